#include "physics/solve/motion.h"

#include "physics/solve/lobatto.h"
#include "physics/solve/processor.h"
#include "physics/solve/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What is differentiated at a node, padded for the processor: a vector, a quaternion, 0. */
enum { LANE_Q = 3 };

/* Strains and forces at a quadrature point, body frame. */
typedef struct strained {
    double v[3], u[3], n[3], m[3];
} strained;

/* What the rod is made of at a node, stiffness finite also where it is locked. */
typedef struct material {
    solve_section section;
    double by_mass, by_inertia[3]; /* 1 over them */
} material;

struct motion {
    const solve_rod *rod;
    int elements, degree;
    size_t nodes;
    bool is_damped; /* Bse or Bbt */
    bool has_time;  /* loads, ends and a rest shape that moves are those of `time` */
    double time;

    double *points;          /* [degree + 1] on [-1, 1] */
    double *point_weights;   /* [degree + 1] */
    double *derivative;      /* [degree + 1][degree + 1] d/ds */
    double *transposed;      /* of the derivative */
    double *s;               /* [nodes] */
    double *weight;          /* [nodes] of the quadrature over the rod */
    double *element_weight;  /* [degree + 1] of the quadrature over an element */
    material *materials;     /* [nodes] */
    solve_rest *rest;        /* [nodes] */
    solve_load *load;        /* [nodes] */
    solve_end_state ends[2]; /* at s = 0, 1 */

    double (*pose)[LANES];                                          /* [nodes] r, q; unit */
    double (*flow)[LANES];                                          /* [nodes] V, q_t */
    double (*spin)[3];                                              /* [nodes] w */
    double (*R)[3][3];                                              /* [nodes] */
    double (*slope)[LANES], (*slope_rate)[LANES], (*wrench)[LANES]; /* [degree + 1] */
    strained *sections;                                             /* [elements][degree + 1] */
    double (*force)[LANES]; /* [nodes] internal, as an impulse on r and q */
    double (*torque)[3];    /* [nodes] internal, body */
    double (*push)[3];      /* [nodes] outside force without drag, world */
    double (*turn)[3];      /* [nodes] outside moment, body */
};

/* ---- creating ------------------------------------------------------------------------------ */

static bool allocate(motion *m)
{
    size_t n = (size_t)m->degree + 1, nodes = m->nodes;
    m->points = calloc(n, sizeof *m->points);
    m->point_weights = calloc(n, sizeof *m->point_weights);
    m->derivative = calloc(n * n, sizeof *m->derivative);
    m->transposed = calloc(n * n, sizeof *m->transposed);
    m->s = calloc(nodes, sizeof *m->s);
    m->weight = calloc(nodes, sizeof *m->weight);
    m->element_weight = calloc(n, sizeof *m->element_weight);
    m->materials = calloc(nodes, sizeof *m->materials);
    m->rest = calloc(nodes, sizeof *m->rest);
    m->load = calloc(nodes, sizeof *m->load);
    m->pose = calloc(nodes, sizeof *m->pose);
    m->flow = calloc(nodes, sizeof *m->flow);
    m->spin = calloc(nodes, sizeof *m->spin);
    m->R = calloc(nodes, sizeof *m->R);
    m->slope = calloc(n, sizeof *m->slope);
    m->slope_rate = calloc(n, sizeof *m->slope_rate);
    m->wrench = calloc(n, sizeof *m->wrench);
    m->sections = calloc(n * (size_t)m->elements, sizeof *m->sections);
    m->force = calloc(nodes, sizeof *m->force);
    m->torque = calloc(nodes, sizeof *m->torque);
    m->push = calloc(nodes, sizeof *m->push);
    m->turn = calloc(nodes, sizeof *m->turn);
    return m->points && m->point_weights && m->derivative && m->transposed && m->s && m->weight &&
           m->element_weight && m->materials && m->rest && m->load && m->pose && m->flow &&
           m->spin && m->R && m->slope && m->slope_rate && m->wrench && m->sections && m->force &&
           m->torque && m->push && m->turn;
}

void motion_free(motion *m)
{
    if (m) {
        void *all[] = {m->points, m->point_weights,  m->derivative, m->transposed, m->s,
                       m->weight, m->element_weight, m->rest,       m->load,       m->pose,
                       m->flow,   m->spin,           m->R,          m->slope,      m->slope_rate,
                       m->wrench, m->sections,       m->force,      m->torque,     m->push,
                       m->turn,   m->materials};
        for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
            free(all[i]);
        }
        free(m);
    }
}

