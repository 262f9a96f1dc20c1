#include "physics/solve/strain_form.h"

#include "physics/solve/strain_algebra.h"

#include <stdlib.h>

/* ---- making -------------------------------------------------------------------------------- */

void strain_form_lagrange(const gauss_rule *rule, double x, double *values)
{
    for (int j = 0; j < rule->stages; j++) {
        values[j] = 1;
        for (int k = 0; k < rule->stages; k++) {
            if (k != j) {
                values[j] *= (x - rule->nodes[k]) / (rule->nodes[j] - rule->nodes[k]);
            }
        }
    }
}

void strain_form_integral(const gauss_rule *rule, double x, double *values)
{
    const gauss_rule exact = solve_gauss_rule_of(rule->stages);
    memset(values, 0, (size_t)rule->stages * sizeof *values);
    for (int k = 0; k < exact.stages; k++) {
        double at[GAUSS_STAGES_MAX];
        strain_form_lagrange(rule, x * exact.nodes[k], at);
        for (int j = 0; j < rule->stages; j++) {
            values[j] += x * exact.weights[k] * at[j];
        }
    }
}

/* Blanes' alpha_1 .. alpha_3 from u at three points of Gauss. */
void strain_form_magnus(const gauss_rule *rule, double from, double to,
                        double terms[3][GAUSS_STAGES_MAX])
{
    const double h = to - from, middle = (from + to) / 2, off = h * sqrt(15) / 10;
    double at[3][GAUSS_STAGES_MAX];
    for (int k = 0; k < 3; k++) {
        strain_form_lagrange(rule, middle + (k - 1) * off, at[k]);
    }
    for (int j = 0; j < rule->stages; j++) {
        terms[0][j] = h * at[1][j];
        terms[1][j] = h * sqrt(15) / 3 * (at[2][j] - at[0][j]);
        terms[2][j] = h * 10 / 3 * (at[2][j] - 2 * at[1][j] + at[0][j]);
    }
}

static void set_magnus(strain_form *x)
{
    const int n = x->kind.stages, parts = x->kind.substeps;
    const gauss_rule *rule = &x->rule;
    for (int i = 0; i < (n + 1) * parts; i++) {
        const int next = i / parts;
        double from = next > 0 ? rule->nodes[next - 1] : 0, to = next < n ? rule->nodes[next] : 1;
        double h = (to - from) / parts, start = from + h * (i % parts);
        strain_form_magnus(rule, start, start + h, x->magnus[i]);
    }
}

/* Numbers those unknowns that are no curvatures. */
static void number_unknowns(strain_form *x)
{
    const strain_kind *kind = &x->kind;
    int *first[] = {&x->force_at, &x->moment_at, &x->shift_at, &x->turn_at, &x->push_at};
    const int count[] = {kind->end.hold.directions > 0 ? 3 : 0, kind->end.holds_rotation ? 3 : 0,
                         kind->free_position ? 3 : 0, kind->free_rotation ? 3 : 0,
                         kind->founded ? 3 * x->nodes : 0};
    x->elastic = x->unknowns = 3 * x->nodes;
    for (int i = 0; i < 5; i++) {
        *first[i] = count[i] > 0 ? x->unknowns : -1;
        x->unknowns += count[i];
    }
}

static void *make(size_t count, size_t size)
{
    return calloc(count + 1, size);
}

ad_status strain_form_create(const strain_kind *kind, strain_form **result, ad_error *error)
{
    strain_form *x = calloc(1, sizeof *x);
    *result = x;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a strain form");
    }
    *x = (strain_form){.kind = *kind,
                       .rule = solve_gauss_rule_of(kind->stages),
                       .nodes = kind->stages * kind->elements};
    size_t nodes = (size_t)x->nodes, elements = (size_t)kind->elements;
    number_unknowns(x);
    x->unknowns += 3 * kind->springs; /* at most */
    size_t unknowns = (size_t)x->unknowns;
    x->unknowns -= 3 * kind->springs;
    x->width = make(elements, sizeof *x->width);
    x->points = make(nodes, sizeof *x->points);
    x->actuators = make(nodes * (size_t)kind->actuators, sizeof *x->actuators);
    x->at = make(nodes, sizeof *x->at);
    x->edges = make(elements + 1, sizeof *x->edges);
    x->springs = make((size_t)kind->springs, sizeof *x->springs);
    x->matrix = make(kind->is_rigid || kind->is_one ? 0 : unknowns * unknowns, sizeof *x->matrix);
    x->right = make(unknowns, sizeof *x->right);
    x->swapped = make(unknowns, sizeof *x->swapped);
    x->direction = make(unknowns, sizeof *x->direction);
    x->columns = make(nodes + elements + 1, 15 * sizeof(lanes)); /* strain_matrix.c */
    if (!x->width || !x->points || !x->actuators || !x->at || !x->edges || !x->springs ||
        !x->matrix || !x->right || !x->swapped || !x->direction || !x->columns) {
        strain_form_free(x);
        *result = NULL;
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", nodes);
    }
    for (int e = 0; e < kind->elements; e++) {
        x->width[e] = kind->edges[e + 1] - kind->edges[e];
    }
    for (int i = 0; i < kind->stages; i++) {
        for (int j = 0; j < kind->stages; j++) {
            x->tail[i][j] = x->rule.weights[j] - x->rule.matrix[i][j];
        }
    }
    set_magnus(x);
    x->start_q[0] += 1;
    return AD_OK;
}

