/* step [--points N] [--threads N] [--out FILE.csv] [--memory]
 *
 * One training step, value and gradient, of the problem in fused.h: the recorded tape against the
 * yardstick fused by hand, both on the same OpenBLAS, in turn, medians of the repetitions. Exit
 * status 1 when the two disagree. --memory instead measures how much the memory of the process
 * grows when the points become a hundred times as many. */
#include "autodiff/blas.h"
#include "fused.h"
#include "tools/clock.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { LAYERS = 5, REPETITIONS = 15, THREADS_MAX = FUSED_MAX_THREADS, POINTS_MAX = 10000000 };

static const double AGREEMENT = 1e-10; /* sums of up to 10^7 terms, in different orders */

typedef struct options {
    size_t points;
    int threads;
    const char *out;
    bool memory;
} options;

typedef struct problem {
    size_t points;
    double *s, *t; /* [points] */
    double parameters[FUSED_PARAMETERS];
} problem;

typedef struct result {
    double loss;
    double gradient[FUSED_PARAMETERS];
} result;

typedef struct contest {
    int threads;
    double tape, fused; /* medians, seconds per point */
    double ratio;       /* median over the repetitions: a busy moment slows both of a pair */
    double disagreement;
} contest;

typedef struct tape_side {
    ad_pool *pool;
    ad_program *program;
} tape_side;

static int compare_numbers(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, compare_numbers);
    return values[count / 2];
}

/* A linear congruential generator (Knuth's MMIX constants): uniform in [0, 1). */
static double uniform(unsigned long long *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53;
}

static void problem_free(problem *p)
{
    if (p) {
        free(p->s);
        free(p->t);
        free(p);
    }
}

static problem *problem_create(size_t points)
{
    problem *p = calloc(1, sizeof *p);
    if (!p) {
        return NULL;
    }
    p->points = points;
    p->s = malloc(points * sizeof *p->s);
    p->t = malloc(points * sizeof *p->t);
    if (!p->s || !p->t) {
        problem_free(p);
        return NULL;
    }
    unsigned long long seed = 1;
    for (int i = 0; i < FUSED_PARAMETERS; i++) {
        p->parameters[i] = 0.4 * (uniform(&seed) - 0.5);
    }
    for (size_t i = 0; i < points; i++) {
        p->s[i] = uniform(&seed);
        p->t[i] = uniform(&seed);
    }
    return p;
}

/* ---- the tape ------------------------------------------------------------------------------- */

static ad_value record_network(ad_value parameters, ad_value s, ad_value t)
{
    static const int widths[LAYERS + 1] = {FUSED_INPUTS, FUSED_WIDTH, FUSED_WIDTH,
                                           FUSED_WIDTH,  FUSED_WIDTH, FUSED_OUTPUTS};
    ad_value y = ad_stack(2, (ad_value[]){s, t});
    int at = 0;
    for (int layer = 0; layer < LAYERS; layer++) {
        int k = widths[layer], m = widths[layer + 1];
        ad_value weights = ad_slice(parameters, at, m * k);
        ad_value bias = ad_slice(parameters, at + m * k, m);
        at += m * k + m;
        y = ad_add(ad_matvec(weights, y), bias);
        y = layer < LAYERS - 1 ? ad_tanh(y) : y;
    }
    return y;
}

static bool tape_compile(tape_side *side, ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    if (!tape) {
        return false;
    }
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
    ad_value parameters = ad_parameter(tape, "parameters", FUSED_PARAMETERS, 0), gradient;
    ad_value y = record_network(parameters, s, t);
    ad_value residual = ad_sub(y, ad_scalar(tape, 0.1));
    residual = ad_add(residual, ad_scale(ad_derivative(y, s, 1), 0.5));
    residual = ad_add(residual, ad_scale(ad_derivative(y, s, 2), 0.25));
    residual = ad_add(residual, ad_scale(ad_derivative(y, t, 1), 0.3));
    residual = ad_add(residual, ad_scale(ad_derivative(y, t, 2), 0.2));
    ad_value loss = ad_div(ad_sum_points(ad_dot(residual, residual)), ad_points(tape));
    ad_reverse(loss, 1, &parameters, AD_SUMMED, &gradient);
    ad_value outputs[2] = {loss, gradient};
    bool ok = ad_tape_status(tape, error) == AD_OK &&
              ad_compile(2, outputs, NULL, side->pool, &side->program, error) == AD_OK;
    ad_tape_free(tape);
    return ok;
}

