#include "physics/solve/defect.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FEW = 6 };

/* Points in an element, with the integral each belongs to. */
typedef struct dense {
    size_t count, room, rows;
    double *s, *weight, *y, *rate; /* [room], [room], [room][rows], [room][rows] */
    int *part;                     /* [room] */
} dense;

static void dense_free(dense *dense)
{
    free(dense->s);
    free(dense->weight);
    free(dense->y);
    free(dense->rate);
    free(dense->part);
}

static bool grow(dense *dense, size_t more)
{
    if (dense->count + more <= dense->room) {
        return true;
    }
    size_t room = 2 * (dense->count + more);
    double **all[] = {&dense->s, &dense->weight, &dense->y, &dense->rate};
    const size_t rows[] = {1, 1, dense->rows, dense->rows};
    for (int i = 0; i < 4; i++) {
        double *bigger = realloc(*all[i], room * rows[i] * sizeof *bigger);
        if (!bigger) {
            return false;
        }
        *all[i] = bigger;
    }
    int *part = realloc(dense->part, room * sizeof *part);
    dense->part = part ? part : dense->part;
    dense->room = part ? room : dense->room;
    return part != NULL;
}

/* From one point of an element to the next: as many points as there are on a panel, or few where
 * it is a small part of one. */
static bool add_part(dense *to, const solve_quadrature *quadrature, const gauss_rule *few, int part,
                     double first, double last)
{
    for (double at = first, next; at < last; at = next) {
        const double *panel = quadrature->edges + solve_quadrature_panel(quadrature, at);
        next = fmin(last, panel[1]);
        const gauss_rule *rule = next - at < (panel[1] - panel[0]) / 4 ? few : &quadrature->rule;
        if (!grow(to, (size_t)rule->stages)) {
            return false;
        }
        for (int i = 0; i < rule->stages; i++) {
            to->s[to->count] = at + (next - at) * rule->nodes[i];
            to->weight[to->count] = (next - at) * rule->weights[i];
            to->part[to->count++] = part;
        }
    }
    return true;
}

static bool add_element(dense *to, const solve_quadrature *quadrature, const gauss_rule *rule,
                        const double *edges)
{
    const gauss_rule few = solve_gauss_rule_of(FEW);
    double width = edges[1] - edges[0], from = edges[0];
    for (int i = 0; i <= rule->stages; i++) {
        double next = i < rule->stages ? edges[0] + width * rule->nodes[i] : edges[1];
        if (!add_part(to, quadrature, &few, i, from, next)) {
            return false;
        }
        from = next;
    }
    return true;
}

static void compare(const dense *points, const gauss_rule *rule, const double *values,
                    double *residual)
{
    double sum[GAUSS_STAGES_MAX + 1][ELEMENTS_ROWS_MAX] = {{0}}, so_far[ELEMENTS_ROWS_MAX] = {0};
    size_t rows = points->rows;
    for (size_t i = 0; i < points->count; i++) {
        for (size_t k = 0; k < rows; k++) {
            sum[points->part[i]][k] += points->weight[i] * points->rate[i * rows + k];
        }
    }
    for (size_t i = 0; i <= (size_t)rule->stages; i++) {
        for (size_t k = 0; k < rows; k++) {
            so_far[k] += sum[i][k];
            residual[i * rows + k] = values[(i + 1) * rows + k] - values[k] - so_far[k];
        }
    }
}

ad_status solve_defect(const solve_quadrature *quadrature, const solve_equations *equations,
                       const solve_elements *mesh, int element, const double *values,
                       double *residual, ad_error *error)
{
    dense points = {.rows = (size_t)mesh->rows};
    bool made = add_element(&points, quadrature, &mesh->rule, mesh->edges + element);
    ad_status status =
        made ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for points between nodes");
    for (size_t i = 0; i < points.count && status == AD_OK; i++) {
        solve_elements_interpolate(mesh, element, points.s[i], points.rows, points.rows, values,
                                   points.y + i * points.rows);
    }
    if (status == AD_OK) {
        status = equations->rate(equations->context, points.count, points.s, points.y, points.rate,
                                 error);
    }
    if (status == AD_OK) {
        compare(&points, &mesh->rule, values, residual);
    }
    dense_free(&points);
    return status;
}
