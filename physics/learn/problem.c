/* The loss as a sum over point sets; each set has its points and one program. */
#include "physics/learn/problem_internal.h"

#include "physics/numerics/vector_size.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- making -------------------------------------------------------------------------------- */

/* The terms of a set are those that carry weight. */
static void list_terms(problem *p, problem_set *set, int number)
{
    for (int i = 0; i < p->model->term_count && set->term_count < PROBLEM_SET_TERMS; i++) {
        const model_term *term = &p->model->terms[i];
        if (term->set == number && term->weight > 0) {
            p->terms[p->term_count] = term;
            set->terms[set->term_count++] = p->term_count++;
        }
    }
}

static ad_status make_set(problem *p, int number, ad_error *error)
{
    problem_set *set = &p->sets[p->set_count];
    *set = (problem_set){.about = &p->model->sets[number], .problem = p};
    list_terms(p, set, number);
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
    settings.adaptive = (problem_adaptive){.every = 100, .power = 1, .floor = 1, .width = 0.02};
    settings.held_out_points = 256;
    settings.causal_epsilon_count = sizeof epsilons / sizeof *epsilons;
    memcpy(settings.causal_epsilon, epsilons, sizeof epsilons);
    settings.causal_threshold = 0.99;
    settings.causal_update_every = 50;
    settings.balance_every = 100;
    settings.balance_memory = 0.9;
    return settings;
}

const char *problem_settings_check(const problem_settings *settings, const physics_model *m)
{
    const problem_points *sets[] = {&settings->interior, &settings->boundary, &settings->initial};
    for (int i = 0; i < 3; i++) {
        if (sets[i]->points < 1 || sets[i]->resample_every < 0) {
            return "points: at least 1, resample_every: at least 0";
        }
    }
    if (settings->held_out_points < 1) {
        return "held_out_points: at least 1";
    }
    const char *wrong = problem_adaptive_check(settings);
    return wrong ? wrong : problem_weights_check(settings, m);
}

static void clear_sets(problem *p)
{
    for (int i = 0; i < MODEL_SETS_MAX; i++) {
        problem_set_clear(&p->sets[i]);
    }
    memset(p->sets, 0, sizeof p->sets);
    p->set_count = p->term_count = 0;
    p->derivatives[0] = '\0';
}

static ad_status make_panels(problem *p, ad_error *error)
{
    const scene *of = &p->model->scene;
    if (!p->model->has_scene || scene_is_manufactured(of)) {
        return AD_OK;
    }
    ad_status status = scene_panels_of(of, "s", &p->panels[0], error);
    return status == AD_OK && scene_is_dynamic(of) ? scene_panels_of(of, "t", &p->panels[1], error)
                                                   : status;
}

ad_status problem_create(const physics_model *m, const nn_mlp *mlp,
                         const problem_settings *settings, uint64_t seed, ad_pool *pool,
                         problem **result, ad_error *error)
{
    *result = NULL;
    ad_status sound = model_check(m, error);
    for (int i = 0; i < m->domain.count && sound == AD_OK; i++) {
        if ((m->domain.coordinates[i].periodic && !m->call.input) || m->own_unknown_count > 0) {
            sound = ad_fail(error, AD_BAD_ARGUMENT,
                            "model: periodic coordinates and unknown numbers; allowed: with "
                            "patches_fit; periodic ones with model_for_network, too");
        }
    }
    const char *wrong = sound == AD_OK ? problem_settings_check(settings, m) : NULL;
    if (sound != AD_OK || wrong) {
        return sound != AD_OK ? sound
                              : ad_fail(error, AD_BAD_ARGUMENT, "problem settings: %s", wrong);
    }
    problem *p = calloc(1, sizeof *p);
    if (!p) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a problem");
    }
    p->model = m;
    p->settings = *settings;
    p->mlp = mlp;
    p->pool = pool;
    p->seed = seed;
    p->setting.load_factor = 1;
    p->parameters = nn_mlp_parameters(mlp);
    p->released = m->scene.unknown_count == 0;
    p->scratch = malloc((p->parameters + 1) * sizeof *p->scratch);
    ad_status status = p->scratch && problem_weights_create(p)
                           ? make_panels(p, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a problem");
    status = status == AD_OK ? problem_enter(p, 0, NULL, error) : status;
    if (status != AD_OK) {
        problem_free(p);
        return status;
    }
    *result = p;
    return AD_OK;
}

