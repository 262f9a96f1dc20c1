#include "physics/check/plausible.h"
#include "physics/numerics/constants.h"
#include "physics/numerics/vector_size.h"
#include "physics/rod/rod.h"
#include "physics/solve/solve.h"
#include "physics/solve/stability.h"

#include <math.h>
#include <stdlib.h>

/* Nothing is known where memory has run out. */
static stability stability_of(const solution *solution, const scene *rod_scene)
{
    double s[STABILITY_POINTS], values[MODEL_COLUMNS_MAX * STABILITY_POINTS];
    stability found = {.modes = -1, .share = NAN};
    ad_error ignored;
    if (!scene_is_dynamic(rod_scene) && !scene_is_beam(rod_scene) &&
        stability_points(rod_scene, s, &ignored) == AD_OK &&
        solution_evaluate(solution, solution_columns(rod_scene), STABILITY_POINTS, s, NULL, values,
                          &ignored) == AD_OK &&
        stability_find(rod_scene, values, &found, &ignored) != AD_OK) {
        snprintf(found.unknown, sizeof found.unknown, "%.180s", ignored.message);
    }
    return found;
}

/* What is allowed, in tolerances of the position, but at most a tenth of the energy. Motions whose
 * error is within their tolerance are out of balance by up to 10 tolerances
 * (configs/cases/travelling_helix.yaml, --tolerance 1e-6 and 1e-3), usually by less than one. */
static const double ALLOWED_MISMATCH = 100;

bool solve_energy_is_met(const solve_report *report)
{
    return report->energy_mismatch <= SOLVE_ENERGY_ALLOWED;
}

/* An error d of the position, in lengths, changes the work of loads F by up to F L d, and stands
 * for a strain energy of the order of d^2 EI/L: small motions are only as exact as their tolerance.
 * Of a motion that is out of balance by more than a tenth nothing is known, however small it is: it
 * may not have met its loads. */
static void judge_energy(const scene *rod_scene, const solve_settings *settings,
                         const solve_report *report, verdict *result)
{
    rod_numbers n = rod_numbers_of(rod_scene);
    double share = fmin(ALLOWED_MISMATCH * settings->tolerance, SOLVE_ENERGY_ALLOWED);
    double loads = n.tip_force + n.tip_moment + n.distributed_force + n.distributed_moment +
                   n.weight + n.point_force + n.point_moment + n.actuation;
    double limit = fmin((share * (report->energy + loads) + share * share) / report->energy,
                        SOLVE_ENERGY_ALLOWED);
    if (!(report->energy_mismatch <= limit)) {
        verdict_add(result, VERDICT_ENERGY_OUT_OF_BALANCE,
                    "energy, work and dissipation differ by %.2g of the largest, where a tolerance "
                    "of %.2g allows %.2g; try a smaller one, and look for loads that jump",
                    report->energy_mismatch, settings->tolerance, limit);
    }
}

/* In estimated errors, and what rounding leaves. Of 500 random scenes at rest by the solver
 * (tests/library/test_random_scenes.c) the rest is at most twice the estimated error, and below
 * 2e-11. */
static const double ALLOWED_BALANCE = 100, ROUNDING_BALANCE = 1e-11;

void solve_judge_balance(double balance, double allowed_error, verdict *result)
{
    double limit = ALLOWED_BALANCE * allowed_error + ROUNDING_BALANCE;
    if (!(balance <= limit)) {
        verdict_add(result, VERDICT_LOADS_OUT_OF_BALANCE,
                    "all loads, integrated by themselves, and the forces and moments of the ends "
                    "add up to %.2g of their size, where the estimated error allows %.2g; look for "
                    "loads that jump or are narrow",
                    balance, limit);
    }
}

/* A network goes on smoothly for a little. */
static const double ALLOWED_EXCESS = 0.02;

enum { V = 7 }; /* columns before: position, rotation */

/* As strains are in tables, by metres of the rod as it is written. */
static scene_rest rest_as_written(const scene *rod_scene)
{
    scene written = *rod_scene;
    written.rod.growth = (quantity){.is_given = false};
    return scene_rest_of(&written);
}

static void judge_learned(const scene *rod_scene, size_t n, const double *s, const double *t,
                          const double *values, verdict *result)
{
    static const char *const names[] = {"v1", "v2", "v3", "u1", "u2", "u3"};
    const scene_law *law = rod_scene->rod.law;
    const scene_rest rest = rest_as_written(rod_scene);
    double worst = ALLOWED_EXCESS, strain = 0;
    int which = -1;
    for (size_t i = 0; i < n; i++) {
        double x[SCENE_LAW_STRAINS];
        int of = -1;
        for (int k = 0; k < SCENE_LAW_STRAINS; k++) {
            const quantity at_rest = k < 3 ? rest.strain[k] : rest.curvature[k - 3];
            x[k] = values[(size_t)(V + k) * n + i] - quantity_value(at_rest, s[i], t ? t[i] : 0);
        }
        const double beyond = scene_law_excess(law, x, &of);
        if (beyond > worst) {
            worst = beyond;
            strain = x[of];
            which = of;
        }
    }
    if (which >= 0) {
        verdict_add(result, VERDICT_OUTSIDE_DATA,
                    "strain %s is %.4g%s beyond rest, and the data of rod.law have %.4g to %.4g; "
                    "give cpinn-law larger strains",
                    names[which], strain, which < 3 ? "" : " 1/m", law->low[which],
                    law->high[which]);
    }
}

