#include "physics/learn/evaluator_table.h"

#include "autodiff/host.h"
#include "autodiff/memory.h"
#include "physics/learn/window_state.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What is asked for: a column of the model, differentiated. */
typedef struct evaluator_column {
    char name[EVALUATOR_NAME_MAX], unit[128];
    int column;                         /* of the model */
    int orders[DOMAIN_COORDINATES_MAX]; /* of differentiation */
    double to_si;                       /* of the derivatives, which are by dimensionless s and t */
} evaluator_column;

struct evaluator {
    bool dynamic;
    int windows, columns;
    int places; /* coordinates that are not parameters of a family; they come first */
    evaluator_column column[EVALUATOR_COLUMNS_MAX];
    domain domain;
    ad_pool *pool;
    ad_program *programs[2]; /* of the first window, of all later ones */
    domain_uniforms kinds[2];
    double *parameters;                   /* [windows][count], combined; or a table */
    size_t count;                         /* of parameters of a window */
    int tabled, table[MODEL_COLUMNS_MAX]; /* columns of the model that it has */
    double *starts;                       /* [windows][numbers] */
    size_t numbers;
};

/* ---- names --------------------------------------------------------------------------------- */

static int find_column(const physics_model *model, const char *name, size_t length)
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
static void write_unit(const evaluator *e, evaluator_column *c, const char *unit)
{
    int used = 0, length = 0;
    bool differentiated = false;
    for (int i = 0; i < e->domain.count; i++) {
        differentiated = differentiated || c->orders[i] > 0;
    }
    if (*unit || !differentiated) {
        length = snprintf(c->unit, sizeof c->unit, "%s", unit);
        used = *unit != '\0';
    }
    for (int i = 0; i < e->domain.count && length < (int)sizeof c->unit; i++) {
        if (c->orders[i] > 0 && *e->domain.coordinates[i].unit) {
            length += snprintf(c->unit + length, sizeof c->unit - (size_t)length, "%s%s^-%d",
                               used++ ? " " : "", e->domain.coordinates[i].unit, c->orders[i]);
        }
    }
}

static ad_status add_column(evaluator *e, const physics_model *model, int column, const int *orders,
                            ad_error *error)
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
    *c = (evaluator_column){.column = column, .to_si = 1};
    int length = snprintf(c->name, sizeof c->name, "%s", model->columns[column].name);
    for (int i = 0, first = 1; i < e->domain.count; i++) {
        const domain_coordinate by = e->domain.coordinates[i];
        c->orders[i] = orders[i];
        for (int k = 0; k < orders[i]; k++, first = 0) {
            const bool apart = first || by.name[1] != '\0'; /* s and t stand together */
            if (length < EVALUATOR_NAME_MAX) {
                length += snprintf(c->name + length, sizeof c->name - (size_t)length, "%s%s",
                                   apart ? "_" : "", by.name);
            }
            c->to_si /= by.scale;
        }
    }
    write_unit(e, c, model->columns[column].unit);
    return AD_OK;
}

static ad_status refuse_name(const physics_model *model, const char *name, size_t length,
                             ad_error *error)
{
    char known[300] = "", by[100] = "";
    size_t at = 0;
    for (int i = 0; i < model->column_count && at < sizeof known; i++) {
        at += (size_t)snprintf(known + at, sizeof known - at, "%s%s", i ? ", " : "",
                               model->columns[i].name);
    }
    at = 0;
    for (int i = 0; i < model->domain.count && at < sizeof by; i++) {
        at += (size_t)snprintf(by + at, sizeof by - at, "%s%s", i ? ", " : "",
                               model->domain.coordinates[i].name);
    }
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "%.*s is no column; allowed: %s, and behind an underscore what it is "
                   "differentiated by, %d times at most, of %s: as in %s_%s",
                   (int)(length < 40 ? length : 40), name, known, EVALUATOR_ORDER_MAX, by,
                   model->columns[0].name, model->domain.coordinates[0].name);
}

/* One name of `length` characters: the longest part of it that is a column or a group of columns is
 * one, what follows its underscore are derivatives. */
