#include "physics/chain/strain_level.h"

#include "physics/chain/solve_members.h"
#include "physics/chain/strain_inline.h"
#include "physics/local/mesh.h"
#include "physics/rod/rod_internal.h"

#include <stdlib.h>

/* ---- making -------------------------------------------------------------------------------- */

static size_t nodes_of(const strain_level *level)
{
    return (size_t)level->stages * level->elements;
}

static bool allocate(strain_level *level, const solve_rod *rod)
{
    const size_t nodes = nodes_of(level);
    AD_TAKE(level, s, nodes);
    AD_TAKE(level, bent, nodes);
    AD_TAKE(level, pulls, nodes * (size_t)rod->actuators + 1);
    AD_TAKE(level, curved, nodes * (size_t)rod->tubes);
    AD_TAKE(level, along, nodes * (size_t)rod->along.numbers + 1);
    AD_TAKE(level, numbers, (size_t)rod->jumps.numbers + 1);
    AD_TAKE(level, output, (size_t)level->outputs + 1);
    return !level->memory.is_short;
}

/* Outputs lie in the element that ends at s or goes on there. */
static void place_outputs(strain_level *level, const double *s)
{
    const gauss_rule *rule = &level->form->rule;
    for (int k = 0, e = 0; k < level->outputs; k++) {
        strain_output *to = &level->output[k];
        while (e + 1 < level->elements && s[k] > level->edges[e + 1]) {
            e++;
        }
        double at = (s[k] - level->edges[e]) / (level->edges[e + 1] - level->edges[e]);
        *to = (strain_output){.element = e, .from = -1};
        while (to->from + 1 < level->stages && rule->nodes[to->from + 1] <= at) {
            to->from++;
        }
        gauss_lagrange(rule, at, to->interpolate);
        gauss_integral(rule, at, to->integrate);
        gauss_magnus(rule, to->from < 0 ? 0 : rule->nodes[to->from], at, to->magnus);
    }
}

ad_status strain_link_create(const strain_level *from, const strain_level *to, strain_link *result,
                             ad_error *error)
{
    const size_t nodes = nodes_of(to);
    *result = (strain_link){.element = malloc(nodes * sizeof *result->element),
                            .value = malloc(nodes * sizeof *result->value),
                            .integral = malloc(nodes * sizeof *result->integral)};
    if (!result->element || !result->value || !result->integral) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", nodes);
    }
    for (size_t i = 0; i < nodes; i++) {
        int e = 0;
        while (e + 1 < from->elements && to->s[i] > from->edges[e + 1]) {
            e++;
        }
        const double at = (to->s[i] - from->edges[e]) / (from->edges[e + 1] - from->edges[e]);
        result->element[i] = e;
        gauss_lagrange(&from->form->rule, at, result->value[i]);
        gauss_integral(&from->form->rule, at, result->integral[i]);
    }
    return AD_OK;
}

void strain_link_free(strain_link *link)
{
    free(link->element);
    free(link->value);
    free(link->integral);
    *link = (strain_link){.element = NULL};
}

/* ---- what is given ------------------------------------------------------------------------- */

static const solve_part PARTS[] = {SOLVE_SECTIONS,  SOLVE_REST,  SOLVE_START, SOLVE_END,
                                   SOLVE_ACTUATORS, SOLVE_JUMPS, SOLVE_ALONG};
_Static_assert(sizeof PARTS / sizeof *PARTS == STRAIN_PARTS, "one of each");

/* Whether it is one of each point. */
static bool is_along(solve_part part)
{
    return part == SOLVE_SECTIONS || part == SOLVE_REST || part == SOLVE_ACTUATORS ||
           part == SOLVE_ALONG;
}

static void put(lanes *to, int lane, size_t count, const double *from)
{
    for (size_t k = 0; k < count; k++) {
        to[k][lane] = from[k];
    }
}

