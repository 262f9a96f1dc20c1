/* How thick a rod is, for pictures. */
#ifndef TOOLS_PROGRAMS_SECTION_SIZE_H
#define TOOLS_PROGRAMS_SECTION_SIZE_H

#include "physics/scene/scene.h"
#include "tools/files/table_file.h"

/* Half the width along d1, or the height along d2, of the section at s, m; of anything round the
 * radius, of concentric tubes that of the outermost. 0: none is given, or it depends on a
 * parameter that is open. */
double section_half(const scene *of, double s, bool along_d2);

/* Of the ball that stands for a body at s, m: a body has a mass, and no size. It sticks out of the
 * rod, also of a hair, which pictures draw thicker than it is. */
double section_ball(const scene *of, double s);

/* shapes_write of a table with column s, for ParaView (or `always`) with a column radius, half of
 * the larger size of the section. AD_NO_MEMORY, errors of shapes_write. */
ad_status section_write(const char *path, const table_source *table, const scene *of, bool always,
                        ad_error *error);

#endif
