/* The equations of the static system where the path is, their derivatives, and a Newton step. */
#include "physics/solve/static_system_internal.h"

#include "autodiff/dense.h"

#include <stdlib.h>
#include <string.h>

/* What is given at one s where the path is; the section is that with its stretch. */
static static_point point_from(const static_system *x, double s, const solve_section *section,
                               const solve_rest *rest, const double *along,
                               const solve_actuator *actuators)
{
    static_point at = {.rest = *rest,
                       .acting = &x->rod->along,
                       .compliance = section->compliance,
                       .actuation = static_system_actuation(x, actuators, 0, s),
                       .tubes = x->rod->tubes};
    for (int k = 0; k < 3; k++) {
        at.rest.curvature[k] += x->path.imperfection * at.rest.imperfection[k];
    }
    acting_on_way(at.acting, along, x->path.load, way_of(&x->path), at.numbers);
    if (x->path.perturbation != 0) {
        double *force = at.numbers + at.acting->numbers;
        memset(force, 0, 3 * sizeof *force);
        force[x->path.director] = x->path.perturbation;
        at.acting = &x->perturbed;
    }
    return at;
}

static_point static_system_point(const static_system *x, size_t i)
{
    return point_from(x, x->points[i], &x->sections[i], &x->rest[i],
                      x->along + i * (size_t)x->rod->along.numbers,
                      x->actuators + i * (size_t)x->rod->actuators);
}

ad_status static_system_rates(const static_system *x, size_t n, const double *s, const double *y,
                              double *rate, ad_error *error)
{
    size_t pulling = (size_t)x->rod->actuators;
    solve_section *sections = malloc(n * sizeof *sections);
    solve_rest *rest = malloc(n * sizeof *rest);
    const size_t numbers = (size_t)x->rod->along.numbers;
    double *along = malloc((n * numbers + 1) * sizeof *along);
    solve_actuator *actuators = malloc((n * pulling + 1) * sizeof *actuators);
    ad_status status = sections && rest && along && actuators
                           ? solve_rod_sections(x->rod, n, s, sections, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    status = status == AD_OK ? solve_rod_rest(x->rod, n, s, 0, rest, error) : status;
    status = status == AD_OK ? solve_rod_along(x->rod, n, s, 0, along, error) : status;
    if (status == AD_OK && pulling > 0) {
        status = solve_rod_actuators(x->rod, n, s, 0, actuators, error);
    }
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        sections[i].compliance[2] += x->path.stretch;
        static_point at = point_from(x, s[i], &sections[i], &rest[i], along + i * numbers,
                                     actuators + i * pulling);
        static_rate(&at, y + i * (size_t)x->rows, rate + i * (size_t)x->rows, NULL);
    }
    free(sections);
    free(rest);
    free(along);
    free(actuators);
    return status;
}

static void add_length(const static_system *x, size_t point, double weight, const double *y,
                       double *excess)
{
    static_point at = static_system_point(x, point);
    double strains[ACTUATION_ROWS], rest[ACTUATION_ROWS];
    static_strains(&at, y, strains, strains + 3);
    memcpy(rest, x->rest[point].strain, 3 * sizeof *rest);
    memcpy(rest + 3, x->rest[point].curvature, 3 * sizeof *rest);
    for (int i = 0; i < x->rod->actuators; i++) {
        if (x->rod->extents[i].has_length) {
            excess[i] += weight * (solve_actuation_length(&at.actuation, i, strains) -
                                   solve_actuation_length(&at.actuation, i, rest));
        }
    }
}

void static_system_excess(const static_system *x, const double *y, double *excess)
{
    for (int i = 0; i < x->rod->actuators; i++) {
        excess[i] = x->path.load * solve_rod_displacement(x->rod, i, 0);
    }
    for (int e = 0; e < x->elements; e++) {
        for (int i = 0; i < x->stages; i++) {
            add_length(x, (size_t)e * x->stages + i, width(x, e) * x->rule.weights[i],
                       y + edge(x, e) + (i + 1) * x->rows, excess);
        }
    }
}

/* ---- single places ------------------------------------------------------------------------- */

