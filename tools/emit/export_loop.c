#include "tools/emit/export_loop.h"
#include "tools/emit/export_text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static int sensors_of(const export_loop *loop)
{
    return loop->settings->estimator.sensors;
}

/* ---- constants ----------------------------------------------------------------------------- */

static void put_kinematics_arrays(const char *name, const kinematics *rod, FILE *file)
{
    const int modes = rod->modes, elements = rod->elements, stages = rod->stages;
    const int places = rod->places, rows = rod->rows;
#define PUT(field, count)                                                                          \
    export_put_integers(file, (size_t)(count), rod->field, "static const int %s_" #field "[]",     \
                        name);
    KINEMATICS_INTEGERS(PUT)
#undef PUT
#define PUT(field, count)                                                                          \
    export_put_array(file, (size_t)(count), rod->field, "static const double %s_" #field "[]",     \
                     name);
    KINEMATICS_NUMBERS(PUT)
#undef PUT
}

static void put_kinematics(const char *name, const kinematics *rod, FILE *file)
{
    fprintf(file, "{%d, %d, %d, %d, %d", rod->modes, rod->elements, rod->stages, rod->places,
            rod->rows);
#define PUT(field, count) fprintf(file, ",\n      %s_" #field, name);
    KINEMATICS_INTEGERS(PUT)
    KINEMATICS_NUMBERS(PUT)
#undef PUT
    fputc('}', file);
}

/* Looks of the sensors, then of the view. */
static const kinematic_observation *look_at(const export_loop *loop, int i)
{
    return i < sensors_of(loop) ? loop->sensors[i] : loop->parts[i - sensors_of(loop)];
}

static void put_looks(const export_loop *loop, FILE *file)
{
    const int count = sensors_of(loop) + loop->seen->parts;
    char name[40];
    for (int i = 0; i < count; i++) {
        snprintf(name, sizeof name, "loop_observation%d", i);
        put_kinematics_arrays(name, &look_at(loop, i)->rod, file);
    }
    fputs("static const kinematic_observation loop_looks[] = {\n", file);
    for (int i = 0; i < count; i++) {
        snprintf(name, sizeof name, "loop_observation%d", i);
        fprintf(file, "    {(observation_what)%d,\n     ", look_at(loop, i)->what);
        put_kinematics(name, &look_at(loop, i)->rod, file);
        fputs(i + 1 < count ? ", 0, NULL},\n" : ", 0, NULL}};\n", file);
    }
    fputs("static const int loop_parts[][2] = {", file);
    for (int i = 0; i < loop->seen->parts; i++) {
        const struct task_observation_part *part = &loop->seen->part[i];
        fprintf(file, "%s{%d, %d}", i ? ", " : "", part->first, part->count);
    }
    fputs("};\n", file);
}

/* The distances by which a clearance is kept. */
static void put_clearance(const export_loop *loop, FILE *file)
{
    const clearance_observation *x = loop->clearance;
    fprintf(file, "#define LOOP_CLEARANCE %d /* which part; 0: none */\n",
            x ? loop->clearance_part : 0);
    if (!x) {
        return;
    }
    export_put_tree(x->surface, "loop_surface", file);
    fprintf(
        file,
        "static const clearance_observation loop_clearance = {.surface = &loop_surface, .radius = "
        "%.17g, .smooth = %.17g};\n",
        x->radius, x->smooth);
}

