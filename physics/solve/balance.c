#include "physics/solve/balance.h"

#include "autodiff/memory.h"
#include "physics/numerics/quaternion.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* A place where something acts is looked at from before, s less this. */
static const double BEFORE = 1e-13;

/* Panels follow what is given, not the shape, on which followers and laws outside depend: they are
 * taken in more and more parts, until what is missing is rounding or stays the same by a tenth. */
enum { PARTS_MAX = 64 };
static const double ROUNDING = 1e-12, SAME = 0.1;

/* ---- the shape ------------------------------------------------------------------------------ */

/* A rod or beam, and the shape that it is said to have. */
typedef struct asked {
    const void *model; /* solve_rod or solve_beam */
    const solve_quadrature *along;
    double length, units[MODEL_COLUMNS_MAX], places[SOLVE_JUMPS_MAX];
    size_t place_count; /* where something acts */
    int columns;
    solve_shape *shape;
    const void *context;
} asked;

/* Where a shape has to be known: points of the quadrature, `places` where something acts, and both
 * ends. */
typedef struct samples {
    size_t count, panels, places;
    double *s;      /* [count], by the length */
    double *weight; /* [panels] of the integral along the rod */
    double *values; /* [columns][count], dimensionless */
    double *work;   /* [count]: s in m */
    ad_memory memory;
} samples;

static void samples_free(samples *samples)
{
    ad_memory_free(&samples->memory);
}

/* Every panel in so many parts. */
static ad_status sample(const asked *of, int parts, samples *samples, ad_error *error)
{
    size_t k = 0, columns = (size_t)of->columns;
    samples->panels = (size_t)of->along->count * (size_t)parts * QUADRATURE_POINTS;
    samples->places = of->place_count;
    samples->count = samples->panels + samples->places + 2;
    AD_TAKE(samples, s, samples->count);
    AD_TAKE(samples, weight, samples->panels + 1);
    AD_TAKE(samples, work, samples->count);
    AD_TAKE(samples, values, samples->count * columns);
    if (samples->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", samples->count);
    }
    for (int i = 0; i < of->along->count * parts; i++) {
        const double *edge = of->along->edges + i / parts;
        double width = (edge[1] - edge[0]) / parts, from = edge[0] + width * (i % parts);
        for (int j = 0; j < QUADRATURE_POINTS; j++) {
            samples->weight[k] = width * of->along->rule.weights[j];
            samples->s[k++] = from + width * of->along->rule.nodes[j];
        }
    }
    for (size_t i = 0; i < samples->places; i++) {
        samples->s[k++] = fmax(0, of->places[i] - BEFORE);
    }
    samples->s[k++] = 0;
    samples->s[k] = 1;
    for (size_t i = 0; i < samples->count; i++) {
        samples->work[i] = samples->s[i] * of->length;
    }
    ad_status status =
        of->shape(of->context, samples->count, samples->work, samples->values, error);
    for (size_t i = 0; i < samples->count * columns && status == AD_OK; i++) {
        samples->values[i] /= of->units[i / samples->count];
    }
    return status;
}

/* The largest force or moment that is left of all, and the sum of their absolute values. */
typedef ad_status add_up(const void *model, const samples *x, double *rest, double *size,
                         ad_error *error);

/* The rest by the size; small loads are compared with what bends a rod. On more parts as long as
 * they may tell more. */
static ad_status find_rest(const asked *of, add_up *add, double *balance, ad_error *error)
{
    double before, found = INFINITY;
    bool finer = true;
    ad_status status = AD_OK;
    for (int parts = 1; finer && parts <= PARTS_MAX && status == AD_OK; parts *= 2) {
        double rest = 0, size = 0;
        samples x = {.count = 0};
        before = found;
        status = sample(of, parts, &x, error);
        status = status == AD_OK ? add(of->model, &x, &rest, &size, error) : status;
        found = rest / (1 + size);
        finer = found > ROUNDING && !(fabs(found - before) <= SAME * found);
        samples_free(&x);
    }
    *balance = isnan(found) ? INFINITY : found;
    return status;
}

/* ---- rods ----------------------------------------------------------------------------------- */

/* Sums over the rod: of forces, and of moments about the origin; size: of all absolute values. */
typedef struct total {
    double force[3], moment[3], size;
} total;

/* A state of the shape. */
typedef struct posed {
    double r[3], q[4], rotation[3][3], force[3], moment[3]; /* N, M: in the world */
} posed;

