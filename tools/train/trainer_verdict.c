/* The verdict on a training run, and the measures that it rests on. */
#include "physics/beam/beam.h"
#include "physics/check/plausible.h"
#include "physics/learn/motion_network.h"
#include "physics/learn/patches.h"
#include "physics/solve/solve.h"
#include "physics/solve/stability.h"
#include "tools/train/trainer_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

ad_status trainer_measure_size(trainer *t, ad_error *error)
{
    const scene *rod_scene = t->e->scene;
    double *nothing = calloc(t->e->count, sizeof *nothing), loss = 0;
    if (!nothing) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu parameters", t->e->count);
    }
    ad_status status = problem_held_out(t->problem, nothing, &loss, NULL, error);
    free(nothing);
    if (!t->e->model->has_scene) {
        t->size = loss > 0 && loss < 1 ? loss : 1;
        return status;
    }
    rod_numbers n = rod_numbers_of(rod_scene);
    double load = fmax(fmax(n.tip_force, n.tip_moment),
                       fmax(fmax(n.distributed_force, n.distributed_moment), n.weight));
    load = fmax(fmax(load, fmax(n.actuation, n.tubes)), fmax(n.point_force, n.point_moment));
    double size =
        scene_is_dynamic(rod_scene) ? fmax(loss, load * load) : loss; /* some come later */
    t->size = size > 0 && size < 1 && t->e->settings->data_count == 0 ? size : 1;
    if (scene_is_beam(rod_scene)) { /* on a stiff foundation slopes are smaller than loads tell */
        double foundation = fmax(1, beam_numbers_of(rod_scene).foundation);
        t->size *= pow(fmin(1, 8 * pow(foundation / 4, 0.25) / foundation), 2);
    } else if (!rod_plane_of(rod_scene).is_planar) {
        t->size *= pow(fmin(1, n.torsion_ratio), 2);
    }
    return status;
}

bool trainer_is_small(const trainer *t, double loss)
{
    return loss < fmax(TRAINER_LARGE_LOSS * t->size, FIT_ROUNDING_LOSS);
}

/* The largest held-out loss with which a window ended, and the window, from 0. */
static double worst_held_out(const trainer *t, int *window)
{
    const history *h = &t->fit.rows;
    double worst = -1;
    for (size_t row = 0; row < h->count; row++) {
        int at = fit_row_window(&t->fit, row);
        double held_out = history_value(h, row, "held_out");
        bool last = row + 1 == h->count || fit_row_window(&t->fit, row + 1) != at;
        if (last && !(held_out <= worst)) { /* not a number is the worst */
            worst = held_out;
            *window = at;
        }
    }
    return worst;
}

/* A scene at rest, of a family a member, and its columns at the points of stability. */
static bool shape_at_rest(const trainer *t, scene *one, double *s, double *values)
{
    const experiment *e = t->e;
    ad_error ignored;
    field *shape = NULL;
    if (!e->model->has_scene || scene_is_dynamic(e->scene)) {
        return false;
    }
    double middle[SCENE_PARAMETERS_MAX];
    scene_member(e->scene, experiment_member_values(e, middle), one);
    ad_status status = stability_points(one, s, &ignored);
    status = status == AD_OK ? experiment_field(e, middle, &shape, &ignored) : status;
    if (status == AD_OK) {
        field_load(shape, t->fit.at.part);
        status = field_evaluate(shape, experiment_parameters(e), STABILITY_POINTS,
                                (const double *const[]){s}, values, &ignored);
    }
    field_free(shape);
    return status == AD_OK;
}

int trainer_unstable_modes(const trainer *t)
{
    double s[STABILITY_POINTS], values[MODEL_COLUMNS_MAX * STABILITY_POINTS];
    ad_error ignored;
    int modes = -1;
    scene one;
    if (shape_at_rest(t, &one, s, values)) {
        stability_count(&one, values, &modes, &ignored);
    }
    return modes;
}

/* Of loads that have no energy vibrations tell, which nobody waits for on the way. */
static void judge_stability(const trainer *t, verdict *result)
{
    double s[STABILITY_POINTS], values[MODEL_COLUMNS_MAX * STABILITY_POINTS];
    ad_error ignored;
    scene one;
    stability found;
    if (shape_at_rest(t, &one, s, values) &&
        stability_find(&one, values, &found, &ignored) == AD_OK) {
        stability_judge(&found,
                        ", so that the rod buckles or snaps to another; rod.rest.imperfection says "
                        "to which, or take another training.seed",
                        result);
    }
}

