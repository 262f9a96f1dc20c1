/* A text of C as machine code: compiled by `cc` in a process of its own, kept in a folder by the
 * hash of text and command, loaded.
 *
 * What is loaded is code. So the folder and the file must belong to this user and be writable by
 * nobody else, and nobody else may be able to put another folder in the place of this one or of one
 * above it. The file ends with the hash it is kept by and a checksum, so that a damaged one is not
 * taken, nor that of another program under this one's name. It is opened once: what is checked is
 * what is loaded, whatever has its name by then.
 */
#define _DEFAULT_SOURCE /* realpath, S_ISVTX */
#include "autodiff/ad.h"
#include "autodiff/compile/kernels.h"
#include "autodiff/process.h"

#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define TABLE_NAME "ad_code_table"
#define FLAGS      "-std=c11 -fPIC -shared"

enum {
    PATH_ROOM = 4096,
    ARGUMENTS_MAX = 32,
    LIBRARIES_MAX = 4096,   /* of programs that are loaded at once */
    COMPILER_SECONDS = 600, /* one that takes longer hangs */
    LEFTOVER_SECONDS = 7200 /* files of a compiler that nobody waits for any more */
};

struct ad_code {
    pid_t child; /* the compiler at work, and its process group; 0: none */
    time_t began;
    uint64_t hash;
    char source[PATH_ROOM], made[PATH_ROOM], kept[PATH_ROOM];
    void *library;     /* NULL: not loaded */
    const void *table; /* in it */
};

typedef struct seal {
    char mark[8];
    uint64_t hash, size, checksum;
} seal;

static const char seal_mark[8] = "cpinn 3";

extern char **environ;

static uint64_t hash_bytes(uint64_t hash, const char *bytes, size_t count)
{
    for (; count >= sizeof hash; bytes += sizeof hash, count -= sizeof hash) {
        uint64_t word;
        memcpy(&word, bytes, sizeof word);
        hash = ad_hash_mix(hash, word);
    }
    for (size_t i = 0; i < count; i++) {
        hash = ad_hash_mix(hash, (unsigned char)bytes[i]);
    }
    return hash;
}

/* ---- files ---------------------------------------------------------------------------------- */

