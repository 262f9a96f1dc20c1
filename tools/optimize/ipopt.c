/* IPOPT by its C interface. */
#include "autodiff/dense.h"
#include "tools/optimize/descent.h"
#include "tools/optimize/optimize.h"

#include <math.h>
#include <stdlib.h>

#ifdef CPINN_HAS_IPOPT
#include <IpStdCInterface.h>

#include <stdio.h>
#include <string.h>

/* Gradients of the scaled problem, whose numbers are of the order of 1: far below what a user
 * reads, and above what the solver's tolerance leaves of noise. Ten times that in five steps, one
 * after the other, is enough, too: IPOPT calls it acceptable. */
static const double TOLERANCE = 1e-7, ACCEPTABLE = 1e-6;
enum { ACCEPTABLE_STEPS = 5 };
enum { STEPS_MAX = 300 };

typedef struct run {
    const descent *of;
    int steps;
} run;

static const descent *find(UserDataPtr data, const Number *x, bool *there)
{
    const descent *d = ((const run *)data)->of;
    *there = d->at(d->of, x);
    return d;
}

static Bool value_at(Index n, Number *x, Bool is_new, Number *value, UserDataPtr data)
{
    bool there;
    (void)n, (void)is_new;
    *value = *find(data, x, &there)->value;
    return there;
}

static Bool gradient_at(Index n, Number *x, Bool is_new, Number *gradient, UserDataPtr data)
{
    bool there;
    (void)is_new;
    memcpy(gradient, find(data, x, &there)->gradient, (size_t)n * sizeof *gradient);
    return there;
}

static Bool rows_at(Index n, Number *x, Bool is_new, Index m, Number *row, UserDataPtr data)
{
    bool there;
    (void)n, (void)is_new;
    memcpy(row, find(data, x, &there)->row, (size_t)m * sizeof *row);
    return there;
}

static Bool rows_by_x(Index n, Number *x, Bool is_new, Index m, Index entries, Index *row,
                      Index *column, Number *by, UserDataPtr data)
{
    const descent *d = ((const run *)data)->of;
    bool there;
    (void)n, (void)m, (void)is_new;
    if (!by) {
        memcpy(row, d->row_of, (size_t)entries * sizeof *row);
        memcpy(column, d->column_of, (size_t)entries * sizeof *column);
        return TRUE;
    }
    memcpy(by, find(data, x, &there)->by, (size_t)entries * sizeof *by);
    return there;
}

/* Never asked for: they are those of the steps before, by BFGS with limited memory. Differences of
 * exact gradients instead take half of the steps and four times the members. */
static Bool second_at(Index n, Number *x, Bool is_new, Number factor, Index m, Number *multiplier,
                      Bool new_multiplier, Index entries, Index *row, Index *column, Number *values,
                      UserDataPtr data)
{
    (void)n, (void)x, (void)is_new, (void)factor, (void)m, (void)multiplier, (void)new_multiplier;
    (void)entries, (void)row, (void)column, (void)values, (void)data;
    return FALSE;
}

static Bool count_steps(Index mode, Index steps, Number objective, Number primal, Number dual,
                        Number barrier, Number norm, Number regularisation, Number step_dual,
                        Number step_primal, Index trials, UserDataPtr data)
{
    run *now = data;
    (void)mode, (void)objective, (void)primal, (void)dual, (void)barrier, (void)norm;
    (void)regularisation, (void)step_dual, (void)step_primal, (void)trials;
    now->steps = steps;
    return now->of->why->status == AD_OK;
}

static bool take_text(IpoptProblem problem, const char *name, const char *value)
{
    char names[40], values[40]; /* IPOPT does not promise to leave them as they are */
    snprintf(names, sizeof names, "%s", name);
    snprintf(values, sizeof values, "%s", value);
    return AddIpoptStrOption(problem, names, values);
}

static bool take_number(IpoptProblem problem, const char *name, double value)
{
    char names[40];
    snprintf(names, sizeof names, "%s", name);
    return AddIpoptNumOption(problem, names, value);
}

static bool take_integer(IpoptProblem problem, const char *name, int value)
{
    char names[40];
    snprintf(names, sizeof names, "%s", name);
    return AddIpoptIntOption(problem, names, value);
}

static bool take_options(IpoptProblem problem)
{
    return take_text(problem, "sb", "yes") && take_integer(problem, "print_level", 0) &&
           take_text(problem, "nlp_scaling_method", "none") &&
           take_text(problem, "mu_strategy", "adaptive") &&
           take_number(problem, "bound_relax_factor", 0) && /* no x is moved at the end */
           take_text(problem, "hessian_approximation", "limited-memory") &&
           take_number(problem, "tol", TOLERANCE) &&
           take_number(problem, "acceptable_tol", ACCEPTABLE) &&
           take_number(problem, "acceptable_constr_viol_tol", ACCEPTABLE) &&
           take_integer(problem, "acceptable_iter", ACCEPTABLE_STEPS) &&
           take_integer(problem, "max_iter", STEPS_MAX);
}

ad_status optimize_descent(const descent *of, int *steps, bool *converged, ad_error *error)
{
    const size_t n = of->n, m = of->m;
    double *limits = malloc((2 * n + 2 * m + 1) * sizeof *limits);
    if (!limits) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    double *row_low = limits + 2 * n, *row_high = row_low + m;
    memcpy(limits, of->x_low, n * sizeof *limits);
    memcpy(limits + n, of->x_high, n * sizeof *limits);
    memcpy(row_low, of->row_low, m * sizeof *limits);
    memcpy(row_high, of->row_high, m * sizeof *limits);
    for (size_t i = 0; i < 2 * n + 2 * m; i++) { /* its infinity */
        limits[i] = fmax(-2e19, fmin(2e19, limits[i]));
    }
    ad_dense_kernels(); /* MUMPS has the same OpenBLAS, which gets one thread so */
    IpoptProblem problem = CreateIpoptProblem((Index)n, limits, limits + n, (Index)m, row_low,
                                              row_high, (Index)of->nonzeros, 0, 0, value_at,
                                              rows_at, gradient_at, rows_by_x, second_at);
    free(limits);
    if (!problem) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    ad_status status = AD_OK;
    run now = {.of = of};
    *converged = false;
    if (take_options(problem) && SetIntermediateCallback(problem, count_steps)) {
        const enum ApplicationReturnStatus end =
            IpoptSolve(problem, of->x, NULL, NULL, of->multiplier, NULL, NULL, &now);
        *converged = end == Solve_Succeeded || end == Solved_To_Acceptable_Level;
        if (of->why->status != AD_OK) {
            *error = *of->why;
            status = of->why->status;
        }
    } else {
        status = ad_fail(error, AD_BAD_ARGUMENT, "IPOPT does not take its options");
    }
    *steps = now.steps;
    FreeIpoptProblem(problem);
    return status;
}

bool optimize_has_ipopt(void)
{
    return true;
}

#else

ad_status optimize_descent(const descent *of, int *steps, bool *converged, ad_error *error)
{
    (void)of, (void)steps, (void)converged;
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "built without IPOPT; install coinor-libipopt-dev and build again");
}

bool optimize_has_ipopt(void)
{
    return false;
}

#endif
