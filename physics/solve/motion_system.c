#include "physics/solve/motion_system.h"

#include "autodiff/dense.h"
#include "autodiff/memory.h"
#include "physics/numerics/quaternion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { UNKNOWNS = 6 }; /* V, w at a node */

struct motion_system {
    motion *motion;
    size_t nodes;
    double gamma;
    double *factors; /* [6 nodes][6 nodes], column-major */
    int *pivots;     /* [6 nodes] */
    double *state;   /* [motion_size] */
    double *rate;    /* its rate */
    double (*R)[3][3];
    double *moved, *moved_rate;
    double *change; /* of V and w, in the frames of the bodies [6 nodes] */
    SUNMatrix matrix;
    SUNLinearSolver solver;
    ad_memory memory;
};

/* dq of the quaternion's equation dq - gamma/2 dq (0, w) = b + gamma/2 q (0, dw). */
static void solve_rotation(double gamma, const double *state, const double *b, const double *dw,
                           double *dq)
{
    const double *w = state + MOTION_W;
    const double back[4] = {1, 0.5 * gamma * w[0], 0.5 * gamma * w[1], 0.5 * gamma * w[2]};
    double right[4], norm = 1 + 0.25 * gamma * gamma * vector_dot(w, w);
    quaternion_times_vector(state + MOTION_Q, dw, right);
    for (int i = 0; i < 4; i++) {
        right[i] = (b ? b[i] : 0) + 0.5 * gamma * right[i];
    }
    quaternion_product(right, back, dq);
    for (int i = 0; i < 4; i++) {
        dq[i] /= norm;
    }
}

/* ---- forming ------------------------------------------------------------------------------- */

/* Change of position or angle for difference quotients: errors of rounding and of curvature are
 * both small beside what an approximate Newton step tolerates. */
static const double displacement = 1e-7;

/* Move node `node` along unknown `which`. */
static void move_node(motion_system *n, size_t node, int which, double by)
{
    const double *state = n->state + node * MOTION_ROWS;
    double *to = n->moved + node * MOTION_ROWS;
    double along[UNKNOWNS] = {0}, dq[4], dV[3];
    along[which] = by;
    to_world(n->R[node], along, dV);
    solve_rotation(n->gamma, state, NULL, along + 3, dq);
    for (int i = 0; i < 3; i++) {
        to[MOTION_R + i] += n->gamma * dV[i];
        to[MOTION_V + i] += dV[i];
        to[MOTION_W + i] += along[3 + i];
    }
    for (int i = 0; i < 4; i++) {
        to[MOTION_Q + i] += dq[i];
    }
}

/* to [UNKNOWNS] += factor times the change of acceleration at a node, in the frame of its body. */
static void add_acceleration(const motion_system *n, size_t node, double factor, double *to)
{
    const double *moved = n->moved_rate + node * MOTION_ROWS, *rate = n->rate + node * MOTION_ROWS;
    double dV[3], body[3];
    for (int i = 0; i < 3; i++) {
        dV[i] = moved[MOTION_V + i] - rate[MOTION_V + i];
        to[3 + i] += factor * (moved[MOTION_W + i] - rate[MOTION_W + i]);
    }
    to_body(n->R[node], dV, body);
    for (int i = 0; i < 3; i++) {
        to[i] += factor * body[i];
    }
}

/* n->moved becomes the state, with z as motion_rate_following has it. */
static void begin_to_move(motion_system *n)
{
    const size_t memory = n->nodes * MOTION_ROWS, size = motion_size(n->motion);
    memcpy(n->moved, n->state, size * sizeof *n->moved);
    for (size_t i = memory; i < size; i++) {
        n->moved[i] -= n->gamma * n->rate[i];
    }
}

/* Columns of the nodes first, first + stride, ...: no two share an element. */
static void form_columns(motion_system *n, size_t first, size_t stride, int which)
{
    double by = displacement / n->gamma;
    size_t size = n->nodes * UNKNOWNS;
    begin_to_move(n);
    for (size_t node = first; node < n->nodes; node += stride) {
        move_node(n, node, which, by);
    }
    motion_rate_following(n->motion, n->gamma, n->moved, n->moved_rate);
    size_t reach = (size_t)motion_degree(n->motion);
    for (size_t node = first; node < n->nodes; node += stride) {
        double *column = n->factors + (node * UNKNOWNS + (size_t)which) * size;
        size_t from = node > reach ? node - reach : 0;
        size_t to = node + reach < n->nodes ? node + reach : n->nodes - 1;
        for (size_t i = from; i <= to; i++) {
            add_acceleration(n, i, -n->gamma / by, column + i * UNKNOWNS);
        }
        column[node * UNKNOWNS + (size_t)which] += 1;
    }
}

