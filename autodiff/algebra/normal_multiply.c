/* Blocks of J^T J as products of panels. For heads a and b
 *
 *     sum_r J_ra^T J_rb = sum_d X_d^T (sum_e diag(sum_r c_rad c_rbe) X_e)
 *
 * over their bases d and e, where c_rad, per point, is the coefficient of X_d in residual r. The
 * head with fewer bases stands on the left. Of a head and plain columns the head does:
 *
 *     sum_r J_ra^T J_rb = sum_d X_d^T (sum_r diag(c_rad) J_rb)
 *
 * Points are taken NORMAL_DEPTH at a time, in order, whoever does it. */
#include "autodiff/algebra/normal.h"

#include <string.h>

typedef struct block {
    const normal_layout *l;
    const kernel_set *kernels;
    const normal_slab *slab;
    normal_space *space;
    normal_group a, b;
    size_t first, depth; /* points at hand */
    double *jtj, *jtr, *rtr;
} block;

static bool diagonal(const block *k)
{
    return k->a.head == k->b.head && k->a.panel == k->b.panel;
}

/* ---- where things are ------------------------------------------------------------------------ */

static const double *basis(const block *k, int source, int panel)
{
    size_t at = (size_t)(k->l->sources[source].panel + panel) * k->slab->room + k->first;
    return k->slab->basis + at * PANEL;
}

static const double *plain(const block *k, int panel, int residual)
{
    size_t at = (size_t)(panel * k->l->rows + residual) * k->slab->room + k->first;
    return k->slab->plain + at * PANEL;
}

static const double *coefficient(const block *k, int weight)
{
    return k->slab->weights + (size_t)weight * k->slab->room + k->first;
}

static double *combined(const block *k, int panel)
{
    return k->space->panels + (size_t)panel * NORMAL_DEPTH * PANEL;
}

static double *tile(const block *k, int p, int q)
{
    return k->space->tiles + (size_t)(p * NORMAL_GROUP + q) * TILE;
}

/* ---- combinations ---------------------------------------------------------------------------- */

/* by[] = sum over residuals of the coefficients of one basis of a head and one of another; false:
 * they do not meet. */
static bool multiply_coefficients(const block *k, const normal_head *head, int source,
                                  const normal_head *other, int with, double *by)
{
    const normal_weight *weights = k->l->weights;
    bool any = false;
    for (int i = head->weight; i < head->weight + head->weights; i++) {
        for (int j = other->weight; j < other->weight + other->weights; j++) {
            if (weights[i].source != source || weights[j].source != with ||
                weights[i].residual != weights[j].residual) {
                continue;
            }
            const double *x = coefficient(k, i), *y = coefficient(k, j);
            for (size_t p = 0; p < k->depth; p++) {
                by[p] = (any ? by[p] : 0) + x[p] * y[p];
            }
            any = true;
        }
    }
    return any;
}

/* What stands beside one basis of `head` in a block with `other`, a group of a head. */
static void combine_head(const block *k, const normal_head *head, int source, normal_group other,
                         const int *with, int with_count)
{
    normal_space *space = k->space;
    int count = 0;
    for (int i = 0; i < with_count; i++) {
        double *by = space->by + (size_t)count * NORMAL_DEPTH;
        if (multiply_coefficients(k, head, source, &k->l->heads[other.head], with[i], by)) {
            space->factors[count] = by;
            space->used[count++] = with[i];
        }
    }
    for (int p = 0; p < other.panels; p++) {
        for (int i = 0; i < count; i++) {
            space->terms[i] = basis(k, space->used[i], other.panel + p);
        }
        k->kernels->products->combine_panels(count, k->depth, space->factors, space->terms,
                                             combined(k, p));
    }
}

/* The same where `other` is plain. */
static void combine_plain(const block *k, const normal_head *head, int source, normal_group other)
{
    const normal_layout *l = k->l;
    for (int p = 0; p < other.panels; p++) {
        int count = 0, panel = other.panel + p;
        for (int i = head->weight; i < head->weight + head->weights; i++) {
            int r = l->weights[i].residual;
            if (l->weights[i].source == source && l->live[panel * l->rows + r]) {
                k->space->factors[count] = coefficient(k, i);
                k->space->terms[count++] = plain(k, panel, r);
            }
        }
        k->kernels->products->combine_panels(count, k->depth, k->space->factors, k->space->terms,
                                             combined(k, p));
    }
}

/* ---- products -------------------------------------------------------------------------------- */

static void multiply_tile(const block *k, const double *a, const double *b, int p, int q)
{
    k->kernels->products->multiply_panels(k->depth, a, b, false, tile(k, p, q));
}

