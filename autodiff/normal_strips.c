/* Which columns of J are zero in which residuals, and the cut that makes use of it: the last
 * layer's weights of an output only matter to residuals in which the output occurs. */
#include "autodiff/normal.h"

#include <stdlib.h>
#include <string.h>

/* Products of narrower strips are slow, those of wider ones leave few pieces to the threads. */
enum { NARROW = 64, WIDE = 256, GROUP_WIDE = 320 };

static void mark_term(const jacobian_block *block, jacobian_term term, size_t row_count, bool *used)
{
    size_t columns = term.x >= 0 ? (size_t)block->columns : 1;
    size_t first = block->offset + (size_t)term.first * columns;
    for (size_t k = first; k < first + (size_t)term.rows * columns; k++) {
        used[k * row_count] = true;
    }
}

/* used[column][residual] */
static void mark(const jacobian *j, bool *used)
{
    for (int r = 0; r < j->row_count; r++) {
        for (int b = 0; b < j->rows[r].count; b++) {
            const jacobian_block *block = &j->blocks[j->rows[r].first + b];
            for (int i = 0; i < block->count; i++) {
                mark_term(block, j->terms[block->first + i], (size_t)j->row_count, used + r);
            }
        }
    }
}

/* One strip more, or the last one wider when both are narrow. */
static void append(strips *s, size_t first, size_t width, const bool *used, size_t row_count)
{
    strip *last = s->count > 0 ? &s->items[s->count - 1] : NULL;
    if (!last || last->width + width > NARROW) {
        last = &s->items[s->count];
        *last = (strip){first, 0, s->live + s->count * row_count};
        s->count++;
    }
    last->width += width;
    bool *live = s->live + (s->count - 1) * row_count;
    for (size_t r = 0; r < row_count; r++) {
        live[r] = live[r] || used[r];
    }
}

static void make_groups(strips *s)
{
    size_t width = 0;
    for (size_t i = 0; i < s->count; i++) {
        width += s->items[i].width;
        if (i == 0 || width > GROUP_WIDE) {
            s->groups[s->group_count++].first = i;
            width = s->items[i].width;
        }
        s->groups[s->group_count - 1].end = i + 1;
    }
}

ad_status ad_strips_create(const jacobian *j, size_t parameters, strips *result)
{
    size_t row_count = (size_t)j->row_count;
    bool *used = calloc(parameters, row_count * sizeof *used);
    *result = (strips){.items = malloc(parameters * sizeof *result->items),
                       .groups = malloc(parameters * sizeof *result->groups),
                       .live = calloc(parameters, row_count * sizeof *used)};
    if (!used || !result->items || !result->groups || !result->live) {
        free(used);
        ad_strips_clear(result);
        return AD_NO_MEMORY;
    }
    mark(j, used);
    for (size_t first = 0, end; first < parameters; first = end) {
        const bool *own = used + first * row_count;
        end = first + 1;
        while (end < parameters && memcmp(own, used + end * row_count, row_count) == 0) {
            end++;
        }
        size_t pieces = (end - first + WIDE - 1) / WIDE;
        for (size_t i = 0; i < pieces; i++) {
            size_t from = first + i * (end - first) / pieces;
            size_t to = first + (i + 1) * (end - first) / pieces;
            append(result, from, to - from, own, row_count);
        }
    }
    free(used);
    make_groups(result);
    return AD_OK;
}

void ad_strips_clear(strips *s)
{
    free(s->items);
    free(s->groups);
    free(s->live);
    *s = (strips){0};
}

bool ad_strips_next(const strips *s, strip_group within, int residual, size_t *at, size_t *first,
                    size_t *width)
{
    *width = 0;
    while (*at < within.end && !s->items[*at].live[residual]) {
        ++*at;
    }
    if (*at == within.end) {
        return false;
    }
    *first = s->items[*at].first;
    for (; *at < within.end && s->items[*at].live[residual]; ++*at) {
        *width += s->items[*at].width;
    }
    return true;
}

bool ad_strips_alike(const strips *s, strip_group within, int residual, int other)
{
    bool alike = true;
    for (size_t i = within.first; i < within.end; i++) {
        alike = alike && s->items[i].live[residual] == s->items[i].live[other];
    }
    return alike;
}

size_t ad_strips_flops(const strips *s, int row_count)
{
    size_t flops = 0;
    for (size_t a = 0; a < s->count; a++) {
        const strip *top = &s->items[a];
        for (int r = 0; r < row_count; r++) {
            flops += top->live[r] ? top->width * (top->width + 1) : 0;
            for (size_t b = a + 1; top->live[r] && b < s->count; b++) {
                flops += s->items[b].live[r] ? 2 * top->width * s->items[b].width : 0;
            }
        }
    }
    return flops;
}
