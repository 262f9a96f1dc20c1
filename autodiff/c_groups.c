/* Elementwise groups as C. A run of them, which lies between two matrix products, is one function;
 * its values stay in registers unless something after it reads them. Where rows are few all are
 * written out; blocks of many rows become loops over rows. */
#include "autodiff/c_code.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    FEW_ROWS = 8,     /* written out */
    STATEMENTS = 400, /* in one loop over points: what a compiler is quick with */
    IN_A_LOOP = 96    /* instructions in one loop over rows */
};

/* What holds a value: a variable of the segment at work. */
typedef struct held {
    place at;
    int variable;
} held;

typedef struct writer {
    const ad_program *program;
    const pass *pass;
    FILE *file;
    int *end; /* [instructions] the instruction after its segment */
    lives lives;
    int *holder;    /* [units] variable of a row, -1 */
    bool *constant; /* [uniform memory] known when the program was compiled */
    held held[5 * IN_A_LOOP];
    int held_count, variables;
} writer;

int ad_c_run_length(const pass *p, int group)
{
    int count = 0;
    while (group + count < p->group_count &&
           op_is_elementwise(p->instructions[p->groups[group + count].first].op)) {
        count++;
    }
    return count;
}

void ad_c_text(const char *const *lines, FILE *file)
{
    for (; *lines; lines++) {
        fputs(*lines, file);
    }
}

void ad_c_number(double number, FILE *file)
{
    char text[40];
    snprintf(text, sizeof text, "%.17g", number);
    fprintf(file, "%s%s", text, strpbrk(text, ".en") ? "" : ".0");
}

/* ---- segments ------------------------------------------------------------------------------- */

static bool fits_loop(const pass *p, int first, int next)
{
    if (p->instructions[next].out.rows != p->instructions[first].out.rows ||
        next - first >= IN_A_LOOP) {
        return false;
    }
    for (int i = first; i < next; i++) {
        if (ad_instructions_conflict(&p->instructions[i], &p->instructions[next])) {
            return false;
        }
    }
    return true;
}

static int segment_end(const pass *p, int first, int end)
{
    int next = first, rows = 0;
    if (!op_is_elementwise(p->instructions[first].op)) {
        return first + 1;
    }
    if (p->instructions[first].out.rows > FEW_ROWS) {
        while (next < end && fits_loop(p, first, next)) {
            next++;
        }
        return next;
    }
    while (next < end && p->instructions[next].out.rows <= FEW_ROWS &&
           rows + p->instructions[next].out.rows <= STATEMENTS) {
        rows += p->instructions[next++].out.rows;
    }
    return next;
}

/* ---- one segment ---------------------------------------------------------------------------- */

static bool kept(const writer *w, int n, int row)
{
    return w->lives.kept[w->lives.first[n] + (size_t)row];
}

static int unit_of(place p, int row)
{
    return p.offset + row * p.stride;
}

/* "u[12]", or the number that is known to stand there. */
static void put_uniform(const writer *w, place p, int row)
{
    int at = unit_of(p, row);
    if (p.kind == PLACE_UNIFORM && w->constant[at] && isfinite(w->program->uniform[at])) {
        ad_c_number(w->program->uniform[at], w->file);
    } else {
        fprintf(w->file, "%c[%d]", p.kind == PLACE_UNIFORM ? 'u' : 'p', at);
    }
}

/* "v_mul_add(x1, x2, x3)" from operands written by `put`. */
static void put_operation(writer *w, const instruction *i, int row,
                          void (*put)(writer *w, place p, int row))
{
    static const char *const infix[] = {[OP_ADD] = " + ", [OP_SUB] = " - ", [OP_MUL] = " * "};
    int arity = ad_op_table[i->op].arity;
    bool copy = i->op == OP_COPY || i->op == OP_REPEAT;
    const char *between = i->op <= OP_MUL ? infix[i->op] : ", ";
    if (i->op > OP_MUL && !copy) {
        fprintf(w->file, "v_%s(", ad_op_table[i->op].name);
    }
    for (int k = 0; k < arity; k++) {
        fputs(k > 0 ? between : "", w->file);
        put(w, i->in[k], row);
    }
    if (i->op == OP_POWER || op_is_scaled(i->op)) {
        fputs(", ", w->file);
        ad_c_number(i->number, w->file);
    } else if (i->op == OP_STUMPFF) {
        fprintf(w->file, ", %d", i->whole);
    }
    fputs(i->op > OP_MUL && !copy ? ");\n" : ";\n", w->file);
}

