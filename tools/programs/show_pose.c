/* cpinn-show: shapes of a table as rings of a tube. */
#include "tools/programs/show_pose.h"
#include "tools/programs/section_size.h"
#include "tools/programs/show.h"

#include <math.h>
#include <string.h>

enum { FRAMES_MEASURED = 401 };

/* ---- places -------------------------------------------------------------------------------- */

static size_t row_of(const show_shapes *shapes, size_t frame, size_t k)
{
    const size_t last = shapes->at.points - 1;
    return frame * shapes->at.points + (shapes->count > 1 ? k * last / (shapes->count - 1) : last);
}

static void place_of(const show_shapes *shapes, size_t frame, size_t k, double place[3])
{
    const size_t row = row_of(shapes, frame, k);
    if (shapes->deflection) {
        place[0] = shapes->at.s[row];
        place[1] = 0;
        place[2] = shapes->enlarged * shapes->deflection[row];
        return;
    }
    for (int i = 0; i < 3; i++) {
        place[i] = shapes->at.place[i][row];
    }
}

/* The frames before and after, and where between them. */
static double between(const show_shapes *shapes, double frame, size_t *first, size_t *next)
{
    const double last = (double)(shapes->at.frames - 1), at = fmin(fmax(frame, 0), last);
    *first = (size_t)at;
    *next = *first + 1 < shapes->at.frames ? *first + 1 : *first;
    return shapes->at.t ? at - (double)*first : 0;
}

void show_place(const show_shapes *shapes, double frame, size_t k, double place[3])
{
    size_t first, next;
    double other[3];
    const double part = between(shapes, frame, &first, &next);
    place_of(shapes, first, k, place);
    place_of(shapes, next, k, other);
    for (int i = 0; i < 3; i++) {
        place[i] += part * (other[i] - place[i]);
    }
}

double show_left(const show_shapes *shapes, double frame, size_t k)
{
    size_t first, next;
    const double part = between(shapes, frame, &first, &next);
    const double from = shapes->left[row_of(shapes, first, k)];
    return from + part * (shapes->left[row_of(shapes, next, k)] - from);
}

picture_colour show_nearness(double part)
{
    static const char *const colours[] = {"b8232f", "e2711d", "e3b022",
                                          "7fb93c", "27a684", "2c8fbd"};
    return picture_between(colours, 6, isnan(part) ? 1 : part);
}

double show_time(const show_shapes *shapes, double frame)
{
    size_t first, next;
    const double part = between(shapes, frame, &first, &next);
    if (!shapes->at.t) {
        return frame;
    }
    const double from = shapes->at.t[first * shapes->at.points],
                 to = shapes->at.t[next * shapes->at.points];
    return from + part * (to - from);
}

const double *show_member(const show_shapes *shapes, double frame)
{
    return shapes->members ? shapes->members + (size_t)frame * (size_t)shapes->of->parameter_count
                           : NULL;
}

/* ---- sizes --------------------------------------------------------------------------------- */

static void measure(show_shapes *shapes)
{
    double square = 0;
    const size_t frames = shapes->at.frames < FRAMES_MEASURED ? shapes->at.frames : FRAMES_MEASURED;
    for (int k = 0; k < 3; k++) {
        shapes->low[k] = INFINITY;
        shapes->high[k] = -INFINITY;
    }
    for (size_t i = 0; i < frames; i++) {
        const size_t frame = frames > 1 ? i * (shapes->at.frames - 1) / (frames - 1) : 0;
        for (size_t j = 0; j < shapes->count; j++) {
            double place[3];
            place_of(shapes, frame, j, place);
            for (int k = 0; k < 3 && isfinite(place[0] + place[1] + place[2]); k++) {
                shapes->low[k] = fmin(shapes->low[k], place[k]);
                shapes->high[k] = fmax(shapes->high[k], place[k]);
            }
        }
    }
    for (int k = 0; k < 3; k++) {
        square += (shapes->high[k] - shapes->low[k]) * (shapes->high[k] - shapes->low[k]);
    }
    shapes->size = sqrt(square);
}

static double arc_of(const show_shapes *shapes, size_t k)
{
    const double length = shapes->of ? scene_length(shapes->of) : 1;
    return shapes->at.s ? shapes->at.s[row_of(shapes, 0, k)]
                        : length * (double)k / (double)(shapes->count > 1 ? shapes->count - 1 : 1);
}

