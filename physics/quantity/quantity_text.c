/* Quantities as text. */
#include "physics/quantity/quantity_internal.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void write_number(double number, char text[32])
{
    if (isinf(number) || isnan(number)) {
        snprintf(text, 32, "%s", isnan(number) ? ".nan" : number > 0 ? ".inf" : "-.inf");
        return;
    }
    ad_number_text(number, text);
    char *exponent = strchr(text, 'e');
    if (exponent && !strchr(text, '.')) {
        memmove(exponent + 2, exponent, strlen(exponent) + 1);
        memcpy(exponent, ".0", 2);
    }
}

void quantity_number_text(double number, char text[32])
{
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    locale_t before = c_locale ? uselocale(c_locale) : (locale_t)0;
    write_number(number, text);
    if (c_locale) {
        uselocale(before);
        freelocale(c_locale);
    }
}

static bool is_written_as_number(const quantity *q, bool as_written)
{
    const quantity_node *node = q->node;
    return !node || (node->uses == 0 && !(as_written || node->kind != QUANTITY_WRITTEN));
}

static void write_quantity(FILE *file, const quantity *q, bool as_written, int around);

/* Formulas have no words for what is not finite, which YAML has. */
static void write_argument(FILE *file, const quantity *q, bool as_written, int around)
{
    if (is_written_as_number(q, as_written) && !isfinite(q->number)) {
        fputs(isnan(q->number) ? "(0/0)" : q->number > 0 ? "(1/0)" : "(-1/0)", file);
    } else {
        write_quantity(file, q, as_written, around);
    }
}

/* `around`: the operator that takes it as an argument binds so tightly. */
static void write_operation(FILE *file, const quantity_node *node, bool as_written, int around)
{
    const quantity_operation *operation = node->operation;
    bool enclosed = operation->precedence && operation->precedence <= around;
    if (!operation->precedence) {
        fprintf(file, "%s(", operation->name);
        for (int i = 0; i < operation->arity; i++) {
            fputs(i ? ", " : "", file);
            write_argument(file, &node->x[i], as_written, 0);
        }
        fputc(')', file);
        return;
    }
    /* from the left, so that the right argument is enclosed where it binds as tightly; a power
     * encloses both */
    bool power = operation->precedence == 3;
    fputs(enclosed ? "(" : "", file);
    write_argument(file, &node->x[0], as_written, operation->precedence - !power);
    fputs(operation->name, file);
    write_argument(file, &node->x[1], as_written, operation->precedence);
    fputs(enclosed ? ")" : "", file);
}

static void write_quantity(FILE *file, const quantity *q, bool as_written, int around)
{
    char number[32];
    const quantity_node *node = q->node;
    if (is_written_as_number(q, as_written)) {
        quantity_number_text(q->number, number);
        fprintf(file, around && *number == '-' ? "(%s)" : "%s", number);
    } else if (node->kind == QUANTITY_OPERATION) {
        write_operation(file, node, as_written, around);
    } else if (node->kind == QUANTITY_WRITTEN && !as_written) {
        write_quantity(file, &node->x[0], as_written, around);
    } else {
        bool enclosed = around && node->kind == QUANTITY_WRITTEN;
        fprintf(file, enclosed ? "(%s)" : "%s", node->text);
    }
}

char *quantity_text(quantity q, bool as_written)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return NULL;
    }
    write_quantity(file, &q, as_written, 0);
    if (fclose(file) != 0) {
        free(text);
        return NULL;
    }
    return text;
}
