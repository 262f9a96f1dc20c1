/* Kinematics, constitutive law and balance laws: each equation once, in full. */
#include "physics/rod_internal.h"

#include <math.h>

/* ---- constants of the equations -------------------------------------------------------------- */

typedef double rod_ratio(double x, double unit);

static double rod_divide(double x, double unit)
{
    return x / unit;
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

static ad_value rod_constants(const rod_context *rod, rod_ratio *ratio, const double *x,
                              double unit)
{
    return ad_vector_constant(rod->tape, ratio(x[0], unit), ratio(x[1], unit), ratio(x[2], unit));
}

/* u* of the equations. The imperfection is no part of the unloaded shape from which the ansatz
 * starts: parameters mean the same for every load factor. */
static ad_value rod_rest_curvature(const rod_context *rod)
{
    const double none[3] = {0, 0, 0};
    const scene_rod *given = &rod->scene->rod;
    double length = rod->scales.length;
    ad_value zero = ad_scalar(rod->tape, 0);
    ad_value rest = rod_expressions(rod, 3, given->rest_curvature, none, length, rod->s, zero);
    ad_value missing = ad_sub(ad_scalar(rod->tape, 1), rod->at.load_factor);
    ad_value bent = rod_expressions(rod, 3, given->imperfection, none, length, rod->s, zero);
    return ad_add(rest, ad_mul(missing, bent));
}

rod_coefficients rod_coefficients_of(const rod_context *rod)
{
    const scene *rod_scene = rod->scene;
    const rod_scales *scale = &rod->scales;
    double length = scale->length, force = scale->force, moment = scale->moment;
    double rate = rod->dynamic ? 1 / scale->time : 0; /* 0: what needs time is absent */
    double mass = rod->properties.mass_per_length;
    double inertia[3], strain_damping[3], curvature_damping[3], weight[3];
    for (int i = 0; i < 3; i++) {
        inertia[i] = rod->properties.rotary_inertia[i] * rate * rate;
        strain_damping[i] = rod_scene->rod.strain_damping[i] * rate;
        curvature_damping[i] = rod_scene->rod.curvature_damping[i] * rate / length;
        weight[i] = mass * rod_scene->loads.gravity[i] * length;
    }
    const double straight[3] = {0, 0, 1};
    ad_value zero = ad_scalar(rod->tape, 0);
    return (rod_coefficients){
        .strain_compliance =
            rod_constants(rod, rod_compliance, rod->properties.strain_stiffness, force),
        .curvature_compliance = rod_constants(rod, rod_compliance,
                                              rod->properties.curvature_stiffness, moment * length),
        .strain_stiffness =
            rod_constants(rod, rod_stiffness, rod->properties.strain_stiffness, force),
        .curvature_stiffness =
            rod_constants(rod, rod_stiffness, rod->properties.curvature_stiffness, moment * length),
        .strain_damping = rod_constants(rod, rod_divide, strain_damping, force),
        .curvature_damping = rod_constants(rod, rod_divide, curvature_damping, moment),
        .mass = ad_scalar(rod->tape, rod->dynamic), /* by the choice of the time */
        .rotary_inertia = rod_constants(rod, rod_divide, inertia, force),
        .weight = ad_mul(rod->at.load_factor,
                         rod_from_world(rod, rod_constants(rod, rod_divide, weight, force))),
        .drag = ad_scalar(rod->tape, rod_scene->loads.drag * length * length * rate / force),
        .rest_strain =
            rod_expressions(rod, 3, rod_scene->rod.rest_strain, straight, 1, rod->s, zero),
        .rest_curvature = rod_rest_curvature(rod)};
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

/* n = Kse (v - v*) + Bse v_t,  m = Kbt (u - u*) + Bbt u_t  (Kelvin-Voigt). */
rod_wrench rod_constitutive(const rod_context *rod, const rod_kinematics *k)
{
    rod_coefficients c = rod_coefficients_of(rod);
    return (rod_wrench){
        .force = ad_add(ad_mul(c.strain_stiffness, ad_sub(k->strain, c.rest_strain)),
                        ad_mul(c.strain_damping, k->strain_rate)),
        .moment = ad_add(ad_mul(c.curvature_stiffness, ad_sub(k->curvature, c.rest_curvature)),
                         ad_mul(c.curvature_damping, k->curvature_rate))};
}

typedef ad_value rod_conversion(const rod_context *rod, ad_value vector);

/* The scene's distributed force, moment (expressions of s, t), from the rod's or the world's frame
 * to that of the equations. */
static ad_value rod_distributed(const rod_context *rod, const char *const *text, double unit,
                                ad_value rotation, rod_conversion *from_world)
{
    const double none[3] = {0, 0, 0};
    ad_value load =
        ad_mul(rod->at.load_factor, rod_expressions(rod, 3, text, none, 1 / unit, rod->s, rod->t));
    if (ad_is_constant(load, 0)) {
        return load;
    }
    bool follower = rod->scene->loads.frame == SCENE_FOLLOWER;
    return follower ? ad_rotate(rotation, load) : from_world(rod, load);
}

/* N_s + f - rhoA r_tt, world; f: distributed force, gravity, drag. */
ad_value rod_force_balance(const rod_context *rod, rod_state state)
{
    rod_coefficients c = rod_coefficients_of(rod);
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    ad_value load =
        rod_distributed(rod, rod->scene->loads.force, rod->scales.force / rod->scales.length,
                        state.rotation, rod_from_world);
    ad_value drag = ad_mul(c.drag, k.velocity);
    ad_value outside = ad_sub(ad_add(load, c.weight), drag);
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
    ad_value load =
        rod_distributed(rod, rod->scene->loads.moment, rod->scales.moment / rod->scales.length,
                        state.rotation, rod_axial_from_world);
    ad_value force = ad_rotate_inverse(state.rotation, state.force);
    ad_value bending = ad_add(ad_cross(k.curvature, state.moment), ad_cross(k.strain, force));
    ad_value outside = ad_is_constant(load, 0) ? load : ad_rotate_inverse(state.rotation, load);
    ad_value gyroscopic = ad_cross(k.spin, ad_mul(c.rotary_inertia, k.spin));
    ad_value inertia = ad_add(ad_mul(c.rotary_inertia, k.spin_rate), gyroscopic);
    ad_value internal = ad_add(rod_space_derivative(rod, state.moment), bending);
    return ad_sub(ad_add(internal, outside), inertia);
}
