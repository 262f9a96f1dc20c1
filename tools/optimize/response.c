#include "tools/optimize/response.h"

#include "physics/chain/solve_members.h"
#include "physics/quantity/quantity.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SHAPES_MAX = 4, NAME_MAX_BYTES = 41, ALONG = -1, COLUMNS = SOLVE_MEMBERS_COLUMNS };

struct response {
    response_kind kind;
    size_t points, parameters, columns;
    int shapes;            /* that the formula has: */
    int place[SHAPES_MAX]; /* the index of a place, or ALONG */
    bool *needs;           /* [parameters] */
    ad_pool *pool;
    ad_program *program;             /* value; by the columns of each shape; by the parameters */
    bool is_uniform[SHAPES_MAX + 2]; /* of its outputs: one value for all points */
    double *memory;                  /* what the program reads and writes */
};

/* ---- names --------------------------------------------------------------------------------- */

enum { Q = 3, V = 7, U = 10 };

static ad_value root_of_squares(ad_value a, ad_value b)
{
    return ad_sqrt(ad_add(ad_square(a), ad_square(b)));
}

static ad_value axis(ad_value shape, int k)
{
    const ad_value q = ad_slice(shape, Q, 4);
    return ad_row(ad_rotate(q, ad_vector_constant(shape.tape, 0, 0, 1)), k);
}

/* What an output of that name is, of a shape [COLUMNS]; false: there is none. */
static bool output_named(const model_column *outputs, const char *name, ad_value shape,
                         ad_value *value)
{
    for (int c = 0; c < COLUMNS; c++) {
        if (strcmp(name, outputs[c].name) == 0) {
            *value = ad_row(shape, c);
            return true;
        }
    }
    if (name[0] == 't' && name[1] >= 'x' && name[1] <= 'z' && !name[2]) {
        *value = axis(shape, name[1] - 'x');
        return true;
    }
    const bool bends = strcmp(name, "curvature") == 0, shears = strcmp(name, "shear") == 0;
    if (bends || shears) {
        const int first = bends ? U : V;
        *value = root_of_squares(ad_row(shape, first), ad_row(shape, first + 1));
    }
    return bends || shears;
}

static int index_of(const char *name, size_t length, int count, const char *const *names)
{
    for (int i = 0; i < count; i++) {
        if (strlen(names[i]) == length && strncmp(names[i], name, length) == 0) {
            return i;
        }
    }
    return -1;
}

/* The next name of a formula, with its place, "tip.x"; false: there is none. */
static bool next_name(const char **at, char name[NAME_MAX_BYTES])
{
    const char *p = *at;
    while (*p && !(isalpha((unsigned char)*p) || *p == '_')) {
        const bool number = isdigit((unsigned char)*p) || *p == '.';
        p++;
        if (number && (*p == 'e' || *p == 'E')) { /* the exponent of a number */
            p++;
        }
    }
    size_t length = 0;
    while (isalnum((unsigned char)p[length]) || p[length] == '_' || p[length] == '.') {
        length++;
    }
    *at = p + length;
    snprintf(name, NAME_MAX_BYTES, "%.*s", (int)length, p);
    return length > 0;
}

/* ---- recording ----------------------------------------------------------------------------- */

/* A formula that is being recorded. */
typedef struct recording {
    response *of;
    const response_scope *scope;
    ad_tape *tape;
    ad_value s, one, parameters, columns, shape[SHAPES_MAX];
    quantities *names;
    int count;
    char text[QUANTITY_OPEN_MAX][NAME_MAX_BYTES];
    quantity_binding bound[QUANTITY_OPEN_MAX];
} recording;

static ad_value shape_of(recording *r, int place)
{
    for (int i = 0; i < r->of->shapes; i++) {
        if (r->of->place[i] == place) {
            return r->shape[i];
        }
    }
    if (r->of->shapes == SHAPES_MAX) {
        ad_tape_fail(r->tape, AD_BAD_INPUT, "has more than %d places; use fewer", SHAPES_MAX);
        return r->one;
    }
    r->of->place[r->of->shapes] = place;
    return r->shape[r->of->shapes++] = ad_input(r->tape, "shape", COLUMNS);
}

/* What a name stands for; false: nothing that is known here. */
static bool meaning_of(recording *r, const char *name, ad_value *value)
{
    const response_scope *scope = r->scope;
    const int parameter = index_of(name, strlen(name), scope->parameters, scope->parameter);
    const int column = index_of(name, strlen(name), scope->columns, scope->column);
    if (parameter >= 0) {
        r->of->needs[parameter] = true;
        *value = ad_row(r->parameters, parameter);
        return true;
    }
    if (column >= 0) {
        *value = ad_row(r->columns, column);
        return true;
    }
    const char *dot = strchr(name, '.');
    const int place =
        dot ? index_of(name, (size_t)(dot - name), scope->places, scope->place) : ALONG;
    if (dot ? place < 0 : r->of->kind == RESPONSE_AT_PLACES) {
        return false;
    }
    ad_value probe; /* so that no input is made for what is no output */
    ad_tape *apart = ad_tape_create();
    const bool known = apart && output_named(scope->outputs, dot ? dot + 1 : name,
                                             ad_input(apart, "shape", COLUMNS), &probe);
    ad_tape_free(apart);
    return known && output_named(scope->outputs, dot ? dot + 1 : name, shape_of(r, place), value);
}

