#include "tools/control/look.h"

#include "physics/solve/reduced.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct look {
    kinematic_look look;
    reduced_rod *rod;
    int *row; /* [count][LOOK_ROWS] */
};

static ad_status allocate(look *look, const look_sensor *sensor, ad_error *error)
{
    const int first = kinematic_look_row(sensor->what);
    look->look = (kinematic_look){.what = sensor->what, .rod = *reduced_kinematics(look->rod)};
    look->look.room = calloc(kinematic_look_room(&look->look.rod), sizeof *look->look.room);
    look->row = calloc((size_t)(LOOK_ROWS * sensor->count) + 1, sizeof *look->row);
    if (!look->look.room || !look->row) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for what is seen");
    }
    for (int i = 0; i < LOOK_ROWS * sensor->count; i++) {
        look->row[i] = i / LOOK_ROWS * KINEMATICS_ROWS + first + i % LOOK_ROWS;
    }
    look->look.rod.row = look->row;
    look->look.rod.rows = LOOK_ROWS * sensor->count;
    return AD_OK;
}

ad_status look_create(const scene *rod_scene, const int modes[4], const look_sensor *sensor,
                      look **result, ad_error *error)
{
    reduced_settings settings = {.count = sensor->count, .s = sensor->s};
    look *x = calloc(1, sizeof *x);
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
        look_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void look_free(look *look)
{
    if (look) {
        reduced_free(look->rod);
        free(look->look.room);
        free(look->row);
        free(look);
    }
}

one_look look_of(look *look)
{
    return kinematic_look_of(&look->look);
}

const kinematic_look *look_kinematics(const look *look)
{
    return &look->look;
}

int look_depends_on(const look *look)
{
    const int modes = look->look.rod.modes;
    const bool moves = look->look.what == LOOK_VELOCITY || look->look.what == LOOK_ANGULAR_VELOCITY;
    return moves ? 2 * modes : modes;
}

void look_noise(int modes, const double *size, double *deviation, double *process)
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
