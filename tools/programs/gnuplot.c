#include "tools/programs/gnuplot.h"

#include "tools/files/file_bytes.h"

#include <errno.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static void print_quoted(FILE *file, const char *text)
{
    fputc('\'', file);
    for (; *text; text++) {
        if (*text == '\'') {
            fputc('\'', file);
        }
        fputc((unsigned char)*text < ' ' ? ' ' : *text, file);
    }
    fputc('\'', file);
}

static void print_output(FILE *file, const char *name, const char *ending)
{
    char output[GNUPLOT_NAME];
    snprintf(output, sizeof output, "%s.%s", name, ending);
    fprintf(file, "set output ");
    print_quoted(file, output);
    fputc('\n', file);
}

static ad_status print_script(FILE *file, const gnuplot_picture *what, ad_error *error)
{
    fprintf(file,
            "%s# In this folder: gnuplot %s.gp\n\nset terminal svg size %d,%d dynamic font "
            "'Helvetica,13' background rgb "
            "'white'\n",
            what->about, what->name, what->width, what->height);
    print_output(file, what->name, "svg");
    fprintf(file, "set encoding utf8\n");
    fprintf(file, "set border 3 lw 1 lc rgb '#444444'\nset tics nomirror out scale 0.7\n"
                  "set grid xtics ytics lt 1 lw 0.6 lc rgb '#DDDDDD'\n\n");
    ad_status status = what->print(file, what->context, error);
    fprintf(file, "\nset terminal pngcairo size %d,%d fontscale 1.9 linewidth 1.9 pointscale 1.8\n",
            2 * what->width, 2 * what->height);
    print_output(file, what->name, "png");
    fprintf(file, "replot\nunset output\n");
    return status;
}

ad_status gnuplot_write(const gnuplot_picture *what, const char *folder, ad_error *error)
{
    char *text = NULL, path[4096];
    size_t size = 0;
    snprintf(path, sizeof path, "%s/%s.gp", folder, what->name);
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %s", path);
    }
    ad_status status = print_script(file, what, error);
    if (fclose(file) != 0 && status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %s", path);
    }
    if (status == AD_OK) {
        status = file_bytes_write(path, text, size, error);
    }
    free(text);
    return status;
}

ad_status gnuplot_beside(const char *path, gnuplot_place *place, ad_error *error)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    size_t length = dot ? (size_t)(dot - name) : strlen(name);
    size_t folder = slash ? (size_t)(slash - path) : 0;
    if (length > GNUPLOT_NAME - 9 || folder >= sizeof place->folder) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%s: the name is too long for a picture; allowed: %d bytes without ending",
                       path, GNUPLOT_NAME - 9);
    }
    snprintf(place->name, sizeof place->name, "%.*s", (int)length, name);
    snprintf(place->folder, sizeof place->folder, "%.*s", (int)folder, path);
    if (!slash || folder == 0) {
        snprintf(place->folder, sizeof place->folder, "%s", slash ? "/" : ".");
    }
    return AD_OK;
}

/* ---- drawing ------------------------------------------------------------------------------- */

enum { NOT_FOUND = 127 }; /* says the shell */

/* Reads to the end; keeps the line of gnuplot that says what is wrong, "...: line 3: ...". */
static void read_complaint(int from, char complaint[160])
{
    char text[4096];
    size_t length = 0;
    ssize_t got;
    while ((got = read(from, text + length, sizeof text - 1 - length)) > 0) {
        length += (size_t)got;
        length = length < sizeof text - 1 ? length : sizeof text / 2;
    }
    text[length] = '\0';
    char *line = strstr(text, " line ");
    line = line ? line + 1 : text;
    while (*line == '\n') {
        line++;
    }
    line[strcspn(line, "\n")] = '\0';
    snprintf(complaint, 160, "%.159s", line);
}

static int run_gnuplot(const char *folder, const char *script, char complaint[160])
{
    const char *const arguments[] = {"sh",   "-c",   "cd -- \"$0\" && exec gnuplot \"$1\"",
                                     folder, script, NULL};
    posix_spawn_file_actions_t files;
    int pipes[2], status = 0;
    pid_t child;
    complaint[0] = '\0';
    if (pipe(pipes) != 0) {
        return -1;
    }
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addclose(&files, pipes[0]);
    posix_spawn_file_actions_adddup2(&files, pipes[1], STDERR_FILENO);
    const bool runs =
        posix_spawn(&child, "/bin/sh", &files, NULL, (char *const *)arguments, environ) == 0;
    posix_spawn_file_actions_destroy(&files);
    close(pipes[1]);
    if (runs) {
        read_complaint(pipes[0], complaint);
        while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
        }
    }
    close(pipes[0]);
    return runs && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

ad_status gnuplot_draw(const char *name, const char *folder, ad_error *error)
{
    char script[GNUPLOT_NAME], complaint[160];
    snprintf(script, sizeof script, "./%s.gp", name); /* a name may begin with - */
    int status = run_gnuplot(folder, script, complaint);
    if (status == NOT_FOUND) {
        return ad_fail(
            error, AD_IO,
            "no picture, gnuplot is not installed; once it is: (cd %.300s && gnuplot %s)", folder,
            script + 2);
    }
    return status == 0
               ? AD_OK
               : ad_fail(error, AD_IO,
                         "no picture, gnuplot failed: %s; to see: (cd %.200s && gnuplot %s)",
                         *complaint ? complaint : "it says nothing", folder, script);
}
