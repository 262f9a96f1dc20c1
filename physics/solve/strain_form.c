#include "physics/solve/strain_form.h"

#include "physics/solve/mesh.h"
#include "physics/solve/strain_algebra.h"

#include <stdlib.h>

/* ---- making -------------------------------------------------------------------------------- */

static void set_magnus(strain_form *x)
{
    const int n = x->kind.stages, parts = x->kind.substeps;
    const gauss_rule *rule = &x->rule;
    for (int i = 0; i < (n + 1) * parts; i++) {
        const int next = i / parts;
        double from = next > 0 ? rule->nodes[next - 1] : 0, to = next < n ? rule->nodes[next] : 1;
        double h = (to - from) / parts, start = from + h * (i % parts);
        gauss_magnus(rule, start, start + h, x->magnus[i]);
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
static void sort_laws(strain_form *x)
{
    const strain_kind *kind = &x->kind;
    const acting *along = kind->along;
    for (int i = 0; along && i < along->count; i++) {
        const law *one = &law_table[along->law[i]];
        const bool turns = one->by_rotation && !law_force_by_position(one);
        x->turns |= turns;
        x->follows |= turns && one->has_force;
    }
    x->is_pushed = along && along->by_position;
    x->is_full = along && along->moment_by_position;
    for (int i = 0; kind->jumps && i < kind->jumps->count; i++) {
        x->is_full = x->is_full || kind->jumps->at[i].acting.by_position;
    }
}

/* Whether nothing acts but what pulls within the section: at points, at places, by the ends. */
static bool is_unloaded(const strain_form *x)
{
    const strain_kind *kind = &x->kind;
    bool acts = kind->is_one || x->unknowns > x->elastic || (kind->along && kind->along->count > 0);
    for (int i = 0; kind->jumps && i < kind->jumps->count; i++) {
        acts = acts || kind->jumps->at[i].acting.count > 0;
    }
    return !acts;
}

/* Numbers those unknowns that are no curvatures. */
static void number_unknowns(strain_form *x)
{
    const strain_kind *kind = &x->kind;
    int *first[] = {&x->force_at, &x->moment_at, &x->shift_at, &x->turn_at, &x->push_at};
    const int count[] = {kind->end.hold.directions > 0 ? 3 : 0, kind->end.holds_rotation ? 3 : 0,
                         kind->free_position ? 3 : 0, kind->free_rotation ? 3 : 0,
                         is_sought(kind) ? 3 * x->nodes : 0};
    x->elastic = x->unknowns = 3 * x->nodes;
    for (int i = 0; i < 5; i++) {
        *first[i] = count[i] > 0 ? x->unknowns : -1;
        x->unknowns += count[i];
        x->holding += i < 4 ? count[i] : 0;
    }
    for (int i = 0; i < kind->actuators && kind->seeks_tensions; i++) {
        x->rub_count += kind->extents[i].rubs;
    }
    x->angle_at = x->unknowns;
    x->unknowns += x->rub_count * x->nodes;
}

/* After all others, which have the matrix. */
static void number_tensions(strain_form *x)
{
    const strain_kind *kind = &x->kind;
    x->tension_at = x->unknowns;
    for (int i = 0; i < kind->actuators && kind->seeks_tensions; i++) {
        x->tension_count += kind->extents[i].has_length;
    }
    x->unknowns += x->tension_count;
}

/* Zeros where no number of all lanes lies across two lines of the cache. */
static void *make(size_t count, size_t size)
{
    void *room = NULL;
    if (posix_memalign(&room, sizeof(lanes), (count + 1) * size) != 0) {
        return NULL;
    }
    return memset(room, 0, (count + 1) * size);
}

/* Tendons whose tension is sought, and by which points their length is measured. */
static bool add_tensions(strain_form *x)
{
    const strain_kind *kind = &x->kind;
    const size_t count = (size_t)x->tension_count, nodes = (size_t)x->nodes;
    const size_t each = 6 * nodes + (size_t)x->unknowns;
    x->tensions = make(count, sizeof *x->tensions);
    const size_t border = count > 0 ? 2 * (size_t)x->unknowns : 0;
    x->tension_room = make(count * (each + count) + border, sizeof *x->tension_room);
    x->tension_shares = make(count * nodes, sizeof *x->tension_shares);
    x->pulled = make(count + (size_t)x->rub_count > 0 ? nodes : 0, sizeof *x->pulled);
    if (!x->tensions || !x->tension_room || !x->tension_shares || !x->pulled) {
        return false;
    }
    x->shorter = x->tension_room + count * each;
    x->border = x->shorter + count * count;
    for (int i = 0, k = 0; i < kind->actuators && k < x->tension_count; i++) {
        const solve_extent *extent = &kind->extents[i];
        if (!extent->has_length) {
            continue;
        }
        lanes *room = x->tension_room + (size_t)k * each;
        strain_tension *to = &x->tensions[k];
        *to = (strain_tension){.actuator = i,
                               .share = x->tension_shares + (size_t)k * nodes,
                               .along = (lanes(*)[6])room,
                               .bent = room + 6 * nodes};
        for (int j = 0; j < x->nodes; j++) {
            const int e = j / kind->stages;
            const double s = kind->edges[e] + x->width[e] * x->rule.nodes[j % kind->stages];
            const double whole = x->width[e] * x->rule.weights[j % kind->stages];
            to->share[j] = extent->start <= s && s <= extent->end ? whole : 0;
        }
        k++;
    }
    return true;
}

/* Tendons with friction. */
static bool add_rubs(strain_form *x)
{
    enum { EACH = 4 + 6 + LAW_STIFFNESS + 3 + 3 };
    const strain_kind *kind = &x->kind;
    const size_t count = (size_t)x->rub_count, nodes = (size_t)x->nodes;
    x->rubs = make(count, sizeof *x->rubs);
    x->rub_room = make(count * nodes * EACH, sizeof *x->rub_room);
    x->strained = make(count > 0 ? nodes : 0, sizeof *x->strained);
    x->turned = make(count > 0 ? nodes : 0, sizeof *x->turned);
    if (!x->rubs || !x->rub_room || !x->strained || !x->turned) {
        return false;
    }
    lanes *room = x->rub_room;
    for (int i = 0, k = 0; i < kind->actuators && k < x->rub_count; i++) {
        if (kind->extents[i].rubs) {
            x->rubs[k++] = (strain_rub){.actuator = i,
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
    gauss_slope(&x->rule, x->slope);
    return true;
}

ad_status strain_form_create(const strain_kind *kind, strain_form **result, ad_error *error)
{
    *result = NULL;
    ad_status status = check_laws(kind, error);
    strain_form *x = status == AD_OK ? calloc(1, sizeof *x) : NULL;
    if (!x) {
        return status != AD_OK ? status
                               : ad_fail(error, AD_NO_MEMORY, "out of memory for a strain form");
    }
    *x = (strain_form){.kind = *kind,
                       .rule = solve_gauss_rule_of(kind->stages),
                       .nodes = kind->stages * kind->elements};
    size_t nodes = (size_t)x->nodes, elements = (size_t)kind->elements;
    sort_laws(x);
    number_unknowns(x);
    const int places = kind->jumps ? kind->jumps->count : 0;
    x->is_full = x->is_full || x->unknowns > x->elastic;
    number_tensions(x);
    x->is_unloaded = is_unloaded(x);
    x->unknowns += 3 * places; /* at most */
    size_t unknowns = (size_t)x->unknowns, each = 3 * (size_t)kind->stages;
    size_t numbers = x->is_full ? unknowns * unknowns : elements * each * each;
    const size_t held = (size_t)(x->holding + x->tension_count + 1) * (size_t)x->elastic;
    numbers = numbers > held ? numbers : held; /* a column of each (strain_answer.c) */
    x->width = make(elements, sizeof *x->width);
    x->points = make(nodes, sizeof *x->points);
    x->actuators = make(nodes * (size_t)kind->actuators, sizeof *x->actuators);
    x->at = make(nodes, sizeof *x->at);
    x->edges = make(elements + 1, sizeof *x->edges);
    x->along = make(nodes * numbers_along(kind), sizeof *x->along);
    x->pushes = make(x->is_pushed ? nodes : 0, sizeof *x->pushes);
    x->numbers = make(kind->jumps ? (size_t)kind->jumps->numbers : 0, sizeof *x->numbers);
    x->places = make((size_t)places, sizeof *x->places);
    x->matrix = make(kind->is_rigid || kind->is_one ? 0 : numbers, sizeof *x->matrix);
    x->coupled = make(kind->is_rigid || kind->is_one ? 0 : 3 * unknowns, sizeof *x->coupled);
    x->right = make(unknowns, sizeof *x->right);
    x->swapped = make(unknowns, sizeof *x->swapped);
    x->direction = make(unknowns, sizeof *x->direction);
    x->columns = make(nodes + elements + 1, 15 * sizeof(lanes)); /* strain_matrix.c */
    if (!x->width || !x->points || !x->actuators || !x->at || !x->edges || !x->along ||
        !x->pushes || !x->numbers || !x->places || !x->matrix || !x->coupled || !x->right ||
        !x->swapped || !x->direction || !x->columns) {
        strain_form_free(x);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", nodes);
    }
    for (int e = 0; e < kind->elements; e++) {
        x->width[e] = kind->edges[e + 1] - kind->edges[e];
    }
    for (int i = 0; i < kind->stages; i++) {
        for (int j = 0; j < kind->stages; j++) {
            x->tail[i][j] = x->rule.weights[j] - x->rule.matrix[i][j];
        }
    }
    set_magnus(x);
    if (!add_tensions(x) || !add_rubs(x)) {
        strain_form_free(x);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu nodes", nodes);
    }
    x->unknowns -= 3 * places;
    x->start_q[0] += 1;
    *result = x;
    return AD_OK;
}

/* Lane by lane; rods that are the same in all lanes once. */
void strain_form_law(const strain_form *x, int node, int rows, lanes wrench[6], lanes *stiffness)
{
    const strain_node *at = &x->at[node];
    const lanes *rest = x->points[node].rest;
    double strains[6], stress[6], tangent[6][6];
    for (int lane = 0; lane < LANES; lane++) {
        for (int i = 0; i < 6; i++) {
            strains[i] = (i < 3 ? at->v[i] : at->u[i - 3])[lane] - rest[i][lane];
        }
        if (lane == 0 || !x->kind.is_one) {
            scene_law_beyond(x->kind.law, x->kind.length, x->kind.force, strains, stress, tangent);
        }
        for (int i = 0, k = 0; i < 6; i++) {
            wrench[i][lane] = stress[i];
            for (int j = i; j < rows; j++) {
                stiffness[k++][lane] = tangent[i][j];
            }
        }
    }
}

void strain_form_set_jumps(strain_form *x)
{
    const solve_jumps *jumps = x->kind.jumps;
    for (int e = 0, next = 0; e <= x->kind.elements && next < jumps->count; e++) {
        const solve_jump *jump = &jumps->at[next];
        strain_edge *edge = &x->edges[e];
        if (fabs(jump->s - x->kind.edges[e]) >= SOLVE_SAME_PLACE) {
            continue;
        }
        next++;
        edge->turns = jump->turns;
        memcpy(edge->turn, jump->turn, sizeof edge->turn);
        if (jump->acting.count > 0) {
            strain_place *to = &x->places[x->place_count++];
            *to = (strain_place){.edge = e,
                                 .unknown = -1,
                                 .acting = &jump->acting,
                                 .numbers = x->numbers + jump->first};
            if (jump->acting.force_by_position) {
                to->unknown = x->tension_at;
                x->tension_at += 3;
                x->unknowns += 3;
            }
        }
    }
}

lanes *strain_form_unknown(strain_form *x, int i)
{
    if (i < x->elastic) {
        return &x->at[i / 3].u[i % 3];
    }
    if (i >= x->tension_at) {
        return &x->tensions[i - x->tension_at].pull;
    }
    if (x->push_at >= 0 && i >= x->push_at && i < x->push_at + x->elastic) {
        return &x->at[(i - x->push_at) / 3].push[(i - x->push_at) % 3];
    }
    const int angle = i - x->angle_at;
    if (angle >= 0 && angle < x->rub_count * x->nodes) {
        return &x->rubs[angle % x->rub_count].angle[angle / x->rub_count];
    }
    for (int k = 0; k < x->place_count; k++) {
        const int at = x->places[k].unknown;
        if (at >= 0 && i >= at && i < at + 3) {
            return &x->places[k].force[i - at];
        }
    }
    return x->force_at >= 0 && i < x->force_at + 3 ? &x->end_force[i - x->force_at]
                                                   : &x->end_moment[i - x->moment_at];
}

void strain_form_free(strain_form *x)
{
    if (x) {
        free(x->width);
        free(x->points);
        free(x->actuators);
        free(x->at);
        free(x->edges);
        free(x->along);
        free(x->pushes);
        free(x->numbers);
        free(x->places);
        free(x->tensions);
        free(x->tension_room);
        free(x->tension_shares);
        free(x->rubs);
        free(x->rub_room);
        free(x->strained);
        free(x->turned);
        free(x->pulled);
        free(x->matrix);
        free(x->coupled);
        free(x->right);
        free(x->swapped);
        free(x->direction);
        free(x->columns);
        free(x);
    }
}
