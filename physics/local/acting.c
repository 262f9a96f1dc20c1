#include "physics/local/acting.h"

#include "physics/numerics/quaternion.h"

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

void acting_add(acting *acting, law_name law)
{
    const struct law *of = &law_table[law];
    acting->kind[acting->count] = kind_of(law);
    acting->law[acting->count++] = law;
    acting->numbers += of->numbers;
    acting->kinds |= (int)kind_of(law);
    acting->has_moment |= of->has_moment;
    acting->follows |= of->has_force && of->by_rotation;
    acting->by_position |= of->by_position;
    acting->force_by_position |= law_force_by_position(of);
    acting->moment_by_position |= of->by_position && of->has_moment;
    acting->by_rotation |= of->by_rotation;
    acting->by_velocity |= of->by_velocity;
}

/* Of a unit rotation and a velocity. */
static acting_on complete(const acting *acting, acting_on at, double q[4])
{
    static const double still[3] = {0};
    if (acting->by_rotation) {
        memcpy(q, at.rotation, 4 * sizeof *q);
        quaternion_normalize(q);
    }
    return (acting_on){at.position, acting->by_rotation ? q : at.rotation,
                       at.velocity ? at.velocity : still};
}

void acting_wrench(const acting *acting, const double *numbers, acting_on at, int kinds,
                   double weight, double *wrench)
{
    double q[4], sum[6] = {0};
    at = complete(acting, at, q);
    for (int i = 0; i < acting->count; i++) {
        if (kinds & (int)acting->kind[i]) {
            number_law_outside_wrench(acting->law[i], at.position, at.rotation, at.velocity,
                                      numbers, sum);
        }
        numbers += law_table[acting->law[i]].numbers;
    }
    for (int k = 0; k < 6; k++) {
        wrench[k] += weight * sum[k];
    }
}

void acting_differentiate(const acting *acting, const double *numbers, acting_on at, double weight,
                          acting_change *result)
{
    double q[4], *all = (double *)result, *by = all + 6;
    _Static_assert(sizeof *result == (6 + LAW_BY) * sizeof *all, "all of it, in this order");
    memset(result, 0, sizeof *result);
    at = complete(acting, at, q);
    for (int i = 0; i < acting->count; i++) {
        number_law_outside(acting->law[i], at.position, at.rotation, at.velocity, numbers, all, by);
        numbers += law_table[acting->law[i]].numbers;
    }
    for (int k = 0; k < 6; k++) {
        all[k] *= weight;
    }
    for (int k = 0; k < 18; k++) {
        by[k] *= acting->by_position ? weight : 0;
        by[18 + k] *= acting->by_rotation ? weight : 0;
        by[36 + k] *= acting->by_velocity ? weight : 0;
    }
}

double acting_energy(const acting *acting, const double *numbers, acting_on at)
{
    double q[4], energy = 0;
    at = complete(acting, at, q);
    for (int i = 0; i < acting->count; i++) {
        if (law_table[acting->law[i]].kind == LAW_STORES) {
            number_law_outside_energy(acting->law[i], at.position, at.rotation, at.velocity,
                                      numbers, &energy);
        }
        numbers += law_table[acting->law[i]].numbers;
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

double acting_work(const acting *acting, const double *numbers, acting_on from, acting_on to)
{
    double work = 0, q[2][4];
    from = complete(acting, from, q[0]);
    to = complete(acting, to, q[1]);
    for (int i = 0; i < acting->count; i++) {
        const law *of = &law_table[acting->law[i]];
        double energy[2] = {0};
        if (of->kind == LAW_LOADS && of->has_energy) {
            number_law_outside_energy(acting->law[i], from.position, from.rotation, from.velocity,
                                      numbers, &energy[0]);
            number_law_outside_energy(acting->law[i], to.position, to.rotation, to.velocity,
                                      numbers, &energy[1]);
        } else if (of->kind == LAW_LOADS && size_of(of->numbers, numbers) > 0) {
            energy[0] = NAN;
        }
        work += energy[0] - energy[1];
        numbers += of->numbers;
    }
    return work;
}

void acting_measure(const acting *acting, const double *numbers, acting_on at, acting_size *sum)
{
    double q[4];
    at = complete(acting, at, q);
    for (int i = 0; i < acting->count; i++) {
        const law *of = &law_table[acting->law[i]];
        double wrench[6] = {0};
        if (of->kind == LAW_LOADS) {
            number_law_outside_wrench(acting->law[i], at.position, at.rotation, at.velocity,
                                      numbers, wrench);
            const double force = size_of(3, wrench), moment = size_of(3, wrench + 3);
            sum->force += force;
            sum->moment += moment;
            sum->follows = sum->follows || (of->by_rotation && force > 0);
        }
        sum->pulled += of->kind == LAW_STORES ? size_of(of->shares, numbers) : 0;
        numbers += of->numbers;
    }
}

void acting_on_way(const acting *acting, const double *full, double load, double way,
                   double *numbers)
{
    for (int i = 0, first = 0; i < acting->count; i++) {
        const law *of = &law_table[acting->law[i]];
        for (int k = 0; k < of->numbers; k++, first++) {
            numbers[first] = (k >= of->shares         ? 1
                              : of->kind == LAW_LOADS ? load
                                                      : way) *
                             full[first];
        }
    }
}
