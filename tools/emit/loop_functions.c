
/* ---- the loop ------------------------------------------------------------------------------ */

typedef struct loop_step { /* one of the two */
    const surrogate_step *of;
    const linear_step *linear;
    double *work;
} loop_step;

static const loop_step loop_by_sample = LOOP_FILTER, loop_by_step = LOOP_CONTROLLER;

struct model_loop {
    regulator_settings settings;
    estimator_sensor sensor[LOOP_SENSORS];
    kinematic_observation observation[LOOP_SENSORS + LOOP_PARTS];
#if LOOP_CLEARANCE > 0
    clearance_observation clearance;
#endif
    task_observation seen;
    loop_step filter, controller;
    double *reference; /* [HORIZON][LOOP_VALUES] */
    regulator *both;
};

static int loop_advance(void *context, int count, double h, const double *states,
                        const double *inputs, const double *after, double *next, double *by_state,
                        double *by_inputs)
{
    const loop_step *x = context;
    return surrogate_step_advance(x->of, x->work, count, h, states, inputs, after, next, by_state,
                                  by_inputs);
}

static double loop_outside(void *context, const double *state, const double *inputs)
{
    const loop_step *x = context;
    return surrogate_step_outside(x->of, state, inputs);
}

/* Room of so many numbers, counted; without memory none. */
static double *loop_take(double *memory, size_t *used, size_t count)
{
    double *at = memory ? memory + *used : NULL;
    *used += count;
    return at;
}

static one_step loop_model(loop_step *x, const loop_step *from, double *memory, size_t *used)
{
    one_step result;
    *x = *from;
    if (x->linear) {
        return linear_one_step(x->linear);
    }
    x->work = loop_take(memory, used, surrogate_step_work(x->of));
    memset(&result, 0, sizeof result);
    result.context = x;
    result.states = x->of->states;
    result.inputs = x->of->inputs;
    result.step = x->of->step;
    result.advance = loop_advance;
    result.outside = loop_outside;
    return result;
}

static one_observation loop_observation(kinematic_observation *x, const kinematic_observation *from,
                                        double *memory, size_t *used)
{
    *x = *from;
    x->room = loop_take(memory, used, kinematic_observation_room(&x->rod));
    return kinematic_observation_of(x);
}

/* Settings with rooms in `memory`, which may be NULL; returns how many numbers they have. */
static size_t loop_fill(model_loop *x, double *memory)
{
    size_t used = 0;
    estimator_settings *filter = &x->settings.estimator;
    controller_settings *controller = &x->settings.controller;
    int i;
    x->settings.estimator = loop_estimator;
    x->settings.controller = loop_controller;
    x->settings.turns = LOOP_TURNS;
    x->settings.delay = model_DELAY;
    x->settings.rate = LOOP_RATE;
    filter->sensor = x->sensor;
    filter->model = loop_model(&x->filter, &loop_by_sample, memory, &used);
    filter->model.step = LOOP_SAMPLE;
    controller->model = loop_model(&x->controller, &loop_by_step, memory, &used);
    for (i = 0; i < LOOP_SENSORS; i++) {
        x->sensor[i] = loop_sensors[i];
        x->sensor[i].observation =
            loop_observation(&x->observation[i], &loop_looks[i], memory, &used);
    }
    x->seen.parts = LOOP_PARTS;
    x->seen.inputs = model_INPUTS;
    for (i = 0; i < LOOP_PARTS; i++) {
        kinematic_observation *observation = &x->observation[LOOP_SENSORS + i];
        x->seen.part[i].observation =
            loop_observation(observation, &loop_looks[LOOP_SENSORS + i], memory, &used);
        x->seen.part[i].first = loop_parts[i][0];
        x->seen.part[i].count = loop_parts[i][1];
    }
#if LOOP_CLEARANCE > 0
    x->clearance = loop_clearance;
    x->clearance.places = x->seen.part[LOOP_CLEARANCE].observation;
    x->clearance.room = loop_take(memory, &used, clearance_observation_room(&x->clearance.places));
    x->seen.part[LOOP_CLEARANCE].observation = clearance_observation_of(&x->clearance);
#endif
    x->seen.room = loop_take(memory, &used, task_observation_room(&x->seen));
    controller->observation = task_observation_of(&x->seen);
    x->reference = loop_take(memory, &used, (size_t)(model_HORIZON * LOOP_VALUES));
    return used;
}

