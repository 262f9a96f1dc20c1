/* cpinn-check: compares the derivatives of a scene with differences; see --help. */
#include "physics/learn/derivative_check.h"
#include "tools/prepare/config_experiment.h"
#include "tools/programs/cli.h"
#include "tools/programs/help.h"
#include "tools/programs/scene_line.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-check";

static const char *const few_points[] = {"losses.interior.points=32", "losses.boundary.points=8",
                                         "losses.initial.points=16", "losses.held_out_points=16"};
enum { FEW = sizeof few_points / sizeof *few_points, DERIVATIVE_POINTS = 12 };

/* Parameters are moved off their initial values by this much, because biases are 0 there. */
static const double PERTURBATION = 0.1;

typedef struct options {
    const char *config;
    cli_list overrides;
    int entries, seed, threads;
    double step, tolerance;
} options;

typedef struct checker {
    options asked;
    experiment *e;
    problem *problem;
    double *x;        /* [count] all parameters */
    double *gradient; /* [count] */
    int failures;
} checker;

/* ---- one loss as a function of some of the parameters --------------------------------------- */

/* Parameters from `offset` on are the variables; term -1 is the whole loss. */
typedef struct partial {
    checker *checker;
    int term;
    size_t offset, count;
    ad_error *error;
} partial;

static int evaluate(void *context, const double *x, double *value, double *gradient)
{
    partial *p = context;
    checker *s = p->checker;
    memcpy(s->x + p->offset, x, p->count * sizeof *x);
    double *full = gradient ? s->gradient : NULL;
    ad_status status =
        p->term < 0 ? problem_evaluate(s->problem, s->x, value, full, p->error)
                    : problem_evaluate_term(s->problem, p->term, s->x, value, full, p->error);
    if (status == AD_OK && gradient) {
        memcpy(gradient, s->gradient + p->offset, p->count * sizeof *gradient);
    }
    return status != AD_OK;
}

static const char *term_name(const checker *s, int term)
{
    return term < 0 ? "all terms" : problem_term_name(s->problem, term);
}

/* ---- the table ------------------------------------------------------------------------------ */

static void print_row(checker *s, const char *kind, const char *name, double error,
                      const char *where, double computed, double difference)
{
    bool good = error <= s->asked.tolerance; /* false for NaN */
    s->failures += !good;
    if (isnan(computed)) {
        printf("%-10s %-10s %9.2e  %s", kind, name, error, where);
    } else {
        printf("%-10s %-10s %9.2e  %-34s %13.6e %13.6e", kind, name, error, where, computed,
               difference);
    }
    printf("%s\n", good ? "" : "  FAILED");
}

/* A check whose numbers are not finite counts as failed; any other error ends the program. */
static ad_status print_failure(checker *s, const char *kind, const char *name, ad_error *error)
{
    if (error->status != AD_NOT_FINITE) {
        return error->status;
    }
    s->failures++;
    printf("%-10s %-10s not finite: %s  FAILED\n", kind, name, error->message);
    return AD_OK;
}

/* "network/layer2/weight[13][7]" */
static void entry_name(const nn_view *view, size_t entry, char *text, size_t size)
{
    size_t columns = (size_t)view->columns;
    if (columns > 1) {
        snprintf(text, size, "network/%s[%zu][%zu]", view->name, entry / columns, entry % columns);
    } else {
        snprintf(text, size, "network/%s[%zu]", view->name, entry);
    }
}

/* ---- parameter gradients -------------------------------------------------------------------- */

/* Checks entries of one view. All errors are relative to `scale`. */
static ad_status check_view(checker *s, int term, const nn_view *view, size_t entries, double scale,
                            double *worst, ad_check *worst_check, char *where, size_t size,
                            ad_error *error)
{
    size_t count = (size_t)view->rows * (size_t)view->columns;
    partial p = {s, term, view->offset, count, error};
    ad_check check;
    double *x = malloc(count * sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a gradient check");
    }
    memcpy(x, s->x + view->offset, count * sizeof *x);
    ad_status status = ad_check_gradient(evaluate, &p, x, count, entries < count ? entries : 0,
                                         s->asked.step, &check, error);
    memcpy(s->x + view->offset, x, count * sizeof *x);
    free(x);
    if (status != AD_OK) {
        return status;
    }
    double off = fabs(check.worst_difference - check.worst_gradient) / scale;
    if (off >= *worst) {
        *worst = off;
        *worst_check = check;
        entry_name(view, check.worst_entry, where, size);
    }
    return AD_OK;
}

/* The size that errors are relative to: the largest entry, but no less than what rounding of the
 * value leaves of a difference. */
