/* Whether vibrations of a rod about its equilibrium grow: by strain modes (modes.h), in which the
 * linearised motion is M y_tt + D y_t + K y = 0 with the exact derivatives of all forces. */
#include "autodiff/dense.h"
#include "physics/chain/modes_internal.h"
#include "physics/numerics/sort.h"
#include "physics/rod/rod.h"
#include "physics/scene/support.h"
#include "physics/solve/stability.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a rod that has none: by mass L^2, as that of a round one of length 50 radii. */
static const double ROTARY = 1e-4;

/* What the equilibrium of the modes may be off that of the solution, over the length. */
static const double SAME_SHAPE = 1e-3;

/* Slower vibrations than this, over the slowest: rounding has their phase to 1e-8. */
static const double FASTEST = 1e4;

/* ---- the scene in motion ------------------------------------------------------------------- */

static bool follows(const scene_rod *rod)
{
    return rod->section != SCENE_SECTION_NONE && rod->density.is_given;
}

/* The same rod and loads, let go; *massless: of a mass that nobody has given, and is the same all
 * along. */
static scene in_motion(const scene *still, bool *massless)
{
    scene moving = *still;
    scene_rod *rod = &moving.rod;
    *massless = false;
    for (int i = 0; i < scene_pieces(still); i++) {
        const scene_piece piece = scene_piece_of(still, i);
        *massless |= !follows(&piece.rod) && !piece.rod.mass_per_length.is_given;
    }
    if (*massless) {
        rod->mass_per_length = quantity_number(1);
    }
    if (!quantity_any_something(3, rod->rotary_inertia) && !follows(rod)) {
        const quantity mass = scene_properties_of(&moving).mass_per_length;
        const double length = scene_length(still);
        for (int i = 0; i < 3; i++) {
            rod->rotary_inertia[i] =
                quantity_scale(mass, (i < 2 ? 1 : 2) * ROTARY * length * length);
        }
    }
    for (int i = 0; i < 3; i++) {
        rod->imperfection[i] = quantity_number(0);
    }
    moving.duration = quantity_number(1);
    moving.duration = quantity_number(rod_scales_of(&moving).time);
    moving.windows = 1;
    return moving;
}

/* Why it cannot be let go, in `why`. */
static bool is_refused(const scene *moving, char why[STABILITY_TEXT])
{
    const char *key = "";
    ad_error error;
    const char *what = scene_has_branch(moving)
                           ? "rod.material.maxwell: vibrations of a material that relaxes"
                       : scene_has_rubbing_tendons(moving)
                           ? "tendons[].friction: vibrations of a rod whose tendons stick"
                           : NULL;
    if (what) {
        snprintf(why, STABILITY_TEXT, "%s are not looked at", what);
        return true;
    }
    if (support_check(moving, SUPPORT_MODES, &key, &error) != AD_OK ||
        scene_check(moving, &key, &error) != AD_OK ||
        scene_physics_of(moving)->check(moving, &key, &error) != AD_OK) {
        snprintf(why, STABILITY_TEXT, "%.40s: %.150s", key, error.message);
    }
    return why[0] != '\0';
}

/* ---- the equilibrium in modes -------------------------------------------------------------- */

typedef struct released {
    modes *m;
    modes_linear at;
    double *memory;
    int free;                 /* motions, of so many first rows and columns of the matrices */
    const double *s, *values; /* [STABILITY_POINTS] m, [columns] of it, SI */
} released;

static ad_status allocate(released *released, ad_error *error)
{
    const size_t n = (size_t)released->m->size, square = (n + QUAD) * (size_t)released->m->width;
    double *at = released->memory = calloc(4 * n + 3 * square, sizeof *at);
    released->at.pivots = malloc((2 * n + 1) * sizeof *released->at.pivots);
    if (!at || !released->at.pivots) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu modes", n);
    }
    released->at.q = at;
    released->at.v = at + n;
    released->at.residual = at + 2 * n;
    released->at.a = at + 3 * n;
    released->at.by_q = at + 4 * n;
    released->at.by_v = released->at.by_q + square;
    released->at.factor = released->at.by_v + square;
    return AD_OK;
}

static void release(released *released)
{
    modes_free(released->m);
    free(released->at.pivots);
    free(released->memory);
}

/* The sample next to s, m, on the same side of all edges. */
static int sample_at(const released *released, double s)
{
    const int k = (int)sort_cell(STABILITY_POINTS - 1, released->s, s, false);
    return s - released->s[k] <= released->s[k + 1] - s ? k : k + 1;
}

static void sample(const released *released, int k, int column, int count, double *out)
{
    for (int i = 0; i < count; i++) {
        out[i] = released->values[(column + i) * STABILITY_POINTS + k];
    }
}

/* The modes nearest to the solution, and from them the equilibrium. */
static ad_status settle(const released *released, ad_error *error)
{
    const modes *m = released->m;
    const double length = m->rod->scales.length;
    double(*strains)[MODES_STRAINS] = malloc((size_t)m->points * sizeof *strains);
    if (!strains) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an equilibrium");
    }
    for (int p = 0; p < m->points; p++) {
        sample(released, sample_at(released, m->s[p] * length), 7, MODES_STRAINS, strains[p]);
        for (int c = MODES_U; c < MODES_STRAINS; c++) {
            strains[p][c] *= length;
        }
    }
    modes_project(m, (const double(*)[MODES_STRAINS])strains, released->at.q);
    free(strains);
    return modes_settle(released->m, &released->at, error);
}