/* How many times as long as at rest a linear law may make a rod. Rubber, which stands most, has 0.4
 * times its stiffness at twice its length, and 6 times at half of it: E (1 + 2/x^3)/3 by the law
 * of neo-Hooke. */
static const double SHORTEST = 0.5, LONGEST = 2;

static void judge_linear(const scene *rod_scene, size_t n, const double *s, const double *t,
                         const double *values, verdict *result)
{
    const scene_rest rest = rest_as_written(rod_scene);
    const double *v[3] = {values + V * n, values + (V + 1) * n, values + (V + 2) * n};
    double least = INFINITY, most = 0;
    size_t at[2] = {0, 0};
    for (size_t i = 0; i < n; i++) {
        const double at_rest = quantity_value(rest.strain[2], s[i], t ? t[i] : 0);
        const double across = v[2][i] / at_rest, along = hypot(hypot(v[0][i], v[1][i]), v[2][i]);
        at[0] = across < least ? i : at[0];
        at[1] = along / at_rest > most ? i : at[1];
        least = fmin(least, across);
        most = fmax(most, along / at_rest);
    }
    const bool is_crushed = least < SHORTEST;
    if (is_crushed || most > LONGEST) {
        const size_t where = at[!is_crushed];
        verdict_add(result, VERDICT_STRAIN_LARGE,
                    "at s = %.4g m the rod is %s to %.3g of its length, where no linear law of a "
                    "section holds; look at the units of loads and of the modulus, or give rod.law",
                    s[where], is_crushed ? "crushed" : "stretched", is_crushed ? least : most);
    }
}

void solve_judge_strains(const scene *rod_scene, size_t n, const double *s, const double *t,
                         const double *values, verdict *result)
{
    (rod_scene->rod.law ? judge_learned : judge_linear)(rod_scene, n, s, t, values, result);
}

/* Of all that was solved. */
static void judge_strains(const solution *solution, const scene *rod_scene, verdict *result)
{
    enum { PLACES = 65, TIMES = 65 };
    const bool moves = scene_is_dynamic(rod_scene);
    const size_t n = moves ? PLACES * TIMES : PLACES;
    const int columns = solution_columns(rod_scene);
    double *all = malloc(n * (size_t)(columns + 2) * sizeof *all);
    ad_error ignored;
    for (size_t i = 0; i < n && all; i++) {
        all[i] = scene_length(rod_scene) * (double)(i % PLACES) / (PLACES - 1);
        all[n + i] = scene_duration(rod_scene) * (double)(i / PLACES) / (TIMES - 1);
    }
    double *t = moves && all ? all + n : NULL;
    if (all && solution_evaluate(solution, columns, n, all, t, all + 2 * n, &ignored) == AD_OK) {
        solve_judge_strains(rod_scene, n, all, t, all + 2 * n, result);
    }
    free(all);
}

static void judge_estimate(const scene *rod_scene, const solve_settings *settings,
                           const solve_report *report, verdict *result)
{
    bool moves = scene_is_dynamic(rod_scene), beam = scene_is_beam(rod_scene);
    if (!(report->estimate_l2 <= settings->tolerance)) {
        verdict_add(result, VERDICT_ESTIMATE_ABOVE_TOLERANCE,
                    "estimated error %.2g of the %s with %d nodes, above the tolerance of %.2g; "
                    "try a larger one%s",
                    report->estimate_l2,
                    beam    ? "deflection"
                    : moves ? "position"
                            : "length",
                    report->nodes, settings->tolerance,
                    moves ? "; jumps in loads or rest shape converge slowly" : "");
    } else if (moves && !beam && !(report->estimate <= SOLVE_PEAK * settings->tolerance)) {
        verdict_add(result, VERDICT_ESTIMATE_ABOVE_TOLERANCE,
                    "estimated error up to %.2g of the length with %d nodes, %g times the "
                    "tolerance of %.2g; try a larger one",
                    report->estimate, report->nodes, report->estimate / settings->tolerance,
                    settings->tolerance);
    }
}

/* That the full load is not reached. */
static void judge_load(const solve_settings *settings, const solve_report *report, verdict *result)
{
    if (settings->branch > 0) {
        verdict_add(result, VERDICT_LOAD_NOT_REACHED,
                    "branch %d, which leaves the path of the unstressed rod at %.9g of the load, "
                    "does not lead to the full load",
                    settings->branch, report->bifurcation_load);
    } else if (!isnan(report->limit_load)) {
        verdict_add(result, VERDICT_LOAD_NOT_REACHED,
                    "the equilibria that continue the unstressed rod turn back at a limit point at "
                    "%.9g of the load, and none under the full load was found on their path beyond "
                    "it; try the option path, perturb 10 or a smaller load",
                    report->limit_load);
    } else {
        verdict_add(result, VERDICT_LOAD_NOT_REACHED,
                    "stopped at %.6g of the load: beyond it the equilibria that continue the "
                    "unstressed rod end, turn back or need more nodes; try perturb 10, a smaller "
                    "load, or a stiffness that is not infinite",
                    report->load_fraction);
    }
}

