#include "physics/solve/motion_internal.h"

#include "physics/local/lobatto.h"
#include "physics/numerics/quaternion.h"

#include <stdlib.h>
#include <string.h>

/* Of half an element: how far within it values at its edges are taken. */
static const double SIDE = 1e-9;

/* ---- creating ------------------------------------------------------------------------------ */

/* Zeros, freed with m. NULL: there is no memory for them, or was none for others before. */
static void *take(motion *m, size_t count, size_t size)
{
    bool has_room = !m->lacks_memory && m->owned_count < MOTION_OWNED_MAX;
    void *made = has_room ? calloc(count, size) : NULL;
    m->lacks_memory = !made;
    if (made) {
        m->owned[m->owned_count++] = made;
    }
    return made;
}

static bool allocate(motion *m)
{
    size_t n = (size_t)m->degree + 1, nodes = m->nodes, points = m->points;
    size_t padded = (size_t)m->blocks * LANES, elements = (size_t)m->elements;
    m->edge = take(m, elements + 1, sizeof *m->edge);
    m->abscissas = take(m, n, sizeof *m->abscissas);
    m->weights = take(m, n, sizeof *m->weights);
    m->derivative = take(m, n * padded, sizeof *m->derivative);
    m->transposed = take(m, n * padded, sizeof *m->transposed);
    m->s = take(m, nodes, sizeof *m->s);
    m->point_s = take(m, points, sizeof *m->point_s);
    m->point_weight = take(m, points, sizeof *m->point_weight);
    m->node_weight = take(m, nodes, sizeof *m->node_weight);
    m->made = take(m, points, sizeof *m->made);
    m->rest = take(m, points, sizeof *m->rest);
    m->actuators = take(m, points * (size_t)m->rod->actuators + 1, sizeof *m->actuators);
    m->number = take(m, (size_t)m->rod->jumps.numbers, sizeof *m->number);
    m->along = take(m, points * (size_t)m->rod->along.numbers, sizeof *m->along);
    m->relaxing = take(m, points * MOTION_STRAINS, sizeof *m->relaxing);
    m->mass = take(m, nodes, sizeof *m->mass);
    m->inertia = take(m, nodes, sizeof *m->inertia);
    m->by_mass = take(m, nodes, sizeof *m->by_mass);
    m->by_inertia = take(m, nodes, sizeof *m->by_inertia);
    m->block = take(m, elements * (size_t)m->blocks, sizeof *m->block);
    m->pose = take(m, nodes, sizeof *m->pose);
    m->flow = take(m, nodes, sizeof *m->flow);
    m->spin = take(m, nodes, sizeof *m->spin);
    m->wrench = take(m, MOTION_LANES * padded, sizeof *m->wrench);
    m->force = take(m, nodes, sizeof *m->force);
    m->torque = take(m, nodes, sizeof *m->torque);
    m->push = take(m, nodes, sizeof *m->push);
    m->turn = take(m, nodes, sizeof *m->turn);
    m->pull_force = take(m, nodes, sizeof *m->pull_force);
    m->pull_torque = take(m, nodes, sizeof *m->pull_torque);
    m->has_added = scene_couples_inertia(&m->rod->scene);
    m->added = take(m, m->has_added ? nodes : 0, sizeof *m->added);
    m->velocity = take(m, points, sizeof *m->velocity);
    m->resistance = take(m, points, sizeof *m->resistance);
    m->places = take(m, (size_t)m->rod->jumps.count + 1, sizeof *m->places);
    m->frame = take(m, elements, sizeof *m->frame);
    return !m->lacks_memory;
}

void motion_free(motion *m)
{
    if (m) {
        for (int i = 0; i < m->owned_count; i++) {
            free(m->owned[i]);
        }
        free(m);
    }
}

static bool place_nodes(motion *m, const double *edges)
{
    int n = m->degree + 1, padded = m->blocks * LANES;
    double *derivative = malloc((size_t)(n * n) * sizeof *derivative);
    if (!derivative) {
        return false;
    }
    solve_lobatto_points(m->degree, m->abscissas, m->weights);
    solve_lobatto_derivative(m->degree, m->abscissas, derivative);
    for (int k = 0; k < n; k++) {
        for (int j = 0; j < n; j++) {
            m->derivative[j * padded + k] = derivative[k * n + j];
            m->transposed[j * padded + k] = derivative[j * n + k];
        }
    }
    free(derivative);
    for (int e = 0; e <= m->elements; e++) {
        m->edge[e] = edges ? edges[e] : (double)e / m->elements;
    }
    for (int e = 0; e < m->elements; e++) {
        double middle = 0.5 * (m->edge[e] + m->edge[e + 1]);
        double half = 0.5 * (m->edge[e + 1] - m->edge[e]);
        for (int k = 0; k < n; k++) {
            size_t node = (size_t)e * m->degree + k, point = (size_t)e * n + k;
            double inside = k == 0 && e > 0 ? SIDE : k == n - 1 && e + 1 < m->elements ? -SIDE : 0;
            m->s[node] = k == n - 1 ? m->edge[e + 1] : middle + half * m->abscissas[k];
            m->point_s[point] = m->s[node] + inside * half;
            m->point_weight[point] = half * m->weights[k];
            m->node_weight[node] += m->point_weight[point];
        }
    }
    return true;
}

