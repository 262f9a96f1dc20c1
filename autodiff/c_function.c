/* A whole program as one function of numbers in C99, without anything but libm: for a fixed number
 * of points, passes one after the other, matrix products as loops. Parameters and uniform values
 * that are given become constants, and with them all that follows from them. */
#include "autodiff/c_code.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK_ROWS = 32, BLOCK_NUMBERS = 160 };

/* ---- products and sums ---------------------------------------------------------------------- */

/* "120 + k * 5": row k of a block whose rows are 5 numbers apart. */
static void row_text(int offset, const char *row, int stride, char *text)
{
    snprintf(text, C_OPERAND, stride == 1 ? "%d + %s" : "%d + %s * %d", offset, row, stride);
}

/* Of `rows` rows from `first` on: a block of sums that fits into registers, one point. Columns are
 * written out, so that the innermost loop is one that any compiler vectorises. */
static void write_block(c_function *f, const instruction *i, int first, int rows, int block,
                        const char *matrix)
{
    int m = i->out.rows, k = i->in[1].rows;
    bool turned = ad_c_is_known(f, i->in[0]) || i->op == OP_MATVEC_TRANSPOSED;
    const char *type = f->w.type;
    char row[C_OPERAND];
    fprintf(f->w.file, "    for (int i = %d; i < %d; i += %d) {\n", first, first + rows, block);
    for (int c = 0; c < i->columns; c++) {
        fprintf(f->w.file, "        %s sum%d[%d] = {0};\n", type, c, block);
    }
    fprintf(f->w.file, "        for (int k = 0; k < %d; k++) {\n", k);
    for (int c = 0; c < i->columns; c++) {
        row_text(i->in[1].offset + c, "k", i->in[1].stride, row);
        fprintf(f->w.file, "            const %s x%d = w[%s];\n", type, c, row);
    }
    fprintf(f->w.file, "            for (int n = 0; n < %d; n++) {\n", block);
    fprintf(f->w.file, "                const %s a = %s", type, matrix);
    fprintf(f->w.file, turned ? "k * %d + i + n];\n" : "(i + n) * %d + k];\n", turned ? m : k);
    for (int c = 0; c < i->columns; c++) {
        fprintf(f->w.file, "                sum%d[n] += a * x%d;\n", c, c);
    }
    fprintf(f->w.file, "            }\n        }\n        for (int n = 0; n < %d; n++) {\n", block);
    for (int c = 0; c < i->columns; c++) {
        row_text(i->out.offset + c, i->out.stride == 1 ? "i + n" : "(i + n)", i->out.stride, row);
        fprintf(f->w.file, "            w[%s] = sum%d[n];\n", row, c);
    }
    fputs("        }\n    }\n", f->w.file);
}

/* Columns of several points lie side by side. */
static void write_wide(c_function *f, const instruction *i, const char *matrix)
{
    int m = i->out.rows, k = i->in[1].rows, width = i->columns * f->w.numbers;
    bool turned = ad_c_is_known(f, i->in[0]) || i->op == OP_MATVEC_TRANSPOSED;
    char entry[C_OPERAND];
    snprintf(entry, sizeof entry, turned ? "k * %d + i" : "i * %d + k", turned ? m : k);
    fprintf(f->w.file,
            "    for (int i = 0; i < %d; i++) {\n"
            "        %s sum[%d] = {0};\n"
            "        for (int k = 0; k < %d; k++) {\n"
            "            for (int n = 0; n < %d; n++) {\n"
            "                sum[n] += %s%s] * w[(%d + k * %d) * %d + n];\n"
            "            }\n        }\n"
            "        for (int n = 0; n < %d; n++) {\n"
            "            w[(%d + i * %d) * %d + n] = sum[n];\n        }\n    }\n",
            m, f->w.type, width, k, width, matrix, entry, i->in[1].offset, i->in[1].stride,
            f->w.numbers, width, i->out.offset, i->out.stride, f->w.numbers);
}

/* A matrix that is known stands turned in the C, so that sums go along its rows. */
static void write_product(c_function *f, const instruction *i)
{
    int m = i->out.rows, k = i->in[1].rows, block = BLOCK_NUMBERS / i->columns;
    bool natural = i->op == OP_MATVEC_TRANSPOSED;
    char matrix[C_OPERAND];
    c_table t = {.at = i->in[0]};
    if (!natural) {
        t.m = m;
        t.k = k;
    }
    ad_c_begin_index(f, t, matrix);
    if (f->w.numbers > 1) {
        write_wide(f, i, matrix);
        return;
    }
    block = block > BLOCK_ROWS ? BLOCK_ROWS : block < 4 ? 4 : block / 4 * 4;
    block = block > m ? m : block;
    write_block(f, i, 0, m / block * block, block, matrix);
    if (m % block > 0) {
        write_block(f, i, m / block * block, m % block, m % block, matrix);
    }
}

