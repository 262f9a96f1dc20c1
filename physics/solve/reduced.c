#include "physics/solve/reduced.h"

#include "autodiff/dense.h"
#include "physics/solve/modes_internal.h"
#include "physics/solve/modes_step.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a step: of order 5. */
enum { STAGES = 3 };

/* Of each place: position, turn, velocity, angular velocity. */
enum { OUTPUT_ROWS = 12 };

_Static_assert(offsetof(reduced_place, angular_velocity) == 10 * sizeof(double) &&
                   sizeof(reduced_place) == 13 * sizeof(double),
               "as kinematics.h has them");

struct reduced_rod {
    scene open;
    const char *names[SCENE_PARAMETERS_MAX];
    double usual[SCENE_PARAMETERS_MAX];
    solve_rod *rod;
    modes *m;
    collocation *step;
    kinematics look; /* of places, all rows but those of curvature */
    int count;
    double newton;
    double *unit;        /* [states] of the state: SI by the model's */
    double *q, *v, *a;   /* [size] each */
    double *residual;    /* [size] */
    double *start;       /* [states] */
    double *by_q, *by_v; /* [size][width] */
    double *by;          /* [states][states + inputs] */
    double *mass;        /* [width][width] */
    double *room;        /* of the derivatives of a step */
    double *seen;        /* [count][KINEMATICS_SEEN] */
    double *look_room;
    double *memory;
    int *pivots; /* [size] */
};

/* ---- making -------------------------------------------------------------------------------- */

static ad_status create_model(reduced_rod *x, const reduced_settings *settings, ad_error *error)
{
    const scene *open = &x->open;
    const int *given = settings->modes, count = open->parameter_count;
    const bool is_given = given[0] + given[1] + given[2] + given[3] > 0;
    const modes_counts counts = is_given ? modes_counts_of(given[0], given[1], given[2], given[3])
                                         : modes_counts_of(3, 1, 2, 1);
    solve_parameters parameters = {count, x->names, x->usual};
    double low[SCENE_PARAMETERS_MAX], high[SCENE_PARAMETERS_MAX];
    scene_middle_values(open, x->usual);
    for (int k = 0; k < count; k++) {
        x->names[k] = open->parameters[k].name;
        low[k] = open->parameters[k].low;
        high[k] = open->parameters[k].high;
    }
    ad_status status = count > 0 ? solve_rod_create_open(open, &parameters, &x->rod, error)
                                 : solve_rod_create(open, &x->rod, error);
    if (status == AD_OK) {
        status = modes_create(x->rod, count > 0 ? &parameters : NULL, &counts, 0, &x->m, error);
    }
    return status == AD_OK ? modes_set_ranges(x->m, low, high, error) : status;
}

static ad_status place(reduced_rod *x, const reduced_settings *settings, ad_error *error)
{
    const double length = x->rod->scales.length;
    const size_t places = (size_t)settings->count;
    double *s = malloc((places + 1) * sizeof *s);
    int *rows = malloc((OUTPUT_ROWS * places + 1) * sizeof *rows);
    ad_status status = s && rows ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for places");
    x->count = settings->count;
    for (int i = 0; i < x->count && status == AD_OK; i++) {
        s[i] = settings->s[i] / length;
        for (int k = 0; k < OUTPUT_ROWS; k++) {
            rows[i * OUTPUT_ROWS + k] = i * KINEMATICS_ROWS + k;
        }
        if (!(s[i] >= 0 && s[i] <= 1 + 1e-12)) {
            status = ad_fail(error, AD_BAD_ARGUMENT, "s[%d] = %g; allowed: 0 to %g", i,
                             settings->s[i], length);
        }
    }
    if (status == AD_OK) {
        status = modes_kinematics_create(x->m, places, s, OUTPUT_ROWS * settings->count, rows,
                                         &x->look, error);
    }
    free(s);
    free(rows);
    return status;
}

static ad_status allocate(reduced_rod *x, ad_error *error)
{
    const modes *m = x->m;
    const size_t n = (size_t)m->size, width = (size_t)m->width, inputs = (size_t)m->inputs;
    const size_t square = (n + QUAD) * width;
    double **const parts[] = {&x->unit,  &x->q,    &x->v,        &x->a,  &x->residual,
                              &x->start, &x->by_q, &x->by_v,     &x->by, &x->mass,
                              &x->room,  &x->seen, &x->look_room};
    const size_t sizes[] = {2 * n,
                            n,
                            n,
                            n,
                            n,
                            2 * n,
                            square,
                            square,
                            2 * n * (2 * n + inputs),
                            square,
                            collocation_derivative_room(x->step),
                            KINEMATICS_SEEN * (size_t)x->count,
                            kinematics_room(&x->look)};
    size_t all = 0;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        all += sizes[i];
    }
    double *at = x->memory = calloc(all, sizeof *at);
    x->pivots = calloc(n + 1, sizeof *x->pivots);
    if (!at || !x->pivots) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a reduced rod");
    }
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        *parts[i] = at;
        at += sizes[i];
    }
    for (size_t k = 0; k < n; k++) {
        const bool bends = m->mode[k].strain >= MODES_U && k >= (size_t)m->hinges;
        x->unit[k] = bends ? 1 / x->rod->scales.length : 1;
        x->unit[n + k] = x->unit[k] / x->rod->scales.time;
    }
    return AD_OK;
}

