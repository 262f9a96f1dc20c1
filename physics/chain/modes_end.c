/* The end of a reduced rod that is held, slides or is driven: a loop that is closed.
 *
 * Where the end holds its place, in all directions or in some (scene_hold), and its rotation,
 * reactions f and m of what holds it act there. They stand behind the modes as further entries of
 * the accelerations, and behind the equations of motion stands what the end is off by:
 *
 *   M(q) q_tt + c(q, q_t) - loads - G^T (f, m) = 0,   g(q, t) + T g_t = 0,   G = dg/dq
 *
 * with g the parts of the displacement and of twice the vector of the turn from what is
 * prescribed, in the world, so that G has the rows of theta and rho at the tip, and the reactions
 * are one more load there. A start with g = 0 keeps g = 0, and what steps leave of it fades within
 * T (Baumgarte, Comput. Methods Appl. Mech. Eng. 1, 1972). With T = 0 the index of these
 * differential-algebraic equations would be 3, and rates have an error of rounding over the step;
 * so it is 2, for which Radau's methods keep their order in modes and rates (Hairer, Lubich, Roche,
 * The Numerical Solution of Differential-Algebraic Systems by Runge-Kutta Methods, 1989).
 *
 * Directions in which no mode ever moves the end, as those out of the plane of modes that are in
 * one, have no reaction. */
#include "autodiff/dense.h"
#include "physics/chain/modes_internal.h"

#include <math.h>
#include <string.h>

/* Of squares of what modes move the end by: what is smaller beside the largest is rounding. */
static const double NOTHING = 1e-14;

/* T: what a rate counts for beside what the end is off by, in units of time. */
static const double RATE_COUNTS = 0.02;

/* x along the directions that the end holds: force and moment, or displacement and turn. */
static void held_part(const solve_end *end, const double x[6], double part[6])
{
    scene_hold_part(&end->hold, x, part);
    for (int k = 3; k < 6; k++) {
        part[k] = end->holds_rotation ? x[k] : 0;
    }
}

int modes_end_directions(const solve_rod *rod)
{
    return rod->ends[1].hold.directions + (rod->ends[1].holds_rotation ? 3 : 0);
}

/* Rows of displacement and turn of the end, i of 6, by the modes. */
static const double *row_of(const modes *m, int i)
{
    const double *rows = i < 3 ? m->rho : m->theta;
    return rows + ((m->points - 1) * 3 + i % 3) * m->width;
}

/* What mode a moves the end by in direction k of those held. */
static double moved_by(const modes *m, int k, int a)
{
    double sum = 0;
    for (int i = 0; i < 6; i++) {
        sum += m->end.hold[k][i] * row_of(m, i)[a];
    }
    return sum;
}

/* ---- making -------------------------------------------------------------------------------- */

/* The sum over a few shapes without a pattern of G G^T [6][6], in directions that the end holds. */
static void sum_directions(modes *m, double *sum)
{
    enum { SHAPES = 3 };
    const double most = 0.6;
    double *q = m->feed.trial, *v = q + m->size;
    unsigned seed = 1;
    memset(v, 0, (size_t)m->size * sizeof *v);
    memset(sum, 0, 36 * sizeof *sum);
    for (int shape = 0; shape < SHAPES; shape++) {
        for (int a = 0; a < m->size; a++) {
            seed = seed * 1664525U + 1013904223U;
            q[a] = most * ((double)seed / 4294967296.0 - 0.5);
        }
        modes_shape(m, q, v, NULL);
        modes_mass(m);
        for (int a = 0; a < m->end.first; a++) {
            double moved[6], held[6];
            for (int i = 0; i < 6; i++) {
                moved[i] = row_of(m, i)[a];
            }
            held_part(&m->rod->ends[1], moved, held);
            for (int i = 0; i < 36; i++) {
                sum[i] += held[i / 6] * held[i % 6];
            }
        }
    }
}

ad_status modes_end_find(modes *m, ad_error *error)
{
    struct modes_end *end = &m->end;
    double sum[36], directions[36], most = 0;
    if (end->directions == 0) {
        return AD_OK;
    }
    sum_directions(m, sum);
    ad_dense_diagonalize(6, sum, directions);
    for (int k = 0; k < 6; k++) {
        most = fmax(most, sum[7 * k]);
    }
    for (int k = 0; k < 6; k++) {
        if (sum[7 * k] > NOTHING * most) {
            held_part(&m->rod->ends[1], directions + 6 * k, end->hold[end->count++]);
        }
    }
    m->size = end->first + end->count;
    return end->count < end->first
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "method modes: %d modes, and boundary.end holds %d directions of them; "
                         "allowed: more modes than that",
                         end->first, end->count);
}

/* ---- at a state ---------------------------------------------------------------------------- */

void modes_end_given(modes *m)
{
    solve_end_state *given = &m->end.given;
    double R[3][3];
    quaternion_normalize(given->rotation);
    rotation_matrix(given->rotation, R);
    to_world(R, given->spin, m->end.spin);
    to_world(R, given->spin_rate, m->end.spin_rate);
}

