/* The verifier can fail: programs are changed behind the compiler's back, one number at a time.
 * Whatever the verifier lets pass has to give the same results to the last bit. */
#include "ad_testing.h"

#include "verify.h"

enum { WIDTH = 9, POINTS = 45, MEMBERS = 9, OUTPUTS = 6 };

typedef struct subject {
    ad_tape *tape;
    ad_value outputs[OUTPUTS];
    run_data data;
    compiled c;
    double *results[OUTPUTS]; /* of the program as it was compiled */
    long tried, caught;
} subject;

/* A network with a stack, slices, panels of Taylor coefficients, a uniform, sums and two passes. */
static void record(subject *s)
{
    ad_tape *tape = s->tape;
    ad_value x = ad_input(tape, "x", 1), y = ad_input(tape, "y", 2);
    ad_value load = ad_uniform(tape, "load", 2);
    ad_value w1 = ad_parameter(tape, "w1", 3 * WIDTH, 0), b1 = ad_parameter(tape, "b1", WIDTH, 30);
    ad_value w2 = ad_parameter(tape, "w2", WIDTH * WIDTH, 40);
    ad_value w3 = ad_parameter(tape, "w3", 2 * WIDTH, 130);
    ad_value h = ad_tanh(ad_add(ad_matvec(w1, ad_stack(2, (ad_value[]){x, y})), b1));
    h = ad_tanh(ad_matvec(w2, ad_sin(h)));
    ad_value u = ad_matvec(w3, h), mean = ad_div(ad_sum_points(u), ad_points(tape));
    ad_value residual = ad_add(ad_sub(ad_derivative(u, x, 2), ad_mul(load, u)),
                               ad_mul(ad_sub(u, mean), ad_exp(ad_row(y, 1))));
    ad_value wrt[4] = {w1, w2, w3, load};
    s->outputs[0] = ad_sum_points(ad_dot(residual, residual));
    s->outputs[1] = ad_stack(2, (ad_value[]){ad_row(residual, 1), ad_row(u, 0)});
    ad_reverse(s->outputs[0], 4, wrt, AD_SUMMED, s->outputs + 2);
    assert_tape_ok(tape);
}

/* The same with coefficients of members, a matrix of each, and what each member's points add up to:
 * passes over members and points in turn. */
static void record_members(subject *s)
{
    ad_tape *tape = s->tape;
    ad_value x = ad_input(tape, "x", 1), m = ad_input_member(tape, "m", 2);
    ad_value w1 = ad_parameter(tape, "w1", 2 * WIDTH, 0);
    ad_value w2 = ad_parameter(tape, "w2", 6 * WIDTH, 40);
    ad_value h = ad_tanh(ad_matvec(w1, m)), c = ad_tanh(ad_matvec(w2, ad_add(h, ad_sin(h))));
    ad_value modes = ad_stack(3, (ad_value[]){x, ad_square(x), ad_sin(x)});
    ad_value u = ad_mul(ad_matvec(c, modes), ad_row(m, 1));
    ad_value mean = ad_tanh(ad_div(ad_sum_points_of_member(u), ad_points_of_member(tape)));
    ad_value residual = ad_add(ad_derivative(u, x, 1), ad_mul(ad_sub(u, mean), ad_row(h, 2)));
    s->outputs[0] = ad_add(ad_sum_points(ad_dot(residual, residual)), ad_sum_members(ad_row(c, 1)));
    s->outputs[1] = ad_stack(2, (ad_value[]){ad_row(residual, 1), ad_row(u, 0)});
    s->outputs[2] = mean;
    ad_reverse(s->outputs[0], 3, (ad_value[]){w1, w2, m}, AD_SUMMED, s->outputs + 3);
    assert_tape_ok(tape);
}

