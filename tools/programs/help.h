/* What the programs print for --help: lines of the files in help/, NULL at the end of each. Options
 * that several programs have are lines "@set" there, which shared.txt explains. */
#ifndef TOOLS_PROGRAMS_HELP_H
#define TOOLS_PROGRAMS_HELP_H

#include <stddef.h>

extern const char *const help_check[];
extern const char *const help_control[];
extern const char *const help_eval[];
extern const char *const help_export[];
extern const char *const help_fit[];
extern const char *const help_law[];
extern const char *const help_plan[];
extern const char *const help_optimize[];
extern const char *const help_residual[];
extern const char *const help_shared[];
extern const char *const help_show[];
extern const char *const help_solve[];
extern const char *const help_train[];

#endif
