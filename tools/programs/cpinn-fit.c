/* cpinn-fit: solves equations of one's own; see --help. */
#include "physics/numerics/clock.h"
#include "tools/config/config_equations.h"
#include "tools/files/file_bytes.h"
#include "tools/programs/cli.h"
#include "tools/programs/conclude.h"
#include "tools/programs/equation_places.h"
#include "tools/programs/estimates.h"
#include "tools/programs/help.h"
#include "tools/programs/signals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char program[] = "cpinn-fit";

typedef struct fitting {
    const char *file, *grid, *points, *out, *reference, *json, *save;
    cli_list overrides;
    double tolerance, seconds;
    int threads;
    bool quiet;
    config_equations *read;
    equation_places at;
    equation_reference known; /* of --reference */
    equation_difference difference;
    cpinn_fit *fit;
    verdict verdict;
    bool speaks, live;
    int width;          /* of the live line */
    double spoken, gap; /* s, when it spoke last, and until the next line */
} fitting;

/* ---- on the way ------------------------------------------------------------------------------ */

static void clear_line(fitting *f)
{
    if (f->width > 0) {
        fprintf(stderr, "\r%*s\r", f->width, "");
        f->width = 0;
    }
}

/* A live line on a terminal, lines at growing intervals elsewhere. */
static bool progress(void *context, const patches_progress *now)
{
    fitting *f = context;
    if (f->speaks && now->seconds >= f->spoken + (f->live ? 0.2 : f->gap)) {
        char line[120];
        const int width = snprintf(line, sizeof line,
                                   "attempt %d, window %d, %.0f %% of time, %d patches, error "
                                   "%.1e, %.1f s",
                                   now->attempt, now->window, 100 * now->done, now->patches,
                                   now->estimate, now->seconds);
        fprintf(stderr, f->live ? "\r%-*s" : "%*s\n", f->live && f->width > width ? f->width : 0,
                line);
        fflush(stderr);
        f->width = f->live ? width : 0;
        f->gap = fmin(1.5 * f->gap, 60);
        f->spoken = now->seconds;
    }
    return !signals_caught();
}

/* ---- report ---------------------------------------------------------------------------------- */

static void print(const fitting *f)
{
    const patches_summary s = cpinn_fit_summary(f->fit);
    const physics_model *m = cpinn_fit_model(f->fit);
    printf("%s: %d field%s of", f->read->name, m->field_count, m->field_count == 1 ? "" : "s");
    for (int i = 0; i < m->domain.count; i++) {
        printf("%s %s", i ? "," : "", m->domain.coordinates[i].name);
    }
    printf("; %d window%s, up to %d patches, %zu numbers, %d steps, %.2f s\n", s.windows,
           s.windows == 1 ? "" : "s", s.most_patches, s.parameters, s.steps, s.seconds);
    for (int i = 0; i < s.unknowns; i++) {
        printf("%s = %.8g +- %.1e\n", m->own_unknowns[i].name, s.unknown[i], s.deviation[i]);
    }
    if (s.windows > 0) {
        printf("estimate: %.1e", s.estimate);
        if (s.by_unknowns > 0) {
            printf(", %.1e of it by the deviations of the unknowns", s.by_unknowns);
        }
        putchar('\n');
    }
    if (f->difference.field) {
        printf("error: %.1e, largest %.1e, of %s at %zu points of %s\n", f->difference.relative,
               f->difference.largest, f->difference.field, f->difference.count, f->reference);
    }
    verdict_print(stdout, "", &f->verdict);
}

static void tell(const void *of, json *to)
{
    const fitting *f = of;
    if (!f->fit) {
        return;
    }
    const patches_summary s = cpinn_fit_summary(f->fit);
    const physics_model *m = cpinn_fit_model(f->fit);
    json_number(to, "tolerance", cpinn_fit_tolerance(f->fit));
    json_number(to, "seconds", s.seconds);
    json_text(to, "end", patches_end_word(s.end));
    json_number(to, "estimated_error", s.windows > 0 ? s.estimate : NAN);
    json_number(to, "estimated_error_by_unknowns", s.by_unknowns);
    json_number(to, "done", s.done);
    json_integer(to, "attempts", s.attempts);
    json_integer(to, "windows", s.windows);
    json_integer(to, "most_patches", s.most_patches);
    json_integer(to, "parameters", (int64_t)s.parameters);
    json_integer(to, "steps", s.steps);
    json_open(to, "unknowns", '[');
    for (int i = 0; i < s.unknowns; i++) {
        estimate_open(to, m->own_unknowns[i].name, s.unknown[i], s.deviation[i]);
        json_close(to, '}');
    }
    json_close(to, ']');
    if (f->difference.field) {
        json_open(to, "reference", '{');
        json_text(to, "name", f->reference);
        json_integer(to, "points", (int64_t)f->difference.count);
        json_text(to, "field", f->difference.field);
        json_number(to, "relative_l2", f->difference.relative);
        json_number(to, "largest", f->difference.largest);
        json_close(to, '}');
    } else {
        json_null(to, "reference");
    }
}

