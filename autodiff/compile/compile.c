/* From a tape to a program: what is needed, in which pass, which instructions. */
#include "autodiff/compile/compile.h"

#include "autodiff/dense.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

ad_status (*ad_program_check)(const ad_program *program, ad_error *error);

/* Tiles are whole strips of products (products.c) for every instruction set. */
enum {
    TILE_STRIP = 24,
    TILE_MAX = 5 * TILE_STRIP,
    TILE_ALLOWED = 1 << 16,
    ROWS_MAX = INT_MAX / 64
};

ad_settings ad_settings_default(void)
{
    return (ad_settings){.tile = 0, .piece = 256, .fuse = true};
}

static ad_status no_memory(ad_error *error)
{
    return ad_fail(error, AD_NO_MEMORY, "out of memory while compiling a tape");
}

static void *copy_of(const void *from, size_t count, size_t item)
{
    void *to = malloc((count + 1) * item);
    if (to && count) {
        memcpy(to, from, count * item);
    }
    return to;
}

/* What a program keeps of its tape: nodes, arguments, numbers, rows of inputs. */
static ad_tape *tape_copy(const ad_tape *tape)
{
    ad_tape *copy = calloc(1, sizeof *copy);
    if (!copy) {
        return NULL;
    }
    copy->count = tape->count;
    copy->inputs = tape->inputs;
    copy->uniforms = tape->uniforms;
    copy->members = tape->members;
    copy->nodes = copy_of(tape->nodes, (size_t)tape->count, sizeof *tape->nodes);
    copy->arguments =
        copy_of(tape->arguments, (size_t)tape->argument_count, sizeof *tape->arguments);
    copy->numbers = copy_of(tape->numbers, (size_t)tape->number_count, sizeof *tape->numbers);
    copy->names = copy_of(tape->names, (size_t)tape->name_count, sizeof *tape->names);
    copy->name_count = tape->name_count;
    copy->text = copy_of(tape->text, (size_t)tape->text_count, 1);
    copy->input_rows = copy_of(tape->input_rows, (size_t)tape->inputs, sizeof(int));
    copy->input_extent = copy_of(tape->input_extent, (size_t)tape->inputs, 1);
    copy->uniform_rows = copy_of(tape->uniform_rows, (size_t)tape->uniforms, sizeof(int));
    if (!copy->nodes || !copy->arguments || !copy->numbers || !copy->names || !copy->text ||
        !copy->input_rows || !copy->input_extent || !copy->uniform_rows) {
        ad_tape_free(copy);
        return NULL;
    }
    return copy;
}

/* ---- what is needed, and when --------------------------------------------------------------- */

static void mark_needed(compilation *c)
{
    for (int i = 0; i < c->program->outputs; i++) {
        c->needed[c->program->output_ids[i]] = true;
        c->uses[c->program->output_ids[i]] += 2; /* never absorbed by a user */
    }
    for (int id = c->tape->count - 1; id >= 0; id--) {
        for (int i = 0; c->needed[id] && i < c->tape->nodes[id].count; i++) {
            c->needed[argument(c, id, i)] = true;
            c->uses[argument(c, id, i)]++;
        }
    }
}

/* Places are numbered by int. A value per point may stand in a panel, whose rows are longer. */
static ad_status check_rows(const compilation *c, ad_error *error)
{
    long long uniform = 1, batch = 0;
    for (int id = 0; id < c->tape->count; id++) {
        const node *n = &c->tape->nodes[id];
        long long rows = c->needed[id] ? n->rows : 0;
        batch += n->extent != AD_UNIFORM ? rows : 0;
        uniform += n->extent == AD_UNIFORM && n->op != OP_PARAMETER ? rows : 0;
    }
    if (uniform > INT_MAX || batch > ROWS_MAX) {
        return ad_fail(error, AD_BAD_SHAPE,
                       "compile: values of %lld rows per point and %lld rows for all points; at "
                       "most %d and %d are allowed",
                       batch, uniform, ROWS_MAX, INT_MAX);
    }
    return AD_OK;
}

/* ---- uniform values ------------------------------------------------------------------------- */

static place uniform_place(compilation *c, int rows)
{
    place p = {.kind = PLACE_UNIFORM, .offset = c->program->uniform_count, .stride = 1};
    p.rows = rows;
    c->program->uniform_count += rows;
    return p;
}

