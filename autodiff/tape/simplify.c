/* The algebra that makes what a scene does not need disappear while it is recorded.
 *
 * Zero is structural: 0 * x is 0 whatever x turns out to be. Constant factors move outwards, so
 * that they meet and merge; blocks of a few rows that are made of parts are worked on row by row,
 * so that the zeros inside a vector fold like scalars do. */
#include "autodiff/tape/tape.h"

#include <math.h>
#include <stdlib.h>

enum { SCALARIZE_ROWS_MAX = 16, SCALARIZE_ALL_ROWS = 4 };

static ad_value widen(ad_value x, int rows)
{
    return ad_rows(x) == rows ? x : ad_repeat(x, rows);
}

static bool same(ad_value a, ad_value b)
{
    return a.id == b.id;
}

static bool is_zero(ad_value x)
{
    return ad_is_constant(x, 0);
}

/* x = factor * rest with a constant scalar factor. */
static bool is_scaled(ad_value x, ad_value *factor, ad_value *rest)
{
    if (node_of(x)->op != OP_MUL) {
        return false;
    }
    *factor = argument_of(x, 0);
    *rest = argument_of(x, 1);
    return is_constant(*factor) && ad_rows(*factor) == 1;
}

static bool is_negated(ad_value x, ad_value *rest)
{
    ad_value factor;
    return is_scaled(x, &factor, rest) && ad_is_constant(factor, -1) &&
           ad_rows(*rest) == ad_rows(x);
}

/* ---- constants ----------------------------------------------------------------------------- */

static bool fold_constants(ad_tape *tape, const node *n, const ad_value *x, ad_value *result)
{
    for (int i = 0; i < n->count; i++) {
        if (!is_constant(x[i])) {
            return false;
        }
    }
    double small[SCALARIZE_ROWS_MAX] = {0};
    double *values =
        n->rows <= SCALARIZE_ROWS_MAX ? small : malloc((size_t)n->rows * sizeof *values);
    if (!values) {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory for a constant of %d rows", n->rows);
        *result = ad_tape_failed(tape);
        return true;
    }
    for (int row = 0; row < n->rows; row++) {
        double arguments[AD_ARITY_MAX];
        for (int i = 0; i < n->count; i++) {
            arguments[i] = ad_constant_row(x[i], ad_rows(x[i]) == 1 ? 0 : row);
        }
        values[row] = ad_op_evaluate(n->op, n->whole, n->number, arguments);
    }
    *result = ad_constant(tape, n->rows, values);
    if (values != small) {
        free(values);
    }
    return true;
}

/* Whether rows of it may fold what is done with them away: a known part, of a constant 0 or 1. */
static bool has_known_part(ad_value x)
{
    const node *n = node_of(x);
    bool known = false;
    for (int i = 0; n->op == OP_STACK && i < n->count; i++) {
        known = known || is_constant(argument_of(x, i));
    }
    for (int i = 0; is_constant(x) && !n->splat && i < n->rows; i++) {
        double entry = ad_constant_row(x, i);
        known = known || n->rows <= SCALARIZE_ALL_ROWS || entry == 0 || fabs(entry) == 1;
    }
    return known;
}

/* A vector made of parts: apply the operation to each row. Rows of what is longer than vectors and
 * quaternions, and unknown throughout, as what many places along a rod have, stay together. */
static bool scalarize(ad_tape *tape, const node *n, const ad_value *x, ad_value *result)
{
    bool parts = false;
    for (int i = 0; i < n->count; i++) {
        parts = parts || (node_of(x[i])->op == OP_STACK && n->rows <= SCALARIZE_ALL_ROWS) ||
                has_known_part(x[i]);
    }
    if (!parts || n->rows < 2 || n->rows > SCALARIZE_ROWS_MAX) {
        return false;
    }
    ad_value rows[SCALARIZE_ROWS_MAX];
    int op = n->op, count = n->count, whole = n->whole, height = n->rows;
    double number = n->number;
    for (int row = 0; row < height; row++) {
        ad_value arguments[AD_ARITY_MAX];
        for (int i = 0; i < count; i++) {
            arguments[i] = ad_rows(x[i]) == 1 ? x[i] : ad_row(x[i], row);
        }
        rows[row] = ad_tape_record(tape, op, count, arguments, whole, number, 0);
    }
    *result = ad_stack(height, rows);
    return true;
}

/* ---- elementwise rules --------------------------------------------------------------------- */

static bool simplify_add(const node *n, ad_value a, ad_value b, ad_value *result)
{
    ad_value rest;
    if (is_zero(a)) {
        *result = widen(b, n->rows);
    } else if (is_zero(b)) {
        *result = widen(a, n->rows);
    } else if (same(a, b)) {
        *result = ad_scale(a, 2);
    } else if (is_negated(b, &rest)) {
        *result = ad_sub(a, rest);
    } else if (is_negated(a, &rest)) {
        *result = ad_sub(b, rest);
    } else if (a.id > b.id) { /* one order, so that equal sums are shared */
        *result = ad_add(b, a);
    } else {
        return false;
    }
    return true;
}

