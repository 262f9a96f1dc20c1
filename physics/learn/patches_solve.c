/* Gauss-Newton steps of a window: least squares by QR factors of a front that moves over the
 * patches.
 *
 * Patches are eliminated one after the other. The front has the columns of a patch and of those
 * that come within the distance of its furthest neighbour. Rows enter with the first patch they
 * belong to; what a patch's own rows say is a triangle first. So the matrix is never squared. Where
 * the slowest coordinate is periodic, its first patches stay until the end: so they are nobody's
 * far neighbours. Derivatives by unknown numbers are right sides, as the residual is. */
#include "physics/learn/patches_rows.h"

#include "autodiff/dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct front {
    patch_window *w;
    size_t size;    /* columns of a patch */
    int pinned;     /* the first patches, which come last */
    size_t globals; /* columns of these; right sides: by the unknowns, and the residual */
    int width;      /* patches in the front */
    int steps;      /* patches that are not pinned: patch k + pinned at step k */
    int *first;     /* [steps + 1] joints that enter at a step, */
    patch_joint *joints;
    double **own; /* [patches] triangles of (size + unknowns + 1) columns */
    size_t *own_rows;
    size_t tall;    /* rows of the front at most */
    double *a;      /* [columns][tall] */
    size_t carried; /* of these rows */
    double *r;      /* [steps][columns][size] of R */
    double *last;   /* [globals][globals], its triangle */
    size_t height;  /* of a patch's own rows at most */
    double **room;  /* [threads] */
    double *step;   /* [1 + unknowns][patches][size]: the step, and by how much fields change */
    ad_memory memory;
} front;

/* The block of the patch of a step; blocks of pinned ones, unknowns, the residual; then blocks of
 * the other patches of the front. */
static size_t columns_of(const front *f)
{
    return (size_t)f->width * f->size + f->globals;
}

static size_t own_columns(const front *f)
{
    return f->size + (size_t)f->w->p->unknowns + 1;
}

/* ---- the order ------------------------------------------------------------------------------- */

static void pin_patches(front *f)
{
    const patch_grid *grid = f->w->grid;
    int slow = 0;
    for (int d = 1; d < grid->dims; d++) {
        slow = grid->stride[d] > grid->stride[slow] ? d : slow;
    }
    const bool closed = f->w->p->model->domain.coordinates[slow].periodic;
    f->pinned = closed && grid->cells[slow] > 2 ? grid->stride[slow] : 0;
    f->steps = grid->patches - f->pinned;
    f->globals = (size_t)f->pinned * f->size + (size_t)f->w->p->unknowns + 1;
}

/* The step at which a joint enters; `steps`: after all, between pinned patches. */
static int entry_of(const front *f, const patch_joint *joint)
{
    const int a = joint->a - f->pinned, b = joint->b - f->pinned;
    const int first = a < b ? a : b, other = a < b ? b : a;
    return first >= 0 ? first : other >= 0 ? other : f->steps;
}

/* Where the columns of a patch are at a step. */
static size_t column_of(const front *f, int patch, int step)
{
    const int block = patch - f->pinned - step;
    return block == 0 && patch >= f->pinned ? 0
           : patch < f->pinned              ? (size_t)(1 + patch) * f->size
                                            : (size_t)block * f->size + f->globals;
}

static void order_joints(front *f)
{
    const patch_window *w = f->w;
    int next = 0;
    f->width = 1;
    for (int i = 0; i < w->joint_count; i++) {
        const patch_joint *joint = &w->joints[i];
        const int apart = abs(joint->a - joint->b);
        if (joint->a >= f->pinned && joint->b >= f->pinned && apart + 1 > f->width) {
            f->width = apart + 1;
        }
    }
    for (int k = 0; k <= f->steps; k++) {
        f->first[k] = next;
        for (int i = 0; i < w->joint_count; i++) {
            if (entry_of(f, &w->joints[i]) == k) {
                f->joints[next++] = w->joints[i];
            }
        }
    }
    f->first[f->steps + 1] = next;
}

