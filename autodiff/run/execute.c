/* Replay a program over tiles of points, or of members.
 *
 * Points are cut into tiles and tiles dealt to leaves, both by the number of points alone, never by
 * the number of threads. A leaf adds up its tiles in order, whichever thread takes it, and the
 * leaves are added pairwise in order: so the sums are the same to the last bit for any number of
 * threads, or of ranks. What a thread takes at a time is a chunk, a whole part of the tree of
 * leaves, of which there are more for more ranks; each rank takes some of them (execute_ranks.c).
 *
 * Where there are values of members, a tile of points has whole members, or a part of one: the
 * points of a member are added up by the tile, or tile by tile and then in order. */
#include "autodiff/run/execute.h"

#include <stdlib.h>
#include <string.h>

enum { SLICE = 4096 };

/* ---- instructions --------------------------------------------------------------------------- */

static tile_state begin(const execution *e, int thread)
{
    const ad_program *program = e->program;
    tile_state t = {.e = e, .workspace = program->workspaces[thread], .tile = e->tile};
    t.scratch = t.workspace + program->workspace_numbers;
    t.row = t.scratch + program->scratch;
    t.base[PLACE_TILE] = t.workspace;
    t.base[PLACE_UNIFORM] = program->uniform;
    t.base[PLACE_PARAMETER] = e->run->parameters;
    t.unit[PLACE_TILE] = e->tile;
    t.unit[PLACE_UNIFORM] = t.unit[PLACE_PARAMETER] = 1;
    t.base[PLACE_MEMBER] = program->member;
    t.unit[PLACE_MEMBER] = (ptrdiff_t)e->members;
    return t;
}

static void run_elementwise(const tile_state *t, const instruction *i, int row, int rows)
{
    kernel_operand in[AD_ARITY_MAX];
    for (int k = 0; k < AD_ARITY_MAX; k++) { /* also of those it has not: no branch */
        in[k] = operand(t, i->in[k], i->in[k].local ? 0 : row);
    }
    i->loop(rows, t->width, tile_at(t, i->out, i->out.local ? 0 : row),
            (ptrdiff_t)i->out.stride * t->tile, in, i->whole, i->number);
}

static void run_group(const tile_state *t, const group *g)
{
    const instruction *first = &t->e->pass->instructions[g->first];
    int rows = first->out.rows, piece = rows;
    if (g->pieces) {
        piece = t->e->program->settings.piece / t->width;
        piece = piece < 1 ? 1 : piece;
    }
    for (int row = 0; row < rows; row += piece) {
        int height = rows - row < piece ? rows - row : piece;
        for (int i = 0; i < g->count; i++) {
            run_elementwise(t, first + i, row, height);
        }
    }
}

/* y = W x for `points` columns of a panel, from x and y on. */
static void multiply(const tile_state *t, const instruction *i, const double *x, double *y,
                     int points)
{
    bool transposed = i->op == OP_MATVEC_TRANSPOSED;
    int m = i->out.rows, k = i->in[1].rows;
    t->e->program->kernels->products->multiply(
        m, points, k, operand(t, i->in[0], 0).at, transposed ? 1 : k, transposed ? m : 1, x,
        (ptrdiff_t)i->in[1].stride * t->tile, y, (ptrdiff_t)i->out.stride * t->tile, false);
}

/* All columns of the panel at once when the tile is full, else column by column. */
static void run_matvec(const tile_state *t, const instruction *i)
{
    const double *x = tile_at(t, i->in[1], 0);
    double *y = tile_at(t, i->out, 0);
    if (t->width == t->tile) {
        multiply(t, i, x, y, i->columns * t->tile);
        return;
    }
    for (int c = 0; c < i->columns; c++) {
        multiply(t, i, x + c * t->tile, y + c * t->tile, t->width);
    }
}

size_t ad_execute_scratch(const instruction *i)
{
    int m = i->in[0].rows, k = i->in[1].rows;
    if (i->out.kind == PLACE_MEMBER) { /* the sum for one member */
        return (size_t)m * (size_t)(i->op == OP_OUTER_SUM ? k : 1);
    }
    /* a member's matrix */
    return op_is_matvec(i->op) && i->in[0].kind == PLACE_MEMBER ? (size_t)m : 0;
}

