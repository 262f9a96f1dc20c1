#include "physics/evaluator.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What is asked for: a column of the model, differentiated. */
typedef struct evaluator_column {
    char name[EVALUATOR_NAME_MAX], unit[32];
    int column;     /* of the model */
    int by_s, by_t; /* orders */
    double to_si;   /* of the derivatives, which are by dimensionless s and t */
} evaluator_column;

struct evaluator {
    bool dynamic;
    int windows, columns;
    double length, time;
    evaluator_column column[EVALUATOR_COLUMNS_MAX];
    domain domain;
    ad_pool *pool;
    ad_program *programs[2]; /* of the first window, of all later ones */
    domain_uniforms kinds[2];
    bool is_uniform[2][EVALUATOR_COLUMNS_MAX]; /* the same at all points */
    double *parameters;                        /* [windows][count], combined */
    size_t count;                              /* of parameters of a window */
    double *starts;                            /* [windows][numbers] */
    size_t numbers;
};

/* ---- names --------------------------------------------------------------------------------- */

static int find_column(const scene_physics *model, const char *name, size_t length)
{
    for (int i = 0; i < model->column_count; i++) {
        if (strlen(model->columns[i].name) == length &&
            strncmp(model->columns[i].name, name, length) == 0) {
            return i;
        }
    }
    return -1;
}

/* "m s^-2": the unit of a derivative. */
static void write_unit(const evaluator_column *c, const char *unit, char text[32])
{
    char by_s[16] = "", by_t[16] = "";
    bool per_length = c->by_s > 0, per_time = c->by_t > 0;
    if (per_length) {
        snprintf(by_s, sizeof by_s, "m^-%d", c->by_s);
    }
    if (per_time) {
        snprintf(by_t, sizeof by_t, "s^-%d", c->by_t);
    }
    bool plain = *unit == '\0' && (per_length || per_time);
    snprintf(text, 32, "%s%s%s%s%s", plain ? "" : unit, !plain && per_length ? " " : "", by_s,
             per_time && (!plain || per_length) ? " " : "", by_t);
}

static ad_status add_column(evaluator *e, const scene_physics *model, int column, int by_s,
                            int by_t, ad_error *error)
{
    if (e->columns == EVALUATOR_COLUMNS_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT, "more than %d columns are asked for",
                       EVALUATOR_COLUMNS_MAX);
    }
    if (model->columns[column].of_motion && !e->dynamic) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%s is of a scene in motion, and this one is at rest",
                       model->columns[column].name);
    }
    evaluator_column *c = &e->column[e->columns++];
    *c = (evaluator_column){.column = column, .by_s = by_s, .by_t = by_t, .to_si = 1};
    int length = snprintf(c->name, sizeof c->name, "%s%s", model->columns[column].name,
                          by_s + by_t ? "_" : "");
    for (int i = 0; i < by_s + by_t && length + 1 < EVALUATOR_NAME_MAX; i++) {
        c->name[length++] = i < by_s ? 's' : 't';
        c->name[length] = '\0';
        c->to_si /= i < by_s ? e->length : e->time;
    }
    write_unit(c, model->columns[column].unit, c->unit);
    return AD_OK;
}

static ad_status refuse_name(const scene_physics *model, const char *name, size_t length,
                             ad_error *error)
{
    char known[300] = "";
    size_t at = 0;
    for (int i = 0; i < model->column_count && at < sizeof known; i++) {
        at += (size_t)snprintf(known + at, sizeof known - at, "%s%s", i ? ", " : "",
                               model->columns[i].name);
    }
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "%.*s is no column; allowed: %s, and behind an underscore up to %d letters s "
                   "and t, as in %s_s",
                   (int)(length < 40 ? length : 40), name, known, EVALUATOR_ORDER_MAX,
                   model->columns[0].name);
}

/* One name of `length` characters: the longest part of it that is a column or a group of columns is
 * one, what follows its underscore are derivatives. */
