#include "physics/local/complement.h"

#include "autodiff/dense.h"

#include <math.h>
#include <string.h>

/* x [count] of active rows: matrix x = right there, 0 elsewhere; false: singular. */
static bool meet(int count, const bool *active, const double *matrix, const double *right,
                 double *x)
{
    double factor[COMPLEMENT_MAX * COMPLEMENT_MAX], found[COMPLEMENT_MAX];
    int pivots[COMPLEMENT_MAX], rows[COMPLEMENT_MAX], n = 0;
    for (int i = 0; i < count; i++) {
        x[i] = 0;
        if (active[i]) {
            rows[n++] = i;
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            factor[j * n + i] = matrix[rows[i] * count + rows[j]];
        }
        found[i] = right[rows[i]];
    }
    if (n > 0 && ad_dense_lu((size_t)n, factor, pivots) != 0) {
        return false;
    }
    if (n > 0) {
        ad_dense_lu_solve((size_t)n, 1, factor, pivots, found);
    }
    for (int i = 0; i < n; i++) {
        x[rows[i]] = found[i];
    }
    return true;
}

/* Meets active rows, and lets go of those whose numbers would be negative. */
static bool settle(int count, int open, bool *active, const double *matrix, const double *right,
                   double *x)
{
    for (bool negative = true; negative;) {
        double wanted[COMPLEMENT_MAX], share = 1;
        if (!meet(count, active, matrix, right, wanted)) {
            return false;
        }
        negative = false;
        for (int i = open; i < count; i++) {
            if (active[i] && !(wanted[i] > 0)) {
                negative = true;
                share = fmin(share, x[i] / (x[i] - wanted[i]));
            }
        }
        for (int i = 0; i < count; i++) {
            x[i] += share * (wanted[i] - x[i]);
            active[i] = active[i] && (i < open || !negative || x[i] > 1e-14 * fabs(wanted[i]));
            x[i] = active[i] ? x[i] : 0;
        }
    }
    return true;
}

bool solve_complement(int count, int open, const double *matrix, const double *right, double most,
                      double *x)
{
    bool active[COMPLEMENT_MAX] = {false};
    memset(active, true, (size_t)open * sizeof *active);
    memset(x, 0, (size_t)count * sizeof *x);
    for (int round = 0; round < 4 * COMPLEMENT_MAX; round++) {
        int next = -1;
        double largest = most;
        if (!settle(count, open, active, matrix, right, x)) {
            return false;
        }
        for (int i = open; i < count; i++) {
            double left = right[i];
            for (int j = 0; j < count; j++) {
                left -= matrix[i * count + j] * x[j];
            }
            if (!active[i] && left > largest) {
                next = i;
                largest = left;
            }
        }
        if (next < 0) {
            return true;
        }
        active[next] = true;
    }
    return false;
}

void solve_complement_fit(int rows, int count, int open, int apart, const double *columns,
                          double *x)
{
    static const double most = 1e-13; /* of the derivative of the squares by a number that is 0 */
    double normal[COMPLEMENT_MAX * COMPLEMENT_MAX], right[COMPLEMENT_MAX], found[COMPLEMENT_MAX];
    for (int a = 0; a < count; a++) {
        right[a] = 0;
        for (int b = 0; b <= count; b++) {
            double sum = a == b ? 1e-12 : 0;
            for (int k = 0; k < rows; k++) {
                sum += columns[(a * rows + k) * apart] * columns[(b * rows + k) * apart];
            }
            right[a] += b < count ? sum * x[b] : -sum;
            if (b < count) {
                normal[a * count + b] = sum;
            }
        }
    }
    if (solve_complement(count, open, normal, right, most, found)) {
        memcpy(x, found, (size_t)count * sizeof *x);
    }
}
