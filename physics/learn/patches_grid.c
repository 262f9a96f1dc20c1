/* Patches, their functions, and what these are at points. */
#include "physics/learn/patches_internal.h"

#include "physics/numerics/gauss.h"
#include "physics/numerics/sort.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- grids ----------------------------------------------------------------------------------- */

/* The coordinate with the most cells is the slowest, so that neighbours are close to each other. */
static void number_patches(patch_grid *grid)
{
    int left[PATCH_DIMS];
    for (int d = 0; d < grid->dims; d++) {
        left[d] = d;
    }
    grid->patches = 1;
    for (int i = 0; i < grid->dims; i++) {
        int least = i;
        for (int k = i + 1; k < grid->dims; k++) {
            least = grid->cells[left[k]] < grid->cells[left[least]] ? k : least;
        }
        const int d = left[least];
        left[least] = left[i];
        grid->stride[d] = grid->patches;
        grid->patches *= grid->cells[d];
    }
}

bool patch_grid_create(patch_grid *grid, int dims, int outputs, const int *cells,
                       double *const *edges, const int *degree)
{
    *grid = (patch_grid){.dims = dims, .outputs = outputs, .functions = 1};
    for (int d = 0; d < dims; d++) {
        const size_t size = ((size_t)cells[d] + 1) * sizeof **grid->edge;
        grid->cells[d] = cells[d];
        grid->degree[d] = degree[d];
        grid->functions *= degree[d] + 1;
        if (AD_TAKE(grid, edge[d], cells[d] + 1)) {
            memcpy(grid->edge[d], edges[d], size);
        }
    }
    number_patches(grid);
    AD_TAKE(grid, c, (size_t)grid->patches * patch_grid_size(grid));
    AD_TAKE(grid, missed, grid->patches);
    if (grid->memory.is_short) {
        patch_grid_clear(grid);
        return false;
    }
    return true;
}

void patch_grid_clear(patch_grid *grid)
{
    ad_memory_free(&grid->memory);
    free(grid->slopes);
    *grid = (patch_grid){.dims = 0};
}

double patch_half(const patch_grid *grid, int patch, int coordinate)
{
    const double *edge = grid->edge[coordinate] + patch_cell(grid, patch, coordinate);
    return (edge[1] - edge[0]) / 2;
}

double patch_volume(const patch_grid *grid, int patch)
{
    double volume = 1;
    for (int d = 0; d < grid->dims; d++) {
        volume *= 2 * patch_half(grid, patch, d);
    }
    return volume;
}

double patch_grid_volume(const patch_grid *grid)
{
    double volume = 0;
    for (int k = 0; k < grid->patches; k++) {
        volume += patch_volume(grid, k);
    }
    return volume;
}

double patch_share(const patch_grid *grid, int patch, const bool *holds)
{
    double share = 1;
    for (int d = 0; d < grid->dims; d++) {
        if (!holds[d]) {
            share *=
                2 * patch_half(grid, patch, d) / (grid->edge[d][grid->cells[d]] - grid->edge[d][0]);
        }
    }
    return share;
}

double patch_place(const patch_grid *grid, int patch, int coordinate, double local)
{
    const double *edge = grid->edge[coordinate] + patch_cell(grid, patch, coordinate);
    return edge[0] + (edge[1] - edge[0]) * (1 + local) / 2;
}

double patch_scale(const patch_grid *grid, int patch, const unsigned char *order)
{
    double scale = 1;
    for (int d = 0; d < grid->dims; d++) {
        for (int k = 0; k < order[d]; k++) {
            scale /= patch_half(grid, patch, d);
        }
    }
    return scale;
}

/* ---- functions ------------------------------------------------------------------------------- */

/* values [degree + 1]: derivatives of that order of (2k + 1)^(1/2) P_k at x. */
static void legendre(int degree, int order, double x, double *values)
{
    double row[2][PATCH_DEGREE + 1];
    double *now = row[0], *lower = row[1];
    gauss_legendre(degree, x, now);
    for (int m = 1; m <= order; m++) {
        double *swap = lower;
        lower = now;
        now = swap;
        for (int k = 0; k <= degree; k++) {
            now[k] = (k > 1 ? now[k - 2] : 0) + (k > 0 ? (2 * k - 1) * lower[k - 1] : 0);
        }
    }
    for (int k = 0; k <= degree; k++) {
        values[k] = sqrt(2 * k + 1.0) * now[k];
    }
}

int patch_degree(const patch_grid *grid, int function, int coordinate)
{
    for (int d = grid->dims - 1; d > coordinate; d--) {
        function /= grid->degree[d] + 1;
    }
    return function % (grid->degree[coordinate] + 1);
}

void patch_table_clear(patch_table *table)
{
    ad_memory_free(&table->memory);
    *table = (patch_table){.points = 0};
}

