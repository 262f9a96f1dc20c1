/* J^T J without J: how it is made, and the rows of J as tiles write them, into panels or as such.
 */
#include "autodiff/algebra/normal.h"

#include <stdlib.h>
#include <string.h>

/* ---- making -------------------------------------------------------------------------------- */

/* Are these recorded parameters, within the vector [parameters]? Else AD_BAD_ARGUMENT. */
static ad_status check(int count, const ad_value *wrt, size_t parameters, ad_error *error)
{
    for (int i = 0; i < count; i++) {
        bool inside = ad_is_valid(wrt[i]) && node_of(wrt[i])->op == OP_PARAMETER &&
                      node_of(wrt[i])->offset + (size_t)ad_rows(wrt[i]) <= parameters;
        if (!inside) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "normal equations: variable %d is not a parameter within the vector", i);
        }
    }
    return AD_OK;
}

/* Zeros, aligned for vectors; NULL: out of memory. */
static void make_space(ad_memory *memory, const normal_layout *l, normal_space *space)
{
    size_t sources = (size_t)l->source_count + 1, terms = sources + (size_t)l->weights_max;
    AD_TAKE_OF(memory, space->tiles, NORMAL_GROUP * NORMAL_GROUP * TILE);
    AD_TAKE_OF(memory, space->panels, NORMAL_GROUP * NORMAL_DEPTH * PANEL);
    AD_TAKE_OF(memory, space->by, sources * NORMAL_DEPTH);
    AD_TAKE_OF(memory, space->factors, terms);
    AD_TAKE_OF(memory, space->terms, terms);
    AD_TAKE_OF(memory, space->sources[0], sources);
    AD_TAKE_OF(memory, space->sources[1], sources);
    AD_TAKE_OF(memory, space->used, sources);
}

static bool make_spaces(ad_normal *normal)
{
    normal->threads = ad_pool_threads(normal->program->pool);
    AD_TAKE(normal, spaces, normal->threads);
    for (int i = 0; normal->spaces && i < normal->threads; i++) {
        make_space(&normal->memory, &normal->layout, &normal->spaces[i]);
    }
    return !normal->memory.is_short;
}

static ad_status compile(ad_normal *normal, int count, const ad_value *residuals, int wrt_count,
                         const ad_value *wrt, ad_pool *pool, ad_error *error)
{
    jacobian *j = &normal->jacobian;
    ad_status status = ad_jacobian_record(j, count, residuals, wrt_count, wrt);
    if (status != AD_OK || j->row_count == 0) {
        ad_status sticky = count > 0 ? ad_tape_status(residuals[0].tape, error) : AD_OK;
        return sticky != AD_OK ? sticky
               : status != AD_OK
                   ? ad_fail(error, status, "normal equations: %s", ad_status_text(status))
                   : ad_fail(error, AD_BAD_ARGUMENT, "normal equations: every residual is 0");
    }
    status = ad_compile(j->output_count, j->outputs, NULL, pool, &normal->program, error);
    if (status == AD_OK && normal->program->members) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "normal equations: residuals need values of members, of which rows of J "
                         "are not made: see ad_normal_product, or give inputs of members per "
                         "point");
    }
    if (status == AD_OK && normal->program->pass_count != 1) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "normal equations: residuals have to vary over the points and may not "
                         "contain sums over them");
    }
    if (status == AD_OK && (ad_normal_layout(j, normal->parameters, &normal->layout) != AD_OK ||
                            !make_spaces(normal))) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for normal equations");
    }
    return status;
}

/* Empty columns of panels are 0, and stay so. */
bool ad_normal_make_slab(ad_normal *normal, size_t points)
{
    const normal_layout *l = &normal->layout;
    normal_slab *slab = &normal->slab;
    size_t room = ad_normal_room(normal, points);
    if (room <= slab->room) {
        return true;
    }
    ad_memory_free(&slab->memory);
    AD_TAKE(slab, basis, (size_t)l->source_panels * room * PANEL);
    AD_TAKE(slab, plain, (size_t)l->plain_panels * (size_t)l->rows * room * PANEL);
    AD_TAKE(slab, weights, (size_t)l->weight_count * room);
    slab->room = slab->memory.is_short ? 0 : room;
    return slab->room > 0;
}

ad_status ad_normal_compile(int count, const ad_value *residuals, int wrt_count,
                            const ad_value *wrt, size_t parameters, ad_pool *pool,
                            ad_normal **result, ad_error *error)
{
    *result = NULL;
    ad_status status = check(wrt_count, wrt, parameters, error);
    if (status != AD_OK) {
        return status;
    }
    ad_normal *normal = calloc(1, sizeof *normal);
    if (!normal) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for normal equations");
    }
    normal->parameters = parameters;
    status = compile(normal, count, residuals, wrt_count, wrt, pool, error);
    if (status != AD_OK) {
        ad_normal_free(normal);
        return status;
    }
    *result = normal;
    return AD_OK;
}

