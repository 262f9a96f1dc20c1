/* cpinn-show: a trained network. */
#include "tools/programs/show_source.h"

#include "tools/library/cpinn.h"
#include "tools/train/history.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- a run --------------------------------------------------------------------------------- */

/* How far the field is from the reference: the largest distance at each instant, at rest that at
 * each place. */
static void put_error_curve(showing *showing)
{
    const size_t count = reference_points(showing->known);
    const bool moves = scene_is_dynamic(showing->e->scene);
    const double *t = moves ? reference_t(showing->known) : reference_s(showing->known);
    double *at = calloc(2 * count + 1, sizeof *at), *most = at + count;
    double largest = 0;
    size_t rows = 0;
    bool ascending = true; /* as points of a file need not be, nor those of several members */
    for (size_t i = 0; at && i < count; i++) {
        double square = 0;
        ascending = ascending && (i == 0 || t[i] >= t[i - 1]);
        for (int k = 0; k < 3 && reference_known(showing->known, k); k++) {
            square += pow(
                reference_found(showing->known, k)[i] - reference_known(showing->known, k)[i], 2);
        }
        if (rows == 0 || t[i] != at[rows - 1]) {
            at[rows] = t[i];
            most[rows++] = 0;
        }
        most[rows - 1] = fmax(most[rows - 1], sqrt(square));
        largest = fmax(largest, most[rows - 1]);
    }
    for (size_t i = 0; at && i < rows; i++) {
        most[i] = most[i] > 1e-6 * largest ? most[i] : NAN; /* met exactly, as at the start */
    }
    if (at && rows > 1 && ascending) {
        show_open_curve(&showing->to, "Distance from the reference", moves ? "t" : "s",
                        moves ? "s" : "m", "m", true);
        show_series(&showing->to, "distance", at, most, rows);
        show_close_curve(&showing->to);
    }
    free(at);
}

static ad_status put_training(showing *showing, ad_error *error)
{
    json_open(&showing->to, "curves", '[');
    if (showing->known) {
        put_error_curve(showing);
    }
    const ad_status status = show_history(&showing->to, showing->file, error);
    json_close(&showing->to, ']');
    return status;
}

static void put_run_texts(showing *showing)
{
    char *text = train_origin_text(&showing->e->origin);
    json_open(&showing->to, "texts", '[');
    if (text) {
        show_text(&showing->to, "Scene and settings (YAML)", text);
    }
    json_close(&showing->to, ']');
    free(text);
}

/* `member` (NULL: not one) are values of a family's parameters. */
static void put_run_head(showing *showing, const double *member, const reference_errors *errors)
{
    verdict judged;
    ad_error why;
    if (checkpoint_has(showing->file, "verdict") &&
        report_get_verdict(showing->file, &judged, &why) == AD_OK) {
        report_verdict(&showing->to, &judged);
    }
    double seconds = history_last(showing->file, "seconds"),
           steps = history_last(showing->file, "step");
    json_open(&showing->to, "facts", '[');
    show_scene_facts(&showing->to, showing->e->scene);
    for (int i = 0; member && i < scene_known_count(showing->e->scene); i++) {
        show_fact(&showing->to, showing->e->scene->parameters[i].name, "%.4g", member[i]);
    }
    show_fact(&showing->to, "parameters of the network", "%.0f", (double)showing->e->count);
    if (!isnan(steps)) {
        show_fact(&showing->to, "steps", "%.0f", steps);
    }
    if (!isnan(seconds)) {
        show_fact(&showing->to, "training", "%.3g s", seconds);
    }
    if (errors) {
        show_fact(&showing->to, "error of position, relative L2", "%.2e", errors->position);
    }
    json_close(&showing->to, ']');
}

/* The reference as a table, of a rod; its points must be those of instants one after the other. */
static ad_status put_run_motion(showing *showing, const double *member, ad_error *error)
{
    samples_table result_table;
    const reference *r = showing->known;
    static const char *const names[] = {"s", "t", "x", "y", "z"};
    const bool is_rod = r && reference_known(r, 2);
    const double *columns[5] = {NULL};
    if (is_rod) {
        columns[0] = reference_s(r);
        columns[1] = reference_t(r);
        for (int k = 0; k < 3; k++) {
            columns[2 + k] = reference_known(r, k);
        }
    }
    const table_source ghost = {
        .names = names, .columns = columns, .ncols = 5, .nrows = r ? reference_points(r) : 0};
    scene one;
    scene_member(showing->e->scene, member, &one);
    showing->of = &one;
    samples_fill(&showing->samples, showing->e->scene, &result_table);
    ad_status status =
        show_put_motion(showing, &result_table.table, NULL,
                        is_rod && !scene_is_family(showing->e->scene) ? &ghost : NULL,
                        r ? reference_name(r) : NULL, error);
    showing->of = NULL;
    return status == AD_OK ? show_scene(&showing->to, &one, NULL, &showing->kept, NULL, error)
                           : status;
}

