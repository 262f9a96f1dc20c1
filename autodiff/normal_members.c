/* J^T J of residuals at points that see the parameters x through values c of their members alone:
 * J = (dr/dc) (dc/dx). What the points of a member add to J^T J is D^T A D with D = dc/dx and
 * A = sum (dr/dc)^T (dr/dc) over its points; with A = L L^T it is that of the few rows L^T D, the
 * Jacobian of L^T c at a run over the members in place of the points. So what lies before c is gone
 * back through once for each coefficient of a member, not for each residual of each point. J^T r is
 * the gradient of half the sum of squares. */
#include "autodiff/normal.h"
#include "autodiff/transform.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct ad_member_normal {
    ad_program *points; /* outputs: A [size][size], the sum of r^2, J^T r by variables */
    double **outputs;   /* of a run */
    bool is_uniform;    /* A is the same for all members */
    int variables;
    size_t *offsets; /* [variables] of the parameters in their vector */
    int *rows;
    ad_normal *members; /* rows L^T D; its points are the members */
    int size;
    int inputs;           /* of the tape */
    int *given;           /* [inputs] the input of members that one of `members` is, or -1 */
    int factor;           /* its input L^T */
    const double **input; /* [inputs] */
    size_t parameters;
    double
        *gradient;  /* [2 parameters]: J^T r by variables, one after the other; what is not used */
    double *matrix; /* [2][size][size]: A and L^T of one member */
    double *matrices; /* [size][size][members]: A, then L^T */
    size_t capacity;  /* members */
};

/* Working memory of one compilation. */
typedef struct split {
    ad_tape *tape;
    int count;      /* nodes below it are looked at */
    bool *needed;   /* by a residual */
    bool *moves;    /* with the parameters */
    bool *taken;    /* is one of `from` */
    ad_value *from; /* values of members that points see */
    ad_value *leaf; /* an input of members in place of each */
    ad_value *adjoints, *outputs;
    int leaves, size;
} split;

static int argument(const split *s, int id, int i)
{
    return s->tape->arguments[s->tape->nodes[id].first + i];
}

static void mark(split *s, int count, const ad_value *residuals, int wrt_count, const ad_value *wrt)
{
    for (int i = 0; i < count; i++) {
        s->needed[residuals[i].id] = true;
    }
    for (int i = 0; i < wrt_count; i++) {
        s->moves[wrt[i].id] = true;
    }
    for (int id = s->count - 1; id >= 0; id--) {
        for (int i = 0; s->needed[id] && i < s->tape->nodes[id].count; i++) {
            s->needed[argument(s, id, i)] = true;
        }
    }
    for (int id = 0; id < s->count; id++) {
        for (int i = 0; i < s->tape->nodes[id].count; i++) {
            s->moves[id] = s->moves[id] || s->moves[argument(s, id, i)];
        }
    }
}

/* Does a node vary over points with the parameters, other than through values of members? */
static bool is_mixed(const split *s, int id)
{
    const node *n = &s->tape->nodes[id];
    bool mixed = false;
    for (int i = 0; s->needed[id] && n->extent == AD_BATCH && i < n->count; i++) {
        int x = argument(s, id, i);
        mixed = mixed || (s->moves[x] && s->tape->nodes[x].extent == AD_UNIFORM);
    }
    return mixed || (s->needed[id] && (op_is_reduction(n->op) || n->op == OP_POINTS));
}

static void take(split *s, int id)
{
    if (s->moves[id] && !s->taken[id]) {
        s->taken[id] = true;
        s->from[s->leaves++] = value_of(s->tape, id);
    }
}

