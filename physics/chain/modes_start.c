/* How a reduced rod starts: modes that come nearest to a shape and its motion. */
#include "physics/chain/modes_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool modes_factor(int n, int width, double *A)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = A[i * width + j];
            for (int k = 0; k < j; k++) {
                sum -= A[i * width + k] * A[j * width + k];
            }
            if (i == j && !(sum > 0)) {
                return false;
            }
            A[i * width + j] = i == j ? sqrt(sum) : sum / A[j * width + j];
        }
    }
    return true;
}

void modes_back(int n, int width, const double *L, double *x)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) {
            x[i] -= L[i * width + k] * x[k];
        }
        x[i] /= L[i * width + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++) {
            x[i] -= L[k * width + i] * x[k];
        }
        x[i] /= L[i * width + i];
    }
}

/* x [size]: the right side, then the solution of a positive definite matrix [size rows of width],
 * of which the lower triangle counts and is overwritten; false: it is not. */
static bool solve_positive(const modes *m, double *matrix, double *x)
{
    const bool done = modes_factor(m->size, m->width, matrix);
    if (done) {
        modes_back(m->size, m->width, matrix, x);
    }
    return done;
}

void modes_solve_factored(const modes *m, const double *matrix, double *x)
{
    modes_back(m->size, m->width, matrix, x);
}

/* Adds a row [size], which counts `by` and is off by `off`, to normal equations: the lower triangle
 * of matrix [size rows of width], right [size]. */
static void add_row(const modes *m, double by, const double *row, double off, double *matrix,
                    double *right)
{
    for (int a = 0; a < m->size; a++) {
        right[a] += by * row[a] * off;
        for (int b = 0; b <= a; b++) {
            matrix[a * m->width + b] += by * row[a] * row[b];
        }
    }
}

/* By how much a point is off in displacement and turn (or velocity and spin), world. */
static double point_off(const modes_point *at, const solve_initial *given, bool moving,
                        double off[6])
{
    double turn[4], vector[3], R[3][3], size = 0;
    memcpy(R, at->R, sizeof R);
    if (moving) {
        to_world(R, given->spin, vector);
        for (int k = 0; k < 3; k++) {
            off[k] = given->velocity[k] - at->velocity[k];
            off[3 + k] = vector[k] - at->spin[k];
        }
    } else {
        quaternion_quotient(at->q, given->rotation, turn);
        const double length = sqrt(vector_dot(turn + 1, turn + 1));
        const double by = length > 1e-8 ? 2 * atan2(length, fabs(turn[0])) / length : 2;
        for (int k = 0; k < 3; k++) {
            vector[k] = copysign(by, turn[0]) * turn[1 + k];
            off[k] = given->position[k] - at->r[k];
        }
        to_world(R, vector, off + 3);
    }
    for (int k = 0; k < 6; k++) {
        size = fmax(size, fabs(off[k]));
    }
    return size;
}

/* A mode, unless -1, is not sought: its column and row of a matrix [size rows of width]. */
static void leave(const modes *m, int mode, double *matrix, double *right)
{
    for (int a = 0; a < m->size && mode >= 0; a++) {
        matrix[a * m->width + mode] = matrix[mode * m->width + a] = a == mode;
    }
    if (mode >= 0) {
        right[mode] = 0;
    }
}

/* Reactions of a held end are not sought; nor are, of rods that drives move, their modes. */
static void leave_reactions(const modes *m, double *matrix, double *right)
{
    for (int k = m->end.first; k < m->size; k++) {
        leave(m, k, matrix, right);
    }
}

static void leave_drives(const modes *m, double *matrix, double *right)
{
    for (int drive = 0; drive < MODES_DRIVES; drive++) {
        leave(m, modes_driven(m, drive), matrix, right);
    }
}

/* As much as is out at the present time and inputs. */
static void begin_feed(const modes *m, double *q, double *v)
{
    const struct modes_feed *feed = &m->feed;
    if (feed->mode >= 0) {
        const bool follows = feed->input >= 0;
        q[feed->mode] = follows ? (feed->command - feed->from) / feed->unit : feed->wanted[0];
        v[feed->mode] = follows ? 0 : feed->wanted[1];
    }
}

/* Of the unstressed rod at a point: weights along it are the same by whatever length s is measured.
 */
static double length_at(const modes_point *at)
{
    return at->weight * sqrt(vector_dot(at->rest + MODES_V, at->rest + MODES_V));
}

