/* Input: numbers beyond reason, data files, networks and settings that cannot work. */
#include "tools/judge/stress_rows.h"

#define BESIDE_PULL ROD "loads: {tip: {force: [1, 0, 0]}}\n" BESIDE
#define SET(...)    .overrides = {__VA_ARGS__}, .quick = true

/* The elastica of F L^2/EI = 1; physics/analytic.h. */
#define ROW_0 "0,0,0,0\n"
#define ROW_1 "1,0.30172077379981,0,0.94356676371662\n"

static const stress_row rows[] = {
    {"number/length-1e-300", PULL, SET("rod.length=1e-300"),
     BOTH(REFUSED("rod.length", "EI/L^2 overflows"))},
    {"number/length-1e300", PULL, SET("rod.length=1e300"),
     BOTH(REFUSED("rod.length", "EI/L^2 vanishes"))},
    {"number/length-denormal", PULL, SET("rod.length=5e-324"),
     BOTH(REFUSED("rod.length", "EI/L^2 overflows"))},
    {"number/stiffness-1e300", PULL, SET("rod.stiffness.bending=[1e300, 1e300]"),
     BOTH(REFUSED("rod.stiffness.bending", "beyond any rod"))},
    {"number/stiffness-1e-300", PULL, SET("rod.stiffness.bending=[1e-300, 1e-300]"),
     BOTH(REFUSED("rod.stiffness.bending", "beyond any rod"))},
    {"number/torsion-1e-300", PULL, SET("rod.stiffness.torsion=1e-300", "motion=spatial"),
     BOTH(REFUSED("rod.stiffness.torsion", "its compliance overflows in a square"))},
    {"number/modulus-1e300",
     "rod:\n"
     "  length: 1\n"
     "  section: {shape: circle, radius: 1}\n"
     "  material: {youngs_modulus: 1e300, poissons_ratio: 0.3}\n",
     .quick = true, BOTH(REFUSED("rod.material.youngs_modulus", "beyond any rod"))},
    {"number/radius-1e-300",
     "rod:\n"
     "  length: 1\n"
     "  section: {shape: circle, radius: 1e-300}\n"
     "  material: {youngs_modulus: 1, poissons_ratio: 0.3}\n",
     .quick = true, BOTH(REFUSED("rod.section", "its fourth power vanishes"))},
    {"number/force-1e300", PULL, SET("loads.tip.force=[1e300, 0, 0]"),
     BOTH(REFUSED("loads.tip.force", "beyond any load"))},
    {"number/force-1e-300", PULL, SET("loads.tip.force=[1e-300, 0, 0]"),
     PINN = SOLVED(1e-12, "as good as none: the rod stays straight"), SOLVER = EXACT},
    {"number/gravity-1e300", PULL, SET("loads.gravity=[1e300, 0, 0]", "reference.analytic=none"),
     BOTH(REFUSED("loads.gravity", "beyond any load"))},
    {"number/mass-1e300", PULL_MOVED, SET("rod.inertia.mass_per_length=1e300"),
     BOTH(REFUSED("rod.inertia.mass_per_length", "the unit of time overflows in a square"))},
    {"number/damping-1e300", PULL_MOVED, SET("rod.damping.curvature=[1e300, 1e300, 1e300]"),
     BOTH(REFUSED("rod.damping.curvature", "beyond any damping"))},
    {"number/drag-1e300", PULL_MOVED, SET("loads.drag=1e300"),
     BOTH(REFUSED("loads.drag", "beyond any drag"))},
    {"number/quadratic-drag-1e300", PULL_MOVED, SET("loads.quadratic_drag=1e300"),
     BOTH(REFUSED("loads.quadratic_drag", "beyond any drag"))},
    {"number/duration-1e300", PULL_MOVED, SET("time.duration=1e300", "loads.tip.force=[1, 0, 0]"),
     BOTH(REFUSED("time.duration", "beyond any motion"))},
    {"number/duration-1e-300", PULL_MOVED, SET("time.duration=1e-300"),
     BOTH(REFUSED("time.duration", "beyond any motion"))},
    {"number/wavenumber-1e300", PULL, SET("network.fourier.wavenumber=1e300"),
     PINN = REFUSED("network.fourier.wavenumber", "waves no point can resolve")},
    {"number/weight-1e300", PULL, SET("losses.interior.weights.strain=1e300"),
     PINN = REFUSED("losses.interior.weights.strain", "its square overflows")},
    {"number/overflow", PULL, SET("rod.length=1e400"),
     BOTH(REFUSED("rod.length", "no double holds it"))},
    {"number/nan", PULL, SET("loads.tip.force=[.nan, 0, 0]"),
     BOTH(REFUSED("loads.tip.force[0]", "not a number"))},
    {"number/formula-nan", PULL_MOVED, SET("loads.tip.force=[sqrt(t-2), 0, 0]"),
     BOTH(REFUSED("must be finite, and is not at t", "the root of a negative number"))},
    {"number/formula-nan-late", PULL_MOVED, SET("loads.tip.force=[sqrt(0.97-t), 0, 0]"),
     .solver_override = "rod.inertia.rotary=[1e-4, 1e-4, 2e-4]",
     PINN = STOPPED("not finite", "only where no check looks"),
     SOLVER = STOPPED("not finite", "the same")},
    {"number/formula-inf", PULL_MOVED, SET("loads.tip.force=[exp(1e4*t)-1, 0, 0]"),
     BOTH(REFUSED("loads.tip.force", "overflows within the duration"))},

    {"file/nan", BESIDE_PULL, .file = "s,x,y,z\n" ROW_0 ROW_1 "1,nan,0,0.9\n", .quick = true,
     PINN = AT_REST, SOLVER = EXACT}, /* a lost marker */
    {"file/infinity", BESIDE_PULL, .file = "s,x,y,z\n0,0,0,-inf\n" ROW_1, .quick = true,
     BOTH(REFUSED("reference.csv:2:7: ", "its line is named"))},
    {"file/overflow", BESIDE_PULL, .file = "s,x,y,z\n0,0,0,1e999\n" ROW_1, .quick = true,
     BOTH(REFUSED("reference.csv:2:7: ", "no double holds it"))},
    {"file/denormal", BESIDE_PULL, .file = "s,x,y,z\n5e-324,5e-324,1e-310,0\n" ROW_1, .quick = true,
     PINN = AT_REST, SOLVER = EXACT},
    {"file/duplicates", BESIDE_PULL, .file = "s,x,y,z\n" ROW_0 ROW_1 ROW_1 ROW_0 ROW_1,
     .quick = true, PINN = AT_REST, SOLVER = EXACT},
    {"file/empty", BESIDE_PULL, .file = "", .quick = true,
     BOTH(REFUSED("reference.csv", "there is nothing to compare with"))},
    {"file/no-rows", BESIDE_PULL, .file = "s,x,y,z\n", .quick = true,
     BOTH(REFUSED("there are no rows", "there is nothing to compare with"))},
    {"file/elsewhere", BESIDE_PULL, .file = "s,x,y,z\n2,0,0,0\n", .quick = true,
     BOTH(REFUSED("none of its 1 points lies in the scene", "another rod's file"))},
    {"file/origin-only", BESIDE_PULL, .file = "s,x,y,z\n" ROW_0, .quick = true,
     BOTH(REFUSED("reference.csv", "no error is relative to 0"))},
    {"file/quaternion-0", BESIDE_PULL, .file = "s,x,y,z,qw,qx,qy,qz\n1,0.3,0,0.9,0,0,0,0\n",
     .quick = true, BOTH(REFUSED("the quaternion qw, qx, qy, qz is 0", "no rotation"))},
    {"file/quaternion-1e-200", ROD BESIDE, .file = "s,x,y,z,qw,qx,qy,qz\n1,0,0,1,-1e-200,0,0,0\n",
     .measure = stress_rotation, .quick = true,
     PINN = SOLVED(1e-6, "rad; only its direction counts"), SOLVER = EXACT},
    {"file/huge", BESIDE_PULL, .file = "s,x,y,z\n1,1e300,0,0\n", .quick = true,
     BOTH(REFUSED("reference.csv", "its square overflows"))},

    {"network/two-points", PULL, SET("losses.interior.points=2"),
     PINN = WARNED(VERDICT_INTERPOLATES, "two points leave the rod between them free")},
    {"network/one-unit", PULL,
     SET("network.hidden=[1]", "training.stages=[{optimizer: adam, steps: 500}, "
                               "{optimizer: lbfgs, steps: 500}]"),
     PINN = WARNED(VERDICT_NOT_CONVERGED, "one hidden unit has not the shape of a rod")},
    {"network/one-feature", PULL, SET("network.fourier.features=1"),
     PINN = WARNED(VERDICT_NOT_CONVERGED, "one wave has not the shape of a rod")},
    {"training/rate-10", PULL,
     SET("network.hidden=[16]",
         "training.stages=[{optimizer: adam, steps: 500, learning_rate: 10}]"),
     PINN = WARNED(VERDICT_NOT_CONVERGED, "the best state is kept, but it is no solution")},
    {"training/rate-1e200", PULL,
     SET("network.hidden=[16]",
         "training.stages=[{optimizer: adam, steps: 500, learning_rate: 1e200}]"),
     PINN = STOPPED("try: resume with", "caught at once, with advice")},
    {"training/one-step-gentle", PULL,
     SET("training.stages=[{optimizer: adam, steps: 1}]", "network.hidden=[8]",
         "loads.tip.force=[1e-3, 0, 0]"),
     PINN = WARNED(VERDICT_NOT_CONVERGED, "nor when all residuals are small because the load is")},
    {"training/one-step", PULL,
     SET("training.stages=[{optimizer: adam, steps: 1}]", "network.hidden=[8]"),
     PINN = WARNED(VERDICT_NOT_CONVERGED, "a step is no training")},
};
const stress_group stress_inputs =
    GROUP("Input: numbers, files, networks, settings that cannot work", rows);
