/* Named parameters of a scene file: in formulas, by --set, written and read again, refused. */
#include "config_testing.h"
#include "quantity_testing.h"

#include <string.h>

#define ROD                                                                                        \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [5, 5], axial: 9, bending: [1, 1], torsion: 0.8}\n"
#define FAMILY                                                                                     \
    "parameters: {pull: {range: [0, 4]}, stiff: {range: [0.5, 2], scale: log}, half: stiff/2}\n"   \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [5, 5], axial: 9, bending: [stiff, stiff], torsion: half}\n"             \
    "loads: {tip: {force: [0, pull, 0]}}\n"
#define LOADED LOADED_WITH("")
#define LOADED_WITH(more)                                                                          \
    "parameters: {" more "load: 0.3, twice: 2*load, ramp: \"twice*s\"}\n" ROD                      \
    "loads: {force: [0, -ramp, load], tip: {force: [0, 0, \"-load*(1 + twice)\"]}}\n"

/* The physics alone. */
static char *printed(const config *experiment)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    assert_non_null(file);
    assert_int_equal(config_write_physics(experiment, file), AD_OK);
    fclose(file);
    return text;
}

static void test_values(void **state)
{
    (void)state;
    config *experiment = read_text(LOADED, 0, NULL);
    const scene_loads *loads = &experiment->scene.loads;
    assert_true(quantity_value(loads->force[1], 0.5, 0) == -(2 * 0.3 * 0.5));
    assert_true(quantity_is(loads->force[2], 0.3));
    assert_true(quantity_is(loads->tip.force[2], -0.3 * (1 + 2 * 0.3)));
    config_free(experiment);
    static const char *const overrides[] = {"parameters.load=0.5", "parameters.more=3*load",
                                            "loads.tip.force[0]=more"};
    experiment = read_text(LOADED, 3, overrides);
    loads = &experiment->scene.loads;
    assert_true(quantity_is(loads->force[2], 0.5)); /* in its place, before those that use it */
    assert_true(quantity_is(loads->tip.force[2], -0.5 * (1 + 2 * 0.5)));
    assert_true(quantity_is(loads->tip.force[0], 3 * 0.5));
    config_free(experiment);
}

/* The formulas as they were written, and the same experiment again. */
static void test_round_trip(void **state)
{
    (void)state;
    config *experiment = read_text(LOADED, 0, NULL);
    char *first = written(experiment, false);
    assert_non_null(strstr(first, "parameters:\n  load: 0.3\n  twice: \"2*load\"\n"
                                  "  ramp: \"twice*s\"\n"));
    assert_non_null(strstr(first, "force: [0, \"-ramp\", \"load\"]"));
    config *again = read_text(first, 0, NULL);
    char *second = written(again, false);
    assert_string_equal(first, second);
    assert_int_equal(config_continues(experiment, again, 0, NULL), AD_OK);
    static const char *const change[] = {"parameters.load=0.5"};
    config *other = read_text(first, 1, change);
    ad_error error = {AD_OK, ""};
    assert_int_equal(config_continues(experiment, other, 0, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "loads.force: [0, \"(-1)*(0.6*s)\", 0.3] in the "
                                          "checkpoint, [0, \"(-1)*(1*s)\""));
    config *same = read_text(LOADED_WITH("unused: 0.5, "), 0, NULL);
    assert_int_equal(config_continues(experiment, same, 0, NULL), AD_OK);
    config_free(experiment);
    config_free(again);
    config_free(other);
    config_free(same);
    free(first);
    free(second);
}

/* A classical solution does not depend on how its scene was written. */
static void test_physics(void **state)
{
    (void)state;
    static const char plain[] =
        ROD "loads: {force: [0, \"-(0.6*s)\", 0.3], tip: {force: [0, 0, -0.48]}}\n";
    config *one = read_text(LOADED, 0, NULL), *other = read_text(plain, 0, NULL);
    char *texts[2] = {printed(one), printed(other)};
    assert_string_equal(texts[0], texts[1]);
    free(texts[0]);
    free(texts[1]);
    config_free(one);
    config_free(other);
}