/* The sums of one pass lie side by side, then every other uniform value. */
static void place_uniforms(compilation *c)
{
    ad_program *program = c->program;
    program->uniform_count = 1; /* number 0 is a zero, for padding */
    for (int s = 0; s < program->pass_count; s++) {
        pass *p = &program->passes[s];
        p->reduced_offset = program->uniform_count;
        for (int id = 0; id < c->tape->count; id++) {
            if (c->sum_of[id] == id && c->tape->nodes[id].extent == AD_UNIFORM &&
                ad_stages_summed_by(c, id, p)) {
                program->places[id] = uniform_place(c, c->tape->nodes[id].rows);
            }
        }
        p->reduced = program->uniform_count - p->reduced_offset;
        program->info.reduced += (size_t)p->reduced;
    }
    for (int id = 0; id < c->tape->count; id++) {
        const node *n = &c->tape->nodes[id];
        if (!c->needed[id] || n->extent != AD_UNIFORM || c->sum_of[id] >= 0) {
            continue;
        }
        if (n->op == OP_PARAMETER) {
            program->places[id] = (place){
                .kind = PLACE_PARAMETER, .offset = (int)n->offset, .stride = 1, .rows = n->rows};
        } else if (n->op == OP_SLICE) {
            program->places[id] = program->places[argument(c, id, 0)];
            program->places[id].offset += n->whole;
            program->places[id].rows = n->rows;
        } else {
            program->places[id] = uniform_place(c, n->rows);
        }
    }
}

static bool write_constants(compilation *c)
{
    ad_program *program = c->program;
    AD_TAKE(program, uniform, program->uniform_count);
    for (int id = 0; program->uniform && id < c->tape->count; id++) {
        const node *n = &c->tape->nodes[id];
        for (int row = 0; c->needed[id] && n->op == OP_CONSTANT && row < n->rows; row++) {
            program->uniform[program->places[id].offset + row] =
                n->splat ? n->number : c->tape->numbers[n->offset + (size_t)row];
        }
    }
    return program->uniform != NULL;
}

static bool list_uniforms(compilation *c, pass *p, int stage)
{
    AD_TAKE_OF(&c->program->memory, p->uniforms, c->tape->count + 1);
    for (int id = 0; p->uniforms && id < c->tape->count; id++) {
        const node *n = &c->tape->nodes[id];
        bool computed = n->op != OP_CONSTANT && n->op != OP_PARAMETER && n->op != OP_SLICE;
        if (c->needed[id] && n->extent == AD_UNIFORM && c->stage[id] == stage && computed &&
            c->sum_of[id] < 0) {
            p->uniforms[p->uniform_count++] = id;
        }
    }
    return p->uniforms != NULL;
}

/* ---- passes --------------------------------------------------------------------------------- */

/* ---- values of members ---------------------------------------------------------------------- */

static void place_member(compilation *c, int id)
{
    int rows = c->tape->nodes[id].rows;
    c->program->places[id] = (place){.kind = PLACE_MEMBER, .stride = 1, .rows = rows};
    c->program->places[id].offset = c->program->member_rows;
    c->program->member_rows += rows;
}

/* The sums of one pass lie side by side, then all that passes from one pass to another. */
static void place_members(compilation *c)
{
    for (int s = 0; s < c->program->pass_count; s++) {
        pass *p = &c->program->passes[s];
        p->summed_offset = c->program->member_rows;
        for (int id = 0; id < c->tape->count; id++) {
            const node *n = &c->tape->nodes[id];
            if (c->needed[id] && op_is_reduction(n->op) && n->extent == AD_MEMBER &&
                ad_stages_summed_by(c, id, p)) {
                place_member(c, id);
            }
        }
        p->summed = c->program->member_rows - p->summed_offset;
    }
    for (int id = 0; id < c->tape->count; id++) {
        if (c->kept[id] && !op_is_reduction(c->tape->nodes[id].op)) {
            place_member(c, id);
        }
    }
}

static void fill_plan(const compilation *c, pass_plan *plan, const pass *p)
{
    memset(plan->uses, 0, (size_t)plan->count * sizeof *plan->uses);
    for (int id = 0; id < plan->count; id++) {
        plan->nodes[id] = c->tape->nodes[id];
        if (!c->in[id]) {
            plan->nodes[id].op = OP_COUNT;
            plan->nodes[id].count = 0;
            continue;
        }
        if (ad_stages_is_there(c, id, p) || plan->nodes[id].op == OP_SPREAD) {
            plan->nodes[id].op = OP_SPREAD; /* read from the memory of the members */
            plan->nodes[id].count = 0;
        }
        plan->uses[id] += c->stored[id];
        for (int i = 0; i < plan->nodes[id].count; i++) {
            plan->uses[argument(c, id, i)]++;
            if (i < AD_ARITY_MAX) {
                plan->arguments[id][i] = argument(c, id, i);
            }
        }
    }
    for (int i = 0; i < c->program->outputs; i++) {
        plan->uses[c->program->output_ids[i]]++;
    }
}

