#include "autodiff/ranks.h"
#include "physics/numerics/clock.h"
#include "tools/train/trainer_internal.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static const fit_kind trained_network;

/* ---- rows of history ----------------------------------------------------------------------------
 */

/* The first is the column "error". */
static const struct {
    const char *name;
    size_t offset;
} members_columns[TRAINER_MEMBERS] = {{"error", offsetof(targets_errors, median)},
                                      {"error_95", offsetof(targets_errors, most)},
                                      {"error_worst", offsetof(targets_errors, worst)},
                                      {"polished", offsetof(targets_errors, polished_median)},
                                      {"polished_95", offsetof(targets_errors, polished_most)},
                                      {"polished_worst", offsetof(targets_errors, polished_worst)}};

const char *trainer_members_name(int column)
{
    return members_columns[column].name;
}

double *trainer_members_error(trainer_info *info, int column)
{
    return (double *)((char *)&info->members + members_columns[column].offset);
}

static void put(history *h, double *row, const char *name, double value)
{
    row[h->columns] = value;
    h->names[h->columns++] = name;
}

/* A row of the history as it is now, and the names of its columns. */
static void fill_row(trainer *t, double row[HISTORY_COLUMNS_MAX])
{
    const fit *f = &t->fit;
    const problem *p = t->problem;
    const problem_settings *losses = &t->e->settings->losses;
    history *h = &t->fit.rows;
    h->columns = 0;
    put(h, row, "step", (double)f->at.step);
    if (f->windows > 1) {
        put(h, row, "window", f->at.window + 1);
    }
    put(h, row, "stage", f->at.stage + 1); /* counted from 1, as on the screen */
    put(h, row, "seconds", fit_seconds(f));
    put(h, row, "loss", f->loss);
    for (int i = 0; i < problem_terms(p); i++) {
        put(h, row, problem_term_name(p, i), problem_losses(p)[i]);
    }
    if (t->loads.solved) {
        put(h, row, "load_factor", f->at.part);
    }
    put(h, row, "held_out", f->held_out);
    put(h, row, "error", f->error);
    put(h, row, "tip_error", t->info.errors.tip);
    put(h, row, "rotation_error", t->info.errors.rotation);
    put(h, row, "learning_rate", f->rate);
    put(h, row, "gradient_norm", f->gradient_norm);
    for (int i = 1; t->e->targets && i < TRAINER_MEMBERS; i++) {
        put(h, row, trainer_members_name(i), *trainer_members_error(&t->info, i));
    }
    if (losses->causal_slices) {
        put(h, row, "causal_epsilon", problem_causal_epsilon(p));
        put(h, row, "causal_least_weight", problem_causal_least_weight(p));
    }
    for (int i = 0; losses->balance && i < problem_terms(p); i++) {
        snprintf(t->balance_names[i], sizeof t->balance_names[i], "balance_%s",
                 problem_term_name(p, i));
        put(h, row, t->balance_names[i], problem_balance_weight(p, i));
    }
}

/* ---- making -------------------------------------------------------------------------------- */

static bool fixed_loss(const train_settings *settings)
{
    const problem_settings *losses = &settings->losses;
    for (int i = 0; i < settings->stage_count; i++) {
        if (settings->stages[i].targets != TARGETS_SOLVED) {
            return false;
        }
    }
    return losses->causal_slices == 0 && losses->interior.resample_every == 0 &&
           losses->boundary.resample_every == 0 && losses->initial.resample_every == 0 &&
           !losses->adaptive.kind && !losses->balance;
}

static const train_stage *stage_of(const trainer *t)
{
    return &t->e->settings->stages[t->fit.at.stage];
}

void trainer_forget_optimizer(trainer *t)
{
    optimizer_free(t->optimizer);
    t->optimizer = NULL;
    t->fit.by = NULL;
}

void trainer_limit_steps(trainer *t)
{
    const bool last = t->fit.at.stage + 1 == t->e->settings->stage_count;
    const int steps = stage_of(t)->steps;
    t->fit.steps = last && problem_holds_unknowns(t->problem) ? (steps + 1) / 2 : steps;
}

