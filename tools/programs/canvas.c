#include "tools/programs/canvas.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void canvas_clear(canvas *c, int columns, int rows)
{
    c->columns = columns < CANVAS_COLUMNS ? columns : CANVAS_COLUMNS;
    c->rows = rows < CANVAS_ROWS ? rows : CANVAS_ROWS;
    memset(c->cells, 0, sizeof c->cells);
}

void canvas_put(canvas *c, int column, int row, canvas_colour colour, unsigned code)
{
    if (column >= 0 && column < c->columns && row >= 0 && row < c->rows) {
        c->cells[row][column] = (canvas_cell){(uint16_t)code, 0, (uint8_t)colour};
    }
}

int canvas_text(canvas *c, int column, int row, canvas_colour colour, const char *text)
{
    for (; *text; text++) {
        canvas_put(c, column++, row, colour, *text >= ' ' && *text <= '~' ? (unsigned)*text : '?');
    }
    return column;
}

/* ---- lines --------------------------------------------------------------------------------- */

/* A dot, counted from the upper left corner of all. */
static void put_dot(canvas *c, canvas_colour colour, int x, int y)
{
    static const uint8_t bits[CANVAS_DOWN][CANVAS_ACROSS] = {
        {0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}}; /* Unicode, 2800 to 28FF */
    const int column = x / CANVAS_ACROSS, row = y / CANVAS_DOWN;
    if (x < 0 || y < 0 || column >= c->columns || row >= c->rows) {
        return;
    }
    canvas_cell *cell = &c->cells[row][column];
    if (!cell->code) {
        cell->dots |= bits[y % CANVAS_DOWN][x % CANVAS_ACROSS];
        cell->colour = (uint8_t)colour;
    }
}

/* Cuts the range [*from, *to] of a line's parameter where start + parameter * change leaves
 * [0, most] (Liang and Barsky 1984). */
static void cut(double start, double change, double most, double *from, double *to)
{
    if (change == 0) {
        *to = start < 0 || start > most ? -1 : *to;
        return;
    }
    const double one = -start / change, other = (most - start) / change;
    *from = fmax(*from, fmin(one, other));
    *to = fmin(*to, fmax(one, other));
}

void canvas_line(canvas *c, const canvas_view *view, canvas_colour colour, double x0, double y0,
                 double x1, double y1)
{
    const double width = CANVAS_ACROSS * view->columns - 1, height = CANVAS_DOWN * view->rows - 1;
    const double across = width / (view->right - view->left);
    const double down = height / (view->bottom - view->top);
    const double x = (x0 - view->left) * across, y = (y0 - view->top) * down;
    const double dx = (x1 - x0) * across, dy = (y1 - y0) * down;
    double from = 0, to = 1;
    if (!isfinite(x) || !isfinite(y) || !isfinite(dx) || !isfinite(dy)) {
        return;
    }
    const double near = 1e-9; /* of a dot, at the edges */
    cut(x + near, dx, width + 2 * near, &from, &to);
    cut(y + near, dy, height + 2 * near, &from, &to);
    if (from > to) {
        return;
    }
    const int steps = (int)ceil((to - from) * fmax(fabs(dx), fabs(dy)));
    for (int i = 0; i <= steps; i++) {
        const double at = steps ? from + (to - from) * i / steps : from;
        put_dot(c, colour, CANVAS_ACROSS * view->column + (int)lround(x + at * dx),
                CANVAS_DOWN * view->row + (int)lround(y + at * dy));
    }
}

/* ---- text ---------------------------------------------------------------------------------- */

/* What stands for a character where there is only ASCII. */
static unsigned plain_code(const canvas_cell *cell)
{
    static const struct {
        uint16_t code;
        char plain;
    } known[] = {{0x2500, '-'}, {0x2501, '='}, {0x2502, '|'}, {0x2190, '<'},
                 {0x2191, '^'}, {0x2192, '>'}, {0x25a0, '#'}};
    const unsigned upper = cell->dots & 0x1b, lower = cell->dots & 0xe4;
    if (!cell->code) {
        return upper && lower ? ':' : upper ? '\'' : lower ? '.' : ' ';
    }
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (known[i].code == cell->code) {
            return (unsigned char)known[i].plain;
        }
    }
    return cell->code < 0x80 ? cell->code : '+'; /* corners of boxes */
}

static size_t put_code(unsigned code, char *text)
{
    if (code < 0x80) {
        text[0] = (char)code;
        return 1;
    }
    if (code < 0x800) {
        text[0] = (char)(0xc0 | code >> 6);
        text[1] = (char)(0x80 | (code & 0x3f));
        return 2;
    }
    text[0] = (char)(0xe0 | code >> 12);
    text[1] = (char)(0x80 | (code >> 6 & 0x3f));
    text[2] = (char)(0x80 | (code & 0x3f));
    return 3;
}

size_t canvas_row(const canvas *c, int row, bool utf8, bool colours, char *text)
{
    static const char *const escapes[] = {"\033[0m",  "\033[2m",  "\033[94m", "\033[36m",
                                          "\033[32m", "\033[33m", "\033[31m", "\033[35m"};
    const canvas_cell *cells = c->cells[row];
    int end = c->columns;
    unsigned colour = CANVAS_PLAIN;
    size_t size = 0;
    while (end > 0 && !cells[end - 1].code && !cells[end - 1].dots) {
        end--;
    }
    for (int i = 0; i <= end; i++) {
        const canvas_cell blank = {0}, *cell = i < end ? &cells[i] : &blank;
        const bool empty = !cell->code && !cell->dots;
        if (colours && cell->colour != colour && (!empty || i == end)) {
            if (colour == CANVAS_DIM) { /* which no colour ends */
                size += (size_t)sprintf(text + size, "%s", escapes[CANVAS_PLAIN]);
            }
            colour = cell->colour;
            size += (size_t)sprintf(text + size, "%s", escapes[colour]);
        }
        if (i < end) {
            size += put_code(!utf8        ? plain_code(cell)
                             : cell->code ? cell->code
                             : cell->dots ? 0x2800u + cell->dots
                                          : ' ',
                             text + size);
        }
    }
    return size;
}
