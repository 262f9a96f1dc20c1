/* Scene files: what is accepted and what it means, what is refused and with which line, and that
 * writing and reading an experiment changes nothing. Run from the project folder, or with
 * CONFIGS_FOLDER set to where the shipped scenes are. */
#include "config_refusals.h"
#include "config_refusals_lists.h"
#include "config_testing.h"
#include "physics/scene/scene_field.h"
#include "tools/config/config_parts.h"

#include <locale.h>
#include <math.h>
#include <string.h>

#ifndef CONFIGS_FOLDER
#define CONFIGS_FOLDER "configs"
#endif

/* ---- refusals ------------------------------------------------------------------------------ */

/* The line with what it says of optimisers: "<rate>" stands for those that have a rate. */
static void expand(const char *line, char *text, size_t size)
{
    static const struct {
        const char *token;
        unsigned reads;
    } lists[] = {{"<optimizers>", 0},
                 {"<rate>", OPTIM_READS_RATE},
                 {"<memory>", OPTIM_READS_MEMORY},
                 {"<lines>", OPTIM_READS_LINES},
                 {"<tolerances>", OPTIM_READS_TOLERANCES}};
    const char *at = strchr(line, '<');
    char words[600] = "";
    size_t token = 0;
    for (size_t i = 0; at && i < sizeof lists / sizeof *lists && !token; i++) {
        if (strncmp(at, lists[i].token, strlen(lists[i].token)) == 0) {
            token = strlen(lists[i].token);
            optim_method_list(0, lists[i].reads, words, sizeof words);
        }
    }
    for (int i = 0; at && strncmp(at, "<settings>", 10) == 0 && i < optim_setting_count; i++) {
        const size_t used = strlen(words);
        token = 10;
        snprintf(words + used, sizeof words - used, "%s%s", i ? ", " : "",
                 optim_setting_rows[i].name);
    }
    snprintf(text, size, "%.*s%s%s", token ? (int)(at - line) : (int)strlen(line), line, words,
             token ? at + token : "");
}

static void check_refusals(const refusal *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const refusal *row = &rows[i];
        ad_error error = {AD_OK, ""};
        config *experiment = NULL;
        ad_status status = read_to_train("scene.yaml", row->text, row->override ? 1 : 0,
                                         &row->override, &experiment, &error);
        char line[1000];
        expand(row->line, line, sizeof line);
        assert_string_equal(error.message, line);
        assert_int_equal(status, AD_BAD_INPUT);
        assert_null(experiment);
    }
}

static void test_refusals(void **state)
{
    (void)state;
    check_refusals(refusals, sizeof refusals / sizeof *refusals);
}

static void test_scene_refusals(void **state)
{
    (void)state;
    check_refusals(scene_refusals, sizeof scene_refusals / sizeof *scene_refusals);
    check_refusals(beam_refusals, sizeof beam_refusals / sizeof *beam_refusals);
    check_refusals(list_refusals, sizeof list_refusals / sizeof *list_refusals);
}

static void test_files(void **state)
{
    (void)state;
    ad_error error = {AD_OK, ""};
    config *experiment = NULL;
    assert_int_equal(read_to_train("/nowhere/a.yaml", NULL, 0, NULL, &experiment, &error), AD_IO);
    assert_string_equal(error.message,
                        "/nowhere/a.yaml: cannot be read: No such file or directory");
    assert_int_equal(read_to_train("/", NULL, 0, NULL, &experiment, &error), AD_IO);
    assert_string_equal(error.message, "/: is a directory; allowed: a YAML file");
    assert_int_equal(read_to_train("/dev/null", NULL, 0, NULL, &experiment, &error), AD_IO);
    assert_string_equal(error.message, "/dev/null: is not a regular file; allowed: a YAML file");
    assert_null(experiment);
}

/* "list=[{what it has to give}]" */
static void entry_of(const config_list *list, char entry[CONFIG_PATH_MAX])
{
    char required[CONFIG_PATH_MAX] = "";
    if (list && list->required) {
        snprintf(required, sizeof required, "%s[].%s", list->path, list->required);
        const config_key *key = config_key_find(required);
        snprintf(required, sizeof required, "%s: %s", list->required,
                 key->names ? key->names()[0] : "[0, 0, 0]");
    }
    snprintf(entry, CONFIG_PATH_MAX, "%.60s=[{%.80s}]", list ? list->path : "", required);
}

