#include "tools/environment/environment.h"

#include "physics/numerics/quaternion.h"
#include "physics/numerics/triangle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct environment {
    surface *of;
    double sign; /* 1: outside of the surface is free, -1: inside; 0: both */
    double size;
    double *normal; /* [corners][3], sums of those of triangles weighted by their angles */
    surface_tree *tree;
};

static void corners_of(const surface *of, size_t triangle, const double *corners[3])
{
    for (size_t k = 0; k < 3; k++) {
        corners[k] = &of->corner[3 * (size_t)of->triangle[3 * triangle + k]];
    }
}

static double norm(const double v[3])
{
    return sqrt(vector_dot(v, v));
}

static void unit_normal(const surface *of, size_t triangle, double normal[3])
{
    const double *c[3];
    double one[3], other[3];
    corners_of(of, triangle, c);
    for (int i = 0; i < 3; i++) {
        one[i] = c[1][i] - c[0][i];
        other[i] = c[2][i] - c[0][i];
    }
    vector_cross(one, other, normal);
    const double length = norm(normal);
    for (int i = 0; i < 3; i++) {
        normal[i] /= length;
    }
}

static double angle_at(const double *const corners[3], int k)
{
    double a[3], b[3], normal[3];
    for (int i = 0; i < 3; i++) {
        a[i] = corners[(k + 1) % 3][i] - corners[k][i];
        b[i] = corners[(k + 2) % 3][i] - corners[k][i];
    }
    vector_cross(a, b, normal);
    return atan2(norm(normal), vector_dot(a, b));
}

static void find_normals(environment *e)
{
    const surface *const of = e->of;
    for (size_t i = 0; i < of->triangles; i++) {
        const double *corners[3];
        double normal[3];
        corners_of(of, i, corners);
        unit_normal(of, i, normal);
        for (int k = 0; k < 3; k++) {
            double *const to = &e->normal[3 * (size_t)of->triangle[3 * i + (size_t)k]];
            const double angle = angle_at(corners, k);
            for (int j = 0; j < 3; j++) {
                to[j] += angle * normal[j];
            }
        }
    }
}

/* ---- the nearest triangle -------------------------------------------------------------------- */

typedef struct search {
    const environment *e;
    const double *a, *b; /* b NULL: of the point a */
    double best;
    triangle_nearest nearest;
    size_t triangle; /* of the surface; SURFACE_NONE */
} search;

static void run(search *s)
{
    const environment *const e = s->e;
    s->best =
        triangle_tree_nearest(&e->tree->tree, e->of->corner, s->a, s->b, s->best, &s->nearest);
    s->triangle =
        s->nearest.triangle < 0 ? SURFACE_NONE : (size_t)e->tree->number[s->nearest.triangle];
}

/* Of the nearest triangle, also where it is further than was said. */
static void find_nearest(search *s)
{
    run(s);
    if (s->triangle == SURFACE_NONE && s->best < INFINITY) {
        s->best = INFINITY;
        run(s);
    }
}

/* ---- distances ------------------------------------------------------------------------------- */

/* The normal at the nearest place, outwards, of any length. */
static void find_normal(const search *s, double normal[3])
{
    const surface *const of = s->e->of;
    double other[3];
    if (s->nearest.part < TRIANGLE_EDGE) {
        const size_t corner = of->triangle[3 * s->triangle + (size_t)s->nearest.part];
        memcpy(normal, &s->e->normal[3 * corner], 3 * sizeof *normal);
        return;
    }
    unit_normal(of, s->triangle, normal);
    if (s->nearest.part < TRIANGLE_WITHIN) {
        unit_normal(of, of->neighbour[3 * s->triangle + (size_t)(s->nearest.part - TRIANGLE_EDGE)],
                    other);
        for (int i = 0; i < 3; i++) {
            normal[i] += other[i];
        }
    }
}

/* Whether a point is outside, by that normal. */
static bool is_outside(const search *s, const double normal[3])
{
    const double *corners[3], *from = s->nearest.place;
    double to[3];
    if (s->nearest.part == TRIANGLE_WITHIN) { /* rounding of the foot does not count */
        corners_of(s->e->of, s->triangle, corners);
        from = corners[0];
    }
    for (int i = 0; i < 3; i++) {
        to[i] = s->a[i] - from[i];
    }
    return vector_dot(to, normal) >= 0;
}

