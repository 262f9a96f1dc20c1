/* cpinn-train: train a network on a scene; see --help. */
#include "tools/config/config_experiment.h"
#include "tools/judge/signals.h"
#include "tools/programs/cli.h"
#include "tools/programs/explain.h"
#include "tools/programs/progress.h"
#include "tools/train/clock.h"
#include "tools/train/run.h"

#include <string.h>

static const char program[] = "cpinn-train";

static const char summary[] =
    "Train a physics-informed network on the rod described in CONFIG.yaml.";

static const char epilogue[] =
    "Ctrl-C finishes the step at hand, saves, and says how to resume. Exit status: 0 trained, 1\n"
    "stopped by a number that is not finite or a file that cannot be written, 2 bad input, 130 or\n"
    "143 stopped by a signal.\n"
    "\n"
    "Keys of CONFIG.yaml\n";

typedef struct options {
    const char *config, *out;
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
        status = problem_create(s->e->scene, s->e->mlp, &s->e->settings->losses,
                                s->e->settings->seed, s->e->pool, &s->problem, error);
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
    char doubt[TRAINER_DOUBT], coarse[REFERENCE_DOUBT];
    if (s->progress.quiet) {
        return;
    }
    trainer_info info = trainer_inspect(s->trainer);
    progress_say(&s->progress, "done: %lld steps in %.2f s, loss %.3e, held-out %.3e",
                 (long long)info.step, info.seconds, info.loss, info.held_out);
    if (trainer_doubts(s->trainer, doubt)) {
        progress_say(&s->progress, "%s", doubt);
    }
    progress_error_table(stdout, trainer_history(s->trainer), s->e->scene->windows);
    if (s->known && reference_doubts(s->known, &info.errors, coarse)) {
        printf("    %s\n", coarse);
    }
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
static int interrupted(session *s, const options *o, ad_error *error)
{
    if (save(s, error) != AD_OK) {
        return cli_fail_training(program, error);
    }
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
    return 128 + signals_caught();
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

static int train(session *s, const options *o, ad_error *error)
{
    signals_catch();
    s->last_save = wall_seconds();
    s->saved_step = trainer_inspect(s->trainer).step;
    s->progress = progress_start(stdout, o->quiet, s->trainer);
    announce(s, o);
    announce_stage(s);
    while (trainer_inspect(s->trainer).state == TRAINER_RUNNING) {
        trainer_info before = trainer_inspect(s->trainer);
        if (trainer_step(s->trainer, error) != AD_OK) {
            if (trainer_inspect(s->trainer).state == TRAINER_NOT_FINITE) {
                progress_say(&s->progress, "stopped; the checkpoint of step %lld is kept: %s",
                             (long long)s->saved_step, s->folder.checkpoint);
            }
            return cli_fail_training(program, error);
        }
        trainer_info info = trainer_inspect(s->trainer);
        say_ended(s, &before, &info);
        progress_step(&s->progress, s->trainer, s->e);
        if (run_append(&s->folder, trainer_history(s->trainer), error) != AD_OK) {
            return cli_fail_training(program, error);
        }
        if (signals_caught()) {
            return interrupted(s, o, error);
        }
        if ((save_is_due(s) || info.state == TRAINER_DONE) && save(s, error) != AD_OK) {
            return cli_fail_training(program, error);
        }
    }
    finish(s);
    return 0;
}

static int run(const options *o, config *settings, double started)
{
    session s = {.e = NULL};
    ad_error error = {AD_OK, ""};
    int result;
    if (prepare(&s, o, settings, started, &error) != AD_OK) {
        result = cli_refuse(program, &error);
    } else if (o->explain) {
        explain_print(stdout, s.e, s.problem, s.known);
        result = 0;
    } else if (begin(&s, o, &error) != AD_OK) {
        result = cli_refuse(program, &error);
    } else {
        result = train(&s, o, &error);
    }
    session_free(&s);
    return result;
}

static int parse(int count, char **arguments, options *o)
{
    const cli_program about = {program, "CONFIG.yaml", summary, epilogue, config_help, NULL};
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
         "print what the scene consists of, what is computed and what\nis left out, and stop"},
        {"--quiet", NULL, CLI_FLAG, &o->quiet, 0, 0, "say nothing but errors"}};
    return cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &o->config);
}

int main(int count, char **arguments)
{
    double started = wall_seconds();
    options o = {.threads = 0};
    int result = parse(count, arguments, &o);
    if (result != CLI_RUN) {
        return result;
    }
    config *settings;
    ad_error error = {AD_OK, ""};
    if (config_read(o.config, NULL, o.overrides.count, o.overrides.texts, &settings, &error) !=
        AD_OK) {
        return cli_refuse(program, &error);
    }
    if (o.print_config) {
        result = config_write(settings, stdout, true) == AD_OK ? 0 : 1;
        config_free(settings);
        return result;
    }
    return run(&o, settings, started);
}
