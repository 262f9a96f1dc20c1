/* A rod that is fed through its port: motion where s is not a point of the material.
 *
 * What is out of the port up to the first place that anything is at, s from 0 to `to`, is g times
 * as long as where g = 1. Strains are by metres of s, so g is a strain of stretch all along, and
 * g - 1 a mode of the rod like others: kinematics and virtual work at held g know no difference.
 * What is there passes s at the rate
 *
 *   c = s_t = (to - s) g_t / g,   s_tt = (to - s) (g_tt / g - 2 (g_t / g)^2),
 *
 * so with D = d/dt + c d/ds, p = R v, k = R u and w, V of the point of s, its own motion is
 *
 *   w + c k,   D (w + c k) = w_t + 2 c R u_t + c w x k + s_tt k + c^2 R u_s
 *   V + c p,   D (V + c p) = V_t + 2 c (w x p + R v_t) + s_tt p + c^2 (k x p + R v_s)
 *
 * which is the kinematics of axially moving material (Mote, J. Franklin Inst. 279, 1965; Tabarrok,
 * Leech, Kim, J. Franklin Inst. 297, 1974, of a beam that is deployed). Strains of the material by
 * its own metres are v / g, u / g, and their rates times g are v_t - v g_t / g + c v_s. The guide
 * behind the port is straight, rigid and smooth: the rod leaves it clamped, as one in a sliding
 * sleeve does, on which the port acts with the configurational force of the energy that it gets
 * there (Bigoni, Dal Corso, Bosi, Misseroni, Mech. Mater. 80, 2015; of Kirchhoff rods in motion
 * Boyer, Lebastard, Candelier, Renda, J. Sound Vib. 516, 2022). No force on the rod depends on
 * that: g is driven. The residual of its mode is g_tt less what the drive makes of it. */
#include "physics/chain/modes_rows.h"

#include <math.h>
#include <string.h>

/* The mode's own column is by central differences: of the mode, whose residual is no polynomial, by
 * a step at which rounding and curvature are 1e-10; of its rates, of degree 2 and 1, exactly. */
static const double MODE_STEP = 1e-5, RATE_STEP = 1e-2, SECOND_STEP = 1;

/* ---- making -------------------------------------------------------------------------------- */

static const char *refused(const modes *m)
{
    const scene *given = &m->rod->scene;
    return !scene_rests_straight(given) ? "a rest shape that is not straight"
           : !scene_end_holds_rotation(given->start.type)
               ? "a start that does not hold the rotation"
           : given->spring_count > 0                                 ? "springs"
           : quantity_any_something(3, given->loads.foundation)      ? "a foundation"
           : quantity_is_something(given->loads.added_mass)          ? "added mass of a fluid"
           : quantity_any_something(3, given->loads.magnetic_moment) ? "a magnetised rod"
           : given->rod.law                                          ? "a law of the section"
           : m->branch.count > 0   ? "a Maxwell branch of the material"
           : m->end.directions > 0 ? "an end that is held"
           : m->rod->lengths > 0   ? "tendons of given displacement"
           : m->rod->frictions > 0 ? "friction of tendons"
           : quantity_any_something(3, given->initial.velocity) ||
                   quantity_any_something(3, given->initial.angular_velocity)
               ? "an initial velocity"
               : NULL;
}

ad_status modes_feed_create(modes *m, ad_error *error)
{
    const scene *given = &m->rod->scene;
    const char *why = refused(m);
    if (m->feed.mode < 0) {
        return AD_OK;
    }
    if (why) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "a rod that moves through its port does not take %s yet; allowed: a scene "
                       "without it",
                       why);
    }
    m->feed.to = given->feed.to / m->rod->scales.length;
    m->feed.lag = quantity_number_or(given->rod.feed_time, 0) / m->rod->scales.time;
    m->feed.unit = given->feed.to;
    return AD_OK;
}

/* ---- what it is given ------------------------------------------------------------------------ */

