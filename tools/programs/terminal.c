#include "tools/programs/terminal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/ioctl.h>
#include <unistd.h>

/* As setlocale would find it, which would change how all of the program reads numbers. */
static bool speaks_utf8(void)
{
    static const char *const names[] = {"LC_ALL", "LC_CTYPE", "LANG"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const char *value = getenv(names[i]);
        if (value && *value) {
            const char *set = strrchr(value, '.');
            return set && (strncasecmp(set, ".utf-8", 6) == 0 || strncasecmp(set, ".utf8", 5) == 0);
        }
    }
    return false;
}

bool terminal_begin(terminal *t, FILE *file)
{
    const char *kind = getenv("TERM"), *plain = getenv("NO_COLOR"); /* no-color.org */
    t->file = file;
    t->shown = t->columns = t->rows = 0;
    t->utf8 = speaks_utf8();
    t->colours = !plain || !*plain;
    return isatty(fileno(file)) && kind && *kind && strcmp(kind, "dumb") != 0;
}

static void size_of(const terminal *t, int *columns, int *rows)
{
    struct winsize size;
    const bool known =
        ioctl(fileno(t->file), TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0;
    *columns = known ? size.ws_col : 80;
    *rows = known ? size.ws_row : 24;
}

void terminal_room(const terminal *t, int *columns, int *rows)
{
    size_of(t, columns, rows);
    --*columns;
    --*rows;
}

/* All at once, so that no half of a picture is seen or left behind. */
static void put(const terminal *t, const char *text, size_t size)
{
    fflush(t->file);
    for (size_t done = 0; done < size;) {
        const ssize_t now = write(fileno(t->file), text + done, size - done);
        if (now < 0 && errno != EINTR) {
            return; /* what is printed later will say so */
        }
        done += now > 0 ? (size_t)now : 0;
    }
}

/* To the beginning of the picture, or of an empty screen. */
static size_t go_back(terminal *t, char *text)
{
    int columns, rows;
    size_of(t, &columns, &rows);
    const bool changed = t->shown && (columns < t->columns || rows <= t->shown);
    t->columns = columns;
    t->rows = rows;
    return (size_t)(changed    ? sprintf(text, "\033[2J\033[H")
                    : t->shown ? sprintf(text, "\r\033[%dA", t->shown)
                               : sprintf(text, "\r"));
}

void terminal_show(terminal *t, const canvas *picture)
{
    size_t size = go_back(t, t->text);
    for (int row = 0; row < picture->rows; row++) {
        size += canvas_row(picture, row, t->utf8, t->colours, t->text + size);
        size += (size_t)sprintf(t->text + size, "\033[K\n");
    }
    size += (size_t)sprintf(t->text + size, "\033[J");
    t->shown = picture->rows;
    put(t, t->text, size);
}

void terminal_clear(terminal *t)
{
    if (t->shown) {
        size_t size = go_back(t, t->text);
        size += (size_t)sprintf(t->text + size, "\033[J");
        t->shown = 0;
        put(t, t->text, size);
    }
}
