/* Conditions on faces that fields meet whatever a network is: a blend of what is given, and the
 * network times a factor that vanishes there. */
#include "physics/learn/model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    ORDERS = 4,   /* of conditions on a face: value and slopes up to this, exclusive */
    SAMPLES = 16, /* of the edge where two faces meet */
    PLACES = 512  /* of a face, where steep values are looked for */
};

/* Of a range, over which values on a face may change by all that they do. A front of a tenth to a
 * hundredth of it that moves away was learned worse by 1e2 to 1e8 with its start built in, since
 * the network has to take it away again at all later times. */
static const double STEEP = 10;

static const model_set *face_of(const physics_model *m, int condition)
{
    return &m->sets[m->terms[m->condition_terms[condition]].set];
}

/* Where its coordinate is held, and at which end that is. */
static double place_of(const physics_model *m, int condition)
{
    return face_of(m, condition)->value[m->conditions[condition].coordinate];
}

static int end_of(const physics_model *m, int condition)
{
    const domain_coordinate *c = &m->domain.coordinates[m->conditions[condition].coordinate];
    return place_of(m, condition) == c->high;
}

static bool same_row(const model_condition *a, const model_condition *b)
{
    return a->field == b->field && a->row == b->row;
}

static bool same_face(const physics_model *m, int a, int b)
{
    return m->conditions[a].coordinate == m->conditions[b].coordinate &&
           end_of(m, a) == end_of(m, b);
}

/* ---- which ---------------------------------------------------------------------------------- */

typedef struct comparing {
    const physics_model *m;
    ad_pool *pool;
    ad_error *error;
} comparing;

/* Whether pairs of values agree but for rounding at some places where the faces of conditions meet;
 * they are recorded at `at`, and b = a where there is one condition. */
static ad_status compare(const comparing *c, int a, int b, const domain_place *at, int pairs,
                         const ad_value *sides, bool *agree)
{
    const domain *d = &c->m->domain;
    double x[DOMAIN_COORDINATES_MAX][SAMPLES], values[2 * ORDERS][SAMPLES];
    double *outputs[2 * ORDERS];
    const double *inputs[DOMAIN_COORDINATES_MAX];
    const int held[2] = {c->m->conditions[a].coordinate, c->m->conditions[b].coordinate};
    for (int i = 0; i < d->count; i++) {
        inputs[i] = x[i];
        for (int k = 0; k < SAMPLES; k++) { /* both ends too */
            const double part = k * (2.0 * i + 1) / (SAMPLES - 1);
            const double other =
                domain_coordinate_at(&d->coordinates[i], k + 1 < SAMPLES ? part - floor(part) : 1);
            x[i][k] = i == held[0] ? place_of(c->m, a) : i == held[1] ? place_of(c->m, b) : other;
        }
    }
    for (int i = 0; i < 2 * pairs; i++) {
        outputs[i] = values[i];
    }
    const ad_run run = {
        .points = SAMPLES, .inputs = inputs, .outputs = outputs, .everywhere = true};
    const ad_status status = ad_evaluate(2 * pairs, sides, c->pool, &run, c->error);
    *agree = status == AD_OK;
    for (int i = 0; i < 2 * pairs && *agree; i += 2) {
        for (int k = 0; k < SAMPLES && *agree; k++) {
            const double one = values[i][k], two = values[i + 1][k];
            *agree = fabs(one - two) <= 1e-13 * (1 + fabs(one) + fabs(two));
        }
    }
    ad_tape_free(at->tape);
    return status;
}

static domain_place begin(const comparing *c)
{
    const domain_uniforms none = {0};
    return domain_record(&c->m->domain, &none, ad_tape_create());
}

/* What condition a says of the face of b, and the other way round. */
static ad_status compare_corner(const comparing *c, int a, int b, bool *agree)
{
    const model_condition *one = &c->m->conditions[a], *two = &c->m->conditions[b];
    const domain_place at = begin(c);
    ad_value sides[2] = {one->value(one->context, &at), two->value(two->context, &at)};
    if (two->order > 0) {
        sides[0] = ad_derivative(sides[0], at.x[two->coordinate], two->order);
    }
    if (one->order > 0) {
        sides[1] = ad_derivative(sides[1], at.x[one->coordinate], one->order);
    }
    return compare(c, a, b, &at, 1, sides, agree);
}

