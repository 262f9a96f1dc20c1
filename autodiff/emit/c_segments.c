/* Elementwise instructions as C. Those that follow one another are cut into segments of one loop
 * over points each, whose values stay in registers unless something after it reads them. Where rows
 * are few all are written out; blocks of many rows become loops over rows. */
#include "autodiff/emit/c_code.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    FEW_ROWS = 4,    /* written out */
    STATEMENTS = 400 /* in one loop over points: what a compiler is quick with */
};

void ad_c_text(const char *const *lines, FILE *file)
{
    for (; *lines; lines++) {
        fputs(*lines, file);
    }
}

void ad_c_number(const c_writer *w, double number, char *text)
{
    static const char digits[] = "+-0123456789";
    double written = *w->suffix ? (float)number : number;
    if (!isfinite(written)) {
        snprintf(text, 32, "%s", isnan(number) ? "NAN" : number < 0 ? "-HUGE_VAL" : "HUGE_VAL");
        return;
    }
    int length = snprintf(text, 32, *w->suffix ? "%.9g" : "%.17g", written);
    char *point = text + strspn(text, digits);
    size_t bytes = strcspn(point, digits);
    if (bytes > 0 && *point != 'e') { /* of the locale: another sign, perhaps of several bytes */
        memmove(point + 1, point + bytes, strlen(point + bytes) + 1);
        *point = '.';
        length -= (int)bytes - 1;
    }
    snprintf(text + length, 8, "%s%s", strpbrk(text, ".e") ? "" : ".0", w->suffix);
}

bool *ad_c_constants(const ad_program *program)
{
    bool *known = calloc((size_t)program->uniform_count + 1, sizeof *known);
    for (int id = 0; known && id < program->tape->count; id++) {
        place p = program->places[id];
        if (program->tape->nodes[id].op == OP_CONSTANT) {
            memset(known + p.offset, 1, (size_t)p.rows);
        }
    }
    if (known) {
        known[0] = true; /* the zero of a padding */
    }
    return known;
}

/* ---- operations ----------------------------------------------------------------------------- */

static const char *const formulas[OP_ELEMENTWISE_END] = {
#define FORMULA(code, name, arity, kind, rule, numbers, vectors, text) [OP_##code] = (text),
    AD_ELEMENTWISE(FORMULA)
#undef FORMULA
};

static bool has_number(int op)
{
    return op == OP_POWER || op_is_scaled(op);
}

static void put_formula(const c_writer *w, const char *formula, double number,
                        char (*operands)[C_OPERAND])
{
    char text[C_OPERAND];
    formula += number == 1 && strncmp(formula, "N * ", 4) == 0 ? 4 : 0;
    for (; *formula; formula++) {
        if (*formula >= 'A' && *formula <= 'D') {
            fputs(operands[*formula - 'A'], w->file);
        } else if (*formula == 'N') {
            ad_c_number(w, number, text);
            fputs(text, w->file);
        } else {
            fputc(*formula, w->file);
        }
    }
}

/* A function of our own, or of libm where it has our name but for the suffix. */
static void put_name(const c_writer *w, int op)
{
    const char *kind = *w->suffix ? "single" : "number";
    if (w->vectors) {
        fprintf(w->file, "v_%s(", ad_op_table[op].name);
    } else if (op == OP_TANH || op == OP_TANH_SUM) {
        fprintf(w->file, "ad_tanh_%s(", kind);
    } else if (op == OP_EXP) {
        fprintf(w->file, "ad_exp_%s(", kind);
    } else {
        fprintf(w->file, "%s%s(",
                op == OP_ABS     ? "fabs"
                : op == OP_POWER ? "pow"
                                 : ad_op_table[op].name,
                w->suffix);
    }
}

/* The largest arguments that a function of our own serves without a branch. */
static const char *reach_of(const c_writer *w, int op)
{
    return op == OP_STUMPFF ? "AD_STUMPFF_NEAR"
           : *w->suffix     ? "AD_SINE_MOST_SINGLE"
                            : "AD_SINE_MOST";
}

static void put_sine(const c_writer *w, int op, const char *operand)
{
    const char *name = ad_op_table[op].name, *kind = *w->suffix ? "single" : "number";
    if (w->reach == REACH_ANY) {
        fprintf(w->file, "fabs%s(%s) <= %s ? ", w->suffix, operand, reach_of(w, op));
    }
    if (w->reach != REACH_FAR) {
        fprintf(w->file, "ad_sine_%s(%s, %d)", kind, operand, op == OP_COS);
    }
    fputs(w->reach == REACH_ANY ? " : " : "", w->file);
    if (w->reach != REACH_NEAR) {
        fprintf(w->file, "%s%s(%s)", name, w->suffix, operand);
    }
}