static posed pose_of(const samples *samples, size_t point)
{
    solve_state state, *at = &state;
    posed result;
    memset(at, 0, sizeof *at);
    for (size_t c = 0; c < offsetof(solve_state, velocity) / sizeof(double); c++) {
        ((double *)at)[c] = samples->values[c * samples->count + point];
    }
    memcpy(result.r, at->position, sizeof result.r);
    memcpy(result.q, at->rotation, sizeof result.q);
    rotation_matrix(at->rotation, result.rotation);
    to_world(result.rotation, at->force, result.force);
    to_world(result.rotation, at->moment, result.moment);
    return result;
}

static void add(total *sum, double weight, posed *at, const double *force, const double *moment)
{
    double lever[3];
    vector_cross(at->r, force, lever);
    for (int i = 0; i < 3; i++) {
        sum->force[i] += weight * force[i];
        sum->moment[i] += weight * (lever[i] + moment[i]);
        sum->size += weight * (fabs(force[i]) + fabs(lever[i]) + fabs(moment[i]));
    }
}

/* What holds an end does to it, by the shape there, in which all that acts at this place is
 * counted.
 */
static void add_end(const solve_rod *rod, int end, posed *at, total *sum)
{
    const solve_end *kind = &rod->ends[end];
    double force[3], moment[3];
    scene_hold_part(&kind->hold, at->force, force);
    for (int i = 0; i < 3; i++) {
        force[i] *= end ? 1 : -1;
        moment[i] = kind->holds_rotation ? (end ? 1 : -1) * at->moment[i] : 0;
    }
    add(sum, 1, at, force, moment);
}

/* Force and moment of laws outside, wrench [6]. */
static void act(const acting *of, const double *numbers, const posed *at, double *wrench)
{
    memset(wrench, 0, 6 * sizeof *wrench);
    acting_wrench(of, numbers, (acting_on){at->r, at->q, NULL}, ACTING_ALL, 1, wrench);
}

/* What acts at single places, as far as the support of an end does not take it. */
static void add_jumps(const solve_rod *rod, const samples *samples, total *sum)
{
    const solve_jumps *jumps = &rod->jumps;
    for (size_t i = 0; i < samples->places; i++) {
        const solve_jump *jump = &jumps->at[i];
        const solve_end *end = &rod->ends[jump->s == 1];
        double held[3], wrench[6];
        posed at = pose_of(samples, samples->panels + i);
        act(&jump->acting, solve_jump_numbers(jumps, jumps->number, (int)i), &at, wrench);
        scene_hold_part(&end->hold, wrench, held);
        for (int k = 0; k < 3 && (jump->s == 0 || jump->s == 1); k++) {
            wrench[k] -= held[k];
            wrench[3 + k] = end->holds_rotation ? 0 : wrench[3 + k];
        }
        add(sum, 1, &at, wrench, wrench + 3);
    }
}

static double largest(const double a[3])
{
    return fmax(fabs(a[0]), fmax(fabs(a[1]), fabs(a[2])));
}

static ad_status add_up_rod(const void *model, const samples *samples, double *rest, double *size,
                            ad_error *error)
{
    const solve_rod *rod = model;
    total sum = {.size = 0};
    double along[QUADRATURE_POINTS * ACTING_ALONG_MAX], wrench[6];
    ad_status status = AD_OK;
    for (size_t i = 0; i < samples->panels && status == AD_OK; i++) {
        size_t within = i % QUADRATURE_POINTS;
        if (within == 0) {
            status = solve_rod_along(rod, QUADRATURE_POINTS, samples->s + i, 0, along, error);
        }
        posed at = pose_of(samples, i);
        if (status == AD_OK) {
            act(&rod->along, along + within * (size_t)rod->along.numbers, &at, wrench);
            add(&sum, samples->weight[i], &at, wrench, wrench + 3);
        }
    }
    if (status == AD_OK) {
        add_jumps(rod, samples, &sum);
    }
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        posed at = pose_of(samples, samples->count - 2 + (size_t)end);
        add_end(rod, end, &at, &sum);
    }
    *rest = fmax(largest(sum.force), largest(sum.moment));
    *size = sum.size;
    return status;
}

ad_status solve_balance_rod(const solve_rod *rod, solve_shape *shape, const void *context,
                            double *balance, ad_error *error)
{
    asked of = {.model = rod,
                .along = rod->quadrature,
                .length = rod->scales.length,
                .place_count = (size_t)rod->jumps.count,
                .columns = solution_columns(&rod->scene),
                .shape = shape,
                .context = context};
    solve_rod_units(rod, of.units);
    solve_jump_places(&rod->jumps, of.places);
    return find_rest(&of, add_up_rod, balance, error);
}

/* ---- beams ---------------------------------------------------------------------------------- */

