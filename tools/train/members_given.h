/* Members of a family as they are given in a file, to programs and to training. */
#ifndef TOOLS_TRAIN_MEMBERS_GIVEN_H
#define TOOLS_TRAIN_MEMBERS_GIVEN_H

#include "physics/scene/scene.h"
#include "tools/files/table_file.h"

/* parameters [rows of the table][parameter_count] from a table with a column for each parameter and
 * no other; what plays were before follows from the rows in their order. The caller owns both.
 * AD_BAD_INPUT with file and line, errors of table_read. */
ad_status train_members_read(const scene *family, const char *path, double **parameters,
                             table_file **table, ad_error *error);

/* Whether all of them lie within their ranges. AD_BAD_INPUT with file and line; `or_else`, such as
 * ", or with --extrapolate", ends the message. */
ad_status train_members_check(const scene *family, const char *path, const table_file *table,
                              const double *parameters, const char *or_else, ad_error *error);

#endif
