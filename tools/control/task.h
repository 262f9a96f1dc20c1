/* The path that a place of the rod is to follow: a circle, a figure eight, set points, rows of a
 * file; and the approach to it from where the place is at the start. */
#ifndef CONTROL_TASK_H
#define CONTROL_TASK_H

#include "tools/control/control_settings.h"

typedef struct task_path task_path;

/* The settings have a centre and a normal where the path needs them. start [3]: where the place is
 * at t = 0, m. AD_BAD_INPUT: the file, with its line; AD_IO, AD_NO_MEMORY. */
ad_status task_path_create(const control_task *task, const double start[3], task_path **result,
                           ad_error *error);
void task_path_free(task_path *path); /* NULL is allowed */

/* Directions [2][3] of the plane of a circle or an eight: across the normal, the first nearest to
 * x in the world, or to y. */
void task_plane(const double normal[3], double across[2][3]);

/* m, for t >= 0. Twice continuously differentiable but for jumps of set points without travel. */
void task_path_at(const task_path *path, double t, double position[3]);

/* s at which set points and rows of a file end; 0: never. */
double task_path_end(const task_path *path);

#endif