/* Sums over the beam: of forces, and of moments about s = 0 (physics/beam/beam.h). */
typedef struct beam_total {
    double force, moment, size;
} beam_total;

static void add_beam(beam_total *sum, double weight, double s, double force, double moment)
{
    sum->force += weight * force;
    sum->moment += weight * (s * force + moment);
    sum->size += weight * (fabs(force) + fabs(moment));
}

/* w, psi, V, M: of a column at a point. */
static double column(const samples *samples, int c, size_t point)
{
    return samples->values[(size_t)c * samples->count + point];
}

static ad_status add_beam_ends(const solve_beam *beam, const samples *samples, beam_total *sum,
                               ad_error *error)
{
    double given[4];
    ad_status status = solve_beam_ends(beam, 0, given, error);
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        size_t point = samples->count - 2 + (size_t)end;
        double force =
            beam->ends[end].holds_deflection ? column(samples, 2, point) : given[2 * end];
        double moment =
            beam->ends[end].holds_slope ? column(samples, 3, point) : given[2 * end + 1];
        add_beam(sum, 1, end, end ? force : -force, end ? moment : -moment);
    }
    return status;
}

static ad_status add_beam_jumps(const solve_beam *beam, const samples *samples, beam_total *sum,
                                ad_error *error)
{
    beam_load load[BEAM_JUMPS_MAX];
    ad_status status = samples->places > 0 ? solve_beam_jump_loads(beam, 0, load, error) : AD_OK;
    for (size_t i = 0; i < samples->places && status == AD_OK; i++) {
        const beam_jump *jump = &beam->jumps[i];
        double force = load[i].force - jump->stiffness * column(samples, 0, samples->panels + i);
        double moment = load[i].moment - jump->turning * column(samples, 1, samples->panels + i);
        int end = jump->s == 1;
        bool inside = jump->s > 0 && jump->s < 1;
        add_beam(sum, 1, jump->s, !inside && beam->ends[end].holds_deflection ? 0 : force,
                 !inside && beam->ends[end].holds_slope ? 0 : moment);
    }
    return status;
}

static ad_status add_up_beam(const void *model, const samples *samples, double *rest, double *size,
                             ad_error *error)
{
    const solve_beam *beam = model;
    beam_load load[QUADRATURE_POINTS];
    beam_section section[QUADRATURE_POINTS];
    beam_total sum = {.size = 0};
    ad_status status = AD_OK;
    for (size_t i = 0; i < samples->panels && status == AD_OK; i++) {
        size_t k = i % QUADRATURE_POINTS;
        if (k == 0) {
            status = solve_beam_load(beam, QUADRATURE_POINTS, samples->s + i, 0, load, error);
            status = status == AD_OK ? solve_beam_sections(beam, QUADRATURE_POINTS, samples->s + i,
                                                           section, error)
                                     : status;
        }
        if (status == AD_OK) {
            add_beam(&sum, samples->weight[i], samples->s[i],
                     load[k].force - section[k].foundation * column(samples, 0, i), load[k].moment);
        }
    }
    status = status == AD_OK ? add_beam_jumps(beam, samples, &sum, error) : status;
    status = status == AD_OK ? add_beam_ends(beam, samples, &sum, error) : status;
    *rest = fmax(fabs(sum.force), fabs(sum.moment));
    *size = sum.size;
    return status;
}

ad_status solve_balance_beam(const solve_beam *beam, solve_shape *shape, const void *context,
                             double *balance, ad_error *error)
{
    asked of = {.model = beam,
                .along = beam->quadrature,
                .length = beam->scales.length,
                .place_count = (size_t)beam->jump_count,
                .columns = 4,
                .shape = shape,
                .context = context};
    solve_beam_units(beam, of.units);
    for (int i = 0; i < beam->jump_count; i++) {
        of.places[i] = beam->jumps[i].s;
    }
    return find_rest(&of, add_up_beam, balance, error);
}

/* ---- scenes --------------------------------------------------------------------------------- */

ad_status solve_balance(const scene *rod_scene, solve_shape *shape, const void *context,
                        double *balance, ad_error *error)
{
    solve_rod *rod = NULL;
    solve_beam *beam = NULL;
    ad_status status;
    *balance = NAN;
    if (scene_is_beam(rod_scene)) {
        status = solve_beam_create(rod_scene, &beam, error);
        status =
            status == AD_OK ? solve_balance_beam(beam, shape, context, balance, error) : status;
    } else {
        status = solve_rod_create(rod_scene, &rod, error);
        status = status == AD_OK ? solve_balance_rod(rod, shape, context, balance, error) : status;
    }
    solve_rod_free(rod);
    solve_beam_free(beam);
    return status;
}
