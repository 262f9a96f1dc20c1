/* The instructions of a pass, from its ordered and placed nodes. */
#include "autodiff/compile/program.h"

#include <stdlib.h>

typedef struct emitter {
    const pass_plan *plan;
    pass *to;
    int value; /* the node at work */
    bool ok;
} emitter;

static place place_for(const emitter *e, int id, int rows)
{
    const pass_plan *plan = e->plan;
    bool tile = plan->tape->nodes[id].extent != AD_UNIFORM;
    place p = tile ? plan->places[id] : plan->program->places[id];
    if (p.rows == 1 && rows > 1) {
        p.stride = 0;
    }
    return p;
}

static place part_of(place whole, int row, int rows)
{
    whole.offset += row * whole.stride;
    whole.rows = rows;
    return whole;
}

static instruction *append(emitter *e, instruction i)
{
    pass *p = e->to;
    if (!ad_tape_grow((void **)&p->instructions, &p->capacity, p->count + 1,
                      sizeof *p->instructions)) {
        e->ok = false;
        return NULL;
    }
    i.value = e->value;
    p->instructions[p->count] = i;
    return &p->instructions[p->count++];
}

static void emit_elementwise(emitter *e, int op, place out, int count, const place *in, int whole,
                             double number)
{
    instruction i = {.op = op, .whole = whole, .number = number, .out = out};
    unsigned mask = 0;
    for (int k = 0; k < count; k++) {
        i.in[k] = in[k];
        mask |= in[k].kind == PLACE_TILE ? 0 : 1u << k;
    }
    i.loop = e->plan->program->kernels->loops[op][mask];
    append(e, i);
}

static void emit_copy(emitter *e, place out, place from)
{
    if (from.rows == 1 && out.rows > 1) {
        from.stride = 0;
    }
    emit_elementwise(e, OP_COPY, out, 1, &from, 0, 0);
}

static void emit_stack(emitter *e, int id)
{
    const pass_plan *plan = e->plan;
    int row = 0;
    for (int i = 0; i < plan->nodes[id].count; i++) {
        int part = ad_plan_argument(plan, id, i), rows = plan->tape->nodes[part].rows;
        if (!(plan->tape->nodes[part].extent != AD_UNIFORM && plan->parent[part] == id &&
              plan->row[part] == row)) {
            emit_copy(e, part_of(plan->places[id], row, rows), place_for(e, part, rows));
        }
        row += rows;
    }
}

static void emit_pad(emitter *e, int id)
{
    const pass_plan *plan = e->plan;
    place zero = {.kind = PLACE_UNIFORM, .offset = 0, .stride = 0, .rows = 1};
    int inner = ad_plan_argument(plan, id, 0), rows = plan->tape->nodes[inner].rows;
    int before = plan->nodes[id].whole, after = plan->nodes[id].rows - before - rows;
    if (before) {
        emit_copy(e, part_of(plan->places[id], 0, before), zero);
    }
    emit_copy(e, part_of(plan->places[id], before, rows), place_for(e, inner, rows));
    if (after) {
        emit_copy(e, part_of(plan->places[id], before + rows, after), zero);
    }
}

static void emit_sum_rows(emitter *e, int id)
{
    place out = e->plan->places[id];
    place all = place_for(e, ad_plan_argument(e->plan, id, 0), 0);
    place pair[2] = {part_of(all, 0, 1), part_of(all, 1, 1)};
    for (int row = 1; row < all.rows; row++) {
        pair[1] = part_of(all, row, 1);
        emit_elementwise(e, OP_ADD, out, 2, pair, 0, 0);
        pair[0] = out;
    }
}

/* b continues a: the next columns of the same panel. */
static bool continues(place a, int columns, place b)
{
    return a.kind == PLACE_TILE && b.kind == PLACE_TILE && a.stride == b.stride &&
           b.offset == a.offset + columns && a.stride >= columns + 1;
}

/* Products with one matrix, and sums into one place, in the order of their columns: one instruction
 * for a run of columns that lie side by side. `done` marks the nodes served. */