/* What condition a says of both ends of a periodic coordinate, with derivatives. */
static ad_status compare_round(const comparing *c, int a, int coordinate, bool *agree)
{
    const model_condition *one = &c->m->conditions[a];
    const domain_coordinate *round = &c->m->domain.coordinates[coordinate];
    const domain_place at = begin(c);
    ad_value sides[2 * ORDERS];
    const ad_value y = one->value(one->context, &at), x = at.x[coordinate];
    for (int order = 0; order < ORDERS; order++) {
        const ad_value scaled = ad_scale(order > 0 ? ad_derivative(y, x, order) : y,
                                         pow(1e-1 * (round->high - round->low), order));
        sides[2 * order] = ad_substitute(scaled, x, ad_scalar(at.tape, round->low));
        sides[2 * order + 1] = ad_substitute(scaled, x, ad_scalar(at.tape, round->high));
    }
    return compare(c, a, a, &at, ORDERS, sides, agree);
}

/* Whether what a condition says changes within a small part of the range of a coordinate. */
static ad_status find_steep(const comparing *c, int a, bool *steep)
{
    const domain *d = &c->m->domain;
    const model_condition *one = &c->m->conditions[a];
    const size_t count = (size_t)d->count;
    double *numbers = malloc((2 * count + 1) * PLACES * sizeof *numbers);
    const double *inputs[DOMAIN_COORDINATES_MAX];
    double *outputs[DOMAIN_COORDINATES_MAX + 1];
    ad_value values[DOMAIN_COORDINATES_MAX + 1];
    *steep = false;
    if (!numbers) {
        return ad_fail(c->error, AD_NO_MEMORY, "out of memory for a condition");
    }
    const domain_place at = begin(c);
    values[0] = one->value(one->context, &at);
    outputs[0] = numbers + count * PLACES;
    for (int i = 0; i < d->count; i++) {
        double *x = numbers + (size_t)i * PLACES;
        const double step = i == d->time ? 0.618033988749895 : 0.754877666246693 + 0.11 * i;
        for (int k = 0; k < PLACES; k++) {
            const double part = (k + 0.5) * step;
            x[k] = i == one->coordinate
                       ? place_of(c->m, a)
                       : domain_coordinate_at(&d->coordinates[i], part - floor(part));
        }
        inputs[i] = x;
        outputs[i + 1] = numbers + (count + (size_t)i + 1) * PLACES;
        values[i + 1] = ad_scale(ad_derivative(values[0], at.x[i], 1),
                                 d->coordinates[i].high - d->coordinates[i].low);
    }
    const ad_run run = {.points = PLACES, .inputs = inputs, .outputs = outputs, .everywhere = true};
    ad_status status = ad_evaluate(d->count + 1, values, c->pool, &run, c->error);
    if (status == AD_OK && ad_extent_of(values[0]) != AD_UNIFORM) {
        double low = INFINITY, high = -INFINITY, most = 0;
        for (int k = 0; k < PLACES; k++) {
            low = fmin(low, outputs[0][k]);
            high = fmax(high, outputs[0][k]);
        }
        for (int i = 0; i < d->count; i++) {
            for (int k = 0; k < PLACES && i != one->coordinate; k++) {
                most = fmax(most, fabs(outputs[i + 1][k]));
            }
        }
        *steep = !(most <= STEEP * (high - low) || most <= 1e-12 * (1 + fabs(high) + fabs(low)));
    }
    ad_tape_free(at.tape);
    free(numbers);
    return status;
}

/* Whether all lower orders are met on its face, and nothing else is said of it. */
static bool stands(const physics_model *m, int condition)
{
    const model_condition *c = &m->conditions[condition];
    bool lower = c->order == 0, alone = true;
    for (int i = 0; i < m->condition_count; i++) {
        const model_condition *other = &m->conditions[i];
        if (i != condition && same_row(c, other) && same_face(m, i, condition)) {
            alone = alone && other->order != c->order;
            lower = lower || (m->exact[i] && other->order == c->order - 1);
        }
    }
    return lower && alone && c->order < ORDERS;
}