static ad_status start(void *of, ad_error *error)
{
    trainer *t = of;
    if (t->e->targets) {
        targets_use(t->e->targets, stage_of(t)->targets);
    }
    trainer_limit_steps(t);
    ad_status status = optimizer_create(t->e->settings, t->fit.at.stage, t->problem, t->e->pool,
                                        experiment_parameters(t->e), &t->optimizer, error);
    t->fit.by = status == AD_OK ? optimizer_method(t->optimizer) : NULL;
    return status;
}

/* ---- parts of the loads -------------------------------------------------------------------- */

void trainer_apply_loads(trainer *t)
{
    if (t->loads.solved && t->fit.at.part != t->loads.part) {
        t->fit.at.part = t->loads.part;
        problem_load(t->problem, t->fit.at.part);
    }
}

static ad_status start_loads(trainer *t, ad_error *error)
{
    t->fit.at.part = 1;
    if (!t->e->model->has_scene || !train_takes_loads_in_parts(t->e->settings, t->e->scene)) {
        return AD_OK;
    }
    bool gradual = scene_is_imperfect(t->e->scene);
    if (!optim_continuation_create(&t->loads, t->e->count, gradual)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for training");
    }
    trainer_apply_loads(t);
    return AD_OK;
}

/* Another part of the loads, for which the stage begins again? Not where the user's limit ended it
 * with all loads at work. */
static bool goes_on_with_loads(trainer *t, optim_status status)
{
    bool limited = t->fit.at.part == 1 && status == OPTIM_RUNNING;
    return t->loads.solved && t->fit.at.stage == 0 && !limited &&
           optim_continuation_next(&t->loads, t->info.solved, experiment_parameters(t->e));
}

ad_status trainer_create(experiment *e, problem *problem_, reference *known, double seconds,
                         trainer **result, ad_error *error)
{
    *result = NULL;
    trainer *t = calloc(1, sizeof *t);
    if (!t) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for training");
    }
    t->e = e;
    t->problem = problem_;
    t->known = known;
    t->fit = fit_of(e->settings, ad_pool_ranks(e->pool), &trained_network, t);
    t->fit.windows = e->scene->windows;
    t->fit.origin = &e->origin;
    t->fit.text_item = experiment_text_item(e);
    t->fit.points = 0;
    t->began = t->fit.started;
    t->fit.started -= seconds;
    t->has_cache = trainer_fuse_folder(t->compiled, false);
    t->losses_compare = fixed_loss(e->settings);
    t->info.errors = (reference_errors){NAN, NAN, NAN, NAN, NAN};
    t->info.members = (targets_errors){NAN, NAN, NAN, NAN, NAN, NAN};
    t->info.balance = (learnt_balance){NAN, NAN, NAN};
    t->info.fresh = (fresh_errors){NAN, NAN, NAN, 0};
    t->info.estimate = NAN;
    for (int i = 0; i < problem_sets(problem_); i++) {
        t->info.points += (double)problem_set_inspect(problem_, i).points;
    }
    ad_status status = optimizer_check(e->settings, problem_, error); /* said before training */
    status = status == AD_OK ? trainer_measure_size(t, error) : status;
    status = status == AD_OK ? start_loads(t, error) : status;
    status = status == AD_OK ? fit_start(&t->fit, error) : status;
    if (status != AD_OK) {
        trainer_free(t);
        return status;
    }
    double row[HISTORY_COLUMNS_MAX];
    fill_row(t, row); /* for its names */
    *result = t;
    return AD_OK;
}

void trainer_free(trainer *t)
{
    if (t) {
        trainer_forget_optimizer(t);
        optim_continuation_free(&t->loads);
        fit_free(&t->fit);
        free(t);
    }
}

/* ---- looking ------------------------------------------------------------------------------- */

static const double *current_x(const trainer *t)
{
    return t->fit.by ? optim_x(t->fit.by) : experiment_parameters(t->e);
}

const double *trainer_parameters(const trainer *t)
{
    return t->losses_compare && t->fit.by ? optim_best_x(t->fit.by) : current_x(t);
}

const trainer_info *trainer_inspect(const trainer *t)
{
    return &t->info;
}

