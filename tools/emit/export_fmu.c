/* A run as an FMU: the texts of its C with what FMI wants to know. */
#include "tools/emit/export_model.h"

#include <math.h>

static void describe(const export_model *model, char *text, size_t size)
{
    char error[64] = "is not known";
    if (!isnan(model->estimate)) {
        snprintf(error, sizeof error, "of the position is estimated at %.1e of the %s",
                 model->estimate, scene_is_beam(model->e->scene) ? "deflection" : "length");
    }
    snprintf(text, size,
             "A rod's network in place of its equations. Verdict on training: %s. Its error %s.",
             !model->is_judged           ? "none, it was not finished"
             : model->verdict.count == 0 ? "solved"
                                         : model->verdict.findings[0].text,
             error);
}

ad_status export_write_fmu(const export_model *exported, const export_texts texts, int count,
                           const double *places, const char *path, bool *compiled,
                           char note[FMU_NOTE], ad_error *error)
{
    const domain *d = &exported->e->model->domain;
    fmu_variable inputs[DOMAIN_COORDINATES_MAX], outputs[EVALUATOR_COLUMNS_MAX];
    char description[VERDICT_TEXT + 256];
    const fmu_model model = {.name = exported->name,
                             .title = exported->e->settings->name,
                             .description = description,
                             .tool = "cpinn " CPINN_VERSION,
                             .header = texts[EXPORT_HEADER].bytes,
                             .source = texts[EXPORT_SOURCE].bytes,
                             .inputs = inputs,
                             .outputs = outputs,
                             .input_count = exported->inputs,
                             .output_count = exported->outputs,
                             .places = places,
                             .place_count = count};
    for (int i = 0; i < exported->inputs; i++) {
        const domain_coordinate *c = &d->coordinates[i];
        inputs[i] = (fmu_variable){c->name, c->unit, exported->lower[i], exported->upper[i]};
    }
    for (int i = 0; i < exported->outputs; i++) {
        outputs[i] = (fmu_variable){evaluator_column_name(exported->values, i),
                                    evaluator_column_unit(exported->values, i), 0, 0};
    }
    describe(exported, description, sizeof description);
    return fmu_write(&model, path, compiled, note, error);
}