/* The normal equations of the points' `off`; returns the largest. */
static double normal_equations(modes *m, const solve_initial *given, bool moving, double *matrix,
                               double *right)
{
    const int n = m->size, width = m->width;
    double most = 0, length = 0;
    memset(matrix, 0, (size_t)(n * width) * sizeof *matrix);
    memset(right, 0, (size_t)n * sizeof *right);
    for (int p = 0; p < m->points; p++) {
        length += length_at(&m->point[p]);
    }
    for (int p = 0; p < m->points; p++) {
        double off[6];
        const double weight = length_at(&m->point[p]), turn = MODES_TURN * length * length;
        const double *rho = m->rho + p * 3 * width, *theta = m->theta + p * 3 * width;
        if (weight > 0) {
            most = fmax(most, point_off(&m->point[p], &given[p], moving, off));
        }
        for (int k = 0; k < 6 && weight > 0; k++) {
            const double *row = k < 3 ? rho + k * width : theta + (k - 3) * width;
            add_row(m, weight * (k < 3 ? 1 : turn), row, off[k], matrix, right);
        }
    }
    leave_reactions(m, matrix, right);
    leave(m, m->feed.mode, matrix, right); /* a base that is turned is so by its drive after all */
    return most;
}

/* ---- a held end ---------------------------------------------------------------------------- */

/* To the mass what strains resist with: of the modes that move an end as much as they should those
 * are wanted that store little, so that no stretch makes up for what is left of bending. */
static void add_stiffness(const modes *m, double *matrix)
{
    for (int p = 0; p < m->points; p++) {
        const modes_point *at = &m->point[p];
        for (int a = 0; a < m->end.first && at->weight > 0; a++) {
            const double value = m->value[p * m->width + a];
            matrix[a * m->width + a] +=
                at->weight * at->stiffness[m->mode[a].strain] * value * value;
        }
    }
}

/* How x [size] has to change for the end to move by what is missing of the derivative-th of its
 * motion as it is; work: matrix [size][width]. */
static bool change_end(modes *m, int derivative, double *matrix, double *x)
{
    double missing[6];
    modes_mass(m);
    memcpy(matrix, m->mass, (size_t)(m->size * m->width) * sizeof *matrix);
    memset(x, 0, (size_t)m->size * sizeof *x);
    if (derivative == 0) {
        add_stiffness(m, matrix);
    }
    leave_reactions(m, matrix, x);
    leave_drives(m, matrix, x);
    modes_end_missing(m, derivative, missing);
    return modes_factor(m->size, m->width, matrix) && modes_end_hold(m, matrix, missing, x, NULL);
}

/* Whether a given state has the end where it is held. */
static ad_status check_given(const modes *m, const solve_initial *given, ad_error *error)
{
    const double most = 1e-2; /* of states that were computed or seen */
    const double off = modes_end_off_at(m, given->position, given->rotation);
    return off <= most
               ? AD_OK
               : ad_fail(error, AD_NOT_FINITE,
                         "boundary.end: the state to start from is off what it holds by %.2g of "
                         "the length or rad; allowed: one that agrees",
                         off);
}

/* From modes q to such as meet the end; v [size] is 0. */
static bool meet_end(modes *m, double *q, const double *v, double *matrix, double *right)
{
    enum { STEPS = 30 };
    const double near = 1e-13, good = 1e-10;
    double off = INFINITY, before = INFINITY;
    bool done = true;
    for (int step = 0; step < STEPS && done && m->end.count > 0; step++) {
        modes_shape(m, q, v, NULL);
        off = modes_end_off(m);
        if (off < near || (step > 2 && !(off < before))) {
            break;
        }
        before = off;
        done = change_end(m, 0, matrix, right);
        for (int a = 0; a < m->size && done; a++) {
            q[a] += right[a];
        }
    }
    return done && (m->end.count == 0 || off < good);
}

/* ---- fits ---------------------------------------------------------------------------------- */

/* The rates v [size] that come nearest to a motion given at the points [points], of modes q; work:
 * matrix [size][width], right [size]. */
