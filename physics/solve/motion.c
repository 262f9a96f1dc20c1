#include "physics/solve/motion_internal.h"

#include "physics/solve/lobatto.h"
#include "physics/solve/quaternion.h"

#include <stdlib.h>
#include <string.h>

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
    m->velocity = calloc(nodes, sizeof *m->velocity);
    m->resistance = calloc(nodes, sizeof *m->resistance);
    return m->points && m->point_weights && m->derivative && m->transposed && m->s && m->weight &&
           m->element_weight && m->materials && m->rest && m->load && m->pose && m->flow &&
           m->spin && m->R && m->slope && m->slope_rate && m->wrench && m->sections && m->force &&
           m->torque && m->push && m->turn && m->velocity && m->resistance;
}

void motion_free(motion *m)
{
    if (m) {
        void *all[] = {m->points, m->point_weights,  m->derivative, m->transposed, m->s,
                       m->weight, m->element_weight, m->rest,       m->load,       m->pose,
                       m->flow,   m->spin,           m->R,          m->slope,      m->slope_rate,
                       m->wrench, m->sections,       m->force,      m->torque,     m->push,
                       m->turn,   m->materials,      m->velocity,   m->resistance};
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
    solve_lobatto_points(m->degree, m->points, m->point_weights);
    solve_lobatto_derivative(m->degree, m->points, m->derivative);
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
    motion_material *to = &m->materials[node];
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

bool motion_is_held(const motion *m, size_t node, int row)
{
    bool of_rotation = (row >= MOTION_Q && row < MOTION_V) || row >= MOTION_W;
    for (int end = 0; end < 2; end++) {
        const solve_end *given = &m->rod->ends[end];
        if (node == motion_end_node(m, end) &&
            (of_rotation ? given->holds_rotation : given->holds_position)) {
            return true;
        }
    }
    return false;
}

void motion_prescribe(const motion *m, double *state)
{
    for (int end = 0; end < 2; end++) {
        double *node = state + motion_end_node(m, end) * MOTION_ROWS;
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