/* An entry of a place in a loop: row `row` at point j, or the same for all. */
static void put_entry(c_function *f, place p, const char *row, char *text)
{
    char start[C_OPERAND];
    if (p.kind == PLACE_MEMBER) {
        snprintf(text, 2 * C_OPERAND, "m[%d + %s]", p.offset, row);
        return;
    }
    if (p.kind != PLACE_TILE) {
        ad_c_begin_index(f, (c_table){.at = p}, start);
        snprintf(text, 2 * C_OPERAND, "%s%s]", start, row);
        return;
    }
    row_text(p.offset, row, p.stride, start);
    if (f->w.numbers == 1) {
        snprintf(text, 2 * C_OPERAND, "w[%s]", start);
    } else {
        snprintf(text, 2 * C_OPERAND, "w[(%s) * %d + j]", start, f->w.numbers);
    }
}

/* A matrix of its own at every point, or of the member. */
static void write_point_product(c_function *f, const instruction *i)
{
    char matrix[2 * C_OPERAND], x[2 * C_OPERAND], out[2 * C_OPERAND], entry[C_OPERAND];
    bool transposed = i->op == OP_MATVEC_TRANSPOSED;
    int m = i->out.rows, k = i->in[1].rows;
    snprintf(entry, sizeof entry, transposed ? "(k * %d + i)" : "(i * %d + k)", transposed ? m : k);
    put_entry(f, i->in[0], entry, matrix);
    put_entry(f, i->in[1], "k", x);
    put_entry(f, i->out, "i", out);
    fprintf(f->w.file,
            "    for (int i = 0; i < %d; i++) {\n        %s{\n"
            "            %s sum = 0;\n            for (int k = 0; k < %d; k++) {\n"
            "                sum += %s * %s;\n            }\n            %s = sum;\n"
            "        }\n    }\n",
            m, f->w.points, f->w.type, k, matrix, x, out);
}

static void write_outer(c_function *f, const instruction *i)
{
    char y[2 * C_OPERAND], x[2 * C_OPERAND], out[2 * C_OPERAND], entry[C_OPERAND];
    int k = i->in[1].rows;
    snprintf(entry, sizeof entry, "(i * %d + k)", k);
    put_entry(f, i->in[0], "i", y);
    put_entry(f, i->in[1], "k", x);
    put_entry(f, i->out, entry, out);
    fprintf(f->w.file,
            "    for (int i = 0; i < %d; i++) {\n        for (int k = 0; k < %d; k++) {\n"
            "            %s{\n                %s = %s * %s;\n"
            "            }\n        }\n    }\n",
            i->in[0].rows, k, f->w.points, out, y, x);
}

/* A value of the member at every point, or as it is. */
static void write_spread(c_function *f, const instruction *i)
{
    char out[2 * C_OPERAND];
    put_entry(f, i->out, "r", out);
    fprintf(f->w.file,
            "    for (int r = 0; r < %d; r++) {\n        %s{\n            %s = m[%d + r];\n"
            "        }\n    }\n",
            i->out.rows, f->w.points, out, i->in[0].offset);
}

/* u += y x^T, or u += y, summed over columns and points; m where the sum is the member's. */
static void write_sum(c_function *f, const instruction *i)
{
    bool outer = i->op == OP_OUTER_SUM, member = i->out.kind == PLACE_MEMBER;
    int columns = i->columns > 1 ? i->columns : 1, k = outer ? i->in[1].rows : 1;
    char factor[2 * C_OPERAND] = "";
    f->uses_u = f->uses_u || !member;
    if (outer) {
        snprintf(factor, sizeof factor, " * w[(%d + k * %d) * %d + j]", i->in[1].offset,
                 i->in[1].stride, f->w.numbers);
    }
    fprintf(f->w.file,
            "    for (int i = 0; i < %d; i++) {\n        for (int k = 0; k < %d; k++) {\n"
            "            for (int j = 0; j < %d; j++) {\n"
            "                %c[%d + i * %d + k] += w[(%d + i * %d) * %d + j]%s;\n"
            "            }\n        }\n    }\n",
            i->in[0].rows, k, columns * f->w.numbers, member ? 'm' : 'u', i->out.offset, k,
            i->in[0].offset, i->in[0].stride, f->w.numbers, factor);
}

