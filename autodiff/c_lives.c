/* What has to be in memory after a segment of instructions; all else stays in registers. */
#include "autodiff/c_code.h"

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

static void mark_reads(const instruction *i, bool *live)
{
    for (int k = 0; k < ad_op_table[i->op].arity; k++) {
        bool panel = !op_is_elementwise(i->op) && (k > 0 || op_is_reduction(i->op));
        mark(live, i->in[k], panel ? columns_of(i) : 1, true);
    }
}

/* Backwards over instructions first .. end-1: `after` is live after them, `live` becomes what is
 * live before. Of several that write a unit the last one keeps it. */
static void walk_segment(const pass *p, int first, int end, lives *l, const bool *after, bool *live,
                         bool *written)
{
    for (int n = end - 1; n >= first; n--) {
        const instruction *i = &p->instructions[n];
        for (int row = 0; i->out.kind == PLACE_TILE && row < i->out.rows; row++) {
            int unit = i->out.offset + row * i->out.stride;
            l->kept[l->first[n] + (size_t)row] = after[unit] && !written[unit];
            written[unit] = true;
        }
        mark(live, i->out, columns_of(i), false);
        mark_reads(i, live);
    }
    for (int n = first; n < end; n++) {
        mark(written, p->instructions[n].out, 1, false);
    }
}

static bool make_room(const pass *p, lives *l)
{
    size_t rows = 0;
    l->first = malloc(((size_t)p->count + 1) * sizeof *l->first);
    for (int n = 0; l->first && n < p->count; n++) {
        l->first[n] = rows;
        rows += (size_t)p->instructions[n].out.rows;
    }
    l->kept = calloc(rows + 1, sizeof *l->kept);
    return l->first && l->kept;
}

bool ad_c_lives_create(const pass *p, const int *end, lives *l)
{
    size_t units = (size_t)p->units + 1;
    bool *live = calloc(3 * units, sizeof *live), *after = live + units,
         *written = live + 2 * units;
    *l = (lives){0};
    bool ok = make_room(p, l) && live;
    for (int i = 0; ok && i < p->output_count; i++) {
        mark(live, p->outputs[i].from, 1, true);
    }
    for (int n = p->count; ok && n > 0;) {
        int first = n - 1;
        while (first > 0 && end[first - 1] == n) {
            first--;
        }
        memcpy(after, live, units);
        walk_segment(p, first, n, l, after, live, written);
        n = first;
    }
    free(live);
    return ok;
}

void ad_c_lives_clear(lives *l)
{
    free(l->kept);
    free(l->first);
    *l = (lives){0};
}