static ad_status add_name(evaluator *e, const physics_model *model, const char *name, size_t length,
                          ad_error *error)
{
    int orders[DOMAIN_COORDINATES_MAX] = {0}, first = find_column(model, name, length), count = 1;
    if (first < 0) {
        const char *underscore = memchr(name, '_', length);
        size_t stem = underscore ? (size_t)(underscore - name) : length;
        first = find_column(model, name, stem);
        if (first < 0 && stem == 1 && model->rotation_columns > 1 &&
            (name[0] == 'r' || name[0] == 'q')) {
            first = name[0] == 'r' ? 0 : model->position_columns;
            count = name[0] == 'r' ? model->position_columns : model->rotation_columns;
        }
        if (underscore && first >= 0 && !e->dynamic && e->domain.count == 1 &&
            memchr(underscore, 't', length - stem)) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "%.*s is a derivative by time, and this scene is at rest", (int)length,
                           name);
        }
        if (underscore && !domain_read_orders(&e->domain, underscore + 1, length - stem - 1,
                                              EVALUATOR_ORDER_MAX, orders)) {
            first = -1;
        }
    }
    if (first < 0) {
        return refuse_name(model, name, length, error);
    }
    ad_status status = AD_OK;
    for (int i = 0; i < count && status == AD_OK; i++) {
        status = add_column(e, model, first + i, orders, error);
    }
    return status;
}