static void put_stumpff(const c_writer *w, int whole, const char *operand)
{
    const char *kind = w->reach == REACH_NEAR ? *w->suffix ? "near_single" : "near"
                       : *w->suffix           ? "single"
                                              : "number";
    fprintf(w->file, "ad_stumpff_%s(%d, %s)", kind, whole, operand);
}

/* "v_power(x1, 3.0)", or of numbers "pow(x1, 3.0)", "ad_tanh_number(x1 + x2)". */
static void put_call(const c_writer *w, int op, int whole, double number,
                     char (*operands)[C_OPERAND])
{
    const char *between = op == OP_TANH_SUM && !w->vectors ? " + " : ", ";
    char attribute[C_OPERAND];
    put_name(w, op);
    for (int k = 0; k < ad_op_table[op].arity; k++) {
        fprintf(w->file, "%s%s", k == 0 ? "" : between, operands[k]);
    }
    if (has_number(op)) {
        ad_c_number(w, number, attribute);
        fprintf(w->file, ", %s", attribute);
    } else if (op == OP_STUMPFF) {
        fprintf(w->file, ", %d", whole);
    }
    fputc(')', w->file);
}

void ad_c_operation(const c_writer *w, int op, int whole, double number,
                    char (*operands)[C_OPERAND])
{
    bool infix =
        w->vectors ? op <= OP_MUL || op == OP_COPY || op == OP_REPEAT : formulas[op] != NULL;
    if (infix) {
        put_formula(w, formulas[op], number, operands);
    } else if (!w->vectors && op_is_sine(op)) {
        put_sine(w, op, operands[0]);
    } else if (!w->vectors && op == OP_STUMPFF) {
        put_stumpff(w, whole, operands[0]);
    } else {
        put_call(w, op, whole, number, operands);
    }
    fputs(";\n", w->file);
}

/* ---- segments ------------------------------------------------------------------------------- */

bool ad_c_is_loop(const instruction *i)
{
    return op_is_elementwise(i->op) && i->out.rows > FEW_ROWS;
}

/* Functions of numbers that have a reach have loops of their own. */
static bool fits_loop(const c_writer *w, int first, int next)
{
    const instruction *list = w->pass->instructions;
    if (list[next].out.rows != list[first].out.rows || next - first >= C_LOOP_MAX ||
        (!w->vectors && next > first && (has_reach(list[first].op) || has_reach(list[next].op)))) {
        return false;
    }
    for (int i = first; i < next; i++) {
        if (ad_instructions_conflict(&list[i], &list[next])) {
            return false;
        }
    }
    return true;
}

/* Of the segment that begins at `first`, in a run of elementwise instructions that ends at `end`.
 */
