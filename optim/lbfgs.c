/* Liu & Nocedal, "On the limited memory BFGS method for large scale optimization", Mathematical
 * Programming 45 (1989); Nocedal & Wright, Numerical Optimization, 2nd ed. 2006, algorithms 7.4
 * and 7.5. */
#include "internal.h"

#include <math.h>
#include <stdlib.h>
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
    double *room;   /* of all of them */
    double ring[RING_SCALARS];
} optim_lbfgs;

static void release(void *own)
{
    optim_lbfgs *lbfgs = own;
    if (lbfgs) {
        optim_descent_clear(&lbfgs->descent);
        free(lbfgs->room);
        free(lbfgs);
    }
}

static optim_lbfgs *allocate(size_t count, size_t memory)
{
    optim_lbfgs *lbfgs = calloc(1, sizeof *lbfgs);
    if (!lbfgs) {
        return NULL;
    }
    const int prepared = optim_descent_prepare(&lbfgs->descent, count);
    lbfgs->memory = memory;
    const optim_part parts[] = {{&lbfgs->s, memory, count},
                                {&lbfgs->y, memory, count},
                                {&lbfgs->sy, 1, memory},
                                {&lbfgs->weight, 1, memory}};
    lbfgs->room = optim_room_create(sizeof parts / sizeof *parts, parts);
    if (!prepared || !lbfgs->room) {
        release(lbfgs);
        return NULL;
    }
    return lbfgs;
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

static void *create(size_t count, const double *x, const optim_settings *settings)
{
    optim_lbfgs *lbfgs = allocate(count, (size_t)settings->memory);
    if (lbfgs) {
        optim_descent_begin(&lbfgs->descent, x, settings, &model, lbfgs);
    }
    return lbfgs;
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

static void objective_changed(void *own)
{
    optim_descent_objective_changed(&((optim_lbfgs *)own)->descent);
}

static int state(void *own, optim_array *arrays, int capacity)
{
    optim_lbfgs *lbfgs = own;
    optim_descent *d = &lbfgs->descent;
    const optim_array rows[] = {
        {"x", d->x, d->count},
        {"gradient", d->gradient, d->count},
        {"best_x", d->best_x, d->count},
        {"s", lbfgs->s, lbfgs->memory * d->count},
        {"y", lbfgs->y, lbfgs->memory * d->count},
        {"sy", lbfgs->sy, lbfgs->memory},
        {"ring", lbfgs->ring, RING_SCALARS},
        {"scalars", d->scalar, OPTIM_DESCENT_SCALARS},
    };
    return optim_copy_rows(arrays, capacity, rows, (int)(sizeof rows / sizeof rows[0]));
}

static const char *state_check(const void *own)
{
    const optim_lbfgs *lbfgs = own;
    const optim_descent *d = &lbfgs->descent;
    const size_t memory = lbfgs->memory;
    const char *problem = check_scalars(lbfgs);
    problem = problem ? problem : optim_descent_state_check(d);
    if (problem) {
        return problem;
    }
    if (!optim_all_finite(memory * d->count, lbfgs->s)) {
        return "s holds a number that is not finite";
    }
    if (!optim_all_finite(memory * d->count, lbfgs->y)) {
        return "y holds a number that is not finite";
    }
    for (size_t age = 1; age <= (size_t)d->scalar[OPTIM_PAIRS]; age++) {
        const double sy = lbfgs->sy[((size_t)lbfgs->ring[NEXT_SLOT] + memory - age) % memory];
        if (!(sy > 0 && isfinite(sy))) {
            return "sy holds a number that is not finite and positive";
        }
    }
    return NULL;
}

const optim_kind optim_lbfgs_kind = {
    .about = "L-BFGS with a line search",
    .needs = OPTIM_NEEDS_ONE_FUNCTION,
    .reads = OPTIM_READS_MEMORY | OPTIM_READS_LINES | OPTIM_READS_TOLERANCES,
    .check = optim_descent_check,
    .bytes = bytes,
    .create = create,
    .free = release,
    .step = step,
    .objective_changed = objective_changed,
    .x = optim_descent_x,
    .inspect = optim_descent_inspect,
    .state = state,
    .state_check = state_check,
    .advice = "more steps of adam before, or a smaller maximum_step"};
