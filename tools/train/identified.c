#include "tools/train/identify.h"

#include <math.h>
#include <stdio.h>

enum { MAX = SCENE_PARAMETERS_MAX };

/* What residuals of the equations may say of unknowns beside the measurements. */
static const double LOOSE = 0.2;

/* Of the noise: what the modes of a reduced rod may leave out. */
static const double REDUCED = 0.2;

/* Of standard deviations, by the growth of chi squared: half and twice what is said. */
static const double ROUGH = 4;

double identified_off(double chi_squared, double freedom)
{
    const double variance = 2 / (9 * freedom);
    return (cbrt(chi_squared / freedom) - (1 - variance)) / sqrt(variance);
}

ad_status identify_check(int unknowns, size_t numbers, bool noise_is_scaled, ad_error *error)
{
    if (unknowns > 0 && numbers >= (size_t)unknowns + (noise_is_scaled ? 1 : 0)) {
        return AD_OK;
    }
    return ad_fail(error, AD_BAD_INPUT,
                   "%zu measured numbers for %d unknowns%s; allowed: at least as many as "
                   "unknowns%s",
                   numbers, unknowns, noise_is_scaled ? " and the noise" : "",
                   noise_is_scaled ? ", and one more for the noise" : "");
}

void identified_inform(identified *result, const scene *open, double *matrix)
{
    for (int i = 0; i < result->count * result->count; i++) {
        matrix[i] /= result->noise_factor * result->noise_factor;
    }
    result->information = solve_information_of(result->count, matrix, result->held);
    for (int i = 0; i < result->count; i++) {
        const scene_parameter *p = &open->parameters[scene_known_count(open) + i];
        result->deviation[i] =
            result->information.deviation[i] * scene_parameter_slope(p, result->value[i]);
    }
}

/* Appends "name = value" of an unknown. */
static void say_value(char *text, size_t size, size_t *used, const char *before, const scene *open,
                      int unknown, double value)
{
    if (*used < size) {
        *used += (size_t)snprintf(text + *used, size - *used, "%s%s = %.4g", before,
                                  open->parameters[scene_known_count(open) + unknown].name, value);
    }
}

static void judge_bounds(const identified *identified, const scene *open, verdict *to)
{
    char names[300] = "";
    size_t used = 0;
    bool held = false;
    for (int i = 0; i < identified->count; i++) {
        held = held || identified->held[i];
        if (identified->bounded[i]) {
            say_value(names, sizeof names, &used, used ? ", " : "", open, i, identified->value[i]);
        }
    }
    if (used) {
        verdict_add(to, VERDICT_AT_BOUND, "the best value is an end of its range, and %s: %s",
                    held ? "deviations of the others hold for this value"
                         : "values within its deviation suit nearly as well",
                    names);
    }
}

static void judge_others(const identified *identified, const scene *open, verdict *to)
{
    char text[400] = "";
    size_t used = 0;
    for (int k = 0; k < identified->others; k++) {
        for (int i = 0; i < identified->count; i++) {
            say_value(text, sizeof text, &used,
                      i   ? ", "
                      : k ? "; or "
                          : "",
                      open, i, identified->other[k].value[i]);
        }
    }
    if (used) {
        verdict_add(to, VERDICT_SEVERAL_SOLUTIONS,
                    "other values suit the measurements as well: %s; narrow the range, or measure "
                    "what tells them apart",
                    text);
    }
}

/* Where two deviations do not change chi squared by about 4. */
static void judge_growth(const identified *identified, const scene *open, verdict *to)
{
    int worst = -1, side = 0;
    double by = ROUGH;
    for (int k = 0; k < 2 * identified->count; k++) {
        const double part = identified->growth[k / 2][k % 2];
        const double off = part > 0 ? fmax(part, 1 / part) : INFINITY;
        if (!isnan(part) && off > by) {
            worst = k / 2;
            side = k % 2;
            by = off;
        }
    }
    if (worst >= 0) {
        verdict_add(to, VERDICT_DEVIATIONS_ROUGH,
                    "deviations are rough: two of %s %s change chi squared by %.3g, where 4 is "
                    "meant; more or better measurements make them hold",
                    open->parameters[scene_known_count(open) + worst].name,
                    side ? "upwards" : "downwards", 4 * identified->growth[worst][side]);
    }
}

/* A valley: what is known of a combination, but hardly of each by itself. */
static void judge_valley(const identified *identified, const scene_parameter *const *parameters,
                         verdict *to)
{
    char text[200];
    if (identified->information.collinearity > SOLVE_COLLINEAR &&
        identified->information.untold == 0) {
        solve_information_text(parameters, identified->count, identified->value,
                               identified->information.valley, text, sizeof text);
        verdict_add(to, VERDICT_KNOWN_TOGETHER,
                    "the measurements hardly tell, as the deviations say, how large a change is "
                    "of: %s; each alone would be known %.0f times as well",
                    text, identified->information.collinearity);
    }
}

static void judge_untold(const identified *identified, const scene *open, verdict *to)
{
    const scene_parameter *parameters[MAX];
    char text[400] = "";
    size_t used = 0;
    for (int i = 0; i < identified->count; i++) {
        parameters[i] = &open->parameters[scene_known_count(open) + i];
    }
    for (int k = 0; k < identified->information.untold && used < sizeof text; k++) {
        char one[200];
        solve_information_text(parameters, identified->count, identified->value,
                               identified->information.direction[k], one, sizeof one);
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", k > 0 ? "; " : "", one);
    }
    if (used) {
        verdict_add(to, VERDICT_NOT_TOLD,
                    "the measurements do not tell, beyond the ranges, how large a change is of: %s",
                    text);
    }
    judge_valley(identified, parameters, to);
}

void identified_verdict(const identified *identified, const scene *open, verdict *to)
{
    const double freedom = (double)identified->residuals - identified->count;
    const double off =
        freedom > 0 && !identified->scaled ? identified_off(identified->chi_squared, freedom) : 0;
    if (!identified->converged) {
        verdict_add(to, VERDICT_NOT_CONVERGED,
                    "the search for the unknowns has not ended after %d steps", identified->steps);
    }
    if (identified->held_by_equations > LOOSE) {
        verdict_add(to, VERDICT_NOT_CONVERGED,
                    "unknowns are held by what the network leaves of the equations, more than by "
                    "the measurements (%.0f %%): try more features or points, or a larger "
                    "data.weight; cpinn-solve finds them without a network",
                    100 * identified->held_by_equations);
    }
    if (fabs(off) > IDENTIFIED_EXPLAINED) {
        verdict_add(to, off > 0 ? VERDICT_MISFIT : VERDICT_NOISE_OVERSTATED,
                    "chi squared is %.4g of %.0f degrees of freedom: residuals are %.3g times the "
                    "noise that is stated; deviations are those of the stated one",
                    identified->chi_squared, freedom, sqrt(identified->chi_squared / freedom));
    }
    if (!(identified->reduction <= REDUCED)) {
        verdict_add(to, VERDICT_ESTIMATE_ABOVE_TOLERANCE,
                    "more modes of the reduced rod and shorter steps change what was measured by "
                    "%.2g of its noise, rms, so that values are off by more than their deviations; "
                    "give more modes (--method modes --modes) or inputs at more instants",
                    identified->reduction);
    }
    judge_untold(identified, open, to);
    judge_bounds(identified, open, to);
    judge_others(identified, open, to);
    judge_growth(identified, open, to);
}
