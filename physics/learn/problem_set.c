/* One set of points: recorded, compiled, run. */
#include "physics/learn/problem_internal.h"

#include "physics/numerics/clock.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void fixed_clear(problem_fixed *fixed)
{
    ad_program_free(fixed->program);
    free(fixed->values);
    *fixed = (problem_fixed){.program = NULL};
}

void problem_set_clear(problem_set *set)
{
    problem_set_forget_points(set);
    fixed_clear(&set->gradient_fixed);
    fixed_clear(&set->normal_fixed);
    fixed_clear(&set->product_fixed);
    ad_program_free(set->gradient);
    ad_program_free(set->value);
    ad_program_free(set->product);
    ad_program_free(set->fields);
    ad_normal_free(set->normal);
    for (int i = 0; i < PROBLEM_SET_TERMS; i++) {
        ad_program_free(set->term_gradient[i]);
        ad_program_free(set->share_gradient[i]);
    }
}

void problem_set_refresh(problem_set *set)
{
    set->gradient_fixed.stale = set->normal_fixed.stale = set->product_fixed.stale = true;
}

/* ---- recording ------------------------------------------------------------------------------- */

/* A recording of the set: the coordinates and, where points have them, data and weights as inputs;
 * what is set before a run and, where terms are balanced, the weights of the set's terms as
 * uniforms. */
typedef struct recording {
    double began; /* s */
    ad_tape *tape;
    domain_place at;
    ad_value point_weight, weights;
    ad_value balance[PROBLEM_SET_TERMS]; /* per term */
    ad_value fields[MODEL_FIELDS_MAX];
    ad_value residuals[PROBLEM_SET_TERMS]; /* per point */
    ad_value squares[PROBLEM_SET_TERMS];   /* their squared norms */
    ad_value views[PROBLEM_VIEWS];
} recording;

/* Of the residuals at an instant of one of several windows, 1 + x with mean square 1, x from 0 at
 * its start to 1 at its end, from which the next one starts. With equal weights the least sum of
 * squares may be had by a bend of what was wrong at the start that leaves with more velocity than
 * it came with: windows of a rod that turns without shear and stretch then each pass on half again
 * the error, and ten periods are not solved. Larger weights at the end cost accuracy. */
static ad_value weight_in_window(const problem *p, const domain_place *at)
{
    if (p->model->domain.windows == 1) {
        return ad_scalar(at->tape, 1);
    }
    ad_value x = ad_mul(domain_elapsed(&p->model->domain, at), ad_reciprocal(at->span));
    return ad_scale(ad_add(ad_scalar(at->tape, 1), x), 1 / sqrt(7.0 / 3));
}

static void record_begin(const problem *p, problem_set *set, recording *r)
{
    r->began = clock_seconds(CLOCK_MONOTONIC);
    r->tape = ad_tape_create();
    r->at = model_record(p->model, p->window, p->mlp, r->tape, r->fields);
    if (set->about->source.rows > 0) {
        r->at.data = ad_input(r->tape, "data", set->about->source.rows);
    }
    r->point_weight =
        set->point_weights ? ad_input(r->tape, "point weight", 1) : ad_scalar(r->tape, 1);
    r->weights = set->balance ? ad_uniform(r->tape, "balance", set->term_count) : r->point_weight;
    for (int i = 0; i < set->term_count; i++) {
        r->balance[i] = set->balance ? ad_row(r->weights, i) : ad_scalar(r->tape, 1);
    }
    ad_value weight = weight_in_window(p, &r->at);
    for (int i = 0; i < set->term_count; i++) {
        const model_term *term = p->terms[set->terms[i]];
        ad_value residual = ad_mul(weight, term->residual(term->context, &r->at, r->fields));
        r->residuals[i] = residual;
        r->squares[i] = ad_dot(residual, residual);
    }
    const nn_view *views;
    set->view_count = nn_mlp_views(p->mlp, &views);
    for (int i = 0; i < set->view_count; i++) {
        set->view_offsets[i] = views[i].offset;
        r->views[i] =
            ad_parameter(r->tape, views[i].name, views[i].rows * views[i].columns, views[i].offset);
    }
}

