/* What follows from the curvature, on the tape: rotation, forces, strain, moment, residual. */
#include "physics/law/law.h"
#include "physics/rod/strain_internal.h"

#include <math.h>
#include <string.h>

/* ---- from s = 0 on ------------------------------------------------------------------------- */

/* Rotations over the steps of an element: from its beginning to its first point, from one to the
 * next, from the last to its end; one row each. */
static along_turn turns_of_element(const strain_rod *rod, int e, along curvature)
{
    const int n = rod->mesh.stages;
    const double h = rod->mesh.edges[e + 1] - rod->mesh.edges[e];
    double weights[3 * (STRAIN_STAGES_MAX + 1) * STRAIN_STAGES_MAX];
    along_twist a[3];
    for (int i = 0; i <= n; i++) {
        double terms[3][GAUSS_STAGES_MAX];
        gauss_magnus(&rod->rule, i > 0 ? rod->rule.nodes[i - 1] : 0, i < n ? rod->rule.nodes[i] : 1,
                     terms);
        for (int k = 0; k < 3; k++) {
            for (int j = 0; j < n; j++) {
                weights[(k * (n + 1) + i) * n + j] = h * terms[k][j];
            }
        }
    }
    for (int c = 0; c < 3; c++) {
        ad_value all = strain_weigh(3 * (n + 1), n, weights, curvature.x[c]);
        for (int k = 0; k < 3; k++) {
            a[k].turn.x[c] = ad_slice(all, k * (n + 1), n + 1);
            a[k].shift.x[c] = ad_scalar(rod->tape, 0);
        }
    }
    return strain_turn_by(strain_magnus(a).turn);
}

static along_turn turn_row(along_turn q, int row)
{
    along_turn one;
    for (int k = 0; k < 4; k++) {
        one.x[k] = ad_rows(q.x[k]) == 1 ? q.x[k] : ad_row(q.x[k], row);
    }
    return one;
}

along_turn strain_turn_over(const strain_rod *rod, int edge, along_turn q)
{
    for (int i = 0; i < rod_joint_count(&rod->open); i++) {
        rod_joint joint = rod_joint_of(&rod->open, i);
        if (joint.turns && fabs(joint.s - rod->mesh.edges[edge]) < 1e-12) {
            q = strain_turn_product(q, strain_turn_rows(ad_constant(rod->tape, 4, joint.turn)));
        }
    }
    return q;
}

static void turn_all(const strain_rod *rod, strain_state *state)
{
    const int n = rod->mesh.stages;
    ad_value rows[4][STRAIN_NODES_MAX];
    along_turn q = strain_turn_rows(rod->start.rotation);
    for (int e = 0; e < rod->mesh.elements; e++) {
        along_turn steps = turns_of_element(rod, e, strain_element(rod, state->curvature, e));
        state->edge_turn[e] = q;
        q = strain_turn_over(rod, e, q);
        for (int i = 0; i <= n; i++) {
            q = strain_turn_product(q, turn_row(steps, i));
            for (int k = 0; k < 4 && i < n; k++) {
                rows[k][e * n + i] = q.x[k];
            }
        }
    }
    state->edge_turn[rod->mesh.elements] = q;
    for (int k = 0; k < 4; k++) {
        state->turn.x[k] = ad_stack(rod->nodes, rows[k]);
    }
    state->R = strain_turn_matrix(state->turn);
}

/* ---- from s = 1 back ----------------------------------------------------------------------- */

/* Force and moment, world, of a law from outside. */
static void act(const strain_rod *rod, const strain_law *at, along position, along_turn turn,
                along wrench[2])
{
    ad_value given[LAW_GIVEN_MAX], both[LAW_WRENCH];
    const along still = strain_zeros(rod->tape);
    memcpy(given, position.x, sizeof position.x);
    memcpy(given + 3, turn.x, sizeof turn.x);
    memcpy(given + 7, still.x, sizeof still.x);
    memcpy(given + LAW_STATE, at->numbers, (size_t)law_table[at->law].numbers * sizeof *given);
    law_record(at->law, rod->tape, given, NULL, both, NULL);
    for (int i = 0; i < 6; i++) {
        wrench[i / 3].x[i % 3] = both[i];
    }
}

