/* cpinn-stress: stiff and extreme scenes, each against the outcome that is expected; see --help. */
#include "tools/files/table_file.h"
#include "tools/judge/result_table.h"
#include "tools/judge/signals.h"
#include "tools/judge/stress.h"
#include "tools/programs/cli.h"
#include "tools/programs/help.h"
#include "tools/programs/program_ranks.h"
#include "tools/programs/ranks_queue.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char program[] = "cpinn-stress";

enum {
    FOLDER = 64,
    WORDS = 7,
    NUMBERS = 3,
    SUBJECT = 32,
    ROWS_MAX = STRESS_ROWS_MAX * JUDGE_METHODS
};

typedef struct options {
    cli_list only;
    const char *out, *method;
    bool quick, is_long, list;
    const stress_row *rows; /* [count] */
    size_t count;
    const ad_ranks *ranks; /* NULL: this process is by itself */
} options;

/* ---- which rows ---------------------------------------------------------------------------- */

/* The name itself, or its part before the slash. */
static bool named(const stress_row *row, const char *name)
{
    size_t length = strlen(name);
    return strncmp(row->name, name, length) == 0 &&
           (row->name[length] == '\0' || row->name[length] == '/');
}

static bool is_asked(const options *o, const stress_row *row, judge_method method)
{
    if (!row->expected[method].why ||
        (o->method && strcmp(o->method, judge_method_name(method)) != 0)) {
        return false;
    }
    for (int i = 0; i < o->only.count; i++) {
        if (named(row, o->only.texts[i])) {
            return true;
        }
    }
    return o->only.count == 0 && (o->quick ? row->quick : o->is_long || !row->is_long);
}

/* The name of --only that no row has, or NULL. */
static const char *unknown_name(const options *o)
{
    for (int i = 0; i < o->only.count; i++) {
        bool found = false;
        for (size_t k = 0; k < o->count; k++) {
            found = found || named(&o->rows[k], o->only.texts[i]);
        }
        if (!found) {
            return o->only.texts[i];
        }
    }
    return NULL;
}

/* ---- the table ----------------------------------------------------------------------------- */

static void print_expected(const stress_expectation *expected, char text[32])
{
    int length = snprintf(text, 32, "%s", verdict_outcome_name(expected->outcome));
    if (expected->outcome == VERDICT_SOLVED) {
        snprintf(text + length, 32 - (size_t)length, " %.0e", expected->bound);
    }
}

static void print_list_row(const options *o, const stress_row *row)
{
    for (int method = 0; method < JUDGE_METHODS; method++) {
        char expected[32];
        if (is_asked(o, row, (judge_method)method)) {
            print_expected(&row->expected[method], expected);
            printf("  %-26s %-7s %-14s %s\n", row->name, judge_method_name((judge_method)method),
                   expected, row->expected[method].why);
        }
    }
}

static void print_list(const options *o)
{
    for (size_t k = 0; k < o->count; k++) {
        if (o->rows[k].about) {
            printf("%s%s\n", k ? "\n" : "", o->rows[k].about);
        }
        print_list_row(o, &o->rows[k]);
    }
}

static void print_row(const stress_row *row, judge_method method, const judge_row *result)
{
    const stress_expectation *expected = &row->expected[method];
    char outcome[32], error[RESULT_TABLE_TEXT], seconds[RESULT_TABLE_TEXT];
    bool as_expected = stress_as_expected(expected, &result->verdict);
    print_expected(expected, outcome);
    printf("%-26s %-27s %-13s %-11s %8s %6s  %s\n", row->name, judge_form_of(result, method),
           outcome, verdict_outcome_name(verdict_outcome_of(&result->verdict)),
           result_table_error(result->error, error), result_table_seconds(result->seconds, seconds),
           as_expected ? "as expected" : "NOT AS EXPECTED");
    if (!as_expected) {
        printf("    expected: %s%s%s; got:\n", expected->text ? "\"" : "",
               expected->text ? expected->text : expected->why, expected->text ? "\"" : "");
        verdict_print(stdout, "      ", &result->verdict);
    }
    fflush(stdout);
}

/* A row by a method. */
typedef struct planned {
    const stress_row *row;
    judge_method method;
} planned;

/* What is to be done, and what the file of --out is made of. */
typedef struct record {
    char folder[FOLDER]; /* of this process, for the files of its rows */
    size_t count;
    planned plan[ROWS_MAX];
    result_table table;
    char subjects[ROWS_MAX][SUBJECT];
    int surprises; /* rows not as expected */
} record;

static void record_row(record *all, const stress_row *row, judge_method method,
                       const judge_row *result)
{
    const stress_expectation *expected = &row->expected[method];
    const verdict *found = &result->verdict;
    char *subject = all->subjects[all->table.rows];
    const char *slash = strchr(row->name, '/');
    bool as_expected = stress_as_expected(expected, found);
    snprintf(subject, SUBJECT, "%.*s", (int)(slash - row->name), row->name);
    const char *words[WORDS] = {subject,
                                slash + 1,
                                judge_method_name(method),
                                verdict_outcome_name(expected->outcome),
                                verdict_outcome_name(verdict_outcome_of(found)),
                                verdict_reason_name(verdict_worst(found)),
                                as_expected ? "as expected" : "not as expected"};
    const double numbers[NUMBERS] = {expected->outcome == VERDICT_SOLVED ? expected->bound : NAN,
                                     result->error, result->seconds};
    result_table_add(&all->table, words, numbers);
    all->surprises += !as_expected;
}

