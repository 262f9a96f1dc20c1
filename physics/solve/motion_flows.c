/* The flows whose compositions are steps of time: nodes that move freely, forces that change their
 * velocities where they are, and drag that slows them. */
#include "physics/solve/motion_internal.h"

#include "physics/numerics/quaternion.h"
#include "physics/numerics/quaternion_lanes.h"

#include <math.h>
#include <string.h>

bool motion_is_separable(const motion *m)
{
    return !m->is_damped && !m->has_added;
}

void motion_start(motion *m, const double *state)
{
    motion_set_nodes(m, state);
}

void motion_finish(const motion *m, double *state)
{
    for (size_t i = 0; i < m->nodes; i++) {
        double *to = state + i * MOTION_ROWS;
        memcpy(to + MOTION_R, m->pose[i], 3 * sizeof *to);
        memcpy(to + MOTION_Q, m->pose[i] + MOTION_LANE_Q, 4 * sizeof *to);
        memcpy(to + MOTION_V, m->flow[i], 3 * sizeof *to);
        memcpy(to + MOTION_W, m->spin[i], 3 * sizeof *to);
    }
}

enum { KEPT = 2 * LANES + 3 }; /* of a node */

size_t motion_kept_size(const motion *m)
{
    return m->nodes * KEPT;
}

void motion_keep(const motion *m, double *kept)
{
    memcpy(kept, m->pose, m->nodes * sizeof *m->pose);
    memcpy(kept + m->nodes * LANES, m->flow, m->nodes * sizeof *m->flow);
    memcpy(kept + 2 * m->nodes * LANES, m->spin, m->nodes * sizeof *m->spin);
}

ad_status motion_take_back(motion *m, const double *kept, double t, ad_error *error)
{
    memcpy(m->pose, kept, m->nodes * sizeof *m->pose);
    memcpy(m->flow, kept + m->nodes * LANES, m->nodes * sizeof *m->flow);
    memcpy(m->spin, kept + 2 * m->nodes * LANES, m->nodes * sizeof *m->spin);
    return motion_at(m, t, error);
}

/* ---- moving freely ------------------------------------------------------------------------- */

/* Nodes side by side. */
typedef struct spinning {
    lanes q[4], w[3], inertia[3], by_inertia[3];
} spinning;

/* Most terms of Taylor series of w and q, over a time in which nothing turns by more than
 * LARGEST_TURN: the first left out is below rounding. */
enum { TERMS = 9 };
static const double LARGEST_TURN = 0.02;

/* a = by_inertia (J b x c), added to a. */
PROCESSOR_INLINE void add_gyroscopic(const spinning *spinning, const lanes b[3], const lanes c[3],
                                     lanes a[3])
{
    lanes momentum[3], turning[3];
    for (int i = 0; i < 3; i++) {
        momentum[i] = spinning->inertia[i] * b[i];
    }
    lanes_vector_cross(momentum, c, turning);
    for (int i = 0; i < 3; i++) {
        a[i] += spinning->by_inertia[i] * turning[i];
    }
}

/* A body that turns freely, J w_t = J w x w and q_t = q (0, w)/2, by h: coefficients of its Taylor
 * series follow from one another. */
PROCESSOR_INLINE void spin_by_series(spinning *spinning, double h, int terms)
{
    lanes w[TERMS + 1][3], q[TERMS + 1][4];
    memcpy(w[0], spinning->w, sizeof w[0]);
    memcpy(q[0], spinning->q, sizeof q[0]);
    for (int k = 0; k < terms; k++) {
        lanes w_next[3] = {{0}}, q_next[4] = {{0}};
        for (int j = 0; j <= k; j++) {
            lanes turned[4];
            add_gyroscopic(spinning, w[j], w[k - j], w_next);
            lanes_quaternion_times_vector(q[j], w[k - j], turned);
            for (int i = 0; i < 4; i++) {
                q_next[i] += turned[i];
            }
        }
        for (int i = 0; i < 3; i++) {
            w[k + 1][i] = w_next[i] * (h / (k + 1));
            spinning->w[i] += w[k + 1][i];
        }
        for (int i = 0; i < 4; i++) {
            q[k + 1][i] = q_next[i] * (h / (2 * (k + 1)));
            spinning->q[i] += q[k + 1][i];
        }
    }
}

/* The same where w does not change: q exp(w h/2), by the series of cosine and sine. */
PROCESSOR_INLINE void spin_steadily(spinning *spinning, double h)
{
    lanes square = {0}, half[3], turned[4];
    for (int i = 0; i < 3; i++) {
        half[i] = 0.5 * h * spinning->w[i];
        square += half[i] * half[i];
    }
    /* to the powers that rounding leaves of LARGEST_TURN */
    lanes cosine = 1 - square * (1.0 / 2 - square * (1.0 / 24 - square * (1.0 / 720)));
    lanes sine = 1 - square * (1.0 / 6 - square * (1.0 / 120 - square * (1.0 / 5040)));
    for (int i = 0; i < 3; i++) {
        half[i] *= sine;
    }
    lanes_quaternion_times_vector(spinning->q, half, turned);
    for (int i = 0; i < 4; i++) {
        spinning->q[i] = spinning->q[i] * cosine + turned[i];
    }
}

