#include "tools/environment/environment.h"

#include "physics/numerics/triangle.h"
#include "physics/numerics/vector_size.h"

#include <embree3/rtcore.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct environment {
    surface *of;
    double sign; /* 1: outside of the surface is free, -1: inside; 0: both */
    double centre[3], size;
    double *normal; /* [corners][3], sums of those of triangles weighted by their angles */
    RTCDevice device;
    RTCScene scene;
};

bool environment_is_built(void)
{
    return true;
}

static void corners_of(const surface *of, size_t triangle, const double *corners[3])
{
    for (size_t k = 0; k < 3; k++) {
        corners[k] = &of->corner[3 * (size_t)of->triangle[3 * triangle + k]];
    }
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
    const double length = vector_length(normal);
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
    return atan2(vector_length(normal), vector_dot(a, b));
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

/* ---- Embree ---------------------------------------------------------------------------------- */

/* Embree's coordinates are from the middle of the surface. A float is within half of its last bit
 * of the double; the next one is beyond it. */
static float below(double value)
{
    return nextafterf((float)value, -INFINITY);
}

static float above(double value)
{
    return nextafterf((float)value, INFINITY);
}

static void bound(const struct RTCBoundsFunctionArguments *a)
{
    const environment *const e = a->geometryUserPtr;
    const double *corners[3];
    double low[3], high[3];
    corners_of(e->of, a->primID, corners);
    for (int i = 0; i < 3; i++) {
        low[i] = fmin(corners[0][i], fmin(corners[1][i], corners[2][i])) - e->centre[i];
        high[i] = fmax(corners[0][i], fmax(corners[1][i], corners[2][i])) - e->centre[i];
    }
    *a->bounds_o = (struct RTCBounds){.lower_x = below(low[0]),
                                      .lower_y = below(low[1]),
                                      .lower_z = below(low[2]),
                                      .upper_x = above(high[0]),
                                      .upper_y = above(high[1]),
                                      .upper_z = above(high[2])};
}

typedef struct search {
    const environment *e;
    const double *a, *b; /* b NULL: of the point a */
    double best;
    double further; /* from the point that Embree is asked for to those that are meant */
    double nearest[3];
    size_t triangle;
    int part;
} search;

/* What Embree may leave out is farther than `best` from all that is meant: `further` is exact but
 * for rounding of doubles, squares of distances in floats are off by less than 1e-6 of them, and
 * what is added keeps them from vanishing. */
static float radius_of(const search *s)
{
    const double radius = (s->best + s->further) * (1 + 1e-6) + 1e-9 * s->e->size;
    return radius < FLT_MAX ? above(radius) : INFINITY;
}

static bool measure(struct RTCPointQueryFunctionArguments *a)
{
    search *const s = a->userPtr;
    const double *corners[3];
    corners_of(s->e->of, a->primID, corners);
    double nearest[3];
    int part = TRIANGLE_WITHIN;
    if (triangle_is_beyond(corners, s->a, s->b ? s->b : s->a, s->best)) {
        return false;
    }
    const double distance = s->b ? triangle_segment_distance(corners, s->a, s->b)
                                 : triangle_distance(corners, s->a, nearest, &part);
    if (!(distance < s->best || (distance == s->best && s->triangle == SURFACE_NONE))) {
        return false;
    }
    s->best = distance;
    s->triangle = a->primID;
    s->part = part;
    if (!s->b) {
        memcpy(s->nearest, nearest, sizeof nearest);
    }
    a->query->radius = radius_of(s);
    return true;
}

static void run(search *s, const double middle[3])
{
    const environment *const e = s->e;
    float p[3];
    double off = 0, far = 0;
    for (int i = 0; i < 3; i++) {
        const double at = middle[i] - e->centre[i];
        p[i] = (float)at;
        off += (at - p[i]) * (at - p[i]);
        far = fmax(far, fabs(at));
    }
    s->further += sqrt(off) + 4 * DBL_EPSILON * (far + e->size);
    s->triangle = SURFACE_NONE;
    struct RTCPointQuery query = {p[0], p[1], p[2], 0, radius_of(s)};
    struct RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(e->scene, &query, &context, NULL, s);
}

/* Of the nearest triangle, also where it is further than was said. */
static void find_nearest(search *s, const double middle[3])
{
    const double further = s->further;
    run(s, middle);
    if (s->triangle == SURFACE_NONE && s->best < INFINITY) {
        s->best = INFINITY;
        s->further = further;
        run(s, middle);
    }
}

/* ---- distances ------------------------------------------------------------------------------- */

/* The normal at the nearest place, outwards, of any length. */
static void find_normal(const search *s, double normal[3])
{
    const surface *const of = s->e->of;
    double other[3];
    if (s->part < TRIANGLE_EDGE) {
        const size_t corner = of->triangle[3 * s->triangle + (size_t)s->part];
        memcpy(normal, &s->e->normal[3 * corner], 3 * sizeof *normal);
        return;
    }
    unit_normal(of, s->triangle, normal);
    if (s->part < TRIANGLE_WITHIN) {
        unit_normal(of, of->neighbour[3 * s->triangle + (size_t)(s->part - TRIANGLE_EDGE)], other);
        for (int i = 0; i < 3; i++) {
            normal[i] += other[i];
        }
    }
}

/* Whether a point is outside, by that normal. */
static bool is_outside(const search *s, const double normal[3])
{
    const double *corners[3], *from = s->nearest;
    double to[3];
    if (s->part == TRIANGLE_WITHIN) { /* rounding of the foot does not count */
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
    find_nearest(&s, p);
    return s.triangle == SURFACE_NONE ? NAN : signed_distance(&s);
}

/* Of the size: nearer than so the way from the nearest place is rounding. */
static const double TOUCHES = 1e-12;

double environment_slope(const environment *of, const double p[3], double slope[3])
{
    search s = {.e = of, .a = p, .best = INFINITY};
    find_nearest(&s, p);
    if (s.triangle == SURFACE_NONE) {
        slope[0] = slope[1] = slope[2] = NAN;
        return NAN;
    }
    const double distance = signed_distance(&s);
    double normal[3] = {0}, over = 0;
    const bool touches = s.best < TOUCHES * of->size;
    const bool by_normal = touches || (s.part == TRIANGLE_WITHIN && of->sign != 0);
    if (by_normal && of->sign != 0) {
        find_normal(&s, normal);
        over = of->sign / vector_length(normal);
    }
    for (int i = 0; i < 3; i++) {
        slope[i] = by_normal ? over * normal[i] : (p[i] - s.nearest[i]) / distance;
    }
    return distance;
}

/* Of a line; its middle. */
static search search_line(const environment *of, const double a[3], const double b[3], double best,
                          double middle[3])
{
    double along[3];
    for (int i = 0; i < 3; i++) {
        middle[i] = (a[i] + b[i]) / 2;
        along[i] = (b[i] - a[i]) / 2;
    }
    return (search){.e = of, .a = a, .b = b, .best = best, .further = vector_length(along)};
}

double environment_segment(const environment *of, const double a[3], const double b[3],
                           double within)
{
    double middle[3];
    search s = search_line(of, a, b, within * (1 + 1e-12), middle);
    const double half = s.further;
    find_nearest(&s, middle);
    if (s.triangle == SURFACE_NONE) {
        return NAN;
    }
    return of->sign == 0 || environment_distance(of, a, s.best + 2 * half) >= 0 ? s.best : -s.best;
}

bool environment_is_beyond(const environment *of, const double a[3], const double b[3],
                           double distance)
{
    double middle[3];
    search s = search_line(of, a, b, distance * (1 + 1e-12), middle);
    run(&s, middle);
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
            length[k] = vector_length(to[k]);
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

static ad_status build(environment *e, ad_error *error)
{
    e->device = rtcNewDevice("threads=1,set_affinity=0");
    e->scene = e->device ? rtcNewScene(e->device) : NULL;
    RTCGeometry geometry = e->scene ? rtcNewGeometry(e->device, RTC_GEOMETRY_TYPE_USER) : NULL;
    if (!geometry) {
        return ad_fail(error, AD_NO_MEMORY, "Embree does not start");
    }
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)e->of->triangles);
    rtcSetGeometryUserData(geometry, e);
    rtcSetGeometryBoundsFunction(geometry, bound, NULL);
    rtcSetGeometryPointQueryFunction(geometry, measure);
    rtcSetSceneFlags(e->scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(e->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(e->scene);
    return rtcGetDeviceError(e->device) == RTC_ERROR_NONE
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for Embree's tree of %zu triangles",
                         e->of->triangles);
}

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
        e->centre[i] = (of->low[i] + of->high[i]) / 2;
        e->size = fmax(e->size, of->high[i] - of->low[i]);
    }
    e->normal = calloc(3 * of->corners, sizeof *e->normal);
    if (e->normal) {
        find_normals(e);
        status = build(e, error);
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
        if (of->scene) {
            rtcReleaseScene(of->scene);
        }
        if (of->device) {
            rtcReleaseDevice(of->device);
        }
        surface_free(of->of);
        free(of->normal);
        free(of);
    }
}

const surface *environment_surface(const environment *of)
{
    return of->of;
}
