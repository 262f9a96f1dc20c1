/* The simulated robot of a closed loop: a reduced rod of its own modes, stepped by short steps of
 * Radau's method, its sensors, and what goes wrong with them. */
#ifndef CONTROL_PLANT_H
#define CONTROL_PLANT_H

#include "physics/numerics/triangle_tree.h"
#include "tools/control/control_settings.h"

typedef struct plant plant;

/* What a robot is to keep away from; all is borrowed. */
typedef struct surroundings {
    const triangle_tree *surface; /* by which the controller goes */
    /* The exact distance of the line from a to b from the surface, m, by which it is judged: 0
     * where it meets the surface, negative beyond. */
    double (*of_line)(const void *context, const double a[3], const double b[3]);
    const void *context;
} surroundings;

/* around: for a constrained clearance, else NULL. of: the scene with the keys of control->changes;
 * nominal: without, whose parameters are the inputs in plant_step. Measurements are those of
 * control. */
ad_status plant_create(const scene *of, const scene *nominal, const control_settings *control,
                       const surroundings *around, plant **result, ad_error *error);
void plant_free(plant *plant); /* NULL is allowed */

/* At rest under inputs [nominal parameters] at t = 0, with noise of this seed. AD_NOT_FINITE: no
 * equilibrium is found. */
ad_status plant_start(plant *plant, const double *inputs, uint64_t seed, ad_error *error);

/* Steps up to this time (s) do not pass over what formulas of t do, however short it is. Before the
 * first step; the scene must outlive the plant. AD_BAD_INPUT: a formula whose changes are not
 * found. */
ad_status plant_divide(plant *plant, double duration, ad_error *error);

/* A time h later, under held inputs. AD_NOT_FINITE: there is no motion any more. */
ad_status plant_step(plant *plant, double h, const double *inputs, ad_error *error);

/* m: the place that follows the path. */
ad_status plant_place(plant *plant, double position[3], ad_error *error);

/* What sensor i says now, with noise: numbers [4 at most], how many in *count. */
ad_status plant_measure(plant *plant, int i, double values[4], int *count, ad_error *error);

/* Whether a measurement is lost at random; one draw each call. */
bool plant_loses(plant *plant, int i);

/* The whole robot now, at PLANT_POINTS places from its start to its end, evenly: position [][3]
 * (m), rotation [][4] and curvature [][3] (1/m) as observations have them. */
enum { PLANT_POINTS = 31 };
ad_status plant_shape(plant *plant, double *position, double *rotation, double *curvature,
                      ad_error *error);
double plant_length(const plant *plant); /* m */

/* The constrained numbers [control->limit_count] now. */
ad_status plant_limited(plant *plant, double *values, ad_error *error);

#endif
