/* Changes of a reduced rod by each of its modes, side by side: stiffness and damping. */
#include "physics/chain/modes_rows.h"
#include "physics/law/law_numbers.h"

/* What x [stages + 1] and all `beyond` do at Gauss points, by the transposed matrix: to [stages].
 */
PROCESSOR_INLINE void gather_rows(const modes *m, int e, int length, const double *x, int stride,
                                  const double *beyond, double *to)
{
    const modes_element *element = &m->element[e];
    const int n = m->stages;
    for (int c = 0; c < length; c += QUAD) {
        quad at[GAUSS_STAGES_MAX + 1], more;
        for (int i = 0; i <= n; i++) {
            memcpy(&at[i], x + i * stride + c, sizeof at[i]);
        }
        memcpy(&more, beyond + c, sizeof more);
        at[n] += more;
        for (int j = 0; j < n; j++) {
            quad sum = element->matrix[n][j] * at[n];
            for (int i = 0; i < n; i++) {
                sum += element->matrix[i][j] * at[i];
            }
            memcpy(to + j * length + c, &sum, sizeof sum);
        }
    }
}

/* beyond += x [stages + 1] */
PROCESSOR_INLINE void add_beyond(const modes *m, int length, const double *x, int stride,
                                 double *beyond)
{
    for (int i = 0; i <= m->stages; i++) {
        for (int c = 0; c < length; c++) {
            beyond[c] += x[i * stride + c];
        }
    }
}

/* ---- derivatives of motion ----------------------------------------------------------------- */

/* Of an element, rows: by q and then by q_t where there are six. */
typedef struct changes {
    double *own;          /* [stages][6] */
    double *rate;         /* [stages][6] */
    double *spin;         /* [stages + 1][3] by q; by q_t it is theta */
    double *velocity;     /* [stages + 1][3] by q; by q_t it is rho */
    double *spin_rate;    /* [stages + 1][6] */
    double *acceleration; /* [stages + 1][6] */
    double *edge;         /* [18] of the element before: spin, velocity, spin_rate, acceleration */
    double *point;        /* [points][MODES_ROWS]: force, moment */
} changes;

static changes changes_of(modes *m)
{
    const int width = m->width, n = m->stages + 1;
    changes x;
    x.point = m->room;
    x.own = x.point + m->points * MODES_ROWS * width;
    x.rate = x.own + n * 6 * width;
    x.spin = x.rate + n * 6 * width;
    x.velocity = x.spin + n * 3 * width;
    x.spin_rate = x.velocity + n * 3 * width;
    x.acceleration = x.spin_rate + n * 6 * width;
    x.edge = x.acceleration + n * 6 * width;
    return x;
}

_Static_assert((GAUSS_STAGES_MAX + 1) * 36 + 18 <= MODES_ROOM, "changes have room");

