/* cpinn-show: shapes of a table as rings of a tube. */
#include "tools/programs/show_pose.h"
#include "tools/programs/section_size.h"
#include "tools/programs/show.h"

#include <math.h>
#include <string.h>

enum { FRAMES_MEASURED = 401 };

/* ---- places -------------------------------------------------------------------------------- */

static size_t row_of(const show_shapes *x, size_t frame, size_t k)
{
    const size_t last = x->at.points - 1;
    return frame * x->at.points + (x->count > 1 ? k * last / (x->count - 1) : last);
}

static void place_of(const show_shapes *x, size_t frame, size_t k, double place[3])
{
    const size_t row = row_of(x, frame, k);
    if (x->deflection) {
        place[0] = x->at.s[row];
        place[1] = 0;
        place[2] = x->enlarged * x->deflection[row];
        return;
    }
    for (int i = 0; i < 3; i++) {
        place[i] = x->at.place[i][row];
    }
}

/* The frames before and after, and where between them. */
static double between(const show_shapes *x, double frame, size_t *first, size_t *next)
{
    const double last = (double)(x->at.frames - 1), at = fmin(fmax(frame, 0), last);
    *first = (size_t)at;
    *next = *first + 1 < x->at.frames ? *first + 1 : *first;
    return x->at.t ? at - (double)*first : 0;
}

void show_place(const show_shapes *x, double frame, size_t k, double place[3])
{
    size_t first, next;
    double other[3];
    const double part = between(x, frame, &first, &next);
    place_of(x, first, k, place);
    place_of(x, next, k, other);
    for (int i = 0; i < 3; i++) {
        place[i] += part * (other[i] - place[i]);
    }
}

double show_time(const show_shapes *x, double frame)
{
    size_t first, next;
    const double part = between(x, frame, &first, &next);
    if (!x->at.t) {
        return frame;
    }
    const double from = x->at.t[first * x->at.points], to = x->at.t[next * x->at.points];
    return from + part * (to - from);
}

const double *show_member(const show_shapes *x, double frame)
{
    return x->members ? x->members + (size_t)frame * (size_t)x->of->parameter_count : NULL;
}

/* ---- sizes --------------------------------------------------------------------------------- */

static void measure(show_shapes *x)
{
    double square = 0;
    const size_t frames = x->at.frames < FRAMES_MEASURED ? x->at.frames : FRAMES_MEASURED;
    for (int k = 0; k < 3; k++) {
        x->low[k] = INFINITY;
        x->high[k] = -INFINITY;
    }
    for (size_t i = 0; i < frames; i++) {
        const size_t frame = frames > 1 ? i * (x->at.frames - 1) / (frames - 1) : 0;
        for (size_t j = 0; j < x->count; j++) {
            double place[3];
            place_of(x, frame, j, place);
            for (int k = 0; k < 3 && isfinite(place[0] + place[1] + place[2]); k++) {
                x->low[k] = fmin(x->low[k], place[k]);
                x->high[k] = fmax(x->high[k], place[k]);
            }
        }
    }
    for (int k = 0; k < 3; k++) {
        square += (x->high[k] - x->low[k]) * (x->high[k] - x->low[k]);
    }
    x->size = sqrt(square);
}

static double arc_of(const show_shapes *x, size_t k)
{
    const double length = x->of ? scene_length(x->of) : 1;
    return x->at.s ? x->at.s[row_of(x, 0, k)]
                   : length * (double)k / (double)(x->count > 1 ? x->count - 1 : 1);
}

static void measure_section(show_shapes *x)
{
    double thickest = 0;
    for (size_t k = 0; k < x->count && x->of; k++) {
        for (int d = 0; d < 2; d++) {
            thickest = fmax(thickest, section_half(x->of, arc_of(x, k), d == 1));
        }
    }
    x->thicker = thickest > 0 ? fmax(1, 0.0065 * x->size / thickest) : 1;
    x->radius = thickest > 0 ? thickest * x->thicker : 0.012 * x->size;
}

static double deflection_scale(const show_shapes *x)
{
    double most = 0, length = 0;
    for (size_t i = 0; i < x->at.frames * x->at.points; i++) {
        most = isfinite(x->deflection[i]) ? fmax(most, fabs(x->deflection[i])) : most;
        length = fmax(length, x->at.s[i] - x->at.s[0]);
    }
    return most > 0 && most < 0.1 * length ? show_round(0.2 * length / most) : 1;
}

