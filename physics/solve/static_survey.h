/* How much there is along a rod at rest, in a few numbers: what a path to the loads has to follow.
 */
#ifndef PHYSICS_SOLVE_STATIC_SURVEY_H
#define PHYSICS_SOLVE_STATIC_SURVEY_H

#include "physics/local/rod_model.h"

/* Largest values at samples; where what is given needs more than one panel to be seen, integrals of
 * distributed loads, as if they acted at one place, and the angle by which the rest shape turns. */
typedef struct static_survey {
    bool straight, round;  /* at rest; with equal stiffness about d1 and d2 */
    double force, moment;  /* as at one place */
    double spread, couple; /* per length */
    double curvature;      /* of the rest shape */
    double softness[3]; /* how much more what bends with the power 0, 1, 2 of a lever does than it
                         * does to a rod of the scales' stiffness: 1 where that does not vary.
                         * Levers reach from an end that nothing holds. */
} static_survey;

ad_status static_survey_of(const solve_rod *rod, static_survey *result, ad_error *error);

#endif
