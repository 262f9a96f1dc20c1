/* One training step, value and gradient, of the rod of rod_case.h, and one Gauss-Newton step of a
 * smaller network: the recorded tape against the rate of its products and against the peers in
 * Python. Everybody takes turns with the tape, so that a busy moment slows both of a pair; medians.
 * See --help. */
#include "autodiff/compile/kernels.h"
#include "autodiff/dense.h"
#include "autodiff/run/blas.h"
#include "peers.h"
#include "physics/numerics/sort.h"
#include "tools/programs/cli.h"
#include "tools/programs/help.h"
#include "tools/train/clock.h"
#include "tools/train/trainer.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum {
    HIDDEN = 4,
    WIDTH = 64,
    GAUSS_NEWTON_HIDDEN = 3,
    GAUSS_NEWTON_WIDTH = 32,
    ROUNDS_MAX = 101,
    THREADS_MAX = 256
};

static const double DAMPING = 1e-3; /* of the Gauss-Newton step, as in the peers */

static const char program[] = "step";

typedef struct options {
    int points, normal_points, threads, rounds;
    const char *python;
    bool memory, peers;
} options;

/* One step of somebody. */
typedef bool step_function(void *side);

typedef struct entrant {
    const char *name;
    step_function *step;
    void *side;
    bool (*timed)(void *side, double *seconds); /* instead of `step`: measures itself */
    int threads;
} entrant;

/* A line of the table. */
typedef struct row {
    const char *name;
    int threads;
    size_t points;
    double seconds;            /* median, of a step */
    double ratio, least, most; /* to the tape with `reference_threads`, median and extremes */
    double flops, fraction;    /* per second; of the products' rate. NaN: not known */
    double disagreement;       /* NaN: nothing to compare with */
    double preparation;        /* s; NaN: none */
    char remark[160];          /* why there are no numbers */
} row;

enum { ROWS_MAX = 32 };

typedef struct report {
    const options *o;
    double rates[2], rate; /* of products, one thread: OpenBLAS's, the tape's; the better one's */
    row rows[ROWS_MAX];
    int count;
} report;

/* ---- sides ---------------------------------------------------------------------------------- */

typedef struct tape_side {
    rod_case c;
    double loss, *gradient;
    double *jtj, *jtr, *damping; /* of the Gauss-Newton step, else NULL */
    ad_dense_factor *factor;
} tape_side;

static bool tape_step(void *side)
{
    tape_side *t = side;
    ad_error error;
    if (problem_evaluate(t->c.problem, t->c.x, &t->loss, t->gradient, &error) != AD_OK) {
        cli_fail_error(program, &error);
        return false;
    }
    return true;
}

/* (J^T J + damping diag) step = -J^T r; the step is left in the gradient's place. */
static bool normal_step(void *side)
{
    tape_side *t = side;
    size_t n = t->c.parameters;
    ad_error error;
    if (problem_normal_equations(t->c.problem, t->c.x, &t->loss, t->jtj, t->jtr, &error) != AD_OK) {
        cli_fail_error(program, &error);
        return false;
    }
    for (size_t i = 0; i < n; i++) {
        t->damping[i] = DAMPING * (t->jtj[i * n + i] + DAMPING);
        t->gradient[i] = -t->jtr[i];
    }
    if (ad_dense_cholesky(t->c.pool, t->jtj, t->damping, t->factor) != 0) {
        cli_fail(program, "Gauss-Newton: the matrix has no Cholesky factor");
        return false;
    }
    ad_dense_cholesky_solve(t->factor, t->gradient);
    return true;
}

static void tape_free(tape_side *t)
{
    rod_case_free(&t->c);
    free(t->gradient);
    free(t->jtj);
    free(t->damping);
    ad_dense_factor_free(t->factor);
    free(t->jtr);
    *t = (tape_side){0};
}

