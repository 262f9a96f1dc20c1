/* Shape, motion and forces of a reduced rod: sums from the start to the tip and back. */
#include "physics/chain/modes_internal.h"
#include "physics/chain/strain_inline.h"
#include "physics/law/law_numbers.h"
#include "physics/local/actuation.h"

#include <string.h>

/* ---- from the start to the tip ------------------------------------------------------------- */

/* Strains of an element's points from its own modes. */
static void strain_points(modes *m, int e, const double *q, const double *v, const double *a)
{
    const modes_element *element = &m->element[e];
    for (int i = 0; i < m->stages; i++) {
        modes_point *at = &m->point[e * (m->stages + 1) + i];
        const double *value = m->value + (e * (m->stages + 1) + i) * m->width;
        memcpy(at->strain, at->origin, sizeof at->strain);
        memset(at->rate, 0, sizeof at->rate);
        memset(at->second, 0, sizeof at->second);
        for (int k = element->own; k < element->end; k++) {
            const int c = m->mode[k].strain;
            const bool fed = k == m->feed.mode;
            at->strain[c] += value[k] * (fed ? m->feed.now[0] : q[k]);
            at->rate[c] += value[k] * (fed ? m->feed.now[1] : v[k]);
            at->second[c] += fed ? value[k] * m->feed.now[2] : a ? value[k] * a[k] : 0;
        }
        if (m->branch.count > 0) {
            memset(at->stretch, 0, sizeof at->stretch);
            for (int k = element->own; k < element->end; k++) {
                at->stretch[m->mode[k].strain] += value[k] * m->branch.stretch[k];
            }
        }
    }
}

/* Turns of an element from each of its points to the next, LANES at a time: q of each step. */
FOR_EACH_PROCESSOR static void turn_steps(const modes *m, int e, double (*turn)[4])
{
    const int n = m->stages;
    const double length = m->element[e].length;
    const modes_point *at = m->point + e * (n + 1);
    for (int first = 0; first <= n; first += LANES) {
        lanes terms[3][3], q[4] = {NO_LANES + 1, NO_LANES, NO_LANES, NO_LANES};
        for (int k = 0; k < 3; k++) {
            for (int c = 0; c < 3; c++) {
                lanes sum = NO_LANES, of_steps;
                for (int j = 0; j < n; j++) {
                    memcpy(&of_steps, &m->magnus[k][j][first], sizeof of_steps);
                    sum += of_steps * at[j].strain[MODES_U + c];
                }
                terms[k][c] = length * sum;
            }
        }
        step_on(terms, q);
        for (int lane = 0; lane < LANES && first + lane <= n; lane++) {
            for (int i = 0; i < 4; i++) {
                turn[first + lane][i] = q[i][lane];
            }
        }
    }
}

static void turn_points(modes *m, int e, double q[4])
{
    double turn[GAUSS_STAGES_MAX + 1][4], next[4];
    turn_steps(m, e, turn);
    for (int i = 0; i <= m->stages; i++) {
        modes_point *at = &m->point[e * (m->stages + 1) + i];
        quaternion_product(q, turn[i], next);
        memcpy(q, next, 4 * sizeof *q);
        if (i == m->stages) {
            quaternion_normalize(q);
        }
        memcpy(at->q, q, sizeof at->q);
        rotation_matrix(q, at->R);
    }
    if (m->turn_at[e] >= 0) {
        quaternion_product(q, m->rod->jumps.at[m->turn_at[e]].turn, next);
        memcpy(q, next, 4 * sizeof *q);
    }
}

/* to [stages + 1] = from + integral of rate [stages], vectors of points `stride` doubles apart. */
static void integrate(const modes *m, int e, const double from[3], const double *rate, double *to)
{
    const size_t stride = sizeof(modes_point) / sizeof(double);
    const modes_element *element = &m->element[e];
    for (int i = 0; i <= m->stages; i++) {
        double sum[3] = {from[0], from[1], from[2]};
        for (int j = 0; j < m->stages; j++) {
            const double *x = rate + (size_t)j * stride, by = element->matrix[i][j];
            for (int k = 0; k < 3; k++) {
                sum[k] += by * x[k];
            }
        }
        memcpy(to + (size_t)i * stride, sum, sizeof sum);
    }
}

_Static_assert(sizeof(modes_point) % sizeof(double) == 0, "points are rows of doubles");

