#include "physics/solve/static_defect.h"

#include "physics/numerics/quaternion.h"
#include "physics/solve/defect.h"

#include <math.h>
#include <stdlib.h>

static ad_status rate(const void *context, size_t n, const double *s, const double *y, double *to,
                      ad_error *error)
{
    return static_system_rates(context, n, s, y, to, error);
}

/* Of a correction of y, in rows. */
static double largest(size_t rows, size_t unknowns, const double *y, const double *step)
{
    double result = 0;
    for (size_t i = 0; i < unknowns; i += rows) {
        double turn[4], position = sqrt(vector_dot(step + i, step + i));
        quaternion_quotient(y + i + STATIC_Q, step + i + STATIC_Q, turn);
        if (!isfinite(position) || !isfinite(turn[3])) {
            return INFINITY;
        }
        result = fmax(result, fmax(position, 2 * fabs(turn[3])));
        for (size_t k = STATIC_TUBES; k < rows; k += 2) { /* theta */
            result = fabs(step[i + k]) <= result ? result : fabs(step[i + k]);
        }
    }
    return result;
}

ad_status static_defect(static_system *system, const solve_quadrature *quadrature, const double *y,
                        double *error_of_y, ad_error *error)
{
    size_t unknowns = elements_unknowns(&system->mesh), width = (size_t)system->mesh.rows;
    const solve_elements *mesh = &system->mesh;
    const solve_equations equations = {.rate = rate, .context = system};
    double values[(GAUSS_STAGES_MAX + 2) * STATIC_ROWS_MAX];
    double *rows = malloc(2 * unknowns * sizeof *rows);
    ad_status status = rows ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    *error_of_y = INFINITY;
    if (status == AD_OK) {
        static_system_residual(system, y, rows);
    }
    for (int e = 0; e < mesh->count && status == AD_OK; e++) { /* rows of its points and its end */
        static_system_values(system, y, e, values);
        status = solve_defect(quadrature, &equations, mesh, e, values,
                              rows + mesh->start_rows + elements_edge(mesh, e), error);
    }
    static_system_linearise(system, y);
    if (status == AD_OK && solve_elements_factor(&system->mesh) == 0) {
        solve_elements_solve(&system->mesh, rows, rows + unknowns);
        *error_of_y = largest(width, unknowns, y, rows + unknowns);
    }
    free(rows);
    return status;
}
