/* From a run and the options of cpinn-export to what is exported. */
#ifndef TOOLS_PROGRAMS_EXPORT_OPEN_H
#define TOOLS_PROGRAMS_EXPORT_OPEN_H

#include "tools/emit/export_model.h"

/* `columns`: names, NULL: all; `places`: of families in the strain form, arc lengths in m separated
 * by commas, of which the last is the tip, or NULL. Name and precision are set. AD_BAD_INPUT,
 * AD_BAD_ARGUMENT, AD_NO_MEMORY; free it all the same. */
ad_status export_open(export_model *model, const char *run, const char *columns, const char *places,
                      ad_error *error);

/* Places of an FMU, "0.1,0.25" in m; NULL: the end of the rod. */
ad_status export_read_places(const export_model *model, const char *text,
                             double places[FMU_PLACES_MAX], int *count, ad_error *error);

#endif
