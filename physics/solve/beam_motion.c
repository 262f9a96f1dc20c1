#include "physics/solve/beam_motion.h"

#include "autodiff/dense.h"
#include "physics/solve/radau.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* x = (w at the nodes), with rotary inertia (w, psi at the nodes), v = x_t, z = x_tt. A response is
 * that of x to q at the nodes, mu at the nodes, what the ends prescribe; its first columns belong
 * to the loads that act on the rows of x. */
enum { STAGES = RADAU_STAGES, LAST = STAGES - 1 };

typedef struct beam_motion {
    const solve_beam *beam;
    beam_system *system;
    radau_rule rule;
    double step;                 /* of time */
    size_t nodes, rows, columns; /* columns: of the response */
    double *response;            /* [columns][rows] */
    double *matrix;              /* [STAGES rows]^2, LU */
    int *pivots;
    double *x, *v;        /* [rows], at the start of the step */
    double *at_stages[3]; /* [STAGES][rows]: x, v, z */
    double *loads;        /* [STAGES][columns] */
    double *change, *y;   /* [rows], [places][BEAM_ROWS] */
    beam_load *line;      /* [nodes] */
} beam_motion;

/* ---- matrices -------------------------------------------------------------------------------- */

/* Of row k of x: what the stiffening, drag and inertia make of x, v and z, as loads. */
static void resistance(const beam_motion *m, size_t k, double *stiffening, double *drag,
                       double *inertia)
{
    bool turns = k >= m->nodes;
    const beam_section *at = &beam_system_sections(m->system)[k % m->nodes];
    *stiffening = turns ? 0 : BEAM_MOTION_STIFFENING;
    *drag = turns ? 0 : at->drag;
    *inertia = turns ? at->rotary_inertia : at->mass;
}

static void fill_response(beam_motion *m)
{
    for (size_t column = 0; column < m->columns; column++) {
        double ends[4] = {0};
        memset(m->line, 0, m->nodes * sizeof *m->line);
        if (column < m->nodes) {
            m->line[column].force = 1;
        } else if (column < 2 * m->nodes) {
            m->line[column - m->nodes].moment = 1;
        } else {
            ends[column - 2 * m->nodes] = 1;
        }
        beam_system_solve(m->system, m->line, ends, m->y);
        for (size_t row = 0; row < m->rows; row++) {
            size_t place = beam_system_place(m->system, row % m->nodes);
            m->response[column * m->rows + row] = m->y[place * BEAM_ROWS + row / m->nodes];
        }
    }
}

/* The integral of the integral: a^2. */
static double twice(const radau_rule *rule, int i, int j)
{
    double sum = 0;
    for (int k = 0; k < STAGES; k++) {
        sum += rule->matrix[i][k] * rule->matrix[k][j];
    }
    return sum;
}

/* x = response (loads + stiffening x - drag v - inertia z) at all stages, for z. */
static int factor(beam_motion *m)
{
    size_t n = STAGES * m->rows;
    for (int j = 0; j < STAGES; j++) {
        for (size_t k = 0; k < m->rows; k++) {
            double stiffening, drag, inertia;
            double *column = m->matrix + ((size_t)j * m->rows + k) * n;
            const double *response = m->response + k * m->rows;
            resistance(m, k, &stiffening, &drag, &inertia);
            for (int i = 0; i < STAGES; i++) {
                double by_x = m->step * m->step * twice(&m->rule, i, j);
                double by_v = m->step * m->rule.matrix[i][j];
                double weight = drag * by_v - stiffening * by_x + (i == j ? inertia : 0);
                double *to = column + (size_t)i * m->rows;
                for (size_t row = 0; row < m->rows; row++) {
                    to[row] = weight * response[row];
                }
                to[k] += by_x;
            }
        }
    }
    return ad_dense_lu(n, m->matrix, m->pivots);
}

/* ---- one step -------------------------------------------------------------------------------- */

/* to [rows] += response loads [count], of the first columns */
static void add_response(const beam_motion *m, size_t count, const double *loads, double *to)
{
    for (size_t column = 0; column < count; column++) {
        const double *response = m->response + column * m->rows;
        for (size_t row = 0; loads[column] != 0 && row < m->rows; row++) {
            to[row] += response[row] * loads[column];
        }
    }
}

static ad_status load_stages(beam_motion *m, double start, ad_error *error)
{
    const double *points = beam_system_points(m->system);
    ad_status status = AD_OK;
    for (int i = 0; i < STAGES && status == AD_OK; i++) {
        double t = start + m->step * m->rule.nodes[i], *loads = m->loads + (size_t)i * m->columns;
        status = solve_beam_load(m->beam, m->nodes, points, t, m->line, error);
        for (size_t k = 0; k < m->nodes; k++) {
            loads[k] = m->line[k].force;
            loads[m->nodes + k] = m->line[k].moment;
        }
        status =
            status == AD_OK ? solve_beam_ends(m->beam, t, loads + 2 * m->nodes, error) : status;
    }
    return status;
}

/* z at the stages. */
static void solve_stages(beam_motion *m)
{
    double *z = m->at_stages[2];
    for (int i = 0; i < STAGES; i++) {
        double *right = z + (size_t)i * m->rows, ahead = m->step * m->rule.nodes[i];
        for (size_t k = 0; k < m->rows; k++) {
            double stiffening, drag, inertia;
            resistance(m, k, &stiffening, &drag, &inertia);
            right[k] = -(m->x[k] + ahead * m->v[k]);
            m->change[k] = -stiffening * right[k] - drag * m->v[k];
        }
        add_response(m, m->rows, m->change, right);
        add_response(m, m->columns, m->loads + (size_t)i * m->columns, right);
    }
    ad_dense_lu_solve(STAGES * m->rows, 1, m->matrix, m->pivots, z);
}

