/* Whole programs as C: what is the same at all points. It is worked out here where all that it
 * follows from is given, and stands in the C as a number or an array; else it is computed in u. */
#include "autodiff/emit/c_code.h"

#include <stdlib.h>
#include <string.h>

/* ---- numbers that are known ----------------------------------------------------------------- */

bool ad_c_is_known(const c_function *f, place p)
{
    return p.kind == PLACE_PARAMETER ? f->options->sets > 0 : f->known[p.offset];
}

static double number_at(const c_function *f, place p, int row, int set)
{
    int at = p.offset + row * p.stride;
    return p.kind == PLACE_PARAMETER
               ? f->options->parameters[set][at]
               : f->values[(size_t)set * (size_t)f->program->uniform_count + (size_t)at];
}

/* Are these rows the same in all sets? Compared by their bits. */
static bool is_same(const c_function *f, place p, int first, int rows)
{
    for (int set = 1; set < f->options->sets; set++) {
        for (int row = first; row < first + rows; row++) {
            double one = number_at(f, p, row, 0), other = number_at(f, p, row, set);
            if (memcmp(&one, &other, sizeof one) != 0) {
                return false;
            }
        }
    }
    return true;
}

/* Does a uniform node follow from what is given? Those before it have been looked at. */
static bool follows(const c_function *f, int id)
{
    const ad_tape *tape = f->program->tape;
    const node *n = &tape->nodes[id];
    bool result = n->op != OP_UNIFORM || f->options->sets > 0;
    for (int i = 0; i < n->count; i++) {
        result = result && ad_c_is_known(f, f->program->places[tape->arguments[n->first + i]]);
    }
    return result;
}

static void evaluate_sets(c_function *f, const pass *given)
{
    size_t count = (size_t)f->program->uniform_count;
    for (int set = 0; set == 0 || set < f->options->sets; set++) {
        const ad_run run = {.points = f->options->points,
                            .uniforms = f->options->sets ? f->options->uniforms[set] : NULL,
                            .parameters = f->options->sets ? f->options->parameters[set] : NULL};
        ad_uniform_evaluate(f->program, given, &run);
        memcpy(f->values + (size_t)set * count, f->program->uniform, count * sizeof *f->values);
    }
    for (size_t i = 0; i < count; i++) {
        place p = {.kind = PLACE_UNIFORM, .offset = (int)i, .rows = 1};
        f->same[i] = f->known[i] && is_same(f, p, 0, 1);
    }
}

bool ad_c_find_known(c_function *f)
{
    const pass *first = &f->program->passes[0];
    size_t count = (size_t)f->program->uniform_count,
           sets = f->options->sets ? (size_t)f->options->sets : 1;
    int *list = malloc(((size_t)first->uniform_count + 1) * sizeof *list);
    pass given = {.uniforms = list};
    f->known = ad_c_constants(f->program);
    f->same = calloc(count + 1, sizeof *f->same);
    f->values = calloc(sets * count + 1, sizeof *f->values);
    bool ok = list && f->known && f->same && f->values;
    for (int i = 0; ok && i < first->uniform_count; i++) {
        int id = first->uniforms[i];
        place p = f->program->places[id];
        if (follows(f, id)) {
            list[given.uniform_count++] = id;
            memset(f->known + p.offset, 1, (size_t)p.rows);
        }
    }
    if (ok) {
        evaluate_sets(f, &given);
    }
    free(list);
    return ok;
}

void ad_c_clear_known(c_function *f)
{
    free(f->known);
    free(f->same);
    free(f->values);
    free(f->varying);
}

/* ---- tables --------------------------------------------------------------------------------- */

/* The number of a table like this one, whose numbers are taken over. */
static int take_table(c_function *f, c_table wanted)
{
    c_tables *all = f->tables;
    size_t bytes = (size_t)wanted.sets * (size_t)wanted.rows * sizeof *wanted.numbers;
    for (int i = 0; wanted.numbers && i < all->count; i++) {
        c_table *t = &all->items[i];
        if (t->sets == wanted.sets && t->rows == wanted.rows &&
            memcmp(t->numbers, wanted.numbers, bytes) == 0) {
            free(wanted.numbers);
            return i;
        }
    }
    if (!wanted.numbers ||
        !ad_tape_grow((void **)&all->items, &all->capacity, all->count + 1, sizeof *all->items)) {
        free(wanted.numbers);
        f->failed = true;
        return 0;
    }
    all->items[all->count] = wanted;
    return all->count++;
}

/* What a parameter or an input is called, "" where it is no leaf. */
static const char *name_of(const c_function *f, place p)
{
    for (int id = 0; id < f->program->tape->count; id++) {
        place at = f->program->places[id];
        if (at.rows > 0 && at.kind == p.kind && at.offset == p.offset && at.rows == p.rows) {
            return ad_tape_name(f->program->tape, id);
        }
    }
    return "";
}

