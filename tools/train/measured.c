#include "tools/train/measured.h"

#include "tools/files/table_file.h"
#include "tools/train/settings_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS_MAX = 4 }; /* of a quantity */

/* One file: rows in SI units, places dimensionless. */
typedef struct measured_set {
    const physics_model *m;
    train_quantity quantity;
    int first, columns;                /* among those of the model */
    double scale;                      /* of a residual, SI */
    size_t rows, largest;              /* in all; in the window that has most */
    double *x[DOMAIN_COORDINATES_MAX]; /* [rows] */
    const double *values[COLUMNS_MAX]; /* [rows], of the table */
    table_file *table;
} measured_set;

struct measured {
    int count;
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

/* data: the columns, then the root of the weight of the row. */
static ad_value residual(const void *context, const domain_place *at, const ad_value *fields)
{
    const measured_set *set = context;
    ad_value values[MODEL_COLUMNS_MAX];
    set->m->call.observe(set->m, at, fields, values);
    ad_value now = ad_stack(set->columns, values + set->first);
    ad_value then = ad_slice(at->data, 0, set->columns);
    bool turns = set->quantity == TRAIN_ROTATION && set->columns == 4;
    ad_value off = turns
                       ? rotation_vector(ad_quaternion_multiply(ad_quaternion_conjugate(then), now))
                       : ad_sub(now, then);
    return ad_mul(ad_scale(ad_row(at->data, set->columns), 1 / set->scale), off);
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
    for (size_t row = 0; row < set->rows; row++) {
        count += is_in_window(set, row, window);
    }
    return count;
}

/* Windows with fewer rows than others have points without weight, so that all have as many. */
static ad_status fill(void *context, const model_draw *draw, ad_error *error)
{
    const measured_set *set = context;
    const domain *d = &set->m->domain;
    size_t count = rows_in_window(set, draw->window), point = 0;
    (void)error;
    for (size_t row = 0; row < set->rows; row++) {
        if (!is_in_window(set, row, draw->window)) {
            continue;
        }
        for (int i = 0; i < d->count; i++) {
            draw->x[(size_t)i * draw->count + point] = set->x[i][row];
        }
        for (int i = 0; i < set->columns; i++) {
            draw->data[(size_t)i * draw->count + point] = set->values[i][row];
        }
        draw->data[(size_t)set->columns * draw->count + point++] =
            sqrt((double)draw->count / (double)count);
    }
    for (; point < draw->count; point++) {
        for (int i = 0; i < d->count; i++) {
            draw->x[(size_t)i * draw->count + point] =
                i == d->time ? domain_window_time(d, draw->window) : d->coordinates[i].low;
        }
        for (int i = 0; i <= set->columns; i++) {
            draw->data[(size_t)i * draw->count + point] = i == 0 && set->columns == 4;
        }
    }
    return AD_OK;
}

/* ---- files --------------------------------------------------------------------------------- */

/* The columns of each quantity: of rods the first, of beams the second name on. */
static const struct {
    const char *rod, *beam;
    int rod_columns;
} columns_of[TRAIN_QUANTITY_COUNT] = {
    [TRAIN_POSITION] = {"x", "w", 3},    [TRAIN_ROTATION] = {"qw", "slope", 4},
    [TRAIN_STRAIN] = {"v1", NULL, 3},    [TRAIN_CURVATURE] = {"u1", NULL, 3},
    [TRAIN_FORCE] = {"n1", "V", 3},      [TRAIN_MOMENT] = {"m1", "M", 3},
    [TRAIN_VELOCITY] = {"vx", "w_t", 3}, [TRAIN_ANGULAR_VELOCITY] = {"w1", "slope_t", 3}};

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
    for (size_t row = 0; row < set->rows; row++) {
        largest = fmax(largest, fabs(set->values[0][row]));
    }
    return !scene_is_beam(&set->m->scene) ? of[set->quantity] : largest > 0 ? largest : 1;
}

static ad_status refuse_row(const measured_set *set, const char *file, size_t row, const char *text,
                            ad_error *error)
{
    size_t line = table_line(set->table, row);
    return line ? ad_fail(error, AD_BAD_INPUT, "%s:%zu: %s", file, line, text)
                : ad_fail(error, AD_BAD_INPUT, "%s: row %zu: %s", file, row + 1, text);
}

/* Where the rows are, within the rod, its time and its parameters. */
static ad_status take_places(measured_set *set, const char *file, ad_error *error)
{
    static const double ROUNDING = 1e-9;
    const domain *d = &set->m->domain;
    for (int i = 0; i < d->count; i++) {
        const domain_coordinate *c = &d->coordinates[i];
        const double *column = table_column(set->table, c->name);
        double slack = ROUNDING * (c->high - c->low);
        if (!column) {
            return ad_fail(error, AD_BAD_INPUT, "%s: has no column '%s', where the rows are", file,
                           c->name);
        }
        set->x[i] = malloc(set->rows * sizeof *set->x[i]);
        if (!set->x[i]) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows of data", set->rows);
        }
        for (size_t row = 0; row < set->rows; row++) {
            double x = column[row] / c->scale;
            char text[160];
            if (!(x >= c->low - slack && x <= c->high + slack)) {
                snprintf(text, sizeof text, "%s = %.9g %s lies outside; allowed: %.9g to %.9g",
                         c->name, column[row], c->unit, c->low * c->scale, c->high * c->scale);
                return refuse_row(set, file, row, text, error);
            }
            set->x[i][row] = fmin(fmax(x, c->low), c->high);
        }
    }
    return AD_OK;
}

