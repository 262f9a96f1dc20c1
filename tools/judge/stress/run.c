/* One row in a process of its own. */
#include "tools/judge/child.h"
#include "tools/judge/stress/methods.h"
#include "tools/train/clock.h"

#include <math.h>
#include <string.h>

static const double usual_seconds = 10;
static const double patience_of_limits = 10; /* of wall time, on a busy machine, and */
static const double grace = 30;              /* s for recording, measuring and the solver */

const char *stress_outcome_name(stress_outcome outcome)
{
#define STRESS_NAME(name, text) text,
    static const char *const names[] = {STRESS_OUTCOME_LIST(STRESS_NAME)};
#undef STRESS_NAME
    return names[outcome];
}

const char *stress_method_name(stress_method method)
{
    static const char *const names[STRESS_METHODS] = {"pinn", "solver"};
    return names[method];
}

double stress_limit(const stress_row *row)
{
    return row->seconds > 0 ? row->seconds : usual_seconds;
}

static bool as_expected(const stress_expectation *expected, const stress_result *result)
{
    bool said = !expected->text || strstr(result->text, expected->text);
    return result->outcome == expected->outcome && said;
}

typedef struct order {
    const stress_row *row;
    stress_method method;
    const char *folder;
} order;

static void work(const void *task, void *result)
{
    const order *o = task;
    stress_answer_by(o->method, o->row, o->folder, result);
}

ad_status stress_run(const stress_row *row, stress_method method, const char *folder,
                     stress_result *result, ad_error *error)
{
    child_end end;
    char why[CHILD_WHY];
    const order task = {row, method, folder};
    double began = train_seconds(), patience = patience_of_limits * stress_limit(row) + grace;
    *result = (stress_result){.error = NAN, .seconds = NAN};
    ad_status status = child_run(work, &task, result, sizeof *result, patience, &end, why, error);
    if (status != AD_OK) {
        return status;
    }
    if (end != CHILD_TOLD) {
        result->outcome = end == CHILD_LATE ? STRESS_HUNG : STRESS_CRASHED;
        snprintf(result->text, sizeof result->text, "%s", end == CHILD_LATE ? "" : why);
    }
    if (isnan(result->seconds)) {
        result->seconds = train_seconds() - began;
    }
    result->as_expected = as_expected(&row->expected[method], result);
    return AD_OK;
}