/* The elementwise groups as machine code, where there is a compiler; else a word about it. */
static void tape_fuse(const tape_side *t)
{
    char folder[4000];
    problem_fusing state = {0, 0};
    ad_error error = {AD_OK, "no cache folder"};
    double start = train_seconds();
    if (trainer_fuse_folder(folder, true)) {
        problem_fuse(t->c.problem, folder, PROBLEM_FUSE_WAIT, &state, &error);
    }
    printf("groups of %d of %d programs compiled and loaded in %.2f s%s%s\n", state.fused,
           state.programs, train_seconds() - start, error.status == AD_OK ? "" : ": ",
           error.status == AD_OK ? "" : error.message);
}

static bool tape_create(tape_side *t, int points, int threads, bool fuse)
{
    ad_error error;
    *t = (tape_side){0};
    if (rod_case_create(&t->c, HIDDEN, WIDTH, points, threads, &error) != AD_OK) {
        cli_fail_error(program, &error);
        return false;
    }
    t->gradient = malloc(t->c.parameters * sizeof *t->gradient);
    if (!t->gradient) {
        cli_fail(program, "out of memory");
        tape_free(t);
    } else if (fuse) {
        tape_fuse(t);
    }
    return t->gradient;
}

static bool normal_create(tape_side *t, int points, int threads)
{
    ad_error error;
    *t = (tape_side){0};
    if (ad_dense_load(&error) != AD_OK ||
        rod_case_create(&t->c, GAUSS_NEWTON_HIDDEN, GAUSS_NEWTON_WIDTH, points, threads, &error) !=
            AD_OK) {
        cli_fail_error(program, &error);
        return false;
    }
    size_t n = t->c.parameters;
    t->gradient = malloc(n * sizeof *t->gradient);
    t->jtr = malloc(n * sizeof *t->jtr);
    t->jtj = malloc(n * n * sizeof *t->jtj);
    t->damping = malloc(n * sizeof *t->damping);
    t->factor = ad_dense_factor_create(n);
    if (!t->gradient || !t->jtr || !t->jtj || !t->damping || !t->factor) {
        cli_fail(program, "out of memory");
        tape_free(t);
        return false;
    }
    problem_least_squares sizes;
    if (problem_prepare_least_squares(t->c.problem, &sizes, &error) != AD_OK) {
        cli_fail_error(program, &error);
        tape_free(t);
        return false;
    }
    tape_fuse(t);
    return true;
}

/* ---- the machine ---------------------------------------------------------------------------- */

/* The tape's products by the name of OpenBLAS's. */
static void tape_gemm(int order, int transpose_a, int transpose_b, int m, int n, int k,
                      double alpha, const double *a, int lda, const double *b, int ldb, double beta,
                      double *c, int ldc)
{
    (void)order, (void)transpose_b, (void)alpha; /* row-major, as it is, 1 */
    bool turned = transpose_a == BLAS_TRANSPOSED;
    ad_kernels_select()->products->multiply(m, n, k, a, turned ? 1 : lda, turned ? lda : 1, b, ldb,
                                            c, ldc, beta != 0);
}

/* Multiply-adds per second, times 2, of the products that a step consists of: weights of a hidden
 * layer times five coefficients of 32 points, the median of many. */
static double gemm_rate(blas_gemm gemm)
{
    enum { N = WIDTH, COLUMNS = 160, TIMES = 200, TRIALS = 21 };
    static double a[N * N], b[N * COLUMNS] __attribute__((aligned(64))), c[N * COLUMNS];
    double seconds[TRIALS];
    for (int trial = 0; trial < TRIALS; trial++) {
        double start = train_seconds();
        for (int i = 0; i < TIMES; i++) {
            gemm(BLAS_ROW_MAJOR, BLAS_NORMAL, BLAS_NORMAL, N, COLUMNS, N, 1, a, N, b, COLUMNS, 0, c,
                 COLUMNS);
        }
        seconds[trial] = (train_seconds() - start) / TIMES;
    }
    return 2.0 * N * N * COLUMNS / sort_median(TRIALS, seconds);
}

/* ---- turns ---------------------------------------------------------------------------------- */

