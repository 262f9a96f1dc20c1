/* Random scenes at rest that jump or are narrow along the rod: the error is within ten times its
 * estimate, or there is a warning.
 *
 *   test_library random_scenes [COUNT [FIRST [network]]]
 *
 * COUNT scenes, of seeds from FIRST on, by the solver, or by networks of the default recipe, whose
 * error is to be below 1e-8; without arguments as many as take some seconds. */
#include "fewer.h"
#include "random_scenes.h"

#include "physics/solve/solve.h"
#include "tools/library/cpinn.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 60, COLUMNS = 19 };

/* What shooting and the solver round, of the length, whatever the estimate is: both integrate over
 * some hundred steps, and the shape is up to a hundred times as sensitive. */
static const double FLOOR = 1e-12;

/* Of a beam, whose deflection may be small where its loads are near the clamp: what they round of
 * force and moment there bends all of it. */
static const double ROUNDING = 4e-14;

/* What networks reach without a warning. */
static const double NETWORK = 1e-8;

/* Scenes that may warn: rods that buckle or snap, or whose path cannot be followed to the full
 * load; most of these are held at both ends. */
static const double WARNED_MAX = 0.03;

typedef struct outcome {
    bool solved, warned, whole, shot;
    double error, estimate, balance, size, floor;
    int nodes;
    char text[VERDICT_TEXT + 128];
} outcome;

/* N in the world from n in the body. */
static void turn(const double *q, const double *n, double *to)
{
    const double *p = q + 1;
    double once[3] = {p[1] * n[2] - p[2] * n[1], p[2] * n[0] - p[0] * n[2],
                      p[0] * n[1] - p[1] * n[0]};
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        to[i] = n[i] + 2 * (q[0] * once[i] + p[j] * once[k] - p[k] * once[j]);
    }
}

/* What a solution has to be compared at: alike distances, and the middles between edges. */
static int places_of(const random_scene *x, double *s)
{
    int count = 0;
    for (int i = 1; i <= SAMPLES / 2; i++) {
        s[count++] = i == SAMPLES / 2 ? x->length : x->length * i / (SAMPLES / 2);
    }
    for (int i = 0; i + 1 < x->edge_count && count < SAMPLES; i++) {
        s[count++] = (x->edges[i] + x->edges[i + 1]) / 2;
    }
    for (int i = 1; i < count; i++) {
        for (int k = i; k > 0 && s[k] < s[k - 1]; k--) {
            double swap = s[k];
            s[k] = s[k - 1];
            s[k - 1] = swap;
        }
    }
    return count;
}

/* values [columns][count + 1], at s = 0 and then at the places. */
static void compare(const random_scene *x, const double *values, int count, const double *s,
                    outcome *result)
{
    size_t stride = (size_t)count + 1;
    double guess[RANDOM_ROWS] = {0}, at[SAMPLES][3], largest = 0;
    int rows = x->is_beam ? 1 : 3;
    result->floor = FLOOR;
    for (size_t i = 0; i < 4 && x->is_beam; i++) {
        guess[i] = values[i * stride];
    }
    for (size_t i = 0; i < 7 && !x->is_beam; i++) {
        guess[i] = values[i * stride];
    }
    for (size_t i = 0; i < 3 && !x->is_beam; i++) {
        guess[7 + i] = values[(13 + i) * stride];
        guess[10 + i] = values[(16 + i) * stride];
    }
    if (!x->is_beam) {
        const double n[3] = {guess[7], guess[8], guess[9]};
        turn(guess + 3, n, guess + 7);
    }
    result->shot = random_scene_shoot(x, guess, count, s, at);
    for (int i = 0; i < count; i++) {
        double square = 0;
        for (int k = 0; k < rows; k++) {
            double off = values[(size_t)k * stride + (size_t)i + 1] - at[i][k];
            square += off * off;
        }
        result->error = fmax(result->error, sqrt(square));
        largest = fmax(largest, fabs(at[i][0]));
    }
    double size = result->size > 0 ? result->size : x->is_beam ? largest : x->length;
    result->error /= size;
    if (x->is_beam) {
        double L = x->length;
        result->floor +=
            ROUNDING * L * L / x->stiffness * (fabs(guess[2]) * L / 3 + fabs(guess[3]) / 2) / size;
    }
}

