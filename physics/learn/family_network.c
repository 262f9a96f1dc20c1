#include "physics/learn/family_fit.h"

#include <stdlib.h>

struct family_network {
    const family *f;
    ad_program *program;
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
    family_network *network = calloc(1, sizeof *network);
    ad_status status = tape && network ? family_model(f, &none, true, &m, error)
                                       : ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    if (status == AD_OK) {
        network->f = f;
        model_record(m, 0, mlp, tape, fields);
        status = ad_compile(1, &fields[FAMILY_CURVATURE], NULL, pool, &network->program, error);
    }
    model_free(m);
    ad_tape_free(tape);
    if (status != AD_OK) {
        family_network_free(network);
        network = NULL;
    }
    *result = network;
    return status;
}

void family_network_free(family_network *network)
{
    if (network) {
        ad_program_free(network->program);
        free(network->x);
        free(network->u);
        free(network);
    }
}

static bool make_room(family_network *network, size_t members)
{
    if (members > network->room) {
        free(network->x);
        free(network->u);
        network->x =
            malloc((size_t)network->f->open.parameter_count * members * sizeof *network->x);
        network->u = malloc((size_t)network->f->rows * members * sizeof *network->u);
        network->room = network->x && network->u ? members : 0;
    }
    return network->room > 0;
}

ad_status family_network_run(family_network *network, const double *weights, size_t members,
                             const double *parameters, double *curvature, ad_error *error)
{
    const family *f = network->f;
    const size_t count = (size_t)f->open.parameter_count, nodes = f->nodes;
    const size_t width = (size_t)f->width;
    const double *inputs[SCENE_PARAMETERS_MAX];
    if (!make_room(network, members)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", members);
    }
    for (size_t i = 0; i < count; i++) {
        inputs[i] = network->x + i * members;
        for (size_t k = 0; k < members; k++) {
            network->x[i * members + k] =
                scene_parameter_fraction(&f->open.parameters[i], parameters[k * count + i]);
        }
    }
    const ad_run run = {.points = members,
                        .inputs = inputs,
                        .parameters = weights,
                        .outputs = &network->u,
                        .everywhere = true};
    ad_status status = ad_execute(network->program, &run, error);
    for (size_t k = 0; k < members && status == AD_OK; k++) {
        for (size_t i = 0; i < nodes; i++) {
            for (size_t c = 0; c < width; c++) {
                curvature[width * (k * nodes + i) + c] =
                    network->u[(c * nodes + i) * members + k] / f->length;
            }
        }
    }
    return status;
}
