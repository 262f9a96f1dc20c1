/* The methods of cpinn-stress, and what measures see of their answers. */
#ifndef TOOLS_JUDGE_STRESS_METHODS_H
#define TOOLS_JUDGE_STRESS_METHODS_H

#include "tools/judge/stress/stress.h"

/* All that a row is to its method, in the process at hand: outcome, error, text, and the seconds
 * that the answer took, references and measures left out. */
void stress_answer_by(stress_method method, const stress_row *row, const char *folder,
                      stress_result *result);

double stress_limit(const stress_row *row); /* s, of training */

const scene *stress_scene(const stress_answer *a);
reference_errors stress_errors(const stress_answer *a); /* NaN: the scene names no reference */

/* Values [columns][points] as of field_evaluate; a motion at the instants below, or those of the
 * reference. */
ad_status stress_values(const stress_answer *a, size_t points, const double *s, const double *t,
                        double *values, ad_error *error);

/* From 0 to the duration; zeros of a static scene. */
enum { STRESS_INSTANTS = 201 };
void stress_instants(const scene *rod_scene, double t[STRESS_INSTANTS]);

#endif
