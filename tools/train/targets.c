#include "tools/train/targets.h"

#include "autodiff/memory.h"
#include "physics/numerics/clock.h"
#include "physics/numerics/distance.h"
#include "physics/numerics/sort.h"
#include "tools/train/members_given.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Members at a time, and of how many modes are made. */
enum { BATCH = 1024, FIT = 4096 };

/* Of the position over the length: a tenth of what one step of Newton's method leaves of a good
 * network. */
static const double TOLERANCE = 1e-6;

/* Where fewer of the members drawn have a solution, the ranges are not what was meant. */
static const double LEAST_SOLVED = 0.1;

typedef struct members {
    size_t count;
    double *x;         /* [parameters][count], dimensionless */
    double *curvature; /* [count][rows] as solve_members has it */
    double *values;    /* [count][TARGETS_POINTS][SOLVE_MEMBERS_COLUMNS]; NULL: not wanted */
    ad_memory memory;
} members;

struct targets {
    const scene *open;
    targets_settings settings;
    targets_kind kind;
    ad_pool *pool;
    solve_members *solver;
    family *family;
    size_t parameters, nodes, rows; /* rows: 3 nodes */
    double length;
    members solved, fresh;
    targets_account account;
    double low[SCENE_PARAMETERS_MAX], high[SCENE_PARAMETERS_MAX]; /* of those without a solution,
                                                                   * in parts of the ranges */
    family_network *network; /* made by the first measurement */

    /* room for BATCH members */
    double *x, *si, *curvature, *refined, *values;
    solve_member *results;
    solve_answer *answers;
    ad_memory memory;
};

/* ---- making -------------------------------------------------------------------------------- */

static bool make_room(targets *t)
{
    AD_TAKE(t, x, t->parameters * BATCH);
    AD_TAKE(t, si, t->parameters * BATCH);
    AD_TAKE(t, curvature, t->rows * BATCH);
    AD_TAKE(t, refined, t->rows * BATCH);
    AD_TAKE(t, values, (size_t)TARGETS_POINTS * SOLVE_MEMBERS_COLUMNS * BATCH);
    AD_TAKE(t, results, BATCH);
    AD_TAKE(t, answers, BATCH);
    return !t->memory.is_short;
}

static ad_status make_family(targets *t, ad_error *error)
{
    double *places = malloc(t->nodes * sizeof *places);
    if (!places) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    }
    solve_members_places(t->solver, places);
    ad_status status =
        family_create(t->open, &t->settings.inputs, t->nodes, places, &t->family, error);
    free(places);
    return status;
}

ad_status targets_create(const scene *family, const targets_settings *settings, ad_pool *pool,
                         targets **result, ad_error *error)
{
    double s[TARGETS_POINTS];
    *result = NULL;
    targets *t = calloc(1, sizeof *t);
    if (!t) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    }
    t->open = family;
    t->settings = *settings;
    t->pool = pool;
    t->parameters = (size_t)family->parameter_count;
    for (size_t i = 0; i < t->parameters; i++) {
        t->low[i] = 1;
    }
    t->length = scene_length(family);
    for (int i = 0; i < TARGETS_POINTS; i++) {
        s[i] = t->length * i / (TARGETS_POINTS - 1);
    }
    const solve_members_settings solver = {.tolerance = TOLERANCE,
                                           .threads = ad_pool_threads(pool),
                                           .points = TARGETS_POINTS,
                                           .s = s,
                                           .ranks = settings->ranks};
    ad_status status = solve_members_create(family, &solver, &t->solver, error);
    if (status == AD_OK) {
        t->nodes = solve_members_nodes(t->solver);
        t->rows = solve_members_numbers(t->solver);
        status = make_room(t) ? make_family(t, error)
                              : ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    }
    if (status != AD_OK) {
        targets_free(t);
        return status;
    }
    *result = t;
    return AD_OK;
}

