/* cpinn-solve: solve a scene classically; see --help. */
#include "physics/beam/beam.h"
#include "physics/learn/model.h"
#include "physics/numerics/clock.h"
#include "tools/files/shapes_vtk.h"
#include "tools/prepare/config_experiment.h"
#include "tools/programs/cli.h"
#include "tools/programs/conclude.h"
#include "tools/programs/form.h"
#include "tools/programs/help.h"
#include "tools/programs/motion_derivatives.h"
#include "tools/programs/path_files.h"
#include "tools/programs/residual_deviation.h"
#include "tools/programs/samples.h"
#include "tools/programs/scene_line.h"
#include "tools/programs/solution_print.h"
#include "tools/programs/solve_family.h"
#include "tools/programs/solve_rows.h"
#include "tools/programs/state_file.h"
#include "tools/programs/unknowns.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-solve";

typedef struct options {
    const char *config, *out;
    samples_asked where;
    cli_list overrides;
    const char *at;
    fit_run search; /* of unknowns */
    double tolerance, perturbation;
    int nodes, branch, threads;
    bool quiet;
    const char *json, *path, *rows, *method_name;
    solve_method method;
    const char *mode_counts;
    int modes[4]; /* of bending, twist, stretch, shear */
    const char *from, *state_out, *residuals;
    const char *members;
    bool derivatives; /* of members, or of one in motion */
} options;

typedef struct solving {
    options asked;
    char name[128];   /* of the scene */
    config *settings; /* NULL once the experiment has them */
    unknowns unknown;
    bool only_identified; /* of a family, of which no member is meant */
    const scene *scene;
    motion_derivatives derived;
    experiment *e;    /* with a reference only */
    reference *known; /* the same */
    samples grid;
    solve_seen *from;
    size_t from_count;
    size_t time_count;
    double *times; /* [time_count] at which a motion is wanted, s */
    solution *solved;
    solve_report report;
    rows_solved rows;
    reference_errors errors; /* of it, against `known` */
    solution_path *path;
    residual_deviation learned;
    verdict verdict;
    double seconds;
} solving;

static void solving_free(solving *solving)
{
    solution_free(solving->solved);
    motion_derivatives_free(&solving->derived);
    solution_path_free(solving->path);
    free(solving->times);
    free(solving->from);
    samples_free(&solving->grid);
    reference_free(solving->known);
    experiment_free(solving->e);
    config_free(solving->settings);
    unknowns_free(&solving->unknown);
}

/* ---- samples ------------------------------------------------------------------------------- */

/* Collects the times of the grid and of the reference. */
static ad_status gather_times(solving *solving, ad_error *error)
{
    size_t points = solving->known ? reference_points(solving->known) : 0;
    solving->time_count = solving->grid.count + points;
    solving->times = malloc(solving->time_count * sizeof *solving->times);
    if (!solving->times) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for times");
    }
    memcpy(solving->times, solving->grid.t, solving->grid.count * sizeof *solving->times);
    if (solving->known) {
        memcpy(solving->times + solving->grid.count, reference_t(solving->known),
               points * sizeof *solving->times);
    }
    return AD_OK;
}

static ad_status write_out(solving *solving, ad_error *error)
{
    const answer solved = solving->derived.change
                              ? motion_derivatives_answer(&solving->derived, solving->solved)
                              : answer_of_solution(solving->solved, solving->scene);
    const ad_status status = samples_ask(&solving->grid, &solved, error);
    return status == AD_OK ? samples_write(&solving->grid, solving->asked.out, error) : status;
}

/* ---- report -------------------------------------------------------------------------------- */

