#include "physics/learn/patches_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Conditions and joints weigh more than equations, which are to be least beside them; data that
 * nothing unknown is found by weigh less. */
static const double CONDITION = 10, DATA = 0.1;

/* ---- where a law counts ---------------------------------------------------------------------- */

static bool counts(const patch_window *w, const patch_law *law)
{
    const int time = w->p->model->domain.time;
    const bool starts = w->p->marches && law->set->holds[time < 0 ? 0 : time];
    return w->phase == PATCH_START ? starts : w->phase == PATCH_FIRST || !starts;
}

/* The ends of a face: -1 or 1 where it holds a coordinate. */
static ad_status ends_of(const patch_window *w, const model_set *set, int *end, ad_error *error)
{
    for (int d = 0; d < w->grid->dims; d++) {
        const domain_coordinate *c = &w->p->model->domain.coordinates[d];
        const double at = set->value[d];
        end[d] = !set->holds[d] ? 0 : at == c->low ? -1 : at == c->high ? 1 : 2;
        if (end[d] == 2) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "%s: holds %s within its range; allowed: faces of the domain", set->name,
                           c->name);
        }
    }
    return AD_OK;
}

static bool touches(const patch_grid *grid, int patch, const int *end)
{
    for (int d = 0; d < grid->dims; d++) {
        const int cell = patch_cell(grid, patch, d);
        if ((end[d] < 0 && cell > 0) || (end[d] > 0 && cell < grid->cells[d] - 1)) {
            return false;
        }
    }
    return true;
}

/* ---- points ---------------------------------------------------------------------------------- */

static bool wants_of(const patch_problem *p, const patch_law *law, bool *wanted)
{
    memset(wanted, 0, PATCH_JETS * sizeof *wanted);
    for (int i = 0; i < p->outputs * p->jets.count; i++) {
        wanted[i % p->jets.count] = wanted[i % p->jets.count] || law->uses[i];
    }
    return true;
}

static bool rows_list(patch_rows *rows, int patches)
{
    rows->patch = malloc((size_t)patches * sizeof *rows->patch);
    rows->first = calloc((size_t)patches + 1, sizeof *rows->first);
    rows->table = calloc((size_t)patches, sizeof *rows->table);
    return rows->patch && rows->first && rows->table;
}

static bool place_points(patch_window *w, patch_rows *rows)
{
    const patch_grid *grid = w->grid;
    const size_t all = rows->first[rows->patches];
    rows->x = malloc((size_t)grid->dims * all * sizeof *rows->x + 1);
    for (int k = 0; k < rows->patches && rows->x; k++) {
        const patch_table *table = &rows->table[rows->tables == 1 ? 0 : k];
        const size_t points = (size_t)table->points;
        for (int d = 0; d < grid->dims; d++) {
            const double *edge = grid->edge[d] + patch_cell(grid, rows->patch[k], d);
            for (size_t q = 0; q < points; q++) {
                rows->x[(size_t)d * all + rows->first[k] + q] =
                    edge[0] + (edge[1] - edge[0]) * (1 + table->local[(size_t)d * points + q]) / 2;
            }
        }
    }
    return rows->x != NULL;
}

