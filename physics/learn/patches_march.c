/* Through time, window by window: each on patches that are refined as needed, and judged. */
#include "physics/learn/patches_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 24 }; /* of refinement in a window */

ad_status patch_no_memory(ad_error *error)
{
    return ad_fail(error, AD_NO_MEMORY, "out of memory for patches");
}

/* ---- a window -------------------------------------------------------------------------------- */

typedef struct window_plan {
    double begin, end;
    patch_phase phase;
    const patch_grid *before, *richer_before;
} window_plan;

static bool make_grid(patch_run *r, const int *degree, patch_grid *grid)
{
    return patch_grid_create(grid, r->problem.dims, r->problem.outputs, r->cells, r->edges, degree);
}

/* The start of time alone, by the conditions there: a first guess, and patches that resolve it. */
static ad_status guess_start(patch_run *r, patch_grid *guess, ad_error *error)
{
    patch_problem *p = &r->problem;
    const int time = patch_time(r);
    int degree[PATCH_DIMS], most = 1;
    memcpy(degree, r->degree, sizeof degree);
    for (int f = 0; f < p->outputs; f++) {
        most = p->order[f][time] > most ? p->order[f][time] : most;
    }
    degree[time] = most - 1;
    for (int round = 0; round < ROUNDS; round++) {
        patch_outcome outcome;
        bool changed;
        int halved = 0;
        patch_grid_clear(guess);
        if (!make_grid(r, degree, guess)) {
            return patch_no_memory(error);
        }
        ad_status status =
            patch_solve(p, guess, PATCH_START, NULL, PATCH_STEPS, 0.01 * r->local, &outcome, error);
        if (status != AD_OK) { /* such as a field that has no start */
            memset(guess->c, 0, (size_t)guess->patches * patch_grid_size(guess) * sizeof *guess->c);
            return status == AD_BAD_INPUT || status == AD_NOT_FINITE ? AD_OK : status;
        }
        patch_find_scale(r, guess, &changed);
        for (int d = 0; d < p->dims; d++) {
            halved += d != time ? patch_refine(r, guess, d, false) : 0;
        }
        if (!changed && halved == 0) {
            break;
        }
    }
    return AD_OK;
}

static void set_window(patch_run *r, const window_plan *plan)
{
    const int time = patch_time(r);
    if (r->problem.marches) {
        r->edges[time][0] = plan->begin;
        r->edges[time][1] = plan->end;
    }
}

/* A solution with half the degrees from the guess, which costs next to nothing, is where
 * Gauss-Newton starts from. Without one it is the guess. */
static ad_status start_from(patch_run *r, const window_plan *plan, const patch_grid *guess,
                            patch_grid *found, ad_error *error)
{
    patch_problem *p = &r->problem;
    patch_grid coarse;
    patch_outcome outcome;
    ad_error ignored;
    int degree[PATCH_DIMS];
    for (int d = 0; d < p->dims; d++) {
        degree[d] = r->degree[d] / 2 > 3 ? r->degree[d] / 2 : 3;
        degree[d] = degree[d] < r->degree[d] ? degree[d] : r->degree[d];
    }
    if (guess->dims > 0) {
        patch_grid_project(guess, found);
    }
    if (p->linear) {
        return AD_OK;
    }
    if (!make_grid(r, degree, &coarse)) {
        return patch_no_memory(error);
    }
    if (guess->dims > 0) {
        patch_grid_project(guess, &coarse);
    }
    const ad_status status =
        patch_solve(p, &coarse, plan->phase, plan->before, PATCH_STEPS, 1e-2, &outcome, &ignored);
    r->steps += outcome.steps;
    if (status == AD_OK) {
        memset(found->c, 0, (size_t)found->patches * patch_grid_size(found) * sizeof *found->c);
        patch_grid_embed(&coarse, found);
    }
    patch_grid_clear(&coarse);
    return AD_OK;
}

/* Solves a window on patches that are refined as needed. *factor: the length that would have been
 * right, over that of the plan; below 0.89 the window is not solved. *outcome: of its
 * last solution. */
static ad_status solve_window(patch_run *r, const window_plan *plan, const patch_grid *guess,
                              patch_grid *found, double *factor, patch_outcome *outcome,
                              ad_error *error)
{
    patch_problem *p = &r->problem;
    patch_grid last = {.dims = 0};
    ad_status status = AD_OK;
    const double enough = fmax(1e-14, 0.02 * r->local);
    *factor = 1;
    for (int round = 0; round < ROUNDS && status == AD_OK; round++) {
        bool changed;
        int halved = 0;
        set_window(r, plan);
        patch_grid_clear(found);
        if (!make_grid(r, r->degree, found)) {
            status = patch_no_memory(error);
            break;
        }
        if (last.dims > 0) {
            patch_grid_project(&last, found);
        } else {
            status = start_from(r, plan, guess, found, error);
        }
        if (status == AD_OK) {
            status = patch_solve(p, found, plan->phase, plan->before, PATCH_STEPS, enough, outcome,
                                 error);
        }
        if (status != AD_OK) {
            break;
        }
        r->steps += outcome->steps;
        patch_find_scale(r, found, &changed);
        *factor = patch_length_factor(r, found);
        if (*factor < 0.6) {
            break; /* solved again, in less time: space is looked at then */
        }
        for (int d = 0; d < p->dims; d++) {
            halved += p->marches && d == patch_time(r) ? 0 : patch_refine(r, found, d, false);
        }
        if ((halved == 0 && !changed) || patch_is_late(&r->problem)) {
            break;
        }
        patch_grid_clear(&last);
        last = *found;
        *found = (patch_grid){.dims = 0};
    }
    patch_grid_clear(&last);
    return status;
}

