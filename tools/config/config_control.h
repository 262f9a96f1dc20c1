/* Rows of the table of keys (config_keys.c) under `control`; the macros are those of that file. */
#ifndef TOOLS_CONFIG_CONFIG_CONTROL_H
#define TOOLS_CONFIG_CONFIG_CONTROL_H

CONFIG_NAMES(control_path_names, CONTROL_PATH_LIST(CONFIG_NAME))
CONFIG_NAMES(control_surface_names, CONTROL_SURFACE_LIST(CONFIG_NAME))
CONFIG_NAMES(control_model_names, CONTROL_MODEL_LIST(CONFIG_NAME))
CONFIG_NAMES(control_seen_names, CONTROL_SEEN_LIST(CONFIG_NAME))
CONFIG_NAMES(control_fault_names, CONTROL_FAULT_LIST(CONFIG_NAME))

/* clang-format off */
#define CONTROL_AT(field) AT(control.field)
#define CONTROL_BY_INPUT(path, field, of_unit, in_words, text)                                     \
    {path, CONFIG_NUMBER, ENTRIES(0, CONTROL_INPUTS_MAX), CONTROL_AT(field),                       \
     .count_offset = offsetof(config, control.field##_count), ANY, .unit = (of_unit),              \
     .fallback = (in_words), .help = (text)}

#define CONTROL_ROWS                                                                               \
    {"control.track.at", CONFIG_NUMBER, CONTROL_AT(track_at), NOT_NEGATIVE, .unit = "m",           \
     .fallback = "the end of the rod",                                                             \
     .help = "Place on the rod whose position follows the path (cpinn-control)."},                 \
    {"control.task.path", CONFIG_CHOICE, CONTROL_AT(task.path), .names = control_path_names,       \
     .help = "The path: a circle; a figure eight, twice as wide as high; set points; or rows of "  \
             "a file."},                                                                           \
    {"control.task.centre", CONFIG_NUMBER, ENTRIES(3, 3), CONTROL_AT(task.centre), ANY,            \
     .unit = "m", .fallback = "on the normal through the place with inputs in the middle of "      \
     "their ranges, as high as the path is followed best at rest",                                 \
     .help = "Centre of the circle or the eight."},                                                \
    {"control.task.normal", CONFIG_NUMBER, ENTRIES(3, 3), CONTROL_AT(task.normal), ANY,            \
     .fallback = "along the rod there",                                                            \
     .help = "Normal of the plane of the circle or the eight, of any length."},                    \
    {"control.task.radius", CONFIG_NUMBER, CONTROL_AT(task.radius), POSITIVE, .unit = "m",         \
     .fallback = "a tenth of the rod's length",                                                    \
     .help = "Radius of the circle, or half the width of the eight."},                             \
    {"control.task.surface", CONFIG_CHOICE, CONTROL_AT(task.surface),                              \
     .names = control_surface_names,                                                               \
     .help = "plane: the circle or the eight lies in its plane. reachable: it lies over the "      \
             "plane on the surface where the place can be at rest, for robots with two inputs or " \
             "tendons that hardly stretch."},                                                      \
    {"control.task.frequency", CONFIG_NUMBER, CONTROL_AT(task.frequency), POSITIVE, .unit = "Hz",  \
     .help = "Frequency of the path."},                                                            \
    {"control.task.points[].position", CONFIG_NUMBER, ENTRIES(3, 3),                               \
     CONTROL_AT(task.points[0].position), ANY, .unit = "m", .fallback = "required",                \
     .help = "A set point."},                                                                      \
    {"control.task.points[].stay", CONFIG_NUMBER, CONTROL_AT(task.points[0].stay), NOT_NEGATIVE,   \
     .unit = "s", .help = "Time at the set point; the last one is kept."},                         \
    {"control.task.travel", CONFIG_NUMBER, CONTROL_AT(task.travel), NOT_NEGATIVE, .unit = "s",     \
     .help = "Time from one set point to the next, smoothly along a line; 0: by jumps."},          \
    {"control.task.file", CONFIG_TEXT, CONTROL_AT(task.file), .fallback = "required by file",      \
     .help = "CSV or HDF5 with columns t, x, y, z in s and m, t ascending. The path is relative "  \
             "to this file."},                                                                     \
    {"control.task.approach", CONFIG_NUMBER, CONTROL_AT(task.approach), NOT_NEGATIVE, .unit = "s", \
     .help = "Time in which the path goes from the place at the start to the task. Errors count "  \
             "from then on."},                                                                     \
    {"control.duration", CONFIG_NUMBER, CONTROL_AT(duration), POSITIVE, .unit = "s",               \
     .fallback = "the approach and 5 s more, or to the end of the set points or of the file",      \
     .help = "Duration of the simulated loop."},                                                   \
    {"control.period", CONFIG_NUMBER, CONTROL_AT(period), POSITIVE, .unit = "s",                   \
     .fallback = "surrogate.step",                                                                 \
     .help = "Time from one measurement and input to the next. A period shorter than the step of " \
             "the model needs a model with shorter steps; the plan keeps the step of the model."}, \
    {"control.model", CONFIG_CHOICE, CONTROL_AT(model), .names = control_model_names,              \
     .help = "Model of filter and controller. surrogate: the trained one-step model. reduced: "    \
             "the reduced rod. linear: that rod linearised where it rests at the start. "          \
             "automatic: surrogate if it is trained, else reduced."},                              \
    {"control.residual", CONFIG_TEXT, CONTROL_AT(residual),                                         \
     .help = "A network beside the model, which cpinn-residual has learned from measured motions " \
             "of the robot. The path is relative to this file. Not for model linear."},            \
    {"control.horizon", CONFIG_INTEGER, CONTROL_AT(horizon), BETWEEN(1, 60), .unit = "steps",      \
     .help = "Number of steps that the controller looks ahead."},                                  \
    {"control.weights.rate", CONFIG_NUMBER, CONTROL_AT(weight_rate), NOT_NEGATIVE,                 \
     .help = "Cost of a change of an input by its range in one step. The square of the error "     \
             "counts in units of accuracy."},                                                      \
    {"control.weights.effort", CONFIG_NUMBER, CONTROL_AT(weight_effort), NOT_NEGATIVE,             \
     .help = "Cost of an input that is off the middle of its range by its range."},                \
    {"control.accuracy", CONFIG_NUMBER, CONTROL_AT(accuracy), POSITIVE, .unit = "m",               \
     .help = "Error of the place that costs 1."},                                                  \
    {"control.offset", CONFIG_NUMBER, CONTROL_AT(offset), BETWEEN(0, 1),                           \
     .help = "Fraction of each prediction error that is added to the model. More than 0 removes "  \
             "constant errors from unknown loads and masses."},                                    \
    CONTROL_BY_INPUT("control.limits.low", low, "of the input", "the lower ends of their ranges",  \
     "Least values of the inputs, in the order of surrogate.inputs."),                             \
    CONTROL_BY_INPUT("control.limits.high", high, "of the input",                                  \
     "the upper ends of their ranges", "Largest values of the inputs."),                           \
    CONTROL_BY_INPUT("control.limits.rate", rate, "of the input by s", "none",                     \
     "Largest rate of change of the inputs; one number: all of them."),                            \
    {"control.constraints[].what", CONFIG_CHOICE, CONTROL_AT(limits[0].what),                      \
     .names = control_seen_names, .fallback = "required",                                          \
     .help = "Quantity of the rod that is kept in a range as far as inputs can: a position or a "  \
             "velocity (m/s) in the world, or a curvature (1/m)."},                                \
    {"control.constraints[].at", CONFIG_NUMBER, CONTROL_AT(limits[0].at), NOT_NEGATIVE,            \
     .unit = "m", .fallback = "the end of the rod", .help = "Place on the rod of the constraint."},\
    {"control.constraints[].axis", CONFIG_INTEGER, CONTROL_AT(limits[0].axis), BETWEEN(1, 3),      \
     .help = "Axis of the constraint: x, y, z; of the curvature d1, d2, d3."},                     \
    {"control.constraints[].low", CONFIG_NUMBER, CONTROL_AT(limits[0].low), ANY,                   \
     .fallback = "none", .help = "Least value of the quantity."},                                  \
    {"control.constraints[].high", CONFIG_NUMBER, CONTROL_AT(limits[0].high), ANY,                 \
     .fallback = "none", .help = "Largest value of the quantity."},                                \
    {"control.measurements[].what", CONFIG_CHOICE, CONTROL_AT(measurements[0].what),               \
     .names = control_seen_names, .fallback = "required",                                          \
     .help = "What a sensor measures. rotation: of the section; direction: of its d3; curvature: " \
             "about d1, d2, d3. Without measurements the position of track.at is measured."},      \
    {"control.measurements[].at", CONFIG_NUMBER, CONTROL_AT(measurements[0].at), NOT_NEGATIVE,     \
     .unit = "m", .fallback = "track.at", .help = "Place on the rod of the sensor."},              \
    {"control.measurements[].noise", CONFIG_NUMBER, CONTROL_AT(measurements[0].noise), POSITIVE,   \
     .unit = "of the SI, rad", .fallback = "0.2 mm, 0.01 rad, 0.01 m/s, 0.1/m",                    \
     .help = "Standard deviation of each number, for the simulated noise and for the filter."},    \
    {"control.measurements[].every", CONFIG_INTEGER, CONTROL_AT(measurements[0].every),            \
     BETWEEN(1, 1000), .unit = "periods", .help = "Periods between measurements."},                \
    {"control.measurements[].delay", CONFIG_INTEGER, CONTROL_AT(measurements[0].delay),            \
     BETWEEN(0, 20), .unit = "periods", .help = "Periods until a measurement arrives."},           \
    {"control.measurements[].dropouts", CONFIG_NUMBER, CONTROL_AT(measurements[0].dropouts),       \
     BETWEEN(0, 1), .flags = CONFIG_HIGH_OPEN,                                                     \
     .help = "Fraction of the measurements that never arrive, at random."},                        \
    {"control.estimate", CONFIG_TEXT, ENTRIES(0, CONTROL_INPUTS_MAX), CONTROL_AT(estimate),        \
     .count_offset = offsetof(config, control.estimate_count),                                     \
     .fallback = "surrogate.parameters",                                                           \
     .help = "Parameters with a range that the filter finds. Others of surrogate.parameters are "  \
             "taken in the middle of their range."},                                               \
    {"control.walk", CONFIG_NUMBER, ENTRIES(0, CONTROL_INPUTS_MAX), CONTROL_AT(walk),              \
     .count_offset = offsetof(config, control.walk_count), BETWEEN(1e-9, 100),                     \
     .unit = "of half the range, by sqrt(s)",                                                      \
     .fallback = "0.03, more while innovations are large; of positive ranges 0.003",               \
     .help = "How fast each estimate may change, as a random walk: more for a load that comes "    \
             "and goes. Positive ranges count by their logarithm. One number: all of them."},      \
    {"control.plant.modes", CONFIG_INTEGER, ENTRIES(4, 4), CONTROL_AT(plant_modes),                \
     BETWEEN(0, 12), .fallback = "one more of each than the model has",                            \
     .help = "Modes of the simulated robot: bending, twist, stretch, shear."},                     \
    {"control.plant.set", CONFIG_TEXT, ENTRIES(0, CONTROL_CHANGES_MAX), CONTROL_AT(changes),       \
     .count_offset = offsetof(config, control.change_count), .fallback = "none",                   \
     .help = "Keys in which the simulated robot differs from the scene, each as --set takes it: "  \
             "parameters.stiffness=0.8, \"bodies=[{at: 0.13, mass: 0.01}]\". A push is "           \
             "\"loads.tip.force=['where(t-2, 0.1, 0)', 0, 0]\"."},                                 \
    {"control.delay", CONFIG_INTEGER, CONTROL_AT(delay), BETWEEN(0, 1), .unit = "periods",         \
     .help = "Periods from a measurement until the input computed from it acts; the controller "   \
             "takes it into account."                                                              \
     },                                                                                            \
    {"control.faults[].kind", CONFIG_CHOICE, CONTROL_AT(faults[0].kind),                           \
     .names = control_fault_names, .fallback = "required",                                         \
     .help = "A fault for a while. lost, nan, wild: measurements do not arrive, are NaN, or are "  \
             "off by the length of the rod. late: the controller has no time to optimise."},       \
    {"control.faults[].from", CONFIG_NUMBER, CONTROL_AT(faults[0].from), NOT_NEGATIVE,             \
     .unit = "s", .help = "Time at which the fault begins."},                                      \
    {"control.faults[].lasts", CONFIG_NUMBER, CONTROL_AT(faults[0].lasts), NOT_NEGATIVE,           \
     .unit = "s", .help = "Duration of the fault; 0: one period."},                                \
    {"control.faults[].measurement", CONFIG_INTEGER, CONTROL_AT(faults[0].measurement),            \
     BETWEEN(-1, CONTROL_MEASUREMENTS_MAX - 1), .help = "Which measurement is affected, counted "  \
                                                        "from 0; -1: all."},                       \
    {"control.tolerance.rms", CONFIG_NUMBER, CONTROL_AT(tolerance_rms), POSITIVE, .unit = "m",     \
     .fallback = "2 % of the length",                                                             \
     .help = "Largest root mean square of the error after the approach; above it cpinn-control "   \
             "ends with exit status 3."},                                                          \
    {"control.tolerance.worst", CONFIG_NUMBER, CONTROL_AT(tolerance_worst), POSITIVE, .unit = "m", \
     .fallback = "5 % of the length, or 2.5 rms", .help = "Largest error after the approach; "     \
                                                          "above it cpinn-control ends with exit " \
                                                          "status 3."},                            \
    {"control.seed", CONFIG_LONG, CONTROL_AT(seed), BETWEEN(0, 9007199254740992),                  \
     .help = "Seed of noise and drop-outs."},
/* clang-format on */

#define CONTROL_LISTS                                                                              \
    LIST("control.task.points", "point", "points", "position", 0, CONTROL_POINTS_MAX,              \
         control.task.points, control.task.point_count),                                           \
        LIST("control.constraints", "constraint", "constraints", "what", 0, CONTROL_LIMITS_MAX,    \
             control.limits, control.limit_count),                                                 \
        LIST("control.measurements", "measurement", "measurements", "what", 0,                     \
             CONTROL_MEASUREMENTS_MAX, control.measurements, control.measurement_count),           \
        LIST("control.faults", "fault", "faults", "kind", 0, CONTROL_FAULTS_MAX, control.faults,   \
             control.fault_count),

#endif
