#include "physics/learn/patches_internal.h"

#include "autodiff/dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    ATTEMPTS = 5,
    ROUNDS = 24, /* of refinement in a window */
    FUNCTIONS_MAX = 400,
    STEPS = 40,
    CELLS_MAX = 2048,
    RICHER = 2 /* degrees of the basis that judges */
};

/* A window of time: what was found, and by the richer basis. */
typedef struct solved {
    patch_grid found, richer;
} solved;

struct patches {
    const physics_model *model;
    patches_summary summary;
    int count, room;
    solved *window; /* [room] */
};

const char *patches_end_word(patches_end end)
{
#define PATCHES_END_WORD(code, word, text) word,
    static const char *const words[] = {PATCHES_END_LIST(PATCHES_END_WORD)};
    return words[end];
}

const char *patches_end_text(patches_end end)
{
#define PATCHES_END_TEXT(code, word, text) text,
    static const char *const texts[] = {PATCHES_END_LIST(PATCHES_END_TEXT)};
    return texts[end];
}

static void drop_windows(patches *p)
{
    for (int i = 0; i < p->count; i++) {
        patch_grid_clear(&p->window[i].found);
        patch_grid_clear(&p->window[i].richer);
    }
    free(p->window);
    p->window = NULL;
    p->count = p->room = 0;
}

void patches_free(patches *p)
{
    if (p) {
        drop_windows(p);
        free(p);
    }
}

patches_summary patches_summarize(const patches *p)
{
    return p->summary;
}

/* ---- a run ----------------------------------------------------------------------------------- */

typedef struct run {
    patch_problem problem;
    patches *result;
    double began;
    double local; /* tolerance of a window */
    int cells[PATCH_DIMS];
    double *edges[PATCH_DIMS]; /* of the next window */
    int degree[PATCH_DIMS];
    /* over the windows so far: of the fields, of their errors, of what unknowns do */
    double squares[PATCH_OUTPUTS], errors[PATCH_OUTPUTS], varied[PATCH_OUTPUTS], volume;
    int steps;
} run;

static double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool time_over(const run *r)
{
    return seconds_now() - r->began > r->problem.settings->seconds;
}

static int time_of(const run *r)
{
    return r->problem.model->domain.time;
}

static bool even_edges(double **edges, int cells, double low, double high)
{
    free(*edges);
    *edges = malloc(((size_t)cells + 1) * sizeof **edges);
    for (int i = 0; i <= cells && *edges; i++) {
        (*edges)[i] = i == cells ? high : low + (high - low) * i / cells;
    }
    return *edges != NULL;
}

/* Degrees that suit a tolerance, a little more along coordinates of derivatives of higher order. */
static void choose_degrees(run *r)
{
    const patch_problem *p = &r->problem;
    const double digits = fmin(14, fmax(1, -log10(r->local)));
    double functions = 1;
    for (int d = 0; d < p->dims; d++) {
        int order = 0;
        for (int f = 0; f < p->outputs; f++) {
            order = p->order[f][d] > order ? p->order[f][d] : order;
        }
        const double degree =
            p->marches && d == time_of(r) ? 2 + digits + order : 3 + 1.4 * digits + order - 2;
        r->degree[d] = (int)fmin(PATCH_DEGREE - RICHER, fmax(4, round(degree)));
        functions *= r->degree[d] + 1;
    }
    while (functions * p->outputs > FUNCTIONS_MAX) { /* the highest first */
        int most = 0;
        for (int d = 1; d < p->dims; d++) {
            most = r->degree[d] > r->degree[most] ? d : most;
        }
        if (r->degree[most] <= 4) {
            break;
        }
        functions *= (double)r->degree[most] / (r->degree[most] + 1);
        r->degree[most]--;
    }
}

static bool begin_edges(run *r)
{
    const patch_problem *p = &r->problem;
    int coordinates = p->dims - (p->marches ? 1 : 0);
    for (int d = 0; d < p->dims; d++) {
        const domain_coordinate *c = &p->model->domain.coordinates[d];
        r->cells[d] = p->marches && d == time_of(r) ? 1 : coordinates == 1 ? 4 : 1;
        if (!even_edges(&r->edges[d], r->cells[d], c->low, c->high)) {
            return false;
        }
    }
    return true;
}

/* ---- how well a grid resolves
 * -------------------------------------------------------------------- */

/* Root mean square in a patch of the functions of the last two degrees along a coordinate, relative
 * to the size of the outputs, the worst of these. */
