#include "physics/solve/strain_level.h"

#include "physics/solve/mesh.h"
#include "physics/solve/strain_inline.h"

#include <stdlib.h>

/* ---- making -------------------------------------------------------------------------------- */

static size_t nodes_of(const strain_level *x)
{
    return (size_t)x->stages * x->elements;
}

static bool allocate(strain_level *x, const solve_rod *rod)
{
    const size_t nodes = nodes_of(x);
    x->s = malloc(nodes * sizeof *x->s);
    x->bent = calloc(nodes, sizeof *x->bent);
    x->pulls = calloc(nodes * (size_t)rod->actuators + 1, sizeof *x->pulls);
    x->along = calloc(nodes * (size_t)rod->along.numbers + 1, sizeof *x->along);
    x->numbers = calloc((size_t)rod->jumps.numbers + 1, sizeof *x->numbers);
    x->output = calloc((size_t)x->outputs + 1, sizeof *x->output);
    return x->s && x->bent && x->pulls && x->along && x->numbers && x->output;
}

/* Outputs lie in the element that ends at s or goes on there. */
static void place_outputs(strain_level *x, const double *s)
{
    const gauss_rule *rule = &x->form->rule;
    for (int k = 0, e = 0; k < x->outputs; k++) {
        strain_output *to = &x->output[k];
        while (e + 1 < x->elements && s[k] > x->edges[e + 1]) {
            e++;
        }
        double at = (s[k] - x->edges[e]) / (x->edges[e + 1] - x->edges[e]);
        *to = (strain_output){.element = e, .from = -1};
        while (to->from + 1 < x->stages && rule->nodes[to->from + 1] <= at) {
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

void strain_link_free(strain_link *x)
{
    free(x->element);
    free(x->value);
    free(x->integral);
    *x = (strain_link){.element = NULL};
}

/* ---- what is given ------------------------------------------------------------------------- */

static const solve_part PARTS[] = {SOLVE_SECTIONS,  SOLVE_REST,  SOLVE_START, SOLVE_END,
                                   SOLVE_ACTUATORS, SOLVE_JUMPS, SOLVE_ALONG};
enum { PART_COUNT = sizeof PARTS / sizeof *PARTS };

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

static void put_actuators(strain_level *x, int node, int lane, const solve_actuator *from)
{
    const strain_kind *kind = &x->form->kind;
    for (int k = 0; k < kind->actuators; k++) {
        const int at = node * kind->actuators + k;
        put(x->form->actuators[at].given + ACTUATOR_OFFSET, lane, 2, from[k].offset);
        put(x->form->actuators[at].given + ACTUATOR_SLOPE, lane, 2, from[k].slope);
        x->pulls[at][lane] = from[k].pull;
    }
    for (int k = 0; k < x->form->tension_count; k++) {
        x->displaced[k][lane] = from[x->form->tensions[k].actuator].displacement;
    }
    for (int k = 0; k < x->form->rub_count; k++) {
        x->form->rubs[k].friction[lane] = from[x->form->rubs[k].actuator].friction;
    }
}

/* values: of one point, or of the rod. */
static void put_part(strain_level *x, solve_part part, int node, int lane, const double *values)
{
    strain_point *point = &x->form->points[node];
    const size_t along = (size_t)x->form->kind.along->numbers;
    const solve_section *section = (const solve_section *)(const void *)values;
    const solve_end_state *end = (const solve_end_state *)(const void *)values;
    switch (part) {
    case SOLVE_SECTIONS:
        put(point->compliance, lane, 6, section->compliance);
        break;
    case SOLVE_REST:
        put(point->rest, lane, 3, values); /* strain, curvature, imperfection */
        put(x->bent[node][0], lane, 6, values + 3);
        break;
    case SOLVE_ACTUATORS:
        put_actuators(x, node, lane, (const solve_actuator *)(const void *)values);
        break;
    case SOLVE_START:
        put(x->form->start_r, lane, 3, end->position);
        put(x->form->start_q, lane, 4, end->rotation);
        break;
    case SOLVE_END:
        put(x->full_r, lane, 3, end->position);
        put(x->full_q, lane, 4, end->rotation);
        break;
    case SOLVE_ALONG:
        put(x->along + (size_t)node * along, lane, along, values);
        break;
    default:
        put(x->numbers, lane, (size_t)x->form->kind.jumps->numbers, values);
    }
}

/* Of the first point, to another. */
static void copy_part(strain_level *x, solve_part part, int node)
{
    const size_t actuators = (size_t)x->form->kind.actuators;
    const size_t along = (size_t)x->form->kind.along->numbers;
    strain_point *from = x->form->points, *to = from + node;
    switch (part) {
    case SOLVE_SECTIONS:
        memcpy(to->compliance, from->compliance, sizeof to->compliance);
        break;
    case SOLVE_REST:
        memcpy(to->rest, from->rest, sizeof to->rest);
        memcpy(x->bent[node], x->bent[0], sizeof *x->bent);
        break;
    case SOLVE_ALONG:
        memcpy(x->along + (size_t)node * along, x->along, along * sizeof *x->along);
        break;
    default:
        memcpy(x->form->actuators + (size_t)node * actuators, x->form->actuators,
               actuators * sizeof *x->form->actuators);
        memcpy(x->pulls + (size_t)node * actuators, x->pulls, actuators * sizeof *x->pulls);
    }
}

/* Values of a part: [points][width] of one lane after the other, `stride` apart; where it is the
 * same along the rod, of one point. */
static void spread(strain_level *x, solve_part part, bool by_s, size_t width, size_t stride,
                   const double *values)
{
    const int nodes = is_along(part) ? (int)nodes_of(x) : 1;
    for (int lane = 0; lane < LANES; lane++) {
        for (int i = 0; i < (by_s ? nodes : 1); i++) {
            put_part(x, part, i, lane, values + (size_t)lane * stride + (size_t)i * width);
        }
    }
    for (int i = 1; i < nodes && !by_s; i++) {
        copy_part(x, part, i);
    }
}

static size_t points_of(const strain_level *x, const solve_rod *rod, solve_part part)
{
    return is_along(part) && solve_rod_part_kind(rod, part).by_s ? nodes_of(x) : 1;
}

size_t strain_level_room(const strain_level *x, const solve_rod *rod)
{
    size_t most = 0;
    for (int i = 0; i < PART_COUNT; i++) {
        size_t count = points_of(x, rod, PARTS[i]);
        size_t width = solve_rod_part_kind(rod, PARTS[i]).width;
        most = count * width > most ? count * width : most;
    }
    return LANES * (most + nodes_of(x) * (1 + SCENE_PARAMETERS_MAX));
}

ad_status strain_level_give(strain_level *x, const solve_rod *rod, int count,
                            const double *parameters, double *room, ad_error *error)
{
    const size_t nodes = nodes_of(x);
    double *s = room, *of_points = s + LANES * nodes;
    double *values = of_points + LANES * nodes * SCENE_PARAMETERS_MAX;
    ad_status status = AD_OK;
    for (int p = 0; p < PART_COUNT && status == AD_OK; p++) {
        const solve_part_kind kind = solve_rod_part_kind(rod, PARTS[p]);
        const size_t points = points_of(x, rod, PARTS[p]), width = (size_t)count;
        if (!kind.by_parameters) {
            continue;
        }
        for (size_t lane = 0, k = 0; lane < LANES; lane++) {
            for (size_t i = 0; i < points; i++, k++) {
                s[k] = points > 1 ? x->s[i] : PARTS[p] == SOLVE_END;
                memcpy(of_points + k * width, parameters + lane * width, width * sizeof *s);
            }
        }
        status = solve_rod_part(rod, PARTS[p], LANES * points, s, 0, of_points, values, error);
        if (status == AD_OK) {
            spread(x, PARTS[p], points > 1, kind.width, points * kind.width, values);
        }
    }
    return status;
}

/* What is the same of all members, once. */
static ad_status give_same(strain_level *x, const solve_rod *rod, ad_error *error)
{
    const double none[SCENE_PARAMETERS_MAX] = {0};
    size_t nodes = nodes_of(x);
    ad_status status = AD_OK;
    for (int p = 0; p < PART_COUNT && status == AD_OK; p++) {
        const solve_part_kind kind = solve_rod_part_kind(rod, PARTS[p]);
        const size_t points = points_of(x, rod, PARTS[p]);
        double *values = malloc((points * kind.width + 1) * sizeof *values);
        double *zeros = calloc(nodes * SCENE_PARAMETERS_MAX, sizeof *zeros);
        if (!values || !zeros) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", points);
        } else if (kind.width > 0 && !kind.by_parameters) {
            const double end = PARTS[p] == SOLVE_END;
            status = solve_rod_part(rod, PARTS[p], points, points > 1 ? x->s : &end, 0,
                                    points > 1 ? zeros : none, values, error);
            if (status == AD_OK) {
                spread(x, PARTS[p], points > 1, kind.width, 0, values);
            }
        }
        free(values);
        free(zeros);
    }
    return status;
}

/* ---- making, all together ------------------------------------------------------------------ */

static ad_status create_form(strain_level *x, const solve_rod *rod, bool is_rigid, ad_error *error)
{
    const scene_properties made = scene_properties_of(&rod->scene);
    const strain_kind kind = {.stages = x->stages,
                              .elements = x->elements,
                              .actuators = rod->actuators,
                              .edges = x->edges,
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
    return strain_form_create(&kind, &x->form, error);
}

ad_status strain_level_create(const solve_rod *rod, int stages, int elements, const double *edges,
                              bool is_rigid, int outputs, const double *s, strain_level *result,
                              ad_error *error)
{
    strain_level *x = result;
    *x = (strain_level){.stages = stages, .elements = elements, .outputs = outputs};
    x->edges = malloc(((size_t)elements + 1) * sizeof *x->edges);
    if (!x->edges || !allocate(x, rod)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a mesh");
    }
    memcpy(x->edges, edges, ((size_t)elements + 1) * sizeof *edges);
    ad_status status = create_form(x, rod, is_rigid, error);
    if (status != AD_OK) {
        return status;
    }
    for (size_t i = 0; i < nodes_of(x); i++) {
        const size_t e = i / (size_t)stages;
        x->s[i] = edges[e] + (edges[e + 1] - edges[e]) * x->form->rule.nodes[i % (size_t)stages];
    }
    place_outputs(x, s);
    strain_form_set_jumps(x->form);
    return give_same(x, rod, error);
}

void strain_level_free(strain_level *x)
{
    free(x->edges);
    free(x->s);
    free(x->bent);
    free(x->pulls);
    free(x->along);
    free(x->numbers);
    free(x->output);
    strain_form_free(x->form);
    *x = (strain_level){.stages = 0};
}

/* ---- where members are --------------------------------------------------------------------- */

/* Where the end is on the way from where the unstressed rod has it; of q and -q the one that is
 * near its rotation, as a turn counts in pivots. */
PROCESSOR_INLINE void hold(strain_level *x, const lanes *factor)
{
    lanes *q = x->form->held_q, square = NO_LANES, dot = NO_LANES, by;
    for (int i = 0; i < 3; i++) {
        x->form->held_r[i] = x->bare_r[i] + *factor * (x->full_r[i] - x->bare_r[i]);
    }
    for (int i = 0; i < 4; i++) {
        dot += x->bare_q[i] * x->full_q[i];
    }
    const lanes sign = 1 + 2 * __builtin_convertvector(dot < 0, lanes);
    for (int i = 0; i < 4; i++) {
        q[i] = (1 - *factor) * x->bare_q[i] + *factor * sign * x->full_q[i];
        square += q[i] * q[i];
    }
    lanes_inverse_root(&square, &by);
    for (int i = 0; i < 4; i++) {
        q[i] *= by;
    }
}

/* Tendons may be as long as in the unstressed rod, less what is pulled out. */
PROCESSOR_INLINE void allow_lengths(strain_level *x, const lanes *factor)
{
    strain_form *form = x->form;
    for (int k = 0; k < form->tension_count; k++) {
        strain_tension *of = &form->tensions[k];
        of->allowed = -*factor * x->displaced[k];
        for (int i = 0; i < form->nodes; i++) {
            const strain_actuator *at = &form->actuators[i * form->kind.actuators + of->actuator];
            add_length(at, of->share[i], form->points[i].rest, x->bent[i][0], &of->allowed);
        }
    }
}

FOR_EACH_PROCESSOR static void load(strain_level *x, const lanes *factor)
{
    strain_form *form = x->form;
    const int pulling = form->kind.actuators;
    for (int i = 0; i < form->nodes; i++) {
        for (int c = 0; c < 3; c++) {
            form->points[i].rest[3 + c] = x->bent[i][0][c] + (1 - *factor) * x->bent[i][1][c];
        }
        for (int k = 0; k < pulling; k++) {
            const solve_extent *extent = &form->kind.extents[k];
            lanes *pull = &form->actuators[i * pulling + k].given[ACTUATOR_PULL];
            *pull = NO_LANES;
            if (extent->start <= x->s[i] && x->s[i] <= extent->end) {
                *pull = *factor * x->pulls[i * pulling + k];
            }
        }
        for (int k = 0; k < form->rub_count; k++) {
            const strain_actuator *at = &form->actuators[i * pulling + form->rubs[k].actuator];
            form->rubs[k].pull[i] = at->given[ACTUATOR_PULL];
        }
    }
    const acting *along = form->kind.along;
    for (int i = 0; i < form->nodes && along->count > 0; i++) {
        acting_lanes_on_way(along, x->along + i * along->numbers, factor,
                            form->along + i * along->numbers);
    }
    for (int k = 0; k < form->place_count; k++) {
        const strain_place *place = &form->places[k];
        acting_lanes_on_way(place->acting, x->numbers + (place->numbers - form->numbers), factor,
                            place->numbers);
    }
    if (form->holding > 0) {
        hold(x, factor);
    }
    allow_lengths(x, factor);
}

void strain_level_load(strain_level *x, const lanes *factor)
{
    load(x, factor);
    strain_form_load(x->form);
}

void strain_level_rest(strain_level *x)
{
    for (int i = 0; i < x->form->nodes; i++) {
        memcpy(x->form->at[i].v, x->form->points[i].rest, sizeof x->form->at[i].v);
        for (int c = 0; c < 3; c++) {
            x->form->at[i].u[c] = x->bent[i][0][c] + x->bent[i][1][c];
        }
    }
    for (int i = x->form->elastic; i < x->form->unknowns; i++) {
        *strain_form_unknown(x->form, i) = NO_LANES;
    }
    if (x->form->holding > 0) {
        const strain_edge *end = &x->form->edges[x->elements];
        strain_form_place(x->form);
        memcpy(x->bare_r, end->r, sizeof x->bare_r);
        memcpy(x->bare_q, end->q, sizeof x->bare_q);
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
    for (int j = 0; j < x->stages; j++) {                                                          \
        sum += (weights)[j] * at[j].field;                                                         \
    }

FOR_EACH_PROCESSOR static void evaluate(const strain_level *x, lanes *values)
{
    for (int k = 0; k < x->outputs; k++, values += SOLVE_MEMBERS_COLUMNS) {
        const strain_output *out = &x->output[k];
        strain_node *at = x->form->at + out->element * x->stages;
        strain_edge *edge = &x->form->edges[out->element];
        lanes terms[3][3], q[4];
        const double h = x->form->width[out->element];
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

void strain_level_evaluate(const strain_level *x, lanes *values)
{
    evaluate(x, values);
}