static void place_nodes(motion *m)
{
    int n = m->degree + 1;
    double half = 0.5 / m->elements; /* of an element's length */
    lobatto_points(m->degree, m->points, m->point_weights);
    lobatto_derivative(m->degree, m->points, m->derivative);
    for (int k = 0; k < n; k++) {
        m->element_weight[k] = half * m->point_weights[k];
        for (int j = 0; j < n; j++) {
            m->derivative[k * n + j] /= half;
            m->transposed[j * n + k] = m->derivative[k * n + j];
        }
    }
    for (int e = 0; e < m->elements; e++) {
        for (int k = 0; k < n; k++) {
            size_t node = (size_t)(e * m->degree + k);
            m->s[node] = (2 * e + 1 + m->points[k]) * half;
            m->weight[node] += m->element_weight[k];
        }
    }
}

/* AD_BAD_INPUT without rotary inertia. */
static ad_status set_material(motion *m, size_t node, const solve_section *section, double lock,
                              ad_error *error)
{
    material *to = &m->materials[node];
    to->section = *section;
    to->by_mass = 1 / section->mass;
    for (int i = 0; i < 3; i++) {
        double *strain = &to->section.strain_stiffness[i];
        double *curvature = &to->section.curvature_stiffness[i];
        *strain = *strain > 0 ? *strain : lock;
        *curvature = *curvature > 0 ? *curvature : lock;
        to->by_inertia[i] = 1 / section->rotary_inertia[i];
        m->is_damped |= section->strain_damping[i] != 0 || section->curvature_damping[i] != 0;
        if (!(section->rotary_inertia[i] > 0)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "rotary inertia about d%d is %g in a dynamic scene; allowed: > 0", i + 1,
                           section->rotary_inertia[i]);
        }
    }
    return AD_OK;
}

static ad_status set_materials(motion *m, double lock, ad_error *error)
{
    solve_section *sections = malloc(m->nodes * sizeof *sections);
    ad_status status = sections ? solve_rod_sections(m->rod, m->nodes, m->s, sections, error)
                                : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (size_t i = 0; status == AD_OK && i < m->nodes; i++) {
        status = set_material(m, i, &sections[i], lock, error);
    }
    free(sections);
    return status;
}

ad_status motion_create(const solve_rod *rod, double lock, int elements, int degree,
                        motion **result, ad_error *error)
{
    *result = NULL;
    if (elements < 1 || degree < 2 || degree > LOBATTO_DEGREE_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%d elements of degree %d; allowed: at least one, of degree 2 to %d",
                       elements, degree, LOBATTO_DEGREE_MAX);
    }
    motion *m = calloc(1, sizeof *m);
    if (m) {
        *m = (motion){.rod = rod, .elements = elements, .degree = degree};
        m->nodes = (size_t)elements * (size_t)degree + 1;
    }
    if (!m || !allocate(m)) {
        motion_free(m);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a rod of %d elements", elements);
    }
    place_nodes(m);
    ad_status status = set_materials(m, lock, error);
    if (status == AD_OK) {
        status = solve_rod_rest(rod, m->nodes, m->s, 0, m->rest, error);
    }
    if (status != AD_OK) {
        motion_free(m);
        return status;
    }
    *result = m;
    return AD_OK;
}

const solve_rod *motion_rod(const motion *m)
{
    return m->rod;
}

size_t motion_nodes(const motion *m)
{
    return m->nodes;
}

int motion_degree(const motion *m)
{
    return m->degree;
}

const double *motion_points(const motion *m)
{
    return m->s;
}

const double *motion_weights(const motion *m)
{
    return m->weight;
}

ad_status motion_initial(const motion *m, double *state, ad_error *error)
{
    _Static_assert(sizeof(solve_initial) == MOTION_ROWS * sizeof(double), "the same rows");
    return solve_rod_initial(m->rod, m->nodes, m->s, (solve_initial *)state, error);
}