static bool is_private(const struct stat *s)
{
    return s->st_uid == geteuid() && (s->st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/* A file that only this user could have written; -1: it is none. Never waits, as a FIFO would. */
static int open_private(const char *path, int flags)
{
    struct stat s;
    int file = open(path, flags | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (file >= 0 && (fstat(file, &s) != 0 || !S_ISREG(s.st_mode) || !is_private(&s))) {
        close(file);
        file = -1;
    }
    return file;
}

/* All bytes of a file; NULL: they cannot be read. */
static char *read_all(int file, size_t *size)
{
    struct stat s;
    if (fstat(file, &s) != 0) {
        return NULL;
    }
    *size = (size_t)s.st_size;
    char *bytes = malloc(*size + 1);
    if (bytes && pread(file, bytes, *size, 0) != (ssize_t)*size) {
        free(bytes);
        bytes = NULL;
    }
    return bytes;
}

static seal seal_of(uint64_t hash, const char *bytes, size_t size)
{
    seal s = {.hash = hash, .size = size, .checksum = hash_bytes(0, bytes, size)};
    memcpy(s.mark, seal_mark, sizeof s.mark);
    return s;
}

static bool is_sealed(int file, uint64_t hash)
{
    size_t size = 0;
    char *bytes = read_all(file, &size);
    bool ok = bytes && size > sizeof(seal);
    if (ok) {
        size -= sizeof(seal);
        const seal expected = seal_of(hash, bytes, size);
        ok = memcmp(bytes + size, &expected, sizeof expected) == 0;
    }
    free(bytes);
    return ok;
}

/* What the compiler has made, and others may write to where the user's files are so by default. */
static int open_sealed(const char *path, uint64_t hash)
{
    size_t size = 0;
    chmod(path, S_IRWXU);
    int file = open_private(path, O_RDWR | O_APPEND);
    char *bytes = file >= 0 ? read_all(file, &size) : NULL;
    if (bytes) {
        const seal end = seal_of(hash, bytes, size);
        if (write(file, &end, sizeof end) == (ssize_t)sizeof end) {
            free(bytes);
            return file;
        }
    }
    free(bytes);
    if (file >= 0) {
        close(file);
    }
    return -1;
}

static bool write_private(const char *path, const char *bytes, size_t size)
{
    unlink(path); /* of a process that was killed */
    int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
    FILE *stream = file >= 0 ? fdopen(file, "wb") : NULL;
    bool ok = stream && fwrite(bytes, 1, size, stream) == size;
    if (!stream && file >= 0) {
        close(file);
    }
    return stream && fclose(stream) == 0 && ok;
}

/* What compilers left whose process was killed: HASH.PROCESS-PROGRAM.c and .so, old ones. */
static void remove_leftovers(const char *folder)
{
    DIR *list = opendir(folder);
    for (const struct dirent *entry; list && (entry = readdir(list));) {
        struct stat s;
        const char *dot = strchr(entry->d_name, '.');
        if (dot && strchr(dot, '-') &&
            fstatat(dirfd(list), entry->d_name, &s, AT_SYMLINK_NOFOLLOW) == 0 &&
            time(NULL) - s.st_mtime > LEFTOVER_SECONDS) {
            unlinkat(dirfd(list), entry->d_name, 0);
        }
    }
    if (list) {
        closedir(list);
    }
}

/* Whether nobody but this user and root can put another file in the place of this user's here. */
static bool is_safe_above(const char *folder)
{
    struct stat s;
    return lstat(folder, &s) == 0 && S_ISDIR(s.st_mode) &&
           (s.st_uid == geteuid() || s.st_uid == 0) &&
           ((s.st_mode & (S_IWGRP | S_IWOTH)) == 0 || (s.st_mode & S_ISVTX) != 0);
}

/* A folder that only this user can write to, made if it is missing, as a path [PATH_ROOM] without
 * links. From the root on, so that what is found stays so. */
static ad_status make_private(const char *folder, char *path, ad_error *error)
{
    struct stat s;
    mkdir(folder, S_IRWXU);
    if (!realpath(folder, path)) {
        return ad_fail(error, AD_IO, "%s: %s", folder, strerror(errno));
    }
    for (char *end = strchr(path, '/'); end && end[1]; end = strchr(end + 1, '/')) {
        char *first = end == path ? end + 1 : end, kept = *first;
        *first = '\0';
        if (!is_safe_above(path)) {
            return ad_fail(error, AD_IO, "%s: others can put another folder in the place of %s",
                           path, folder);
        }
        *first = kept;
    }
    if (lstat(path, &s) != 0 || !S_ISDIR(s.st_mode) || !is_private(&s)) {
        return ad_fail(error, AD_IO, "%s: is no folder that only its user can write to", folder);
    }
    return AD_OK;
}

/* ---- loading -------------------------------------------------------------------------------- */

/* The table's name has the hash: whatever has it is the code of these groups. */
static void name_table(uint64_t hash, char *name, size_t room)
{
    snprintf(name, room, TABLE_NAME "_%016" PRIx64, hash);
}

/* The library is opened by the number of `file`. The loader takes what it once opened by the same
 * name, when another file had this number: then by another number. NULL: fails, dlerror says why.
 */
static void *open_library(int file, const char *name, void **table)
{
    void *library = NULL;
    int number = file;
    *table = NULL;
    for (int i = 0; i < LIBRARIES_MAX && number >= 0 && !*table; i++) {
        char path[64];
        snprintf(path, sizeof path, "/proc/self/fd/%d", number);
        library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        *table = library ? dlsym(library, name) : NULL;
        int next = library && !*table ? fcntl(file, F_DUPFD_CLOEXEC, number + 1) : -1;
        if (library && !*table) {
            dlclose(library);
            library = NULL;
        }
        if (number != file) {
            close(number);
        }
        number = next;
    }
    return library;
}

static ad_status load(ad_code *code, int file, ad_error *error)
{
    char name[sizeof TABLE_NAME + 32];
    void *found = NULL;
    name_table(code->hash, name, sizeof name);
    code->library = open_library(file, name, &found);
    code->table = found;
    if (!code->library) {
        const char *why = dlerror();
        return ad_fail(error, AD_IO, "compiled C: %s", why ? why : "none");
    }
    return AD_OK;
}

/* Takes what is kept of this text. */
static bool load_kept(ad_code *code)
{
    int file = open_private(code->kept, O_RDONLY);
    bool ok = file >= 0 && is_sealed(file, code->hash) && load(code, file, NULL) == AD_OK;
    if (file >= 0) {
        close(file);
    }
    return ok;
}

/* Keeps what the compiler has made, and takes it. */
static ad_status load_made(ad_code *code, ad_error *error)
{
    int file = open_sealed(code->made, code->hash);
    if (file < 0 || rename(code->made, code->kept) != 0) {
        ad_fail(error, AD_IO, "%s: %s", code->kept, strerror(errno));
        if (file >= 0) {
            close(file);
        }
        return AD_IO;
    }
    ad_status status = load(code, file, error);
    close(file);
    return status;
}

/* ---- compiling ------------------------------------------------------------------------------ */

bool ad_find_program(const char *name, char *path, size_t room)
{
    struct stat s;
    for (const char *at = getenv("PATH"); at && *at;) {
        int length = (int)strcspn(at, ":");
        int whole = snprintf(path, room, "%.*s/%s", length, at, name);
        if (*at == '/' && whole > 0 && (size_t)whole < room && stat(path, &s) == 0 &&
            S_ISREG(s.st_mode) && access(path, X_OK) == 0) {
            return true;
        }
        at += length + (at[length] == ':');
    }
    return false;
}

bool ad_fuse_compiler(char *path, size_t room)
{
    return ad_find_program("cc", path, room);
}

int ad_start_process(char *const *arguments, const char *output, pid_t *child)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, output, O_WRONLY | O_CREAT | O_TRUNC,
                                     S_IRUSR | S_IWUSR);
    posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    int failure = posix_spawn(child, arguments[0], &files, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return failure;
}

/* cc FLAGS OPTIONS -mavx... -DTABLE -o MADE SOURCE -lmvec -lm, without a word. */
static ad_status start_compiler(ad_code *code, const char *options, ad_error *error)
{
    char compiler[PATH_ROOM], words[512], *arguments[ARGUMENTS_MAX] = {compiler}, *rest = NULL;
    char table[2 * sizeof TABLE_NAME + 32] = "-D" TABLE_NAME "=";
    int count = 1;
    name_table(code->hash, table + strlen(table), sizeof table - strlen(table));
    if (!ad_fuse_compiler(compiler, sizeof compiler)) {
        return ad_fail(error, AD_IO, "no compiler: no cc in a folder of PATH");
    }
    snprintf(words, sizeof words, "%s %s %s", FLAGS, options, ad_kernels_select()->flags);
    for (char *word = strtok_r(words, " ", &rest); word && count < ARGUMENTS_MAX - 7;
         word = strtok_r(NULL, " ", &rest)) {
        arguments[count++] = word;
    }
    arguments[count++] = table;
    arguments[count++] = "-o";
    arguments[count++] = code->made;
    arguments[count++] = code->source;
#if defined(__x86_64__) && defined(__GLIBC__)
    arguments[count++] = "-lmvec";
#endif
    arguments[count++] = "-lm";
    int failure = ad_start_process(arguments, "/dev/null", &code->child);
    if (failure) {
        code->child = 0;
        return ad_fail(error, AD_IO, "%s: %s", compiler, strerror(failure));
    }
    code->began = time(NULL);
    return AD_OK;
}

/* Waits for the compiler, 0.1 s at most: false, it is still at work. */
static bool ends_soon(pid_t child)
{
    const struct timespec moment = {0, 1000000};
    for (int i = 0; i < 100; i++) {
        if (waitpid(child, NULL, WNOHANG) != 0) {
            return true;
        }
        nanosleep(&moment, NULL);
    }
    return false;
}

/* The compiler is stopped, its files are gone. */
static void stop(ad_code *code)
{
    if (code->child > 0) {
        kill(-code->child, SIGTERM); /* lets it remove its own files */
        if (!ends_soon(code->child)) {
            kill(-code->child, SIGKILL);
            ends_soon(code->child);
        }
    }
    code->child = 0;
    unlink(code->source);
    unlink(code->made);
}

void ad_code_free(ad_code *code)
{
    if (code) {
        stop(code);
        if (code->library) {
            dlclose(code->library);
        }
        free(code);
    }
}

/* Of a compiler at work by process and object, so that none writes another's. */
static bool name_files(ad_code *code, const char *folder)
{
    char work[PATH_ROOM];
    int length = snprintf(code->kept, PATH_ROOM, "%s/%016" PRIx64 ".so", folder, code->hash);
    int longest = snprintf(work, sizeof work, "%s/%016" PRIx64 ".%d-%p.so", folder, code->hash,
                           (int)getpid(), (const void *)code);
    if (length >= PATH_ROOM || longest >= PATH_ROOM) {
        return false;
    }
    memcpy(code->made, work, (size_t)longest + 1);
    memcpy(code->source, work, (size_t)longest + 1);
    memcpy(code->source + longest - 2, "c", 2);
    return true;
}

/* Takes what is kept; else, where it is to `compile`, starts the compiler. */
static ad_status begin(ad_code *code, const char *text, size_t size, const ad_code_settings *how,
                       ad_error *error)
{
    char path[PATH_ROOM];
    ad_status status = make_private(how->folder, path, error);
    if (status == AD_OK && !name_files(code, path)) {
        status = ad_fail(error, AD_IO, "%s: too long a name", how->folder);
    }
    if (status != AD_OK || load_kept(code) || !how->compile) {
        return status;
    }
    remove_leftovers(path);
    if (!write_private(code->source, text, size)) {
        return ad_fail(error, AD_IO, "%s: %s", code->source, strerror(errno));
    }
    return start_compiler(code, how->options, error);
}

ad_status ad_code_begin(const char *text, size_t size, const ad_code_settings *how,
                        ad_code **result, ad_error *error)
{
    const char *parts[] = {FLAGS, how->options, ad_kernels_select()->flags};
    ad_code *code = calloc(1, sizeof *code);
    *result = NULL;
    if (!code) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the names of files");
    }
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        code->hash = hash_bytes(code->hash, parts[i], strlen(parts[i]));
    }
    code->hash = hash_bytes(code->hash, text, size);
    ad_status status = begin(code, text, size, how, error);
    if (status != AD_OK || (!code->library && code->child == 0)) {
        ad_code_free(code);
        return status;
    }
    *result = code;
    return AD_OK;
}

