/* Every key a scene file may have. The quantities of the scene are the rows of
 * physics/scene_rows.h. Defaults live there and in tools/train/settings.c; `fallback` says in words
 * what a default that depends on other keys is. */
#include "tools/config/config_keys.h"

#include "physics/scene_rows.h"
#include "physics/solve/solve.h"

#include <math.h>

#define CONFIG_NAME(name, text)                    text,
#define CONFIG_SAMPLER(name, text, random, tensor) text,
#define CONFIG_NAMES(function, ...)                                                                \
    static const char *const *function(void)                                                       \
    {                                                                                              \
        static const char *const names[] = {__VA_ARGS__ NULL};                                     \
        return names;                                                                              \
    }

CONFIG_NAMES(truth_names, "false", "true", )
CONFIG_NAMES(unit_names, "SI", "EI", )
CONFIG_NAMES(activation_names, NN_ACTIVATION_LIST(CONFIG_NAME))
CONFIG_NAMES(initialization_names, NN_INITIALIZATION_LIST(CONFIG_NAME))
CONFIG_NAMES(input_names, GROUPS_INPUTS_LIST(CONFIG_NAME))
CONFIG_NAMES(symmetry_names, GROUPS_SYMMETRY_LIST(CONFIG_NAME))
CONFIG_NAMES(sampler_names, SAMPLING_KIND_LIST(CONFIG_SAMPLER))
CONFIG_NAMES(schedule_names, OPTIM_SCHEDULE_LIST(CONFIG_NAME))
CONFIG_NAMES(adaptive_names, PROBLEM_ADAPTIVE_LIST(CONFIG_NAME))
CONFIG_NAMES(balance_names, "none", "gradient_norm", )
CONFIG_NAMES(scaling_names, OPTIM_SCALING_LIST(CONFIG_NAME))
CONFIG_NAMES(surrogate_kinds, SURROGATE_KIND_LIST(CONFIG_NAME))
CONFIG_NAMES(surrogate_holds, SURROGATE_HOLD_LIST(CONFIG_NAME))
CONFIG_NAMES(surrogate_weights, SURROGATE_WEIGHTS_LIST(CONFIG_NAME))

#define AT(field)            .offset = offsetof(config, field)
#define STAGE(field)         AT(settings.stages[0].field)
#define POSITIVE             .low = 0, .high = INFINITY, .flags = CONFIG_LOW_OPEN
#define NOT_NEGATIVE         .low = 0, .high = INFINITY
#define STIFFNESS            .low = 0, .high = INFINITY, .flags = CONFIG_LOW_OPEN | CONFIG_INFINITE
#define LOSS_WEIGHT          BETWEEN(0, 1e12)
#define ANY                  .low = -INFINITY, .high = INFINITY
#define BETWEEN(least, most) .low = (least), .high = (most)
#define ENTRIES(least, most) .entries_min = (least), .entries_max = (most)
#define FORMULA(path, field) path, CONFIG_QUANTITY, AT(field), ANY
#define LIKE_ADAM            CONFIG_FOR_ADAM | CONFIG_FOR_SOAP
#define ADAM                 .flags = LIKE_ADAM
#define LBFGS                .flags = CONFIG_FOR_LBFGS
#define GAUSS_NEWTON         .flags = CONFIG_FOR_GAUSS_NEWTON
#define LINE_SEARCH          CONFIG_FOR_LBFGS | CONFIG_FOR_SSBROYDEN
#define NOT_ADAM             LINE_SEARCH | CONFIG_FOR_GAUSS_NEWTON

/* What some bounds of quantities are called in their rows; the others as above. */
#define FINITE  ANY
#define POISSON BETWEEN(-1, 0.5), .flags = CONFIG_LOW_OPEN

/* ...: its bounds */
#define QUANTITY_KEY(path, size, member, of_unit, in_words, text, ...)                             \
    {path,                                                                                         \
     CONFIG_QUANTITY,                                                                              \
     ENTRIES((size) > 1 ? (size) : 0, (size) > 1 ? (size) : 0),                                    \
     AT(scene.member),                                                                             \
     __VA_ARGS__,                                                                                  \
     .unit = (of_unit),                                                                            \
     .fallback = (in_words),                                                                       \
     .help = (text)},
#define SCENE_QUANTITY(path, size, member, part, rule, bounds, geometry, axes, of_unit, otherwise, \
                       in_words, text)                                                             \
    QUANTITY_KEY(path, size, member, of_unit, in_words, text, bounds)

/* What a segment has of the rod. */
#define SEGMENT_QUANTITY(path, size, member, part, rule, bounds, geometry, axes, of_unit,          \
                         otherwise, in_words, text)                                                \
    QUANTITY_KEY(path, size, member, of_unit, "as under rod, or from section and material",        \
                 "Of this piece, as under rod.", bounds)

#include "tools/config/config_control.h"