static void judge(outcome *result, const verdict *said, ad_status status, const ad_error *error)
{
    result->solved = status == AD_OK;
    result->warned = status == AD_OK && verdict_outcome_of(said) != VERDICT_SOLVED;
    snprintf(result->text, sizeof result->text, "%s",
             status == AD_OK ? verdict_text(said) : error->message);
}

/* values [COLUMNS][count] at s [count]. */
static outcome solve(const random_scene *x, int count, const double *s, double *values)
{
    outcome result = {.error = 0};
    solve_settings settings = solve_settings_default(&x->scene);
    solve_report report = solve_report_blank();
    solution *found = NULL;
    verdict said = {0};
    ad_error error = {AD_OK, ""};
    const char *key = "";
    ad_status status = scene_check(&x->scene, &key, &error);
    if (status != AD_OK) {
        snprintf(result.text, sizeof result.text, "%s: %s", key, error.message);
        return result;
    }
    status = solution_create(&x->scene, &settings, 0, NULL, &found, &report, &error);
    if (status == AD_OK) {
        solution_verdict(found, &x->scene, &settings, &report, &said);
        status = solution_evaluate(found, solution_columns(&x->scene), (size_t)count, s, NULL,
                                   values, &error);
    }
    judge(&result, &said, status, &error);
    result.estimate = report.estimate;
    result.balance = report.balance;
    result.whole = report.load_fraction == 1;
    result.nodes = report.nodes;
    result.size = report.size;
    solution_free(found);
    return result;
}

static outcome train(const random_scene *x, int count, const double *s, double *values)
{
    outcome result = {.estimate = NETWORK / 10, .whole = true};
    const cpinn_options options = {.threads = 1};
    const verdict none = {0};
    cpinn_model *model = NULL;
    evaluator *columns = NULL;
    ad_error error = {AD_OK, ""};
    ad_status status = cpinn_train_scene(&x->scene, NULL, &options, &model, &error);
    status = status == AD_OK ? cpinn_evaluator(model, NULL, &columns, &error) : status;
    if (status == AD_OK) {
        status = evaluator_evaluate(columns, (size_t)count, s, NULL, values, &error);
    }
    judge(&result, model ? cpinn_verdict(model) : &none, status, &error);
    evaluator_free(columns);
    cpinn_free(model);
    return result;
}

static outcome run(const random_scene *x, bool by_network)
{
    double s[SAMPLES + 1] = {0}, values[COLUMNS * (SAMPLES + 1)];
    int count = places_of(x, s + 1);
    outcome result = by_network ? train(x, count + 1, s, values) : solve(x, count + 1, s, values);
    if (result.solved && result.whole) {
        compare(x, values, count, s + 1, &result);
    }
    return result;
}

/* Not within its estimate, or out of balance, and no word. */
static bool is_silent(const outcome *x)
{
    double allowed = 10 * x->estimate + x->floor;
    bool known = x->shot && x->error <= allowed && x->balance <= allowed;
    return !x->solved || (!x->warned && !known);
}

/* Whether too many of them are silent or warned. */
static bool judge_scenes(bool by_network, int first, int count)
{
    int silent = 0, warned = 0;
    double worst = 0, balance = 0;
    for (int i = first; i < first + count; i++) {
        bool is_beam = i % 3 == 0;
        random_scene *x = random_scene_create((uint64_t)i, is_beam);
        outcome result = run(x, by_network);
        if (is_silent(&result) || result.warned) {
            printf("%s: scene %d: error %.2g, estimate %.2g, balance %.2g, %d nodes%s: %s\n  ",
                   is_silent(&result) ? "silent" : "warned", i, result.error, result.estimate,
                   result.balance, result.nodes, result.shot ? "" : ", not shot", result.text);
            random_scene_describe(x, stdout);
            fflush(stdout);
        }
        silent += is_silent(&result);
        warned += result.warned;
        worst = fmax(worst, result.warned ? 0 : result.error);
        balance = fmax(balance, result.warned ? 0 : result.balance);
        random_scene_free(x);
    }
    printf("%d scenes by %s: %d silent, %d warned, largest error of the others %.2g, balance "
           "%.2g\n",
           count, by_network ? "network" : "solver", silent, warned, worst, balance);
    return silent > 0 || (warned > WARNED_MAX * count && !by_network);
}

int main(int arguments, char **argument)
{
    int count = arguments > 1 ? atoi(argument[1]) : FEWER(24);
    int first = arguments > 2 ? atoi(argument[2]) : 1;
    return judge_scenes(arguments > 3, first, count);
}
