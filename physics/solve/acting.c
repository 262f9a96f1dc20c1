#include "physics/solve/acting.h"

#include "physics/quaternion.h"

/* Each law is a function of its own, lest a short one pays for the registers of a long one. */
#define LAWS_INLINE static __attribute__((noinline, unused))
#include "physics/solve/laws.h"

#include <string.h>

void acting_add(acting *x, law_name law)
{
    const struct law *of = &law_table[law];
    x->law[x->count++] = law;
    x->numbers += of->numbers;
    x->kinds |= 1 << of->kind;
    x->has_moment |= of->has_moment;
    x->by_position |= of->by_position;
    x->by_rotation |= of->by_rotation;
    x->by_velocity |= of->by_velocity;
}

/* Of a unit rotation and a velocity. */
static acting_on complete(const acting *x, acting_on at, double q[4])
{
    static const double still[3] = {0};
    if (x->by_rotation) {
        memcpy(q, at.rotation, 4 * sizeof *q);
        quaternion_normalize(q);
    }
    return (acting_on){at.position, x->by_rotation ? q : at.rotation,
                       at.velocity ? at.velocity : still};
}

void acting_wrench(const acting *x, const double *numbers, acting_on at, int kinds, double weight,
                   double *wrench)
{
    double q[4], sum[6] = {0};
    at = complete(x, at, q);
    for (int i = 0; i < x->count; i++) {
        if (kinds & 1 << law_table[x->law[i]].kind) {
            number_law_outside_wrench(x->law[i], at.position, at.rotation, at.velocity, numbers,
                                      sum);
        }
        numbers += law_table[x->law[i]].numbers;
    }
    for (int k = 0; k < 6; k++) {
        wrench[k] += weight * sum[k];
    }
}

void acting_differentiate(const acting *x, const double *numbers, acting_on at, double weight,
                          acting_change *result)
{
    double q[4], *all = (double *)result, *by = all + 6;
    _Static_assert(sizeof *result == (6 + LAW_BY) * sizeof *all, "all of it, in this order");
    memset(result, 0, sizeof *result);
    at = complete(x, at, q);
    for (int i = 0; i < x->count; i++) {
        number_law_outside(x->law[i], at.position, at.rotation, at.velocity, numbers, all, by);
        numbers += law_table[x->law[i]].numbers;
    }
    for (int k = 0; k < 6; k++) {
        all[k] *= weight;
    }
    for (int k = 0; k < 18; k++) {
        by[k] *= x->by_position ? weight : 0;
        by[18 + k] *= x->by_rotation ? weight : 0;
        by[36 + k] *= x->by_velocity ? weight : 0;
    }
}

double acting_energy(const acting *x, const double *numbers, acting_on at)
{
    double q[4], energy = 0;
    at = complete(x, at, q);
    for (int i = 0; i < x->count; i++) {
        if (law_table[x->law[i]].kind == LAW_STORES) {
            number_law_outside_energy(x->law[i], at.position, at.rotation, at.velocity, numbers,
                                      &energy);
        }
        numbers += law_table[x->law[i]].numbers;
    }
    return energy;
}

double acting_pulled(const acting *x, const double *numbers)
{
    double sum = 0;
    for (int i = 0; i < x->count; i++) {
        const law *of = &law_table[x->law[i]];
        double square = 0;
        for (int k = 0; k < of->shares && of->kind == LAW_STORES; k++) {
            square += numbers[k] * numbers[k];
        }
        sum += sqrt(square);
        numbers += of->numbers;
    }
    return sum;
}

void acting_on_way(const acting *x, const double *full, double load, double way, double *numbers)
{
    for (int i = 0, first = 0; i < x->count; i++) {
        const law *of = &law_table[x->law[i]];
        for (int k = 0; k < of->numbers; k++, first++) {
            numbers[first] = (k >= of->shares         ? 1
                              : of->kind == LAW_LOADS ? load
                                                      : way) *
                             full[first];
        }
    }
}