/* Vectors of points that move_element integrates on from the end of one element. */
typedef struct motion_of_edge {
    double r[3], spin[3], velocity[3], spin_rate[3], acceleration[3];
} motion_of_edge;

/* r' = R v; w' = R u_t; V' = w x R v + R v_t; and their rates by t. */
static void move_element(modes *m, int e, motion_of_edge *edge)
{
    modes_point *at = m->point + e * (m->stages + 1), *end = at + m->stages;
    double rate[GAUSS_STAGES_MAX][sizeof(modes_point) / sizeof(double)], more[3];
    for (int i = 0; i < m->stages; i++) {
        to_world(at[i].R, at[i].strain + MODES_V, at[i].along);
        to_world(at[i].R, at[i].rate + MODES_V, at[i].along_rate);
        to_world(at[i].R, at[i].rate + MODES_U, at[i].turned_rate);
        to_world(at[i].R, at[i].second + MODES_V, at[i].along_second);
        to_world(at[i].R, at[i].second + MODES_U, at[i].turned_second);
    }
    integrate(m, e, edge->r, at->along, at->r);
    integrate(m, e, edge->spin, at->turned_rate, at->spin);
    for (int i = 0; i < m->stages; i++) {
        double *to = rate[i];
        vector_cross(at[i].spin, at[i].along, at[i].turning);
        vector_cross(at[i].spin, at[i].turned_rate, to);
        for (int k = 0; k < 3; k++) {
            to[k] += at[i].turned_second[k];
            to[3 + k] = at[i].turning[k] + at[i].along_rate[k];
        }
    }
    integrate(m, e, edge->spin_rate, rate[0], at->spin_rate);
    integrate(m, e, edge->velocity, rate[0] + 3, at->velocity);
    for (int i = 0; i < m->stages; i++) {
        const double twice[3] = {at[i].turning[0] + 2 * at[i].along_rate[0],
                                 at[i].turning[1] + 2 * at[i].along_rate[1],
                                 at[i].turning[2] + 2 * at[i].along_rate[2]};
        vector_cross(at[i].spin_rate, at[i].along, rate[i]);
        vector_cross(at[i].spin, twice, more);
        for (int k = 0; k < 3; k++) {
            rate[i][k] += more[k] + at[i].along_second[k];
        }
    }
    integrate(m, e, edge->acceleration, rate[0], at->acceleration);
    memcpy(edge->r, end->r, sizeof edge->r);
    memcpy(edge->spin, end->spin, sizeof edge->spin);
    memcpy(edge->velocity, end->velocity, sizeof edge->velocity);
    memcpy(edge->spin_rate, end->spin_rate, sizeof edge->spin_rate);
    memcpy(edge->acceleration, end->acceleration, sizeof edge->acceleration);
}

void modes_shape(modes *m, const double *q, const double *v, const double *a)
{
    const solve_end_state *start = &m->start;
    motion_of_edge edge;
    double turn[4], R[3][3];
    if (m->feed.mode >= 0) {
        modes_feed_give(m, q, v, a);
    }
    if (m->turn.mode >= 0) {
        modes_turn_take(m, q, v, a);
    }
    if (m->end.count > 0) {
        modes_end_react(m, a);
    }
    memcpy(turn, start->rotation, sizeof turn);
    rotation_matrix(turn, R);
    memcpy(edge.r, start->position, sizeof edge.r);
    memcpy(edge.velocity, start->velocity, sizeof edge.velocity);
    memcpy(edge.acceleration, start->acceleration, sizeof edge.acceleration);
    to_world(R, start->spin, edge.spin);
    to_world(R, start->spin_rate, edge.spin_rate);
    for (int e = 0; e < m->elements; e++) {
        strain_points(m, e, q, v, a);
        turn_points(m, e, turn);
        move_element(m, e, &edge);
        if (m->feed.mode >= 0) {
            modes_feed_carry(m, e, q);
        }
    }
}

/* ---- stress -------------------------------------------------------------------------------- */

/* An actuator at LANES points of an element from `first` on, and what it pulls with there: `pull`,
 * of each metre where it is for weights; 0 beyond its ends. */
