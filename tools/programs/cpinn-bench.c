/* cpinn-bench: error against run time, by method and network; see --help. */
#include "tools/files/file_bytes.h"
#include "tools/judge/compare.h"
#include "tools/judge/gnuplot.h"
#include "tools/judge/signals.h"
#include "tools/programs/cli.h"
#include "tools/programs/help.h"
#include "tools/programs/progress.h"
#include "tools/train/run.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char program[] = "cpinn-bench";

static void print_methods(FILE *file)
{
    compare_method_help(file);
}

typedef struct options {
    cli_list configs, overrides, curves;
    const char *methods, *networks, *out, *error;
    int seeds, threads;
    double seconds;
    bool quiet;
} options;

/* What a cell is made of. */
typedef struct planned {
    int scene, method, network;
} planned;

/* Everything there is. */
typedef struct bench {
    const options *o;
    judge_measure measure;
    compare_method methods[COMPARE_METHODS_MAX];
    compare_network networks[COMPARE_NETWORKS_MAX];
    int method_count, network_count;
    compare_curves curves;
    planned *plan;       /* [cells], scene by scene; the solver has no network, and one cell */
    compare_cell *cells; /* [cells] */
    uint64_t *seeds;     /* [cells], the first of each */
    compare_results results;
    char folder[3800];
} bench;

static void say(const bench *b, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void say(const bench *b, const char *format, ...)
{
    va_list arguments;
    if (!b->o->quiet) {
        va_start(arguments, format);
        vprintf(format, arguments);
        va_end(arguments);
        fflush(stdout);
    }
}

/* ---- what to train ------------------------------------------------------------------------- */

/* The overrides of one run: the method's stages, those of the user, the network, the seed. */
typedef struct assembled {
    const char *texts[CLI_LIST_MAX + 5];
    char seed[48];
} assembled;

static compare_task task_of(const bench *b, int cell, const uint64_t *seed, assembled *texts)
{
    const compare_method *method = &b->methods[b->plan[cell].method];
    const compare_network *network = &b->networks[b->plan[cell].network];
    int n = 0;
    if (*method->override) {
        texts->texts[n++] = method->override;
    }
    for (int i = 0; i < b->o->overrides.count; i++) {
        texts->texts[n++] = b->o->overrides.texts[i];
    }
    if (*network->hidden) {
        texts->texts[n++] = network->hidden;
    }
    if (*network->features) {
        texts->texts[n++] = network->features;
    }
    if (seed) {
        snprintf(texts->seed, sizeof texts->seed, "training.seed=%llu", (unsigned long long)*seed);
        texts->texts[n++] = texts->seed;
    }
    texts->texts[n++] = "output.every=1000000000"; /* rows come by time instead */
    return (compare_task){.path = b->o->configs.texts[b->plan[cell].scene],
                          .overrides = texts->texts,
                          .override_count = n,
                          .is_solver = method->is_solver,
                          .threads = b->o->threads,
                          .seconds = b->o->seconds};
}

/* --set must not undo what tells the runs apart. */
static ad_status check_overrides(const bench *b, ad_error *error)
{
    for (int i = 0; i < b->o->overrides.count; i++) {
        const char *text = b->o->overrides.texts[i];
        for (int k = 0; k < b->method_count; k++) {
            if (strncmp(text, "training.stages=", 16) == 0 && *b->methods[k].override) {
                return ad_fail(error, AD_BAD_INPUT,
                               "--set training.stages: the stages are those of --methods; allowed: "
                               "--methods config, or a method such as fast=adam:300+lbfgs:2000");
            }
        }
        for (int k = 0; k < b->network_count; k++) {
            if (strncmp(text, "network.fourier.features", 24) == 0 && *b->networks[k].features) {
                return ad_fail(error, AD_BAD_INPUT,
                               "--set network.fourier.features: the features are those of "
                               "--networks; allowed: one of the two");
            }
        }
        if (strncmp(text, "network.hidden", 14) == 0 && b->o->networks) {
            return ad_fail(error, AD_BAD_INPUT,
                           "--set network.hidden: the layers are those of "
                           "--networks; allowed: one of the two");
        }
    }
    return AD_OK;
}

static ad_status parse_measure(bench *b, ad_error *error)
{
    for (int i = 0; i < JUDGE_MEASURES; i++) {
        if (strcmp(b->o->error, judge_measure_name((judge_measure)i)) == 0) {
            b->measure = (judge_measure)i;
            return AD_OK;
        }
    }
    return ad_fail(error, AD_BAD_INPUT, "--error %.100s: allowed: position, tip, rotation",
                   b->o->error);
}

static ad_status read_plan(bench *b, ad_error *error)
{
    char names[256];
    compare_method_names(names, sizeof names);
    ad_status status = parse_measure(b, error);
    if (status == AD_OK) {
        status = compare_methods_parse(b->o->methods ? b->o->methods : names, b->methods,
                                       &b->method_count, error);
    }
    if (status == AD_OK) {
        status = compare_networks_parse(b->o->networks, b->networks, &b->network_count, error);
    }
    if (status == AD_OK) {
        status = check_overrides(b, error);
    }
    if (status == AD_OK && b->o->curves.count > 0 && b->o->configs.count > 1) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "--curve: a curve belongs to one scene; allowed: one "
                         "CONFIG.yaml at a time");
    }
    for (int i = 0; status == AD_OK && i < b->o->curves.count; i++) {
        status = compare_curves_read(&b->curves, b->o->curves.texts[i], error);
    }
    return status;
}