/* clang-format off */
const config_key config_keys[] = {
    {"name", CONFIG_TEXT, AT(settings.name), .fallback = "the file's name without .yaml",
     .help = "Name of the experiment; results go to runs/<name>."},

    {CONFIG_PARAMETER_PATH, CONFIG_PARAMETER, ANY,
     .help = "A name for the formulas of the scene, as in parameters: {load: 0.3} and then "
             "\"-load*s\"; --set parameters.load=0.5 changes it. Formulas of s, t and of the "
             "parameters before it. In place of a value {range: [0, 2]}: the scene is a family, of "
             "which a number that is set in its place is a member."},

    {CONFIG_PARAMETER_PATH ".range", CONFIG_NUMBER, AT(parameters[0].range), ENTRIES(2, 2), ANY,
     .help = "The least and the largest value of a parameter that stays open: one training or one "
             "batch of members is for all values between."},
    {CONFIG_PARAMETER_PATH ".identify", CONFIG_NUMBER, AT(parameters[0].identify), ANY,
     .help = "The parameter is one number that is to be found from the measurements under data, "
             "from this value on and within its range. {identify: 6e10, range: [1e10, 1e11]} may "
             "also stand in place of any number of the scene."},
    {CONFIG_PARAMETER_PATH ".scale", CONFIG_CHOICE, AT(parameters[0].scale),
     .names = scene_scale_names,
     .help = "How members are spread over the range and networks see it; log: by the logarithm of "
             "the value, for a range over powers of ten.",
     .fallback = "linear; of what is to be identified log from 1:100 on"},

    {"tables[].name", CONFIG_TEXT, AT(tables[0].name), .fallback = "required",
     .help = "A function for the formulas, as wind(s) or 2*pull(t), that goes through the rows of a "
             "table without overshoot, as cubics with a continuous slope. Formulas that use it must "
             "stay within its rows."},
    {"tables[].file", CONFIG_TEXT, AT(tables[0].file),
     .help = "CSV or HDF5 with two columns, argument and value in SI units, the argument "
             "ascending, 2 to 200 rows; relative to this file."},
    {"tables[].x", CONFIG_NUMBER, ENTRIES(2, QUANTITY_TABLE_MAX), AT(tables[0].x),
     .count_offset = offsetof(config, tables[0].x_count), ANY,
     .help = "Or the numbers themselves: arguments, ascending."},
    {"tables[].y", CONFIG_NUMBER, ENTRIES(2, QUANTITY_TABLE_MAX), AT(tables[0].y),
     .count_offset = offsetof(config, tables[0].y_count), ANY, .help = "Values."},

    {"rod.model", CONFIG_CHOICE, AT(scene.rod.model), .names = scene_model_names,
     .help = "cosserat: bends, twists, shears, stretches; inextensible: no stretch; kirchhoff: "
             "neither shear nor stretch; beams of small deflection, see beam: euler_bernoulli "
             "bends, timoshenko also shears."},
    SCENE_LENGTH_ROWS(SCENE_QUANTITY)
    {"rod.section.shape", CONFIG_CHOICE, AT(scene.rod.section), .names = scene_section_names,
     .help = "Cross-section; none: give stiffness and inertia instead."},
    SCENE_MATTER_ROWS(SCENE_QUANTITY, "rod.", rod.)
    SCENE_REST_ROWS(SCENE_QUANTITY, "rod.", rod.)
    SCENE_DAMPING_ROWS(SCENE_QUANTITY, "rod.", rod.)
    {"rod.law.file", CONFIG_TEXT, AT(law.file),
     .help = "A nonlinear law of the section in place of n = Kse (v - v*), m = Kbt (u - u*): a "
             "potential that cpinn-law has learned; relative to this file. Its stiffness at rest "
             "is that of rod.stiffness. Of rods at rest and in motion, without tubes; families by "
             "formulation mixed."},
    {"rod.law.numbers", CONFIG_NUMBER, ENTRIES(1, SCENE_LAW_NUMBERS_MAX), AT(law.numbers),
     .count_offset = offsetof(config, law.count), .low = -INFINITY, .high = INFINITY,
     .flags = CONFIG_INFINITE, .help = "Or the numbers of that file themselves."},

    SCENE_PIECE_ROWS(SCENE_QUANTITY, "segments[].", segments[0].)
    {"segments[].section.shape", CONFIG_CHOICE, AT(scene.segments[0].rod.section),
     .names = scene_section_names, .help = "Cross-section of this piece; none: as under rod."},
    SCENE_MATTER_ROWS(SEGMENT_QUANTITY, "segments[].", segments[0].rod.)
    SCENE_REST_ROWS(SEGMENT_QUANTITY, "segments[].", segments[0].rod.)
    SCENE_DAMPING_ROWS(SEGMENT_QUANTITY, "segments[].", segments[0].rod.)
    SCENE_TURN_ROWS(SCENE_QUANTITY, "segments[].", segments[0].)

    {"loads.units", CONFIG_CHOICE, AT(load_units), .names = unit_names,
     .help = "Of the forces and moments below: SI, or multiples of EI/L^2 and EI/L at ends and "
             "points and of EI/L^3 and EI/L^2 along the rod (EI about d1)."},
    SCENE_LINE_ROWS(SCENE_QUANTITY)
    {"loads.frame", CONFIG_CHOICE, AT(scene.loads.frame), .names = scene_frame_names,
     .help = "Of the distributed loads; dead: fixed in the world, follower: turns with the rod."},
    SCENE_BASE_ROWS(SCENE_QUANTITY)
    {"loads.base.frame", CONFIG_CHOICE, AT(scene.loads.base.frame), .names = scene_frame_names,
     .help = "dead: fixed in the world, follower: turns with this end."},
    SCENE_TIP_ROWS(SCENE_QUANTITY)
    {"loads.tip.frame", CONFIG_CHOICE, AT(scene.loads.tip.frame), .names = scene_frame_names,
     .help = "dead: fixed in the world, follower: turns with the tip."},
    SCENE_POINT_ROWS(SCENE_QUANTITY, "loads.points[].", points[0].)
    {"loads.points[].frame", CONFIG_CHOICE, AT(scene.points[0].load.frame),
     .names = scene_frame_names,
     .help = "dead: fixed in the world, follower: turns with the rod there."},

    SCENE_BODY_ROWS(SCENE_QUANTITY, "bodies[].", bodies[0].)

    SCENE_SPRING_ROWS(SCENE_QUANTITY, "springs[].", springs[0].)

    SCENE_TENDON_ROWS(SCENE_QUANTITY, "tendons[].", tendons[0].)

    SCENE_CHAMBER_ROWS(SCENE_QUANTITY, "chambers[].", chambers[0].)

    SCENE_TUBE_ROWS(SCENE_QUANTITY, "tubes[].", tubes[0].)

    SCENE_BEAM_ROWS(SCENE_QUANTITY)
    SCENE_BEAM_POINT_ROWS(SCENE_QUANTITY, "beam.points[].", beam.points[0].)

    {"boundary.start.type", CONFIG_CHOICE, AT(scene.start.type), .names = scene_end_names,
     .help = "What holds s = 0: clamped, pinned (position only: a simple support), free, loaded "
             "(loads.base, beam.base), driven (formulas of t)."},
    SCENE_START_ROWS(SCENE_QUANTITY)
    {"boundary.end.type", CONFIG_CHOICE, AT(scene.end.type), .names = scene_end_names,
     .fallback = "loaded when loads.tip or beam.tip is given, else free",
     .help = "What holds s = length; loaded: loads.tip, beam.tip."},
    SCENE_END_ROWS(SCENE_QUANTITY)

    SCENE_INITIAL_ROWS(SCENE_QUANTITY)
    {"initial.state", CONFIG_CHOICE, AT(scene.initial.state), .names = scene_state_names,
     .help = "given: as the keys above say; equilibrium: the rod starts in its equilibrium under "
             "what acts at t = 0, so that \"where(t, 0, 2)\" as a load lets go of a rod that 2 has "
             "bent. Beams, too."},

    SCENE_DURATION_ROWS(SCENE_QUANTITY)
    {"time.windows", CONFIG_INTEGER, AT(settings.windows), BETWEEN(1, SCENE_WINDOWS_MAX),
     .fallback = "1; without hidden layers as many as last L^2/6 (rhoA/EI)^(1/2) at most",
     .help = "Equal parts of the duration, trained in turn, each with a network of its own that "
             "starts exactly where the one before ends; for many periods. training.stages are run "
             "in each."},

    SCENE_EXACT_ROWS(SCENE_QUANTITY)

    {"formulation", CONFIG_CHOICE, AT(scene.formulation), .names = scene_formulation_names,
     .fallback = "mixed; of families at rest and of motions without hidden layers strain, where it takes the "
                 "scene and there are no data",
     .help = "mixed: unknowns r, q, N, m, first order in s; displacement: r, q, second order. Of "
             "beams: w, slope, V, M; displacement, the strong form: w, fourth order, of timoshenko "
             "beams w and slope, second order. strain: of a family at rest, the curvature alone as a "
             "function of the parameters, learnt from members; of one motion, strain modes along s whose "
             "numbers are a network of time, network.modes. pose_strain, after Bensch et al. 2024: "
             "unknowns r, q and the strains v, u, that of the pose being residuals, N and m by the "
             "constitutive law."},
    {"members.solved", CONFIG_INTEGER, AT(settings.members), BETWEEN(0, 100000000),
     .fallback = "in the strain form 131072, of one parameter 8192, of two 32768; else 0",
     .help = "Of a family in the strain form: members that are drawn from the ranges and solved "
             "before training, 16 at least."},
    {"members.file", CONFIG_TEXT, AT(settings.members_file),
     .help = "Or CSV/HDF5 with a column for every parameter, such as measured actuations: these members "
             "are solved and learnt, without hidden layers all at once; held-out and fresh ones are "
             "drawn from the ranges none the less. Relative to this file."},
    {"motion", CONFIG_CHOICE, AT(scene.motion), .names = scene_motion_names,
     .help = "automatic: in a plane where the scene keeps the rod in one by symmetry (6 unknowns in "
             "place of 13), else in space; planar: or an error; spatial: always in space, say for a "
             "column that may buckle sideways."},
    {"enforcement.boundary", CONFIG_CHOICE, AT(scene.boundary_enforcement),
     .names = scene_enforcement_names,
     .help = "How the conditions at the ends are met. hard: the network's outputs are put into a "
             "form that meets them exactly, whatever its parameters; soft: they are a loss term "
             "of weight losses.boundary.weight and hold as well as it is trained."},
    {"enforcement.initial", CONFIG_CHOICE, AT(scene.initial_enforcement),
     .names = scene_enforcement_names,
     .help = "The same for the state at t = 0, with losses.initial.weight. Several windows of "
             "time need hard."},

    {"network.hidden", CONFIG_INTEGER, ENTRIES(0, NN_HIDDEN_MAX), AT(settings.network.hidden),
     .count_offset = offsetof(config, settings.network.hidden_count), BETWEEN(1, 4096),
     .fallback = "[] where training begins with gauss_newton, else [32, 32, 32]; in the strain form [] for "
                 "up to four parameters, else [128, 128, 128]",
     .help = "Widths of the hidden layers. []: the network is linear in its parameters, a sum of "
             "fixed random waves, and Gauss-Newton finds it in a few steps."},
    {"network.activation", CONFIG_CHOICE, AT(settings.network.activation), .names = activation_names,
     .help = "Between the layers."},
    {"network.initialization", CONFIG_CHOICE, AT(settings.network.initialization),
     .names = initialization_names, .help = "Of the weights."},
    {"network.fourier.features", CONFIG_INTEGER, AT(settings.network.fourier_features), BETWEEN(0, 1024),
     .fallback = "0; without hidden layers enough for the largest frequencies",
     .help = "Pairs sin, cos of random waves put beside the inputs; 0: none."},
    {"network.fourier.wavenumber", CONFIG_NUMBER, AT(settings.fourier_wavenumber), .unit = "rad/m", POSITIVE,
     .fallback = "16 / rod.length, more for large loads; dynamic 12 / rod.length",
     .help = "Their largest frequency along s; drawn uniformly within."},
    {"network.fourier.parameters", CONFIG_NUMBER, AT(settings.fourier_parameters), .unit = "rad", POSITIVE,
     .fallback = "2 of a family, else null",
     .help = "The largest frequency along every parameter with a range, in half of it."},
    {"network.fourier.frequency", CONFIG_NUMBER, AT(settings.fourier_frequency), .unit = "rad/s", POSITIVE,
     .fallback = "the third bending frequency of the cantilever",
     .help = "Their largest frequency in time."},
    {"network.polynomial.degree", CONFIG_INTEGER, AT(settings.network.degree), BETWEEN(0, NN_DEGREE_MAX),
     .fallback = "0; of one motion in the strain form 20, with damping 16, more in long windows; of families in the strain form without hidden layers and waves as large as 1300 "
                 "polynomials and 64 members for each allow",
     .help = "Polynomial chaos: in place of waves all products of Legendre polynomials of the inputs up "
             "to this degree in all, where inputs that move the rod little count two- or threefold."},
    {"network.modes", CONFIG_INTEGER, ENTRIES(4, 4), AT(settings.modes), BETWEEN(0, SOLVE_MODES_MAX),
     .fallback = "[12, 6, 10, 10] of one motion in the strain form, with network.tolerance what it takes; else 0",
     .help = "Strain modes of bending, twist, stretch and shear, Legendre polynomials along each piece "
             "of the rod, for each direction; a locked strain, or one across the plane of a motion, "
             "has none."},
    {"network.tolerance", CONFIG_NUMBER, AT(settings.tolerance), BETWEEN(1e-10, 0.1),
     .fallback = "1e-3; of one scene at rest in mixed form without hidden layers 5e-8",
     .help = "Of the estimated error, of the length or of a beam's deflection: above it the verdict is "
             "a warning. Of one motion in the strain form, where it is given, cpinn-train takes more "
             "network.modes and a larger network.polynomial.degree, from few or from those that are "
             "given, until the estimate is below. Not of families in the strain form, each of whose "
             "answers has an error of its own."},
    {"network.inputs", CONFIG_CHOICE, AT(settings.groups.inputs), .names = input_names,
     .help = "Of a family whose network is of the parameters alone. groups: the dimensionless "
             "numbers of its equations, forces by EI/L^2 and so on, which --explain lists; "
             "parameters: as they are, over their ranges."},
    {"network.symmetry", CONFIG_CHOICE, AT(settings.groups.symmetry), .names = symmetry_names,
     .help = "With groups. auto: where section, actuators and loads look the same after a turn "
             "about d3 of the base or in a mirror, one member stands for all that are so turned; "
             "none: each by itself."},
    {"network.rotation", CONFIG_CHOICE, AT(settings.rotation), .names = scene_rotation_names,
     .fallback = "quaternion; vector in motion without hidden layers, from a hard initial state",
     .help = "How the network expresses a rotation in space. quaternion: four outputs, normalised, "
             "for any number of turns; vector: a rotation vector, of less than a turn from where "
             "the ends and the start of the window put the rod; six: two columns of the matrix "
             "that turns it on from there, made orthonormal (Zhou et al. 2019), in one window; "
             "measured to be the worst of the three beyond a quarter of a turn. In a plane it is "
             "an angle."},

    {"losses.interior.points", CONFIG_INTEGER, AT(settings.losses.interior.points), BETWEEN(1, 1e8),
     .fallback = "256 static, 1024 dynamic; without hidden layers 4 for each function",
     .help = "Collocation points of the balance and kinematic equations."},
    {"losses.interior.sampler", CONFIG_CHOICE, AT(settings.losses.interior.sampler),
     .names = sampler_names,
     .fallback = "sobol; chebyshev_lobatto without hidden layers; of members uniform",
     .help = "Where they lie; of a family in the strain form, how its members are drawn from the "
             "ranges: uniform, latin_hypercube or sobol."},
    {"losses.interior.resample_every", CONFIG_INTEGER, AT(settings.losses.interior.resample_every),
     .unit = "steps", BETWEEN(0, 1e9), .help = "New points so often; 0: never."},
    {"losses.interior.adaptive.kind", CONFIG_CHOICE, AT(settings.losses.adaptive.kind),
     .names = adaptive_names,
     .help = "Points that move to where residuals are large, their number the same. rad: all drawn "
             "anew with density |r|^power/mean + floor; rar_g: a twentieth at a time, up to half, "
             "gives way to the worst candidates; gaussian: half lie around the worst candidates."},
    {"losses.interior.adaptive.every", CONFIG_INTEGER, AT(settings.losses.adaptive.every),
     .unit = "steps", BETWEEN(1, 1e9),
     .fallback = "100; 5 where training begins with gauss_newton",
     .help = "They move so often."},
    {"losses.interior.adaptive.candidates", CONFIG_INTEGER, AT(settings.losses.adaptive.candidates),
     BETWEEN(0, 1e8), .help = "Places where the residual is looked at; 0: ten for each point."},
    {"losses.interior.adaptive.power", CONFIG_NUMBER, AT(settings.losses.adaptive.power), POSITIVE,
     .help = "rad: larger values crowd the points together."},
    {"losses.interior.adaptive.floor", CONFIG_NUMBER, AT(settings.losses.adaptive.floor),
     NOT_NEGATIVE, .help = "rad: larger values spread them."},
    {"losses.interior.adaptive.width", CONFIG_NUMBER, AT(settings.losses.adaptive.width),
     BETWEEN(0, 1), .flags = CONFIG_LOW_OPEN,
     .help = "gaussian: standard deviation, in parts of the length and of the window of time."},
    {"losses.interior.weights.strain", CONFIG_NUMBER, AT(settings.weights.strain), LOSS_WEIGHT,
     .help = "Weight of r_s = R v, of beams w_s = slope + V/kGA (mixed form)."},
    {"losses.interior.weights.curvature", CONFIG_NUMBER, AT(settings.weights.curvature),
     LOSS_WEIGHT, .help = "Weight of q_s = q u/2, of the twist of tubes, of beams slope_s = M/EI (mixed form)."},
    {"losses.interior.weights.force", CONFIG_NUMBER, AT(settings.weights.force), LOSS_WEIGHT,
     .help = "Weight of the balance of forces."},
    {"losses.interior.weights.moment", CONFIG_NUMBER, AT(settings.weights.moment), LOSS_WEIGHT,
     .help = "Weight of the balance of moments, also of each tube."},
    {"losses.boundary.points", CONFIG_INTEGER, AT(settings.losses.boundary.points), BETWEEN(1, 1e8),
     .fallback = "1 static, 64 dynamic", .help = "Instants at both ends (soft enforcement)."},
    {"losses.boundary.sampler", CONFIG_CHOICE, AT(settings.losses.boundary.sampler),
     .names = sampler_names, .help = "Where they lie."},
    {"losses.boundary.resample_every", CONFIG_INTEGER, AT(settings.losses.boundary.resample_every),
     .unit = "steps", BETWEEN(0, 1e9), .help = "New points so often; 0: never."},
    {"losses.boundary.weight", CONFIG_NUMBER, AT(settings.weights.boundary), LOSS_WEIGHT,
     .help = "Weight of the end conditions (soft enforcement)."},
    {"losses.initial.points", CONFIG_INTEGER, AT(settings.losses.initial.points), BETWEEN(1, 1e8),
     .help = "Points at t = 0 (soft enforcement)."},
    {"losses.initial.sampler", CONFIG_CHOICE, AT(settings.losses.initial.sampler), .names = sampler_names,
     .help = "Where they lie."},
    {"losses.initial.resample_every", CONFIG_INTEGER, AT(settings.losses.initial.resample_every),
     .unit = "steps", BETWEEN(0, 1e9), .help = "New points so often; 0: never."},
    {"losses.initial.weight", CONFIG_NUMBER, AT(settings.weights.initial), LOSS_WEIGHT,
     .help = "Weight of the initial state (soft enforcement)."},
    {"losses.held_out_points", CONFIG_INTEGER, AT(settings.losses.held_out_points), BETWEEN(1, 1e8),
     .fallback = "256 static, 1024 dynamic",
     .help = "Points per loss term that are only watched, never trained on."},
    {"losses.balance", CONFIG_CHOICE, AT(settings.losses.balance), .names = balance_names,
     .help = "gradient_norm: in stages of adam, factors on the weights above keep the gradients of "
             "all loss terms equally long; other stages take the factors as they are."},
    {"losses.balance_every", CONFIG_INTEGER, AT(settings.losses.balance_every), .unit = "steps",
     BETWEEN(1, 1e9), .help = "Steps between updates of the factors."},
    {"losses.balance_memory", CONFIG_NUMBER, AT(settings.losses.balance_memory), BETWEEN(0, 1),
     .flags = CONFIG_HIGH_OPEN, .help = "What an update keeps of the factors before; 0: nothing."},
    {"losses.self_adaptive.rate", CONFIG_NUMBER, AT(settings.losses.self_adaptive_rate), NOT_NEGATIVE,
     .help = "In stages of adam, every point has a weight that climbs by gradient ascent at this "
             "rate, as 0.01, most where the loss is large; other stages take the weights as they "
             "are. 0: off."},
    {"losses.causal.slices", CONFIG_INTEGER, AT(settings.losses.causal_slices), BETWEEN(0, 10000),
     .help = "Slices of time for causal weighting; 0: off."},
    {"losses.causal.epsilon", CONFIG_NUMBER, ENTRIES(1, PROBLEM_EPSILONS_MAX),
     AT(settings.losses.causal_epsilon), .count_offset = offsetof(config, settings.losses.causal_epsilon_count),
     POSITIVE, .help = "Strengths of the causal weights, in turn."},
    {"losses.causal.threshold", CONFIG_NUMBER, AT(settings.losses.causal_threshold), BETWEEN(0, 1),
     .flags = CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN,
     .help = "The next strength when every weight exceeds this."},
    {"losses.causal.update_every", CONFIG_INTEGER, AT(settings.losses.causal_update_every),
     BETWEEN(1, 1000000), .unit = "steps",
     .help = "Steps between updates of the causal weights; lbfgs and ssbroyden start anew at "
             "each."},

    {"data[].quantity", CONFIG_CHOICE, AT(settings.data[0].quantity), .names = train_quantity_names,
     .fallback = "required",
     .help = "Measurements as a term of the loss beside the equations; rotations by the angle between "
             "them. History has it as data0_position and so on, in units of the noise."},
    {"data[].file", CONFIG_TEXT, AT(settings.data[0].file), .fallback = "required",
     .help = "CSV or HDF5, a row for each place: columns s, in motion t, and those of the quantity, "
             "named and in units as cpinn-eval writes them; relative to this file. Others are left, and "
             "of the quantity nan or an empty field is a number that is missing."},
    {"data[].noise", CONFIG_NUMBER, AT(settings.data[0].noise), NOT_NEGATIVE,
     .unit = "of the SI, rad",
     .help = "Standard deviation of each number: differences count in its units; 0: in those of the "
             "scene, L for positions."},
    {"data[].weight", CONFIG_NUMBER, AT(settings.data[0].weight), LOSS_WEIGHT,
     .fallback = "1; 1e-6 with noise, so that the equations count for more than it",
     .help = "Weight of the mean of their squares in training. Where there are unknowns it is one for "
             "all entries, which count by their noise."},

    {"training.seed", CONFIG_LONG, AT(settings.seed), BETWEEN(0, 9007199254740992), .help = "Fixes everything random."},
    {"training.stages[].optimizer", CONFIG_CHOICE, STAGE(optimizer), .names = train_optimizer_names,
     .fallback = "required",
     .help = "Stages run in turn; gauss_newton is Levenberg-Marquardt, ssbroyden self-scaled Broyden, "
             "soap Adam in the eigenvectors of Shampoo. "
             "Without training.stages there is one: gauss_newton for up to 200 steps, with "
             "function_tolerance 0.2. Defaults below are those of a stage that is given."},
    {"training.stages[].steps", CONFIG_INTEGER, STAGE(steps), BETWEEN(1, 1e9),
     .help = "Length of the stage."},
    {"training.stages[].learning_rate", CONFIG_NUMBER, STAGE(adam.schedule.learning_rate),
     .low = 0, .high = INFINITY, .flags = CONFIG_LOW_OPEN | LIKE_ADAM,
     .help = "Highest step size of Adam."},
    {"training.stages[].schedule", CONFIG_CHOICE, STAGE(adam.schedule.kind),
     .names = schedule_names, ADAM, .help = "How the learning rate falls."},
    {"training.stages[].warmup_steps", CONFIG_LONG, STAGE(adam.schedule.warmup_steps),
     .unit = "steps", BETWEEN(0, 1e9), ADAM, .help = "The learning rate rises first, so long."},
    {"training.stages[].decay_steps", CONFIG_LONG, STAGE(adam.schedule.decay_steps),
     .unit = "steps", BETWEEN(1, 1e9), ADAM, .fallback = "steps less warmup_steps",
     .help = "cosine: falls for so long; exponential: falls by decay_factor in so many steps."},
    {"training.stages[].final_fraction", CONFIG_NUMBER, STAGE(adam.schedule.final_fraction),
     BETWEEN(0, 1), ADAM, .help = "cosine: what is left of the learning rate at the end."},
    {"training.stages[].decay_factor", CONFIG_NUMBER, STAGE(adam.schedule.decay_factor),
     BETWEEN(0, 1), .flags = LIKE_ADAM | CONFIG_LOW_OPEN,
     .help = "exponential: factor per decay_steps."},
    {"training.stages[].beta1", CONFIG_NUMBER, STAGE(adam.beta1), BETWEEN(0, 1),
     .flags = LIKE_ADAM | CONFIG_HIGH_OPEN, .fallback = "0.9, soap 0.95",
     .help = "Memory of the gradient's mean."},
    {"training.stages[].beta2", CONFIG_NUMBER, STAGE(adam.beta2), BETWEEN(0, 1),
     .flags = LIKE_ADAM | CONFIG_HIGH_OPEN, .fallback = "0.999, soap 0.95",
     .help = "Memory of the gradient's square."},
    {"training.stages[].epsilon", CONFIG_NUMBER, STAGE(adam.epsilon), .low = 0, .high = INFINITY,
     .flags = LIKE_ADAM | CONFIG_LOW_OPEN, .help = "Keeps Adam's division finite."},
    {"training.stages[].clip_norm", CONFIG_NUMBER, STAGE(adam.clip_norm), NOT_NEGATIVE, ADAM,
     .help = "Gradients longer than this are shortened to it; 0: never."},
    {"training.stages[].memory", CONFIG_INTEGER, STAGE(lbfgs.memory), BETWEEN(1, 1000), LBFGS,
     .help = "Pairs that L-BFGS remembers."},
    {"training.stages[].sufficient_decrease", CONFIG_NUMBER,
     STAGE(lbfgs.descent.sufficient_decrease), BETWEEN(0, 0.5),
     .flags = LINE_SEARCH | CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN,
     .help = "c1 of the strong Wolfe conditions."},
    {"training.stages[].curvature", CONFIG_NUMBER, STAGE(lbfgs.descent.curvature), BETWEEN(0, 1),
     .flags = LINE_SEARCH | CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN,
     .help = "c2 of the strong Wolfe conditions, above c1."},
    {"training.stages[].maximum_line_evaluations", CONFIG_INTEGER,
     STAGE(lbfgs.descent.maximum_line_evaluations), BETWEEN(2, 1000), .flags = LINE_SEARCH,
     .help = "Evaluations in one line search."},
    {"training.stages[].maximum_step", CONFIG_NUMBER, STAGE(lbfgs.descent.maximum_step), .low = 0,
     .high = INFINITY, .flags = LINE_SEARCH | CONFIG_LOW_OPEN,
     .help = "Longest step; a loss still falling there counts as unbounded."},
    {"training.stages[].gradient_tolerance", CONFIG_NUMBER, STAGE(lbfgs.descent.gradient_tolerance),
     NOT_NEGATIVE, .flags = NOT_ADAM,
     .help = "The stage ends when no gradient component is larger."},
    {"training.stages[].function_tolerance", CONFIG_NUMBER, STAGE(lbfgs.descent.function_tolerance),
     BETWEEN(0, 1), .flags = NOT_ADAM | CONFIG_HIGH_OPEN,
     .help = "... when a step, gauss_newton three in turn, changes the loss relatively by no more."},
    {"training.stages[].step_tolerance", CONFIG_NUMBER, STAGE(lbfgs.descent.step_tolerance),
     BETWEEN(0, 1), .flags = NOT_ADAM | CONFIG_HIGH_OPEN,
     .help = "... when a step changes the parameters relatively by no more."},
    {"training.stages[].curvature_threshold", CONFIG_NUMBER,
     STAGE(lbfgs.descent.curvature_threshold), BETWEEN(0, 1),
     .flags = LINE_SEARCH | CONFIG_HIGH_OPEN,
     .help = "Pairs of less curvature are forgotten."},
    {"training.stages[].linear_algebra", CONFIG_CHOICE, STAGE(linear_algebra),
     .names = train_linear_algebra_names, GAUSS_NEWTON,
     .help = "How steps are computed; automatic: by the numbers of parameters and residuals, "
             "separate for linear networks in the strain form, matrix_free, with scaling identity, "
             "where matrices would take more than 2 GB or kernel seconds a step."},
    {"training.stages[].scaling", CONFIG_CHOICE, STAGE(gauss_newton.scaling),
     .names = scaling_names, GAUSS_NEWTON,
     .fallback = "identity; without hidden layers diagonal in motion and for beams",
     .help = "What is damped: every parameter alike, or by the diagonal of J^T J."},
    {"training.stages[].initial_damping", CONFIG_NUMBER, STAGE(gauss_newton.initial_damping),
     .low = 0, .high = INFINITY, .flags = CONFIG_FOR_GAUSS_NEWTON | CONFIG_LOW_OPEN,
     .fallback = "0.001; 1e-10 without hidden layers",
     .help = "In units of the largest diagonal entry of J^T J (identity) or of 1 (diagonal)."},
    {"training.stages[].maximum_damping", CONFIG_NUMBER, STAGE(gauss_newton.maximum_damping),
     .low = 0, .high = INFINITY, .flags = CONFIG_FOR_GAUSS_NEWTON | CONFIG_LOW_OPEN,
     .help = "The stage ends when no step lowers the loss up to here; same units."},
    {"training.stages[].damping_increase", CONFIG_NUMBER, STAGE(gauss_newton.damping_increase),
     .low = 1, .high = INFINITY, .flags = CONFIG_FOR_GAUSS_NEWTON | CONFIG_LOW_OPEN,
     .help = "Factor after a step that did not lower the loss and is not taken."},
    {"training.stages[].damping_decrease", CONFIG_NUMBER, STAGE(gauss_newton.damping_decrease),
     BETWEEN(0, 1), .flags = CONFIG_FOR_GAUSS_NEWTON | CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN,
     .help = "Factor after one that lowered it as predicted; a root of it after a smaller fall."},
    {"training.stages[].targets", CONFIG_CHOICE, STAGE(targets), .names = train_targets_names,
     .help = "Of a family in the strain form. solved: members of members.solved; physics: new "
             "members in every step, by a step of Newton's method from what the network says; both: half "
             "of a step's members of either kind."},
    {"training.stages[].stop.loss", CONFIG_NUMBER, STAGE(stop_loss), NOT_NEGATIVE,
     .help = "The stage ends when the loss falls below; 0: never."},
    {"training.stages[].stop.error", CONFIG_NUMBER, STAGE(stop_error), NOT_NEGATIVE,
     .help = "... when the error against the reference falls below; 0: never."},
    {"training.stages[].stop.seconds", CONFIG_NUMBER, STAGE(stop_seconds), .unit = "s",
     NOT_NEGATIVE, .help = "... after so much wall time (not reproducible); 0: never."},
    {"training.stages[].stop.held_out_ratio", CONFIG_NUMBER, STAGE(stop_held_out_ratio),
     NOT_NEGATIVE,
     .help = "... when the held-out loss exceeds the training loss by this factor, and reaches no "
             "new minimum, in 5 rows of history in turn; 0: never."},


    {"surrogate.step", CONFIG_NUMBER, AT(surrogate.step), .unit = "s", POSITIVE,
     .fallback = "none: a network of the scene is trained",
     .help = "What is trained is a one-step model of the robot: the state of its reduced rod "
             "(cpinn-solve --method modes) so much later, for inputs within the ranges of the "
             "parameters; for filters and controllers (cpinn-control)."},
    {"surrogate.kind", CONFIG_CHOICE, AT(surrogate.kind), .names = surrogate_kinds,
     .help = "flow: a linear map, and a network for what it leaves over of solved steps, in a frame "
             "that turns with the robot where that has such a symmetry; linear: the map alone. "
             "Others are curves in time that begin at the state, so that any part of a step has an "
             "answer, learned from the rod's equations: polynomial: values at the nodes of Radau's "
             "method, in that frame; ddpinn: damped sines (Krauss et al. 2024); polynomial_flow, "
             "ddpinn_flow: both beside the exact linear flow."},
    {"surrogate.terms", CONFIG_INTEGER, AT(surrogate.terms), BETWEEN(1, 16),
     .help = "Of ddpinn: damped sines for each number of the state."},
    {"surrogate.weights", CONFIG_CHOICE, AT(surrogate.weights), .names = surrogate_weights,
     .help = "Of ddpinn: tip: residuals count by the error that they leave, that by what it does to the "
             "tip, and states are moved off the motions a little; plain: the mean square of z' - f "
             "along the motions, as published."},
    {"surrogate.physics", CONFIG_NUMBER, AT(surrogate.physics), BETWEEN(0, 1e6),
     .fallback = "1",
     .help = "Of curves in time: weight of the rod's equations in the loss."},
    {"surrogate.data", CONFIG_NUMBER, AT(surrogate.data), BETWEEN(0, 1e6),
     .fallback = "0", .help = "Of curves in time: weight of solved steps."},
    {"surrogate.ahead", CONFIG_INTEGER, AT(surrogate.ahead), BETWEEN(1, 32), .unit = "steps",
     .help = "Of damped sines: steps in a row that the loss follows an error."},
    {"surrogate.modes", CONFIG_INTEGER, ENTRIES(4, 4), AT(surrogate.modes), BETWEEN(0, 12),
     .fallback = "the fewest within surrogate.tolerance, when training begins",
     .help = "Of the reduced rod: bending, twist, stretch, shear, in each direction and segment; "
             "all 0: open."},
    {"surrogate.tolerance", CONFIG_NUMBER, AT(surrogate.tolerance), BETWEEN(1e-6, 0.5),
     .flags = CONFIG_LOW_OPEN,
     .help = "Modes are chosen so that the tip in motion is off that of 5, 3, 4, 3 modes by no more "
             "of the length (median of rollouts)."},
    {"surrogate.inputs", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX), AT(surrogate.inputs),
     .count_offset = offsetof(config, surrogate.input_count),
     .fallback = "all parameters with a range that are not among surrogate.parameters",
     .help = "Names of parameters with a range that actuators set."},
    {"surrogate.parameters", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX), AT(surrogate.parameters),
     .count_offset = offsetof(config, surrogate.parameter_count), .fallback = "none",
     .help = "Names of those that stay, as a stiffness or a load, and that a filter finds."},
    {"surrogate.hold", CONFIG_CHOICE, AT(surrogate.hold), .names = surrogate_holds,
     .help = "constant: inputs stay while a step lasts; linear: they go linearly to those of its "
             "end."},
    {"surrogate.solved", CONFIG_INTEGER, AT(surrogate.solved), BETWEEN(500, 1e7), .unit = "steps",
     .help = "Steps of the reduced rod to learn from, of rollouts under steps, ramps, bang-bang and "
             "chirps of the inputs; a tenth as many beside them measure the held-out loss."},

    CONTROL_ROWS

    {"checkpoint.every", CONFIG_INTEGER, AT(settings.checkpoint_every), .unit = "steps", BETWEEN(1, 1e9),
     .help = "Save so often."},
    {"checkpoint.seconds", CONFIG_NUMBER, AT(settings.checkpoint_seconds), .unit = "s", POSITIVE,
     .help = "Or after so much wall time, whichever is first."},
    {"checkpoint.keep", CONFIG_INTEGER, AT(settings.checkpoint_keep), BETWEEN(1, 1000),
     .help = "How many checkpoints are kept."},
    {"output.every", CONFIG_INTEGER, AT(settings.output_every), .unit = "steps", BETWEEN(1, 1e9),
     .fallback = "10; 1 where training begins with gauss_newton in one window",
     .help = "Steps between rows of history.csv, which every stage ends with as well."},
    {"output.tensorboard", CONFIG_CHOICE, AT(settings.output_tensorboard), .names = truth_names,
     .help = "Every column of history.csv also goes to event files, events.out.tfevents.*, which "
             "`tensorboard --logdir runs` shows while training goes on."},
    {"reference.analytic", CONFIG_CHOICE, AT(settings.reference), .names = train_reference_names,
     .help = "A known solution of this scene to measure the error against."},
    {"reference.solve", CONFIG_NUMBER, AT(settings.reference_tolerance), BETWEEN(1e-13, 0.1),
     .flags = CONFIG_BY_NAME,
     .help = "Or a classical solution (cpinn-solve) to this estimated error of the position over "
             "the length, of a beam's deflection over the largest. `reference: solve`: 1e-11 at "
             "rest, 1e-8 in motion, 1e-4 there where shear or stretch is locked. Kept in the folder cpinn of XDG_CACHE_HOME, else of ~/.cache, "
             "until the physics changes."},
    {"reference.file", CONFIG_TEXT, AT(settings.reference_file),
     .help = "Or CSV/HDF5 with columns s[, t], x, y, z[, qw, qx, qy, qz], of a beam s[, t], w[, "
             "slope]; relative to this file."},
    {FORMULA("reference.deflection", settings.reference_deflection), .unit = "m",
     .help = "Or the known deflection of a beam; formula of s and t."},
};
/* clang-format on */
const int config_key_count = (int)(sizeof config_keys / sizeof *config_keys);

