/* Scales, formulas made dimensionless, and the numbers that decide how hard a scene is. */
#include "physics/numerics/constants.h"
#include "physics/rod/rod_internal.h"

#include <math.h>

/* First bending mode of a cantilever: angular frequency 3.516 / time (beta_1^2, 1.8751^2). */
static const double ROD_FIRST_MODE = 3.516015268523;

enum { ROD_TIME_SAMPLES = 64, ROD_SPACE_SAMPLES = 8 };

/* The smaller one: scene_check lets at most one of the two be infinite. */
static double rod_bending_stiffness(const scene *rod_scene, const scene_properties *properties)
{
    return fmin(scene_mean_stiffness(rod_scene, properties->curvature_stiffness[0]),
                scene_mean_stiffness(rod_scene, properties->curvature_stiffness[1]));
}

rod_scales rod_scales_of(const scene *rod_scene)
{
    scene_properties properties = scene_properties_of(rod_scene);
    double stiffness = rod_bending_stiffness(rod_scene, &properties);
    double length = scene_length(rod_scene);
    double mass = scene_mean(rod_scene, properties.mass_per_length);
    rod_scales scales = {.length = length,
                         .time = 1,
                         .force = stiffness / (length * length),
                         .moment = stiffness / length};
    if (scene_is_dynamic(rod_scene)) {
        scales.time = length * length * sqrt(mass / stiffness);
    }
    return scales;
}

ad_value rod_quantity(const rod_context *rod, quantity q, ad_value s, ad_value t)
{
    double number = 0;
    if (quantity_is_number(q, &number)) {
        return ad_scalar(rod->tape, number);
    }
    quantity_binding bindings[2 + SCENE_PARAMETERS_MAX] = {{"s", ad_scale(s, rod->scales.length)},
                                                           {"t", ad_scale(t, rod->scales.time)}};
    for (int i = 0; i < rod->parameter_count; i++) {
        bindings[2 + i] = rod->parameters[i];
    }
    return quantity_record(q, rod->tape, 2 + rod->parameter_count, bindings);
}

ad_value rod_growth(const rod_context *rod)
{
    const quantity growth = rod->scene->rod.growth;
    return growth.is_given ? rod_quantity(rod, growth, rod->s, rod->t) : ad_scalar(rod->tape, 1);
}

ad_value rod_quantities(const rod_context *rod, int count, const quantity *given,
                        const double *fallback, double factor, ad_value s, ad_value t)
{
    ad_value parts[4];
    for (int i = 0; i < count; i++) {
        parts[i] = given[i].is_given ? ad_scale(rod_quantity(rod, given[i], s, t), factor)
                                     : ad_scalar(rod->tape, fallback[i]);
    }
    return ad_stack(count, parts);
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* Largest norm of a vector over samples of arc length and time (SI). */
static double rod_largest(const scene *rod_scene, const quantity *given, int space_samples)
{
    if (!quantity_any_given(3, given)) {
        return 0;
    }
    int time_samples = scene_is_dynamic(rod_scene) ? ROD_TIME_SAMPLES : 0;
    double largest = 0;
    for (int i = 0; i <= space_samples; i++) {
        double s = space_samples ? scene_length(rod_scene) * i / space_samples : 0;
        for (int j = 0; j <= time_samples; j++) {
            double t = time_samples ? scene_duration(rod_scene) * j / time_samples : 0, square = 0;
            for (int k = 0; k < 3; k++) {
                double x = given[k].is_given ? quantity_largest(given[k], s, t) : 0;
                square += x * x;
            }
            largest = fmax(largest, sqrt(square));
        }
    }
    return largest;
}

static double rod_largest_end(const scene *rod_scene, const quantity *base, const quantity *tip)
{
    bool at_base = scene_end_takes_force(rod_scene->start.type);
    bool at_tip = scene_end_takes_force(rod_scene->end.type);
    return fmax(at_base ? rod_largest(rod_scene, base, 0) : 0,
                at_tip ? rod_largest(rod_scene, tip, 0) : 0);
}

/* What a dead force at the loaded end does along d3 = R(q) e3 of the other end at time t: along
 * d3 at s = 0 and against it at s = length it compresses. */
static double rod_compression_at(const scene *rod_scene, bool at_tip, double t)
{
    const scene_end *held = at_tip ? &rod_scene->start : &rod_scene->end;
    const quantity *force = at_tip ? rod_scene->loads.tip.force : rod_scene->loads.base.force;
    double q[4], f[3], square = 0;
    for (int i = 0; i < 4; i++) {
        q[i] = quantity_value(quantity_or(held->rotation[i], quantity_number(i == 0)), 0, t);
        square += q[i] * q[i];
    }
    for (int i = 0; i < 3; i++) {
        f[i] = quantity_value(quantity_or(force[i], quantity_number(0)), 0, t);
    }
    double pull = 2 * (q[1] * q[3] + q[0] * q[2]) * f[0] + 2 * (q[2] * q[3] - q[0] * q[1]) * f[1] +
                  (q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]) * f[2];
    return at_tip ? -pull / square : pull / square;
}

