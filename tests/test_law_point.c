/* The laws at a point: the C that is written from them against their tape, in numbers and in lanes;
 * their derivatives against differences; their use with values of another tape. */
#include "physics/law/law.h"
#include "physics/solve/laws.h"
#include "physics/solve/laws_lanes.h"

#include "near.h"
#include "random_numbers.h"

#include <stdlib.h>
#include <string.h>

enum { OUTPUTS_MAX = LAW_FIRST_MAX + LAW_SECOND_MAX, TRIES = 200 };

/* One call of a law as it is written: given in groups; value, first, second. */
typedef struct written {
    law_name name;
    void (*numbers)(const double *given, double *value, double *first, double *second);
    void (*vectors)(const lanes *given, lanes *first, lanes *second);
} written;

static void tendon(const double *x, double *value, double *first, double *second)
{
    number_law_tendon_energy(x, x + 3, x + 6, value);
    number_law_tendon(x, x + 3, x + 6, first, second);
}

static void chamber(const double *x, double *value, double *first, double *second)
{
    number_law_chamber_energy(x, x + 3, x + 6, value);
    number_law_chamber(x, x + 3, x + 6, first, second);
}

static void resistance(const double *x, double *value, double *first, double *second)
{
    (void)second;
    number_law_resistance(x, x + 3, value, first);
}

FOR_EACH_PROCESSOR static void tendons(const lanes *x, lanes *first, lanes *second)
{
    lanes_law_tendon(x, x + 3, x + 6, first, second);
}

FOR_EACH_PROCESSOR static void chambers(const lanes *x, lanes *first, lanes *second)
{
    lanes_law_chamber(x, x + 3, x + 6, first, second);
}

FOR_EACH_PROCESSOR static void resistances(const lanes *x, lanes *first, lanes *second)
{
    lanes_law_resistance(x, x + 3, second, first); /* the force in place of what it has not */
}

static const written all[LAW_COUNT] = {{LAW_TENDON, tendon, tendons},
                                       {LAW_CHAMBER, chamber, chambers},
                                       {LAW_RESISTANCE, resistance, resistances}};

/* A section that is about straight, and whatever else it is given. */
static void draw(uint64_t *from, const law *of, double *given)
{
    for (int i = 0; i < law_given(of); i++) {
        given[i] = random_in(from, -1, 1);
    }
    given[2] += of->is_energy ? 3 : 0; /* p' is not 0 */
}

/* Outputs of a law on its tape, one after the other: value, first, second. */
static int outputs_of(const law *of, const law_formula *x, ad_value *outputs)
{
    int count = 0;
    for (int i = 0; i < of->rows; i++) {
        outputs[count++] = x->value[i];
    }
    for (int i = 0; i < law_first(of); i++) {
        outputs[count++] = x->first[i];
    }
    for (int i = 0; i < law_second(of); i++) {
        outputs[count++] = x->second[i];
    }
    return count;
}