/* Which point a lane of a block stands for. */
static size_t point_of(const motion *m, int element, int block, int lane)
{
    int k = block * LANES + lane;
    return (size_t)element * (m->degree + 1) + (k < m->degree ? k : m->degree);
}

static void set_block_material(motion *m, int element, int index, double lock)
{
    motion_block *to = &m->block[element * m->blocks + index];
    for (int lane = 0; lane < LANES; lane++) {
        size_t point = point_of(m, element, index, lane);
        const solve_section *made = &m->made[point];
        bool counts = index * LANES + lane <= m->degree;
        to->weight[lane] = counts ? m->point_weight[point] : 0;
        for (int i = 0; i < MOTION_STRAINS; i++) {
            to->stiffness[i][lane] = made->stiffness[i] > 0 ? made->stiffness[i] : lock;
            to->damping[i][lane] = made->damping[i];
            to->branch[i][lane] = made->maxwell_ratio * made->stiffness[i];
            m->relaxing[point * MOTION_STRAINS + (size_t)i] = made->maxwell_rate;
        }
        to->relaxing[lane] = made->maxwell_rate;
        m->has_branch |= made->maxwell_ratio > 0;
    }
}

static void set_rest_blocks(motion *m)
{
    for (int b = 0; b < m->elements * m->blocks; b++) {
        for (int lane = 0; lane < LANES; lane++) {
            const solve_rest *rest = &m->rest[point_of(m, b / m->blocks, b % m->blocks, lane)];
            for (int i = 0; i < 3; i++) {
                m->block[b].rest[i][lane] = rest->strain[i];
                m->block[b].rest[MOTION_U + i][lane] = rest->curvature[i];
            }
        }
    }
}

/* Mass and inertia at nodes. AD_BAD_INPUT without rotary inertia. */
static ad_status lump(motion *m, ad_error *error)
{
    int n = m->degree + 1;
    for (size_t point = 0; point < m->points; point++) {
        size_t node = (point / (size_t)n) * (size_t)m->degree + point % (size_t)n;
        const solve_section *made = &m->made[point];
        m->mass[node] += m->point_weight[point] * made->mass;
        for (int i = 0; i < 3; i++) {
            m->inertia[node][i] += m->point_weight[point] * made->rotary_inertia[i];
            m->is_damped |= made->damping[i] != 0 || made->damping[MOTION_U + i] != 0;
            if (!(made->rotary_inertia[i] > 0)) {
                return ad_fail(error, AD_BAD_INPUT,
                               "rotary inertia about d%d is %g in a dynamic scene; allowed: > 0",
                               i + 1, made->rotary_inertia[i]);
            }
        }
    }
    m->is_damped |= m->has_branch;
    motion_add_bodies(m);
    for (size_t node = 0; node < m->nodes; node++) {
        m->by_mass[node] = 1 / m->mass[node];
        for (int i = 0; i < 3; i++) {
            m->by_inertia[node][i] = 1 / m->inertia[node][i];
        }
    }
    return AD_OK;
}

static ad_status set_materials(motion *m, double lock, ad_error *error)
{
    ad_status status = solve_rod_sections(m->rod, m->points, m->point_s, m->made, error);
    for (int b = 0; status == AD_OK && b < m->elements * m->blocks; b++) {
        set_block_material(m, b / m->blocks, b % m->blocks, lock);
    }
    status = status == AD_OK ? lump(m, error) : status;
    if (status == AD_OK) {
        status = solve_rod_rest(m->rod, m->points, m->point_s, 0, m->rest, error);
    }
    if (status == AD_OK) {
        set_rest_blocks(m);
    }
    return status;
}

ad_status motion_create(const solve_rod *rod, double lock, int elements, const double *edges,
                        int degree, motion **result, ad_error *error)
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
        m->blocks = degree / LANES + 1;
        m->is_pulled = rod->actuators > 0;
        m->nodes = (size_t)elements * (size_t)degree + 1;
        m->points = (size_t)elements * ((size_t)degree + 1);
    }
    if (!m || !allocate(m) || !place_nodes(m, edges)) {
        motion_free(m);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a rod of %d elements", elements);
    }
    ad_status status = motion_place_jumps(m, error);
    status = status == AD_OK ? set_materials(m, lock, error) : status;
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
    return m->node_weight;
}

