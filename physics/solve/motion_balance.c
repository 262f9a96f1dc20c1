#include "physics/solve/motion_balance.h"

#include "physics/local/inertia.h"
#include "physics/local/mesh.h"
#include "physics/numerics/quaternion.h"
#include "physics/solve/motion_internal.h"
#include "physics/solve/motion_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Elements hold waves of some 10 radians each to rounding. Between two times, parts no longer than
 * so many units of time, each with so many points, hold vibrations of some 400 radians per unit. */
enum { ELEMENTS = 3, DEGREE = 14, STAGES = 8 };
static const double PART = 1.0 / 32;

/* Of a stretch of time: its ends are taken so much further in, where what jumps there is that of
 * the stretch. Of s: a place is looked at so much before it. */
static const double WITHIN = 1e-9, BEFORE = 1e-12;

typedef struct balance {
    solve_rod *rod;
    motion *m;
    solve_known_motion *known;
    void *context;
    size_t columns;
    double units[MODEL_COLUMNS_MAX];
    double *s, *t;   /* [nodes] in SI; `s` owns the next */
    double *values;  /* [columns][nodes] */
    double *state;   /* [nodes][MOTION_ROWS] */
    double outer[3]; /* force of all outside: of loads, springs and held ends */
    double momentum[3], impulse[3], momentum_at_start[3];
    double mass, work, dissipated, energy_at_start;
    double largest, energy_missing, momentum_missing;
} balance;

static void balance_free(balance *b)
{
    motion_free(b->m);
    solve_rod_free(b->rod);
    free(b->s);
}

static ad_status make_mesh(balance *b, ad_error *error)
{
    solve_quadrature *places = NULL;
    ad_status status = motion_places_of(b->rod, &places, error);
    if (status != AD_OK) {
        return status;
    }
    double *edges = malloc((size_t)(ELEMENTS + places->place_count + 1) * sizeof *edges);
    if (edges) {
        int elements = solve_mesh_edges(ELEMENTS, places->place_count, places->places, edges);
        status = motion_create(b->rod, 0, elements, edges, DEGREE, &b->m, error);
    } else {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a mesh");
    }
    free(edges);
    solve_quadrature_free(places);
    return status;
}

static ad_status make_room(balance *b, ad_error *error)
{
    size_t nodes = motion_nodes(b->m);
    b->s = malloc((2 + b->columns + MOTION_ROWS) * nodes * sizeof *b->s);
    if (!b->s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", nodes);
    }
    b->t = b->s + nodes;
    b->values = b->t + nodes;
    b->state = b->values + b->columns * nodes;
    for (size_t i = 0; i < nodes; i++) {
        b->s[i] = b->m->s[i] * b->rod->scales.length;
        b->mass += b->m->mass[i];
    }
    for (int k = 0; k < b->rod->jumps.count; k++) {
        b->s[b->m->places[k].node] *= 1 - BEFORE;
    }
    return AD_OK;
}

/* ---- at one time --------------------------------------------------------------------------- */

static solve_state known_at(const balance *b, size_t node)
{
    solve_state known;
    double *to = (double *)&known;
    for (size_t c = 0; c < b->columns; c++) {
        to[c] = b->values[c * motion_nodes(b->m) + node] / b->units[c];
    }
    return known;
}

static ad_status go_to(balance *b, double t, ad_error *error)
{
    size_t nodes = motion_nodes(b->m);
    for (size_t i = 0; i < nodes; i++) {
        b->t[i] = t * b->rod->scales.time;
    }
    ad_status status = b->known(b->context, nodes, b->s, b->t, b->values, error);
    status = status == AD_OK ? motion_at(b->m, t, error) : status;
    for (size_t i = 0; i < nodes && status == AD_OK; i++) {
        solve_state known = known_at(b, i);
        double *to = b->state + i * MOTION_ROWS;
        memcpy(to + MOTION_R, known.position, sizeof known.position);
        memcpy(to + MOTION_Q, known.rotation, sizeof known.rotation);
        memcpy(to + MOTION_V, known.velocity, sizeof known.velocity);
        memcpy(to + MOTION_W, known.spin, sizeof known.spin);
    }
    for (int k = 0; k < b->rod->jumps.count && status == AD_OK; k++) {
        solve_state known = known_at(b, b->m->places[k].node);
        motion_turn_node(b->m, k, known.rotation, known.spin, b->state);
    }
    return status;
}

