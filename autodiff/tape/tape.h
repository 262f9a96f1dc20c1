/* Inside of the tape: nodes and the table of operations. Private to autodiff. */
#ifndef AD_TAPE_H
#define AD_TAPE_H

#include "autodiff/ad.h"
#include "autodiff/tape/operations.h"

#include <stdint.h>

/* How an operation is differentiated; transforms know these kinds and nothing else.
 *   LEAF      no arguments
 *   LINEAR    coefficient by coefficient; adjoint by its rule
 *   BILINEAR  convolution of coefficients; adjoint by its rule
 *   SMOOTH    y' = sum_i partial_i x_i'; both transforms follow from the partials
 *   SELECT    linear in its last two arguments, the first frozen
 *   FLAT      derivative zero */
typedef enum op_kind { LEAF, LINEAR, BILINEAR, SMOOTH, SELECT, FLAT } op_kind;

/* How the rows of a result come about: what the stages of a compilation and a run distinguish. */
typedef enum op_form {
    FORM_LEAF,
    FORM_ELEMENTWISE,
    FORM_SLICE,
    FORM_JOIN, /* parts below each other */
    FORM_SUM_ROWS,
    FORM_SUM_POINTS,
    FORM_PRODUCT, /* of a matrix and a vector */
    FORM_OUTER,
    FORM_OUTER_SUM,
    FORM_SPREAD
} op_form;

typedef enum op_code {
#define AD_OP_CODE(code, ...) OP_##code,
    AD_LEAVES(AD_OP_CODE) AD_ELEMENTWISE(AD_OP_CODE) AD_STRUCTURAL(AD_OP_CODE) OP_COUNT
#undef AD_OP_CODE
} op_code;

enum { OP_ELEMENTWISE_END = OP_COPY + 1 };

/* What a reduction sums over, its attribute `whole`: all points; the members, of a value that has
 * one block for each; the points of each member. OP_POINTS has the same, as the number of them. */
typedef enum sum_over { OVER_POINTS, OVER_MEMBERS, OF_MEMBER } sum_over;

static inline bool op_is_elementwise(int op)
{
    return op >= OP_ADD && op < OP_ELEMENTWISE_END;
}

static inline bool op_is_reduction(int op)
{
    return op == OP_SUM_POINTS || op == OP_OUTER_SUM;
}

static inline bool op_is_matvec(int op)
{
    return op == OP_MATVEC || op == OP_MATVEC_TRANSPOSED;
}

/* Of a product a b with a constant factor. */
static inline bool op_is_scaled(int op)
{
    return op >= OP_SCALED_MUL && op <= OP_PAIR_SUB;
}

enum { AD_ARITY_MAX = 4, AD_ARITY_ANY = -1, AD_STUMPFF_MAX = 12 };

typedef struct node {
    uint16_t op;
    uint8_t extent; /* ad_extent */
    bool splat;     /* constant with all rows equal to `number` */
    int rows;
    int first; /* of its arguments in tape->arguments */
    int count;
    int whole;     /* integer attribute: slice first row, pad rows before, Stumpff k, input number,
                    * sum_over; stack: 1 + the value of members that it spreads, part by part */
    double number; /* attribute: power's exponent, splat constant */
    size_t offset; /* constant: into tape->numbers; parameter: into the flat vector */
    bool used;     /* by an operation that was asked for, even if algebra answered it */
} node;

/* What a leaf was called when it was recorded first. */
typedef struct leaf_name {
    int id, text; /* text: where it begins in tape->text */
} leaf_name;

struct ad_tape {
    node *nodes;
    int count, capacity;
    int *arguments;
    int argument_count, argument_capacity;
    double *numbers;
    int number_count, number_capacity;
    leaf_name *names;
    int name_count, name_capacity;
    char *text; /* of the names, each with its closing zero */
    int text_count, text_capacity;
    int *table; /* hash table of node ids, -1 empty; capacity a power of two */
    int table_capacity;
    int inputs, uniforms;
    int *input_rows, *uniform_rows; /* by number */
    uint8_t *input_extent;          /* ad_extent, by number */
    bool members;                   /* some value has one block per member */
    ad_tape_counts counts;
    int depth; /* of operations recorded by simplification */
    ad_error error;
};

/* One row per operation (operations.h). Rules append to the tape; y is the node's own value. */
typedef struct op_row {
    const char *name;
    int arity;
    op_form form;
    op_kind kind;
    /* SMOOTH: d y / d argument i. */
    ad_value (*partial)(ad_value y, int i);
    /* LINEAR, BILINEAR: contribution of the adjoint of y to argument i, not yet summed. */
    ad_value (*adjoint)(ad_value y, ad_value adjoint, int i);
} op_row;

extern const op_row ad_op_table[OP_COUNT];

/* The scalar meaning of an elementwise operation: folds constants, evaluates uniform values, and is
 * what the kernels are tested against. */
double ad_op_evaluate(int op, int whole, double number, const double *x);

/* ---- recording (tape.c, simplify.c) -------------------------------------------------------- */

static inline const node *node_of(ad_value x)
{
    return &x.tape->nodes[x.id];
}

static inline ad_value value_of(ad_tape *tape, int id)
{
    return (ad_value){tape, id};
}

static inline ad_value argument_of(ad_value x, int i)
{
    return value_of(x.tape, x.tape->arguments[node_of(x)->first + i]);
}

static inline bool is_constant(ad_value x)
{
    return node_of(x)->op == OP_CONSTANT;
}

ad_value ad_tape_failed(ad_tape *tape); /* the value of a failed operation */

const char *ad_tape_name(const ad_tape *tape, int id); /* of a leaf; "" where it has none */

/* Append (or find) a node as it is: the end of every recording. */
ad_value ad_tape_append(ad_tape *tape, node prototype, const ad_value *arguments);

/* Record an operation on valid arguments: shapes checked, simplified, shared. `rows` only for
 * operations whose rows do not follow from the arguments (slice, pad, repeat). */
ad_value ad_tape_record(ad_tape *tape, int op, int count, const ad_value *arguments, int whole,
                        double number, int rows);

/* A sum over points or members of a; of the outer product of two values. */
ad_value ad_tape_sum(ad_value a, sum_over over);
ad_value ad_tape_outer_sum(ad_value y, ad_value x, sum_over over);

static inline ad_value tape_record1(int op, ad_value a)
{
    return ad_tape_record(a.tape, op, 1, &a, 0, 0, 0);
}

static inline ad_value tape_record2(int op, ad_value a, ad_value b)
{
    return ad_tape_record(a.tape, op, 2, (ad_value[]){a, b}, 0, 0, 0);
}

/* What operands stand for where they are values of members, in place, and how they vary together;
 * then, where they meet a batch value, the same at every point (false: out of memory). */
ad_extent ad_members_gather(int count, ad_value *arguments);
bool ad_members_spread(int op, int count, ad_value *arguments);

/* Rules of algebra; false: none applies. `prototype` has rows and extent filled in. */
bool ad_simplify(ad_tape *tape, const node *prototype, const ad_value *arguments, ad_value *result);

double ad_constant_row(ad_value x, int row); /* of an OP_CONSTANT */

/* Takes one more word into a hash of nodes or formulas. */
static inline uint64_t ad_hash_mix(uint64_t hash, uint64_t word)
{
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    return hash ^ (hash >> 29);
}

/* Grow *array to hold `needed` items; false when memory runs out (array unchanged). */
bool ad_tape_grow(void **array, int *capacity, int needed, size_t item);

#endif