static ad_status read_names(evaluator *e, const physics_model *model, const char *names,
                            ad_error *error)
{
    ad_status status = AD_OK;
    if (model->column_count == 0) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the network says strains of a family's members, not their shapes; "
                       "cpinn_family_open (in Python cpinn.Family) evaluates members");
    }
    for (int i = 0; !names && status == AD_OK && i < model->column_count; i++) {
        if (e->dynamic || !model->columns[i].of_motion) {
            const int none[DOMAIN_COORDINATES_MAX] = {0};
            status = add_column(e, model, i, none, error);
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

static ad_value differentiated(const evaluator *e, const evaluator_column *c, ad_value y,
                               const domain_place *at)
{
    for (int i = 0; i < e->domain.count; i++) {
        y = c->orders[i] ? ad_derivative(y, at->x[i], c->orders[i]) : y;
    }
    return ad_scale(y, c->to_si);
}

/* The program of the first window or of the later ones. */
static ad_status build(evaluator *e, const evaluator_model *model, int later, ad_error *error)
{
    const physics_model *physics = model->physics;
    ad_tape *tape = ad_tape_create();
    ad_value fields[MODEL_FIELDS_MAX], observed[MODEL_COLUMNS_MAX], values[EVALUATOR_COLUMNS_MAX];
    e->kinds[later] = model_uniforms(physics, later);
    e->kinds[later].state = e->numbers > 0 ? e->kinds[later].state : 0;
    domain_place at = domain_record(&e->domain, &e->kinds[later], tape);
    if (physics->motion) {
        ad_value numbers = ad_parameter(tape, "table", (int)e->count, 0);
        ad_value rows = evaluator_table_record(physics, e->tabled, &at, numbers);
        for (int i = 0; i < e->tabled; i++) {
            observed[e->table[i]] = ad_row(rows, i);
        }
    } else {
        model_record_unknowns(physics, model->mlp, true, &at);
        ad_value input = physics->call.input ? physics->call.input(physics, &at)
                                             : domain_network_input(&e->domain, &at);
        physics->call.ansatz(physics, &at, nn_mlp_record_combined(model->mlp, input, 0), fields);
        physics->call.observe(physics, &at, fields, observed);
    }
    for (int i = 0; i < e->columns; i++) {
        values[i] = differentiated(e, &e->column[i], observed[e->column[i].column], &at);
    }
    ad_status status = ad_compile(e->columns, values, NULL, e->pool, &e->programs[later], error);
    ad_tape_free(tape);
    return status;
}

enum { CHUNK = 128 }; /* points of one window at a time, on the stack */

/* The numbers that are set for a window. */
static domain_setting setting_of(const evaluator *e, int index)
{
    return domain_setting_of(&e->domain, index, e->starts + (size_t)index * e->numbers, 1);
}

/* `count` points of one window; column c goes to values + c * stride. */
static ad_status evaluate_run(evaluator *e, int index, size_t count,
                              double at[DOMAIN_COORDINATES_MAX][CHUNK], double *values,
                              size_t stride, ad_error *error)
{
    double *outputs[EVALUATOR_COLUMNS_MAX];
    const double *inputs[DOMAIN_COORDINATES_MAX], *uniforms[DOMAIN_UNIFORMS_MAX];
    for (int i = 0; i < e->domain.count; i++) {
        inputs[i] = at[i];
    }
    const domain_setting setting = setting_of(e, index);
    int later = index > 0;
    domain_list_uniforms(&e->kinds[later], &setting, uniforms);
    for (int c = 0; c < e->columns; c++) {
        outputs[c] = values + (size_t)c * stride;
    }
    const ad_run run = {.points = count,
                        .inputs = inputs,
                        .uniforms = uniforms,
                        .parameters = e->parameters + (size_t)index * e->count,
                        .outputs = outputs,
                        .everywhere = true};
    return ad_execute(e->programs[later], &run, error);
}

/* What a program allocates when it first runs, it allocates here. */
static ad_status warm_up(evaluator *e, ad_error *error)
{
    double zero[DOMAIN_COORDINATES_MAX][CHUNK] = {{0}},
           *values = malloc(CHUNK * (size_t)e->columns * sizeof *values);
    ad_status status = values ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (int i = 0; i < 2 && i < e->windows && status == AD_OK; i++) {
        status = evaluate_run(e, i, CHUNK, zero, values, CHUNK, error);
    }
    free(values);
    return status;
}

static ad_status add_derivatives(evaluator *e, const physics_model *model, ad_error *error)
{
    ad_status status = AD_OK;
    for (int c = 0, columns = e->columns; c < columns; c++) {
        for (int i = 0; i < e->domain.count && status == AD_OK; i++) {
            int orders[DOMAIN_COORDINATES_MAX];
            memcpy(orders, e->column[c].orders, sizeof orders);
            orders[i]++;
            status = add_column(e, model, e->column[c].column, orders, error);
        }
    }
    return status;
}

/* The columns of the model that are asked for, each once, and what of them a window keeps. */
static void list_table(evaluator *e, const physics_model *physics)
{
    bool listed[MODEL_COLUMNS_MAX] = {false};
    for (int i = 0; i < e->columns; i++) {
        const int column = e->column[i].column;
        if (!listed[column]) {
            e->table[e->tabled++] = column;
            listed[column] = true;
        }
    }
    e->numbers = 0;
    e->count = evaluator_table_numbers(physics, e->tabled);
}

static ad_status make(evaluator *e, const evaluator_model *model, const char *names, bool jacobian,
                      ad_error *error)
{
    size_t windows = (size_t)model->windows, numbers = nn_mlp_parameters(model->mlp);
    ad_status status = read_names(e, model->physics, names, error);
    if (status == AD_OK && jacobian) {
        status = add_derivatives(e, model->physics, error);
    }
    if (status != AD_OK) {
        return status;
    }
    if (model->physics->motion) {
        list_table(e, model->physics);
    }
    e->pool = ad_pool_create(1);
    e->parameters = calloc(windows * e->count, sizeof *e->parameters);
    e->starts = calloc(windows * e->numbers + 1, sizeof *e->starts);
    if (!e->pool || !e->parameters || !e->starts) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the evaluation of a network");
    }
    if (windows > 1 && e->numbers > 0) {
        memcpy(e->starts, model->starts, windows * e->numbers * sizeof *e->starts);
    }
    if (model->physics->motion) {
        status = evaluator_table_fill(model, e->tabled, e->table, e->pool, e->parameters, error);
    }
    for (size_t i = 0; i < windows && !model->physics->motion; i++) {
        nn_mlp_combine(model->mlp, model->parameters + i * numbers, e->parameters + i * e->count);
    }
    for (int i = 0; i < 2 && i < e->windows && status == AD_OK; i++) {
        status = build(e, model, i, error);
    }
    return status == AD_OK ? warm_up(e, error) : status;
}

static ad_status create(const evaluator_model *model, const char *names, bool jacobian,
                        evaluator **result, ad_error *error)
{
    const domain *d = &model->physics->domain;
    evaluator *e = calloc(1, sizeof *e);
    *result = NULL;
    if (!e) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the evaluation of a network");
    }
    e->domain = *d;
    e->dynamic = d->time >= 0;
    e->places = model->physics->has_scene ? 1 + e->dynamic : d->count;
    e->windows = model->windows;
    e->numbers = window_state_numbers(model->physics);
    e->count = nn_mlp_combined_parameters(model->mlp);
    ad_status status = make(e, model, names, jacobian, error);
    if (status != AD_OK) {
        evaluator_free(e);
        return status;
    }
    *result = e;
    return AD_OK;
}

