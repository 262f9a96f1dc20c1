#include "tools/train/reference.h"

#include "physics/learn/analytic.h"
#include "physics/numerics/quaternion.h"
#include "physics/numerics/sampling.h"
#include "tools/train/reference_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STATIC_POINTS = 101, DYNAMIC_POINTS = 41 };

/* Of a family, that are solved, and points of each; a motion takes seconds or minutes. */
enum { MEMBERS = 16, MOVING_MEMBERS = 4, MEMBER_POINTS = 21 };

/* ---- making -------------------------------------------------------------------------------- */

ad_status reference_allocate(reference *r, size_t points, ad_error *error)
{
    r->points = points;
    r->s = calloc((2 + (size_t)r->parameters + 3 * r->pose) * points, sizeof *r->s);
    if (!r->s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu reference points", points);
    }
    r->t = r->s + points;
    r->poses = r->t + points;
    for (int i = 0; i < r->parameters; i++, r->poses += points) {
        r->more[i] = r->poses;
    }
    r->values = r->poses + r->pose * points;
    r->part = r->values + r->pose * points;
    return AD_OK;
}

/* Points at equal distances, ends included; of a family those of each member in turn. */
static ad_status make_grid(reference *r, bool dynamic, ad_error *error)
{
    size_t ns = r->parameters ? MEMBER_POINTS : dynamic ? DYNAMIC_POINTS : STATIC_POINTS;
    size_t nt = !dynamic ? 1 : r->parameters ? MEMBER_POINTS : DYNAMIC_POINTS;
    ad_status status = reference_allocate(r, (size_t)r->members * ns * nt, error);
    for (size_t i = 0; status == AD_OK && i < r->points; i++) {
        r->s[i] = r->length * (double)(i % ns) / (double)(ns - 1);
        r->t[i] = nt > 1 ? r->duration * (double)(i / ns % nt) / (double)(nt - 1) : 0;
    }
    return status;
}

static void numbers_of(const quantity *given, int count, double *numbers)
{
    for (int i = 0; i < count; i++) {
        numbers[i] = given[i].is_given ? quantity_value(given[i], 0, 0) : 0;
    }
}

static analytic_clamp clamp_of(const scene *scene)
{
    analytic_clamp clamp;
    double square = 0;
    numbers_of(scene->start.position, 3, clamp.position);
    numbers_of(scene->start.rotation, 4, clamp.quaternion);
    for (int i = 0; i < 4; i++) {
        square += clamp.quaternion[i] * clamp.quaternion[i];
    }
    for (int i = 0; i < 4; i++) {
        clamp.quaternion[i] /= sqrt(square);
    }
    return clamp;
}

void reference_put_pose(reference *r, size_t i, const double *position, const double *rotation)
{
    size_t positions = (size_t)r->model->position_columns;
    for (size_t k = 0; k < r->pose; k++) {
        r->poses[k * r->points + i] = k < positions ? position[k] : rotation[k - positions];
    }
}

static ad_status make_elastica(reference *r, const scene *scene, ad_error *error)
{
    analytic_clamp clamp = clamp_of(scene);
    analytic_elastica elastica;
    double force[3];
    numbers_of(scene->loads.tip.force, 3, force);
    ad_status status = analytic_elastica_create(
        &clamp, r->length, scene_properties_of(scene).curvature_stiffness[0].number, force,
        &elastica, error);
    for (size_t i = 0; status == AD_OK && i < r->points; i++) {
        analytic_state state;
        analytic_elastica_at(&elastica, r->s[i], &state);
        reference_put_pose(r, i, state.position, state.quaternion);
    }
    return status;
}

