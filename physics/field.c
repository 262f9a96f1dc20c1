#include "physics/field.h"

#include <stdlib.h>

typedef struct field_program {
    ad_program *program;
    bool is_uniform[MODEL_COLUMNS_MAX]; /* the same at all points: across the plane of a planar
                                           motion, say */
} field_program;

struct field {
    scene scene;
    const physics_model *model;
    const nn_mlp *mlp; /* NULL for the manufactured solution */
    int index;         /* of the last window */
    const double *earlier, *starts;
    field_program *programs; /* [windows], made when a point asks for one */
    ad_pool *pool;
    int columns;
    double length, time;
    bool dynamic, pose_only;
    double *points; /* [2][capacity], dimensionless */
    size_t capacity;
    int *windows;   /* [capacity], of each point */
    double *values; /* [columns][capacity], several windows only */
};

const char *field_column_name(const field *f, int column)
{
    return column >= 0 && column < f->columns ? f->model->columns[column].name : "";
}

/* The observables of motion come last, so that columns are numbered alike in every scene. */
static int count_columns(const field *f)
{
    const physics_model *m = f->model;
    int count = 0;
    if (f->pose_only) {
        return m->position_columns + m->rotation_columns;
    }
    while (count < m->column_count && (f->dynamic || !m->columns[count].of_motion)) {
        count++;
    }
    return count;
}

static ad_status build(field *f, int index, ad_error *error)
{
    const double *start = index > 0 ? f->starts + (size_t)index * ROD_WINDOW_NUMBERS : NULL;
    const rod_window window = {index, start};
    ad_tape *tape = ad_tape_create();
    if (!tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
    t = f->dynamic ? t : ad_scalar(tape, 0);
    rod_state state;
    if (f->mlp) {
        ad_value input = rod_network_input(&f->scene, &window, s, t);
        ad_value outputs = nn_mlp_record(f->mlp, input, 0);
        state = f->model->ansatz(&f->scene, &window, outputs, s, t);
    } else {
        state = rod_manufactured(&f->scene, s, t);
    }
    ad_value observed[MODEL_COLUMNS_MAX];
    field_program *made = &f->programs[index];
    f->model->observe(&f->scene, state, s, t, observed);
    for (int i = 0; i < f->columns; i++) {
        made->is_uniform[i] = ad_extent_of(observed[i]) == AD_UNIFORM;
    }
    ad_status status = ad_compile(f->columns, observed, NULL, f->pool, &made->program, error);
    ad_tape_free(tape);
    return status;
}

ad_status field_create(const scene *scene, const nn_mlp *mlp, bool pose_only, ad_pool *pool,
                       field **result, ad_error *error)
{
    *result = NULL;
    field *f = calloc(1, sizeof *f);
    field_program *programs = calloc((size_t)scene->windows, sizeof *programs);
    if (!f || !programs) {
        free(f);
        free(programs);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a field");
    }
    rod_scales scales = rod_scales_of(scene);
    *f = (field){.scene = *scene,
                 .model = model_of(scene),
                 .mlp = mlp,
                 .programs = programs,
                 .pool = pool,
                 .length = scales.length,
                 .time = scales.time,
                 .dynamic = scene_is_dynamic(scene),
                 .pose_only = pose_only};
    f->columns = count_columns(f);
    ad_status status = build(f, 0, error); /* at once: an error should show here */
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
        for (int i = 0; i < f->scene.windows; i++) {
            ad_program_free(f->programs[i].program);
        }
        free(f->programs);
        free(f->points);
        free(f->windows);
        free(f->values);
        free(f);
    }
}

/* Programs hold the states in which windows start as numbers, so those of other numbers go. */
void field_enter(field *f, int index, const double *earlier, const double *starts)
{
    for (int i = 1; i < f->scene.windows; i++) {
        ad_program_free(f->programs[i].program);
        f->programs[i].program = NULL;
    }
    f->index = index;
    f->earlier = earlier;
    f->starts = starts;
}

int field_columns(const field *f)
{
    return f->columns;
}

static ad_status make_room(field *f, size_t points, ad_error *error)
{
    if (points <= f->capacity) {
        return AD_OK;
    }
    double *coordinates = realloc(f->points, 2 * points * sizeof *coordinates);
    f->points = coordinates ? coordinates : f->points;
    int *windows = realloc(f->windows, points * sizeof *windows);
    f->windows = windows ? windows : f->windows;
    double *values = NULL;
    if (f->scene.windows > 1) {
        values = realloc(f->values, (size_t)f->columns * points * sizeof *values);
        f->values = values ? values : f->values;
    }
    if (!coordinates || !windows || (f->scene.windows > 1 && !values)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", points);
    }
    f->capacity = points;
    return AD_OK;
}

/* The points of f->points in window `index`: values [columns][count] in their order. */
static ad_status evaluate_window(field *f, int index, const double *x, size_t count, double *values,
                                 ad_error *error)
{
    ad_status status = f->programs[index].program ? AD_OK : build(f, index, error);
    double *outputs[MODEL_COLUMNS_MAX];
    for (int i = 0; i < f->columns; i++) {
        outputs[i] = values + (size_t)i * count;
    }
    const double *inputs[2] = {f->points, f->points + count};
    bool last = index == f->index;
    size_t parameters = f->mlp ? nn_mlp_parameters(f->mlp) : 0;
    ad_run run = {.points = count,
                  .inputs = inputs,
                  .parameters = last ? x : f->earlier + (size_t)index * parameters,
                  .outputs = outputs};
    if (status == AD_OK) {
        status = ad_execute(f->programs[index].program, &run, error);
    }
    for (int i = 0; i < f->columns && status == AD_OK; i++) {
        for (size_t k = 1; k < count && f->programs[index].is_uniform[i]; k++) {
            outputs[i][k] = outputs[i][0];
        }
    }
    return status;
}

static double dimensionless_time(const field *f, const double *t, size_t i)
{
    return f->dynamic ? t[i] / f->time : 0;
}

/* Gather the points of one window, evaluate, and put the values where they belong. */
static ad_status evaluate_part(field *f, int index, const double *x, size_t points, const double *s,
                               const double *t, double *values, ad_error *error)
{
    size_t count = 0, taken = 0;
    for (size_t i = 0; i < points; i++) {
        count += f->windows[i] == index;
    }
    if (count == 0) {
        return AD_OK;
    }
    for (size_t i = 0; i < points; i++) {
        if (f->windows[i] == index) {
            f->points[taken] = s[i] / f->length;
            f->points[count + taken++] = dimensionless_time(f, t, i);
        }
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

ad_status field_evaluate(field *f, const double *x, size_t points, const double *s, const double *t,
                         double *values, ad_error *error)
{
    ad_status status = make_room(f, points, error);
    if (status != AD_OK) {
        return status;
    }
    if (f->scene.windows == 1 || !f->mlp) {
        for (size_t i = 0; i < points; i++) {
            f->points[i] = s[i] / f->length;
            f->points[points + i] = dimensionless_time(f, t, i);
        }
        return evaluate_window(f, 0, x, points, values, error);
    }
    for (size_t i = 0; i < points; i++) {
        int window = rod_window_at(&f->scene, dimensionless_time(f, t, i));
        f->windows[i] = window < f->index ? window : f->index;
    }
    for (int index = 0; status == AD_OK && index <= f->index; index++) {
        status = evaluate_part(f, index, x, points, s, t, values, error);
    }
    return status;
}
