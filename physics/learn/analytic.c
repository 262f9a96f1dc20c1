#include "physics/learn/analytic.h"

#include "physics/numerics/quaternion.h"

#include <math.h>
#include <string.h>

static const double largest_alpha = 1e4;

/* ---- vectors and quaternions ---- */

static double norm(const double a[3])
{
    return hypot(hypot(a[0], a[1]), a[2]);
}

/* Rotation by `angle` about the unit `axis`. */
static void axis_quaternion(const double axis[3], double angle, double result[4])
{
    const double sine = sin(0.5 * angle);
    result[0] = cos(0.5 * angle);
    for (int i = 0; i < 3; i++) {
        result[1 + i] = sine * axis[i];
    }
}

/* Body to world: v + 2 w (q x v) + 2 q x (q x v). With `sign` -1 the inverse. */
static void rotate(const double q[4], double sign, const double v[3], double result[3])
{
    double first[3], second[3];
    vector_cross(q + 1, v, first);
    vector_cross(q + 1, first, second);
    for (int i = 0; i < 3; i++) {
        result[i] = v[i] + 2.0 * (sign * q[0] * first[i] + second[i]);
    }
}

static ad_status check_clamp(const analytic_clamp *clamp, ad_error *error)
{
    double squares = 0;
    for (int i = 0; i < 4; i++) {
        squares += clamp->quaternion[i] * clamp->quaternion[i];
    }
    if (!(fabs(squares - 1.0) <= 2e-12)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "quaternion of the clamp has norm %.15g, not 1",
                       sqrt(squares));
    }
    return AD_OK;
}

static ad_status check_positive(const char *name, double value, ad_error *error)
{
    if (!(value > 0.0 && value <= 1e300)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%s is %g; it must be positive", name, value);
    }
    return AD_OK;
}

/* The load must be finite and perpendicular to the clamped tangent; *tangent receives d3(0). */
static ad_status check_transverse(const char *name, const analytic_clamp *clamp,
                                  const double load[3], double tangent[3], ad_error *error)
{
    static const double e3[3] = {0, 0, 1};
    rotate(clamp->quaternion, 1.0, e3, tangent);
    const double size = norm(load), axial = vector_dot(load, tangent);
    if (!isfinite(size) || fabs(axial) > 1e-12 * size) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%s of size %g has a part %g along the clamped tangent; it must have none",
                       name, size, axial);
    }
    return AD_OK;
}

/* ---- elastica ---- */

/* sc(w) = sn(w)/cn(w) of modulus k at w = far and w = near, and their difference, each to full
 * relative accuracy; 0 <= near <= far < K(k), difference = far - near given exactly. */
typedef struct sc_pair {
    double far, near, difference;
} sc_pair;

/* sc(w, k) = -i sn(iw, k') (DLMF 22.6(iv)), so descending Landen steps in k' (DLMF 22.7.2)
 * lead to sinh. All terms of the way back are positive: X -> (1 + k1) X / (1 - k1 X^2). The first
 * step is never left out: near K(k) the function is of order 1/k', so k1 X^2 is of order 1. `far`
 * comes back infinite when w = far is beyond K(k). */
static sc_pair sc_functions(double far, double near, double difference, double modulus,
                            double complement)
{
    double small[8]; /* k' after each step; quadratic, from at most 1/sqrt(2) to nothing in 5 */
    int steps = 0;
    do {
        /* (1 - k)/(1 + k) = k'^2/(1 + k)^2 without the difference. */
        const double root = complement / (1.0 + modulus);
        small[steps] = root * root;
        const double scale = 1.0 + small[steps];
        far /= scale;
        near /= scale;
        difference /= scale;
        complement = small[steps++];
        modulus = sqrt((1.0 - complement) * (1.0 + complement));
    } while (complement > 1e-20 && steps < 8);
    sc_pair sc = {sinh(far), sinh(near), 0.0};
    /* sinh(far) - sinh(near), tied to the very sinh(far) above: rounding of a large far cancels. */
    sc.difference = difference < 1.0
                        ? sinh(difference) * (cosh(far) - sc.far * tanh(0.5 * difference))
                        : sc.far - sc.near;
    while (steps-- > 0) {
        const double k1 = small[steps];
        const double below_far = 1.0 - k1 * sc.far * sc.far;
        const double below_near = 1.0 - k1 * sc.near * sc.near;
        if (!(below_far > 0.0)) {
            return (sc_pair){INFINITY, INFINITY, INFINITY};
        }
        sc.difference *= (1.0 + k1) * (1.0 + k1 * sc.far * sc.near) / (below_far * below_near);
        sc.far *= (1.0 + k1) / below_far;
        sc.near *= (1.0 + k1) / below_near;
    }
    return sc;
}

