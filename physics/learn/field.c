#include "physics/learn/field.h"
#include "physics/learn/motion_network.h"
#include "physics/learn/window_state.h"

#include <stdlib.h>

struct field {
    int held; /* of the last coordinates, which are these: */
    double member[SCENE_PARAMETERS_MAX];
    const physics_model *model;
    const nn_mlp *mlp; /* NULL for the manufactured solution */
    int index;         /* of the last window */
    const double *earlier, *starts;
    double load_factor;
    ad_program *programs[2]; /* of the first window, of a later one; made when a point asks */
    motion_network *motion;  /* of a model of such, in place of the programs */
    ad_pool *pool;
    int columns;
    double *points; /* [coordinates][capacity], dimensionless */
    size_t capacity;
    int *windows;   /* [capacity], of each point */
    double *values; /* [columns][capacity], several windows only */
};

const char *field_column_name(const field *f, int column)
{
    return column >= 0 && column < f->columns ? f->model->columns[column].name : "";
}

static ad_status build(field *f, int window, ad_program **made, ad_error *error)
{
    const physics_model *m = f->model;
    ad_tape *tape = ad_tape_create();
    ad_value fields[MODEL_FIELDS_MAX], observed[MODEL_COLUMNS_MAX];
    domain_place at = model_record(m, window, f->mlp, tape, fields);
    m->call.observe(m, &at, fields, observed);
    ad_status status = ad_compile(f->columns, observed, NULL, f->pool, made, error);
    ad_tape_free(tape);
    return status;
}

ad_status field_create(const physics_model *m, const nn_mlp *mlp, bool pose_only, ad_pool *pool,
                       field **result, ad_error *error)
{
    *result = NULL;
    field *f = calloc(1, sizeof *f);
    if (!f) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a field");
    }
    *f = (field){.model = m, .mlp = mlp, .pool = pool, .load_factor = 1};
    f->columns = pose_only ? m->position_columns + m->rotation_columns : model_columns(m);
    ad_status status = m->motion && mlp /* at once: an error should show here */
                           ? motion_network_create(m, mlp, pool, &f->motion, error)
                           : build(f, 0, &f->programs[0], error);
    if (status != AD_OK) {
        field_free(f);
        return status;
    }
    *result = f;
    return AD_OK;
}

void field_free(field *f)
{
    if (f) {
        ad_program_free(f->programs[0]);
        ad_program_free(f->programs[1]);
        motion_network_free(f->motion);
        free(f->points);
        free(f->windows);
        free(f->values);
        free(f);
    }
}

void field_enter(field *f, int index, const double *earlier, const double *starts)
{
    f->index = index;
    f->earlier = earlier;
    f->starts = starts;
}

void field_load(field *f, double factor)
{
    f->load_factor = factor;
}

void field_member(field *f, const double *values)
{
    f->held = scene_known_count(&f->model->scene);
    for (int i = 0; i < f->held; i++) {
        f->member[i] = values[i];
    }
}

int field_columns(const field *f)
{
    return f->columns;
}

static bool has_windows(const field *f)
{
    return f->mlp && f->model->domain.windows > 1;
}

static ad_status make_room(field *f, size_t points, ad_error *error)
{
    if (points <= f->capacity) {
        return AD_OK;
    }
    size_t coordinates = (size_t)f->model->domain.count;
    double *room = realloc(f->points, coordinates * points * sizeof *room);
    f->points = room ? room : f->points;
    int *windows = realloc(f->windows, points * sizeof *windows);
    f->windows = windows ? windows : f->windows;
    double *values = NULL;
    if (has_windows(f)) {
        values = realloc(f->values, (size_t)f->columns * points * sizeof *values);
        f->values = values ? values : f->values;
    }
    if (!room || !windows || (has_windows(f) && !values)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", points);
    }
    f->capacity = points;
    return AD_OK;
}

/* The points of f->points in window `index`: values [columns][count] in their order. */
static ad_status evaluate_window(field *f, int index, const double *x, size_t count, double *values,
                                 ad_error *error)
{
    const domain *d = &f->model->domain;
    const bool last = index == f->index;
    const size_t parameters = f->mlp ? nn_mlp_parameters(f->mlp) : 0;
    const double *of_window = last ? x : f->earlier + (size_t)index * parameters;
    const double *start =
        index > 0 ? f->starts + (size_t)index * window_state_numbers(f->model) : NULL;
    if (f->motion) {
        return motion_network_observe(f->motion, index, start, of_window, count, f->points,
                                      f->points + count, f->columns, values, error);
    }
    ad_program **made = &f->programs[index > 0];
    ad_status status = *made ? AD_OK : build(f, index, made, error);
    double *outputs[MODEL_COLUMNS_MAX];
    const double *inputs[DOMAIN_COORDINATES_MAX], *uniforms[DOMAIN_UNIFORMS_MAX];
    domain_uniforms kinds = model_uniforms(f->model, index);
    const domain_setting setting = domain_setting_of(d, index, start, f->load_factor);
    domain_list_uniforms(&kinds, &setting, uniforms);
    for (int i = 0; i < f->columns; i++) {
        outputs[i] = values + (size_t)i * count;
    }
    for (int i = 0; i < d->count; i++) {
        inputs[i] = f->points + (size_t)i * count;
    }
    const ad_run run = {.points = count,
                        .inputs = inputs,
                        .uniforms = uniforms,
                        .parameters = of_window,
                        .outputs = outputs,
                        .everywhere = true};
    return status == AD_OK ? ad_execute(*made, &run, error) : status;
}

/* Gather the points of one window, dimensionless, evaluate, and put the values where they belong.
 */
static ad_status evaluate_part(field *f, int index, const double *x, size_t points,
                               const double *const *at, double *values, ad_error *error)
{
    const domain *d = &f->model->domain;
    size_t count = 0;
    for (size_t i = 0; i < points; i++) {
        count += f->windows[i] == index;
    }
    if (count == 0) {
        return AD_OK;
    }
    for (int k = 0; k < d->count; k++) {
        double *to = f->points + (size_t)k * count;
        for (size_t i = 0; i < points; i++) {
            if (f->windows[i] == index) {
                double x = k < d->count - f->held ? at[k][i] : f->member[k - (d->count - f->held)];
                *to++ = x / d->coordinates[k].scale;
            }
        }
    }
    if (count == points) {
        return evaluate_window(f, index, x, count, values, error);
    }
    ad_status status = evaluate_window(f, index, x, count, f->values, error);
    for (int c = 0; status == AD_OK && c < f->columns; c++) {
        const double *from = f->values + (size_t)c * count;
        for (size_t i = 0; i < points; i++) {
            if (f->windows[i] == index) {
                values[(size_t)c * points + i] = *from++;
            }
        }
    }
    return status;
}

ad_status field_evaluate(field *f, const double *x, size_t points, const double *const *at,
                         double *values, ad_error *error)
{
    const domain *d = &f->model->domain;
    ad_status status = make_room(f, points, error);
    for (size_t i = 0; status == AD_OK && i < points; i++) {
        int window = has_windows(f)
                         ? domain_window_at(d, at[d->time][i] / d->coordinates[d->time].scale)
                         : 0;
        f->windows[i] = window < f->index ? window : f->index;
    }
    for (int index = 0; status == AD_OK && index <= f->index; index++) {
        status = evaluate_part(f, index, x, points, at, values, error);
    }
    return status;
}
