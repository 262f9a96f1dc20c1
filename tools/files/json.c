#include "tools/files/json.h"

#include "tools/files/file_bytes.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void put_quoted(FILE *file, const char *text)
{
    fputc('"', file);
    for (; *text; text++) {
        unsigned char byte = (unsigned char)*text;
        if (byte < ' ') {
            fprintf(file, "\\u%04x", byte);
            continue;
        }
        if (byte == '"' || byte == '\\') {
            fputc('\\', file);
        }
        fputc(byte, file);
    }
    fputc('"', file);
}

/* What stands before a value; false: memory has run out. */
static bool begin(json *to, const char *name)
{
    if (!to->file) {
        return false;
    }
    if (to->more) {
        fputs(", ", to->file);
    }
    if (name) {
        put_quoted(to->file, name);
        fputs(": ", to->file);
    }
    to->more = true;
    return true;
}

void json_open(json *to, const char *name, char bracket)
{
    if (begin(to, name)) {
        fputc(bracket, to->file);
    }
    to->more = false;
}

void json_close(json *to, char bracket)
{
    if (to->file) {
        fputc(bracket, to->file);
    }
    to->more = true;
}

void json_null(json *to, const char *name)
{
    if (begin(to, name)) {
        fputs("null", to->file);
    }
}

void json_text(json *to, const char *name, const char *text)
{
    if (!text) {
        json_null(to, name);
    } else if (begin(to, name)) {
        put_quoted(to->file, text);
    }
}

void json_number(json *to, const char *name, double value)
{
    if (!isfinite(value)) {
        json_null(to, name);
    } else if (begin(to, name)) {
        fprintf(to->file, "%.17g", value);
    }
}

void json_integer(json *to, const char *name, int64_t value)
{
    if (begin(to, name)) {
        fprintf(to->file, "%" PRId64, value);
    }
}

/* ---- the whole ----------------------------------------------------------------------------- */

void json_begin(json *to)
{
    *to = (json){.file = NULL};
    to->file = open_memstream(&to->text, &to->size);
    json_open(to, NULL, '{');
}

ad_status json_end(json *to, const char *path, ad_error *error)
{
    json_close(to, '}');
    if (to->file) {
        fputc('\n', to->file);
    }
    bool whole = to->file && fclose(to->file) == 0;
    ad_status status;
    if (!whole) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %s", file_bytes_shown(path));
    } else if (strcmp(path, "-") == 0) {
        fputs(to->text, stdout); /* a program says when it ends that this could not be written */
        status = AD_OK;
    } else {
        status = file_bytes_write(path, to->text, to->size, 1, error);
    }
    free(to->text);
    *to = (json){.file = NULL};
    return status;
}
