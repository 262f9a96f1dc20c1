/* What springs in place of locked strains do to a motion. */
#include "physics/local/solve_vector.h"
#include "physics/numerics/quaternion.h"
#include "physics/numerics/vector.h"
#include "physics/solve/dynamic.h"

#include <stdlib.h>
#include <string.h>

enum { COMPARED = MOTION_COMPARED };

/* World: by how much locked strains are off what they are held to, per length of the rod. */
static void stretch_of(const solve_section *made, const solve_rest *rest, const solve_state *seen,
                       double off[2][3])
{
    double R[3][3], in_body[2][3];
    for (int k = 0; k < 3; k++) {
        in_body[0][k] = made->compliance[k] > 0 ? 0 : seen->strain[k] - rest->strain[k];
        in_body[1][k] = made->compliance[3 + k] > 0 ? 0 : seen->curvature[k] - rest->curvature[k];
    }
    rotation_matrix(seen->rotation, R);
    to_world(R, in_body[0], off[0]);
    to_world(R, in_body[1], off[1]);
}

/* At one time: what that adds up to from s = 0 on is taken from the places. Where the end is held,
 * it stays there, and the rod between gives way with it. */
static void take_back(const solve_section *made, const solve_rest *rest, bool is_held,
                      const solve_state *seen, solve_state *to)
{
    const double half = 0.5 / (COMPARED - 1);
    double off[2][2][3] = {{{0}}}, moved[3] = {0}, turned[3] = {0};
    for (int i = 0; i < COMPARED; i++) {
        double way[3] = {0}, carried[3] = {0};
        memcpy(off[1], off[0], sizeof off[0]);
        stretch_of(&made[i], &rest[i], &seen[i], off[0]);
        for (int k = 0; k < 3 && i > 0; k++) {
            turned[k] += half * (off[0][1][k] + off[1][1][k]);
            way[k] = seen[i].position[k] - seen[i - 1].position[k];
        }
        vector_cross(turned, way, carried);
        to[i] = seen[i];
        for (int k = 0; k < 3 && i > 0; k++) {
            moved[k] += half * (off[0][0][k] + off[1][0][k]) + carried[k];
            to[i].position[k] -= moved[k];
        }
    }
    for (int i = 1; i < COMPARED && is_held; i++) {
        for (int k = 0; k < 3; k++) {
            to[i].position[k] += moved[k] * i / (COMPARED - 1);
        }
    }
}

ad_status motion_locks_give(const solve_rod *rod, size_t count, const double *times,
                            const solve_state *seen, motion_apart *give, ad_error *error)
{
    double s[COMPARED];
    solve_section made[COMPARED];
    solve_rest rest[COMPARED];
    *give = (motion_apart){0, 0};
    if (!scene_locks_somewhere(&rod->scene)) {
        return AD_OK;
    }
    for (int i = 0; i < COMPARED; i++) {
        s[i] = (double)i / (COMPARED - 1);
    }
    solve_state *held = malloc(count * COMPARED * sizeof *held);
    ad_status status = held ? solve_rod_sections(rod, COMPARED, s, made, error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", count);
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        status = solve_rod_rest(rod, COMPARED, s, times[i], rest, error);
        take_back(made, rest, rod->ends[1].hold.directions == 3, seen + i * COMPARED,
                  held + i * COMPARED);
    }
    if (status == AD_OK) {
        *give = motion_compare(count, seen, held);
    }
    free(held);
    return status;
}
