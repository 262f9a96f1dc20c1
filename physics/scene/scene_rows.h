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
#ifndef PHYSICS_SCENE_SCENE_ROWS_H
#define PHYSICS_SCENE_SCENE_ROWS_H

#include "physics/scene/scene.h"

/* clang-format off */
#define SCENE_LENGTH_ROWS(X)                                                                       \
    X("rod.length", 1, rod.length, EXTENT, LENGTH, POSITIVE, SCALAR, WORLD, "m", NOTHING,          \
      "the sum of the segments, required without",                                            \
      "Length of the undeformed rod.")                                                             \
    X("rod.inserted", 1, rod.inserted, EXTENT, LENGTH, POSITIVE, SCALAR, WORLD, "m", NOTHING,      \
      "all of it",                                                                                 \
      "Length that has come out of a port, the tip first: the rod is held where s is its length "  \
      "less this. What is behind lies straight and does nothing; tendons pull from the port on. "  \
      "s, places and tables still count along the whole rod. In motion a formula of t, with a "    \
      "speed that does not jump, or a parameter with feed_time.")                                  \
    X("rod.feed_time", 1, rod.feed_time, EXTENT, ONE_NUMBER, POSITIVE, SCALAR, WORLD, "s",         \
      NOTHING, NULL,                                                                               \
      "In motion, of an `inserted` that is a parameter: how fast the drive follows it. What has "  \
      "come out goes to the command u by feed_time^2 I_tt + 2 feed_time I_t + I = u.")

#define SCENE_MATTER_ROWS(X, of, in)                                                                       \
    X(of "section.radius", 1, in radius, ROD, ALONG, POSITIVE, SCALAR, WORLD, "m", NOTHING,      \
      NULL,                                                                                        \
      "Radius of a circle, or outer radius of a tube. Sizes, material, stiffness, inertia and "    \
      "damping may be formulas of s, as for a tapered rod.")                                       \
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
      "Poisson's ratio nu; G = E/(2(1 + nu)). 0.5 is incompressible, such as rubber.")             \
    X(of "material.density", 1, in density, ROD, ALONG, POSITIVE, SCALAR, WORLD, "kg/m^3",       \
      NOTHING, NULL,                                                                               \
      "Density. Gravity and motions need it.")                                                     \
    X(of "material.shear_correction", 1, in shear_correction, ROD, ALONG, POSITIVE, SCALAR,      \
      WORLD, NULL, NOTHING, "Cowper's for the section",                                            \
      "The factor kappa of the shear stiffness kappa G A.")                                        \
    X(of "material.viscosity", 1, in viscosity, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "Pa s", \
      NOTHING, NULL,                                                                               \
      "Kelvin-Voigt damping eta of the material, in place of rod.damping: the stress is E times "  \
      "the strain plus eta times its rate, in shear eta/(2(1 + nu)). So damping is eta A of "      \
      "stretch, eta I of bending, eta kappa A/(2(1 + nu)) of shear, eta J/(2(1 + nu)) of twist.")  \
    X(of "material.relaxation_time", 1, in relaxation_time, ROD, ALONG, NOT_NEGATIVE, SCALAR,    \
      WORLD, "s", NOTHING, NULL,                                                                   \
      "The time eta/E, in place of viscosity: every damping is its stiffness times this time.")    \
    X(of "material.maxwell.ratio", 1, in maxwell_ratio, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD,   \
      NULL, NOTHING, NULL,                                                                         \
      "A spring of so many times the stiffness, in series with a damper, beside the material: a "  \
      "standard linear solid. A strain that is held has at first 1 + ratio times its stress.")     \
    X(of "material.maxwell.time", 1, in maxwell_time, ROD, ALONG, POSITIVE, SCALAR, WORLD, "s",    \
      NOTHING, "required with ratio",                                                              \
      "The time in which that spring relaxes, as exp(-t/time). The rod begins relaxed. For strain " \
      "modes it is the same all along a segment.")                                                 \
    X(of "stiffness.shear", 2, in shear_stiffness, ROD, ALONG, STIFFNESS, SCALAR, WORLD, "N",    \
      NOTHING, "from section, material and model",                                                 \
      "Shear stiffness kappa G A along d1, d2. It replaces the value of section and material.")    \
    X(of "stiffness.axial", 1, in axial_stiffness, ROD, ALONG, STIFFNESS, SCALAR, WORLD, "N",    \
      NOTHING, "from section, material and model",                                                 \
      "Axial stiffness E A.")                                                                      \
    X(of "stiffness.bending", 2, in bending_stiffness, ROD, ALONG, STIFFNESS, SCALAR, WORLD,     \
      "N m^2", NOTHING, "from section and material",                                               \
      "Bending stiffness E I about d1, d2.")                                                       \
    X(of "stiffness.torsion", 1, in torsional_stiffness, ROD, ALONG, STIFFNESS, SCALAR, WORLD,   \
      "N m^2", NOTHING, "from section and material",                                               \
      "Torsional stiffness G J.")                                                                  \
    X(of "inertia.mass_per_length", 1, in mass_per_length, ROD, ALONG, POSITIVE, SCALAR, WORLD,  \
      "kg/m", NOTHING, "from section and density",                                                 \
      "Mass per length rho A.")                                                                    \
    X(of "inertia.rotary", 3, in rotary_inertia, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD,        \
      "kg m", NOTHING, "from section and density",                                                 \
      "Rotary inertia per length, rho I about d1, d2, d3. [0, 0, 0] leaves it out.")

