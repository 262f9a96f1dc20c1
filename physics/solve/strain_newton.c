#include "physics/solve/strain_newton.h"

#include "autodiff/dense.h"
#include "physics/chain/strain_form.h"
#include "physics/numerics/quaternion.h"
#include "physics/solve/static_system.h"

#include <stdlib.h>
#include <string.h>

/* The matrix is full: of this many it takes 50 MB, and a step some 0.3 s. */
enum { UNKNOWNS_MAX = 2400, STEPS_MAX = 40 };

/* Steps below this no longer have to lessen what rounding leaves; the last is below that. The
 * derivatives are those of the equation by quadrature, not of Magnus' steps: they differ by the
 * error of both, so that convergence is linear at last, and quick. */
static const double SMALL = 1e-8, LAST = 1e-13;

struct strain_newton {
    static_system *system;
    strain_form *form;
    lanes *step;  /* [unknowns] */
    double *room; /* [unknowns][unknowns], [unknowns] */
    int *pivots;  /* [unknowns] */
};

/* ---- making -------------------------------------------------------------------------------- */

static bool any(size_t count, const double *x)
{
    bool result = false;
    for (size_t i = 0; i < count; i++) {
        result = result || x[i] != 0;
    }
    return result;
}

static strain_kind kind_of(const static_system *system)
{
    const solve_rod *rod = system->rod;
    const solve_end *ends = rod->ends;
    strain_kind kind = {.stages = system->mesh.stages,
                        .elements = system->mesh.count,
                        .actuators = rod->actuators,
                        .edges = system->mesh.edges,
                        .extents = rod->extents,
                        .law = rod->scene.rod.law,
                        .length = rod->scales.length,
                        .force = rod->scales.force,
                        .along = &rod->along,
                        .free_position = ends[0].hold.directions < 3,
                        .free_rotation = !ends[0].holds_rotation,
                        .jumps = &rod->jumps,
                        .substeps = STRAIN_SUBSTEPS_MAX,
                        .is_one = true,
                        .end = ends[1]};
    /* a rod between two ends stretches on its path, also where it does not at its end */
    kind.shears = ends[0].hold.directions > 0 && ends[1].hold.directions > 0;
    for (int i = 0; i < system->mesh.count * system->mesh.stages; i++) {
        kind.shears = kind.shears || any(3, system->given.sections[i].compliance);
    }
    return kind;
}

ad_status strain_newton_create(static_system *system, strain_newton **result, ad_error *error)
{
    const strain_kind kind = kind_of(system);
    *result = NULL;
    if (3 * kind.stages * kind.elements > UNKNOWNS_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the strain form would need %d nodes, more than %d; allowed: the method "
                       "collocation",
                       kind.stages * kind.elements, UNKNOWNS_MAX / 3);
    }
    strain_newton *newton = calloc(1, sizeof *newton);
    if (!newton) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for Newton's method");
    }
    newton->system = system;
    ad_status status = strain_form_create(&kind, &newton->form, error);
    if (status == AD_OK) {
        strain_form_set_jumps(newton->form);
        size_t count = (size_t)newton->form->unknowns;
        newton->step = malloc(count * sizeof *newton->step);
        newton->room = malloc((count + 1) * count * sizeof *newton->room);
        newton->pivots = malloc(count * sizeof *newton->pivots);
        if (!newton->step || !newton->room || !newton->pivots) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu unknowns", count);
        }
    }
    if (status != AD_OK) {
        strain_newton_free(newton);
        return status;
    }
    *result = newton;
    return AD_OK;
}

void strain_newton_free(strain_newton *newton)
{
    if (newton) {
        strain_form_free(newton->form);
        free(newton->step);
        free(newton->room);
        free(newton->pivots);
        free(newton);
    }
}

/* ---- what is given, where the path is ------------------------------------------------------ */

static void spread(size_t count, const double *from, lanes *to)
{
    for (size_t i = 0; i < count; i++) {
        for (int lane = 0; lane < LANES; lane++) {
            to[i][lane] = from[i];
        }
    }
}