/* y beyond what acts at edge e, and its derivative by y there where by_y is not NULL. */
static void jump_over(const static_system *x, int e, const double *y, double *after, jacobian by_y)
{
    if (x->jump[e] >= 0) {
        static_jump_over(&x->jumps[x->jump[e]], y, after, by_y);
        return;
    }
    memcpy(after, y, (size_t)x->rows * sizeof *after);
    for (int r = 0; r < x->rows && by_y; r++) {
        for (int c = 0; c < x->rows; c++) {
            by_y[r][c] = r == c;
        }
    }
}

int static_system_jump(const static_system *x, int edge)
{
    return x->jump[edge];
}

void static_system_start(const static_system *x, const double *y, int element, double *start)
{
    jump_over(x, element, y + edge(x, element), start, NULL);
}

/* Rows of the conditions at s = 1, which are about y beyond what acts there. */
static void end_residual(const static_system *x, const double *y, double *rows,
                         double (*by_y)[STATIC_ROWS_MAX])
{
    double after[STATIC_ROWS_MAX];
    jacobian across, by_after;
    jump_over(x, x->elements, y + edge(x, x->elements), after, by_y ? across : NULL);
    static_end_residual(&x->ends[1], 1, after, rows, by_after);
    for (int r = 0; r < x->end_rows && by_y; r++) {
        for (int c = 0; c < x->rows; c++) {
            by_y[r][c] = 0;
            for (int k = 0; k < x->rows; k++) {
                by_y[r][c] += by_after[r][k] * across[k][c];
            }
        }
    }
}

/* ---- residual and derivatives -------------------------------------------------------------- */

void static_system_residual(static_system *x, const double *y, double *residual)
{
    const int rows = x->rows;
    double unused[STATIC_END_ROWS_MAX][STATIC_ROWS_MAX], *to = residual + x->start_rows;
    static_end_residual(&x->ends[0], 0, y, residual, unused);
    for (int e = 0; e < x->elements; e++) {
        const double *inner = y + edge(x, e) + rows;
        double start[STATIC_ROWS_MAX], h = width(x, e), *rate = x->rate + (size_t)e * inner_rows(x);
        jump_over(x, e, y + edge(x, e), start, NULL);
        for (int i = 0; i < x->stages; i++) {
            static_point at = static_system_point(x, (size_t)e * x->stages + i);
            static_rate(&at, inner + i * rows, rate + i * rows, NULL);
        }
        for (int i = 0; i <= x->stages; i++) { /* the last is the end of the element */
            const double *a = i < x->stages ? x->rule.matrix[i] : x->rule.weights;
            for (int k = 0; k < rows; k++) {
                double sum = 0;
                for (int j = 0; j < x->stages; j++) {
                    sum += a[j] * rate[j * rows + k];
                }
                *to++ = inner[i * rows + k] - start[k] - h * sum;
            }
        }
    }
    end_residual(x, y, to, NULL);
}

void static_system_linearise(static_system *x, const double *y)
{
    double rows[STATIC_END_ROWS_MAX], rate[STATIC_ROWS_MAX];
    static_end_residual(&x->ends[0], 0, y, rows, x->start);
    end_residual(x, y, rows, x->end);
    for (int e = 0; e < x->elements; e++) {
        jump_over(x, e, y + edge(x, e), rate, x->across[e]);
        const double *inner = y + edge(x, e) + x->rows;
        for (int i = 0; i < x->stages; i++) {
            size_t p = (size_t)e * x->stages + i;
            static_point at = static_system_point(x, p);
            static_rate(&at, inner + i * x->rows, rate, x->by_y[p]);
        }
    }
}

/* I - h a_ij J_j, column-major. */
static void fill_inner(const static_system *x, int e, double *matrix)
{
    const int rows = x->rows;
    size_t n = inner_rows(x);
    double h = width(x, e);
    jacobian *by_y = x->by_y + e * x->stages;
    for (int j = 0; j < x->stages; j++) {
        for (int c = 0; c < rows; c++) {
            double *to = matrix + (size_t)(j * rows + c) * n;
            for (int i = 0; i < x->stages; i++) {
                double factor = -h * x->rule.matrix[i][j];
                for (int r = 0; r < rows; r++) {
                    *to++ = factor * by_y[j][r][c] + (i == j && r == c);
                }
            }
        }
    }
}

