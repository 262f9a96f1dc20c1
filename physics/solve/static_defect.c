#include "physics/solve/static_defect.h"

#include "physics/quaternion.h"
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
static ad_status look_between(const static_system *x, const solve_quadrature *quadrature,
                              const double *y, int element, double *rows, ad_error *error)
{
    const gauss_rule *rule = static_system_rule(x);
    const int rows_of_y = static_system_rows(x);
    const solve_equations equations = {.rows = rows_of_y, .rate = rate, .context = x};
    size_t points = (size_t)rule->stages + 1, width = (size_t)rows_of_y;
    double values[(GAUSS_STAGES_MAX + 2) * STATIC_ROWS_MAX];
    static_system_start(x, y, element, values);
    memcpy(values + width, y + ((size_t)element * points + 1) * width,
           points * width * sizeof *values);
    return solve_defect(quadrature, &equations, rule, static_system_edges(x) + element, values,
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

ad_status static_defect(static_system *x, const solve_quadrature *quadrature, const double *y,
                        double *error_of_y, ad_error *error)
{
    size_t unknowns = static_system_unknowns(x), width = (size_t)static_system_rows(x);
    size_t stride = ((size_t)static_system_rule(x)->stages + 1) * width;
    int first = static_end_rows(static_system_rod(x), 0);
    double *rows = malloc(2 * unknowns * sizeof *rows);
    ad_status status = rows ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    *error_of_y = INFINITY;
    if (status == AD_OK) {
        static_system_residual(x, y, rows);
    }
    for (int e = 0; e < static_system_elements(x) && status == AD_OK; e++) {
        status = look_between(x, quadrature, y, e, rows + first + (size_t)e * stride, error);
    }
    static_system_linearise(x, y);
    if (status == AD_OK && static_system_factor(x) == 0) {
        static_system_solve(x, rows, rows + unknowns);
        *error_of_y = largest(width, unknowns, y, rows + unknowns);
    }
    free(rows);
    return status;
}
