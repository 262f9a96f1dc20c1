#include "physics/learn/family.h"

#include "physics/learn/family_fit.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* e of the loss over the spread of the members: about what a network reaches in its first tenth of
 * training. */
static const double SOFTNESS = 0.005;

ad_status family_create(const scene *open, const groups_settings *settings, size_t nodes,
                        const double *places, family **result, ad_error *error)
{
    *result = NULL;
    family *f = calloc(1, sizeof *f);
    if (!f) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    }
    const int width = 3 + open->tube_count, rows = width * (int)nodes;
    *f = (family){.open = *open,
                  .nodes = nodes,
                  .length = scene_length(open),
                  .width = width,
                  .rows = rows,
                  .modes = rows < FAMILY_MODES_MAX ? rows : FAMILY_MODES_MAX,
                  .spread = NAN,
                  .missed = NAN};
    ad_status status = groups_find(&f->open, settings, &f->groups, error);
    if (status == AD_OK) {
        f->inputs = groups_count(f->groups);
        size_t rows = (size_t)f->rows, modes = (size_t)f->modes;
        AD_TAKE(f, places, nodes);
        AD_TAKE(f, affine, rows * ((size_t)f->inputs + 1));
        AD_TAKE(f, shapes, rows * modes);
        AD_TAKE(f, project, rows * modes);
        AD_TAKE(f, scale, modes);
        if (f->memory.is_short) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
        }
    }
    if (status != AD_OK) {
        family_free(f);
        return status;
    }
    for (size_t i = 0; i < nodes; i++) {
        f->places[i] = places[i] / f->length;
    }
    *result = f;
    return AD_OK;
}

void family_free(family *f)
{
    if (f) {
        groups_free(f->groups);
        ad_memory_free(&f->memory);
        free(f);
    }
}

void family_arrays(family *f, family_array arrays[FAMILY_ARRAYS])
{
    size_t rows = (size_t)f->rows, modes = (size_t)f->modes;
    arrays[0] = (family_array){"affine", f->affine, rows, (size_t)f->inputs + 1};
    arrays[1] = (family_array){"modes", f->shapes, rows, modes};
    arrays[2] = (family_array){"project", f->project, modes, rows};
    arrays[3] = (family_array){"scale", f->scale, 1, modes};
}

int family_width(const family *f)
{
    return f->width;
}

size_t family_nodes(const family *f)
{
    return f->nodes;
}

int family_modes(const family *f)
{
    return f->modes;
}

const groups *family_groups(const family *f)
{
    return f->groups;
}

double family_spread(const family *f)
{
    return f->spread;
}

double family_missed(const family *f)
{
    return f->missed;
}

void family_parameters(const family *f, size_t members, const double *x, double *parameters)
{
    const size_t count = (size_t)f->open.parameter_count;
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < members; k++) {
            parameters[k * count + i] =
                scene_parameter_at(&f->open.parameters[i], x[i * members + k]);
        }
    }
}

/* ---- on a tape ----------------------------------------------------------------------------- */

/* Parameters in SI units from coordinates, as scene_parameter_at. */
static ad_value record_parameters(const family *f, ad_tape *tape, const ad_value *x)
{
    ad_value values[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < f->open.parameter_count; i++) {
        const scene_parameter *p = &f->open.parameters[i];
        values[i] = p->scale == SCENE_LOG
                        ? ad_scale(ad_exp(ad_scale(x[i], log(p->high / p->low))), p->low)
                        : ad_add(ad_scale(x[i], p->high - p->low), ad_scalar(tape, p->low));
    }
    return ad_stack(f->open.parameter_count, values);
}

ad_value family_inputs(const family *f, ad_tape *tape, const ad_value *x, groups_turn *turn)
{
    return groups_record(f->groups, record_parameters(f, tape, x), turn);
}

void family_turn_matrix(const groups_turn *turn, ad_tape *tape, ad_value matrix[3][3])
{
    for (int k = 0; k < 3; k++) {
        ad_value axis[3];
        for (int i = 0; i < 3; i++) {
            axis[i] = ad_scalar(tape, i == k);
        }
        groups_restore(turn, axis);
        for (int i = 0; i < 3; i++) {
            matrix[i][k] = axis[i];
        }
    }
}

static const family *family_of(const physics_model *m)
{
    return m->own;
}

static ad_value input_of_family(const physics_model *m, const domain_place *at)
{
    groups_turn turn;
    return family_inputs(family_of(m), at->tape, at->x, &turn);
}

