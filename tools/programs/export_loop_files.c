/* The files of an exported loop, compiled and compared before they are written. */
#include "tools/files/file_bytes.h"
#include "tools/programs/cli.h"
#include "tools/programs/export_loop.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/wait.h>
#include <unistd.h>

enum { TEXTS = 3 };
static const char *const endings[TEXTS] = {".c", "_selftest.c",
                                           ".h"}; /* the last needs the others */

/* What names within the C begin with. */
static const char *const taken[] = {
    "controller",     "estimator",  "gauss",     "gauss_newton",   "kinematic",
    "kinematic_look", "kinematics", "lanes",     "linear",         "linear_step",
    "look",           "loop",       "qp",        "regulator",      "sigma",
    "small",          "step",       "surrogate", "surrogate_step", "view"};

typedef void (*writer)(const export_loop *x, FILE *file);
static const writer writers[TEXTS] = {export_loop_write_source, export_loop_write_selftest,
                                      export_loop_write_header};

ad_status export_loop_name(const char *out, char name[EXPORT_LOOP_NAME + 1], ad_error *error)
{
    const char *slash = strrchr(out, '/'), *base = slash ? slash + 1 : out;
    size_t count = strlen(base);
    count -= count > 2 && strcmp(base + count - 2, ".c") == 0 ? 2 : 0;
    bool ok = count > 0 && count <= EXPORT_LOOP_NAME && !isdigit((unsigned char)base[0]);
    for (size_t i = 0; i < count; i++) {
        ok = ok && (base[i] == '_' || isalnum((unsigned char)base[i]));
    }
    if (!ok) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "--c %s: functions cannot be called %.*s; allowed: up to %d letters, digits "
                       "and _, the first no digit",
                       out, (int)count, base, EXPORT_LOOP_NAME);
    }
    snprintf(name, EXPORT_LOOP_NAME + 1, "%.*s", (int)count, base);
    for (size_t i = 0; i < sizeof taken / sizeof *taken; i++) {
        if (strcasecmp(name, taken[i]) == 0) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "--c %s: the C has functions of its own called %s_...; allowed: any "
                           "other name",
                           out, name);
        }
    }
    return AD_OK;
}

static ad_status write_text(const export_loop *x, int which, const char *path, ad_error *error)
{
    char *text = NULL;
    size_t size;
    FILE *to = open_memstream(&text, &size);
    if (to) {
        writers[which](x, to);
    }
    const bool bad = !to || ferror(to);
    ad_status status = (to && fclose(to) != 0) || bad
                           ? ad_fail(error, AD_NO_MEMORY, "out of memory for a file of C")
                           : file_bytes_write(path, text, size, error);
    free(text);
    return status;
}

/* The files in a folder, or at OUT without its ending. */
static ad_status write_texts(const export_loop *x, const char *base, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < TEXTS && status == AD_OK; i++) {
        char path[4096];
        snprintf(path, sizeof path, "%s%s", base, endings[i]);
        status = write_text(x, i, path, error);
    }
    return status;
}

/* AD_IO: no compiler, or it refuses; AD_BAD_PROGRAM: another result. `said`: its line. */
static ad_status compile_and_run(const export_loop *x, const char *folder, char said[256],
                                 ad_error *error)
{
    char command[512];
    snprintf(command, sizeof command,
             "cd '%s' && { cc -std=c11 -o run %s.c %s_selftest.c -lm 2>&1 || exit 77; } && "
             "./run",
             folder, x->name, x->name);
    fflush(stdout);
    FILE *from = popen(command, "r");
    if (!from) {
        return ad_fail(error, AD_IO, "the compiler cannot be started: %s", strerror(errno));
    }
    if (!fgets(said, 256, from)) {
        snprintf(said, 256, "it says nothing");
    }
    said[strcspn(said, "\n")] = '\0';
    while (fgetc(from) != EOF) {
    }
    const int status = pclose(from), code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
    const bool ran = code != 77 && code != 126 && code != 127;
    return code == 0 ? AD_OK
                     : ad_fail(error, ran ? AD_BAD_PROGRAM : AD_IO, "%s%s",
                               ran ? "the self-test of the C fails: " : "", said);
}

static ad_status check(const export_loop *x, char said[256], ad_error *error)
{
    char folder[] = "/tmp/cpinn_export_XXXXXX", base[128], path[160];
    if (!mkdtemp(folder)) {
        return ad_fail(error, AD_IO, "%s: %s", folder, strerror(errno));
    }
    snprintf(base, sizeof base, "%s/%s", folder, x->name);
    ad_status status = write_texts(x, base, error);
    status = status == AD_OK ? compile_and_run(x, folder, said, error) : status;
    for (int i = 0; i < TEXTS; i++) {
        snprintf(path, sizeof path, "%s%s", base, endings[i]);
        unlink(path);
    }
    snprintf(path, sizeof path, "%s/run", folder);
    unlink(path);
    rmdir(folder);
    return status;
}

ad_status export_loop_write(export_loop *x, const char *out, bool force, char said[256],
                            ad_error *error)
{
    char base[4000], path[4096];
    const size_t length = strlen(out);
    const bool has_ending = length > 2 && strcmp(out + length - 2, ".c") == 0;
    snprintf(base, sizeof base, "%.*s", (int)(length - (has_ending ? 2 : 0)), out);
    ad_status status = AD_OK;
    for (int i = 0; i < TEXTS && status == AD_OK; i++) {
        snprintf(path, sizeof path, "%s%s", base, endings[i]);
        status = file_bytes_check(path, error);
        if (status == AD_OK && !force && access(path, F_OK) == 0) {
            status = ad_fail(error, AD_IO, "%s: there is such a file already; --force replaces it",
                             file_bytes_shown(path));
        }
    }
    status = status == AD_OK ? export_loop_record(x, error) : status;
    if (status != AD_OK) {
        return status;
    }
    status = check(x, said, error);
    if (status == AD_IO) {
        cli_warn("cpinn-control", "the C has not been compiled and checked: %s", error->message);
        snprintf(said, 256, "not compiled");
        status = AD_OK;
    }
    return status == AD_OK ? write_texts(x, base, error) : status;
}