/* Every row of the table, so that a new key is tested unasked: a section is refused where a value
 * belongs, and numbers outside the range are. */
static void test_every_key(void **state)
{
    (void)state;
    for (int i = 0; i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        char path[CONFIG_PATH_MAX];
        char override[2 * CONFIG_PATH_MAX];
        char start[4 * CONFIG_PATH_MAX];
        config *experiment = NULL;
        ad_error error = {AD_OK, ""};
        const config_list *list = config_list_of(key->path);
        char entry[CONFIG_PATH_MAX];
        const char *both[] = {entry, override};
        entry_of(list, entry);
        const char **given = list ? both : both + 1;
        int count = list ? 2 : 1;
        config_key_path(key, 0, path);
        bool one = key->type == CONFIG_QUANTITY && key->entries_max == 0; /* may be identified */
        bool section = key->type == CONFIG_PARAMETER || key->type == CONFIG_FORMULAS || one;
        snprintf(override, sizeof override, "%s=%s", path, section ? "[1]" : "{a: b}");
        snprintf(start, sizeof start, "override %s: %s: is a %s; allowed: ", override, path,
                 section ? "list" : "section");
        assert_int_equal(read_to_train("scene.yaml", BASE, count, given, &experiment, &error),
                         AD_BAD_INPUT);
        assert_memory_equal(error.message, start, strlen(start));
        if (key->type <= CONFIG_LONG && isfinite(key->low) && key->entries_max == 0) {
            snprintf(override, sizeof override, "%s=%.17g", path, key->low - 1);
            snprintf(start, sizeof start, "override %s: %s: is ", override, path);
            assert_int_equal(read_to_train("scene.yaml", BASE, count, given, &experiment, &error),
                             AD_BAD_INPUT);
            assert_memory_equal(error.message, start, strlen(start));
        }
        const config_words words = config_words_of(key);
        assert_in_range(strlen(words.help), 4, sizeof words.help - 2);
        assert_true(strlen(words.fallback) < sizeof words.fallback - 1);
        assert_ptr_equal(config_key_find(key->path), key);
    }
}

/* ---- aliases ------------------------------------------------------------------------------- */

static void test_aliases(void **state)
{
    (void)state;
    config *experiment = read_with("rod:\n"
                                   "  length: &one 1\n"
                                   "  stiffness: {shear: &pair [5, 5], axial: 9, bending: *pair,"
                                   " torsion: *one}\n"
                                   "training:\n"
                                   "  stages:\n"
                                   "    - &first {optimizer: adam, steps: 7, stop: {loss: 0.5}}\n"
                                   "    - &second {<<: *first, steps: 8, stop: {seconds: 5}}\n"
                                   "    - {<<: [{optimizer: lbfgs}, *second]}\n",
                                   NULL);
    assert_near(experiment->scene.rod.bending_stiffness[1].number, 5, 0);
    assert_near(experiment->scene.rod.torsional_stiffness.number, 1, 0);
    assert_int_equal(experiment->settings.stage_count, 3);
    assert_int_equal(experiment->settings.stages[1].optim.method, OPTIM_ADAM);
    assert_int_equal(experiment->settings.stages[1].steps, 8);
    assert_near(experiment->settings.stages[0].stop_loss, 0.5, 0);
    assert_near(experiment->settings.stages[1].stop_loss, 0, 0); /* a section is replaced whole */
    assert_near(experiment->settings.stages[1].stop_seconds, 5, 0);
    assert_int_equal(experiment->settings.stages[2].optim.method,
                     OPTIM_LBFGS); /* the earlier one wins */
    assert_int_equal(experiment->settings.stages[2].steps, 8);
    config_free(experiment);
}

/* Nine merges of nine merges of ...: refused after a bounded number of entries. */
static void test_alias_bomb(void **state)
{
    (void)state;
    char text[4000] = "rod: &a0 {length: 1}\n";
    ad_error error = {AD_OK, ""};
    config *experiment = NULL;
    static const char *const sections[] = {"time",     "output", "reference", "checkpoint",
                                           "training", "losses", "network"};
    for (int i = 0; i < 7; i++) {
        size_t at = strlen(text);
        snprintf(text + at, sizeof text - at,
                 "%s: &a%d {<<: [*a%d, *a%d, *a%d, *a%d, *a%d, *a%d, *a%d, *a%d, *a%d]}\n",
                 sections[i], i + 1, i, i, i, i, i, i, i, i, i);
    }
    assert_int_equal(read_to_train("scene.yaml", text, 0, NULL, &experiment, &error), AD_BAD_INPUT);
    snprintf(text, sizeof text, "rod: &a0 {}\n");
    for (int i = 0; i < 7; i++) {
        size_t at = strlen(text);
        snprintf(text + at, sizeof text - at,
                 "%s: &a%d {<<: [*a%d, *a%d, *a%d, *a%d, *a%d, *a%d, *a%d, *a%d, *a%d]}\n",
                 sections[i], i + 1, i, i, i, i, i, i, i, i, i);
    }
    assert_int_equal(read_to_train("scene.yaml", text, 0, NULL, &experiment, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "aliases expand to too many entries"));
}

