#include "physics/solve/elements.h"

#include "autodiff/dense.h"
#include "physics/numerics/sort.h"

#include <stdlib.h>
#include <string.h>

void solve_elements_clear(solve_elements *mesh)
{
    ad_memory_free(&mesh->memory);
    if (mesh->band) {
        SUNDlsMat_destroyMat(mesh->band);
    }
}

ad_status solve_elements_make(int rows, int start_rows, int stages, int count, const double *edges,
                              solve_elements *mesh, ad_error *error)
{
    *mesh = (solve_elements){.rule = solve_gauss_rule_of(stages),
                             .count = count,
                             .stages = stages,
                             .rows = rows,
                             .start_rows = start_rows,
                             .end_rows = rows - start_rows,
                             .lower = start_rows + rows - 1,
                             .above = 3 * rows - 2}; /* 2 rows - 1 - start_rows without pivoting */
    const size_t elements = (size_t)count, points = elements * (size_t)stages;
    const size_t inner = elements_inner(mesh), outer = (elements + 1) * (size_t)rows;
    AD_TAKE(mesh, edges, elements + 1);
    AD_TAKE(mesh, points, points);
    AD_TAKE(mesh, by_y, points);
    AD_TAKE(mesh, across, elements);
    AD_TAKE(mesh, factor, elements * inner * inner);
    AD_TAKE(mesh, pivots, elements * inner);
    AD_TAKE(mesh, by_start, elements * inner * (size_t)rows);
    AD_TAKE(mesh, inner, elements * inner);
    AD_TAKE(mesh, part, elements * (size_t)rows);
    AD_TAKE(mesh, packed, inner * (size_t)rows);
    mesh->band = SUNDlsMat_newBandMat((sunindextype)outer, mesh->above, mesh->lower);
    AD_TAKE(mesh, band_pivots, outer);
    AD_TAKE(mesh, right, outer);
    if (!mesh->band || mesh->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", points);
    }
    memcpy(mesh->edges, edges, (elements + 1) * sizeof *edges);
    for (int i = 0; i < count * stages; i++) {
        const int e = i / stages;
        mesh->points[i] = edges[e] + elements_width(mesh, e) * mesh->rule.nodes[i % stages];
    }
    return ad_dense_load(error);
}

/* ---- places ---------------------------------------------------------------------------------- */

void solve_elements_places(const solve_elements *mesh, double *s)
{
    const double *from = mesh->points;
    *s++ = 0;
    for (int e = 0; e < mesh->count; e++) {
        for (int i = 0; i < mesh->stages; i++) {
            *s++ = *from++;
        }
        *s++ = mesh->edges[e + 1];
    }
}

int solve_elements_at(const solve_elements *mesh, double s)
{
    return (int)sort_cell((size_t)mesh->count, mesh->edges, s, true);
}

void solve_elements_interpolate(const solve_elements *mesh, int e, double s, size_t rows,
                                size_t stride, const double *values, double *y)
{
    double weights[GAUSS_STAGES_MAX + 2];
    solve_gauss_lagrange(&mesh->rule, (s - mesh->edges[e]) / elements_width(mesh, e), weights);
    memset(y, 0, rows * sizeof *y);
    for (int i = 0; i < mesh->stages + 2; i++, values += stride) {
        for (size_t k = 0; k < rows; k++) {
            y[k] += weights[i] * values[k];
        }
    }
}

/* ---- equations ------------------------------------------------------------------------------- */

void solve_elements_residual(const solve_elements *mesh, int e, const double *start,
                             const double *y, const double *rate, double *residual)
{
    const int rows = mesh->rows;
    const double h = elements_width(mesh, e);
    for (int i = 0; i <= mesh->stages; i++) { /* the last is the end of the element */
        const double *a = i < mesh->stages ? mesh->rule.matrix[i] : mesh->rule.weights;
        for (int k = 0; k < rows; k++) {
            double sum = 0;
            for (int j = 0; j < mesh->stages; j++) {
                sum += a[j] * rate[j * rows + k];
            }
            *residual++ = y[i * rows + k] - start[k] - h * sum;
        }
    }
}

/* Rows of an element's points: those whose rates no y changes, those that are solved for together,
 * and those on which no rate depends, which follow from the others. */
enum { GIVEN, COUPLED, FOLLOWS, PARTS };

/* part [rows]; returns how many are coupled. */
static int find_parts(solve_elements *mesh, int e)
{
    const int rows = mesh->rows;
    bool changes[ELEMENTS_ROWS_MAX] = {false}, counts[ELEMENTS_ROWS_MAX] = {false};
    int coupled = 0, *part = mesh->part + e * rows;
    for (int j = 0; j < mesh->stages; j++) {
        for (int r = 0; r < rows; r++) {
            const double *row = mesh->by_y[e * mesh->stages + j][r];
            for (int c = 0; c < rows; c++) {
                changes[r] |= row[c] != 0;
                counts[c] |= row[c] != 0;
            }
        }
    }
    for (int r = 0; r < rows; r++) {
        part[r] = !changes[r] ? GIVEN : counts[r] ? COUPLED : FOLLOWS;
        coupled += part[r] == COUPLED;
    }
    return coupled;
}

