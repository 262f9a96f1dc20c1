#include "tools/control/sigma_points.h"

#include "tools/control/small_matrix.h"

#include <math.h>
#include <string.h>

sigma_points sigma_points_of(int n, double alpha, double beta, double kappa)
{
    const double more = beta - alpha * alpha;
    sigma_points x = {.n = n, .c = alpha * alpha * (n + kappa)};
    if (more >= 0) {
        x.bent = sqrt(more);
    } else { /* 1 + more n/c >= 0, but for rounding */
        x.mu = x.c / n * (1 - sqrt(fmax(0, 1 + more * n / x.c)));
    }
    return x;
}

SMALL_FOR_EACH_PROCESSOR static void spread(double by, int stride, int count, int width,
                                            const double *z, const double *u, double *points)
{
    memcpy(points, z, (size_t)width * sizeof *z);
    for (int j = 0; j < count; j++) {
        double *plus = points + (1 + 2 * j) * width, *minus = plus + width;
        const double *row = u + j * stride;
        for (int k = 0; k < width; k++) {
            const double off = by * row[k];
            plus[k] = z[k] + off;
            minus[k] = z[k] - off;
        }
    }
}

void sigma_spread(const sigma_points *sigma, int count, int width, const double *z, const double *u,
                  double *points)
{
    spread(sqrt(sigma->c), small_matrix_stride(sigma->n), count, width, z, u, points);
}

SMALL_FOR_EACH_PROCESSOR static void gather(const sigma_points *points, int count, int width,
                                            int stride, const double *values, double *mean,
                                            double *d, double *b)
{
    const double by = 1 / sqrt(points->c);
    double *last = b + count * stride;
    memset(d, 0, (size_t)(count * stride) * sizeof *d);
    memset(b, 0, (size_t)((count + 1) * stride) * sizeof *b);
    for (int j = 0; j < count; j++) {
        const double *plus = values + (1 + 2 * j) * width, *minus = plus + width;
        for (int k = 0; k < width; k++) {
            d[j * stride + k] = 0.5 * by * (plus[k] - minus[k]);
            b[j * stride + k] = by * (0.5 * (plus[k] + minus[k]) - values[k]);
            last[k] += b[j * stride + k];
        }
    }
    const double rest = points->mu > 0 ? sqrt(points->n - count) * by * points->mu : points->bent;
    for (int k = 0; k < width; k++) {
        const double m = by * last[k];
        mean[k] = values[k] + m;
        last[k] = rest * m;
        for (int j = 0; j < count; j++) {
            b[j * stride + k] -= by * points->mu * m;
        }
    }
}

void sigma_gather(const sigma_points *points, int count, int width, int stride,
                  const double *values, double *mean, double *d, double *b)
{
    gather(points, count, width, stride, values, mean, d, b);
}

int sigma_room(int n, int width)
{
    const int of_states = small_matrix_stride(n), of_values = small_matrix_stride(width);
    return (2 * n + 1 + 2 * width) * of_values + width * of_states + (n + width) * of_states +
           of_values;
}

/* P_vv = T^T T = sum of squares of d, and of b and noise, whose root is N. With the gain
 * K = P_zv P_vv^-1 the covariance becomes the sum of squares of u_j - d_j K^T and of N K^T. */
double sigma_correct(const sigma_points *points, int count, int width, const double *d,
                     const double *b, const double *noise, const double *innovation, double gate,
                     double *z, double *u, double *normal, double *room)
{
    const int n = points->n, stride = small_matrix_stride(n), apart = small_matrix_stride(width);
    const size_t row = (size_t)apart * sizeof(double);
    double *N = room, *T = N + (count + 1 + width) * apart, *nu = T + (count + width) * apart;
    double *gain = nu + apart, *rows = gain + width * stride; /* [width][n], [n + width][n] */
    memcpy(N, b, (size_t)(count + 1) * row);
    memset(N + (count + 1) * apart, 0, (size_t)width * row);
    for (int i = 0; i < width; i++) {
        N[(count + 1 + i) * apart + i] = noise[i];
    }
    small_matrix_triangle(count + 1 + width, width, N);
    memcpy(T, N, (size_t)width * row);
    memcpy(T + width * apart, d, (size_t)count * row);
    small_matrix_triangle(count + width, width, T);
    memcpy(nu, innovation, (size_t)width * sizeof *nu);
    small_matrix_solve_transposed(width, T, nu);
    double square = 0;
    for (int i = 0; i < width; i++) {
        square += nu[i] * nu[i];
        normal[i] = nu[i];
    }
    if (!(square <= gate)) {
        return square;
    }
    small_matrix_product_transposed(count, width, n, d, u, gain);
    small_matrix_solve_factored(width, T, n, gain);
    small_matrix_product(count, width, n, d, gain, rows);
    for (int i = 0; i < count * stride; i++) {
        rows[i] = u[i] - rows[i];
    }
    memcpy(rows + count * stride, u + count * stride,
           (size_t)((n - count) * stride) * sizeof *rows);
    small_matrix_product(width, width, n, N, gain, rows + n * stride);
    small_matrix_triangle(n + width, n, rows);
    memcpy(u, rows, (size_t)(n * stride) * sizeof *u);
    for (int i = 0; i < width; i++) {
        for (int k = 0; k < n; k++) {
            z[k] += gain[i * stride + k] * innovation[i];
        }
    }
    return square;
}