static ad_status make_couple(reference *r, const scene *scene, bool planar, ad_error *error)
{
    analytic_clamp clamp = clamp_of(scene);
    scene_properties properties = scene_properties_of(scene);
    double bending = properties.curvature_stiffness[0].number;
    double torsion = properties.curvature_stiffness[2].number, couple[3];
    ad_status status = AD_OK;
    numbers_of(scene->loads.tip.moment, 3, couple);
    for (size_t i = 0; status == AD_OK && i < r->points; i++) {
        analytic_state state;
        status = planar
                     ? analytic_rollup_at(&clamp, bending, couple, r->s[i], &state, error)
                     : analytic_helix_at(&clamp, bending, torsion, couple, r->s[i], &state, error);
        if (status == AD_OK) {
            reference_put_pose(r, i, state.position, state.quaternion);
        }
    }
    return status;
}

/* Modes of the strain have no fields that could be given, and without a network there is no model:
 * those of the mixed form then are. */
static ad_status make_manufactured(reference *r, const experiment *e, ad_error *error)
{
    scene mixed = *e->scene;
    physics_model *model = NULL;
    field *exact = NULL;
    ad_status status = AD_OK;
    mixed.formulation = SCENE_MIXED;
    if (!e->model || e->model->motion) {
        status = model_of_scene(&mixed, NULL, &model, error);
    }
    if (status == AD_OK) {
        status = field_create(model ? model : e->model, NULL, true, e->pool, &exact, error);
    }
    if (status == AD_OK) {
        status = field_evaluate(exact, NULL, r->points, (const double *const[]){r->s, r->t},
                                r->poses, error);
    }
    field_free(exact);
    model_free(model);
    return status;
}

/* A formula, evaluated point by point. */
static ad_status make_deflection(reference *r, const experiment *e, ad_error *error)
{
    snprintf(r->name, sizeof r->name, "reference.deflection");
    ad_status status = make_grid(r, scene_is_dynamic(e->scene), error);
    for (size_t i = 0; status == AD_OK && i < r->points; i++) {
        double unknown = 0;
        double w = quantity_value(e->settings->reference_deflection, r->s[i], r->t[i]);
        reference_put_pose(r, i, &w, &unknown);
        if (!isfinite(w)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "reference.deflection: is not finite at s = %g m, t = %g s; allowed: a "
                           "formula that is",
                           r->s[i], r->t[i]);
        }
    }
    return status;
}

/* The members that are solved, by Sobol's sequence: always the same. */
static ad_status draw_members(reference *r, const scene *family, ad_error *error)
{
    double *unit = malloc((size_t)r->members * (size_t)(r->parameters + 1) * sizeof *unit);
    nn_rng rng = nn_rng_seed(1);
    const size_t each = r->points / (size_t)r->members;
    ad_status status =
        unit ? sampling_fill(SAMPLING_SOBOL, &rng, r->parameters, (size_t)r->members, unit, error)
             : ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    for (size_t i = 0; status == AD_OK && i < r->points; i++) {
        for (int k = 0; k < r->parameters; k++) {
            const double at = unit[(size_t)(k * r->members) + i / each];
            r->more[k][i] = scene_parameter_at(&family->parameters[k], at);
        }
    }
    free(unit);
    return status;
}

/* One after the other; what is told is told of the worst. */
static ad_status solve_each(reference *r, const experiment *e, ad_error *error)
{
    const size_t each = r->points / (size_t)r->members;
    reference_solution about, *worst = &r->about;
    ad_status status = draw_members(r, e->scene, error);
    for (size_t m = 0; status == AD_OK && m < (size_t)r->members; m++) {
        double values[SCENE_PARAMETERS_MAX];
        for (int k = 0; k < r->parameters; k++) {
            values[k] = r->more[k][m * each];
        }
        status = reference_solve(e, values, each, r->s + m * each, r->t + m * each, (int)r->pose,
                                 r->part, &about, error);
        if (status == AD_OK) {
            r->files[m] = strdup(about.path);
        }
        for (size_t k = 0; status == AD_OK && k < r->pose; k++) {
            memcpy(r->poses + k * r->points + m * each, r->part + k * each,
                   each * sizeof *r->poses);
        }
        bool is_worse = m == 0 ||
                        verdict_outcome_of(&about.verdict) > verdict_outcome_of(&worst->verdict) ||
                        about.estimate * about.size > worst->estimate * worst->size;
        *worst = status == AD_OK && is_worse ? about : *worst;
    }
    return status;
}

