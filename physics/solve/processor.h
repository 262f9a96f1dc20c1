/* Loops compiled several times over, for the widest vectors of the processor at hand. Without
 * contraction of products and sums (-ffp-contract=off) results are the same on any. For static
 * functions only: clang gives others names of its own. */
#ifndef PHYSICS_SOLVE_PROCESSOR_H
#define PHYSICS_SOLVE_PROCESSOR_H

#if defined(__x86_64__)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define FOR_EACH_PROCESSOR
#endif

/* So many numbers side by side, anywhere in memory. */
enum { LANES = 8 };
typedef double lanes
    __attribute__((vector_size(LANES * sizeof(double)), aligned(sizeof(double)), may_alias));

#endif
