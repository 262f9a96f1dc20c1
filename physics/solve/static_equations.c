/* The equations of the static system where the path is, their derivatives, and a Newton step. */
#include "physics/solve/static_system_internal.h"

#include "autodiff/dense.h"

#include <stdlib.h>
#include <string.h>

/* What is given at one s where the path is; the section is that with its stretch. */
static static_point point_from(const static_system *system, double s, const solve_section *section,
                               const solve_rest *rest, const double *along,
                               const solve_actuator *actuators)
{
    static_point at = {.rest = *rest,
                       .acting = &system->rod->along,
                       .compliance = section->compliance,
                       .actuation = static_system_actuation(system, actuators, 0, s),
                       .tubes = system->rod->tubes};
    for (int k = 0; k < 3; k++) {
        at.rest.curvature[k] += system->path.imperfection * at.rest.imperfection[k];
    }
    acting_on_way(at.acting, along, system->path.load, way_of(&system->path), at.numbers);
    if (system->path.perturbation != 0) {
        double *force = at.numbers + at.acting->numbers;
        memset(force, 0, 3 * sizeof *force);
        force[system->path.director] = system->path.perturbation;
        at.acting = &system->perturbed;
    }
    return at;
}

static_point static_system_point(const static_system *system, size_t i)
{
    return point_from(system, system->points[i], &system->sections[i], &system->rest[i],
                      system->along + i * (size_t)system->rod->along.numbers,
                      system->actuators + i * (size_t)system->rod->actuators);
}

ad_status static_system_rates(const static_system *system, size_t n, const double *s,
                              const double *y, double *rate, ad_error *error)
{
    size_t pulling = (size_t)system->rod->actuators;
    solve_section *sections = malloc(n * sizeof *sections);
    solve_rest *rest = malloc(n * sizeof *rest);
    const size_t numbers = (size_t)system->rod->along.numbers;
    double *along = malloc((n * numbers + 1) * sizeof *along);
    solve_actuator *actuators = malloc((n * pulling + 1) * sizeof *actuators);
    ad_status status = sections && rest && along && actuators
                           ? solve_rod_sections(system->rod, n, s, sections, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", n);
    status = status == AD_OK ? solve_rod_rest(system->rod, n, s, 0, rest, error) : status;
    status = status == AD_OK ? solve_rod_along(system->rod, n, s, 0, along, error) : status;
    if (status == AD_OK && pulling > 0) {
        status = solve_rod_actuators(system->rod, n, s, 0, actuators, error);
    }
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        sections[i].compliance[2] += system->path.stretch;
        static_point at = point_from(system, s[i], &sections[i], &rest[i], along + i * numbers,
                                     actuators + i * pulling);
        static_rate(&at, y + i * (size_t)system->rows, rate + i * (size_t)system->rows, NULL);
    }
    free(sections);
    free(rest);
    free(along);
    free(actuators);
    return status;
}

static void add_length(const static_system *system, size_t point, double weight, const double *y,
                       double *excess)
{
    static_point at = static_system_point(system, point);
    double strains[ACTUATION_ROWS], rest[ACTUATION_ROWS];
    static_strains(&at, y, strains, strains + 3);
    memcpy(rest, system->rest[point].strain, 3 * sizeof *rest);
    memcpy(rest + 3, system->rest[point].curvature, 3 * sizeof *rest);
    for (int i = 0; i < system->rod->actuators; i++) {
        if (system->rod->extents[i].has_length) {
            excess[i] += weight * (solve_actuation_length(&at.actuation, i, strains) -
                                   solve_actuation_length(&at.actuation, i, rest));
        }
    }
}

void static_system_excess(const static_system *system, const double *y, double *excess)
{
    for (int i = 0; i < system->rod->actuators; i++) {
        excess[i] = system->path.load * solve_rod_displacement(system->rod, i, 0);
    }
    for (int e = 0; e < system->elements; e++) {
        for (int i = 0; i < system->stages; i++) {
            add_length(system, (size_t)e * system->stages + i,
                       width(system, e) * system->rule.weights[i],
                       y + edge(system, e) + (i + 1) * system->rows, excess);
        }
    }
}

/* ---- single places ------------------------------------------------------------------------- */

