/* A path of equilibria as a file and as text. */
#ifndef TOOLS_PROGRAMS_PATH_FILES_H
#define TOOLS_PROGRAMS_PATH_FILES_H

#include "physics/solve/solve.h"
#include "tools/files/json.h"

/* Writes the points to `path`, a table (tools/files/table_file.h). AD_BAD_ARGUMENT (ending), AD_IO,
 * AD_NO_MEMORY. */
ad_status path_files_write(const solution_path *solutions, const char *path, ad_error *error);

/* One line for each limit point and bifurcation. */
void path_files_print(const solution_path *path, FILE *file);

/* Member "path" of an object; null without a path. */
void path_files_json(const solution_path *solutions, const char *path, json *to);

#endif
