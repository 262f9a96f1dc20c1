#include "autodiff/dense.h"
#include "physics/chain/modes_step_internal.h"
#include "physics/numerics/processor.h"
#include "physics/numerics/spline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- making -------------------------------------------------------------------------------- */

/* How many numbers a branch has, which begin at `at`; NULL: they are counted alone. */
static size_t take_branch(collocation *x, double *at)
{
    collocation_branch *to = &x->branch;
    const size_t n = (size_t)x->size, s = (size_t)x->by.rule.stages, inputs = (size_t)x->m->inputs;
    double **const parts[] = {&to->left,    &to->by,       &to->start,   &to->from,
                              &to->stretch, &to->change,   &to->rate,    &to->rest_rate,
                              &to->matrix,  &to->relaxing, &to->rate_by, &to->rest_by};
    const size_t rows[] = {s, s * s,      1,         1, s, s, s, s, (size_t)x->m->width,
                           1, s * inputs, s * inputs};
    size_t count = 0;
    for (size_t i = 0; i < sizeof rows / sizeof *rows && x->m->branch.count > 0; i++) {
        *parts[i] = at ? at + count : NULL;
        count += rows[i] * n;
    }
    return count;
}

ad_status collocation_create(modes *m, int stages, collocation **result, ad_error *error)
{
    ad_status status = ad_dense_load(error);
    collocation *x = status == AD_OK ? calloc(1, sizeof *x) : NULL;
    const size_t n = (size_t)m->size, each = (size_t)stages * n, square = n * (size_t)m->width;
    *result = NULL;
    if (!x) {
        return status != AD_OK ? status : ad_fail(error, AD_NO_MEMORY, "out of memory for steps");
    }
    x->m = m;
    x->size = m->size;
    collocation_make_method(stages, &x->by);
    const size_t pairs = (size_t)x->by.pairs;
    int *pivots = malloc(pairs * n * sizeof *pivots);
    const size_t rubs = (size_t)stages * (size_t)m->rod->frictions * (size_t)m->points;
    double *at = x->memory =
        calloc(4 * each + 6 * n + 3 * square + 2 * pairs * n * n + each * (each + 1) +
                   take_branch(x, NULL) + rubs * sizeof *x->dual / sizeof *at,
               sizeof *at);
    x->solve[0].pivot = pivots;
    if (!at || !pivots) {
        collocation_free(x);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for steps");
    }
    double **const parts[] = {&x->a,    &x->before,   &x->residual, &x->change, &x->q,
                              &x->v,    &x->right[0], &x->right[1], &x->from_q, &x->from_v,
                              &x->by_q, &x->by_v,     &x->mass};
    const size_t sizes[] = {each, each, each, each, n, n, n, n, n, n, square, square, square};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        *parts[i] = at;
        at += sizes[i];
    }
    for (size_t k = 0; k < pairs; k++) {
        x->solve[k] = (collocation_factors){at, at + n * n, pivots + k * n};
        at += 2 * n * n;
    }
    x->exact = at;
    at += each * (each + 1);
    x->dual = (modes_dual *)(at + take_branch(x, at));
    *result = x;
    return AD_OK;
}

void collocation_free(collocation *collocation)
{
    if (collocation) {
        free(collocation->solve[0].pivot);
        free(collocation->memory);
        free(collocation);
    }
}

collocation_counts collocation_counts_of(const collocation *collocation)
{
    return collocation->counts;
}

/* ---- linear systems ------------------------------------------------------------------------ */

/* M + h l D + (h l)^2 K */
static void set_system(const collocation *collocation, double h, double complex eigenvalue,
                       collocation_factors *f)
{
    const int n = collocation->size, width = collocation->m->width;
    const double complex first = h * eigenvalue, second = first * first;
    const double a = creal(first), b = cimag(first), c = creal(second), d = cimag(second);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            const double K = collocation->by_q[i * width + j], D = collocation->by_v[i * width + j];
            f->re[i * n + j] = collocation->mass[i * width + j] + a * D + c * K;
            f->im[i * n + j] = b * D + d * K;
        }
    }
    collocation_branch_system(collocation, first, second, f);
}

static void swap_rows(int n, int i, int j, double *rows)
{
    for (int c = 0; c < n && i != j; c++) {
        const double other = rows[i * n + c];
        rows[i * n + c] = rows[j * n + c];
        rows[j * n + c] = other;
    }
}