ad_status evaluator_create(const evaluator_model *model, const char *names, evaluator **result,
                           ad_error *error)
{
    AD_LEAVE_HOST;
    return create(model, names, false, result, error);
}

ad_status evaluator_create_jacobian(const evaluator_model *model, const char *names,
                                    evaluator **result, ad_error *error)
{
    AD_LEAVE_HOST;
    return create(model, names, true, result, error);
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

static ad_status check_place(const evaluator *e, int coordinate, size_t points, const double *at,
                             ad_error *error)
{
    const domain_coordinate *by = &e->domain.coordinates[coordinate];
    const double slack = EVALUATOR_BEYOND * (by->high - by->low);
    const double low = (by->low - slack) * by->scale, high = (by->high + slack) * by->scale;
    for (size_t i = 0; i < points; i++) {
        if (at[i] < low || at[i] > high) {
            return ad_fail(error, AD_BAD_ARGUMENT, "%s is %g %s; allowed: %g to %g %s", by->name,
                           at[i], by->unit, by->low * by->scale, by->high * by->scale, by->unit);
        }
    }
    return AD_OK;
}

/* Points that follow one another in the same window are computed at once. */
ad_status evaluator_evaluate_at(evaluator *e, size_t points, const double *const *at,
                                double *values, ad_error *error)
{
    AD_LEAVE_HOST;
    double scaled[DOMAIN_COORDINATES_MAX][CHUNK];
    const domain *d = &e->domain;
    ad_status status = AD_OK;
    for (int i = 0; i < e->places && status == AD_OK; i++) {
        status = check_place(e, i, points, at[i], error);
    }
    for (size_t begin = 0; begin < points && status == AD_OK;) {
        size_t count = 0;
        int index = 0;
        while (count < CHUNK && begin + count < points) {
            for (int i = 0; i < d->count; i++) {
                scaled[i][count] = at[i][begin + count] / d->coordinates[i].scale;
            }
            int window = e->windows > 1 ? window_at(e, scaled[d->time][count]) : 0;
            if (count > 0 && window != index) {
                break;
            }
            index = window;
            count++;
        }
        status = evaluate_run(e, index, count, scaled, values + begin, points, error);
        begin += count;
    }
    return status;
}

ad_status evaluator_evaluate(evaluator *e, size_t points, const double *s, const double *t,
                             double *values, ad_error *error)
{
    AD_LEAVE_HOST;
    const int given = e->dynamic ? 2 : 1;
    if (e->domain.count > given) {
        return ad_fail(
            error, AD_BAD_ARGUMENT,
            "%s is given, too: evaluator_evaluate_at takes all coordinates; members of a "
            "family are evaluated by cpinn_family_open (in Python cpinn.Family)",
            e->domain.coordinates[given].name);
    }
    return evaluator_evaluate_at(e, points, (const double *const[]){s, t}, values, error);
}

/* ---- rounding ------------------------------------------------------------------------------- */

/* `from` [count], each changed by up to a rounding error, the same for the same seed. */
static void put_rounded(size_t count, const double *from, uint64_t seed, double *to)
{
    nn_rng random = nn_rng_seed(seed);
    for (size_t i = 0; i < count; i++) {
        to[i] = from[i] * (1 + nn_rng_between(&random, -1, 1) * DBL_EPSILON);
    }
}

ad_status evaluator_rounding(evaluator *e, size_t points, const double *const *at, double *change,
                             ad_error *error)
{
    AD_LEAVE_HOST;
    enum { TIMES = 8 };
    size_t columns = (size_t)e->columns, count = (size_t)e->windows * e->count;
    double *exact = calloc(2 * columns * points + count + 1, sizeof *exact),
           *changed = exact + columns * points, *parameters = changed + columns * points;
    if (!exact) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", points);
    }
    double *own = e->parameters;
    ad_status status = evaluator_evaluate_at(e, points, at, exact, error);
    memset(change, 0, columns * sizeof *change);
    for (int k = 0; k < TIMES && status == AD_OK; k++) {
        put_rounded(count, own, (uint64_t)k, parameters);
        e->parameters = parameters;
        status = evaluator_evaluate_at(e, points, at, changed, error);
        for (size_t i = 0; i < columns * points && status == AD_OK; i++) {
            change[i / points] = fmax(change[i / points], fabs(changed[i] - exact[i]));
        }
    }
    e->parameters = own;
    free(exact);
    return status;
}