/* The values c, and an input in place of each. */
static bool cut(split *s, int count, const ad_value *residuals)
{
    bool mixed = false;
    for (int id = 0; id < s->count; id++) {
        mixed = mixed || is_mixed(s, id);
        if (s->needed[id] && s->tape->nodes[id].op == OP_SPREAD) {
            take(s, argument(s, id, 0));
        }
    }
    for (int i = 0; i < count; i++) {
        ad_extent extent = ad_extent_of(residuals[i]);
        mixed = mixed || (extent == AD_UNIFORM && s->moves[residuals[i].id]);
        if (extent == AD_MEMBER) {
            take(s, residuals[i].id);
        }
    }
    if (mixed || s->leaves == 0) {
        ad_tape_fail(s->tape, AD_BAD_ARGUMENT,
                     "normal equations of members: parameters have to act through values of "
                     "members alone, and residuals may not contain sums or numbers of points");
        return false;
    }
    for (int i = 0; i < s->leaves; i++) {
        s->leaf[i] = ad_input_member(s->tape, "coefficients", ad_rows(s->from[i]));
        s->size += ad_rows(s->from[i]);
    }
    return s->tape->error.status == AD_OK;
}

/* A and r^2 of one row of the residuals, by the inputs in place of c. */
static void add_row(split *s, ad_value r, ad_value *sums, ad_value *adjoints)
{
    if (ad_reverse(r, s->leaves, s->leaf, AD_PER_POINT, adjoints) != AD_OK) {
        return;
    }
    ad_value row = ad_stack(s->leaves, adjoints);
    sums[0] = ad_add(sums[0], ad_sum_points_of_member(ad_outer(row, row)));
    sums[1] = ad_add(sums[1], ad_sum_points(ad_square(r)));
}

static ad_status compile_points(ad_member_normal *normal, split *s, int count,
                                const ad_value *residuals, int wrt_count, const ad_value *wrt,
                                ad_pool *pool, ad_error *error)
{
    ad_value *outputs = s->outputs;
    outputs[0] = ad_zeros(s->tape, s->size * s->size);
    outputs[1] = ad_zeros(s->tape, 1);
    for (int i = 0; i < count; i++) {
        ad_value r = ad_transform_replace(residuals[i], s->leaves, s->from, s->leaf);
        for (int row = 0; row < ad_rows(r); row++) {
            add_row(s, ad_row(r, row), outputs, s->adjoints);
        }
    }
    for (int i = 0; i < 2; i++) {
        outputs[i] = ad_transform_replace(outputs[i], s->leaves, s->leaf, s->from);
    }
    normal->is_uniform = ad_extent_of(outputs[0]) == AD_UNIFORM;
    if (ad_reverse(ad_scale(outputs[1], 0.5), wrt_count, wrt, AD_SUMMED, outputs + 2) != AD_OK) {
        return ad_tape_status(s->tape, error);
    }
    return ad_compile(wrt_count + 2, outputs, NULL, pool, &normal->points, error);
}

/* Inputs of members, with one block per point of a run over the members. */
static ad_value per_point(ad_member_normal *normal, split *s, ad_value c)
{
    ad_tape *tape = s->tape;
    for (int id = 0; id < s->count; id++) {
        node n = tape->nodes[id];
        if (s->needed[id] && n.op == OP_INPUT && n.extent == AD_MEMBER) {
            int number = tape->inputs;
            c = ad_substitute(c, value_of(tape, id), ad_input(tape, "of member", n.rows));
            normal->given[number] = n.whole;
        }
    }
    return c;
}

static ad_status compile_members(ad_member_normal *normal, split *s, int wrt_count,
                                 const ad_value *wrt, ad_pool *pool, ad_error *error)
{
    int size = s->size;
    ad_value c = per_point(normal, s, ad_stack(s->leaves, s->from));
    normal->factor = s->tape->inputs;
    ad_value factor = ad_input(s->tape, "factor", size * size);
    ad_value *rows = malloc((size_t)size * sizeof *rows);
    if (!rows) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for normal equations of members");
    }
    for (int k = 0; k < size; k++) {
        rows[k] = ad_dot(ad_slice(factor, k * size, size), c);
    }
    ad_status status = ad_normal_compile(size, rows, wrt_count, wrt, normal->parameters, pool,
                                         &normal->members, error);
    free(rows);
    return status;
}

