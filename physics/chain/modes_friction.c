/* Friction of the tendons of a reduced rod in motion: the capstan's law with the speed w at which a
 * tendon slides past its guides towards its beginning,
 *
 *   T' = -mu |t'| w/sqrt(w^2 + c^2) T,   t the tangent of its path,
 *
 * t' in the world, kinks where strains jump included. The tendon is fixed at its end, so that w is
 * the rate at which it gets shorter from s to there. The law has no memory: where Coulomb's sticks,
 * this one creeps, slower than c. What friction takes is the integral of -T' w, never less than 0.
 */
#include "physics/chain/modes_internal.h"
#include "physics/law/law_numbers.h"

#include <math.h>
#include <string.h>

/* The k-th tendon with friction. */
typedef struct path {
    modes_rub *rub;               /* [points] */
    modes_dual *dual;             /* [points]; NULL: none */
    int actuator, first, last;    /* elements */
    double friction, creep, pull; /* pull: where it begins */
    double longer;                /* rate of the length of it all */
} path;

static path path_of(const modes *m, int k)
{
    path x = {.rub = m->friction.rub + k * m->points, .last = m->elements - 1, .first = m->hinges};
    for (int left = k; left > 0 || !m->rod->extents[x.actuator].rubs; x.actuator++) {
        left -= m->rod->extents[x.actuator].rubs;
    }
    const solve_extent *extent = &m->rod->extents[x.actuator];
    x.dual = m->friction.dual ? m->friction.dual + k * m->points : NULL;
    for (; m->s[x.first * (m->stages + 1)] < extent->start; x.first++) {
    }
    for (; m->s[x.last * (m->stages + 1)] > extent->end; x.last--) {
    }
    const solve_actuator *at = &m->actuators[x.actuator];
    x.friction = at->friction;
    x.creep = extent->creep;
    x.pull = at->pull + m->tension[x.actuator];
    return x;
}

/* Whether the tendon may have a kink where an element begins. */
static bool may_kink(const modes *m, const path *x, int e)
{
    return e > x->first && m->element[e].own != m->element[e - 1].own;
}

/* ---- what it leaves ------------------------------------------------------------------------ */

/* Length per length by the strains, and its rate. */
static void take_point(const modes *m, const path *x, int p, bool derive)
{
    const solve_actuator *a = &m->actuators[p * m->rod->actuators + x->actuator];
    const double given[] = {a->offset[0], a->offset[1], a->slope[0], a->slope[1], 1};
    const modes_point *at = &m->point[p];
    modes_rub *to = &x->rub[p];
    memset(to, 0, sizeof *to);
    if (derive) {
        number_law_tendon(at->strain, at->strain + MODES_U, given, to->along, to->bend);
    } else {
        number_law_tendon_wrench(at->strain, at->strain + MODES_U, given, to->along);
    }
    for (int c = 0; c < MODES_STRAINS; c++) {
        to->rate += to->along[c] * at->rate[c];
    }
}

static double integral(const modes *m, int e, int i, const double *first)
{
    double sum = 0;
    for (int j = 0; j < m->stages; j++) {
        sum += m->element[e].matrix[i][j] * first[(size_t)j * sizeof(modes_rub) / sizeof *first];
    }
    return sum;
}

/* For Newton's method: r = w/sqrt(w^2 + c^2) is taken as an unknown of its own, of which
 * r sqrt(w^2 + c^2) = w is linearised (Chan, Golub, Mulet, SIAM J. Sci. Comput. 20 (1999) 1964, of
 * the total variation). r itself, which is as good as a jump, sends the method to and fro. */
static void follow(const path *x, modes_dual *dual, modes_rub *at)
{
    const double w = at->speed, root = hypot(w, x->creep), before = hypot(dual->speed, x->creep);
    const double now = dual->speed / before, slope = (1 - dual->share * now) / before;
    dual->share = fmax(-1, fmin(1, now + slope * (w - dual->speed)));
    dual->speed = w;
    at->by[3] *= (1 - dual->share * w / root) * (root / x->creep) * (root / x->creep);
}