#define SCENE_REST_ROWS(X, of, in)                                                                         \
    X(of "rest.strain", 3, in rest_strain, LOADS, EVERYWHERE, ANY, POLAR_VECTOR, BODY, NULL,     \
      STRAIGHT, NULL,                                                                              \
      "Strain v of the unstressed rod along d1, d2, d3; formulas of s and t.")                     \
    X(of "rest.curvature", 3, in rest_curvature, LOADS, EVERYWHERE, ANY, AXIAL_VECTOR, BODY,     \
      "1/m", ZERO, NULL,                                                                           \
      "Curvature u of the unstressed rod about d1, d2, d3; formulas of s and t.")                  \
    X(of "rest.imperfection", 3, in imperfection, LOADS, ALONG, ANY, AXIAL_VECTOR, BODY, "1/m",  \
      ZERO, NULL,                                                                                  \
      "A curvature that is added to the rest curvature while the loads grow, and is gone when "    \
      "all of them act. It decides to which side a column buckles. For scenes at rest without "    \
      "hidden layers.")

#define SCENE_DAMPING_ROWS(X, of, in)                                                                      \
    X(of "damping.strain", 3, in strain_damping, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "N s", \
      NOTHING, "by the material, else 0",                                                          \
      "Kelvin-Voigt damping of shear along d1, d2 and of stretch.")                                \
    X(of "damping.curvature", 3, in curvature_damping, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD,  \
      "N m^2 s", NOTHING, "by the material, else 0",                                               \
      "Kelvin-Voigt damping of bending about d1, d2 and of twist.")

