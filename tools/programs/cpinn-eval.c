/* cpinn-eval: evaluate a trained network; see --help. */
#include "physics/numerics/clock.h"
#include "tools/files/shapes_vtk.h"
#include "tools/prepare/config_experiment.h"
#include "tools/programs/cli.h"
#include "tools/programs/eval_family.h"
#include "tools/programs/eval_rollouts.h"
#include "tools/programs/help.h"
#include "tools/programs/launcher.h"
#include "tools/programs/program_ranks.h"
#include "tools/programs/samples.h"
#include "tools/programs/solution_print.h"
#include "tools/train/learnt_balance.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "cpinn-eval";

typedef struct options {
    const char *checkpoint, *out;
    samples_asked where;
    int threads;
    const char *json; /* file, or - */
    bool quiet;
    cli_list overrides;
    eval_family_options family;
    eval_rollouts_options rollouts;
    const ad_ranks *ranks; /* NULL: this process is by itself */
} options;

/* How far training has come, from "training/..."; -1 or NaN where the checkpoint does not say. */
typedef struct progress {
    int64_t step, stage;
    double seconds;
} progress;

typedef struct evaluation {
    options asked;
    experiment *e;
    double member[SCENE_PARAMETERS_MAX]; /* of a family, asked for or the middle one */
    checkpoint *file;
    reference *known;
    field *field; /* NULL: of a family that is answered with errors */
    eval_family family;
    samples samples; /* none without --out */
    samples tip;     /* s = length at the last time that is trained */
    progress progress;
    bool is_judged;
    verdict verdict; /* of training, where it is judged */
    reference_errors errors;
    double estimate;        /* of the error of the position over the length */
    ad_error unknown;       /* why it is not known */
    learnt_balance balance; /* in motion to the end of what is trained */
} evaluation;

static void evaluation_free(evaluation *evaluation)
{
    eval_family_free(&evaluation->family);
    samples_free(&evaluation->samples);
    samples_free(&evaluation->tip);
    field_free(evaluation->field);
    reference_free(evaluation->known);
    checkpoint_free(evaluation->file);
    experiment_free(evaluation->e);
}

/* ---- work ---------------------------------------------------------------------------------- */

static ad_status read_progress(evaluation *evaluation, ad_error *error)
{
    progress *p = &evaluation->progress;
    *p = (progress){-1, -1, NAN};
    checkpoint_get_int64(evaluation->file, "training/step", &p->step, 1, NULL);
    checkpoint_get_int64(evaluation->file, "training/stage", &p->stage, 1, NULL);
    checkpoint_get_doubles(evaluation->file, "training/seconds", &p->seconds, 1, NULL);
    evaluation->is_judged = checkpoint_has(evaluation->file, "verdict");
    return evaluation->is_judged ? report_get_verdict(evaluation->file, &evaluation->verdict, error)
                                 : AD_OK;
}

static answer network_of(const evaluation *evaluation)
{
    const experiment *e = evaluation->e;
    return answer_of_network(evaluation->field, experiment_parameters(e), e->scene);
}

static ad_status evaluate(evaluation *evaluation, samples *p, ad_error *error)
{
    const answer network = network_of(evaluation);
    const ad_status status = samples_ask(p, &network, error);
    const size_t numbers = status == AD_OK ? (size_t)p->columns * p->count : 0;
    size_t bad = 0;
    for (size_t i = 0; i < numbers; i++) {
        bad += !isfinite(p->values[i]);
    }
    if (bad) {
        cli_warn(program, "%zu of %zu values are not finite", bad, numbers);
    }
    return status;
}

static ad_status evaluate_tip(evaluation *evaluation, ad_error *error)
{
    ad_status status = samples_make(&evaluation->tip, 1, error);
    if (status != AD_OK) {
        return status;
    }
    *evaluation->tip.s = scene_length(evaluation->e->scene);
    *evaluation->tip.t = experiment_until(evaluation->e);
    return evaluate(evaluation, &evaluation->tip, error);
}

