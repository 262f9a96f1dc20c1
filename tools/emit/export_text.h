/* Texts of C: those that the build embeds, with what stands for names and types in them, and parts
 * that all have. */
#ifndef TOOLS_EMIT_EXPORT_TEXT_H
#define TOOLS_EMIT_EXPORT_TEXT_H

#include "physics/numerics/triangle_tree.h"
#include "physics/scene/scene.h"

#include <stdbool.h>
#include <stdio.h>

/* A text in memory that `file` writes to; bytes [size] are to be freed. False: out of memory. */
typedef struct export_text {
    char *bytes;
    size_t size;
    FILE *file;
} export_text;

bool export_text_open(export_text *text);
bool export_text_close(export_text *text);

/* One of the texts of what is exported; the source, which others need, first. */
typedef ad_status export_writer(void *of, int which, FILE *file, ad_error *error);

/* What a writer makes in place of the text. AD_NO_MEMORY, errors of the writer. */
ad_status export_text_write(export_text *text, int which, export_writer *writer, void *of,
                            ad_error *error);

/* The text with the name in place of "model", and the type of numbers of "model_number"; or all of
 * it in single precision, with its functions and numbers. */
typedef enum export_type { EXPORT_DOUBLE, EXPORT_FLOAT, EXPORT_ALL_FLOAT } export_type;
void export_put(const char *name, export_type type, const char *text, FILE *file);

/* Of all lines, NULL at the end. */
void export_put_lines(const char *name, export_type type, const char *const *lines, FILE *file);

/* The text on one line, with nothing that begins or ends a comment. */
void export_put_comment(const char *text, FILE *file);

/* A number, in double or single precision; "{1, 2, 3}", numbers times `unit`, in double or single
 * precision. */
void export_put_number(double value, bool single, FILE *file);
void export_put_list(size_t count, const double *list, double unit, bool single, FILE *file);

/* "static const triangle_tree NAME = ..;", of NAME_corners and so on. */
void export_put_tree(const triangle_tree *tree, const char *name, FILE *file);

/* "HEAD[rows][columns] = {{..}, {..}};" of list [rows][columns]. */
void export_put_rows(const char *head, size_t rows, size_t columns, const double *list, bool single,
                     FILE *file);

/* "HEAD = {..};", the head as printf has it, of double precision or of integers, one of them where
 * there is none; nothing of a list that is NULL. */
void export_put_array(FILE *file, size_t count, const double *list, const char *head, ...)
    __attribute__((format(printf, 4, 5)));
void export_put_integers(FILE *file, size_t count, const int *list, const char *head, ...)
    __attribute__((format(printf, 4, 5)));

/* "NAME_KINDWORD = index," of an enumeration of so many, the word in capitals. */
void export_put_index(const char *name, const char *kind, const char *word, int index, int count,
                      FILE *file);

/* "const char *const NAME_kind[count] = {"..", ".."};" */
void export_put_names(const char *name, const char *kind, size_t count, const char *const *names,
                      FILE *file);

/* Names, lower and upper ends of the parameters of a family or a loop, "NAME_lower" and so on; the
 * names are those of this kind. */
void export_put_parameters(const char *name, const char *kind, const scene *of, bool single,
                           FILE *file);

/* How NAME.c, NAME.h behind its comment, and NAME_selftest.c by this standard of C begin; and how
 * NAME.h ends. */
void export_begin_source(const char *name, FILE *file);
void export_begin_header(const char *name, FILE *file);
void export_end_header(FILE *file);
void export_begin_selftest(const char *name, const char *standard, FILE *file);

#endif
