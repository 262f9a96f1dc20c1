/* The classical solution of a scene as its reference, kept between runs.
 *
 * It is kept in $XDG_CACHE_HOME/cpinn, else $HOME/.cache/cpinn (XDG Base Directory Specification),
 * else nowhere, in a file named after a hash of all that it depends on: what the experiment's
 * origin writes of the physics, points and version of the solver. The file is written as a
 * checkpoint is, and so either complete and unchanged or found out:
 *
 *   scene      the text that was hashed; another one, whose hash happens to be the same, is no hit
 *   poses      [columns, points]
 *   estimate   of the error of the position over the size
 *   size       the length, of a beam of small deflection its largest, m
 *   verdict    on the solution, tools/train/report.h
 *
 * FNV-1a is that of the checkpoints: since the text is compared, a hash need not resist more than
 * accidents. */
#ifndef TOOLS_TRAIN_REFERENCE_SOLVE_H
#define TOOLS_TRAIN_REFERENCE_SOLVE_H

#include "physics/scene/verdict.h"
#include "tools/train/experiment.h"

typedef struct reference_solution {
    double estimate;   /* of the error of the position over the size */
    double size;       /* the length, of a beam of small deflection its largest; m */
    verdict verdict;   /* on the solution */
    char account[640]; /* "solved classically, estimated error 2e-11 of the length, 0.2 s" */
    char path[4096];   /* where it is kept; "": nowhere */
    char remark[640];  /* what was wrong with the file in the cache; "": nothing */
} reference_solution;

/* Of the scene, or of a family's member with these values [parameter_count] (NULL: it is none).
 * Poses, the first columns [columns][points] of the scene's model, at s [points] (m) and t [points]
 * (s). Where reference.solve cannot be met they are the best there are. AD_BAD_INPUT, a line that
 * names the key: a scene that no solver takes, a load that cannot be reached, or hardly any digit.
 * AD_NO_MEMORY. A cache that cannot be used is no error. */
ad_status reference_solve(const experiment *e, const double *member, size_t points, const double *s,
                          const double *t, int columns, double *poses, reference_solution *about,
                          ad_error *error);

#endif
