#include "physics/chain/kinematics.h"
#include "physics/local/magnus.h"

#include <stdbool.h>

/* LANES states side by side. */
typedef struct kinematics_point {
    lanes q[4], R[3][3];
    lanes spin[3];                                 /* world */
    lanes along[3], along_rate[3], turned_rate[3]; /* R v, R v_t, R u_t */
} kinematics_point;

/* Before an element, behind the joint there. */
typedef struct kinematics_edge {
    lanes q[4], r[3], velocity[3], spin[3];
} kinematics_edge;

/* [row][mode] of one place: derivatives by the modes of position, turn, velocity, angular velocity
 * in the world; what rates do is among them. */
enum { BY_POSITION, BY_TURN, BY_VELOCITY, BY_SPIN, KINEMATICS_KINDS };

typedef struct kinematics_work {
    lanes *state; /* [2 modes] */
    lanes *by;    /* [KINEMATICS_KINDS][modes][3] */
    kinematics_edge *edge;
    kinematics_point *point;
} kinematics_work;

size_t kinematics_room(const kinematics *kinematics)
{
    const size_t lanes_count = (size_t)kinematics->modes * (2 + 3 * KINEMATICS_KINDS);
    return (lanes_count * sizeof(lanes) + (size_t)kinematics->elements * sizeof(kinematics_edge) +
            (size_t)(kinematics->elements * kinematics->stages) * sizeof(kinematics_point)) /
           sizeof(double);
}

static kinematics_work divide_room(const kinematics *kinematics, double *room)
{
    kinematics_work w;
    w.state = (lanes *)(void *)room;
    w.by = w.state + 2 * kinematics->modes;
    w.edge = (kinematics_edge *)(void *)(w.by + 3 * KINEMATICS_KINDS * kinematics->modes);
    w.point = (kinematics_point *)(void *)(w.edge + kinematics->elements);
    return w;
}

/* to += by a */
PROCESSOR_INLINE void add_multiple(double by, const lanes a[3], lanes to[3])
{
    for (int k = 0; k < 3; k++) {
        to[k] += by * a[k];
    }
}

/* ---- from the start to the last element ------------------------------------------------------ */

/* Turns q by one step with terms [3][3], by the curvature's modes of an element by [modes][3]. */
PROCESSOR_CALLED void take_step(const kinematics *kinematics, int e, const double *base,
                                const double *by, const lanes *state, lanes q[4])
{
    lanes terms[3][3];
    for (int k = 0; k < 3; k++) {
        for (int c = 0; c < 3; c++) {
            terms[k][c] = NO_LANES + base[3 * k + c];
        }
    }
    for (int a = kinematics->own[e]; a < kinematics->own_end[e]; a++) {
        const int c = kinematics->strain[a] - 3;
        for (int k = 0; k < 3 && c >= 0; k++) {
            terms[k][c] += by[3 * a + k] * state[a];
        }
    }
    step_on(terms, q);
}

PROCESSOR_CALLED void turn_points(const kinematics *kinematics, int e, const lanes *state,
                                  const lanes from[4], kinematics_point *at)
{
    const int n = kinematics->stages;
    lanes q[4];
    memcpy(q, from, sizeof q);
    for (int i = 0; i < n; i++) {
        const int step = e * (n + 1) + i;
        take_step(kinematics, e, kinematics->step + 9 * step,
                  kinematics->step_by + 3 * kinematics->modes * step, state, q);
        memcpy(at[i].q, q, sizeof q);
        lanes_rotation_matrix(q, at[i].R);
    }
}

/* R v, R v_t, R u_t at the points of an element. */
PROCESSOR_INLINE void strain_points(const kinematics *kinematics, int e, const lanes *state,
                                    kinematics_point *at)
{
    for (int i = 0; i < kinematics->stages; i++) {
        const double *origin =
            kinematics->origin + (e * kinematics->stages + i) * KINEMATICS_STRAINS;
        const double *value = kinematics->value + (e * kinematics->stages + i) * kinematics->modes;
        lanes v[3], rate[KINEMATICS_STRAINS];
        memset(rate, 0, sizeof rate);
        for (int k = 0; k < 3; k++) {
            v[k] = NO_LANES + origin[k];
        }
        for (int a = kinematics->own[e]; a < kinematics->own_end[e]; a++) {
            const int c = kinematics->strain[a];
            rate[c] += value[a] * state[kinematics->modes + a];
            if (c < 3) {
                v[c] += value[a] * state[a];
            }
        }
        lanes_to_world(at[i].R, v, at[i].along);
        lanes_to_world(at[i].R, rate, at[i].along_rate);
        lanes_to_world(at[i].R, rate + 3, at[i].turned_rate);
    }
}

