/* Concentric tubes in the strain form: the torsion of each is sought at the points and at s = 0, as
 * is what is left of it where the tube begins to be held. Theta follows from it from s = 0 on, and
 * what the law of a tube (physics/law/law.h) makes of m' from its end back:
 *
 *   theta' = -E_m,   theta(0) = turned + yielding m(0),   m(s) = -int_s^end E_theta
 *
 * The row of a torsion is it less that integral. As it is eliminated first, and as Gauss' rule has
 * of both integrals the same sums, what is left for curvatures is the second variation of the
 * energy by all that turns. For functions that are compiled FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_CHAIN_STRAIN_TUBES_H
#define PHYSICS_CHAIN_STRAIN_TUBES_H

#include "physics/chain/strain_inline.h"

/* Rows of the gradient of a tube's energy beyond those by u. */
enum { TUBE_THETA = 3, TUBE_TORSION = 4 };

/* Where the torsion at a node is among what is sought; node = -1: at s = 0. */
PROCESSOR_INLINE int torsion_at(const strain_form *form, int node, int k)
{
    return form->tube_at + (node + 1) * form->kind.tubes + k;
}

/* Whether a tube goes along an element. */
PROCESSOR_INLINE bool reaches(const strain_form *form, const strain_tube *of, int e)
{
    return (form->kind.edges[e] + form->kind.edges[e + 1]) / 2 < of->end;
}

/* How many elements it goes along. */
PROCESSOR_INLINE int elements_of(const strain_form *form, const strain_tube *of)
{
    int count = 0;
    while (count < form->kind.elements && reaches(form, of, count)) {
        count++;
    }
    return count;
}

/* The integral of a rate over an element, beyond what it is before: from its beginning to its
 * points and its end, or from its end back. */
PROCESSOR_INLINE void sum_on(const strain_form *form, int e, bool back, const lanes *rate,
                             lanes *before, lanes *to)
{
    const int n = form->kind.stages;
    lanes all = NO_LANES;
    for (int i = 0; i < n; i++) {
        const double *by = back ? form->tail[i] : form->rule.matrix[i];
        lanes sum = NO_LANES;
        for (int j = 0; j < n; j++) {
            sum += by[j] * rate[j];
        }
        to[i] = *before + form->width[e] * sum;
        all += form->rule.weights[i] * rate[i];
    }
    *before += form->width[e] * all;
}

/* Theta at the points, as its cosine and sine, and the law there. */
PROCESSOR_INLINE void turn_tube(strain_form *form, const strain_tube *of, int last)
{
    const int n = form->kind.stages;
    lanes theta = of->turned + of->yielding * of->base;
    for (int e = 0; e < last; e++) {
        lanes rate[GAUSS_STAGES_MAX], angle[GAUSS_STAGES_MAX];
        for (int i = 0; i < n; i++) {
            const int node = e * n + i;
            lanes by[LAW_WRENCH] = {{0}};
            of->turn[node][2] = of->torsion[node];
            lanes_law_tube_wrench(form->at[node].u, of->turn[node], of->numbers[node], by);
            rate[i] = -by[TUBE_TORSION]; /* of any theta */
        }
        sum_on(form, e, false, rate, &theta, angle);
        for (int i = 0; i < n; i++) {
            const int node = e * n + i;
            of->theta[node] = angle[i];
            for (int lane = 0; lane < LANES; lane++) {
                of->turn[node][0][lane] = cos(angle[i][lane]);
                of->turn[node][1][lane] = sin(angle[i][lane]);
            }
            memset(of->gradient[node], 0, sizeof of->gradient[node]);
            memset(of->second[node], 0, sizeof of->second[node]);
            lanes_law_tube(form->at[node].u, of->turn[node], of->numbers[node], of->gradient[node],
                           of->second[node]);
        }
    }
    for (int i = last * n; i < form->nodes; i++) {
        of->theta[i] = theta;
    }
}