static double tail_of(const run *r, const patch_grid *grid, int patch, int coordinate)
{
    double worst = 0;
    for (int f = 0; f < grid->outputs; f++) {
        const double *c =
            grid->c + (size_t)patch * patch_grid_size(grid) + (size_t)f * (size_t)grid->functions;
        double sum = 0;
        for (int j = 0; j < grid->functions; j++) {
            int function = j;
            for (int d = grid->dims - 1; d > coordinate; d--) {
                function /= grid->degree[d] + 1;
            }
            if (function % (grid->degree[coordinate] + 1) >= grid->degree[coordinate] - 1) {
                sum += c[j] * c[j];
            }
        }
        worst = fmax(worst, sqrt(sum) / r->problem.scale[f]);
    }
    return worst;
}

/* The size of the outputs, as far as is known. *changed: some by more than ten. */
static void find_scale(run *r, const patch_grid *grid, bool *changed)
{
    patch_problem *p = &r->problem;
    double volume = 0, size[PATCH_OUTPUTS] = {0}, most = 0;
    for (int k = 0; k < grid->patches; k++) {
        const double part = patch_volume(grid, k);
        volume += part;
        for (size_t i = 0; i < patch_grid_size(grid); i++) {
            const double c = grid->c[(size_t)k * patch_grid_size(grid) + i];
            size[i / (size_t)grid->functions] += part * c * c;
        }
    }
    *changed = false;
    for (int f = 0; f < p->outputs; f++) {
        size[f] = sqrt((r->squares[f] + size[f]) / (r->volume + volume));
        most = fmax(most, size[f]);
    }
    for (int f = 0; f < p->outputs; f++) {
        const double now = size[f] > 1e-8 * most ? size[f] : most > 0 ? most : 1;
        *changed = *changed || now > 10 * p->scale[f] || p->scale[f] > 10 * now;
        p->scale[f] = now;
    }
}

/* Cells whose tails are too long are halved; where two neighbours have far shorter ones than needed
 * they become one (only if `merge`). Returns how many were halved. */
static int refine(run *r, const patch_grid *grid, int coordinate, bool merge)
{
    enum { KEEP, HALVE, JOIN };
    const int cells = grid->cells[coordinate];
    const double *edge = grid->edge[coordinate];
    char *what = calloc((size_t)cells, 1);
    double *tail = calloc((size_t)cells, sizeof *tail), volume = 0;
    double *edges = malloc((2 * (size_t)cells + 1) * sizeof *edges);
    int halved = 0, next = 0;
    if (!what || !tail || !edges) {
        free(what);
        free(tail);
        free(edges);
        return 0;
    }
    for (int k = 0; k < grid->patches; k++) {
        volume += patch_volume(grid, k);
    }
    for (int k = 0; k < grid->patches; k++) {
        /* by its share of the error: all of the patches together may have the tolerance */
        const double share = sqrt(patch_volume(grid, k) / volume * grid->patches);
        double *worst = &tail[patch_cell(grid, k, coordinate)];
        *worst = fmax(*worst, share * tail_of(r, grid, k, coordinate));
    }
    for (int i = 0; i < cells; i++) {
        const bool can = edge[i + 1] - edge[i] > 1e-9 * (edge[cells] - edge[0]);
        if (tail[i] > r->local && can && cells + halved < CELLS_MAX) {
            what[i] = HALVE;
            halved++;
        }
    }
    const double longer = pow(2, grid->degree[coordinate] + 1);
    for (int i = 0; i + 1 < cells && merge; i++) {
        const double ratio = (edge[i + 2] - edge[i + 1]) / (edge[i + 1] - edge[i]);
        if (what[i] == KEEP && what[i + 1] == KEEP && ratio > 0.49 && ratio < 2.1 && cells > 2 &&
            fmax(tail[i], tail[i + 1]) * longer * 10 < r->local) {
            what[i] = JOIN;
            i++;
        }
    }
    edges[next++] = edge[0];
    for (int i = 0; i < cells; i++) {
        if (what[i] == HALVE) {
            edges[next++] = (edge[i] + edge[i + 1]) / 2;
        }
        if (what[i] != JOIN) {
            edges[next++] = edge[i + 1];
        }
    }
    free(what);
    free(tail);
    free(r->edges[coordinate]);
    r->edges[coordinate] = edges;
    r->cells[coordinate] = next - 1;
    return halved;
}

static bool make_grid(run *r, const int *degree, patch_grid *grid)
{
    return patch_grid_create(grid, r->problem.dims, r->problem.outputs, r->cells, r->edges, degree);
}

/* ---- a window -------------------------------------------------------------------------------- */

typedef struct window_plan {
    double begin, end;
    patch_phase phase;
    const patch_grid *before, *richer_before;
} window_plan;

