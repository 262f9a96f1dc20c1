#include "autodiff/compile/kernels.h"

const kernel_set *ad_kernels_select(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
        return &ad_kernels_avx512;
    }
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        return &ad_kernels_avx2;
    }
#endif
    return &ad_kernels_baseline;
}
