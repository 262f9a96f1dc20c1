#include "tools/train/train_law.h"

#include "nn/rng.h"
#include "tools/files/table_file.h"
#include "tools/train/least_squares.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { N = SCENE_LAW_STRAINS };
static const char *const STRAINS[N] = {"v1", "v2", "v3", "u1", "u2", "u3"};
static const char *const STRESSES[N] = {"n1", "n2", "n3", "m1", "m2", "m3"};

/* A strain or stress this much smaller than others of its kind counts as if it were so large. */
static const double SMALLEST = 1e-3;

train_law_settings train_law_defaults(void)
{
    return (train_law_settings){
        .symmetry = SCENE_SYMMETRY_NONE, .units = 16, .starts = 3, .steps = 300, .held_out = 0.2};
}

/* ---- data ---------------------------------------------------------------------------------- */

void train_law_free_data(train_law_data *data)
{
    free(data->strain[0]);
    *data = (train_law_data){.rows = 0};
}

ad_status train_law_read_data(const char *path, train_law_data *data, ad_error *error)
{
    table_file *file = NULL;
    ad_status status = table_read(path, TABLE_MEASURED, &file, error);
    *data = (train_law_data){.rows = 0};
    if (status != AD_OK) {
        return status;
    }
    const size_t rows = table_rows(file);
    double *all = calloc(rows * 2 * N + 1, sizeof *all);
    status = all ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", rows);
    data->rows = rows;
    bool any = false;
    for (int i = 0; i < N && all; i++) {
        const double *strain = NULL, *stress = NULL;
        if (status == AD_OK) {
            status = table_find(file, STRAINS[i], TABLE_FINITE, &strain, error);
        }
        if (status == AD_OK) {
            status = table_find(file, STRESSES[i], TABLE_FINITE, &stress, error);
        }
        data->strain[i] = all + (size_t)i * rows;
        data->stress[i] = all + (size_t)(N + i) * rows;
        data->known[i] = strain && stress;
        any = any || data->known[i];
        if (status == AD_OK && !strain != !stress) {
            status =
                ad_fail(error, AD_BAD_INPUT,
                        "%s: has a column %s, but no %s; allowed: both or "
                        "none of them",
                        path, strain ? STRAINS[i] : STRESSES[i], strain ? STRESSES[i] : STRAINS[i]);
        }
        for (size_t r = 0; r < rows && data->known[i]; r++) {
            data->strain[i][r] = strain[r] - (i == 2);
            data->stress[i][r] = stress[r];
        }
    }
    table_free(file);
    if (status == AD_OK && !any) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s: has no strain with its force or moment; allowed: columns v1, v2, v3, "
                         "u1, u2, u3 beside n1, n2, n3, m1, m2, m3, some of them",
                         path);
    }
    if (status != AD_OK && all) {
        train_law_free_data(data);
    }
    return status;
}

/* ---- the fit ------------------------------------------------------------------------------- */

/* Everything is scaled: strains by law->scale, stresses times that by `unit`, so that a, c are
 * numbers about 1; a residual is a difference of stresses over their root mean square. */
typedef struct law_fit {
    const train_law_settings *asked;
    scene_law *law;
    double unit;     /* N */
    double by[N];    /* of a residual; 0: not known */
    size_t rows[2];  /* trained on, held out */
    double *data[2]; /* strains, stresses [2 N][rows] */
    int features;
    size_t count; /* parameters */
    least_squares ls;
    ad_normal *normal;
    ad_program *sum; /* of squares */
    double *best;    /* [count], of the network to be taken */
    double found[3]; /* its sum of squares over rows held out, its step and start */
    ad_error error;
} law_fit;

/* Root mean squares of a kind (v, u, n, m) of the rows, none below SMALLEST of the largest; both
 * strains across are alike for a round law. */
