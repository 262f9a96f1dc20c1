/* The library in a host that is no program of ours: exceptions of floating-point numbers are
 * signals there, numbers are rounded otherwise, subnormal ones flushed, and the environment is the
 * host's. What a function gets wrong ends the test: by a signal, or by what stands below. */
#define _GNU_SOURCE /* feenableexcept */
#include "near.h"
#include "temporary_folder.h"

#include "autodiff/dense.h"
#include "autodiff/host.h"
#include "cpinn.h"

#include <dlfcn.h>
#include <fenv.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define ELASTICA "configs/elastica.yaml"
#define MOTION   "configs/cantilever_dynamic.yaml"

/* ---- the environment ------------------------------------------------------------------------ */

extern char **environ;
static int changes; /* of the environment, while others may look at it */

int setenv(const char *name, const char *value, int overwrite)
{
    (void)name, (void)value, (void)overwrite;
    changes++;
    return 0;
}

int unsetenv(const char *name)
{
    const size_t length = strlen(name);
    changes++;
    for (char **text = environ; *text; text++)
        if (strncmp(*text, name, length) == 0 && (*text)[length] == '=') {
            for (char **at = text; *at; at++)
                at[0] = at[1];
            return 0;
        }
    return 0;
}

int putenv(char *text)
{
    (void)text;
    changes++;
    return 0;
}

/* As other threads do with setenv: the host's environment is another one, with a further variable,
 * from the first look of OpenBLAS on. */
static bool others_change;
static char *changed[8], other[] = "OTHER=1";

char *getenv(const char *name)
{
    const size_t length = strlen(name);
    if (others_change && strncmp(name, "OPENBLAS_", 9) == 0 && environ[1]) {
        others_change = false;
        size_t count = 0;
        for (; environ[count]; count++)
            changed[count] = environ[count];
        changed[count] = other;
        environ = changed;
    }
    for (char **text = environ; text && *text; text++)
        if (strncmp(*text, name, length) == 0 && (*text)[length] == '=')
            return *text + length + 1;
    return NULL;
}

static int count_threads(void)
{
    char line[256];
    int count = 0;
    FILE *file = fopen("/proc/self/status", "r");
    while (file && fgets(line, sizeof line, file))
        sscanf(line, "Threads: %d", &count);
    if (file)
        fclose(file);
    return count;
}

/* OpenBLAS is loaded with variables of its own, without a change to those of the host. */
static void test_environment(void **state)
{
    (void)state;
    static char *none[3];
    char **before = environ;
    for (char **text = before; *text; text++)
        if (strncmp(*text, "PATH=", 5) == 0)
            none[0] = *text;
    environ = none;
    const pid_t child = fork();
    if (child == 0) {
        others_change = true;
        const bool good = *ad_dense_kernels() && count_threads() == 1 && environ == changed &&
                          changed[0] == none[0] && changed[1] &&
                          strcmp(changed[1], "OTHER=1") == 0 && !changed[2];
        _exit(good ? 0 : 1);
    }
    int ended;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_int_equal(ended, 0);
    const pid_t other_child = fork();
    if (other_child == 0) { /* of a host that has loaded the same library, with two threads */
        void *loaded = dlopen("libopenblas.so.0", RTLD_NOW | RTLD_LOCAL), *function[2];
        void (*set)(int);
        int (*get)(void);
        function[0] = loaded ? dlsym(loaded, "openblas_set_num_threads") : NULL;
        function[1] = loaded ? dlsym(loaded, "openblas_get_num_threads") : NULL;
        memcpy(&set, &function[0], sizeof set);
        memcpy(&get, &function[1], sizeof get);
        if (set && get) {
            set(2);
            _exit(get() == 2 && *ad_dense_kernels() && get() == 1 ? 0 : 1);
        }
        _exit(0);
    }
    assert_int_equal(waitpid(other_child, &ended, 0), other_child);
    assert_int_equal(ended, 0);
    assert_true(*ad_dense_kernels());
    assert_int_equal(count_threads(), 1); /* OPENBLAS_NUM_THREADS=1 was seen */
    assert_ptr_equal(environ, none);
    assert_null(none[1]);
    assert_int_equal(changes, 0);
    environ = before;
}

/* ---- floating-point numbers ----------------------------------------------------------------- */