static bool one_step(const entrant *e, double *seconds)
{
    if (e->timed) {
        return e->timed(e->side, seconds);
    }
    double start = train_seconds();
    bool ok = e->step(e->side);
    *seconds = train_seconds() - start;
    return ok;
}

/* `rounds` steps of each in turn, after one that warms up; fills the row's times and ratios. */
static bool take_turns(const entrant *reference, const entrant *e, int rounds, row *r)
{
    double seconds[ROUNDS_MAX], ratios[ROUNDS_MAX], ours, theirs;
    for (int i = -1; i < rounds; i++) {
        if (!one_step(reference, &ours) || !one_step(e, &theirs)) {
            return false;
        }
        if (i >= 0) {
            seconds[i] = theirs;
            ratios[i] = theirs / ours;
        }
    }
    r->seconds = sort_median((size_t)rounds, seconds);
    r->ratio = sort_median((size_t)rounds, ratios); /* sorts */
    r->least = ratios[0];
    r->most = ratios[rounds - 1];
    return true;
}

/* ---- report --------------------------------------------------------------------------------- */

static row *new_row(report *to, const char *name, int threads, size_t points)
{
    row *r = &to->rows[to->count++];
    *r = (row){name, threads, points, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, ""};
    return r;
}

static void set_flops(row *r, double flops_per_point, double rate)
{
    r->flops = flops_per_point * (double)r->points / r->seconds;
    r->fraction = r->flops / (rate * r->threads);
}

static void print_number(const char *format, int width, double x)
{
    isnan(x) ? (void)printf(" %*s", width, "-") : (void)printf(format, x);
}

static void print_header(void)
{
    printf("%-30s %7s %10s %8s %9s %8s %17s %8s %9s\n", "", "threads", "us/point", "Gflop/s",
           "of rate", "/ tape", "least..most", "differs", "first, s");
}

static void print_row(const row *r)
{
    if (r->remark[0]) {
        printf("%-30s %7d %s\n", r->name, r->threads, r->remark);
        fflush(stdout);
        return;
    }
    printf("%-30s %7d %10.3f", r->name, r->threads, 1e6 * r->seconds / (double)r->points);
    print_number(" %8.1f", 8, 1e-9 * r->flops);
    print_number(" %9.3f", 9, r->fraction);
    printf(" %8.3f %8.3f..%-7.3f", r->ratio, r->least, r->most);
    print_number(" %8.0e", 8, r->disagreement);
    print_number(" %9.2f", 9, r->preparation);
    printf("\n");
    fflush(stdout);
}

/* ---- peers ---------------------------------------------------------------------------------- */

static bool peer_timed(void *side, double *seconds)
{
    return peer_step(side, seconds);
}

static void race_peer(report *to, const peer_kind *kind, const char *folder,
                      const entrant *reference, size_t points, double flops_per_point)
{
    peer p;
    row *r = new_row(to, kind->name, to->o->threads, points);
    peer_status status = peer_start(&p, kind, to->o->python, folder, to->o->threads);
    const entrant other = {kind->name, NULL, &p, peer_timed, to->o->threads};
    if (status != PEER_READY) {
        snprintf(r->remark, sizeof r->remark, "%s: %.120s",
                 status == PEER_MISSING ? "not installed" : "failed", p.message);
    } else if (!take_turns(reference, &other, to->o->rounds, r)) {
        snprintf(r->remark, sizeof r->remark, "failed: it ended during a step");
    } else {
        r->disagreement = p.disagreement;
        r->preparation = p.preparation;
        set_flops(r, flops_per_point, to->rate);
    }
    peer_stop(&p);
    print_row(r);
}

static bool race_peers(report *to, const tape_side *t, const entrant *reference,
                       const peer_answer *answer, double flops_per_point)
{
    const char *root = getenv("TMPDIR");
    char folder[256];
    ad_error error;
    snprintf(folder, sizeof folder, "%.200s/cpinn-step-XXXXXX", root && *root ? root : "/tmp");
    if (!mkdtemp(folder)) {
        cli_fail(program, "%s: %s", folder, strerror(errno));
        return false;
    }
    bool ok = peer_write_case(folder, &t->c, answer, &error) == AD_OK;
    if (!ok) {
        cli_fail_error(program, &error);
    }
    for (int i = 0; ok && i < peer_kind_count; i++) {
        if (peer_kinds[i].gauss_newton == (answer->jtj != NULL)) {
            race_peer(to, &peer_kinds[i], folder, reference, t->c.points, flops_per_point);
        }
    }
    peer_remove_case(folder);
    return ok;
}

