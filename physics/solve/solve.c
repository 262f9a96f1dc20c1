#include "physics/solve/solve.h"

#include "physics/numerics/sort.h"
#include "physics/scene/breaks.h"
#include "physics/scene/support.h"
#include "physics/solve/balance.h"
#include "physics/solve/beam_solver.h"
#include "physics/solve/dynamic.h"
#include "physics/solve/modes_motion.h"
#include "physics/solve/rows.h"
#include "physics/solve/static.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct solution {
    rod_scales scales;
    double duration; /* in units of time, as times; 0 if static */
    solve_rod *rod;  /* of rods in space, and one of the three */
    static_solution *at_rest;
    dynamic_solution *moving;
    modes_solution *in_modes;
    solve_beam *beam; /* of beams of small deflection */
    beam_solution *bent;
    size_t count;
    double *times; /* [count] ascending, each once; in units of the rod's time */
};

/* No estimate is below this: sums over some thousand points leave errors of up to 8e-14 of the
 * length that neither meshes nor what equations leave undone show (rods with bands, jumps and point
 * loads, against shooting). */
static const double ROUNDING = 1e-13, BEAM_ROUNDING = 1e-14;

/* Nodes hold locked strains by springs, which ring, so that they do not tell the forces there. */
static bool moves_by_modes(const scene *rod_scene)
{
    ad_error unused;
    return scene_has_rubbing_tendons(rod_scene) ||
           (scene_locks_somewhere(rod_scene) &&
            support_check(rod_scene, SUPPORT_MODES, NULL, &unused) == AD_OK);
}

solve_settings solve_settings_default(const scene *rod_scene)
{
    bool hard = scene_is_dynamic(rod_scene) && !scene_is_beam(rod_scene);
    bool stiff = hard && scene_locks_strains(rod_scene);
    return (solve_settings){.tolerance = stiff  ? 1e-4
                                         : hard ? 1e-6
                                                : 1e-10,
                            .method = hard && moves_by_modes(rod_scene) ? SOLVE_MODES
                                                                        : SOLVE_COLLOCATION};
}

const char *const *solve_method_names(void)
{
    static const char *const names[] = {"collocation", "modes", NULL};
    return names;
}

solve_report solve_report_blank(void)
{
    return (solve_report){.estimate = NAN,
                          .balance = NAN,
                          .estimate_l2 = NAN,
                          .load_fraction = 1,
                          .energy_mismatch = NAN,
                          .limit_load = NAN,
                          .bifurcation_load = NAN,
                          .path_estimate = NAN};
}

double solve_misfit(const solve_report *report)
{
    return isnan(report->misfit) ? 0 : report->misfit;
}

static ad_status solve_rod_scene(solution *solution, const scene *rod_scene,
                                 const solve_settings *settings, solve_report *report,
                                 ad_error *error)
{
    ad_status status = solve_rod_create(rod_scene, &solution->rod, error);
    if (status != AD_OK) {
        return status;
    }
    if (!solution->rod->dynamic) {
        return static_solve(solution->rod, settings,
                            settings->before ? settings->before->at_rest : NULL, &solution->at_rest,
                            report, error);
    }
    status = settings->method == SOLVE_MODES
                 ? modes_motion_solve(solution->rod, settings, solution->count, solution->times,
                                      &solution->in_modes, report, error)
                 : dynamic_solve(solution->rod, settings, solution->count, solution->times,
                                 &solution->moving, report, error);
    if (status != AD_BAD_INPUT) {
        return status;
    }
    if (error) {
        error->status = AD_BAD_ARGUMENT; /* no place in a file is known here */
    }
    return AD_BAD_ARGUMENT;
}

static ad_status solve_beam_scene(solution *solution, const scene *beam_scene,
                                  const solve_settings *settings, solve_report *report,
                                  ad_error *error)
{
    ad_status status = solve_beam_create(beam_scene, &solution->beam, error);
    return status == AD_OK ? beam_solve(solution->beam, settings, solution->count, solution->times,
                                        &solution->bent, report, error)
                           : status;
}

