/* What a family is made of: a scene with open parameters, its solver of members, and whatever says
 * what members look like. */
#ifndef TOOLS_LIBRARY_TRAINED_FAMILY_H
#define TOOLS_LIBRARY_TRAINED_FAMILY_H

#include "autodiff/memory.h"
#include "tools/config/config.h"
#include "tools/library/cpinn.h"
#include "tools/train/experiment.h"

/* A network, whatever its kind: curvature of members in any number, or their values too. */
typedef struct cpinn_family_network {
    void *context; /* owned by the family */
    /* curvature [members][nodes][width], 1/m, at the solver's places. */
    ad_status (*curvature)(void *context, size_t members, const double *parameters,
                           double *curvature, ad_error *error);
    /* values [members][points][columns] as the network itself has them; NULL: they follow from the
     * curvature. */
    ad_status (*values)(void *context, size_t members, const double *parameters, double *values,
                        ad_error *error);
    /* jacobian [members][points][columns][parameters] of values; NULL as these. */
    ad_status (*jacobian)(void *context, size_t members, const double *parameters, double *jacobian,
                          ad_error *error);
    void (*free)(void *context); /* NULL: nothing is owned */
} cpinn_family_network;

/* A family; its answers are those of family_answers.c. */
struct cpinn_family {
    experiment *owned; /* NULL: the scene is of the file, */
    config *settings;  /* or lent */
    scene open;
    double tolerance; /* of members that are solved */
    int count;        /* of parameters */
    bool extrapolate;
    ad_pool *pool;
    double length;
    size_t points, nodes, numbers, chunk; /* numbers: of a member's curvature */
    double *s, *t;                        /* [points]; t NULL at rest */
    int columns;                          /* without forces */
    bool forces;                          /* are columns, too, */
    size_t more;                          /* so many */
    solve_members *solver;                /* NULL: */
    ad_error why_not;
    bool solves_all; /* without that and a network: solution_create answers, and `tolerance` 0 is
                      * its default */
    cpinn_family_network network;
    struct member_code *code; /* of few members; NULL: */
    ad_error not_compiled;
    double *curvature, *found; /* [chunk][numbers] of members, of some that are solved */
    double *values;            /* [chunk][points][columns] */
    double *parameters;        /* [chunk][count] of members that are solved */
    size_t *which;             /* [chunk] their places */
    solve_answer *refined;     /* [chunk] */
    solve_member *solved;      /* [chunk] */
    /* With forces, else NULL: [chunk][points][more], their derivatives [..][count],
     * and what is said of members of which nobody asks. */
    double *carried, *carried_by;
    cpinn_answer *unasked; /* [chunk] */
    ad_memory memory;
};

/* A family without a network, of a scene that outlives it; then its network. tolerance: 0,
 * CPINN_TOLERANCE. */
ad_status cpinn_family_prepare(const scene *open, double tolerance,
                               const cpinn_family_settings *settings, cpinn_family **result,
                               ad_error *error);

/* As cpinn_family_file, of a scene that was read, and outlives it. */
ad_status cpinn_family_of_scene(const scene *open, double tolerance,
                                const cpinn_family_settings *settings, cpinn_family **result,
                                ad_error *error);
void cpinn_family_attach(cpinn_family *family, const cpinn_family_network *network);

/* Of an experiment that was restored, and outlives it. */
ad_status cpinn_family_of(const experiment *e, const cpinn_family_settings *settings,
                          cpinn_family **result, ad_error *error);

/* Stability margins of members [members][SOLVE_MARGINS], by the solver, and their derivatives, by
 * [members][SOLVE_MARGINS][parameters] or NULL: solve_members_margin. Not numbers where there is no
 * stable equilibrium on that path, or no solver. */
ad_status cpinn_family_margin(cpinn_family *family, size_t members, const double *parameters,
                              double *margin, double *by, ad_error *error);

/* As cpinn_family_evaluate, which is without a jacobian, and as cpinn_family_jacobian, whatever the
 * polish: derivatives, and forces, are of equilibria after two steps. With a jacobian there are
 * answers. */
ad_status cpinn_family_answer(cpinn_family *family, const cpinn_polish *polish, size_t members,
                              const double *parameters, double *values, double *jacobian,
                              cpinn_answer *answers, ad_error *error);

/* The same without forces: rows of `columns` numbers. */
ad_status cpinn_family_shapes(cpinn_family *family, const cpinn_polish *polish, size_t members,
                              const double *parameters, double *values, double *jacobian,
                              cpinn_answer *answers, ad_error *error);

/* Largest distance of two shapes [points][columns], m; infinite: one of them has
 * what is not a number. */
double cpinn_family_distance(const cpinn_family *family, const double *a, const double *b);

/* Numbers that nobody has. */
void cpinn_put_nothing(size_t numbers, double *values);
void cpinn_family_say_nothing(const cpinn_family *family, cpinn_reason reason, double *values,
                              cpinn_answer *answer);

/* Derivatives of motions of members by solution_create, jacobian [members][points][columns]
 * [parameters], by modes (physics/solve/motion_change.h): not numbers where there is no answer, and
 * not trusted where they are estimated to be less exact than these allow. Errors of
 * motion_change_create. */
ad_status cpinn_family_change(const cpinn_family *family, size_t members, const double *parameters,
                              double *jacobian, cpinn_answer *answers, ad_error *error);

/* Of some members those by solution_create whose numbers are which [count]: parameters, values
 * [members][points][columns]; and, where there is a solver of members, curvature
 * [members][numbers] as it takes that, or NULL; of `answers` [members] the reason is kept where
 * the solver has no doubt. AD_NO_MEMORY, AD_NO_BLAS. */
ad_status cpinn_family_solve(const cpinn_family *family, size_t count, const size_t *which,
                             const double *parameters, double *values, double *curvature,
                             cpinn_answer *answers, ad_error *error);

/* The network of the evaluator (physics/learn/evaluator.h) of coordinates s, t and the parameters.
 */
ad_status cpinn_family_fields(const evaluator_model *trained, const cpinn_family *family,
                              cpinn_family_network *result, ad_error *error);

#endif
