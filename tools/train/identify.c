#include "tools/train/identify_search.h"

#include "autodiff/memory.h"
#include "physics/numerics/sampling.h"
#include "physics/numerics/vector_size.h"
#include "tools/train/least_squares.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS_MAX = 60 };

/* Of more experiments than this, and than so many for each unknown, some are enough to say where
 * minima are: the search begins with these, and each minimum is settled with all. */
enum { FEW = 64, FEW_EACH = 8 };

/* The search ends where a step of Gauss-Newton would lower chi squared by less: by 1e-2 standard
 * deviations; and where no step lowers it, by errors of the solutions, by 1e-1. Half a deviation
 * will do with some experiments, and where more than KINKED steps were made and the last lowered
 * it by less than STUCK: at each pose in which a tendon becomes slack its derivative jumps. */
enum { KINKED = 10 };
static const double SETTLED = 1e-4, STUCK = 1e-2, ROUGHLY = 0.25;

/* Residuals of so small a part of what is measured are those of the solutions alone. */
static const double EXACT = 1e-6;

/* So often a descent begins once more from where it ended. */
static const double AGAIN_MOST = 3;

static double part_of(double y)
{
    return 1 / (1 + exp(-y));
}

static double logit(double z)
{
    return log(z / (1 - z));
}

void identify_values(const search *search, const double *z, double *values)
{
    for (int i = 0; i < search->count; i++) {
        values[i] = scene_parameter_at(
            &search->open->parameters[scene_known_count(search->open) + i], z[i]);
    }
}

/* residuals [trials][n] at parts z [trials][count] of the ranges; `rough`: an idea is enough. */
ad_status identify_run(search *search, bool rough, size_t trials, const double *z,
                       double *residuals, ad_error *error)
{
    double values[2 * MAX * MAX + STARTS * MAX];
    for (size_t k = 0; k < trials; k++) {
        identify_values(search, z + k * (size_t)search->count, values + k * (size_t)search->count);
    }
    search->all.solutions +=
        (double)(trials * solve_trials_experiments(search->trials)) / search->all.every;
    return solve_trials_run(search->trials, trials, values, rough, residuals, error);
}

static int evaluate(search *search, const double *y, double *value)
{
    double z[MAX];
    for (int i = 0; i < search->count; i++) {
        z[i] = part_of(y[i]);
        search->all.y[i] = y[i];
    }
    const ad_status status =
        identify_run(search, search->all.easy != 0, 1, z, search->r, &search->error);
    *value = vector_square(search->n, search->r);
    return status != AD_OK    ? OPTIM_OBJECTIVE_STOP
           : isfinite(*value) ? OPTIM_OBJECTIVE_OK
                              : OPTIM_OBJECTIVE_NOT_FINITE;
}

/* Of a part of a range: smaller towards its ends, where the logarithm of the distance from them
 * counts. */
static double difference_at(const search *search, double z)
{
    return search->difference * fmax(EDGE, 4 * z * (1 - z));
}

/* j around z; r is there. */
int identify_differentiate(search *search, const double *z)
{
    const scene_parameter *unknown = &search->open->parameters[scene_known_count(search->open)];
    const size_t n = search->n;
    double values[MAX], ends[2 * MAX];
    size_t solved = 0;
    identify_values(search, z, values);
    for (int k = 0; k < 2 * search->count; k++) {
        const double by = (k % 2 ? 1 : -1) * difference_at(search, z[k / 2]);
        ends[k] = scene_parameter_at(&unknown[k / 2], fmin(1, fmax(0, z[k / 2] + by)));
    }
    if (solve_trials_differentiate(search->trials, values, ends, search->r, search->room, search->j,
                                   &solved, &search->error) != AD_OK) {
        return OPTIM_OBJECTIVE_STOP;
    }
    search->all.solutions += (double)solved;
    for (size_t i = 0; i < (size_t)search->count * n; i++) {
        search->j[i] *= scene_parameter_slope(&unknown[i / n], values[i / n]);
    }
    return isfinite(vector_square((size_t)search->count * n, search->j))
               ? OPTIM_OBJECTIVE_OK
               : OPTIM_OBJECTIVE_NOT_FINITE;
}

/* J^T J and J^T r, by unknowns of which the parts of the ranges go as slope [count], NULL: 1. */
void identify_multiply(search *search, const double *slope)
{
    for (int i = 0; i < search->count; i++) {
        const double *a = search->j + (size_t)i * search->n;
        for (int k = 0; k <= search->count; k++) {
            const double *b = k < search->count ? search->j + (size_t)k * search->n : search->r;
            double sum = 0;
            for (size_t row = 0; row < search->n; row++) {
                sum += a[row] * b[row];
            }
            *(k < search->count ? &search->ls.jtj[i * search->count + k] : &search->ls.jtr[i]) =
                slope ? sum * slope[i] * (k < search->count ? slope[k] : 1) : sum;
        }
    }
}

