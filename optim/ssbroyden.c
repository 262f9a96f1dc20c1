/* The self-scaled Broyden family with the choice of theta and tau of Al-Baali, "Numerical
 * experience with a class of self-scaling quasi-Newton algorithms", J. Optim. Theory Appl. 96
 * (1998), and as SSBroyden2 in Urban, Stefanou & Pons, "Unveiling the optimization process of
 * physics informed neural networks", J. Comput. Phys. 523 (2025), arXiv:2405.04230; also Kiyani,
 * Shukla, Urban, Darbon & Karniadakis, "Optimizing the optimizer for physics-informed neural
 * networks and Kolmogorov-Arnold networks", Comput. Methods Appl. Mech. Eng. 446 (2025),
 * arXiv:2501.16371. */
#include "internal.h"

#include <math.h>
#include <string.h>

typedef struct optim_ssbroyden {
    optim_descent descent; /* first, so that a pointer to one points to the other */
    double *matrix;        /* [count (count + 1) / 2], H: the lower triangle, row by row */
    double *hy;            /* [count], work: H y */
    double *along;         /* [2][count], work: what the update adds to a row, per H y and s */
    double *next;          /* [count], H gradient, for the gradient of the next step */
    int next_known;        /* not part of the state: the product gives the same bits at any time */
} optim_ssbroyden;

static int parts(size_t count, const optim_settings *settings, optim_part *part)
{
    const optim_part own[] = {OPTIM_STATE(optim_ssbroyden, matrix, 1, count * (count + 1) / 2),
                              OPTIM_WORK(optim_ssbroyden, hy, 1, count),
                              OPTIM_WORK(optim_ssbroyden, along, 2, count),
                              OPTIM_WORK(optim_ssbroyden, next, 1, count)};
    (void)settings;
    return optim_descent_parts(count, sizeof own / sizeof *own, own, part);
}

/* ---- the matrix ---- */

/* What row i of the triangle gives to result = H v: row.v to the i-th number, and, as column i, its
 * share to those before. Once through the row, which is all that has to come from memory. */
static void multiply_row(const double *restrict row, size_t i, const double *restrict v,
                         double *restrict result)
{
    enum { LANES = 8 }; /* as in optim_dot */
    double sum[LANES] = {0};
    size_t j = 0;
    for (; j + LANES <= i; j += LANES) {
        for (size_t lane = 0; lane < LANES; lane++) {
            sum[lane] += row[j + lane] * v[j + lane];
            result[j + lane] += row[j + lane] * v[i];
        }
    }
    for (size_t lane = 0; j < i; j++, lane++) {
        sum[lane] += row[j] * v[j];
        result[j] += row[j] * v[i];
    }
    for (size_t half = LANES / 2; half > 0; half /= 2) {
        for (size_t lane = 0; lane < half; lane++) {
            sum[lane] += sum[lane + half];
        }
    }
    result[i] = sum[0] + row[i] * v[i];
}

static void multiply(const optim_ssbroyden *ssb, const double *v, double *result)
{
    const double *row = ssb->matrix;
    for (size_t i = 0; i < ssb->descent.count; row += ++i) {
        multiply_row(row, i, v, result);
    }
}

static void set_scaled_identity(optim_ssbroyden *ssb, double scale)
{
    const size_t count = ssb->descent.count;
    double *row = ssb->matrix;
    memset(row, 0, count * (count + 1) / 2 * sizeof *row);
    for (size_t i = 0; i < count; row += ++i) {
        row[i] = scale;
    }
}

/* H+ = scale H + hy hy_along. + s s_along., symmetric by the choice of the two, and next = H+ v
 * while each row is at hand. */
static void update_and_multiply(optim_ssbroyden *ssb, double scale, const double *s,
                                const double *v)
{
    const size_t count = ssb->descent.count;
    const double *restrict hy_along = ssb->along;
    const double *restrict s_along = ssb->along + count;
    double *restrict row = ssb->matrix;
    for (size_t i = 0; i < count; row += ++i) {
        const double hy_i = ssb->hy[i], s_i = s[i];
        for (size_t j = 0; j <= i; j++) {
            row[j] = scale * row[j] + hy_i * hy_along[j] + s_i * s_along[j];
        }
        multiply_row(row, i, v, ssb->next);
    }
    ssb->next_known = 1;
}

/* ---- the model ---- */