/* ---- running ------------------------------------------------------------------------------- */

static ad_status make_folder(char folder[FOLDER], ad_error *error)
{
    const char *base = getenv("TMPDIR");
    int length = snprintf(folder, FOLDER, "%s/cpinn-stress-XXXXXX",
                          base && strlen(base) < FOLDER - 24 ? base : "/tmp");
    return length < FOLDER && mkdtemp(folder)
               ? AD_OK
               : ad_fail(error, AD_IO, "%s: %s", folder, strerror(errno));
}

/* What rows have left there is theirs alone. */
static void remove_folder(const char *folder)
{
    char path[FOLDER + 300];
    DIR *open = opendir(folder);
    for (struct dirent *entry; open && (entry = readdir(open));) {
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        unlink(path);
    }
    if (open) {
        closedir(open);
    }
    rmdir(folder);
}

static void make_plan(record *all, const options *o)
{
    for (size_t k = 0; k < o->count; k++) {
        for (judge_method method = 0; method < JUDGE_METHODS; method++) {
            if (is_asked(o, &o->rows[k], method)) {
                all->plan[all->count++] = (planned){&o->rows[k], method};
            }
        }
    }
}

static ad_status do_row(void *context, size_t index, ranks_result *result, ad_error *error)
{
    const record *all = context;
    const planned *at = &all->plan[index];
    judge_row row;
    ad_status status = stress_run(at->row, at->method, all->folder, &row, error);
    return status == AD_OK ? ranks_result_copy(result, sizeof row, &row, error) : status;
}

/* What a signal has cut short is no row. */
static ad_status take_row(void *context, size_t index, const ranks_result *result, ad_error *error)
{
    record *all = context;
    const planned *at = &all->plan[index];
    judge_row row;
    (void)error;
    if (!result->is_cut) {
        memcpy(&row, result->bytes, sizeof row);
        print_row(at->row, at->method, &row);
        record_row(all, at->row, at->method, &row);
    }
    return AD_OK;
}

static int run(const options *o)
{
    static const char *const names[] = {"subject", "scene",   "method", "expected", "outcome",
                                        "reason",  "verdict", "bound",  "error",    "seconds"};
    static record all;
    const bool writes = o->out && ad_ranks_is_first(o->ranks);
    int signal = 0;
    ad_error error = {AD_OK, ""};
    signals_catch();
    if ((writes && table_check_path(o->out, &error) != AD_OK) ||
        make_folder(all.folder, &error) != AD_OK) {
        ranks_queue_none(o->ranks);
        return cli_fail_error(program, &error);
    }
    make_plan(&all, o);
    all.table = result_table_create(names, WORDS, NUMBERS, ROWS_MAX);
    const ranks_jobs jobs = {.count = all.count, .context = &all, .work = do_row, .take = take_row};
    printf("%-26s %-27s %-13s %-11s %8s %6s  %s\n", "scene", "method", "expected", "outcome",
           "error", "s", "verdict");
    ad_status status = ranks_queue(o->ranks, &jobs, &signal, &error);
    const int stopped =
        signal ? ranks_queue_stopped(program, o->ranks, signal, all.table.rows, all.count) : 0;
    if (status == AD_OK && !stopped) {
        printf("%zu rows, %d not as expected\n", all.table.rows, all.surprises);
    }
    if (status == AD_OK && writes) {
        status = result_table_write(&all.table, o->out, &error);
    }
    result_table_free(&all.table);
    remove_folder(all.folder);
    return status != AD_OK ? cli_fail_error(program, &error)
           : stopped       ? stopped
                           : all.surprises > 0;
}

/* Returns CLI_RUN where rows are to be run. */
static int parse(int count, char **arguments, options *o)
{
    const char *operand;
    const cli_program about = {program, NULL, help_stress, NULL, NULL};
    const cli_option known[] = {{"--only", "NAME", CLI_LIST, &o->only, 0, 0},
                                {"--method", "NAME", CLI_TEXT, &o->method, 0, 0},
                                {"--quick", NULL, CLI_FLAG, &o->quick, 0, 0},
                                {"--long", NULL, CLI_FLAG, &o->is_long, 0, 0},
                                {"--list", NULL, CLI_FLAG, &o->list, 0, 0},
                                {"--out", "FILE", CLI_TEXT, &o->out, 0, 0}};
    int result = cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &operand);
    if (result != CLI_RUN) {
        return result;
    }
    const char *unknown = unknown_name(o);
    if (unknown) {
        return cli_fail(program, "--only %.100s: there is no such scene; --list shows all",
                        unknown);
    }
    if (o->method && strcmp(o->method, "network") != 0 && strcmp(o->method, "solver") != 0) {
        return cli_fail(program, "--method %.100s: allowed: network, solver", o->method);
    }
    if (o->list) {
        print_list(o);
        return 0;
    }
    return CLI_RUN;
}

int main(int count, char **arguments)
{
    options o = {.out = NULL};
    stress_rows *rows = NULL;
    ad_error error;
    if (ranks_begin(count, arguments, &o.ranks, &error) != AD_OK ||
        stress_rows_open(&rows, &error) != AD_OK) {
        return ranks_end(program, cli_fail_error(program, &error));
    }
    o.rows = stress_rows_of(rows, &o.count);
    int result = parse(count, arguments, &o);
    result = result == CLI_RUN ? run(&o) : result;
    stress_rows_free(rows);
    return ranks_end(program, result);
}
