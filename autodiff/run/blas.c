/* OpenBLAS chooses its kernels once, when it is loaded, from the processor's family number; older
 * releases do not know recent processors and then take kernels of half the speed. The environment
 * variable OPENBLAS_CORETYPE overrides the choice, but only before loading. So the library is
 * loaded here, on first use, with the variable set for the time of loading unless the user has set
 * it. The same holds for OPENBLAS_NUM_THREADS: threads are the pool's, one matrix product each. */
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */
#include "autodiff/run/blas.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

extern char **environ;

static struct {
    pthread_once_t once;
    blas loaded;
    ad_error error;
} state = {.once = PTHREAD_ONCE_INIT};

/* The kernels for AVX-512 that every release has; NULL: leave the choice to OpenBLAS. */
static const char *preferred_core(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl")) {
        return "SkylakeX";
    }
#endif
    return NULL;
}

/* Removes the variable of "NAME=VALUE", if it is this very text. */
static void take_back(const char *text)
{
    char name[64];
    const size_t length = strcspn(text, "=");
    snprintf(name, sizeof name, "%.*s", (int)length, text);
    if (*name && getenv(name) == text + length + 1) {
        unsetenv(name);
    }
}

/* Somebody may have loaded the same library before, such as the numpy or the MUMPS of Debian, with
 * threads of its own: products of some microseconds then wait for these, for milliseconds where
 * others use the processors, and differ in last digits with their number. */
static void set_one_thread(void *library)
{
    void *function = library && !getenv("OPENBLAS_NUM_THREADS")
                         ? dlsym(library, "openblas_set_num_threads")
                         : NULL;
    void (*set)(int) = NULL;
    memcpy(&set, &function, sizeof function);
    if (set) {
        set(1);
    }
}

/* For as long as it is loaded, the process has an environment with these variables, unless they are
 * set. It is another array, and the own one is back afterwards: other threads that look at it see
 * one or the other. So it is not freed. Where another thread has changed it meanwhile, the change
 * stays, and these variables alone go. */
static void *load_library(ad_error *error)
{
    static char threads[] = "OPENBLAS_NUM_THREADS=1", core[64], **during;
    char **const before = environ;
    size_t count = 0;
    while (before && before[count]) {
        count++;
    }
    during = malloc((count + 3) * sizeof *during);
    if (!during) {
        ad_fail(error, AD_NO_MEMORY, "out of memory for OpenBLAS");
        return NULL;
    }
    memcpy(during, before, count * sizeof *during);
    if (!getenv("OPENBLAS_NUM_THREADS")) {
        during[count++] = threads;
    }
    if (preferred_core() && !getenv("OPENBLAS_CORETYPE")) {
        snprintf(core, sizeof core, "OPENBLAS_CORETYPE=%s", preferred_core());
        during[count++] = core;
    }
    during[count] = NULL;
    char **now = during;
    __atomic_store_n(&environ, during, __ATOMIC_RELEASE);
    void *library = dlopen(AD_OPENBLAS_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    if (!__atomic_compare_exchange_n(&environ, &now, before, false, __ATOMIC_RELEASE,
                                     __ATOMIC_RELAXED)) {
        take_back(threads);
        take_back(core);
    }
    return library;
}

bool ad_blas_fits(int threads)
{
    const size_t buffer = (size_t)128 << 20, library = (size_t)40 << 20;
    const size_t room = (size_t)threads * buffer + library;
    void *tried = mmap(NULL, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return tried != MAP_FAILED && munmap(tried, room) == 0;
}

static void load(void)
{
    if (!ad_blas_fits(1)) {
        ad_fail(&state.error, AD_NO_MEMORY, "out of memory for OpenBLAS: 168 MiB of address space");
        return;
    }
    void *library = load_library(&state.error);
    if (state.error.status != AD_OK) {
        return;
    }
    const struct {
        const char *name;
        void *to;
    } wanted[] = {{"cblas_dgemm", &state.loaded.gemm}, {"cblas_dsyrk", &state.loaded.syrk},
                  {"dgetrf_", &state.loaded.getrf},    {"dgetrs_", &state.loaded.getrs},
                  {"dgeqp3_", &state.loaded.geqp3},    {"dgeqrf_", &state.loaded.geqrf},
                  {"dtpqrt_", &state.loaded.tpqrt},    {"dtpmqrt_", &state.loaded.tpmqrt},
                  {"dtrtri_", &state.loaded.trtri},    {"dsytf2_", &state.loaded.sytf2},
                  {"dgeev_", &state.loaded.geev}};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        void *function = library ? dlsym(library, wanted[i].name) : NULL;
        if (!function) {
            const char *why = dlerror();
            ad_fail(&state.error, AD_NO_BLAS, "OpenBLAS: %s", why ? why : wanted[i].name);
            return;
        }
        memcpy(wanted[i].to, &function, sizeof function);
    }
    set_one_thread(library);
    void *core = dlsym(library, "openblas_get_corename");
    char *(*corename)(void) = NULL;
    memcpy(&corename, &core, sizeof core);
    state.loaded.core = corename ? corename() : "unknown";
}

const blas *ad_blas_load(ad_error *error)
{
    pthread_once(&state.once, load);
    if (state.error.status != AD_OK) {
        if (error) {
            *error = state.error;
        }
        return NULL;
    }
    return &state.loaded;
}

ad_status ad_blas_status(void)
{
    return state.error.status;
}
