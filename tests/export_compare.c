/* A model written by cpinn-export as NAME.h, compiled with -DHEADER="NAME.h" -DNAME=NAME:
 *   export_compare FILE.csv TOLERANCE    the table that cpinn-eval has written: its columns agree,
 * by the tolerance times the largest value of all with that unit; derivatives agree with
 * differences; ends of the range */
#include HEADER

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PASTE(a, b)  a##_##b
#define JOIN(a, b)   PASTE(a, b)
#define OF(what)     JOIN(NAME, what)
#define INPUTS       OF(INPUTS)
#define OUTPUTS      OF(OUTPUTS)
#define OUT_OF_RANGE OF(OUT_OF_RANGE)

enum { ROWS_MAX = 200, COLUMNS_MAX = 40 };

static double memory[OF(MEMORY)], table[ROWS_MAX][COLUMNS_MAX], scale[OUTPUTS];
static int rows, failures;

static void fail(const char *what, int row, int output, double is, double wanted)
{
    if (failures++ == 0) {
        printf("%s: %s at row %d is %.17g, not %.17g\n", what, OF(output_names)[output], row, is,
               wanted);
    }
}

/* The columns after those of the inputs are the outputs. */
static int read_table(const char *path)
{
    char line[4000];
    FILE *file = fopen(path, "r");
    if (!file || !fgets(line, sizeof line, file)) {
        return 0;
    }
    while (rows < ROWS_MAX && fgets(line, sizeof line, file)) {
        char *at = line;
        for (int i = 0; i < 2 + OUTPUTS; i++, at += *at == ',') {
            table[rows][i] = strtod(at, &at);
        }
        rows++;
    }
    fclose(file);
    return rows;
}

static const double *in_of(int row)
{
    return table[row]; /* s, t; of a model at rest s alone */
}

static void find_scales(void)
{
    for (int i = 0; i < OUTPUTS; i++) {
        scale[i] = 1e-6; /* what is smaller is nothing but rounding in the models of the test */
        for (int k = 0; k < OUTPUTS; k++) {
            for (int row = 0; row < rows && strcmp(OF(output_units)[i], OF(output_units)[k]) == 0;
                 row++) {
                scale[i] = fmax(scale[i], fabs(table[row][2 + k]));
            }
        }
    }
}

static void compare_values(double tolerance)
{
    for (int row = 0; row < rows; row++) {
        double out[OUTPUTS];
        if (OF(eval)(in_of(row), out, memory) != 0) {
            fail("status of eval", row, 0, 1, 0);
        }
        for (int i = 0; i < OUTPUTS; i++) {
            if (!(fabs(out[i] - table[row][2 + i]) <= tolerance * scale[i])) {
                fail("eval", row, i, out[i], table[row][2 + i]);
            }
        }
    }
}

/* Differences of fourth order: h = 1e-4 of the range leaves 1e-16 (waves)^5 of them, and of
 * rounding 1e-12 / 1e-4. A row whose steps may leave its window of time or its piece shows as a
 * difference to both sides; two thirds have to agree, of those that lie inside. */
static void compare_jacobian(void)
{
    static const double weights[2] = {8.0 / 12, -1.0 / 12};
    int seen = 0, bad = 0;
    for (int row = 0; row < rows; row++) {
        double out[OUTPUTS], jacobian[OUTPUTS][INPUTS];
        OF(jacobian)(in_of(row), out, jacobian[0], memory);
        for (int c = 0; c < INPUTS; c++) {
            const double range = OF(upper)[c] - OF(lower)[c], h = 1e-4 * range;
            double difference[OUTPUTS] = {0}, in[INPUTS], moved[OUTPUTS];
            int outside = 0, off = 0;
            for (int k = -2; k <= 2; k++) {
                memcpy(in, in_of(row), sizeof in);
                in[c] += k * h;
                outside |= OF(eval)(in, moved, memory);
                for (int i = 0; i < OUTPUTS && k != 0; i++) {
                    difference[i] += (k > 0 ? 1 : -1) * weights[abs(k) - 1] * moved[i] / h;
                }
            }
            for (int i = 0; i < OUTPUTS; i++) {
                double size = scale[i] / range + fabs(difference[i]);
                off |= !(fabs(jacobian[i][c] - difference[i]) <= 1e-5 * size);
            }
            seen += !outside;
            bad += !outside && off;
        }
    }
    if (seen == 0 || 3 * bad > seen) {
        printf("%d of %d derivatives are not those of differences\n", bad, seen);
        failures++;
    }
}

/* Beyond its range an input counts as the end of it. */
static void check_ends(void)
{
    for (int c = 0; c < INPUTS; c++) {
        double in[INPUTS], at_end[OUTPUTS], beyond[OUTPUTS];
        memcpy(in, in_of(rows / 2), sizeof in);
        in[c] = OF(upper)[c];
        int status = OF(eval)(in, at_end, memory);
        in[c] = 3 * OF(upper)[c];
        if (status != 0 || OF(eval)(in, beyond, memory) != OUT_OF_RANGE ||
            memcmp(at_end, beyond, sizeof beyond) != 0) {
            fail("beyond its end", rows / 2, 0, beyond[0], at_end[0]);
        }
        in[c] = -HUGE_VAL;
        if (OF(eval)(in, beyond, memory) != OUT_OF_RANGE || !isfinite(beyond[0])) {
            fail("-inf", rows / 2, 0, beyond[0], 0);
        }
    }
}

int main(int count, char **arguments)
{
    if (count != 3 || !read_table(arguments[1])) {
        fprintf(stderr, "export_compare FILE.csv TOLERANCE\n");
        return 2;
    }
    find_scales();
    compare_values(strtod(arguments[2], NULL));
    compare_jacobian();
    check_ends();
    return failures > 0;
}
