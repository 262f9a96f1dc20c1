/* scenes [--scene CONFIG.yaml]... [--points N] [--width N] [--threads N]
 *
 * What a scene does not need is not computed: the time of one value and gradient of each scene, all
 * with the same network (3 hidden layers of tanh) and the same number of points, and what was left
 * out of each. Without scenes: every model, at rest and in motion, in mixed and in strong form,
 * under a load along the rod. The scenes take turns, so that a busy moment slows all of them;
 * medians. Ratios are to the last scene. */
#include "physics/numerics/sort.h"
#include "tools/prepare/config_experiment.h"
#include "tools/programs/cli.h"
#include "tools/programs/help.h"
#include "tools/train/clock.h"
#include "tools/train/trainer.h"

#include <stdlib.h>
#include <string.h>

enum { REPETITIONS = 15, SCENES_MAX = 24 };

static const char program[] = "scenes";

typedef struct entrant {
    experiment *e;
    problem *problem;
    double *gradient;
    double seconds[REPETITIONS];
    problem_set_info info;
} entrant;

/* Of a / b round by round, b = NULL: of a. */
static double median(const double *a, const double *b)
{
    double numbers[REPETITIONS];
    for (int r = 0; r < REPETITIONS; r++) {
        numbers[r] = b ? a[r] / b[r] : a[r];
    }
    return sort_median(REPETITIONS, numbers);
}

/* `text`: of the scene, or NULL for the file `path`; `same`: what all scenes have in common. */
static ad_status enter(entrant *scene, const char *path, const char *text,
                       const char *const same[2], int threads, ad_error *error)
{
    config *settings;
    ad_status status = prepare_read(path, text, 2, same, &settings, error);
    if (status == AD_OK) {
        status = config_experiment_create(settings, threads, &scene->e, error);
    }
    if (status == AD_OK) {
        status = experiment_problem(scene->e, &scene->problem, error);
    }
    if (status != AD_OK) {
        return status;
    }
    scene->info = problem_set_inspect(scene->problem, 0);
    scene->gradient = malloc(scene->e->count * sizeof *scene->gradient);
    return scene->gradient ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
}

/* ---- the models ------------------------------------------------------------------------------ */

/* One rod for all of them; a model locks what it lacks. Strong form: second order in s, of
 * euler_bernoulli fourth; a locked strain has no constitutive law, and so kirchhoff no strong form.
 */
typedef struct model_row {
    const char *name, *text;
    bool has_strong_form;
} model_row;

#define INERTIA "  inertia: {mass_per_length: 1, rotary: [6.25e-4, 6.25e-4, 1.25e-3]}\n"
#define KIRCHHOFF                                                                                  \
    "rod:\n  model: kirchhoff\n  length: 1\n"                                                      \
    "  stiffness: {bending: [1, 1], torsion: 0.77}\n" INERTIA
#define COSSERAT                                                                                   \
    "rod:\n  model: cosserat\n  length: 1\n"                                                       \
    "  stiffness: {shear: [545, 545], axial: 1600, bending: [1, 1], torsion: 0.77}\n" INERTIA

static const model_row models[] = {
    {"euler_bernoulli",
     "rod:\n  model: euler_bernoulli\n  length: 1\n  stiffness: {bending: [1, 1]}\n"
     "  inertia: {mass_per_length: 1}\nbeam: {force: 1}\n",
     true},
    {"timoshenko",
     "rod:\n  model: timoshenko\n  length: 1\n"
     "  stiffness: {bending: [1, 1], shear: [545, 545]}\n" INERTIA "beam: {force: 1}\n",
     true},
    {"kirchhoff_planar", KIRCHHOFF "loads: {force: [1, 0, 0]}\nmotion: planar\n", false},
    {"kirchhoff_spatial", KIRCHHOFF "loads: {force: [1, 1, 0]}\n", false},
    {"cosserat_planar", COSSERAT "loads: {force: [1, 0, 0]}\nmotion: planar\n", true},
    {"cosserat_spatial", COSSERAT "loads: {force: [1, 1, 0]}\n", true}};

static ad_status enter_models(entrant *scenes, const char *const same[2], int threads, int *entered,
                              ad_error *error)
{
    ad_status status = AD_OK;
    for (int moving = 0; moving <= 1; moving++) {
        for (size_t m = 0; m < sizeof models / sizeof *models; m++) {
            for (int strong = models[m].has_strong_form; strong >= 0 && status == AD_OK; strong--) {
                char text[1024];
                snprintf(text, sizeof text,
                         "name: %s_%s_%s\ntime: {duration: %d}\nformulation: %s\n%s",
                         moving ? "dynamic" : "static", models[m].name, strong ? "strong" : "mixed",
                         moving, strong ? "displacement" : "mixed", models[m].text);
                status = enter(&scenes[(*entered)++], models[m].name, text, same, threads, error);
            }
        }
    }
    return status;
}

