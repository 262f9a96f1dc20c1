/* The table of operations, one test for all: every operation enters by itself. Values of all kernel
 * sets against ad_op_evaluate, derivatives by both transforms against differences and each other,
 * all combinations of uniform, batch and repeated operands, for every instruction set that the
 * processor has. */
#include "ad_testing.h"
#include "fewer.h"
#include "kernel_sets.h"

/* libmvec: at most 4 units in the last place; ad_op_evaluate's libm: 1. */
#define LIBRARY_ULPS 5.0

enum { POINTS = 11, ORDER = 4, ARGUMENTS = 4 };

/* ---- what an operation needs --------------------------------------------------------------------
 */

typedef struct hint {
    double low, high; /* arguments */
    int whole;        /* attributes */
    double number;
} hint;

/* Only where the default does not do: away from poles, branch points and jumps. An operation may
 * have several rows: every branch, every attribute that has a rule of its own. */
static const struct {
    int op;
    hint hint;
} hints[] = {
    {OP_LOG, {.low = 0.5, .high = 2}},
    {OP_SQRT, {.low = 0.5, .high = 2}},
    {OP_POWER, {.low = 0.5, .high = 2, .number = 2.7}},
    {OP_POWER, {.low = 0.7, .high = 2, .number = -1.5}},
    {OP_POWER, {.low = -2, .high = 2, .number = 3}},
    {OP_RECIPROCAL, {.low = 0.7, .high = 2}},
    {OP_RECIPROCAL, {.low = -2, .high = -0.7}},
    {OP_RECIPROCAL_OR_ZERO, {.low = 0.7, .high = 2}},
    {OP_RECIPROCAL_OR_ZERO, {.low = -2, .high = -0.7}},
    {OP_ABS, {.low = 0.3, .high = 2}},
    {OP_ABS, {.low = -2, .high = -0.3}},
    {OP_SIGN, {.low = 0.3, .high = 2}},
    {OP_SIGN, {.low = -2, .high = -0.3}},
    {OP_ATAN2, {.low = 0.5, .high = 2}},
    {OP_ATAN2, {.low = -2, .high = -0.5}},
    {OP_STUMPFF, {.low = -3, .high = 3, .whole = 0}},
    {OP_STUMPFF, {.low = -3, .high = 3, .whole = 1}},
    {OP_STUMPFF, {.low = -3, .high = 3, .whole = 2}},
    {OP_STUMPFF, {.low = 3, .high = 30, .whole = 3}},
    {OP_STUMPFF, {.low = -30, .high = -3, .whole = 4}},
    {OP_SCALED_MUL, {.low = -2, .high = 2, .number = -2.5}},
    {OP_SCALED_MUL_ADD, {.low = -2, .high = 2, .number = -2.5}},
    {OP_SCALED_MUL_SUB, {.low = -2, .high = 2, .number = 0.3}},
    {OP_PAIR_ADD, {.low = -2, .high = 2, .number = -2.5}},
    {OP_PAIR_SUB, {.low = -2, .high = 2, .number = 1}},
    {OP_SELECT, {.low = 0.3, .high = 2}},
    {OP_SELECT, {.low = -2, .high = -0.3}},
};

/* The `number`-th hint for an operation; the default is the first of those without one. */
static bool find_hint(int op, int number, hint *found)
{
    int seen = 0;
    for (int i = 0; i < (int)(sizeof hints / sizeof *hints); i++) {
        if (hints[i].op == op && seen++ == number) {
            *found = hints[i].hint;
            return true;
        }
    }
    *found = (hint){.low = -1.4, .high = 1.4};
    return seen == 0 && number == 0;
}

static bool only_in_programs(int op)
{
    return op >= OP_MUL_ADD && op <= OP_COPY;
}

static bool is_leaf(int op)
{
    return op <= OP_POINTS;
}

static int arity_of(int op)
{
    return ad_op_table[op].arity == AD_ARITY_ANY ? 3 : ad_op_table[op].arity;
}

/* Rows of argument i; elementwise: 3, or 1 where `single` has the bit. Fails for operations of
 * unknown shape. */
