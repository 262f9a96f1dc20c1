/* cpinn-show: a trained network. */
#include "tools/programs/show_source.h"

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
    return show_put_shapes(showing, &one, NULL,
                           is_rod && !scene_is_family(showing->e->scene) ? &ghost : NULL,
                           r ? reference_name(r) : NULL, error);
}

static ad_status evaluate_run(showing *showing, const double *member, ad_error *error)
{
    const experiment *e = showing->e;
    ad_status status = experiment_field(e, member, &showing->field, error);
    status = status == AD_OK ? show_choose_points(showing, e->scene, experiment_until(e), error)
                             : status;
    if (status == AD_OK) {
        const answer network =
            answer_of_network(showing->field, experiment_parameters(e), e->scene);
        status = samples_ask(&showing->samples, &network, error);
    }
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
    status = experiment_choose_member(showing->e, showing->at, member, error);
    if (status == AD_OK && scene_is_family(showing->e->scene) && showing->e->targets) {
        put_run_head(showing, showing->at ? member : NULL, NULL);
        status = show_family(showing, showing->at ? member : NULL, error);
        put_run_texts(showing);
        return status;
    }
    status = status == AD_OK ? evaluate_run(showing, member, error) : status;
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