static void put_tube(strain_level *level, int k, int node, int lane, const solve_actuator *from)
{
    strain_tube *to = &level->form->tubes[k];
    put(to->numbers[node], lane, 2, from->bending);
    put(&to->numbers[node][TUBE_SOFTNESS], lane, 1, &from->softness);
    put(level->curved[k * level->form->nodes + node], lane, 3, from->curvature);
    level->turned[k][lane] = from->turned;
    to->yielding[lane] = from->yielding;
}

static void put_actuators(strain_level *level, int node, int lane, const solve_actuator *from)
{
    const strain_kind *kind = &level->form->kind;
    for (int k = 0; k < kind->actuators; k++) {
        const int at = node * kind->actuators + k;
        put(level->form->actuators[at].given + ACTUATOR_OFFSET, lane, 2, from[k].offset);
        put(level->form->actuators[at].given + ACTUATOR_SLOPE, lane, 2, from[k].slope);
        level->pulls[at][lane] = from[k].pull;
    }
    for (int k = 0; k < level->form->tension_count; k++) {
        strain_tension *to = &level->form->tensions[k];
        level->displaced[k][lane] = from[to->actuator].displacement;
        to->compliance[lane] = from[to->actuator].compliance;
    }
    for (int k = 0; k < level->form->rub_count; k++) {
        level->form->rubs[k].friction[lane] = from[level->form->rubs[k].actuator].friction;
    }
    for (int k = 0; k < kind->tubes; k++) {
        put_tube(level, k, node, lane, &from[kind->actuators + k]);
    }
}

/* values: of one point, or of the rod. */
static void put_part(strain_level *level, solve_part part, int node, int lane, const double *values)
{
    strain_point *point = &level->form->points[node];
    const size_t along = (size_t)level->form->kind.along->numbers;
    const solve_section *section = (const solve_section *)(const void *)values;
    const solve_end_state *end = (const solve_end_state *)(const void *)values;
    switch (part) {
    case SOLVE_SECTIONS:
        put(point->compliance, lane, 6, section->compliance);
        break;
    case SOLVE_REST:
        put(point->rest, lane, 3, values); /* strain, curvature, imperfection */
        put(level->bent[node][0], lane, 6, values + 3);
        break;
    case SOLVE_ACTUATORS:
        put_actuators(level, node, lane, (const solve_actuator *)(const void *)values);
        break;
    case SOLVE_START:
        put(level->form->start_r, lane, 3, end->position);
        put(level->form->start_q, lane, 4, end->rotation);
        break;
    case SOLVE_END:
        put(level->full_r, lane, 3, end->position);
        put(level->full_q, lane, 4, end->rotation);
        break;
    case SOLVE_ALONG:
        put(level->along + (size_t)node * along, lane, along, values);
        break;
    default:
        put(level->numbers, lane, (size_t)level->form->kind.jumps->numbers, values);
    }
}

/* Of the first point, to another. */
static void copy_part(strain_level *level, solve_part part, int node)
{
    const size_t actuators = (size_t)level->form->kind.actuators;
    const size_t along = (size_t)level->form->kind.along->numbers;
    strain_point *from = level->form->points, *to = from + node;
    switch (part) {
    case SOLVE_SECTIONS:
        memcpy(to->compliance, from->compliance, sizeof to->compliance);
        break;
    case SOLVE_REST:
        memcpy(to->rest, from->rest, sizeof to->rest);
        memcpy(level->bent[node], level->bent[0], sizeof *level->bent);
        break;
    case SOLVE_ALONG:
        memcpy(level->along + (size_t)node * along, level->along, along * sizeof *level->along);
        break;
    default:
        memcpy(level->form->actuators + (size_t)node * actuators, level->form->actuators,
               actuators * sizeof *level->form->actuators);
        memcpy(level->pulls + (size_t)node * actuators, level->pulls,
               actuators * sizeof *level->pulls);
        for (int k = 0; k < level->form->kind.tubes; k++) {
            lanes(*curved)[3] = level->curved + k * level->form->nodes;
            lanes(*numbers)[LAW_TUBE_GIVEN] = level->form->tubes[k].numbers;
            memcpy(numbers[node], numbers[0], sizeof *numbers);
            memcpy(curved[node], curved[0], sizeof *curved);
        }
    }
}

