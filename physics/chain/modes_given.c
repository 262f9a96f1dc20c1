/* What a reduced rod is given at its points: only what time or inputs have changed. */
#include "physics/chain/modes_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whether a part has to be taken again; at first all do. */
static bool is_due(const modes *m, solve_part part, bool time_moved, bool input_moved)
{
    const solve_part_kind kind = solve_rod_part_kind(m->rod, part);
    return !m->has_given || (kind.by_t && time_moved) || (kind.by_parameters && input_moved);
}

static ad_status part(modes *m, solve_part which, size_t n, const double *s, double *out,
                      ad_error *error)
{
    const struct modes_affine *sum = &m->affine[which];
    if (!sum->base) {
        return solve_rod_part(m->rod, which, n, s, m->time, m->inputs > 0 ? m->inputs_at : NULL,
                              out, error);
    }
    memcpy(out, sum->base, sum->count * sizeof *out);
    for (int k = 0; k < m->inputs; k++) {
        const double by = m->input[k] - m->center[k], *slope = sum->slope + (size_t)k * sum->count;
        const size_t *of = sum->of + (size_t)k * sum->count;
        for (size_t i = 0; i < sum->changes[k]; i++) {
            out[of[i]] += by * slope[of[i]];
        }
    }
    return AD_OK;
}

/* Room for a part at all points is that of the matrices, which are not in use now. */
static double *room_for(const modes *m)
{
    return m->room;
}

static ad_status give_sections(modes *m, ad_error *error)
{
    const solve_section *made = (const solve_section *)room_for(m);
    ad_status status = part(m, SOLVE_SECTIONS, (size_t)m->points, m->s, room_for(m), error);
    for (int p = 0; p < m->points && status == AD_OK; p++) {
        modes_point *to = &m->point[p];
        if (to->weight == 0) {
            continue;
        }
        to->inertia.mass = to->weight * made[p].mass;
        to->inertia.added = to->weight * made[p].added_mass;
        for (int k = 0; k < 3; k++) {
            to->inertia.rotary[k] = to->weight * made[p].rotary_inertia[k];
        }
        memcpy(to->stiffness, made[p].stiffness, sizeof to->stiffness); /* 0: locked */
        memcpy(to->damping, made[p].damping, sizeof to->damping);
    }
    return status == AD_OK ? modes_branch_give(m, made, error) : status;
}

/* Modes count from the rest shape, and where that moves from the first. A strain without modes is
 * as the present one has it, which then stays (modes_create, find_rest). */
static void give_origin(const modes *m, int p)
{
    const modes_element *element = &m->element[p / (m->stages + 1)];
    modes_point *to = &m->point[p];
    bool stays[MODES_STRAINS];
    for (int c = 0; c < MODES_STRAINS; c++) {
        stays[c] = m->has_given && m->rod->rest_moves;
    }
    for (int k = element->own; k < element->end; k++) {
        stays[m->mode[k].strain] = m->has_given && m->rest_moves;
    }
    for (int c = 0; c < MODES_STRAINS; c++) {
        to->origin[c] = stays[c] ? to->origin[c] : to->rest[c];
    }
}

static ad_status give_rest(modes *m, ad_error *error)
{
    const solve_rest *rest = (const solve_rest *)room_for(m);
    ad_status status = part(m, SOLVE_REST, (size_t)m->points, m->s, room_for(m), error);
    for (int p = 0; p < m->points && status == AD_OK; p++) {
        modes_point *to = &m->point[p];
        memcpy(to->rest + MODES_V, rest[p].strain, sizeof rest[p].strain);
        memcpy(to->rest + MODES_U, rest[p].curvature, sizeof rest[p].curvature);
        memcpy(to->rest_rate + MODES_V, rest[p].strain_rate, sizeof rest[p].strain_rate);
        memcpy(to->rest_rate + MODES_U, rest[p].curvature_rate, sizeof rest[p].curvature_rate);
        const bool extends = p >= m->hinges * (m->stages + 1); /* hinges do not */
        if (m->feed.mode >= 0) {                               /* with the mode that feeds 0 */
            to->origin[MODES_V + 2] = extends;
            memset(to->rest_rate, 0, sizeof to->rest_rate); /* of the material */
        } else if (extends) {
            give_origin(m, p);
        }
    }
    modes_branch_rest(m);
    return status;
}