/* After compiling what was recorded. */
static void record_end(problem *p, recording *r)
{
    ad_tape_free(r->tape);
    p->compiled.count++;
    p->compiled.seconds += clock_seconds(CLOCK_MONOTONIC) - r->began;
}

static ad_value mean(ad_value per_point)
{
    return ad_div(ad_sum_points(per_point), ad_points(per_point.tape));
}

enum { PROBLEM_WAYS = 3 };

/* `y` differentiated in the order of `by`: s, t, and S, T for twice at once; a number: so many
 * times by s at once. s stands for the first coordinate, t for time. */
static ad_value differentiate(const problem *p, const recording *r, ad_value y, const char *by)
{
    for (; *by; by++) {
        bool along_t = *by == 't' || *by == 'T', twice = *by == 'S' || *by == 'T';
        int order = *by >= '1' && *by <= '9' ? *by - '0' : 1 + twice;
        y = ad_derivative(y, r->at.x[along_t ? p->model->domain.time : 0], order);
    }
    return y;
}

/* A derivative is shared with the equations only when it is recorded the way they came to it; and
 * they may need its rows alone. */
static bool uses_derivative(const problem *p, const recording *r, const problem_set *set,
                            ad_value y, const char *const *ways)
{
    for (int i = 0; i < PROBLEM_WAYS && ways[i]; i++) {
        ad_value d = differentiate(p, r, y, ways[i]);
        bool used = ad_uses(set->term_count, r->squares, d);
        for (int row = 0; row < ad_rows(d) && !used; row++) {
            used = ad_uses(set->term_count, r->squares, ad_row(d, row));
        }
        if (used) {
            return true;
        }
    }
    return false;
}

/* Name the derivatives of the fields that appear among what the terms need. */
static void note_derivatives(problem *p, const recording *r, const problem_set *set)
{
    static const struct {
        const char *name, *ways[PROBLEM_WAYS];
        bool timed;
    } orders[] = {{"s", {"s"}, false},        {"ss", {"S", "ss"}, false},
                  {"t", {"t"}, true},         {"tt", {"T", "tt"}, true},
                  {"st", {"st", "ts"}, true}, {"sst", {"sts", "sst", "tss"}, true},
                  {"ssss", {"4"}, false}};
    bool dynamic = p->model->domain.time >= 0;
    size_t used = 0;
    for (int f = 0; f < p->model->unknowns && p->model->has_scene; f++) {
        for (size_t o = 0; o < sizeof orders / sizeof *orders; o++) {
            if ((dynamic || !orders[o].timed) && used < sizeof p->derivatives &&
                uses_derivative(p, r, set, r->fields[f], orders[o].ways)) {
                used +=
                    (size_t)snprintf(p->derivatives + used, sizeof p->derivatives - used, "%s%s_%s",
                                     used ? " " : "", p->model->symbols[f], orders[o].name);
            }
        }
    }
}

/* Loads, prescribed motion, forcing, where a window begins: a program of their own, run when the
 * points are new. */
static ad_status compile_fixed(problem *p, problem_set *set, recording *r, int count,
                               ad_value *outputs, problem_fixed *made, ad_error *error)
{
    enum { LEAST_WORK = 4 };
    ad_value fixed[PROBLEM_FIXED_ROWS];
    size_t room = PROBLEM_FIXED_BYTES / sizeof(double) / set->trained.count;
    int rows = room < PROBLEM_FIXED_ROWS ? (int)room : PROBLEM_FIXED_ROWS;
    ad_value varying[3];
    int varying_count = 0;
    if (set->about->source.rows > 0) {
        varying[varying_count++] = r->at.data;
    }
    if (set->point_weights) {
        varying[varying_count++] = r->point_weight;
    }
    if (set->balance) {
        varying[varying_count++] = r->weights;
    }
    ad_status status = ad_precompute(count, outputs, varying_count, varying, LEAST_WORK, rows,
                                     fixed, &made->count);
    if (status != AD_OK || made->count == 0) {
        return ad_tape_status(r->tape, error);
    }
    for (int i = 0; i < made->count; i++) {
        made->offsets[i] = made->rows;
        made->rows += ad_rows(fixed[i]);
    }
    made->stale = true;
    made->values = malloc((size_t)made->rows * set->trained.count * sizeof(double));
    if (!made->values) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for what depends on points alone");
    }
    return ad_compile(made->count, fixed, NULL, p->pool, &made->program, error);
}