static ad_status bind(recording *r, const char *name, ad_error *error)
{
    for (int i = 0; i < r->count; i++) {
        if (strcmp(r->text[i], name) == 0) {
            return AD_OK;
        }
    }
    ad_value value;
    if (!meaning_of(r, name, &value)) {
        return AD_OK; /* a function, a constant, or unknown, which the parser says */
    }
    ad_status status = quantities_coordinate(r->names, name, error);
    if (status == AD_OK) {
        char *kept = r->text[r->count];
        snprintf(kept, NAME_MAX_BYTES, "%s", name);
        r->bound[r->count++] = (quantity_binding){kept, value};
    }
    return status;
}

/* The value at a point, always one of a batch, so that derivatives are those of each point. */
static ad_status record(recording *r, const char *text, ad_value *value, ad_error *error)
{
    char name[NAME_MAX_BYTES];
    ad_status status = AD_OK;
    r->bound[r->count++] = (quantity_binding){"s", r->s};
    snprintf(r->text[0], NAME_MAX_BYTES, "s");
    for (const char *at = text; status == AD_OK && next_name(&at, name);) {
        status = bind(r, name, error);
    }
    if (status != AD_OK) {
        return status;
    }
    const quantity formula = quantity_formula(r->names, text);
    status = quantity_check(formula, error);
    if (status == AD_OK && quantity_depends_on(formula, "t")) {
        status = ad_fail(error, AD_BAD_INPUT, "has the time t; the rod is at rest");
    }
    if (status == AD_OK && r->of->kind == RESPONSE_AT_PLACES && quantity_depends_on(formula, "s")) {
        status =
            ad_fail(error, AD_BAD_INPUT, "has s outside of max, min or mean; allowed there alone");
    }
    if (status == AD_OK) {
        *value = ad_mul(quantity_record(formula, r->tape, r->count, r->bound), r->one);
    }
    return status;
}

static ad_status compile(recording *r, ad_value value, ad_error *error)
{
    response *of = r->of;
    ad_value wanted[SHAPES_MAX + 1], outputs[SHAPES_MAX + 2] = {value};
    int count = 0;
    for (; count < of->shapes; count++) {
        wanted[count] = r->shape[count];
    }
    wanted[count++] = r->parameters;
    ad_reverse(value, count, wanted, AD_PER_POINT, outputs + 1);
    ad_status status = ad_tape_status(r->tape, error);
    for (int i = 0; status == AD_OK && i <= count; i++) {
        of->is_uniform[i] = ad_extent_of(outputs[i]) == AD_UNIFORM;
    }
    return status == AD_OK ? ad_compile(count + 1, outputs, NULL, of->pool, &of->program, error)
                           : status;
}

/* The formula within "max(...)", where that is all of the text; and what it is. */
static response_kind kind_of(const char *text, char *inner, size_t room)
{
    static const char *const words[] = {"", "max", "min", "mean"};
    snprintf(inner, room, "%s", text);
    const char *p = text + strspn(text, " \t");
    for (int kind = RESPONSE_MAX; kind <= RESPONSE_MEAN; kind++) {
        const size_t length = strlen(words[kind]);
        if (strncmp(p, words[kind], length) != 0) {
            continue;
        }
        const char *open = p + length + strspn(p + length, " \t");
        int depth = 0;
        bool alone = *open == '(';
        const char *end = open;
        for (; alone && *end; end++) {
            depth += *end == '(' ? 1 : *end == ')' ? -1 : 0;
            alone = !(*end == ',' && depth == 1); /* max(a, b) of two is that of formulas */
            if (depth == 0) {
                break;
            }
        }
        if (alone && *end == ')' && !end[1 + strspn(end + 1, " \t")]) {
            snprintf(inner, room, "%.*s", (int)(end - open - 1), open + 1);
            return (response_kind)kind;
        }
    }
    return RESPONSE_AT_PLACES;
}

/* ---- making, evaluating -------------------------------------------------------------------- */

static size_t points_of(const response *r)
{
    return r->kind == RESPONSE_AT_PLACES ? 1 : r->points;
}

/* Numbers that the program reads or writes: s and one, columns of shapes and the adjoints of these,
 * the value and the adjoints of the parameters. */
static size_t numbers_of(const response *r)
{
    return points_of(r) * (3 + 2 * (size_t)r->shapes * COLUMNS + r->parameters) + r->parameters +
           r->columns + 1;
}