void targets_free(targets *t)
{
    if (t) {
        family_network_free(t->network);
        ad_memory_free(&t->solved.memory);
        ad_memory_free(&t->fresh.memory);
        family_free(t->family);
        solve_members_free(t->solver);
        ad_memory_free(&t->memory);
        free(t);
    }
}

family *targets_family(targets *t)
{
    return t->family;
}

solve_members *targets_solver(targets *t)
{
    return t->solver;
}

targets_account targets_drawn(const targets *t)
{
    return t->account;
}

void targets_unsolved_text(const targets *t, char text[TARGETS_TEXT])
{
    static const double most = 0.9;
    int used = 0;
    const char *before = " (";
    text[0] = 0;
    for (int end = SOLVE_MEMBER_SOLVED + 1; end < SOLVE_MEMBER_ENDS; end++) {
        if (t->account.ends[end] > 0) {
            used += snprintf(text + used, (size_t)(TARGETS_TEXT - used), "%s%zu: %s", before,
                             t->account.ends[end], solve_member_text(end));
            before = "; ";
        }
    }
    if (used == 0) {
        return;
    }
    used += snprintf(text + used, (size_t)(TARGETS_TEXT - used), ")");
    before = ", all with";
    for (size_t i = 0; i < t->parameters && used < TARGETS_TEXT - 200; i++) {
        const scene_parameter *p = &t->open->parameters[i];
        if (t->high[i] - t->low[i] < most) {
            used += snprintf(text + used, (size_t)(TARGETS_TEXT - used), "%s %.100s %.3g to %.3g",
                             before, p->name, scene_parameter_at(p, t->low[i]),
                             scene_parameter_at(p, t->high[i]));
            before = ",";
        }
    }
}

void targets_use(targets *t, targets_kind kind)
{
    t->kind = kind;
}

/* ---- drawing ------------------------------------------------------------------------------- */

/* `count` members, at most BATCH, at places x [parameters][count]; those that have a solution are
 * appended. */
static ad_status solve_batch(targets *t, size_t count, const double *x, members *to, size_t *done,
                             ad_error *error)
{
    const size_t width = (size_t)TARGETS_POINTS * SOLVE_MEMBERS_COLUMNS;
    family_parameters(t->family, count, x, t->si);
    ad_status status = solve_members_curvature(
        t->solver, count, t->si, to->values ? t->values : NULL, t->curvature, t->results, error);
    for (size_t k = 0; k < count && status == AD_OK && *done < to->count; k++) {
        t->account.drawn++;
        t->account.ends[t->results[k].end]++;
        if (!t->results[k].solved) {
            for (size_t i = 0; i < t->parameters; i++) {
                t->low[i] = fmin(t->low[i], x[i * count + k]);
                t->high[i] = fmax(t->high[i], x[i * count + k]);
            }
            continue;
        }
        for (size_t i = 0; i < t->parameters; i++) {
            to->x[i * to->count + *done] = x[i * count + k];
        }
        memcpy(to->curvature + *done * t->rows, t->curvature + k * t->rows,
               t->rows * sizeof *t->curvature);
        if (to->values) {
            memcpy(to->values + *done * width, t->values + k * width, width * sizeof *t->values);
        }
        ++*done;
    }
    return status;
}

/* So many members at places x [parameters][count], a batch at a time; drawn: how many have been
 * drawn so far, NULL: these are given. */
