/* What vanishes for the true solution, kind by kind, and what is observed of it. */
#include "physics/rod/rod_internal.h"

#include <math.h>

/* ---- strains of the mixed form, and those that are unknowns ---------------------------------- */

bool rod_has_strains(const scene *rod_scene)
{
    return rod_scene->formulation == SCENE_MIXED || rod_scene->formulation == SCENE_POSE_STRAIN;
}

/* v - v* - Kse^-1 (R^T N - what is beyond elastic): a locked strain is a compliance of 0. */
static ad_value rod_strain_residual(const rod_context *rod, rod_state state)
{
    if (rod->scene->formulation == SCENE_POSE_STRAIN) {
        rod_kinematics pose = rod_kinematics_of(rod, state.position, state.rotation);
        return ad_sub(pose.strain, ad_slice(state.strains, 0, 3));
    }
    rod_coefficients c = rod_coefficients_of(rod);
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    ad_value force = ad_rotate_inverse(state.rotation, state.force);
    ad_value elastic = ad_sub(force, rod_beyond_elastic(rod, &k, state.tendons).force);
    return ad_sub(ad_sub(k.strain, c.rest_strain), ad_mul(c.strain_compliance, elastic));
}

/* u - u* - Kbt^-1 (m - what is beyond elastic - tubes); where tubes stiffen the rod, by how much.
 */
static ad_value rod_curvature_residual(const rod_context *rod, rod_state state)
{
    if (rod->scene->formulation == SCENE_POSE_STRAIN) {
        rod_kinematics pose = rod_kinematics_of(rod, state.position, state.rotation);
        return ad_sub(pose.curvature, ad_slice(state.strains, 3, 3));
    }
    rod_coefficients c = rod_coefficients_of(rod);
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    ad_value elastic = ad_sub(state.moment, rod_beyond_elastic(rod, &k, state.tendons).moment);
    bool tubes = rod->scene->tube_count > 0;
    if (tubes) {
        elastic = ad_sub(elastic, rod_tube_moment(rod, state.tubes, k.curvature));
    }
    ad_value missing =
        ad_sub(ad_sub(k.curvature, c.rest_curvature), ad_mul(c.curvature_compliance, elastic));
    return tubes ? ad_mul(rod_tube_stiffening(rod, c.curvature_compliance), missing) : missing;
}

/* ---- balances -------------------------------------------------------------------------------- */

/* A moment about a director that is softer than bending, twist at most, by its own stiffness: what
 * it misses turns the rod by so much. In mixed form, which computes strains from moments. */
static ad_value rod_by_stiffness(const rod_context *rod, ad_value moment)
{
    if (rod->scene->formulation != SCENE_MIXED) {
        return moment;
    }
    double unit = rod->scales.moment * rod->scales.length, factor[3];
    for (int i = 0; i < 3; i++) {
        double stiffness = scene_mean_stiffness(rod->scene, rod->properties.curvature_stiffness[i]);
        factor[i] = fmax(1, unit / stiffness);
    }
    return ad_mul(ad_vector_constant(rod->tape, factor[0], factor[1], factor[2]), moment);
}

static ad_value rod_balance_residual(const rod_context *rod, bool force, rod_state state)
{
    ad_value balance = force ? rod_force_balance(rod, state) : rod_moment_balance(rod, state);
    if (scene_is_manufactured(rod->scene)) {
        rod_load load = rod_manufactured_load(rod->scene, rod->s, rod->t);
        ad_value added = force ? load.force : ad_rotate_inverse(state.rotation, load.moment);
        balance = ad_add(balance, added);
    }
    return force ? rod_vector_in_plane(rod, balance)
                 : rod_axial_in_plane(rod, rod_by_stiffness(rod, balance));
}

/* ---- conditions at ends and at the start of time --------------------------------------------- */

static bool rod_is_mixed(const scene *rod_scene)
{
    return rod_scene->formulation == SCENE_MIXED;
}

/* Which of the two rows-of-3 of an end are residuals: a held pose only when it is soft, force and
 * moment also in the other forms, where the ansatz cannot hold them. */
static bool rod_end_needs(const scene *rod_scene, bool natural)
{
    return rod_scene->boundary_enforcement == SCENE_SOFT || (natural && !rod_is_mixed(rod_scene));
}

/* Whether the rows of position and force are residuals: any of their directions. */
static bool rod_end_moves(const scene *rod_scene, int directions)
{
    return (directions > 0 && rod_end_needs(rod_scene, false)) ||
           (directions < 3 && rod_end_needs(rod_scene, true));
}

