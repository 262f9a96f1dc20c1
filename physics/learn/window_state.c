#include "physics/learn/window_state.h"
#include "physics/learn/motion_network.h"
#include "physics/numerics/constants.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of one piece of s, or of its part that goes on. */
static size_t piece_numbers(int rows)
{
    return WINDOW_STATE_POINTS * (size_t)rows;
}

/* Points of a parameter of a family, of as many as there are. */
static int points_of(int parameters)
{
    static const int points[WINDOW_STATE_PARAMETERS_MAX + 1] = {1, 11, 7};
    return points[parameters];
}

/* Members of a family at whose points states are handed on. */
static int members_of(int parameters)
{
    int members = 1;
    for (int i = 0; i < parameters; i++) {
        members *= points_of(parameters);
    }
    return members;
}

static int parameters_of(const domain *d)
{
    return d->count - (d->time >= 0 ? 2 : 1);
}

size_t window_state_numbers(const physics_model *m)
{
    const int parameters = parameters_of(&m->domain); /* of more there is one window */
    if (m->motion) {
        return 2 * (size_t)m->motion->size;
    }
    const size_t members =
        parameters <= WINDOW_STATE_PARAMETERS_MAX ? (size_t)members_of(parameters) : 0;
    return 2 * (size_t)domain_pieces(&m->domain) * members * piece_numbers(m->state_rows);
}

/* Chebyshev's points of [0, 1], from 1 down to 0. */
static double window_state_point(int j)
{
    return (1 + cos(PI * j / WINDOW_STATE_DEGREE)) / 2;
}

/* ---- on the tape --------------------------------------------------------------------------- */

/* Chebyshev's polynomials T_k(x), k < count. */
static void chebyshev_polynomials(ad_value x, int count, ad_value *powers)
{
    powers[0] = ad_scalar(x.tape, 1);
    powers[1] = x;
    for (int k = 2; k < count; k++) {
        powers[k] = ad_sub(ad_scale(ad_mul(x, powers[k - 1]), 2), powers[k - 2]);
    }
}

/* Products of the polynomials of s and of all parameters, those of s fastest. */
static ad_value all_polynomials(const domain_place *at, ad_value x)
{
    const int parameters = at->over ? parameters_of(at->over) : 0, each = points_of(parameters);
    ad_value along[WINDOW_STATE_POINTS], rows[WINDOW_STATE_MEMBERS_MAX],
        powers[WINDOW_STATE_POINTS];
    int count = 1;
    chebyshev_polynomials(x, WINDOW_STATE_POINTS, along);
    rows[0] = ad_stack(WINDOW_STATE_POINTS, along);
    for (int i = 0; i < parameters; i++) {
        const int coordinate = at->over->count - parameters + i;
        chebyshev_polynomials(domain_unit(at->over, at, coordinate), each, powers);
        for (int k = each - 1; k >= 0; k--) {
            for (int j = 0; j < count; j++) {
                rows[k * count + j] = k ? ad_mul(powers[k], rows[j]) : rows[j];
            }
        }
        count *= each;
    }
    return count > 1 ? ad_stack(count, rows) : rows[0];
}

ad_value window_state_state(const domain_place *at, int rows, bool going)
{
    int pieces = at->over ? domain_pieces(at->over) : 1;
    int members = at->over ? members_of(parameters_of(at->over)) : 1;
    int numbers = members * (int)piece_numbers(rows);
    int first = going ? pieces * numbers : 0;
    if (pieces == 1) {
        ad_value x = ad_sub(ad_scale(at->x[0], 2), ad_scalar(at->tape, 1));
        ad_value coefficients = ad_slice(at->state, first, numbers);
        return ad_matvec_transposed(coefficients, all_polynomials(at, x));
    }
    domain_local local = domain_local_of(at->over, at->x[0]);
    ad_value polynomials = all_polynomials(at, local.x), state = ad_zeros(at->tape, rows);
    for (int k = 0; k < pieces; k++) {
        ad_value coefficients = ad_slice(at->state, first + k * numbers, numbers);
        ad_value there = ad_matvec_transposed(coefficients, polynomials);
        state = ad_add(state, ad_mul(local.mask[k], there));
    }
    return state;
}

/* ---- polynomials of low degree ------------------------------------------------------------- */

/* At point `point` by the barycentric formula (Berrut & Trefethen 2004, SIAM Review 46). */
static double interpolate(const double *values, int rows, int degree, int point)
{
    int step = WINDOW_STATE_DEGREE / degree;
    double above = 0, below = 0, x = cos(PI * point / WINDOW_STATE_DEGREE);
    if (point % step == 0) {
        return values[point * rows];
    }
    for (int j = 0; j <= degree; j++) {
        double weight = (j % 2 ? -1 : 1) * (j % degree ? 1 : 0.5) / (x - cos(PI * j / degree));
        above += weight * values[j * step * rows];
        below += weight;
    }
    return above / below;
}