ad_status motion_at(motion *m, double t, ad_error *error)
{
    if (m->has_time && m->time == t) {
        return AD_OK;
    }
    ad_status status = solve_rod_load(m->rod, m->nodes, m->s, t, m->load, error);
    if (status == AD_OK && m->rod->rest_moves) {
        status = solve_rod_rest(m->rod, m->nodes, m->s, t, m->rest, error);
    }
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        status = solve_rod_end(m->rod, end, t, &m->ends[end], error);
    }
    m->time = t;
    m->has_time = status == AD_OK;
    return status;
}

/* ---- what ends prescribe ------------------------------------------------------------------- */

static size_t end_node(const motion *m, int end)
{
    return end ? m->nodes - 1 : 0;
}

bool motion_is_held(const motion *m, size_t node, int row)
{
    bool of_rotation = (row >= MOTION_Q && row < MOTION_V) || row >= MOTION_W;
    for (int end = 0; end < 2; end++) {
        const solve_end *given = &m->rod->ends[end];
        if (node == end_node(m, end) &&
            (of_rotation ? given->holds_rotation : given->holds_position)) {
            return true;
        }
    }
    return false;
}

void motion_prescribe(const motion *m, double *state)
{
    for (int end = 0; end < 2; end++) {
        double *node = state + end_node(m, end) * MOTION_ROWS;
        if (m->rod->ends[end].holds_position) {
            memcpy(node + MOTION_R, m->ends[end].position, 3 * sizeof(double));
            memcpy(node + MOTION_V, m->ends[end].velocity, 3 * sizeof(double));
        }
        if (m->rod->ends[end].holds_rotation) {
            memcpy(node + MOTION_Q, m->ends[end].rotation, 4 * sizeof(double));
            memcpy(node + MOTION_W, m->ends[end].spin, 3 * sizeof(double));
        }
    }
    for (size_t i = 0; i < m->nodes; i++) {
        quaternion_normalize(state + i * MOTION_ROWS + MOTION_Q);
    }
}

/* ---- internal forces ----------------------------------------------------------------------- */

/* y [n][LANES] = matrix [n][n] x. Sums have the same order, so the same bits, on any processor. */
FOR_EACH_PROCESSOR static void apply(int n, const double *matrix, double (*x)[LANES],
                                     double (*y)[LANES])
{
    for (int i = 0; i < n; i += 2) { /* two rows at once: a sum waits for its last addition */
        const double *row = matrix + i * n, *next = i + 1 < n ? row + n : row;
        lanes sum = {0}, next_sum = {0};
        for (int j = 0; j < n; j++) {
            lanes at = *(const lanes *)x[j];
            sum += row[j] * at;
            next_sum += next[j] * at;
        }
        memcpy(y[i], &sum, sizeof sum);
        if (i + 1 < n) {
            memcpy(y[i + 1], &next_sum, sizeof next_sum);
        }
    }
}

static void set_node(motion *m, size_t node, const double *state)
{
    double *pose = m->pose[node], *flow = m->flow[node], *spin = m->spin[node];
    memcpy(pose + LANE_Q, state + MOTION_Q, 4 * sizeof(double));
    quaternion_normalize(pose + LANE_Q);
    for (int k = 0; k < 3; k++) {
        pose[k] = state[MOTION_R + k];
        flow[k] = state[MOTION_V + k];
        spin[k] = state[MOTION_W + k];
    }
}

static void set_nodes(motion *m, const double *state)
{
    for (size_t i = 0; i < m->nodes; i++) {
        set_node(m, i, state + i * MOTION_ROWS);
    }
    for (int end = 0; end < 2; end++) {
        size_t i = end_node(m, end);
        if (m->rod->ends[end].holds_position) {
            memcpy(m->pose[i], m->ends[end].position, 3 * sizeof(double));
            memcpy(m->flow[i], m->ends[end].velocity, 3 * sizeof(double));
        }
        if (m->rod->ends[end].holds_rotation) {
            memcpy(m->pose[i] + LANE_Q, m->ends[end].rotation, 4 * sizeof(double));
            memcpy(m->spin[i], m->ends[end].spin, 3 * sizeof(double));
        }
    }
    for (size_t i = 0; i < m->nodes; i++) {
        const double *w = m->spin[i], half[3] = {0.5 * w[0], 0.5 * w[1], 0.5 * w[2]};
        quaternion_times_vector(m->pose[i] + LANE_Q, half, m->flow[i] + LANE_Q);
        rotation_matrix(m->pose[i] + LANE_Q, m->R[i]);
    }
}

