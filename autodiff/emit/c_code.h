/* A program written out as C: the elementwise groups for tiles of vectors (c_groups.c), or all of
 * it for numbers (c_function.c). Private to autodiff. */
#ifndef AD_C_CODE_H
#define AD_C_CODE_H

#include "autodiff/compile/program.h"
#include "autodiff/memory.h"

/* The texts of lanes.h, stumpff.h and so on (made by text.cmake): lines, NULL at the end. */
extern const char *const ad_text_lanes[], *const ad_text_stumpff[];
extern const char *const ad_text_tanh[], *const ad_text_sine[], *const ad_text_exp[];
extern const char *const ad_text_tanh_single[], *const ad_text_sine_single[];
extern const char *const ad_text_exp_single[], *const ad_text_stumpff_single[];

void ad_c_text(const char *const *lines, FILE *file);

/* How many groups of elementwise instructions follow one another from `group` on: what one function
 * does. */
int ad_c_run_length(const pass *p, int group);

/* All elementwise groups of a program for the tiles of its passes, one function for each run of
 * them, and a table `name` of the functions in the order of passes and groups. False: out of
 * memory. */
bool ad_c_write_groups(const ad_program *program, const char *name, FILE *file);

/* ---- elementwise instructions, for both (c_segments.c) -------------------------------------- */

enum {
    C_OPERAND = 64,
    C_LOOP_MAX = 96, /* instructions in a loop over rows; each may make its operands again */
    C_HELD_MAX = C_LOOP_MAX * (1 + AD_ARITY_MAX * (1 + AD_ARITY_MAX))
};

/* What holds a block of rows: a variable of the segment at work. */
typedef struct c_held {
    place at;
    int variable;
} c_held;

/* Functions of numbers with a reach, sin, cos and those of Stumpff: whichever serves the argument,
 * which costs a branch; those for arguments within reach, without one; those for all. */
typedef enum c_reach { REACH_ANY, REACH_NEAR, REACH_FAR } c_reach;

static inline bool op_is_sine(int op)
{
    return op == OP_SIN || op == OP_COS;
}

static inline bool has_reach(int op)
{
    return op_is_sine(op) || op == OP_STUMPFF;
}

typedef struct c_writer {
    const ad_program *program;
    FILE *file;
    bool vectors;       /* of LANES points, by the functions of lanes.h; else one number */
    const char *type;   /* of a variable */
    const char *suffix; /* of numbers and of libm's functions: "", or "f" */
    int numbers;        /* points, when these are numbers */
    const char *points; /* head of the loop over points, "": there is one */
    /* a uniform value, its row or the one that `r` counts (row < 0): C_OPERAND characters */
    void (*uniform)(const struct c_writer *w, place p, int row, char *text);
    void *context;     /* of it */
    const bool *known; /* [uniform memory] written as they are: numbers that stand in it */
    c_reach reach;
    /* a pass */
    const pass *pass;
    int *end;     /* [instructions] the one after its segment */
    bool *kept;   /* of all instructions' rows, one after the other: read after its segment */
    bool *needed; /* of the same: read at all; of loops over rows all are */
    size_t *row;  /* [instructions] its first in `kept` and `needed` */
    bool *dead;   /* [instructions] read by nobody: all make it again */
    int *again;   /* [instructions][AD_ARITY_MAX] the one that makes an operand again, or -1 */
    /* a segment */
    int *holder; /* [units] variable of a row, -1: none */
    c_held held[C_HELD_MAX];
    int held_count, variables;
    ad_memory memory;
} c_writer;

/* Cut a pass into segments, find what each has to leave in memory. False: out of memory; end it all
 * the same. */
bool ad_c_begin_pass(c_writer *w, const pass *p);
void ad_c_end_pass(c_writer *w);

/* Instructions first .. end-1, all elementwise, whole segments. */
void ad_c_write_segments(c_writer *w, int first, int end);

/* The constants of a program, [uniform memory]; NULL: out of memory. */
bool *ad_c_constants(const ad_program *program);

/* "a + b", "v_tanh(a)" or, of numbers, "tanh(a)". */
void ad_c_operation(const c_writer *w, int op, int whole, double number,
                    char (*operands)[C_OPERAND]);

/* A number as C, exact: C_OPERAND characters are enough. */
void ad_c_number(const c_writer *w, double number, char *text);

bool ad_c_is_loop(const instruction *i); /* over rows: of many of them */

/* Fill w->again (c_again.c). */
bool ad_c_find_again(c_writer *w);

/* Mark what is read after each segment in w->kept, what is read in w->needed (c_lives.c). */
bool ad_c_find_lives(c_writer *w);

/* ---- whole programs (c_function.c, c_uniform.c) --------------------------------------------- */

/* Numbers that stand in the C as an array. */
typedef struct c_table {
    const char *name; /* what they are called on the tape, or "" */
    bool turned;      /* a matrix [k][m] that is stored [m][k] */
    int sets;         /* 1: all have the same */
    int rows;
    double *numbers; /* [sets][rows] */
} c_table;

/* y = A x, or of `columns` side by side; at several points these are columns, too. A is
 * [rows][terms] in memory, or turned. */
typedef struct c_product {
    int rows, terms, columns, x_stride, y_stride;
    bool wide, turned;
} c_product;

/* Of all functions of a file; functions with the same numbers or with alike products share them. */
typedef struct c_tables {
    const char *name; /* before the number of a table or product */
    c_table *items;
    int count, capacity;
    c_product *products;
    int product_count, product_capacity;
} c_tables;

typedef struct c_function {
    c_writer w;
    ad_program *program;
    const ad_c_options *options;
    c_tables *tables;
    const char *loop; /* head of a loop over points; "" for one */
    bool *known;      /* [uniform memory] */
    bool *same;       /* [uniform memory] known, and the same in all sets */
    double *values;   /* [sets][uniform memory] */
    int *varying;     /* of numbers that differ, where they are: v[i] in the C */
    int varying_count, varying_capacity;
    bool uses_u, failed;
} c_function;

/* Evaluate what follows from what is given, before the first pass. False: out of memory. */
bool ad_c_find_known(c_function *f);
bool ad_c_is_known(const c_function *f, place p);
void ad_c_clear_known(c_function *f);

/* c_writer.uniform of whole programs; context is the c_function. */
void ad_c_put_uniform(const c_writer *w, place p, int row, char *text);

/* Where numbers stand and how far in, to be followed by the rest of an index and "]": "u[13 + ",
 * "eval_2[", "eval_2[set][". C_OPERAND characters. A matrix of k columns is turned where it is
 * known; k = 0: as it is. */
void ad_c_begin_index(c_function *f, place p, int k, char *text);

/* The array of numbers that are no places of their own, behind their name: `set` of it. -1: none */
int ad_c_varying_table(c_function *f);

/* What is computed before a pass, arrays of what is known, zeros in the array u or m. */
void ad_c_write_uniforms(c_function *f, const pass *p);
void ad_c_write_tables(const c_writer *w, const c_tables *tables, FILE *file);
void ad_c_clear_tables(c_tables *tables);
void ad_c_write_zeros(c_function *f, char memory, int to, int rows);

#endif