/* What the shape makes of torsions, and what tubes add to the moment of the rod. */
PROCESSOR_INLINE void measure_tubes(strain_form *form)
{
    const int n = form->kind.stages;
    for (int k = 0; k < form->kind.tubes; k++) {
        strain_tube *of = &form->tubes[k];
        const int last = elements_of(form, of);
        lanes torsion = NO_LANES;
        turn_tube(form, of, last);
        for (int e = last - 1; e >= 0; e--) {
            lanes rate[GAUSS_STAGES_MAX];
            for (int i = 0; i < n; i++) {
                rate[i] = -of->gradient[e * n + i][TUBE_THETA];
            }
            sum_on(form, e, true, rate, &torsion, of->measured + e * n);
        }
        of->base_measured = torsion;
    }
}

/* What all tubes add to the moment at a node. */
PROCESSOR_INLINE void tube_moment(const strain_form *form, int node, lanes moment[3])
{
    memset(moment, 0, 3 * sizeof *moment);
    for (int k = 0; k < form->kind.tubes; k++) { /* 0 beyond its end */
        add_lanes(3, form->tubes[k].gradient[node], moment);
    }
}

/* Rows of the gradient of a tube's energy as they change with u and m. */
PROCESSOR_INLINE void tube_change(const strain_tube *of, int node, int row, const lanes u[3],
                                  const lanes *torsion, lanes *sum)
{
    *sum = of->second[node][law_entry(row, TUBE_TORSION)] * *torsion;
    for (int c = 0; c < 3; c++) {
        *sum += of->second[node][law_entry(row, c)] * u[c];
    }
}

/* The rows of torsions, and what the moment of a tube adds to those of curvatures. gradients
 * [nodes], base: by themselves, NULL: 0. */
PROCESSOR_INLINE void rows_of_tube(strain_form *form, int k, lanes (*gradients)[LAW_WRENCH],
                                   const lanes *base, const lanes *direction, lanes *to)
{
    const strain_tube *of = &form->tubes[k];
    const int n = form->kind.stages, last = elements_of(form, of);
    lanes theta = of->yielding * direction[torsion_at(form, -1, k)], torsion = NO_LANES;
    lanes rate[GAUSS_STAGES_MAX], measured[GAUSS_STAGES_MAX];
    lanes *turned = form->tube_turned + k * form->nodes;
    if (base) {
        theta += *base;
    }
    for (int e = 0; e < last; e++) {
        for (int i = 0; i < n; i++) {
            const int node = e * n + i;
            lanes by;
            tube_change(of, node, TUBE_TORSION, direction + 3 * node,
                        &direction[torsion_at(form, node, k)], &by);
            if (gradients) {
                by += gradients[node][TUBE_TORSION];
            }
            rate[i] = -by;
        }
        sum_on(form, e, false, rate, &theta, turned + e * n);
    }
    for (int e = form->kind.elements - 1; e >= 0; e--) {
        for (int i = 0; i < n && e < last; i++) {
            const int node = e * n + i;
            lanes by[TUBE_THETA + 1];
            for (int c = 0; c <= TUBE_THETA; c++) {
                tube_change(of, node, c, direction + 3 * node,
                            &direction[torsion_at(form, node, k)], &by[c]);
                by[c] += of->second[node][law_entry(c, TUBE_THETA)] * turned[node];
                if (gradients) {
                    by[c] += gradients[node][c];
                }
            }
            for (int c = 0; c < 3; c++) {
                to[3 * node + c] += form->points[node].compliance[3 + c] * by[c];
            }
            rate[i] = -by[TUBE_THETA];
        }
        memset(measured, 0, sizeof measured);
        if (e < last) {
            sum_on(form, e, true, rate, &torsion, measured);
        }
        for (int i = e * n; i < (e + 1) * n && e >= last; i++) {
            turned[i] = theta;
        }
        for (int i = 0; i < n; i++) {
            const int row = torsion_at(form, e * n + i, k);
            to[row] = direction[row] - measured[i];
        }
    }
    to[torsion_at(form, -1, k)] = direction[torsion_at(form, -1, k)] - torsion;
}

#endif
