/* The quantities of a scene, each in one row that says all of it; scene_fields (checks, the search
 * for a plane, defaults) and the keys of a scene file (reader, --set, --help, --print-config) are
 * made of these rows.
 *
 *   X(key, count, member, part, rule, bounds, geometry, axes, unit, otherwise, fallback, help)
 *
 * key: dotted, of YAML; count: of quantities in turn; member: of the scene. Then the names, without
 * SCENE_, of scene_part, scene_rule, scene_bounds, scene_geometry, scene_axes (scene_field.h).
 * unit: NULL for a number without one. otherwise: the value where it is not given, of
 * scene_otherwise; fallback: this in words where it depends on other keys, else NULL. help: for
 * people. Rows are in the order of --help.
 *
 * Rows of what there may be several of are for one entry: `of` is what its keys begin with, `in`
 * what its members begin with. A segment has the rows of the rod. */
#ifndef PHYSICS_SCENE_ROWS_H
#define PHYSICS_SCENE_ROWS_H

#include "physics/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* clang-format off */
#define SCENE_LENGTH_ROWS(X)                                                                       \
    X("rod.length", 1, rod.length, EXTENT, ONE_NUMBER, POSITIVE, SCALAR, WORLD, "m", NOTHING,      \
      "the sum of the segments, required without",                                            \
      "Length of the undeformed rod.")

#define SCENE_MATTER_ROWS(X, of, in)                                                                       \
    X(of "section.radius", 1, in radius, ROD, ALONG, POSITIVE, SCALAR, WORLD, "m", NOTHING,      \
      NULL,                                                                                        \
      "Radius of a circle, outer radius of a tube. Sizes, material, stiffness, inertia and "       \
      "damping may be formulas of s: a tapered rod.")                                              \
    X(of "section.inner_radius", 1, in inner_radius, ROD, ALONG, POSITIVE, SCALAR, WORLD, "m",   \
      NOTHING, NULL,                                                                               \
      "Inner radius of a tube.")                                                                   \
    X(of "section.width", 1, in width, ROD, ALONG, POSITIVE, SCALAR, WORLD, "m", NOTHING, NULL,  \
      "Side of a rectangle along d1.")                                                             \
    X(of "section.height", 1, in height, ROD, ALONG, POSITIVE, SCALAR, WORLD, "m", NOTHING,      \
      NULL,                                                                                        \
      "Side of a rectangle along d2.")                                                             \
    X(of "material.youngs_modulus", 1, in youngs_modulus, ROD, ALONG, POSITIVE, SCALAR, WORLD,   \
      "Pa", NOTHING, NULL,                                                                         \
      "Young's modulus E.")                                                                        \
    X(of "material.poissons_ratio", 1, in poissons_ratio, ROD, ALONG, POISSON, SCALAR, WORLD,    \
      NULL, NOTHING, NULL,                                                                         \
      "Poisson's ratio nu; G = E/(2(1 + nu)). 0.5: incompressible, as rubber.")                    \
    X(of "material.density", 1, in density, ROD, ALONG, POSITIVE, SCALAR, WORLD, "kg/m^3",       \
      NOTHING, NULL,                                                                               \
      "Needed for gravity and for dynamics.")                                                      \
    X(of "material.shear_correction", 1, in shear_correction, ROD, ALONG, POSITIVE, SCALAR,      \
      WORLD, NULL, NOTHING, "Cowper's for the section",                                            \
      "kappa in the shear stiffness kappa G A.")                                                   \
    X(of "material.viscosity", 1, in viscosity, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "Pa s", \
      NOTHING, NULL,                                                                               \
      "Kelvin-Voigt damping by the material in place of rod.damping: the stress is E times the "   \
      "strain and this, eta, times its rate, in shear eta/(2(1 + nu)). So damping is eta A of "    \
      "stretch, eta I of bending, eta kappa A/(2(1 + nu)) of shear, eta J/(2(1 + nu)) of twist.")  \
    X(of "material.relaxation_time", 1, in relaxation_time, ROD, ALONG, NOT_NEGATIVE, SCALAR,    \
      WORLD, "s", NOTHING, NULL,                                                                   \
      "Or by the time eta/E: every damping is its stiffness times this.")                          \
    X(of "stiffness.shear", 2, in shear_stiffness, ROD, ALONG, STIFFNESS, SCALAR, WORLD, "N",    \
      NOTHING, "from section, material and model",                                                 \
      "kappa G A along d1, d2; replaces what follows from section and material.")                  \
    X(of "stiffness.axial", 1, in axial_stiffness, ROD, ALONG, STIFFNESS, SCALAR, WORLD, "N",    \
      NOTHING, "from section, material and model",                                                 \
      "E A.")                                                                                      \
    X(of "stiffness.bending", 2, in bending_stiffness, ROD, ALONG, STIFFNESS, SCALAR, WORLD,     \
      "N m^2", NOTHING, "from section and material",                                               \
      "E I about d1, d2.")                                                                         \
    X(of "stiffness.torsion", 1, in torsional_stiffness, ROD, ALONG, STIFFNESS, SCALAR, WORLD,   \
      "N m^2", NOTHING, "from section and material",                                               \
      "G J.")                                                                                      \
    X(of "inertia.mass_per_length", 1, in mass_per_length, ROD, ALONG, POSITIVE, SCALAR, WORLD,  \
      "kg/m", NOTHING, "from section and density",                                                 \
      "rho A.")                                                                                    \
    X(of "inertia.rotary", 3, in rotary_inertia, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD,        \
      "kg m", NOTHING, "from section and density",                                                 \
      "rho I about d1, d2, d3; [0, 0, 0] leaves rotary inertia out.")

