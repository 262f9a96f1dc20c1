/* What residual and derivatives of the strain form share: actuators at a point, the sums
 * of physics/rod/rod.h, and the conditions of a held end. For functions that are compiled
 * FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_CHAIN_STRAIN_INLINE_H
#define PHYSICS_CHAIN_STRAIN_INLINE_H

#include "physics/chain/strain_form.h"
#include "physics/law/law.h"
#include "physics/law/laws_lanes.h"
#include "physics/local/magnus.h"

/* Of all actuators and of a law of the section at a point: force and moment, and the second
 * derivatives of their energy by v and u (law_entry), or by v alone. */
typedef struct pulling {
    lanes wrench[6], stiffness[LAW_STIFFNESS];
} pulling;

typedef struct pulling_by_v {
    lanes wrench[6], stiffness[6];
} pulling_by_v;

static const int BY_V[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

PROCESSOR_INLINE void add_lanes(int count, const lanes *from, lanes *to)
{
    for (int i = 0; i < count; i++) {
        to[i] += from[i];
    }
}

PROCESSOR_INLINE void pull_by_v(strain_form *form, int node, pulling_by_v *sum)
{
    strain_node *at = &form->at[node];
    const strain_actuator *all = &form->actuators[node * form->kind.actuators];
    memset(sum, 0, sizeof *sum);
    for (int i = 0; i < form->kind.actuators; i++) {
        lanes_law_actuator_by_v((int)form->kind.extents[i].law, at->v, at->u, all[i].given,
                                sum->wrench, sum->stiffness);
    }
    if (form->kind.law) {
        pulling_by_v own; /* so that the sum need not be in memory without */
        strain_form_law(form, node, 3, own.wrench, own.stiffness);
        add_lanes(6, own.wrench, sum->wrench);
        add_lanes(6, own.stiffness, sum->stiffness);
    }
}

/* Whether anything pulls. */
PROCESSOR_INLINE bool pulls(const strain_form *form)
{
    return form->kind.actuators > 0 || form->kind.law;
}

PROCESSOR_INLINE void pull_all(strain_form *form, int node, pulling *sum)
{
    strain_node *at = &form->at[node];
    const strain_actuator *all = &form->actuators[node * form->kind.actuators];
    memset(sum, 0, sizeof *sum);
    for (int i = 0; i < form->kind.actuators; i++) {
        lanes_law_actuator((int)form->kind.extents[i].law, at->v, at->u, all[i].given, sum->wrench,
                           sum->stiffness);
    }
    if (form->kind.law) {
        pulling own;
        strain_form_law(form, node, 6, own.wrench, own.stiffness);
        add_lanes(6, own.wrench, sum->wrench);
        add_lanes(LAW_STIFFNESS, own.stiffness, sum->stiffness);
    }
}

/* A tendon as the laws are given it, with a pull of 1: its energy is |p'|. */
PROCESSOR_INLINE void line_of(const strain_actuator *at, lanes given[ACTUATOR_NUMBERS])
{
    memcpy(given, at->given, ACTUATOR_NUMBERS * sizeof *given);
    given[ACTUATOR_PULL] = NO_LANES + 1;
}

/* That at a point of which the length has a share. */
PROCESSOR_INLINE void add_length(const strain_actuator *at, double share, const lanes v[3],
                                 const lanes u[3], lanes *sum)
{
    lanes given[ACTUATOR_NUMBERS], length = NO_LANES;
    if (share != 0) {
        line_of(at, given);
        lanes_law_tendon_energy(v, u, given, &length);
        *sum += share * length;
    }
}

/* Its derivatives by v, u there, of which the first are the tangent in the body, and theirs. */
PROCESSOR_INLINE void differentiate_length(const strain_form *form, int node, int actuator,
                                           lanes along[6], lanes bend[LAW_STIFFNESS])
{
    lanes given[ACTUATOR_NUMBERS];
    line_of(&form->actuators[node * form->kind.actuators + actuator], given);
    memset(along, 0, 6 * sizeof *along);
    memset(bend, 0, LAW_STIFFNESS * sizeof *bend);
    lanes_law_tendon(form->at[node].v, form->at[node].u, given, along, bend);
}

/* The part of a that an end holds. */
PROCESSOR_INLINE void held_part(const scene_hold *hold, const lanes a[3], lanes part[3])
{
    const double *d = hold->axis;
    const lanes along = a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
    for (int i = 0; i < 3; i++) {
        const double held[4] = {0, 0, 1, 1}, axial[4] = {0, d[i], -d[i], 0};
        part[i] = held[hold->directions] * a[i] + axial[hold->directions] * along;
    }
}

/* Of a position off by `off` and a force beyond what is given. */
PROCESSOR_INLINE void hold_row(const scene_hold *hold, const lanes off[3], const lanes beyond[3],
                               lanes row[3])
{
    lanes held[2][3];
    held_part(hold, off, held[0]);
    held_part(hold, beyond, held[1]);
    for (int i = 0; i < 3; i++) {
        row[i] = held[0][i] + beyond[i] - held[1][i];
    }
}

PROCESSOR_INLINE void turn_over(strain_edge *edge, lanes q[4])
{
    if (edge->turns) {
        lanes turn[4], next[4];
        for (int i = 0; i < 4; i++) {
            turn[i] = NO_LANES + edge->turn[i];
        }
        lanes_quaternion_product(q, turn, next);
        memcpy(q, next, sizeof next);
    }
}

/* Terms of a step of Magnus, magnus [3][GAUSS_STAGES_MAX], of a vector at the points of an element.
 */
PROCESSOR_INLINE void step_terms(const strain_form *form, int e, const double *magnus,
                                 const lanes *first, size_t stride, lanes a[3][3])
{
    for (int k = 0; k < 3; k++) {
        for (int c = 0; c < 3; c++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < form->kind.stages; j++) {
                sum += magnus[k * GAUSS_STAGES_MAX + j] * first[(size_t)j * stride + (size_t)c];
            }
            a[k][c] = sum * form->width[e];
        }
    }
}

