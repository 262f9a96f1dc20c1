/* cpinn-solve: solve a scene classically; see --help. */
#include "physics/beam.h"
#include "physics/model.h"
#include "tools/files/shapes_vtk.h"
#include "tools/prepare/config_experiment.h"
#include "tools/programs/cli.h"
#include "tools/programs/help.h"
#include "tools/programs/path_files.h"
#include "tools/programs/samples.h"
#include "tools/programs/scene_line.h"
#include "tools/programs/solution_print.h"
#include "tools/programs/state_file.h"
#include "tools/programs/unknowns.h"
#include "tools/programs/work_precision.h"
#include "tools/train/clock.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-solve";

typedef struct options {
    const char *config, *grid, *out, *work_precision;
    cli_list overrides;
    const char *at;
    double tolerance, perturbation;
    int nodes, branch, threads;
    bool quiet;
    const char *json, *path, *method_name;
    solve_method method;
    const char *mode_counts;
    int modes[4]; /* of bending, twist, stretch, shear */
    const char *from, *state_out;
} options;

typedef struct solving {
    options asked;
    char name[128];   /* of the scene */
    config *settings; /* NULL once the experiment has them */
    unknowns unknown;
    bool only_identified; /* of a family, of which no member is meant */
    const scene *scene;
    experiment *e;    /* with a reference only */
    reference *known; /* the same */
    samples grid;
    solve_seen *from;
    size_t from_count;
    size_t time_count;
    double *times; /* [time_count] at which a motion is wanted, s */
    solution *solved;
    solve_report report;
    reference_errors errors; /* of it, against `known` */
    solution_path *path;
    verdict verdict;
    double seconds;
} solving;

static void solving_free(solving *x)
{
    solution_free(x->solved);
    solution_path_free(x->path);
    free(x->times);
    free(x->from);
    samples_free(&x->grid);
    reference_free(x->known);
    experiment_free(x->e);
    config_free(x->settings);
    unknowns_free(&x->unknown);
}

/* ---- samples ------------------------------------------------------------------------------- */

static ad_status evaluate(const solution *solved, const samples *p, ad_error *error)
{
    return solution_evaluate(solved, p->columns, p->count, p->s, p->t, p->values, error);
}

/* Collects the times of the grid and of the reference. */
static ad_status gather_times(solving *x, ad_error *error)
{
    size_t points = x->known ? reference_points(x->known) : 0;
    x->time_count = x->grid.count + points;
    x->times = malloc(x->time_count * sizeof *x->times);
    if (!x->times) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for times");
    }
    memcpy(x->times, x->grid.t, x->grid.count * sizeof *x->times);
    if (x->known) {
        memcpy(x->times + x->grid.count, reference_t(x->known), points * sizeof *x->times);
    }
    return AD_OK;
}

static ad_status write_out(solving *x, ad_error *error)
{
    ad_status status = evaluate(x->solved, &x->grid, error);
    return status == AD_OK ? samples_write(&x->grid, x->scene, x->asked.out, error) : status;
}

/* ---- report -------------------------------------------------------------------------------- */

static bool reached(const solving *x)
{
    return x->only_identified || scene_is_dynamic(x->scene) || x->report.load_fraction == 1;
}

static solve_settings settings_of(const options *o)
{
    return (solve_settings){.tolerance = o->tolerance,
                            .nodes = o->nodes,
                            .perturbation = o->perturbation,
                            .branch = o->branch,
                            .method = o->method,
                            .modes = {o->modes[0], o->modes[1], o->modes[2], o->modes[3]}};
}

/* With --work-precision the tolerance is only that of the solution that others are compared with.
 */
static void judge(solving *x)
{
    solve_settings settings = settings_of(&x->asked);
    settings.nodes = x->asked.work_precision ? x->report.nodes : settings.nodes;
    solution_verdict(x->solved, x->scene, &settings, &x->report, &x->verdict);
}

static bool is_rod_in_motion(const solving *x)
{
    return scene_is_dynamic(x->scene) && !scene_is_beam(x->scene);
}

static void print_reference(const solving *x)
{
    const reference_errors *errors = &x->errors;
    printf("difference from %s (%zu points)\n", reference_name(x->known),
           reference_points(x->known));
    cli_print_error("position, relative L2", errors->position, "");
    cli_print_error("position, largest", errors->position_max, " of the length");
    cli_print_error("tip", errors->tip, " of the length");
    cli_print_error("rotation, largest", errors->rotation_max, " rad");
}

