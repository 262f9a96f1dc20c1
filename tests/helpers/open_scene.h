/* For tests: a rod that neither shears nor stretches, with parameters, of which the last are to be
 * found; the rest is the test's. */
#ifndef TESTS_OPEN_SCENE_H
#define TESTS_OPEN_SCENE_H

#include "good.h"

#include "physics/scene/scene.h"

static inline void open_scene(scene *to, quantities *names, int count, int unknowns,
                              const scene_parameter *parameters, const double *guess, double length)
{
    ad_error error;
    scene_defaults(to);
    for (int i = 0; i < count; i++) {
        const scene_parameter *p = &parameters[i];
        assert_good(quantities_parameter(names, p->name, p->low, p->high, guess[i], &error),
                    &error);
        to->parameters[i] = parameters[i];
        to->guess[i] = guess[i];
    }
    to->parameter_count = count;
    to->unknown_count = unknowns;
    to->names = names;
    to->rod.model = SCENE_KIRCHHOFF;
    to->rod.length = quantity_number(length);
}

#endif
