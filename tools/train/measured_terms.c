#include "tools/train/measured_terms.h"

#include "tools/train/measurements.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The rows of one file, and their places as the model has them. */
typedef struct measured_set {
    const physics_model *m;
    train_quantity quantity;
    const solve_measured *rows;
    double scale;                      /* of a residual, SI */
    size_t largest;                    /* rows in the window that has most */
    double *x[DOMAIN_COORDINATES_MAX]; /* [rows] */
} measured_set;

struct measured {
    int count;
    measurements *files;
    measured_set sets[TRAIN_DATA_MAX];
};

/* ---- residuals ----------------------------------------------------------------------------- */

/* The rotation vector of a unit quaternion of either sign, smooth at angle 0: with z = |vec|^2 it
 * is 2 asin(sqrt z)/sqrt z vec, by its series where z is small. */
static ad_value rotation_vector(ad_value q)
{
    static const double SMALL = 1e-4;
    ad_value one = ad_scalar(q.tape, 1), small = ad_scalar(q.tape, SMALL);
    ad_value sign = ad_select(ad_neg(ad_row(q, 0)), ad_neg(one), one);
    ad_value part = ad_mul(sign, ad_slice(q, 1, 3)), z = ad_dot(part, part);
    ad_value sine = ad_sqrt(ad_max(z, small));
    ad_value far = ad_div(ad_atan2(sine, ad_mul(sign, ad_row(q, 0))), sine);
    ad_value near = ad_add(ad_scalar(q.tape, 3.0 / 40), ad_scale(z, 15.0 / 336));
    near = ad_add(one, ad_mul(z, ad_add(ad_scalar(q.tape, 1.0 / 6), ad_mul(z, near))));
    return ad_mul(ad_scale(ad_select(ad_sub(z, small), far, near), 2), part);
}

/* data: the columns, then for each the root of its weight, 0 where its number is missing. */
static ad_value residual(const void *context, const domain_place *at, const ad_value *fields)
{
    const measured_set *set = context;
    ad_value values[MODEL_COLUMNS_MAX];
    set->m->call.observe(set->m, at, fields, values);
    const int columns = set->rows->columns;
    ad_value now = ad_stack(columns, values + set->rows->column[0]);
    ad_value then = ad_slice(at->data, 0, columns);
    bool turns = set->quantity == TRAIN_ROTATION && columns == 4;
    ad_value off = turns
                       ? rotation_vector(ad_quaternion_multiply(ad_quaternion_conjugate(then), now))
                       : ad_sub(now, then);
    ad_value weights = ad_slice(at->data, columns, turns ? 3 : columns);
    return ad_mul(ad_scale(weights, 1 / set->scale), off);
}

/* ---- points -------------------------------------------------------------------------------- */

static bool is_in_window(const measured_set *set, size_t row, int window)
{
    const domain *d = &set->m->domain;
    return d->time < 0 || domain_window_at(d, set->x[d->time][row]) == window;
}

static size_t rows_in_window(const measured_set *set, int window)
{
    size_t count = 0;
    for (size_t row = 0; row < set->rows->rows; row++) {
        count += is_in_window(set, row, window);
    }
    return count;
}

/* Windows with fewer rows than others have points without weight, so that all have as many. */
static ad_status fill(void *context, const model_draw *draw, ad_error *error)
{
    const measured_set *set = context;
    const solve_measured *rows = set->rows;
    const domain *d = &set->m->domain;
    size_t count = rows_in_window(set, draw->window), point = 0;
    (void)error;
    for (size_t row = 0; row < set->rows->rows; row++) {
        if (!is_in_window(set, row, draw->window)) {
            continue;
        }
        for (int i = 0; i < d->count; i++) {
            draw->x[(size_t)i * draw->count + point] = set->x[i][row];
        }
        for (int i = 0; i < rows->columns; i++) {
            const double value = rows->values[(size_t)i * rows->rows + row];
            draw->data[(size_t)i * draw->count + point] = isnan(value) ? 0 : value;
            draw->data[(size_t)(rows->columns + i) * draw->count + point] =
                isnan(value) ? 0 : sqrt((double)draw->count / (double)count);
        }
        point++;
    }
    for (; point < draw->count; point++) {
        for (int i = 0; i < d->count; i++) {
            draw->x[(size_t)i * draw->count + point] =
                i == d->time ? domain_window_time(d, draw->window) : d->coordinates[i].low;
        }
        for (int i = 0; i < 2 * rows->columns; i++) {
            draw->data[(size_t)i * draw->count + point] = i == 0 && rows->columns == 4;
        }
    }
    return AD_OK;
}

/* ---- files --------------------------------------------------------------------------------- */