/* LU factors with row pivoting; false: singular. */
FOR_EACH_PROCESSOR static bool factor(int n, collocation_factors *f)
{
    for (int i = 0; i < n; i++) {
        int best = i;
        double most = -1;
        for (int r = i; r < n; r++) {
            const double re = f->re[r * n + i], im = f->im[r * n + i], size = re * re + im * im;
            best = size > most ? r : best;
            most = size > most ? size : most;
        }
        f->pivot[i] = best;
        swap_rows(n, i, best, f->re);
        swap_rows(n, i, best, f->im);
        if (!(most > 0)) {
            return false;
        }
        const double *top_re = f->re + i * n, *top_im = f->im + i * n;
        const double a = top_re[i] / most, b = -top_im[i] / most;
        for (int r = i + 1; r < n; r++) {
            double *re = f->re + r * n, *im = f->im + r * n;
            const double by_re = re[i] * a - im[i] * b, by_im = re[i] * b + im[i] * a;
            re[i] = by_re;
            im[i] = by_im;
            for (int c = i + 1; c < n; c++) {
                re[c] -= by_re * top_re[c] - by_im * top_im[c];
                im[c] -= by_re * top_im[c] + by_im * top_re[c];
            }
        }
    }
    return true;
}

/* sum of (re + i im) (x + i y) over `count`, four at a time. */
PROCESSOR_INLINE void dot(int count, const double *re, const double *im, const double *x,
                          const double *y, double *sum_re, double *sum_im)
{
    quad a, b, u, v, real = {0}, imaginary = {0};
    int c = 0;
    for (; c + QUAD <= count; c += QUAD) {
        memcpy(&a, re + c, sizeof a);
        memcpy(&b, im + c, sizeof b);
        memcpy(&u, x + c, sizeof u);
        memcpy(&v, y + c, sizeof v);
        real += a * u - b * v;
        imaginary += a * v + b * u;
    }
    *sum_re = (real[0] + real[1]) + (real[2] + real[3]);
    *sum_im = (imaginary[0] + imaginary[1]) + (imaginary[2] + imaginary[3]);
    for (; c < count; c++) {
        *sum_re += re[c] * x[c] - im[c] * y[c];
        *sum_im += re[c] * y[c] + im[c] * x[c];
    }
}

/* re + i im [n]: the right side, then the solution. */
FOR_EACH_PROCESSOR static void solve_factored(int n, const collocation_factors *f, double *re,
                                              double *im)
{
    double a, b;
    for (int i = 0; i < n; i++) {
        const int p = f->pivot[i];
        a = re[i];
        b = im[i];
        re[i] = re[p];
        im[i] = im[p];
        re[p] = a;
        im[p] = b;
    }
    for (int i = 0; i < n; i++) {
        dot(i, f->re + i * n, f->im + i * n, re, im, &a, &b);
        re[i] -= a;
        im[i] -= b;
    }
    for (int i = n - 1; i >= 0; i--) {
        const int after = i + 1;
        dot(n - after, f->re + i * n + after, f->im + i * n + after, re + after, im + after, &a,
            &b);
        const double x = re[i] - a, y = im[i] - b;
        a = f->re[i * n + i];
        b = f->im[i * n + i];
        re[i] = (x * a + y * b) / (a * a + b * b);
        im[i] = (y * a - x * b) / (a * a + b * b);
    }
}

/* Polynomials are continued for so many times the step they are of; beyond that by their last
 * value. */
static const double FARTHEST = 1.5;

/* What a rate counts for beside a mode, in units of time. */
static const double RATE_COUNTS = 0.1;

/* ---- a step -------------------------------------------------------------------------------- */

void collocation_stage(collocation *collocation, int i, double h, const double *q, const double *v)
{
    const collocation_method *by = &collocation->by;
    const int n = collocation->size;
    for (int k = 0; k < n; k++) {
        double once = 0, twice = 0;
        for (int j = 0; j < by->rule.stages; j++) {
            once += by->rule.matrix[i][j] * collocation->a[j * n + k];
            twice += by->square[i][j] * collocation->a[j * n + k];
        }
        collocation->v[k] = v[k] + h * once;
        collocation->q[k] = q[k] + by->rule.nodes[i] * h * v[k] + h * h * twice;
    }
    collocation_branch_stretch(collocation, i, h, v);
}

