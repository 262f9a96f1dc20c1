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

void json_add(json *to, const char *text, size_t size)
{
    const size_t around = strlen("{}\n");
    if (size > around && begin(to, NULL)) {
        fwrite(text + 1, 1, size - around, to->file);
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

void json_bytes(json *to, const char *name, const void *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *from = bytes;
    if (!begin(to, name)) {
        return;
    }
    fputc('"', to->file);
    for (size_t i = 0; i < size; i += 3) {
        unsigned long three = 0;
        char four[4];
        for (size_t k = 0; k < 3; k++) {
            three = three << 8 | (i + k < size ? from[i + k] : 0u);
        }
        for (size_t k = 0; k < 4; k++) {
            four[k] = i + k > size ? '=' : digits[three >> (18 - 6 * k) & 63];
        }
        fwrite(four, 1, 4, to->file);
    }
    fputc('"', to->file);
}

/* ---- the whole ----------------------------------------------------------------------------- */

void json_begin(json *to)
{
    *to = (json){.file = NULL};
    to->file = open_memstream(&to->text, &to->size);
    json_open(to, NULL, '{');
}

ad_status json_take(json *to, char **text, size_t *size, ad_error *error)
{
    json_close(to, '}');
    if (to->file) {
        fputc('\n', to->file);
    }
    ad_status status = to->file && fclose(to->file) == 0
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for JSON");
    *text = to->text;
    *size = to->size;
    *to = (json){.file = NULL};
    return status;
}

bool json_is_printed(const char *path)
{
    return path && strcmp(path, "-") == 0;
}

ad_status json_check_path(const char *path, ad_error *error)
{
    return path && !json_is_printed(path) ? file_bytes_check(path, error) : AD_OK;
}

ad_status json_end(json *to, const char *path, ad_error *error)
{
    char *text;
    size_t size;
    ad_status status = json_take(to, &text, &size, error);
    if (status == AD_OK && json_is_printed(path)) {
        fputs(text, stdout); /* a program says when it ends that this could not be written */
    } else if (status == AD_OK) {
        status = file_bytes_write(path, text, size, error);
    }
    free(text);
    return status;
}