static int rows_of(int op, int i, unsigned single)
{
    if (op == OP_REPEAT)
        return 1;
    if (op_is_elementwise(op))
        return single >> i & 1 ? 1 : 3;
    switch (op) {
    case OP_SLICE:
    case OP_PAD:
    case OP_SUM_ROWS:
    case OP_SUM_POINTS:
        return 4;
    case OP_STACK:
        return 1 + i;
    case OP_MATVEC: /* 2 x 3 */
        return i == 0 ? 6 : 3;
    case OP_MATVEC_TRANSPOSED:
        return i == 0 ? 6 : 2;
    case OP_OUTER:
    case OP_OUTER_SUM:
        return 2 + i;
    default:
        fail_msg("%s: an operation the test knows no shapes for", ad_op_table[op].name);
        return 0;
    }
}

static ad_value record_op(ad_tape *tape, int op, const hint *h, int count, const ad_value *x)
{
    int rows = op == OP_SLICE ? 2 : op == OP_PAD ? 7 : op == OP_REPEAT ? 4 : 0;
    int whole = op == OP_SLICE || op == OP_PAD ? 1 : h->whole;
    return ad_tape_record(tape, op, count, x, whole, h->number, rows);
}

/* ---- the table itself ---------------------------------------------------------------------------
 */

static void test_every_operation_has_its_rules(void **state)
{
    (void)state;
    const kernel_set *sets[KERNEL_SETS_MAX];
    int count = kernel_sets(sets);
    for (int op = 0; op < OP_COUNT; op++) {
        const op_row *row = &ad_op_table[op];
        assert_non_null(row->name);
        if (row->kind == LEAF)
            assert_true(is_leaf(op) || only_in_programs(op));
        if (ad_op_table[op].kind == SMOOTH)
            assert_non_null(row->partial);
        if (row->kind == LINEAR || row->kind == BILINEAR)
            assert_non_null(row->adjoint);
        for (int k = 0; k < count && op_is_elementwise(op); k++) {
            int masks = (1 << row->arity) - (row->arity > 1); /* all uniform: not at points */
            for (int mask = 0; mask < masks; mask++)
                assert_non_null(sets[k]->loops[op][mask]);
        }
    }
}

/* ---- kernels ------------------------------------------------------------------------------------
 */

static const double special[] = {0.0,
                                 -0.0,
                                 INFINITY,
                                 -INFINITY,
                                 NAN,
                                 DBL_MIN,
                                 -DBL_MIN,
                                 5e-324,
                                 -5e-324,
                                 1e-310,
                                 1e308,
                                 -1e308,
                                 DBL_MAX,
                                 1e-200,
                                 1,
                                 -1,
                                 0.5,
                                 -0.5,
                                 1e5,
                                 -1e5,
                                 709.7,
                                 -709.7,
                                 745.2,
                                 -745.2,
                                 1e16,
                                 -1e16,
                                 1e22,
                                 3.14159265358979,
                                 -3.14159265358979,
                                 1.5707963,
                                 DBL_MAX,
                                 -DBL_MAX,
                                 1 - 1e-16,
                                 1 + 3e-16,
                                 1e-8,
                                 -1e-8,
                                 20,
                                 -20,
                                 6,
                                 -6,
                                 0.25,
                                 -0.25,
                                 2.225e-308,
                                 36.04365,
                                 19.0615};

/* What the function of the library may be off, and fused or not fused products. */
static double allowed(int op, const double *x, double number, double expected)
{
    double ulp = fmax(fabs(expected) * DBL_EPSILON, 5e-324);
    switch (op) {
    case OP_TANH:
    case OP_SIN:
    case OP_COS:
    case OP_EXP:
    case OP_LOG:
    case OP_ERF:
    case OP_POWER:
    case OP_ATAN2:
        return LIBRARY_ULPS * ulp;
    case OP_MUL_ADD:
    case OP_MUL_SUB:
    case OP_SUB_MUL: /* the product rounded or not */
        return ulp + DBL_EPSILON * fabs(x[0] * x[1]);
    case OP_SCALED_MUL_ADD:
    case OP_SCALED_MUL_SUB:
        return ulp + DBL_EPSILON * fabs(number * (x[0] * x[1]));
    case OP_PAIR_ADD:
    case OP_PAIR_SUB: /* either product rounded or not */
        return ulp + DBL_EPSILON * (fabs(number * (x[0] * x[1])) + fabs(x[2] * x[3]));
    case OP_TANH_SUM:
        return LIBRARY_ULPS * ulp;
    default:
        return 0;
    }
}

