/* Values that cost less to compute again than to fetch: made by an earlier run of instructions, by
 * arithmetic, from what is fetched in any case. So what lies between the way forward through a
 * layer and the way back, such as 1 - y^2, takes no memory. Blocks of many rows only. */
#include "autodiff/emit/c_code.h"

#include <stdlib.h>
#include <string.h>

enum { NOBODY = -1, SEVERAL = -2 };

/* A block that a segment reads from memory. */
typedef struct fetched {
    place at;
    int by; /* the instruction that wrote it, or NOBODY, SEVERAL */
    bool needed, again;
} fetched;

typedef struct search {
    c_writer *w;
    int *by;       /* [units] the last instruction that wrote each */
    int *versions; /* [instructions][AD_ARITY_MAX] who wrote the operand that it read */
    fetched *list; /* of the segment at work */
    int count;
} search;

static int writer_of(const search *s, place p)
{
    int by = s->by[p.offset];
    for (int row = 1; row < p.rows; row++) {
        by = s->by[p.offset + row * p.stride] == by ? by : SEVERAL;
    }
    return by;
}

static bool same_block(place a, place b)
{
    return a.kind == b.kind && a.offset == b.offset && a.stride == b.stride && a.rows == b.rows;
}

static bool is_cheap(int op)
{
    return op == OP_ADD || op == OP_SUB || op == OP_MUL || (op >= OP_MUL_ADD && op <= OP_PAIR_SUB);
}

static fetched *find(const search *s, place p)
{
    for (int i = 0; i < s->count; i++) {
        if (same_block(s->list[i].at, p)) {
            return &s->list[i];
        }
    }
    return NULL;
}

/* Operands whose reach is looked at before the loop stay in memory. */
static bool stays(const search *s, int op)
{
    return !s->w->vectors && has_reach(op);
}

/* Can it be made again, from blocks that are fetched and are what they were? Those stay. */
static void consider(search *s, fetched *f)
{
    if (f->by < 0 || f->needed) {
        return;
    }
    const instruction *i = &s->w->pass->instructions[f->by];
    int arity = ad_op_table[i->op].arity;
    bool ok = is_cheap(i->op) && same_block(i->out, f->at);
    for (int pass = 0; pass < 2 && ok; pass++) {
        for (int k = 0; k < arity && ok; k++) {
            fetched *from = i->in[k].kind == PLACE_TILE ? find(s, i->in[k]) : NULL;
            if (i->in[k].kind != PLACE_TILE) {
                continue;
            }
            ok = from && !from->again && from != f && from->by != SEVERAL &&
                 from->by == s->versions[f->by * AD_ARITY_MAX + k];
            if (ok && pass == 1) {
                from->needed = true;
            }
        }
    }
    f->again = ok;
}

static bool is_written(const pass *p, int first, int end, place block)
{
    for (int n = first; n < end; n++) {
        if (same_block(p->instructions[n].out, block)) {
            return true;
        }
    }
    return false;
}

/* Blocks are either the same or apart, within a segment (ad_instructions_conflict). */
static void search_segment(search *s, int first, int end)
{
    const pass *p = s->w->pass;
    s->count = 0;
    for (int n = first; n < end; n++) {
        const instruction *i = &p->instructions[n];
        for (int k = 0; k < ad_op_table[i->op].arity; k++) {
            place in = i->in[k];
            if (in.kind == PLACE_TILE && !find(s, in) && !is_written(p, first, n, in)) {
                s->list[s->count++] = (fetched){.at = in, .by = writer_of(s, in)};
            }
        }
    }
    for (int i = 0; i < s->count; i++) {
        consider(s, &s->list[i]);
    }
    for (int n = first; n < end; n++) {
        const instruction *i = &p->instructions[n];
        for (int k = 0; k < ad_op_table[i->op].arity; k++) {
            fetched *f = i->in[k].kind == PLACE_TILE ? find(s, i->in[k]) : NULL;
            if (f && f->again && !stays(s, i->op) && !is_written(p, first, n, i->in[k])) {
                s->w->again[n * AD_ARITY_MAX + k] = f->by;
            }
        }
    }
}

static void note_writes(search *s, int n)
{
    const instruction *i = &s->w->pass->instructions[n];
    int columns = i->columns > 1 ? i->columns : 1;
    for (int k = 0; k < AD_ARITY_MAX; k++) {
        s->versions[n * AD_ARITY_MAX + k] =
            i->in[k].kind == PLACE_TILE && i->in[k].rows > 0 ? writer_of(s, i->in[k]) : SEVERAL;
    }
    for (int row = 0; i->out.kind == PLACE_TILE && row < i->out.rows; row++) {
        for (int c = 0; c < columns; c++) {
            s->by[i->out.offset + row * i->out.stride + c] = n;
        }
    }
}

bool ad_c_find_again(c_writer *w)
{
    const pass *p = w->pass;
    size_t count = (size_t)p->count * AD_ARITY_MAX + 1;
    search s = {.w = w};
    ad_memory memory = {0};
    AD_TAKE(w, again, count);
    AD_TAKE_OF(&memory, s.by, p->units + 1);
    AD_TAKE_OF(&memory, s.versions, count);
    AD_TAKE_OF(&memory, s.list, C_LOOP_MAX * AD_ARITY_MAX);
    bool ok = w->again && !memory.is_short;
    if (ok) {
        memset(w->again, -1, count * sizeof *w->again);
        memset(s.by, -1, ((size_t)p->units + 1) * sizeof *s.by); /* NOBODY */
    }
    for (int n = 0; ok && n < p->count; n = w->end[n]) {
        if (ad_c_is_loop(&p->instructions[n])) {
            search_segment(&s, n, w->end[n]);
        }
        for (int i = n; i < w->end[n]; i++) {
            note_writes(&s, i);
        }
    }
    ad_memory_free(&memory);
    return ok;
}