#define SCENE_REST_ROWS(X, of, in)                                                                         \
    X(of "rest.strain", 3, in rest_strain, LOADS, EVERYWHERE, ANY, POLAR_VECTOR, BODY, NULL,     \
      STRAIGHT, NULL,                                                                              \
      "Strain v of the unstressed rod along d1, d2, d3; formulas of s and t.")                     \
    X(of "rest.curvature", 3, in rest_curvature, LOADS, EVERYWHERE, ANY, AXIAL_VECTOR, BODY,     \
      "1/m", ZERO, NULL,                                                                           \
      "Curvature u of the unstressed rod about d1, d2, d3; formulas of s and t.")                  \
    X(of "rest.imperfection", 3, in imperfection, LOADS, ALONG, ANY, AXIAL_VECTOR, BODY, "1/m",  \
      ZERO, NULL,                                                                                  \
      "Curvature added to it while the loads grow, gone when all of them act: it says to which "   \
      "side a column buckles. Static scenes without hidden layers.")

#define SCENE_DAMPING_ROWS(X, of, in)                                                                      \
    X(of "damping.strain", 3, in strain_damping, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "N s", \
      NOTHING, "by the material, else 0",                                                          \
      "Kelvin-Voigt damping of shear, shear, stretch.")                                            \
    X(of "damping.curvature", 3, in curvature_damping, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD,  \
      "N m^2 s", NOTHING, "by the material, else 0",                                               \
      "Kelvin-Voigt damping of bending, bending, twist.")