/* Values of a part: [points][width] of one lane after the other, `stride` apart, of each from
 * `first` [LANES] on, NULL: 0; where it is the same along the rod, of one point. */
static void spread(strain_level *level, solve_part part, bool by_s, size_t width, size_t stride,
                   const size_t *first, const double *values)
{
    const int nodes = is_along(part) ? (int)nodes_of(level) : 1;
    for (int lane = 0; lane < LANES; lane++) {
        const double *from = values + (size_t)lane * stride + (first ? first[lane] : 0);
        for (int i = 0; i < (by_s ? nodes : 1); i++) {
            put_part(level, part, i, lane, from + (size_t)i * width);
        }
    }
    for (int i = 1; i < nodes && !by_s; i++) {
        copy_part(level, part, i);
    }
}

static size_t points_of(const strain_level *level, const solve_rod *rod, solve_part part)
{
    return is_along(part) && solve_rod_part_kind(rod, part).by_s ? nodes_of(level) : 1;
}

size_t strain_level_room(const strain_level *level, const solve_rod *rod)
{
    size_t most = 0;
    for (int i = 0; i < STRAIN_PARTS; i++) {
        const size_t size = strain_level_part_room(level, rod, i);
        most = size > most ? size : most;
    }
    return most + LANES * nodes_of(level) * (1 + SCENE_PARAMETERS_MAX);
}

bool strain_level_is_open(const solve_rod *rod, int part)
{
    return solve_rod_part_kind(rod, PARTS[part]).by_parameters;
}

size_t strain_level_part_room(const strain_level *level, const solve_rod *rod, int part)
{
    return LANES * points_of(level, rod, PARTS[part]) * solve_rod_part_kind(rod, PARTS[part]).width;
}

ad_status strain_level_find(const strain_level *level, const solve_rod *rod, int part, int count,
                            const double *parameters, double *room, double *values, ad_error *error)
{
    const size_t nodes = nodes_of(level), points = points_of(level, rod, PARTS[part]);
    const size_t width = (size_t)count;
    double *s = room, *of_points = s + LANES * nodes;
    for (size_t lane = 0, k = 0; lane < LANES; lane++) {
        for (size_t i = 0; i < points; i++, k++) {
            s[k] = points > 1 ? level->s[i] : PARTS[part] == SOLVE_END;
            memcpy(of_points + k * width, parameters + lane * width, width * sizeof *s);
        }
    }
    return solve_rod_part(rod, PARTS[part], LANES * points, s, 0, of_points, values, error);
}

ad_status strain_level_give(strain_level *level, const solve_rod *rod, int count,
                            const double *parameters, double *room, ad_error *error)
{
    double *values = room + LANES * nodes_of(level) * (1 + SCENE_PARAMETERS_MAX);
    ad_status status = AD_OK;
    for (int p = 0; p < STRAIN_PARTS && status == AD_OK; p++) {
        const solve_part_kind kind = solve_rod_part_kind(rod, PARTS[p]);
        const size_t points = points_of(level, rod, PARTS[p]);
        if (kind.by_parameters) {
            status = strain_level_find(level, rod, p, count, parameters, room, values, error);
            if (status == AD_OK) {
                spread(level, PARTS[p], points > 1, kind.width, points * kind.width, NULL, values);
            }
        }
    }
    return status;
}

