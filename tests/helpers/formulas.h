/* What a program has to compute: a number for every row of every batch value of its tape, and of
 * those of members, by the formula that makes it; equal formulas have one number. */
#ifndef AD_FORMULAS_H
#define AD_FORMULAS_H

#include "autodiff/compile/program.h"

/* Formulas that are not operations: numbers in the uniform memory and in the parameter vector at
 * `a`; `b` of these side by side, from `a` on; the row `b` after the list `a`. Constants are what
 * they are, wherever they lie. */
enum { UNIFORM_AT = OP_COUNT, PARAMETER_AT, BLOCK, LIST };

typedef struct formula {
    int op, whole;
    double number;
    int a, b, c; /* formulas, or where leaves lie */
} formula;

typedef struct formulas {
    const ad_tape *tape;
    const place *places; /* of uniform values */
    formula *items;      /* from 1 on; 0 is none */
    int count, capacity;
    int *table; /* hash table of items, 0 empty; capacity a power of two */
    int table_capacity;
    bool *needed; /* [nodes] by an output */
    int *first;   /* [nodes] where the rows of a value that is not uniform begin in `rows` */
    int *rows;
    bool failed; /* out of memory */
} formulas;

/* Of all values that the outputs of a program need. False: out of memory; clear it all the same. */
bool ad_formulas_create(const ad_program *program, formulas *result);
void ad_formulas_clear(formulas *f);

/* A row of a sum over each member's points; b: 0, or the other factor of a product. */
static inline formula member_sum_of(int op, int a, int b)
{
    return (formula){.op = op, .whole = OF_MEMBER, .a = a, .b = b};
}

/* The number of a formula; 0 when no value of the tape has it. */
int ad_formulas_find(const formulas *f, formula wanted);

/* The number of row `row` of a value, or of its only one. */
int ad_formulas_row(const formulas *f, int id, int row);

/* Sums and products of two, which have one value in either order. */
static inline formula sum_of(int a, int b)
{
    return (formula){.op = OP_ADD, .a = a < b ? a : b, .b = a < b ? b : a};
}

static inline formula product_of(int a, int b)
{
    return (formula){.op = OP_MUL, .a = a < b ? a : b, .b = a < b ? b : a};
}

static inline formula difference_of(int a, int b)
{
    return (formula){.op = OP_SUB, .a = a, .b = b};
}

/* An elementwise operation of rows x[AD_ARITY_MAX], 0 beyond its arity. */
static inline formula operation_of(int op, int whole, double number, const int *x)
{
    if (op == OP_ADD || op == OP_MUL) {
        return op == OP_ADD ? sum_of(x[0], x[1]) : product_of(x[0], x[1]);
    }
    return (formula){.op = op, .whole = whole, .number = number, .a = x[0], .b = x[1], .c = x[2]};
}

static inline formula formula_at(place p, int row)
{
    return (formula){.op = p.kind == PLACE_PARAMETER ? PARAMETER_AT : UNIFORM_AT,
                     .a = p.offset + row * p.stride};
}

static inline formula constant_of(double number)
{
    return (formula){.op = OP_CONSTANT, .number = number};
}

static inline formula block_at(place p)
{
    return (formula){.op = BLOCK, .whole = (int)p.kind, .a = p.offset, .b = p.rows};
}

#endif