static void judge_strains(const trainer *t, verdict *result)
{
    double s[STABILITY_POINTS], values[MODEL_COLUMNS_MAX * STABILITY_POINTS];
    scene one;
    if (t->e->model->has_scene && !scene_is_beam(t->e->scene) &&
        shape_at_rest(t, &one, s, values)) {
        solve_judge_strains(&one, STABILITY_POINTS, s, NULL, values, result);
    }
}

/* The error of the position over the length, or of a deflection over its size, per root of the
 * held-out loss with which the worst window ended, for networks without hidden layers in mixed
 * form: the largest that was measured, of some 120 scenes at rest, with jumps and narrow peaks
 * (smooth ones are five times as good); in motion per root of the longest window as well, in units
 * of L^2 (rhoA/EI)^(1/2), of steps, blows, ramps, releases and tendons, planar and spatial, in 5 to
 * 190 windows: errors were 0.3 to 3 times that, where all is smooth a tenth. Nearly unstable
 * equilibria may be worse. */
static const double AT_REST = 0.005, IN_MOTION = 0.16;

/* Of a family at rest, of the worst of its members: the loss is a mean over all. Measured over 500
 * members of cantilevers with two and three parameters: 2 to 3, and 11 where some are near the load
 * that buckles them. */
static const double OF_FAMILY = 10;

/* Of a motion at least: what windows hand on is exact to some 1e-9 only. */
static const double ROUNDING_IN_MOTION = 1e-8;

/* Of one motion in the strain form, of its error to first order. */
static const double OF_MOTION = 2;

/* What a network that has solved a scene stays below at rest; motions have waves without end. */
static const double BOUND_AT_REST = 5e-8, BOUND_AT_REST_DEEP = 1e-3, BOUND_IN_MOTION = 1e-3,
                    BOUND_OF_FAMILY = 1e-3;

static bool has_fresh(const trainer *t)
{
    const scene *family = t->e->scene;
    return t->e->model->has_scene && scene_is_family(family) && !scene_is_dynamic(family) &&
           !scene_is_beam(family) && family->unknown_count == 0 && !t->e->targets;
}

static ad_status measure_motion(trainer *t, ad_error *error)
{
    const evaluator_model all = experiment_trained(t->e);
    const size_t state = window_state_numbers(all.physics);
    motion_network *network = NULL;
    ad_status status = motion_network_create(all.physics, all.mlp, t->e->pool, &network, error);
    for (int i = 0; i < all.windows && status == AD_OK; i++) {
        status =
            motion_network_off(network, i, i > 0 ? all.starts + (size_t)i * state : NULL,
                               all.parameters + (size_t)i * t->e->count, &t->info.motion, error);
    }
    motion_network_free(network);
    return status;
}

/* Networks for which the errors above were measured. */
static bool is_measured(const trainer *t)
{
    return t->e->model->has_scene && t->e->settings->network.hidden_count == 0 &&
           t->e->scene->formulation == SCENE_MIXED;
}

static double estimate_by_residuals(const trainer *t)
{
    int window = 0;
    const scene *rod_scene = t->e->scene;
    if (!is_measured(t) || t->fit.rows.count == 0) {
        return NAN;
    }
    bool beam = scene_is_beam(rod_scene), moves = scene_is_dynamic(rod_scene);
    double per_root = moves ? IN_MOTION * sqrt(domain_longest_window(&t->e->model->domain))
                      : scene_is_family(rod_scene) ? OF_FAMILY
                                                   : AT_REST;
    double estimate = per_root * sqrt(worst_held_out(t, &window) / (beam ? t->size : 1));
    return moves && !beam ? fmax(estimate, ROUNDING_IN_MOTION) : estimate;
}

/* Of a family that of the worst of a few members: each is solved. */
static ad_status measure_error(trainer *t, ad_error *error)
{
    enum { MEMBERS = 8 };
    const scene *family = t->e->scene;
    const int known = scene_known_count(family);
    nn_rng rng = nn_rng_split(t->e->settings->seed, "estimate");
    ad_status status = AD_OK;
    for (int m = 0; m < (known > 0 ? MEMBERS : 1) && status == AD_OK; m++) {
        double values[SCENE_PARAMETERS_MAX], estimate;
        ad_error why = {.status = AD_OK};
        experiment_member_values(t->e, values);
        for (int k = 0; k < known; k++) {
            values[k] = scene_parameter_at(&family->parameters[k], nn_rng_uniform(&rng));
        }
        status = experiment_error(t->e, values, &estimate, &why);
        if (status != AD_OK) {
            *error = why;
        } else if (isnan(estimate)) {
            snprintf(t->info.unknown, sizeof t->info.unknown, "%.159s", why.message);
        } else {
            t->info.estimate = estimate <= t->info.estimate ? t->info.estimate : estimate;
        }
    }
    return status;
}