static bool simplify_sub(const node *n, ad_value a, ad_value b, ad_value *result)
{
    ad_value rest;
    if (is_zero(b)) {
        *result = widen(a, n->rows);
    } else if (is_zero(a)) {
        *result = widen(ad_neg(b), n->rows);
    } else if (same(a, b)) {
        *result = ad_zeros(a.tape, n->rows);
    } else if (is_negated(b, &rest)) {
        *result = ad_add(a, rest);
    } else {
        return false;
    }
    return true;
}

static bool simplify_mul(const node *n, ad_value a, ad_value b, ad_value *result)
{
    ad_value factor, rest;
    if (is_zero(a) || is_zero(b)) {
        *result = ad_zeros(a.tape, n->rows);
    } else if (ad_is_constant(a, 1)) {
        *result = widen(b, n->rows);
    } else if (ad_is_constant(b, 1)) {
        *result = widen(a, n->rows);
    } else if (is_constant(b) && !is_constant(a)) { /* constants first */
        *result = ad_mul(b, a);
    } else if (is_constant(a) && node_of(a)->splat && ad_rows(a) > 1) {
        *result = widen(ad_scale(b, node_of(a)->number), n->rows);
    } else if (is_constant(a) && is_scaled(b, &factor, &rest)) {
        *result = ad_mul(ad_mul(a, factor), rest);
    } else if (ad_is_constant(a, -1) && node_of(b)->op == OP_SUB) {
        *result = ad_sub(argument_of(b, 1), argument_of(b, 0));
    } else if (is_constant(a)) {
        return false;
    } else if (is_scaled(a, &factor, &rest)) {
        *result = ad_mul(factor, ad_mul(rest, b));
    } else if (is_scaled(b, &factor, &rest)) {
        *result = ad_mul(factor, ad_mul(a, rest));
    } else if (a.id > b.id) {
        *result = ad_mul(b, a);
    } else {
        return false;
    }
    return true;
}

static bool simplify_power(const node *n, ad_value a, ad_value *result)
{
    if (n->number == 0) {
        *result = widen(ad_scalar(a.tape, 1), n->rows);
    } else if (n->number == 1) {
        *result = a;
    } else if (n->number == 2) {
        *result = ad_mul(a, a);
    } else if (n->number == -1) {
        *result = ad_reciprocal(a);
    } else {
        return false;
    }
    return true;
}

static bool simplify_select(const node *n, const ad_value *x, ad_value *result)
{
    if (same(x[1], x[2])) {
        *result = widen(x[1], n->rows);
        return true;
    }
    const node *condition = node_of(x[0]);
    if (is_constant(x[0]) && condition->splat) {
        *result = widen(condition->number > 0 ? x[1] : x[2], n->rows);
        return true;
    }
    return false;
}

static bool simplify_elementwise(ad_tape *tape, const node *n, const ad_value *x, ad_value *result)
{
    if (n->op == OP_REPEAT) {
        if (n->rows == 1) {
            *result = x[0];
            return true;
        }
        if (is_constant(x[0])) {
            node splat = {.op = OP_CONSTANT, .rows = n->rows, .splat = true};
            splat.number = ad_constant_row(x[0], 0);
            *result = ad_tape_append(tape, splat, NULL);
            return true;
        }
        return false;
    }
    if (fold_constants(tape, n, x, result)) {
        return true;
    }
    bool done = n->op == OP_ADD      ? simplify_add(n, x[0], x[1], result)
                : n->op == OP_SUB    ? simplify_sub(n, x[0], x[1], result)
                : n->op == OP_MUL    ? simplify_mul(n, x[0], x[1], result)
                : n->op == OP_POWER  ? simplify_power(n, x[0], result)
                : n->op == OP_SELECT ? simplify_select(n, x, result)
                                     : false;
    return done || scalarize(tape, n, x, result);
}

/* ---- rows ---------------------------------------------------------------------------------- */

static ad_value slice_constant(ad_value x, int first, int rows)
{
    if (node_of(x)->splat) {
        return widen(ad_scalar(x.tape, node_of(x)->number), rows);
    }
    double values[SCALARIZE_ROWS_MAX];
    if (rows > SCALARIZE_ROWS_MAX) {
        return ad_tape_failed(x.tape);
    }
    for (int i = 0; i < rows; i++) {
        values[i] = ad_constant_row(x, first + i);
    }
    return ad_constant(x.tape, rows, values);
}

