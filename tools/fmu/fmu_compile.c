#include "tools/fmu/fmu_parts.h"

#include "tools/files/file_bytes.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <sys/wait.h>
#include <unistd.h>

/* For all machines of one kind, whichever their processor: without -march, and without contraction,
 * so that results are the same bits. */
#define COMPILE                                                                                    \
    "cc -std=c99 -O3 -fPIC -shared -fvisibility=hidden -ffp-contract=off -s -o library *.c -lm"

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

static bool put_file(const char *folder, const fmu_file *file)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, file->name);
    FILE *stream = fopen(path, "wb");
    bool ok = stream && fwrite(file->text, 1, file->size, stream) == file->size;
    return stream && fclose(stream) == 0 && ok;
}

static void remove_file(const char *folder, const char *name)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    unlink(path);
}

unsigned char *fmu_compile(const fmu_file *files, int count, size_t *size, char note[FMU_NOTE])
{
    char folder[] = "/tmp/cpinn_fmu_XXXXXX", command[512], path[512];
    unsigned char *bytes = NULL;
    ad_error error = {.message = ""};
    size_t whole;
    bool ok = mkdtemp(folder) != NULL;
    for (int i = 0; i < count && ok; i++) {
        ok = put_file(folder, &files[i]);
    }
    snprintf(command, sizeof command, "cd %s && " COMPILE " >/dev/null 2>&1", folder);
    snprintf(path, sizeof path, "%s/library", folder);
    if (!ok) {
        snprintf(note, FMU_NOTE, "%s: %s", folder, strerror(errno));
    } else {
        int how = system(command);
        int status = WIFEXITED(how) ? WEXITSTATUS(how) : 1;
        if (status == 127) {
            snprintf(note, FMU_NOTE, "there is no compiler, cc");
        } else if (status != 0) {
            snprintf(note, FMU_NOTE, "cc does not compile it");
        } else if (file_bytes_read(path, 0, &bytes, size, &whole, &error) != AD_OK) {
            snprintf(note, FMU_NOTE, "%.400s", error.message);
        }
    }
    for (int i = 0; i < count; i++) {
        remove_file(folder, files[i].name);
    }
    remove_file(folder, "library");
    rmdir(folder);
    return bytes;
}