/* sum += y x^T, all columns of both panels at once when the tile is full. */
static void run_outer_sum(const tile_state *t, const instruction *i)
{
    const product_set *products = t->e->program->kernels->products;
    const double *y = tile_at(t, i->in[0], 0), *x = tile_at(t, i->in[1], 0);
    double *sum = t->sums + (i->out.offset - t->e->pass->reduced_offset);
    bool full = t->valid == t->tile;
    int count = full ? 1 : i->columns, points = full ? i->columns * t->tile : t->valid;
    for (int c = 0; c < count; c++) {
        products->add_outer_sum(i->in[0].rows, i->in[1].rows, points, y + c * t->tile,
                                (ptrdiff_t)i->in[0].stride * t->tile, x + c * t->tile,
                                (ptrdiff_t)i->in[1].stride * t->tile, sum);
    }
}

static unsigned mask_of(place a, place b)
{
    return (a.kind != PLACE_TILE ? 1u : 0) | (b.kind != PLACE_TILE ? 2u : 0);
}

void ad_execute_multiply_rows(const tile_state *t, place out, int row, int rows, kernel_operand a,
                              kernel_operand b, bool add, unsigned mask)
{
    const kernel_set *kernels = t->e->program->kernels;
    double *to = tile_at(t, out, row);
    kernel_operand in[3] = {a, b, {to, (ptrdiff_t)out.stride * t->tile}};
    kernel loop = kernels->loops[add ? OP_MUL_ADD : OP_MUL][mask];
    loop(rows, t->width, to, (ptrdiff_t)out.stride * t->tile, in, 0, 0);
}

/* A matrix of its own at every point. */
static void run_point_matvec(const tile_state *t, const instruction *i)
{
    bool transposed = i->op == OP_MATVEC_TRANSPOSED;
    int m = i->out.rows, k = i->in[1].rows;
    unsigned mask = mask_of(i->in[0], i->in[1]);
    for (int row = 0; row < m; row++) {
        for (int j = 0; j < k; j++) {
            int entry = transposed ? j * m + row : row * k + j;
            ad_execute_multiply_rows(t, i->out, row, 1, operand(t, i->in[0], entry),
                                     operand(t, i->in[1], j), j > 0, mask);
        }
    }
}

static void run_outer(const tile_state *t, const instruction *i)
{
    int k = i->in[1].rows;
    for (int row = 0; row < i->in[0].rows; row++) {
        kernel_operand y = operand(t, i->in[0], row);
        y.stride = 0;
        ad_execute_multiply_rows(t, i->out, row * k, k, y, operand(t, i->in[1], 0), false,
                                 mask_of(i->in[0], i->in[1]));
    }
}

static void run_other(const tile_state *t, const instruction *i)
{
    if (i->out.kind == PLACE_MEMBER) {
        ad_execute_member_sum(t, i);
        return;
    }
    switch (ad_op_table[i->op].form) {
    case FORM_SPREAD:
        ad_execute_spread(t, i);
        break;
    case FORM_PRODUCT:
        if (i->in[0].kind == PLACE_MEMBER) {
            ad_execute_member_matvec(t, i);
        } else if (i->in[0].kind == PLACE_TILE) {
            run_point_matvec(t, i);
        } else {
            run_matvec(t, i);
        }
        break;
    case FORM_OUTER:
        run_outer(t, i);
        break;
    case FORM_OUTER_SUM:
        run_outer_sum(t, i);
        break;
    default: /* a sum over points */
        t->e->program->kernels->sum_points(i->in[0].rows, t->valid,
                                           t->sums + (i->out.offset - t->e->pass->reduced_offset),
                                           operand(t, i->in[0], 0));
    }
}

/* ---- tiles and chunks ------------------------------------------------------------------------ */

static void read_inputs(const tile_state *t)
{
    const ad_tape *tape = t->e->program->tape;
    const ad_run *run = t->e->run;
    for (int i = 0; i < tape->inputs; i++) {
        int unit = t->e->input_units[i];
        for (int row = 0; unit >= 0 && row < tape->input_rows[i]; row++) {
            const double *from = run->inputs[i] + (size_t)row * t->e->count + t->start;
            double *to = t->workspace + (ptrdiff_t)(unit + row) * t->tile;
            memcpy(to, from, (size_t)t->valid * sizeof *to);
            for (int j = t->valid; j < t->width; j++) {
                to[j] = from[t->valid - 1]; /* points that do not count, with numbers that do */
            }
        }
    }
}