/* Points that a model gives, sorted into patches; data [rows][points] in this order. */
static ad_status place_given(patch_window *w, patch_rows *rows, double **data, ad_error *error)
{
    const patch_grid *grid = w->grid;
    const model_source *source = &rows->law->set->source;
    const size_t count = source->points;
    bool wanted[PATCH_JETS];
    double *x = malloc((size_t)grid->dims * count * sizeof *x);
    double *values = malloc((size_t)(source->rows + 1) * count * sizeof *values);
    double *local = malloc((size_t)grid->dims * count * sizeof *local);
    int *owner = malloc(count * sizeof *owner);
    size_t *from = malloc(count * sizeof *from), kept = 0;
    bool has_memory = x && values && local && owner && from && rows_list(rows, grid->patches);
    nn_rng rng = nn_rng_split(1, rows->law->set->name);
    ad_status status =
        has_memory
            ? source->fill(source->context,
                           &(model_draw){.count = count, .rng = &rng, .x = x, .data = values},
                           error)
            : ad_fail(error, AD_NO_MEMORY, "out of memory for data");
    wants_of(w->p, rows->law, wanted);
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        owner[i] = 0;
        for (int d = 0; d < grid->dims; d++) {
            const double at = x[(size_t)d * count + i];
            int cell = 0;
            while (cell < grid->cells[d] - 1 && at >= grid->edge[d][cell + 1]) {
                cell++;
            }
            const bool within = at >= grid->edge[d][0] && at <= grid->edge[d][grid->cells[d]];
            owner[i] = within && owner[i] >= 0 ? owner[i] + cell * grid->stride[d] : -1;
        }
    }
    rows->tables = 2; /* one for each */
    for (int k = 0; k < grid->patches && status == AD_OK; k++) {
        size_t here = 0;
        for (size_t i = 0; i < count; i++) {
            if (owner[i] == k) {
                from[kept + here++] = i;
            }
        }
        for (size_t q = 0; q < here; q++) {
            for (int d = 0; d < grid->dims; d++) {
                const double *edge = grid->edge[d] + patch_cell(grid, k, d);
                local[(size_t)d * here + q] =
                    2 * (x[(size_t)d * count + from[kept + q]] - edge[0]) / (edge[1] - edge[0]) - 1;
            }
        }
        if (here > 0) {
            kept += here;
            rows->patch[rows->patches] = k;
            rows->first[rows->patches + 1] = kept;
            if (!patch_table_at(&rows->table[rows->patches++], grid, &w->p->jets, wanted, (int)here,
                                local)) {
                status = ad_fail(error, AD_NO_MEMORY, "out of memory for data");
            }
        }
    }
    *data = malloc((size_t)(source->rows + 1) * (kept + 1) * sizeof **data);
    for (int i = 0; i < source->rows && *data && status == AD_OK; i++) {
        for (size_t q = 0; q < kept; q++) {
            (*data)[(size_t)i * kept + q] = values[(size_t)i * count + from[q]];
        }
    }
    free(x);
    free(values);
    free(local);
    free(owner);
    free(from);
    return status != AD_OK || *data ? status
                                    : ad_fail(error, AD_NO_MEMORY, "out of memory for data");
}

static ad_status place_face(patch_window *w, patch_rows *rows, ad_error *error)
{
    int end[PATCH_DIMS] = {0};
    bool wanted[PATCH_JETS];
    ad_status status = ends_of(w, rows->law->set, end, error);
    if (status != AD_OK) {
        return status;
    }
    wants_of(w->p, rows->law, wanted);
    if (!rows_list(rows, w->grid->patches) ||
        !patch_table_create(rows->table, w->grid, &w->p->jets, wanted, end)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for points");
    }
    rows->tables = 1;
    for (int k = 0; k < w->grid->patches; k++) {
        if (touches(w->grid, k, end)) {
            rows->patch[rows->patches++] = k;
            rows->first[rows->patches] = (size_t)rows->patches * (size_t)rows->table->points;
        }
    }
    return AD_OK;
}

/* ---- inputs and outputs of a law ---------------------------------------------------------------
 */