void modes_feed_give(modes *m, const double *q, const double *v, const double *a)
{
    struct modes_feed *feed = &m->feed;
    const int k = feed->mode;
    double inputs[SCENE_PARAMETERS_MAX];
    ad_error error;
    memcpy(feed->q, q, (size_t)m->size * sizeof *q);
    feed->second = a ? a[k] : 0;
    feed->now[0] = q[k];
    feed->now[1] = v[k];
    feed->now[2] = feed->second;
    if (feed->input < 0) { /* exactly, whatever steps of time make of the mode */
        memcpy(feed->now, feed->wanted, sizeof feed->now);
        return;
    }
    feed->out = feed->from + feed->unit * q[k];
    memcpy(inputs, m->input, (size_t)m->inputs * sizeof *inputs);
    inputs[feed->input] = feed->out;
    if (!(1 + q[k] > 0) || modes_give(m, m->time, inputs, &error) != AD_OK) {
        feed->now[0] = NAN; /* and so all that follows */
    }
}

double modes_feed_residual(const modes *m)
{
    const struct modes_feed *feed = &m->feed;
    const double wanted = (feed->command - feed->from) / feed->unit;
    return feed->input < 0 ? feed->second - feed->wanted[2]
                           : modes_drive_residual(feed->lag, feed->now, wanted);
}

/* ---- motion -------------------------------------------------------------------------------- */

static void carry_point(const struct modes_feed *feed, modes_point *at, const double *slope)
{
    const double growth = 1 + feed->now[0], rate = feed->now[1] / growth;
    const double c = (feed->to - at->s) * rate;
    const double c_t = (feed->to - at->s) * (feed->now[2] / growth - 2 * rate * rate);
    double turned[3], along[3], bent[3], moved[3];
    at->is_carried = true;
    at->carry = c;
    at->carry_rate = c_t;
    to_world(at->R, at->strain + MODES_U, at->curve);
    to_world(at->R, slope + MODES_V, at->along_slope);
    to_world(at->R, slope + MODES_U, at->curve_slope);
    vector_cross(at->spin, at->curve, turned);
    vector_cross(at->curve, at->along, along);
    for (int k = 0; k < 3; k++) {
        bent[k] = c * (2 * at->turned_rate[k] + turned[k]) + c_t * at->curve[k];
        moved[k] = 2 * c * (at->turning[k] + at->along_rate[k]) + c_t * at->along[k];
        at->own_spin[k] = at->spin[k] + c * at->curve[k];
        at->own_velocity[k] = at->velocity[k] + c * at->along[k];
        at->own_spin_rate[k] = at->spin_rate[k] + bent[k] + c * c * at->curve_slope[k];
        at->own_acceleration[k] =
            at->acceleration[k] + moved[k] + c * c * (along[k] + at->along_slope[k]);
    }
    for (int i = 0; i < MODES_STRAINS; i++) {
        at->own_rate[i] = at->rate[i] - rate * at->strain[i] + c * slope[i];
    }
}

void modes_feed_carry(modes *m, int e, const double *q)
{
    const modes_mode *mode = &m->mode[m->feed.mode];
    const modes_element *element = &m->element[e];
    if (e < mode->first_element || e > mode->last_element) {
        return;
    }
    for (int i = 0; i < m->stages; i++) {
        const int p = e * (m->stages + 1) + i;
        double slope[MODES_STRAINS] = {0};
        for (int k = element->own; k < element->end; k++) {
            slope[m->mode[k].strain] += m->feed.slope[p * m->width + k] * q[k];
        }
        carry_point(&m->feed, &m->point[p], slope);
    }
}

/* ---- the mode's own column ------------------------------------------------------------------- */

static void residual_at(modes *m, const double *q, const double *v, const double *a, double *to)
{
    modes_shape(m, q, v, a);
    modes_forces(m, false, to);
}