/* The sets of a window whose programs are not there yet; those of all of the domain come first, for
 * causal weights. */
static ad_status make_sets(problem *p, ad_error *error)
{
    ad_status status = AD_OK;
    int count = p->model->set_count;
    clear_sets(p);
    for (int i = 0; status == AD_OK && i < 2 * count; i++) {
        bool inside = p->model->sets[i % count].points == MODEL_INTERIOR;
        status = inside == (i < count) ? make_set(p, i % count, error) : AD_OK;
    }
    if (status == AD_OK && (p->set_count == 0 || p->sets[0].about->points != MODEL_INTERIOR)) {
        p->settings.causal_slices = 0; /* nothing inside to be weighted */
    }
    return status;
}

ad_status problem_enter(problem *p, int window, const double *start, ad_error *error)
{
    bool has_programs = p->set_count > 0 && (window > 0) == (p->window > 0);
    ad_status status = AD_OK;
    p->window = window;
    p->kinds = model_uniforms(p->model, window);
    p->setting = domain_setting_of(&p->model->domain, window, start, p->setting.load_factor);
    problem_weights_start(p);
    if (!has_programs) {
        status = make_sets(p, error);
    }
    for (int i = 0; status == AD_OK && has_programs && i < p->set_count; i++) {
        status = problem_set_sample(p, &p->sets[i], error);
    }
    problem_weights_spread(p);
    return status;
}

void problem_load(problem *p, double factor)
{
    p->setting.load_factor = factor;
    for (int i = 0; i < p->set_count; i++) {
        problem_set_refresh(&p->sets[i]);
    }
}

problem_compilations problem_compiled(const problem *p)
{
    return p->compiled;
}

void problem_free(problem *p)
{
    if (!p) {
        return;
    }
    clear_sets(p);
    scene_panels_free(&p->panels[0]);
    scene_panels_free(&p->panels[1]);
    free(p->scratch);
    free(p->pair);
    motion_network_free(p->motion);
    free(p->motion_room);
    free(p->motion_blocks);
    problem_weights_free(p);
    free(p);
}

/* ---- what there is --------------------------------------------------------------------------- */

size_t problem_parameters(const problem *p)
{
    return p->parameters;
}

int problem_views(const problem *p, const nn_view **views)
{
    return nn_mlp_views(p->mlp, views);
}

int problem_terms(const problem *p)
{
    return p->term_count;
}

const char *problem_term_name(const problem *p, int term)
{
    return p->terms[term]->name;
}

double problem_term_weight(const problem *p, int term)
{
    return p->terms[term]->weight;
}

bool problem_term_is_held_out(const problem *p, int term)
{
    return problem_set_of_term((problem *)p, term)->held_out.count > 0;
}

const char *problem_unresolved(const problem *p)
{
    return p->panels[0].unresolved ? p->panels[0].unresolved : p->panels[1].unresolved;
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
    problem_set_info info = {.name = s->about->name,
                             .points = s->trained.count,
                             .held_out = s->held_out.count,
                             .tape = s->counts,
                             .fixed_rows = s->gradient_fixed.rows};
    if (s->gradient) {
        info.program = ad_program_inspect(s->gradient);
    }
    if (s->gradient_fixed.program) {
        info.fixed_instructions = ad_program_inspect(s->gradient_fixed.program).instructions;
    }
    return info;
}

