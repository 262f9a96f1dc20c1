/* From a run and the options of cpinn-export to what is exported. */
#include "tools/programs/export_open.h"

#include "tools/prepare/config_experiment.h"
#include "tools/prepare/config_surrogate.h"
#include "tools/programs/cli.h"
#include "tools/train/history.h"
#include "tools/train/learnt_balance.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- the run -------------------------------------------------------------------------------- */

/* Without a reference the error is not known; the model can be exported all the same. */
static ad_status measure_error(export_model *model, ad_error *error)
{
    reference *known = NULL;
    reference_errors errors = {.position = NAN};
    ad_status status = AD_OK;
    if (!model->e->targets && !model->e->warning[0] &&
        reference_create(model->e, &known, error) != AD_OK) {
        cli_warn("cpinn-export", "no reference: %s", error->message);
        known = NULL;
    }
    if (known) {
        status = reference_compare(known, experiment_parameters(model->e), &errors, error);
    }
    model->error = errors.position;
    reference_free(known);
    return status;
}

static ad_status read_run(export_model *exported, ad_error *error)
{
    checkpoint *file = NULL;
    surrogate *model = NULL;
    ad_error other;
    ad_status status =
        config_experiment_open(exported->run, 0, NULL, 1, &exported->e, &file, error);
    if (status != AD_OK && surrogate_load(exported->run, &model, &other) == AD_OK) {
        surrogate_free(model);
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: a one-step model; with filter and controller it is written as C by "
                       "cpinn-control CONFIG.yaml --run DIR --c OUT",
                       exported->run);
    }
    if (status == AD_OK && checkpoint_has(file, "verdict")) {
        exported->is_judged = true;
        status = report_get_verdict(file, &exported->verdict, error);
    }
    if (status == AD_OK) {
        exported->held_out = sqrt(history_last(file, "held_out"));
        status = experiment_kept_error(exported->e, file, &exported->estimate, error);
    }
    if (status == AD_OK) {
        status = measure_error(exported, error);
    }
    checkpoint_free(file);
    return status;
}

/* ---- options --------------------------------------------------------------------------------- */

/* Columns become names in C, which are written in capitals. */
static ad_status check_names(const evaluator *values, ad_error *error)
{
    for (int i = 0; i < evaluator_columns(values); i++) {
        for (int k = 0; k < i; k++) {
            if (strcasecmp(evaluator_column_name(values, i), evaluator_column_name(values, k)) ==
                0) {
                return ad_fail(error, AD_BAD_ARGUMENT, "--columns: %s is there twice",
                               evaluator_column_name(values, i));
            }
        }
    }
    return AD_OK;
}

/* "0.1,0.25", in m. */
static ad_status list_places(const char *text, int most, double *places, int *count,
                             ad_error *error)
{
    const char *at = text;
    *count = 0;
    do {
        char *end;
        const double place = strtod(at, &end);
        if (end == at || (*end != ',' && *end != '\0') || !isfinite(place) || *count == most) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "--places %s: allowed: 1 to %d arc lengths in m, separated by commas",
                           text, most);
        }
        places[(*count)++] = place;
        at = end + 1;
    } while (at[-1] == ',');
    return AD_OK;
}

/* Places of the shape of a family in the strain form, over its length. */
static ad_status list_shape(double length, const char *text, double s[EXPORT_PLACES_MAX],
                            int *count, ad_error *error)
{
    ad_status status = list_places(text, EXPORT_PLACES_MAX, s, count, error);
    for (int i = 0; i < *count && status == AD_OK; i++) {
        s[i] /= length;
        if (!(s[i] >= (i > 0 ? s[i - 1] : 0) && s[i] <= 1 + 1e-9)) {
            status =
                ad_fail(error, AD_BAD_ARGUMENT,
                        "--places %s: allowed: ascending arc lengths from 0 to %g", text, length);
        }
        s[i] = fmin(s[i], 1);
    }
    return status != AD_OK || s[*count - 1] >= 1 - 1e-9
               ? status
               : ad_fail(error, AD_BAD_ARGUMENT, "--places: the last is not the tip, %g", length);
}

/* Which columns `names` lists, as evaluator_create takes them; NULL: all. */
static ad_status list_columns(const scene *of, const char *names, export_family *f, ad_error *error)
{
    const model_column *known = scene_physics_of(of)->columns;
    const int all = strain_columns(of);
    const char *at = names ? names : "";
    for (; !names && f->columns < all; f->columns++) {
        f->which[f->columns] = f->columns;
    }
    for (at += strspn(at, " ,"); *at; at += strspn(at, " ,")) {
        const size_t length = strcspn(at, " ,");
        int first = *at == 'q' ? 3 : 0, count = *at == 'q' ? 4 : 3;
        if (length != 1 || (*at != 'r' && *at != 'q')) {
            count = 1;
            for (first = 0; first < all; first++) {
                if (strncmp(known[first].name, at, length) == 0 && !known[first].name[length]) {
                    break;
                }
            }
        }
        if (first == all) {
            return ad_fail(
                error, AD_BAD_ARGUMENT,
                "--columns: %.*s is no column of a family in the strain form; allowed: "
                "r, q, and x to z, qw to qz, v1 to v3, u1 to u3, n1 to n3, m1 to m3, and "
                "of tubes theta1, mt1 and so on",
                (int)(length < 40 ? length : 40), at);
        }
        for (int c = first; c < first + count; c++) {
            for (int i = 0; i < f->columns; i++) {
                if (f->which[i] == c) {
                    return ad_fail(error, AD_BAD_ARGUMENT, "--columns: %s is there twice",
                                   known[c].name);
                }
            }
            f->which[f->columns++] = c;
        }
        at += length;
    }
    return f->columns > 0 ? AD_OK
                          : ad_fail(error, AD_BAD_ARGUMENT, "--columns: no column is asked for");
}

ad_status export_open(export_model *model, const char *run, const char *columns, const char *places,
                      ad_error *error)
{
    double s[EXPORT_PLACES_MAX];
    int count = 0;
    model->run = run;
    model->error = model->held_out = model->estimate = NAN;
    for (int i = 0; i < EVALUATOR_COLUMNS_MAX; i++) {
        model->measured.values[i] = model->measured.jacobian[i] = NAN;
    }
    ad_status status = read_run(model, error);
    if (status == AD_OK && !export_is_family(model)) {
        status = export_model_prepare(model, columns, error);
        return status == AD_OK ? check_names(model->values, error) : status;
    }
    status =
        status == AD_OK ? list_columns(model->e->scene, columns, &model->family, error) : status;
    if (status == AD_OK && places) {
        status = list_shape(scene_length(model->e->scene), places, s, &count, error);
    }
    return status == AD_OK ? export_members_prepare(model, count, places ? s : NULL, error)
                           : status;
}

ad_status export_read_places(const export_model *model, const char *text,
                             double places[FMU_PLACES_MAX], int *count, ad_error *error)
{
    *count = 1;
    places[0] = model->upper[0];
    return text ? list_places(text, FMU_PLACES_MAX, places, count, error) : AD_OK;
}
