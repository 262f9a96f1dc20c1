/* References that are solved classically, and how they are kept. */
#include "evaluate.h"
#include "temporary_folder.h"
#include "training_testing.h"

#include "tools/config/config_keys.h"
#include "tools/train/reference.h"

#include <sys/stat.h>

static const char rod[] = "rod: {length: 2, stiffness: {bending: [1, 1.5], torsion: 1, "
                          "shear: [100, 100], axial: 200}}\n"
                          "loads: {tip: {force: [0.7, 0.2, 0]}}\n"
                          "network: {hidden: [6]}\n"
                          "training: {stages: [{optimizer: adam, steps: 1}]}\n"
                          "reference: solve\n";

/* ---- the folder of the cache --------------------------------------------------------------- */

static int list_cache(char names[][64], int most)
{
    int count = 0;
    DIR *dir = opendir(at("cpinn"));
    for (struct dirent *entry; dir && count < most && (entry = readdir(dir));) {
        if (entry->d_name[0] != '.') {
            snprintf(names[count++], 64, "cpinn/%.50s", entry->d_name);
        }
    }
    if (dir) {
        closedir(dir);
    }
    return count;
}

static int cached(void)
{
    char names[16][64];
    return list_cache(names, 16);
}

static int begin(void **state)
{
    return make_directory(state) == 0 ? setenv("XDG_CACHE_HOME", directory, 1) : -1;
}

static int end(void **state)
{
    char names[16][64];
    for (int count = list_cache(names, 16); count > 0; count--) {
        remove(at(names[count - 1]));
    }
    return remove_directory(state);
}

/* ---- references ---------------------------------------------------------------------------- */

/* What a reference came to: the errors of the untrained network, to the bit. */
typedef struct outcome {
    reference_errors errors, estimates;
    char account[640], remark[640];
    size_t points;
} outcome;