static bool fit_rates(modes *m, const solve_initial *given, const double *q, double *v,
                      double *matrix, double *right)
{
    const int n = m->size;
    bool done = true;
    memset(v, 0, (size_t)n * sizeof *v);
    modes_shape(m, q, v, NULL);
    modes_mass(m);
    if (normal_equations(m, given, true, matrix, right) > 0) {
        done = solve_positive(m, matrix, right);
        memcpy(v, right, (size_t)n * sizeof *v);
    }
    if (m->feed.mode >= 0) { /* it slides along its shape */
        v[m->feed.mode] = m->feed.input < 0 ? m->feed.wanted[1] : 0;
    }
    if (m->turn.mode >= 0) {
        v[m->turn.mode] = 0;
    }
    if (m->end.count > 0 && done) {
        modes_shape(m, q, v, NULL);
        done = change_end(m, 1, matrix, right);
        for (int a = 0; a < n; a++) {
            v[a] += right[a];
        }
    }
    return done;
}

/* The same of modes and rates, from modes q that are not far off. */
static ad_status fit(modes *m, const solve_initial *given, double *q, double *v, ad_error *error)
{
    enum { STEPS = 30 };
    const double near = 1e-10;
    const int n = m->size;
    double *matrix = calloc((size_t)(n + 2) * (size_t)m->width, sizeof *matrix);
    double *right = matrix ? matrix + n * m->width : NULL, before = INFINITY;
    bool done = matrix != NULL;
    const ad_status status = done ? check_given(m, &given[m->points - 1], error)
                                  : ad_fail(error, AD_NO_MEMORY, "out of memory for a start");
    if (status != AD_OK) {
        free(matrix);
        return status;
    }
    memset(v, 0, (size_t)n * sizeof *v);
    for (int step = 0; step < STEPS && done; step++) {
        modes_shape(m, q, v, NULL);
        modes_mass(m);
        const double off = normal_equations(m, given, false, matrix, right);
        if (off < near || (step > 2 && off > 0.999 * before)) {
            break;
        }
        before = off;
        done = solve_positive(m, matrix, right);
        const double part = fmin(1, 0.7 / off); /* turns by less than a radian */
        for (int a = 0; a < n && done; a++) {
            q[a] += part * right[a];
        }
    }
    const bool moves =
        done && meet_end(m, q, v, matrix, right) && fit_rates(m, given, q, v, matrix, right);
    free(matrix);
    return moves ? AD_OK
           : done && m->end.count > 0
               ? modes_end_fail(error)
               : ad_fail(error, AD_NOT_FINITE, "modes for the initial shape are not found");
}

/* Legendre's polynomials are orthogonal in the sums of Gauss. */
void modes_project(const modes *m, const double (*strains)[MODES_STRAINS], double *q)
{
    double *size = m->room;
    const double fed = m->feed.mode >= 0 ? q[m->feed.mode] : 0;
    memset(q, 0, (size_t)m->size * sizeof *q);
    memset(size, 0, (size_t)m->size * sizeof *size);
    for (int p = 0; p < m->points; p++) {
        const modes_point *at = &m->point[p];
        const double of_feed = m->feed.mode >= 0 ? m->value[p * m->width + m->feed.mode] : 0;
        for (int a = 0; a < m->end.first && at->weight > 0; a++) {
            const double value = at->weight * m->value[p * m->width + a];
            const int c = m->mode[a].strain;
            const double off = c == MODES_V + 2 ? fed * of_feed : 0;
            q[a] += value * (strains[p][c] - at->origin[c] - off);
            size[a] += value * m->value[p * m->width + a];
        }
    }
    for (int a = 0; a < m->size; a++) {
        q[a] /= size[a] > 0 ? size[a] : 1;
    }
    if (m->feed.mode >= 0) {
        q[m->feed.mode] = fed;
    }
}

/* Strains between states just before and behind each point. */
static void strains_between(const modes *m, const solve_initial *before,
                            const solve_initial *behind, const double *distance,
                            double (*strains)[MODES_STRAINS])
{
    for (int p = 0; p < m->points; p++) {
        double step[3], turn[4], mid[4], R[3][3];
        for (int k = 0; k < 4; k++) {
            mid[k] = before[p].rotation[k] + behind[p].rotation[k];
        }
        quaternion_normalize(mid);
        rotation_matrix(mid, R);
        for (int k = 0; k < 3; k++) {
            step[k] = (behind[p].position[k] - before[p].position[k]) / distance[p];
        }
        to_body(R, step, strains[p] + MODES_V);
        quaternion_quotient(before[p].rotation, behind[p].rotation, turn);
        for (int k = 0; k < 3; k++) {
            strains[p][MODES_U + k] = 2 * turn[1 + k] / distance[p];
        }
    }
}