/* (k'/k) nc(w, k) - 1, which rises with k' and is 0 at the wanted modulus. */
static double modulus_residual(double root_alpha, double complement)
{
    const double modulus = sqrt((1.0 - complement) * (1.0 + complement));
    const sc_pair sc = sc_functions(root_alpha, 0.0, root_alpha, modulus, complement);
    return complement / modulus * hypot(1.0, sc.far) - 1.0;
}

/* cn <= sech gives the upper end of the bracket; the root over that end falls from 1 (alpha = 0) to
 * 2/(1 + sqrt 2) = 0.828 (alpha = infinity), so 0.8 times it is a lower end. Regula falsi with
 * the Illinois rule, between the ends of the bracket at all times. */
static double solve_complement(double root_alpha)
{
    double high = 1.0 / hypot(1.0, cosh(root_alpha)), low = 0.8 * high;
    double residual_high = modulus_residual(root_alpha, high);
    double residual_low = modulus_residual(root_alpha, low);
    if (residual_high <= 0.0) {
        return high; /* alpha below rounding */
    }
    double complement = high;
    for (int step = 0, side = 0; step < 60; step++) {
        const double share = residual_high / (residual_high - residual_low);
        const double next = high - (high - low) * share;
        if (next == complement) {
            break;
        }
        complement = next;
        const double residual = modulus_residual(root_alpha, complement);
        if (residual == 0.0) {
            break;
        }
        if (residual > 0.0) {
            high = complement;
            residual_high = residual;
            residual_low *= side > 0 ? 0.5 : 1.0;
            side = 1;
        } else {
            low = complement;
            residual_low = residual;
            residual_high *= side < 0 ? 0.5 : 1.0;
            side = -1;
        }
    }
    return complement;
}

ad_status analytic_elastica_create(const analytic_clamp *clamp, double length,
                                   double bending_stiffness, const double force[3],
                                   analytic_elastica *elastica, ad_error *error)
{
    double tangent[3];
    ad_status status = check_clamp(clamp, error);
    status = status ? status : check_positive("length", length, error);
    status = status ? status : check_positive("bending stiffness", bending_stiffness, error);
    status = status ? status : check_transverse("tip force", clamp, force, tangent, error);
    if (status != AD_OK) {
        return status;
    }
    const double size = norm(force);
    const double alpha = size * length * length / bending_stiffness;
    if (!(alpha <= largest_alpha)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "tip load F L^2/EI is %g; allowed: 0 to %g", alpha,
                       largest_alpha);
    }
    *elastica = (analytic_elastica){
        .clamp = *clamp, .length = length, .bending_stiffness = bending_stiffness, .alpha = alpha};
    memcpy(elastica->force, force, sizeof elastica->force);
    if (size > 0.0) {
        const double direction[3] = {force[0] / size, force[1] / size, force[2] / size};
        vector_cross(tangent, direction, elastica->axis);
    }
    rotate(clamp->quaternion, -1.0, elastica->axis, elastica->body_axis);
    elastica->complement = solve_complement(sqrt(alpha));
    elastica->modulus = sqrt((1.0 - elastica->complement) * (1.0 + elastica->complement));
    return AD_OK;
}

/* Everything at distance `travel` = sqrt(alpha) s/L from the clamp. */
typedef struct elastica_point {
    double angle;   /* theta */
    double along;   /* sqrt(alpha) x/L */
    double bending; /* kappa L / sqrt(alpha) */
} elastica_point;

