#include "physics/chebyshev.h"
#include "physics/constants.h"

#include <math.h>

/* Lagrange's polynomials of s at Chebyshev's points of [0, 1], the ends among them (Trefethen 2013,
 * Approximation Theory and Approximation Practice, ch. 3 and 5): sum_k m_jk T_k(2s - 1). */
static ad_value lagrange_polynomials(ad_value s, int degree)
{
    double matrix[(ROD_WINDOW_DEGREE + 1) * (ROD_WINDOW_DEGREE + 1)];
    ad_value powers[ROD_WINDOW_DEGREE + 1] = {ad_scalar(s.tape, 1)};
    int points = degree + 1;
    for (int j = 0; j < points; j++) {
        for (int k = 0; k < points; k++) {
            double ends = (j % degree ? 1 : 2) * (k % degree ? 1 : 2);
            matrix[j * points + k] = 2 * cos(PI * j * k / degree) / (ends * degree);
        }
    }
    ad_value x = powers[1] = ad_sub(ad_scale(s, 2), powers[0]);
    for (int k = 2; k < points; k++) {
        powers[k] = ad_sub(ad_scale(ad_mul(x, powers[k - 1]), 2), powers[k - 2]);
    }
    return ad_matvec(ad_constant(s.tape, points * points, matrix), ad_stack(points, powers));
}

void chebyshev_fields(ad_value s, const double *values, int rows, int degree, ad_value *fields)
{
    double matrix[(ROD_WINDOW_DEGREE + 1) * ROD_WINDOW_ROWS];
    ad_value lagrange = lagrange_polynomials(s, degree);
    int points = degree + 1, step = ROD_WINDOW_DEGREE / degree, which[ROD_WINDOW_ROWS], count = 0;
    for (int i = 0; i < rows; i++) {
        bool moves = false;
        for (int j = 0; j < points; j++) {
            matrix[count * points + j] = values[j * step * rows + i];
            moves = moves || matrix[count * points + j] != 0;
        }
        fields[i] = ad_scalar(s.tape, 0);
        which[count] = i;
        count += moves;
    }
    if (count == 0) {
        return;
    }
    ad_value moving = ad_matvec(ad_constant(s.tape, count * points, matrix), lagrange);
    for (int k = 0; k < count; k++) {
        fields[which[k]] = ad_row(moving, k);
    }
}

/* By the barycentric formula (Berrut & Trefethen 2004, SIAM Review 46). */
static double interpolate(const double *values, int rows, int degree, int point)
{
    int step = ROD_WINDOW_DEGREE / degree;
    double above = 0, below = 0, x = cos(PI * point / ROD_WINDOW_DEGREE);
    for (int j = 0; j <= degree; j++) {
        double weight = (j % 2 ? -1 : 1) * (j % degree ? 1 : 0.5) / (x - cos(PI * j / degree));
        above += weight * values[j * step * rows];
        below += weight;
    }
    return above / below;
}

double chebyshev_misfit(const double *values, int rows, int first, int count, int degree)
{
    int step = ROD_WINDOW_DEGREE / degree;
    double largest = 0;
    for (int point = 0; point <= ROD_WINDOW_DEGREE; point++) {
        for (int i = first; point % step && i < first + count; i++) {
            double found = interpolate(values + i, rows, degree, point);
            largest = fmax(largest, fabs(found - values[point * rows + i]));
        }
    }
    return largest;
}

ad_status chebyshev_sample(int rows, const ad_value *fields, const double *parameters,
                           ad_pool *pool, double *values, ad_error *error)
{
    enum { POINTS = ROD_WINDOW_DEGREE + 1 };
    ad_program *program = NULL;
    double s[POINTS], unused[POINTS] = {0}, found[ROD_WINDOW_ROWS][POINTS];
    double *outputs[ROD_WINDOW_ROWS];
    ad_status status = ad_compile(rows, fields, NULL, pool, &program, error);
    for (int j = 0; j < POINTS; j++) {
        s[j] = (1 + cos(PI * j / ROD_WINDOW_DEGREE)) / 2;
    }
    for (int i = 0; i < rows; i++) {
        outputs[i] = found[i];
    }
    const double *inputs[2] = {s, unused};
    const ad_run run = {
        .points = POINTS, .inputs = inputs, .parameters = parameters, .outputs = outputs};
    if (status == AD_OK) {
        status = ad_execute(program, &run, error);
    }
    for (int j = 0; status == AD_OK && j < POINTS; j++) {
        for (int i = 0; i < rows; i++) {
            bool uniform = ad_extent_of(fields[i]) == AD_UNIFORM;
            values[j * rows + i] = found[i][uniform ? 0 : j];
        }
    }
    ad_program_free(program);
    return status;
}
