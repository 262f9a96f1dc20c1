#include "physics/solve/solve.h"
#include "physics/solve/stability.h"

#include <stdio.h>

/* Where memory lacks nothing is said. */
static int ways_to_give(const solution *x, const scene *rod_scene)
{
    double s[STABILITY_POINTS], values[MODEL_COLUMNS_MAX * STABILITY_POINTS];
    ad_error ignored;
    int ways = -1;
    stability_points(rod_scene, s);
    if (!scene_is_dynamic(rod_scene) && !scene_is_beam(rod_scene) &&
        solution_evaluate(x, solution_columns(rod_scene), STABILITY_POINTS, s, NULL, values,
                          &ignored) == AD_OK) {
        stability_count(rod_scene, values, &ways, &ignored);
    }
    return ways;
}

bool solution_doubts(const solution *x, const scene *rod_scene, const solve_settings *settings,
                     const solve_report *report, char text[SOLUTION_DOUBT])
{
    if (!scene_is_dynamic(rod_scene) && report->load_fraction < 1) {
        snprintf(text, SOLUTION_DOUBT,
                 "stopped at %.6g of the load: beyond it the equilibria that continue the "
                 "unstressed rod end, turn back or need more nodes; try --perturb 10, a smaller "
                 "load, or a stiffness that is not infinite",
                 report->load_fraction);
        return true;
    }
    if (settings->nodes == 0 && !(report->estimate <= settings->tolerance)) {
        snprintf(text, SOLUTION_DOUBT,
                 "estimated error %.2g of the %s with %d nodes, above the tolerance of %.2g; try a "
                 "larger one; jumps in loads or rest shape converge slowly",
                 report->estimate, scene_is_beam(rod_scene) ? "deflection" : "length",
                 report->nodes, settings->tolerance);
        return true;
    }
    int ways = ways_to_give(x, rod_scene);
    snprintf(text, SOLUTION_DOUBT,
             "unstable: in this equilibrium, which continues the unstressed rod, the energy falls "
             "in %d direction%s; try --perturb 10, which looks for another",
             ways, ways == 1 ? "" : "s");
    return ways > 0;
}