static bool slice_stack(ad_value x, int first, int rows, ad_value *result)
{
    int parts = node_of(x)->count, row = 0;
    ad_value taken[SCALARIZE_ROWS_MAX];
    int count = 0;
    for (int i = 0; i < parts && row < first + rows; i++) {
        ad_value part = argument_of(x, i);
        int height = ad_rows(part);
        int from = first > row ? first - row : 0;
        int to = first + rows - row < height ? first + rows - row : height;
        if (from < to) {
            if (count == SCALARIZE_ROWS_MAX) {
                return false;
            }
            taken[count++] = ad_slice(part, from, to - from);
        }
        row += height;
    }
    *result = ad_stack(count, taken);
    return true;
}

static bool simplify_slice(const node *n, ad_value x, ad_value *result)
{
    int first = n->whole, rows = n->rows, whole = node_of(x)->whole;
    ad_value inner = node_of(x)->count ? argument_of(x, 0) : x;
    if (rows == ad_rows(x)) {
        *result = x;
        return true;
    }
    const int op = node_of(x)->op;
    if (op == OP_STACK) {
        return slice_stack(x, first, rows, result);
    }
    bool inside = first >= whole && first + rows <= whole + ad_rows(inner); /* of a padded value */
    bool outside = first + rows <= whole || first >= whole + ad_rows(inner);
    if (op == OP_CONSTANT && (node_of(x)->splat || rows <= SCALARIZE_ROWS_MAX)) {
        *result = slice_constant(x, first, rows);
    } else if (op == OP_SLICE) {
        *result = ad_slice(inner, whole + first, rows);
    } else if (op == OP_REPEAT) {
        *result = widen(inner, rows);
    } else if (op == OP_PAD && (inside || outside)) {
        *result = inside ? ad_slice(inner, first - whole, rows) : ad_zeros(x.tape, rows);
    } else {
        return false;
    }
    return true;
}

static bool stack_constants(ad_tape *tape, const node *n, const ad_value *x, ad_value *result)
{
    double values[SCALARIZE_ROWS_MAX];
    int row = 0;
    for (int i = 0; i < n->count; i++) {
        if (!is_constant(x[i]) || n->rows > SCALARIZE_ROWS_MAX) {
            return false;
        }
        for (int k = 0; k < ad_rows(x[i]); k++) {
            values[row++] = ad_constant_row(x[i], k);
        }
    }
    *result = ad_constant(tape, n->rows, values);
    return true;
}

static bool simplify_stack(ad_tape *tape, const node *n, const ad_value *x, ad_value *result)
{
    if (n->count == 1) {
        *result = x[0];
        return true;
    }
    bool zero = true, consecutive = node_of(x[0])->op == OP_SLICE;
    int parts = 0;
    for (int i = 0; i < n->count; i++) {
        const node *part = node_of(x[i]);
        zero = zero && is_zero(x[i]);
        parts += part->op == OP_STACK ? part->count : 1;
        if (i > 0 && consecutive) {
            const node *before = node_of(x[i - 1]);
            consecutive = part->op == OP_SLICE && part->whole == before->whole + before->rows &&
                          same(argument_of(x[i], 0), argument_of(x[0], 0));
        }
    }
    if (zero) {
        *result = ad_zeros(tape, n->rows);
        return true;
    }
    if (consecutive) {
        *result = ad_slice(argument_of(x[0], 0), node_of(x[0])->whole, n->rows);
        return true;
    }
    if (parts > n->count && parts <= SCALARIZE_ROWS_MAX) { /* stacks within: make it one */
        ad_value flat[SCALARIZE_ROWS_MAX];
        int k = 0;
        for (int i = 0; i < n->count; i++) {
            bool nested = node_of(x[i])->op == OP_STACK;
            int inner = nested ? node_of(x[i])->count : 1;
            for (int j = 0; j < inner; j++) {
                flat[k++] = nested ? argument_of(x[i], j) : x[i];
            }
        }
        *result = ad_stack(k, flat);
        return true;
    }
    return stack_constants(tape, n, x, result);
}

static bool simplify_sum_rows(ad_value x, ad_value *result)
{
    int rows = ad_rows(x);
    if (rows == 1) {
        *result = x;
    } else if (is_constant(x)) {
        double sum = 0;
        for (int i = 0; i < rows; i++) {
            sum += ad_constant_row(x, i);
        }
        *result = ad_scalar(x.tape, sum);
    } else if (node_of(x)->op == OP_REPEAT) {
        *result = ad_scale(argument_of(x, 0), rows);
    } else if (node_of(x)->op == OP_STACK) {
        int parts = node_of(x)->count;
        ad_value sum = ad_sum_rows(argument_of(x, 0));
        for (int i = 1; i < parts; i++) {
            sum = ad_add(sum, ad_sum_rows(argument_of(x, i)));
        }
        *result = sum;
    } else {
        return false;
    }
    return true;
}