/* Rates of strain: v_t = R^T V_s + v x w, u_t = 2 vec(q_t* q_s + q* q_ts). */
static void add_damping(const motion *m, size_t node, const double *slope, const double *rate,
                        strained *at)
{
    const solve_section *section = &m->materials[node].section;
    double v_t[3], turning[3], p[4], p_t[4];
    double(*R)[3] = m->R[node];
    to_body(R, rate, v_t);
    vector_cross(at->v, m->spin[node], turning);
    quaternion_quotient(m->flow[node] + LANE_Q, slope + LANE_Q, p);
    quaternion_quotient(m->pose[node] + LANE_Q, rate + LANE_Q, p_t);
    for (int i = 0; i < 3; i++) {
        at->n[i] += section->strain_damping[i] * (v_t[i] + turning[i]);
        at->m[i] += section->curvature_damping[i] * 2 * (p[i + 1] + p_t[i + 1]);
    }
}

/* Strains, n and m at point k of an element; what they exert there, times the quadrature's weight:
 * `wrench` on r_s and q_s, m->torque on q itself. */
static void section_at(motion *m, size_t node, int k, strained *at, double *wrench)
{
    const solve_section *section = &m->materials[node].section;
    const solve_rest *rest = &m->rest[node];
    const double *slope = m->slope[k], *q = m->pose[node] + LANE_Q;
    double(*R)[3] = m->R[node];
    double p[4], cross_n[3], cross_m[3], weight = m->element_weight[k];
    to_body(R, slope, at->v);
    quaternion_quotient(q, slope + LANE_Q, p);
    for (int i = 0; i < 3; i++) {
        at->u[i] = 2 * p[i + 1];
        at->n[i] = section->strain_stiffness[i] * (at->v[i] - rest->strain[i]);
        at->m[i] = section->curvature_stiffness[i] * (at->u[i] - rest->curvature[i]);
    }
    if (m->is_damped) {
        add_damping(m, node, slope, m->slope_rate[k], at);
    }
    to_world(R, at->n, wrench);
    quaternion_times_vector(q, at->m, wrench + LANE_Q);
    wrench[LANES - 1] = 0;
    for (int i = 0; i < LANES; i++) {
        wrench[i] *= weight;
    }
    /* vec(q* q_s) varies by -vec(turn p) with q itself: torque p_0 m + u/2 x m */
    vector_cross(at->v, at->n, cross_n);
    vector_cross(at->u, at->m, cross_m);
    for (int i = 0; i < 3; i++) {
        m->torque[node][i] += weight * (p[0] * at->m[i] + 0.5 * cross_m[i] + cross_n[i]);
    }
}

static void internal_forces(motion *m)
{
    int n = m->degree + 1;
    memset(m->force, 0, m->nodes * sizeof *m->force);
    memset(m->torque, 0, m->nodes * sizeof *m->torque);
    for (int e = 0; e < m->elements; e++) {
        size_t first = (size_t)(e * m->degree);
        apply(n, m->derivative, m->pose + first, m->slope);
        if (m->is_damped) {
            apply(n, m->derivative, m->flow + first, m->slope_rate);
        }
        for (int k = 0; k < n; k++) {
            section_at(m, first + (size_t)k, k, &m->sections[e * n + k], m->wrench[k]);
        }
        apply(n, m->transposed, m->wrench, m->slope);
        for (int j = 0; j < n; j++) {
            for (int i = 0; i < LANES; i++) {
                m->force[first + (size_t)j][i] -= m->slope[j][i];
            }
        }
    }
    for (size_t i = 0; i < m->nodes; i++) {
        double turn[4];
        quaternion_quotient(m->pose[i] + LANE_Q, m->force[i] + LANE_Q, turn);
        for (int k = 0; k < 3; k++) {
            m->torque[i][k] += turn[k + 1];
        }
    }
}

/* ---- loads --------------------------------------------------------------------------------- */

