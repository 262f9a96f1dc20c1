/* What the makers of a reference share: reference.c (closed forms, classical solutions, comparison)
 * and reference_file.c. */
#ifndef TOOLS_TRAIN_REFERENCE_INTERNAL_H
#define TOOLS_TRAIN_REFERENCE_INTERNAL_H

#include "tools/train/reference.h"
#include "tools/train/reference_solve.h"

enum { REFERENCE_POSE = 7 }; /* columns at most */

struct reference {
    char name[256];
    double length, duration;
    size_t points, left_out;
    reference_solution about; /* of a classical solution */
    char **files;             /* [members] where they are kept, owned; NULL: nowhere */
    const scene_physics *model;
    size_t pose;                         /* columns: of position, then of rotation */
    bool rotations;                      /* known */
    double *s, *t;                       /* [points] m, s; `s` owns everything up to `part` */
    int members, parameters;             /* of a family; 1 and 0: one scene */
    double *more[SCENE_PARAMETERS_MAX];  /* [parameters][points] */
    double *poses;                       /* [pose][points] */
    double *values;                      /* the same, of the field compared last */
    double *part;                        /* the same, of some of the points */
    field *candidate;                    /* of the experiment's networks */
    int window;                          /* entered */
    size_t first[SCENE_WINDOWS_MAX + 1]; /* points in the order of the windows; of each the first */
};

/* Arrays of that many points, zero. AD_NO_MEMORY. */
ad_status reference_allocate(reference *r, size_t points, ad_error *error);

void reference_put_pose(reference *r, size_t i, const double *position, const double *rotation);

/* Everything from the file that the settings name. */
ad_status reference_read(reference *r, const experiment *e, ad_error *error);

#endif
