#include "tools/train/linear_model.h"

#include "autodiff/dense.h"
#include "autodiff/memory.h"
#include "nn/rng.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* And no more than the smallest machine has. */
static double bytes_max(const problem *p)
{
    static const double most = 2e9;
    const double pages = (double)sysconf(_SC_PHYS_PAGES), bytes = (double)sysconf(_SC_PAGESIZE);
    const double here = pages > 0 && bytes > 0 ? fmin(most, pages * bytes) : most;
    return -ad_ranks_largest(problem_ranks(p), -here);
}

enum { RANK = 80, ITERATIONS_MAX = 200 }; /* of the preconditioner; of conjugate gradients */

struct linear_model {
    problem *problem;
    ad_pool *pool;
    linear_model_info info;
    size_t count, rows;
    double *jtr;             /* [count] */
    double *matrix;          /* J^T J [count][count]; or J D^-1 J^T [rows][rows] */
    ad_dense_factor *factor; /* of the matrix and `shift` on its diagonal */
    double *shift;
    double *jt;    /* kernel: [count][rows], in time divided by sqrt(scale) */
    double *r, *z; /* [rows] */
    bool scaled;   /* kernel: jt is divided, matrix is made of it */
    double damped; /* damping of `factor`; NaN: of another matrix */
    optim_nystrom *preconditioner;
    optim_cg *cg;
    double *x;       /* matrix_free: where J is, [count] */
    size_t outputs;  /* separate */
    double *factors; /* separate: [outputs] */
    ad_status status;
    ad_error *error;
    ad_memory memory;
};

/* ---- choosing ------------------------------------------------------------------------------ */

/* Of one or two processors. */
static const double MINUTES = 1e12;

static size_t rank_of(size_t parameters)
{
    return parameters < RANK ? parameters : RANK;
}

static double bytes_of(const linear_model_info *plan, const problem_least_squares *sizes)
{
    enum { VECTORS = 7 }; /* the random numbers of the preconditioner are needed once */
    double n = (double)plan->parameters, rows = (double)plan->rows;
    switch (plan->form) {
    case TRAIN_SEPARATE:
        return 16 * (double)plan->order * (double)plan->order;
    case TRAIN_MATRIX_FREE:
        return 8 * n * (3 * (double)rank_of(plan->parameters) + VECTORS) + (double)sizes->bytes;
    case TRAIN_KERNEL:
        return 8 * (n * rows + 2 * rows * rows);
    default:
        return 16 * n * n + (double)sizes->slab_bytes;
    }
}

double linear_model_flops(const linear_model_info *plan)
{
    const double n = (double)plan->parameters, rows = (double)plan->rows;
    switch (plan->form) {
    case TRAIN_MATRIX_FREE:
        return 4 * n * rows * (double)(rank_of(plan->parameters) + ITERATIONS_MAX);
    case TRAIN_KERNEL:
        return rows * rows * (n + rows / 3);
    default:
        return n * n * ((double)plan->inner + n / 3);
    }
}

/* Sizes of one form; its programs are compiled. */
static ad_status size_up(problem *p, train_linear_algebra form, linear_model_info *plan,
                         ad_error *error)
{
    problem_least_squares sizes = {.rows = 0};
    if (form == TRAIN_SEPARATE) {
        *plan = (linear_model_info){.form = form, .parameters = problem_parameters(p)};
        problem_separates(p, &plan->order, NULL);
        plan->bytes = bytes_of(plan, &sizes);
        return AD_OK;
    }
    ad_status status = form == TRAIN_MATRIX_FREE ? problem_prepare_product(p, &sizes, error)
                                                 : problem_prepare_least_squares(p, &sizes, error);
    *plan = (linear_model_info){.form = form, .parameters = problem_parameters(p)};
    if (status == AD_OK) {
        plan->rows = sizes.rows;
        plan->inner = sizes.inner;
        if (form == TRAIN_LINEAR_AUTOMATIC) {
            plan->form = plan->rows < plan->parameters ? TRAIN_KERNEL : TRAIN_NORMAL_EQUATIONS;
        }
        plan->bytes = bytes_of(plan, &sizes);
    }
    return status;
}

/* Some seconds of a processor: more than conjugate gradients take, at most as many products. */
static bool is_slow(const linear_model_info *plan)
{
    static const double many = 1e11;
    linear_model_info other = *plan;
    other.form = TRAIN_MATRIX_FREE;
    const double flops = linear_model_flops(plan);
    return plan->form == TRAIN_KERNEL && flops > many && flops > linear_model_flops(&other);
}