PROCESSOR_INLINE strain_actuator actuator_lanes(const modes *m, int e, int first, int k,
                                                bool weighs)
{
    const int n = m->stages, count = m->rod->actuators;
    const solve_extent *extent = &m->rod->extents[k];
    strain_actuator here = {{NO_LANES}};
    for (int lane = 0; lane < LANES; lane++) {
        const int p = e * (n + 1) + (first + lane < n ? first + lane : n - 1);
        const solve_actuator *a = &m->actuators[p * count + k];
        const modes_point *at = &m->point[p];
        const double pull = !weighs ? a->pull + m->tension[k] : first + lane < n ? at->weight : 0;
        for (int c = 0; c < 2; c++) {
            here.given[ACTUATOR_OFFSET + c][lane] = a->offset[c];
            here.given[ACTUATOR_SLOPE + c][lane] = a->slope[c];
        }
        here.given[ACTUATOR_PULL][lane] = extent->start <= at->s && at->s <= extent->end ? pull : 0;
    }
    return here;
}

PROCESSOR_INLINE void strain_lanes(const modes *m, int e, int first, bool unstressed,
                                   lanes strain[MODES_STRAINS])
{
    for (int lane = 0; lane < LANES; lane++) {
        const int i = first + lane < m->stages ? first + lane : m->stages - 1;
        const modes_point *at = &m->point[e * (m->stages + 1) + i];
        for (int c = 0; c < MODES_STRAINS; c++) {
            strain[c][lane] = unstressed ? at->rest[c] : at->strain[c];
        }
    }
}

/* What the length of a tendon changes by with the modes of an element: by the strains, times
 * weights. */
static void lengthen(modes *m, int e, int first, int k, const lanes by[MODES_STRAINS])
{
    const modes_element *element = &m->element[e];
    for (int lane = 0; lane < LANES && first + lane < m->stages; lane++) {
        const double *value = m->value + (e * (m->stages + 1) + first + lane) * m->width;
        for (int a = element->own; a < element->end; a++) {
            m->longer[k * m->width + a] += value[a] * by[m->mode[a].strain][lane];
        }
    }
}

FOR_EACH_PROCESSOR static void find_lengths(modes *m, bool unstressed, bool derive, double *length)
{
    memset(length, 0, (size_t)m->rod->actuators * sizeof *length);
    memset(m->longer, 0, (size_t)(derive ? m->rod->actuators * m->width : 0) * sizeof *m->longer);
    for (int e = m->hinges; e < m->elements; e++) {
        for (int first = 0; first < m->stages; first += LANES) {
            lanes strain[MODES_STRAINS] = {NO_LANES};
            strain_lanes(m, e, first, unstressed, strain);
            for (int k = 0; k < m->rod->actuators; k++) {
                if (!m->rod->extents[k].has_length) {
                    continue;
                }
                const strain_actuator here = actuator_lanes(m, e, first, k, true);
                lanes sum = {0}, by[MODES_STRAINS] = {NO_LANES};
                lanes_law_tendon_energy(strain, strain + MODES_U, here.given, &sum);
                for (int lane = 0; lane < LANES; lane++) {
                    length[k] += sum[lane];
                }
                if (derive) {
                    lanes_law_tendon_wrench(strain, strain + MODES_U, here.given, by);
                    lengthen(m, e, first, k, by);
                }
            }
        }
    }
}

void modes_unstressed_lengths(modes *m)
{
    find_lengths(m, true, false, m->unstressed);
}

/* Tensions of tendons whose length is given, by how much longer they are; none pushes. */
static void find_tensions(modes *m, bool derive)
{
    double length[SOLVE_ACTUATORS_MAX];
    find_lengths(m, false, derive, length);
    for (int i = 0; i < m->rod->actuators; i++) {
        if (m->rod->extents[i].has_length) {
            const double by = 1 / m->actuators[i].compliance;
            const double over = length[i] - m->unstressed[i] + m->actuators[i].displacement;
            m->tension[i] = over > 0 ? by * over : 0;
            m->tight[i] = over > 0 ? by : 0;
        }
    }
}

/* What friction leaves of a pull. */
static void rub(const modes *m, int e, int first, int k, lanes *pull)
{
    for (int lane = 0; lane < LANES; lane++) {
        const int i = first + lane < m->stages ? first + lane : m->stages - 1;
        (*pull)[lane] *= m->friction.left[(e * (m->stages + 1) + i) * m->rod->actuators + k];
    }
}

