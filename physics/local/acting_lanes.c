#include "physics/local/acting_lanes.h"

#include "physics/law/laws_lanes.h"

#include <string.h>

_Static_assert(sizeof(acting_lanes) == (6 + LAW_BY) * sizeof(lanes), "all of it, in this order");

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
        if (placed ? of->by_position : !law_force_by_position(of)) {
            const bool is_half = of->by_position && !law_force_by_position(of);
            acting_lanes half;
            lanes *all = (lanes *)result;
            if (is_half) {
                all = memset(&half, 0, sizeof half);
            }
            lanes_law_outside(acting->law[i], position, rotation, still, numbers, all,
                              all + LAW_WRENCH);
            if (is_half) {
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