/* ---- C -------------------------------------------------------------------------------------- */

/* What the functions of an evaluator are given: lists over its windows. */
typedef struct given {
    domain_setting *settings;
    const double **parameters;
    const double *(*lists)[DOMAIN_UNIFORMS_MAX];
    const double *const **uniforms;
    char names[2][32];
    ad_memory memory;
} given;

static void given_clear(given *g)
{
    ad_memory_free(&g->memory);
}

/* Fills in the options of one or two functions. */
static ad_status give(const evaluator *e, const char *name, given *g, ad_c_options *options,
                      ad_error *error)
{
    size_t windows = (size_t)e->windows;
    AD_TAKE(g, settings, windows);
    AD_TAKE(g, parameters, windows);
    AD_TAKE(g, lists, windows);
    AD_TAKE(g, uniforms, windows);
    if (g->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for C of a network");
    }
    for (int i = 0; i < e->windows; i++) {
        g->settings[i] = setting_of(e, i);
        domain_list_uniforms(&e->kinds[i > 0], &g->settings[i], g->lists[i]);
        g->parameters[i] = e->parameters + (size_t)i * e->count;
        g->uniforms[i] = g->lists[i];
    }
    for (int later = 0; later < 2; later++) {
        snprintf(g->names[later], sizeof g->names[later], "%.20s_%s", name,
                 later ? "later" : "first");
        options[later] = (ad_c_options){.name = g->names[later],
                                        .points = 1,
                                        .sets = later ? e->windows - 1 : 1,
                                        .parameters = g->parameters + later,
                                        .uniforms = g->uniforms + later,
                                        .internal = true};
    }
    return AD_OK;
}

ad_status evaluator_write_c(int count, evaluator *const *list, const char *const *names,
                            bool single, FILE *file, size_t *memory, ad_error *error)
{
    enum { EVALUATORS_MAX = 4 };
    given all[EVALUATORS_MAX] = {{.settings = NULL}};
    ad_c_options options[2 * EVALUATORS_MAX + 1];
    ad_program *programs[2 * EVALUATORS_MAX + 1];
    ad_status status = AD_OK;
    int functions = 0;
    if (count > EVALUATORS_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT, "C of %d evaluators; allowed: %d", count,
                       EVALUATORS_MAX);
    }
    for (int i = 0; i < count && status == AD_OK; i++) {
        status = give(list[i], names[i], &all[i], options + functions, error);
        for (int later = 0; later < 2 && later < list[i]->windows; later++) {
            programs[functions++] = list[i]->programs[later];
        }
    }
    if (status == AD_OK) {
        status = ad_write_c(functions, programs, options, single, file, memory, error);
    }
    for (int i = 0; i < count; i++) {
        given_clear(&all[i]);
    }
    return status;
}
