/* Every key a scene file may have. The quantities of the scene are the rows of
 * physics/scene/scene_rows.h. Defaults live there and in tools/train/train_settings.c; help, and a
 * default that depends on other keys in words, stand in keys.txt. */
#include "tools/config/config_keys.h"

#include "physics/scene/scene_rows.h"
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
CONFIG_NAMES(loss_names, TRAIN_LOSS_LIST(CONFIG_NAME))
CONFIG_NAMES(unit_names, "SI", "EI", )
CONFIG_NAMES(activation_names, NN_ACTIVATION_LIST(CONFIG_NAME))
CONFIG_NAMES(initialization_names, NN_INITIALIZATION_LIST(CONFIG_NAME))
CONFIG_NAMES(input_names, GROUPS_INPUTS_LIST(CONFIG_NAME))
CONFIG_NAMES(symmetry_names, GROUPS_SYMMETRY_LIST(CONFIG_NAME))
CONFIG_NAMES(sampler_names, SAMPLING_KIND_LIST(CONFIG_SAMPLER))
CONFIG_NAMES(adaptive_names, PROBLEM_ADAPTIVE_LIST(CONFIG_NAME))
CONFIG_NAMES(balance_names, "none", "gradient_norm", )
CONFIG_NAMES(surrogate_holds, SURROGATE_HOLD_LIST(CONFIG_NAME))
CONFIG_NAMES(control_path_names, CONTROL_PATH_LIST(CONFIG_NAME))
CONFIG_NAMES(control_surface_names, CONTROL_SURFACE_LIST(CONFIG_NAME))
CONFIG_NAMES(control_model_names, CONTROL_MODEL_LIST(CONFIG_NAME))
CONFIG_NAMES(control_seen_names, CONTROL_SEEN_LIST(CONFIG_NAME))
CONFIG_NAMES(control_limited_names, CONTROL_LIMITED_LIST(CONFIG_NAME))
CONFIG_NAMES(control_fault_names, CONTROL_FAULT_LIST(CONFIG_NAME))
#define CONFIG_UNIT_NAME(name, text, size) text,
CONFIG_NAMES(environment_unit_names, ENVIRONMENT_UNIT_LIST(CONFIG_UNIT_NAME))
CONFIG_NAMES(environment_side_names, ENVIRONMENT_SIDE_LIST(CONFIG_NAME))
CONFIG_NAMES(plan_method_names, PLAN_METHOD_LIST(CONFIG_NAME))
CONFIG_NAMES(optimize_over_names, OPTIMIZE_OVER_LIST(CONFIG_NAME))
CONFIG_NAMES(optimize_least_names, OPTIMIZE_LEAST_LIST(CONFIG_NAME))

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

/* A setting of optim/methods.h; ...: its limits, low, high, which are open, in words */
#define LIMITS(least, most, open, ...) .low = (least), .high = (most), .flags = (open)
#define STAGE_SETTING(type, key, kind, group, otherwise, in_words, of_names, of_unit, text, ...)   \
    {"training.stages[]." #key, CONFIG_##kind,     STAGE(optim.key),                               \
     .names = (of_names),       .unit = (of_unit), .reads = (group),                               \
     .fallback = (in_words),    .help = (text),    LIMITED(__VA_ARGS__)},
#define LIMITED(...) LIMITS(__VA_ARGS__)

/* A number for each input of a controller. */
#define BY_INPUT(path, field, of_unit)                                                             \
    {                                                                                              \
        path, CONFIG_NUMBER, ENTRIES(0, CONTROL_INPUTS_MAX), AT(control.field),                    \
            .count_offset = offsetof(config, control.field##_count), ANY, .unit = (of_unit)        \
    }

/* A surface that the robot must not touch. */
#define ENVIRONMENT(path, to)                                                                      \
    {path "file", CONFIG_TEXT, AT(to file)},                                                       \
        {path "unit", CONFIG_CHOICE, AT(to unit), .names = environment_unit_names},                \
        {path "side", CONFIG_CHOICE, AT(to side), .names = environment_side_names},                \
        {path "position", CONFIG_NUMBER, ENTRIES(3, 3), AT(to position), ANY, .unit = "m"},        \
    {                                                                                              \
        path "rotation", CONFIG_NUMBER, ENTRIES(4, 4), AT(to rotation), ANY                        \
    }

/* What a segment has of the rod. */
#define SEGMENT_QUANTITY(path, size, member, part, rule, bounds, geometry, axes, of_unit,          \
                         otherwise, in_words, text)                                                \
    QUANTITY_KEY(path, size, member, of_unit, "as under rod, or from section and material",        \
                 "Of this piece, as under rod.", bounds)