static ad_status check_names(const bench *b, int cell, ad_error *error)
{
    for (int i = 0; i < cell; i++) {
        if (b->cells[i].scene != b->cells[cell].scene &&
            strcmp(b->cells[i].scene_name, b->cells[cell].scene_name) == 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: a scene called %s is there already; give it another name: in the "
                           "file",
                           b->o->configs.texts[b->cells[cell].scene], b->cells[cell].scene_name);
        }
    }
    return AD_OK;
}

static ad_status make_plan(bench *b, ad_error *error)
{
    int most = b->o->configs.count * b->method_count * b->network_count, count = 0;
    b->plan = malloc((size_t)most * sizeof *b->plan);
    for (int i = 0; b->plan && i < most; i++) {
        planned cell = {i / (b->method_count * b->network_count),
                        i / b->network_count % b->method_count, i % b->network_count};
        if (cell.network == 0 || !b->methods[cell.method].is_solver) {
            b->plan[count++] = cell;
        }
    }
    b->results.cell_count = count;
    return b->plan ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %d runs", most);
}

/* Every combination once, so that what is wrong shows before anything is trained. */
static ad_status rehearse(bench *b, ad_error *error)
{
    size_t cells = (size_t)b->results.cell_count, seeds = (size_t)b->o->seeds;
    b->cells = calloc(cells, sizeof *b->cells);
    b->seeds = calloc(cells, sizeof *b->seeds);
    b->results.runs = calloc(cells * seeds, sizeof *b->results.runs);
    if (!b->cells || !b->seeds || !b->results.runs) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu runs", cells * seeds);
    }
    b->results.measure = b->measure;
    b->results.cells = b->cells;
    for (int i = 0; i < (int)cells && !signals_caught(); i++) {
        assembled texts;
        compare_task task = task_of(b, i, NULL, &texts);
        compare_cell *cell = &b->cells[i];
        cell->scene = b->plan[i].scene;
        strcpy(cell->method, b->methods[b->plan[i].method].name);
        ad_status status = compare_rehearse(&task, b->measure, cell, &b->seeds[i], error);
        if (status == AD_OK) {
            status = check_names(b, i, error);
        }
        if (status != AD_OK) {
            return status;
        }
    }
    return AD_OK;
}

/* ---- where it goes ------------------------------------------------------------------------- */

static const char *name_of(const bench *b, int scene)
{
    int cell = 0;
    while (b->plan[cell].scene != scene) {
        cell++;
    }
    return b->cells[cell].scene_name;
}

static bool is_taken(const char *folder)
{
    static const char *const files[] = {"about.txt", "runs.csv", "summary.csv"};
    char path[4000];
    bool taken = false;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, files[i]);
        taken = taken || access(path, F_OK) == 0;
    }
    return taken;
}

/* Results are never overwritten: a folder of the user's choice must be new to them, ours gets a
 * number. */
static ad_status choose_folder(bench *b, ad_error *error)
{
    char name[1024] = "";
    if (b->o->out) {
        size_t length = strlen(b->o->out);
        if (length == 0 || length >= sizeof b->folder) {
            return ad_fail(error, AD_BAD_INPUT, "--out: a path of %zu bytes; 1 to %zu are allowed",
                           length, sizeof b->folder - 1);
        }
        strcpy(b->folder, b->o->out);
        if (is_taken(b->folder)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: there are results already; choose another folder with --out",
                           file_bytes_shown(b->folder));
        }
        return run_make_folder(b->folder, error);
    }
    for (int i = 0; i < b->o->configs.count; i++) {
        size_t length = strlen(name);
        snprintf(name + length, sizeof name - length, "%s%s", i ? "+" : "", name_of(b, i));
    }
    snprintf(b->folder, sizeof b->folder, "bench/%.200s", name);
    for (int i = 2; is_taken(b->folder); i++) {
        snprintf(b->folder, sizeof b->folder, "bench/%.200s-%d", name, i);
    }
    return run_make_folder(b->folder, error);
}