/* outputs: weighted loss, means, extra per-point values, gradient per view */
static ad_status compile_gradient(problem *p, problem_set *set, recording *r, ad_error *error)
{
    ad_value outputs[2 + PROBLEM_SET_TERMS + PROBLEM_VIEWS];
    ad_value per_point = ad_zeros(r->tape, 1), balanced = per_point;
    int count = 1;
    for (int i = 0; i < set->term_count; i++) {
        ad_value weighted = ad_scale(r->squares[i], p->terms[set->terms[i]]->weight);
        per_point = ad_add(per_point, weighted);
        balanced = ad_add(balanced, ad_mul(r->balance[i], weighted));
        outputs[count++] = mean(r->squares[i]);
    }
    outputs[0] = mean(ad_mul(r->point_weight, balanced));
    if (set->point_losses) {
        outputs[count++] = per_point;
    }
    ad_reverse(outputs[0], set->view_count, r->views, AD_SUMMED, outputs + count);
    set->counts = ad_tape_count(r->tape);
    count += set->view_count;
    ad_status status = compile_fixed(p, set, r, count, outputs, &set->gradient_fixed, error);
    return status == AD_OK ? ad_compile(count, outputs, NULL, p->pool, &set->gradient, error)
                           : status;
}

/* outputs: weighted loss, means, squares per point; by the weights of the settings alone */
static ad_status compile_value(problem *p, problem_set *set, recording *r, ad_error *error)
{
    ad_value outputs[1 + 2 * PROBLEM_SET_TERMS];
    int count = 1;
    outputs[0] = ad_zeros(r->tape, 1);
    for (int i = 0; i < set->term_count; i++) {
        outputs[count] = mean(r->squares[i]);
        outputs[0] =
            ad_add(outputs[0], ad_scale(outputs[count++], p->terms[set->terms[i]]->weight));
    }
    for (int i = 0; i < set->term_count; i++) {
        outputs[count++] = r->squares[i];
    }
    return ad_compile(count, outputs, NULL, p->pool, &set->value, error);
}

/* weighted: by the weights of points. */
static ad_status compile_term(problem *p, problem_set *set, int index, bool weighted,
                              ad_program **program, ad_error *error)
{
    recording r;
    record_begin(p, set, &r);
    ad_value outputs[1 + PROBLEM_VIEWS];
    outputs[0] = mean(weighted ? ad_mul(r.point_weight, r.squares[index]) : r.squares[index]);
    ad_reverse(outputs[0], set->view_count, r.views, AD_SUMMED, outputs + 1);
    ad_status status = ad_compile(1 + set->view_count, outputs, NULL, p->pool, program, error);
    record_end(p, &r);
    return status;
}

ad_status problem_set_build(problem *p, problem_set *set, ad_error *error)
{
    recording r;
    if (p->model->motion) {
        return problem_motion_prepare(p, error);
    }
    record_begin(p, set, &r);
    ad_status status = compile_gradient(p, set, &r, error);
    if (status == AD_OK) {
        status = compile_value(p, set, &r, error);
    }
    for (int i = 0; status == AD_OK && set->balance && i < set->term_count; i++) {
        status = compile_term(p, set, i, true, &set->share_gradient[i], error);
    }
    if (status == AD_OK && set->about->points == MODEL_INTERIOR) {
        note_derivatives(p, &r, set);
    }
    record_end(p, &r);
    return status;
}

/* ---- running --------------------------------------------------------------------------------- */

/* The coordinates, data and weights of points if there are any, then what was computed from the
 * points. */
static void list_inputs(const problem_set *set, const problem_cloud *cloud,
                        const problem_fixed *fixed, const double **inputs)
{
    int count = 0;
    for (int i = 0; i < set->problem->model->domain.count; i++) {
        inputs[count++] = cloud->x + (size_t)i * cloud->count;
    }
    if (cloud->data) {
        inputs[count++] = cloud->data;
    }
    if (set->point_weights) {
        inputs[count++] = set->point_weights;
    }
    for (int i = 0; fixed && i < fixed->count; i++) {
        inputs[count++] = fixed->values + (size_t)fixed->offsets[i] * set->trained.count;
    }
}