#define SCENE_LINE_ROWS(X)                                                                         \
    X("loads.gravity", 3, loads.gravity, LOADS, IN_TIME, FINITE, POLAR_VECTOR, WORLD, "m/s^2",     \
      ZERO, NULL,                                                                                  \
      "Acceleration of gravity, world frame; formulas of t.")                                      \
    X("loads.drag", 1, loads.drag, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "N s/m^2", ZERO, NULL, \
      "Force per length against the velocity, f = -drag r_t; formula of s.")                       \
    X("loads.quadratic_drag", 1, loads.quadratic_drag, LOADS, ALONG, NOT_NEGATIVE, SCALAR, WORLD,  \
      "N s^2/m^3", ZERO, NULL,                                                                     \
      "Force per length against the square of the velocity, f = -quadratic_drag |r_t| r_t; of a "  \
      "cylinder across a flow half of density, drag coefficient and diameter; formula of s.")      \
    X("loads.force", 3, loads.force, LOADS, EVERYWHERE, ANY, POLAR_VECTOR, BY_LOAD, "N/m",         \
      NOTHING, NULL,                                                                               \
      "Distributed force; formulas of s and t.")                                                   \
    X("loads.moment", 3, loads.moment, LOADS, EVERYWHERE, ANY, AXIAL_VECTOR, BY_LOAD, "N m/m",     \
      NOTHING, NULL,                                                                               \
      "Distributed moment; formulas of s and t.")                                                  \
    X("loads.foundation", 3, loads.foundation, LOADS, ALONG, NOT_NEGATIVE, TENSOR, WORLD, "N/m^2", \
      NOTHING, NULL,                                                                               \
      "Elastic foundation along the rod: force per length and displacement from the unstressed "   \
      "rod, along the world's axes; formulas of s. It does not grow with the loads. Of a beam "    \
      "beam.foundation.")

#define SCENE_BASE_ROWS(X)                                                                         \
    X("loads.base.force", 3, loads.base.force, BASE, AT_END, ANY, POLAR_VECTOR, BY_LOAD, "N",      \
      NOTHING, NULL,                                                                               \
      "Force on the end s = 0 (type loaded); formulas of t.")                                      \
    X("loads.base.moment", 3, loads.base.moment, BASE, AT_END, ANY, AXIAL_VECTOR, BY_LOAD, "N m",  \
      NOTHING, NULL,                                                                               \
      "Moment on the end s = 0; formulas of t.")

#define SCENE_TIP_ROWS(X)                                                                          \
    X("loads.tip.force", 3, loads.tip.force, TIP, AT_END, ANY, POLAR_VECTOR, BY_LOAD, "N",         \
      NOTHING, NULL,                                                                               \
      "Force on the end s = length; formulas of t.")                                               \
    X("loads.tip.moment", 3, loads.tip.moment, TIP, AT_END, ANY, AXIAL_VECTOR, BY_LOAD, "N m",     \
      NOTHING, NULL,                                                                               \
      "Moment on the end s = length; formulas of t.")

#define SCENE_BEAM_ROWS(X)                                                                         \
    X("beam.force", 1, beam.force, BEAM, EVERYWHERE, ANY, SCALAR, WORLD, "N/m", NOTHING, NULL,     \
      "Of a beam, which bends about d1: force q along its deflection w; formula of s and t.")      \
    X("beam.moment", 1, beam.moment, BEAM, EVERYWHERE, ANY, SCALAR, WORLD, "N m/m", NOTHING, NULL, \
      "Distributed moment, positive where it turns the axis towards w; formula of s and t.")       \
    X("beam.foundation", 1, beam.foundation, BEAM, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "N/m^2",    \
      NOTHING, NULL,                                                                               \
      "Elastic foundation, force per length k w against the deflection; formula of s.")            \
    X("beam.base.force", 1, beam.base.force, BEAM, AT_END, ANY, SCALAR, WORLD, "N", NOTHING, NULL, \
      "Force along w on the end s = 0 (type loaded); formula of t.")                               \
    X("beam.base.moment", 1, beam.base.moment, BEAM, AT_END, ANY, SCALAR, WORLD, "N m", NOTHING,   \
      NULL,                                                                                        \
      "Moment on the end s = 0; formula of t.")                                                    \
    X("beam.tip.force", 1, beam.tip.force, BEAM, AT_END, ANY, SCALAR, WORLD, "N", NOTHING, NULL,   \
      "Force along w on the end s = length; formula of t.")                                        \
    X("beam.tip.moment", 1, beam.tip.moment, BEAM, AT_END, ANY, SCALAR, WORLD, "N m", NOTHING,     \
      NULL,                                                                                        \
      "Moment on the end s = length; formula of t.")                                               \
    X("beam.initial.deflection", 1, beam.deflection, BEAM, AT_START, ANY, SCALAR, WORLD, "m",      \
      NOTHING, "0",                                                                                \
      "Deflection at t = 0; formula of s.")                                                        \
    X("beam.initial.velocity", 1, beam.velocity, BEAM, AT_START, ANY, SCALAR, WORLD, "m/s",        \
      NOTHING, "0",                                                                                \
      "Its velocity at t = 0; formula of s.")                                                      \
    X("beam.initial.slope", 1, beam.slope, BEAM, AT_START, ANY, SCALAR, WORLD, "rad", NOTHING,     \
      "the derivative of the deflection",                                                          \
      "Rotation of the sections of a timoshenko beam at t = 0; formula of s.")                     \
    X("beam.initial.slope_rate", 1, beam.slope_rate, BEAM, AT_START, ANY, SCALAR, WORLD, "1/s",    \
      NOTHING, "the derivative of the velocity",                                                   \
      "Its rate at t = 0; formula of s.")

