/* Bad scene files and the exact line each of them is refused with: what is not YAML, what has a
 * wrong key or a value out of range, and --set. What does not make a scene is refused in
 * config_refusals_scene.h. */
#ifndef TESTS_CONFIG_REFUSALS_H
#define TESTS_CONFIG_REFUSALS_H

#include <stddef.h>

/* A static rod that is accepted; what follows it begins on line 4. */
#define BASE                                                                                       \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [5, 5], axial: 9, bending: [1, 1], torsion: 0.8}\n"

typedef struct refusal {
    const char *text;
    const char *override; /* NULL: none */
    const char *line;
} refusal;

static const refusal refusals[] = {
    {"", NULL, "scene.yaml: is empty; allowed: the sections of a scene file"},
    {"# only a comment\n", NULL, "scene.yaml: is empty; allowed: the sections of a scene file"},
    {"rod: [1, 2\n", NULL,
     "scene.yaml:2:1: not valid YAML: did not find expected ',' or ']' while parsing a flow "
     "sequence"},
    {"rod:\n"
     "\tlength: 1\n",
     NULL, "scene.yaml:2:1: a tab indents this line; YAML allows spaces only"},
    {"a: b: c\n", NULL,
     "scene.yaml:1:5: not valid YAML: mapping values are not allowed in this context"},
    {"--- \n"
     "rod: {}\n"
     "---\n"
     "rod: {}\n",
     NULL, "scene.yaml:4:1: a second YAML document begins here; allowed: one"},
    {"rod: "
     "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[["
     "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[["
     "\n",
     NULL, "scene.yaml:1:69: nested 65 deep; allowed: 64"},
    {"just text\n", NULL,
     "scene.yaml:1:1: is a single value; allowed: a section with the keys name, parameters, "
     "tables, rod, segments, loads, bodies, springs, tendons, chambers, "
     "tubes, beam, boundary, initial, time, manufactured, formulation, members, motion, "
     "enforcement, "
     "network, "
     "losses, residual, data_folder, data, training, surrogate, control, plan, optimize, "
     "checkpoint, output, reference"},
    {"[1, 2]\n", NULL,
     "scene.yaml:1:1: is a list; allowed: a section with the keys name, parameters, tables, rod, "
     "segments, loads, bodies, springs, tendons, chambers, tubes, beam, boundary, initial, time, "
     "manufactured, formulation, members, motion, enforcement, "
     "network, losses, residual, data_folder, data, training, surrogate, control, plan, optimize, "
     "checkpoint, output, reference"},
    {"rod:\n"
     "  \001length: 1\n",
     NULL, "scene.yaml:2:3: not valid YAML: control characters are not allowed"},
    {"rod: &a {length: 1}\n"
     "name: *b\n",
     NULL, "scene.yaml:2:7: not valid YAML: found undefined alias"},
    {"rod: {length: 1}\n"
     "rod: {length: 2}\n",
     NULL, "scene.yaml:2:1: rod: is given twice in this section; allowed: once"},
    {"rod: {length: 1, length: 2}\n", NULL,
     "scene.yaml:1:18: rod.length: is given twice in this section; allowed: once"},
    {"rod: &r\n"
     "  <<: *r\n"
     "  length: 1\n",
     NULL, "scene.yaml:1:6: rod: << merges are nested too deeply or refer to themselves"},
    {"rod: {<<: 5, length: 1}\n", NULL,
     "scene.yaml:1:11: rod: << needs an alias of a section, as <<: *name"},
    {"rod: {<<: [5], length: 1}\n", NULL,
     "scene.yaml:1:12: rod: << needs a list of aliases of sections"},
    {"rod: {<<: {}, <<: {}, length: 1}\n", NULL,
     "scene.yaml:1:15: rod: << is given twice; allowed: <<: [*a, *b]"},
    {"? [1, 2]\n"
     ": 3\n",
     NULL, "scene.yaml:1:3: a key here is not a word; allowed: key: value"},
    {"a: &a [x, x]\n"
     "b: &b [*a, *a]\n",
     NULL,
     "scene.yaml:1:1: a: unknown key; allowed in the file: name, parameters, tables, rod, "
     "segments, "
     "loads, bodies, springs, tendons, chambers, tubes, beam, boundary, initial, time, "
     "manufactured, "
     "formulation, members, motion, enforcement, network, "
     "losses, residual, data_folder, data, training, surrogate, control, plan, optimize, "
     "checkpoint, output, reference"},
    {"name: &a [x, x]\n", NULL, "scene.yaml:1:7: name: is a list; allowed: text"},
    {BASE "rod2: {}\n", NULL, "scene.yaml:4:1: rod2: unknown key; did you mean rod?"},
    {BASE "name: a/b\n", NULL,
     "scene.yaml:4:7: name: names a folder in runs; allowed: up to 100 bytes, no slash, not "
     "beginning with a point"},
    {BASE "name: ''\n", NULL,
     "scene.yaml:4:7: name: is the text '', which is empty or longer than 1000 bytes; allowed: "
     "text"},
    {BASE "name: [a]\n", NULL, "scene.yaml:4:7: name: is a list; allowed: text"},
    {BASE "name: \"a\\u0001\"\n", NULL,
     "scene.yaml:4:7: name: is the text 'a?', which holds a control character; allowed: text"},
    {BASE "training: {seed: -1}\n", NULL,
     "scene.yaml:4:18: training.seed: is -1, which is out of range; allowed: a whole number 0 to "
     "9007199254740992"},
    {BASE "training: {seed: 1.5}\n", NULL,
     "scene.yaml:4:18: training.seed: is 1.5, which is not a whole number; allowed: a whole number "
     "0 to 9007199254740992"},
    {BASE "training: {stages: {}}\n", NULL,
     "scene.yaml:4:20: training.stages: is not a list; allowed: a list of 1 to 32 stages"},
    {BASE "training: {stages: []}\n", NULL,
     "scene.yaml:4:20: training.stages: is empty; allowed: a list of 1 to 32 stages"},
    {BASE "training: {stages: [{steps: 5}]}\n", NULL,
     "scene.yaml:4:21: training.stages[0].optimizer: missing; allowed: one of <optimizers>"},
    {BASE "training: {stages: [{optimizer: adam, memory: 5}]}\n", NULL,
     "scene.yaml:4:47: training.stages[0].memory: belongs to optimizer <memory>, but this stage "
     "runs "
     "adam; leave it out"},
    {BASE "training: {stages: [{optimizer: lbfgs, learning_rate: 5}]}\n", NULL,
     "scene.yaml:4:55: training.stages[0].learning_rate: belongs to optimizer <rate>, but this "
     "stage runs lbfgs; leave it out"},
    {BASE "network: {modes: [3, 1, 2, 1]}\n", NULL,
     "scene.yaml:4:18: network.modes: are of one motion in the strain form; leave them out"},
    {BASE "network: {tolerance: 1.0e-3}\nparameters: {p: {range: [0, 1]}}\nloads: {tip: {force: "
          "[p, 0, 0]}}\n",
     NULL,
     "scene.yaml:4:22: network.tolerance: is not of a family in the strain form, each of whose "
     "answers has an error of its own; leave it out"},
    {BASE "network: {modes: [3, 1]}\n", NULL,
     "scene.yaml:4:18: network.modes: has 2 entries; allowed: a list of 4 whole numbers 0 to 24"},
    {BASE "formulation: strain\n", NULL,
     "scene.yaml:4:14: formulation: strain learns a rod at rest from members of its family; give "
     "parameters with ranges, or take mixed"},
    {BASE "training: {stages: [{optimizer: gauss_newton, memory: 5}]}\n", NULL,
     "scene.yaml:4:55: training.stages[0].memory: belongs to optimizer <memory>, but this stage "
     "runs "
     "gauss_newton; leave it out"},
    {BASE "training: {stages: [{optimizer: adam, step_tolerance: 0.1}]}\n", NULL,
     "scene.yaml:4:55: training.stages[0].step_tolerance: belongs to optimizer <tolerances>, "
     "but this stage runs adam; leave it out"},
    {BASE "training: {stages: [{optimizer: ssbroyden, memory: 5}]}\n", NULL,
     "scene.yaml:4:52: training.stages[0].memory: belongs to optimizer <memory>, but this stage "
     "runs "
     "ssbroyden; leave it out"},
    {BASE "training: {stages: [{optimizer: gauss_newton, maximum_step: 5}]}\n", NULL,
     "scene.yaml:4:61: training.stages[0].maximum_step: belongs to optimizer <lines>, but "
     "this stage runs gauss_newton; leave it out"},
    {BASE "training: {stages: [{optimizer: gauss_newton, maximum_damping: 1e-11}]}\n", NULL,
     "scene.yaml:4:21: training.stages[0]: maximum_damping must be finite and > initial_damping"},
    {BASE "training: {stages: [{optimizer: sgd}]}\n", NULL,
     "scene.yaml:4:33: training.stages[0].optimizer: is sgd; allowed: one of <optimizers>"},
    {BASE "training: {stages: [{optimizer: adam, steps: many}]}\n", NULL,
     "scene.yaml:4:46: training.stages[0].steps: is many, which is not a number; allowed: a whole "
     "number 1 to 1000000000"},
    {BASE "training: {stages: [{optimizer: adam, stop: {los: 1}}]}\n", NULL,
     "scene.yaml:4:46: training.stages[0].stop.los: unknown key; did you mean "
     "training.stages[0].stop.loss?"},
    {BASE "training: {stages: [{optimizer: lbfgs, sufficient_decrease: 0.4, curvature: 0.3}]}\n",
     NULL, "scene.yaml:4:21: training.stages[0]: curvature must be in (sufficient_decrease, 1)"},
    {BASE "training: {stages: [{optimizer: ssbroyden, maximum_step: 2, curvature: 5e-5}]}\n", NULL,
     "scene.yaml:4:21: training.stages[0]: curvature must be in (sufficient_decrease, 1)"},
    {BASE "training: {stages: [5]}\n", NULL,
     "scene.yaml:4:21: training.stages[0]: is a single value; allowed: a section with the keys "
     "optimizer, steps, <settings>, linear_algebra, targets, stop"},
    {BASE "training: {stages: [{optimizer: adam, beta1: 1}]}\n", NULL,
     "scene.yaml:4:46: training.stages[0].beta1: is 1, which is out of range; allowed: a finite "
     "number >= 0 and < 1"},
    {BASE "network: {hidden: 32}\n", NULL,
     "scene.yaml:4:19: network.hidden: is 32; allowed: a list of 0 to 16 whole numbers 1 to 4096"},
    {BASE "network: {fourier: {frequency: 5}}\n", NULL,
     "scene.yaml:4:32: network.fourier.frequency: is along time, but the scene is static; give "
     "time.duration, or leave it out"},
    {BASE "network: {hidden: [32, 0]}\n", NULL,
     "scene.yaml:4:24: network.hidden[1]: is 0, which is out of range; allowed: a whole number 1 "
     "to 4096"},
    {BASE "network: {hidden: [32, 3.5]}\n", NULL,
     "scene.yaml:4:24: network.hidden[1]: is 3.5, which is not a whole number; allowed: a whole "
     "number 1 to 4096"},
    {BASE "network: {activation: relu}\n", NULL,
     "scene.yaml:4:23: network.activation: is relu; allowed: one of tanh, sin, silu, gelu"},
    {BASE "network: {rotation: angles}\n", NULL,
     "scene.yaml:4:21: network.rotation: is angles; allowed: one of quaternion, vector, six"},
    {BASE "network: {polynomial: {degree: 5}}\n", NULL,
     "scene.yaml:4:32: network.polynomial.degree: is of families in the strain form; leave it out"},
    {BASE "network: {fourier: 16}\n", NULL,
     "scene.yaml:4:20: network.fourier: is a single value; allowed: a section with the keys "
     "features, wavenumber, parameters, frequency"},
    {BASE "network: {widths: [32]}\n", NULL,
     "scene.yaml:4:11: network.widths: unknown key; allowed in network: hidden, activation, "
     "initialization, fourier, polynomial, modes, tolerance, inputs, symmetry, rotation"},
    {BASE "network: {fourier: {wavenumber: 0}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is 0, which is out of range; allowed: a finite "
     "number > 0, in rad/m"},
    {BASE "network: {fourier: {wavenumber: 1e400}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is 1e400, which is too large for a number; "
     "allowed: "
     "a finite number > 0, in rad/m"},
    {BASE "network: {fourier: {wavenumber: 1e-400}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is 1e-400, which is too small for a number; "
     "write 0; "
     "allowed: a finite number > 0, in rad/m"},
    {BASE "network: {fourier: {wavenumber: .nan}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is .nan, which is out of range; allowed: a "
     "finite "
     "number > 0, in rad/m"},
    {BASE "network: {fourier: {wavenumber: .inf}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is .inf, which is out of range; allowed: a "
     "finite "
     "number > 0, in rad/m"},
    {BASE "network: {fourier: {wavenumber: 010}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is 010, which begins with 0, which some YAML "
     "readers "
     "take for octal; leave the 0 out; allowed: a finite number > 0, in rad/m"},
    {BASE "network: {fourier: {wavenumber: 0x10}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is 0x10, which is hexadecimal or octal; write "
     "it in "
     "decimals; allowed: a finite number > 0, in rad/m"},
    {BASE "network: {fourier: {wavenumber: 1_000}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is 1_000, which is not a number; allowed: a "
     "finite "
     "number > 0, in rad/m"},
    {BASE "network: {fourier: {wavenumber: '5'}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is the text '5'; allowed: a finite number > 0, "
     "in rad/m"},
    {BASE "network: {fourier: {wavenumber: yes}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is yes, which is not a number; allowed: a "
     "finite "
     "number > 0, in rad/m"},
    {BASE "network: {fourier: {wavenumber: }}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: has no value; allowed: a finite number > 0, in "
     "rad/m"},
    {BASE "network: {fourier: {wavenumber: !!foo 5}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: has a YAML tag; allowed: a finite number > 0, "
     "in rad/m"},
    {BASE "network: {fourier: {wavenumber: !mine 5}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: has a YAML tag; allowed: a finite number > 0, "
     "in rad/m"},
    {BASE "network: {fourier: {wavenumber: {}}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is a section; allowed: a finite number > 0, in "
     "rad/m"},
    {BASE "network: {fourier: {features: 2.5}}\n", NULL,
     "scene.yaml:4:31: network.fourier.features: is 2.5, which is not a whole number; allowed: a "
     "whole number 0 to 1024"},
    {BASE "network: {fourier: {wavenumber: 1:30}}\n", NULL,
     "scene.yaml:4:33: network.fourier.wavenumber: is 1:30, which is not a number; allowed: a "
     "finite "
     "number > 0, in rad/m"},
    {BASE "loads: {gravity: [0, 0]}\n", NULL,
     "scene.yaml:4:18: loads.gravity: has 2 entries; allowed: a list of 3 numbers or "
     "formulas, in m/s^2"},
    {BASE "loads: {gravity: [0, 0, x]}\n", NULL,
     "scene.yaml:4:25: loads.gravity[2]: column 1 of 'x': unknown name 'x'; allowed are s, t, "
     "pi, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, exp, log, sqrt, abs, min, "
     "max, step, where, within"},
    {BASE "loads: {gravity: 9.81}\n", NULL,
     "scene.yaml:4:18: loads.gravity: is 9.81; allowed: a list of 3 numbers or formulas, in "
     "m/s^2"},
    {BASE "loads: {gravity: [0, 0, null]}\n", NULL,
     "scene.yaml:4:25: loads.gravity[2]: is null; allowed: a number or a formula, in m/s^2"},
    {BASE "loads: {gravity: [0, 0, -9.81]}\n", NULL,
     "scene.yaml:2:3: rod.inertia.mass_per_length: missing; loads.gravity needs the rod's mass"},
    {BASE "loads: {tip: {force: [0, 0, sin(]}}\n", NULL,
     "scene.yaml:4:29: loads.tip.force[2]: column 5 of 'sin(': the formula ends where a number, a "
     "name or ( is expected"},
    {BASE "loads: {tip: {force: [0, 0, foo(t)]}}\n", NULL,
     "scene.yaml:4:29: loads.tip.force[2]: column 1 of 'foo(t)': unknown name 'foo'; allowed are "
     "s, t, pi, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, exp, log, sqrt, abs, "
     "min, max, step, where, within"},
    {BASE "loads: {tip: {force: [0, 0, .inf]}}\n", NULL,
     "scene.yaml:4:29: loads.tip.force[2]: is .inf, which is not finite; allowed: a number or a "
     "formula, in N"},
    {BASE "loads: {tip: {force: [0, 0, 1/0]}}\n", NULL,
     "scene.yaml:4:29: loads.tip.force[2]: column 1 of '1/0': the value is not a finite number"},
    {BASE "loads: {tip: {force: [0, 0, where(1, 2, 3)]}}\n", NULL,
     "scene.yaml:4:22: loads.tip.force: has 5 entries (a formula that contains a comma needs "
     "quotes); allowed: a list of 3 numbers or formulas, in N"},
    {BASE "loads: {tip: {force: [0, 0, [1]]}}\n", NULL,
     "scene.yaml:4:29: loads.tip.force[2]: is a list; allowed: a number or a formula, in N"},
    {BASE "loads: {tip: {force: 5}}\n", NULL,
     "scene.yaml:4:22: loads.tip.force: is 5; allowed: a list of 3 numbers or formulas, in N"},
    {BASE "loads: {tip: {forces: [0, 0, 1]}}\n", NULL,
     "scene.yaml:4:15: loads.tip.forces: unknown key; did you mean loads.tip.force?"},
    {BASE "loads: {force: [s**2, 0, 0]}\n", NULL,
     "scene.yaml:4:17: loads.force[0]: column 3 of 's**2': expected a number, a name or (; use ^ "
     "for powers"},
    {BASE "boundary: {start: {type: held}}\n", NULL,
     "scene.yaml:4:26: boundary.start.type: is held; allowed: one of clamped, pinned, free, "
     "loaded, driven, guided, roller"},
    {BASE "rod: {}\n", NULL, "scene.yaml:4:1: rod: is given twice in this section; allowed: once"},
    {BASE "radius: 5\n", NULL,
     "scene.yaml:4:1: radius: unknown key; did you mean rod.section.radius?"},
    {BASE "time: {duration: -1}\n", NULL,
     "scene.yaml:4:18: time.duration: is -1, which is out of range; allowed: a number or a "
     "formula >= 0, in s"},
    {BASE "losses: {interior: {sampler: random}}\n", NULL,
     "scene.yaml:4:30: losses.interior.sampler: is random; allowed: one of uniform, "
     "latin_hypercube, sobol, chebyshev, chebyshev_lobatto, grid"},
    {BASE "losses: {causal: {epsilon: [1, 0]}}\n", NULL,
     "scene.yaml:4:32: losses.causal.epsilon[1]: is 0, which is out of range; allowed: a finite "
     "number > 0"},
    {BASE "losses: {balance: 1}\n", NULL,
     "scene.yaml:4:19: losses.balance: is 1; allowed: one of none, gradient_norm"},
    {BASE "losses: {balance_memory: 1}\n", NULL,
     "scene.yaml:4:26: losses.balance_memory: is 1, which is out of range; allowed: a finite "
     "number "
     ">= 0 and < 1"},
    {BASE "losses: {balance_every: 0}\n", NULL,
     "scene.yaml:4:25: losses.balance_every: is 0, which is out of range; allowed: a whole number "
     "1 "
     "to 1000000000, in steps"},
    {BASE "training: {stages: [{optimizer: adam, stop: {held_out_ratio: -1}}]}\n", NULL,
     "scene.yaml:4:62: training.stages[0].stop.held_out_ratio: is -1, which is out of range; "
     "allowed: a finite number >= 0"},
    {BASE "losses: {self_adaptive: {rate: 0.1}}\n", NULL,
     "scene.yaml:4:10: losses.self_adaptive: unknown key; allowed in losses: interior, boundary, "
     "initial, "
     "held_out_points, balance, balance_every, balance_memory, causal"},
    {BASE "losses: {causal: {threshold: 1}}\n", NULL,
     "scene.yaml:4:30: losses.causal.threshold: is 1, which is out of range; allowed: a finite "
     "number > 0 and < 1"},
    {BASE "checkpoint: {keep: 0}\n", NULL,
     "scene.yaml:4:20: checkpoint.keep: is 0, which is out of range; allowed: a whole number 1 to "
     "1000"},
    {BASE "output: {every: 0}\n", NULL,
     "scene.yaml:4:17: output.every: is 0, which is out of range; allowed: a whole number 1 to "
     "1000000000, in steps"},
    {BASE "formulation: weak\n", NULL,
     "scene.yaml:4:14: formulation: is weak; allowed: one of mixed, displacement, strain, "
     "pose_strain"},
    {BASE "motion: flat\n", NULL,
     "scene.yaml:4:9: motion: is flat; allowed: one of automatic, planar, spatial"},
    {BASE "enforcement: {boundary: medium}\n", NULL,
     "scene.yaml:4:25: enforcement.boundary: is medium; allowed: one of hard, soft"},
    {BASE "checkpoint: {every: 1e3, seconds: 0}\n", NULL,
     "scene.yaml:4:35: checkpoint.seconds: is 0, which is out of range; allowed: a finite number > "
     "0, in s"},
    {BASE "training: {stages: [{optimizer: adam, warmup: 3}]}\n", NULL,
     "scene.yaml:4:39: training.stages[0].warmup: unknown key; allowed in training.stages[]: "
     "optimizer, steps, <settings>, linear_algebra, targets, stop"},
    {BASE, "rod.length", "override rod.length: allowed: key=value, the key as in rod.length"},
    {BASE, "=5", "override =5: allowed: key=value, the key as in rod.length"},
    {BASE, "rod.lenght=5",
     "override rod.lenght=5: rod.lenght: unknown key; did you mean rod.length?"},
    {BASE, "rod.length=", "override rod.length=: is empty; allowed: key=value"},
    {BASE, "rod.length=-5",
     "override rod.length=-5: rod.length: is -5, which is out of range; allowed: a number or a "
     "formula > 0, in m"},
    {BASE, "rod.length=[1",
     "override rod.length=[1: not valid YAML: did not find expected ',' or ']' while parsing a "
     "flow "
     "sequence"},
    {BASE, "rod={length: x}",
     "override rod={length: x}: rod.length: column 1 of 'x': unknown name 'x'; allowed are s, t, "
     "pi, sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, exp, log, sqrt, abs, min, "
     "max, step, where, within"},
    {BASE, "rod={lenght: 2}",
     "override rod={lenght: 2}: rod.lenght: unknown key; did you mean rod.length?"},
    {BASE, "network.hidden=[64,-1]",
     "override network.hidden=[64,-1]: network.hidden[1]: is -1, which is out of range; allowed: a "
     "whole number 1 to 4096"},
    {BASE, "network.hidden[1]=3",
     "override network.hidden[1]=3: network.hidden: the list is not given; set all of it"},
    {BASE "network: {hidden: [32, 32]}\n", "network.hidden[1]=0",
     "override network.hidden[1]=0: network.hidden[1]: is 0, which is out of range; allowed: a "
     "whole "
     "number 1 to 4096"},
    {BASE "network: {hidden: [32, 32]}\n", "network.hidden[7]=3",
     "override network.hidden[7]=3: network.hidden: the list is shorter; entries count from 0"},
    {BASE, "training.stages[5].steps=3",
     "override training.stages[5].steps=3: training.stages[5].steps: no such stage; allowed: 0 to "
     "0"},
    {BASE, "training.stages[0].steps=x",
     "override training.stages[0].steps=x: training.stages[0].steps: is x, which is not a number; "
     "allowed: a whole number 1 to 1000000000"},
    {BASE, "training.stages[].steps=1",
     "override training.stages[].steps=1: training.stages[].steps: needs an index, as in "
     "training.stages[0].steps"},
    {BASE, "loads.tip.force[2]=1",
     "override loads.tip.force[2]=1: loads.tip.force: the list is not given; set all of it"},
    {BASE, "loads.tip.force=[0,0]",
     "override loads.tip.force=[0,0]: loads.tip.force: has 2 entries; allowed: a list of 3 numbers "
     "or "
     "formulas, in N"},
    {BASE, "time.duration=1",
     "scene.yaml:2:3: rod.inertia.mass_per_length: missing; a dynamic scene needs the rod's mass"},
    {BASE, "rod.length[0]=2",
     "override rod.length[0]=2: rod.length[0]: unknown key; did you mean rod.length?"},
    {BASE, "reference.analytic=elastica",
     "override reference.analytic=elastica: reference.analytic: needs a clamped start and a loaded "
     "end"},
    {BASE "training: {stages: [{optimizer: lbfgs}]}\n", "training.stages[0].memory=0",
     "override training.stages[0].memory=0: training.stages[0].memory: is 0, which is out of "
     "range; "
     "allowed: a whole number 1 to 1000"},
    {BASE, "network.hidden=null null",
     "override network.hidden=null null: network.hidden: is null null; allowed: a list of 0 to 16 "
     "whole numbers 1 to 4096"},
    {BASE, "a.b=1", "override a.b=1: a.b: unknown key; no section has that name"},
    {BASE, "training.stages=[{optimizer: lbfgs}, {steps: 3}]",
     "override training.stages=[{optimizer: lbfgs}, {steps: 3}]: training.stages[1].optimizer: "
     "missing; allowed: one of <optimizers>"},
    {BASE, "loads.tip.force=[0, 0, sin(]",
     "override loads.tip.force=[0, 0, sin(]: loads.tip.force[2]: column 5 of 'sin(': the formula "
     "ends "
     "where a number, a name or ( is expected"},
};

#endif
