#include "tools/optimize/response.h"

#include "physics/chain/solve_members.h"
#include "physics/quantity/quantity.h"
#include "physics/rod/rod_section.h"
#include "physics/scene/breaks.h"
#include "physics/solve/stability.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A shape's columns, and behind them its clearance. */
enum { SHAPES_MAX = 4, NAME_MAX_BYTES = 41, ALONG = -1 };

struct response {
    response_kind kind;
    size_t points, parameters, columns, directions;
    size_t clearance, width;   /* which column of a shape, and how many with it */
    int shapes;                /* that the formula has: */
    int place[SHAPES_MAX];     /* the index of a place, or ALONG */
    bool clears[SHAPES_MAX];   /* the formula has its clearance, */
    const environment *around; /* from this, less the radius */
    double radius;
    bool *needs; /* [parameters] */
    ad_pool *pool;
    response *energy;    /* of the rod, that the formula has; NULL: it has none */
    bool asks_stability; /* it has the margin of that; */
    bool is_bound;       /* it is the least of SOLVE_MARGINS */
    double *s, *weights; /* [points] over the length, and of the mean along the rod */
    double length;
    ad_program *program;             /* value; by the columns of each shape; by the parameters; by
                                      * the energy; by the margin */
    bool is_uniform[SHAPES_MAX + 4]; /* of its outputs: one value for all points */
    double *memory;                  /* what the program reads and writes */
};

/* ---- names --------------------------------------------------------------------------------- */

enum { Q = 3, V = 7 };

static ad_value axis(ad_value shape, int k)
{
    const ad_value q = ad_slice(shape, Q, 4);
    return ad_row(ad_rotate(q, ad_vector_constant(shape.tape, 0, 0, 1)), k);
}

/* A formula that is being recorded. */
typedef struct recording {
    response *of;
    const response_scope *scope;
    ad_tape *tape;
    ad_value s, one, parameters, columns, shape[SHAPES_MAX], energy, stability;
    const scene_breaks *breaks;
    quantities *names;
    int count;
    char text[QUANTITY_OPEN_MAX][NAME_MAX_BYTES];
    quantity_binding bound[QUANTITY_OPEN_MAX];
} recording;

/* What a section has there, or at a place. */
static ad_value section_of(const recording *r, rod_section which, int place, ad_value shape)
{
    ad_value parameters[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < r->scope->family->parameter_count; i++) {
        parameters[i] = ad_row(r->parameters, i);
    }
    if (r->scope->moves && which <= ROD_SECTION_M3) {
        ad_tape_fail(r->tape, AD_BAD_INPUT,
                     "has %s, of which shapes do not say what damping adds to it in motion",
                     rod_section_name(which));
        return r->one;
    }
    const ad_value value =
        rod_section_record(r->scope->family, which, r->s, parameters, ad_slice(shape, V, 6));
    if (place == ALONG) {
        return value;
    }
    const double at = scene_breaks_before(r->breaks, r->of->length, r->scope->at[place]);
    return ad_substitute(value, r->s, ad_scalar(r->tape, at));
}

/* Of a name: a column of shapes, a component of the axis, what follows from strains, or the size of
 * the velocity. */
typedef struct output {
    enum { OUTPUT_COLUMN, OUTPUT_AXIS, OUTPUT_SECTION, OUTPUT_SPEED } kind;
    int which;
} output;

/* false: it is none. */
static bool find_output(const recording *r, const char *name, output *found)
{
    static const char *const rates[] = {"vx", "vy", "vz", "w1", "w2", "w3"};
    const model_column *const columns = scene_physics_of(r->scope->family)->columns;
    const int clearance = (int)r->of->clearance;
    for (int c = 0; c < clearance; c++) {
        const int rate = c - SOLVE_MEMBERS_COLUMNS;
        if (strcmp(name, rate < 0 ? columns[c].name : rates[rate]) == 0) {
            *found = (output){OUTPUT_COLUMN, c};
            return true;
        }
    }
    for (int i = 0; i < ROD_SECTION_COUNT; i++) {
        if (strcmp(name, rod_section_name(i)) == 0) {
            *found = (output){OUTPUT_SECTION, i};
            return true;
        }
    }
    if (strcmp(name, "clearance") == 0) {
        *found = (output){OUTPUT_COLUMN, clearance};
        return true;
    }
    if (strcmp(name, "speed") == 0 && r->scope->moves) {
        *found = (output){OUTPUT_SPEED, 0};
        return true;
    }
    *found = (output){OUTPUT_AXIS, name[0] ? name[1] - 'x' : 0};
    return name[0] == 't' && name[1] >= 'x' && name[1] <= 'z' && !name[2];
}