static void emit_products(emitter *e, int at, bool *done)
{
    const pass_plan *plan = e->plan;
    int first = plan->order[at], op = plan->nodes[first].op;
    bool sum = op == OP_OUTER_SUM, merge = sum || ad_plan_is_product(plan, first);
    for (;;) {
        int next = -1; /* the one of the lowest column that is left */
        for (int k = at; k < plan->ordered; k++) {
            int id = plan->order[k];
            if (plan->level[id] != plan->level[first]) {
                break;
            }
            bool alike =
                id == first || (merge && plan->nodes[id].op == op &&
                                (sum ? plan->sum_of[id] == plan->sum_of[first]
                                     : plan->arguments[id][0] == plan->arguments[first][0]));
            if (alike && !done[id] &&
                (next < 0 || plan->places[plan->arguments[id][1]].column <
                                 plan->places[plan->arguments[next][1]].column)) {
                next = id;
            }
        }
        if (next < 0) {
            return;
        }
        done[next] = true;
        e->value = next;
        instruction i = {.op = op, .columns = 1};
        i.in[0] = place_for(e, plan->arguments[next][0], 0);
        i.in[1] = place_for(e, plan->arguments[next][1], 0);
        i.out = sum ? plan->program->places[plan->sum_of[next]] : plan->places[next];
        instruction *last = e->to->count ? &e->to->instructions[e->to->count - 1] : NULL;
        if (merge && last && last->op == op && last->in[1].kind == PLACE_TILE &&
            continues(last->in[1], last->columns, i.in[1]) &&
            (sum ? last->out.offset == i.out.offset &&
                       continues(last->in[0], last->columns, i.in[0])
                 : last->in[0].offset == i.in[0].offset &&
                       continues(last->out, last->columns, i.out))) {
            last->columns++;
        } else {
            append(e, i);
        }
    }
}

/* Where the rows of values of members are: of the one that a node spreads over the points, or, in a
 * pass over the members, of its own. */
static place member_place(const pass_plan *plan, int id)
{
    int spread = spread_of(plan->tape, id);
    return plan->program->places[spread >= 0 ? spread : id];
}

static void emit_spread(emitter *e, int id)
{
    instruction i = {.op = OP_SPREAD, .columns = 1, .out = e->plan->places[id]};
    i.in[0] = member_place(e->plan, id);
    append(e, i);
}

/* A product with a matrix of each member, read where it is. */
static void emit_member_product(emitter *e, int id)
{
    const pass_plan *plan = e->plan;
    instruction i = {.op = plan->nodes[id].op, .columns = 1, .out = plan->places[id]};
    i.in[0] = member_place(plan, plan->arguments[id][0]);
    i.in[1] = place_for(e, plan->arguments[id][1], 0);
    append(e, i);
}

static void emit_node(emitter *e, int at, bool *done)
{
    const pass_plan *plan = e->plan;
    int id = plan->order[at];
    const node *n = &plan->nodes[id];
    if (done[id]) {
        return;
    }
    e->value = id;
    switch (ad_op_table[n->op].form) {
    case FORM_LEAF:
    case FORM_SLICE: /* views */
        return;
    case FORM_JOIN:
        (n->op == OP_PAD ? emit_pad : emit_stack)(e, id);
        return;
    case FORM_SPREAD:
        emit_spread(e, id);
        return;
    case FORM_SUM_ROWS:
        emit_sum_rows(e, id);
        return;
    case FORM_SUM_POINTS: {
        instruction i = {.op = n->op, .columns = 1};
        i.in[0] = place_for(e, plan->arguments[id][0], 0);
        i.out = plan->program->places[plan->sum_of[id]];
        append(e, i);
        return;
    }
    case FORM_PRODUCT:
        if (spread_of(plan->tape, plan->arguments[id][0]) >= 0) {
            emit_member_product(e, id);
            return;
        } /* fallthrough */
    case FORM_OUTER:
    case FORM_OUTER_SUM:
        emit_products(e, at, done);
        return;
    case FORM_ELEMENTWISE: {
        place in[AD_ARITY_MAX];
        for (int i = 0; i < n->count; i++) {
            in[i] = place_for(e, plan->arguments[id][i], n->rows);
        }
        emit_elementwise(e, n->op, plan->places[id], n->count, in, n->whole, n->number);
    }
    }
}