static int sum(void *context, const double *y, double *value, least_squares *to)
{
    search *search = context;
    double z[MAX], slope[MAX];
    if (!to) {
        return evaluate(search, y, value);
    }
    const size_t bytes = (size_t)search->count * sizeof *y;
    int code =
        memcmp(search->all.y, y, bytes) == 0 ? OPTIM_OBJECTIVE_OK : evaluate(search, y, value);
    for (int i = 0; i < search->count; i++) {
        z[i] = part_of(y[i]);
        slope[i] = z[i] * (1 - z[i]);
    }
    code = code == OPTIM_OBJECTIVE_OK ? identify_differentiate(search, z) : code;
    if (code == OPTIM_OBJECTIVE_OK) {
        *value = vector_square(search->n, search->r);
        identify_multiply(search, slope);
    }
    return code;
}

/* By how much a step would lower chi squared: with a damping that keeps steps along what is not
 * measured within the range. */
static double promised(search *search, double damping, double *step)
{
    double ones[MAX], sum = 0;
    for (int i = 0; i < search->count; i++) {
        ones[i] = 1;
    }
    if (least_squares_solve(&search->ls, damping, ones, step) != 0) {
        return INFINITY;
    }
    for (int i = 0; i < search->count; i++) {
        sum -= step[i] * search->ls.jtr[i];
    }
    return sum;
}

/* ---- the search ---------------------------------------------------------------------------- */

/* What counts as little of chi squared: a number's share of it where the noise is not known. */
static double variance_of(const search *search, double chi_squared)
{
    return !search->noise_is_scaled
               ? 1
               : chi_squared / fmax(1, (double)search->counted - search->count);
}

/* So that each so many-th experiment is enough for an idea. */
size_t identify_few(const search *search)
{
    const size_t each = FEW_EACH * (size_t)search->count, enough = each > FEW ? each : FEW;
    const size_t experiments = solve_trials_experiments(search->trials);
    return experiments > enough ? experiments / enough : 1;
}

ad_status identify_stopped(const search *search, ad_error *error)
{
    return ad_fail(error, search->error.status, "%s", search->error.message);
}

/* How many descents there are at most, of those with so many experiments; and of all. */
static int most_of(const starts *all)
{
    return all->few_ends > 0            ? (int)all->few_ends
           : all->count == STARTS / 2.0 ? DESCENTS / 2
                                        : DESCENTS;
}

static int windows_of(const starts *all)
{
    return (int)all->few_ends + most_of(all) + (all->every > 1 ? DESCENTS : 0);
}

static descent *end_at_work(search *search)
{
    return &search->all.end[search->ls.fit.at.window - (int)search->all.few_ends];
}

/* From parts of the ranges on. AD_OK also where there is no solution: chi_squared is then infinite.
 */
static ad_status begin(void *context, double *y, ad_error *error)
{
    search *search = context;
    starts *all = &search->all;
    double first;
    (void)error;
    search->ls.fit.windows = windows_of(all);
    search->counted = solve_trials_thin(search->trials, (size_t)all->every);
    *end_at_work(search) = (descent){.chi_squared = INFINITY,
                                     .steps = search->ls.again ? end_at_work(search)->steps : 0,
                                     .again = search->ls.again ? end_at_work(search)->again : 0};
    all->ends = search->ls.fit.at.window + 1 - all->few_ends;
    for (int i = 0; i < search->count; i++) {
        y[i] = logit(fmin(1 - EDGE, fmax(EDGE, all->from[i])));
    }
    all->easy = solve_trials_by_members(search->trials);
    all->easy = all->easy != 0 && evaluate(search, y, &first) == OPTIM_OBJECTIVE_OK;
    for (int i = 0; i < search->count && all->easy == 0; i++) {
        all->y[i] = NAN;
    }
    return AD_OK;
}

/* Towards the ends of a range y goes on for ever and chi squared by y is flat, though by the range
 * it may fall again, inwards. Then `from` is a place on the way where it is less. z is given. */
