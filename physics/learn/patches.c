#include "physics/learn/patches.h"

#include "autodiff/dense.h"
#include "physics/learn/patches_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *patches_end_word(patches_end end)
{
#define PATCHES_END_WORD(code, word) word,
    static const char *const words[] = {PATCHES_END_LIST(PATCHES_END_WORD)};
    return words[end];
}

void patches_free(patches *p)
{
    if (p) {
        patches_drop(p);
        free(p);
    }
}

patches_summary patches_summarize(const patches *p)
{
    return p->summary;
}

/* ---- attempts -------------------------------------------------------------------------------- */

static void summarize(patch_run *r, patches_end end)
{
    patches *p = r->result;
    patches_summary *s = &p->summary;
    s->end = end;
    s->by_unknowns = patch_relative(r, r->varied);
    s->estimate = p->count > 0 ? hypot(patch_estimate(r), s->by_unknowns) : INFINITY;
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
    s->seconds = patch_now() - r->began;
}

/* A run that ended early gives way to one before it that covered all of time. */
static void restore(patches *p, patches *before)
{
    const int attempts = p->summary.attempts;
    const patches_end end = p->summary.end;
    if (before->count > 0 && p->summary.done < 1) {
        patches_drop(p);
        *p = *before;
        p->summary.end = end;
        p->summary.attempts = attempts;
        before->count = 0;
        before->window = NULL;
    }
    patches_drop(before);
}

static ad_status fit(patch_run *r, ad_error *error)
{
    const double tolerance = r->problem.settings->tolerance;
    patches *p = r->result, before = {.count = 0};
    double best = INFINITY;
    ad_status status = AD_OK;
    r->local = 3 * tolerance;
    for (int attempt = 1; attempt <= PATCH_ATTEMPTS; attempt++) {
        patches_end end;
        status = r->problem.unknowns > 0 ? patch_identify(r, attempt, &end, error)
                                         : patch_march(r, attempt, &end, error);
        summarize(r, end);
        p->summary.attempts = attempt;
        const double estimate = patch_estimate(r), done = p->summary.done;
        if (status != AD_OK || (end != PATCHES_CONVERGED && end != PATCHES_INACCURATE) ||
            estimate <= tolerance) {
            break;
        }
        p->summary.end = patch_is_late(&r->problem) ? PATCHES_TIME_OVER : PATCHES_INACCURATE;
        if (patch_is_late(&r->problem) || (done == 1 && estimate > 0.5 * best)) {
            break;
        }
        if (done == 1) { /* the next may end before its time */
            best = estimate;
            patches_drop(&before);
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
    } else if (status == AD_OK && model_has_ansatz(m)) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "model: has an ansatz of its own; allowed: conditions on faces");
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
    bool inside = false, marches = m->domain.time >= 0;
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
    patch_run *r = calloc(1, sizeof *r);
    *result = calloc(1, sizeof **result);
    if (!r || !*result) {
        free(r);
        free(*result);
        *result = NULL;
        return patch_no_memory(error);
    }
    patch_problem *p = &r->problem;
    r->result = *result;
    r->began = patch_now();
    (*result)->model = m;
    ad_status status = check_model(m, error);
    if (status == AD_OK) {
        status = ad_dense_load(error);
    }
    if (status == AD_OK) {
        p->model = m;
        p->settings = settings;
        p->deadline = r->began + settings->seconds;
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
    for (int i = 0; i < p->unknowns && status == AD_OK; i++) {
        p->unknown[i] = m->own_unknowns[i].guess;
    }
    if (status == AD_OK && !patch_look(p, &r->panels)) {
        status = patch_no_memory(error);
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
        values[i] =
            here ? scale * patch_grid_at(&here->found, here->found.c, row, orders, at) : NAN;
        if (errors) {
            errors[i] =
                here ? fabs(scale * patch_grid_at(&here->richer, here->richer.c, row, orders, at) -
                            values[i])
                     : NAN;
        }
    }
}
