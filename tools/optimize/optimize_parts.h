/* What the files of tools/optimize share; not for others. */
#ifndef TOOLS_OPTIMIZE_OPTIMIZE_PARTS_H
#define TOOLS_OPTIMIZE_OPTIMIZE_PARTS_H

#include "tools/optimize/optimize.h"
#include "tools/optimize/response.h"

enum { OPTIMIZE_NAMES_MAX = SCENE_PARAMETERS_MAX, OPTIMIZE_KEY_MAX = 64 };

/* ---- cases.c: numbers that differ from case to case -------------------------------------------
 */

/* Columns are parameters of the scene, or names for formulas. Without any there is one case. */
typedef struct optimize_cases_table {
    size_t count;
    int columns;
    char name[OPTIMIZE_NAMES_MAX][64];
    int parameter[OPTIMIZE_NAMES_MAX]; /* its index, or -1 */
    double *values;                    /* [count][columns] */
} optimize_cases_table;

ad_status optimize_read_cases(const optimize_settings *settings, const scene *family,
                              optimize_cases_table *cases, char key[OPTIMIZE_KEY_MAX],
                              ad_error *error);

/* ---- formulas.c -------------------------------------------------------------------------------
 */

/* Points along the rod: s [even + OPTIMIZE_PLACES_MAX], ascending, and which of them the named
 * places are [place_count + 1]; the end is the first. */
ad_status optimize_put_places(const optimize_settings *settings, double length, size_t even,
                              double *s, size_t *points, size_t *place_of,
                              char key[OPTIMIZE_KEY_MAX], ad_error *error);

/* What a scope borrows. */
typedef struct optimize_names {
    const char *parameter[2 * OPTIMIZE_NAMES_MAX], *column[OPTIMIZE_NAMES_MAX];
    const char *place[OPTIMIZE_PLACES_MAX + 1];
    double at[OPTIMIZE_PLACES_MAX + 1];
} optimize_names;

/* Of formulas that know the parameters and these places. */
response_scope optimize_scope(const optimize_settings *settings, const scene *family,
                              const double *s, const size_t *place_of, optimize_names *names);

/* "tip.z >= 0.1", "0.1 <= tip.z <= 0.2", "tip.z = 0.1": the formula, for shapes of that many
 * points, and its bounds. */
ad_status optimize_read_constraint(const char *text, const response_scope *scope, size_t points,
                                   response **of, double *low, double *high, ad_error *error);

/* ---- a problem --------------------------------------------------------------------------------
 */

/* A formula that is bounded. */
typedef struct optimize_constraint {
    response *of;
    double low, high;
    bool by_shared; /* the same in all cases */
    size_t rows;    /* of one case */
    double scale;   /* its rows are multiplied by */
} optimize_constraint;

/* A case, or a member of the box in it. */
typedef struct optimize_scenario {
    size_t of;                      /* the case */
    double box[OPTIMIZE_NAMES_MAX]; /* values of settings->box */
} optimize_scenario;

enum { OPTIMIZE_SCENARIOS_MAX = 1024 };

struct optimization {
    const optimize_settings *settings;
    const scene *family;
    const environment *around;
    int parameters, shared, each; /* numbers of them */
    optimize_role role[OPTIMIZE_NAMES_MAX];
    int index[OPTIMIZE_NAMES_MAX]; /* among those of its role; of a case the column */
    optimize_cases_table cases;
    size_t points, place[OPTIMIZE_PLACES_MAX + 1];
    double *s;
    response *objective;
    double sign, objective_scale; /* -1: it is made large */
    int constraints;
    optimize_constraint constraint[OPTIMIZE_CONSTRAINTS_MAX];
    size_t scenarios;
    optimize_scenario *scenario; /* [OPTIMIZE_SCENARIOS_MAX]; the first are the cases themselves */

    /* The problem of these scenarios. x: shared, those of each case, bounds of objectives. */
    size_t tops;     /* bounds of objectives: none, one, or one for each scenario */
    size_t n, m;     /* variables, rows */
    size_t nonzeros; /* of the derivatives of rows */
    double *x;       /* [n] */
    size_t members;  /* solved */
    const optimize_solver *solver;
    ad_error why; /* of a solver that failed, with its status */

    /* At the x that was evaluated last, `known`: */
    bool known, solved, sloped; /* the last: with derivatives */
    double *at;                 /* [n] */
    double value;               /* the objective, scaled */
    double *gradient;           /* [n] */
    double *row;                /* [m], scaled */
    double *by;                 /* [nonzeros], in the order of rows and of optimize_entries */
    double *multiplier;         /* [m], of the last descent */
    double *given;              /* [scenarios][parameters] */
    double *shapes, *jacobians;
    double *margins, *by_margins; /* [scenarios][SOLVE_MARGINS], and [][][parameters], where a
                                   * formula has them */
    bool *is_solved;
    double *values, *partials; /* of one response */
    double *objectives;        /* [scenarios], not scaled */
};

/* problem.c: sizes, once scenarios are known; keeps x where it fits. */
ad_status optimize_shape(optimization *o, ad_error *error);

/* Values at x, and with derivatives, which take most of the time; false where a member is not
 * solved: its objective and rows are then NaN. The last is what a descent asks (descent.h). */
bool optimize_look(optimization *o, const double *x);
bool optimize_at(void *o, const double *x);

/* The values of parameters that a scenario has with x. */
void optimize_given(const optimization *o, const double *x, size_t scenario, double *parameters);

/* Every row of a constraint: which, of which scenario, and its place among all rows. */
typedef void optimize_visitor(void *context, int constraint, size_t scenario, size_t row);
void optimize_visit(const optimization *o, optimize_visitor *visit, void *context);

/* Descends from o->x, which is where it ends; multipliers. */
ad_status optimize_descend(optimization *o, int *steps, bool *converged, ad_error *error);

#endif
