/* Where the rows of a window are: points of laws in patches, joints, what the window before ends
 * with. */
#include "physics/learn/patches_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

static void wants_of(const patch_problem *p, const patch_law *law, bool *wanted)
{
    memset(wanted, 0, PATCH_JETS * sizeof *wanted);
    for (int i = 0; i < p->outputs * p->jets.count; i++) {
        wanted[i % p->jets.count] = wanted[i % p->jets.count] || law->uses[i];
    }
}

static bool rows_list(patch_rows *rows, int patches)
{
    AD_TAKE(rows, patch, (size_t)patches);
    AD_TAKE(rows, first, (size_t)patches + 1);
    AD_TAKE(rows, table, (size_t)patches);
    return !rows->memory.is_short;
}

static bool place_points(patch_window *w, patch_rows *rows)
{
    const patch_grid *grid = w->grid;
    const size_t all = rows->first[rows->patches];
    AD_TAKE(rows, x, (size_t)grid->dims * all);
    for (int k = 0; k < rows->patches && rows->x; k++) {
        const patch_table *table = patch_rows_table(rows, k);
        const size_t points = (size_t)table->points;
        for (int d = 0; d < grid->dims; d++) {
            for (size_t q = 0; q < points; q++) {
                rows->x[(size_t)d * all + rows->first[k] + q] =
                    patch_place(grid, rows->patch[k], d, table->local[(size_t)d * points + q]);
            }
        }
    }
    return rows->x != NULL;
}

/* The patch of each of `count` places, -1: in none of this window. */
static void find_owners(const patch_window *w, size_t count, const double *x, int *owner)
{
    const patch_grid *grid = w->grid;
    for (size_t i = 0; i < count; i++) {
        owner[i] = 0;
        for (int d = 0; d < grid->dims; d++) {
            const double at = x[(size_t)d * count + i];
            const double low = grid->edge[d][0]; /* what ends a window is not in the next one */
            const bool within = at <= grid->edge[d][grid->cells[d]] &&
                                (at > low || low == w->p->model->domain.coordinates[d].low);
            owner[i] = within && owner[i] >= 0
                           ? owner[i] + patch_cell_at(grid, d, at) * grid->stride[d]
                           : -1;
        }
    }
}