/* ---- training ------------------------------------------------------------------------------ */

static void report(const bench *b, const compare_run *run, int number, int total)
{
    const compare_cell *cell = &b->cells[run->cell];
    verdict_reason reason = verdict_worst(&run->verdict);
    bool warned = verdict_outcome_of(&run->verdict) == VERDICT_WARNING;
    say(b, "[%d/%d] %s %s %s seed %llu: ", number, total, cell->scene_name, cell->method,
        cell->network, (unsigned long long)run->seed);
    if (run->count > 0) {
        say(b, "error %.2e, ", run->rows[run->count - 1].errors[b->measure]);
    }
    say(b, "%.2f s, %lld steps, ", run->seconds, (long long)run->steps);
    if (compare_failed(run)) {
        say(b, "failed: %s\n", verdict_text(&run->verdict));
    } else {
        say(b, "%s%s%s\n",
            reason == VERDICT_SIGNAL       ? "stopped"
            : reason == VERDICT_TIME_LIMIT ? "time is up"
                                           : "every stage ended",
            warned ? "; warning: " : "", warned ? verdict_reason_name(reason) : "");
    }
}

/* The live line of a terminal; `context` is a progress that may be before its beginning. */
static ad_status show(void *context, session *s, bool is_last, ad_error *error)
{
    progress *live = context;
    (void)error;
    if (!live->file) {
        double limit = live->limit;
        *live = progress_start(stdout, live->quiet, trainer_fit(s->trainer), NULL);
        live->limit = limit;
    }
    if (!is_last && live->live) {
        progress_step(live);
    }
    return AD_OK;
}

static ad_status do_run(bench *b, int cell, uint64_t seed, ad_error *error)
{
    assembled texts;
    compare_task task = task_of(b, cell, &seed, &texts);
    compare_run *run = &b->results.runs[b->results.run_count];
    progress live = {.quiet = b->o->quiet, .limit = b->o->seconds};
    *run = (compare_run){.cell = cell, .seed = seed};
    task.step = b->o->quiet ? NULL : show;
    task.context = &live;
    ad_status status = compare_do(&task, b->measure, run, error);
    progress_clear(&live);
    b->results.run_count++;
    if (status == AD_OK) {
        report(b, run, b->results.run_count, b->results.cell_count * b->o->seeds);
    }
    return status;
}

/* Seeds outermost, so that what else the machine does is spread over the methods, and what there
 * is after Ctrl-C compares. */
static ad_status do_all(bench *b, ad_error *error)
{
    const int cells = b->results.cell_count, count = cells * b->o->seeds;
    ad_status status = AD_OK;
    for (int i = 0; i < count && status == AD_OK && !signals_caught(); i++) {
        status = do_run(b, i % cells, b->seeds[i % cells] + (uint64_t)(i / cells), error);
    }
    return status;
}

/* ---- results ------------------------------------------------------------------------------- */

static void print_about(FILE *file, const bench *b)
{
    const options *o = b->o;
    fprintf(file, "%s %s\n\nscenes:\n", program, cli_version());
    for (int i = 0; i < o->configs.count; i++) {
        fprintf(file, "  %s\n", o->configs.texts[i]);
    }
    fprintf(file, "methods:\n");
    for (int i = 0; i < b->method_count; i++) {
        fprintf(file, "  %s = %s\n", b->methods[i].name,
                *b->methods[i].stages     ? b->methods[i].stages
                : b->methods[i].is_solver ? "classical, with more and more nodes"
                                          : "the stages of the config");
    }
    fprintf(file, "networks: %s\n", o->networks ? o->networks : "of the configs");
    for (int i = 0; i < o->overrides.count; i++) {
        fprintf(file, "%s  %s\n", i ? "" : "set:\n", o->overrides.texts[i]);
    }
    for (int i = 0; i < o->curves.count; i++) {
        fprintf(file, "%s  %s\n", i ? "" : "curves:\n", o->curves.texts[i]);
    }
    fprintf(file,
            "seeds: %d\nthreads: %d%s\nlimit: %g s of training for each run\nerror: %s\n"
            "runs: %d of %d\n",
            o->seeds, o->threads, o->threads ? "" : " (one for each processor)", o->seconds,
            judge_measure_text(b->measure), b->results.run_count, b->results.cell_count * o->seeds);
}

static ad_status write_about(const bench *b, ad_error *error)
{
    char *text = NULL, path[4096];
    size_t size = 0;
    snprintf(path, sizeof path, "%s/about.txt", b->folder);
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %s", path);
    }
    print_about(file, b);
    ad_status status = fclose(file) == 0
                           ? file_bytes_write(path, text, size, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %s", path);
    free(text);
    return status;
}