static bool agrees(int op, const double *x, double number, double value, double expected)
{
    bool fused = op >= OP_MUL_ADD && op < OP_TANH_SUM;
    double product = op_is_scaled(op) ? number * (x[0] * x[1]) : x[0] * x[1];
    if (fused && isinf(product) && isfinite(x[0]) && isfinite(x[1]))
        return true; /* overflow before the sum, in one of the two */
    bool pair = op == OP_PAIR_ADD || op == OP_PAIR_SUB;
    if (pair && isinf(x[2] * x[3]) && isfinite(x[2]) && isfinite(x[3]))
        return true;
    if (isnan(expected) || isnan(value))
        return isnan(expected) && isnan(value);
    if (value == expected)
        return true;
    return fabs(value - expected) <= allowed(op, x, number, expected);
}

enum { WIDTH = 64, HEIGHT = 2 };

/* Two rows of 64 points (the first specials, the second random), operands uniform as in `mask`. */
static void check_kernel(const kernel_set *set, int op, const hint *h, unsigned mask,
                         uint64_t *random, bool specials)
{
    static _Alignas(64) double in[ARGUMENTS][HEIGHT * WIDTH], out[HEIGHT * WIDTH];
    int specials_count = (int)(sizeof special / sizeof *special);
    kernel_operand x[ARGUMENTS];
    for (int i = 0; i < ARGUMENTS; i++) {
        bool uniform = mask >> i & 1;
        for (int k = 0; k < HEIGHT * WIDTH; k++)
            in[i][k] = specials ? special[random_below(random, specials_count)]
                                : random_in(random, h->low, h->high);
        for (int k = 0; k < specials_count && specials && i == 0; k++)
            in[i][k] = special[k];
        x[i] = (kernel_operand){in[i], uniform ? 1 : WIDTH};
    }
    memset(out, 0, sizeof out);
    set->loops[op][mask](HEIGHT, WIDTH, out, WIDTH, x, h->whole, h->number);
    for (int row = 0; row < HEIGHT; row++) {
        for (int j = 0; j < WIDTH; j++) {
            double at[ARGUMENTS];
            for (int i = 0; i < ARGUMENTS; i++)
                at[i] = mask >> i & 1 ? in[i][row] : in[i][row * WIDTH + j];
            double expected = ad_op_evaluate(op, h->whole, h->number, at);
            double value = out[row * WIDTH + j];
            if (!agrees(op, at, h->number, value, expected))
                fail_msg("%s, %s, mask %u: (%.17g, %.17g, %.17g) gives %.17g, not %.17g", set->name,
                         ad_op_table[op].name, mask, at[0], at[1], at[2], value, expected);
        }
    }
}

static void check_kernels_of(const kernel_set *set, int op, const hint *h, uint64_t *random)
{
    int arity = ad_op_table[op].arity;
    hint wide = *h;
    wide.low = -50;
    wide.high = 50;
    for (unsigned mask = 0; mask < (1u << arity) - (arity > 1); mask++) {
        check_kernel(set, op, h, mask, random, false);
        check_kernel(set, op, &wide, mask, random, false);
        for (int repeat = 0; repeat < 20; repeat++)
            check_kernel(set, op, h, mask, random, true);
    }
}

static void test_kernels(void **state)
{
    (void)state;
    const kernel_set *sets[KERNEL_SETS_MAX];
    uint64_t random = 5;
    int count = kernel_sets(sets);
    for (int op = OP_ADD; op < OP_ELEMENTWISE_END; op++) {
        hint h;
        for (int number = 0; find_hint(op, number, &h); number++)
            for (int k = 0; k < count; k++)
                check_kernels_of(sets[k], op, &h, &random);
    }
}

/* ---- derivatives --------------------------------------------------------------------------------
 */

/* One operation on a tape, with what its derivatives need. */
typedef struct bench {
    ad_tape *tape;
    int op, count;
    const hint *hint;
    ad_value tau;               /* uniform: arguments move along a_i + tau b_i + tau^2 c_i */
    ad_value x[ARGUMENTS];      /* leaves */
    ad_value v[ARGUMENTS];      /* leaves of the same shape: directions */
    ad_value y;                 /* of x */
    ad_value moving[ORDER + 1]; /* Taylor coefficients in tau */
    ad_value push;              /* J v */
    ad_value weight;            /* a leaf of the shape of y */
    ad_value root;              /* weight . y, summed over points */
    ad_value pull[ARGUMENTS];   /* J^T weight */
    ad_value rows[ARGUMENTS];   /* the same per point, where that is possible */
    bool per_point;
    ad_value high_push; /* the same two of the third coefficient of `moving` */
    ad_value high_pull[ARGUMENTS];
    run_data data;
    uint64_t random;
} bench;

