#include "tools/emit/export_text.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

bool export_text_open(export_text *text)
{
    text->file = open_memstream(&text->bytes, &text->size);
    return text->file != NULL;
}

bool export_text_close(export_text *text)
{
    const bool ok = text->file && !ferror(text->file);
    return text->file && fclose(text->file) == 0 && ok;
}

ad_status export_text_write(export_text *text, int which, export_writer *writer, void *of,
                            ad_error *error)
{
    free(text->bytes);
    *text = (export_text){.bytes = NULL};
    ad_status status = export_text_open(text) ? writer(of, which, text->file, error) : AD_OK;
    return export_text_close(text) || status != AD_OK
               ? status
               : ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
}

void export_put(const char *name, export_type type, const char *text, FILE *file)
{
    const struct {
        const char *word, *to, *behind;
        bool of_single;
    } words[] = {{"model_number", type == EXPORT_DOUBLE ? "double" : "float", "", false},
                 {"model_", name, "_", false},
                 {"double ", "float ", "", true},
                 {"fabs(", "fabsf(", "", true},
                 {"sqrt(", "sqrtf(", "", true},
                 {"HUGE_VAL", "HUGE_VALF", "", true}};
    while (*text) {
        size_t i = 0;
        while (i < sizeof words / sizeof *words &&
               ((words[i].of_single && type != EXPORT_ALL_FLOAT) ||
                strncmp(text, words[i].word, strlen(words[i].word)) != 0)) {
            i++;
        }
        if (i == sizeof words / sizeof *words) {
            fputc(*text++, file);
        } else {
            fprintf(file, "%s%s", words[i].to, words[i].behind);
            text += strlen(words[i].word);
        }
    }
}

void export_put_lines(const char *name, export_type type, const char *const *lines, FILE *file)
{
    for (; *lines; lines++) {
        export_put(name, type, *lines, file);
    }
}

void export_put_comment(const char *text, FILE *file)
{
    for (; *text; text++) {
        const bool ends = (text[0] == '*' && text[1] == '/') || (text[0] == '/' && text[1] == '*');
        fputc(ends || *text == '\n' || *text == '\\' ? ' ' : *text, file);
    }
}

static void put_upper(const char *text, FILE *file)
{
    for (; *text; text++) {
        fputc(toupper((unsigned char)*text), file);
    }
}

/* ---- numbers and names --------------------------------------------------------------------- */

/* A float has the point or the exponent that its f needs. */
void export_put_number(double value, bool single, FILE *file)
{
    if (isnan(value)) {
        fputs("NAN", file);
    } else if (isinf(value)) {
        fputs(value > 0 ? "INFINITY" : "-INFINITY", file);
    } else {
        fprintf(file, single ? "%.8ef" : "%.17g", value);
    }
}

void export_put_list(size_t count, const double *list, double unit, bool single, FILE *file)
{
    fputc('{', file);
    for (size_t i = 0; i < count; i++) {
        fputs(i == 0 ? "" : i % 4 ? ", " : ",\n    ", file);
        export_put_number(list[i] * unit, single, file);
    }
    fputc('}', file);
}

static void put_floats(size_t count, const float *list, const char *name, const char *of,
                       FILE *file)
{
    fprintf(file, "static const float %s_%s[] = {", name, of);
    for (size_t i = 0; i < count; i++) {
        fprintf(file, "%s%.9g", i == 0 ? "" : i % 10 ? ", " : ",\n    ", list[i]);
    }
    fputs("};\n", file);
}

void export_put_tree(const triangle_tree *tree, const char *name, FILE *file)
{
    put_floats(3 * (size_t)tree->corners, tree->corner, name, "corners", file);
    put_floats(6 * TRIANGLE_TREE_BOXES(tree), tree->box, name, "boxes", file);
    export_put_integers(file, 3 * (size_t)tree->triangles, tree->triangle,
                        "static const int %s_triangles[]", name);
    fprintf(file,
            "static const triangle_tree %s = {%d, %d, %d, %d,\n    %s_corners, %s_triangles, "
            "%s_boxes};\n",
            name, tree->corners, tree->triangles, tree->levels, tree->side, name, name, name);
}

