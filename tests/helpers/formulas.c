#include "formulas.h"

#include <stdlib.h>
#include <string.h>

static uint64_t formula_hash(const formula *formula)
{
    uint64_t number;
    memcpy(&number, &formula->number, sizeof number);
    uint64_t hash =
        ad_hash_mix(ad_hash_mix((uint64_t)formula->op, (uint64_t)formula->whole), number);
    hash = ad_hash_mix(ad_hash_mix(hash, (uint64_t)formula->a), (uint64_t)formula->b);
    return ad_hash_mix(hash, (uint64_t)formula->c);
}

static bool formula_equal(const formula *x, const formula *y)
{
    return x->op == y->op && x->whole == y->whole && x->a == y->a && x->b == y->b && x->c == y->c &&
           memcmp(&x->number, &y->number, sizeof x->number) == 0;
}

static bool enlarge_table(formulas *f)
{
    int capacity = f->table_capacity ? 2 * f->table_capacity : 4096;
    int *table = calloc((size_t)capacity, sizeof *table);
    if (!table) {
        return false;
    }
    for (int i = 1; i < f->count; i++) {
        uint64_t slot = formula_hash(&f->items[i]);
        while (table[slot & (uint64_t)(capacity - 1)]) {
            slot++;
        }
        table[slot & (uint64_t)(capacity - 1)] = i;
    }
    free(f->table);
    f->table = table;
    f->table_capacity = capacity;
    return true;
}

int ad_formulas_find(const formulas *f, formula wanted)
{
    uint64_t mask = (uint64_t)(f->table_capacity - 1), slot = formula_hash(&wanted) & mask;
    for (; f->table[slot]; slot = (slot + 1) & mask) {
        if (formula_equal(&wanted, &f->items[f->table[slot]])) {
            return f->table[slot];
        }
    }
    return 0;
}

/* The same, made where it is new; 0: out of memory. */
static int make(formulas *f, formula wanted)
{
    if ((2 * (f->count + 2) > f->table_capacity && !enlarge_table(f)) ||
        !ad_tape_grow((void **)&f->items, &f->capacity, f->count + 2, sizeof wanted)) {
        f->failed = true;
        return 0;
    }
    int known = ad_formulas_find(f, wanted);
    if (known) {
        return known;
    }
    uint64_t mask = (uint64_t)(f->table_capacity - 1), slot = formula_hash(&wanted) & mask;
    while (f->table[slot]) {
        slot = (slot + 1) & mask;
    }
    f->count = f->count ? f->count : 1;
    f->items[f->count] = wanted;
    f->table[slot] = f->count;
    return f->count++;
}

/* ---- the rows of the tape ------------------------------------------------------------------- */

static int argument(const formulas *f, const node *n, int i)
{
    return f->tape->arguments[n->first + i];
}

static const node *argument_node(const formulas *f, const node *n, int i)
{
    return &f->tape->nodes[argument(f, n, i)];
}

/* A row of a value that is the same at every point. */
static formula uniform_row(const formulas *f, int id, int row)
{
    const node *n = &f->tape->nodes[id];
    int first = id, within = row;
    for (; n->op == OP_SLICE; n = &f->tape->nodes[first]) {
        within += n->whole;
        first = argument(f, n, 0);
    }
    return n->op == OP_CONSTANT
               ? constant_of(ad_constant_row(value_of((ad_tape *)f->tape, first), within))
               : formula_at(f->places[id], row);
}

int ad_formulas_row(const formulas *f, int id, int row)
{
    const node *n = &f->tape->nodes[id];
    row = n->rows == 1 ? 0 : row;
    return n->extent != AD_UNIFORM ? f->rows[f->first[id] + row]
                                   : ad_formulas_find(f, uniform_row(f, id, row));
}

static int row_of(formulas *f, int id, int row)
{
    const node *n = &f->tape->nodes[id];
    return n->extent != AD_UNIFORM ? ad_formulas_row(f, id, row)
                                   : make(f, uniform_row(f, id, n->rows == 1 ? 0 : row));
}

/* All rows of a value as one formula: matrices of parameters by where they lie. */
static int all_rows(formulas *f, int id)
{
    const node *n = &f->tape->nodes[id];
    if (n->extent == AD_UNIFORM) {
        return make(f, block_at(f->places[id]));
    }
    int list = 0;
    for (int row = 0; row < n->rows; row++) {
        list = make(f, (formula){.op = LIST, .a = list, .b = row_of(f, id, row)});
    }
    return list;
}

