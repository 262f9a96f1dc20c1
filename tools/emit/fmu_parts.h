/* What an FMU is put together from. */
#ifndef TOOLS_EMIT_FMU_PARTS_H
#define TOOLS_EMIT_FMU_PARTS_H

#include "tools/emit/fmu.h"

/* modelDescription.xml and sources/buildDescription.xml. AD_BAD_ARGUMENT: a unit without a name in
 * FMI. */
ad_status fmu_put_description(const fmu_model *model, const char *token, FILE *file,
                              ad_error *error);
void fmu_put_build_description(const fmu_model *model, FILE *file);

/* The index of an input; -1: there is none. */
int fmu_input(const fmu_model *model, const char *name);

/* The files fmi3_... by lines, NULL at the end. */
extern const char *const fmu_text_fmi3_types[], *const fmu_text_fmi3_instance[],
                                                    *const fmu_text_fmi3_functions[];

#endif