/* ---- meaning ------------------------------------------------------------------------------- */

static void test_numbers(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double value;
    } rows[] = {{"1e6", 1e6},  {"1.5E-3", 1.5e-3}, {"+2", 2},
                {".5", 0.5},   {"3.", 3},          {"1e300", 1e300},
                {"0.25", .25}, {"1e-300", 1e-300}, {"2.50e+1", 25.0}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char override[64];
        snprintf(override, sizeof override, "checkpoint.seconds=%s", rows[i].text);
        config *experiment = read_with(BASE, override);
        assert_true(experiment->settings.checkpoint_seconds == rows[i].value);
        config_free(experiment);
    }
    config *experiment = read_with(BASE, "training.seed=9007199254740992");
    assert_true(experiment->settings.seed == UINT64_C(9007199254740992));
    config_free(experiment);
    experiment = read_with(BASE, "rod.stiffness.shear=[.inf, .inf]");
    assert_true(scene_locks(experiment->scene.rod.shear_stiffness[0]));
    config_free(experiment);
}

/* A user whose language writes a comma in numbers reads the same experiment. */
static void test_locale(void **state)
{
    (void)state;
    static const char *const names[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE.utf8"};
    const char *found = NULL;
    for (int i = 0; i < 3 && !found; i++) {
        found = setlocale(LC_ALL, names[i]);
    }
    config *experiment = read_with(BASE, "loads.tip={force: [0, 0, 1.5], frame: dead}");
    char *text = written(experiment, false);
    assert_non_null(strstr(text, "force: [0, 0, 1.5]"));
    assert_non_null(strstr(text, "function_tolerance: 0.2"));
    setlocale(LC_ALL, "C");
    free(text);
    config_free(experiment);
}

static void test_defaults(void **state)
{
    (void)state;
    config *experiment = read_with(BASE, NULL);
    assert_string_equal(experiment->settings.name, "scene");
    assert_int_equal(experiment->scene.start.type, SCENE_CLAMPED);
    assert_text(experiment->scene.start.rotation[0], "1");
    assert_int_equal(experiment->scene.end.type, SCENE_FREE);
    assert_int_equal(experiment->settings.stage_count, 1);
    assert_int_equal(experiment->settings.stages[0].optim.method, OPTIM_GAUSS_NEWTON);
    assert_int_equal(experiment->settings.stages[0].steps, 200);
    assert_near(experiment->settings.stages[0].optim.function_tolerance, 0.2, 0);
    assert_near(experiment->settings.stages[0].optim.initial_damping, 1e-10, 0);
    assert_int_equal(experiment->settings.stages[0].optim.scaling, OPTIM_SCALING_IDENTITY);
    assert_int_equal(experiment->settings.network.hidden_count, 0);
    assert_near(experiment->settings.fourier_wavenumber * scene_length(&experiment->scene), 16,
                1e-14);
    assert_near(experiment->settings.network.fourier_bandwidth[0], 8, 1e-14);
    assert_int_equal(experiment->settings.network.fourier_features, 16);
    assert_int_equal(experiment->settings.losses.interior.points, 4 * 33);
    assert_int_equal(experiment->scene.rotation, SCENE_QUATERNION);
    assert_int_equal(experiment->settings.output_every, 1);
    config_free(experiment);
    experiment = read_with(BASE, "loads.tip.moment=[0, 0, 30]"); /* bends by more than waves do */
    assert_near(experiment->settings.network.fourier_bandwidth[0],
                4 + 15 * scene_length(&experiment->scene) /
                        experiment->scene.rod.bending_stiffness[0].number,
                1e-12);
    config_free(experiment);
    experiment = read_with(DYNAMIC, NULL); /* by its strain modes */
    assert_int_equal(experiment->scene.formulation, SCENE_STRAIN_FORM);
    config_free(experiment);
    experiment = read_with(DYNAMIC, "network.fourier.features=80"); /* waves of s, too */
    assert_int_equal(experiment->scene.formulation, SCENE_MIXED);
    config_free(experiment);
    experiment = read_with(DYNAMIC, "formulation=mixed");
    assert_int_equal(experiment->settings.stages[0].optim.scaling, OPTIM_SCALING_DIAGONAL);
    assert_int_equal(experiment->scene.rotation, SCENE_VECTOR);
    config_free(experiment);
    experiment = read_with(DYNAMIC, "enforcement.initial=soft"); /* not from where the rod starts */
    assert_int_equal(experiment->scene.rotation, SCENE_QUATERNION);
    config_free(experiment);
    experiment = read_with(DYNAMIC, "training.stages=[{optimizer: gauss_newton, "
                                    "linear_algebra: matrix_free}]"); /* has no diagonal */
    assert_int_equal(experiment->settings.stages[0].optim.scaling, OPTIM_SCALING_IDENTITY);
    config_free(experiment);
    experiment = read_with(BASE, "training.stages[0].optimizer=adam"); /* all else as if given */
    assert_int_equal(experiment->settings.stages[0].steps, 1000);
    config_free(experiment);
    experiment = read_with(DYNAMIC "parameters: {a: {range: [0, 1]}}\n"
                                   "loads: {tip: {moment: [a, 0, 0]}}\n"
                                   "surrogate: {step: 0.01}\n",
                           "training.stages[0].steps=7"); /* of its usual stage */
    assert_int_equal(experiment->settings.stages[0].optim.method, OPTIM_SSBROYDEN);
    assert_int_equal(experiment->settings.stages[0].steps, 7);
    config_free(experiment);
    experiment = read_with(BASE "parameters: {a: {range: [0, 1]}}\n"
                                "loads: {tip: {moment: [a, 0, 0]}}\n"
                                "network: {polynomial: {degree: 0}}\n",
                           "training.stages[0].steps=70");
    assert_int_equal(experiment->settings.stages[0].optim.method, OPTIM_SOAP);
    assert_int_equal(experiment->settings.stages[0].steps, 70);
    assert_int_equal(experiment->settings.stages[0].optim.warmup_steps, 35);
    config_free(experiment);
    experiment = read_with(BASE, "training.stages=[{optimizer: adam}]");
    assert_int_equal(experiment->settings.network.hidden_count, 3);
    assert_int_equal(experiment->settings.network.fourier_features, 0);
    assert_int_equal(experiment->settings.losses.interior.points, 256);
    assert_int_equal(experiment->settings.output_every, 10);
    assert_int_equal(experiment->settings.stages[0].steps, 1000);
    assert_near(experiment->settings.stages[0].optim.learning_rate, 5e-3, 0);
    assert_int_equal(experiment->settings.stages[0].optim.schedule, OPTIM_SCHEDULE_COSINE);
    assert_int_equal(experiment->settings.stages[0].optim.decay_steps, 1000);
    config_free(experiment);
    experiment = read_with(DYNAMIC, "loads.tip.force=[0, 0, t]");
    assert_int_equal(experiment->scene.end.type, SCENE_LOADED);
    assert_int_equal(experiment->settings.losses.held_out_points, 32); /* instants */
    config_free(experiment);
}

static void test_overrides(void **state)
{
    (void)state;
    static const char *const overrides[] = {
        "training.stages=[{optimizer: adam}]",
        "network.hidden=[64,64]",
        "network.hidden[1]=48",
        "training.stages[0].steps=100",
        "training.stages[0]={warmup_steps: 10}",
        "loads.tip.force=[0, 0, \"min(1, 2)*3\"]",
        "loads.tip.force[2]=-7",
        "rod={length: 2, rest: {curvature: [0, 0.5, 0]}}",
        "name=other",
        "name=null",
        "rod.stiffness.torsion=1.0",
        "boundary.start.rotation=[0, 3, 0, 4]",
    };
    config *experiment = read_text(BASE, 12, overrides);
    assert_int_equal(experiment->settings.network.hidden_count, 2);
    assert_int_equal(experiment->settings.network.hidden[0], 64);
    assert_int_equal(experiment->settings.network.hidden[1], 48);
    assert_int_equal(experiment->settings.stages[0].steps, 100);
    assert_int_equal(experiment->settings.stages[0].optim.decay_steps, 90);
    assert_text(experiment->scene.loads.tip.force[2], "-7");
    assert_int_equal(experiment->scene.end.type, SCENE_LOADED);
    assert_near(experiment->scene.rod.length.number, 2, 0);
    assert_text(experiment->scene.rod.rest_curvature[1], "0.5");
    assert_string_equal(experiment->settings.name, "scene");
    assert_text(experiment->scene.start.rotation[1], "0.6");
    assert_text(experiment->scene.start.rotation[3], "0.8");
    config_free(experiment);
    experiment = read_with(BASE, "training.stages=[{optimizer: lbfgs, steps: 5}]");
    assert_int_equal(experiment->settings.stage_count, 1);
    assert_int_equal(experiment->settings.stages[0].optim.method, OPTIM_LBFGS);
    config_free(experiment);
}

static void test_load_units(void **state)
{
    (void)state;
    static const char *const overrides[] = {
        "rod={length: 2, stiffness: {bending: [3, 5]}}",
        "loads={units: EI, force: [s, 0, 0], moment: [0, 8, 0]}",
        "loads.tip={force: [4, 0, t*0], moment: [0, 2*2, 0]}",
        "time.duration=1",
        "rod.inertia={mass_per_length: 1, rotary: [0, 0, 0]}",
    };
    config *experiment = read_text(BASE, 5, overrides);
    const scene_loads *loads = &experiment->scene.loads;
    assert_int_equal(experiment->load_units, CONFIG_UNITS_SI);
    assert_text(loads->force[0], "(s)*0.375"); /* 3/2^3 */
    assert_text(loads->moment[1], "6");        /* 8 * 3/2^2 */
    assert_text(loads->tip.force[0], "3");     /* 4 * 3/2^2 */
    assert_text(loads->tip.force[2], "(t*0)*0.75");
    assert_text(loads->tip.moment[1], "6"); /* 4 * 3/2 */
    config_free(experiment);
}

/* ---- round trip ---------------------------------------------------------------------------- */

static void assert_same_properties(const scene_properties *a, const scene_properties *b)
{
    for (int i = 0; i < 3; i++) {
        assert_true(a->strain_stiffness[i].number == b->strain_stiffness[i].number);
        assert_true(a->curvature_stiffness[i].number == b->curvature_stiffness[i].number);
        assert_true(a->rotary_inertia[i].number == b->rotary_inertia[i].number);
    }
    assert_true(a->mass_per_length.number == b->mass_per_length.number);
}

static void assert_round_trip(const config *experiment)
{
    for (int help = 0; help < 2; help++) {
        char *first = written(experiment, help);
        config *again = read_with(first, NULL);
        char *second = written(again, help);
        scene_properties a = scene_properties_of(&experiment->scene);
        scene_properties b = scene_properties_of(&again->scene);
        assert_string_equal(first, second);
        assert_same_properties(&a, &b);
        assert_memory_equal(&experiment->settings.losses.interior, &again->settings.losses.interior,
                            sizeof(problem_points));
        config_free(again);
        free(first);
        free(second);
    }
}

static void test_shipped_configs(void **state)
{
    (void)state;
    static const char *const names[] = {"elastica",
                                        "rollup",
                                        "helix",
                                        "heavy_cantilever",
                                        "cantilever_dynamic",
                                        "manufactured_dynamic",
                                        "slender"};
    for (int i = 0; i < 7; i++) {
        char path[512];
        ad_error error = {AD_OK, ""};
        config *experiment = NULL;
        snprintf(path, sizeof path, "%s/%s.yaml", CONFIGS_FOLDER, names[i]);
        if (read_to_train(path, NULL, 0, NULL, &experiment, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        assert_string_equal(experiment->settings.name, names[i]);
        assert_true(train_names_reference(&experiment->settings));
        assert_round_trip(experiment);
        config_free(experiment);
    }
}

/* The numbers the shipped scenes are about. */
static void test_shipped_numbers(void **state)
{
    (void)state;
    config *experiment = NULL;
    const char *path = CONFIGS_FOLDER "/heavy_cantilever.yaml";
    assert_int_equal(read_to_train(path, NULL, 0, NULL, &experiment, NULL), AD_OK);
    const scene_rod *rod = &experiment->scene.rod;
    scene_properties follows = scene_properties_of(&experiment->scene);
    double weight = follows.mass_per_length.number * 9.81 * pow(rod->length.number, 3) /
                    follows.curvature_stiffness[0].number;
    assert_near(weight, 5, 1e-12); /* rounding of a few operations */
    config_free(experiment);
    path = CONFIGS_FOLDER "/helix.yaml";
    assert_int_equal(read_to_train(path, NULL, 0, NULL, &experiment, NULL), AD_OK);
    rod = &experiment->scene.rod;
    follows = scene_properties_of(&experiment->scene);
    assert_near(follows.curvature_stiffness[2].number / follows.curvature_stiffness[0].number,
                1 / 1.3, 1e-14);
    config_free(experiment);
    path = CONFIGS_FOLDER "/cantilever_dynamic.yaml";
    assert_int_equal(read_to_train(path, NULL, 0, NULL, &experiment, NULL), AD_OK);
    assert_near(experiment->scene.start.rotation[1].number, sqrt(0.5), 1e-15);
    assert_near(experiment->scene.start.rotation[3].number, sqrt(0.5), 1e-15);
    config_free(experiment);
}

/* What follows from section and material is not written as if it had been given: the section of a
 * resolved experiment can be edited. */
static void test_edited_section(void **state)
{
    (void)state;
    config *experiment = NULL;
    const char *path = CONFIGS_FOLDER "/heavy_cantilever.yaml";
    assert_int_equal(read_to_train(path, NULL, 0, NULL, &experiment, NULL), AD_OK);
    char *text = written(experiment, false);
    assert_non_null(strstr(text, "    shear_correction: null # 0."));
    assert_non_null(strstr(text, "    bending: null # [0."));
    assert_non_null(strstr(text, ", from section and material\n"));
    assert_non_null(strstr(text, "    mass_per_length: null # 0."));
    config *thicker = read_with(text, "rod.section.radius=0.02");
    scene_properties before = scene_properties_of(&experiment->scene);
    scene_properties after = scene_properties_of(&thicker->scene);
    for (int i = 0; i < 3; i++) { /* rounding of a fourth power */
        double ratio = after.curvature_stiffness[i].number / before.curvature_stiffness[i].number;
        assert_near(ratio, 16, 1e-13);
    }
    assert_near(after.mass_per_length.number / before.mass_per_length.number, 4, 1e-14);
    config_free(thicker);
    config_free(experiment);
    free(text);
}

/* Rest strains that vary give the initial shape too. */
static void test_varying_rest_shape(void **state)
{
    (void)state;
    config *experiment = read_with(DYNAMIC, "rod.rest.curvature=[3*s, 0, sin(s)]");
    assert_false(experiment->scene.initial.position[0].is_given);
    assert_round_trip(experiment);
    config_free(experiment);
}

/* null puts a section and all below back. */
static void test_null_sections(void **state)
{
    (void)state;
    static const char *const overrides[] = {
        "loads.tip={force: [0, 0, 1], frame: follower}",
        "loads.tip=null",
        "training={seed: 5, stages: [{optimizer: lbfgs, steps: 5}]}",
        "training=null",
        "network.hidden=[7]",
        "network=null",
        "losses={interior: {points: 9, weights: {force: 3}}}",
        "losses.interior=null",
    };
    config *changed = read_text(BASE, 8, overrides), *plain = read_with(BASE, NULL);
    char *one = written(changed, false), *two = written(plain, false);
    assert_string_equal(one, two);
    free(one);
    free(two);
    config_free(changed);
    config_free(plain);
    changed = read_with(BASE "training: {stages: [{optimizer: lbfgs, steps: 5}]}\n",
                        "training.stages[0].stop=null");
    assert_int_equal(changed->settings.stages[0].steps, 5);
    config_free(changed);
}

/* Checkpoints of 0.2.0 have all keys of then, at their defaults. */
static void test_gone_section(void **state)
{
    (void)state;
    config *old = read_text(BASE "losses: {self_adaptive: {rate: 0}, balance_every: 7}\n"
                                 "output: {every: 10, tensorboard: false}\n",
                            0, NULL);
    assert_int_equal(old->settings.losses.balance_every, 7);
    config_free(old);
}

static void test_round_trip_of_texts(void **state)
{
    (void)state;
    static const char *const overrides[] = {
        "name=\"quo\\\"te \\\\ \\u00e9\"",
        "loads.tip.force=[0, \"max(t, 0.1)\", 1e-300]",
        "boundary.start={type: driven, position: [t, 0, sin(t)], rotation: [1, 0, 0, t]}",
        "initial={position: [0, 0, s], rotation: [1, 0, 0, 0], velocity: [s, 0, 0]}",
        "training.stages=[{optimizer: adam, stop: {loss: 1e-9}}, {optimizer: lbfgs}]",
        "training.stages[0]={schedule: exponential, decay_factor: 0.5}",
        "losses={causal: {slices: 8, epsilon: [1, 2, 3]}, boundary: {sampler: chebyshev}}",
        "losses={balance: gradient_norm, balance_memory: 0.5}",
        "enforcement={boundary: soft, initial: soft}",
    };
    config *experiment = read_text(DYNAMIC, 9, overrides);
    assert_round_trip(experiment);
    config_free(experiment);
}

static void test_help(void **state)
{
    (void)state;
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    config_help(file);
    fclose(file);
    for (int i = 0; i < config_key_count; i++) {
        char row[CONFIG_PATH_MAX + 4];
        snprintf(row, sizeof row, "  %s: ", config_keys[i].path);
        assert_non_null(strstr(text, row));
    }
    char line[200];
    expand("training.stages[].optimizer: one of <optimizers>; required", line, sizeof line);
    assert_non_null(strstr(text, line));
    assert_non_null(strstr(text, "gauss_newton for up to 200 steps"));
    free(text);
    for (const char *const *line = config_text_keys; *line; line++) { /* no words without a key */
        char path[CONFIG_PATH_MAX];
        snprintf(path, sizeof path, "%.*s", (int)strcspn(*line, "\n"), *line);
        assert_true(*path == ' ' || !*path || strcmp(path, "formulas") == 0 ||
                    config_key_find(path));
    }
}

/* The default that --help states for a key, to text [200]; false: it states none, or one in words
 * that depends on other keys. */
static bool stated_default(const char *help, const config_key *key, char text[200])
{
    char row[CONFIG_PATH_MAX + 4];
    snprintf(row, sizeof row, "  %s: ", key->path);
    const char *line = strstr(help, row);
    assert_non_null(line);
    const char *end = strchr(line, '\n'), *stated = strstr(line, "; default: ");
    if (*config_words_of(key).fallback || !stated || stated > end) {
        return false;
    }
    stated += strlen("; default: ");
    snprintf(text, 200, "%.*s", (int)strcspn(stated, ";\n"), stated);
    return true;
}

/* The value that --print-config shows. */
static void resolved_value(const config *experiment, const config_key *key, char text[200])
{
    FILE *file = fmemopen(text, 200, "w");
    assert_non_null(file);
    config_write_value(file, key, config_key_base(experiment, key, 0), true);
    fclose(file);
}

/* What --help states as the default of a key is what a scene without the key gets: at rest and in
 * motion, for every optimiser, with hidden layers and without. */
static void test_stated_defaults(void **state)
{
    (void)state;
    static const char *const scenes[] = {BASE, DYNAMIC};
    char *help = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&help, &size);
    config_help(file);
    fclose(file);
    int compared = 0;
    for (int round = 0; round < 4 * OPTIM_METHOD_COUNT; round++) {
        optim_method optimizer = (optim_method)(round / 4);
        const char *text = scenes[round % 2];
        char stage[80];
        snprintf(stage, sizeof stage, "training.stages=[{optimizer: %s}]",
                 optim_method_name(optimizer));
        const char *overrides[] = {stage, "network.hidden=[8]"};
        config *experiment = read_text(text, 1 + round / 2 % 2, overrides);
        for (int i = 0; i < config_key_count; i++) {
            const config_key *key = &config_keys[i];
            char stated[200], resolved[200];
            if (config_given(experiment->source, key->path) ||
                !config_key_applies(experiment, key, 0) || !stated_default(help, key, stated)) {
                continue;
            }
            resolved_value(experiment, key, resolved);
            if (strcmp(stated, resolved) != 0) {
                fail_msg("%s: --help states %s, %s has %s", key->path, stated, stage, resolved);
            }
            compared++;
        }
        config_free(experiment);
    }
    assert_true(compared > 16 * 50);
    free(help);
}

/* ---- mutation ------------------------------------------------------------------------------ */

/* Random bytes in a valid file: accepted or refused with one line, never a crash. */
static void test_mutations(void **state)
{
    (void)state;
    char original[8192];
    FILE *file = fopen(CONFIGS_FOLDER "/elastica.yaml", "rb");
    assert_non_null(file);
    size_t size = fread(original, 1, sizeof original - 1, file);
    fclose(file);
    nn_rng rng = nn_rng_seed(20240607);
    static const char interesting[] = "[]{}:,&*!|>'\"#-?%@`\n\t <\\\x80\xff.0e";
    for (int round = 0; round < 3000; round++) {
        char text[sizeof original];
        ad_error error = {AD_OK, ""};
        config *experiment = NULL;
        memcpy(text, original, size);
        text[size] = '\0';
        for (uint64_t changes = 1 + nn_rng_below(&rng, 8); changes > 0; changes--) {
            uint64_t byte = 1 + nn_rng_below(&rng, 255);
            bool random = nn_rng_below(&rng, 2) == 0;
            char with = interesting[nn_rng_below(&rng, sizeof interesting - 1)];
            text[nn_rng_below(&rng, size)] = random ? (char)byte : with;
        }
        ad_status status =
            read_to_train(CONFIGS_FOLDER "/elastica.yaml", text, 0, NULL, &experiment, &error);
        if (status == AD_OK) {
            config_free(experiment);
        } else {
            assert_null(experiment);
            assert_true(strlen(error.message) > 10);
            assert_null(strchr(error.message, '\n'));
        }
    }
}

/* Brackets nested a thousand deep are neither a crash nor a long wait. */
static void test_deep_nesting(void **state)
{
    (void)state;
    char text[4001];
    static const char openings[] = "[{-";
    for (int i = 0; i < 3; i++) {
        ad_error error = {AD_OK, ""};
        config *experiment = NULL;
        for (size_t k = 0; k < sizeof text - 1; k++) {
            text[k] = openings[i] == '-' ? "- "[k % 2] : openings[i];
        }
        text[sizeof text - 1] = '\0';
        assert_int_not_equal(read_to_train("scene.yaml", text, 0, NULL, &experiment, &error),
                             AD_OK);
    }
}

/* libyaml compares each anchor with all before it. */
static void test_many_anchors(void **state)
{
    (void)state;
    char text[8192];
    size_t used = 0;
    ad_error error = {AD_OK, ""};
    config *experiment = NULL;
    for (int i = 0; i < 300; i++) {
        used += (size_t)snprintf(text + used, sizeof text - used, "k%d: &a%d 1\n", i, i);
    }
    assert_int_equal(read_to_train("scene.yaml", text, 0, NULL, &experiment, &error), AD_BAD_INPUT);
    assert_string_equal(error.message, "scene.yaml:257:7: anchor 257; allowed: 256 in a file");
}

/* Every quantity of the scene that the reader knows stands in the list of all quantities of a
 * scene, which meshes, windows and steps ask. */
static void test_quantities_are_listed(void **state)
{
    (void)state;
    int quantities = 0;
    for (int i = 0; i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        const size_t at = key->offset - offsetof(config, scene);
        bool listed = false;
        if (key->type != CONFIG_QUANTITY || key->offset < offsetof(config, scene) ||
            at >= sizeof(scene)) {
            continue;
        }
        for (int k = 0; k < scene_field_count; k++) {
            const int count = key->entries_max > 0 ? key->entries_max : 1;
            listed |= scene_fields[k].offset == at && scene_fields[k].count == count;
        }
        if (!listed) {
            fail_msg("%s is not in scene_fields", key->path);
        }
        quantities++;
    }
    assert_true(quantities > 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quantities_are_listed),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_scene_refusals),
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_every_key),
        cmocka_unit_test(test_aliases),
        cmocka_unit_test(test_alias_bomb),
        cmocka_unit_test(test_many_anchors),
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_locale),
        cmocka_unit_test(test_defaults),
        cmocka_unit_test(test_overrides),
        cmocka_unit_test(test_load_units),
        cmocka_unit_test(test_shipped_configs),
        cmocka_unit_test(test_shipped_numbers),
        cmocka_unit_test(test_edited_section),
        cmocka_unit_test(test_varying_rest_shape),
        cmocka_unit_test(test_null_sections),
        cmocka_unit_test(test_gone_section),
        cmocka_unit_test(test_round_trip_of_texts),
        cmocka_unit_test(test_help),
        cmocka_unit_test(test_stated_defaults),
        cmocka_unit_test(test_mutations),
        cmocka_unit_test(test_deep_nesting),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