static bool list_outputs(compilation *c, const pass_plan *plan, pass *p)
{
    ad_program *program = c->program;
    int *units = program->input_units + (p - program->passes) * c->tape->inputs;
    size_t stored = 0;
    for (int id = 0; id < plan->count; id++) {
        stored += c->stored[id];
    }
    AD_TAKE_OF(&program->memory, p->outputs, program->outputs);
    AD_TAKE_OF(&program->memory, p->kept, stored);
    if (program->memory.is_short) {
        return false;
    }
    for (int i = 0; i < program->outputs; i++) {
        int id = program->output_ids[i];
        if (c->tape->nodes[id].extent == (p->members ? AD_MEMBER : AD_BATCH) &&
            c->stage[id] == p->stage) {
            p->outputs[p->output_count++] = (batch_output){i, plan->places[id]};
        }
    }
    for (int id = 0; id < plan->count; id++) {
        if (plan->nodes[id].op == OP_INPUT) {
            units[plan->nodes[id].whole] = plan->places[id].offset;
        }
        if (c->stored[id]) {
            p->kept[p->kept_count++] = (batch_output){program->places[id].offset, plan->places[id]};
        }
    }
    return true;
}

static bool compile_pass(compilation *c, pass *p)
{
    size_t count = (size_t)c->tape->count + 1;
    pass_plan plan = {.program = c->program, .tape = c->tape, .count = c->tape->count};
    AD_TAKE(&plan, nodes, count);
    AD_TAKE(&plan, arguments, count);
    AD_TAKE(&plan, places, count);
    AD_TAKE(&plan, uses, count);
    AD_TAKE(&plan, level, count);
    AD_TAKE(&plan, order, count);
    AD_TAKE(&plan, position, count);
    AD_TAKE(&plan, parent, count);
    AD_TAKE(&plan, row, count);
    AD_TAKE(&plan, panel, count);
    AD_TAKE(&plan, column, count);
    AD_TAKE(&plan, panel_columns, count);
    bool ok = !plan.memory.is_short;
    if (ok) {
        plan.sum_of = c->sum_of;
        plan.stored = c->stored;
        ad_stages_mark(c, p);
        fill_plan(c, &plan, p);
        ok = ad_plan_layout(&plan, p) && ad_emit_pass(&plan, p) && list_outputs(c, &plan, p);
    }
    ad_memory_free(&plan.memory);
    return ok;
}

/* ---- the program ---------------------------------------------------------------------------- */

static void count_instructions(ad_program *program)
{
    ad_program_info *info = &program->info;
    for (int s = 0; s < program->pass_count; s++) {
        const pass *p = &program->passes[s];
        info->instructions += (size_t)p->count;
        info->passes++;
        for (int g = 0; g < p->group_count; g++) {
            info->groups += p->groups[g].pieces;
        }
        for (int i = 0; i < p->count; i++) {
            const instruction *now = &p->instructions[i];
            size_t scratch = ad_execute_scratch(now);
            scratch = (scratch + TILE_STEP - 1) / TILE_STEP * TILE_STEP;
            program->scratch = scratch > program->scratch ? scratch : program->scratch;
            info->products += instruction_flops(now) > 0;
            *(p->members ? &info->flops_per_member : &info->flops_per_point) +=
                instruction_flops(now);
        }
        program->most_summed = p->summed > program->most_summed ? p->summed : program->most_summed;
        program->most_reduced =
            p->reduced > program->most_reduced ? p->reduced : program->most_reduced;
        program->most_units = p->units > program->most_units ? p->units : program->most_units;
    }
}

/* A workspace of five eighths of the second cache, which also holds parameters and sums. Larger
 * tiles have fewer calls, but the values of layers that rest from the way forward to the way back
 * are then fetched from the third cache. */
static int choose_tile(const ad_program *program)
{
    if (program->settings.tile > 0) {
        int steps = (program->settings.tile + TILE_STEP - 1) / TILE_STEP;
        return steps * TILE_STEP;
    }
    long cache = sysconf(_SC_LEVEL2_CACHE_SIZE);
    size_t budget = (cache > 0 ? (size_t)cache : 1u << 20) / 8 * 5;
    size_t per_point = (size_t)program->most_units * sizeof(double);
    size_t tile = per_point ? budget / per_point / TILE_STRIP * TILE_STRIP : TILE_MAX;
    return tile < TILE_STRIP ? TILE_STRIP : tile > TILE_MAX ? TILE_MAX : (int)tile;
}

static bool allocate_workspaces(ad_program *program)
{
    int threads = ad_pool_threads(program->pool);
    program->tile = choose_tile(program);
    program->info.tile = program->tile;
    size_t numbers = (size_t)program->most_units * (size_t)program->tile;
    program->workspace_numbers = numbers;
    numbers += program->scratch + (program->members ? (size_t)program->tile : 0);
    program->info.workspace_bytes = numbers * sizeof(double);
    AD_TAKE(program, workspaces, threads);
    for (int i = 0; program->workspaces && i < threads; i++) {
        AD_TAKE(program, workspaces[i], numbers + TILE_STEP);
    }
    return !program->memory.is_short;
}