/* A column radius is of a robot that is thicker than its rod. */
static void measure_section(show_shapes *shapes, const double *radius)
{
    double thickest = radius ? *radius : 0;
    for (size_t k = 0; k < shapes->count && shapes->of && !radius; k++) {
        for (int d = 0; d < 2; d++) {
            thickest = fmax(thickest, section_half(shapes->of, arc_of(shapes, k), d == 1));
        }
    }
    shapes->thicker = thickest > 0 ? fmax(1, 0.0065 * shapes->size / thickest) : 1;
    shapes->radius = thickest > 0 ? thickest * shapes->thicker : 0.012 * shapes->size;
}

static double deflection_scale(const show_shapes *shapes)
{
    double most = 0, length = 0;
    for (size_t i = 0; i < shapes->at.frames * shapes->at.points; i++) {
        most = isfinite(shapes->deflection[i]) ? fmax(most, fabs(shapes->deflection[i])) : most;
        length = fmax(length, shapes->at.s[i] - shapes->at.s[0]);
    }
    return most > 0 && most < 0.1 * length ? show_round(0.2 * length / most) : 1;
}

ad_status show_shapes_create(const table_source *table, const scene *of, const double *members,
                             size_t rings, show_shapes *shapes, ad_error *error)
{
    static const char *const names[] = {"qw", "qx", "qy", "qz"};
    *shapes = (show_shapes){.of = of, .members = members, .enlarged = 1};
    ad_status status = table_shapes_of(table, &shapes->at, error);
    if (status != AD_OK) {
        return status;
    }
    shapes->count = shapes->at.points < rings ? shapes->at.points : rings;
    for (int k = 0; k < 4; k++) {
        shapes->turned[k] = table_source_column(table, names[k]);
    }
    if (!shapes->at.place[0]) {
        shapes->deflection = table_source_column(table, "w");
        if (!shapes->deflection || !shapes->at.s) {
            return ad_fail(error, AD_BAD_INPUT, "there are no columns x, y, z to be drawn");
        }
        shapes->enlarged = deflection_scale(shapes);
        memset(shapes->turned, 0, sizeof shapes->turned);
    }
    measure(shapes);
    if (!(shapes->size > 0)) {
        return ad_fail(error, AD_BAD_INPUT, "there is no shape of any size to be drawn");
    }
    measure_section(shapes, of ? NULL : table_source_column(table, "radius"));
    shapes->left = table_source_column(table, "left");
    shapes->least = INFINITY;
    for (size_t i = 0; shapes->left && i < table->nrows; i++) {
        shapes->least = fmin(shapes->least, shapes->left[i]);
        shapes->most = fmax(shapes->most, shapes->left[i]);
    }
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

static void turn_between(const show_shapes *shapes, size_t first, size_t next, double part,
                         double d[3][3])
{
    double same = 0, q[4];
    for (int k = 0; k < 4; k++) {
        same += shapes->turned[k][first] * shapes->turned[k][next];
    }
    for (int k = 0; k < 4; k++) {
        q[k] = (1 - part) * shapes->turned[k][first] +
               (same < 0 ? -part : part) * shapes->turned[k][next];
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

void show_pose(const show_shapes *shapes, double frame, picture_ring *rings, double *arc)
{
    size_t first, next;
    const double part = between(shapes, frame, &first, &next);
    for (size_t k = 0; k < shapes->count; k++) {
        arc[k] = arc_of(shapes, k);
        show_place(shapes, frame, k, rings[k].place);
        for (int d = 0; d < 2; d++) {
            const double half =
                shapes->of ? shapes->thicker * section_half(shapes->of, arc[k], d == 1) : 0;
            rings[k].half[d] = half > 0 ? half : shapes->radius;
        }
        if (shapes->turned[0] && shapes->turned[1] && shapes->turned[2] && shapes->turned[3]) {
            turn_between(shapes, row_of(shapes, first, k), row_of(shapes, next, k), part,
                         rings[k].director);
        }
    }
    if (!(shapes->turned[0] && shapes->turned[1] && shapes->turned[2] && shapes->turned[3])) {
        transport(rings, shapes->count);
    }
}
