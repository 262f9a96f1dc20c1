#include "random_scenes.h"

#include <math.h>
#include <stdlib.h>

/* ---- tables ---------------------------------------------------------------------------------- */

/* Slope of a monotone cubic at row i (Fritsch, Butland, SIAM J. Sci. Stat. Comput. 5, 1984); at the
 * ends that of a parabola, kept from overshooting. */
static double slope_at(const double *x, const double *y, int i)
{
    if (i > 0 && i < PROFILE_ROWS - 1) {
        double h = x[i] - x[i - 1], k = x[i + 1] - x[i];
        double a = (y[i] - y[i - 1]) / h, b = (y[i + 1] - y[i]) / k;
        return a * b <= 0 ? 0 : 3 * (h + k) / ((2 * k + h) / a + (k + 2 * h) / b);
    }
    int step = i == 0 ? 1 : -1;
    double h = x[i + step] - x[i], k = x[i + 2 * step] - x[i + step];
    double a = (y[i + step] - y[i]) / h, b = (y[i + 2 * step] - y[i + step]) / k;
    double slope = ((2 * h + k) * a - h * b) / (h + k);
    if (slope * a <= 0) {
        return 0;
    }
    return a * b <= 0 && fabs(slope) > 3 * fabs(a) ? 3 * a : slope;
}

static double table_value(const profile_part *part, double s, double inside)
{
    const double *x = part->knots, *y = part->rows;
    int i = 0;
    while (i < PROFILE_ROWS - 2 && x[i + 1] < inside) {
        i++;
    }
    double h = x[i + 1] - x[i], t = (s - x[i]) / h, u = 1 - t;
    return y[i] * u * u * (1 + 2 * t) + y[i + 1] * t * t * (3 - 2 * t) +
           h * t * u * (u * slope_at(x, y, i) - t * slope_at(x, y, i + 1));
}

/* ---- values ---------------------------------------------------------------------------------- */

/* The value at s, on the side of a jump on which `inside` is. */
static double part_value(const profile_part *part, double s, double inside)
{
    double x = (s - part->at) / part->width;
    switch (part->kind) {
    case PROFILE_CONSTANT:
        return part->value;
    case PROFILE_BAND:
        return inside > part->at && inside < part->at + part->width ? part->value : 0;
    case PROFILE_STEP:
        return inside > part->at ? part->value : 0;
    case PROFILE_BUMP:
        return part->value * exp(-x * x);
    case PROFILE_ELBOW:
        return part->value / (cosh(x) * cosh(x));
    case PROFILE_TENT:
        return inside > part->at - part->width && inside < part->at + part->width
                   ? part->value * (1 - (inside > part->at ? x : -x))
                   : 0;
    case PROFILE_TABLE:
        return part->value * table_value(part, s, inside);
    case PROFILE_KINDS:
        break;
    }
    return NAN;
}

double profile_value(const profile *p, double s, double inside)
{
    double sum = 0;
    for (int i = 0; i < p->count; i++) {
        sum += part_value(&p->parts[i], s, inside);
    }
    return sum;
}

/* ---- formulas -------------------------------------------------------------------------------- */

void profile_write(const profile_part *part, const char *table, FILE *to)
{
    double a = part->at, b = part->at + part->width, w = part->width, v = part->value;
    switch (part->kind) {
    case PROFILE_CONSTANT:
        fprintf(to, "(%.17g)", v);
        break;
    case PROFILE_BAND:
        if (part->spelling == 0) {
            fprintf(to, "where((s-%.17g)*(%.17g-s), %.17g, 0)", a, b, v);
        } else if (part->spelling == 1) {
            fprintf(to, "%.17g*step(s-%.17g)*step(%.17g-s)", v, a, b);
        } else if (part->spelling == 2) {
            fprintf(to, "where(s-%.17g, where(%.17g-s, %.17g, 0), 0)", a, b, v);
        } else {
            fprintf(to, "%.17g*step(min(s-%.17g, %.17g-s))", v, a, b);
        }
        break;
    case PROFILE_STEP:
        if (part->spelling < 2) {
            fprintf(to, "where(s-%.17g, %.17g, 0)", a, v);
        } else {
            fprintf(to, "%.17g*(1-step(%.17g-s))", v, a);
        }
        break;
    case PROFILE_BUMP:
        fprintf(to, "%.17g*exp(-((s-%.17g)/%.17g)^2)", v, a, w);
        break;
    case PROFILE_ELBOW:
        if (part->spelling < 2) {
            fprintf(to, "%.17g*(1-tanh((s-%.17g)/%.17g)^2)", v, a, w);
        } else {
            fprintf(to, "%.17g/cosh((s-%.17g)/%.17g)^2", v, a, w);
        }
        break;
    case PROFILE_TENT:
        fprintf(to, "%.17g*max(0, 1-abs(s-%.17g)/%.17g)", v, a, w);
        break;
    case PROFILE_TABLE:
        fprintf(to, "%.17g*%s(s)", v, table);
        break;
    case PROFILE_KINDS:
        break;
    }
}

quantity profile_quantity(const profile *p, quantities *names)
{
    static int tables; /* of all scenes: every name is new */
    char *text = NULL, table[32];
    size_t size = 0;
    ad_error error;
    FILE *to = open_memstream(&text, &size);
    for (int i = 0; i < p->count && to; i++) {
        const profile_part *part = &p->parts[i];
        snprintf(table, sizeof table, "table%d", part->kind == PROFILE_TABLE ? tables++ : 0);
        if (part->kind == PROFILE_TABLE &&
            quantities_define_table(names, table, PROFILE_ROWS, part->knots, part->rows, &error) !=
                AD_OK) {
            abort();
        }
        fputs(i ? " + " : "", to);
        profile_write(part, table, to);
    }
    if (!to || fclose(to) != 0) {
        abort();
    }
    quantity made = quantity_formula(names, p->count > 0 ? text : NULL);
    free(text);
    return made;
}