#define PLAN_GOAL_KEYS(path, member)                                                               \
    {path "position", CONFIG_NUMBER, ENTRIES(3, 3), AT(member position), ANY, .unit = "m"},        \
        {path "tolerance", CONFIG_NUMBER, AT(member tolerance), POSITIVE, .unit = "m"},            \
        {path "direction", CONFIG_NUMBER, ENTRIES(3, 3), AT(member direction), ANY},               \
        {path "angle", CONFIG_NUMBER, AT(member angle), BETWEEN(1e-4, 3.2), .unit = "rad"},        \
        {path "actuators",                                                                         \
         CONFIG_NUMBER,                                                                            \
         ENTRIES(0, PLAN_VARIABLES_MAX),                                                           \
         AT(member actuators),                                                                     \
         .count_offset = offsetof(config, member count),                                           \
         ANY,                                                                                      \
         .unit = "of the actuator"},

/* clang-format off */
const config_key config_keys[] = {
    {"name", CONFIG_TEXT, AT(settings.name)},

    {CONFIG_PARAMETER_PATH, CONFIG_PARAMETER, ANY},

    {CONFIG_PARAMETER_PATH ".range", CONFIG_NUMBER, AT(parameters[0].range), ENTRIES(2, 2), ANY},
    {CONFIG_PARAMETER_PATH ".identify", CONFIG_NUMBER, AT(parameters[0].identify), ANY},
    {CONFIG_PARAMETER_PATH ".scale", CONFIG_CHOICE, AT(parameters[0].scale),
     .names = scene_scale_names},

    {"tables[].name", CONFIG_TEXT, AT(tables[0].name)},
    {"tables[].file", CONFIG_TEXT, AT(tables[0].file)},
    {"tables[].x", CONFIG_NUMBER, ENTRIES(2, QUANTITY_TABLE_MAX), AT(tables[0].x),
     .count_offset = offsetof(config, tables[0].x_count), ANY},
    {"tables[].y", CONFIG_NUMBER, ENTRIES(2, QUANTITY_TABLE_MAX), AT(tables[0].y),
     .count_offset = offsetof(config, tables[0].y_count), ANY},

    {"rod.model", CONFIG_CHOICE, AT(scene.rod.model), .names = scene_model_names},
    SCENE_LENGTH_ROWS(SCENE_QUANTITY)
    {"rod.section.shape", CONFIG_CHOICE, AT(scene.rod.section), .names = scene_section_names},
    SCENE_MATTER_ROWS(SCENE_QUANTITY, "rod.", rod.)
    SCENE_REST_ROWS(SCENE_QUANTITY, "rod.", rod.)
    SCENE_DAMPING_ROWS(SCENE_QUANTITY, "rod.", rod.)
    {"rod.law.file", CONFIG_TEXT, AT(law.file)},
    {"rod.law.numbers", CONFIG_NUMBER, ENTRIES(1, SCENE_LAW_NUMBERS_MAX), AT(law.numbers),
     .count_offset = offsetof(config, law.count), .low = -INFINITY, .high = INFINITY,
     .flags = CONFIG_INFINITE},

    SCENE_PIECE_ROWS(SCENE_QUANTITY, "segments[].", segments[0].)
    {"segments[].section.shape", CONFIG_CHOICE, AT(scene.segments[0].rod.section),
     .names = scene_section_names},
    SCENE_MATTER_ROWS(SEGMENT_QUANTITY, "segments[].", segments[0].rod.)
    SCENE_REST_ROWS(SEGMENT_QUANTITY, "segments[].", segments[0].rod.)
    SCENE_DAMPING_ROWS(SEGMENT_QUANTITY, "segments[].", segments[0].rod.)
    SCENE_TURN_ROWS(SCENE_QUANTITY, "segments[].", segments[0].)

    {"loads.units", CONFIG_CHOICE, AT(load_units), .names = unit_names},
    SCENE_LINE_ROWS(SCENE_QUANTITY)
    {"loads.frame", CONFIG_CHOICE, AT(scene.loads.frame), .names = scene_frame_names},
    SCENE_BASE_ROWS(SCENE_QUANTITY)
    {"loads.base.frame", CONFIG_CHOICE, AT(scene.loads.base.frame), .names = scene_frame_names},
    SCENE_TIP_ROWS(SCENE_QUANTITY)
    {"loads.tip.frame", CONFIG_CHOICE, AT(scene.loads.tip.frame), .names = scene_frame_names},
    SCENE_POINT_ROWS(SCENE_QUANTITY, "loads.points[].", points[0].)
    {"loads.points[].frame", CONFIG_CHOICE, AT(scene.points[0].load.frame),
     .names = scene_frame_names},

    SCENE_BODY_ROWS(SCENE_QUANTITY, "bodies[].", bodies[0].)

    SCENE_SPRING_ROWS(SCENE_QUANTITY, "springs[].", springs[0].)

    SCENE_TENDON_ROWS(SCENE_QUANTITY, "tendons[].", tendons[0].)

    SCENE_CHAMBER_ROWS(SCENE_QUANTITY, "chambers[].", chambers[0].)

    SCENE_TUBE_ROWS(SCENE_QUANTITY, "tubes[].", tubes[0].)

    SCENE_BEAM_ROWS(SCENE_QUANTITY)
    SCENE_BEAM_POINT_ROWS(SCENE_QUANTITY, "beam.points[].", beam.points[0].)

    {"boundary.start.type", CONFIG_CHOICE, AT(scene.start.type), .names = scene_end_names},
    SCENE_START_ROWS(SCENE_QUANTITY)
    {"boundary.end.type", CONFIG_CHOICE, AT(scene.end.type), .names = scene_end_names},
    SCENE_END_ROWS(SCENE_QUANTITY)

    SCENE_INITIAL_ROWS(SCENE_QUANTITY)
    {"initial.state", CONFIG_CHOICE, AT(scene.initial.state), .names = scene_state_names},

    SCENE_DURATION_ROWS(SCENE_QUANTITY)
    {"time.windows", CONFIG_INTEGER, AT(settings.windows), BETWEEN(1, SCENE_WINDOWS_MAX)},

    SCENE_EXACT_ROWS(SCENE_QUANTITY)

    {"formulation", CONFIG_CHOICE, AT(scene.formulation), .names = scene_formulation_names},
    {"members.solved", CONFIG_INTEGER, AT(settings.members), BETWEEN(0, 100000000)},
    {"members.file", CONFIG_TEXT, AT(settings.members_file)},
    {"motion", CONFIG_CHOICE, AT(scene.motion), .names = scene_motion_names},
    {"enforcement.boundary", CONFIG_CHOICE, AT(scene.boundary_enforcement),
     .names = scene_enforcement_names},
    {"enforcement.initial", CONFIG_CHOICE, AT(scene.initial_enforcement),
     .names = scene_enforcement_names},

    {"network.hidden", CONFIG_INTEGER, ENTRIES(0, NN_HIDDEN_MAX), AT(settings.network.hidden),
     .count_offset = offsetof(config, settings.network.hidden_count), BETWEEN(1, 4096)},
    {"network.activation", CONFIG_CHOICE, AT(settings.network.activation),
     .names = activation_names},
    {"network.initialization", CONFIG_CHOICE, AT(settings.network.initialization),
     .names = initialization_names},
    {"network.fourier.features", CONFIG_INTEGER, AT(settings.network.fourier_features),
     BETWEEN(0, 1024)},
    {"network.fourier.wavenumber", CONFIG_NUMBER, AT(settings.fourier_wavenumber), .unit = "rad/m",
     POSITIVE},
    {"network.fourier.parameters", CONFIG_NUMBER, AT(settings.fourier_parameters), .unit = "rad",
     POSITIVE},
    {"network.fourier.frequency", CONFIG_NUMBER, AT(settings.fourier_frequency), .unit = "rad/s",
     POSITIVE},
    {"network.polynomial.degree", CONFIG_INTEGER, AT(settings.network.degree),
     BETWEEN(0, NN_DEGREE_MAX)},
    {"network.modes", CONFIG_INTEGER, ENTRIES(4, 4), AT(settings.modes),
     BETWEEN(0, SOLVE_MODES_MAX)},
    {"network.tolerance", CONFIG_NUMBER, AT(settings.tolerance), BETWEEN(1e-10, 0.1)},
    {"network.inputs", CONFIG_CHOICE, AT(settings.groups.inputs), .names = input_names},
    {"network.symmetry", CONFIG_CHOICE, AT(settings.groups.symmetry), .names = symmetry_names},
    {"network.rotation", CONFIG_CHOICE, AT(settings.rotation), .names = scene_rotation_names},

    {"losses.interior.points", CONFIG_INTEGER, AT(settings.losses.interior.points),
     BETWEEN(1, 1e8)},
    {"losses.interior.sampler", CONFIG_CHOICE, AT(settings.losses.interior.sampler),
     .names = sampler_names},
    {"losses.interior.resample_every", CONFIG_INTEGER, AT(settings.losses.interior.resample_every),
     .unit = "steps", BETWEEN(0, 1e9)},
    {"losses.interior.adaptive.kind", CONFIG_CHOICE, AT(settings.losses.adaptive.kind),
     .names = adaptive_names},
    {"losses.interior.adaptive.every", CONFIG_INTEGER, AT(settings.losses.adaptive.every),
     .unit = "steps", BETWEEN(1, 1e9)},
    {"losses.interior.adaptive.candidates", CONFIG_INTEGER, AT(settings.losses.adaptive.candidates),
     BETWEEN(0, 1e8)},
    {"losses.interior.adaptive.power", CONFIG_NUMBER, AT(settings.losses.adaptive.power), POSITIVE},
    {"losses.interior.adaptive.floor", CONFIG_NUMBER, AT(settings.losses.adaptive.floor),
     NOT_NEGATIVE},
    {"losses.interior.adaptive.width", CONFIG_NUMBER, AT(settings.losses.adaptive.width),
     BETWEEN(0, 1), .flags = CONFIG_LOW_OPEN},
    {"losses.interior.weights.strain", CONFIG_NUMBER, AT(settings.weights.strain), LOSS_WEIGHT},
    {"losses.interior.weights.curvature", CONFIG_NUMBER, AT(settings.weights.curvature),
     LOSS_WEIGHT},
    {"losses.interior.weights.force", CONFIG_NUMBER, AT(settings.weights.force), LOSS_WEIGHT},
    {"losses.interior.weights.moment", CONFIG_NUMBER, AT(settings.weights.moment), LOSS_WEIGHT},
    {"losses.boundary.points", CONFIG_INTEGER, AT(settings.losses.boundary.points),
     BETWEEN(1, 1e8)},
    {"losses.boundary.sampler", CONFIG_CHOICE, AT(settings.losses.boundary.sampler),
     .names = sampler_names},
    {"losses.boundary.resample_every", CONFIG_INTEGER, AT(settings.losses.boundary.resample_every),
     .unit = "steps", BETWEEN(0, 1e9)},
    {"losses.boundary.weight", CONFIG_NUMBER, AT(settings.weights.boundary), LOSS_WEIGHT},
    {"losses.initial.points", CONFIG_INTEGER, AT(settings.losses.initial.points), BETWEEN(1, 1e8)},
    {"losses.initial.sampler", CONFIG_CHOICE, AT(settings.losses.initial.sampler),
     .names = sampler_names},
    {"losses.initial.resample_every", CONFIG_INTEGER, AT(settings.losses.initial.resample_every),
     .unit = "steps", BETWEEN(0, 1e9)},
    {"losses.initial.weight", CONFIG_NUMBER, AT(settings.weights.initial), LOSS_WEIGHT},
    {"losses.held_out_points", CONFIG_INTEGER, AT(settings.losses.held_out_points),
     BETWEEN(1, 1e8)},
    {"losses.balance", CONFIG_CHOICE, AT(settings.losses.balance), .names = balance_names},
    {"losses.balance_every", CONFIG_INTEGER, AT(settings.losses.balance_every), .unit = "steps",
     BETWEEN(1, 1e9)},
    {"losses.balance_memory", CONFIG_NUMBER, AT(settings.losses.balance_memory), BETWEEN(0, 1),
     .flags = CONFIG_HIGH_OPEN},
    {"losses.causal.slices", CONFIG_INTEGER, AT(settings.losses.causal_slices), BETWEEN(0, 10000)},
    {"losses.causal.epsilon", CONFIG_NUMBER, ENTRIES(1, PROBLEM_EPSILONS_MAX),
     AT(settings.losses.causal_epsilon),
     .count_offset = offsetof(config, settings.losses.causal_epsilon_count), POSITIVE},
    {"losses.causal.threshold", CONFIG_NUMBER, AT(settings.losses.causal_threshold), BETWEEN(0, 1),
     .flags = CONFIG_LOW_OPEN | CONFIG_HIGH_OPEN},
    {"losses.causal.update_every", CONFIG_INTEGER, AT(settings.losses.causal_update_every),
     BETWEEN(1, 1000000), .unit = "steps"},

    {"residual.outputs", CONFIG_FORMULAS, AT(residual.outputs)},
    {"residual.inputs", CONFIG_TEXT, ENTRIES(0, LEARNED_INPUTS_MAX), AT(residual.inputs),
     .count_offset = offsetof(config, residual.input_count)},
    {"residual.hidden", CONFIG_INTEGER, ENTRIES(0, LEARNED_LAYERS_MAX), AT(residual.hidden),
     .count_offset = offsetof(config, residual.hidden_count), BETWEEN(1, LEARNED_OUTPUTS_MAX)},
    {"residual.file", CONFIG_TEXT, AT(residual.file)},

    {"data_folder", CONFIG_TEXT, AT(settings.data_folder)},
    {"data[].quantity", CONFIG_CHOICE, AT(settings.data[0].quantity),
     .names = train_quantity_names},
    {"data[].file", CONFIG_TEXT, AT(settings.data[0].file)},
    {"data[].columns", CONFIG_FORMULAS, AT(settings.data[0].columns)},
    {"data[].rows.from", CONFIG_INTEGER, AT(settings.data[0].from), BETWEEN(1, 1e9)},
    {"data[].rows.to", CONFIG_INTEGER, AT(settings.data[0].to), BETWEEN(0, 1e9)},
    {"data[].rows.every", CONFIG_INTEGER, AT(settings.data[0].every), BETWEEN(1, 1e9)},
    {"data[].rows.where", CONFIG_TEXT, AT(settings.data[0].where)},
    {FORMULA("data[].marker", settings.data[0].view.marker), ENTRIES(2, 3),
     .count_offset = offsetof(config, settings.data[0].marker_count), .unit = "m"},
    {FORMULA("data[].frame.position", settings.data[0].view.position), ENTRIES(3, 3),
     .unit = "m"},
    {FORMULA("data[].frame.rotation", settings.data[0].view.rotation), ENTRIES(4, 4)},
    {FORMULA("data[].frame.rotation_vector", settings.data[0].view.rotation_vector),
     ENTRIES(3, 3), .unit = "rad"},
    {"data[].rate", CONFIG_NUMBER, AT(settings.data[0].rate), NOT_NEGATIVE, .unit = "Hz"},
    {FORMULA("data[].delay", settings.data[0].view.delay), .unit = "s"},
    {"data[].robust", CONFIG_CHOICE, AT(settings.data[0].robust), .names = loss_names},
    {"data[].held_out", CONFIG_CHOICE, AT(settings.data[0].held_out), .names = truth_names},
    {"data[].noise", CONFIG_NUMBER, AT(settings.data[0].noise), NOT_NEGATIVE,
     .unit = "of the SI, rad"},
    {"data[].weight", CONFIG_NUMBER, AT(settings.data[0].weight), LOSS_WEIGHT},

    {"training.seed", CONFIG_LONG, AT(settings.seed), BETWEEN(0, 9007199254740992)},
    {"training.stages[].optimizer", CONFIG_CHOICE, STAGE(optim.method),
     .names = optim_method_names},
    {"training.stages[].steps", CONFIG_INTEGER, STAGE(steps), BETWEEN(1, 1e9)},
    OPTIM_SETTING_LIST(STAGE_SETTING)
    {"training.stages[].linear_algebra", CONFIG_CHOICE, STAGE(linear_algebra),
     .names = train_linear_algebra_names, .reads = OPTIM_READS_DAMPING},
    {"training.stages[].targets", CONFIG_CHOICE, STAGE(targets), .names = train_targets_names},
    {"training.stages[].stop.loss", CONFIG_NUMBER, STAGE(stop_loss), NOT_NEGATIVE},
    {"training.stages[].stop.error", CONFIG_NUMBER, STAGE(stop_error), NOT_NEGATIVE},
    {"training.stages[].stop.seconds", CONFIG_NUMBER, STAGE(stop_seconds), .unit = "s",
     NOT_NEGATIVE},
    {"training.stages[].stop.held_out_ratio", CONFIG_NUMBER, STAGE(stop_held_out_ratio),
     NOT_NEGATIVE},

    {"surrogate.step", CONFIG_NUMBER, AT(surrogate.step), .unit = "s", POSITIVE},
    {"surrogate.kind", CONFIG_CHOICE, AT(surrogate.kind), .names = surrogate_kind_names},
    {"surrogate.modes", CONFIG_INTEGER, ENTRIES(4, 4), AT(surrogate.modes), BETWEEN(0, 12)},
    {"surrogate.tolerance", CONFIG_NUMBER, AT(surrogate.tolerance), BETWEEN(1e-6, 0.5),
     .flags = CONFIG_LOW_OPEN},
    {"surrogate.inputs", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX), AT(surrogate.inputs),
     .count_offset = offsetof(config, surrogate.input_count)},
    {"surrogate.parameters", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX),
     AT(surrogate.parameters), .count_offset = offsetof(config, surrogate.parameter_count)},
    {"surrogate.hold", CONFIG_CHOICE, AT(surrogate.hold), .names = surrogate_holds},
    {"surrogate.solved", CONFIG_INTEGER, AT(surrogate.solved), BETWEEN(500, 1e7), .unit = "steps"},

    {"control.track.at", CONFIG_NUMBER, AT(control.track_at), NOT_NEGATIVE, .unit = "m"},
    {"control.task.path", CONFIG_CHOICE, AT(control.task.path), .names = control_path_names},
    {"control.task.centre", CONFIG_NUMBER, ENTRIES(3, 3), AT(control.task.centre), ANY,
     .unit = "m"},
    {"control.task.normal", CONFIG_NUMBER, ENTRIES(3, 3), AT(control.task.normal), ANY},
    {"control.task.radius", CONFIG_NUMBER, AT(control.task.radius), POSITIVE, .unit = "m"},
    {"control.task.surface", CONFIG_CHOICE, AT(control.task.surface),
     .names = control_surface_names},
    {"control.task.frequency", CONFIG_NUMBER, AT(control.task.frequency), POSITIVE, .unit = "Hz"},
    {"control.task.points[].position", CONFIG_NUMBER, ENTRIES(3, 3),
     AT(control.task.points[0].position), ANY, .unit = "m"},
    {"control.task.points[].stay", CONFIG_NUMBER, AT(control.task.points[0].stay), NOT_NEGATIVE,
     .unit = "s"},
    {"control.task.travel", CONFIG_NUMBER, AT(control.task.travel), NOT_NEGATIVE, .unit = "s"},
    {"control.task.file", CONFIG_TEXT, AT(control.task.file)},
    {"control.task.approach", CONFIG_NUMBER, AT(control.task.approach), NOT_NEGATIVE, .unit = "s"},
    {"control.duration", CONFIG_NUMBER, AT(control.duration), POSITIVE, .unit = "s"},
    {"control.period", CONFIG_NUMBER, AT(control.period), POSITIVE, .unit = "s"},
    {"control.model", CONFIG_CHOICE, AT(control.model), .names = control_model_names},
    {"control.residual", CONFIG_TEXT, AT(control.residual)},
    {"control.horizon", CONFIG_INTEGER, AT(control.horizon), BETWEEN(1, 60), .unit = "steps"},
    {"control.weights.rate", CONFIG_NUMBER, AT(control.weight_rate), NOT_NEGATIVE},
    {"control.weights.effort", CONFIG_NUMBER, AT(control.weight_effort), NOT_NEGATIVE},
    {"control.accuracy", CONFIG_NUMBER, AT(control.accuracy), POSITIVE, .unit = "m"},
    {"control.offset", CONFIG_NUMBER, AT(control.offset), BETWEEN(0, 1)},
    BY_INPUT("control.limits.low", low, "of the input"),
    BY_INPUT("control.limits.high", high, "of the input"),
    BY_INPUT("control.limits.rate", rate, "of the input by s"),
    ENVIRONMENT("control.environment.", control.environment.),
    {"control.radius", CONFIG_NUMBER, AT(control.radius), NOT_NEGATIVE, .unit = "m"},
    {"control.constraints[].what", CONFIG_CHOICE, AT(control.limits[0].what),
     .names = control_limited_names},
    {"control.constraints[].at", CONFIG_NUMBER, AT(control.limits[0].at), NOT_NEGATIVE,
     .unit = "m"},
    {"control.constraints[].axis", CONFIG_INTEGER, AT(control.limits[0].axis), BETWEEN(1, 3)},
    {"control.constraints[].low", CONFIG_NUMBER, AT(control.limits[0].low), ANY},
    {"control.constraints[].high", CONFIG_NUMBER, AT(control.limits[0].high), ANY},
    {"control.measurements[].what", CONFIG_CHOICE, AT(control.measurements[0].what),
     .names = control_seen_names},
    {"control.measurements[].at", CONFIG_NUMBER, AT(control.measurements[0].at), NOT_NEGATIVE,
     .unit = "m"},
    {"control.measurements[].noise", CONFIG_NUMBER, AT(control.measurements[0].noise), POSITIVE,
     .unit = "of the SI, rad"},
    {"control.measurements[].every", CONFIG_INTEGER, AT(control.measurements[0].every),
     BETWEEN(1, 1000), .unit = "periods"},
    {"control.measurements[].delay", CONFIG_INTEGER, AT(control.measurements[0].delay),
     BETWEEN(0, 20), .unit = "periods"},
    {"control.measurements[].dropouts", CONFIG_NUMBER, AT(control.measurements[0].dropouts),
     BETWEEN(0, 1), .flags = CONFIG_HIGH_OPEN},
    {"control.estimate", CONFIG_TEXT, ENTRIES(0, CONTROL_INPUTS_MAX), AT(control.estimate),
     .count_offset = offsetof(config, control.estimate_count)},
    {"control.walk", CONFIG_NUMBER, ENTRIES(0, CONTROL_INPUTS_MAX), AT(control.walk),
     .count_offset = offsetof(config, control.walk_count), BETWEEN(1e-9, 100),
     .unit = "of half the range, by sqrt(s)"},
    {"control.plant.modes", CONFIG_INTEGER, ENTRIES(4, 4), AT(control.plant_modes), BETWEEN(0, 12)},
    {"control.plant.set", CONFIG_TEXT, ENTRIES(0, CONTROL_CHANGES_MAX), AT(control.changes),
     .count_offset = offsetof(config, control.change_count)},
    {"control.delay", CONFIG_INTEGER, AT(control.delay), BETWEEN(0, 1), .unit = "periods"},
    {"control.faults[].kind", CONFIG_CHOICE, AT(control.faults[0].kind),
     .names = control_fault_names},
    {"control.faults[].from", CONFIG_NUMBER, AT(control.faults[0].from), NOT_NEGATIVE, .unit = "s"},
    {"control.faults[].lasts", CONFIG_NUMBER, AT(control.faults[0].lasts), NOT_NEGATIVE,
     .unit = "s"},
    {"control.faults[].measurement", CONFIG_INTEGER, AT(control.faults[0].measurement),
     BETWEEN(-1, CONTROL_MEASUREMENTS_MAX - 1)},
    {"control.tolerance.rms", CONFIG_NUMBER, AT(control.tolerance_rms), POSITIVE, .unit = "m"},
    {"control.tolerance.worst", CONFIG_NUMBER, AT(control.tolerance_worst), POSITIVE, .unit = "m"},
    {"control.seed", CONFIG_LONG, AT(control.seed), BETWEEN(0, 9007199254740992)},

    ENVIRONMENT("plan.environment.", plan.environment.),
    {"plan.radius", CONFIG_NUMBER, AT(plan.radius), NOT_NEGATIVE, .unit = "m"},
    {"plan.from", CONFIG_NUMBER, AT(plan.from), NOT_NEGATIVE, .unit = "m"},
    {"plan.clearance", CONFIG_NUMBER, AT(plan.clearance), NOT_NEGATIVE, .unit = "m"},
    {"plan.actuators", CONFIG_TEXT, ENTRIES(0, PLAN_ACTUATORS_MAX), AT(plan.actuators),
     .count_offset = offsetof(config, plan.actuator_count)},
    {"plan.fixed", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX), AT(plan.fixed),
     .count_offset = offsetof(config, plan.fixed_count)},
    {"plan.unknown", CONFIG_TEXT, ENTRIES(0, PLAN_UNKNOWN_MAX), AT(plan.unknown),
     .count_offset = offsetof(config, plan.unknown_count)},
    {"plan.slide", CONFIG_NUMBER, ENTRIES(2, 2), AT(plan.slide), ANY, .unit = "m"},
    {"plan.turn", CONFIG_NUMBER, ENTRIES(2, 2), AT(plan.turn), ANY, .unit = "rad"},
    {"plan.start", CONFIG_NUMBER, ENTRIES(0, PLAN_VARIABLES_MAX), AT(plan.start),
     .count_offset = offsetof(config, plan.start_count), ANY, .unit = "of the actuator"},
    PLAN_GOAL_KEYS("plan.goal.", plan.goal.)
    PLAN_GOAL_KEYS("plan.goals[].", plan.goals[0].)
    {"plan.roadmap.file", CONFIG_TEXT, AT(plan.roadmap)},
    {"plan.roadmap.nodes", CONFIG_INTEGER, AT(plan.roadmap_nodes), BETWEEN(10, 1e6)},
    {"plan.planner", CONFIG_CHOICE, AT(plan.method), .names = plan_method_names},
    {"plan.states", CONFIG_INTEGER, AT(plan.states), BETWEEN(100, 1e9)},
    {"plan.seed", CONFIG_LONG, AT(plan.seed), BETWEEN(0, 4294967295)},
    {"optimize.minimize", CONFIG_TEXT, AT(optimize.minimize)},
    {"optimize.maximize", CONFIG_TEXT, AT(optimize.maximize)},
    {"optimize.variables", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX), AT(optimize.variables),
     .count_offset = offsetof(config, optimize.variable_count)},
    {"optimize.each", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX), AT(optimize.each),
     .count_offset = offsetof(config, optimize.each_count)},
    {"optimize.constraints", CONFIG_TEXT, ENTRIES(0, OPTIMIZE_CONSTRAINTS_MAX),
     AT(optimize.constraints), .count_offset = offsetof(config, optimize.constraint_count)},
    {"optimize.places[].name", CONFIG_TEXT, AT(optimize.places[0].name)},
    {"optimize.places[].at", CONFIG_NUMBER, AT(optimize.places[0].at), NOT_NEGATIVE, .unit = "m"},
    {"optimize.cases", CONFIG_TEXT, ENTRIES(0, OPTIMIZE_CASES_MAX), AT(optimize.cases),
     .count_offset = offsetof(config, optimize.case_count)},
    {"optimize.file", CONFIG_TEXT, AT(optimize.file)},
    {"optimize.over", CONFIG_CHOICE, AT(optimize.over), .names = optimize_over_names},
    {"optimize.box", CONFIG_TEXT, ENTRIES(0, SCENE_PARAMETERS_MAX), AT(optimize.box),
     .count_offset = offsetof(config, optimize.box_count)},
    ENVIRONMENT("optimize.environment.", optimize.environment.),
    {"optimize.radius", CONFIG_NUMBER, AT(optimize.radius), NOT_NEGATIVE, .unit = "m"},
    {"optimize.motion.minimize", CONFIG_CHOICE, AT(optimize.motion.minimize),
     .names = optimize_least_names},
    {"optimize.motion.start", CONFIG_TEXT, AT(optimize.motion.start)},
    {"optimize.motion.end", CONFIG_TEXT, AT(optimize.motion.end)},
    {"optimize.motion.intervals", CONFIG_INTEGER, AT(optimize.motion.intervals), BETWEEN(4, 400)},
    {"optimize.motion.modes", CONFIG_INTEGER, ENTRIES(4, 4), AT(optimize.motion.modes),
     BETWEEN(0, 12)},
    {"optimize.points", CONFIG_INTEGER, AT(optimize.points), BETWEEN(2, OPTIMIZE_POINTS_MAX)},
    {"optimize.starts", CONFIG_INTEGER, AT(optimize.starts), BETWEEN(1, OPTIMIZE_STARTS_MAX)},
    {"optimize.tolerance", CONFIG_NUMBER, AT(optimize.tolerance), BETWEEN(1e-12, 1e-3)},
    {"optimize.seed", CONFIG_LONG, AT(optimize.seed), BETWEEN(0, 9007199254740992)},

    {"checkpoint.every", CONFIG_INTEGER, AT(settings.checkpoint_every), .unit = "steps",
     BETWEEN(1, 1e9)},
    {"checkpoint.seconds", CONFIG_NUMBER, AT(settings.checkpoint_seconds), .unit = "s", POSITIVE},
    {"checkpoint.keep", CONFIG_INTEGER, AT(settings.checkpoint_keep), BETWEEN(1, 1000)},
    {"output.every", CONFIG_INTEGER, AT(settings.output_every), .unit = "steps", BETWEEN(1, 1e9)},
    {"reference.analytic", CONFIG_CHOICE, AT(settings.reference), .names = train_reference_names},
    {"reference.solve", CONFIG_NUMBER, AT(settings.reference_tolerance), BETWEEN(1e-13, 0.1),
     .flags = CONFIG_BY_NAME},
    {"reference.file", CONFIG_TEXT, AT(settings.reference_file)},
    {FORMULA("reference.deflection", settings.reference_deflection), .unit = "m"},
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
    LIST("control.task.points", "point", "points", "position", 0, CONTROL_POINTS_MAX,
         control.task.points, control.task.point_count),
    LIST("control.constraints", "constraint", "constraints", "what", 0, CONTROL_LIMITS_MAX,
         control.limits, control.limit_count),
    LIST("control.measurements", "measurement", "measurements", "what", 0, CONTROL_MEASUREMENTS_MAX,
         control.measurements, control.measurement_count),
    LIST("control.faults", "fault", "faults", "kind", 0, CONTROL_FAULTS_MAX, control.faults,
         control.fault_count),
    LIST("plan.goals", "goal", "goals", NULL, 0, PLAN_GOALS_MAX, plan.goals, plan.goal_count),
    LIST("optimize.places", "place", "places", NULL, 0, OPTIMIZE_PLACES_MAX, optimize.places,
         optimize.place_count),
    LIST("beam.points", "point", "points", NULL, 0, SCENE_POINTS_MAX, scene.beam.points,
         scene.beam.point_count),
};
const int config_list_count = (int)(sizeof config_lists / sizeof *config_lists);