/* Of a place; with k > 0 a matrix of so many columns, turned. */
static int find_table(c_function *f, place p, int k)
{
    c_table t = {.name = name_of(f, p),
                 .turned = k > 0,
                 .sets = is_same(f, p, 0, p.rows) ? 1 : f->options->sets,
                 .rows = p.rows};
    size_t rows = (size_t)t.rows;
    int m = k > 0 ? p.rows / k : 0;
    t.numbers = malloc(((size_t)t.sets * rows + 1) * sizeof *t.numbers);
    for (int set = 0; t.numbers && set < t.sets; set++) {
        for (int row = 0; row < t.rows; row++) {
            t.numbers[(size_t)set * rows + (size_t)row] =
                number_at(f, p, k > 0 ? row % m * k + row / m : row, set);
        }
    }
    return take_table(f, t);
}

/* Where a number stands in v. */
static int find_varying(c_function *f, place p, int row)
{
    int at = p.offset + row * p.stride;
    at = p.kind == PLACE_PARAMETER ? -1 - at : at;
    for (int i = 0; i < f->varying_count; i++) {
        if (f->varying[i] == at) {
            return i;
        }
    }
    if (!ad_tape_grow((void **)&f->varying, &f->varying_capacity, f->varying_count + 1,
                      sizeof *f->varying)) {
        f->failed = true;
        return 0;
    }
    f->varying[f->varying_count] = at;
    return f->varying_count++;
}

int ad_c_varying_table(c_function *f)
{
    c_table t = {.name = "", .sets = f->options->sets, .rows = f->varying_count};
    size_t rows = (size_t)t.rows;
    if (rows == 0) {
        return -1;
    }
    t.numbers = malloc((size_t)t.sets * rows * sizeof *t.numbers);
    for (int set = 0; t.numbers && set < t.sets; set++) {
        for (size_t i = 0; i < rows; i++) {
            int at = f->varying[i];
            place p = {.kind = at < 0 ? PLACE_PARAMETER : PLACE_UNIFORM,
                       .offset = at < 0 ? -1 - at : at};
            t.numbers[(size_t)set * rows + i] = number_at(f, p, 0, set);
        }
    }
    return take_table(f, t);
}

static void write_row_of_numbers(const c_writer *w, int rows, const double *numbers, FILE *file)
{
    char text[C_OPERAND];
    for (int row = 0; row < rows; row++) {
        ad_c_number(w, numbers[row], text);
        fprintf(file, "%s%s%s", row % 4 == 0 ? "\n    " : " ", text, row + 1 < rows ? "," : "");
    }
}

/* GCC 12 copies some tables wrongly by AVX-512, {1, ... 0, ...} of 10 each, where it makes a memcpy
 * of the loop. */
static const char no_copies[] =
    "#if defined(__GNUC__) && !defined(__clang__) && defined(__AVX512F__)\n"
    "#pragma GCC optimize(\"no-tree-loop-distribute-patterns\")\n"
    "#endif\n";

void ad_c_write_tables(const c_writer *w, const c_tables *tables, FILE *file)
{
    fputs(tables->count > 0 ? no_copies : "", file);
    for (int i = 0; i < tables->count; i++) {
        const c_table *t = &tables->items[i];
        if (*t->name) {
            fprintf(file, "/* %s%s */\n", t->name, t->turned ? ", turned" : "");
        }
        fprintf(file, "static const %s %s_%d", w->type, tables->name, i);
        if (t->sets > 1) {
            fprintf(file, "[%d]", t->sets);
        }
        fprintf(file, "[%d] = {", t->rows);
        for (int set = 0; set < t->sets; set++) {
            fputs(t->sets > 1 ? "\n    {" : "", file);
            write_row_of_numbers(w, t->rows, t->numbers + (size_t)set * (size_t)t->rows, file);
            fputs(t->sets == 1 ? "" : set + 1 < t->sets ? "}," : "}", file);
        }
        fputs("};\n\n", file);
    }
}

void ad_c_clear_tables(c_tables *tables)
{
    for (int i = 0; i < tables->count; i++) {
        free(tables->items[i].numbers);
    }
    free(tables->items);
    free(tables->products);
}

void ad_c_begin_index(c_function *f, place p, int k, char *text)
{
    if (ad_c_is_known(f, p)) {
        int number = find_table(f, p, k);
        bool several = !f->failed && f->tables->items[number].sets > 1;
        snprintf(text, C_OPERAND, "%.30s_%d%s[", f->tables->name, number, several ? "[set]" : "");
        return;
    }
    f->uses_u = f->uses_u || p.kind == PLACE_UNIFORM;
    snprintf(text, C_OPERAND, "%c[%d + ", p.kind == PLACE_UNIFORM ? 'u' : 'p', p.offset);
}

void ad_c_put_uniform(const c_writer *w, place p, int row, char *text)
{
    c_function *f = w->context;
    if (row >= 0 && ad_c_is_known(f, p)) {
        if (is_same(f, p, row, 1)) {
            ad_c_number(w, number_at(f, p, row, 0), text);
        } else {
            snprintf(text, C_OPERAND - 8, "v[%d]", find_varying(f, p, row));
        }
    } else {
        char start[C_OPERAND];
        ad_c_begin_index(f, p, 0, start);
        snprintf(text, C_OPERAND - 8, row < 0 ? "%.40sr]" : "%.40s%d]", start, row * p.stride);
    }
}

