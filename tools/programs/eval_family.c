#include "tools/programs/eval_family.h"

#include "physics/scene/scene_memory.h"
#include "tools/config/config.h"
#include "tools/library/trained_family.h"
#include "tools/programs/cli.h"
#include "tools/programs/samples.h"
#include "tools/train/members_given.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double MM = 1e3;

enum { POLISH = 2, SEED = 1 }; /* where nothing is said */

void eval_family_free(eval_family *eval)
{
    cpinn_family_free(eval->family);
}

const char *eval_family_conflict(const eval_family_options *asked)
{
    const int ways = !!asked->at + !!asked->members + (asked->verify > 0);
    return ways > 1 ? "--at, --members and --verify: allowed: one of them"
           : asked->members && !asked->out
               ? "--members: nothing would be written; give --out FILE too"
           : asked->members && strcmp(asked->members, asked->out) == 0
               ? "--out: is the file of --members, which would be lost"
           : asked->verify && asked->out ? "--verify writes no --out; --json has its numbers"
           : asked->out && ways == 0     ? "--out: of a family nothing would be written; give --at "
                                           "or --members too"
           : !(asked->at || asked->members) && asked->extrapolate
               ? "--extrapolate: of --at or --members"
           : asked->derivatives && !asked->out
               ? "--derivatives: nothing would be written; give --out FILE too"
           : asked->compile && asked->verify == 0
               ? "--compile: of the answers that --verify measures"
           : asked->seed >= 0 && asked->verify == 0 ? "--seed: of the members that --verify draws"
                                                    : NULL;
}

/* ---- answers ------------------------------------------------------------------------------- */

static const char OR_ELSE[] = ", or with --extrapolate";

static ad_status check_range(const eval_family *eval, const table_file *table, ad_error *error)
{
    size_t member;
    int k;
    if (table && !eval->asked.extrapolate) {
        return train_members_check(&eval->family->open, eval->asked.members, table,
                                   eval->shapes->parameters, OR_ELSE, error);
    }
    if (!cpinn_family_refuses(eval->family, eval->shapes->members, eval->shapes->parameters,
                              &member, &k)) {
        return AD_OK;
    }
    const scene_parameter *p = cpinn_family_parameter(eval->family, k);
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "--at: %s = %.10g is outside its range; allowed: %g to %g%s", p->name,
                   eval->shapes->parameters[k], p->low, p->high, OR_ELSE);
}

static ad_status gather(eval_family *eval, ad_error *error)
{
    const scene *family = &eval->family->open;
    samples *to = eval->shapes;
    table_file *table = NULL;
    ad_status status;
    if (eval->asked.members) {
        status = train_members_read(family, eval->asked.members, &to->parameters, &table, error);
        to->members = table ? table_rows(table) : 0;
    } else {
        to->members = 1;
        to->parameters = malloc((size_t)family->parameter_count * sizeof *to->parameters);
        status = to->parameters /* ranges are asked for later, with those of files */
                     ? scene_member_read(scene_given_count(family), family->parameters, true,
                                         eval->asked.at, to->parameters, error)
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for a member");
        if (status == AD_OK) {
            scene_remember_path(family, 1, to->parameters, NULL);
        }
    }
    status = status == AD_OK ? check_range(eval, table, error) : status;
    table_free(table);
    return status;
}

/* Tables have the columns of tubes, as those of one shape. */
static cpinn_family_settings settings_of(const eval_family_options *asked, const scene *open,
                                         const samples *shapes)
{
    const bool twists = open->tube_count > 0 && asked->verify == 0;
    return (cpinn_family_settings){.extrapolate = asked->extrapolate,
                                   .threads = asked->threads,
                                   .points = shapes->count,
                                   .s = shapes->s,
                                   .t = shapes->t,
                                   .compile = asked->compile,
                                   .ranks = asked->ranks,
                                   .forces = asked->derivatives || twists};
}