/* Whether a rod that is loaded slowly would have left the path on the way. */
static bool is_left_behind(const solve_settings *settings, const solve_report *report)
{
    return report->snapped || (settings->branch == 0 && !isnan(report->bifurcation_load));
}

static void judge_path(const solve_report *report, verdict *result)
{
    double limit = report->limit_load, crossing = report->bifurcation_load;
    bool turns_first = !isnan(limit) && !(crossing < limit);
    char turn[80] = "";
    if (!isnan(limit) && !turns_first) {
        snprintf(turn, sizeof turn, ", before its limit point at %.9g", limit);
    }
    verdict_add(result, VERDICT_SNAPPED,
                "a rod that is loaded slowly leaves this path at %.9g of the load, at a %s%s, and "
                "snaps; this equilibrium lies on the same path beyond",
                turns_first ? limit : crossing, turns_first ? "limit point" : "bifurcation", turn);
}

/* The remark that other equilibria may exist. */
static void judge_uniqueness(const scene *rod_scene, const solve_settings *settings,
                             const solve_report *report, verdict *result)
{
    bool perturbed = settings->perturbation != 0 || scene_is_imperfect(rod_scene);
    if (settings->branch > 0) {
        verdict_add(result, VERDICT_SEVERAL_EQUILIBRIA,
                    "of several equilibria this one lies on branch %d, which leaves the path of "
                    "the unstressed rod at %.9g of the load",
                    settings->branch, report->bifurcation_load);
    } else {
        verdict_add(result, VERDICT_SEVERAL_EQUILIBRIA,
                    "pushed from both ends: of possibly several equilibria this one continues the "
                    "%s",
                    perturbed ? "rod as it was perturbed"
                              : "unstressed rod; perturb 10 looks for a buckled one");
    }
}

void solution_verdict(const solution *solution, const scene *rod_scene,
                      const solve_settings *settings, const solve_report *report, verdict *result)
{
    bool moves = scene_is_dynamic(rod_scene), beam = scene_is_beam(rod_scene);
    if (!moves && report->load_fraction < 1) {
        judge_load(settings, report, result);
        return;
    }
    const int *given = settings->modes;
    if (settings->nodes == 0 && given[0] + given[1] + given[2] + given[3] == 0) {
        judge_estimate(rod_scene, settings, report, result);
    }
    if (report->unresolved) {
        verdict_add(result, VERDICT_UNRESOLVED,
                    "%s jumps in more places than are found, or along a curve of s and t, or "
                    "varies on lengths that no mesh here follows: the estimated error may be too "
                    "small; try fewer jumps, or a smoother formula",
                    report->unresolved);
    }
    if (!moves && settings->nodes == 0) {
        solve_judge_balance(report->balance, fmax(report->estimate, settings->tolerance), result);
    }
    if (moves && !beam) {
        judge_energy(rod_scene, settings, report, result);
    }
    if (!beam) {
        judge_strains(solution, rod_scene, result);
    }
    if (rod_scene->rod.law && isnan(report->misfit)) {
        verdict_add(result, VERDICT_MISFIT_UNKNOWN,
                    "the law of rod.law does not say how well it meets its data: what that leaves "
                    "is not in the estimated error; learn it again with cpinn-law");
    }
    scene_judge_sizes(rod_scene, result);
    double turn[3];
    if (rod_turn_is_doubtful(rod_scene, turn)) {
        double size = vector_length(turn);
        verdict_add(result, VERDICT_END_TURN,
                    "boundary.end.rotation is taken as a turn of %.4g degrees about (%.3g, %.3g, "
                    "%.3g) from where the unstressed rod ends; for another way round give "
                    "boundary.end.rotation_vector",
                    size * 180 / PI, turn[0] / size, turn[1] / size, turn[2] / size);
    }
    const stability found = stability_of(solution, rod_scene);
    char advice[200] = "; try perturb 10, which looks for another";
    if (settings->branch == 0 && !isnan(report->bifurcation_load)) {
        snprintf(advice, sizeof advice,
                 "; another path crosses that of the unstressed rod at %.9g of the load: branch 1 "
                 "follows it; try perturb 10, which looks for another",
                 report->bifurcation_load);
    }
    stability_judge(&found, advice, result);
    if (stability_is_lost(&found) && !found.aside) {
        return;
    }
    if (is_left_behind(settings, report)) {
        judge_path(report, result);
    } else if (report->may_buckle || settings->branch > 0) {
        judge_uniqueness(rod_scene, settings, report, result);
    }
}
