#include "tools/control/kinematic_observation.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* States at once: those that kinematics_see has side by side. */
enum { LOOK_STATES = 8 };

int kinematic_observation_row(observation_what what)
{
    static const int rows[] = {[OBSERVATION_POSITION] = 0,         [OBSERVATION_ROTATION] = 3,
                               [OBSERVATION_DIRECTION] = 3,        [OBSERVATION_VELOCITY] = 6,
                               [OBSERVATION_ANGULAR_VELOCITY] = 9, [OBSERVATION_CURVATURE] = 15,
                               [OBSERVATION_STRAIN] = 12};
    return rows[what];
}

size_t kinematic_observation_room(const kinematics *rod)
{
    const int numbers =
        LOOK_STATES *
        (rod->places * (KINEMATICS_SEEN + OBSERVATION_ROWS * 2 * rod->modes) + 2 * rod->modes);
    return kinematics_room(rod) + (size_t)numbers;
}

/* Of a place that is seen [KINEMATICS_SEEN]. */
static void take_values(observation_what what, const double *seen, double *values)
{
    static const int first[] = {[OBSERVATION_POSITION] = 0,   [OBSERVATION_ROTATION] = 3,
                                [OBSERVATION_VELOCITY] = 7,   [OBSERVATION_ANGULAR_VELOCITY] = 10,
                                [OBSERVATION_CURVATURE] = 16, [OBSERVATION_STRAIN] = 13};
    const double *q = seen + 3;
    if (what == OBSERVATION_DIRECTION) {
        values[0] = 2 * (q[1] * q[3] + q[0] * q[2]);
        values[1] = 2 * (q[2] * q[3] - q[0] * q[1]);
        values[2] = 1 - 2 * (q[1] * q[1] + q[2] * q[2]);
        return;
    }
    memcpy(values, seen + first[what], (what == OBSERVATION_ROTATION ? 4 : 3) * sizeof *values);
}

/* From rows [OBSERVATION_ROWS][size] of a place, to by [.][stride]: a turn theta changes d3 by
 * theta x d3, and q by half of (0, theta) q. */
static void take_rows(observation_what what, const double *seen, int size, const double *rows,
                      int stride, double *by)
{
    const double *q = seen + 3;
    double d[3];
    if (what != OBSERVATION_ROTATION && what != OBSERVATION_DIRECTION) {
        for (int r = 0; r < OBSERVATION_ROWS; r++) {
            memcpy(by + r * stride, rows + r * size, (size_t)size * sizeof *by);
        }
        return;
    }
    take_values(OBSERVATION_DIRECTION, seen, d);
    for (int c = 0; c < size; c++) {
        const double theta[3] = {rows[c], rows[size + c], rows[2 * size + c]};
        double *to = by + c;
        if (what == OBSERVATION_ROTATION) {
            *to = -0.5 * (theta[0] * q[1] + theta[1] * q[2] + theta[2] * q[3]);
        }
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            if (what == OBSERVATION_ROTATION) {
                to[(1 + i) * stride] =
                    0.5 * (q[0] * theta[i] + theta[j] * q[1 + k] - theta[k] * q[1 + j]);
            } else {
                to[i * stride] = theta[j] * d[k] - theta[k] * d[j];
            }
        }
    }
}

static int see(void *context, int count, const double *states, const double *inputs, double *values,
               double *by_state)
{
    kinematic_observation *observation = context;
    const int places = observation->rod.places, size = 2 * observation->rod.modes,
              stride = size + observation->more;
    const int of_place = observation->what == OBSERVATION_ROTATION ? 4 : 3;
    double *seen = observation->room + kinematics_room(&observation->rod);
    double *rows = seen + LOOK_STATES * places * KINEMATICS_SEEN;
    double *alone = rows + LOOK_STATES * places * OBSERVATION_ROWS * size;
    bool finite = true;
    (void)inputs;
    for (int from = 0; from < count; from += LOOK_STATES) {
        const int now = count - from < LOOK_STATES ? count - from : LOOK_STATES;
        const double *at = states + from * stride;
        for (int i = 0; i < now && stride > size; i++) {
            memcpy(alone + i * size, at + i * stride, (size_t)size * sizeof *alone);
        }
        kinematics_see(&observation->rod, now, stride > size ? alone : at, seen,
                       by_state ? rows : NULL, observation->room);
        for (int i = 0; i < now * places; i++) {
            double *to = values + (from * places + i) * of_place;
            take_values(observation->what, seen + i * KINEMATICS_SEEN, to);
            for (int k = 0; k < of_place; k++) {
                finite &= isfinite(to[k]) != 0;
            }
            if (by_state) {
                double *by = by_state + (from * places + i) * of_place * stride;
                memset(by, 0, (size_t)(of_place * stride) * sizeof *by);
                take_rows(observation->what, seen + i * KINEMATICS_SEEN, size,
                          rows + i * OBSERVATION_ROWS * size, stride, by);
            }
        }
    }
    return finite ? 0 : 1;
}

one_observation kinematic_observation_of(kinematic_observation *observation)
{
    return (one_observation){.context = observation,
                             .states = 2 * observation->rod.modes + observation->more,
                             .values = observation->rod.places *
                                       (observation->what == OBSERVATION_ROTATION ? 4 : 3),
                             .see = see};
}
