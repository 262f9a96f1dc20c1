/* Letters for pictures of pixels: strokes of a pen with round ends. */
#include "tools/picture/picture_parts.h"

#include <string.h>

/* Lines of letters.txt: a letter, a blank and its strokes between blanks, each corners "xy" on a
 * grid: x a digit, y from a = -2 (below the line) over c = 0 and h = 5 (the height of small
 * letters) to j = 7. "~": a quadratic B-spline of these corners, "@": a closed one.
 *
 * The strokes of the letter that a text begins with, and how many bytes it has. */
static const char *letter_of(const char *text, size_t *bytes)
{
    *bytes = 1;
    while (((unsigned char)*text & 0x80) && ((unsigned char)text[*bytes] & 0xC0) == 0x80) {
        ++*bytes;
    }
    for (const char *const *line = picture_text_letters; *line && *text != ' '; line++) {
        if (strncmp(*line, text, *bytes) == 0 && (*line)[*bytes] == ' ') {
            return *line + *bytes + 1;
        }
    }
    return *text == ' ' ? "" : "0c4c4j0j0c";
}

static int wide(const char *letter)
{
    int most = *letter ? 0 : 1;
    for (; *letter; letter++) {
        most = *letter >= '0' && *letter <= '9' && *letter - '0' > most ? *letter - '0' : most;
    }
    return most;
}

static void corner(const char *stroke, size_t k, double x, double unit, double to[2])
{
    to[0] = x + unit * (stroke[2 * k] - '0');
    to[1] = -unit * (stroke[2 * k + 1] - 'c');
}

/* A stroke of `count` corners. */
static void draw_stroke(const char *stroke, size_t count, char kind, double x, double unit,
                        picture_pen draw, void *context)
{
    enum { MOST = 16, PIECES = 5 };
    double points[(MOST + 1) * PIECES + 1][2], c[MOST][2];
    size_t used = 0;
    for (size_t k = 0; k < count && k < MOST; k++) {
        corner(stroke, k, x, unit, c[k]);
    }
    if (kind == ' ' || count < 3) { /* straight */
        draw(context, c[0], count);
        return;
    }
    const size_t arcs = kind == '@' ? count : count - 2;
    for (size_t k = 0; k < arcs; k++) { /* about corner k + 1, from middle to middle of its sides */
        const double *a = c[k], *b = c[(k + 1) % count], *d = c[(k + 2) % count];
        for (int piece = k > 0; piece <= PIECES; piece++) {
            const double u = (double)piece / PIECES;
            for (int i = 0; i < 2; i++) {
                const double from = kind == '~' && k == 0 ? a[i] : (a[i] + b[i]) / 2;
                const double to = kind == '~' && k + 1 == arcs ? d[i] : (b[i] + d[i]) / 2;
                points[used][i] = (1 - u) * (1 - u) * from + 2 * u * (1 - u) * b[i] + u * u * to;
            }
            used++;
        }
    }
    draw(context, points[0], used);
}

double picture_write(const char *text, double size, picture_pen draw, void *context)
{
    const double unit = size / 9.6;
    double x = 0;
    for (size_t bytes; *text; text += bytes) {
        const char *letter = letter_of(text, &bytes);
        for (const char *at = letter; draw && *at > ' ';) {
            const char kind = *at == '~' || *at == '@' ? *at++ : ' ';
            const size_t length = strcspn(at, " \n");
            draw_stroke(at, length / 2, kind, x, unit, draw, context);
            at += length;
            at += *at == ' ';
        }
        x += unit * (wide(letter) + 1.9);
    }
    return x > 0 ? x - 1.9 * unit : 0;
}

double picture_text_width(double size, const char *text)
{
    return picture_write(text, size, NULL, NULL);
}