static ad_status take_values(measured_set *set, const char *file, ad_error *error)
{
    for (int i = 0; i < set->columns; i++) {
        const char *name = set->m->columns[set->first + i].name;
        set->values[i] = table_column(set->table, name);
        if (!set->values[i]) {
            return ad_fail(error, AD_BAD_INPUT, "%s: has no column '%s'; %s has %s%s%s", file, name,
                           train_quantity_names()[set->quantity], set->m->columns[set->first].name,
                           set->columns > 1 ? " to " : "",
                           set->columns > 1 ? set->m->columns[set->first + set->columns - 1].name
                                            : "");
        }
    }
    for (size_t row = 0; row < set->rows && set->columns == 4; row++) {
        double square = 0;
        for (int i = 0; i < 4; i++) {
            square += set->values[i][row] * set->values[i][row];
        }
        if (!(fabs(square - 1) < 1e-3)) {
            return refuse_row(set, file, row,
                              "qw to qz are no unit quaternion; allowed: length 1 to 3 digits",
                              error);
        }
    }
    return AD_OK;
}

bool measured_columns(const scene *rod_scene, train_quantity quantity, int *first, int *count)
{
    const scene_physics *physics = scene_physics_of(rod_scene);
    const bool beam = scene_is_beam(rod_scene);
    const char *name = beam ? columns_of[quantity].beam : columns_of[quantity].rod;
    *count = beam ? 1 : columns_of[quantity].rod_columns;
    for (int i = 0; name && i < physics->column_count; i++) {
        if (strcmp(physics->columns[i].name, name) == 0 &&
            (scene_is_dynamic(rod_scene) || !physics->columns[i].of_motion)) {
            *first = i;
            return true;
        }
    }
    return false;
}

static ad_status read_set(measured_set *set, const train_data *of, ad_error *error)
{
    ad_status status = table_read(of->file, TABLE_FINITE, &set->table, error);
    if (status != AD_OK) {
        return status;
    }
    set->rows = table_rows(set->table);
    if (set->rows == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: has no rows; allowed: 1 at least", of->file);
    }
    status = take_places(set, of->file, error);
    status = status == AD_OK ? take_values(set, of->file, error) : status;
    for (int i = 0; status == AD_OK && i < set->m->domain.windows; i++) {
        size_t rows = rows_in_window(set, i);
        set->largest = rows > set->largest ? rows : set->largest;
    }
    return status;
}

static ad_status add_set(physics_model *m, measured_set *set, const train_data *of, int index,
                         char *key, ad_error *error)
{
    char term[MODEL_NAME];
    *set = (measured_set){.m = m, .quantity = of->quantity};
    if (!measured_columns(&m->scene, of->quantity, &set->first, &set->columns)) {
        snprintf(key, TRAIN_KEY_MAX, "data[%d].quantity", index);
        return ad_fail(error, AD_BAD_INPUT, "this scene has no %s",
                       train_quantity_names()[of->quantity]);
    }
    snprintf(key, TRAIN_KEY_MAX, "data[%d].file", index);
    ad_status status = read_set(set, of, error);
    if (status != AD_OK) {
        return status;
    }
    set->scale = of->noise > 0 ? of->noise : natural_scale(set);
    const model_source source = {
        .rows = set->columns + 1, .fill = fill, .context = set, .points = set->largest};
    snprintf(term, sizeof term, "data%d", index);
    int points = model_add_given(m, term, &source);
    snprintf(term, sizeof term, "data%d_%s", index, train_quantity_names()[of->quantity]);
    model_add_term(m, term, points, of->weight, residual, set);
    return m->error.status == AD_OK ? AD_OK : ad_fail(error, AD_BAD_INPUT, "%s", m->error.message);
}

ad_status measured_add(physics_model *m, const train_settings *settings, measured **result,
                       char key[TRAIN_KEY_MAX], ad_error *error)
{
    measured *x = calloc(1, sizeof *x);
    ad_status status = x ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for data");
    for (int i = 0; status == AD_OK && i < settings->data_count; i++) {
        x->count = i + 1;
        status = add_set(m, &x->sets[i], &settings->data[i], i, key, error);
    }
    if (status != AD_OK) {
        measured_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void measured_free(measured *x)
{
    for (int i = 0; x && i < x->count; i++) {
        for (int k = 0; k < DOMAIN_COORDINATES_MAX; k++) {
            free(x->sets[i].x[k]);
        }
        table_free(x->sets[i].table);
    }
    free(x);
}
