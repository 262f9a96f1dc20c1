/* cpinn-cases: every case by a network and classically, in one table; see --help. */
#include "tools/files/file_bytes.h"
#include "tools/judge/cases.h"
#include "tools/judge/signals.h"
#include "tools/programs/cli.h"
#include "tools/programs/help.h"
#include "tools/programs/program_ranks.h"
#include "tools/programs/ranks_queue.h"
#include "tools/train/run.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char program[] = "cpinn-cases";

enum { PATHS_MAX = 512, PATH_BYTES = 4096 };

static const double grace = 20; /* s beyond the limit, for recording and a last step */

typedef struct options {
    cli_list operands;
    const char *out;
    double seconds;
    int threads;
    const ad_ranks *ranks; /* NULL: this process is by itself */
} options;

typedef struct table {
    const options *asked;
    int path_count;
    char *paths[PATHS_MAX]; /* owned */
    size_t count;
    cases_row *rows; /* [JUDGE_METHODS * path_count] */
    int width;       /* of the longest name */
} table;

/* ---- which cases --------------------------------------------------------------------------- */

static ad_status add_path(table *t, const char *path, ad_error *error)
{
    if (t->path_count == PATHS_MAX) {
        return ad_fail(error, AD_BAD_INPUT, "more than %d cases", PATHS_MAX);
    }
    t->paths[t->path_count] = strdup(path);
    return t->paths[t->path_count++] ? AD_OK
                                     : ad_fail(error, AD_NO_MEMORY, "out of memory for a path");
}

static int is_case(const struct dirent *entry)
{
    const char *dot = strrchr(entry->d_name, '.');
    return dot && dot != entry->d_name && strcmp(dot, ".yaml") == 0;
}

/* In the order of their names. */
static ad_status add_folder(table *t, const char *folder, ad_error *error)
{
    struct dirent **entries;
    char path[PATH_BYTES];
    int count = scandir(folder, &entries, is_case, alphasort);
    if (count < 0) {
        return ad_fail(error, AD_IO, "%s: %s", file_bytes_shown(folder), strerror(errno));
    }
    ad_status status = count > 0 ? AD_OK
                                 : ad_fail(error, AD_BAD_INPUT, "%s: holds no case, NAME.yaml",
                                           file_bytes_shown(folder));
    for (int i = 0; i < count; i++) {
        int length = snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
        if (status == AD_OK) {
            status = length < PATH_BYTES ? add_path(t, path, error)
                                         : ad_fail(error, AD_BAD_INPUT, "%s: is too long a path",
                                                   file_bytes_shown(path));
        }
        free(entries[i]);
    }
    free(entries);
    return status;
}

static ad_status find_cases(table *t, const options *o, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < o->operands.count; i++) {
        const char *path = o->operands.texts[i];
        struct stat about;
        if (stat(path, &about) != 0) {
            return ad_fail(error, AD_IO, "%s: %s", file_bytes_shown(path), strerror(errno));
        }
        status = S_ISDIR(about.st_mode) ? add_folder(t, path, error) : add_path(t, path, error);
    }
    t->width = (int)strlen("case");
    for (int i = 0; status == AD_OK && i < t->path_count; i++) {
        char name[JUDGE_NAME];
        judge_name_of_file(name, t->paths[i]);
        t->width = (int)strlen(name) > t->width ? (int)strlen(name) : t->width;
    }
    t->rows = calloc((size_t)(JUDGE_METHODS * t->path_count) + 1, sizeof *t->rows);
    return status != AD_OK || t->rows ? status
                                      : ad_fail(error, AD_NO_MEMORY, "out of memory for a table");
}

/* ---- running ------------------------------------------------------------------------------- */

static ad_status prepare_folder(const char *folder, ad_error *error)
{
    char path[PATH_BYTES];
    if (strlen(folder) == 0 || strlen(folder) > 3800) {
        return ad_fail(error, AD_BAD_INPUT, "--out: allowed: a path of 1 to 3800 bytes");
    }
    snprintf(path, sizeof path, "%s/cases.csv", folder);
    if (access(path, F_OK) == 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: there is a table already; choose another folder with --out",
                       file_bytes_shown(folder));
    }
    return run_make_folder(folder, error);
}