/* All times, each once, and the end. */
static ad_status gather_times(solution *solution, size_t count, const double *times,
                              ad_error *error)
{
    double end = solution->duration;
    solution->times = malloc((count + 1) * sizeof *solution->times);
    if (!solution->times) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", count);
    }
    for (size_t i = 0; i < count; i++) {
        solution->times[i] = fmin(end, fmax(0, times[i] / solution->scales.time));
    }
    solution->times[count] = end;
    solution->count = sort_once(count + 1, solution->times);
    return AD_OK;
}

ad_status solve_check(const scene *rod_scene, const solve_settings *settings, bool path,
                      const char **key, ad_error *error)
{
    const bool moves = scene_is_dynamic(rod_scene);
    const support_form form = settings->method == SOLVE_MODES ? SUPPORT_MODES
                              : moves                         ? SUPPORT_NODES
                                                              : SUPPORT_COLLOCATION;
    ad_status status = support_check(rod_scene, form, key, error);
    return status == AD_OK && (path || settings->branch > 0)
               ? support_check(rod_scene, SUPPORT_PATH, key, error)
               : status;
}

static ad_status solve(solution *solution, const scene *rod_scene, const solve_settings *settings,
                       size_t count, const double *times, solve_report *report, ad_error *error)
{
    bool moves = scene_is_dynamic(rod_scene);
    ad_status status = solve_check(rod_scene, settings, false, NULL, error);
    if (status != AD_OK) {
        return status;
    }
    solution->scales = rod_scales_of(rod_scene);
    if (moves) {
        solution->duration = scene_duration(rod_scene) / solution->scales.time;
        status = gather_times(solution, count, times, error);
    }
    if (status != AD_OK) {
        return status;
    }
    return scene_is_beam(rod_scene) ? solve_beam_scene(solution, rod_scene, settings, report, error)
                                    : solve_rod_scene(solution, rod_scene, settings, report, error);
}

/* Of a motion, whose meshes and steps take what breaks are found. */
static ad_status find_unresolved(const scene *rod_scene, solve_report *report, ad_error *error)
{
    scene_breaks breaks;
    ad_status status = AD_OK;
    for (int i = 0; i < 2 && status == AD_OK && !report->unresolved; i++) {
        status = scene_breaks_of(rod_scene, i == 0 ? "s" : "t", &breaks, error);
        report->unresolved = breaks.unresolved;
    }
    return status;
}

/* The columns of a scene at rest. */
static ad_status shape_of(const void *context, size_t n, const double *s, double *values,
                          ad_error *error)
{
    const solution *solution = context;
    return solution_evaluate(solution, solution->beam ? 4 : solution_columns(&solution->rod->scene),
                             n, s, NULL, values, error);
}

static ad_status find_balance(const solution *solution, solve_report *report, ad_error *error)
{
    return solution->beam
               ? solve_balance_beam(solution->beam, shape_of, solution, &report->balance, error)
               : solve_balance_rod(solution->rod, shape_of, solution, &report->balance, error);
}

/* Positions of a solution at its own times, [3][PLACES] each after the other. */
enum { PLACES = 33 };

static ad_status positions_of(const solution *solution, double *to, ad_error *error)
{
    const size_t times = solution->duration > 0 ? solution->count : 1;
    double s[PLACES], t[PLACES];
    ad_status status = AD_OK;
    for (size_t i = 0; i < times && status == AD_OK; i++) {
        for (int k = 0; k < PLACES; k++) {
            s[k] = solution->scales.length * k / (PLACES - 1);
            t[k] = solution->duration > 0 ? solution->times[i] * solution->scales.time : 0;
        }
        status = solution_evaluate(solution, 3, PLACES, s, t, to + i * 3 * PLACES, error);
    }
    return status;
}

/* The largest distance of two solutions of one scene, over its length. */
static ad_status distance_of(const solution *x, const solution *y, double *distance,
                             ad_error *error)
{
    const size_t times = x->duration > 0 ? x->count : 1, each = times * 3 * PLACES;
    double *a = malloc(2 * each * sizeof *a), *b = a + each;
    ad_status status =
        a ? positions_of(x, a, error) : ad_fail(error, AD_NO_MEMORY, "out of memory");
    status = status == AD_OK ? positions_of(y, b, error) : status;
    *distance = 0;
    for (size_t i = 0; i < times * PLACES && status == AD_OK; i++) {
        const size_t at = i / PLACES * 3 * PLACES + i % PLACES;
        double square = 0;
        for (size_t k = 0; k < 3; k++) {
            square += pow(a[at + k * PLACES] - b[at + k * PLACES], 2);
        }
        *distance = fmax(*distance, sqrt(square) / x->scales.length);
    }
    free(a);
    return status;
}

