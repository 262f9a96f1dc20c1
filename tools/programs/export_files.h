/* Where exported C goes: OUT of --c and --fmu. */
#ifndef TOOLS_PROGRAMS_EXPORT_FILES_H
#define TOOLS_PROGRAMS_EXPORT_FILES_H

#include "tools/emit/export_compile.h"

#include <stdbool.h>

typedef struct export_out {
    const char *option, *path; /* as given: "--c", OUT */
    const char *ending;        /* NULL: the three of C */
    bool force;
    size_t length;                  /* of the path without its ending */
    char name[EXPORT_NAME_MAX + 1]; /* its last part, an identifier of C */
} export_out;

/* Sets length and name. AD_BAD_ARGUMENT. */
ad_status export_files_name(export_out *to, ad_error *error);

/* Before anything is computed: whether the files can be written. AD_IO. */
ad_status export_files_check(const export_out *to, ad_error *error);

/* Each file is whole or not there; the header, which the others need, comes last. */
ad_status export_files_put(const export_out *to, const export_texts texts, ad_error *error);

/* The path with this ending. */
enum { EXPORT_PATH = 4200 /* more than a system takes */ };
void export_files_path(const export_out *to, const char *ending, char path[EXPORT_PATH]);

#endif