/* Before positions are known: of a law whose force does not depend on them, that, and the moment if
 * it does not either. */
static void act_turned(const strain_rod *rod, const strain_law *at, along_turn turn,
                       along wrench[2])
{
    act(rod, at, strain_zeros(rod->tape), turn, wrench);
    if (law_table[at->law].by_position) {
        wrench[1] = strain_zeros(rod->tape);
    }
}

void strain_loads(const strain_rod *rod, along_turn turn, along load_rate[2])
{
    along by[2];
    load_rate[0] = load_rate[1] = strain_zeros(rod->tape);
    for (int i = 0; i < rod->along_count; i++) {
        if (!law_force_by_position(&law_table[rod->along[i].law])) {
            act_turned(rod, &rod->along[i], turn, by);
            load_rate[0] = strain_add(load_rate[0], by[0]);
            load_rate[1] = strain_add(load_rate[1], by[1]);
        }
    }
}

along strain_moment_load(const strain_rod *rod, const strain_state *state)
{
    along sum = state->load_rate[1], by[2];
    for (int i = 0; i < rod->along_count; i++) {
        const law *of = &law_table[rod->along[i].law];
        if (of->by_position && of->has_moment) {
            act(rod, &rod->along[i], state->position, state->turn, by);
            sum = strain_add(sum, by[1]);
        }
    }
    return sum;
}

void strain_acting(const strain_rod *rod, int edge, along_turn turn, along *force, along *moment)
{
    const double s = rod->mesh.edges[edge];
    *force = *moment = strain_zeros(rod->tape);
    for (int i = 0; i < rod->place_count; i++) {
        const strain_law *at = &rod->places[i];
        if (fabs(at->s - s) < 1e-12 && !law_force_by_position(&law_table[at->law])) {
            along by[2];
            act_turned(rod, at, turn, by);
            *force = strain_add(*force, by[0]);
            *moment = strain_add(*moment, by[1]);
        }
    }
}

/* Over an element: from its points to its end; and all of it. */
static along integrate(const strain_rod *rod, int e, along rate, along *all)
{
    const int n = rod->mesh.stages;
    const double h = rod->mesh.edges[e + 1] - rod->mesh.edges[e];
    double to[(STRAIN_STAGES_MAX + 1) * STRAIN_STAGES_MAX];
    const along here = strain_element(rod, rate, e);
    along a;
    for (int j = 0; j < n; j++) {
        to[n * n + j] = h * rod->rule.weights[j];
        for (int i = 0; i < n; i++) {
            to[i * n + j] = h * (rod->rule.weights[j] - rod->rule.matrix[i][j]);
        }
    }
    for (int c = 0; c < 3; c++) {
        const ad_value both = strain_weigh(n + 1, n, to, here.x[c]);
        a.x[c] = ad_slice(both, 0, n);
        all->x[c] = ad_row(both, n);
    }
    return a;
}

static along join(const strain_rod *rod, const along *parts)
{
    int counts[STRAIN_ELEMENTS_MAX];
    for (int e = 0; e < rod->mesh.elements; e++) {
        counts[e] = rod->mesh.stages;
    }
    return strain_join(rod->mesh.elements, counts, parts);
}

/* The integral of a rate at all points and at edges, from s = 1 back, with what acts at edges. */
static along integrate_back(const strain_rod *rod, along rate, const along *acting, along *edges)
{
    along parts[STRAIN_ELEMENTS_MAX], all, sum = strain_zeros(rod->tape);
    for (int e = rod->mesh.elements; e >= 0; e--) {
        edges[e] = sum = strain_add(sum, acting[e]);
        if (e > 0) {
            parts[e - 1] = strain_add(integrate(rod, e - 1, rate, &all), sum);
            sum = strain_add(sum, all);
        }
    }
    return join(rod, parts);
}

along strain_moment_rate(along slope, along force, along load)
{
    return strain_add(strain_cross(slope, force), load);
}

/* ---- forces that depend on the place -------------------------------------------------------- */

