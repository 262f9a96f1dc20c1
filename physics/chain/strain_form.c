#include "physics/chain/strain_form.h"

#include "physics/local/mesh.h"
#include "physics/local/strain_algebra.h"

#include <stdlib.h>

/* ---- making -------------------------------------------------------------------------------- */

static void set_magnus(strain_form *form)
{
    const int n = form->kind.stages, parts = form->kind.substeps;
    const gauss_rule *rule = &form->rule;
    for (int i = 0; i < (n + 1) * parts; i++) {
        const int next = i / parts;
        double from = next > 0 ? rule->nodes[next - 1] : 0, to = next < n ? rule->nodes[next] : 1;
        double h = (to - from) / parts, start = from + h * (i % parts);
        gauss_magnus(rule, start, start + h, form->magnus[i]);
    }
}

/* Whether forces along the rod are sought. */
static bool is_sought(const strain_kind *kind)
{
    return kind->along && kind->along->force_by_position;
}

static size_t numbers_along(const strain_kind *kind)
{
    return kind->along ? (size_t)kind->along->numbers : 0;
}

static ad_status check_laws(const strain_kind *kind, ad_error *error)
{
    bool resists = kind->along && kind->along->by_velocity;
    for (int i = 0; kind->jumps && i < kind->jumps->count; i++) {
        resists = resists || kind->jumps->at[i].acting.by_velocity;
    }
    return resists
               ? ad_fail(error, AD_BAD_ARGUMENT,
                         "the strain form is of rods at rest, and a law depends on the velocity")
               : AD_OK;
}

/* What laws along the rod are asked, and whether a moment depends on the place. */
static void sort_laws(strain_form *form)
{
    const strain_kind *kind = &form->kind;
    const acting *along = kind->along;
    for (int i = 0; along && i < along->count; i++) {
        const law *one = &law_table[along->law[i]];
        const bool turns = one->by_rotation && !law_force_by_position(one);
        form->turns |= turns;
        form->follows |= turns && one->has_force;
    }
    form->is_pushed = along && along->by_position;
    form->is_full = along && along->moment_by_position;
    for (int i = 0; kind->jumps && i < kind->jumps->count; i++) {
        form->is_full = form->is_full || kind->jumps->at[i].acting.by_position;
    }
}

/* Whether nothing acts but what pulls within the section, tubes among it: at points, at places, by
 * the ends.
 * Tensions that are sought are such pulls; how they change a shape that shears asks for more. */
static bool is_unloaded(const strain_form *form)
{
    const strain_kind *kind = &form->kind;
    const int within = form->elastic + kind->tubes * (form->nodes + 1);
    bool acts = form->tension_at > within || (form->tension_count > 0 && kind->shears) ||
                (kind->along && kind->along->count > 0);
    for (int i = 0; kind->jumps && i < kind->jumps->count; i++) {
        acts = acts || kind->jumps->at[i].acting.count > 0;
    }
    return !acts;
}

/* Numbers those unknowns that are no curvatures. */
static void number_unknowns(strain_form *form)
{
    const strain_kind *kind = &form->kind;
    int *first[] = {&form->force_at, &form->moment_at, &form->push_at};
    const int count[] = {kind->end.hold.directions > 0 ? 3 : 0, kind->end.holds_rotation ? 3 : 0,
                         is_sought(kind) ? 3 * form->nodes : 0};
    form->elastic = form->unknowns = 3 * form->nodes;
    for (int i = 0; i < 3; i++) {
        *first[i] = count[i] > 0 ? form->unknowns : -1;
        form->unknowns += count[i];
        form->holding += i < 2 ? count[i] : 0;
    }
    for (int i = 0; i < kind->actuators && kind->seeks_tensions; i++) {
        form->rub_count += kind->extents[i].rubs;
    }
    form->angle_at = form->unknowns;
    form->unknowns += form->rub_count * form->nodes;
    form->tube_at = form->unknowns;
    form->unknowns += kind->tubes * (form->nodes + 1);
}

/* After all others, which have the matrix. */
static void number_tensions(strain_form *form)
{
    const strain_kind *kind = &form->kind;
    form->tension_at = form->unknowns;
    for (int i = 0; i < kind->actuators && kind->seeks_tensions; i++) {
        form->tension_count += kind->extents[i].has_length;
    }
    form->unknowns += form->tension_count;
}

