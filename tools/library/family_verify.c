/* Answers of a family against fresh members that are solved. */
#include "tools/library/trained_family.h"

#include "autodiff/host.h"
#include "autodiff/memory.h"
#include "nn/rng.h"
#include "physics/numerics/clock.h"
#include "physics/numerics/sort.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Members of one batch; of those that are asked for alone; times that a batch is; of members that
 * both solvers solve. */
enum { BATCH = 512, ALONE = 100, ROUNDS = 5, COMPARED = 30 };

/* The tolerance of the truth over CPINN_TOLERANCE, and the estimate with which it is taken where
 * that is not met; errors as many times the former are compared with the predicted ones, if they
 * are below that share of the length. */
static const double TRUTH = 1e-2, ENOUGH = 0.1, KNOWN = 100, SMALL = 1.0 / 40;

static const double ENOUGH_SECONDS = 2; /* of measuring one time */

typedef struct verifying {
    cpinn_family *family;
    solve_members *truth; /* NULL: the scene is not one that it takes */
    size_t members, count, width, points;
    double length;
    double *parameters;             /* [members][count] */
    double *values, *answered;      /* [BATCH][width] */
    solve_member *solved;           /* [BATCH] */
    cpinn_answer *answers;          /* [BATCH] */
    bool *known;                    /* [BATCH] whether it is solved */
    size_t *which;                  /* [BATCH] members for the other solver */
    double *off[CPINN_WAY_COUNT];   /* [members] m; NaN: not known */
    double *ratio[CPINN_WAY_COUNT]; /* [members] predicted over actual */
    cpinn_family_check *result;
    ad_memory memory;
} verifying;

static const cpinn_polish ways[CPINN_WAY_COUNT] = {
    {.alone = true}, {.steps = 1, .alone = true}, {.steps = 2, .alone = true}, {.steps = 2}};

const char *cpinn_way_word(cpinn_way way)
{
    static const char *const words[] = {"network", "one step", "two steps", "product"};
    return way >= 0 && way < CPINN_WAY_COUNT ? words[way] : "";
}

double cpinn_family_bound(const cpinn_family *family, const cpinn_answer *answer)
{
    return 2 * answer->error + CPINN_TOLERANCE * family->length;
}

/* ---- making -------------------------------------------------------------------------------- */

static void draw(verifying *verifying, uint64_t seed)
{
    nn_rng random = nn_rng_split(seed, "members to verify");
    for (size_t i = 0; i < verifying->members * verifying->count; i++) {
        const scene_parameter *p =
            cpinn_family_parameter(verifying->family, (int)(i % verifying->count));
        verifying->parameters[i] = scene_parameter_at(p, nn_rng_uniform(&random));
    }
}

static bool make_room(verifying *verifying)
{
    AD_TAKE(verifying, parameters, verifying->members * verifying->count);
    AD_TAKE(verifying, values, BATCH * verifying->width + 1);
    AD_TAKE(verifying, answered, BATCH * verifying->width + 1);
    AD_TAKE(verifying, solved, BATCH);
    AD_TAKE(verifying, answers, BATCH);
    AD_TAKE(verifying, known, BATCH);
    AD_TAKE(verifying, which, BATCH);
    for (int k = 0; k < CPINN_WAY_COUNT; k++) {
        AD_TAKE(verifying, off[k], verifying->members);
        AD_TAKE(verifying, ratio[k], verifying->members);
    }
    return !verifying->memory.is_short;
}

static void verifying_free(verifying *verifying)
{
    solve_members_free(verifying->truth);
    ad_memory_free(&verifying->memory);
}

static ad_status create_truth(verifying *verifying, ad_error *error)
{
    const scene *open = &verifying->family->open;
    const ad_pool *pool = verifying->family->pool;
    const solve_members_settings settings = {.tolerance = TRUTH * CPINN_TOLERANCE,
                                             .threads = ad_pool_threads(pool),
                                             .points = verifying->points,
                                             .s = verifying->family->s,
                                             .ranks = ad_pool_ranks(pool)};
    return verifying->family->solver
               ? solve_members_create(open, &settings, &verifying->truth, error)
               : AD_OK;
}

/* ---- members that are solved --------------------------------------------------------------- */

/* Members verifying->which [count] of those from `given` on by the other solver, also into
 * verifying->answers. */
static ad_status solve_others(verifying *verifying, size_t count, const double *given,
                              double *values, ad_error *error)
{
    for (size_t k = 0; k < count; k++) {
        verifying->answers[verifying->which[k]] = (cpinn_answer){.reason = CPINN_REASON_NONE};
    }
    return cpinn_family_solve(verifying->family, count, verifying->which, given, values, NULL,
                              verifying->answers, error);
}

