/* cpinn-train: train a network on a scene; see --help. */
#include "tools/config/config_experiment.h"
#include "tools/files/file_bytes.h"
#include "tools/judge/signals.h"
#include "tools/programs/cli.h"
#include "tools/programs/explain.h"
#include "tools/programs/progress.h"
#include "tools/train/clock.h"
#include "tools/train/report.h"
#include "tools/train/run.h"

#include <string.h>

static const char program[] = "cpinn-train";

static const char summary[] =
    "Train a network until it satisfies the equations of the rod or beam that CONFIG.yaml "
    "describes.\n"
    "It goes to a folder, from which cpinn-eval reads it; the last lines say how good it is.";

static const char epilogue[] =
    "  cpinn-train configs/elastica.yaml\n"
    "  cpinn-train rod.yaml --explain\n"
    "  cpinn-train rod.yaml --set loads.tip.force[2]=-10 --out runs/heavier\n"
    "  cpinn-train rod.yaml --out runs/rod --resume\n"
    "\n"
    "Ctrl-C finishes the step at hand, saves, and says how to resume.\n"
    "\n"
    "--json writes one object: program, version, name, verdict {outcome, reason, text, "
    "exit_status,\n"
    "findings: [{reason, outcome, text}]}, step, stage, stages, window, windows, "
    "training_seconds,\n"
    "parameters, points, threads, loss, held_out, reference {name, points, left_out,\n"
    "estimated_error_over_length, position_relative_l2, position_max_over_length, "
    "tip_over_length,\n"
    "rotation_rms_rad, rotation_max_rad} or null, checkpoint, history, config. Numbers that are "
    "not\n"
    "known are null; what was not reached is not there.";

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
    bool resume, print_config, explain, quiet;
} options;

/* Everything a run is made of. */
typedef struct session {
    experiment *e;
    problem *problem;
    reference *known;
    trainer *trainer;
    run_folder folder;
    progress progress;
    double last_save;
    int64_t saved_step;
    verdict verdict;
} session;

static void session_free(session *s)
{
    run_end(&s->folder);
    trainer_free(s->trainer);
    reference_free(s->known);
    problem_free(s->problem);
    experiment_free(s->e);
}

static ad_status prepare(session *s, const options *o, config *settings, double started,
                         ad_error *error)
{
    ad_status status = config_experiment_create(settings, o->threads, &s->e, error);
    if (status == AD_OK) {
        status = experiment_problem(s->e, &s->problem, error);
    }
    double spent = wall_seconds() - started; /* the reference, which only measures, is not part */
    if (status == AD_OK) {
        status = reference_create(s->e, &s->known, error);
    }
    if (status == AD_OK && !o->explain) {
        status = trainer_create(s->e, s->problem, s->known, spent, &s->trainer, error);
    }
    return status;
}

static ad_status restore(session *s, ad_error *error)
{
    checkpoint *file;
    ad_status status = checkpoint_open(s->folder.checkpoint, &file, error);
    if (status != AD_OK) {
        return status;
    }
    status = config_check_same(&s->folder, s->e, file, error);
    if (status == AD_OK) {
        status = trainer_restore(s->trainer, file, error);
    }
    checkpoint_free(file);
    return status;
}

static ad_status save(session *s, ad_error *error)
{
    const train_settings *settings = s->e->settings;
    ad_status status =
        trainer_save(s->trainer, s->folder.checkpoint, settings->checkpoint_keep, error);
    s->last_save = wall_seconds();
    s->saved_step = trainer_inspect(s->trainer).step;
    return status;
}

static bool save_is_due(const session *s)
{
    const train_settings *settings = s->e->settings;
    return trainer_inspect(s->trainer).step % settings->checkpoint_every == 0 ||
           wall_seconds() - s->last_save > settings->checkpoint_seconds;
}

static ad_status begin(session *s, const options *o, ad_error *error)
{
    char path[3900];
    snprintf(path, sizeof path, "runs/%s", s->e->settings->name);
    ad_status status = run_name(&s->folder, o->out ? o->out : path, error);
    if (status == AD_OK) {
        status = o->resume ? restore(s, error) : run_check_new(&s->folder, error);
    }
    if (status == AD_OK && !o->resume) {
        status = run_make_folder(s->folder.path, error);
    }
    if (status == AD_OK && !o->resume) {
        status = save(s, error);
    }
    return status == AD_OK ? run_begin(&s->folder, s->e, trainer_history(s->trainer), error)
                           : status;
}

static void announce_reference(session *s)
{
    if (reference_left_out(s->known)) {
        progress_say(&s->progress,
                     "reference %s: %zu points lie outside the scene and are left out",
                     reference_name(s->known), reference_left_out(s->known));
    }
    if (*reference_account(s->known)) {
        progress_say(&s->progress, "reference: %s", reference_account(s->known));
    }
    if (*reference_remark(s->known)) {
        progress_say(&s->progress, "reference: %s", reference_remark(s->known));
    }
}

