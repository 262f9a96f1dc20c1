#include "tools/optimize/motion_parts.h"

#include "physics/numerics/quaternion.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = RESPONSE_MOTION_COLUMNS, NAME_BYTES = 64 };

void motion_rod_free(motion_rod *rod)
{
    if (rod) {
        for (int i = 0; i < rod->bounds; i++) {
            response_free(rod->bound[i].of);
        }
        reduced_free(rod->rod);
        ad_memory_free(&rod->memory);
        free(rod);
    }
}

double motion_bound_excess(const motion_bound *bound, double value)
{
    return isnan(value) ? INFINITY : fmax(0, fmax(bound->low - value, value - bound->high));
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_status make_rod(motion_rod *rod, const optimize_settings *settings, const scene *family,
                          const int *modes, size_t points, char *key, ad_error *error)
{
    AD_TAKE(rod, s, points + OPTIMIZE_PLACES_MAX);
    ad_status status = rod->s ? optimize_put_places(settings, scene_length(family), points, rod->s,
                                                    &rod->points, rod->place, key, error)
                              : ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    if (status == AD_OK) {
        const reduced_settings asked = {.modes = {modes[0], modes[1], modes[2], modes[3]},
                                        .count = (int)rod->points,
                                        .s = rod->s,
                                        .newton = 1e-10};
        snprintf(key, OPTIMIZE_KEY_MAX, "optimize.motion");
        status = reduced_create(family, &asked, &rod->rod, error);
    }
    if (status == AD_OK) {
        rod->states = reduced_states(rod->rod);
        rod->inputs = reduced_inputs(rod->rod);
        rod->directions = 2 * (size_t)rod->inputs + (size_t)rod->states;
        rod->look = *reduced_kinematics(rod->rod);
        rod->look.rows = (int)rod->points * KINEMATICS_ROWS;
    }
    return status;
}

/* Formulas know "pull.rate", too, how fast an input changes. */
static ad_status read_bounds(motion_rod *rod, const optimize_settings *settings,
                             const scene *family, const environment *around, char *key,
                             ad_error *error)
{
    const int inputs = rod->inputs;
    char rate[SCENE_PARAMETERS_MAX][NAME_BYTES];
    optimize_names names;
    response_scope scope = optimize_scope(settings, family, rod->s, rod->place, &names);
    ad_status status = AD_OK;
    for (int i = 0; i < inputs; i++) {
        snprintf(rate[i], sizeof rate[i], "%s.rate", family->parameters[i].name);
        names.parameter[inputs + i] = rate[i];
    }
    scope.parameters = 2 * inputs;
    scope.more = rod->states;
    scope.around = around;
    scope.moves = true;
    for (int i = 0; i < settings->constraint_count && status == AD_OK; i++) {
        motion_bound *b = &rod->bound[i];
        snprintf(key, OPTIMIZE_KEY_MAX, "optimize.constraints[%d]", i);
        status = optimize_read_constraint(settings->constraints[i], &scope, rod->points, &b->of,
                                          &b->low, &b->high, error);
        rod->bounds += b->of != NULL;
        if (status == AD_OK && !(b->low < b->high)) {
            status = ad_fail(error, AD_BAD_INPUT,
                             "is an equality, which a motion does not keep at all times; allowed: "
                             "bounds one below the other");
        } else if (status == AD_OK && !reduced_is_placed(rod->rod)) {
            status =
                ad_fail(error, AD_BAD_INPUT,
                        "bounds a motion whose start inputs move; allowed: a start that stands "
                        "still");
        } else if (status == AD_OK) {
            b->rows = response_rows(b->of);
            b->scale = 1;
            rod->rows += b->rows;
        }
        for (int k = 0; k < inputs && status == AD_OK; k++) {
            rod->rates = rod->rates || response_needs_parameter(b->of, inputs + k);
        }
    }
    return status;
}

static ad_status allocate(motion_rod *rod, ad_error *error)
{
    const size_t points = rod->points, states = (size_t)rod->states, width = rod->directions;
    AD_TAKE(rod, seen, points);
    AD_TAKE(rod, row, points * KINEMATICS_ROWS);
    AD_TAKE(rod, values, points * COLUMNS);
    AD_TAKE(rod, by_state, points * KINEMATICS_ROWS * states);
    AD_TAKE(rod, jacobian, points * COLUMNS * width);
    AD_TAKE(rod, number, points);
    AD_TAKE(rod, slope, points * width);
    AD_TAKE(rod, room, points * KINEMATICS_SEEN + kinematics_room(&rod->look));
    if (rod->memory.is_short) {
        return ad_memory_status(&rod->memory, error, "out of memory for a motion");
    }
    for (int i = 0; i < rod->look.rows; i++) {
        rod->row[i] = i;
    }
    rod->look.row = rod->row;
    return AD_OK;
}

ad_status motion_rod_create(const optimize_settings *settings, const scene *family,
                            const environment *around, const int *modes, size_t points,
                            motion_rod **result, char key[OPTIMIZE_KEY_MAX], ad_error *error)
{
    motion_rod *rod = calloc(1, sizeof *rod);
    *result = NULL;
    ad_status status = rod ? make_rod(rod, settings, family, modes, points, key, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    status = status == AD_OK ? read_bounds(rod, settings, family, around, key, error) : status;
    status = status == AD_OK ? allocate(rod, error) : status;
    if (status != AD_OK) {
        motion_rod_free(rod);
        return status;
    }
    *result = rod;
    return AD_OK;
}

/* ---- looking ------------------------------------------------------------------------------- */

ad_status motion_rod_tip(motion_rod *rod, const double *state, const double *inputs,
                         reduced_place *tip, ad_error *error)
{
    const ad_status status = reduced_output(rod->rod, 0, state, inputs, rod->seen, NULL, error);
    *tip = rod->seen[rod->place[0]];
    return status;
}

/* Of a point: columns of shapes by what kinematics see, position, rotation, velocities, strains. */
static void take_columns(const double *seen, double *values)
{
    memcpy(values, seen, 7 * sizeof *values);
    memcpy(values + 7, seen + 13, 6 * sizeof *values);
    memcpy(values + 13, seen + 7, 6 * sizeof *values);
}

/* Their derivatives by the state, from rows with a turn of the world in place of the rotation. */
static void take_slopes(const motion_rod *rod, const double *seen, const double *rows,
                        double *jacobian)
{
    static const int row_of[COLUMNS] = {0,  1,  2,  -1, -1, -1, -1, 12, 13, 14,
                                        15, 16, 17, 6,  7,  8,  9,  10, 11};
    const size_t states = (size_t)rod->states, width = rod->directions;
    double *to = jacobian + 2 * (size_t)rod->inputs;
    for (int c = 0; c < COLUMNS; c++) {
        if (row_of[c] >= 0) {
            memcpy(to + (size_t)c * width, rows + (size_t)row_of[c] * states, states * sizeof *to);
        }
    }
    for (size_t k = 0; k < states; k++) {
        const double half[4] = {0, rows[3 * states + k] / 2, rows[4 * states + k] / 2,
                                rows[5 * states + k] / 2};
        double by[4];
        quaternion_product(half, seen + 3, by);
        for (size_t c = 0; c < 4; c++) {
            to[(3 + c) * width + k] = by[c];
        }
    }
}

ad_status motion_rod_look(motion_rod *rod, const double *state, const double *inputs,
                          const double *rates, double *values, double *by, ad_error *error)
{
    const size_t m = (size_t)rod->inputs, states = (size_t)rod->states, width = rod->directions;
    double *seen = rod->room + kinematics_room(&rod->look), given[2 * SCENE_PARAMETERS_MAX];
    ad_status status = AD_OK;
    kinematics_see(&rod->look, 1, state, seen, by ? rod->by_state : NULL, rod->room);
    for (size_t i = 0; i < rod->points; i++) {
        take_columns(seen + i * KINEMATICS_SEEN, rod->values + i * COLUMNS);
        if (by) {
            take_slopes(rod, seen + i * KINEMATICS_SEEN,
                        rod->by_state + i * KINEMATICS_ROWS * states,
                        rod->jacobian + i * COLUMNS * width);
        }
    }
    for (size_t i = 0; i < m; i++) {
        given[i] = inputs[i];
        given[m + i] = rates[i];
    }
    const response_shape shape = {.points = rod->points,
                                  .place = rod->place,
                                  .values = rod->values,
                                  .jacobian = rod->jacobian,
                                  .parameters = given};
    for (int i = 0; i < rod->bounds && status == AD_OK; i++) {
        status = response_evaluate(rod->bound[i].of, &shape, values, by, error);
        values += rod->bound[i].rows;
        by = by ? by + rod->bound[i].rows * width : NULL;
    }
    return status;
}