static bool reached(const solving *solving)
{
    return solving->only_identified || solving->asked.rows || scene_is_dynamic(solving->scene) ||
           solving->report.load_fraction == 1;
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

static void judge(solving *solving)
{
    const solve_settings settings = settings_of(&solving->asked);
    solution_verdict(solving->solved, solving->scene, &settings, &solving->report,
                     &solving->verdict);
    residual_deviation_judge(&solving->learned, &solving->verdict);
    motion_derivatives_judge(&solving->derived, &solving->verdict);
}

static bool is_rod_in_motion(const solving *solving)
{
    return scene_is_dynamic(solving->scene) && !scene_is_beam(solving->scene);
}

static ad_status print_report(solving *solving, ad_error *error)
{
    ad_status status =
        solution_print(solving->solved, solving->scene, &solving->report, solving->seconds, error);
    residual_deviation_print(&solving->learned);
    motion_derivatives_print(&solving->derived);
    verdict_print(stdout, "", &solving->verdict);
    if (status == AD_OK && solving->known) {
        solution_print_errors("difference from", solving->known, &solving->errors);
    }
    return status;
}

static void tell(const void *of, json *to)
{
    const solving *solving = of;
    const solve_report *r = &solving->report;
    unknowns_json(&solving->unknown, to);
    if (solving->asked.rows) {
        json_integer(to, "rows", (long long)solving->rows.rows);
        json_integer(to, "rows_reached", (long long)solving->rows.reached);
        json_number(to, "estimated_error", solving->rows.estimate);
        json_number(to, "seconds", solving->seconds);
        json_text(to, "out", solving->asked.out);
    }
    if (solving->solved) {
        bool moves = scene_is_dynamic(solving->scene);
        json_text(to, "method", solve_method_names()[solving->asked.method]);
        json_text(to, "form", form_of_solver(solving->scene, solving->asked.method));
        json_integer(to, "nodes", r->nodes);
        if (r->mode_count > 0) {
            json_integer(to, "modes", r->mode_count);
        }
        json_integer(to, "steps", moves ? r->time_steps : r->load_steps);
        json_integer(to, "newton_steps", r->newton_steps);
        json_number(to, "seconds", solving->seconds);
        json_number(to, "tolerance", solving->asked.tolerance);
        json_number(to, "estimated_error", r->estimate_l2 + solve_misfit(r));
        json_number(to, "estimated_error_max", r->estimate + solve_misfit(r));
        json_number(to, "law_misfit", r->misfit);
        json_number(to, "loads_out_of_balance", r->balance);
        json_number(to, "load_factor", moves ? NAN : r->load_fraction);
        json_number(to, "energy_out_of_balance", r->energy_mismatch);
        report_reference(to, solving->known, &solving->errors);
        if (!moves && !scene_is_beam(solving->scene)) {
            json_number(to, "limit_load", r->limit_load);
            json_number(to, "bifurcation_load", r->bifurcation_load);
            path_files_json(solving->path, solving->asked.path, to);
        }
        motion_derivatives_json(&solving->derived, to);
        residual_deviation_json(&solving->learned, to);
        json_text(to, "out", reached(solving) ? solving->asked.out : NULL);
    }
}

/* ---- the program --------------------------------------------------------------------------- */

/* A reference needs the experiment around the scene. */
static ad_status open_reference(solving *solving, ad_error *error)
{
    config *settings = solving->settings;
    const train_settings *given = &settings->settings;
    if (given->reference == TRAIN_REFERENCE_NONE && !given->reference_file &&
        !given->reference_deflection.is_given) {
        return AD_OK;
    }
    solving->settings = NULL;
    ad_status status = config_experiment_without_network(settings, &solving->e, error);
    if (status == AD_OK) {
        solving->scene = solving->e->scene;
        status = reference_create(solving->e, &solving->known, error);
    }
    return status;
}

static ad_status solve(solving *solving, ad_error *error)
{
    solve_settings settings = settings_of(&solving->asked);
    settings.from = solving->from;
    settings.from_count = solving->from_count;
    double start = clock_seconds(CLOCK_MONOTONIC);
    ad_status status = solution_create(solving->scene, &settings, solving->time_count,
                                       solving->times, &solving->solved, &solving->report, error);
    status = status == AD_OK ? motion_derivatives_find(&solving->derived, solving->scene,
                                                       &solving->grid, &settings, error)
                             : status;
    solving->seconds = clock_seconds(CLOCK_MONOTONIC) - start;
    return status;
}

/* What data say: unknowns, before the scene is solved with them, and how far it is from each file.
 * Of a family that is all, unless a member is asked for. */
static ad_status find_unknowns(solving *solving, ad_error *error)
{
    options *o = &solving->asked;
    memcpy(solving->unknown.modes, o->modes, sizeof o->modes);
    unknowns *unknown = &solving->unknown;
    ad_status status = unknowns_find(o->config, &o->overrides, o->at, o->threads,
                                     o->residuals != NULL, &o->search, unknown, error);
    if (status == AD_OK && o->residuals && !unknown->settings) {
        return ad_fail(error, AD_BAD_INPUT,
                       "--residuals: allowed: of a scene with data, without --at of its unknowns");
    }
    if (status == AD_OK && o->search.folder &&
        (!unknown->settings || unknown->open->unknown_count == 0)) {
        return ad_fail(error, AD_BAD_INPUT, "--run: allowed: of a scene with unknowns to be found");
    }
    if (status != AD_OK || !unknown->settings) {
        return status;
    }
    snprintf(solving->name, sizeof solving->name, "%s", solving->unknown.settings->settings.name);
    solving->only_identified =
        !o->at && !o->out && !o->path && unknowns_leave_family(&solving->unknown, o->at);
    if (o->search.signal) {
        solving->only_identified = true;
        solving->verdict.signal = o->search.signal;
        verdict_add(&solving->verdict, VERDICT_SIGNAL, "stopped and saved; --resume goes on");
        return AD_OK;
    }
    unknowns_verdict(unknown, &solving->verdict);
    if (!o->quiet) {
        unknowns_print(&solving->unknown);
        if (solving->only_identified) {
            verdict_print(stdout, "", &solving->verdict);
        }
    }
    if (o->residuals) {
        status = unknowns_write(unknown, o->residuals, o->quiet, error);
    }
    return status;
}

/* Whether the method takes the scene, and the path where one is asked for. */
static ad_status check_method(const solving *solving, ad_error *error)
{
    const solve_settings settings = settings_of(&solving->asked);
    const char *key = "";
    ad_error reason;
    const ad_status status =
        solve_check(solving->scene, &settings, solving->asked.path != NULL, &key, &reason);
    if (status != AD_OK) {
        config_refuse(solving->settings, key, reason.message, error);
        error->status = status; /* it is the method that cannot, and the scene is right */
    }
    return status;
}

/* What derivatives of a motion ask for. */
static ad_status open_family(solving *solving, ad_error *error)
{
    const options *o = &solving->asked;
    return is_rod_in_motion(solving)
               ? motion_derivatives_open(o->config, &o->overrides, o->at, &solving->grid,
                                         &solving->derived, error)
               : ad_fail(error, AD_BAD_ARGUMENT,
                         "--derivatives: allowed: of --members where nothing moves; not of beams");
}

/* Reads the scene and prepares everything that the solution needs. */
static ad_status prepare(solving *solving, ad_error *error)
{
    const options *o = &solving->asked;
    const char *const tables[] = {o->path, o->state_out, o->residuals};
    ad_status status = o->out ? shapes_check_path(o->out, error) : AD_OK;
    for (int i = 0; i < 3 && status == AD_OK; i++) {
        status = tables[i] ? table_check_path(tables[i], error) : AD_OK;
    }
    status = status == AD_OK ? json_check_path(o->json, error) : status;
    if (status == AD_OK) {
        status = find_unknowns(solving, error);
    }
    if (status == AD_OK && !solving->only_identified) {
        status = prepare_read_member(o->config, NULL, o->overrides.count, o->overrides.texts,
                                     *solving->unknown.at ? solving->unknown.at : o->at,
                                     &solving->settings, error);
    }
    if (status != AD_OK || solving->only_identified) {
        return status;
    }
    solving->scene = &solving->settings->scene;
    snprintf(solving->name, sizeof solving->name, "%s", solving->settings->settings.name);
    status = residual_deviation_find(solving->settings, o->config, &o->overrides, o->at, o->threads,
                                     &solving->learned, error);
    if (status != AD_OK) {
        return status;
    }
    const solve_settings usual = solve_settings_default(solving->scene);
    if (solving->asked.tolerance == 0) {
        solving->asked.tolerance = usual.tolerance;
    }
    if (!o->method_name) {
        solving->asked.method = o->nodes > 0     ? SOLVE_COLLOCATION
                                : o->derivatives ? SOLVE_MODES
                                                 : usual.method;
    }
    status = samples_choose(&solving->grid, &o->where, NULL, solving->scene,
                            scene_duration(solving->scene), error);
    status = status == AD_OK && o->derivatives ? open_family(solving, error) : status;
    status = status == AD_OK ? check_method(solving, error) : status;
    if (status == AD_OK) {
        if (!o->quiet) {
            scene_line_implausible(solving->scene);
        }
        status = open_reference(solving, error);
    }
    if (status == AD_OK && o->state_out && !is_rod_in_motion(solving)) {
        status = ad_fail(error, AD_BAD_INPUT, "--state-out: allowed: of a rod in motion");
    }
    if (status == AD_OK && o->from) {
        status = state_file_read(o->from, scene_length(solving->scene), &solving->from,
                                 &solving->from_count, error);
    }
    return status == AD_OK ? gather_times(solving, error) : status;
}

/* Also of a rod whose full load has no equilibrium that is found. */
static ad_status follow_path(solving *solving, ad_error *error)
{
    const options *o = &solving->asked;
    const solve_settings settings = settings_of(o);
    ad_status status = solution_path_create(solving->scene, &settings, &solving->path, error);
    if (status == AD_OK) {
        status = path_files_write(solving->path, o->path, error);
    }
    if (status == AD_OK && !o->quiet) {
        path_files_print(solving->path, stdout);
    }
    return status;
}

/* Of a table of commands, all of it. */
static ad_status run_rows(solving *solving, ad_error *error)
{
    options *o = &solving->asked;
    ad_status status = o->out ? shapes_check_path(o->out, error) : AD_OK;
    status = status == AD_OK ? json_check_path(o->json, error) : status;
    status = status == AD_OK ? prepare_read(o->config, NULL, o->overrides.count, o->overrides.texts,
                                            &solving->settings, error)
                             : status;
    if (status != AD_OK) {
        return status;
    }
    const scene *open = solving->scene = &solving->settings->scene;
    snprintf(solving->name, sizeof solving->name, "%s", solving->settings->settings.name);
    if (scene_is_dynamic(open) || !scene_is_open(open)) {
        return ad_fail(error, AD_BAD_INPUT, "--rows: allowed: of a scene at rest with parameters");
    }
    o->tolerance = o->tolerance > 0 ? o->tolerance : solve_settings_default(open).tolerance;
    const solve_settings settings = settings_of(o);
    const double start = clock_seconds(CLOCK_MONOTONIC);
    status = samples_choose(&solving->grid, &o->where, NULL, open, 0, error);
    status = status == AD_OK ? solve_rows_run(open, o->rows, &settings, &solving->grid,
                                              &solving->rows, &solving->verdict, error)
                             : status;
    solving->seconds = clock_seconds(CLOCK_MONOTONIC) - start;
    if (status == AD_OK && o->out) {
        status = samples_write(&solving->grid, o->out, error);
    }
    if (status == AD_OK && !o->quiet) {
        printf("%s: %zu of %zu rows in their order, largest estimated error %.3e of the length, "
               "%.1f s\n",
               solving->name, solving->rows.reached, solving->rows.rows, solving->rows.estimate,
               solving->seconds);
        verdict_print(stdout, "", &solving->verdict);
    }
    return status;
}

static ad_status run(solving *solving, ad_error *error)
{
    const options *o = &solving->asked;
    if (o->rows) {
        return run_rows(solving, error);
    }
    ad_status status = prepare(solving, error);
    if (status == AD_OK && o->path) {
        status = follow_path(solving, error);
    }
    if (status == AD_OK && !solving->only_identified) {
        status = solve(solving, error);
    }
    if (status != AD_OK || solving->only_identified) {
        return status;
    }
    judge(solving);
    if (!reached(solving)) {
        return AD_OK;
    }
    if (solving->known) {
        status =
            reference_compare_solution(solving->known, solving->solved, &solving->errors, error);
    }
    if (status == AD_OK && o->out) {
        status = write_out(solving, error);
    }
    if (status == AD_OK && o->state_out) {
        status = state_file_write(o->state_out, solving->solved, solving->scene,
                                  scene_duration(solving->scene), error);
    }
    if (status == AD_OK && !o->quiet) {
        scene_line_print(solving->name, solving->scene);
        status = print_report(solving, error);
        if (o->out) {
            printf("wrote %s: %zu points\n", o->out, solving->grid.count);
        }
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

/* Beside --members stands what says how and where shapes are wanted. */
static int solve_members_of(const options *o)
{
    if (o->at || o->path || o->from || o->state_out || o->method_name || o->branch > 0 ||
        o->nodes > 0 || o->perturbation != 0 || o->search.folder) {
        return cli_fail(program, "--members: allowed beside it: --out, --grid, --points, --set, "
                                 "--derivatives, --tolerance, --threads, --json, --quiet");
    }
    return solve_family_run(program, &(solve_family_options){.config = o->config,
                                                             .members = o->members,
                                                             .out = o->out,
                                                             .json = o->json,
                                                             .overrides = &o->overrides,
                                                             .where = o->where,
                                                             .tolerance = o->tolerance,
                                                             .threads = o->threads,
                                                             .derivatives = o->derivatives,
                                                             .quiet = o->quiet});
}

int main(int argc, char **argv)
{
    solving x = {.asked = {.search.program = program}, .errors = {NAN, NAN, NAN, NAN, NAN}};
    options *o = &x.asked;
    const cli_option list[] = {
        {"--tolerance", "X", CLI_NUMBER, &o->tolerance, 1e-13, 1},
        {"--nodes", "N", CLI_INTEGER, &o->nodes, 1, 6000},
        {"--perturb", "X", CLI_NUMBER, &o->perturbation, -1e6, 1e6},
        {"--branch", "N", CLI_INTEGER, &o->branch, 1, 1000},
        {"--method", "NAME", CLI_TEXT, &o->method_name, 0, 0},
        {"--modes", "B,T,ST,SH", CLI_TEXT, &o->mode_counts, 0, 0},
        {"--from", "FILE", CLI_TEXT, &o->from, 0, 0},
        {"--state-out", "FILE", CLI_TEXT, &o->state_out, 0, 0},
        {"--path", "CSV", CLI_TEXT, &o->path, 0, 0},
        {"--rows", "FILE", CLI_TEXT, &o->rows, 0, 0},
        CLI_OUT(&o->out),
        CLI_GRID(&o->where.grid),
        CLI_POINTS(&o->where.points),
        CLI_SET(&o->overrides),
        CLI_DATA(&o->overrides),
        CLI_AT(&o->at),
        {"--members", "FILE", CLI_TEXT, &o->members, 0, 0},
        {"--derivatives", NULL, CLI_FLAG, &o->derivatives, 0, 0},
        CLI_THREADS(&o->threads),
        CLI_JSON(&o->json),
        CLI_QUIET(&o->quiet),
        {"--residuals", "FILE", CLI_TEXT, &o->residuals, 0, 0},
        {"--run", "DIR", CLI_TEXT, &o->search.folder, 0, 0},
        {"--resume", NULL, CLI_FLAG, &o->search.resume, 0, 0},
    };
    const cli_program about = {program, "CONFIG.yaml", help_solve, verdict_help, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &o->config);
    if (status != CLI_RUN) {
        return status;
    }
    if (!find_method(o)) {
        return cli_fail(program, "--method %s; allowed: collocation, modes", o->method_name);
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
    if (o->rows && (o->at || o->path || o->branch || o->state_out || o->search.folder)) {
        return cli_fail(program,
                        "--rows with --at, --path, --branch, --state-out or --run; allowed: "
                        "one of them");
    }
    status = samples_check(program, &o->where, o->out);
    if (status != CLI_RUN) {
        return status;
    }
    o->quiet = o->search.quiet = o->quiet || json_is_printed(o->json);
    if (o->members) {
        return solve_members_of(o);
    }
    if (o->derivatives &&
        (!o->at || !o->out || o->nodes > 0 || (o->method_name && o->method != SOLVE_MODES))) {
        return cli_fail(program, "--derivatives: allowed: of --members, or of a rod in motion with "
                                 "--at and --out, by modes");
    }
    ad_error error = {.message = ""};
    const ad_status ran = run(&x, &error);
    const conclusion end = {.program = program,
                            .quiet = o->quiet,
                            .anyhow = ran == AD_OK && !reached(&x),
                            .json = o->json,
                            .name = *x.name ? x.name : NULL,
                            .tell = tell,
                            .of = &x,
                            .verdict = &x.verdict};
    status = conclude(&end, ran, &error);
    solving_free(&x);
    fit_run_end(&o->search);
    return status;
}
