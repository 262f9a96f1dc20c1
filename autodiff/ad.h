/* autodiff: a tape that is a small compiler.
 *
 *   record      ad_input, ad_parameter, ad_mul, ad_tanh, ... append operations to a tape
 *   transform   ad_taylor, ad_derivative (forward, any order) and ad_reverse (adjoints) append the
 *               operations that compute derivatives; every rule is written in terms of the same
 *               operations, so transforms compose in any order
 *   simplify    happens while recording: common subexpressions, constants, the algebra of 0 and 1
 *   compile     ad_compile keeps what the outputs need and gives every value a place
 *   execute     ad_execute replays the program over tiles of points, on all threads of a pool
 *
 * A value is a block of `rows` scalars. There is one block per point of a batch (AD_BATCH), or one
 * block for all points (AD_UNIFORM: constants, parameters, scalars of the scene). Between the two
 * there is one block per member of a family (AD_MEMBER: a robot's stiffness, coefficients of its
 * shape). Every member has equally many points, which follow each other. In memory a batch value is
 * [rows][points], points contiguous; a value of members is [rows][members]; a matrix [m][k] is a
 * value of m*k rows, row-major.
 *
 * Elementwise operations take values of equal rows, or one of a single row, which is repeated. A
 * uniform value meets a batch value by being the same at every point. A value of a member is the
 * same at every point of the member. What follows from values of members alone is computed once per
 * member, and so are its derivatives: ad_reverse sums what the points of a member contribute before
 * it goes on. Algebra may find that a value varies less than its operands seem to (a row of a
 * stack, 0 times a batch value); no result depends on that.
 *
 * Errors while recording are sticky: the first one stays on the tape, later operations return
 * values that may be passed on but compute nothing, and ad_compile refuses the tape. So physics
 * can be written as formulas, with one check at the end.
 *
 * Every operation's derivative at its singular point is defined: see the operations. */
#ifndef AD_H
#define AD_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ad_tape ad_tape;

/* Passed and copied by value; valid as long as its tape. */
typedef struct ad_value {
    ad_tape *tape;
    int id;
} ad_value;

typedef enum ad_extent { AD_UNIFORM, AD_MEMBER, AD_BATCH } ad_extent; /* in this order */

/* ---- tape ---------------------------------------------------------------------------------- */

/* An empty tape, owned by the caller; one that has failed when memory runs out. */
ad_tape *ad_tape_create(void);
void ad_tape_free(ad_tape *tape);

/* The first error of the recording, AD_OK when there is none. `error` may be NULL. */
ad_status ad_tape_status(const ad_tape *tape, ad_error *error);

