#include "tools/emit/export_compile.h"

#include "autodiff/ad.h"
#include "autodiff/process.h"
#include "tools/files/file_bytes.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PATH_ROOM = 4096, FILES_MAX = 5, WORDS_MAX = 16 };

const char *const export_endings[EXPORT_TEXTS] = {".c", ".h", "_selftest.c"};

typedef struct folder {
    char *name, made[64], said[64];
    int count;
    char file[FILES_MAX][288];
} folder;

static bool make(folder *f, int count, const export_file *files)
{
    bool ok = count <= FILES_MAX && mkdtemp(f->name);
    snprintf(f->made, sizeof f->made, "%s/made", f->name);
    snprintf(f->said, sizeof f->said, "%s/said", f->name);
    for (f->count = 0; ok && f->count < count; f->count++) {
        const export_file *file = &files[f->count];
        snprintf(f->file[f->count], sizeof *f->file, "%s/%s", f->name, file->name);
        FILE *to = fopen(f->file[f->count], "wb");
        ok = to && fwrite(file->text, 1, file->size, to) == file->size;
        ok = to && fclose(to) == 0 && ok;
    }
    return ok;
}

static void drop(const folder *f)
{
    for (int i = 0; i < f->count; i++) {
        unlink(f->file[i]);
    }
    unlink(f->made);
    unlink(f->said);
    rmdir(f->name);
}

/* Of a program, to f->said. AD_IO: it cannot be started; AD_BAD_PROGRAM: it fails. */
static ad_status wait_for(char *const *arguments, const folder *f, ad_error *error)
{
    pid_t child;
    int how = 0;
    const int failure = ad_start_process(arguments, f->said, &child);
    if (failure) {
        return ad_fail(error, AD_IO, "%s: %s", arguments[0], strerror(failure));
    }
    while (waitpid(child, &how, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(how) && WEXITSTATUS(how) == 0 ? AD_OK : AD_BAD_PROGRAM;
}

/* The first line of what was said. */
static ad_status complain(const folder *f, ad_status status, const char *whose, ad_error *error)
{
    unsigned char *bytes = NULL;
    size_t size, whole;
    char *text =
        file_bytes_read(f->said, 0, &bytes, &size, &whole, NULL) == AD_OK ? (char *)bytes : NULL;
    const int length = text ? (int)strcspn(text, "\n") : 0;
    ad_fail(error, status, "%s%.*s", whose, length > 0 ? length : 16,
            length > 0 ? text : "it says nothing");
    free(bytes);
    return status;
}

static ad_status compile(const export_compiler *by, const folder *f, ad_error *error)
{
    char path[PATH_ROOM], words[512], last[16], *rest = NULL, beside[] = "-I", to[] = "-o";
    char *arguments[WORDS_MAX + FILES_MAX + 7] = {path};
    int count = 1;
    if (!ad_find_program(by->name, path, sizeof path)) {
        return ad_fail(error, AD_IO, "there is no compiler, %s", by->name);
    }
    snprintf(words, sizeof words, "%s", by->options);
    snprintf(last, sizeof last, "%s", by->last ? by->last : "");
    for (char *word = strtok_r(words, " ", &rest); word && count <= WORDS_MAX;
         word = strtok_r(NULL, " ", &rest)) {
        arguments[count++] = word;
    }
    arguments[count++] = beside;
    arguments[count++] = f->name;
    arguments[count++] = to;
    arguments[count++] = (char *)f->made;
    for (int i = 0; i < f->count; i++) {
        if (strcmp(strrchr(f->file[i], '.'), ".c") == 0) {
            arguments[count++] = (char *)f->file[i];
        }
    }
    arguments[count++] = *last ? last : NULL;
    const ad_status status = wait_for(arguments, f, error);
    snprintf(words, sizeof words, "%s does not compile it: ", by->name);
    return status == AD_BAD_PROGRAM ? complain(f, AD_IO, words, error) : status;
}

ad_status export_compile(const export_compiler *by, int count, const export_file *files, bool run,
                         char **bytes, size_t *size, ad_error *error)
{
    char name[] = "/tmp/cpinn_export_XXXXXX";
    folder f = {.name = name};
    size_t whole;
    unsigned char *result = NULL;
    *bytes = NULL;
    ad_status status = make(&f, count, files)
                           ? compile(by, &f, error)
                           : ad_fail(error, AD_IO, "%s: %s", f.name, strerror(errno));
    if (status == AD_OK && run) {
        char *const arguments[] = {f.made, NULL};
        status = wait_for(arguments, &f, error);
        if (status == AD_BAD_PROGRAM) {
            complain(&f, status, "the self-test of the C fails: ", error);
        }
    }
    if (status == AD_OK) {
        status = file_bytes_read(run ? f.said : f.made, 0, &result, size, &whole, error);
    }
    *bytes = (char *)result;
    drop(&f);
    return status;
}

/* ---- the three texts ------------------------------------------------------------------------ */

ad_status export_texts_write_all(export_texts texts, export_writer *writer, void *of,
                                 ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < EXPORT_TEXTS && status == AD_OK; i++) {
        status = export_text_write(&texts[i], i, writer, of, error);
    }
    return status;
}

void export_texts_free(export_texts texts)
{
    for (int i = 0; i < EXPORT_TEXTS; i++) {
        free(texts[i].bytes);
        texts[i].bytes = NULL;
    }
}

ad_status export_texts_check(const export_texts texts, const char *name, const char *standard,
                             char **said, ad_error *error)
{
    export_file files[EXPORT_TEXTS];
    char options[32];
    size_t size;
    for (int i = 0; i < EXPORT_TEXTS; i++) {
        files[i] = (export_file){.text = texts[i].bytes, .size = texts[i].size};
        snprintf(files[i].name, sizeof files[i].name, "%s%s", name, export_endings[i]);
    }
    snprintf(options, sizeof options, "-std=%s", standard);
    const export_compiler cc = {"cc", options, "-lm"};
    return export_compile(&cc, EXPORT_TEXTS, files, true, said, &size, error);
}
