/* Liu & Nocedal, "On the limited memory BFGS method for large scale optimization", Mathematical
 * Programming 45 (1989); Nocedal & Wright, Numerical Optimization, 2nd ed. 2006, algorithms 7.4
 * and 7.5. */
#include "internal.h"

#include <math.h>
#include <string.h>

enum {
    GAMMA,     /* s.y / y.y of the newest pair */
    NEXT_SLOT, /* slot of the ring to write next */
    RING_SCALARS
};

typedef struct optim_lbfgs {
    optim_descent descent; /* first, so that a pointer to one points to the other */
    size_t memory;
    double *s;      /* [memory][count], steps */
    double *y;      /* [memory][count], gradient differences */
    double *sy;     /* [memory], s.y */
    double *weight; /* [memory], work: alpha of algorithm 7.4 */
    double ring[RING_SCALARS];
} optim_lbfgs;

static int parts(size_t count, const optim_settings *settings, optim_part *part)
{
    const size_t memory = (size_t)settings->memory;
    const optim_part own[] = {
        OPTIM_STATE(optim_lbfgs, s, memory, count), OPTIM_STATE(optim_lbfgs, y, memory, count),
        OPTIM_ANY(optim_lbfgs, sy, 1, memory, "sy"), OPTIM_WORK(optim_lbfgs, weight, 1, memory),
        OPTIM_ANY(optim_lbfgs, ring, 0, RING_SCALARS, "ring")};
    return optim_descent_parts(count, sizeof own / sizeof *own, own, part);
}

/* ---- the model ---- */

/* a[count] += factor * b[count] */
static void add(size_t count, double *restrict a, double factor, const double *restrict b)
{
    for (size_t i = 0; i < count; i++) {
        a[i] += factor * b[i];
    }
}

/* The two-loop recursion, algorithm 7.4. */
static void apply(void *self, const double *gradient, double *result)
{
    optim_lbfgs *lbfgs = self;
    const size_t count = lbfgs->descent.count;
    const size_t memory = lbfgs->memory;
    const size_t pairs = (size_t)lbfgs->descent.scalar[OPTIM_PAIRS];
    const size_t next = (size_t)lbfgs->ring[NEXT_SLOT];
    memcpy(result, gradient, count * sizeof *result);
    for (size_t age = 1; age <= pairs; age++) {
        const size_t slot = (next + memory - age) % memory;
        const double weight = optim_dot(count, lbfgs->s + slot * count, result) / lbfgs->sy[slot];
        lbfgs->weight[slot] = weight;
        add(count, result, -weight, lbfgs->y + slot * count);
    }
    for (size_t i = 0; i < count; i++) {
        result[i] *= lbfgs->ring[GAMMA];
    }
    for (size_t age = pairs; age >= 1; age--) {
        const size_t slot = (next + memory - age) % memory;
        const double weight = optim_dot(count, lbfgs->y + slot * count, result) / lbfgs->sy[slot];
        add(count, result, lbfgs->weight[slot] - weight, lbfgs->s + slot * count);
    }
}

/* Over the oldest pair, when the ring is full. */
static void learn(void *self, const optim_pair *pair)
{
    optim_lbfgs *lbfgs = self;
    const size_t count = lbfgs->descent.count;
    double *pairs = &lbfgs->descent.scalar[OPTIM_PAIRS];
    const size_t slot = *pairs > 0 ? (size_t)lbfgs->ring[NEXT_SLOT] : 0;
    memcpy(lbfgs->s + slot * count, pair->s, count * sizeof *lbfgs->s);
    memcpy(lbfgs->y + slot * count, pair->y, count * sizeof *lbfgs->y);
    lbfgs->sy[slot] = pair->sy;
    lbfgs->ring[GAMMA] = pair->sy / pair->yy;
    lbfgs->ring[NEXT_SLOT] = (double)((slot + 1) % lbfgs->memory);
    *pairs = fmin(*pairs + 1, (double)lbfgs->memory);
}

static const optim_model model = {apply, learn};

static double bytes(const optim_settings *settings, size_t count)
{
    return 8 * (double)count * (2 * settings->memory + 7);
}

static void begin(void *own, size_t count, const double *x, const optim_settings *settings)
{
    optim_lbfgs *lbfgs = own;
    lbfgs->memory = (size_t)settings->memory;
    optim_descent_begin(&lbfgs->descent, count, x, settings, &model);
}

/* ---- stepping and looking ---- */

static const char *check_scalars(const optim_lbfgs *lbfgs)
{
    const double *ring = lbfgs->ring;
    if (!optim_is_counter(ring[NEXT_SLOT], (double)lbfgs->memory - 1)) {
        return "ring: the next slot does not fit in memory";
    }
    if (lbfgs->descent.scalar[OPTIM_PAIRS] > 0 && !(ring[GAMMA] > 0 && isfinite(ring[GAMMA]))) {
        return "ring: the scale of the history is not positive";
    }
    return optim_descent_check_scalars(&lbfgs->descent, (double)lbfgs->memory);
}

static optim_status step(void *own, const optim_target *target)
{
    optim_lbfgs *lbfgs = own;
    return check_scalars(lbfgs) ? OPTIM_BAD_STATE : optim_descent_step(&lbfgs->descent, target);
}

static const char *state_check(const void *own)
{
    const optim_lbfgs *lbfgs = own;
    const optim_descent *d = &lbfgs->descent;
    const size_t memory = lbfgs->memory;
    const char *problem = check_scalars(lbfgs);
    for (size_t age = 1; !problem && age <= (size_t)d->scalar[OPTIM_PAIRS]; age++) {
        const double sy = lbfgs->sy[((size_t)lbfgs->ring[NEXT_SLOT] + memory - age) % memory];
        if (!(sy > 0 && isfinite(sy))) {
            problem = "sy holds a number that is not finite and positive";
        }
    }
    return problem;
}

const optim_kind optim_lbfgs_kind = {
    .about = "L-BFGS with a line search",
    .needs = OPTIM_NEEDS_ONE_FUNCTION,
    .reads = OPTIM_READS_MEMORY | OPTIM_READS_LINES | OPTIM_READS_TOLERANCES,
    .check = optim_descent_check,
    .bytes = bytes,
    .size = sizeof(optim_lbfgs),
    .parts = parts,
    .begin = begin,
    .step = step,
    .objective_changed = optim_descent_objective_changed,
    .x = optim_descent_x,
    .inspect = optim_descent_inspect,
    .state_check = state_check,
    .advice = "more steps of adam before, or a smaller maximum_step"};
