/* Replay a program over tiles of points.
 *
 * Points are cut into tiles and tiles dealt to chunks, both by the number of points alone, never by
 * the number of threads. A chunk adds up its tiles in order, whichever thread takes it, and the
 * chunks are added pairwise in order: so the sums are the same to the last bit for any number of
 * threads. */
#include "autodiff/program.h"

#include <stdlib.h>
#include <string.h>

enum { CHUNKS_FEW = 8, CHUNKS_MANY = 64, SLICE = 4096 };

typedef struct execution {
    ad_program *program;
    const ad_run *run;
    const pass *pass;
    const int *input_units;
    int tile; /* points per tile of this run, a multiple of 8 */
    size_t tiles, chunks;
    size_t slices, width; /* of the final sum */
} execution;

/* One tile at work. */
struct tile_state {
    const execution *e;
    double *workspace;
    double *sums;
    const double *base[3]; /* by place_kind: where its values lie */
    ptrdiff_t unit[3];     /* by place_kind: numbers per unit of offset and stride */
    int tile;
    int width; /* points computed: `valid` rounded up to a multiple of 8 */
    int valid;
};

static size_t minimum(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* ---- instructions --------------------------------------------------------------------------- */

static tile_state begin(const execution *e, int thread)
{
    const ad_program *program = e->program;
    tile_state t = {.e = e, .workspace = program->workspaces[thread], .tile = e->tile};
    t.base[PLACE_TILE] = t.workspace;
    t.base[PLACE_UNIFORM] = program->uniform;
    t.base[PLACE_PARAMETER] = e->run->parameters;
    t.unit[PLACE_TILE] = e->tile;
    t.unit[PLACE_UNIFORM] = t.unit[PLACE_PARAMETER] = 1;
    return t;
}

static double *tile_at(const tile_state *t, place p, int row)
{
    return t->workspace + (ptrdiff_t)(p.offset + row * p.stride) * t->tile;
}

static kernel_operand operand(const tile_state *t, place p, int row)
{
    ptrdiff_t unit = t->unit[p.kind];
    return (kernel_operand){t->base[p.kind] + (p.offset + row * p.stride) * unit, p.stride * unit};
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

static void multiply_rows(const tile_state *t, place out, int row, int rows, kernel_operand a,
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
            multiply_rows(t, i->out, row, 1, operand(t, i->in[0], entry), operand(t, i->in[1], j),
                          j > 0, mask);
        }
    }
}

static void run_outer(const tile_state *t, const instruction *i)
{
    int k = i->in[1].rows;
    for (int row = 0; row < i->in[0].rows; row++) {
        kernel_operand y = operand(t, i->in[0], row);
        y.stride = 0;
        multiply_rows(t, i->out, row * k, k, y, operand(t, i->in[1], 0), false,
                      mask_of(i->in[0], i->in[1]));
    }
}

static void run_other(const tile_state *t, const instruction *i)
{
    switch (i->op) {
    case OP_MATVEC:
    case OP_MATVEC_TRANSPOSED:
        if (i->in[0].kind == PLACE_TILE) {
            run_point_matvec(t, i);
        } else {
            run_matvec(t, i);
        }
        break;
    case OP_OUTER:
        run_outer(t, i);
        break;
    case OP_OUTER_SUM:
        run_outer_sum(t, i);
        break;
    default: /* OP_SUM_POINTS */
        t->e->program->kernels->sum_points(i->in[0].rows, t->valid,
                                           t->sums + (i->out.offset - t->e->pass->reduced_offset),
                                           operand(t, i->in[0], 0));
    }
}

/* ---- tiles and chunks ------------------------------------------------------------------------ */

static void read_inputs(const tile_state *t, size_t start)
{
    const ad_tape *tape = t->e->program->tape;
    const ad_run *run = t->e->run;
    for (int i = 0; i < tape->inputs; i++) {
        int unit = t->e->input_units[i];
        for (int row = 0; unit >= 0 && row < tape->input_rows[i]; row++) {
            const double *from = run->inputs[i] + (size_t)row * run->points + start;
            double *to = t->workspace + (ptrdiff_t)(unit + row) * t->tile;
            memcpy(to, from, (size_t)t->valid * sizeof *to);
            for (int j = t->valid; j < t->width; j++) {
                to[j] = from[t->valid - 1]; /* points that do not count, with numbers that do */
            }
        }
    }
}

static void write_outputs(const tile_state *t, size_t start)
{
    const ad_run *run = t->e->run;
    for (int i = 0; i < t->e->pass->output_count; i++) {
        batch_output o = t->e->pass->outputs[i];
        for (int row = 0; run->outputs[o.number] && row < o.from.rows; row++) {
            memcpy(run->outputs[o.number] + (size_t)row * run->points + start,
                   tile_at(t, o.from, row), (size_t)t->valid * sizeof(double));
        }
    }
}

