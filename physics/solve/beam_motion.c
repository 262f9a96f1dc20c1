#include "physics/solve/beam_motion.h"

#include "autodiff/dense.h"
#include "autodiff/memory.h"
#include "physics/numerics/gauss.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* x = (w at the nodes), with rotary inertia (w, psi at the nodes), and w and psi of bodies, v =
 * x_t, z = x_tt. A response is that of x to loads: q at the nodes, mu at the nodes, force and
 * moment at the jumps in turn, what the ends prescribe. */
enum { STAGES = 8, LAST = STAGES - 1 };

/* Of the duration: how far from a jump loads are those of its own side. */
static const double INSIDE = 1e-12;

/* A row of x: where it stands in a field y, the load that acts on it, and what stiffening, drag and
 * inertia make of x, v and z, as such loads. */
typedef struct beam_row {
    size_t in_field, load;
    double stiffening, drag, inertia;
} beam_row;

typedef struct beam_motion {
    const solve_beam *beam;
    beam_system *system;
    gauss_rule rule;
    double step;                 /* of time */
    double first, last;          /* of a stretch of time, in which nothing jumps */
    size_t nodes, rows, columns; /* columns: of the response */
    beam_row *row;               /* [rows] */
    double *response;            /* [columns][rows] */
    double *matrix;              /* [STAGES rows]^2, LU */
    int *pivots;
    double *x, *v;        /* [rows], at the start of the step */
    double *at_stages[3]; /* [STAGES][rows]: x, v, z */
    double *loads, *all;  /* [STAGES][columns], [columns] */
    double *change, *y;   /* [rows], [places][BEAM_ROWS] */
    beam_load *line;      /* [nodes] */
    beam_load jumps[BEAM_JUMPS_MAX];
    ad_memory memory;
} beam_motion;

/* ---- matrices -------------------------------------------------------------------------------- */

static size_t count_rows(const solve_beam *beam, size_t nodes)
{
    size_t rows = beam->turns ? 2 * nodes : nodes;
    for (int i = 0; i < beam->jump_count; i++) {
        rows += (size_t)(beam->jumps[i].mass > 0) + (size_t)(beam->jumps[i].inertia > 0);
    }
    return rows;
}

static void set_rows(beam_motion *m)
{
    size_t count = 0, sides = m->beam->turns ? 2 : 1;
    for (size_t side = 0; side < sides; side++) {
        for (size_t i = 0; i < m->nodes; i++) {
            const beam_section *at = &m->system->sections[i];
            m->row[count++] =
                (beam_row){.in_field = beam_system_place(m->system, i) * BEAM_ROWS + side,
                           .load = side * m->nodes + i,
                           .stiffening = side == 0 ? BEAM_MOTION_STIFFENING : 0,
                           .drag = side == 0 ? at->drag : 0,
                           .inertia = side == 0 ? at->mass : at->rotary_inertia};
        }
    }
    for (int i = 0; i < m->beam->jump_count; i++) {
        const double inertia[2] = {m->beam->jumps[i].mass, m->beam->jumps[i].inertia};
        for (size_t side = 0; side < 2; side++) {
            size_t place = beam_system_jump_place(m->system, i);
            if (inertia[side] > 0) {
                m->row[count++] = (beam_row){.in_field = place * BEAM_ROWS + side,
                                             .load = 2 * (m->nodes + (size_t)i) + side,
                                             .inertia = inertia[side]};
            }
        }
    }
}

/* y [places][BEAM_ROWS] under loads [columns]. */
static void solve_loads(beam_motion *m, const double *loads)
{
    for (size_t i = 0; i < m->nodes; i++) {
        m->line[i] = (beam_load){loads[i], loads[m->nodes + i]};
    }
    const double *jumps = loads + 2 * m->nodes;
    for (int i = 0; i < m->beam->jump_count; i++) {
        m->jumps[i] = (beam_load){jumps[2 * i], jumps[2 * i + 1]};
    }
    beam_system_solve(m->system, m->line, m->jumps, loads + m->columns - 4, m->y);
}

static void fill_response(beam_motion *m)
{
    double *loads = m->loads;
    for (size_t column = 0; column < m->columns; column++) {
        memset(loads, 0, m->columns * sizeof *loads);
        loads[column] = 1;
        solve_loads(m, loads);
        for (size_t k = 0; k < m->rows; k++) {
            m->response[column * m->rows + k] = m->y[m->row[k].in_field];
        }
    }
}