/* Points that a model gives, sorted into patches; data [rows][points] in this order. */
static ad_status place_given(patch_window *w, patch_rows *rows, double **data, ad_error *error)
{
    const patch_grid *grid = w->grid;
    const model_source *source = &rows->law->set->source;
    const size_t count = source->points, dims = (size_t)grid->dims;
    bool wanted[PATCH_JETS];
    double *x = malloc(dims * count * sizeof *x), *local = malloc(dims * count * sizeof *local);
    double *values = malloc((size_t)(source->rows + 1) * count * sizeof *values);
    int *owner = malloc(count * sizeof *owner);
    size_t *from = malloc(count * sizeof *from); /* by patch */
    size_t *end = calloc((size_t)grid->patches + 1, sizeof *end), kept = 0;
    bool has_memory =
        x && values && local && owner && from && end && rows_list(rows, grid->patches);
    nn_rng rng = nn_rng_split(1, rows->law->set->name);
    ad_status status =
        has_memory
            ? source->fill(source->context,
                           &(model_draw){.count = count, .rng = &rng, .x = x, .data = values},
                           error)
            : ad_fail(error, AD_NO_MEMORY, "out of memory for data");
    wants_of(w->p, rows->law, wanted);
    if (status == AD_OK) {
        find_owners(w, count, x, owner);
        for (size_t i = 0; i < count; i++) {
            end[owner[i] + 1]++; /* those of no patch come first, and are left out below */
        }
        end[0] = 0;
        for (int k = 0; k < grid->patches; k++) {
            end[k + 1] += end[k];
        }
        kept = end[grid->patches];
        for (size_t i = 0; i < count; i++) {
            if (owner[i] >= 0) {
                from[end[owner[i]]++] = i; /* so end[k] becomes where k ends */
            }
        }
    }
    for (int k = 0; k < grid->patches && status == AD_OK; k++) {
        const size_t first = rows->first[rows->patches], here = end[k] - first;
        for (size_t q = 0; q < here; q++) {
            for (int d = 0; d < grid->dims; d++) {
                const double *edge = grid->edge[d] + patch_cell(grid, k, d);
                local[(size_t)d * here + q] =
                    2 * (x[(size_t)d * count + from[first + q]] - edge[0]) / (edge[1] - edge[0]) -
                    1;
            }
        }
        if (here > 0) {
            rows->patch[rows->patches] = k;
            rows->first[rows->patches + 1] = end[k];
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
    free(end);
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
    for (int k = 0; k < w->grid->patches; k++) {
        if (touches(w->grid, k, end)) {
            rows->patch[rows->patches++] = k;
            rows->first[rows->patches] = (size_t)rows->patches * (size_t)rows->table->points;
        }
    }
    return AD_OK;
}

/* ---- inputs and outputs of a law ------------------------------------------------------------- */

static ad_status connect(patch_window *w, patch_rows *rows, const double *data, ad_error *error)
{
    const patch_problem *p = w->p;
    const patch_law *law = rows->law;
    const size_t points = rows->first[rows->patches];
    const size_t all = (size_t)p->outputs * (size_t)p->jets.count;
    const size_t results = (size_t)law->rows + (size_t)law->entry_count;
    const size_t data_rows = (size_t)law->set->source.rows;
    size_t used = 0, at = 0;
    for (size_t i = 0; i < all; i++) {
        used += law->uses[i];
    }
    AD_TAKE(rows, numbers, (used + (size_t)p->unknowns + data_rows + results) * points + 1);
    AD_TAKE(rows, inputs, patch_inputs(p, law));
    AD_TAKE(rows, outputs, results);
    AD_TAKE(rows, factor, (size_t)law->rows);
    if (rows->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for residuals");
    }
    for (int d = 0; d < p->dims; d++) {
        rows->inputs[d] = rows->inputs[patch_input_about(p, law, d)] = rows->x + (size_t)d * points;
    }
    for (size_t i = 0; i < all; i++) { /* what is not used is not read */
        rows->inputs[patch_input_jet(p, i)] =
            law->uses[i] ? rows->numbers + points * at++ : rows->x;
    }
    rows->unknowns = rows->numbers + points * at;
    for (int i = 0; i < p->unknowns; i++) {
        rows->inputs[patch_input_unknown(p, i)] = rows->numbers + points * at++;
    }
    if (data_rows > 0) {
        rows->inputs[patch_input_data(p)] = rows->numbers + points * at;
        memcpy(rows->numbers + points * at, data, data_rows * points * sizeof *data);
        at += data_rows;
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
    AD_TAKE(w, joints, (size_t)grid->patches * PATCH_DIMS);
    /* the start may jump from patch to patch */
    for (int k = 0; k < grid->patches && w->joints && w->phase != PATCH_START; k++) {
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

size_t patch_before_size(const patch_window *w)
{
    size_t rows = 0;
    for (int f = 0; f < w->p->outputs; f++) {
        rows += (size_t)w->p->order[f][w->p->model->domain.time];
    }
    return rows * (size_t)w->grid->patches * (size_t)w->start.points;
}

/* What they are, in the order output, derivative, patch, point. */
static void fill_before(const patch_window *w, const patch_grid *before, const double *c,
                        double *to)
{
    const patch_grid *grid = w->grid;
    const int time = w->p->model->domain.time;
    const size_t points = (size_t)w->start.points;
    for (int f = 0; f < w->p->outputs; f++) {
        for (int k = 0; k < w->p->order[f][time]; k++) {
            for (int patch = 0; patch < grid->patches; patch++) {
                for (size_t q = 0; q < points; q++) {
                    int order[PATCH_DIMS] = {0};
                    double x[PATCH_DIMS];
                    order[time] = k;
                    for (int d = 0; d < grid->dims; d++) {
                        x[d] = patch_place(grid, patch, d, w->start.local[(size_t)d * points + q]);
                    }
                    *to++ = patch_grid_at(before, c, f, order, x);
                }
            }
        }
    }
}

/* And how it changes with the unknowns. */
static bool make_before(patch_window *w, const patch_grid *before)
{
    const size_t all = patch_before_size(w), unknowns = (size_t)w->p->unknowns;
    AD_TAKE(w, before, (1 + unknowns) * all);
    if (w->before) {
        fill_before(w, before, before->c, w->before);
    }
    for (size_t g = 0; g < unknowns && w->before; g++) {
        fill_before(w, before,
                    before->slopes + g * (size_t)before->patches * patch_grid_size(before),
                    w->before + (1 + g) * all);
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
        ad_memory_free(&rows->memory);
    }
    for (int d = 0; d < PATCH_DIMS; d++) {
        patch_table_clear(&w->low[d]);
        patch_table_clear(&w->high[d]);
    }
    patch_table_clear(&w->start);
    ad_memory_free(&w->memory);
    *w = (patch_window){.law_count = 0};
}