static bool leads_inward(search *search, const double *z, double chi_squared, double variance)
{
    enum { HALVED_MOST = 6 };
    double step[MAX], y[MAX], now = INFINITY, *from = search->all.from;
    const size_t n = (size_t)search->count;
    bool at_end = false;
    for (size_t i = 0; i < n; i++) {
        y[i] = logit(z[i]);
        at_end = at_end || z[i] < EDGE || z[i] > 1 - EDGE;
    }
    if (!at_end || evaluate(search, y, &now) != OPTIM_OBJECTIVE_OK ||
        identify_differentiate(search, z) != OPTIM_OBJECTIVE_OK) {
        return false;
    }
    identify_multiply(search, NULL);
    for (size_t i = 0; i < n; i++) {
        const double by = search->ls.jtr[i];
        for (size_t k = 0; k < n && ((z[i] < EDGE && by > 0) || (z[i] > 1 - EDGE && by < 0)); k++) {
            search->ls.jtj[i * n + k] = search->ls.jtj[k * n + i] = search->ls.jtr[i] = 0;
        }
    }
    bool leads = promised(search, variance, step) > variance, less = false;
    for (int halved = 0; leads && !less && halved < HALVED_MOST; halved++) {
        for (size_t i = 0; i < n; i++) {
            from[i] = fmin(1 - EDGE, fmax(EDGE, z[i] + ldexp(step[i], -halved)));
            y[i] = logit(from[i]);
        }
        leads = evaluate(search, y, &now) != OPTIM_OBJECTIVE_STOP;
        less = leads && now < chi_squared;
    }
    return less;
}

/* A descent that has ended begins once more where its motions need more modes or smaller steps of
 * time than those they were begun with, and where it ended on the flat way to an end of a range. */
static ad_status look_again(search *search, descent *at, double variance, ad_error *error)
{
    double values[MAX];
    bool finer = false, inward = false;
    identify_values(search, at->z, values);
    const ad_status status =
        solve_trials_choose(search->trials, values, search->room, &finer, error);
    if (status == AD_OK && finer) {
        memcpy(search->all.from, at->z, sizeof at->z);
    } else if (status == AD_OK) {
        inward = leads_inward(search, at->z, at->chi_squared, variance);
    }
    search->ls.again = (finer || inward) && at->again < AGAIN_MOST;
    at->again += search->ls.again;
    at->converged = finer || inward ? 0 : at->converged;
    return status == AD_OK && search->error.status != AD_OK ? identify_stopped(search, error)
                                                            : status;
}

static ad_status judge(void *context, optim_status status, ad_error *error)
{
    static const double DAMPING = 1.0 / 16; /* (dz/dy)^2 in the middle of a range */
    double step[MAX];
    search *search = context;
    descent *at = end_at_work(search);
    if (status == OPTIM_STOPPED_BY_OBJECTIVE) {
        return identify_stopped(search, error);
    }
    const optim_optimizer *by = search->ls.by;
    const double chi_squared = optim_inspect(by).value;
    const double variance = variance_of(search, chi_squared);
    at->steps++;
    const bool kinked = at->steps > KINKED && at->chi_squared - chi_squared < variance * STUCK;
    at->converged = status == OPTIM_FUNCTION_TOLERANCE || status == OPTIM_GRADIENT_TOLERANCE ||
                    promised(search, DAMPING * variance, step) <
                        variance * (search->all.every > 1 || kinked ? ROUGHLY
                                    : status != OPTIM_RUNNING       ? STUCK
                                                                    : SETTLED);
    at->chi_squared = isfinite(chi_squared) ? chi_squared : INFINITY;
    for (int i = 0; i < search->count; i++) {
        at->z[i] = part_of(optim_x(by)[i]);
    }
    search->ls.fit.reason = at->converged != 0 ? "converged" : NULL;
    const bool ends = at->converged != 0 || status != OPTIM_RUNNING;
    return ends && isfinite(chi_squared) ? look_again(search, at, variance, error) : AD_OK;
}

static bool is_explained(const search *search, const descent *found)
{
    const double freedom = (double)search->counted - search->count;
    return found->converged != 0 &&
           (search->noise_is_scaled || freedom <= 0 ||
            identified_off(found->chi_squared, freedom) < IDENTIFIED_EXPLAINED);
}

static double distance(int count, const double *a, const double *b)
{
    double square = 0;
    for (int i = 0; i < count; i++) {
        square += (a[i] - b[i]) * (a[i] - b[i]);
    }
    return sqrt(square);
}

/* The radius of the ball that has a part of 4 log(N)/N of the cube of all ranges. */
static double critical(int dimensions, int points)
{
    const double part = fmin(1, 4 * log(points) / points);
    return pow(tgamma(1 + dimensions / 2.0) * part, 1.0 / dimensions) / sqrt(acos(-1));
}

