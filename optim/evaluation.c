#include "internal.h"

#include <math.h>
#include <string.h>

const char *optim_status_name(optim_status status)
{
    static const char *const name[OPTIM_STATUS_COUNT] = {
#define OPTIM_STATUS_NAME(code, words, sentence) [code] = words,
        OPTIM_STATUS_LIST(OPTIM_STATUS_NAME)
#undef OPTIM_STATUS_NAME
    };
    return (unsigned)status < OPTIM_STATUS_COUNT ? name[status] : "unknown status";
}

const char *optim_status_text(optim_status status)
{
    static const char *const text[OPTIM_STATUS_COUNT] = {
#define OPTIM_STATUS_TEXT(code, words, sentence) [code] = sentence,
        OPTIM_STATUS_LIST(OPTIM_STATUS_TEXT)
#undef OPTIM_STATUS_TEXT
    };
    return (unsigned)status < OPTIM_STATUS_COUNT ? text[status] : "Unknown status.";
}

optim_status optim_evaluate(const optim_evaluator *evaluator, const double *x, double *value,
                            double *gradient)
{
    *value = NAN; /* an objective that forgets to write it must not pass */
    *evaluator->evaluations += 1;
    const int code = evaluator->objective(evaluator->context, x, value, gradient);
    if (code == OPTIM_OBJECTIVE_NOT_FINITE) {
        return OPTIM_NOT_FINITE;
    }
    if (code != OPTIM_OBJECTIVE_OK) {
        return OPTIM_STOPPED_BY_OBJECTIVE;
    }
    /* The squared norm is NaN or Inf when a component is, and also when squares overflow, which
     * would spoil Adam's second moment and the slopes of a line search. */
    if (!isfinite(*value) || !isfinite(optim_dot(evaluator->count, gradient, gradient))) {
        return OPTIM_NOT_FINITE;
    }
    if (*value < *evaluator->best_value) {
        *evaluator->best_value = *value;
        memcpy(evaluator->best_x, x, evaluator->count * sizeof *x);
    }
    return OPTIM_RUNNING;
}