static ad_status evaluate_run(showing *showing, double *member, ad_error *error)
{
    const experiment *e = showing->e;
    const domain *d = &e->model->domain;
    const double until = scene_is_dynamic(e->scene)
                             ? domain_window_time(d, e->window + 1) * d->coordinates[d->time].scale
                             : 0;
    ad_status status = field_create(e->model, e->mlp, false, e->pool, &showing->field, error);
    experiment_member_values(e, member);
    if (status == AD_OK && showing->at) {
        status = scene_member_read(scene_known_count(e->scene), e->scene->parameters, false,
                                   showing->at, member, error);
    }
    if (status == AD_OK) {
        field_enter(showing->field, e->window, e->parameters, e->starts);
        field_member(showing->field, member);
        status = samples_of_grid(&showing->samples,
                                 showing->grid                ? showing->grid
                                 : scene_is_dynamic(e->scene) ? "81x201"
                                                              : NULL,
                                 e->scene, until, field_columns(showing->field), error);
    }
    samples *p = &showing->samples;
    return status == AD_OK ? field_evaluate(showing->field, experiment_parameters(e), p->count,
                                            (const double *const[]){p->s, p->t}, p->values, error)
                           : status;
}

/* ---- a family ------------------------------------------------------------------------------ */

enum { SWEEP = 21, FAMILY_POINTS = 61, LABEL = 96 };

typedef struct sweep {
    size_t frames;
    int columns;
    double *parameters; /* [frames][parameters] */
    double *values;     /* [frames][points][columns] */
    double *sorted;     /* member, s, then columns [frames points] each; then three [frames] */
    cpinn_answer *answers;
    const char **labels;
    char (*texts)[LABEL];
} sweep;

static void sweep_free(sweep *w)
{
    free(w->parameters);
    free(w->values);
    free(w->sorted);
    free(w->answers);
    free(w->labels);
    free(w->texts);
}

/* `member` NULL: all of it, else these values of the parameters alone. */
static bool sweep_make(sweep *w, const scene *of, int columns, const double *member)
{
    const int count = scene_known_count(of);
    const size_t rows = (w->frames = member ? 1 : (size_t)count * SWEEP) * FAMILY_POINTS;
    w->columns = columns;
    w->parameters = calloc(w->frames * (size_t)count, sizeof *w->parameters);
    w->values = calloc(rows * (size_t)columns, sizeof *w->values);
    w->sorted = calloc((rows + 1) * (size_t)(columns + 2) + 3 * w->frames, sizeof *w->sorted);
    w->answers = calloc(w->frames, sizeof *w->answers);
    w->labels = calloc(w->frames, sizeof *w->labels);
    w->texts = calloc(w->frames, sizeof *w->texts);
    if (!w->parameters || !w->values || !w->sorted || !w->answers || !w->labels || !w->texts) {
        return false;
    }
    for (size_t i = 0; i < w->frames; i++) {
        const int moves = (int)(i / SWEEP);
        double *values = w->parameters + i * (size_t)count;
        for (int k = 0; k < count; k++) {
            const double part = k == moves ? (double)(i % SWEEP) / (SWEEP - 1) : 0.5;
            values[k] = member ? member[k] : scene_parameter_at(&of->parameters[k], part);
        }
        snprintf(w->texts[i], LABEL, "%.60s = %.4g", of->parameters[moves].name, values[moves]);
        w->labels[i] = w->texts[i];
    }
    return true;
}

static void put_family_curve(showing *showing, const sweep *w)
{
    double *number = w->sorted + (size_t)(w->columns + 2) * w->frames * FAMILY_POINTS;
    double *network = number + w->frames, *answer = network + w->frames;
    for (size_t i = 0; i < w->frames; i++) {
        number[i] = (double)i;
        network[i] = w->answers[i].network_error;
        answer[i] = w->answers[i].error;
    }
    json_open(&showing->to, "curves", '[');
    show_open_curve(&showing->to, "Predicted error of the shape", "member", "", "m", true);
    show_series(&showing->to, "network", number, network, w->frames);
    show_series(&showing->to, "after two steps", number, answer, w->frames);
    show_close_curve(&showing->to);
    json_close(&showing->to, ']');
}

