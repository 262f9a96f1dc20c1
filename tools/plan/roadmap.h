/* A roadmap in a file, for many searches: configurations that are free and ways between them. What
 * is certain of it is for one surface and one robot; among others its ways are looked at again,
 * where they are used.
 *
 *   variables   their names and ranges; others are refused
 *   surface, shapes   hashes of what nodes and edges were looked at with
 *   needed      m, of the rod from the surface
 *   nodes       [nodes, variables]
 *   edges       [edges, 2] of nodes */
#ifndef PLAN_ROADMAP_H
#define PLAN_ROADMAP_H

#include "tools/plan/ompl_shim.h"
#include "tools/plan/plan_robot.h"

typedef struct roadmap_settings {
    const char *file; /* read where it is, else made and written */
    size_t nodes;     /* of one that is made */
    uint64_t surface, shapes;
} roadmap_settings;

typedef enum roadmap_source {
    ROADMAP_MADE,
    ROADMAP_KEPT,
    ROADMAP_OTHER_SURFACE, /* kept, and nothing of it is certain */
    ROADMAP_OTHER_SHAPES,
    ROADMAP_NEARER /* it was looked at with less clearance */
} roadmap_source;

typedef struct roadmap {
    roadmap_source source;
    size_t nodes, edges; /* of the file */
    double needed;       /* for which what is known is so */
    ompl_map *map;
} roadmap;

/* how: its ranges, step, seed and what is free; needed: there. AD_BAD_INPUT, naming the file: one
 * that is no roadmap, or of other variables. `failed` is looked at before a file is written: what
 * went wrong in is_free. AD_NOT_WRITTEN, AD_IO, AD_NO_MEMORY. */
ad_status roadmap_open(const roadmap_settings *settings, const plan_robot *robot,
                       const ompl_search *how, double needed, const ad_status *failed,
                       roadmap *result, ad_error *error);
void roadmap_close(roadmap *of); /* not itself */

/* As ompl_find. */
ad_status roadmap_find(roadmap *of, const ompl_search *search, double needed, double **way,
                       size_t *length, size_t *looked, ad_error *error);

#endif