static void make_room(front *f)
{
    const patch_window *w = f->w;
    const size_t patches = (size_t)w->grid->patches, steps = (size_t)f->steps;
    const size_t columns = columns_of(f), own = own_columns(f);
    const int threads = ad_pool_threads(w->p->settings->pool);
    size_t joined = 0;
    for (size_t k = 0; k <= steps; k++) {
        size_t here = 0;
        for (int i = f->first[k]; i < f->first[k + 1]; i++) {
            here += patch_joint_count(w, &f->joints[i]);
        }
        joined = here > joined ? here : joined;
    }
    for (size_t k = 0; k < patches; k++) {
        const size_t rows = patch_own_count(w, (int)k);
        f->height = rows > f->height ? rows : f->height;
    }
    f->height = f->height > own ? f->height : own;
    f->tall = columns + joined + own;
    AD_TAKE(f, a, columns * f->tall);
    AD_TAKE(f, r, steps * columns * f->size);
    AD_TAKE(f, last, f->globals * f->globals);
    AD_TAKE(f, step, (size_t)(1 + w->p->unknowns) * patches * f->size);
    for (size_t k = 0; k < patches; k++) {
        AD_TAKE(f, own[k], own * own);
    }
    for (int i = 0; i < threads; i++) {
        AD_TAKE(f, room[i], own * f->height + AD_DENSE_TRIANGLE_WORK(columns));
    }
}

static ad_status front_create(front *f, patch_window *w, ad_error *error)
{
    const size_t patches = (size_t)w->grid->patches;
    *f = (front){.w = w, .size = patch_grid_size(w->grid)};
    AD_TAKE(f, first, patches + 2);
    AD_TAKE(f, joints, w->joint_count);
    AD_TAKE(f, own, patches);
    AD_TAKE(f, own_rows, patches);
    AD_TAKE(f, room, ad_pool_threads(w->p->settings->pool));
    if (!f->memory.is_short) {
        pin_patches(f);
        order_joints(f);
        make_room(f);
    }
    return ad_memory_status(&f->memory, error, "out of memory for the least squares of %d patches",
                            w->grid->patches);
}

/* ---- elimination ----------------------------------------------------------------------------- */

/* The own rows of a patch become a triangle. */
static void reduce_own(void *context, int patch, int thread)
{
    front *f = context;
    const size_t rows = patch_own_count(f->w, patch), own = own_columns(f);
    double *a = f->room[thread], *work = a + own * f->height;
    if (patch_is_late(f->w->p)) {
        return;
    }
    memset(a, 0, own * f->height * sizeof *a);
    patch_own_rows(
        f->w, patch,
        &(patch_block){.a = a, .stride = f->height, .unknowns = f->size, .residual = own - 1});
    ad_dense_triangle(rows, own, a, f->height, work);
    const size_t kept = rows < own ? rows : own;
    for (size_t j = 0; j < own; j++) {
        memcpy(f->own[patch] + j * own, a + j * f->height, kept * sizeof *a);
    }
    f->own_rows[patch] = kept;
}

/* Rows from..to of the triangle of a patch are written from row 0 on to a[..][stride]: its columns
 * from `column` on, its unknowns and residual to theirs. */
static void put_own(const front *f, int patch, size_t from, size_t to, double *a, size_t stride,
                    size_t column)
{
    const size_t own = own_columns(f), unknowns = f->size + f->globals - (own - f->size);
    for (size_t j = 0; j < own; j++) {
        const size_t there = j < f->size ? column + j : unknowns + (j - f->size);
        memcpy(a + there * stride, f->own[patch] + j * own + from, (to - from) * sizeof *a);
    }
}

static void clear_rows(const front *f, size_t from, size_t to)
{
    for (size_t j = 0; j < columns_of(f) && to > from; j++) {
        memset(f->a + j * f->tall + from, 0, (to - from) * sizeof *f->a);
    }
}