/* Differences from the clamp, where tan(psi/2) = 1, are formed from sc(far) - sc(near), so that a
 * small angle or a small x keeps its relative accuracy. */
static elastica_point elastica_functions(const analytic_elastica *elastica, double travel)
{
    const double far = sqrt(elastica->alpha), near = fmax(far - travel, 0.0);
    const double k = elastica->modulus, complement = elastica->complement;
    const double m1 = complement * complement;
    const sc_pair sc = sc_functions(far, near, travel, k, complement);
    const double rise = sc.difference * (sc.far + sc.near); /* sc^2(far) - sc^2(near) */

    const double nc_far = hypot(1.0, sc.far), nc_near = hypot(1.0, sc.near);
    const double half = complement / k * nc_near; /* tan(psi/2) */
    const double gap = complement / k * rise / (nc_far + nc_near);

    const double dc_far = hypot(1.0, complement * sc.far);
    const double dc_near = hypot(1.0, complement * sc.near);
    const double sd_far = sc.far / dc_far, sd_near = sc.near / dc_near;
    const double dc_squares = (1.0 + m1 * sc.far * sc.far) * (1.0 + m1 * sc.near * sc.near);
    const double sd_difference = rise > 0.0 ? rise / (dc_squares * (sd_far + sd_near)) : 0.0;
    return (elastica_point){.angle = 2.0 * atan(gap / (1.0 + half)),
                            .along = 2.0 * k * complement * sd_difference,
                            .bending = 2.0 * k * complement * sd_near};
}

/* Nodes and weights of 16-point Gauss-Legendre quadrature on [-1, 1], positive half. */
static const double gauss_node[8] = {
    0.0950125098376374402, 0.281603550779258913, 0.458016777657227386, 0.617876244402643748,
    0.755404408355003034,  0.865631202387831744, 0.944575023073232576, 0.989400934991649933};
static const double gauss_weight[8] = {
    0.189450610455068496, 0.182603415044923589,  0.169156519395002538,  0.149595988816576732,
    0.124628971255533872, 0.0951585116824927848, 0.0622535239386478929, 0.0271524594117540949};

/* sqrt(alpha) y/L. The nearest poles of sin theta lie 0.88 beyond the clamp and K' >= pi/2 off the
 * real axis; on panels no longer than 2 the rule's error is below 4.7^-32 = 1e-21 of sin theta. */
static double elastica_across(const analytic_elastica *elastica, double travel)
{
    const int panels = (int)ceil(0.5 * travel) > 1 ? (int)ceil(0.5 * travel) : 1;
    const double half_width = 0.5 * travel / panels;
    double sum = 0;
    for (int panel = panels; panel-- > 0;) {
        const double middle = (2 * panel + 1) * half_width;
        for (int i = 0; i < 8; i++) {
            const double offset = half_width * gauss_node[i];
            sum += gauss_weight[i] * (sin(elastica_functions(elastica, middle - offset).angle) +
                                      sin(elastica_functions(elastica, middle + offset).angle));
        }
    }
    return sum * half_width;
}

analytic_planar analytic_elastica_shape(const analytic_elastica *elastica, double s)
{
    const double fraction = fmin(fmax(s / elastica->length, 0.0), 1.0);
    const double root_alpha = sqrt(elastica->alpha);
    if (!(root_alpha > 0.0)) {
        return (analytic_planar){.along = fraction * elastica->length};
    }
    const double travel = fraction * root_alpha;
    const elastica_point point = elastica_functions(elastica, travel);
    const double unit = elastica->length / root_alpha;
    return (analytic_planar){.angle = point.angle,
                             .along = point.along * unit,
                             .across = elastica_across(elastica, travel) * unit,
                             .curvature = point.bending / unit};
}

void analytic_elastica_at(const analytic_elastica *elastica, double s, analytic_state *state)
{
    static const double e3[3] = {0, 0, 1};
    const analytic_planar shape = analytic_elastica_shape(elastica, s);
    double tangent[3], across[3], turn[4];
    rotate(elastica->clamp.quaternion, 1.0, e3, tangent);
    vector_cross(elastica->axis, tangent, across);
    axis_quaternion(elastica->axis, shape.angle, turn);
    quaternion_product(turn, elastica->clamp.quaternion, state->quaternion);
    for (int i = 0; i < 3; i++) {
        state->position[i] =
            elastica->clamp.position[i] + shape.along * tangent[i] + shape.across * across[i];
        state->force[i] = elastica->force[i];
        state->moment[i] = elastica->bending_stiffness * shape.curvature * elastica->body_axis[i];
    }
}