static void tape_free(tape_side *side)
{
    ad_program_free(side->program);
    ad_pool_free(side->pool);
    *side = (tape_side){NULL, NULL};
}

static bool tape_create(tape_side *side, int threads)
{
    ad_error error = {0};
    *side = (tape_side){ad_pool_create(threads), NULL};
    if (!side->pool || !tape_compile(side, &error)) {
        fprintf(stderr, "step: the tape: %s\n", side->pool ? error.message : "no threads left");
        tape_free(side);
        return false;
    }
    return true;
}

static bool tape_step(const tape_side *side, const problem *p, result *to)
{
    const double *inputs[2] = {p->s, p->t};
    double *outputs[2] = {&to->loss, to->gradient};
    ad_run run = {p->points, inputs, NULL, p->parameters, outputs};
    ad_error error = {0};
    if (ad_execute(side->program, &run, &error) != AD_OK) {
        fprintf(stderr, "step: the tape: %s\n", error.message);
        return false;
    }
    return true;
}

/* ---- the machine ---------------------------------------------------------------------------- */

/* Multiply-adds per second, times 2, of the products that a step consists of: weights of a hidden
 * layer times five coefficients of 32 points, the median of many. */
static double dgemm_rate(const blas *library)
{
    enum { N = FUSED_WIDTH, COLUMNS = 160, TIMES = 200, TRIALS = 21 };
    double *a = calloc(N * N, sizeof *a), *b = calloc(N * COLUMNS, sizeof *b);
    double *c = calloc(N * COLUMNS, sizeof *c), seconds[TRIALS];
    for (int trial = 0; a && b && c && trial < TRIALS; trial++) {
        double start = wall_seconds();
        for (int i = 0; i < TIMES; i++) {
            library->gemm(BLAS_ROW_MAJOR, BLAS_NORMAL, BLAS_NORMAL, N, COLUMNS, N, 1, a, N, b,
                          COLUMNS, 0, c, COLUMNS);
        }
        seconds[trial] = (wall_seconds() - start) / TIMES;
    }
    double rate = a && b && c ? 2.0 * N * N * COLUMNS / median(seconds, TRIALS) : NAN;
    free(a);
    free(b);
    free(c);
    return rate;
}

/* ---- contest -------------------------------------------------------------------------------- */

static double disagreement(const result *a, const result *b)
{
    double worst = fabs(a->loss - b->loss) / fabs(b->loss), difference = 0, largest = 0;
    for (int i = 0; i < FUSED_PARAMETERS; i++) {
        difference = fmax(difference, fabs(a->gradient[i] - b->gradient[i]));
        largest = fmax(largest, fabs(b->gradient[i]));
        worst = isfinite(a->gradient[i]) ? worst : INFINITY; /* fmax would hide it */
    }
    double relative = difference / largest;
    return worst > relative ? worst : relative;
}

static bool run_contest(const tape_side *side, fused_state *fused, const problem *p, contest *c)
{
    static result tape_result, fused_result;
    double tape[REPETITIONS], hand[REPETITIONS], ratio[REPETITIONS];
    for (int i = -1; i < REPETITIONS; i++) { /* the first to warm up */
        double start = wall_seconds();
        if (!tape_step(side, p, &tape_result)) {
            return false;
        }
        double between = wall_seconds();
        fused_step(fused, p->parameters, p->s, p->t, p->points, &fused_result.loss,
                   fused_result.gradient);
        if (i >= 0) {
            tape[i] = (between - start) / (double)p->points;
            hand[i] = (wall_seconds() - between) / (double)p->points;
            ratio[i] = tape[i] / hand[i];
        }
    }
    c->tape = median(tape, REPETITIONS);
    c->fused = median(hand, REPETITIONS);
    c->ratio = median(ratio, REPETITIONS);
    c->disagreement = disagreement(&tape_result, &fused_result);
    return true;
}