static ad_status answer_members(eval_family *eval, const cpinn_polish *polish, ad_error *error)
{
    const eval_family_options *asked = &eval->asked;
    ad_status status = gather(eval, error);
    if (status == AD_OK) {
        const answer family = answer_of_family(eval->family, polish);
        eval->shapes->derives = asked->derivatives;
        status = samples_ask(eval->shapes, &family, error);
    }
    const bool writes = asked->out && ad_ranks_is_first(asked->ranks);
    return status == AD_OK && writes ? samples_write(eval->shapes, asked->out, error) : status;
}

ad_status eval_family_run(const eval_family_options *asked, const experiment *e, samples *shapes,
                          eval_family *result, ad_error *error)
{
    const cpinn_polish polish = {.steps = asked->polish < 0 ? POLISH : asked->polish};
    const cpinn_family_settings settings = settings_of(asked, e->scene, shapes);
    *result = (eval_family){.asked = *asked, .shapes = shapes};
    result->asked.seed = asked->seed < 0 ? SEED : asked->seed;
    ad_status status = cpinn_family_of(e, &settings, &result->family, error);
    const char *why = status != AD_OK || asked->polish < 0 ? ""
                      : asked->verify > 0                  ? "--verify measures 0, 1 and 2 steps"
                                          : cpinn_family_without_error(result->family);
    if (*why) {
        return ad_fail(error, AD_BAD_ARGUMENT, "--polish: of no effect: %s", why);
    }
    why = status == AD_OK ? cpinn_family_not_compiled(result->family) : "";
    if (*why) {
        return ad_fail(error, AD_BAD_ARGUMENT, "--compile: %s", why);
    }
    if (status == AD_OK && asked->verify > 0) {
        return cpinn_family_verify(result->family, (size_t)asked->verify,
                                   (uint64_t)result->asked.seed, &result->check, error);
    }
    return status == AD_OK && (asked->at || asked->members) ? answer_members(result, &polish, error)
                                                            : status;
}

ad_status eval_family_solve(const eval_family_options *asked, const scene *open, double tolerance,
                            samples *shapes, eval_family *result, ad_error *error)
{
    const cpinn_family_settings settings = settings_of(asked, open, shapes);
    *result = (eval_family){.asked = *asked, .shapes = shapes};
    const ad_status status =
        cpinn_family_of_scene(open, tolerance, &settings, &result->family, error);
    return status == AD_OK ? answer_members(result, NULL, error) : status;
}

/* ---- report -------------------------------------------------------------------------------- */

typedef struct tally {
    size_t trusted, outside, sources[CPINN_FROM_NOTHING + 1], reasons[CPINN_REASON_COUNT];
    double worst; /* predicted error, of those trusted, m */
} tally;

static tally count(const eval_family *eval)
{
    tally of = {.worst = 0};
    for (size_t i = 0; i < eval->shapes->members; i++) {
        const cpinn_answer *said = &eval->shapes->said[i];
        of.trusted += said->trusted;
        of.outside += said->outside;
        of.sources[said->source]++;
        of.reasons[said->reason] += !said->trusted;
        of.worst = said->trusted ? fmax(of.worst, said->error) : of.worst;
    }
    return of;
}

/* "2 no_equilibrium, 1 warning" */
static const char *list_reasons(const size_t *reasons, char text[256])
{
    size_t at = 0;
    text[0] = '\0';
    for (int i = 0; i < CPINN_REASON_COUNT && at < 256; i++) {
        if (reasons[i] > 0) {
            at += (size_t)snprintf(text + at, 256 - at, "%s%zu %s", at > 0 ? ", " : "", reasons[i],
                                   cpinn_reason_word((cpinn_reason)i));
        }
    }
    return text;
}

