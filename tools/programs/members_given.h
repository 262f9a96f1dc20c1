/* Members of a family as they are given to a program: one on the command line, many in a file. */
#ifndef TOOLS_PROGRAMS_MEMBERS_GIVEN_H
#define TOOLS_PROGRAMS_MEMBERS_GIVEN_H

#include "physics/scene.h"
#include "tools/files/table_file.h"

/* What --at takes, for --help. */
#define MEMBERS_AT_VALUE "NAME=X,..."
#define MEMBERS_AT_HELP  "one member of a family: a value for each of its parameters, in SI units"

/* values [parameter_count] from "tension_1=2,tension_2=0.5", each parameter once, in any order.
 * AD_BAD_ARGUMENT: a scene without parameters, a name that is none of them or that is there twice,
 * what is no finite number, a parameter that is missing. */
ad_status members_at(const scene *family, const char *text, double *values, ad_error *error);

/* parameters [rows of the table][parameter_count] from a table with a column for each parameter and
 * no other; the caller owns both. AD_BAD_INPUT with file and line, errors of table_read. */
ad_status members_read(const scene *family, const char *path, double **parameters,
                       table_file **table, ad_error *error);

#endif