/* Working memory, and what is needed. */
static ad_status begin(compilation *c, ad_error *error)
{
    size_t count = (size_t)c->tape->count + 1;
    c->needed = calloc(4 * count, sizeof *c->needed);
    c->stage = calloc(4 * count, sizeof *c->stage);
    AD_TAKE(c->program, places, count);
    if (!c->needed || !c->stage || !c->program->places) {
        return no_memory(error);
    }
    c->in = c->needed + count;
    c->kept = c->needed + 2 * count;
    c->stored = c->needed + 3 * count;
    c->uses = c->stage + count;
    c->sum_of = c->stage + 2 * count;
    c->home = c->stage + 3 * count;
    memset(c->home, -1, count * sizeof *c->home);
    mark_needed(c);
    return check_rows(c, error);
}

/* False: out of memory. */
static bool build(compilation *c)
{
    ad_program *program = c->program;
    if (!ad_stages_assign(c)) {
        return false;
    }
    int passes = program->pass_count;
    size_t inputs = (size_t)passes * (size_t)c->tape->inputs + 1;
    if (!AD_TAKE(program, input_units, inputs)) {
        return false;
    }
    memset(program->input_units, -1, inputs * sizeof *program->input_units);
    place_uniforms(c);
    place_members(c);
    bool ok = write_constants(c);
    for (int s = 0; ok && s <= passes; s++) {
        pass *p = &program->passes[s];
        bool first = s == 0 || p->stage != p[-1].stage;
        ok = list_uniforms(c, p, first ? p->stage : -1) && (s == passes || compile_pass(c, p));
    }
    for (int id = 0; id < c->tape->count; id++) {
        program->info.dead += !c->needed[id];
    }
    count_instructions(program);
    return ok && allocate_workspaces(program);
}

static ad_status check_request(int count, const ad_value *outputs, const ad_settings *settings,
                               ad_error *error)
{
    if (settings && (settings->tile < 0 || settings->tile > TILE_ALLOWED)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "compile: tiles of %d points; 0 to %d are allowed",
                       settings->tile, TILE_ALLOWED);
    }
    if (count < 1 || !outputs[0].tape) {
        return ad_fail(error, AD_BAD_ARGUMENT, "compile: no outputs");
    }
    if (ad_tape_status(outputs[0].tape, error) != AD_OK) {
        return outputs[0].tape->error.status;
    }
    for (int i = 0; i < count; i++) {
        if (!ad_is_valid(outputs[i]) || outputs[i].tape != outputs[0].tape) {
            return ad_fail(error, AD_BAD_ARGUMENT, "compile: output %d is not of this tape", i);
        }
    }
    return AD_OK;
}

ad_status ad_compile(int count, const ad_value *outputs, const ad_settings *settings, ad_pool *pool,
                     ad_program **result, ad_error *error)
{
    *result = NULL;
    ad_status status = check_request(count, outputs, settings, error);
    if (status != AD_OK) {
        return status;
    }
    status = ad_dense_load(error);
    if (status != AD_OK) {
        return status;
    }
    ad_program *program = calloc(1, sizeof *program);
    if (!program) {
        return no_memory(error);
    }
    program->pool = pool;
    program->kernels = ad_kernels_select();
    program->settings = settings ? *settings : ad_settings_default();
    program->outputs = count;
    AD_TAKE(program, output_ids, count);
    program->tape = tape_copy(outputs[0].tape);
    compilation c = {.program = program, .tape = program->tape};
    bool ok = program->output_ids && program->tape;
    for (int i = 0; ok && i < count; i++) {
        program->output_ids[i] = outputs[i].id;
    }
    status = ok ? begin(&c, error) : no_memory(error);
    if (status == AD_OK && !build(&c)) {
        status = no_memory(error);
    }
    if (status == AD_OK && ad_program_check) {
        status = ad_program_check(program, error);
    }
    free(c.needed);
    free(c.stage);
    if (status != AD_OK) {
        ad_program_free(program);
        return status;
    }
    *result = program;
    return AD_OK;
}

void ad_program_free(ad_program *program)
{
    if (!program) {
        return;
    }
    ad_fuse_clear(program);
    for (int s = 0; program->passes && s <= program->pass_count; s++) {
        free(program->passes[s].instructions);
    }
    ad_tape_free(program->tape);
    ad_memory_free(&program->memory);
    free(program->sums);
    free(program->member);
    free(program->shares);
    free(program);
}

ad_program_info ad_program_inspect(const ad_program *program)
{
    return program->info;
}
