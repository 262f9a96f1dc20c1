#include "physics/local/rod_model.h"
#include "physics/solve/solve.h"

ad_status solve_start(const scene *rod_scene, solve_place ends[2], ad_error *error)
{
    static const double s[2] = {0, 1};
    solve_initial states[2];
    solve_rod *rod;
    ad_status status = solve_rod_create(rod_scene, &rod, error);
    if (status == AD_OK) {
        status = solve_rod_initial(rod, 2, s, states, error);
    }
    for (int i = 0; status == AD_OK && i < 2; i++) {
        const double *q = states[i].rotation;
        ends[i] = (solve_place){.tangent = {2 * (q[1] * q[3] + q[0] * q[2]),
                                            2 * (q[2] * q[3] - q[0] * q[1]),
                                            q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]}};
        for (int k = 0; k < 3; k++) {
            ends[i].position[k] = states[i].position[k] * rod->scales.length;
        }
    }
    solve_rod_free(rod);
    return status;
}
