#include "physics/local/acting_lanes.h"

#include "physics/law/laws_lanes.h"

#include <string.h>

_Static_assert(sizeof(acting_lanes) == (6 + LAW_BY) * sizeof(lanes), "all of it, in this order");

/* Whether a law is asked before positions are known, or then; and whether of force and moment one
 * is asked then alone. */
static bool is_asked(const law *of, bool placed)
{
    return placed ? of->by_position : !law_force_by_position(of);
}

static bool is_half(const law *of)
{
    return of->by_position && !law_force_by_position(of);
}

/* Force or moment. */
PROCESSOR_INLINE void add_half(const acting_lanes *from, bool moment, acting_lanes *to)
{
    for (int i = moment ? 3 : 0, end = i + 3; i < end; i++) {
        to->wrench[i] += from->wrench[i];
        for (int k = 0; k < 3; k++) {
            to->by_position[i][k] += from->by_position[i][k];
            to->by_turn[i][k] += from->by_turn[i][k];
        }
    }
}

FOR_EACH_PROCESSOR static void find(const acting *acting, const lanes *numbers, bool placed,
                                    const lanes *position, const lanes *rotation,
                                    acting_lanes *result)
{
    const lanes still[3] = {{0}};
    memset(result, 0, sizeof *result);
    for (int i = 0; i < acting->count; i++) {
        const law *of = &law_table[acting->law[i]];
        if (is_asked(of, placed)) {
            acting_lanes half;
            lanes *all = (lanes *)result;
            if (is_half(of)) {
                all = memset(&half, 0, sizeof half);
            }
            lanes_law_outside(acting->law[i], position, rotation, still, numbers, all,
                              all + LAW_WRENCH);
            if (is_half(of)) {
                add_half(&half, placed, result);
            }
        }
        numbers += law_table[acting->law[i]].numbers;
    }
}

void acting_lanes_of(const acting *acting, const lanes *numbers, bool placed, const lanes *position,
                     const lanes *rotation, acting_lanes *result)
{
    find(acting, numbers, placed, position, rotation, result);
}

FOR_EACH_PROCESSOR static void change(const acting *acting, const lanes *numbers,
                                      const lanes *changes, bool placed, const lanes *position,
                                      const lanes *rotation, lanes *wrench)
{
    const lanes still[3] = {{0}};
    memset(wrench, 0, LAW_WRENCH * sizeof *wrench);
    for (int i = 0, first = 0; i < acting->count; i++) {
        const law *of = &law_table[acting->law[i]];
        if (is_asked(of, placed)) {
            const int from = is_half(of) && placed ? 3 : 0, to = is_half(of) && !placed ? 3 : 6;
            lanes all[LAW_WRENCH] = {{0}};
            lanes_law_outside_wrench_change(acting->law[i], position, rotation, still,
                                            numbers + first, changes + first, all);
            for (int k = from; k < to; k++) {
                wrench[k] += all[k];
            }
        }
        first += of->numbers;
    }
}

void acting_lanes_change(const acting *acting, const lanes *numbers, const lanes *changes,
                         bool placed, const lanes *position, const lanes *rotation, lanes *wrench)
{
    change(acting, numbers, changes, placed, position, rotation, wrench);
}

FOR_EACH_PROCESSOR static void scale_numbers(const acting *acting, const lanes *full,
                                             const lanes *share, lanes *numbers)
{
    for (int i = 0, first = 0; i < acting->count; i++) {
        const law *of = &law_table[acting->law[i]];
        for (int k = 0; k < of->numbers; k++, first++) {
            numbers[first] = full[first];
            if (k < of->shares) {
                numbers[first] *= *share;
            }
        }
    }
}

void acting_lanes_on_way(const acting *acting, const lanes *full, const lanes *share,
                         lanes *numbers)
{
    scale_numbers(acting, full, share, numbers);
}
