/* For tests of the engine: tapes that grow by chance, of all kinds of operations. */
#ifndef TESTS_RANDOM_GRAPHS_H
#define TESTS_RANDOM_GRAPHS_H

#include "ad_testing.h"

enum { POOL_MAX = 200, OUTPUTS = 10, WIDTHS = 6 };

static const int widths[WIDTHS] = {1, 2, 3, 4, 6, 9};

/* Values of members: none; some inputs have one block per member; the same inputs per point; with
 * sums over members and over the points of each as well. */
typedef enum garden_kind { PLAIN, MEMBERS, MEMBERS_PER_POINT, MEMBERS_AND_SUMS } garden_kind;

typedef struct garden {
    ad_tape *tape;
    garden_kind kind;
    ad_value variables[3]; /* inputs: 1, 2 and 3 rows; with members the first and last are theirs */
    ad_value member_matrix; /* 2 x 3 */
    uint64_t random;
    ad_value values[POOL_MAX];
    int count;
    ad_value matrices[4]; /* 6 x 6, 9 x 6, 6 x 9, 6 x 6 */
} garden;

static inline void plant(garden *g, ad_value x)
{
    assert_tape_ok(g->tape);
    if (g->count < POOL_MAX && ad_rows(x) <= 54)
        g->values[g->count++] = x;
}

/* A value of `rows` rows, a recent one more likely. */
static inline ad_value pick(garden *g, int rows)
{
    for (int attempt = 0; attempt < 40; attempt++) {
        int window = attempt < 20 && g->count > 12 ? 12 : g->count;
        ad_value x = g->values[g->count - 1 - random_below(&g->random, window)];
        if (ad_rows(x) == rows)
            return x;
    }
    return ad_repeat(ad_sum_rows(ad_tanh(g->values[random_below(&g->random, g->count)])), rows);
}

static inline ad_value pick_any(garden *g)
{
    return g->values[random_below(&g->random, g->count)];
}

static inline int random_width(garden *g)
{
    return widths[random_below(&g->random, WIDTHS)];
}

static inline ad_value grow_elementwise(garden *g)
{
    int rows = random_width(g);
    ad_value a = pick(g, rows), b = random_below(&g->random, 4) ? pick(g, rows) : pick(g, 1);
    ad_value one = ad_scalar(g->tape, 1);
    switch (random_below(&g->random, 16)) {
    case 0:
        return ad_add(a, b);
    case 1:
        return ad_sub(b, a);
    case 2:
        return ad_tanh(ad_add(ad_mul(a, b), pick(g, rows)));
    case 3:
        return ad_tanh(ad_sub(ad_mul(a, b), pick(g, rows)));
    case 4:
        return ad_tanh(ad_sub(pick(g, rows), ad_mul(a, b)));
    case 5:
        return ad_sin(a);
    case 6:
        return ad_mul(ad_cos(a), ad_tanh(b));
    case 7:
        return ad_div(ad_tanh(a), ad_add(one, ad_square(b)));
    case 8:
        return ad_sqrt(ad_add(one, ad_square(ad_tanh(a))));
    case 9:
        return ad_atan2(a, ad_add(ad_scalar(g->tape, 2), ad_tanh(b)));
    case 10:
        return ad_add(ad_abs(a), ad_tanh(b));
    case 11:
        return ad_stumpff(random_below(&g->random, 5), ad_tanh(a));
    case 12:
        return ad_max(ad_tanh(a), ad_tanh(b));
    case 13:
        return ad_scale(ad_tanh(a), random_in(&g->random, -2, 2));
    case 14:
        return ad_exp(ad_neg(ad_square(a)));
    default:
        return ad_log(ad_add(one, ad_abs(a)));
    }
}

static inline ad_value grow_rows(garden *g)
{
    ad_value a = pick_any(g), b = pick_any(g);
    int rows = ad_rows(a), first = random_below(&g->random, rows);
    switch (random_below(&g->random, 8)) {
    case 0:
        return ad_slice(a, first, 1 + random_below(&g->random, rows - first));
    case 1:
        return ad_stack(2, (ad_value[]){ad_tanh(a), b});
    case 2:
        return ad_stack(4, (ad_value[]){pick(g, 1), pick(g, 2), ad_sin(pick(g, 1)), pick(g, 2)});
    case 3:
        return ad_pad(a, first, rows + first + random_below(&g->random, 3));
    case 4:
        return ad_repeat(pick(g, 1), random_width(g));
    case 5:
        return ad_tanh(ad_sum_rows(a));
    case 6:
        return ad_tanh(ad_dot(pick(g, 3), pick(g, 3)));
    default:
        return ad_stack(5, (ad_value[]){pick(g, 2), pick(g, 1), ad_square(ad_tanh(pick(g, 1))),
                                        pick(g, 1), pick(g, 1)});
    }
}

