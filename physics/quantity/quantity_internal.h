/* What the files of quantities share; not for others. */
#ifndef PHYSICS_QUANTITY_QUANTITY_INTERNAL_H
#define PHYSICS_QUANTITY_QUANTITY_INTERNAL_H

#include "physics/quantity/quantity.h"

#include <stdint.h>

enum {
    QUANTITY_NAME_MAX = 40,
    QUANTITY_SIZE_MAX = 4096, /* operations of a formula, which bounds the depth of recursions */
    QUANTITY_ARGUMENTS_MAX = 3
};

/* Where an operation jumps, has a kink, or begins to be defined. */
typedef enum quantity_switch {
    QUANTITY_SMOOTH,
    QUANTITY_BY_SIGN,       /* of its first argument */
    QUANTITY_BY_DIFFERENCE, /* sign of the difference of both */
    QUANTITY_BY_UNIT,       /* where its argument is 1 or -1 */
    QUANTITY_BY_EXPONENT    /* sign of the base, but for exponents that are natural numbers */
} quantity_switch;

/* An operator or a function. */
typedef struct quantity_operation {
    const char *name;
    int arity;
    int precedence; /* of an operator; 0: a function, name(...) */
    double (*number)(const double *x);
    ad_value (*record)(const ad_value *x);
    void (*range)(const quantity_interval *x, quantity_interval *value, quantity_interval *by);
    quantity_switch switches;
} quantity_operation;

/* The operators are the first rows. */
enum {
    QUANTITY_ADD,
    QUANTITY_SUBTRACT,
    QUANTITY_MULTIPLY,
    QUANTITY_DIVIDE,
    QUANTITY_POWER,
    QUANTITY_WHERE = 22, /* behind the functions; evaluates one of its branches only: long tables
                            are trees of it */
    QUANTITY_WITHIN
};
extern const quantity_operation quantity_operations[];
extern const int quantity_operation_count;

/* The row of a name that is `length` long; NULL: none. */
const quantity_operation *quantity_operation_find(const char *name, size_t length);

typedef enum quantity_kind {
    QUANTITY_OPEN,      /* an open name: s, t */
    QUANTITY_OPERATION, /* of its arguments */
    QUANTITY_WRITTEN,   /* what its author wrote, and what it says: x[0] */
    QUANTITY_UNPARSED,  /* the same, not parsed yet */
    QUANTITY_ERROR      /* the text says what is wrong */
} quantity_kind;

/* s and t in quantity_node.uses. */
static const uint64_t QUANTITY_COORDINATES = 3;

typedef struct quantity_node {
    quantity_kind kind;
    ad_status status; /* of an error */
    int index;        /* of an open name, whose x are its usual value and its range */
    uint64_t uses;    /* open names that occur: bits by index */
    int size;         /* operations with repetition */
    const quantity_operation *operation;
    const char *text; /* name, written text, error */
    quantity x[QUANTITY_ARGUMENTS_MAX];
    quantities *owner;
    uint64_t hash;
    struct quantity_node *next; /* of the same bucket */
    quantity_enclosure still;   /* of quantity_enclose_still */
} quantity_node;

/* A defined or an open name. */
typedef struct quantity_name {
    char text[QUANTITY_NAME_MAX + 1];
    quantity value;
    bool used; /* by a formula that was parsed */
} quantity_name;

/* The value of a name `length` long, not given when there is none; and the names by number. */
quantity quantities_find(const quantities *names, const char *name, size_t length);
void quantities_use(quantities *names, const char *name, size_t length);
int quantities_count(const quantities *names);
const char *quantities_name(const quantities *names, int i);

/* quantity_table.c: a table as a function, of a list that `next` links; its name's length is that
 * of `name`. */
typedef struct quantity_table quantity_table;
struct quantity_table *quantity_table_create(const char *name, int count, const double *x,
                                             const double *y, quantity_table *next);
void quantity_tables_free(quantity_table *first);
const quantity_table *quantity_table_find(const quantity_table *first, const char *name,
                                          size_t length);
quantity quantity_table_call(const quantity_table *table, quantity x);

/* The table of that name that formulas of `names` know, NULL: none. */
const quantity_table *quantities_table(const quantities *names, const char *name, size_t length);

/* quantity_play.c: plays and lags of `names`, and the state of one of these arguments. */
typedef struct quantity_plays {
    bool known;
    int count;
    quantity_play play[QUANTITY_PLAYS_MAX];
} quantity_plays;
quantity_plays *quantities_memory(quantities *names);
quantity quantity_memory_call(quantities *names, bool lags, quantity x, quantity constant);

/* `value` with the text of a formula as it was written. */
quantity quantity_written(quantity as, quantity value);

/* kept.c: the last findings, each the bytes of its key and behind them what is found. */
enum { QUANTITY_KEPT_MAX = 16 };
typedef struct quantity_finding {
    size_t key_size, size;
    char *bytes; /* NULL: none */
} quantity_finding;
typedef struct quantity_kept {
    unsigned count; /* of all that were kept */
    quantity_finding findings[QUANTITY_KEPT_MAX];
} quantity_kept;
quantity_kept *quantities_lock_kept(quantities *names); /* those of `names`, for one thread */
void quantities_unlock_kept(quantities *names);

/* Whether the name goes on there with a point and a letter, as "tip.x" does. */
bool quantity_name_goes_on(const char *at);

/* quantity_range.c: the enclosure of an operation that depends on open names, and neither on s nor
 * on t; of other nodes nothing. Those of its arguments are known. */
quantity_enclosure quantity_enclose_still(const quantity_node *node);

quantity quantity_error(quantities *owner, ad_status status, const char *message);
quantity quantity_operate(const quantity_operation *operation, const quantity *x);

/* quantity_interval.c: for arguments in intervals x [arity] an enclosure of the values and of the
 * derivatives by [arity] each; where it has none, of quotients of differences. One per row. */
/* clang-format off */
#define QUANTITY_RANGE_LIST(X)                                                                     \
    X(add) X(subtract) X(multiply) X(divide) X(power) X(sin) X(cos) X(tan) X(asin) X(acos)         \
    X(atan) X(atan2) X(sinh) X(cosh) X(tanh) X(exp) X(log) X(sqrt) X(abs) X(min) X(max) X(step)    \
    X(where) X(within)
/* clang-format on */
#define QUANTITY_RANGE(name)                                                                       \
    void quantity_range_##name(const quantity_interval *x, quantity_interval *value,               \
                               quantity_interval *by);
QUANTITY_RANGE_LIST(QUANTITY_RANGE)
#undef QUANTITY_RANGE

/* The same file: an interval of two, outward by rounding. */
quantity_interval quantity_interval_add(quantity_interval a, quantity_interval b);
quantity_interval quantity_interval_multiply(quantity_interval a, quantity_interval b);

/* quantity_parse.c: without the text as it was written. */
quantity quantity_parse(quantities *names, const char *text);

#endif