/* What it is worth to solve the other law for: a hundredth of what its misfit is. */
static const double OF_MISFIT = 1e-2;

/* The same with a law that is stiffer by its misfit. */
static ad_status find_misfit(const solution *x, const scene *rod_scene,
                             const solve_settings *settings, size_t count, const double *times,
                             solve_report *report, ad_error *error)
{
    scene other = *rod_scene;
    report->misfit = other.rod.law ? other.rod.law->misfit : 0;
    if (!(report->misfit > 0) || report->load_fraction < 1) {
        return AD_OK;
    }
    scene_law law = *other.rod.law;
    solve_settings asked = *settings;
    solve_report of_other;
    solution *moved = NULL;
    scene_law_stiffen(&law, 1 + report->misfit);
    other.rod.law = &law;
    asked.tolerance = fmax(asked.tolerance, OF_MISFIT * report->misfit);
    ad_status status = solution_create(&other, &asked, count, times, &moved, &of_other, error);
    if (status == AD_OK && of_other.load_fraction == 1) {
        status = distance_of(x, moved, &report->misfit, error);
    } else if (status != AD_NO_MEMORY) {
        report->misfit = NAN;
        status = AD_OK;
    }
    solution_free(moved);
    return status;
}

ad_status solution_create(const scene *rod_scene, const solve_settings *settings, size_t count,
                          const double *times, solution **result, solve_report *report,
                          ad_error *error)
{
    *result = NULL;
    if (scene_is_open(rod_scene)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "a family has no solution; allowed: a member of it (scene_member)");
    }
    solution *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a solution");
    }
    ad_status status = solve(x, rod_scene, settings, count, times, report, error);
    if (status == AD_OK && scene_is_dynamic(rod_scene) && !report->unresolved) {
        status = find_unresolved(rod_scene, report, error);
    }
    if (status == AD_OK && x->duration == 0 && report->load_fraction == 1) {
        status = find_balance(x, report, error);
    }
    if (status == AD_OK) {
        status = find_misfit(x, rod_scene, settings, count, times, report, error);
    }
    if (status != AD_OK) {
        solution_free(x);
        return status;
    }
    if (!isnan(report->estimate)) {
        report->estimate = fmax(report->estimate, x->beam ? BEAM_ROUNDING : ROUNDING);
        report->estimate_l2 =
            isnan(report->estimate_l2) ? report->estimate : fmax(report->estimate_l2, ROUNDING);
    }
    report->size = x->beam ? x->beam->deflection * beam_largest(x->bent) : x->scales.length;
    *result = x;
    return AD_OK;
}

void solution_free(solution *solution)
{
    if (solution) {
        static_free(solution->at_rest);
        dynamic_free(solution->moving);
        modes_motion_free(solution->in_modes);
        solve_rod_free(solution->rod);
        beam_free(solution->bent);
        solve_beam_free(solution->beam);
        free(solution->times);
        free(solution);
    }
}

/* ---- values -------------------------------------------------------------------------------- */

int solution_columns(const scene *rod_scene)
{
    const scene_physics *model = scene_physics_of(rod_scene);
    int count = 0;
    while (count < model->column_count &&
           (scene_is_dynamic(rod_scene) || !model->columns[count].of_motion)) {
        count++;
    }
    return count;
}

/* Doubles in the state of a model: its columns. */
static size_t width_of(const solution *solution)
{
    return (solution->beam ? sizeof(beam_state) : sizeof(solve_state)) / sizeof(double);
}

/* Which of the times is t, in units of the scene's. */
static size_t nearest_time(const solution *solution, double t)
{
    size_t nearest = 0;
    for (size_t i = 1; i < solution->count; i++) {
        nearest = fabs(solution->times[i] - t) < fabs(solution->times[nearest] - t) ? i : nearest;
    }
    return nearest;
}