static ad_value leaf(ad_tape *tape, bool uniform, int rows)
{
    return uniform ? ad_uniform(tape, "leaf", rows) : ad_input(tape, "leaf", rows);
}

static void bench_move(bench *b, unsigned mask)
{
    ad_value moved[ARGUMENTS];
    for (int i = 0; i < b->count; i++) {
        int rows = ad_rows(b->x[i]);
        ad_value first = leaf(b->tape, mask >> i & 1, rows);
        ad_value second = leaf(b->tape, mask >> i & 1, rows);
        ad_value small = ad_scalar(b->tape, 0.25); /* stay within the domain */
        ad_value path = ad_add(ad_mul(b->tau, first), ad_mul(ad_square(b->tau), second));
        moved[i] = ad_add(b->x[i], ad_mul(small, path));
    }
    ad_value y = record_op(b->tape, b->op, b->hint, b->count, moved);
    ad_taylor(1, &y, b->tau, ad_scalar(b->tape, 1), ORDER, b->moving);
}

/* The derivative of a coefficient, along the directions and backwards. */
static void bench_high(bench *b)
{
    ad_value high = b->moving[3], coefficients[2];
    for (int i = 0; i < b->count; i++) {
        ad_taylor(1, &high, b->x[i], b->v[i], 1, coefficients);
        b->high_push = i == 0 ? coefficients[1] : ad_add(b->high_push, coefficients[1]);
    }
    ad_reverse(ad_dot(b->weight, high), b->count, b->x, AD_SUMMED, b->high_pull);
}

static void bench_begin(bench *b, int op, const hint *h, unsigned mask, unsigned single)
{
    *b = (bench){.tape = ad_tape_create(), .op = op, .hint = h, .random = 3};
    b->count = arity_of(op);
    b->tau = ad_uniform(b->tape, "tau", 1);
    for (int i = 0; i < b->count; i++) {
        b->x[i] = leaf(b->tape, mask >> i & 1, rows_of(op, i, single));
        b->v[i] = leaf(b->tape, mask >> i & 1, rows_of(op, i, single));
    }
    b->y = record_op(b->tape, op, h, b->count, b->x);
    for (int i = 0; i < b->count; i++) {
        ad_value coefficients[2];
        ad_taylor(1, &b->y, b->x[i], b->v[i], 1, coefficients);
        b->push = i == 0 ? coefficients[1] : ad_add(b->push, coefficients[1]);
    }
    b->weight = leaf(b->tape, ad_extent_of(b->y) == AD_UNIFORM, ad_rows(b->y));
    b->root = ad_dot(b->weight, b->y);
    ad_reverse(b->root, b->count, b->x, AD_SUMMED, b->pull);
    bench_move(b, mask);
    bench_high(b);
    b->per_point = ad_extent_of(b->y) == AD_BATCH;
    if (b->per_point)
        ad_reverse(b->root, b->count, b->x, AD_PER_POINT, b->rows);
    assert_tape_ok(b->tape);
    data_fill(&b->data, b->tape, POINTS, h->low, h->high, &b->random);
    b->data.uniform[0][0] = 0; /* tau */
}

static void bench_end(bench *b)
{
    data_free(&b->data);
    ad_tape_free(b->tape);
}

static double *leaf_numbers(bench *b, ad_value x, size_t *count)
{
    const node *n = node_of(x);
    *count = (size_t)n->rows * (n->op == OP_INPUT ? POINTS : 1);
    return n->op == OP_INPUT ? b->data.input[n->whole] : b->data.uniform[n->whole];
}

/* a . b over rows and points; either may be uniform. */
static double dot_of(const naive *n, ad_value a, ad_value b, double *size)
{
    bool batch = ad_extent_of(a) == AD_BATCH || ad_extent_of(b) == AD_BATCH;
    double sum = 0;
    *size = 0;
    for (int row = 0; row < ad_rows(a); row++) {
        for (size_t j = 0; j < (batch ? POINTS : 1); j++) {
            double term = naive_at(n, a.id, row, j) * naive_at(n, b.id, row, j);
            sum += term;
            *size += fabs(term);
        }
    }
    return sum;
}

static double root_sum(bench *b)
{
    naive n = naive_run(b->tape, &b->data);
    double sum = 0;
    for (size_t j = 0; j < (ad_extent_of(b->root) == AD_BATCH ? POINTS : 1); j++)
        sum += naive_at(&n, b->root.id, 0, j);
    naive_free(&n);
    return sum;
}