static void put_surrogate(const char *name, const surrogate_step *m, FILE *file)
{
    export_put_array(file, surrogate_step_numbers(m), m->numbers,
                     "static const double %s_numbers[]", name);
    fprintf(file, "static const surrogate_step %s = {\n", name);
#define PUT(field) fprintf(file, "    ." #field " = %d,\n", m->field);
    PUT(kind)
    PUT(states)
    PUT(inputs)
    PUT(ramps)
    PUT(drives)
    PUT(slow_count)
    PUT(turns)
    PUT(mirrors)
    PUT(pairs)
    PUT(evens)
    PUT(odds)
    PUT(out_pairs)
    PUT(out_evens)
    PUT(out_odds)
    PUT(layers)
#undef PUT
#define PUT(field, count)                                                                          \
    fputs("    ." #field " = {", file);                                                            \
    for (int i = 0; i < (count); i++) {                                                            \
        fprintf(file, "%s%d", i ? ", " : "", m->field[i]);                                         \
    }                                                                                              \
    fputs("},\n", file);
    PUT(slow, SURROGATE_SLOW_MAX)
    PUT(width, SURROGATE_LAYERS_MAX)
    PUT(state_slot, SURROGATE_STATES_MAX)
    PUT(input_slot, m->drives)
#undef PUT
    fprintf(file, "    .step = %.17g,\n    .soft = %.17g,\n    .numbers = %s_numbers};\n", m->step,
            m->soft, name);
}

static void put_linear(const char *name, const linear_step *m, FILE *file)
{
    const size_t n = (size_t)m->states, inputs = (size_t)m->inputs;
    export_put_array(file, n, m->next, "static const double %s_next[]", name);
    export_put_array(file, n * n, m->by_state, "static const double %s_by_state[]", name);
    export_put_array(file, n * inputs, m->by_inputs, "static const double %s_by_inputs[]", name);
    fprintf(file,
            "static const linear_step %s = {%d, %d, %.17g, %s_next, %s_by_state, %s_by_inputs};\n",
            name, m->states, m->inputs, m->h, name, name, name);
}

/* `macro` is a loop_step of loop_functions.c. */
static void put_step(const char *name, const char *macro, const export_step *m, FILE *file)
{
    if (m->surrogate) {
        put_surrogate(name, m->surrogate, file);
    } else {
        put_linear(name, m->linear, file);
    }
    fprintf(file, "#define %s {%s%s, %s%s, NULL}\n", macro, m->surrogate ? "&" : "NULL",
            m->surrogate ? name : "", m->linear ? "&" : "NULL", m->linear ? name : "");
}

static void put_steps(const export_loop *loop, FILE *file)
{
    put_step("loop_planned", "LOOP_CONTROLLER", &loop->controller, file);
    if (memcmp(&loop->filter, &loop->controller, sizeof loop->filter) == 0) {
        fputs("#define LOOP_FILTER LOOP_CONTROLLER\n", file);
    } else {
        put_step("loop_filtered", "LOOP_FILTER", &loop->filter, file);
    }
    fprintf(file, "#define LOOP_SAMPLE %.17g\n", loop->settings->estimator.model.step);
}

/* Settings of a struct: a field that is an array `loop_FIELD`, and one that is a number. */
#define PUT_FIELD(of, field, count)                                                                \
    if ((of)->field) {                                                                             \
        fprintf(file, "    ." #field " = loop_" #field ",\n");                                     \
    }
#define PUT_ARRAY(of, field, count)                                                                \
    export_put_array(file, (size_t)(count), (of)->field, "static const double loop_" #field "[]");
#define PUT_WHOLE(of, field) fprintf(file, "    ." #field " = %d,\n", (of)->field);
#define PUT_REAL(of, field)  fprintf(file, "    ." #field " = %.17g,\n", (of)->field);

#define ESTIMATOR_ARRAYS(X)                                                                        \
    X(e, deviation, e->model.states)                                                               \
    X(e, process, e->model.states) X(e, largest, e->model.states)

static void put_estimator(const export_loop *loop, FILE *file)
{
    const estimator_settings *e = &loop->settings->estimator;
    for (int i = 0; i < e->sensors; i++) {
        const estimator_sensor *s = &e->sensor[i];
        const int values = s->rotations ? s->observation.values / 4 * 3 : s->observation.values;
        export_put_array(file, (size_t)values, s->noise, "static const double loop_noise%d[]", i);
    }
    fputs("static const estimator_sensor loop_sensors[] = {\n", file);
    for (int i = 0; i < e->sensors; i++) {
        const estimator_sensor *s = &e->sensor[i];
        fprintf(file,
                "    {.rotations = %d, .noise = loop_noise%d, .every = %d, .phase = %d, "
                ".delay = %d,\n     .depends = %d}%s\n",
                s->rotations, i, s->every, s->phase, s->delay, s->depends,
                i + 1 < e->sensors ? "," : "};");
    }
    fprintf(file, "static const estimator_parameter loop_parameters[] = {%s",
            e->parameters == 0 ? "{0, 0, 1, 0, 0}" : "");
    for (int i = 0; i < e->parameters; i++) {
        const estimator_parameter *p = &e->parameter[i];
        fprintf(file, "%s\n    {%d, %.17g, %.17g, %.17g, %.17g}", i ? "," : "", p->input, p->low,
                p->high, p->deviation, p->walk);
    }
    fputs("};\n", file);
    ESTIMATOR_ARRAYS(PUT_ARRAY)
    fputs("static const estimator_settings loop_estimator = {\n    .parameter = loop_parameters,\n",
          file);
    ESTIMATOR_ARRAYS(PUT_FIELD)
    PUT_WHOLE(e, parameters)
    PUT_WHOLE(e, sensors)
    PUT_WHOLE(e, late)
    PUT_WHOLE(e, patience)
    PUT_WHOLE(e, window)
    PUT_REAL(e, alpha)
    PUT_REAL(e, beta)
    PUT_REAL(e, kappa)
    PUT_REAL(e, gate)
    PUT_REAL(e, adapt)
    PUT_REAL(e, period)
    fputs("};\n", file);
}

#define CONTROLLER_ARRAYS(X)                                                                       \
    X(c, others, c->model.inputs)                                                                  \
    X(c, lower, c->controlled)                                                                     \
    X(c, upper, c->controlled)                                                                     \
    X(c, rate, c->controlled)                                                                      \
    X(c, rest, c->controlled)                                                                      \
    X(c, smooth, c->controlled)                                                                    \
    X(c, effort, c->controlled)                                                                    \
    X(c, weight, c->observation.values)                                                            \
    X(c, soft_lower, c->observation.values)                                                        \
    X(c, soft_upper, c->observation.values) X(c, soft_weight, c->observation.values)

static void put_controller(const export_loop *loop, FILE *file)
{
    const controller_settings *c = &loop->settings->controller;
    CONTROLLER_ARRAYS(PUT_ARRAY)
    export_put_array(file, (size_t)c->controlled, loop->settings->rate,
                     "static const double loop_turn_rate[]");
    fprintf(file,
            "static const controller_settings loop_controller = {\n    .inputs = %s_controlled,\n",
            loop->name);
    CONTROLLER_ARRAYS(PUT_FIELD)
    PUT_WHOLE(c, horizon)
    PUT_WHOLE(c, moves)
    PUT_WHOLE(c, delay)
    PUT_WHOLE(c, iterations)
    PUT_WHOLE(c, qp_limit)
    PUT_WHOLE(c, controlled)
    PUT_WHOLE(c, coast)
    PUT_REAL(c, terminal)
    PUT_REAL(c, offset)
    PUT_REAL(c, outside)
    fputs("};\n", file);
}

static void write_source(const export_loop *loop, FILE *file)
{
    const regulator_settings *s = loop->settings;
    const size_t n = (size_t)s->estimator.model.states;
    export_begin_source(loop->name, file);
    fputs("#if defined(__OPTIMIZE__) && !defined(__clang__) /* -O2 alone takes twice as long */\n"
          "#pragma GCC optimize(\"O3\", \"fp-contract=fast\")\n#endif\n"
          "#if defined(__GNUC__)\n#define WHOLE_FUNCTION static __attribute__((unused))\n"
          "#else\n#define WHOLE_FUNCTION static\n#endif\n",
          file);
    export_put_lines(loop->name, EXPORT_DOUBLE, export_loop_cores, file);
    fputs("\n/* ---- constants "
          "--------------------------------------------------------------------------- */\n\n",
          file);
    export_put_parameters(loop->name, "input_names", loop->open, false, file);
    export_put_integers(file, (size_t)s->controller.controlled, s->controller.inputs,
                        "const int %s_controlled[%s_CONTROLLED]", loop->name, loop->name);
    fprintf(file,
            "enum {\n    LOOP_SENSORS = %d,\n    LOOP_PARTS = %d,\n    LOOP_VALUES = %d,\n"
            "    LOOP_TURNS = %d\n};\n",
            sensors_of(loop), loop->seen->parts, s->controller.observation.values, s->turns);
    put_steps(loop, file);
    put_looks(loop, file);
    put_clearance(loop, file);
    put_estimator(loop, file);
    put_controller(loop, file);
    fprintf(file, "#define LOOP_RATE %s\n", s->rate ? "loop_turn_rate" : "NULL");
    export_put_array(file, n, loop->state, "static const double loop_state[]");
    export_put_array(file, (size_t)s->estimator.model.inputs, loop->inputs,
                     "static const double loop_inputs[]");
    export_put_array(file, n * (size_t)s->estimator.parameters, loop->by_parameters,
                     "static const double loop_by_parameters[]");
    export_put_lines(loop->name, EXPORT_DOUBLE, export_loop_functions, file);
}

/* ---- the header ---------------------------------------------------------------------------- */

static void put_macro(const export_loop *loop, const char *name, double number, const char *what,
                      FILE *file)
{
    fprintf(file, "#define %s_%-12s %.9g /* %s */\n", loop->name, name, number, what);
}

static void put_sensors(const export_loop *loop, FILE *file)
{
    static const char *const seen[] = {[OBSERVATION_POSITION] = "position, m",
                                       [OBSERVATION_ROTATION] = "rotation (w, x, y, z)",
                                       [OBSERVATION_DIRECTION] = "direction d3",
                                       [OBSERVATION_VELOCITY] = "velocity, m/s",
                                       [OBSERVATION_ANGULAR_VELOCITY] =
                                           "angular velocity, body, 1/s",
                                       [OBSERVATION_CURVATURE] = "curvature, body, 1/m",
                                       [OBSERVATION_STRAIN] = "strain, body"};
    fputs(
        "\n/* sensors: what they see, noise, every so many samples, delay in samples */\nenum {\n",
        file);
    for (int i = 0; i < sensors_of(loop); i++) {
        const estimator_sensor *s = &loop->settings->estimator.sensor[i];
        fprintf(file, "    %s_SENSOR_%d%s /* %s [%d], %.3g, %d, %d */\n", loop->name, i,
                i + 1 < sensors_of(loop) ? "," : "", seen[loop->sensors[i]->what],
                s->observation.values, s->noise[0], s->every > 0 ? s->every : 1, s->delay);
    }
    fputs("};\n", file);
}

static void put_inputs(const export_loop *loop, FILE *file)
{
    const controller_settings *c = &loop->settings->controller;
    const estimator_settings *e = &loop->settings->estimator;
    fputs("\n/* inputs of the model: index, range */\nenum {\n", file);
    for (int i = 0; i < loop->open->parameter_count; i++) {
        const scene_parameter *p = &loop->open->parameters[i];
        export_put_index(loop->name, "IN_", p->name, i, loop->open->parameter_count, file);
        fprintf(file, " /* %.9g to %.9g", p->low, p->high);
        for (int k = 0; k < c->controlled; k++) {
            if (c->inputs[k] == i) {
                fprintf(file, "; controlled, number %d: %.9g to %.9g", k, c->lower[k], c->upper[k]);
            }
        }
        for (int k = 0; k < e->parameters; k++) {
            if (e->parameter[k].input == i) {
                fprintf(file, "; found, parameter %d", k);
            }
        }
        fputs(" */\n", file);
    }
    fputs("};\n", file);
}

static void put_flags(const export_loop *loop, FILE *file)
{
    static const struct {
        int bit;
        const char *what;
    } flags[] = {
        {ESTIMATOR_MISSING, "a measurement is missing: the model goes on"},
        {ESTIMATOR_NOT_FINITE, "one is not finite: as missing"},
        {ESTIMATOR_LATE, "one is too late: not used"},
        {ESTIMATOR_OUTLIER, "an outlier: not used"},
        {ESTIMATOR_INFLATED, "many outliers: the covariance is made larger"},
        {ESTIMATOR_NO_ANSWER, "the filter's model has no answer: its mean goes on or stays"},
        {ESTIMATOR_OUTSIDE, "the state is outside of what the model was made for"},
        {ESTIMATOR_AT_EDGE, "a parameter is at an end of its range"},
        {ESTIMATOR_INCONSISTENT, "innovations are larger or smaller than noise says"},
        {ESTIMATOR_BAD_INPUTS, "inputs not finite: the last ones are held"},
        {ESTIMATOR_BAD_CALL, "no such sensor, or measured already"},
        {ESTIMATOR_BAD_START, "of model_start: no such state or inputs, not taken"},
        {CONTROLLER_STATE << REGULATOR_CONTROLLER, "no state: the plan coasts on its prediction"},
        {CONTROLLER_OUTSIDE << REGULATOR_CONTROLLER, "its state is outside of the model"},
        {CONTROLLER_HELD << REGULATOR_CONTROLLER, "inputs are held: too long without a state"},
        {CONTROLLER_MODEL << REGULATOR_CONTROLLER, "its model has no answer: the plan goes on"},
        {CONTROLLER_QP_LIMIT << REGULATOR_CONTROLLER, "the program was stopped: its best point"},
        {CONTROLLER_QP << REGULATOR_CONTROLLER, "the program has no answer: the plan goes on"},
        {CONTROLLER_SOFT << REGULATOR_CONTROLLER, "a limit of what is seen is violated"},
        {CONTROLLER_OTHERS << REGULATOR_CONTROLLER, "other inputs not finite: the last ones"},
        {CONTROLLER_REFERENCE << REGULATOR_CONTROLLER, "the path is infinite: no wish there"},
        {REGULATOR_LATE, "model_late was called: the last plan goes on, or inputs are held"},
        {REGULATOR_AGAIN, "the filter was lost, outside of its model: it begins again, at rest"}};
    fputs("\n/* Flags, 0: all is well. What is done about each:\n", file);
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
        fprintf(file, " *   0x%07x  ", (unsigned)flags[i].bit);
        export_put(loop->name, EXPORT_DOUBLE, flags[i].what, file);
        fputc('\n', file);
    }
    fputs(" */\n", file);
}

static void write_header(const export_loop *loop, FILE *file)
{
    const regulator_settings *s = loop->settings;
    const estimator_settings *e = &s->estimator;
    const controller_settings *c = &s->controller;
    fprintf(file, "/* %s: ", loop->name);
    export_put_comment(loop->about, file);
    fprintf(file, ": one-step model, filter and predictive controller as C11 that needs\n"
                  " * nothing but libm; written by cpinn " CPINN_VERSION
                  ". SI units. cc -std=c11 -O2 is all it "
                  "takes.\n");
    for (const char *const *line = loop->verified; line && *line; line++) {
        fprintf(file, "%s\n * %s", line == loop->verified ? " *" : "", *line);
    }
    fputs("\n */\n", file);
    export_begin_header(loop->name, file);
    put_macro(loop, "STATES", e->model.states, "of the model: modes, then their rates", file);
    put_macro(loop, "INPUTS", e->model.inputs, "of the model", file);
    put_macro(loop, "CONTROLLED", c->controlled, "inputs that are answered", file);
    put_macro(loop, "PARAMETERS", e->parameters, "inputs that the filter finds", file);
    put_macro(loop, "SENSORS", e->sensors, "", file);
    put_macro(loop, "HORIZON", c->horizon, "steps", file);
    put_macro(loop, "SAMPLE", e->period > 0 ? e->period : e->model.step, "s, between samples",
              file);
    put_macro(loop, "LOOK_AHEAD", c->model.step, "s, a step of the horizon", file);
    put_macro(loop, "DELAY", s->delay, "samples from a measurement to the inputs by it", file);
    put_macro(loop, "MEMORY", (double)loop->memory, "bytes", file);
    put_inputs(loop, file);
    put_sensors(loop, file);
    put_flags(loop, file);
    export_put_lines(loop->name, EXPORT_DOUBLE, export_loop_types, file);
    export_end_header(file);
}

/* ---- the self-test ------------------------------------------------------------------------- */

/* Of the ranges of inputs: rounding, which compilers do differently, in a loop that forgets. */
static const double TOLERANCE = 1e-8;

/* The same of a robot with more inputs than numbers of its place. How they share the work hardly
 * matters to what a plan costs, so that rounding is taken by the condition of its program, up to
 * 1e8; what the inputs do to the place is compared as closely as ever. */
static const double SHARED = 1e-5;

static void write_selftest(const export_loop *loop, FILE *file)
{
    const controller_settings *c = &loop->settings->controller;
    const estimator_settings *e = &loop->settings->estimator;
    const int known = c->controlled + e->parameters;
    int parameter[ESTIMATOR_PARAMETERS_MAX + 1], values[ESTIMATOR_SENSORS_MAX];
    const struct {
        const char *head;
        int columns;
        const double *rows;
    } tables[4] = {{"static const double measured", export_loop_values(loop), loop->measured},
                   {"static const double paths", c->horizon * 3, loop->paths},
                   {"static const double expected", known, loop->expected},
                   {"static const double reached", 3, loop->reached}};
    for (int i = 0; i < e->parameters; i++) {
        parameter[i] = e->parameter[i].input;
    }
    for (int i = 0; i < e->sensors; i++) {
        values[i] = e->sensor[i].observation.values;
    }
    export_begin_selftest(loop->name, "c11", file);
    fprintf(file,
            "enum { SAMPLES = %d, PARAMETERS = %d, LATE = %d, HELD = %d };\n"
            "#define TOLERANCE %g\n#define OF_INPUTS %g\n\n",
            loop->samples, e->parameters, REGULATOR_LATE, EXPORT_LOOP_HELD, TOLERANCE,
            c->controlled > 3 ? SHARED : TOLERANCE);
    export_put_integers(file, (size_t)e->parameters, parameter, "static const int parameter[]");
    export_put_integers(file, (size_t)e->sensors, values, "static const int sensor_values[]");
    export_put_integers(file, (size_t)loop->samples, loop->flags,
                        "static const int expected_flags[]");
    for (int i = 0; i < 4; i++) {
        export_put_rows(tables[i].head, (size_t)loop->samples, (size_t)tables[i].columns,
                        tables[i].rows, false, file);
    }
    export_put_lines(loop->name, EXPORT_DOUBLE, export_loop_selftest, file);
}

ad_status export_loop_write(void *of, int which, FILE *file, ad_error *error)
{
    static void (*const writers[EXPORT_TEXTS])(const export_loop *, FILE *) = {
        write_source, write_header, write_selftest};
    (void)error;
    writers[which](of, file);
    return AD_OK;
}

/* What names within the C begin with. */
static const char *const taken[] = {
    "clearance",      "controller",      "distance",  "estimator",
    "gauss",          "gauss_newton",    "kinematic", "kinematic_observation",
    "kinematics",     "lanes",           "linear",    "linear_step",
    "loop",           "observation",     "qp",        "regulator",
    "sigma",          "small_matrix",    "step",      "surrogate",
    "surrogate_step", "task_observation"};

bool export_loop_takes(const char *name)
{
    bool takes = false;
    for (size_t i = 0; i < sizeof taken / sizeof *taken; i++) {
        takes = takes || strcasecmp(name, taken[i]) == 0;
    }
    return takes;
}
