#include "tools/environment/distance_grid.h"

#include "tools/files/checkpoint.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t total(const distance_grid *g)
{
    const int *const count = g->field.count;
    return (size_t)count[0] * (size_t)count[1] * (size_t)count[2];
}

/* Cubes, and one beyond the surface on each side. */
static void lay_out(distance_field *g, const surface *of, size_t nodes)
{
    double size[3], longest = 0;
    for (int i = 0; i < 3; i++) {
        size[i] = of->high[i] - of->low[i];
        longest = fmax(longest, size[i]);
    }
    double volume = 1;
    for (int i = 0; i < 3; i++) {
        volume *= fmax(size[i], longest / 100); /* flat ones have some thickness */
    }
    for (g->cell = cbrt(volume / (double)nodes);; g->cell *= 1.01) {
        double needed = 1;
        for (int i = 0; i < 3; i++) {
            g->low[i] = of->low[i] - g->cell;
            g->count[i] = (int)ceil(size[i] / g->cell) + 3;
            needed *= g->count[i];
        }
        if (needed <= (double)nodes || g->cell > longest) {
            return;
        }
    }
}

/* Along a row each distance is no more than the one before and a cell. */
static void fill(distance_grid *g, const environment *of)
{
    const distance_field *const f = &g->field;
    float *to = g->value;
    for (int k = 0; k < f->count[2]; k++) {
        for (int j = 0; j < f->count[1]; j++) {
            double within = INFINITY;
            for (int i = 0; i < f->count[0]; i++, to++) {
                const double p[3] = {f->low[0] + f->cell * i, f->low[1] + f->cell * j,
                                     f->low[2] + f->cell * k};
                const double distance = environment_distance(of, p, within);
                within = fabs(distance) + f->cell;
                *to = (float)distance;
            }
        }
    }
}

/* ---- the file -------------------------------------------------------------------------------- */

/* False: there is none, it is another's, or there is no memory. */
static bool read_kept(distance_grid *g, const char *file, uint64_t seal)
{
    checkpoint *cp = NULL;
    uint64_t of_file = 0;
    double *const values = malloc(total(g) * sizeof *values);
    const bool fits = values && checkpoint_open(file, &cp, NULL) == AD_OK &&
                      checkpoint_get_uint64(cp, "surface", &of_file, 1, NULL) == AD_OK &&
                      of_file == seal &&
                      checkpoint_get_doubles(cp, "distance", values, total(g), NULL) == AD_OK;
    for (size_t i = 0; i < total(g) && fits; i++) {
        g->value[i] = (float)values[i];
    }
    free(values);
    checkpoint_free(cp);
    return fits;
}

static void keep(const distance_grid *g, const char *file, uint64_t seal)
{
    checkpoint *const cp = checkpoint_create(CPINN_VERSION);
    double *const values = malloc(total(g) * sizeof *values);
    if (cp && values) {
        const size_t size[3] = {(size_t)g->field.count[2], (size_t)g->field.count[1],
                                (size_t)g->field.count[0]};
        for (size_t i = 0; i < total(g); i++) {
            values[i] = g->value[i];
        }
        (void)checkpoint_put_uint64(cp, "surface", &seal, 0, NULL);
        (void)checkpoint_put_doubles(cp, "low", g->field.low, 1, (const size_t[1]){3});
        (void)checkpoint_put_double(cp, "cell", g->field.cell);
        (void)checkpoint_put_doubles(cp, "distance", values, 3, size);
        (void)checkpoint_write(cp, &(file_place){.path = file}, NULL); /* made anew next time */
    }
    free(values);
    checkpoint_free(cp);
}

ad_status distance_grid_create(const environment *of, environment_side side, size_t nodes,
                               const char *file, distance_grid **result, ad_error *error)
{
    const surface *const s = environment_surface(of);
    *result = NULL;
    distance_grid *const g = calloc(1, sizeof *g);
    if (g) {
        lay_out(&g->field, s, nodes);
        g->value = malloc(total(g) * sizeof *g->value);
    }
    if (!g || !g->value) {
        distance_grid_free(g);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a grid of %zu distances", nodes);
    }
    g->field.value = g->value;
    g->field.inside = side == ENVIRONMENT_INSIDE;
    memcpy(g->field.box_low, s->low, sizeof s->low);
    memcpy(g->field.box_high, s->high, sizeof s->high);
    const uint64_t numbers[2] = {(uint64_t)side, (uint64_t)nodes};
    const uint64_t seal = checkpoint_hash(s->hash, numbers, sizeof numbers);
    g->was_kept = file && read_kept(g, file, seal);
    if (!g->was_kept) {
        fill(g, of);
        if (file) {
            keep(g, file, seal);
        }
    }
    *result = g;
    return AD_OK;
}

static ad_status create_beside(const environment *of, environment_side side, distance_grid **result,
                               ad_error *error)
{
    enum { NODES = 400000 };
    const char *const file = environment_surface(of)->name, *const dot = strrchr(file, '.');
    const int stem = (int)(dot ? dot - file : (ptrdiff_t)strlen(file));
    char *const kept = malloc((size_t)stem + sizeof ".distances.h5");
    *result = NULL;
    if (!kept) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a name");
    }
    sprintf(kept, "%.*s.distances.h5", stem, file);
    const ad_status status = distance_grid_create(of, side, NODES, kept, result, error);
    free(kept);
    return status;
}

ad_status distance_grid_open(const environment_settings *of, double length, environment **around,
                             distance_grid **grid, ad_error *error)
{
    const ad_status status = environment_open(of, length, around, error);
    *grid = NULL;
    return status == AD_OK ? create_beside(*around, of->side, grid, error) : status;
}

void distance_grid_free(distance_grid *of)
{
    if (of) {
        free(of->value);
        free(of);
    }
}

double distance_grid_error(const distance_grid *of)
{
    return (1 + 1e-5) * sqrt(3) / 2 * of->field.cell;
}
