/* What the programs report in the same words: verdicts and errors as JSON, and the verdict of a run
 * in its checkpoint.
 *
 * Item of a checkpoint:
 *   verdict   text, a line "REASON: SENTENCE" for each finding, the worst first; "none" without */
#ifndef TOOLS_TRAIN_REPORT_H
#define TOOLS_TRAIN_REPORT_H

#include "physics/scene/verdict.h"
#include "tools/files/checkpoint.h"
#include "tools/files/json.h"
#include "tools/train/fresh_members.h"
#include "tools/train/reference.h"

void report_put_verdict(checkpoint *file, const verdict *v);

/* AD_BAD_INPUT: no verdict is there, or none that this version knows. */
ad_status report_get_verdict(const checkpoint *file, verdict *v, ad_error *error);

/* "verdict": {"outcome": "warning", "reason": "unstable", "text": "...", "exit_status": 3,
 * "findings": [{"reason": "unstable", "outcome": "warning", "text": "..."}, ...]} */
void report_verdict(json *to, const verdict *v);

/* "reference": its name, points, estimated error, and the errors against it; null: `known` is
 * NULL. */
void report_reference(json *to, const reference *known, const reference_errors *errors);

/* "members": errors over the fresh members of a family in the strain form, in m. */
void report_members(json *to, const targets_errors *errors, double length);

/* The same key of a family in mixed form: fresh, median_m, within_95_m, worst_m. */
void report_fresh(json *to, const fresh_errors *members, double length);

#endif
