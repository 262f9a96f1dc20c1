/* Movies by ffmpeg in a process of its own: raw images go in through a pipe. */
#include "tools/picture/images.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static const char program[] = "ffmpeg";

struct image_movie {
    char *path, *partial;
    size_t image; /* bytes */
    pid_t child;  /* 0: none runs */
    int to;       /* its standard input; -1: closed */
    FILE *said;   /* its standard error, without a name */
    struct sigaction before;
    bool ignores; /* SIGPIPE, since the encoder may end before its input does */
};

enum { OPTIONS = 8 };

/* By the ending of a file. The colours of a .gif are those of each image, so that the encoder need
 * not keep all of them. */
static const struct format {
    const char *ending, *options[OPTIONS];
} formats[] = {
    {".mp4", {"-pix_fmt", "yuv420p", "-c:v", "libx264", "-crf", "20", "-f", "mp4"}},
    {".webm", {"-pix_fmt", "yuv420p", "-c:v", "libvpx-vp9", "-crf", "30", "-f", "webm"}},
    {".gif",
     {"-filter_complex",
      "split[a][b];[a]palettegen=stats_mode=single[c];[b][c]paletteuse=new=1:dither=none", "-loop",
      "0", "-f", "gif"}}};

static const struct format *format_of(const char *path)
{
    const char *dot = strrchr(path, '.');
    int k = 2;
    while (k > 0 && !(dot && strcmp(dot, formats[k].ending) == 0)) {
        k--;
    }
    return &formats[k];
}

/* With its standard input from the pipe. Returns 0, or errno: ENOENT where there is no such
 * program.
 */
static int spawn_encoder(image_movie *movie, int from, const char *size, const char *rate,
                         const char *output)
{
    const char *arguments[20 + OPTIONS] = {
        program, "-nostdin",    "-loglevel", "error",      "-y", "-f", "rawvideo", "-pixel_format",
        "rgb24", "-video_size", size,        "-framerate", rate, "-i", "pipe:0"};
    const struct format *format = format_of(movie->path);
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t pipes;
    int count = 15;
    for (int k = 0; k < OPTIONS && format->options[k]; k++) {
        arguments[count++] = format->options[k];
    }
    arguments[count] = output;
    sigemptyset(&pipes);
    sigaddset(&pipes, SIGPIPE);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setsigdefault(&attributes, &pipes);
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, from, STDIN_FILENO);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files, movie->said ? fileno(movie->said) : STDOUT_FILENO,
                                     STDERR_FILENO);
    const int why = posix_spawnp(&movie->child, program, &files, &attributes,
                                 (char *const *)arguments, environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    movie->child = why == 0 ? movie->child : 0;
    return why;
}

/* In a process group of its own, since Ctrl-C is for the program, which ends this. */
static ad_status start(image_movie *movie, int width, int height, int per_second, ad_error *error)
{
    int input[2];
    char size[32], rate[16], output[4200];
    snprintf(size, sizeof size, "%dx%d", width, height);
    snprintf(rate, sizeof rate, "%d", per_second);
    snprintf(output, sizeof output, "file:%s", movie->partial);
    if (pipe(input) != 0) {
        return ad_fail(error, AD_IO, "%s cannot be started: %s", program, strerror(errno));
    }
    fcntl(input[0], F_SETFD, FD_CLOEXEC);
    fcntl(input[1], F_SETFD, FD_CLOEXEC);
    const int why = spawn_encoder(movie, input[0], size, rate, output);
    close(input[0]);
    movie->to = input[1];
    if (why == ENOENT) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%.200s: movies need the encoder %s, which is not installed "
                       "(apt-get install %s)",
                       movie->path, program, program);
    }
    return why == 0 ? AD_OK
                    : ad_fail(error, AD_IO, "%s cannot be started: %s", program, strerror(why));
}

ad_status image_movie_begin(const char *path, int width, int height, int per_second,
                            image_movie **result, ad_error *error)
{
    image_movie *movie = calloc(1, sizeof *movie);
    const size_t length = strlen(path);
    struct sigaction ignore;
    if (movie) {
        movie->to = -1;
        movie->image = 3 * (size_t)width * (size_t)height;
        movie->path = strdup(path);
        movie->partial = malloc(length + sizeof ".partial");
    }
    if (!movie || !movie->path || !movie->partial) {
        image_movie_free(movie);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a movie");
    }
    snprintf(movie->partial, length + sizeof ".partial", "%s.partial", path);
    movie->said = tmpfile();
    memset(&ignore, 0, sizeof ignore);
    ignore.sa_handler = SIG_IGN;
    movie->ignores = sigaction(SIGPIPE, &ignore, &movie->before) == 0;
    ad_status status = start(movie, width, height, per_second, error);
    if (status != AD_OK) {
        image_movie_free(movie);
        return status;
    }
    *result = movie;
    return AD_OK;
}

/* Waits for its end; whether it was a good one. */
static bool encoder_ends(image_movie *movie)
{
    int status = -1;
    if (movie->to >= 0) {
        close(movie->to);
        movie->to = -1;
    }
    while (movie->child > 0 && waitpid(movie->child, &status, 0) < 0 && errno == EINTR) {
    }
    movie->child = 0;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/* With the first line that it said. */
static ad_status encoder_failed(const image_movie *movie, ad_error *error)
{
    char line[200] = "";
    if (movie->said) {
        rewind(movie->said);
        while (fgets(line, sizeof line, movie->said) && *line == '\n') {
        }
    }
    line[strcspn(line, "\n")] = '\0';
    ad_one_line(line);
    return ad_fail(error, AD_NOT_WRITTEN, "%.200s: not written, %s failed: %s", movie->path,
                   program, *line ? line : "it says nothing");
}

ad_status image_movie_add(image_movie *movie, const unsigned char *rgb, ad_error *error)
{
    for (size_t done = 0; done < movie->image;) {
        const ssize_t put = write(movie->to, rgb + done, movie->image - done);
        if (put < 0 && errno != EINTR) {
            encoder_ends(movie);
            return encoder_failed(movie, error);
        }
        done += put > 0 ? (size_t)put : 0;
    }
    return AD_OK;
}

ad_status image_movie_end(image_movie *movie, ad_error *error)
{
    if (!encoder_ends(movie) || access(movie->partial, F_OK) != 0) {
        return encoder_failed(movie, error);
    }
    return rename(movie->partial, movie->path) == 0
               ? AD_OK
               : ad_fail(error, AD_NOT_WRITTEN, "%.200s: not written: %s", movie->path,
                         strerror(errno));
}

void image_movie_free(image_movie *movie)
{
    if (!movie) {
        return;
    }
    if (movie->child > 0) {
        kill(movie->child, SIGKILL);
        encoder_ends(movie);
    }
    if (movie->to >= 0) {
        close(movie->to);
    }
    if (movie->partial && movie->ignores) {
        unlink(movie->partial);
    }
    if (movie->ignores) {
        sigaction(SIGPIPE, &movie->before, NULL);
    }
    if (movie->said) {
        fclose(movie->said);
    }
    free(movie->path);
    free(movie->partial);
    free(movie);
}