/* What dampers of branches have of strains of nodes that are set, once they have relaxed. */
static void relax(motion *m, double *memory)
{
    motion_internal_forces(m);
    for (size_t i = 0; i < m->points * MOTION_STRAINS; i++) {
        const int point = (int)(i / MOTION_STRAINS), n = m->degree + 1;
        const motion_block *at = motion_block_of(m, point / n, point % n);
        memory[i] = at->strain[i % MOTION_STRAINS][point % n % LANES] -
                    at->rest[i % MOTION_STRAINS][point % n % LANES];
    }
}

size_t motion_size(const motion *m)
{
    return m->nodes * MOTION_ROWS + (m->has_branch ? m->points * MOTION_STRAINS : 0);
}

const double *motion_relaxing(const motion *m, size_t *count)
{
    *count = m->has_branch ? m->points * MOTION_STRAINS : 0;
    return m->relaxing;
}

ad_status motion_initial(motion *m, double *state, ad_error *error)
{
    _Static_assert(sizeof(solve_initial) == MOTION_ROWS * sizeof(double), "the same rows");
    ad_status status = solve_rod_initial(m->rod, m->nodes, m->s, (solve_initial *)state, error);
    status = status == AD_OK ? motion_turn_initial(m, state, error) : status;
    status = status == AD_OK && m->has_branch ? motion_at(m, 0, error) : status;
    if (status == AD_OK && m->has_branch) {
        double *memory = state + m->nodes * MOTION_ROWS;
        memset(memory, 0, m->points * MOTION_STRAINS * sizeof *memory);
        motion_set_nodes(m, state);
        relax(m, memory);
    }
    return status;
}

ad_status motion_at(motion *m, double t, ad_error *error)
{
    if (m->has_time && m->time == t) {
        return AD_OK;
    }
    bool is_first = !m->has_time;
    ad_status status = AD_OK;
    m->has_time = false;
    if (is_first || m->rod->along_moves) {
        status = solve_rod_along(m->rod, m->points, m->point_s, t, m->along, error);
    }
    if (status == AD_OK && m->rod->rest_moves) {
        status = solve_rod_rest(m->rod, m->points, m->point_s, t, m->rest, error);
        set_rest_blocks(m);
    }
    if (status == AD_OK && (is_first || m->rod->jumps.loads_move)) {
        status = solve_rod_jump_numbers(m->rod, t, m->number, error);
    }
    if (status == AD_OK && m->is_pulled) {
        status = solve_rod_actuators(m->rod, m->points, m->point_s, t, m->actuators, error);
    }
    for (int i = 0; i < m->rod->actuators && status == AD_OK; i++) {
        m->displacement[i] = solve_rod_displacement(m->rod, i, t);
    }
    for (int end = 0; end < 2 && status == AD_OK; end++) {
        if (is_first || m->rod->ends[end].moves) {
            status = solve_rod_end(m->rod, end, t, &m->ends[end], error);
        }
    }
    m->time = t;
    m->has_time = status == AD_OK;
    return status;
}

/* ---- what ends prescribe ------------------------------------------------------------------- */

void motion_hold_part(const motion *m, int end, const double *position, const double *velocity,
                      double *r, double *v)
{
    const scene_hold *hold = &m->rod->ends[end].hold;
    double off[2][3], held[2][3];
    for (int k = 0; k < 3; k++) {
        off[0][k] = r[k] - position[k];
        off[1][k] = v[k] - velocity[k];
    }
    scene_hold_part(hold, off[0], held[0]);
    scene_hold_part(hold, off[1], held[1]);
    for (int k = 0; k < 3; k++) {
        r[k] = hold->directions == 3 ? position[k] : r[k] - held[0][k];
        v[k] = hold->directions == 3 ? velocity[k] : v[k] - held[1][k];
    }
}

void motion_prescribe(const motion *m, double *state)
{
    for (int end = 0; end < 2; end++) {
        double *node = state + motion_end_node(m, end) * MOTION_ROWS;
        motion_hold_part(m, end, m->ends[end].position, m->ends[end].velocity, node + MOTION_R,
                         node + MOTION_V);
        if (m->rod->ends[end].holds_rotation) {
            memcpy(node + MOTION_Q, m->ends[end].rotation, 4 * sizeof(double));
            memcpy(node + MOTION_W, m->ends[end].spin, 3 * sizeof(double));
        }
    }
    for (size_t i = 0; i < m->nodes; i++) {
        quaternion_normalize(state + i * MOTION_ROWS + MOTION_Q);
    }
}