/* Smaller than what squares can be told from 0: a slope there is 0, and a number. */
static const double NOTHING = 1e-200;

/* Of a shape [width] along the rod, or at a place. */
static ad_value record_output(const recording *r, output of, int place, ad_value shape)
{
    switch (of.kind) {
    case OUTPUT_COLUMN:
        return ad_row(shape, of.which);
    case OUTPUT_AXIS:
        return axis(shape, of.which);
    case OUTPUT_SPEED: {
        ad_value squares = ad_scalar(r->tape, NOTHING);
        for (int i = 0; i < 3; i++) {
            squares = ad_add(squares, ad_square(ad_row(shape, SOLVE_MEMBERS_COLUMNS + i)));
        }
        return ad_sqrt(squares);
    }
    default:
        return section_of(r, of.which, place, shape);
    }
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
    return r->shape[r->of->shapes++] = ad_input(r->tape, "shape", (int)r->of->width);
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
    if (strcmp(name, "energy") == 0) {
        *value = r->energy;
        return true;
    }
    if (strcmp(name, "stability") == 0) {
        *value = r->stability;
        return true;
    }
    if (dot ? place < 0 : r->of->kind == RESPONSE_AT_PLACES) {
        return false;
    }
    output found;
    if (!find_output(r, dot ? dot + 1 : name, &found)) {
        return false;
    }
    *value = record_output(r, found, place, shape_of(r, place));
    const bool clears = found.kind == OUTPUT_COLUMN && found.which == (int)r->of->clearance;
    for (int i = 0; i < r->of->shapes && clears; i++) {
        r->of->clears[i] |= r->of->place[i] == place;
    }
    if (clears && !scope->around) {
        ad_tape_fail(r->tape, AD_BAD_INPUT,
                     "has a clearance, but no surface is given; allowed: optimize.environment.file "
                     "with an STL or OBJ");
    }
    return true;
}

/* Whether a number that is given has the name of what the rod is there. */
static bool is_twofold(const recording *r, const char *name)
{
    const response_scope *scope = r->scope;
    output found;
    return (index_of(name, strlen(name), scope->parameters, scope->parameter) >= 0 ||
            index_of(name, strlen(name), scope->columns, scope->column) >= 0) &&
           (strcmp(name, "energy") == 0 || strcmp(name, "stability") == 0 ||
            (r->of->kind != RESPONSE_AT_PLACES && find_output(r, name, &found)));
}

/* The elastic energy of the rod: its density, integrated. */
static ad_status find_energy(recording *r, ad_error *error)
{
    static const char density[] = "mean(energy_density)";
    return r->of->energy ? AD_OK
                         : response_create(density, r->scope, r->of->points, &r->of->energy, error);
}

/* The margin comes with shapes, of rods at rest that have one. */
static ad_status find_stability(recording *r, ad_error *error)
{
    const char *const why = r->scope->moves ? "has a margin of rods at rest alone"
                                            : stability_without_margin(r->scope->family);
    r->of->asks_stability = true;
    return why ? ad_fail(error, AD_BAD_INPUT, "stability %s", why) : AD_OK;
}

static ad_status bind(recording *r, const char *name, ad_error *error)
{
    for (int i = 0; i < r->count; i++) {
        if (strcmp(r->text[i], name) == 0) {
            return AD_OK;
        }
    }
    ad_value value;
    if (is_twofold(r, name)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "has %s, which is a parameter or a column of cases, and what the rod has "
                       "along it; rename the former",
                       name);
    }
    if (!meaning_of(r, name, &value)) {
        return AD_OK; /* a function, a constant, or unknown, which the parser says */
    }
    ad_status status = quantities_coordinate(r->names, name, error);
    if (status == AD_OK && value.id == r->energy.id) {
        status = find_energy(r, error);
    }
    if (status == AD_OK && value.id == r->stability.id) {
        status = find_stability(r, error);
    }
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
    r->bound[r->count++] = (quantity_binding){"s", ad_scale(r->s, r->of->length)};
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
        status = ad_fail(error, AD_BAD_INPUT, "has the time t; %s",
                         r->scope->moves ? "allowed: what the rod is like at any time"
                                         : "the rod is at rest");
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
    ad_value wanted[SHAPES_MAX + 3], outputs[SHAPES_MAX + 4] = {value};
    int count = 0;
    for (; count < of->shapes; count++) {
        wanted[count] = r->shape[count];
    }
    wanted[count++] = r->parameters;
    wanted[count++] = r->energy;
    wanted[count++] = r->stability;
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

