/* Loops compiled several times over, for the widest vectors of the processor at hand, unless a
 * compiler's options say which. Without contraction of products and sums (-ffp-contract=off)
 * results are the same on any. For static functions only: clang gives others names of its own. */
#ifndef PHYSICS_NUMERICS_PROCESSOR_H
#define PHYSICS_NUMERICS_PROCESSOR_H

/* Sanitizers watch the same operations in each version, and with all put into one function compile
 * a file for half a minute; ThreadSanitizer does not survive what chooses between versions either,
 * which runs before it has begun. */
#if defined(__has_feature)
#define SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#else
#define SANITIZED 0
#endif

#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__AVX512F__) && !SANITIZED
#define FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define FOR_EACH_PROCESSOR
#endif

/* What functions FOR_EACH_PROCESSOR are made of; a plain one would be for the oldest processor. */
#if SANITIZED
#define PROCESSOR_INLINE static inline __attribute__((unused))
#else
#define PROCESSOR_INLINE static inline __attribute__((always_inline, unused))
#endif

/* The same of large ones: compiled once for each processor, not again wherever they are called. */
#define PROCESSOR_CALLED FOR_EACH_PROCESSOR static

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
