#include "tools/control/plant.h"

#include "nn/rng.h"
#include "physics/chain/reduced.h"
#include "physics/numerics/quaternion.h"
#include "physics/scene/breaks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Longest step of time, s: within it the method is far more exact than any model of the rod. */
static const double STEP = 5e-3;

enum {
    SHAPE = 3,
    OBSERVATIONS = 1 + CONTROL_MEASUREMENTS_MAX + CONTROL_LIMITS_MAX + SHAPE,
    HALVINGS = 10,
    OF_PANEL = 8 /* steps, at least */
};

struct plant {
    const control_settings *control;
    const surroundings *around;
    const scene *of;
    reduced_rod *rod;
    observation
        *observations[OBSERVATIONS]; /* the place, the measurements, the constraints, the shape */
    int count;
    double length, own_length;           /* m, of the nominal rod and of this one */
    int from[SCENE_PARAMETERS_MAX];      /* of its inputs: which of the nominal ones; -1: none */
    double inputs[SCENE_PARAMETERS_MAX]; /* now; those of -1 stay in the middle of their range */
    double t;
    scene_panels panels;           /* of time */
    int panel;                     /* in which t is; the count of them: behind all */
    double *memory, *state, *next; /* [states] */
    nn_rng noise[CONTROL_MEASUREMENTS_MAX], losses[CONTROL_MEASUREMENTS_MAX];
};

/* The end of the nominal rod is the end of this one, other places stay where they are. */
static ad_status add_observation(plant *plant, const scene *of, observation_what what, double at,
                                 ad_error *error)
{
    const double length = scene_length(of);
    at = at >= plant->length * (1 - 1e-12) ? length : at;
    if (at > length) {
        return ad_fail(error, AD_BAD_INPUT,
                       "control.plant.set: makes the rod %g m long, and the place at %g m is seen "
                       "or constrained; allowed: a rod that has it",
                       length, at);
    }
    const observation_sensor sensor = {.what = what, .count = 1, .s = &at};
    return observation_create(of, plant->control->plant_modes, &sensor,
                              &plant->observations[plant->count++], error);
}

static ad_status add_shape(plant *plant, const scene *of, ad_error *error)
{
    static const observation_what parts[SHAPE] = {OBSERVATION_POSITION, OBSERVATION_ROTATION,
                                                  OBSERVATION_CURVATURE};
    double s[PLANT_POINTS];
    ad_status status = AD_OK;
    plant->own_length = scene_length(of);
    for (int i = 0; i < PLANT_POINTS; i++) {
        s[i] = plant->own_length * i / (PLANT_POINTS - 1);
    }
    for (int k = 0; k < SHAPE && status == AD_OK; k++) {
        const observation_sensor sensor = {.what = parts[k], .count = PLANT_POINTS, .s = s};
        status = observation_create(of, plant->control->plant_modes, &sensor,
                                    &plant->observations[plant->count++], error);
    }
    return status;
}

static ad_status map_inputs(plant *plant, const scene *of, const scene *nominal, ad_error *error)
{
    scene_middle_values(of, plant->inputs);
    for (int i = 0; i < of->parameter_count; i++) {
        const scene_parameter *p = &of->parameters[i];
        const int from = plant->from[i] = scene_parameter_find(nominal, p->name);
        if (from >= 0 && (p->low != nominal->parameters[from].low ||
                          p->high != nominal->parameters[from].high)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "control.plant.set: gives %.60s the range %g to %g, and the loop has %g "
                           "to %g; allowed: a value, or formulas in which it stands",
                           p->name, p->low, p->high, nominal->parameters[from].low,
                           nominal->parameters[from].high);
        }
    }
    return AD_OK;
}