static bool contest_with(const blas *library, const problem *p, contest *c, ad_program_info *info)
{
    fused_blas pointer = {library->gemm};
    fused_state *fused = fused_create(&pointer, 0, c->threads);
    tape_side side;
    if (!fused || !tape_create(&side, c->threads)) {
        fprintf(stderr, "step: cannot set up %d threads\n", c->threads);
        fused_free(fused);
        return false;
    }
    *info = ad_program_inspect(side.program);
    bool ok = run_contest(&side, fused, p, c);
    tape_free(&side);
    fused_free(fused);
    return ok;
}

/* ---- report --------------------------------------------------------------------------------- */

static void print_side(const char *name, int threads, double seconds, double flops, double rate)
{
    double reached = flops / seconds;
    printf("%-6s %7d %14.3f %14.1f %17.3f\n", name, threads, 1e6 * seconds, 1e-9 * reached,
           reached / (rate * threads));
}

static void print_contests(const contest *c, int count, const ad_program_info *info, double rate)
{
    double flops = (double)info->flops_per_point;
    printf("dgemm, one thread: %.1f Gflop/s; matrix products of a step: %zu flops/point\n",
           1e-9 * rate, info->flops_per_point);
    printf("tape: %zu instructions, %zu products, tiles of %d points, workspace %zu KB\n\n",
           info->instructions, info->products, info->tile, info->workspace_bytes / 1024);
    printf("%-6s %7s %14s %14s %17s\n", "", "threads", "us per point", "Gflop/s",
           "fraction of dgemm");
    for (int i = 0; i < count; i++) {
        print_side("tape", c[i].threads, c[i].tape, flops, rate);
        print_side("fused", c[i].threads, c[i].fused, flops, rate);
    }
    printf("\n");
    for (int i = 0; i < count; i++) {
        printf("tape / fused, %d thread%s: %.3f; they agree to %.1e\n", c[i].threads,
               c[i].threads > 1 ? "s" : "", c[i].ratio, c[i].disagreement);
    }
}

static bool write_csv(const char *path, const contest *c, int count, const problem *p, double flops,
                      double rate)
{
    FILE *file = fopen(path, "w");
    if (!file) {
        fprintf(stderr, "step: %s: %s\n", path, strerror(errno));
        return false;
    }
    fprintf(file, "points,threads,tape_us_per_point,fused_us_per_point,ratio,tape_gflops,"
                  "fused_gflops,dgemm_gflops_per_thread,tape_fraction,fused_fraction,"
                  "disagreement\n");
    for (int i = 0; i < count; i++) {
        double tape = flops / c[i].tape, fused = flops / c[i].fused, whole = rate * c[i].threads;
        fprintf(file, "%zu,%d,%.4f,%.4f,%.4f,%.2f,%.2f,%.2f,%.4f,%.4f,%.2e\n", p->points,
                c[i].threads, 1e6 * c[i].tape, 1e6 * c[i].fused, c[i].ratio, 1e-9 * tape,
                1e-9 * fused, 1e-9 * rate, tape / whole, fused / whole, c[i].disagreement);
    }
    if (fclose(file) != 0) {
        fprintf(stderr, "step: %s: %s\n", path, strerror(errno));
        return false;
    }
    return true;
}