static ad_status add_name(evaluator *e, const scene_physics *model, const char *name, size_t length,
                          ad_error *error)
{
    size_t stem = length;
    int by_s = 0, by_t = 0, first = find_column(model, name, length), count = 1;
    if (first < 0) {
        for (stem = 0; stem < length && name[stem] != '_'; stem++) {
        }
        for (size_t i = stem + 1; i < length; i++) {
            by_s += name[i] == 's';
            by_t += name[i] == 't';
        }
        bool letters = stem == length || (size_t)(by_s + by_t) == length - stem - 1;
        bool some = stem == length || by_s + by_t > 0;
        first = letters && some && by_s + by_t <= EVALUATOR_ORDER_MAX
                    ? find_column(model, name, stem)
                    : -1;
        if (letters && some && first < 0 && stem == 1 && model->rotation_columns > 1 &&
            (name[0] == 'r' || name[0] == 'q')) {
            first = name[0] == 'r' ? 0 : model->position_columns;
            count = name[0] == 'r' ? model->position_columns : model->rotation_columns;
        }
    }
    if (first < 0 || by_s + by_t > EVALUATOR_ORDER_MAX) {
        return refuse_name(model, name, length, error);
    }
    if (by_t > 0 && !e->dynamic) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%.*s is a derivative by time, and this scene is at rest", (int)length,
                       name);
    }
    ad_status status = AD_OK;
    for (int i = 0; i < count && status == AD_OK; i++) {
        status = add_column(e, model, first + i, by_s, by_t, error);
    }
    return status;
}

static ad_status read_names(evaluator *e, const scene_physics *model, const char *names,
                            ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; !names && status == AD_OK && i < model->column_count; i++) {
        if (e->dynamic || !model->columns[i].of_motion) {
            status = add_column(e, model, i, 0, 0, error);
        }
    }
    while (names && *names && status == AD_OK) {
        size_t length = strcspn(names, " ,");
        if (length > 0) {
            status = add_name(e, model, names, length, error);
        }
        names += length + (names[length] != '\0');
    }
    return status == AD_OK && e->columns == 0
               ? ad_fail(error, AD_BAD_ARGUMENT, "no column is asked for")
               : status;
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_value differentiated(const evaluator_column *c, ad_value y, ad_value s, ad_value t)
{
    y = c->by_s ? ad_derivative(y, s, c->by_s) : y;
    y = c->by_t ? ad_derivative(y, t, c->by_t) : y;
    return ad_scale(y, c->to_si);
}

/* The program of the first window or of the later ones. */
static ad_status build(evaluator *e, const evaluator_model *model, int later, ad_error *error)
{
    const physics_model *physics = model->physics;
    ad_tape *tape = ad_tape_create();
    if (!tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    ad_value fields[MODEL_FIELDS_MAX], observed[MODEL_COLUMNS_MAX], values[EVALUATOR_COLUMNS_MAX];
    e->kinds[later] = model_uniforms(physics, later);
    domain_place at = domain_record(&e->domain, &e->kinds[later], tape);
    ad_value outputs = nn_mlp_record_combined(model->mlp, domain_network_input(&e->domain, &at), 0);
    physics->ansatz(physics, &at, outputs, fields);
    physics->observe(physics, &at, fields, observed);
    for (int i = 0; i < e->columns; i++) {
        values[i] = differentiated(&e->column[i], observed[e->column[i].column], at.x[0], at.x[1]);
        e->is_uniform[later][i] = ad_extent_of(values[i]) == AD_UNIFORM;
    }
    ad_status status = ad_compile(e->columns, values, NULL, e->pool, &e->programs[later], error);
    ad_tape_free(tape);
    return status;
}

enum { CHUNK = 128 }; /* points of one window at a time, on the stack */

/* `count` points of one window; column c goes to values + c * stride. */
static ad_status evaluate_run(evaluator *e, int index, size_t count, const double *s,
                              const double *t, double *values, size_t stride, ad_error *error)
{
    double *outputs[EVALUATOR_COLUMNS_MAX];
    const double *inputs[2] = {s, t}, *uniforms[DOMAIN_UNIFORMS_MAX];
    double begin = domain_window_time(&e->domain, index);
    const domain_setting setting = {{begin, domain_window_time(&e->domain, index + 1) - begin},
                                    e->starts + (size_t)index * e->numbers,
                                    1};
    int later = index > 0;
    domain_list_uniforms(&e->kinds[later], &setting, uniforms);
    for (int c = 0; c < e->columns; c++) {
        outputs[c] = values + (size_t)c * stride;
    }
    const ad_run run = {.points = count,
                        .inputs = inputs,
                        .uniforms = uniforms,
                        .parameters = e->parameters + (size_t)index * e->count,
                        .outputs = outputs};
    ad_status status = ad_execute(e->programs[later], &run, error);
    for (int c = 0; c < e->columns && status == AD_OK; c++) {
        for (size_t k = 1; k < count && e->is_uniform[later][c]; k++) {
            outputs[c][k] = outputs[c][0];
        }
    }
    return status;
}

/* What a program allocates when it first runs, it allocates here. */
static ad_status warm_up(evaluator *e, ad_error *error)
{
    double zero[CHUNK] = {0}, *values = malloc(CHUNK * (size_t)e->columns * sizeof *values);
    ad_status status = values ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (int i = 0; i < 2 && i < e->windows && status == AD_OK; i++) {
        status = evaluate_run(e, i, CHUNK, zero, zero, values, CHUNK, error);
    }
    free(values);
    return status;
}

static ad_status make(evaluator *e, const evaluator_model *model, const char *names,
                      ad_error *error)
{
    size_t windows = (size_t)model->windows, numbers = nn_mlp_parameters(model->mlp);
    ad_status status = read_names(e, scene_physics_of(&model->physics->scene), names, error);
    if (status != AD_OK) {
        return status;
    }
    e->pool = ad_pool_create(1);
    e->parameters = calloc(windows * e->count, sizeof *e->parameters);
    e->starts = calloc(windows * e->numbers + 1, sizeof *e->starts);
    if (!e->pool || !e->parameters || !e->starts) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the evaluation of a network");
    }
    if (windows > 1) {
        memcpy(e->starts, model->starts, windows * e->numbers * sizeof *e->starts);
    }
    for (size_t i = 0; i < windows; i++) {
        nn_mlp_combine(model->mlp, model->parameters + i * numbers, e->parameters + i * e->count);
    }
    for (int i = 0; i < 2 && i < e->windows && status == AD_OK; i++) {
        status = build(e, model, i, error);
    }
    return status == AD_OK ? warm_up(e, error) : status;
}