static void write_rows(const tile_state *t, place from, double *to)
{
    for (int row = 0; to && row < from.rows; row++) {
        memcpy(to + (size_t)row * t->e->count + t->start, tile_at(t, from, row),
               (size_t)t->valid * sizeof(double));
    }
}

static void write_outputs(const tile_state *t)
{
    const pass *p = t->e->pass;
    for (int i = 0; i < p->output_count; i++) {
        write_rows(t, p->outputs[i].from, t->e->run->outputs[p->outputs[i].number]);
    }
    for (int i = 0; i < p->kept_count; i++) {
        write_rows(t, p->kept[i].from,
                   t->e->program->member + (size_t)p->kept[i].number * t->e->members);
    }
}

static void run_tile(tile_state *t, size_t number)
{
    const execution *e = t->e;
    size_t first = number / e->parts * e->each, end = e->parts > 1 ? first + e->each : e->count;
    t->number = number;
    t->start = e->parts > 1 ? first + number % e->parts * e->step : number * e->step;
    t->valid = (int)minimum(e->step, end - t->start);
    t->width = (t->valid + TILE_STEP - 1) / TILE_STEP * TILE_STEP;
    read_inputs(t);
    bool fused = t->tile == e->pass->fused_tile;
    for (int g = 0; g < t->e->pass->group_count; g++) {
        const group *now = &t->e->pass->groups[g];
        const instruction *i = &t->e->pass->instructions[now->first];
        if (fused && now->fused_count > 0) {
            now->fused(t->workspace, t->e->program->uniform, t->e->run->parameters, t->width);
            g += now->fused_count - 1;
        } else if (op_is_elementwise(i->op)) {
            run_group(t, now);
        } else {
            run_other(t, i);
        }
    }
}

/* The sums of so many leaves; spare: as many rows of memory as they have levels above them. */
static void run_leaves(tile_state *t, size_t first, size_t count, double *sums, double *spare)
{
    const execution *e = t->e;
    const size_t half = count / 2, numbers = (size_t)e->pass->reduced, all = e->chunks * e->leaves;
    size_t number = first * e->tiles / all;
    const size_t end = (first + count) * e->tiles / all;
    if (number == end) {
        memset(sums, 0, numbers * sizeof *sums);
        return;
    }
    if (half > 0) {
        run_leaves(t, first, half, sums, spare);
        run_leaves(t, first + half, half, spare, spare + e->program->most_reduced);
        for (size_t i = 0; i < numbers; i++) {
            sums[i] += spare[i];
        }
        return;
    }
    t->sums = sums;
    memset(sums, 0, numbers * sizeof *sums);
    for (; number < end; number++) {
        run_tile(t, number);
        write_outputs(t);
    }
}

static void run_chunk(void *context, int item, int thread)
{
    const execution *e = context;
    tile_state t = begin(e, thread);
    const size_t row = (size_t)e->program->most_reduced, own = e->end_chunk - e->first_chunk,
                 spare = own + (size_t)thread * leaf_levels(e);
    run_leaves(&t, (e->first_chunk + (size_t)item) * e->leaves, e->leaves,
               e->program->sums + (size_t)item * row, e->program->sums + spare * row);
}

/* Sum one slice of the chunks at hand pairwise: (0+1)+(2+3), ..., as far as they belong together.
 */
static void sum_slice(void *context, int slice, int thread)
{
    (void)thread;
    const execution *e = context;
    size_t row = (size_t)e->program->most_reduced, start = (size_t)slice * e->width;
    size_t count = minimum(e->width, (size_t)e->pass->reduced - start);
    double *sums = e->program->sums + start;
    for (size_t step = 1; step < e->chunks; step *= 2) {
        const size_t pair = 2 * step;
        for (size_t c = (e->first_chunk + pair - 1) / pair * pair; c + step < e->end_chunk;
             c += pair) {
            double *to = sums + (c - e->first_chunk) * row;
            const double *from = to + step * row;
            const bool whole = minimum(c + pair, e->chunks) <= e->end_chunk;
            for (size_t i = 0; whole && i < count; i++) {
                to[i] += from[i];
            }
        }
    }
}

