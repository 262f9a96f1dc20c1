/* Laws of a section with random numbers. */
#ifndef LAW_TESTING_H
#define LAW_TESTING_H

#include "near.h"
#include "random_numbers.h"

#include "physics/scene/scene_law.h"

enum { LAW_UNITS = 5 };

/* Strains of a size of 0.3 and 10/m make a difference. */
static inline scene_law random_law(scene_symmetry symmetry, bool convex, uint64_t seed)
{
    scene_law law = {.symmetry = symmetry, .units = LAW_UNITS};
    const bool round = symmetry == SCENE_SYMMETRY_ROUND;
    ad_error error = {.message = ""};
    for (int i = 0; i < SCENE_LAW_STRAINS; i++) {
        law.scale[i] = i < 3 ? 0.3 : 10;
        law.quadratic[i] = round ? 2 : 2 + random_in(&seed, 0, 1);
        law.low[i] = -law.scale[i];
        law.high[i] = law.scale[i];
    }
    for (int u = 0; u < LAW_UNITS; u++) {
        law.weight[u] = convex ? random_in(&seed, 0, 2) : random_in(&seed, -0.4, 0.4);
        law.offset[u] = random_in(&seed, -1, 1);
        for (int k = 0; k < scene_law_features(symmetry); k++) {
            const bool grows = round && convex && k > 0;
            law.by[u][k] = random_in(&seed, grows ? 0 : -1, 1);
        }
        if (round && convex) {
            law.by[u][SCENE_LAW_FEATURES - 1] = 0;
        }
    }
    if (scene_law_finish(&law, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return law;
}

#endif