/* Of each part the rows; how many there are. */
static int rows_of(const solve_elements *mesh, int e, int part, int *rows)
{
    int count = 0;
    for (int r = 0; r < mesh->rows; r++) {
        if (mesh->part[e * mesh->rows + r] == part) {
            rows[count++] = r;
        }
    }
    return count;
}

/* I - h a_ij J_j of the coupled rows, column-major. */
static void fill_inner(const solve_elements *mesh, int e, double *matrix)
{
    int row[ELEMENTS_ROWS_MAX];
    const int rows = rows_of(mesh, e, COUPLED, row);
    const double h = elements_width(mesh, e);
    elements_matrix *by_y = mesh->by_y + e * mesh->stages;
    for (int j = 0; j < mesh->stages; j++) {
        double J[ELEMENTS_ROWS_MAX][ELEMENTS_ROWS_MAX]; /* by columns */
        for (int r = 0; r < rows; r++) {
            for (int c = 0; c < rows; c++) {
                J[c][r] = by_y[j][row[r]][row[c]];
            }
        }
        for (int c = 0; c < rows; c++) {
            for (int i = 0; i < mesh->stages; i++) {
                const double factor = -h * mesh->rule.matrix[i][j];
                for (int r = 0; r < rows; r++) {
                    matrix[r] = factor * J[c][r];
                }
                matrix[c] += i == j;
                matrix += rows;
            }
        }
    }
}

/* inner [stages][rows] of part `to` += h sum_j a_ij J_j inner_j of part `from`. */
static void add_inner(const solve_elements *mesh, int e, int from, int to, double *inner)
{
    int row[ELEMENTS_ROWS_MAX], column[ELEMENTS_ROWS_MAX];
    const int rows = rows_of(mesh, e, to, row), columns = rows_of(mesh, e, from, column);
    const double h = elements_width(mesh, e);
    double rate[GAUSS_STAGES_MAX][ELEMENTS_ROWS_MAX];
    if (rows == 0 || columns == 0) {
        return;
    }
    for (int j = 0; j < mesh->stages; j++) {
        for (int r = 0; r < rows; r++) {
            const double *by_y = mesh->by_y[e * mesh->stages + j][row[r]];
            double sum = 0;
            for (int c = 0; c < columns; c++) {
                sum += by_y[column[c]] * inner[j * mesh->rows + column[c]];
            }
            rate[j][r] = h * sum;
        }
    }
    for (int i = 0; i < mesh->stages; i++) {
        double sum[ELEMENTS_ROWS_MAX] = {0};
        for (int j = 0; j < mesh->stages; j++) {
            for (int r = 0; r < rows; r++) {
                sum[r] += mesh->rule.matrix[i][j] * rate[j][r];
            }
        }
        for (int r = 0; r < rows; r++) {
            inner[i * mesh->rows + row[r]] += sum[r];
        }
    }
}

/* inner [count][stages][rows]: right sides, then the solutions of an element that is factored. */
static void solve_inner(const solve_elements *mesh, int e, size_t count, double *inner)
{
    const size_t n = elements_inner(mesh);
    const double *factor = mesh->factor + (size_t)e * n * n;
    const int *pivots = mesh->pivots + (size_t)e * n;
    int row[ELEMENTS_ROWS_MAX];
    const int rows = rows_of(mesh, e, COUPLED, row);
    if (rows == mesh->rows) {
        ad_dense_lu_solve(n, count, factor, pivots, inner);
        return;
    }
    double *to = mesh->packed;
    for (size_t k = 0; k < count; k++) {
        add_inner(mesh, e, GIVEN, COUPLED, inner + k * n);
        for (int i = 0; i < mesh->stages; i++) {
            for (int r = 0; r < rows; r++) {
                *to++ = inner[k * n + (size_t)(i * mesh->rows + row[r])];
            }
        }
    }
    if (rows > 0) {
        ad_dense_lu_solve((size_t)mesh->stages * (size_t)rows, count, factor, pivots, mesh->packed);
    }
    const double *from = mesh->packed;
    for (size_t k = 0; k < count; k++) {
        for (int i = 0; i < mesh->stages; i++) {
            for (int r = 0; r < rows; r++) {
                inner[k * n + (size_t)(i * mesh->rows + row[r])] = *from++;
            }
        }
        add_inner(mesh, e, GIVEN, FOLLOWS, inner + k * n);
        add_inner(mesh, e, COUPLED, FOLLOWS, inner + k * n);
    }
}

/* to[rows] += h sum_j b_j J_j inner_j */
static void add_end(const solve_elements *mesh, int e, const double *inner, double *to)
{
    const int rows = mesh->rows;
    double h = elements_width(mesh, e);
    for (int j = 0; j < mesh->stages; j++) {
        const double *from = inner + j * rows, factor = h * mesh->rule.weights[j];
        for (int r = 0; r < rows; r++) {
            const double *row = mesh->by_y[e * mesh->stages + j][r];
            double sum = 0;
            for (int c = 0; c < rows; c++) {
                sum += row[c] * from[c];
            }
            to[r] += factor * sum;
        }
    }
}