static void run_tile(tile_state *t, size_t number)
{
    size_t start = number * (size_t)t->tile;
    t->valid = (int)minimum((size_t)t->tile, t->e->run->points - start);
    t->width = (t->valid + TILE_STEP - 1) / TILE_STEP * TILE_STEP;
    read_inputs(t, start);
    bool fused = t->tile == t->e->program->fused_tile;
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

static void run_chunk(void *context, int chunk, int thread)
{
    const execution *e = context;
    tile_state t = begin(e, thread);
    t.sums = e->program->sums + (size_t)chunk * (size_t)e->program->most_reduced;
    memset(t.sums, 0, (size_t)e->pass->reduced * sizeof *t.sums);
    size_t first = (size_t)chunk * e->tiles / e->chunks;
    size_t end = ((size_t)chunk + 1) * e->tiles / e->chunks;
    for (size_t number = first; number < end; number++) {
        run_tile(&t, number);
        write_outputs(&t, number * (size_t)t.tile);
    }
}

/* Sum one slice of all chunks pairwise: (0+1)+(2+3), ... */
static void sum_slice(void *context, int slice, int thread)
{
    (void)thread;
    const execution *e = context;
    size_t row = (size_t)e->program->most_reduced, start = (size_t)slice * e->width;
    size_t count = minimum(e->width, (size_t)e->pass->reduced - start);
    double *sums = e->program->sums + start;
    for (size_t step = 1; step < e->chunks; step *= 2) {
        for (size_t c = 0; c + step < e->chunks; c += 2 * step) {
            double *to = sums + c * row;
            const double *from = to + step * row;
            for (size_t i = 0; i < count; i++) {
                to[i] += from[i];
            }
        }
    }
    memcpy(e->program->uniform + e->pass->reduced_offset + start, sums, count * sizeof *sums);
}

static void run_pass(execution *e)
{
    if (e->chunks == 0) {
        memset(e->program->uniform + e->pass->reduced_offset, 0,
               (size_t)e->pass->reduced * sizeof(double));
        return;
    }
    if (e->pass->count == 0 && e->pass->output_count == 0) {
        return;
    }
    ad_pool_run(e->program->pool, (int)e->chunks, run_chunk, e);
    e->width = SLICE;
    e->slices = ((size_t)e->pass->reduced + SLICE - 1) / SLICE;
    if (e->slices > 0) {
        ad_pool_run(e->program->pool, (int)e->slices, sum_slice, e);
    }
}

/* ---- runs ------------------------------------------------------------------------------------ */

static void cut(execution *e, size_t points)
{
    size_t wanted = (points + CHUNKS_FEW - 1) / CHUNKS_FEW; /* work for several threads */
    wanted = (wanted + TILE_STEP - 1) / TILE_STEP * TILE_STEP;
    wanted = wanted < TILE_MIN ? TILE_MIN : wanted;
    e->tile = (int)minimum(wanted, (size_t)e->program->tile);
    e->tiles = (points + (size_t)e->tile - 1) / (size_t)e->tile;
    size_t chunks = e->tiles / CHUNKS_FEW;
    chunks = chunks < CHUNKS_FEW ? CHUNKS_FEW : chunks;
    e->chunks = minimum(e->tiles, minimum(chunks, CHUNKS_MANY));
}

static bool make_room(ad_program *program, size_t chunks)
{
    if (chunks <= program->chunk_capacity) {
        return true;
    }
    size_t numbers = chunks * (size_t)program->most_reduced + 1;
    double *sums = realloc(program->sums, numbers * sizeof *sums);
    if (!sums) {
        return false;
    }
    program->sums = sums;
    program->chunk_capacity = chunks;
    return true;
}

ad_status ad_execute(ad_program *program, const ad_run *run, ad_error *error)
{
    execution e = {.program = program, .run = run};
    cut(&e, run->points);
    if (!make_room(program, e.chunks)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the sums of %zu chunks", e.chunks);
    }
    for (int s = 0; s < program->pass_count; s++) {
        e.pass = &program->passes[s];
        e.input_units = program->input_units + s * program->tape->inputs;
        ad_uniform_evaluate(program, e.pass, run);
        run_pass(&e);
    }
    ad_uniform_evaluate(program, &program->passes[program->pass_count], run);
    for (int i = 0; i < program->outputs; i++) {
        const node *n = &program->tape->nodes[program->output_ids[i]];
        if (n->extent == AD_UNIFORM && run->outputs[i]) {
            memcpy(run->outputs[i], ad_uniform_at(program, program->output_ids[i], run),
                   (size_t)n->rows * sizeof(double));
        }
    }
    return AD_OK;
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

void ad_execute_cut(ad_program *program, size_t points, int *tile, size_t *tiles)
{
    execution e = {.program = program};
    cut(&e, points);
    *tile = e.tile;
    *tiles = e.tiles;
}

void ad_execute_tiles(ad_program *program, const ad_run *run, size_t first, size_t count,
                      tile_work work, void *context)
{
    tile_job job = {
        {.program = program, .run = run, .pass = &program->passes[0]}, first, work, context};
    cut(&job.e, run->points);
    job.e.input_units = program->input_units;
    if (first == 0) {
        ad_uniform_evaluate(program, job.e.pass, run);
    }
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
