/* Learning the constitutive law of a section (physics/scene/scene_law.h) from measured or computed
 * strains with their forces and moments, by Levenberg-Marquardt on the tape; and its file. */
#ifndef TOOLS_TRAIN_TRAIN_LAW_H
#define TOOLS_TRAIN_TRAIN_LAW_H

#include "physics/scene/scene_law.h"
#include "tools/train/least_squares.h"

#include <stdint.h>

typedef struct train_law_settings {
    scene_symmetry symmetry;
    bool convex;     /* by construction */
    int units;       /* 1 to SCENE_LAW_UNITS_MAX */
    int starts;      /* random initial networks, the best of which is taken; >= 1 */
    int steps;       /* of each at most; >= 1 */
    double held_out; /* share of the rows that are not trained on and choose among all networks on
                      * the way; [0, 0.9]; 0: the last network of the best start */
    uint64_t seed;
    const least_squares_runner *runner; /* NULL: none */
} train_law_settings;

train_law_settings train_law_defaults(void);

/* Rows of strains x = (v - (0, 0, 1), u) of a rod that is straight at rest, with n, m; SI. A strain
 * that is not known is 0 everywhere. */
typedef struct train_law_data {
    size_t rows;
    bool known[SCENE_LAW_STRAINS];
    double *strain[SCENE_LAW_STRAINS], *stress[SCENE_LAW_STRAINS]; /* [rows] */
} train_law_data;

/* From columns v1, v2, v3 (1), u1, u2, u3 (1/m), n1, n2, n3 (N), m1, m2, m3 (N m) of a table
 * (tools/files/table_file.h), as cpinn-solve writes them; a strain may be left out together with
 * its force or moment. AD_BAD_INPUT, errors of the table. The caller frees. */
ad_status train_law_read_data(const char *path, train_law_data *data, ad_error *error);
void train_law_free_data(train_law_data *data);

/* Root mean square of the errors of each n, m by that of its values in the same rows; NaN where
 * there are none or all values are 0. */
typedef struct train_law_report {
    size_t trained, held_out; /* rows */
    double error[SCENE_LAW_STRAINS], held_out_error[SCENE_LAW_STRAINS];
    double linear[SCENE_LAW_STRAINS]; /* the best linear law of one stiffness each, held-out rows;
                                       * all rows if there are none */
    int steps, start;                 /* the network that was taken */
} train_law_report;

/* AD_BAD_INPUT: data that cannot tell; AD_NOT_FINITE: no start came to anything. */
ad_status train_law_fit(const train_law_settings *settings, const train_law_data *data,
                        scene_law *law, train_law_report *report, ad_error *error);

/* A table of two columns, name and value, of scene_law_numbers. */
ad_status train_law_write(const char *path, const scene_law *law, ad_error *error);
ad_status train_law_read(const char *path, scene_law *law, ad_error *error);

#endif