static const double six[3] = {45, -9, 1}; /* central differences of sixth order, over 60 h */

/* <weight, J v> = <J^T weight, v>: two independent ways through the rules; rounding alone. */
static void check_adjoint(bench *b, const naive *n, ad_value push, const ad_value *pull)
{
    double left_size, left = dot_of(n, b->weight, push, &left_size), right = 0;
    for (int i = 0; i < b->count; i++) {
        double size;
        right += dot_of(n, pull[i], b->v[i], &size);
    }
    assert_near(right, left, 1e-12 * (1 + left_size));
}

/* Rows of a Jacobian add up to the gradient. */
static void check_rows(bench *b, const naive *n)
{
    for (int i = 0; i < b->count && b->per_point; i++) {
        bool summed = ad_extent_of(b->x[i]) == AD_UNIFORM;
        for (int row = 0; row < ad_rows(b->x[i]); row++) {
            double sum = 0;
            for (size_t j = 0; j < POINTS; j++) {
                sum = summed ? sum : 0;
                sum += naive_at(n, b->rows[i].id, row, j);
                if (!summed || j + 1 == POINTS)
                    assert_near(sum, naive_at(n, b->pull[i].id, row, j), 1e-13 * (1 + fabs(sum)));
            }
        }
    }
}

/* The adjoint of each argument along a direction. Truncation h^6 f^(7) / 140 < 1e-12 and rounding
 * 1e-15 / h for sums of some ten terms. */
static void check_differences(bench *b, const naive *n)
{
    double step = 2e-3;
    for (int i = 0; i < b->count; i++) {
        size_t count, v_count;
        double *x = leaf_numbers(b, b->x[i], &count), sum = 0, size;
        const double *v = leaf_numbers(b, b->v[i], &v_count);
        for (int k = -3; k <= 3; k++) {
            for (size_t e = 0; e < count && k; e++)
                x[e] += k * step * v[e];
            sum += k ? (k > 0 ? 1 : -1) * six[abs(k) - 1] * root_sum(b) : 0;
            for (size_t e = 0; e < count && k; e++)
                x[e] -= k * step * v[e];
        }
        double pull = dot_of(n, b->pull[i], b->v[i], &size);
        assert_near(sum / (60 * step), pull, 2e-10 * (1 + size));
    }
}

/* c_k(tau): k c_k is the derivative of c_(k-1). */
static void check_coefficients(bench *b, const naive *n)
{
    double step = 5e-3; /* the path is slow, so are the coefficients: h^6 f^(7) / 140 < 1e-11 */
    naive sides[7];
    for (int k = -3; k <= 3; k++) {
        b->data.uniform[0][0] = k * step;
        sides[k + 3] = naive_run(b->tape, &b->data);
    }
    b->data.uniform[0][0] = 0;
    for (int order = 1; order <= ORDER; order++) {
        int id = b->moving[order].id, below = b->moving[order - 1].id;
        bool batch = ad_extent_of(b->y) == AD_BATCH;
        for (int row = 0; row < ad_rows(b->y); row++) {
            for (size_t j = 0; j < (batch ? POINTS : 1); j++) {
                double sum = 0;
                for (int k = 1; k <= 3; k++)
                    sum += six[k - 1] * (naive_at(&sides[3 + k], below, row, j) -
                                         naive_at(&sides[3 - k], below, row, j));
                double expected = sum / (60 * step * order);
                assert_near(naive_at(n, id, row, j), expected, 1e-9 * (1 + fabs(expected)));
            }
        }
    }
    for (int k = 0; k < 7; k++)
        naive_free(&sides[k]);
}

/* Every number above by compiled programs of all kernel sets. */
static void check_programs(bench *b, const naive *n)
{
    ad_value values[16] = {b->y, b->push, b->root};
    int count = 3;
    const kernel_set *sets[KERNEL_SETS_MAX];
    for (int i = 0; i < b->count; i++)
        values[count++] = b->pull[i];
    for (int i = 0; i < b->count; i++)
        values[count++] = b->high_pull[i];
    for (int k = 0; k <= ORDER; k++)
        values[count++] = b->moving[k];
    int set_count = kernel_sets(sets);
    for (int k = 0; k < set_count; k++) {
        chosen_kernels = sets[k];
        compiled c = run_compiled(count, values, NULL, 1, &b->data);
        /* 5 units in the last place, some ten operations deep */
        assert_near(compiled_error(&c, values, n), 0, 5e-14);
        compiled_free(&c);
    }
    chosen_kernels = NULL;
}

