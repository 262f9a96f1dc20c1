/* What programs print of a solution. */
#ifndef TOOLS_PROGRAMS_SOLUTION_PRINT_H
#define TOOLS_PROGRAMS_SOLUTION_PRINT_H

#include "tools/train/reference.h"

/* Its size and time, estimate, tip and energy, of the scene `of`, to stdout. Errors are those of
 * solution_evaluate and solution_energy. */
ad_status solution_print(const solution *solved, const scene *of, const solve_report *r,
                         double seconds, ad_error *error);

/* Errors, "error against", of what was found against what is known. */
void solution_print_errors(const char *title, const reference *known,
                           const reference_errors *errors);

#endif