/* Squares of fields, and of what unknowns change, over the windows. */
static void add_window(patch_run *r, const patch_grid *found)
{
    const patch_problem *p = &r->problem;
    const size_t size = patch_grid_size(found), all = (size_t)found->patches * size;
    for (int k = 0; k < found->patches; k++) {
        const double part = patch_volume(found, k);
        r->volume += part;
        for (size_t i = 0; i < size; i++) {
            const size_t f = i / (size_t)found->functions, at = (size_t)k * size + i;
            r->squares[f] += part * found->c[at] * found->c[at];
            for (size_t g = 0; g < (size_t)p->unknowns; g++) {
                const double slope = found->slopes[g * all + at];
                r->slopes[g][f] += part * slope * slope;
            }
        }
    }
}

static void add_misfit(patch_misfit *to, const patch_misfit *of, int unknowns)
{
    to->rows += of->rows;
    to->sum += of->sum;
    for (int i = 0; i < unknowns * unknowns; i++) {
        to->jtj[i] += of->jtj[i];
    }
    for (int i = 0; i < unknowns; i++) {
        to->jtr[i] += of->jtr[i];
    }
}

/* The step that a richer basis would take from what was found, and so what iterations left, too. */
static ad_status judge(patch_run *r, const window_plan *plan, const patch_grid *found,
                       patch_grid *richer, ad_error *error)
{
    patch_problem *p = &r->problem;
    patch_outcome outcome;
    patch_grid same = {.dims = 0};
    int degree[PATCH_DIMS];
    for (int d = 0; d < p->dims; d++) {
        degree[d] = found->degree[d] + PATCH_RICHER;
    }
    if (!patch_grid_create(&same, found->dims, found->outputs, found->cells,
                           (double *const *)found->edge, degree) ||
        !patch_grid_create(richer, found->dims, found->outputs, found->cells,
                           (double *const *)found->edge, degree)) {
        patch_grid_clear(&same);
        return patch_no_memory(error);
    }
    patch_grid_embed(found, richer);
    patch_grid_embed(found, &same);
    ad_status status =
        patch_solve(p, richer, plan->phase, plan->richer_before, 1, 0, &outcome, error);
    const size_t size = patch_grid_size(richer);
    for (size_t at = 0; at < (size_t)found->patches * size && status == AD_OK; at++) {
        const double off = richer->c[at] - same.c[at];
        r->errors[at % size / (size_t)richer->functions] +=
            patch_volume(found, (int)(at / size)) * off * off;
    }
    for (int k = 0; k < found->patches && status == AD_OK; k++) { /* what neither basis shows */
        for (int f = 0; f < found->outputs; f++) {
            const double off = (found->missed[k] + outcome.rounding) * p->scale[f];
            r->errors[f] += patch_volume(found, k) * off * off;
        }
    }
    if (status == AD_OK) {
        add_misfit(&r->richer, &outcome.misfit, p->unknowns);
    }
    patch_grid_clear(&same);
    return status;
}

double patch_relative(const patch_run *r, const double *errors)
{
    double worst = 0, most = 0;
    for (int f = 0; f < r->problem.outputs; f++) {
        most = fmax(most, r->squares[f]);
    }
    for (int f = 0; f < r->problem.outputs; f++) {
        const double size = r->squares[f] > 1e-16 * most ? r->squares[f] : most;
        worst = fmax(worst, size > 0 ? errors[f] / size : errors[f] > 0 ? INFINITY : 0);
    }
    return sqrt(worst);
}

/* Rounding leaves some hundred units of the last digit at a front, and more with every window. */
double patch_estimate(const patch_run *r)
{
    return hypot(patch_relative(r, r->errors), 2e-14 * sqrt(1 + (double)r->result->count));
}

bool patches_keep(patches *p, patch_grid *found, patch_grid *richer)
{
    if (p->count == p->room) {
        const int room = p->room > 0 ? 2 * p->room : 16;
        solved *grown = realloc(p->window, (size_t)room * sizeof *grown);
        if (!grown) {
            return false;
        }
        p->window = grown;
        p->room = room;
    }
    p->window[p->count++] = (solved){*found, *richer};
    *found = *richer = (patch_grid){.dims = 0};
    return true;
}

void patches_drop(patches *p)
{
    for (int i = 0; i < p->count; i++) {
        patch_grid_clear(&p->window[i].found);
        patch_grid_clear(&p->window[i].richer);
    }
    free(p->window);
    p->window = NULL;
    p->count = p->room = 0;
}

