/* Where what a scene says jumps or has a kink along one coordinate: switching places of formulas
 * (where, step, abs, min, max), joints of segments, points, bodies, springs, ends of actuators.
 * Meshes, windows of time, pieces of networks and their points are aligned with them.
 *
 * Places are found by interval arithmetic on the formulas, which misses none that their own
 * arguments bound, and are exact to rounding. */
#ifndef PHYSICS_SCENE_BREAKS_H
#define PHYSICS_SCENE_BREAKS_H

#include "physics/scene/scene.h"

enum { BREAKS_MAX = 256 };

typedef struct scene_breaks {
    int count;
    double place[BREAKS_MAX]; /* ascending, strictly within the range; m or s */
    /* A formula of both coordinates that switches along a curve, or one with more places than fit:
     * its dotted YAML key, static text; NULL: all places are listed. */
    const char *unresolved;
} scene_breaks;

/* coordinate: "s" or "t". Needs a scene that passes scene_check. AD_NO_MEMORY. */
ad_status scene_breaks_of(const scene *rod_scene, const char *coordinate, scene_breaks *result,
                          ad_error *error);

/* *now: the breaks of the member at values [parameter_count]. *moved_by: the first parameter that
 * moves one of them where it is more by a part of its range, the others as they are; -1: none. So
 * do places that come or go; those that move by less than 1e-8 of the coordinate over the range of
 * the parameter stay. AD_NO_MEMORY. */
ad_status scene_breaks_moved(const scene *family, const char *coordinate, const double *values,
                             double part, scene_breaks *now, int *moved_by, ad_error *error);

/* s over `length`; just before a place where something jumps, as shapes are. */
double scene_breaks_before(const scene_breaks *breaks, double length, double s);

/* Whether a force, a moment, a tension or a pressure that acts at one place is sudden: it jumps at
 * a break of t, or acts at once on a rod that starts unstressed. Waves then have kinks. Needs
 * breaks of "t". */
bool scene_is_sudden(const scene *rod_scene, const scene_breaks *in_time);

/* In how short a time any quantity of the scene changes by its largest size, at its largest rate
 * but for jumps, by samples of panels; a third of that where the rate itself jumps; four times that
 * of what acts all along the rod; s; infinite where all stay as they are. As scene_panels_of. */
ad_status scene_rise_time(const scene *rod_scene, double *rise, ad_error *error);

/* Panels: between two edges no formula jumps, and none does what samples of it do not show: where
 * its slopes, enclosed by interval arithmetic, differ by much more than those at samples, the panel
 * is halved. So what is narrow but smooth lies on narrow panels. */
enum { SCENE_PANELS_MAX = 8192 };

typedef struct scene_panels {
    int count;     /* at most SCENE_PANELS_MAX */
    double *edges; /* [count + 1], ascending, from 0 to the end of the range; m or s */
    /* A formula that has places which are not found, or needs more panels than there may be: its
     * dotted YAML key, static text; NULL: all is seen. */
    const char *unresolved;
} scene_panels;

/* As scene_breaks_of; the result is freed by scene_panels_free. */
ad_status scene_panels_of(const scene *rod_scene, const char *coordinate, scene_panels *result,
                          ad_error *error);
void scene_panels_free(scene_panels *panels); /* not itself */

/* Where a mesh of so many pieces may be divided: the edges between panels, or where there are more
 * panels or these are not found the breaks alone. */
ad_status scene_divisions_of(const scene *rod_scene, const char *coordinate, int most,
                             scene_breaks *result, ad_error *error);

#endif