static int rod_end_rows(const scene *rod_scene, int end)
{
    const scene_end *given = end ? &rod_scene->end : &rod_scene->start;
    rod_plane plane = rod_plane_of(rod_scene);
    bool moves = rod_end_moves(rod_scene, scene_hold_of(given).directions);
    bool turns = rod_end_needs(rod_scene, !scene_end_holds_rotation(given->type));
    return moves * rod_vector_rows(&plane) + turns * rod_axial_rows(&plane);
}

/* 2 vec(p* q): the rotation from p to q, 0 for q = p and q = -p. */
static ad_value rod_rotation_mismatch(ad_value p, ad_value q)
{
    return rod_rate(p, q);
}

/* What is prescribed of N and m, with what acts at the end itself: at s = 0 the rod begins behind
 * it, at s = 1 it ends before. */
static rod_wrench rod_end_wrench(const rod_context *rod, const rod_end_data *data, rod_state state,
                                 int end)
{
    rod_force_at acting[ROD_AT_PLACES_MAX + SCENE_BODIES_MAX];
    rod_pose field = {state.position, state.rotation};
    rod_wrench wrench = {rod_end_force(data, state.rotation), rod_end_moment(data, state.rotation)};
    int count = rod_has_places(rod->scene) ? rod_forces_at(rod, &field, acting) : 0;
    for (int i = 0; i < count; i++) {
        if (end ? acting[i].s >= 1 : acting[i].s <= 0) {
            double sign = end ? 1 : -1;
            wrench.force = ad_add(wrench.force, ad_scale(acting[i].force, sign));
            wrench.moment = ad_add(wrench.moment, ad_scale(acting[i].moment, sign));
        }
    }
    return wrench;
}

static ad_value rod_end_residual(const rod_context *rod, rod_state state, int end)
{
    rod_end_data data = rod_end_of(rod, end, rod->t);
    rod_wrench wrench = rod_end_wrench(rod, &data, state, end);
    ad_value parts[2];
    int count = 0;
    if (rod_end_moves(rod->scene, data.hold.directions)) {
        ad_value moves = ad_zeros(rod->tape, 3);
        rod_hold free = rod_hold_other(&data.hold);
        if (data.hold.directions > 0 && rod_end_needs(rod->scene, false)) {
            ad_value away = ad_sub(state.position, data.position);
            moves = ad_add(moves, rod_hold_part(rod, &data.hold, away));
        }
        if (free.directions > 0) {
            ad_value beyond = ad_sub(state.force, wrench.force);
            moves = ad_add(moves, rod_hold_part(rod, &free, beyond));
        }
        parts[count++] = rod_vector_in_plane(rod, moves);
    }
    if (rod_end_needs(rod->scene, !data.holds_rotation)) {
        ad_value turns = data.holds_rotation ? rod_rotation_mismatch(data.rotation, state.rotation)
                                             : ad_sub(state.moment, wrench.moment);
        parts[count++] = rod_axial_in_plane(rod, turns);
    }
    return ad_stack(count, parts);
}

static ad_value rod_initial_residual(const rod_context *rod, rod_state state)
{
    rod_initial_data initial = rod_initial_of(rod, rod->s);
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    ad_value turned = rod_rotation_mismatch(initial.rotation, state.rotation);
    ad_value parts[4] = {rod_vector_in_plane(rod, ad_sub(state.position, initial.position)),
                         rod_axial_in_plane(rod, turned),
                         rod_vector_in_plane(rod, ad_sub(k.velocity, initial.velocity)),
                         rod_axial_in_plane(rod, ad_sub(k.spin, initial.spin))};
    return ad_stack(4, parts);
}

/* ---- weights --------------------------------------------------------------------------------- */

/* Errors of the first two add up along s. The rows of shear and stretch are strains, not forces, so
 * no weight has to follow the slenderness (tests/train/test_slender.c). */
rod_weights rod_weights_default(void)
{
    return (rod_weights){
        .strain = 1000, .curvature = 100, .force = 1, .moment = 1, .boundary = 1, .initial = 1};
}