static void write_other(c_function *f, const instruction *i)
{
    switch (i->op) {
    case OP_MATVEC:
    case OP_MATVEC_TRANSPOSED:
        if (i->in[0].kind == PLACE_TILE || i->in[0].kind == PLACE_MEMBER) {
            write_point_product(f, i);
        } else {
            write_product(f, i);
        }
        break;
    case OP_OUTER:
        write_outer(f, i);
        break;
    case OP_SPREAD:
        write_spread(f, i);
        break;
    default:
        write_sum(f, i);
    }
}

/* ---- passes --------------------------------------------------------------------------------- */

static void write_inputs(c_function *f, const int *units)
{
    const ad_tape *tape = f->program->tape;
    for (int i = 0; i < tape->inputs; i++) {
        if (units[i] >= 0) {
            int numbers = tape->input_rows[i] * f->w.numbers;
            fprintf(f->w.file,
                    "    for (int r = 0; r < %d; r++) {\n        w[%d + r] = inputs[%d][r];\n"
                    "    }\n",
                    numbers, units[i] * f->w.numbers, i);
        }
    }
}

static void write_outputs(c_function *f, const pass *p)
{
    char from[2 * C_OPERAND];
    for (int i = 0; i < p->output_count; i++) {
        batch_output o = p->outputs[i];
        put_entry(f, o.from, "r", from);
        fprintf(f->w.file, "    for (int r = 0; r < %d; r++) {\n        %s{\n", o.from.rows,
                f->w.points);
        fprintf(f->w.file, "            outputs[%d][", o.number);
        if (f->w.numbers == 1) {
            fputs("r", f->w.file);
        } else {
            fprintf(f->w.file, "r * %d + j", f->w.numbers);
        }
        fprintf(f->w.file, "] = %s;\n        }\n    }\n", from);
    }
}

/* What later passes need of the member. */
static void write_kept(c_function *f, const pass *p)
{
    char from[2 * C_OPERAND];
    for (int i = 0; i < p->kept_count; i++) {
        put_entry(f, p->kept[i].from, "r", from);
        fprintf(f->w.file, "    for (int r = 0; r < %d; r++) {\n        m[%d + r] = %s;\n    }\n",
                p->kept[i].from.rows, p->kept[i].number, from);
    }
}

static bool write_pass(c_function *f, int number)
{
    const pass *p = &f->program->passes[number];
    f->w.numbers = p->members ? 1 : (int)f->options->points;
    f->w.points = p->members ? "" : f->loop;
    bool ok = ad_c_begin_pass(&f->w, p);
    write_inputs(f, f->program->input_units + number * f->program->tape->inputs);
    if (p->reduced > 0) {
        f->uses_u = true;
        ad_c_write_zeros(f, 'u', p->reduced_offset, p->reduced);
    }
    ad_c_write_zeros(f, 'm', p->summed_offset, p->summed);
    for (int g = 0; ok && g < p->group_count; g++) {
        int length = ad_c_run_length(p, g);
        if (length > 0) {
            const group *last = &p->groups[g + length - 1];
            ad_c_write_segments(&f->w, p->groups[g].first, last->first + last->count);
            g += length - 1;
        } else {
            write_other(f, &p->instructions[p->groups[g].first]);
        }
    }
    write_outputs(f, p);
    write_kept(f, p);
    ad_c_end_pass(&f->w);
    return ok;
}

static void write_uniform_outputs(c_function *f)
{
    char text[C_OPERAND];
    for (int i = 0; i < f->program->outputs; i++) {
        int id = f->program->output_ids[i];
        if (f->program->tape->nodes[id].extent == AD_UNIFORM) {
            place p = f->program->places[id];
            ad_c_put_uniform(&f->w, p, -1, text);
            fprintf(f->w.file,
                    "    for (int r = 0; r < %d; r++) {\n        outputs[%d][r] = %s;\n    }\n",
                    p.rows, i, text);
        }
    }
}

static bool write_body(c_function *f)
{
    bool ok = true;
    for (int s = 0; ok && s < f->program->pass_count; s++) {
        ad_c_write_uniforms(f, &f->program->passes[s]);
        ok = write_pass(f, s);
    }
    ad_c_write_uniforms(f, &f->program->passes[f->program->pass_count]);
    write_uniform_outputs(f);
    return ok && !f->failed;
}

/* ---- the whole ------------------------------------------------------------------------------ */

static bool uses_operation(const ad_program *program, int first, int second)
{
    for (int s = 0; s <= program->pass_count; s++) {
        const pass *p = &program->passes[s];
        for (int i = 0; i < p->count; i++) {
            if (p->instructions[i].op == first || p->instructions[i].op == second) {
                return true;
            }
        }
        for (int i = 0; i < p->uniform_count; i++) {
            if (program->tape->nodes[p->uniforms[i]].op == first) {
                return true;
            }
        }
    }
    return false;
}