/* Memory of the compilation, and what runs need whatever their members. */
static bool begin(split *s, ad_member_normal *normal, int wrt_count, const ad_value *wrt)
{
    size_t nodes = (size_t)s->count + 1, variables = (size_t)wrt_count;
    s->needed = calloc(3 * nodes, sizeof *s->needed);
    s->from = calloc(3 * nodes + variables + 2, sizeof *s->from);
    normal->given = malloc(3 * nodes * sizeof *normal->given);
    normal->offsets = malloc((variables + 1) * sizeof *normal->offsets);
    normal->rows = malloc((variables + 1) * sizeof *normal->rows);
    normal->outputs = calloc(variables + 2, sizeof *normal->outputs);
    normal->gradient = calloc(2 * normal->parameters + 1, sizeof *normal->gradient);
    if (!s->needed || !s->from || !normal->given || !normal->offsets || !normal->rows ||
        !normal->outputs || !normal->gradient) {
        return false;
    }
    memset(normal->given, -1, 3 * nodes * sizeof *normal->given);
    s->moves = s->needed + nodes;
    s->taken = s->needed + 2 * nodes;
    s->leaf = s->from + nodes;
    s->adjoints = s->from + 2 * nodes;
    s->outputs = s->from + 3 * nodes;
    normal->variables = wrt_count;
    double *at = normal->gradient;
    for (int i = 0; i < wrt_count; i++) {
        normal->offsets[i] = node_of(wrt[i])->offset;
        normal->rows[i] = ad_rows(wrt[i]);
        normal->outputs[i + 2] = at;
        at += normal->rows[i];
    }
    return true;
}

static ad_status compile(ad_member_normal *normal, split *s, int count, const ad_value *residuals,
                         int wrt_count, const ad_value *wrt, ad_pool *pool, ad_error *error)
{
    if (!begin(s, normal, wrt_count, wrt)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for normal equations of members");
    }
    mark(s, count, residuals, wrt_count, wrt);
    if (!cut(s, count, residuals)) {
        return ad_tape_status(s->tape, error);
    }
    ad_status status = compile_members(normal, s, wrt_count, wrt, pool, error);
    if (status == AD_OK) {
        status = compile_points(normal, s, count, residuals, wrt_count, wrt, pool, error);
    }
    size_t size = (size_t)s->size;
    normal->size = s->size;
    normal->inputs = s->tape->inputs;
    normal->input = calloc((size_t)normal->inputs, sizeof *normal->input);
    normal->matrix = malloc(2 * size * size * sizeof *normal->matrix);
    if (status == AD_OK && (!normal->input || !normal->matrix)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for normal equations of members");
    }
    return status;
}

ad_status ad_member_normal_compile(int count, const ad_value *residuals, int wrt_count,
                                   const ad_value *wrt, size_t parameters, ad_pool *pool,
                                   ad_member_normal **result, ad_error *error)
{
    *result = NULL;
    ad_tape *tape = count > 0 ? residuals[0].tape : NULL;
    if (!tape || ad_tape_status(tape, error) != AD_OK) {
        return tape ? tape->error.status : AD_BAD_ARGUMENT;
    }
    ad_status status = ad_normal_check(wrt_count, wrt, parameters, error);
    for (int i = 0; status == AD_OK && i < count; i++) {
        ad_transform_usable(residuals[i], "residual", tape);
        status = ad_tape_status(tape, error);
    }
    if (status != AD_OK) {
        return status;
    }
    split s = {.tape = tape, .count = tape->count};
    ad_member_normal *normal = calloc(1, sizeof *normal);
    if (normal) {
        normal->parameters = parameters;
        status = compile(normal, &s, count, residuals, wrt_count, wrt, pool, error);
    } else {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for normal equations of members");
    }
    free(s.needed);
    free(s.from);
    if (status != AD_OK) {
        ad_member_normal_free(normal);
        return status;
    }
    *result = normal;
    return AD_OK;
}

