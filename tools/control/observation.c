#include "tools/control/observation.h"

#include "physics/chain/reduced.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct observation {
    kinematic_observation observation;
    reduced_rod *rod;
    int *row; /* [count][OBSERVATION_ROWS] */
};

static ad_status allocate(observation *observation, const observation_sensor *sensor,
                          ad_error *error)
{
    const int first = kinematic_observation_row(sensor->what);
    observation->observation = (kinematic_observation){
        .what = sensor->what,
        .rod = *reduced_kinematics(observation->rod),
        .more = reduced_all_states(observation->rod) - 2 * reduced_modes(observation->rod)};
    observation->observation.room =
        calloc(kinematic_observation_room(&observation->observation.rod),
               sizeof *observation->observation.room);
    observation->row =
        calloc((size_t)(OBSERVATION_ROWS * sensor->count) + 1, sizeof *observation->row);
    if (!observation->observation.room || !observation->row) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for what is seen");
    }
    for (int i = 0; i < OBSERVATION_ROWS * sensor->count; i++) {
        observation->row[i] = i / OBSERVATION_ROWS * KINEMATICS_ROWS + first + i % OBSERVATION_ROWS;
    }
    observation->observation.rod.row = observation->row;
    observation->observation.rod.rows = OBSERVATION_ROWS * sensor->count;
    return AD_OK;
}

ad_status observation_create(const scene *rod_scene, const int modes[4],
                             const observation_sensor *sensor, observation **result,
                             ad_error *error)
{
    reduced_settings settings = {.count = sensor->count, .s = sensor->s};
    observation *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for what is seen");
    }
    memcpy(settings.modes, modes, sizeof settings.modes);
    ad_status status = reduced_create(rod_scene, &settings, &x->rod, error);
    if (status == AD_OK && !reduced_is_placed(x->rod)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "the start depends on t or on inputs; allowed: one that stays");
    }
    status = status == AD_OK ? allocate(x, sensor, error) : status;
    if (status != AD_OK) {
        observation_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void observation_free(observation *observation)
{
    if (observation) {
        reduced_free(observation->rod);
        free(observation->observation.room);
        free(observation->row);
        free(observation);
    }
}

one_observation observation_of(observation *observation)
{
    return kinematic_observation_of(&observation->observation);
}

const kinematic_observation *observation_kinematics(const observation *observation)
{
    return &observation->observation;
}

int observation_depends_on(const observation *observation)
{
    const int modes = observation->observation.rod.modes;
    const bool moves = observation->observation.what == OBSERVATION_VELOCITY ||
                       observation->observation.what == OBSERVATION_ANGULAR_VELOCITY;
    return moves ? 2 * modes : modes;
}

void observation_noise(int modes, const double *size, double *deviation, double *process)
{
    double largest[2] = {0, 0};
    for (int i = 0; i < 2 * modes; i++) {
        largest[i / modes] = fmax(largest[i / modes], size[i]);
    }
    for (int i = 0; i < 2 * modes; i++) { /* what hardly moves is not known exactly, either */
        const double scale = fmax(size[i], 1e-6 * largest[i / modes]);
        deviation[i] = 0.02 * scale;
        process[i] = (i < modes ? 1e-3 : 0.02) * scale;
    }
}