/* The first members also by the other solver. */
static ad_status compare_solvers(verifying *verifying, size_t now, ad_error *error)
{
    ad_status status = AD_OK;
    for (size_t i = 0; i < now && verifying->result->compared < COMPARED && status == AD_OK;) {
        size_t count = 0;
        for (; i < now && count < COMPARED - verifying->result->compared; i++) {
            verifying->which[count] = i;
            count += verifying->solved[i].solved;
        }
        status = solve_others(verifying, count, verifying->parameters, verifying->answered, error);
        for (size_t k = 0; k < count && status == AD_OK; k++) {
            const size_t at = verifying->which[k] * verifying->width;
            if (verifying->answers[verifying->which[k]].trusted) {
                verifying->result->apart =
                    fmax(verifying->result->apart,
                         cpinn_family_distance(verifying->family, verifying->values + at,
                                               verifying->answered + at));
                verifying->result->compared++;
            }
        }
    }
    return status;
}

static double estimate_of(const verifying *verifying, size_t i)
{
    return verifying->truth ? verifying->solved[i].estimate : INFINITY;
}

static ad_status solve_batch(verifying *verifying, size_t first, size_t now, ad_error *error)
{
    cpinn_family_check *result = verifying->result;
    const double *given = verifying->parameters + first * verifying->count;
    size_t others = 0;
    ad_status status = verifying->truth
                           ? solve_members_solve(verifying->truth, now, given, verifying->values,
                                                 verifying->solved, error)
                           : AD_OK;
    for (size_t i = 0; i < now && status == AD_OK; i++) {
        verifying->known[i] = estimate_of(verifying, i) <= ENOUGH * CPINN_TOLERANCE;
        verifying->which[others] = i;
        others += !verifying->known[i];
    }
    status =
        status == AD_OK ? solve_others(verifying, others, given, verifying->values, error) : status;
    for (size_t k = 0; k < others && status == AD_OK; k++) {
        verifying->known[verifying->which[k]] = verifying->answers[verifying->which[k]].trusted;
    }
    for (size_t i = 0; i < now && status == AD_OK; i++) {
        const bool by_members = estimate_of(verifying, i) <= CPINN_TOLERANCE;
        result->by_members += by_members;
        result->by_solver += !by_members && verifying->known[i];
        result->unsolved += !by_members && !verifying->known[i];
    }
    return status == AD_OK && verifying->truth && first == 0
               ? compare_solvers(verifying, now, error)
               : status;
}

/* ---- answers ------------------------------------------------------------------------------- */

static void count_answer(verifying *verifying, cpinn_way way, size_t member, const double *values,
                         const double *truth, bool known, const cpinn_answer *answer)
{
    cpinn_family_row *row = &verifying->result->rows[way];
    const double off = known ? cpinn_family_distance(verifying->family, values, truth) : NAN;
    const double least = KNOWN * TRUTH * CPINN_TOLERANCE * verifying->length;
    row->not_trusted += !answer->trusted;
    row->solved += answer->source == CPINN_FROM_MEMBERS || answer->source == CPINN_FROM_SOLVER;
    row->reasons[answer->reason] += !answer->trusted;
    row->wrong +=
        answer->trusted && known && !(off <= cpinn_family_bound(verifying->family, answer));
    row->unknown += answer->trusted && !known;
    /* a member that has an equilibrium but no answer is as wrong as can be */
    verifying->off[way][member] = off;
    verifying->ratio[way][member] =
        off >= least && off <= SMALL * verifying->length ? answer->error / off : NAN;
}

static ad_status answer_batch(verifying *verifying, size_t first, size_t now, cpinn_way way,
                              ad_error *error)
{
    const size_t most = verifying->family->code ? CPINN_FEW : now;
    const double *given = verifying->parameters + first * verifying->count;
    ad_status status = AD_OK;
    for (size_t i = 0; i < now && status == AD_OK; i += most) {
        status = cpinn_family_shapes(verifying->family, &ways[way], now - i < most ? now - i : most,
                                     given + i * verifying->count,
                                     verifying->answered + i * verifying->width, NULL,
                                     verifying->answers + i, error);
    }
    for (size_t i = 0; i < now && status == AD_OK; i++) {
        count_answer(verifying, way, first + i, verifying->answered + i * verifying->width,
                     verifying->values + i * verifying->width, verifying->known[i],
                     &verifying->answers[i]);
    }
    return status;
}

/* ---- times --------------------------------------------------------------------------------- */

/* What is timed: the ways, the network without its errors, and the solver. */
enum { BARE = CPINN_WAY_COUNT, SOLVER, TIMED };

static ad_status work(verifying *verifying, int what, size_t first, size_t members, ad_error *error)
{
    const double *given = verifying->parameters + first * verifying->count;
    solve_members *solver = verifying->family->solver;
    return what < CPINN_WAY_COUNT
               ? cpinn_family_shapes(verifying->family, &ways[what], members, given,
                                     verifying->answered, NULL, verifying->answers, error)
           : what == BARE ? cpinn_family_shapes(verifying->family, &ways[0], members, given,
                                                verifying->answered, NULL, NULL, error)
           : solver       ? solve_members_solve(solver, members, given, verifying->answered,
                                                verifying->solved, error)
                          : AD_OK;
}

