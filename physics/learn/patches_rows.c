/* Residuals and rows of the least squares. */
#include "physics/learn/patches_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Conditions and joints are met as far as polynomials can, 1e-12 or so, and equations are least
 * beside them. Data that nothing unknown is found by weigh less. */
static const double CONDITION = 100, DATA = 0.1;

/* ---- evaluation ------------------------------------------------------------------------------ */

/* y [points] = sum over functions of c phi, times a scale. */
static void combine(const patch_table *table, int jet, int functions, const double *c, double scale,
                    double *y)
{
    const size_t points = (size_t)table->points;
    memset(y, 0, points * sizeof *y);
    for (int j = 0; j < functions; j++) {
        const double *phi = table->phi[jet] + (size_t)j * points, factor = scale * c[j];
        for (size_t q = 0; q < points; q++) {
            y[q] += factor * phi[q];
        }
    }
}

typedef struct filling {
    patch_window *w;
    patch_rows *rows;
} filling;

static void fill_patch(void *context, int k, int thread)
{
    const filling *f = context;
    const patch_problem *p = f->w->p;
    const patch_grid *grid = f->w->grid;
    const patch_rows *rows = f->rows;
    (void)thread;
    for (int i = 0, used = 0; i < p->outputs * p->jets.count; i++) {
        const int jet = i % p->jets.count, output = i / p->jets.count;
        if (rows->law->uses[i]) {
            const size_t points = rows->first[rows->patches];
            combine(patch_rows_table(rows, k), jet, grid->functions,
                    grid->c + patch_first(grid, rows->patch[k], output),
                    patch_scale(grid, rows->patch[k], p->jets.order[jet]),
                    rows->numbers + points * (size_t)used++ + rows->first[k]);
        }
    }
}

/* Residuals are divided by how much they change with fields of their usual size: the sum over their
 * derivatives, at the point where it is largest. */
static void find_factors(const patch_window *w, patch_rows *rows)
{
    const patch_law *law = rows->law;
    for (int row = 0; row < law->rows; row++) {
        double largest = 0;
        for (int k = 0; k < rows->patches; k++) {
            for (size_t q = rows->first[k]; q < rows->first[k + 1]; q++) {
                double sum = 0;
                for (int i = 0; i < law->entry_count; i++) {
                    const patch_entry *e = &law->entries[i];
                    if (e->row == row && e->output >= 0) {
                        sum += fabs(rows->outputs[law->rows + i][q]) * w->p->scale[e->output] *
                               patch_scale(w->grid, rows->patch[k], w->p->jets.order[e->jet]);
                    }
                }
                largest = fmax(largest, sum);
            }
        }
        rows->factor[row] = largest > 0 && isfinite(largest) ? 1 / largest : 1;
    }
}

ad_status patch_window_evaluate(patch_window *w, ad_error *error)
{
    const patch_problem *p = w->p;
    for (int i = 0; i < w->law_count; i++) {
        patch_rows *rows = &w->laws[i];
        const patch_law *law = rows->law;
        const size_t points = rows->first[rows->patches];
        filling filled = {w, rows};
        if (points == 0) {
            continue;
        }
        ad_pool_run(p->settings->pool, rows->patches, fill_patch, &filled);
        for (int k = 0; k < p->unknowns; k++) {
            for (size_t q = 0; q < points; q++) {
                rows->unknowns[(size_t)k * points + q] = p->unknown[k];
            }
        }
        const ad_run run = {
            .points = points, .inputs = rows->inputs, .outputs = rows->outputs, .everywhere = true};
        ad_status status = ad_execute(law->program, &run, error);
        if (status != AD_OK) {
            return status;
        }
        if (rows->factor[0] == 0) {
            find_factors(w, rows);
        }
    }
    return AD_OK;
}

/* ---- rows ------------------------------------------------------------------------------------ */

/* What a residual in a patch is multiplied with, but for the weight of its point: by the patch's
 * share of the window's volume or of the face's area. */
static double row_weight(const patch_window *w, const patch_rows *rows, int k, int row)
{
    const model_set *set = rows->law->set;
    const double kind = set->points == MODEL_INTERIOR ? 1
                        : set->points == MODEL_GIVEN  ? DATA * sqrt(rows->law->weight[row])
                                                      : CONDITION;
    const double share = set->points == MODEL_GIVEN
                             ? 1 / (double)set->source.points
                             : patch_share(w->grid, rows->patch[k], set->holds);
    return kind * rows->factor[row] * sqrt(share);
}

/* The weight of a point; points that are given count alike. */
static double point_weight(const patch_rows *rows, size_t q)
{
    return rows->law->set->points == MODEL_GIVEN ? 1 : sqrt(rows->table->weight[q]);
}