static void sizes(const law_fit *fit, const train_law_data *data, double *const *columns,
                  double *size)
{
    for (int i = 0; i < N; i++) {
        size[i] = 0;
        for (size_t r = 0; r < data->rows; r++) {
            size[i] += columns[i][r] * columns[i][r] / (double)data->rows;
        }
        size[i] = sqrt(size[i]);
    }
    for (int first = 0; first < N; first += 3) {
        if (fit->asked->symmetry == SCENE_SYMMETRY_ROUND) {
            size[first] = size[first + 1] = fmax(size[first], size[first + 1]);
        }
        const double most = fmax(size[first], fmax(size[first + 1], size[first + 2]));
        for (int i = first; i < first + 3; i++) {
            size[i] = fmax(size[i], SMALLEST * most);
        }
    }
}

static ad_status set_scales(law_fit *fit, const train_law_data *data, ad_error *error)
{
    scene_law *law = fit->law;
    double strain[N], stress[N];
    sizes(fit, data, data->strain, strain);
    sizes(fit, data, data->stress, stress);
    for (int i = 0; i < N; i++) {
        const int partner = i % 3 < 2 ? i - i % 3 + 1 - i % 3 : i;
        const bool round = fit->asked->symmetry == SCENE_SYMMETRY_ROUND;
        const bool known = data->known[i] || (round && data->known[partner]);
        law->low[i] = INFINITY;
        law->high[i] = -INFINITY;
        for (size_t r = 0; r < data->rows; r++) {
            law->low[i] = fmin(law->low[i], data->strain[i][r]);
            law->high[i] = fmax(law->high[i], data->strain[i][r]);
        }
        if (data->known[i] && law->low[i] == law->high[i] && !(round && partner != i)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s is the same in all rows; allowed: one that varies, or no columns "
                           "%s and %s, for a rod in which it is locked",
                           STRAINS[i], STRAINS[i], STRESSES[i]);
        }
        law->scale[i] = known ? strain[i] : INFINITY;
        fit->unit = known ? fmax(fit->unit, stress[i] * strain[i]) : fit->unit;
    }
    for (int i = 0; i < N; i++) {
        const bool known = isfinite(law->scale[i]);
        if (known && !(strain[i] > 0 && stress[i] > 0)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s or %s is 0 in all rows; allowed: ones that vary", STRAINS[i],
                           STRESSES[i]);
        }
        fit->by[i] = known ? fit->unit / (stress[i] * strain[i]) : 0;
    }
    return AD_OK;
}

/* Rows held out are drawn at random. */
static ad_status deal(law_fit *fit, const train_law_data *data, ad_error *error)
{
    const size_t rows = data->rows, out = (size_t)(fit->asked->held_out * (double)rows);
    size_t *order = malloc((rows + 1) * sizeof *order), at = 0;
    double *all = calloc(rows * 2 * N + 1, sizeof *all);
    nn_rng rng = nn_rng_split(fit->asked->seed, "held out");
    fit->rows[0] = rows - out;
    fit->rows[1] = out;
    fit->data[0] = all;
    fit->data[1] = all + fit->rows[0] * 2 * N;
    for (size_t i = 0; order && i < rows; i++) {
        const size_t other = (size_t)nn_rng_below(&rng, i + 1);
        order[i] = order[other];
        order[other] = i;
    }
    for (int part = 0; order && all && part < 2; part++) {
        for (size_t r = 0; r < fit->rows[part]; r++, at++) {
            for (int i = 0; i < N; i++) {
                const double scale = fit->law->scale[i], *strain = data->strain[i];
                const size_t n = fit->rows[part];
                fit->data[part][(size_t)i * n + r] = strain[order[at]] / scale;
                fit->data[part][(size_t)(N + i) * n + r] =
                    isfinite(scale) ? data->stress[i][order[at]] * scale / fit->unit : 0;
            }
        }
    }
    const bool enough = order && all;
    free(order);
    return enough ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", rows);
}

/* ---- parameters ---------------------------------------------------------------------------- */

/* Flat: the roots of c [N]; a, b [units]; w [features * units]. Of a convex law a and, if round, w
 * are squares, but for the first w; the last is 0. Of a round law c_2 and c_5 do not count. */
