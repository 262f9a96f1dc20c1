/* Numbers within reach; and held ends against the initial state: where both are exact by
 * construction they must agree. */
#include "physics/rod/rod_internal.h"
#include "physics/scene/scene_field.h"

#include <math.h>

enum { MISMATCHES = 4 };

typedef struct rod_mismatch {
    const char *key, *what, *unit;
    double factor; /* to the unit */
    bool asked, is_rotation;
    ad_value rows; /* [3], a function of t alone */
} rod_mismatch;

/* End data minus initial state, in value and rate. */
static void rod_mismatches(const rod_context *rod, int end, rod_mismatch *list)
{
    rod_end_data data = rod_end_of(rod, end, rod->t);
    rod_initial_data initial = rod_initial_of(rod, ad_scalar(rod->tape, end));
    ad_value velocity = rod_time_derivative(rod, data.position, 1);
    ad_value spin = rod_rate(data.rotation, rod_time_derivative(rod, data.rotation, 1));
    double length = rod->scales.length, time = rod->scales.time;
    bool moves = data.hold.directions > 0, turns = data.holds_rotation;
    ad_value away = rod_hold_part(rod, &data.hold, ad_sub(data.position, initial.position));
    ad_value faster = rod_hold_part(rod, &data.hold, ad_sub(velocity, initial.velocity));
    list[0] = (rod_mismatch){"initial.position", "position", "m", length, moves, false, away};
    list[1] = (rod_mismatch){"initial.rotation",
                             "rotation",
                             "rad",
                             1,
                             turns,
                             true,
                             rod_rate(initial.rotation, data.rotation)};
    list[2] =
        (rod_mismatch){"initial.velocity", "velocity", "m/s", length / time, moves, false, faster};
    list[3] = (rod_mismatch){
        "initial.angular_velocity", "angular velocity", "1/s", 1 / time, turns, false,
        ad_sub(spin, initial.spin)};
}

/* sizes [MISMATCHES]: norm of each mismatch at t = 0. */
static ad_status rod_measure(const rod_mismatch *list, double *sizes, ad_error *error)
{
    ad_value values[MISMATCHES];
    double numbers[MISMATCHES][3] = {{0}}, zero = 0;
    double *outputs[MISMATCHES];
    for (int i = 0; i < MISMATCHES; i++) {
        values[i] = list[i].rows;
        outputs[i] = numbers[i];
    }
    const ad_run run = {
        .points = 1, .inputs = (const double *const[]){&zero, &zero}, .outputs = outputs};
    const ad_status status = ad_evaluate(MISMATCHES, values, NULL, &run, error);
    for (int i = 0; i < MISMATCHES; i++) {
        sizes[i] = hypot(hypot(numbers[i][0], numbers[i][1]), numbers[i][2]);
    }
    return status;
}

/* In SI. A rotation is measured as 2 |vec(q_i* q)| = 2 sin(angle/2), and told as the angle. */
static double rod_mismatch_told(const rod_mismatch *mismatch, double size)
{
    return mismatch->is_rotation ? 2 * asin(fmin(1, size / 2)) : size * mismatch->factor;
}

static ad_status rod_check_end(const scene *rod_scene, int end, const char **key, ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    ad_value s = ad_input(tape, "s", 1);
    const domain_place at = rod_place(rod_scene, s, ad_input(tape, "t", 1));
    rod_context rod = rod_context_of(rod_scene, &at);
    rod_mismatch list[MISMATCHES];
    double sizes[MISMATCHES] = {0};
    rod_mismatches(&rod, end, list);
    ad_status status = rod_measure(list, sizes, error);
    for (int i = 0; i < MISMATCHES && status == AD_OK; i++) {
        if (list[i].asked && !(sizes[i] <= ROD_MISMATCH)) {
            *key = list[i].key;
            status = ad_fail(error, AD_BAD_INPUT,
                             "at t = 0 the %s differs by %.3g %s from that of the %s; they must "
                             "agree, or the initial state be enforced softly",
                             list[i].what, rod_mismatch_told(&list[i], sizes[i]), list[i].unit,
                             end ? "held end" : "held start");
        }
    }
    ad_tape_free(tape);
    return status;
}

/* Dimensionless numbers beyond which the equations are no longer computed with any accuracy; each
 * with the key that is to blame. */