/* What acts at places, and the bodies there. */
static ad_status give_jumps(modes *m, ad_error *error)
{
    const double s = 0;
    solve_jumps *jumps = &m->rod->jumps;
    const ad_status status =
        jumps->numbers > 0 ? part(m, SOLVE_JUMPS, 1, &s, jumps->number, error) : AD_OK;
    for (int k = 0; k < jumps->count && status == AD_OK; k++) {
        if (m->jump_at[k] >= 0) {
            m->point[m->jump_at[k]].inertia = solve_jump_body(jumps, jumps->number, k);
        }
    }
    return status;
}

/* Dead loads, along the rod and at places. */
static void give_dead(modes *m)
{
    const solve_jumps *jumps = &m->rod->jumps;
    const acting *along = &m->rod->along;
    const acting_on anywhere = {m->start.position, m->start.rotation, NULL};
    for (int p = 0; p < m->points; p++) {
        modes_point *to = &m->point[p];
        memset(to->dead, 0, sizeof to->dead);
        acting_wrench(along, m->along + p * along->numbers, anywhere, ACTING_DEAD, to->weight,
                      to->dead);
    }
    for (int k = 0; k < jumps->count; k++) {
        if (m->jump_at[k] >= 0) {
            acting_wrench(&jumps->at[k].acting, solve_jump_numbers(jumps, jumps->number, k),
                          anywhere, ACTING_DEAD, 1, m->point[m->jump_at[k]].dead);
        }
    }
}

/* What an end is given where it is now, and as fast as inputs move it. */
static ad_status end_part(modes *m, int end, solve_end_state *out, ad_error *error)
{
    const double s = end;
    bool moves = false;
    for (int i = 0; i < 2 * m->inputs; i++) {
        moves = moves || m->rate[i] != 0;
    }
    return moves ? solve_rod_end_moving(m->rod, end, m->time, m->inputs_at, m->rate, out, error)
                 : part(m, end ? SOLVE_END : SOLVE_START, 1, &s, (double *)out, error);
}

void modes_move(modes *m, const double *rates)
{
    const size_t size = 2 * (size_t)m->inputs * sizeof *rates;
    for (int i = 0; i < 2 * m->inputs; i++) {
        m->has_moved = m->has_moved || m->rate[i] != (rates ? rates[i] : 0);
    }
    if (rates) {
        memcpy(m->rate, rates, size);
    } else if (size > 0) {
        memset(m->rate, 0, size);
    }
}

static ad_status give_upright(modes *m, ad_error *error)
{
    const double s = 0;
    solve_initial start;
    ad_status status = part(m, SOLVE_INITIAL, 1, &s, (double *)&start, error);
    memcpy(m->upright, start.rotation, sizeof m->upright);
    return status;
}

static ad_status give_start(modes *m, ad_error *error)
{
    ad_status status = end_part(m, 0, &m->start, error);
    if (m->hinges > 0 && m->turn.mode < 0) {
        const double still[3] = {0};
        memcpy(m->start.rotation, m->upright, sizeof m->upright);
        memcpy(m->start.spin, still, sizeof still);
        memcpy(m->start.spin_rate, still, sizeof still);
    }
    quaternion_normalize(m->start.rotation);
    return status;
}

static ad_status give_end(modes *m, ad_error *error)
{
    ad_status status = end_part(m, 1, &m->end.given, error);
    modes_end_given(m);
    return status;
}

/* Whether tendons run elsewhere in the sections than before. */
static bool guides_moved(modes *m)
{
    enum { GUIDE = sizeof m->guides[0] };
    bool moved = false;
    for (int i = 0; i < m->points * m->rod->actuators; i++) {
        const solve_actuator *at = &m->actuators[i];
        const double guide[] = {at->offset[0], at->offset[1], at->slope[0], at->slope[1]};
        moved = moved || memcmp(m->guides[i], guide, GUIDE) != 0;
        memcpy(m->guides[i], guide, GUIDE);
    }
    return moved;
}

ad_status modes_at(modes *m, double t, const double *inputs, ad_error *error)
{
    double given[SCENE_PARAMETERS_MAX], as_they_are[SCENE_PARAMETERS_MAX];
    if (!inputs) {
        modes_commands(m, as_they_are);
        inputs = as_they_are;
    }
    if (m->feed.input < 0 && m->turn.input < 0) {
        return modes_give(m, t, inputs, error);
    }
    memcpy(given, inputs, (size_t)m->inputs * sizeof *inputs);
    if (m->feed.input >= 0) {
        m->feed.command = inputs[m->feed.input];
        given[m->feed.input] = m->feed.out;
    }
    if (m->turn.input >= 0) {
        m->turn.command = inputs[m->turn.input];
        given[m->turn.input] = 0;
    }
    return modes_give(m, t, given, error);
}

