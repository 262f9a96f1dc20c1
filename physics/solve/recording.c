#include "physics/solve/recording.h"

#include "physics/chain/reduced.h"
#include "physics/learn/model.h"
#include "physics/numerics/quaternion.h"
#include "physics/numerics/spline.h"
#include "physics/scene/scene_values.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of modes and rates that have no unit: differences of motions are those of what differs. */
static const double NEWTON = 1e-10;

/* Stops closer to each other than this part of the time at hand are one. */
static const double SAME = 1e-12;

struct solve_recording {
    const scene *open;
    reduced_rod *rod;
    size_t places;
    int parameters;
    size_t velocity;        /* its first column */
    uint64_t timed, states; /* parameters of plays of time, and states of memory among them */
    double time, *state;    /* as it is now */
    const solve_inputs *of; /* the recording of which the following are */
    uint64_t followed;      /* inputs that ends follow; */
    double *path;           /* [samples][parameters] theirs, smooth, and then slopes; NULL: none */
    double *rates[2];       /* [parameters] as they are now, and after a step */
    reduced_place *seen;    /* [3][places]: as it is, and with a parameter moved to both sides */
    size_t columns;
    /* Of solve_recording_change: so many last parameters, from `first` on; 0: values alone. */
    size_t count, first;
    double *change; /* [states + parameters][count] of the state, and of parameters */
    double *moved;  /* [states] */
    double *by_seen;
};

void solve_inputs_at(const solve_inputs *inputs, int parameters, double t, size_t *at,
                     double *values)
{
    const double *times = inputs->t;
    while (*at + 2 < inputs->count && t >= times[*at + 1]) {
        ++*at;
    }
    const size_t width = (size_t)parameters, next = *at + 1 < inputs->count ? *at + 1 : *at;
    const double *from = inputs->values + *at * width, *to = inputs->values + next * width;
    const double span = times[next] - times[*at];
    const double part = span > 0 ? fmin(1, fmax(0, (t - times[*at]) / span)) : 0;
    for (size_t k = 0; k < width; k++) {
        if (inputs->which >> k & 1) {
            values[k] = part == 1 ? to[k] : from[k] + part * (to[k] - from[k]);
        }
    }
}

/* ---- making -------------------------------------------------------------------------------- */

size_t solve_velocity_column(const scene *open)
{
    const scene_physics *physics = scene_physics_of(open);
    size_t column = 0;
    while (strcmp(physics->columns[column].name, "vx") != 0) {
        column++;
    }
    return column;
}

