/* A run as an FMU: the texts of its C with what FMI wants to know. */
#include "tools/fmu/fmu.h"
#include "tools/programs/cli.h"
#include "tools/programs/export.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* "0.1,0.25" in m; NULL: the end of the rod. */
static ad_status read_places(const export_model *x, const char *text, double places[FMU_PLACES_MAX],
                             int *count, ad_error *error)
{
    const char *at = text;
    *count = 0;
    if (!text) {
        places[(*count)++] = x->upper[0];
        return AD_OK;
    }
    do {
        char *end;
        double place = strtod(at, &end);
        if (end == at || (*end != ',' && *end != '\0') || !isfinite(place) ||
            *count == FMU_PLACES_MAX) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "--places %s: allowed: 1 to %d arc lengths in m, separated by commas",
                           text, FMU_PLACES_MAX);
        }
        places[(*count)++] = place;
        at = end + 1;
    } while (at[-1] == ',');
    return AD_OK;
}

static void describe(const export_model *x, char *text, size_t size)
{
    char error[64] = "is not known";
    if (!isnan(x->estimate)) {
        snprintf(error, sizeof error, "of the position is estimated at %.1e of the %s", x->estimate,
                 scene_is_beam(x->e->scene) ? "deflection" : "length");
    }
    snprintf(text, size,
             "A rod's network in place of its equations. Verdict on training: %s. Its error %s.",
             !x->is_judged           ? "none, it was not finished"
             : x->verdict.count == 0 ? "solved"
                                     : x->verdict.findings[0].text,
             error);
}

ad_status export_write_fmu(const export_model *x, const char *source, const char *header,
                           const char *places, const char *path, ad_error *error)
{
    const domain *d = &x->e->model->domain;
    fmu_variable inputs[DOMAIN_COORDINATES_MAX], outputs[EVALUATOR_COLUMNS_MAX];
    double list[FMU_PLACES_MAX];
    char description[VERDICT_TEXT + 256], tool[64], note[FMU_NOTE];
    bool compiled;
    fmu_model model = {.name = x->name,
                       .title = x->e->settings->name,
                       .description = description,
                       .tool = tool,
                       .header = header,
                       .source = source,
                       .inputs = inputs,
                       .outputs = outputs,
                       .input_count = x->inputs,
                       .output_count = x->outputs,
                       .places = list};
    ad_status status = read_places(x, places, list, &model.place_count, error);
    if (status != AD_OK) {
        return status;
    }
    for (int i = 0; i < x->inputs; i++) {
        const domain_coordinate *c = &d->coordinates[i];
        inputs[i] = (fmu_variable){c->name, c->unit, x->lower[i], x->upper[i]};
    }
    for (int i = 0; i < x->outputs; i++) {
        outputs[i] = (fmu_variable){evaluator_column_name(x->values, i),
                                    evaluator_column_unit(x->values, i), 0, 0};
    }
    describe(x, description, sizeof description);
    snprintf(tool, sizeof tool, "cpinn %s", cli_version());
    status = fmu_write(&model, path, &compiled, note, error);
    if (status == AD_OK && !compiled) {
        cli_warn("cpinn-export", "%s has sources only: %s", path, note);
    }
    return status;
}
