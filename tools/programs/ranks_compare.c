/* Whether all ranks are about to do the same. */
#include "tools/files/checkpoint.h"
#include "tools/files/file_bytes.h"
#include "tools/programs/cli.h"
#include "tools/programs/program_ranks.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { SHOWN = 120 }; /* bytes of a line in a message */

/* What each rank says to all, as numbers. */
typedef struct said {
    double status; /* AD_OK, or why it cannot begin */
    double differs;
    size_t at;      /* where the line begins that differs in the text of rank 0 */
    char text[512]; /* its own line, or the error */
} said;

enum { SAID = sizeof(said) / sizeof(double) };

void ranks_name_file(FILE *to, const char *path)
{
    unsigned char *bytes = NULL;
    size_t size = 0, all = 0;
    if (file_bytes_read(path, 0, &bytes, &size, &all, NULL) == AD_OK) {
        fprintf(to, "%s (%zu bytes, hash %016" PRIx64 ")", file_bytes_name(path), size,
                checkpoint_hash(CHECKPOINT_HASH_START, bytes, size));
    } else {
        fprintf(to, "%s (no file)", file_bytes_name(path));
    }
    free(bytes);
}

/* The text of rank 0 on all ranks; NULL: out of memory. */
static char *text_of_first(const ad_ranks *ranks, const char *text)
{
    double size = (double)(strlen(text) + 1);
    ad_ranks_first(ranks, 1, &size);
    const size_t numbers = (size_t)size / sizeof(double) + 1;
    double *first = calloc(numbers, sizeof *first);
    if (first && ranks->rank == 0) {
        memcpy(first, text, (size_t)size);
    }
    if (first) {
        ad_ranks_first(ranks, numbers, first);
    }
    return (char *)first;
}

static size_t first_difference(const char *a, const char *b)
{
    size_t line = 0;
    for (size_t i = 0; a[i] == b[i] && a[i]; i++) {
        line = a[i] == '\n' ? i + 1 : line;
    }
    return line;
}

/* The line that begins there. */
static const char *line_at(const char *text, char line[SHOWN])
{
    snprintf(line, SHOWN, "%.*s", (int)strcspn(text, "\n"), text);
    return *line ? line + strspn(line, " ") : "nothing";
}

static ad_status judge(const ad_ranks *ranks, const said *all, const char *first, ad_error *error)
{
    char here[SHOWN], there[SHOWN];
    for (int i = 0; i < ranks->count; i++) {
        if (all[i].status != AD_OK) {
            return ad_fail(error, (ad_status)all[i].status, "rank %d: %s", i, all[i].text);
        }
    }
    for (int i = 0; i < ranks->count; i++) {
        if (all[i].differs != 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "rank %d is about to do something else than rank 0: '%s' there, '%s' "
                           "on rank 0; allowed: the same program, options and files on all ranks",
                           i, line_at(all[i].text, there), line_at(first + all[i].at, here));
        }
    }
    return AD_OK;
}

ad_status ranks_compare(const ad_ranks *ranks, ad_status status, const char *text, ad_error *error)
{
    if (!ranks) {
        return status;
    }
    size_t bounds[AD_RANKS_MAX + 1];
    const char *own = status == AD_OK ? text : "";
    char *first = text_of_first(ranks, own);
    said *all = calloc((size_t)ranks->count, sizeof *all);
    if (!first || !all) {
        free(first);
        free(all);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d ranks", ranks->count);
    }
    said *self = &all[ranks->rank];
    self->status = status;
    self->differs = strcmp(first, own) != 0;
    self->at = first_difference(first, own);
    snprintf(self->text, sizeof self->text, "%s",
             status == AD_OK ? own + self->at : error->message);
    for (int i = 0; i <= ranks->count; i++) {
        bounds[i] = (size_t)i * SAID;
    }
    ranks->gather(ranks->context, bounds, (double *)all);
    status = status == AD_OK ? judge(ranks, all, first, error) : status;
    free(first);
    free(all);
    return status;
}

/* ---- arguments ------------------------------------------------------------------------------- */

/* A file, or the checkpoint of a run, is named with what is in it. */
static void name_operand(FILE *to, const char *argument)
{
    char path[4096];
    struct stat about;
    const bool is_there = stat(argument, &about) == 0;
    const bool is_folder = is_there && S_ISDIR(about.st_mode);
    snprintf(path, sizeof path, "%s%s", argument, is_folder ? "/checkpoint.h5" : "");
    if (is_folder || (is_there && S_ISREG(about.st_mode))) {
        ranks_name_file(to, path);
    } else {
        fputs(argument, to);
    }
}

/* A line for each option. Threads may be other ones on each rank, and what is written is the first
 * rank's. */
static void describe(FILE *to, int count, char **arguments)
{
    fprintf(to, "%s %s", count > 0 ? file_bytes_name(arguments[0]) : "", cli_version());
    for (int i = 1; i < count; i++) {
        const char *now = arguments[i];
        const bool written = strcmp(now, "--out") == 0 || strcmp(now, "--json") == 0;
        if (strcmp(now, "--threads") == 0) {
            i++;
        } else if (strncmp(now, "--threads=", strlen("--threads=")) != 0) {
            fputc(*now == '-' ? '\n' : ' ', to);
            name_operand(to, now);
        }
        if (written && i + 1 < count) {
            fprintf(to, " %s", arguments[++i]);
        }
    }
    fputc('\n', to);
}

ad_status ranks_compare_arguments(const ad_ranks *ranks, int count, char **arguments,
                                  ad_error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (file) {
        describe(file, count, arguments);
    }
    const bool made = file && fclose(file) == 0;
    ad_status status =
        made ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for what ranks compare");
    status = ranks_compare(ranks, status, text, error);
    free(text);
    return status;
}