#define SCENE_LINE_ROWS(X)                                                                         \
    X("loads.gravity", 3, loads.gravity, LOADS, IN_TIME, FINITE, POLAR_VECTOR, WORLD, "m/s^2",     \
      ZERO, NULL,                                                                                  \
      "Acceleration of gravity, world frame; formulas of t.")                                      \
    X("loads.buoyancy", 1, loads.buoyancy, LOADS, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "kg/m", ZERO, \
      NULL,                                                                                        \
      "Mass of the fluid that the rod displaces, per length: the fluid's density times the area; " \
      "formula of s. The rod weighs so much less under loads.gravity. The axial force is then "     \
      "that beyond the pressure of the fluid on the section.")                                      \
    X("loads.drag", 1, loads.drag, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD, "N s/m^2", ZERO, NULL, \
      "Force per length against the velocity, f = -drag r_t; formula of s.")                       \
    X("loads.quadratic_drag", 1, loads.quadratic_drag, LOADS, ALONG, NOT_NEGATIVE, SCALAR, WORLD,  \
      "N s^2/m^3", ZERO, NULL,                                                                     \
      "Force per length against the square of the velocity, f = -quadratic_drag |r_t| r_t; "       \
      "formula of s. For a cylinder across a flow it is half of density, drag coefficient and "    \
      "diameter.")                                                                                 \
    X("loads.fluid.along", 3, loads.fluid_along, LOADS, ALONG, NOT_NEGATIVE, SCALAR, WORLD,        \
      "N s/m^2, N s^1.5/m^2.5, N s^2/m^3", ZERO, NULL,                                             \
      "Drag of a slender rod in a fluid: f = -(c1 + c2 |w|^(1/2) + c3 |w|) w against the velocity "\
      "w along the rod; [c1, c2, c3], formulas of s.")                                             \
    X("loads.fluid.across", 3, loads.fluid_across, LOADS, ALONG, NOT_NEGATIVE, SCALAR, WORLD,      \
      "N s/m^2, N s^1.5/m^2.5, N s^2/m^3", ZERO, NULL,                                             \
      "The same for the velocity across the rod. c3 is half of density, drag coefficient and "     \
      "diameter.")                                                                                 \
    X("loads.fluid.added_mass", 1, loads.added_mass, ROD, ALONG, NOT_NEGATIVE, SCALAR, WORLD,      \
      "kg/m", ZERO, NULL,                                                                          \
      "Mass per length of the fluid that moves with the rod across d3, not along it: of a round "  \
      "rod that of the fluid it displaces; formula of s. Its momentum changes as the rod moves "   \
      "and turns.")                                                                                \
    X("loads.magnetic.moment", 3, loads.magnetic_moment, LOADS, ALONG, FINITE, POLAR_VECTOR, BODY, \
      "A m", ZERO, NULL,                                                                           \
      "Magnetic moment m of the rod per length, along its directors d1, d2, d3: its magnetisation "\
      "times the area; formulas of s. In a field B it has the energy -m . B per length.")          \
    X("loads.magnetic.field", 3, loads.magnetic_field, LOADS, IN_TIME, FINITE, POLAR_VECTOR,       \
      WORLD, "T", ZERO, NULL,                                                                      \
      "Magnetic field B at the origin, world frame; formulas of t.")                               \
    X("loads.magnetic.gradient", 5, loads.magnetic_gradient, LOADS, IN_TIME, FINITE, GRADIENT,     \
      WORLD, "T/m", ZERO, NULL,                                                                    \
      "Gradient G of the field, B = field + G r, as [xx, yy, xy, xz, yz]; formulas of t. It is "   \
      "symmetric and zz = -xx - yy, as of any field without currents where the rod is.")           \
    X("loads.force", 3, loads.force, LOADS, EVERYWHERE, ANY, POLAR_VECTOR, BY_LOAD, "N/m",         \
      NOTHING, NULL,                                                                               \
      "Distributed force; formulas of s and t.")                                                   \
    X("loads.moment", 3, loads.moment, LOADS, EVERYWHERE, ANY, AXIAL_VECTOR, BY_LOAD, "N m/m",     \
      NOTHING, NULL,                                                                               \
      "Distributed moment; formulas of s and t.")                                                  \
    X("loads.foundation", 3, loads.foundation, LOADS, ALONG, NOT_NEGATIVE, TENSOR, WORLD, "N/m^2", \
      NOTHING, NULL,                                                                               \
      "Elastic foundation along the rod: force per length and displacement from the unstressed "   \
      "rod, along the axes of the world; formulas of s. It does not grow with the loads. Beams "   \
      "have beam.foundation.")

/* What of these laws along the rod are given: X(law, term, member of loads, more), all of a law
 * together, in the order of its numbers; term: for people, NULL: it stands with another; more: of a
 * rod_given (physics/rod/rod_internal.h). */
#define SCENE_SLENDER_DRAG                                                                         \
    .unit = {{2, -1}, {2.5, -1.5}, {3, -2}}, .formula = "c/(2 rhoA w1), c at w1 L"
