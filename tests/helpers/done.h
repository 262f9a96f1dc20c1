/* For tests: calls that succeed, with what they say where they do not, and calls that refuse. */
#ifndef TESTS_DONE_H
#define TESTS_DONE_H

#include "autodiff/ad.h"
#include "near.h"

#include <string.h>

static ad_error error; /* of the last call */

#define DONE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != AD_OK) {                                                                     \
            fail_msg("%s", error.message);                                                         \
        }                                                                                          \
    } while (0)

/* As bad input, in words among which are these. */
#define REFUSED(call, words)                                                                       \
    do {                                                                                           \
        error.message[0] = '\0';                                                                   \
        assert_int_equal((call), AD_BAD_INPUT);                                                    \
        if (!strstr(error.message, (words))) {                                                     \
            fail_msg("'%s' says nothing of '%s'", error.message, (words));                         \
        }                                                                                          \
    } while (0)

#endif
