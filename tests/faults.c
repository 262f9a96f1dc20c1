/* A library to be preloaded (test_faults.sh): the n-th call of one kind fails, whoever makes it,
 * the libraries that are used as well. CPINN_FAULT="allocate 120": that one; "write 3+": all from
 * the third on. CPINN_FAULT_COUNTS=FILE: how many calls there were of each, at the end. */
#define _GNU_SOURCE /* RTLD_NEXT, off64_t */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
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
static bool further;

__attribute__((constructor)) static void prepare(void)
{
    const char *fault = getenv("CPINN_FAULT");
    char name[16] = "", plus = 0;
    unsetenv("LD_PRELOAD"); /* for this program, not for those that it starts */
    if (fault && sscanf(fault, "%15s %ld%c", name, &first, &plus) >= 2) {
        for (int k = 0; k < KIND_COUNT; k++) {
            calls[k] = 0;
            failing = strcmp(name, kinds[k]) == 0 ? k : failing;
        }
    }
    further = plus == '+';
}

static _Thread_local int exempt; /* within what does not look whether it gets memory */

static bool fails(int kind)
{
    const long now = exempt ? 0 : ++calls[kind];
    return kind == failing && now > 0 && (further ? now >= first : now == first);
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

int fflush(FILE *file)
{
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

int ftruncate(int file, off_t size)
{
    CALL(ftruncate, EIO, -1, "ftruncate", int (*next)(int, off_t), file, size);
}

int mkdir(const char *path, mode_t mode)
{
    CALL(mkdir, ENOSPC, -1, "mkdir", int (*next)(const char *, mode_t), path, mode);
}

/* ---- libraries that cannot be helped -------------------------------------------------------- */

/* The programs try the memory before (hdf5_image_silence, solve_vectors_fit). */
#define EXEMPT(result, name, types, call)                                                          \
    types;                                                                                         \
    void *symbol = dlsym(RTLD_NEXT, name);                                                         \
    memcpy(&next, &symbol, sizeof symbol);                                                         \
    exempt++;                                                                                      \
    result got = call;                                                                             \
    exempt--;                                                                                      \
    return got

int H5open(void);
void *N_VClone(void *vector);

int H5open(void) /* recurses */
{
    EXEMPT(int, "H5open", int (*next)(void), next());
}

void *N_VClone(void *vector) /* writes to what it has not got */
{
    EXEMPT(void *, "N_VClone", void *(*next)(void *), next(vector));
}
