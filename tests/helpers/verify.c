/* Does a program compute what its tape says? Every row of every value has the number of the formula
 * that makes it. The instructions are replayed on a workspace of such numbers: what an instruction
 * reads has to make a formula of the tape, and at the end every output and every sum has to hold
 * its own. So a wrong order, a value that was overwritten before its last use, shared memory, a
 * wrong row, column or operand are all found by what they do.
 *
 * Groups are replayed twice, with all rows in one piece and with one row in each. Any other piece
 * lies in between: an instruction that reads row r after an earlier one wrote row q is in order for
 * every piece when q <= r, which one row finds, or wrong for whole blocks already. */
#include "verify.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The first thing that is wrong. */
bool ad_verify_wrong(verifier *v, const char *format, ...)
{
    char what[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    if (v->status == AD_OK) {
        const pass *p = &v->program->passes[v->pass];
        bool at = v->instruction >= 0 && v->instruction < p->count;
        v->status =
            at ? ad_fail(v->error, AD_BAD_PROGRAM, "pass %d, instruction %d (%s): %s", v->pass,
                         v->instruction, ad_op_table[p->instructions[v->instruction].op].name, what)
               : ad_fail(v->error, AD_BAD_PROGRAM, "pass %d: %s", v->pass, what);
    }
    return false;
}

/* ---- sums over points ----------------------------------------------------------------------- */

/* One summand: a row, or a product of two. Sums of hashes stand for sets of summands. */
static uint64_t summand(int a, int b)
{
    return ad_hash_mix(ad_hash_mix(0x2545f4914f6cdd1du, (uint64_t)a), (uint64_t)b);
}

static bool expect_sum(verifier *v, int id, place to)
{
    const node *n = &v->tape->nodes[id];
    if (n->rows != to.rows || !v->formulas.needed[id]) {
        return ad_verify_wrong(v, "%%%d of %d rows is added to a sum of %d", id, n->rows, to.rows);
    }
    if (n->op == OP_ADD) {
        return expect_sum(v, argument(v, n, 0), to) && expect_sum(v, argument(v, n, 1), to);
    }
    if (!op_is_reduction(n->op)) {
        return ad_verify_wrong(v, "%%%d is no sum over points", id);
    }
    int width = n->op == OP_OUTER_SUM ? v->tape->nodes[argument(v, n, 1)].rows : 1;
    for (int row = 0; row < n->rows; row++) {
        int a = ad_formulas_row(&v->formulas, argument(v, n, 0), row / width);
        int b = n->op == OP_OUTER_SUM
                    ? ad_formulas_row(&v->formulas, argument(v, n, 1), row % width)
                    : 0;
        v->sums[to.offset + row] += summand(a, b);
    }
    return true;
}

static bool is_sum_of(const verifier *v, const pass *p, int id)
{
    place at = v->program->places[id];
    return v->formulas.needed[id] && v->tape->nodes[id].extent == AD_UNIFORM &&
           at.kind == PLACE_UNIFORM && v->tape->nodes[id].op != OP_SLICE && at.rows > 0 &&
           at.offset >= p->reduced_offset && at.offset < p->reduced_offset + p->reduced;
}

static bool expect_sums(verifier *v, const pass *p)
{
    memset(v->sums, 0, (size_t)v->program->uniform_count * sizeof *v->sums);
    for (int id = 0; id < v->tape->count; id++) {
        if (is_sum_of(v, p, id) && !expect_sum(v, id, v->program->places[id])) {
            return false;
        }
    }
    return true;
}

static bool check_sums(verifier *v, const pass *p)
{
    v->instruction = -1;
    for (int i = p->reduced_offset; i < p->reduced_offset + p->reduced; i++) {
        if (v->sums[i] != 0) {
            return ad_verify_wrong(v, "sum %d of %d is not that of its summands",
                                   i - p->reduced_offset, p->reduced);
        }
    }
    return true;
}

/* ---- instructions -----------------------------------------------------------------------------
 */

static bool is_there(verifier *v, place_kind kind, int at)
{
    bool known =
        kind == PLACE_PARAMETER || (at >= 0 && at < v->program->uniform_count && v->ready[at]);
    return known || ad_verify_wrong(v, "number %d of the uniform memory is not there yet", at);
}

/* What row `row` of an operand holds; 0 and an error when nothing is there. */
static int read_row(verifier *v, place from, int row)
{
    int at = from.offset + row * from.stride;
    if (from.stride != 0 && row >= from.rows) {
        return ad_verify_wrong(v, "row %d of an operand of %d", row, from.rows);
    }
    if (from.kind == PLACE_MEMBER) {
        return ad_verify_wrong(v, "reads a value of members that is not spread");
    }
    if (from.kind != PLACE_TILE) {
        if (!is_there(v, from.kind, at)) {
            return 0;
        }
        bool constant = from.kind == PLACE_UNIFORM && v->constant[at];
        return ad_formulas_find(&v->formulas, constant ? constant_of(v->program->uniform[at])
                                                       : formula_at(from, row));
    }
    if (at < 0 || at >= v->program->passes[v->pass].units) {
        return ad_verify_wrong(v, "reads unit %d of %d", at, v->program->passes[v->pass].units);
    }
    v->reader[at] = v->instruction;
    if (!v->unit[at]) {
        return ad_verify_wrong(v, "reads unit %d, which holds nothing", at);
    }
    return v->unit[at];
}

/* apart: no number that this instruction has read may be overwritten. */
static bool write_row(verifier *v, place to, int row, int held, bool apart)
{
    int at = to.offset + row * to.stride, units = v->program->passes[v->pass].units;
    if (v->status != AD_OK) {
        return false;
    }
    if (to.kind != PLACE_TILE || at < 0 || at >= units || row >= to.rows) {
        return ad_verify_wrong(v, "writes unit %d of %d", at, units);
    }
    if (apart && v->reader[at] == v->instruction) {
        return ad_verify_wrong(v, "overwrites unit %d, which it reads", at);
    }
    if (!held) {
        return ad_verify_wrong(v, "row %d is made of operands that no value of the tape has", row);
    }
    v->unit[at] = held;
    return true;
}

/* A number of the memory of the members, written once, by one pass. */
static bool write_member(verifier *v, int at, int held)
{
    if (v->status != AD_OK || at < 0 || at >= v->program->member_rows) {
        return ad_verify_wrong(v, "writes row %d of %d of the members", at,
                               v->program->member_rows);
    }
    if (!held || (v->again ? v->member[at] != held : v->member[at] != 0)) {
        return ad_verify_wrong(
            v, "row %d of the members is of no value of the tape, or written twice", at);
    }
    v->member[at] = held;
    return true;
}

static int read_member(verifier *v, place from, int row)
{
    int at = from.offset + row * from.stride, rows = v->program->member_rows;
    if (from.kind != PLACE_MEMBER || row >= from.rows || at < 0 || at >= rows || !v->member[at]) {
        return ad_verify_wrong(v, "reads row %d of %d of the members, which holds nothing", at,
                               rows);
    }
    return v->member[at];
}

/* What points see of it; a pass over the members sees it as it is. */
static int read_spread(verifier *v, place from, int row)
{
    int held = read_member(v, from, row);
    return v->program->passes[v->pass].members
               ? held
               : ad_formulas_find(&v->formulas, (formula){.op = OP_SPREAD, .a = held});
}

static int scaled(const formulas *f, double factor, int product)
{
    int constant = ad_formulas_find(f, constant_of(factor));
    return factor == 1 ? product : ad_formulas_find(f, product_of(constant, product));
}

/* What an elementwise operation makes of rows; 0: no value of the tape. */
static int combine(const verifier *v, const instruction *i, const int *x)
{
    const formulas *f = &v->formulas;
    int product = ad_formulas_find(f, product_of(x[0], x[1])), other = x[2];
    if (i->op == OP_PAIR_ADD || i->op == OP_PAIR_SUB) {
        other = ad_formulas_find(f, product_of(x[2], x[3]));
    }
    switch (i->op) {
    case OP_COPY:
    case OP_REPEAT:
        return x[0];
    case OP_MUL_ADD:
        return ad_formulas_find(f, sum_of(product, other));
    case OP_MUL_SUB:
        return ad_formulas_find(f, difference_of(product, other));
    case OP_SUB_MUL:
        return ad_formulas_find(f, difference_of(other, product));
    case OP_SCALED_MUL:
        return scaled(f, i->number, product);
    case OP_SCALED_MUL_ADD:
    case OP_PAIR_ADD:
        return i->whole == 1
                   ? ad_formulas_find(f, difference_of(other, scaled(f, -i->number, product)))
                   : ad_formulas_find(f, sum_of(scaled(f, i->number, product), other));
    case OP_SCALED_MUL_SUB:
    case OP_PAIR_SUB:
        return ad_formulas_find(f, difference_of(scaled(f, i->number, product), other));
    case OP_TANH_SUM: {
        const int sum[AD_ARITY_MAX] = {ad_formulas_find(f, sum_of(x[0], x[1]))};
        return ad_formulas_find(f, operation_of(OP_TANH, 0, 0, sum));
    }
    default:
        return ad_formulas_find(f, operation_of(i->op, i->whole, i->number, x));
    }
}

static bool replay_elementwise(verifier *v, const instruction *i, int first, int rows)
{
    int arity = ad_op_table[i->op].arity;
    unsigned mask = 0;
    for (int k = 0; k < arity; k++) {
        mask |= i->in[k].kind == PLACE_TILE ? 0 : 1u << k;
    }
    if (!i->loop || i->loop != v->program->kernels->loops[i->op][mask]) {
        return ad_verify_wrong(v, "another operation's loop");
    }
    for (int row = first; row < first + rows; row++) {
        int x[AD_ARITY_MAX] = {0};
        for (int k = 0; k < arity; k++) {
            x[k] = read_row(v, i->in[k], i->in[k].local ? row - first : row);
        }
        if (!write_row(v, i->out, i->out.local ? row - first : row, combine(v, i, x), false)) {
            return false;
        }
    }
    return true;
}

static int read_all(verifier *v, place from)
{
    if (from.kind == PLACE_UNIFORM || from.kind == PLACE_PARAMETER) {
        for (int i = 0; i < from.rows && is_there(v, from.kind, from.offset + i); i++) {
        }
        return ad_formulas_find(&v->formulas, block_at(from));
    }
    int list = 0;
    for (int row = 0; row < from.rows; row++) {
        int held = from.kind == PLACE_MEMBER ? read_spread(v, from, row) : read_row(v, from, row);
        list = ad_formulas_find(&v->formulas, (formula){.op = LIST, .a = list, .b = held});
    }
    return list;
}

static place column_of(place panel, int column)
{
    panel.offset += column;
    return panel;
}

/* Columns of one panel lie side by side. */
static bool check_columns(verifier *v, const instruction *i, place panel)
{
    return (panel.kind == PLACE_TILE && i->columns >= 1 && panel.stride >= i->columns) ||
           ad_verify_wrong(v, "%d columns in rows of %d", i->columns, panel.stride);
}

static bool replay_product(verifier *v, const instruction *i)
{
    enum { COLUMNS_MAX = 64 };
    const pass *p = &v->program->passes[v->pass];
    bool uniform = i->in[0].kind == PLACE_UNIFORM || i->in[0].kind == PLACE_PARAMETER;
    int lists[COLUMNS_MAX], w = read_all(v, i->in[0]);
    if ((uniform && (!check_columns(v, i, i->in[1]) || !check_columns(v, i, i->out))) ||
        i->columns > (uniform ? COLUMNS_MAX : 1) || i->in[0].rows != i->in[1].rows * i->out.rows) {
        return ad_verify_wrong(v, "shapes do not fit");
    }
    if (i->in[0].kind == PLACE_MEMBER && (p->members || i->in[1].kind != PLACE_TILE ||
                                          ad_execute_scratch(i) > v->program->scratch)) {
        return ad_verify_wrong(v, "a matrix of each member does not stand here");
    }
    for (int c = 0; c < i->columns; c++) {
        lists[c] = read_all(v, column_of(i->in[1], c));
    }
    for (int c = 0; c < i->columns; c++) {
        for (int row = 0; row < i->out.rows; row++) {
            int held = ad_formulas_find(&v->formulas,
                                        (formula){.op = i->op, .a = w, .b = lists[c], .c = row});
            if (!write_row(v, column_of(i->out, c), row, held, true)) {
                return false;
            }
        }
    }
    return true;
}

static bool replay_outer(verifier *v, const instruction *i)
{
    int width = i->in[1].rows;
    if (i->out.rows != i->in[0].rows * width) {
        return ad_verify_wrong(v, "shapes do not fit");
    }
    for (int row = 0; row < i->in[0].rows; row++) {
        for (int k = 0; k < width; k++) {
            int y = read_row(v, i->in[0], row), x = read_row(v, i->in[1], k);
            if (!write_row(v, i->out, row * width + k,
                           ad_formulas_find(&v->formulas, product_of(y, x)), true)) {
                return false;
            }
        }
    }
    return true;
}

/* Of each member's points. */
static bool replay_member_sum(verifier *v, const instruction *i)
{
    const pass *p = &v->program->passes[v->pass];
    bool outer = i->op == OP_OUTER_SUM;
    int width = outer ? i->in[1].rows : 1, rows = i->in[0].rows * width;
    if (p->members || i->columns != 1 || i->in[0].kind != PLACE_TILE || i->out.stride != 1 ||
        (outer && i->in[1].kind != PLACE_TILE) || i->out.rows != rows ||
        i->out.offset < p->summed_offset || i->out.offset + rows > p->summed_offset + p->summed ||
        ad_execute_scratch(i) > v->program->scratch) {
        return ad_verify_wrong(v, "adds outside of the members' sums of the pass");
    }
    for (int row = 0; row < rows; row++) {
        int a = read_row(v, i->in[0], row / width);
        int b = outer ? read_row(v, i->in[1], row % width) : 0;
        if (!write_member(v, i->out.offset + row,
                          ad_formulas_find(&v->formulas, member_sum_of(i->op, a, b)))) {
            return false;
        }
    }
    return v->status == AD_OK;
}

static bool replay_spread(verifier *v, const instruction *i)
{
    bool fits = i->out.rows == i->in[0].rows && i->out.kind == PLACE_TILE;
    for (int row = 0; fits && row < i->out.rows; row++) {
        if (!write_row(v, i->out, row, read_spread(v, i->in[0], row), true)) {
            return false;
        }
    }
    return fits || ad_verify_wrong(v, "shapes do not fit");
}

static bool replay_sum(verifier *v, const instruction *i)
{
    if (i->out.kind == PLACE_MEMBER) {
        return replay_member_sum(v, i);
    }
    const pass *p = &v->program->passes[v->pass];
    bool outer = i->op == OP_OUTER_SUM;
    int width = outer ? i->in[1].rows : 1, rows = i->in[0].rows * width;
    if (!check_columns(v, i, i->in[0]) || (outer && !check_columns(v, i, i->in[1])) ||
        i->out.kind != PLACE_UNIFORM || i->out.rows != rows || i->out.offset < p->reduced_offset ||
        i->out.offset + rows > p->reduced_offset + p->reduced) {
        return ad_verify_wrong(v, "adds outside of the sums of the pass");
    }
    if (ad_execute_scratch(i) > v->program->scratch) {
        return ad_verify_wrong(v, "needs more than the scratch memory there is");
    }
    for (int c = 0; c < i->columns; c++) {
        for (int row = 0; row < rows; row++) {
            int a = read_row(v, column_of(i->in[0], c), row / width);
            int b = outer ? read_row(v, column_of(i->in[1], c), row % width) : 0;
            v->sums[i->out.offset + row] -= summand(a, b);
        }
    }
    return v->status == AD_OK;
}

static bool replay_other(verifier *v, const instruction *i)
{
    switch (ad_op_table[i->op].form) {
    case FORM_PRODUCT:
        return replay_product(v, i);
    case FORM_OUTER:
        return replay_outer(v, i);
    case FORM_OUTER_SUM:
    case FORM_SUM_POINTS:
        return replay_sum(v, i);
    case FORM_SPREAD:
        return replay_spread(v, i);
    default:
        return ad_verify_wrong(v, "no instruction");
    }
}

/* ---- passes --------------------------------------------------------------------------------- */

static bool replay_group(verifier *v, const pass *p, const group *g, bool one_row)
{
    const instruction *first = &p->instructions[g->first];
    v->instruction = g->first;
    if (!op_is_elementwise(first->op)) {
        return g->count == 1 ? replay_other(v, first) : ad_verify_wrong(v, "stands in a group");
    }
    int rows = first->out.rows, piece = g->pieces && one_row ? 1 : rows;
    for (int row = 0; row < rows; row += piece) {
        for (int i = g->first; i < g->first + g->count; i++) {
            v->instruction = i;
            if (!op_is_elementwise(p->instructions[i].op) || p->instructions[i].out.rows != rows) {
                return ad_verify_wrong(v, "stands in a group of other rows");
            }
            if (!replay_elementwise(v, &p->instructions[i], row, piece)) {
                return false;
            }
        }
    }
    return true;
}

static bool place_inputs(verifier *v, const pass *p)
{
    const int *units = v->program->input_units + v->pass * v->tape->inputs;
    v->instruction = -1;
    for (int i = 0; i < v->tape->inputs; i++) {
        if (units[i] >= 0 && (v->tape->input_extent[i] == AD_MEMBER) != p->members) {
            return ad_verify_wrong(v, "input %d is not one of this pass", i);
        }
        for (int row = 0; units[i] >= 0 && row < v->tape->input_rows[i]; row++) {
            int at = units[i] + row;
            if (at >= p->units || v->unit[at]) {
                return ad_verify_wrong(v, "input %d has no memory of its own", i);
            }
            v->unit[at] =
                ad_formulas_find(&v->formulas, (formula){.op = OP_INPUT, .whole = i, .a = row});
        }
    }
    return true;
}

static bool check_outputs(verifier *v, const pass *p)
{
    v->instruction = -1;
    for (int i = 0; i < p->output_count; i++) {
        batch_output o = p->outputs[i];
        if (o.number < 0 || o.number >= v->program->outputs) {
            return ad_verify_wrong(v, "writes output %d of %d", o.number, v->program->outputs);
        }
        int id = v->program->output_ids[o.number];
        if (o.from.rows != v->tape->nodes[id].rows || o.from.local ||
            (v->tape->nodes[id].extent == AD_MEMBER) != p->members) {
            return ad_verify_wrong(v, "output %d of %d rows is read as %d", o.number,
                                   v->tape->nodes[id].rows, o.from.rows);
        }
        for (int row = 0; row < o.from.rows; row++) {
            if (read_row(v, o.from, row) != ad_formulas_row(&v->formulas, id, row)) {
                return ad_verify_wrong(v, "output %d holds another value in row %d", o.number, row);
            }
        }
    }
    return true;
}

/* What later passes find in the memory of the members. */
static bool keep(verifier *v, const pass *p)
{
    v->instruction = -1;
    for (int i = 0; i < p->kept_count; i++) {
        place from = p->kept[i].from;
        bool good = p->members && from.kind == PLACE_TILE && !from.local;
        for (int row = 0; good && row < from.rows; row++) {
            if (!write_member(v, p->kept[i].number + row, read_row(v, from, row))) {
                return false;
            }
        }
        if (!good) {
            return ad_verify_wrong(v, "keeps what it may not");
        }
    }
    return true;
}

static bool replay_pass(verifier *v, const pass *p, bool one_row)
{
    v->again = one_row;
    memset(v->unit, 0, (size_t)v->program->most_units * sizeof *v->unit);
    memset(v->reader, -1, (size_t)v->program->most_units * sizeof *v->reader);
    bool ok = expect_sums(v, p) && place_inputs(v, p);
    int next = 0;
    for (int g = 0; ok && g < p->group_count; g++) {
        const group *now = &p->groups[g];
        ok = now->first == next && now->count >= 1 && now->count <= p->count - now->first
                 ? replay_group(v, p, now, one_row)
                 : ad_verify_wrong(v, "groups do not follow each other");
        next = now->first + now->count;
    }
    v->instruction = -1;
    ok = ok && (next == p->count || ad_verify_wrong(v, "instructions outside of all groups"));
    return ok && check_sums(v, p) && check_outputs(v, p) && keep(v, p);
}

/* Rows of a tile begin at multiples of 64 bytes, and the workspace has all of them. */
static bool check_workspace(verifier *v)
{
    const ad_program *program = v->program;
    size_t tile = (size_t)program->tile;
    bool fits =
        program->info.workspace_bytes >= tile * (size_t)program->most_units * sizeof(double);
    for (int s = 0; s < program->pass_count; s++) {
        const pass *p = &program->passes[s];
        fits = fits && p->units <= program->most_units && p->reduced <= program->most_reduced &&
               p->reduced_offset >= 1 && p->reduced_offset + p->reduced <= program->uniform_count &&
               p->summed <= program->most_summed &&
               p->summed_offset + p->summed <= program->member_rows;
    }
    for (int i = 0; i < ad_pool_threads(program->pool); i++) {
        fits = fits && (uintptr_t)program->workspaces[i] % 64 == 0;
    }
    return (fits && tile >= TILE_STEP && tile % TILE_STEP == 0) ||
           ad_verify_wrong(v, "workspaces do not have the size or alignment that tiles of %zu need",
                           tile);
}

static bool replay(verifier *v)
{
    const ad_program *program = v->program;
    for (int s = 0; s <= program->pass_count; s++) {
        const pass *p = &program->passes[s];
        v->pass = s;
        if (!ad_verify_evaluated(v, p)) {
            return false;
        }
        if (s == program->pass_count) {
            break;
        }
        if (!replay_pass(v, p, false) || !replay_pass(v, p, true)) {
            return false;
        }
        for (int i = 0; i < p->reduced; i++) {
            v->ready[p->reduced_offset + i] = true;
        }
        for (int i = 0; i < p->output_count; i++) {
            v->outputs[p->outputs[i].number]++;
        }
    }
    for (int i = 0; i < program->outputs; i++) {
        int id = program->output_ids[i];
        bool batch = v->tape->nodes[id].extent != AD_UNIFORM;
        if (v->outputs[i] != batch) {
            return ad_verify_wrong(v, "output %d is written %d times", i, v->outputs[i]);
        }
        if (!batch && !ad_verify_ready(v, id)) {
            return false;
        }
    }
    return true;
}

ad_status ad_program_verify(const ad_program *program, ad_error *error)
{
    verifier v = {.program = program, .tape = program->tape, .instruction = -1, .error = error};
    size_t uniform = (size_t)program->uniform_count, units = (size_t)program->most_units + 1;
    v.ready = calloc(3 * uniform, sizeof *v.ready);
    v.owned = v.ready ? v.ready + uniform : NULL;
    v.constant = v.ready ? v.ready + 2 * uniform : NULL;
    v.sums = calloc(uniform, sizeof *v.sums);
    v.outputs = calloc((size_t)program->outputs, sizeof *v.outputs);
    v.member = calloc((size_t)program->member_rows + 1, sizeof *v.member);
    v.unit = calloc(2 * units, sizeof *v.unit);
    v.reader = v.unit ? v.unit + units : NULL;
    if (ad_formulas_create(program, &v.formulas) && v.ready && v.sums && v.outputs && v.unit &&
        v.member) {
        (void)(check_workspace(&v) && ad_verify_uniforms(&v) && replay(&v));
    } else {
        v.status = ad_fail(error, AD_NO_MEMORY, "out of memory while verifying a program");
    }
    ad_formulas_clear(&v.formulas);
    free(v.ready);
    free(v.sums);
    free(v.outputs);
    free(v.member);
    free(v.unit);
    return v.status;
}
