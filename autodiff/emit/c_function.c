/* A whole program as one function of numbers in C99, without anything but libm: for a fixed number
 * of points, passes one after the other, matrix products as loops. Parameters and uniform values
 * that are given become constants, and with them all that follows from them. */
#include "autodiff/emit/c_code.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

enum {
    BLOCK_ROWS = 32,
    BLOCK_NUMBERS = 160,
    TERMS = 4,
    FEW_TERMS = 8, /* of a sum: one chain of additions waits no longer than several would take */
    TERMS_NUMBERS = 64,
    C_ENTRY = 2 * C_OPERAND /* characters */
};

/* ---- products and sums ---------------------------------------------------------------------- */

/* "120 + k * 5": row k of a block whose rows are 5 numbers apart. */
static void row_text(int offset, const char *row, int stride, char *text)
{
    snprintf(text, C_OPERAND, stride == 1 ? "%d + %s" : "%d + %s * %d", offset, row, stride);
}

/* A block of sums that fits into registers: rows i .. i + rows - 1 of a product, one point, for k
 * from `from` on, `terms` of them at a time, each into sums of its own, so that one addition does
 * not wait for another. */
static void write_terms(const c_writer *w, const c_product *p, int rows, int terms, int from,
                        int to)
{
    char row[C_OPERAND], at[24];
    if (from == to) {
        return;
    }
    fprintf(w->file, "        for (int k = %d; k < %d; k += %d) {\n", from, to, terms);
    for (int q = 0; q < terms; q++) {
        snprintf(at, sizeof at, terms > 1 ? "(k + %d)" : "k", q);
        for (int c = 0; c < p->columns; c++) {
            row_text(c, at, p->x_stride, row);
            fprintf(w->file, "            const %s x%d_%d = x[%s];\n", w->type, c, q, row);
        }
    }
    fprintf(w->file, "            AD_UNROLL\n            for (int n = 0; n < %d; n++) {\n", rows);
    for (int q = 0; q < terms; q++) {
        snprintf(at, sizeof at, terms > 1 ? "(k + %d)" : "k", q);
        fprintf(w->file, "                const %s a%d = a[", w->type, q);
        if (p->turned) {
            fprintf(w->file, "%s * %d + i + n];\n", at, p->rows);
        } else {
            fprintf(w->file, "(i + n) * %d + %s];\n", p->terms, at);
        }
        for (int c = 0; c < p->columns; c++) {
            fprintf(w->file, "                sum%d_%d[n] += a%d * x%d_%d;\n", c, q, q, c, q);
        }
    }
    fputs("            }\n        }\n", w->file);
}

/* Of `rows` rows from `first` on, `block` at a time. Columns are written out, so that the innermost
 * loop is one that any compiler vectorises. */
static void write_block(const c_writer *w, const c_product *p, int first, int rows, int block)
{
    int k = p->terms, terms = 1;
    char row[C_OPERAND];
    while (k > FEW_TERMS && terms < TERMS && 2 * terms * block * p->columns <= TERMS_NUMBERS &&
           2 * terms <= k) {
        terms *= 2;
    }
    fprintf(w->file, "    for (int i = %d; i < %d; i += %d) {\n", first, first + rows, block);
    for (int s = 0; s < p->columns * terms; s++) {
        fprintf(w->file, "        %s sum%d_%d[%d] = {0};\n", w->type, s / terms, s % terms, block);
    }
    write_terms(w, p, block, terms, 0, k / terms * terms);
    write_terms(w, p, block, 1, k / terms * terms, k);
    fprintf(w->file, "        AD_UNROLL\n        for (int n = 0; n < %d; n++) {\n", block);
    for (int c = 0; c < p->columns; c++) {
        row_text(c, p->y_stride == 1 ? "i + n" : "(i + n)", p->y_stride, row);
        fprintf(w->file, "            y[%s] = ", row);
        for (int q = 0; q < terms; q++) {
            fprintf(w->file, "%ssum%d_%d[n]", q ? " + " : "", c, q);
        }
        fputs(";\n", w->file);
    }
    fputs("        }\n    }\n", w->file);
}