/* A reference that cannot be had is worth a warning: the network can still be evaluated. */
static ad_status compare(evaluation *evaluation, ad_error *error)
{
    if (evaluation->e->warning[0]) {
        cli_warn(program, "no reference: %s", evaluation->e->warning);
    } else if (reference_create(evaluation->e, &evaluation->known, error) != AD_OK) {
        cli_warn(program, "no reference: %s", error->message);
        evaluation->known = NULL;
    } else if (evaluation->known && *reference_remark(evaluation->known)) {
        cli_warn(program, "reference: %s", reference_remark(evaluation->known));
    }
    return evaluation->known
               ? reference_compare(evaluation->known, experiment_parameters(evaluation->e),
                                   &evaluation->errors, error)
               : AD_OK;
}

/* ---- report -------------------------------------------------------------------------------- */

static void print_progress(const evaluation *evaluation)
{
    const progress *p = &evaluation->progress;
    int stages = evaluation->e->settings->stage_count;
    printf("%s: %s", evaluation->e->settings->name, evaluation->asked.checkpoint);
    if (p->step >= 0) {
        printf(", step %lld", (long long)p->step);
    }
    if (evaluation->e->scene->windows > 1) {
        printf(", window %d of %d (t = 0 to %g s)", evaluation->e->window + 1,
               evaluation->e->scene->windows, experiment_until(evaluation->e));
    }
    if (p->stage >= stages) {
        printf(", trained to the end");
    } else if (p->stage >= 0) {
        printf(", in stage %lld of %d", (long long)p->stage + 1, stages);
    }
    if (!isnan(p->seconds)) {
        printf(", %.1f s of training", p->seconds);
    }
    putchar('\n');
}

static void print_reference(const evaluation *evaluation)
{
    if (*reference_account(evaluation->known)) {
        printf("reference: %s\n", reference_account(evaluation->known));
    }
    solution_print_errors("error against", evaluation->known, &evaluation->errors);
}

/* The position of a rod, the deflection of a beam. */
static void print_tip(const evaluation *evaluation)
{
    const scene *scene = evaluation->e->scene;
    for (int i = 0; i < scene_known_count(scene); i++) {
        printf("%s%s = %g%s", i ? ", " : "member ", scene->parameters[i].name,
               evaluation->member[i],
               i + 1 < scene_known_count(scene) ? ""
               : evaluation->asked.family.at    ? "\n"
                                                : ", the middle one\n");
    }
    printf("tip%s", scene_is_beam(scene) ? " deflection" : "");
    for (int i = 0; i < scene_physics_of(scene)->position_columns; i++) {
        printf(" %.9g", evaluation->tip.values[i]);
    }
    printf(" m");
    if (scene_is_dynamic(scene)) {
        printf(" at t = %g s", *evaluation->tip.t);
    }
    putchar('\n');
}

static void print_report(const evaluation *evaluation)
{
    print_progress(evaluation);
    if (evaluation->is_judged) {
        verdict_print(stdout, "verdict on training: ", &evaluation->verdict);
    }
    if (!evaluation->field) {
        eval_family_print(&evaluation->family);
        return;
    }
    print_tip(evaluation);
    if (!isnan(evaluation->estimate)) {
        printf("estimated error %.1e of the %s\n", evaluation->estimate,
               scene_is_beam(evaluation->e->scene) ? "deflection" : "length");
    } else {
        printf("not trusted: its error is not known%s%s\n",
               *evaluation->unknown.message ? ": " : "", evaluation->unknown.message);
    }
    if (isfinite(evaluation->balance.loads)) {
        printf("loads: out of balance by %.1e\n", evaluation->balance.loads);
    }
    if (!isnan(evaluation->balance.energy)) {
        printf("energy out of balance by %.3e of the largest, momentum by %.3e\n",
               evaluation->balance.energy, evaluation->balance.momentum);
    }
    if (evaluation->known) {
        print_reference(evaluation);
    } else if (!evaluation->e->warning[0]) {
        printf("no reference to compare with\n");
    }
    if (evaluation->asked.out) {
        printf("wrote %s: %zu points\n", evaluation->asked.out, evaluation->samples.count);
    }
}