static void outside_forces(motion *m)
{
    for (size_t i = 0; i < m->nodes; i++) {
        const solve_load *load = &m->load[i];
        double force[3] = {0}, moment[3];
        if (m->rod->has_body_load) {
            to_world(m->R[i], load->body_force, force);
        }
        to_body(m->R[i], load->moment, moment);
        for (int k = 0; k < 3; k++) {
            m->push[i][k] = m->weight[i] * (load->force[k] + force[k]);
            m->turn[i][k] = m->weight[i] * (moment[k] + load->body_moment[k]);
        }
    }
    for (int end = 0; end < 2; end++) {
        const solve_end *given = &m->rod->ends[end];
        const solve_end_state *now = &m->ends[end];
        size_t i = end_node(m, end);
        double force[3], moment[3], sign = end ? 1 : -1;
        to_world(m->R[i], now->force, force);
        to_body(m->R[i], now->moment, moment);
        for (int k = 0; k < 3; k++) {
            m->push[i][k] += given->holds_position
                                 ? 0
                                 : sign * (given->force_is_body ? force[k] : now->force[k]);
            m->turn[i][k] += given->holds_rotation
                                 ? 0
                                 : sign * (given->moment_is_body ? now->moment[k] : moment[k]);
        }
    }
}

void motion_rate(motion *m, const double *state, double *rate)
{
    set_nodes(m, state);
    internal_forces(m);
    outside_forces(m);
    for (size_t i = 0; i < m->nodes; i++) {
        double *to = rate + i * MOTION_ROWS, by = 1 / m->weight[i], gyroscopic[3];
        const material *made = &m->materials[i];
        const double *w = m->spin[i], *q = state + i * MOTION_ROWS + MOTION_Q;
        const double *inertia = made->section.rotary_inertia, drag = made->section.drag;
        const double half[3] = {0.5 * w[0], 0.5 * w[1], 0.5 * w[2]};
        const double momentum[3] = {inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2]};
        vector_cross(w, momentum, gyroscopic);
        quaternion_times_vector(q, half, to + MOTION_Q);
        for (int k = 0; k < 3; k++) {
            to[MOTION_R + k] = m->flow[i][k];
            to[MOTION_V + k] =
                (by * (m->force[i][k] + m->push[i][k]) - drag * m->flow[i][k]) * made->by_mass;
            to[MOTION_W + k] =
                (by * (m->torque[i][k] + m->turn[i][k]) - gyroscopic[k]) * made->by_inertia[k];
        }
    }
    for (int end = 0; end < 2; end++) {
        double *to = rate + end_node(m, end) * MOTION_ROWS;
        for (int row = 0; row < MOTION_ROWS; row++) {
            to[row] = motion_is_held(m, end_node(m, end), row) ? 0 : to[row];
        }
    }
}

/* ---- energy -------------------------------------------------------------------------------- */

/* Power of what holds an end: what its node's prescribed acceleration asks for beyond the rest. */
static double holding_power(const motion *m, int end)
{
    const solve_end *given = &m->rod->ends[end];
    const solve_end_state *now = &m->ends[end];
    size_t i = end_node(m, end);
    const solve_section *section = &m->materials[i].section;
    const double *inertia = section->rotary_inertia, *w = now->spin;
    double power = 0;
    for (int k = 0; k < 3; k++) {
        double mass = m->weight[i] * section->mass, drag = m->weight[i] * section->drag;
        double force =
            mass * now->acceleration[k] + drag * now->velocity[k] - m->force[i][k] - m->push[i][k];
        double moment =
            m->weight[i] * inertia[k] * now->spin_rate[k] - m->torque[i][k] - m->turn[i][k];
        power += given->holds_position ? force * now->velocity[k] : 0;
        power += given->holds_rotation ? moment * w[k] : 0; /* w x rhoJ w does no work */
    }
    return power;
}

/* Of all sections as they are: strain energy, the power that damping takes, and that which a
 * changing rest shape puts in. */
typedef struct section_sums {
    double energy, dissipation, reshaping;
} section_sums;

