/* What of FMI 3.0 (fmi-standard.org) the functions of an FMU need: types as the standard's headers
 * name them, and how functions are exported and named.
 *
 * Define FMU_STANDARD_HEADERS to take them from an importer's own fmi3Functions.h. As there,
 * FMI3_FUNCTION_PREFIX is put before the names of all functions, which static linking of several
 * FMUs needs; FMI3_OVERRIDE_FUNCTION_PREFIX with FMI3_ACTUAL_FUNCTION_PREFIX goes before it. */
#ifdef FMU_STANDARD_HEADERS
#include "fmi3Functions.h"
#else

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;

typedef enum {
    fmi3Independent,
    fmi3Constant,
    fmi3Fixed,
    fmi3Tunable,
    fmi3Discrete,
    fmi3Dependent
} fmi3DependencyKind;

typedef enum {
    fmi3IntervalNotYetKnown,
    fmi3IntervalUnchanged,
    fmi3IntervalChanged
} fmi3IntervalQualifier;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment environment, fmi3Status status,
                                       fmi3String category, fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment environment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment environment,
                                               fmi3Float64 time, fmi3Boolean set, fmi3Boolean get,
                                               fmi3Boolean finished, fmi3Boolean can_return,
                                               fmi3Boolean *return_early, fmi3Float64 *return_time);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

#if !defined(FMI3_OVERRIDE_FUNCTION_PREFIX) && defined(FMI3_FUNCTION_PREFIX)
#define FMI3_ACTUAL_FUNCTION_PREFIX FMI3_FUNCTION_PREFIX
#endif

#ifndef FMI3_Export
#if defined(FMI3_ACTUAL_FUNCTION_PREFIX)
#define FMI3_Export
#elif defined(_WIN32) || defined(__CYGWIN__)
#define FMI3_Export __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI3_Export __attribute__((visibility("default")))
#else
#define FMI3_Export
#endif
#endif

#endif

/* FMU_FUNCTION(type, name) begins the definition of a function; the standard's headers have macros
 * of their own for the prefix. */
#if defined(FMU_STANDARD_HEADERS) || !defined(FMI3_ACTUAL_FUNCTION_PREFIX)
#define FMU_FUNCTION(type, name) FMI3_Export type name
#else
#define FMU_PASTE(prefix, name)    prefix##name
#define FMU_PREFIXED(prefix, name) FMU_PASTE(prefix, name)
#define FMU_FUNCTION(type, name)   FMI3_Export type FMU_PREFIXED(FMI3_ACTUAL_FUNCTION_PREFIX, name)
#endif