/* to[rows] += h sum_j b_j J_j inner_j */
static void add_end(const static_system *x, int e, const double *inner, double *to)
{
    const int rows = x->rows;
    double h = width(x, e);
    for (int j = 0; j < x->stages; j++) {
        const double *from = inner + j * rows, factor = h * x->rule.weights[j];
        for (int r = 0; r < rows; r++) {
            const double *row = x->by_y[e * x->stages + j][r];
            double sum = 0;
            for (int c = 0; c < rows; c++) {
                sum += row[c] * from[c];
            }
            to[r] += factor * sum;
        }
    }
}

static void put(static_system *x, int row, int column, double value)
{
    x->band[column][row - column + x->above] = value;
}

static int factor_element(static_system *x, int e)
{
    const int rows = x->rows;
    size_t n = inner_rows(x), all = n * (size_t)rows;
    double *matrix = x->factor + (size_t)e * n * n, *by_start = x->by_start + (size_t)e * all;
    int *pivots = x->pivots + (size_t)e * n, row = x->start_rows + e * rows, column = e * rows;
    fill_inner(x, e, matrix);
    if (ad_dense_lu(n, matrix, pivots) != 0) {
        return 1;
    }
    for (int c = 0; c < rows; c++) {
        for (size_t i = 0; i < n; i++) {
            by_start[(size_t)c * n + i] = x->across[e][i % (size_t)rows][c];
        }
    }
    ad_dense_lu_solve(n, (size_t)rows, matrix, pivots, by_start);
    for (int c = 0; c < rows; c++) {
        double end[STATIC_ROWS_MAX];
        for (int r = 0; r < rows; r++) {
            end[r] = x->across[e][r][c];
        }
        add_end(x, e, by_start + (size_t)c * n, end);
        for (int r = 0; r < rows; r++) {
            put(x, row + r, column + c, -end[r]);
            put(x, row + r, column + rows + c, r == c);
        }
    }
    return 0;
}

int static_system_factor(static_system *x)
{
    const int rows = x->rows;
    int size = (x->elements + 1) * rows, last = size - rows;
    for (int c = 0; c < size; c++) {
        memset(x->band[c], 0, (size_t)(x->above + x->lower + 1) * sizeof **x->band);
    }
    for (int c = 0; c < rows; c++) {
        for (int r = 0; r < x->start_rows; r++) {
            put(x, r, c, x->start[r][c]);
        }
        for (int r = 0; r < x->end_rows; r++) {
            put(x, last + x->start_rows + r, last + c, x->end[r][c]);
        }
    }
    for (int e = 0; e < x->elements; e++) {
        if (factor_element(x, e) != 0) {
            return 1;
        }
    }
    return SUNDlsMat_bandGBTRF(x->band, size, x->above - x->lower, x->lower, x->above,
                               x->band_pivots) != 0;
}

void static_system_solve(static_system *x, const double *right, double *step)
{
    size_t n = inner_rows(x), rows = (size_t)x->rows;
    int size = (x->elements + 1) * x->rows;
    const double *from = right + x->start_rows;
    double *to = x->right + x->start_rows;
    memcpy(x->right, right, (size_t)x->start_rows * sizeof *right);
    for (int e = 0; e < x->elements; e++, from += n + rows, to += rows) {
        double *inner = x->inner + (size_t)e * n;
        memcpy(inner, from, n * sizeof *from);
        ad_dense_lu_solve(n, 1, x->factor + (size_t)e * n * n, x->pivots + (size_t)e * n, inner);
        memcpy(to, from + n, rows * sizeof *from);
        add_end(x, e, inner, to);
    }
    memcpy(to, from, (size_t)x->end_rows * sizeof *from);
    SUNDlsMat_bandGBTRS(x->band, size, x->above, x->lower, x->band_pivots, x->right);
    for (int e = 0; e <= x->elements; e++) {
        const double *start = x->right + (size_t)e * rows;
        memcpy(step + edge(x, e), start, rows * sizeof *start);
        for (size_t i = 0; e < x->elements && i < n; i++) {
            double sum = x->inner[(size_t)e * n + i];
            for (size_t c = 0; c < rows; c++) {
                sum += x->by_start[((size_t)e * rows + c) * n + i] * start[c];
            }
            step[edge(x, e) + rows + i] = sum;
        }
    }
}