/* Joints of a step as rows of the front from `row` on; returns where they end. */
static size_t put_joints(front *f, int step, size_t row)
{
    for (int i = f->first[step]; i < f->first[step + 1]; i++) {
        const patch_joint *joint = &f->joints[i];
        const patch_block block = {
            .a = f->a, .stride = f->tall, .row = row, .residual = f->size + f->globals - 1};
        const size_t end = row + patch_joint_count(f->w, joint);
        clear_rows(f, row, end);
        patch_joint_rows(f->w, joint, &block, column_of(f, joint->a, step),
                         column_of(f, joint->b, step));
        row = end;
    }
    return row;
}

/* Rows of the front that have global columns alone. */
static void add_last(front *f, size_t rows)
{
    ad_dense_triangle_add(f->globals, rows, f->globals, f->last, f->globals,
                          f->a + f->size * f->tall, f->tall,
                          f->room[0] + own_columns(f) * f->height);
}

/* What is left of the rows moves one patch on; more of them than columns become a triangle. */
static void move_on(front *f, size_t rows)
{
    const size_t columns = columns_of(f), size = f->size, blocks = (size_t)f->width * size;
    if (rows > columns - size) {
        ad_dense_triangle(rows, columns - size, f->a + size * f->tall, f->tall,
                          f->room[0] + own_columns(f) * f->height);
        rows = columns - size;
    }
    for (size_t j = 0; j < blocks; j++) { /* globals stay where they are */
        const size_t column = j < size ? j : j + f->globals, from = j + size + f->globals;
        double *to = f->a + column * f->tall;
        if (j + size < blocks) {
            memcpy(to, f->a + from * f->tall, rows * sizeof *to);
        } else {
            memset(to, 0, rows * sizeof *to);
        }
    }
    f->carried = rows;
}

static bool is_sound(const double *r, size_t stride, size_t n)
{
    double least = INFINITY, most = 0;
    for (size_t j = 0; j < n; j++) {
        least = fmin(least, fabs(r[j * stride + j]));
        most = fmax(most, fabs(r[j * stride + j]));
    }
    return n == 0 || least > 1e-14 * most;
}

/* False: some coefficients are not determined, or it is late. */
static bool eliminate(front *f)
{
    const size_t columns = columns_of(f), size = f->size, own = own_columns(f);
    double *work = f->room[0] + own * f->height;
    memset(f->last, 0, f->globals * f->globals * sizeof *f->last);
    f->carried = 0;
    for (int k = 0; k < f->steps; k++) {
        const int patch = k + f->pinned;
        const size_t kept = f->own_rows[patch] < size ? f->own_rows[patch] : size;
        double *r = f->r + (size_t)k * columns * size;
        if (patch_is_late(f->w->p)) {
            return false;
        }
        memset(r, 0, columns * size * sizeof *r);
        put_own(f, patch, 0, kept, r, size, 0);
        if (f->width <= 2) { /* rows from before end in this patch: what is left is global */
            ad_dense_triangle_add(size, f->carried, size + f->globals, r, size, f->a, f->tall,
                                  work);
            add_last(f, f->carried);
            f->carried = 0;
        }
        size_t rows = put_joints(f, k, f->carried);
        ad_dense_triangle_add(size, rows, columns, r, size, f->a, f->tall, work);
        if (!is_sound(r, size, size)) {
            return false;
        }
        if (f->own_rows[patch] > kept) {
            clear_rows(f, rows, rows + f->own_rows[patch] - kept);
            put_own(f, patch, kept, f->own_rows[patch], f->a + rows, f->tall, 0);
            rows += f->own_rows[patch] - kept;
        }
        move_on(f, rows);
    }
    add_last(f, f->carried);
    for (int patch = 0; patch < f->pinned; patch++) {
        clear_rows(f, 0, f->own_rows[patch]);
        put_own(f, patch, 0, f->own_rows[patch], f->a, f->tall, column_of(f, patch, 0));
        add_last(f, f->own_rows[patch]);
    }
    add_last(f, put_joints(f, f->steps, 0));
    return is_sound(f->last, f->globals, (size_t)f->pinned * size);
}