void ad_member_normal_free(ad_member_normal *normal)
{
    if (normal) {
        ad_program_free(normal->points);
        ad_normal_free(normal->members);
        free(normal->outputs);
        free(normal->offsets);
        free(normal->rows);
        free(normal->given);
        free(normal->input);
        free(normal->gradient);
        free(normal->matrix);
        free(normal->matrices);
        free(normal);
    }
}

/* ---- runs ------------------------------------------------------------------------------------ */

/* A = L L^T; the largest pivot first, so that where only rounding is left all of it is small. l:
 * L^T [n][n]; a is used up. */
static void factor(int n, double *a, double *l)
{
    double least = 0;
    memset(l, 0, (size_t)(n * n) * sizeof *l);
    for (int k = 0; k < n; k++) {
        double *row = l + k * n;
        int p = 0;
        for (int i = 1; i < n; i++) {
            p = a[i * n + i] > a[p * n + p] ? i : p;
        }
        least = k == 0 ? n * DBL_EPSILON * a[p * n + p] : least;
        if (!(a[p * n + p] > least)) {
            return;
        }
        for (int i = 0; i < n; i++) {
            row[i] = a[p * n + i] / sqrt(a[p * n + p]);
        }
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                a[i * n + j] = i == p || j == p ? 0 : a[i * n + j] - row[i] * row[j];
            }
        }
    }
}

/* A of each member becomes L^T. */
static void factor_members(const ad_member_normal *normal, size_t members)
{
    int n = normal->size;
    double *a = normal->matrices, *own = normal->matrix, *l = own + n * n;
    for (size_t i = (size_t)(n * n) * members; normal->is_uniform && i-- > 0;) {
        a[i] = a[i / members];
    }
    for (size_t member = 0; member < members; member++) {
        for (int i = 0; i < n * n; i++) {
            own[i] = a[(size_t)i * members + member];
        }
        factor(n, own, l);
        for (int i = 0; i < n * n; i++) {
            a[(size_t)i * members + member] = l[i];
        }
    }
}

static bool make_room(ad_member_normal *normal, size_t members)
{
    if (members > normal->capacity) {
        size_t size = (size_t)normal->size;
        double *larger = realloc(normal->matrices, size * size * members * sizeof *larger);
        if (!larger) {
            return false;
        }
        normal->matrices = larger;
        normal->capacity = members;
    }
    return true;
}

ad_status ad_member_normal_add(ad_member_normal *normal, const ad_run *run, double *jtj,
                               double *jtr, double *rtr, ad_error *error)
{
    size_t members = run->members > 0 ? run->members : 1;
    if (!make_room(normal, members)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", members);
    }
    double squares = 0, unused = 0;
    ad_run points = *run;
    points.outputs = normal->outputs;
    normal->outputs[0] = normal->matrices;
    normal->outputs[1] = &squares;
    ad_status status = ad_execute(normal->points, &points, error);
    if (status != AD_OK) {
        return status;
    }
    factor_members(normal, members);
    *rtr += squares;
    for (int i = 0; i < normal->variables; i++) {
        for (int row = 0; row < normal->rows[i]; row++) {
            jtr[normal->offsets[i] + (size_t)row] += normal->outputs[i + 2][row];
        }
    }
    for (int i = 0; i < normal->inputs; i++) {
        normal->input[i] = normal->given[i] >= 0 ? run->inputs[normal->given[i]] : NULL;
    }
    normal->input[normal->factor] = normal->matrices;
    ad_run over = {.points = members,
                   .inputs = normal->input,
                   .uniforms = run->uniforms,
                   .parameters = run->parameters};
    return ad_normal_add(normal->members, &over, jtj, normal->gradient + normal->parameters,
                         &unused, error);
}