/* Columns of several points lie side by side. */
static void write_wide(const c_writer *w, const c_product *p)
{
    char entry[C_OPERAND];
    snprintf(entry, sizeof entry, p->turned ? "k * %d + i" : "i * %d + k",
             p->turned ? p->rows : p->terms);
    fprintf(w->file,
            "    for (int i = 0; i < %d; i++) {\n"
            "        %s sum[%d] = {0};\n"
            "        for (int k = 0; k < %d; k++) {\n"
            "            for (int n = 0; n < %d; n++) {\n"
            "                sum[n] += a[%s] * x[k * %d + n];\n"
            "            }\n        }\n"
            "        for (int n = 0; n < %d; n++) {\n"
            "            y[i * %d + n] = sum[n];\n        }\n    }\n",
            p->rows, w->type, p->columns, p->terms, p->columns, entry, p->x_stride, p->columns,
            p->y_stride);
}

/* One function for all products that are alike. */
static void write_product_function(const c_writer *w, const c_tables *tables, int number)
{
    const c_product *p = &tables->products[number];
    int block = BLOCK_NUMBERS / p->columns;
    fprintf(w->file, "static void %.30s_product_%d(const %s *a, const %s *x, %s *y)\n{\n",
            tables->name, number, w->type, w->type, w->type);
    block = block > BLOCK_ROWS ? BLOCK_ROWS : block < 4 ? 4 : block / 4 * 4;
    block = block > p->rows ? p->rows : block;
    if (p->wide) {
        write_wide(w, p);
    } else {
        write_block(w, p, 0, p->rows / block * block, block);
    }
    if (!p->wide && p->rows % block > 0) {
        write_block(w, p, p->rows / block * block, p->rows % block, p->rows % block);
    }
    fputs("}\n\n", w->file);
}

static bool is_alike(const c_product *a, const c_product *b)
{
    return a->rows == b->rows && a->terms == b->terms && a->columns == b->columns &&
           a->x_stride == b->x_stride && a->y_stride == b->y_stride && a->wide == b->wide &&
           a->turned == b->turned;
}

/* The number of a product; -1: out of memory. */
static int find_product(c_tables *tables, const c_product *p)
{
    int i = 0;
    while (i < tables->product_count && !is_alike(&tables->products[i], p)) {
        i++;
    }
    if (i == tables->product_capacity) {
        int capacity = 2 * i + 8;
        c_product *more = realloc(tables->products, (size_t)capacity * sizeof *more);
        if (!more) {
            return -1;
        }
        tables->products = more;
        tables->product_capacity = capacity;
    }
    if (i == tables->product_count) {
        tables->products[tables->product_count++] = *p;
    }
    return i;
}

/* A matrix that is known stands turned in the C, so that sums go along its rows. */
static void write_product(c_function *f, const instruction *i)
{
    const int numbers = f->w.numbers, k = i->in[1].rows;
    const bool natural = i->op == OP_MATVEC_TRANSPOSED;
    const c_product p = {.rows = i->out.rows,
                         .terms = k,
                         .columns = i->columns * numbers,
                         .x_stride = i->in[1].stride * numbers,
                         .y_stride = i->out.stride * numbers,
                         .wide = numbers > 1,
                         .turned = natural || ad_c_is_known(f, i->in[0])};
    char matrix[C_OPERAND];
    const int number = find_product(f->tables, &p);
    ad_c_begin_index(f, i->in[0], natural ? 0 : k, matrix);
    f->failed = f->failed || number < 0;
    fprintf(f->w.file, "    %.30s_product_%d(&%s0], w + %d, w + %d);\n", f->tables->name, number,
            matrix, i->in[1].offset * numbers, i->out.offset * numbers);
}