void motion_system_at(motion_system *n, const double *state, const double *rate)
{
    memcpy(n->state, state, motion_size(n->motion) * sizeof *state);
    memcpy(n->rate, rate, motion_size(n->motion) * sizeof *rate);
    motion_prescribe(n->motion, n->state);
    for (size_t i = 0; i < n->nodes; i++) {
        rotation_matrix(n->state + i * MOTION_ROWS + MOTION_Q, n->R[i]);
    }
}

int motion_system_form(motion_system *n, double gamma)
{
    size_t size = n->nodes * UNKNOWNS, stride = 2 * (size_t)motion_degree(n->motion) + 1;
    n->gamma = gamma;
    memset(n->factors, 0, size * size * sizeof *n->factors);
    for (size_t first = 0; first < stride && first < n->nodes; first++) {
        for (int which = 0; which < UNKNOWNS; which++) {
            form_columns(n, first, stride, which);
        }
    }
    return ad_dense_lu(size, n->factors, n->pivots);
}

/* ---- solving ------------------------------------------------------------------------------- */

/* How far b, the right sides of position, rotation and z, moves the rod where V and w do not
 * change: n->moved_rate; the largest move. */
static double move_freely(motion_system *n, const double *b)
{
    static const double still[3] = {0};
    double largest = 0;
    for (size_t i = 0; i < n->nodes * MOTION_ROWS; i += MOTION_ROWS) {
        double *move = n->moved_rate + i;
        memcpy(move + MOTION_R, b + i + MOTION_R, 3 * sizeof(double));
        solve_rotation(n->gamma, n->state + i, b + i + MOTION_Q, still, move + MOTION_Q);
        for (int k = 0; k < MOTION_V; k++) {
            largest = fmax(largest, fabs(move[k]));
        }
    }
    for (size_t i = n->nodes * MOTION_ROWS; i < motion_size(n->motion); i++) {
        n->moved_rate[i] = b[i];
        largest = fmax(largest, fabs(b[i]));
    }
    return largest;
}

/* n->change += gamma K move, by a difference quotient along n->moved_rate. */
static void add_stiffness(motion_system *n, double largest)
{
    double by = displacement / largest;
    begin_to_move(n);
    for (size_t i = 0; i < motion_size(n->motion); i++) {
        const bool moves = i >= n->nodes * MOTION_ROWS || i % MOTION_ROWS < MOTION_V;
        n->moved[i] += moves ? by * n->moved_rate[i] : 0;
    }
    motion_rate_following(n->motion, n->gamma, n->moved, n->moved_rate);
    for (size_t i = 0; i < n->nodes; i++) {
        add_acceleration(n, i, n->gamma / by, n->change + i * UNKNOWNS);
    }
}

/* x = [b + gamma (dV, dw) in position and rotation; dV, dw], bodies' frames to the world's. */
static void finish(const motion_system *n, const double *b, double *x)
{
    for (size_t i = 0; i < n->nodes; i++) {
        const double *from = b + i * MOTION_ROWS, *dv = n->change + i * UNKNOWNS;
        double *to = x + i * MOTION_ROWS;
        to_world(n->R[i], dv, to + MOTION_V);
        memcpy(to + MOTION_W, dv + 3, 3 * sizeof(double));
        solve_rotation(n->gamma, n->state + i * MOTION_ROWS, from + MOTION_Q, dv + 3,
                       to + MOTION_Q);
        for (int k = 0; k < 3; k++) {
            to[MOTION_R + k] = from[MOTION_R + k] + n->gamma * to[MOTION_V + k];
        }
    }
}

