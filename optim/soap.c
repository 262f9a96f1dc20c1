/* Vyas, Morwani, Zhao, Kwun, Shapira, Brandfonbrener, Janson & Kakade, "SOAP: improving and
 * stabilizing Shampoo using Adam", ICLR 2025, algorithm 3. */
#include "internal.h"

#include <math.h>
#include <string.h>

/* Rows of a basis that are made orthogonal at a time. */
enum { PANEL = 16 };

/* Of the mean eigenvalue, added to products of gradients while they are of low rank: directions
 * that no gradient had yet keep their place in the basis. */
static const double RIDGE = 1e-9;

/* A side of a matrix: mean products of gradients and their eigenvectors, [n][n], one in each row.
 */
typedef struct side {
    size_t n; /* 0: too long, its basis stays as it is */
    double *products, *basis;
} side;

typedef struct optim_soap {
    optim_adam adam; /* first, so that a pointer to one points to the other */
    optim_matrix *matrices;
    double *factor;  /* [factors], all sides: products, then basis */
    double *work[3]; /* [largest matrix or square of a side] */
    size_t *order;   /* [longest side], work */
    double *sizes;   /* [longest side], work */
} optim_soap;

/* ---- sides --------------------------------------------------------------------------------- */

static size_t side_length(size_t n)
{
    return n > 1 && n <= OPTIM_SOAP_SIDE_MAX ? n : 0;
}

/* Both sides of matrix `index`, rows first. */
static void sides_of(const optim_soap *soap, int index, side sides[2])
{
    double *at = soap->factor;
    for (int i = 0; i <= index; i++) {
        const size_t lengths[2] = {side_length(soap->matrices[i].rows),
                                   side_length(soap->matrices[i].columns)};
        for (int k = 0; k < 2; k++) {
            const size_t n = lengths[k];
            sides[k] = (side){n, at, at + n * n};
            at += 2 * n * n;
        }
    }
}

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

static int parts(size_t count, const optim_settings *settings, optim_part *part)
{
    _Static_assert(sizeof(optim_matrix) % sizeof(double) == 0 && sizeof(size_t) <= sizeof(double),
                   "they have room where numbers have");
    const size_t matrices = (size_t)settings->matrix_count;
    size_t largest = 1, longest = 1, factors = 0;
    for (size_t i = 0; i < matrices; i++) {
        const optim_matrix *m = &settings->matrices[i];
        const size_t a = side_length(m->rows), b = side_length(m->columns);
        largest = larger(largest, larger(m->rows * m->columns, larger(a * a, b * b)));
        longest = larger(longest, larger(a, b));
        factors += 2 * (a * a + b * b);
    }
    const optim_part own[] = {
        OPTIM_WORK(optim_soap, matrices, sizeof(optim_matrix) / sizeof(double), matrices + 1),
        {offsetof(optim_soap, factor), 1, factors + 1, "factors",
         "factors hold a number that is not finite"},
        OPTIM_WORK(optim_soap, work[0], 1, largest),
        OPTIM_WORK(optim_soap, work[1], 1, largest),
        OPTIM_WORK(optim_soap, work[2], 1, largest),
        OPTIM_WORK(optim_soap, order, 1, longest),
        OPTIM_WORK(optim_soap, sizes, 1, longest)};
    return optim_parts_add(optim_adam_parts(count, settings, part), part, sizeof own / sizeof *own,
                           own);
}

static void start_bases(optim_soap *soap)
{
    for (int i = 0; i < soap->adam.settings.matrix_count; i++) {
        side sides[2];
        sides_of(soap, i, sides);
        for (int k = 0; k < 2; k++) {
            for (size_t j = 0; j < sides[k].n; j++) {
                sides[k].basis[j * sides[k].n + j] = 1;
            }
        }
    }
}