void problem_print(const problem *p, FILE *file)
{
    for (int i = 0; i < p->set_count; i++) {
        const problem_set *s = &p->sets[i];
        const struct {
            const char *what;
            const ad_program *program;
        } programs[] = {{"once for a set of points", s->gradient_fixed.program},
                        {"loss and gradient", s->gradient},
                        {"losses", s->value},
                        {"products with J^T J", s->product}};
        for (size_t k = 0; k < sizeof programs / sizeof *programs; k++) {
            if (programs[k].program) {
                fprintf(file, "== %s: %s\n", s->about->name, programs[k].what);
                ad_program_print(programs[k].program, file);
            }
        }
        if (s->normal) {
            fprintf(file, "== %s: rows of J\n", s->about->name);
            ad_normal_print(s->normal, file);
        }
    }
}

enum { FUSED_PER_SET = 3 };

/* Of a set, those that steps run: [FUSED_PER_SET], NULL where there is none. */
static void list_programs(const problem_set *s, ad_program **programs)
{
    programs[0] = s->gradient;
    programs[1] = s->product;
    programs[2] = s->normal ? ad_normal_program(s->normal) : NULL;
}

ad_status problem_fuse(problem *p, const char *folder, problem_fuse_way way, problem_fusing *state,
                       ad_error *error)
{
    ad_status first = AD_OK;
    bool busy = false;
    *state = (problem_fusing){0};
    for (int i = 0; i < p->set_count * FUSED_PER_SET; i++) {
        ad_program *programs[FUSED_PER_SET];
        const problem_set *s = &p->sets[i / FUSED_PER_SET];
        list_programs(s, programs);
        ad_program *now = programs[i % FUSED_PER_SET];
        if (!now) {
            continue;
        }
        ad_error *to = first == AD_OK ? error : NULL;
        ad_fuse_state is = AD_INTERPRETED;
        ad_status status =
            ad_fuse_begin(now, s->trained.count, 1, folder, way != PROBLEM_FUSE_KEPT && !busy, to);
        status = status == AD_OK ? ad_fuse_finish(now, way == PROBLEM_FUSE_WAIT, &is, to) : status;
        first = first == AD_OK ? status : first;
        busy = busy || is == AD_FUSING;
        state->programs++;
        state->fused += is == AD_FUSED;
    }
    return first;
}

