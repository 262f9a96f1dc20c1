/* The tape's side of step.py, which reads what is printed here.
 *   step_tape FOLDER gradient|interpreted|normal THREADS
 *   step_tape - rates 1
 * The first: loss and gradient of the scene FOLDER/scene.yaml with the parameters of FOLDER/x.bin,
 * with groups of the tape as machine code or interpreted, or a Gauss-Newton step. Writes
 * FOLDER/case.bin (s, t, parameters, loss, gradient) and of the last jtj.bin,
 * [parameters][parameters], upper triangle. Prints what it is, and then makes a step for every line
 * that it reads and prints its seconds. The second: multiply-adds a second, times 2, of products by
 * OpenBLAS and by the tape's own. */
#include "autodiff/compile/kernels.h"
#include "autodiff/dense.h"
#include "autodiff/run/blas.h"
#include "physics/numerics/clock.h"
#include "physics/numerics/sort.h"
#include "tools/prepare/config_experiment.h"
#include "tools/train/trainer.h"

#include <stdlib.h>
#include <string.h>

static const double DAMPING = 1e-3; /* of the Gauss-Newton step, as in the peers */

typedef struct side {
    experiment *e;
    problem *problem;
    const double *s, *t; /* [points], the problem's own */
    size_t points, count;
    double *x, loss, *gradient;
    double *jtj, *jtr, *damping; /* of the Gauss-Newton step, else NULL */
    ad_dense_factor *factor;
} side;

/* ---- steps ---------------------------------------------------------------------------------- */

/* (J^T J + damping diag) step = -J^T r; the step is left in the gradient's place. */
static ad_status normal_step(side *a, ad_error *error)
{
    const ad_status status =
        problem_normal_equations(a->problem, a->x, &a->loss, a->jtj, a->jtr, error);
    for (size_t i = 0; status == AD_OK && i < a->count; i++) {
        a->damping[i] = DAMPING * (a->jtj[i * a->count + i] + DAMPING);
        a->gradient[i] = -a->jtr[i];
    }
    if (status == AD_OK && ad_dense_cholesky(a->e->pool, a->jtj, a->damping, a->factor) != 0) {
        return ad_fail(error, AD_NOT_FINITE, "the matrix has no Cholesky factor");
    }
    if (status == AD_OK) {
        ad_dense_cholesky_solve(a->factor, a->gradient);
    }
    return status;
}

static ad_status step(side *a, ad_error *error)
{
    return a->jtj ? normal_step(a, error)
                  : problem_evaluate(a->problem, a->x, &a->loss, a->gradient, error);
}

/* ---- the case ------------------------------------------------------------------------------- */

static ad_status open_case(side *a, const char *folder, int threads, ad_error *error)
{
    char path[4096];
    config *settings;
    snprintf(path, sizeof path, "%s/scene.yaml", folder);
    ad_status status = prepare_read(path, NULL, 0, NULL, &settings, error);
    status = status == AD_OK ? config_experiment_create(settings, threads, &a->e, error) : status;
    status = status == AD_OK ? experiment_problem(a->e, &a->problem, error) : status;
    if (status != AD_OK) {
        return status;
    }
    problem_array arrays[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int generator_count;
    problem_state(a->problem, arrays, generators, &generator_count);
    a->points = problem_set_inspect(a->problem, 0).points;
    a->s = arrays[0].data; /* points/interior [2][points] */
    a->t = a->s + a->points;
    a->count = a->e->count;
    a->x = experiment_parameters(a->e);
    snprintf(path, sizeof path, "%s/x.bin", folder);
    FILE *file = fopen(path, "rb");
    const size_t got = file ? fread(a->x, sizeof *a->x, a->count, file) : 0;
    if (file) {
        fclose(file);
    }
    a->gradient = malloc(a->count * sizeof *a->gradient);
    return !a->gradient      ? ad_fail(error, AD_NO_MEMORY, "out of memory")
           : got == a->count ? AD_OK
                             : ad_fail(error, AD_IO, "%s: not %zu parameters", path, a->count);
}

static ad_status make_normal(side *a, ad_error *error)
{
    const size_t n = a->count;
    problem_least_squares sizes;
    a->jtr = malloc(n * sizeof *a->jtr);
    a->jtj = malloc(n * n * sizeof *a->jtj);
    a->damping = malloc(n * sizeof *a->damping);
    a->factor = ad_dense_factor_create(n);
    if (!a->jtr || !a->jtj || !a->damping || !a->factor) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    const ad_status status = ad_dense_load(error);
    return status == AD_OK ? problem_prepare_least_squares(a->problem, &sizes, error) : status;
}

/* The elementwise groups as machine code, where there is a compiler. */
static problem_fusing fuse(const side *a)
{
    char folder[4000];
    problem_fusing state = {0, 0};
    ad_error error;
    if (trainer_fuse_folder(folder, true)) {
        problem_fuse(a->problem, folder, PROBLEM_FUSE_WAIT, &state, &error);
    }
    return state;
}

static ad_status write_numbers(const char *folder, const char *name, const double *const parts[],
                               const size_t sizes[], int count, ad_error *error)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    for (int i = 0; file && i < count; i++) {
        fwrite(parts[i], sizeof **parts, sizes[i], file);
    }
    const bool good = file && ferror(file) == 0;
    return file && fclose(file) == 0 && good ? AD_OK
                                             : ad_fail(error, AD_IO, "%s: cannot be written", path);
}

