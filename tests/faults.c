/* A library to be preloaded (test_faults.sh): the n-th call of one kind fails, whoever makes it,
 * the libraries that are used as well. CPINN_FAULT="allocate 120": that one; "write 3+": all from
 * the third on; "rename 4!": the process is killed in its place. CPINN_FAULT_COUNTS=FILE: how many
 * calls there were of each, at the end. */
#define _GNU_SOURCE /* RTLD_NEXT, off64_t */
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* One row per kind. */
#define KINDS(X) X(allocate) X(open) X(read) X(write) X(fsync) X(rename) X(ftruncate) X(mkdir)

enum {
#define KIND(name) KIND_##name,
    KINDS(KIND) KIND_COUNT
#undef KIND
};

static const char *const kinds[] = {
#define NAME(name) #name,
    KINDS(NAME)
#undef NAME
};

static atomic_long calls[KIND_COUNT];
static int failing = KIND_COUNT;
static long first;
static bool further, kills;

/* HDF5 and SUNDIALS use some memory without looking whether they have got it; the programs try
 * before whether there is plenty (hdf5_image_read, solve_vectors_fit). */
static bool is_in_library(void)
{
    void *callers[24];
    const int count = backtrace(callers, 24);
    Dl_info from;
    for (int i = 0; i < count; i++) {
        if (dladdr(callers[i], &from) != 0 && from.dli_fname &&
            (strstr(from.dli_fname, "hdf5") || strstr(from.dli_fname, "sundials"))) {
            return true;
        }
    }
    return false;
}

__attribute__((constructor)) static void prepare(void)
{
    const char *fault = getenv("CPINN_FAULT");
    char name[16] = "", plus = 0;
    is_in_library();        /* which loads what it needs */
    unsetenv("LD_PRELOAD"); /* for this program, not for those that it starts */
    if (fault && sscanf(fault, "%15s %ld%c", name, &first, &plus) >= 2) {
        for (int k = 0; k < KIND_COUNT; k++) {
            calls[k] = 0;
            failing = strcmp(name, kinds[k]) == 0 ? k : failing;
        }
    }
    further = plus == '+';
    kills = plus == '!';
}

/* The first that is due, and `further` all after it. */
static bool fails(int kind)
{
    static _Thread_local bool looking;
    const long now = ++calls[kind];
    if (kind != failing || now < first || looking) {
        return false;
    }
    if (kills) {
        raise(SIGKILL);
    }
    looking = true;
    const bool failed = kind != KIND_allocate || !is_in_library();
    looking = false;
    failing = failed && !further ? KIND_COUNT : failing;
    return failed;
}

__attribute__((destructor)) static void report(void)
{
    const char *path = getenv("CPINN_FAULT_COUNTS");
    const int file = path ? open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600) : -1;
    for (int k = 0; file >= 0 && k < KIND_COUNT; k++) {
        dprintf(file, "%s %ld\n", kinds[k], (long)calls[k]);
    }
    if (file >= 0) {
        close(file);
    }
}

/* ---- memory: the names that glibc has for these ---- */

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static void *no_memory(void)
{
    errno = ENOMEM;
    return NULL;
}

void *malloc(size_t size)
{
    return fails(KIND_allocate) ? no_memory() : __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    return fails(KIND_allocate) ? no_memory() : __libc_calloc(count, size);
}

void *realloc(void *memory, size_t size)
{
    return fails(KIND_allocate) ? no_memory() : __libc_realloc(memory, size);
}

int posix_memalign(void **memory, size_t alignment, size_t size)
{
    *memory = fails(KIND_allocate) ? NULL : __libc_memalign(alignment, size);
    return *memory ? 0 : ENOMEM;
}

/* ---- system calls ---- */

/* The next function of that name, or that of a failed call. */
#define CALL(kind, code, result, name, types, ...)                                                 \
    if (fails(KIND_##kind)) {                                                                      \
        errno = code;                                                                              \
        return result;                                                                             \
    }                                                                                              \
    types;                                                                                         \
    void *symbol = dlsym(RTLD_NEXT, name);                                                         \
    memcpy(&next, &symbol, sizeof symbol);                                                         \
    return next(__VA_ARGS__)

int open(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    CALL(open, EMFILE, -1, "open", int (*next)(const char *, int, ...), path, flags, mode);
}

int openat(int folder, const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    CALL(open, EMFILE, -1, "openat", int (*next)(int, const char *, int, ...), folder, path, flags,
         mode);
}

FILE *fopen(const char *path, const char *mode)
{
    CALL(open, EMFILE, NULL, "fopen", FILE * (*next)(const char *, const char *), path, mode);
}

ssize_t read(int file, void *bytes, size_t size)
{
    CALL(read, EIO, -1, "read", ssize_t(*next)(int, void *, size_t), file, bytes, size);
}

ssize_t write(int file, const void *bytes, size_t size)
{
    CALL(write, ENOSPC, -1, "write", ssize_t(*next)(int, const void *, size_t), file, bytes, size);
}

int fflush(FILE *file) /* of files, which call write within the C library */
{
    const bool standard = file == stdout || file == stderr || file == NULL;
    if (standard) {
        return fflush_unlocked(file);
    }
    CALL(write, ENOSPC, EOF, "fflush", int (*next)(FILE *), file);
}

int fsync(int file)
{
    CALL(fsync, EIO, -1, "fsync", int (*next)(int), file);
}

int rename(const char *from, const char *to)
{
    CALL(rename, EIO, -1, "rename", int (*next)(const char *, const char *), from, to);
}

int renameat(int from_folder, const char *from, int to_folder, const char *to)
{
    CALL(rename, EIO, -1, "renameat", int (*next)(int, const char *, int, const char *),
         from_folder, from, to_folder, to);
}

int ftruncate(int file, off_t size)
{
    CALL(ftruncate, EIO, -1, "ftruncate", int (*next)(int, off_t), file, size);
}

int mkdir(const char *path, mode_t mode)
{
    CALL(mkdir, ENOSPC, -1, "mkdir", int (*next)(const char *, mode_t), path, mode);
}
