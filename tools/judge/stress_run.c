/* One row of cpinn-stress by one method, against what is expected of it. */
#include "tools/judge/stress.h"

#include <errno.h>
#include <string.h>

static const double usual_seconds = 10;
static const double patience_of_limits = 10; /* of wall time, on a busy machine, and */
static const double grace = 30;              /* s for recording, measuring and the solver */

bool stress_as_expected(const stress_expectation *expected, const verdict *found)
{
    bool said = !expected->text;
    for (int i = 0; i < found->count && !said; i++) {
        said = strstr(found->findings[i].text, expected->text) != NULL;
    }
    return said && verdict_outcome_of(found) == expected->outcome &&
           (expected->reason == VERDICT_NONE || verdict_has(found, expected->reason));
}

/* The files beside the scene. */
static ad_status write_files(const stress_row *row, const char *folder, ad_error *error)
{
    char path[4096];
    if (!row->file && !row->write) {
        return AD_OK;
    }
    snprintf(path, sizeof path, "%s/reference.csv", folder);
    FILE *file = fopen(path, "w");
    if (!file) {
        return ad_fail(error, AD_IO, "%s: %s", path, strerror(errno));
    }
    if (row->file) {
        fputs(row->file, file);
    } else {
        row->write(file);
    }
    return fclose(file) == 0 ? AD_OK
                             : ad_fail(error, AD_NOT_WRITTEN, "%s: %s", path, strerror(errno));
}

ad_status stress_run(const stress_row *row, judge_method method, const char *folder,
                     judge_row *result, ad_error *error)
{
    const stress_expectation *expected = &row->expected[method];
    const char *overrides[STRESS_OVERRIDES_MAX + 1];
    char path[4096];
    double seconds = row->seconds > 0 ? row->seconds : usual_seconds;
    int count = 0;
    for (; count < STRESS_OVERRIDES_MAX && row->overrides[count]; count++) {
        overrides[count] = row->overrides[count];
    }
    if (method == JUDGE_SOLVER && row->solver_override) {
        overrides[count++] = row->solver_override;
    }
    snprintf(path, sizeof path, "%s/scene.yaml", folder);
    const judge_task task = {.path = path,
                             .text = row->scene,
                             .overrides = overrides,
                             .override_count = count,
                             .method = method,
                             .threads = 1,
                             .seconds = seconds,
                             .by_processor = true,
                             .patience = patience_of_limits * seconds + grace,
                             .tolerance = row->tolerance,
                             .measure = row->measure};
    ad_status status = write_files(row, folder, error);
    status = status == AD_OK ? judge_run(&task, result, error) : status;
    if (status != AD_OK) {
        return status;
    }
    const verdict_outcome outcome = verdict_outcome_of(&result->verdict);
    const bool within = expected->bound > 0 && result->error <= expected->bound;
    const bool warns = expected->outcome == VERDICT_WARNING && expected->bound > 0;
    if (!within && (outcome == VERDICT_SOLVED || (warns && outcome == VERDICT_WARNING))) {
        verdict_add(&result->verdict, VERDICT_ERROR_ABOVE_BOUND, "error %.1e, and no warning",
                    result->error);
    }
    return AD_OK;
}