ad_status response_create(const char *text, const response_scope *scope, size_t points,
                          response **result, ad_error *error)
{
    response *made = calloc(1, sizeof *made);
    recording r = {
        .of = made, .scope = scope, .tape = ad_tape_create(), .names = quantities_create()};
    const size_t room = strlen(text) + 1;
    char *inner = malloc(room);
    ad_value value;
    *result = NULL;
    if (made) {
        made->points = points;
        made->parameters = (size_t)scope->parameters;
        made->columns = (size_t)scope->columns;
        made->needs = calloc(made->parameters + 1, sizeof *made->needs);
        made->pool = ad_pool_create(1);
    }
    ad_status status = made && made->needs && made->pool && r.tape && r.names && inner
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a formula");
    if (status == AD_OK) {
        made->kind = kind_of(text, inner, room);
        r.s = ad_input(r.tape, "s", 1);
        r.one = ad_input(r.tape, "one", 1);
        r.parameters = ad_uniform(r.tape, "parameters", scope->parameters);
        r.columns = ad_uniform(r.tape, "columns", scope->columns + 1);
        status = record(&r, inner, &value, error);
    }
    status = status == AD_OK ? compile(&r, value, error) : status;
    if (status == AD_OK) {
        made->memory = calloc(numbers_of(made), sizeof *made->memory);
        status = made->memory ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a formula");
    }
    free(inner);
    quantities_free(r.names);
    ad_tape_free(r.tape);
    if (status != AD_OK) {
        response_free(made);
        return status;
    }
    *result = made;
    return AD_OK;
}

void response_free(response *r)
{
    if (r) {
        ad_program_free(r->program);
        ad_pool_free(r->pool);
        free(r->needs);
        free(r->memory);
        free(r);
    }
}

response_kind response_kind_of(const response *r)
{
    return r->kind;
}

bool response_needs_shape(const response *r)
{
    return r->shapes > 0;
}

bool response_needs_parameter(const response *r, int which)
{
    return r->needs[which];
}

size_t response_rows(const response *r)
{
    return r->kind == RESPONSE_MAX || r->kind == RESPONSE_MIN ? r->points : 1;
}

/* The mean along the rod, by trapezoids. */
static void average(const response_shape *shape, size_t parameters, double *values, double *by)
{
    const size_t n = shape->points;
    const double length = shape->s[n - 1] - shape->s[0];
    double mean = 0;
    for (size_t i = 0; i < n; i++) {
        const double next = shape->s[i + 1 < n ? i + 1 : i], before = shape->s[i > 0 ? i - 1 : 0];
        const double weight = (next - before) / 2 / length;
        mean += weight * values[i];
        for (size_t p = 0; p < parameters && by; p++) {
            by[p] = (i > 0 ? by[p] : 0) + weight * by[i * parameters + p];
        }
    }
    values[0] = mean;
}

/* Which point of the shape the formula's point j is to its shape i. */
static size_t point_of(const response *r, const response_shape *shape, int i, size_t j)
{
    return r->place[i] == ALONG ? j : shape->place[r->place[i]];
}

/* A number of an output of the program. */
static double entry(const response *r, int output, const double *numbers, size_t row, size_t j)
{
    return r->is_uniform[output] ? numbers[row] : numbers[row * points_of(r) + j];
}

ad_status response_evaluate(const response *r, const response_shape *shape, double *values,
                            double *by, ad_error *error)
{
    const size_t n = points_of(r), width = r->parameters;
    double *s = r->memory, *one = s + n, *value = one + n, *adjoint = value + n;
    double *columns[SHAPES_MAX], *by_columns[SHAPES_MAX];
    double *given = adjoint + n * width, *more = given + r->columns + 1;
    const double *inputs[SHAPES_MAX + 2] = {s, one};
    double *outputs[SHAPES_MAX + 2] = {value};
    for (int i = 0; i < r->shapes; i++, more += 2 * n * COLUMNS) {
        columns[i] = more;
        by_columns[i] = more + n * COLUMNS;
        inputs[2 + i] = columns[i];
        outputs[1 + i] = by_columns[i];
    }
    outputs[1 + r->shapes] = adjoint;
    for (size_t j = 0; j < n; j++) {
        s[j] = shape->s[j];
        one[j] = 1;
        for (int i = 0; i < r->shapes; i++) {
            const double *at = shape->values + point_of(r, shape, i, j) * COLUMNS;
            for (size_t c = 0; c < COLUMNS; c++) {
                columns[i][c * n + j] = at[c];
            }
        }
    }
    memcpy(given, shape->columns, r->columns * sizeof *given);
    const double *uniforms[2] = {shape->parameters, given};
    const ad_run run = {.points = n, .inputs = inputs, .uniforms = uniforms, .outputs = outputs};
    ad_status status = ad_execute(r->program, &run, error);
    for (size_t j = 0; j < n && status == AD_OK; j++) {
        values[j] = entry(r, 0, value, 0, j);
        for (size_t p = 0; p < width && by; p++) {
            double sum = entry(r, 1 + r->shapes, adjoint, p, j);
            for (int i = 0; i < r->shapes; i++) {
                const double *by_shape =
                    shape->jacobian + point_of(r, shape, i, j) * COLUMNS * width;
                for (size_t c = 0; c < COLUMNS; c++) {
                    sum += entry(r, 1 + i, by_columns[i], c, j) * by_shape[c * width + p];
                }
            }
            by[j * width + p] = sum;
        }
    }
    if (status == AD_OK && r->kind == RESPONSE_MEAN) {
        average(shape, width, values, by);
    }
    return status;
}