/* How an end slides. */
#define SCENE_SLIDE_ROWS(X, of, in, part)                                                          \
    X(of "along", 3, in along, part, ONE_NUMBER, FINITE, POLAR_VECTOR, WORLD, NULL, NOTHING, NULL, \
      "Of a guided or roller end: the direction along which its position slides, held across.")    \
    X(of "across", 3, in across, part, ONE_NUMBER, FINITE, POLAR_VECTOR, WORLD, NULL, NOTHING,     \
      NULL,                                                                                        \
      "Or the direction across which it slides, held along it. A guided end with neither of them " \
      "moves freely and does not turn.")

#define SCENE_START_ROWS(X)                                                                        \
    X("boundary.start.position", 3, start.position, START, HELD, ANY, POSITION_VECTOR, WORLD, "m", \
      ZERO, "[0, 0, 0] where the type holds it",                                                   \
      "Position of a held end.")                                                                   \
    X("boundary.start.rotation", 4, start.rotation, START, HELD, ANY, ORIENTATION, WORLD, NULL,    \
      UPRIGHT, "[1, 0, 0, 0] where the type holds it",                                             \
      "Quaternion (w, x, y, z), body to world; d3 is the tangent. Normalised when read.")         \
    SCENE_SLIDE_ROWS(X, "boundary.start.", start., START)

#define SCENE_END_ROWS(X)                                                                          \
    X("boundary.end.position", 3, end.position, END, HELD, ANY, POSITION_VECTOR, WORLD, "m",       \
      NOTHING, NULL,                                                                               \
      "Position of a held end.")                                                                   \
    X("boundary.end.rotation", 4, end.rotation, END, HELD, ANY, ORIENTATION, WORLD, NULL, NOTHING, \
      NULL,                                                                                        \
      "Quaternion (w, x, y, z) of a held end.")                                                    \
    X("boundary.end.rotation_vector", 3, end.rotation_vector, END, HELD, ANY, AXIAL_VECTOR, WORLD, \
      "rad", NOTHING, NULL,                                                                        \
      "In place of rotation, for any number of turns: by how much the end is turned from where "   \
      "the unstressed rod ends; axis times angle, world frame. The other end is clamped or "       \
      "driven.")                                                                                   \
    X("boundary.end.twist", 1, end.twist, END, HELD, ANY, SCALAR, WORLD, "rad", NOTHING, "0",      \
      "By how much the end is turned on about its own d3, beyond its rotation or rotation_vector " \
      "and for any number of turns. On the path of equilibria the ends bend the rod first, then "  \
      "the twist grows with the loads.")                                                           \
    SCENE_SLIDE_ROWS(X, "boundary.end.", end., END)

