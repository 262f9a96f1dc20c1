#include "tools/train/identify.h"

#include "autodiff/dense.h"
#include "optim/optim.h"
#include "physics/sampling.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX = SCENE_PARAMETERS_MAX, STEPS_MAX = 60, STARTS = 32, STARTS_TRIED = 3 };

/* Starts and bounds keep so far from the ends of a range, as part of it. */
static const double EDGE = 1e-2;

/* The search ends where a step of Gauss-Newton would lower chi squared by less: by 1e-2 standard
 * deviations; and where no step lowers it, by errors of the solutions, by 1e-1. */
static const double SETTLED = 1e-4, STUCK = 1e-2;

/* What residuals of the equations may say of unknowns beside the measurements. */
static const double LOOSE = 0.2;

/* What residuals are off by, in standard deviations, before the noise does not explain them. */
static const double EXPLAINED = 4;

/* The unknowns of the search are y = log(z / (1 - z)), z the part of the range, 0 to 1: no step
 * leaves a range. */
typedef struct search {
    const scene *open;
    bool noise_is_scaled;
    solve_trials *trials;
    ad_pool *pool;
    ad_dense_factor *factor;
    int count;
    size_t n;                           /* residuals */
    double difference;                  /* of z, to both sides */
    double *room;                       /* [2 count][n] residuals of trials */
    double *r;                          /* [n] at y */
    double *j;                          /* [count][n] by z */
    double y[MAX];                      /* where r was computed; NaN: nowhere */
    double matrix[MAX * MAX], jtr[MAX]; /* by y */
    long solutions;
    ad_error error; /* what stops the search */
} search;

static double part_of(double y)
{
    return 1 / (1 + exp(-y));
}

static double logit(double z)
{
    return log(z / (1 - z));
}

static void values_of(const search *x, const double *z, double *values)
{
    for (int i = 0; i < x->count; i++) {
        values[i] = scene_parameter_at(&x->open->parameters[scene_known_count(x->open) + i], z[i]);
    }
}

/* residuals [trials][n] at parts z [trials][count] of the ranges. */
static int run(search *x, size_t trials, const double *z, double *residuals)
{
    double values[2 * MAX * MAX + STARTS * MAX];
    for (size_t k = 0; k < trials; k++) {
        values_of(x, z + k * (size_t)x->count, values + k * (size_t)x->count);
    }
    x->solutions += (long)(trials * solve_trials_experiments(x->trials));
    return solve_trials_run(x->trials, trials, values, residuals, &x->error) == AD_OK
               ? OPTIM_OBJECTIVE_OK
               : OPTIM_OBJECTIVE_STOP;
}

static double sum_of_squares(size_t n, const double *r)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += r[i] * r[i];
    }
    return sum;
}

static int evaluate(void *context, const double *y, double *value)
{
    search *x = context;
    double z[MAX];
    for (int i = 0; i < x->count; i++) {
        z[i] = part_of(y[i]);
        x->y[i] = y[i];
    }
    const int code = run(x, 1, z, x->r);
    *value = sum_of_squares(x->n, x->r);
    return code != OPTIM_OBJECTIVE_OK ? code
           : isfinite(*value)         ? OPTIM_OBJECTIVE_OK
                                      : OPTIM_OBJECTIVE_NOT_FINITE;
}

/* j by differences around z, to one side where there is no solution on the other; r is there. */
static int differentiate(search *x, const double *z)
{
    const size_t count = (size_t)x->count;
    double trial[2 * MAX * MAX], ends[2 * MAX];
    for (size_t k = 0; k < 2 * count; k++) {
        memcpy(trial + k * count, z, count * sizeof *z);
        ends[k] = fmin(1, fmax(0, z[k / 2] + (k % 2 ? 1 : -1) * x->difference));
        trial[k * count + k / 2] = ends[k];
    }
    const int code = run(x, 2 * count, trial, x->room);
    for (size_t i = 0; code == OPTIM_OBJECTIVE_OK && i < count; i++) {
        const double *low = x->room + 2 * i * x->n, *high = low + x->n;
        double from = ends[2 * i], to = ends[2 * i + 1];
        if (!isfinite(sum_of_squares(x->n, low))) {
            low = x->r;
            from = z[i];
        } else if (!isfinite(sum_of_squares(x->n, high))) {
            high = x->r;
            to = z[i];
        }
        for (size_t k = 0; k < x->n; k++) {
            x->j[i * x->n + k] = (high[k] - low[k]) / (to - from);
        }
        if (!isfinite(sum_of_squares(x->n, x->j + i * x->n))) {
            return OPTIM_OBJECTIVE_NOT_FINITE;
        }
    }
    return code;
}