/* Points of an element side by side, LANES at a time. */
FOR_EACH_PROCESSOR static void pull_points(modes *m, int e, bool derive)
{
    const int n = m->stages;
    modes_point *at = m->point + e * (n + 1);
    for (int first = 0; first < n; first += LANES) {
        lanes strain[MODES_STRAINS] = {NO_LANES};
        pulling sum;
        memset(&sum, 0, sizeof sum);
        strain_lanes(m, e, first, false, strain);
        for (int k = 0; k < m->rod->actuators; k++) {
            strain_actuator here = actuator_lanes(m, e, first, k, false);
            if (m->rod->extents[k].rubs) {
                rub(m, e, first, k, &here.given[ACTUATOR_PULL]);
            }
            const int law = (int)m->rod->extents[k].law;
            if (derive) {
                lanes_law_actuator(law, strain + MODES_V, strain + MODES_U, here.given, sum.wrench,
                                   sum.stiffness);
            } else {
                lanes_law_actuator_wrench(law, strain + MODES_V, strain + MODES_U, here.given,
                                          sum.wrench);
            }
        }
        for (int lane = 0; lane < LANES && first + lane < n; lane++) {
            double *by = m->pull_by[e * (n + 1) + first + lane];
            for (int i = 0; i < MODES_STRAINS; i++) {
                at[first + lane].pull[i] = sum.wrench[i][lane];
            }
            for (int i = 0; i < LAW_STIFFNESS && derive; i++) {
                by[i] = sum.stiffness[i][lane];
            }
        }
    }
}

/* What a law is beyond the stiffness. */
static void bend_points(modes *m, int e, bool derive)
{
    for (int p = e * (m->stages + 1); p < (e + 1) * (m->stages + 1) - 1; p++) {
        modes_point *at = &m->point[p];
        const solve_actuation law = {.law = m->rod->scene.rod.law,
                                     .length = m->rod->scales.length,
                                     .unit_force = m->rod->scales.force,
                                     .rest = at->rest};
        double by[MODES_STRAINS][MODES_STRAINS], *to = m->pull_by[p];
        at->law_energy = solve_law_energy(&law, at->strain, at->law, derive ? by : NULL);
        for (int i = 0; i < MODES_STRAINS && derive; i++) {
            for (int j = i; j < MODES_STRAINS; j++, to++) {
                *to = by[i][j] + (m->is_pulled ? *to : 0);
            }
        }
    }
}

static void stress_points(modes *m, int e, bool derive)
{
    if (m->is_pulled) {
        pull_points(m, e, derive);
    }
    if (m->rod->scene.rod.law && e >= m->hinges) {
        bend_points(m, e, derive);
    }
    for (int i = 0; i < m->stages; i++) {
        modes_point *at = &m->point[e * (m->stages + 1) + i];
        double off[MODES_STRAINS], stress[MODES_STRAINS] = {0};
        strain_beyond_rest(at, off);
        number_law_elastic_wrench(off, off + MODES_U, at->stiffness, stress);
        const double *rate = modes_strain_rate(at);
        number_law_damping_wrench(rate, rate + MODES_U, at->damping, stress);
        if (m->branch.count > 0) {
            number_law_elastic_wrench(at->stretch, at->stretch + MODES_U, at->branch, stress);
        }
        for (int c = 0; c < MODES_STRAINS; c++) {
            at->stress[c] = stress[c] + at->pull[c] + at->law[c];
        }
    }
}

/* ---- what acts at points ------------------------------------------------------------------- */

static void add_inertia(modes_point *at)
{
    double wrench[6];
    inertia_wrench(&at->inertia, modes_section(at), wrench);
    memcpy(at->force, wrench, sizeof at->force);
    memcpy(at->moment, wrench + 3, sizeof at->moment);
}

static void add_loads(modes_point *at)
{
    for (int k = 0; k < 3; k++) {
        at->force[k] += at->dead[k];
        at->moment[k] += at->dead[3 + k];
    }
}

/* The section at a point. */
static acting_on section_of(const modes_point *at)
{
    return (acting_on){at->r, at->q, modes_section(at).velocity};
}

static void add_wrench(const acting *of, const double *numbers, double weight, modes_point *at)
{
    double wrench[6] = {0};
    if (of->kinds & ~ACTING_DEAD) {
        acting_wrench(of, numbers, section_of(at), ACTING_ALL & ~ACTING_DEAD, weight, wrench);
        for (int k = 0; k < 3; k++) {
            at->force[k] += wrench[k];
            at->moment[k] += wrench[3 + k];
        }
    }
}

