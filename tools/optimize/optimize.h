/* The best values of parameters of a rod at rest: formulas over its shapes (response.h) are made
 * small or kept, by IPOPT (Waechter and Biegler, Math. Program. 106, 2006) with exact derivatives
 * from several starts.
 *
 *   optimize_create(&settings, &scene, &chosen, key, &error);
 *   ... a solver of members at optimize_places(chosen, &points) ...
 *   optimize_run(chosen, &solver, &report, &error);
 *
 * Variables are fractions z of the ranges of parameters: those that all cases share, then for each
 * case those that are its own. Loads that nobody chooses and that are somewhere in a box multiply
 * the cases: to its corners and its middle come, one after the other, the worst members that random
 * ones of the box show. */
#ifndef TOOLS_OPTIMIZE_OPTIMIZE_H
#define TOOLS_OPTIMIZE_OPTIMIZE_H

#include "physics/scene/verdict.h"
#include "tools/environment/environment.h"
#include "tools/optimize/optimize_settings.h"

/* Who solves members at the places of an optimisation: values [members][points][13] and, where it
 * is not NULL, jacobian [members][points][13][parameters]; whether each is solved [members]. */
typedef struct optimize_solver {
    ad_status (*solve)(void *of, size_t members, const double *parameters, double *values,
                       double *jacobian, bool *solved, ad_error *error);
    /* Their stability margins [members][SOLVE_MARGINS] and derivatives
     * [members][SOLVE_MARGINS][parameters], or NULL, where a formula has them. */
    ad_status (*margin)(void *of, size_t members, const double *parameters, double *margin,
                        double *by, ad_error *error);
    void *of;
} optimize_solver;

typedef struct optimization optimization;

/* A scene with ranges of parameters. The settings are those of its section and, like the scene and
 * the surface around it, NULL if there is none, are borrowed. AD_BAD_INPUT with the key to blame,
 * AD_IO, AD_NO_MEMORY. */
ad_status optimize_create(const optimize_settings *settings, const scene *family,
                          const environment *around, optimization **result, char key[64],
                          ad_error *error);
void optimize_free(optimization *o); /* NULL is allowed */

/* s [points], m, ascending. */
const double *optimize_places(const optimization *o, size_t *points);

/* How one start ended. */
typedef struct optimize_start {
    double objective, violation; /* the latter over the spread of what is bounded */
    int steps;
    bool converged;
} optimize_start;

/* What is known of a constraint at the optimum, of all cases together. */
typedef struct optimize_bound {
    const char *text;
    double low, high;   /* as given; infinite: none */
    double least, most; /* of its values */
    double multiplier;  /* change of the objective for the bound's own, in their units, */
    double weight;      /* and the sum of those of all cases without their signs */
    int active;         /* cases in which it holds with equality */
    bool kept;
} optimize_bound;

typedef struct optimize_report {
    bool found; /* there is a best start that meets all constraints: IPOPT has converged, or several
                 * agree */
    int starts, agreeing, best;
    optimize_start start[OPTIMIZE_STARTS_MAX];
    size_t cases, members; /* cases with those of the box; members solved on the way */
    int rounds;            /* that a box took, */
    bool box_open;         /* and whether the last one still found worse members */
    double objective, violation;
    double left; /* what a descent that has converged may leave of the objective */
    double seconds;
    int bounds;
    optimize_bound bound[OPTIMIZE_CONSTRAINTS_MAX];
} optimize_report;

/* Called after every start; false: stop. */
typedef bool optimize_progress(void *context, const optimize_report *now);

/* The best of all starts, or of as many as it takes until three end at the best; the report says
 * whether there is one. AD_NO_MEMORY; what the solver says;
 * AD_BAD_ARGUMENT: built without IPOPT. */
ad_status optimize_run(optimization *o, const optimize_solver *solver, optimize_progress *progress,
                       void *context, optimize_report *report, ad_error *error);

/* Whether this is built with IPOPT. */
bool optimize_has_ipopt(void);

/* The variables of the optimum, or of where it ended: z [*count]. */
const double *optimize_variables(const optimization *o, size_t *count);

/* Variables, members of the box and scales of another optimisation of the same section, with other
 * points. AD_NO_MEMORY. */
ad_status optimize_take(optimization *o, const optimization *from, ad_error *error);

/* The objective and all constraints with these variables. Of the report objective, violation, cases
 * and bounds are written. A member that is not solved makes the objective NaN. */
ad_status optimize_evaluate(optimization *o, const optimize_solver *solver, optimize_report *report,
                            ad_error *error);

/* Cases and their values, in SI units; of the first [optimize_cases] cases, without a box. */
size_t optimize_cases(const optimization *o);
int optimize_columns(const optimization *o);
const char *optimize_column_name(const optimization *o, int column);
bool optimize_column_is_parameter(const optimization *o, int column);
double optimize_column(const optimization *o, size_t which, int column);
double optimize_parameter(const optimization *o, size_t which, int parameter);
double optimize_case_objective(const optimization *o, size_t which);

/* Says of the first of some cases whose equilibrium is not stable why it is not: members do not see
 * vibrations under loads that follow. */
void optimize_judge_stability(const optimization *of, const scene *family, verdict *to);

/* Who gives a parameter its value. */
typedef enum optimize_role {
    OPTIMIZE_SHARED, /* a variable of all cases */
    OPTIMIZE_EACH,   /* one of each case */
    OPTIMIZE_CASE,   /* a column of the cases */
    OPTIMIZE_BOX
} optimize_role;
optimize_role optimize_role_of(const optimization *o, int parameter);

#endif