/* One basis of the head on the left, combinations on the right; or the other way round. */
static void multiply_combined(const block *k, int source, bool left)
{
    for (int q = 0; q < k->b.panels; q++) {
        for (int p = 0; p < (diagonal(k) ? q + 1 : k->a.panels); p++) {
            const double *a = left ? basis(k, source, k->a.panel + p) : combined(k, p);
            const double *b = left ? combined(k, q) : basis(k, source, k->b.panel + q);
            multiply_tile(k, a, b, p, q);
        }
    }
}

static void multiply_head(const block *k)
{
    const normal_layout *l = k->l;
    const normal_head *a = &l->heads[k->a.head];
    const normal_head *b = k->b.head >= 0 ? &l->heads[k->b.head] : NULL;
    int *of_a = k->space->sources[0], *of_b = k->space->sources[1];
    int count_a = ad_normal_common(l, a, k->b, of_a);
    int count_b = b ? ad_normal_common(l, b, k->a, of_b) : 0;
    bool left = !b || count_a <= count_b;
    for (int i = 0; i < (left ? count_a : count_b); i++) {
        if (!b) {
            combine_plain(k, a, of_a[i], k->b);
        } else if (left) {
            combine_head(k, a, of_a[i], k->b, of_b, count_b);
        } else {
            combine_head(k, b, of_b[i], k->a, of_a, count_a);
        }
        multiply_combined(k, left ? of_a[i] : of_b[i], left);
    }
}

static void multiply_plain(const block *k)
{
    const normal_layout *l = k->l;
    for (int r = 0; r < l->rows; r++) {
        for (int q = 0; q < k->b.panels; q++) {
            int with = k->b.panel + q;
            for (int p = 0; p < (diagonal(k) ? q + 1 : k->a.panels); p++) {
                int panel = k->a.panel + p;
                if (l->live[panel * l->rows + r] && l->live[with * l->rows + r]) {
                    multiply_tile(k, plain(k, panel, r), plain(k, with, r), p, q);
                }
            }
        }
    }
}

/* ---- into J^T J ------------------------------------------------------------------------------ */

static void list_columns(const normal_layout *l, normal_group group, int panel, size_t *columns)
{
    for (int i = 0; i < PANEL; i++) {
        int at = (group.panel + panel) * PANEL + i;
        if (group.head < 0) {
            columns[i] = l->columns[at];
        } else {
            const normal_head *head = &l->heads[group.head];
            columns[i] = at < head->width ? head->column + (size_t)at : NO_COLUMN;
        }
    }
}

static void add_number(const block *k, size_t a, size_t b, double number)
{
    size_t n = k->l->parameters, row = a < b ? a : b, column = a < b ? b : a;
    if (column < n) {
        k->jtj[row * n + column] += number;
    } else if (row < n) {
        k->jtr[row] += number;
    } else {
        *k->rtr += number;
    }
}

static void add_tile(const block *k, int p, int q)
{
    size_t rows[PANEL], columns[PANEL];
    const double *from = tile(k, p, q);
    bool same = diagonal(k) && p == q;
    list_columns(k->l, k->a, p, rows);
    list_columns(k->l, k->b, q, columns);
    for (int i = 0; i < PANEL && rows[i] != NO_COLUMN; i++) {
        for (int j = same ? i : 0; j < PANEL && columns[j] != NO_COLUMN; j++) {
            add_number(k, rows[i], columns[j], from[i * PANEL + j]);
        }
    }
}

static bool any_product(const normal_layout *l, normal_group a, normal_group b)
{
    bool any = false;
    for (int r = 0; r < l->rows; r++) {
        any = any || (ad_normal_is_live(l, a, r) && ad_normal_is_live(l, b, r));
    }
    return any;
}

void ad_normal_multiply(const normal_layout *l, const kernel_set *kernels, const normal_slab *slab,
                        normal_group a, normal_group b, normal_space *space, double *jtj,
                        double *jtr, double *rtr)
{
    block k = {l, kernels, slab, space, a, b, 0, 0, jtj, jtr, rtr};
    if (!any_product(l, a, b)) {
        return;
    }
    memset(space->tiles, 0, (size_t)a.panels * NORMAL_GROUP * TILE * sizeof *space->tiles);
    for (; k.first < slab->points; k.first += NORMAL_DEPTH) {
        size_t left = slab->points - k.first;
        k.depth = left < NORMAL_DEPTH ? left : NORMAL_DEPTH;
        a.head >= 0 ? multiply_head(&k) : multiply_plain(&k);
    }
    for (int p = 0; p < a.panels; p++) {
        for (int q = diagonal(&k) ? p : 0; q < b.panels; q++) {
            add_tile(&k, p, q);
        }
    }
}