void modes_end_react(modes *m, const double *a)
{
    for (int i = 0; i < 6; i++) {
        m->end.reaction[i] = 0;
        for (int k = 0; k < m->end.count && a; k++) {
            m->end.reaction[i] += m->end.hold[k][i] * a[m->end.first + k];
        }
    }
}

void modes_end_push(modes *m)
{
    modes_point *tip = &m->point[m->points - 1];
    for (int k = 0; k < 3; k++) {
        tip->force[k] += m->end.reaction[k];
        tip->moment[k] += m->end.reaction[3 + k];
    }
}

/* The turn from what is prescribed to q, a quaternion in the world with w >= 0. */
static void turn_off(const modes *m, const double q[4], double turn[4])
{
    const double *p = m->end.given.rotation, back[4] = {p[0], -p[1], -p[2], -p[3]};
    quaternion_product(q, back, turn);
    for (int k = 3; k >= 0; k--) {
        turn[k] *= turn[0] < 0 ? -1 : 1;
    }
}

/* Displacement and turn of a pose beyond what is prescribed, in all directions. */
static void find_off(const modes *m, const double r[3], const double q[4], double off[6])
{
    double turn[4];
    turn_off(m, q, turn);
    for (int k = 0; k < 3; k++) {
        off[k] = r[k] - m->end.given.position[k];
        off[3 + k] = 2 * turn[1 + k];
    }
}

static double along(const modes *m, int k, const double x[6])
{
    return vector_dot(m->end.hold[k], x) + vector_dot(m->end.hold[k] + 3, x + 3);
}

double modes_end_off_at(const modes *m, const double r[3], const double q[4])
{
    double off[6], held[6], most = 0;
    find_off(m, r, q, off);
    held_part(&m->rod->ends[1], off, held);
    for (int i = 0; i < 6; i++) {
        most = fabs(held[i]) > most || isnan(held[i]) ? fabs(held[i]) : most;
    }
    return m->end.directions > 0 ? most : 0;
}

double modes_end_off(const modes *m)
{
    const modes_point *tip = &m->point[m->points - 1];
    return modes_end_off_at(m, tip->r, tip->q);
}

void modes_end_residual(const modes *m, double *residual)
{
    const modes_point *tip = &m->point[m->points - 1];
    double off[6], slow[6];
    find_off(m, tip->r, tip->q, off);
    modes_end_missing(m, 1, slow);
    for (int k = 0; k < m->end.count; k++) {
        residual[m->end.first + k] = along(m, k, off) - RATE_COUNTS * along(m, k, slow);
    }
}

void modes_end_keep(modes *m, const double *spin, const double *velocity)
{
    const size_t size = 3 * (size_t)m->width * sizeof *velocity;
    memcpy(m->end.faster, velocity, size);
    memcpy(m->end.faster + 3 * m->width, spin, size);
}

void modes_end_derivatives(modes *m, double *by_q, double *by_v)
{
    const int first = m->end.first, width = m->width;
    double turn[4];
    turn_off(m, m->point[m->points - 1].q, turn);
    for (int a = 0; a < first; a++) {
        double moved[6], theta[3], across[3];
        for (int i = 0; i < 3; i++) {
            moved[i] = row_of(m, i)[a];
            theta[i] = row_of(m, 3 + i)[a];
        }
        vector_cross(theta, turn + 1, across); /* 2 turn_t = (0, w) turn */
        for (int i = 0; i < 3; i++) {
            moved[3 + i] = turn[0] * theta[i] + across[i];
        }
        for (int i = 0; i < 6; i++) {
            moved[i] += RATE_COUNTS * m->end.faster[i * width + a];
        }
        for (int k = 0; k < m->end.count; k++) {
            const double by = moved_by(m, k, a);
            by_q[(first + k) * width + a] = along(m, k, moved);
            by_v[(first + k) * width + a] = RATE_COUNTS * by;
            m->mass[a * width + first + k] = -by;
        }
    }
}

double modes_end_power(const modes *m)
{
    return vector_dot(m->end.reaction, m->end.given.velocity) +
           vector_dot(m->end.reaction + 3, m->end.spin);
}

/* ---- holding ------------------------------------------------------------------------------- */

ad_status modes_end_fail(ad_error *error)
{
    return ad_fail(error, AD_NOT_FINITE,
                   "boundary.end: the modes do not move the end in every direction in which it is "
                   "held, as those of a straight rod that does not stretch; allowed: a rod that "
                   "stretches, more modes, or an end that slides");
}

void modes_end_missing(const modes *m, int derivative, double missing[6])
{
    const modes_point *tip = &m->point[m->points - 1];
    const solve_end_state *given = &m->end.given;
    double off[6];
    find_off(m, tip->r, tip->q, off);
    for (int k = 0; k < 3; k++) {
        missing[k] = derivative == 0   ? -off[k]
                     : derivative == 1 ? given->velocity[k] - tip->velocity[k]
                                       : given->acceleration[k] - tip->acceleration[k];
        missing[3 + k] = derivative == 0   ? -off[3 + k]
                         : derivative == 1 ? m->end.spin[k] - tip->spin[k]
                                           : m->end.spin_rate[k] - tip->spin_rate[k];
    }
}