static bool has_periodic(const domain *d)
{
    for (int i = 0; i < d->count; i++) {
        if (d->coordinates[i].periodic) {
            return true;
        }
    }
    return false;
}

static ad_status find_exact(physics_model *m, ad_error *error)
{
    const bool of_outputs = !model_has_ansatz(m) && !m->has_scene;
    comparing c = {.m = m, .error = error};
    bool changed = true, agree = true;
    ad_status status = ad_pool_open(1, &c.pool, error);
    for (int i = 0; i < m->condition_count; i++) {
        m->exact[i] = of_outputs && m->terms[m->condition_terms[i]].weight > 0 &&
                      !m->domain.coordinates[m->conditions[i].coordinate].periodic;
    }
    bool against[MODEL_SETS_MAX] = {false};
    for (int a = 0; a < m->condition_count; a++) {
        if (m->exact[a] && status == AD_OK) {
            bool steep;
            status = find_steep(&c, a, &steep);
            for (int b = 0; b < m->condition_count && steep; b++) {
                against[b] = against[b] || same_row(&m->conditions[a], &m->conditions[b]);
            }
        }
        for (int p = 0; p < m->domain.count && status == AD_OK && m->exact[a]; p++) {
            if (m->domain.coordinates[p].periodic) {
                status = compare_round(&c, a, p, &agree);
                against[a] = against[a] || !agree;
            }
        }
        for (int b = 0; b < a && status == AD_OK && m->exact[a]; b++) {
            const bool meet = m->exact[b] && same_row(&m->conditions[a], &m->conditions[b]) &&
                              m->conditions[a].coordinate != m->conditions[b].coordinate;
            status = meet ? compare_corner(&c, a, b, &agree) : AD_OK;
            if (meet && status == AD_OK && !agree) {
                against[a] = against[b] = true;
            }
        }
    }
    for (int i = 0; i < m->condition_count; i++) {
        m->exact[i] = m->exact[i] && !against[i];
    }
    while (changed) {
        changed = false;
        for (int i = 0; i < m->condition_count; i++) {
            if (m->exact[i] && !stands(m, i)) {
                m->exact[i] = false;
                changed = true;
            }
        }
    }
    ad_pool_free(c.pool);
    return status;
}

/* ---- the ansatz ----------------------------------------------------------------------------- */

static ad_value to_the(ad_value x, int power)
{
    ad_value y = ad_scalar(x.tape, 1);
    for (int i = 0; i < power; i++) {
        y = ad_mul(y, x);
    }
    return y;
}

/* Of degree here + there - 1: all its derivatives below `here` at z = 0 and below `there` at w = 0,
 * w = 1 - z, are 0, but that of `order` at z = 0, which is 1. */
static ad_value hermite(ad_value z, ad_value w, int order, int here, int there)
{
    double factorial = 1, binomial = 1;
    ad_value sum = ad_scalar(z.tape, 1);
    for (int k = 1; k <= order; k++) {
        factorial *= k;
    }
    for (int k = 1; k < here - order && there > 0; k++) {
        binomial *= (double)(there + k - 1) / k;
        sum = ad_add(sum, ad_scale(to_the(z, k), binomial));
    }
    return ad_scale(ad_mul(ad_mul(to_the(z, order), to_the(w, there)), sum), 1 / factorial);
}

/* Adds to what `given` says what the conditions of a row on the faces of one coordinate ask beyond
 * it, and lets `factor` vanish there. */
