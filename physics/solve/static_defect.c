#include "physics/solve/static_defect.h"

#include "physics/numerics/quaternion.h"
#include "physics/solve/defect.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static ad_status rate(const void *context, size_t n, const double *s, const double *y, double *to,
                      ad_error *error)
{
    return static_system_rates(context, n, s, y, to, error);
}

/* rows: of its points and its end */
static ad_status look_between(const static_system *system, const solve_quadrature *quadrature,
                              const double *y, int element, double *rows, ad_error *error)
{
    const gauss_rule *rule = static_system_rule(system);
    const int rows_of_y = static_system_rows(system);
    const solve_equations equations = {.rows = rows_of_y, .rate = rate, .context = system};
    size_t points = (size_t)rule->stages + 1, width = (size_t)rows_of_y;
    double values[(GAUSS_STAGES_MAX + 2) * STATIC_ROWS_MAX];
    static_system_start(system, y, element, values);
    memcpy(values + width, y + ((size_t)element * points + 1) * width,
           points * width * sizeof *values);
    return solve_defect(quadrature, &equations, rule, static_system_edges(system) + element, values,
                        rows, error);
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
    size_t unknowns = static_system_unknowns(system), width = (size_t)static_system_rows(system);
    size_t stride = ((size_t)static_system_rule(system)->stages + 1) * width;
    int first = static_end_rows(static_system_rod(system), 0);
    double *rows = malloc(2 * unknowns * sizeof *rows);
    ad_status status = rows ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    *error_of_y = INFINITY;
    if (status == AD_OK) {
        static_system_residual(system, y, rows);
    }
    for (int e = 0; e < static_system_elements(system) && status == AD_OK; e++) {
        status = look_between(system, quadrature, y, e, rows + first + (size_t)e * stride, error);
    }
    static_system_linearise(system, y);
    if (status == AD_OK && static_system_factor(system) == 0) {
        static_system_solve(system, rows, rows + unknowns);
        *error_of_y = largest(width, unknowns, y, rows + unknowns);
    }
    free(rows);
    return status;
}