/* Changes of w, then of its rate and of V, then of the acceleration. */
PROCESSOR_INLINE void change_motion(modes *m, int e, changes *changes)
{
    const int n = m->stages, width = m->width, used = m->element[e].width, first = e * (n + 1);
    for (int i = 0; i < n; i++) {
        const modes_point *at = &m->point[first + i];
        own_rows(m, e, first + i, width, changes->own + i * 6 * width);
        for (int c = 0; c < used; c += QUAD) {
            quad theta[3], to[3] = {{0}};
            load_rows(m->theta + (first + i) * 3 * width + c, width, theta);
            add_crossed(theta, at->turned_rate, to);
            store_rows(to, width, changes->rate + i * 6 * width + c);
        }
    }
    for (int k = 0; k < 3; k++) {
        integrate_rows(m, e, used, changes->edge + k * width, changes->rate + k * width, 6 * width,
                       changes->spin + k * width, 3 * width);
    }
    for (int i = 0; i < n; i++) {
        const modes_point *at = &m->point[first + i];
        for (int c = 0; c < used; c += QUAD) {
            quad theta[3], spin[3], by_u[3], inner[3] = {{0}}, by_q[3] = {{0}}, by_v[3] = {{0}};
            load_rows(m->theta + (first + i) * 3 * width + c, width, theta);
            load_rows(changes->spin + i * 3 * width + c, width, spin);
            load_rows(changes->own + (i * 6 + 3) * width + c, width, by_u);
            add_crossed(theta, at->turned_rate, inner);
            add_crossed(spin, at->turned_rate, by_q);
            add_cross(at->spin, inner, by_q);
            add_crossed(theta, at->turned_second, by_q);
            add_scaled(1, inner, by_v);
            add_cross(at->spin, by_u, by_v);
            store_rows(by_q, width, changes->rate + i * 6 * width + c);
            store_rows(by_v, width, changes->rate + (i * 6 + 3) * width + c);
        }
    }
    for (int k = 0; k < 6; k++) {
        integrate_rows(m, e, used, changes->edge + (6 + k) * width, changes->rate + k * width,
                       6 * width, changes->spin_rate + k * width, 6 * width);
    }
    const bool velocity = m->rod->along.by_velocity || m->inertia_couples || m->end.count > 0;
    for (int i = 0; i < n && velocity; i++) {
        const modes_point *at = &m->point[first + i];
        for (int c = 0; c < used; c += QUAD) {
            quad theta[3], spin[3], along[3], to[3] = {{0}};
            load_rows(m->theta + (first + i) * 3 * width + c, width, theta);
            load_rows(changes->spin + i * 3 * width + c, width, spin);
            load_rows(changes->own + i * 6 * width + c, width, along);
            add_crossed(theta, at->along, along);
            add_crossed(spin, at->along, to);
            add_cross(at->spin, along, to);
            add_crossed(theta, at->along_rate, to);
            store_rows(to, width, changes->rate + i * 6 * width + c);
        }
    }
    for (int k = 0; k < 3 && velocity; k++) {
        integrate_rows(m, e, used, changes->edge + (3 + k) * width, changes->rate + k * width,
                       6 * width, changes->velocity + k * width, 3 * width);
    }
    for (int i = 0; i < n; i++) {
        const modes_point *at = &m->point[first + i];
        double moving[3];
        for (int k = 0; k < 3; k++) {
            moving[k] = at->turning[k] + 2 * at->along_rate[k];
        }
        for (int c = 0; c < used; c += QUAD) {
            quad theta[3], spin[3], second[2][3], own[3], along[3];
            quad inner[2][3] = {{{0}}}, to[2][3] = {{{0}}};
            load_rows(m->theta + (first + i) * 3 * width + c, width, theta);
            load_rows(changes->spin + i * 3 * width + c, width, spin);
            load_rows(changes->spin_rate + i * 6 * width + c, width, second[0]);
            load_rows(changes->spin_rate + (i * 6 + 3) * width + c, width, second[1]);
            load_rows(changes->own + i * 6 * width + c, width, own);
            memcpy(along, own, sizeof along);
            add_crossed(theta, at->along, along);
            /* by q: (DA x p) + (a x P) + (DW x moving) + w x (DW x p + w x P + 2 theta x p_t)
             * + theta x p_tt, with P the change of p = R v */
            add_crossed(spin, at->along, inner[0]);
            add_cross(at->spin, along, inner[0]);
            add_crossed(theta, at->along_rate, inner[0]);
            add_crossed(theta, at->along_rate, inner[0]);
            add_crossed(second[0], at->along, to[0]);
            add_cross(at->spin_rate, along, to[0]);
            add_crossed(spin, moving, to[0]);
            add_cross(at->spin, inner[0], to[0]);
            add_crossed(theta, at->along_second, to[0]);
            /* by q_t */
            add_crossed(theta, at->along, inner[1]);
            add_scaled(2, own, inner[1]);
            add_crossed(second[1], at->along, to[1]);
            add_crossed(theta, moving, to[1]);
            add_cross(at->spin, inner[1], to[1]);
            store_rows(to[0], width, changes->rate + i * 6 * width + c);
            store_rows(to[1], width, changes->rate + (i * 6 + 3) * width + c);
        }
    }
    for (int k = 0; k < 6; k++) {
        integrate_rows(m, e, used, changes->edge + (12 + k) * width, changes->rate + k * width,
                       6 * width, changes->acceleration + k * width, 6 * width);
    }
    memcpy(changes->edge, changes->spin + n * 3 * width, (size_t)(3 * width) * sizeof(double));
    memcpy(changes->edge + 3 * width, changes->velocity + n * 3 * width,
           (size_t)(3 * width) * sizeof(double));
    memcpy(changes->edge + 6 * width, changes->spin_rate + n * 6 * width,
           (size_t)(6 * width) * sizeof(double));
    memcpy(changes->edge + 12 * width, changes->acceleration + n * 6 * width,
           (size_t)(6 * width) * sizeof(double));
}