static double natural_scale(const measured_set *set)
{
    const rod_scales scale = rod_scales_of(&set->m->scene);
    const double of[TRAIN_QUANTITY_COUNT] = {[TRAIN_POSITION] = scale.length,
                                             [TRAIN_ROTATION] = 1,
                                             [TRAIN_STRAIN] = 1,
                                             [TRAIN_CURVATURE] = 1 / scale.length,
                                             [TRAIN_FORCE] = scale.force,
                                             [TRAIN_MOMENT] = scale.moment,
                                             [TRAIN_VELOCITY] = scale.length / scale.time,
                                             [TRAIN_ANGULAR_VELOCITY] = 1 / scale.time};
    double largest = 0;
    for (size_t row = 0; row < set->rows->rows; row++) {
        largest = fmax(largest, fabs(set->rows->values[row])); /* NaN is passed over */
    }
    return !scene_is_beam(&set->m->scene) ? of[set->quantity] : largest > 0 ? largest : 1;
}

/* Where the rows are, dimensionless and within the domain. */
static ad_status take_places(measured_set *set, ad_error *error)
{
    const solve_measured *rows = set->rows;
    const scene *of = &set->m->scene;
    const domain *d = &set->m->domain;
    const int first = d->count - scene_known_count(of); /* of the parameters */
    for (int i = 0; i < d->count; i++) {
        const domain_coordinate *c = &d->coordinates[i];
        set->x[i] = malloc(rows->rows * sizeof *set->x[i]);
        if (!set->x[i]) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows of data", rows->rows);
        }
        for (size_t row = 0; row < rows->rows; row++) {
            const double *known = rows->known + row * (size_t)of->parameter_count;
            const double at = i >= first     ? known[i - first]
                              : i == d->time ? rows->t[row]
                                             : rows->s[row];
            set->x[i][row] = fmin(fmax(at / c->scale, c->low), c->high);
        }
    }
    return AD_OK;
}

/* Where there are unknowns every row counts by its noise alone, in whichever file it is, though the
 * loss of a term is a mean over its own rows. */
static double share_of(const measured *measured, const measured_set *set)
{
    double rows = 0;
    for (int i = 0; i < measurements_count(measured->files); i++) {
        rows += (double)measurements_sets(measured->files)[i].rows;
    }
    return set->m->scene.unknown_count > 0 ? (double)set->rows->rows / rows : 1;
}

static ad_status add_set(physics_model *m, measured *measured, const train_data *of, int index,
                         ad_error *error)
{
    char term[MODEL_NAME];
    measured_set *set = &measured->sets[measured->count - 1];
    *set = (measured_set){.m = m,
                          .quantity = of->quantity,
                          .rows = &measurements_sets(measured->files)[measured->count - 1]};
    if (set->rows->view || of->robust != TRAIN_SQUARES) {
        return ad_fail(error, AD_BAD_INPUT,
                       "has a marker, a frame, a delay or a loss of its own; networks take squares "
                       "of points of the axis, cpinn-solve finds unknowns from others, too");
    }
    ad_status status = take_places(set, error);
    for (int i = 0; status == AD_OK && i < m->domain.windows; i++) {
        size_t rows = rows_in_window(set, i);
        set->largest = rows > set->largest ? rows : set->largest;
    }
    if (status != AD_OK) {
        return status;
    }
    set->scale = of->noise > 0 ? of->noise : natural_scale(set);
    const model_source source = {
        .rows = 2 * set->rows->columns, .fill = fill, .context = set, .points = set->largest};
    snprintf(term, sizeof term, "data%d", index);
    int points = model_add_given(m, term, &source);
    snprintf(term, sizeof term, "data%d_%s", index, train_quantity_names()[of->quantity]);
    model_add_term(m, term, points, of->weight * share_of(measured, set), residual, set);
    return m->error.status == AD_OK ? AD_OK : ad_fail(error, AD_BAD_INPUT, "%s", m->error.message);
}

ad_status measured_add(physics_model *m, const train_settings *settings, measured **result,
                       char key[TRAIN_KEY_MAX], ad_error *error)
{
    measured *x = calloc(1, sizeof *x);
    ad_status status = x ? measurements_read(&m->scene, settings, &x->files, key, error)
                         : ad_fail(error, AD_NO_MEMORY, "out of memory for data");
    while (status == AD_OK && x->count < measurements_count(x->files)) {
        const int entry = measurements_entry(x->files, x->count++);
        snprintf(key, TRAIN_KEY_MAX, "data[%d].file", entry);
        status = add_set(m, x, &settings->data[entry], entry, error);
    }
    if (status != AD_OK) {
        measured_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

bool measured_tells_noise(const measured *measured)
{
    return measurements_tell_noise(measured->files);
}

double measured_unit(const measured *measured)
{
    return measurements_tell_noise(measured->files) ? 1 : measured->sets[0].scale;
}

size_t measured_missing(const measured *measured)
{
    size_t count = 0;
    for (int i = 0; i < measured->count; i++) {
        count += solve_measured_missing(measured->sets[i].rows);
    }
    return count;
}

size_t measured_fields_missing(const measured *measured)
{
    return measurements_missing(measured->files);
}

void measured_free(measured *measured)
{
    for (int i = 0; measured && i < measured->count; i++) {
        for (int k = 0; k < DOMAIN_COORDINATES_MAX; k++) {
            free(measured->sets[i].x[k]);
        }
    }
    if (measured) {
        measurements_free(measured->files);
    }
    free(measured);
}