#define SCENE_INITIAL_ROWS(X)                                                                      \
    X("initial.position", 3, initial.position, INITIAL, AT_START, ANY, POSITION_VECTOR, WORLD,     \
      "m", NOTHING, "at rest in the unstressed shape",                                             \
      "Position at t = 0; formulas of s.")                                                         \
    X("initial.rotation", 4, initial.rotation, INITIAL, AT_START, ANY, ORIENTATION, WORLD, NULL,   \
      NOTHING, "at rest in the unstressed shape",                                                  \
      "Quaternion (w, x, y, z) at t = 0; formulas of s.")                                          \
    X("initial.velocity", 3, initial.velocity, INITIAL, AT_START, ANY, POLAR_VECTOR, WORLD, "m/s", \
      NOTHING, "zero",                                                                             \
      "Velocity at t = 0, world frame; formulas of s.")                                            \
    X("initial.angular_velocity", 3, initial.angular_velocity, INITIAL, AT_START, ANY,             \
      AXIAL_VECTOR, BODY, "1/s", NOTHING, "zero",                                                  \
      "Angular velocity at t = 0, body frame; formulas of s.")

#define SCENE_DURATION_ROWS(X)                                                                     \
    X("time.duration", 1, duration, EXTENT, ONE_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, "s", ZERO,    \
      NULL,                                                                                        \
      "0: a static scene.")

#define SCENE_EXACT_ROWS(X)                                                                        \
    X("manufactured.position", 3, manufactured.position, EXACT, EVERYWHERE, ANY, POSITION_VECTOR,  \
      WORLD, "m", NOTHING, NULL,                                                                   \
      "A solution of your choice, formulas of s and t; the loads, ends and initial state that "    \
      "make it exact follow.")                                                                     \
    X("manufactured.rotation", 4, manufactured.rotation, EXACT, EVERYWHERE, ANY, ORIENTATION,      \
      WORLD, NULL, NOTHING, NULL,                                                                  \
      "Its quaternion (w, x, y, z), normalised.")                                                  \
    X("manufactured.angles", 3, manufactured.angles, EXACT, EVERYWHERE, ANY, SCALAR, WORLD, "rad", \
      NOTHING, NULL,                                                                               \
      "Or three angles a, b, c about body axes 1, 2, 3 in turn: q = q1(a) q2(b) q3(c).")

#define SCENE_PIECE_ROWS(X, of, in)                                                                \
    X(of "length", 1, in length, EXTENT, ONE_NUMBER, POSITIVE, SCALAR, WORLD, "m", NOTHING,        \
      "required",                                                                                  \
      "The rod in pieces from s = 0 on, which may differ in all that follows; what a piece does "  \
      "not give is as under rod. Its length.")

#define SCENE_TURN_ROWS(X, of, in)                                                                 \
    X(of "turn", 3, in turn, LOADS, ONE_NUMBER, FINITE, AXIAL_VECTOR, BODY, "rad", ZERO, NULL,     \
      "How the piece is set against the end of the one before: axis times angle in the axes of "   \
      "that end, [pi/2, 0, 0] for an elbow. The first has none.")

#define SCENE_POINT_ROWS(X, of, in)                                                                \
    X(of "at", 1, in at, LISTS, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING, "required",    \
      "Place within the rod, 0 < at < length, on which the outside acts; for the ends there are "  \
      "loads.base and loads.tip.")                                                                 \
    X(of "force", 3, in load.force, LISTS, AT_PLACE, FINITE, POLAR_VECTOR, BY_LOAD, "N", NOTHING, \
      NULL,                                                                                        \
      "Force on it; formulas of t.")                                                               \
    X(of "moment", 3, in load.moment, LISTS, AT_PLACE, FINITE, AXIAL_VECTOR, BY_LOAD, "N m",      \
      NOTHING, NULL,                                                                               \
      "Moment on it; formulas of t.")

