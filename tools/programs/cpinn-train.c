/* cpinn-train: train a network on a scene; see --help. */
#include "autodiff/dense.h"
#include "physics/numerics/clock.h"
#include "tools/prepare/config_session.h"
#include "tools/programs/cli.h"
#include "tools/programs/conclude.h"
#include "tools/programs/explain.h"
#include "tools/programs/form.h"
#include "tools/programs/help.h"
#include "tools/programs/launcher.h"
#include "tools/programs/program_ranks.h"
#include "tools/programs/progress.h"
#include "tools/programs/scene_line.h"
#include "tools/programs/signals.h"
#include "tools/programs/train_ranks.h"
#include "tools/programs/train_surrogate.h"
#include "tools/programs/unknowns.h"
#include "tools/train/measured_terms.h"
#include "tools/train/report.h"
#include "tools/train/trainer_unknowns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-train";

static void more_help(FILE *file)
{
    verdict_help(file);
    fprintf(file, "\nKeys of CONFIG.yaml\n\n");
    config_help(file);
}

typedef struct options {
    const char *config, *out, *json;
    cli_list overrides;
    int threads;
    const char *explain; /* NULL: train; "": the scene; "program" */
    bool resume, print_config, quiet;
    const ad_ranks *ranks; /* NULL: this process is by itself */
} options;

/* A session with what only a program has. */
typedef struct training {
    session s;
    const options *asked;
    run_folder folder;
    progress progress;
    verdict verdict;
    unknowns unknown;     /* of a scene that has some, once it is trained */
    double began, waited; /* s, by the clock; by this rank for others before that */
} training;

static ad_status name_folder(const options *o, const char *name, run_folder *folder,
                             ad_error *error)
{
    char path[3900];
    snprintf(path, sizeof path, "runs/%s", name);
    return run_name(folder, o->out ? o->out : path, error);
}

static void announce_reference(training *t)
{
    if (reference_left_out(t->s.known)) {
        progress_say(
            &t->progress,
            "reference %s: %zu points lie outside the scene, or lack a number, and are left out",
            reference_name(t->s.known), reference_left_out(t->s.known));
    }
    if (*reference_account(t->s.known)) {
        progress_say(&t->progress, "reference: %s", reference_account(t->s.known));
    }
    if (*reference_remark(t->s.known)) {
        progress_say(&t->progress, "reference: %s", reference_remark(t->s.known));
    }
}

static void announce_measurements(training *t)
{
    const size_t missing = t->s.e->measured ? measured_fields_missing(t->s.e->measured) : 0;
    if (missing > 0) {
        progress_say(&t->progress, "data: %zu number%s missing, and left out", missing,
                     missing == 1 ? " is" : "s are");
    }
}

static void announce(training *t)
{
    const fit *f = trainer_fit(t->s.trainer);
    const trainer_info *info = trainer_inspect(t->s.trainer);
    char ranks[32] = "";
    if (t->asked->ranks) {
        snprintf(ranks, sizeof ranks, "%d ranks of ", t->asked->ranks->count);
    }
    progress_say(&t->progress, "%s: %zu parameters, %.0f points, %s%d thread%s -> %s",
                 t->s.e->settings->name, t->s.e->count, info->points, ranks,
                 ad_pool_threads(t->s.e->pool), ad_pool_threads(t->s.e->pool) == 1 ? "" : "s",
                 t->folder.path);
    if (t->asked->resume) {
        progress_say(&t->progress, "resumed at step %lld, %.1f s into the run",
                     (long long)f->at.step, fit_seconds(f));
    }
    if (*info->kernels) {
        progress_say(
            &t->progress,
            "OpenBLAS' kernels are those of %s here, of %s before: last digits differ from "
            "those of a run that never stopped; OPENBLAS_CORETYPE chooses them",
            ad_dense_kernels(), info->kernels);
    }
    if (f->state == FIT_OVER) {
        progress_say(&t->progress, "nothing is left to do: every stage has ended");
    }
    if (t->s.known) {
        announce_reference(t);
    }
    announce_measurements(t);
}

static void announce_members(training *t)
{
    if (t->s.e->targets) {
        const targets_account drawn = targets_drawn(t->s.e->targets);
        const size_t solved = drawn.ends[SOLVE_MEMBER_SOLVED];
        char why[TARGETS_TEXT];
        targets_unsolved_text(t->s.e->targets, why);
        progress_say(&t->progress, "%zu members solved in %.3g s, and %zu not%s", solved,
                     drawn.seconds, drawn.drawn - solved, why);
    }
}