ad_status linear_model_plan(problem *p, const train_stage *stage, int number,
                            linear_model_info *plan, ad_error *error)
{
    const bool identity = stage->optim.scaling == OPTIM_SCALING_IDENTITY;
    const double most = bytes_max(p);
    ad_status status = AD_OK;
    size_t order;
    if (stage->linear_algebra == TRAIN_MATRIX_FREE && !identity) {
        return ad_fail(error, AD_BAD_INPUT,
                       "training.stages[%d].linear_algebra: matrix_free has no diagonal of J^T J; "
                       "allowed with it: scaling identity",
                       number);
    }
    train_linear_algebra form = stage->linear_algebra;
    const bool separates = !identity && problem_separates(p, &order, NULL);
    if (form == TRAIN_SEPARATE && !separates) {
        return ad_fail(error, AD_BAD_INPUT,
                       "training.stages[%d].linear_algebra: separate is of linear networks in the "
                       "strain form that learn from solved members alone, with scaling diagonal",
                       number);
    }
    status = size_up(p, form == TRAIN_LINEAR_AUTOMATIC && separates ? TRAIN_SEPARATE : form, plan,
                     error);
    if (status == AD_OK && (plan->bytes > most || is_slow(plan)) && identity &&
        stage->linear_algebra == TRAIN_LINEAR_AUTOMATIC) {
        status = size_up(p, TRAIN_MATRIX_FREE, plan, error);
    }
    if (status == AD_OK && plan->bytes > most) {
        return ad_fail(error, AD_BAD_INPUT,
                       "training.stages[%d].optimizer: gauss_newton by %s keeps %.1f GB%s "
                       "for %zu parameters and %zu residuals; allowed: at most %.1f GB; make "
                       "network.hidden smaller, or take %s",
                       number, train_linear_algebra_names()[plan->form], 1e-9 * plan->bytes,
                       plan->form == TRAIN_MATRIX_FREE ? "" : " of matrices", plan->parameters,
                       plan->rows, 1e-9 * most,
                       plan->form == TRAIN_MATRIX_FREE ? "lbfgs"
                       : identity                      ? "linear_algebra matrix_free"
                                  : "scaling identity with linear_algebra matrix_free");
    }
    return status;
}

void linear_model_describe(const linear_model_info *info, char text[160])
{
    int n = snprintf(text, 160, "%s for %zu parameters", train_linear_algebra_names()[info->form],
                     info->parameters);
    n += info->form == TRAIN_SEPARATE
             ? snprintf(text + n, 160 - (size_t)n, ", %zu of each output", info->order)
             : snprintf(text + n, 160 - (size_t)n, " and %zu residuals", info->rows);
    n += snprintf(text + n, 160 - (size_t)n, ", %.1f MiB", info->bytes / (1024 * 1024));
    if (linear_model_flops(info) > MINUTES) {
        snprintf(text + n, 160 - (size_t)n,
                 ", %.2g Gflop a step: minutes; fewer features take less",
                 1e-9 * linear_model_flops(info));
    }
}

/* ---- making -------------------------------------------------------------------------------- */

void linear_model_free(linear_model *m)
{
    if (m) {
        ad_memory_free(&m->memory);
        ad_dense_factor_free(m->factor);
        optim_nystrom_free(m->preconditioner);
        optim_cg_free(m->cg);
        free(m);
    }
}

/* The same random numbers for every J: a step is what its point makes it, also after --resume. */
static bool allocate_vectors(linear_model *m)
{
    const size_t rank = rank_of(m->count);
    nn_rng rng = nn_rng_split(0, "nystrom");
    double *random = calloc(m->count, rank * sizeof *random);
    for (size_t i = 0; random && i < rank * m->count; i++) {
        random[i] = nn_rng_normal(&rng);
    }
    m->preconditioner = random ? optim_nystrom_create(m->count, rank, random) : NULL;
    free(random);
    m->cg = optim_cg_create(m->count);
    AD_TAKE(m, jtr, m->count);
    AD_TAKE(m, x, m->count);
    return m->preconditioner && m->cg && !m->memory.is_short;
}

static bool allocate(linear_model *m)
{
    if (m->info.form == TRAIN_MATRIX_FREE) {
        return allocate_vectors(m);
    }
    bool kernel = m->info.form == TRAIN_KERNEL;
    size_t order = kernel ? m->rows : m->count;
    if (m->info.form == TRAIN_SEPARATE) {
        order = m->info.order;
        m->outputs = m->count / order;
        m->rows = order; /* of r and z */
        AD_TAKE(m, factors, m->outputs);
        if (m->memory.is_short) {
            return false;
        }
    }
    AD_TAKE(m, jtr, m->count);
    AD_TAKE(m, matrix, order * order);
    m->factor = ad_dense_factor_create(order);
    AD_TAKE(m, shift, order);
    AD_TAKE(m, r, m->rows);
    AD_TAKE(m, z, m->rows);
    if (kernel) {
        AD_TAKE(m, jt, m->count * m->rows);
    }
    return m->factor && !m->memory.is_short;
}