/* w' = R u_t */
PROCESSOR_INLINE void spin_points(const kinematics *kinematics, int e, const lanes from[3],
                                  kinematics_point *at)
{
    const int n = kinematics->stages;
    const double *integral = kinematics->integral + e * (n + 1) * n;
    for (int i = 0; i < n; i++) {
        memcpy(at[i].spin, from, sizeof at[i].spin);
        for (int j = 0; j < n; j++) {
            add_multiple(integral[i * n + j], at[j].turned_rate, at[i].spin);
        }
    }
}

/* r' = R v, V' = w x R v + R v_t, w' = R u_t over a part of an element, by integrals [stages]. */
PROCESSOR_INLINE void move_on(int n, const double *integral, const kinematics_point *at, lanes r[3],
                              lanes velocity[3], lanes spin[3])
{
    for (int j = 0; j < n; j++) {
        lanes turning[3];
        lanes_vector_cross(at[j].spin, at[j].along, turning);
        add_multiple(1, at[j].along_rate, turning);
        add_multiple(integral[j], at[j].along, r);
        add_multiple(integral[j], turning, velocity);
        add_multiple(integral[j], at[j].turned_rate, spin);
    }
}

PROCESSOR_INLINE void begin_rod(const kinematics *kinematics, kinematics_edge *edge)
{
    lanes R[3][3], spin[3];
    in_all_lanes(3, kinematics->start, edge->r);
    in_all_lanes(4, kinematics->start + 3, edge->q);
    in_all_lanes(3, kinematics->start + 7, edge->velocity);
    in_all_lanes(3, kinematics->start + 10, spin);
    lanes_rotation_matrix(edge->q, R);
    lanes_to_world(R, spin, edge->spin);
}

PROCESSOR_CALLED void find_shape(const kinematics *kinematics, const kinematics_work *w)
{
    const int n = kinematics->stages;
    begin_rod(kinematics, w->edge);
    for (int e = 0; e < kinematics->elements; e++) {
        const kinematics_edge *from = &w->edge[e];
        kinematics_point *at = w->point + e * n;
        turn_points(kinematics, e, w->state, from->q, at);
        strain_points(kinematics, e, w->state, at);
        spin_points(kinematics, e, from->spin, at);
        if (e + 1 < kinematics->elements) {
            const int step = e * (n + 1) + n;
            kinematics_edge *to = &w->edge[e + 1];
            lanes q[4], joint[4];
            *to = *from;
            memcpy(q, at[n - 1].q, sizeof q);
            take_step(kinematics, e, kinematics->step + 9 * step,
                      kinematics->step_by + 3 * kinematics->modes * step, w->state, q);
            normalise(q);
            in_all_lanes(4, kinematics->joint + 4 * e, joint);
            lanes_quaternion_product(q, joint, to->q);
            move_on(n, kinematics->integral + step * n, at, to->r, to->velocity, to->spin);
        }
    }
}

/* ---- places ---------------------------------------------------------------------------------- */

PROCESSOR_CALLED void find_place(const kinematics *kinematics, const kinematics_work *w, int place,
                                 lanes seen[KINEMATICS_SEEN], lanes R[3][3], lanes spin[3])
{
    const int e = kinematics->place_element[place], before = kinematics->place_before[place];
    const kinematics_edge *from = &w->edge[e];
    const kinematics_point *at = w->point + e * kinematics->stages;
    lanes *q = seen + 3, *strain = seen + 13;
    memcpy(seen, from->r, sizeof from->r);
    memcpy(q, before >= 0 ? at[before].q : from->q, sizeof from->q);
    memcpy(seen + 7, from->velocity, sizeof from->velocity);
    memcpy(spin, from->spin, sizeof from->spin);
    take_step(kinematics, e, kinematics->place_step + 9 * place,
              kinematics->place_step_by + 3 * kinematics->modes * place, w->state, q);
    normalise(q);
    lanes_rotation_matrix(q, R);
    move_on(kinematics->stages, kinematics->place_integral + place * kinematics->stages, at, seen,
            seen + 7, spin);
    lanes_to_body(R, spin, seen + 10);
    in_all_lanes(KINEMATICS_STRAINS, kinematics->place_origin + KINEMATICS_STRAINS * place, strain);
    for (int a = kinematics->own[e]; a < kinematics->own_end[e]; a++) {
        strain[kinematics->strain[a]] +=
            kinematics->place_value[place * kinematics->modes + a] * w->state[a];
    }
}

/* What lies between an element and a place: integrals of R v and R u_t, and of M, by which a turn
 * that all of it makes changes the velocity. */
typedef struct kinematics_beyond {
    lanes along[3], turned[3], M[3][3];
} kinematics_beyond;