static outcome outcome_of(const char *path, const char *text, const char *override)
{
    outcome o;
    ad_error error = {.message = ""};
    reference *r = NULL;
    experiment *e = experiment_of(path, text, override);
    if (reference_create(e, &r, &error) != AD_OK ||
        reference_compare(r, e->parameters, &o.errors, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    o.estimates = reference_estimates(r);
    o.points = reference_points(r);
    snprintf(o.account, sizeof o.account, "%s", reference_account(r));
    snprintf(o.remark, sizeof o.remark, "%s", reference_remark(r));
    reference_free(r);
    experiment_free(e);
    return o;
}

static outcome solve(const char *override)
{
    return outcome_of("rod.yaml", rod, override);
}

static void assert_same(const outcome *a, const outcome *b)
{
    assert_memory_equal(&a->errors, &b->errors, sizeof a->errors);
    assert_memory_equal(&a->estimates, &b->estimates, sizeof a->estimates);
}

static void assert_says(const char *text, const char *expected)
{
    if (!strstr(text, expected)) {
        fail_msg("'%s' is not in: %s", expected, text);
    }
}

/* Against the closed form: the untrained network is as far from both. */
static void test_values(void **state)
{
    (void)state;
    outcome known = outcome_of("configs/elastica.yaml", NULL, NULL);
    outcome solved = outcome_of("configs/elastica.yaml", NULL, "reference=solve");
    assert_int_equal(solved.points, 101);
    assert_near(solved.errors.position, known.errors.position, 1e-10);
    assert_near(solved.errors.tip, known.errors.tip, 1e-10);
    assert_near(solved.errors.rotation, known.errors.rotation, 1e-10);
    assert_true(solved.estimates.position_max > 0 && solved.estimates.position_max <= 1e-11);
    assert_true(solved.estimates.position > solved.estimates.position_max); /* |r| < L */
    assert_true(isnan(known.estimates.position) && isnan(known.estimates.position_max));
    assert_string_equal(known.account, "");
    assert_int_equal(cached(), 1);
}

/* A motion that differs from its manufactured solution by no more than was asked for; by a network
 * in mixed form, and by modes of the strain, which have no position among their outputs. */
#define MADE                                                                                       \
    "rod: {model: cosserat, length: 1, stiffness: {bending: [1, 1], torsion: 1, shear: [100, "     \
    "100], axial: 100}, inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.02]}}\n"              \
    "time: {duration: 0.5, windows: 1}\n"                                                          \
    "manufactured: {position: [0.1*s^2*t^2, 0, s], angles: [0, 0.1*s*t, 0]}\n"

static void test_motion(void **state)
{
    (void)state;
    static const char *const texts[] = {
        MADE "network: {hidden: [6]}\ntraining: {stages: [{optimizer: adam, steps: 1}]}\n",
        MADE "formulation: strain\n"};
    for (int i = 0; i < 2; i++) {
        outcome known = outcome_of("moving.yaml", texts[i], "reference.analytic=manufactured");
        outcome solved = outcome_of("moving.yaml", texts[i], "reference.solve=1e-6");
        outcome kept = outcome_of("moving.yaml", texts[i], "reference.solve=1e-6");
        assert_int_equal(solved.points, 41 * 41);
        assert_near(solved.errors.position, known.errors.position, 1e-6);
        assert_near(solved.errors.tip, known.errors.tip, 1e-6);
        assert_says(kept.account, ", from ");
        assert_same(&solved, &kept);
    }
}

/* ---- hits and misses ----------------------------------------------------------------------- */

static void test_hit(void **state)
{
    (void)state;
    outcome first = solve(NULL), second = solve(NULL);
    assert_says(first.account, "solved classically, estimated error ");
    assert_says(first.account, " of the length, 0.");
    assert_says(second.account, ", from ");
    assert_says(second.account, directory);
    assert_string_equal(first.remark, "");
    assert_string_equal(second.remark, "");
    assert_same(&first, &second);
    assert_int_equal(cached(), 1);
}

/* Solving anew gives the same bits, so that it never matters whether the cache is there. */
static void test_no_cache(void **state)
{
    (void)state;
    char home[256];
    const char *before = getenv("HOME");
    outcome kept = solve(NULL);
    snprintf(home, sizeof home, "%s", before ? before : "");
    unsetenv("HOME");
    setenv("XDG_CACHE_HOME", "relative/does/not/count", 1);
    outcome solved = solve(NULL);
    if (before) {
        setenv("HOME", home, 1);
    }
    assert_says(solved.account, " of the length, 0.");
    assert_string_equal(solved.remark, "");
    assert_same(&kept, &solved);
    assert_int_equal(cached(), 1);
}

static void test_home(void **state)
{
    (void)state;
    static const char *const folders[] = {".cache/cpinn", ".cache"};
    char home[256], made[512], name[64] = "";
    const char *before = getenv("HOME");
    snprintf(home, sizeof home, "%s", before ? before : "");
    unsetenv("XDG_CACHE_HOME");
    setenv("HOME", directory, 1);
    outcome o = solve(NULL);
    if (before) {
        setenv("HOME", home, 1);
    }
    assert_string_equal(o.remark, "");
    snprintf(made, sizeof made, "%s", at(folders[0]));
    DIR *dir = opendir(made);
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir));) {
        if (entry->d_name[0] != '.') {
            snprintf(name, sizeof name, "%.60s", entry->d_name);
        }
    }
    closedir(dir);
    assert_int_equal(strlen(name), 16 + strlen(".h5"));
    strcat(strcat(made, "/"), name);
    assert_int_equal(remove(made), 0);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(rmdir(at(folders[i])), 0);
    }
}

