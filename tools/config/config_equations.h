/* Own equations from a YAML file: the sections `equations` and `fit`, for cpinn-fit. Every mistake
 * is one line with its place, as those of a scene (config.h). */
#ifndef TOOLS_CONFIG_CONFIG_EQUATIONS_H
#define TOOLS_CONFIG_CONFIG_EQUATIONS_H

#include "physics/learn/equations.h"

/* Of fit, where nothing else is said. */
#define CONFIG_FIT_TOLERANCE 1e-6
#define CONFIG_FIT_SECONDS   60

typedef struct config_equations {
    equations *equations;
    const physics_model *model; /* of them */
    double tolerance, seconds;  /* fit */
    char name[64];              /* the file's without its ending, unless it is given */
} config_equations;

/* Read `path`, or `text` of that name where it is not NULL, and change it by `count` overrides
 * "key=value", as --set equations.parameters.nu=0.02; null takes a key away. AD_BAD_INPUT, AD_IO,
 * AD_NO_MEMORY; on failure *result is NULL. */
ad_status config_equations_read(const char *path, const char *text, int count,
                                const char *const *overrides, config_equations **result,
                                ad_error *error);
void config_equations_free(config_equations *c); /* NULL is fine */

#endif