/* ---- helix and circle ---- */

/* State after turning by rate s about the unit `axis` and by `twist` about d3; |M| = size. */
static void precess(const analytic_clamp *clamp, const double axis[3], double size, double rate,
                    double twist, double s, analytic_state *state)
{
    static const double e3[3] = {0, 0, 1};
    double tangent[3], sideways[3], turn[4], spin[4], half[4];
    rotate(clamp->quaternion, 1.0, e3, tangent);
    vector_cross(axis, tangent, sideways);
    const double angle = rate * s, axial = vector_dot(axis, tangent);
    const double swept = angle != 0.0 ? s * (sin(angle) / angle) : s;
    const double lifted = angle != 0.0 ? s * (sin(0.5 * angle) * sin(0.5 * angle) / (0.5 * angle))
                                       : 0.0; /* s (1 - cos)/angle */
    axis_quaternion(axis, angle, turn);
    axis_quaternion(e3, twist, spin);
    quaternion_product(turn, clamp->quaternion, half);
    quaternion_product(half, spin, state->quaternion);
    double body_axis[3];
    rotate(state->quaternion, -1.0, axis, body_axis);
    for (int i = 0; i < 3; i++) {
        const double along = axial * axis[i];
        state->position[i] =
            clamp->position[i] + s * along + swept * (tangent[i] - along) + lifted * sideways[i];
        state->force[i] = 0.0;
        state->moment[i] = size * body_axis[i];
    }
}

static ad_status check_helix(const analytic_clamp *clamp, double bending_stiffness,
                             const double couple[3], double s, ad_error *error)
{
    ad_status status = check_clamp(clamp, error);
    status = status ? status : check_positive("bending stiffness", bending_stiffness, error);
    if (status == AD_OK && !(isfinite(norm(couple)) && isfinite(s))) {
        return ad_fail(error, AD_BAD_ARGUMENT, "tip couple and s must be finite");
    }
    return status;
}

/* Unit vector along the couple; any will do when there is none. Returns the couple's size. */
static double couple_axis(const double couple[3], double axis[3])
{
    const double size = norm(couple);
    for (int i = 0; i < 3; i++) {
        axis[i] = size > 0.0 ? couple[i] / size : (i == 0);
    }
    return size;
}

ad_status analytic_helix_at(const analytic_clamp *clamp, double bending_stiffness,
                            double torsional_stiffness, const double couple[3], double s,
                            analytic_state *state, ad_error *error)
{
    static const double e3[3] = {0, 0, 1};
    ad_status status = check_helix(clamp, bending_stiffness, couple, s, error);
    status = status ? status : check_positive("torsional stiffness", torsional_stiffness, error);
    if (status != AD_OK) {
        return status;
    }
    double axis[3], tangent[3];
    const double size = couple_axis(couple, axis);
    rotate(clamp->quaternion, 1.0, e3, tangent);
    const double twist = size * vector_dot(axis, tangent) * s *
                         (1.0 / torsional_stiffness - 1.0 / bending_stiffness);
    precess(clamp, axis, size, size / bending_stiffness, twist, s, state);
    return AD_OK;
}

ad_status analytic_rollup_at(const analytic_clamp *clamp, double bending_stiffness,
                             const double couple[3], double s, analytic_state *state,
                             ad_error *error)
{
    double axis[3], tangent[3];
    ad_status status = check_helix(clamp, bending_stiffness, couple, s, error);
    status = status ? status : check_transverse("tip couple", clamp, couple, tangent, error);
    if (status != AD_OK) {
        return status;
    }
    const double size = couple_axis(couple, axis);
    precess(clamp, axis, size, size / bending_stiffness, 0.0, s, state);
    return AD_OK;
}
