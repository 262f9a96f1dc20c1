/* Status codes and the one-line message that goes with them; shared by autodiff, nn, physics and
 * the tools. A function that can fail returns an ad_status and, when it has an ad_error to write
 * to, says there what was wrong and what is allowed. Nothing here prints. */
#ifndef AD_ERROR_H
#define AD_ERROR_H

#include <stdarg.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One row per status: name, text. Code and text cannot drift apart. */
#define AD_STATUS_LIST(X)                                                                          \
    X(AD_OK, "success")                                                                            \
    X(AD_NO_MEMORY, "out of memory")                                                               \
    X(AD_BAD_SHAPE, "shapes do not fit")                                                           \
    X(AD_BAD_ARGUMENT, "argument out of range")                                                    \
    X(AD_NO_RULE, "operation has no such derivative rule")                                         \
    X(AD_NOT_FINITE, "a number stopped being finite")                                              \
    X(AD_BAD_INPUT, "bad input")                                                                   \
    X(AD_IO, "input or output failed")                                                             \
    X(AD_NO_BLAS, "OpenBLAS could not be loaded")                                                  \
    X(AD_BAD_PROGRAM, "a compiled program does not compute what its tape says")                    \
    X(AD_NOT_WRITTEN, "the system could not write a file")

typedef enum ad_status {
#define AD_STATUS_ENUM(name, text) name,
    AD_STATUS_LIST(AD_STATUS_ENUM)
#undef AD_STATUS_ENUM
        AD_STATUS_COUNT
} ad_status;

typedef struct ad_error {
    ad_status status;
    char message[512]; /* one line, no newline at the end */
} ad_error;

/* Text of a status, never NULL. */
const char *ad_status_text(ad_status status);

/* Control characters, which names and paths may have, become question marks. */
void ad_one_line(char *text);

/* The shortest of 15 to 17 digits that reads back as the same number in the present locale; returns
 * its length. */
int ad_number_text(double number, char text[32]);

/* Write status and a printf-style message to `error` (NULL: only return) and return `status`. */
ad_status ad_fail(ad_error *error, ad_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
ad_status ad_fail_list(ad_error *error, ad_status status, const char *format, va_list arguments)
    __attribute__((format(printf, 3, 0)));

#ifdef __cplusplus
}
#endif

#endif
