/* What has to be in memory after a segment of instructions; all else stays in registers. */
#include "autodiff/emit/c_code.h"

#include <stdlib.h>
#include <string.h>

static int columns_of(const instruction *i)
{
    return i->columns > 1 ? i->columns : 1;
}

/* Every unit of a place, in all columns of a product. */
static void mark(bool *live, place p, int columns, bool value)
{
    for (int row = 0; p.kind == PLACE_TILE && row < p.rows; row++) {
        memset(live + p.offset + row * p.stride, value, (size_t)columns);
    }
}

static void mark_reads(const c_writer *w, int n, bool *live)
{
    const instruction *i = &w->pass->instructions[n];
    for (int k = 0; k < ad_op_table[i->op].arity; k++) {
        bool panel = !op_is_elementwise(i->op) && (k > 0 || op_is_reduction(i->op));
        if (w->again[n * AD_ARITY_MAX + k] < 0) {
            mark(live, i->in[k], panel ? columns_of(i) : 1, true);
        }
    }
}

/* The same of an instruction whose rows are written out: what its needed rows read. */
static void mark_row_reads(const c_writer *w, int n, bool *live)
{
    const instruction *i = &w->pass->instructions[n];
    for (int k = 0; k < ad_op_table[i->op].arity; k++) {
        for (int row = 0; row < i->out.rows && i->in[k].kind == PLACE_TILE; row++) {
            if (w->needed[w->row[n] + (size_t)row]) {
                live[i->in[k].offset + row * i->in[k].stride] = true;
            }
        }
    }
}

/* What operands are made again from, when a segment begins. */
static void mark_made_again(const c_writer *w, int n, bool *live)
{
    for (int k = 0; k < AD_ARITY_MAX; k++) {
        int by = w->again[n * AD_ARITY_MAX + k];
        for (int x = 0; by >= 0 && x < AD_ARITY_MAX; x++) {
            mark(live, w->pass->instructions[by].in[x], 1, true);
        }
    }
}

static bool is_live(const bool *live, const instruction *i)
{
    bool result = i->out.kind != PLACE_TILE || !op_is_elementwise(i->op);
    for (int row = 0; row < i->out.rows && !result; row++) {
        result = live[i->out.offset + row * i->out.stride];
    }
    return result;
}

/* Backwards over instructions first .. end-1: `after` is live after them, `live` becomes what is
 * live before. Of several that write a unit the last one keeps it. */
static void walk_segment(c_writer *w, int first, int end, const bool *after, bool *live,
                         bool *written)
{
    for (int n = end - 1; n >= first; n--) {
        const instruction *i = &w->pass->instructions[n];
        bool by_rows = op_is_elementwise(i->op) && !ad_c_is_loop(i);
        w->dead[n] = !is_live(live, i);
        for (int row = 0; i->out.kind == PLACE_TILE && row < i->out.rows; row++) {
            int unit = i->out.offset + row * i->out.stride;
            w->kept[w->row[n] + (size_t)row] = after[unit] && !written[unit];
            w->needed[w->row[n] + (size_t)row] = !by_rows || live[unit];
            written[unit] = true;
        }
        mark(live, i->out, columns_of(i), false);
        if (by_rows) {
            mark_row_reads(w, n, live);
        } else if (!w->dead[n]) {
            mark_reads(w, n, live);
        }
    }
    for (int n = first; n < end; n++) {
        mark(written, w->pass->instructions[n].out, 1, false);
        if (!w->dead[n]) {
            mark_made_again(w, n, live);
        }
    }
}

bool ad_c_find_lives(c_writer *w)
{
    const pass *p = w->pass;
    size_t units = (size_t)p->units + 1;
    bool *live = calloc(3 * units, sizeof *live), *after = live ? live + units : NULL;
    for (int i = 0; live && i < p->output_count; i++) {
        mark(live, p->outputs[i].from, 1, true);
    }
    for (int i = 0; live && i < p->kept_count; i++) {
        mark(live, p->kept[i].from, 1, true);
    }
    for (int n = p->count; live && n > 0;) {
        int first = n - 1;
        while (first > 0 && w->end[first - 1] == n) {
            first--;
        }
        memcpy(after, live, units);
        walk_segment(w, first, n, after, live, live + 2 * units);
        n = first;
    }
    free(live);
    return live != NULL;
}
