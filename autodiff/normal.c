/* J^T J without J. Slab by slab of points: first every tile of the slab writes its rows of J, as
 * columns of a matrix [parameters][rows of the slab], residual by residual; then blocks of J^T J,
 * each of two groups of columns, are dealt to the threads. Products take the columns that are live
 * in a residual; nothing else of the slab is written or read. So there is one J^T J, whatever the
 * number of threads, and each of its numbers is summed in the same order. */
#include "autodiff/normal.h"

#include <stdlib.h>
#include <string.h>

/* Numbers in a slab: large enough that reading and writing J^T J once per slab costs little. */
enum { SLAB_NUMBERS = 16 << 20 };

struct ad_normal {
    ad_program *program;
    jacobian jacobian;
    strips strips;
    size_t parameters;
    size_t slab_rows; /* so many rows of J have room; 0 before the first run */
    double *slab;     /* [parameters][slab_rows] */
    double *residual; /* [slab_rows] */
};

/* One run. */
typedef struct normal_run {
    const ad_normal *normal;
    const ad_run *run;
    double *jtj, *jtr;
    double *columns, *residual; /* where rows of J go: [parameters][stride], [stride] */
    size_t stride;
    int tile;
    size_t points; /* of the slab at hand: rows of J per residual */
    bool whole;    /* J itself is wanted, with its zeros */
} normal_run;

/* ---- making -------------------------------------------------------------------------------- */

ad_status ad_normal_check(int count, const ad_value *wrt, size_t parameters, ad_error *error)
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
                         "are not made: see ad_member_normal and ad_normal_product, or give "
                         "inputs of members per point");
    }
    if (status == AD_OK && normal->program->pass_count != 1) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "normal equations: residuals have to vary over the points and may not "
                         "contain sums over them");
    }
    if (status == AD_OK && ad_strips_create(j, normal->parameters, &normal->strips) != AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for normal equations");
    }
    return status;
}

/* Rows of a slab for a run over so many points. */
static size_t rows_for(const ad_normal *normal, size_t points)
{
    int tile;
    size_t tiles, most;
    ad_execute_cut(normal->program, points, &tile, &tiles);
    size_t tile_rows = (size_t)tile * (size_t)normal->jacobian.row_count;
    most = SLAB_NUMBERS / (normal->parameters * tile_rows + 1);
    most = most < 2 ? 2 : most;
    size_t rows = (tiles < most ? tiles : most) * tile_rows;
    return rows + (rows % 512 == 0 ? 8 : 0); /* spread over the cache's sets */
}

static bool make_room(ad_normal *normal, size_t points)
{
    size_t rows = rows_for(normal, points);
    if (rows <= normal->slab_rows) {
        return true;
    }
    free(normal->slab);
    free(normal->residual);
    normal->slab = calloc(rows, normal->parameters * sizeof *normal->slab);
    normal->residual = calloc(rows, sizeof *normal->residual);
    normal->slab_rows = normal->slab && normal->residual ? rows : 0;
    return normal->slab_rows > 0;
}

ad_status ad_normal_compile(int count, const ad_value *residuals, int wrt_count,
                            const ad_value *wrt, size_t parameters, ad_pool *pool,
                            ad_normal **result, ad_error *error)
{
    *result = NULL;
    ad_status status = ad_normal_check(wrt_count, wrt, parameters, error);
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
        ad_strips_clear(&normal->strips);
        free(normal->slab);
        free(normal->residual);
        free(normal);
    }
}

ad_normal_info ad_normal_inspect(const ad_normal *normal, size_t points)
{
    size_t rows = (size_t)normal->jacobian.row_count, n = normal->parameters;
    size_t threads = (size_t)ad_pool_threads(normal->program->pool);
    return (ad_normal_info){.rows = rows,
                            .bytes = threads * normal->program->info.workspace_bytes,
                            .slab_bytes = rows_for(normal, points) * (n + 1) * sizeof(double),
                            .flops = ad_strips_flops(&normal->strips, (int)rows)};
}

