/* Steps of the strain form with tensions that are sought: beside its matrix, as a border. */
#include "physics/chain/strain_form.h"

#include "autodiff/dense.h"
#include "physics/chain/strain_inline.h"
#include "physics/local/complement.h"

#include <math.h>

/* Of the length: tendons that are longer by this are not too long. */
static const double LONGER = 1e-13;

/* What each tension does to the rod, bent = A^-1 B, and by that and by itself to the lengths.
 * `right` is lost. */
static void bend_by_tensions(strain_form *form)
{
    const size_t size = (size_t)form->tension_at * sizeof(lanes);
    lanes *rows = form->border + form->unknowns;
    for (int k = 0; k < form->tension_count; k++) {
        form->direction[form->tension_at + k] = NO_LANES + 1;
        strain_form_apply(form, form->direction, rows);
        form->direction[form->tension_at + k] = NO_LANES;
        memcpy(form->right, rows, size);
        for (int i = 0; i < form->tension_count; i++) {
            form->shorter[i * form->tension_count + k] = rows[form->tension_at + i];
        }
        strain_form_eliminate(form, true);
        memcpy(form->tensions[k].bent, form->right, size);
        memcpy(form->direction, form->right, size);
        strain_form_apply_lengths(form, form->direction, rows);
        memset(form->direction, 0, size);
        for (int i = 0; i < form->tension_count; i++) {
            form->shorter[i * form->tension_count + k] -= rows[form->tension_at + i];
        }
    }
}

/* How many pivots are negative of those that are taut: each takes away a direction in which the rod
 * would give way, as one of what holds an end. */
static int negative_of(int count, const double *matrix, const double *pull)
{
    double a[COMPLEMENT_MAX * COMPLEMENT_MAX];
    int rows[COMPLEMENT_MAX], n = 0, negative = 0;
    for (int i = 0; i < count; i++) {
        rows[n] = i;
        n += pull[i] > 0;
    }
    for (int i = 0; i < n * n; i++) {
        a[i] = matrix[rows[i / n] * count + rows[i % n]];
    }
    for (int k = 0; k < n; k++) {
        negative += a[k * n + k] < 0;
        for (int i = k + 1; i < n; i++) {
            const double factor = a[i * n + k] / a[k * n + k];
            for (int j = k + 1; j < n; j++) {
                a[i * n + j] -= factor * a[k * n + j];
            }
        }
    }
    return negative;
}

/* The tensions of a lane of the linear model, of which excess [tension_count] are by how much
 * tendons would be too long without; not numbers where there are none. */
static void find_tensions(strain_form *form, int lane, const double *excess, bool again,
                          double *pull)
{
    const int count = form->tension_count;
    double matrix[COMPLEMENT_MAX * COMPLEMENT_MAX];
    for (int i = 0; i < count * count; i++) {
        matrix[i] = form->shorter[i][lane];
    }
    if (!solve_complement(count, 0, matrix, excess, LONGER, pull)) {
        for (int k = 0; k < count; k++) {
            pull[k] = NAN;
        }
    }
    form->negative[lane] -= again ? 0 : negative_of(count, matrix, pull);
}

void strain_form_say_taut(strain_form *form, double least)
{
    const int count = form->tension_count;
    for (int lane = 0; lane < LANES && count > 0; lane++) {
        double *matrix = form->taut + (size_t)lane * (size_t)(count * count);
        int *pivots = form->taut_pivots + lane * count;
        for (int i = 0; i < count; i++) {
            const bool taut = form->tensions[i].pull[lane] > least;
            for (int k = 0; k < count; k++) {
                matrix[k * count + i] = taut ? form->shorter[i * count + k][lane] : i == k;
            }
            form->tensions[i].is_taut[lane] = taut;
        }
        if (ad_dense_lu((size_t)count, matrix, pivots) != 0) {
            pivots[0] = -1;
        }
    }
}

/* The changes of a lane's tensions, of which excess are by how much tendons become too long
 * without: those that are taut keep their tendons as long as they may be. */
static void change_tensions(const strain_form *form, int lane, const double *excess, double *change)
{
    const int count = form->tension_count, *pivots = form->taut_pivots + lane * count;
    const double *factors = form->taut + (size_t)lane * (size_t)(count * count);
    for (int i = 0; i < count; i++) {
        change[i] = form->tensions[i].is_taut[lane] ? -excess[i] : 0;
    }
    if (pivots[0] < 0) {
        change[0] = NAN;
    } else {
        ad_dense_lu_solve((size_t)count, 1, factors, pivots, change);
    }
}

/* The matrix with a border: A du + B dT = right, and lengths. */
static void solve_bordered(strain_form *form, bool again, bool changes)
{
    const int n = form->tension_at, count = form->tension_count;
    const size_t size = (size_t)n * sizeof(lanes);
    lanes missing[COMPLEMENT_MAX], *alone = form->border, *rows = alone + form->unknowns;
    memcpy(missing, form->right + n, (size_t)count * sizeof *missing);
    strain_form_eliminate(form, again);
    memcpy(alone, form->right, size);
    if (!again) {
        bend_by_tensions(form);
    }
    memcpy(form->direction, alone, size);
    strain_form_apply_lengths(form, form->direction, rows);
    memset(form->direction, 0, size);
    for (int k = 0; k < count; k++) { /* too long under no tension at all */
        missing[k] = rows[n + k] - missing[k];
        for (int i = 0; i < count && !changes; i++) {
            missing[k] += form->shorter[k * count + i] * form->tensions[i].pull;
        }
    }
    for (int lane = 0; lane < LANES; lane++) {
        double excess[COMPLEMENT_MAX], pull[COMPLEMENT_MAX];
        for (int k = 0; k < count; k++) {
            excess[k] = missing[k][lane];
        }
        if (changes) {
            change_tensions(form, lane, excess, pull);
        } else {
            find_tensions(form, lane, excess, again, pull);
        }
        for (int k = 0; k < count; k++) {
            form->right[n + k][lane] = changes ? pull[k] : form->tensions[k].pull[lane] - pull[k];
        }
    }
    memcpy(form->right, alone, size);
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < n; i++) {
            form->right[i] -= form->right[n + k] * form->tensions[k].bent[i];
        }
    }
}

static void solve_by(strain_form *form, bool again, bool changes)
{
    if (form->tension_count > 0) {
        solve_bordered(form, again, changes);
    } else {
        strain_form_eliminate(form, again);
    }
}

void strain_form_solve(strain_form *form)
{
    solve_by(form, false, false);
}

void strain_form_solve_again(strain_form *form)
{
    solve_by(form, true, false);
}

void strain_form_solve_change(strain_form *form)
{
    solve_by(form, true, true);
}