/* ---- the gradient's step -------------------------------------------------------------------- */

static bool race_tape(report *to, const entrant *reference, const entrant *e, const tape_side *t,
                      double flops)
{
    row *r = new_row(to, e->name, e->threads, t->c.points);
    bool ok = take_turns(reference, e, to->o->rounds, r);
    if (ok) {
        set_flops(r, flops, to->rate);
        print_row(r);
    }
    return ok;
}

/* So they are for compiled and interpreted groups, one thread and more. */
static bool same_bits(const tape_side *a, const tape_side *b)
{
    bool same = a->loss == b->loss &&
                memcmp(a->gradient, b->gradient, a->c.parameters * sizeof *a->gradient) == 0;
    if (!same) {
        cli_fail(
            program,
            "the same step gives different bits, interpreted or with another number of threads");
    }
    return same;
}

/* The tape with compiled groups and interpreted, with all threads and with one; interpreted against
 * compiled with as many threads, all else against all threads. */
static bool race_ours(report *to, tape_side *all, double flops)
{
    bool ok = true;
    const entrant ours = {"tape", tape_step, all, NULL, to->o->threads};
    for (int threads = to->o->threads; ok && threads > 0; threads = threads > 1) {
        tape_side single = {0}, plain = {0},
                  *side = threads > 1 || to->o->threads == 1 ? all : &single;
        const entrant compiled = {"tape", tape_step, side, NULL, threads},
                      interpreted = {"tape, interpreted", tape_step, &plain, NULL, threads};
        ok = (side == all || tape_create(side, to->o->points, threads, true)) &&
             tape_create(&plain, to->o->points, threads, false) &&
             race_tape(to, &ours, &compiled, side, flops) &&
             race_tape(to, &compiled, &interpreted, &plain, flops) && same_bits(all, side) &&
             same_bits(side, &plain);
        tape_free(&plain);
        tape_free(&single);
    }
    return ok;
}

static bool compare_gradients(report *to, const blas *library)
{
    tape_side t;
    if (!tape_create(&t, to->o->points, to->o->threads, true)) {
        return false;
    }
    const ad_program_info info = problem_set_inspect(t.c.problem, 0).program;
    const double flops = (double)info.flops_per_point;
    printf("loss and gradient: network 2-64-64-64-64-7, %d points; products of a step: %.0f "
           "flops/point; %zu instructions, tiles of %d points\n",
           to->o->points, flops, info.instructions, info.tile);
    printf("products of 64 x 64 weights, one thread: %.1f Gflop/s by the tape's own (%s), %.1f by "
           "OpenBLAS (%s)\n\n",
           1e-9 * to->rates[1], ad_kernels_select()->name, 1e-9 * to->rates[0], library->core);
    print_header();
    bool ok = race_ours(to, &t, flops);
    if (ok && to->o->peers) {
        const entrant ours = {"tape", tape_step, &t, NULL, to->o->threads};
        const peer_answer answer = {t.loss, t.gradient, NULL};
        ok = race_peers(to, &t, &ours, &answer, flops);
    }
    tape_free(&t);
    return ok;
}

/* ---- the Gauss-Newton step ------------------------------------------------------------------ */