/* ---- of a rod that is fed ------------------------------------------------------------------- */

/* Four columns of a point, at a held mode of the feed: what is there by what is at its s. */
typedef struct carried {
    quad theta[3], spin[3], along[3], curve[3]; /* along, curve: of R v and R u */
    quad own[2][3], slope[2][3];                /* R e P and R e P_s of v and of u */
} carried;

/* Of c (2 R u_t + w x k) + s_tt k + c^2 R u_s: by q, and by q_t. */
PROCESSOR_INLINE void turn_carried(const modes_point *at, const carried *x, quad to[2][3])
{
    quad once[3] = {{0}}, twice[3] = {{0}}, by_rate[3] = {{0}};
    add_crossed(x->theta, at->turned_rate, once);
    add_crossed(x->theta, at->turned_rate, once);
    add_crossed(x->spin, at->curve, once);
    add_cross(at->spin, x->curve, once);
    add_scaled(at->carry, once, to[0]);
    add_scaled(at->carry_rate, x->curve, to[0]);
    add_crossed(x->theta, at->curve_slope, twice);
    add_scaled(1, x->slope[1], twice);
    add_scaled(at->carry * at->carry, twice, to[0]);
    add_scaled(2, x->own[1], by_rate);
    add_crossed(x->theta, at->curve, by_rate);
    add_scaled(at->carry, by_rate, to[1]);
}

/* Of 2 c (w x p + R v_t) + s_tt p + c^2 (k x p + R v_s). */
PROCESSOR_INLINE void push_carried(const modes_point *at, const carried *x, quad to[2][3])
{
    quad once[3] = {{0}}, twice[3] = {{0}}, by_rate[3] = {{0}};
    add_crossed(x->spin, at->along, once);
    add_cross(at->spin, x->along, once);
    add_crossed(x->theta, at->along_rate, once);
    add_scaled(2 * at->carry, once, to[0]);
    add_scaled(at->carry_rate, x->along, to[0]);
    add_crossed(x->curve, at->along, twice);
    add_cross(at->curve, x->along, twice);
    add_crossed(x->theta, at->along_slope, twice);
    add_scaled(1, x->slope[0], twice);
    add_scaled(at->carry * at->carry, twice, to[0]);
    add_scaled(1, x->own[0], by_rate);
    add_crossed(x->theta, at->along, by_rate);
    add_scaled(2 * at->carry, by_rate, to[1]);
}

/* Of what is at the points of an element, in place of what is at their s (modes_feed.c). */
PROCESSOR_INLINE void change_carried(modes *m, int e, changes *changes)
{
    const int n = m->stages, width = m->width, first = e * (n + 1);
    double *slopes = changes->rate;
    for (int i = 0; i < n && m->point[first].is_carried; i++) {
        const modes_point *at = &m->point[first + i];
        slope_rows(m, e, first + i, width, slopes);
        for (int c = 0; c < m->element[e].width; c += QUAD) {
            carried x;
            quad spin[3], velocity[3], second[2][3], push[2][3];
            load_rows(m->theta + (first + i) * 3 * width + c, width, x.theta);
            load_rows(changes->spin + i * 3 * width + c, width, x.spin);
            load_rows(changes->velocity + i * 3 * width + c, width, velocity);
            for (int k = 0; k < 2; k++) {
                load_rows(changes->own + (i * 6 + 3 * k) * width + c, width, x.own[k]);
                load_rows(slopes + 3 * k * width + c, width, x.slope[k]);
                load_rows(changes->spin_rate + (i * 6 + 3 * k) * width + c, width, second[k]);
                load_rows(changes->acceleration + (i * 6 + 3 * k) * width + c, width, push[k]);
            }
            memcpy(x.along, x.own[0], sizeof x.along);
            memcpy(x.curve, x.own[1], sizeof x.curve);
            memcpy(spin, x.spin, sizeof spin);
            add_crossed(x.theta, at->along, x.along);
            add_crossed(x.theta, at->curve, x.curve);
            add_scaled(at->carry, x.curve, spin);
            add_scaled(at->carry, x.along, velocity);
            turn_carried(at, &x, second);
            push_carried(at, &x, push);
            store_rows(spin, width, changes->spin + i * 3 * width + c);
            store_rows(velocity, width, changes->velocity + i * 3 * width + c);
            for (int k = 0; k < 2; k++) {
                store_rows(second[k], width, changes->spin_rate + (i * 6 + 3 * k) * width + c);
                store_rows(push[k], width, changes->acceleration + (i * 6 + 3 * k) * width + c);
            }
        }
    }
}