static void begin(void *own, size_t count, const double *x, const optim_settings *settings)
{
    optim_soap *soap = own;
    optim_adam_begin(own, count, x, settings);
    if (settings->matrix_count > 0) {
        memcpy(soap->matrices, settings->matrices,
               (size_t)settings->matrix_count * sizeof *soap->matrices);
    }
    start_bases(soap);
}

/* ---- products ------------------------------------------------------------------------------ */

/* c[m][n] = a b + beta c; without a function of the settings, for small ones. */
static void multiply(const optim_soap *soap, bool transpose_a, bool transpose_b, size_t m, size_t n,
                     size_t k, const double *a, const double *b, double beta, double *c)
{
    if (soap->adam.settings.multiply) {
        soap->adam.settings.multiply(soap->adam.settings.context, transpose_a, transpose_b, m, n, k,
                                     a, b, beta, c);
        return;
    }
    for (size_t i = 0; i < m; i++) {
        for (size_t j = 0; j < n; j++) {
            double sum = 0;
            for (size_t l = 0; l < k; l++) {
                sum +=
                    a[transpose_a ? l * m + i : i * k + l] * b[transpose_b ? j * k + l : l * n + j];
            }
            c[i * n + j] = sum + (beta != 0 ? beta * c[i * n + j] : 0);
        }
    }
}

/* to = P_left from P_right^T, P the bases; back: P_left^T from P_right. `to` may be `from`. */
static void turn(const optim_soap *soap, const optim_matrix *matrix, const side sides[2], bool back,
                 const double *from, double *to)
{
    const size_t rows = matrix->rows, columns = matrix->columns;
    const double *half = from;
    if (sides[0].n) {
        multiply(soap, back, false, rows, columns, rows, sides[0].basis, from, 0, soap->work[2]);
        half = soap->work[2];
    }
    if (sides[1].n) {
        multiply(soap, false, !back, rows, columns, columns, half, sides[1].basis, 0,
                 soap->work[1]);
        half = soap->work[1];
    }
    if (half != to) {
        memcpy(to, half, rows * columns * sizeof *to);
    }
}

/* ---- bases --------------------------------------------------------------------------------- */

/* Rows first to last of p[n][n] become orthonormal among themselves, by Gram and Schmidt. */
static void orthonormalise(size_t n, size_t first, size_t last, double *p)
{
    for (size_t i = first; i < last; i++) {
        double *row = p + i * n;
        for (int again = 0; again < 2; again++) {
            for (size_t k = first; k < i; k++) {
                const double *other = p + k * n;
                const double part = optim_dot(n, other, row);
                for (size_t j = 0; j < n; j++) {
                    row[j] -= part * other[j];
                }
            }
            const double size = sqrt(optim_dot(n, row, row));
            for (size_t j = 0; j < n; j++) {
                row[j] /= size;
            }
        }
    }
}

/* The eigenvectors with the largest eigenvalues, as they seem, come first; square follows. */
static void sort_basis(optim_soap *soap, const side *s, const optim_matrix *matrix, bool left,
                       const double *image)
{
    const size_t n = s->n, rows = matrix->rows, columns = matrix->columns;
    double *square = soap->adam.square + matrix->offset;
    for (size_t i = 0; i < n; i++) {
        size_t k = i;
        soap->sizes[i] = optim_dot(n, s->basis + i * n, image + i * n);
        for (; k > 0 && soap->sizes[soap->order[k - 1]] < soap->sizes[i]; k--) {
            soap->order[k] = soap->order[k - 1];
        }
        soap->order[k] = i;
    }
    for (size_t i = 0; i < n; i++) { /* work[0] becomes the image in its new order */
        memcpy(soap->work[0] + i * n, image + soap->order[i] * n, n * sizeof *image);
    }
    memcpy(soap->work[1], square, rows * columns * sizeof *square);
    for (size_t i = 0; i < rows; i++) {
        for (size_t j = 0; j < columns; j++) {
            const size_t from = left ? soap->order[i] * columns + j : i * columns + soap->order[j];
            square[i * columns + j] = soap->work[1][from];
        }
    }
}