bool strain_level_is_uniform(const strain_level *level)
{
    const strain_form *form = level->form;
    const size_t actuators = (size_t)form->kind.actuators;
    bool result = form->is_unloaded;
    for (size_t i = 1; i < nodes_of(level) && result; i++) {
        const size_t to = i - i % (size_t)level->stages; /* the first of the element */
        result = memcmp(&form->points[i], &form->points[to], sizeof *form->points) == 0 &&
                 memcmp(level->bent[i], level->bent[to], sizeof *level->bent) == 0 &&
                 memcmp(form->actuators + i * actuators, form->actuators + to * actuators,
                        actuators * sizeof *form->actuators) == 0 &&
                 memcmp(level->pulls + i * actuators, level->pulls + to * actuators,
                        actuators * sizeof *level->pulls) == 0;
    }
    return result;
}

/* What is the same of all members, once. */
static ad_status give_same(strain_level *level, const solve_rod *rod, ad_error *error)
{
    const double none[SCENE_PARAMETERS_MAX] = {0};
    size_t nodes = nodes_of(level);
    ad_status status = AD_OK;
    for (int p = 0; p < STRAIN_PARTS && status == AD_OK; p++) {
        const solve_part_kind kind = solve_rod_part_kind(rod, PARTS[p]);
        const size_t points = points_of(level, rod, PARTS[p]);
        double *values = malloc((points * kind.width + 1) * sizeof *values);
        double *zeros = calloc(nodes * SCENE_PARAMETERS_MAX, sizeof *zeros);
        if (!values || !zeros) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", points);
        } else if (kind.width > 0 && !kind.by_parameters) {
            const double end = PARTS[p] == SOLVE_END;
            status = solve_rod_part(rod, PARTS[p], points, points > 1 ? level->s : &end, 0,
                                    points > 1 ? zeros : none, values, error);
            if (status == AD_OK) {
                spread(level, PARTS[p], points > 1, kind.width, 0, NULL, values);
            }
        }
        free(values);
        free(zeros);
    }
    return status;
}

/* ---- making, all together ------------------------------------------------------------------ */

static ad_status create_form(strain_level *level, const solve_rod *rod, bool is_rigid,
                             ad_error *error)
{
    const scene_properties made = scene_properties_of(&rod->scene);
    const strain_kind kind = {.stages = level->stages,
                              .elements = level->elements,
                              .actuators = rod->actuators - rod->tubes,
                              .tubes = rod->tubes,
                              .edges = level->edges,
                              .extents = rod->extents,
                              .shears = !scene_locks(made.strain_stiffness[0]) ||
                                        !scene_locks(made.strain_stiffness[1]) ||
                                        !scene_locks(made.strain_stiffness[2]),
                              .law = rod->scene.rod.law,
                              .length = rod->scales.length,
                              .force = rod->scales.force,
                              .along = &rod->along,
                              .jumps = &rod->jumps,
                              .substeps = 1,
                              .seeks_tensions = true,
                              .is_rigid = is_rigid,
                              .end = rod->ends[1]};
    return strain_form_create(&kind, &level->form, error);
}

ad_status strain_level_create(const solve_rod *rod, int stages, int elements, const double *edges,
                              bool is_rigid, int outputs, const double *s, strain_level *result,
                              ad_error *error)
{
    strain_level *level = result;
    *level = (strain_level){.stages = stages, .elements = elements, .outputs = outputs};
    AD_TAKE(level, edges, (size_t)elements + 1);
    if (level->memory.is_short || !allocate(level, rod)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a mesh");
    }
    memcpy(level->edges, edges, ((size_t)elements + 1) * sizeof *edges);
    ad_status status = create_form(level, rod, is_rigid, error);
    if (status != AD_OK) {
        return status;
    }
    for (size_t i = 0; i < nodes_of(level); i++) {
        const size_t e = i / (size_t)stages;
        level->s[i] =
            edges[e] + (edges[e + 1] - edges[e]) * level->form->rule.nodes[i % (size_t)stages];
    }
    place_outputs(level, s);
    strain_form_set_jumps(level->form);
    return give_same(level, rod, error);
}

void strain_level_free(strain_level *level)
{
    ad_memory_free(&level->memory);
    strain_form_free(level->form);
    *level = (strain_level){.stages = 0};
}