void eval_family_warn(const char *program, const eval_family *eval)
{
    const tally of = count(eval);
    char text[256];
    if (of.outside > 0) {
        cli_warn(program, "extrapolated: %zu of %zu members are outside the range", of.outside,
                 eval->shapes->members);
    }
    if (of.trusted < eval->shapes->members) {
        cli_warn(program, "not trusted: %zu of %zu members: %s", eval->shapes->members - of.trusted,
                 eval->shapes->members, list_reasons(of.reasons, text));
    }
    for (int k = 0; k < CPINN_WAY_COUNT; k++) {
        if (eval->check.rows[k].wrong > 0) {
            cli_warn(program, "wrong though trusted: %zu of %zu members (%s)",
                     eval->check.rows[k].wrong, eval->check.members, cpinn_way_word((cpinn_way)k));
        }
    }
}

static void print_range(const eval_family *eval)
{
    const int parameters = cpinn_family_parameters(eval->family);
    printf("family of %d parameter%s:", parameters, parameters == 1 ? "" : "s");
    for (int i = 0; i < parameters; i++) {
        const scene_parameter *p = cpinn_family_parameter(eval->family, i);
        printf("%s %s %g to %g", i > 0 ? "," : "", p->name, p->low, p->high);
    }
    putchar('\n');
    if (*cpinn_family_without_error(eval->family)) {
        printf("errors are not predicted: %s\n", cpinn_family_without_error(eval->family));
    }
}

static void print_answer(const eval_family *eval)
{
    const samples *p = eval->shapes;
    const cpinn_answer *said = p->said;
    const int rows = scene_physics_of(&eval->family->open)->position_columns;
    printf("%strusted, from %s", said->trusted ? "" : "not ", cpinn_source_word(said->source));
    if (said->reason) {
        printf(" (%s: %s)", cpinn_reason_word(said->reason), cpinn_reason_text(said->reason));
    }
    putchar('\n');
    cli_print_error("predicted error", MM * said->error, " mm");
    cli_print_error("of the network alone", MM * said->network_error, " mm");
    if (eval->asked.out || said->source == CPINN_FROM_NOTHING) {
        return;
    }
    printf("%12s", "s, mm");
    if (eval->family->t) {
        printf("%12s", "t, s");
    }
    for (int c = 0; c < rows; c++) {
        printf("%11s, mm", cpinn_family_column_name(eval->family, c));
    }
    putchar('\n');
    for (size_t i = 0; i < p->count; i++) {
        printf("%12.6g", MM * scene_place_at(p->of, p->parameters, p->s[i], 0));
        if (eval->family->t) {
            printf("%12.6g", p->t[i]);
        }
        for (int c = 0; c < rows; c++) {
            printf("%15.8g", MM * p->values[(size_t)c * p->count + i]);
        }
        putchar('\n');
    }
}

static void print_members(const eval_family *eval)
{
    const tally of = count(eval);
    char errors[64] = "";
    if (of.trusted > 0) {
        snprintf(errors, sizeof errors, ", with errors of up to %.2g mm", MM * of.worst);
    }
    printf("%zu members: %zu trusted%s; from the network %zu, solved "
           "%zu, without an equilibrium %zu; %.3g us a shape\n",
           eval->shapes->members, of.trusted, errors, of.sources[CPINN_FROM_NETWORK],
           of.sources[CPINN_FROM_MEMBERS] + of.sources[CPINN_FROM_SOLVER],
           of.sources[CPINN_FROM_NOTHING],
           1e6 * eval->shapes->seconds / (double)eval->shapes->members);
}

static void print_row(const char *name, const cpinn_family_row *row)
{
    char text[256];
    printf("%-12s %9.2e %9.2e %9.2e %9.2e %11zu %6zu", name, MM * row->median, MM * row->p95,
           MM * row->p999, MM * row->worst, row->not_trusted, row->wrong);
    if (isnan(row->within)) {
        printf(" %31s", "-");
    } else {
        printf("  %6.3f %6.3f %6.3f  %6.1f %%", row->ratio[0], row->ratio[1], row->ratio[2],
               100 * row->within);
    }
    printf(" %8.1f %8.2f  %s", 1e6 * row->alone, 1e6 * row->batch,
           list_reasons(row->reasons, text));
    if (row->solved > 0) {
        printf("%s%zu solved instead", *text ? ", " : "", row->solved);
    }
    putchar('\n');
}

