/* Does every uniform value have numbers of its own, and are they there before they are read? */
#include "verify.h"

#include <string.h>

static bool has_place(const verifier *v, int id)
{
    return v->program->places[id].rows > 0;
}

/* Every uniform value has numbers of its own; slices and parameters lie within those of others. */
static bool check_uniform_place(verifier *v, int id)
{
    const node *n = &v->tape->nodes[id];
    place p = v->program->places[id];
    if (!has_place(v, id)) {
        return n->op == OP_ADD || op_is_reduction(n->op) ||
               ad_verify_wrong(v, "%%%d has no place", id);
    }
    if (p.rows != n->rows || p.stride != 1 || p.kind == PLACE_TILE) {
        return ad_verify_wrong(v, "%%%d of %d rows has a place of %d", id, n->rows, p.rows);
    }
    if (n->op == OP_PARAMETER) {
        return (p.kind == PLACE_PARAMETER && (size_t)p.offset == n->offset) ||
               ad_verify_wrong(v, "%%%d is not where the parameter is", id);
    }
    if (n->op == OP_SLICE) {
        place whole = v->program->places[argument(v, n, 0)];
        return (p.kind == whole.kind && p.offset == whole.offset + n->whole &&
                n->whole + n->rows <= whole.rows) ||
               ad_verify_wrong(v, "%%%d is not a part of %%%d", id, argument(v, n, 0));
    }
    if (p.kind != PLACE_UNIFORM || p.offset < 1 || p.offset > v->program->uniform_count - p.rows) {
        return ad_verify_wrong(v, "%%%d lies outside of the uniform memory", id);
    }
    for (int i = p.offset; i < p.offset + p.rows; i++) {
        if (v->owned[i]) {
            return ad_verify_wrong(v, "%%%d shares uniform memory with another value", id);
        }
        v->owned[i] = true;
    }
    return true;
}

static void set_ready(verifier *v, int id)
{
    place p = v->program->places[id];
    for (int i = 0; i < p.rows; i++) {
        v->ready[p.offset + i] = true;
    }
}

bool ad_verify_ready(verifier *v, int id)
{
    place p = v->program->places[id];
    for (int i = 0; p.kind == PLACE_UNIFORM && i < p.rows; i++) {
        if (!v->ready[p.offset + i]) {
            return ad_verify_wrong(v, "%%%d is used before it is computed", id);
        }
    }
    return has_place(v, id) || ad_verify_wrong(v, "%%%d is used but has no place", id);
}

static bool check_constant(verifier *v, int id)
{
    const node *n = &v->tape->nodes[id];
    const double *at = v->program->uniform + v->program->places[id].offset;
    for (int row = 0; row < n->rows; row++) {
        double value = n->splat ? n->number : v->tape->numbers[n->offset + (size_t)row];
        if (memcmp(&at[row], &value, sizeof value) != 0) {
            return ad_verify_wrong(v, "constant %%%d holds %g in place of %g", id, at[row], value);
        }
        v->constant[v->program->places[id].offset + row] = true;
    }
    set_ready(v, id);
    return true;
}

/* What has no place is a summand of a sum over points, and of that alone. */
static bool check_arguments(verifier *v, int id)
{
    const node *n = &v->tape->nodes[id];
    for (int i = 0; i < n->count; i++) {
        int x = argument(v, n, i);
        bool summand = n->op == OP_ADD && n->extent == AD_UNIFORM;
        if (v->tape->nodes[x].extent == AD_UNIFORM && !has_place(v, x) && !summand) {
            return ad_verify_wrong(v, "%%%d is used but has no place", x);
        }
    }
    return true;
}

bool ad_verify_uniforms(verifier *v)
{
    for (int id = 0; id < v->tape->count; id++) {
        const node *n = &v->tape->nodes[id];
        if (v->formulas.needed[id] && !check_arguments(v, id)) {
            return false;
        }
        if (v->formulas.needed[id] && n->extent == AD_UNIFORM &&
            (!check_uniform_place(v, id) || (n->op == OP_CONSTANT && !check_constant(v, id)))) {
            return false;
        }
    }
    v->ready[0] = v->constant[0] = v->program->uniform[0] == 0;
    return v->ready[0] || ad_verify_wrong(v, "the zero for padding is not 0");
}

/* What is computed once, before a pass. */
bool ad_verify_evaluated(verifier *v, const pass *p)
{
    v->instruction = -1;
    for (int i = 0; i < p->uniform_count; i++) {
        int id = p->uniforms[i];
        const node *n = &v->tape->nodes[id];
        place at = v->program->places[id];
        bool computed = n->op != OP_CONSTANT && n->op != OP_SLICE && !op_is_reduction(n->op);
        if (!computed || !v->formulas.needed[id] || n->extent != AD_UNIFORM || !has_place(v, id) ||
            at.kind != PLACE_UNIFORM || v->ready[at.offset]) {
            return ad_verify_wrong(v, "%%%d is computed for nothing, or twice", id);
        }
        for (int k = 0; k < n->count; k++) {
            if (!ad_verify_ready(v, argument(v, n, k))) {
                return false;
            }
        }
        set_ready(v, id);
    }
    return true;
}
