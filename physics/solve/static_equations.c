/* The equations of the static system where the path is, their derivatives, and a Newton step. */
#include "physics/solve/static_system.h"

#include <string.h>

static_point static_system_given(const static_system *system, const solve_rod_points *given,
                                 size_t i, double s)
{
    static_point at = {.rest = given->rest[i],
                       .acting = &system->rod->along,
                       .compliance = given->sections[i].compliance,
                       .actuation = static_system_actuation(system, given->actuators, i, s),
                       .tubes = system->rod->tubes};
    for (int k = 0; k < 3; k++) {
        at.rest.curvature[k] += system->path.imperfection * at.rest.imperfection[k];
    }
    acting_on_way(at.acting, given->along + i * (size_t)at.acting->numbers, system->path.load,
                  way_of(&system->path), at.numbers);
    if (system->path.perturbation != 0) {
        double *force = at.numbers + at.acting->numbers;
        memset(force, 0, 3 * sizeof *force);
        force[system->path.director] = system->path.perturbation;
        at.acting = &system->perturbed;
    }
    return at;
}

static_point static_system_point(const static_system *system, size_t i)
{
    return static_system_given(system, &system->given, i, system->mesh.points[i]);
}

ad_status static_system_rates(const static_system *system, size_t n, const double *s,
                              const double *y, double *rate, ad_error *error)
{
    const size_t rows = (size_t)system->mesh.rows;
    solve_rod_points given = {0};
    ad_status status = solve_rod_points_make(system->rod, n, s, &given, error);
    for (size_t i = 0; i < n && status == AD_OK; i++) {
        given.sections[i].compliance[2] += system->path.stretch;
        static_point at = static_system_given(system, &given, i, s[i]);
        static_rate(&at, y + i * rows, rate + i * rows, NULL);
    }
    solve_rod_points_clear(&given);
    return status;
}

static void add_length(const static_system *system, size_t point, double weight, const double *y,
                       double *excess)
{
    static_point at = static_system_point(system, point);
    double strains[ACTUATION_ROWS], rest[ACTUATION_ROWS];
    static_strains(&at, y, strains, strains + 3);
    memcpy(rest, system->given.rest[point].strain, 3 * sizeof *rest);
    memcpy(rest + 3, system->given.rest[point].curvature, 3 * sizeof *rest);
    for (int i = 0; i < system->rod->actuators; i++) {
        if (system->rod->extents[i].has_length) {
            excess[i] += weight * (solve_actuation_length(&at.actuation, i, strains) -
                                   solve_actuation_length(&at.actuation, i, rest));
        }
    }
}

void static_system_excess(const static_system *system, const double *y, double *excess)
{
    for (int i = 0; i < system->rod->actuators; i++) {
        excess[i] = system->path.load * solve_rod_displacement(system->rod, i, 0);
    }
    for (int e = 0; e < system->mesh.count; e++) {
        for (int i = 0; i < system->mesh.stages; i++) {
            add_length(system, (size_t)e * system->mesh.stages + i,
                       elements_width(&system->mesh, e) * system->mesh.rule.weights[i],
                       y + elements_edge(&system->mesh, e) + (i + 1) * system->mesh.rows, excess);
        }
    }
}

/* ---- single places ------------------------------------------------------------------------- */

/* y beyond what acts at edge e, and its derivative by y there where by_y is not NULL. */
static void jump_over(const static_system *system, int e, const double *y, double *after,
                      elements_matrix by_y)
{
    if (system->jump[e] >= 0) {
        static_jump_over(&system->jumps[system->jump[e]], y, after, by_y);
        return;
    }
    memcpy(after, y, (size_t)system->mesh.rows * sizeof *after);
    for (int r = 0; r < system->mesh.rows && by_y; r++) {
        for (int c = 0; c < system->mesh.rows; c++) {
            by_y[r][c] = r == c;
        }
    }
}

void static_system_values(const static_system *system, const double *y, int element, double *values)
{
    const solve_elements *mesh = &system->mesh;
    const double *edge = y + elements_edge(mesh, element);
    const size_t rows = (size_t)mesh->rows;
    jump_over(system, element, edge, values, NULL);
    memcpy(values + rows, edge + rows, (elements_inner(mesh) + rows) * sizeof *values);
}

/* Rows of the conditions at s = 1, which are about y beyond what acts there. */
static void end_residual(const static_system *system, const double *y, double *rows,
                         double (*by_y)[STATIC_ROWS_MAX])
{
    double after[STATIC_ROWS_MAX];
    elements_matrix across, by_after;
    jump_over(system, system->mesh.count, y + elements_edge(&system->mesh, system->mesh.count),
              after, by_y ? across : NULL);
    static_end_residual(&system->ends[1], 1, after, rows, by_after);
    for (int r = 0; r < system->mesh.end_rows && by_y; r++) {
        for (int c = 0; c < system->mesh.rows; c++) {
            by_y[r][c] = 0;
            for (int k = 0; k < system->mesh.rows; k++) {
                by_y[r][c] += by_after[r][k] * across[k][c];
            }
        }
    }
}

/* ---- residual and derivatives -------------------------------------------------------------- */

void static_system_residual(static_system *system, const double *y, double *residual)
{
    const solve_elements *mesh = &system->mesh;
    const int rows = mesh->rows;
    double unused[STATIC_END_ROWS_MAX][STATIC_ROWS_MAX], *to = residual + system->mesh.start_rows;
    static_end_residual(&system->ends[0], 0, y, residual, unused);
    for (int e = 0; e < system->mesh.count; e++) {
        const double *inner = y + elements_edge(&system->mesh, e) + rows;
        double start[STATIC_ROWS_MAX], *rate = system->rate;
        jump_over(system, e, y + elements_edge(&system->mesh, e), start, NULL);
        for (int i = 0; i < system->mesh.stages; i++) {
            static_point at = static_system_point(system, (size_t)e * system->mesh.stages + i);
            static_rate(&at, inner + i * rows, rate + i * rows, NULL);
        }
        solve_elements_residual(mesh, e, start, inner, rate, to);
        to += (mesh->stages + 1) * rows;
    }
    end_residual(system, y, to, NULL);
}

void static_system_linearise(static_system *system, const double *y)
{
    double rows[STATIC_END_ROWS_MAX], rate[STATIC_ROWS_MAX];
    static_end_residual(&system->ends[0], 0, y, rows, system->mesh.start);
    end_residual(system, y, rows, system->mesh.end);
    for (int e = 0; e < system->mesh.count; e++) {
        jump_over(system, e, y + elements_edge(&system->mesh, e), rate, system->mesh.across[e]);
        const double *inner = y + elements_edge(&system->mesh, e) + system->mesh.rows;
        for (int i = 0; i < system->mesh.stages; i++) {
            size_t p = (size_t)e * system->mesh.stages + i;
            static_point at = static_system_point(system, p);
            static_rate(&at, inner + i * system->mesh.rows, rate, system->mesh.by_y[p]);
        }
    }
}