/* by [size rows of width]: its column, by steps of q, v or a, the `which` of these in x. */
static void difference(modes *m, double *const x[3], int which, double step, double *by)
{
    const int n = m->size, k = m->feed.mode;
    double *residual = m->feed.trial + 3 * n, was = x[which][k];
    for (int side = 0; side < 2; side++) {
        const double sign = side ? 1 : -1;
        x[which][k] = was + sign * step;
        residual_at(m, x[0], x[1], x[2], residual);
        for (int r = 0; r < n; r++) {
            double *to = &by[r * m->width + k];
            *to = (side ? *to : 0) + sign * residual[r] / (2 * step);
        }
    }
    x[which][k] = was;
}

void modes_feed_derivatives(modes *m, const double *q, const double *v, const double *a,
                            double *by_q, double *by_v)
{
    const int n = m->size, width = m->width, k = m->feed.mode;
    double *const x[3] = {m->feed.trial, m->feed.trial + n, m->feed.trial + 2 * n};
    double *const rows[3] = {by_q, by_v, m->mass};
    const double steps[3] = {MODE_STEP, RATE_STEP, SECOND_STEP};
    memcpy(x[0], q, (size_t)n * sizeof *q);
    memcpy(x[1], v, (size_t)n * sizeof *v);
    memset(x[2], 0, (size_t)n * sizeof *x[2]);
    if (a) {
        memcpy(x[2], a, (size_t)n * sizeof *a);
    }
    for (int i = 0; i < 3; i++) {
        difference(m, x, i, steps[i], rows[i]);
        for (int c = 0; c < n; c++) { /* the drive does not depend on the rod */
            rows[i][k * width + c] = c == k ? rows[i][k * width + k] : 0;
        }
    }
    residual_at(m, q, v, a, m->feed.trial + 3 * n); /* as it was */
}

/* ---- power --------------------------------------------------------------------------------- */

/* What the port does to the rod that leaves it, and the energy that comes with what is behind. */
double modes_feed_power(const modes *m)
{
    const int first = m->mode[m->feed.mode].first_element, n = m->stages;
    const double speed = m->feed.to * m->feed.now[1] / (1 + m->feed.now[0]);
    double R[3][3], q[4], strain[MODES_STRAINS], along[3], curve[3], values[GAUSS_STAGES_MAX];
    double velocity[3], spin[3], elastic = 0, stiffness[MODES_STRAINS] = {0};
    inertia section = {0};
    modes_point at = m->point[first * (n + 1)];
    memcpy(q, m->start.rotation, sizeof q);
    rotation_matrix(q, R);
    memcpy(strain, at.origin, sizeof strain);
    for (int k = m->element[first].own; k < m->element[first].end; k++) {
        const double value = m->mode[k].degree % 2 ? -1 : 1; /* where Legendre's begin */
        strain[m->mode[k].strain] += value * (k == m->feed.mode ? m->feed.now[0] : m->feed.q[k]);
    }
    gauss_lagrange(&m->rule, 0, values);
    memset(at.rest, 0, sizeof at.rest);
    for (int j = 0; j < n; j++) {
        const modes_point *x = &m->point[first * (n + 1) + j];
        section.mass += values[j] * x->inertia.mass / x->weight;
        for (int i = 0; i < 3; i++) {
            section.rotary[i] += values[j] * x->inertia.rotary[i] / x->weight;
        }
        for (int i = 0; i < MODES_STRAINS; i++) {
            stiffness[i] += values[j] * x->stiffness[i];
            at.rest[i] += values[j] * x->rest[i];
        }
    }
    to_world(R, strain + MODES_V, along);
    to_world(R, strain + MODES_U, curve);
    to_world(R, m->start.spin, spin);
    for (int k = 0; k < 3; k++) {
        velocity[k] = m->start.velocity[k] + speed * along[k];
        spin[k] += speed * curve[k];
    }
    for (int i = 0; i < MODES_STRAINS; i++) {
        strain[i] -= at.rest[i];
    }
    number_law_elastic_energy(strain, strain + MODES_U, stiffness, &elastic);
    const inertia_motion moving = {(const double(*)[3])R, velocity, spin, NULL, NULL};
    return speed * (inertia_energy(&section, moving) + elastic + vector_dot(m->base[0], along) +
                    vector_dot(m->base[1], curve));
}