/* 1 above x. */
static ad_value with_one(ad_value x)
{
    return ad_stack(2, (ad_value[]){ad_scalar(x.tape, 1), x});
}

static void ansatz_of_family(const physics_model *m, const domain_place *at, ad_value outputs,
                             ad_value *fields)
{
    const family *f = family_of(m);
    const int nodes = (int)f->nodes;
    groups_turn turn;
    ad_value x = with_one(family_inputs(f, at->tape, at->x, &turn)), u[3 + SCENE_TUBES_MAX];
    ad_value affine = ad_constant(at->tape, f->rows * (f->inputs + 1), f->affine);
    ad_value shapes = ad_constant(at->tape, f->rows * f->modes, f->shapes);
    ad_value c = ad_mul(outputs, ad_constant(at->tape, f->modes, f->scale));
    ad_value all = ad_add(ad_matvec(affine, x), ad_matvec(shapes, c));
    for (int i = 0; i < f->width; i++) {
        u[i] = ad_slice(all, i * nodes, nodes);
    }
    groups_restore(&turn, u); /* of the curvature; torsions are of no direction */
    fields[FAMILY_COEFFICIENTS] = c;
    fields[FAMILY_CURVATURE] = ad_stack(f->width, u);
}

/* Coefficients of what a target has beyond the affine function. */
static ad_value target_coefficients(const family *f, const domain_place *at)
{
    const int nodes = (int)f->nodes;
    groups_turn turn;
    ad_value matrix[3][3], u[3 + SCENE_TUBES_MAX];
    ad_value x = with_one(family_inputs(f, at->tape, at->x, &turn));
    ad_value affine = ad_constant(at->tape, f->rows * (f->inputs + 1), f->affine);
    ad_value project = ad_constant(at->tape, f->modes * f->rows, f->project);
    family_turn_matrix(&turn, at->tape, matrix);
    for (int k = 0; k < 3; k++) {
        u[k] = ad_zeros(at->tape, nodes);
        for (int i = 0; i < 3; i++) {
            u[k] = ad_add(u[k], ad_mul(matrix[i][k], ad_slice(at->data, i * nodes, nodes)));
        }
    }
    for (int k = 3; k < f->width; k++) {
        u[k] = ad_slice(at->data, k * nodes, nodes);
    }
    return ad_matvec(project, ad_sub(ad_stack(f->width, u), ad_matvec(affine, x)));
}

static ad_value difference(const void *context, const domain_place *at, const ad_value *fields)
{
    return ad_sub(fields[FAMILY_COEFFICIENTS], target_coefficients(context, at));
}

/* d (|d|^2 + e^2)^(1/2) + e)^(-1/2), whose square is (|d|^2 + e^2)^(1/2) - e. */
static ad_value soft_difference(const void *context, const domain_place *at, const ad_value *fields)
{
    const double spread = family_spread(context);
    const double softness = SOFTNESS * (spread > 0 ? spread : 1);
    ad_value d = difference(context, at, fields), e = ad_scalar(at->tape, softness);
    ad_value size = ad_sqrt(ad_add(ad_dot(d, d), ad_square(e)));
    return ad_mul(d, ad_reciprocal(ad_sqrt(ad_add(size, e))));
}

ad_status family_model(const family *f, const model_source *source, bool squares,
                       physics_model **result, ad_error *error)
{
    physics_model *m = *result = model_create();
    if (!m) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a model");
    }
    for (int i = 0; i < f->open.parameter_count; i++) {
        model_add_coordinate(m, f->open.parameters[i].name, "", 0, 1, 1);
    }
    m->own = f;
    m->inputs = f->inputs;
    m->outputs = f->modes;
    m->field_count = m->unknowns = FAMILY_FIELDS;
    m->field_rows[FAMILY_COEFFICIENTS] = f->modes;
    m->field_rows[FAMILY_CURVATURE] = f->rows;
    snprintf(m->symbols[FAMILY_COEFFICIENTS], sizeof m->symbols[0], "c");
    snprintf(m->symbols[FAMILY_CURVATURE], sizeof m->symbols[0], "u");
    m->call = (model_functions){.ansatz = ansatz_of_family, .input = input_of_family};
    m->separate = squares ? f->scale : NULL;
    int members = model_add_interior(m, "members");
    m->sets[members].source = *source;
    model_add_term(m, "members", members, 1, squares ? difference : soft_difference, f);
    return AD_OK;
}