#define LIST(path, one, many, required, least, most, entries, count)                               \
    {                                                                                              \
        path, one, many, required, least, most, offsetof(config, entries),                         \
            sizeof(((config *)NULL)->entries[0]), offsetof(config, count)                          \
    }
const config_list config_lists[] = {
    LIST("training.stages", "stage", "stages", "optimizer", 1, TRAIN_STAGES_MAX, settings.stages,
         settings.stage_count),
    LIST("data", "data set", "data sets", "quantity", 0, TRAIN_DATA_MAX, settings.data,
         settings.data_count),
    LIST("tables", "table", "tables", NULL, 0, CONFIG_TABLES_MAX, tables, table_count),
    LIST("segments", "segment", "segments", NULL, 0, SCENE_SEGMENTS_MAX, scene.segments,
         scene.segment_count),
    LIST("loads.points", "point", "points", NULL, 0, SCENE_POINTS_MAX, scene.points,
         scene.point_count),
    LIST("bodies", "body", "bodies", NULL, 0, SCENE_BODIES_MAX, scene.bodies, scene.body_count),
    LIST("springs", "spring", "springs", NULL, 0, SCENE_SPRINGS_MAX, scene.springs,
         scene.spring_count),
    LIST("tendons", "tendon", "tendons", NULL, 0, SCENE_TENDONS_MAX, scene.tendons,
         scene.tendon_count),
    LIST("chambers", "chamber", "chambers", NULL, 0, SCENE_CHAMBERS_MAX, scene.chambers,
         scene.chamber_count),
    LIST("tubes", "tube", "tubes", NULL, 0, SCENE_TUBES_MAX, scene.tubes, scene.tube_count),
    CONTROL_LISTS LIST("beam.points", "point", "points", NULL, 0, SCENE_POINTS_MAX,
                       scene.beam.points, scene.beam.point_count),
};
const int config_list_count = (int)(sizeof config_lists / sizeof *config_lists);
