/* A family written by export_family.h as NAME.h, compiled with -DHEADER='"NAME.h"' -DNAME=NAME:
 *   export_family_compare MEMBERS.txt   of each member its parameters, and for 0, 1 and 2 steps
 * what the solver makes of the network's curvature: curvature, shape by 13 columns, distances.
 * Curvature agrees to rounding, shapes by the errors of both in taking it; derivatives with
 * differences. */
#include HEADER

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PASTE(a, b) a##_##b
#define JOIN(a, b)  PASTE(a, b)
#define OF(what)    JOIN(NAME, what)

enum {
    P = OF(PARAMETERS),
    N = 3 * OF(NODES),
    POINTS = OF(POINTS),
    COLUMNS = OF(COLUMNS),
    KNOWN = 13
};

static double memory[OF(MEMORY)];
static int failures;

static void compare(const char *what, int count, const double *is, const double *wanted,
                    double tolerance)
{
    double worst = 0, size = 0;
    for (int i = 0; i < count; i++) {
        double off = fabs(is[i] - wanted[i]);
        worst = off <= worst || isnan(worst) ? worst : off;
        size = fmax(size, fabs(wanted[i]));
    }
    if (!(worst <= tolerance)) {
        printf("%s: off by %.3g of %.3g, %.1g is allowed\n", what, worst, size, tolerance);
        failures++;
    }
}

static int read_list(FILE *file, int count, double *list)
{
    for (int i = 0; i < count; i++) {
        if (fscanf(file, "%lf", &list[i]) != 1) {
            return 0;
        }
    }
    return 1;
}

static void compare_steps(FILE *file, const double *p, int steps)
{
    static double shape[POINTS][COLUMNS], again[POINTS][COLUMNS], tip[COLUMNS];
    double wanted[N], values[POINTS][KNOWN], distances[2], curvature[N], pose[KNOWN];
    OF(answer) answer;
    if (!read_list(file, N, wanted) || !read_list(file, POINTS * KNOWN, values[0]) ||
        !read_list(file, 2, distances)) {
        failures++;
        return;
    }
    OF(network)(p, curvature, memory);
    failures += OF(polish)(p, steps, curvature, &answer, memory);
    compare("curvature", N, curvature, wanted, 1e-11); /* of 1 to 10 */
    failures += OF(shape)(p, steps, shape[0], &answer, memory);
    failures += OF(shape_of)(p, curvature, again[0], memory);
    failures += OF(tip)(p, steps, tip, NULL, memory);
    compare("in parts", POINTS * COLUMNS, again[0], shape[0], 1e-12);
    compare("tip", COLUMNS, tip, shape[POINTS - 1], 1e-6); /* by other steps */
    for (int i = 0; i < POINTS; i++) {
        for (int k = 0; k < KNOWN; k++) { /* q and -q, curvature as small as the rest */
            pose[k] = shape[i][k] * (k >= 10 ? OF(places)[POINTS - 1] : 1);
            values[i][k] *= k >= 10 ? OF(places)[POINTS - 1] : 1;
        }
        compare("shape", KNOWN, pose, values[i], 1e-6);
    }
    /* how far it moves, by the largest of other points and without what the mesh leaves out */
    compare("predicted", 1, &answer.predicted, distances, 0.2 * distances[0] + 1e-6);
    compare("left", 1, &answer.left, distances + 1, 0.5 * distances[1] + 1e-5);
}

/* Differences of order 4 along each parameter. */
static void compare_jacobian(const double *p, int steps)
{
    static const double weights[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    double tip[COLUMNS], jacobian[COLUMNS][P], column[COLUMNS], moved[COLUMNS], there[P];
    OF(tip_jacobian)(p, steps, tip, jacobian[0], NULL, memory);
    for (int i = 0; i < P; i++) {
        const double range = OF(upper)[i] - OF(lower)[i], h = 1e-3 * range;
        double difference[COLUMNS] = {0};
        for (int k = 0; k < 4; k++) {
            memcpy(there, p, sizeof there);
            there[i] += (k < 2 ? k - 2 : k - 1) * h;
            OF(tip)(there, steps > 0 ? 9 : 0, moved, NULL, memory);
            for (int c = 0; c < COLUMNS; c++) {
                difference[c] += weights[k] * moved[c] / h * range;
            }
        }
        for (int c = 0; c < COLUMNS; c++) {
            column[c] = jacobian[c][i] * range;
        }
        compare("jacobian", COLUMNS, column, difference, 1e-4);
    }
}

static void check_ends(const double *p)
{
    double end[COLUMNS], beyond[COLUMNS], there[P];
    for (int i = 0; i < P; i++) {
        memcpy(there, p, sizeof there);
        there[i] = OF(upper)[i];
        failures += OF(tip)(there, 1, end, NULL, memory);
        there[i] = 2 * OF(upper)[i] + 1;
        failures += OF(tip)(there, 1, beyond, NULL, memory) != OF(OUT_OF_RANGE);
        failures += memcmp(end, beyond, sizeof end) != 0;
        there[i] = NAN;
        failures += OF(tip)(there, 1, beyond, NULL, memory) != OF(OUT_OF_RANGE) || isnan(beyond[0]);
    }
}

int main(int count, char **arguments)
{
    FILE *file = count == 2 ? fopen(arguments[1], "r") : NULL;
    double p[P];
    int members = 0;
    if (!file) {
        fprintf(stderr, "export_family_compare MEMBERS.txt\n");
        return 2;
    }
    for (; read_list(file, P, p); members++) {
        for (int steps = 0; steps <= 2; steps++) {
            compare_steps(file, p, steps);
        }
        double curvature[N];
        OF(network)(p, curvature, memory);
        compare_jacobian(p, 0);
        OF(polish)(p, 9, curvature, NULL, memory);
        compare_jacobian(p, 9);
        check_ends(p);
    }
    fclose(file);
    return failures > 0 || members == 0;
}