#define SCENE_BODY_ROWS(X, of, in)                                                                 \
    X(of "at", 1, in at, ROD, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING,            \
      "required",                                                                                  \
      "Place of the section to which a rigid body is fixed, its centre on the axis; 0 to length.") \
    X(of "mass", 1, in mass, ROD, EACH_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, "kg", NOTHING,       \
      "required",                                                                                  \
      "Its mass.")                                                                                 \
    X(of "inertia", 3, in inertia, ROD, ONE_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, "kg m^2",      \
      ZERO, NULL,                                                                                  \
      "Its moments of inertia about d1, d2, d3.")

#define SCENE_SPRING_ROWS(X, of, in)                                                               \
    X(of "at", 1, in at, ROD, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING,            \
      "required",                                                                                  \
      "Place of the section that a linear spring holds; 0 to length. Of a beam it acts on the "      \
      "deflection, along d2, and on the slope, about d1.")                             \
    X(of "stiffness", 3, in stiffness, ROD, ONE_NUMBER, NOT_NEGATIVE, TENSOR, WORLD, "N/m",     \
      ZERO, NULL,                                                                                  \
      "Force per displacement from the anchor, along the world's axes.")                           \
    X(of "turning", 3, in turning, ROD, ONE_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, "N m/rad",     \
      ZERO, NULL,                                                                                  \
      "Moment about d1, d2, d3 per rotation, axis times angle, from the unstressed rod there.")    \
    X(of "anchor", 3, in anchor, ROD, ONE_NUMBER, FINITE, POSITION_VECTOR, WORLD, "m", NOTHING, \
      "the unstressed rod there",                                                                  \
      "Where the spring does not pull.")

/* What runs along a part of the rod: what the places of its sections are, and what its end is. */
#define SCENE_ALONG_ROWS(X, of, in, guided, ends)                                                  \
    X(of "offset", 2, in offset, LISTS, ALONG, FINITE, SECTION_POINT, BODY, "m", NOTHING,          \
      "required", guided)                                                                          \
    X(of "start", 1, in start, LISTS, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING, "0",             \
      "From here on.")                                                                             \
    X(of "end", 1, in end, LISTS, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING,                      \
      "the end of the rod", ends)

#define SCENE_TENDON_ROWS(X, of, in)                                                               \
    SCENE_ALONG_ROWS(X, of, in,                                                                    \
                     "A tendon is guided by the rod at this place of its sections, along d1 and "  \
                     "d2; formulas of s.",                                                         \
                     "It is fixed to the rod here.")                                               \
    X(of "tension", 1, in tension, LISTS, AT_PLACE, NOT_NEGATIVE, SCALAR, WORLD, "N", NOTHING,    \
      NULL,                                                                                        \
      "Its tension, where it begins; formula of t.")                                               \
    X(of "displacement", 1, in displacement, LISTS, AT_PLACE, FINITE, SCALAR, WORLD, "m",         \
      NOTHING, NULL,                                                                               \
      "Or by how much it is pulled out of the rod, against its length in the unstressed rod; "     \
      "formula of t.")                                                                             \
    X(of "stiffness", 1, in stiffness, LISTS, ONE_NUMBER, POSITIVE, SCALAR, WORLD, "N/m",         \
      NOTHING, "it keeps its length",                                                              \
      "Of a tendon with a displacement: its tension over how much longer it is.")                  \
    X(of "friction", 1, in friction, LISTS, ONE_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, NULL, ZERO,  \
      NULL,                                                                                        \
      "Coulomb's coefficient against the guides: pulled, its tension falls by exp(-friction angle) " \
      "with the angle that its path has turned. At rest only.")

#define SCENE_CHAMBER_ROWS(X, of, in)                                                              \
    SCENE_ALONG_ROWS(X, of, in,                                                                    \
                     "A fluid chamber along the rod has its axis at this place of the sections, "  \
                     "along d1 and d2; formulas of s.",                                            \
                     "Up to here.")                                                                \
    X(of "pressure", 1, in pressure, LISTS, AT_PLACE, FINITE, SCALAR, WORLD, "Pa", NOTHING,       \
      "required",                                                                                  \
      "Its pressure over that outside; formula of t.")                                             \
    X(of "area", 1, in area, LISTS, ALONG, POSITIVE, SCALAR, WORLD, "m^2", NOTHING, "required",   \
      "Area of its cross-section; formula of s.")