static ad_status no_memory(ad_error *error)
{
    return ad_fail(error, AD_NO_MEMORY, "out of memory for patches");
}

/* The start of time alone, by the conditions there: a first guess, and patches that resolve it. */
static ad_status guess_start(run *r, patch_grid *guess, ad_error *error)
{
    patch_problem *p = &r->problem;
    const int time = time_of(r);
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
            return no_memory(error);
        }
        ad_status status =
            patch_solve(p, guess, PATCH_START, NULL, STEPS, 0.01 * r->local, &outcome, error);
        if (status != AD_OK) { /* such as a field that has no start */
            memset(guess->c, 0, (size_t)guess->patches * patch_grid_size(guess) * sizeof *guess->c);
            return status == AD_BAD_INPUT || status == AD_NOT_FINITE ? AD_OK : status;
        }
        find_scale(r, guess, &changed);
        for (int d = 0; d < p->dims; d++) {
            halved += d != time ? refine(r, guess, d, false) : 0;
        }
        if (!changed && halved == 0) {
            break;
        }
    }
    return AD_OK;
}

static void set_window(run *r, const window_plan *plan)
{
    const int time = time_of(r);
    if (r->problem.marches) {
        r->edges[time][0] = plan->begin;
        r->edges[time][1] = plan->end;
    }
}

/* What a window solved on a grid says of its length: the factor it should have had. */
static double length_factor(const run *r, const patch_grid *grid)
{
    const int time = time_of(r);
    double tail = 0, volume = 0;
    if (!r->problem.marches) {
        return 1;
    }
    for (int k = 0; k < grid->patches; k++) {
        volume += patch_volume(grid, k);
    }
    for (int k = 0; k < grid->patches; k++) {
        const double share = sqrt(patch_volume(grid, k) / volume * grid->patches);
        tail = fmax(tail, share * tail_of(r, grid, k, time));
    }
    return fmin(2, 0.9 * pow(r->local / fmax(tail, 1e-300), 1.0 / grid->degree[time]));
}

/* A solution with half the degrees from the guess, which costs next to nothing, is where
 * Gauss-Newton starts from. Without one it is the guess. */
static ad_status start_from(run *r, const window_plan *plan, const patch_grid *guess,
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
        return no_memory(error);
    }
    if (guess->dims > 0) {
        patch_grid_project(guess, &coarse);
    }
    const ad_status status =
        patch_solve(p, &coarse, plan->phase, plan->before, STEPS, 1e-2, &outcome, &ignored);
    r->steps += outcome.steps;
    if (status == AD_OK) {
        memset(found->c, 0, (size_t)found->patches * patch_grid_size(found) * sizeof *found->c);
        patch_grid_embed(&coarse, found);
    }
    patch_grid_clear(&coarse);
    return AD_OK;
}

/* Solves a window on patches that are refined as needed. *factor: the length that would have been
 * right, over that of the plan; below 0.89 the window is not solved. *left: by iterations. */
static ad_status solve_window(run *r, const window_plan *plan, const patch_grid *guess,
                              patch_grid *found, double *factor, double *left, ad_error *error)
{
    patch_problem *p = &r->problem;
    patch_grid last = {.dims = 0};
    ad_status status = AD_OK;
    const double enough = fmax(1e-14, 0.02 * r->local);
    bool identifies = false; /* when patches resolve the fields of the guess */
    *factor = 1;
    for (int round = 0; round < ROUNDS && status == AD_OK; round++) {
        patch_outcome outcome;
        bool changed;
        int halved = 0;
        set_window(r, plan);
        patch_grid_clear(found);
        if (!make_grid(r, r->degree, found)) {
            status = no_memory(error);
            break;
        }
        if (last.dims > 0) {
            patch_grid_project(&last, found);
        } else {
            status = start_from(r, plan, guess, found, error);
        }
        if (status == AD_OK) {
            status = identifies ? patch_identify(p, found, STEPS, enough, &outcome, error)
                                : patch_solve(p, found, plan->phase, plan->before, STEPS, enough,
                                              &outcome, error);
        }
        if (status != AD_OK) {
            break;
        }
        r->steps += outcome.steps;
        *left = outcome.left;
        find_scale(r, found, &changed);
        *factor = length_factor(r, found);
        if (*factor < 0.6) {
            break; /* solved again, in less time: space is looked at then */
        }
        for (int d = 0; d < p->dims; d++) {
            halved += p->marches && d == time_of(r) ? 0 : refine(r, found, d, false);
        }
        if ((halved == 0 && !changed && identifies == (p->unknowns > 0)) || time_over(r)) {
            break;
        }
        identifies = p->unknowns > 0 && (identifies || halved == 0);
        patch_grid_clear(&last);
        last = *found;
        *found = (patch_grid){.dims = 0};
    }
    patch_grid_clear(&last);
    return status;
}

