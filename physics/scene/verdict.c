#include "physics/scene/verdict.h"

#include <string.h>

static const struct {
    const char *word, *help;
    int status;
} outcomes[VERDICT_OUTCOME_COUNT] = {
#define VERDICT_OUTCOME_ROW(name, word, status, help) {word, help, status},
    VERDICT_OUTCOME_LIST(VERDICT_OUTCOME_ROW)
#undef VERDICT_OUTCOME_ROW
};

static const struct {
    const char *word, *help;
    verdict_outcome outcome;
} reasons[VERDICT_REASON_COUNT] = {
#define VERDICT_REASON_ROW(name, word, outcome, help) {word, help, outcome},
    VERDICT_REASON_LIST(VERDICT_REASON_ROW)
#undef VERDICT_REASON_ROW
};

const char *verdict_outcome_name(verdict_outcome outcome)
{
    return outcomes[outcome].word;
}

const char *verdict_reason_name(verdict_reason reason)
{
    return reasons[reason].word;
}

verdict_outcome verdict_reason_outcome(verdict_reason reason)
{
    return reasons[reason].outcome;
}

verdict_reason verdict_reason_find(const char *name)
{
    int reason = 0;
    while (reason < VERDICT_REASON_COUNT && strcmp(reasons[reason].word, name) != 0) {
        reason++;
    }
    return (verdict_reason)reason;
}

/* ---- findings ------------------------------------------------------------------------------ */

/* Index of the first finding that is as mild as `reason` or milder. */
static int place_of(const verdict *v, verdict_reason reason)
{
    int place = 0;
    while (place < v->count && v->findings[place].reason > reason) {
        place++;
    }
    return place;
}

bool verdict_has(const verdict *v, verdict_reason reason)
{
    int place = place_of(v, reason);
    return place < v->count && v->findings[place].reason == reason;
}

void verdict_add(verdict *v, verdict_reason reason, const char *format, ...)
{
    int place = place_of(v, reason);
    if (reason == VERDICT_NONE || place == VERDICT_FINDINGS_MAX || verdict_has(v, reason)) {
        return;
    }
    v->count += v->count < VERDICT_FINDINGS_MAX;
    for (int i = v->count - 1; i > place; i--) {
        v->findings[i] = v->findings[i - 1];
    }
    va_list arguments;
    va_start(arguments, format);
    v->findings[place].reason = reason;
    vsnprintf(v->findings[place].text, VERDICT_TEXT, format, arguments);
    va_end(arguments);
}

void verdict_add_error(verdict *v, const ad_error *error)
{
    verdict_reason reason = error->status == AD_OK             ? VERDICT_NONE
                            : error->status == AD_NOT_FINITE   ? VERDICT_NOT_FINITE
                            : error->status == AD_BAD_INPUT    ? VERDICT_BAD_INPUT
                            : error->status == AD_IO           ? VERDICT_BAD_INPUT
                            : error->status == AD_BAD_ARGUMENT ? VERDICT_NO_METHOD
                                                               : VERDICT_FAILED;
    verdict_add(v, reason, "%s", error->message);
}

verdict_reason verdict_worst(const verdict *v)
{
    return v->count > 0 ? v->findings[0].reason : VERDICT_NONE;
}

const char *verdict_text(const verdict *v)
{
    return v->count > 0 ? v->findings[0].text : "";
}

verdict_outcome verdict_outcome_of(const verdict *v)
{
    return reasons[verdict_worst(v)].outcome;
}

int verdict_exit_status(const verdict *v)
{
    return verdict_worst(v) == VERDICT_SIGNAL && v->signal > 0
               ? 128 + v->signal
               : outcomes[verdict_outcome_of(v)].status;
}

/* ---- text ---------------------------------------------------------------------------------- */

void verdict_print(FILE *file, const char *prefix, const verdict *v)
{
    if (v->count == 0) {
        fprintf(file, "%s%s\n", prefix, outcomes[VERDICT_SOLVED].word);
    }
    for (int i = 0; i < v->count; i++) {
        verdict_reason reason = v->findings[i].reason;
        verdict_outcome outcome = reasons[reason].outcome;
        fprintf(file, "%s%s (%s): %s\n", prefix,
                outcome == VERDICT_SOLVED ? "note" : outcomes[outcome].word, reasons[reason].word,
                v->findings[i].text);
    }
}

void verdict_help(FILE *file)
{
    fprintf(file, "Exit status\n");
    for (int i = 0; i <= VERDICT_REFUSED; i++) {
        fprintf(file, "  %-3d %-24s %s\n", outcomes[i].status, outcomes[i].word, outcomes[i].help);
    }
    fprintf(file, "  %-3s %-24s %s\n", "130", "stopped by Ctrl-C",
            "128 and the number of another signal: 143 of TERM");
    fprintf(file, "\nReasons of warnings, as in the output and in --json\n");
    for (int i = 0; i < VERDICT_REASON_COUNT; i++) {
        if (reasons[i].outcome == VERDICT_WARNING) {
            fprintf(file, "  %-28s %s\n", reasons[i].word, reasons[i].help);
        }
    }
}
