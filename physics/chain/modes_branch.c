/* A Maxwell branch beside the material: a spring of ratio K in series with a damper.
 *
 * The spring is stretched by d, of which the strain e beyond rest is the cause and the time T of
 * the branch the end (the standard linear solid: Zener, Elasticity and Anelasticity of Metals,
 * 1948):
 *
 *   n, m += ratio K d,   d_t = e_t - d/T,   d = 0 in a rod that has rested for long.
 *
 * T is the same all along a piece of the rod, so d is a sum of the modes of its strain with
 * coefficients that are states, too. A rest shape that moves has the part that modes can say. */
#include "physics/chain/modes_internal.h"

#include "physics/law/law_numbers.h"

#include <math.h>
#include <string.h>

bool modes_branch_any(const solve_section *section)
{
    return section->maxwell_rate > 0;
}

/* Points of the piece of a mode: the first, and the one behind. */
static int first_point(const modes *m, int mode)
{
    return m->mode[mode].first_element * (m->stages + 1);
}

static int end_point(const modes *m, int mode)
{
    return (m->mode[mode].last_element + 1) * (m->stages + 1);
}

bool modes_branch_as_before(const modes *m, int i)
{
    return i > 0 && first_point(m, m->branch.mode[i]) == first_point(m, m->branch.mode[i - 1]);
}

ad_status modes_branch_give(modes *m, const solve_section *made, ad_error *error)
{
    const double same = 1e-12;
    for (int i = 0; i < m->branch.count; i++) {
        const int a = m->branch.mode[i];
        const double rate = made[first_point(m, a)].maxwell_rate;
        for (int p = first_point(m, a); p < end_point(m, a); p++) {
            if (m->point[p].weight > 0 && !(fabs(made[p].maxwell_rate - rate) <= same * rate)) {
                return ad_fail(error, AD_BAD_INPUT,
                               "method modes: material.maxwell.time varies along a piece of the "
                               "rod; allowed: one that is the same all along each segment");
            }
        }
        m->branch.rate[a] = rate;
    }
    for (int p = 0; p < m->points && m->branch.count > 0; p++) {
        modes_point *to = &m->point[p];
        to->relaxing = made[p].maxwell_rate;
        for (int c = 0; c < MODES_STRAINS && to->weight > 0; c++) {
            to->branch[c] = made[p].maxwell_ratio * made[p].stiffness[c];
        }
    }
    return AD_OK;
}

void modes_branch_rest(modes *m)
{
    for (int i = 0; i < m->branch.count; i++) {
        const int a = m->branch.mode[i];
        double sum = 0, size = 0;
        for (int p = first_point(m, a); p < end_point(m, a); p++) {
            const double value = m->value[p * m->width + a], by = m->point[p].weight * value;
            sum += by * m->point[p].rest_rate[m->mode[a].strain];
            size += by * value;
        }
        m->branch.rest_rate[a] = -sum / size;
    }
}

void modes_stretch(modes *m, const double *d)
{
    for (int i = 0; i < m->branch.count; i++) {
        const int a = m->branch.mode[i];
        m->branch.stretch[a] = d ? d[a] : 0;
    }
}

void modes_branch_derivatives(modes *m)
{
    const int width = m->width;
    memset(m->branch.by, 0, (size_t)(m->size * width) * sizeof *m->branch.by);
    for (int e = m->hinges; e < m->elements && m->branch.count > 0; e++) {
        const modes_element *element = &m->element[e];
        for (int p = e * (m->stages + 1); p < (e + 1) * (m->stages + 1) - 1; p++) {
            const modes_point *at = &m->point[p];
            const double *value = m->value + p * width;
            double unused[MODES_STRAINS] = {0}, by[LAW_STIFFNESS] = {0};
            number_law_elastic(at->stretch, at->stretch + MODES_U, at->branch, unused, by);
            for (int b = element->own; b < element->end; b++) {
                for (int a = element->own; a < element->end; a++) {
                    m->branch.by[b * width + a] +=
                        at->weight * value[b] * value[a] *
                        by[law_entry(m->mode[b].strain, m->mode[a].strain)];
                }
            }
        }
    }
}

/* Of times, which formulas have: at one point of each piece. [size]; modes without a branch are
 * left out. */
static ad_status times_at(const modes *m, const double *inputs, double *times, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < m->branch.count && status == AD_OK; i++) {
        const int a = m->branch.mode[i];
        solve_section made;
        if (modes_branch_as_before(m, i)) {
            times[a] = times[m->branch.mode[i - 1]];
            continue;
        }
        status = solve_rod_part(m->rod, SOLVE_SECTIONS, 1, &m->s[first_point(m, a)], m->time,
                                inputs, (double *)&made, error);
        times[a] = 1 / made.maxwell_rate;
    }
    return status;
}

ad_status modes_branch_by_inputs(modes *m, double t, double *rate_by, double *rest_by,
                                 ad_error *error)
{
    const bool times = solve_rod_part_kind(m->rod, SOLVE_SECTIONS).by_parameters,
               rests = solve_rod_part_kind(m->rod, SOLVE_REST).by_parameters;
    const size_t n = (size_t)m->size;
    double inputs[SCENE_PARAMETERS_MAX], *now = m->room;
    ad_status status = AD_OK;
    modes_commands(m, inputs);
    memset(rate_by, 0, (size_t)m->inputs * n * sizeof *rate_by);
    memset(rest_by, 0, (size_t)m->inputs * n * sizeof *rest_by);
    for (int k = 0; k < m->inputs && (times || rests) && status == AD_OK; k++) {
        for (int side = -1; side <= 1 && status == AD_OK; side += 2) {
            const double by = side / (2 * m->input_step[k]);
            inputs[k] += side * m->input_step[k];
            status = rests ? modes_at(m, t, inputs, error) : AD_OK;
            status = status == AD_OK && times ? times_at(m, inputs, now, error) : status;
            inputs[k] -= side * m->input_step[k];
            for (int i = 0; i < m->branch.count && status == AD_OK; i++) {
                const int a = m->branch.mode[i], at = k * m->size + a;
                rate_by[at] += times ? by * now[a] : 0;
                rest_by[at] += rests ? by * m->branch.rest_rate[a] : 0;
            }
        }
    }
    status = status == AD_OK && rests ? modes_at(m, t, inputs, error) : status;
    for (int i = 0; i < m->inputs * m->size && times; i++) {
        const double rate = m->branch.rate[i % m->size];
        rate_by[i] *= -rate * rate;
    }
    return status;
}