ad_status modes_give(modes *m, double t, const double *inputs, ad_error *error)
{
    const bool time_moved = t != m->time;
    const size_t count = (size_t)m->inputs;
    const bool input_moved = count > 0 && memcmp(m->input, inputs, count * sizeof *inputs) != 0;
    ad_status status = AD_OK;
    bool due[SOLVE_PARTS];
    if (m->has_given && !time_moved && !input_moved && !m->has_moved) {
        return AD_OK;
    }
    m->time = t;
    if (input_moved || !m->has_given) {
        for (size_t p = 0; p < (size_t)m->points && count > 0; p++) {
            memcpy(m->inputs_at + p * count, inputs, count * sizeof *inputs);
        }
        for (size_t i = 0; i < count; i++) {
            m->input[i] = inputs[i];
        }
    }
    for (int i = 0; i < SOLVE_PARTS; i++) {
        const bool is_end = i == SOLVE_START || i == SOLVE_END;
        due[i] = is_due(m, (solve_part)i, time_moved, input_moved || (is_end && m->has_moved));
    }
    due[SOLVE_JUMPS] &= m->rod->jumps.count > 0;
    if (m->hinges > 0 && !m->has_given) {
        status = give_upright(m, error);
    }
    if (status == AD_OK && m->feed.mode >= 0 && m->feed.input < 0) {
        const double s = 0;
        status = part(m, SOLVE_FEED, 1, &s, m->feed.wanted, error);
    }
    if (status == AD_OK && due[SOLVE_SECTIONS]) {
        status = give_sections(m, error);
    }
    if (status == AD_OK && due[SOLVE_REST]) {
        status = give_rest(m, error);
    }
    if (status == AD_OK && due[SOLVE_ALONG] && m->rod->along.count > 0) {
        status = part(m, SOLVE_ALONG, (size_t)m->points, m->s, m->along, error);
    }
    if (status == AD_OK && due[SOLVE_START]) {
        status = give_start(m, error);
    }
    if (status == AD_OK && due[SOLVE_END] && m->end.directions > 0) {
        status = give_end(m, error);
    }
    if (status == AD_OK && due[SOLVE_JUMPS]) {
        status = give_jumps(m, error);
    }
    if (status == AD_OK && (due[SOLVE_ALONG] || due[SOLVE_JUMPS])) {
        give_dead(m);
    }
    if (status == AD_OK && due[SOLVE_ACTUATORS] && m->is_pulled) {
        status = part(m, SOLVE_ACTUATORS, (size_t)m->points, m->s, (double *)m->actuators, error);
    }
    if (status == AD_OK && m->rod->lengths > 0) {
        const bool moved = due[SOLVE_ACTUATORS] && guides_moved(m);
        if (moved || due[SOLVE_REST]) {
            modes_unstressed_lengths(m);
        }
    }
    m->has_given = status == AD_OK;
    m->has_moved = false;
    return status;
}

void modes_commands(const modes *m, double *inputs)
{
    memcpy(inputs, m->input, (size_t)m->inputs * sizeof *inputs);
    if (m->feed.input >= 0) {
        inputs[m->feed.input] = m->feed.command;
    }
    if (m->turn.input >= 0) {
        inputs[m->turn.input] = m->turn.command;
    }
}

/* ---- inputs -------------------------------------------------------------------------------- */

/* The part at inputs on a line through their ranges; out [count]. */
static ad_status part_at(const modes *m, solve_part which, size_t n, const double *s,
                         const double *inputs, double *room, double *out, ad_error *error)
{
    for (size_t p = 0; p < n; p++) {
        memcpy(room + p * (size_t)m->inputs, inputs, (size_t)m->inputs * sizeof *room);
    }
    return solve_rod_part(m->rod, which, n, s, m->time, room, out, error);
}

