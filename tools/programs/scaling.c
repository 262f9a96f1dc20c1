#include "tools/programs/scaling.h"

#include <math.h>
#include <stdbool.h>

const scaling_network scaling_memory = {"memory of a machine", 0.5e-6, 0.3e-6, 8e9};
const scaling_network scaling_infiniband = {"InfiniBand HDR100", 2e-6, 0.3e-6, 12e9};

scaling_time scaling_step(const scaling_machine *machine, int ranks, const scaling_load *load)
{
    const bool several = ranks > machine->ranks;
    const scaling_network *by = several ? &scaling_infiniband : &scaling_memory;
    const double beside = several ? machine->ranks : ranks,
                 crowded = fmax(1, beside * machine->threads / machine->processors),
                 bandwidth = by->bandwidth / (several ? beside : 1);
    scaling_time t = {.work = crowded * load->work, .repeated = crowded * load->repeated};
    if (ranks > 1) {
        t.sums =
            load->exchanges * (by->latency + (ranks - 1) * by->message) + load->bytes / bandwidth;
    }
    t.step = t.work + t.sums + t.repeated;
    return t;
}
