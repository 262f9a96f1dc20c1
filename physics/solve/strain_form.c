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

/* Numbers those unknowns that are no curvatures. */
static void number_unknowns(strain_form *x)
{
    const strain_kind *kind = &x->kind;
    int *first[] = {&x->force_at, &x->moment_at, &x->shift_at, &x->turn_at, &x->push_at};
    const int count[] = {kind->end.hold.directions > 0 ? 3 : 0, kind->end.holds_rotation ? 3 : 0,
                         kind->free_position ? 3 : 0, kind->free_rotation ? 3 : 0,
                         kind->founded ? 3 * x->nodes : 0};
    x->elastic = x->unknowns = 3 * x->nodes;
    for (int i = 0; i < 5; i++) {
        *first[i] = count[i] > 0 ? x->unknowns : -1;
        x->unknowns += count[i];
        x->holding += i < 4 ? count[i] : 0;
    }
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

ad_status strain_form_create(const strain_kind *kind, strain_form **result, ad_error *error)
{
    strain_form *x = calloc(1, sizeof *x);
    *result = x;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a strain form");
    }
    *x = (strain_form){.kind = *kind,
                       .rule = solve_gauss_rule_of(kind->stages),
                       .nodes = kind->stages * kind->elements};
    size_t nodes = (size_t)x->nodes, elements = (size_t)kind->elements;
    number_unknowns(x);
    x->unknowns += 3 * kind->springs; /* at most */
    size_t unknowns = (size_t)x->unknowns, each = 3 * (size_t)kind->stages;
    const size_t numbers = x->unknowns > x->elastic ? unknowns * unknowns : elements * each * each;
    x->unknowns -= 3 * kind->springs;
    x->width = make(elements, sizeof *x->width);
    x->points = make(nodes, sizeof *x->points);
    x->actuators = make(nodes * (size_t)kind->actuators, sizeof *x->actuators);
    x->at = make(nodes, sizeof *x->at);
    x->edges = make(elements + 1, sizeof *x->edges);
    x->springs = make((size_t)kind->springs, sizeof *x->springs);
    x->matrix = make(kind->is_rigid || kind->is_one ? 0 : numbers, sizeof *x->matrix);
    x->coupled = make(kind->is_rigid || kind->is_one ? 0 : 3 * unknowns, sizeof *x->coupled);
    x->right = make(unknowns, sizeof *x->right);
    x->swapped = make(unknowns, sizeof *x->swapped);
    x->direction = make(unknowns, sizeof *x->direction);
    x->columns = make(nodes + elements + 1, 15 * sizeof(lanes)); /* strain_matrix.c */
    if (!x->width || !x->points || !x->actuators || !x->at || !x->edges || !x->springs ||
        !x->matrix || !x->coupled || !x->right || !x->swapped || !x->direction || !x->columns) {
        strain_form_free(x);
        *result = NULL;
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
    x->start_q[0] += 1;
    return AD_OK;
}

static bool pulls(const solve_spring *spring)
{
    return spring->stiffness[0] != 0 || spring->stiffness[1] != 0 || spring->stiffness[2] != 0;
}

void strain_form_set_jumps(strain_form *x, const solve_jumps *jumps)
{
    for (int e = 0, next = 0, k = 0; e <= x->kind.elements && next < jumps->count; e++) {
        const solve_jump *jump = &jumps->at[next];
        strain_edge *edge = &x->edges[e];
        if (fabs(jump->s - x->kind.edges[e]) >= SOLVE_SAME_PLACE) {
            continue;
        }
        next++;
        edge->turns = jump->turns;
        memcpy(edge->turn, jump->turn, sizeof edge->turn);
        for (int i = 0; i < jump->spring_count; i++, k++) {
            strain_spring *to = &x->springs[k];
            *to = (strain_spring){
                .edge = e, .unknown = -1, .given = &jumps->springs[jump->springs[i]]};
            if (pulls(to->given)) {
                to->unknown = x->unknowns;
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
    if (x->push_at >= 0 && i >= x->push_at && i < x->push_at + x->elastic) {
        return &x->at[(i - x->push_at) / 3].push[(i - x->push_at) % 3];
    }
    for (int k = 0; k < x->kind.springs; k++) {
        const int at = x->springs[k].unknown;
        if (at >= 0 && i >= at && i < at + 3) {
            return &x->springs[k].force[i - at];
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
        free(x->springs);
        free(x->matrix);
        free(x->coupled);
        free(x->right);
        free(x->swapped);
        free(x->direction);
        free(x->columns);
        free(x);
    }
}