static int segment_end(const c_writer *w, int first, int end)
{
    const pass *p = w->pass;
    int next = first, rows = 0;
    if (ad_c_is_loop(&p->instructions[first])) {
        while (next < end && fits_loop(w, first, next)) {
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

static void cut_segments(c_writer *w)
{
    const pass *p = w->pass;
    for (int n = 0, run = 0, end; n < p->count;) {
        while (run < p->count && op_is_elementwise(p->instructions[run].op)) {
            run++;
        }
        end = n < run ? segment_end(w, n, run) : n + 1;
        run = end > run ? end : run;
        for (; n < end; n++) {
            w->end[n] = end;
        }
    }
}

bool ad_c_begin_pass(c_writer *w, const pass *p)
{
    size_t rows = 0;
    w->pass = p;
    AD_TAKE(w, end, (size_t)p->count + 1);
    AD_TAKE(w, row, (size_t)p->count + 1);
    AD_TAKE(w, dead, (size_t)p->count + 1);
    AD_TAKE(w, holder, (size_t)p->units + 1);
    for (int n = 0; w->row && n < p->count; n++) {
        w->row[n] = rows;
        rows += (size_t)p->instructions[n].out.rows;
    }
    AD_TAKE(w, kept, rows + 1);
    AD_TAKE(w, needed, rows + 1);
    if (w->memory.is_short) {
        return false;
    }
    cut_segments(w);
    return ad_c_find_again(w) && ad_c_find_lives(w);
}

void ad_c_end_pass(c_writer *w)
{
    ad_memory_free(&w->memory);
    w->end = w->holder = w->again = NULL;
    w->row = NULL;
    w->kept = w->needed = w->dead = NULL;
}

/* ---- rows written out ----------------------------------------------------------------------- */

static int unit_of(place p, int row)
{
    return p.offset + row * p.stride;
}

/* "AT(120)" or "ROW(120, 5)", row r of a block whose rows are 5 units apart; of numbers "w[120]",
 * or "w[(120 + 5 * r) * 8 + j]" with 8 points. */
static void at_text(const c_writer *w, int offset, int stride, char *text)
{
    char row[C_OPERAND / 2];
    if (w->vectors) {
        snprintf(text, C_OPERAND, stride > 0 ? "ROW(%d, %d)" : "AT(%d)", offset, stride);
        return;
    }
    snprintf(row, sizeof row,
             stride == 0   ? "%d"
             : stride == 1 ? "%d + r"
                           : "%d + %d * r",
             offset, stride);
    if (w->numbers == 1) {
        snprintf(text, C_OPERAND, "w[%s]", row);
    } else {
        snprintf(text, C_OPERAND, stride > 0 ? "w[(%s) * %d + j]" : "w[%s * %d + j]", row,
                 w->numbers);
    }
}

static void put_load(const c_writer *w, const char *indent, int variable, int offset, int stride)
{
    char at[C_OPERAND];
    at_text(w, offset, stride, at);
    fprintf(w->file, "%sconst %s x%d = %s;\n", indent, w->type, variable, at);
}

static void put_store(const c_writer *w, const char *indent, int variable, int offset, int stride)
{
    char at[C_OPERAND];
    at_text(w, offset, stride, at);
    fprintf(w->file, "%s%s = x%d;\n", indent, at, variable);
}

/* A uniform value as an operand. */
static void uniform_text(const c_writer *w, place p, int row, char *text)
{
    char number[C_OPERAND - 8];
    int at = unit_of(p, row < 0 ? 0 : row);
    bool one = row >= 0 || p.stride == 0;
    if (one && p.kind == PLACE_UNIFORM && w->known[at]) {
        ad_c_number(w, w->program->uniform[at], number);
    } else {
        w->uniform(w, p, row, number);
    }
    snprintf(text, C_OPERAND, w->vectors ? "splat(%s)" : "%s", number);
}

static bool is_kept(const c_writer *w, int n, int row)
{
    return w->kept[w->row[n] + (size_t)row];
}

static void write_statement(c_writer *w, int n, int row)
{
    const instruction *i = &w->pass->instructions[n];
    char operands[AD_ARITY_MAX][C_OPERAND];
    for (int k = 0; k < ad_op_table[i->op].arity; k++) {
        int unit = unit_of(i->in[k], row);
        if (i->in[k].kind != PLACE_TILE) {
            uniform_text(w, i->in[k], row, operands[k]);
            continue;
        }
        if (w->holder[unit] < 0) {
            w->holder[unit] = w->variables++;
            put_load(w, "        ", w->holder[unit], unit, 0);
        }
        snprintf(operands[k], C_OPERAND, "x%d", w->holder[unit]);
    }
    int unit = unit_of(i->out, row);
    w->holder[unit] = w->variables++;
    fprintf(w->file, "        const %s x%d = ", w->type, w->holder[unit]);
    ad_c_operation(w, i->op, i->whole, i->number, operands);
    if (is_kept(w, n, row)) {
        put_store(w, "        ", w->holder[unit], unit, 0);
    }
}

static void write_statements(c_writer *w, int first, int end)
{
    w->variables = 0;
    memset(w->holder, -1, (size_t)w->pass->units * sizeof *w->holder);
    fprintf(w->file, "    %s{\n", w->points);
    for (int n = first; n < end; n++) {
        for (int row = 0; row < w->pass->instructions[n].out.rows; row++) {
            if (w->needed[w->row[n] + (size_t)row]) {
                write_statement(w, n, row);
            }
        }
    }
    fputs("    }\n", w->file);
}

/* ---- loops over rows ------------------------------------------------------------------------ */

/* The variable of a row of a block, the latest; -1: none yet. */
static int find_held(const c_writer *w, place p)
{
    for (int i = w->held_count - 1; i >= 0; i--) {
        place at = w->held[i].at;
        if (at.kind == p.kind && at.offset == p.offset && at.stride == p.stride) {
            return w->held[i].variable;
        }
    }
    return -1;
}

static int hold(c_writer *w, place p)
{
    w->held[w->held_count++] = (c_held){p, w->variables};
    return w->variables++;
}

/* The instruction that makes an operand again, or NULL. */
static const instruction *again(const c_writer *w, int n, int k)
{
    int by = w->again[n * AD_ARITY_MAX + k];
    return by < 0 ? NULL : &w->pass->instructions[by];
}

/* Operands that are the same for all points: fetched before the loop over them. */
static void write_uniforms_of_row(c_writer *w, const instruction *i)
{
    char text[C_OPERAND];
    for (int k = 0; k < ad_op_table[i->op].arity; k++) {
        place p = i->in[k];
        if (p.kind != PLACE_TILE && p.stride > 0 && find_held(w, p) < 0) {
            uniform_text(w, p, -1, text);
            fprintf(w->file, "        const %s x%d = %s;\n", w->type, hold(w, p), text);
        }
    }
}

static const char indent[] = "            ";

static int write_operation(c_writer *w, const instruction *i, char (*operands)[C_OPERAND])
{
    int variable = hold(w, i->out);
    fprintf(w->file, "%sconst %s x%d = ", indent, w->type, variable);
    ad_c_operation(w, i->op, i->whole, i->number, operands);
    return variable;
}

/* The variable of an operand, fetched when it is not there yet. */
static void fetch(c_writer *w, place p, char *text)
{
    if (p.kind != PLACE_TILE && p.stride == 0) {
        uniform_text(w, p, 0, text);
        return;
    }
    int variable = find_held(w, p);
    if (variable < 0) {
        variable = hold(w, p);
        put_load(w, indent, variable, p.offset, p.stride);
    }
    snprintf(text, C_OPERAND, "x%d", variable);
}

static void make_again(c_writer *w, const instruction *i)
{
    char operands[AD_ARITY_MAX][C_OPERAND];
    for (int k = 0; k < ad_op_table[i->op].arity; k++) {
        fetch(w, i->in[k], operands[k]);
    }
    write_operation(w, i, operands);
}

static void write_row_statement(c_writer *w, int n)
{
    const instruction *i = &w->pass->instructions[n];
    char operands[AD_ARITY_MAX][C_OPERAND];
    bool kept = false;
    for (int row = 0; row < i->out.rows; row++) {
        kept = kept || is_kept(w, n, row);
    }
    for (int k = 0; k < ad_op_table[i->op].arity; k++) {
        fetch(w, i->in[k], operands[k]);
    }
    int variable = write_operation(w, i, operands);
    if (kept) {
        put_store(w, indent, variable, i->out.offset, i->out.stride);
    }
}

static void write_rows(c_writer *w, int first, int end)
{
    w->variables = w->held_count = 0;
    fprintf(w->file, "    for (int r = 0; r < %d; r++) {\n", w->pass->instructions[first].out.rows);
    for (int n = first; n < end; n++) {
        if (!w->dead[n]) {
            write_uniforms_of_row(w, &w->pass->instructions[n]);
        }
        for (int k = 0; k < AD_ARITY_MAX; k++) {
            if (again(w, n, k) && !w->dead[n]) {
                write_uniforms_of_row(w, again(w, n, k));
            }
        }
    }
    fprintf(w->file, "        %s{\n", w->points);
    for (int n = first; n < end; n++) { /* before anything is overwritten */
        for (int k = 0; k < AD_ARITY_MAX; k++) {
            if (again(w, n, k) && !w->dead[n] && find_held(w, w->pass->instructions[n].in[k]) < 0) {
                make_again(w, again(w, n, k));
            }
        }
    }
    for (int n = first; n < end; n++) {
        if (!w->dead[n]) {
            write_row_statement(w, n);
        }
    }
    fputs("        }\n    }\n", w->file);
}

/* A function with a reach, without a branch in the loop over rows unless some argument is beyond.
 */
static void write_reach(c_writer *w, int n)
{
    const instruction *i = &w->pass->instructions[n];
    static const c_reach reaches[] = {REACH_FAR, REACH_NEAR};
    char at[C_OPERAND], operands[AD_ARITY_MAX][C_OPERAND];
    if (w->dead[n]) {
        return;
    }
    at_text(w, i->in[0].offset, i->in[0].stride, operands[0]);
    at_text(w, i->out.offset, i->out.stride, at);
    fprintf(w->file,
            "    {\n    int far = 0;\n    for (int r = 0; r < %d; r++) {\n"
            "        %sfar |= !(fabs%s(%s) <= %s);\n    }\n",
            i->out.rows, w->points, w->suffix, operands[0], reach_of(w, i->op));
    for (int k = 0; k < 2; k++) {
        fprintf(w->file, "    %s {\n    for (int r = 0; r < %d; r++) {\n        %s%s = ",
                k ? "} else" : "if (far)", i->out.rows, w->points, at);
        w->reach = reaches[k];
        ad_c_operation(w, i->op, i->whole, i->number, operands);
        fputs("    }\n", w->file);
    }
    w->reach = REACH_ANY;
    fputs("    }\n    }\n", w->file);
}

void ad_c_write_segments(c_writer *w, int first, int end)
{
    for (int at = first; at < end; at = w->end[at]) {
        const instruction *i = &w->pass->instructions[at];
        if (!w->vectors && ad_c_is_loop(i) && has_reach(i->op)) {
            write_reach(w, at);
        } else if (ad_c_is_loop(i)) {
            write_rows(w, at, w->end[at]);
        } else {
            write_statements(w, at, w->end[at]);
        }
    }
}