static void put_held(writer *w, place p, int row)
{
    if (p.kind == PLACE_TILE) {
        fprintf(w->file, "x%d", w->holder[unit_of(p, row)]);
    } else {
        fputs("splat(", w->file);
        put_uniform(w, p, row);
        fputc(')', w->file);
    }
}

/* All rows written out. */
static void write_statements(writer *w, int first, int end)
{
    w->variables = 0;
    memset(w->holder, -1, (size_t)w->pass->units * sizeof *w->holder);
    fputs("    for (int j = 0; j < points; j += LANES) {\n", w->file);
    for (int n = first; n < end; n++) {
        const instruction *i = &w->pass->instructions[n];
        for (int row = 0; row < i->out.rows; row++) {
            for (int k = 0; k < ad_op_table[i->op].arity; k++) {
                int unit = unit_of(i->in[k], row);
                if (i->in[k].kind == PLACE_TILE && w->holder[unit] < 0) {
                    w->holder[unit] = w->variables++;
                    fprintf(w->file, "        const vec x%d = AT(%d);\n", w->holder[unit], unit);
                }
            }
            fprintf(w->file, "        const vec x%d = ", w->variables);
            put_operation(w, i, row, put_held);
            w->holder[unit_of(i->out, row)] = w->variables;
            if (kept(w, n, row)) {
                fprintf(w->file, "        AT(%d) = x%d;\n", unit_of(i->out, row), w->variables);
            }
            w->variables++;
        }
    }
    fputs("    }\n", w->file);
}

/* The variable of a row of a block; -1: none yet. */
static int find_held(const writer *w, place p)
{
    for (int i = w->held_count - 1; i >= 0; i--) {
        place at = w->held[i].at;
        if (at.kind == p.kind && at.offset == p.offset && at.stride == p.stride) {
            return w->held[i].variable;
        }
    }
    return -1;
}

static int hold(writer *w, place p)
{
    w->held[w->held_count++] = (held){p, w->variables};
    return w->variables++;
}

static bool is_inline(place p)
{
    return p.kind != PLACE_TILE && p.stride == 0;
}

static void put_row_held(writer *w, place p, int row)
{
    if (is_inline(p)) {
        put_held(w, p, row);
    } else {
        fprintf(w->file, "x%d", find_held(w, p));
    }
}

/* "ROW(120, 5)", row r of a block whose rows are 5 units apart. */
static void put_row(const writer *w, place p)
{
    if (p.stride == 0) {
        fprintf(w->file, "AT(%d)", p.offset);
    } else {
        fprintf(w->file, "ROW(%d, %d)", p.offset, p.stride);
    }
}

/* A loop over rows. */
static void write_rows(writer *w, int first, int end)
{
    w->variables = w->held_count = 0;
    fprintf(w->file, "    for (int r = 0; r < %d; r++) {\n", w->pass->instructions[first].out.rows);
    for (int n = first; n < end; n++) {
        const instruction *i = &w->pass->instructions[n];
        for (int k = 0; k < ad_op_table[i->op].arity; k++) {
            place p = i->in[k];
            if (p.kind != PLACE_TILE && !is_inline(p) && find_held(w, p) < 0) {
                fprintf(w->file, "        const vec x%d = splat(%c[%d + r]);\n", hold(w, p),
                        p.kind == PLACE_UNIFORM ? 'u' : 'p', p.offset);
            }
        }
    }
    fputs("        for (int j = 0; j < points; j += LANES) {\n", w->file);
    for (int n = first; n < end; n++) {
        const instruction *i = &w->pass->instructions[n];
        bool keep = false;
        for (int row = 0; row < i->out.rows; row++) {
            keep = keep || kept(w, n, row);
        }
        for (int k = 0; k < ad_op_table[i->op].arity; k++) {
            if (i->in[k].kind == PLACE_TILE && find_held(w, i->in[k]) < 0) {
                fprintf(w->file, "            const vec x%d = ", hold(w, i->in[k]));
                put_row(w, i->in[k]);
                fputs(";\n", w->file);
            }
        }
        fprintf(w->file, "            const vec x%d = ", w->variables);
        put_operation(w, i, 0, put_row_held);
        int variable = hold(w, i->out);
        if (keep) {
            fputs("            ", w->file);
            put_row(w, i->out);
            fprintf(w->file, " = x%d;\n", variable);
        }
    }
    fputs("        }\n    }\n", w->file);
}