/* The force by which bodies at place k, which an end moves, resist; R: of the rod there. */
static void resist_at_end(const balance *b, int k, int end, double R[3][3], double force[3])
{
    const motion *m = b->m;
    const solve_end_state *now = &m->ends[end];
    double spin[3], spin_rate[3], wrench[6];
    const inertia what = solve_jump_body(&b->rod->jumps, m->number, k);
    to_world(R, now->spin, spin);
    to_world(R, now->spin_rate, spin_rate);
    inertia_wrench(
        &what,
        (inertia_motion){(const double(*)[3])R, now->velocity, spin, now->acceleration, spin_rate},
        wrench);
    memcpy(force, wrench, 3 * sizeof *force);
}

/* The force of what holds an end: by N of the motion, which also bears what acts at this place and
 * moves a body there. */
static void add_reaction(balance *b, int end)
{
    const motion *m = b->m;
    const solve_end *kind = &b->rod->ends[end];
    solve_state known = known_at(b, motion_end_node(m, end));
    double R[3][3], force[3], held[3], part[3];
    rotation_matrix(known.rotation, R);
    to_world(R, known.force, force);
    scene_hold_part(&kind->hold, force, held);
    for (int i = 0; i < 3; i++) {
        b->outer[i] += end ? held[i] : -held[i];
    }
    for (int k = 0; k < b->rod->jumps.count; k++) {
        if (m->places[k].node == motion_end_node(m, end)) {
            motion_place_force(m, k, force);
            resist_at_end(b, k, end, R, part);
            for (int i = 0; i < 3; i++) {
                force[i] += part[i];
            }
            scene_hold_part(&kind->hold, force, part);
            for (int i = 0; i < 3; i++) {
                b->outer[i] -= part[i];
            }
        }
    }
}

/* Work, dissipation and impulses of a time `weight`. Internal forces on all nodes add up to 0, and
 * springs are among them. */
static void add_stage(balance *b, double weight)
{
    motion_power power = motion_power_of(b->m, b->state);
    motion_internal_forces(b->m);
    memset(b->outer, 0, sizeof b->outer);
    add_reaction(b, 0);
    add_reaction(b, 1);
    for (size_t i = 0; i < motion_nodes(b->m); i++) {
        for (int k = 0; k < 3; k++) {
            b->outer[k] += b->m->force[i][k] + b->m->push[i][k];
        }
    }
    b->work += weight * power.load;
    b->dissipated += weight * power.dissipation;
    for (int k = 0; k < 3; k++) {
        b->impulse[k] += weight * b->outer[k];
    }
}

/* Energy and momentum of the state at hand. */
static double energy_now(balance *b)
{
    motion_energy energy = motion_energy_of(b->m, b->state);
    memset(b->momentum, 0, sizeof b->momentum);
    if (b->m->has_added) {
        motion_find_added(b->m);
    }
    for (size_t i = 0; i < motion_nodes(b->m); i++) {
        const double *V = b->m->flow[i];
        for (int k = 0; k < 3; k++) {
            b->momentum[k] += b->m->mass[i] * V[k];
            if (b->m->has_added) {
                const double *by = b->m->added[i].mass[k];
                b->momentum[k] += vector_dot(by, V) + vector_dot(by + 3, b->m->spin[i]);
            }
        }
    }
    return energy.kinetic + energy.strain;
}

/* ---- through time -------------------------------------------------------------------------- */

static void compare(balance *b, double energy)
{
    double missing[3];
    for (int k = 0; k < 3; k++) {
        missing[k] = b->momentum[k] - b->momentum_at_start[k] - b->impulse[k];
    }
    double mismatch = fabs(energy - b->energy_at_start + b->dissipated - b->work);
    b->largest = fmax(b->largest, fmax(energy, fmax(fabs(b->work), b->dissipated)));
    b->energy_missing = motion_larger(b->energy_missing, mismatch);
    b->momentum_missing = motion_larger(b->momentum_missing, sqrt(vector_dot(missing, missing)));
}