static ad_status connect(patch_window *w, patch_rows *rows, const double *data, ad_error *error)
{
    const patch_problem *p = w->p;
    const patch_law *law = rows->law;
    const size_t points = rows->first[rows->patches], jets = (size_t)p->jets.count;
    const size_t all = (size_t)p->outputs * jets, results = (size_t)(law->rows + law->entry_count);
    const size_t data_rows = (size_t)law->set->source.rows;
    size_t used = 0, next = 0, at = 0;
    for (size_t i = 0; i < all; i++) {
        used += law->uses[i];
    }
    rows->numbers = calloc((used + (size_t)p->unknowns + data_rows + results) * points + 1,
                           sizeof *rows->numbers);
    rows->inputs = malloc(((size_t)(2 * p->dims + p->unknowns + 1) + all) * sizeof *rows->inputs);
    rows->outputs = malloc(results * sizeof *rows->outputs);
    rows->factor = calloc((size_t)law->rows, sizeof *rows->factor);
    if (!rows->numbers || !rows->inputs || !rows->outputs || !rows->factor) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for residuals");
    }
    for (int d = 0; d < p->dims; d++) {
        rows->inputs[next++] = rows->x + (size_t)d * points;
    }
    for (size_t i = 0; i < all; i++) { /* what is not used is not read */
        rows->inputs[next++] = law->uses[i] ? rows->numbers + points * at++ : rows->x;
    }
    for (int i = 0; i < p->unknowns; i++) {
        rows->inputs[next++] = rows->numbers + points * at++;
    }
    if (data_rows > 0) {
        rows->inputs[next++] = rows->numbers + points * at;
        memcpy(rows->numbers + points * at, data, data_rows * points * sizeof *data);
        at += data_rows;
    }
    for (int d = 0; d < p->dims; d++) {
        rows->inputs[next++] = rows->x + (size_t)d * points;
    }
    for (size_t i = 0; i < results; i++) {
        rows->outputs[i] = rows->numbers + points * at++;
    }
    return AD_OK;
}

/* ---- windows --------------------------------------------------------------------------------- */

static bool make_joints(patch_window *w)
{
    const patch_grid *grid = w->grid;
    const domain *domain = &w->p->model->domain;
    w->joints = malloc((size_t)grid->patches * PATCH_DIMS * sizeof *w->joints);
    for (int k = 0; k < grid->patches && w->joints; k++) {
        for (int d = 0; d < grid->dims; d++) {
            const int last = grid->cells[d] - 1, cell = patch_cell(grid, k, d);
            if (cell < last || domain->coordinates[d].periodic) {
                w->joints[w->joint_count++] =
                    (patch_joint){k, k + (cell < last ? 1 : -last) * grid->stride[d], d};
            }
        }
    }
    return w->joints != NULL;
}

/* Tables of the ends along a coordinate, with derivatives below the order of the equations. */
static bool make_ends(const patch_window *w, int d, int end, patch_table *table)
{
    const patch_problem *p = w->p;
    bool wanted[PATCH_JETS] = {false};
    int ends[PATCH_DIMS] = {0};
    ends[d] = end;
    for (int f = 0; f < p->outputs; f++) {
        for (int k = 0; k < p->order[f][d]; k++) {
            int order[PATCH_DIMS] = {0};
            order[d] = k;
            wanted[patch_jet_of(&p->jets, order)] = true;
        }
    }
    return patch_table_create(table, w->grid, &p->jets, wanted, ends);
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

/* What they are, in the order output, derivative, patch, point. */
static bool make_before(patch_window *w, const patch_grid *before)
{
    const patch_grid *grid = w->grid;
    const int time = w->p->model->domain.time;
    const size_t points = (size_t)w->start.points;
    size_t next = 0, rows = 0;
    for (int f = 0; f < w->p->outputs; f++) {
        rows += (size_t)w->p->order[f][time];
    }
    w->before = malloc(rows * (size_t)grid->patches * points * sizeof *w->before + 1);
    for (int f = 0; f < w->p->outputs && w->before; f++) {
        for (int k = 0; k < w->p->order[f][time]; k++) {
            for (int patch = 0; patch < grid->patches; patch++) {
                for (size_t q = 0; q < points; q++) {
                    int order[PATCH_DIMS] = {0};
                    double x[PATCH_DIMS];
                    order[time] = k;
                    for (int d = 0; d < grid->dims; d++) {
                        const double *edge = grid->edge[d] + patch_cell(grid, patch, d);
                        x[d] = edge[0] + (edge[1] - edge[0]) *
                                             (1 + w->start.local[(size_t)d * points + q]) / 2;
                    }
                    w->before[next++] = patch_grid_at(before, f, order, x);
                }
            }
        }
    }
    return w->before != NULL;
}

ad_status patch_window_create(patch_window *w, patch_problem *p, patch_grid *grid,
                              patch_phase phase, const patch_grid *before, ad_error *error)
{
    *w = (patch_window){.p = p, .grid = grid, .phase = phase};
    bool has_memory = make_joints(w);
    for (int d = 0; d < grid->dims && has_memory; d++) {
        has_memory = make_ends(w, d, -1, &w->low[d]) && make_ends(w, d, 1, &w->high[d]);
    }
    if (before && has_memory) {
        has_memory = make_ends(w, p->model->domain.time, -1, &w->start) && make_before(w, before);
    }
    ad_status status = has_memory ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (int i = 0; i < p->law_count && status == AD_OK; i++) {
        if (!counts(w, &p->laws[i])) {
            continue;
        }
        patch_rows *rows = &w->laws[w->law_count++];
        double *data = NULL;
        rows->law = &p->laws[i];
        status = rows->law->set->points == MODEL_GIVEN ? place_given(w, rows, &data, error)
                                                       : place_face(w, rows, error);
        if (status == AD_OK && !place_points(w, rows)) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for points");
        }
        if (status == AD_OK) {
            status = connect(w, rows, data, error);
        }
        free(data);
    }
    if (status != AD_OK) {
        patch_window_clear(w);
    }
    return status;
}

