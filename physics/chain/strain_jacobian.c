#include "physics/chain/strain_jacobian.h"

#include "physics/chain/strain_inline.h"
#include "physics/chain/strain_jacobian_internal.h"
#include "physics/chain/strain_tubes.h"

#include <stdlib.h>

/* A tension, by EI/L^2, that is none: of a tendon that is slack, or just as long as it may be. */
static const double SLACK = 1e-7;

/* The matrix of the elimination leaves out what Magnus' steps of finite length add: each time that
 * share of what is missing is left. Where more is sought than the curvature, steps before. */
enum { AGAIN = 2, SETTLED = 2 };

void strain_jacobian_free(strain_jacobian *jacobian)
{
    if (jacobian) {
        strain_level_free(&jacobian->by);
        solve_rod_free(jacobian->changes);
        ad_memory_free(&jacobian->memory);
        free(jacobian);
    }
}

/* ---- making -------------------------------------------------------------------------------- */

static void allocate_lanes(strain_jacobian *x)
{
    const strain_form *form = level_of(x)->form, *fine = fine_of(x)->form;
    const size_t nodes = (size_t)form->nodes, edges = (size_t)form->kind.elements + 1;
    const size_t places = (size_t)form->place_count, rubs = (size_t)form->rub_count;
    const size_t finer = (size_t)fine->nodes, outputs = (size_t)fine_of(x)->outputs;
    const size_t unknowns = (size_t)form->unknowns, tensions = (size_t)form->tension_count;
    const size_t tubes = (size_t)form->kind.tubes;
    const size_t finer_edges = (size_t)fine->kind.elements + 1;
    AD_TAKE(x, sources.points, nodes);
    AD_TAKE(x, sources.edges, edges);
    AD_TAKE(x, sources.places, places);
    AD_TAKE(x, sources.lengths, tensions);
    AD_TAKE(x, sources.tangents, rubs * nodes);
    AD_TAKE(x, sources.tubes, tubes * nodes);
    AD_TAKE(x, sources.bases, tubes);
    AD_TAKE(x, sources.steps, nodes + edges);
    AD_TAKE(x, softness, nodes);
    AD_TAKE(x, sought, unknowns);
    AD_TAKE(x, left, nodes * 6);
    AD_TAKE(x, strains, nodes * 3);
    AD_TAKE(x, carried, nodes);
    AD_TAKE(x, fine.u, finer * 3);
    AD_TAKE(x, fine.v, finer * 3);
    AD_TAKE(x, fine.turning, finer * 3);
    AD_TAKE(x, fine.slopes, finer * 3);
    AD_TAKE(x, fine.carried, finer * 6);
    AD_TAKE(x, twisted, nodes * 2 * tubes);
    AD_TAKE(x, fine.twisted, finer * 2 * tubes);
    AD_TAKE(x, fine.edges, finer_edges);
    AD_TAKE(x, forces, 2 * outputs * x->carrying);
    AD_TAKE(x, turns, outputs);
    AD_TAKE(x, columns, (size_t)x->group->count * outputs * x->derived);
}

static ad_status allocate(strain_jacobian *x, ad_error *error)
{
    const size_t count = (size_t)x->group->count, outputs = (size_t)fine_of(x)->outputs;
    const size_t nodes = (size_t)level_of(x)->form->nodes;
    allocate_lanes(x);
    AD_TAKE(x, growth, LANES * outputs * count + 1);
    AD_TAKE(x, room, LANES * nodes * (1 + SCENE_PARAMETERS_MAX));
    for (int p = 0; p < STRAIN_PARTS; p++) {
        AD_TAKE(x, values[p], strain_level_part_room(&x->by, x->changes, p));
    }
    return ad_memory_status(&x->memory, error, "out of memory for derivatives of members");
}