ad_status solve_recording_create(const scene *open, const int modes[4], size_t places,
                                 const double *s, solve_recording **result, ad_error *error)
{
    solve_recording *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a recording");
    }
    const uint64_t unknown = ~UINT64_C(0) << scene_known_count(open);
    const reduced_settings settings = {.modes = {modes[0], modes[1], modes[2], modes[3]},
                                       .staying = unknown,
                                       .count = (int)places,
                                       .s = s,
                                       .newton = NEWTON,
                                       .follows = true};
    const scene_physics *physics = scene_physics_of(open);
    ad_status status = reduced_create(open, &settings, &x->rod, error);
    if (status == AD_OK) {
        x->open = open;
        x->timed = open->timed;
        for (int k = scene_given_count(open); k < scene_known_count(open); k++) {
            x->states |= UINT64_C(1) << k;
        }
        x->places = places;
        x->parameters = open->parameter_count;
        x->state = malloc((size_t)reduced_all_states(x->rod) * sizeof *x->state);
        x->rates[0] = calloc(2 * (size_t)open->parameter_count + 1, sizeof(double));
        x->rates[1] = x->rates[0] + open->parameter_count;
        x->seen = malloc((3 * places + 1) * sizeof *x->seen);
        x->columns = (size_t)physics->column_count;
        x->velocity = solve_velocity_column(open);
        status = x->state && x->seen && x->rates[0]
                     ? AD_OK
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for a rod");
    }
    if (status != AD_OK) {
        solve_recording_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void solve_recording_free(solve_recording *recording)
{
    if (recording) {
        reduced_free(recording->rod);
        free(recording->state);
        free(recording->rates[0]);
        free(recording->path);
        free(recording->seen);
        free(recording->change);
        free(recording);
    }
}

/* ---- inputs that ends follow --------------------------------------------------------------- */

/* Samples have noise, of which accelerations are that over the square of their distance in time. */
static void smooth(const solve_recording *x, const solve_inputs *inputs, size_t k, double *room)
{
    const size_t count = inputs->count, width = (size_t)x->parameters;
    double *y = room, *slope = y + count, *rest = slope + count;
    for (size_t i = 0; i < count; i++) {
        slope[i] = inputs->values[i * width + k];
    }
    spline_smooth(count, inputs->t, slope, spline_noise(count, inputs->t, slope), y, rest);
    spline_slopes(count, inputs->t, y, slope, rest);
    for (size_t i = 0; i < count; i++) {
        x->path[i * width + k] = y[i];
        x->path[(count + i) * width + k] = slope[i];
    }
}

/* q and -q are one rotation, but what goes from one to the other turns once around. */
static ad_status check_sign(const solve_recording *x, const solve_inputs *inputs, bool end,
                            ad_error *error)
{
    const scene_end *of = end ? &x->open->end : &x->open->start;
    const scene_values names = scene_values_of(x->open);
    const size_t width = (size_t)x->parameters;
    double before[4];
    for (size_t i = 0; i < inputs->count && of->rotation[0].is_given; i++) {
        double same = 0;
        for (size_t k = 0; k < 4; k++) {
            const double now = scene_value_at(&names, of->rotation[k], inputs->values + i * width);
            same += i > 0 ? now * before[k] : 1;
            before[k] = now;
        }
        if (same < 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "boundary.%s.rotation changes its sign at t = %g s of the inputs; "
                           "allowed: quaternions that go on, of which q and -q are one rotation",
                           end ? "end" : "start", inputs->t[i]);
        }
    }
    return AD_OK;
}

/* Springs and foundations are measured from the unstressed rod, which would move with the start. */
static ad_status check_start(const scene *open, uint64_t which, ad_error *error)
{
    const bool counts = scene_measures_from_rest(open);
    for (int k = 0; k < open->parameter_count && counts; k++) {
        const char *name = open->parameters[k].name;
        if (which >> k & 1 && (quantity_any_depends_on(3, open->start.position, name) ||
                               quantity_any_depends_on(4, open->start.rotation, name))) {
            return ad_fail(error, AD_BAD_INPUT,
                           "boundary.start follows the input %s, and springs or a foundation are "
                           "measured from the unstressed rod there; allowed: springs that do not "
                           "turn, with an anchor",
                           name);
        }
    }
    return AD_OK;
}

static ad_status find_path(solve_recording *x, const solve_inputs *inputs, ad_error *error)
{
    enum { ROOM = 8 };
    const size_t count = inputs->count, width = (size_t)x->parameters;
    const uint64_t which = reduced_followed(x->rod) & inputs->which;
    memset(x->rates[0], 0, 2 * width * sizeof *x->rates[0]);
    if (x->of == inputs) {
        return AD_OK;
    }
    ad_status status = which ? check_sign(x, inputs, false, error) : AD_OK;
    status = status == AD_OK && which ? check_sign(x, inputs, true, error) : status;
    status = status == AD_OK ? check_start(x->open, which, error) : status;
    if (status != AD_OK) {
        return status;
    }
    free(x->path);
    x->of = NULL;
    x->path = which ? malloc(count * (2 * width + ROOM) * sizeof *x->path) : NULL;
    if (which && !x->path) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu samples", count);
    }
    for (size_t k = 0; k < width; k++) {
        if (which >> k & 1) {
            smooth(x, inputs, k, x->path + 2 * count * width);
        }
    }
    x->of = inputs;
    x->followed = which;
    return AD_OK;
}