ad_status modes_initial(modes *m, double *q, double *v, ad_error *error)
{
    const double step = 1e-4; /* of an element, to either side */
    const size_t n = (size_t)m->points;
    solve_initial *given = calloc(3 * n, sizeof *given);
    double *s = malloc((2 + MODES_STRAINS) * n * sizeof *s), *distance = s + n;
    double(*strains)[MODES_STRAINS] = (double(*)[MODES_STRAINS])(s + 2 * n);
    ad_status status =
        given && s ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a start");
    double inputs[SCENE_PARAMETERS_MAX];
    if (status == AD_OK) {
        m->feed.out = m->feed.input >= 0 ? m->feed.command : m->feed.out;
        modes_commands(m, inputs);
        status = modes_at(m, 0, inputs, error);
    }
    for (int side = 0; side < 3 && status == AD_OK; side++) { /* there, before, behind */
        for (size_t p = 0; p < n; p++) {
            const double off = step * m->element[p / ((size_t)m->stages + 1)].length;
            s[p] = m->s[p] + (side == 0 ? 0 : side == 1 ? -off : off);
            distance[p] = 2 * off;
        }
        status = solve_rod_part(m->rod, SOLVE_INITIAL, n, s, 0, m->inputs > 0 ? m->inputs_at : NULL,
                                (double *)(given + (size_t)side * n), error);
    }
    if (status == AD_OK) {
        strains_between(m, given + n, given + 2 * n, distance, strains);
        begin_feed(m, q, v);
        modes_project(m, (const double(*)[MODES_STRAINS])strains, q);
        status = fit(m, given, q, v, error);
        if (m->turn.mode >= 0) {
            q[m->turn.mode] = m->turn.command;
        }
    }
    free(given);
    free(s);
    return status;
}

/* Whether the stiffness at which modes_settle ended resists every displacement that there can be.
 */
static bool is_stable(modes *m, const modes_linear *linear)
{
    for (int i = 0; i < m->end.first; i++) {
        for (int j = 0; j < m->end.first; j++) {
            const int at = i * m->width + j;
            linear->factor[at] = 0.5 * (linear->by_q[at] + linear->by_q[j * m->width + i]);
        }
    }
    leave_drives(m, linear->factor, linear->residual);
    return modes_factor(modes_end_free(m, 1, &linear->factor), m->width, linear->factor);
}

ad_status modes_initial_settled(modes *m, const double *settled_at, const double *inputs,
                                const double *rates, const modes_linear *linear, ad_error *error)
{
    enum { FIRST = 4, MOST = 64 };
    double between[SCENE_PARAMETERS_MAX];
    solve_initial *given = malloc((size_t)m->points * sizeof *given);
    ad_status status = given ? AD_NOT_FINITE : ad_fail(error, AD_NO_MEMORY, "out of memory");
    modes_move(m, NULL);
    for (int steps = FIRST; steps <= MOST && status == AD_NOT_FINITE; steps *= 2) {
        status = modes_at(m, 0, settled_at, error);
        status = status == AD_OK ? modes_initial(m, linear->q, linear->v, error) : status;
        for (int i = 0; i <= steps && status == AD_OK; i++) {
            for (int k = 0; k < m->inputs; k++) {
                between[k] = i == steps ? inputs[k]
                                        : settled_at[k] + (inputs[k] - settled_at[k]) * i / steps;
            }
            status = modes_at(m, 0, between, error);
            status = status == AD_OK ? modes_settle(m, linear, error) : status;
            if (status == AD_OK && !is_stable(m, linear)) {
                status = ad_fail(error, AD_NOT_FINITE,
                                 "no stable equilibrium to start from is found at the inputs");
            }
        }
    }
    modes_move(m, rates);
    status = status == AD_OK ? modes_at(m, 0, inputs, error) : status;
    status = status == AD_OK ? solve_rod_part(m->rod, SOLVE_INITIAL, (size_t)m->points, m->s, 0,
                                              m->inputs_at, (double *)given, error)
                             : status;
    if (status == AD_OK &&
        !fit_rates(m, given, linear->q, linear->v, linear->factor, linear->residual)) {
        status = ad_fail(error, AD_NOT_FINITE, "rates for the initial motion are not found");
    }
    free(given);
    return status;
}