/* ---- where members are --------------------------------------------------------------------- */

/* Where the end is on the way from where the unstressed rod has it; of q and -q the one that is
 * near its rotation, as a turn counts in pivots. */
PROCESSOR_INLINE void hold(strain_level *level, const lanes *factor)
{
    lanes *q = level->form->held_q, square = NO_LANES, dot = NO_LANES, by;
    for (int i = 0; i < 3; i++) {
        level->form->held_r[i] = level->bare_r[i] + *factor * (level->full_r[i] - level->bare_r[i]);
    }
    for (int i = 0; i < 4; i++) {
        dot += level->bare_q[i] * level->full_q[i];
    }
    const lanes sign = 1 + 2 * __builtin_convertvector(dot < 0, lanes);
    for (int i = 0; i < 4; i++) {
        q[i] = (1 - *factor) * level->bare_q[i] + *factor * sign * level->full_q[i];
        square += q[i] * q[i];
    }
    lanes_inverse_root(&square, &by);
    for (int i = 0; i < 4; i++) {
        q[i] *= by;
    }
}

/* Tendons may be as long as in the unstressed rod, less what is pulled out. */
PROCESSOR_INLINE void allow_lengths(strain_level *level, const lanes *factor)
{
    strain_form *form = level->form;
    for (int k = 0; k < form->tension_count; k++) {
        strain_tension *of = &form->tensions[k];
        of->allowed = -*factor * level->displaced[k];
        for (int i = 0; i < form->nodes; i++) {
            const strain_actuator *at = &form->actuators[i * form->kind.actuators + of->actuator];
            add_length(at, of->share[i], form->points[i].rest, level->bent[i][0], &of->allowed);
        }
    }
}

/* On the way tubes become curved and are turned as rod_tube_shape_share and rod_tube_turn_share
 * say; without load they have the shape of the rod. */
PROCESSOR_INLINE void load_tubes(strain_level *level, const lanes *factor)
{
    strain_form *form = level->form;
    lanes shape, turn;
    for (int lane = 0; lane < LANES; lane++) {
        shape[lane] = rod_tube_shape_share((*factor)[lane]);
        turn[lane] = rod_tube_turn_share((*factor)[lane]);
    }
    for (int k = 0; k < form->kind.tubes; k++) {
        form->tubes[k].turned = turn * level->turned[k];
        for (int i = 0; i < form->nodes; i++) {
            const lanes *whole = level->curved[k * form->nodes + i],
                        *rest = form->points[i].rest + 3;
            for (int c = 0; c < 3; c++) {
                form->tubes[k].numbers[i][TUBE_REST + c] = rest[c] + shape * (whole[c] - rest[c]);
            }
        }
    }
}

/* What grows with the load, in proportion to it. */
PROCESSOR_INLINE void load_given(strain_level *level, const lanes *factor)
{
    strain_form *form = level->form;
    const int pulling = form->kind.actuators;
    for (int i = 0; i < form->nodes; i++) {
        for (int c = 0; c < 3; c++) {
            form->points[i].rest[3 + c] =
                level->bent[i][0][c] + (1 - *factor) * level->bent[i][1][c];
        }
        for (int k = 0; k < pulling; k++) {
            const solve_extent *extent = &form->kind.extents[k];
            lanes *pull = &form->actuators[i * pulling + k].given[ACTUATOR_PULL];
            *pull = NO_LANES;
            if (extent->start <= level->s[i] && level->s[i] <= extent->end) {
                *pull = *factor * level->pulls[i * pulling + k];
            }
        }
        for (int k = 0; k < form->rub_count; k++) {
            const strain_actuator *at = &form->actuators[i * pulling + form->rubs[k].actuator];
            form->rubs[k].pull[i] = at->given[ACTUATOR_PULL];
        }
    }
    load_tubes(level, factor);
    const acting *along = form->kind.along;
    for (int i = 0; i < form->nodes && along->count > 0; i++) {
        acting_lanes_on_way(along, level->along + i * along->numbers, factor,
                            form->along + i * along->numbers);
    }
    for (int k = 0; k < form->place_count; k++) {
        const strain_place *place = &form->places[k];
        acting_lanes_on_way(place->acting, level->numbers + (place->numbers - form->numbers),
                            factor, place->numbers);
    }
}

