#include "tools/programs/undeformed.h"

#include "physics/solve/solve.h"

#include <math.h>
#include <stdio.h>

/* A coordinate below this part of the length is rounding, and is shown as 0. */
static const double ROUNDING = 1e-9;

/* "+x" where it is along an axis, else "(0.6, 0, 0.8)". */
static void direction_text(const double d[3], char text[64])
{
    double shown[3];
    for (int i = 0; i < 3; i++) {
        if (fabs(d[i]) > 1 - ROUNDING) {
            snprintf(text, 64, "%c%c", d[i] > 0 ? '+' : '-', "xyz"[i]);
            return;
        }
        shown[i] = fabs(d[i]) < ROUNDING ? 0 : d[i];
    }
    snprintf(text, 64, "(%.4g, %.4g, %.4g)", shown[0], shown[1], shown[2]);
}

static void describe(const solve_place ends[2], double length, char text[UNDEFORMED_TEXT])
{
    double chord[3], far = 0, at[2][3];
    char direction[64];
    for (int i = 0; i < 3; i++) {
        chord[i] = (ends[1].position[i] - ends[0].position[i]) / length;
        far += chord[i] * chord[i];
        for (int k = 0; k < 2; k++) {
            double x = ends[k].position[i];
            at[k][i] = fabs(x) < ROUNDING * length ? 0 : x;
        }
    }
    bool straight = fabs(far - 1) < 1e-6;
    direction_text(straight ? chord : ends[0].tangent, direction);
    snprintf(text, UNDEFORMED_TEXT, "from (%.4g, %.4g, %.4g) to (%.4g, %.4g, %.4g) m, %s %s",
             at[0][0], at[0][1], at[0][2], at[1][0], at[1][1], at[1][2],
             straight ? "straight along" : "curved, beginning along", direction);
}

ad_status undeformed_describe(const scene *scene, char text[UNDEFORMED_TEXT], ad_error *error)
{
    solve_place ends[2];
    *text = '\0';
    if (scene_is_beam(scene) || scene_is_manufactured(scene)) {
        return AD_OK;
    }
    ad_status status = solve_start(scene, ends, error);
    if (status == AD_OK) {
        describe(ends, rod_scales_of(scene).length, text);
    }
    return status;
}