/* G [count][size] but for modes that drives move, which nothing else does. */
static void find_rows(const modes *m, double *rows)
{
    for (int k = 0; k < m->end.count; k++) {
        for (int a = 0; a < m->size; a++) {
            rows[k * m->size + a] = a < m->end.first ? moved_by(m, k, a) : 0;
        }
        for (int drive = 0; drive < MODES_DRIVES; drive++) {
            if (modes_driven(m, drive) >= 0) {
                rows[k * m->size + modes_driven(m, drive)] = 0;
            }
        }
    }
}

bool modes_end_hold(modes *m, const double *factor, const double missing[6], double *x,
                    double *reaction)
{
    const int n = m->size, count = m->end.count;
    double *by = m->end.room, *moves = by + count * n; /* G; M^-1 G^T */
    double matrix[36], right[6], most = 0, least = INFINITY;
    find_rows(m, by);
    for (int k = 0; k < count; k++) {
        memcpy(moves + k * n, by + k * n, (size_t)n * sizeof *by);
        modes_solve_factored(m, factor, moves + k * n);
    }
    for (int i = 0; i < count; i++) {
        right[i] = along(m, i, missing);
        for (int a = 0; a < n; a++) {
            right[i] -= by[i * n + a] * x[a];
        }
        for (int k = 0; k <= i; k++) {
            double sum = 0;
            for (int a = 0; a < n; a++) {
                sum += by[i * n + a] * moves[k * n + a];
            }
            matrix[i * count + k] = sum;
        }
        most = fmax(most, matrix[i * count + i]);
    }
    m->end.freedom = 0;
    if (!modes_factor(count, count, matrix)) {
        return false;
    }
    for (int k = 0; k < count; k++) {
        least = fmin(least, pow(matrix[k * count + k], 2));
    }
    if (!(least > NOTHING * most)) {
        return false;
    }
    m->end.freedom = least;
    modes_back(count, count, matrix, right);
    for (int k = 0; k < count; k++) {
        for (int a = 0; a < n; a++) {
            x[a] += moves[k * n + a] * right[k];
        }
        if (reaction) {
            reaction[k] = right[k];
        }
    }
    return true;
}

/* ---- motions that leave the end where it is ------------------------------------------------ */

/* Rows G [count][size] become such that each has a 1 in a column of its own, where the others have
 * 0: pivot [count]. */
static void reduce_rows(const modes *m, double *rows, int *pivot)
{
    const int n = m->size, count = m->end.count;
    bool is_used[6] = {false};
    for (int step = 0; step < count; step++) {
        int row = -1, column = 0;
        for (int r = 0; r < count; r++) {
            for (int c = 0; c < m->end.first && !is_used[r]; c++) {
                const bool more = row < 0 || fabs(rows[r * n + c]) > fabs(rows[row * n + column]);
                row = more ? r : row;
                column = more ? c : column;
            }
        }
        is_used[row] = true;
        pivot[row] = column;
        const double by = 1 / rows[row * n + column];
        for (int c = 0; c < n; c++) {
            rows[row * n + c] *= by;
        }
        for (int r = 0; r < count; r++) {
            const double part = r == row ? 0 : rows[r * n + column];
            for (int c = 0; c < n && part != 0; c++) {
                rows[r * n + c] -= part * rows[row * n + c];
            }
        }
    }
}

int modes_end_free(modes *m, int count, double *const *matrices)
{
    const int n = m->end.first, width = m->width, held = m->end.count;
    double *rows = m->end.room;
    int pivot[6], at = 0, *of = m->end.free;
    find_rows(m, rows);
    reduce_rows(m, rows, pivot);
    for (int a = 0; a < n; a++) {
        bool follows = false;
        for (int k = 0; k < held; k++) {
            follows |= pivot[k] == a;
        }
        of[at] = a;
        at += !follows;
    }
    for (int i = 0; i < count; i++) {
        double *x = matrices[i];
        for (int k = 0; k < held; k++) { /* the modes that follow move by minus these rows */
            for (int j = 0; j < at; j++) {
                const double by = rows[k * m->size + of[j]];
                for (int r = 0; r < n; r++) {
                    x[r * width + of[j]] -= by * x[r * width + pivot[k]];
                }
            }
        }
        for (int k = 0; k < held; k++) {
            for (int j = 0; j < at; j++) {
                const double by = rows[k * m->size + of[j]];
                for (int c = 0; c < n; c++) {
                    x[of[j] * width + c] -= by * x[pivot[k] * width + c];
                }
            }
        }
        for (int r = 0; r < at; r++) {
            for (int c = 0; c < at; c++) {
                x[r * width + c] = x[of[r] * width + of[c]];
            }
        }
    }
    return at;
}