/* By how much log T falls, per length, and its derivatives, by how the path turns there. */
static void slide(const path *x, const double turning[3], modes_rub *at)
{
    const double speed[3] = {at->longer - x->longer}, numbers[2] = {x->friction, x->creep};
    double wrench[LAW_WRENCH] = {0}, second[LAW_STIFFNESS] = {0};
    number_law_friction(turning, speed, numbers, wrench, second);
    at->speed = speed[0];
    at->fall = wrench[3];
    for (int c = 0; c < 4; c++) {
        at->by[c] = second[law_entry(c, 3)];
    }
    if (x->dual) {
        follow(x, &x->dual[at - x->rub], at);
    }
}

/* t' in the body. */
static void turn(const modes *m, const path *x, int e, int i, double turning[3])
{
    const int first = e * (m->stages + 1);
    vector_cross(m->point[first + i].strain + MODES_U, x->rub[first + i].along, turning);
    for (int j = 0; j < m->stages; j++) {
        for (int c = 0; c < 3; c++) {
            turning[c] +=
                m->friction.slope[i][j] / m->element[e].length * x->rub[first + j].along[c];
        }
    }
}

/* Where element e begins: the rotation of a joint there. */
static void joint(const modes *m, int e, double R[3][3])
{
    static const double none[4] = {1};
    const int turns = m->turn_at[e - 1];
    rotation_matrix(turns >= 0 ? m->rod->jumps.at[turns].turn : none, R);
}

/* The same where it has a kink, whose angle is 2 asin(|jump of t|/2). */
static void slide_kink(const modes *m, const path *x, int e, modes_rub *at)
{
    const int n = m->stages;
    double R[3][3], after[3] = {0}, jump[3];
    for (int j = 0; j < n; j++) {
        for (int c = 0; c < 3; c++) {
            after[c] += m->friction.edge[0][j] * at[1 + j].along[c];
        }
    }
    joint(m, e, R);
    to_world(R, after, jump);
    for (int j = 0; j < n; j++) {
        for (int c = 0; c < 3; c++) {
            jump[c] -= m->friction.edge[1][j] * at[j - n].along[c];
        }
    }
    slide(x, jump, at);
    const double half = fmin(sqrt(vector_dot(jump, jump)) / 2, 1 - 1e-9);
    const double more = half > 0 ? asin(half) / half : 1, steeper = 1 / sqrt(1 - half * half);
    at->fall *= more;
    for (int c = 0; c < 4; c++) {
        at->by[c] *= c < 3 ? steeper : more;
    }
}

static void rub(modes *m, path *x, bool derive)
{
    const int n = m->stages;
    double fallen = 0;
    for (int e = x->first; e <= x->last; e++) {
        modes_rub *at = x->rub + e * (n + 1);
        const double from = x->longer;
        for (int i = 0; i < n; i++) {
            take_point(m, x, e * (n + 1) + i, derive);
        }
        for (int i = 0; i <= n; i++) {
            at[i].longer = from + integral(m, e, i, &at->rate);
        }
        x->longer = at[n].longer;
    }
    for (int e = x->first; e <= x->last; e++) {
        modes_rub *at = x->rub + e * (n + 1);
        if (may_kink(m, x, e)) {
            slide_kink(m, x, e, at - 1);
            fallen += at[-1].fall;
        }
        for (int i = 0; i < n; i++) {
            double turning[3];
            turn(m, x, e, i, turning);
            slide(x, turning, &at[i]);
        }
        for (int i = 0; i <= n; i++) {
            at[i].fallen = fallen + integral(m, e, i, &at->fall);
            m->friction.left[(e * (n + 1) + i) * m->rod->actuators + x->actuator] =
                exp(-at[i].fallen);
        }
        fallen = at[n].fallen;
    }
}