/* Inputs at a time, and the rates of those that ends follow. */
static void inputs_at(const solve_recording *x, const solve_inputs *inputs, double t, size_t *at,
                      double *values, double *rates)
{
    const size_t width = (size_t)x->parameters;
    solve_inputs_at(inputs, x->parameters, t, at, values);
    const size_t next = *at + 1 < inputs->count ? *at + 1 : *at;
    const double h = inputs->t[next] - inputs->t[*at];
    const double part = h > 0 ? fmin(1, fmax(0, (t - inputs->t[*at]) / h)) : 0;
    for (size_t k = 0; k < width && x->followed; k++) {
        if (x->followed >> k & 1) {
            const double *y = x->path + k, *slope = y + inputs->count * width;
            double now[3];
            spline_between((double[]){y[*at * width], y[next * width]},
                           (double[]){slope[*at * width], slope[next * width]}, h, part, now);
            values[k] = now[0];
            rates[k] = now[1];
        }
    }
}

/* ---- running ------------------------------------------------------------------------------- */

/* How far a parameter is moved for a difference, of what is solved to 1e-10. */
static double beside(const solve_recording *x, size_t parameter, double value)
{
    const scene_parameter *p = reduced_input(x->rod, (int)parameter);
    const double range = p->high - p->low;
    return 1e-4 * fmin(range, fabs(value) + 1e-3 * range);
}

/* A step, and how the state after it changes. */
static ad_status step(solve_recording *x, double h, const double *now, const double *after,
                      ad_error *error)
{
    if (x->followed) {
        reduced_follow(x->rod, x->rates[0], x->rates[1]);
    }
    return reduced_step_along(x->rod, x->time, h, x->state, now, after, x->state, (int)x->count,
                              x->change, error);
}

/* A step from one time to another that has no sample between; two of half of it where Newton's
 * method fails, as where ends begin to move at once. */
static ad_status advance(solve_recording *x, const solve_inputs *inputs, double from, double to,
                         int halved, size_t *at, double *now, ad_error *error)
{
    enum { HALVED_MOST = 6 };
    double after[SCENE_PARAMETERS_MAX];
    size_t sample = *at;
    memcpy(after, now, sizeof after);
    inputs_at(x, inputs, to, &sample, after, x->rates[1]);
    x->time = from;
    ad_status status = step(x, to - from, now, after, error);
    if (status == AD_NOT_FINITE && halved < HALVED_MOST) {
        const double middle = from + (to - from) / 2;
        status = advance(x, inputs, from, middle, halved + 1, at, now, error);
        return status == AD_OK ? advance(x, inputs, middle, to, halved + 1, at, now, error)
                               : status;
    }
    if (status == AD_OK) {
        *at = sample;
        memcpy(now, after, sizeof after);
        memcpy(x->rates[0], x->rates[1], (size_t)x->parameters * sizeof *x->rates[0]);
    }
    return status;
}

/* On to a time through all samples between. */
static ad_status go_on(solve_recording *x, const solve_inputs *inputs, double *now, int parts,
                       double *t, double to, size_t *at, ad_error *error)
{
    ad_status status = AD_OK;
    while (*t < to && status == AD_OK) {
        size_t next = *at;
        while (next < inputs->count && inputs->t[next] <= *t + SAME * fmax(1, *t)) {
            next++;
        }
        const double sample = next < inputs->count ? inputs->t[next] : to;
        const double stop = sample < to - SAME * fmax(1, to) ? sample : to;
        const double begin = *t, h = (stop - begin) / parts;
        for (int i = 0; i < parts && status == AD_OK; i++) {
            status = advance(x, inputs, begin + i * h, i + 1 < parts ? begin + (i + 1) * h : stop,
                             0, at, now, error);
        }
        *t = x->time = stop;
    }
    return status;
}