static int make(void **state, void (*record_subject)(subject *))
{
    static subject s;
    uint64_t random = 7;
    s = (subject){.tape = ad_tape_create()};
    record_subject(&s);
    data_fill_members(&s.data, s.tape, POINTS, MEMBERS, -1, 1, &random);
    ad_settings settings = {.tile = 16, .piece = 48, .fuse = true};
    s.c = run_compiled(OUTPUTS, s.outputs, &settings, 1, &s.data);
    for (int i = 0; i < OUTPUTS; i++) {
        s.results[i] = new_numbers(s.c.sizes[i]);
        memcpy(s.results[i], s.c.results[i], s.c.sizes[i] * sizeof(double));
    }
    assert_int_equal(ad_program_verify(s.c.program, NULL), AD_OK);
    *state = &s;
    return 0;
}

static int make_subject(void **state)
{
    return make(state, record);
}

static int make_member_subject(void **state)
{
    return make(state, record_members);
}

static int free_subject(void **state)
{
    subject *s = *state;
    compiled_free(&s->c);
    for (int i = 0; i < OUTPUTS; i++) {
        free(s->results[i]);
    }
    data_free(&s->data);
    ad_tape_free(s->tape);
    return 0;
}

/* Was the change caught? If not it must not matter. */
static bool judge(subject *s, const char *what, int number)
{
    s->tried++;
    if (ad_program_verify(s->c.program, NULL) != AD_OK) {
        s->caught++;
        return true;
    }
    compiled_execute(&s->c, s->outputs, &s->data);
    for (int i = 0; i < OUTPUTS; i++) {
        if (memcmp(s->c.results[i], s->results[i], s->c.sizes[i] * sizeof(double)) != 0) {
            fail_msg("%s %d passed and changed output %d", what, number, i);
        }
    }
    return false;
}

#define CHANGE(s, what, number, variable, value)                                                   \
    do {                                                                                           \
        const __typeof__(variable) before_ = (variable);                                           \
        (variable) = (value);                                                                      \
        judge(s, what, number);                                                                    \
        (variable) = before_;                                                                      \
    } while (0)

static pass *pass_of(const subject *s, int number)
{
    assert_true(number < s->c.program->pass_count);
    return &s->c.program->passes[number];
}

/* Every place of every instruction, moved by a unit, cut, or exchanged for that of a neighbour. */
static void test_places(void **state)
{
    subject *s = *state;
    s->tried = s->caught = 0;
    for (int k = 0; k < s->c.program->pass_count; k++) {
        pass *p = pass_of(s, k);
        for (int n = 0; n < p->count; n++) {
            instruction *i = &p->instructions[n], *next = &p->instructions[(n + 1) % p->count];
            for (int x = -1; x < ad_op_table[i->op].arity; x++) {
                place *at = x < 0 ? &i->out : &i->in[x];
                CHANGE(s, "offset + 1", n, at->offset, at->offset + 1);
                CHANGE(s, "offset - 1", n, at->offset, at->offset - 1);
                CHANGE(s, "stride", n, at->stride, at->stride + 1);
                CHANGE(s, "rows", n, at->rows, at->rows - 1);
                CHANGE(s, "local", n, at->local, !at->local);
                CHANGE(s, "kind", n, at->kind, (at->kind + 1) % PLACE_KINDS);
                CHANGE(s, "other", n, *at, next->out);
                CHANGE(s, "other operand", n, *at, next->in[0]);
            }
        }
    }
    print_message("%ld of %ld changes caught\n", s->caught, s->tried);
    assert_true(s->caught > s->tried * 8 / 10); /* the others read the same numbers elsewhere */
}

static void test_instructions(void **state)
{
    subject *s = *state;
    for (int k = 0; k < s->c.program->pass_count; k++) {
        pass *p = pass_of(s, k);
        for (int n = 0; n < p->count; n++) {
            instruction *i = &p->instructions[n], *next = &p->instructions[(n + 1) % p->count];
            CHANGE(s, "operation", n, i->op, i->op == OP_ADD ? OP_SUB : OP_ADD);
            CHANGE(s, "columns", n, i->columns, i->columns + 1);
            CHANGE(s, "fewer columns", n, i->columns, i->columns - 1);
            CHANGE(s, "attribute", n, i->whole, i->whole + 1);
            CHANGE(s, "loop", n, i->loop, s->c.program->kernels->loops[OP_COS][0]);
            CHANGE(s, "repeated", n, *i, *next);
            instruction first = *i, second = *next; /* order */
            *i = second;
            *next = first;
            judge(s, "exchanged", n);
            *i = first;
            *next = second;
        }
    }
}

