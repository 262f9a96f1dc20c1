#include "physics/solve/information.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

enum { MAX = SCENE_PARAMETERS_MAX, SWEEPS = 60 };

/* ---- eigenvalues --------------------------------------------------------------------------- */

/* One rotation of Jacobi's method, which makes a[p][q] vanish (Golub & Van Loan, Matrix
 * Computations, 4th ed., 8.5.2). */
static void rotate(int n, double a[MAX][MAX], double v[MAX][MAX], int p, int q)
{
    const double tau = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    const double t = (tau >= 0 ? 1 : -1) / (fabs(tau) + sqrt(1 + tau * tau));
    const double c = 1 / sqrt(1 + t * t), s = t * c;
    for (int k = 0; k < n; k++) {
        const double x = a[k][p], y = a[k][q];
        a[k][p] = c * x - s * y;
        a[k][q] = s * x + c * y;
    }
    for (int k = 0; k < n; k++) {
        const double x = a[p][k], y = a[q][k];
        a[p][k] = c * x - s * y;
        a[q][k] = s * x + c * y;
        const double left = v[p][k], right = v[q][k];
        v[p][k] = c * left - s * right;
        v[q][k] = s * left + c * right;
    }
}

/* Symmetric a becomes diagonal; rows of v are the eigenvectors. */
static void diagonalize(int n, double a[MAX][MAX], double v[MAX][MAX])
{
    bool rotated = true;
    memset(v, 0, sizeof(double[MAX][MAX]));
    for (int i = 0; i < n; i++) {
        v[i][i] = 1;
    }
    for (int sweep = 0; rotated && sweep < SWEEPS; sweep++) {
        rotated = false;
        for (int p = 0; p < n; p++) {
            for (int q = p + 1; q < n; q++) {
                if (fabs(a[p][q]) > DBL_EPSILON * sqrt(fabs(a[p][p] * a[q][q]))) {
                    rotate(n, a, v, p, q);
                    rotated = true;
                }
            }
        }
    }
}

/* ---- information --------------------------------------------------------------------------- */

/* The covariance of the free unknowns, by eigenvectors; what is not measured at all has the
 * information of rounding. */
static void add_directions(solve_information *information, int n, const int *index,
                           double a[MAX][MAX], double v[MAX][MAX], double covariance[MAX][MAX])
{
    double largest = 0, taken = INFINITY;
    for (int k = 0; k < n; k++) {
        largest = fmax(largest, a[k][k]);
    }
    const double least = fmax(n * DBL_EPSILON * largest, DBL_MIN / DBL_EPSILON);
    for (int k = 0; k < n; k++) {
        a[k][k] = fmax(a[k][k], least);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                covariance[i][j] += v[k][i] * v[k][j] / a[k][k];
            }
        }
    }
    for (;;) { /* the least known first */
        int next = -1;
        for (int k = 0; k < n; k++) {
            if (!isnan(a[k][k]) && (next < 0 || a[k][k] < a[next][next])) {
                next = k;
            }
        }
        taken = next < 0 ? INFINITY : a[next][next];
        if (taken * SOLVE_UNTOLD * SOLVE_UNTOLD >= 1) {
            return;
        }
        a[next][next] = NAN;
        for (int i = 0; i < n; i++) {
            information->direction[information->untold][index[i]] = v[next][i];
        }
        information->untold++;
    }
}

static void find_valley(solve_information *information, int n, const int *index, double a[MAX][MAX])
{
    double scaled[MAX][MAX], v[MAX][MAX], length[MAX], square = 0;
    int least = 0;
    for (int i = 0; i < n; i++) {
        length[i] = a[i][i] > 0 ? sqrt(a[i][i]) : 1;
    }
    for (int i = 0; i < n * n; i++) {
        scaled[i / n][i % n] = a[i / n][i % n] / (length[i / n] * length[i % n]);
    }
    diagonalize(n, scaled, v);
    for (int i = 1; i < n; i++) {
        least = scaled[i][i] < scaled[least][least] ? i : least;
    }
    information->collinearity = n > 0 ? 1 / sqrt(fmax(scaled[least][least], n * DBL_EPSILON)) : 0;
    for (int i = 0; i < n; i++) {
        square += pow(v[least][i] / length[i], 2);
    }
    for (int i = 0; i < n; i++) {
        information->valley[index[i]] = v[least][i] / (length[i] * sqrt(square));
    }
}

solve_information solve_information_of(int count, const double *matrix, const bool *held)
{
    solve_information x = {.count = count};
    double a[MAX][MAX], v[MAX][MAX], covariance[MAX][MAX] = {{0}};
    int index[MAX], n = 0;
    for (int i = 0; i < count; i++) {
        x.deviation[i] = NAN;
        for (int j = 0; j < count; j++) {
            x.correlation[i][j] = NAN;
        }
        if (!held[i]) {
            index[n++] = i;
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            a[i][j] = matrix[index[i] * count + index[j]];
        }
    }
    find_valley(&x, n, index, a);
    diagonalize(n, a, v);
    add_directions(&x, n, index, a, v, covariance);
    for (int i = 0; i < n; i++) {
        x.deviation[index[i]] = sqrt(covariance[i][i]);
        for (int j = 0; j < n; j++) {
            x.correlation[index[i]][index[j]] =
                i == j ? 1 : covariance[i][j] / sqrt(covariance[i][i] * covariance[j][j]);
        }
    }
    return x;
}

/* ---- text ---------------------------------------------------------------------------------- */

/* Relative change of a value by a step of its parameter in parts of the range. */
static double change(const scene_parameter *p, double value, double step, bool *relative)
{
    const double width = p->high - p->low;
    *relative = p->scale == SCENE_LOG || fabs(value) > 1e-3 * width;
    return p->scale == SCENE_LOG ? log(p->high / p->low) * step
           : *relative           ? width * step / value
                                 : step;
}

void solve_information_text(const scene_parameter *const *parameters, int count,
                            const double *values, const double *direction, char *text, size_t size)
{
    static const double SHOWN = 0.1, SMALL = 0.005;
    double largest = 0;
    size_t used = 0;
    bool relative;
    *text = '\0';
    for (int i = 0; i < count; i++) {
        const double by = change(parameters[i], values[i], direction[i], &relative);
        largest = fabs(by) > fabs(largest) ? by : largest;
    }
    for (int i = 0; i < count && used < size; i++) {
        const double step = direction[i] * SHOWN / largest;
        const double by = change(parameters[i], values[i], step, &relative);
        if (fabs(by) < SMALL) {
            continue;
        }
        used += (size_t)snprintf(
            text + used, size - used, relative ? "%s%s %+.2g %%" : "%s%s %+.2g", used ? ", " : "",
            parameters[i]->name,
            relative ? 100 * by : (parameters[i]->high - parameters[i]->low) * step);
    }
}
