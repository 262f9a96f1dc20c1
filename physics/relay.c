#include "physics/relay.h"
#include "physics/constants.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

size_t relay_numbers(const physics_model *m)
{
    return 2 * RELAY_POINTS * (size_t)m->state_rows;
}

/* Chebyshev's points of [0, 1], from 1 down to 0. */
static double relay_point(int j)
{
    return (1 + cos(PI * j / RELAY_DEGREE)) / 2;
}

/* ---- on the tape --------------------------------------------------------------------------- */

/* Chebyshev's polynomials T_k(2s - 1). */
static ad_value chebyshev_polynomials(ad_value s)
{
    ad_value powers[RELAY_POINTS] = {ad_scalar(s.tape, 1)};
    ad_value x = powers[1] = ad_sub(ad_scale(s, 2), powers[0]);
    for (int k = 2; k < RELAY_POINTS; k++) {
        powers[k] = ad_sub(ad_scale(ad_mul(x, powers[k - 1]), 2), powers[k - 2]);
    }
    return ad_stack(RELAY_POINTS, powers);
}

ad_value relay_state(const domain_place *at, int rows, bool going)
{
    int numbers = RELAY_POINTS * rows;
    ad_value coefficients = ad_slice(at->state, going ? numbers : 0, numbers);
    return ad_matvec_transposed(coefficients, chebyshev_polynomials(at->x[0]));
}

/* ---- polynomials of low degree ------------------------------------------------------------- */

/* At point `point` by the barycentric formula (Berrut & Trefethen 2004, SIAM Review 46). */
static double interpolate(const double *values, int rows, int degree, int point)
{
    int step = RELAY_DEGREE / degree;
    double above = 0, below = 0, x = cos(PI * point / RELAY_DEGREE);
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

double relay_misfit(const double *values, int rows, int first, int count, int degree)
{
    double largest = 0;
    for (int point = 0; point < RELAY_POINTS; point++) {
        for (int i = first; i < first + count; i++) {
            double found = interpolate(values + i, rows, degree, point);
            largest = fmax(largest, fabs(found - values[point * rows + i]));
        }
    }
    return largest;
}

/* From values at the points to coefficients of Chebyshev's polynomials (Trefethen 2013,
 * Approximation Theory and Approximation Practice, ch. 3). */
static void transform(const double *values, int rows, double *coefficients)
{
    for (int k = 0; k < RELAY_POINTS; k++) {
        for (int i = 0; i < rows; i++) {
            double sum = 0;
            for (int j = 0; j < RELAY_POINTS; j++) {
                double ends = (j % RELAY_DEGREE ? 1 : 2) * (k % RELAY_DEGREE ? 1 : 2);
                sum += 2 * cos(PI * j * k / RELAY_DEGREE) / (ends * RELAY_DEGREE) *
                       values[j * rows + i];
            }
            coefficients[k * rows + i] = sum;
        }
    }
}

/* A state from its values [RELAY_POINTS][rows]. */
static void write_state(const physics_model *m, const double *values, double *state)
{
    double going[RELAY_POINTS * MODEL_STATE_ROWS_MAX];
    int rows = m->state_rows, degree = m->call.going_degree(m, values);
    for (int point = 0; point < RELAY_POINTS; point++) {
        for (int i = 0; i < rows; i++) {
            going[point * rows + i] = interpolate(values + i, rows, degree, point);
        }
    }
    transform(values, rows, state);
    transform(going, rows, state + RELAY_POINTS * rows);
}

/* ---- from window to window ----------------------------------------------------------------- */

typedef struct relay_program {
    ad_program *program; /* NULL: not needed yet */
    bool is_uniform[MODEL_STATE_ROWS_MAX];
} relay_program;

struct relay {
    const physics_model *model;
    const nn_mlp *mlp;
    ad_pool *pool;
    relay_program programs[2]; /* of the first window, of a later one */
};

ad_status relay_create(const physics_model *m, const nn_mlp *mlp, ad_pool *pool, relay **result,
                       ad_error *error)
{
    relay *r = *result = calloc(1, sizeof *r);
    if (!r) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for windows of time");
    }
    *r = (relay){.model = m, .mlp = mlp, .pool = pool};
    return AD_OK;
}

void relay_free(relay *r)
{
    if (r) {
        ad_program_free(r->programs[0].program);
        ad_program_free(r->programs[1].program);
        free(r);
    }
}

static ad_status build(relay *r, int window, relay_program *made, ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    if (!tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    const physics_model *m = r->model;
    ad_value fields[MODEL_FIELDS_MAX], rows[MODEL_STATE_ROWS_MAX];
    domain_place at = model_record(m, window, r->mlp, tape, fields);
    m->call.state(m, &at, fields, rows);
    ad_value end = ad_add(at.start, at.span);
    for (int i = 0; i < m->state_rows; i++) {
        rows[i] = ad_substitute(rows[i], at.x[m->domain.time], end);
        made->is_uniform[i] = ad_extent_of(rows[i]) == AD_UNIFORM;
    }
    ad_status status = ad_compile(m->state_rows, rows, NULL, r->pool, &made->program, error);
    ad_tape_free(tape);
    return status;
}

ad_status relay_run(relay *r, int index, const double *start, const double *x, double *end,
                    ad_error *error)
{
    const physics_model *m = r->model;
    relay_program *made = &r->programs[index > 0];
    ad_status status = made->program ? AD_OK : build(r, index, made, error);
    double s[RELAY_POINTS], unused[RELAY_POINTS] = {0}, found[MODEL_STATE_ROWS_MAX][RELAY_POINTS];
    double *outputs[MODEL_STATE_ROWS_MAX], begin = domain_window_time(&m->domain, index);
    const double *inputs[DOMAIN_COORDINATES_MAX] = {s}, *uniforms[DOMAIN_UNIFORMS_MAX];
    domain_uniforms kinds = model_uniforms(m, index);
    domain_setting setting = {{begin, domain_window_time(&m->domain, index + 1) - begin}, start, 1};
    domain_list_uniforms(&kinds, &setting, uniforms);
    for (int i = 1; i < m->domain.count; i++) {
        inputs[i] = unused;
    }
    for (int j = 0; j < RELAY_POINTS; j++) {
        s[j] = relay_point(j);
    }
    for (int i = 0; i < m->state_rows; i++) {
        outputs[i] = found[i];
    }
    const ad_run run = {.points = RELAY_POINTS,
                        .inputs = inputs,
                        .uniforms = uniforms,
                        .parameters = x,
                        .outputs = outputs};
    status = status == AD_OK ? ad_execute(made->program, &run, error) : status;
    double values[RELAY_POINTS * MODEL_STATE_ROWS_MAX];
    for (int j = 0; status == AD_OK && j < RELAY_POINTS; j++) {
        for (int i = 0; i < m->state_rows; i++) {
            values[j * m->state_rows + i] = found[i][made->is_uniform[i] ? 0 : j];
        }
    }
    if (status == AD_OK) {
        write_state(m, values, end);
    }
    return status;
}
