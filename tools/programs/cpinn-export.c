/* cpinn-export: a trained network as C or as an FMU; see --help. */
#include "tools/programs/cli.h"
#include "tools/programs/export_files.h"
#include "tools/programs/export_open.h"
#include "tools/programs/export_wall.h"
#include "tools/programs/help.h"

#include <math.h>

static const char program[] = "cpinn-export";

typedef struct options {
    const char *run, *c, *fmu, *columns, *places, *wall;
    bool single, jacobian, force;
} options;

static ad_status put_fmu(const export_model *model, const options *o, const export_out *to,
                         const export_texts texts, ad_error *error)
{
    double places[FMU_PLACES_MAX];
    char path[EXPORT_PATH], note[FMU_NOTE];
    bool compiled = true;
    int count;
    export_files_path(to, to->ending, path);
    ad_status status = export_read_places(model, o->places, places, &count, error);
    if (status == AD_OK) {
        status = export_write_fmu(model, texts, count, places, path, &compiled, note, error);
    }
    if (status == AD_OK && !compiled) {
        cli_warn(program, "%s has sources only: %s", path, note);
    }
    return status;
}

/* Without a compiler the C is written unchecked, and its header says so. */
static ad_status check(export_model *model, export_texts texts, ad_error *error)
{
    ad_status status = export_model_check(model, texts, error);
    if (status == AD_IO) {
        cli_warn(program, "the C has not been compiled and checked: %s", error->message);
        status = AD_OK;
    }
    return status == AD_OK ? export_text_write(&texts[EXPORT_HEADER], EXPORT_HEADER,
                                               export_model_write, model, error)
                           : status;
}

/* ---- report --------------------------------------------------------------------------------- */

static void report(const export_model *model, const export_out *to)
{
    const bool family = export_is_family(model), measured = !isnan(model->measured.values[0]);
    const int first = family ? 1 : 0; /* of a family the first line is the curvature */
    const double value = export_largest(model->outputs - first, model->measured.values + first);
    const double jacobian =
        export_largest(model->outputs - first, model->measured.jacobian + first);
    printf("wrote %.*s%s: ", (int)to->length, to->path,
           to->ending ? to->ending : ".c, .h and _selftest.c");
    if (family) {
        printf("%d parameters, %d nodes, shapes at %d places\n",
               model->family.open->parameter_count, strain_mesh_nodes(&model->family.mesh),
               model->family.places);
    } else {
        printf("%d inputs, %d outputs, %zu numbers of memory\n", model->inputs, model->outputs,
               model->memory);
    }
    if (measured && family) {
        printf("checked by cc: a polished curvature to %.1e of its scale, columns of the tip to "
               "%.1e, derivatives to %.1e of their scales\n",
               model->measured.jacobian[0], value, jacobian);
    } else if (measured) {
        printf("checked by cc: values to %.1e, derivatives to %.1e of their scales\n", value,
               jacobian);
    }
    for (int i = first; i < model->outputs && model->single && measured; i++) {
        printf("  %-10s %.1e  derivatives %.1e\n",
               family
                   ? scene_physics_of(model->family.open)->columns[model->family.which[i - 1]].name
                   : evaluator_column_name(model->values, i),
               model->measured.values[i], model->measured.jacobian[i]);
    }
    if (model->single && value > model->error) {
        cli_warn(program, "single precision costs %.1e, more than the error of the network, %.1e",
                 value, model->error);
    }
    if (model->is_judged) {
        verdict_print(stdout, "verdict on training: ", &model->verdict);
    }
}

static ad_status run(export_model *model, export_walled *walled, const options *o,
                     const export_out *to, export_texts texts, ad_error *error)
{
    ad_status status = export_files_check(to, error);
    if (status == AD_OK) {
        status = export_open(model, o->run, o->columns, o->places, error);
    }
    if (status == AD_OK && o->fmu && export_is_family(model)) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "%s: --fmu is not for families in the strain form; allowed: --c", o->run);
    }
    if (status == AD_OK && o->c && o->places && !export_is_family(model)) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "--places is for --fmu and for families in the strain form alone");
    }
    if (status == AD_OK && o->jacobian && !export_is_family(model)) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "--jacobian is for families in the strain form; all else has a Jacobian");
    }
    if (status == AD_OK && o->wall) {
        status = export_wall_open(o->wall, model, walled, error);
    }
    if (status == AD_OK) {
        status = export_texts_write_all(texts, export_model_write, model, error);
    }
    status = status == AD_OK ? check(model, texts, error) : status;
    return status != AD_OK ? status
           : o->fmu        ? put_fmu(model, o, to, texts, error)
                           : export_files_put(to, texts, error);
}

int main(int argc, char **argv)
{
    options o = {.run = NULL};
    export_model x = {.e = NULL};
    export_walled walled = {.tree = NULL};
    export_texts texts = {{.bytes = NULL}};
    ad_error error = {AD_OK, ""};
    const cli_option list[] = {{"--c", "OUT", CLI_TEXT, &o.c, 0, 0},
                               {"--fmu", "OUT", CLI_TEXT, &o.fmu, 0, 0},
                               {"--places", "S,S,...", CLI_TEXT, &o.places, 0, 0},
                               {"--columns", "NAMES", CLI_TEXT, &o.columns, 0, 0},
                               {"--single", NULL, CLI_FLAG, &o.single, 0, 0},
                               {"--jacobian", NULL, CLI_FLAG, &o.jacobian, 0, 0},
                               {"--wall", "CONFIG.yaml", CLI_TEXT, &o.wall, 0, 0},
                               CLI_FORCE(&o.force)};
    const cli_program about = {program, "DIR_OR_CHECKPOINT", help_export, NULL, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &o.run);
    if (status != CLI_RUN) {
        return status;
    }
    if (!o.c == !o.fmu) {
        return cli_fail(program, o.c ? "--c and --fmu are given; allowed: one of the two"
                                     : "nothing would be written; give --c OUT or --fmu OUT");
    }
    if (o.fmu && o.single) {
        return cli_fail(program, "--single is for --c alone; FMUs have double precision");
    }
    export_out to = {.option = o.fmu ? "--fmu" : "--c",
                     .path = o.fmu ? o.fmu : o.c,
                     .ending = o.fmu ? ".fmu" : NULL,
                     .force = o.force};
    status = 0;
    if (export_files_name(&to, &error) != AD_OK) {
        return cli_fail_error(program, &error);
    }
    x.name = to.name;
    x.single = o.single;
    x.family.shape_by = o.jacobian;
    if (run(&x, &walled, &o, &to, texts, &error) == AD_OK) {
        report(&x, &to);
    } else {
        status = cli_fail_error(program, &error);
    }
    export_texts_free(texts);
    export_model_free(&x);
    export_wall_close(&walled);
    return status;
}
