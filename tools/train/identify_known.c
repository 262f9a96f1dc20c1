/* What measurements tell of unknowns where the search for them has ended. */
#include "tools/train/identify_search.h"

#include "physics/numerics/vector_size.h"

#include <math.h>
#include <string.h>

/* Another end of the search is another one where it is so many standard deviations away. */
static const double APART = 5;

/* Unknowns close to an end of their range which the residuals push on beyond it go there. */
static void find_bounds(search *search, double *z, bool *bounded)
{
    double zeros[MAX] = {0}, step[MAX];
    identify_multiply(search, NULL);
    const bool solved = least_squares_solve(&search->ls, 0, zeros, step) == 0;
    for (int i = 0; i < search->count; i++) {
        const bool low = z[i] < EDGE && (!solved || z[i] + step[i] <= 0);
        const bool high = z[i] > 1 - EDGE && (!solved || z[i] + step[i] >= 1);
        bounded[i] = low || high;
        z[i] = low ? 0 : high ? 1 : z[i];
    }
}

/* Of values at a bound those that the residuals push beyond it by more than chance. Where they do
 * not, the value may as well be within the range, and what it may be is in all deviations. */
static void find_held(search *search, identified *result)
{
    static const double CHANCE = 2;
    const bool none[MAX] = {false};
    double zeros[MAX] = {0}, step[MAX];
    const solve_information all = solve_information_of(search->count, search->ls.jtj, none);
    const bool solved = least_squares_solve(&search->ls, 0, zeros, step) == 0;
    for (int i = 0; i < search->count; i++) {
        const double deviation = result->noise_factor * all.deviation[i];
        const bool by_chance = solved && fabs(step[i]) <= CHANCE * deviation;
        result->held[i] = result->bounded[i] && !by_chance && !(deviation > SOLVE_UNTOLD);
    }
}

static int at(search *search, const double *z)
{
    return identify_run(search, false, 1, z, search->r, &search->error) == AD_OK
               ? identify_differentiate(search, z)
               : OPTIM_OBJECTIVE_STOP;
}

static void list_others(const search *search, const starts *all, double variance,
                        identified *result)
{
    const descent *best = &all->end[0], *known[DESCENTS] = {best};
    int ends = 1;
    for (int k = 1; k < all->ends; k++) {
        const descent *end = &all->end[k];
        const double limit = fmax(best->chi_squared + AS_GOOD * variance, search->exact);
        bool other = end->converged != 0 && end->chi_squared <= limit;
        for (int i = 0; i < ends && other; i++) {
            double square = 0; /* deviations between the two */
            for (int a = 0; a < search->count * search->count; a++) {
                const int row = a / search->count, column = a % search->count;
                square += search->ls.jtj[a] * (end->z[row] - known[i]->z[row]) *
                          (end->z[column] - known[i]->z[column]);
            }
            other = square > APART * APART * fmax(variance, search->exact / (double)search->n);
        }
        if (other) {
            identify_values(search, end->z, result->other[ends - 1].value);
            result->other[ends - 1].chi_squared = end->chi_squared;
            known[ends++] = end;
        }
    }
    result->others = ends - 1;
}

/* By how much chi squared grows beyond what J says, from residuals r to `moved`, where z moves from
 * one to the other of z and `to`; residuals of experiments that do not count are 0. */
static double grown_beyond(const search *search, const double *r, const double *moved,
                           const double *z, const double *to)
{
    double sum = 0;
    for (size_t row = 0; row < search->n; row++) {
        double linear = r[row];
        for (int i = 0; i < search->count && r[row] != 0; i++) {
            linear += search->j[(size_t)i * search->n + row] * (to[i] - z[i]);
        }
        sum += moved[row] * moved[row] - linear * linear;
    }
    return sum;
}

/* How much chi squared grows where an unknown is off by two deviations, the others as they follow,
 * for 4: where linear formulas hold. Not looked at beyond the ranges. Of many experiments by some.
 */
static ad_status check_deviations(search *search, const double *z, identified *result,
                                  ad_error *error)
{
    static const double MOVED = 2;
    const solve_information *known = &result->information;
    const double variance = result->noise_factor * result->noise_factor;
    const size_t count = (size_t)search->count, every = identify_few(search);
    double trial[2 * MAX * MAX];
    bool within[2 * MAX];
    for (int k = 0; k < 2 * search->count; k++) {
        within[k] = !result->held[k / 2];
        for (int i = 0; i < search->count; i++) {
            const double by = result->held[i] || result->held[k / 2]
                                  ? 0
                                  : MOVED * known->deviation[i] * known->correlation[k / 2][i];
            const double to = z[i] + (k % 2 ? by : -by);
            within[k] = within[k] && to >= 0 && to <= 1;
            trial[k * search->count + i] = fmin(1, fmax(0, to));
        }
    }
    solve_trials_thin(search->trials, every);
    search->all.every = (double)every;
    ad_status status = identify_run(search, false, 1, z, search->r, error);
    status = status == AD_OK ? identify_run(search, false, 2 * count, trial, search->room, error)
                             : status;
    for (size_t k = 0; status == AD_OK && k < 2 * count; k++) {
        const double beyond =
            grown_beyond(search, search->r, search->room + k * search->n, z, trial + k * count);
        const double part = 1 + (double)every * beyond / (variance * MOVED * MOVED);
        const bool counts = within[k] && isfinite(beyond) && result->chi_squared > search->exact;
        result->growth[k / 2][k % 2] = counts ? part : NAN;
    }
    return status;
}

ad_status identify_conclude(search *search, identified *result, ad_error *error)
{
    const starts *all = &search->all;
    const descent *found = &all->end[0];
    double z[MAX];
    memcpy(z, found->z, sizeof z);
    int code = at(search, z);
    if (code == OPTIM_OBJECTIVE_OK) {
        find_bounds(search, z, result->bounded);
        code = at(search, z);
    }
    if (code != OPTIM_OBJECTIVE_OK) {
        return code == OPTIM_OBJECTIVE_STOP
                   ? identify_stopped(search, error)
                   : ad_fail(error, AD_NOT_FINITE,
                             "identification ends where there is no solution next to it");
    }
    int free_unknowns = 0;
    for (int i = 0; i < search->count; i++) {
        free_unknowns += !result->bounded[i];
    }
    identify_multiply(search, NULL);
    identify_values(search, z, result->value);
    result->chi_squared = vector_square(search->n, search->r);
    const double freedom = (double)search->n - free_unknowns;
    result->noise_factor =
        search->noise_is_scaled && freedom > 0 ? sqrt(result->chi_squared / freedom) : 1;
    find_held(search, result);
    list_others(search, all, result->noise_factor * result->noise_factor, result);
    identified_inform(result, search->open, search->ls.jtj);
    for (int i = 0; i < DESCENTS; i++) {
        result->steps += (int)(i < all->ends ? all->end[i].steps : 0);
        result->steps += (int)(i < all->few_ends ? all->few[i].steps : 0);
    }
    result->converged = found->converged != 0;
    return check_deviations(search, z, result, error);
}
