/* The columns of a measured file as the scene calls them: those of the file, or formulas of them
 * ("x=tip_x_mm/1000"). A formula knows the columns of the file by their names, or as c1, c2, ... by
 * their number; i1, the number of the row from 1, of an array of three dimensions the first index,
 * and i2, its second; and of the scene the names that are numbers, and the tables. */
#ifndef TOOLS_TRAIN_MEASURED_COLUMNS_H
#define TOOLS_TRAIN_MEASURED_COLUMNS_H

#include "physics/quantity/quantity.h"
#include "tools/files/table_file.h"

typedef struct measured_columns measured_columns;

/* lines: "name=formula" of each, as of train_data; NULL: none. table and outer (may be NULL) are
 * borrowed. AD_NO_MEMORY. */
ad_status measured_columns_create(const table_file *table, const quantities *outer,
                                  const char *lines, measured_columns **result, ad_error *error);
void measured_columns_free(measured_columns *columns); /* NULL is allowed */

/* Whether a formula says what a name is; whether that or the file does. */
bool measured_columns_say(const measured_columns *columns, const char *name);
bool measured_columns_have(const measured_columns *columns, const char *name);

/* values [table_rows] of that name, NaN where a number is missing; they belong to the columns.
 * AD_BAD_INPUT: there is none; a formula that is none, or a value of it that is not finite; of the
 * file, what is no number. */
ad_status measured_columns_find(measured_columns *columns, const char *name, const double **values,
                                ad_error *error);

/* The same of a formula. */
ad_status measured_columns_compute(measured_columns *columns, const char *formula,
                                   const double **values, ad_error *error);

/* Whether formulas, or lines of them, have the name; NULL: there are none. */
bool measured_columns_name(const char *formulas, const char *name);

/* A name of the lines that is none of `known` [count]; NULL: there is none, else valid until the
 * next call. */
const char *measured_columns_stray(measured_columns *columns, int count, const char *const *known);

#endif
