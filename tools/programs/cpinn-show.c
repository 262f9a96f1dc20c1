/* cpinn-show: a report as one HTML file; see --help. */
#include "physics/chain/solve_members.h"
#include "tools/files/file_bytes.h"
#include "tools/programs/help.h"
#include "tools/programs/show_source.h"
#include "tools/programs/signals.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char program[] = "cpinn-show";

static void showing_free(showing *showing)
{
    show_kept_free(&showing->kept);
    table_free(showing->table);
    table_free(showing->ghost);
    samples_free(&showing->samples);
    surface_free(showing->wall);
    solution_free(showing->solved);
    reference_free(showing->known);
    field_free(showing->field);
    checkpoint_free(showing->file);
    experiment_free(showing->e);
    config_free(showing->settings);
}

/* ---- a scene that is solved ---------------------------------------------------------------- */

/* Families at rest of which the members are solved at once. */
static bool is_fan(const scene *of)
{
    ad_error unused;
    solve_members *members = NULL;
    const double s = scene_length(of);
    const solve_members_settings settings = {.tolerance = 1e-6, .threads = 1, .points = 1, .s = &s};
    const bool taken = scene_is_family(of) && !scene_is_dynamic(of) && of->unknown_count == 0 &&
                       solve_members_create(of, &settings, &members, &unused) == AD_OK;
    solve_members_free(members);
    return taken;
}

static ad_status show_solved(showing *showing, ad_error *error)
{
    solve_report report;
    verdict judged = {.count = 0};
    ad_status status = config_read(showing->source, NULL, showing->overrides.count,
                                   showing->overrides.texts, &showing->settings, error);
    if (status != AD_OK) {
        return status;
    }
    if (!showing->at && is_fan(&showing->settings->scene)) {
        status = prepare_config(showing->settings, error);
        return status == AD_OK ? show_members(showing, error) : status;
    }
    config_free(showing->settings);
    showing->settings = NULL;
    status = prepare_read_member(showing->source, NULL, showing->overrides.count,
                                 showing->overrides.texts, showing->at, &showing->settings, error);
    if (status != AD_OK) {
        return status;
    }
    const scene *of = &showing->settings->scene;
    const solve_settings settings = solve_settings_default(of);
    snprintf(showing->title, sizeof showing->title, "%s", showing->settings->settings.name);
    status = show_choose_points(showing, of, scene_duration(of), error);
    samples *p = &showing->samples;
    if (status == AD_OK) {
        status = solution_create(of, &settings, p->count, p->t, &showing->solved, &report, error);
    }
    if (status == AD_OK) {
        const answer found = answer_of_solution(showing->solved, of);
        status = samples_ask(p, &found, error);
    }
    if (status != AD_OK) {
        return status;
    }
    solution_verdict(showing->solved, of, &settings, &report, &judged);
    report_verdict(&showing->to, &judged);
    json_open(&showing->to, "facts", '[');
    show_scene_facts(&showing->to, of);
    show_fact(&showing->to, "nodes", "%.0f", report.nodes);
    if (!isnan(report.estimate)) {
        show_fact(&showing->to, "estimated error, largest, over the length", "%.1e",
                  report.estimate);
    }
    json_close(&showing->to, ']');
    status = show_put_shapes(showing, of, NULL, NULL, NULL, error);
    show_settings(&showing->to, showing->settings);
    return status;
}

/* ---- a table ------------------------------------------------------------------------------- */

static bool ends_with(const char *text, const char *ending)
{
    const size_t length = strlen(text), more = strlen(ending);
    return length > more && strcmp(text + length - more, ending) == 0;
}

/* Whether the first line of a .csv file names columns of shapes or of a closed loop; what is
 * neither may hold words. */
static bool has_shapes(const char *path)
{
    unsigned char *bytes = NULL;
    size_t size, length;
    ad_error why;
    bool any = !ends_with(path, ".csv") ||
               file_bytes_read(path, TABLE_MAX_LINE, &bytes, &size, &length, &why) != AD_OK;
    char *rest = NULL, *line = any ? NULL : strtok_r((char *)bytes, "\r\n", &rest);
    while (line && *line == '#') {
        line = strtok_r(NULL, "\r\n", &rest);
    }
    for (char *name = line ? strtok_r(line, ", \t", &rest) : NULL; name && !any;
         name = strtok_r(NULL, ", \t", &rest)) {
        any = strcmp(name, "x") == 0 || strcmp(name, "s") == 0 || strcmp(name, "true_x") == 0;
    }
    free(bytes);
    return any;
}

static ad_status show_read(showing *showing, const table_build *read, ad_error *error)
{
    const table_source *table = &read->table;
    if (show_is_residuals(showing->table)) {
        return show_residuals(showing, table, error);
    }
    if (table_source_column(table, "true_x")) {
        return show_loop(showing, table, error);
    }
    if (!table_source_column(table, "x") && !table_source_column(table, "w")) {
        return show_numbers(showing, table, error);
    }
    ad_status status = showing->wall_path ? show_open_wall(showing, error) : AD_OK;
    status = status == AD_OK ? show_put_motion(showing, table, NULL, NULL, NULL, error) : status;
    if (status == AD_OK && showing->wall) {
        status = show_put_wall(showing, error);
    }
    if (status == AD_OK && showing->settings) {
        show_settings(&showing->to, showing->settings);
        status =
            show_scene(&showing->to, &showing->settings->scene, NULL, &showing->kept, NULL, error);
    }
    return status;
}