void ad_normal_free(ad_normal *normal)
{
    if (normal) {
        ad_program_free(normal->program);
        ad_jacobian_clear(&normal->jacobian);
        ad_memory_free(&normal->memory);
        ad_normal_layout_clear(&normal->layout);
        ad_memory_free(&normal->slab.memory);
        free(normal->leaves);
        free(normal->packed);
        free(normal);
    }
}

ad_normal_info ad_normal_inspect(const ad_normal *normal, size_t points)
{
    size_t threads = (size_t)ad_pool_threads(normal->program->pool);
    size_t numbers = ad_normal_numbers(normal, points);
    return (ad_normal_info){.rows = (size_t)normal->jacobian.row_count,
                            .bytes = threads * normal->program->info.workspace_bytes,
                            .slab_bytes = numbers * sizeof(double),
                            .flops = ad_normal_flops(&normal->layout)};
}

void ad_normal_print(const ad_normal *normal, FILE *file)
{
    const normal_layout *l = &normal->layout;
    file = file ? file : stderr;
    fprintf(file,
            "normal equations of %d residuals per point by %zu parameters, %zu flops per point\n",
            l->rows, normal->parameters, ad_normal_flops(l));
    for (int i = 0; i < l->head_count; i++) {
        const normal_head *head = &l->heads[i];
        fprintf(file, "  columns %5zu to %5zu of J, by functions and residuals", head->column,
                head->column + (size_t)head->width - 1);
        for (int w = head->weight; w < head->weight + head->weights; w++) {
            fprintf(file, " %d:%d", l->weights[w].source, l->weights[w].residual);
        }
        fputc('\n', file);
    }
    for (int p = 0; p < l->plain_panels; p++) {
        fprintf(file, "  panel %d from column %zu of J on, in residuals", p, l->columns[p * PANEL]);
        for (int r = 0; r < l->rows; r++) {
            l->live[p * l->rows + r] ? (void)fprintf(file, " %d", r) : (void)0;
        }
        fputc('\n', file);
    }
    ad_program_print(normal->program, file);
}

ad_program *ad_normal_program(ad_normal *normal)
{
    return normal->program;
}

/* ---- rows of J ------------------------------------------------------------------------------- */

/* Columns of J at some points of a tile: where they go to, and what points. */
typedef struct patch {
    size_t first, width; /* columns */
    int from, points;    /* within the tile */
    double *out;         /* [width][stride] */
    ptrdiff_t stride;
} patch;

/* out += y x^T where a factor may be the same at every point. */
static void add_uniform_outer(int columns, int points, double *out, ptrdiff_t stride,
                              const double *y, bool y_uniform, kernel_operand x, bool x_uniform)
{
    for (int k = 0; k < columns; k++) {
        const double *from = x.at + k * x.stride;
        for (int j = 0; j < points; j++) {
            out[k * stride + j] += y[y_uniform ? 0 : j] * from[x_uniform ? 0 : j];
        }
    }
}

static size_t at_least(size_t a, size_t b)
{
    return a < b ? b : a;
}

/* Of one term what falls into the patch. */
static void add_term(const ad_normal *normal, const tile_state *t, const jacobian_block *block,
                     jacobian_term term, patch to)
{
    static const double one = 1;
    bool y_uniform, x_uniform = true;
    kernel_operand y = ad_execute_output(t, term.y, &y_uniform), x = {&one, 0};
    if (term.x >= 0) {
        x = ad_execute_output(t, term.x, &x_uniform);
    }
    /* A block with outer products may have terms that are not: they have all its rows. */
    size_t columns = term.x >= 0 ? (size_t)block->columns : 1, end = to.first + to.width;
    for (int i = term.first; i < term.first + term.rows; i++) {
        size_t begin = block->offset + (size_t)i * columns, first = at_least(begin, to.first);
        size_t last = begin + columns < end ? begin + columns : end;
        if (first >= last) {
            continue;
        }
        double *out = to.out + (ptrdiff_t)(first - to.first) * to.stride;
        kernel_operand factor = {
            x.at + (ptrdiff_t)(first - begin) * x.stride + (x_uniform ? 0 : to.from), x.stride};
        const double *by = y.at + i * y.stride + (y_uniform ? 0 : to.from);
        if (y_uniform || x_uniform) {
            add_uniform_outer((int)(last - first), to.points, out, to.stride, by, y_uniform, factor,
                              x_uniform);
        } else {
            normal->program->kernels->add_outer((int)(last - first), to.points, out, to.stride, by,
                                                factor);
        }
    }
}

static void add_columns(const ad_normal *normal, const tile_state *t, int residual, patch to)
{
    const jacobian *j = &normal->jacobian;
    for (int b = 0; b < j->rows[residual].count; b++) {
        const jacobian_block *block = &j->blocks[j->rows[residual].first + b];
        size_t size = (size_t)block->rows * (size_t)block->columns;
        bool apart = block->offset + size <= to.first || block->offset >= to.first + to.width;
        for (int i = 0; i < block->count && !apart; i++) {
            add_term(normal, t, block, j->terms[block->first + i], to);
        }
    }
}