static void check_op(int op, const hint *h, unsigned mask, unsigned single)
{
    bench b;
    bench_begin(&b, op, h, mask, single);
    if (node_of(b.y)->op != op && op != OP_OUTER_SUM && op != OP_SUM_POINTS)
        fail_msg("%s simplified to %s: not tested", ad_op_table[op].name,
                 ad_op_table[node_of(b.y)->op].name);
    naive n = naive_run(b.tape, &b.data);
    check_adjoint(&b, &n, b.push, b.pull);
    check_adjoint(&b, &n, b.high_push, b.high_pull);
    check_rows(&b, &n);
    check_differences(&b, &n);
    check_coefficients(&b, &n);
    check_programs(&b, &n);
    naive_free(&n);
    bench_end(&b);
}

static void test_derivatives(void **state)
{
    (void)state;
    for (int op = 0; op < OP_COUNT; op++) {
        if (is_leaf(op) || only_in_programs(op) || op == OP_SPREAD) /* test_members */
            continue;
        unsigned all = 1u << arity_of(op);
        unsigned repeats = op_is_elementwise(op) && op != OP_REPEAT ? all : 1;
        hint h;
        for (int number = 0; find_hint(op, number, &h); number++)
            for (unsigned mask = 0; mask < all; mask++)
                for (unsigned single = 0; single < repeats; single++)
                    check_op(op, &h, mask, single);
    }
}

/* ---- panels ----------------------------------------------------------------------------------
 */

/* Products, combinations and triangular solves of panels, by every kernel set, against plain loops.
 */
static void check_panels(const kernel_set *set)
{
    enum { DEPTH = 13 };
    _Alignas(64) double a[DEPTH * PANEL], b[DEPTH * PANEL], c[TILE], u[TILE], out[DEPTH * PANEL];
    uint64_t seed = 3;
    for (int i = 0; i < DEPTH * PANEL; i++) {
        a[i] = random_in(&seed, -1, 1);
        b[i] = random_in(&seed, -1, 1);
    }
    for (int i = 0; i < TILE; i++) {
        c[i] = random_in(&seed, -1, 1);
        u[i] = i % PANEL < i / PANEL ? (double)NAN : random_in(&seed, 1, 2) / (1 + i % PANEL);
    }
    double before[TILE], added[TILE] __attribute__((aligned(64))), x[TILE];
    memcpy(before, c, sizeof c);
    memcpy(added, c, sizeof c);
    set->products->multiply_panels(DEPTH, a, b, false, added);
    set->products->multiply_panels(DEPTH, a, b, true, c);
    memcpy(x, c, sizeof c);
    set->products->solve_tile(u, c);
    const double *by[2] = {a, b}, *of[2] = {b, a};
    set->products->combine_panels(2, DEPTH, by, of, out);
    for (int i = 0; i < PANEL; i++) {
        for (int j = 0; j < PANEL; j++) {
            double sum = 0, product = 0, size = 0;
            for (int k = 0; k < DEPTH; k++) {
                sum += a[k * PANEL + i] * b[k * PANEL + j];
            }
            for (int k = 0; k <= i; k++) {
                product += u[k * PANEL + i] * c[k * PANEL + j];
                size += fabs(u[k * PANEL + i] * c[k * PANEL + j]);
            }
            /* orders of summing and rounding of some 13 and 24 products */
            assert_true(fabs(x[i * PANEL + j] - (before[i * PANEL + j] - sum)) <= 1e-14);
            assert_true(fabs(added[i * PANEL + j] - (before[i * PANEL + j] + sum)) <= 1e-14);
            assert_true(fabs(product - x[i * PANEL + j]) <= 1e-14 * size);
        }
        for (int k = 0; k < DEPTH; k++) {
            double expected = a[k] * b[k * PANEL + i] + b[k] * a[k * PANEL + i];
            assert_true(fabs(out[k * PANEL + i] - expected) <= 1e-15);
        }
    }
}

static void test_panels(void **state)
{
    (void)state;
    const kernel_set *sets[KERNEL_SETS_MAX];
    for (int i = kernel_sets(sets) - 1; i >= 0; i--) {
        check_panels(sets[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_operation_has_its_rules),
        cmocka_unit_test(test_kernels),
        cmocka_unit_test(test_panels),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_derivatives)};
    return run_with_alike(tests, alike, NULL, NULL);
}