static inline ad_value grow_product(garden *g)
{
    ad_value w = g->matrices[random_below(&g->random, 4)];
    ad_value six = pick(g, 6), nine = pick(g, 9);
    switch (random_below(&g->random, 9)) {
    case 0:
    case 1:
        return ad_tanh(ad_matvec(g->matrices[0], six));
    case 2:
        return ad_tanh(ad_matvec(g->matrices[1], six));
    case 3:
        return ad_matvec(g->matrices[2], ad_tanh(nine));
    case 4:
        return ad_tanh(ad_matvec_transposed(g->matrices[1], nine));
    case 5:
        return ad_tanh(ad_matvec_transposed(w, ad_rows(w) == 36            ? six
                                               : w.id == g->matrices[1].id ? nine
                                                                           : six));
    case 6: /* a matrix of its own at every point */
        return ad_tanh(ad_matvec(ad_outer(pick(g, 2), pick(g, 3)), ad_tanh(pick(g, 3))));
    case 7:
        return ad_tanh(ad_matvec_transposed(ad_outer(pick(g, 4), pick(g, 2)), pick(g, 4)));
    default:
        return ad_outer(ad_tanh(pick(g, 3)), ad_tanh(pick(g, 2)));
    }
}

/* A matrix of each member. */
static inline ad_value grow_member_product(garden *g)
{
    return random_below(&g->random, 2)
               ? ad_tanh(ad_matvec(g->member_matrix, pick(g, 3)))
               : ad_tanh(ad_matvec_transposed(g->member_matrix, pick(g, 2)));
}

static inline ad_value grow_geometry(garden *g)
{
    ad_value u = pick(g, 3), v = pick(g, 3), q = ad_quaternion_exp(ad_tanh(v));
    switch (random_below(&g->random, 4)) {
    case 0:
        return ad_tanh(ad_cross(u, v));
    case 1:
        return ad_rotate(q, ad_tanh(u));
    case 2:
        return ad_quaternion_multiply(q, ad_tanh(pick(g, 4)));
    default:
        return ad_cross(u, ad_vector_constant(g->tape, 0, 0, 1));
    }
}

/* Sums over points divided by their number, so that they stay near 1 (1 + n: n may be 0). */
static inline ad_value grow_sum(garden *g)
{
    ad_value scale = ad_reciprocal(ad_add(ad_points(g->tape), ad_scalar(g->tape, 1)));
    ad_value sum;
    switch (random_below(&g->random, 3)) {
    case 0:
        sum = ad_sum_points(pick_any(g));
        break;
    case 1:
        sum = ad_sum_points(ad_outer(ad_tanh(pick(g, 2)), ad_tanh(pick(g, 3))));
        break;
    default:
        sum = ad_add(ad_sum_points(ad_outer(ad_tanh(pick(g, 2)), ad_tanh(pick(g, 3)))),
                     ad_sum_points(ad_outer(ad_sin(pick(g, 2)), ad_tanh(pick(g, 3)))));
    }
    return ad_tanh(ad_mul(scale, sum));
}

static inline ad_value grow_member_sum(garden *g)
{
    ad_value scale = ad_reciprocal(ad_add(ad_points_of_member(g->tape), ad_scalar(g->tape, 1)));
    ad_value sum = random_below(&g->random, 2)
                       ? ad_sum_points_of_member(pick_any(g))
                       : ad_sum_points_of_member(ad_outer(pick(g, 3), ad_tanh(pick(g, 2))));
    sum = ad_tanh(ad_mul(scale, sum));
    if (random_below(&g->random, 3) == 0 && ad_extent_of(sum) != AD_BATCH)
        sum = ad_tanh(ad_div(ad_sum_members(sum), ad_members(g->tape)));
    return sum;
}

