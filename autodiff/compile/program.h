/* Inside of a compiled program. Private to autodiff.
 *
 * A run is a sequence of passes; pass p evaluates the uniform values that do not need sums of pass
 * p or later, then replays its instructions over all tiles, then sums. Most programs have one pass.
 * A pass goes over the points or, where there are values of members, over the members: forwards to
 * what points need of their members, then over the points, then over the members again with what
 * the points of each add up to. What passes between these lies in the memory of the members, and so
 * do values that a later pass over the members needs again.
 *
 * Places. A tile of T points lives in a workspace of `units * T` doubles per thread. A value there
 * is `rows` rows of T numbers; row r starts at (offset + r * stride) * T. Values that are
 * multiplied by the same matrix are columns of one panel, so that one matrix product serves all:
 * their stride is the number of columns. Uniform values are `rows` numbers at `offset` of the
 * uniform memory or of the parameter vector. The memory of the members has rows of one number per
 * member, of which a value has those from `offset` on. */
#ifndef AD_PROGRAM_H
#define AD_PROGRAM_H

#include "autodiff/compile/kernels.h"
#include "autodiff/memory.h"
#include "autodiff/tape/tape.h"

typedef enum place_kind {
    PLACE_TILE,
    PLACE_UNIFORM,
    PLACE_PARAMETER,
    PLACE_MEMBER,
    PLACE_KINDS
} place_kind;

/* Small: a tile reads all of them. */
typedef struct place {
    int offset;
    int rows;
    int16_t stride; /* between rows: columns of the panel; 1 if uniform; 0: one row for all */
    int16_t column; /* within a panel */
    uint8_t kind;   /* place_kind */
    bool local;     /* lives in one group: every piece of the group uses the same first rows */
} place;

enum { TILE_MIN = 32, TILE_STEP = 8 };

typedef struct instruction {
    int op;
    int columns; /* of a matrix product: values side by side in one panel */
    int whole;
    double number;
    int value; /* the node that it computes or adds up, of a panel that of the first column */
    kernel loop;
    place out;
    place in[AD_ARITY_MAX];
} instruction;

/* Of a matrix product, per point. */
static inline size_t instruction_flops(const instruction *i)
{
    size_t a = (size_t)i->in[0].rows, b = (size_t)i->in[1].rows;
    return i->op == OP_SUM_POINTS || i->op == OP_SPREAD
               ? 0
               : 2 * (i->op == OP_OUTER_SUM ? a * b : a) * (size_t)i->columns;
}

/* Compiled groups: workspace, uniform memory, parameters; points, a multiple of 8. */
typedef void (*fused_groups)(double *w, const double *u, const double *p, int points);

/* instructions[first .. first+count-1]; elementwise ones of equal many rows are worked on piece by
 * piece, all instructions on one piece before the next. */
typedef struct group {
    int first, count;
    bool pieces;
    int fused_count; /* groups from this one on that `fused` does (fuse.c); 0: none */
    fused_groups fused;
} group;

typedef struct batch_output {
    int number; /* of the output, or first row in the memory of the members */
    place from;
} batch_output;

typedef struct pass {
    bool members;  /* goes over the members, not over the points */
    int stage;     /* reductions that have to be over before it, one after the other */
    int *uniforms; /* ids of uniform nodes to evaluate before the pass, in order */
    int uniform_count;
    instruction *instructions;
    int count, capacity;
    group *groups;
    int group_count;
    batch_output *outputs;
    int output_count;
    batch_output *kept; /* what goes into the memory of the members */
    int kept_count;
    int reduced_offset, reduced; /* sums: a range of the uniform memory */
    int summed_offset, summed;   /* sums of each member's points: rows of the members' memory */
    int units;                   /* of workspace */
    int fused_tile;              /* points per tile that groups of machine code are made for */
} pass;

struct ad_program {
    ad_pool *pool;
    const kernel_set *kernels;
    ad_settings settings;
    ad_program_info info;

    /* uniform values: the nodes they came from, kept to evaluate them */
    ad_tape *tape; /* a private copy of what is needed */
    place *places; /* [tape->count]; of uniform nodes, and of what is in the members' memory */
    double *uniform;
    int uniform_count;
    bool members; /* there are values of members */
    int member_rows;
    double *member; /* [member_rows][members of the run] */

    pass *passes; /* [pass_count + 1]: the last has only uniform values */
    int pass_count;
    int *input_units; /* [passes][inputs]: offset in the workspace, -1: not needed */