static ad_status solve_places(targets *t, size_t count, const double *x, members *to, size_t *done,
                              size_t *drawn, ad_error *error)
{
    ad_status status = AD_OK;
    for (size_t first = 0; first < count && status == AD_OK; first += BATCH) {
        const size_t size = count - first < BATCH ? count - first : BATCH;
        for (size_t i = 0; i < t->parameters; i++) {
            memcpy(t->x + i * size, x + i * count + first, size * sizeof *x);
        }
        status = solve_batch(t, size, t->x, to, done, error);
        if (drawn) {
            *drawn += size;
        }
        if (status == AD_OK && drawn && *drawn >= BATCH / 4 &&
            (double)*done < LEAST_SOLVED * (double)*drawn) {
            char why[TARGETS_TEXT];
            targets_unsolved_text(t, why);
            status = ad_fail(error, AD_BAD_INPUT,
                             "parameters: of %zu members drawn from these ranges only %zu are "
                             "solved, others not%s; allowed: a tenth at least%s",
                             *drawn, *done, why,
                             2 * t->account.ends[SOLVE_MEMBER_UNSTABLE] <
                                     t->account.drawn - t->account.ends[SOLVE_MEMBER_SOLVED]
                                 ? ", or formulation: mixed"
                                 : "");
        }
    }
    return status;
}

/* Those without a solution are made up for by others. */
static ad_status draw_members(targets *t, sampling_kind sampler, nn_rng *rng, members *to,
                              ad_error *error)
{
    size_t done = 0, drawn = 0;
    double *x = malloc(t->parameters * to->count * sizeof *x);
    ad_status status = x ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    while (done < to->count && status == AD_OK) {
        const size_t count = to->count - done;
        status = sampling_fill(sampler, rng, (int)t->parameters, count, x, error);
        status = status == AD_OK ? solve_places(t, count, x, to, &done, &drawn, error) : status;
    }
    free(x);
    return status;
}

static bool make_members(const targets *t, size_t count, bool with_values, members *m)
{
    const size_t width = (size_t)TARGETS_POINTS * SOLVE_MEMBERS_COLUMNS;
    *m = (members){.count = count};
    AD_TAKE(m, x, t->parameters * count);
    AD_TAKE(m, curvature, t->rows * count);
    if (with_values) {
        AD_TAKE(m, values, width * count);
    }
    return !m->memory.is_short;
}

/* The pool of a file; what has no solution is left out. */
static ad_status read_members(targets *t, ad_error *error)
{
    table_file *table = NULL;
    double *si = NULL, *x = NULL;
    size_t done = 0, count = 0;
    ad_status status = train_members_read(t->open, t->settings.file, &si, &table, error);
    if (status == AD_OK) {
        count = table_rows(table);
        status = train_members_check(t->open, t->settings.file, table, si, "", error);
        x = malloc(t->parameters * count * sizeof *x);
    }
    if (status == AD_OK && !(x && make_members(t, count, false, &t->solved))) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", count);
    }
    for (size_t i = 0; i < t->parameters * count && status == AD_OK; i++) {
        x[i % t->parameters * count + i / t->parameters] =
            scene_parameter_fraction(&t->open->parameters[i % t->parameters], si[i]);
    }
    status = status == AD_OK ? solve_places(t, count, x, &t->solved, &done, NULL, error) : status;
    for (size_t i = 1; i < t->parameters && status == AD_OK; i++) { /* closes up */
        memmove(t->solved.x + i * done, t->solved.x + i * count, done * sizeof *x);
    }
    t->solved.count = done;
    if (status == AD_OK && done <= (size_t)groups_count(family_groups(t->family))) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s: %zu of %zu members have a solution; allowed: more than the %d inputs "
                         "of the network",
                         t->settings.file, done, count, groups_count(family_groups(t->family)));
    }
    table_free(table);
    free(si);
    free(x);
    return status;
}

static ad_status make_pool(targets *t, uint64_t seed, ad_error *error)
{
    nn_rng rng = nn_rng_split(seed, "members/solved");
    if (t->settings.file) {
        return read_members(t, error);
    }
    return make_members(t, (size_t)t->settings.solved, false, &t->solved)
               ? draw_members(t, t->settings.sampler, &rng, &t->solved, error)
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %d solved members",
                         t->settings.solved);
}