/* ---- derivatives of forces at points ------------------------------------------------------- */

/* What a point needs of itself: what resists its motion, and what acts. */
typedef struct local {
    inertia_change inertia;
    const acting *of; /* NULL: nothing */
    acting_change acting;
} local;

/* Along the rod, or at the place that the point is. */
static void find_acting(const modes *m, int p, local *local)
{
    const solve_jumps *jumps = &m->rod->jumps;
    const modes_point *at = &m->point[p];
    const bool along = at->weight > 0 && m->rod->along.count > 0;
    const double *numbers = m->along + p * m->rod->along.numbers;
    local->of = along ? &m->rod->along : NULL;
    for (int k = 0; k < jumps->count && at->weight == 0 && jumps->numbers > 0; k++) {
        if (m->jump_at[k] == p) {
            local->of = &jumps->at[k].acting;
            numbers = solve_jump_numbers(jumps, jumps->number, k);
        }
    }
    if (local->of &&
        !(local->of->by_position || local->of->by_rotation || local->of->by_velocity)) {
        local->of = NULL;
    }
    if (local->of) {
        acting_differentiate(local->of, numbers,
                             (acting_on){at->r, at->q, modes_section(at).velocity},
                             along ? at->weight : 1, &local->acting);
    }
}

/* What force and moment of laws change with the change x of what they depend on. */
PROCESSOR_INLINE void add_changed(const acting *of, double by[6][3], const quad x[3], quad force[3],
                                  quad moment[3])
{
    add_applied(by, 1, x, force);
    if (of->has_moment) {
        add_applied(by + 3, 1, x, moment);
    }
}

static void find_local(const modes *m, int p, local *local)
{
    const modes_point *at = &m->point[p];
    inertia_differentiate(&at->inertia, modes_section(at), &local->inertia);
    find_acting(m, p, local);
}

/* What resists the motion changes by the turn, the spin and its rate: rows of the force from 0 on,
 * of the moment from 3 on; to those by q and by q_t. */
PROCESSOR_INLINE void add_resistance(const inertia_change *by, int row, const quad theta[3],
                                     const quad spin[3], quad spin_rate[2][3], quad to[2][3])
{
    for (int i = 0; i < 3; i++) {
        const double *turn = by->by_turn[row + i], *own = by->by_spin[row + i];
        const double *rate = by->by_spin_rate[row + i];
        quad by_q = to[0][i], by_v = to[1][i];
        for (int k = 0; k < 3; k++) {
            by_q += turn[k] * theta[k] + own[k] * spin[k] + rate[k] * spin_rate[0][k];
            by_v += own[k] * theta[k] + rate[k] * spin_rate[1][k];
        }
        to[0][i] = by_q;
        to[1][i] = by_v;
    }
}

/* What inertia that couples adds to the rows `to` of point p, the i-th of its element: to the force
 * all that it changes by, to the moment what is by velocity and acceleration. A function of its
 * own: without a fluid and bodies beside the axis the loops around it are then as fast as if it
 * were not there. */