ad_status linear_model_create(problem *p, const linear_model_info *plan, ad_pool *pool,
                              linear_model **result, ad_error *error)
{
    *result = NULL;
    ad_status status = ad_dense_load(error);
    if (status != AD_OK) {
        return status;
    }
    linear_model *m = calloc(1, sizeof *m);
    if (m) {
        m->problem = p;
        m->pool = pool;
        m->info = *plan;
        m->count = plan->parameters;
        m->rows = plan->rows;
    }
    if (!m || !allocate(m)) {
        linear_model_free(m);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the matrices of gauss_newton");
    }
    *result = m;
    return AD_OK;
}

linear_model_info linear_model_inspect(const linear_model *m)
{
    return m->info;
}

/* ---- at a point ---------------------------------------------------------------------------- */

static int product(void *context, const double *v, double *result)
{
    linear_model *m = context;
    m->status = problem_normal_product(m->problem, m->x, v, result, m->error);
    return m->status != AD_OK || ad_pool_stopped(m->pool);
}

/* The gradient by its own program, and where J^T J is large; of its diagonal what shows there. */
static ad_status linearize_products(linear_model *m, const double *x, double *value, double *jtr,
                                    double *diagonal, ad_error *error)
{
    ad_status status = problem_evaluate(m->problem, x, value, m->jtr, error);
    if (status != AD_OK) {
        return status;
    }
    for (size_t i = 0; i < m->count; i++) {
        m->jtr[i] /= 2;
    }
    memcpy(jtr, m->jtr, m->count * sizeof *jtr);
    memcpy(m->x, x, m->count * sizeof *x);
    m->error = error;
    const int code = optim_nystrom_update(m->preconditioner, product, m);
    m->error = NULL;
    if (code != 0) {
        return m->status;
    }
    optim_nystrom_diagonal(m->preconditioner, diagonal);
    return AD_OK;
}

/* Where of the parameters number `i` of an output is: its weights, then its bias. */
static size_t place_of(const linear_model *m, size_t output, size_t i)
{
    const size_t features = m->info.order - 1;
    return i < features ? output * features + i : m->outputs * features + output;
}

static ad_status linearize_separate(linear_model *m, const double *x, double *value,
                                    double *diagonal, ad_error *error)
{
    const size_t order = m->info.order;
    size_t size;
    problem_separates(m->problem, &size, m->factors);
    ad_status status = problem_evaluate(m->problem, x, value, m->jtr, error);
    status = status == AD_OK ? problem_separate_matrix(m->problem, m->matrix, error) : status;
    for (size_t i = 0; status == AD_OK && i < m->count; i++) {
        m->jtr[i] /= 2;
    }
    for (size_t k = 0; status == AD_OK && k < m->outputs; k++) {
        for (size_t i = 0; i < order; i++) {
            diagonal[place_of(m, k, i)] = m->factors[k] * m->factors[k] * m->matrix[i * order + i];
        }
    }
    return status;
}

ad_status linear_model_linearize(linear_model *m, const double *x, double *value, double *jtr,
                                 double *diagonal, ad_error *error)
{
    ad_status status;
    m->scaled = false;
    m->damped = NAN;
    if (m->info.form == TRAIN_MATRIX_FREE) {
        return linearize_products(m, x, value, jtr, diagonal, error);
    }
    if (m->info.form == TRAIN_SEPARATE) {
        status = linearize_separate(m, x, value, diagonal, error);
    } else if (m->info.form == TRAIN_KERNEL) {
        status = problem_jacobian(m->problem, x, value, m->jt, m->r, m->jtr, diagonal, error);
    } else {
        status = problem_normal_equations(m->problem, x, value, m->matrix, m->jtr, error);
        for (size_t i = 0; i < m->count; i++) {
            diagonal[i] = m->matrix[i * m->count + i];
        }
    }
    memcpy(jtr, m->jtr, m->count * sizeof *jtr);
    return status;
}

bool linear_model_keeps(const linear_model *m)
{
    static const double large = 5e8;      /* products in J^T J: some ten milliseconds */
    if (m->info.form == TRAIN_SEPARATE) { /* it does not depend on x */
        return true;
    }
    double products = (double)m->info.inner * (double)m->count * (double)m->count;
    return m->info.form == TRAIN_NORMAL_EQUATIONS && products > large;
}