FOR_EACH_PROCESSOR static void load(strain_level *level, const lanes *factor)
{
    load_given(level, factor);
    if (level->form->holding > 0) {
        hold(level, factor);
    }
    allow_lengths(level, factor);
}

FOR_EACH_PROCESSOR static void load_fully(strain_level *level)
{
    const lanes whole = NO_LANES + 1;
    load_given(level, &whole);
}

void strain_level_give_changes(strain_level *level, const solve_rod *rod, int count,
                               const int *which, const double *const *values)
{
    for (int p = 0; p < STRAIN_PARTS; p++) {
        const solve_part_kind kind = solve_rod_part_kind(rod, PARTS[p]);
        const size_t points = points_of(level, rod, PARTS[p]);
        size_t first[LANES];
        for (int lane = 0; lane < LANES; lane++) {
            first[lane] = (size_t)which[lane] * kind.width / (size_t)count;
        }
        if (kind.by_parameters) {
            spread(level, PARTS[p], points > 1, kind.width, points * kind.width, first, values[p]);
        }
    }
    load_fully(level);
}

void strain_level_load(strain_level *level, const lanes *factor)
{
    load(level, factor);
    strain_form_load(level->form);
}

void strain_level_rest(strain_level *level)
{
    for (int i = 0; i < level->form->nodes; i++) {
        memcpy(level->form->at[i].v, level->form->points[i].rest, sizeof level->form->at[i].v);
        for (int c = 0; c < 3; c++) {
            level->form->at[i].u[c] = level->bent[i][0][c] + level->bent[i][1][c];
        }
    }
    for (int i = level->form->elastic; i < level->form->unknowns; i++) {
        *strain_form_unknown(level->form, i) = NO_LANES;
    }
    if (level->form->holding > 0) {
        const strain_edge *end = &level->form->edges[level->elements];
        strain_form_place(level->form);
        memcpy(level->bare_r, end->r, sizeof level->bare_r);
        memcpy(level->bare_q, end->q, sizeof level->bare_q);
    }
}

FOR_EACH_PROCESSOR static void refine(const strain_link *link, const strain_level *from,
                                      strain_level *to)
{
    for (int i = 0; i < to->form->nodes; i++) {
        const strain_node *coarse = from->form->at + link->element[i] * from->stages;
        strain_node *at = &to->form->at[i];
        for (int c = 0; c < 3; c++) {
            at->u[c] = at->v[c] = NO_LANES;
            for (int j = 0; j < from->stages; j++) {
                at->u[c] += link->value[i][j] * coarse[j].u[c];
                at->v[c] += link->value[i][j] * coarse[j].v[c];
            }
        }
    }
}

FOR_EACH_PROCESSOR static void sample(const strain_link *link, const strain_level *from,
                                      const strain_level *to, int width, const lanes *numbers,
                                      lanes *sampled)
{
    for (int i = 0; i < to->form->nodes; i++) {
        const lanes *of = numbers + width * link->element[i] * from->stages;
        for (int c = 0; c < width; c++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < from->stages; j++) {
                sum += link->value[i][j] * of[width * j + c];
            }
            sampled[width * i + c] = sum;
        }
    }
}

void strain_level_sample(const strain_link *link, const strain_level *from, const strain_level *to,
                         int width, const lanes *numbers, lanes *sampled)
{
    sample(link, from, to, width, numbers, sampled);
}