/* From z: v and x at the stages, the last of which is the end of the step. */
static void advance(beam_motion *m)
{
    for (int order = 1; order >= 0; order--) {
        const double *rates = m->at_stages[order + 1];
        double *start = order == 0 ? m->x : m->v;
        for (int i = 0; i < STAGES; i++) {
            double *to = m->at_stages[order] + (size_t)i * m->rows;
            memcpy(to, start, m->rows * sizeof *to);
            for (size_t j = 0; j < STAGES; j++) {
                double weight = m->step * m->rule.matrix[i][j];
                for (size_t k = 0; k < m->rows; k++) {
                    to[k] += weight * rates[j * m->rows + k];
                }
            }
        }
        memcpy(start, m->at_stages[order] + LAST * m->rows, m->rows * sizeof *start);
    }
}

/* ---- results --------------------------------------------------------------------------------- */

/* y and y_t within the step just made: in time the polynomial through y at the stages. */
static void observe(beam_motion *m, double at, double *fields)
{
    size_t count = beam_system_places(m->system) * BEAM_ROWS;
    double values[STAGES], derivatives[STAGES];
    solve_radau_lagrange(&m->rule, at, values, derivatives);
    memset(fields, 0, 2 * count * sizeof *fields);
    for (size_t i = 0; i < STAGES; i++) {
        double *loads = m->loads + i * m->columns;
        for (size_t k = 0; k < m->rows; k++) {
            double stiffening, drag, inertia;
            size_t of_stage = i * m->rows + k;
            resistance(m, k, &stiffening, &drag, &inertia);
            m->change[k] = stiffening * m->at_stages[0][of_stage] -
                           drag * m->at_stages[1][of_stage] - inertia * m->at_stages[2][of_stage];
        }
        for (size_t k = 0; k < m->nodes; k++) {
            bool turns = m->rows > m->nodes;
            m->line[k] = (beam_load){loads[k] + m->change[k],
                                     loads[m->nodes + k] + (turns ? m->change[m->nodes + k] : 0)};
        }
        beam_system_solve(m->system, m->line, loads + 2 * m->nodes, m->y);
        for (size_t k = 0; k < count; k++) {
            fields[k] += values[i] * m->y[k];
            fields[count + k] += derivatives[i] / m->step * m->y[k];
        }
    }
}

/* ---- making and freeing ---------------------------------------------------------------------- */

static void release(beam_motion *m)
{
    free(m->response);
    free(m->pivots);
    free(m->line);
}

static ad_status allocate(beam_motion *m, ad_error *error)
{
    size_t stacked = STAGES * m->rows, places = beam_system_places(m->system);
    size_t response = m->columns * m->rows, loads = STAGES * m->columns;
    size_t numbers =
        response + stacked * stacked + 3 * m->rows + 3 * stacked + loads + places * BEAM_ROWS;
    m->response = calloc(numbers, sizeof(double));
    m->pivots = malloc(stacked * sizeof *m->pivots);
    m->line = malloc(m->nodes * sizeof *m->line);
    if (!m->response || !m->pivots || !m->line) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", m->nodes);
    }
    m->matrix = m->response + response;
    m->x = m->matrix + stacked * stacked;
    m->v = m->x + m->rows;
    m->change = m->v + m->rows;
    for (int i = 0; i < 3; i++) {
        m->at_stages[i] = m->change + m->rows + (size_t)i * stacked;
    }
    m->loads = m->at_stages[2] + stacked;
    m->y = m->loads + loads;
    return AD_OK;
}

static ad_status start(beam_motion *m, ad_error *error)
{
    beam_initial_state *initial = malloc(m->nodes * sizeof *initial);
    const double *points = beam_system_points(m->system);
    ad_status status = initial ? solve_beam_initial(m->beam, m->nodes, points, initial, error)
                               : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (size_t k = 0; status == AD_OK && k < m->rows; k++) {
        const beam_initial_state *at = &initial[k % m->nodes];
        m->x[k] = k < m->nodes ? at->deflection : at->slope;
        m->v[k] = k < m->nodes ? at->velocity : at->slope_rate;
    }
    free(initial);
    return status;
}

static ad_status prepare(beam_motion *m, ad_error *error)
{
    ad_status status = allocate(m, error);
    status = status == AD_OK ? start(m, error) : status;
    if (status == AD_OK) {
        fill_response(m);
        if (factor(m) != 0) {
            status = ad_fail(error, AD_NOT_FINITE, "the steps of time are singular");
        }
    }
    return status;
}

ad_status beam_motion_solve(const solve_beam *beam, beam_system *system, long steps, size_t count,
                            const double *times, double *fields, ad_error *error)
{
    size_t nodes = beam_system_nodes(system), done = 0;
    size_t stride = 2 * beam_system_places(system) * BEAM_ROWS;
    beam_motion m = {.beam = beam,
                     .system = system,
                     .rule = solve_radau_rule_of(),
                     .step = beam->duration / (double)steps,
                     .nodes = nodes,
                     .rows = beam->turns ? 2 * nodes : nodes,
                     .columns = 2 * nodes + 4};
    ad_status status = prepare(&m, error);
    for (long i = 0; i < steps && status == AD_OK; i++) {
        double at = (double)i * m.step, last = i + 1 == steps ? INFINITY : at + m.step;
        status = load_stages(&m, at, error);
        if (status == AD_OK) {
            solve_stages(&m);
            advance(&m);
        }
        for (; status == AD_OK && done < count && times[done] <= last; done++) {
            observe(&m, (times[done] - at) / m.step, fields + done * stride);
        }
    }
    release(&m);
    return status;
}