static ad_status show_table(showing *showing, ad_error *error)
{
    static const char *const words[] = {"source", "reason", "file", "judged", NULL};
    show_title_of(showing, showing->source);
    ad_status status =
        table_read_words(showing->source, TABLE_NONFINITE, words, &showing->table, error);
    if (status == AD_BAD_INPUT && !has_shapes(showing->source)) {
        return show_csv(showing, error);
    }
    if (status == AD_OK && showing->scene_path && !table_column(showing->table, "true_x")) {
        status =
            config_read_member(showing->scene_path, NULL, showing->overrides.count,
                               showing->overrides.texts, showing->at, &showing->settings, error);
        status = status == AD_OK ? prepare_choices(showing->settings, error) : status;
    }
    const scene *of = showing->settings ? &showing->settings->scene : NULL;
    table_build *read = status == AD_OK ? show_read_table_of(showing->table, of) : NULL;
    if (status == AD_OK && !read) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    status = status == AD_OK ? show_read(showing, read, error) : status;
    free(read);
    return status;
}

/* ---- the program --------------------------------------------------------------------------- */

/* "DIR/report.html" of a folder, else "NAME.html" here. */
static void choose_out(showing *showing, bool is_folder, char *path, size_t size)
{
    if (is_folder) {
        const size_t length = strlen(showing->source);
        snprintf(path, size, "%s%sreport.html", showing->source,
                 showing->source[length - 1] == '/' ? "" : "/");
    } else {
        snprintf(path, size, "%s.html", showing->title);
    }
}

/* The texts that every page has: what file it was made of. */
static ad_status fill(showing *showing, bool is_folder, ad_error *error)
{
    struct stat of;
    char inside[4096];
    snprintf(inside, sizeof inside, "%s/checkpoint.h5", showing->source);
    if (is_folder && stat(inside, &of) != 0) {
        return show_folder(showing, error);
    }
    if (ends_with(showing->source, ".yaml") || ends_with(showing->source, ".yml")) {
        return show_solved(showing, error);
    }
    if (!is_folder && !ends_with(showing->source, "checkpoint.h5")) {
        return show_table(showing, error);
    }
    ad_status status = checkpoint_open(is_folder ? inside : showing->source, &showing->file, error);
    if (status == AD_OK && checkpoint_has(showing->file, "surrogate/numbers")) {
        return show_surrogate(showing, error);
    }
    checkpoint_free(showing->file);
    showing->file = NULL;
    return status == AD_OK ? show_run(showing, error) : status;
}

static ad_status run(showing *showing, char *path, size_t size, ad_error *error)
{
    struct stat of;
    if (stat(showing->source, &of) != 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: does not exist; allowed: a folder of a run, "
                       "SCENE.yaml, a table",
                       file_bytes_shown(showing->source));
    }
    const bool is_folder = S_ISDIR(of.st_mode);
    snprintf(path, size, "%s", showing->out ? showing->out : "");
    ad_status status = showing->out ? file_bytes_check(showing->out, error) : AD_OK;
    if (status == AD_OK && showing->workspace) {
        status = table_check_path(showing->workspace, error);
    }
    json_begin(&showing->to);
    json_text(&showing->to, "program", "cpinn");
    json_text(&showing->to, "version", cli_version());
    json_text(&showing->to, "source", showing->source);
    status = status == AD_OK ? fill(showing, is_folder, error) : status;
    if (!showing->out) {
        choose_out(showing, is_folder, path, size);
    }
    if (status == AD_OK && (showing->workspace || showing->by) && !showing->has_workspace) {
        status =
            ad_fail(error, AD_BAD_INPUT,
                    "%s: --%s is of families at rest with predicted errors, without --at",
                    file_bytes_shown(showing->source), showing->workspace ? "workspace" : "by");
    }
    if (status == AD_OK && showing->wall_path && !showing->wall) {
        status = ad_fail(error, AD_BAD_INPUT, "%s: --wall is of tables of shapes",
                         file_bytes_shown(showing->source));
    }
    json_text(&showing->to, "title", showing->title);
    if (status == AD_OK && show_is_picture(showing->out)) {
        return show_picture(showing, error);
    }
    if (status != AD_OK) {
        char *text;
        size_t length;
        ad_error unused;
        json_take(&showing->to, &text, &length, &unused);
        free(text);
        return status;
    }
    return show_page(&showing->to, showing->title, path, error);
}

int main(int argc, char **argv)
{
    showing x = {.source = NULL, .slow = 1};
    char path[4200];
    ad_error error = {.message = ""};
    const cli_option list[] = {
        {"--out", "FILE", CLI_TEXT, &x.out, 0, 0},
        {"--slow", "X", CLI_NUMBER, &x.slow, 1e-3, 1e6},
        {"--scene", "CONFIG.yaml", CLI_TEXT, &x.scene_path, 0, 0},
        {"--wall", "CONFIG.yaml", CLI_TEXT, &x.wall_path, 0, 0},
        {"--reference", "TABLE", CLI_TEXT, &x.reference_path, 0, 0},
        {"--workspace", "FILE", CLI_TEXT, &x.workspace, 0, 0},
        {"--by", "NAME", CLI_TEXT, &x.by, 0, 0},
        CLI_GRID(&x.grid),
        CLI_SET(&x.overrides),
        CLI_DATA(&x.overrides),
        CLI_AT(&x.at),
        CLI_QUIET(&x.quiet),
    };
    const cli_program about = {program, "SOURCE", help_show, NULL, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &x.source);
    if (status != CLI_RUN) {
        return status;
    }
    status = 0;
    if (run(&x, path, sizeof path, &error) != AD_OK) {
        status = cli_fail_error(program, &error);
        status = signals_caught() ? 128 + signals_caught() : status;
    } else if (!x.quiet) {
        printf("wrote %s\n", path);
    }
    showing_free(&x);
    return status;
}