#define SCENE_LAW_ROWS(X)                                                                          \
    X(LAW_SPRING, "elastic foundation", foundation, .unit = {{2, 0}, {2, 0}, {2, 0}})                       \
    X(LAW_RESISTANCE, "drag", drag, .unit = {{2, -1}}, .formula = "c/(2 rhoA w1)")                 \
    X(LAW_RESISTANCE, "quadratic drag", quadratic_drag, .unit = {{3, -2}},                         \
      .formula = "c L/(2 rhoA)")                                                                   \
    X(LAW_SLENDER_DRAG, "drag along d3", fluid_along, SCENE_SLENDER_DRAG)                          \
    X(LAW_SLENDER_DRAG, "drag across d3", fluid_across, SCENE_SLENDER_DRAG)                        \
    X(LAW_MAGNET, "magnetic field", magnetic_field, .is_factor = false)                            \
    X(LAW_MAGNET, "magnetic moment", magnetic_moment, .is_factor = true)                           \
    X(LAW_MAGNET_GRADIENT, "magnetic gradient", magnetic_gradient,                                 \
      .unit = {{1, 0}, {1, 0}, {1, 0}, {1, 0}, {1, 0}})                                                           \
    X(LAW_MAGNET_GRADIENT, NULL, magnetic_moment, .is_factor = true)

/* Rows of the table of support, of what is a law at a point and so taken by every form: X(name,
 * keys, OF_STATE, or OF_MOTION of what has no effect at rest). */
#define SCENE_LAW_FEATURES(X)                                                                      \
    X("a foundation", "loads.foundation", OF_STATE)                                                \
    X("drag", "loads.drag", OF_MOTION)                                                             \
    X("quadratic drag", "loads.quadratic_drag", OF_MOTION)                                         \
    X("drag in a fluid", "loads.fluid", OF_MOTION)                                                 \
    X("added mass of a fluid", "loads.fluid.added_mass", OF_MOTION)                                \
    X("a magnetised rod in a field", "loads.magnetic", OF_STATE)                                   \
    X("gravity", "loads.gravity", OF_STATE)                                                        \
    X("buoyancy", "loads.buoyancy", OF_STATE)                                                      \
    X("a distributed force", "loads.force", OF_STATE)                                              \
    X("a distributed moment", "loads.moment", OF_STATE)                                            \
    X("a load at the tip", "loads.tip", OF_STATE)

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
      "Force q per length along the deflection w of a beam, which bends about d1; formula of s "   \
      "and t.")                                                                                    \
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
      "Velocity of the deflection at t = 0; formula of s.")                                        \
    X("beam.initial.slope", 1, beam.slope, BEAM, AT_START, ANY, SCALAR, WORLD, "rad", NOTHING,     \
      "the derivative of the deflection",                                                          \
      "Rotation of the sections of a timoshenko beam at t = 0; formula of s.")                     \
    X("beam.initial.slope_rate", 1, beam.slope_rate, BEAM, AT_START, ANY, SCALAR, WORLD, "1/s",    \
      NOTHING, "the derivative of the velocity",                                                   \
      "Rate of the slope at t = 0; formula of s.")

/* How an end slides. */
#define SCENE_SLIDE_ROWS(X, of, in, part)                                                          \
    X(of "along", 3, in along, part, ONE_NUMBER, FINITE, POLAR_VECTOR, WORLD, NULL, NOTHING, NULL, \
      "Direction along which a guided or roller end slides; it is held across.")                   \
    X(of "across", 3, in across, part, ONE_NUMBER, FINITE, POLAR_VECTOR, WORLD, NULL, NOTHING,     \
      NULL,                                                                                        \
      "Direction across which a guided or roller end slides; it is held along it. A guided end "   \
      "with neither of the two moves freely and does not turn.")

#define SCENE_START_ROWS(X)                                                                        \
    X("boundary.start.position", 3, start.position, START, HELD, ANY, POSITION_VECTOR, WORLD, "m", \
      ZERO, "[0, 0, 0] where the type holds it",                                                   \
      "Position of a held end.")                                                                   \
    X("boundary.start.rotation", 4, start.rotation, START, HELD, ANY, ORIENTATION, WORLD, NULL,    \
      UPRIGHT, "[1, 0, 0, 0] where the type holds it",                                             \
      "Quaternion (w, x, y, z), body to world; d3 is the tangent. Normalised when read.")         \
    X("boundary.start.turn_time", 1, start.turn_time, START, ONE_NUMBER, POSITIVE, SCALAR, WORLD,  \
      "s", NOTHING, NULL,                                                                          \
      "In motion, of a rotation that a parameter with a range turns about d3, in rad: how fast a " \
      "drive follows it. The angle a goes to the command u by turn_time^2 a_tt + 2 turn_time a_t " \
      "+ a = u.")                                                                                  \
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
      "Turn of the end from where the unstressed rod ends, in place of rotation, for any number "  \
      "of turns: axis times angle, world frame. The other end is clamped or driven.")              \
    X("boundary.end.twist", 1, end.twist, END, HELD, ANY, SCALAR, WORLD, "rad", NOTHING, "0",      \
      "Angle by which the end is turned about its own d3, beyond its rotation or "                 \
      "rotation_vector, for any number of turns. On the path of equilibria the ends bend the rod " \
      "first; then the twist grows with the loads.")                                               \
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
      "Length of the motion. 0: the scene is at rest.")