/* With b = s.B s / s.y, h = y.H y / s.y, a = h b - 1 >= 0, c = sqrt(a / (1 + a)):
 *
 *     rho- = min(1, h (1 - c)), theta- = (rho- - 1) / a, theta+ = 1 / rho-,
 *     theta = max(theta-, min(theta+, (1 - b) / b)), sigma = 1 + a theta,
 *     phi = (1 - theta) / sigma, rho+ = min(1, 1 / b),
 *     tau = rho+ min(sigma^(-1 / (count - 1)), 1 / theta)    for theta > 0,
 *           min(rho+ sigma^(-1 / (count - 1)), sigma)        otherwise.
 *
 * h (1 - c) is 1 / (b (1 + c)), which does not cancel. theta <= 1, since theta+ = 1 for b < 1/2 and
 * (1 - b) / b <= 1 for the rest; so sigma does for both cases of tau, being above 1 in the first.
 * sigma >= rho- > 0 keeps H+ positive definite. */
static void choose(size_t count, double b, double h, double *phi, double *tau)
{
    const double a = fmax(h * b - 1, 0); /* rounding may go below */
    const double c = sqrt(a / (1 + a));
    const double rho_minus = fmin(1, 1 / (b * (1 + c)));
    const double theta_plus = 1 / rho_minus;
    const double theta_minus = rho_minus < 1 ? (rho_minus - 1) / a : 0; /* -infinity for a = 0 */
    const double theta = fmax(theta_minus, fmin(theta_plus, (1 - b) / b));
    const double sigma = 1 + (a > 0 ? a * theta : 0);
    const double rho_plus = fmin(1, 1 / b);
    const double root = count > 1 ? pow(sigma, -1 / ((double)count - 1)) : 1;
    *phi = (1 - theta) / sigma;
    *tau = fmin(rho_plus * root, sigma);
}

static void learn(void *self, const optim_pair *pair)
{
    optim_ssbroyden *ssb = self;
    const size_t count = ssb->descent.count;
    const double gamma = pair->sy / pair->yy;
    const int first = ssb->descent.scalar[OPTIM_PAIRS] == 0;
    if (first) {
        set_scaled_identity(ssb, gamma);
    }
    multiply(ssb, pair->y, ssb->hy);
    const double yhy = optim_dot(count, pair->y, ssb->hy);
    const double sbs = first ? pair->ss / gamma : pair->sbs;
    double phi, tau;
    choose(count, sbs / pair->sy, yhy / pair->sy, &phi, &tau);
    if (first) {
        tau = 1; /* gamma is the scale */
    }
    /* The update as a polynomial in H y and s. */
    const double hy_hy = (phi - 1) / (tau * yhy);
    const double hy_s = -phi / (tau * pair->sy);
    const double s_s = phi / tau * yhy / pair->sy / pair->sy + 1 / pair->sy;
    for (size_t i = 0; i < count; i++) {
        ssb->along[i] = hy_hy * ssb->hy[i] + hy_s * pair->s[i];
        ssb->along[count + i] = hy_s * ssb->hy[i] + s_s * pair->s[i];
    }
    update_and_multiply(ssb, 1 / tau, pair->s, pair->gradient);
    ssb->descent.scalar[OPTIM_PAIRS] += 1;
}

static void apply(void *self, const double *gradient, double *result)
{
    optim_ssbroyden *ssb = self;
    if (ssb->next_known) {
        memcpy(result, ssb->next, ssb->descent.count * sizeof *result);
    } else {
        multiply(ssb, gradient, result);
    }
    ssb->next_known = 0;
}

static const optim_model model = {apply, learn};

static double bytes(const optim_settings *settings, size_t count)
{
    (void)settings;
    return 8 * (double)count * (0.5 * ((double)count + 1) + 10);
}

static void begin(void *own, size_t count, const double *x, const optim_settings *settings)
{
    optim_descent_begin(own, count, x, settings, &model);
}

/* ---- stepping and looking ---- */

static optim_status step(void *own, const optim_target *target)
{
    return optim_descent_check_scalars(own, OPTIM_COUNTER_LIMIT) ? OPTIM_BAD_STATE
                                                                 : optim_descent_step(own, target);
}

static void objective_changed(void *own)
{
    optim_ssbroyden *ssb = own;
    optim_descent_objective_changed(&ssb->descent);
    ssb->next_known = 0;
}

/* A matrix that is not positive definite is left to the search, which drops it where it shows. */
static const char *state_check(const void *own)
{
    return optim_descent_check_scalars(own, OPTIM_COUNTER_LIMIT);
}

const optim_kind optim_ssbroyden_kind = {
    .about = "self-scaled Broyden",
    .needs = OPTIM_NEEDS_ONE_FUNCTION,
    .reads = OPTIM_READS_LINES | OPTIM_READS_TOLERANCES,
    .check = optim_descent_check,
    .bytes = bytes,
    .size = sizeof(optim_ssbroyden),
    .parts = parts,
    .begin = begin,
    .step = step,
    .objective_changed = objective_changed,
    .x = optim_descent_x,
    .inspect = optim_descent_inspect,
    .state_check = state_check,
    .count_max = OPTIM_SSBROYDEN_COUNT_MAX,
    .advice = "more steps of adam before, or a smaller maximum_step"};