/* At the beginning of a stage. */
static void announce_stage(training *t)
{
    char text[160];
    trainer_describe(t->s.trainer, text);
    if (text[0]) {
        progress_say(&t->progress, "stage %d: %s", trainer_fit(t->s.trainer)->at.stage + 1, text);
    }
}

/* What training has found of the scene. */
static void find_unknowns(training *t)
{
    ad_error error;
    const scene *open = t->s.e->scene;
    if (open->unknown_count == 0) {
        return;
    }
    t->unknown.open = open;
    if (trainer_unknowns(t->s.trainer, &t->unknown.found, &error) == AD_OK) {
        identified_verdict(&t->unknown.found, open, &t->verdict);
    } else {
        verdict_add_error(&t->verdict, &error);
    }
}

static void announce_waiting(training *t)
{
    const ad_ranks *ranks = t->asked->ranks;
    const double part = (ranks_waited() - t->waited) / (clock_seconds(CLOCK_MONOTONIC) - t->began),
                 most = ad_ranks_largest(ranks, part), least = -ad_ranks_largest(ranks, -part);
    if (ranks) {
        progress_say(&t->progress,
                     "of this run's time ranks waited %.1f to %.1f %% for others and their numbers",
                     100 * least, 100 * most);
    }
}

static void finish(training *t)
{
    trainer_verdict(t->s.trainer, &t->verdict);
    find_unknowns(t);
    if (t->progress.quiet) {
        return;
    }
    const fit *f = trainer_fit(t->s.trainer);
    const trainer_info *info = trainer_inspect(t->s.trainer);
    progress_say(&t->progress, "done: %lld steps in %.2f s, loss %.3e, held-out %.3e",
                 (long long)f->at.step, fit_seconds(f), f->loss, f->held_out);
    announce_waiting(t);
    if (t->s.e->targets) {
        progress_members(&t->progress, &info->members, scene_length(t->s.e->scene));
    }
    const double mm = 1e3 * scene_length(t->s.e->scene);
    if (info->fresh.compared) {
        progress_say(&t->progress,
                     "largest error of a shape, over %d fresh members solved classically: median "
                     "%.2g mm, 95 %% below %.2g mm, worst %.2g mm",
                     info->fresh.compared, mm * info->fresh.median, mm * info->fresh.most,
                     mm * info->fresh.worst);
    }
    double estimate = trainer_estimate(t->s.trainer);
    if (isfinite(estimate)) {
        progress_say(&t->progress, "estimated error %.1e of the %s%s", estimate,
                     scene_is_beam(t->s.e->scene) ? "deflection" : "length",
                     !t->s.e->modes                                ? ""
                     : 2 * info->motion.in_time > info->motion.all ? ", most by degree in time"
                                                                   : ", most by modes");
    }
    if (isfinite(info->balance.loads)) {
        progress_say(&t->progress, "loads out of balance by %.1e", info->balance.loads);
    }
    if (!isnan(info->balance.energy)) {
        progress_say(&t->progress, "energy out of balance by %.1e of the largest, momentum by %.1e",
                     info->balance.energy, info->balance.momentum);
    }
    problem_compilations compiled = problem_compiled(t->s.problem);
    progress_say(&t->progress,
                 "of which the equations took %.3f s to be recorded and compiled (%d)",
                 compiled.seconds, compiled.count);
    if (t->unknown.found.count > 0) {
        unknowns_print(&t->unknown);
    }
    verdict_print(stdout, "", &t->verdict);
    progress_error_table(stdout, &trainer_fit(t->s.trainer)->rows, t->s.e->scene->windows);
    printf("\n  %s\n  %s\n  %s\n\n  cpinn-eval %s\n", t->folder.checkpoint, t->folder.history,
           t->folder.config, t->folder.path);
}

/* As one word of a shell. */
static void print_word(const char *text)
{
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"
                                "_-+=./,:@%";
    if (*text && text[strspn(text, plain)] == '\0') {
        printf(" %s", text);
        return;
    }
    printf(" '");
    for (; *text; text++) {
        fputs(*text == '\'' ? "'\\''" : (const char[]){*text, '\0'}, stdout);
    }
    putchar('\'');
}

/* The signal that has stopped training: some rank has caught it. */
static int signal_of(const training *t)
{
    return (int)ad_ranks_largest(t->asked->ranks, signals_caught());
}