/* Force per length, or at a place, of those laws where it depends on that. */
static along pushed(const strain_rod *rod, int count, const strain_law *laws, along position,
                    along_turn turn)
{
    along sum = strain_zeros(rod->tape), wrench[2];
    for (int i = 0; i < count; i++) {
        if (law_force_by_position(&law_table[laws[i].law])) {
            act(rod, &laws[i], position, turn, wrench);
            sum = strain_add(sum, wrench[0]);
        }
    }
    return sum;
}

static int edge_of(const strain_rod *rod, double s)
{
    int e = 0;
    while (e < rod->mesh.elements && fabs(rod->mesh.edges[e] - s) > 1e-12) {
        e++;
    }
    return e;
}

/* Tensions, of what is sought from `first` on; and all pulls. */
static void find_pulls(const strain_rod *rod, ad_value sought, int first, strain_state *state)
{
    for (int i = 0; i < rod->actuators; i++) {
        const strain_pull *of = &rod->pulls[i];
        state->pull[i] = of->pull;
        if (of->is_sought) {
            state->tension[i] = ad_row(sought, first++);
            state->pull[i] = strain_pull_within(rod, of, state->tension[i]);
        }
        if (of->rubs) {
            state->pull[i] = rod_tendon_rubbed(state->pull[i], of->friction, state->angle[i]);
        }
    }
}

/* Forces, curvature, what holds the end and pulls, of what is sought. */
static void divide(const strain_rod *rod, ad_value sought, strain_state *state)
{
    const bool holds[2] = {rod->holds_position, rod->holds_rotation};
    int first = 0;
    state->push = strain_zeros(rod->tape);
    if (rod->is_pushed) {
        state->push = strain_of_points(rod->nodes, ad_slice(sought, 0, 3 * rod->nodes));
        first = 3 * rod->nodes;
    }
    for (int i = 0; i < rod->place_count; i++) {
        state->pushes[i] = strain_zeros(rod->tape);
        if (law_force_by_position(&law_table[rod->places[i].law])) {
            state->pushes[i] = strain_rows(ad_slice(sought, first, 3));
            first += 3;
        }
    }
    for (int i = 0; i < rod->actuators; i++) {
        if (rod->pulls[i].rubs) {
            state->angle[i] = ad_slice(sought, first, rod->nodes);
            first += rod->nodes;
        }
    }
    const int twisting = first;
    first += rod->twisting;
    const bool all = rod->forces + rod->twisting + rod->held == 0;
    state->curvature =
        strain_of_points(rod->nodes, all ? sought : ad_slice(sought, first, 3 * rod->nodes));
    strain_torsion_turn(rod, sought, twisting, state);
    first += 3 * rod->nodes;
    for (int i = 0; i < 2; i++) {
        state->held[i] = strain_zeros(rod->tape);
        if (holds[i]) {
            state->held[i] = strain_rows(ad_slice(sought, first, 3));
            first += 3;
        }
    }
    find_pulls(rod, sought, first, state);
}

static void find_loads(const strain_rod *rod, strain_state *state)
{
    strain_loads(rod, state->turn, state->load_rate);
    state->load_rate[0] = strain_add(state->load_rate[0], state->push);
}

/* Forces and angles that are sought less what the shape makes of them, to rows; returns how many.
 */
static int missing_forces(const strain_rod *rod, const strain_state *state, ad_value *rows)
{
    along is[2];
    int count = 0;
    if (rod->is_pushed) {
        const along sum = pushed(rod, rod->along_count, rod->along, state->position, state->turn);
        rows[count++] = strain_points(rod->nodes, strain_sub(state->push, sum));
    }
    for (int i = 0; i < rod->place_count; i++) {
        if (law_force_by_position(&law_table[rod->places[i].law])) {
            const int e = edge_of(rod, rod->places[i].s);
            act(rod, &rod->places[i], state->edge_position[e], state->edge_turn[e], is);
            rows[count++] = ad_stack(3, strain_sub(state->pushes[i], is[0]).x);
        }
    }
    for (int i = 0; i < rod->actuators; i++) {
        const strain_pull *of = &rod->pulls[i];
        if (of->rubs) {
            rows[count++] = ad_sub(state->angle[i], strain_pull_angle(rod, of, state));
        }
    }
    return count;
}