ad_status trainer_measure_end(trainer *t, ad_error *error)
{
    t->info.balance = experiment_balance(t->e, NULL);
    if (t->e->modes) {
        return measure_motion(t, error);
    }
    if (has_fresh(t)) {
        return fresh_members_compare(t->e, &t->info.fresh, error);
    }
    const bool asked = !t->e->targets && isnan(estimate_by_residuals(t));
    return asked ? measure_error(t, error) : AD_OK;
}

double trainer_estimate(const trainer *t)
{
    if (t->e->modes) {
        return t->fit.state == FIT_OVER ? OF_MOTION * t->info.motion.all : NAN;
    }
    return t->info.fresh.compared     ? t->info.fresh.worst
           : !isnan(t->info.estimate) ? t->info.estimate
                                      : estimate_by_residuals(t);
}

bool trainer_needs(const trainer *t, int modes[4], int *degree)
{
    enum { STEP = 4 };
    const train_settings *settings = t->e->settings;
    const double most = settings->tolerance / 2, in_time = OF_MOTION * t->info.motion.in_time;
    const double estimate = trainer_estimate(t);
    memcpy(modes, settings->modes, sizeof settings->modes);
    *degree = settings->network.degree;
    if (!t->e->modes || !(estimate > settings->tolerance)) {
        return false;
    }
    if (in_time > most && *degree > 0) {
        *degree = *degree + STEP < NN_DEGREE_MAX ? *degree + STEP : NN_DEGREE_MAX;
    }
    for (int i = 0; i < 4 && estimate - in_time > most; i++) {
        const int more = modes[i] > 0 ? modes[i] + modes[i] / 3 + 1 : 0;
        modes[i] = more < SOLVE_MODES_MAX ? more : SOLVE_MODES_MAX;
    }
    return *degree != settings->network.degree ||
           memcmp(modes, settings->modes, sizeof settings->modes) != 0;
}

/* What would make the largest part of it smaller. */
static const char *mend_motion(const trainer *t)
{
    return t->info.motion.in_time > t->info.motion.all / 2
               ? "a larger network.polynomial.degree, or more time.windows"
               : "more network.modes";
}

static void judge_fresh(const trainer *t, verdict *result)
{
    const fresh_errors *w = &t->info.fresh;
    if (!(w->worst <= BOUND_OF_FAMILY)) {
        verdict_add(result, VERDICT_ESTIMATE_ABOVE_TOLERANCE,
                    "of %d fresh members, solved classically, the worst is off by %.2g of the "
                    "length, 95 %% by less than %.2g; allowed: %.2g; try more "
                    "network.fourier.features or losses.interior.points, or smaller ranges",
                    w->compared, w->worst, w->most, BOUND_OF_FAMILY);
    }
}

/* Below which error a network has solved its scene. */
static double bound(const trainer *t)
{
    const double asked = t->e->settings->tolerance;
    return asked > 0                       ? asked
           : scene_is_dynamic(t->e->scene) ? BOUND_IN_MOTION
           : scene_is_family(t->e->scene)  ? BOUND_OF_FAMILY
           : is_measured(t)                ? BOUND_AT_REST
                                           : BOUND_AT_REST_DEEP;
}

/* What may make the error smaller. */
static const char *mend(const trainer *t)
{
    return t->e->modes                                ? mend_motion(t)
           : t->e->settings->network.hidden_count > 0 ? "more steps, another optimizer or a larger "
                                                        "network.hidden"
           : scene_is_dynamic(t->e->scene)            ? "more time.windows, or a larger "
                                                        "network.fourier.wavenumber with more features"
                                                      : "more network.fourier.features";
}

/* What else there is for equations of one's own, or NULL: they have no keys, and neither more waves
 * nor larger layers help all of them. */
static const char *solved_by(const trainer *t)
{
    const physics_model *m = t->e->model;
    return m->has_scene || m->domain.count > PATCHES_COORDINATES_MAX
               ? NULL
               : "cpinn_fit_equations or patches_fit (cpinn-fit) solves such equations to a "
                 "tolerance, with an estimate of the error";
}

