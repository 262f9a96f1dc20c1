/* Programs and kernels for every instruction set that this processor has. */
#ifndef TESTS_KERNEL_SETS_H
#define TESTS_KERNEL_SETS_H

#include "autodiff/compile/kernels.h"

extern const kernel_set *chosen_kernels; /* for programs; NULL: as the library would */

enum { KERNEL_SETS_MAX = 3 };
int kernel_sets(const kernel_set *sets[KERNEL_SETS_MAX]); /* how many */

#endif