#define SCENE_EXACT_ROWS(X)                                                                        \
    X("manufactured.position", 3, manufactured.position, EXACT, EVERYWHERE, ANY, POSITION_VECTOR,  \
      WORLD, "m", NOTHING, NULL,                                                                   \
      "A solution of your choice, formulas of s and t. The loads, ends and initial state that "    \
      "make it exact follow from it.")                                                             \
    X("manufactured.rotation", 4, manufactured.rotation, EXACT, EVERYWHERE, ANY, ORIENTATION,      \
      WORLD, NULL, NOTHING, NULL,                                                                  \
      "The quaternion (w, x, y, z) of the chosen solution; it is normalised.")                     \
    X("manufactured.angles", 3, manufactured.angles, EXACT, EVERYWHERE, ANY, SCALAR, WORLD, "rad", \
      NOTHING, NULL,                                                                               \
      "The rotation of the chosen solution by three angles a, b, c about body axes 1, 2, 3 in "    \
      "turn: q = q1(a) q2(b) q3(c).")

#define SCENE_PIECE_ROWS(X, of, in)                                                                \
    X(of "length", 1, in length, EXTENT, LENGTH, POSITIVE, SCALAR, WORLD, "m", NOTHING,        \
      "required",                                                                                  \
      "Length of a piece of the rod. Pieces follow one another from s = 0 on. What a piece does "  \
      "not give is as under rod.")

#define SCENE_TURN_ROWS(X, of, in)                                                                 \
    X(of "turn", 3, in turn, LOADS, ONE_NUMBER, FINITE, AXIAL_VECTOR, BODY, "rad", ZERO, NULL,     \
      "Turn of the piece against the end of the piece before: axis times angle in the axes of "    \
      "that end, as [pi/2, 0, 0] for an elbow. The first piece has none.")

#define SCENE_POINT_ROWS(X, of, in)                                                                \
    X(of "at", 1, in at, LISTS, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING, "required",    \
      "Place of a point load, 0 < at < length. The ends have loads.base and loads.tip.")           \
    X(of "force", 3, in load.force, LISTS, AT_PLACE, FINITE, POLAR_VECTOR, BY_LOAD, "N", NOTHING, \
      NULL,                                                                                        \
      "Force at that place; formulas of t.")                                                       \
    X(of "moment", 3, in load.moment, LISTS, AT_PLACE, FINITE, AXIAL_VECTOR, BY_LOAD, "N m",      \
      NOTHING, NULL,                                                                               \
      "Moment at that place; formulas of t.")

#define SCENE_BODY_ROWS(X, of, in)                                                                 \
    X(of "at", 1, in at, ROD, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING,            \
      "required",                                                                                  \
      "Place of a rigid body on the rod, 0 to length.")                                            \
    X(of "mass", 1, in mass, ROD, EACH_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, "kg", NOTHING,       \
      "required",                                                                                  \
      "Mass of the body.")                                                                         \
    X(of "offset", 3, in offset, ROD, EACH_NUMBER, FINITE, POLAR_VECTOR, BODY, "m", ZERO, NULL,    \
      "Where the centre of mass of the body lies, from the axis along d1, d2, d3.")                \
    X(of "inertia", 3, in inertia, ROD, EACH_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, "kg m^2",      \
      ZERO, NULL,                                                                                  \
      "Moments of inertia of the body about d1, d2, d3 through its centre of mass.")               \
    X(of "magnetic_moment", 3, in magnetic_moment, ROD, EACH_NUMBER, FINITE, POLAR_VECTOR, BODY,    \
      "A m^2", ZERO, NULL,                                                                         \
      "Magnetic moment of the body along d1, d2, d3, in the field of loads.magnetic.")