static ad_status scale_of(checker *s, int term, double *scale, ad_error *error)
{
    partial p = {s, term, 0, s->e->count, error};
    double value;
    if (evaluate(&p, s->x, &value, s->gradient) != 0) {
        return error->status;
    }
    *scale = fmax(1e-6 * fabs(value), 1e-300);
    for (size_t i = 0; i < s->e->count; i++) {
        *scale = fmax(*scale, fabs(s->gradient[i]));
    }
    return AD_OK;
}

static ad_status check_entries(checker *s, int term, ad_error *error)
{
    const nn_view *views;
    int count = nn_mlp_views(s->e->mlp, &views);
    size_t each = ((size_t)s->asked.entries + (size_t)count - 1) / (size_t)count;
    double worst = 0, scale = 0;
    ad_check found = {0};
    char where[NN_NAME_MAX + 64] = "";
    ad_status status = scale_of(s, term, &scale, error);
    for (int i = 0; i < count && status == AD_OK; i++) {
        status =
            check_view(s, term, &views[i], each, scale, &worst, &found, where, sizeof where, error);
    }
    if (status == AD_OK) {
        print_row(s, "gradient", term_name(s, term), worst, where, found.worst_gradient,
                  found.worst_difference);
    }
    return status;
}

static ad_status check_direction(checker *s, int term, ad_error *error)
{
    partial p = {s, term, 0, s->e->count, error};
    ad_check check;
    double *x = malloc(s->e->count * sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a gradient check");
    }
    memcpy(x, s->x, s->e->count * sizeof *x);
    ad_status status =
        ad_check_gradient(evaluate, &p, x, s->e->count, 1, s->asked.step, &check, error);
    memcpy(s->x, x, s->e->count * sizeof *x);
    free(x);
    if (status == AD_OK) {
        print_row(s, "dot", term_name(s, term), check.dot_error, "along a random direction", NAN,
                  NAN);
    }
    return status;
}

static ad_status check_term(checker *s, int term, ad_error *error)
{
    ad_status status = check_entries(s, term, error);
    if (status == AD_OK) {
        status = check_direction(s, term, error);
    }
    return status == AD_OK ? AD_OK : print_failure(s, "gradient", term_name(s, term), error);
}

/* ---- derivatives by s and t ----------------------------------------------------------------- */

static ad_status check_derivative(checker *s, const char *name, nn_rng *rng, ad_error *error)
{
    const domain *d = &s->e->model->domain;
    derivative_check check;
    char where[96];
    ad_status status =
        derivative_check_run(s->e->model, s->e->window, experiment_start(s->e), s->e->mlp, s->x,
                             name, DERIVATIVE_POINTS, rng, s->e->pool, &check, error);
    if (status != AD_OK) {
        return print_failure(s, "derivative", name, error);
    }
    int length = snprintf(where, sizeof where, "row %d", check.worst_row);
    for (int i = 0; i < d->count && length < (int)sizeof where; i++) {
        length += snprintf(where + length, sizeof where - (size_t)length, ", %s = %.4g %s",
                           d->coordinates[i].name, check.worst_at[i], d->coordinates[i].unit);
    }
    print_row(s, "derivative", name, check.worst_error, where, check.worst_derivative,
              check.worst_difference);
    return AD_OK;
}

static ad_status check_derivatives(checker *s, ad_error *error)
{
    nn_rng rng = nn_rng_split(s->e->settings->seed, "derivative check");
    ad_status status = AD_OK;
    const char *names = problem_derivatives(s->problem);
    while (*names && status == AD_OK) {
        char name[DERIVATIVE_NAME_MAX];
        int length = (int)strcspn(names, " ");
        snprintf(name, sizeof name, "%.*s", length, names);
        status = check_derivative(s, name, &rng, error);
        names += length + (names[length] == ' ');
    }
    return status;
}

/* ---- the program ---------------------------------------------------------------------------- */

/* The largest coefficient of a function of the network's basis, 1 without such a basis. Derivatives
 * grow with it, and differences are off by rounding times it; a solution has little of it. */
static double coefficient_of(const checker *s, size_t parameter)
{
    int rows, columns;
    const double *basis = nn_mlp_basis(s->e->mlp, &rows, &columns);
    const nn_view *weights;
    double most = 1;
    nn_mlp_views(s->e->mlp, &weights);
    if (basis && parameter < (size_t)weights->rows * (size_t)rows) {
        const double *row = basis + parameter % (size_t)rows * (size_t)columns;
        for (int i = 0; i < columns; i++) {
            most = fmax(most, fabs(row[i]));
        }
    }
    return most;
}