FOR_EACH_PROCESSOR static void add_coupled(const modes *m, const changes *changes,
                                           inertia_change *by, int i, int used, int p, double *to)
{
    const int width = m->width;
    for (int c = 0; c < used; c += QUAD) {
        quad theta[3], spin[3], velocity[2][3], spin_rate[2][3], acceleration[2][3];
        quad wrench[2][2][3]; /* force, moment; by q, by q_t */
        load_rows(m->theta + p * 3 * width + c, width, theta);
        load_rows(m->rho + p * 3 * width + c, width, velocity[1]);
        load_rows(changes->spin + i * 3 * width + c, width, spin);
        load_rows(changes->velocity + i * 3 * width + c, width, velocity[0]);
        for (int k = 0; k < 2; k++) {
            load_rows(changes->spin_rate + (i * 6 + 3 * k) * width + c, width, spin_rate[k]);
            load_rows(changes->acceleration + (i * 6 + 3 * k) * width + c, width, acceleration[k]);
            load_rows(to + 3 * k * width + c, width, wrench[0][k]);
            load_rows(to + (6 + 3 * k) * width + c, width, wrench[1][k]);
        }
        add_resistance(by, 0, theta, spin, spin_rate, wrench[0]);
        for (int k = 0; k < 2; k++) {
            for (int row = 0; row < 2; row++) {
                add_applied(by->by_velocity + 3 * row, 1, velocity[k], wrench[row][k]);
                add_applied(by->by_acceleration + 3 * row, 1, acceleration[k], wrench[row][k]);
            }
            store_rows(wrench[0][k], width, to + 3 * k * width + c);
            store_rows(wrench[1][k], width, to + (6 + 3 * k) * width + c);
        }
    }
}

PROCESSOR_INLINE void change_forces(modes *m, int e, changes *changes)
{
    const int n = m->stages, width = m->width, used = m->element[e].width, first = e * (n + 1);
    for (int i = 0; i <= n; i++) {
        const int p = first + i;
        const modes_point *at = &m->point[p];
        double *to = changes->point + p * MODES_ROWS * width;
        local own;
        if (used < width) {
            memset(to, 0, (size_t)(MODES_ROWS * width) * sizeof *to);
        }
        find_local(m, p, &own);
        for (int c = 0; c < used; c += QUAD) {
            quad theta[3], rho[3], spin[3], velocity[3], second[2][3], acceleration[2][3];
            quad force[2][3] = {{{0}}}, moment[2][3] = {{{0}}};
            load_rows(m->theta + p * 3 * width + c, width, theta);
            load_rows(m->rho + p * 3 * width + c, width, rho);
            load_rows(changes->spin + i * 3 * width + c, width, spin);
            for (int k = 0; k < 2; k++) {
                load_rows(changes->spin_rate + (i * 6 + 3 * k) * width + c, width, second[k]);
                load_rows(changes->acceleration + (i * 6 + 3 * k) * width + c, width,
                          acceleration[k]);
                add_scaled(-at->inertia.mass, acceleration[k], force[k]);
            }
            if (own.of && own.of->by_position) {
                add_changed(own.of, own.acting.by_position, rho, force[0], moment[0]);
            }
            if (own.of && own.of->by_rotation) {
                add_changed(own.of, own.acting.by_turn, theta, force[0], moment[0]);
            }
            if (own.of && own.of->by_velocity) {
                load_rows(changes->velocity + i * 3 * width + c, width, velocity);
                add_changed(own.of, own.acting.by_velocity, velocity, force[0], moment[0]);
                add_changed(own.of, own.acting.by_velocity, rho, force[1], moment[1]);
            }
            add_resistance(&own.inertia, 3, theta, spin, second, moment);
            for (int k = 0; k < 2; k++) {
                store_rows(force[k], width, to + 3 * k * width + c);
                store_rows(moment[k], width, to + (6 + 3 * k) * width + c);
            }
        }
        if (inertia_couples(&at->inertia)) {
            add_coupled(m, changes, &own.inertia, i, used, p, to);
        }
    }
}

/* ---- back from the tip --------------------------------------------------------------------- */

