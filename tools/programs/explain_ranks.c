/* The page of --explain: what a step takes on any number of ranks. The time of a point and the
 * rates of the linear algebra are measured here, in some tenths of a second; what ranks take,
 * send and keep is what the programs say (autodiff/ranks.h). */
#include "autodiff/dense.h"
#include "tools/programs/explain_parts.h"
#include "tools/train/clock.h"
#include "tools/train/optimizer.h"
#include "tools/train/session.h"
#include "tools/train/trainer.h"

#include <math.h>
#include <stdlib.h>

enum { RANKS_MOST = 1024, SETS = MODEL_SETS_MAX, ORDER = 400, STEPS = 12 };

/* s of processors: that of the other threads is only known to some milliseconds. */
static const double LONG = 0.06;
static const double COPYING = 10e9; /* bytes/s of a thread that goes over large matrices */
static const double PASSES = 5;     /* over J^T J in a step: cleared, summed, shifted, solved */

/* Of one thread. */
typedef struct rates {
    double point[SETS]; /* s for the loss and its gradient at a point of a set */
    double products;    /* flops/s of matrix products */
} rates;

/* ---- measuring ------------------------------------------------------------------------------- */

/* s of processors for one run, of as many as take long enough. */
static ad_status time_runs(ad_status (*run)(void *context, ad_error *error), void *context,
                           double *seconds, ad_error *error)
{
    const double began = train_processor_seconds();
    ad_status status = AD_OK;
    int runs = 0;
    do {
        status = run(context, error);
        *seconds = (train_processor_seconds() - began) / ++runs;
    } while (status == AD_OK && *seconds * runs < LONG);
    return status;
}

typedef struct rehearsal {
    problem *p;
    int set;
    size_t points;
    const double *x;
} rehearsal;

static ad_status rehearse(void *context, ad_error *error)
{
    const rehearsal *r = context;
    return problem_rehearse(r->p, r->set, r->points, r->x, error);
}

/* s for a point: over all of them, or as many as take long enough. */
static ad_status time_points(problem *p, int set, const double *x, double *seconds, ad_error *error)
{
    const size_t all = problem_set_inspect(p, set).points;
    rehearsal r = {p, set, all < 64 ? all : 64, x};
    double took = 0;
    ad_status status = rehearse(&r, error); /* computes what is kept, too */
    while (status == AD_OK && r.points < all && took < LONG / 4) {
        const double began = train_processor_seconds();
        r.points = 2 * r.points < all ? 2 * r.points : all;
        status = rehearse(&r, error);
        took = train_processor_seconds() - began;
    }
    status = status == AD_OK ? time_runs(rehearse, &r, seconds, error) : status;
    *seconds = all > 0 ? *seconds / (double)r.points : 0;
    return status;
}

typedef struct factoring {
    ad_pool *pool;
    double *matrix;
    ad_dense_factor *factor;
} factoring;

static ad_status factor(void *context, ad_error *error)
{
    const factoring *f = context;
    return ad_dense_cholesky(f->pool, f->matrix, NULL, f->factor) == 0
               ? AD_OK
               : ad_fail(error, AD_NOT_FINITE, "a unit matrix has no factor");
}

