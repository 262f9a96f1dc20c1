/* check_json FILE: whether it holds one JSON object (RFC 8259) and nothing else; exit status 0
 * or 1. For tests of programs, on machines that need not have a reader of JSON. */
#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static const char *skip_blanks(const char *at)
{
    return at + strspn(at, " \t\r\n");
}

/* Behind what is there, or NULL: it is not valid. */
static const char *skip_text(const char *at)
{
    if (*at++ != '"') {
        return NULL;
    }
    for (; *at != '"'; at++) {
        if ((unsigned char)*at < ' ') {
            return NULL; /* the end too */
        }
        if (*at == '\\' && *++at == 'u') {
            for (int i = 0; i < 4; i++) {
                if (!isxdigit((unsigned char)*++at)) {
                    return NULL;
                }
            }
        } else if (at[-1] == '\\' && (!*at || !strchr("\"\\/bfnrt", *at))) {
            return NULL;
        }
    }
    return at + 1;
}

static const char *skip_digits(const char *at)
{
    const char *end = at + strspn(at, "0123456789");
    return end > at ? end : NULL;
}

static const char *skip_number(const char *at)
{
    at += *at == '-';
    at = *at == '0' ? at + 1 : skip_digits(at);
    if (at && *at == '.') {
        at = skip_digits(at + 1);
    }
    if (at && (*at == 'e' || *at == 'E')) {
        at++;
        at = skip_digits(at + (*at == '-' || *at == '+'));
    }
    return at;
}

static const char *skip_value(const char *at);

static const char *skip_list(const char *at, char close)
{
    at = skip_blanks(at + 1);
    if (*at == close) {
        return at + 1;
    }
    for (;;) {
        if (close == '}') {
            at = skip_text(skip_blanks(at));
            at = at ? skip_blanks(at) : NULL;
            if (!at || *at++ != ':') {
                return NULL;
            }
        }
        at = skip_value(skip_blanks(at));
        at = at ? skip_blanks(at) : NULL;
        if (!at || (*at != ',' && *at != close)) {
            return NULL;
        }
        if (*at++ == close) {
            return at;
        }
    }
}

static const char *skip_value(const char *at)
{
    static const char *const words[] = {"null", "true", "false"};
    for (int i = 0; i < 3; i++) {
        if (strncmp(at, words[i], strlen(words[i])) == 0) {
            return at + strlen(words[i]);
        }
    }
    return *at == '{'   ? skip_list(at, '}')
           : *at == '[' ? skip_list(at, ']')
           : *at == '"' ? skip_text(at)
                        : skip_number(at);
}

int main(int count, char **arguments)
{
    static char text[1 << 20];
    FILE *file = count == 2 ? fopen(arguments[1], "r") : NULL;
    size_t size = file ? fread(text, 1, sizeof text - 1, file) : 0;
    bool whole = file && size > 0 && strlen(text) == size && feof(file);
    if (file) {
        fclose(file);
    }
    const char *end = whole && *text == '{' ? skip_list(text, '}') : NULL;
    return end && *skip_blanks(end) == '\0' ? 0 : 1;
}
