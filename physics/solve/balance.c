#include "physics/solve/balance.h"

#include "physics/solve/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A place where something acts is looked at from before, s less this. */
static const double BEFORE = 1e-13;

/* Panels follow what is given, not the shape, on which followers and foundations depend: they are
 * taken in more and more parts, until what is missing is rounding or stays the same by a tenth. */
enum { PARTS_MAX = 64 };
static const double ROUNDING = 1e-12, SAME = 0.1;

/* ---- the shape ------------------------------------------------------------------------------ */

/* Where a shape has to be known: points of the quadrature, `places` where something acts, and both
 * ends. */
typedef struct samples {
    size_t count, panels, places;
    int columns;
    double *s;      /* [count], by the length */
    double *weight; /* [panels] of the integral along the rod */
    double *values; /* [columns][count], dimensionless */
    double *work;   /* [count]: s in m */
} samples;

static void samples_free(samples *x)
{
    free(x->s);
    free(x->weight);
    free(x->values);
    free(x->work);
}

/* Every panel in so many parts; places [x->places]; units [columns] of the values. */
static ad_status sample(const solve_quadrature *along, int parts, const double *places,
                        double length, const double *units, solve_shape *shape, const void *context,
                        samples *x, ad_error *error)
{
    size_t k = 0;
    x->panels = (size_t)along->count * (size_t)parts * QUADRATURE_POINTS;
    x->count = x->panels + x->places + 2;
    x->s = malloc(x->count * sizeof *x->s);
    x->weight = malloc((x->panels + 1) * sizeof *x->weight);
    x->work = malloc(x->count * sizeof *x->work);
    x->values = malloc(x->count * (size_t)x->columns * sizeof *x->values);
    if (!x->s || !x->weight || !x->work || !x->values) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", x->count);
    }
    for (int i = 0; i < along->count * parts; i++) {
        const double *edge = along->edges + i / parts;
        double width = (edge[1] - edge[0]) / parts, from = edge[0] + width * (i % parts);
        for (int j = 0; j < QUADRATURE_POINTS; j++) {
            x->weight[k] = width * along->rule.weights[j];
            x->s[k++] = from + width * along->rule.nodes[j];
        }
    }
    for (size_t i = 0; i < x->places; i++) {
        x->s[k++] = fmax(0, places[i] - BEFORE);
    }
    x->s[k++] = 0;
    x->s[k] = 1;
    for (size_t i = 0; i < x->count; i++) {
        x->work[i] = x->s[i] * length;
    }
    ad_status status = shape(context, x->count, x->work, x->values, error);
    for (size_t i = 0; i < x->count * (size_t)x->columns && status == AD_OK; i++) {
        x->values[i] /= units[i / x->count];
    }
    return status;
}

/* The rest of a sum by the size of its parts; small loads are compared with what bends a rod. */
static double relative(double rest, double size)
{
    return rest / (1 + size);
}

