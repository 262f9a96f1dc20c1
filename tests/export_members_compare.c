/* A family written by cpinn-export as NAME.h with two places, the last the tip, compiled with
 * -DHEADER='"NAME.h"' -DNAME=NAME -DNUMBER=double (or float):
 *   export_members_compare MEMBERS.csv SHAPES.csv TOLERANCE STEPS    shapes after steps as
 * cpinn-eval or cpinn-solve has written them, of three places, the first the start; columns that
 * both have */
#include HEADER

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PASTE(a, b) a##_##b
#define JOIN(a, b)  PASTE(a, b)
#define OF(what)    JOIN(NAME, what)

enum { P = OF(PARAMETERS), COLUMNS = OF(COLUMNS), POINTS = 2, FIELDS = 40 };

static int index_of[COLUMNS];

/* Where the line has a column; -1: nowhere. */
static int find(const char *line, const char *name)
{
    const size_t length = strlen(name);
    for (int i = 0;; i++) {
        const size_t size = strcspn(line, ",\n");
        if (size == length && strncmp(line, name, size) == 0) {
            return i;
        }
        if (line[size] != ',') {
            return -1;
        }
        line += size + 1;
    }
}

static int read_line(FILE *file, double *fields)
{
    char line[4000], *at = line;
    if (!fgets(line, sizeof line, file)) {
        return 0;
    }
    for (int i = 0; i < FIELDS && at; i++) {
        fields[i] = strtod(at, NULL);
        at = strchr(at, ',');
        at += at != NULL;
    }
    return 1;
}

int main(int count, char **arguments)
{
    static NUMBER memory[OF(MEMORY)];
    char line[4000];
    double fields[FIELDS], worst = 0;
    int compared = 0;
    FILE *members = count == 5 ? fopen(arguments[1], "r") : NULL;
    FILE *shapes = count == 5 ? fopen(arguments[2], "r") : NULL;
    if (!members || !shapes || !fgets(line, sizeof line, members) ||
        !fgets(line, sizeof line, shapes)) {
        return 2;
    }
    for (int c = 0; c < COLUMNS; c++) {
        index_of[c] = find(line, OF(column_names)[c]);
    }
    while (read_line(members, fields)) {
        NUMBER parameters[P], shape[POINTS][COLUMNS];
        for (int i = 0; i < P; i++) {
            parameters[i] = (NUMBER)fields[i];
        }
        OF(shape)(parameters, atoi(arguments[4]), shape[0], NULL, memory);
        read_line(shapes, fields); /* the start */
        for (int k = 0; k < POINTS; k++) {
            if (!read_line(shapes, fields)) {
                return 2;
            }
            for (int c = 0; c < COLUMNS; c++) {
                if (index_of[c] >= 0) {
                    const double unit =
                        OF(column_names)[c][0] == 'u' ? 0.1 : 1; /* of 0 to 20 1/m */
                    const double off = unit * fabs((double)shape[k][c] - fields[index_of[c]]);
                    worst = off <= worst ? worst : off;
                    compared++;
                }
            }
        }
    }
    printf("%d numbers, off by %.2g\n", compared, worst);
    return !(worst <= atof(arguments[3]) && compared >= POINTS * COLUMNS / 2);
}
