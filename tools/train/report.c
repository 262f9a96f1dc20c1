#include "tools/train/report.h"

#include <string.h>

/* ---- in a checkpoint ----------------------------------------------------------------------- */

void report_put_verdict(checkpoint *file, const verdict *v)
{
    char text[VERDICT_FINDINGS_MAX * (VERDICT_TEXT + 32)];
    size_t length = 0;
    strcpy(text, verdict_reason_name(VERDICT_NONE));
    for (int i = 0; i < v->count; i++) {
        length +=
            (size_t)snprintf(text + length, sizeof text - length, "%s%s: %s", i > 0 ? "\n" : "",
                             verdict_reason_name(v->findings[i].reason), v->findings[i].text);
    }
    checkpoint_put_text(file, "verdict", text);
}

ad_status report_get_verdict(const checkpoint *file, verdict *v, ad_error *error)
{
    const char *text;
    *v = (verdict){.count = 0};
    ad_status status = checkpoint_get_text(file, "verdict", &text, error);
    while (status == AD_OK && *text) {
        char name[32];
        int length = (int)strcspn(text, "\n"), word = (int)strcspn(text, ":\n");
        int skip = text[word] == ':' ? word + 2 : length;
        snprintf(name, sizeof name, "%.*s", word, text);
        verdict_reason reason = verdict_reason_find(name);
        if (reason == VERDICT_REASON_COUNT || skip > length) {
            return ad_fail(error, AD_BAD_INPUT, "checkpoint: '%s' is not a reason of a verdict",
                           name);
        }
        verdict_add(v, reason, "%.*s", length - skip, text + skip);
        text += length + (text[length] == '\n');
    }
    return status;
}

/* ---- as JSON ------------------------------------------------------------------------------- */

void report_verdict(json *to, const verdict *v)
{
    json_open(to, "verdict", '{');
    json_text(to, "outcome", verdict_outcome_name(verdict_outcome_of(v)));
    json_text(to, "reason", verdict_reason_name(verdict_worst(v)));
    json_text(to, "text", verdict_text(v));
    json_integer(to, "exit_status", verdict_exit_status(v));
    json_open(to, "findings", '[');
    for (int i = 0; i < v->count; i++) {
        verdict_reason reason = v->findings[i].reason;
        json_open(to, NULL, '{');
        json_text(to, "reason", verdict_reason_name(reason));
        json_text(to, "outcome", verdict_outcome_name(verdict_reason_outcome(reason)));
        json_text(to, "text", v->findings[i].text);
        json_close(to, '}');
    }
    json_close(to, ']');
    json_close(to, '}');
}

void report_reference(json *to, const reference *known, const reference_errors *errors)
{
    if (!known) {
        json_null(to, "reference");
        return;
    }
    json_open(to, "reference", '{');
    json_text(to, "name", reference_name(known));
    json_integer(to, "points", (int64_t)reference_points(known));
    json_integer(to, "left_out", (int64_t)reference_left_out(known));
    json_number(to, "estimated_error_over_length", reference_estimates(known).position_max);
    json_number(to, "position_relative_l2", errors->position);
    json_number(to, "position_max_over_length", errors->position_max);
    json_number(to, "tip_over_length", errors->tip);
    json_number(to, "rotation_rms_rad", errors->rotation);
    json_number(to, "rotation_max_rad", errors->rotation_max);
    json_close(to, '}');
}

void report_fresh(json *to, const fresh_errors *members, double length)
{
    json_open(to, "members", '{');
    json_integer(to, "fresh", members->compared);
    json_number(to, "median_m", length * members->median);
    json_number(to, "within_95_m", length * members->most);
    json_number(to, "worst_m", length * members->worst);
    json_close(to, '}');
}

void report_members(json *to, const targets_errors *errors, double length)
{
    json_open(to, "members", '{');
    json_integer(to, "fresh", TARGETS_FRESH);
    json_number(to, "median_m", length * errors->median);
    json_number(to, "within_95_m", length * errors->most);
    json_number(to, "worst_m", length * errors->worst);
    json_number(to, "polished_median_m", length * errors->polished_median);
    json_number(to, "polished_95_m", length * errors->polished_most);
    json_number(to, "polished_worst_m", length * errors->polished_worst);
    json_close(to, '}');
}