/* What the stress at a point changes by, by the strain and by its rate (law_entry). */
PROCESSOR_INLINE void differentiate_stress(const modes *m, int p, double by[2][LAW_STIFFNESS])
{
    const modes_point *at = &m->point[p];
    double off[MODES_STRAINS], stress[MODES_STRAINS] = {0};
    strain_beyond_rest(at, off);
    memset(by, 0, 2 * sizeof *by);
    if (m->is_pulled || m->rod->scene.rod.law) {
        memcpy(by[0], m->pull_by[p], sizeof by[0]);
    }
    number_law_elastic(off, off + MODES_U, at->stiffness, stress, by[0]);
    const double *rate = modes_strain_rate(at);
    number_law_damping(rate, rate + MODES_U, at->damping, stress, by[1]);
}

/* Rows [6][width] of a point: R^T (changed - theta x carried), by q and by q_t. */
PROCESSOR_INLINE void to_section(const modes *m, int p, const double carried[3], const double *rows,
                                 double *to)
{
    const modes_point *at = &m->point[p];
    const int width = m->width;
    for (int c = 0; c < width; c += QUAD) {
        quad theta[3], change[2][3], body[3];
        load_rows(m->theta + p * 3 * width + c, width, theta);
        load_rows(rows + c, width, change[0]);
        load_rows(rows + 3 * width + c, width, change[1]);
        add_cross(carried, theta, change[0]);
        for (int k = 0; k < 2; k++) {
            for (int i = 0; i < 3; i++) {
                body[i] = at->R[0][i] * change[k][0] + at->R[1][i] * change[k][1] +
                          at->R[2][i] * change[k][2];
            }
            store_rows(body, width, to + 3 * k * width + c);
        }
    }
}

/* Rows [12][width] of a point, by q and by q_t of force and of moment: what the stress changes by
 * with the element's own modes, subtracted. */
PROCESSOR_INLINE void subtract_stress(const modes *m, int e, int p, double *to)
{
    const modes_element *element = &m->element[e];
    const double *value = m->value + p * m->width, weight = m->point[p].weight;
    const double *slope = m->feed.slope + p * m->width, carried = m->point[p].carry;
    const bool fed = m->point[p].is_carried;
    const double grown = fed ? m->feed.now[1] / (1 + m->feed.now[0]) : 0;
    double by[2][LAW_STIFFNESS];
    differentiate_stress(m, p, by);
    for (int a = element->own; a < element->end; a++) {
        const int own = m->mode[a].strain;
        for (int c = m->is_coupled ? 0 : own; c < (m->is_coupled ? MODES_STRAINS : own + 1); c++) {
            double *row = to + (c / 3 * 6 + c % 3) * m->width + a;
            row[0] -= weight * (value[a] * by[0][law_entry(c, own)] +
                                (fed ? carried * slope[a] - grown * value[a] : 0) *
                                    by[1][law_entry(c, own)]);
            row[3 * m->width] -= weight * value[a] * by[1][law_entry(c, own)];
        }
    }
}

/* forces, moments [stages][6]: what modes_point.carried changes by; sections: room [12]. */
PROCESSOR_INLINE void collect_rows(modes *m, int e, const double *forces, const double *moments,
                                   double *sections, double *by_q, double *by_v)
{
    const int n = m->stages, width = m->width;
    const modes_element *element = &m->element[e];
    for (int i = 0; i < n; i++) {
        const int p = e * (n + 1) + i;
        const modes_point *at = &m->point[p];
        to_section(m, p, at->carried[0], forces + i * 6 * width, sections);
        to_section(m, p, at->carried[1], moments + i * 6 * width, sections + 6 * width);
        subtract_stress(m, e, p, sections);
        for (int b = element->own; b < element->end; b++) {
            const int c = m->mode[b].strain;
            const double *row = sections + (c / 3 * 6 + c % 3) * width;
            const double value = m->value[p * width + b];
            for (int a = 0; a < width; a += QUAD) {
                quad q, v, change[2];
                memcpy(&q, by_q + b * width + a, sizeof q);
                memcpy(&v, by_v + b * width + a, sizeof v);
                memcpy(&change[0], row + a, sizeof change[0]);
                memcpy(&change[1], row + 3 * width + a, sizeof change[1]);
                q -= value * change[0];
                v -= value * change[1];
                memcpy(by_q + b * width + a, &q, sizeof q);
                memcpy(by_v + b * width + a, &v, sizeof v);
            }
        }
    }
}