/* Numbers of a row of an output at the points of a tile. */
static void copy_row(const tile_state *t, int output, int row, double *to)
{
    bool uniform;
    kernel_operand from = ad_execute_output(t, output, &uniform);
    for (int i = 0; i < ad_execute_valid(t); i++) {
        to[i] = from.at[row * from.stride + (uniform ? 0 : i)];
    }
}

/* Whole rows, for those who want J itself. */
static void write_rows(void *context, const tile_state *t, size_t item)
{
    const normal_run *n = context;
    const ad_normal *normal = n->normal;
    int points = ad_execute_valid(t);
    for (int r = 0; r < normal->jacobian.row_count; r++) {
        size_t first = (size_t)r * n->points + item * (size_t)n->tile;
        patch to = {0, normal->parameters, 0, points, n->columns + first, (ptrdiff_t)n->stride};
        for (size_t k = 0; k < normal->parameters; k++) {
            memset(to.out + k * n->stride, 0, (size_t)points * sizeof *to.out);
        }
        add_columns(normal, t, r, to);
        copy_row(t, normal->jacobian.rows[r].residual, 0, n->residual + first);
    }
}

/* ---- panels ---------------------------------------------------------------------------------- */

enum { PATCH = 64 }; /* points of a panel that are written together */

static int whole_vectors(int points)
{
    return (points + 7) / 8 * 8;
}

static void write_source(const normal_run *n, const tile_state *t, const normal_source *source,
                         size_t first)
{
    bool uniform;
    const normal_slab *slab = &n->normal->slab;
    kernel_operand x = ad_execute_output(t, source->x, &uniform);
    for (int k = 0; k < source->width; k += PANEL) {
        int width = source->width - k < PANEL ? source->width - k : PANEL;
        double *out =
            slab->basis + ((size_t)(source->panel + k / PANEL) * slab->room + first) * PANEL;
        kernel_operand part = {x.at + k * x.stride, x.stride};
        if (!uniform) {
            n->normal->program->kernels->products->transpose(
                width, whole_vectors(ad_execute_valid(t)), out, PANEL, part);
        }
        for (int i = 0; uniform && i < ad_execute_valid(t) * width; i++) {
            out[i / width * PANEL + i % width] = part.at[i % width * part.stride];
        }
    }
}

/* Plain columns of one residual, each run of neighbours by itself. */
static void write_panel(const normal_run *n, const tile_state *t, int panel, int residual,
                        size_t first)
{
    const ad_normal *normal = n->normal;
    const size_t *columns = normal->layout.columns + panel * PANEL;
    const normal_slab *slab = &normal->slab;
    size_t at = (size_t)(panel * normal->layout.rows + residual) * slab->room + first;
    _Alignas(64) double rows[PANEL][PATCH];
    for (int from = 0; from < ad_execute_valid(t); from += PATCH) {
        int left = ad_execute_valid(t) - from, points = left < PATCH ? left : PATCH;
        memset(rows, 0, sizeof rows);
        for (int i = 0, end; i < PANEL && columns[i] < normal->parameters; i = end) {
            for (end = i + 1; end < PANEL && columns[end] == columns[i] + (size_t)(end - i);) {
                end++;
            }
            patch to = {columns[i], (size_t)(end - i), from, points, rows[i], PATCH};
            add_columns(normal, t, residual, to);
        }
        for (int i = 0; i < PANEL; i++) {
            for (int k = 0; columns[i] == normal->parameters && k < points; k++) {
                bool uniform;
                kernel_operand r =
                    ad_execute_output(t, normal->jacobian.rows[residual].residual, &uniform);
                rows[i][k] = r.at[uniform ? 0 : from + k];
            }
        }
        kernel_operand written = {rows[0], PATCH};
        normal->program->kernels->products->transpose(PANEL, whole_vectors(points),
                                                      slab->plain + (at + (size_t)from) * PANEL,
                                                      PANEL, written);
    }
}

void ad_normal_write_panels(void *context, const tile_state *t, size_t item)
{
    const normal_run *n = context;
    const normal_layout *l = &n->normal->layout;
    const normal_slab *slab = &n->normal->slab;
    size_t first = item * (size_t)n->tile;
    for (int i = 0; i < l->source_count; i++) {
        write_source(n, t, &l->sources[i], first);
    }
    for (int i = 0; i < l->weight_count; i++) {
        copy_row(t, l->weights[i].y, l->weights[i].row,
                 slab->weights + (size_t)i * slab->room + first);
    }
    for (int p = 0; p < l->plain_panels; p++) {
        for (int r = 0; r < l->rows; r++) {
            if (l->live[p * l->rows + r]) {
                write_panel(n, t, p, r, first);
            }
        }
    }
}

void ad_normal_jacobian(ad_normal *normal, const ad_run *run, size_t first, size_t stride,
                        double *jt, double *r)
{
    normal_run n = {.normal = normal, .stride = stride, .points = run->points};
    size_t tiles;
    n.columns = jt + first;
    n.residual = r + first;
    ad_execute_tiling(normal->program, run->points, &n.tile, &tiles);
    ad_execute_begin(normal->program, run);
    ad_execute_tiles(normal->program, run, 0, tiles, write_rows, &n);
}
