#include "physics/solve/information.h"

#include "autodiff/dense.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

enum { MAX = SCENE_PARAMETERS_MAX };

/* ---- information --------------------------------------------------------------------------- */

/* The covariance of the free unknowns, by eigenvectors; what is not measured at all has the
 * information of rounding. */
static void add_directions(solve_information *information, int n, const int *index, double *a,
                           const double *v, double covariance[MAX][MAX])
{
    double largest = 0, taken = INFINITY;
    for (int k = 0; k < n; k++) {
        largest = fmax(largest, a[k * n + k]);
    }
    const double least = fmax(n * DBL_EPSILON * largest, DBL_MIN / DBL_EPSILON);
    for (int k = 0; k < n; k++) {
        a[k * n + k] = fmax(a[k * n + k], least);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                covariance[i][j] += v[k * n + i] * v[k * n + j] / a[k * n + k];
            }
        }
    }
    for (;;) { /* the least known first */
        int next = -1;
        for (int k = 0; k < n; k++) {
            if (!isnan(a[k * n + k]) && (next < 0 || a[k * n + k] < a[next * n + next])) {
                next = k;
            }
        }
        taken = next < 0 ? INFINITY : a[next * n + next];
        if (taken * SOLVE_UNTOLD * SOLVE_UNTOLD >= 1) {
            return;
        }
        a[next * n + next] = NAN;
        for (int i = 0; i < n; i++) {
            information->direction[information->untold][index[i]] = v[next * n + i];
        }
        information->untold++;
    }
}

static void find_valley(solve_information *information, int n, const int *index, const double *a)
{
    double scaled[MAX * MAX], v[MAX * MAX], length[MAX], square = 0;
    int least = 0;
    for (int i = 0; i < n; i++) {
        length[i] = a[i * n + i] > 0 ? sqrt(a[i * n + i]) : 1;
    }
    for (int i = 0; i < n * n; i++) {
        scaled[i] = a[i] / (length[i / n] * length[i % n]);
    }
    ad_dense_diagonalize((size_t)n, scaled, v);
    for (int i = 1; i < n; i++) {
        least = scaled[i * n + i] < scaled[least * n + least] ? i : least;
    }
    information->collinearity =
        n > 0 ? 1 / sqrt(fmax(scaled[least * n + least], n * DBL_EPSILON)) : 0;
    for (int i = 0; i < n; i++) {
        square += pow(v[least * n + i] / length[i], 2);
    }
    for (int i = 0; i < n; i++) {
        information->valley[index[i]] = v[least * n + i] / (length[i] * sqrt(square));
    }
}

solve_information solve_information_of(int count, const double *matrix, const bool *held)
{
    solve_information x = {.count = count};
    double a[MAX * MAX], v[MAX * MAX], covariance[MAX][MAX] = {{0}};
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
            a[i * n + j] = matrix[index[i] * count + index[j]];
        }
    }
    find_valley(&x, n, index, a);
    ad_dense_diagonalize((size_t)n, a, v);
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
