/* Files that read well but do not make a scene, and the exact line each of them is refused with:
 * something is missing, or two settings contradict one another. */
#ifndef TESTS_CONFIG_REFUSALS_SCENE_H
#define TESTS_CONFIG_REFUSALS_SCENE_H

#include "config_refusals.h"

/* A dynamic one; what follows begins on line 6. */
#define DYNAMIC                                                                                    \
    BASE "  inertia: {mass_per_length: 1, rotary: [0.1, 0.1, 0.1]}\n"                              \
         "time: {duration: 1}\n"

/* One that the closed forms hold for; what follows begins on line 5. */
#define KIRCHHOFF                                                                                  \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  model: kirchhoff\n"                                                                         \
    "  stiffness: {bending: [1, 1], torsion: 0.8}\n"

static const refusal scene_refusals[] = {
    {DYNAMIC "formulation: strain\nnetwork: {hidden: [8]}\n", NULL,
     "scene.yaml:7:19: network.hidden: is not of a motion in the strain form, a linear network of "
     "time for each mode; leave it out, or take formulation: mixed"},
    {DYNAMIC "formulation: strain\nenforcement: {initial: soft}\n", NULL,
     "scene.yaml:7:24: enforcement.initial: formulation strain of a motion does not take soft "
     "conditions: its shapes meet the conditions exactly; allowed: formulation mixed, "
     "displacement, pose_strain"},
    {DYNAMIC "formulation: strain\nlosses: {interior: {points: 5}}\n", NULL,
     "scene.yaml:7:29: losses.interior.points: are 5 instants for 21 functions of time; allowed: "
     "as "
     "many at least"},
    {"rod:\n"
     "  length: 1\n",
     NULL,
     "scene.yaml:2:3: rod.stiffness.bending: missing; give rod.section and rod.material, or this "
     "stiffness itself"},
    {"rod:\n"
     "  section: {shape: circle}\n",
     NULL, "scene.yaml:2:3: rod.length: missing; the length of the undeformed rod in m"},
    {"boundary:\n"
     "  end: {type: free}\n",
     NULL, "scene.yaml:1:1: rod.length: missing; the length of the undeformed rod in m"},
    {"rod:\n"
     "  length: 1\n"
     "  section: {shape: circle, radius: 0.01}\n",
     NULL,
     "scene.yaml:2:3: rod.material.youngs_modulus: missing; the stiffness of the section follows "
     "from it"},
    {"rod:\n"
     "  length: 1\n"
     "  section: {shape: circle, radius: 0.01}\n"
     "  material: {youngs_modulus: 1e6}\n",
     NULL,
     "scene.yaml:4:13: rod.material.poissons_ratio: missing; shear and torsional stiffness follow "
     "from it"},
    {"rod:\n"
     "  length: 1\n"
     "  section: {shape: circle}\n",
     NULL, "scene.yaml:3:12: rod.section.radius: missing; the section's shape needs it"},
    {"rod:\n"
     "  length: 1\n"
     "  section: {shape: tube, radius: 0.01, inner_radius: 0.02}\n",
     NULL, "scene.yaml:3:54: rod.section.inner_radius: must be less than rod.section.radius"},
    {"rod:\n"
     "  length: 1\n"
     "  section: {shape: rectangle, width: 0.01, height: 0.02, radius: 0.1}\n",
     NULL,
     "scene.yaml:3:66: rod.section.radius: the section's shape has no such size; circle: radius, "
     "tube: radius and inner_radius, rectangle: width and height"},
    {"rod:\n"
     "  length: 1\n"
     "  model: kirchhoff\n"
     "  stiffness: {axial: 9, bending: [1, 1], torsion: 0.8}\n",
     NULL,
     "scene.yaml:4:22: rod.stiffness.axial: contradicts rod.model, which locks this strain; leave "
     "it out, or take model cosserat"},
    {"rod:\n"
     "  length: 1\n"
     "  model: kirchhoff\n"
     "  stiffness: {bending: [1, 1], torsion: 0.8}\n"
     "formulation: displacement\n",
     NULL,
     "scene.yaml:3:10: rod.model: formulation displacement does not take locked shear or stretch: "
     "its forces follow from the strains, and a locked strain gives none; allowed: formulation "
     "mixed, strain of a family"},
    {"rod:\n"
     "  length: 1\n"
     "  model: kirchhoff\n"
     "  stiffness: {bending: [1, 1], torsion: 0.8}\n"
     "formulation: pose_strain\n",
     NULL,
     "scene.yaml:3:10: rod.model: formulation pose_strain does not take locked shear or stretch: "
     "its forces follow from the strains, and a locked strain gives none; allowed: formulation "
     "mixed, strain of a family"},
    {"rod:\n"
     "  length: 1\n"
     "  model: euler_bernoulli\n"
     "  stiffness: {bending: [1, 1]}\n"
     "formulation: pose_strain\n",
     NULL,
     "scene.yaml:3:10: rod.model: formulation pose_strain does not take a beam of small "
     "deflection: a beam of small deflection is linear and has no shape in space; allowed: "
     "formulation mixed, displacement"},
    {"rod:\n"
     "  length: 1\n"
     "  stiffness: {shear: [5, 5], axial: 9, bending: [.inf, .inf], torsion: 0.8}\n",
     NULL, "scene.yaml:3:49: rod.stiffness.bending: at least one of the two must be finite"},
    {"rod:\n"
     "  length: 1\n"
     "  stiffness: {shear: [5, 5], axial: 9, bending: [1, 1], torsion: 0.8}\n"
     "  inertia: {mass_per_length: 1, rotary: [0, 0, 0]}\n"
     "  rest: {curvature: [500*s, 0, 0]}\n"
     "time: {duration: 1}\n",
     NULL,
     "scene.yaml:5:21: rod.rest.curvature: the unstressed shape winds too much, or bends too "
     "suddenly, to start from; give initial.position and initial.rotation"},
    {DYNAMIC, "rod.rest.imperfection=[0, 1, 0]",
     "override rod.rest.imperfection=[0, 1, 0]: rod.rest.imperfection: nothing takes an "
     "imperfection in motion: it goes as the loads of a rod at rest grow; allowed: a scene without "
     "it, or without time.duration"},
    {BASE "network: {hidden: [8]}\n", "rod.rest.imperfection=[0, 1, 0]",
     "override rod.rest.imperfection=[0, 1, 0]: rod.rest.imperfection: goes as the loads grow, "
     "which "
     "they do only for a network without hidden layers and gauss_newton; leave out network.hidden "
     "and training.stages, or this"},
    {BASE, "rod.rest.imperfection=[t, 0, 0]",
     "override rod.rest.imperfection=[t, 0, 0]: rod.rest.imperfection: depends on t, but it "
     "may not change with time; allowed: a formula of s"},
    {"rod:\n"
     "  length: 1\n"
     "  stiffness: {shear: [5, 5], axial: 9, bending: [1, 1], torsion: 0.8}\n"
     "  rest: {curvature: [t, 0, 0]}\n",
     NULL,
     "scene.yaml:4:21: rod.rest.curvature: nothing takes a formula of time at rest: a rod at rest "
     "does not change in time; allowed: a scene without it, or with time.duration"},
    {"rod:\n"
     "  length: 1\n"
     "  stiffness: {shear: [5, 5], axial: 9, bending: [1, 1], torsion: 0.8}\n"
     "  inertia: {mass_per_length: 1}\n"
     "time: {duration: 1}\n",
     NULL,
     "scene.yaml:4:12: rod.inertia.rotary: missing; give rho I about d1, d2, d3, or [0, 0, 0] to "
     "leave rotary inertia out"},
    {"rod:\n"
     "  length: 1\n"
     "  model: kirchhoff\n"
     "  stiffness: {bending: [1, 1], torsion: 0.8}\n"
     "manufactured: {position: [0, 0, s], angles: [s, 0, 0]}\n",
     NULL,
     "scene.yaml:3:10: rod.model: nothing takes a manufactured solution with locked strains at "
     "rest: its forces follow from the strains, and a locked strain gives none; allowed: a scene "
     "without it"},
    {"rod:\n"
     "  length: 1\n"
     "  section: {shape: circle, radius: 1e-2}\n"
     "  material: {youngs_modulus: 1e6, poissons_ratio: 0.7}\n",
     NULL,
     "scene.yaml:4:51: rod.material.poissons_ratio: is 0.7, which is out of range; allowed: a "
     "number or a formula > -1 and <= 0.5"},
    {"rod:\n"
     "  length: 1\n"
     "  section: {shape: circle, radius: 1e-2}\n"
     "  material: {youngs_modulus: 1e6, poissons_ratio: 0.3}\n"
     "loads: {gravity: [0, 0, -9.81]}\n",
     NULL, "scene.yaml:4:13: rod.material.density: missing; loads.gravity needs the rod's mass"},
    {BASE "loads: {tip: {force: [0, 0, t]}}\n", NULL,
     "scene.yaml:4:22: loads.tip.force: nothing takes a formula of time at rest: a rod at rest "
     "does not change in time; allowed: a scene without it, or with time.duration"},
    {BASE "loads: {tip: {force: [0, 0, s]}}\n", NULL,
     "scene.yaml:4:22: loads.tip.force: depends on s, but it belongs to one end; allowed: a "
     "formula of t"},
    {BASE "loads: {tip: {frame: follower}}\n", NULL,
     "scene.yaml:4:22: loads.tip.frame: follower, but there is no force or moment to follow; give "
     "one, or leave frame out"},
    {BASE "loads: {frame: follower}\n", NULL,
     "scene.yaml:4:16: loads.frame: follower, but there is no force or moment to follow; give one, "
     "or leave frame out"},
    {BASE "loads: {base: {force: [0, 0, 1]}}\n", NULL,
     "scene.yaml:4:23: loads.base.force: acts on an end that is held against it; allowed: an end "
     "of type loaded"},
    {BASE "loads: {tip: {force: [0, 0, 1]}}\n"
          "boundary: {end: {type: free}}\n",
     NULL,
     "scene.yaml:4:22: loads.tip.force: acts on an end declared free; allowed: an end of type "
     "loaded"},
    {BASE "boundary: {end: {type: loaded}}\n", NULL,
     "scene.yaml:4:24: boundary.end.type: loaded, but no load is given there; say free"},
    {BASE "boundary: {end: {type: clamped}}\n", NULL,
     "scene.yaml:4:17: boundary.end.position: missing; the type of this end needs it"},
    {BASE "boundary: {end: {type: free, position: [0, 0, 1]}}\n", NULL,
     "scene.yaml:4:40: boundary.end.position: is not held by an end of this type; leave it out, or "
     "take clamped, pinned (position) or driven"},
    {BASE "boundary: {end: {type: roller, position: [0, 0, 1]}}\n", NULL,
     "scene.yaml:4:17: boundary.end.along: missing; a roller slides along a direction, or across "
     "one; say pinned for none, free for all"},
    {BASE "boundary: {end: {type: roller, position: [0, 0, 1], along: [0, 0, 0]}}\n", NULL,
     "scene.yaml:4:60: boundary.end.along: is zero; allowed: a direction that is not zero"},
    {BASE "boundary: {end: {type: roller, along: [1, 0, 0]}}\n", NULL,
     "scene.yaml:4:17: boundary.end.position: missing; the type of this end needs it"},
    {BASE "boundary: {end: {type: roller, position: [0, 0, 1], along: [1, 0, 0], "
          "across: [1, 0, 0]}}\n",
     NULL,
     "scene.yaml:4:79: boundary.end.across: given beside along, and an end slides in one way; "
     "allowed: one of the two"},
    {BASE "boundary: {end: {type: clamped, position: [0, 0, 1], rotation: [1, 0, 0, 0], "
          "along: [1, 0, 0]}}\n",
     NULL,
     "scene.yaml:4:85: boundary.end.along: says how an end slides, and this one does not; allowed "
     "for it: an end of type guided or roller"},
    {BASE "boundary: {end: {type: guided, position: [0, 0, 1], rotation: [1, 0, 0, 0]}}\n"
          "loads: {tip: {moment: [1, 0, 0]}}\n",
     NULL,
     "scene.yaml:5:23: loads.tip.moment: acts on an end that does not turn; allowed: a force, or "
     "an end of type loaded or roller"},
    {BASE "boundary: {start: {type: roller, along: [0, 0, 1]}, "
          "end: {type: roller, along: [0, 0, 1], position: [0, 0, 1]}}\n",
     NULL,
     "scene.yaml:4:11: boundary: the ends leave this static rod free to move as a whole: all that "
     "slides can do so at once; hold one of them in this direction"},
    {BASE "loads: {foundation: [1, -1, 0]}\n", NULL,
     "scene.yaml:4:25: loads.foundation[1]: is -1, which is out of range; allowed: a number or a "
     "formula >= 0, in N/m^2"},
    {BASE "boundary: {start: {type: free}}\n", NULL,
     "scene.yaml:4:11: boundary: nothing holds the rod, so a static scene leaves its position and "
     "rotation open; clamp one end"},
    {BASE "boundary: {start: {type: pinned}}\n", NULL,
     "scene.yaml:4:11: boundary: one pinned end leaves the rotation of a static rod open; clamp "
     "one end"},
    {BASE "boundary: {start: {type: pinned}, end: {type: pinned, position: [0, 0, 1]}}\n"
          "motion: spatial\n",
     NULL,
     "scene.yaml:4:11: boundary: two pinned ends leave this static rod free to spin about the line "
     "between them; give gravity or a dead distributed load across it, or clamp one end"},
    {KIRCHHOFF "boundary: {end: {type: pinned, position: [0.8, 0, 0.7]}}\n", NULL,
     "scene.yaml:5:42: boundary.end.position: the held ends are farther apart than the rod is "
     "long, and rod.model or an infinite stiffness locks its stretch and shear"},
    {KIRCHHOFF
     "  inertia: {mass_per_length: 1, rotary: [0, 0, 0]}\n"
     "time: {duration: 2}\n"
     "boundary: {end: {type: driven, position: [0, 0, 1 + t^2], rotation: [1, 0, 0, 0]}}\n",
     NULL,
     "scene.yaml:7:42: boundary.end.position: the held ends are farther apart than the rod is "
     "long, and rod.model or an infinite stiffness locks its stretch and shear"},
    {KIRCHHOFF "  damping: {strain: [0, 0, 0.1]}\n", NULL,
     "scene.yaml:5:21: rod.damping.strain: damps a strain that rod.model or an infinite stiffness "
     "locks; allowed for it: 0"},
    {BASE "training: {stages: [{optimizer: lbfgs, stop: {error: 0.1}}]}\n", NULL,
     "scene.yaml:4:54: training.stages[0].stop.error: there is no reference to measure an error "
     "against; give reference.analytic, solve or file, or leave it out"},
    {BASE "reference: classical\n", NULL,
     "scene.yaml:4:12: reference: is a single value; allowed: solve, or a section with the keys "
     "analytic, solve, file, deflection"},
    {BASE "reference: {solve: solve}\n", NULL,
     "scene.yaml:4:20: reference.solve: is solve, which is not a number; allowed: a finite number "
     "1e-13 to 0.1"},
    {BASE "reference: {solve: 1, file: x.csv}\n", NULL,
     "scene.yaml:4:20: reference.solve: is 1, which is out of range; allowed: a finite number "
     "1e-13 "
     "to 0.1"},
    {BASE "reference: {analytic: elastica, solve: 1e-8}\n", NULL,
     "scene.yaml:4:40: reference.solve: given beside another reference; allowed: one of them"},
    {BASE "reference: solve\n", "reference.file=x.csv",
     "scene.yaml:4:12: reference.solve: given beside another reference; allowed: one of them"},
    {BASE "reference: solve\n", "rod.rest.imperfection=[0, 0.1, 0]",
     "scene.yaml:4:12: reference.solve: does not follow rod.rest.imperfection; give "
     "reference.file"},
    {BASE "training: {stages: [{optimizer: adam, steps: 9, warmup_steps: 10}]}\n", NULL,
     "scene.yaml:4:63: training.stages[0].warmup_steps: 10 steps are more than the 9 steps of the "
     "stage"},
    {BASE "losses: {interior: {weights: {strain: 0, curvature: 0, force: 0, moment: 0}}}\n", NULL,
     "scene.yaml:4:30: losses.interior.weights: every loss term of this scene has weight 0: "
     "nothing to learn"},
    {BASE "boundary: {start: {rotation: [0, 0, 0, 0]}}\n", NULL,
     "scene.yaml:4:30: boundary.start.rotation: is zero; allowed: a quaternion (w, x, y, z) that "
     "is not zero"},
    {BASE "boundary: {start: {position: [0, 0, s]}}\n", NULL,
     "scene.yaml:4:30: boundary.start.position: depends on s, but it belongs to one end; allowed: "
     "a formula of t"},
    {BASE "boundary: {start: {position: [0, 0, t]}}\n"
          "time: {duration: 1}\n",
     NULL,
     "scene.yaml:4:30: boundary.start.position: depends on t, but the end stands still; allowed: "
     "numbers, or an end of type driven"},
    {BASE "loads: {tip: {moment: [0, 1, 0]}}\n"
          "boundary: {end: {type: pinned, position: [0, 0, 1]}}\n",
     NULL,
     "scene.yaml:4:23: loads.tip.moment: acts on an end that is held against it; allowed: an end "
     "of type loaded"},
    {BASE "initial: {velocity: [0, 0, 1]}\n", NULL,
     "scene.yaml:4:21: initial.velocity: nothing takes a given state at t = 0 at rest: a rod at "
     "rest does not change in time; allowed: a scene without it, or with time.duration"},
    {BASE "time: {duration: 1}\n", NULL,
     "scene.yaml:2:3: rod.inertia.mass_per_length: missing; a dynamic scene needs the rod's mass"},
    {BASE "time: {windows: 4}\n", NULL,
     "scene.yaml:4:17: time.windows: windows divide the duration, but the scene is static; give "
     "time.duration, or leave it out"},
    {DYNAMIC "enforcement: {initial: soft}\n", "time.windows=2",
     "override time.windows=2: time.windows: every window starts exactly where the one before "
     "ends, "
     "but the initial state is soft; take enforcement.initial hard, or 1 window"},
    {DYNAMIC, "time.windows=1025",
     "override time.windows=1025: time.windows: is 1025, which is out of range; allowed: a whole "
     "number 1 to 1024"},
    {BASE "losses: {causal: {slices: 4}}\n", NULL,
     "scene.yaml:4:27: losses.causal.slices: causal weighting follows time, but the scene is "
     "static; give time.duration, or leave it out"},
    {BASE "losses: {balance: gradient_norm}\n"
          "training: {stages: [{optimizer: lbfgs}, {optimizer: gauss_newton}]}\n",
     NULL,
     "scene.yaml:4:19: losses.balance: weights are moved in stages of adam, and training.stages "
     "has "
     "none; give one, or leave it out"},
    {DYNAMIC "network: {rotation: six}\n", "time.windows=2",
     "scene.yaml:6:21: network.rotation: six numbers leave the sign of the quaternion open, which "
     "windows of time hand on; allowed with time.windows above 1: quaternion, vector"},
    {BASE "losses: {interior: {resample_every: 50, adaptive: {kind: rad}}}\n", NULL,
     "scene.yaml:4:58: losses.interior.adaptive.kind: given beside losses.interior.resample_every, "
     "for which points have to stay; allowed: one of the two"},
    {BASE "losses: {interior: {points: 1, sampler: chebyshev}}\n", NULL,
     "scene.yaml:4:29: losses.interior.points: 1 points are too few for a tensor grid in 1 "
     "dimensions"},
    {BASE "manufactured: {angles: [s, s, s]}\n", NULL,
     "scene.yaml:4:15: manufactured.position: missing; a manufactured solution needs the position"},
    {BASE "manufactured: {position: [0, 0, s]}\n", NULL,
     "scene.yaml:4:15: manufactured.rotation: missing; give rotation or angles"},
    {BASE "manufactured: {position: [0, 0, s], angles: [s, 0, 0]}\n"
          "loads: {force: [0, 0, 1]}\n",
     NULL, "scene.yaml:5:16: loads.force: follows from the manufactured solution; leave it out"},
    {BASE "manufactured: {position: [0, 0, s], angles: [s, 0, 0]}\n"
          "boundary: {start: {position: [0, 0, 0]}}\n",
     NULL,
     "scene.yaml:5:30: boundary.start.position: follows from the manufactured solution; leave it "
     "out"},
    {BASE "manufactured: {position: [0, 0, s], angles: [s, 0, 0], rotation: [1, 0, 0, 0]}\n", NULL,
     "scene.yaml:4:45: manufactured.angles: given beside rotation; allowed: one of the two"},
    {BASE "manufactured: {position: [0, 0, s], angles: [s, 0, 0]}\n"
          "loads: {tip: {force: [0, 0, 1]}}\n",
     NULL, "scene.yaml:5:14: loads.tip: follows from the manufactured solution; leave it out"},
    {BASE "reference: {analytic: elastica}\n", NULL,
     "scene.yaml:4:23: reference.analytic: needs a clamped start and a loaded end"},
    {BASE "reference: {analytic: manufactured}\n", NULL,
     "scene.yaml:4:23: reference.analytic: needs the section manufactured"},
    {BASE "reference: {file: /nothing/here.csv}\n", NULL,
     "scene.yaml:4:19: reference.file: /nothing/here.csv is not a file; paths are relative to the "
     "scene file"},
    {BASE "reference: {analytic: rollup, file: a.csv}\n", NULL,
     "scene.yaml:4:23: reference.analytic: given beside reference.file; allowed: one of the two"},
    {BASE "reference: {analytic: circle}\n", NULL,
     "scene.yaml:4:23: reference.analytic: is circle; allowed: one of none, elastica, rollup, "
     "helix, manufactured"},
    {BASE "reference: {analytic: elastica}\n"
          "loads: {tip: {force: [1, 0, 0]}}\n",
     NULL,
     "scene.yaml:4:23: reference.analytic: needs rod.model kirchhoff, without shear and stretch"},
    {BASE "reference: {analytic: rollup}\n"
          "loads: {tip: {force: [1, 0, 0]}}\n",
     NULL, "scene.yaml:4:23: reference.analytic: needs a tip moment without a force"},
    {BASE "reference: {analytic: rollup}\n"
          "loads: {tip: {moment: [1, 0, 1]}}\n",
     NULL,
     "scene.yaml:4:23: reference.analytic: needs a tip moment perpendicular to the clamped "
     "tangent; helix allows any"},
    {BASE "reference: {analytic: helix}\n"
          "loads: {tip: {moment: [1, 0, 1], frame: follower}}\n",
     NULL, "scene.yaml:4:23: reference.analytic: needs a dead load at the tip"},
    {DYNAMIC "boundary: {start: {position: [0, 0, t]}}\n", NULL,
     "scene.yaml:6:30: boundary.start.position: depends on t, but the end stands still; allowed: "
     "numbers, or an end of type driven"},
    {DYNAMIC "boundary: {start: {type: driven, position: [0, 0, s]}}\n", NULL,
     "scene.yaml:6:44: boundary.start.position: depends on s, but it belongs to one end; allowed: "
     "a formula of t"},
    {DYNAMIC "initial: {position: [0, 0, t], rotation: [1, 0, 0, 0]}\n", NULL,
     "scene.yaml:6:21: initial.position: depends on t, but it holds at t = 0; allowed: a formula "
     "of s"},
    {DYNAMIC "initial: {position: [0, 0, s]}\n", NULL,
     "scene.yaml:6:10: initial.rotation: missing; position and rotation at t = 0 come together or "
     "not at all"},
    {DYNAMIC "boundary: {start: {type: free}}\n", NULL,
     "scene.yaml:1:1: initial.position: missing; without a clamped or driven end the pose at t = 0 "
     "is unknown"},
    {DYNAMIC "reference: {analytic: helix}\n"
             "loads: {tip: {moment: [1, 0, 1]}}\n",
     NULL, "scene.yaml:6:23: reference.analytic: is a static shape, but the scene has a duration"},
    {DYNAMIC "manufactured: {position: [0, 0, s], angles: [s, 0, 0]}\n"
             "initial: {velocity: [0, 0, 0]}\n",
     NULL, "scene.yaml:7:10: initial: follows from the manufactured solution; leave it out"},
    {DYNAMIC "losses: {interior: {points: 3, sampler: grid}}\nformulation: mixed\n", NULL,
     "scene.yaml:6:29: losses.interior.points: 3 points are too few for a tensor grid in 2 "
     "dimensions"},
    {KIRCHHOFF "reference: {analytic: elastica}\n"
               "loads: {tip: {force: [0, 1, 1]}}\n",
     NULL,
     "scene.yaml:5:23: reference.analytic: needs a tip force perpendicular to the clamped tangent"},
    {KIRCHHOFF "reference: {analytic: elastica}\n"
               "loads: {tip: {force: [0, 1, 0], moment: [0, 1, 0]}}\n",
     NULL, "scene.yaml:5:23: reference.analytic: needs a tip force without a moment"},
    {KIRCHHOFF "reference: {analytic: elastica}\n"
               "loads: {tip: {force: [0, 1, 0]}, force: [0, 0, 1]}\n",
     NULL,
     "scene.yaml:5:23: reference.analytic: needs a rod without gravity and distributed loads"},
    {KIRCHHOFF "reference: {analytic: elastica}\n"
               "loads: {tip: {force: [0, 1, 0], frame: follower}}\n",
     NULL, "scene.yaml:5:23: reference.analytic: needs a dead load at the tip"},
    {KIRCHHOFF "reference: {analytic: elastica}\n"
               "loads: {tip: {force: [0, 0, 0]}}\n",
     NULL, "scene.yaml:5:23: reference.analytic: needs a tip force that is not zero"},
    {BASE, "rod.length=1e-300",
     "override rod.length=1e-300: rod.length: the rod's length is 1e-300 m, beyond what can be "
     "computed with; allowed: 1e-30 to 1e+30"},
    {BASE, "rod.stiffness.bending=[1e100, 1e100]",
     "override rod.stiffness.bending=[1e100, 1e100]: rod.stiffness.bending: the rod's bending "
     "stiffness is 1e+100 N m^2, beyond what can be computed with; allowed: 1e-60 to 1e+60"},
    {BASE, "rod.stiffness.torsion=1e-20",
     "override rod.stiffness.torsion=1e-20: rod.stiffness.torsion: G J/EI is 1e-20, beyond what "
     "can "
     "be computed with; allowed: 1e-12 to 1e+30"},
    {BASE, "loads.tip.force=[1e20, 0, 0]",
     "override loads.tip.force=[1e20, 0, 0]: loads.tip.force: F L^2/EI is 1e+20, beyond what can "
     "be "
     "computed with; allowed: 0 to 1e+12"},
    {DYNAMIC, "loads.quadratic_drag=1e300",
     "override loads.quadratic_drag=1e300: loads.quadratic_drag: damping of the first bending mode "
     "is "
     "5e+299, beyond what can be computed with; allowed: 0 to 1e+12"},
    {DYNAMIC, "time.duration=1e-20",
     "override time.duration=1e-20: time.duration: the rod's motion is 1e-20 L^2 (rhoA/EI)^(1/2) "
     "long, beyond what can be computed with; allowed: 1e-12 to 1e+12"},
    {DYNAMIC, "time.duration=1000",
     "override time.duration=1000: time.duration: would take 6e+03 windows of 1/11 of a period "
     "of the first bending mode; allowed: up to 1024, here 171 s, or longer windows, given by "
     "time.windows"},
    {BASE, "network.fourier.wavenumber=1e9",
     "override network.fourier.wavenumber=1e9: network.fourier.wavenumber: is 5e+08 radians in "
     "half "
     "the length, more than points can resolve; allowed: up to 100000"},
    {BASE, "losses.interior.weights.strain=1e20",
     "override losses.interior.weights.strain=1e20: losses.interior.weights.strain: is 1e20, which "
     "is "
     "out of range; allowed: a finite number 0 to 1000000000000"},
    {BASE "motion: planar\n"
          "loads: {tip: {force: [1, 1, 0]}}\n",
     NULL,
     "scene.yaml:4:9: motion: is planar, but loads.tip.force leaves the plane; allowed: automatic, "
     "spatial"},
    {BASE "motion: planar\n"
          "manufactured: {position: [0, 0, s], angles: [s, 0, 0]}\n",
     NULL,
     "scene.yaml:4:9: motion: is planar, but manufactured leaves the plane; allowed: automatic, "
     "spatial"},
};

#endif
