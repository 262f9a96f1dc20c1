/* IPOPT by its C interface. */
#include "tools/optimize/optimize_parts.h"

#include <math.h>
#include <stdlib.h>

#ifdef CPINN_HAS_IPOPT
#include <IpStdCInterface.h>

#include <stdio.h>
#include <string.h>

/* Gradients of the scaled problem, whose numbers are of the order of 1: far below what a user
 * reads, and above what the solver's tolerance leaves of noise. */
static const double TOLERANCE = 1e-8;
enum { STEPS_MAX = 300 };

static Bool value_at(Index n, Number *x, Bool is_new, Number *value, UserDataPtr data)
{
    optimization *o = data;
    (void)n, (void)is_new;
    const bool there = optimize_at(o, x);
    *value = o->value;
    return there;
}

static Bool gradient_at(Index n, Number *x, Bool is_new, Number *gradient, UserDataPtr data)
{
    optimization *o = data;
    (void)is_new;
    const bool there = optimize_at(o, x);
    memcpy(gradient, o->gradient, (size_t)n * sizeof *gradient);
    return there;
}

static Bool rows_at(Index n, Number *x, Bool is_new, Index m, Number *row, UserDataPtr data)
{
    optimization *o = data;
    (void)n, (void)is_new;
    const bool there = optimize_at(o, x);
    memcpy(row, o->row, (size_t)m * sizeof *row);
    return there;
}

static Bool rows_by_x(Index n, Number *x, Bool is_new, Index m, Index entries, Index *row,
                      Index *column, Number *by, UserDataPtr data)
{
    optimization *o = data;
    (void)n, (void)m, (void)is_new;
    if (!by) {
        optimize_entries(o, row, column);
        return TRUE;
    }
    const bool there = optimize_at(o, x);
    memcpy(by, o->by, (size_t)entries * sizeof *by);
    return there;
}

static Bool second_at(Index n, Number *x, Bool is_new, Number factor, Index m, Number *multiplier,
                      Bool new_multiplier, Index entries, Index *row, Index *column, Number *values,
                      UserDataPtr data)
{
    optimization *o = data;
    (void)n, (void)is_new, (void)m, (void)new_multiplier, (void)entries;
    if (!values) {
        optimize_second_entries(o, row, column);
        return TRUE;
    }
    return optimize_second(o, x, factor, multiplier, values);
}

static Bool count_steps(Index mode, Index steps, Number objective, Number primal, Number dual,
                        Number barrier, Number norm, Number regularisation, Number step_dual,
                        Number step_primal, Index trials, UserDataPtr data)
{
    optimization *o = data;
    (void)mode, (void)objective, (void)primal, (void)dual, (void)barrier, (void)norm;
    (void)regularisation, (void)step_dual, (void)step_primal, (void)trials;
    o->steps = steps;
    return o->why.status == AD_OK;
}

static bool options_of(IpoptProblem problem)
{
    char option[][32] = {"sb",          "nlp_scaling_method", "tol",
                         "print_level", "max_iter",           "mu_strategy"};
    char yes[] = "yes", none[] = "none", adaptive[] = "adaptive";
    return AddIpoptStrOption(problem, option[0], yes) &&
           AddIpoptStrOption(problem, option[1], none) &&
           AddIpoptStrOption(problem, option[5], adaptive) &&
           AddIpoptNumOption(problem, option[2], TOLERANCE) &&
           AddIpoptIntOption(problem, option[3], 0) &&
           AddIpoptIntOption(problem, option[4], STEPS_MAX);
}

ad_status optimize_descend(optimization *o, int *steps, bool *converged, ad_error *error)
{
    const size_t n = o->n, m = o->m;
    double *limits = malloc((2 * n + 2 * m + 1) * sizeof *limits);
    if (!limits) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    double *row_low = limits + 2 * n, *row_high = row_low + m;
    optimize_limits(o, limits, limits + n, row_low, row_high);
    for (size_t i = 0; i < 2 * n + 2 * m; i++) { /* its infinity */
        limits[i] = fmax(-2e19, fmin(2e19, limits[i]));
    }
    IpoptProblem problem = CreateIpoptProblem(
        (Index)n, limits, limits + n, (Index)m, row_low, row_high, (Index)o->nonzeros,
        (Index)optimize_second_count(o), 0, value_at, rows_at, gradient_at, rows_by_x, second_at);
    free(limits);
    if (!problem) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    ad_status status = AD_OK;
    *converged = false;
    o->steps = 0;
    if (options_of(problem) && SetIntermediateCallback(problem, count_steps)) {
        const enum ApplicationReturnStatus end =
            IpoptSolve(problem, o->x, NULL, NULL, o->multiplier, NULL, NULL, o);
        *converged = end == Solve_Succeeded || end == Solved_To_Acceptable_Level;
        if (o->why.status != AD_OK) {
            *error = o->why;
            status = o->why.status;
        }
    } else {
        status = ad_fail(error, AD_BAD_ARGUMENT, "IPOPT does not take its options");
    }
    *steps = o->steps;
    FreeIpoptProblem(problem);
    return status;
}

bool optimize_has_ipopt(void)
{
    return true;
}

#else

ad_status optimize_descend(optimization *o, int *steps, bool *converged, ad_error *error)
{
    (void)o, (void)steps, (void)converged;
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "built without IPOPT; install coinor-libipopt-dev and build again");
}

bool optimize_has_ipopt(void)
{
    return false;
}

#endif