static void gather(size_t count, const lanes *from, double *to)
{
    for (size_t i = 0; i < count; i++) {
        to[i] = from[i][0];
    }
}

static void give_point(strain_newton *newton, int i, const static_point *at)
{
    strain_point *to = &newton->form->points[i];
    spread(3, at->rest.strain, to->rest);
    spread(3, at->rest.curvature, to->rest + 3);
    spread(6, at->compliance, to->compliance);
    spread((size_t)at->acting->numbers, at->numbers, newton->form->along + i * at->acting->numbers);
    for (int k = 0; k < at->actuation.count; k++) {
        const solve_actuator *from = &at->actuation.actuators[k];
        strain_actuator *a = &newton->form->actuators[i * at->actuation.count + k];
        double pull = solve_actuation_pull(&at->actuation, k);
        spread(2, from->offset, a->given + ACTUATOR_OFFSET);
        spread(2, from->slope, a->given + ACTUATOR_SLOPE);
        spread(1, &pull, a->given + ACTUATOR_PULL);
    }
}

static void give_edges(strain_newton *newton)
{
    strain_form *form = newton->form;
    for (int e = 0; e <= form->kind.elements; e++) {
        const int jump = newton->system->jump[e];
        if (jump < 0) {
            continue;
        }
        const static_jump *at = &newton->system->jumps[jump];
        spread((size_t)at->acting->numbers, at->numbers,
               form->numbers + newton->system->rod->jumps.at[jump].first);
    }
}

static void give(strain_newton *newton)
{
    strain_form *form = newton->form;
    form->start = newton->system->ends[0];
    form->last = newton->system->ends[1];
    spread(3, form->last.position, form->held_r);
    spread(4, form->last.rotation, form->held_q);
    if (form->shift_at < 0) {
        spread(3, form->start.position, form->start_r);
    }
    if (form->turn_at < 0) {
        spread(4, form->start.rotation, form->start_q);
    }
    give_edges(newton);
}

/* ---- y to unknowns and back ---------------------------------------------------------------- */

/* What is sought besides curvature, from y at s = 0, at s = 1 and at edges. */
static void guess_ends(strain_newton *newton, const double *y)
{
    strain_form *form = newton->form;
    const static_system *system = newton->system;
    const int last = form->kind.elements, jump = system->jump[last];
    double R[3][3], world[3], after[STATIC_ROWS_MAX];
    memcpy(after, y + elements_edge(&system->mesh, last),
           (size_t)system->mesh.rows * sizeof *after);
    if (jump >= 0) {
        static_jump_over(&system->jumps[jump], y + elements_edge(&system->mesh, last), after, NULL);
    }
    if (form->shift_at >= 0) {
        spread(3, y + STATIC_R, form->start_r);
    }
    if (form->turn_at >= 0) {
        double q[4];
        memcpy(q, y + STATIC_Q, sizeof q);
        quaternion_normalize(q);
        spread(4, q, form->start_q);
    }
    if (form->force_at >= 0) {
        spread(3, after + STATIC_N, form->end_force);
    }
    if (form->moment_at >= 0) {
        rotation_matrix(after + STATIC_Q, R);
        to_world(R, after + STATIC_M, world);
        spread(3, world, form->end_moment);
    }
    for (int k = 0; k < form->place_count; k++) {
        strain_place *place = &form->places[k];
        const double *at = y + elements_edge(&system->mesh, place->edge);
        const static_jump *here = &system->jumps[system->jump[place->edge]];
        double wrench[6] = {0};
        acting_wrench(here->acting, here->numbers, (acting_on){at + STATIC_R, at + STATIC_Q, NULL},
                      ACTING_STORES, 1, wrench);
        spread(3, wrench, place->force);
    }
}

