
/* ---- the loop ------------------------------------------------------------------------------ */

typedef struct loop_step {
    const surrogate_step *of;
    double *work;
} loop_step;

struct model_loop {
    regulator_settings settings;
    estimator_sensor sensor[LOOP_SENSORS];
    kinematic_look look[LOOP_SENSORS + LOOP_PARTS];
    view seen;
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

static one_step loop_model(loop_step *x, const surrogate_step *surrogate, const linear_step *linear,
                           double *memory, size_t *used)
{
    one_step result;
    if (!surrogate) {
        return linear_one_step(linear);
    }
    x->of = surrogate;
    x->work = loop_take(memory, used, surrogate_step_work(surrogate));
    memset(&result, 0, sizeof result);
    result.context = x;
    result.states = surrogate->states;
    result.inputs = surrogate->inputs;
    result.step = surrogate->step;
    result.shorter = LOOP_SHORTER;
    result.advance = loop_advance;
    result.outside = loop_outside;
    return result;
}

static one_look loop_look(kinematic_look *x, const kinematic_look *from, double *memory,
                          size_t *used)
{
    *x = *from;
    x->room = loop_take(memory, used, kinematic_look_room(&x->rod));
    return kinematic_look_of(x);
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
    filter->model = loop_model(&x->filter, LOOP_FILTER, memory, &used);
    controller->model = loop_model(&x->controller, LOOP_CONTROLLER, memory, &used);
    for (i = 0; i < LOOP_SENSORS; i++) {
        x->sensor[i] = loop_sensors[i];
        x->sensor[i].look = loop_look(&x->look[i], &loop_looks[i], memory, &used);
    }
    x->seen.parts = LOOP_PARTS;
    x->seen.inputs = model_INPUTS;
    for (i = 0; i < LOOP_PARTS; i++) {
        kinematic_look *look = &x->look[LOOP_SENSORS + i];
        x->seen.part[i].look = loop_look(look, &loop_looks[LOOP_SENSORS + i], memory, &used);
        x->seen.part[i].first = loop_parts[i][0];
        x->seen.part[i].count = loop_parts[i][1];
    }
    x->seen.room = loop_take(memory, &used, view_room(&x->seen));
    controller->look = view_of(&x->seen);
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
    memset(x, 0, sizeof *x);
    numbers = loop_fill(x, (double *)(void *)(at + loop_bytes(sizeof *x)));
    at += loop_bytes(sizeof *x) + loop_bytes(numbers * sizeof(double));
    x->both = regulator_init(at, &x->settings);
    model_start(x, NULL, NULL);
    return x;
}

void model_start(model_loop *x, const double *state, const double *inputs)
{
    regulator_start(x->both, state ? state : loop_state, inputs ? inputs : loop_inputs,
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

void model_applied(model_loop *x, const double *inputs)
{
    regulator_applied(x->both, inputs);
}

void model_prepare(model_loop *x)
{
    regulator_prepare(x->both);
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
    const one_step *model = &x->settings.controller.model;
    return model->advance(model->context, 1, model->step, state, inputs, NULL, next, by_state,
                          by_inputs);
}

int model_place(model_loop *x, const double *state, double *position, double *by_state)
{
    const one_look *place = &x->seen.part[0].look;
    return place->see(place->context, 1, state, NULL, position, by_state);
}