/* To where a stretch of time begins: at the first, and where a rest shape may jump. */
static ad_status enter(balance *b, double t, bool first, ad_error *error)
{
    double before = first ? 0 : motion_energy_of(b->m, b->state).strain;
    ad_status status = go_to(b, t, error);
    if (status == AD_OK && first) {
        b->energy_at_start = energy_now(b);
        memcpy(b->momentum_at_start, b->momentum, sizeof b->momentum);
    } else if (status == AD_OK && b->rod->rest_moves) {
        b->work += motion_energy_of(b->m, b->state).strain - before;
    }
    return status;
}

static ad_status pass(balance *b, double from, double to, ad_error *error)
{
    const gauss_rule rule = solve_gauss_rule_of(STAGES);
    const int parts = 2 + (int)fmin((to - from) / PART, 1e6);
    const double length = (to - from) / parts;
    ad_status status = AD_OK;
    for (int part = 0; part < parts && status == AD_OK; part++) {
        for (int i = 0; i < rule.stages && status == AD_OK; i++) {
            status = go_to(b, from + length * (part + rule.nodes[i]), error);
            if (status == AD_OK) {
                add_stage(b, length * rule.weights[i]);
            }
        }
        double end = from + length * (part + 1) - (part + 1 == parts ? WITHIN * (to - from) : 0);
        status = status == AD_OK ? go_to(b, end, error) : status;
        if (status == AD_OK) {
            compare(b, energy_now(b));
        }
    }
    return status;
}

static ad_status balance_all(balance *b, int count, const double *times, ad_error *error)
{
    ad_status status = make_mesh(b, error);
    status = status == AD_OK ? make_room(b, error) : status;
    solve_rod_units(b->rod, b->units);
    for (int i = 0; status == AD_OK && !b->m->has_branch && i + 1 < count; i++) {
        double from = times[i] / b->rod->scales.time, to = times[i + 1] / b->rod->scales.time;
        status = enter(b, from + WITHIN * (to - from), i == 0, error);
        status = status == AD_OK ? pass(b, from, to, error) : status;
    }
    return status;
}

static bool can_be_known(const solve_rod *rod)
{
    bool moves = solve_end_is_driven(&rod->ends[0]) || solve_end_is_driven(&rod->ends[1]);
    for (int k = 0; k < rod->jumps.count; k++) { /* how a body turns there is not known */
        const int end = rod->jumps.at[k].s > 0.5;
        if (rod->jumps.at[k].beside && fabs(rod->jumps.at[k].s - end) < SOLVE_SAME_PLACE &&
            rod->ends[end].hold.directions > 0 && !rod->ends[end].holds_rotation) {
            return false;
        }
    }
    return rod_numbers_of(&rod->scene).rotary_inertia > 0 &&
           !(moves && scene_locks_strains(&rod->scene));
}

/* Of a motion that is not a number nothing balances. */
static double or_infinite(double missing)
{
    return isnan(missing) ? INFINITY : missing;
}

ad_status motion_balance_of(const scene *rod_scene, int count, const double *times,
                            solve_known_motion *motion, void *context, motion_balance *result,
                            ad_error *error)
{
    balance b = {.known = motion, .context = context};
    *result = (motion_balance){NAN, NAN};
    b.columns = (size_t)solution_columns(rod_scene);
    ad_status status = solve_rod_create(rod_scene, &b.rod, error);
    if (status == AD_OK && can_be_known(b.rod)) {
        status = balance_all(&b, count, times, error);
        if (status == AD_OK && !b.m->has_branch) {
            double size = b.largest + SOLVE_ENERGY_ROUNDING;
            result->energy = or_infinite(b.energy_missing / size);
            result->momentum = or_infinite(b.momentum_missing / sqrt(2 * b.mass * size));
        }
    }
    balance_free(&b);
    return status;
}