/* ---- functions ------------------------------------------------------------------------------ */

static void write_run(writer *w, int number, int first, int end)
{
    fprintf(w->file,
            "\nstatic void run_%d(double *restrict w, const double *restrict u, "
            "const double *restrict p,\n    int points)\n{\n    (void)u, (void)p;\n",
            number);
    for (int at = first; at < end; at = w->end[at]) {
        if (w->pass->instructions[at].out.rows > FEW_ROWS) {
            write_rows(w, at, w->end[at]);
        } else {
            write_statements(w, at, w->end[at]);
        }
    }
    fputs("}\n", w->file);
}

/* Segments end where a run does. */
static void cut_segments(writer *w)
{
    const pass *p = w->pass;
    for (int n = 0; n < p->count;) {
        int run = n;
        while (run < p->count && op_is_elementwise(p->instructions[run].op)) {
            run++;
        }
        int end = segment_end(p, n, run);
        for (; n < end; n++) {
            w->end[n] = end;
        }
    }
}

static bool write_pass(writer *w, int *number)
{
    const pass *p = w->pass;
    w->end = malloc(((size_t)p->count + 1) * sizeof *w->end);
    w->holder = malloc(((size_t)p->units + 1) * sizeof *w->holder);
    bool ok = w->end && w->holder;
    if (ok) {
        cut_segments(w);
        ok = ad_c_lives_create(p, w->end, &w->lives);
    }
    for (int g = 0; ok && g < p->group_count; g++) {
        int length = ad_c_run_length(p, g);
        if (length > 0) {
            const group *last = &p->groups[g + length - 1];
            write_run(w, (*number)++, p->groups[g].first, last->first + last->count);
            g += length - 1;
        }
    }
    ad_c_lives_clear(&w->lives);
    free(w->end);
    free(w->holder);
    return ok;
}

static bool find_constants(writer *w)
{
    const ad_tape *tape = w->program->tape;
    w->constant = calloc((size_t)w->program->uniform_count + 1, sizeof *w->constant);
    for (int id = 0; w->constant && id < tape->count; id++) {
        place p = w->program->places[id];
        if (tape->nodes[id].op == OP_CONSTANT) {
            memset(w->constant + p.offset, 1, (size_t)p.rows);
        }
    }
    if (w->constant) {
        w->constant[0] = true;
    }
    return w->constant != NULL;
}

bool ad_c_write_groups(const ad_program *program, int tile, const char *name, FILE *file)
{
    writer w = {.program = program, .file = file};
    int count = 0;
    bool ok = find_constants(&w);
    fputs(
        "/* Elementwise groups of a program: w is the workspace of a tile, u the values that are\n"
        " * the same at all points, p the parameters. */\n",
        file);
    ad_c_text(ad_text_stumpff, file);
    ad_c_text(ad_text_lanes, file);
    fprintf(file,
            "\n#define TILE %d\n#define AT(unit) (*(vec *)(w + (ptrdiff_t)(unit) * TILE + j))\n"
            "#define ROW(unit, stride) AT((unit) + r * (stride))\n",
            tile);
    for (int s = 0; ok && s < program->pass_count; s++) {
        w.pass = &program->passes[s];
        ok = write_pass(&w, &count);
    }
    fprintf(file,
            "\ntypedef void run(double *restrict, const double *restrict, const double *restrict, "
            "int);\nextern run *const %s[];\nrun *const %s[] = {",
            name, name);
    for (int i = 0; i < count; i++) {
        fprintf(file, "%srun_%d,", i % 8 == 0 ? "\n    " : " ", i);
    }
    fputs("\n    0};\n", file);
    free(w.constant);
    return ok;
}
