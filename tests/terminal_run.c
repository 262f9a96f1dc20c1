/* Runs a program on a terminal of its own, for tests of what it draws.
 *   terminal_run COLUMNSxROWS SCREEN [PICTURES ACTION]... -- PROGRAM ARGUMENTS...
 * An action follows so many pictures (ESC [ J): `int` types Ctrl-C, `term` sends the signal, a size
 * is that of the terminal from then on. SCREEN gets what has left the screen at its top, a line of
 * ----, and the screen. Prints "pictures N"; its exit status is that of the program, or 99 for a
 * control sequence that is not known here, so that nothing is left to be undone, and for a terminal
 * that is not as it was before. */
#define _DEFAULT_SOURCE
#include <errno.h>
#include <pty.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>
#include <utmp.h>

enum { COLUMNS = 400, ROWS = 200 };

static struct {
    uint32_t cells[ROWS][COLUMNS];
    int columns, rows, x, y;
    FILE *log;
    int pictures;
    enum { TEXT, ESCAPE, SEQUENCE } state;
    char escape[32]; /* behind ESC [ */
    size_t escaped;
    uint32_t code; /* of UTF-8, with so many bytes to come */
    int more;
} t;

static void fail(const char *what)
{
    fprintf(stderr, "terminal_run: %s\n", what);
    exit(99);
}

static void print_row(int row)
{
    int end = t.columns;
    while (end > 0 && t.cells[row][end - 1] == ' ') {
        end--;
    }
    for (int i = 0; i < end; i++) {
        const uint32_t code = t.cells[row][i];
        if (code >= 0x800) {
            fputc((int)(0xe0 | code >> 12), t.log);
            fputc((int)(0x80 | (code >> 6 & 0x3f)), t.log);
            fputc((int)(0x80 | (code & 0x3f)), t.log);
        } else {
            fputc((int)code, t.log);
        }
    }
    fputc('\n', t.log);
}

static void blank(int row, int from)
{
    for (int i = from; i < COLUMNS; i++) {
        t.cells[row][i] = ' ';
    }
}

static void scroll(void)
{
    print_row(0);
    memmove(t.cells[0], t.cells[1], (ROWS - 1) * sizeof *t.cells);
    blank(ROWS - 1, 0);
}

static void next_line(void)
{
    if (++t.y == t.rows) {
        scroll();
        t.y--;
    }
}

static void put(uint32_t code)
{
    if (t.x == t.columns) {
        t.x = 0;
        next_line();
    }
    t.cells[t.y][t.x++] = code;
}

static void clear_below(int row, int from)
{
    blank(row, from);
    for (int i = row + 1; i < ROWS; i++) {
        blank(i, 0);
    }
}

/* ESC [ numbers, and a letter. */
static void control(void)
{
    const char last = t.escape[t.escaped - 1];
    const int number = atoi(t.escape);
    if (last == 'A') {
        t.y = t.y > number ? t.y - number : 0;
    } else if (last == 'K' && t.escaped == 1) {
        blank(t.y, t.x);
    } else if (last == 'J' && t.escaped == 1) {
        clear_below(t.y, t.x);
        t.pictures++;
    } else if (last == 'J' && number == 2) {
        clear_below(0, 0);
    } else if (last == 'H' && t.escaped == 1) {
        t.x = t.y = 0;
    } else if (last != 'm') {
        fail("a control sequence that is not known");
    }
}