/* What was measured in one row, from the place at which it was. */
static void give(const solve_recording *x, const reduced_place *place, size_t row, size_t rows,
                 double *values)
{
    for (size_t k = 0; k < 3; k++) {
        values[k * rows + row] = place->position[k];
        values[(x->velocity + k) * rows + row] = place->velocity[k];
        values[(x->velocity + 3 + k) * rows + row] = place->angular_velocity[k];
    }
    for (size_t k = 0; k < 4; k++) {
        values[(3 + k) * rows + row] = place->rotation[k];
    }
}

/* The state with which the motion begins; states of memory among the parameters, too. */
static ad_status begin(solve_recording *x, double *now, double *state, ad_error *error)
{
    reduced_begin(x->rod, now, state);
    return reduced_initial(x->rod, now, state, error);
}

/* How the state at the start changes. */
static ad_status start_change(solve_recording *x, const double *now, ad_error *error)
{
    const size_t n = (size_t)reduced_all_states(x->rod);
    double moved[SCENE_PARAMETERS_MAX], *room = x->moved;
    ad_status status = AD_OK;
    for (size_t i = 0; i < x->count && status == AD_OK; i++) {
        const double by = beside(x, x->first + i, now[x->first + i]);
        for (int side = -1; side <= 1 && status == AD_OK; side += 2) {
            memcpy(moved, now, sizeof moved);
            moved[x->first + i] += side * by;
            status = begin(x, moved, room, error);
            for (size_t r = 0; r < n && status == AD_OK; r++) {
                double *to = &x->change[r * x->count + i];
                *to = side < 0 ? -room[r] / (2 * by) : *to + room[r] / (2 * by);
            }
        }
    }
    return status;
}

/* Of one parameter what follows from where the start is held: x->seen behind the first. */
static ad_status look_beside(solve_recording *x, const double *now, size_t i, double by,
                             ad_error *error)
{
    const size_t n = (size_t)reduced_states(x->rod),
                 memory = (size_t)reduced_all_states(x->rod) - n;
    double moved[SCENE_PARAMETERS_MAX], *state = x->moved;
    ad_status status = AD_OK;
    for (int side = 0; side < 2 && status == AD_OK; side++) {
        const double off = side ? by : -by;
        memcpy(moved, now, sizeof moved);
        moved[x->first + i] += off;
        for (size_t k = 0; k < memory; k++) {
            state[n + k] = x->state[n + k] + off * x->change[(n + k) * x->count + i];
        }
        reduced_remember(x->rod, state, moved);
        status = reduced_output(x->rod, x->time, x->state, moved,
                                x->seen + (1 + (size_t)side) * x->places, NULL, error);
    }
    return status;
}

/* change [13] in the order of reduced_place, by parameter i through the state. */
static void change_place(const solve_recording *x, size_t place, size_t i, double *change)
{
    enum { ROWS = 12 };
    const size_t n = 2 * (size_t)reduced_modes(x->rod);
    const double *by = x->by_seen + place * ROWS * n, *q = x->seen[place].rotation;
    double rows[ROWS];
    for (size_t r = 0; r < ROWS; r++) {
        rows[r] = 0;
        for (size_t c = 0; c < n; c++) {
            rows[r] += by[r * n + c] * x->change[c * x->count + i];
        }
    }
    const double half[4] = {0, rows[3] / 2, rows[4] / 2, rows[5] / 2}; /* q_t = (0, w) q / 2 */
    memcpy(change, rows, 3 * sizeof *rows);
    quaternion_product(half, q, change + 3);
    memcpy(change + 7, rows + 6, 6 * sizeof *rows);
}

/* Rows from `row` to before `end`, of one time. */
static ad_status give_change(solve_recording *x, const double *now, const size_t *places,
                             size_t row, size_t end, size_t rows, double *by, ad_error *error)
{
    const bool held = reduced_is_placed(x->rod);
    ad_status status = AD_OK;
    for (size_t i = 0; i < x->count && status == AD_OK; i++) {
        const double off = beside(x, x->first + i, now[x->first + i]);
        status = held ? AD_OK : look_beside(x, now, i, off, error);
        for (size_t k = row; k < end && status == AD_OK; k++) {
            reduced_place change;
            double *all = change.position; /* 13 numbers */
            change_place(x, places[k], i, all);
            const double *low = x->seen[x->places + places[k]].position;
            const double *high = x->seen[2 * x->places + places[k]].position;
            for (size_t c = 0; c < 13 && !held; c++) {
                all[c] += (high[c] - low[c]) / (2 * off);
            }
            give(x, &change, k, rows, by + i * x->columns * rows);
        }
    }
    if (!held && status == AD_OK) { /* the start is again where it is */
        status = reduced_output(x->rod, x->time, x->state, now, x->seen, NULL, error);
    }
    return status;
}