#define SCENE_SPRING_ROWS(X, of, in)                                                               \
    X(of "at", 1, in at, ROD, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING,            \
      "required",                                                                                  \
      "Place of a linear spring, 0 to length. On a beam it acts on the deflection, along d2, and " \
      "on the slope, about d1.")                                                                   \
    X(of "stiffness", 3, in stiffness, ROD, EACH_NUMBER, NOT_NEGATIVE, TENSOR, WORLD, "N/m",     \
      ZERO, NULL,                                                                                  \
      "Force per displacement from the anchor, along the axes of the world.")                      \
    X(of "turning", 3, in turning, ROD, EACH_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, "N m/rad",     \
      ZERO, NULL,                                                                                  \
      "Moment about d1, d2, d3 per rotation (axis times angle) from the unstressed rod there.")    \
    X(of "anchor", 3, in anchor, ROD, EACH_NUMBER, FINITE, POSITION_VECTOR, WORLD, "m", NOTHING, \
      "the unstressed rod there",                                                                  \
      "Position at which the spring does not pull.")

/* What runs along a part of the rod: what the places of its sections are, and what its end is. */
#define SCENE_ALONG_ROWS(X, of, in, guided, ends)                                                  \
    X(of "offset", 2, in offset, LISTS, ALONG, FINITE, SECTION_POINT, BODY, "m", NOTHING,          \
      "required", guided)                                                                          \
    X(of "start", 1, in start, LISTS, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING, "0",             \
      "Arc length at which it begins.")                                                            \
    X(of "end", 1, in end, LISTS, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING,                      \
      "the end of the rod", ends)

#define SCENE_TENDON_ROWS(X, of, in)                                                               \
    SCENE_ALONG_ROWS(X, of, in,                                                                    \
                     "Where the rod guides the tendon in its sections, along d1 and d2; formulas " \
                     "of s.",                                                                      \
                     "Arc length at which the tendon is fixed to the rod.")                        \
    X(of "tension", 1, in tension, LISTS, AT_PLACE, NOT_NEGATIVE, SCALAR, WORLD, "N", NOTHING,    \
      NULL,                                                                                        \
      "Tension of the tendon, where it begins; formula of t.")                                     \
    X(of "displacement", 1, in displacement, LISTS, AT_PLACE, FINITE, SCALAR, WORLD, "m",         \
      NOTHING, NULL,                                                                               \
      "In place of tension: by how much the tendon is pulled out of the rod, against its length "  \
      "in the unstressed rod; formula of t.")                                                      \
    X(of "stiffness", 1, in stiffness, LISTS, EACH_NUMBER, POSITIVE, SCALAR, WORLD, "N/m",         \
      NOTHING, "it keeps its length",                                                              \
      "Stiffness of a tendon with a displacement: its tension over its elongation.")               \
    X(of "friction", 1, in friction, LISTS, EACH_NUMBER, NOT_NEGATIVE, SCALAR, WORLD, NULL, ZERO,  \
      NULL,                                                                                        \
      "Coulomb's coefficient of the tendon against its guides. The tension of a pulled tendon "    \
      "falls by exp(-friction angle), with the angle by which its path has turned.")               \
    X(of "creep_speed", 1, in creep_speed, LISTS, ONE_NUMBER, POSITIVE, SCALAR, WORLD, "m/s",      \
      NOTHING, "1e-5 of the length over its time, L^2 sqrt(rho A/(E I))",                          \
      "In motion: speed past its guides below which a tendon with friction creeps rather than "    \
      "sticks. Friction is w/sqrt(w^2 + creep_speed^2) of Coulomb's at the speed w.")

