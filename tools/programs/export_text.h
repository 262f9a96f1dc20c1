/* Texts of C that the build embeds, with what stands for names and types in them. */
#ifndef TOOLS_PROGRAMS_EXPORT_TEXT_H
#define TOOLS_PROGRAMS_EXPORT_TEXT_H

#include <stdio.h>

/* Around the functions of a model: model_functions.c and model_selftest.c. */
extern const char *const export_model_functions[], *const export_model_selftest[];

/* The text with the name in place of "model", and the type of numbers of "model_number". */
void export_put(const char *name, const char *type, const char *text, FILE *file);

/* The same in single precision, with its functions and numbers in place of those of double. */
void export_put_single(const char *name, const char *text, FILE *file);

/* Of all lines, NULL at the end. */
void export_put_lines(const char *name, const char *type, const char *const *lines, FILE *file);

#endif
