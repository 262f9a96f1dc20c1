/* What speaks against a closed loop. */
#ifndef TOOLS_PROGRAMS_CONTROL_JUDGE_H
#define TOOLS_PROGRAMS_CONTROL_JUDGE_H

#include "physics/scene/verdict.h"
#include "tools/control/loop.h"
#include "tools/files/json.h"

/* Adds a finding where the residual was followed beyond what it was trained on, in a loop or a
 * recording of that name. */
void control_judge_residual(const residual_reach *reach, const char *of, verdict *to);
void control_residual_json(const residual_reach *reach, json *to); /* or null */

/* Adds findings: it diverged, control->tolerance was not kept, an estimate is off the truth. Of the
 * report diverged, done, rms, worst, reach (NaN: not known), estimate, deviation and truth. */
void control_judge(const control_settings *control, const loop_report *report, verdict *to);

#endif