/* The polynomial of the last step's accelerations, at the stages of this one. */
static void predict(collocation *collocation, double h)
{
    const collocation_method *by = &collocation->by;
    const int n = collocation->size, s = by->rule.stages;
    double values[COLLOCATION_STAGES_MAX];
    if (!collocation->has_polynomial) {
        memset(collocation->a, 0, (size_t)(s * n) * sizeof *collocation->a);
        return;
    }
    for (int i = 0; i < s; i++) {
        const double at = h > FARTHEST * collocation->last_step
                              ? 1
                              : 1 + by->rule.nodes[i] * h / collocation->last_step;
        memset(collocation->a + i * n, 0, (size_t)n * sizeof *collocation->a);
        gauss_lagrange(&by->rule, at, values);
        for (int j = 0; j < s; j++) {
            for (int k = 0; k < n; k++) {
                collocation->a[i * n + k] += values[j] * collocation->before[j * n + k];
            }
        }
    }
}

void collocation_follow(collocation *collocation, const collocation_path *path)
{
    collocation->path = path;
}

/* Values at a part of the step of inputs on a path, and their two rates [2][inputs] by t. */
static void follow(const collocation *collocation, double part, double h, const double *inputs,
                   double *between, double *rates)
{
    const collocation_path *path = collocation->path;
    const int count = collocation->m->inputs;
    for (int k = 0; k < count; k++) {
        rates[k] = rates[count + k] = 0;
        if (path->which >> k & 1) {
            double now[3];
            spline_between((double[]){inputs[k], collocation->after[k]},
                           (double[]){path->before[k], path->after[k]}, h, part, now);
            between[k] = now[0];
            rates[k] = now[1];
            rates[count + k] = now[2];
        }
    }
}

ad_status collocation_at(collocation *collocation, int i, double t, double h, const double *inputs,
                         ad_error *error)
{
    const double part = collocation->by.rule.nodes[i];
    double between[SCENE_PARAMETERS_MAX], rates[2 * SCENE_PARAMETERS_MAX];
    for (int k = 0; collocation->after && k < collocation->m->inputs; k++) {
        between[k] = inputs[k] + part * (collocation->after[k] - inputs[k]);
    }
    if (collocation->after && collocation->path) {
        follow(collocation, part, h, inputs, between, rates);
        modes_move(collocation->m, rates);
    }
    return modes_at(collocation->m, t + part * h, collocation->after ? between : inputs, error);
}

/* Mass and derivatives in the middle of the step as it is predicted. */
ad_status collocation_form(collocation *collocation, double t, double h, const double *inputs,
                           const double *q, const double *v, ad_error *error)
{
    modes *m = collocation->m;
    const int middle = collocation->by.rule.stages / 2;
    ad_status status = collocation_at(collocation, middle, t, h, inputs, error);
    if (status == AD_OK) {
        collocation_stage(collocation, middle, h, q, v);
        modes_linearise(m, collocation->q, collocation->v,
                        collocation->a + middle * collocation->size, collocation->residual,
                        collocation->by_q, collocation->by_v);
        memcpy(collocation->mass, m->mass,
               (size_t)(m->size * m->width) * sizeof *collocation->mass);
        collocation_branch_form(collocation, middle);
        collocation->counts.matrices++;
        collocation->formed_step = 0;
    }
    return status;
}

bool collocation_factor(collocation *collocation, double h)
{
    bool done = true;
    for (int k = 0; k < collocation->by.pairs; k++) {
        set_system(collocation, h, collocation->by.eigenvalue[k], &collocation->solve[k]);
        done &= factor(collocation->size, &collocation->solve[k]);
    }
    collocation->formed_step = h;
    return done;
}

/* Rates count, as the errors of many short steps add up in them; reactions follow from both. */
double collocation_change(collocation *collocation, double h)
{
    const collocation_method *by = &collocation->by;
    const int n = collocation->size;
    double most = 0;
    for (int c = 0; c < collocation->m->end.first; c++) {
        for (int i = 0; i < by->rule.stages; i++) {
            double once = 0, twice = 0;
            for (int j = 0; j < by->rule.stages; j++) {
                once += by->rule.matrix[i][j] * collocation->change[j * n + c];
                twice += by->square[i][j] * collocation->change[j * n + c];
            }
            const double size = fmax(h * h * fabs(twice), RATE_COUNTS * h * fabs(once));
            most = size > most || isnan(size) ? size : most;
        }
    }
    for (int c = 0; c < by->rule.stages * n; c++) {
        collocation->a[c] += collocation->change[c];
    }
    return most;
}