/* x [n] becomes R^-1 x. */
static void solve_triangle(const double *r, size_t stride, size_t n, double *x)
{
    for (size_t j = n; j-- > 0;) {
        x[j] /= r[j * stride + j];
        for (size_t i = 0; i < j; i++) {
            x[i] -= r[j * stride + i] * x[j];
        }
    }
}

/* y [size] -= columns [count][size] times x. */
static void take_from(double *y, const double *columns, size_t size, size_t count, const double *x)
{
    for (size_t j = 0; j < count; j++) {
        for (size_t i = 0; i < size; i++) {
            y[i] -= columns[j * size + i] * x[j];
        }
    }
}

/* x [patches][size] becomes R^-1 x. */
static void solve_back(const front *f, double *x)
{
    const size_t size = f->size, pinned = (size_t)f->pinned * size;
    solve_triangle(f->last, f->globals, pinned, x);
    for (int k = f->steps - 1; k >= 0; k--) {
        const double *r = f->r + (size_t)k * columns_of(f) * size;
        double *y = x + (size_t)(k + f->pinned) * size;
        take_from(y, r + size * size, size, pinned, x);
        for (int block = 1; block < f->width && k + block < f->steps; block++) {
            take_from(y, r + ((size_t)block * size + f->globals) * size, size, size,
                      y + (size_t)block * size);
        }
        solve_triangle(r, size, size, y);
    }
}

/* x [patches][size] = -(least squares solution) of right side `right`: of an unknown, or the last
 * one. */
static void solve_side(const front *f, size_t right, double *x)
{
    const size_t size = f->size, pinned = (size_t)f->pinned * size, column = pinned + right;
    for (size_t i = 0; i < pinned; i++) {
        x[i] = -f->last[column * f->globals + i];
    }
    for (int k = 0; k < f->steps; k++) {
        const double *r = f->r + ((size_t)k * columns_of(f) + size + column) * size;
        for (size_t i = 0; i < size; i++) {
            x[(size_t)(k + f->pinned) * size + i] = -r[i];
        }
    }
    solve_back(f, x);
}

/* The root mean square of fields of these coefficients, over their scale. */
static double size_of(const front *f, const double *x)
{
    const patch_grid *grid = f->w->grid;
    double total = 0, volume = 0;
    for (int k = 0; k < grid->patches; k++) {
        const double part = patch_volume(grid, k);
        volume += part;
        for (size_t i = 0; i < f->size; i++) {
            const double by =
                x[(size_t)k * f->size + i] / f->w->p->scale[i / (size_t)grid->functions];
            total += part * by * by;
        }
    }
    return sqrt(total / volume);
}

/* The Gauss-Newton step, and how fields change with the unknowns; *moved is its size. */
static ad_status take_step(front *f, double *moved, ad_error *error)
{
    const patch_problem *p = f->w->p;
    const size_t all = (size_t)f->w->grid->patches * f->size, unknowns = (size_t)p->unknowns;
    ad_pool_run(p->settings->pool, f->w->grid->patches, reduce_own, f);
    if (patch_is_late(f->w->p) || !eliminate(f)) {
        return patch_is_late(f->w->p)
                   ? ad_fail(error, AD_NOT_FINITE, "the time is over")
                   : ad_fail(
                         error, AD_BAD_INPUT,
                         "the equations with their conditions do not determine the fields: is a "
                         "condition missing, or an equation twice?");
    }
    solve_side(f, unknowns, f->step);
    for (size_t i = 0; i < unknowns; i++) {
        solve_side(f, i, f->step + (1 + i) * all);
    }
    *moved = size_of(f, f->step);
    return isfinite(*moved) ? AD_OK : ad_fail(error, AD_NOT_FINITE, "a step is not finite");
}

/* By how much fields change, as size_of, when what the rows say is off by rounding: a right side of
 * random signs, which meets every direction, the least determined one too. */