#define SCENE_CHAMBER_ROWS(X, of, in)                                                              \
    SCENE_ALONG_ROWS(X, of, in,                                                                    \
                     "Where the axis of a fluid chamber runs in the sections, along d1 and d2; "   \
                     "formulas of s.",                                                             \
                     "Arc length at which the chamber ends.")                                      \
    X(of "pressure", 1, in pressure, LISTS, AT_PLACE, FINITE, SCALAR, WORLD, "Pa", NOTHING,       \
      "required",                                                                                  \
      "Pressure of the chamber above the outside; formula of t.")                                  \
    X(of "area", 1, in area, LISTS, ALONG, POSITIVE, SCALAR, WORLD, "m^2", NOTHING, "required",   \
      "Area of the cross-section of the chamber; formula of s.")

#define SCENE_TUBE_ROWS(X, of, in)                                                                 \
    X(of "end", 1, in end, LISTS, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING,                      \
      "the end of the rod",                                                                        \
      "Arc length at which a tube around the rod ends. Tube and rod share their axis and turn "    \
      "freely in one another.")                                                                    \
    X(of "section.radius", 1, in rod.radius, LISTS, ALONG, POSITIVE, SCALAR, WORLD, "m", NOTHING,  \
      NULL, "Outer radius of the tube.")                                                           \
    X(of "section.inner_radius", 1, in rod.inner_radius, LISTS, ALONG, POSITIVE, SCALAR, WORLD,    \
      "m", NOTHING, NULL, "Inner radius of the tube.")                                             \
    X(of "material.youngs_modulus", 1, in rod.youngs_modulus, LISTS, ALONG, POSITIVE, SCALAR,      \
      WORLD, "Pa", NOTHING, NULL, "Young's modulus of the tube.")                                  \
    X(of "material.poissons_ratio", 1, in rod.poissons_ratio, LISTS, ALONG, POISSON, SCALAR,       \
      WORLD, NULL, NOTHING, NULL, "Poisson's ratio of the tube.")                                  \
    X(of "material.density", 1, in rod.density, LISTS, ALONG, POSITIVE, SCALAR, WORLD, "kg/m^3",   \
      NOTHING, NULL, "Density of the tube. Gravity needs it.")                                     \
    X(of "stiffness.bending", 2, in rod.bending_stiffness, LISTS, ALONG, POSITIVE, SCALAR, WORLD,  \
      "N m^2", NOTHING, "from section and material", "Bending stiffness E I of the tube about "    \
                                                     "its own d1, d2.")                            \
    X(of "stiffness.torsion", 1, in rod.torsional_stiffness, LISTS, ALONG, STIFFNESS, SCALAR,      \
      WORLD, "N m^2", NOTHING, "from section and material", "Torsional stiffness G J of the "      \
                                                            "tube.")                               \
    X(of "inertia.mass_per_length", 1, in rod.mass_per_length, LISTS, ALONG, POSITIVE, SCALAR,     \
      WORLD, "kg/m", NOTHING, "from section and density", "Mass per length of the tube.")          \
    X(of "rest.curvature", 3, in rod.rest_curvature, LISTS, ALONG, FINITE, AXIAL_VECTOR, BODY,     \
      "1/m", ZERO, NULL,                                                                           \
      "Curvature of the free tube about its own d1, d2, d3; formulas of s.")                       \
    X(of "turned", 1, in turned, LISTS, EACH_NUMBER, FINITE, SCALAR, WORLD, "rad", ZERO, NULL,      \
      "Angle by which the base of the tube is turned about the axis against that of the rod, any " \
      "number of turns.")                                                                          \
    X(of "transmission", 1, in transmission, LISTS, EACH_NUMBER, NOT_NEGATIVE, SCALAR, WORLD,      \
      "m", ZERO, NULL,                                                                                  \
      "Length of the straight part of the tube behind s = 0, at whose far end it is turned.")

#define SCENE_BEAM_POINT_ROWS(X, of, in)                                                           \
    X(of "at", 1, in at, BEAM, PLACE, FINITE, SCALAR, WORLD, "m", NOTHING, "required",      \
      "Place of a point load on the beam, 0 < at < length.")                                       \
    X(of "force", 1, in load.force, BEAM, AT_PLACE, FINITE, SCALAR, WORLD, "N", NOTHING, NULL,     \
      "Force along w at that place; formula of t.")                                                \
    X(of "moment", 1, in load.moment, BEAM, AT_PLACE, FINITE, SCALAR, WORLD, "N m", NOTHING, NULL, \
      "Moment at that place; formula of t.")
/* clang-format on */

#endif