double window_state_misfit(const double *values, int rows, int first, int count, int degree)
{
    double largest = 0;
    for (int point = 0; point < WINDOW_STATE_POINTS; point++) {
        for (int i = first; i < first + count; i++) {
            double found = interpolate(values + i, rows, degree, point);
            largest = fmax(largest, fabs(found - values[point * rows + i]));
        }
    }
    return largest;
}

/* From values [degree + 1][rows] at the points to coefficients of Chebyshev's polynomials
 * (Trefethen 2013, Approximation Theory and Approximation Practice, ch. 3). */
static void transform(const double *values, int degree, int rows, double *coefficients)
{
    for (int k = 0; k <= degree; k++) {
        for (int i = 0; i < rows; i++) {
            double sum = 0;
            for (int j = 0; j <= degree; j++) {
                double ends = (j % degree ? 1 : 2) * (k % degree ? 1 : 2);
                sum += 2 * cos(PI * j * k / degree) / (ends * degree) * values[j * rows + i];
            }
            coefficients[k * rows + i] = sum;
        }
    }
}

/* The same along every parameter, in place: [pieces][last parameter]...[first][numbers of s]. */
static ad_status transform_members(const physics_model *m, double *state, ad_error *error)
{
    const int parameters = parameters_of(&m->domain), each = points_of(parameters);
    const size_t all = window_state_numbers(m) / 2;
    size_t stride = piece_numbers(m->state_rows);
    double *copy = parameters ? malloc(all * sizeof *copy) : NULL;
    if (parameters && !copy) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a state");
    }
    for (int i = 0; i < parameters; i++, stride *= (size_t)each) {
        memcpy(copy, state, all * sizeof *copy);
        for (size_t first = 0; first < all; first += stride * (size_t)each) {
            transform(copy + first, each - 1, (int)stride, state + first);
        }
    }
    free(copy);
    return AD_OK;
}

/* A state from its values [pieces][members][WINDOW_STATE_POINTS][rows]. */
static ad_status write_state(const physics_model *m, const double *values, double *state,
                             ad_error *error)
{
    double going[WINDOW_STATE_POINTS * MODEL_STATE_ROWS_MAX], *begin = state;
    int rows = m->state_rows, degree = 1;
    int pieces = domain_pieces(&m->domain) * members_of(parameters_of(&m->domain));
    size_t numbers = piece_numbers(rows);
    for (int k = 0; k < pieces; k++) {
        int needed = m->call.going_degree(m, values + (size_t)k * numbers);
        degree = needed > degree ? needed : degree;
    }
    for (int k = 0; k < pieces; k++, values += numbers, state += numbers) {
        for (int point = 0; point < WINDOW_STATE_POINTS; point++) {
            for (int i = 0; i < rows; i++) {
                going[point * rows + i] = interpolate(values + i, rows, degree, point);
            }
        }
        transform(values, WINDOW_STATE_DEGREE, rows, state);
        transform(going, WINDOW_STATE_DEGREE, rows, state + (size_t)pieces * numbers);
    }
    ad_status status = transform_members(m, begin, error);
    return status == AD_OK ? transform_members(m, begin + (size_t)pieces * numbers, error) : status;
}

/* ---- from window to window ----------------------------------------------------------------- */

struct window_state {
    const physics_model *model;
    const nn_mlp *mlp;
    ad_pool *pool;
    ad_program *programs[2]; /* of the first window, of a later one; NULL: not needed yet */
    motion_network *motion;  /* of a model of such */
};

ad_status window_state_create(const physics_model *m, const nn_mlp *mlp, ad_pool *pool,
                              window_state **result, ad_error *error)
{
    window_state *r = *result = calloc(1, sizeof *r);
    if (!r) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for windows of time");
    }
    *r = (window_state){.model = m, .mlp = mlp, .pool = pool};
    return AD_OK;
}

void window_state_free(window_state *r)
{
    if (r) {
        ad_program_free(r->programs[0]);
        ad_program_free(r->programs[1]);
        motion_network_free(r->motion);
        free(r);
    }
}

static ad_status build(window_state *r, int window, ad_program **made, ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    const physics_model *m = r->model;
    ad_value fields[MODEL_FIELDS_MAX], rows[MODEL_STATE_ROWS_MAX];
    domain_place at = model_record(m, window, r->mlp, tape, fields);
    m->call.state(m, &at, fields, rows);
    ad_value end = ad_add(at.start, at.span);
    for (int i = 0; i < m->state_rows; i++) {
        rows[i] = ad_substitute(rows[i], at.x[m->domain.time], end);
    }
    ad_status status = ad_compile(m->state_rows, rows, NULL, r->pool, made, error);
    ad_tape_free(tape);
    return status;
}

