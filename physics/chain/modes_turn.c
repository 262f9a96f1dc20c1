/* A base that a drive turns about the axis d3 of the rod there: a hinge whose angle a follows an
 * input as modes_drive_residual says. What is given is that of the angle 0. */
#include "physics/chain/modes_internal.h"

#include <math.h>
#include <string.h>

/* Of quaternions and places over the length, beside what rounding leaves of formulas. */
static const double SAME = 1e-12;

static ad_status start_at(const modes *m, const double *inputs, solve_end_state *start,
                          ad_error *error)
{
    const double s = 0;
    const ad_status status =
        solve_rod_part(m->rod, SOLVE_START, 1, &s, 0, inputs, (double *)start, error);
    quaternion_normalize(start->rotation);
    return status;
}

/* By how much b is not a, turned about its d3. */
static double off_by(const solve_end_state *a, double angle, const solve_end_state *b)
{
    const double turn[4] = {cos(angle / 2), 0, 0, sin(angle / 2)};
    double turned[4], apart = 0, opposite = 0, far = 0;
    quaternion_product(a->rotation, turn, turned);
    for (int k = 0; k < 4; k++) {
        apart = fmax(apart, fabs(b->rotation[k] - turned[k]));
        opposite = fmax(opposite, fabs(b->rotation[k] + turned[k]));
    }
    for (int k = 0; k < 3; k++) {
        far = fmax(far, fabs(b->position[k] - a->position[k]));
    }
    return fmax(far, fmin(apart, opposite));
}

ad_status modes_turn_find(modes *m, const solve_parameters *open, ad_error *error)
{
    static const double angles[] = {-3, -1.3, -0.2, 0.4, 1.1, 2.9};
    const scene *given = &m->rod->scene;
    const solve_part_kind kind = solve_rod_part_kind(m->rod, SOLVE_START);
    double inputs[SCENE_PARAMETERS_MAX], worst = kind.by_t ? INFINITY : 0;
    solve_end_state usual, at;
    if (!open || !given->start.turn_time.is_given) {
        return AD_OK;
    }
    memcpy(inputs, open->values, (size_t)open->count * sizeof *inputs);
    ad_status status = start_at(m, inputs, &usual, error);
    for (int k = 0; k < open->count && status == AD_OK; k++) {
        inputs[k] += 0.3;
        status = start_at(m, inputs, &at, error);
        inputs[k] = open->values[k];
        if (status == AD_OK && off_by(&usual, 0, &at) > SAME) {
            worst = m->turn.input < 0 ? worst : INFINITY; /* two of them */
            m->turn.input = k;
        }
    }
    const int k = m->turn.input;
    for (size_t i = 0; i < sizeof angles / sizeof *angles && status == AD_OK && k >= 0; i++) {
        inputs[k] = angles[i];
        status = start_at(m, inputs, &at, error);
        worst = fmax(worst, off_by(&usual, angles[i] - open->values[k], &at));
    }
    if (status == AD_OK && (k < 0 || !(worst <= SAME))) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "boundary.start.turn_time: allowed where boundary.start.rotation is turned "
                       "about d3 by one parameter with a range, in rad, and the start does not "
                       "move otherwise");
    }
    if (status == AD_OK && (quantity_any_something(3, given->initial.velocity) ||
                            quantity_any_something(3, given->initial.angular_velocity))) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "a base that turns does not take an initial velocity yet; allowed: a scene "
                       "without it");
    }
    m->turn.mode = 0;
    m->turn.lag = quantity_number_or(given->start.turn_time, 0) / m->rod->scales.time;
    return status;
}

void modes_turn_take(modes *m, const double *q, const double *v, const double *a)
{
    const int k = m->turn.mode;
    m->turn.now[0] = q[k];
    m->turn.now[1] = v[k];
    m->turn.now[2] = a ? a[k] : 0;
}

double modes_turn_residual(const modes *m)
{
    return modes_drive_residual(m->turn.lag, m->turn.now, m->turn.command);
}

void modes_turn_derivatives(modes *m, double *by_q, double *by_v)
{
    const int k = m->turn.mode, width = m->width;
    const double own[3] = {1 / (m->turn.lag * m->turn.lag), 2 / m->turn.lag, 1};
    double *const rows[3] = {by_q, by_v, m->mass};
    for (int i = 0; i < 3; i++) {
        memset(rows[i] + k * width, 0, (size_t)m->size * sizeof(double));
        rows[i][k * width + k] = own[i];
    }
}