void modes_friction_find(modes *m, bool derive)
{
    for (int k = 0; k < m->rod->frictions; k++) {
        path x = path_of(m, k);
        rub(m, &x, derive);
    }
}

void modes_friction_power(const modes *m, double *load, double *dissipation)
{
    const int n = m->stages;
    for (int k = 0; k < m->rod->frictions; k++) {
        const path x = path_of(m, k);
        for (int e = x.first; e <= x.last; e++) {
            const modes_rub *at = x.rub + e * (n + 1);
            for (int i = 0; i < n; i++) {
                const double pull = m->point[e * (n + 1) + i].weight * x.pull;
                const double left = exp(-at[i].fallen);
                *load += pull * (left - 1) * at[i].rate;
                *dissipation += pull * left * at[i].fall * at[i].speed;
            }
            if (may_kink(m, &x, e)) {
                *dissipation += x.pull * exp(-at[-1].fallen) * -expm1(-at[-1].fall) * at[-1].speed;
            }
        }
    }
}

/* ---- derivatives --------------------------------------------------------------------------- */

/* Rows of derivatives by q and then by q_t. */
typedef struct rubbed_rows {
    double *longer, *fallen; /* [points] */
    double *fall;            /* [stages] */
} rubbed_rows;

/* What x [count] of `along` changes by with the strains of a point. */
static void bend(const modes_rub *at, int count, const double *x, double by[MODES_STRAINS])
{
    for (int k = 0; k < MODES_STRAINS; k++) {
        by[k] = 0;
        for (int c = 0; c < count; c++) {
            by[k] += x[c] * at->bend[law_entry(c, k)];
        }
    }
}

/* to += by from, rows. */
static void add_row(const modes *m, double by, const double *from, double *to)
{
    for (int c = 0; c < 2 * m->width; c++) {
        to[c] += by * from[c];
    }
}

static void change_longer(const modes *m, const path *x, const double *before, int e,
                          rubbed_rows *rows)
{
    const int n = m->stages, width = m->width, first = e * (n + 1);
    const modes_element *element = &m->element[e];
    for (int i = 0; i <= n; i++) {
        double *to = rows->longer + (first + i) * 2 * width;
        memset(to, 0, (size_t)(2 * width) * sizeof *to);
        if (before) {
            add_row(m, 1, before, to);
        }
        for (int j = 0; j < n; j++) {
            const double *value = m->value + (first + j) * width;
            const modes_rub *at = &x->rub[first + j];
            double by[MODES_STRAINS];
            bend(at, MODES_STRAINS, m->point[first + j].rate, by);
            for (int a = element->own; a < element->end; a++) {
                const double own = element->matrix[i][j] * value[a];
                to[a] += own * by[m->mode[a].strain];
                to[width + a] += own * at->along[m->mode[a].strain];
            }
        }
    }
}

/* By its speed where `at` is. */
static void change_slid(const modes *m, const path *x, const modes_rub *at, const rubbed_rows *rows,
                        double *to)
{
    const int end = (x->last + 1) * (m->stages + 1) - 1;
    add_row(m, at->by[3], rows->longer + (at - x->rub) * 2 * m->width, to);
    add_row(m, -at->by[3], rows->longer + end * 2 * m->width, to);
}

static void change_kink(const modes *m, const path *x, int e, const rubbed_rows *rows, double *to)
{
    const int n = m->stages, first = e * (n + 1);
    const modes_rub *kink = &x->rub[first - 1];
    double R[3][3], by[3];
    joint(m, e, R);
    to_body(R, kink->by, by);
    change_slid(m, x, kink, rows, to);
    for (int j = 0; j < n; j++) {
        const int p[2] = {first + j, first + j - n - 1};
        for (int side = 0; side < 2; side++) {
            const modes_element *element = &m->element[e - side];
            const double weight = (side ? -1 : 1) * m->friction.edge[side][j];
            double own[MODES_STRAINS];
            bend(&x->rub[p[side]], 3, side ? kink->by : by, own);
            for (int a = element->own; a < element->end; a++) {
                to[a] += weight * m->value[p[side] * m->width + a] * own[m->mode[a].strain];
            }
        }
    }
}