/* Values of outputs of a tape with so many scalar inputs at one point. */
static void evaluate(int count, const ad_value *outputs, int inputs, const double *given,
                     double *values)
{
    ad_error error;
    ad_program *program = NULL;
    ad_pool *pool = ad_pool_create(1);
    const double *input[LAW_GIVEN_MAX];
    double *output[OUTPUTS_MAX];
    for (int i = 0; i < inputs; i++) {
        input[i] = &given[i];
    }
    for (int i = 0; i < count; i++) {
        output[i] = &values[i];
    }
    const ad_run run = {.points = 1, .inputs = input, .outputs = output};
    if (!pool || ad_compile(count, outputs, NULL, pool, &program, &error) != AD_OK ||
        ad_execute(program, &run, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    ad_program_free(program);
    ad_pool_free(pool);
}

/* What is written is what is recorded, to rounding of some sums of numbers of about 10. */
static void test_written(void **state)
{
    (void)state;
    static const double rounding = 1e-13;
    uint64_t from = 7;
    for (int l = 0; l < LAW_COUNT; l++) {
        const law *of = &law_table[all[l].name];
        law_formula x = law_formula_create(all[l].name);
        ad_value outputs[OUTPUTS_MAX];
        const int count = outputs_of(of, &x, outputs);
        for (int k = 0; k < TRIES; k++) {
            double given[LAW_GIVEN_MAX], values[OUTPUTS_MAX], got[OUTPUTS_MAX] = {0};
            lanes side[LAW_GIVEN_MAX], first[LAW_FIRST_MAX] = {{0}}, second[LAW_SECOND_MAX] = {{0}};
            draw(&from, of, given);
            for (int i = 0; i < law_given(of); i++) {
                side[i] = (lanes){0} + given[i];
            }
            evaluate(count, outputs, law_given(of), given, values);
            all[l].numbers(given, got, got + of->rows, got + of->rows + law_first(of));
            all[l].vectors(side, first, second);
            for (int i = 0; i < count; i++) {
                assert_near(got[i], values[i], rounding);
            }
            for (int i = 0; i < law_first(of); i++) {
                assert_near(first[i][k % LANES], values[of->rows + i], rounding);
            }
            for (int i = 0; i < law_second(of); i++) {
                assert_near(second[i][k % LANES], values[of->rows + law_first(of) + i], rounding);
            }
            for (int i = 0; i < of->rows && !of->is_energy; i++) {
                assert_near(second[i][k % LANES], values[i], rounding);
            }
        }
        law_formula_free(&x);
    }
}

/* Central differences with h = 1e-5: h^2 and rounding over h are below 1e-9. */
static void test_derivatives(void **state)
{
    (void)state;
    static const double h = 1e-5, close = 1e-9;
    uint64_t from = 11;
    for (int l = 0; l < LAW_COUNT; l++) {
        const law *of = &law_table[all[l].name];
        const int n = of->variables;
        for (int k = 0; k < TRIES; k++) {
            double given[LAW_GIVEN_MAX], at[3] = {0}, first[LAW_FIRST_MAX] = {0};
            double second[LAW_SECOND_MAX] = {0}, value[2][3], beside[2][LAW_FIRST_MAX];
            double unused[LAW_SECOND_MAX] = {0};
            draw(&from, of, given);
            all[l].numbers(given, at, first, second);
            for (int j = 0; j < n; j++) {
                const double middle = given[j];
                for (int side = 0; side < 2; side++) {
                    memset(value[side], 0, sizeof value[side]);
                    memset(beside[side], 0, sizeof beside[side]);
                    given[j] = middle + (side ? h : -h);
                    all[l].numbers(given, value[side], beside[side], unused);
                }
                given[j] = middle;
                for (int i = 0; i < of->rows; i++) {
                    assert_near((value[1][i] - value[0][i]) / (2 * h), first[i * n + j], close);
                }
                for (int i = 0; i < n && of->is_energy; i++) {
                    assert_near((beside[1][i] - beside[0][i]) / (2 * h), second[law_entry(i, j)],
                                close);
                }
            }
        }
    }
}

/* On a tape of its own rows: three points side by side are three points. */
static void test_called(void **state)
{
    (void)state;
    enum { POINTS = 3 };
    uint64_t from = 13;
    for (int l = 0; l < LAW_COUNT; l++) {
        const law *of = &law_table[all[l].name];
        ad_tape *tape = ad_tape_create();
        double given[POINTS][LAW_GIVEN_MAX], columns[LAW_GIVEN_MAX][POINTS];
        ad_value constants[LAW_GIVEN_MAX], value[3], first[LAW_FIRST_MAX], second[LAW_SECOND_MAX];
        for (int p = 0; p < POINTS; p++) {
            draw(&from, of, given[p]);
        }
        for (int i = 0; i < law_given(of); i++) {
            for (int p = 0; p < POINTS; p++) {
                columns[i][p] = given[p][i];
            }
            constants[i] = ad_constant(tape, POINTS, columns[i]);
        }
        law_record(all[l].name, tape, constants, value, first, second);
        assert_int_equal(ad_tape_status(tape, NULL), AD_OK);
        for (int p = 0; p < POINTS; p++) {
            double got[OUTPUTS_MAX] = {0}, out[LAW_FIRST_MAX][POINTS];
            double *output[LAW_FIRST_MAX];
            all[l].numbers(given[p], got, got + of->rows, got + of->rows + law_first(of));
            ad_error error;
            ad_program *program = NULL;
            ad_pool *pool = ad_pool_create(1);
            for (int i = 0; i < law_first(of); i++) {
                output[i] = out[i];
                first[i] = ad_rows(first[i]) == 1 ? ad_repeat(first[i], POINTS) : first[i];
            }
            const ad_run run = {.points = 1, .outputs = output};
            if (ad_compile(law_first(of), first, NULL, pool, &program, &error) != AD_OK ||
                ad_execute(program, &run, &error) != AD_OK) {
                fail_msg("%s", error.message);
            }
            for (int i = 0; i < law_first(of); i++) {
                assert_near(out[i][p], got[of->rows + i], 1e-13);
            }
            ad_program_free(program);
            ad_pool_free(pool);
        }
        ad_tape_free(tape);
    }
}

/* Nothing moves, nothing resists, and derivatives are finite. */
static void test_at_rest(void **state)
{
    (void)state;
    const double velocity[3] = {0, 0, 0}, coefficients[2] = {0.5, 2};
    double force[3] = {0}, by[9] = {0};
    number_law_resistance(velocity, coefficients, force, by);
    for (int i = 0; i < 9; i++) {
        assert_near(by[i], i % 4 == 0 ? 0.5 : 0, 0);
        assert_near(force[i % 3], 0, 0);
    }
}

/* What cannot be written is refused, and the same text is written again. */
static void test_text(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 3), y = ad_input(tape, "y", 1), sum = ad_sum_rows(x);
    const ad_inline_argument input = {"y", 1, &y};
    const ad_inline_argument bad = {"z", 1, &sum};
    ad_error error = {AD_OK, ""};
    char *text[2] = {NULL, NULL};
    size_t size;
    FILE *file = open_memstream(&text[0], &size);
    assert_int_equal(ad_write_inline("f", 1, &input, 1, &bad, file, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "allowed: elementwise"));
    fclose(file);
    free(text[0]);
    ad_value z = ad_exp(ad_mul(ad_sqrt(y), ad_scalar(tape, 0.1)));
    const ad_inline_argument good = {"z", 1, &z};
    for (int i = 0; i < 2; i++) {
        file = open_memstream(&text[i], &size);
        assert_int_equal(ad_write_inline("f", 1, &input, 1, &good, file, &error), AD_OK);
        fclose(file);
    }
    assert_string_equal(text[0], text[1]);
    assert_non_null(strstr(text[0], "0.10000000000000001"));
    assert_non_null(strstr(text[0], "ALGEBRA(exp)("));
    free(text[0]);
    free(text[1]);
    ad_tape_free(tape);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_written), cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_called), cmocka_unit_test(test_at_rest), cmocka_unit_test(test_text)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