/* Newton's change of the accelerations for the residuals as they are. */
static double improve(collocation *collocation, double h)
{
    const collocation_method *by = &collocation->by;
    const int n = collocation->size;
    double *re = collocation->right[0], *im = collocation->right[1];
    memset(collocation->change, 0, (size_t)(by->rule.stages * n) * sizeof *collocation->change);
    for (int k = 0; k < by->pairs; k++) {
        for (int c = 0; c < n; c++) {
            re[c] = im[c] = 0;
            for (int j = 0; j < by->rule.stages; j++) {
                re[c] -= creal(by->to[k][j]) * collocation->residual[j * n + c];
                im[c] -= cimag(by->to[k][j]) * collocation->residual[j * n + c];
            }
        }
        solve_factored(n, &collocation->solve[k], re, im);
        for (int j = 0; j < by->rule.stages; j++) {
            const double a = creal(by->from[j][k]), b = cimag(by->from[j][k]);
            for (int c = 0; c < n; c++) {
                collocation->change[j * n + c] += a * re[c] - b * im[c];
            }
        }
    }
    return collocation_change(collocation, h);
}

static ad_status residuals(collocation *collocation, double t, double h, const double *inputs,
                           const double *q, const double *v, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < collocation->by.rule.stages && status == AD_OK; i++) {
        status = collocation_at(collocation, i, t, h, inputs, error);
        if (status == AD_OK) {
            collocation_stage(collocation, i, h, q, v);
            modes_shape(collocation->m, collocation->q, collocation->v,
                        collocation->a + i * collocation->size);
            modes_forces(collocation->m, false, collocation->residual + i * collocation->size);
            if (collocation->asks_power) {
                modes_power_now(collocation->m, &collocation->load[i], &collocation->loss[i]);
            }
        }
    }
    return status;
}

/* Newton's method; *slow: it took many steps, *failed: too many. */
ad_status collocation_iterate(collocation *collocation, double t, double h, const double *inputs,
                              double tolerance, const double *q, const double *v, bool *slow,
                              bool *failed, ad_error *error)
{
    const int most = 10;
    double before = INFINITY;
    *failed = true;
    *slow = true;
    for (int i = 0; i < most; i++) {
        ad_status status = residuals(collocation, t, h, inputs, q, v, error);
        if (status != AD_OK) {
            return status;
        }
        const double change = improve(collocation, h), ratio = change / before;
        collocation->counts.iterations++;
        if (!(change < 1e6) || (i > 1 && ratio > 0.9)) {
            return AD_OK;
        }
        if (change <= tolerance ||
            (i > 0 && ratio < 1 && change * ratio / (1 - ratio) < tolerance)) {
            *failed = false;
            *slow = i > 3;
            return AD_OK;
        }
        before = change;
    }
    return AD_OK;
}

/* What the highest part of the accelerations' polynomial moves modes by, without what is too fast
 * for the step: of order stages + 1. */
static double estimate(collocation *collocation, double h)
{
    const collocation_method *by = &collocation->by;
    const int n = collocation->size, width = collocation->m->width;
    double most = 0, *re = collocation->right[0], *im = collocation->right[1];
    for (int c = 0; c < n; c++) {
        collocation->q[c] = 0;
        im[c] = 0;
        for (int j = 0; j < by->rule.stages; j++) {
            collocation->q[c] += h * h * by->highest[j] * collocation->a[j * n + c];
        }
    }
    for (int c = 0; c < n; c++) {
        re[c] = 0;
        for (int k = 0; k < n; k++) {
            re[c] += collocation->mass[c * width + k] * collocation->q[k];
        }
    }
    solve_factored(n, &collocation->solve[0], re, im);
    for (int c = 0; c < collocation->m->end.first; c++) {
        most = fabs(re[c]) > most || isnan(re[c]) ? fabs(re[c]) : most;
    }
    return most * 0.25 / by->rule.stages / by->rule.stages; /* twice integrated */
}

void collocation_finish(collocation *collocation, double h, double *q, double *v, double *d)
{
    const collocation_method *by = &collocation->by;
    const int n = collocation->size;
    collocation_branch_stretch(collocation, by->rule.stages - 1, h, v);
    collocation_branch_finish(collocation, d);
    for (int k = 0; k < n; k++) {
        double once = 0, twice = 0;
        for (int j = 0; j < by->rule.stages; j++) {
            once += by->rule.weights[j] * collocation->a[j * n + k];
            twice += by->square[by->rule.stages - 1][j] * collocation->a[j * n + k];
        }
        q[k] += h * v[k] + h * h * twice;
        v[k] += h * once;
    }
}

/* Of powers at the stages, up to a share of the step. */
static void add_energy(const collocation *collocation, double h, const double *integral,
                       solve_energy *energy)
{
    for (int i = 0; i < collocation->by.rule.stages; i++) {
        energy->work += h * integral[i] * collocation->load[i];
        energy->dissipated += h * integral[i] * collocation->loss[i];
    }
}