static void judge_estimate(const trainer *t, verdict *result)
{
    const double estimate = trainer_estimate(t), most = bound(t);
    if (t->info.fresh.compared) {
        judge_fresh(t, result);
    } else if (estimate > most) {
        verdict_add(result, VERDICT_ESTIMATE_ABOVE_TOLERANCE,
                    "estimated error %.2g of the %s, above %.2g%s; try %s, or another "
                    "network.tolerance",
                    estimate, scene_is_beam(t->e->scene) ? "deflection" : "length", most,
                    isnan(t->info.estimate) ? ", by residuals at points never trained on"
                                            : ", by what the equations move it",
                    mend(t));
    } else if (isnan(estimate) && !t->e->targets) {
        verdict_add(result, VERDICT_ERROR_UNKNOWN, "the error of the answer is not known%s%s; %s",
                    *t->info.unknown ? ": " : "", t->info.unknown,
                    solved_by(t) ? solved_by(t)
                                 : "compare with a known case, or with a second training of "
                                   "another kind of network, waves or hidden layers");
    }
}

static void judge_load_balance(const trainer *t, verdict *result)
{
    double estimate = isnan(t->info.estimate) ? estimate_by_residuals(t) : t->info.estimate;
    double balance = t->info.balance.loads;
    const rod_weights *weights = &t->e->settings->weights; /* 0: data stand for that equation */
    bool balances = weights->force > 0 && weights->moment > 0;
    if (balances && !isnan(estimate) && !isnan(balance)) {
        solve_judge_balance(balance, estimate, result);
    }
}

/* Of the length; such a network is no start for steps of Newton's method either. */
static const double MEMBERS_FAR = 0.01;

static void judge_members(const trainer *t, verdict *result)
{
    const targets_errors *off = &t->info.members;
    if (!(off->median <= MEMBERS_FAR)) {
        verdict_add(result, VERDICT_NOT_CONVERGED,
                    "half of all fresh members are off by more than %.2g of the length; train "
                    "longer, or take a larger network.hidden, more members.solved, or smaller "
                    "ranges",
                    off->median);
    }
}

static void judge_held_out(const trainer *t, verdict *result)
{
    int window = 0, windows = t->e->scene->windows;
    char where[64] = "";
    bool converged = trainer_is_small(t, worst_held_out(t, &window));
    if (windows > 1) {
        snprintf(where, sizeof where, " in window %d of %d", window + 1, windows);
    }
    if (!converged) {
        verdict_add(result, VERDICT_NOT_CONVERGED,
                    "residuals are still large%s on points never trained on; %s", where,
                    solved_by(t) ? solved_by(t)
                                 : "train longer, or its dimensionless numbers show what makes "
                                   "this scene hard");
    }
}

static void judge_motion_balance(const learnt_balance *balance, bool modes, verdict *result)
{
    if (balance->energy > SOLVE_ENERGY_ALLOWED || balance->momentum > SOLVE_ENERGY_ALLOWED) {
        verdict_add(result, VERDICT_ENERGY_OUT_OF_BALANCE,
                    "energy, work and dissipation of the motion differ by %.2g of the largest, "
                    "momentum and the impulses of all forces by %.2g, where a tenth is allowed: "
                    "waves are missed, or the motion is wrong; try more time.windows, or %s",
                    balance->energy, balance->momentum,
                    modes ? "more network.modes"
                          : "a larger network.fourier.wavenumber with more features");
    }
}

void trainer_verdict(const trainer *t, verdict *result)
{
    const fit *f = &t->fit;
    *result = (verdict){.count = 0};
    if (f->state != FIT_OVER) {
        verdict_add(result, VERDICT_UNFINISHED,
                    "training is at step %lld, in stage %d of %d; resume it to go on",
                    (long long)f->at.step, f->at.stage + 1, t->e->settings->stage_count);
        return;
    }
    if (f->interpolates) {
        verdict_add(result, VERDICT_INTERPOLATES,
                    "the network interpolates its points: between them, where it was not trained, "
                    "the loss is %.1e times as large; take more losses.interior.points, or a "
                    "smaller network.hidden",
                    f->held_out_ratio);
    }
    if (t->e->targets) {
        judge_members(t, result);
    } else {
        judge_held_out(t, result);
    }
    judge_estimate(t, result);
    judge_load_balance(t, result);
    if (problem_unresolved(t->problem)) {
        verdict_add(result, VERDICT_UNRESOLVED,
                    "%s jumps in more places than are found, or along a curve of s and t, or "
                    "varies on lengths that no pieces follow: residuals may be large where none "
                    "was computed; try fewer jumps, or a smoother formula",
                    problem_unresolved(t->problem));
    }
    judge_motion_balance(&t->info.balance, t->e->modes != NULL, result);
    judge_strains(t, result);
    if (t->e->model->has_scene) {
        scene_judge_sizes(t->e->scene, result);
    }
    judge_stability(t, result);
    if (t->known) {
        reference_verdict(t->known, &t->info.errors, trainer_estimate(t), result);
        if (verdict_has(result, VERDICT_ESTIMATES_CONTRADICT)) {
            reference_forget(t->known);
        }
    }
}
