#include "tools/fmu/fmu_parts.h"

#include "tools/files/file_bytes.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PATH_ROOM = 4096, FILES_MAX = 8 };

extern char **environ;

const char *fmu_platform(char text[64])
{
    struct utsname machine;
    if (uname(&machine) != 0) {
        return NULL;
    }
    const char *architecture = strcmp(machine.machine, "arm64") == 0 ? "aarch64" : machine.machine;
    const char *system = strcmp(machine.sysname, "Linux") == 0    ? "linux"
                         : strcmp(machine.sysname, "Darwin") == 0 ? "darwin"
                                                                  : NULL;
    static const char *const known[] = {"x86_64", "aarch64", "riscv64"};
    for (size_t i = 0; system && i < sizeof known / sizeof *known; i++) {
        if (strcmp(architecture, known[i]) == 0) {
            snprintf(text, 64, "%s-%s", known[i], system);
            return text;
        }
    }
    return NULL;
}

const char *fmu_library_ending(void)
{
#ifdef __APPLE__
    return ".dylib";
#else
    return ".so";
#endif
}

/* Runs it without a word; false with a note when it fails. For machines of one kind, whichever its
 * processor: without -march, and without contraction, so that results are the same bits. */
static bool run_compiler(char *const *sources, int count, char *library, char note[FMU_NOTE])
{
    static char *const flags[] = {
        "cc", "-std=c99", "-O3", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off",
        "-s", "-o"};
    enum { FLAGS = sizeof flags / sizeof *flags };
    char *arguments[FLAGS + FILES_MAX + 3];
    int n = FLAGS, how = 0;
    memcpy(arguments, flags, sizeof flags);
    arguments[n++] = library;
    for (int i = 0; i < count; i++) {
        arguments[n++] = sources[i];
    }
    arguments[n++] = "-lm";
    arguments[n] = NULL;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t child = 0;
    int failure = posix_spawnp(&child, "cc", &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure) {
        snprintf(note, FMU_NOTE, "there is no compiler: cc: %s", strerror(failure));
        return false;
    }
    pid_t ended;
    while ((ended = waitpid(child, &how, 0)) < 0 && errno == EINTR) {
    }
    if (ended < 0 || !WIFEXITED(how) || WEXITSTATUS(how) != 0) {
        snprintf(note, FMU_NOTE, "cc does not compile it");
        return false;
    }
    return true;
}

static bool write_file(const char *path, const fmu_file *file)
{
    FILE *stream = fopen(path, "wb");
    bool ok = stream && fwrite(file->text, 1, file->size, stream) == file->size;
    return stream && fclose(stream) == 0 && ok;
}

static unsigned char *compile_in(const char *folder, const fmu_file *files, int count, size_t *size,
                                 char note[FMU_NOTE])
{
    char paths[FILES_MAX][PATH_ROOM] = {""}, library[PATH_ROOM], *sources[FILES_MAX];
    unsigned char *bytes = NULL;
    size_t whole;
    int source_count = 0;
    bool ok = count <= FILES_MAX;
    snprintf(library, sizeof library, "%s/library%s", folder, fmu_library_ending());
    for (int i = 0; i < count && ok; i++) {
        int length = snprintf(paths[i], PATH_ROOM, "%s/%s", folder, files[i].name);
        ok = length < PATH_ROOM && write_file(paths[i], &files[i]);
        if (ok && strcmp(paths[i] + length - 2, ".c") == 0) {
            sources[source_count++] = paths[i];
        }
    }
    if (!ok) {
        snprintf(note, FMU_NOTE, "%.200s: %s", folder, strerror(errno));
    } else if (run_compiler(sources, source_count, library, note)) {
        ad_error error = {.message = ""};
        if (file_bytes_read(library, 0, &bytes, size, &whole, &error) != AD_OK) {
            snprintf(note, FMU_NOTE, "%.400s", error.message);
        }
    }
    unlink(library);
    for (int i = 0; i < count && i < FILES_MAX; i++) {
        unlink(paths[i]);
    }
    return bytes;
}

unsigned char *fmu_compile(const fmu_file *files, int count, size_t *size, char note[FMU_NOTE])
{
    const char *temporary = getenv("TMPDIR");
    char folder[1024];
    snprintf(folder, sizeof folder, "%s/cpinn_fmu_XXXXXX",
             temporary && *temporary ? temporary : "/tmp");
    if (!mkdtemp(folder)) {
        snprintf(note, FMU_NOTE, "%.200s: %s", folder, strerror(errno));
        return NULL;
    }
    unsigned char *bytes = compile_in(folder, files, count, size, note);
    rmdir(folder);
    return bytes;
}
