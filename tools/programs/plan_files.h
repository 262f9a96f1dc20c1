/* A certified way as tables, and the parts of a clearance by name. */
#ifndef TOOLS_PROGRAMS_PLAN_FILES_H
#define TOOLS_PROGRAMS_PLAN_FILES_H

#include "tools/plan/way.h"

enum { PLAN_PARTS = 8 };

double plan_part(const clearance *of, int part);
const char *plan_part_word(int part);   /* "between points" */
const char *plan_part_column(int part); /* "between_points" */

/* A row for each configuration. Errors of table_write. */
ad_status plan_write(const plan_robot *robot, const certificate *of, const char *path,
                     ad_error *error);

/* The shapes of all configurations, in the scene's axes, their number from 0 as t; with the robot's
 * radius and what is left at each point. Errors of shapes_write and of the solver. */
ad_status plan_write_shapes(plan_exact *exact, const environment *environment,
                            const plan_settings *settings, const certificate *of, const char *path,
                            ad_error *error);

#endif