static void keep(collocation *collocation, double h, const double *q, const double *v,
                 const double *d, solve_energy *energy)
{
    const size_t n = (size_t)collocation->size;
    memcpy(collocation->from_q, q, n * sizeof *q);
    memcpy(collocation->from_v, v, n * sizeof *v);
    collocation->from_energy = *energy;
    add_energy(collocation, h, collocation->by.rule.weights, energy);
    memcpy(collocation->before, collocation->a,
           (size_t)collocation->by.rule.stages * n * sizeof *collocation->a);
    collocation_branch_keep(collocation, h, d, v);
    collocation->has_polynomial = true;
    collocation->last_step = h;
    collocation->counts.steps++;
}

void collocation_within(const collocation *collocation, double share, double *q, double *v,
                        double *d, solve_energy *energy)
{
    const collocation_method *by = &collocation->by;
    const double h = collocation->last_step;
    double integral[COLLOCATION_STAGES_MAX];
    gauss_integral(&by->rule, share, integral);
    for (int k = 0; k < collocation->size; k++) {
        q[k] = collocation->from_q[k] + share * h * collocation->from_v[k];
        v[k] = collocation->from_v[k];
        for (int j = 0; j < by->rule.stages; j++) {
            double twice = 0;
            for (int i = 0; i < by->rule.stages; i++) {
                twice += integral[i] * by->rule.matrix[i][j];
            }
            q[k] += h * h * twice * collocation->before[j * collocation->size + k];
            v[k] += h * integral[j] * collocation->before[j * collocation->size + k];
        }
    }
    collocation_branch_within(collocation, integral, d);
    *energy = collocation->from_energy;
    add_energy(collocation, h, integral, energy);
}

/* Newton's method for a step of length h as predicted; *failed: it came to nothing. */
static ad_status attempt(collocation *collocation, double t, double h, double tolerance,
                         const double *q, const double *v, const double *d, bool *slow,
                         bool *failed, ad_error *error)
{
    const double of_newton = 1e-2;
    ad_status status = collocation_branch_begin(collocation, t, h, NULL, d, error);
    predict(collocation, h);
    if (status == AD_OK && collocation->must_form) {
        status = collocation_form(collocation, t, h, NULL, q, v, error);
    }
    if (status == AD_OK && collocation->formed_step != h) {
        *failed = !collocation_factor(collocation, h);
    }
    return status == AD_OK && !*failed
               ? collocation_iterate(collocation, t, h, NULL, of_newton * tolerance, q, v, slow,
                                     failed, error)
               : status;
}

ad_status collocation_next(collocation *collocation, double *t, double end, double tolerance,
                           double *q, double *v, double *d, solve_energy *energy, ad_error *error)
{
    const double smallest = 1e-13 * fmax(1, fabs(end)), left = end - *t;
    collocation->asks_power = true;
    collocation->must_form |= !collocation->has_polynomial;
    collocation->step = collocation->step > 0 ? collocation->step : fmin(left, 1e-3);
    while (true) {
        const bool clipped = collocation->step >= left;
        const double h =
            clipped ? left : fmin(collocation->step, 0.5 * left + 0.25 * collocation->step);
        bool slow = false, failed = false;
        ad_status status = attempt(collocation, *t, h, tolerance, q, v, d, &slow, &failed, error);
        if (status != AD_OK) {
            return status;
        }
        if (failed && !collocation->must_form) { /* the matrix may be that of another time */
            collocation->must_form = true;
            continue;
        }
        collocation->must_form = slow || failed;
        const double error_now = failed ? INFINITY : estimate(collocation, h);
        double factor = fmin(4, fmax(0.2, 0.9 * pow(tolerance / fmax(error_now, 1e-300),
                                                    1.0 / (collocation->by.rule.stages + 1))));
        if (!failed && error_now <= tolerance) {
            keep(collocation, h, q, v, d, energy);
            collocation_finish(collocation, h, q, v, d);
            *t = clipped ? end : *t + h;
            factor = factor > 0.9 && factor < 1.3 ? 1 : factor; /* keeps the factors */
            collocation->step = clipped ? fmax(collocation->step, h * factor) : h * factor;
            return AD_OK;
        }
        collocation->counts.rejected++;
        collocation->step = h * (failed ? 0.3 : fmin(factor, 0.9));
        if (!(collocation->step > smallest)) {
            return ad_fail(error, AD_NOT_FINITE, "steps of time became too small at %g of %g", *t,
                           end);
        }
    }
}