static void json_member(json *to, const evaluation *evaluation)
{
    const scene *scene = evaluation->e->scene;
    json_open(to, "member", '{');
    for (int i = 0; i < scene_known_count(scene); i++) {
        json_number(to, scene->parameters[i].name, evaluation->member[i]);
    }
    json_close(to, '}');
}

static void json_tip(json *to, const evaluation *evaluation)
{
    json_open(to, "tip", '{');
    json_number(to, "s", *evaluation->tip.s);
    json_number(to, "t", *evaluation->tip.t);
    for (int i = 0; i < scene_physics_of(evaluation->e->scene)->position_columns; i++) {
        json_number(to, field_column_name(evaluation->field, i), evaluation->tip.values[i]);
    }
    json_close(to, '}');
}

static void json_progress(json *to, const evaluation *evaluation)
{
    json_text(to, "name", evaluation->e->settings->name);
    json_text(to, "checkpoint", evaluation->asked.checkpoint);
    if (evaluation->is_judged) {
        report_verdict(to, &evaluation->verdict);
    } else {
        json_null(to, "verdict");
    }
    json_number(to, "step",
                evaluation->progress.step < 0 ? NAN : (double)evaluation->progress.step);
    json_integer(to, "window", evaluation->e->window);
    json_integer(to, "windows", evaluation->e->scene->windows);
    json_number(to, "stage",
                evaluation->progress.stage < 0 ? NAN : (double)evaluation->progress.stage);
    json_integer(to, "stages", evaluation->e->settings->stage_count);
    json_number(to, "training_seconds", evaluation->progress.seconds);
    json_integer(to, "parameters", (int64_t)evaluation->e->count);
}

static ad_status write_json(const evaluation *evaluation, ad_error *error)
{
    json to;
    json_begin(&to);
    json_progress(&to, evaluation);
    if (!evaluation->field) {
        eval_family_json(&to, &evaluation->family);
        return json_end(&to, evaluation->asked.json, error);
    }
    if (scene_is_family(evaluation->e->scene)) {
        json_member(&to, evaluation);
    }
    json_tip(&to, evaluation);
    json_number(&to, "estimate", evaluation->estimate);
    json_number(&to, "loads_out_of_balance", evaluation->balance.loads);
    json_number(&to, "energy_out_of_balance", evaluation->balance.energy);
    json_number(&to, "momentum_out_of_balance", evaluation->balance.momentum);
    report_reference(&to, evaluation->known, &evaluation->errors);
    json_integer(&to, "threads", ad_pool_threads(evaluation->e->pool));
    json_integer(&to, "points", (int64_t)evaluation->samples.count);
    json_text(&to, "out", evaluation->asked.out);
    return json_end(&to, evaluation->asked.json, error);
}

static ad_status open_run(evaluation *evaluation, ad_error *error)
{
    ad_status status =
        config_experiment_open(evaluation->asked.checkpoint, evaluation->asked.overrides.count,
                               evaluation->asked.overrides.texts, evaluation->asked.threads,
                               &evaluation->e, &evaluation->file, error);
    return status == AD_OK ? read_progress(evaluation, error) : status;
}

static ad_status open_field(evaluation *evaluation, ad_error *error)
{
    const ad_status status = experiment_choose_member(evaluation->e, evaluation->asked.family.at,
                                                      evaluation->member, error);
    return status == AD_OK
               ? experiment_field(evaluation->e, evaluation->member, &evaluation->field, error)
               : status;
}

static ad_status gather_points(evaluation *evaluation, const char *usual, ad_error *error)
{
    return samples_choose(&evaluation->samples, &evaluation->asked.where, usual,
                          evaluation->e->scene, experiment_until(evaluation->e), error);
}

/* Tables say where the points are on this member. */
static ad_status keep_member(evaluation *evaluation, ad_error *error)
{
    samples *p = &evaluation->samples;
    const size_t bytes = (size_t)evaluation->e->scene->parameter_count * sizeof *p->parameters;
    p->parameters = malloc(bytes + 1);
    if (!p->parameters) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a member");
    }
    memcpy(p->parameters, evaluation->member, bytes);
    return AD_OK;
}

/* Whether members are answered with their errors; motions and beams have none, and like families
 * without a question are shown by one member. */