/* Along the rod and at places. */
static void add_acting(modes *m)
{
    const solve_jumps *jumps = &m->rod->jumps;
    const acting *along = &m->rod->along;
    for (int p = 0; p < m->points && (along->kinds & ~ACTING_DEAD); p++) {
        if (m->point[p].weight > 0) {
            add_wrench(along, m->along + p * along->numbers, m->point[p].weight, &m->point[p]);
        }
    }
    for (int k = 0; k < jumps->count && jumps->numbers > 0; k++) {
        if (m->jump_at[k] >= 0) {
            add_wrench(&jumps->at[k].acting, solve_jump_numbers(jumps, jumps->number, k), 1,
                       &m->point[m->jump_at[k]]);
        }
    }
}

/* ---- from the tip to the start ------------------------------------------------------------- */

/* What forces at the points of an element and all beyond it change with the rate of one of its
 * Gauss points; `beyond` then has this element, too. which: 0 forces, 1 moments. */
static void carry(modes *m, int e, int which, double beyond[3])
{
    const int n = m->stages;
    const modes_element *element = &m->element[e];
    modes_point *at = m->point + e * (n + 1);
    for (int k = 0; k < 3; k++) {
        const double end = beyond[k] + (which ? at[n].moment[k] : at[n].force[k]);
        double sum = end;
        for (int j = 0; j < n; j++) {
            double to = element->matrix[n][j] * end;
            for (int i = 0; i < n; i++) {
                to += element->matrix[i][j] * (which ? at[i].moment[k] : at[i].force[k]);
            }
            at[j].carried[which][k] = to;
            sum += which ? at[j].moment[k] : at[j].force[k];
        }
        beyond[k] = sum;
    }
}

static void collect(modes *m, int e, double *residual)
{
    const modes_element *element = &m->element[e];
    for (int i = 0; i < m->stages; i++) {
        const int p = e * (m->stages + 1) + i;
        modes_point *at = &m->point[p];
        double work[MODES_STRAINS];
        to_body(at->R, at->carried[0], work + MODES_V);
        to_body(at->R, at->carried[1], work + MODES_U);
        for (int c = 0; c < MODES_STRAINS; c++) {
            work[c] = at->weight * at->stress[c] - work[c];
        }
        for (int a = element->own; a < element->end; a++) {
            residual[a] += m->value[p * m->width + a] * work[m->mode[a].strain];
        }
    }
}

void modes_forces(modes *m, bool derive, double *residual)
{
    double beyond[2][3] = {{0}};
    memset(residual, 0, (size_t)m->size * sizeof *residual);
    for (int p = 0; p < m->points; p++) {
        add_inertia(&m->point[p]);
        add_loads(&m->point[p]);
    }
    add_acting(m);
    if (m->end.count > 0) {
        modes_end_push(m);
    }
    if (m->rod->lengths > 0) {
        find_tensions(m, derive);
    }
    modes_friction_find(m, derive);
    for (int e = m->elements - 1; e >= 0; e--) {
        stress_points(m, e, derive);
        carry(m, e, 0, beyond[0]);
        for (int i = 0; i < m->stages; i++) { /* a turn moves what lies beyond along R v */
            modes_point *at = &m->point[e * (m->stages + 1) + i];
            double arm[3];
            vector_cross(at->along, at->carried[0], arm);
            for (int k = 0; k < 3; k++) {
                at->moment[k] += arm[k];
            }
        }
        carry(m, e, 1, beyond[1]);
        collect(m, e, residual);
    }
    for (int k = 0; k < 3; k++) {
        m->base[0][k] = -beyond[0][k];
        m->base[1][k] = -beyond[1][k];
    }
    if (m->end.count > 0) {
        modes_end_residual(m, residual);
    }
    if (m->feed.mode >= 0) {
        residual[m->feed.mode] = modes_feed_residual(m);
    }
    if (m->turn.mode >= 0) {
        m->turn.moment = residual[m->turn.mode];
        residual[m->turn.mode] = modes_turn_residual(m);
    }
}

/* ---- energy -------------------------------------------------------------------------------- */

