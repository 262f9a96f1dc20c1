/* Functions of formulas that are given by tables: piecewise cubics, a tree of where. */
#include "physics/quantity/quantity_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct quantity_table {
    char name[QUANTITY_NAME_MAX + 1];
    int count;
    quantity_table *next;
    double rows[]; /* [3][count]: x, y, slope */
};

/* ---- slopes ---------------------------------------------------------------------------------- */

/* The weighted harmonic mean of the slopes of two neighbours, 0 where they differ in sign (Fritsch,
 * Butland, SIAM J. Sci. Stat. Comput. 5, 1984). */
static double inner_slope(double before, double after, double first, double second)
{
    double one = 2 * after + before, two = after + 2 * before;
    return first * second <= 0 ? 0 : (one + two) / (one / first + two / second);
}

/* Of the parabola through three points, at the first; kept from overshooting. */
static double end_slope(double near, double far, double first, double second)
{
    double slope = ((2 * near + far) * first - near * second) / (near + far);
    if (slope * first <= 0) {
        return 0;
    }
    return first * second <= 0 && fabs(slope) > 3 * fabs(first) ? 3 * first : slope;
}

static void set_slopes(int count, const double *x, const double *y, double *slope)
{
    if (count == 2) {
        slope[0] = slope[1] = (y[1] - y[0]) / (x[1] - x[0]);
        return;
    }
    double before = 0, first = 0;
    for (int i = 0; i + 1 < count; i++) {
        double after = x[i + 1] - x[i], second = (y[i + 1] - y[i]) / after;
        if (i == 1) {
            slope[0] = end_slope(before, after, first, second);
        }
        if (i > 0) {
            slope[i] = inner_slope(before, after, first, second);
        }
        if (i == count - 2) {
            slope[count - 1] = end_slope(after, before, second, first);
        }
        before = after;
        first = second;
    }
}

/* ---- the list -------------------------------------------------------------------------------- */

quantity_table *quantity_table_create(const char *name, int count, const double *x, const double *y,
                                      quantity_table *next)
{
    size_t n = (size_t)count;
    quantity_table *table = calloc(1, sizeof *table + 3 * n * sizeof(double));
    if (table) {
        memcpy(table->name, name, strlen(name) + 1);
        table->count = count;
        table->next = next;
        memcpy(table->rows, x, n * sizeof *x);
        memcpy(table->rows + n, y, n * sizeof *y);
        set_slopes(count, x, y, table->rows + 2 * n);
    }
    return table;
}

void quantity_tables_free(quantity_table *first)
{
    while (first) {
        quantity_table *next = first->next;
        free(first);
        first = next;
    }
}

const quantity_table *quantity_table_find(const quantity_table *first, const char *name,
                                          size_t length)
{
    for (; first; first = first->next) {
        if (strlen(first->name) == length && strncmp(first->name, name, length) == 0) {
            return first;
        }
    }
    return NULL;
}

/* ---- a call ---------------------------------------------------------------------------------- */

/* Hermite's cubic from row i to the next, by powers of the distance from x_i. */
static quantity cubic(const quantity_table *table, int i, quantity x)
{
    const double *at = table->rows + i, *y = at + table->count, *slope = y + table->count;
    double width = at[1] - at[0], chord = (y[1] - y[0]) / width;
    double third = (slope[0] + slope[1] - 2 * chord) / (width * width);
    double second = (3 * chord - 2 * slope[0] - slope[1]) / width;
    quantity off = quantity_subtract(x, quantity_number(at[0]));
    quantity sum = quantity_number(third);
    sum = quantity_add(quantity_number(second), quantity_multiply(off, sum));
    sum = quantity_add(quantity_number(slope[0]), quantity_multiply(off, sum));
    return quantity_add(quantity_number(y[0]), quantity_multiply(off, sum));
}

/* Pieces first to last - 1. */
static quantity tree(const quantity_table *table, int first, int last, quantity x)
{
    if (last - first == 1) {
        return cubic(table, first, x);
    }
    int middle = (first + last) / 2;
    quantity before = quantity_subtract(quantity_number(table->rows[middle]), x);
    const quantity branches[3] = {before, tree(table, first, middle, x),
                                  tree(table, middle, last, x)};
    return quantity_operate(&quantity_operations[QUANTITY_WHERE], branches);
}

quantity quantity_table_call(const quantity_table *table, quantity x)
{
    const quantity bounds[3] = {x, quantity_number(table->rows[0]),
                                quantity_number(table->rows[table->count - 1])};
    return tree(table, 0, table->count - 1,
                quantity_operate(&quantity_operations[QUANTITY_WITHIN], bounds));
}
