/* What data say of a scene, for programs: unknowns that are found from them, how far the scene is
 * from each file, tables and JSON. */
#ifndef TOOLS_PROGRAMS_UNKNOWNS_H
#define TOOLS_PROGRAMS_UNKNOWNS_H

#include "tools/config/config.h"
#include "tools/files/json.h"
#include "tools/programs/fit_run.h"
#include "tools/train/identify.h"
#include "tools/train/judged.h"

typedef struct unknowns {
    config *settings; /* of the scene with open names; NULL: there are no data, or values of
                       * unknowns are given */
    const scene *open;
    identified found;  /* count 0: nothing is unknown, or the search was stopped */
    judged fit;        /* count 0: not known */
    judged_rows *rows; /* NULL: not wanted */
    double seconds;
    int modes[4];  /* as config_identify has them */
    char at[1600]; /* what was asked for by --at, and the values found */
} unknowns;

/* Reads the scene, and where it has unknowns of which `at` (may be NULL) has no value finds them
 * from its data, as `run` says; where that is stopped nothing is found. Then data are judged, also
 * of a scene without unknowns, with rows where they are wanted. threads: 0 means one per processor.
 * AD_BAD_INPUT, with unknowns and without data too; errors of identify. */
ad_status unknowns_find(const char *scene_file, const cli_list *overrides, const char *at,
                        int threads, bool wants_rows, fit_run *run, unknowns *unknowns,
                        ad_error *error);
void unknowns_free(unknowns *unknowns);

/* The parameters that are neither found nor given by `at`, so that no member is meant. */
bool unknowns_leave_family(const unknowns *unknowns, const char *at);

/* What speaks against what was found, and rows of data that the scene has no solution for. */
void unknowns_verdict(const unknowns *unknowns, verdict *result);

void unknowns_print(const unknowns *unknowns);
/* The residuals to `path`, and shapes of the rod beside it, where rows were wanted; says so unless
 * quiet. Errors of table_write. */
ad_status unknowns_write(const unknowns *unknowns, const char *path, bool quiet, ad_error *error);
/* "identified" and "files": null where there are none. */
void unknowns_json(const unknowns *unknowns, json *to);

#endif