/* The line under the title; after a signal there are fewer seeds than asked for. */
static void write_note(const bench *b, char note[160])
{
    long threads = b->o->threads ? b->o->threads : sysconf(_SC_NPROCESSORS_ONLN);
    int cells = b->results.cell_count, runs = b->results.run_count;
    int seeds = (runs + cells - 1) / cells;
    const char *plural = threads == 1 ? "" : "s";
    if (seeds > 1) {
        snprintf(note, 160, "median of %s%d seeds, shaded from the best to the worst; %ld thread%s",
                 runs % cells ? "up to " : "", seeds, threads, plural);
    } else {
        snprintf(note, 160, "one seed; %ld thread%s", threads, plural);
    }
}

/* A picture for each scene. Without gnuplot there is none, which is a remark and no failure. */
static ad_status draw(const bench *b, ad_error *error)
{
    char note[160];
    bool drawn = true;
    write_note(b, note);
    for (int i = 0; i < b->o->configs.count; i++) {
        ad_status status = compare_plot_write(&b->results, i, &b->curves, note, b->folder, error);
        if (status != AD_OK) {
            return status;
        }
        ad_error why;
        if (drawn && gnuplot_draw(name_of(b, i), b->folder, &why) != AD_OK) {
            cli_warn(program, "%s", why.message);
            drawn = false; /* said once */
        }
    }
    say(b, "\n  %s/\n  %s/summary.csv, runs.csv, curves.csv, and each as .h5\n", b->folder,
        b->folder);
    for (int i = 0; drawn && i < b->o->configs.count; i++) {
        const char *name = name_of(b, i);
        say(b, "  %s/%s.png, %s.svg, %s.gp\n", b->folder, name, name, name);
    }
    return AD_OK;
}

/* What there is, also after a signal or a run that went wrong. */
static ad_status finish(const bench *b, ad_error *error)
{
    if (!b->o->quiet) {
        compare_print(stdout, &b->results);
    }
    ad_status status = compare_write(&b->results, b->folder, error);
    if (status == AD_OK) {
        status = write_about(b, error);
    }
    return status == AD_OK ? draw(b, error) : status;
}

static ad_status prepare(bench *b, ad_error *error)
{
    ad_status status = read_plan(b, error);
    status = status == AD_OK ? make_plan(b, error) : status;
    status = status == AD_OK ? rehearse(b, error) : status;
    return status == AD_OK && !signals_caught() ? choose_folder(b, error) : status;
}

static int run(bench *b)
{
    ad_error error = {AD_OK, ""};
    ad_status status = prepare(b, &error);
    if (status != AD_OK || signals_caught()) {
        return status != AD_OK ? cli_fail_error(program, &error) : 128 + signals_caught();
    }
    say(b, "%d runs of at most %.3g s of training each -> %s\n",
        b->results.cell_count * b->o->seeds, b->o->seconds, b->folder);
    status = do_all(b, &error);
    int result = status == AD_OK ? 0 : cli_fail_error(program, &error);
    if (finish(b, &error) != AD_OK) {
        return cli_fail_error(program, &error);
    }
    return signals_caught() ? 128 + signals_caught() : result;
}

static int parse(int count, char **arguments, options *o)
{
    const char *last;
    const cli_program about = {program, "CONFIG.yaml", help_bench, print_methods, &o->configs};
    const cli_option known[] = {{"--methods", "LIST", CLI_TEXT, &o->methods, 0, 0},
                                {"--networks", "LIST", CLI_TEXT, &o->networks, 0, 0},
                                {"--seeds", "N", CLI_INTEGER, &o->seeds, 1, COMPARE_SEEDS_MAX},
                                CLI_SECONDS(&o->seconds),
                                {"--error", "KIND", CLI_TEXT, &o->error, 0, 0},
                                {"--curve", "[NAME=]FILE", CLI_LIST, &o->curves, 0, 0},
                                CLI_SET(&o->overrides),
                                CLI_THREADS(&o->threads),
                                {"--out", "DIR", CLI_TEXT, &o->out, 0, 0},
                                CLI_QUIET(&o->quiet)};
    return cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &last);
}

static void bench_free(bench *b)
{
    for (int i = 0; i < b->results.run_count; i++) {
        compare_run_free(&b->results.runs[i]);
    }
    compare_curves_free(&b->curves);
    free(b->results.runs);
    free(b->plan);
    free(b->cells);
    free(b->seeds);
    free(b);
}

int main(int count, char **arguments)
{
    options o = {.seeds = 3, .seconds = 10, .error = "position"};
    int result = parse(count, arguments, &o);
    if (result != CLI_RUN) {
        return result;
    }
    bench *b = calloc(1, sizeof *b);
    if (!b) {
        return cli_fail(program, "out of memory"), 1;
    }
    b->o = &o;
    signals_catch();
    result = run(b);
    bench_free(b);
    return result;
}