void export_put_rows(const char *head, size_t rows, size_t columns, const double *list, bool single,
                     FILE *file)
{
    fprintf(file, "%s[%zu][%zu] = {\n", head, rows, columns);
    for (size_t i = 0; i < rows; i++) {
        export_put_list(columns, list + i * columns, 1, single, file);
        fputs(i + 1 < rows ? ",\n" : "};\n", file);
    }
}

static void put_head(FILE *file, const char *head, va_list arguments)
{
    vfprintf(file, head, arguments);
    fputs(" = ", file);
}

void export_put_array(FILE *file, size_t count, const double *list, const char *head, ...)
{
    const double none = 0;
    va_list arguments;
    va_start(arguments, head);
    if (list) {
        put_head(file, head, arguments);
        export_put_list(count > 0 ? count : 1, count > 0 ? list : &none, 1, false, file);
        fputs(";\n", file);
    }
    va_end(arguments);
}

void export_put_integers(FILE *file, size_t count, const int *list, const char *head, ...)
{
    va_list arguments;
    va_start(arguments, head);
    put_head(file, head, arguments);
    va_end(arguments);
    for (size_t i = 0; i < count; i++) {
        fprintf(file, "%s%d", i == 0 ? "{" : i % 20 ? ", " : ",\n    ", list[i]);
    }
    fputs(count > 0 ? "};\n" : "{0};\n", file);
}

void export_put_index(const char *name, const char *kind, const char *word, int index, int count,
                      FILE *file)
{
    fprintf(file, "    %s_%s", name, kind);
    put_upper(word, file);
    fprintf(file, " = %d%s", index, index + 1 < count ? "," : "");
}

void export_put_names(const char *name, const char *kind, size_t count, const char *const *names,
                      FILE *file)
{
    fprintf(file, "const char *const %s_%s[%zu] = {", name, kind, count);
    for (size_t i = 0; i < count; i++) {
        fprintf(file, "%s\"%s\"%s", i % 8 == 0 ? "\n    " : " ", names[i],
                i + 1 < count ? "," : "");
    }
    fputs("};\n", file);
}

void export_put_parameters(const char *name, const char *kind, const scene *of, bool single,
                           FILE *file)
{
    const size_t count = (size_t)of->parameter_count;
    const char *names[SCENE_PARAMETERS_MAX];
    double ends[2][SCENE_PARAMETERS_MAX];
    for (size_t i = 0; i < count; i++) {
        names[i] = of->parameters[i].name;
        ends[0][i] = of->parameters[i].low;
        ends[1][i] = of->parameters[i].high;
    }
    export_put_names(name, kind, count, names, file);
    for (int k = 0; k < 2; k++) {
        fprintf(file, "const %s %s_%s[%zu] = ", single ? "float" : "double", name,
                k == 0 ? "lower" : "upper", count);
        export_put_list(count, ends[k], 1, single, file);
        fputs(";\n", file);
    }
}

/* ---- files --------------------------------------------------------------------------------- */

void export_begin_source(const char *name, FILE *file)
{
    fprintf(file, "/* %s, see %s.h; written by cpinn " CPINN_VERSION ". */\n#include \"%s.h\"\n\n",
            name, name, name);
}

void export_begin_header(const char *name, FILE *file)
{
    fprintf(file,
            "#ifndef %s_H\n#define %s_H\n\n#include <stddef.h>\n\n#ifdef __cplusplus\n"
            "extern \"C\" {\n#endif\n\n",
            name, name);
}

void export_end_header(FILE *file)
{
    fputs("\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n", file);
}

void export_begin_selftest(const char *name, const char *standard, FILE *file)
{
    fprintf(
        file,
        "/* Compares %s.c with what cpinn has computed: exit 1 and a line where they differ by\n"
        " * more than rounding.\n"
        " *     cc -std=%s -O2 -o selftest %s.c %s_selftest.c -lm && ./selftest */\n"
        "#include \"%s.h\"\n\n#include <math.h>\n#include <stdio.h>\n#include <string.h>\n\n",
        name, standard, name, name, name);
}
