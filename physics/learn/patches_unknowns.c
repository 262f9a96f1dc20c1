/* Numbers that are found from data. */
#include "physics/learn/patches_run.h"

#include "autodiff/dense.h"

#include <math.h>
#include <string.h>

/* The step of the unknowns, and the diagonal of the inverse; false: data do not determine them. */
static bool solve_misfit(const patch_misfit *m, int n, double *step, double *inverse)
{
    double lu[MODEL_UNKNOWNS_MAX * MODEL_UNKNOWNS_MAX];
    double sides[(MODEL_UNKNOWNS_MAX + 1) * MODEL_UNKNOWNS_MAX] = {0};
    int pivots[MODEL_UNKNOWNS_MAX];
    memcpy(lu, m->jtj, (size_t)(n * n) * sizeof *lu);
    for (int i = 0; i < n; i++) {
        sides[i] = -m->jtr[i];
        sides[(1 + i) * n + i] = 1;
    }
    if (ad_dense_lu((size_t)n, lu, pivots) != 0) {
        return false;
    }
    ad_dense_lu_solve((size_t)n, (size_t)n + 1, lu, pivots, sides);
    for (int i = 0; i < n; i++) {
        step[i] = sides[i];
        inverse[i] = sides[(1 + i) * n + i];
    }
    return true;
}

/* What changes of the unknowns do to the fields, relative; the squares are added to varied. */
static double effect(patch_run *r, const double *change, double *varied)
{
    double sums[PATCH_OUTPUTS] = {0};
    for (int f = 0; f < r->problem.outputs; f++) {
        for (int g = 0; g < r->problem.unknowns; g++) {
            sums[f] += change[g] * change[g] * r->slopes[g][f];
        }
        if (varied) {
            varied[f] += sums[f];
        }
    }
    return patch_relative(r, sums);
}

/* Scatter of the data, what the richer basis would find, and what is left to go. */
static ad_status find_deviations(patch_run *r, ad_error *error)
{
    patch_problem *p = &r->problem;
    double left[MODEL_UNKNOWNS_MAX], other[MODEL_UNKNOWNS_MAX], inverse[MODEL_UNKNOWNS_MAX];
    if (!solve_misfit(&r->richer, p->unknowns, other, inverse) ||
        !solve_misfit(&r->misfit, p->unknowns, left, inverse)) {
        return ad_fail(error, AD_BAD_INPUT, "the data do not determine the unknown numbers");
    }
    for (int i = 0; i < p->unknowns; i++) {
        const double rows = (double)r->misfit.rows - p->unknowns;
        const double scatter = sqrt(fabs(inverse[i]) * r->misfit.sum / fmax(1, rows));
        p->deviation[i] = hypot(scatter, hypot(left[i], other[i]));
    }
    effect(r, p->deviation, r->varied);
    return AD_OK;
}

/* Gauss-Newton steps of the unknowns alone (variable projection: Golub & Pereyra, SIAM J. Numer.
 * Anal. 10, 1973), each by a march through all of time. The first ones are coarse. */
ad_status patch_identify(patch_run *r, int attempt, patches_end *end, ad_error *error)
{
    enum { MARCHES = 40 };
    static const double COARSE = 1e-3, SMALLEST = 1e-3;
    patch_problem *p = &r->problem;
    const double wanted = r->local;
    double best = INFINITY, part = 1, from[MODEL_UNKNOWNS_MAX], step[MODEL_UNKNOWNS_MAX] = {0};
    double inverse[MODEL_UNKNOWNS_MAX];
    bool fine = wanted >= COARSE, last = false;
    ad_status status = AD_OK;
    memcpy(from, p->unknown, sizeof from);
    r->local = fine ? wanted : COARSE;
    for (int i = 0; i < MARCHES; i++) {
        status = patch_march(r, attempt, end, error);
        const bool whole = status == AD_OK && *end == PATCHES_CONVERGED;
        if ((status != AD_OK && status != AD_NOT_FINITE) || (!whole && isinf(best)) || last ||
            *end == PATCHES_STOPPED || *end == PATCHES_TIME_OVER) {
            break;
        }
        if (!whole || r->misfit.sum > best * (1 + 1e-6)) { /* less far */
            part /= 2;
            last = part < SMALLEST;
        } else {
            if (!solve_misfit(&r->misfit, p->unknowns, step, inverse)) {
                return ad_fail(error, AD_BAD_INPUT,
                               "the data do not determine the unknown numbers");
            }
            const double size = effect(r, step, NULL);
            if (fine && size <= fmax(1e-14, 0.02 * r->local)) {
                break;
            }
            memcpy(from, p->unknown, sizeof from);
            best = r->misfit.sum;
            part = 1;
            if (!fine && size <= 10 * COARSE) {
                fine = true;
                r->local = wanted;
                best = INFINITY;
            }
        }
        for (int g = 0; g < p->unknowns; g++) {
            p->unknown[g] = from[g] + (last ? 0 : part * step[g]);
        }
    }
    r->local = wanted;
    return status == AD_OK && r->result->count > 0 ? find_deviations(r, error) : status;
}