static int find_patch(const patch_rows *rows, int patch)
{
    for (int k = 0; k < rows->patches; k++) {
        if (rows->patch[k] == patch) {
            return k;
        }
    }
    return -1;
}

/* Rows by which a window starts as the one before ends, of a patch. */
static size_t start_rows(const patch_window *w)
{
    size_t rows = 0;
    for (int f = 0; f < w->p->outputs && w->before; f++) {
        rows += (size_t)w->p->order[f][w->p->model->domain.time];
    }
    return rows * (size_t)w->start.points;
}

static bool at_start(const patch_window *w, int patch)
{
    return w->before && patch_cell(w->grid, patch, w->p->model->domain.time) == 0;
}

size_t patch_own_count(const patch_window *w, int patch)
{
    size_t count = at_start(w, patch) ? start_rows(w) : 0;
    for (int i = 0; i < w->law_count; i++) {
        const patch_rows *rows = &w->laws[i];
        const int k = find_patch(rows, patch);
        if (k >= 0 && !patch_rows_judge(w, rows)) {
            count += (size_t)rows->law->rows * (rows->first[k + 1] - rows->first[k]);
        }
    }
    return count;
}

/* A row of a law at points q0 .. q0 + count - 1 of a patch, count <= CHUNK, from `row0` on. */
enum { CHUNK = 256 };

static void law_row(const patch_window *w, const patch_rows *rows, int k, int row, size_t q0,
                    size_t count, const patch_block *block, size_t row0)
{
    const patch_law *law = rows->law;
    const patch_table *table = patch_rows_table(rows, k);
    const patch_grid *grid = w->grid;
    const size_t points = (size_t)table->points, from = rows->first[k] + q0;
    const double of_row = row_weight(w, rows, k, row);
    double weight[CHUNK], factor[CHUNK];
    for (size_t q = 0; q < count; q++) {
        weight[q] = of_row * point_weight(rows, q0 + q);
        block->a[block->residual * block->stride + row0 + q] =
            weight[q] * rows->outputs[row][from + q];
    }
    for (int i = 0; i < law->entry_count; i++) {
        const patch_entry *e = &law->entries[i];
        const double *by = rows->outputs[law->rows + i] + from;
        if (e->row != row) {
            continue;
        }
        if (e->output < 0) {
            double *column = block->a + (block->unknowns + (size_t)e->jet) * block->stride + row0;
            for (size_t q = 0; q < count; q++) {
                column[q] += weight[q] * by[q];
            }
            continue;
        }
        const double scale = patch_scale(grid, rows->patch[k], w->p->jets.order[e->jet]);
        for (size_t q = 0; q < count; q++) {
            factor[q] = weight[q] * by[q] * scale;
        }
        for (int j = 0; j < grid->functions; j++) {
            const double *phi = table->phi[e->jet] + (size_t)j * points + q0;
            double *column =
                block->a + (size_t)(e->output * grid->functions + j) * block->stride + row0;
            for (size_t q = 0; q < count; q++) {
                column[q] += factor[q] * phi[q];
            }
        }
    }
}

static size_t law_rows(const patch_window *w, const patch_rows *rows, int k,
                       const patch_block *block, size_t row0)
{
    const size_t points = (size_t)patch_rows_table(rows, k)->points;
    for (int row = 0; row < rows->law->rows; row++, row0 += points) {
        for (size_t q = 0; q < points; q += CHUNK) {
            law_row(w, rows, k, row, q, points - q < CHUNK ? points - q : CHUNK, block, row0 + q);
        }
    }
    return row0;
}

/* The number of the first derivative by one coordinate alone. */
static int jet_along(const patch_problem *p, int coordinate, int order)
{
    int orders[PATCH_DIMS] = {0};
    orders[coordinate] = order;
    return patch_jet_of(&p->jets, orders);
}