static ad_status rod_check_numbers(const scene *rod_scene, const char **key, ad_error *error)
{
    static const double large = 1e12, locked = 1e30;
    rod_numbers n = rod_numbers_of(rod_scene);
    bool at_base = scene_end_takes_force(rod_scene->start.type);
    const char *damped = rod_scene->rod.viscosity.is_given         ? "rod.material.viscosity"
                         : rod_scene->rod.relaxation_time.is_given ? "rod.material.relaxation_time"
                                                                   : NULL;
    bool heavy = quantity_any_something(3, rod_scene->loads.gravity);
    const struct {
        const char *key, *formula;
        double value, low, high;
    } rows[] = {
        {"rod.stiffness.shear", "kappa G A L^2/EI", n.shear_ratio, 1 / large, locked},
        {"rod.stiffness.axial", "E A L^2/EI", n.axial_ratio, 1 / large, locked},
        {"rod.stiffness.torsion", "G J/EI", n.torsion_ratio, 1 / large, locked},
        {at_base ? "loads.base.force" : "loads.tip.force", "F L^2/EI", n.tip_force, 0, large},
        {at_base ? "loads.base.moment" : "loads.tip.moment", "M L/EI", n.tip_moment, 0, large},
        {"loads.force", "f L^3/EI", n.distributed_force, 0, large},
        {"loads.moment", "l L^2/EI", n.distributed_moment, 0, large},
        {"loads.foundation", "k L^4/EI", n.foundation, 0, large},
        {"loads.gravity", "rhoA g L^3/EI", heavy ? n.weight : 0, 0, large},
        {rod_scene->point_count ? "loads.points" : "bodies", "F L^2/EI", n.point_force, 0, large},
        {"loads.points", "T L/EI", n.point_moment, 0, large},
        {scene_actuator_lists(rod_scene), "tension times offset L/EI", n.actuation, 0, large},
        {"tubes", "curvature times length", n.tubes, 0, large},
        {"rod.inertia.rotary", "rho I/(rhoA L^2)", n.rotary_inertia, 0, large},
        {damped ? damped : "rod.damping.strain", "Bse L^2/(EI T)", n.strain_damping, 0, large},
        {damped ? damped : "rod.damping.curvature", "damping of the first bending mode",
         n.curvature_damping, 0, large},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        bool fits = rows[i].value >= rows[i].low && rows[i].value <= rows[i].high;
        if (!fits && !(isinf(rows[i].value) && rows[i].high == locked)) {
            *key = rows[i].key;
            return ad_fail(error, AD_BAD_INPUT,
                           "%s is %.3g, beyond what can be computed with; allowed: %g to %g",
                           rows[i].formula, rows[i].value, rows[i].low, rows[i].high);
        }
    }
    return AD_OK;
}

static ad_status rod_check_resistance(const scene *rod_scene, const char **key, ad_error *error)
{
    static const double large = 1e12;
    rod_term terms[ROD_TERM_MAX];
    int count = rod_terms(rod_scene, terms);
    for (int i = 0; i < count; i++) {
        if (!(terms[i].damping <= large)) {
            *key = terms[i].key;
            return ad_fail(error, AD_BAD_INPUT,
                           "damping of the first bending mode is %.3g, beyond what can be computed "
                           "with; allowed: 0 to %g",
                           terms[i].damping, large);
        }
    }
    return AD_OK;
}

ad_status rod_check(const scene *rod_scene, const char **key, ad_error *error)
{
    bool implied = scene_is_dynamic(rod_scene) && !scene_is_manufactured(rod_scene) &&
                   !rod_scene->initial.position[0].is_given;
    bool both_exact = rod_scene->boundary_enforcement == SCENE_HARD &&
                      rod_scene->initial_enforcement == SCENE_HARD;
    const char *ignored = NULL;
    ad_status status = rod_check_numbers(rod_scene, key ? key : &ignored, error);
    if (status == AD_OK) {
        status = rod_check_resistance(rod_scene, key ? key : &ignored, error);
    }
    if (status != AD_OK) {
        return status;
    }
    rod_plane plane = rod_plane_of(rod_scene);
    if (rod_scene->motion == SCENE_PLANAR && !plane.is_planar) {
        *(key ? key : &ignored) = "motion";
        return ad_fail(error, AD_BAD_INPUT,
                       "is planar, but %s leaves the plane; allowed: automatic, spatial",
                       plane.leaves);
    }
    if (implied && !rod_shape_is_resolved(rod_scene)) {
        *(key ? key : &ignored) = "rod.rest.curvature";
        return ad_fail(
            error, AD_BAD_INPUT,
            "the unstressed shape winds too much, or bends too suddenly, to start from; give "
            "initial.position and initial.rotation");
    }
    if (!scene_is_dynamic(rod_scene) || scene_is_manufactured(rod_scene) || !both_exact) {
        return AD_OK;
    }
    for (int end = 0; end <= 1 && status == AD_OK; end++) {
        status = rod_check_end(rod_scene, end, key ? key : &ignored, error);
    }
    return status;
}