/* How far the end is from where it is held, and the force that holds it in other directions. */
static int missing_holds(const strain_rod *rod, const strain_state *state, ad_value *rows)
{
    const int last = rod->mesh.elements;
    const rod_end_data *end = &rod->end;
    const ad_value q = ad_stack(4, state->edge_turn[last].x);
    int count = 0;
    if (rod->holds_position) {
        const rod_hold other = rod_hold_other(&end->hold);
        const ad_value off = ad_sub(ad_stack(3, state->edge_position[last].x), end->position);
        rows[count++] = ad_add(rod_hold_part(&rod->rod, &end->hold, off),
                               rod_hold_part(&rod->rod, &other, ad_stack(3, state->held[0].x)));
    }
    if (rod->holds_rotation) { /* q and -q are one rotation */
        const ad_value turn = ad_quaternion_multiply(ad_quaternion_conjugate(end->rotation), q);
        const ad_value vector = ad_mul(ad_scale(ad_sign(ad_row(turn, 0)), 2), ad_slice(turn, 1, 3));
        rows[count++] = ad_rotate(end->rotation, vector);
    }
    return count;
}

/* By how much tendons are shorter than they may be. */
static int missing_lengths(const strain_rod *rod, const strain_state *state, ad_value *rows)
{
    double weights[STRAIN_NODES_MAX];
    int count = 0;
    strain_mesh_integral(&rod->mesh, true, rod->mesh.elements, weights);
    for (int i = 0; i < rod->actuators; i++) {
        const strain_pull *of = &rod->pulls[i];
        if (of->is_sought) {
            const ad_value now = strain_pull_length(rod, of, state->strain, state->curvature);
            const ad_value rest =
                strain_pull_length(rod, of, rod->rest_strain, rod->rest_curvature);
            const ad_value longer = strain_weigh(1, rod->nodes, weights, ad_sub(now, rest));
            const ad_value excess = ad_add(longer, of->displacement);
            rows[count++] = ad_sub(ad_mul(of->compliance, state->tension[i]), excess);
        }
    }
    return count;
}

/* N, from the loads and the turns at edges. */
static void find_force(const strain_rod *rod, strain_state *state)
{
    along force[STRAIN_ELEMENTS_MAX + 1], moment;
    for (int e = 0; e <= rod->mesh.elements; e++) {
        strain_acting(rod, e, state->edge_turn[e], &force[e], &moment);
    }
    for (int i = 0; i < rod->place_count; i++) {
        const int e = edge_of(rod, rod->places[i].s);
        force[e] = strain_add(force[e], state->pushes[i]);
    }
    force[rod->mesh.elements] = strain_add(force[rod->mesh.elements], state->held[0]);
    state->force = integrate_back(rod, state->load_rate[0], force, state->edge_force);
}

/* Positions, where laws or the end ask for them. */
static void find_positions(const strain_rod *rod, strain_state *state)
{
    along parts[STRAIN_ELEMENTS_MAX], all, sum = strain_rows(rod->start.position);
    for (int e = 0; e <= rod->mesh.elements && rod->is_placed; e++) {
        state->edge_position[e] = sum;
        if (e < rod->mesh.elements) {
            const along rest = integrate(rod, e, state->slope, &all); /* from a point to the end */
            sum = strain_add(sum, all);
            parts[e] = strain_sub(sum, rest);
        }
    }
    if (rod->is_placed) {
        state->position = join(rod, parts);
    }
}

/* Moments at edges that depend on the position. */
static void add_placed(const strain_rod *rod, const strain_state *state, along *moment)
{
    for (int i = 0; i < rod->place_count; i++) {
        const law *of = &law_table[rod->places[i].law];
        if (of->by_position && of->has_moment) {
            const int e = edge_of(rod, rod->places[i].s);
            along by[2];
            act(rod, &rod->places[i], state->edge_position[e], state->edge_turn[e], by);
            moment[e] = strain_add(moment[e], by[1]);
        }
    }
}