static ad_status put_sweep(showing *showing, sweep *w, cpinn_family *family, const double *s,
                           ad_error *error)
{
    const size_t rows = w->frames * FAMILY_POINTS;
    const char *names[2 + MODEL_COLUMNS_MAX] = {"member", "s"};
    const char *units[2 + MODEL_COLUMNS_MAX] = {"", "m"};
    const double *columns[2 + MODEL_COLUMNS_MAX];
    for (int k = 0; k < w->columns + 2; k++) {
        double *to = w->sorted + (size_t)k * rows;
        columns[k] = to;
        for (size_t i = 0; i < rows; i++) {
            to[i] = k == 0   ? (double)(i / FAMILY_POINTS)
                    : k == 1 ? s[i % FAMILY_POINTS]
                             : w->values[i * (size_t)w->columns + (size_t)(k - 2)];
        }
        if (k >= 2) {
            names[k] = cpinn_family_column_name(family, k - 2);
            units[k] = show_unit(names[k], showing->e->scene);
        }
    }
    const table_source table = {.names = names,
                                .columns = columns,
                                .ncols = (size_t)w->columns + 2,
                                .nrows = rows,
                                .units = units};
    put_family_curve(showing, w);
    showing->of = showing->e->scene;
    showing->members = w->parameters;
    ad_status status = show_put_motion(showing, &table, w->labels, NULL, NULL, error);
    return status == AD_OK ? show_scene(&showing->to, showing->e->scene, w->parameters,
                                        &showing->kept, NULL, error)
                           : status;
}

/* Every parameter through its range, the others in the middle of theirs; or the member of --at. */
static ad_status show_family(showing *showing, ad_error *error)
{
    double s[FAMILY_POINTS], member[SCENE_PARAMETERS_MAX];
    const scene *of = showing->e->scene;
    sweep w = {.frames = 0};
    cpinn_family *family = NULL;
    for (int i = 0; i < FAMILY_POINTS; i++) {
        s[i] = scene_length(of) * i / (FAMILY_POINTS - 1);
    }
    const cpinn_family_settings settings = {.points = FAMILY_POINTS, .s = s};
    ad_status status = cpinn_family_open(showing->source, &settings, &family, error);
    bool is_live = false;
    if (status == AD_OK && !showing->at && !showing->reference_path &&
        !show_is_plot(showing->out)) {
        status = show_live(showing, family, FAMILY_POINTS, s, &is_live, error);
    }
    if (is_live || status != AD_OK) {
        put_run_head(showing, NULL, NULL);
        put_run_texts(showing);
        cpinn_family_free(family);
        return status;
    }
    if (status == AD_OK && showing->at) {
        status = scene_member_read(scene_known_count(of), of->parameters, false, showing->at,
                                   member, error);
    }
    if (status == AD_OK &&
        !sweep_make(&w, of, cpinn_family_columns(family), showing->at ? member : NULL)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    if (status == AD_OK) {
        const bool judged = *cpinn_family_without_error(family) == '\0';
        const cpinn_polish polish = {.steps = judged ? 2 : 0};
        status = cpinn_family_evaluate(family, &polish, w.frames, w.parameters, w.values, w.answers,
                                       error);
    }
    if (status == AD_OK) {
        put_run_head(showing, showing->at ? member : NULL, NULL);
        status = put_sweep(showing, &w, family, s, error);
        put_run_texts(showing);
    }
    sweep_free(&w);
    cpinn_family_free(family);
    return status;
}

ad_status show_run(showing *showing, ad_error *error)
{
    double member[SCENE_PARAMETERS_MAX];
    reference_errors errors;
    ad_error why;
    ad_status status =
        config_experiment_open(showing->source, showing->overrides.count, showing->overrides.texts,
                               0, &showing->e, &showing->file, error);
    if (status != AD_OK) {
        return status;
    }
    snprintf(showing->title, sizeof showing->title, "%s", showing->e->settings->name);
    if (scene_is_family(showing->e->scene) && showing->e->targets) {
        return show_family(showing, error);
    }
    status = evaluate_run(showing, member, error);
    if (status != AD_OK) {
        return status;
    }
    if (reference_create(showing->e, &showing->known, &why) != AD_OK) {
        cli_warn("cpinn-show", "no reference: %s", why.message);
        showing->known = NULL;
    }
    if (showing->known) {
        status =
            reference_compare(showing->known, experiment_parameters(showing->e), &errors, error);
    }
    if (status == AD_OK) {
        put_run_head(showing, member, showing->known ? &errors : NULL);
        status = put_run_motion(showing, member, error);
    }
    if (status == AD_OK) {
        status = put_training(showing, error);
        put_run_texts(showing);
    }
    return status;
}
