/* What settings_resolve.c and settings_check.c share; not for callers. */
#ifndef TOOLS_TRAIN_SETTINGS_INTERNAL_H
#define TOOLS_TRAIN_SETTINGS_INTERNAL_H

#include "tools/train/train_settings.h"

/* Name `field` in key, and the rest of the line in error; returns AD_BAD_INPUT. */
ad_status train_refuse(char key[TRAIN_KEY_MAX], const char *field, ad_error *error,
                       const char *format, ...) __attribute__((format(printf, 4, 5)));

/* The same for a field of a stage; "" is the stage as a whole. */
ad_status train_refuse_stage(char key[TRAIN_KEY_MAX], int stage, const char *field, ad_error *error,
                             const char *format, ...) __attribute__((format(printf, 5, 6)));

/* Whether the form takes the scene and, where there are any, measured data. */
ad_status train_check_support(const train_settings *settings, const scene *rod_scene,
                              char key[TRAIN_KEY_MAX], ad_error *error);

/* Radians in half of a parameter's range that waves have at most. Measured on a cantilever with a
 * load up to 4 EI/L^2 and a stiffness that differs four times: of 1 to 3 the best, by a factor of
 * ten. */
#define TRAIN_OF_PARAMETER 2.0

/* What the optimiser of a stage leaves open. */
void train_resolve_stage(train_stage *stage, bool diagonal, bool linear);

/* Windows of time of a scene in motion without hidden layers. */
ad_status train_resolve_windows(train_settings *settings, scene *rod_scene, char key[TRAIN_KEY_MAX],
                                ad_error *error);

/* As train_settings_resolve, of one motion in the strain form. */
ad_status train_resolve_motion(train_settings *settings, scene *motion, char key[TRAIN_KEY_MAX],
                               ad_error *error);

ad_status train_check_motion(const train_settings *settings, char key[TRAIN_KEY_MAX],
                             ad_error *error);

/* As train_settings_resolve and train_settings_check, of a family in the strain form. */
ad_status train_resolve_family(train_settings *settings, scene *family, char key[TRAIN_KEY_MAX],
                               ad_error *error);
ad_status train_check_family(const train_settings *settings, const scene *family,
                             char key[TRAIN_KEY_MAX], ad_error *error);

#endif