static section_sums sum_sections(const motion *m)
{
    section_sums sum = {0};
    for (int e = 0; e < m->elements; e++) {
        for (int k = 0; k <= m->degree; k++) {
            const strained *at = &m->sections[e * (m->degree + 1) + k];
            const solve_rest *rest = &m->rest[e * m->degree + k];
            const solve_section *section = &m->materials[e * m->degree + k].section;
            double weight = m->element_weight[k];
            for (int i = 0; i < 3; i++) {
                double strain = at->v[i] - rest->strain[i], kse = section->strain_stiffness[i];
                double bend = at->u[i] - rest->curvature[i], kbt = section->curvature_stiffness[i];
                double bse = section->strain_damping[i], bbt = section->curvature_damping[i];
                double elastic_n = kse * strain, elastic_m = kbt * bend;
                double viscous_n = at->n[i] - elastic_n, viscous_m = at->m[i] - elastic_m;
                sum.energy += 0.5 * weight * (elastic_n * strain + elastic_m * bend);
                sum.dissipation += bse > 0 ? weight * viscous_n * viscous_n / bse : 0;
                sum.dissipation += bbt > 0 ? weight * viscous_m * viscous_m / bbt : 0;
                sum.reshaping -= weight * (elastic_n * rest->strain_rate[i] +
                                           elastic_m * rest->curvature_rate[i]);
            }
        }
    }
    return sum;
}

motion_energy motion_energy_of(motion *m, const double *state)
{
    motion_energy energy = {0};
    set_nodes(m, state);
    internal_forces(m);
    energy.strain = sum_sections(m).energy;
    for (size_t i = 0; i < m->nodes; i++) {
        const solve_section *section = &m->materials[i].section;
        const double *inertia = section->rotary_inertia;
        const double *V = m->flow[i], *w = m->spin[i];
        double spinning =
            inertia[0] * w[0] * w[0] + inertia[1] * w[1] * w[1] + inertia[2] * w[2] * w[2];
        energy.kinetic += 0.5 * m->weight[i] * (section->mass * vector_dot(V, V) + spinning);
    }
    return energy;
}

/* Only then what holds it does work. */
static bool end_moves(const motion *m, int end)
{
    const solve_end *given = &m->rod->ends[end];
    const solve_end_state *now = &m->ends[end];
    return (given->holds_position && vector_dot(now->velocity, now->velocity) > 0) ||
           (given->holds_rotation && vector_dot(now->spin, now->spin) > 0);
}

motion_power motion_power_of(motion *m, const double *state)
{
    motion_power power = {0};
    bool moves = end_moves(m, 0) || end_moves(m, 1);
    set_nodes(m, state);
    outside_forces(m);
    if (m->is_damped || moves || m->rod->rest_moves) {
        internal_forces(m);
        section_sums sum = sum_sections(m);
        power.load = sum.reshaping;
        power.dissipation = sum.dissipation;
    }
    for (size_t i = 0; i < m->nodes; i++) {
        const double *V = m->flow[i], *w = m->spin[i];
        power.load += vector_dot(m->push[i], V) + vector_dot(m->turn[i], w);
        power.dissipation += m->weight[i] * m->materials[i].section.drag * vector_dot(V, V);
    }
    power.load += moves ? holding_power(m, 0) + holding_power(m, 1) : 0;
    return power;
}

/* ---- samples ------------------------------------------------------------------------------- */

static void sample_node(const motion *m, int element, int k, double scale, solve_state *to)
{
    size_t node = (size_t)(element * m->degree + k);
    const strained *at = &m->sections[element * (m->degree + 1) + k];
    for (int i = 0; i < 4; i++) {
        to->rotation[i] += scale * m->pose[node][LANE_Q + i];
    }
    for (int i = 0; i < 3; i++) {
        to->position[i] += scale * m->pose[node][i];
        to->velocity[i] += scale * m->flow[node][i];
        to->spin[i] += scale * m->spin[node][i];
        to->strain[i] += scale * at->v[i];
        to->curvature[i] += scale * at->u[i];
        to->force[i] += scale * at->n[i];
        to->moment[i] += scale * at->m[i];
    }
}

void motion_samples(motion *m, const double *state, size_t n, const double *s, solve_state *out)
{
    double values[LOBATTO_DEGREE_MAX + 1];
    set_nodes(m, state);
    internal_forces(m);
    for (size_t i = 0; i < n; i++) {
        int element = (int)(s[i] * m->elements);
        element = element < 0 ? 0 : element < m->elements ? element : m->elements - 1;
        double at = 2 * (s[i] * m->elements - element) - 1;
        out[i] = (solve_state){0};
        lobatto_interpolation(m->degree, m->points, m->point_weights, at, values);
        for (int k = 0; k <= m->degree; k++) {
            sample_node(m, element, k, values[k], &out[i]);
        }
        quaternion_normalize(out[i].rotation);
    }
}
