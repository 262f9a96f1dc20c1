/* What a tape and a program look like, for people who look for a fault or for time. */
#include "autodiff/compile/program.h"

#include <stdlib.h>

static const char *plural(size_t count)
{
    return count == 1 ? "" : "s";
}

static const char *shape_text(const node *n)
{
    return n->extent == AD_BATCH ? "per point" : n->extent == AD_MEMBER ? "of member" : "for all";
}

/* %12, or what a leaf is called, or the number that a constant is. */
static void put_value(const ad_tape *tape, int id, FILE *file)
{
    const node *n = &tape->nodes[id];
    if (n->op == OP_CONSTANT && (n->splat || n->rows == 1)) {
        fprintf(file, " %g", n->splat ? n->number : tape->numbers[n->offset]);
    } else if (*ad_tape_name(tape, id)) {
        fprintf(file, " \"%s\"", ad_tape_name(tape, id));
    } else {
        fprintf(file, " %%%d", id);
    }
}

static void put_attribute(int op, int whole, double number, FILE *file)
{
    if (op_is_scaled(op)) {
        fprintf(file, " scale %g", number);
    } else if (op == OP_POWER) {
        fprintf(file, " exponent %g", number);
    } else if (op == OP_STUMPFF) {
        fprintf(file, " order %d", whole);
    } else if (op == OP_SLICE || op == OP_PAD) {
        fprintf(file, " from row %d", whole);
    } else if ((op_is_reduction(op) || op == OP_POINTS) && whole != OVER_POINTS) {
        fputs(whole == OF_MEMBER ? " of each member" : " over members", file);
    }
}

/* "%12  64 per point  matvec %3 %4" */
static void put_node(const ad_tape *tape, int id, FILE *file)
{
    const node *n = &tape->nodes[id];
    fprintf(file, "  %%%-6d %6d %-9s  %s", id, n->rows, shape_text(n), ad_op_table[n->op].name);
    for (int i = 0; i < n->count; i++) {
        put_value(tape, tape->arguments[n->first + i], file);
    }
    put_attribute(n->op, n->whole, n->number, file);
    if (n->op == OP_CONSTANT && !n->splat && n->rows > 1) {
        fprintf(file, " %g, ...", tape->numbers[n->offset]);
    } else if (n->count == 0 && n->op != OP_POINTS) {
        put_value(tape, id, file);
    }
    if (n->op == OP_PARAMETER) {
        fprintf(file, " from %zu on", n->offset);
    }
}

void ad_tape_print(const ad_tape *tape, FILE *file)
{
    file = file ? file : stderr;
    fprintf(file, "tape of %d value%s, %d input%s, %d uniform%s\n", tape->count,
            plural((size_t)tape->count), tape->inputs, plural((size_t)tape->inputs), tape->uniforms,
            plural((size_t)tape->uniforms));
    for (int id = 0; id < tape->count; id++) {
        put_node(tape, id, file);
        fputc('\n', file);
    }
    if (tape->error.status != AD_OK) {
        fprintf(file, "  error: %s\n", tape->error.message);
    }
}

/* ---- programs ------------------------------------------------------------------------------- */

typedef struct printer {
    const ad_program *program;
    const pass *pass;
    FILE *file;
    int *holder; /* [units] the value that each holds */
} printer;

static int columns_of(const instruction *i)
{
    return i->columns > 1 ? i->columns : 1;
}

/* The leaf, or the uniform value, that lies at a place; -1: none. */
static int owner_of(const ad_program *program, place at)
{
    for (int id = 0; id < program->tape->count; id++) {
        place p = program->places[id];
        if (p.rows > 0 && p.kind == at.kind && program->tape->nodes[id].op != OP_SLICE &&
            at.offset >= p.offset && at.offset < p.offset + p.rows) {
            return id;
        }
    }
    return -1;
}

static void put_place(const printer *p, place at)
{
    if (at.kind == PLACE_TILE) {
        put_value(p->program->tape, p->holder[at.offset], p->file);
        fprintf(p->file, "@%d", at.offset);
        return;
    }
    int id = owner_of(p->program, at);
    if (id < 0) {
        fputs(" 0", p->file);
        return;
    }
    put_value(p->program->tape, id, p->file);
    if (at.offset != p->program->places[id].offset) {
        fprintf(p->file, "+%d", at.offset - p->program->places[id].offset);
    }
}

static void put_result(const printer *p, const instruction *i)
{
    if (i->out.kind != PLACE_TILE) {
        bool member = i->out.kind == PLACE_MEMBER;
        fprintf(p->file, member ? "row %-13d" : "sum %-20d",
                i->out.offset - (member ? 0 : p->pass->reduced_offset));
        fputs(member ? " of members " : "", p->file);
        return;
    }
    int n = fprintf(p->file, "%%%d@%d", i->value, i->out.offset);
    n += i->out.stride > 1 ? fprintf(p->file, "/%d", i->out.stride) : 0;
    fprintf(p->file, "%*s", n < 24 ? 24 - n : 1, "");
}

