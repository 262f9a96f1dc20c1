/* How many modes a one-step model's rod needs. */
#include "physics/numerics/quaternion.h"
#include "physics/numerics/sort.h"
#include "tools/surrogate/surrogate.h"
#include "tools/surrogate/training_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Rollouts by which modes are judged, and their steps. */
enum { JUDGED = 4, JUDGED_STEPS = 100 };

static const int tried[][4] = {{1, 1, 1, 0}, {2, 1, 1, 0}, {2, 1, 2, 0}, {2, 1, 2, 1}, {3, 1, 2, 1},
                               {3, 2, 3, 1}, {3, 2, 3, 2}, {4, 2, 3, 2}, {4, 3, 4, 2}};
static const int finest[4] = {5, 3, 4, 3};

/* Tips [JUDGED][JUDGED_STEPS][3] of rollouts, NaN where they end before. */
static ad_status roll(const scene *open, const surrogate_settings *settings, const int modes[4],
                      ad_pool *pool, uint64_t seed, double *tips, ad_error *error)
{
    const double length = scene_length(open);
    const reduced_settings reduced = {
        .modes = {modes[0], modes[1], modes[2], modes[3]}, .count = 1, .s = &length};
    excitation_settings how = excitation_settings_default();
    excitation_rollouts motions = {0};
    reduced_rod *rod = NULL;
    memcpy(how.modes, modes, sizeof how.modes);
    how.step = settings->step;
    how.steps = JUDGED_STEPS;
    how.count = JUDGED;
    how.seed = seed;
    how.linear = settings->hold == SURROGATE_RAMP;
    for (int i = 0; i < open->parameter_count; i++) {
        if (surrogate_names_parameter(settings, open->parameters[i].name)) {
            how.constant |= UINT32_C(1) << i;
        }
    }
    ad_status status = reduced_create(open, &reduced, &rod, error);
    status = status == AD_OK ? excitation_run(open, &how, pool, &motions, error) : status;
    for (int i = 0; i < JUDGED * JUDGED_STEPS && status == AD_OK; i++) {
        const int r = i / JUDGED_STEPS, k = i % JUDGED_STEPS + 1;
        const size_t row = (size_t)r * (JUDGED_STEPS + 1) + (size_t)k;
        reduced_place tip = {.position = {NAN, NAN, NAN}};
        if (k <= motions.done[r]) {
            status =
                reduced_output(rod, 0, motions.state + row * (size_t)motions.states,
                               motions.input + row * (size_t)motions.inputs, &tip, NULL, error);
        }
        memcpy(tips + 3 * i, tip.position, sizeof tip.position);
    }
    excitation_free(&motions);
    reduced_free(rod);
    return status;
}

/* Median distance over the length. */
static double distance(const double *a, const double *b, double length)
{
    double all[JUDGED * JUDGED_STEPS];
    size_t count = 0;
    for (int i = 0; i < JUDGED * JUDGED_STEPS; i++) {
        all[count] = vector_distance(a + 3 * i, b + 3 * i) / length;
        count += !isnan(all[count]);
    }
    return count > 0 ? sort_median(count, all) : NAN;
}

ad_status surrogate_choose_modes(const scene *open, surrogate_settings *settings, ad_pool *pool,
                                 uint64_t seed, char text[256], ad_error *error)
{
    static const int none[4] = {0, 0, 0, 0};
    const size_t count = sizeof tried / sizeof *tried;
    double off = NAN, *tips = malloc(sizeof *tips * 2 * 3 * JUDGED * JUDGED_STEPS);
    text[0] = '\0';
    if (memcmp(settings->modes, none, sizeof none) != 0 || !tips) {
        const bool given = tips != NULL;
        free(tips);
        return given ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for modes");
    }
    double *now = tips + 3 * JUDGED * JUDGED_STEPS;
    ad_status status = roll(open, settings, finest, pool, seed, tips, error);
    for (size_t i = 0; i < count && status == AD_OK && !(off <= settings->tolerance); i++) {
        status = roll(open, settings, tried[i], pool, seed, now, error);
        off = distance(tips, now, scene_length(open));
        memcpy(settings->modes, tried[i], sizeof settings->modes);
    }
    free(tips);
    snprintf(
        text, 256,
        "modes: %d bending, %d twist, %d stretch, %d shear; tip within %.2g %% of the length of "
        "%d, %d, %d, %d modes (median; surrogate.tolerance %.2g %%)",
        settings->modes[0], settings->modes[1], settings->modes[2], settings->modes[3], 100 * off,
        finest[0], finest[1], finest[2], finest[3], 100 * settings->tolerance);
    return status;
}
