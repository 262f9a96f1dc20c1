/* cpinn-stress: stiff and extreme scenes, each against the outcome that is expected; see --help. */
#include "tools/files/table_file.h"
#include "tools/judge/signals.h"
#include "tools/judge/stress/stress.h"
#include "tools/programs/cli.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char program[] = "cpinn-stress";

static const char summary[] =
    "Run stiff and extreme scenes, and compare what comes of each with what is expected: solved\n"
    "within a bound of error, refused or stopped with a reason, or trained and doubted by the\n"
    "program itself; never a wrong answer without a word, a crash or an endless run. By a "
    "network,\n"
    "and where that makes sense by the solver of cpinn-solve.";

static const char epilogue[] =
    "Every scene runs in a process of its own, with a time limit, on one thread. Errors are those\n"
    "of position, relative L2, unless the scene says otherwise.\n"
    "\n"
    "Ctrl-C ends the table and writes what there is.\n"
    "\n"
    "Exit status: 0 every scene as expected, 1 not, 2 bad arguments, 130 or 143 stopped by a "
    "signal.\n";

static const stress_group *const groups[] = {&stress_rods,  &stress_loads, &stress_motions,
                                             &stress_beams, &stress_pairs, &stress_inputs};
enum {
    GROUPS = sizeof groups / sizeof *groups,
    FOLDER = 64,
    COLUMNS = 9,
    SUBJECT = 32,
    ROWS_MAX = 512
};

typedef struct options {
    cli_list only;
    const char *out, *method;
    bool quick, is_long, list;
} options;

/* ---- which rows ---------------------------------------------------------------------------- */

/* The name itself, or its part before the slash. */
static bool named(const stress_row *row, const char *name)
{
    size_t length = strlen(name);
    return strncmp(row->name, name, length) == 0 &&
           (row->name[length] == '\0' || row->name[length] == '/');
}