/* As waitpid, for COMPILER_SECONDS at most. 0: still at work. */
static pid_t look_after(const ad_code *code, bool wait, int *how)
{
    const struct timespec moment = {0, 2000000};
    pid_t ended = waitpid(code->child, how, WNOHANG);
    while (ended == 0 && wait && time(NULL) - code->began <= COMPILER_SECONDS) {
        nanosleep(&moment, NULL);
        ended = waitpid(code->child, how, WNOHANG);
    }
    return ended;
}

ad_status ad_code_finish(ad_code *code, bool wait, const void **table, ad_error *error)
{
    int how = 0;
    ad_status status;
    *table = code->table;
    if (code->child == 0) {
        return AD_OK;
    }
    pid_t ended = look_after(code, wait, &how);
    if (ended == 0 && time(NULL) - code->began <= COMPILER_SECONDS) {
        return AD_OK;
    }
    code->child = ended == 0 ? code->child : 0;
    if (ended == 0) {
        status = ad_fail(error, AD_IO, "cc has not ended after %d s", COMPILER_SECONDS);
    } else if (ended < 0 || !WIFEXITED(how) || WEXITSTATUS(how) != 0) {
        status = ad_fail(error, AD_IO, "cc does not compile what a program is written out as");
    } else {
        status = load_made(code, error);
    }
    stop(code);
    *table = code->table;
    return status;
}