/* Tendons whose tension is sought, and by which points their length is measured. */
static bool add_tensions(strain_form *form)
{
    const strain_kind *kind = &form->kind;
    const size_t count = (size_t)form->tension_count, nodes = (size_t)form->nodes;
    const size_t each = 6 * nodes + (size_t)form->unknowns;
    AD_TAKE(form, tensions, count);
    const size_t border = count > 0 ? 2 * (size_t)form->unknowns : 0;
    AD_TAKE(form, tension_room, count * (each + count) + border);
    AD_TAKE(form, tension_shares, count * nodes);
    AD_TAKE(form, pulled, nodes);
    AD_TAKE(form, taut, LANES * count * count);
    AD_TAKE(form, taut_pivots, LANES * count);
    if (form->memory.is_short) {
        return false;
    }
    form->shorter = form->tension_room + count * each;
    form->border = form->shorter + count * count;
    for (int i = 0, k = 0; i < kind->actuators && k < form->tension_count; i++) {
        const solve_extent *extent = &kind->extents[i];
        if (!extent->has_length) {
            continue;
        }
        lanes *room = form->tension_room + (size_t)k * each;
        strain_tension *to = &form->tensions[k];
        *to = (strain_tension){.actuator = i,
                               .compliance = NO_LANES + extent->compliance,
                               .share = form->tension_shares + (size_t)k * nodes,
                               .along = (lanes(*)[6])room,
                               .bent = room + 6 * nodes};
        for (int j = 0; j < form->nodes; j++) {
            const int e = j / kind->stages;
            const double s = kind->edges[e] + form->width[e] * form->rule.nodes[j % kind->stages];
            const double whole = form->width[e] * form->rule.weights[j % kind->stages];
            to->share[j] = extent->start <= s && s <= extent->end ? whole : 0;
        }
        k++;
    }
    return true;
}

/* Tendons with friction. */
static bool add_rubs(strain_form *form)
{
    enum { EACH = 4 + 6 + LAW_STIFFNESS + 3 + 3 };
    const strain_kind *kind = &form->kind;
    const size_t count = (size_t)form->rub_count, nodes = (size_t)form->nodes;
    AD_TAKE(form, rubs, count);
    AD_TAKE(form, rub_room, count * nodes * EACH);
    AD_TAKE(form, strained, count > 0 ? nodes : 0);
    AD_TAKE(form, turned, count > 0 ? nodes : 0);
    if (form->memory.is_short) {
        return false;
    }
    lanes *room = form->rub_room;
    for (int i = 0, k = 0; i < kind->actuators && k < form->rub_count; i++) {
        if (kind->extents[i].rubs) {
            form->rubs[k++] = (strain_rub){.actuator = i,
                                           .pull = room,
                                           .left = room + nodes,
                                           .angle = room + 2 * nodes,
                                           .measured = room + 3 * nodes,
                                           .along = (lanes(*)[6])(room + 4 * nodes),
                                           .tangent = (lanes(*)[3])(room + 10 * nodes),
                                           .across = (lanes(*)[3])(room + 13 * nodes),
                                           .bend = (lanes(*)[LAW_STIFFNESS])(room + 16 * nodes)};
            room += EACH * nodes;
        }
    }
    gauss_slope(&form->rule, form->slope);
    return true;
}

static bool add_tubes(strain_form *form)
{
    enum { EACH = 3 + LAW_TUBE_GIVEN + 3 + LAW_WRENCH + LAW_STIFFNESS };
    const size_t count = (size_t)form->kind.tubes, nodes = (size_t)form->nodes;
    AD_TAKE(form, tubes, count);
    AD_TAKE(form, tube_room, count * nodes * EACH);
    AD_TAKE(form, tube_turned, count * nodes);
    if (form->memory.is_short) {
        return false;
    }
    lanes *room = form->tube_room;
    for (size_t k = 0; k < count; k++, room += EACH * nodes) {
        lanes *laws = room + 3 * nodes;
        form->tubes[k] = (strain_tube){
            .end = form->kind.extents[form->kind.actuators + (int)k].end,
            .torsion = room,
            .measured = room + nodes,
            .theta = room + 2 * nodes,
            .numbers = (lanes(*)[LAW_TUBE_GIVEN])laws,
            .turn = (lanes(*)[3])(laws + LAW_TUBE_GIVEN * nodes),
            .gradient = (lanes(*)[LAW_WRENCH])(laws + (LAW_TUBE_GIVEN + 3) * nodes),
            .second = (lanes(*)[LAW_STIFFNESS])(laws + (LAW_TUBE_GIVEN + 3 + LAW_WRENCH) * nodes)};
    }
    return true;
}

