/* What a host of the library has in its thread: the floating-point environment. */
#ifndef AD_HOST_H
#define AD_HOST_H

#include <fenv.h>
#include <stdbool.h>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

typedef struct ad_host {
    bool left; /* its environment is not the default one */
    fenv_t environment;
} ad_host;

/* Rounding to nearest, subnormal numbers are kept, and no exception is a signal. The register of
 * SSE says it of both units, in a hundredth of the time. */
static inline bool ad_host_is_default(void)
{
#if defined(__SSE2__)
    const unsigned raised = 0x3f, usual = 0x1f80;
    return (_mm_getcsr() & ~raised) == usual;
#else
    return false;
#endif
}

/* The default environment in place of the caller's; threads that are started have it, too. */
static inline ad_host ad_host_leave(void)
{
    ad_host host;
    host.left = !ad_host_is_default();
    if (host.left) {
        fegetenv(&host.environment);
        fesetenv(FE_DFL_ENV);
    }
    return host;
}

static inline void ad_host_return(const ad_host *host)
{
    if (host->left) {
        fesetenv(&host->environment);
    }
}

/* The first declaration of a function that a host calls and that computes: until it returns, the
 * environment is the default one. Solvers try steps that end in NaN and infinity, on purpose; a
 * host that has made them signals receives none, and one that rounds otherwise or flushes subnormal
 * numbers gets the same results. */
#define AD_LEAVE_HOST                                                                              \
    __attribute__((unused, cleanup(ad_host_return))) const ad_host host = ad_host_leave()

#endif