/* ---- points and matrices ------------------------------------------------------------------- */

/* Is x the same for all that a sum runs over? */
static bool is_factor(ad_value x, sum_over over)
{
    return node_of(x)->extent == AD_UNIFORM || (over == OF_MEMBER && node_of(x)->op == OP_SPREAD);
}

/* A sum over points of values of members: so many times each. */
static bool is_counted(ad_value x, sum_over over)
{
    return node_of(x)->extent == AD_MEMBER && over != OVER_MEMBERS;
}

static bool simplify_sum_points(sum_over over, ad_value x, ad_value *result)
{
    const node *n = node_of(x);
    if (n->extent == AD_UNIFORM) {
        *result = is_zero(x)             ? x
                  : over == OVER_POINTS  ? ad_mul(ad_points(x.tape), x)
                  : over == OVER_MEMBERS ? ad_mul(ad_members(x.tape), x)
                                         : ad_mul(ad_points_of_member(x.tape), x);
        return true;
    }
    if (is_counted(x, over)) {
        *result = ad_mul(ad_points_of_member(x.tape),
                         over == OVER_POINTS ? ad_tape_sum(x, OVER_MEMBERS) : x);
        return true;
    }
    if (n->op == OP_OUTER) {
        *result = ad_tape_outer_sum(argument_of(x, 0), argument_of(x, 1), over);
        return true;
    }
    if (n->op == OP_ADD && over == OF_MEMBER) { /* adjoints of a matrix of each member */
        ad_value a = argument_of(x, 0), b = argument_of(x, 1);
        if (node_of(a)->op == OP_OUTER || node_of(b)->op == OP_OUTER) {
            *result = ad_add(ad_tape_sum(a, over), ad_tape_sum(b, over));
            return true;
        }
    }
    if (n->op == OP_MUL) {
        ad_value a = argument_of(x, 0), b = argument_of(x, 1);
        if (is_factor(a, over) || is_factor(b, over)) {
            bool first = is_factor(a, over);
            *result = ad_mul(first ? a : b, ad_tape_sum(first ? b : a, over));
            return true;
        }
    }
    return false;
}

static bool simplify_outer(const node *n, ad_value y, ad_value x, ad_value *result)
{
    bool sum = n->op == OP_OUTER_SUM;
    sum_over over = (sum_over)n->whole;
    if (is_zero(y) || is_zero(x)) {
        *result = ad_zeros(y.tape, n->rows);
        return true;
    }
    if (sum && (is_factor(y, over) || is_factor(x, over))) {
        *result = is_factor(y, over) ? tape_record2(OP_OUTER, y, ad_tape_sum(x, over))
                                     : tape_record2(OP_OUTER, ad_tape_sum(y, over), x);
        return true;
    }
    if (sum && is_counted(y, over)) {
        *result = ad_mul(ad_points_of_member(y.tape), over == OVER_POINTS
                                                          ? ad_tape_outer_sum(y, x, OVER_MEMBERS)
                                                          : tape_record2(OP_OUTER, y, x));
        return true;
    }
    if (ad_rows(y) == 1 || ad_rows(x) == 1) {
        ad_value product = ad_mul(y, x);
        *result = sum ? ad_tape_sum(product, over) : product;
        return true;
    }
    return false;
}

static bool simplify_matvec(const node *n, ad_value w, ad_value x, ad_value *result)
{
    if (is_zero(w) || is_zero(x)) {
        *result = ad_zeros(w.tape, n->rows);
        return true;
    }
    if (ad_rows(x) == 1) {
        *result = ad_mul(w, x);
        return true;
    }
    return false;
}

bool ad_simplify(ad_tape *tape, const node *n, const ad_value *x, ad_value *result)
{
    if (op_is_elementwise(n->op)) {
        return simplify_elementwise(tape, n, x, result);
    }
    switch (ad_op_table[n->op].form) {
    case FORM_SLICE:
        return simplify_slice(n, x[0], result);
    case FORM_JOIN:
        if (n->op == OP_STACK) {
            return simplify_stack(tape, n, x, result);
        }
        if (ad_rows(x[0]) == n->rows || is_zero(x[0])) {
            *result = widen(is_zero(x[0]) ? ad_zeros(tape, n->rows) : x[0], n->rows);
            return true;
        }
        return false;
    case FORM_SUM_ROWS:
        return simplify_sum_rows(x[0], result);
    case FORM_SUM_POINTS:
        return simplify_sum_points((sum_over)n->whole, x[0], result);
    case FORM_OUTER:
    case FORM_OUTER_SUM:
        return simplify_outer(n, x[0], x[1], result);
    case FORM_PRODUCT:
        return simplify_matvec(n, x[0], x[1], result);
    default:
        return false;
    }
}