fit *trainer_fit(trainer *t)
{
    return &t->fit;
}

void trainer_describe(const trainer *t, char text[160])
{
    text[0] = '\0';
    if (t->optimizer) {
        optimizer_describe(t->optimizer, text);
    }
}

/* Ranks come to the same parameters, each by itself. */
static ad_status check_ranks(const trainer *t, const double *x, ad_error *error)
{
    const ad_ranks *ranks = ad_pool_ranks(t->e->pool);
    return ad_ranks_agree(ranks,
                          ranks ? checkpoint_hash(CHECKPOINT_HASH_START, x, t->e->count * sizeof *x)
                                : 0)
               ? AD_OK
               : ad_fail(error, AD_BAD_ARGUMENT,
                         "step %lld: the ranks have come to different parameters; their machines, "
                         "libraries or files differ",
                         (long long)t->fit.at.step);
}

static ad_status add_row(void *of, ad_error *error)
{
    trainer *t = of;
    trainer_info *info = &t->info;
    fit *f = &t->fit;
    const double *x = trainer_parameters(t);
    ad_status status = check_ranks(t, x, error);
    status = status == AD_OK ? problem_held_out(t->problem, x, &f->held_out, NULL, error) : status;
    if (status == AD_OK && t->known) {
        status = reference_compare(t->known, x, &info->errors, error);
        f->error = info->errors.position;
    }
    if (status == AD_OK && t->e->targets) {
        status = targets_measure(t->e->targets, t->e->mlp, x, &info->members, error);
        f->error = info->errors.position = info->members.median;
    }
    double row[HISTORY_COLUMNS_MAX];
    fill_row(t, row);
    return status == AD_OK ? history_add(&f->rows, row, error) : status;
}

static double trained_loss(const void *of, size_t row)
{
    const trainer *t = of;
    double sum = 0;
    for (int i = 0; i < problem_terms(t->problem); i++) {
        sum += problem_term_is_held_out(t->problem, i) * problem_term_weight(t->problem, i) *
               history_value(&t->fit.rows, row, problem_term_name(t->problem, i));
    }
    return sum;
}

/* ---- stepping ------------------------------------------------------------------------------ */

static void count_evaluation(trainer *t)
{
    t->fit.points += t->info.points;
}

static int code_of(trainer *t, ad_status status)
{
    count_evaluation(t);
    return ad_pool_stopped(t->e->pool) ? OPTIM_OBJECTIVE_STOP
           : status == AD_OK           ? OPTIM_OBJECTIVE_OK
           : status == AD_NOT_FINITE   ? OPTIM_OBJECTIVE_NOT_FINITE
                                       : OPTIM_OBJECTIVE_STOP;
}

static int objective(void *context, const double *x, double *value, double *gradient)
{
    trainer *t = context;
    ad_status status = problem_evaluate(t->problem, x, value, gradient, &t->failure);
    t->evaluated = *value;
    return code_of(t, status);
}

static int linearize(void *context, linear_model *model, const double *x, double *value,
                     double *jtr, double *diagonal)
{
    trainer *t = context;
    return code_of(t, linear_model_linearize(model, x, value, jtr, diagonal, &t->failure));
}

static ad_status not_finite(trainer *t, optim_status why, ad_error *error)
{
    problem_place place = {.term = -1};
    ad_error inner = {AD_OK, ""};
    char advice[160], where[160];
    long long step = (long long)t->fit.at.step + 1;
    problem_locate(t->problem, current_x(t), &place, &inner);
    if (t->fit.at.step > 0) {
        optimizer_advise(t->optimizer, advice);
    } else { /* before the first step only the scene can be to blame */
        snprintf(advice, sizeof advice,
                 "look for a formula or number of the scene that is not finite there");
    }
    problem_place_text(t->problem, &place, where, sizeof where);
    t->fit.state = FIT_NOT_FINITE;
    if (place.term < 0) {
        return ad_fail(error, AD_NOT_FINITE,
                       "step %lld: %s; every loss term is finite at the current parameters, so the "
                       "step itself or the gradient is not; try: %s",
                       step, optim_status_name(why), advice);
    }
    return ad_fail(error, AD_NOT_FINITE, "step %lld: loss term '%s' is not finite at %s; try: %s",
                   step, problem_term_name(t->problem, place.term), where, advice);
}