ad_status show_shapes_create(const table_source *table, const scene *of, const double *members,
                             size_t rings, show_shapes *x, ad_error *error)
{
    static const char *const names[] = {"qw", "qx", "qy", "qz"};
    *x = (show_shapes){.of = of, .members = members, .enlarged = 1};
    ad_status status = table_shapes_of(table, &x->at, error);
    if (status != AD_OK) {
        return status;
    }
    x->count = x->at.points < rings ? x->at.points : rings;
    for (int k = 0; k < 4; k++) {
        x->turned[k] = table_source_column(table, names[k]);
    }
    if (!x->at.place[0]) {
        x->deflection = table_source_column(table, "w");
        if (!x->deflection || !x->at.s) {
            return ad_fail(error, AD_BAD_INPUT, "there are no columns x, y, z to be drawn");
        }
        x->enlarged = deflection_scale(x);
        memset(x->turned, 0, sizeof x->turned);
    }
    measure(x);
    if (!(x->size > 0)) {
        return ad_fail(error, AD_BAD_INPUT, "there is no shape of any size to be drawn");
    }
    measure_section(x);
    return AD_OK;
}

/* ---- rings --------------------------------------------------------------------------------- */

/* Directors of a quaternion (w, x, y, z). */
static void turn(const double q[4], double d[3][3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double square = w * w + x * x + y * y + z * z, n = square > 0 ? 2 / square : 2;
    const double rows[3][3] = {{1 - n * (y * y + z * z), n * (x * y + w * z), n * (x * z - w * y)},
                               {n * (x * y - w * z), 1 - n * (x * x + z * z), n * (y * z + w * x)},
                               {n * (x * z + w * y), n * (y * z - w * x), 1 - n * (x * x + y * y)}};
    memcpy(d, rows, sizeof rows);
}

static void turn_between(const show_shapes *x, size_t first, size_t next, double part,
                         double d[3][3])
{
    double same = 0, q[4];
    for (int k = 0; k < 4; k++) {
        same += x->turned[k][first] * x->turned[k][next];
    }
    for (int k = 0; k < 4; k++) {
        q[k] = (1 - part) * x->turned[k][first] + (same < 0 ? -part : part) * x->turned[k][next];
    }
    turn(q, d);
}

/* Without quaternions: along the tangent, turned as little as can be from ring to ring. */
static void transport(picture_ring *rings, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const double *from = rings[i > 0 ? i - 1 : 0].place;
        const double *to = rings[i + 1 < count ? i + 1 : i].place;
        double(*d)[3] = rings[i].director, size = 0, along = 0, wide = 0;
        for (int k = 0; k < 3; k++) {
            d[2][k] = to[k] - from[k];
            size = hypot(size, d[2][k]);
        }
        for (int k = 0; k < 3; k++) {
            d[2][k] = size > 0 ? d[2][k] / size : k == 2;
            along += i > 0 ? d[2][k] * rings[i - 1].director[0][k] : 0;
        }
        for (int k = 0; k < 3 && i > 0; k++) {
            d[0][k] = rings[i - 1].director[0][k] - along * d[2][k];
            wide = hypot(wide, d[0][k]);
        }
        if (!(wide > 1e-9)) {
            picture_level(d[2], d[0], d[1]);
            wide = 1;
        }
        for (int k = 0; k < 3; k++) {
            d[0][k] /= wide;
        }
        for (int k = 0; k < 3; k++) {
            d[1][k] = d[2][(k + 1) % 3] * d[0][(k + 2) % 3] - d[2][(k + 2) % 3] * d[0][(k + 1) % 3];
        }
    }
}

void show_pose(const show_shapes *x, double frame, picture_ring *rings, double *arc)
{
    size_t first, next;
    const double part = between(x, frame, &first, &next);
    for (size_t k = 0; k < x->count; k++) {
        arc[k] = arc_of(x, k);
        show_place(x, frame, k, rings[k].place);
        for (int d = 0; d < 2; d++) {
            const double half = x->of ? x->thicker * section_half(x->of, arc[k], d == 1) : 0;
            rings[k].half[d] = half > 0 ? half : x->radius;
        }
        if (x->turned[0] && x->turned[1] && x->turned[2] && x->turned[3]) {
            turn_between(x, row_of(x, first, k), row_of(x, next, k), part, rings[k].director);
        }
    }
    if (!(x->turned[0] && x->turned[1] && x->turned[2] && x->turned[3])) {
        transport(rings, x->count);
    }
}