/* J^T J and J^T r, by unknowns of which the parts of the ranges go as slope [count], NULL: 1. */
static void multiply(search *x, const double *slope)
{
    for (int i = 0; i < x->count; i++) {
        const double *a = x->j + (size_t)i * x->n;
        for (int k = 0; k <= x->count; k++) {
            const double *b = k < x->count ? x->j + (size_t)k * x->n : x->r;
            double sum = 0;
            for (size_t row = 0; row < x->n; row++) {
                sum += a[row] * b[row];
            }
            *(k < x->count ? &x->matrix[i * x->count + k] : &x->jtr[i]) =
                slope ? sum * slope[i] * (k < x->count ? slope[k] : 1) : sum;
        }
    }
}

static int linearize(void *context, const double *y, double *value, double *jtr, double *diagonal)
{
    search *x = context;
    double z[MAX], slope[MAX];
    const size_t bytes = (size_t)x->count * sizeof *y;
    int code = memcmp(x->y, y, bytes) == 0 ? OPTIM_OBJECTIVE_OK : evaluate(x, y, value);
    for (int i = 0; i < x->count; i++) {
        z[i] = part_of(y[i]);
        slope[i] = z[i] * (1 - z[i]);
    }
    code = code == OPTIM_OBJECTIVE_OK ? differentiate(x, z) : code;
    if (code != OPTIM_OBJECTIVE_OK) {
        return code;
    }
    *value = sum_of_squares(x->n, x->r);
    multiply(x, slope);
    for (int i = 0; i < x->count; i++) {
        jtr[i] = x->jtr[i];
        diagonal[i] = x->matrix[i * x->count + i];
    }
    return OPTIM_OBJECTIVE_OK;
}

static int solve(void *context, double damping, const double *scale, double *step)
{
    const search *x = context;
    double shift[MAX];
    for (int i = 0; i < x->count; i++) {
        shift[i] = damping * scale[i];
        step[i] = -x->jtr[i];
    }
    if (ad_dense_cholesky(x->pool, x->matrix, shift, x->factor) != 0) {
        return 1;
    }
    ad_dense_cholesky_solve(x->factor, step);
    return 0;
}

/* By how much a step would lower chi squared: with the damping that keeps steps along what is not
 * measured within the range. */
static double promised(search *x)
{
    static const double DAMPING = 1.0 / 16; /* (dz/dy)^2 in the middle of a range */
    double ones[MAX], step[MAX], sum = 0;
    for (int i = 0; i < x->count; i++) {
        ones[i] = 1;
    }
    if (solve(x, DAMPING, ones, step) != 0) {
        return INFINITY;
    }
    for (int i = 0; i < x->count; i++) {
        sum -= step[i] * x->jtr[i];
    }
    return sum;
}

/* ---- the search ---------------------------------------------------------------------------- */

typedef struct descent {
    double z[MAX], chi_squared;
    int steps;
    bool converged;
} descent;

/* What counts as little of chi squared: a number's share of it where the noise is not known. */
static double variance_of(const search *x, double chi_squared)
{
    return !x->noise_is_scaled ? 1 : chi_squared / fmax(1, (double)x->n - x->count);
}

/* From parts z of the ranges on. AD_OK also where there is no solution: chi_squared is then
 * infinite. */