/* Slopes by the ends of each range, and whether the sum is met at other inputs. */
static ad_status find_affine(modes *m, solve_part which, size_t n, const double *s,
                             const double *low, const double *high, bool *met, ad_error *error)
{
    enum { CHECKS = 12 };
    const size_t count = n * solve_rod_part_kind(m->rod, which).width, inputs = (size_t)m->inputs;
    struct modes_affine *to = &m->affine[which];
    double at[SCENE_PARAMETERS_MAX];
    double *room = malloc((n * inputs + count + 1) * sizeof *room), *now = room + n * inputs;
    double *base = malloc((1 + inputs) * count * sizeof *base);
    size_t *of = calloc(inputs * count + inputs, sizeof *of);
    ad_status status = room && base && of ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    *to = (struct modes_affine){count, base, base ? base + count : NULL, of,
                                of ? of + inputs * count : NULL};
    *met = true;
    memcpy(at, m->center, inputs * sizeof *at);
    status = status == AD_OK ? part_at(m, which, n, s, at, room, base, error) : status;
    for (size_t k = 0; k < inputs && status == AD_OK; k++) {
        at[k] = high[k];
        status = part_at(m, which, n, s, at, room, now, error);
        for (size_t i = 0; i < count && status == AD_OK; i++) {
            to->slope[k * count + i] = (now[i] - base[i]) / (high[k] - m->center[k]);
            if (to->slope[k * count + i] != 0) {
                of[k * count + to->changes[k]++] = i;
            }
        }
        at[k] = m->center[k];
    }
    for (int check = 0; check < CHECKS && status == AD_OK && *met; check++) {
        for (size_t k = 0; k < inputs; k++) { /* corners, and places without a pattern */
            const double off = 0.618034 * (double)((size_t)check * inputs + k + 1);
            const double part = check < 2 ? check : off - floor(off);
            at[k] = low[k] + part * (high[k] - low[k]);
        }
        status = part_at(m, which, n, s, at, room, now, error);
        for (size_t i = 0; i < count && status == AD_OK; i++) {
            double sum = base[i], size = fabs(base[i]) + fabs(now[i]);
            for (size_t k = 0; k < inputs; k++) {
                sum += (at[k] - m->center[k]) * to->slope[k * count + i];
            }
            *met &= now[i] == sum || fabs(now[i] - sum) <= 1e-12 * size;
        }
    }
    free(room);
    if (status != AD_OK || !*met) {
        free(base);
        free(of);
        *to = (struct modes_affine){0};
    }
    return status;
}

ad_status modes_set_ranges(modes *m, const double *low, const double *high, ad_error *error)
{
    const double start = 0;
    ad_status status = AD_OK;
    for (int k = 0; k < m->inputs; k++) {
        m->center[k] = 0.5 * (low[k] + high[k]);
        m->input_step[k] = 1e-4 * (high[k] - low[k]);
    }
    for (int i = 0; i < SOLVE_PARTS && status == AD_OK; i++) {
        const solve_part_kind kind = solve_rod_part_kind(m->rod, (solve_part)i);
        const bool single = i == SOLVE_START || i == SOLVE_JUMPS;
        const bool counts = i != SOLVE_INITIAL && i != SOLVE_END && i != SOLVE_FEED;
        bool met;
        if (kind.width > 0 && kind.by_parameters && !kind.by_t && counts) {
            status = find_affine(m, (solve_part)i, single ? 1 : (size_t)m->points,
                                 single ? &start : m->s, low, high, &met, error);
        }
    }
    return status;
}

ad_status modes_by_inputs(modes *m, double t, const double *q, const double *v, const double *a,
                          double *by_inputs, ad_error *error)
{
    const int n = m->size;
    double inputs[SCENE_PARAMETERS_MAX], *residual = m->room;
    const bool moves = m->origin_moves || (m->feed.mode >= 0 && m->feed.input < 0) ||
                       (solve_rod_part_kind(m->rod, SOLVE_START).by_parameters && m->turn.mode < 0);
    ad_status status = AD_OK;
    modes_commands(m, inputs);
    for (int k = 0; k < m->inputs && status == AD_OK; k++) {
        const bool asked = !(m->unasked >> k & 1);
        for (int i = 0; i < n && !asked; i++) {
            by_inputs[i * m->inputs + k] = 0;
        }
        for (int side = 0; side < 2 && status == AD_OK && asked; side++) {
            const double sign = side ? 1 : -1, by = 2 * m->input_step[k];
            inputs[k] += sign * m->input_step[k];
            status = modes_at(m, t, inputs, error);
            inputs[k] -= sign * m->input_step[k];
            if (status == AD_OK && moves) {
                modes_shape(m, q, v, a);
            }
            modes_forces(m, false, residual);
            for (int i = 0; i < n; i++) {
                double *to = &by_inputs[i * m->inputs + k];
                *to = (side ? *to : 0) + sign * residual[i] / by;
            }
        }
    }
    return status == AD_OK ? modes_at(m, t, inputs, error) : status;
}