/* An optimiser may keep another point than the one it evaluated last: a line search that gives up
 * returns to an earlier trial, and a rejected Gauss-Newton step to where it began. The loss terms
 * and causal weights that the problem holds are those of its last evaluation, so it is evaluated
 * once more at the point kept; the history and the causal schedule then speak of that point. Passes
 * the status of the step through, unless this evaluation fails. */
static optim_status settle(trainer *t, optim_status status)
{
    double value;
    if (problem_evaluate(t->problem, current_x(t), &value, NULL, &t->failure) != AD_OK) {
        return OPTIM_STOPPED_BY_OBJECTIVE;
    }
    t->evaluated = value;
    count_evaluation(t);
    return status;
}

static bool failed(optim_status status)
{
    return status == OPTIM_NOT_FINITE || status == OPTIM_NO_FINITE_STEP ||
           status == OPTIM_STOPPED_BY_OBJECTIVE || status == OPTIM_BAD_STATE;
}

void trainer_watch_stop(trainer *t, bool (*asked)(void *context), void *context)
{
    t->asked = asked;
    t->asked_context = context;
}

/* A step of Gauss-Newton may take minutes, and leaves no trace when it is given up: as long as
 * `again`, what came before it in the trainer's step does not change anything when it is done
 * again. Sets *given_up. */
static optim_status take_step(trainer *t, bool again, bool *given_up)
{
    const optimizer_objective f = {objective, linearize, t};
    const bool watched = again &&
                         optim_method_needs(stage_of(t)->optim.method) == OPTIM_NEEDS_SQUARES &&
                         !ad_pool_ranks(t->e->pool); /* ranks end a step together */
    ad_pool_watch(t->e->pool, watched ? t->asked : NULL, t->asked_context);
    optim_status status = optimizer_step(t->optimizer, &f);
    *given_up = ad_pool_stopped(t->e->pool);
    ad_pool_watch(t->e->pool, NULL, NULL);
    if (*given_up) { /* what is kept for a set of points may be half computed */
        const ad_status restored = problem_restored(t->problem, &t->failure);
        return restored == AD_OK ? settle(t, OPTIM_RUNNING) : OPTIM_STOPPED_BY_OBJECTIVE;
    }
    return failed(status) || t->evaluated == optim_inspect(t->fit.by).value ? status
                                                                            : settle(t, status);
}

ad_status trainer_enter_window(trainer *t, int from, ad_error *error)
{
    ad_status status = problem_enter(t->problem, t->e->window, experiment_start(t->e), error);
    return status == AD_OK && t->known ? reference_enter(t->known, t->e, from, error) : status;
}

/* All stages again, from the parameters that the window before has come to; a linear network from
 * 0, where the state goes on as it moves. */
static ad_status next_window(trainer *t, ad_error *error)
{
    const double *before = experiment_parameters(t->e);
    ad_status status = experiment_next_window(t->e, error);
    if (status != AD_OK) {
        return status;
    }
    double *now = experiment_parameters(t->e);
    bool linear = t->e->settings->network.hidden_count == 0;
    for (size_t i = 0; i < t->e->count; i++) {
        now[i] = linear ? 0 : before[i];
    }
    return trainer_enter_window(t, t->fit.before.window, error);
}

/* Of a family each window multiplies the error that the one before hands on, by about five as
 * measured with two parameters: what follows one that is not solved is worth nothing. */
static ad_status check_window(const trainer *t, ad_error *error)
{
    if (!scene_is_family(t->e->scene) || trainer_is_small(t, t->fit.held_out)) {
        return AD_OK;
    }
    return ad_fail(error, AD_BAD_INPUT,
                   "window %d of %d of this family is not solved: its loss at points never trained "
                   "on is %.2g, and those after it would start from that; try a shorter "
                   "time.duration, smaller ranges, more losses.interior.points and "
                   "network.fourier.features, or a smaller network.fourier.wavenumber",
                   t->fit.before.window + 1, t->e->scene->windows, t->fit.held_out);
}

