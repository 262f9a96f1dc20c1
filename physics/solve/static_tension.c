#include "physics/solve/static_tension.h"

#include "physics/local/complement.h"

#include <math.h>
#include <string.h>

enum { MOST = SCENE_TENDONS_MAX, STEPS_MAX = 40 };

/* Tensions, by EI/L^2, whose change lengths are differentiated with. */
static const double CHANGE = 1e-5;

/* Of the length: tendons that are longer by this are not too long. */
static const double LONGER = 1e-13;

/* The tendons of a system whose tensions are sought. */
typedef struct tensions {
    static_system *system;
    int count, which[MOST]; /* of the rod's actuators */
    double *all;            /* of the system */
} tensions;

static tensions tensions_of(static_system *system)
{
    const solve_rod *rod = system->rod;
    tensions t = {.system = system, .all = system->tensions};
    for (int i = 0; i < rod->actuators; i++) {
        if (rod->extents[i].has_length) {
            t.which[t.count++] = i;
        }
    }
    return t;
}

/* excess [count]: by how much each is longer than it may be. */
static void measure(const tensions *t, const double *y, double *excess)
{
    double all[SOLVE_ACTUATORS_MAX];
    static_system_excess(t->system, y, all);
    for (int i = 0; i < t->count; i++) {
        const solve_extent *extent = &t->system->rod->extents[t->which[i]];
        excess[i] = all[t->which[i]] - extent->compliance * t->all[t->which[i]];
    }
}

/* shorter [count][count], row by row: by how much tendon i becomes shorter with tension j. */
static void differentiate(const tensions *t, const static_tension_newton *newton, const double *y,
                          const double *excess, double *moved, double *shorter)
{
    double changed[MOST];
    for (int j = 0; j < t->count; j++) {
        double *tension = &t->all[t->which[j]], before = *tension;
        *tension += CHANGE;
        newton->step(newton->context, y, moved);
        measure(t, moved, changed);
        *tension = before;
        for (int i = 0; i < t->count; i++) {
            shorter[i * t->count + j] = (excess[i] - changed[i]) / CHANGE;
        }
    }
}

/* One step of the tensions, to those of the linear model of which no tendon with tension is slack
 * and none without is too long; its size over theirs, NaN: none. */
static double improve(const tensions *t, const static_tension_newton *newton, const double *y,
                      double *moved)
{
    double excess[MOST], shorter[MOST * MOST], x[MOST], change = 0, size = 1;
    measure(t, y, excess);
    differentiate(t, newton, y, excess, moved, shorter);
    for (int i = 0; i < t->count; i++) {
        for (int j = 0; j < t->count; j++) {
            excess[i] += shorter[i * t->count + j] * t->all[t->which[j]];
        }
    }
    if (!solve_complement(t->count, 0, shorter, excess, LONGER, x)) {
        return NAN;
    }
    for (int i = 0; i < t->count; i++) {
        double *tension = &t->all[t->which[i]];
        change = fmax(change, fabs(x[i] - *tension));
        size = fmax(size, fabs(x[i]));
        *tension = x[i];
    }
    return change / size;
}

bool static_tension_solve(static_system *system, const static_tension_newton *newton, double *y,
                          double *moved, long *steps)
{
    static const double small = 1e-12;
    tensions t = tensions_of(system);
    double before[SOLVE_ACTUATORS_MAX], last = INFINITY;
    memcpy(before, t.all, sizeof before);
    bool solved = newton->solve(newton->context, y, steps);
    for (int i = 0; i < STEPS_MAX && solved && t.count > 0; i++) {
        double change = improve(&t, newton, y, moved);
        solved = isfinite(change) && newton->solve(newton->context, y, steps);
        if (solved && (change <= small || (change < 1e-9 && change >= last))) {
            return true; /* or rounding does not let it fall any more */
        }
        last = change;
    }
    if (t.count > 0) {
        memcpy(t.all, before, sizeof before);
        return false;
    }
    return solved;
}