/* The integral of the integral: a^2. */
static double twice(const gauss_rule *rule, int i, int j)
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
            const beam_row *row = &m->row[k];
            double *column = m->matrix + ((size_t)j * m->rows + k) * n;
            const double *response = m->response + row->load * m->rows;
            for (int i = 0; i < STAGES; i++) {
                double by_x = m->step * m->step * twice(&m->rule, i, j);
                double by_v = m->step * m->rule.matrix[i][j];
                double weight =
                    row->drag * by_v - row->stiffening * by_x + (i == j ? row->inertia : 0);
                double *to = column + (size_t)i * m->rows;
                for (size_t other = 0; other < m->rows; other++) {
                    to[other] = weight * response[other];
                }
                to[k] += by_x;
            }
        }
    }
    return ad_dense_lu(n, m->matrix, m->pivots);
}

/* ---- one step -------------------------------------------------------------------------------- */

/* to [rows] += the response to one load */
static void add_response(const beam_motion *m, size_t column, double load, double *to)
{
    const double *response = m->response + column * m->rows;
    for (size_t k = 0; load != 0 && k < m->rows; k++) {
        to[k] += response[k] * load;
    }
}

/* Loads are those within the stretch, at its ends as well. */
static ad_status load_stages(beam_motion *m, double start, ad_error *error)
{
    const double *points = m->system->mesh.points;
    double first = m->first > 0 ? m->first + INSIDE * m->beam->duration : 0;
    double end = m->beam->duration, last = m->last < end ? m->last - INSIDE * end : end;
    ad_status status = AD_OK;
    for (int i = 0; i < STAGES && status == AD_OK; i++) {
        double *loads = m->loads + (size_t)i * m->columns;
        double t = fmax(first, fmin(last, start + m->step * m->rule.nodes[i]));
        status = solve_beam_load(m->beam, m->nodes, points, t, m->line, error);
        for (size_t k = 0; k < m->nodes; k++) {
            loads[k] = m->line[k].force;
            loads[m->nodes + k] = m->line[k].moment;
        }
        status = status == AD_OK ? solve_beam_jump_loads(m->beam, t, m->jumps, error) : status;
        for (int k = 0; k < m->beam->jump_count; k++) {
            loads[2 * (m->nodes + (size_t)k)] = m->jumps[k].force;
            loads[2 * (m->nodes + (size_t)k) + 1] = m->jumps[k].moment;
        }
        status =
            status == AD_OK ? solve_beam_ends(m->beam, t, loads + m->columns - 4, error) : status;
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
            right[k] = -(m->x[k] + ahead * m->v[k]);
            m->change[k] = -m->row[k].stiffening * right[k] - m->row[k].drag * m->v[k];
        }
        for (size_t k = 0; k < m->rows; k++) {
            add_response(m, m->row[k].load, m->change[k], right);
        }
        for (size_t k = 0; k < m->columns; k++) {
            add_response(m, k, m->loads[(size_t)i * m->columns + k], right);
        }
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
    gauss_lagrange_slope(&m->rule, at, values, derivatives);
    memset(fields, 0, 2 * count * sizeof *fields);
    for (size_t i = 0; i < STAGES; i++) {
        memcpy(m->all, m->loads + i * m->columns, m->columns * sizeof *m->all);
        for (size_t k = 0; k < m->rows; k++) {
            const beam_row *row = &m->row[k];
            size_t of_stage = i * m->rows + k;
            m->all[row->load] += row->stiffening * m->at_stages[0][of_stage] -
                                 row->drag * m->at_stages[1][of_stage] -
                                 row->inertia * m->at_stages[2][of_stage];
        }
        solve_loads(m, m->all);
        for (size_t k = 0; k < count; k++) {
            fields[k] += values[i] * m->y[k];
            fields[count + k] += derivatives[i] / m->step * m->y[k];
        }
    }
}

/* ---- making and freeing ---------------------------------------------------------------------- */

static ad_status allocate(beam_motion *m, ad_error *error)
{
    size_t stacked = STAGES * m->rows, places = beam_system_places(m->system);
    size_t response = m->columns * m->rows, loads = (STAGES + 1) * m->columns;
    size_t numbers =
        response + stacked * stacked + 3 * m->rows + 3 * stacked + loads + places * BEAM_ROWS;
    AD_TAKE(m, response, numbers);
    AD_TAKE(m, pivots, stacked);
    AD_TAKE(m, line, m->nodes);
    AD_TAKE(m, row, m->rows);
    if (m->memory.is_short) {
        return ad_memory_status(&m->memory, error, "out of memory for %zu nodes", m->nodes);
    }
    m->matrix = m->response + response;
    m->x = m->matrix + stacked * stacked;
    m->v = m->x + m->rows;
    m->change = m->v + m->rows;
    for (int i = 0; i < 3; i++) {
        m->at_stages[i] = m->change + m->rows + (size_t)i * stacked;
    }
    m->loads = m->at_stages[2] + stacked;
    m->all = m->loads + STAGES * m->columns;
    m->y = m->loads + loads;
    return AD_OK;
}