/* y beyond what acts at edge e, and its derivative by y there where by_y is not NULL. */
static void jump_over(const static_system *system, int e, const double *y, double *after,
                      jacobian by_y)
{
    if (system->jump[e] >= 0) {
        static_jump_over(&system->jumps[system->jump[e]], y, after, by_y);
        return;
    }
    memcpy(after, y, (size_t)system->rows * sizeof *after);
    for (int r = 0; r < system->rows && by_y; r++) {
        for (int c = 0; c < system->rows; c++) {
            by_y[r][c] = r == c;
        }
    }
}

int static_system_jump(const static_system *system, int edge)
{
    return system->jump[edge];
}

void static_system_start(const static_system *system, const double *y, int element, double *start)
{
    jump_over(system, element, y + edge(system, element), start, NULL);
}

/* Rows of the conditions at s = 1, which are about y beyond what acts there. */
static void end_residual(const static_system *system, const double *y, double *rows,
                         double (*by_y)[STATIC_ROWS_MAX])
{
    double after[STATIC_ROWS_MAX];
    jacobian across, by_after;
    jump_over(system, system->elements, y + edge(system, system->elements), after,
              by_y ? across : NULL);
    static_end_residual(&system->ends[1], 1, after, rows, by_after);
    for (int r = 0; r < system->end_rows && by_y; r++) {
        for (int c = 0; c < system->rows; c++) {
            by_y[r][c] = 0;
            for (int k = 0; k < system->rows; k++) {
                by_y[r][c] += by_after[r][k] * across[k][c];
            }
        }
    }
}

/* ---- residual and derivatives -------------------------------------------------------------- */

void static_system_residual(static_system *system, const double *y, double *residual)
{
    const int rows = system->rows;
    double unused[STATIC_END_ROWS_MAX][STATIC_ROWS_MAX], *to = residual + system->start_rows;
    static_end_residual(&system->ends[0], 0, y, residual, unused);
    for (int e = 0; e < system->elements; e++) {
        const double *inner = y + edge(system, e) + rows;
        double start[STATIC_ROWS_MAX], h = width(system, e),
                                       *rate = system->rate + (size_t)e * inner_rows(system);
        jump_over(system, e, y + edge(system, e), start, NULL);
        for (int i = 0; i < system->stages; i++) {
            static_point at = static_system_point(system, (size_t)e * system->stages + i);
            static_rate(&at, inner + i * rows, rate + i * rows, NULL);
        }
        for (int i = 0; i <= system->stages; i++) { /* the last is the end of the element */
            const double *a = i < system->stages ? system->rule.matrix[i] : system->rule.weights;
            for (int k = 0; k < rows; k++) {
                double sum = 0;
                for (int j = 0; j < system->stages; j++) {
                    sum += a[j] * rate[j * rows + k];
                }
                *to++ = inner[i * rows + k] - start[k] - h * sum;
            }
        }
    }
    end_residual(system, y, to, NULL);
}

void static_system_linearise(static_system *system, const double *y)
{
    double rows[STATIC_END_ROWS_MAX], rate[STATIC_ROWS_MAX];
    static_end_residual(&system->ends[0], 0, y, rows, system->start);
    end_residual(system, y, rows, system->end);
    for (int e = 0; e < system->elements; e++) {
        jump_over(system, e, y + edge(system, e), rate, system->across[e]);
        const double *inner = y + edge(system, e) + system->rows;
        for (int i = 0; i < system->stages; i++) {
            size_t p = (size_t)e * system->stages + i;
            static_point at = static_system_point(system, p);
            static_rate(&at, inner + i * system->rows, rate, system->by_y[p]);
        }
    }
}

/* I - h a_ij J_j, column-major. */
static void fill_inner(const static_system *system, int e, double *matrix)
{
    const int rows = system->rows;
    size_t n = inner_rows(system);
    double h = width(system, e);
    jacobian *by_y = system->by_y + e * system->stages;
    for (int j = 0; j < system->stages; j++) {
        for (int c = 0; c < rows; c++) {
            double *to = matrix + (size_t)(j * rows + c) * n;
            for (int i = 0; i < system->stages; i++) {
                double factor = -h * system->rule.matrix[i][j];
                for (int r = 0; r < rows; r++) {
                    *to++ = factor * by_y[j][r][c] + (i == j && r == c);
                }
            }
        }
    }
}

