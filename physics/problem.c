/* The loss as a sum over point sets; each set has its points and one program. */
#include "physics/problem_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- making -------------------------------------------------------------------------------- */

static double weight_of(const problem_settings *settings, rod_residual_kind kind)
{
    switch (kind) {
    case ROD_STRAIN:
        return settings->strain_weight;
    case ROD_CURVATURE:
        return settings->curvature_weight;
    case ROD_FORCE:
        return settings->force_weight;
    case ROD_MOMENT:
        return settings->moment_weight;
    case ROD_INITIAL:
        return settings->initial_weight;
    default:
        return settings->boundary_weight;
    }
}

/* The terms of a set are those residuals that the scene has and that carry weight. */
static void list_terms(problem *p, problem_set *set)
{
    static const struct {
        problem_set_kind kind;
        rod_residual_kind first, last;
    } owned[] = {{SET_INTERIOR, ROD_STRAIN, ROD_MOMENT},
                 {SET_START, ROD_START, ROD_START},
                 {SET_END, ROD_END, ROD_END},
                 {SET_INITIAL, ROD_INITIAL, ROD_INITIAL}};
    for (int kind = (int)owned[set->kind].first; kind <= (int)owned[set->kind].last; kind++) {
        double weight = weight_of(&p->settings, (rod_residual_kind)kind);
        if (p->model->residual_rows(&p->scene, (rod_residual_kind)kind) > 0 && weight > 0) {
            p->terms[p->term_count] = (problem_term){(rod_residual_kind)kind, weight};
            set->terms[set->term_count++] = p->term_count++;
        }
    }
}

static ad_status make_set(problem *p, problem_set_kind kind, ad_error *error)
{
    problem_set *set = &p->sets[p->set_count];
    *set = (problem_set){.kind = kind};
    list_terms(p, set);
    if (set->term_count == 0) {
        return AD_OK;
    }
    p->set_count++;
    ad_status status = problem_set_sample(p, set, error);
    return status == AD_OK ? problem_set_build(p, set, error) : status;
}

problem_settings problem_settings_default(void)
{
    static const double epsilons[] = {0.01, 0.1, 1, 10, 100};
    const problem_points points = {256, SAMPLING_SOBOL, 0};
    problem_settings settings = {.interior = points, .boundary = points, .initial = points};
    /* Errors of the first two add up along s. The rows of shear and stretch are strains, not
     * forces, so no weight has to follow the slenderness (tests/test_slender.c). */
    settings.strain_weight = 1000;
    settings.curvature_weight = 100;
    settings.force_weight = settings.moment_weight = 1;
    settings.boundary_weight = settings.initial_weight = 1;
    settings.held_out_points = 256;
    settings.causal_epsilon_count = sizeof epsilons / sizeof *epsilons;
    memcpy(settings.causal_epsilon, epsilons, sizeof epsilons);
    settings.causal_threshold = 0.99;
    settings.causal_update_every = 50;
    settings.balance_every = 100;
    settings.balance_memory = 0.9;
    return settings;
}

const char *problem_settings_check(const problem_settings *settings, const scene *scene)
{
    const problem_points *sets[] = {&settings->interior, &settings->boundary, &settings->initial};
    const double weights[] = {settings->strain_weight,   settings->curvature_weight,
                              settings->force_weight,    settings->moment_weight,
                              settings->boundary_weight, settings->initial_weight};
    for (int i = 0; i < 3; i++) {
        if (sets[i]->points < 1 || sets[i]->resample_every < 0) {
            return "points: at least 1, resample_every: at least 0";
        }
    }
    for (int i = 0; i < 6; i++) {
        if (!(weights[i] >= 0 && isfinite(weights[i]))) {
            return "weights: finite and at least 0";
        }
    }
    if (settings->held_out_points < 1) {
        return "held_out_points: at least 1";
    }
    return problem_weights_check(settings, scene);
}

static void clear_sets(problem *p)
{
    for (int i = 0; i < SET_COUNT; i++) {
        problem_set_clear(&p->sets[i]);
    }
    memset(p->sets, 0, sizeof p->sets);
    p->set_count = p->term_count = 0;
    p->derivatives[0] = '\0';
}

