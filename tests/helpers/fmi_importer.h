/* For tests: an importer of FMUs, with the functions of one library at a time. */
#ifndef TESTS_FMI_IMPORTER_H
#define TESTS_FMI_IMPORTER_H

#include "near.h"

#include "tools/emit/fmi3_types.h"
#include "tools/files/file_bytes.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

/* Text of a file between two others; to be freed. */
static inline char *between(const char *path, const char *before, const char *after)
{
    unsigned char *bytes = NULL;
    size_t size = 0, whole = 0;
    ad_error error;
    assert_int_equal(file_bytes_read(path, 0, &bytes, &size, &whole, &error), AD_OK);
    char *from = strstr((char *)bytes, before), *to;
    assert_non_null(from);
    from += strlen(before);
    to = strstr(from, after);
    assert_non_null(to);
    char *result = strndup(from, (size_t)(to - from));
    free(bytes);
    return result;
}

typedef fmi3Status step_function(fmi3Instance);
typedef fmi3Status get_function(fmi3Instance, const fmi3ValueReference *, size_t, fmi3Float64 *,
                                size_t);
typedef fmi3Status set_function(fmi3Instance, const fmi3ValueReference *, size_t,
                                const fmi3Float64 *, size_t);
typedef fmi3Status product_function(fmi3Instance, const fmi3ValueReference *, size_t,
                                    const fmi3ValueReference *, size_t, const fmi3Float64 *, size_t,
                                    fmi3Float64 *, size_t);
typedef fmi3Status flags_function(fmi3Instance, fmi3Boolean *, fmi3Boolean *, fmi3Boolean *,
                                  fmi3Boolean *, fmi3Boolean *, fmi3Float64 *);

static void *library;
static int warnings, errors;

static inline void take_message(fmi3InstanceEnvironment environment, fmi3Status status,
                                fmi3String category, fmi3String message)
{
    (void)environment;
    (void)category;
    warnings += status == fmi3Warning;
    errors += status == fmi3Error && *message;
}

/* A function of the library, as ISO C has no cast from void * to it. */
#define FIND(type, name) (*(type **)find(&(void *){NULL}, name))
static inline void *find(void **place, const char *name)
{
    *place = dlsym(library, name);
    if (!*place) {
        fail_msg("no function %s", name);
    }
    return place;
}

static inline fmi3Status call(fmi3Instance instance, const char *name)
{
    return FIND(step_function, name)(instance);
}

static inline fmi3Instance importer_open(const char *path, const char *token, bool by_steps,
                                         bool event_mode)
{
    typedef fmi3Instance make_steps(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                    fmi3Boolean, fmi3Boolean, const fmi3ValueReference *, size_t,
                                    void *, fmi3LogMessageCallback, fmi3IntermediateUpdateCallback);
    typedef fmi3Instance make_exchange(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                       void *, fmi3LogMessageCallback);
    library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fail_msg("%s", dlerror());
    }
    return by_steps ? FIND(make_steps, "fmi3InstantiateCoSimulation")("a", token, NULL, false, true,
                                                                      event_mode, false, NULL, 0,
                                                                      NULL, take_message, NULL)
                    : FIND(make_exchange, "fmi3InstantiateModelExchange")("a", token, NULL, false,
                                                                          true, NULL, take_message);
}

static inline void end(fmi3Instance instance)
{
    typedef void end_function(fmi3Instance);
    FIND(end_function, "fmi3FreeInstance")(instance);
    dlclose(library);
}

static inline fmi3Status initialize(fmi3Instance instance, double start)
{
    typedef fmi3Status enter(fmi3Instance, fmi3Boolean, fmi3Float64, fmi3Float64, fmi3Boolean,
                             fmi3Float64);
    fmi3Status status =
        FIND(enter, "fmi3EnterInitializationMode")(instance, false, 0, start, true, 3);
    return status == fmi3OK ? call(instance, "fmi3ExitInitializationMode") : status;
}

static inline fmi3Status get(fmi3Instance instance, fmi3ValueReference reference, double *value)
{
    return FIND(get_function, "fmi3GetFloat64")(instance, &reference, 1, value, 1);
}

static inline fmi3Status set(fmi3Instance instance, fmi3ValueReference reference, double value)
{
    return FIND(set_function, "fmi3SetFloat64")(instance, &reference, 1, &value, 1);
}

static inline fmi3Status step(fmi3Instance instance, double time, double size, double *reached)
{
    typedef fmi3Status do_step(fmi3Instance, fmi3Float64, fmi3Float64, fmi3Boolean, fmi3Boolean *,
                               fmi3Boolean *, fmi3Boolean *, fmi3Float64 *);
    fmi3Boolean flags[3] = {true, true, true};
    fmi3Status status = FIND(do_step, "fmi3DoStep")(instance, time, size, true, &flags[0],
                                                    &flags[1], &flags[2], reached);
    assert_false(flags[0] || flags[1] || flags[2]);
    return status;
}

#endif