ad_status strain_jacobian_create(strain_group *group, solve_rod *changes, strain_jacobian **result,
                                 ad_error *error)
{
    strain_jacobian *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        solve_rod_free(changes);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of members");
    }
    *x = (strain_jacobian){.group = group, .changes = changes};
    const strain_level *of = level_of(x);
    x->carrying = SOLVE_MEMBERS_FORCES + 2 * (size_t)of->form->kind.tubes;
    x->derived = SOLVE_MEMBERS_COLUMNS + x->carrying;
    ad_status status = strain_level_create(changes, of->stages, of->elements, of->edges, true, 0,
                                           NULL, &x->by, error);
    status = status == AD_OK ? allocate(x, error) : status;
    if (status != AD_OK) {
        strain_jacobian_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

/* ---- what is given changes ----------------------------------------------------------------- */

/* Of all parts and parameters. */
static ad_status find_changes(strain_jacobian *x, ad_error *error)
{
    strain_group *group = x->group;
    ad_status status = AD_OK;
    for (int p = 0; p < STRAIN_PARTS && status == AD_OK; p++) {
        if (strain_level_is_open(x->changes, p)) {
            status = strain_level_find(&x->by, x->changes, p, group->count, group->parameters,
                                       x->room, x->values[p], error);
        }
    }
    const solve_part_kind growth = solve_rod_part_kind(x->changes, SOLVE_GROWTH);
    const size_t outputs = LANES * (size_t)fine_of(x)->outputs;
    return status == AD_OK && growth.by_parameters && outputs > 0
               ? solve_rod_part(x->changes, SOLVE_GROWTH, outputs, group->outputs, 0, group->each,
                                x->growth, error)
               : status;
}

/* Of an actuator as the laws are given it, without its pull; what it is, with a pull of 1. */
PROCESSOR_INLINE void line_change(const strain_form *form, const strain_form *by, int node,
                                  int actuator, lanes given[ACTUATOR_NUMBERS],
                                  lanes change[ACTUATOR_NUMBERS])
{
    const int at = node * form->kind.actuators + actuator;
    line_of(&form->actuators[at], given);
    memcpy(change, by->actuators[at].given, ACTUATOR_NUMBERS * sizeof *change);
    change[ACTUATOR_PULL] = NO_LANES;
}

PROCESSOR_INLINE void soften(strain_form *form, int node, softness *to)
{
    strain_node *at = &form->at[node];
    const strain_point *point = &form->points[node];
    lanes soft[3][3], tubes[3];
    pulling pull;
    pull_all(form, node, &pull);
    tube_moment(form, node, tubes);
    lanes_to_body(at->R, at->N, to->left);
    lanes_to_body(at->R, at->M, to->left + 3);
    for (int i = 0; i < 3; i++) {
        to->left[i] -= pull.wrench[i];
        to->left[3 + i] -= pull.wrench[3 + i] + tubes[i];
        for (int j = 0; j < 3; j++) {
            soft[i][j] = (i == j) + point->compliance[i] * pull.stiffness[law_entry(i, j)];
            to->turned[i][j] = pull.stiffness[law_entry(3 + i, j)];
        }
    }
    invert(soft, to->inverse);
}

/* Pulls of actuators by their angles, of those with friction. */
PROCESSOR_INLINE void change_pull(const strain_form *form, const strain_form *by, int node,
                                  int actuator, lanes *pull)
{
    for (int k = 0; k < form->tension_count; k++) {
        if (form->tensions[k].actuator == actuator) {
            *pull = NO_LANES;
        }
    }
    for (int k = 0; k < form->rub_count; k++) {
        const strain_rub *of = &form->rubs[k];
        if (of->actuator == actuator) {
            const int at = node * form->kind.actuators + actuator;
            *pull = *pull * of->left[node] - by->rubs[k].friction * of->angle[node] *
                                                 form->actuators[at].given[ACTUATOR_PULL];
        }
    }
}

/* At a point, of the rod and its actuators. */
PROCESSOR_INLINE void change_point(strain_form *form, const strain_form *by, int node,
                                   softness *soft, strain_source *to)
{
    strain_node *at = &form->at[node];
    const strain_point *point = &form->points[node], *change = &by->points[node];
    lanes wrench[6] = {{0}}, v[3], missing[3], bent[3];
    for (int k = 0; k < form->kind.actuators; k++) {
        const int one = node * form->kind.actuators + k;
        lanes given[ACTUATOR_NUMBERS];
        memcpy(given, by->actuators[one].given, sizeof given);
        change_pull(form, by, node, k, &given[ACTUATOR_PULL]);
        lanes_law_actuator_wrench_change((int)form->kind.extents[k].law, at->v, at->u,
                                         form->actuators[one].given, given, wrench);
    }
    if (form->kind.law) { /* of strains beyond rest */
        pulling own;
        strain_form_law(form, node, 6, own.wrench, own.stiffness);
        for (int i = 0; i < 36; i++) {
            wrench[i / 6] -= own.stiffness[law_entry(i / 6, i % 6)] * change->rest[i % 6];
        }
    }
    for (int i = 0; i < 3; i++) {
        missing[i] = change->rest[i] + change->compliance[i] * soft->left[i] -
                     point->compliance[i] * wrench[i];
    }
    apply(soft->inverse, missing, v);
    apply(soft->turned, v, bent);
    for (int i = 3; i < 6; i++) {
        to->row[i - 3] = point->compliance[i] * (wrench[i] + bent[i - 3]) -
                         change->compliance[i] * soft->left[i] - change->rest[i];
    }
    lanes_to_world(at->R, v, to->slope);
}

/* Of laws along the rod, at a point; and at places, at their edges. */
static void change_loads(strain_jacobian *x, int node)
{
    strain_form *form = level_of(x)->form, *by = x->by.form;
    const acting *along = form->kind.along;
    const int first = node * along->numbers;
    const strain_node *at = &form->at[node];
    strain_source *to = &x->sources.points[node];
    lanes wrench[LAW_WRENCH];
    acting_lanes_change(along, form->along + first, by->along + first, false, at->r, at->q, wrench);
    memcpy(to->load, wrench, sizeof to->load);
    if (form->is_pushed) {
        acting_lanes_change(along, form->along + first, by->along + first, true, at->r, at->q,
                            wrench);
        memcpy(to->push, wrench, sizeof to->push);
        for (int c = 0; c < 3; c++) {
            to->load[1][c] += wrench[3 + c];
        }
    }
}

static void change_place(strain_jacobian *x, int k)
{
    strain_form *form = level_of(x)->form;
    const strain_place *place = &form->places[k];
    const strain_edge *edge = &form->edges[place->edge];
    const lanes *change = x->by.form->places[k].numbers;
    lanes wrench[LAW_WRENCH], (*to)[3] = x->sources.edges[place->edge];
    acting_lanes_change(place->acting, place->numbers, change, false, edge->r, edge->q, wrench);
    for (int c = 0; c < 6; c++) {
        to[c / 3][c % 3] += wrench[c];
    }
    if (place->acting->by_position) {
        acting_lanes_change(place->acting, place->numbers, change, true, edge->r, edge->q, wrench);
        memcpy(x->sources.places[k], wrench, sizeof x->sources.places[k]);
        for (int c = 0; c < 3 && place->acting->moment_by_position; c++) {
            to[1][c] += wrench[3 + c];
        }
    }
}

/* The turn, world, of q by a change of it. */
PROCESSOR_INLINE void turn_of(const lanes q[4], const lanes change[4], lanes turn[3])
{
    const lanes back[4] = {q[0], -q[1], -q[2], -q[3]};
    lanes half[4];
    lanes_quaternion_product(change, back, half);
    for (int c = 0; c < 3; c++) {
        turn[c] = 2 * half[1 + c];
    }
}

/* By how much tendons of given length are shorter than they may be: these may be as long as in the
 * unstressed rod. */
PROCESSOR_INLINE void change_lengths(strain_jacobian *x)
{
    strain_form *form = level_of(x)->form, *by = x->by.form;
    for (int k = 0; k < form->tension_count; k++) {
        const strain_tension *of = &form->tensions[k];
        lanes sum = by->tensions[k].compliance * of->pull - x->by.displaced[k];
        for (int i = 0; i < form->nodes; i++) {
            const lanes *rest = form->points[i].rest, *change = by->points[i].rest;
            lanes given[ACTUATOR_NUMBERS], moved[ACTUATOR_NUMBERS], along[6] = {{0}};
            lanes before = NO_LANES, now = NO_LANES;
            if (of->share[i] <= 0) {
                continue;
            }
            line_change(form, by, i, of->actuator, given, moved);
            lanes_law_tendon_wrench(rest, rest + 3, given, along);
            lanes_law_tendon_energy_change(rest, rest + 3, given, moved, &before);
            lanes_law_tendon_energy_change(form->at[i].v, form->at[i].u, given, moved, &now);
            for (int c = 0; c < 6; c++) {
                before += along[c] * change[c];
            }
            sum += of->share[i] * (before - now);
        }
        x->sources.lengths[k] = sum;
    }
}

PROCESSOR_INLINE void change_tangents(strain_jacobian *x)
{
    strain_form *form = level_of(x)->form;
    for (int k = 0; k < form->rub_count; k++) {
        for (int i = 0; i < form->nodes; i++) {
            lanes given[ACTUATOR_NUMBERS], moved[ACTUATOR_NUMBERS], along[6] = {{0}};
            line_change(form, x->by.form, i, form->rubs[k].actuator, given, moved);
            lanes_law_tendon_wrench_change(form->at[i].v, form->at[i].u, given, moved, along);
            memcpy(x->sources.tangents[k * form->nodes + i], along,
                   sizeof x->sources.tangents[k * form->nodes + i]);
        }
    }
}

PROCESSOR_INLINE void change_tubes(strain_jacobian *x)
{
    const strain_form *form = level_of(x)->form, *by = x->by.form;
    for (int k = 0; k < form->kind.tubes; k++) {
        const strain_tube *of = &form->tubes[k], *change = &by->tubes[k];
        lanes(*to)[LAW_WRENCH] = x->sources.tubes + k * form->nodes;
        memset(to, 0, (size_t)form->nodes * sizeof *to);
        for (int i = 0; i < form->nodes; i++) {
            lanes_law_tube_wrench_change(form->at[i].u, of->turn[i], of->numbers[i],
                                         change->numbers[i], to[i]);
        }
        x->sources.bases[k] = change->turned + change->yielding * of->base;
    }
}

FOR_EACH_PROCESSOR static void find_sources(strain_jacobian *x)
{
    const strain_level *level = level_of(x);
    strain_form *form = level->form, *by = x->by.form;
    strain_sources *to = &x->sources;
    for (int i = 0; i < form->nodes; i++) {
        change_point(form, by, i, &x->softness[i], &to->points[i]);
    }
    change_lengths(x);
    change_tangents(x);
    change_tubes(x);
    memcpy(to->start[0], by->start_r, sizeof by->start_r);
    memcpy(to->end[0], x->by.full_r, sizeof x->by.full_r);
    turn_of(form->start_q, by->start_q, to->start[1]);
    turn_of(level->full_q, x->by.full_q, to->end[1]);
}

static void find_loads(strain_jacobian *x)
{
    const strain_form *form = level_of(x)->form;
    for (int i = 0; i < form->nodes && form->kind.along->count > 0; i++) {
        change_loads(x, i);
    }
    memset(x->sources.edges, 0, ((size_t)form->kind.elements + 1) * sizeof *x->sources.edges);
    for (int k = 0; k < form->place_count; k++) {
        change_place(x, k);
    }
}

/* ---- what is sought changes ---------------------------------------------------------------- */

FOR_EACH_PROCESSOR static void find_softness(strain_jacobian *x)
{
    for (int i = 0; i < level_of(x)->form->nodes; i++) {
        soften(level_of(x)->form, i, &x->softness[i]);
    }
}

/* Where the rod is: equations as linear ones, shapes, steps. */
static void linearise(strain_jacobian *x)
{
    strain_form *form = level_of(x)->form;
    const lanes whole = NO_LANES + 1;
    const bool is_unloaded = form->is_unloaded;
    bool all[LANES];
    memset(all, true, sizeof all);
    for (int k = 0; k < SETTLED && form->unknowns > form->elastic; k++) {
        lanes length;
        strain_group_step(form, all, &length);
        strain_form_move(form, form->right, &whole);
    }
    strain_form_shape(form);
    form->is_unloaded = false; /* positions are asked for, too */
    strain_form_linearise(form);
    form->is_unloaded = is_unloaded;
    strain_form_solve(form);
    strain_form_say_taut(form, SLACK);
    strain_form_steps(form, x->sources.steps);
    find_softness(x);
    strain_group_place(x->group);
    strain_group_evaluate(x->group, x->group->modes + STRAIN_BEYOND);
}

/* x->sought, and strains by it, and what is carried where that is asked for. */
static void solve(strain_jacobian *x, bool carries)
{
    strain_form *form = level_of(x)->form;
    lanes(*strains)[6] = (lanes(*)[6])x->left;
    memset(x->sought, 0, (size_t)form->unknowns * sizeof *x->sought);
    for (int k = 0; k <= (form->is_unloaded ? 0 : AGAIN); k++) {
        strain_form_change(form, &x->sources, x->sought, form->right, strains, NULL);
        strain_form_solve_change(form);
        for (int i = 0; i < form->unknowns; i++) {
            x->sought[i] -= form->right[i];
        }
    }
    strain_form_change(form, &x->sources, x->sought, form->right, strains,
                       carries ? x->carried : NULL);
    for (int i = 0; i < form->nodes; i++) {
        memcpy(x->strains + 3 * i, strains[i], 3 * sizeof *x->strains);
    }
    for (int i = 0; i < form->nodes * form->kind.tubes; i++) {
        const int node = i / form->kind.tubes, k = i % form->kind.tubes;
        x->twisted[2 * i] = form->tube_turned[k * form->nodes + node];
        x->twisted[2 * i + 1] = x->sought[torsion_at(form, node, k)];
    }
    const strain_link *link = &x->group->beyond;
    strain_level_sample(link, level_of(x), fine_of(x), 3, x->sought, x->fine.u);
    strain_level_sample(link, level_of(x), fine_of(x), 3, x->strains, x->fine.v);
}

/* ---- all together -------------------------------------------------------------------------- */

ad_status strain_jacobian_run(strain_jacobian *x, size_t members, const double *parameters,
                              const double *curvature, int from, const strain_derived *to,
                              ad_error *error)
{
    const int count = x->group->count, copies = LANES / (int)members;
    const size_t outputs = (size_t)fine_of(x)->outputs;
    const bool slopes = to->jacobian || to->by;
    ad_status status = strain_group_take(x->group, members, parameters, curvature, error);
    status = status == AD_OK && slopes ? find_changes(x, error) : status;
    if (status != AD_OK) {
        return status;
    }
    linearise(x);
    if (to->forces || to->by) {
        strain_columns_carry(x);
    }
    if (to->forces) {
        strain_columns_put_forces(x, members, to->forces);
    }
    for (int first = from; first < count && slopes; first += copies) {
        lanes *columns = x->columns + (size_t)((first - from) / copies) * outputs * x->derived;
        int which[LANES];
        for (int lane = 0; lane < LANES; lane++) { /* of each parameter all members */
            const int parameter = first + lane / (int)members;
            which[lane] = parameter < count ? parameter : from;
        }
        strain_level_give_changes(&x->by, x->changes, count, which,
                                  (const double *const *)x->values);
        find_sources(x);
        find_loads(x);
        solve(x, to->by != NULL);
        strain_columns_find(x, to->by != NULL, which, columns);
    }
    strain_columns_put(x, members, (size_t)copies, (size_t)(count - from), to);
    return AD_OK;
}
