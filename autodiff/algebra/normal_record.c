/* The rows of a Jacobian on the tape. The adjoint of a matrix of parameters is a sum of outer
 * products, one per Taylor coefficient that met the matrix. Their factors become outputs, not the
 * products: a tile then holds the network's width per residual, not its number of parameters. */
#include "autodiff/algebra/normal.h"

#include <stdlib.h>

/* Room for one more item; NULL when memory runs out. */
static void *grow(void *items, int count, int *capacity, size_t size)
{
    if (count < *capacity) {
        return items;
    }
    int wanted = *capacity ? 2 * *capacity : 64;
    void *more = realloc(items, (size_t)wanted * size);
    if (more) {
        *capacity = wanted;
    }
    return more;
}

#define GROW(j, item)                                                                              \
    (grown = grow((j)->item##s, (j)->item##_count, &(j)->item##_capacity, sizeof *(j)->item##s))

static bool add_term(jacobian *j, jacobian_term term)
{
    void *grown;
    if (!GROW(j, term)) {
        return false;
    }
    j->terms = grown;
    j->terms[j->term_count++] = term;
    return true;
}

/* The number of an output, -1 when memory runs out. */
static int output_of(jacobian *j, ad_value value)
{
    void *grown;
    for (int i = 0; i < j->output_count; i++) {
        if (j->outputs[i].id == value.id) {
            return i;
        }
    }
    if (!GROW(j, output)) {
        return -1;
    }
    j->outputs = grown;
    j->outputs[j->output_count] = value;
    return j->output_count++;
}

/* A term for every range of rows of y that are not 0; false: out of memory. x may be none. */
static bool add_ranges(jacobian *j, ad_value y, const ad_value *x)
{
    jacobian_term term = {output_of(j, y), x ? output_of(j, *x) : -1, 0, 0};
    bool ok = term.y >= 0 && (!x || term.x >= 0);
    for (int row = 0; ok && row < ad_rows(y); row++) {
        bool zero = ad_is_constant(ad_row(y, row), 0);
        bool last = row + 1 == ad_rows(y);
        term.rows += !zero;
        if (term.rows > 0 && (zero || last)) {
            ok = add_term(j, term);
            term.rows = 0;
        }
        term.first = term.rows > 0 ? term.first : row + 1;
    }
    return ok;
}

static bool add_terms(jacobian *j, ad_value adjoint)
{
    if (ad_is_constant(adjoint, 0)) {
        return true;
    }
    if (node_of(adjoint)->op == OP_ADD && ad_rows(argument_of(adjoint, 0)) == ad_rows(adjoint) &&
        ad_rows(argument_of(adjoint, 1)) == ad_rows(adjoint)) {
        return add_terms(j, argument_of(adjoint, 0)) && add_terms(j, argument_of(adjoint, 1));
    }
    if (node_of(adjoint)->op != OP_OUTER) {
        return add_ranges(j, adjoint, NULL);
    }
    ad_value y = argument_of(adjoint, 0), x = argument_of(adjoint, 1);
    return add_ranges(j, y, &x);
}

/* A block [m][k] with outer products has the shape of their factors, another is a column. */
static bool add_block(jacobian *j, ad_value wrt, ad_value adjoint)
{
    void *grown;
    if (!GROW(j, block)) {
        return false;
    }
    j->blocks = grown;
    jacobian_block *block = &j->blocks[j->block_count++];
    *block = (jacobian_block){node_of(wrt)->offset, ad_rows(wrt), 1, j->term_count, 0};
    if (!add_terms(j, adjoint)) {
        return false;
    }
    block->count = j->term_count - block->first;
    for (int i = block->first; i < j->term_count; i++) {
        if (j->terms[i].x >= 0) {
            block->columns = ad_rows(j->outputs[j->terms[i].x]);
            block->rows = ad_rows(wrt) / block->columns;
        }
    }
    return true;
}

static ad_status add_row(jacobian *j, ad_value residual, int wrt_count, const ad_value *wrt,
                         ad_value *adjoints)
{
    void *grown;
    if (ad_is_constant(residual, 0)) {
        return AD_OK;
    }
    ad_status status = ad_reverse(residual, wrt_count, wrt, AD_PER_POINT, adjoints);
    if (status != AD_OK) {
        return status;
    }
    if (!GROW(j, row)) {
        return AD_NO_MEMORY;
    }
    j->rows = grown;
    jacobian_row *row = &j->rows[j->row_count++];
    *row = (jacobian_row){output_of(j, residual), j->block_count, wrt_count};
    bool ok = row->residual >= 0;
    for (int i = 0; ok && i < wrt_count; i++) {
        ok = add_block(j, wrt[i], adjoints[i]);
    }
    return ok ? AD_OK : AD_NO_MEMORY;
}

ad_status ad_jacobian_record(jacobian *j, int count, const ad_value *residuals, int wrt_count,
                             const ad_value *wrt)
{
    ad_value *adjoints = malloc(((size_t)wrt_count + 1) * sizeof *adjoints);
    ad_status status = adjoints ? AD_OK : AD_NO_MEMORY;
    for (int i = 0; i < count; i++) {
        for (int row = 0; status == AD_OK && row < ad_rows(residuals[i]); row++) {
            status = add_row(j, ad_row(residuals[i], row), wrt_count, wrt, adjoints);
        }
    }
    free(adjoints);
    return status;
}

void ad_jacobian_clear(jacobian *j)
{
    free(j->rows);
    free(j->blocks);
    free(j->terms);
    free(j->outputs);
    *j = (jacobian){0};
}
