/* The equilibrium next to a shape that is known, such as that of a network. */
#include "physics/numerics/quaternion.h"
#include "physics/solve/static_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* y of a state; its quaternion is the one of q, -q that is nearer to `before`. */
static void fill(const solve_rod *rod, const solve_state *state, const double *before, double *y)
{
    double q[4], R[3][3], sign = 0;
    memcpy(q, state->rotation, sizeof q);
    for (int k = 0; k < 4; k++) {
        sign += q[k] * before[k];
    }
    for (int k = 0; k < 4; k++) {
        q[k] = sign < 0 ? -q[k] : q[k];
    }
    rotation_matrix(q, R);
    memcpy(y + STATIC_R, state->position, sizeof state->position);
    memcpy(y + STATIC_Q, q, sizeof q);
    to_world(R, state->force, y + STATIC_N);
    memcpy(y + STATIC_M, state->moment, sizeof state->moment);
    memcpy(y + STATIC_TUBES, state->tubes, 2 * (size_t)rod->tubes * sizeof *y);
}

/* The guess at the points of the system, in place of the unstressed rod at y. values: room for
 * [columns + 1][points]. */
static ad_status take(const static_solution *solution, const solve_settings *settings,
                      double *values, ad_error *error)
{
    const solve_rod *rod = solution->rod;
    const size_t rows = (size_t)solution->system->mesh.rows;
    const size_t points = elements_unknowns(&solution->system->mesh) / rows;
    const int columns = solution_columns(&rod->scene);
    double units[MODEL_COLUMNS_MAX], *s = values + (size_t)columns * points;
    const double *before = solution->y + STATIC_Q;
    solve_elements_places(&solution->system->mesh, s);
    for (size_t i = 0; i < points; i++) {
        s[i] *= rod->scales.length;
    }
    solve_rod_units(rod, units);
    ad_status status = settings->guess(settings->guess_context, points, s, values, error);
    for (size_t i = 0; i < points && status == AD_OK; i++) {
        solve_state state = {.tubes = {0}};
        for (int c = 0; c < columns; c++) {
            ((double *)&state)[c] = values[(size_t)c * points + i] / units[c];
        }
        fill(rod, &state, before, solution->y + i * rows);
        before = solution->y + i * rows + STATIC_Q;
    }
    return status;
}

ad_status static_from_guess(static_solution *solution, const solve_settings *settings,
                            const path_shape *path, bool *found, solve_report *report,
                            ad_error *error)
{
    const static_path end = static_path_at(path, path->last);
    const size_t points =
        elements_unknowns(&solution->system->mesh) / (size_t)solution->system->mesh.rows;
    double *values =
        malloc(((size_t)solution_columns(&solution->rod->scene) + 1) * points * sizeof *values);
    *found = false;
    static_system_set(solution->system, &end);
    ad_status status = values ? static_system_guess(solution->system, solution->y, error)
                              : ad_fail(error, AD_NO_MEMORY, "out of memory for a guess");
    status = status == AD_OK ? take(solution, settings, values, error) : status;
    if (status == AD_OK) {
        *found = static_newton_solve(solution->newton, solution->y, &report->newton_steps);
    }
    free(values);
    return status;
}