/* r' and M, from N and the strain. */
static void find_moment(const strain_rod *rod, strain_state *state)
{
    along force, moment[STRAIN_ELEMENTS_MAX + 1];
    for (int e = 0; e <= rod->mesh.elements; e++) {
        strain_acting(rod, e, state->edge_turn[e], &force, &moment[e]);
    }
    moment[rod->mesh.elements] = strain_add(moment[rod->mesh.elements], state->held[1]);
    state->slope = strain_to_world(&state->R, state->strain);
    find_positions(rod, state);
    add_placed(rod, state, moment);
    state->moment = integrate_back(
        rod, strain_moment_rate(state->slope, state->force, strain_moment_load(rod, state)), moment,
        state->edge_moment);
}

static void find_state(const strain_rod *rod, ad_value sought, strain_state *state)
{
    const int more = rod->forces + rod->twisting + rod->held;
    if (ad_rows(sought) != more + 3 * rod->nodes) {
        ad_tape_fail(rod->tape, AD_BAD_SHAPE, "%d forces and curvature at %d points: %d rows", more,
                     rod->nodes, ad_rows(sought));
    }
    divide(rod, sought, state);
    turn_all(rod, state);
    find_loads(rod, state);
    find_force(rod, state);
    state->strain = strain_yield(rod, state->pull, strain_to_body(&state->R, state->force),
                                 state->curvature, rod->rest_strain);
    find_moment(rod, state);
}

/* ---- the state as one vector ---------------------------------------------------------------- */

enum { BY_TURNS, BY_FORCE, BY_STRAIN, PARTS, FIELDS_MAX = 29 + 13 * STRAIN_ELEMENTS_MAX };

/* The fields of the vector in turn: those of part i end at ends[i]. Others are the same at all
 * points, or 0, and are recorded anew. */
typedef struct fields {
    ad_value *of[FIELDS_MAX];
    int count, ends[PARTS];
} fields;

static void add_fields(const strain_rod *rod, int count, ad_value *of, bool at_points, fields *all)
{
    for (int i = 0; i < count; i++) {
        if (at_points ? ad_rows(of[i]) == rod->nodes : !ad_is_constant(of[i], 0)) {
            all->of[all->count++] = &of[i];
        }
    }
}

static fields list_fields(const strain_rod *rod, strain_state *state)
{
    const int elements = rod->mesh.elements;
    fields all = {.count = 0};
    for (int i = 0; i < 3; i++) {
        add_fields(rod, 3, state->R.x[i], true, &all);
    }
    add_fields(rod, rod->turns ? 4 : 0, state->turn.x, true, &all);
    add_fields(rod, 3, state->force.x, true, &all);
    for (int e = 1; e <= elements; e++) {
        add_fields(rod, 4, state->edge_turn[e].x, false, &all);
        add_fields(rod, 3, state->edge_force[e].x, false, &all);
    }
    all.ends[BY_TURNS] = all.count;
    add_fields(rod, 3, state->strain.x, true, &all);
    all.ends[BY_FORCE] = all.count;
    add_fields(rod, 3, state->moment.x, true, &all);
    for (int e = 1; e <= elements; e++) {
        add_fields(rod, 3, state->edge_moment[e].x, false, &all);
    }
    if (rod->is_placed) {
        add_fields(rod, 3, state->position.x, true, &all);
        for (int e = 1; e <= elements; e++) {
            add_fields(rod, 3, state->edge_position[e].x, false, &all);
        }
    }
    all.ends[BY_STRAIN] = all.count;
    return all;
}

ad_value strain_rod_state(const strain_rod *rod, ad_value sought)
{
    ad_value parts[FIELDS_MAX];
    strain_state state;
    find_state(rod, sought, &state);
    const fields all = list_fields(rod, &state);
    for (int i = 0; i < all.count; i++) {
        parts[i] = *all.of[i];
    }
    return ad_stack(all.count, parts);
}

void strain_state_of(const strain_rod *rod, ad_value sought, ad_value vector, strain_state *state)
{
    int first = 0;
    find_state(rod, sought, state);
    const fields all = list_fields(rod, state);
    for (int i = 0; i < all.count; i++) {
        const int rows = ad_rows(*all.of[i]);
        *all.of[i] = ad_slice(vector, first, rows);
        first += rows;
    }
    find_loads(rod, state);
    state->slope = strain_to_world(&state->R, state->strain);
}

