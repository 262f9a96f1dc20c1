/* A model written by cpinn-export as NAME.h, compiled with -DHEADER='"NAME.h"' -DNAME=NAME
 * -DTYPE=double (or float) and the sanitizers: with inputs that it does not expect it says so, and
 * all that comes out is finite and the same whatever was in its memory; no exception of
 * floating-point numbers is raised. */
#define _GNU_SOURCE /* feenableexcept */
#include "export_fuzz.h"

#include HEADER

#define PASTE(a, b) a##_##b
#define JOIN(a, b)  PASTE(a, b)
#define OF(what)    JOIN(NAME, what)

enum { IN = OF(INPUTS), OUT = OF(OUTPUTS), BATCH = 3, ROUNDS = 2000 };

static TYPE memory[OF(MEMORY)];

static int is_beyond(const TYPE *in)
{
    const double part = sizeof(TYPE) < sizeof(double) ? 1e-6 : 1e-9;
    for (int i = 0; i < IN; i++) {
        const double low = OF(lower)[i], high = OF(upper)[i], rounding = part * (high - low);
        if (!(isgreaterequal(in[i], low - rounding) && islessequal(in[i], high + rounding))) {
            return OF(OUT_OF_RANGE);
        }
    }
    return 0;
}

int main(void)
{
    for (int round = 0; round < ROUNDS; round++) {
        TYPE in[BATCH][IN], out[4][BATCH * OUT], jacobian[2][BATCH * OUT * IN];
        int status[4] = {0}, beyond = 0;
        for (int i = 0; i < BATCH * IN; i++) {
            const int at = i % IN;
            in[i / IN][at] = (TYPE)fuzz_number(OF(lower)[at], OF(upper)[at], round % 2 ? 3 : 100);
        }
        fuzz_trap(1);
        fuzz_fill(memory, sizeof memory);
        status[0] = OF(eval_batch)(BATCH, in[0], out[0], memory);
        fuzz_fill(memory, sizeof memory);
        status[1] = OF(jacobian_batch)(BATCH, in[0], out[1], jacobian[0], memory);
        for (int k = 0; k < BATCH; k++) {
            beyond |= is_beyond(in[k]);
            fuzz_fill(memory, sizeof memory);
            status[2] |= OF(eval)(in[k], out[2] + k * OUT, memory);
            fuzz_fill(memory, sizeof memory);
            status[3] |= OF(jacobian)(in[k], out[3] + k * OUT, jacobian[1] + k * OUT * IN, memory);
        }
        fuzz_trap(0);
        for (int k = 0; k < 4; k++) {
            fuzz_require(status[k] == beyond, "a status is wrong", round);
            for (int i = 0; i < BATCH * OUT; i++) {
                fuzz_require(isfinite(out[k][i]), "an output is not finite", round);
            }
        }
        for (int i = 0; i < BATCH * OUT * IN; i++) {
            fuzz_require(isfinite(jacobian[0][i]), "a derivative is not finite", round);
        }
        fuzz_require(memcmp(out[0], out[2], sizeof out[0]) == 0 &&
                         memcmp(out[1], out[3], sizeof out[1]) == 0 &&
                         memcmp(jacobian[0], jacobian[1], sizeof jacobian[0]) == 0,
                     "what was in the memory makes a difference", round);
    }
    return fuzz_failures > 0;
}
