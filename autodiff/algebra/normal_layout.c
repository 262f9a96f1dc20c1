/* Which columns of J are worked on how, and which of their products are not 0. */
#include "autodiff/algebra/normal.h"

#include <stdlib.h>
#include <string.h>

/* Narrow heads leave panels empty; many are those of hidden layers, which save nothing. */
enum { HEAD_WIDTH = 2 * PANEL, HEADS_MAX = 64 };

static int panels_of(int width)
{
    return (width + PANEL - 1) / PANEL;
}

/* ---- heads ----------------------------------------------------------------------------------- */

/* Columns of the block by a view if it consists of outer products in all residuals, else 0. */
static int head_width(const jacobian *j, int view)
{
    int width = 0;
    for (int r = 0; r < j->row_count; r++) {
        const jacobian_block *block = &j->blocks[j->rows[r].first + view];
        for (int i = 0; i < block->count; i++) {
            if (j->terms[block->first + i].x < 0) {
                return 0;
            }
            width = block->columns;
        }
    }
    return width >= HEAD_WIDTH ? width : 0;
}

static int source_of(normal_layout *l, int x, int width)
{
    for (int i = 0; i < l->source_count; i++) {
        if (l->sources[i].x == x) {
            return i;
        }
    }
    l->sources[l->source_count] = (normal_source){x, width, l->source_panels};
    l->source_panels += panels_of(width);
    return l->source_count++;
}

static void add_head(normal_layout *l, const jacobian *j, int view, int row, int width)
{
    normal_head *head = &l->heads[l->head_count++];
    *head = (normal_head){0, width, l->weight_count, 0};
    for (int r = 0; r < j->row_count; r++) {
        const jacobian_block *block = &j->blocks[j->rows[r].first + view];
        head->column = block->offset + (size_t)row * (size_t)width;
        for (int i = 0; i < block->count; i++) {
            jacobian_term term = j->terms[block->first + i];
            if (row >= term.first && row < term.first + term.rows) {
                l->weights[l->weight_count++] =
                    (normal_weight){r, source_of(l, term.x, width), term.y, row};
            }
        }
    }
    head->weights = l->weight_count - head->weight;
    l->weights_max = head->weights > l->weights_max ? head->weights : l->weights_max;
}

static void add_heads(normal_layout *l, const jacobian *j, bool *plain)
{
    for (int view = 0; view < j->rows[0].count; view++) {
        int width = head_width(j, view);
        size_t offset = j->blocks[j->rows[0].first + view].offset;
        int rows = 0;
        for (int r = 0; width > 0 && r < j->row_count; r++) {
            const jacobian_block *block = &j->blocks[j->rows[r].first + view];
            rows = block->count > 0 ? block->rows : rows;
        }
        if (l->head_count + rows > HEADS_MAX) {
            continue;
        }
        for (int row = 0; row < rows; row++) {
            add_head(l, j, view, row, width);
        }
        memset(plain + offset, 0, (size_t)rows * (size_t)width * sizeof *plain);
    }
}

/* ---- plain columns --------------------------------------------------------------------------- */

/* used[column][residual] */
static void mark(const jacobian *j, bool *used)
{
    for (int r = 0; r < j->row_count; r++) {
        for (int b = 0; b < j->rows[r].count; b++) {
            const jacobian_block *block = &j->blocks[j->rows[r].first + b];
            for (int i = 0; i < block->count; i++) {
                jacobian_term term = j->terms[block->first + i];
                size_t columns = term.x >= 0 ? (size_t)block->columns : 1;
                size_t first = block->offset + (size_t)term.first * columns;
                for (size_t k = first; k < first + (size_t)term.rows * columns; k++) {
                    used[k * (size_t)j->row_count + (size_t)r] = true;
                }
            }
        }
    }
}

static void add_plain(normal_layout *l, const bool *plain, const bool *used)
{
    size_t rows = (size_t)l->rows, count = 0;
    for (size_t column = 0; column <= l->parameters; column++) {
        bool any = false;
        for (size_t r = 0; plain[column] && r < rows; r++) {
            any = any || used[column * rows + r];
        }
        if (any) { /* a column of zeros has no products */
            size_t panel = count / PANEL;
            l->columns[count++] = column;
            for (size_t r = 0; r < rows; r++) {
                l->live[panel * rows + r] |= used[column * rows + r];
            }
        }
    }
    l->plain_panels = panels_of((int)count);
    for (; count < (size_t)l->plain_panels * PANEL; count++) {
        l->columns[count] = NO_COLUMN;
    }
}

/* ---- groups ---------------------------------------------------------------------------------- */

/* Cut panels into groups as equal as can be. */
static void add_groups(normal_layout *l, int head, int panels)
{
    int pieces = (panels + NORMAL_GROUP - 1) / NORMAL_GROUP;
    for (int i = 0; i < pieces; i++) {
        int first = i * panels / pieces, end = (i + 1) * panels / pieces;
        l->groups[l->group_count++] = (normal_group){head, first, end - first};
    }
}