/* Units of EI scale a formula that stays readable, and read back in SI. */
static void test_units(void **state)
{
    (void)state;
    static const char *const changes[] = {"loads.units=EI", "rod.stiffness.bending=[4, 4]"};
    config *experiment = read_text(LOADED, 2, changes);
    char *text = written(experiment, false);
    assert_non_null(strstr(text, "force: [0, \"(-ramp)*4\", 1.2]"));
    config *again = read_text(text, 0, NULL);
    assert_true(quantity_value(again->scene.loads.force[1], 0.5, 0) == -(2 * 0.3 * 0.5) * 4);
    free(text);
    config_free(experiment);
    config_free(again);
}

static void test_refusals(void **state)
{
    (void)state;
    static const struct {
        const char *text, *override, *says;
    } rows[] = {
        {"parameters: {s: 1}\n" ROD, NULL,
         "scene.yaml:1:17: parameters.s: formulas know 's' already; choose another name"},
        {"parameters: {exp: 1}\n" ROD, NULL, "scene.yaml:1:19: parameters.exp: formulas know"},
        {"parameters: {a-b: 1}\n" ROD, NULL, "scene.yaml:1:19: parameters.a-b: 'a-b' is no name"},
        {"parameters: {a: 1, a: 2}\n" ROD, NULL, "scene.yaml:1:20: parameters.a: is given twice"},
        {"parameters: {a: 2*b, b: 3*s}\n" ROD, NULL, /* formulas in their order, behind numbers */
         "scene.yaml:1:17: parameters.a: column 3 of '2*b': unknown name 'b'; allowed are s, t, "
         "pi, sin"},
        {"parameters: {a: [1]}\n" ROD, NULL,
         "scene.yaml:1:17: parameters.a: is a list; allowed: a number, a formula or "
         "{range: [low, high], scale: linear or log, identify: number}"},
        {"parameters: {a: .inf}\n" ROD, NULL, "scene.yaml:1:17: parameters.a: is .inf, which is"},
        {"parameters: {a: }\n" ROD, NULL, "parameters.a: has no value"},
        {"parameters: {a: {b: 1}}\n" ROD, NULL,
         "scene.yaml:1:18: parameters.a.b: unknown key; allowed in parameters.<name>: range, "
         "identify, scale"},
        {"parameters: {a: {}}\n" ROD, NULL, "parameters.a: has no range"},
        {"parameters: {a: {rnge: [0, 1]}}\n" ROD, NULL,
         "parameters.a.rnge: unknown key; did you mean parameters.<name>.range?"},
        {"parameters: {a: {range: 1}}\n" ROD, NULL,
         "parameters.a.range: is 1; allowed: a list of 2 finite numbers"},
        {"parameters: {a: {range: [1, 1]}}\n" ROD, NULL, "parameters.a: has the range 1 to 1"},
        {"parameters: {a: {range: [2, 1]}}\n" ROD, NULL,
         "scene.yaml:1:17: parameters.a: has the range 2 to 1; allowed: the lower value first"},
        {"parameters: {a: {range: [0, 1], scale: log}}\n" ROD, NULL,
         "parameters.a: has the range 0 to 1; allowed with scale log: values > 0"},
        {"parameters: {a: {range: [0, 1]}}\n" ROD, NULL,
         "parameters.a: has a range, but no formula of the scene uses it"},
        {LOADED, "parameters.load.scale=log", "parameters.load: has no range"},
        {FAMILY, "rod.length=pull",
         "rod.length: must be a finite number > 0 (of the member pull=0, stiff=0.5)"},
        {FAMILY, "rod.stiffness.torsion=pull-1",
         "rod.stiffness.torsion: must be > 0; .inf locks that strain (of the member pull=0, "
         "stiff=0.5)"},
        {FAMILY, "loads.tip.force=[0, 0, 0.1/(pull-2)*stiff]",
         "loads.tip.force: must be finite (of the member pull="},
        {FAMILY, "loads.tip.force=[0, 0, sqrt(abs(pull-0.7)-0.1)*stiff]",
         " members looked at are refused"},
        {FAMILY, "parameters.pul=3",
         "override parameters.pul=3: parameters.pul: no formula of the scene uses it"},
        {FAMILY, "parameters.pull=-s", "depends on s"},
        {"parameters: 3\n" ROD, NULL, "scene.yaml:1:13: parameters: is a single value"},
        {"parametres: {a: 1}\n" ROD, NULL, "parametres: unknown key; did you mean parameters?"},
        {LOADED, "parameters.load=null",
         "parameters.twice: column 3 of '2*load': unknown name 'load'"},
        {LOADED, "loads.tip.force[2]=-laod",
         "override loads.tip.force[2]=-laod: loads.tip.force[2]: column 2 of '-laod': unknown name "
         "'laod'; did you mean load? allowed are s, t, load, twice, ramp, pi, sin"},
        {LOADED, "rod.length=ramp",
         "override rod.length=ramp: rod.length: depends on s or t; allowed: one number"},
        {LOADED, "rod.length=-load",
         "override rod.length=-load: rod.length: is the formula of a number -0.3, which is out of "
         "range; allowed: a number or a formula > 0, in m"},
        {LOADED, "rod.stiffness.torsion=0.5 - s",
         "override rod.stiffness.torsion=0.5 - s: rod.stiffness.torsion: must be > 0; .inf locks "
         "that "
         "strain"},
        {LOADED, "network.hidden=[load]", "network.hidden[0]: is load, which is not a number"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ad_error error = {AD_OK, ""};
        config *experiment = NULL;
        ad_status status = prepare_read("scene.yaml", rows[i].text, rows[i].override ? 1 : 0,
                                        &rows[i].override, &experiment, &error);
        if (status != AD_BAD_INPUT || !strstr(error.message, rows[i].says)) {
            fail_msg("row %zu: %s", i, error.message);
        }
        config_free(experiment);
    }
}

/* ---- families ------------------------------------------------------------------------------ */

static void test_ranges(void **state)
{
    (void)state;
    config *family = read_text(FAMILY, 0, NULL);
    const scene *x = &family->scene;
    assert_int_equal(x->parameter_count, 2);
    assert_string_equal(x->parameters[1].name, "stiff");
    assert_near(scene_parameter_at(&x->parameters[0], 0.5), 2, 0);
    assert_near(scene_parameter_at(&x->parameters[1], 0.5), 1, 1e-15);
    assert_near(scene_parameter_fraction(&x->parameters[1], 1), 0.5, 1e-15);
    scene member;
    scene_member(x, (double[]){3, 0.8}, &member);
    assert_false(scene_is_family(&member));
    assert_true(quantity_is(member.loads.tip.force[1], 3));
    assert_true(quantity_is(member.rod.torsional_stiffness, 0.8 / 2));
    char *first = written(family, true);
    assert_non_null(strstr(first, "  pull: {range: [0, 4], scale: linear}\n"
                                  "  stiff: {range: [0.5, 2], scale: log}\n"
                                  "  half: \"stiff/2\"\n"));
    config *again = read_text(first, 0, NULL);
    char *second = written(again, true);
    assert_string_equal(first, second);
    assert_int_equal(config_continues(family, again, 0, NULL), AD_OK);
    config *other = read_with(FAMILY, "parameters.pull.range=[0, 3]");
    ad_error error = {AD_OK, ""};
    assert_int_equal(config_continues(family, other, 0, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "parameters: other ranges"));
    char *physics[2] = {printed(family), printed(other)};
    assert_non_null(strstr(physics[0], "pull: {range: [0, 4]"));
    assert_string_not_equal(physics[0], physics[1]);
    free(physics[0]);
    free(physics[1]);
    free(first);
    free(second);
    config_free(family);
    config_free(again);
    config_free(other);
}

/* A number in place of a range, and a range in place of a number. */
static void test_closing(void **state)
{
    (void)state;
    static const char *const open[] = {"parameters.load={range: [0.1, 1], scale: log}"};
    static const char *const closed[] = {"parameters.pull=5", "parameters.stiff=1"};
    static const char *const changed[] = {"parameters.stiff.range=[1, 3]",
                                          "parameters.pull.range=[-1, 1]"};
    config *x = read_text(FAMILY, 2, closed);
    assert_false(scene_is_family(&x->scene));
    assert_true(quantity_is(x->scene.loads.tip.force[1], 5));
    config_free(x);
    x = read_text(LOADED, 1, open);
    assert_int_equal(x->scene.parameter_count, 1);
    config_free(x);
    x = read_text(FAMILY, 2, changed);
    assert_true(x->scene.parameters[1].scale == SCENE_LOG && x->scene.parameters[1].high == 3);
    assert_true(x->scene.parameters[0].low == -1);
    config_free(x);
}

static void test_members(void **state)
{
    (void)state;
    static const struct {
        const char *at, *says;
    } rows[] = {
        {NULL, "scene.yaml:1:13: parameters: the scene is a family, of which one member is wanted: "
               "values are missing of pull, stiff; give a number for each"},
        {"stiff=1", "values are missing of pull"},
        {"pull=1,stiff=4", "stiff = 4 is outside its range; allowed: 0.5 to 2"},
        {"pul=1", "pul is no parameter with a range; allowed: pull, stiff"},
        {"pull=1,pull=1", "pull is given twice; allowed: stiff"},
        {"pull", "member 'pull': allowed: name=number"},
        {"pull=a", "member 'pull=a': allowed: name=number"},
        {"pull=1 2", "allowed: name=number"},
        {"half=1", "half is no parameter with a range"},
    };
    ad_error error = {AD_OK, ""};
    config *x = NULL;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ad_status status =
            prepare_read_member("scene.yaml", FAMILY, 0, NULL, rows[i].at, &x, &error);
        if (status != AD_BAD_INPUT || !strstr(error.message, rows[i].says)) {
            fail_msg("row %zu: %s", i, error.message);
        }
    }
    assert_int_equal(
        prepare_read_member("scene.yaml", FAMILY, 0, NULL, "pull=1, stiff = 2", &x, &error), AD_OK);
    assert_true(quantity_is(x->scene.rod.torsional_stiffness, 1));
    config_free(x);
}

