#include "tools/environment/distance_grid.h"

#include "tools/files/checkpoint.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static size_t total(const distance_grid *g)
{
    return g->count[0] * g->count[1] * g->count[2];
}

/* Cubes, and one beyond the surface on each side. */
static void lay_out(distance_grid *g, const surface *of, size_t nodes)
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
            g->count[i] = (size_t)ceil(size[i] / g->cell) + 3;
            needed *= (double)g->count[i];
        }
        if (needed <= (double)nodes || g->cell > longest) {
            return;
        }
    }
}

/* Along a row each distance is no more than the one before and a cell. */
static void fill(distance_grid *g, const environment *of)
{
    double *to = g->value;
    for (size_t k = 0; k < g->count[2]; k++) {
        for (size_t j = 0; j < g->count[1]; j++) {
            double within = INFINITY;
            for (size_t i = 0; i < g->count[0]; i++, to++) {
                const double p[3] = {g->low[0] + g->cell * (double)i,
                                     g->low[1] + g->cell * (double)j,
                                     g->low[2] + g->cell * (double)k};
                *to = environment_distance(of, p, within);
                within = fabs(*to) + g->cell;
            }
        }
    }
}

/* ---- the file -------------------------------------------------------------------------------- */

/* False: there is none, or it is another's. */
static bool read_kept(distance_grid *g, const char *file, uint64_t seal)
{
    checkpoint *cp = NULL;
    uint64_t of_file = 0;
    const bool fits = checkpoint_open(file, &cp, NULL) == AD_OK &&
                      checkpoint_get_uint64(cp, "surface", &of_file, 1, NULL) == AD_OK &&
                      of_file == seal &&
                      checkpoint_get_doubles(cp, "distance", g->value, total(g), NULL) == AD_OK;
    checkpoint_free(cp);
    return fits;
}

static void keep(const distance_grid *g, const char *file, uint64_t seal)
{
    checkpoint *const cp = checkpoint_create(CPINN_VERSION);
    if (cp) {
        (void)checkpoint_put_uint64(cp, "surface", &seal, 0, NULL);
        (void)checkpoint_put_doubles(cp, "low", g->low, 1, (const size_t[1]){3});
        (void)checkpoint_put_double(cp, "cell", g->cell);
        (void)checkpoint_put_doubles(cp, "distance", g->value, 3,
                                     (const size_t[3]){g->count[2], g->count[1], g->count[0]});
        (void)checkpoint_write(cp, &(file_place){.path = file}, NULL); /* made anew next time */
        checkpoint_free(cp);
    }
}

ad_status distance_grid_create(const environment *of, environment_side side, size_t nodes,
                               const char *file, distance_grid **result, ad_error *error)
{
    const surface *const s = environment_surface(of);
    *result = NULL;
    distance_grid *const g = calloc(1, sizeof *g);
    if (g) {
        lay_out(g, s, nodes);
        g->value = malloc(total(g) * sizeof *g->value);
    }
    if (!g || !g->value) {
        distance_grid_free(g);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a grid of %zu distances", nodes);
    }
    g->inside = side == ENVIRONMENT_INSIDE;
    memcpy(g->surface_low, s->low, sizeof s->low);
    memcpy(g->surface_high, s->high, sizeof s->high);
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

void distance_grid_free(distance_grid *of)
{
    if (of) {
        free(of->value);
        free(of);
    }
}

/* ---- asking ---------------------------------------------------------------------------------- */

/* Of a point beyond the box of the surface, from that box. */
static double from_box(const distance_grid *g, const double p[3])
{
    double square = 0;
    for (int i = 0; i < 3; i++) {
        const double off = fmax(fmax(g->surface_low[i] - p[i], p[i] - g->surface_high[i]), 0);
        square += off * off;
    }
    return g->inside ? -sqrt(square) : sqrt(square);
}

double distance_grid_at(const distance_grid *of, const double p[3])
{
    size_t at[3];
    double part[3];
    for (int i = 0; i < 3; i++) {
        const double x = (p[i] - of->low[i]) / of->cell;
        if (!(x >= 0 && x < (double)(of->count[i] - 1))) {
            return from_box(of, p);
        }
        at[i] = (size_t)x;
        part[i] = x - (double)at[i];
    }
    const double *const v = &of->value[(at[2] * of->count[1] + at[1]) * of->count[0] + at[0]];
    const size_t up[2] = {of->count[0], of->count[0] * of->count[1]};
    double plane[2];
    for (size_t k = 0; k < 2; k++) {
        const double *const w = v + k * up[1];
        const double low = w[0] + part[0] * (w[1] - w[0]);
        const double high = w[up[0]] + part[0] * (w[up[0] + 1] - w[up[0]]);
        plane[k] = low + part[1] * (high - low);
    }
    return plane[0] + part[2] * (plane[1] - plane[0]);
}

double distance_grid_error(const distance_grid *of)
{
    return sqrt(3) / 2 * of->cell;
}