static judge_task task_of(const table *t, size_t row)
{
    return (judge_task){.path = t->paths[row / JUDGE_METHODS],
                        .method = (judge_method)(row % JUDGE_METHODS),
                        .threads = t->asked->threads,
                        .seconds = t->asked->seconds,
                        .patience = t->asked->seconds + grace};
}

static ad_status do_row(void *context, size_t index, ranks_result *result, ad_error *error)
{
    judge_row row;
    const judge_task task = task_of(context, index);
    ad_status status = judge_run(&task, &row, error);
    return status == AD_OK ? ranks_result_copy(result, sizeof row, &row, error) : status;
}

/* What a signal has cut short is no row. */
static ad_status take_row(void *context, size_t index, const ranks_result *result, ad_error *error)
{
    table *t = context;
    cases_row *row = &t->rows[t->count];
    const judge_task task = task_of(t, index);
    (void)error;
    if (!result->is_cut) {
        judge_name_of_file(row->name, task.path);
        row->method = task.method;
        memcpy(&row->result, result->bytes, sizeof row->result);
        cases_print_row(stdout, row, t->count > 0 ? row - 1 : NULL, t->width);
        fflush(stdout);
        t->count++;
    }
    return AD_OK;
}

static bool all_have_errors(const table *t)
{
    for (size_t i = 0; i < t->count; i++) {
        if (!(t->rows[i].result.errors[JUDGE_POSITION] >= 0)) {
            return false;
        }
    }
    return true;
}

static int run(table *t, const options *o)
{
    ad_error error = {AD_OK, ""};
    const bool writes = o->out && ad_ranks_is_first(o->ranks);
    int signal;
    ad_status status = find_cases(t, o, &error);
    status = status == AD_OK && writes ? prepare_folder(o->out, &error) : status;
    if (status != AD_OK) {
        ranks_queue_none(o->ranks);
        return cli_fail_error(program, &error);
    }
    const size_t count = JUDGE_METHODS * (size_t)t->path_count;
    const ranks_jobs jobs = {.count = count, .context = t, .work = do_row, .take = take_row};
    cases_print_heading(stdout, t->width);
    status = ranks_queue(o->ranks, &jobs, &signal, &error);
    const int stopped =
        signal ? ranks_queue_stopped(program, o->ranks, signal, t->count, count) : 0;
    if (status == AD_OK && writes && t->count > 0) {
        status = cases_write(t->rows, t->count, o->out, &error);
    }
    return status != AD_OK ? cli_fail_error(program, &error)
           : stopped       ? stopped
                           : !all_have_errors(t);
}

static int parse(int count, char **arguments, options *o)
{
    const char *last;
    const cli_program about = {program, "FOLDER|CONFIG.yaml", help_cases, NULL, &o->operands};
    const cli_option known[] = {{"--out", "DIR", CLI_TEXT, &o->out, 0, 0},
                                CLI_SECONDS(&o->seconds),
                                CLI_THREADS(&o->threads)};
    return cli_parse(&about, known, sizeof known / sizeof *known, count, arguments, &last);
}

int main(int count, char **arguments)
{
    options o = {.seconds = 600};
    table t = {.asked = &o};
    ad_error error;
    if (ranks_begin(count, arguments, &o.ranks, &error) != AD_OK) {
        return ranks_end(program, cli_fail_error(program, &error));
    }
    int result = parse(count, arguments, &o);
    if (result == CLI_RUN) {
        o.threads = ranks_threads(o.threads);
        signals_catch();
        result = run(&t, &o);
    }
    for (int i = 0; i < t.path_count; i++) {
        free(t.paths[i]);
    }
    free(t.rows);
    return ranks_end(program, result);
}
