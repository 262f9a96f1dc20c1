#include "physics/solve/error_estimate.h"

#include <math.h>
#include <stdlib.h>

enum { PLACES = 65, TIMES = 64, ROUNDS = 3 };

/* The first tolerance of the solver, and the smallest. */
static const double FIRST_AT_REST = 1e-7, FIRST_IN_MOTION = 1e-4;
static const double LAST_AT_REST = 1e-12, LAST_IN_MOTION = 1e-9;

/* What the solver may leave of the estimate. */
static const double SHARE = 0.25;

typedef struct measuring {
    const scene *scene;
    solve_known_motion *answer;
    void *context;
    bool moves;
    int columns, positions; /* of the answer */
    size_t points;
    double *s, *t, *values; /* [points], [points]; [columns][points] of the answer */
    double *exact;          /* [positions][points] */
} measuring;

static ad_status shape_of(const void *context, size_t n, const double *s, double *values,
                          ad_error *error)
{
    const measuring *measuring = context;
    return measuring->answer(measuring->context, n, s, NULL, values, error);
}

static ad_status sample(measuring *measuring, double end, ad_error *error)
{
    const int times = measuring->moves ? TIMES : 1;
    const scene_physics *model = scene_physics_of(measuring->scene);
    measuring->points = PLACES * (size_t)times;
    measuring->columns = solution_columns(measuring->scene);
    measuring->positions = model->position_columns;
    const size_t numbers = 2 + (size_t)measuring->columns + (size_t)measuring->positions;
    measuring->s = malloc(numbers * measuring->points * sizeof *measuring->s);
    if (!measuring->s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", measuring->points);
    }
    measuring->t = measuring->s + measuring->points;
    measuring->values = measuring->t + measuring->points;
    measuring->exact = measuring->values + (size_t)measuring->columns * measuring->points;
    for (size_t i = 0; i < measuring->points; i++) {
        measuring->s[i] = scene_length(measuring->scene) * (double)(i % PLACES) / (PLACES - 1);
        measuring->t[i] = end * (double)(i / PLACES + 1) / times;
    }
    return measuring->answer(measuring->context, measuring->points, measuring->s,
                             measuring->moves ? measuring->t : NULL, measuring->values, error);
}

/* Infinite where one is not a number. */
static double largest_distance(const measuring *measuring)
{
    double largest = 0;
    for (size_t i = 0; i < measuring->points; i++) {
        double square = 0;
        for (size_t k = 0; k < (size_t)measuring->positions; k++) {
            const double off = measuring->values[k * measuring->points + i] -
                               measuring->exact[k * measuring->points + i];
            square += off * off;
        }
        largest = square <= largest ? largest : isnan(square) ? INFINITY : square;
    }
    return sqrt(largest);
}

/* What makes a solution worthless. */
static ad_status judge(const measuring *measuring, const solve_report *report, ad_error *error)
{
    if (!measuring->moves && report->load_fraction < 1) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "no equilibrium is found next to it, and from the unstressed rod none "
                       "beyond %.4g of the load",
                       report->load_fraction);
    }
    if (measuring->moves && !scene_is_beam(measuring->scene) && !solve_energy_is_met(report)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "the solver's energy is out of balance by %.2g",
                       report->energy_mismatch);
    }
    return AD_OK;
}

/* *result is NULL where it fails, or is worthless. */
static ad_status solve_by(const measuring *measuring, solve_method method, double tolerance,
                          solution **result, solve_report *report, ad_error *error)
{
    solve_settings settings = {.tolerance = tolerance, .method = method};
    if (!measuring->moves && !scene_is_beam(measuring->scene)) {
        settings.guess = shape_of;
        settings.guess_context = measuring;
    }
    ad_status status =
        solution_create(measuring->scene, &settings, measuring->moves ? measuring->points : 0,
                        measuring->t, result, report, error);
    status = status == AD_OK ? judge(measuring, report, error) : status;
    if (status != AD_OK) {
        solution_free(*result);
        *result = NULL;
    }
    return status;
}

/* By strain modes where these solve a rod's motion, which follow sudden loads best. */
static ad_status solve(const measuring *measuring, double tolerance, solution **result,
                       solve_report *report, ad_error *error)
{
    const bool modes = measuring->moves && !scene_is_beam(measuring->scene);
    ad_status status =
        modes ? solve_by(measuring, SOLVE_MODES, tolerance, result, report, error) : AD_OK;
    return modes && (status == AD_OK || status == AD_NO_MEMORY)
               ? status
               : solve_by(measuring, SOLVE_COLLOCATION, tolerance, result, report, error);
}

/* estimate: the distance and what the solver leaves, *left of it. */
static ad_status measure(const measuring *measuring, double tolerance, double *estimate,
                         double *left, double *misfit, ad_error *error)
{
    solution *solved = NULL;
    solve_report report;
    ad_status status = solve(measuring, tolerance, &solved, &report, error);
    if (status == AD_OK) {
        status = solution_evaluate(solved, measuring->positions, measuring->points, measuring->s,
                                   measuring->moves ? measuring->t : NULL, measuring->exact, error);
    }
    if (status == AD_OK) {
        *left = report.estimate;
        *misfit = solve_misfit(&report);
        *estimate = largest_distance(measuring) / report.size + report.estimate;
    }
    solution_free(solved);
    return status;
}

/* Whether it is only that there is no solution. */
static bool is_unknown(ad_status status)
{
    return status == AD_BAD_ARGUMENT || status == AD_NOT_FINITE;
}

ad_status solve_error_estimate(const scene *rod_scene, double end, solve_known_motion *answer,
                               void *context, double *estimate, ad_error *error)
{
    measuring x = {.scene = rod_scene,
                   .answer = answer,
                   .context = context,
                   .moves = scene_is_dynamic(rod_scene)};
    const double last = x.moves ? LAST_IN_MOTION : LAST_AT_REST;
    double tolerance = x.moves ? FIRST_IN_MOTION : FIRST_AT_REST, left = INFINITY, misfit = 0;
    *estimate = NAN;
    ad_status status = sample(&x, end, error);
    for (int i = 0; i < ROUNDS && status == AD_OK; i++) {
        double found, leaves;
        status = measure(&x, tolerance, &found, &leaves, &misfit, error);
        if (status == AD_OK && !(leaves >= left)) {
            *estimate = found;
            left = leaves;
        }
        if (status != AD_OK || left <= SHARE * *estimate || tolerance <= last) {
            break;
        }
        tolerance = fmax(last, fmin(tolerance, *estimate) / 100);
    }
    *estimate += misfit;
    free(x.s);
    return is_unknown(status) ? AD_OK : status;
}
