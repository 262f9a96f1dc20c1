/* Files of C and the `cc` of PATH. */
#ifndef TOOLS_EMIT_EXPORT_COMPILE_H
#define TOOLS_EMIT_EXPORT_COMPILE_H

#include "autodiff/error.h"
#include "tools/emit/export_text.h"

typedef struct export_file {
    char name[256];
    const char *text;
    size_t size;
} export_file;

/* Compiles the files that end in .c, beside which the others lie, by "COMPILER OPTIONS -I FOLDER -o
 * MADE FILES", the compiler from PATH, in a folder of its own, of which nothing stays. *bytes
 * [*size], of the caller, with a 0 behind them: what is made; where it is to `run`, what that
 * prints. AD_IO: there is no compiler, or it refuses, and the first line of what it says;
 * AD_BAD_PROGRAM: what is made fails, and its first line. */
typedef struct export_compiler {
    const char *name, *options, *last; /* behind all files, "-lm"; NULL: nothing */
} export_compiler;

ad_status export_compile(const export_compiler *by, int count, const export_file *files, bool run,
                         char **bytes, size_t *size, ad_error *error);

/* The three texts of what is exported. */
enum { EXPORT_SOURCE, EXPORT_HEADER, EXPORT_SELFTEST, EXPORT_TEXTS, EXPORT_NAME_MAX = 40 };
typedef export_text export_texts[EXPORT_TEXTS];

extern const char *const export_endings[EXPORT_TEXTS]; /* ".c" */

ad_status export_texts_write_all(export_texts texts, export_writer *writer, void *of,
                                 ad_error *error);
void export_texts_free(export_texts texts);

/* What the self-test of NAME prints, of the caller. Errors as export_compile. */
ad_status export_texts_check(const export_texts texts, const char *name, const char *standard,
                             char **said, ad_error *error);

#endif
