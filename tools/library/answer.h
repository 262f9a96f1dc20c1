/* Whatever answers what shapes are: a network, a solution, a family by its network or by the solver
 * of members. It is asked at points and, of a family, for members; it gives columns of the scene's
 * model in SI units. Of members it has their derivatives by the parameters, too, and says of every
 * shape how far it is off, whether it is to be trusted, and who has found it. */
#ifndef TOOLS_LIBRARY_ANSWER_H
#define TOOLS_LIBRARY_ANSWER_H

#include "physics/solve/solve.h"
#include "tools/library/trained_family.h"

typedef struct answer {
    const struct answer_kind *kind;
    void *of;         /* who answers, or */
    const void *with; /* does so without a change; or his weights or settings; borrowed */
    const scene *scene;
    int columns; /* the first of the scene's model */
} answer;

/* One of the first two is there. */
typedef struct answer_kind {
    /* One shape, values [columns][points] at s and t [points]. */
    ad_status (*at_points)(const answer *a, size_t points, const double *s, const double *t,
                           double *values, ad_error *error);
    /* Members at the points that the answers are made for: values [members][points][columns],
     * unless NULL jacobian [members][points][columns][parameters], said [members]. */
    ad_status (*of_members)(const answer *a, size_t members, const double *parameters,
                            double *values, double *jacobian, cpinn_answer *said, ad_error *error);
    /* NULL: not known. Beside at_points, by [columns][parameters][points]. */
    ad_status (*change_at_points)(const answer *a, size_t points, const double *s, const double *t,
                                  double *by, ad_error *error);
} answer_kind;

/* Of a family the member that the field was told. */
answer answer_of_network(field *trained, const double *weights, const scene *of);
answer answer_of_solution(const solution *solved, const scene *of);
answer answer_of_family(cpinn_family *family, const cpinn_polish *polish);

#endif