/* Of the network without its errors, and of the solver. */
static void print_times(const char *name, double alone, double batch)
{
    if (!isnan(alone)) {
        printf("%-12s %98.1f %8.2f\n", name, 1e6 * alone, 1e6 * batch);
    }
}

/* Whether the two solvers are further apart than by their tolerances. */
static bool are_apart(const eval_family *eval)
{
    return eval->check.compared > 0 &&
           eval->check.apart > CPINN_ENOUGH * scene_length(&eval->family->open);
}

static void print_check(const eval_family *eval)
{
    const cpinn_family_check *c = &eval->check;
    printf(
        "%zu fresh members (seed %d), shapes of %zu points: %zu solved by the solver of members, "
        "%zu by the other one alone, %zu by neither\n",
        c->members, eval->asked.seed, eval->shapes->count, c->by_members, c->by_solver,
        c->unsolved);
    if (c->compared > 0) {
        printf("both solvers on %zu members: at most %.1e mm apart%s\n", c->compared, MM * c->apart,
               are_apart(eval) ? ": different equilibria, so that errors below say little" : "");
    }
    printf("             error, mm                                                      predicted "
           "over actual          us a shape\n"
           "answers         median      95 %%    99.9 %%     worst not trusted  wrong     1 %%   "
           "50 %%   99 %%  within 5 %%   alone    batch\n");
    const int ways = *cpinn_family_without_error(eval->family) ? 1 : CPINN_WAY_COUNT;
    for (int k = 0; k < ways; k++) { /* without errors there are no steps */
        print_row(cpinn_way_word((cpinn_way)k), &c->rows[k]);
    }
    print_times("no error", c->bare_alone, c->bare_batch);
    print_times("solver", c->solver_alone, c->solver_batch);
    for (int k = 0; k < CPINN_WAY_COUNT; k++) {
        if (c->rows[k].unknown > 0) {
            printf("%s: %zu trusted where no solver finds an equilibrium without a warning\n",
                   cpinn_way_word((cpinn_way)k), c->rows[k].unknown);
        }
    }
}

void eval_family_print(const eval_family *eval)
{
    print_range(eval);
    if (eval->asked.verify > 0) {
        print_check(eval);
    } else if (eval->asked.members) {
        print_members(eval);
    } else if (eval->asked.at) {
        print_answer(eval);
    } else {
        puts("a shape: --at, shapes: --members, how far they can be trusted: --verify");
    }
    if (eval->asked.out) {
        printf("wrote %s: %zu rows\n", eval->asked.out, samples_rows(eval->shapes));
    }
}

/* ---- as JSON ------------------------------------------------------------------------------- */

static void json_reasons(json *to, const size_t *reasons)
{
    json_open(to, "reasons", '{');
    for (int i = 0; i < CPINN_REASON_COUNT; i++) {
        if (reasons[i] > 0) {
            json_integer(to, cpinn_reason_word((cpinn_reason)i), (int64_t)reasons[i]);
        }
    }
    json_close(to, '}');
}

static void json_row(json *to, cpinn_way way, const cpinn_family_row *row)
{
    json_open(to, NULL, '{');
    json_text(to, "answers", cpinn_way_word(way));
    json_number(to, "median", row->median);
    json_number(to, "p95", row->p95);
    json_number(to, "p999", row->p999);
    json_number(to, "worst", row->worst);
    json_integer(to, "not_trusted", (int64_t)row->not_trusted);
    json_reasons(to, row->reasons);
    json_integer(to, "solved_instead", (int64_t)row->solved);
    json_integer(to, "wrong_though_trusted", (int64_t)row->wrong);
    json_integer(to, "trusted_though_unsolved", (int64_t)row->unknown);
    json_number(to, "predicted_over_actual_p01", row->ratio[0]);
    json_number(to, "predicted_over_actual_median", row->ratio[1]);
    json_number(to, "predicted_over_actual_p99", row->ratio[2]);
    json_number(to, "predicted_within_5_percent", row->within);
    json_number(to, "seconds_alone", row->alone);
    json_number(to, "seconds_batch", row->batch);
    json_close(to, '}');
}