/* One step of orthogonal iteration from the basis before. */
static void turn_basis(optim_soap *soap, const side *s, const optim_matrix *matrix, bool left)
{
    const size_t n = s->n;
    double trace = 0, *p = soap->work[0];
    for (size_t i = 0; i < n; i++) {
        trace += s->products[i * n + i];
    }
    if (!(trace > 0)) {
        return;
    }
    memcpy(soap->work[2], s->basis, n * n * sizeof *p);
    multiply(soap, false, false, n, n, n, s->basis, s->products, RIDGE * trace / (double)n,
             soap->work[2]);
    sort_basis(soap, s, matrix, left, soap->work[2]);
    for (size_t first = 0; first < n; first += PANEL) {
        const size_t last = first + PANEL < n ? first + PANEL : n, count = last - first;
        double *panel = p + first * n, *parts = soap->work[1];
        orthonormalise(n, first, last, p);
        for (int again = 0; again < 2 && first > 0; again++) {
            multiply(soap, false, true, count, first, n, panel, p, 0, parts);
            for (size_t i = 0; i < count * first; i++) {
                parts[i] = -parts[i];
            }
            multiply(soap, false, false, count, n, first, parts, p, 1, panel);
            orthonormalise(n, first, last, p);
        }
    }
    if (optim_all_finite(n * n, p)) {
        memcpy(s->basis, p, n * n * sizeof *p);
    }
}

/* The products of this gradient, and every so many steps the bases. */
static void follow(optim_soap *soap, int index, const double *gradient)
{
    const optim_matrix *matrix = &soap->matrices[index];
    const size_t rows = matrix->rows, columns = matrix->columns;
    const bool first = soap->adam.scalar[OPTIM_ADAM_STEPS] == 0;
    const double beta = soap->adam.settings.beta2, weight = first ? 1 : sqrt(1 - beta);
    double *scaled = soap->work[0];
    side sides[2];
    sides_of(soap, index, sides);
    for (size_t i = 0; i < rows * columns; i++) {
        scaled[i] = weight * gradient[i];
    }
    for (int k = 0; k < 2; k++) {
        if (sides[k].n) {
            multiply(soap, k == 1, k == 0, sides[k].n, sides[k].n, k == 0 ? columns : rows, scaled,
                     scaled, first ? 0 : beta, sides[k].products);
        }
    }
    if (first || fmod(soap->adam.scalar[OPTIM_ADAM_STEPS], soap->adam.settings.basis_every) == 0) {
        for (int k = 0; k < 2; k++) {
            if (sides[k].n) {
                turn_basis(soap, &sides[k], matrix, k == 0);
            }
        }
    }
}

/* ---- steps --------------------------------------------------------------------------------- */

typedef struct rates {
    double beta2, correction1, correction2, epsilon, rate;
} rates;

/* mean and square of `gradient` and the change of x, all [count], the last two of as many numbers
 * in the basis at hand. */
static void adam_direction(const rates *r, size_t count, const double *gradient, const double *mean,
                           double *square, double *direction)
{
    for (size_t i = 0; i < count; i++) {
        square[i] = r->beta2 * square[i] + (1 - r->beta2) * gradient[i] * gradient[i];
        direction[i] =
            r->rate * (mean[i] / r->correction1) / (sqrt(square[i] / r->correction2) + r->epsilon);
    }
}

static void step_matrix(optim_soap *soap, const rates *r, int index)
{
    const optim_matrix *matrix = &soap->matrices[index];
    const size_t count = matrix->rows * matrix->columns, offset = matrix->offset;
    side sides[2];
    sides_of(soap, index, sides);
    double *direction = soap->adam.next_x + offset;
    double *turned = soap->work[0];
    turn(soap, matrix, sides, false, soap->adam.gradient + offset, turned);
    turn(soap, matrix, sides, false, soap->adam.mean + offset, direction);
    adam_direction(r, count, turned, direction, soap->adam.square + offset, direction);
    turn(soap, matrix, sides, true, direction, direction);
}