/* to[rows] += h sum_j b_j J_j inner_j */
static void add_end(const static_system *system, int e, const double *inner, double *to)
{
    const int rows = system->rows;
    double h = width(system, e);
    for (int j = 0; j < system->stages; j++) {
        const double *from = inner + j * rows, factor = h * system->rule.weights[j];
        for (int r = 0; r < rows; r++) {
            const double *row = system->by_y[e * system->stages + j][r];
            double sum = 0;
            for (int c = 0; c < rows; c++) {
                sum += row[c] * from[c];
            }
            to[r] += factor * sum;
        }
    }
}

static void put(static_system *system, int row, int column, double value)
{
    system->band[column][row - column + system->above] = value;
}

static int factor_element(static_system *system, int e)
{
    const int rows = system->rows;
    size_t n = inner_rows(system), all = n * (size_t)rows;
    double *matrix = system->factor + (size_t)e * n * n,
           *by_start = system->by_start + (size_t)e * all;
    int *pivots = system->pivots + (size_t)e * n, row = system->start_rows + e * rows,
        column = e * rows;
    fill_inner(system, e, matrix);
    if (ad_dense_lu(n, matrix, pivots) != 0) {
        return 1;
    }
    for (int c = 0; c < rows; c++) {
        for (size_t i = 0; i < n; i++) {
            by_start[(size_t)c * n + i] = system->across[e][i % (size_t)rows][c];
        }
    }
    ad_dense_lu_solve(n, (size_t)rows, matrix, pivots, by_start);
    for (int c = 0; c < rows; c++) {
        double end[STATIC_ROWS_MAX];
        for (int r = 0; r < rows; r++) {
            end[r] = system->across[e][r][c];
        }
        add_end(system, e, by_start + (size_t)c * n, end);
        for (int r = 0; r < rows; r++) {
            put(system, row + r, column + c, -end[r]);
            put(system, row + r, column + rows + c, r == c);
        }
    }
    return 0;
}

int static_system_factor(static_system *system)
{
    const int rows = system->rows;
    int size = (system->elements + 1) * rows, last = size - rows;
    for (int c = 0; c < size; c++) {
        memset(system->band[c], 0,
               (size_t)(system->above + system->lower + 1) * sizeof **system->band);
    }
    for (int c = 0; c < rows; c++) {
        for (int r = 0; r < system->start_rows; r++) {
            put(system, r, c, system->start[r][c]);
        }
        for (int r = 0; r < system->end_rows; r++) {
            put(system, last + system->start_rows + r, last + c, system->end[r][c]);
        }
    }
    for (int e = 0; e < system->elements; e++) {
        if (factor_element(system, e) != 0) {
            return 1;
        }
    }
    return SUNDlsMat_bandGBTRF(system->band, size, system->above - system->lower, system->lower,
                               system->above, system->band_pivots) != 0;
}

void static_system_solve(static_system *system, const double *right, double *step)
{
    size_t n = inner_rows(system), rows = (size_t)system->rows;
    int size = (system->elements + 1) * system->rows;
    const double *from = right + system->start_rows;
    double *to = system->right + system->start_rows;
    memcpy(system->right, right, (size_t)system->start_rows * sizeof *right);
    for (int e = 0; e < system->elements; e++, from += n + rows, to += rows) {
        double *inner = system->inner + (size_t)e * n;
        memcpy(inner, from, n * sizeof *from);
        ad_dense_lu_solve(n, 1, system->factor + (size_t)e * n * n, system->pivots + (size_t)e * n,
                          inner);
        memcpy(to, from + n, rows * sizeof *from);
        add_end(system, e, inner, to);
    }
    memcpy(to, from, (size_t)system->end_rows * sizeof *from);
    SUNDlsMat_bandGBTRS(system->band, size, system->above, system->lower, system->band_pivots,
                        system->right);
    for (int e = 0; e <= system->elements; e++) {
        const double *start = system->right + (size_t)e * rows;
        memcpy(step + edge(system, e), start, rows * sizeof *start);
        for (size_t i = 0; e < system->elements && i < n; i++) {
            double sum = system->inner[(size_t)e * n + i];
            for (size_t c = 0; c < rows; c++) {
                sum += system->by_start[((size_t)e * rows + c) * n + i] * start[c];
            }
            step[edge(system, e) + rows + i] = sum;
        }
    }
}