/* What standard deviations of the unknowns do to the fields. */
static ad_status vary_unknowns(run *r, const window_plan *plan, const patch_grid *found,
                               ad_error *error)
{
    patch_problem *p = &r->problem;
    ad_status status = AD_OK;
    for (int i = 0; i < p->unknowns && status == AD_OK; i++) {
        const double value = p->unknown[i];
        patch_grid varied;
        patch_outcome outcome;
        if (!patch_grid_create(&varied, found->dims, found->outputs, found->cells,
                               (double *const *)found->edge, found->degree)) {
            return no_memory(error);
        }
        patch_grid_embed(found, &varied);
        p->unknown[i] += p->deviation[i];
        status = patch_solve(p, &varied, plan->phase, plan->before, 1, 0, &outcome, error);
        p->unknown[i] = value;
        for (int k = 0; k < found->patches && status == AD_OK; k++) {
            for (size_t j = 0; j < patch_grid_size(found); j++) {
                const size_t at = (size_t)k * patch_grid_size(found) + j;
                const double off = varied.c[at] - found->c[at];
                r->varied[j / (size_t)found->functions] += patch_volume(found, k) * off * off;
            }
        }
        patch_grid_clear(&varied);
    }
    return status;
}

/* The step that a richer basis would take from what was found. */
static ad_status judge(run *r, const window_plan *plan, const patch_grid *found, double left,
                       patch_grid *richer, ad_error *error)
{
    patch_problem *p = &r->problem;
    patch_outcome outcome;
    patch_grid same = {.dims = 0};
    double unknown[MODEL_UNKNOWNS_MAX], deviation[MODEL_UNKNOWNS_MAX];
    int degree[PATCH_DIMS];
    memcpy(unknown, p->unknown, sizeof unknown);
    memcpy(deviation, p->deviation, sizeof deviation);
    for (int d = 0; d < p->dims; d++) {
        degree[d] = found->degree[d] + RICHER;
    }
    if (!patch_grid_create(&same, found->dims, found->outputs, found->cells,
                           (double *const *)found->edge, degree) ||
        !patch_grid_create(richer, found->dims, found->outputs, found->cells,
                           (double *const *)found->edge, degree)) {
        patch_grid_clear(&same);
        return no_memory(error);
    }
    patch_grid_embed(found, richer);
    patch_grid_embed(found, &same);
    ad_status status =
        p->unknowns > 0
            ? patch_identify(p, richer, STEPS, fmax(1e-14, 0.02 * r->local), &outcome, error)
            : patch_solve(p, richer, plan->phase, plan->richer_before, 1, 0, &outcome, error);
    for (int k = 0; k < found->patches && status == AD_OK; k++) {
        const double part = patch_volume(found, k);
        r->volume += part;
        for (size_t i = 0; i < patch_grid_size(richer); i++) {
            const size_t at = (size_t)k * patch_grid_size(richer) + i;
            const double off = richer->c[at] - same.c[at];
            const size_t f = i / (size_t)richer->functions;
            r->errors[f] += part * off * off;
            r->squares[f] += part * same.c[at] * same.c[at];
        }
        for (int f = 0; f < found->outputs; f++) { /* what iterations left */
            const double off = left * p->scale[f];
            r->errors[f] += part * off * off;
        }
    }
    for (int i = 0; i < p->unknowns; i++) { /* the richer basis finds another one, too */
        p->deviation[i] = hypot(deviation[i], p->unknown[i] - unknown[i]);
        p->unknown[i] = unknown[i];
    }
    patch_grid_clear(&same);
    return status == AD_OK ? vary_unknowns(r, plan, found, error) : status;
}

/* Root mean square of errors [outputs] over that of the fields. */
static double relative(const run *r, const double *errors)
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

/* Rounding leaves some units of the last digit, and more with every window. */
static double estimate_of(const run *r)
{
    return hypot(relative(r, r->errors), 4e-15 * sqrt(1 + (double)r->result->count));
}

static bool keep_window(patches *p, patch_grid *found, patch_grid *richer)
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

/* ---- all windows ----------------------------------------------------------------------------- */