static bool is_squared(const law_fit *fit, int feature)
{
    return fit->asked->convex && fit->asked->symmetry == SCENE_SYMMETRY_ROUND && feature > 0;
}

static void set_law(const law_fit *fit, const double *p)
{
    scene_law *law = fit->law;
    const int units = law->units;
    const bool round = law->symmetry == SCENE_SYMMETRY_ROUND;
    for (int i = 0; i < N; i++) {
        const double root = p[round && i % 3 == 1 ? i - 1 : i];
        law->quadratic[i] = fit->unit * root * root;
    }
    for (int u = 0; u < units; u++) {
        const double a = p[N + u];
        law->weight[u] = fit->unit * (fit->asked->convex ? a * a : a);
        law->offset[u] = p[N + units + u];
        for (int k = 0; k < fit->features; k++) {
            const double w = p[N + 2 * units + k * units + u];
            law->by[u][k] = !is_squared(fit, k) ? w : k + 1 < SCENE_LAW_FEATURES ? w * w : 0;
        }
    }
}

/* The same on the tape; wrt [4]. */
static scene_law_values record_law(const law_fit *fit, ad_tape *tape, ad_value *wrt)
{
    const int units = fit->law->units, all = units * fit->features;
    double linear[SCENE_LAW_UNITS_MAX * SCENE_LAW_FEATURES];
    double square[SCENE_LAW_UNITS_MAX * SCENE_LAW_FEATURES];
    wrt[0] = ad_parameter(tape, "c", N, 0);
    wrt[1] = ad_parameter(tape, "a", units, N);
    wrt[2] = ad_parameter(tape, "b", units, (size_t)N + (size_t)units);
    wrt[3] = ad_parameter(tape, "w", all, (size_t)N + 2 * (size_t)units);
    ad_value root = wrt[0], weight = wrt[1], by = wrt[3];
    if (fit->asked->symmetry == SCENE_SYMMETRY_ROUND) {
        static const int of[N] = {0, 0, 2, 3, 3, 5};
        ad_value rows[N];
        for (int i = 0; i < N; i++) {
            rows[i] = ad_row(root, of[i]);
        }
        root = ad_stack(N, rows);
    }
    for (int i = 0; i < all; i++) {
        const int k = i / units;
        linear[i] = !is_squared(fit, k);
        square[i] = is_squared(fit, k) && k + 1 < SCENE_LAW_FEATURES;
    }
    by = ad_add(ad_mul(ad_constant(tape, all, linear), by),
                ad_mul(ad_constant(tape, all, square), ad_square(by)));
    return (scene_law_values){ad_square(root), fit->asked->convex ? ad_square(weight) : weight,
                              wrt[2], by};
}

static ad_status record(law_fit *fit, ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    ad_value strain = ad_input(tape, "strain", N), stress = ad_input(tape, "stress", N), wrt[4];
    const scene_law_values values = record_law(fit, tape, wrt);
    const scene_symmetry symmetry = fit->asked->symmetry;
    ad_value given = ad_sub(scene_law_record(symmetry, &values, strain),
                            scene_law_record(symmetry, &values, ad_zeros(tape, N)));
    ad_value off = ad_mul(ad_constant(tape, N, fit->by), ad_sub(given, stress));
    ad_value sum = ad_sum_points(ad_sum_rows(ad_square(off)));
    const ad_settings settings = ad_settings_default();
    ad_status status = ad_tape_status(tape, error);
    if (status == AD_OK) {
        status = ad_compile(1, &sum, &settings, fit->ls.pool, &fit->sum, error);
    }
    if (status == AD_OK) {
        status = ad_normal_compile(1, &off, 4, wrt, fit->count, fit->ls.pool, &fit->normal, error);
    }
    ad_tape_free(tape);
    return status;
}

/* ---- Levenberg-Marquardt ------------------------------------------------------------------- */

static ad_run run_of(const law_fit *fit, int part, const double *p, const double *inputs[2],
                     double **output)
{
    inputs[0] = fit->data[part];
    inputs[1] = fit->data[part] + N * fit->rows[part];
    return (ad_run){
        .points = fit->rows[part], .inputs = inputs, .parameters = p, .outputs = output};
}

