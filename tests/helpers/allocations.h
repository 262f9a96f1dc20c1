/* Count the project's allocations and make the n-th of them fail; what a library does inside itself
 * is not seen. Programs that use it are linked with --wrap of these functions. */
#ifndef TESTS_ALLOCATIONS_H
#define TESTS_ALLOCATIONS_H

#include <stdbool.h>

extern long allocations;        /* counted so far */
extern long failing_allocation; /* 1, 2, 3, ...: the one that fails; 0: none */
extern bool allocations_count;

#endif