/* Where the gradient by each view goes. */
static void list_views(const problem_set *set, double *gradient, double **outputs)
{
    for (int i = 0; i < set->view_count; i++) {
        outputs[i] = gradient ? gradient + set->view_offsets[i] : NULL;
    }
}

static void list_uniforms(const problem_set *set, const double **uniforms)
{
    const problem *p = set->problem;
    int count = domain_list_uniforms(&p->kinds, &p->setting, uniforms);
    uniforms[count] = set->balance;
}

static ad_status refresh_fixed(problem_set *set, problem_fixed *fixed, ad_error *error)
{
    const double *inputs[PROBLEM_INPUTS], *uniforms[PROBLEM_UNIFORMS];
    double *outputs[PROBLEM_FIXED_ROWS];
    if (!fixed->stale || !fixed->program) {
        return AD_OK;
    }
    ad_status status = problem_set_hold(set, fixed->program, set->trained.count, error);
    if (status != AD_OK) {
        return status;
    }
    list_inputs(set, &set->trained, NULL, inputs);
    list_uniforms(set, uniforms);
    for (int i = 0; i < fixed->count; i++) {
        outputs[i] = fixed->values + (size_t)fixed->offsets[i] * set->trained.count;
    }
    ad_run r = {
        .points = set->trained.count, .inputs = inputs, .uniforms = uniforms, .outputs = outputs};
    status = ad_execute(fixed->program, &r, error);
    fixed->stale = status != AD_OK;
    return status;
}

/* Over the first points of a cloud: rows of data are then not theirs. */
static ad_status run_first(problem_set *set, ad_program *program, const problem_cloud *cloud,
                           size_t points, const double *x, double **outputs, ad_error *error)
{
    const double *inputs[PROBLEM_INPUTS + PROBLEM_FIXED_ROWS], *uniforms[PROBLEM_UNIFORMS];
    problem_fixed *fixed = program == set->gradient  ? &set->gradient_fixed
                           : program == set->product ? &set->product_fixed
                                                     : NULL;
    ad_status status = fixed ? refresh_fixed(set, fixed, error) : AD_OK;
    if (status == AD_OK && cloud == &set->trained) {
        status = problem_set_hold(set, program, points, error);
    }
    if (status != AD_OK) {
        return status;
    }
    list_inputs(set, cloud, fixed, inputs);
    list_uniforms(set, uniforms);
    ad_run r = {.points = points,
                .inputs = inputs,
                .uniforms = uniforms,
                .parameters = x,
                .outputs = outputs};
    return ad_execute(program, &r, error);
}

static ad_status run(problem_set *set, ad_program *program, const problem_cloud *cloud,
                     const double *x, double **outputs, ad_error *error)
{
    return run_first(set, program, cloud, cloud->count, x, outputs, error);
}

static ad_status compile_fields(problem *p, problem_set *set, ad_error *error)
{
    ad_value fields[MODEL_FIELDS_MAX], all;
    ad_tape *tape = ad_tape_create();
    model_record(p->model, p->window, p->mlp, tape, fields);
    all = ad_stack(p->model->field_count, fields);
    ad_status status = ad_compile(1, &all, NULL, p->pool, &set->fields, error);
    if (status == AD_OK) {
        set->field_values =
            malloc((size_t)ad_rows(all) * set->trained.count * sizeof *set->field_values);
    }
    ad_tape_free(tape);
    return status == AD_OK && !set->field_values
               ? ad_fail(error, AD_NO_MEMORY, "out of memory for the fields of points")
               : status;
}

ad_status problem_set_fields(problem *p, problem_set *set, const double *x, ad_error *error)
{
    ad_status status = set->field_values ? AD_OK : compile_fields(p, set, error);
    return status == AD_OK ? run(set, set->fields, &set->trained, x, &set->field_values, error)
                           : status;
}