static ad_status allocate(const jacobian *j, normal_layout *l)
{
    size_t n = l->parameters + 1, rows = (size_t)l->rows, terms = (size_t)j->term_count + 1;
    size_t weights = 0;
    for (size_t i = 0; i + 1 < terms; i++) {
        weights += (size_t)j->terms[i].rows;
    }
    AD_TAKE(l, sources, terms);
    AD_TAKE(l, weights, weights + 1);
    AD_TAKE(l, heads, n);
    AD_TAKE(l, groups, 2 * n);
    AD_TAKE(l, columns, n + PANEL);
    AD_TAKE(l, live, (n / PANEL + 1) * rows);
    return l->memory.is_short ? AD_NO_MEMORY : AD_OK;
}

static ad_status make(const jacobian *j, size_t parameters, bool heads, normal_layout *l)
{
    size_t rows = (size_t)j->row_count;
    *l = (normal_layout){.rows = j->row_count, .parameters = parameters};
    bool *used = calloc(parameters + 1, rows * sizeof *used);
    bool *plain = malloc((parameters + 1) * sizeof *plain);
    ad_status status = used && plain ? allocate(j, l) : AD_NO_MEMORY;
    if (status == AD_OK) {
        mark(j, used);
        memset(used + parameters * rows, true, rows * sizeof *used);
        memset(plain, true, (parameters + 1) * sizeof *plain);
        if (heads) {
            add_heads(l, j, plain);
        }
        add_plain(l, plain, used);
        for (int i = 0; i < l->head_count; i++) {
            add_groups(l, i, panels_of(l->heads[i].width));
        }
        add_groups(l, -1, l->plain_panels);
    }
    free(used);
    free(plain);
    return status;
}

void ad_normal_layout_clear(normal_layout *l)
{
    ad_memory_free(&l->memory);
    *l = (normal_layout){0};
}

/* ---- products -------------------------------------------------------------------------------- */

bool ad_normal_is_live(const normal_layout *l, normal_group group, int residual)
{
    bool live = false;
    if (group.head >= 0) {
        const normal_head *head = &l->heads[group.head];
        for (int i = head->weight; i < head->weight + head->weights; i++) {
            live = live || l->weights[i].residual == residual;
        }
        return live;
    }
    for (int p = group.panel; p < group.panel + group.panels; p++) {
        live = live || l->live[p * l->rows + residual];
    }
    return live;
}

int ad_normal_common(const normal_layout *l, const normal_head *head, normal_group other,
                     int *sources)
{
    int count = 0;
    for (int i = head->weight; i < head->weight + head->weights; i++) {
        bool known = false;
        for (int k = 0; k < count; k++) {
            known = known || sources[k] == l->weights[i].source;
        }
        if (!known && ad_normal_is_live(l, other, l->weights[i].residual)) {
            sources[count++] = l->weights[i].source;
        }
    }
    return count;
}

/* Tiles of the block of two plain groups, each counted in every residual in which it is not 0. */
static size_t plain_products(const normal_layout *l, normal_group a, normal_group b)
{
    size_t count = 0;
    for (int p = a.panel; p < a.panel + a.panels; p++) {
        for (int q = a.panel == b.panel ? p : b.panel; q < b.panel + b.panels; q++) {
            for (int r = 0; r < l->rows; r++) {
                count += l->live[p * l->rows + r] && l->live[q * l->rows + r];
            }
        }
    }
    return count;
}

static size_t products(const normal_layout *l, normal_group a, normal_group b, int *sources)
{
    if (a.head < 0) {
        return plain_products(l, a, b);
    }
    bool same = a.head == b.head && a.panel == b.panel;
    int tiles = same ? a.panels * (a.panels + 1) / 2 : a.panels * b.panels;
    int count = ad_normal_common(l, &l->heads[a.head], b, sources);
    if (b.head >= 0) {
        int other = ad_normal_common(l, &l->heads[b.head], a, sources);
        count = other < count ? other : count;
    }
    return (size_t)tiles * (size_t)count;
}

static size_t products_of_all(const normal_layout *l, int *sources)
{
    size_t count = 0;
    for (int a = 0; a < l->group_count; a++) {
        for (int b = a; b < l->group_count; b++) {
            count += products(l, l->groups[a], l->groups[b], sources);
        }
    }
    return count;
}

size_t ad_normal_flops(const normal_layout *l)
{
    return (size_t)2 * TILE * l->products;
}

/* What heads save must be worth making their combinations. */
static const double WORTH = 0.8;

ad_status ad_normal_layout(const jacobian *j, size_t parameters, normal_layout *result)
{
    normal_layout plain;
    ad_status status = make(j, parameters, false, &plain);
    *result = (normal_layout){0};
    if (status == AD_OK) {
        status = make(j, parameters, true, result);
    }
    int *sources = malloc(((size_t)j->term_count + 1) * sizeof *sources);
    if (status != AD_OK || !sources) {
        free(sources);
        ad_normal_layout_clear(&plain);
        ad_normal_layout_clear(result);
        return AD_NO_MEMORY;
    }
    plain.products = products_of_all(&plain, sources);
    result->products = products_of_all(result, sources);
    free(sources);
    if ((double)result->products > WORTH * (double)plain.products) {
        normal_layout chosen = plain;
        plain = *result;
        *result = chosen;
    }
    ad_normal_layout_clear(&plain);
    return AD_OK;
}