double rod_weight_of(const rod_weights *weights, rod_residual_kind kind)
{
    switch (kind) {
    case ROD_STRAIN:
        return weights->strain;
    case ROD_CURVATURE:
    case ROD_TENDON:
    case ROD_TWIST:
        return weights->curvature;
    case ROD_FORCE:
        return weights->force;
    case ROD_MOMENT:
    case ROD_TORSION:
        return weights->moment;
    case ROD_INITIAL:
        return weights->initial;
    default:
        return weights->boundary;
    }
}

/* ---- the face -------------------------------------------------------------------------------- */

const char *rod_residual_name(rod_residual_kind kind)
{
#define ROD_NAME(name, text) text,
    static const char *const names[] = {ROD_RESIDUAL_LIST(ROD_NAME)};
#undef ROD_NAME
    return kind >= 0 && kind < ROD_RESIDUAL_COUNT ? names[kind] : "";
}

int rod_residual_rows(const scene *rod_scene, rod_residual_kind kind)
{
    rod_plane plane = rod_plane_of(rod_scene);
    int vector = rod_vector_rows(&plane), axial = rod_axial_rows(&plane);
    bool starts_soft = scene_is_dynamic(rod_scene) && rod_scene->initial_enforcement == SCENE_SOFT;
    switch (kind) {
    case ROD_STRAIN:
        return rod_has_strains(rod_scene) ? vector : 0;
    case ROD_CURVATURE:
        return rod_has_strains(rod_scene) ? axial : 0;
    case ROD_FORCE:
        return vector;
    case ROD_MOMENT:
        return axial;
    case ROD_TENDON:
        return rod_tendon_rows(rod_scene);
    case ROD_TWIST:
    case ROD_TORSION:
        return rod_scene->tube_count;
    case ROD_START:
        return rod_end_rows(rod_scene, 0);
    case ROD_END:
        return rod_end_rows(rod_scene, 1);
    case ROD_INITIAL:
        return starts_soft ? 2 * (vector + axial) : 0;
    case ROD_RESIDUAL_COUNT:
        break;
    }
    return 0;
}

ad_value rod_residual(const scene *rod_scene, rod_residual_kind kind, rod_state state,
                      const domain_place *at)
{
    rod_context rod = rod_context_of(rod_scene, at);
    if (rod_residual_rows(rod_scene, kind) == 0) {
        ad_tape_fail(at->tape, AD_BAD_ARGUMENT, "this scene has no residual '%s'",
                     rod_residual_name(kind));
        return ad_scalar(at->tape, 0);
    }
    switch (kind) {
    case ROD_STRAIN:
        return rod_vector_in_plane(&rod, rod_strain_residual(&rod, state));
    case ROD_CURVATURE:
        return rod_axial_in_plane(&rod, rod_curvature_residual(&rod, state));
    case ROD_FORCE:
    case ROD_MOMENT:
        return rod_balance_residual(&rod, kind == ROD_FORCE, state);
    case ROD_TENDON:
        return rod_tendon_residual(&rod, state);
    case ROD_TWIST:
    case ROD_TORSION:
        return rod_tube_residual(&rod, state, kind == ROD_TORSION);
    case ROD_START:
    case ROD_END:
        return rod_end_residual(&rod, state, kind == ROD_END);
    default:
        return rod_initial_residual(&rod, state);
    }
}

rod_observables rod_observe(const scene *rod_scene, rod_state state, const domain_place *at)
{
    rod_context rod = rod_context_of(rod_scene, at);
    const rod_scales *scale = &rod.scales;
    rod_kinematics k = rod_kinematics_of(&rod, state.position, state.rotation);
    ad_value force = ad_rotate_inverse(state.rotation, state.force);
    if (rod_scene->rod.growth.is_given) { /* by metres of the rod as it is written */
        const ad_value over = ad_reciprocal(rod_growth(&rod));
        k.strain = ad_mul(over, k.strain);
        k.curvature = ad_mul(over, k.curvature);
    }
    ad_value position = rod_position_to_world(&rod, state.position);
    ad_value velocity = rod_to_world(&rod, k.velocity);
    return (rod_observables){.position = ad_scale(position, scale->length),
                             .rotation = rod_rotation_to_world(&rod, state.rotation),
                             .strain = k.strain,
                             .curvature = ad_scale(k.curvature, 1 / scale->length),
                             .force = ad_scale(force, scale->force),
                             .moment = ad_scale(state.moment, scale->moment),
                             .velocity = ad_scale(velocity, scale->length / scale->time),
                             .angular_velocity = ad_scale(k.spin, 1 / scale->time),
                             .tubes = state.tubes};
}