static void blend(const physics_model *m, const domain_place *at, int field, int row,
                  int coordinate, ad_value *given, ad_value *factor)
{
    const domain_coordinate *c = &m->domain.coordinates[coordinate];
    const double range = c->high - c->low;
    const ad_value x = at->x[coordinate], before = *given;
    const ad_value z[2] = {ad_scale(ad_sub(x, ad_scalar(at->tape, c->low)), 1 / range),
                           ad_scale(ad_sub(ad_scalar(at->tape, c->high), x), 1 / range)};
    const model_condition row_of = {.field = field, .row = row};
    int orders[2] = {0, 0};
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < m->condition_count; i++) {
            const model_condition *asked = &m->conditions[i];
            const int end = end_of(m, i);
            if (!m->exact[i] || asked->coordinate != coordinate || !same_row(asked, &row_of)) {
                continue;
            }
            if (pass == 0) {
                orders[end]++;
                continue;
            }
            const ad_value there =
                asked->order > 0 ? ad_derivative(before, x, asked->order) : before;
            const ad_value off = ad_substitute(ad_sub(asked->value(asked->context, at), there), x,
                                               ad_scalar(at->tape, place_of(m, i)));
            const ad_value shape =
                hermite(z[end], z[!end], asked->order, orders[end], orders[!end]);
            const double unit = pow(end ? -range : range, asked->order);
            *given = ad_add(*given, ad_mul(ad_scale(shape, unit), off));
        }
    }
    const int all = orders[0] + orders[1];
    if (all > 0) { /* 1 at most */
        const double most = pow(orders[0], orders[0]) * pow(orders[1], orders[1]) / pow(all, all);
        const ad_value vanishing = ad_mul(to_the(z[0], orders[0]), to_the(z[1], orders[1]));
        *factor = ad_mul(*factor, ad_scale(vanishing, 1 / most));
    }
}

static void meet_conditions(const physics_model *m, const domain_place *at, ad_value outputs,
                            ad_value *fields)
{
    for (int f = 0, output = 0; f < m->field_count; f++) {
        ad_value rows[MODEL_COLUMNS_MAX];
        for (int row = 0; row < m->field_rows[f]; row++) {
            ad_value given = ad_scalar(at->tape, 0), factor = ad_scalar(at->tape, 1);
            for (int c = 0; c < m->domain.count; c++) {
                blend(m, at, f, row, c, &given, &factor);
            }
            rows[row] = ad_add(given, ad_mul(factor, ad_row(outputs, output++)));
        }
        fields[f] = ad_stack(m->field_rows[f], rows);
    }
}

/* Sine and cosine of what goes round. */
static ad_value go_round(const physics_model *m, const domain_place *at)
{
    static const double pi = 3.14159265358979323846;
    ad_value rows[2 * DOMAIN_COORDINATES_MAX];
    int count = 0;
    for (int i = 0; i < m->domain.count; i++) {
        const ad_value x = domain_unit(&m->domain, at, i), turned = ad_scale(x, pi);
        const bool periodic = m->domain.coordinates[i].periodic;
        rows[count++] = periodic ? ad_sin(turned) : x;
        if (periodic) {
            rows[count++] = ad_cos(turned);
        }
    }
    return ad_stack(count, rows);
}

ad_status model_for_network(const physics_model *m, physics_model **result, ad_error *error)
{
    physics_model *made = *result = malloc(sizeof *made);
    if (!made) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a model");
    }
    *made = *m;
    made->columns = m->columns == m->own_columns ? made->own_columns : m->columns;
    for (int i = 0; i < MODEL_COLUMNS_MAX; i++) {
        made->own_columns[i].name = made->own_names[i];
    }
    ad_status status = m->error.status == AD_OK ? find_exact(made, error) : AD_OK;
    for (int i = 0; i < made->condition_count && status == AD_OK; i++) {
        if (made->exact[i]) {
            made->terms[made->condition_terms[i]].weight = 0;
            made->call.ansatz = meet_conditions;
        }
    }
    if (has_periodic(&made->domain) && !made->call.input) {
        made->call.input = go_round;
        made->inputs = 0;
        for (int i = 0; i < made->domain.count; i++) {
            made->inputs += made->domain.coordinates[i].periodic ? 2 : 1;
        }
    }
    if (status != AD_OK) {
        model_free(made);
        *result = NULL;
    }
    return status;
}

bool model_condition_is_exact(const physics_model *m, int term)
{
    for (int i = 0; i < m->condition_count; i++) {
        if (m->condition_terms[i] == term) {
            return m->exact[i];
        }
    }
    return false;
}