static void write_signature(const c_function *f, FILE *file)
{
    const char *type = f->w.type;
    fprintf(file, "void %s(const %s *const *inputs,", f->options->name, type);
    if (!f->options->uniforms) {
        fprintf(file, " const %s *const *uniforms,", type);
    }
    if (!f->options->parameters) {
        fprintf(file, " const %s *p,", type);
    }
    fprintf(file, " %s *const *outputs)", type);
}

static void write_unused(const c_function *f, FILE *file)
{
    fputs("    (void)inputs;\n", file);
    if (!f->options->uniforms) {
        fputs("    (void)uniforms;\n", file);
    }
    if (!f->options->parameters) {
        fputs("    (void)p;\n", file);
    }
}

/* What goes in and comes out. */
static void write_comment(const c_function *f, FILE *file)
{
    const ad_tape *tape = f->program->tape;
    int points = (int)f->options->points;
    fprintf(file, "/* At %d point%s%s. inputs:", points, points == 1 ? "" : "s",
            f->program->members ? " of one member" : "");
    for (int id = 0; id < tape->count; id++) {
        const node *n = &tape->nodes[id];
        if (n->op == OP_INPUT) {
            fprintf(file, " %s[%d]", ad_tape_name(tape, id), n->rows);
        }
    }
    fputs("; outputs:", file);
    for (int i = 0; i < f->program->outputs; i++) {
        fprintf(file, " [%d]", tape->nodes[f->program->output_ids[i]].rows);
    }
    fputs(points == 1 ? ". */\n" : ", rows one after the other, each of all points. */\n", file);
}

static void write_all(const c_function *f, const char *body, FILE *file)
{
    const ad_program *program = f->program;
    size_t numbers = (size_t)program->most_units * f->options->points;
    fputs("#include <math.h>\n\n", file);
    if (uses_operation(program, OP_STUMPFF, OP_STUMPFF)) {
        ad_c_text(ad_text_stumpff, file);
    }
    if (uses_operation(program, OP_TANH, OP_TANH_SUM) && !f->options->single) {
        ad_c_text(ad_text_tanh, file);
    }
    ad_c_write_tables(f, file);
    write_comment(f, file);
    write_signature(f, file);
    fputs(";\n\n", file);
    write_signature(f, file);
    fputs("\n{\n", file);
    if (numbers > 0) {
        fprintf(file, "    %s w[%zu];\n", f->w.type, numbers);
    }
    if (f->uses_u) {
        fprintf(file, "    %s u[%d];\n", f->w.type, program->uniform_count);
    }
    if (program->member_rows > 0) {
        fprintf(file, "    %s m[%d];\n", f->w.type, program->member_rows);
    }
    write_unused(f, file);
    fputs(body, file);
    fputs("}\n", file);
}

static bool is_identifier(const char *name)
{
    bool ok = *name && !isdigit((unsigned char)*name) && strlen(name) <= 30;
    for (; *name; name++) {
        ok = ok && (isalnum((unsigned char)*name) || *name == '_');
    }
    return ok;
}

ad_status ad_write_c(ad_program *program, const ad_c_options *options, FILE *file, ad_error *error)
{
    enum { POINTS_MAX = 1024 };
    c_function f = {.program = program, .options = options};
    char *body = NULL, loop[C_OPERAND] = "";
    size_t size = 0;
    if (!is_identifier(options->name) || options->points < 1 || options->points > POINTS_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "C of a program: a name of up to 30 letters, digits and _, and 1 to %d "
                       "points of a call",
                       POINTS_MAX);
    }
    f.w = (c_writer){.program = program,
                     .type = options->single ? "float" : "double",
                     .suffix = options->single ? "f" : "",
                     .numbers = (int)options->points,
                     .uniform = ad_c_put_uniform,
                     .context = &f};
    f.loop = loop;
    if (options->points > 1) {
        snprintf(loop, sizeof loop, "for (int j = 0; j < %d; j++) ", (int)options->points);
    }
    f.w.file = open_memstream(&body, &size);
    bool ok = f.w.file && ad_c_find_known(&f);
    f.w.known = f.known;
    ok = ok && write_body(&f);
    ok = f.w.file && fclose(f.w.file) == 0 && ok;
    if (ok) {
        write_all(&f, body, file);
    }
    free(body);
    free(f.known);
    free(f.tables);
    return ok ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
}