static int compare_sides(const options *o, const blas *library)
{
    problem *p = problem_create(o->points);
    if (!p) {
        fprintf(stderr, "step: out of memory for %zu points\n", o->points);
        return EXIT_FAILURE;
    }
    double rate = dgemm_rate(library);
    contest contests[2] = {{.threads = 1}, {.threads = o->threads}};
    int count = o->threads > 1 ? 2 : 1;
    ad_program_info info = {0};
    bool ok = true;
    for (int i = 0; ok && i < count; i++) {
        ok = contest_with(library, p, &contests[i], &info);
    }
    if (ok) {
        printf("%zu points, OpenBLAS kernels: %s\n", o->points, library->core);
        print_contests(contests, count, &info, rate);
        ok = !o->out || write_csv(o->out, contests, count, p, (double)info.flops_per_point, rate);
    }
    for (int i = 0; ok && i < count; i++) {
        if (!(contests[i].disagreement <= AGREEMENT)) {
            fprintf(stderr, "step: tape and yardstick differ by %.1e; at most %.0e is allowed\n",
                    contests[i].disagreement, AGREEMENT);
            ok = false;
        }
    }
    problem_free(p);
    return ok ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* ---- memory --------------------------------------------------------------------------------- */

static double peak_bytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * (double)usage.ru_maxrss; /* kilobytes on Linux */
}

static bool peak_after(const tape_side *side, size_t points, double *peak)
{
    static result ignored;
    problem *p = problem_create(points);
    bool ok = p && tape_step(side, p, &ignored);
    *peak = peak_bytes();
    problem_free(p);
    return ok;
}

/* What a run needs beside its points is tiles and sums, whose number is bounded: the process may
 * grow by the points, and by half as much for the bounded rest and the page tables. */
static int measure_memory(const options *o)
{
    enum { FEW = 10000, MANY = 1000000 };
    tape_side side;
    if (!tape_create(&side, o->threads)) {
        return EXIT_FAILURE;
    }
    double before, after;
    bool ok = peak_after(&side, FEW, &before) && peak_after(&side, MANY, &after);
    tape_free(&side);
    if (!ok) {
        fprintf(stderr, "step: out of memory for %d points\n", MANY);
        return EXIT_FAILURE;
    }
    double points = (double)(MANY - FEW) * FUSED_INPUTS * sizeof(double), growth = after - before;
    printf("peak memory: %.1f MB at %d points, %.1f MB at %d: growth %.1f MB, of which points "
           "%.1f MB\n",
           1e-6 * before, FEW, 1e-6 * after, MANY, 1e-6 * growth, 1e-6 * points);
    if (growth > 1.5 * points) {
        fprintf(stderr, "step: memory grows with the points by more than the points\n");
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}

/* ---- command line --------------------------------------------------------------------------- */

static bool read_count(const char *name, const char *text, long most, long *count)
{
    char *end = NULL;
    errno = 0;
    long value = text ? strtol(text, &end, 10) : 0;
    if (!text || errno || end == text || *end || value < 1 || value > most) {
        fprintf(stderr, "step: %s: %s; a number from 1 to %ld is needed\n", name,
                text ? text : "missing", most);
        return false;
    }
    *count = value;
    return true;
}

static bool read_options(int count, char **arguments, options *o)
{
    for (int i = 1; i < count; i++) {
        const char *name = arguments[i], *next = i + 1 < count ? arguments[i + 1] : NULL;
        long number = 0;
        bool points = strcmp(name, "--points") == 0, threads = strcmp(name, "--threads") == 0;
        if (strcmp(name, "--memory") == 0) {
            o->memory = true;
        } else if (points || threads) {
            if (!read_count(name, next, points ? POINTS_MAX : THREADS_MAX, &number)) {
                return false;
            }
            o->points = points ? (size_t)number : o->points;
            o->threads = threads ? (int)number : o->threads;
            i++;
        } else if (strcmp(name, "--out") == 0 && next) {
            o->out = next;
            i++;
        } else {
            fprintf(stderr, "usage: step [--points N] [--threads N] [--out FILE.csv] [--memory]\n");
            return false;
        }
    }
    return true;
}

int main(int count, char **arguments)
{
    options o = {.points = 16384, .threads = 2};
    ad_error error = {0};
    if (!read_options(count, arguments, &o)) {
        return EXIT_FAILURE;
    }
    const blas *library = blas_load(&error);
    if (!library) {
        fprintf(stderr, "step: %s\n", error.message);
        return EXIT_FAILURE;
    }
    return o.memory ? measure_memory(&o) : compare_sides(&o, library);
}
