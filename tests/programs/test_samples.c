/* Whoever is asked for the same shapes says the same, and all of it is in the table. */
#include "good.h"

#include "tools/prepare/config_session.h"
#include "tools/programs/samples.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROD "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}}\n"

static const char pushed[] = ROD "parameters: {push: {range: [0.5, 2]}}\n"
                                 "boundary: {end: {type: loaded}}\n"
                                 "loads: {tip: {force: [push, 0, 0]}}\n";
static const char rollup[] = ROD "loads: {tip: {moment: [0, 1, 0]}}\n";

enum { POINTS = 5, MEMBERS = 3, POSE = 7, COLUMNS = SOLVE_MEMBERS_COLUMNS + SOLVE_MEMBERS_FORCES };

static void ask(samples *p, const answer *a)
{
    ad_error error = {.message = ""};
    assert_good(samples_ask(p, a, &error), &error);
}

static solution *solve(const scene *of)
{
    const solve_settings settings = solve_settings_default(of);
    solve_report report;
    solution *solved = NULL;
    ad_error error = {.message = ""};
    assert_good(solution_create(of, &settings, 0, NULL, &solved, &report, &error), &error);
    return solved;
}

static samples points_along(const scene *of)
{
    samples p = {.count = 0};
    ad_error error = {.message = ""};
    assert_good(samples_choose(&p, &(samples_asked){.grid = "5"}, NULL, of, 0, &error), &error);
    assert_int_equal(p.count, POINTS);
    return p;
}

/* The solver of members is within 1e-6 of the length, the other one, in other equations, within
 * 1e-10; a rotation turns by no more than ten times that over the length. */
static void test_members(void **state)
{
    (void)state;
    config *settings;
    ad_error error = {.message = ""};
    cpinn_family *family = NULL;
    assert_good(prepare_read("pushed.yaml", pushed, 0, NULL, &settings, &error), &error);
    const scene *open = &settings->scene;
    samples all = points_along(open), one = points_along(open);
    const cpinn_family_settings asked = {
        .threads = 1, .points = POINTS, .s = all.s, .forces = true};
    assert_good(cpinn_family_prepare(open, 1e-6, &asked, &family, &error), &error);
    all.members = MEMBERS;
    all.parameters = malloc(MEMBERS * sizeof *all.parameters);
    for (int i = 0; i < MEMBERS; i++) {
        all.parameters[i] = 0.5 + 0.75 * i;
    }
    const answer members = answer_of_family(family, NULL);
    all.derives = true;
    ask(&all, &members);
    for (size_t i = 0; i < MEMBERS; i++) {
        scene member;
        scene_member(open, &all.parameters[i], &member);
        solution *solved = solve(&member);
        const answer alone = answer_of_solution(solved, &member);
        ask(&one, &alone);
        assert_true(all.said[i].trusted && all.said[i].source == CPINN_FROM_MEMBERS);
        for (size_t c = 0; c < POSE; c++) {
            for (size_t k = 0; k < POINTS; k++) {
                assert_near(all.values[(c * MEMBERS + i) * POINTS + k], one.values[c * POINTS + k],
                            c < 3 ? 1e-6 : 1e-5);
            }
        }
        solution_free(solved);
    }
    samples_table table;
    assert_good(samples_fill(&all, true, &table, &error), &error);
    const table_source *t = &table.of.table;
    assert_int_equal(t->nrows, MEMBERS * POINTS);
    assert_int_equal(t->ncols, 2 + COLUMNS + 5 + COLUMNS);
    assert_string_equal(t->names[7 + COLUMNS], "x_by_push");
    assert_string_equal(t->names[1], "s"); /* at rest there is no t */
    assert_string_equal(t->names[2], "x");
    assert_string_equal(t->units[2], "m");
    for (size_t row = 0; row < t->nrows; row++) {
        assert_true(t->columns[0][row] == (double)(row / POINTS + 1));
        assert_true(t->columns[1][row] == all.s[row % POINTS]);
        assert_true(t->columns[2][row] == all.values[row]);
        assert_string_equal(t->words[5 + COLUMNS][row], "members");
        assert_string_equal(t->words[6 + COLUMNS][row], "none");
        assert_true(t->columns[7 + COLUMNS][row] == all.slopes[row]);
    }
    for (size_t k = 0; k < t->nrows * (size_t)all.columns; k++) {
        assert_false(all.values[k] == 0 && signbit(all.values[k]));
    }
    samples_table_free(&table);
    samples_free(&all);
    samples_free(&one);
    cpinn_family_free(family);
    config_free(settings);
}

/* The rolled-up rod is linear in the default network: right to rounding, as in the solver. */
static void test_network(void **state)
{
    (void)state;
    config *settings;
    session s = {.e = NULL};
    field *trained = NULL;
    ad_error error = {.message = ""};
    assert_good(prepare_read("rollup.yaml", rollup, 0, NULL, &settings, &error), &error);
    assert_good(config_session_create(settings, 1, &s, &error), &error);
    assert_good(session_train(&s, NULL, NULL, &error), &error);
    memcpy(experiment_parameters(s.e), trainer_parameters(s.trainer), s.e->count * sizeof(double));
    assert_good(experiment_field(s.e, NULL, &trained, &error), &error);
    solution *solved = solve(s.e->scene);
    const answer answers[2] = {answer_of_network(trained, experiment_parameters(s.e), s.e->scene),
                               answer_of_solution(solved, s.e->scene)};
    samples p[2] = {points_along(s.e->scene), points_along(s.e->scene)};
    for (int i = 0; i < 2; i++) {
        ask(&p[i], &answers[i]);
        assert_null(p[i].said);
    }
    assert_int_equal(p[0].columns, p[1].columns);
    for (int k = 0; k < p[0].columns * POINTS; k++) {
        assert_near(p[0].values[k], p[1].values[k], 1e-8);
    }
    samples_table table;
    assert_good(samples_fill(&p[0], true, &table, &error), &error);
    assert_int_equal(table.of.table.ncols, 2 + p[0].columns);
    p[1].derives = true;
    assert_int_equal(samples_ask(&p[1], &answers[1], &error), AD_BAD_ARGUMENT);
    assert_string_equal(table.of.table.names[1], "t");
    samples_table_free(&table);
    samples_free(&p[0]);
    samples_free(&p[1]);
    solution_free(solved);
    field_free(trained);
    session_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_members),
                                       cmocka_unit_test(test_network)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