solve_energy modes_energy_now(const modes *m)
{
    const solve_jumps *jumps = &m->rod->jumps;
    const acting *along = &m->rod->along;
    solve_energy energy = {0};
    for (int p = 0; p < m->points; p++) {
        const modes_point *at = &m->point[p];
        double off[MODES_STRAINS], elastic = at->law_energy;
        energy.kinetic += inertia_energy(&at->inertia, modes_section(at));
        strain_beyond_rest(at, off);
        number_law_elastic_energy(off, off + MODES_U, at->stiffness, &elastic);
        number_law_elastic_energy(at->stretch, at->stretch + MODES_U, at->branch, &elastic);
        energy.strain += at->weight * elastic;
        if (along->count > 0 && at->weight > 0) {
            energy.strain +=
                at->weight * acting_energy(along, m->along + p * along->numbers, section_of(at));
        }
    }
    for (int k = 0; k < jumps->count; k++) {
        if (m->jump_at[k] >= 0) {
            energy.strain +=
                acting_energy(&jumps->at[k].acting, solve_jump_numbers(jumps, jumps->number, k),
                              section_of(&m->point[m->jump_at[k]]));
        }
    }
    return energy;
}

/* Adds the power of what loads, but for dead loads, and of what dissipates at a point. */
static void add_power(const acting *of, const double *numbers, double weight, const modes_point *at,
                      double *load, double *dissipation)
{
    for (int i = 0; i < 2; i++) {
        const int kind = i ? ACTING_DISSIPATES : ACTING_OTHER_LOADS;
        double wrench[6] = {0};
        if (of->kinds & kind) {
            acting_wrench(of, numbers, section_of(at), kind, weight, wrench);
            const inertia_motion moving = modes_section(at);
            const double power =
                vector_dot(wrench, moving.velocity) + vector_dot(wrench + 3, moving.spin);
            *(i ? dissipation : load) += i ? -power : power;
        }
    }
}

void modes_power_now(const modes *m, double *load, double *dissipation)
{
    const solve_jumps *jumps = &m->rod->jumps;
    const acting *along = &m->rod->along;
    double R[3][3], q[4], spin[3];
    memcpy(q, m->start.rotation, sizeof q);
    rotation_matrix(q, R);
    to_world(R, m->start.spin, spin);
    *load = vector_dot(m->base[0], m->start.velocity) + vector_dot(m->base[1], spin);
    *load += m->feed.mode >= 0 ? modes_feed_power(m) : 0;
    *load += m->turn.mode >= 0 ? m->turn.moment * m->turn.now[1] : 0;
    *load += m->end.count > 0 ? modes_end_power(m) : 0;
    *dissipation = 0;
    for (int k = 0; k < jumps->count; k++) {
        if (m->jump_at[k] >= 0) {
            add_power(&jumps->at[k].acting, solve_jump_numbers(jumps, jumps->number, k), 1,
                      &m->point[m->jump_at[k]], load, dissipation);
        }
    }
    for (int p = 0; p < m->points; p++) {
        const modes_point *at = &m->point[p];
        const inertia_motion moving = modes_section(at);
        const double *rate = modes_strain_rate(at);
        *load += vector_dot(at->dead, moving.velocity) + vector_dot(at->dead + 3, moving.spin);
        if ((along->kinds & ~ACTING_DEAD) && at->weight > 0) {
            add_power(along, m->along + p * along->numbers, at->weight, at, load, dissipation);
        }
        double off[MODES_STRAINS], elastic[MODES_STRAINS] = {0}, viscous[MODES_STRAINS] = {0},
                                   branch[MODES_STRAINS] = {0};
        strain_beyond_rest(at, off);
        number_law_elastic_wrench(off, off + MODES_U, at->stiffness, elastic);
        number_law_damping_wrench(rate, rate + MODES_U, at->damping, viscous);
        number_law_elastic_wrench(at->stretch, at->stretch + MODES_U, at->branch, branch);
        for (int c = 0; c < MODES_STRAINS && at->weight > 0; c++) {
            *dissipation +=
                at->weight * (viscous[c] * rate[c] + at->relaxing * branch[c] * at->stretch[c]);
            *load -= at->weight * ((elastic[c] + branch[c] + at->law[c]) * at->rest_rate[c] +
                                   at->pull[c] * rate[c]);
        }
    }
    modes_friction_power(m, load, dissipation);
}
