/* Kinematics, constitutive law and balance laws: each equation once, in full. */
#include "physics/rod/rod_internal.h"

#include <math.h>

/* ---- coefficients of the equations ----------------------------------------------------------- */

/* What becomes of a quantity in SI when it is counted in units: as a number and on the tape. */
typedef struct rod_ratio {
    double (*number)(double x, double unit);
    ad_value (*record)(ad_value x, double unit);
} rod_ratio;

static double rod_divide(double x, double unit)
{
    return x / unit;
}

static ad_value rod_record_divide(ad_value x, double unit)
{
    return ad_scale(x, 1 / unit);
}

/* 0 for a locked strain. */
static double rod_stiffness(double x, double unit)
{
    return isfinite(x) ? x / unit : 0;
}

static double rod_compliance(double x, double unit)
{
    return isfinite(x) ? unit / x : 0;
}

static ad_value rod_record_compliance(ad_value x, double unit)
{
    return ad_scale(ad_reciprocal(x), unit);
}

static const rod_ratio ROD_DIVIDE = {rod_divide, rod_record_divide};
static const rod_ratio ROD_COMPLIANCE = {rod_compliance, rod_record_compliance};

static ad_value rod_record_ratio(const rod_context *rod, rod_ratio ratio, quantity q, double unit)
{
    double number = 0;
    if (quantity_is_number(q, &number)) {
        return ad_scalar(rod->tape, ratio.number(number, unit));
    }
    return ratio.record(rod_quantity(rod, q, rod->s, rod->t), unit);
}

/* A stiffness that is infinite in some segments is 0 there, as one that is so all along. */
static ad_value rod_record_stiffness(ad_value x, double unit)
{
    static const double beyond = 1e300;
    ad_value excess = ad_sub(x, ad_scalar(x.tape, beyond));
    return ad_select(excess, ad_scalar(x.tape, 0), rod_record_divide(x, unit));
}

/* [3] */
static ad_value rod_ratios(const rod_context *rod, rod_ratio ratio, const quantity *q, double unit)
{
    ad_value rows[3];
    double x[3];
    if (quantity_is_number(q[0], &x[0]) && quantity_is_number(q[1], &x[1]) &&
        quantity_is_number(q[2], &x[2])) {
        return ad_vector_constant(rod->tape, ratio.number(x[0], unit), ratio.number(x[1], unit),
                                  ratio.number(x[2], unit));
    }
    for (int i = 0; i < 3; i++) {
        rows[i] = rod_record_ratio(rod, ratio, q[i], unit);
    }
    return ad_stack(3, rows);
}

/* u* of the equations. The imperfection is no part of the unloaded shape from which the ansatz
 * starts: parameters mean the same for every load factor. */
static ad_value rod_rest_curvature(const rod_context *rod, const scene_rest *given)
{
    double length = rod->scales.length;
    ad_value rest = rod_quantities(rod, 3, given->curvature, NULL, length, rod->s, rod->t);
    ad_value missing = ad_sub(ad_scalar(rod->tape, 1), rod->at.load_factor);
    ad_value bent = rod_quantities(rod, 3, given->imperfection, NULL, length, rod->s, rod->t);
    return ad_add(rest, ad_mul(missing, bent));
}

/* rhoA over its mean, by the choice of the time. */
static ad_value rod_mass(const rod_context *rod)
{
    quantity mass = rod->properties.mass_per_length;
    return !rod->dynamic || quantity_is_number(mass, NULL)
               ? ad_scalar(rod->tape, rod->dynamic)
               : rod_record_ratio(rod, ROD_DIVIDE, mass, scene_mean(rod->scene, mass));
}

rod_coefficients rod_coefficients_of(const rod_context *rod)
{
    const scene *given = rod->scene;
    const scene_properties *properties = &rod->properties;
    const rod_scales *scale = &rod->scales;
    double length = scale->length, force = scale->force, bending = scale->moment * length;
    double rate = rod->dynamic ? 1 / scale->time : 0; /* 0: what needs time is absent */
    quantity inertia[3], strain_damping[3], curvature_damping[3];
    for (int i = 0; i < 3; i++) {
        inertia[i] = quantity_scale(quantity_scale(properties->rotary_inertia[i], rate), rate);
        strain_damping[i] = quantity_scale(properties->strain_damping[i], rate);
        curvature_damping[i] = quantity_divide(
            quantity_scale(properties->curvature_damping[i], rate), quantity_number(length));
    }
    const quantity maxwell[] = {
        properties->maxwell_ratio,
        quantity_scale(properties->maxwell_rate, rod->dynamic ? scale->time : 0)};
    const scene_rest rest = scene_rest_of(given);
    const rod_ratio stiffness = scene_locks_somewhere(given)
                                    ? (rod_ratio){rod_stiffness, rod_record_stiffness}
                                    : (rod_ratio){rod_stiffness, rod_record_divide};
    return (rod_coefficients){
        .strain_compliance = rod_ratios(rod, ROD_COMPLIANCE, properties->strain_stiffness, force),
        .curvature_compliance =
            rod_ratios(rod, ROD_COMPLIANCE, properties->curvature_stiffness, bending),
        .strain_stiffness = rod_ratios(rod, stiffness, properties->strain_stiffness, force),
        .curvature_stiffness = rod_ratios(rod, stiffness, properties->curvature_stiffness, bending),
        .strain_damping = rod_ratios(rod, ROD_DIVIDE, strain_damping, force),
        .curvature_damping = rod_ratios(rod, ROD_DIVIDE, curvature_damping, scale->moment),
        .maxwell = rod_quantities(rod, 2, maxwell, NULL, 1, rod->s, rod->t),
        .mass = rod_mass(rod),
        .rotary_inertia = rod_ratios(rod, ROD_DIVIDE, inertia, force),
        .added_mass = rod_record_ratio(
            rod, ROD_DIVIDE, quantity_scale(quantity_scale(given->loads.added_mass, rate), rate),
            force / (length * length)),
        .rest_strain = rod_quantities(rod, 3, rest.strain, NULL, 1, rod->s, rod->t),
        .rest_curvature = rod_rest_curvature(rod, &rest)};
}

