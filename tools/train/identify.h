/* Unknown numbers of a scene from measurements by solving it: least squares by Gauss-Newton with
 * damping, the residuals over their noise, derivatives exact where members are solved in batches,
 * else by central differences of solutions; then what the measurements tell of each. */
#ifndef TOOLS_TRAIN_IDENTIFY_H
#define TOOLS_TRAIN_IDENTIFY_H

#include "physics/solve/information.h"
#include "physics/solve/measured.h"
#include "tools/train/least_squares.h"

typedef struct identify_settings {
    double tolerance;     /* of the solutions, as of solve_trials_create */
    int threads;          /* 0: one per processor */
    bool noise_is_scaled; /* the noise is known up to a factor: that which the residuals show is
                           * taken */
    bool settles;         /* the search is one descent from where it starts */
    const least_squares_runner *runner; /* NULL: none; one that leaves: nothing is identified */
} identify_settings;

enum { IDENTIFIED_OTHERS = 5 };

/* Values that suit the measurements as well. */
typedef struct identified_other {
    double value[SCENE_PARAMETERS_MAX], chi_squared;
} identified_other;

typedef struct identified {
    int count; /* of unknowns: the scene's last parameters */
    double value[SCENE_PARAMETERS_MAX];
    double deviation[SCENE_PARAMETERS_MAX]; /* standard, of the value; NaN where it is held */
    bool bounded[SCENE_PARAMETERS_MAX];     /* the value is an end of its range, */
    bool held[SCENE_PARAMETERS_MAX]; /* and what suits better beyond is so by more than chance:
                                      * deviations of others hold for this value */
    solve_information information;
    /* of how chi squared grows by two deviations down and up, the part that it should: 1; NaN: not
     * looked at */
    double growth[SCENE_PARAMETERS_MAX][2];
    int others; /* as good as the values */
    identified_other other[IDENTIFIED_OTHERS];
    double chi_squared;  /* sum of squared residuals, each over its noise */
    double noise_factor; /* by which the noise was scaled, else 1 */
    size_t residuals;    /* numbers that were measured */
    size_t missing;      /* that the files lack */
    size_t experiments;  /* members of the family that they are of */
    bool by_members;     /* solved in batches */
    bool scaled;         /* noise_is_scaled */
    int steps;           /* of Gauss-Newton, of all starts */
    long solutions;      /* of experiments */
    bool converged;
    double reduction; /* of motions by modes: by how much more modes change residuals, rms, over
                       * the noise as it is scaled */
    double held_by_equations; /* of a network: the part of what is known that residuals of the
                               * equations add to the measurements; 0: they are met exactly */
} identified;

/* The search starts where the scene's parameters say, and then elsewhere in the ranges, which is
 * how other values that suit as well are seen. Errors as of solve_trials_create, and AD_BAD_INPUT:
 * fewer measured numbers than unknowns, or no solution anywhere it starts. */
ad_status identify(const scene *open, int sets, const solve_measured *measured,
                   const identify_settings *settings, identified *result, ad_error *error);

/* What speaks against it: values at the ends of their ranges, others that are as good, what the
 * measurements do not tell, deviations that formulas get wrong, residuals that are larger or
 * smaller than their noise, a search that has not ended. */
void identified_verdict(const identified *identified, const scene *open, verdict *result);

/* By how many standard deviations a chi squared of so many degrees of freedom is off, by the normal
 * approximation of Wilson and Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684; up to
 * IDENTIFIED_EXPLAINED the noise explains it. */
static const double IDENTIFIED_EXPLAINED = 4;
double identified_off(double chi_squared, double freedom);

/* AD_BAD_INPUT: fewer measured numbers than unknowns, among which the noise may be. */
ad_status identify_check(int unknowns, size_t numbers, bool noise_is_scaled, ad_error *error);

/* Information and deviations, of count, values, bounds and the factor of the noise, and of what the
 * measurements say of parts of the ranges by the noise as it is stated: matrix [count][count],
 * which is divided by the factor. */
void identified_inform(identified *result, const scene *open, double *matrix);

#endif