static double rod_compression(const scene *rod_scene)
{
    scene_end_type start = rod_scene->start.type, end = rod_scene->end.type;
    bool at_tip = scene_end_holds_rotation(start) && scene_end_takes_force(end);
    bool at_base = !at_tip && scene_end_holds_rotation(end) && scene_end_takes_force(start);
    const scene_load *load = at_tip ? &rod_scene->loads.tip : &rod_scene->loads.base;
    int samples = scene_is_dynamic(rod_scene) ? ROD_TIME_SAMPLES : 0;
    double largest = 0;
    if (!(at_tip || at_base) || load->frame != SCENE_DEAD || scene_is_manufactured(rod_scene)) {
        return 0;
    }
    for (int j = 0; j <= samples; j++) {
        double t = samples ? scene_duration(rod_scene) * j / samples : 0;
        largest = fmax(largest, rod_compression_at(rod_scene, at_tip, t));
    }
    return largest;
}

double rod_first_frequency(const scene *rod_scene)
{
    return ROD_FIRST_MODE / rod_scales_of(rod_scene).time;
}

static void rod_dynamic_numbers(const scene *rod_scene, const rod_scales *scale,
                                rod_numbers *numbers)
{
    scene_properties properties = scene_properties_of(rod_scene);
    double mass = scene_mean(rod_scene, properties.mass_per_length), length = scale->length;
    double stiffness = scale->moment * length, frequency = ROD_FIRST_MODE / scale->time;
    for (int i = 0; i < 3; i++) {
        double strain = scene_range_of(rod_scene, properties.strain_damping[i]).high /
                        (scale->force * scale->time);
        double curvature =
            scene_mean(rod_scene, properties.curvature_damping[i]) * frequency / (2 * stiffness);
        numbers->strain_damping = fmax(numbers->strain_damping, strain);
        if (i < 2) {
            numbers->curvature_damping = fmax(numbers->curvature_damping, curvature);
        }
    }
    double inertia = fmax(scene_mean(rod_scene, properties.rotary_inertia[0]),
                          scene_mean(rod_scene, properties.rotary_inertia[1]));
    numbers->rotary_inertia = inertia / (mass * length * length);
    numbers->duration = scene_duration(rod_scene) / scale->time;
    numbers->periods = numbers->duration * ROD_FIRST_MODE / (2 * PI);
}

/* ---- what acts at places --------------------------------------------------------------------- */

/* All point loads at once, and the weight of bodies. */
static void rod_point_numbers(const scene *rod_scene, const rod_scales *scale, rod_numbers *numbers)
{
    double gravity = rod_largest(rod_scene, rod_scene->loads.gravity, 0);
    for (int i = 0; i < rod_scene->point_count; i++) {
        const scene_load *load = &rod_scene->points[i].load;
        numbers->point_force += rod_largest(rod_scene, load->force, 0) / scale->force;
        numbers->point_moment += rod_largest(rod_scene, load->moment, 0) / scale->moment;
    }
    for (int i = 0; i < rod_scene->body_count; i++) {
        numbers->point_force += rod_scene->bodies[i].mass.number * gravity / scale->force;
    }
}

/* Largest distance from the axis between two places. */
static double rod_lever(const scene *rod_scene, const scene_actuator *actuator)
{
    double size[2];
    for (int i = 0; i < 2; i++) {
        scene_range range =
            scene_range_within(rod_scene, actuator->offset[i], actuator->from, actuator->to);
        size[i] = fmax(fabs(range.low), fabs(range.high));
    }
    return hypot(size[0], size[1]);
}

double rod_tendon_arm(const scene *rod_scene, int index)
{
    const scene_actuator tendon = scene_actuator_of(rod_scene, index);
    return fmax(rod_lever(rod_scene, &tendon) / scene_length(rod_scene), 1e-3);
}

static double rod_most(const scene *rod_scene, quantity q)
{
    scene_range range = scene_range_of(rod_scene, q);
    return fmax(fabs(range.low), fabs(range.high));
}

/* A tendon that is pulled by d at the distance h from the axis turns the end by d/h, as a moment
 * T L/EI of that size does. */
static double rod_actuation_moment(const scene *rod_scene, const rod_scales *scale)
{
    double sum = 0;
    for (int i = 0; i < scene_actuator_count(rod_scene); i++) {
        const scene_actuator one = scene_actuator_of(rod_scene, i);
        const double lever = rod_lever(rod_scene, &one);
        if (!one.tendon || one.tendon->tension.is_given) {
            sum += rod_most(rod_scene, scene_actuator_pull(&one)) * lever / scale->moment;
        } else if (lever > 0) {
            sum += rod_most(rod_scene, one.tendon->displacement) / lever;
        }
    }
    return sum;
}