/* z of x = b + gamma z_t, as strains and z change by x. */
static void finish_memory(motion_system *n, const double *b, double *x)
{
    const size_t first = n->nodes * MOTION_ROWS;
    size_t count;
    const double *relaxing = motion_relaxing(n->motion, &count);
    double largest = 0;
    for (size_t i = 0; i < first && count > 0; i++) {
        largest = i % MOTION_ROWS < MOTION_V ? fmax(largest, fabs(x[i])) : largest;
    }
    const double by = largest > 0 ? displacement / largest : 1;
    memcpy(n->moved, n->state, motion_size(n->motion) * sizeof *n->moved);
    for (size_t i = 0; i < first && count > 0; i++) {
        n->moved[i] += i % MOTION_ROWS < MOTION_V ? by * x[i] : 0;
    }
    if (count > 0) {
        motion_rate(n->motion, n->moved, n->moved_rate);
    }
    for (size_t i = 0; i < count; i++) {
        const double change = (n->moved_rate[first + i] - n->rate[first + i]) / by;
        x[first + i] = (b[first + i] + n->gamma * change) / (1 + n->gamma * relaxing[i]);
    }
}

static void solve(motion_system *n, const double *b, double *x)
{
    for (size_t i = 0; i < n->nodes; i++) {
        const double *from = b + i * MOTION_ROWS;
        to_body(n->R[i], from + MOTION_V, n->change + i * UNKNOWNS);
        memcpy(n->change + i * UNKNOWNS + 3, from + MOTION_W, 3 * sizeof(double));
    }
    double move = move_freely(n, b);
    if (move > 0) {
        add_stiffness(n, move);
    }
    ad_dense_lu_solve(n->nodes * UNKNOWNS, 1, n->factors, n->pivots, n->change);
    finish(n, b, x);
    finish_memory(n, b, x);
}

/* ---- for SUNDIALS -------------------------------------------------------------------------- */

static SUNMatrix_ID matrix_id(SUNMatrix matrix)
{
    (void)matrix;
    return SUNMATRIX_CUSTOM;
}

static SUNLinearSolver_Type solver_type(SUNLinearSolver solver)
{
    (void)solver;
    return SUNLINEARSOLVER_DIRECT;
}

static int solver_setup(SUNLinearSolver solver, SUNMatrix matrix)
{
    (void)solver;
    (void)matrix;
    return 0; /* motion_system_form has the factors */
}

static int solver_solve(SUNLinearSolver solver, SUNMatrix matrix, N_Vector x, N_Vector b,
                        realtype tolerance)
{
    (void)matrix;
    (void)tolerance;
    solve(solver->content, N_VGetArrayPointer(b), N_VGetArrayPointer(x));
    return 0;
}

static ad_status make_shells(motion_system *n, SUNContext context, ad_error *error)
{
    n->matrix = SUNMatNewEmpty(context);
    n->solver = SUNLinSolNewEmpty(context);
    if (!n->matrix || !n->solver) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for SUNDIALS");
    }
    n->matrix->ops->getid = matrix_id;
    n->solver->ops->gettype = solver_type;
    n->solver->ops->setup = solver_setup;
    n->solver->ops->solve = solver_solve;
    n->solver->content = n;
    return AD_OK;
}

ad_status motion_system_create(motion *m, SUNContext context, motion_system **result,
                               ad_error *error)
{
    *result = NULL;
    if (ad_dense_load(error) != AD_OK) {
        return AD_NO_BLAS;
    }
    motion_system *n = calloc(1, sizeof *n);
    if (!n) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for linear systems");
    }
    size_t nodes = motion_nodes(m), size = nodes * UNKNOWNS, rows = motion_size(m);
    *n = (motion_system){.motion = m, .nodes = nodes};
    AD_TAKE(n, factors, size * size);
    AD_TAKE(n, pivots, size);
    AD_TAKE(n, state, rows);
    AD_TAKE(n, rate, rows);
    AD_TAKE(n, R, nodes);
    AD_TAKE(n, moved, rows);
    AD_TAKE(n, moved_rate, rows);
    AD_TAKE(n, change, size);
    ad_status status = ad_memory_status(&n->memory, error, "out of memory for linear systems");
    status = status == AD_OK ? make_shells(n, context, error) : status;
    if (status != AD_OK) {
        motion_system_free(n);
        return status;
    }
    *result = n;
    return AD_OK;
}

void motion_system_free(motion_system *n)
{
    if (n) {
        if (n->matrix) {
            SUNMatFreeEmpty(n->matrix);
        }
        if (n->solver) {
            SUNLinSolFreeEmpty(n->solver);
        }
        ad_memory_free(&n->memory);
        free(n);
    }
}

SUNMatrix motion_system_matrix(motion_system *n)
{
    return n->matrix;
}

SUNLinearSolver motion_system_solver(motion_system *n)
{
    return n->solver;
}