/* All that the face of the library computes; what it gives, as text. */
static void use_everything(char *results, size_t room)
{
    static const char *const steps[] = {"training.stages=[{optimizer: adam, steps: 3}, "
                                        "{optimizer: gauss_newton, steps: 2}]"};
    static const char *const ranges[] = {"parameters={force: {range: [0, 4]}}",
                                         "loads.tip.force=[force, 0, 0]",
                                         "reference=null",
                                         "formulation=strain",
                                         "network.hidden=[4]",
                                         "members.solved=20",
                                         "training.stages=[{optimizer: adam, steps: 3}]"};
    const cpinn_options options = {.threads = 2};
    const double s[2] = {0.1, 0.3}, t[2] = {0, 0.1}, given[2] = {1, 3};
    double values[2 * MODEL_COLUMNS_MAX], more[2 * 2 * SOLVE_MEMBERS_COLUMNS];
    ad_error error = {AD_OK, ""};
    cpinn_model *model;
    evaluator *tip;
    FILE *file = fmemopen(results, room, "w");
#define GOOD(call)                                                                                 \
    if ((call) != AD_OK)                                                                           \
    fail_msg("%s: %s", #call, error.message)
    GOOD(cpinn_train_file(ELASTICA, 1, steps, &options, &model, &error));
    GOOD(cpinn_save(model, at("run.h5"), &error));
    cpinn_free(model);
    GOOD(cpinn_open(at("run.h5"), &model, &error));
    GOOD(cpinn_evaluator(model, "x z_ss", &tip, &error));
    GOOD(evaluator_evaluate(tip, 2, s, NULL, values, &error));
    fprintf(file, "%a %a %a\n", values[0], values[2],
            cpinn_history_value(model, cpinn_history_rows(model) - 1, "loss"));
    evaluator_free(tip);
    cpinn_free(model);

    static const char *const scenes[] = {ELASTICA, MOTION};
    for (int i = 0; i < 2; i++) {
        cpinn_solution *solved;
        GOOD(cpinn_solve_file(scenes[i], 0, NULL, NULL, 2, t, &solved, &error));
        GOOD(cpinn_solution_evaluate(solved, 2, s, t, values, &error));
        fprintf(file, "%a %a\n", values[1], cpinn_solution_estimate(solved));
        cpinn_solution_free(solved);
    }

    const cpinn_family_settings points = {.extrapolate = true, .threads = 2, .points = 2, .s = s};
    cpinn_answer answers[2];
    cpinn_family *family;
    cpinn_family_check check;
    GOOD(cpinn_family_file(ELASTICA, 3, ranges, 0, &points, &family, &error));
    GOOD(cpinn_family_evaluate(family, NULL, 2, given, more, answers, &error));
    fprintf(file, "%a %a\n", more[0], answers[1].error);
    /* no equilibrium is found */
    GOOD(cpinn_family_evaluate(family, NULL, 2, (double[]){1e6, 1e300}, more, answers, &error));
    cpinn_family_free(family);
    GOOD(cpinn_train_file(ELASTICA, 7, ranges, &options, &model, &error));
    GOOD(cpinn_save(model, at("family.h5"), &error));
    cpinn_free(model);
    GOOD(cpinn_family_open(at("family.h5"), &points, &family, &error));
    GOOD(cpinn_family_evaluate(family, NULL, 2, given, more, answers, &error));
    fprintf(file, "%a %a\n", more[0], answers[1].error);
    GOOD(cpinn_family_evaluate(family, NULL, 2, (double[]){1e6, -1e300}, more, answers, &error));
    GOOD(cpinn_family_verify(family, 4, 1, &check, &error));
    assert_int_equal(cpinn_family_evaluate(family, NULL, 1, &(double){NAN}, more, answers, &error),
                     AD_BAD_ARGUMENT);
    cpinn_family_free(family);

    cpinn_unknowns *found;
    GOOD(cpinn_identify_file("configs/identify/stiffness.yaml", 0, NULL, 1, &found, &error));
    fprintf(file, "%a\n", cpinn_unknowns_value(found, 0));
    cpinn_unknowns_free(found);
    fclose(file);
}

/* The same bits as without, no signal, and the host's settings are as they were. */
static void test_numbers(void **state)
{
    (void)state;
    static char usual[2000], results[2000];
    const int signals = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;
    use_everything(usual, sizeof usual);
    feclearexcept(FE_ALL_EXCEPT);
    if (feenableexcept(signals) == -1)
        skip(); /* a processor without */
    use_everything(results, sizeof results);
    assert_int_equal(fegetexcept(), signals);
    assert_int_equal(fetestexcept(signals), 0);
    fedisableexcept(signals);
    assert_string_equal(results, usual);
#if defined(__SSE2__)
    const unsigned flush = 0x8040, before = _mm_getcsr();
    _mm_setcsr(before | flush);
#endif
    fesetround(FE_UPWARD);
    use_everything(results, sizeof results);
    assert_int_equal(fegetround(), FE_UPWARD);
    fesetround(FE_TONEAREST);
#if defined(__SSE2__)
    assert_int_equal(_mm_getcsr() & flush, flush);
    _mm_setcsr(before);
#endif
    assert_string_equal(results, usual);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_environment),
        cmocka_unit_test_setup_teardown(test_numbers, make_directory, remove_directory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