static void take(unsigned char byte)
{
    if (t.state == ESCAPE) {
        if (byte != '[') {
            fail("a control sequence that is not known");
        }
        t.state = SEQUENCE;
        t.escaped = 0;
    } else if (t.state == SEQUENCE) {
        if (t.escaped + 1 == sizeof t.escape) {
            fail("a control sequence that does not end");
        }
        t.escape[t.escaped++] = (char)byte;
        t.escape[t.escaped] = '\0';
        if (byte >= 0x40) {
            t.state = TEXT;
            control();
        }
    } else if (byte == 033) {
        t.state = ESCAPE;
    } else if (byte == '\r') {
        t.x = 0;
    } else if (byte == '\n') { /* the terminal has put a \r before it */
        next_line();
    } else if (byte < ' ') {
        fail("a control character that is not known");
    } else if (byte >= 0xc0) {
        t.more = byte >= 0xe0 ? 2 : 1;
        t.code = byte & (byte >= 0xe0 ? 0x0f : 0x1f);
    } else if (byte >= 0x80) {
        t.code = t.code << 6 | (byte & 0x3f);
        if (--t.more == 0) {
            put(t.code);
        }
    } else {
        put(byte);
    }
}

/* ---- the program --------------------------------------------------------------------------- */

static struct winsize size_of(const char *text)
{
    int columns, rows;
    if (sscanf(text, "%dx%d", &columns, &rows) != 2 || columns < 1 || rows < 1 ||
        columns > COLUMNS || rows > ROWS) {
        fail("COLUMNSxROWS");
    }
    t.columns = columns;
    t.rows = rows;
    return (struct winsize){.ws_col = (unsigned short)columns, .ws_row = (unsigned short)rows};
}

static void act(const char *action, int terminal, pid_t child)
{
    if (strcmp(action, "int") == 0) {
        if (write(terminal, "\003", 1) != 1) {
            fail("Ctrl-C cannot be typed");
        }
    } else if (strcmp(action, "term") == 0) {
        kill(child, SIGTERM);
    } else {
        const int rows = t.rows;
        const struct winsize size = size_of(action);
        for (int i = t.rows; i < rows && t.y >= t.rows; i++, t.y--) { /* the cursor stays visible */
            scroll();
        }
        ioctl(terminal, TIOCSWINSZ, &size);
    }
}

int main(int count, char **arguments)
{
    struct winsize size;
    struct termios before = {0}, after = {0};
    int terminal, slave, status, next = 3;
    if (count < 5) {
        fail("COLUMNSxROWS SCREEN [PICTURES ACTION]... -- PROGRAM...");
    }
    size = size_of(arguments[1]);
    clear_below(0, 0);
    t.log = fopen(arguments[2], "w");
    if (!t.log || openpty(&terminal, &slave, NULL, NULL, &size) != 0 ||
        tcgetattr(terminal, &before) != 0) {
        fail(strerror(errno));
    }
    int program = 3;
    while (program < count - 1 && strcmp(arguments[program], "--") != 0) {
        program++;
    }
    const pid_t child = fork();
    if (child == 0) {
        close(terminal);
        login_tty(slave);
        execvp(arguments[program + 1], arguments + program + 1);
        _exit(127);
    }
    for (bool over = false, empty = false; child > 0 && !(over && empty);) {
        unsigned char bytes[4096];
        fd_set ready;
        struct timeval wait = {0, 10000};
        ssize_t got = 0;
        over = over || waitpid(child, &status, WNOHANG) == child; /* then look once more */
        FD_ZERO(&ready);
        FD_SET(terminal, &ready);
        if (select(terminal + 1, &ready, NULL, NULL, &wait) > 0) {
            got = read(terminal, bytes, sizeof bytes);
        }
        for (ssize_t i = 0; i < got; i++) {
            take(bytes[i]);
        }
        empty = got <= 0;
        for (; next + 1 < program && t.pictures >= atoi(arguments[next]); next += 2) {
            act(arguments[next + 1], terminal, child);
        }
    }
    if (child < 0 || t.state != TEXT || tcgetattr(terminal, &after) != 0 ||
        memcmp(&before, &after, sizeof before) != 0) {
        fail("the terminal is not as it was before");
    }
    fprintf(t.log, "----\n");
    for (int i = 0; i < t.rows; i++) {
        print_row(i);
    }
    if (fclose(t.log) != 0) {
        fail(strerror(errno));
    }
    printf("pictures %d\n", t.pictures);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}
