/* cpinn-show: a picture is drawn by cpinn-picture, which lies beside this program. */
#include "tools/programs/show_source.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

bool show_is_picture(const char *path)
{
    static const char *const endings[] = {".svg", ".png", ".gif", ".mp4", ".webm"};
    const char *dot = path ? strrchr(path, '.') : NULL;
    for (int k = 0; dot && k < 5; k++) {
        if (strcmp(dot, endings[k]) == 0) {
            return true;
        }
    }
    return false;
}

/* The data as standard input, from a file without a name. */
static bool give(const char *data, size_t size)
{
    FILE *file = tmpfile();
    return file && fwrite(data, 1, size, file) == size && fflush(file) == 0 &&
           lseek(fileno(file), 0, SEEK_SET) == 0 && dup2(fileno(file), STDIN_FILENO) >= 0;
}

ad_status show_picture(showing *showing, ad_error *error)
{
    static const char program[] = "cpinn-picture";
    char path[4096], slow[32], *data = NULL;
    size_t size = 0;
    const ssize_t length = readlink("/proc/self/exe", path, sizeof path - sizeof program);
    path[length > 0 ? length : 0] = '\0';
    char *name = strrchr(path, '/');
    memcpy(name ? name + 1 : path, program, sizeof program);
    snprintf(slow, sizeof slow, "%.17g", showing->slow);
    const ad_status status = json_take(&showing->to, &data, &size, error);
    if (status == AD_OK && give(data, size)) {
        const char *const arguments[] = {
            "python3",    path,     "-",  "--out",
            showing->out, "--slow", slow, showing->quiet ? "--quiet" : NULL,
            NULL};
        execvp(*arguments, (char *const *)arguments);
        ad_fail(error, AD_BAD_INPUT,
                "pictures need python3 with numpy: %s (apt-get install python3-numpy)",
                strerror(errno));
    } else if (status == AD_OK) {
        ad_fail(error, AD_IO, "the data of a picture cannot be written: %s", strerror(errno));
    }
    free(data);
    return error->status;
}
