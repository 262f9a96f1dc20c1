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
     .help = "Name of the experiment. Results go to runs/<name>."},

    {CONFIG_PARAMETER_PATH, CONFIG_PARAMETER, ANY,
     .help = "A name for a number, for use in the formulas of the scene, as in parameters: {load: "
             "0.3} and then \"-load*s\". --set parameters.load=0.5 changes it. It may be a "
             "formula of s, t and of the parameters before it. With {range: [0, 2]} in place of a "
             "number the scene is a family."},

    {CONFIG_PARAMETER_PATH ".range", CONFIG_NUMBER, AT(parameters[0].range), ENTRIES(2, 2), ANY,
     .help = "The least and the largest value of a parameter that stays open. One training or one "
             "batch of members covers all values between."},
    {CONFIG_PARAMETER_PATH ".identify", CONFIG_NUMBER, AT(parameters[0].identify), ANY,
     .help = "The first guess of an unknown number, which is found within its range from the "
             "measurements under data. {identify: 6e10, range: [1e10, 1e11]} may also stand in "
             "place of any number of the scene."},
    {CONFIG_PARAMETER_PATH ".scale", CONFIG_CHOICE, AT(parameters[0].scale),
     .names = scene_scale_names,
     .help = "How members are spread over the range and how networks see it. log: by the "
             "logarithm of the value, for a range over powers of ten.",
     .fallback = "linear; of what is to be identified log from 1:100 on"},

    {"tables[].name", CONFIG_TEXT, AT(tables[0].name), .fallback = "required",
     .help = "Name of a function for the formulas, as in wind(s) or 2*pull(t). It goes through "
             "the rows of a table without overshoot, as cubics with a continuous slope. Formulas "
             "that use it must stay within its rows."},
    {"tables[].file", CONFIG_TEXT, AT(tables[0].file),
     .help = "CSV or HDF5 with two columns, argument and value in SI units, 2 to 200 rows with "
             "ascending arguments. The path is relative to this file."},
    {"tables[].x", CONFIG_NUMBER, ENTRIES(2, QUANTITY_TABLE_MAX), AT(tables[0].x),
     .count_offset = offsetof(config, tables[0].x_count), ANY,
     .help = "The arguments of the table, ascending, in place of a file."},
    {"tables[].y", CONFIG_NUMBER, ENTRIES(2, QUANTITY_TABLE_MAX), AT(tables[0].y),
     .count_offset = offsetof(config, tables[0].y_count), ANY, .help = "The values of the table, "
                                                                       "in place of a file."},

    {"rod.model", CONFIG_CHOICE, AT(scene.rod.model), .names = scene_model_names,
     .help = "cosserat: bends, twists, shears and stretches. inextensible: does not stretch. "
             "kirchhoff: neither shears nor stretches. Beams of small deflection (see beam): "
             "euler_bernoulli bends, timoshenko also shears."},
    SCENE_LENGTH_ROWS(SCENE_QUANTITY)
    {"rod.section.shape", CONFIG_CHOICE, AT(scene.rod.section), .names = scene_section_names,
     .help = "Cross-section. none: stiffness and inertia are given instead."},
    SCENE_MATTER_ROWS(SCENE_QUANTITY, "rod.", rod.)
    SCENE_REST_ROWS(SCENE_QUANTITY, "rod.", rod.)
    SCENE_DAMPING_ROWS(SCENE_QUANTITY, "rod.", rod.)
    {"rod.law.file", CONFIG_TEXT, AT(law.file),
     .help = "A nonlinear law of the section in place of n = Kse (v - v*), m = Kbt (u - u*): a "
             "potential that cpinn-law has learned. The path is relative to this file. Its "
             "stiffness at rest is rod.stiffness. For rods without tubes, at rest and in motion; "
             "families need formulation mixed."},
    {"rod.law.numbers", CONFIG_NUMBER, ENTRIES(1, SCENE_LAW_NUMBERS_MAX), AT(law.numbers),
     .count_offset = offsetof(config, law.count), .low = -INFINITY, .high = INFINITY,
     .flags = CONFIG_INFINITE, .help = "The numbers of a law, in place of its file; "
                                       "--print-config writes them."},

    SCENE_PIECE_ROWS(SCENE_QUANTITY, "segments[].", segments[0].)
    {"segments[].section.shape", CONFIG_CHOICE, AT(scene.segments[0].rod.section),
     .names = scene_section_names, .help = "Cross-section of this piece; none: as under rod."},
    SCENE_MATTER_ROWS(SEGMENT_QUANTITY, "segments[].", segments[0].rod.)
    SCENE_REST_ROWS(SEGMENT_QUANTITY, "segments[].", segments[0].rod.)
    SCENE_DAMPING_ROWS(SEGMENT_QUANTITY, "segments[].", segments[0].rod.)
    SCENE_TURN_ROWS(SCENE_QUANTITY, "segments[].", segments[0].)

    {"loads.units", CONFIG_CHOICE, AT(load_units), .names = unit_names,
     .help = "Units of the forces and moments below. SI, or EI: multiples of EI/L^2 and EI/L at "
             "ends and points, and of EI/L^3 and EI/L^2 along the rod (EI about d1)."},
    SCENE_LINE_ROWS(SCENE_QUANTITY)
    {"loads.frame", CONFIG_CHOICE, AT(scene.loads.frame), .names = scene_frame_names,
     .help = "Frame of the distributed loads. dead: fixed in the world. follower: turns with the "
             "rod."},
    SCENE_BASE_ROWS(SCENE_QUANTITY)
    {"loads.base.frame", CONFIG_CHOICE, AT(scene.loads.base.frame), .names = scene_frame_names,
     .help = "dead: the load is fixed in the world. follower: it turns with this end."},
    SCENE_TIP_ROWS(SCENE_QUANTITY)
    {"loads.tip.frame", CONFIG_CHOICE, AT(scene.loads.tip.frame), .names = scene_frame_names,
     .help = "dead: the load is fixed in the world. follower: it turns with the tip."},
    SCENE_POINT_ROWS(SCENE_QUANTITY, "loads.points[].", points[0].)
    {"loads.points[].frame", CONFIG_CHOICE, AT(scene.points[0].load.frame),
     .names = scene_frame_names,
     .help = "dead: the load is fixed in the world. follower: it turns with the rod there."},

    SCENE_BODY_ROWS(SCENE_QUANTITY, "bodies[].", bodies[0].)

    SCENE_SPRING_ROWS(SCENE_QUANTITY, "springs[].", springs[0].)

    SCENE_TENDON_ROWS(SCENE_QUANTITY, "tendons[].", tendons[0].)

    SCENE_CHAMBER_ROWS(SCENE_QUANTITY, "chambers[].", chambers[0].)

    SCENE_TUBE_ROWS(SCENE_QUANTITY, "tubes[].", tubes[0].)

    SCENE_BEAM_ROWS(SCENE_QUANTITY)
    SCENE_BEAM_POINT_ROWS(SCENE_QUANTITY, "beam.points[].", beam.points[0].)

    {"boundary.start.type", CONFIG_CHOICE, AT(scene.start.type), .names = scene_end_names,
     .help = "What holds the end s = 0: clamped; pinned (position only, a simple support); free; "
             "loaded (loads.base, beam.base); driven (formulas of t); guided; roller."},
    SCENE_START_ROWS(SCENE_QUANTITY)
    {"boundary.end.type", CONFIG_CHOICE, AT(scene.end.type), .names = scene_end_names,
     .fallback = "loaded when loads.tip or beam.tip is given, else free",
     .help = "What holds the end s = length, as boundary.start.type; loaded: loads.tip, beam.tip."},
    SCENE_END_ROWS(SCENE_QUANTITY)

    SCENE_INITIAL_ROWS(SCENE_QUANTITY)
    {"initial.state", CONFIG_CHOICE, AT(scene.initial.state), .names = scene_state_names,
     .help = "given: the keys above say it. equilibrium: the rod or beam starts in its "
             "equilibrium under the loads at t = 0. So \"where(t, 0, 2)\" as a load lets go of a "
             "rod that a load of 2 has bent."},

    SCENE_DURATION_ROWS(SCENE_QUANTITY)
    {"time.windows", CONFIG_INTEGER, AT(settings.windows), BETWEEN(1, SCENE_WINDOWS_MAX),
     .fallback = "1; without hidden layers as many as last L^2/6 (rhoA/EI)^(1/2) at most",
     .help = "Number of equal parts of the duration. They are trained in turn, each with a "
             "network of its own that starts exactly where the one before ends. training.stages "
             "are run in each."},

    SCENE_EXACT_ROWS(SCENE_QUANTITY)

    {"formulation", CONFIG_CHOICE, AT(scene.formulation), .names = scene_formulation_names,
     .fallback = "mixed; of families at rest and of motions without hidden layers strain, where it takes the "
                 "scene and there are no data",
     .help = "mixed: unknowns r, q, N, m, first order in s; of beams w, slope, V, M. "
             "displacement: r, q, second order; of beams the strong form, w, fourth order, with "
             "the slope, second order, of timoshenko beams. strain, of a family at rest: the "
             "curvature as a function of the parameters, learnt from members. strain, of one "
             "motion: strain modes along s whose amplitudes are a network of time "
             "(network.modes). pose_strain, after Bensch et al. 2024: r, q and the strains v, u; "
             "the strains of the pose are residuals."},
    {"members.solved", CONFIG_INTEGER, AT(settings.members), BETWEEN(0, 100000000),
     .fallback = "in the strain form 131072, of one parameter 8192, of two 32768; else 0",
     .help = "Members of a family in the strain form that are drawn from the ranges and solved "
             "before training, 16 at least."},
    {"members.file", CONFIG_TEXT, AT(settings.members_file),
     .help = "CSV or HDF5 with a column for every parameter, such as measured actuations. These "
             "members are solved and learnt in place of drawn ones, without hidden layers all at "
             "once. Held-out and fresh members are still drawn from the ranges. The path is "
             "relative to this file."},
    {"motion", CONFIG_CHOICE, AT(scene.motion), .names = scene_motion_names,
     .help = "automatic: in a plane, with 6 unknowns instead of 13, if symmetry keeps the rod in "
             "it, else in space. planar: in a plane; refused where the rod leaves it. spatial: "
             "always in space, as for a column that may buckle sideways."},
    {"enforcement.boundary", CONFIG_CHOICE, AT(scene.boundary_enforcement),
     .names = scene_enforcement_names,
     .help = "How the conditions at the ends are met. hard: the network's outputs are put into a "
             "form that meets them exactly. soft: they are a loss term of weight "
             "losses.boundary.weight, and hold as well as training meets them."},
    {"enforcement.initial", CONFIG_CHOICE, AT(scene.initial_enforcement),
     .names = scene_enforcement_names,
     .help = "How the state at t = 0 is met, with losses.initial.weight if soft. Several windows "
             "of time need hard."},

    {"network.hidden", CONFIG_INTEGER, ENTRIES(0, NN_HIDDEN_MAX), AT(settings.network.hidden),
     .count_offset = offsetof(config, settings.network.hidden_count), BETWEEN(1, 4096),
     .fallback = "[] where training begins with gauss_newton, else [32, 32, 32]; in the strain form [] for "
                 "up to four parameters, else [128, 128, 128]",
     .help = "Widths of the hidden layers. []: the network is linear in its parameters, a sum of "
             "fixed functions, and Gauss-Newton finds it in a few steps."},
    {"network.activation", CONFIG_CHOICE, AT(settings.network.activation), .names = activation_names,
     .help = "Activation between the layers."},
    {"network.initialization", CONFIG_CHOICE, AT(settings.network.initialization),
     .names = initialization_names, .help = "How the weights are drawn."},
    {"network.fourier.features", CONFIG_INTEGER, AT(settings.network.fourier_features), BETWEEN(0, 1024),
     .fallback = "0; without hidden layers enough for the largest frequencies",
     .help = "Pairs sin, cos of random waves beside the inputs; 0: none."},
    {"network.fourier.wavenumber", CONFIG_NUMBER, AT(settings.fourier_wavenumber), .unit = "rad/m", POSITIVE,
     .fallback = "16 / rod.length, more for large loads; dynamic 12 / rod.length",
     .help = "Largest frequency of the random waves along s; they are drawn uniformly within."},
    {"network.fourier.parameters", CONFIG_NUMBER, AT(settings.fourier_parameters), .unit = "rad", POSITIVE,
     .fallback = "2 of a family, else null",
     .help = "Largest frequency of the random waves along each parameter, in half of its range."},
    {"network.fourier.frequency", CONFIG_NUMBER, AT(settings.fourier_frequency), .unit = "rad/s", POSITIVE,
     .fallback = "the third bending frequency of the cantilever",
     .help = "Largest frequency of the random waves in time."},
    {"network.polynomial.degree", CONFIG_INTEGER, AT(settings.network.degree), BETWEEN(0, NN_DEGREE_MAX),
     .fallback = "0; for one motion in the strain form 20, or 16 with damping; for families in the "
                 "strain form up to 1300 polynomials, each with 64 members",
     .help = "Polynomial chaos: in place of waves, all products of Legendre polynomials of the "
             "inputs up to this total degree. Inputs that move the rod little count two- or "
             "threefold."},
    {"network.modes", CONFIG_INTEGER, ENTRIES(4, 4), AT(settings.modes), BETWEEN(0, SOLVE_MODES_MAX),
     .fallback = "[12, 6, 10, 10] of one motion in the strain form, with network.tolerance what it takes; else 0",
     .help = "Strain modes of bending, twist, stretch and shear: Legendre polynomials along each "
             "piece of the rod, for each direction. A locked strain, or one across the plane of a "
             "motion, has none."},
    {"network.tolerance", CONFIG_NUMBER, AT(settings.tolerance), BETWEEN(1e-10, 0.1),
     .fallback = "1e-3; of one scene at rest in mixed form without hidden layers 5e-8",
     .help = "Bound of the estimated error, over the length or a beam's deflection; above it the "
             "verdict is a warning. For one motion in the strain form, cpinn-train raises "
             "network.modes and network.polynomial.degree until the estimate is below, if this "
             "key is given. Families in the strain form have an error for each answer instead."},
    {"network.inputs", CONFIG_CHOICE, AT(settings.groups.inputs), .names = input_names,
     .help = "Inputs of a network of the parameters alone. groups: the dimensionless numbers of "
             "the equations, such as forces by EI/L^2, which --explain lists. parameters: the "
             "parameters themselves, over their ranges."},
    {"network.symmetry", CONFIG_CHOICE, AT(settings.groups.symmetry), .names = symmetry_names,
     .help = "With inputs: groups. auto: members that a turn about d3 of the base or a mirror "
             "makes equal are learnt once, nearly equal ones of three or more equal tendons, too. "
             "exact: only members that are exactly equal. none: each member by itself."},
    {"network.rotation", CONFIG_CHOICE, AT(settings.rotation), .names = scene_rotation_names,
     .fallback = "quaternion; vector in motion without hidden layers, from a hard initial state",
     .help = "How the network expresses a rotation in space. quaternion: four outputs, "
             "normalised, for any number of turns. vector: a rotation vector of less than a turn "
             "from where the ends and the start of the window put the rod. six: two columns of "
             "the matrix that turns it on from there, made orthonormal (Zhou et al. 2019), in one "
             "window; measured to be the worst beyond a quarter of a turn. In a plane the output "
             "is an angle."},

    {"losses.interior.points", CONFIG_INTEGER, AT(settings.losses.interior.points), BETWEEN(1, 1e8),
     .fallback = "256 static, 1024 dynamic; without hidden layers 4 for each function",
     .help = "Collocation points of the balance and kinematic equations."},
    {"losses.interior.sampler", CONFIG_CHOICE, AT(settings.losses.interior.sampler),
     .names = sampler_names,
     .fallback = "sobol; chebyshev_lobatto without hidden layers; of members uniform",
     .help = "How the points are placed; for a family in the strain form, how members are drawn: "
             "uniform, latin_hypercube or sobol."},
    {"losses.interior.resample_every", CONFIG_INTEGER, AT(settings.losses.interior.resample_every),
     .unit = "steps", BETWEEN(0, 1e9), .help = "Steps between new points; 0: never."},
    {"losses.interior.adaptive.kind", CONFIG_CHOICE, AT(settings.losses.adaptive.kind),
     .names = adaptive_names,
     .help = "Moves points to where residuals are large. rad: all are drawn anew with density "
             "|r|^power/mean + floor. rar_g: a twentieth at a time, up to half, is replaced by "
             "the worst candidates. gaussian: half lie around the worst candidates."},
    {"losses.interior.adaptive.every", CONFIG_INTEGER, AT(settings.losses.adaptive.every),
     .unit = "steps", BETWEEN(1, 1e9),
     .fallback = "100; 5 where training begins with gauss_newton",
     .help = "Steps between moves of the points."},
    {"losses.interior.adaptive.candidates", CONFIG_INTEGER, AT(settings.losses.adaptive.candidates),
     BETWEEN(0, 1e8), .help = "Places at which the residual is computed for a move; 0: ten for "
                              "each point."},
    {"losses.interior.adaptive.power", CONFIG_NUMBER, AT(settings.losses.adaptive.power), POSITIVE,
     .help = "With rad: larger values concentrate the points."},
    {"losses.interior.adaptive.floor", CONFIG_NUMBER, AT(settings.losses.adaptive.floor),
     NOT_NEGATIVE, .help = "With rad: larger values spread the points."},
    {"losses.interior.adaptive.width", CONFIG_NUMBER, AT(settings.losses.adaptive.width),
     BETWEEN(0, 1), .flags = CONFIG_LOW_OPEN,
     .help = "With gaussian: standard deviation, as a fraction of the length and of the window of "
             "time."},
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
     .names = sampler_names, .help = "How these points are placed."},
    {"losses.boundary.resample_every", CONFIG_INTEGER, AT(settings.losses.boundary.resample_every),
     .unit = "steps", BETWEEN(0, 1e9), .help = "Steps between new points; 0: never."},
    {"losses.boundary.weight", CONFIG_NUMBER, AT(settings.weights.boundary), LOSS_WEIGHT,
     .help = "Weight of the end conditions (soft enforcement)."},
    {"losses.initial.points", CONFIG_INTEGER, AT(settings.losses.initial.points), BETWEEN(1, 1e8),
     .help = "Points at t = 0 (soft enforcement)."},
    {"losses.initial.sampler", CONFIG_CHOICE, AT(settings.losses.initial.sampler), .names = sampler_names,
     .help = "How these points are placed."},
    {"losses.initial.resample_every", CONFIG_INTEGER, AT(settings.losses.initial.resample_every),
     .unit = "steps", BETWEEN(0, 1e9), .help = "Steps between new points; 0: never."},
    {"losses.initial.weight", CONFIG_NUMBER, AT(settings.weights.initial), LOSS_WEIGHT,
     .help = "Weight of the initial state (soft enforcement)."},
    {"losses.held_out_points", CONFIG_INTEGER, AT(settings.losses.held_out_points), BETWEEN(1, 1e8),
     .fallback = "256 static, 1024 dynamic",
     .help = "Points per loss term that only measure, and are never trained on."},
    {"losses.balance", CONFIG_CHOICE, AT(settings.losses.balance), .names = balance_names,
     .help = "gradient_norm: in stages of adam, factors on the weights keep the gradients of all "
             "loss terms equally long. Other stages keep the factors."},
    {"losses.balance_every", CONFIG_INTEGER, AT(settings.losses.balance_every), .unit = "steps",
     BETWEEN(1, 1e9), .help = "Steps between updates of the factors."},
    {"losses.balance_memory", CONFIG_NUMBER, AT(settings.losses.balance_memory), BETWEEN(0, 1),
     .flags = CONFIG_HIGH_OPEN, .help = "Fraction of the old factors that an update keeps; 0: "
                                        "nothing."},
    {"losses.self_adaptive.rate", CONFIG_NUMBER, AT(settings.losses.self_adaptive_rate), NOT_NEGATIVE,
     .help = "Rate of self-adaptive weights, such as 0.01; 0: off. In stages of adam the weight "
             "of every point grows by gradient ascent, most where the loss is large. Other stages "
             "keep the weights."},
    {"losses.causal.slices", CONFIG_INTEGER, AT(settings.losses.causal_slices), BETWEEN(0, 10000),
     .help = "Slices of time for causal weighting; 0: off."},
    {"losses.causal.epsilon", CONFIG_NUMBER, ENTRIES(1, PROBLEM_EPSILONS_MAX),
     AT(settings.losses.causal_epsilon), .count_offset = offsetof(config, settings.losses.causal_epsilon_count),
     POSITIVE, .help = "Strengths of the causal weights, one after the other."},
    {"losses.causal.threshold", CONFIG_NUMBER, AT(settings.losses.causal_threshold), BETWEEN(0, 1),
     .flags = CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN,
     .help = "The next strength is taken when every weight exceeds this."},
    {"losses.causal.update_every", CONFIG_INTEGER, AT(settings.losses.causal_update_every),
     BETWEEN(1, 1000000), .unit = "steps",
     .help = "Steps between updates of the causal weights; lbfgs and ssbroyden start anew at "
             "each."},

    {"data[].quantity", CONFIG_CHOICE, AT(settings.data[0].quantity), .names = train_quantity_names,
     .fallback = "required",
     .help = "Measured quantity, a term of the loss beside the equations. Rotations count by the "
             "angle between them. history.csv has its column data0_position and so on, in units "
             "of the noise."},
    {"data[].file", CONFIG_TEXT, AT(settings.data[0].file), .fallback = "required",
     .help = "CSV or HDF5 with a row for each place: columns s, in motion t, and those of the "
             "quantity, named and in units as cpinn-eval writes them. Other columns are ignored; "
             "nan or an empty field is a missing number. The path is relative to this file."},
    {"data[].noise", CONFIG_NUMBER, AT(settings.data[0].noise), NOT_NEGATIVE,
     .unit = "of the SI, rad",
     .help = "Standard deviation of each number: differences count in its units. 0: in units of "
             "the scene, L for positions."},
    {"data[].weight", CONFIG_NUMBER, AT(settings.data[0].weight), LOSS_WEIGHT,
     .fallback = "1; 1e-6 with noise, so that the equations count for more than it",
     .help = "Weight of the mean square of the differences in training. With unknowns it is the "
             "same for all entries, which count by their noise."},

    {"training.seed", CONFIG_LONG, AT(settings.seed), BETWEEN(0, 9007199254740992), .help = "Seed "
                                                                                            "of "
                                                                                            "everything "
                                                                                            "random."},
    {"training.stages[].optimizer", CONFIG_CHOICE, STAGE(optimizer), .names = train_optimizer_names,
     .fallback = "required",
     .help = "Method of the stage; stages run in turn. gauss_newton is Levenberg-Marquardt, "
             "ssbroyden self-scaled Broyden, soap Adam in the eigenvectors of Shampoo. Without "
             "training.stages there is one stage: gauss_newton for up to 200 steps, with "
             "function_tolerance 0.2. The defaults below are those of a stage that is given."},
    {"training.stages[].steps", CONFIG_INTEGER, STAGE(steps), BETWEEN(1, 1e9),
     .help = "Largest number of steps of the stage."},
    {"training.stages[].learning_rate", CONFIG_NUMBER, STAGE(adam.schedule.learning_rate),
     .low = 0, .high = INFINITY, .flags = CONFIG_LOW_OPEN | LIKE_ADAM,
     .help = "Largest step size of Adam."},
    {"training.stages[].schedule", CONFIG_CHOICE, STAGE(adam.schedule.kind),
     .names = schedule_names, ADAM, .help = "How the learning rate falls."},
    {"training.stages[].warmup_steps", CONFIG_LONG, STAGE(adam.schedule.warmup_steps),
     .unit = "steps", BETWEEN(0, 1e9), ADAM, .help = "Steps over which the learning rate rises "
                                                     "first."},
    {"training.stages[].decay_steps", CONFIG_LONG, STAGE(adam.schedule.decay_steps),
     .unit = "steps", BETWEEN(1, 1e9), ADAM, .fallback = "steps less warmup_steps",
     .help = "cosine: steps over which the learning rate falls. exponential: steps in which it "
             "falls by decay_factor."},
    {"training.stages[].final_fraction", CONFIG_NUMBER, STAGE(adam.schedule.final_fraction),
     BETWEEN(0, 1), ADAM, .help = "cosine: fraction of the learning rate that is left at the end."},
    {"training.stages[].decay_factor", CONFIG_NUMBER, STAGE(adam.schedule.decay_factor),
     BETWEEN(0, 1), .flags = LIKE_ADAM | CONFIG_LOW_OPEN,
     .help = "exponential: factor of the learning rate per decay_steps."},
    {"training.stages[].beta1", CONFIG_NUMBER, STAGE(adam.beta1), BETWEEN(0, 1),
     .flags = LIKE_ADAM | CONFIG_HIGH_OPEN, .fallback = "0.9, soap 0.95",
     .help = "Decay rate of the mean of gradients."},
    {"training.stages[].beta2", CONFIG_NUMBER, STAGE(adam.beta2), BETWEEN(0, 1),
     .flags = LIKE_ADAM | CONFIG_HIGH_OPEN, .fallback = "0.999, soap 0.95",
     .help = "Decay rate of the mean of squared gradients."},
    {"training.stages[].epsilon", CONFIG_NUMBER, STAGE(adam.epsilon), .low = 0, .high = INFINITY,
     .flags = LIKE_ADAM | CONFIG_LOW_OPEN, .help = "Keeps the division of Adam finite."},
    {"training.stages[].clip_norm", CONFIG_NUMBER, STAGE(adam.clip_norm), NOT_NEGATIVE, ADAM,
     .help = "Longest gradient; longer ones are shortened to it. 0: never."},
    {"training.stages[].memory", CONFIG_INTEGER, STAGE(lbfgs.memory), BETWEEN(1, 1000), LBFGS,
     .help = "Number of pairs that L-BFGS keeps."},
    {"training.stages[].sufficient_decrease", CONFIG_NUMBER,
     STAGE(lbfgs.descent.sufficient_decrease), BETWEEN(0, 0.5),
     .flags = LINE_SEARCH | CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN,
     .help = "c1 of the strong Wolfe conditions."},
    {"training.stages[].curvature", CONFIG_NUMBER, STAGE(lbfgs.descent.curvature), BETWEEN(0, 1),
     .flags = LINE_SEARCH | CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN,
     .help = "c2 of the strong Wolfe conditions, above c1."},
    {"training.stages[].maximum_line_evaluations", CONFIG_INTEGER,
     STAGE(lbfgs.descent.maximum_line_evaluations), BETWEEN(2, 1000), .flags = LINE_SEARCH,
     .help = "Largest number of evaluations in one line search."},
    {"training.stages[].maximum_step", CONFIG_NUMBER, STAGE(lbfgs.descent.maximum_step), .low = 0,
     .high = INFINITY, .flags = LINE_SEARCH | CONFIG_LOW_OPEN,
     .help = "Longest step. A loss that still falls there counts as unbounded."},
    {"training.stages[].gradient_tolerance", CONFIG_NUMBER, STAGE(lbfgs.descent.gradient_tolerance),
     NOT_NEGATIVE, .flags = NOT_ADAM,
     .help = "The stage ends when no component of the gradient is larger."},
    {"training.stages[].function_tolerance", CONFIG_NUMBER, STAGE(lbfgs.descent.function_tolerance),
     BETWEEN(0, 1), .flags = NOT_ADAM | CONFIG_HIGH_OPEN,
     .help = "The stage ends when a step changes the loss relatively by no more; gauss_newton "
             "needs three such steps in a row."},
    {"training.stages[].step_tolerance", CONFIG_NUMBER, STAGE(lbfgs.descent.step_tolerance),
     BETWEEN(0, 1), .flags = NOT_ADAM | CONFIG_HIGH_OPEN,
     .help = "The stage ends when a step changes the parameters relatively by no more."},
    {"training.stages[].curvature_threshold", CONFIG_NUMBER,
     STAGE(lbfgs.descent.curvature_threshold), BETWEEN(0, 1),
     .flags = LINE_SEARCH | CONFIG_HIGH_OPEN,
     .help = "Pairs with less curvature are dropped."},
    {"training.stages[].linear_algebra", CONFIG_CHOICE, STAGE(linear_algebra),
     .names = train_linear_algebra_names, GAUSS_NEWTON,
     .help = "How gauss_newton computes a step. automatic chooses by the numbers of parameters "
             "and residuals: separate for linear networks in the strain form, matrix_free (with "
             "scaling identity) if matrices would take more than 2 GB or kernel seconds a step."},
    {"training.stages[].scaling", CONFIG_CHOICE, STAGE(gauss_newton.scaling),
     .names = scaling_names, GAUSS_NEWTON,
     .fallback = "identity; without hidden layers diagonal in motion and for beams",
     .help = "What the damping multiplies: the identity, or the diagonal of J^T J."},
    {"training.stages[].initial_damping", CONFIG_NUMBER, STAGE(gauss_newton.initial_damping),
     .low = 0, .high = INFINITY, .flags = CONFIG_FOR_GAUSS_NEWTON | CONFIG_LOW_OPEN,
     .fallback = "0.001; 1e-10 without hidden layers",
     .help = "First damping, in units of the largest diagonal entry of J^T J (identity) or of 1 "
             "(diagonal)."},
    {"training.stages[].maximum_damping", CONFIG_NUMBER, STAGE(gauss_newton.maximum_damping),
     .low = 0, .high = INFINITY, .flags = CONFIG_FOR_GAUSS_NEWTON | CONFIG_LOW_OPEN,
     .help = "The stage ends when no step lowers the loss up to this damping; same units."},
    {"training.stages[].damping_increase", CONFIG_NUMBER, STAGE(gauss_newton.damping_increase),
     .low = 1, .high = INFINITY, .flags = CONFIG_FOR_GAUSS_NEWTON | CONFIG_LOW_OPEN,
     .help = "Factor of the damping after a step that did not lower the loss and is rejected."},
    {"training.stages[].damping_decrease", CONFIG_NUMBER, STAGE(gauss_newton.damping_decrease),
     BETWEEN(0, 1), .flags = CONFIG_FOR_GAUSS_NEWTON | CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN,
     .help = "Factor of the damping after a step that lowered the loss as predicted; its root "
             "after a smaller decrease."},
    {"training.stages[].targets", CONFIG_CHOICE, STAGE(targets), .names = train_targets_names,
     .help = "What a family in the strain form learns. solved: the members of members.solved. "
             "physics: new members in every step, by one Newton step from the network's answer. "
             "both: half of a step's members of either kind."},
    {"training.stages[].stop.loss", CONFIG_NUMBER, STAGE(stop_loss), NOT_NEGATIVE,
     .help = "The stage ends when the loss falls below this; 0: never."},
    {"training.stages[].stop.error", CONFIG_NUMBER, STAGE(stop_error), NOT_NEGATIVE,
     .help = "The stage ends when the error against the reference falls below this; 0: never."},
    {"training.stages[].stop.seconds", CONFIG_NUMBER, STAGE(stop_seconds), .unit = "s",
     NOT_NEGATIVE, .help = "The stage ends after this wall time, which is not reproducible; 0: "
                           "never."},
    {"training.stages[].stop.held_out_ratio", CONFIG_NUMBER, STAGE(stop_held_out_ratio),
     NOT_NEGATIVE,
     .help = "The stage ends when the held-out loss exceeds the training loss by this factor "
             "without a new minimum, in 5 rows of history in turn; 0: never."},


    {"surrogate.step", CONFIG_NUMBER, AT(surrogate.step), .unit = "s", POSITIVE,
     .fallback = "none: a network of the scene is trained",
     .help = "Step of a one-step model, which is trained in place of a network of the scene: the "
             "state of the reduced rod (cpinn-solve --method modes) one step later, for any "
             "inputs within their ranges. Filters and controllers use it (cpinn-control)."},
    {"surrogate.kind", CONFIG_CHOICE, AT(surrogate.kind), .names = surrogate_kinds,
     .help = "flow: a linear map, and a network for what it leaves over of solved steps, in a frame "
             "that turns with the robot where that has such a symmetry. linear: the map alone. "
             "polynomial, ddpinn: curves in time that begin at the state, so that any part of a step "
             "has an answer. They learn from the rod's equations. polynomial: values at the nodes of "
             "Radau's method, in that frame. ddpinn: damped sines, as published by Krauss et al. "
             "2024, a baseline."},
    {"surrogate.terms", CONFIG_INTEGER, AT(surrogate.terms), BETWEEN(1, 16),
     .help = "With ddpinn: number of damped sines for each number of the state."},
    {"surrogate.modes", CONFIG_INTEGER, ENTRIES(4, 4), AT(surrogate.modes), BETWEEN(0, 12),
     .fallback = "the fewest within surrogate.tolerance, when training begins",
     .help = "Modes of the reduced rod: bending, twist, stretch and shear, in each direction and "
             "segment. All 0: chosen by surrogate.tolerance."},
    {"surrogate.tolerance", CONFIG_NUMBER, AT(surrogate.tolerance), BETWEEN(1e-6, 0.5),
     .flags = CONFIG_LOW_OPEN,
     .help = "Modes are chosen so that the tip in motion differs from that of 5, 3, 4, 3 modes by "
             "no more of the length (median of rollouts)."},
    {"surrogate.inputs", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX), AT(surrogate.inputs),
     .count_offset = offsetof(config, surrogate.input_count),
     .fallback = "all parameters with a range that are not among surrogate.parameters",
     .help = "Names of parameters with a range that actuators set."},
    {"surrogate.parameters", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX), AT(surrogate.parameters),
     .count_offset = offsetof(config, surrogate.parameter_count), .fallback = "none",
     .help = "Names of parameters with a range that stay constant, such as a stiffness or a load, "
             "and that a filter finds."},
    {"surrogate.hold", CONFIG_CHOICE, AT(surrogate.hold), .names = surrogate_holds,
     .help = "constant: inputs stay while a step lasts. linear: they change linearly to those at "
             "its end."},
    {"surrogate.solved", CONFIG_INTEGER, AT(surrogate.solved), BETWEEN(500, 1e7), .unit = "steps",
     .help = "Steps of the reduced rod to learn from. They are solved in rollouts under steps, "
             "ramps, bang-bang and chirps of the inputs. A tenth as many more measure the "
             "held-out loss."},

    CONTROL_ROWS

    {"checkpoint.every", CONFIG_INTEGER, AT(settings.checkpoint_every), .unit = "steps", BETWEEN(1, 1e9),
     .help = "Steps between checkpoints."},
    {"checkpoint.seconds", CONFIG_NUMBER, AT(settings.checkpoint_seconds), .unit = "s", POSITIVE,
     .help = "Wall time between checkpoints, if it is shorter than the steps take."},
    {"checkpoint.keep", CONFIG_INTEGER, AT(settings.checkpoint_keep), BETWEEN(1, 1000),
     .help = "Number of checkpoints that are kept."},
    {"output.every", CONFIG_INTEGER, AT(settings.output_every), .unit = "steps", BETWEEN(1, 1e9),
     .fallback = "10; 1 where training begins with gauss_newton in one window",
     .help = "Steps between rows of history.csv; every stage ends with a row, too."},
    {"output.tensorboard", CONFIG_CHOICE, AT(settings.output_tensorboard), .names = truth_names,
     .help = "Writes every column of history.csv to event files, too (events.out.tfevents.*). "
             "`tensorboard --logdir runs` shows them during training."},
    {"reference.analytic", CONFIG_CHOICE, AT(settings.reference), .names = train_reference_names,
     .help = "A known solution of this scene, to measure the error."},
    {"reference.solve", CONFIG_NUMBER, AT(settings.reference_tolerance), BETWEEN(1e-13, 0.1),
     .flags = CONFIG_BY_NAME,
     .help = "A classical solution (cpinn-solve) as reference, to this estimated error of the "
             "position over the length, or of a beam's deflection over the largest. `reference: "
             "solve` means 1e-11 at rest and 1e-8 in motion, or 1e-4 there with locked shear or "
             "stretch. It is kept in the folder cpinn of XDG_CACHE_HOME, else of ~/.cache, until "
             "the physics changes."},
    {"reference.file", CONFIG_TEXT, AT(settings.reference_file),
     .help = "CSV or HDF5 with the reference: columns s[, t], x, y, z[, qw, qx, qy, qz]; of a "
             "beam s[, t], w[, slope]. The path is relative to this file."},
    {FORMULA("reference.deflection", settings.reference_deflection), .unit = "m",
     .help = "The known deflection of a beam; formula of s and t."},
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
