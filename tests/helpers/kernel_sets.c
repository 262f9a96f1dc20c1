#include "kernel_sets.h"

#include <stddef.h>

const kernel_set *chosen_kernels;

const kernel_set *__real_ad_kernels_select(void);
const kernel_set *__wrap_ad_kernels_select(void);

const kernel_set *__wrap_ad_kernels_select(void)
{
    return chosen_kernels ? chosen_kernels : __real_ad_kernels_select();
}

int kernel_sets(const kernel_set *sets[KERNEL_SETS_MAX])
{
    int count = 0;
    sets[count++] = &ad_kernels_baseline;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        sets[count++] = &ad_kernels_avx2;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
        sets[count++] = &ad_kernels_avx512;
#endif
    return count;
}
