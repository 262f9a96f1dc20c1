#include "physics/scene_field.h"

#include <stddef.h>

#define ROW(key, count, field, ...)                                                                \
    {                                                                                              \
        key, count, offsetof(scene, field), __VA_ARGS__                                            \
    }
#define NUMBER(key, field, ...) ROW(key, 1, field, __VA_ARGS__, SCENE_SCALAR, SCENE_WORLD)
#define OF_ROD(key, count, field, bounds)                                                          \
    ROW(key, count, rod.field, SCENE_OF_ROD, SCENE_ALONG, bounds, SCENE_SCALAR, SCENE_WORLD)
#define OF_BEAM(key, field, rule, bounds) NUMBER(key, beam.field, SCENE_OF_BEAM, rule, bounds)

const scene_field scene_fields[] = {
    NUMBER("rod.length", rod.length, SCENE_OF_EXTENT, SCENE_ONE_NUMBER, SCENE_POSITIVE),
    NUMBER("time.duration", duration, SCENE_OF_EXTENT, SCENE_ONE_NUMBER, SCENE_NOT_NEGATIVE),

    OF_ROD("rod.material.youngs_modulus", 1, youngs_modulus, SCENE_POSITIVE),
    OF_ROD("rod.material.shear_correction", 1, shear_correction, SCENE_POSITIVE),
    OF_ROD("rod.material.density", 1, density, SCENE_POSITIVE),
    OF_ROD("rod.inertia.mass_per_length", 1, mass_per_length, SCENE_POSITIVE),
    OF_ROD("rod.material.poissons_ratio", 1, poissons_ratio, SCENE_POISSON),
    OF_ROD("rod.material.viscosity", 1, viscosity, SCENE_NOT_NEGATIVE),
    OF_ROD("rod.material.relaxation_time", 1, relaxation_time, SCENE_NOT_NEGATIVE),
    OF_ROD("rod.section.radius", 1, radius, SCENE_POSITIVE),
    OF_ROD("rod.section.inner_radius", 1, inner_radius, SCENE_POSITIVE),
    OF_ROD("rod.section.width", 1, width, SCENE_POSITIVE),
    OF_ROD("rod.section.height", 1, height, SCENE_POSITIVE),
    OF_ROD("rod.stiffness.bending", 2, bending_stiffness, SCENE_STIFFNESS),
    OF_ROD("rod.stiffness.torsion", 1, torsional_stiffness, SCENE_STIFFNESS),
    OF_ROD("rod.stiffness.axial", 1, axial_stiffness, SCENE_STIFFNESS),
    OF_ROD("rod.stiffness.shear", 2, shear_stiffness, SCENE_STIFFNESS),
    OF_ROD("rod.inertia.rotary", 3, rotary_inertia, SCENE_NOT_NEGATIVE),
    OF_ROD("rod.damping.strain", 3, strain_damping, SCENE_NOT_NEGATIVE),
    OF_ROD("rod.damping.curvature", 3, curvature_damping, SCENE_NOT_NEGATIVE),
    NUMBER("loads.drag", loads.drag, SCENE_OF_ROD, SCENE_ALONG, SCENE_NOT_NEGATIVE),

    NUMBER("loads.quadratic_drag", loads.quadratic_drag, SCENE_OF_LOADS, SCENE_ALONG,
           SCENE_NOT_NEGATIVE),

    ROW("rod.rest.strain", 3, rod.rest_strain, SCENE_OF_LOADS, SCENE_EVERYWHERE, SCENE_ANY,
        SCENE_POLAR_VECTOR, SCENE_BODY),
    ROW("rod.rest.curvature", 3, rod.rest_curvature, SCENE_OF_LOADS, SCENE_EVERYWHERE, SCENE_ANY,
        SCENE_AXIAL_VECTOR, SCENE_BODY),
    ROW("rod.rest.imperfection", 3, rod.imperfection, SCENE_OF_LOADS, SCENE_ALONG, SCENE_ANY,
        SCENE_AXIAL_VECTOR, SCENE_BODY),
    ROW("boundary.start.rotation", 4, start.rotation, SCENE_OF_START, SCENE_HELD, SCENE_ANY,
        SCENE_ORIENTATION, SCENE_WORLD),
    ROW("boundary.start.position", 3, start.position, SCENE_OF_START, SCENE_HELD, SCENE_ANY,
        SCENE_POSITION_VECTOR, SCENE_WORLD),
    ROW("loads.base.force", 3, loads.base.force, SCENE_OF_BASE, SCENE_AT_END, SCENE_ANY,
        SCENE_POLAR_VECTOR, SCENE_BY_LOAD),
    ROW("loads.base.moment", 3, loads.base.moment, SCENE_OF_BASE, SCENE_AT_END, SCENE_ANY,
        SCENE_AXIAL_VECTOR, SCENE_BY_LOAD),
    ROW("boundary.end.rotation", 4, end.rotation, SCENE_OF_END, SCENE_HELD, SCENE_ANY,
        SCENE_ORIENTATION, SCENE_WORLD),
    ROW("boundary.end.position", 3, end.position, SCENE_OF_END, SCENE_HELD, SCENE_ANY,
        SCENE_POSITION_VECTOR, SCENE_WORLD),
    ROW("loads.tip.force", 3, loads.tip.force, SCENE_OF_TIP, SCENE_AT_END, SCENE_ANY,
        SCENE_POLAR_VECTOR, SCENE_BY_LOAD),
    ROW("loads.tip.moment", 3, loads.tip.moment, SCENE_OF_TIP, SCENE_AT_END, SCENE_ANY,
        SCENE_AXIAL_VECTOR, SCENE_BY_LOAD),
    ROW("initial.rotation", 4, initial.rotation, SCENE_OF_INITIAL, SCENE_AT_START, SCENE_ANY,
        SCENE_ORIENTATION, SCENE_WORLD),
    ROW("initial.position", 3, initial.position, SCENE_OF_INITIAL, SCENE_AT_START, SCENE_ANY,
        SCENE_POSITION_VECTOR, SCENE_WORLD),
    ROW("initial.velocity", 3, initial.velocity, SCENE_OF_INITIAL, SCENE_AT_START, SCENE_ANY,
        SCENE_POLAR_VECTOR, SCENE_WORLD),
    ROW("initial.angular_velocity", 3, initial.angular_velocity, SCENE_OF_INITIAL, SCENE_AT_START,
        SCENE_ANY, SCENE_AXIAL_VECTOR, SCENE_BODY),
    ROW("loads.gravity", 3, loads.gravity, SCENE_OF_LOADS, SCENE_IN_TIME, SCENE_FINITE,
        SCENE_POLAR_VECTOR, SCENE_WORLD),
    ROW("loads.force", 3, loads.force, SCENE_OF_LOADS, SCENE_EVERYWHERE, SCENE_ANY,
        SCENE_POLAR_VECTOR, SCENE_BY_LOAD),
    ROW("loads.moment", 3, loads.moment, SCENE_OF_LOADS, SCENE_EVERYWHERE, SCENE_ANY,
        SCENE_AXIAL_VECTOR, SCENE_BY_LOAD),
    ROW("manufactured.position", 3, manufactured.position, SCENE_OF_EXACT, SCENE_EVERYWHERE,
        SCENE_ANY, SCENE_POSITION_VECTOR, SCENE_WORLD),
    ROW("manufactured.rotation", 4, manufactured.rotation, SCENE_OF_EXACT, SCENE_EVERYWHERE,
        SCENE_ANY, SCENE_ORIENTATION, SCENE_WORLD),
    ROW("manufactured.angles", 3, manufactured.angles, SCENE_OF_EXACT, SCENE_EVERYWHERE, SCENE_ANY,
        SCENE_SCALAR, SCENE_WORLD),

    OF_BEAM("beam.force", force, SCENE_EVERYWHERE, SCENE_ANY),
    OF_BEAM("beam.moment", moment, SCENE_EVERYWHERE, SCENE_ANY),
    OF_BEAM("beam.foundation", foundation, SCENE_ALONG, SCENE_NOT_NEGATIVE),
    OF_BEAM("beam.base.force", base.force, SCENE_AT_END, SCENE_ANY),
    OF_BEAM("beam.base.moment", base.moment, SCENE_AT_END, SCENE_ANY),
    OF_BEAM("beam.tip.force", tip.force, SCENE_AT_END, SCENE_ANY),
    OF_BEAM("beam.tip.moment", tip.moment, SCENE_AT_END, SCENE_ANY),
    OF_BEAM("beam.initial.deflection", deflection, SCENE_AT_START, SCENE_ANY),
    OF_BEAM("beam.initial.velocity", velocity, SCENE_AT_START, SCENE_ANY),
    OF_BEAM("beam.initial.slope", slope, SCENE_AT_START, SCENE_ANY),
    OF_BEAM("beam.initial.slope_rate", slope_rate, SCENE_AT_START, SCENE_ANY),
};
const int scene_field_count = sizeof scene_fields / sizeof scene_fields[0];
_Static_assert(sizeof scene_fields / sizeof scene_fields[0] <= SCENE_FIELDS_MAX, "too many");

const quantity *scene_field_of(const scene *rod_scene, const scene_field *field)
{
    return (const quantity *)(const void *)((const char *)rod_scene + field->offset);
}
