/* Seeded pseudo-random numbers: xoshiro256++ (Blackman and Vigna, ACM Trans. Math. Softw. 47(4),
 * 2021), seeded by splitmix64 (Steele, Lea and Flood, OOPSLA 2014).
 *
 * The whole state is the four words of nn_rng, so a checkpoint that stores them resumes the very
 * sequence. Integers and uniform numbers are the same on every machine; normal numbers are too, up
 * to the last-digit rounding of the C library's log and cos. */
#ifndef NN_RNG_H
#define NN_RNG_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct nn_rng {
    uint64_t state[4]; /* never all zero */
} nn_rng;

/* One step of splitmix64: advances *state and returns the next output. */
uint64_t nn_splitmix64(uint64_t *state);

/* Generator whose state is the first four splitmix64 outputs from `seed`. */
nn_rng nn_rng_seed(uint64_t seed);

/* Generator for one named use ("initialisation", "interior points") of a seed. Different names give
 * unrelated sequences, so one use may draw more numbers without changing another. The name enters
 * as its bytes, through FNV-1a. */
nn_rng nn_rng_split(uint64_t seed, const char *stream);

/* 64 uniform bits. */
uint64_t nn_rng_next(nn_rng *rng);

/* Uniform on [0, 1): a multiple of 2^-53. */
double nn_rng_uniform(nn_rng *rng);

/* Uniform on [low, high), low < high both finite. */
double nn_rng_between(nn_rng *rng, double low, double high);

/* Mean 0, variance 1 (Box and Muller 1958, cosine branch). Always consumes two outputs. */
double nn_rng_normal(nn_rng *rng);

/* Uniform on 0 .. count-1 without bias; 0 when count is 0. */
uint64_t nn_rng_below(nn_rng *rng, uint64_t count);

#ifdef __cplusplus
}
#endif

#endif