static ad_status make_solved(reference *r, const experiment *e, ad_error *error)
{
    r->rotations = true;
    r->parameters = e->scene->parameter_count;
    r->members = r->parameters == 0 ? 1 : scene_is_dynamic(e->scene) ? MOVING_MEMBERS : MEMBERS;
    snprintf(r->name, sizeof r->name,
             r->members > 1 ? "classical solutions of %d members" : "classical solution",
             r->members);
    ad_status status = make_grid(r, scene_is_dynamic(e->scene), error);
    r->files = calloc((size_t)r->members, sizeof *r->files);
    if (status == AD_OK && !r->files) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a reference");
    }
    if (status != AD_OK || r->parameters) {
        return status == AD_OK ? solve_each(r, e, error) : status;
    }
    status =
        reference_solve(e, NULL, r->points, r->s, r->t, (int)r->pose, r->poses, &r->about, error);
    r->files[0] = status == AD_OK ? strdup(r->about.path) : NULL;
    return status;
}

static ad_status make_analytic(reference *r, const experiment *e, ad_error *error)
{
    static const char *const names[] = {"", "elastica", "rollup", "helix", "manufactured"};
    const scene *scene = e->scene;
    train_reference kind = e->settings->reference;
    snprintf(r->name, sizeof r->name, "%s", names[kind]);
    r->rotations = true;
    ad_status status = make_grid(r, scene_is_dynamic(scene), error);
    if (status != AD_OK) {
        return status;
    }
    switch (kind) {
    case TRAIN_REFERENCE_ELASTICA:
        return make_elastica(r, scene, error);
    case TRAIN_REFERENCE_MANUFACTURED:
        return make_manufactured(r, e, error);
    default:
        return make_couple(r, scene, kind == TRAIN_REFERENCE_ROLLUP, error);
    }
}

/* ---- windows of time ----------------------------------------------------------------------- */

/* [points] in the order of `order`. */
static void permute(const reference *r, const size_t *order, double *column)
{
    for (size_t i = 0; i < r->points; i++) {
        r->part[i] = column[order[i]];
    }
    memcpy(column, r->part, r->points * sizeof *column);
}

/* Bring the points into the order of their windows; within one they keep theirs. */
static ad_status sort_points(reference *r, const domain *d, ad_error *error)
{
    double time = d->time < 0 ? 1 : d->coordinates[d->time].scale;
    size_t taken = 0, *order = malloc((r->points + 1) * sizeof *order);
    if (!order) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu reference points", r->points);
    }
    for (int window = 0; window < d->windows; window++) {
        r->first[window] = taken;
        for (size_t i = 0; i < r->points; i++) {
            if (d->windows == 1 || domain_window_at(d, r->t[i] / time) == window) {
                order[taken++] = i;
            }
        }
    }
    r->first[d->windows] = taken;
    permute(r, order, r->s);
    permute(r, order, r->t);
    for (int k = 0; k < r->parameters; k++) {
        permute(r, order, r->more[k]);
    }
    for (size_t k = 0; k < r->pose; k++) {
        permute(r, order, r->poses + k * r->points);
    }
    free(order);
    return AD_OK;
}

/* Values of the points from `first` up to `end`. */
static ad_status evaluate(reference *r, const double *x, size_t first, size_t end, ad_error *error)
{
    size_t count = end - first;
    const double *at[DOMAIN_COORDINATES_MAX] = {r->s + first, r->t + first};
    for (int k = 0; k < r->parameters; k++) {
        at[(r->duration > 0 ? 2 : 1) + k] = r->more[k] + first;
    }
    ad_status status = count ? field_evaluate(r->candidate, x, count, at, r->part, error) : AD_OK;
    for (size_t k = 0; status == AD_OK && count && k < r->pose; k++) {
        memcpy(r->values + k * r->points + first, r->part + k * count, count * sizeof *r->values);
    }
    return status;
}

