#include "tools/run.h"

#include "tools/file_bytes.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

ad_status run_name(run_folder *run, const char *path, ad_error *error)
{
    *run = (run_folder){.rows = NULL};
    size_t length = strlen(path);
    while (length > 1 && path[length - 1] == '/') {
        length--;
    }
    if (length == 0 || length >= sizeof run->path) {
        return ad_fail(error, AD_BAD_INPUT, "--out: a path of %zu bytes; 1 to %zu are allowed",
                       length, sizeof run->path - 1);
    }
    memcpy(run->path, path, length);
    snprintf(run->checkpoint, sizeof run->checkpoint, "%s/checkpoint.h5", run->path);
    snprintf(run->history, sizeof run->history, "%s/history.csv", run->path);
    snprintf(run->config, sizeof run->config, "%s/config.yaml", run->path);
    return AD_OK;
}

ad_status run_check_new(const run_folder *run, ad_error *error)
{
    const char *const files[] = {run->checkpoint, run->history, run->config};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        if (access(files[i], F_OK) == 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: there is a run already (%s); continue it with --resume, or choose "
                           "another folder with --out",
                           file_bytes_shown(run->path), strrchr(files[i], '/') + 1);
        }
    }
    return AD_OK;
}

ad_status run_make_folder(const run_folder *run, ad_error *error)
{
    const char *path = run->path;
    char part[sizeof run->path];
    size_t length = strlen(path);
    for (size_t i = 1; i <= length; i++) {
        if (path[i] != '/' && path[i] != '\0') {
            continue;
        }
        memcpy(part, path, i);
        part[i] = '\0';
        if (mkdir(part, 0777) != 0 && errno != EEXIST) {
            return ad_fail(error, AD_IO, "%s: the folder cannot be made: %s",
                           file_bytes_shown(part), strerror(errno));
        }
    }
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISDIR(info.st_mode)) {
        return ad_fail(error, AD_IO, "%s: is not a folder; choose another with --out",
                       file_bytes_shown(path));
    }
    return AD_OK;
}

/* Header and rows so far as one file; what an interrupted process wrote beyond the checkpoint goes.
 */
static ad_status write_history(const run_folder *run, const history *h, ad_error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %s", run->history);
    }
    history_print(h, -1, file);
    for (size_t row = 0; row < h->count; row++) {
        history_print(h, (long)row, file);
    }
    fclose(file);
    ad_status status = file_bytes_write(run->history, text, size, 1, error);
    free(text);
    return status;
}

ad_status run_begin(run_folder *run, const experiment *e, const history *h, ad_error *error)
{
    char *yaml = experiment_yaml(e);
    if (!yaml) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %s", run->config);
    }
    ad_status status = file_bytes_write(run->config, yaml, strlen(yaml), 1, error);
    free(yaml);
    if (status == AD_OK) {
        status = write_history(run, h, error);
    }
    if (status == AD_OK) {
        run->rows = fopen(run->history, "a");
        run->rows_written = h->count;
        if (!run->rows) {
            return ad_fail(error, AD_IO, "%s: %s", run->history, strerror(errno));
        }
    }
    return status;
}

ad_status run_append(run_folder *run, const history *h, ad_error *error)
{
    if (run->rows_written == h->count) {
        return AD_OK;
    }
    while (run->rows_written < h->count) {
        history_print(h, (long)run->rows_written++, run->rows);
    }
    if (fflush(run->rows) != 0) {
        return ad_fail(error, AD_IO, "%s: %s", run->history, strerror(errno));
    }
    return AD_OK;
}

void run_end(run_folder *run)
{
    if (run->rows) {
        fclose(run->rows);
        run->rows = NULL;
    }
}

/* Lines that may differ between a checkpoint and the experiment that continues it; decay_steps
 * follows the length of the stage unless it is given. */
static bool may_differ(const char *section, const char *line)
{
    const char *key = line + strspn(line, " -");
    bool lengths = strncmp(section, "training:", 9) == 0 &&
                   (strncmp(key, "steps:", 6) == 0 || strncmp(key, "decay_steps:", 12) == 0);
    return lengths || strncmp(section, "checkpoint:", 11) == 0 ||
           strncmp(section, "output:", 7) == 0 || line[0] == '#';
}

static const char *next_line(const char *text)
{
    const char *end = strchr(text, '\n');
    return end ? end + 1 : text + strlen(text);
}

/* The lines at `theirs` and `ours`, without what they are indented by. */
static ad_status differs(const run_folder *run, const char *theirs, const char *ours,
                         ad_error *error)
{
    enum { SHOWN = 80 };
    theirs += strspn(theirs, " ");
    ours += strspn(ours, " ");
    size_t there = strcspn(theirs, "\n"), here = strcspn(ours, "\n");
    return ad_fail(error, AD_BAD_INPUT,
                   "%s: belongs to another experiment: there '%.*s', now '%.*s'; use the same "
                   "experiment, or another folder with --out",
                   file_bytes_shown(run->checkpoint), (int)(there < SHOWN ? there : SHOWN), theirs,
                   (int)(here < SHOWN ? here : SHOWN), ours);
}

ad_status run_check_same(const run_folder *run, const experiment *e, const checkpoint *file,
                         ad_error *error)
{
    const char *theirs;
    ad_status status = checkpoint_get_text(file, "scene/yaml", &theirs, error);
    char *ours = status == AD_OK ? experiment_yaml(e) : NULL;
    if (status == AD_OK && !ours) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory while comparing experiments");
    }
    const char *a = theirs, *b = ours, *section = "";
    while (status == AD_OK && (*a || *b)) {
        size_t a_length = strcspn(a, "\n"), b_length = strcspn(b, "\n");
        section = *b && *b != ' ' ? b : section;
        bool same = a_length == b_length && memcmp(a, b, a_length) == 0;
        if (!same && !may_differ(section, b)) {
            status = differs(run, a, b, error);
        }
        a = next_line(a);
        b = next_line(b);
    }
    free(ours);
    return status;
}
