/* Letters for pictures of pixels: strokes of a pen with round ends. */
#include "tools/picture/picture_parts.h"

#include <string.h>

/* A letter is strokes between blanks, each corners "xy" on a grid: x a digit, y from a = -2 (below
 * the line) over c = 0 and h = 5 (the height of small letters) to j = 7. "~": a quadratic B-spline
 * of these corners, "@": a closed one. */
static const char *const letters[128] = {
    [' '] = "",
    ['!'] = "0j0e 0c0c",
    ['"'] = "0j0h 2j2h",
    ['#'] = "1c1j 3c3j 0e4e 0h4h",
    ['%'] = "0c5j @0h2h2j0j @3c5c5e3e",
    ['&'] = "~5c1i1j3j3h0f0c3c5f",
    ['\''] = "0j0h",
    ['('] = "~2k0j0b2a",
    [')'] = "~0k2j2b0a",
    ['*'] = "0e4i 4e0i",
    ['+'] = "0f4f 2d2h",
    [','] = "1c0b",
    ['-'] = "0f3f",
    ['.'] = "0c0c",
    ['/'] = "0b3j",
    ['0'] = "@0c4c4j0j",
    ['1'] = "0h2j2c",
    ['2'] = "~0i0j4j4g0d0c 0c4c",
    ['3'] = "~0i0j4j4g2g1g ~1g4g4c0c0d",
    ['4'] = "3c3j0e4e",
    ['5'] = "4j0j0g ~0g1h4h4c0c0d",
    ['6'] = "@0c4c4g0g ~4j1j0g0e",
    ['7'] = "0j4j1c",
    ['8'] = "@0c4c4g0g @0g4g4j0j",
    ['9'] = "@0f4f4j0j ~4h4f3c0c",
    [':'] = "0d0d 0g0g",
    [';'] = "1g1g 1d0b",
    ['<'] = "4h0f4d",
    ['='] = "0e4e 0g4g",
    ['>'] = "0h4f0d",
    ['?'] = "~0i0j4j4g2g2e 2c2c",
    ['A'] = "0c2j4c 1e3e",
    ['B'] = "2j0j0c2c 0g2g ~2j4j4g2g ~2g5g5c2c",
    ['C'] = "~5i4j0j0c4c5d",
    ['D'] = "2j0j0c2c ~2j5j5c2c",
    ['E'] = "4j0j0c4c 0g3g",
    ['F'] = "4j0j0c 0g3g",
    ['G'] = "~5i4j0j0c5c5f 5f3f",
    ['H'] = "0j0c 4j4c 0g4g",
    ['I'] = "0j0c",
    ['J'] = "~3j3d3c0c0d",
    ['K'] = "0j0c 4j0f 1g4c",
    ['L'] = "0j0c4c",
    ['M'] = "0c0j3e6j6c",
    ['N'] = "0c0j4c4j",
    ['O'] = "@0c5c5j0j",
    ['P'] = "0c0j2j 0f2f ~2j5j5f2f",
    ['Q'] = "@0c5c5j0j 3e5c",
    ['R'] = "0c0j2j 0g2g ~2j5j5g2g 2g4c",
    ['S'] = "~4i4j0j0g4g4c0c0d",
    ['T'] = "0j4j 2j2c",
    ['U'] = "~0j0e0c5c5e5j",
    ['V'] = "0j2c4j",
    ['W'] = "0j2c4j6c8j",
    ['X'] = "0j4c 4j0c",
    ['Y'] = "0j2g4j 2g2c",
    ['Z'] = "0j4j0c4c",
    ['['] = "2k0k0a2a",
    [']'] = "0k2k2a0a",
    ['^'] = "0h2j4h",
    ['_'] = "0b4b",
    ['a'] = "@0c4c4h0h 4h4c",
    ['b'] = "0j0c @0c4c4h0h",
    ['c'] = "~4g3h0h0c3c4d",
    ['d'] = "4j4c @0c4c4h0h",
    ['e'] = "0f4f ~4f4h0h0c3c4d",
    ['f'] = "~3j1j1h1c 0h3h",
    ['g'] = "@0c4c4h0h ~4h4c4a0a0b",
    ['h'] = "0j0c ~0f1h4h4f4c",
    ['i'] = "0h0c 0j0j",
    ['j'] = "~1h1b1a0a 1j1j",
    ['k'] = "0j0c 3h0e 1f3c",
    ['l'] = "0j0c",
    ['m'] = "0h0c ~0f0h3h3f3c ~3f3h6h6f6c",
    ['n'] = "0h0c ~0f1h4h4f4c",
    ['o'] = "@0c4c4h0h",
    ['p'] = "0h0a @0c4c4h0h",
    ['q'] = "4h4a @0c4c4h0h",
    ['r'] = "0h0c ~0f0h2h3h",
    ['s'] = "~3g3h0h0f3f3c0c0d",
    ['t'] = "~1j1d1c3c 0h3h",
    ['u'] = "~0h0e0c3c4e 4h4c",
    ['v'] = "0h2c4h",
    ['w'] = "0h1c3h5c6h",
    ['x'] = "0h4c 4h0c",
    ['y'] = "0h2c 4h1a",
    ['z'] = "0h4h0c4c",
};

static const char micro[] = "0h0a ~0e0c3c4e 4h4c", degree[] = "@0h2h2j0j", unknown[] = "0c4c4j0j0c";

/* The letter that a text begins with, and how many bytes it has. */
static const char *letter_of(const char *text, size_t *bytes)
{
    const unsigned char first = (unsigned char)*text;
    *bytes = 1;
    if (first < 128) {
        return letters[first] ? letters[first] : unknown;
    }
    while (((unsigned char)text[*bytes] & 0xC0) == 0x80) {
        ++*bytes;
    }
    return strncmp(text, "\302\265", 2) == 0   ? micro
           : strncmp(text, "\302\260", 2) == 0 ? degree
                                               : unknown;
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
    if (kind == ' ') {
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
        for (const char *at = letter; draw && *at;) {
            const char kind = *at == '~' || *at == '@' ? *at++ : ' ';
            const size_t length = strcspn(at, " ");
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