static size_t points_of(const response *r)
{
    return r->kind == RESPONSE_AT_PLACES ? 1 : r->points;
}

/* Numbers that the program reads or writes: one, the energy and the margin, columns of shapes, the
 * adjoints of these and derivatives of clearances, the value and the adjoints of the parameters, of
 * the energy and of the margin; beside them the energy with its derivatives, and of a mean what it
 * is of. */
static size_t numbers_of(const response *r)
{
    const size_t mean = r->kind == RESPONSE_MEAN ? 1 + r->directions : 0;
    return points_of(r) * (6 + (2 * r->width + 3) * (size_t)r->shapes + r->parameters + mean) +
           r->directions + r->columns + 2;
}

/* ---- along the rod ------------------------------------------------------------------------- */

static ad_status place_points(recording *r, scene_breaks *breaks, ad_error *error)
{
    response *of = r->of;
    scene one;
    scene_middle(r->scope->family, &one);
    of->length = scene_length(&one);
    of->s = malloc(of->points * sizeof *of->s);
    of->weights = calloc(of->points, sizeof *of->weights);
    size_t *kept = malloc(of->points * sizeof *kept);
    if (!of->s || !of->weights || !kept) {
        free(kept);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a formula");
    }
    ad_status status = scene_breaks_of(&one, "s", breaks, error);
    double at[BREAKS_MAX];
    for (int i = 0; i < breaks->count; i++) {
        at[i] = breaks->place[i] / of->length;
    }
    for (size_t j = 0; j < of->points && status == AD_OK; j++) {
        of->s[j] = scene_breaks_before(breaks, of->length, r->scope->s[j]);
    }
    if (status == AD_OK) {
        response_weights(of->points, of->s, breaks->count, at, kept, of->weights);
    }
    free(kept);
    return status;
}

/* ---- making, evaluating -------------------------------------------------------------------- */

