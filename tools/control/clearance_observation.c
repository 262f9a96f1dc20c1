#include "tools/control/clearance_observation.h"

#include <math.h>
#include <stddef.h>

size_t clearance_observation_room(const one_observation *places)
{
    return (size_t)places->values * (2 + (size_t)places->states);
}

/* Of a place, negative where it is not free, and its derivative; on the surface 0. */
static double distance_at(const triangle_tree *surface, const double p[3], double slope[3])
{
    double nearest[3];
    const double distance = triangle_tree_distance(surface, p, INFINITY, nearest);
    const double found = triangle_tree_is_free(surface, p) ? distance : -distance;
    for (int i = 0; i < 3; i++) {
        slope[i] = distance > 0 ? (p[i] - nearest[i]) / found : 0;
    }
    return found;
}

static int see_least(void *context, int count, const double *states, const double *inputs,
                     double *values, double *by_state)
{
    const clearance_observation *x = context;
    const one_observation *of = &x->places;
    const int n = of->states, places = of->values / 3;
    double *position = x->room, *gradient = position + of->values, *rows = gradient + of->values;
    for (int i = 0; i < count; i++, states += n, inputs += inputs ? of->inputs : 0) {
        double least = INFINITY, sum = 0;
        if (of->see(of->context, 1, states, inputs, position, by_state ? rows : NULL)) {
            return 1;
        }
        for (int k = 0; k < places; k++) { /* distances in the place of the first coordinate */
            position[3 * k] = distance_at(x->surface, position + 3 * k, gradient + 3 * k);
            least = fmin(least, position[3 * k]);
        }
        for (int j = 0; j < n && by_state; j++) {
            by_state[i * n + j] = 0;
        }
        for (int k = 0; k < places; k++) {
            sum += position[3 * k] = exp((least - position[3 * k]) / x->smooth);
        }
        for (int r = 0; r < of->values && by_state; r++) {
            const double part = position[r - r % 3] / sum * gradient[r];
            for (int j = 0; j < n; j++) {
                by_state[i * n + j] += part * rows[r * n + j];
            }
        }
        values[i] = least - x->smooth * log(sum) - x->radius;
    }
    return 0;
}

one_observation clearance_observation_of(clearance_observation *x)
{
    one_observation result = x->places;
    result.context = x;
    result.values = 1;
    result.see = see_least;
    return result;
}