ad_status reference_enter(reference *r, const experiment *e, int from, ad_error *error)
{
    field_enter(r->candidate, e->window, e->parameters, e->starts);
    r->window = e->window;
    return evaluate(r, experiment_parameters(e), r->first[from < e->window ? from : e->window],
                    r->first[e->window], error);
}

/* ---- the reference ------------------------------------------------------------------------- */

static double position_square(const reference *r)
{
    double square = 0;
    for (size_t i = 0; i < (size_t)r->model->position_columns * r->points; i++) { /* come first */
        square += r->poses[i] * r->poses[i];
    }
    return square;
}

/* Errors are relative to the norm of all positions. */
static ad_status check_size(const reference *r, ad_error *error)
{
    double square = position_square(r);
    return square > 0 && isfinite(square)
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "%s: the positions are all 0, or too large to be squared; an error "
                         "relative to them needs others",
                         r->name);
}

ad_status reference_create(const experiment *e, reference **result, ad_error *error)
{
    const train_settings *settings = e->settings;
    *result = NULL;
    if (!train_names_reference(settings)) {
        return AD_OK;
    }
    reference *r = calloc(1, sizeof *r);
    if (!r) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a reference");
    }
    r->model = scene_physics_of(e->scene);
    r->pose = (size_t)r->model->position_columns + (size_t)r->model->rotation_columns;
    r->members = 1;
    r->length = scene_length(e->scene);
    r->duration = scene_duration(e->scene);
    r->about.estimate = NAN;
    r->members = 1;
    ad_status status = settings->reference_file                  ? reference_read(r, e, error)
                       : settings->reference_deflection.is_given ? make_deflection(r, e, error)
                       : !isnan(settings->reference_tolerance)   ? make_solved(r, e, error)
                                                                 : make_analytic(r, e, error);
    if (status == AD_OK) {
        status = check_size(r, error);
    }
    if (status == AD_OK && e->mlp) {
        status = sort_points(r, &e->model->domain, error);
        status = status == AD_OK
                     ? field_create(e->model, e->mlp, true, e->pool, &r->candidate, error)
                     : status;
        status = status == AD_OK ? reference_enter(r, e, 0, error) : status;
    }
    if (status != AD_OK) {
        reference_free(r);
        return status;
    }
    *result = r;
    return AD_OK;
}

void reference_forget(const reference *r)
{
    for (int m = 0; m < r->members && r->files; m++) {
        if (r->files[m] && *r->files[m]) {
            remove(r->files[m]);
        }
    }
}

void reference_free(reference *r)
{
    if (r) {
        for (int m = 0; m < r->members && r->files; m++) {
            free(r->files[m]);
        }
        free(r->files);
        field_free(r->candidate);
        free(r->s);
        free(r);
    }
}

size_t reference_points(const reference *r)
{
    return r->points;
}

const double *reference_s(const reference *r)
{
    return r->s;
}

const double *reference_t(const reference *r)
{
    return r->t;
}

size_t reference_left_out(const reference *r)
{
    return r->left_out;
}

const char *reference_name(const reference *r)
{
    return r->name;
}

const char *reference_account(const reference *r)
{
    return r->about.account;
}

const char *reference_remark(const reference *r)
{
    return r->about.remark;
}

/* Over the length. */
static double largest_estimate(const reference *r)
{
    return r->about.estimate * r->about.size / r->length;
}

reference_errors reference_estimates(const reference *r)
{
    double estimate = largest_estimate(r);
    return (reference_errors){.position = estimate * r->length *
                                          sqrt((double)r->points / position_square(r)),
                              .position_max = estimate,
                              .tip = estimate,
                              .rotation = NAN,
                              .rotation_max = NAN};
}

static const double *column_of(const reference *r, const double *poses, int coordinate)
{
    return coordinate < r->model->position_columns ? poses + (size_t)coordinate * r->points : NULL;
}

const double *reference_known(const reference *r, int coordinate)
{
    return column_of(r, r->poses, coordinate);
}