static ad_status run(solve_recording *x, const solve_inputs *inputs, const double *parameters,
                     int parts, size_t rows, const double *t, const size_t *places, double *values,
                     double *by, ad_error *error)
{
    double now[SCENE_PARAMETERS_MAX] = {0}, time = 0;
    size_t at = 0;
    if (inputs->t[0] > 0 || inputs->t[inputs->count - 1] < t[rows - 1]) {
        return ad_fail(error, AD_BAD_INPUT,
                       "inputs are recorded from t = %g to %g s; allowed: from 0 to %g at least",
                       inputs->t[0], inputs->t[inputs->count - 1], t[rows - 1]);
    }
    if ((inputs->which | x->states) & x->timed) {
        return ad_fail(error, AD_BAD_INPUT,
                       "a play of a formula of t depends on inputs that are recorded; allowed: of "
                       "either t or inputs");
    }
    x->time = 0;
    memcpy(now, parameters, (size_t)x->parameters * sizeof *now);
    ad_status status = find_path(x, inputs, error);
    if (status != AD_OK) {
        return status;
    }
    inputs_at(x, inputs, 0, &at, now, x->rates[0]);
    reduced_follow(x->rod, x->followed ? x->rates[0] : NULL, x->rates[0]);
    status = begin(x, now, x->state, error);
    status = status == AD_OK ? start_change(x, now, error) : status;
    for (size_t row = 0, end; row < rows && status == AD_OK; row = end) {
        ad_error reason;
        status = go_on(x, inputs, now, parts, &time, t[row], &at, &reason);
        if (status != AD_OK) {
            return ad_fail(error, status, "from t = %g s on: %s", time, reason.message);
        }
        reduced_remember(x->rod, x->state, now);
        if (x->followed) {
            reduced_follow(x->rod, x->rates[0], x->rates[0]);
        }
        status = reduced_output(x->rod, x->time, x->state, now, x->seen,
                                x->count ? x->by_seen : NULL, error);
        for (end = row; end < rows && t[end] == t[row]; end++) {
            give(x, &x->seen[places[end]], end, rows, values);
        }
        status = status == AD_OK && x->count > 0
                     ? give_change(x, now, places, row, end, rows, by, error)
                     : status;
    }
    return status;
}

ad_status solve_recording_run(solve_recording *x, const solve_inputs *inputs,
                              const double *parameters, int parts, size_t rows, const double *t,
                              const size_t *places, double *values, ad_error *error)
{
    x->count = 0;
    return run(x, inputs, parameters, parts, rows, t, places, values, NULL, error);
}

ad_status solve_recording_change(solve_recording *x, const solve_inputs *inputs,
                                 const double *parameters, int parts, size_t rows, const double *t,
                                 const size_t *places, double *values, size_t count, double *by,
                                 ad_error *error)
{
    const size_t n = (size_t)reduced_all_states(x->rod), m = (size_t)x->parameters;
    free(x->change);
    x->count = count;
    x->first = m - count;
    double *at = x->change = calloc((n + m) * count + n + 12 * n * x->places + 1, sizeof *at);
    if (!at) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of a motion");
    }
    for (size_t i = 0; i < count; i++) {
        at[(n + x->first + i) * count + i] = 1;
    }
    x->moved = at + (n + m) * count;
    x->by_seen = x->moved + n;
    return run(x, inputs, parameters, parts, rows, t, places, values, by, error);
}