/* The largest distance from the solution, over the length. */
static double distance(const released *released)
{
    const modes *m = released->m;
    const double length = m->rod->scales.length;
    double most = 0;
    for (int p = 0; p < m->points; p++) {
        const int k = sample_at(released, m->s[p] * length);
        double r[3], q[4], v[3], R[3][3], tangent[3], square = 0;
        sample(released, k, 0, 3, r);
        sample(released, k, 3, 4, q);
        sample(released, k, 7, 3, v);
        rotation_matrix(q, R);
        to_world(R, v, tangent);
        for (int i = 0; i < 3; i++) {
            const double on = r[i] + (m->s[p] * length - released->s[k]) * tangent[i];
            square += pow(on / length - m->point[p].r[i], 2);
        }
        most = fmax(most, sqrt(square));
    }
    return most;
}

/* ---- the linearised motion ----------------------------------------------------------------- */

/* By sigma = 1/lambda, which has the slowest vibrations to all digits: sigma^2 K y + sigma D y +
 * M y = 0, [sigma y; y] -> [-K^-1 (D sigma y + M y); sigma y]. companion [2n][2n], column-major. */
static bool set_companion(const released *released, double *companion)
{
    const modes *m = released->m;
    const int n = released->free, width = m->width, all = 2 * n;
    for (int c = 0; c < n; c++) {
        for (int r = 0; r < n; r++) {
            released->at.factor[c * n + r] = released->at.by_q[r * width + c];
        }
    }
    if (ad_dense_lu((size_t)n, released->at.factor, released->at.pivots) != 0) {
        return false;
    }
    for (int c = 0; c < all; c++) {
        double *column = companion + c * all, *right = released->at.residual;
        for (int r = 0; r < n; r++) {
            right[r] =
                -(c < n ? released->at.by_v[r * width + c]
                        : m->mass[(r > c - n ? r : c - n) * width + (r > c - n ? c - n : r)]);
            column[n + r] = r == c;
        }
        ad_dense_lu_solve((size_t)n, 1, released->at.factor, released->at.pivots, right);
        memcpy(column, right, (size_t)n * sizeof *right);
    }
    return true;
}

static bool is_damped(const released *released)
{
    double most = 0;
    for (int i = 0; i < released->free; i++) {
        for (int k = 0; k < released->free; k++) {
            most = fmax(most, fabs(released->at.by_v[i * released->m->width + k]));
        }
    }
    return most > 0;
}

/* What grows the most for its size. */
static void pick(int count, const double *real, const double *imaginary, double unit,
                 stability *result)
{
    double slowest = 0;
    result->share = -INFINITY;
    for (int i = 0; i < count; i++) {
        slowest = fmax(slowest, hypot(real[i], imaginary[i]));
    }
    for (int i = 0; i < count; i++) {
        const double size = hypot(real[i], imaginary[i]), share = real[i] / size;
        const double growth = real[i] / (size * size * unit);
        const bool alike = fabs(share - result->share) < 1e-9;
        if (size * FASTEST >= slowest &&
            (alike ? growth > result->growth : share > result->share)) {
            result->share = share;
            result->growth = growth;
            result->frequency = fabs(imaginary[i]) / (size * size * unit);
        }
    }
}

static ad_status find_growth(released *released, stability *result, ad_error *error)
{
    double *const matrices[3] = {released->at.by_q, released->at.by_v, released->m->mass};
    released->free = modes_end_free(released->m, 3, matrices);
    const size_t n = 2 * (size_t)released->free;
    double *companion = calloc(n * n + 2 * n + AD_DENSE_EIGEN_WORK(n), sizeof *companion);
    if (!companion) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu vibrations", n);
    }
    double *real = companion + n * n, *imaginary = real + n;
    result->damped = is_damped(released);
    if (set_companion(released, companion) &&
        ad_dense_eigenvalues(n, companion, real, imaginary, imaginary + n) == 0) {
        pick((int)n, real, imaginary, released->m->rod->scales.time, result);
    } else {
        snprintf(result->unknown, sizeof result->unknown, "the stiffness is singular");
    }
    free(companion);
    return AD_OK;
}

/* With so many modes of bending in each piece; *close: enough for the shape. */
static ad_status look(solve_rod *rod, const scene *still, int most, released *released,
                      stability *result, bool *close, ad_error *error)
{
    const int fewer = (most + 1) / 2, of[4] = {most, fewer, fewer, fewer};
    const modes_counts counts = modes_counts_in(still, of);
    ad_status status = modes_create(rod, NULL, &counts, 0, &released->m, error);
    status = status == AD_OK ? allocate(released, error) : status;
    status = status == AD_OK ? settle(released, error) : status;
    *close = status == AD_OK && distance(released) <= SAME_SHAPE;
    return *close ? find_growth(released, result, error) : status;
}

ad_status stability_of_motion(const scene *still, const double *values, stability *result,
                              ad_error *error)
{
    enum { FEW = 8, MOST = 24, BASE = 3 };
    const scene moving = in_motion(still, &result->massless);
    double s[STABILITY_POINTS];
    solve_rod *rod = NULL;
    bool close = false;
    if (is_refused(&moving, result->unknown)) {
        return AD_OK;
    }
    ad_status status = stability_points(still, s, error);
    status = status == AD_OK ? solve_rod_create(&moving, &rod, error) : status;
    for (int most = FEW; status == AD_OK && !close && most <= MOST; most += FEW) {
        released x = {.s = s, .values = values};
        const int each = most / scene_pieces(still) + BASE;
        status = look(rod, still, each < SOLVE_MODES_MAX ? each : SOLVE_MODES_MAX, &x, result,
                      &close, error);
        status = status == AD_NOT_FINITE ? AD_OK : status; /* not settled: more modes may */
        release(&x);
    }
    solve_rod_free(rod);
    if (status == AD_OK && !close) {
        snprintf(result->unknown, sizeof result->unknown, "it bends too much for strain modes");
    }
    return status;
}