ad_status problem_set_run(problem_set *set, ad_program *program, const problem_cloud *cloud,
                          const double *x, double *terms, double *total, double *gradient,
                          ad_error *error)
{
    double means[PROBLEM_SET_TERMS];
    double *outputs[2 + 2 * PROBLEM_SET_TERMS + PROBLEM_VIEWS] = {total};
    int count = 1;
    if (set->problem->model->motion) {
        return problem_motion_loss((problem *)set->problem, cloud, x, terms, total, gradient,
                                   error);
    }
    for (int i = 0; i < set->term_count; i++) {
        outputs[count++] = &means[i];
    }
    if (program == set->gradient) {
        if (set->point_losses) {
            outputs[count++] = set->point_losses;
        }
        list_views(set, gradient, outputs + count);
    }
    ad_status status = run(set, program, cloud, x, outputs, error);
    for (int i = 0; status == AD_OK && i < set->term_count; i++) {
        terms[set->terms[i]] = means[i];
    }
    return status;
}

ad_status problem_set_run_term(problem *p, problem_set *set, int term, bool weighted,
                               const double *x, double *loss, double *gradient, ad_error *error)
{
    int index = 0;
    if (p->model->motion) {
        return problem_motion_run(p, &set->trained, x, NULL, loss, gradient, error);
    }
    while (set->terms[index] != term) {
        index++;
    }
    ad_program **program = weighted ? &set->share_gradient[index] : &set->term_gradient[index];
    if (!*program) {
        ad_status status = compile_term(p, set, index, weighted, program, error);
        if (status != AD_OK) {
            return status;
        }
    }
    double *outputs[1 + PROBLEM_VIEWS] = {loss};
    list_views(set, gradient, outputs + 1);
    return run(set, *program, &set->trained, x, outputs, error);
}

/* Residuals times sqrt(weight / points), so that the loss is the sum of their squares. */
static void record_rows(const problem *p, const problem_set *set, const recording *r,
                        ad_value *rows)
{
    ad_value share = ad_sqrt(ad_div(r->point_weight, ad_points(r->tape)));
    for (int i = 0; i < set->term_count; i++) {
        double weight = sqrt(p->terms[set->terms[i]]->weight);
        ad_value factor = ad_mul(share, ad_sqrt(r->balance[i]));
        rows[i] = ad_mul(ad_scale(factor, weight), r->residuals[i]);
    }
}

static ad_status compile_normal(problem *p, problem_set *set, ad_error *error)
{
    recording r;
    record_begin(p, set, &r);
    ad_value rows[PROBLEM_SET_TERMS];
    record_rows(p, set, &r, rows);
    ad_status status = compile_fixed(p, set, &r, set->term_count, rows, &set->normal_fixed, error);
    if (status == AD_OK) {
        status = ad_normal_compile(set->term_count, rows, set->view_count, r.views, p->parameters,
                                   p->pool, &set->normal, error);
    }
    if (status != AD_OK) {
        fixed_clear(&set->normal_fixed);
    }
    record_end(p, &r);
    return status;
}

/* The vector v follows x in one vector of parameters. */
static ad_status compile_product(problem *p, problem_set *set, ad_error *error)
{
    recording r;
    record_begin(p, set, &r);
    ad_value rows[PROBLEM_SET_TERMS], v[PROBLEM_VIEWS], products[PROBLEM_VIEWS];
    record_rows(p, set, &r, rows);
    ad_status status = compile_fixed(p, set, &r, set->term_count, rows, &set->product_fixed, error);
    set->product_rows = 0;
    for (int i = 0; status == AD_OK && i < set->term_count; i++) {
        for (int row = 0; row < ad_rows(rows[i]); row++) {
            set->product_rows += !ad_is_constant(ad_row(rows[i], row), 0);
        }
    }
    for (int i = 0; status == AD_OK && i < set->view_count; i++) {
        v[i] = ad_parameter(r.tape, "v", ad_rows(r.views[i]), p->parameters + set->view_offsets[i]);
    }
    if (status == AD_OK) {
        ad_normal_product(set->term_count, rows, set->view_count, r.views, v, products);
        status = ad_compile(set->view_count, products, NULL, p->pool, &set->product, error);
    }
    if (status != AD_OK) {
        fixed_clear(&set->product_fixed);
    }
    record_end(p, &r);
    return status;
}