/* Without terms of data, which noise keeps from vanishing. */
static double physics_loss(const trainer *t)
{
    double loss = t->fit.loss;
    for (int i = 0; i < problem_terms(t->problem); i++) {
        loss -= problem_term_is_held_out(t->problem, i)
                    ? 0
                    : problem_balance_weight(t->problem, i) * problem_term_weight(t->problem, i) *
                          problem_losses(t->problem)[i];
    }
    return loss;
}

static ad_status end_stage(void *of, optim_status result, bool *again, ad_error *error)
{
    trainer *t = of;
    (void)error;
    memcpy(experiment_parameters(t->e), trainer_parameters(t), t->e->count * sizeof(double));
    t->info.solved = trainer_is_small(t, physics_loss(t)) || t->fit.loss < stage_of(t)->stop_loss;
    optimizer_account(t->optimizer, t->info.account);
    trainer_forget_optimizer(t);
    if (t->info.solved && t->loads.solved && t->fit.at.stage == 0 &&
        trainer_unstable_modes(t) > 0) {
        t->info.solved = false; /* another path of loads may lead to a stable shape */
        t->fit.ended = "unstable";
    }
    if (goes_on_with_loads(t, result)) {
        t->fit.at.stage_step = 0;
        trainer_apply_loads(t);
        *again = true;
    } else if (problem_holds_unknowns(t->problem) &&
               (t->info.solved || t->fit.at.stage + 1 == t->e->settings->stage_count)) {
        problem_release_unknowns(t->problem); /* for what is left of the steps */
        *again = true;
    }
    return AD_OK;
}

static ad_status turn(void *of, ad_error *error)
{
    trainer *t = of;
    if (t->fit.state == FIT_OVER) {
        return trainer_measure_end(t, error);
    }
    const ad_status status = check_window(t, error);
    return status == AD_OK ? next_window(t, error) : status;
}

static ad_status cannot_go_on(trainer *t, optim_status why, ad_error *error)
{
    if (why == OPTIM_STOPPED_BY_OBJECTIVE) {
        return ad_fail(error, t->failure.status, "step %lld: %s", (long long)t->fit.at.step + 1,
                       t->failure.message);
    }
    return why == OPTIM_BAD_STATE ? ad_fail(error, AD_BAD_INPUT, "step %lld: %s",
                                            (long long)t->fit.at.step + 1, optim_status_text(why))
                                  : not_finite(t, why, error);
}

/* Of what is small with a part of the loads: where the next part starts. */
static const double near_enough = 1e-2;

static ad_status step(void *of, optim_status *result, bool *taken, ad_error *error)
{
    trainer *t = of;
    const int64_t number = t->fit.at.window_step + 1;
    bool changed, weights = false, given_up;
    trainer_fuse(t);
    ad_status status = problem_advance(t->problem, number, current_x(t), &changed, error);
    if (status == AD_OK && optim_method_needs(stage_of(t)->optim.method) == OPTIM_NEEDS_GRADIENTS) {
        status = problem_reweigh(t->problem, number, current_x(t), &weights, error);
    }
    if (status != AD_OK) {
        return status;
    }
    if (changed || weights) {
        optim_objective_changed(t->fit.by);
    }
    *result = take_step(t, !changed && !weights, &given_up);
    *taken = !given_up;
    if (*result == OPTIM_RUNNING && t->fit.at.part < 1 &&
        trainer_is_small(t, optim_inspect(t->fit.by).value / near_enough)) {
        t->fit.reason = "near enough";
    }
    return failed(*result) ? cannot_go_on(t, *result, error) : AD_OK;
}

static const fit_kind trained_network = {.start = start,
                                         .step = step,
                                         .row = add_row,
                                         .trained = trained_loss,
                                         .end = end_stage,
                                         .turn = turn,
                                         .put = trainer_put,
                                         .get = trainer_get,
                                         .got = trainer_got};

ad_status trainer_step(trainer *t, ad_error *error)
{
    return fit_step(&t->fit, error);
}
