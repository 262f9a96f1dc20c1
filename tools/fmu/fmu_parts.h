/* What an FMU is put together from. */
#ifndef TOOLS_FMU_FMU_PARTS_H
#define TOOLS_FMU_FMU_PARTS_H

#include "tools/fmu/fmu.h"

#include <stddef.h>

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

/* A file to be compiled. */
typedef struct fmu_file {
    char name[256];
    const char *text;
    size_t size;
} fmu_file;

/* "x86_64-linux" as the standard names this machine; NULL: it has no name. */
const char *fmu_platform(char text[64]);
const char *fmu_library_ending(void); /* ".so" */

/* Compile the files whose names end in .c, beside which the others lie, to a shared library. The
 * caller owns *bytes [size]; NULL: it could not be made, `note` says why. */
unsigned char *fmu_compile(const fmu_file *files, int count, size_t *size, char note[FMU_NOTE]);

#endif