void strain_level_refine(const strain_link *link, const strain_level *from, strain_level *to)
{
    refine(link, from, to);
    memcpy(to->form->start_r, from->form->start_r, sizeof to->form->start_r);
    memcpy(to->form->start_q, from->form->start_q, sizeof to->form->start_q);
    for (int i = 0; i < to->form->nodes && to->form->push_at >= 0; i++) {
        const strain_node *coarse = from->form->at + link->element[i] * from->stages;
        for (int c = 0; c < 3; c++) {
            to->form->at[i].push[c] = NO_LANES;
            for (int j = 0; j < from->stages; j++) {
                to->form->at[i].push[c] += link->value[i][j] * coarse[j].push[c];
            }
        }
    }
    for (int k = 0; k < to->form->rub_count; k++) {
        sample(link, from, to, 1, from->form->rubs[k].angle, to->form->rubs[k].angle);
    }
    for (int k = 0; k < to->form->kind.tubes; k++) {
        sample(link, from, to, 1, from->form->tubes[k].torsion, to->form->tubes[k].torsion);
        to->form->tubes[k].base = from->form->tubes[k].base;
    }
    for (int k = 0; k < to->form->place_count; k++) {
        memcpy(to->form->places[k].force, from->form->places[k].force,
               sizeof to->form->places[k].force);
    }
    for (int k = 0; k < to->form->tension_count; k++) {
        to->form->tensions[k].pull = from->form->tensions[k].pull;
    }
    if (to->form->force_at >= 0) {
        memcpy(to->form->end_force, from->form->end_force, sizeof to->form->end_force);
    }
    if (to->form->moment_at >= 0) {
        memcpy(to->form->end_moment, from->form->end_moment, sizeof to->form->end_moment);
    }
}

FOR_EACH_PROCESSOR static void foresee(const strain_link *link, const strain_level *from,
                                       const strain_level *to, lanes *positions)
{
    for (int i = 0; i < to->form->nodes; i++) {
        const int e = link->element[i];
        const strain_node *coarse = from->form->at + e * from->stages;
        for (int c = 0; c < 3; c++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < from->stages; j++) {
                sum += link->integral[i][j] * coarse[j].slope[c];
            }
            positions[3 * i + c] = from->form->edges[e].r[c] + from->form->width[e] * sum;
        }
    }
}

void strain_level_foresee(const strain_link *link, const strain_level *from, const strain_level *to,
                          lanes *positions)
{
    foresee(link, from, to, positions);
}

/* ---- shapes -------------------------------------------------------------------------------- */

/* Sums of weights times a field of the points of an element. */
#define WEIGHED(weights, field)                                                                    \
    for (int j = 0; j < level->stages; j++) {                                                      \
        sum += (weights)[j] * at[j].field;                                                         \
    }

FOR_EACH_PROCESSOR static void evaluate(const strain_level *level, lanes *values)
{
    for (int k = 0; k < level->outputs; k++, values += SOLVE_MEMBERS_COLUMNS) {
        const strain_output *out = &level->output[k];
        strain_node *at = level->form->at + out->element * level->stages;
        strain_edge *edge = &level->form->edges[out->element];
        lanes terms[3][3], q[4];
        const double h = level->form->width[out->element];
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < 3; i++) {
                lanes sum = NO_LANES;
                WEIGHED(out->magnus[i], u[c]);
                terms[i][c] = h * sum;
            }
            lanes sum = NO_LANES;
            WEIGHED(out->integrate, slope[c]);
            values[c] = edge->r[c] + h * sum;
            sum = NO_LANES;
            WEIGHED(out->interpolate, v[c]);
            values[7 + c] = sum;
            sum = NO_LANES;
            WEIGHED(out->interpolate, u[c]);
            values[10 + c] = sum;
        }
        if (out->from < 0) {
            memcpy(q, edge->q, sizeof q);
            turn_over(edge, q);
        } else {
            memcpy(q, at[out->from].q, sizeof q);
        }
        step_on(terms, q);
        memcpy(values + 3, q, sizeof q);
    }
}

void strain_level_evaluate(const strain_level *level, lanes *values)
{
    evaluate(level, values);
}