void patch_window_clear(patch_window *w)
{
    for (int i = 0; i < w->law_count; i++) {
        patch_rows *rows = &w->laws[i];
        for (int k = 0; k < w->grid->patches && rows->table; k++) {
            patch_table_clear(&rows->table[k]);
        }
        free(rows->patch);
        free(rows->first);
        free(rows->table);
        free(rows->x);
        free(rows->numbers);
        free(rows->inputs);
        free(rows->outputs);
        free(rows->factor);
    }
    for (int d = 0; d < PATCH_DIMS; d++) {
        patch_table_clear(&w->low[d]);
        patch_table_clear(&w->high[d]);
    }
    patch_table_clear(&w->start);
    free(w->before);
    free(w->joints);
    *w = (patch_window){.law_count = 0};
}

/* ---- evaluation ------------------------------------------------------------------------------ */

static const patch_table *table_of(const patch_rows *rows, int k)
{
    return &rows->table[rows->tables == 1 ? 0 : k];
}

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
    const size_t size = patch_grid_size(grid);
    (void)thread;
    for (int i = 0, used = 0; i < p->outputs * p->jets.count; i++) {
        const int jet = i % p->jets.count, output = i / p->jets.count;
        if (rows->law->uses[i]) {
            const size_t points = rows->first[rows->patches];
            combine(table_of(rows, k), jet, grid->functions,
                    grid->c + (size_t)rows->patch[k] * size +
                        (size_t)output * (size_t)grid->functions,
                    patch_scale(grid, rows->patch[k], p->jets.order[jet]),
                    rows->numbers + points * (size_t)used++ + rows->first[k]);
        }
    }
}

static void spread(double *y, size_t points)
{
    for (size_t q = 1; q < points; q++) {
        y[q] = y[0];
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
            const size_t input = (size_t)p->dims + (size_t)(p->outputs * p->jets.count + k);
            double *y = rows->numbers + (rows->inputs[input] - rows->numbers);
            y[0] = p->unknown[k];
            spread(y, points);
        }
        const ad_run run = {.points = points, .inputs = rows->inputs, .outputs = rows->outputs};
        ad_status status = ad_execute(law->program, &run, error);
        if (status != AD_OK) {
            return status;
        }
        for (int k = 0; k < law->rows + law->entry_count; k++) {
            if (k < law->rows ? law->same[k] : law->entries[k - law->rows].same) {
                spread(rows->outputs[k], points);
            }
        }
        if (rows->factor[0] == 0) {
            find_factors(w, rows);
        }
    }
    return AD_OK;
}

/* ---- rows ------------------------------------------------------------------------------------ */

