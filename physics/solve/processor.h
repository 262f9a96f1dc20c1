/* Loops compiled several times over, for the widest vectors of the processor at hand, unless a
 * compiler's options say which. Without contraction of products and sums (-ffp-contract=off)
 * results are the same on any. For static functions only: clang gives others names of its own. */
#ifndef PHYSICS_SOLVE_PROCESSOR_H
#define PHYSICS_SOLVE_PROCESSOR_H

/* ThreadSanitizer does not survive what chooses between them, which runs before it has begun. */
#if defined(__has_feature)
#define WATCHES_THREADS __has_feature(thread_sanitizer)
#elif defined(__SANITIZE_THREAD__)
#define WATCHES_THREADS 1
#else
#define WATCHES_THREADS 0
#endif

#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__AVX512F__) && !WATCHES_THREADS
#define FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define FOR_EACH_PROCESSOR
#endif

/* So many numbers side by side, anywhere in memory. */
enum { LANES = 8 };
typedef double lanes
    __attribute__((vector_size(LANES * sizeof(double)), aligned(sizeof(double)), may_alias));

/* Number c of each row [LANES]: put together in registers, as a vector that is read back from
 * memory waits for all that was stored there. */
#define LANES_OF(row, c)                                                                           \
    ((lanes){(row)[0][c], (row)[1][c], (row)[2][c], (row)[3][c], (row)[4][c], (row)[5][c],         \
             (row)[6][c], (row)[7][c]})

#endif