/* Numbers that are in no matrix, from `first` on. */
static void step_others(optim_soap *soap, const rates *r, size_t first, size_t end)
{
    if (end > first) {
        adam_direction(r, end - first, soap->adam.gradient + first, soap->adam.mean + first,
                       soap->adam.square + first, soap->adam.next_x + first);
    }
}

/* As in the paper the first gradient only makes the bases. */
static optim_status update(optim_soap *soap)
{
    optim_adam *adam = &soap->adam;
    const optim_settings *s = &adam->settings;
    const double steps = adam->scalar[OPTIM_ADAM_STEPS], clip = optim_adam_clip(adam);
    const rates r = {.beta2 = s->beta2,
                     .correction1 = 1 - pow(s->beta1, steps),
                     .correction2 = 1 - pow(s->beta2, steps),
                     .epsilon = s->epsilon,
                     .rate = optim_schedule_rate(s, (int64_t)steps)};
    for (size_t i = 0; i < adam->count && clip < 1; i++) {
        adam->gradient[i] *= clip;
    }
    if (steps > 0) {
        size_t done = 0;
        for (size_t i = 0; i < adam->count; i++) {
            adam->mean[i] = s->beta1 * adam->mean[i] + (1 - s->beta1) * adam->gradient[i];
        }
        for (int i = 0; i < soap->adam.settings.matrix_count; i++) {
            const optim_matrix *m = &soap->matrices[i];
            step_others(soap, &r, done, m->offset);
            step_matrix(soap, &r, i);
            done = m->offset + m->rows * m->columns;
        }
        step_others(soap, &r, done, adam->count);
        for (size_t i = 0; i < adam->count; i++) {
            adam->next_x[i] = adam->x[i] - adam->next_x[i];
        }
        if (!optim_all_finite(adam->count, adam->next_x)) {
            return OPTIM_NOT_FINITE;
        }
        memcpy(adam->x, adam->next_x, adam->count * sizeof *adam->x);
    }
    for (int i = 0; i < soap->adam.settings.matrix_count; i++) {
        follow(soap, i, adam->gradient + soap->matrices[i].offset);
    }
    adam->scalar[OPTIM_ADAM_STEPS] = steps + 1;
    adam->scalar[OPTIM_ADAM_LEARNING_RATE] = r.rate;
    return OPTIM_RUNNING;
}

/* ---- the method ---------------------------------------------------------------------------- */

static void defaults(optim_settings *settings)
{
    settings->beta1 = settings->beta2 = 0.95;
    settings->gradient_tolerance = 0;
}

static const char *check(const optim_settings *settings)
{
    return settings->basis_every < 1 ? "basis_every must be at least 1" : NULL;
}

static optim_status step(void *own, const optim_target *target)
{
    optim_soap *soap = own;
    const optim_status status = optim_adam_evaluate(&soap->adam, target);
    return status == OPTIM_RUNNING ? update(soap) : status;
}

const optim_kind optim_soap_kind = {
    .about = "Adam in the eigenvectors of Shampoo",
    .needs = OPTIM_NEEDS_GRADIENTS,
    .reads = OPTIM_READS_RATE | OPTIM_READS_MEANS | OPTIM_READS_EPSILON | OPTIM_READS_MATRICES,
    .defaults = defaults,
    .check = check,
    .size = sizeof(optim_soap),
    .parts = parts,
    .begin = begin,
    .step = step,
    .objective_changed = optim_adam_objective_changed,
    .x = optim_adam_x,
    .best_x = optim_adam_best_x,
    .inspect = optim_adam_inspect,
    .state_check = optim_adam_state_check,
    .advice = "a smaller learning_rate, or clip_norm or warmup_steps"};