static ad_status print_report(solving *x, ad_error *error)
{
    ad_status status = solution_print(x->solved, x->scene, &x->report, x->seconds, error);
    verdict_print(stdout, "", &x->verdict);
    if (status == AD_OK && x->known) {
        print_reference(x);
    }
    return status;
}

static ad_status write_json(const solving *x, ad_error *error)
{
    const solve_report *r = &x->report;
    json to;
    json_begin(&to);
    json_text(&to, "program", program);
    json_text(&to, "version", cli_version());
    json_text(&to, "name", *x->name ? x->name : NULL);
    report_verdict(&to, &x->verdict);
    unknowns_json(&x->unknown, &to);
    if (x->solved) {
        bool moves = scene_is_dynamic(x->scene);
        json_text(&to, "method", solve_method_names()[x->asked.method]);
        json_integer(&to, "nodes", r->nodes);
        if (r->mode_count > 0) {
            json_integer(&to, "modes", r->mode_count);
        }
        json_integer(&to, "steps", moves ? r->time_steps : r->load_steps);
        json_integer(&to, "newton_steps", r->newton_steps);
        json_number(&to, "seconds", x->seconds);
        json_number(&to, "tolerance", x->asked.tolerance);
        json_number(&to, "estimated_error", r->estimate_l2 + solve_misfit(r));
        json_number(&to, "estimated_error_max", r->estimate + solve_misfit(r));
        json_number(&to, "law_misfit", r->misfit);
        json_number(&to, "loads_out_of_balance", r->balance);
        json_number(&to, "load_factor", moves ? NAN : r->load_fraction);
        json_number(&to, "energy_out_of_balance", r->energy_mismatch);
        report_reference(&to, x->known, &x->errors);
        if (!moves && !scene_is_beam(x->scene)) {
            json_number(&to, "limit_load", r->limit_load);
            json_number(&to, "bifurcation_load", r->bifurcation_load);
            path_files_json(x->path, x->asked.path, &to);
        }
        json_text(&to, "out", reached(x) ? x->asked.out : NULL);
    }
    return json_end(&to, x->asked.json, error);
}

/* ---- the program --------------------------------------------------------------------------- */

/* A reference needs the experiment around the scene. */
static ad_status open_reference(solving *x, ad_error *error)
{
    config *settings = x->settings;
    const train_settings *given = &settings->settings;
    if (given->reference == TRAIN_REFERENCE_NONE && !given->reference_file &&
        !given->reference_deflection.is_given) {
        return AD_OK;
    }
    x->settings = NULL;
    ad_status status = config_experiment_create(settings, 1, &x->e, error);
    if (status == AD_OK) {
        x->scene = x->e->scene;
        status = reference_create(x->e, &x->known, error);
    }
    return status;
}

/* The tolerance without --tol, and that of the solution with which others are compared. */
static void choose_tolerance(solving *x)
{
    double *tolerance = &x->asked.tolerance, usual = solve_settings_default(x->scene).tolerance;
    if (*tolerance == 0) {
        *tolerance = usual;
    }
    if (x->asked.work_precision && x->asked.method != SOLVE_MODES) {
        *tolerance = fmin(*tolerance, usual / 100);
    }
}

/* With --work-precision modes are compared with spectral elements. */
static ad_status solve(solving *x, ad_error *error)
{
    solve_settings settings = settings_of(&x->asked);
    if (x->asked.work_precision) {
        settings.method = SOLVE_COLLOCATION;
    }
    settings.from = x->from;
    settings.from_count = x->from_count;
    double start = train_seconds();
    ad_status status = solution_create(x->scene, &settings, x->time_count, x->times, &x->solved,
                                       &x->report, error);
    x->seconds = train_seconds() - start;
    return status;
}

/* What is to be identified, before the scene is solved with it. Of a family the search is all,
 * unless a member is asked for. */
static ad_status find_unknowns(solving *x, ad_error *error)
{
    const options *o = &x->asked;
    ad_status status =
        unknowns_find(o->config, &o->overrides, o->at, o->threads, &x->unknown, error);
    if (status != AD_OK || !x->unknown.settings) {
        return status;
    }
    snprintf(x->name, sizeof x->name, "%s", x->unknown.settings->settings.name);
    x->only_identified = !o->at && !o->out && !o->path && !o->work_precision &&
                         unknowns_leave_family(&x->unknown, o->at);
    identified_verdict(&x->unknown.found, &x->unknown.settings->scene, &x->verdict);
    if (!o->quiet) {
        unknowns_print(&x->unknown);
        if (x->only_identified) {
            verdict_print(stdout, "", &x->verdict);
        }
    }
    return status;
}