static void announce(session *s, const options *o)
{
    trainer_info info = trainer_inspect(s->trainer);
    progress_say(&s->progress, "%s: %zu parameters, %.0f points, %d thread%s -> %s",
                 s->e->settings->name, s->e->count, info.points, ad_pool_threads(s->e->pool),
                 ad_pool_threads(s->e->pool) == 1 ? "" : "s", s->folder.path);
    if (o->resume) {
        progress_say(&s->progress, "resumed at step %lld, %.1f s into the run",
                     (long long)info.step, info.seconds);
    }
    if (info.state == TRAINER_DONE) {
        progress_say(&s->progress, "nothing is left to do: every stage has ended");
    }
    if (s->known) {
        announce_reference(s);
    }
}

/* At the beginning of a stage. */
static void announce_stage(session *s)
{
    char text[160];
    trainer_describe(s->trainer, text);
    if (text[0]) {
        progress_say(&s->progress, "stage %d: %s", trainer_inspect(s->trainer).stage + 1, text);
    }
}

static void finish(session *s)
{
    trainer_verdict(s->trainer, &s->verdict);
    if (s->progress.quiet) {
        if (verdict_outcome_of(&s->verdict) == VERDICT_WARNING) {
            verdict_print(stderr, "cpinn-train: ", &s->verdict);
        }
        return;
    }
    trainer_info info = trainer_inspect(s->trainer);
    progress_say(&s->progress, "done: %lld steps in %.2f s, loss %.3e, held-out %.3e",
                 (long long)info.step, info.seconds, info.loss, info.held_out);
    problem_compilations compiled = problem_compiled(s->problem);
    progress_say(&s->progress,
                 "of which the equations took %.3f s to be recorded and compiled (%d)",
                 compiled.seconds, compiled.count);
    verdict_print(stdout, "", &s->verdict);
    progress_error_table(stdout, trainer_history(s->trainer), s->e->scene->windows);
    printf("\n  %s\n  %s\n  %s\n\n  cpinn-eval %s\n", s->folder.checkpoint, s->folder.history,
           s->folder.config, s->folder.path);
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

/* After a signal: the state is that after a whole step. */
static ad_status interrupted(session *s, const options *o, ad_error *error)
{
    ad_status status = save(s, error);
    if (status != AD_OK) {
        return status;
    }
    trainer_verdict(s->trainer, &s->verdict);
    s->verdict.signal = signals_caught();
    verdict_add(&s->verdict, VERDICT_SIGNAL, "stopped at step %lld and saved; --resume goes on",
                (long long)s->saved_step);
    progress_say(&s->progress, "stopped at step %lld and saved; continue with",
                 (long long)s->saved_step);
    if (!s->progress.quiet) {
        printf("  cpinn-train");
        print_word(o->config);
        for (int i = 0; i < o->overrides.count; i++) {
            printf(" --set");
            print_word(o->overrides.texts[i]);
        }
        printf(" --out");
        print_word(s->folder.path);
        printf(" --resume\n");
    }
    return AD_OK;
}

static void say_ended(session *s, const trainer_info *before, const trainer_info *now)
{
    char window[32] = "";
    if (now->stage_step > 0) {
        return;
    }
    if (before->part < 1 || now->part < 1) {
        progress_say(&s->progress, "load factor %.4g %s at step %lld: %s", before->part,
                     now->solved ? "solved" : "not solved", (long long)now->step, now->ended);
    }
    if (now->stage == before->stage && now->window == before->window) {
        return;
    }
    int windows = s->e->scene->windows;
    if (windows > 1) {
        snprintf(window, sizeof window, "window %d/%d ", before->window + 1, windows);
    }
    progress_say(&s->progress, "%sstage %d ended at step %lld: %s%s%s", window, before->stage + 1,
                 (long long)now->step, now->ended, *now->account ? "; " : "", now->account);
    if (now->window == 0) { /* later windows repeat the stages of the first */
        announce_stage(s);
    }
}

static ad_status train(session *s, const options *o, ad_error *error)
{
    signals_catch();
    s->last_save = wall_seconds();
    s->saved_step = trainer_inspect(s->trainer).step;
    s->progress = progress_start(stdout, o->quiet, s->trainer);
    announce(s, o);
    announce_stage(s);
    while (trainer_inspect(s->trainer).state == TRAINER_RUNNING) {
        trainer_info before = trainer_inspect(s->trainer);
        ad_status status = trainer_step(s->trainer, error);
        if (status != AD_OK) {
            if (trainer_inspect(s->trainer).state == TRAINER_NOT_FINITE) {
                progress_say(&s->progress, "stopped; the checkpoint of step %lld is kept: %s",
                             (long long)s->saved_step, s->folder.checkpoint);
            }
            return status;
        }
        trainer_info info = trainer_inspect(s->trainer);
        say_ended(s, &before, &info);
        progress_step(&s->progress, s->trainer, s->e);
        status = run_append(&s->folder, trainer_history(s->trainer), error);
        if (status == AD_OK && signals_caught()) {
            return interrupted(s, o, error);
        }
        if (status == AD_OK && (save_is_due(s) || info.state == TRAINER_DONE)) {
            status = save(s, error);
        }
        if (status != AD_OK) {
            return status;
        }
    }
    finish(s);
    return AD_OK;
}

/* What there is of a run, also of one that was refused or has stopped. */
static ad_status write_json(const session *s, const options *o, ad_error *error)
{
    json to;
    json_begin(&to);
    json_text(&to, "program", program);
    json_text(&to, "version", cli_version());
    json_text(&to, "name", s->e ? s->e->settings->name : NULL);
    report_verdict(&to, &s->verdict);
    if (s->trainer) {
        trainer_info info = trainer_inspect(s->trainer);
        json_integer(&to, "step", info.step);
        json_integer(&to, "stage", info.stage);
        json_integer(&to, "stages", s->e->settings->stage_count);
        json_integer(&to, "window", info.window);
        json_integer(&to, "windows", s->e->scene->windows);
        json_number(&to, "training_seconds", info.seconds);
        json_integer(&to, "parameters", (int64_t)s->e->count);
        json_number(&to, "points", info.points);
        json_integer(&to, "threads", ad_pool_threads(s->e->pool));
        json_number(&to, "loss", info.loss);
        json_number(&to, "held_out", info.held_out);
        report_reference(&to, s->known, &info.errors);
        json_text(&to, "checkpoint", s->folder.checkpoint);
        json_text(&to, "history", s->folder.history);
        json_text(&to, "config", s->folder.config);
    }
    return json_end(&to, o->json, error);
}

/* `error` as a verdict; before training every error but memory is one of the input. */
static void blame(session *s, const ad_error *error, bool began)
{
    verdict_reason reason = error->status == AD_NOT_FINITE           ? VERDICT_NOT_FINITE
                            : began || error->status == AD_NO_MEMORY ? VERDICT_FAILED
                                                                     : VERDICT_BAD_INPUT;
    cli_fail_error(program, error);
    verdict_add(&s->verdict, reason, "%s", error->message);
}

static int run(const options *o, double started)
{
    session s = {.e = NULL};
    config *settings;
    ad_error error = {AD_OK, ""};
    bool began = false;
    bool writes = o->json && strcmp(o->json, "-") != 0;
    ad_status status = writes ? file_bytes_check(o->json, &error) : AD_OK;
    if (status != AD_OK) {
        return cli_refuse(program, &error);
    }
    status =
        config_read(o->config, NULL, o->overrides.count, o->overrides.texts, &settings, &error);
    if (status == AD_OK && o->print_config) {
        int result = config_write(settings, stdout, true) == AD_OK ? 0 : 1;
        config_free(settings);
        return result;
    }
    if (status == AD_OK) {
        status = prepare(&s, o, settings, started, &error);
    }
    if (status == AD_OK && o->explain) {
        explain_print(stdout, s.e, s.problem, s.known);
    } else if (status == AD_OK) {
        status = begin(&s, o, &error);
        began = status == AD_OK;
        status = began ? train(&s, o, &error) : status;
    }
    if (status != AD_OK) {
        blame(&s, &error, began);
    }
    if (o->json && !o->explain && write_json(&s, o, &error) != AD_OK) {
        cli_fail_error(program, &error);
        verdict_add(&s.verdict, VERDICT_FAILED, "%s", error.message);
    }
    session_free(&s);
    return verdict_exit_status(&s.verdict);
}

static int parse(int count, char **arguments, options *o)
{
    const cli_program about = {program, "CONFIG.yaml", summary, epilogue, more_help, NULL};
    const cli_option known[] = {
        {"--out", "DIR", CLI_TEXT, &o->out, 0, 0,
         "where checkpoint.h5, history.csv and config.yaml go (runs/NAME)"},
        {"--resume", NULL, CLI_FLAG, &o->resume, 0, 0,
         "continue the run in DIR from its checkpoint, to the same bits\n"
         "as if it had never stopped"},
        {"--set", "KEY=VALUE", CLI_LIST, &o->overrides, 0, 0,
         "change one key, as in --set loads.tip.force[2]=-10;\nmay be repeated"},
        {"--threads", "N", CLI_INTEGER, &o->threads, 0, 1024,
         "default 0: one for each processor; results do not depend on it"},
        {"--print-config", NULL, CLI_FLAG, &o->print_config, 0, 0,
         "print the experiment with every default filled in, and stop"},
        {"--explain", NULL, CLI_FLAG, &o->explain, 0, 0,
         "print what the scene consists of, what about it is hard or\n"
         "implausible, what is computed and what is left out, and stop"},
        {"--json", "FILE|-", CLI_TEXT, &o->json, 0, 0,
         "write how it ended as one JSON object, see below; - is standard\n"
         "output, with nothing else on it"},
        {"--quiet", NULL, CLI_FLAG, &o->quiet, 0, 0,
         "say nothing but errors, and on stderr the verdict when it is a\nwarning"}};
    int result =
        cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &o->config);
    o->quiet = o->quiet || (o->json && strcmp(o->json, "-") == 0);
    return result;
}

int main(int count, char **arguments)
{
    double started = wall_seconds();
    options o = {.threads = 0};
    int result = parse(count, arguments, &o);
    if (result != CLI_RUN) {
        return result;
    }
    return run(&o, started);
}