/* The weight of a point of a law: its share of the window's volume or of the face's area. */
static double share_of(const patch_window *w, const patch_rows *rows, int k, size_t q)
{
    const patch_grid *grid = w->grid;
    const model_set *set = rows->law->set;
    if (set->points == MODEL_GIVEN) {
        return 1 / (double)set->source.points;
    }
    double share = rows->table->weight[q];
    for (int d = 0; d < grid->dims; d++) {
        if (!set->holds[d]) {
            share *= 2 * patch_half(grid, rows->patch[k], d) /
                     (grid->edge[d][grid->cells[d]] - grid->edge[d][0]);
        }
    }
    return share;
}

/* What a residual at a point is multiplied with. */
static double row_weight(const patch_window *w, const patch_rows *rows, int k, int row, size_t q)
{
    const model_points points = rows->law->set->points;
    const double kind = points == MODEL_INTERIOR ? 1
                        : points == MODEL_GIVEN  ? DATA * sqrt(rows->law->weight[row])
                                                 : CONDITION;
    return kind * rows->factor[row] * sqrt(share_of(w, rows, k, q));
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

static size_t law_rows(const patch_window *w, const patch_rows *rows, int k,
                       const patch_block *block, size_t row0)
{
    const patch_law *law = rows->law;
    const patch_table *table = table_of(rows, k);
    const patch_grid *grid = w->grid;
    const size_t points = (size_t)table->points, from = rows->first[k];
    double weight[points + 1]; /* some hundreds */
    for (int row = 0; row < law->rows; row++, row0 += points) {
        for (size_t q = 0; q < points; q++) {
            weight[q] = row_weight(w, rows, k, row, q);
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
                double *column =
                    block->a + (block->unknowns + (size_t)e->jet) * block->stride + row0;
                for (size_t q = 0; q < points; q++) {
                    column[q] += weight[q] * by[q];
                }
                continue;
            }
            double factor[points + 1];
            const double scale = patch_scale(grid, rows->patch[k], w->p->jets.order[e->jet]);
            for (size_t q = 0; q < points; q++) {
                factor[q] = weight[q] * by[q] * scale;
            }
            for (int j = 0; j < grid->functions; j++) {
                const double *phi = table->phi[e->jet] + (size_t)j * points;
                double *column =
                    block->a + (size_t)(e->output * grid->functions + j) * block->stride + row0;
                for (size_t q = 0; q < points; q++) {
                    column[q] += factor[q] * phi[q];
                }
            }
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
    double sum = 0, y[points + 1], share = 1;
    size_t row = 0;
    for (int d = 0; d < grid->dims; d++) {
        if (d != time) {
            share *=
                2 * patch_half(grid, patch, d) / (grid->edge[d][grid->cells[d]] - grid->edge[d][0]);
        }
    }
    for (int f = 0; f < p->outputs; f++) {
        const double *c =
            grid->c + (size_t)patch * patch_grid_size(grid) + (size_t)f * (size_t)grid->functions;
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
    double sum = 0, area = 1, y[2][points + 1];
    size_t row = block ? block->row : 0;
    for (int i = 0; i < grid->dims; i++) {
        if (i != d) {
            area *= 2 * patch_half(grid, joint->a, i) /
                    (grid->edge[i][grid->cells[i]] - grid->edge[i][0]);
        }
    }
    for (int f = 0; f < p->outputs; f++) {
        const double *a =
            grid->c + (size_t)joint->a * patch_grid_size(grid) + (size_t)f * functions;
        const double *b =
            grid->c + (size_t)joint->b * patch_grid_size(grid) + (size_t)f * functions;
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

double patch_window_sum(const patch_window *w)
{
    double sum = 0;
    for (int i = 0; i < w->law_count; i++) {
        const patch_rows *rows = &w->laws[i];
        for (int k = 0; k < rows->patches && !patch_rows_judge(w, rows); k++) {
            for (size_t q = rows->first[k]; q < rows->first[k + 1]; q++) {
                for (int row = 0; row < rows->law->rows; row++) {
                    const double rest =
                        row_weight(w, rows, k, row, q - rows->first[k]) * rows->outputs[row][q];
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
    const patch_table *table = table_of(rows, k);
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
        const double *s = slopes + (size_t)rows->patch[k] * patch_grid_size(grid) +
                          (size_t)e->output * (size_t)grid->functions;
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
