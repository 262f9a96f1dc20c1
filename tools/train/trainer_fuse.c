/* Steps by compiled programs: what an earlier run kept at once, the rest once a run has lasted. */
#include "autodiff/ranks.h"
#include "physics/numerics/clock.h"
#include "tools/train/run.h"
#include "tools/train/trainer_internal.h"

#include <string.h>

bool trainer_fuse_folder(char *path, bool make)
{
    enum { ROOM = 3900 };
    if (!run_cache_folder(path, ROOM, make)) {
        return false;
    }
    strcat(path, "/compiled");
    return true;
}

/* What fails is not tried again, and steps go on as they are. */
void trainer_fuse(trainer *t)
{
    problem_fuse_way way = t->lasts ? PROBLEM_FUSE_COMPILE : PROBLEM_FUSE_KEPT;
    const ad_ranks *ranks = ad_pool_ranks(t->e->pool);
    const bool first = ad_ranks_is_first(ranks); /* others take what it has kept by then */
    if (!t->lasts && clock_seconds(CLOCK_MONOTONIC) - t->began >
                         (first ? TRAINER_FUSE_AFTER : 3 * TRAINER_FUSE_AFTER)) {
        t->lasts = true;
        t->has_cache = trainer_fuse_folder(t->compiled, true);
    }
    if (t->has_cache) {
        problem_fuse(t->problem, t->compiled, way, &t->info.fused, NULL);
    }
}
