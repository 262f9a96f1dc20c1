/* What the harnesses of libFuzzer share: built with clang where CPINN_FUZZ is on, run by run.sh. */
#ifndef TESTS_FUZZ_FUZZ_H
#define TESTS_FUZZ_FUZZ_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

/* Ends the process, which libFuzzer reports with the input. */
#define fuzz_require(condition)                                                                    \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

/* A copy that ends with a zero byte. */
static inline char *fuzz_text(const uint8_t *bytes, size_t size)
{
    char *text = malloc(size + 1);
    fuzz_require(text);
    memcpy(text, bytes, size);
    text[size] = 0;
    return text;
}

/* A refusal has a status and a message of one line. */
static inline void fuzz_refused(const ad_error *error)
{
    fuzz_require(error->status != AD_OK && error->message[0] && !strchr(error->message, '\n'));
}

#endif
