#include "physics/solve/static_defect.h"

#include "physics/solve/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = STATIC_ROWS, FEW = 6 };

/* Points in an element, with the integral each belongs to. */
typedef struct dense {
    size_t count, room;
    double *s, *weight, *y, *rate; /* [room], [room], [room][ROWS], [room][ROWS] */
    int *part;                     /* [room] */
} dense;

static void dense_free(dense *x)
{
    free(x->s);
    free(x->weight);
    free(x->y);
    free(x->rate);
    free(x->part);
}

static bool grow(dense *x, size_t more)
{
    if (x->count + more <= x->room) {
        return true;
    }
    size_t room = 2 * (x->count + more);
    double **all[] = {&x->s, &x->weight, &x->y, &x->rate};
    const size_t rows[] = {1, 1, ROWS, ROWS};
    for (int i = 0; i < 4; i++) {
        double *bigger = realloc(*all[i], room * rows[i] * sizeof *bigger);
        if (!bigger) {
            return false;
        }
        *all[i] = bigger;
    }
    int *part = realloc(x->part, room * sizeof *part);
    x->part = part ? part : x->part;
    x->room = part ? room : x->room;
    return part != NULL;
}

/* From one point of an element to the next: as many points as there are on a panel, or few where
 * it is a small part of one. */
static bool add_part(dense *x, const solve_quadrature *quadrature, const gauss_rule *few, int part,
                     double first, double last)
{
    for (double at = first, next; at < last; at = next) {
        int panel = solve_quadrature_panel(quadrature, at);
        const double *edges = quadrature->edges + panel;
        next = fmin(last, edges[1]);
        const gauss_rule *rule = next - at < (edges[1] - edges[0]) / 4 ? few : &quadrature->rule;
        if (!grow(x, (size_t)rule->stages)) {
            return false;
        }
        for (int i = 0; i < rule->stages; i++) {
            x->s[x->count] = at + (next - at) * rule->nodes[i];
            x->weight[x->count] = (next - at) * rule->weights[i];
            x->part[x->count++] = part;
        }
    }
    return true;
}

static double point_of(const gauss_rule *rule, int i)
{
    return i == 0 ? 0 : i > rule->stages ? 1 : rule->nodes[i - 1];
}

/* values [stages + 2][ROWS] at the points 0, c, 1 of an element. */
static void interpolate(const gauss_rule *rule, const double *values, double x, double *y)
{
    double weights[GAUSS_STAGES_MAX + 2];
    solve_gauss_lagrange(rule, x, weights);
    memset(y, 0, ROWS * sizeof *y);
    for (int i = 0; i < rule->stages + 2; i++) {
        for (int k = 0; k < ROWS; k++) {
            y[k] += weights[i] * values[i * ROWS + k];
        }
    }
}

/* Adds to the rows of an element the integral by its own rule, takes that by the dense points. */
static void exchange(const gauss_rule *rule, double width, const double *own, const dense *x,
                     double *rows)
{
    double sum[GAUSS_STAGES_MAX + 1][ROWS] = {{0}}, so_far[ROWS] = {0};
    for (size_t i = 0; i < x->count; i++) {
        for (int k = 0; k < ROWS; k++) {
            sum[x->part[i]][k] += x->weight[i] * x->rate[i * ROWS + (size_t)k];
        }
    }
    for (int i = 0; i <= rule->stages; i++) {
        const double *a = i < rule->stages ? rule->matrix[i] : rule->weights;
        for (int k = 0; k < ROWS; k++) {
            so_far[k] += sum[i][k];
            rows[i * ROWS + k] -= so_far[k];
            for (int j = 0; j < rule->stages; j++) {
                rows[i * ROWS + k] += width * a[j] * own[j * ROWS + k];
            }
        }
    }
}

static ad_status look_between(const static_system *x, const solve_quadrature *quadrature,
                              const gauss_rule *few, const double *y, int element, dense *points,
                              double *rows, ad_error *error)
{
    const gauss_rule *rule = static_system_rule(x);
    const double *edges = static_system_edges(x) + element;
    size_t stages = (size_t)rule->stages;
    double values[(GAUSS_STAGES_MAX + 2) * ROWS], own[GAUSS_STAGES_MAX * ROWS];
    double s[GAUSS_STAGES_MAX], width = edges[1] - edges[0];
    static_system_start(x, y, element, values);
    memcpy(values + ROWS, y + ((size_t)element * (stages + 1) + 1) * ROWS,
           (stages + 1) * ROWS * sizeof *values);
    points->count = 0;
    for (int i = 0; i <= rule->stages; i++) {
        double first = edges[0] + width * point_of(rule, i);
        double last = i < rule->stages ? edges[0] + width * rule->nodes[i] : edges[1];
        if (i < rule->stages) {
            s[i] = last;
        }
        if (!add_part(points, quadrature, few, i, first, last)) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for points between nodes");
        }
    }
    for (size_t i = 0; i < points->count; i++) {
        interpolate(rule, values, (points->s[i] - edges[0]) / width, points->y + i * ROWS);
    }
    ad_status status =
        static_system_rates(x, points->count, points->s, points->y, points->rate, error);
    if (status == AD_OK) {
        status = static_system_rates(x, stages, s, values + ROWS, own, error);
    }
    if (status == AD_OK) {
        exchange(rule, width, own, points, rows);
    }
    return status;
}

/* Of a correction of y. */
static double largest(size_t unknowns, const double *y, const double *step)
{
    double result = 0;
    for (size_t i = 0; i < unknowns; i += ROWS) {
        double turn[4], position = sqrt(vector_dot(step + i, step + i));
        quaternion_quotient(y + i + STATIC_Q, step + i + STATIC_Q, turn);
        double off = fmax(position, 2 * fabs(turn[3]));
        if (!isfinite(position) || !isfinite(turn[3])) {
            return INFINITY;
        }
        result = fmax(result, off);
    }
    return result;
}

ad_status static_defect(static_system *x, const solve_quadrature *quadrature, const double *y,
                        double *error_of_y, ad_error *error)
{
    size_t unknowns = static_system_unknowns(x);
    size_t stride = ((size_t)static_system_rule(x)->stages + 1) * ROWS;
    const gauss_rule few = solve_gauss_rule_of(FEW);
    double *rows = malloc(2 * unknowns * sizeof *rows), *step = rows + unknowns;
    dense points = {0};
    ad_status status = rows ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    *error_of_y = INFINITY;
    if (status == AD_OK) {
        static_system_residual(x, y, rows);
    }
    for (int e = 0; e < static_system_elements(x) && status == AD_OK; e++) {
        status = look_between(x, quadrature, &few, y, e, &points,
                              rows + STATIC_START_ROWS + (size_t)e * stride, error);
    }
    if (status == AD_OK) {
        static_system_solve(x, rows, step);
        *error_of_y = largest(unknowns, y, step);
    }
    dense_free(&points);
    free(rows);
    return status;
}