/* ---- uniform values that are not known ------------------------------------------------------ */

static place argument_place(const c_function *f, const node *n, int i)
{
    return f->program->places[f->program->tape->arguments[n->first + i]];
}

/* "u[13 + r * step]" of an argument, as it is read in a loop over r. */
static void argument_text(c_function *f, place p, int step, char *text)
{
    if (step == 0) {
        ad_c_put_uniform(&f->w, p, 0, text);
    } else {
        ad_c_put_uniform(&f->w, p, -1, text);
    }
}

static void write_copy(c_function *f, int to, place from)
{
    char text[C_OPERAND];
    ad_c_put_uniform(&f->w, from, -1, text);
    fprintf(f->w.file, "    for (int r = 0; r < %d; r++) {\n        u[%d + r] = %s;\n    }\n",
            from.rows, to, text);
}

void ad_c_write_zeros(c_function *f, char memory, int to, int rows)
{
    if (rows > 0) {
        fprintf(f->w.file, "    for (int r = 0; r < %d; r++) {\n        %c[%d + r] = 0;\n    }\n",
                rows, memory, to);
    }
}

/* u[out + i m..] = sum over k; W is stored [m][k], or [k][m] transposed. */
static void write_uniform_product(c_function *f, const node *n, int out, bool transposed)
{
    char matrix[C_OPERAND], vector[C_OPERAND];
    place x = argument_place(f, n, 1);
    ad_c_begin_index(f, argument_place(f, n, 0), 0, matrix);
    ad_c_begin_index(f, x, 0, vector);
    fprintf(f->w.file,
            "    for (int i = 0; i < %d; i++) {\n        %s sum = 0;\n"
            "        for (int k = 0; k < %d; k++) {\n            sum += %s%s * %d + %s] * %sk];\n"
            "        }\n        u[%d + i] = sum;\n    }\n",
            n->rows, f->w.type, x.rows, matrix, transposed ? "k" : "i",
            transposed ? n->rows : x.rows, transposed ? "i" : "k", vector, out);
}

static void write_uniform_outer(c_function *f, const node *n, int out)
{
    char y[C_OPERAND], x[C_OPERAND];
    place b = argument_place(f, n, 1);
    ad_c_begin_index(f, argument_place(f, n, 0), 0, y);
    ad_c_begin_index(f, b, 0, x);
    fprintf(f->w.file,
            "    for (int r = 0; r < %d; r++) {\n        u[%d + r] = %sr / %d] * %sr %% %d];\n"
            "    }\n",
            n->rows, out, y, b.rows, x, b.rows);
}

static void write_uniform_elementwise(c_function *f, const node *n, int out)
{
    char operands[AD_ARITY_MAX][C_OPERAND];
    for (int i = 0; i < n->count; i++) {
        place p = argument_place(f, n, i);
        argument_text(f, p, p.rows > 1, operands[i]);
    }
    fprintf(f->w.file, "    for (int r = 0; r < %d; r++) {\n        u[%d + r] = ", n->rows, out);
    ad_c_operation(&f->w, n->op, n->whole, n->number, operands);
    fputs("    }\n", f->w.file);
}

static void write_joined(c_function *f, const node *n, int out)
{
    int row = n->op == OP_PAD ? n->whole : 0;
    ad_c_write_zeros(f, 'u', out, row);
    for (int i = 0; i < n->count; i++) {
        place p = argument_place(f, n, i);
        write_copy(f, out + row, p);
        row += p.rows;
    }
    ad_c_write_zeros(f, 'u', out + row, n->rows - row);
}

static void write_uniform(c_function *f, int id)
{
    const node *n = &f->program->tape->nodes[id];
    int out = f->program->places[id].offset;
    char text[C_OPERAND];
    f->uses_u = true;
    switch (ad_op_table[n->op].form) {
    case FORM_LEAF: /* a uniform */
        fprintf(f->w.file,
                "    for (int r = 0; r < %d; r++) {\n        u[%d + r] = uniforms[%d][r];\n    }\n",
                n->rows, out, n->whole);
        break;
    case FORM_JOIN:
        write_joined(f, n, out);
        break;
    case FORM_SUM_ROWS:
        ad_c_put_uniform(&f->w, argument_place(f, n, 0), -1, text);
        fprintf(f->w.file,
                "    u[%d] = 0;\n    for (int r = 0; r < %d; r++) {\n        u[%d] += %s;\n    }\n",
                out, argument_place(f, n, 0).rows, out, text);
        break;
    case FORM_PRODUCT:
        write_uniform_product(f, n, out, n->op == OP_MATVEC_TRANSPOSED);
        break;
    case FORM_OUTER:
        write_uniform_outer(f, n, out);
        break;
    default:
        write_uniform_elementwise(f, n, out);
    }
}

void ad_c_write_uniforms(c_function *f, const pass *p)
{
    for (int i = 0; i < p->uniform_count; i++) {
        if (!f->known[f->program->places[p->uniforms[i]].offset]) {
            write_uniform(f, p->uniforms[i]);
        }
    }
}