/* Whether the method takes the scene, and the path where one is asked for. */
static ad_status check_method(const solving *x, ad_error *error)
{
    const solve_settings settings = settings_of(&x->asked);
    const char *key = "";
    ad_error reason;
    const ad_status status = solve_check(x->scene, &settings, x->asked.path != NULL, &key, &reason);
    if (status != AD_OK) {
        config_refuse(x->settings, key, reason.message, error);
        error->status = status; /* it is the method that cannot, and the scene is right */
    }
    return status;
}

/* Reads the scene and prepares everything that the solution needs. */
static ad_status prepare(solving *x, ad_error *error)
{
    const options *o = &x->asked;
    const char *const tables[] = {o->work_precision, o->path, o->state_out};
    ad_status status = o->out ? shapes_check_path(o->out, error) : AD_OK;
    for (int i = 0; i < 3 && status == AD_OK; i++) {
        status = tables[i] ? table_check_path(tables[i], error) : AD_OK;
    }
    status = status == AD_OK ? json_check_path(o->json, error) : status;
    if (status == AD_OK) {
        status = find_unknowns(x, error);
    }
    if (status == AD_OK && !x->only_identified) {
        status =
            prepare_read_member(o->config, NULL, o->overrides.count, o->overrides.texts,
                                x->unknown.settings ? x->unknown.at : o->at, &x->settings, error);
    }
    if (status != AD_OK || x->only_identified) {
        return status;
    }
    x->scene = &x->settings->scene;
    snprintf(x->name, sizeof x->name, "%s", x->settings->settings.name);
    choose_tolerance(x);
    status = samples_of_grid(&x->grid, o->grid, x->scene, scene_duration(x->scene),
                             solution_columns(x->scene), error);
    status = status == AD_OK ? check_method(x, error) : status;
    if (status == AD_OK) {
        if (!o->quiet) {
            scene_line_implausible(x->scene);
        }
        status = open_reference(x, error);
    }
    if (status == AD_OK && o->state_out && !is_rod_in_motion(x)) {
        status = ad_fail(error, AD_BAD_INPUT, "--state-out: allowed: of a rod in motion");
    }
    if (status == AD_OK && o->from) {
        status = state_file_read(o->from, scene_length(x->scene), &x->from, &x->from_count, error);
    }
    return status == AD_OK ? gather_times(x, error) : status;
}

/* Also of a rod whose full load has no equilibrium that is found. */
static ad_status follow_path(solving *x, ad_error *error)
{
    const options *o = &x->asked;
    const solve_settings settings = settings_of(o);
    ad_error why;
    ad_status status = solution_path_create(x->scene, &settings, &x->path, error);
    if (status == AD_OK) {
        status = path_files_write(x->path, o->path, error);
    }
    if (status == AD_OK && !o->quiet) {
        path_files_print(x->path, stdout);
    }
    if (status == AD_OK && path_files_draw(o->path, &why) != AD_OK && !o->quiet) {
        cli_warn(program, "%s", why.message);
    }
    return status;
}

static ad_status run(solving *x, ad_error *error)
{
    const options *o = &x->asked;
    ad_status status = prepare(x, error);
    if (status == AD_OK && o->path) {
        status = follow_path(x, error);
    }
    if (status == AD_OK && !x->only_identified) {
        status = solve(x, error);
    }
    if (status != AD_OK || x->only_identified) {
        return status;
    }
    judge(x);
    if (!reached(x)) {
        return AD_OK;
    }
    if (x->known) {
        status = reference_compare_solution(x->known, x->solved, &x->errors, error);
    }
    if (status == AD_OK && o->out) {
        status = write_out(x, error);
    }
    if (status == AD_OK && o->state_out) {
        status =
            state_file_write(o->state_out, x->solved, x->scene, scene_duration(x->scene), error);
    }
    if (status == AD_OK && !o->quiet) {
        scene_line_print(x->name, x->scene);
        status = print_report(x, error);
        if (o->out) {
            printf("wrote %s: %zu points\n", o->out, x->grid.count);
        }
    }
    if (status == AD_OK && o->work_precision) {
        const solve_settings like = settings_of(o);
        status = work_precision_write(x->scene, &like, x->solved, &x->grid, o->work_precision,
                                      !o->quiet, error);
    }
    return status;
}