/* Of a turn theta at each point of an element alone: the velocity of the place changes by
 * (theta x R u_t) x arm + weight (w x (theta x R v) + theta x R v_t). */
PROCESSOR_INLINE void turn_matrix(const kinematics_point *at, double weight, const lanes arm[3],
                                  lanes M[3][3])
{
    const lanes *w = at->spin, *l = at->along, *t = at->turned_rate;
    const lanes along = weight * (w[0] * l[0] + w[1] * l[1] + w[2] * l[2]) -
                        (t[0] * arm[0] + t[1] * arm[1] + t[2] * arm[2]);
    cross_matrix(at->along_rate, -weight, M);
    for (int i = 0; i < 3; i++) {
        M[i][i] += along;
        for (int k = 0; k < 3; k++) {
            M[i][k] += t[i] * arm[k] - weight * l[i] * w[k];
        }
    }
}

/* Row `own` of derivatives by an element's modes from those by strains at a point. */
PROCESSOR_INLINE void add_point(const kinematics *kinematics, int e, int point,
                                lanes of[2][KINEMATICS_KINDS][3][3], lanes *by)
{
    const double *value = kinematics->value + (e * kinematics->stages + point) * kinematics->modes;
    for (int a = kinematics->own[e]; a < kinematics->own_end[e]; a++) {
        const int c = kinematics->strain[a];
        for (int kind = 0; kind < KINEMATICS_KINDS; kind++) {
            add_multiple(value[a], of[c >= 3][kind][c % 3],
                         by + 3 * (kind * kinematics->modes + a));
        }
    }
}

/* Derivatives of a place by the modes of one element; `beyond` then has the element, too. */
PROCESSOR_CALLED void differentiate_element(const kinematics *kinematics,
                                            const kinematics_point *at, int e, const double *weight,
                                            bool moving, kinematics_beyond *beyond, lanes *by)
{
    const int n = kinematics->stages;
    const double *integral = kinematics->integral + e * (n + 1) * n, *full = integral + n * n;
    lanes arm[KINEMATICS_STAGES_MAX][3], turned[KINEMATICS_STAGES_MAX][3];
    lanes M[KINEMATICS_STAGES_MAX][3][3], all[3][3], of[2][KINEMATICS_KINDS][3][3];
    memset(of, 0, sizeof of);
    for (int i = 0; i < n; i++) {
        memset(arm[i], 0, sizeof arm[i]);
        memset(turned[i], 0, sizeof turned[i]);
        add_multiple(full[i], beyond->along, arm[i]);
        add_multiple(full[i], beyond->turned, turned[i]);
        for (int j = 0; j < n; j++) {
            add_multiple(weight[j] * integral[j * n + i], at[j].along, arm[i]);
            add_multiple(weight[j] * integral[j * n + i], at[j].turned_rate, turned[i]);
        }
        if (moving) {
            turn_matrix(&at[i], weight[i], arm[i], M[i]);
        }
    }
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 9 && moving; k++) {
            all[k / 3][k % 3] = full[i] * beyond->M[k / 3][k % 3];
            for (int j = 0; j < n; j++) {
                all[k / 3][k % 3] += integral[j * n + i] * M[j][k / 3][k % 3];
            }
        }
        for (int c = 0; c < 3; c++) {
            const lanes d[3] = {at[i].R[0][c], at[i].R[1][c], at[i].R[2][c]};
            for (int k = 0; k < 3; k++) {
                of[0][BY_POSITION][c][k] = of[1][BY_TURN][c][k] = weight[i] * d[k];
            }
            lanes_vector_cross(d, arm[i], of[1][BY_POSITION][c]);
            if (moving) {
                const lanes spin[3] = {weight[i] * at[i].spin[0], weight[i] * at[i].spin[1],
                                       weight[i] * at[i].spin[2]};
                lanes_vector_cross(spin, d, of[0][BY_VELOCITY][c]);
                apply(all, d, of[1][BY_VELOCITY][c]);
                lanes_vector_cross(d, turned[i], of[1][BY_SPIN][c]);
            }
        }
        add_point(kinematics, e, i, of, by);
    }
    for (int i = 0; i < n; i++) {
        add_multiple(weight[i], at[i].along, beyond->along);
        add_multiple(weight[i], at[i].turned_rate, beyond->turned);
        for (int k = 0; k < 3 && moving; k++) {
            add_multiple(1, M[i][k], beyond->M[k]);
        }
    }
}