#define SCENE_TUBE_ROWS(X, of, in)                                                                 \
    X(of "end", 1, in end, LISTS, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING,                      \
      "the end of the rod",                                                                        \
      "A tube around the rod, from its beginning up to here: the two share their axis and turn "   \
      "freely in one another.")                                                                    \
    X(of "section.radius", 1, in rod.radius, LISTS, ALONG, POSITIVE, SCALAR, WORLD, "m", NOTHING,  \
      NULL, "Its outer radius.")                                                                   \
    X(of "section.inner_radius", 1, in rod.inner_radius, LISTS, ALONG, POSITIVE, SCALAR, WORLD,    \
      "m", NOTHING, NULL, "Its inner radius.")                                                     \
    X(of "material.youngs_modulus", 1, in rod.youngs_modulus, LISTS, ALONG, POSITIVE, SCALAR,      \
      WORLD, "Pa", NOTHING, NULL, "Young's modulus.")                                              \
    X(of "material.poissons_ratio", 1, in rod.poissons_ratio, LISTS, ALONG, POISSON, SCALAR,       \
      WORLD, NULL, NOTHING, NULL, "Poisson's ratio.")                                              \
    X(of "material.density", 1, in rod.density, LISTS, ALONG, POSITIVE, SCALAR, WORLD, "kg/m^3",   \
      NOTHING, NULL, "Needed for gravity.")                                                        \
    X(of "stiffness.bending", 2, in rod.bending_stiffness, LISTS, ALONG, POSITIVE, SCALAR, WORLD,  \
      "N m^2", NOTHING, "from section and material", "E I about its own d1, d2.")                  \
    X(of "stiffness.torsion", 1, in rod.torsional_stiffness, LISTS, ALONG, STIFFNESS, SCALAR,      \
      WORLD, "N m^2", NOTHING, "from section and material", "G J.")                                \
    X(of "inertia.mass_per_length", 1, in rod.mass_per_length, LISTS, ALONG, POSITIVE, SCALAR,     \
      WORLD, "kg/m", NOTHING, "from section and density", "rho A.")                                \
    X(of "rest.curvature", 3, in rod.rest_curvature, LISTS, ALONG, FINITE, AXIAL_VECTOR, BODY,     \
      "1/m", ZERO, NULL,                                                                           \
      "Its curvature by itself, about its own d1, d2, d3; formulas of s.")                         \
    X(of "turned", 1, in turned, LISTS, ONE_NUMBER, FINITE, SCALAR, WORLD, "rad", ZERO, NULL,      \
      "By how much its base is turned about the axis against that of the rod, any number of "      \
      "turns.")                                                                                    \
    X(of "transmission", 1, in transmission, LISTS, ONE_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, "m",  \
      ZERO, NULL,                                                                                  \
      "Length of its straight part behind s = 0, held straight, at whose far end it is turned.")

#define SCENE_BEAM_POINT_ROWS(X, of, in)                                                           \
    X(of "at", 1, in at, BEAM, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING, "required",      \
      "Place within the beam, 0 < at < length, on which the outside acts.")                        \
    X(of "force", 1, in load.force, BEAM, AT_PLACE, FINITE, SCALAR, WORLD, "N", NOTHING, NULL,     \
      "Force along w on it; formula of t.")                                                        \
    X(of "moment", 1, in load.moment, BEAM, AT_PLACE, FINITE, SCALAR, WORLD, "N m", NOTHING, NULL, \
      "Moment on it; formula of t.")
/* clang-format on */

#ifdef __cplusplus
}
#endif

#endif