/* After a signal: the state is that after a whole step. */
static void interrupted(training *t)
{
    const options *o = t->asked;
    trainer_verdict(t->s.trainer, &t->verdict);
    t->verdict.signal = signal_of(t);
    verdict_add(&t->verdict, VERDICT_SIGNAL, "stopped at step %lld and saved; --resume goes on",
                (long long)t->s.saved_step);
    progress_say(&t->progress, "stopped at step %lld and saved; continue with",
                 (long long)t->s.saved_step);
    if (!t->progress.quiet) {
        printf("  cpinn-train");
        print_word(o->config);
        for (int i = 0; i < o->overrides.count; i++) {
            printf(" --set");
            print_word(o->overrides.texts[i]);
        }
        printf(" --out");
        print_word(t->folder.path);
        printf(" --resume\n");
    }
}

static void say_ended(training *t)
{
    const trainer_info *info = trainer_inspect(t->s.trainer);
    const fit *f = trainer_fit(t->s.trainer);
    const fit_place *before = &f->before, *now = &f->at;
    char window[32] = "";
    if (now->stage_step > 0) {
        return;
    }
    if (before->part < 1 || now->part < 1) {
        progress_say(&t->progress, "load factor %.4g %s at step %lld: %s", before->part,
                     info->solved ? "solved" : "not solved", (long long)now->step, f->ended);
    }
    if (now->stage == before->stage && now->window == before->window) {
        return;
    }
    int windows = t->s.e->scene->windows;
    if (windows > 1) {
        snprintf(window, sizeof window, "window %d/%d ", before->window + 1, windows);
    }
    progress_say(&t->progress, "%sstage %d ended at step %lld: %s%s%s", window, before->stage + 1,
                 (long long)now->step, f->ended, *info->account ? "; " : "", info->account);
    if (now->window == 0) { /* later windows repeat the stages of the first */
        announce_stage(t);
    }
}

static bool stepped(void *context)
{
    training *t = context;
    say_ended(t);
    progress_step(&t->progress);
    return !signals_caught();
}

static bool is_asked_to_stop(void *context)
{
    (void)context;
    return signals_caught() != 0;
}

static bool goes_on(void *context)
{
    (void)context;
    return !signals_caught();
}

static ad_status prepare(training *t, config *settings, ad_error *error)
{
    settings->settings.ranks = t->asked->ranks;
    return config_session_prepare(settings, t->asked->threads, &t->s, error);
}

static void start_progress(training *t)
{
    t->progress = progress_start(stdout, t->asked->quiet, trainer_fit(t->s.trainer));
}

/* Train a motion in the strain form in memory, anew with more modes or a larger degree as long as
 * its error is estimated above the tolerance and falls. A signal stops it. */
static ad_status grow(training *t, ad_error *error)
{
    const double enough = 0.7; /* of the estimate before */
    double before = INFINITY;
    signals_catch();
    while (t->s.e->modes && !isnan(t->s.e->settings->tolerance)) {
        int modes[4], degree;
        char texts[2][64];
        config *settings = NULL;
        cli_list given = t->asked->overrides;
        trainer_watch_stop(t->s.trainer, is_asked_to_stop, NULL);
        start_progress(t);
        ad_status status = session_train(&t->s, goes_on, NULL, error);
        const double estimate = trainer_estimate(t->s.trainer);
        const int *now = t->s.e->settings->modes;
        t->verdict.signal = status == AD_OK ? signal_of(t) : 0;
        if (status != AD_OK || t->verdict.signal) {
            return status;
        }
        progress_say(&t->progress,
                     "network.modes [%d, %d, %d, %d], degree %d: estimated error "
                     "%.1e of the length",
                     now[0], now[1], now[2], now[3], t->s.e->settings->network.degree, estimate);
        if (!(estimate < enough * before) || given.count + 2 > CLI_LIST_MAX ||
            !trainer_needs(t->s.trainer, modes, &degree)) {
            return AD_OK;
        }
        const double spent = fit_seconds(trainer_fit(t->s.trainer));
        before = estimate;
        snprintf(texts[0], sizeof texts[0], "network.modes=[%d, %d, %d, %d]", modes[0], modes[1],
                 modes[2], modes[3]);
        snprintf(texts[1], sizeof texts[1], "network.polynomial.degree=%d", degree);
        for (int i = 0; i < 2; i++) {
            given.texts[given.count++] = texts[i];
        }
        status = prepare_read(t->asked->config, NULL, given.count, given.texts, &settings, error);
        session_free(&t->s);
        t->s = (session){.e = NULL};
        status = status == AD_OK ? prepare(t, settings, error) : status;
        t->s.prepared += spent; /* all attempts count */
        status = status == AD_OK ? session_start(&t->s, error) : status;
        if (status != AD_OK) {
            return status;
        }
    }
    return AD_OK;
}