void ad_normal_print(const ad_normal *normal, FILE *file)
{
    const strips *s = &normal->strips;
    file = file ? file : stderr;
    fprintf(file,
            "normal equations of %d residuals per point by %zu parameters, %zu flops per point\n",
            normal->jacobian.row_count, normal->parameters,
            ad_strips_flops(s, normal->jacobian.row_count));
    for (size_t i = 0; i < s->count; i++) {
        fprintf(file, "  columns %5zu to %5zu of J, in residuals", s->items[i].first,
                s->items[i].first + s->items[i].width - 1);
        for (int r = 0; r < normal->jacobian.row_count; r++) {
            if (s->items[i].live[r]) {
                fprintf(file, " %d", r);
            }
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

static void add_term(const normal_run *n, const tile_state *t, const jacobian_block *block,
                     jacobian_term term, double *out)
{
    static const double one = 1;
    bool y_uniform, x_uniform = true;
    int points = ad_execute_valid(t);
    ptrdiff_t stride = (ptrdiff_t)n->stride;
    kernel_operand y = ad_execute_output(t, term.y, &y_uniform), x = {&one, 0};
    if (term.x >= 0) {
        x = ad_execute_output(t, term.x, &x_uniform);
    }
    /* A block with outer products may have terms that are not: they have all its rows. */
    int columns = term.x >= 0 ? block->columns : 1;
    for (int i = term.first; i < term.first + term.rows; i++) {
        double *to = out + i * columns * stride;
        if (y_uniform || x_uniform) {
            add_uniform_outer(columns, points, to, stride, y.at + i * y.stride, y_uniform, x,
                              x_uniform);
        } else {
            n->normal->program->kernels->add_outer(columns, points, to, stride, y.at + i * y.stride,
                                                   x);
        }
    }
}

/* slab: the first column, where this residual's rows of J begin. */
static void clear_rows(const normal_run *n, int residual, int points, double *slab)
{
    const strips *s = &n->normal->strips;
    for (size_t i = 0; i < s->count; i++) {
        const strip *at = &s->items[i];
        for (size_t k = 0; (n->whole || at->live[residual]) && k < at->width; k++) {
            memset(slab + (at->first + k) * n->stride, 0, (size_t)points * sizeof *slab);
        }
    }
}

static void write_rows(void *context, const tile_state *t, size_t item)
{
    const normal_run *n = context;
    const jacobian *j = &n->normal->jacobian;
    int points = ad_execute_valid(t);
    for (int r = 0; r < j->row_count; r++) {
        bool uniform;
        size_t first = (size_t)r * n->points + item * (size_t)n->tile;
        const double *from = ad_execute_output(t, j->rows[r].residual, &uniform).at;
        for (int i = 0; i < points; i++) {
            n->residual[first + (size_t)i] = from[uniform ? 0 : i];
        }
        clear_rows(n, r, points, n->columns + first);
        for (int b = 0; b < j->rows[r].count; b++) {
            const jacobian_block *block = &j->blocks[j->rows[r].first + b];
            double *out = n->columns + first + block->offset * n->stride;
            for (int i = 0; i < block->count; i++) {
                add_term(n, t, block, j->terms[block->first + i], out);
            }
        }
    }
}

/* ---- sums of products ------------------------------------------------------------------------ */

/* A factor of a product: columns of J in some rows of the slab. */
typedef struct factor {
    size_t first, width, row, rows;
} factor;

/* Into jtj (and jtr). */
static void multiply(const normal_run *n, factor a, factor b)
{
    const ad_normal *normal = n->normal;
    const blas *library = normal->program->blas;
    int size = (int)normal->parameters, stride = (int)n->stride, depth = (int)a.rows;
    const double *rows = n->columns + a.first * n->stride + a.row;
    const double *columns = n->columns + b.first * n->stride + b.row;
    double *to = n->jtj + a.first * normal->parameters + b.first;
    if (a.first != b.first) {
        library->gemm(BLAS_ROW_MAJOR, BLAS_NORMAL, BLAS_TRANSPOSED, (int)a.width, (int)b.width,
                      depth, 1, rows, stride, columns, stride, 1, to, size);
        return;
    }
    library->syrk(BLAS_ROW_MAJOR, BLAS_UPPER, BLAS_NORMAL, (int)a.width, depth, 1, rows, stride, 1,
                  to, size);
    library->gemm(BLAS_ROW_MAJOR, BLAS_NORMAL, BLAS_NORMAL, (int)a.width, 1, depth, 1, rows, stride,
                  n->residual + a.row, 1, 1, n->jtr + a.first, 1);
}

/* What residuals first .. end - 1, alike in both groups, add to a block of J^T J. */
static void multiply_residuals(const normal_run *n, strip_group rows, strip_group columns,
                               int first, int end)
{
    const strips *s = &n->normal->strips;
    factor a = {.row = (size_t)first * n->points, .rows = (size_t)(end - first) * n->points};
    factor b = a;
    size_t before = rows.first, at = rows.first;
    for (; ad_strips_next(s, rows, first, &at, &a.first, &a.width); before = at) {
        size_t other = rows.first == columns.first ? before : columns.first;
        while (ad_strips_next(s, columns, first, &other, &b.first, &b.width)) {
            multiply(n, a, b);
        }
    }
}

/* Item of the triangle of blocks of J^T J. */
static void multiply_groups(void *context, int item, int thread)
{
    (void)thread;
    const normal_run *n = context;
    const strips *s = &n->normal->strips;
    size_t row = 0, column = (size_t)item;
    for (; column >= s->group_count - row; row++) { /* a row has group_count - row blocks */
        column -= s->group_count - row;
    }
    strip_group a = s->groups[row], b = s->groups[row + column];
    int count = n->normal->jacobian.row_count;
    for (int first = 0, end; first < count; first = end) {
        end = first + 1;
        while (end < count && ad_strips_alike(s, a, first, end) &&
               ad_strips_alike(s, b, first, end)) {
            end++;
        }
        multiply_residuals(n, a, b, first, end);
    }
}

ad_status ad_normal_add(ad_normal *normal, const ad_run *run, double *jtj, double *jtr, double *rtr,
                        ad_error *error)
{
    if (!make_room(normal, run->points)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for rows of a Jacobian");
    }
    normal_run n = {.normal = normal, .run = run, .jtj = jtj, .jtr = jtr};
    n.columns = normal->slab;
    n.residual = normal->residual;
    n.stride = normal->slab_rows;
    size_t tiles, row_count = (size_t)normal->jacobian.row_count;
    ad_execute_cut(normal->program, run->points, &n.tile, &tiles);
    size_t most = normal->slab_rows / ((size_t)n.tile * row_count),
           groups = normal->strips.group_count;
    for (size_t first = 0; first < tiles; first += most) {
        size_t count = tiles - first < most ? tiles - first : most;
        size_t points = (first + count) * (size_t)n.tile;
        n.points = (points < run->points ? points : run->points) - first * (size_t)n.tile;
        ad_execute_tiles(normal->program, run, first, count, write_rows, &n);
        for (size_t i = 0; i < n.points * row_count; i++) {
            *rtr += normal->residual[i] * normal->residual[i];
        }
        ad_pool_run(normal->program->pool, (int)(groups * (groups + 1) / 2), multiply_groups, &n);
    }
    return AD_OK;
}

void ad_normal_jacobian(ad_normal *normal, const ad_run *run, size_t first, size_t stride,
                        double *jt, double *r)
{
    normal_run n = {
        .normal = normal, .run = run, .stride = stride, .points = run->points, .whole = true};
    size_t tiles;
    n.columns = jt + first;
    n.residual = r + first;
    ad_execute_cut(normal->program, run->points, &n.tile, &tiles);
    ad_execute_tiles(normal->program, run, 0, tiles, write_rows, &n);
}