ad_status problem_set_prepare_product(problem *p, problem_set *set, ad_error *error)
{
    return set->product ? AD_OK : compile_product(p, set, error);
}

ad_status problem_set_product(problem_set *set, const double *pair, double *product,
                              ad_error *error)
{
    double *outputs[PROBLEM_VIEWS];
    list_views(set, product, outputs);
    return run(set, set->product, &set->trained, pair, outputs, error);
}

ad_status problem_set_prepare_normal(problem *p, problem_set *set, ad_error *error)
{
    return set->normal ? AD_OK : compile_normal(p, set, error);
}

/* What the rows of J are computed from, at the points that there are. */
typedef struct rows_run {
    const double *inputs[PROBLEM_INPUTS + PROBLEM_FIXED_ROWS], *uniforms[PROBLEM_UNIFORMS];
    ad_run run;
} rows_run;

static void begin_rows(problem_set *set, const double *x, rows_run *r)
{
    list_inputs(set, &set->trained, &set->normal_fixed, r->inputs);
    list_uniforms(set, r->uniforms);
    r->run = (ad_run){.points = set->trained.count,
                      .inputs = r->inputs,
                      .uniforms = r->uniforms,
                      .parameters = x};
}

ad_status problem_set_normal(problem_set *set, const double *x, double *loss, double *jtj,
                             double *jtr, ad_error *error)
{
    rows_run r;
    ad_status status = refresh_fixed(set, &set->normal_fixed, error);
    status = status == AD_OK ? problem_set_hold_rows(set, error) : status;
    if (status != AD_OK) {
        return status;
    }
    begin_rows(set, x, &r);
    return ad_normal_add(set->normal, &r.run, jtj, jtr, loss, error);
}

ad_status problem_set_jacobian(problem_set *set, const double *x, size_t first, size_t stride,
                               double *jt, double *r, ad_error *error)
{
    rows_run rows;
    ad_status status = refresh_fixed(set, &set->normal_fixed, error);
    status = status == AD_OK ? problem_set_hold_all(set, error) : status;
    if (status == AD_OK) {
        begin_rows(set, x, &rows);
        ad_normal_jacobian(set->normal, &rows.run, first, stride, jt, r);
    }
    return status;
}

static problem_place found_at(const problem *p, const problem_cloud *cloud, size_t point, int term)
{
    problem_place place = {.term = term};
    for (int i = 0; i < p->model->domain.count; i++) {
        place.x[i] =
            cloud->x[(size_t)i * cloud->count + point] * p->model->domain.coordinates[i].scale;
    }
    return place;
}

ad_status problem_set_squares(problem_set *set, const problem_cloud *cloud, const double *x,
                              double *squares, ad_error *error)
{
    double *outputs[1 + 2 * PROBLEM_SET_TERMS] = {NULL}, mean;
    if (set->problem->model->motion) {
        return problem_motion_run((problem *)set->problem, cloud, x, squares, &mean, NULL, error);
    }
    for (int i = 0; i < set->term_count; i++) {
        outputs[1 + set->term_count + i] = squares + (size_t)i * cloud->count;
    }
    return run(set, set->value, cloud, x, outputs, error);
}

ad_status problem_set_locate(problem *p, problem_set *set, const double *x, problem_place *place,
                             ad_error *error)
{
    size_t points = set->trained.count;
    double *squares = malloc((size_t)set->term_count * points * sizeof *squares);
    if (!squares) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory while looking for a bad number");
    }
    ad_status status = problem_set_hold_all(set, error); /* any of them may be the place */
    status = status == AD_OK ? problem_set_squares(set, &set->trained, x, squares, error) : status;
    for (int i = 0; status == AD_OK && i < set->term_count && place->term < 0; i++) {
        for (size_t k = 0; k < points && place->term < 0; k++) {
            if (!isfinite(squares[(size_t)i * points + k])) {
                *place = found_at(p, &set->trained, k, set->terms[i]);
            }
        }
    }
    free(squares);
    return status;
}