/* An entry of a place in a loop: row `row` at point j, or the same for all; to text [C_ENTRY]. */
static void put_entry(c_function *f, place p, const char *row, char *text)
{
    char start[C_OPERAND];
    if (p.kind == PLACE_MEMBER) {
        snprintf(text, C_ENTRY, "m[%d + %s]", p.offset, row);
        return;
    }
    if (p.kind != PLACE_TILE) {
        ad_c_begin_index(f, p, 0, start);
        snprintf(text, C_ENTRY, "%s%s]", start, row);
        return;
    }
    row_text(p.offset, row, p.stride, start);
    if (f->w.numbers == 1) {
        snprintf(text, C_ENTRY, "w[%s]", start);
    } else {
        snprintf(text, C_ENTRY, "w[(%s) * %d + j]", start, f->w.numbers);
    }
}

/* A matrix of its own at every point, or of the member. */
static void write_point_product(c_function *f, const instruction *i)
{
    char matrix[C_ENTRY], x[C_ENTRY], out[C_ENTRY], entry[C_OPERAND];
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
    char y[C_ENTRY], x[C_ENTRY], out[C_ENTRY], entry[C_OPERAND];
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

/* Values of the member at every point, or as they are: of `count` instructions in turn, by a table
 * of where they go, their rows and where they are from. */
static void write_spreads(c_function *f, const instruction *first, int count)
{
    fprintf(f->w.file, "    {\n        static const int to[%d][4] = {", count);
    for (int k = 0; k < count; k++) {
        const instruction *i = &first[k];
        fprintf(f->w.file, "%s{%d, %d, %d, %d}",
                k == 0  ? ""
                : k % 4 ? ", "
                        : ",\n            ",
                i->out.offset, i->out.stride, i->out.rows, i->in[0].offset);
    }
    fprintf(f->w.file,
            "};\n        for (int i = 0; i < %d; i++) {\n"
            "            for (int r = 0; r < to[i][2]; r++) {\n"
            "                const %s x = m[to[i][3] + r];\n"
            "                %s{\n                    w[(to[i][0] + r * to[i][1]) * %d%s] = x;\n"
            "                }\n            }\n        }\n    }\n",
            count, f->w.type, f->w.points, f->w.numbers, f->w.numbers > 1 ? " + j" : "");
}

/* How many groups from `group` on are one spread each, of instructions that follow one another. */
static int spreads_from(const pass *p, int group)
{
    int count = 0;
    while (group + count < p->group_count && p->groups[group + count].count == 1 &&
           p->groups[group + count].first == p->groups[group].first + count &&
           p->instructions[p->groups[group + count].first].op == OP_SPREAD) {
        count++;
    }
    return count;
}

/* u += y x^T, or u += y, summed over columns and points; m where the sum is the member's. */
static void write_sum(c_function *f, const instruction *i)
{
    bool outer = i->op == OP_OUTER_SUM, member = i->out.kind == PLACE_MEMBER;
    int columns = i->columns > 1 ? i->columns : 1, k = outer ? i->in[1].rows : 1;
    char factor[C_ENTRY] = "";
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
    if (op_is_matvec(i->op)) {
        bool own = i->in[0].kind == PLACE_TILE || i->in[0].kind == PLACE_MEMBER;
        (own ? write_point_product : write_product)(f, i);
    } else {
        (i->op == OP_OUTER ? write_outer : write_sum)(f, i);
    }
}

/* ---- passes --------------------------------------------------------------------------------- */

/* Numbers of one row of an input or output: one, or one per point. */
static int numbers_of(const c_function *f, int extent)
{
    return extent == AD_BATCH ? (int)f->options->points : 1;
}

static void write_inputs(c_function *f, const int *units)
{
    const ad_tape *tape = f->program->tape;
    int first = 0;
    for (int i = 0; i < tape->inputs; i++) {
        int numbers = tape->input_rows[i] * numbers_of(f, tape->input_extent[i]);
        int to = units[i] * f->w.numbers;
        if (to >= 0 && numbers == 1) {
            fprintf(f->w.file, "    w[%d] = x[%d];\n", to, first);
        } else if (to >= 0) {
            fprintf(f->w.file,
                    "    for (int r = 0; r < %d; r++) {\n        w[%d + r] = x[%d + r];\n    }\n",
                    numbers, to, first);
        }
        first += numbers;
    }
}

/* Where an output begins in y. */
static int output_at(const c_function *f, int output)
{
    int first = 0;
    for (int i = 0; i < output; i++) {
        const node *n = &f->program->tape->nodes[f->program->output_ids[i]];
        first += n->rows * numbers_of(f, n->extent);
    }
    return first;
}

static void write_outputs(c_function *f, const pass *p)
{
    char from[C_ENTRY];
    for (int i = 0; i < p->output_count; i++) {
        batch_output o = p->outputs[i];
        int to = output_at(f, o.number);
        if (f->w.numbers == 1 && o.from.rows == 1) {
            put_entry(f, o.from, "0", from);
            fprintf(f->w.file, "    y[%d] = %s;\n", to, from);
            continue;
        }
        put_entry(f, o.from, "r", from);
        fprintf(f->w.file, "    for (int r = 0; r < %d; r++) {\n        %s{\n", o.from.rows,
                f->w.points);
        fprintf(f->w.file,
                f->w.numbers == 1 ? "            y[%d + r" : "            y[%d + r * %d + j", to,
                f->w.numbers);
        fprintf(f->w.file, "] = %s;\n        }\n    }\n", from);
    }
}

/* What later passes need of the member. */
static void write_kept(c_function *f, const pass *p)
{
    char from[C_ENTRY];
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
        int length = ad_c_run_length(p, g), spreads = spreads_from(p, g);
        if (spreads > 0) {
            write_spreads(f, &p->instructions[p->groups[g].first], spreads);
            g += spreads - 1;
        } else if (length > 0) {
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
                    "    for (int r = 0; r < %d; r++) {\n        y[%d + r] = %s;\n    }\n", p.rows,
                    output_at(f, i), text);
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

static void write_signature(const c_function *f, FILE *file)
{
    const char *type = f->w.type;
    fprintf(file, "%svoid %s(%sconst %s *x,", f->options->internal ? "static " : "",
            f->options->name, f->options->sets > 1 ? "int set, " : "", type);
    if (f->options->sets == 0) {
        fprintf(file, " const %s *const *uniforms, const %s *p,", type, type);
    }
    fprintf(file, " %s *y, %s *w)", type, type);
}

/* What goes in and comes out. */
static void write_comment(const c_function *f, FILE *file)
{
    const ad_tape *tape = f->program->tape;
    int points = (int)f->options->points;
    fprintf(file, "/* At %d point%s%s. x:", points, points == 1 ? "" : "s",
            f->program->members ? " of one member" : "");
    for (int id = 0; id < tape->count; id++) {
        const node *n = &tape->nodes[id];
        if (n->op == OP_INPUT) {
            fprintf(file, " %s[%d]", ad_tape_name(tape, id), n->rows);
        }
    }
    fputs("; y:", file);
    for (int i = 0; i < f->program->outputs; i++) {
        fprintf(file, " [%d]", tape->nodes[f->program->output_ids[i]].rows);
    }
    fputs(points == 1 ? ". */\n" : ", rows one after the other, each of all points. */\n", file);
}

/* The function around its body; returns the numbers of workspace it needs. */
static size_t write_function(c_function *f, const char *body, FILE *file)
{
    const ad_program *program = f->program;
    size_t numbers = (size_t)program->most_units * f->options->points;
    int varying = ad_c_varying_table(f);
    write_comment(f, file);
    if (!f->options->internal) {
        write_signature(f, file);
        fputs(";\n\n", file);
    }
    write_signature(f, file);
    fputs("\n{\n", file);
    if (f->uses_u) {
        fprintf(file, "    %s *const u = w + %zu;\n", f->w.type, numbers);
        numbers += (size_t)program->uniform_count;
    }
    if (program->member_rows > 0) {
        fprintf(file, "    %s *const m = w + %zu;\n", f->w.type, numbers);
        numbers += (size_t)program->member_rows;
    }
    if (varying >= 0) {
        fprintf(file, "    const %s *const v = %s_%d[set];\n", f->w.type, f->tables->name, varying);
    }
    fputs(f->options->sets == 0  ? "    (void)uniforms;\n    (void)p;\n"
          : f->options->sets > 1 ? "    (void)set;\n"
                                 : "",
          file);
    fputs("    (void)x;\n    (void)w;\n", file);
    fputs(body, file);
    fputs("}\n\n", file);
    return numbers;
}

static bool is_identifier(const char *name)
{
    bool ok = *name && !isdigit((unsigned char)*name) && strlen(name) <= 30;
    for (; *name; name++) {
        ok = ok && (isalnum((unsigned char)*name) || *name == '_');
    }
    return ok;
}

/* One function to `file`, what it needs to `tables`. */
static bool write_one(ad_program *program, const ad_c_options *options, c_writer w,
                      c_tables *tables, FILE *file, size_t *numbers)
{
    c_function f = {.program = program, .options = options, .tables = tables, .w = w};
    char *body = NULL, loop[C_OPERAND] = "";
    size_t size = 0;
    if (options->points > 1) {
        snprintf(loop, sizeof loop, "for (int j = 0; j < %d; j++) ", (int)options->points);
    }
    f.w.program = program;
    f.loop = loop;
    f.w.uniform = ad_c_put_uniform;
    f.w.context = &f;
    f.w.file = open_memstream(&body, &size);
    bool ok = f.w.file && ad_c_find_known(&f);
    f.w.known = f.same;
    ok = ok && write_body(&f);
    ok = f.w.file && fclose(f.w.file) == 0 && ok;
    if (ok) {
        *numbers = write_function(&f, body, file);
    }
    free(body);
    ad_c_clear_known(&f);
    return ok && !f.failed;
}

/* Functions of our own that the code calls. */
static void write_texts(const char *code, const c_tables *tables, FILE *file)
{
    const struct {
        const char *name;
        const char *const *lines;
    } texts[] = {
        {"ad_stumpff_number(", ad_text_stumpff}, {"ad_stumpff_single(", ad_text_stumpff_single},
        {"ad_tanh_number(", ad_text_tanh},       {"ad_tanh_single(", ad_text_tanh_single},
        {"ad_sine_number(", ad_text_sine},       {"ad_sine_single(", ad_text_sine_single},
        {"ad_exp_number(", ad_text_exp},         {"ad_exp_single(", ad_text_exp_single}};
    fputs("#include <math.h>\n\n", file);
    if (tables->product_count > 0) { /* gcc -O2 makes vectors of loops but leaves them loops */
        fputs("#if defined(__GNUC__) && __GNUC__ >= 8 && !defined(__clang__)\n"
              "#define AD_UNROLL _Pragma(\"GCC unroll 8\")\n#else\n#define AD_UNROLL\n#endif\n\n",
              file);
    }
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        if (strstr(code, texts[i].name)) {
            ad_c_text(texts[i].lines, file);
        }
    }
}

ad_status ad_write_c(int count, ad_program *const *programs, const ad_c_options *options,
                     bool single, FILE *file, size_t *memory, ad_error *error)
{
    enum { POINTS_MAX = 1024 };
    const c_writer w = {.type = single ? "float" : "double", .suffix = single ? "f" : ""};
    c_tables tables = {.name = options[0].name};
    char *code = NULL;
    size_t size = 0, numbers = 0;
    for (int i = 0; i < count; i++) {
        if (!is_identifier(options[i].name) || options[i].points < 1 ||
            options[i].points > POINTS_MAX) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "C of a program: a name of up to 30 letters, digits and _, and 1 to %d "
                           "points of a call",
                           POINTS_MAX);
        }
    }
    FILE *functions = open_memstream(&code, &size);
    bool ok = functions != NULL;
    *memory = 0;
    for (int i = 0; i < count && ok; i++) {
        ok = write_one(programs[i], &options[i], w, &tables, functions, &numbers);
        *memory = numbers > *memory ? numbers : *memory;
    }
    ok = functions && fclose(functions) == 0 && ok;
    if (ok) {
        write_texts(code, &tables, file);
        ad_c_write_tables(&w, &tables, file);
        for (int i = 0; i < tables.product_count; i++) {
            write_product_function(&(c_writer){.file = file, .type = w.type}, &tables, i);
        }
        fputs(code, file);
    }
    free(code);
    ad_c_clear_tables(&tables);
    return ok ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
}
