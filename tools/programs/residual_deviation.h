/* How well a rod at rest is known with what was learned (residual.file): the numbers of the network
 * and the unknowns that were found with it have a covariance, by which the tip deviates, to first
 * order, with g C g^T; g are exact derivatives of the tip at equilibrium. */
#ifndef TOOLS_PROGRAMS_RESIDUAL_DEVIATION_H
#define TOOLS_PROGRAMS_RESIDUAL_DEVIATION_H

#include "physics/scene/verdict.h"
#include "tools/config/config.h"
#include "tools/files/json.h"
#include "tools/programs/cli.h"

typedef struct residual_deviation {
    bool known;     /* the scene is at rest and has a residual, and members solve it */
    double tip[3];  /* standard deviation of each coordinate, of what was learned, m */
    double noise;   /* of what is measured beside it, in its unit; NaN: not known */
    int beyond;     /* inputs that are beyond what it was trained on, */
    char text[200]; /* the furthest */
} residual_deviation;

/* Of the member `at` of a scene that was read as `settings`. Errors of reading and of members. */
ad_status residual_deviation_find(const config *settings, const char *path,
                                  const cli_list *overrides, const char *at, int threads,
                                  residual_deviation *result, ad_error *error);

/* A finding where inputs are beyond. */
void residual_deviation_judge(const residual_deviation *of, verdict *to);
void residual_deviation_print(const residual_deviation *of);
/* "residual": null where it is not known. */
void residual_deviation_json(const residual_deviation *of, json *to);

#endif