static void perturb(checker *s, const char *stream)
{
    nn_rng rng = nn_rng_split(s->e->settings->seed, stream);
    for (size_t i = 0; i < s->e->count; i++) {
        s->x[i] += PERTURBATION * nn_rng_normal(&rng) / coefficient_of(s, i);
    }
}

/* The few points come first, so that the user's overrides replace them. */
static ad_status prepare(checker *s, ad_error *error)
{
    const char *overrides[FEW + CLI_LIST_MAX + 1];
    char seed[64];
    int count = FEW;
    config *settings;
    memcpy(overrides, few_points, sizeof few_points);
    for (int i = 0; i < s->asked.overrides.count; i++) {
        overrides[count++] = s->asked.overrides.texts[i];
    }
    if (s->asked.seed >= 0) {
        snprintf(seed, sizeof seed, "training.seed=%d", s->asked.seed);
        overrides[count++] = seed;
    }
    ad_status status = prepare_read(s->asked.config, NULL, count, overrides, &settings, error);
    if (status == AD_OK) {
        scene_line_implausible(&settings->scene);
        status = config_experiment_create(settings, s->asked.threads, &s->e, error);
    }
    if (status == AD_OK) {
        status = experiment_problem(s->e, &s->problem, error);
    }
    if (status != AD_OK) {
        return status;
    }
    s->x = malloc(2 * s->e->count * sizeof *s->x);
    if (!s->x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for parameters");
    }
    s->gradient = s->x + s->e->count;
    memcpy(s->x, s->e->parameters, s->e->count * sizeof *s->x);
    perturb(s, "gradient check");
    problem_release_unknowns(s->problem);
    return AD_OK;
}

static void print_heading(const checker *s)
{
    printf("%s: %zu parameters;", s->e->settings->name, s->e->count);
    for (int i = 0; i < problem_sets(s->problem); i++) {
        problem_set_info set = problem_set_inspect(s->problem, i);
        printf(" %zu points %s%s", set.points, set.name,
               i + 1 < problem_sets(s->problem) ? "," : "");
    }
    printf("; tolerance %g\n\n", s->asked.tolerance);
    printf("%-10s %-10s %9s  %-34s %13s %13s\n", "check", "of", "error", "worst at", "computed",
           "difference");
}

static ad_status check_window(checker *s, ad_error *error)
{
    ad_status status = AD_OK;
    int terms = problem_terms(s->problem);
    for (int term = 0; term <= terms && status == AD_OK; term++) {
        status = check_term(s, term < terms ? term : -1, error);
    }
    return status == AD_OK ? check_derivatives(s, error) : status;
}

/* The second window stands for all later ones, which run the same program. */
static ad_status enter_second_window(checker *s, ad_error *error)
{
    memcpy(s->e->parameters, s->x, s->e->count * sizeof *s->x);
    ad_status status = experiment_next_window(s->e, error);
    if (status == AD_OK) {
        status = problem_enter(s->problem, s->e->window, experiment_start(s->e), error);
    }
    if (status != AD_OK) {
        return status;
    }
    perturb(s, "gradient check/window2");
    printf("\nwindow 2 of %d, which starts where such a network ends\n", s->e->scene->windows);
    return check_window(s, error);
}

static ad_status run(checker *s, ad_error *error)
{
    ad_status status = prepare(s, error);
    if (status != AD_OK) {
        return status;
    }
    print_heading(s);
    status = check_window(s, error);
    if (status == AD_OK && s->e->scene->windows > 1) {
        status = enter_second_window(s, error);
    }
    if (status == AD_OK && s->failures) {
        printf("\n%d check%s failed\n", s->failures, s->failures == 1 ? "" : "s");
    } else if (status == AD_OK) {
        printf("\nall checks passed\n");
    }
    return status;
}

int main(int argc, char **argv)
{
    checker s = {.asked = {.entries = 64, .seed = -1, .step = 1e-3, .tolerance = 1e-6}};
    options *o = &s.asked;
    const cli_option list[] = {CLI_SET(&o->overrides),
                               {"--entries", "N", CLI_INTEGER, &o->entries, 1, 1e9},
                               CLI_SEED(&o->seed),
                               {"--step", "H", CLI_NUMBER, &o->step, 1e-8, 1},
                               {"--tolerance", "E", CLI_NUMBER, &o->tolerance, 1e-16, 1},
                               CLI_THREADS(&o->threads)};
    const cli_program about = {program, "CONFIG.yaml", help_check, NULL, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &o->config);
    if (status != CLI_RUN) {
        return status;
    }
    ad_error error = {.message = ""};
    if (run(&s, &error) != AD_OK) {
        status = cli_fail_error(program, &error);
    } else {
        status = s.failures ? 1 : 0;
    }
    free(s.x);
    problem_free(s.problem);
    experiment_free(s.e);
    return status;
}