    int outputs;
    int *output_ids; /* [outputs] */

    int fuse_begun; /* 1: with what is kept, 2: with a compiler (fuse.c) */
    ad_code *code;  /* of fused groups, or their compiler at work; else NULL */
    bool is_fused;  /* it is loaded */

    /* memory of a run */
    int tile;            /* largest */
    double **workspaces; /* per thread: tile * most_units numbers, then with values of members
                          * `scratch` and one row */
    size_t workspace_numbers, scratch;
    double *sums; /* [chunk_capacity][most reduced], of chunks and within them */
    size_t chunk_capacity;
    size_t member_capacity; /* numbers */
    double *shares;         /* of members that take several tiles: [most summed][tiles] */
    size_t share_capacity;
    int most_reduced, most_units, most_summed;
    ad_memory memory;
};

/* Lay out and order one pass (layout.c). `needed` marks the nodes of the pass. */
typedef struct pass_plan {
    ad_program *program;
    const ad_tape *tape;
    int count;   /* nodes of the tape */
    node *nodes; /* copies that may have been contracted; op OP_COUNT: not in this pass */
    int (*arguments)[AD_ARITY_MAX]; /* of contracted nodes; stacks keep the tape's */
    int *uses;
    int *level;
    int *order; /* [ordered] node ids in order of execution */
    int ordered;
    int *position;      /* in order, by id */
    int *sum_of;        /* reductions: the node they are added to, by id */
    const bool *stored; /* goes into the memory of the members, by id */
    /* placement */
    int *parent;        /* the stack or viewed value a node lives in, -1 */
    int *row;           /* within the parent */
    int *panel;         /* number of panel, -1 */
    int *column;        /* within the panel */
    int *panel_columns; /* by panel */
    int panels;
    place *places; /* final, by id */
    ad_memory memory;
} pass_plan;

bool ad_plan_layout(pass_plan *plan, pass *p);
void ad_plan_contract(pass_plan *plan);            /* contract.c */
bool ad_emit_pass(const pass_plan *plan, pass *p); /* instructions.c */

/* May the two not be worked on row by row, both on one row before the next? (instructions.c) */
bool ad_instructions_conflict(const instruction *earlier, const instruction *later);
int ad_plan_argument(const pass_plan *plan, int id, int i);
bool ad_plan_is_product(const pass_plan *plan, int id); /* a matrix product with a uniform matrix */

/* The value of members that a node of the tape spreads over the points, or -1. */
static inline int spread_of(const ad_tape *tape, int id)
{
    const node *n = &tape->nodes[id];
    return n->op == OP_SPREAD ? tape->arguments[n->first] : -1;
}

/* NULL, or what tests have in its place, tests/helpers/verify.c: AD_BAD_PROGRAM with the first
 * thing that is wrong. It takes as long as compiling. */
extern ad_status (*ad_program_check)(const ad_program *program, ad_error *error);

/* Evaluate the uniform nodes of a pass, in order (uniform.c). */
void ad_uniform_evaluate(ad_program *program, const pass *p, const ad_run *run);
const double *ad_uniform_at(const ad_program *program, int id, const ad_run *run);

void ad_fuse_clear(ad_program *program); /* fuse.c */

/* Numbers of memory beside the workspace that an instruction needs while it runs (execute.c). */
size_t ad_execute_scratch(const instruction *i);

/* For those who use the values of a tile in place: programs of one pass that sums nothing. Tiles
 * first .. first+count-1 are replayed on the pool's threads and handed to work, which sees outputs
 * by ad_execute_output: rows of `valid` points, or single numbers of a uniform value. The cut
 * depends on the number of points alone, and is not shared with other ranks. ad_execute_begin has
 * to come before, once for all tiles. */
typedef struct tile_state tile_state;
typedef void (*tile_work)(void *context, const tile_state *t, size_t item);
void ad_execute_tiling(ad_program *program, size_t points, int *tile, size_t *tiles);
int ad_execute_tile(ad_program *program, const pass *p, size_t points, size_t members);
void ad_execute_begin(ad_program *program, const ad_run *run);
void ad_execute_tiles(ad_program *program, const ad_run *run, size_t first, size_t count,
                      tile_work work, void *context);
kernel_operand ad_execute_output(const tile_state *t, int output, bool *uniform);
int ad_execute_valid(const tile_state *t);

#endif
