/* Random scenes at rest that jump or are narrow along the rod: the solver's error is within ten
 * times its estimate, or it warns. test_random_scenes COUNT [FIRST]: so many scenes, of seeds from
 * FIRST on; without arguments as many as take some seconds. */
#include "random_scenes.h"

#include "physics/solve/solve.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 60, SAID = 4000, COLUMNS = 19 };

/* What shooting and the solver round, of the length, whatever the estimate is: both integrate over
 * some hundred steps, and the shape is up to a hundred times as sensitive. */
static const double FLOOR = 1e-12;

/* Of a beam, whose deflection may be small where its loads are near the clamp: what they round of
 * force and moment there bends all of it. */
static const double ROUNDING = 4e-14;

/* Scenes that may warn: those at whose load the path of the solver cannot be followed. */
static const double WARNED_MAX = 0.02;

typedef struct outcome {
    bool solved, warned, shot;
    double error, estimate, floor;
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
                    double size, outcome *result)
{
    size_t stride = (size_t)count + 1;
    double guess[6], at[SAMPLES][3];
    bool is_beam = scene_is_beam(&x->scene);
    int rows = is_beam ? 1 : 3;
    result->floor = FLOOR;
    if (is_beam) {
        double L = x->length, stiffness = profile_value(&x->bending[0], 0, 0);
        guess[0] = values[2 * stride];
        guess[1] = values[3 * stride];
        result->floor +=
            ROUNDING * L * L / stiffness * (fabs(guess[0]) * L / 3 + fabs(guess[1]) / 2) / size;
    } else {
        double q[4], n[3];
        for (size_t i = 0; i < 4; i++) {
            q[i] = values[(3 + i) * stride];
        }
        for (size_t i = 0; i < 3; i++) {
            n[i] = values[(13 + i) * stride];
            guess[3 + i] = values[(16 + i) * stride];
        }
        turn(q, n, guess);
    }
    result->shot = random_scene_shoot(x, guess, count, s, at);
    for (int i = 0; i < count; i++) {
        double square = 0;
        for (int k = 0; k < rows; k++) {
            double off = values[(size_t)k * stride + (size_t)i + 1] - at[i][k];
            square += off * off;
        }
        result->error = fmax(result->error, sqrt(square) / size);
    }
}

static outcome judge(const random_scene *x)
{
    outcome result = {.error = 0};
    solve_settings settings = solve_settings_default(&x->scene);
    solve_report report;
    solution *found;
    verdict said = {0};
    ad_error error = {AD_OK, ""};
    const char *key = "";
    double s[SAMPLES + 1] = {0}, values[COLUMNS * (SAMPLES + 1)];
    int count = places_of(x, s + 1);
    if (scene_check(&x->scene, &key, &error) != AD_OK ||
        solution_create(&x->scene, &settings, 0, NULL, &found, &report, &error) != AD_OK) {
        snprintf(result.text, sizeof result.text, "%s: %s", key, error.message);
        return result;
    }
    solution_verdict(found, &x->scene, &settings, &report, &said);
    result.solved = solution_evaluate(found, solution_columns(&x->scene), (size_t)count + 1, s,
                                      NULL, values, &error) == AD_OK;
    result.warned = verdict_outcome_of(&said) != VERDICT_SOLVED;
    result.estimate = report.estimate;
    result.nodes = report.nodes;
    snprintf(result.text, sizeof result.text, "%s", verdict_text(&said));
    if (result.solved && report.load_fraction == 1) {
        compare(x, values, count, s + 1, report.size, &result);
    }
    solution_free(found);
    return result;
}

/* Not within its estimate, and no word. */
static bool is_silent(const outcome *x)
{
    return !x->solved || (!x->warned && (!x->shot || !(x->error <= 10 * x->estimate + x->floor)));
}

int main(int arguments, char **argument)
{
    int count = arguments > 1 ? atoi(argument[1]) : 60, silent = 0, warned = 0;
    int first = arguments > 2 ? atoi(argument[2]) : 1;
    double worst = 0;
    for (int i = first; i < first + count; i++) {
        random_scene *x = random_scene_create((uint64_t)i, i % 3 == 0);
        outcome result = judge(x);
        if (is_silent(&result) || result.warned) {
            char text[SAID];
            random_scene_describe(x, text, sizeof text);
            printf("%s: scene %d: error %.2g, estimate %.2g, %d nodes%s: %s\n  %s\n",
                   is_silent(&result) ? "silent" : "warned", i, result.error, result.estimate,
                   result.nodes, result.shot ? "" : ", not shot", result.text, text);
        }
        silent += is_silent(&result);
        warned += result.warned;
        worst = fmax(worst, result.warned ? 0 : result.error);
        random_scene_free(x);
    }
    printf("%d scenes: %d silent, %d warned, largest error of the others %.2g\n", count, silent,
           warned, worst);
    return silent > 0 || warned > WARNED_MAX * count;
}