void linear_model_refresh(linear_model *m, const double *jtr)
{
    memcpy(m->jtr, jtr, m->count * sizeof *jtr);
}

/* matrix + damping D, factored; D the unit matrix when scale is NULL. Where rounding leaves no
 * factor the step is refused, and the damping, which rises then, restores the conditioning; there
 * is no form by QR of J over sqrt(damping D). */
static bool factor(linear_model *m, size_t n, double damping, const double *scale)
{
    if (damping == m->damped) { /* and so is D */
        return true;
    }
    for (size_t i = 0; i < n; i++) {
        m->shift[i] = damping * (scale ? scale[i] : 1);
    }
    const bool found = ad_dense_cholesky(m->pool, m->matrix, m->shift, m->factor) == 0;
    m->info.factors++;
    m->info.failed += !found;
    m->damped = found ? damping : NAN;
    return found;
}

static int solve_normal_equations(linear_model *m, double damping, const double *scale,
                                  double *step)
{
    if (!factor(m, m->count, damping, scale)) {
        return 1;
    }
    for (size_t i = 0; i < m->count; i++) {
        step[i] = -m->jtr[i];
    }
    ad_dense_cholesky_solve(m->factor, step);
    return 0;
}

/* (factor^2 (matrix + damping diagonal)) step = -J^T r of every output. */
static int solve_separate(linear_model *m, double damping, double *step)
{
    const size_t order = m->info.order;
    for (size_t i = 0; i < order && !m->scaled; i++) {
        m->r[i] = m->matrix[i * order + i];
    }
    m->scaled = true;
    if (!factor(m, order, damping, m->r)) {
        return 1;
    }
    for (size_t k = 0; k < m->outputs; k++) {
        const double square = m->factors[k] * m->factors[k];
        for (size_t i = 0; i < order; i++) {
            m->z[i] = square > 0 ? -m->jtr[place_of(m, k, i)] / square : 0;
        }
        ad_dense_cholesky_solve(m->factor, m->z);
        for (size_t i = 0; i < order; i++) {
            step[place_of(m, k, i)] = m->z[i];
        }
    }
    return 0;
}

static void make_kernel(linear_model *m, const double *scale)
{
    for (size_t i = 0; i < m->count; i++) {
        const double by = 1 / sqrt(scale[i]);
        for (size_t k = 0; by != 1 && k < m->rows; k++) {
            m->jt[i * m->rows + k] *= by;
        }
    }
    ad_dense_gram(m->pool, m->count, m->rows, m->jt, m->matrix);
    m->scaled = true;
}

static int solve_kernel(linear_model *m, double damping, const double *scale, double *step)
{
    if (!m->scaled) {
        make_kernel(m, scale);
    }
    if (!factor(m, m->rows, damping, NULL)) {
        return 1;
    }
    memcpy(m->z, m->r, m->rows * sizeof *m->z);
    ad_dense_cholesky_solve(m->factor, m->z);
    for (size_t i = 0; i < m->count; i++) {
        double sum = 0;
        for (size_t k = 0; k < m->rows; k++) {
            sum += m->jt[i * m->rows + k] * m->z[k];
        }
        step[i] = -sum / sqrt(scale[i]);
    }
    return 0;
}

static int solve_products(linear_model *m, double damping, double *step)
{
    ad_error error;
    m->error = &error;
    const optim_cg_result found =
        optim_cg_solve(m->cg, product, m, damping, m->preconditioner, m->jtr,
                       LINEAR_MODEL_TOLERANCE, ITERATIONS_MAX, step);
    m->error = NULL;
    m->info.solves++;
    m->info.iterations += found.iterations;
    for (size_t i = 0; i < m->count; i++) {
        step[i] = -step[i];
    }
    return found.code;
}

static int solve(linear_model *m, double damping, const double *scale, double *step)
{
    switch (m->info.form) {
    case TRAIN_MATRIX_FREE:
        return solve_products(m, damping, step);
    case TRAIN_SEPARATE:
        return solve_separate(m, damping, step);
    case TRAIN_KERNEL:
        return solve_kernel(m, damping, scale, step);
    default:
        return solve_normal_equations(m, damping, scale, step);
    }
}

int linear_model_solve(linear_model *m, double damping, const double *scale, double *step)
{
    const int code = solve(m, damping, scale, step);
    return ad_pool_stopped(m->pool) ? OPTIM_OBJECTIVE_STOP : code;
}