/* Whether more parts may tell more; before: of half as many, NaN at first. */
static bool may_be_finer(int parts, double balance, double before)
{
    return parts < PARTS_MAX && balance > ROUNDING && !(fabs(balance - before) <= SAME * balance);
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

static posed pose_of(const samples *x, size_t point)
{
    solve_state state, *at = &state;
    posed result;
    memset(at, 0, sizeof *at);
    for (size_t c = 0; c < (size_t)x->columns; c++) {
        ((double *)at)[c] = x->values[c * x->count + point];
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

/* What is given of a follower turns with the section. */
static void add_load(total *sum, double weight, posed *at, const solve_load *load)
{
    double force[3], moment[3];
    to_world(at->rotation, load->body_force, force);
    to_world(at->rotation, load->body_moment, moment);
    for (int i = 0; i < 3; i++) {
        force[i] += load->force[i];
        moment[i] += load->moment[i];
    }
    add(sum, weight, at, force, moment);
}

/* Whether the scene says which force (moment) acts on an end; else the support takes it. */
static bool force_is_given(const solve_rod *rod, int end)
{
    scene_end_type type = end ? rod->scene.end.type : rod->scene.start.type;
    return type == SCENE_FREE || type == SCENE_LOADED;
}

static bool moment_is_given(const solve_rod *rod, int end)
{
    return !scene_end_holds_rotation(end ? rod->scene.end.type : rod->scene.start.type);
}

/* What the outside does to an end: what the scene says, or, where it holds the end, what the shape
 * says, in which all that acts at this place is counted. */
static ad_status add_end(const solve_rod *rod, int end, posed *at, total *sum, ad_error *error)
{
    double sign = end ? 1 : -1, force[3], moment[3];
    solve_end_state given;
    ad_status status = solve_rod_end(rod, end, 0, &given, error);
    if (status != AD_OK) {
        return status;
    }
    memcpy(force, force_is_given(rod, end) ? given.force : at->force, sizeof force);
    memcpy(moment, moment_is_given(rod, end) ? given.moment : at->moment, sizeof moment);
    if (force_is_given(rod, end) && rod->ends[end].force_is_body) {
        to_world(at->rotation, given.force, force);
    }
    if (moment_is_given(rod, end) && rod->ends[end].moment_is_body) {
        to_world(at->rotation, given.moment, moment);
    }
    for (int i = 0; i < 3; i++) {
        force[i] *= sign;
        moment[i] *= sign;
    }
    add(sum, 1, at, force, moment);
    return AD_OK;
}

static void add_springs(const solve_rod *rod, const solve_jump *jump, posed *at, solve_load *load)
{
    for (int k = 0; k < jump->spring_count; k++) {
        const solve_spring *spring = &rod->jumps.springs[jump->springs[k]];
        double force[3], moment[3];
        solve_spring_force(spring, spring->anchor, at->r, force);
        solve_spring_moment(spring, at->q, moment, NULL);
        for (int i = 0; i < 3; i++) {
            load->force[i] += force[i];
            load->body_moment[i] += moment[i];
        }
    }
}

/* What acts at single places, as far as the support of an end does not take it. */
static ad_status add_jumps(const solve_rod *rod, const samples *x, total *sum, ad_error *error)
{
    solve_load load[SOLVE_JUMPS_MAX];
    ad_status status = x->places > 0 ? solve_rod_jump_loads(rod, 0, load, error) : AD_OK;
    for (size_t i = 0; i < x->places && status == AD_OK; i++) {
        const solve_jump *jump = &rod->jumps.at[i];
        posed at = pose_of(x, x->panels + i);
        int end = jump->s == 1;
        bool inside = jump->s > 0 && jump->s < 1;
        add_springs(rod, jump, &at, &load[i]);
        for (int k = 0; k < 3; k++) {
            if (!inside && !force_is_given(rod, end)) {
                load[i].force[k] = load[i].body_force[k] = 0;
            }
            if (!inside && !moment_is_given(rod, end)) {
                load[i].moment[k] = load[i].body_moment[k] = 0;
            }
        }
        add_load(sum, 1, &at, &load[i]);
    }
    return status;
}

static double largest(const double a[3])
{
    return fmax(fabs(a[0]), fmax(fabs(a[1]), fabs(a[2])));
}

static ad_status add_all(const solve_rod *rod, const samples *x, total *sum, ad_error *error)
{
    solve_load load[QUADRATURE_POINTS];
    solve_foundation below[QUADRATURE_POINTS] = {{{0}, {0}}};
    ad_status status = AD_OK;
    for (size_t i = 0; i < x->panels && status == AD_OK; i++) {
        size_t within = i % QUADRATURE_POINTS;
        if (within == 0) {
            status = solve_rod_load(rod, QUADRATURE_POINTS, x->s + i, 0, load, error);
        }
        if (within == 0 && rod->is_founded && status == AD_OK) {
            status = solve_rod_foundation(rod, QUADRATURE_POINTS, x->s + i, below, error);
        }
        posed at = pose_of(x, i);
        if (status == AD_OK) {
            for (int k = 0; k < 3; k++) {
                const solve_foundation *here = &below[within];
                load[within].force[k] -= here->stiffness[k] * (at.r[k] - here->place[k]);
            }
            add_load(sum, x->weight[i], &at, &load[within]);
        }
    }
    status = status == AD_OK ? add_jumps(rod, x, sum, error) : status;
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        posed at = pose_of(x, x->count - 2 + (size_t)end);
        status = add_end(rod, end, &at, sum, error);
    }
    return status;
}

ad_status solve_balance_rod(const solve_rod *rod, solve_shape *shape, const void *context,
                            double *balance, ad_error *error)
{
    double units[MODEL_COLUMNS_MAX], places[SOLVE_JUMPS_MAX], before = NAN;
    ad_status status = AD_OK;
    solve_rod_units(rod, units);
    solve_jump_places(&rod->jumps, places);
    *balance = INFINITY;
    for (int parts = 1; status == AD_OK && may_be_finer(parts / 2, *balance, before); parts *= 2) {
        samples x = {.places = (size_t)rod->jumps.count, .columns = solution_columns(&rod->scene)};
        total sum = {.size = 0};
        before = *balance;
        status = sample(rod->quadrature, parts, places, rod->scales.length, units, shape, context,
                        &x, error);
        status = status == AD_OK ? add_all(rod, &x, &sum, error) : status;
        *balance = relative(fmax(largest(sum.force), largest(sum.moment)), sum.size);
        samples_free(&x);
    }
    return status;
}

/* ---- beams ---------------------------------------------------------------------------------- */

/* Sums over the beam: of forces, and of moments about s = 0 (physics/beam.h). */
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
static double column(const samples *x, int c, size_t point)
{
    return x->values[(size_t)c * x->count + point];
}

static ad_status add_beam_ends(const solve_beam *beam, const samples *x, beam_total *sum,
                               ad_error *error)
{
    double given[4];
    ad_status status = solve_beam_ends(beam, 0, given, error);
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        size_t point = x->count - 2 + (size_t)end;
        double force = beam->ends[end].holds_deflection ? column(x, 2, point) : given[2 * end];
        double moment = beam->ends[end].holds_slope ? column(x, 3, point) : given[2 * end + 1];
        add_beam(sum, 1, end, end ? force : -force, end ? moment : -moment);
    }
    return status;
}

static ad_status add_beam_jumps(const solve_beam *beam, const samples *x, beam_total *sum,
                                ad_error *error)
{
    beam_load load[BEAM_JUMPS_MAX];
    ad_status status = x->places > 0 ? solve_beam_jump_loads(beam, 0, load, error) : AD_OK;
    for (size_t i = 0; i < x->places && status == AD_OK; i++) {
        const beam_jump *jump = &beam->jumps[i];
        double force = load[i].force - jump->stiffness * column(x, 0, x->panels + i);
        double moment = load[i].moment - jump->turning * column(x, 1, x->panels + i);
        int end = jump->s == 1;
        bool inside = jump->s > 0 && jump->s < 1;
        add_beam(sum, 1, jump->s, !inside && beam->ends[end].holds_deflection ? 0 : force,
                 !inside && beam->ends[end].holds_slope ? 0 : moment);
    }
    return status;
}

static ad_status add_beam_loads(const solve_beam *beam, const samples *x, beam_total *sum,
                                ad_error *error)
{
    beam_load load[QUADRATURE_POINTS];
    beam_section section[QUADRATURE_POINTS];
    ad_status status = AD_OK;
    for (size_t i = 0; i < x->panels && status == AD_OK; i++) {
        size_t k = i % QUADRATURE_POINTS;
        if (k == 0) {
            status = solve_beam_load(beam, QUADRATURE_POINTS, x->s + i, 0, load, error);
            status = status == AD_OK
                         ? solve_beam_sections(beam, QUADRATURE_POINTS, x->s + i, section, error)
                         : status;
        }
        if (status == AD_OK) {
            add_beam(sum, x->weight[i], x->s[i],
                     load[k].force - section[k].foundation * column(x, 0, i), load[k].moment);
        }
    }
    return status;
}

ad_status solve_balance_beam(const solve_beam *beam, solve_shape *shape, const void *context,
                             double *balance, ad_error *error)
{
    double units[MODEL_COLUMNS_MAX], places[BEAM_JUMPS_MAX], before = NAN;
    ad_status status = AD_OK;
    solve_beam_units(beam, units);
    for (int i = 0; i < beam->jump_count; i++) {
        places[i] = beam->jumps[i].s;
    }
    *balance = INFINITY;
    for (int parts = 1; status == AD_OK && may_be_finer(parts / 2, *balance, before); parts *= 2) {
        samples x = {.places = (size_t)beam->jump_count, .columns = 4};
        beam_total sum = {.size = 0};
        before = *balance;
        status = sample(beam->quadrature, parts, places, beam->scales.length, units, shape, context,
                        &x, error);
        status = status == AD_OK ? add_beam_loads(beam, &x, &sum, error) : status;
        status = status == AD_OK ? add_beam_jumps(beam, &x, &sum, error) : status;
        status = status == AD_OK ? add_beam_ends(beam, &x, &sum, error) : status;
        *balance = relative(fmax(fabs(sum.force), fabs(sum.moment)), sum.size);
        samples_free(&x);
    }
    return status;
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