ad_status reduced_create(const scene *rod_scene, const reduced_settings *settings,
                         reduced_rod **result, ad_error *error)
{
    reduced_rod *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a reduced rod");
    }
    x->open = *rod_scene;
    x->newton = settings->newton > 0 ? settings->newton : 1e-5; /* errors of a step are larger */
    ad_status status = create_model(x, settings, error);
    status = status == AD_OK ? collocation_create(x->m, STAGES, &x->step, error) : status;
    status = status == AD_OK ? place(x, settings, error) : status;
    status = status == AD_OK ? allocate(x, error) : status;
    if (status != AD_OK) {
        reduced_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void reduced_free(reduced_rod *x)
{
    if (x) {
        modes_kinematics_free(&x->look);
        collocation_free(x->step);
        modes_free(x->m);
        solve_rod_free(x->rod);
        free(x->pivots);
        free(x->memory);
        free(x);
    }
}

int reduced_states(const reduced_rod *x)
{
    return 2 * x->m->size;
}

int reduced_inputs(const reduced_rod *x)
{
    return x->m->inputs;
}

const scene_parameter *reduced_input(const reduced_rod *x, int i)
{
    return &x->open.parameters[i];
}

reduced_mode reduced_mode_of(const reduced_rod *x, int k)
{
    const modes_mode *mode = &x->m->mode[k];
    return (reduced_mode){k < x->m->hinges ? -1 : mode->strain, mode->degree, mode->first_element};
}

/* ---- states -------------------------------------------------------------------------------- */

static void take_state(reduced_rod *x, const double *state)
{
    const int n = x->m->size;
    for (int k = 0; k < n; k++) {
        x->q[k] = state[k] / x->unit[k];
        x->v[k] = state[n + k] / x->unit[n + k];
    }
}

static void give_state(const reduced_rod *x, double *state)
{
    const int n = x->m->size;
    for (int k = 0; k < n; k++) {
        state[k] = x->q[k] * x->unit[k];
        state[n + k] = x->v[k] * x->unit[n + k];
    }
}

/* The model at a time and inputs, with the state in x->q, x->v. */
static ad_status go_to(reduced_rod *x, double t, const double *state, const double *inputs,
                       ad_error *error)
{
    take_state(x, state);
    return modes_at(x->m, t / x->rod->scales.time, inputs, error);
}

ad_status reduced_initial(reduced_rod *x, const double *inputs, double *state, ad_error *error)
{
    const modes_linear room = {x->q, x->v, x->residual, x->by_q, x->by_v, x->mass, x->pivots};
    const bool settles = x->m->inputs > 0 && x->open.initial.state == SCENE_EQUILIBRIUM;
    ad_status status = settles ? ad_dense_load(error) : modes_at(x->m, 0, inputs, error);
    if (status == AD_OK) {
        status = settles ? modes_initial_settled(x->m, x->usual, inputs, &room, error)
                         : modes_initial(x->m, x->q, x->v, error);
    }
    if (status == AD_OK) {
        give_state(x, state);
    }
    return status;
}

ad_status reduced_settle(reduced_rod *x, double t, const double *inputs, double *state,
                         ad_error *error)
{
    const modes_linear room = {x->q, x->v, x->residual, x->by_q, x->by_v, x->mass, x->pivots};
    ad_status status = go_to(x, t, state, inputs, error);
    status = status == AD_OK ? modes_settle(x->m, &room, error) : status;
    if (status == AD_OK) {
        give_state(x, state);
    }
    return status;
}

/* ---- rates and steps ----------------------------------------------------------------------- */

/* x->by [.][2 n + inputs]: derivatives of the accelerations by q, v, and inputs where these are
 * wanted, in the model's units. */
static ad_status differentiate(reduced_rod *x, double t, bool by_inputs, ad_error *error)
{
    modes *m = x->m;
    const int n = m->size, width = m->width, columns = 2 * n + m->inputs;
    const int wanted = by_inputs ? columns : 2 * n;
    ad_status status = AD_OK;
    modes_shape(m, x->q, x->v, x->a);
    modes_forces(m, true, x->residual);
    memcpy(x->mass, m->mass, (size_t)(n * width) * sizeof *x->mass); /* its factor */
    modes_mass(m);
    modes_derivatives(m, x->by_q, x->by_v);
    if (wanted > 2 * n) {
        status = modes_by_inputs(m, t / x->rod->scales.time, x->q, x->v, x->a, x->room, error);
    }
    for (int c = 0; c < wanted; c++) {
        for (int r = 0; r < n; r++) {
            x->residual[r] = -(c < n       ? x->by_q[r * width + c]
                               : c < 2 * n ? x->by_v[r * width + c - n]
                                           : x->room[r * m->inputs + c - 2 * n]);
        }
        modes_solve_factored(m, x->mass, x->residual);
        for (int r = 0; r < n; r++) {
            x->by[r * columns + c] = x->residual[r];
        }
    }
    return status;
}

ad_status reduced_rate(reduced_rod *x, double t, const double *state, const double *inputs,
                       double *rate, double *by_state, double *by_inputs, ad_error *error)
{
    const int n = x->m->size, count = x->m->inputs, wanted = 2 * n + count;
    const double time = x->rod->scales.time;
    ad_status status = go_to(x, t, state, inputs, error);
    if (status == AD_OK && !modes_accelerations(x->m, x->q, x->v, x->a)) {
        status = ad_fail(error, AD_NOT_FINITE, "the mass matrix of the modes is singular");
    }
    if (status == AD_OK && (by_state || by_inputs)) {
        status = differentiate(x, t, by_inputs != NULL, error);
    }
    for (int r = 0; r < n && status == AD_OK; r++) {
        const double unit = x->unit[n + r] / time;
        rate[r] = x->v[r] * x->unit[n + r];
        rate[n + r] = x->a[r] * unit;
        for (int c = 0; c < 2 * n && by_state; c++) {
            by_state[r * 2 * n + c] = c == n + r;
            by_state[(n + r) * 2 * n + c] = x->by[r * wanted + c] * unit / x->unit[c];
        }
        for (int c = 0; c < count && by_inputs; c++) {
            by_inputs[r * count + c] = 0;
            by_inputs[(n + r) * count + c] = x->by[r * wanted + 2 * n + c] * unit;
        }
    }
    return status;
}

ad_status reduced_step(reduced_rod *x, double t, double h, const double *state,
                       const double *inputs, double *next, double *by_state, double *by_inputs,
                       ad_error *error)
{
    return reduced_step_linear(x, t, h, state, inputs, NULL, next, by_state, by_inputs, error);
}

ad_status reduced_step_linear(reduced_rod *x, double t, double h, const double *state,
                              const double *inputs, const double *after, double *next,
                              double *by_state, double *by_inputs, ad_error *error)
{
    const int n = x->m->size, count = x->m->inputs, wanted = 2 * n + count;
    const double time = x->rod->scales.time;
    take_state(x, state);
    memcpy(x->start, x->q, (size_t)n * sizeof *x->q);
    memcpy(x->start + n, x->v, (size_t)n * sizeof *x->v);
    ad_status status =
        collocation_once(x->step, t / time, h / time, inputs, after, x->newton, x->q, x->v, error);
    if (status == AD_OK && (by_state || by_inputs)) {
        status = collocation_derivatives(x->step, t / time, h / time, inputs, after, x->start,
                                         x->start + n, x->room, x->by, error);
    }
    if (status != AD_OK) {
        return status;
    }
    give_state(x, next);
    for (int r = 0; r < 2 * n; r++) {
        for (int c = 0; c < 2 * n && by_state; c++) {
            by_state[r * 2 * n + c] = x->by[r * wanted + c] * x->unit[r] / x->unit[c];
        }
        for (int c = 0; c < count && by_inputs; c++) {
            by_inputs[r * count + c] = x->by[r * wanted + 2 * n + c] * x->unit[r];
        }
    }
    return AD_OK;
}

/* ---- what is seen -------------------------------------------------------------------------- */

ad_status reduced_output(reduced_rod *x, double t, const double *state, const double *inputs,
                         reduced_place *places, double *by_state, ad_error *error)
{
    ad_status status = modes_at(x->m, t / x->rod->scales.time, inputs, error);
    if (status != AD_OK) {
        return status;
    }
    modes_kinematics_start(x->m, &x->look);
    kinematics_see(&x->look, 1, state, x->seen, by_state, x->look_room);
    for (int i = 0; i < x->count; i++) {
        memcpy(&places[i], x->seen + i * KINEMATICS_SEEN, sizeof places[i]);
    }
    return AD_OK;
}

const kinematics *reduced_kinematics(const reduced_rod *x)
{
    return &x->look;
}

bool reduced_is_placed(const reduced_rod *x)
{
    const solve_part_kind kind = solve_rod_part_kind(x->rod, SOLVE_START);
    return !kind.by_t && !kind.by_parameters;
}