PROCESSOR_INLINE void load_nodes(const motion *m, size_t first, spinning *spinning)
{
    const double *pose[LANES], *spin[LANES];
    for (size_t lane = 0; lane < LANES; lane++) {
        size_t node = first + lane < m->nodes ? first + lane : m->nodes - 1;
        pose[lane] = m->pose[node];
        spin[lane] = m->spin[node];
    }
    for (int i = 0; i < 4; i++) {
        spinning->q[i] = LANES_OF(pose, MOTION_LANE_Q + i);
    }
    for (int i = 0; i < 3; i++) {
        spinning->w[i] = LANES_OF(spin, i);
    }
}

PROCESSOR_INLINE void load_inertia(const motion *m, size_t first, spinning *spinning)
{
    const double *inertia[LANES], *by_inertia[LANES];
    for (size_t lane = 0; lane < LANES; lane++) {
        size_t node = first + lane < m->nodes ? first + lane : m->nodes - 1;
        inertia[lane] = m->inertia[node];
        by_inertia[lane] = m->by_inertia[node];
    }
    for (int i = 0; i < 3; i++) {
        spinning->inertia[i] = LANES_OF(inertia, i);
        spinning->by_inertia[i] = LANES_OF(by_inertia, i);
    }
}

PROCESSOR_INLINE void store_nodes(motion *m, size_t first, const spinning *spinning, bool steady)
{
    for (size_t lane = 0; lane < LANES && first + lane < m->nodes; lane++) {
        for (int i = 0; i < 4; i++) {
            m->pose[first + lane][MOTION_LANE_Q + i] = spinning->q[i][lane];
        }
        for (int i = 0; i < 3 && !steady; i++) {
            m->spin[first + lane][i] = spinning->w[i][lane];
        }
    }
}

/* Quaternions of length 1 + e, e of the order of rounding, lose it. */
PROCESSOR_INLINE void renormalize(lanes q[4])
{
    lanes by = 1.5 - 0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) {
        q[i] *= by;
    }
}

PROCESSOR_INLINE double sum_of(const lanes *lane)
{
    const lanes x = *lane;
    return ((x[0] + x[4]) + (x[1] + x[5])) + ((x[2] + x[6]) + (x[3] + x[7]));
}

/* That many, where bodies turn by `turn`. */
static int terms_for(double turn)
{
    const double rounding = 1e-17;
    int terms = 1;
    for (double left_out = turn * turn; terms < TERMS && left_out > rounding; terms++) {
        left_out *= turn;
    }
    return terms;
}

/* The general case, in as many parts as series need; numbers that are not finite are carried on, to
 * be seen by whoever steps. */
FOR_EACH_PROCESSOR static void spin_unsteadily(motion *m, size_t first, double h)
{
    spinning x = {.q = {{0}}};
    load_nodes(m, first, &x);
    load_inertia(m, first, &x);
    lanes fast = x.w[0] * x.w[0] + x.w[1] * x.w[1] + x.w[2] * x.w[2];
    double turn = fabs(h) * sqrt(sum_of(&fast)), most = 1e3 * LARGEST_TURN;
    int parts = turn < most ? 1 + (int)(turn / LARGEST_TURN) : 1000;
    int terms = terms_for(turn / parts);
    for (int part = 0; part < parts; part++) {
        spin_by_series(&x, h / parts, terms);
        renormalize(x.q);
    }
    store_nodes(m, first, &x, false);
}

/* From node `first` on; ends before nodes whose w changes, or that turn far, and returns the first
 * of them. */
FOR_EACH_PROCESSOR static size_t spin_steady_nodes(motion *m, size_t first, double h)
{
    for (; first < m->nodes; first += LANES) {
        spinning x = {.q = {{0}}};
        load_nodes(m, first, &x);
        const lanes xx = x.w[0] * x.w[0], yy = x.w[1] * x.w[1], zz = x.w[2] * x.w[2];
        lanes mixed = xx * yy + yy * zz + zz * xx, fast = (xx + yy + zz) * (h * h);
        if (sum_of(&mixed) != 0) { /* not all about principal axes */
            lanes turning[3] = {{0}};
            load_inertia(m, first, &x);
            add_gyroscopic(&x, x.w, x.w, turning);
            mixed = turning[0] * turning[0] + turning[1] * turning[1] + turning[2] * turning[2];
        }
        if (!(sum_of(&mixed) == 0 && sum_of(&fast) < LARGEST_TURN * LARGEST_TURN)) {
            return first;
        }
        spin_steadily(&x, h);
        renormalize(x.q);
        store_nodes(m, first, &x, true);
    }
    return first;
}

static void spin_nodes(motion *m, double h)
{
    for (size_t first = 0; first < m->nodes; first += LANES) {
        first = spin_steady_nodes(m, first, h);
        if (first < m->nodes) {
            spin_unsteadily(m, first, h);
        }
    }
}