static bool is_answered(const evaluation *evaluation)
{
    const eval_family_options *f = &evaluation->asked.family;
    const scene *scene = evaluation->e->scene;
    return scene_is_family(scene) && (evaluation->e->targets || f->members || f->verify > 0 ||
                                      (f->at && !scene_is_dynamic(scene) && !scene_is_beam(scene)));
}

/* Shapes of members have 21 points as usual. */
static ad_status run_family(evaluation *evaluation, ad_error *error)
{
    const options *o = &evaluation->asked;
    const char *usual = scene_is_dynamic(evaluation->e->scene) ? "21x11" : "21";
    eval_family_options asked = o->family;
    asked.threads = o->threads;
    asked.out = o->out;
    const char *conflict = eval_family_conflict(&asked);
    if (conflict) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%s", conflict);
    }
    ad_status status = gather_points(evaluation, usual, error);
    status = status == AD_OK ? eval_family_run(&asked, evaluation->e, &evaluation->samples,
                                               &evaluation->family, error)
                             : status;
    if (status == AD_OK) {
        eval_family_warn(program, &evaluation->family);
    }
    return status;
}

static ad_status evaluate_points(evaluation *evaluation, ad_error *error)
{
    ad_status status = gather_points(evaluation, NULL, error);
    status = status == AD_OK ? keep_member(evaluation, error) : status;
    if (status == AD_OK) {
        status = evaluate(evaluation, &evaluation->samples, error);
    }
    return status == AD_OK ? samples_write(&evaluation->samples, evaluation->asked.out, error)
                           : status;
}

static ad_status run(evaluation *evaluation, ad_error *error)
{
    const options *o = &evaluation->asked;
    const eval_family_options *f = &o->family;
    ad_status status = o->out ? shapes_check_path(o->out, error) : AD_OK;
    status = status == AD_OK ? json_check_path(o->json, error) : status;
    status = status == AD_OK ? open_run(evaluation, error) : status;
    if (status == AD_OK && is_answered(evaluation)) {
        return run_family(evaluation, error);
    }
    if (status == AD_OK && !scene_is_family(evaluation->e->scene) &&
        (f->at || f->members || f->verify > 0 || f->extrapolate || f->compile || f->derivatives)) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "--at, --members, --verify, --extrapolate, --compile, --derivatives: the "
                         "scene is no family: no parameter of it has a range");
    }
    if (status == AD_OK && (f->extrapolate || f->polish >= 0 || f->seed >= 0 || f->derivatives)) {
        status =
            ad_fail(error, AD_BAD_ARGUMENT, "%s",
                    f->seed >= 0     ? "--seed: of the members that --verify draws"
                    : f->derivatives ? "--derivatives: of a motion or a beam, of --members alone"
                    : f->polish >= 0 ? "--polish: of members of a family of rods at rest"
                                     : "--extrapolate: of a motion or a beam, of --members "
                                       "alone");
    }
    if (status == AD_OK) {
        status = open_field(evaluation, error);
    }
    if (status == AD_OK) {
        status = evaluate_tip(evaluation, error);
    }
    if (status == AD_OK && o->out) {
        status = evaluate_points(evaluation, error);
    }
    if (status == AD_OK) {
        status = f->at ? experiment_error(evaluation->e, evaluation->member, &evaluation->estimate,
                                          &evaluation->unknown)
                       : experiment_kept_error(evaluation->e, evaluation->file,
                                               &evaluation->estimate, &evaluation->unknown);
        if (status != AD_OK) {
            *error = evaluation->unknown;
        }
    }
    if (status == AD_OK) {
        evaluation->balance = experiment_balance(evaluation->e, evaluation->member);
        status = compare(evaluation, error);
    }
    return status;
}

/* Several processes share what takes long. */
static int check_ranks(const options *o)
{
    return !o->ranks || o->family.members || o->family.verify > 0 || o->rollouts.count > 0
               ? CLI_RUN
               : launcher_refuse(program, "shares only --members, --verify and --rollouts among "
                                          "processes");
}