ad_status strain_form_create(const strain_kind *kind, strain_form **result, ad_error *error)
{
    *result = NULL;
    ad_status status = check_laws(kind, error);
    strain_form *form = status == AD_OK ? calloc(1, sizeof *form) : NULL;
    if (!form) {
        return status != AD_OK ? status
                               : ad_fail(error, AD_NO_MEMORY, "out of memory for a strain form");
    }
    *form = (strain_form){.kind = *kind,
                          .rule = solve_gauss_rule_of(kind->stages),
                          .nodes = kind->stages * kind->elements};
    size_t nodes = (size_t)form->nodes, elements = (size_t)kind->elements;
    sort_laws(form);
    number_unknowns(form);
    const int places = kind->jumps ? kind->jumps->count : 0;
    form->is_full = form->is_full || form->unknowns > form->elastic;
    number_tensions(form);
    form->is_unloaded = is_unloaded(form);
    form->unknowns += 3 * places; /* at most */
    size_t unknowns = (size_t)form->unknowns, each = 3 * (size_t)kind->stages;
    size_t numbers = form->is_full ? unknowns * unknowns : elements * each * each;
    const size_t held = (size_t)(form->holding + form->tension_count + 1) * (size_t)form->elastic;
    numbers = numbers > held ? numbers : held; /* a column of each (strain_answer.c) */
    AD_TAKE(form, width, elements);
    AD_TAKE(form, points, nodes);
    AD_TAKE(form, actuators, nodes * (size_t)kind->actuators);
    AD_TAKE(form, at, nodes);
    AD_TAKE(form, edges, elements + 1);
    AD_TAKE(form, along, nodes * numbers_along(kind));
    AD_TAKE(form, pushes, form->is_pushed ? nodes : 0);
    AD_TAKE(form, numbers, kind->jumps ? (size_t)kind->jumps->numbers : 0);
    AD_TAKE(form, places, (size_t)places);
    AD_TAKE(form, matrix, kind->is_rigid ? 0 : numbers);
    AD_TAKE(form, coupled, kind->is_rigid ? 0 : 3 * unknowns);
    AD_TAKE(form, right, unknowns);
    AD_TAKE(form, swapped, unknowns);
    AD_TAKE(form, direction, unknowns);
    form->columns = ad_memory_take(&form->memory, nodes + elements + 1,
                                   15 * sizeof(lanes)); /* strain_matrix.c */
    if (form->memory.is_short) {
        strain_form_free(form);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", nodes);
    }
    for (int e = 0; e < kind->elements; e++) {
        form->width[e] = kind->edges[e + 1] - kind->edges[e];
    }
    for (int i = 0; i < kind->stages; i++) {
        for (int j = 0; j < kind->stages; j++) {
            form->tail[i][j] = form->rule.weights[j] - form->rule.matrix[i][j];
        }
    }
    set_magnus(form);
    if (!add_tensions(form) || !add_rubs(form) || !add_tubes(form)) {
        strain_form_free(form);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", nodes);
    }
    form->unknowns -= 3 * places;
    form->start_q[0] += 1;
    *result = form;
    return AD_OK;
}

/* Lane by lane. */
void strain_form_law(const strain_form *form, int node, int rows, lanes wrench[6], lanes *stiffness)
{
    const strain_node *at = &form->at[node];
    const lanes *rest = form->points[node].rest;
    double strains[6], stress[6], tangent[6][6];
    for (int lane = 0; lane < LANES; lane++) {
        for (int i = 0; i < 6; i++) {
            strains[i] = (i < 3 ? at->v[i] : at->u[i - 3])[lane] - rest[i][lane];
        }
        scene_law_beyond(form->kind.law, form->kind.length, form->kind.force, strains, stress,
                         tangent);
        for (int i = 0, k = 0; i < 6; i++) {
            wrench[i][lane] = stress[i];
            for (int j = i; j < rows; j++) {
                stiffness[k++][lane] = tangent[i][j];
            }
        }
    }
}

void strain_form_set_jumps(strain_form *form)
{
    const solve_jumps *jumps = form->kind.jumps;
    for (int e = 0, next = 0; e <= form->kind.elements && next < jumps->count; e++) {
        const solve_jump *jump = &jumps->at[next];
        strain_edge *edge = &form->edges[e];
        if (fabs(jump->s - form->kind.edges[e]) >= SOLVE_SAME_PLACE) {
            continue;
        }
        next++;
        edge->turns = jump->turns;
        memcpy(edge->turn, jump->turn, sizeof edge->turn);
        if (jump->acting.count > 0) {
            strain_place *to = &form->places[form->place_count++];
            *to = (strain_place){.edge = e,
                                 .unknown = -1,
                                 .acting = &jump->acting,
                                 .numbers = form->numbers + jump->first};
            if (jump->acting.force_by_position) {
                to->unknown = form->tension_at;
                form->tension_at += 3;
                form->unknowns += 3;
            }
        }
    }
}

lanes *strain_form_unknown(strain_form *form, int i)
{
    if (i < form->elastic) {
        return &form->at[i / 3].u[i % 3];
    }
    if (i >= form->tension_at) {
        return &form->tensions[i - form->tension_at].pull;
    }
    if (form->push_at >= 0 && i >= form->push_at && i < form->push_at + form->elastic) {
        return &form->at[(i - form->push_at) / 3].push[(i - form->push_at) % 3];
    }
    const int angle = i - form->angle_at;
    if (angle >= 0 && angle < form->rub_count * form->nodes) {
        return &form->rubs[angle % form->rub_count].angle[angle / form->rub_count];
    }
    const int torsion = i - form->tube_at, tubes = form->kind.tubes;
    if (torsion >= 0 && torsion < tubes * (form->nodes + 1)) {
        strain_tube *tube = &form->tubes[torsion % tubes];
        return torsion < tubes ? &tube->base : &tube->torsion[torsion / tubes - 1];
    }
    for (int k = 0; k < form->place_count; k++) {
        const int at = form->places[k].unknown;
        if (at >= 0 && i >= at && i < at + 3) {
            return &form->places[k].force[i - at];
        }
    }
    return form->force_at >= 0 && i < form->force_at + 3 ? &form->end_force[i - form->force_at]
                                                         : &form->end_moment[i - form->moment_at];
}

void strain_form_free(strain_form *form)
{
    if (form) {
        ad_memory_free(&form->memory);
        free(form);
    }
}
