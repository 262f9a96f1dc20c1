/* The state of a rod in motion at one instant as a table: where another motion of it begins. */
#ifndef TOOLS_PROGRAMS_STATE_FILE_H
#define TOOLS_PROGRAMS_STATE_FILE_H

#include "physics/solve/solve.h"

/* Reads columns s, x to z, qw to qz and, if they are there, vx to vz and w1 to w3, in SI units, of
 * a file of any program here; of several instants, in a column t, the last. *seen [*count] is to be
 * freed. AD_BAD_INPUT in one line: a column is missing, rows do not ascend from 0 to the length. */
ad_status state_file_read(const char *path, double length, solve_seen **seen, size_t *count,
                          ad_error *error);

/* Writes such a file, of a solution at time t; all columns of its model. */
ad_status state_file_write(const char *path, const solution *solved, const scene *rod_scene,
                           double t, ad_error *error);

#endif
