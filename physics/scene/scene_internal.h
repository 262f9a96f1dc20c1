/* What the scene_check files share; not for callers. */
#ifndef PHYSICS_SCENE_SCENE_INTERNAL_H
#define PHYSICS_SCENE_SCENE_INTERNAL_H

#include "physics/scene/scene_field.h"

/* Of the length: places that are closer are one, as they are sums of decimals. */
static const double PLACE_ROUNDING = 1e-9;

/* A quantity per length times growth, which may be not given, or over it (power -1); nothing and
 * infinity stay what they are. */
quantity scene_grown(quantity q, quantity growth, int power);

typedef struct scene_checker {
    const scene *scene;
    const scene_piece *piece; /* at which it looks, and its segment; NULL and -1: the whole */
    int segment;
    const char **key; /* receives the key to blame */
    ad_error *error;
} scene_checker;

/* Write key and sentence, return AD_BAD_INPUT; of a segment the key is its own. */
ad_status scene_refuse(const scene_checker *check, const char *key, const char *sentence);

/* The same of a quantity in the scene. */
ad_status scene_refuse_at(const scene_checker *check, const quantity *q, const char *sentence);

/* Over the piece at which it looks. */
scene_range scene_check_range(const scene_checker *check, quantity q);

typedef ad_status scene_check_part(const scene_checker *check);

/* One part for every piece of the rod in turn. */
ad_status scene_check_pieces(const scene_checker *check, scene_check_part *part);

/* Quantities of the extent, over which the others are sampled, or the others: of a beam what
 * belongs to beams, of a rod what does not (scene_check_quantity.c). */
ad_status scene_check_quantities(const scene_checker *check, bool of_extent);

/* A beam; and that a rod in space has nothing of one (scene_check_beam.c). */
ad_status scene_check_beam(const scene_checker *check);
ad_status scene_check_no_beam(const scene_checker *check);

/* Ends (scene_check_ends.c). */
ad_status scene_check_ends(const scene_checker *check);

/* Section, material, stiffness, inertia, damping (scene_check_rod.c). */
ad_status scene_check_rod(const scene_checker *check);

/* How many entries lists have; the lengths of segments, before anything is sampled along the rod;
 * the rest of segments; and what acts at places of the rod (scene_check_lists.c). */
ad_status scene_check_counts(const scene_checker *check);
ad_status scene_check_extent(const scene_checker *check);
ad_status scene_check_segments(const scene_checker *check);
ad_status scene_check_lists(const scene_checker *check);

/* A range of samples with what lies between them and is narrower, as far as interval arithmetic on
 * some thousand boxes finds it; a little more than the samples have is left out. */
scene_range scene_range_between(quantity q, quantity_interval s, quantity_interval t,
                                scene_range sampled);

#endif
