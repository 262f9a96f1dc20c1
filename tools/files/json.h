/* JSON written value by value (RFC 8259) into memory, then to a file as a whole. Commas, quotes and
 * what JSON cannot say are seen to here: numbers that are not finite become null. */
#ifndef TOOLS_FILES_JSON_H
#define TOOLS_FILES_JSON_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef struct json {
    FILE *file; /* in memory; NULL: there is none left, and nothing is kept */
    char *text;
    size_t size;
    bool more; /* a value precedes at this level */
} json;

/* Starts the outermost object. */
void json_begin(json *to);

/* Whether "-" was asked for; and whether json_end can write there, nothing for NULL. */
bool json_is_printed(const char *path);
ad_status json_check_path(const char *path, ad_error *error);

/* Ends it, writes it with a newline to the file `path`, or to standard output where that is "-",
 * and frees what is held. A file that is there is replaced. AD_IO, AD_NO_MEMORY. */
ad_status json_end(json *to, const char *path, ad_error *error);

/* Ends it as a text [size] and a zero, to be freed by the caller, also after AD_NO_MEMORY. */
ad_status json_take(json *to, char **text, size_t *size, ad_error *error);

/* `name`: NULL within an array. */
void json_open(json *to, const char *name, char bracket);     /* '{' or '[' */
void json_close(json *to, char bracket);                      /* '}' or ']' */
void json_text(json *to, const char *name, const char *text); /* NULL: null */
void json_number(json *to, const char *name, double value);
void json_integer(json *to, const char *name, int64_t value);
void json_null(json *to, const char *name);
void json_add(json *to, const char *text, size_t size); /* of an object that json_take has ended */
void json_bytes(json *to, const char *name, const void *bytes, size_t size); /* in base64 */

#endif
