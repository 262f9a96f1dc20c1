#include "physics/solve/acting.h"

#include "physics/quaternion.h"

/* Each law is a function of its own, lest a short one pays for the registers of a long one. */
#define LAWS_INLINE static __attribute__((noinline, unused))
#include "physics/law/law_numbers.h"

#include <string.h>

static acting_kind kind_of(law_name law)
{
    const struct law *of = &law_table[law];
    if (of->kind != LAW_LOADS) {
        return of->kind == LAW_STORES ? ACTING_STORES : ACTING_DISSIPATES;
    }
    return of->by_position || of->by_rotation || of->by_velocity ? ACTING_OTHER_LOADS : ACTING_DEAD;
}

void acting_add(acting *x, law_name law)
{
    const struct law *of = &law_table[law];
    x->kind[x->count] = kind_of(law);
    x->law[x->count++] = law;
    x->numbers += of->numbers;
    x->kinds |= (int)kind_of(law);
    x->has_moment |= of->has_moment;
    x->follows |= of->has_force && of->by_rotation;
    x->by_position |= of->by_position;
    x->force_by_position |= law_force_by_position(of);
    x->moment_by_position |= of->by_position && of->has_moment;
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
        if (kinds & (int)x->kind[i]) {
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

static double size_of(int count, const double *x)
{
    double square = 0;
    for (int k = 0; k < count; k++) {
        square += x[k] * x[k];
    }
    return sqrt(square);
}

double acting_work(const acting *x, const double *numbers, acting_on from, acting_on to)
{
    double work = 0, q[2][4];
    from = complete(x, from, q[0]);
    to = complete(x, to, q[1]);
    for (int i = 0; i < x->count; i++) {
        const law *of = &law_table[x->law[i]];
        double energy[2] = {0};
        if (of->kind == LAW_LOADS && of->has_energy) {
            number_law_outside_energy(x->law[i], from.position, from.rotation, from.velocity,
                                      numbers, &energy[0]);
            number_law_outside_energy(x->law[i], to.position, to.rotation, to.velocity, numbers,
                                      &energy[1]);
        } else if (of->kind == LAW_LOADS && size_of(of->numbers, numbers) > 0) {
            energy[0] = NAN;
        }
        work += energy[0] - energy[1];
        numbers += of->numbers;
    }
    return work;
}

void acting_measure(const acting *x, const double *numbers, acting_on at, acting_size *sum)
{
    double q[4];
    at = complete(x, at, q);
    for (int i = 0; i < x->count; i++) {
        const law *of = &law_table[x->law[i]];
        double wrench[6] = {0};
        if (of->kind == LAW_LOADS) {
            number_law_outside_wrench(x->law[i], at.position, at.rotation, at.velocity, numbers,
                                      wrench);
            const double force = size_of(3, wrench), moment = size_of(3, wrench + 3);
            sum->force += force;
            sum->moment += moment;
            sum->follows = sum->follows || (of->by_rotation && force > 0);
        }
        sum->pulled += of->kind == LAW_STORES ? size_of(of->shares, numbers) : 0;
        numbers += of->numbers;
    }
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