/* The first of the pool. */
static ad_status fit(targets *t, ad_error *error)
{
    const size_t all = t->solved.count, count = all < FIT ? all : FIT;
    double *x = malloc(t->parameters * count * sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the modes of a family");
    }
    for (size_t i = 0; i < t->parameters; i++) {
        memcpy(x + i * count, t->solved.x + i * all, count * sizeof *x);
    }
    ad_status status = family_fit(t->family, t->pool, count, x, t->solved.curvature, error);
    free(x);
    return status;
}

ad_status targets_draw(targets *t, uint64_t seed, ad_error *error)
{
    const double began = clock_seconds(CLOCK_MONOTONIC);
    nn_rng fresh = nn_rng_split(seed, "members/fresh");
    if (!make_members(t, TARGETS_FRESH, true, &t->fresh)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for fresh members");
    }
    ad_status status = make_pool(t, seed, error);
    status = status == AD_OK ? draw_members(t, SAMPLING_UNIFORM, &fresh, &t->fresh, error) : status;
    status = status == AD_OK ? fit(t, error) : status;
    t->account.solved = t->solved.count;
    t->account.seconds = clock_seconds(CLOCK_MONOTONIC) - began;
    return status;
}

/* ---- the source of a problem's points ------------------------------------------------------ */

static void put_target(const targets *t, const model_draw *draw, size_t point, const double *from)
{
    for (size_t i = 0; i < t->nodes; i++) {
        for (size_t c = 0, width = t->rows / t->nodes; c < width; c++) {
            draw->data[(c * t->nodes + i) * draw->count + point] = from[width * i + c] * t->length;
        }
    }
}

/* The first `count` points. */
static void fill_from_pool(const targets *t, const model_draw *draw, size_t count)
{
    const size_t all = t->solved.count;
    for (size_t k = 0; k < count; k++) { /* as many as there are: each once */
        const size_t any = (size_t)(nn_rng_uniform(draw->rng) * (double)all) % all;
        const size_t from = count == all ? k : any;
        for (size_t i = 0; i < t->parameters; i++) {
            draw->x[i * draw->count + k] = t->solved.x[i * all + from];
        }
        put_target(t, draw, k, t->solved.curvature + from * t->rows);
    }
}

/* Members of their own, that nobody else has. */
static ad_status fill_fresh(targets *t, const model_draw *draw, ad_error *error)
{
    members own;
    ad_status status = AD_OK;
    if (make_members(t, draw->count, false, &own)) {
        status = draw_members(t, SAMPLING_UNIFORM, draw->rng, &own, error);
    } else {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", draw->count);
    }
    for (size_t k = 0; k < draw->count && status == AD_OK; k++) {
        for (size_t i = 0; i < t->parameters; i++) {
            draw->x[i * draw->count + k] = own.x[i * draw->count + k];
        }
        put_target(t, draw, k, own.curvature + k * t->rows);
    }
    ad_memory_free(&own.memory);
    return status;
}

/* Members for which the step is not trusted, solved: `count` of those at `first`, which [count], by
 * parameters in t->x. One without a solution does not count: its target is what the network says.
 */
static ad_status solve_others(targets *t, const model_draw *draw, size_t first, size_t count,
                              const size_t *which, ad_error *error)
{
    ad_status status =
        solve_members_curvature(t->solver, count, t->x, NULL, t->refined, t->results, error);
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        const double *network = t->curvature + which[i] * t->rows;
        put_target(t, draw, first + which[i],
                   t->results[i].solved ? t->refined + i * t->rows : network);
    }
    return status;
}