enum { LOOP_ALIGNED = 64 };

static size_t loop_bytes(size_t bytes)
{
    return (bytes + LOOP_ALIGNED - 1) / LOOP_ALIGNED * LOOP_ALIGNED;
}

size_t model_size(void)
{
    model_loop x;
    const size_t numbers = loop_fill(&x, NULL);
    return loop_bytes(sizeof x) + loop_bytes(numbers * sizeof(double)) +
           regulator_size(&x.settings);
}

model_loop *model_init(void *memory, size_t size)
{
    model_loop *x = memory;
    char *at = memory;
    size_t numbers;
    if (size < model_size()) {
        return NULL;
    }
    memset(memory, 0, model_size());
    numbers = loop_fill(x, (double *)(void *)(at + loop_bytes(sizeof *x)));
    at += loop_bytes(sizeof *x) + loop_bytes(numbers * sizeof(double));
    x->both = regulator_init(at, &x->settings);
    (void)model_start(x, NULL, NULL);
    return x;
}

int model_start(model_loop *x, const double *state, const double *inputs)
{
    return regulator_start(x->both, state ? state : loop_state, inputs ? inputs : loop_inputs,
                           state || inputs ? NULL : loop_by_parameters);
}

/* ---- each sample --------------------------------------------------------------------------- */

int model_measure(model_loop *x, int sensor, int age, const double *values)
{
    return regulator_measure(x->both, sensor, age, values);
}

int model_control(model_loop *x, const double *path, double *inputs)
{
    int i;
    for (i = 0; i < model_HORIZON * LOOP_VALUES && path; i++) {
        const int k = i % LOOP_VALUES;
        x->reference[i] = k < 3 ? path[i / LOOP_VALUES * 3 + k] : NAN;
    }
    return regulator_control(x->both, path ? x->reference : NULL, inputs);
}

int model_late(model_loop *x, int held, double *inputs)
{
    const int flags = regulator_filter(x->both);
    return flags | regulator_late(x->both, held != 0, inputs);
}

void model_applied(model_loop *x, const double *inputs)
{
    regulator_applied(x->both, inputs);
}

void model_prepare(model_loop *x)
{
    regulator_prepare(x->both);
}

int model_iterations(const model_loop *x, int *most)
{
    const controller *plan = regulator_controller(x->both);
    *most = controller_iterations_most(plan);
    return controller_iterations(plan);
}

/* ---- what is known ------------------------------------------------------------------------- */

const double *model_state(const model_loop *x)
{
    return estimator_state(regulator_estimator(x->both));
}

const double *model_inputs(const model_loop *x)
{
    return estimator_inputs(regulator_estimator(x->both));
}

double model_state_deviation(const model_loop *x, int state)
{
    return estimator_deviation(regulator_estimator(x->both), state);
}

double model_parameter_deviation(const model_loop *x, int parameter)
{
    return estimator_parameter_deviation(regulator_estimator(x->both), parameter);
}

int model_step(model_loop *x, const double *state, const double *inputs, double *next,
               double *by_state, double *by_inputs)
{
    const one_step *model = &x->settings.estimator.model;
    return model->advance(model->context, 1, model->step, state, inputs, NULL, next, by_state,
                          by_inputs);
}

int model_place(model_loop *x, const double *state, double *position, double *by_state)
{
    const one_observation *place = &x->seen.part[0].observation;
    return place->see(place->context, 1, state, NULL, position, by_state);
}