static double rounding_of(const front *f, double *x)
{
    const size_t size = f->size, all = (size_t)f->w->grid->patches * size;
    const double unit = 1.1e-16 / sqrt((double)all);
    unsigned state = 1;
    for (size_t i = 0; i < all; i++) {
        state = state * 1664525u + 1013904223u;
        x[i] = state >> 31 ? unit : -unit;
    }
    solve_back(f, x);
    return size_of(f, x);
}

/* ---- Gauss-Newton ---------------------------------------------------------------------------- */

static void go(front *f, double part)
{
    const size_t all = (size_t)f->w->grid->patches * f->size;
    for (size_t i = 0; i < all; i++) {
        f->w->grid->c[i] += part * f->step[i];
    }
}

/* Along the step as far as the sum of squares falls; the part that was gone, 0: nowhere. */
static double search(front *f, double before, bool is_small, double *after, ad_error *error)
{
    enum { HALVINGS = 8 };
    double part = 1, gone = 0;
    for (int i = 0; i <= HALVINGS; i++, part /= 2) {
        go(f, part - gone);
        gone = part;
        if (patch_window_evaluate(f->w, error) == AD_OK) {
            *after = patch_window_sum(f->w);
            if (isfinite(*after) && (*after <= before || is_small)) {
                return gone;
            }
        }
    }
    go(f, -gone);
    return 0;
}

/* Steps until what is left is below `enough`. */
static ad_status settle(front *f, int steps, double enough, patch_outcome *outcome, ad_error *error)
{
    const patch_problem *p = f->w->p;
    double before = INFINITY;
    ad_status status = patch_window_evaluate(f->w, error);
    double sum = status == AD_OK ? patch_window_sum(f->w) : NAN;
    if (status == AD_OK && !isfinite(sum)) {
        status = ad_fail(error, AD_NOT_FINITE, "residuals are not finite");
    }
    outcome->left = INFINITY;
    for (int i = 0; i < steps && status == AD_OK && outcome->left > enough; i++) {
        double after = sum, moved = INFINITY;
        status = take_step(f, &moved, error);
        if (status != AD_OK) {
            break;
        }
        outcome->steps++;
        const double part = search(f, sum, moved < 1e-6 || steps == 1, &after, error);
        if (part == 0) {
            status = ad_fail(error, AD_NOT_FINITE, "steps no longer lower the residuals");
        }
        outcome->left = p->linear       ? 0
                        : part < 1      ? INFINITY
                        : isinf(before) ? moved
                                        : moved * fmin(1, moved / before);
        before = part < 1 ? INFINITY : moved;
        sum = after;
    }
    return status;
}

/* How the fields change with the unknowns, and what the data say of these: by the last step. */
static ad_status keep_slopes(front *f, patch_outcome *outcome, ad_error *error)
{
    patch_grid *grid = f->w->grid;
    const size_t all = (size_t)grid->patches * f->size;
    const size_t numbers = (size_t)f->w->p->unknowns * all;
    double *slopes = realloc(grid->slopes, numbers * sizeof *slopes);
    if (!slopes) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for unknowns");
    }
    memcpy(slopes, f->step + all, numbers * sizeof *slopes);
    grid->slopes = slopes;
    outcome->misfit = patch_window_misfit(f->w, slopes, all);
    return AD_OK;
}

ad_status patch_solve(patch_problem *p, patch_grid *grid, patch_phase phase,
                      const patch_grid *before, int steps, double enough, patch_outcome *outcome,
                      ad_error *error)
{
    patch_window w;
    front f;
    *outcome = (patch_outcome){.left = INFINITY};
    ad_status status = patch_window_create(&w, p, grid, phase, before, error);
    if (status != AD_OK) {
        return status;
    }
    status = front_create(&f, &w, error);
    status = status == AD_OK ? settle(&f, steps, enough, outcome, error) : status;
    if (status == AD_OK && p->unknowns > 0) {
        status = keep_slopes(&f, outcome, error);
    }
    if (status == AD_OK) {
        outcome->rounding = rounding_of(&f, f.step);
        patch_window_missed(&w);
    }
    ad_memory_free(&f.memory);
    patch_window_clear(&w);
    return status;
}