void strain_form_free(strain_form *x)
{
    if (x) {
        free(x->width);
        free(x->points);
        free(x->actuators);
        free(x->at);
        free(x->edges);
        free(x->springs);
        free(x->matrix);
        free(x->right);
        free(x->swapped);
        free(x->direction);
        free(x->columns);
        free(x);
    }
}

/* ---- elimination --------------------------------------------------------------------------- */

/* A diagonal entry that is this much smaller than one below it makes way, in its lane. Where none
 * is, as under moderate loads, lanes need not be looked at one by one. */
static const double PIVOT_LEAST = 0.01;

/* Swaps rows `a` and `b` in one lane, from column `from` on. */
static void swap_rows(strain_form *x, int lane, int from, int a, int b)
{
    const size_t n = (size_t)x->unknowns;
    for (size_t c = (size_t)from; c <= n; c++) {
        double *column = (double *)(c < n ? x->matrix + c * n : x->right);
        double *first = column + a * LANES + lane, *second = column + b * LANES + lane;
        double held = *first;
        *first = *second;
        *second = held;
    }
}

static void choose_pivots(strain_form *x, int k)
{
    const int n = x->unknowns;
    const double *column = (const double *)(x->matrix + (size_t)k * (size_t)n);
    for (int lane = 0; lane < LANES; lane++) {
        int best = k;
        for (int i = k + 1; i < n; i++) {
            best = fabs(column[i * LANES + lane]) > fabs(column[best * LANES + lane]) ? i : best;
        }
        if (fabs(column[k * LANES + lane]) < PIVOT_LEAST * fabs(column[best * LANES + lane])) {
            swap_rows(x, lane, k, k, best);
            x->swapped[k][lane] = best;
            x->negative[lane]++;
        }
    }
}

/* Whether in any lane an entry below the diagonal is much larger. */
STRAIN_INLINE bool needs_pivot(const lanes *column, int k, int n)
{
    const integer_lanes size = {0x7fffffffffffffffLL, 0x7fffffffffffffffLL, 0x7fffffffffffffffLL,
                                0x7fffffffffffffffLL, 0x7fffffffffffffffLL, 0x7fffffffffffffffLL,
                                0x7fffffffffffffffLL, 0x7fffffffffffffffLL};
    lanes limit = (lanes)((integer_lanes)column[k] & size) * (1 / PIVOT_LEAST);
    integer_lanes any = {0};
    for (int i = k + 1; i < n; i++) {
        any |= (lanes)((integer_lanes)column[i] & size) > limit;
    }
    long long sum = 0;
    for (int lane = 0; lane < LANES; lane++) {
        sum |= any[lane];
    }
    return sum != 0;
}

STRAIN_INLINE void substitute_back(strain_form *x)
{
    const int n = x->unknowns;
    for (int k = n - 1; k >= 0; k--) {
        const lanes *from = x->matrix + (size_t)k * (size_t)n, found = x->right[k] / from[k];
        x->right[k] = found;
        for (int i = 0; i < k; i++) {
            x->right[i] -= found * from[i];
        }
    }
}

/* Subtracts multiples of column k, below row k, from others and from the right side. */
FOR_EACH_PROCESSOR static void eliminate(strain_form *x)
{
    const int n = x->unknowns;
    integer_lanes negative = {0};
    memset(x->negative, 0, sizeof x->negative);
    for (int k = 0; k < n; k++) {
        lanes *from = x->matrix + (size_t)k * (size_t)n;
        for (int lane = 0; lane < LANES; lane++) {
            x->swapped[k][lane] = k;
        }
        if (needs_pivot(from, k, n)) {
            choose_pivots(x, k);
        }
        const lanes by = 1 / from[k];
        negative -= by < 0;
        for (int i = k + 1; i < n; i++) {
            from[i] *= by;
        }
        for (int c = k + 1; c <= n; c++) {
            lanes *to = c < n ? x->matrix + (size_t)c * (size_t)n : x->right;
            const lanes factor = to[k];
            for (int i = k + 1; i < n; i++) {
                to[i] -= factor * from[i];
            }
        }
    }
    for (int lane = 0; lane < LANES; lane++) {
        x->negative[lane] += (int)negative[lane];
    }
    substitute_back(x);
}

void strain_form_solve(strain_form *x)
{
    eliminate(x);
}

FOR_EACH_PROCESSOR static void solve_again(strain_form *x)
{
    const int n = x->unknowns;
    double *right = (double *)x->right;
    for (int k = 0; k < n; k++) {
        const lanes *from = x->matrix + (size_t)k * (size_t)n;
        for (int lane = 0; lane < LANES; lane++) {
            const int other = x->swapped[k][lane];
            const double held = right[k * LANES + lane];
            right[k * LANES + lane] = right[other * LANES + lane];
            right[other * LANES + lane] = held;
        }
        for (int i = k + 1; i < n; i++) {
            x->right[i] -= x->right[k] * from[i];
        }
    }
    substitute_back(x);
}

void strain_form_solve_again(strain_form *x)
{
    solve_again(x);
}