static int join_row(formulas *f, const node *n, int row)
{
    int before = n->op == OP_PAD ? n->whole : 0;
    for (int i = 0; i < n->count; i++) {
        int rows = argument_node(f, n, i)->rows;
        if (row >= before && row < before + rows) {
            return row_of(f, argument(f, n, i), row - before);
        }
        before += rows;
    }
    return make(f, constant_of(0)); /* padding */
}

static int sum_of_rows(formulas *f, int id)
{
    int sum = row_of(f, id, 0);
    for (int row = 1; row < f->tape->nodes[id].rows; row++) {
        sum = make(f, sum_of(sum, row_of(f, id, row)));
    }
    return sum;
}

/* w, x: of a product with a matrix, all their rows. */
static int make_row(formulas *f, const node *n, int row, int w, int x)
{
    int rows[AD_ARITY_MAX] = {0};
    switch (ad_op_table[n->op].form) {
    case FORM_LEAF: /* an input */
        return make(f, (formula){.op = n->op, .whole = n->whole, .a = row});
    case FORM_SLICE:
        return row_of(f, argument(f, n, 0), n->whole + row);
    case FORM_JOIN:
        return join_row(f, n, row);
    case FORM_SUM_ROWS:
        return sum_of_rows(f, argument(f, n, 0));
    case FORM_PRODUCT:
        return make(f, (formula){.op = n->op, .a = w, .b = x, .c = row});
    case FORM_SPREAD:
        return make(f, (formula){.op = n->op, .a = row_of(f, argument(f, n, 0), row)});
    case FORM_SUM_POINTS:
        return make(f, member_sum_of(n->op, row_of(f, argument(f, n, 0), row), 0));
    case FORM_OUTER_SUM:
    case FORM_OUTER: {
        int width = argument_node(f, n, 1)->rows;
        int y = row_of(f, argument(f, n, 0), row / width);
        int x = row_of(f, argument(f, n, 1), row % width);
        return make(f, n->op == OP_OUTER ? product_of(y, x) : member_sum_of(n->op, y, x));
    }
    default:
        if (n->op == OP_REPEAT) {
            return row_of(f, argument(f, n, 0), 0);
        }
        for (int i = 0; i < n->count; i++) {
            rows[i] = row_of(f, argument(f, n, i), row);
        }
        return make(f, operation_of(n->op, n->whole, n->number, rows));
    }
}

static bool number_rows(formulas *f)
{
    for (int id = 0; !f->failed && id < f->tape->count; id++) {
        const node *n = &f->tape->nodes[id];
        if (!f->needed[id] || n->extent == AD_UNIFORM) {
            continue;
        }
        bool product = op_is_matvec(n->op);
        int w = product ? all_rows(f, argument(f, n, 0)) : 0;
        int x = product ? all_rows(f, argument(f, n, 1)) : 0;
        for (int row = 0; row < n->rows; row++) {
            f->rows[f->first[id] + row] = make_row(f, n, row, w, x);
        }
    }
    return !f->failed;
}

static void mark_needed(formulas *f, const ad_program *program)
{
    for (int i = 0; i < program->outputs; i++) {
        f->needed[program->output_ids[i]] = true;
    }
    for (int id = f->tape->count - 1; id >= 0; id--) {
        const node *n = &f->tape->nodes[id];
        for (int i = 0; f->needed[id] && i < n->count; i++) {
            f->needed[argument(f, n, i)] = true;
        }
    }
}

bool ad_formulas_create(const ad_program *program, formulas *result)
{
    formulas *f = result;
    *f = (formulas){.tape = program->tape, .places = program->places};
    size_t nodes = (size_t)f->tape->count + 1;
    int count = 0;
    f->needed = calloc(nodes, sizeof *f->needed);
    f->first = calloc(nodes, sizeof *f->first);
    if (!f->needed || !f->first || !enlarge_table(f)) {
        return false;
    }
    mark_needed(f, program);
    for (int id = 0; id < f->tape->count; id++) {
        f->first[id] = count;
        count +=
            f->needed[id] && f->tape->nodes[id].extent != AD_UNIFORM ? f->tape->nodes[id].rows : 0;
    }
    f->rows = calloc((size_t)count + 1, sizeof *f->rows);
    return f->rows && number_rows(f);
}

void ad_formulas_clear(formulas *f)
{
    free(f->items);
    free(f->table);
    free(f->needed);
    free(f->first);
    free(f->rows);
}
