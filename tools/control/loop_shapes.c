#include "tools/control/loop_internal.h"

#include <math.h>
#include <stdlib.h>

enum { FRAMES = 401, X = 2, Q = 5, U = 9, ESTIMATED = 12 };

static const char *const names[LOOP_SHAPE_COLUMNS] = {
    "t",  "s",  "x",  "y",  "z",           "qw",          "qx",         "qy",
    "qz", "u1", "u2", "u3", "estimated_x", "estimated_y", "estimated_z"};
static const char *const units[LOOP_SHAPE_COLUMNS] = {"s", "m",   "m",   "m",   "m", "",  "", "",
                                                      "",  "1/m", "1/m", "1/m", "m", "m", "m"};

ad_status loop_shapes_create(control_loop *loop, ad_error *error)
{
    loop_record_of_shapes *to = &loop->shapes;
    const double length = scene_length(loop->of.nominal);
    double s[PLANT_POINTS];
    for (int i = 0; i < PLANT_POINTS; i++) {
        s[i] = length * i / (PLANT_POINTS - 1);
    }
    const observation_sensor sensor = {.what = OBSERVATION_POSITION, .count = PLANT_POINTS, .s = s};
    to->every = (loop->samples + FRAMES - 1) / FRAMES;
    to->room = PLANT_POINTS * (size_t)((loop->samples - 1) / to->every + 1);
    to->values = calloc(to->room * LOOP_SHAPE_COLUMNS, sizeof *to->values);
    for (int k = 0; k < LOOP_SHAPE_COLUMNS; k++) {
        to->columns[k] = to->values ? to->values + (size_t)k * to->room : NULL;
    }
    to->table = (table_source){
        .names = names, .units = units, .columns = to->columns, .ncols = LOOP_SHAPE_COLUMNS};
    return to->values ? observation_create(loop->of.nominal, loop->of.model->modes, &sensor,
                                           &to->observation, error)
                      : ad_fail(error, AD_NO_MEMORY, "out of memory for shapes");
}

void loop_shapes_free(control_loop *loop)
{
    observation_free(loop->shapes.observation);
    free(loop->shapes.values);
}

/* values [PLANT_POINTS][count] as columns from `first` on. */
static void put(loop_record_of_shapes *to, int first, int count, const double *values)
{
    for (int i = 0; i < PLANT_POINTS * count; i++) {
        const size_t row = to->table.nrows + (size_t)(i / count);
        to->values[(size_t)(first + i % count) * to->room + row] = values[i];
    }
}

ad_status loop_shapes_take(control_loop *loop, long k, ad_error *error)
{
    double position[3 * PLANT_POINTS], rotation[4 * PLANT_POINTS], curvature[3 * PLANT_POINTS];
    double estimated[3 * PLANT_POINTS], at[2 * PLANT_POINTS];
    loop_record_of_shapes *to = &loop->shapes;
    if (k % to->every != 0) {
        return AD_OK;
    }
    const ad_status status = plant_shape(loop->robot, position, rotation, curvature, error);
    if (status != AD_OK) {
        return status;
    }
    const estimator *filtered = regulator_estimator(loop->both);
    const one_observation seen = observation_of(to->observation);
    const bool known = seen.see(seen.context, 1, estimator_state(filtered),
                                estimator_inputs(filtered), estimated, NULL) == 0;
    for (int i = 0; i < PLANT_POINTS; i++) {
        at[2 * i] = (double)k * loop->period;
        at[2 * i + 1] = plant_length(loop->robot) * i / (PLANT_POINTS - 1);
    }
    for (int i = 0; i < 3 * PLANT_POINTS && !known; i++) {
        estimated[i] = NAN;
    }
    put(to, 0, 2, at);
    put(to, X, 3, position);
    put(to, Q, 4, rotation);
    put(to, U, 3, curvature);
    put(to, ESTIMATED, 3, estimated);
    to->table.nrows += PLANT_POINTS;
    return AD_OK;
}

const table_source *loop_shapes(const control_loop *loop)
{
    return &loop->shapes.table;
}
