/* Which pass computes what: reductions have to be over before what needs them, values of members
 * come before their points. */
#include "autodiff/compile/compile.h"

#include <stdlib.h>
#include <string.h>

static void assign_stages(compilation *c)
{
    for (int id = 0; id < c->tape->count; id++) {
        const node *n = &c->tape->nodes[id];
        for (int i = 0; c->needed[id] && i < n->count; i++) {
            int before = c->stage[argument(c, id, i)] + op_is_reduction(n->op);
            c->stage[id] = before > c->stage[id] ? before : c->stage[id];
        }
        c->stages = c->needed[id] && c->stage[id] > c->stages ? c->stage[id] : c->stages;
        if (c->needed[id] && n->extent != AD_UNIFORM && c->stage[id] >= c->stages) {
            c->stages = c->stage[id] + 1;
        }
        c->program->members = c->program->members || (c->needed[id] && n->extent == AD_MEMBER) ||
                              (c->needed[id] && n->op == OP_POINTS && n->whole != OVER_POINTS);
    }
}

/* Do two sums run over the same points or members? Of a sum of sums, all do. */
static bool same_pass(const compilation *c, int a, int b)
{
    const node *nodes = c->tape->nodes;
    while (!op_is_reduction(nodes[a].op)) {
        a = argument(c, a, 0);
    }
    while (!op_is_reduction(nodes[b].op)) {
        b = argument(c, b, 0);
    }
    return nodes[a].whole == nodes[b].whole;
}

/* A sum of sums over points is summed in one place: reductions are the leaves of a tree of
 * additions without other users, whose root holds the sum. */
static void assign_sums(compilation *c)
{
    for (int id = 0; id < c->tape->count; id++) {
        const node *n = &c->tape->nodes[id];
        c->sum_of[id] = c->needed[id] && op_is_reduction(n->op) ? id : -1;
        if (!c->needed[id] || n->op != OP_ADD || n->extent != AD_UNIFORM) {
            continue;
        }
        int a = argument(c, id, 0), b = argument(c, id, 1);
        bool tree = c->sum_of[a] >= 0 && c->sum_of[b] >= 0 && c->uses[a] == 1 && c->uses[b] == 1;
        if (tree && c->stage[a] == c->stage[b] && same_pass(c, a, b) &&
            c->tape->nodes[a].rows == n->rows && c->tape->nodes[b].rows == n->rows) {
            c->sum_of[id] = id;
        }
    }
    for (int id = c->tape->count - 1; id >= 0; id--) {
        for (int i = 0; c->sum_of[id] >= 0 && c->tape->nodes[id].op == OP_ADD && i < 2; i++) {
            c->sum_of[argument(c, id, i)] = c->sum_of[id];
        }
    }
}

/* ---- passes --------------------------------------------------------------------------------- */

bool ad_stages_summed_by(const compilation *c, int id, const pass *p)
{
    while (!op_is_reduction(c->tape->nodes[id].op)) {
        id = argument(c, id, 0);
    }
    return c->stage[id] == p->stage + 1 && (c->tape->nodes[id].whole == OVER_MEMBERS) == p->members;
}

/* Is it there when a pass over members begins: a sum over a member's points, or what an earlier
 * pass has computed? */
bool ad_stages_is_there(const compilation *c, int id, const pass *p)
{
    int op = c->tape->nodes[id].op;
    return p->members &&
           (op_is_reduction(op) ? c->tape->nodes[id].extent == AD_MEMBER
                                : op != OP_INPUT && c->home[id] >= 0 && c->home[id] < p->stage);
}

/* What a node of the pass needs. A matrix of its own for each member is read where it is. */
static void mark_arguments(compilation *c, int id, const pass *p)
{
    const node *n = &c->tape->nodes[id];
    for (int i = 0; i < n->count; i++) {
        int x = argument(c, id, i);
        bool matrix = i == 0 && op_is_matvec(n->op) && spread_of(c->tape, x) >= 0;
        c->in[x] = c->in[x] ||
                   (!matrix && c->tape->nodes[x].extent == (p->members ? AD_MEMBER : AD_BATCH));
    }
}

/* The value of members that is spread by a node, and has to be computed for that by the pass. */
static void mark_spread(compilation *c, int id, const pass *p)
{
    int x = spread_of(c->tape, id);
    if (x < 0 || !c->needed[id]) {
        return;
    }
    c->kept[x] = true;
    if (p->members && c->stage[x] == p->stage && !op_is_reduction(c->tape->nodes[x].op)) {
        c->in[x] = c->stored[x] = true;
    }
}

/* Run for all passes in their order, then again for each. */
bool ad_stages_mark(compilation *c, const pass *p)
{
    bool any = false;
    memset(c->in, 0, (size_t)c->tape->count * sizeof *c->in);
    memset(c->stored, 0, (size_t)c->tape->count * sizeof *c->stored);
    for (int i = 0; i < c->program->outputs; i++) {
        int id = c->program->output_ids[i];
        c->in[id] = c->tape->nodes[id].extent == (p->members ? AD_MEMBER : AD_BATCH) &&
                    c->stage[id] == p->stage;
    }
    for (int id = c->tape->count - 1; id >= 0; id--) {
        bool reduction = c->needed[id] && op_is_reduction(c->tape->nodes[id].op);
        mark_spread(c, id, p);
        c->in[id] = c->in[id] || (reduction && ad_stages_summed_by(c, id, p));
        any = any || c->in[id];
        if (!c->in[id]) {
            continue;
        }
        if (ad_stages_is_there(c, id, p)) {
            c->kept[id] = true;
            continue;
        }
        if (p->members) {
            c->home[id] = c->home[id] < 0 ? p->stage : c->home[id];
            c->stored[id] = c->stored[id] || (c->kept[id] && c->home[id] == p->stage);
        }
        mark_arguments(c, id, p);
    }
    return any;
}

/* At every stage first the members, then their points. */
static bool list_passes(compilation *c)
{
    ad_program *program = c->program;
    AD_TAKE(program, passes, 2 * c->stages + 1);
    for (int k = 0; program->passes && k < 2 * c->stages; k++) {
        pass p = {.members = k % 2 == 0, .stage = k / 2};
        if (program->members ? ad_stages_mark(c, &p) : !p.members) {
            program->passes[program->pass_count++] = p;
        }
    }
    if (program->passes) {
        program->passes[program->pass_count].stage = c->stages;
    }
    return program->passes != NULL;
}

bool ad_stages_assign(compilation *c)
{
    assign_stages(c);
    assign_sums(c);
    return list_passes(c);
}