/* The points of a piece, by more than rounding within where it meets another: what jumps there is
 * that of the piece. */
static void place_points(const domain *d, int piece, double s[WINDOW_STATE_POINTS])
{
    double low, high, off = domain_pieces(d) > 1 ? 4 * DBL_EPSILON : 0;
    domain_piece(d, piece, &low, &high);
    for (int j = 0; j < WINDOW_STATE_POINTS; j++) {
        double at = domain_pieces(d) > 1 ? low + (high - low) * window_state_point(j)
                                         : window_state_point(j);
        s[j] = fmax(low + off, fmin(high - off, at));
    }
}

/* Of parameter `i` at its points of member `member`, dimensionless. */
static double member_at(const domain *d, int member, int i)
{
    const int parameters = parameters_of(d), each = points_of(parameters);
    for (int k = 0; k < i; k++) {
        member /= each;
    }
    return domain_coordinate_at(&d->coordinates[d->count - parameters + i],
                                (1 + cos(PI * (member % each) / (each - 1))) / 2);
}

/* values [WINDOW_STATE_POINTS][rows] of the end of window `index` in one piece, of one member. */
static ad_status run_piece(const window_state *r, ad_program *program, int index, int piece,
                           int member, const double *start, const double *x, double *values,
                           ad_error *error)
{
    const physics_model *m = r->model;
    const int parameters = parameters_of(&m->domain);
    double s[WINDOW_STATE_POINTS], unused[WINDOW_STATE_POINTS] = {0},
                                   found[MODEL_STATE_ROWS_MAX][WINDOW_STATE_POINTS];
    double of_member[WINDOW_STATE_PARAMETERS_MAX][WINDOW_STATE_POINTS];
    double *outputs[MODEL_STATE_ROWS_MAX];
    const double *inputs[DOMAIN_COORDINATES_MAX] = {s, unused}, *uniforms[DOMAIN_UNIFORMS_MAX];
    domain_uniforms kinds = model_uniforms(m, index);
    const domain_setting setting = domain_setting_of(&m->domain, index, start, 1);
    domain_list_uniforms(&kinds, &setting, uniforms);
    for (int i = 0; i < parameters; i++) {
        for (int j = 0; j < WINDOW_STATE_POINTS; j++) {
            of_member[i][j] = member_at(&m->domain, member, i);
        }
        inputs[m->domain.count - parameters + i] = of_member[i];
    }
    place_points(&m->domain, piece, s);
    for (int i = 0; i < m->state_rows; i++) {
        outputs[i] = found[i];
    }
    const ad_run run = {.points = WINDOW_STATE_POINTS,
                        .inputs = inputs,
                        .uniforms = uniforms,
                        .parameters = x,
                        .outputs = outputs,
                        .everywhere = true};
    ad_status status = ad_execute(program, &run, error);
    for (int j = 0; status == AD_OK && j < WINDOW_STATE_POINTS; j++) {
        for (int i = 0; i < m->state_rows; i++) {
            values[j * m->state_rows + i] = found[i][j];
        }
    }
    return status;
}

static ad_status window_state_motion(window_state *r, int index, const double *start,
                                     const double *x, double *end, ad_error *error)
{
    const double last = domain_window_time(&r->model->domain, index + 1);
    double *y = malloc(3 * (size_t)r->model->motion->size * sizeof *y);
    ad_status status = y ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a state");
    if (status == AD_OK && !r->motion) {
        status = motion_network_create(r->model, r->mlp, r->pool, &r->motion, error);
    }
    if (status == AD_OK) {
        status = motion_network_at(r->motion, index, 1, &last, error);
    }
    if (status == AD_OK) {
        motion_network_state(r->motion, 0, index > 0 ? start : NULL, x, y);
        memcpy(end, y, window_state_numbers(r->model) * sizeof *end);
    }
    free(y);
    return status;
}

ad_status window_state_run(window_state *r, int index, const double *start, const double *x,
                           double *end, ad_error *error)
{
    const physics_model *m = r->model;
    if (m->motion) {
        return window_state_motion(r, index, start, x, end, error);
    }
    ad_program **made = &r->programs[index > 0];
    size_t numbers = piece_numbers(m->state_rows);
    int members = members_of(parameters_of(&m->domain));
    int blocks = domain_pieces(&m->domain) * members;
    double *values = malloc(((size_t)blocks * numbers + 1) * sizeof *values);
    ad_status status = values ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a state");
    if (status == AD_OK && !*made) {
        status = build(r, index, made, error);
    }
    for (int k = 0; status == AD_OK && k < blocks; k++) {
        status = run_piece(r, *made, index, k / members, k % members, start, x,
                           values + (size_t)k * numbers, error);
    }
    if (status == AD_OK) {
        status = write_state(m, values, end, error);
    }
    free(values);
    return status;
}
