#include "physics/solve/acting_lanes.h"

#include "physics/solve/laws_lanes.h"

#include <string.h>

_Static_assert(sizeof(acting_lanes) == (6 + LAW_BY) * sizeof(lanes), "all of it, in this order");

FOR_EACH_PROCESSOR static void find(const acting *x, const lanes *numbers, bool by_position,
                                    const lanes *position, const lanes *rotation,
                                    acting_lanes *result)
{
    const lanes still[3] = {{0}};
    lanes *all = (lanes *)result;
    memset(result, 0, sizeof *result);
    for (int i = 0; i < x->count; i++) {
        if (law_table[x->law[i]].by_position == by_position) {
            lanes_law_outside(x->law[i], position, rotation, still, numbers, all, all + LAW_WRENCH);
        }
        numbers += law_table[x->law[i]].numbers;
    }
}

void acting_lanes_of(const acting *x, const lanes *numbers, bool by_position, const lanes *position,
                     const lanes *rotation, acting_lanes *result)
{
    find(x, numbers, by_position, position, rotation, result);
}

FOR_EACH_PROCESSOR static void scale(const acting *x, const lanes *full, const lanes *share,
                                     lanes *numbers)
{
    for (int i = 0, first = 0; i < x->count; i++) {
        const law *of = &law_table[x->law[i]];
        for (int k = 0; k < of->numbers; k++, first++) {
            numbers[first] = full[first];
            if (k < of->shares) {
                numbers[first] *= *share;
            }
        }
    }
}

void acting_lanes_on_way(const acting *x, const lanes *full, const lanes *share, lanes *numbers)
{
    scale(x, full, share, numbers);
}
