/* The elementwise groups of a program as machine code: written as C (c_groups.c), compiled by `cc`
 * in a process of its own while the program goes on as it is, kept in a folder by the hash of text
 * and command, loaded. Both give the same bits, so it does not matter when the one takes over.
 *
 * What is loaded is code. So the folder and the file must belong to this user and be writable by
 * nobody else, and nobody else may be able to put another folder in the place of this one or of one
 * above it. The file ends with the hash it is kept by and a checksum, so that a damaged one is not
 * taken, nor that of another program under this one's name. It is opened once: what is checked is
 * what is loaded, whatever has its name by then.
 */
#define _DEFAULT_SOURCE /* realpath, S_ISVTX */
#include "autodiff/emit/c_code.h"

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

#define TABLE_NAME "cpinn_fused_groups"
#define FLAGS      "-std=c11 -O2 -fPIC -shared -fno-math-errno -ffp-contract=off"

enum {
    PATH_ROOM = 4096,
    ARGUMENTS_MAX = 32,
    LIBRARIES_MAX = 4096,   /* of programs that are loaded at once */
    COMPILER_SECONDS = 600, /* one that takes longer hangs */
    LEFTOVER_SECONDS = 7200 /* files of a compiler that nobody waits for any more */
};

typedef struct fusing {
    pid_t child; /* the compiler at work, and its process group; 0: none */
    time_t began;
    uint64_t hash;
    char source[PATH_ROOM], made[PATH_ROOM], kept[PATH_ROOM];
} fusing;

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

static ad_status load(ad_program *program, int file, uint64_t hash, ad_error *error)
{
    char name[sizeof TABLE_NAME + 32];
    void *found = NULL;
    name_table(hash, name, sizeof name);
    void *library = open_library(file, name, &found);
    if (!library) {
        const char *why = dlerror();
        return ad_fail(error, AD_IO, "compiled groups: %s", why ? why : "none");
    }
    const fused_groups *table = found;
    for (int s = 0; s < program->pass_count; s++) {
        pass *p = &program->passes[s];
        for (int g = 0; g < p->group_count; g++) {
            p->groups[g].fused_count = ad_c_run_length(p, g);
            if (p->groups[g].fused_count > 0) {
                p->groups[g].fused = *table++;
                g += p->groups[g].fused_count - 1;
            }
        }
    }
    program->library = library;
    return AD_OK;
}

/* Takes what is kept for these groups. */
static bool load_kept(ad_program *program, const fusing *f)
{
    int file = open_private(f->kept, O_RDONLY);
    bool ok = file >= 0 && is_sealed(file, f->hash) && load(program, file, f->hash, NULL) == AD_OK;
    if (file >= 0) {
        close(file);
    }
    return ok;
}

/* Keeps what the compiler has made, and takes it. */
static ad_status load_made(ad_program *program, const fusing *f, ad_error *error)
{
    int file = open_sealed(f->made, f->hash);
    if (file < 0 || rename(f->made, f->kept) != 0) {
        ad_fail(error, AD_IO, "%s: %s", f->kept, strerror(errno));
        if (file >= 0) {
            close(file);
        }
        return AD_IO;
    }
    ad_status status = load(program, file, f->hash, error);
    close(file);
    return status;
}

/* ---- compiling ------------------------------------------------------------------------------ */

bool ad_fuse_compiler(char *path, size_t room)
{
    struct stat s;
    for (const char *at = getenv("PATH"); at && *at;) {
        int length = (int)strcspn(at, ":");
        int whole = snprintf(path, room, "%.*s/cc", length, at);
        if (*at == '/' && whole > 0 && (size_t)whole < room && stat(path, &s) == 0 &&
            S_ISREG(s.st_mode) && access(path, X_OK) == 0) {
            return true;
        }
        at += length + (at[length] == ':');
    }
    return false;
}

/* In a process group of its own, so that what it starts in turn can be stopped with it. */
static int spawn_quietly(pid_t *child, char *const *arguments)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    int failure = posix_spawn(child, arguments[0], &files, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return failure;
}