/* The whole program but for its ranks. */
static int go(const ad_ranks *ranks, int argc, char **argv)
{
    evaluation x = {.asked = {.family = {.polish = -1, .seed = -1, .ranks = ranks},
                              .rollouts = {.tolerance = NAN, .ranks = ranks},
                              .ranks = ranks}};
    x.family.shapes = &x.samples;
    eval_family_options *f = &x.asked.family;
    eval_rollouts_options *r = &x.asked.rollouts;
    const cli_option list[] = {CLI_OUT(&x.asked.out),
                               CLI_GRID(&x.asked.where.grid),
                               CLI_POINTS(&x.asked.where.points),
                               CLI_SET(&x.asked.overrides),
                               CLI_AT(&f->at),
                               {"--members", "FILE", CLI_TEXT, &f->members, 0, 0},
                               {"--polish", "N", CLI_INTEGER, &f->polish, 0, 2},
                               {"--extrapolate", NULL, CLI_FLAG, &f->extrapolate, 0, 0},
                               {"--derivatives", NULL, CLI_FLAG, &f->derivatives, 0, 0},
                               {"--verify", "N", CLI_INTEGER, &f->verify, 1, 10000000},
                               {"--compile", NULL, CLI_FLAG, &f->compile, 0, 0},
                               CLI_SEED(&f->seed),
                               {"--rollouts", "N", CLI_INTEGER, &r->count, 1, 10000},
                               {"--tolerance", "X", CLI_NUMBER, &r->tolerance, 0, 1},
                               CLI_JSON(&x.asked.json),
                               CLI_THREADS(&x.asked.threads),
                               CLI_QUIET(&x.asked.quiet)};
    const cli_program about = {program, "DIR_OR_CHECKPOINT", help_eval, NULL, NULL};
    int status =
        cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &x.asked.checkpoint);
    status = status == CLI_RUN ? check_ranks(&x.asked) : status;
    if (status != CLI_RUN) {
        return status;
    }
    x.asked.threads = ranks_threads(x.asked.threads);
    x.asked.json = x.asked.json && !ad_ranks_is_first(ranks) ? "-" : x.asked.json; /* to nowhere */
    if (r->count == 0 && !isnan(r->tolerance)) {
        return cli_fail(program, "--tolerance: of --rollouts; allowed: the two together");
    }
    if (r->count > 0) {
        if (x.asked.where.grid || x.asked.where.points || x.asked.overrides.count > 0 || f->at ||
            f->members || f->verify) {
            return cli_fail(program, "--rollouts: allowed beside it: --out DIR, --tolerance, "
                                     "--seed, --json, --quiet, --threads");
        }
        r->path = x.asked.checkpoint;
        r->out = x.asked.out;
        r->seed = f->seed >= 0 ? f->seed : 1;
        r->threads = x.asked.threads;
        r->json = x.asked.json;
        r->quiet = x.asked.quiet;
        return eval_rollouts_run(program, r);
    }
    status = samples_check(program, &x.asked.where, x.asked.out || f->at || f->verify > 0);
    if (status != CLI_RUN) {
        return status;
    }
    ad_error error = {.message = ""};
    status = 0;
    if (run(&x, &error) != AD_OK) {
        status = cli_fail_error(program, &error);
    } else if (x.asked.json && write_json(&x, &error) != AD_OK) {
        status = cli_fail_error(program, &error);
    } else if (x.asked.quiet && x.is_judged && verdict_outcome_of(&x.verdict) == VERDICT_WARNING) {
        verdict_print(stderr, "cpinn-eval: verdict on training: ", &x.verdict);
    } else if (!x.asked.quiet && !json_is_printed(x.asked.json)) {
        print_report(&x);
    }
    status = status == 0 ? eval_family_status(&x.family) : status;
    evaluation_free(&x);
    return status;
}

int main(int argc, char **argv)
{
    const ad_ranks *ranks;
    ad_error error;
    if (ranks_begin(argc, argv, &ranks, &error) != AD_OK) {
        int rank;
        launcher_processes(&rank); /* one line */
        return ranks_end(program, rank > 0 ? CLI_BAD : cli_fail_error(program, &error));
    }
    return ranks_end(program, go(ranks, argc, argv));
}
