/* Members of a family as they are given to a program in a file. */
#ifndef TOOLS_PROGRAMS_MEMBERS_GIVEN_H
#define TOOLS_PROGRAMS_MEMBERS_GIVEN_H

#include "physics/scene.h"
#include "tools/files/table_file.h"

/* parameters [rows of the table][parameter_count] from a table with a column for each parameter and
 * no other; the caller owns both. AD_BAD_INPUT with file and line, errors of table_read. */
ad_status members_read(const scene *family, const char *path, double **parameters,
                       table_file **table, ad_error *error);

#endif