const double *reference_found(const reference *r, int coordinate)
{
    return column_of(r, r->values, coordinate);
}

/* Estimates are within ten times the error, that of the network and that of the solver; and below
 * this nobody is misled by what both round. */
static const double WITHIN = 10, AT_LEAST = 1e-8;

void reference_verdict(const reference *r, const reference_errors *errors, double estimate,
                       verdict *result)
{
    const double apart = errors->position_max * r->length / r->about.size;
    if (apart > WITHIN * (estimate + r->about.estimate) + AT_LEAST) {
        verdict_add(result, VERDICT_ESTIMATES_CONTRADICT,
                    "network and reference are %.2g of the %s apart, where estimated errors of "
                    "%.2g and %.2g exclude more than %.2g: one of the two is wrong%s",
                    apart, r->model->rotation_columns == 4 ? "length" : "deflection", estimate,
                    r->about.estimate, estimate + r->about.estimate,
                    r->files ? "; the reference is not kept for the next run" : "");
    }
    if (errors->position_max <= largest_estimate(r)) {
        verdict_add(result, VERDICT_REFERENCE_TOO_COARSE,
                    "the reference itself is off by an estimated %.1e of the length; the true "
                    "error may be as large",
                    largest_estimate(r));
    }
}

double reference_angle(const double p[4], const double q[4])
{
    double turn[4];
    quaternion_quotient(p, q, turn);
    return 2 * atan2(sqrt(vector_dot(turn + 1, turn + 1)), fabs(turn[0]));
}

/* A beam of small deflection has one angle, its slope. */
static double angle_between(const reference *r, const double *p, const double *q)
{
    return r->model->rotation_columns == 4 ? reference_angle(p, q) : fabs(p[0] - q[0]);
}

/* The larger; not a number wins, so that it cannot hide. */
static double worse(double a, double b)
{
    return b <= a || isnan(a) ? a : b;
}

static void pose_at(const reference *r, const double *poses, size_t i, double pose[REFERENCE_POSE])
{
    for (size_t k = 0; k < r->pose; k++) {
        pose[k] = poses[k * r->points + i];
    }
}

/* Of r->values at the first `points`. */
static reference_errors measure(const reference *r, size_t points)
{
    double off = 0, size = 0, angles = 0, most = 0, turned = 0, tip = -1;
    int positions = r->model->position_columns;
    for (size_t i = 0; i < points; i++) {
        double exact[REFERENCE_POSE], found[REFERENCE_POSE], square = 0;
        pose_at(r, r->poses, i, exact);
        pose_at(r, r->values, i, found);
        for (int k = 0; k < positions; k++) {
            square += (found[k] - exact[k]) * (found[k] - exact[k]);
            size += exact[k] * exact[k];
        }
        double angle = angle_between(r, exact + positions, found + positions);
        off += square;
        angles += angle * angle;
        most = worse(most, sqrt(square));
        turned = worse(turned, angle);
        if (r->s[i] >= (1 - REFERENCE_END_TOLERANCE) * r->length) {
            tip = worse(tip, sqrt(square));
        }
    }
    return (reference_errors){.position = sqrt(off / size),
                              .position_max = points ? most / r->length : NAN,
                              .tip = tip < 0 ? NAN : tip / r->length,
                              .rotation = r->rotations ? sqrt(angles / (double)points) : NAN,
                              .rotation_max = r->rotations && points ? turned : NAN};
}

ad_status reference_compare(reference *r, const double *x, reference_errors *errors,
                            ad_error *error)
{
    size_t points = r->first[r->window + 1];
    ad_status status = evaluate(r, x, r->first[r->window], points, error);
    if (status == AD_OK) {
        *errors = measure(r, points);
    }
    return status;
}

ad_status reference_compare_solution(reference *r, const solution *solved, reference_errors *errors,
                                     ad_error *error)
{
    ad_status status =
        solution_evaluate(solved, (int)r->pose, r->points, r->s, r->t, r->values, error);
    if (status == AD_OK) {
        *errors = measure(r, r->points);
    }
    return status;
}
