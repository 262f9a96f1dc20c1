#include "nn/rng.h"

#include <math.h>

static const double two_pi = 6.28318530717958647693;

uint64_t nn_splitmix64(uint64_t *state)
{
    *state += UINT64_C(0x9E3779B97F4A7C15);
    uint64_t mixed = *state;
    mixed = (mixed ^ (mixed >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    mixed = (mixed ^ (mixed >> 27)) * UINT64_C(0x94D049BB133111EB);
    return mixed ^ (mixed >> 31);
}

nn_rng nn_rng_seed(uint64_t seed)
{
    /* Four consecutive outputs differ from each other, so they cannot all be zero. */
    nn_rng rng;
    for (int word = 0; word < 4; word++) {
        rng.state[word] = nn_splitmix64(&seed);
    }
    return rng;
}

static uint64_t fnv1a(const char *text)
{
    uint64_t hash = UINT64_C(0xCBF29CE484222325);
    for (const unsigned char *byte = (const unsigned char *)text; *byte; byte++) {
        hash = (hash ^ *byte) * UINT64_C(0x100000001B3);
    }
    return hash;
}

nn_rng nn_rng_split(uint64_t seed, const char *stream)
{
    /* The seed is mixed first: seeds are small numbers and would only touch a few bits. */
    return nn_rng_seed(nn_splitmix64(&seed) ^ fnv1a(stream));
}

static uint64_t rotate_left(uint64_t word, int bits)
{
    return (word << bits) | (word >> (64 - bits));
}

uint64_t nn_rng_next(nn_rng *rng)
{
    uint64_t *state = rng->state;
    const uint64_t result = rotate_left(state[0] + state[3], 23) + state[0];
    const uint64_t shifted = state[1] << 17;
    state[2] ^= state[0];
    state[3] ^= state[1];
    state[1] ^= state[2];
    state[0] ^= state[3];
    state[2] ^= shifted;
    state[3] = rotate_left(state[3], 45);
    return result;
}

double nn_rng_uniform(nn_rng *rng)
{
    return (double)(nn_rng_next(rng) >> 11) * 0x1p-53;
}

double nn_rng_between(nn_rng *rng, double low, double high)
{
    /* Two products instead of low + (high - low) u: the difference could overflow. */
    const double fraction = nn_rng_uniform(rng);
    const double value = low * (1.0 - fraction) + high * fraction;
    if (value >= high) {
        return nextafter(high, low);
    }
    return value < low ? low : value;
}

double nn_rng_normal(nn_rng *rng)
{
    /* 1 - u lies in (0, 1], where the logarithm is finite. */
    const double radius = sqrt(-2.0 * log(1.0 - nn_rng_uniform(rng)));
    return radius * cos(two_pi * nn_rng_uniform(rng));
}

uint64_t nn_rng_below(nn_rng *rng, uint64_t count)
{
    if (count == 0) {
        return 0;
    }
    /* The lowest 2^64 mod count outputs are refused; the rest is a whole number of cycles. */
    const uint64_t refused = (UINT64_C(0) - count) % count;
    uint64_t draw = nn_rng_next(rng);
    while (draw < refused) {
        draw = nn_rng_next(rng);
    }
    return draw % count;
}