static ad_status train(training *t, ad_error *error)
{
    signals_catch();
    trainer_watch_stop(t->s.trainer, is_asked_to_stop, NULL);
    start_progress(t);
    announce(t);
    announce_members(t);
    announce_stage(t);
    t->began = clock_seconds(CLOCK_MONOTONIC);
    t->waited = ranks_waited();
    ad_status status = session_train(&t->s, stepped, t, error);
    const fit_state state = trainer_fit(t->s.trainer)->state;
    if (status == AD_OK && state == FIT_RUNNING) {
        interrupted(t);
    } else if (status == AD_OK) {
        finish(t);
    } else if (state == FIT_NOT_FINITE) {
        progress_say(&t->progress, "stopped; the checkpoint of step %lld is kept: %s",
                     (long long)t->s.saved_step, t->folder.checkpoint);
    }
    return status;
}

/* What there is of a run, also of one that was refused or has stopped. */
static void tell(const void *of, json *to)
{
    const training *t = of;
    unknowns_json(&t->unknown, to);
    if (t->s.trainer) {
        const fit *f = trainer_fit(t->s.trainer);
        const trainer_info *info = trainer_inspect(t->s.trainer);
        json_integer(to, "step", f->at.step);
        json_integer(to, "stage", f->at.stage);
        json_integer(to, "stages", t->s.e->settings->stage_count);
        json_integer(to, "window", f->at.window);
        json_integer(to, "windows", t->s.e->scene->windows);
        json_number(to, "training_seconds", fit_seconds(f));
        char form[FORM_TEXT];
        form_of_network(t->s.e, form);
        json_text(to, "form", form);
        json_integer(to, "unknowns", form_unknowns(t->s.e));
        json_integer(to, "equations", form_equations(t->s.e));
        json_integer(to, "parameters", (int64_t)t->s.e->count);
        json_number(to, "points", info->points);
        json_integer(to, "threads", ad_pool_threads(t->s.e->pool));
        json_integer(to, "compiled_programs", info->fused.fused);
        json_number(to, "loss", f->loss);
        json_number(to, "held_out", f->held_out);
        json_number(to, "estimate", trainer_estimate(t->s.trainer));
        bool is_done = f->state == FIT_OVER;
        json_number(to, "loads_out_of_balance",
                    is_done ? info->balance.loads : experiment_balance(t->s.e, NULL).loads);
        json_number(to, "energy_out_of_balance", info->balance.energy);
        json_number(to, "momentum_out_of_balance", info->balance.momentum);
        report_reference(to, t->s.known, &info->errors);
        if (t->s.e->targets) {
            report_members(to, &info->members, scene_length(t->s.e->scene));
        } else if (info->fresh.compared) {
            report_fresh(to, &info->fresh, scene_length(t->s.e->scene));
        }
        json_text(to, "checkpoint", t->folder.checkpoint);
        json_text(to, "history", t->folder.history);
        json_text(to, "config", t->folder.config);
    }
}

static ad_status go(training *t, config *settings, ad_error *error)
{
    ad_status status = prepare(t, settings, error);
    if (status == AD_OK && t->asked->explain && *t->asked->explain) {
        return explain_programs(stdout, t->s.e, t->s.problem, error);
    }
    if (status == AD_OK && t->asked->explain) {
        explain_print(stdout, t->s.e, t->s.problem, t->s.known);
        return AD_OK;
    }
    status = status == AD_OK ? session_start(&t->s, error) : status;
    if (status == AD_OK) {
        status = name_folder(t->asked, t->s.e->settings->name, &t->folder, error);
    }
    if (status == AD_OK && !t->asked->resume) {
        status = run_check_new(&t->folder, error);
    }
    status = status == AD_OK ? grow(t, error) : status;
    if (status == AD_OK && t->verdict.signal) {
        verdict_add(&t->verdict, VERDICT_SIGNAL,
                    "stopped before modes and degree were found; nothing is saved");
        verdict_print(stderr, "cpinn-train: ", &t->verdict);
        return AD_OK;
    }
    if (status == AD_OK) {
        status = session_begin(&t->s, &t->folder, t->asked->resume, error);
    }
    return status == AD_OK ? train(t, error) : status;
}