static bool is_asked(const options *o, const stress_row *row, stress_method method)
{
    if (!row->expected[method].why ||
        (o->method && strcmp(o->method, stress_method_name(method)))) {
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
        for (int g = 0; g < GROUPS; g++) {
            for (int k = 0; k < groups[g]->count; k++) {
                found = found || named(&groups[g]->rows[k], o->only.texts[i]);
            }
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
    int length = snprintf(text, 32, "%s", stress_outcome_name(expected->outcome));
    if (expected->outcome == STRESS_SOLVED) {
        snprintf(text + length, 32 - (size_t)length, " %.0e", expected->bound);
    }
}

static void print_list_row(const options *o, const stress_row *row)
{
    for (int method = 0; method < STRESS_METHODS; method++) {
        char expected[32];
        if (is_asked(o, row, (stress_method)method)) {
            print_expected(&row->expected[method], expected);
            printf("  %-26s %-6s %-14s %s\n", row->name, stress_method_name((stress_method)method),
                   expected, row->expected[method].why);
        }
    }
}

static void print_list(const options *o)
{
    for (int g = 0; g < GROUPS; g++) {
        printf("%s%s\n", g ? "\n" : "", groups[g]->about);
        for (int k = 0; k < groups[g]->count; k++) {
            print_list_row(o, &groups[g]->rows[k]);
        }
    }
}

static void print_row(const stress_row *row, stress_method method, const stress_result *result)
{
    char expected[32], error[16] = "-";
    print_expected(&row->expected[method], expected);
    if (!isnan(result->error)) {
        snprintf(error, sizeof error, "%.1e", result->error);
    }
    printf("%-26s %-6s %-13s %-11s %8s %6.2f  %s\n", row->name, stress_method_name(method),
           expected, stress_outcome_name(result->outcome), error, result->seconds,
           result->as_expected ? "as expected" : "NOT AS EXPECTED");
    if (!result->as_expected) {
        printf("    expected: %s%s%s; got: %s\n", row->expected[method].text ? "\"" : "",
               row->expected[method].text ? row->expected[method].text : row->expected[method].why,
               row->expected[method].text ? "\"" : "", result->text);
    }
    fflush(stdout);
}

/* What the file of --out is made of. */
typedef struct record {
    size_t count;
    char subjects[ROWS_MAX][SUBJECT];
    const char *subject[ROWS_MAX], *scene[ROWS_MAX], *method[ROWS_MAX], *expected[ROWS_MAX],
        *outcome[ROWS_MAX], *verdict[ROWS_MAX];
    double bound[ROWS_MAX], error[ROWS_MAX], seconds[ROWS_MAX];
} record;

static void record_row(record *all, const stress_row *row, stress_method method,
                       const stress_result *result)
{
    const stress_expectation *expected = &row->expected[method];
    size_t i = all->count++;
    const char *slash = strchr(row->name, '/');
    snprintf(all->subjects[i], SUBJECT, "%.*s", (int)(slash - row->name), row->name);
    all->subject[i] = all->subjects[i];
    all->scene[i] = slash + 1;
    all->method[i] = stress_method_name(method);
    all->expected[i] = stress_outcome_name(expected->outcome);
    all->outcome[i] = stress_outcome_name(result->outcome);
    all->verdict[i] = result->as_expected ? "as expected" : "not as expected";
    all->bound[i] = expected->outcome == STRESS_SOLVED ? expected->bound : NAN;
    all->error[i] = result->error;
    all->seconds[i] = result->seconds;
}

static ad_status write_record(const record *all, const char *path, ad_error *error)
{
    static const char *const names[COLUMNS] = {"subject", "scene", "method",  "expected", "bound",
                                               "outcome", "error", "seconds", "verdict"};
    const double *const numbers[COLUMNS] = {NULL, NULL,       NULL,         NULL, all->bound,
                                            NULL, all->error, all->seconds, NULL};
    const char *const *const words[COLUMNS] = {all->subject,  all->scene, all->method,
                                               all->expected, NULL,       all->outcome,
                                               NULL,          NULL,       all->verdict};
    return table_write_words(path, names, numbers, words, COLUMNS, all->count, error);
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

/* What a signal has cut short is no row. */
static ad_status run_rows(const options *o, const char *folder, record *all, int *surprises,
                          ad_error *error)
{
    printf("%-26s %-6s %-13s %-11s %8s %6s  %s\n", "scene", "method", "expected", "outcome",
           "error", "s", "verdict");
    for (int g = 0; g < GROUPS; g++) {
        for (int k = 0; k < groups[g]->count; k++) {
            const stress_row *row = &groups[g]->rows[k];
            for (int method = 0; method < STRESS_METHODS; method++) {
                if (!is_asked(o, row, (stress_method)method)) {
                    continue;
                }
                stress_result result;
                ad_status status = stress_run(row, (stress_method)method, folder, &result, error);
                if (status != AD_OK || signals_caught()) {
                    return status;
                }
                print_row(row, (stress_method)method, &result);
                record_row(all, row, (stress_method)method, &result);
                *surprises += !result.as_expected;
            }
        }
    }
    printf("%zu rows, %d not as expected\n", all->count, *surprises);
    return AD_OK;
}

static int run(const options *o)
{
    static record all;
    char folder[FOLDER];
    int surprises = 0;
    ad_error error = {AD_OK, ""};
    signals_catch();
    if ((o->out && table_check_path(o->out, &error) != AD_OK) ||
        make_folder(folder, &error) != AD_OK) {
        return cli_fail_error(program, &error);
    }
    ad_status status = run_rows(o, folder, &all, &surprises, &error);
    if (status == AD_OK && o->out) {
        status = write_record(&all, o->out, &error);
    }
    remove_folder(folder);
    if (status != AD_OK) {
        return cli_fail_error(program, &error);
    }
    return signals_caught() ? 128 + signals_caught() : surprises > 0;
}

int main(int count, char **arguments)
{
    options o = {.out = NULL};
    const char *operand;
    const cli_program about = {program, NULL, summary, epilogue, NULL, NULL};
    const cli_option known[] = {
        {"--only", "NAME", CLI_LIST, &o.only, 0, 0,
         "a scene, or all of a subject, as in --only turns; may be repeated"},
        {"--method", "NAME", CLI_TEXT, &o.method, 0, 0, "pinn or solver alone"},
        {"--quick", NULL, CLI_FLAG, &o.quick, 0, 0, "those that take a moment, for the tests"},
        {"--long", NULL, CLI_FLAG, &o.is_long, 0, 0, "also those that take minutes"},
        {"--list", NULL, CLI_FLAG, &o.list, 0, 0, "print what is expected, and why, and stop"},
        {"--out", "FILE", CLI_TEXT, &o.out, 0, 0, "write the table as .csv or .h5"}};
    int result = cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &operand);
    if (result != CLI_RUN) {
        return result;
    }
    const char *unknown = unknown_name(&o);
    if (unknown) {
        return cli_fail(program, "--only %.100s: there is no such scene; --list shows all",
                        unknown);
    }
    if (o.method && strcmp(o.method, "pinn") != 0 && strcmp(o.method, "solver") != 0) {
        return cli_fail(program, "--method %.100s: allowed: pinn, solver", o.method);
    }
    if (o.list) {
        print_list(&o);
        return 0;
    }
    return run(&o);
}