/* Median time of a shape, where the first members are asked for so many at a time. Members without
 * an equilibrium keep both solvers busy: of those one round may have to do. */
static ad_status measure(verifying *verifying, int what, size_t members, double *result,
                         ad_error *error)
{
    double seconds[ALONE], spent = 0;
    const size_t most = members > 1                  ? ROUNDS
                        : verifying->members < ALONE ? verifying->members
                                                     : ALONE;
    size_t rounds = 0;
    ad_status status = AD_OK;
    while (rounds < most && spent < ENOUGH_SECONDS && status == AD_OK) {
        const double start = clock_seconds(CLOCK_MONOTONIC);
        status = work(verifying, what, members > 1 ? 0 : rounds, members, error);
        double passed =
            clock_seconds(CLOCK_MONOTONIC) - start; /* for all by the clock of the first rank */
        ad_ranks_first(ad_pool_ranks(verifying->family->pool), 1, &passed);
        spent += passed;
        seconds[rounds++] = passed / (double)members;
    }
    *result = what == SOLVER && !verifying->family->solver ? NAN : sort_median(rounds, seconds);
    return status;
}

static ad_status measure_all(verifying *verifying, ad_error *error)
{
    cpinn_family_check *to = verifying->result;
    const size_t many = verifying->members < BATCH ? verifying->members : BATCH;
    ad_status status = AD_OK;
    for (int k = 0; k < TIMED && status == AD_OK; k++) {
        double *alone = k < BARE    ? &to->rows[k].alone
                        : k == BARE ? &to->bare_alone
                                    : &to->solver_alone;
        double *batch = k < BARE    ? &to->rows[k].batch
                        : k == BARE ? &to->bare_batch
                                    : &to->solver_batch;
        status = measure(verifying, k, 1, alone, error);
        status = status == AD_OK ? measure(verifying, k, many, batch, error) : status;
    }
    return status;
}

/* ---- the result ---------------------------------------------------------------------------- */

/* Moves what is a number to the front, ascending; returns how many they are. */
static size_t sort_numbers(size_t count, double *x)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        if (!isnan(x[i])) {
            x[kept++] = x[i];
        }
    }
    sort_ascending(kept, x);
    return kept;
}

/* The smallest number that a share of them is not above. */
static double quantile(size_t count, const double *sorted, double share)
{
    const size_t at = (size_t)ceil(share * (double)count);
    return count == 0 ? NAN : sorted[at > 0 ? at - 1 : 0];
}

static void summarise(verifying *verifying)
{
    for (int k = 0; k < CPINN_WAY_COUNT; k++) {
        cpinn_family_row *row = &verifying->result->rows[k];
        const size_t known = sort_numbers(verifying->members, verifying->off[k]);
        const size_t compared = sort_numbers(verifying->members, verifying->ratio[k]);
        size_t within = 0;
        row->median = quantile(known, verifying->off[k], 0.5);
        row->p95 = quantile(known, verifying->off[k], 0.95);
        row->p999 = quantile(known, verifying->off[k], 0.999);
        row->worst = quantile(known, verifying->off[k], 1);
        row->ratio[0] = quantile(compared, verifying->ratio[k], 0.01);
        row->ratio[1] = quantile(compared, verifying->ratio[k], 0.5);
        row->ratio[2] = quantile(compared, verifying->ratio[k], 0.99);
        for (size_t i = 0; i < compared; i++) {
            within += fabs(verifying->ratio[k][i] - 1) <= 0.05;
        }
        row->within = compared > 0 ? (double)within / (double)compared : NAN;
    }
}

static ad_status verify(verifying *verifying, uint64_t seed, ad_error *error)
{
    if (!make_room(verifying)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", verifying->members);
    }
    draw(verifying, seed);
    ad_status status = create_truth(verifying, error);
    for (size_t first = 0; first < verifying->members && status == AD_OK; first += BATCH) {
        const size_t left = verifying->members - first, now = left < BATCH ? left : BATCH;
        status = solve_batch(verifying, first, now, error);
        for (int k = 0; k < CPINN_WAY_COUNT && status == AD_OK; k++) {
            status = answer_batch(verifying, first, now, (cpinn_way)k, error);
        }
    }
    status = status == AD_OK ? measure_all(verifying, error) : status;
    if (status == AD_OK) {
        summarise(verifying);
    }
    return status;
}

ad_status cpinn_family_verify(cpinn_family *family, size_t members, uint64_t seed,
                              cpinn_family_check *result, ad_error *error)
{
    AD_LEAVE_HOST;
    *result = (cpinn_family_check){.members = members};
    if (members == 0 || family->points == 0) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%zu members at %zu points; allowed: from 1 on",
                       members, family->points);
    }
    verifying v = {.family = family,
                   .members = members,
                   .count = (size_t)cpinn_family_parameters(family),
                   .points = family->points,
                   .width = family->points * (size_t)family->columns,
                   .length = family->length,
                   .result = result};
    ad_status status = verify(&v, seed, error);
    verifying_free(&v);
    return status;
}