/* Ranks with other scenes would train a mixture of them. */
static ad_status compare_ranks(const options *o, const config *settings, ad_status status,
                               ad_error *error)
{
    run_folder folder = {.checkpoint = ""};
    if (settings && o->resume) {
        name_folder(o, settings->settings.name, &folder, NULL);
    }
    return train_ranks_compare(o->ranks, settings, *folder.checkpoint ? folder.checkpoint : NULL,
                               status, error);
}

static int run(const options *o)
{
    training t = {.asked = o};
    config *settings = NULL;
    ad_error error = {AD_OK, ""};
    ad_status status = json_check_path(o->json, &error);
    if (status != AD_OK) {
        compare_ranks(o, NULL, status, &error);
        return cli_fail_error(program, &error);
    }
    status =
        config_read(o->config, NULL, o->overrides.count, o->overrides.texts, &settings, &error);
    status = status == AD_OK ? prepare_choices(settings, &error) : status;
    status = status == AD_OK ? prepare_training(settings, &error) : status;
    if (status == AD_OK && !o->print_config) {
        status = prepare_start(settings, &error);
    }
    status = compare_ranks(o, settings, status, &error);
    if (status != AD_OK) {
        config_free(settings);
    }
    if (status == AD_OK && o->print_config) {
        int result = config_write(settings, stdout, true) == AD_OK ? 0 : 1;
        config_free(settings);
        return result;
    }
    const bool is_robot = status == AD_OK && surrogate_is_given(&settings->surrogate);
    if (status == AD_OK && !o->quiet && (is_robot || !o->explain)) { /* explain_print has it */
        scene_line_implausible(&settings->scene);
    }
    if (is_robot) {
        const train_surrogate_options of = {
            program, o->out, o->json, o->threads, o->resume, o->quiet, o->explain != NULL,
            o->ranks};
        return train_surrogate(&of, settings);
    }
    if (status == AD_OK) {
        status = go(&t, settings, &error);
    }
    const conclusion end = {.program = program,
                            .quiet = o->quiet,
                            .json = o->explain ? NULL : o->json,
                            .name = t.s.e ? t.s.e->settings->name : NULL,
                            .tell = tell,
                            .of = &t,
                            .verdict = &t.verdict};
    const int ended = conclude(&end, status, &error);
    run_end(&t.folder);
    session_free(&t.s);
    return ended;
}

static int parse(int count, char **arguments, options *o)
{
    const cli_program about = {program, "CONFIG.yaml", help_train, more_help, NULL};
    const cli_option known[] = {
        {"--out", "DIR", CLI_TEXT, &o->out, 0, 0},
        {"--resume", NULL, CLI_FLAG, &o->resume, 0, 0},
        CLI_SET(&o->overrides),
        CLI_DATA(&o->overrides),
        CLI_THREADS(&o->threads),
        {"--print-config", NULL, CLI_FLAG, &o->print_config, 0, 0},
        {"--explain", "program|support", CLI_CHOICE, &o->explain, 0, 0},
        CLI_JSON(&o->json),
        CLI_QUIET(&o->quiet),
    };
    int result =
        cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &o->config);
    o->quiet = o->quiet || json_is_printed(o->json);
    return result;
}

/* The table of support is of all scenes, and needs none. */
static bool asks_for_support(int count, char **arguments)
{
    bool asks = false;
    for (int i = 1; i < count; i++) {
        asks = asks || strcmp(arguments[i], "--explain=support") == 0;
    }
    return asks;
}

int main(int count, char **arguments)
{
    options o = {.threads = 0};
    ad_error error;
    if (asks_for_support(count, arguments)) {
        explain_support(stdout);
        return 0;
    }
    if (ranks_begin(count, arguments, &o.ranks, &error) != AD_OK) {
        int rank;
        launcher_processes(&rank); /* one line */
        return ranks_end(program, rank > 0 ? CLI_BAD : cli_fail_error(program, &error));
    }
    int result = parse(count, arguments, &o);
    if (result == CLI_RUN) {
        o.threads = ranks_threads(o.threads);
        o.json = o.json && !ad_ranks_is_first(o.ranks) ? "-" : o.json; /* to nowhere */
        result = run(&o);
    }
    return ranks_end(program, result);
}