static void put(const char *name, const unsigned char *bytes, size_t size)
{
    FILE *file = fopen(at(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static size_t take(const char *name, unsigned char *bytes, size_t most)
{
    FILE *file = fopen(at(name), "rb");
    assert_non_null(file);
    size_t size = fread(bytes, 1, most, file);
    assert_int_equal(fclose(file), 0);
    return size;
}

/* Whatever stands in the file's place is found out, solved anew and replaced. */
static void test_damaged(void **state)
{
    (void)state;
    static unsigned char good[65536], bad[65536];
    char names[2][64];
    outcome first = solve(NULL);
    assert_int_equal(list_cache(names, 2), 1);
    size_t size = take(names[0], good, sizeof good);
    assert_true(size < sizeof good);
    for (int i = 0; i < 4; i++) {
        size_t length = i == 0 ? 0 : i == 1 ? size / 2 : size;
        memcpy(bad, good, size);
        bad[i == 2 ? 0 : size - 300] ^= 1;
        put(names[0], bad, length);
        outcome damaged = solve(NULL), after = solve(NULL);
        assert_says(damaged.remark, "is damaged or of another scene; solved anew");
        assert_says(damaged.remark, names[0]);
        assert_same(&first, &damaged);
        assert_string_equal(after.remark, "");
        assert_says(after.account, ", from ");
        assert_same(&first, &after);
    }
}

/* A whole file of another scene, as if the hashes were the same. */
static void test_collision(void **state)
{
    (void)state;
    static unsigned char bytes[65536];
    char mine[1][64], both[2][64];
    outcome first = solve(NULL);
    assert_int_equal(list_cache(mine, 1), 1);
    outcome other = solve("loads.tip.force[0]=0.6");
    assert_int_equal(list_cache(both, 2), 2);
    assert_true(first.errors.position != other.errors.position);
    size_t size = take(strcmp(both[0], mine[0]) == 0 ? both[1] : both[0], bytes, sizeof bytes);
    put(mine[0], bytes, size);
    outcome again = solve(NULL);
    assert_says(again.remark, "of another scene; solved anew");
    assert_same(&first, &again);
}

static void test_unwritable(void **state)
{
    (void)state;
    const unsigned char byte = 0;
    put("file", &byte, 1);
    outcome kept = solve(NULL);
    setenv("XDG_CACHE_HOME", at("file"), 1);
    outcome solved = solve(NULL);
    assert_says(solved.remark, "file/cpinn/");
    assert_says(solved.remark, "cannot be written");
    assert_says(solved.remark, "not kept for the next run");
    assert_null(strchr(solved.remark, '\n'));
    assert_says(solved.account, " of the length, 0.");
    assert_same(&kept, &solved);
}

/* ---- ways to ask for it --------------------------------------------------------------------- */

/* NaN: not asked for. */
static double tolerance_of(const char *path, const char *text, const char *override)
{
    ad_error error = {.message = ""};
    config *settings = NULL;
    if (prepare_read(path, text, override != NULL, &override, &settings, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    double tolerance = settings->settings.reference_tolerance;
    assert_true(isnan(tolerance) || train_names_reference(&settings->settings));
    config_free(settings);
    return tolerance;
}

static void test_ways(void **state)
{
    (void)state;
    const char *with_file = "configs/cantilever_dynamic.yaml";
    assert_true(tolerance_of("rod.yaml", rod, NULL) == 1e-11);
    assert_true(tolerance_of("rod.yaml", rod, "reference={solve: 1e-5}") == 1e-5);
    assert_true(tolerance_of("rod.yaml", rod, "reference.solve=1e-5") == 1e-5);
    assert_true(isnan(tolerance_of("rod.yaml", rod, "reference.solve=null")));
    assert_true(isnan(tolerance_of("rod.yaml", rod, "reference=null")));
    assert_true(isnan(tolerance_of(with_file, NULL, NULL)));
    assert_true(tolerance_of(with_file, NULL, "reference=solve") == 1e-8); /* replaces the file */
    assert_true(tolerance_of("configs/elastica.yaml", NULL, "reference=solve") == 1e-11);
    assert_true(tolerance_of("configs/heavy_cantilever.yaml", NULL, NULL) == 1e-11);
}

/* ---- what a solution depends on ------------------------------------------------------------ */

static char *physics(const char *text, const char *override)
{
    ad_error error = {.message = ""};
    config *settings = NULL;
    char *written = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&written, &size);
    assert_non_null(file);
    if (prepare_read("a.yaml", text, override != NULL, &override, &settings, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(config_write_physics(settings, file), AD_OK);
    assert_int_equal(fclose(file), 0);
    config_free(settings);
    return written;
}

static bool same_physics(const char *first, const char *text, const char *override)
{
    char *second = physics(text, override);
    bool same = strcmp(first, second) == 0;
    free(second);
    return same;
}

/* The same scene, written in other ways and given to other networks. */
static void test_same_physics(void **state)
{
    (void)state;
    static const char reordered[] = "# a comment\n"
                                    "reference:\n"
                                    "  solve: 1.0e-11   # the default\n"
                                    "loads: {tip: {force: [0.70, 2.0e-1, 0]}}\n"
                                    "rod:\n"
                                    "  stiffness:\n"
                                    "    axial: 200\n"
                                    "    shear: [100, 100.0]\n"
                                    "    torsion: 1\n"
                                    "    bending: [1, 1.5]\n"
                                    "  length: 2.0\n";
    static const char *const overrides[] = {"name=other",
                                            "network.hidden=[7, 7]",
                                            "losses.interior.points=33",
                                            "losses.interior.weights.strain=7",
                                            "training.seed=5",
                                            "training.stages=[{optimizer: lbfgs, steps: 3}]",
                                            "checkpoint.every=7",
                                            "output.every=3",
                                            "formulation=displacement",
                                            "motion=spatial",
                                            "enforcement.boundary=soft"};
    char *first = physics(rod, NULL);
    assert_true(same_physics(first, reordered, NULL));
    for (size_t i = 0; i < sizeof overrides / sizeof *overrides; i++) {
        if (!same_physics(first, rod, overrides[i])) {
            fail_msg("%s changes the physics", overrides[i]);
        }
    }
    assert_true(same_physics(first, first, NULL)); /* and so it names all of the physics */
    free(first);
}

static void test_other_physics(void **state)
{
    (void)state;
    static const char *const overrides[] = {"rod.stiffness.shear[0]=99",
                                            "rod.length=2.0000000000000004",
                                            "rod.stiffness.bending[1]=1.6",
                                            "rod.stiffness.torsion=2",
                                            "rod.stiffness.axial=201",
                                            "rod.rest.curvature=[0, s, 0]",
                                            "loads.tip.force[1]=0.3",
                                            "loads.tip.frame=follower",
                                            "loads.units=EI",
                                            "loads.force=[0, 0, 1]",
                                            "boundary.start.position=[0, 0, 1]",
                                            "boundary.start.rotation=[0, 1, 0, 1]",
                                            "reference.solve=1e-9"};
    char *first = physics(rod, NULL);
    for (size_t i = 0; i < sizeof overrides / sizeof *overrides; i++) {
        if (same_physics(first, rod, overrides[i])) {
            fail_msg("%s does not change the physics", overrides[i]);
        }
    }
    free(first);
}

/* Every key of the sections that describe a scene is part of it, those to come as well. */
static void test_every_key(void **state)
{
    (void)state;
    static const char *const sections[] = {"rod.",       "loads.",        "beam.",
                                           "boundary.",  "initial.",      "manufactured.",
                                           "reference.", "time.duration", "residual."};
    char *written = physics(rod, NULL);
    int found = 0, expected = 0;
    for (const char *line = written; *line; line += strcspn(line, "\n") + 1) {
        const char *colon = strchr(line, ':');
        found += strcspn(line, "\n") > (size_t)(colon - line) + 1 && *line != '#';
    }
    for (int i = 0; i < config_key_count; i++) {
        for (size_t k = 0; k < sizeof sections / sizeof *sections; k++) {
            bool listed = config_list_of(config_keys[i].path) != NULL;
            expected +=
                !listed && strncmp(config_keys[i].path, sections[k], strlen(sections[k])) == 0;
        }
    }
    for (int i = 0; i < config_list_count; i++) { /* one line each, as they are empty here */
        expected += strncmp(config_lists[i].path, "training", 8) != 0 &&
                    strncmp(config_lists[i].path, "optimize", 8) != 0 &&
                    strncmp(config_lists[i].path, "control", 7) != 0 &&
                    strncmp(config_lists[i].path, "plan", 4) != 0 &&
                    strcmp(config_lists[i].path, "tables") != 0 &&
                    strcmp(config_lists[i].path, "data") != 0;
    }
    assert_int_equal(found, expected);
    free(written);
}

/* ---- what cannot be had -------------------------------------------------------------------- */

static void assert_refused(const char *text, const char *override, const char *expected)
{
    ad_error error = {.message = ""};
    reference *r = NULL;
    experiment *e = experiment_of("rod.yaml", text, override);
    assert_int_equal(reference_create(e, &r, &error), AD_BAD_INPUT);
    assert_null(r);
    assert_says(error.message, expected);
    assert_null(strchr(error.message, '\n'));
    experiment_free(e);
    assert_int_equal(cached(), 0);
}

static void test_refused(void **state)
{
    (void)state;
    static const char squeezed[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"
        "boundary: {end: {type: clamped, position: [0, 0, 0.6], rotation: [1, 0, 0, 0]}}\n"
        "reference: solve\n";
    assert_refused(squeezed, NULL, "rod.yaml:3:12: reference.solve: solving stops at 0.9");
    assert_refused(squeezed, "reference.solve=1e-3",
                   "override reference.solve=1e-3: reference.solve: solving stops at 0.9");
}

/* The estimate is over the deflection, here an eighth of the length, those of errors over the
 * length. */
static void test_beam(void **state)
{
    (void)state;
    const char *path = "configs/beam_cantilever.yaml";
    outcome known = outcome_of(path, NULL, NULL);
    for (int kept = 0; kept < 2; kept++) {
        outcome solved = outcome_of(path, NULL, "reference=solve");
        assert_near(solved.errors.position, known.errors.position, 1e-10);
        assert_near(solved.errors.tip, known.errors.tip, 1e-10);
        assert_says(solved.account, " of the deflection, ");
        assert_says(solved.account, kept ? "from " : " s");
        double told = strtod(strstr(solved.account, "error ") + 6, NULL);
        assert_near(solved.estimates.position_max, told / 8, 0.01 * told);
    }
}

/* A straight column is an equilibrium beside others. */
static void test_several_equilibria(void **state)
{
    (void)state;
    static const char column[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8}}\n"
        "loads: {tip: {force: [0, 0, -5]}}\nreference: solve\n";
    outcome solved = outcome_of("column.yaml", column, NULL);
    outcome kept = outcome_of("column.yaml", column, NULL);
    assert_says(solved.account, "several equilibria");
    assert_says(kept.account, "several equilibria");
    assert_says(solved.account, "which is unstable");
    assert_says(kept.account, "which is unstable");
}

/* Errors below that of the reference are not told apart. */
static bool is_too_coarse(const reference *r, double position_max, verdict *found)
{
    *found = (verdict){.count = 0};
    reference_verdict(r, &(reference_errors){.position_max = position_max}, 0, found);
    return verdict_has(found, VERDICT_REFERENCE_TOO_COARSE);
}

static void test_too_coarse(void **state)
{
    (void)state;
    verdict found;
    experiment *e = experiment_of("rod.yaml", rod, "reference.solve=1e-4");
    reference *r = NULL;
    assert_int_equal(reference_create(e, &r, NULL), AD_OK);
    double estimate = reference_estimates(r).position_max;
    assert_true(is_too_coarse(r, 0.9 * estimate, &found));
    assert_int_equal(verdict_outcome_of(&found), VERDICT_SOLVED);
    assert_says(verdict_text(&found), "the reference itself is off by an estimated ");
    assert_false(is_too_coarse(r, 1.1 * estimate, &found));
    assert_false(is_too_coarse(r, NAN, &found));
    reference_free(r);
    experiment_free(e);
    e = experiment_of("configs/elastica.yaml", NULL, NULL);
    assert_int_equal(reference_create(e, &r, NULL), AD_OK);
    assert_false(is_too_coarse(r, 0, &found));
    reference_free(r);
    experiment_free(e);
}

/* An error that neither estimate allows is a warning, and nobody finds that reference again. */
static void test_contradicts(void **state)
{
    (void)state;
    verdict found = {.count = 0};
    experiment *e = experiment_of("rod.yaml", rod, "reference.solve=1e-4");
    reference *r = NULL;
    assert_int_equal(reference_create(e, &r, NULL), AD_OK);
    const double estimate = reference_estimates(r).position_max, own = 1e-3;
    const reference_errors near = {.position_max = 9 * (estimate + own)};
    const reference_errors far = {.position_max = 11 * (estimate + own)};
    reference_verdict(r, &near, own, &found);
    reference_verdict(r, &far, NAN, &found); /* who has no estimate excludes nothing */
    assert_int_equal(found.count, 0);
    reference_verdict(r, &far, own, &found);
    assert_true(verdict_has(&found, VERDICT_ESTIMATES_CONTRADICT));
    assert_int_equal(verdict_exit_status(&found), 3);
    reference_free(r);
    assert_int_equal(reference_create(e, &r, NULL), AD_OK);
    assert_says(reference_account(r), "from "); /* kept */
    reference_forget(r);
    reference_free(r);
    assert_int_equal(reference_create(e, &r, NULL), AD_OK);
    assert_null(strstr(reference_account(r), "from "));
    reference_free(r);
    experiment_free(e);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)
    const struct CMUnitTest tests[] = {TEST(test_values),        TEST(test_motion),
                                       TEST(test_hit),           TEST(test_no_cache),
                                       TEST(test_home),          TEST(test_damaged),
                                       TEST(test_collision),     TEST(test_unwritable),
                                       TEST(test_ways),          TEST(test_same_physics),
                                       TEST(test_other_physics), TEST(test_every_key),
                                       TEST(test_contradicts),   TEST(test_refused),
                                       TEST(test_beam),          TEST(test_several_equilibria),
                                       TEST(test_too_coarse)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