/* Moments of the forces beyond, at Gauss points: along x force. */
PROCESSOR_INLINE void add_arms(modes *m, int e, changes *changes, const double *forces)
{
    const int n = m->stages, width = m->width;
    for (int i = 0; i < n; i++) {
        const int p = e * (n + 1) + i;
        const modes_point *at = &m->point[p];
        double *to = changes->point + (p * MODES_ROWS + 6) * width;
        own_rows(m, e, p, width, changes->own);
        for (int c = 0; c < width; c += QUAD) {
            quad theta[3], along[3], force[2][3], moment[2][3];
            load_rows(m->theta + p * 3 * width + c, width, theta);
            load_rows(changes->own + c, width, along);
            add_crossed(theta, at->along, along);
            for (int k = 0; k < 2; k++) {
                load_rows(forces + (i * 6 + 3 * k) * width + c, width, force[k]);
                load_rows(to + 3 * k * width + c, width, moment[k]);
                add_cross(at->along, force[k], moment[k]);
            }
            add_crossed(along, at->carried[0], moment[0]);
            store_rows(moment[0], width, to + c);
            store_rows(moment[1], width, to + 3 * width + c);
        }
    }
}

FOR_EACH_PROCESSOR static void find_derivatives(modes *m, double *by_q, double *by_v)
{
    const int width = m->width, n = m->stages;
    changes x = changes_of(m); /* columns that an element does not use stay 0 */
    memset(x.spin, 0, (size_t)(x.edge + 18 * width - x.spin) * sizeof *x.spin);
    memset(by_q, 0, (size_t)(m->size * width) * sizeof *by_q);
    memset(by_v, 0, (size_t)(m->size * width) * sizeof *by_v);
    for (int e = 0; e < m->elements; e++) {
        change_motion(m, e, &x);
        if (m->feed.mode >= 0) {
            change_carried(m, e, &x);
        }
        change_forces(m, e, &x);
    }
    if (m->end.count > 0) {
        modes_end_keep(m, x.edge, x.edge + 3 * width);
    }
    double *forces = x.rate, *moments = x.spin_rate, *beyond = x.edge, *sections = x.spin;
    memset(beyond, 0, (size_t)(12 * width) * sizeof *beyond);
    for (int e = m->elements - 1; e >= 0; e--) {
        const double *here = x.point + e * (n + 1) * MODES_ROWS * width;
        gather_rows(m, e, 6 * width, here, MODES_ROWS * width, beyond, forces);
        add_beyond(m, 6 * width, here, MODES_ROWS * width, beyond);
        add_arms(m, e, &x, forces);
        gather_rows(m, e, 6 * width, here + 6 * width, MODES_ROWS * width, beyond + 6 * width,
                    moments);
        add_beyond(m, 6 * width, here + 6 * width, MODES_ROWS * width, beyond + 6 * width);
        collect_rows(m, e, forces, moments, sections, by_q, by_v);
    }
    for (int i = 0; i < m->rod->actuators; i++) { /* longer tendons pull more */
        const double *longer = m->longer + i * width;
        for (int b = 0; b < m->size && m->tight[i] > 0 && !m->rod->extents[i].rubs; b++) {
            for (int a = 0; a < m->size; a++) {
                by_q[b * width + a] += m->tight[i] * longer[b] * longer[a];
            }
        }
    }
}

void modes_derivatives(modes *m, double *by_q, double *by_v)
{
    find_derivatives(m, by_q, by_v);
    modes_friction_derivatives(m, by_q, by_v);
}

void modes_linearise(modes *m, const double *q, const double *v, const double *a, double *residual,
                     double *by_q, double *by_v)
{
    modes_shape(m, q, v, a);
    modes_forces(m, true, residual);
    modes_mass(m);
    modes_derivatives(m, by_q, by_v);
    if (m->branch.count > 0) {
        modes_branch_derivatives(m);
    }
    if (m->end.count > 0) {
        modes_end_derivatives(m, by_q, by_v);
    }
    if (m->feed.mode >= 0) {
        modes_feed_derivatives(m, q, v, a, by_q, by_v);
    }
    if (m->turn.mode >= 0) {
        modes_turn_derivatives(m, by_q, by_v);
    }
}