const char *problem_derivatives(const problem *p)
{
    return p->derivatives;
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

bool problem_holds_unknowns(const problem *p)
{
    return p->released == 0;
}

void problem_release_unknowns(problem *p)
{
    p->released = 1;
}

bool problem_is_held(const problem *p, const problem_set *set)
{
    return problem_holds_unknowns(p) && set->about->points == MODEL_GIVEN;
}

size_t problem_first_held(const problem *p)
{
    return p->parameters - (problem_holds_unknowns(p) ? (size_t)p->model->scene.unknown_count : 0);
}

ad_status problem_evaluate(problem *p, const double *x, double *loss, double *gradient,
                           ad_error *error)
{
    *loss = 0;
    for (int i = 0; i < p->set_count; i++) {
        if (problem_is_held(p, &p->sets[i])) {
            for (int k = 0; k < p->sets[i].term_count; k++) {
                p->losses[p->sets[i].terms[k]] = 0;
            }
            continue;
        }
        ad_status status = evaluate_set(p, &p->sets[i], x, i == 0, loss, gradient, error);
        if (status != AD_OK) {
            return status;
        }
    }
    for (size_t i = problem_first_held(p); gradient && i < p->parameters; i++) {
        gradient[i] = 0;
    }
    if (!isfinite(*loss) || (gradient && !vector_is_finite(p->parameters, gradient))) {
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
        double total, *to = terms ? terms : values;
        for (int k = 0; k < set->term_count; k++) {
            to[set->terms[k]] = 0;
        }
        if (set->held_out.count == 0) {
            continue;
        }
        ad_status status =
            problem_set_run(set, set->value, &set->held_out, x, to, &total, NULL, error);
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

/* New points of a set where they are due, and data for them. */
static ad_status advance_set(problem *p, problem_set *set, int64_t step, const double *x,
                             bool *changed, ad_error *error)
{
    int every = problem_points_of(p, set).resample_every;
    bool due = every > 0 && step > 1 && (step - 1) % every == 0;
    bool moves = problem_set_adapts(p, set, step);
    ad_status status = due     ? problem_set_resample(p, set, error)
                       : moves ? problem_set_adapt(p, set, step, x, error)
                               : AD_OK;
    due = due || moves;
    if (due) {
        problem_weights_spread(p);
    }
    if (status == AD_OK && (due || problem_set_follows(set))) {
        status = problem_set_supply(p, set, x, error);
        *changed = true;
    }
    return status;
}

ad_status problem_advance(problem *p, int64_t step, const double *x, bool *changed, ad_error *error)
{
    *changed = false;
    if (p->settings.causal_slices && step > 1 &&
        (step - 1) % p->settings.causal_update_every == 0) {
        problem_weights_follow_time(p);
        *changed = true;
    }
    ad_status status = AD_OK;
    for (int i = 0; i < p->set_count && status == AD_OK; i++) {
        status = advance_set(p, &p->sets[i], step, x, changed, error);
    }
    return status;
}

/* ---- state ----------------------------------------------------------------------------------- */

int problem_state(problem *p, problem_array *arrays, problem_generator *generators,
                  int *generator_count)
{
    int count = 0;
    *generator_count = 0;
    for (int i = 0; i < p->set_count; i++) {
        problem_set *set = &p->sets[i];
        problem_array *points = &arrays[count++];
        const model_source *source = &set->about->source;
        const bool given = set->about->points == MODEL_GIVEN && source->draw_every == 0,
                   drawn = set->about->points != MODEL_GIVEN && !source->fill;
        *points = (problem_array){.data = set->trained.x,
                                  .rows = (size_t)p->model->domain.count,
                                  .columns = set->trained.count,
                                  .given = given,
                                  .drawn = drawn ? &set->trained.drawn : NULL};
        snprintf(points->name, sizeof points->name, "points/%s", set->about->name);
        if (set->trained.data) {
            problem_array *data = &arrays[count++];
            *data = (problem_array){.data = set->trained.data,
                                    .rows = (size_t)source->rows,
                                    .columns = set->trained.count,
                                    .given = given};
            snprintf(data->name, sizeof data->name, "data/%s", set->about->name);
        }
        generators[(*generator_count)++] = (problem_generator){set->about->name, &set->rng};
    }
    if (p->model->scene.unknown_count > 0) {
        arrays[count++] = (problem_array){"unknowns/released", &p->released, 1, 1, false, NULL};
    }
    return count + problem_weights_state(p, arrays + count);
}

ad_status problem_restored(problem *p, ad_error *error)
{
    if (p->released != 0 && p->released != 1) {
        return ad_fail(error, AD_BAD_INPUT, "checkpoint: unknowns/released is neither 0 nor 1");
    }
    for (int i = 0; i < p->set_count; i++) {
        problem_set_refresh(&p->sets[i]);
        problem_cloud *trained = &p->sets[i].trained;
        size_t numbers = (size_t)p->sets[i].about->source.rows * trained->count;
        if (trained->drawn.still) {
            const ad_status status = problem_cloud_redraw(p, &p->sets[i], trained, error);
            if (status != AD_OK) {
                return status;
            }
        } else {
            trained->first = 0;
            trained->end = trained->count; /* they have been filled in */
            if (!problem_points_are_inside(p, trained)) {
                return ad_fail(error, AD_BAD_INPUT, "checkpoint: a point lies outside the scene");
            }
        }
        if (!vector_is_finite(numbers, trained->data)) {
            return ad_fail(error, AD_BAD_INPUT, "checkpoint: data of a point are not finite");
        }
    }
    return problem_weights_restored(p, error);
}

void problem_place_text(const problem *p, const problem_place *place, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < p->model->domain.count && used < size; i++) {
        const domain_coordinate *c = &p->model->domain.coordinates[i];
        used += (size_t)snprintf(text + used, size - used, "%s%s = %.6g%s%s", i ? ", " : "",
                                 c->name, place->x[i], *c->unit ? " " : "", c->unit);
    }
}
