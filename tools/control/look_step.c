#include "tools/control/look_step.h"

#include <math.h>
#include <string.h>

/* So many states at a time. */
enum { LOOK_STATES = 8 };

int look_step_values(int what)
{
    return what == LOOK_ROTATION ? 4 : 3;
}

int look_step_row(int what)
{
    static const int rows[] = {
        [LOOK_POSITION] = 0,         [LOOK_ROTATION] = 3, [LOOK_DIRECTION] = 3, [LOOK_VELOCITY] = 6,
        [LOOK_ANGULAR_VELOCITY] = 9, [LOOK_STRAIN] = 12,  [LOOK_CURVATURE] = 15};
    return rows[what];
}

size_t look_step_room(const look_step *x)
{
    const size_t of_state =
        (size_t)(x->rod.places * KINEMATICS_SEEN) + (size_t)(x->rod.rows * 2 * x->rod.modes);
    return LOOK_STATES * of_state + kinematics_room(&x->rod);
}

/* d3 of the section, the last column of R(q). */
static void direction_of(const double q[4], double d[3])
{
    d[0] = 2 * (q[1] * q[3] + q[0] * q[2]);
    d[1] = 2 * (q[2] * q[3] - q[0] * q[1]);
    d[2] = q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3];
}

static void give_values(int what, const double *seen, double *to)
{
    const int row = look_step_row(what);
    if (what == LOOK_DIRECTION) {
        direction_of(seen + 3, to);
    } else {
        memcpy(to, seen + row + (row > 3), (size_t)look_step_values(what) * sizeof *to);
    }
}

/* by [4 or 3][n] of a turn's rows [3][n]: of q they are 1/2 (0, theta) q, of d theta x d. */
static void give_turned(int what, int n, const double q[4], const double *turn, double *by)
{
    double d[3];
    direction_of(q, d);
    for (int c = 0; c < n; c++) {
        const double x = turn[c], y = turn[n + c], z = turn[2 * n + c];
        if (what == LOOK_DIRECTION) {
            by[c] = y * d[2] - z * d[1];
            by[n + c] = z * d[0] - x * d[2];
            by[2 * n + c] = x * d[1] - y * d[0];
        } else {
            by[c] = -0.5 * (x * q[1] + y * q[2] + z * q[3]);
            by[n + c] = 0.5 * (x * q[0] + y * q[3] - z * q[2]);
            by[2 * n + c] = 0.5 * (y * q[0] + z * q[1] - x * q[3]);
            by[3 * n + c] = 0.5 * (z * q[0] + x * q[2] - y * q[1]);
        }
    }
}

/* Of one state. */
static void give_items(const look_step *x, const double *seen, const double *rows, double *values,
                       double *by_state)
{
    const int n = 2 * x->rod.modes;
    for (int i = 0; i < x->items; i++) {
        const look_item *item = &x->item[i];
        const double *here = seen + item->place * KINEMATICS_SEEN, *row = rows + item->row * n;
        const int count = look_step_values(item->what);
        give_values(item->what, here, values);
        values += count;
        if (by_state && look_step_row(item->what) == 3) {
            give_turned(item->what, n, here + 3, row, by_state);
        } else if (by_state) {
            memcpy(by_state, row, (size_t)(count * n) * sizeof *by_state);
        }
        by_state = by_state ? by_state + count * n : NULL;
    }
}

int look_step_see(const look_step *x, double *room, int count, const double *states, double *values,
                  double *by_state)
{
    const int n = 2 * x->rod.modes, seen_of = x->rod.places * KINEMATICS_SEEN;
    const int rows_of = x->rod.rows * n;
    double *rows = room + LOOK_STATES * seen_of, *rest = rows + LOOK_STATES * rows_of;
    double sum = 0;
    for (int first = 0; first < count; first += LOOK_STATES) {
        const int some = count - first < LOOK_STATES ? count - first : LOOK_STATES;
        kinematics_see(&x->rod, some, states + first * n, room, by_state ? rows : NULL, rest);
        for (int i = 0; i < some; i++) {
            const int at = (first + i) * x->values;
            give_items(x, room + i * seen_of, rows + i * rows_of, values + at,
                       by_state ? by_state + at * n : NULL);
        }
    }
    for (int i = 0; i < count * x->values; i++) {
        sum += 0 * values[i]; /* not a number where one is not finite */
    }
    return isnan(sum);
}