ad_status problem_create(const scene *scene, const nn_mlp *mlp, const problem_settings *settings,
                         uint64_t seed, ad_pool *pool, problem **result, ad_error *error)
{
    *result = NULL;
    const char *wrong = problem_settings_check(settings, scene);
    if (wrong) {
        return ad_fail(error, AD_BAD_ARGUMENT, "problem settings: %s", wrong);
    }
    problem *p = calloc(1, sizeof *p);
    if (!p) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a problem");
    }
    p->scene = *scene;
    p->model = model_of(scene);
    p->settings = *settings;
    p->mlp = mlp;
    p->pool = pool;
    p->seed = seed;
    p->parameters = nn_mlp_parameters(mlp);
    p->scratch = malloc((p->parameters + 1) * sizeof *p->scratch);
    rod_scales scales = rod_scales_of(scene);
    p->length = scales.length;
    p->time = scales.time;
    const rod_window first = {0, NULL};
    ad_status status = p->scratch && problem_weights_create(p)
                           ? problem_enter(p, &first, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a problem");
    if (status != AD_OK) {
        problem_free(p);
        return status;
    }
    *result = p;
    return AD_OK;
}

ad_status problem_enter(problem *p, const rod_window *window, ad_error *error)
{
    clear_sets(p);
    p->window = *window;
    p->start = rod_window_time(&p->scene, window->index);
    p->end = rod_window_time(&p->scene, window->index + 1);
    problem_weights_start(p);
    ad_status status = AD_OK;
    for (int kind = 0; status == AD_OK && kind < SET_COUNT; kind++) {
        status = make_set(p, (problem_set_kind)kind, error);
    }
    if (status == AD_OK && p->set_count == 0) {
        status = ad_fail(error, AD_BAD_INPUT, "every loss term has weight 0: nothing to learn");
    }
    if (status == AD_OK && p->sets[0].kind != SET_INTERIOR) {
        p->settings.causal_slices = 0; /* nothing inside to be weighted */
    }
    problem_weights_spread(p);
    return status;
}

ad_status problem_load(problem *p, double part, ad_error *error)
{
    const rod_window window = p->window;
    p->scene.loads.part = part;
    return problem_enter(p, &window, error);
}

void problem_free(problem *p)
{
    if (!p) {
        return;
    }
    clear_sets(p);
    free(p->scratch);
    free(p->pair);
    problem_weights_free(p);
    free(p);
}

/* ---- what there is --------------------------------------------------------------------------- */

size_t problem_parameters(const problem *p)
{
    return p->parameters;
}

int problem_terms(const problem *p)
{
    return p->term_count;
}

const char *problem_term_name(const problem *p, int term)
{
    return rod_residual_name(p->terms[term].kind);
}

double problem_term_weight(const problem *p, int term)
{
    return p->terms[term].weight;
}

const double *problem_losses(const problem *p)
{
    return p->losses;
}

int problem_sets(const problem *p)
{
    return p->set_count;
}

problem_set_info problem_set_inspect(const problem *p, int set)
{
    const problem_set *s = &p->sets[set];
    problem_set_info info = {.name = problem_set_names[s->kind],
                             .points = s->trained.count,
                             .held_out = s->held_out.count,
                             .tape = s->counts,
                             .program = ad_program_inspect(s->gradient),
                             .fixed_rows = s->gradient_fixed.rows};
    if (s->gradient_fixed.program) {
        info.fixed_instructions = ad_program_inspect(s->gradient_fixed.program).instructions;
    }
    return info;
}

const char *problem_derivatives(const problem *p)
{
    return p->derivatives;
}

size_t problem_bytes(const problem *p)
{
    enum { LEAST_CHUNKS = 8 }; /* each sums for itself; more only for very many points */
    size_t bytes = 2 * p->parameters * sizeof(double);
    int threads = ad_pool_threads(p->pool);
    for (int i = 0; i < p->set_count; i++) {
        const problem_set *s = &p->sets[i];
        const ad_program *programs[3] = {s->gradient, s->value, s->gradient_fixed.program};
        bytes += 2 * (s->trained.count + s->held_out.count) * sizeof(double);
        bytes += problem_weights_per_point(s) * s->trained.count * sizeof(double);
        bytes += (size_t)s->gradient_fixed.rows * s->trained.count * sizeof(double);
        for (int k = 0; k < 3 && programs[k]; k++) {
            ad_program_info info = ad_program_inspect(programs[k]);
            bytes += (size_t)threads * info.workspace_bytes;
            bytes += LEAST_CHUNKS * info.reduced * sizeof(double);
        }
    }
    return bytes;
}

/* ---- evaluating ------------------------------------------------------------------------------ */

/* The trained points through the program with the gradient; adds to *loss and gradient. */
static ad_status evaluate_set(problem *p, problem_set *set, const double *x, bool first,
                              double *loss, double *gradient, ad_error *error)
{
    double *to = !gradient ? NULL : first ? gradient : p->scratch;
    double total = 0;
    ad_status status =
        problem_set_run(set, set->gradient, &set->trained, x, p->losses, &total, to, error);
    if (status == AD_OK && gradient && !first) {
        for (size_t i = 0; i < p->parameters; i++) {
            gradient[i] += p->scratch[i];
        }
    }
    *loss += total;
    return status;
}