/* A value moves, with all who read it, into memory of the same shape that another holds: fine when
 * the other is dead, and caught when it is still to be read. */
static void test_shared_memory(void **state)
{
    subject *s = *state;
    s->tried = s->caught = 0;
    for (int k = 0; k < s->c.program->pass_count; k++) {
        pass *p = pass_of(s, k);
        instruction *kept = malloc((size_t)p->count * sizeof *kept);
        assert_non_null(kept);
        memcpy(kept, p->instructions, (size_t)p->count * sizeof *kept);
        for (int a = 0; a < p->count; a++) {
            for (int b = a + 1; b < p->count; b++) {
                place from = kept[b].out, to = kept[a].out;
                if (from.kind != PLACE_TILE || to.kind != PLACE_TILE || from.rows != to.rows ||
                    from.stride != to.stride || from.offset == to.offset) {
                    continue;
                }
                p->instructions[b].out = to;
                for (int n = b + 1; n < p->count; n++) {
                    for (int x = 0; x < AD_ARITY_MAX; x++) {
                        place *read = &p->instructions[n].in[x];
                        if (read->kind == PLACE_TILE && read->offset == from.offset) {
                            read->offset = to.offset;
                            read->local = to.local;
                        }
                    }
                    if (kept[n].out.offset == from.offset) {
                        break;
                    }
                }
                judge(s, "moved", b);
                memcpy(p->instructions, kept, (size_t)p->count * sizeof *kept);
            }
        }
        free(kept);
    }
    print_message("%ld of %ld moves caught\n", s->caught, s->tried);
    assert_true(s->caught > 100 && s->caught < s->tried);
}

static void test_groups(void **state)
{
    subject *s = *state;
    for (int k = 0; k < s->c.program->pass_count; k++) {
        pass *p = pass_of(s, k);
        for (int g = 0; g < p->group_count; g++) {
            CHANGE(s, "pieces", g, p->groups[g].pieces, !p->groups[g].pieces);
            CHANGE(s, "first", g, p->groups[g].first, p->groups[g].first + 1);
            CHANGE(s, "count", g, p->groups[g].count, p->groups[g].count + 1);
            CHANGE(s, "fewer", g, p->groups[g].count, p->groups[g].count - 1);
        }
        for (int i = 0; i < p->output_count; i++) {
            CHANGE(s, "output", i, p->outputs[i].from.offset, p->outputs[i].from.offset + 1);
        }
    }
}

static void must_catch(subject *s, const char *what)
{
    if (!judge(s, what, 0)) {
        fail_msg("%s: not caught", what);
    }
}

#define MUST_CATCH(s, what, variable, value)                                                       \
    do {                                                                                           \
        const __typeof__(variable) before_ = (variable);                                           \
        (variable) = (value);                                                                      \
        must_catch(s, what);                                                                       \
        (variable) = before_;                                                                      \
    } while (0)

