/* Lists of a scene that are refused - segments, points, bodies, springs, tendons, chambers, tubes -
 * and the exact line each is refused with. */
#ifndef TESTS_CONFIG_REFUSALS_LISTS_H
#define TESTS_CONFIG_REFUSALS_LISTS_H

#include "config_refusals_beam.h"

/* A rod of a section; what follows begins on line 4. */
#define MATERIAL                                                                                   \
    "rod:\n"                                                                                       \
    "  section: {shape: circle, radius: 0.01}\n"                                                   \
    "  material: {youngs_modulus: 1e6, poissons_ratio: 0.5, density: 1000}\n"

/* The innermost of tubes; what follows begins on line 4. */
#define CONCENTRIC                                                                                 \
    "rod: {model: kirchhoff,\n"                                                                    \
    "  length: 1,\n"                                                                               \
    "  stiffness: {bending: [1, 1], torsion: 1}}\n"

static const refusal list_refusals[] = {
    {BASE "segments: {length: 1}\n", NULL,
     "scene.yaml:4:11: segments: is not a list; allowed: a list of 0 to 12 segments"},
    {BASE "segments: [{length: 0.4}, {length: 0.7}]\n", NULL,
     "scene.yaml:2:11: rod.length: is 1 m, but the segments are 1.1 m long together; allowed: the "
     "same, or segments alone"},
    {BASE "segments: [{length: 0.4}, {stiffness: {axial: 3}}]\n", NULL,
     "scene.yaml:4:27: segments[1].length: missing; the length of this piece of the rod in m"},
    {BASE "segments: [{length: -1}, {length: 2}]\n", NULL,
     "scene.yaml:4:21: segments[0].length: is -1, which is out of range; allowed: a number or a "
     "formula > 0, in m"},
    {BASE "segments: [{length: 1, turn: [1, 0, 0]}]\n", NULL,
     "scene.yaml:4:30: segments[0].turn: turns the first piece, which has none before it; leave it "
     "out, or give boundary.start.rotation"},
    {BASE "segments: [{length: 0.5}, {length: 0.5, turn: [s, 0, 0]}]\n", NULL,
     "scene.yaml:4:47: segments[1].turn: depends on s or t; allowed: one number"},
    {BASE "segments: [{length: 0.5}, {length: 0.5, section: {shape: circle, radius: 0.01}}]\n",
     NULL,
     "scene.yaml:4:27: segments[1].stiffness.shear: is given under rod, in place of what follows "
     "from the section and material of this piece; give it here, too, or not there"},
    {BASE "segments: [{length: 0.5}, {length: 0.5, stiffness: {axial: \"s - 0.7\"}}]\n", NULL,
     "scene.yaml:4:60: segments[1].stiffness.axial: must be > 0; .inf locks that strain"},
    {BASE
     "segments: [{length: 1}, {length: 1}, {length: 1}, {length: 1}, {length: 1}, {length: 1}, "
     "{length: 1}, {length: 1}, {length: 1}, {length: 1}, {length: 1}, {length: 1}, {length: 1}]\n",
     NULL, "scene.yaml:4:11: segments: is too long; allowed: a list of 0 to 12 segments"},
    {BASE, "segments[0].length=1",
     "override segments[0].length=1: segments[0].length: no such segment, the list is empty; give "
     "all "
     "of segments"},
    {BASE "segments: [{length: 1}]\n", "segments[1].length=1",
     "override segments[1].length=1: segments[1].length: no such segment; allowed: 0 to 0"},
    {BASE "segments: [{length: 1, radius: 3}]\n", NULL,
     "scene.yaml:4:24: segments[0].radius: unknown key; did you mean segments[0].section.radius?"},
    {BASE "segments: [{length: 1, stiffness: {axial: 0}}]\n", NULL,
     "scene.yaml:4:43: segments[0].stiffness.axial: is 0, which is out of range; allowed: a number "
     "or a formula > 0 or .inf, in N"},
    {MATERIAL "segments: [{length: 1}, {length: 1, section: {shape: rectangle, width: 1}}]\n", NULL,
     "scene.yaml:4:46: segments[1].section.height: missing; the section's shape needs it"},
    {MATERIAL "segments: [{length: 1}, {length: 1, section: {width: 1}}]\n", NULL,
     "scene.yaml:4:54: segments[1].section.width: the section's shape has no such size; circle: "
     "radius, tube: radius and inner_radius, rectangle: width and height"},
    {MATERIAL "segments: [{length: 1}, {length: 1, section: {radius: \"0.1*(1.5 - s)\"}}]\n", NULL,
     "scene.yaml:4:55: segments[1].section.radius: must be finite and > 0 all along"},
    {MATERIAL
     "segments: [{length: 1}, {length: 1, material: {viscosity: 1, relaxation_time: 1}}]\n",
     NULL,
     "scene.yaml:4:79: segments[1].material.relaxation_time: given beside rod.material.viscosity; "
     "allowed: one of the two"},
    {MATERIAL "segments: [{length: 1}, {length: 1, material: {maxwell: {ratio: 0.2}}}]\n", NULL,
     "scene.yaml:4:57: segments[1].material.maxwell.time: missing; a time in s"},
    {BASE "loads: {points: [{at: 1, force: [0, 0, 1]}]}\n", NULL,
     "scene.yaml:4:23: loads.points[0].at: is not within the rod; allowed: 0 < at < length, and at "
     "the ends loads.base, loads.tip"},
    {BASE "loads: {points: [{force: [0, 0, 1]}]}\n", NULL,
     "scene.yaml:4:18: loads.points[0].at: missing; a place along the rod in m"},
    {BASE "loads: {points: [{at: 0.5}]}\n", NULL,
     "scene.yaml:4:23: loads.points[0].at: neither a force nor a moment is given there"},
    {BASE "loads: {points: [{at: 0.5, force: [0, s, 1]}]}\n", NULL,
     "scene.yaml:4:35: loads.points[0].force: depends on s, but it belongs to one place; allowed: "
     "a formula of t"},
    {BASE "loads: {points: [{at: 0.5, force: [0, t, 1]}]}\n", NULL,
     "scene.yaml:4:35: loads.points[0].force: nothing takes a formula of time at rest: a rod at "
     "rest does not change in time; allowed: a scene without it, or with time.duration"},
    {BASE "loads: {points: [{at: 0.5, force: [0, .inf, 1]}]}\n", NULL,
     "scene.yaml:4:39: loads.points[0].force[1]: is .inf, which is not finite; allowed: a number "
     "or a formula, in N"},
    {BASE "loads: {points: [{at: 0.5, force: [0, 1, \"1 +\"]}]}\n", NULL,
     "scene.yaml:4:42: loads.points[0].force[2]: column 4 of '1 +': the formula ends where a "
     "number, a name or ( is expected"},
    {BASE "loads: {points: [{at: 0.5, forc: [0, 1, 1]}]}\n", NULL,
     "scene.yaml:4:28: loads.points[0].forc: unknown key; did you mean loads.points[0].force?"},
    {BASE "loads: {points: 5}\n", NULL,
     "scene.yaml:4:17: loads.points: is not a list; allowed: a list of 0 to 16 points"},
    {BASE "loads: {points: [{at: 0.5, force: [0, 1, 1]}]}\n", "loads.points[0].force[3]=1",
     "override loads.points[0].force[3]=1: loads.points[0].force: the list is shorter; entries "
     "count "
     "from 0"},
    {BASE "bodies: [{at: 1.5, mass: 1}]\n", NULL,
     "scene.yaml:4:15: bodies[0].at: lies beyond the rod; allowed: 0 to its length"},
    {BASE "bodies: [{at: 1}]\n", NULL,
     "scene.yaml:4:10: bodies[0].mass: missing; the mass of the body in kg"},
    {BASE "bodies: [{at: 1, mass: -1}]\n", NULL,
     "scene.yaml:4:24: bodies[0].mass: is -1, which is out of range; allowed: a number or a "
     "formula >= 0, in kg"},
    {BASE "springs: [{at: 1}]\n", NULL,
     "scene.yaml:4:11: springs[0].stiffness: missing; a spring has a stiffness, or one against "
     "turning"},
    {BASE "springs: [{at: 1, stiffness: [1, -1, 0]}]\n", NULL,
     "scene.yaml:4:34: springs[0].stiffness[1]: is -1, which is out of range; allowed: a number or "
     "a formula >= 0, in N/m"},
    {BASE "tendons: [{tension: 1}]\n", NULL,
     "scene.yaml:4:11: tendons[0].offset: missing; two numbers or formulas of s along d1 and d2, "
     "in m"},
    {BASE "tendons: [{offset: [0.01, 0], tension: 1, end: 1.01}]\n", NULL,
     "scene.yaml:4:48: tendons[0].end: ends beyond the rod; allowed: 0 to its length"},
    {BASE "tendons: [{offset: [0.01, 0], tension: 1, start: 0.5, end: 0.3}]\n", NULL,
     "scene.yaml:4:60: tendons[0].end: it ends before it begins; allowed: start < end"},
    {BASE "tendons: [{offset: [0.01, 0]}]\n", NULL,
     "scene.yaml:4:11: tendons[0].tension: missing; give tension or displacement"},
    {BASE "tendons: [{offset: [0.01, 0], tension: 1, displacement: 0.1}]\n", NULL,
     "scene.yaml:4:57: tendons[0].displacement: given beside tension; allowed: one of the two"},
    {BASE "tendons: [{offset: [0.01, 0], tension: 1, stiffness: 5}]\n", NULL,
     "scene.yaml:4:54: tendons[0].stiffness: is that of a tendon with a displacement; leave it "
     "out"},
    {BASE "tendons: [{offset: [0.01, 0], displacement: 1, stiffness: 0}]\n", NULL,
     "scene.yaml:4:59: tendons[0].stiffness: is 0, which is out of range; allowed: a number or a "
     "formula > 0, in N/m"},
    {DYNAMIC "tendons: [{offset: [0.01, 0], displacement: 0.01}]\n", NULL,
     "scene.yaml:6:45: tendons[0].displacement: nothing takes a tendon that keeps its length in "
     "motion: it is not built yet; allowed: a scene without it, or without time.duration"},
    {DYNAMIC "tendons: [{offset: [0.01, 0], tension: 1, friction: 0.1, creep_speed: 0}]\n", NULL,
     "scene.yaml:6:71: tendons[0].creep_speed: is 0, which is out of range; allowed: a number or a "
     "formula > 0, in m/s"},
    {BASE "tendons: [{offset: [0.01, 0], tension: -1}]\n", NULL,
     "scene.yaml:4:40: tendons[0].tension: is -1, which is out of range; allowed: a number or a "
     "formula >= 0, in N"},
    {DYNAMIC "tendons: [{offset: [0.01, 0], tension: \"sin(2*pi*t)\"}]\n", NULL,
     "scene.yaml:6:40: tendons[0].tension: must be finite and >= 0"},
    {BASE "tendons: [{offset: [\"10*s\", 0], tension: 1}]\n", NULL,
     "scene.yaml:4:20: tendons[0].offset: is farther from the axis than the rod is long; it is in "
     "m"},
    {BASE "tendons: [{offset: [0.01, 0], tension: 1, friction: -0.1}]\n", NULL,
     "scene.yaml:4:53: tendons[0].friction: is -0.1, which is out of range; allowed: a number or a "
     "formula >= 0"},
    {CONCENTRIC "tubes: [{stiffness: {bending: [1, 1], torsion: 1}, end: 1.01}]\n", NULL,
     "scene.yaml:4:57: tubes[0].end: is not on the rod, which reaches farther than every tube; "
     "allowed: above 0 up to its length"},
    {CONCENTRIC "tubes: [{stiffness: {bending: [1, 0], torsion: 1}}]\n", NULL,
     "scene.yaml:4:35: tubes[0].stiffness.bending[1]: is 0, which is out of range; allowed: a "
     "number or a formula > 0, in N m^2"},
    {CONCENTRIC "tubes: [{stiffness: {bending: [1, 1]}}]\n", NULL,
     "scene.yaml:4:21: tubes[0].stiffness.torsion: missing; give section and material, or this "
     "stiffness itself"},
    {CONCENTRIC "tubes: [{section: {radius: 0.01}}]\n", NULL,
     "scene.yaml:4:19: tubes[0].section.inner_radius: missing; a tube has a radius and an "
     "inner_radius"},
    {CONCENTRIC "tubes: [{section: {radius: 0.01, inner_radius: 0.01}}]\n", NULL,
     "scene.yaml:4:48: tubes[0].section.inner_radius: must be less than the tube's radius"},
    {CONCENTRIC "tubes: [{section: {radius: 0.01, inner_radius: 0.009}}]\n", NULL,
     "scene.yaml:4:9: tubes[0].material.youngs_modulus: missing; the stiffness of the section "
     "follows from it"},
    {CONCENTRIC "tubes: [{stiffness: {bending: [1, 1], torsion: 1}}]\n"
                "loads: {gravity: [0, 0, -9.81]}\n",
     "rod.inertia.mass_per_length=1",
     "scene.yaml:4:9: tubes[0].inertia.mass_per_length: missing; loads.gravity needs the mass of "
     "every tube"},
    {CONCENTRIC "tubes: [{stiffness: {bending: [1, 1], torsion: 1}}]\n"
                "time: {duration: 1}\n",
     "rod.inertia={mass_per_length: 1, rotary: [0, 0, 0]}",
     "scene.yaml:4:8: tubes: nothing takes concentric tubes in motion: it is not built yet; "
     "allowed: a scene without it, or without time.duration"},
    {CONCENTRIC "tubes: [{stiffness: {bending: [1, 1], torsion: 1}}]\n"
                "boundary: {start: {type: pinned}}\n",
     NULL,
     "scene.yaml:5:26: boundary.start.type: tubes are turned against a base that is held; allowed "
     "with tubes: clamped"},
    {CONCENTRIC "tubes: [{stiffness: {bending: [1, 1], torsion: 1}}]\n"
                "segments: [{length: 0.5}, {length: 0.5, turn: [1, 0, 0]}]\n",
     NULL,
     "scene.yaml:5:47: segments[1].turn: tubes do not go round a corner; allowed with tubes: no "
     "turn"},
    {BASE "tubes: [{stiffness: {bending: [1, 1], torsion: 1}}]\n", NULL,
     "scene.yaml:2:3: rod.model: tubes slide on the rod and take no shear and stretch from it; "
     "allowed with tubes: kirchhoff"},
    {BASE "chambers: [{offset: [0.01, 0], pressure: 1}]\n", NULL,
     "scene.yaml:4:12: chambers[0].area: missing; the area of the chamber's cross-section in m^2"},
    {BASE "chambers: [{offset: [0.01, 0], area: 1}]\n", NULL,
     "scene.yaml:4:12: chambers[0].pressure: missing; its pressure in Pa"},
    {BASE "chambers: [{offset: [0.01, 0], pressure: 1, area: 0}]\n", NULL,
     "scene.yaml:4:51: chambers[0].area: is 0, which is out of range; allowed: a number or a "
     "formula > 0, in m^2"},
    {BASE "chambers: [{offset: [0.01, 0], pressure: 1, area: 1, start: -0.1}]\n", NULL,
     "scene.yaml:4:61: chambers[0].start: begins beyond the rod; allowed: 0 to its length"},
    {BASE "manufactured: {position: [0, 0, s], angles: [s, 0, 0]}\n"
          "bodies: [{at: 1, mass: 1}]\n",
     NULL,
     "scene.yaml:5:15: bodies[0].at: makes the rod jump somewhere, but a manufactured solution is "
     "smooth; leave it out"},
    {BASE "manufactured: {position: [0, 0, s], angles: [s, 0, 0]}\n"
          "tendons: [{offset: [0, 0.1], tension: 1, end: 0.7}]\n",
     NULL,
     "scene.yaml:5:20: tendons[0].offset: makes the rod jump somewhere, but a manufactured "
     "solution "
     "is smooth; leave it out"},
    {BASE "motion: planar\n"
          "tendons: [{offset: [0.01, 0.01], tension: 1}]\n",
     NULL,
     "scene.yaml:4:9: motion: is planar, but tendons[0].offset leaves the plane; allowed: "
     "automatic, spatial"},
    {BASE "motion: planar\n"
          "segments: [{length: 0.5}, {length: 0.5, turn: [0, 0, 1]}]\n",
     NULL,
     "scene.yaml:4:9: motion: is planar, but segments[1].turn leaves the plane; allowed: "
     "automatic, spatial"},
    {BASE "motion: planar\n"
          "springs: [{at: 1, stiffness: [1, 0, 0], anchor: [0, 1, 1]}]\n"
          "loads: {tip: {force: [1, 0, 0]}}\n",
     NULL,
     "scene.yaml:4:9: motion: is planar, but springs[0].anchor leaves the plane; allowed: "
     "automatic, spatial"},
    {BASE "boundary: {end: {type: clamped, position: [0, 0, 1], rotation: [1, 0, 0, 0], "
          "rotation_vector: [3, 0, 0]}}\n",
     NULL,
     "scene.yaml:4:95: boundary.end.rotation_vector: given beside rotation; allowed: one of the "
     "two"},
    {BASE "boundary: {start: {type: pinned}, end: {type: clamped, position: [0, 0, 1], "
          "rotation_vector: [3, 0, 0]}}\n",
     NULL,
     "scene.yaml:4:94: boundary.end.rotation_vector: turns the end from where the unstressed rod "
     "ends, but the end s = 0 is not held; clamp it, or give rotation"},
    {BASE "boundary: {end: {type: pinned, position: [0, 0, 1], rotation_vector: [3, 0, 0]}}\n",
     NULL,
     "scene.yaml:4:70: boundary.end.rotation_vector: is not held by an end of this type; leave it "
     "out, or take clamped, pinned (position) or driven"},
    {BASE "boundary: {end: {type: pinned, position: [0, 0, 1], twist: 3}}\n", NULL,
     "scene.yaml:4:60: boundary.end.twist: is not held by an end of this type; leave it out, or "
     "take clamped, pinned (position) or driven"},
    {BASE "motion: planar\n"
          "boundary: {end: {type: clamped, position: [0, 0, 1], rotation: [1, 0, 0, 0], "
          "twist: 3}}\n",
     NULL,
     "scene.yaml:4:9: motion: is planar, but boundary.end.twist leaves the plane; allowed: "
     "automatic, spatial"},
    {BASE "beam: {points: [{at: 0.5, force: 1}]}\n", NULL,
     "scene.yaml:4:22: beam.points[0].at: belongs to a beam of small deflection; leave it out, or "
     "take rod.model euler_bernoulli or timoshenko"},
    {BEAM "loads: {points: [{at: 0.5, force: [0, 1, 0]}]}\n", NULL,
     "scene.yaml:5:23: loads.points[0].at: acts on a rod in space; a beam has beam.points"},
    {BEAM "bodies: [{at: 0.5, mass: 1, offset: [0, 0.1, 0]}]\n", NULL,
     "scene.yaml:5:37: bodies[0].offset: is of rods; allowed: a body of a beam whose centre is on "
     "it"},
    {BEAM "bodies: [{at: 0.5, mass: 1, magnetic_moment: [0, 0, 1]}]\n", NULL,
     "scene.yaml:5:46: bodies[0].magnetic_moment: is of rods; allowed: a body of a beam without "
     "it"},
    {BEAM "springs: [{at: 0.5, stiffness: [1, 1, 1]}]\n", NULL,
     "scene.yaml:5:32: springs[0].stiffness: acts across or along the beam, which deflects along "
     "d2 alone; allowed: [0, k, 0]"},
    {BEAM "springs: [{at: 0.5, turning: [1, 1, 1]}]\n", NULL,
     "scene.yaml:5:30: springs[0].turning: acts about d2 or d3, but a beam turns about d1 alone; "
     "allowed: [k, 0, 0]"},
    {BEAM "springs: [{at: 0.5, stiffness: [0, 1, 0], anchor: [0, 0, 0.5]}]\n", NULL,
     "scene.yaml:5:51: springs[0].anchor: is a deflection along d2 for a beam; allowed: [0, w, 0]"},
    {BEAM "boundary: {start: {type: free}}\n"
          "springs: [{at: 0.5, stiffness: [0, 1, 0]}]\n",
     NULL,
     "scene.yaml:5:11: boundary: a static beam with these ends is free to move; clamp one, pin "
     "both, or give beam.foundation"},
    {BASE "boundary: {start: {type: free}}\n"
          "springs: [{at: 0.5, stiffness: [1, 1, 1]}]\n",
     NULL,
     "scene.yaml:4:11: boundary: one place that is held leaves the rotation of a static rod open; "
     "clamp one end, or give springs.turning"},
    {BASE "boundary: {start: {type: free}}\n"
          "springs: [{at: 0.3, stiffness: [1, 1, 1]}, {at: 0.1 + 0.2, stiffness: [1, 1, 1]}]\n",
     NULL,
     "scene.yaml:4:11: boundary: one place that is held leaves the rotation of a static rod open; "
     "clamp one end, or give springs.turning"},
    {BEAM "boundary: {start: {type: free}}\n"
          "springs: [{at: 0.3, stiffness: [0, 1, 0]}, {at: 0.1 + 0.2, stiffness: [0, 1, 0]}]\n",
     NULL,
     "scene.yaml:5:11: boundary: a static beam with these ends is free to move; clamp one, pin "
     "both, or give beam.foundation"},
    {BEAM "tendons: [{offset: [0.01, 0], tension: 1}]\n", NULL,
     "scene.yaml:5:20: tendons[0].offset: belongs to a rod in space; leave it out, or take another "
     "rod.model"},
    {BEAM "beam: {points: [{at: 0, force: 1}]}\n", NULL,
     "scene.yaml:5:22: beam.points[0].at: is not within the beam; allowed: 0 < at < length, and at "
     "the ends beam.base, beam.tip"},
    {BEAM "beam: {points: [{at: 0.5}]}\n", NULL,
     "scene.yaml:5:22: beam.points[0].at: neither a force nor a moment is given there"},
    {BEAM "segments: [{length: 0.5}, {length: 0.5, turn: [0.1, 0, 0]}]\n", NULL,
     "scene.yaml:5:47: segments[1].turn: belongs to a rod in space; leave it out, or take another "
     "rod.model"},
    {BEAM "segments: [{length: 0.5}, {length: 0.5, rest: {curvature: [0.1, 0, 0]}}]\n", NULL,
     "scene.yaml:5:59: segments[1].rest.curvature: belongs to a rod in space; leave it out, or "
     "take another rod.model"},
};

#endif