static ad_status descend(search *x, const double *z, descent *result, ad_error *error)
{
    double y[MAX];
    const char *why = NULL;
    optim_gauss_newton_settings settings = optim_gauss_newton_defaults();
    const optim_linear_model model = {x, evaluate, linearize, solve, NULL};
    settings.scaling = OPTIM_SCALING_DIAGONAL;
    settings.gradient_tolerance = 0;
    *result = (descent){.chi_squared = INFINITY};
    for (int i = 0; i < x->count; i++) {
        y[i] = logit(fmin(1 - EDGE, fmax(EDGE, z[i])));
        x->y[i] = NAN;
    }
    optim_gauss_newton *gn = optim_gauss_newton_create((size_t)x->count, y, &settings, &why);
    if (!gn) {
        return ad_fail(error, AD_NO_MEMORY, "identification: %s", why);
    }
    optim_status status = OPTIM_RUNNING;
    while (status == OPTIM_RUNNING && !result->converged && result->steps < STEPS_MAX) {
        status = optim_gauss_newton_step(gn, &model);
        const double variance = variance_of(x, optim_gauss_newton_get_info(gn).value);
        result->steps++;
        result->converged = status == OPTIM_FUNCTION_TOLERANCE ||
                            status == OPTIM_GRADIENT_TOLERANCE ||
                            promised(x) < variance * (status == OPTIM_RUNNING ? SETTLED : STUCK);
    }
    if (isfinite(optim_gauss_newton_get_info(gn).value)) {
        result->chi_squared = optim_gauss_newton_get_info(gn).value;
    }
    for (int i = 0; i < x->count; i++) {
        result->z[i] = part_of(optim_gauss_newton_x(gn)[i]);
    }
    optim_gauss_newton_free(gn);
    return status == OPTIM_STOPPED_BY_OBJECTIVE
               ? ad_fail(error, x->error.status, "%s", x->error.message)
               : AD_OK;
}

/* By how many standard deviations a chi squared of so many degrees of freedom is off, by the normal
 * approximation of Wilson and Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684. */
static double off_by(double chi_squared, double freedom)
{
    const double variance = 2 / (9 * freedom);
    return (cbrt(chi_squared / freedom) - (1 - variance)) / sqrt(variance);
}

static bool is_explained(const search *x, const descent *found)
{
    const double freedom = (double)x->n - x->count;
    return found->converged && !x->noise_is_scaled && /* noise that is not known explains all */
           (freedom <= 0 || off_by(found->chi_squared, freedom) < EXPLAINED);
}