/* `count` points from `first` on, at most BATCH. */
static ad_status refine(targets *t, const model_draw *draw, size_t first, size_t count,
                        ad_error *error)
{
    const size_t modes = (size_t)family_modes(t->family);
    size_t which[BATCH], others = 0;
    for (size_t k = 0; k < count; k++) {
        for (size_t i = 0; i < t->parameters; i++) {
            t->x[i * count + k] = draw->x[i * draw->count + first + k];
        }
        for (size_t i = 0; i < t->nodes; i++) {
            for (size_t c = 0, width = t->rows / t->nodes; c < width; c++) {
                t->curvature[k * t->rows + width * i + c] =
                    draw->fields[(modes + c * t->nodes + i) * draw->count + first + k] / t->length;
            }
        }
    }
    family_parameters(t->family, count, t->x, t->si);
    ad_status status = solve_members_refine(t->solver, count, t->si, t->curvature, -1, NULL,
                                            t->refined, t->answers, error);
    for (size_t k = 0; k < count && status == AD_OK; k++) {
        if (t->answers[k].trusted) {
            put_target(t, draw, first + k, t->refined + k * t->rows);
        } else {
            memcpy(t->x + others * t->parameters, t->si + k * t->parameters,
                   t->parameters * sizeof *t->x);
            which[others++] = k;
        }
    }
    return status == AD_OK ? solve_others(t, draw, first, others, which, error) : status;
}

static ad_status fill_by_physics(targets *t, const model_draw *draw, size_t from, ad_error *error)
{
    ad_status status = AD_OK;
    for (size_t first = from; first < draw->count && status == AD_OK; first += BATCH) {
        const size_t left = draw->count - first;
        status = refine(t, draw, first, left < BATCH ? left : BATCH, error);
    }
    return status;
}

static ad_status fill(void *context, const model_draw *draw, ad_error *error)
{
    targets *t = context;
    if (draw->held_out) {
        return fill_fresh(t, draw, error);
    }
    const size_t from_pool = !draw->fields             ? draw->count
                             : t->kind == TARGETS_BOTH ? draw->count / 2
                                                       : 0;
    fill_from_pool(t, draw, from_pool);
    return fill_by_physics(t, draw, from_pool, error);
}

static bool follows(const void *context)
{
    return ((const targets *)context)->kind != TARGETS_SOLVED;
}

model_source targets_source(targets *t)
{
    return (model_source){.rows = (int)t->rows, .fill = fill, .follows = follows, .context = t};
}

/* ---- measuring ----------------------------------------------------------------------------- */

/* Largest distances [TARGETS_FRESH] of values from those of the fresh members. */
static void compare(const targets *t, const double *values, double *errors)
{
    for (size_t k = 0; k < TARGETS_FRESH; k++) {
        const size_t first = k * TARGETS_POINTS * SOLVE_MEMBERS_COLUMNS;
        errors[k] = largest_distance(TARGETS_POINTS, 3, SOLVE_MEMBERS_COLUMNS, 1, values + first,
                                     t->fresh.values + first) /
                    t->length;
    }
    sort_ascending(TARGETS_FRESH, errors);
}

static_assert((int)TARGETS_FRESH <= (int)BATCH, "fresh members are measured in one batch");

ad_status targets_measure(targets *t, const nn_mlp *mlp, const double *weights,
                          targets_errors *errors, ad_error *error)
{
    double off[TARGETS_FRESH];
    ad_status status =
        t->network ? AD_OK : family_network_create(t->family, mlp, t->pool, &t->network, error);
    if (status == AD_OK) {
        family_parameters(t->family, TARGETS_FRESH, t->fresh.x, t->si);
        status = family_network_run(t->network, weights, TARGETS_FRESH, t->si, t->curvature, error);
    }
    for (int steps = 0; steps <= 1 && status == AD_OK; steps++) {
        status = solve_members_refine(t->solver, TARGETS_FRESH, t->si, t->curvature, steps,
                                      t->values, NULL, NULL, error);
        if (status != AD_OK) {
            break;
        }
        compare(t, t->values, off);
        const double found[3] = {off[TARGETS_FRESH / 2], off[TARGETS_FRESH * 95 / 100],
                                 off[TARGETS_FRESH - 1]};
        memcpy(steps ? &errors->polished_median : &errors->median, found, sizeof found);
    }
    return status;
}