/* How fields `first` to `end` change, to `parts`, which has those of the fields before. */
static void change_fields(const fields *all, int first, int end, const strain_changes *changes,
                          ad_value vector, ad_value *parts)
{
    ad_value wrt[3], along[3], y[FIELDS_MAX];
    for (int i = 0; i < changes->count; i++) {
        wrt[i] = changes->wrt[i];
        along[i] = changes->along[i];
    }
    wrt[changes->count] = vector;
    along[changes->count] = ad_stack(all->count, parts);
    for (int i = first; i < end; i++) {
        y[i] = *all->of[i];
    }
    if (end > first) {
        ad_directional(end - first, y + first, changes->count + 1, wrt, along, parts + first);
    }
    for (int i = first; i < end; i++) {
        parts[i] =
            ad_rows(parts[i]) < ad_rows(y[i]) ? ad_repeat(parts[i], ad_rows(y[i])) : parts[i];
    }
}

/* Those of the strain, where v is on both sides of what it obeys: at v, the rest having changed. */
static void soften_fields(const strain_rod *rod, const fields *all, const strain_state *state,
                          along v, ad_value *parts)
{
    along change = strain_zeros(rod->tape);
    for (int i = all->ends[BY_TURNS]; i < all->ends[BY_FORCE]; i++) {
        change.x[all->of[i] - state->strain.x] = parts[i];
    }
    change = strain_softened(rod, state->pull, v, state->curvature, change);
    for (int i = all->ends[BY_TURNS]; i < all->ends[BY_FORCE]; i++) {
        parts[i] = change.x[all->of[i] - state->strain.x];
    }
}

ad_value strain_rod_state_change(const strain_rod *rod, ad_value sought, ad_value vector,
                                 const strain_changes *changes)
{
    ad_value parts[FIELDS_MAX];
    strain_state state;
    find_state(rod, sought, &state);
    const fields all = list_fields(rod, &state);
    for (int i = 0; i < all.count; i++) {
        parts[i] = ad_zeros(rod->tape, ad_rows(*all.of[i]));
    }
    change_fields(&all, 0, all.ends[BY_TURNS], changes, vector, parts);
    strain_state_of(rod, sought, vector, &state);
    const along v = state.strain;
    state.strain =
        strain_balance(rod, state.pull, strain_to_body(&state.R, state.force), state.curvature, v);
    change_fields(&all, all.ends[BY_TURNS], all.ends[BY_FORCE], changes, vector, parts);
    if (strain_is_implicit(rod)) {
        soften_fields(rod, &all, &state, v, parts);
    }
    state.strain = v;
    find_moment(rod, &state);
    change_fields(&all, all.ends[BY_FORCE], all.ends[BY_STRAIN], changes, vector, parts);
    return ad_stack(all.count, parts);
}

ad_value strain_rod_residual(const strain_rod *rod, ad_value sought, ad_value vector)
{
    strain_state state;
    strain_state_of(rod, sought, vector, &state);
    ad_value rows[1 + ROD_AT_PLACES_MAX + 3 + 2 * SCENE_TENDONS_MAX + 2 * SCENE_TUBES_MAX];
    int count = missing_forces(rod, &state, rows);
    count += strain_torsion_missing(rod, &state, rows + count);
    const along less = strain_mul(rod->curvature_compliance, strain_torsion_moment(rod, &state));
    rows[count++] =
        strain_points(rod->nodes, strain_add(strain_missing(rod, state.pull, &state.R, state.strain,
                                                            state.curvature, state.moment),
                                             less));
    count += missing_holds(rod, &state, rows + count);
    count += missing_lengths(rod, &state, rows + count);
    return count > 1 ? ad_stack(count, rows) : rows[0];
}

ad_value strain_rod_positions(const strain_rod *rod, ad_value sought, ad_value vector)
{
    strain_state state;
    ad_value rows[6];
    strain_state_of(rod, sought, vector, &state);
    for (int c = 0; c < 3; c++) {
        ad_value at = state.position.x[c];
        rows[2 * c] = ad_rows(at) == 1 ? ad_repeat(at, rod->nodes) : at;
        rows[2 * c + 1] = state.edge_position[rod->mesh.elements].x[c];
    }
    return ad_stack(6, rows);
}
