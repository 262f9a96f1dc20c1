#include "physics/solve/strain_form.h"

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
    }
}

static void *make(size_t count, size_t size)
{
    return calloc(count + 1, size);
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
    x->unknowns -= 3 * kind->springs;
    x->width = make(elements, sizeof *x->width);
    x->points = make(nodes, sizeof *x->points);
    x->actuators = make(nodes * (size_t)kind->actuators, sizeof *x->actuators);
    x->at = make(nodes, sizeof *x->at);
    x->edges = make(elements + 1, sizeof *x->edges);
    x->springs = make((size_t)kind->springs, sizeof *x->springs);
    x->matrix =
        make(kind->is_rigid || kind->is_one ? 0 : elements * each * each, sizeof *x->matrix);
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
