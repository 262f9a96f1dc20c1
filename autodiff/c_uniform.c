/* Whole programs as C: what is the same at all points. It is worked out here where all that it
 * follows from is given, and stands in the C as a number or an array; else it is computed in u. */
#include "autodiff/c_code.h"

#include <stdlib.h>
#include <string.h>

/* ---- numbers that are known ----------------------------------------------------------------- */

bool ad_c_is_known(const c_function *f, place p)
{
    return p.kind == PLACE_PARAMETER ? f->options->parameters != NULL : f->known[p.offset];
}

static double number_at(const c_function *f, place p, int row)
{
    int at = p.offset + row * p.stride;
    return p.kind == PLACE_PARAMETER ? f->options->parameters[at] : f->program->uniform[at];
}

/* Does a uniform node follow from what is given? Those before it have been looked at. */
static bool follows(const c_function *f, int id)
{
    const ad_tape *tape = f->program->tape;
    const node *n = &tape->nodes[id];
    bool result = n->op != OP_UNIFORM || f->options->uniforms != NULL;
    for (int i = 0; i < n->count; i++) {
        result = result && ad_c_is_known(f, f->program->places[tape->arguments[n->first + i]]);
    }
    return result;
}

bool ad_c_find_known(c_function *f)
{
    const pass *first = &f->program->passes[0];
    const ad_run run = {.points = f->options->points,
                        .uniforms = f->options->uniforms,
                        .parameters = f->options->parameters};
    int *list = malloc(((size_t)first->uniform_count + 1) * sizeof *list);
    pass given = {.uniforms = list};
    f->known = ad_c_constants(f->program);
    for (int i = 0; list && f->known && i < first->uniform_count; i++) {
        int id = first->uniforms[i];
        place p = f->program->places[id];
        if (follows(f, id)) {
            list[given.uniform_count++] = id;
            memset(f->known + p.offset, 1, (size_t)p.rows);
        }
    }
    if (list && f->known) {
        ad_uniform_evaluate(f->program, &given, &run);
    }
    free(list);
    return list && f->known;
}

static int find_table(c_function *f, c_table wanted)
{
    for (int i = 0; i < f->table_count; i++) {
        c_table t = f->tables[i];
        if (t.at.kind == wanted.at.kind && t.at.offset == wanted.at.offset &&
            t.at.rows == wanted.at.rows && t.m == wanted.m && t.k == wanted.k) {
            return i;
        }
    }
    if (!ad_tape_grow((void **)&f->tables, &f->table_capacity, f->table_count + 1,
                      sizeof *f->tables)) {
        f->failed = true;
        return 0;
    }
    f->tables[f->table_count] = wanted;
    return f->table_count++;
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

void ad_c_write_tables(const c_function *f, FILE *file)
{
    char text[C_OPERAND];
    for (int i = 0; i < f->table_count; i++) {
        c_table t = f->tables[i];
        const char *name = name_of(f, t.at);
        if (*name) {
            fprintf(file, "/* %s%s */\n", name, t.m ? ", turned" : "");
        }
        fprintf(file, "static const %s %s_%d[%d] = {", f->w.type, f->options->name, i, t.at.rows);
        for (int row = 0; row < t.at.rows; row++) {
            ad_c_number(&f->w, number_at(f, t.at, t.m ? row % t.m * t.k + row / t.m : row), text);
            fprintf(file, "%s%s%s", row % 4 == 0 ? "\n    " : " ", text,
                    row + 1 < t.at.rows ? "," : "};\n\n");
        }
    }
}

void ad_c_begin_index(c_function *f, c_table t, char *text)
{
    if (ad_c_is_known(f, t.at)) {
        snprintf(text, C_OPERAND, "%.30s_%d[", f->options->name, find_table(f, t));
        return;
    }
    f->uses_u = f->uses_u || t.at.kind == PLACE_UNIFORM;
    f->uses_p = f->uses_p || t.at.kind == PLACE_PARAMETER;
    snprintf(text, C_OPERAND, "%c[%d + ", t.at.kind == PLACE_UNIFORM ? 'u' : 'p', t.at.offset);
}

void ad_c_put_uniform(const c_writer *w, place p, int row, char *text)
{
    c_function *f = w->context;
    if (row >= 0 && ad_c_is_known(f, p)) {
        ad_c_number(w, number_at(f, p, row), text);
    } else {
        char start[C_OPERAND];
        ad_c_begin_index(f, (c_table){.at = p}, start);
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
    ad_c_begin_index(f, (c_table){.at = argument_place(f, n, 0)}, matrix);
    ad_c_begin_index(f, (c_table){.at = x}, vector);
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
    ad_c_begin_index(f, (c_table){.at = argument_place(f, n, 0)}, y);
    ad_c_begin_index(f, (c_table){.at = b}, x);
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
    switch (n->op) {
    case OP_UNIFORM:
        fprintf(f->w.file,
                "    for (int r = 0; r < %d; r++) {\n        u[%d + r] = uniforms[%d][r];\n    }\n",
                n->rows, out, n->whole);
        break;
    case OP_STACK:
    case OP_PAD:
        write_joined(f, n, out);
        break;
    case OP_SUM_ROWS:
        ad_c_put_uniform(&f->w, argument_place(f, n, 0), -1, text);
        fprintf(f->w.file,
                "    u[%d] = 0;\n    for (int r = 0; r < %d; r++) {\n        u[%d] += %s;\n    }\n",
                out, argument_place(f, n, 0).rows, out, text);
        break;
    case OP_MATVEC:
    case OP_MATVEC_TRANSPOSED:
        write_uniform_product(f, n, out, n->op == OP_MATVEC_TRANSPOSED);
        break;
    case OP_OUTER:
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