static inline void grow(garden *g, int operations, bool sums)
{
    for (int i = 0; i < operations; i++) {
        int kind = random_below(&g->random, 20);
        bool of_member = g->kind != PLAIN && random_below(&g->random, 12) == 0;
        plant(g, of_member                     ? grow_member_product(g)
                 : kind < 9                    ? grow_elementwise(g)
                 : kind < 12                   ? grow_rows(g)
                 : kind < 17                   ? grow_product(g)
                 : kind < 19 || !sums          ? grow_geometry(g)
                 : g->kind == MEMBERS_AND_SUMS ? grow_member_sum(g)
                                               : grow_sum(g));
    }
}

/* Inputs of members, and what follows from them alone. */
static inline void plant_members(garden *g, int operations)
{
    ad_value (*input)(ad_tape *, const char *, int) =
        g->kind == MEMBERS_PER_POINT ? ad_input : ad_input_member;
    plant(g, g->variables[0] = input(g->tape, "member", 1));
    plant(g, g->variables[2] = input(g->tape, "member", 3));
    plant(g, input(g->tape, "member", 6));
    g->member_matrix = input(g->tape, "member matrix", 6);
    grow(g, operations, false);
}

static inline void garden_plant_members(garden *g, uint64_t seed, int operations, bool sums,
                                        garden_kind kind)
{
    *g = (garden){.tape = ad_tape_create(), .random = seed, .kind = kind};
    ad_value all = ad_parameter(g->tape, "all", 54 + 54 + 72, 0);
    g->matrices[0] = ad_slice(all, 0, 36);
    g->matrices[1] = ad_slice(all, 36, 54);
    g->matrices[2] = ad_parameter(g->tape, "matrix", 54, 300);
    g->matrices[3] = ad_tanh(ad_parameter(g->tape, "matrix", 36, 400));
    plant(g, ad_parameter(g->tape, "offset", 6, 500));
    plant(g, ad_slice(all, 90, 9));
    ad_sum_rows(g->matrices[2]); /* some graphs differentiate by a matrix that they do not need */
    plant(g, ad_uniform(g->tape, "scalar", 1));
    plant(g, ad_uniform(g->tape, "vector", 3));
    if (kind != PLAIN)
        plant_members(g, operations / 2);
    for (int i = 0; i < WIDTHS; i++) {
        ad_value x = ad_input(g->tape, "input", widths[i]);
        plant(g, x);
        if (i < 3 && (kind == PLAIN || i == 1))
            g->variables[i] = x;
    }
    plant(g, ad_constant(g->tape, 3, (double[]){1, 0, -1}));
    grow(g, operations, sums);
}

static inline void garden_plant(garden *g, uint64_t seed, int operations, bool sums)
{
    garden_plant_members(g, seed, operations, sums, PLAIN);
}

/* Some values, a Taylor coefficient and a gradient; with members last those by two inputs of
 * theirs. */
static inline int garden_outputs(garden *g, ad_value *outputs)
{
    int count = 0;
    for (; count < 3; count++)
        outputs[count] = g->values[g->count - 1 - count * count];
    ad_value input = g->variables[random_below(&g->random, 3)];
    ad_value coefficients[4];
    int order = 1 + random_below(&g->random, 3);
    ad_value last = ad_tanh(ad_sum_rows(outputs[0]));
    if (ad_taylor(1, &last, input, ad_scalar(g->tape, 0.5), order, coefficients) == AD_OK)
        outputs[count++] = coefficients[order];
    ad_value loss = ad_sum_points(ad_add(ad_square(last), ad_square(coefficients[order])));
    ad_value wrt[2] = {ad_parameter(g->tape, "all", 54 + 54 + 72, 0),
                       ad_parameter(g->tape, "matrix", 54, 300)};
    if (ad_reverse(loss, 2, wrt, AD_SUMMED, outputs + count) == AD_OK)
        count += 2;
    /* the same derivative along one direction of the parameters, forwards and backwards */
    ad_value v = ad_uniform(g->tape, "v", ad_rows(wrt[0])), pushed[2];
    ad_value pulled = ad_dot(v, outputs[count - 2]);
    ad_taylor(1, &loss, wrt[0], v, 1, pushed);
    outputs[count++] = pulled;
    outputs[count++] = pushed[1];
    wrt[0] = g->variables[2];
    wrt[1] = g->member_matrix;
    if (g->kind != PLAIN && ad_reverse(loss, 2, wrt, AD_SUMMED, outputs + count) == AD_OK)
        count += 2;
    assert_tape_ok(g->tape);
    return count;
}

#endif