/* At n points of one time; s [n] within [0, 1]; out [n][width]. */
static ad_status states_at(const solution *solution, size_t n, const double *s, double t,
                           double *out, ad_error *error)
{
    if (solution->bent) {
        beam_at(solution->bent, nearest_time(solution, t), n, s, (beam_state *)out);
        return AD_OK;
    }
    solve_state *states = (solve_state *)out;
    if (solution->in_modes) {
        return modes_motion_at(solution->in_modes, nearest_time(solution, t), n, s, states, error);
    }
    return solution->at_rest
               ? static_at(solution->at_rest, n, s, states, error)
               : dynamic_at(solution->moving, nearest_time(solution, t), n, s, states, error);
}

/* out [points][width]; scaled [points]: room for s. */
static ad_status all_states(const solution *solution, size_t points, const double *s,
                            const double *t, double *scaled, double *out, ad_error *error)
{
    bool still = solution->duration == 0;
    ad_status status = AD_OK;
    for (size_t i = 0; i < points; i++) {
        scaled[i] = fmin(1, fmax(0, s[i] / solution->scales.length));
    }
    for (size_t first = 0, end; status == AD_OK && first < points; first = end) {
        for (end = first; end < points && (still || t[end] == t[first]); end++) {
        }
        status = states_at(solution, end - first, scaled + first,
                           still ? 0 : t[first] / solution->scales.time,
                           out + first * width_of(solution), error);
    }
    return status;
}

_Static_assert(sizeof(solve_state) <= MODEL_COLUMNS_MAX * sizeof(double), "a state is its columns");

ad_status solution_evaluate(const solution *solution, int columns, size_t points, const double *s,
                            const double *t, double *values, ad_error *error)
{
    const bool grows = !solution->beam && solution->rod->scene.rod.growth.is_given;
    size_t width = width_of(solution);
    double *scaled = malloc(points * sizeof *scaled), units[MODEL_COLUMNS_MAX];
    double *states = malloc(points * width * sizeof *states);
    ad_status status = scaled && states
                           ? all_states(solution, points, s, t, scaled, states, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", points);
    if (solution->beam) {
        solve_beam_units(solution->beam, units);
    } else {
        solve_rod_units(solution->rod, units);
    }
    for (size_t i = 0; status == AD_OK && i < points; i++) {
        for (int c = 0; c < columns; c++) { /* no -0 in a table */
            values[(size_t)c * points + i] = states[i * width + (size_t)c] * units[c] + 0.0;
        }
        for (int c = 7; c < columns && c < 13 && grows; c++) { /* v, u by metres as written */
            values[(size_t)c * points + i] /=
                scene_growth_at(&solution->rod->scene, NULL, s[i], t ? t[i] : 0);
        }
    }
    free(scaled);
    free(states);
    return status;
}

/* ---- energy -------------------------------------------------------------------------------- */

double solution_tension(const solution *solution, int tendon)
{
    return solution->at_rest ? static_tension(solution->at_rest, tendon) * solution->scales.force
                             : 0;
}

double solution_tension_at(const solution *solution, int tendon, double s)
{
    return static_tension_at(solution->at_rest, tendon, s / solution->scales.length) *
           solution->scales.force;
}

ad_status solution_energy(const solution *solution, double t, solve_energy *energy, ad_error *error)
{
    const rod_scales *scale = &solution->rod->scales;
    double unit = scale->force * scale->length;
    if (solution->moving || solution->in_modes) {
        const solve_energy *all = solution->in_modes ? modes_motion_energies(solution->in_modes)
                                                     : dynamic_energies(solution->moving);
        *energy = all[nearest_time(solution, t / scale->time)];
    } else {
        ad_status status = static_energy(solution->at_rest, energy, error);
        if (status != AD_OK) {
            return status;
        }
    }
    double *parts[5] = {&energy->kinetic, &energy->strain, &energy->work, &energy->dissipated,
                        &energy->mismatch};
    for (int i = 0; i < 5; i++) {
        *parts[i] *= unit;
    }
    return AD_OK;
}