/* ---- the equations -------------------------------------------------------------------------- */

ad_value rod_space_derivative(const rod_context *rod, ad_value y)
{
    return ad_derivative(y, rod->s, 1);
}

/* Without time the derivative is a constant 0, which then removes what it multiplies. */
ad_value rod_time_derivative(const rod_context *rod, ad_value y, int order)
{
    return rod->dynamic ? ad_derivative(y, rod->t, order) : ad_zeros(rod->tape, ad_rows(y));
}

/* Body-frame rate 2 vec(q* dq) of a unit quaternion; of the second derivative it is the rate's
 * derivative, because vec(dq* dq) = 0. */
ad_value rod_rate(ad_value rotation, ad_value derivative)
{
    ad_value product = ad_quaternion_multiply(ad_quaternion_conjugate(rotation), derivative);
    return ad_scale(ad_slice(product, 1, 3), 2);
}

rod_kinematics rod_kinematics_of(const rod_context *rod, ad_value position, ad_value rotation)
{
    rod_kinematics k;
    k.strain = ad_rotate_inverse(rotation, rod_space_derivative(rod, position));
    k.curvature = rod_rate(rotation, rod_space_derivative(rod, rotation));
    k.strain_rate = rod_time_derivative(rod, k.strain, 1);
    k.curvature_rate = rod_time_derivative(rod, k.curvature, 1);
    k.velocity = rod_time_derivative(rod, position, 1);
    k.acceleration = rod_time_derivative(rod, position, 2);
    k.spin = rod_rate(rotation, rod_time_derivative(rod, rotation, 1));
    k.spin_rate = rod_rate(rotation, rod_time_derivative(rod, rotation, 2));
    return k;
}

rod_wrench rod_resistance(const rod_context *rod, law_name law, ad_value rotation,
                          const rod_kinematics *k, ad_value numbers)
{
    const ad_value motion[5] = {ad_rotate_inverse(rotation, k->velocity), k->spin,
                                ad_rotate_inverse(rotation, k->acceleration), k->spin_rate,
                                numbers};
    const ad_value all = ad_stack(5, motion);
    ad_value given[LAW_GIVEN_MAX], wrench[LAW_WRENCH];
    for (int i = 0; i < law_given(law); i++) {
        given[i] = ad_row(all, i);
    }
    law_record(law, rod->tape, given, NULL, wrench, NULL);
    const ad_value force = ad_rotate(rotation, ad_stack(3, wrench));
    return (rod_wrench){rod_keep_in_plane(rod, force, false),
                        rod_keep_in_plane(rod, ad_stack(3, wrench + 3), true)};
}

/* Force and moment of all laws outside of the rod. */
static rod_wrench rod_outside(const rod_context *rod, const rod_state *state,
                              const rod_kinematics *k)
{
    rod_acting acting[ROD_ALONG_MAX];
    rod_wrench sum = {ad_zeros(rod->tape, 3), ad_zeros(rod->tape, 3)};
    const int count = rod_acting_along(rod, acting);
    for (int i = 0; i < count; i++) {
        const rod_pose pose = {state->position, state->rotation};
        sum = rod_wrench_add(sum, rod_acting_wrench(rod, &acting[i], pose, k->velocity));
    }
    if (rod->dynamic && quantity_is_something(rod->scene->loads.added_mass)) {
        sum = rod_wrench_add(sum, rod_resistance(rod, LAW_ADDED_MASS, state->rotation, k,
                                                 rod_coefficients_of(rod).added_mass));
    }
    return sum;
}

/* N_s + f - rhoA r_tt, world; f of all laws outside. */
ad_value rod_force_balance(const rod_context *rod, rod_state state)
{
    rod_coefficients c = rod_coefficients_of(rod);
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    ad_value outside = rod_outside(rod, &state, &k).force;
    ad_value inertia = ad_mul(c.mass, k.acceleration);
    return ad_sub(ad_add(rod_space_derivative(rod, state.force), outside), inertia);
}

/* m_s + u x m + R^T (r_s x N + l) - rhoJ w_t - w x (rhoJ w), body; R^T (r_s x N) = v x R^T N.
 * u and v are the kinematic ones, 2 vec(q* q_s) and R^T r_s: first derivatives of the unknowns,
 * the same for both forms, and untouched by damping and locked strains, where the constitutive
 * law would bring in u_t and v_t. */
ad_value rod_moment_balance(const rod_context *rod, rod_state state)
{
    rod_coefficients c = rod_coefficients_of(rod);
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    ad_value force = ad_rotate_inverse(state.rotation, state.force);
    ad_value bending = ad_add(ad_cross(k.curvature, state.moment), ad_cross(k.strain, force));
    ad_value outside = rod_outside(rod, &state, &k).moment;
    ad_value gyroscopic = ad_cross(k.spin, ad_mul(c.rotary_inertia, k.spin));
    ad_value inertia = ad_add(ad_mul(c.rotary_inertia, k.spin_rate), gyroscopic);
    ad_value internal = ad_add(rod_space_derivative(rod, state.moment), bending);
    return ad_sub(ad_add(internal, outside), inertia);
}