static void run_pass(execution *e)
{
    const pass *p = e->pass;
    if (e->chunks == 0) {
        memset(e->program->uniform + p->reduced_offset, 0, (size_t)p->reduced * sizeof(double));
        memset(e->program->member + (size_t)p->summed_offset * e->members, 0,
               (size_t)p->summed * e->members * sizeof(double));
        return;
    }
    if (p->count == 0 && p->output_count == 0 && p->kept_count == 0) {
        return;
    }
    if (e->end_chunk > e->first_chunk) {
        ad_pool_run(e->program->pool, (int)(e->end_chunk - e->first_chunk), run_chunk, e);
    }
    ad_execute_add_shares(e);
    e->width = SLICE;
    e->slices = ((size_t)e->pass->reduced + SLICE - 1) / SLICE;
    if (e->slices > 0 && e->end_chunk > e->first_chunk) {
        ad_pool_run(e->program->pool, (int)e->slices, sum_slice, e);
    }
    if (e->slices > 0) {
        ad_execute_sum(e);
    }
    ad_execute_gather(e);
}

/* ---- runs ------------------------------------------------------------------------------------ */

static size_t rounded_up(size_t count, size_t step)
{
    return (count + step - 1) / step * step;
}

/* Tiles of a number of whole members, or of equal parts of one. */
static void cut_members(execution *e)
{
    size_t tile = (size_t)e->tile;
    if (e->each <= tile) {
        e->step = tile / e->each * e->each;
        e->tiles = (e->count + e->step - 1) / e->step;
    } else {
        e->parts = (e->each + tile - 1) / tile;
        e->step = rounded_up((e->each + e->parts - 1) / e->parts, TILE_STEP);
        e->parts = (e->each + e->step - 1) / e->step;
        e->tiles = e->members * e->parts;
    }
    e->tile = (int)rounded_up(e->step, TILE_STEP);
}

void ad_execute_cut(execution *e, const pass *p, size_t points, size_t members)
{
    e->pass = p;
    e->members = members > 0 ? members : 1;
    e->each = p->members ? 1 : points / e->members;
    e->count = p->members ? e->members : points;
    e->parts = 1;
    size_t wanted = (e->count + CHUNKS_FEW - 1) / CHUNKS_FEW; /* work for several threads */
    wanted = rounded_up(wanted, TILE_STEP);
    wanted = wanted < TILE_MIN ? TILE_MIN : wanted;
    const size_t most = (size_t)e->program->tile, tiles = (e->count + most - 1) / most;
    if (tiles > CHUNKS_FEW) { /* as many for each of so many ranks or threads */
        const size_t each = rounded_up(tiles, CHUNKS_FEW);
        wanted = rounded_up((e->count + each - 1) / each, TILE_STEP);
    }
    e->tile = (int)minimum(wanted, most);
    e->step = (size_t)e->tile;
    e->tiles = (e->count + e->step - 1) / e->step;
    if (e->program->members && e->each > 1) {
        cut_members(e);
    }
    ad_execute_deal(e);
}

/* Memory for so many items of equally many numbers; what is in it is lost. */
static bool enlarge(double **memory, size_t *capacity, size_t items, int numbers)
{
    if (items <= *capacity) {
        return true;
    }
    double *larger = realloc(*memory, (items * (size_t)numbers + 1) * sizeof *larger);
    if (larger) {
        *memory = larger;
        *capacity = items;
    }
    return larger != NULL;
}

static bool make_room(execution *e, const ad_run *run)
{
    ad_program *program = e->program;
    bool ok = enlarge(&program->member, &program->member_capacity, run->members + 1,
                      program->member_rows);
    for (int s = 0; ok && s < program->pass_count; s++) {
        const pass *p = &program->passes[s];
        ad_execute_cut(e, p, run->points, run->members);
        ok = enlarge(&program->sums, &program->chunk_capacity,
                     rows_of_sums(e, e->end_chunk - e->first_chunk), program->most_reduced) &&
             ad_execute_make_room(e) &&
             enlarge(&program->shares, &program->share_capacity, e->parts > 1 ? e->tiles : 0,
                     program->most_summed);
    }
    return ok;
}