ad_status motion_drift(motion *m, double h, double t, ad_error *error)
{
    for (size_t i = 0; i < m->nodes; i++) {
        for (int k = 0; k < 3; k++) {
            m->pose[i][k] += h * m->flow[i][k];
        }
    }
    spin_nodes(m, h);
    ad_status status = motion_at(m, t, error);
    if (status == AD_OK) {
        motion_hold_ends(m);
    }
    return status;
}

/* ---- forces -------------------------------------------------------------------------------- */

static double node_power(const motion *m, size_t node)
{
    return vector_dot(m->push[node], m->flow[node]) + vector_dot(m->turn[node], m->spin[node]);
}

/* Of loads and actuators. */
static double power_put_in(const motion *m)
{
    bool everywhere = m->rod->along.kinds & ACTING_LOADS;
    for (int k = 0; k < m->rod->jumps.count; k++) {
        everywhere |= m->places[k].node > 0 && m->places[k].node + 1 < m->nodes;
    }
    double power = node_power(m, 0) + node_power(m, m->nodes - 1) + motion_pull_power(m);
    for (size_t i = 1; everywhere && i + 1 < m->nodes; i++) {
        power += node_power(m, i);
    }
    return power;
}

double motion_kick(motion *m, double h, double before, double after)
{
    motion_internal_forces(m);
    motion_loads(m);
    double work = 0.5 * before * power_put_in(m);
    for (size_t i = 0; i < m->nodes; i++) {
        double by = h * m->by_mass[i];
        for (int k = 0; k < 3; k++) {
            m->flow[i][k] += by * (m->force[i][k] + m->push[i][k]);
            m->spin[i][k] += h * m->by_inertia[i][k] * (m->torque[i][k] + m->turn[i][k]);
        }
    }
    motion_hold_ends(m);
    return work + 0.5 * after * power_put_in(m);
}

/* ---- drag ---------------------------------------------------------------------------------- */

/* Drag on node i, of m->resistance. */
static void node_drag(const motion *m, size_t i, double drag[3])
{
    const size_t degree = (size_t)m->degree, element = i / degree, k = i % degree;
    const size_t first = element * (degree + 1) + k;
    memset(drag, 0, 3 * sizeof *drag);
    for (int c = 0; c < 3; c++) {
        if (element < (size_t)m->elements) {
            drag[c] += m->point_weight[first] * m->resistance[first][c];
        }
        if (k == 0 && element > 0) { /* the last point of the element before */
            drag[c] += m->point_weight[first - 1] * m->resistance[first - 1][c];
        }
    }
}

/* V, moved by h with the drag of other velocities of the same direction, or nearly: that against
 * them makes V fall exponentially, and what is across is a constant while it does. */
static void slow(const motion *m, size_t i, double h, const double at[3], double V[3])
{
    double drag[3], square = vector_dot(at, at);
    node_drag(m, i, drag);
    double rate = square > 0 ? vector_dot(drag, at) / square * m->by_mass[i] : 0;
    double lost = -expm1(-h * rate), for_across = rate > 0 ? lost / rate : h;
    for (int c = 0; c < 3; c++) {
        double across = drag[c] * m->by_mass[i] - rate * at[c];
        V[c] -= lost * V[c] + for_across * across;
    }
}

/* What holds the node makes up for the drag: in V, from m->push before it; gives its work. */
static double hold_against_drag(const motion *m, size_t i, double h, double V[3])
{
    double work = 0;
    for (int end = 0; end < 2; end++) {
        const scene_hold *hold = &m->rod->ends[end].hold;
        double drag[3], slowed[3], kept[3], along[3];
        if (i == motion_end_node(m, end) && hold->directions > 0) {
            for (int c = 0; c < 3; c++) {
                slowed[c] = m->push[i][c] - V[c];
            }
            node_drag(m, i, drag);
            scene_hold_part(hold, m->push[i], along);
            scene_hold_part(hold, slowed, kept);
            work += h * vector_dot(drag, along);
            for (int c = 0; c < 3; c++) {
                V[c] += kept[c];
            }
        }
    }
    return work;
}

double motion_resist(motion *m, double h)
{
    double lost = 0;
    motion_find_resistance(m);
    for (size_t i = 0; i < m->nodes; i++) { /* to the middle of h */
        memcpy(m->push[i], m->flow[i], sizeof m->push[i]);
        slow(m, i, 0.5 * h, m->push[i], m->flow[i]);
    }
    motion_find_resistance(m);
    for (size_t i = 0; i < m->nodes; i++) {
        double middle[3], V[3];
        memcpy(middle, m->flow[i], sizeof middle);
        memcpy(V, m->push[i], sizeof V);
        slow(m, i, h, middle, V);
        lost += hold_against_drag(m, i, h, V);
        lost += 0.5 * m->mass[i] * (vector_dot(m->push[i], m->push[i]) - vector_dot(V, V));
        memcpy(m->flow[i], V, sizeof V);
    }
    return lost;
}