static ad_status try_starts(search *search, starts *all, ad_error *error)
{
    double points[MAX * STARTS], z[STARTS * MAX] = {0};
    const int n = (int)all->count;
    double *residuals = malloc((size_t)n * search->n * sizeof *residuals);
    ad_status status =
        residuals ? sampling_fill(SAMPLING_SOBOL, NULL, search->count, (size_t)n, points, error)
                  : ad_fail(error, AD_NO_MEMORY, "out of memory for starts");
    for (int k = 0; status == AD_OK && k < n; k++) {
        for (int i = 0; i < search->count; i++) {
            all->z[k][i] = z[k * search->count + i] = points[i * n + k];
        }
    }
    const bool rough = isfinite(all->end[0].chi_squared);
    status = status == AD_OK ? identify_run(search, rough, (size_t)n, z, residuals, error) : status;
    for (int k = 0; status == AD_OK && k < n; k++) {
        const double sum = vector_square(search->n, residuals + (size_t)k * search->n);
        all->chi_squared[k] = isfinite(sum) ? sum : INFINITY;
    }
    free(residuals);
    return status;
}

/* The best point that is neither near a better one nor near an end; -1: there is none. */
static int next_start(const search *search, const starts *all)
{
    const double radius = critical(search->count, (int)all->count);
    int next = -1;
    for (int k = 0; k < all->count; k++) {
        bool alone = isfinite(all->chi_squared[k]) && all->tried[k] == 0;
        for (int i = 0; i < all->count && alone; i++) {
            alone = all->chi_squared[i] >= all->chi_squared[k] ||
                    distance(search->count, all->z[i], all->z[k]) > radius;
        }
        for (int i = 0; i < all->ends && alone; i++) {
            alone = all->end[i].converged == 0 ||
                    distance(search->count, all->end[i].z, all->z[k]) > radius / 4;
        }
        if (alone && (next < 0 || all->chi_squared[k] < all->chi_squared[next])) {
            next = k;
        }
    }
    return next;
}

static void best_first(int count, descent *end)
{
    for (int i = 1; i < count; i++) {
        if (end[i].chi_squared < end[0].chi_squared) {
            const descent better = end[i];
            end[i] = end[0];
            end[0] = better;
        }
    }
}

/* From an end with some experiments that is not near one before and about as good as the best. */
static bool settle_next(const search *search, starts *all)
{
    const descent *few = all->few;
    const double limit = few->chi_squared + AS_GOOD * variance_of(search, few->chi_squared);
    for (int i = (int)all->settled; i < all->few_ends; i++) {
        bool other = i == 0 ? isfinite(few->chi_squared)
                            : few[i].converged != 0 && few[i].chi_squared <= limit;
        for (int k = 0; k < i && other; k++) {
            other = distance(search->count, few[i].z, few[k].z) > EDGE;
        }
        if (other) {
            all->settled = i + 1;
            memcpy(all->from, few[i].z, sizeof all->from);
            return true;
        }
    }
    return false;
}

/* With all experiments from then on. */
static void count_all(starts *all)
{
    all->few_ends = all->ends;
    memcpy(all->few, all->end, sizeof all->few);
    best_first((int)all->few_ends, all->few);
    all->ends = 0;
    all->every = 1;
}

/* From elsewhere, though the first end may explain the measurements: others may do so as well.
 * Where solutions are dear there are fewer starts then. */
static ad_status start_elsewhere(void *context, ad_error *error)
{
    search *search = context;
    starts *all = &search->all;
    fit *f = &search->ls.fit;
    ad_status status = AD_OK;
    if (search->settles) {
        f->state = FIT_OVER;
        return AD_OK;
    }
    if (all->few_ends == 0 && all->ends == 1) {
        const bool few =
            is_explained(search, &all->end[0]) && !solve_trials_by_members(search->trials);
        all->count = few ? STARTS / 2.0 : STARTS;
        status = try_starts(search, all, error);
    }
    const bool more = status == AD_OK && all->few_ends == 0 && all->ends < most_of(all);
    const int next = more ? next_start(search, all) : -1;
    if (next >= 0) {
        all->tried[next] = 1;
        memcpy(all->from, all->z[next], sizeof all->from);
        return AD_OK;
    }
    if (status == AD_OK && all->every > 1) {
        count_all(all);
    }
    f->state =
        status == AD_OK && all->few_ends > 0 && settle_next(search, all) ? f->state : FIT_OVER;
    return status;
}