static ad_status start(beam_motion *m, ad_error *error)
{
    size_t jumps = (size_t)m->beam->jump_count, count = m->nodes + jumps;
    beam_initial_state *initial = malloc(count * sizeof *initial);
    double *points = malloc(count * sizeof *points);
    ad_status status = initial && points ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    if (status == AD_OK) {
        memcpy(points, m->system->mesh.points, m->nodes * sizeof *points);
        for (size_t i = 0; i < jumps; i++) {
            points[m->nodes + i] = m->beam->jumps[i].s;
        }
        status = solve_beam_initial(m->beam, count, points, initial, error);
    }
    for (size_t k = 0; status == AD_OK && k < m->rows; k++) {
        size_t load = m->row[k].load;
        bool of_node = load < 2 * m->nodes, of_slope;
        const beam_initial_state *at =
            &initial[of_node ? load % m->nodes : m->nodes + (load - 2 * m->nodes) / 2];
        of_slope = of_node ? load >= m->nodes : load % 2 == 1;
        m->x[k] = of_slope ? at->slope : at->deflection;
        m->v[k] = of_slope ? at->slope_rate : at->velocity;
    }
    free(initial);
    free(points);
    return status;
}

static ad_status prepare(beam_motion *m, ad_error *error)
{
    ad_status status = allocate(m, error);
    if (status == AD_OK) {
        set_rows(m);
        status = start(m, error);
    }
    if (status == AD_OK) {
        fill_response(m);
    }
    return status;
}

/* Where the results are wanted, and how many of them there are already. */
typedef struct wanted {
    size_t count, done, stride;
    const double *times;
    double *fields;
} wanted;

/* `steps` equal ones from m->first to m->last. */
static ad_status pass_stretch(beam_motion *m, long steps, bool is_last, wanted *to, ad_error *error)
{
    m->step = (m->last - m->first) / (double)steps;
    if (factor(m) != 0) {
        return ad_fail(error, AD_NOT_FINITE, "the steps of time are singular");
    }
    ad_status status = AD_OK;
    for (long i = 0; i < steps && status == AD_OK; i++) {
        double at = m->first + (double)i * m->step;
        double last = is_last && i + 1 == steps ? INFINITY : at + m->step;
        status = load_stages(m, at, error);
        if (status == AD_OK) {
            solve_stages(m);
            advance(m);
        }
        for (; status == AD_OK && to->done < to->count && to->times[to->done] <= last; to->done++) {
            observe(m, (to->times[to->done] - at) / m->step, to->fields + to->done * to->stride);
        }
    }
    return status;
}

/* More on a finer mesh, even in a stretch that is shorter than a step. */
static long steps_of(const beam_motion *m, long steps)
{
    double share = (m->last - m->first) / m->beam->duration;
    long least = (long)m->nodes / 3 + 2;
    return share < 1 ? (long)fmax((double)least, ceil(share * (double)steps)) : steps;
}

ad_status beam_motion_solve(const solve_beam *beam, beam_system *system, long *steps, size_t count,
                            const double *times, double *fields, ad_error *error)
{
    size_t nodes = beam_system_nodes(system);
    const scene_breaks *instants = &beam->instants;
    wanted to = {.count = count,
                 .stride = 2 * beam_system_places(system) * BEAM_ROWS,
                 .times = times,
                 .fields = fields};
    beam_motion m = {.beam = beam,
                     .system = system,
                     .rule = gauss_radau_rule_of(STAGES),
                     .nodes = nodes,
                     .rows = count_rows(beam, nodes),
                     .columns = 2 * (nodes + (size_t)beam->jump_count) + 4};
    long taken = 0;
    ad_status status = prepare(&m, error);
    for (int i = 0; i <= instants->count && status == AD_OK; i++) {
        bool is_last = i == instants->count;
        m.first = m.last;
        m.last = is_last ? beam->duration : instants->place[i];
        long here = steps_of(&m, *steps);
        status = pass_stretch(&m, here, is_last, &to, error);
        taken += here;
    }
    *steps = taken;
    ad_memory_free(&m.memory);
    return status;
}
