/* Run time of the solver against its error, with more and more nodes or strain modes. */
#ifndef TOOLS_PROGRAMS_WORK_PRECISION_H
#define TOOLS_PROGRAMS_WORK_PRECISION_H

#include "physics/solve/solve.h"
#include "tools/programs/samples.h"

/* Writes seconds, error and nodes (modes) by the method of `like` to `path`, a table
 * (tools/files/table_file.h), and prints them if asked to. Errors are those of positions on the
 * grid against the finest solution; values of the grid are overwritten. AD_IO, AD_NO_MEMORY, errors
 * of solution_create. */
ad_status work_precision_write(const scene *scene, const solve_settings *like,
                               const solution *finest, samples *grid, const char *path, bool prints,
                               ad_error *error);

#endif