ad_status plant_create(const scene *of, const scene *nominal, const control_settings *control,
                       const surroundings *around, plant **result, ad_error *error)
{
    const int *modes = control->plant_modes;
    const reduced_settings settings = {.modes = {modes[0], modes[1], modes[2], modes[3]}};
    plant *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a plant");
    }
    x->control = control;
    x->around = around;
    x->of = of;
    x->length = scene_length(nominal);
    ad_status status = map_inputs(x, of, nominal, error);
    status = status == AD_OK ? reduced_create(of, &settings, &x->rod, error) : status;
    status = status == AD_OK
                 ? add_observation(x, of, OBSERVATION_POSITION, control->track_at, error)
                 : status;
    for (int i = 0; i < control->measurement_count && status == AD_OK; i++) {
        status = add_observation(x, of, control->measurements[i].what, control->measurements[i].at,
                                 error);
    }
    for (int i = 0; i < control->limit_count && status == AD_OK; i++) {
        const control_limit *l = &control->limits[i];
        if (l->what == CONTROL_CLEARANCE && !around) {
            status =
                ad_fail(error, AD_BAD_INPUT, "control.constraints: a clearance is from nothing");
            break;
        }
        /* of a clearance the shape is seen */
        const int what = l->what == CONTROL_CLEARANCE ? OBSERVATION_POSITION : l->what;
        status = add_observation(x, of, (observation_what)what, l->at, error);
    }
    status = status == AD_OK ? add_shape(x, of, error) : status;
    if (status == AD_OK) {
        const size_t n = (size_t)reduced_all_states(x->rod);
        x->state = x->memory = calloc(2 * n, sizeof *x->memory);
        x->next = x->memory ? x->memory + n : NULL;
        status = x->memory ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a plant");
    }
    if (status != AD_OK) {
        plant_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void plant_free(plant *plant)
{
    if (plant) {
        for (int i = 0; i < plant->count; i++) {
            observation_free(plant->observations[i]);
        }
        reduced_free(plant->rod);
        scene_panels_free(&plant->panels);
        free(plant->memory);
        free(plant);
    }
}

static void take_inputs(plant *plant, const double *inputs)
{
    for (int i = 0; i < reduced_inputs(plant->rod); i++) {
        plant->inputs[i] = plant->from[i] < 0 ? plant->inputs[i] : inputs[plant->from[i]];
    }
}

/* ---- motion -------------------------------------------------------------------------------- */

/* In two halves where a step cannot be solved. */
static ad_status step(plant *plant, double h, int halvings, ad_error *error)
{
    ad_status status = reduced_step_whole(plant->rod, plant->t, h, plant->state, plant->inputs,
                                          NULL, plant->next, NULL, NULL, error);
    if (status == AD_OK) {
        double *before = plant->state;
        plant->state = plant->next;
        plant->next = before;
        plant->t += h;
    } else if (status == AD_NOT_FINITE && halvings > 0) {
        status = step(plant, h / 2, halvings - 1, error);
        status = status == AD_OK ? step(plant, h / 2, halvings - 1, error) : status;
    }
    return status;
}

ad_status plant_divide(plant *plant, double duration, ad_error *error)
{
    scene longer = *plant->of;
    longer.duration = quantity_number(duration);
    scene_panels_free(&plant->panels);
    ad_status status = scene_panels_of(&longer, "t", &plant->panels, error);
    if (status == AD_OK && plant->panels.unresolved) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "control.plant: %s changes in more places of t than are found; allowed: "
                         "formulas whose changes are found",
                         plant->panels.unresolved);
    }
    return status;
}

/* In equal parts, of which a panel has at least some. */
static ad_status go_to(plant *plant, double end, bool in_panel, ad_error *error)
{
    const double h = end - plant->t;
    const int least = in_panel ? OF_PANEL : 1, parts = (int)fmax(least, ceil(h / STEP - 1e-9));
    ad_status status = AD_OK;
    for (int i = 0; i < parts && status == AD_OK; i++) {
        status = step(plant, h / parts, HALVINGS, error);
    }
    plant->t = end;
    return status;
}

ad_status plant_step(plant *plant, double h, const double *inputs, ad_error *error)
{
    const double end = plant->t + h, *edge = plant->panels.edges;
    ad_status status = AD_OK;
    take_inputs(plant, inputs);
    while (plant->panel + 1 < plant->panels.count && edge[plant->panel + 1] <= plant->t) {
        plant->panel++;
    }
    for (;
         plant->panel + 1 < plant->panels.count && edge[plant->panel + 1] < end && status == AD_OK;
         plant->panel++) {
        status = go_to(plant, edge[plant->panel + 1], true, error);
    }
    return status == AD_OK ? go_to(plant, end, plant->panels.count > 1, error) : status;
}