/* Rows of the start of a window; a NULL: the sum of their squares alone. */
static double start_of(const patch_window *w, int patch, const patch_block *block, size_t row0)
{
    const patch_problem *p = w->p;
    const patch_grid *grid = w->grid;
    const int time = p->model->domain.time;
    const size_t points = (size_t)w->start.points;
    const double half = patch_half(grid, patch, time);
    bool holds[PATCH_DIMS] = {false};
    holds[time] = true;
    double sum = 0, y[points + 1];
    const double share = patch_share(grid, patch, holds);
    size_t row = 0;
    for (int f = 0; f < p->outputs; f++) {
        const double *c = grid->c + patch_first(grid, patch, f);
        for (int k = 0; k < p->order[f][time]; k++, row++) {
            const int jet = jet_along(p, time, k);
            const double *target =
                w->before + (row * (size_t)grid->patches + (size_t)patch) * points;
            combine(&w->start, jet, grid->functions, c, pow(half, -k), y);
            for (size_t q = 0; q < points; q++) {
                const double weight =
                    CONDITION * pow(half, k) / p->scale[f] * sqrt(w->start.weight[q] * share);
                const double rest = weight * (y[q] - target[q]);
                const size_t at = row0 + row * points + q;
                sum += rest * rest;
                if (!block) {
                    continue;
                }
                block->a[block->residual * block->stride + at] = rest;
                for (size_t g = 0; g < (size_t)p->unknowns; g++) {
                    block->a[(block->unknowns + g) * block->stride + at] =
                        -weight * target[(1 + g) * patch_before_size(w) + q];
                }
                for (int j = 0; j < grid->functions; j++) {
                    block->a[(size_t)(f * grid->functions + j) * block->stride + at] =
                        weight * pow(half, -k) * w->start.phi[jet][(size_t)j * points + q];
                }
            }
        }
    }
    return sum;
}

void patch_own_rows(const patch_window *w, int patch, const patch_block *block)
{
    size_t row = block->row;
    for (int i = 0; i < w->law_count; i++) {
        const int k = find_patch(&w->laws[i], patch);
        if (k >= 0 && !patch_rows_judge(w, &w->laws[i])) {
            row = law_rows(w, &w->laws[i], k, block, row);
        }
    }
    if (at_start(w, patch)) {
        start_of(w, patch, block, row);
    }
}

size_t patch_joint_count(const patch_window *w, const patch_joint *joint)
{
    size_t rows = 0;
    for (int f = 0; f < w->p->outputs; f++) {
        rows += (size_t)w->p->order[f][joint->d];
    }
    return rows * (size_t)w->low[joint->d].points;
}

double patch_joint_rows(const patch_window *w, const patch_joint *joint, const patch_block *block,
                        size_t column_a, size_t column_b)
{
    const patch_problem *p = w->p;
    const patch_grid *grid = w->grid;
    const int d = joint->d;
    const patch_table *high = &w->high[d], *low = &w->low[d];
    const size_t points = (size_t)low->points, functions = (size_t)grid->functions;
    const double half[2] = {patch_half(grid, joint->a, d), patch_half(grid, joint->b, d)};
    const double least = fmin(half[0], half[1]);
    bool holds[PATCH_DIMS] = {false};
    holds[d] = true;
    double sum = 0, y[2][points + 1];
    const double area = patch_share(grid, joint->a, holds);
    size_t row = block ? block->row : 0;
    for (int f = 0; f < p->outputs; f++) {
        const double *a = grid->c + patch_first(grid, joint->a, f);
        const double *b = grid->c + patch_first(grid, joint->b, f);
        for (int k = 0; k < p->order[f][d]; k++, row += points) {
            const int jet = jet_along(p, d, k);
            const double scale[2] = {pow(half[0], -k), pow(half[1], -k)};
            combine(high, jet, grid->functions, a, scale[0], y[0]);
            combine(low, jet, grid->functions, b, scale[1], y[1]);
            for (size_t q = 0; q < points; q++) {
                const double weight =
                    CONDITION * pow(least, k) / p->scale[f] * sqrt(low->weight[q] * area);
                const double rest = weight * (y[0][q] - y[1][q]);
                sum += rest * rest;
                if (!block) {
                    continue;
                }
                double *at = block->a + row + q;
                at[block->residual * block->stride] = rest;
                for (size_t j = 0; j < functions; j++) {
                    at[(column_a + (size_t)f * functions + j) * block->stride] +=
                        weight * scale[0] * high->phi[jet][j * points + q];
                    at[(column_b + (size_t)f * functions + j) * block->stride] -=
                        weight * scale[1] * low->phi[jet][j * points + q];
                }
            }
        }
    }
    return sum;
}

/* Of row `row` in the k-th patch of its law: see patch_window_missed. */
static double missed_by(const patch_window *w, const patch_rows *rows, int k, int row)
{
    const patch_grid *grid = w->grid;
    double mean = 0, parts = 0, usual = 0;
    for (size_t q = rows->first[k]; q < rows->first[k + 1]; q++) {
        mean += rows->table->weight[q - rows->first[k]] * rows->outputs[row][q];
    }
    for (int i = 0, used = 0; i < w->p->outputs * w->p->jets.count; i++) {
        const int jet = i % w->p->jets.count, output = i / w->p->jets.count;
        const double *field = rows->numbers + rows->first[rows->patches] * (size_t)used;
        used += rows->law->uses[i];
        for (int e = 0; e < rows->law->entry_count && rows->law->uses[i]; e++) {
            const patch_entry *entry = &rows->law->entries[e];
            if (entry->row != row || entry->output != output || entry->jet != jet) {
                continue;
            }
            double size = w->p->scale[output], sum = 0, by = 0;
            for (int d = 0; d < grid->dims; d++) {
                size /= pow((grid->edge[d][grid->cells[d]] - grid->edge[d][0]) / 2,
                            w->p->jets.order[jet][d]);
            }
            for (size_t q = rows->first[k]; q < rows->first[k + 1]; q++) {
                const double weight = rows->table->weight[q - rows->first[k]];
                const double slope = fabs(rows->outputs[rows->law->rows + e][q]);
                sum += weight * slope * fabs(field[q]);
                by += weight * slope;
            }
            parts += sum;
            usual += by * size;
        }
    }
    return fabs(mean) > 0.1 * parts && usual > 0 ? fabs(mean) / usual : 0;
}