/* ---- all windows ----------------------------------------------------------------------------- */

static bool goes_on(const patch_run *r, int attempt, double done)
{
    const patches_settings *s = r->problem.settings;
    const patches *p = r->result;
    const patches_progress now = {.attempt = attempt,
                                  .window = p->count,
                                  .done = done,
                                  .estimate = patch_estimate(r),
                                  .seconds = patch_now() - r->began,
                                  .patches =
                                      p->count > 0 ? p->window[p->count - 1].found.patches : 0};
    return !s->progress || s->progress(s->context, &now);
}

/* Whether it would be too late to begin anew, three times as expensive, when all of time is done.
 */
static bool is_too_late(const patch_run *r, double since, double done)
{
    const double now = patch_now(), all = (now - since) / done;
    return now - r->began + 4 * all > r->problem.settings->seconds;
}

ad_status patch_march(patch_run *r, int attempt, patches_end *end, ad_error *error)
{
    patch_problem *p = &r->problem;
    patches *result = r->result;
    const int time = patch_time(r);
    const domain_coordinate *t = p->marches ? &p->model->domain.coordinates[time] : NULL;
    const double low = t ? t->low : 0, high = t ? t->high : 1, all = high - low;
    const double since = patch_now();
    double now = low, length = all / 8;
    patch_grid guess = {.dims = 0}, found = {.dims = 0}, richer = {.dims = 0};
    ad_status status = AD_OK;
    *end = PATCHES_CONVERGED;
    patches_drop(result);
    memset(r->squares, 0, sizeof r->squares);
    memset(r->errors, 0, sizeof r->errors);
    memset(r->varied, 0, sizeof r->varied);
    memset(r->slopes, 0, sizeof r->slopes);
    r->misfit = r->richer = (patch_misfit){.rows = 0};
    r->volume = 0;
    if (!patch_begin(r)) {
        return patch_no_memory(error);
    }
    if (p->marches) {
        set_window(r, &(window_plan){.begin = low, .end = low + length});
        status = guess_start(r, &guess, error);
    }
    while (status == AD_OK && now < high) {
        const bool last = now + 1.01 * length >= high;
        const double far = last || !p->marches ? high : now + length;
        const solved *ended = result->count > 0 ? &result->window[result->count - 1] : NULL;
        const window_plan plan = {.begin = now,
                                  .end = p->marches ? patch_panel_end(r, now, far) : far,
                                  .phase = ended ? PATCH_LATER : PATCH_FIRST,
                                  .before = ended ? &ended->found : NULL,
                                  .richer_before = ended ? &ended->richer : NULL};
        double factor = 1;
        patch_outcome outcome = {.left = 0};
        status = solve_window(r, &plan, ended ? &ended->found : &guess, &found, &factor, &outcome,
                              error);
        const bool failed = status == AD_NOT_FINITE;
        if (p->marches && (failed || (status == AD_OK && factor < 0.89))) {
            /* shorter */
            length = (plan.end - plan.begin) * (failed ? 0.4 : fmax(0.2, factor));
            status = AD_OK;
            if (length < (p->unknowns > 0 ? 1e-4 : 1e-9) * all || patch_is_late(&r->problem)) {
                *end = patch_is_late(&r->problem) ? PATCHES_TIME_OVER : PATCHES_DIVERGED;
                break;
            }
            continue;
        }
        if (failed) {
            *end = patch_is_late(&r->problem) ? PATCHES_TIME_OVER : PATCHES_DIVERGED;
            status = AD_OK;
            break;
        }
        if (status == AD_OK) {
            add_window(r, &found);
            add_misfit(&r->misfit, &outcome.misfit, p->unknowns);
            status = judge(r, &plan, &found, &richer, error);
        }
        if (status == AD_NOT_FINITE &&
            patch_is_late(&r->problem)) { /* no answer without an estimate */
            *end = PATCHES_TIME_OVER;
            status = AD_OK;
            break;
        }
        if (status != AD_OK) {
            break;
        }
        for (int d = 0; d < p->dims && p->marches; d++) {
            if (d != time) {
                patch_refine(r, &found, d, true); /* for the next */
            }
        }
        if (!patches_keep(result, &found, &richer)) {
            status = patch_no_memory(error);
            break;
        }
        now = plan.end;
        length = (plan.end - plan.begin) * factor;
        const bool wanted = goes_on(r, attempt, (now - low) / all);
        if (!wanted || (patch_is_late(&r->problem) && now < high)) {
            *end = wanted ? PATCHES_TIME_OVER : PATCHES_STOPPED;
            break;
        }
        const double done = (now - low) / all;
        if (done < 0.9 && attempt < PATCH_ATTEMPTS && p->unknowns == 0 && r->local > 1e-14 &&
            patch_estimate(r) * sqrt(done) > 1.5 * p->settings->tolerance &&
            !is_too_late(r, since, done)) {
            *end = PATCHES_INACCURATE;
            break;
        }
    }
    result->summary.done = now >= high ? 1 : (now - low) / all;
    patch_grid_clear(&guess);
    patch_grid_clear(&found);
    patch_grid_clear(&richer);
    return status;
}