static int sum_of(law_fit *fit, int part, const double *p, double *value)
{
    const double *inputs[2];
    const ad_run run = run_of(fit, part, p, inputs, &value);
    return ad_execute(fit->sum, &run, &fit->error) == AD_OK ? OPTIM_OBJECTIVE_OK
                                                            : OPTIM_OBJECTIVE_STOP;
}

static int sum(void *context, const double *p, double *value, least_squares *to)
{
    law_fit *fit = context;
    const double *inputs[2];
    const ad_run run = run_of(fit, 0, p, inputs, NULL);
    if (!to) {
        return sum_of(fit, 0, p, value);
    }
    *value = 0;
    return ad_normal_add(fit->normal, &run, to->jtj, to->jtr, value, &fit->error) == AD_OK
               ? OPTIM_OBJECTIVE_OK
               : OPTIM_OBJECTIVE_STOP;
}

static ad_status draw(void *context, double *p, ad_error *error)
{
    const law_fit *fit = context;
    nn_rng rng = nn_rng_split(fit->asked->seed + (uint64_t)fit->ls.fit.at.window, "law");
    const int units = fit->law->units;
    (void)error;
    for (size_t i = 0; i < fit->count; i++) {
        p[i] = nn_rng_normal(&rng);
    }
    for (int i = 0; i < N; i++) {
        p[i] = 0.7;
    }
    for (int u = 0; u < units; u++) {
        p[N + u] *= fit->asked->convex ? 0.3 : 0.1;
    }
    for (int i = 0; i < units * fit->features; i++) {
        p[N + 2 * units + i] *= 1 / sqrt(fit->features);
    }
    return AD_OK;
}

/* The best network on the way of all starts, by the rows held out. */
static ad_status judge(void *context, optim_status status, ad_error *error)
{
    law_fit *fit = context;
    const int part = fit->rows[1] > 0;
    const double *p = optim_x(fit->ls.by);
    double off = INFINITY;
    if (status == OPTIM_STOPPED_BY_OBJECTIVE || sum_of(fit, part, p, &off) != OPTIM_OBJECTIVE_OK) {
        return ad_fail(error, fit->error.status, "%s", fit->error.message);
    }
    fit->ls.fit.held_out = part ? off * (double)fit->rows[0] / (double)fit->rows[1] : NAN;
    if (off < fit->found[0]) {
        fit->found[0] = off;
        fit->found[1] = (double)fit->ls.fit.at.stage_step + 1;
        fit->found[2] = fit->ls.fit.at.window;
        memcpy(fit->best, p, fit->count * sizeof *p);
    }
    return AD_OK;
}

static int state_of(void *context, optim_array *arrays)
{
    law_fit *fit = context;
    arrays[0] = (optim_array){"best", fit->best, fit->count};
    arrays[1] = (optim_array){"found", fit->found, 3};
    return 2;
}

/* ---- what came of it ----------------------------------------------------------------------- */

/* Of the law, or where it is NULL of one stiffness each. */
static void errors_of(const law_fit *fit, const scene_law *law, int part, double *error)
{
    const size_t n = fit->rows[part];
    double missed[N] = {0}, size[N] = {0}, stiffness[N];
    for (int i = 0; i < N; i++) {
        double both = 0, square = 0;
        for (size_t r = 0; r < fit->rows[0]; r++) {
            const double strain = fit->data[0][(size_t)i * fit->rows[0] + r];
            both += strain * fit->data[0][(size_t)(N + i) * fit->rows[0] + r];
            square += strain * strain;
        }
        stiffness[i] = both / square;
    }
    for (size_t r = 0; r < n; r++) {
        double strain[N], found[N];
        for (int i = 0; i < N; i++) {
            const bool known = fit->by[i] > 0;
            strain[i] = known ? fit->data[part][(size_t)i * n + r] * fit->law->scale[i] : 0;
        }
        if (law) {
            scene_law_potential(law, strain, found, NULL);
        }
        for (int i = 0; i < N; i++) {
            if (!(fit->by[i] > 0)) {
                continue;
            }
            const double scale = fit->law->scale[i],
                         stress = fit->data[part][(size_t)(N + i) * n + r];
            const double off =
                (law ? found[i] * scale / fit->unit : stiffness[i] * strain[i] / scale);
            missed[i] += (off - stress) * (off - stress);
            size[i] += stress * stress;
        }
    }
    for (int i = 0; i < N; i++) {
        error[i] = sqrt(missed[i] / size[i]);
    }
}