/* ---- work ------------------------------------------------------------------------------------ */

/* What can be wrong is found before the work. */
static ad_status prepare(fitting *f, ad_error *error)
{
    ad_status status = f->out ? table_check_path(f->out, error) : AD_OK;
    status = status == AD_OK ? json_check_path(f->json, error) : status;
    status = status == AD_OK && f->save ? file_bytes_check(f->save, error) : status;
    if (status == AD_OK) {
        status = config_equations_read(f->file, NULL, f->overrides.count, f->overrides.texts,
                                       &f->read, error);
    }
    if (status == AD_OK && f->points) {
        table_file *table = NULL;
        status = table_read(f->points, TABLE_FINITE, &table, error);
        status = status == AD_OK
                     ? equation_places_read(&f->at, f->read->model, table, f->points, error)
                     : status;
        table_free(table);
    } else if (status == AD_OK) {
        status = equation_places_grid(&f->at, f->read->model, f->grid, error);
    }
    return status == AD_OK && f->reference
               ? equation_reference_open(f->reference, f->read->model, &f->known, error)
               : status;
}

/* Tables have errors of their own, of which nothing is known: as of a good solver. */
static const double table_error = 1e-10;

/* Of a difference that no estimate of its own explains. */
static void judge(fitting *f)
{
    const patches_summary s = cpinn_fit_summary(f->fit);
    if (f->difference.field && !(f->difference.relative <= 10 * s.estimate + table_error)) {
        verdict_add(&f->verdict, VERDICT_ESTIMATES_CONTRADICT,
                    "the solution is %.1e off %s, more than 10 times the estimated error %.1e; one "
                    "of the two is wrong",
                    f->difference.relative, f->reference, s.estimate);
    }
}

static ad_status run(fitting *f, ad_error *error)
{
    ad_status status = prepare(f, error);
    if (status != AD_OK) {
        return status;
    }
    const cpinn_fit_options options = {.tolerance =
                                           f->tolerance > 0 ? f->tolerance : f->read->tolerance,
                                       .seconds = f->seconds > 0 ? f->seconds : f->read->seconds,
                                       .threads = f->threads,
                                       .progress = progress,
                                       .context = f};
    signals_catch();
    f->live = isatty(STDERR_FILENO);
    f->gap = 1;
    status = cpinn_fit_equations(f->read->equations, &options, &f->fit, error);
    clear_line(f);
    if (status != AD_OK) {
        return status;
    }
    f->verdict = *cpinn_fit_verdict(f->fit);
    f->verdict.signal = signals_caught();
    if (f->reference) {
        status = equation_reference_compare(&f->known, f->fit, &f->difference, error);
        judge(f);
    }
    if (status == AD_OK && !f->quiet) {
        print(f);
    }
    if (status == AD_OK && f->out) {
        status = equation_places_write(&f->at, f->fit, f->out, error);
    }
    return status == AD_OK && f->save ? cpinn_fit_save(f->fit, f->save, error) : status;
}

static void fitting_free(fitting *f)
{
    cpinn_fit_free(f->fit);
    equation_places_free(&f->at);
    equation_reference_free(&f->known);
    config_equations_free(f->read);
}

int main(int argc, char **argv)
{
    fitting f = {.file = NULL};
    const cli_option list[] = {
        CLI_SET(&f.overrides),
        {"--tolerance", "X", CLI_NUMBER, &f.tolerance, 1e-15, 1},
        CLI_SECONDS(&f.seconds),
        CLI_THREADS(&f.threads),
        CLI_GRID(&f.grid),
        CLI_POINTS(&f.points),
        CLI_OUT(&f.out),
        {"--reference", "FILE", CLI_TEXT, &f.reference, 0, 0},
        {"--save", "FILE.h5", CLI_TEXT, &f.save, 0, 0},
        CLI_JSON(&f.json),
        CLI_QUIET(&f.quiet),
    };
    const cli_program about = {program, "FILE.yaml", help_fit, verdict_help, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &f.file);
    if (status != CLI_RUN) {
        return status;
    }
    if ((f.grid || f.points) && !f.out) {
        return cli_fail(program, "%s is given; allowed: with --out",
                        f.grid ? "--grid" : "--points");
    }
    if (f.grid && f.points) {
        return cli_fail(program, "--grid and --points are given; allowed: one of them");
    }
    f.quiet = f.quiet || json_is_printed(f.json);
    f.speaks = !f.quiet;
    ad_error error = {.message = ""};
    const ad_status ran = run(&f, &error);
    const conclusion end = {.program = program,
                            .quiet = f.quiet,
                            .json = f.json,
                            .name = f.read ? f.read->name : NULL,
                            .tell = tell,
                            .of = &f,
                            .verdict = &f.verdict};
    status = conclude(&end, ran, &error);
    fitting_free(&f);
    return status;
}