/* cc FLAGS -mavx... -DTABLE -o MADE SOURCE -lmvec -lm, without a word. */
static ad_status start_compiler(const ad_program *program, fusing *f, ad_error *error)
{
    char compiler[PATH_ROOM], words[512], *arguments[ARGUMENTS_MAX] = {compiler}, *rest = NULL;
    char table[2 * sizeof TABLE_NAME + 32] = "-D" TABLE_NAME "=";
    int count = 1;
    name_table(f->hash, table + strlen(table), sizeof table - strlen(table));
    if (!ad_fuse_compiler(compiler, sizeof compiler)) {
        return ad_fail(error, AD_IO, "no compiler: no cc in a folder of PATH");
    }
    snprintf(words, sizeof words, "%s %s", FLAGS, program->kernels->flags);
    for (char *word = strtok_r(words, " ", &rest); word && count < ARGUMENTS_MAX - 7;
         word = strtok_r(NULL, " ", &rest)) {
        arguments[count++] = word;
    }
    arguments[count++] = table;
    arguments[count++] = "-o";
    arguments[count++] = f->made;
    arguments[count++] = f->source;
#if defined(__x86_64__) && defined(__GLIBC__)
    arguments[count++] = "-lmvec";
#endif
    arguments[count++] = "-lm";
    int failure = spawn_quietly(&f->child, arguments);
    if (failure) {
        f->child = 0;
        return ad_fail(error, AD_IO, "%s: %s", compiler, strerror(failure));
    }
    f->began = time(NULL);
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
static void stop(ad_program *program)
{
    fusing *f = program->fusing;
    if (f && f->child > 0) {
        kill(-f->child, SIGTERM); /* lets it remove its own files */
        if (!ends_soon(f->child)) {
            kill(-f->child, SIGKILL);
            ends_soon(f->child);
        }
    }
    if (f) {
        unlink(f->source);
        unlink(f->made);
    }
    free(f);
    program->fusing = NULL;
}

void ad_fuse_clear(ad_program *program)
{
    stop(program);
    if (program->library) {
        dlclose(program->library);
    }
    program->library = NULL;
}

/* Of a compiler at work by process and program, so that none writes another's. */
static bool name_files(fusing *f, const ad_program *program, const char *folder)
{
    char work[PATH_ROOM];
    int length = snprintf(f->kept, PATH_ROOM, "%s/%016" PRIx64 ".so", folder, f->hash);
    int longest = snprintf(work, sizeof work, "%s/%016" PRIx64 ".%d-%p.so", folder, f->hash,
                           (int)getpid(), (const void *)program);
    if (length >= PATH_ROOM || longest >= PATH_ROOM) {
        return false;
    }
    memcpy(f->made, work, (size_t)longest + 1);
    memcpy(f->source, work, (size_t)longest + 1);
    memcpy(f->source + longest - 2, "c", 2);
    return true;
}

/* Takes what is kept; else, where it is to `compile`, starts the compiler. */
static ad_status begin(ad_program *program, const char *text, size_t size, const char *folder,
                       bool compile, ad_error *error)
{
    fusing *f = program->fusing = calloc(1, sizeof *f);
    if (!f) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the names of files");
    }
    f->hash = hash_bytes(0, FLAGS, strlen(FLAGS));
    f->hash = hash_bytes(f->hash, program->kernels->flags, strlen(program->kernels->flags));
    f->hash = hash_bytes(f->hash, text, size);
    char path[PATH_ROOM];
    ad_status status = make_private(folder, path, error);
    if (status == AD_OK && !name_files(f, program, path)) {
        status = ad_fail(error, AD_IO, "%s: too long a name", folder);
    }
    if (status != AD_OK || load_kept(program, f) || !compile) {
        return status;
    }
    remove_leftovers(path);
    if (!write_private(f->source, text, size)) {
        return ad_fail(error, AD_IO, "%s: %s", f->source, strerror(errno));
    }
    return start_compiler(program, f, error);
}

ad_status ad_fuse_begin(ad_program *program, size_t points, size_t members, const char *folder,
                        bool compile, ad_error *error)
{
    char *text = NULL;
    size_t size = 0;
    int way = compile ? 2 : 1;
    if (program->library || program->fuse_begun >= way) {
        return AD_OK;
    }
    program->fuse_begun = way;
    if (!compile && access(folder, F_OK) != 0) {
        return AD_OK; /* nothing is kept: no text is needed to look for it */
    }
    for (int s = 0; s < program->pass_count; s++) {
        pass *p = &program->passes[s];
        p->fused_tile = ad_execute_tile(program, p, points, members);
    }
    FILE *file = open_memstream(&text, &size);
    bool ok = file && ad_c_write_groups(program, TABLE_NAME, file);
    ok = file && fclose(file) == 0 && ok;
    ad_status status = ok ? begin(program, text, size, folder, compile, error)
                          : ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
    free(text);
    if (program->fusing && program->fusing->child == 0) {
        stop(program);
    }
    return status;
}

/* As waitpid, for COMPILER_SECONDS at most. 0: still at work. */
static pid_t look_after(const fusing *f, bool wait, int *how)
{
    const struct timespec moment = {0, 2000000};
    pid_t ended = waitpid(f->child, how, WNOHANG);
    while (ended == 0 && wait && time(NULL) - f->began <= COMPILER_SECONDS) {
        nanosleep(&moment, NULL);
        ended = waitpid(f->child, how, WNOHANG);
    }
    return ended;
}

ad_status ad_fuse_finish(ad_program *program, bool wait, ad_fuse_state *state, ad_error *error)
{
    fusing *f = program->fusing;
    int how = 0;
    ad_status status = AD_OK;
    *state = program->library ? AD_FUSED : f ? AD_FUSING : AD_INTERPRETED;
    if (!f) {
        return AD_OK;
    }
    pid_t ended = look_after(f, wait, &how);
    if (ended == 0 && time(NULL) - f->began <= COMPILER_SECONDS) {
        return AD_OK;
    }
    f->child = ended == 0 ? f->child : 0;
    if (ended == 0) {
        status = ad_fail(error, AD_IO, "cc has not ended after %d s", COMPILER_SECONDS);
    } else if (ended < 0 || !WIFEXITED(how) || WEXITSTATUS(how) != 0) {
        status = ad_fail(error, AD_IO, "cc does not compile the groups of a program");
    } else {
        status = load_made(program, f, error);
    }
    stop(program);
    *state = program->library ? AD_FUSED : AD_INTERPRETED;
    return status;
}
