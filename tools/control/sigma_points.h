/* Gaussian distributions through functions, by sigma points: what the filter of estimator.h is made
 * of. A distribution is a mean z [n] and an upper triangle U [n][n] (small_matrix.h), covariance
 * U^T U.
 *
 * Points are z and z +- sqrt(c) u_j, u_j the rows of U, c = alpha^2 (n + kappa). Of values f of
 * these points, with d_j = (f_j+ - f_j-)/2 and b_j = (f_j+ + f_j-)/2 - f_0,
 *
 *   mean = f_0 + m,  m = sum_j b_j / c,
 *   covariance = 1/c sum_j (d_j d_j^T + b_j b_j^T) + (beta - alpha^2) m m^T
 *
 * which is the scaled unscented transform (weights lambda/c and 1/(2 c), Julier and Uhlmann 2004)
 * without its large weights of either sign. For beta >= alpha^2 it is a sum of squares, else
 *
 *   1/c sum_j (b_j - mu m)(b_j - mu m)^T,  mu = c/n (1 - sqrt(1 + (beta - alpha^2) n/c))
 *
 * are the last two terms, and the root is real for beta, kappa >= 0: roots of covariances are found
 * by reflections, never by downdates. alpha = 1, beta = kappa = 0 is the cubature rule. */
#ifndef CONTROL_SIGMA_POINTS_H
#define CONTROL_SIGMA_POINTS_H

typedef struct sigma_points {
    int n;
    double c, bent, mu; /* bent: sqrt(max(0, beta - alpha^2)) */
} sigma_points;

sigma_points sigma_points_of(int n, double alpha, double beta, double kappa);

/* Points of the first `width` entries: points [1 + 2 count][width] of rows 0..count-1 of the
 * triangle: z, then each + and -. */
void sigma_spread(const sigma_points *sigma, int count, int width, const double *z, const double *u,
                  double *points);

/* Of values [1 + 2 count][width], those of the other points being the same as the first: mean
 * [width], and rows d [count], b [count + 1] that are `stride` apart and 0 beyond the width, so
 * scaled that the covariance is the sum of squares of all of them. */
void sigma_gather(const sigma_points *points, int count, int width, int stride,
                  const double *values, double *mean, double *d, double *b);

/* Corrects z, U by an innovation [width] off the mean of sigma_gather with d, b of rows
 * small_matrix_stride(width) apart and noise [width] of its own. room: sigma_room(n, width)
 * numbers. Returns nu^T S^-1 nu, the normalised innovation squared, of normal [width], S^(-1/2) nu;
 * if that is not at most `gate`, z and U stay as they are. */
double sigma_correct(const sigma_points *points, int count, int width, const double *d,
                     const double *b, const double *noise, const double *innovation, double gate,
                     double *z, double *u, double *normal, double *room);
int sigma_room(int n, int width);

#endif