static ad_status write_case(side *a, const char *folder, ad_error *error)
{
    const size_t n = a->count;
    if (a->jtj) { /* the gradient in place of the step */
        for (size_t i = 0; i < n; i++) {
            a->gradient[i] = 2 * a->jtr[i];
        }
    }
    ad_status status = write_numbers(
        folder, "case.bin", (const double *const[]){a->s, a->t, a->x, &a->loss, a->gradient},
        (const size_t[]){a->points, a->points, n, 1, n}, 5, error);
    if (status == AD_OK && a->jtj) {
        status = write_numbers(folder, "jtj.bin", (const double *const[]){a->jtj},
                               (const size_t[]){n * n}, 1, error);
    }
    return status;
}

static void print_about(const side *a, problem_fusing fused)
{
    const problem_set_info info = problem_set_inspect(a->problem, 0);
    printf("{\"parameters\": %zu, \"flops\": %g, \"instructions\": %zu, \"tile\": %d, \"numbers\": "
           "%d, \"fused\": %d, \"programs\": %d}\n",
           a->count, (double)info.program.flops_per_point, info.program.instructions,
           info.program.tile, 2 + info.fixed_rows, fused.fused, fused.programs);
    fflush(stdout);
}

static ad_status serve(side *a, const char *folder, const char *kind, ad_error *error)
{
    char line[64];
    ad_status status = strcmp(kind, "normal") == 0 ? make_normal(a, error) : AD_OK;
    const problem_fusing none = {0, 0}, fused = status == AD_OK && strcmp(kind, "interpreted") != 0
                                                    ? fuse(a)
                                                    : none;
    status = status == AD_OK ? step(a, error) : status;
    status = status == AD_OK ? write_case(a, folder, error) : status;
    if (status == AD_OK) {
        print_about(a, fused);
    }
    while (status == AD_OK && fgets(line, sizeof line, stdin)) {
        const double start = clock_seconds(CLOCK_MONOTONIC);
        status = step(a, error);
        printf("%.9f\n", clock_seconds(CLOCK_MONOTONIC) - start);
        fflush(stdout);
    }
    return status;
}

/* ---- the machine ---------------------------------------------------------------------------- */

/* The tape's products by the name of OpenBLAS's. */
static void tape_gemm(int order, int transpose_a, int transpose_b, int m, int n, int k,
                      double alpha, const double *a, int lda, const double *b, int ldb, double beta,
                      double *c, int ldc)
{
    (void)order, (void)transpose_b, (void)alpha; /* row-major, as it is, 1 */
    const bool turned = transpose_a == BLAS_TRANSPOSED;
    ad_kernels_select()->products->multiply(m, n, k, a, turned ? 1 : lda, turned ? lda : 1, b, ldb,
                                            c, ldc, beta != 0);
}

/* The products that a step consists of: weights of a hidden layer times five coefficients of 32
 * points, the median of many. */
static double gemm_rate(blas_gemm gemm)
{
    enum { N = 64, COLUMNS = 160, TIMES = 200, TRIALS = 21 };
    static double a[N * N], b[N * COLUMNS] __attribute__((aligned(64))), c[N * COLUMNS];
    double seconds[TRIALS];
    for (int trial = 0; trial < TRIALS; trial++) {
        const double start = clock_seconds(CLOCK_MONOTONIC);
        for (int i = 0; i < TIMES; i++) {
            gemm(BLAS_ROW_MAJOR, BLAS_NORMAL, BLAS_NORMAL, N, COLUMNS, N, 1, a, N, b, COLUMNS, 0, c,
                 COLUMNS);
        }
        seconds[trial] = (clock_seconds(CLOCK_MONOTONIC) - start) / TIMES;
    }
    return 2.0 * N * N * COLUMNS / sort_median(TRIALS, seconds);
}

static ad_status print_rates(ad_error *error)
{
    const blas *library = ad_blas_load(error);
    if (!library) {
        return error->status;
    }
    printf("{\"openblas\": [\"%s\", %g], \"own\": [\"%s\", %g]}\n", library->core,
           gemm_rate(library->gemm), ad_kernels_select()->name, gemm_rate(tape_gemm));
    return AD_OK;
}

int main(int count, char **arguments)
{
    side a = {0};
    ad_error error = {AD_OK, ""};
    if (count != 4) {
        return 2;
    }
    ad_status status = AD_OK;
    if (strcmp(arguments[2], "rates") == 0) {
        status = print_rates(&error);
    } else {
        status = open_case(&a, arguments[1], atoi(arguments[3]), &error);
        status = status == AD_OK ? serve(&a, arguments[1], arguments[2], &error) : status;
    }
    if (status != AD_OK) {
        fprintf(stderr, "step: %s\n", error.message);
    }
    problem_free(a.problem);
    experiment_free(a.e);
    free(a.gradient);
    free(a.jtj);
    free(a.jtr);
    free(a.damping);
    ad_dense_factor_free(a.factor);
    return status == AD_OK ? 0 : 1;
}