void patch_window_missed(patch_window *w)
{
    memset(w->grid->missed, 0, (size_t)w->grid->patches * sizeof *w->grid->missed);
    for (int i = 0; i < w->law_count; i++) {
        const patch_rows *rows = &w->laws[i];
        for (int k = 0; k < rows->patches && rows->law->set->points == MODEL_INTERIOR; k++) {
            double *missed = &w->grid->missed[rows->patch[k]];
            for (int row = 0; row < rows->law->rows; row++) {
                *missed = fmax(*missed, missed_by(w, rows, k, row));
            }
        }
    }
}

double patch_window_sum(const patch_window *w)
{
    double sum = 0;
    for (int i = 0; i < w->law_count; i++) {
        const patch_rows *rows = &w->laws[i];
        for (int k = 0; k < rows->patches && !patch_rows_judge(w, rows); k++) {
            for (int row = 0; row < rows->law->rows; row++) {
                const double weight = row_weight(w, rows, k, row);
                for (size_t q = rows->first[k]; q < rows->first[k + 1]; q++) {
                    const double rest =
                        weight * point_weight(rows, q - rows->first[k]) * rows->outputs[row][q];
                    sum += rest * rest;
                }
            }
        }
    }
    for (int i = 0; i < w->joint_count; i++) {
        sum += patch_joint_rows(w, &w->joints[i], NULL, 0, 0);
    }
    for (int k = 0; k < w->grid->patches; k++) {
        sum += at_start(w, k) ? start_of(w, k, NULL, 0) : 0;
    }
    return sum;
}

/* How a residual changes with the unknown number g. */
static double slope_of(const patch_window *w, const patch_rows *rows, int k, int row, size_t q,
                       int g, const double *slopes)
{
    const patch_law *law = rows->law;
    const patch_grid *grid = w->grid;
    const patch_table *table = patch_rows_table(rows, k);
    double sum = 0;
    for (int i = 0; i < law->entry_count; i++) {
        const patch_entry *e = &law->entries[i];
        const double by = rows->outputs[law->rows + i][rows->first[k] + q];
        if (e->row != row || (e->output < 0 && e->jet != g)) {
            continue;
        }
        if (e->output < 0) {
            sum += by;
            continue;
        }
        const double *s = slopes + patch_first(grid, rows->patch[k], e->output);
        const double scale = patch_scale(grid, rows->patch[k], w->p->jets.order[e->jet]);
        for (int j = 0; j < grid->functions; j++) {
            sum += by * scale * s[j] * table->phi[e->jet][(size_t)j * (size_t)table->points + q];
        }
    }
    return sum;
}

patch_misfit patch_window_misfit(const patch_window *w, const double *slopes, size_t stride)
{
    patch_misfit misfit = {.rows = 0};
    const int n = w->p->unknowns;
    for (int i = 0; i < w->law_count; i++) {
        const patch_rows *rows = &w->laws[i];
        for (int k = 0; k < rows->patches && patch_rows_judge(w, rows); k++) {
            for (size_t q = 0; q < rows->first[k + 1] - rows->first[k]; q++) {
                for (int row = 0; row < rows->law->rows; row++) {
                    const double weight = sqrt(rows->law->weight[row]);
                    const double rest = weight * rows->outputs[row][rows->first[k] + q];
                    double by[MODEL_UNKNOWNS_MAX];
                    for (int g = 0; g < n; g++) {
                        by[g] =
                            weight * slope_of(w, rows, k, row, q, g, slopes + (size_t)g * stride);
                    }
                    misfit.rows++;
                    misfit.sum += rest * rest;
                    for (int g = 0; g < n; g++) {
                        misfit.jtr[g] += by[g] * rest;
                        for (int h = 0; h < n; h++) {
                            misfit.jtj[g * n + h] += by[g] * by[h];
                        }
                    }
                }
            }
        }
    }
    return misfit;
}