/* Of rows that are the same at all points. */
static void write_uniform(const ad_run *run, int rows, const double *from, double *to)
{
    const size_t times = run->everywhere ? run->points : 1;
    for (int row = 0; row < rows; row++) {
        for (size_t k = 0; k < times; k++) {
            *to++ = from[row];
        }
    }
}

ad_status ad_execute(ad_program *program, const ad_run *run, ad_error *error)
{
    execution e = {.program = program, .run = run};
    if (program->members && run->members > 1 && run->points % run->members != 0) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%zu points of %zu members: every member has to have equally many",
                       run->points, run->members);
    }
    if (!make_room(&e, run)) {
        return ad_fail(error, AD_NO_MEMORY,
                       "out of memory for the sums and values of %zu points and %zu members",
                       run->points, run->members);
    }
    for (int s = 0; s < program->pass_count; s++) {
        ad_execute_cut(&e, &program->passes[s], run->points, run->members);
        e.input_units = program->input_units + s * program->tape->inputs;
        ad_uniform_evaluate(program, e.pass, run);
        run_pass(&e);
    }
    ad_uniform_evaluate(program, &program->passes[program->pass_count], run);
    for (int i = 0; i < program->outputs; i++) {
        const node *n = &program->tape->nodes[program->output_ids[i]];
        if (n->extent == AD_UNIFORM && run->outputs[i]) {
            write_uniform(run, n->rows, ad_uniform_at(program, program->output_ids[i], run),
                          run->outputs[i]);
        }
    }
    return AD_OK;
}

ad_status ad_evaluate(int count, const ad_value *values, ad_pool *pool, const ad_run *run,
                      ad_error *error)
{
    ad_pool *own = pool ? NULL : ad_pool_create(1);
    ad_program *program = NULL;
    ad_status status = pool || own ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    if (status == AD_OK) {
        status = ad_compile(count, values, NULL, pool ? pool : own, &program, error);
    }
    status = status == AD_OK ? ad_execute(program, run, error) : status;
    ad_program_free(program);
    ad_pool_free(own);
    return status;
}

/* ---- tiles for others ------------------------------------------------------------------------ */

typedef struct tile_job {
    execution e;
    size_t first;
    tile_work work;
    void *context;
} tile_job;

static void run_tile_job(void *context, int item, int thread)
{
    const tile_job *job = context;
    const execution *e = &job->e;
    tile_state t = begin(e, thread);
    run_tile(&t, job->first + (size_t)item);
    job->work(job->context, &t, (size_t)item);
}

void ad_execute_tiling(ad_program *program, size_t points, int *tile, size_t *tiles)
{
    execution e = {.program = program};
    ad_execute_cut(&e, &program->passes[0], points, 1);
    *tile = e.tile;
    *tiles = e.tiles;
}

int ad_execute_tile(ad_program *program, const pass *p, size_t points, size_t members)
{
    execution e = {.program = program};
    ad_execute_cut(&e, p, points, members);
    return e.tile;
}

void ad_execute_begin(ad_program *program, const ad_run *run)
{
    ad_uniform_evaluate(program, &program->passes[0], run);
}

void ad_execute_tiles(ad_program *program, const ad_run *run, size_t first, size_t count,
                      tile_work work, void *context)
{
    tile_job job = {{.program = program, .run = run}, first, work, context};
    ad_execute_cut(&job.e, &program->passes[0], run->points, 1);
    job.e.input_units = program->input_units;
    ad_pool_run(program->pool, (int)count, run_tile_job, &job);
}

kernel_operand ad_execute_output(const tile_state *t, int output, bool *uniform)
{
    const ad_program *program = t->e->program;
    int id = program->output_ids[output];
    *uniform = program->tape->nodes[id].extent == AD_UNIFORM;
    if (*uniform) {
        return operand(t, program->places[id], 0);
    }
    const pass *p = t->e->pass;
    int i = 0;
    while (p->outputs[i].number != output) {
        i++;
    }
    return operand(t, p->outputs[i].from, 0);
}

int ad_execute_valid(const tile_state *t)
{
    return t->valid;
}
