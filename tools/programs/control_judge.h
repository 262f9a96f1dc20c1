/* What speaks against a closed loop. */
#ifndef TOOLS_PROGRAMS_CONTROL_JUDGE_H
#define TOOLS_PROGRAMS_CONTROL_JUDGE_H

#include "physics/scene/verdict.h"
#include "tools/control/loop.h"

/* Adds findings: it diverged, control->tolerance was not kept, an estimate is off the truth. Of the
 * report diverged, done, rms, worst, reach (NaN: not known), estimate, deviation and truth. */
void control_judge(const control_settings *control, const loop_report *report, verdict *to);

#endif
