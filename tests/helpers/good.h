/* For tests: calls that have to succeed, and say why where they do not. */
#ifndef TESTS_GOOD_H
#define TESTS_GOOD_H

#include "autodiff/error.h"
#include "near.h"

static inline void assert_good(ad_status status, const ad_error *error)
{
    if (status != AD_OK) {
        fail_msg("%s", error->message);
    }
}

#endif