static void json_check(json *to, const eval_family *eval)
{
    const cpinn_family_check *c = &eval->check;
    json_open(to, "verify", '{');
    json_integer(to, "members", (int64_t)c->members);
    json_integer(to, "seed", eval->asked.seed);
    json_integer(to, "points", (int64_t)eval->shapes->count);
    json_integer(to, "solved_by_members", (int64_t)c->by_members);
    json_integer(to, "solved_by_solver", (int64_t)c->by_solver);
    json_integer(to, "unsolved", (int64_t)c->unsolved);
    json_integer(to, "compared_solvers", (int64_t)c->compared);
    json_number(to, "solvers_apart", c->compared > 0 ? c->apart : NAN);
    json_number(to, "network_seconds_alone", c->bare_alone);
    json_number(to, "network_seconds_batch", c->bare_batch);
    json_number(to, "solver_seconds_alone", c->solver_alone);
    json_number(to, "solver_seconds_batch", c->solver_batch);
    json_open(to, "answers", '[');
    for (int k = 0; k < CPINN_WAY_COUNT; k++) {
        json_row(to, (cpinn_way)k, &c->rows[k]);
    }
    json_close(to, ']');
    json_close(to, '}');
}

static void json_answer(json *to, const eval_family *eval)
{
    const samples *p = eval->shapes;
    const cpinn_answer *said = p->said;
    json_open(to, "answer", '{');
    json_number(to, "error", said->error);
    json_number(to, "network_error", said->network_error);
    json_integer(to, "trusted", said->trusted);
    json_integer(to, "outside", said->outside);
    json_text(to, "source", cpinn_source_word(said->source));
    json_text(to, "reason", cpinn_reason_word(said->reason));
    json_open(to, "end", '{'); /* the last of the points */
    for (int c = 0; c < p->columns; c++) {
        json_number(to, cpinn_family_column_name(eval->family, c),
                    p->values[(size_t)(c + 1) * p->count - 1]);
    }
    json_close(to, '}');
    json_close(to, '}');
}

static void json_members(json *to, const eval_family *eval)
{
    const tally of = count(eval);
    json_open(to, "members", '{');
    json_integer(to, "count", (int64_t)eval->shapes->members);
    json_integer(to, "trusted", (int64_t)of.trusted);
    json_integer(to, "outside", (int64_t)of.outside);
    for (int i = 0; i <= CPINN_FROM_NOTHING; i++) {
        char name[32];
        snprintf(name, sizeof name, "from_%s", cpinn_source_word((cpinn_source)i));
        json_integer(to, name, (int64_t)of.sources[i]);
    }
    json_reasons(to, of.reasons);
    json_number(to, "largest_error", of.worst);
    json_number(to, "seconds", eval->shapes->seconds);
    json_close(to, '}');
}

void eval_family_json(json *to, const eval_family *eval)
{
    json_open(to, "ranges", '[');
    for (int i = 0; i < cpinn_family_parameters(eval->family); i++) {
        const scene_parameter *p = cpinn_family_parameter(eval->family, i);
        json_open(to, NULL, '{');
        json_text(to, "name", p->name);
        json_number(to, "low", p->low);
        json_number(to, "high", p->high);
        json_text(to, "scale", scene_scale_names()[p->scale]);
        json_close(to, '}');
    }
    json_close(to, ']');
    if (eval->asked.verify > 0) {
        json_check(to, eval);
    } else if (eval->asked.members) {
        json_members(to, eval);
    } else if (eval->asked.at) {
        json_answer(to, eval);
    }
    json_text(to, "out", eval->asked.out);
}

int eval_family_status(const eval_family *eval)
{
    bool doubtful = count(eval).trusted < eval->shapes->members || are_apart(eval);
    for (int k = 0; k < CPINN_WAY_COUNT; k++) {
        doubtful = doubtful || eval->check.rows[k].wrong > 0;
    }
    return doubtful ? 3 : 0;
}