/* Consecutive elementwise instructions of equally many rows; worth pieces only when several. */
static bool group_instructions(ad_memory *memory, pass *p)
{
    AD_TAKE_OF(memory, p->groups, p->count);
    for (int i = 0; p->groups && i < p->count; i++) {
        const instruction *now = &p->instructions[i];
        group *last = p->group_count ? &p->groups[p->group_count - 1] : NULL;
        bool elementwise = op_is_elementwise(now->op);
        if (last && elementwise && op_is_elementwise(p->instructions[i - 1].op) &&
            p->instructions[i - 1].out.rows == now->out.rows) {
            last->count++;
            last->pieces = now->out.rows > 1;
            continue;
        }
        p->groups[p->group_count++] = (group){.first = i, .count = 1};
    }
    return p->groups != NULL;
}

/* Within a group an instruction may read rows that belong to a later piece of an earlier
 * instruction of the group (a row of a block computed just before). Such groups are split. */
static bool overlaps(place a, place b)
{
    int a_end = a.offset + (a.rows - 1) * a.stride + 1;
    int b_end = b.offset + (b.rows - 1) * b.stride + 1;
    return a.kind == PLACE_TILE && b.kind == PLACE_TILE && a.offset < b_end && b.offset < a_end;
}

static bool same_rows(place a, place b)
{
    return a.offset == b.offset && a.stride == b.stride && a.rows == b.rows;
}

static bool side_by_side(place a, place b) /* different columns of one panel */
{
    return a.stride == b.stride && a.rows == b.rows && a.column != b.column &&
           a.offset - a.column == b.offset - b.column;
}

bool ad_instructions_conflict(const instruction *earlier, const instruction *later)
{
    for (int i = 0; i < AD_ARITY_MAX; i++) {
        place read = later->in[i], read_before = earlier->in[i];
        if (read.rows && overlaps(earlier->out, read) && !same_rows(earlier->out, read) &&
            !side_by_side(earlier->out, read)) {
            return true;
        }
        if (read_before.rows && overlaps(later->out, read_before) &&
            !same_rows(later->out, read_before) && !side_by_side(later->out, read_before)) {
            return true;
        }
    }
    return overlaps(earlier->out, later->out) && !same_rows(earlier->out, later->out) &&
           !side_by_side(earlier->out, later->out);
}

static void split_groups(pass *p)
{
    for (int g = 0; g < p->group_count; g++) {
        group *now = &p->groups[g];
        for (int i = 1; now->pieces && i < now->count; i++) {
            for (int k = 0; k < i && now->pieces; k++) {
                now->pieces = !ad_instructions_conflict(&p->instructions[now->first + k],
                                                        &p->instructions[now->first + i]);
            }
        }
    }
}

static bool written_before(const pass *p, const group *g, int reader, place read)
{
    for (int i = g->first; i < reader; i++) {
        if (same_rows(p->instructions[i].out, read)) {
            return true;
        }
    }
    return false;
}

static void make_common(pass *p, place memory)
{
    for (int i = 0; i < p->count; i++) {
        instruction *now = &p->instructions[i];
        now->out.local = now->out.local && !overlaps(now->out, memory);
        for (int k = 0; k < AD_ARITY_MAX; k++) {
            now->in[k].local = now->in[k].local && !overlaps(now->in[k], memory);
        }
    }
}

/* The layout took a run of elementwise instructions for one group. Where a value passes from one
 * group to another after all, its memory is not local. */
static void settle_locals(pass *p)
{
    for (int g = 0; g < p->group_count; g++) {
        const group *now = &p->groups[g];
        for (int i = now->first; i < now->first + now->count; i++) {
            for (int k = 0; k < AD_ARITY_MAX; k++) {
                place read = p->instructions[i].in[k];
                if (read.local && !written_before(p, now, i, read)) {
                    make_common(p, read);
                }
            }
        }
    }
}

bool ad_emit_pass(const pass_plan *plan, pass *p)
{
    bool *done = calloc((size_t)plan->count + 1, sizeof *done);
    emitter e = {.plan = plan, .to = p, .ok = done != NULL};
    for (int at = 0; e.ok && at < plan->ordered; at++) {
        emit_node(&e, at, done);
    }
    free(done);
    if (!e.ok || !group_instructions(&plan->program->memory, p)) {
        return false;
    }
    split_groups(p);
    settle_locals(p);
    return true;
}