/* By a Cholesky factor of fixed order, which has the kernels of J^T J. */
static ad_status time_products(double *rate, ad_error *error)
{
    factoring f = {ad_pool_create(1), calloc((size_t)ORDER * ORDER, sizeof *f.matrix),
                   ad_dense_factor_create(ORDER)};
    double seconds = 1;
    ad_status status = f.pool && f.matrix && f.factor
                           ? ad_dense_load(error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (size_t i = 0; status == AD_OK && i < ORDER; i++) {
        f.matrix[i * (ORDER + 1)] = 1;
    }
    status = status == AD_OK ? time_runs(factor, &f, &seconds, error) : status;
    *rate = pow(ORDER, 3) / 3 / seconds;
    ad_dense_factor_free(f.factor);
    ad_pool_free(f.pool);
    free(f.matrix);
    return status;
}

/* Something to minimise that costs next to nothing. */
static int bowl(void *context, const double *x, double *value, double *gradient)
{
    const size_t count = *(const size_t *)context;
    *value = 0;
    for (size_t i = 0; i < count; i++) {
        const double curvature = 1 + (double)(i % 7);
        *value += curvature * x[i] * x[i] / 2;
        if (gradient) {
            gradient[i] = curvature * x[i];
        }
    }
    return OPTIM_OBJECTIVE_OK;
}

/* s of a step of a stage's optimiser without its evaluations. */
static ad_status time_step(const experiment *e, problem *p, int stage, double *seconds,
                           ad_error *error)
{
    size_t count = e->count;
    optimizer *o;
    const optimizer_objective objective = {bowl, NULL, &count};
    ad_status status =
        optimizer_create(e->settings, stage, p, e->pool, experiment_parameters(e), &o, error);
    if (status != AD_OK) {
        return status;
    }
    const double began = train_processor_seconds();
    int steps = 0;
    while (steps < STEPS && train_processor_seconds() - began < LONG &&
           optimizer_step(o, &objective) == OPTIM_RUNNING) {
        steps++;
    }
    *seconds = steps ? (train_processor_seconds() - began) / steps : 0;
    optimizer_free(o);
    return AD_OK;
}

static ad_status measure(const experiment *e, problem *p, rates *r, ad_error *error)
{
    char kept[4000];
    problem_fusing state;
    if (trainer_fuse_folder(kept, false)) {
        problem_fuse(p, kept, PROBLEM_FUSE_KEPT, &state, NULL); /* as a run has them */
    }
    ad_status status = time_products(&r->products, error);
    for (int i = 0; status == AD_OK && i < problem_sets(p); i++) {
        status = time_points(p, i, experiment_parameters(e), &r->point[i], error);
    }
    return status;
}

/* ---- what a step is made of ------------------------------------------------------------------ */

/* A step of a stage: an evaluation of the loss with its gradient; of gauss_newton J^T J and one
 * factor before it. */
typedef struct step {
    const experiment *e;
    problem *p;
    rates r;
    bool normal;
    double repeated, bytes; /* s; of its matrices */
} step;

/* The factor of J^T J is shared as well. */
static void add_factor(const step *s, int threads, int ranks, scaling_load *to)
{
    ad_dense_share most = {.flops = 0};
    for (int rank = 0; rank < ranks; rank++) {
        const ad_dense_share of = ad_dense_cholesky_share(s->e->count, ranks, rank);
        most.flops = fmax(most.flops, of.flops);
        most.bytes = of.bytes > most.bytes ? of.bytes : most.bytes;
        most.exchanges = of.exchanges;
    }
    to->work += most.flops / s->r.products / threads;
    to->exchanges += (double)most.exchanges;
    to->bytes += (double)most.bytes;
}

/* s of a thread for a point of a set; normal: of the normal equations. */
static double seconds_of_point(const step *s, int set, bool normal)
{
    const problem_set_info info = problem_set_inspect(s->p, set);
    const double loss = (double)info.program.flops_per_point,
                 rows = (double)info.rows.flops_per_point;
    if (!normal) {
        return s->r.point[set];
    }
    return s->r.point[set] * (loss > 0 ? rows / loss : 1) +
           (double)info.normal_flops / s->r.products;
}

/* Of the busiest of so many ranks; *points: that it takes, *bytes: that it keeps. */
static scaling_load load_of(const step *s, int threads, int ranks, size_t *points, double *bytes)
{
    scaling_load all = {.exchanges = SESSION_EXCHANGES, .repeated = s->repeated};
    *points = 0;
    *bytes = 0;
    for (int normal = 0; normal <= s->normal; normal++) {
        for (int i = 0; i < problem_sets(s->p); i++) {
            size_t most = 0, kept = 0;
            double busiest = 0, sent = 0, exchanges = 0;
            for (int rank = 0; rank < ranks; rank++) {
                const ad_share of = problem_share(s->p, i, normal, ranks, rank);
                const double items = (double)of.items,
                             turns = items > 0 ? ceil(items / threads) / items : 0;
                busiest = fmax(busiest, turns * (double)of.points);
                sent = fmax(sent, (double)(of.sum_bytes + of.value_bytes));
                exchanges = fmax(exchanges, (double)of.exchanges);
                most = of.points > most ? of.points : most;
                kept = of.bytes > kept ? of.bytes : kept;
            }
            all.work += busiest * seconds_of_point(s, i, normal);
            all.exchanges += exchanges;
            all.bytes += sent;
            *points += normal == s->normal ? most : 0;
            *bytes += normal ? (double)kept : 0;
        }
    }
    if (s->normal) {
        add_factor(s, threads, ranks, &all);
    }
    *bytes += s->bytes;
    return all;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void print_seconds(FILE *file, int width, double seconds)
{
    char text[32];
    const double milli = 1e3 * seconds;
    snprintf(text, sizeof text, milli < 10 ? "%.3f" : milli < 1000 ? "%.1f" : "%.0f", milli);
    fprintf(file, "%*s", width, text);
}

/* alone: s of a step of one rank; 0: this is it. */
static scaling_time print_row(FILE *file, const step *s, const scaling_machine *machine, int ranks,
                              double alone)
{
    size_t points;
    double bytes;
    char memory[32];
    const scaling_load load = load_of(s, machine->threads, ranks, &points, &bytes);
    const scaling_time t = scaling_step(machine, ranks, &load);
    explain_bytes_text(bytes + (double)problem_bytes(s->p, ranks, 0), memory);
    fprintf(file, "  %6d%9zu", ranks, points);
    print_seconds(file, 11, t.work);
    print_seconds(file, 10, t.sums);
    print_seconds(file, 10, t.repeated);
    print_seconds(file, 11, t.step);
    alone = alone > 0 ? alone : t.step;
    fprintf(file, "%10.2f%10.0f %%%11s\n", alone / t.step, 100 * alone / t.step / ranks, memory);
    return t;
}

static void print_table(FILE *file, const step *s, const char *name, const scaling_machine *machine,
                        int now)
{
    scaling_time alone = {.step = 0}, best = {.step = INFINITY};
    int fastest = 1;
    fprintf(file, "  %s: a step with %s, in ms\n", name,
            s->normal ? "J^T J, one factor and one evaluation" : "one evaluation");
    fprintf(file, "  %6s%9s%11s%10s%10s%11s%10s%12s%11s\n", "ranks", "points", "work", "sums",
            "repeated", "step", "speed-up", "efficiency", "memory");
    for (int ranks = 1; ranks <= RANKS_MOST; ranks *= 2) {
        const scaling_time t = print_row(file, s, machine, ranks, alone.step);
        alone = ranks == 1 ? t : alone;
        if (t.step < best.step) {
            best = t;
            fastest = ranks;
        }
        if (ranks < now && now < 2 * ranks) {
            print_row(file, s, machine, now, alone.step);
        }
    }
    if (fastest < RANKS_MOST) {
        fprintf(file, "  more ranks than %d gain nothing\n", fastest);
    }
}

static void print_assumptions(FILE *file, const scaling_machine *machine)
{
    const scaling_network *const networks[] = {&scaling_memory, &scaling_infiniband};
    explain_heading(file, "Ranks: points of the busiest one, and the time of a step by a model");
    fprintf(file,
            "  work, at rates measured here: points, J^T J and its factor, shared;\n"
            "  repeated: by every rank;\n"
            "  ranks of %d thread%s, %d on a machine of %d processor%s\n",
            machine->threads, machine->threads == 1 ? "" : "s", machine->ranks, machine->processors,
            machine->processors == 1 ? "" : "s");
    for (int i = 0; i < 2; i++) {
        fprintf(file, "  sums %s (%s): %.2g us an exchange, %.2g us a message, %.3g GB/s a %s\n",
                i ? "beyond it" : "within it", networks[i]->name, 1e6 * networks[i]->latency,
                1e6 * networks[i]->message, 1e-9 * networks[i]->bandwidth, i ? "machine" : "rank");
    }
}

/* s.repeated and s.bytes of a stage of Gauss-Newton with normal equations; false: of another form.
 */
static bool plan_normal(step *s, int stage, ad_error *error)
{
    linear_model_info plan;
    const double n = (double)s->e->count;
    if (linear_model_plan(s->p, &s->e->settings->stages[stage], stage, &plan, error) != AD_OK ||
        plan.form != TRAIN_NORMAL_EQUATIONS) {
        return false;
    }
    s->normal = true;
    s->bytes = plan.bytes;
    s->repeated = PASSES * n * n * sizeof(double) / COPYING;
    return true;
}

/* One table for the first stage by an evaluation a step, and one for the first by J^T J. */
static ad_status print_stages(FILE *file, step *s, const scaling_machine *machine, int now,
                              ad_error *error)
{
    const train_settings *settings = s->e->settings;
    bool told[2] = {false, false};
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < settings->stage_count; i++) {
        const bool least_squares = settings->stages[i].optimizer == OPTIM_GAUSS_NEWTON;
        s->normal = false;
        s->bytes = 0;
        if (told[least_squares]) {
            continue;
        }
        told[least_squares] = true;
        if (least_squares && !plan_normal(s, i, error)) {
            fprintf(file, "  gauss_newton: no model but of normal equations\n");
            continue;
        }
        if (!least_squares) {
            status = time_step(s->e, s->p, i, &s->repeated, error);
        }
        if (status == AD_OK) {
            print_table(file, s, optim_method_name(settings->stages[i].optimizer), machine, now);
        }
    }
    return status;
}

void explain_ranks(FILE *file, const experiment *e, problem *p, const scaling_machine *machine)
{
    const ad_ranks *ranks = ad_pool_ranks(e->pool);
    step s = {.e = e, .p = p};
    ad_error error = {AD_OK, ""};
    if (e->modes) {
        fprintf(file, "  %-15s each does all of it: motions in the strain form are not shared\n",
                "ranks");
        return;
    }
    ad_pool_share(e->pool, NULL, NULL); /* rates are those of a process by itself */
    ad_status status = measure(e, p, &s.r, &error);
    if (status == AD_OK) {
        print_assumptions(file, machine);
        status = print_stages(file, &s, machine, ranks ? ranks->count : 1, &error);
    }
    if (status != AD_OK) {
        fprintf(file, "  %-15s no model of their time: %s\n", "ranks", error.message);
    }
    if (e->targets) {
        fprintf(file, "  members are solved by whichever rank has a thread that is free\n");
    }
    ad_error shared;
    if (ad_pool_share(e->pool, ranks, &shared) != AD_OK) {
        fprintf(file, "  %-15s %s\n", "ranks", shared.message);
    }
}