static bool goes_on(const run *r, int attempt, double done)
{
    const patches_settings *s = r->problem.settings;
    const patches *p = r->result;
    const patches_progress now = {.attempt = attempt,
                                  .window = p->count,
                                  .done = done,
                                  .estimate = estimate_of(r),
                                  .seconds = seconds_now() - r->began,
                                  .patches =
                                      p->count > 0 ? p->window[p->count - 1].found.patches : 0};
    return !s->progress || s->progress(s->context, &now);
}

/* Whether it would be too late to begin anew, three times as expensive, when all of time is done.
 */
static bool is_late(const run *r, double since, double done)
{
    const double now = seconds_now(), all = (now - since) / done;
    return now - r->began + 4 * all > r->problem.settings->seconds;
}

/* One attempt with r->local; the end it had: PATCHES_CONVERGED means that all of time is solved,
 * PATCHES_INACCURATE that the error was above the tolerance long before. */
static ad_status attempt_once(run *r, int attempt, patches_end *end, ad_error *error)
{
    patch_problem *p = &r->problem;
    patches *result = r->result;
    const int time = time_of(r);
    const domain_coordinate *t = p->marches ? &p->model->domain.coordinates[time] : NULL;
    const double low = t ? t->low : 0, high = t ? t->high : 1, all = high - low;
    const double since = seconds_now();
    double now = low, length = all / 8;
    patch_grid guess = {.dims = 0}, found = {.dims = 0}, richer = {.dims = 0};
    ad_status status = AD_OK;
    *end = PATCHES_CONVERGED;
    drop_windows(result);
    memset(r->squares, 0, sizeof r->squares);
    memset(r->errors, 0, sizeof r->errors);
    memset(r->varied, 0, sizeof r->varied);
    r->volume = 0;
    choose_degrees(r);
    if (!begin_edges(r)) {
        return no_memory(error);
    }
    if (p->marches) {
        set_window(r, &(window_plan){.begin = low, .end = low + length});
        status = guess_start(r, &guess, error);
    }
    while (status == AD_OK && now < high) {
        const bool last = now + 1.01 * length >= high;
        const solved *ended = result->count > 0 ? &result->window[result->count - 1] : NULL;
        const window_plan plan = {.begin = now,
                                  .end = last || !p->marches ? high : now + length,
                                  .phase = ended ? PATCH_LATER : PATCH_FIRST,
                                  .before = ended ? &ended->found : NULL,
                                  .richer_before = ended ? &ended->richer : NULL};
        double factor = 1, left = 0;
        status =
            solve_window(r, &plan, ended ? &ended->found : &guess, &found, &factor, &left, error);
        const bool failed = status == AD_NOT_FINITE;
        if (p->marches && (failed || (status == AD_OK && factor < 0.89))) {
            /* shorter */
            length = (plan.end - plan.begin) * (failed ? 0.4 : fmax(0.2, factor));
            status = AD_OK;
            if (length < 1e-9 * all || time_over(r)) {
                *end = time_over(r) ? PATCHES_TIME_OVER : PATCHES_DIVERGED;
                break;
            }
            continue;
        }
        if (failed) {
            *end = PATCHES_DIVERGED;
            status = AD_OK;
            break;
        }
        if (status == AD_OK) {
            status = judge(r, &plan, &found, left, &richer, error);
        }
        if (status != AD_OK) {
            break;
        }
        for (int d = 0; d < p->dims && p->marches; d++) {
            if (d != time) {
                refine(r, &found, d, true); /* for the next */
            }
        }
        if (!keep_window(result, &found, &richer)) {
            status = no_memory(error);
            break;
        }
        now = plan.end;
        length = (plan.end - plan.begin) * factor;
        const bool wanted = goes_on(r, attempt, (now - low) / all);
        if (!wanted || (time_over(r) && now < high)) {
            *end = wanted ? PATCHES_TIME_OVER : PATCHES_STOPPED;
            break;
        }
        const double done = (now - low) / all;
        if (done < 0.9 && attempt < ATTEMPTS && r->local > 1e-14 &&
            estimate_of(r) > 1.5 * p->settings->tolerance && !is_late(r, since, done)) {
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

static void summarize(run *r, patches_end end)
{
    patches *p = r->result;
    patches_summary *s = &p->summary;
    s->end = end;
    s->by_unknowns = relative(r, r->varied);
    s->estimate = p->count > 0 ? hypot(estimate_of(r), s->by_unknowns) : INFINITY;
    s->windows = p->count;
    s->parameters = 0;
    s->most_patches = 0;
    for (int i = 0; i < p->count; i++) {
        const patch_grid *grid = &p->window[i].found;
        s->parameters += (size_t)grid->patches * patch_grid_size(grid);
        s->most_patches = grid->patches > s->most_patches ? grid->patches : s->most_patches;
    }
    s->steps = r->steps;
    s->unknowns = r->problem.unknowns;
    memcpy(s->unknown, r->problem.unknown, sizeof s->unknown);
    memcpy(s->deviation, r->problem.deviation, sizeof s->deviation);
    s->seconds = seconds_now() - r->began;
}

/* A run that ended early gives way to one before it that covered all of time. */
static void restore(patches *p, patches *before)
{
    const int attempts = p->summary.attempts;
    const patches_end end = p->summary.end;
    if (before->count > 0 && p->summary.done < 1) {
        drop_windows(p);
        *p = *before;
        p->summary.end = end;
        p->summary.attempts = attempts;
        before->count = 0;
        before->window = NULL;
    }
    drop_windows(before);
}

static ad_status fit(run *r, ad_error *error)
{
    const double tolerance = r->problem.settings->tolerance;
    patches *p = r->result, before = {.count = 0};
    double best = INFINITY;
    ad_status status = AD_OK;
    r->local = 3 * tolerance;
    for (int attempt = 1; attempt <= ATTEMPTS; attempt++) {
        patches_end end;
        for (int i = 0; i < r->problem.unknowns; i++) {
            r->problem.unknown[i] = r->problem.model->own_unknowns[i].guess;
        }
        status = attempt_once(r, attempt, &end, error);
        summarize(r, end);
        p->summary.attempts = attempt;
        const double estimate = estimate_of(r), done = p->summary.done;
        if (status != AD_OK || (end != PATCHES_CONVERGED && end != PATCHES_INACCURATE) ||
            estimate <= tolerance) {
            break;
        }
        p->summary.end = time_over(r) ? PATCHES_TIME_OVER : PATCHES_INACCURATE;
        if (time_over(r) || (done == 1 && estimate > 0.5 * best)) {
            break;
        }
        if (done == 1) { /* the next may end before its time */
            best = estimate;
            drop_windows(&before);
            before = *p;
            p->window = NULL;
            p->count = p->room = 0;
        }
        /* errors grow with time at least as its square, if it is not over */
        r->local =
            fmax(1e-15, r->local * fmax(1e-3, fmin(0.2, 0.3 * tolerance * done * done / estimate)));
    }
    restore(p, &before);
    return status;
}

/* ---- the problem ----------------------------------------------------------------------------- */

static ad_status check_model(const physics_model *m, ad_error *error)
{
    ad_status status = model_check(m, error);
    if (status == AD_OK && (m->domain.count > PATCHES_COORDINATES_MAX || m->has_scene)) {
        status = ad_fail(
            error, AD_BAD_ARGUMENT, "model: %d coordinates%s; allowed: up to %d, without a scene",
            m->domain.count, m->has_scene ? " of a scene" : "", PATCHES_COORDINATES_MAX);
    }
    return status;
}

/* The highest order of derivatives of each output along each coordinate, by the equations inside.
 */
static void find_orders(patch_problem *p)
{
    for (int i = 0; i < p->law_count; i++) {
        const patch_law *law = &p->laws[i];
        p->linear = p->linear && law->linear;
        for (int k = 0; k < p->outputs * p->jets.count && law->set->points == MODEL_INTERIOR; k++) {
            for (int d = 0; d < p->dims && law->uses[k]; d++) {
                int *order = &p->order[k / p->jets.count][d];
                const int here = p->jets.order[k % p->jets.count][d];
                *order = here > *order ? here : *order;
            }
        }
    }
}

static ad_status record_laws(patch_problem *p, ad_error *error)
{
    const physics_model *m = p->model;
    bool inside = false, marches = m->domain.time >= 0 && p->unknowns == 0;
    for (int i = 0; i < m->set_count; i++) {
        bool used = false;
        for (int k = 0; k < m->term_count; k++) {
            used = used || (m->terms[k].set == i && m->terms[k].weight > 0);
        }
        if (!used) {
            continue;
        }
        ad_status status =
            patch_law_create(m, i, &p->jets, p->settings->pool, &p->laws[p->law_count], error);
        if (status != AD_OK) {
            return status;
        }
        p->law_count++;
        inside = inside || m->sets[i].points == MODEL_INTERIOR;
        if (marches && m->sets[i].holds[m->domain.time]) {
            marches = m->sets[i].value[m->domain.time] == m->domain.coordinates[m->domain.time].low;
        }
    }
    p->marches = marches;
    find_orders(p);
    return inside ? AD_OK
                  : ad_fail(error, AD_BAD_ARGUMENT, "model: no equation inside; it needs one");
}

ad_status patches_fit(const physics_model *m, const patches_settings *settings, patches **result,
                      ad_error *error)
{
    run *r = calloc(1, sizeof *r);
    *result = calloc(1, sizeof **result);
    if (!r || !*result) {
        free(r);
        free(*result);
        *result = NULL;
        return no_memory(error);
    }
    patch_problem *p = &r->problem;
    r->result = *result;
    r->began = seconds_now();
    (*result)->model = m;
    ad_status status = check_model(m, error);
    if (status == AD_OK) {
        status = ad_dense_load(error);
    }
    if (status == AD_OK) {
        p->model = m;
        p->settings = settings;
        p->dims = m->domain.count;
        p->outputs = m->outputs;
        p->unknowns = m->own_unknown_count;
        p->linear = true;
        for (int f = 0; f < PATCH_OUTPUTS; f++) {
            p->scale[f] = 1;
        }
        patch_jets_fill(&p->jets, p->dims);
        status = record_laws(p, error);
    }
    if (status == AD_OK) {
        status = fit(r, error);
    }
    for (int i = 0; i < p->law_count; i++) {
        patch_law_clear(&p->laws[i]);
    }
    for (int d = 0; d < PATCH_DIMS; d++) {
        free(r->edges[d]);
    }
    free(r);
    if (status != AD_OK) {
        patches_free(*result);
        *result = NULL;
    }
    return status;
}

/* ---- as numbers ------------------------------------------------------------------------------ */

/* Summary, windows; of a window its two grids; of a grid cells, degrees, edges, coefficients. */
static double *put_grid(const patch_grid *grid, double *to)
{
    for (int d = 0; d < grid->dims; d++) {
        *to++ = grid->cells[d];
        *to++ = grid->degree[d];
        memcpy(to, grid->edge[d], ((size_t)grid->cells[d] + 1) * sizeof *to);
        to += grid->cells[d] + 1;
    }
    const size_t numbers = (size_t)grid->patches * patch_grid_size(grid);
    memcpy(to, grid->c, numbers * sizeof *to);
    return to + numbers;
}

enum { SUMMARY_PLAIN = 11, SUMMARY_NUMBERS = SUMMARY_PLAIN + 2 * MODEL_UNKNOWNS_MAX };

size_t patches_numbers(const patches *p)
{
    size_t count = SUMMARY_NUMBERS + 1;
    for (int i = 0; i < p->count; i++) {
        const patch_grid *grids[] = {&p->window[i].found, &p->window[i].richer};
        for (int k = 0; k < 2; k++) {
            count += (size_t)grids[k]->patches * patch_grid_size(grids[k]);
            for (int d = 0; d < grids[k]->dims; d++) {
                count += 3 + (size_t)grids[k]->cells[d];
            }
        }
    }
    return count;
}

void patches_write(const patches *p, double *numbers)
{
    const patches_summary *s = &p->summary;
    double *to = numbers;
    const double plain[SUMMARY_PLAIN] = {
        s->end,     s->estimate,     s->by_unknowns,        s->done,  s->seconds, s->attempts,
        s->windows, s->most_patches, (double)s->parameters, s->steps, s->unknowns};
    memcpy(to, plain, sizeof plain);
    memcpy(to + SUMMARY_PLAIN, s->unknown, sizeof s->unknown);
    memcpy(to + SUMMARY_PLAIN + MODEL_UNKNOWNS_MAX, s->deviation, sizeof s->deviation);
    to[SUMMARY_NUMBERS] = p->count;
    to += SUMMARY_NUMBERS + 1;
    for (int i = 0; i < p->count; i++) {
        to = put_grid(&p->window[i].richer, put_grid(&p->window[i].found, to));
    }
}

/* Takes a grid from *from up to `end`; false: it is not one. */
static bool take_grid(const physics_model *m, const double **from, const double *end,
                      patch_grid *grid, bool *has_memory)
{
    const double *at = *from;
    int cells[PATCH_DIMS], degree[PATCH_DIMS];
    double *edges[PATCH_DIMS];
    for (int d = 0; d < m->domain.count; d++) {
        if (end - at < 4 || !(at[0] >= 1 && at[0] <= 1e6 && at[1] >= 0 && at[1] <= PATCH_DEGREE) ||
            end - at < 3 + (ptrdiff_t)at[0]) {
            return false;
        }
        cells[d] = (int)at[0];
        degree[d] = (int)at[1];
        edges[d] = (double *)at + 2; /* only read */
        at += 3 + cells[d];
        for (int i = 0; i < cells[d]; i++) {
            if (!(edges[d][i] < edges[d][i + 1])) {
                return false;
            }
        }
    }
    size_t numbers = (size_t)m->outputs;
    for (int d = 0; d < m->domain.count; d++) {
        numbers *= (size_t)cells[d] * (size_t)(degree[d] + 1);
        if (numbers > (size_t)(end - at)) {
            return false;
        }
    }
    *has_memory = patch_grid_create(grid, m->domain.count, m->outputs, cells, edges, degree);
    if (*has_memory) {
        memcpy(grid->c, at, numbers * sizeof *grid->c);
    }
    *from = at + numbers;
    return true;
}

static void take_summary(const double *from, patches_summary *s)
{
    *s = (patches_summary){.end = (patches_end)from[0],
                           .estimate = from[1],
                           .by_unknowns = from[2],
                           .done = from[3],
                           .seconds = from[4],
                           .attempts = (int)from[5],
                           .windows = (int)from[6],
                           .most_patches = (int)from[7],
                           .parameters = (size_t)from[8],
                           .steps = (int)from[9],
                           .unknowns = (int)from[10]};
    memcpy(s->unknown, from + SUMMARY_PLAIN, sizeof s->unknown);
    memcpy(s->deviation, from + SUMMARY_PLAIN + MODEL_UNKNOWNS_MAX, sizeof s->deviation);
}

ad_status patches_read(const physics_model *m, size_t count, const double *numbers,
                       patches **result, ad_error *error)
{
    const double *from = numbers + SUMMARY_NUMBERS + 1, *end = numbers + count;
    patches *p = *result = calloc(1, sizeof **result);
    bool sound = p && count > SUMMARY_NUMBERS && numbers[0] >= 0 &&
                 numbers[0] < PATCHES_END_COUNT && numbers[10] >= 0 &&
                 numbers[10] <= MODEL_UNKNOWNS_MAX && numbers[SUMMARY_NUMBERS] >= 0 &&
                 numbers[SUMMARY_NUMBERS] <= 1e7;
    bool has_memory = p != NULL;
    const int windows = sound ? (int)numbers[SUMMARY_NUMBERS] : 0;
    if (sound) {
        p->model = m;
        take_summary(numbers, &p->summary);
    }
    for (int i = 0; i < windows && sound && has_memory; i++) {
        patch_grid found = {.dims = 0}, richer = {.dims = 0};
        sound = take_grid(m, &from, end, &found, &has_memory) && has_memory &&
                take_grid(m, &from, end, &richer, &has_memory);
        has_memory = has_memory && (!sound || keep_window(p, &found, &richer));
        patch_grid_clear(&found);
        patch_grid_clear(&richer);
    }
    if (sound && has_memory && from == end) {
        return AD_OK;
    }
    patches_free(p);
    *result = NULL;
    return has_memory ? ad_fail(error, AD_BAD_INPUT,
                                "these numbers are not of a solution of this model; allowed: what "
                                "was written for the same coordinates and fields")
                      : no_memory(error);
}

/* ---- values ---------------------------------------------------------------------------------- */

void patches_evaluate(const patches *p, int row, const int *orders, size_t count,
                      const double *const *x, double *values, double *errors)
{
    const domain *domain = &p->model->domain;
    const int time = domain->time;
    double scale = 1;
    for (int d = 0; d < domain->count; d++) {
        scale *= pow(domain->coordinates[d].scale, -orders[d]);
    }
    for (size_t i = 0; i < count; i++) {
        double at[PATCH_DIMS];
        bool within = p->count > 0;
        for (int d = 0; d < domain->count; d++) {
            const domain_coordinate *c = &domain->coordinates[d];
            const double range = c->high - c->low, slack = 1e-12 * range;
            at[d] = x[d][i] / c->scale;
            if (c->periodic) {
                at[d] -= range * floor((at[d] - c->low) / range);
            }
            within = within && at[d] >= c->low - slack && at[d] <= c->high + slack;
        }
        int low = 0, high = p->count;
        while (high - low > 1) {
            const int middle = (low + high) / 2;
            if (at[time] > p->window[middle].found.edge[time][0]) {
                low = middle;
            } else {
                high = middle;
            }
        }
        if (within && time >= 0) {
            const patch_grid *last = &p->window[p->count - 1].found;
            within = at[time] <= last->edge[time][last->cells[time]] * (1 + 1e-12) + 1e-300;
        }
        const solved *here = within ? &p->window[low] : NULL;
        values[i] = here ? scale * patch_grid_at(&here->found, row, orders, at) : NAN;
        if (errors) {
            errors[i] =
                here ? fabs(scale * patch_grid_at(&here->richer, row, orders, at) - values[i])
                     : NAN;
        }
    }
}
