/* What a reduced rod is given at its points: only what time or inputs have changed. */
#include "physics/solve/modes_internal.h"

#include <math.h>
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
    return solve_rod_part(m->rod, which, n, s, m->time, m->inputs > 0 ? m->inputs_at : NULL, out,
                          error);
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
        to->mass = to->weight * made[p].mass;
        for (int k = 0; k < 3; k++) {
            to->inertia[k] = to->weight * made[p].rotary_inertia[k];
            to->stiffness[MODES_V + k] = made[p].strain_stiffness[k]; /* 0: locked */
            to->stiffness[MODES_U + k] = made[p].curvature_stiffness[k];
            to->damping[MODES_V + k] = made[p].strain_damping[k];
            to->damping[MODES_U + k] = made[p].curvature_damping[k];
        }
    }
    return status;
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
        if (!m->has_given) {
            memcpy(to->origin, to->rest, sizeof to->origin);
        }
    }
    return status;
}

static void add_load(solve_load *to, double factor, const solve_load *load)
{
    const double *from = (const double *)load;
    double *sum = (double *)to;
    for (size_t i = 0; i < sizeof *to / sizeof *sum; i++) {
        sum[i] += factor * from[i];
    }
}

/* At s = 1, where nothing is held, as a load at a place: what is given counts in one frame. */
static solve_load end_load(const modes *m)
{
    const solve_end *end = &m->rod->ends[1];
    solve_load load = {{0}, {0}, {0}, {0}};
    memcpy(end->force_is_body ? load.body_force : load.force, m->last.force, sizeof load.force);
    memcpy(end->moment_is_body ? load.body_moment : load.moment, m->last.moment,
           sizeof load.moment);
    return load;
}

static ad_status give_loads(modes *m, ad_error *error)
{
    const solve_load *load = (const solve_load *)room_for(m);
    const solve_load at_end = end_load(m);
    ad_status status = part(m, SOLVE_LOAD, (size_t)m->points, m->s, room_for(m), error);
    for (int p = 0; p < m->points && status == AD_OK; p++) {
        modes_point *to = &m->point[p];
        memset(&to->load, 0, sizeof to->load);
        add_load(&to->load, to->weight, &load[p]);
        if (p == m->points - 1) {
            add_load(&to->load, 1, &at_end);
        }
    }
    for (int k = 0; k < m->rod->jumps.count && status == AD_OK; k++) {
        if (m->jump_at[k] >= 0) {
            add_load(&m->point[m->jump_at[k]].load, 1, &m->jump_load[k]);
        }
    }
    for (int p = 0; p < m->points && status == AD_OK; p++) {
        const double *all = (const double *)&m->point[p].load;
        m->point[p].is_loaded = false;
        for (size_t i = 0; i < sizeof(solve_load) / sizeof *all; i++) {
            m->point[p].is_loaded |= all[i] != 0;
        }
    }
    return status;
}

/* Of each place its load, of each spring its poses (rod_model.c). */
static ad_status give_jumps(modes *m, ad_error *error)
{
    const double s = 0;
    const size_t count = (size_t)m->rod->jumps.count;
    ad_status status = part(m, SOLVE_JUMPS, 1, &s, room_for(m), error);
    const double *pose = room_for(m) + count * sizeof(solve_load) / sizeof(double);
    if (status == AD_OK) {
        memcpy(m->jump_load, room_for(m), count * sizeof *m->jump_load);
    }
    for (int i = 0; i < m->rod->jumps.spring_count && status == AD_OK && m->inputs > 0; i++) {
        solve_spring *spring = &m->rod->jumps.springs[i];
        memcpy(spring->anchor, pose + 10 * i, sizeof spring->anchor);
        memcpy(spring->unloaded, pose + 10 * i + 3, sizeof spring->unloaded);
        memcpy(spring->upright, pose + 10 * i + 6, sizeof spring->upright);
    }
    return status;
}

static ad_status give_ends(modes *m, bool first, bool last, ad_error *error)
{
    const double s[2] = {0, 1};
    ad_status status = AD_OK;
    if (first) {
        status = part(m, SOLVE_START, 1, &s[0], (double *)&m->start, error);
        quaternion_normalize(m->start.rotation);
    }
    return status == AD_OK && last ? part(m, SOLVE_END, 1, &s[1], (double *)&m->last, error)
                                   : status;
}

ad_status modes_at(modes *m, double t, const double *inputs, ad_error *error)
{
    const bool time_moved = t != m->time;
    const size_t count = (size_t)m->inputs;
    const bool input_moved = count > 0 && memcmp(m->input, inputs, count * sizeof *inputs) != 0;
    ad_status status = AD_OK;
    bool due[SOLVE_PARTS];
    if (m->has_given && !time_moved && !input_moved) {
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
        due[i] = is_due(m, (solve_part)i, time_moved, input_moved);
    }
    due[SOLVE_JUMPS] &= m->rod->jumps.count > 0;
    if (due[SOLVE_SECTIONS]) {
        status = give_sections(m, error);
    }
    if (status == AD_OK && due[SOLVE_REST]) {
        status = give_rest(m, error);
    }
    status = status == AD_OK ? give_ends(m, due[SOLVE_START], due[SOLVE_END], error) : status;
    if (status == AD_OK && due[SOLVE_JUMPS]) {
        status = give_jumps(m, error);
    }
    if (status == AD_OK && (due[SOLVE_LOAD] || due[SOLVE_END] || due[SOLVE_JUMPS])) {
        status = give_loads(m, error);
    }
    if (status == AD_OK && due[SOLVE_ACTUATORS] && m->is_pulled) {
        status = part(m, SOLVE_ACTUATORS, (size_t)m->points, m->s, (double *)m->actuators, error);
    }
    m->has_given = status == AD_OK;
    return status;
}