static bool compare_normal(report *to)
{
    tape_side t;
    if (!normal_create(&t, to->o->normal_points, to->o->threads)) {
        return false;
    }
    const entrant ours = {"tape, J^T J and Cholesky", normal_step, &t, NULL, to->o->threads};
    printf("\nGauss-Newton: network 2-32-32-32-7 (%zu parameters), %d points\n\n", t.c.parameters,
           to->o->normal_points);
    print_header();
    row *r = new_row(to, ours.name, ours.threads, t.c.points);
    bool ok = take_turns(&ours, &ours, to->o->rounds, r);
    double *gradient = malloc(t.c.parameters * sizeof *gradient);
    if (ok && gradient) {
        print_row(r);
        for (size_t i = 0; i < t.c.parameters; i++) {
            gradient[i] = 2 * t.jtr[i];
        }
        const peer_answer answer = {t.loss, gradient, t.jtj};
        ok = race_peers(to, &t, &ours, &answer, NAN);
    }
    free(gradient);
    tape_free(&t);
    return ok && gradient;
}

static int compare_sides(const options *o, const blas *library)
{
    static report table;
    table = (report){.o = o, .rates = {gemm_rate(library->gemm), gemm_rate(tape_gemm)}};
    table.rate = fmax(table.rates[0], table.rates[1]);
    return compare_gradients(&table, library) && (!o->peers || compare_normal(&table))
               ? EXIT_SUCCESS
               : EXIT_FAILURE;
}

/* ---- memory --------------------------------------------------------------------------------- */

static double peak_bytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * (double)usage.ru_maxrss; /* kilobytes on Linux */
}

static bool peak_after(int points, int threads, double *peak, int *numbers)
{
    tape_side t;
    bool ok = tape_create(&t, points, threads, false);
    if (ok) {
        ok = tape_step(&t);
        *numbers = 2 + problem_set_inspect(t.c.problem, 0).fixed_rows;
        tape_free(&t);
    }
    *peak = peak_bytes();
    return ok;
}

/* What a run needs beside its points, and the numbers that depend on points alone, is tiles and
 * sums, whose number is bounded: the process may grow by the points, and by half as much for the
 * bounded rest and the page tables. */
static int measure_memory(const options *o)
{
    enum { FEW = 10000, MANY = 1000000 };
    double before, after;
    int numbers;
    if (!peak_after(FEW, o->threads, &before, &numbers) ||
        !peak_after(MANY, o->threads, &after, &numbers)) {
        return EXIT_FAILURE;
    }
    double points = (double)(MANY - FEW) * numbers * sizeof(double), growth = after - before;
    printf("peak memory: %.1f MB at %d points, %.1f MB at %d: growth %.1f MB, of which points, %d "
           "numbers each, %.1f MB\n",
           1e-6 * before, FEW, 1e-6 * after, MANY, 1e-6 * growth, numbers, 1e-6 * points);
    if (growth > 1.5 * points) {
        cli_fail(program, "memory grows with the points by more than the points");
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}

/* ---- command line --------------------------------------------------------------------------- */

int main(int count, char **arguments)
{
    options o = {
        .points = 16384, .normal_points = 1024, .threads = 2, .rounds = 15, .python = "python3"};
    const char *operand;
    const cli_program about = {program, NULL, help_step, NULL, NULL};
    const cli_option known[] = {{"--points", "N", CLI_INTEGER, &o.points, 8, 1e7},
                                {"--normal-points", "N", CLI_INTEGER, &o.normal_points, 8, 1e6},
                                {"--threads", "N", CLI_INTEGER, &o.threads, 1, THREADS_MAX},
                                {"--rounds", "N", CLI_INTEGER, &o.rounds, 1, ROUNDS_MAX},
                                {"--peers", NULL, CLI_FLAG, &o.peers, 0, 0},
                                {"--python", "PROGRAM", CLI_TEXT, &o.python, 0, 0},
                                {"--memory", NULL, CLI_FLAG, &o.memory, 0, 0}};
    int result = cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &operand);
    if (result != CLI_RUN) {
        return result;
    }
    ad_error error = {AD_OK, ""};
    const blas *library = ad_blas_load(&error);
    if (!library) {
        return cli_fail_error(program, &error);
    }
    signal(SIGPIPE, SIG_IGN); /* a peer that has ended is a row of the table */
    return o.memory ? measure_memory(&o) : compare_sides(&o, library);
}