/* "12 %45@128/5  matvec "w" %40@0; 64 x 64 times 5 columns, 40960 flops per point" */
static void put_instruction(const printer *p, int number)
{
    const instruction *i = &p->pass->instructions[number];
    fprintf(p->file, "  %5d  ", number);
    put_result(p, i);
    fputs(ad_op_table[i->op].name, p->file);
    for (int k = 0; k < ad_op_table[i->op].arity; k++) {
        put_place(p, i->in[k]);
    }
    put_attribute(i->op, i->whole, i->number, p->file);
    if (instruction_flops(i) > 0) {
        int columns = i->in[1].rows, rows = i->in[0].rows / (i->op == OP_OUTER_SUM ? 1 : columns);
        fprintf(p->file, "; %d x %d times %d column%s, %zu flops per %s", rows, columns, i->columns,
                plural((size_t)i->columns), instruction_flops(i),
                p->pass->members ? "member" : "point");
    }
    fputs(i->out.local ? "; in its group\n" : "\n", p->file);
}

static void hold(printer *p, const instruction *i)
{
    for (int row = 0; i->out.kind == PLACE_TILE && row < i->out.rows; row++) {
        for (int c = 0; c < columns_of(i); c++) {
            p->holder[i->out.offset + row * i->out.stride + c] = i->value;
        }
    }
}

static void put_groups(printer *p)
{
    const ad_settings *settings = &p->program->settings;
    for (int g = 0; g < p->pass->group_count; g++) {
        const group *now = &p->pass->groups[g];
        int rows = p->pass->instructions[now->first].out.rows;
        fprintf(p->file, "  group %d: %d instruction%s of %d row%s", g, now->count,
                plural((size_t)now->count), rows, plural((size_t)rows));
        if (now->pieces) {
            const int most = settings->piece / p->program->tile;
            fprintf(p->file, ", %d at a time", most > 1 ? most : 1);
        }
        fputc('\n', p->file);
        for (int i = now->first; i < now->first + now->count; i++) {
            put_instruction(p, i);
            hold(p, &p->pass->instructions[i]);
        }
    }
}

static void put_inputs(printer *p, int number)
{
    const ad_tape *tape = p->program->tape;
    const int *units = p->program->input_units + number * tape->inputs;
    for (int id = 0; id < tape->count; id++) {
        const node *n = &tape->nodes[id];
        if (n->op == OP_INPUT && units[n->whole] >= 0) {
            fprintf(p->file, "  input %d at %d, %d row%s:", n->whole, units[n->whole], n->rows,
                    plural((size_t)n->rows));
            put_value(tape, id, p->file);
            fputc('\n', p->file);
            for (int row = 0; row < n->rows; row++) {
                p->holder[units[n->whole] + row] = id;
            }
        }
    }
}

static bool put_pass(const ad_program *program, int number, FILE *file)
{
    const pass *now = &program->passes[number];
    printer p = {.program = program, .pass = now, .file = file};
    bool last = number == program->pass_count;
    if (last) {
        fputs("after all passes\n", file);
    } else {
        fprintf(file, "pass %d%s\n", number, now->members ? " over members" : "");
    }
    for (int i = 0; i < now->uniform_count; i++) {
        put_node(program->tape, now->uniforms[i], file);
        fprintf(file, "; at %d\n", program->places[now->uniforms[i]].offset);
    }
    if (last) {
        return true;
    }
    p.holder = calloc((size_t)now->units + 1, sizeof *p.holder);
    if (p.holder) {
        put_inputs(&p, number);
        put_groups(&p);
        for (int i = 0; i < now->output_count; i++) {
            fprintf(file, "  output %d:", now->outputs[i].number);
            put_place(&p, now->outputs[i].from);
            fputc('\n', file);
        }
        for (int i = 0; i < now->kept_count; i++) {
            fprintf(file, "  kept of members, row %d:", now->kept[i].number);
            put_place(&p, now->kept[i].from);
            fputc('\n', file);
        }
    }
    const bool ok = p.holder != NULL;
    free(p.holder);
    return ok;
}

void ad_program_print(const ad_program *program, FILE *file)
{
    const ad_program_info *info = &program->info;
    file = file ? file : stderr;
    fprintf(file,
            "program of %zu instruction%s in %zu group%s of pieces, %zu pass%s; %zu operations of "
            "the tape are not needed\n"
            "  tiles of %d points, %zu bytes of workspace per thread; kernels and products "
            "for %s\n"
            "  %zu matrix products per tile, %zu flops per point; %zu sums over points\n",
            info->instructions, plural(info->instructions), info->groups, plural(info->groups),
            info->passes, info->passes == 1 ? "" : "es", info->dead, program->tile,
            info->workspace_bytes, program->kernels->name, info->products, info->flops_per_point,
            info->reduced);
    if (program->members) {
        fprintf(file, "  %zu flops per member, %d rows of memory of the members\n",
                info->flops_per_member, program->member_rows);
    }
    for (int s = 0; s <= program->pass_count; s++) {
        if (!put_pass(program, s, file)) {
            fputs("  out of memory while printing\n", file);
        }
    }
    for (int i = 0; i < program->outputs; i++) {
        int id = program->output_ids[i];
        if (program->tape->nodes[id].extent == AD_UNIFORM) {
            fprintf(file, "output %d: %%%d at %d\n", i, id, program->places[id].offset);
        }
    }
}