static bool guess(strain_newton *newton, const double *y)
{
    const static_system *system = newton->system;
    bool finite = true;
    for (int i = 0; i < newton->form->nodes && finite; i++) {
        const int e = i / system->mesh.stages;
        const double *at =
            y + elements_edge(&system->mesh, e) + (i % system->mesh.stages + 1) * system->mesh.rows;
        static_point point = static_system_point(system, (size_t)i);
        strain_node *node = &newton->form->at[i];
        double strain[3], curvature[3], push[6] = {0};
        give_point(newton, i, &point);
        static_strains(&point, at, strain, curvature);
        for (int k = 0; k < 3; k++) {
            finite = finite && isfinite(strain[k]) && isfinite(curvature[k]);
        }
        acting_wrench(point.acting, point.numbers, (acting_on){at + STATIC_R, at + STATIC_Q, NULL},
                      ACTING_STORES, 1, push);
        spread(3, strain, node->v);
        spread(3, curvature, node->u);
        spread(3, push, node->push);
    }
    strain_form_load(newton->form);
    guess_ends(newton, y);
    return finite;
}

static void put(lanes q[4], lanes r[3], lanes N[3], lanes M[3], lanes R[3][3], double *y)
{
    double turn[3][3], moment[3];
    gather(3, r, y + STATIC_R);
    gather(4, q, y + STATIC_Q);
    gather(3, N, y + STATIC_N);
    gather(3, M, moment);
    gather(9, R[0], turn[0]);
    to_body(turn, moment, y + STATIC_M);
}

static void put_all(strain_newton *newton, double *y)
{
    strain_form *form = newton->form;
    const int n = form->kind.stages, rows = newton->system->mesh.rows;
    for (int e = 0; e <= form->kind.elements; e++) {
        strain_edge *at = &form->edges[e];
        double *to = y + elements_edge(&newton->system->mesh, e);
        put(at->q, at->r, at->N, at->M, at->R, to);
        for (int i = 0; i < n && e < form->kind.elements; i++) {
            strain_node *node = &form->at[e * n + i];
            put(node->q, node->r, node->N, node->M, node->R, to + (i + 1) * rows);
        }
    }
}

/* ---- Newton's method ----------------------------------------------------------------------- */

/* Of lane 0; not a number if one is none. */
static double largest(size_t count, const lanes *x)
{
    double result = 0;
    for (size_t i = 0; i < count && !isnan(result); i++) {
        double size = fabs(x[i][0]);
        result = size <= result ? result : size;
    }
    return result;
}

static double curvature_of(const strain_form *form)
{
    double result = 1;
    for (int i = 0; i < form->nodes; i++) {
        result = fmax(result, largest(3, form->at[i].u));
    }
    return result;
}

static double shape(strain_form *form)
{
    strain_form_shape(form);
    return largest((size_t)form->unknowns, form->right);
}

/* A step from what is missing, shortened until less is; 0: nothing helps. Returns its length. */
static double take_step(strain_newton *newton, double *missing)
{
    strain_form *form = newton->form;
    const size_t count = (size_t)form->unknowns;
    double *right = newton->room + count * count;
    gather(count, form->right, right);
    strain_form_linearise_first(form, newton->room);
    if (ad_dense_lu(count, newton->room, newton->pivots) != 0) {
        return NAN;
    }
    ad_dense_lu_solve(count, 1, newton->room, newton->pivots, right);
    spread(count, right, newton->step);
    const double length = largest(count, newton->step), before = *missing;
    const bool small = length <= SMALL * curvature_of(form);
    for (double share = 1; share > 1e-4 && isfinite(length); share /= 2) {
        lanes by, back;
        spread(1, &share, &by);
        back = -by;
        strain_form_move(form, newton->step, &by);
        *missing = shape(form);
        if (*missing < before || (small && isfinite(*missing))) {
            return length;
        }
        strain_form_move(form, newton->step, &back);
    }
    return NAN;
}

bool strain_newton_solve(strain_newton *newton, double *y, long *steps)
{
    strain_form *form = newton->form;
    give(newton);
    if (!guess(newton, y)) {
        return false;
    }
    double missing = shape(form), before = INFINITY;
    for (int i = 0; i < STEPS_MAX && isfinite(missing); i++) {
        double length = take_step(newton, &missing), size = curvature_of(form);
        ++*steps;
        if (isnan(length)) {
            return false;
        }
        if (length <= LAST * size || (length <= SMALL * size && length > before / 2)) {
            put_all(newton, y);
            return true;
        }
        before = length;
    }
    return false;
}
