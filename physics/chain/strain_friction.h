/* Tendons with friction in the strain form (static_friction.h has the law): the angle by which such
 * a tendon has turned is sought at each point, and its row is that less what the shape makes of it.
 * For functions that are compiled FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_CHAIN_STRAIN_FRICTION_H
#define PHYSICS_CHAIN_STRAIN_FRICTION_H

#include "physics/chain/strain_inline.h"

/* Where the angle at a node is among what is sought. */
PROCESSOR_INLINE int angle_at(const strain_form *form, int node, int k)
{
    return form->angle_at + node * form->rub_count + k;
}

/* Whether a tendon runs along an element. */
PROCESSOR_INLINE bool runs_along(const strain_form *form, const strain_rub *of, int e)
{
    const solve_extent *extent = &form->kind.extents[of->actuator];
    const double middle = (form->kind.edges[e] + form->kind.edges[e + 1]) / 2;
    return extent->start < middle && middle < extent->end;
}

/* The integral of the turning of an element's points, to these and to its end. */
PROCESSOR_INLINE void add_turning(const strain_form *form, const lanes *turning, lanes *from,
                                  lanes *to)
{
    const int n = form->kind.stages;
    lanes end = *from;
    for (int i = 0; i < n; i++) {
        to[i] = *from;
        for (int j = 0; j < n; j++) {
            to[i] += form->rule.matrix[i][j] * turning[j];
        }
        end += form->rule.weights[i] * turning[i];
    }
    *from = end;
}

/* d/ds of a vector at the i-th point of an element, times its width. */
PROCESSOR_INLINE void slope_at(const strain_form *form, int i, lanes (*vectors)[3], lanes slope[3])
{
    for (int c = 0; c < 3; c++) {
        slope[c] = NO_LANES;
        for (int j = 0; j < form->kind.stages; j++) {
            slope[c] += form->slope[i][j] * vectors[j][c];
        }
    }
}

/* How much the points of an element turn, times the width, and what its changes are made of: at
 * each the tangent with its derivatives, and the direction in which it turns. */
PROCESSOR_INLINE void find_turning(strain_form *form, const strain_rub *of, int e, lanes *turning)
{
    const int n = form->kind.stages, first = e * n;
    for (int i = first; i < first + n; i++) {
        differentiate_length(form, i, of->actuator, of->along[i], of->bend[i]);
        lanes_to_world(form->at[i].R, of->along[i], of->tangent[i]);
    }
    for (int i = 0; i < n; i++) {
        lanes slope[3], square = NO_LANES;
        slope_at(form, i, of->tangent + first, slope);
        for (int c = 0; c < 3; c++) {
            square += slope[c] * slope[c];
        }
        const lanes positive = square + 1e-60; /* of one that does not turn, too */
        lanes inverse;
        lanes_inverse_root(&positive, &inverse);
        turning[i] = square * inverse;
        for (int c = 0; c < 3; c++) {
            of->across[first + i][c] = slope[c] * inverse;
        }
    }
}

/* What the shape makes of the angles. */
PROCESSOR_INLINE void measure_angles(strain_form *form)
{
    for (int k = 0; k < form->rub_count; k++) {
        const strain_rub *of = &form->rubs[k];
        lanes angle = NO_LANES, turning[GAUSS_STAGES_MAX];
        for (int e = 0; e < form->kind.elements; e++) {
            if (runs_along(form, of, e)) {
                find_turning(form, of, e, turning);
                add_turning(form, turning, &angle, of->measured + e * form->kind.stages);
            }
        }
    }
}

/* A change of a tendon's tension becomes what friction leaves of it at a node. */
PROCESSOR_INLINE void rub(const strain_form *form, int actuator, int node, lanes *change)
{
    for (int k = 0; k < form->rub_count; k++) {
        if (form->rubs[k].actuator == actuator) {
            *change *= form->rubs[k].left[node];
        }
    }
}

/* How much less tendons pull at a node by a change of what is sought: at its strains, force and
 * moment. */
PROCESSOR_INLINE void change_rubbed(strain_form *form, int node, const lanes *direction,
                                    lanes wrench[6])
{
    for (int k = 0; k < form->rub_count; k++) {
        const strain_rub *of = &form->rubs[k];
        const lanes pull =
            form->actuators[node * form->kind.actuators + of->actuator].given[ACTUATOR_PULL];
        const lanes less = of->friction * pull * direction[angle_at(form, node, k)];
        for (int c = 0; c < 6; c++) {
            wrench[c] -= less * of->along[node][c];
        }
    }
}

/* How the turning of an element's points changes, by how they have `turned` and are `strained`, and
 * by a change of the tangents [nodes] in the body; NULL: none. */
PROCESSOR_INLINE void change_turning(strain_form *form, const strain_rub *of,
                                     const lanes (*tangents)[3], int e, lanes *turning)
{
    const int n = form->kind.stages, first = e * n;
    lanes tangent[GAUSS_STAGES_MAX][3];
    for (int j = 0; j < n; j++) {
        const int node = first + j;
        lanes body[3], bent[3];
        for (int c = 0; c < 3; c++) {
            body[c] = NO_LANES;
            for (int i = 0; i < 6; i++) {
                body[c] += of->bend[node][law_entry(c, i)] * form->strained[node][i];
            }
            if (tangents) {
                body[c] += tangents[node][c];
            }
        }
        lanes_to_world(form->at[node].R, body, bent);
        lanes_vector_cross(form->turned[node], of->tangent[node], tangent[j]);
        add_lanes(3, bent, tangent[j]);
    }
    for (int i = 0; i < n; i++) {
        lanes slope[3];
        slope_at(form, i, tangent, slope);
        turning[i] = NO_LANES;
        for (int c = 0; c < 3; c++) {
            turning[i] += of->across[first + i][c] * slope[c];
        }
    }
}

/* The rows of angles; tangents [rub_count][nodes]. */
PROCESSOR_INLINE void rows_of_angles(strain_form *form, lanes (*tangents)[3],
                                     const lanes *direction, lanes *to)
{
    const int n = form->kind.stages;
    for (int k = 0; k < form->rub_count; k++) {
        const strain_rub *of = &form->rubs[k];
        lanes angle = NO_LANES, turning[GAUSS_STAGES_MAX], by[GAUSS_STAGES_MAX];
        for (int e = 0; e < form->kind.elements; e++) {
            memset(by, 0, sizeof by);
            if (runs_along(form, of, e)) {
                change_turning(form, of,
                               tangents ? (const lanes(*)[3])tangents + k * form->nodes : NULL, e,
                               turning);
                add_turning(form, turning, &angle, by);
            }
            for (int i = 0; i < n; i++) {
                const int row = angle_at(form, e * n + i, k);
                to[row] = direction[row] - by[i];
            }
        }
    }
}

#endif
