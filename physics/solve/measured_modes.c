/* Motions of trials by modes: whether, by how many, and by how much more of them change. */
#include "physics/scene/support.h"
#include "physics/solve/measured_trials.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void solve_trials_find_modes(solve_trials *trials)
{
    scene middle;
    ad_error unused;
    scene_middle(&trials->open, &middle);
    trials->moves = trials->row[trials->rows - 1].inputs ||
                    (scene_is_dynamic(&middle) &&
                     support_check(&middle, SUPPORT_MODES, NULL, &unused) == AD_OK);
    memcpy(trials->modes, trials->row[0].set->modes, sizeof trials->modes);
}

static bool are_asked(const solve_trials *trials)
{
    const int *modes = trials->modes;
    return modes[0] + modes[1] + modes[2] + modes[3] > 0;
}

void solve_trials_modes(const solve_trials *trials, int modes[4])
{
    const int *from = are_asked(trials) ? trials->modes : TRIALS_MODES;
    for (int k = 0; k < 4; k++) {
        modes[k] = from[k] + (from[k] > 0 ? trials->more : 0);
    }
}

/* Numbers of modes as one number; v and u of them. */
static const int PACKED = SOLVE_MODES_MAX + 1;

double solve_trials_packed(const int of[6])
{
    const int modes[4] = {of[3] > of[4] ? of[3] : of[4], of[5], of[2],
                          of[0] > of[1] ? of[0] : of[1]};
    double number = 0;
    for (int k = 0; k < 4; k++) { /* other values may move what now stays as it is */
        number = PACKED * number + fmax(modes[k], TRIALS_MODES[k]);
    }
    return number;
}

void solve_trials_choose_modes(const solve_trials *trials, size_t experiment,
                               solve_settings *settings)
{
    uint64_t found = (uint64_t)trials->nodes[experiment];
    if (are_asked(trials) || (found == 0 && trials->rough)) {
        solve_trials_modes(trials, settings->modes);
        return;
    }
    for (int k = 3; k >= 0 && found > 0; k--) {
        const int modes = (int)(found % (uint64_t)PACKED) + trials->more;
        settings->modes[k] = modes < SOLVE_MODES_MAX ? modes : SOLVE_MODES_MAX;
        found /= (uint64_t)PACKED;
    }
    settings->tolerance *= trials->rough || trials->nodes[experiment] == 0 ? 1 : TRIALS_STEPS;
}

/* Of numbers of modes each by itself. */
static double larger(bool packed, double a, double b)
{
    double most = 0;
    for (int k = 0; k < 4 && packed; k++) {
        const double unit = pow(PACKED, k);
        most += unit * fmax(fmod(floor(a / unit), PACKED), fmod(floor(b / unit), PACKED));
    }
    return packed ? most : fmax(a, b);
}

ad_status solve_trials_choose(solve_trials *trials, const double *values, double *room, bool *more,
                              ad_error *error)
{
    const size_t count = trials->experiments, bytes = count * sizeof *trials->nodes;
    double *before = trials->nodes ? malloc(bytes) : NULL;
    *more = false;
    if (!before) {
        return trials->nodes ? ad_fail(error, AD_NO_MEMORY, "out of memory") : AD_OK;
    }
    memcpy(before, trials->nodes, bytes);
    memset(trials->nodes, 0, bytes);
    const ad_status status = solve_trials_run(trials, 1, values, false, room, error);
    for (size_t i = 0; i < count; i++) {
        const bool packed = trials->moves && !trials->row[trials->first[i]].inputs;
        const double most = larger(packed, before[i], trials->nodes[i]);
        *more = *more || (before[i] > 0 && most > before[i]);
        trials->nodes[i] = most;
    }
    free(before);
    return status;
}

ad_status solve_trials_reduction(solve_trials *trials, const double *values, double *rms,
                                 ad_error *error)
{
    enum { MORE = 2 };
    const size_t count = trials->residuals;
    double *room = trials->moves ? malloc(2 * count * sizeof *room) : NULL, sum = 0;
    *rms = 0;
    if (!room) {
        return trials->moves ? ad_fail(error, AD_NO_MEMORY, "out of memory") : AD_OK;
    }
    ad_status status = solve_trials_run(trials, 1, values, false, room, error);
    status = status == AD_OK ? solve_trials_record(trials, MORE, error) : status;
    for (size_t e = 0; e < trials->experiments; e++) {
        trials->nodes[e] *= trials->row[trials->first[e]].inputs ? 2 : 1;
    }
    status =
        status == AD_OK ? solve_trials_run(trials, 1, values, false, room + count, error) : status;
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        const double by = room[i] - room[count + i];
        sum += by * by;
    }
    *rms = sqrt(sum / (double)count);
    free(room);
    return status;
}