ad_status evaluator_create(const evaluator_model *model, const char *names, evaluator **result,
                           ad_error *error)
{
    const domain *d = &model->physics->domain;
    evaluator *e = calloc(1, sizeof *e);
    *result = NULL;
    if (!e) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the evaluation of a network");
    }
    e->domain = *d;
    e->dynamic = d->time >= 0;
    e->windows = model->windows;
    e->length = d->coordinates[0].scale;
    e->time = e->dynamic ? d->coordinates[d->time].scale : 1;
    e->numbers = relay_numbers(model->physics);
    e->count = nn_mlp_combined_parameters(model->mlp);
    ad_status status = make(e, model, names, error);
    if (status != AD_OK) {
        evaluator_free(e);
        return status;
    }
    *result = e;
    return AD_OK;
}

void evaluator_free(evaluator *e)
{
    if (!e) {
        return;
    }
    ad_program_free(e->programs[0]);
    ad_program_free(e->programs[1]);
    free(e->parameters);
    free(e->starts);
    ad_pool_free(e->pool);
    free(e);
}

int evaluator_columns(const evaluator *e)
{
    return e->columns;
}

const char *evaluator_column_name(const evaluator *e, int column)
{
    return column >= 0 && column < e->columns ? e->column[column].name : "";
}

const char *evaluator_column_unit(const evaluator *e, int column)
{
    return column >= 0 && column < e->columns ? e->column[column].unit : "";
}

/* ---- evaluation ---------------------------------------------------------------------------- */

static int window_at(const evaluator *e, double t)
{
    int window = domain_window_at(&e->domain, t);
    return window < e->windows ? window : e->windows - 1;
}

/* Points that follow one another in the same window are computed at once. */
ad_status evaluator_evaluate(evaluator *e, size_t points, const double *s, const double *t,
                             double *values, ad_error *error)
{
    double at_s[CHUNK], at_t[CHUNK];
    ad_status status = AD_OK;
    for (size_t begin = 0; begin < points && status == AD_OK;) {
        size_t count = 0;
        int index = 0;
        while (count < CHUNK && begin + count < points) {
            double now = e->dynamic ? t[begin + count] / e->time : 0;
            int window = e->windows > 1 ? window_at(e, now) : 0;
            if (count > 0 && window != index) {
                break;
            }
            index = window;
            at_s[count] = s[begin + count] / e->length;
            at_t[count++] = now;
        }
        status = evaluate_run(e, index, count, at_s, at_t, values + begin, points, error);
        begin += count;
    }
    return status;
}