/* Loads in units of each member's own stiffness. */
static void test_family_units(void **state)
{
    (void)state;
    config *x = read_with(FAMILY, "loads.units=EI");
    scene member;
    scene_member(&x->scene, (double[]){3, 0.8}, &member);
    assert_true(quantity_is(member.loads.tip.force[1], 3 * 0.8));
    config_free(x);
}

/* A scene that a program fills in. */
static void test_by_hand(void **state)
{
    (void)state;
    config *given = read_text(FAMILY, 0, NULL), *made = NULL;
    ad_error error = {AD_OK, ""};
    const train_settings usual = train_settings_default();
    scene x = given->scene;
    assert_int_equal(prepare_create(&x, &usual, &made, &error), AD_OK);
    assert_int_equal(made->scene.parameter_count, 2);
    assert_true(quantity_depends_on(made->scene.rod.torsional_stiffness, "stiff"));
    config_free(made);
    x.parameters[0].high = 0;
    assert_int_equal(prepare_create(&x, &usual, &made, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "parameters.pull: has the range 0 to 0"));
    config_free(given);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),   cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_physics),  cmocka_unit_test(test_units),
        cmocka_unit_test(test_refusals), cmocka_unit_test(test_ranges),
        cmocka_unit_test(test_closing),  cmocka_unit_test(test_members),
        cmocka_unit_test(test_by_hand),  cmocka_unit_test(test_family_units),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