PROCESSOR_INLINE void differentiate(const kinematics *kinematics, const kinematics_work *w,
                                    int place, bool moving)
{
    const int n = kinematics->stages, last = kinematics->place_element[place];
    kinematics_beyond beyond;
    memset(&beyond, 0, sizeof beyond);
    memset(w->by, 0, (size_t)(3 * KINEMATICS_KINDS * kinematics->modes) * sizeof *w->by);
    for (int e = last; e >= 0; e--) {
        const double *weight = e == last ? kinematics->place_integral + place * n
                                         : kinematics->integral + (e * (n + 1) + n) * n;
        differentiate_element(kinematics, w->point + e * n, e, weight, moving, &beyond, w->by);
    }
}

/* Of one kind and row by mode a and by its rate. */
PROCESSOR_INLINE void find_derivative(const kinematics *kinematics, const kinematics_work *w,
                                      int place, int row, int a, lanes R[3][3], const lanes spin[3],
                                      lanes by[2])
{
    const int k = row % 3, kinds = 3 * kinematics->modes, e = kinematics->place_element[place];
    const lanes *all = w->by + 3 * a, *theta = all + BY_TURN * kinds;
    const lanes d[3] = {R[0][k], R[1][k], R[2][k]};
    const bool own = a >= kinematics->own[e] && a < kinematics->own_end[e];
    lanes turned[3];
    by[1] = NO_LANES;
    switch (row / 3) {
    case BY_POSITION:
        by[0] = all[k];
        break;
    case BY_TURN:
        by[0] = theta[k];
        break;
    case BY_VELOCITY:
        by[0] = all[BY_VELOCITY * kinds + k];
        by[1] = all[k];
        break;
    case BY_SPIN: /* R^T (w - theta x spin) */
        lanes_vector_cross(spin, theta, turned);
        add_multiple(1, all + BY_SPIN * kinds, turned);
        by[0] = d[0] * turned[0] + d[1] * turned[1] + d[2] * turned[2];
        by[1] = d[0] * theta[0] + d[1] * theta[1] + d[2] * theta[2];
        break;
    default:
        by[0] = NO_LANES + (own && kinematics->strain[a] == row - 12
                                ? kinematics->place_value[place * kinematics->modes + a]
                                : 0);
    }
}

/* ---- all of it ------------------------------------------------------------------------------- */

PROCESSOR_INLINE void load_states(const kinematics *kinematics, int count, const double *states,
                                  lanes *to)
{
    const int size = 2 * kinematics->modes;
    for (int a = 0; a < size; a++) {
        for (int lane = 0; lane < LANES; lane++) { /* the last again, where there are no more */
            to[a][lane] = states[(lane < count ? lane : count - 1) * size + a];
        }
    }
}

FOR_EACH_PROCESSOR static void see_lanes(const kinematics *kinematics, int count,
                                         const double *states, double *seen, double *by_state,
                                         double *room)
{
    const kinematics_work w = divide_room(kinematics, room);
    const int size = 2 * kinematics->modes;
    load_states(kinematics, count, states, w.state);
    find_shape(kinematics, &w);
    for (int place = 0, row = 0; place < kinematics->places; place++) {
        const int first = place * KINEMATICS_ROWS;
        lanes R[3][3], spin[3], out[KINEMATICS_SEEN];
        bool moving = false;
        find_place(kinematics, &w, place, out, R, spin);
        for (int lane = 0; lane < count; lane++) {
            double *to = seen + (lane * kinematics->places + place) * KINEMATICS_SEEN;
            for (int i = 0; i < KINEMATICS_SEEN; i++) {
                to[i] = out[i][lane];
            }
        }
        if (!by_state) {
            continue;
        }
        for (int r = row; r < kinematics->rows && kinematics->row[r] < first + KINEMATICS_ROWS;
             r++) {
            const int kind = (kinematics->row[r] - first) / 3;
            moving |= kind == BY_VELOCITY || kind == BY_SPIN;
        }
        differentiate(kinematics, &w, place, moving);
        for (; row < kinematics->rows && kinematics->row[row] < first + KINEMATICS_ROWS; row++) {
            for (int a = 0; a < kinematics->modes; a++) {
                lanes by[2];
                find_derivative(kinematics, &w, place, kinematics->row[row] - first, a, R, spin,
                                by);
                for (int lane = 0; lane < count; lane++) {
                    double *to = by_state + (lane * kinematics->rows + row) * size + a;
                    to[0] = by[0][lane];
                    to[kinematics->modes] = by[1][lane];
                }
            }
        }
    }
}

void kinematics_see(const kinematics *kinematics, int count, const double *states, double *seen,
                    double *by_state, double *room)
{
    const int size = 2 * kinematics->modes;
    for (int first = 0; first < count; first += LANES) {
        const int n = count - first < LANES ? count - first : LANES;
        see_lanes(kinematics, n, states + first * size,
                  seen + first * kinematics->places * KINEMATICS_SEEN,
                  by_state ? by_state + first * kinematics->rows * size : NULL, room);
    }
}