/* Note an error from a layer above (a bad shape in a network, say) as if an operation had it. */
void ad_tape_fail(ad_tape *tape, ad_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

typedef struct ad_tape_counts {
    size_t recorded; /* operations asked for, by physics and by transforms */
    size_t folded;   /* of these, answered by algebra without a new operation: 0 x, 1 x, x + 0 */
    size_t shared;   /* of these, answered by an equal operation already on the tape */
    size_t stored;   /* operations on the tape now, inputs and constants included */
} ad_tape_counts;

ad_tape_counts ad_tape_count(const ad_tape *tape);

/* Every value on a line of its own; file NULL, as a debugger may give it, is stderr. */
void ad_tape_print(const ad_tape *tape, FILE *file);

int ad_rows(ad_value x); /* 0 for a failed value */
ad_extent ad_extent_of(ad_value x);
bool ad_is_constant(ad_value x, double value); /* every row known to equal `value` */
bool ad_is_valid(ad_value x);

/* ---- leaves -------------------------------------------------------------------------------- */

/* One block per point, given at every run; inputs are numbered in the order of recording. */
ad_value ad_input(ad_tape *tape, const char *name, int rows);

/* The same with one block per member, numbered together with the others. */
ad_value ad_input_member(ad_tape *tape, const char *name, int rows);

/* One block for all points, given at every run; numbered in the order of recording. */
ad_value ad_uniform(ad_tape *tape, const char *name, int rows);

/* `rows` numbers of the flat parameter vector, from `offset` on. */
ad_value ad_parameter(ad_tape *tape, const char *name, int rows, size_t offset);

ad_value ad_constant(ad_tape *tape, int rows, const double *values);
ad_value ad_scalar(ad_tape *tape, double value);
ad_value ad_zeros(ad_tape *tape, int rows);

/* Numbers of the run, uniform scalars: points, members, points of each member. */
ad_value ad_points(ad_tape *tape);
ad_value ad_members(ad_tape *tape);
ad_value ad_points_of_member(ad_tape *tape);

/* ---- elementwise --------------------------------------------------------------------------- */

ad_value ad_add(ad_value a, ad_value b);
ad_value ad_sub(ad_value a, ad_value b);
ad_value ad_mul(ad_value a, ad_value b);
ad_value ad_div(ad_value a, ad_value b); /* a times the IEEE reciprocal of b */
ad_value ad_neg(ad_value a);
ad_value ad_scale(ad_value a, double factor);
ad_value ad_square(ad_value a);

ad_value ad_tanh(ad_value a);
ad_value ad_sin(ad_value a);
ad_value ad_cos(ad_value a);
ad_value ad_exp(ad_value a);
ad_value ad_log(ad_value a);
ad_value ad_erf(ad_value a);
ad_value ad_sqrt(ad_value a);                   /* derivative at 0 defined as 0 */
ad_value ad_reciprocal(ad_value a);             /* IEEE: 1/0 is infinite */
ad_value ad_reciprocal_or_zero(ad_value a);     /* 1/a, and 0 (with all derivatives) at a = 0 */
ad_value ad_power(ad_value a, double exponent); /* libm's pow; d = exponent a^(exponent-1) */
ad_value ad_abs(ad_value a);                    /* derivative sign(a), 0 at 0 */
ad_value ad_sign(ad_value a);                   /* -1, 0, 1; derivative 0 */
ad_value ad_atan2(ad_value y, ad_value x);      /* derivatives at the origin defined as 0 */
ad_value ad_acos(ad_value a);                   /* derivative at -1 and 1 defined as 0 */
ad_value ad_asin(ad_value a);                   /* the same */

/* Stumpff function c_k(a) = sum_i (-a)^i / (2i+k)!, entire: c_0(x^2) = cos x, c_1(x^2) = sin(x)/x,
 * so rotation formulas have no singular angle. 0 <= k <= 12; a derivative of order j needs
 * k + 2j within that range. */
ad_value ad_stumpff(int k, ad_value a);

/* condition > 0 ? a : b, per element; nothing flows through the condition. The adjoint of the
 * branch not taken is 0, which times an infinite partial derivative is NaN, as everywhere in IEEE
 * arithmetic: keep both branches finite. */
ad_value ad_select(ad_value condition, ad_value a, ad_value b);
ad_value ad_max(ad_value a, ad_value b);
ad_value ad_min(ad_value a, ad_value b);

/* Smooth functions made of the above, for networks. */
ad_value ad_sigmoid(ad_value a);
ad_value ad_silu(ad_value a); /* a sigmoid(a) */
ad_value ad_gelu(ad_value a); /* a Phi(a), with erf */

/* ---- rows, points, matrices ---------------------------------------------------------------- */

ad_value ad_row(ad_value a, int row);                /* 1 row */
ad_value ad_slice(ad_value a, int first, int rows);  /* rows first .. first+rows-1 */
ad_value ad_stack(int count, const ad_value *parts); /* parts above one another */
ad_value ad_pad(ad_value a, int before, int rows);   /* a within `rows` rows of zeros */
ad_value ad_repeat(ad_value a, int rows);            /* 1 row -> rows */
ad_value ad_sum_rows(ad_value a);                    /* rows -> 1 */

/* Sums over points, in a fixed order, of values that need not vary over them: of all points ->
 * uniform; of each member's points -> of members; and of one number per member -> uniform. The last
 * is an error (AD_BAD_SHAPE) for a value that varies within a member. */
ad_value ad_sum_points(ad_value a);
ad_value ad_sum_points_of_member(ad_value a);
ad_value ad_sum_members(ad_value a);

ad_value ad_matvec(ad_value w, ad_value x);            /* [m*k] x [k] -> [m] */
ad_value ad_matvec_transposed(ad_value w, ad_value y); /* [m*k]^T x [m] -> [k] */
ad_value ad_outer(ad_value y, ad_value x);             /* [m] x [k] -> [m*k] */

/* ---- vectors and quaternions (vector.c): 3 rows; quaternions 4 rows, scalar first ------------ */

ad_value ad_vector(ad_value x, ad_value y, ad_value z);
ad_value ad_vector_constant(ad_tape *tape, double x, double y, double z);
ad_value ad_dot(ad_value a, ad_value b);
ad_value ad_norm(ad_value a);      /* gradient at 0 defined as 0 */
ad_value ad_normalize(ad_value a); /* 0 for the zero vector */
ad_value ad_cross(ad_value a, ad_value b);
ad_value ad_quaternion(ad_value scalar, ad_value vector);
ad_value ad_quaternion_multiply(ad_value p, ad_value q);
ad_value ad_quaternion_conjugate(ad_value q);
ad_value ad_quaternion_exp(ad_value rotation_vector); /* exp(w/2), smooth at angle 0 */
ad_value ad_rotate(ad_value q, ad_value x);           /* R(q) x, q a unit quaternion */
ad_value ad_rotate_inverse(ad_value q, ad_value x);   /* R(q)^T x */

/* ---- transforms ---------------------------------------------------------------------------- */

/* Taylor coefficients c_0 .. c_order of each y along x + tau * direction, where
 * y(x + tau direction) = sum_k c_k tau^k. coefficients is [count][order + 1]. x is an input,
 * uniform or parameter; direction is any value of its rows (or of 1 row). */
ad_status ad_taylor(int count, const ad_value *y, ad_value x, ad_value direction, int order,
                    ad_value *coefficients);

/* d^order y / dx^order for a scalar x (1 row): order! times the Taylor coefficient. */
ad_value ad_derivative(ad_value y, ad_value x, int order);

/* Derivatives [count] of each y where all of the different variables wrt move at once, each along
 * its direction as above: sum_i (dy / d wrt[i]) directions[i]. */
ad_status ad_directional(int count, const ad_value *y, int wrt_count, const ad_value *wrt,
                         const ad_value *directions, ad_value *derivatives);

/* Adjoints d root / d wrt[i] for a scalar root, each with the rows of wrt[i]; wrt are inputs,
 * uniforms or parameters. A parameter that no operation on the tape uses is an error: most likely
 * its offset or rows differ from what was recorded, and a 0 would hide that.
 * AD_SUMMED: the root is uniform, and adjoints of uniform values are summed over the points, those
 * of values of members over the points of each. A root that is a batch value stands for its sum
 * over points, a value of members for its sum over members. AD_PER_POINT: the root is a batch
 * scalar and adjoints stay per point, so that adjoints of parameters are rows of a Jacobian. By a
 * member's input they are derivatives of the point by the block of its member. Rows by what lies
 * before other values of members are right, but go back through those at every point. Record such a
 * value as an input of members of its own, and take rows by that. ad_substitute the value where the
 * residuals themselves are wanted. */
typedef enum ad_reduction { AD_SUMMED, AD_PER_POINT } ad_reduction;

ad_status ad_reverse(ad_value root, int count, const ad_value *wrt, ad_reduction reduction,
                     ad_value *adjoints);

/* y with x, an input, uniform or parameter, replaced wherever it occurs; simplified anew. */
ad_value ad_substitute(ad_value y, ad_value x, ad_value replacement);

/* Calls a formula of a tape of its own with values of another tape. results [count] are formula
 * [count] with values [inputs] of `tape` in place of its leaves input [inputs]. Elementwise
 * formulas of one row take values of any number of rows. So a law of physics is recorded once,
 * differentiated once, and used by every equation. An error of either tape is noted on `tape`, and
 * returned. */
ad_status ad_call(int count, const ad_value *formula, int inputs, const ad_value *input,
                  ad_tape *tape, const ad_value *values, ad_value *results);

/* Take out of `outputs` what depends on inputs and uniforms alone, so that it is computed once for
 * a set of points and what is set before a run, instead of in every run. A value becomes a new
 * input if it takes at least `least` operations and is used by something that depends on
 * parameters, sums or one of the `varying` inputs and uniforms. The new inputs have at most `rows`
 * rows together; outputs are replaced by equal ones of these inputs. fixed [rows] receives the
 * values that the new inputs stand for, in the order of the inputs; one of members becomes an input
 * of members. */
ad_status ad_precompute(int count, ad_value *outputs, int varying_count, const ad_value *varying,
                        int least, int rows, ad_value *fixed, int *fixed_count);

/* Does one of `count` values need any row of x? Constants are needed by none. Together with a
 * derivative recorded anew (and so shared) it tells what a formula really uses. */
bool ad_uses(int count, const ad_value *y, ad_value x);

/* ---- compile and execute ------------------------------------------------------------------- */

/* Threads that take work; shared by any number of programs, one run at a time. 1 thread: none is
 * started. NULL when threads or memory run out, of which OpenBLAS takes 128 MiB for each. */
typedef struct ad_pool ad_pool;
ad_pool *ad_pool_create(int threads);

/* The same of 1 to AD_THREADS_MAX threads, or 0: one per processor. Errors: AD_BAD_ARGUMENT,
 * AD_NO_MEMORY; *pool is then NULL. */
#define AD_THREADS_MAX 1024
ad_status ad_pool_open(int threads, ad_pool **pool, ad_error *error);
void ad_pool_free(ad_pool *pool);
int ad_pool_threads(const ad_pool *pool);

/* Run work(context, item, thread) for items 0 .. count-1 on the pool's threads; does not allocate.
 */
typedef void (*ad_pool_work)(void *context, int item, int thread);
void ad_pool_run(ad_pool *pool, int count, ad_pool_work work, void *context);

/* So that long work can be given up: `asked` (NULL: nobody is) is called before every item from now
 * on, by any thread, and once it is true items are left out. Whoever watches asks ad_pool_stopped
 * after the runs, and throws away what they have computed if it is true. Not during a run. */
void ad_pool_watch(ad_pool *pool, bool (*asked)(void *context), void *context);
bool ad_pool_stopped(const ad_pool *pool);

typedef struct ad_settings {
    int tile;  /* points per tile, at most 65536; 0: chosen by the size of the L2 cache */
    int piece; /* numbers per piece of an elementwise group */
    bool fuse; /* stack matrix products that share a matrix, contract k*a*b+c; off only to
                * compare: results agree to rounding */
} ad_settings;

ad_settings ad_settings_default(void);

typedef struct ad_program ad_program;

typedef struct ad_program_info {
    size_t instructions;    /* after dead code is gone */
    size_t dead;            /* operations on the tape that no output needs */
    size_t groups;          /* groups of elementwise instructions */
    size_t products;        /* matrix products per tile */
    size_t flops_per_point; /* of the matrix products */
    size_t flops_per_member;
    size_t passes;          /* passes over the points or the members */
    size_t workspace_bytes; /* per thread */
    size_t reduced;         /* numbers summed over points */
    int tile;
} ad_program_info;

/* Compile what `outputs` need. The tape may be freed afterwards; `pool` must outlive the program.
 * The tests verify every program against its tape: AD_BAD_PROGRAM means a fault of the compiler. */
ad_status ad_compile(int count, const ad_value *outputs, const ad_settings *settings, ad_pool *pool,
                     ad_program **program, ad_error *error);
void ad_program_free(ad_program *program);
ad_program_info ad_program_inspect(const ad_program *program);

/* Every instruction on a line of its own: the value %n of the tape that it computes, and @ where in
 * the workspace (in units of a tile; / units between rows). Then follow operands with their places,
 * and products with sizes and operations. Groups and outputs as well. file NULL is stderr. */
void ad_program_print(const ad_program *program, FILE *file);

typedef struct ad_run {
    size_t points;
    const double *const *inputs;   /* per ad_input of the tape: [rows][points] or, of members,
                                    * [rows][members] */
    const double *const *uniforms; /* per ad_uniform of the tape: [rows] */
    const double *parameters;      /* flat vector */
    double *const *outputs;        /* per output: [rows] if uniform, [rows][points] if batch,
                                    * [rows][members] if of members; NULL: not wanted this time */
    size_t members;                /* 0 is 1; divides points, which are those of the first member,
                                    * of the second, ...; of no meaning to programs without values
                                    * of members */
    bool everywhere;               /* uniform outputs, too, are [rows][points] */
} ad_run;

/* Replay. Allocates nothing after the first run with a given or larger number of points (and
 * members). The result is the same to the last bit for any number of threads. AD_BAD_ARGUMENT:
 * members with different numbers of points; AD_NO_MEMORY. */
ad_status ad_execute(ad_program *program, const ad_run *run, ad_error *error);

/* Compiles values, executes them once and frees the program. pool NULL: by the calling thread. */
ad_status ad_evaluate(int count, const ad_value *values, ad_pool *pool, const ad_run *run,
                      ad_error *error);

/* The elementwise groups of a program can be taken from C that is written for it and compiled by
 * the command cc: the same bits, in half the time. Begin takes compiled groups from `folder`, where
 * an earlier compilation kept them. The folder is made if it is missing, and must belong to this
 * user alone, below folders where only this user and root can put others in its place. If there are
 * no groups and it is to `compile`, it starts the compiler and returns. For runs over so many
 * points and members (others go on as they are). Finish takes over what is ready, or waits for it;
 * until then, and where there is no compiler, the program goes on as it is. What was tried is not
 * tried again. Errors: AD_IO, AD_NO_MEMORY; the program can be used all the same. Not while it
 * runs. */
typedef enum ad_fuse_state { AD_INTERPRETED, AD_FUSING, AD_FUSED } ad_fuse_state;

ad_status ad_fuse_begin(ad_program *program, size_t points, size_t members, const char *folder,
                        bool compile, ad_error *error);
ad_status ad_fuse_finish(ad_program *program, bool wait, ad_fuse_state *state, ad_error *error);

/* The command cc: the first in an absolute folder of PATH. False: there is none. */
bool ad_fuse_compiler(char *path, size_t room);

/* A text of C11 as machine code. It defines `ad_code_table`, whatever that is, and is compiled with
 * these options, words between blanks, for the processor at hand; what was compiled is kept, as
 * above. Begin: *result NULL where nothing is kept and it is not to compile. Finish takes what is
 * ready, or waits for it: *table is the address of ad_code_table, until then NULL; it lasts as long
 * as the code. AD_IO, AD_NO_MEMORY. */
typedef struct ad_code ad_code;
typedef struct ad_code_settings {
    const char *options, *folder;
    bool compile;
} ad_code_settings;

ad_status ad_code_begin(const char *text, size_t size, const ad_code_settings *how,
                        ad_code **result, ad_error *error);
ad_status ad_code_finish(ad_code *code, bool wait, const void **table, ad_error *error);
void ad_code_free(ad_code *code); /* NULL is allowed; stops a compiler at work */

/* Whole programs as C99 functions without anything but libm, for a fixed number of points at a
 * call, in numbers of type double or, where `single`, float:
 *     void NAME(const double *x, const double *const *uniforms, const double *p,
 *               double *y, double *w)
 * x: the inputs one after the other, y: the outputs, each as in ad_run. Values of members are those
 * of one member, and are computed once. w: workspace; *memory numbers are enough for any of the
 * functions. Where parameters and uniforms are given here, they
 * stand in the C and are no arguments; where several sets of them are given, the first argument is
 * `int set`. What several functions have in common stands there once, and is called NAME_0, NAME_1,
 * ... after the first. Sums and products are added up in another order than by ad_execute, and sin,
 * cos, exp and tanh are our own. Not while the programs run. Errors: AD_BAD_ARGUMENT (name,
 * points), AD_NO_MEMORY; those of the file are the caller's to see. */
typedef struct ad_c_options {
    const char *name;                     /* a C identifier of at most 30 characters */
    size_t points;                        /* 1 to 1024 */
    int sets;                             /* that are given; 0: none, both are arguments */
    const double *const *parameters;      /* [sets] */
    const double *const *const *uniforms; /* [sets] */
    bool internal;                        /* a static function */
} ad_c_options;

ad_status ad_write_c(int count, ad_program *const *programs, const ad_c_options *options,
                     bool single, FILE *file, size_t *memory, ad_error *error);

/* A formula as a C function without a loop, for numbers of any type:
 *     ALGEBRA_INLINE void ALGEBRA(function)(const NUMBER input[], ..., NUMBER output[], ...)
 * The text that includes it defines NUMBER (double, float, or a vector of numbers side by side),
 * ALGEBRA(name) and ALGEBRA_INLINE. Sums, products and 1/x are operators; whatever else the formula
 * has is a function that this text defines, such as ALGEBRA(sqrt)(&x, &result), and
 * ALGEBRA(inverse_root) for 1/sqrt(x), which is 0 or a finite number at 0. What is computed is
 * added to the outputs. The text depends on the formula alone. Inputs are scalar leaves of the
 * tape, outputs scalar values of elementwise operations; AD_BAD_ARGUMENT: others. Errors of the
 * file are the caller's to see. */
typedef struct ad_inline_argument {
    const char *name;
    int count;
    const ad_value *values; /* [count], of one row each */
} ad_inline_argument;

ad_status ad_write_inline(const char *function, int inputs, const ad_inline_argument *input,
                          int outputs, const ad_inline_argument *output, FILE *file,
                          ad_error *error);

/* ---- normal equations ----------------------------------------------------------------------- */

/* For residuals r_ij (row i of batch values, point j) the sums over rows and points that a
 * Gauss-Newton step needs, J = dr/dx by the flat parameter vector x: J^T J, J^T r, r^T r. The rows
 * of J live for a slab of points at a time, their sums are matrix products. */
typedef struct ad_normal ad_normal;

typedef struct ad_normal_info {
    size_t rows;       /* of residuals that vary with the parameters, per point */
    size_t bytes;      /* of all workspaces */
    size_t slab_bytes; /* of the rows of J that ad_normal_add keeps for so many points */
    size_t flops;      /* of the matrix products, per point; structural zeros are left out */
} ad_normal_info;

/* Compile residuals (any number of rows each) and their Jacobian by wrt: recorded ad_parameters
 * that cover parts of the vector [parameters] and do not overlap; x outside of them does not count.
 * Appends to the tape, which may be freed afterwards. Residuals may not contain sums over points,
 * nor values of members (AD_BAD_ARGUMENT), for which see ad_normal_product. */
ad_status ad_normal_compile(int count, const ad_value *residuals, int wrt_count,
                            const ad_value *wrt, size_t parameters, ad_pool *pool,
                            ad_normal **normal, ad_error *error);
void ad_normal_free(ad_normal *normal);
ad_normal_info ad_normal_inspect(const ad_normal *normal, size_t points);
void ad_normal_print(const ad_normal *normal, FILE *file); /* its program and columns of J */
ad_program *ad_normal_program(ad_normal *normal);          /* of the factors of the rows of J */

/* Adds to jtj [parameters][parameters] (its upper triangle; the lower one is not touched), jtr
 * [parameters] and *rtr. run->outputs is not read. Allocates nothing after the first run with a
 * given or larger number of points; the same bits for any number of threads. */
ad_status ad_normal_add(ad_normal *normal, const ad_run *run, double *jtj, double *jtr, double *rtr,
                        ad_error *error);

/* J itself: writes rows first .. first + points * info.rows - 1 of the columns jt [parameters]
 * [stride], zeros too, and of r; all points of a residual follow each other. Allocates nothing. */
void ad_normal_jacobian(ad_normal *normal, const ad_run *run, size_t first, size_t stride,
                        double *jt, double *r);

/* J^T J v without J, recorded: products[i] has the rows of wrt[i], of the vector v given by parts
 * as directions[wrt_count], uniform values; residuals and wrt as above. Linear in v, so a program
 * takes some three times the operations of a gradient. Through values of members J is a product of
 * two: that of the points by these, and that of these by the parameters, each taken once. The tape
 * gains an input that no program needs. */
ad_status ad_normal_product(int count, const ad_value *residuals, int wrt_count,
                            const ad_value *wrt, const ad_value *directions, ad_value *products);

/* ---- gradient check ------------------------------------------------------------------------ */

/* value and, when gradient is not NULL, gradient [count] at x [count]; 0 on success. */
typedef int (*ad_function)(void *context, const double *x, double *value, double *gradient);

typedef struct ad_check {
    double worst_error;      /* largest |difference - gradient| / max(|gradient|_inf, tiny) */
    size_t worst_entry;      /* where */
    double worst_gradient;   /* the entry, by reverse mode */
    double worst_difference; /* the entry, by differences */
    double dot_error;        /* relative error of gradient . direction against differences */
} ad_check;

/* Compare a gradient with central differences of sixth order in each of `entries` coordinates
 * (0: all; otherwise evenly spread), and along one seeded random direction (dot-product test).
 * x is [count], restored on return. step: relative to max(1, |x_i|). */
ad_status ad_check_gradient(ad_function function, void *context, double *x, size_t count,
                            size_t entries, double step, ad_check *check, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