/* By a change of u at the points of an element and a turn of its beginning, which becomes that of
 * its end: the turns of its points, by steps as strain_form_steps makes them. */
PROCESSOR_INLINE void turn_by_steps(const strain_form *form, lanes (*steps)[3][3][3], int e,
                                    const lanes *change, lanes turn[3], lanes (*at)[3])
{
    const int n = form->kind.stages;
    for (int i = 0; i <= n; i++) {
        lanes a[3][3];
        step_terms(form, e, form->magnus[i][0], change, 3, a);
        for (int k = 0; k < 3; k++) {
            add_applied(steps[e * (n + 1) + i][k], a[k], turn);
        }
        if (i < n) {
            memcpy(at[i], turn, sizeof at[i]);
        }
    }
}

/* Integrals over an element of rate [stages]: to its points and to its end from its beginning,
 * where `from` is known, */
PROCESSOR_INLINE void integrate_on(strain_form *form, int e, lanes (*rate)[3], const lanes from[3],
                                   lanes (*to)[3], lanes end[3])
{
    const int n = form->kind.stages;
    for (int k = 0; k < 3; k++) {
        lanes all = NO_LANES;
        for (int i = 0; i < n; i++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < n; j++) {
                sum += form->rule.matrix[i][j] * rate[j][k];
            }
            to[i][k] = from[k] + form->width[e] * sum;
            all += form->rule.weights[i] * rate[i][k];
        }
        end[k] = from[k] + form->width[e] * all;
    }
}

/* and from its points and its beginning to its end, where `end` is known. */
PROCESSOR_INLINE void integrate_back(strain_form *form, int e, lanes (*rate)[3], const lanes end[3],
                                     lanes (*to)[3], lanes start[3])
{
    const int n = form->kind.stages;
    for (int k = 0; k < 3; k++) {
        lanes all = NO_LANES;
        for (int i = 0; i < n; i++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < n; j++) {
                sum += form->tail[i][j] * rate[j][k];
            }
            to[i][k] = end[k] + form->width[e] * sum;
            all += form->rule.weights[i] * rate[i][k];
        }
        start[k] = end[k] + form->width[e] * all;
    }
}

#endif