/* Again from those of other places where the residuals are smallest. */
static ad_status start_elsewhere(search *x, descent *best, ad_error *error)
{
    double points[MAX * STARTS], starts[STARTS * MAX], chi_squared[STARTS];
    double *residuals = malloc(STARTS * x->n * sizeof *residuals);
    ad_status status = residuals
                           ? sampling_fill(SAMPLING_SOBOL, NULL, x->count, STARTS, points, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for starts");
    for (int k = 0; k < STARTS; k++) {
        for (int i = 0; i < x->count; i++) {
            starts[k * x->count + i] = points[i * STARTS + k];
        }
    }
    if (status == AD_OK && run(x, STARTS, starts, residuals) != OPTIM_OBJECTIVE_OK) {
        status = ad_fail(error, x->error.status, "%s", x->error.message);
    }
    for (size_t k = 0; status == AD_OK && k < STARTS; k++) {
        chi_squared[k] = sum_of_squares(x->n, residuals + k * x->n);
    }
    free(residuals);
    for (int tried = 0; tried < STARTS_TRIED && status == AD_OK && !is_explained(x, best);
         tried++) {
        descent found;
        int next = -1;
        for (int k = 0; k < STARTS; k++) {
            if (isfinite(chi_squared[k]) && (next < 0 || chi_squared[k] < chi_squared[next])) {
                next = k;
            }
        }
        if (next < 0) {
            break;
        }
        chi_squared[next] = INFINITY;
        status = descend(x, starts + next * x->count, &found, error);
        found.steps += best->steps;
        if (found.chi_squared < best->chi_squared) {
            *best = found;
        } else {
            best->steps = found.steps;
        }
    }
    return status;
}

/* ---- what is known then -------------------------------------------------------------------- */

/* Unknowns close to an end of their range which the residuals push on beyond it go there. */
static void find_bounds(search *x, double *z, bool *bounded)
{
    double zeros[MAX] = {0}, step[MAX];
    multiply(x, NULL);
    const bool solved = solve(x, 0, zeros, step) == 0;
    for (int i = 0; i < x->count; i++) {
        const bool low = z[i] < EDGE && (!solved || z[i] + step[i] <= 0);
        const bool high = z[i] > 1 - EDGE && (!solved || z[i] + step[i] >= 1);
        bounded[i] = low || high;
        z[i] = low ? 0 : high ? 1 : z[i];
    }
}

static int at(search *x, const double *z)
{
    const int code = run(x, 1, z, x->r);
    return code == OPTIM_OBJECTIVE_OK ? differentiate(x, z) : code;
}

static ad_status conclude(search *x, const descent *found, identified *result, ad_error *error)
{
    double z[MAX];
    memcpy(z, found->z, sizeof z);
    int code = at(x, z);
    if (code == OPTIM_OBJECTIVE_OK) {
        find_bounds(x, z, result->bounded);
        code = at(x, z);
    }
    if (code != OPTIM_OBJECTIVE_OK) {
        return code == OPTIM_OBJECTIVE_STOP
                   ? ad_fail(error, x->error.status, "%s", x->error.message)
                   : ad_fail(error, AD_NOT_FINITE,
                             "identification ends where there is no solution next to it");
    }
    int free_unknowns = 0;
    for (int i = 0; i < x->count; i++) {
        free_unknowns += !result->bounded[i];
    }
    multiply(x, NULL);
    values_of(x, z, result->value);
    result->chi_squared = sum_of_squares(x->n, x->r);
    const double freedom = (double)x->n - free_unknowns;
    result->noise_factor =
        x->noise_is_scaled && freedom > 0 ? sqrt(result->chi_squared / freedom) : 1;
    for (int i = 0; i < x->count * x->count; i++) {
        x->matrix[i] /= result->noise_factor * result->noise_factor;
    }
    result->information = solve_information_of(x->count, x->matrix, result->bounded);
    for (int i = 0; i < x->count; i++) {
        const scene_parameter *p = &x->open->parameters[scene_known_count(x->open) + i];
        result->deviation[i] =
            result->information.deviation[i] *
            (p->scale == SCENE_LOG ? result->value[i] * log(p->high / p->low) : p->high - p->low);
    }
    result->steps = found->steps;
    result->converged = found->converged;
    return AD_OK;
}

/* ---- all of it ----------------------------------------------------------------------------- */

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

static ad_status prepare(search *x, const identify_settings *settings, double *start,
                         identified *result, ad_error *error)
{
    const int first = scene_known_count(x->open);
    x->count = x->open->unknown_count;
    for (int i = 0; i < x->count; i++) {
        start[i] =
            scene_parameter_fraction(&x->open->parameters[first + i], x->open->guess[first + i]);
    }
    result->count = x->count;
    result->residuals = x->n = solve_trials_residuals(x->trials);
    result->experiments = solve_trials_experiments(x->trials);
    result->by_members = solve_trials_by_members(x->trials);
    result->scaled = settings->noise_is_scaled;
    ad_status status = identify_check(x->count, x->n, settings->noise_is_scaled, error);
    if (status != AD_OK) {
        return status;
    }
    /* of the error of central differences and that of the solutions both are then small */
    x->difference = fmin(1e-2, fmax(1e-4, cbrt(solve_trials_tolerance(x->trials))));
    const size_t count = (size_t)x->count;
    x->room = malloc(2 * count * x->n * sizeof *x->room);
    x->r = malloc(x->n * sizeof *x->r);
    x->j = malloc(count * x->n * sizeof *x->j);
    x->factor = ad_dense_factor_create(count);
    x->pool = ad_pool_create(1);
    return x->room && x->r && x->j && x->factor && x->pool
               ? ad_dense_load(error)
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu residuals", x->n);
}

static void search_free(search *x)
{
    solve_trials_free(x->trials);
    ad_pool_free(x->pool);
    ad_dense_factor_free(x->factor);
    free(x->room);
    free(x->r);
    free(x->j);
}

ad_status identify(const scene *open, int sets, const solve_measured *measured,
                   const identify_settings *settings, identified *result, ad_error *error)
{
    search x = {.open = open, .noise_is_scaled = settings->noise_is_scaled};
    double start[MAX];
    descent best;
    *result = (identified){.count = 0};
    ad_status status = solve_trials_create(open, sets, measured, settings->tolerance,
                                           settings->threads, &x.trials, error);
    if (status == AD_OK) {
        status = prepare(&x, settings, start, result, error);
    }
    if (status == AD_OK) {
        status = descend(&x, start, &best, error);
    }
    if (status == AD_OK && !is_explained(&x, &best)) {
        status = start_elsewhere(&x, &best, error);
    }
    if (status == AD_OK && !isfinite(best.chi_squared)) {
        const char *reason = solve_trials_reason(x.trials);
        status = ad_fail(error, AD_BAD_INPUT,
                         "there is no solution where the search starts, nor anywhere else in the "
                         "ranges that was tried%s%s",
                         *reason ? ": " : "", reason);
    }
    if (status == AD_OK) {
        status = conclude(&x, &best, result, error);
        result->solutions = x.solutions;
    }
    search_free(&x);
    return status;
}

/* ---- verdict ------------------------------------------------------------------------------- */

static void judge_bounds(const identified *x, const scene *open, verdict *to)
{
    char names[300] = "";
    size_t used = 0;
    for (int i = 0; i < x->count && used < sizeof names; i++) {
        if (x->bounded[i]) {
            used +=
                (size_t)snprintf(names + used, sizeof names - used, "%s%s = %.4g", used ? ", " : "",
                                 open->parameters[scene_known_count(open) + i].name, x->value[i]);
        }
    }
    if (used) {
        verdict_add(to, VERDICT_AT_BOUND,
                    "the best value is an end of its range, and deviations of the others hold for "
                    "this value: %s",
                    names);
    }
}

static void judge_untold(const identified *x, const scene *open, verdict *to)
{
    const scene_parameter *parameters[MAX];
    char text[400] = "";
    size_t used = 0;
    for (int i = 0; i < x->count; i++) {
        parameters[i] = &open->parameters[scene_known_count(open) + i];
    }
    for (int k = 0; k < x->information.untold && used < sizeof text; k++) {
        char one[200];
        solve_information_text(parameters, x->count, x->value, x->information.direction[k], one,
                               sizeof one);
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", k > 0 ? "; " : "", one);
    }
    if (used) {
        verdict_add(to, VERDICT_NOT_TOLD,
                    "the measurements do not tell, beyond the ranges, how large a change is of: %s",
                    text);
    }
}

void identified_verdict(const identified *x, const scene *open, verdict *to)
{
    const double freedom = (double)x->residuals - x->count;
    const double off = freedom > 0 && !x->scaled ? off_by(x->chi_squared, freedom) : 0;
    if (!x->converged) {
        verdict_add(to, VERDICT_NOT_CONVERGED,
                    "the search for the unknowns has not ended after %d steps", x->steps);
    }
    if (x->held_by_equations > LOOSE) {
        verdict_add(to, VERDICT_NOT_CONVERGED,
                    "unknowns are held by what the network leaves of the equations, more than by "
                    "the measurements (%.0f %%): try more features or points, or a larger "
                    "data.weight; cpinn-solve finds them without a network",
                    100 * x->held_by_equations);
    }
    if (fabs(off) > EXPLAINED) {
        verdict_add(to, off > 0 ? VERDICT_MISFIT : VERDICT_NOISE_OVERSTATED,
                    "chi squared is %.4g of %.0f degrees of freedom: residuals are %.3g times the "
                    "noise that is stated",
                    x->chi_squared, freedom, sqrt(x->chi_squared / freedom));
    }
    judge_untold(x, open, to);
    judge_bounds(x, open, to);
}