ad_status plant_start(plant *plant, const double *inputs, uint64_t seed, ad_error *error)
{
    enum { MOTION = 2000 }; /* steps until it rests, where Newton's method does not get there */
    take_inputs(plant, inputs);
    for (int i = 0; i < CONTROL_MEASUREMENTS_MAX; i++) {
        char name[32];
        snprintf(name, sizeof name, "noise %d", i);
        plant->noise[i] = nn_rng_split(seed, name);
        snprintf(name, sizeof name, "losses %d", i);
        plant->losses[i] = nn_rng_split(seed, name);
    }
    plant->t = 0;
    plant->panel = 0;
    reduced_begin(plant->rod, plant->inputs, plant->state);
    ad_status status = reduced_initial(plant->rod, plant->inputs, plant->state, error);
    if (status == AD_OK &&
        reduced_settle(plant->rod, 0, plant->inputs, plant->state, error) == AD_NOT_FINITE) {
        status = reduced_initial(plant->rod, plant->inputs, plant->state, error);
        for (int i = 0; i < MOTION && status == AD_OK; i++) {
            status = step(plant, STEP, HALVINGS, error);
        }
        plant->t = 0;
        status = status == AD_OK ? reduced_settle(plant->rod, 0, plant->inputs, plant->state, error)
                                 : status;
    }
    return status;
}

/* ---- what is seen -------------------------------------------------------------------------- */

static ad_status see(plant *plant, int which, double *values, int *count, ad_error *error)
{
    const one_observation seen = observation_of(plant->observations[which]);
    *count = seen.values;
    return seen.see(seen.context, 1, plant->state, plant->inputs, values, NULL) == 0
               ? AD_OK
               : ad_fail(error, AD_NOT_FINITE, "nothing is seen of the plant at %g s", plant->t);
}

ad_status plant_place(plant *plant, double position[3], ad_error *error)
{
    int count = 0;
    return see(plant, 0, position, &count, error);
}

ad_status plant_shape(plant *plant, double *position, double *rotation, double *curvature,
                      ad_error *error)
{
    double *const parts[SHAPE] = {position, rotation, curvature};
    ad_status status = AD_OK;
    for (int k = 0; k < SHAPE && status == AD_OK; k++) {
        int count;
        status = see(plant, plant->count - SHAPE + k, parts[k], &count, error);
    }
    return status;
}

double plant_length(const plant *plant)
{
    return plant->own_length;
}

/* By a rotation vector of normal numbers about the axes of what turns. */
static void turn(nn_rng *rng, double deviation, double q[4])
{
    double d[4] = {1, 0, 0, 0}, r[4];
    for (int k = 1; k < 4; k++) {
        d[k] = deviation / 2 * nn_rng_normal(rng);
    }
    quaternion_product(q, d, r);
    quaternion_normalize(r);
    memcpy(q, r, sizeof r);
}

ad_status plant_measure(plant *plant, int i, double values[4], int *count, ad_error *error)
{
    const control_measurement *m = &plant->control->measurements[i];
    const ad_status status = see(plant, 1 + i, values, count, error);
    if (m->what == OBSERVATION_ROTATION) {
        turn(&plant->noise[i], m->noise, values);
        return status;
    }
    for (int k = 0; k < *count; k++) {
        values[k] += m->noise * nn_rng_normal(&plant->noise[i]);
    }
    return status;
}

bool plant_loses(plant *plant, int i)
{
    return nn_rng_uniform(&plant->losses[i]) < plant->control->measurements[i].dropouts;
}

static ad_status clearance(plant *plant, double *value, ad_error *error)
{
    double position[3 * PLANT_POINTS];
    int count;
    const ad_status status = see(plant, plant->count - SHAPE, position, &count, error);
    *value = INFINITY;
    for (int i = 0; i + 1 < PLANT_POINTS && status == AD_OK; i++) {
        const double *at = &position[3 * i];
        *value = fmin(*value, plant->around->of_line(plant->around->context, at, at + 3) -
                                  plant->control->radius);
    }
    return status;
}

ad_status plant_limited(plant *plant, double *values, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < plant->control->limit_count && status == AD_OK; i++) {
        double all[4];
        int count = 0;
        status = see(plant, 1 + plant->control->measurement_count + i, all, &count, error);
        values[i] = all[plant->control->limits[i].axis - 1];
        if (status == AD_OK && plant->control->limits[i].what == CONTROL_CLEARANCE) {
            status = clearance(plant, &values[i], error);
        }
    }
    return status;
}