const char *response_raised(const char *text)
{
    static const char alone[] = "stability";
    const char *from = text + strspn(text, " "), *rest = from + strlen(alone);
    return strncmp(from, alone, strlen(alone)) == 0 && !rest[strspn(rest, " ")] ? "min(stability)"
                                                                                : text;
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
    scene_breaks breaks;
    *result = NULL;
    if (made) {
        made->points = points;
        made->parameters = (size_t)scope->parameters;
        made->columns = (size_t)scope->columns;
        made->directions = made->parameters + (size_t)scope->more;
        made->clearance = scope->moves ? RESPONSE_MOTION_COLUMNS : SOLVE_MEMBERS_COLUMNS;
        made->width = made->clearance + 1;
        made->around = scope->around;
        made->radius = scope->radius;
        made->needs = calloc(made->parameters + 1, sizeof *made->needs);
        made->pool = ad_pool_create(1);
    }
    ad_status status = made && made->needs && made->pool && r.tape && r.names && inner
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a formula");
    if (status == AD_OK) {
        made->kind = kind_of(text, inner, room);
        if (made->kind == RESPONSE_MIN && strcmp(inner, "stability") == 0) {
            made->is_bound = true;
            made->points = SOLVE_MARGINS;
        }
        status = place_points(&r, &breaks, error);
    }
    if (status == AD_OK) {
        r.breaks = &breaks;
        r.s = ad_input(r.tape, "s", 1);
        r.one = ad_input(r.tape, "one", 1);
        r.energy = ad_input(r.tape, "energy", 1);
        r.stability = ad_input(r.tape, "stability", 1);
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
        response_free(r->energy);
        free(r->s);
        free(r->weights);
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
    return r->shapes > 0 || r->energy || r->asks_stability;
}

bool response_needs_stability(const response *r)
{
    return r->asks_stability;
}

bool response_needs_parameter(const response *r, int which)
{
    return r->needs[which] || (r->energy && r->energy->needs[which]);
}

size_t response_rows(const response *r)
{
    return r->kind == RESPONSE_MAX || r->kind == RESPONSE_MIN ? r->points : 1;
}

/* The mean along the rod; by: NULL, if nobody asks. */
static void average(const response *r, const double *rows, const double *slopes, double *mean,
                    double *by)
{
    const size_t width = r->directions;
    *mean = 0;
    memset(by ? by : mean, 0, (by ? width : 1) * sizeof *by);
    for (size_t i = 0; i < r->points; i++) {
        *mean += r->weights[i] * rows[i];
        for (size_t p = 0; p < width && by; p++) {
            by[p] += r->weights[i] * slopes[i * width + p];
        }
    }
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
    const size_t n = points_of(r), width = r->directions, of_shape = r->clearance;
    const int energies = 2 + r->shapes; /* where the adjoint of the energy is among the outputs, */
    const int margins = energies + 1;   /* and that of the margin */
    double *one = r->memory, *energy = one + n, *by_energy = energy + n, *margin = by_energy + n,
           *by_margin = margin + n, *value = by_margin + n, *adjoint = value + n;
    double *columns[SHAPES_MAX], *by_columns[SHAPES_MAX], *by_places[SHAPES_MAX];
    double *given = adjoint + n * r->parameters, *more = given + r->columns + 1;
    const double *inputs[SHAPES_MAX + 4] = {r->s, one, energy, margin};
    double *outputs[SHAPES_MAX + 4] = {value};
    for (int i = 0; i < r->shapes; i++, more += (2 * r->width + 3) * n) {
        columns[i] = more;
        by_columns[i] = more + n * r->width;
        by_places[i] = by_columns[i] + n * r->width; /* the clearance [n][3] */
        inputs[4 + i] = columns[i];
        outputs[1 + i] = by_columns[i];
    }
    outputs[1 + r->shapes] = adjoint;
    outputs[energies] = by_energy;
    outputs[margins] = by_margin;
    double *stored = more, *by_stored = stored + 1, *rows = values, *slopes = by;
    if (r->kind == RESPONSE_MEAN) {
        rows = by_stored + width;
        slopes = by ? rows + n : NULL;
    }
    ad_status status =
        r->energy ? response_evaluate(r->energy, shape, stored, by_stored, error) : AD_OK;
    if (status != AD_OK) {
        return status;
    }
    for (size_t j = 0; j < n; j++) {
        one[j] = 1;
        energy[j] = r->length * *stored;
        margin[j] = r->asks_stability ? shape->margin[r->is_bound ? j : 0] : 0;
        for (int i = 0; i < r->shapes; i++) {
            const double *at = shape->values + point_of(r, shape, i, j) * of_shape;
            for (size_t c = 0; c < of_shape; c++) {
                columns[i][c * n + j] = at[c];
            }
            if (r->clears[i]) {
                columns[i][r->clearance * n + j] =
                    environment_slope(r->around, at, by_places[i] + 3 * j) - r->radius;
            }
        }
    }
    if (r->columns > 0) {
        memcpy(given, shape->columns, r->columns * sizeof *given);
    }
    const double *uniforms[2] = {shape->parameters, given};
    const ad_run run = {.points = n, .inputs = inputs, .uniforms = uniforms, .outputs = outputs};
    status = ad_execute(r->program, &run, error);
    for (size_t j = 0; j < n && status == AD_OK; j++) {
        const double of_energy = r->length * entry(r, energies, by_energy, 0, j);
        const double of_margin = entry(r, margins, by_margin, 0, j);
        rows[j] = entry(r, 0, value, 0, j);
        for (size_t p = 0; p < width && by; p++) {
            double sum = of_energy * by_stored[p];
            sum += p < r->parameters && r->asks_stability
                       ? of_margin * shape->by_margin[(r->is_bound ? j : 0) * r->parameters + p]
                       : 0;
            sum += p < r->parameters ? entry(r, 1 + r->shapes, adjoint, p, j) : 0;
            for (int i = 0; i < r->shapes; i++) {
                const double *by_shape =
                    shape->jacobian + point_of(r, shape, i, j) * of_shape * width;
                for (size_t c = 0; c < of_shape; c++) {
                    sum += entry(r, 1 + i, by_columns[i], c, j) * by_shape[c * width + p];
                }
                for (size_t c = 0; c < 3 && r->clears[i]; c++) {
                    sum += entry(r, 1 + i, by_columns[i], r->clearance, j) *
                           by_places[i][3 * j + c] * by_shape[c * width + p];
                }
            }
            slopes[j * width + p] = sum;
        }
    }
    if (status == AD_OK && r->kind == RESPONSE_MEAN) {
        average(r, rows, slopes, values, by);
    }
    return status;
}
