#include "physics/family_fit.h"

#include <stdlib.h>

struct family_network {
    const family *f;
    ad_program *program;
    bool is_same;  /* for all members: the program gives it once */
    size_t room;   /* members */
    double *x, *u; /* [parameters][room], [rows][room] */
};

ad_status family_network_create(const family *f, const nn_mlp *mlp, ad_pool *pool,
                                family_network **result, ad_error *error)
{
    const model_source none = {.rows = 0};
    physics_model *m = NULL;
    ad_value fields[MODEL_FIELDS_MAX];
    ad_tape *tape = ad_tape_create();
    family_network *x = calloc(1, sizeof *x);
    ad_status status = tape && x ? family_model(f, &none, true, &m, error)
                                 : ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    if (status == AD_OK) {
        x->f = f;
        model_record(m, 0, mlp, tape, fields);
        x->is_same = ad_extent_of(fields[FAMILY_CURVATURE]) == AD_UNIFORM;
        status = ad_compile(1, &fields[FAMILY_CURVATURE], NULL, pool, &x->program, error);
    }
    model_free(m);
    ad_tape_free(tape);
    if (status != AD_OK) {
        family_network_free(x);
        x = NULL;
    }
    *result = x;
    return status;
}

void family_network_free(family_network *x)
{
    if (x) {
        ad_program_free(x->program);
        free(x->x);
        free(x->u);
        free(x);
    }
}

static bool make_room(family_network *x, size_t members)
{
    if (members > x->room) {
        free(x->x);
        free(x->u);
        x->x = malloc((size_t)x->f->open.parameter_count * members * sizeof *x->x);
        x->u = malloc((size_t)x->f->rows * members * sizeof *x->u);
        x->room = x->x && x->u ? members : 0;
    }
    return x->room > 0;
}

ad_status family_network_run(family_network *x, const double *weights, size_t members,
                             const double *parameters, double *curvature, ad_error *error)
{
    const family *f = x->f;
    const size_t count = (size_t)f->open.parameter_count, nodes = f->nodes;
    const double *inputs[SCENE_PARAMETERS_MAX];
    if (!make_room(x, members)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", members);
    }
    for (size_t i = 0; i < count; i++) {
        inputs[i] = x->x + i * members;
        for (size_t k = 0; k < members; k++) {
            x->x[i * members + k] =
                scene_parameter_fraction(&f->open.parameters[i], parameters[k * count + i]);
        }
    }
    ad_run run = {.points = members, .inputs = inputs, .parameters = weights, .outputs = &x->u};
    ad_status status = ad_execute(x->program, &run, error);
    const size_t stride = x->is_same ? 1 : members;
    for (size_t k = 0; k < members && status == AD_OK; k++) {
        for (size_t i = 0; i < nodes; i++) {
            for (size_t c = 0; c < 3; c++) {
                curvature[3 * (k * nodes + i) + c] =
                    x->u[(c * nodes + i) * stride + (x->is_same ? 0 : k)] / f->length;
            }
        }
    }
    return status;
}
