/* cpinn-law: learns the constitutive law of a section from a table; see --help. */
#include "physics/numerics/clock.h"
#include "tools/files/table_file.h"
#include "tools/programs/fit_run.h"
#include "tools/programs/help.h"
#include "tools/train/train_law.h"

#include <math.h>
#include <string.h>

static const char program[] = "cpinn-law";

/* The index of `text` among names; -1: none. */
static int index_of(const char *const *names, const char *text)
{
    for (int i = 0; names[i]; i++) {
        if (strcmp(names[i], text) == 0) {
            return i;
        }
    }
    return -1;
}

static void print(const train_law_settings *settings, const scene_law *law,
                  const train_law_report *report, double seconds)
{
    static const char *const names[] = {"n1", "n2", "n3", "m1", "m2", "m3"};
    static const char *const strains[] = {"v1", "v2", "v3", "u1", "u2", "u3"};
    printf("%zu rows, %zu held out; %d units, %s%s; step %d of start %d; %.2f s\n",
           report->trained + report->held_out, report->held_out, law->units,
           scene_symmetry_names()[law->symmetry], settings->convex ? ", convex" : "", report->steps,
           report->start, seconds);
    printf("      error     held out  linear law  stiffness at rest  strain of the data\n");
    for (int i = 0; i < SCENE_LAW_STRAINS; i++) {
        if (isinf(law->scale[i])) {
            printf("%s    locked\n", names[i]);
        } else {
            printf("%s    %-8.1e  %-8.1e  %-10.1e  %-17.6g  %s%s %g .. %g%s\n", names[i],
                   report->error[i], report->held_out_error[i], report->linear[i],
                   law->stiffness[i], strains[i], i == 2 ? " - 1" : "", law->low[i], law->high[i],
                   i < 3 ? "" : " 1/m");
        }
    }
}

int main(int argc, char **argv)
{
    train_law_settings settings = train_law_defaults();
    const char *data_file, *out = "law.csv", *symmetry = "none";
    int seed = 0;
    fit_run run = {.program = program};
    const least_squares_runner runner = fit_run_by(&run);
    const cli_option options[] = {
        {"--out", "FILE", CLI_TEXT, &out, 0, 0},
        {"--symmetry", "NAME", CLI_TEXT, &symmetry, 0, 0},
        {"--convex", NULL, CLI_FLAG, &settings.convex, 0, 0},
        {"--units", "N", CLI_INTEGER, &settings.units, 1, SCENE_LAW_UNITS_MAX},
        {"--held-out", "SHARE", CLI_NUMBER, &settings.held_out, 0, 0.9},
        {"--starts", "N", CLI_INTEGER, &settings.starts, 1, 1000},
        {"--steps", "N", CLI_INTEGER, &settings.steps, 1, 1000000},
        CLI_SEED(&seed),
        {"--run", "DIR", CLI_TEXT, &run.folder, 0, 0},
        {"--resume", NULL, CLI_FLAG, &run.resume, 0, 0}};
    const cli_program face = {.name = program, .operand = "TABLE", .help = help_law};
    int status =
        cli_parse(&face, options, sizeof options / sizeof *options, argc, argv, &data_file);
    if (status != CLI_RUN) {
        return status;
    }
    ad_error error, reason;
    train_law_data data;
    train_law_report report;
    scene_law law;
    const int kind = index_of(scene_symmetry_names(), symmetry);
    if (kind < 0) {
        return cli_fail(program, "--symmetry %s; allowed: none, point, mirrors, round", symmetry);
    }
    settings.symmetry = (scene_symmetry)kind;
    settings.seed = (uint64_t)seed;
    settings.runner = &runner;
    if (table_check_path(out, &error) != AD_OK ||
        fit_run_ask(&run, NULL, &error,
                    "law: {symmetry: %s, convex: %s, units: %d, held_out: %.17g, starts: %d, "
                    "steps: %d, seed: %d}\n",
                    symmetry, settings.convex ? "true" : "false", settings.units, settings.held_out,
                    settings.starts, settings.steps, seed) != AD_OK ||
        train_law_read_data(data_file, &data, &error) != AD_OK) {
        fit_run_end(&run);
        return cli_fail_error(program, &error);
    }
    const double begin = clock_seconds(CLOCK_MONOTONIC);
    if (train_law_fit(&settings, &data, &law, &report, &reason) != AD_OK) {
        ad_fail(&error, reason.status, "%s: %s", data_file, reason.message);
        status = cli_fail_error(program, &error);
    } else if (!run.signal) {
        print(&settings, &law, &report, clock_seconds(CLOCK_MONOTONIC) - begin);
        status = train_law_write(out, &law, &error) == AD_OK ? 0 : cli_fail_error(program, &error);
    }
    train_law_free_data(&data);
    const int left = fit_run_end(&run);
    return left ? left : status;
}