bool patch_table_at(patch_table *table, const patch_grid *grid, const patch_jets *jets,
                    const bool *wanted, int points, const double *local)
{
    const size_t n = (size_t)points;
    double line[PATCH_DIMS][PATCH_DEGREE + 1];
    *table = (patch_table){.points = points};
    AD_TAKE(table, local, (size_t)grid->dims * n);
    AD_TAKE(table, weight, n);
    for (int i = 0; i < jets->count; i++) {
        if (wanted[i]) {
            AD_TAKE(table, phi[i], (size_t)grid->functions * n);
        }
    }
    if (table->memory.is_short) {
        patch_table_clear(table);
        return false;
    }
    memcpy(table->local, local, (size_t)grid->dims * n * sizeof *local);
    for (size_t q = 0; q < n; q++) {
        table->weight[q] = 1 / (double)n;
        for (int i = 0; i < jets->count; i++) {
            if (!table->phi[i]) {
                continue;
            }
            for (int d = 0; d < grid->dims; d++) {
                legendre(grid->degree[d], jets->order[i][d], local[(size_t)d * n + q], line[d]);
            }
            for (int j = 0; j < grid->functions; j++) {
                double product = 1;
                for (int d = 0; d < grid->dims; d++) {
                    product *= line[d][patch_degree(grid, j, d)];
                }
                table->phi[i][(size_t)j * n + q] = product;
            }
        }
    }
    return true;
}

/* A quarter more points than functions along each coordinate. */
static int points_along(const patch_grid *grid, int coordinate)
{
    return (5 * (grid->degree[coordinate] + 1) + 3) / 4;
}

bool patch_table_create(patch_table *table, const patch_grid *grid, const patch_jets *jets,
                        const bool *wanted, const int *end)
{
    double node[PATCH_DIMS][GAUSS_POINTS_MAX], weight[PATCH_DIMS][GAUSS_POINTS_MAX];
    int along[PATCH_DIMS], points = 1;
    for (int d = 0; d < grid->dims; d++) {
        along[d] = end[d] ? 1 : points_along(grid, d);
        points *= along[d];
        if (end[d]) {
            node[d][0] = end[d] > 0;
            weight[d][0] = 1;
        } else {
            gauss_points(along[d], node[d], weight[d]);
        }
    }
    const size_t n = (size_t)points;
    double *local = malloc((size_t)grid->dims * n * sizeof *local);
    double *product = malloc(n * sizeof *product);
    for (size_t q = 0; q < n && local && product; q++) {
        int rest = (int)q;
        product[q] = 1;
        for (int d = grid->dims - 1; d >= 0; d--) {
            const int i = rest % along[d];
            rest /= along[d];
            local[(size_t)d * n + q] = 2 * node[d][i] - 1;
            product[q] *= weight[d][i];
        }
    }
    const bool done = local && product && patch_table_at(table, grid, jets, wanted, points, local);
    if (done) {
        memcpy(table->weight, product, n * sizeof *product);
    }
    free(local);
    free(product);
    return done;
}

/* ---- values ---------------------------------------------------------------------------------- */

int patch_cell_at(const patch_grid *grid, int coordinate, double x)
{
    return (int)sort_cell((size_t)grid->cells[coordinate], grid->edge[coordinate], x, false);
}

double patch_grid_at(const patch_grid *grid, const double *c, int output, const int *order,
                     const double *x)
{
    double line[PATCH_DIMS][PATCH_DEGREE + 1], sum = 0;
    int patch = 0;
    for (int d = 0; d < grid->dims; d++) {
        const int cell = patch_cell_at(grid, d, x[d]);
        const double *edge = grid->edge[d] + cell, half = (edge[1] - edge[0]) / 2;
        const double local = fmin(1, fmax(-1, (x[d] - edge[0]) / half - 1));
        patch += cell * grid->stride[d];
        legendre(grid->degree[d], order[d], local, line[d]);
        for (int k = 0; k <= grid->degree[d]; k++) {
            line[d][k] *= pow(half, -order[d]);
        }
    }
    c += patch_first(grid, patch, output);
    for (int j = 0; j < grid->functions; j++) {
        double product = c[j];
        for (int d = 0; d < grid->dims; d++) {
            product *= line[d][patch_degree(grid, j, d)];
        }
        sum += product;
    }
    return sum;
}

void patch_grid_project(const patch_grid *from, patch_grid *to)
{
    const int inside[PATCH_DIMS] = {0}, none[PATCH_DIMS] = {0};
    bool wanted[PATCH_JETS] = {true};
    patch_jets value = {.dims = to->dims, .count = 1};
    patch_table table;
    if (!patch_table_create(&table, to, &value, wanted, inside)) {
        return; /* a guess less */
    }
    for (int k = 0; k < to->patches; k++) {
        for (int f = 0; f < to->outputs; f++) {
            double *c = to->c + patch_first(to, k, f);
            memset(c, 0, (size_t)to->functions * sizeof *c);
            for (int q = 0; q < table.points; q++) {
                double x[PATCH_DIMS];
                for (int d = 0; d < to->dims; d++) {
                    x[d] = patch_place(to, k, d,
                                       table.local[(size_t)d * (size_t)table.points + (size_t)q]);
                }
                const double value_here =
                    table.weight[q] * patch_grid_at(from, from->c, f, none, x);
                for (int j = 0; j < to->functions; j++) {
                    c[j] += value_here * table.phi[0][(size_t)j * (size_t)table.points + (size_t)q];
                }
            }
        }
    }
    patch_table_clear(&table);
}

void patch_grid_embed(const patch_grid *from, patch_grid *to)
{
    const size_t blocks = (size_t)from->patches * (size_t)from->outputs;
    for (int j = 0; j < from->functions; j++) {
        int there = 0;
        for (int d = 0; d < from->dims; d++) {
            there = there * (to->degree[d] + 1) + patch_degree(from, j, d);
        }
        for (size_t k = 0; k < blocks; k++) {
            to->c[k * (size_t)to->functions + (size_t)there] =
                from->c[k * (size_t)from->functions + (size_t)j];
        }
    }
}