bool problem_all_finite(const double *x, size_t count)
{
    double sum = 0; /* 0 * x is NaN for NaN and infinity alike */
    for (size_t i = 0; i < count; i++) {
        sum += 0 * x[i];
    }
    return sum == 0;
}

ad_status problem_evaluate(problem *p, const double *x, double *loss, double *gradient,
                           ad_error *error)
{
    *loss = 0;
    for (int i = 0; i < p->set_count; i++) {
        ad_status status = evaluate_set(p, &p->sets[i], x, i == 0, loss, gradient, error);
        if (status != AD_OK) {
            return status;
        }
    }
    if (!isfinite(*loss) || (gradient && !problem_all_finite(gradient, p->parameters))) {
        return ad_fail(error, AD_NOT_FINITE, "the loss or its gradient is not finite");
    }
    return AD_OK;
}

problem_set *problem_set_of_term(problem *p, int term)
{
    for (int i = 0; i < p->set_count; i++) {
        for (int k = 0; k < p->sets[i].term_count; k++) {
            if (p->sets[i].terms[k] == term) {
                return &p->sets[i];
            }
        }
    }
    return NULL;
}

ad_status problem_evaluate_term(problem *p, int term, const double *x, double *loss,
                                double *gradient, ad_error *error)
{
    problem_set *set = problem_set_of_term(p, term);
    return problem_set_run_term(p, set, term, false, x, loss, gradient, error);
}

ad_status problem_held_out(problem *p, const double *x, double *loss, double *terms,
                           ad_error *error)
{
    double values[PROBLEM_TERMS];
    *loss = 0;
    for (int i = 0; i < p->set_count; i++) {
        problem_set *set = &p->sets[i];
        double total;
        ad_status status = problem_set_run(set, set->value, &set->held_out, x,
                                           terms ? terms : values, &total, NULL, error);
        if (status != AD_OK) {
            return status;
        }
        *loss += total;
    }
    return AD_OK;
}

ad_status problem_locate(problem *p, const double *x, problem_place *place, ad_error *error)
{
    *place = (problem_place){.term = -1};
    for (int i = 0; i < p->set_count && place->term < 0; i++) {
        ad_status status = problem_set_locate(p, &p->sets[i], x, place, error);
        if (status != AD_OK) {
            return status;
        }
    }
    return AD_OK;
}

/* ---- points over time ------------------------------------------------------------------------ */

ad_status problem_advance(problem *p, int64_t step, bool *changed, ad_error *error)
{
    *changed = false;
    if (p->settings.causal_slices && step > 1 &&
        (step - 1) % p->settings.causal_update_every == 0) {
        problem_weights_follow_time(p);
        *changed = true;
    }
    for (int i = 0; i < p->set_count; i++) {
        int every = problem_points_of(p, &p->sets[i])->resample_every;
        if (every > 0 && step > 1 && (step - 1) % every == 0) {
            ad_status status = problem_set_resample(p, &p->sets[i], error);
            if (status != AD_OK) {
                return status;
            }
            *changed = true;
            problem_weights_spread(p);
        }
    }
    return AD_OK;
}

/* ---- state ----------------------------------------------------------------------------------- */

int problem_state(problem *p, problem_array *arrays, problem_generator *generators,
                  int *generator_count)
{
    static const char *const points[SET_COUNT] = {"points/interior", "points/start", "points/end",
                                                  "points/initial"};
    int count = 0;
    *generator_count = 0;
    for (int i = 0; i < p->set_count; i++) {
        problem_set *set = &p->sets[i];
        arrays[count++] = (problem_array){points[set->kind], set->trained.s, 2, set->trained.count};
        generators[(*generator_count)++] =
            (problem_generator){problem_set_names[set->kind], &set->rng};
    }
    return count + problem_weights_state(p, arrays + count);
}

ad_status problem_restored(problem *p, ad_error *error)
{
    for (int i = 0; i < p->set_count; i++) {
        const problem_cloud *c = &p->sets[i].trained;
        p->sets[i].gradient_fixed.stale = p->sets[i].normal_fixed.stale = true;
        p->sets[i].product_fixed.stale = true;
        for (size_t k = 0; k < c->count; k++) {
            if (!(c->s[k] >= 0 && c->s[k] <= 1 && c->t[k] >= p->start && c->t[k] <= p->end)) {
                return ad_fail(error, AD_BAD_INPUT, "checkpoint: a point lies outside the scene");
            }
        }
    }
    return problem_weights_restored(p, error);
}