static void change_fall(const modes *m, const path *x, int e, int i, const rubbed_rows *rows,
                        double *to)
{
    const int n = m->stages, first = e * (n + 1);
    const modes_element *element = &m->element[e];
    const modes_rub *at = &x->rub[first + i];
    double by_u[3], by_t[3], by[MODES_STRAINS];
    memset(to, 0, (size_t)(2 * m->width) * sizeof *to);
    change_slid(m, x, at, rows, to);
    vector_cross(at->along, at->by, by_u);
    vector_cross(at->by, m->point[first + i].strain + MODES_U, by_t);
    for (int j = -1; j < n; j++) { /* first what its own strains change */
        const int p = first + (j < 0 ? i : j);
        const double weight = j < 0 ? 1 : m->friction.slope[i][j] / element->length;
        bend(&x->rub[p], 3, j < 0 ? by_t : at->by, by);
        for (int c = 0; c < 3 && j < 0; c++) {
            by[MODES_U + c] += by_u[c];
        }
        for (int a = element->own; a < element->end; a++) {
            to[a] += weight * m->value[p * m->width + a] * by[m->mode[a].strain];
        }
    }
}

static void change_fallen(const modes *m, const path *x, int e, rubbed_rows *rows)
{
    const int n = m->stages, row = 2 * m->width;
    double *to = rows->fallen + e * (n + 1) * row, *kinked = rows->fall + n * row;
    memset(kinked, 0, (size_t)row * sizeof *kinked);
    if (e > x->first) {
        add_row(m, 1, to - row, kinked);
    }
    if (may_kink(m, x, e)) {
        change_kink(m, x, e, rows, kinked);
    }
    for (int i = 0; i < n; i++) {
        change_fall(m, x, e, i, rows, rows->fall + i * row);
    }
    for (int i = 0; i <= n; i++, to += row) {
        memcpy(to, kinked, (size_t)row * sizeof *to);
        for (int j = 0; j < n; j++) {
            add_row(m, m->element[e].matrix[i][j], rows->fall + j * row, to);
        }
    }
}

void modes_friction_derivatives(modes *m, double *by_q, double *by_v)
{
    const int n = m->stages, width = m->width;
    rubbed_rows rows = {m->room, m->room + m->points * 2 * width, m->room + m->points * 4 * width};
    for (int k = 0; k < m->rod->frictions; k++) {
        const path x = path_of(m, k);
        const double *before = NULL, *longer = m->longer + x.actuator * width;
        for (int e = x.first; e <= x.last; e++) {
            change_longer(m, &x, before, e, &rows);
            before = rows.longer + ((e + 1) * (n + 1) - 1) * 2 * width;
        }
        for (int e = x.first; e <= x.last; e++) {
            change_fallen(m, &x, e, &rows);
            for (int p = e * (n + 1); p < (e + 1) * (n + 1) - 1; p++) {
                const double *fallen = rows.fallen + p * 2 * width;
                const double weight = m->point[p].weight * exp(-x.rub[p].fallen);
                for (int b = m->element[e].own; b < m->element[e].end; b++) {
                    const double own =
                        weight * m->value[p * width + b] * x.rub[p].along[m->mode[b].strain];
                    for (int a = 0; a < m->size; a++) {
                        by_q[b * width + a] +=
                            own * (m->tight[x.actuator] * longer[a] - x.pull * fallen[a]);
                        by_v[b * width + a] -= own * x.pull * fallen[width + a];
                    }
                }
            }
        }
    }
}
