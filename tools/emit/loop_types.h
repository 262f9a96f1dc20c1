
/* All works in the caller's memory, model_MEMORY bytes aligned as malloc's or for a double, and
 * allocates nothing; several may run at once, each with memory of its own. Each function does a
 * bounded amount of work. */
typedef struct model_loop model_loop;

extern const char *const model_input_names[model_INPUTS];
extern const int model_controlled[model_CONTROLLED];                      /* which are answered */
extern const double model_lower[model_INPUTS], model_upper[model_INPUTS]; /* ranges */

/* Bytes that are needed, at most model_MEMORY; and sample 0, the robot at rest. NULL: size is less
 * than that. */
size_t model_size(void);
model_loop *model_init(void *memory, size_t size);

/* Sample 0 again, with another state [STATES] and inputs [INPUTS]; NULL: as at rest. Returns 0, or
 * a flag: they are not finite or none that the model may answer, and all goes on as before. */
int model_start(model_loop *x, const double *state, const double *inputs);

/* Each sample, in this order:
 *
 *   model_measure    values of a sensor that arrived, taken `age` samples ago (age < 0: the
 * sensor's delay); once for a sensor and sample, in any order; nothing, where none has
 *   model_control    inputs [CONTROLLED], to be applied model_DELAY samples from now. path
 *                    [HORIZON][3]: where the place has to be (m, world) 1, 2, .. times
 *                    model_LOOK_AHEAD after the inputs begin to act; NaN: no wish; NULL: what it
 *                    was, one step on
 *   model_late       in place of model_control and model_prepare, in a fraction of their time,
 *                    where there is none, and for each sample that has passed without a call: what
 *                    was measured is taken, the filter goes on by its model, inputs [CONTROLLED]
 *                    are the next ones of the last plan, at its end held; or `held` (1), as where
 *                    nothing can be sent any more, those answered before
 *   model_applied    only if something else acts from now on than was answered [CONTROLLED]
 *   model_prepare    what can be computed before the next measurement; the next call does it where
 *                    it was not called
 *
 * Inputs are always finite, within their limits and rates. model_measure, model_control and
 * model_late return flags. */
int model_measure(model_loop *x, int sensor, int age, const double *values);
int model_control(model_loop *x, const double *path, double *inputs);
int model_late(model_loop *x, int held, double *inputs);
void model_applied(model_loop *x, const double *inputs);
void model_prepare(model_loop *x);

/* Of the last answer, before model_prepare: rows that its quadratic program added or dropped, which
 * is most of what makes one sample longer than another; and how many there are at most. */
int model_iterations(const model_loop *x, int *most);

/* What the filter knows: the state [STATES], all inputs [INPUTS] with those it finds, and standard
 * deviations of one of each. */
const double *model_state(const model_loop *x);
const double *model_inputs(const model_loop *x);
double model_state_deviation(const model_loop *x, int state);
double model_parameter_deviation(const model_loop *x, int parameter);

/* The filter's model by itself: the state model_SAMPLE later for held inputs [INPUTS], and
 * derivatives [STATES][STATES], [STATES][INPUTS], NULL: not wanted. Not 0: there is no answer. And
 * the place [3], derivatives [3][STATES]. */
int model_step(model_loop *x, const double *state, const double *inputs, double *next,
               double *by_state, double *by_inputs);
int model_place(model_loop *x, const double *state, double *position, double *by_state);