static bool find_method(options *o)
{
    const char *const *names = solve_method_names();
    for (int i = 0; o->method_name && names[i]; i++) {
        if (strcmp(o->method_name, names[i]) == 0) {
            o->method = (solve_method)i;
            return true;
        }
    }
    return !o->method_name;
}

static bool read_modes(options *o)
{
    const char *text = o->mode_counts;
    if (!text) {
        return true;
    }
    bool good = o->method == SOLVE_MODES;
    int all = 0;
    for (int i = 0; i < 4 && good; i++) {
        char *end;
        const long count = strtol(text, &end, 10);
        good =
            end != text && *end == (i < 3 ? ',' : '\0') && count >= 0 && count <= SOLVE_MODES_MAX;
        o->modes[i] = good ? (int)count : 0;
        all += o->modes[i];
        text = end + 1;
    }
    return good && all > 0;
}

static void blame(solving *x, const ad_error *error)
{
    cli_fail_error(program, error);
    verdict_add_error(&x->verdict, error);
}

int main(int argc, char **argv)
{
    solving x = {.asked = {.tolerance = 0}};
    options *o = &x.asked;
    const cli_option list[] = {
        {"--tol", "X", CLI_NUMBER, &o->tolerance, 1e-13, 1},
        {"--nodes", "N", CLI_INTEGER, &o->nodes, 1, 6000},
        {"--perturb", "X", CLI_NUMBER, &o->perturbation, -1e6, 1e6},
        {"--branch", "N", CLI_INTEGER, &o->branch, 1, 1000},
        {"--method", "NAME", CLI_TEXT, &o->method_name, 0, 0},
        {"--modes", "B,T,ST,SH", CLI_TEXT, &o->mode_counts, 0, 0},
        {"--from", "FILE", CLI_TEXT, &o->from, 0, 0},
        {"--state-out", "FILE", CLI_TEXT, &o->state_out, 0, 0},
        {"--path", "CSV", CLI_TEXT, &o->path, 0, 0},
        CLI_OUT(&o->out),
        CLI_GRID(&o->grid),
        {"--work-precision", "CSV", CLI_TEXT, &o->work_precision, 0, 0},
        CLI_SET(&o->overrides),
        CLI_AT(&o->at),
        CLI_THREADS(&o->threads),
        CLI_JSON(&o->json),
        CLI_QUIET(&o->quiet),
    };
    const cli_program about = {program, "CONFIG.yaml", help_solve, verdict_help, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &o->config);
    if (status != CLI_RUN) {
        return status;
    }
    if (!find_method(o)) {
        return cli_fail(program, "--method %s; allowed: collocation, strain, modes",
                        o->method_name);
    }
    if (!read_modes(o)) {
        return cli_fail(program,
                        "--modes %s; allowed: with --method modes, four numbers from 0 to "
                        "%d, not all 0",
                        o->mode_counts, SOLVE_MODES_MAX);
    }
    if (o->method == SOLVE_MODES && o->nodes > 0) {
        return cli_fail(program, "--nodes and --method modes are given; allowed: --modes");
    }
    if (o->method != SOLVE_MODES && o->from) {
        return cli_fail(program, "--from is given; allowed: with --method modes");
    }
    if (o->method == SOLVE_STRAIN && o->work_precision) {
        return cli_fail(program,
                        "--method %s and --work-precision are given; allowed: one of the "
                        "two",
                        o->method_name);
    }
    if ((o->nodes > 0 || o->mode_counts || o->from) && o->work_precision) {
        return cli_fail(program, "--%s and --work-precision are given; allowed: one of the two",
                        o->nodes > 0 ? "nodes"
                        : o->from    ? "from"
                                     : "modes");
    }
    if (o->grid && !o->out && !o->work_precision) {
        return cli_fail(program, "--grid: nothing would be written there; give --out FILE too");
    }
    o->quiet = o->quiet || json_is_printed(o->json);
    ad_error error = {.message = ""};
    if (run(&x, &error) != AD_OK) {
        blame(&x, &error);
    } else if (!reached(&x) || (o->quiet && verdict_outcome_of(&x.verdict) == VERDICT_WARNING)) {
        verdict_print(stderr, "cpinn-solve: ", &x.verdict);
    }
    if (o->json && write_json(&x, &error) != AD_OK) {
        blame(&x, &error);
    }
    status = verdict_exit_status(&x.verdict);
    solving_free(&x);
    return status;
}
