/* A solution as numbers that last. */
#include "physics/learn/patches_run.h"

#include <stdlib.h>
#include <string.h>

/* Summary, windows; of a window its two grids; of a grid cells, degrees, edges, coefficients. */
static double *put_grid(const patch_grid *grid, double *to)
{
    for (int d = 0; d < grid->dims; d++) {
        *to++ = grid->cells[d];
        *to++ = grid->degree[d];
        memcpy(to, grid->edge[d], ((size_t)grid->cells[d] + 1) * sizeof *to);
        to += grid->cells[d] + 1;
    }
    const size_t numbers = (size_t)grid->patches * patch_grid_size(grid);
    memcpy(to, grid->c, numbers * sizeof *to);
    return to + numbers;
}

enum { SUMMARY_PLAIN = 11, SUMMARY_NUMBERS = SUMMARY_PLAIN + 2 * MODEL_UNKNOWNS_MAX };

size_t patches_numbers(const patches *p)
{
    size_t count = SUMMARY_NUMBERS + 1;
    for (int i = 0; i < p->count; i++) {
        const patch_grid *grids[] = {&p->window[i].found, &p->window[i].richer};
        for (int k = 0; k < 2; k++) {
            count += (size_t)grids[k]->patches * patch_grid_size(grids[k]);
            for (int d = 0; d < grids[k]->dims; d++) {
                count += 3 + (size_t)grids[k]->cells[d];
            }
        }
    }
    return count;
}

void patches_write(const patches *p, double *numbers)
{
    const patches_summary *s = &p->summary;
    double *to = numbers;
    const double plain[SUMMARY_PLAIN] = {
        s->end,     s->estimate,     s->by_unknowns,        s->done,  s->seconds, s->attempts,
        s->windows, s->most_patches, (double)s->parameters, s->steps, s->unknowns};
    memcpy(to, plain, sizeof plain);
    memcpy(to + SUMMARY_PLAIN, s->unknown, sizeof s->unknown);
    memcpy(to + SUMMARY_PLAIN + MODEL_UNKNOWNS_MAX, s->deviation, sizeof s->deviation);
    to[SUMMARY_NUMBERS] = p->count;
    to += SUMMARY_NUMBERS + 1;
    for (int i = 0; i < p->count; i++) {
        to = put_grid(&p->window[i].richer, put_grid(&p->window[i].found, to));
    }
}

/* Takes a grid from *from up to `end`; false: it is not one. */
static bool take_grid(const physics_model *m, const double **from, const double *end,
                      patch_grid *grid, bool *has_memory)
{
    const double *at = *from;
    int cells[PATCH_DIMS], degree[PATCH_DIMS];
    double *edges[PATCH_DIMS];
    for (int d = 0; d < m->domain.count; d++) {
        if (end - at < 4 || !(at[0] >= 1 && at[0] <= 1e6 && at[1] >= 0 && at[1] <= PATCH_DEGREE) ||
            end - at < 3 + (ptrdiff_t)at[0]) {
            return false;
        }
        cells[d] = (int)at[0];
        degree[d] = (int)at[1];
        edges[d] = (double *)at + 2; /* only read */
        at += 3 + cells[d];
        for (int i = 0; i < cells[d]; i++) {
            if (!(edges[d][i] < edges[d][i + 1])) {
                return false;
            }
        }
    }
    size_t numbers = (size_t)m->outputs;
    for (int d = 0; d < m->domain.count; d++) {
        numbers *= (size_t)cells[d] * (size_t)(degree[d] + 1);
        if (numbers > (size_t)(end - at)) {
            return false;
        }
    }
    *has_memory = patch_grid_create(grid, m->domain.count, m->outputs, cells, edges, degree);
    if (*has_memory) {
        memcpy(grid->c, at, numbers * sizeof *grid->c);
    }
    *from = at + numbers;
    return true;
}

static void take_summary(const double *from, patches_summary *s)
{
    *s = (patches_summary){.end = (patches_end)from[0],
                           .estimate = from[1],
                           .by_unknowns = from[2],
                           .done = from[3],
                           .seconds = from[4],
                           .attempts = (int)from[5],
                           .windows = (int)from[6],
                           .most_patches = (int)from[7],
                           .parameters = (size_t)from[8],
                           .steps = (int)from[9],
                           .unknowns = (int)from[10]};
    memcpy(s->unknown, from + SUMMARY_PLAIN, sizeof s->unknown);
    memcpy(s->deviation, from + SUMMARY_PLAIN + MODEL_UNKNOWNS_MAX, sizeof s->deviation);
}

ad_status patches_read(const physics_model *m, size_t count, const double *numbers,
                       patches **result, ad_error *error)
{
    const double *from = numbers + SUMMARY_NUMBERS + 1, *end = numbers + count;
    patches *p = *result = calloc(1, sizeof **result);
    bool sound = p && count > SUMMARY_NUMBERS && numbers[0] >= 0 &&
                 numbers[0] < PATCHES_END_COUNT && numbers[10] >= 0 &&
                 numbers[10] <= MODEL_UNKNOWNS_MAX && numbers[SUMMARY_NUMBERS] >= 0 &&
                 numbers[SUMMARY_NUMBERS] <= 1e7;
    bool has_memory = p != NULL;
    const int windows = sound ? (int)numbers[SUMMARY_NUMBERS] : 0;
    if (sound) {
        p->model = m;
        take_summary(numbers, &p->summary);
    }
    for (int i = 0; i < windows && sound && has_memory; i++) {
        patch_grid found = {.dims = 0}, richer = {.dims = 0};
        sound = take_grid(m, &from, end, &found, &has_memory) && has_memory &&
                take_grid(m, &from, end, &richer, &has_memory);
        has_memory = has_memory && (!sound || patches_keep(p, &found, &richer));
        patch_grid_clear(&found);
        patch_grid_clear(&richer);
    }
    if (sound && has_memory && from == end) {
        return AD_OK;
    }
    patches_free(p);
    *result = NULL;
    return has_memory ? ad_fail(error, AD_BAD_INPUT,
                                "these numbers are not of a solution of this model; allowed: what "
                                "was written for the same coordinates and fields")
                      : patch_no_memory(error);
}