/* ---- times ----------------------------------------------------------------------------------- */

static void leave(entrant *scene)
{
    problem_free(scene->problem);
    experiment_free(scene->e);
    free(scene->gradient);
}

static ad_status race(entrant *scenes, int count, ad_error *error)
{
    for (int r = -1; r < REPETITIONS; r++) { /* the first round warms up */
        for (int i = 0; i < count; i++) {
            double loss, start = train_seconds();
            ad_status status = problem_evaluate(scenes[i].problem, scenes[i].e->parameters, &loss,
                                                scenes[i].gradient, error);
            if (status != AD_OK) {
                return status;
            }
            if (r >= 0) {
                scenes[i].seconds[r] = train_seconds() - start;
            }
        }
    }
    return AD_OK;
}

/* ---- table ----------------------------------------------------------------------------------- */

static int equations_inside(const scene *scene)
{
    int rows = 0;
    for (int kind = ROD_STRAIN; kind <= ROD_TORSION; kind++) {
        rows += scene_physics_of(scene)->residual_rows(scene, (rod_residual_kind)kind);
    }
    return rows;
}

static bool any_has(const entrant *scenes, int count, const char *name)
{
    for (int i = 0; i < count; i++) {
        const scene *scene = scenes[i].e->scene;
        rod_term terms[ROD_TERM_MAX];
        int all = scene_physics_of(scene)->terms(scene, terms);
        for (int k = 0; k < all; k++) {
            if (terms[k].present && strcmp(terms[k].name, name) == 0) {
                return true;
            }
        }
    }
    return false;
}

/* What this scene lacks and another one has; a reason once behind terms in a row. */
static void print_left_out(const entrant *scenes, int count, const scene *scene)
{
    rod_term terms[ROD_TERM_MAX];
    int all = scene_physics_of(scene)->terms(scene, terms), left = 0;
    for (int i = 0; i < all; i++) {
        if (!terms[i].present && any_has(scenes, count, terms[i].name)) {
            terms[left++] = terms[i];
        }
    }
    for (int i = 0; i < left; i++) {
        bool last = i + 1 == left || strcmp(terms[i].reason, terms[i + 1].reason) != 0;
        printf("%s%s", i ? ", " : "    without ", terms[i].name);
        if (last) {
            printf(" (%s)", terms[i].reason);
        }
    }
    printf("%s", left ? "\n" : "");
}

static void report(const entrant *scenes, int count)
{
    printf("%-32s %9s %7s %13s %12s %9s %10s\n", "scene", "us/point", "ratio", "instructions",
           "flops/point", "unknowns", "equations");
    for (int i = 0; i < count; i++) {
        const problem_set_info *info = &scenes[i].info;
        const scene *scene = scenes[i].e->scene;
        printf("%-32s %9.3f %7.3f %13zu %12.0f %9d %10d\n", scenes[i].e->settings->name,
               1e6 * median(scenes[i].seconds, NULL) / (double)info->points,
               median(scenes[i].seconds, scenes[count - 1].seconds), info->program.instructions,
               (double)info->program.flops_per_point,
               scene_physics_of(scene)->network_outputs(scene), equations_inside(scene));
        print_left_out(scenes, count, scene);
    }
}

int main(int count, char **arguments)
{
    int points = 4096, width = 64, threads = 1, entered = 0;
    const char *operand;
    cli_list given = {0};
    const cli_program about = {program, NULL, help_scenes, NULL, NULL};
    const cli_option known[] = {{"--scene", "CONFIG.yaml", CLI_LIST, &given, 0, 0},
                                {"--points", "N", CLI_INTEGER, &points, 2, 1e7},
                                {"--width", "N", CLI_INTEGER, &width, 1, 4096},
                                {"--threads", "N", CLI_INTEGER, &threads, 1, 1024}};
    int result = cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &operand);
    if (result != CLI_RUN) {
        return result;
    }
    char network[64], interior[64];
    snprintf(network, sizeof network, "network={hidden: [%d, %d, %d], activation: tanh}", width,
             width, width);
    snprintf(interior, sizeof interior, "losses.interior={points: %d, sampler: sobol}", points);
    const char *const same[2] = {network, interior};
    entrant scenes[SCENES_MAX] = {{0}};
    ad_error error = {AD_OK, ""};
    ad_status status = AD_OK;
    for (; status == AD_OK && entered < given.count && entered < SCENES_MAX; entered++) {
        status = enter(&scenes[entered], given.texts[entered], NULL, same, threads, &error);
    }
    if (given.count == 0) {
        status = enter_models(scenes, same, threads, &entered, &error);
    }
    if (status == AD_OK) {
        status = race(scenes, entered, &error);
    }
    if (status == AD_OK) {
        report(scenes, entered);
    } else {
        result = cli_fail_error(program, &error);
    }
    for (int i = 0; i < entered; i++) {
        leave(&scenes[i]);
    }
    return result;
}