static double signed_distance(const search *s)
{
    double normal[3];
    if (s->e->sign == 0) {
        return s->best;
    }
    find_normal(s, normal);
    return is_outside(s, normal) ? s->e->sign * s->best : -s->e->sign * s->best;
}

double environment_distance(const environment *of, const double p[3], double within)
{
    search s = {.e = of, .a = p, .best = within * (1 + 1e-12)};
    find_nearest(&s);
    return s.triangle == SURFACE_NONE ? NAN : signed_distance(&s);
}

/* Of the size: nearer than so the way from the nearest place is rounding. */
static const double TOUCHES = 1e-12;

double environment_slope(const environment *of, const double p[3], double slope[3])
{
    search s = {.e = of, .a = p, .best = INFINITY};
    find_nearest(&s);
    if (s.triangle == SURFACE_NONE) {
        slope[0] = slope[1] = slope[2] = NAN;
        return NAN;
    }
    const double distance = signed_distance(&s);
    double normal[3] = {0}, over = 0;
    const bool touches = s.best < TOUCHES * of->size;
    const bool by_normal = touches || (s.nearest.part == TRIANGLE_WITHIN && of->sign != 0);
    if (by_normal && of->sign != 0) {
        find_normal(&s, normal);
        over = of->sign / norm(normal);
    }
    for (int i = 0; i < 3; i++) {
        slope[i] = by_normal ? over * normal[i] : (p[i] - s.nearest.place[i]) / distance;
    }
    return distance;
}

double environment_segment(const environment *of, const double a[3], const double b[3],
                           double within)
{
    search s = {.e = of, .a = a, .b = b, .best = within * (1 + 1e-12)};
    find_nearest(&s);
    if (s.triangle == SURFACE_NONE) {
        return NAN;
    }
    const double reach = s.best + vector_distance(a, b);
    return of->sign == 0 || environment_distance(of, a, reach) >= 0 ? s.best : -s.best;
}

bool environment_is_beyond(const environment *of, const double a[3], const double b[3],
                           double distance)
{
    search s = {.e = of, .a = a, .b = b, .best = distance * (1 + 1e-12)};
    run(&s);
    return s.triangle == SURFACE_NONE;
}

double environment_winding(const environment *of, const double p[3])
{
    double sum = 0;
    for (size_t t = 0; t < of->of->triangles; t++) {
        const double *corners[3];
        double to[3][3], length[3];
        corners_of(of->of, t, corners);
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < 3; i++) {
                to[k][i] = corners[k][i] - p[i];
            }
            length[k] = norm(to[k]);
        }
        double normal[3];
        vector_cross(to[1], to[2], normal);
        const double volume = vector_dot(to[0], normal);
        const double below_it =
            length[0] * length[1] * length[2] + vector_dot(to[0], to[1]) * length[2] +
            vector_dot(to[1], to[2]) * length[0] + vector_dot(to[2], to[0]) * length[1];
        sum += 2 * atan2(volume, below_it);
    }
    return sum / (4 * acos(-1));
}

/* ---- making ---------------------------------------------------------------------------------- */

ad_status environment_create(surface *of, environment_side side, environment **result,
                             ad_error *error)
{
    *result = NULL;
    ad_status status = side == ENVIRONMENT_ANY ? AD_OK : surface_check_closed(of, error);
    environment *const e = status == AD_OK ? calloc(1, sizeof *e) : NULL;
    if (!e) {
        surface_free(of);
        return status == AD_OK ? ad_fail(error, AD_NO_MEMORY, "out of memory for an environment")
                               : status;
    }
    e->of = of;
    e->sign = side == ENVIRONMENT_ANY ? 0 : side == ENVIRONMENT_OUTSIDE ? 1 : -1;
    for (int i = 0; i < 3; i++) {
        e->size = fmax(e->size, of->high[i] - of->low[i]);
    }
    e->normal = calloc(3 * of->corners, sizeof *e->normal);
    if (e->normal) {
        find_normals(e);
        status = surface_tree_create(of, side, &e->tree, error);
    } else {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for an environment");
    }
    if (status != AD_OK) {
        environment_free(e);
        return status;
    }
    *result = e;
    return AD_OK;
}

void environment_free(environment *of)
{
    if (of) {
        surface_tree_free(of->tree);
        surface_free(of->of);
        free(of->normal);
        free(of);
    }
}

const surface *environment_surface(const environment *of)
{
    return of->of;
}

const surface_tree *environment_tree(const environment *of)
{
    return of->tree;
}