/* What is wrong whatever the numbers are. */
static void test_bounds(void **state)
{
    subject *s = *state;
    ad_program *program = s->c.program;
    pass *first = pass_of(s, 0);
    MUST_CATCH(s, "a workspace too small", program->info.workspace_bytes,
               program->info.workspace_bytes - 1);
    MUST_CATCH(s, "fewer units", first->units, first->units - 1);
    MUST_CATCH(s, "tiles that are not aligned", program->tile, 20);
    MUST_CATCH(s, "a workspace that is not aligned", program->workspaces[0],
               program->workspaces[0] + 1);
    MUST_CATCH(s, "fewer sums", first->reduced, first->reduced - 1);
    MUST_CATCH(s, "sums elsewhere", first->reduced_offset, first->reduced_offset + 1);
    MUST_CATCH(s, "a zero that is not", program->uniform[0], 1);
    MUST_CATCH(s, "an input elsewhere", program->input_units[0], program->input_units[0] + 1);
    MUST_CATCH(s, "an input outside", program->input_units[0], first->units);
    MUST_CATCH(s, "an output left out", pass_of(s, 1)->output_count, 0);
    MUST_CATCH(s, "an output twice", pass_of(s, 1)->outputs[0].number, 0);
    MUST_CATCH(s, "an instruction left out", first->count, first->count - 1);
    MUST_CATCH(s, "a uniform value not computed", first->uniform_count, first->uniform_count - 1);
    for (int id = 0; id < program->tape->count; id++) {
        const node *n = &program->tape->nodes[id];
        if (n->op == OP_PARAMETER || n->op == OP_UNIFORM) {
            MUST_CATCH(s, "a leaf elsewhere", program->places[id].offset,
                       program->places[id].offset + 1);
        }
        if (n->op == OP_CONSTANT && program->places[id].rows > 0) {
            MUST_CATCH(s, "another constant", program->uniform[program->places[id].offset], 0.125);
        }
    }
}

static void test_bounds_of_members(void **state)
{
    subject *s = *state;
    ad_program *program = s->c.program;
    assert_int_equal(program->pass_count, 7);
    pass *first = pass_of(s, 0), *points = pass_of(s, 1);
    assert_true(first->members && !points->members && pass_of(s, 2)->members);
    assert_true(first->kept_count > 2 && points->summed > 0);
    MUST_CATCH(s, "less memory of the members", program->member_rows, program->member_rows - 1);
    MUST_CATCH(s, "members' sums elsewhere", points->summed_offset, points->summed_offset + 1);
    MUST_CATCH(s, "fewer of the members' sums", points->summed, points->summed - 1);
    MUST_CATCH(s, "points for members", first->members, false);
    MUST_CATCH(s, "members for points", points->members, true);
    MUST_CATCH(s, "less scratch memory", program->scratch, 0);
    MUST_CATCH(s, "a value not kept", first->kept_count, first->kept_count - 1);
    for (int i = 0; i < first->kept_count; i++) {
        MUST_CATCH(s, "kept elsewhere", first->kept[i].number, first->kept[i].number + 1);
        MUST_CATCH(s, "another value kept", first->kept[i].from.offset,
                   first->kept[i].from.offset + 1);
    }
    for (int k = 0; k < program->pass_count; k++) {
        for (int n = 0; n < pass_of(s, k)->count; n++) {
            instruction *i = &pass_of(s, k)->instructions[n];
            if (i->op == OP_SPREAD) {
                MUST_CATCH(s, "another value spread", i->in[0].offset, i->in[0].offset + 1);
            }
            if (i->out.kind == PLACE_MEMBER) {
                MUST_CATCH(s, "another member's sum", i->out.offset, i->out.offset + 1);
            }
        }
    }
}

/* Else none of the other tests would verify what it compiles. */
static void test_is_on(void **state)
{
    (void)state;
    assert_true(ad_program_check == ad_program_verify);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_is_on),        cmocka_unit_test(test_places),
        cmocka_unit_test(test_instructions), cmocka_unit_test(test_shared_memory),
        cmocka_unit_test(test_groups),       cmocka_unit_test(test_bounds),
    };
    const struct CMUnitTest of_members[] = {
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_instructions),
        cmocka_unit_test(test_shared_memory),
        cmocka_unit_test(test_groups),
        cmocka_unit_test(test_bounds_of_members),
    };
    int failed = cmocka_run_group_tests(tests, make_subject, free_subject);
    return failed + cmocka_run_group_tests(of_members, make_member_subject, free_subject);
}