static ad_status check(const train_law_settings *asked, const train_law_data *data, ad_error *error)
{
    const double unknown = (double)N + asked->units * (2.0 + scene_law_features(asked->symmetry));
    const double given = (1 - asked->held_out) * (double)data->rows * N;
    return given >= unknown
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "%zu rows; allowed: %.0f or more for %d units, or fewer units", data->rows,
                         ceil(unknown / N / (1 - asked->held_out)), asked->units);
}

static ad_status fit_law(law_fit *fit, ad_error *error)
{
    const size_t numbers = (fit->rows[0] + fit->rows[1]) * 2 * N;
    fit->ls.digest = checkpoint_hash(CHECKPOINT_HASH_START, fit->data[0], numbers * sizeof(double));
    ad_status status = least_squares_create(&fit->ls, error);
    fit->best = calloc(fit->count, sizeof *fit->best);
    if (status == AD_OK && !fit->best) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a law");
    }
    status = status == AD_OK ? record(fit, error) : status;
    status = status == AD_OK ? least_squares_run(&fit->ls, fit->asked->runner, error) : status;
    if (status == AD_OK && fit->ls.fit.state == FIT_OVER) {
        set_law(fit, fit->best);
        status = isfinite(fit->found[0])
                     ? scene_law_finish(fit->law, error)
                     : ad_fail(error, AD_NOT_FINITE, "no law was found from %d starts",
                               fit->asked->starts);
    }
    free(fit->best);
    ad_normal_free(fit->normal);
    ad_program_free(fit->sum);
    least_squares_clear(&fit->ls);
    return status;
}

ad_status train_law_fit(const train_law_settings *settings, const train_law_data *data,
                        scene_law *law, train_law_report *report, ad_error *error)
{
    const int features = scene_law_features(settings->symmetry);
    law_fit x = {.asked = settings,
                 .law = law,
                 .features = features,
                 .found = {INFINITY},
                 .count = (size_t)(N + settings->units * (2 + features))};
    x.ls = (least_squares){.count = x.count,
                           .scaling = OPTIM_SCALING_IDENTITY,
                           .sum = sum,
                           .begin = draw,
                           .judge = judge,
                           .state = state_of,
                           .context = &x,
                           .name = "law",
                           .every = 10,
                           .descents = settings->starts,
                           .steps = settings->steps};
    *law = (scene_law){.symmetry = settings->symmetry, .units = settings->units, .misfit = NAN};
    ad_status status = check(settings, data, error);
    status = status == AD_OK ? set_scales(&x, data, error) : status;
    status = status == AD_OK ? deal(&x, data, error) : status;
    status = status == AD_OK ? fit_law(&x, error) : status;
    if (status == AD_OK && isfinite(x.found[0])) {
        *report = (train_law_report){.trained = x.rows[0],
                                     .held_out = x.rows[1],
                                     .steps = (int)x.found[1],
                                     .start = (int)x.found[2]};
        errors_of(&x, law, 0, report->error);
        errors_of(&x, law, 1, report->held_out_error);
        errors_of(&x, NULL, x.rows[1] > 0, report->linear);
        law->misfit = 0;
        for (int i = 0; i < N; i++) { /* NaN: of a strain that is not known */
            law->misfit =
                fmax(law->misfit, x.rows[1] > 0 ? report->held_out_error[i] : report->error[i]);
        }
    }
    free(x.data[0]);
    return status;
}