static int state_of(void *context, optim_array *arrays)
{
    search *search = context;
    double *nodes = solve_trials_nodes(search->trials);
    arrays[0] = (optim_array){"search", &search->all.every, sizeof search->all / sizeof(double)};
    arrays[1] = (optim_array){"residuals", search->r, search->n};
    arrays[2] = (optim_array){"nodes", nodes, solve_trials_experiments(search->trials)};
    return nodes ? 3 : 2;
}

/* ---- all of it ----------------------------------------------------------------------------- */

static ad_status prepare(search *search, int sets, const solve_measured *measured,
                         identified *result, ad_error *error)
{
    double *start = search->all.from;
    const int first = scene_known_count(search->open);
    search->count = search->open->unknown_count;
    for (int i = 0; i < search->count; i++) {
        start[i] = scene_parameter_fraction(&search->open->parameters[first + i],
                                            search->open->guess[first + i]);
    }
    result->count = search->count;
    result->residuals = search->n = solve_trials_residuals(search->trials);
    result->experiments = solve_trials_experiments(search->trials);
    search->all.every = search->settles ? 1 : (double)identify_few(search);
    search->counted = search->n;
    result->by_members = solve_trials_by_members(search->trials);
    result->scaled = search->noise_is_scaled;
    ad_status status = identify_check(search->count, search->n, search->noise_is_scaled, error);
    if (status != AD_OK) {
        return status;
    }
    uint64_t digest = CHECKPOINT_HASH_START;
    for (int i = 0; i < sets; i++) {
        const solve_measured *set = &measured[i];
        const size_t numbers = (size_t)set->columns * set->rows;
        digest = checkpoint_hash(digest, set->values, numbers * sizeof(double));
        digest = checkpoint_hash(digest, set->noise, (size_t)set->columns * sizeof(double));
        digest = checkpoint_hash(digest, set->s, set->rows * sizeof(double));
        for (size_t k = 0; k < numbers; k++) {
            search->exact += pow(EXACT * set->values[k] / set->noise[k / set->rows], 2);
        }
    }
    /* of the error of central differences and that of the solutions both are then small */
    search->difference = fmin(1e-2, fmax(1e-4, cbrt(solve_trials_tolerance(search->trials))));
    const size_t count = (size_t)search->count;
    AD_TAKE(search, room, 2 * count * search->n);
    AD_TAKE(search, r, search->n);
    AD_TAKE(search, j, count * search->n);
    search->ls = (least_squares){.count = count,
                                 .scaling = OPTIM_SCALING_DIAGONAL,
                                 .sum = sum,
                                 .begin = begin,
                                 .judge = judge,
                                 .turn = start_elsewhere,
                                 .state = state_of,
                                 .context = search,
                                 .name = "unknowns",
                                 .digest = digest,
                                 .every = 1,
                                 .descents = 2 * DESCENTS,
                                 .steps = STEPS_MAX};
    return !search->memory.is_short
               ? least_squares_create(&search->ls, error)
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu residuals", search->n);
}

static void search_free(search *search)
{
    solve_trials_free(search->trials);
    least_squares_clear(&search->ls);
    ad_memory_free(&search->memory);
}

static ad_status finish(search *search, identified *result, ad_error *error)
{
    best_first((int)search->all.ends, search->all.end);
    if (!isfinite(search->all.end[0].chi_squared)) {
        const char *reason = solve_trials_reason(search->trials);
        return ad_fail(error, AD_BAD_INPUT,
                       "there is no solution where the search starts, nor anywhere else in the "
                       "ranges that was tried%s%s",
                       *reason ? ": " : "", reason);
    }
    ad_status status = identify_conclude(search, result, error);
    if (status == AD_OK) {
        status = solve_trials_reduction(search->trials, result->value, &result->reduction, error);
        result->reduction /= result->noise_factor;
    }
    result->solutions = (long)search->all.solutions;
    return status;
}

ad_status identify(const scene *open, int sets, const solve_measured *measured,
                   const identify_settings *settings, identified *result, ad_error *error)
{
    search x = {
        .open = open, .noise_is_scaled = settings->noise_is_scaled, .settles = settings->settles};
    *result = (identified){.count = 0};
    ad_status status = solve_trials_create(open, sets, measured, settings->tolerance,
                                           settings->threads, &x.trials, error);
    status = status == AD_OK ? prepare(&x, sets, measured, result, error) : status;
    status = status == AD_OK ? least_squares_run(&x.ls, settings->runner, error) : status;
    if (status == AD_OK && x.ls.fit.state == FIT_OVER) {
        status = finish(&x, result, error);
    } else if (status == AD_OK) {
        result->count = 0;
    }
    search_free(&x);
    return status;
}