/* By how much the rest curvature of tubes turns. */
static double rod_tube_turns(const scene *rod_scene)
{
    enum { SAMPLES = 64 };
    double sum = 0;
    for (int i = 0; i < rod_scene->tube_count; i++) {
        const quantity *rest = rod_scene->tubes[i].rod.rest_curvature;
        double largest = 0;
        for (int j = 0; j < SAMPLES; j++) {
            double s = scene_tube_end(rod_scene, i) * (j + 0.5) / SAMPLES, k[3];
            for (int c = 0; c < 3; c++) {
                k[c] = quantity_value(rest[c], s, 0);
            }
            largest = fmax(largest, hypot(hypot(k[0], k[1]), k[2]));
        }
        sum += largest * scene_tube_end(rod_scene, i);
    }
    return sum;
}

/* Mass per length that has weight: the mean, or in a fluid the largest size of what it carries. */
static double rod_heavy_mass(const scene *rod_scene, quantity mass)
{
    if (!quantity_is_something(rod_scene->loads.buoyancy)) {
        return scene_mean(rod_scene, mass);
    }
    const quantity net = quantity_subtract(mass, rod_scene->loads.buoyancy);
    const scene_range range = scene_range_of(rod_scene, net);
    return fmax(fabs(range.low), fabs(range.high));
}

rod_numbers rod_numbers_of(const scene *rod_scene)
{
    rod_scales scale = rod_scales_of(rod_scene);
    scene_properties properties = scene_properties_of(rod_scene);
    double mass = rod_heavy_mass(rod_scene, properties.mass_per_length), strain[3];
    for (int i = 0; i < rod_scene->tube_count; i++) {
        double end = scene_tube_end(rod_scene, i);
        quantity own = scene_tube_properties(&rod_scene->tubes[i]).mass_per_length;
        mass += quantity_value(own, end / 2, 0) * end / scale.length;
    }
    double pull = rod_largest(rod_scene, rod_scene->loads.gravity, 0);
    for (int i = 0; i < 3; i++) {
        strain[i] = scene_mean_stiffness(rod_scene, properties.strain_stiffness[i]);
    }
    rod_numbers numbers = {
        .shear_ratio = fmin(strain[0], strain[1]) / scale.force,
        .axial_ratio = strain[2] / scale.force,
        .torsion_ratio = scene_mean_stiffness(rod_scene, properties.curvature_stiffness[2]) /
                         (scale.moment * scale.length),
        .tip_force =
            rod_largest_end(rod_scene, rod_scene->loads.base.force, rod_scene->loads.tip.force) /
            scale.force,
        .tip_moment =
            rod_largest_end(rod_scene, rod_scene->loads.base.moment, rod_scene->loads.tip.moment) /
            scale.moment,
        .compression = rod_compression(rod_scene) / scale.force,
        .distributed_force = rod_largest(rod_scene, rod_scene->loads.force, ROD_SPACE_SAMPLES) *
                             scale.length / scale.force,
        .distributed_moment = rod_largest(rod_scene, rod_scene->loads.moment, ROD_SPACE_SAMPLES) *
                              scale.length / scale.moment,
        .foundation = rod_largest(rod_scene, rod_scene->loads.foundation, ROD_SPACE_SAMPLES) *
                      scale.length * scale.length / scale.force,
        .weight = mass * pull * scale.length / scale.force,
        .actuation = rod_actuation_moment(rod_scene, &scale),
        .tubes = rod_tube_turns(rod_scene)};
    rod_point_numbers(rod_scene, &scale, &numbers);
    if (scene_is_dynamic(rod_scene)) {
        rod_dynamic_numbers(rod_scene, &scale, &numbers);
    }
    return numbers;
}

/* Magnitude of the internal force, at least 1: what one network output stands for. */
double rod_force_scale(const scene *rod_scene)
{
    rod_numbers numbers = rod_numbers_of(rod_scene);
    double within = fmax(numbers.distributed_force + numbers.weight, numbers.point_force);
    return fmax(1, fmax(numbers.tip_force, within));
}

/* The same of the internal moment; forces act on levers of at most the length. Actuators
 * are in balance with the moment of the rod itself. */
double rod_moment_scale(const scene *rod_scene)
{
    rod_numbers numbers = rod_numbers_of(rod_scene);
    double lever = fmax(numbers.tip_force, 0.5 * (numbers.distributed_force + numbers.weight));
    double moment = fmax(numbers.tip_moment, numbers.distributed_moment);
    lever = fmax(lever, numbers.point_force);
    return fmax(fmax(1, lever), fmax(moment, numbers.point_moment));
}