/* What moves no mass, as twist without rotary inertia: its accelerations do nothing. */
static void leave_massless(const modes *m, double *mass, double *right)
{
    const double nothing = 1e-14; /* of the largest: modes of degree k have some k^-4 of it */
    double most = 0;
    for (int a = 0; a < m->size; a++) {
        most = fmax(most, mass[a * m->width + a]);
    }
    for (int a = 0; a < m->size; a++) {
        if (mass[a * m->width + a] <= nothing * most) {
            leave(m, a, mass, right);
        }
    }
}

bool modes_accelerations(modes *m, const double *q, const double *v, double *a)
{
    const bool drives = m->feed.mode >= 0 || m->turn.mode >= 0;
    double *given = m->feed.trial, driven[MODES_DRIVES] = {0}; /* accelerations, by no other one */
    double missing[6];
    modes_shape(m, q, v, NULL);
    memset(given, 0, drives ? (size_t)m->size * sizeof *given : 0);
    for (int drive = 0; drive < MODES_DRIVES; drive++) {
        if (modes_driven(m, drive) >= 0) {
            driven[drive] = drive == 0 ? -modes_feed_residual(m) : -modes_turn_residual(m);
            given[modes_driven(m, drive)] = driven[drive];
        }
    }
    if (drives) {
        modes_shape(m, q, v, given);
    }
    if (m->end.count > 0) {
        modes_end_missing(m, 2, missing);
    }
    modes_forces(m, false, a);
    modes_mass(m);
    for (int k = 0; k < m->size; k++) {
        a[k] = -a[k];
    }
    leave_reactions(m, m->mass, a);
    leave_drives(m, m->mass, a);
    leave_massless(m, m->mass, a);
    bool done = solve_positive(m, m->mass, a);
    if (m->end.count > 0 && done) {
        done = modes_end_hold(m, m->mass, missing, a, a + m->end.first);
    }
    for (int drive = 0; drive < MODES_DRIVES; drive++) {
        if (modes_driven(m, drive) >= 0) {
            a[modes_driven(m, drive)] = driven[drive];
        }
    }
    return done;
}

ad_status modes_accelerations_fail(const modes *m, ad_error *error)
{
    return m->end.count > 0
               ? modes_end_fail(error)
               : ad_fail(error, AD_NOT_FINITE, "the mass matrix of the modes is singular");
}

/* Rows around a place, whose polynomial goes through them: strains are derivatives of it. */
enum { AROUND = 6 };

/* Their weights by Lagrange's formula; the first of them. */
static size_t weights_at(size_t count, const solve_seen *seen, double s, double weights[AROUND])
{
    size_t first = 0;
    while (first + AROUND < count && seen[first + AROUND / 2].s < s) {
        first++;
    }
    for (int i = 0; i < AROUND; i++) {
        weights[i] = 1;
        for (int k = 0; k < AROUND; k++) {
            const double at = seen[first + (size_t)k].s, own = seen[first + (size_t)i].s;
            weights[i] *= k == i ? 1 : (s - at) / (own - at);
        }
    }
    return first;
}

/* Between what is seen, dimensionless. */
static solve_initial seen_at(const modes *m, size_t count, const solve_seen *seen, double s)
{
    const double length = m->rod->scales.length, time = m->rod->scales.time;
    solve_initial state = {{0}, {0}, {0}, {0}};
    double weights[AROUND];
    const size_t first = weights_at(count, seen, s * length, weights);
    const double *upright = seen[first].rotation;
    for (int i = 0; i < AROUND; i++) {
        const solve_seen *at = &seen[first + (size_t)i];
        double same = 0;
        for (int k = 0; k < 4; k++) {
            same += at->rotation[k] * upright[k];
        }
        for (int k = 0; k < 4; k++) {
            state.rotation[k] += (same < 0 ? -1 : 1) * weights[i] * at->rotation[k];
        }
        for (int k = 0; k < 3; k++) {
            state.position[k] += weights[i] * at->position[k] / length;
            state.velocity[k] += weights[i] * at->velocity[k] * time / length;
            state.spin[k] += weights[i] * at->spin[k] * time;
        }
    }
    quaternion_normalize(state.rotation);
    return state;
}

ad_status modes_fit_seen(modes *m, size_t count, const solve_seen *seen, double *q, double *v,
                         ad_error *error)
{
    solve_initial *given = calloc((size_t)m->points, sizeof *given);
    if (!given) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a start");
    }
    for (int p = 0; p < m->points; p++) {
        given[p] = seen_at(m, count, seen, m->s[p]);
    }
    const ad_status status = fit(m, given, q, v, error);
    free(given);
    return status;
}
