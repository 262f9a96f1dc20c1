/* Integrals of what is given along a rod or a beam, taken on panels that are narrow where it is:
 * what collocation has to be as good as, and is measured by. */
#ifndef PHYSICS_LOCAL_QUADRATURE_H
#define PHYSICS_LOCAL_QUADRATURE_H

#include "physics/numerics/gauss.h"
#include "physics/scene/breaks.h"

#include <stddef.h>

enum {
    QUADRATURE_POINTS = GAUSS_STAGES_MAX, /* on a panel */
    QUADRATURE_BATCH = 2 * GAUSS_STAGES_MAX,
    QUADRATURE_ROWS_MAX = 896
};

/* What is given: `rows` numbers out [n][rows] at s [n] in [0, 1], n <= QUADRATURE_BATCH. */
typedef struct solve_given {
    int rows; /* at most QUADRATURE_ROWS_MAX; 0: of what is not integrated
               * the places, edges of panels among them */
    ad_status (*at)(const void *context, size_t n, const double *s, double *out, ad_error *error);
    const void *context;
} solve_given;

typedef struct solve_quadrature {
    gauss_rule rule; /* of every panel, QUADRATURE_POINTS */
    int count;       /* of panels */
    double *edges;   /* [count + 1], from 0 to 1 */
    int place_count;
    double *places;                   /* ascending, within (0, 1): no element may lie across one */
    double size[QUADRATURE_ROWS_MAX]; /* of each row the integral of its absolute value */
    const char *unresolved;           /* as that of scene_panels */
} solve_quadrature;

/* The panels of the scene (physics/scene/breaks.h), halved until the rule on them and on their
 * halves agree to rounding. places [count], ascending: more that elements may not lie across, in
 * place of breaks that are nearly the same. AD_NO_MEMORY, errors of what is given. */
ad_status solve_quadrature_create(const scene *of, const solve_given *given, int count,
                                  const double *places, solve_quadrature **result, ad_error *error);
void solve_quadrature_free(solve_quadrature *quadrature);

/* The panel that s in [0, 1) lies in or begins at. */
int solve_quadrature_panel(const solve_quadrature *quadrature, double s);

/* Halves elements between edges [*elements + 1], of which there may be at most `most`, until the
 * rule of so many stages on them integrates what is given and its first moment as the quadrature
 * does, to a tolerance: by the size of a row, where that is above 1. edges [most + 1]. False in
 * *done: there were not enough. */
ad_status solve_quadrature_divide(const solve_quadrature *quadrature, const solve_given *given,
                                  int stages, double tolerance, int most, int *elements,
                                  double *edges, bool *done, ad_error *error);

#endif