static void put(solve_elements *mesh, int row, int column, double value)
{
    mesh->band[column][row - column + mesh->above] = value;
}

/* The equations of an element's end by y at its edges. */
static void put_element(solve_elements *mesh, int e, double nudge)
{
    const int rows = mesh->rows, row = mesh->start_rows + e * rows, column = e * rows;
    const size_t n = elements_inner(mesh);
    for (int c = 0; c < rows; c++) {
        double end[ELEMENTS_ROWS_MAX];
        for (int r = 0; r < rows; r++) {
            end[r] = mesh->across[e][r][c];
        }
        add_end(mesh, e, mesh->by_start + (size_t)(e * rows + c) * n, end);
        for (int r = 0; r < rows; r++) {
            put(mesh, row + r, column + c, -end[r]);
            put(mesh, row + r, column + rows + c, r == c ? 1 + nudge : 0);
        }
    }
}

static int factor_element(solve_elements *mesh, int e)
{
    const size_t n = elements_inner(mesh), rows = (size_t)mesh->rows;
    double *matrix = mesh->factor + (size_t)e * n * n;
    double *by_start = mesh->by_start + (size_t)e * n * rows;
    const int coupled = find_parts(mesh, e);
    fill_inner(mesh, e, matrix);
    if (coupled > 0 && ad_dense_lu((size_t)mesh->stages * (size_t)coupled, matrix,
                                   mesh->pivots + (size_t)e * n) != 0) {
        return 1;
    }
    for (size_t c = 0; c < rows; c++) {
        for (size_t i = 0; i < n; i++) {
            by_start[c * n + i] = mesh->across[e][i % rows][c];
        }
    }
    solve_inner(mesh, e, rows, by_start);
    return 0;
}

static bool factor_band(solve_elements *mesh, double nudge)
{
    const int rows = mesh->rows, size = (mesh->count + 1) * rows, last = size - rows;
    for (int c = 0; c < size; c++) {
        memset(mesh->band[c], 0, (size_t)(mesh->above + mesh->lower + 1) * sizeof **mesh->band);
    }
    for (int c = 0; c < rows; c++) {
        for (int r = 0; r < mesh->start_rows; r++) {
            put(mesh, r, c, mesh->start[r][c]);
        }
        for (int r = 0; r < mesh->end_rows; r++) {
            put(mesh, last + mesh->start_rows + r, last + c, mesh->end[r][c]);
        }
    }
    for (int e = 0; e < mesh->count; e++) {
        put_element(mesh, e, nudge);
    }
    return SUNDlsMat_bandGBTRF(mesh->band, size, mesh->above - mesh->lower, mesh->lower,
                               mesh->above, mesh->band_pivots) == 0;
}

/* A buckled column that may turn about its load has a singular matrix and no right side along that
 * turn. Whether a pivot is 0 or what rounding leaves of it must not matter. */
static const double NUDGE = 1e-12;

int solve_elements_factor(solve_elements *mesh)
{
    for (int e = 0; e < mesh->count; e++) {
        if (factor_element(mesh, e) != 0) {
            return 1;
        }
    }
    return !factor_band(mesh, 0) && !factor_band(mesh, NUDGE);
}

void solve_elements_solve(solve_elements *mesh, const double *right, double *step)
{
    size_t n = elements_inner(mesh), rows = (size_t)mesh->rows;
    int size = (mesh->count + 1) * mesh->rows;
    const double *from = right + mesh->start_rows;
    double *to = mesh->right + mesh->start_rows;
    memcpy(mesh->right, right, (size_t)mesh->start_rows * sizeof *right);
    for (int e = 0; e < mesh->count; e++, from += n + rows, to += rows) {
        double *inner = mesh->inner + (size_t)e * n;
        memcpy(inner, from, n * sizeof *from);
        solve_inner(mesh, e, 1, inner);
        memcpy(to, from + n, rows * sizeof *from);
        add_end(mesh, e, inner, to);
    }
    memcpy(to, from, (size_t)mesh->end_rows * sizeof *from);
    SUNDlsMat_bandGBTRS(mesh->band, size, mesh->above, mesh->lower, mesh->band_pivots, mesh->right);
    for (int e = 0; e <= mesh->count; e++) {
        const double *start = mesh->right + (size_t)e * rows;
        memcpy(step + elements_edge(mesh, e), start, rows * sizeof *start);
        for (size_t i = 0; e < mesh->count && i < n; i++) {
            double sum = mesh->inner[(size_t)e * n + i];
            for (size_t c = 0; c < rows; c++) {
                sum += mesh->by_start[((size_t)e * rows + c) * n + i] * start[c];
            }
            step[elements_edge(mesh, e) + rows + i] = sum;
        }
    }
}
