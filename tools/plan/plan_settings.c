#include "tools/plan/plan_settings.h"

#include <math.h>

plan_settings plan_settings_default(void)
{
    const plan_goal goal = {
        .position = {NAN, NAN, NAN}, .tolerance = NAN, .direction = {NAN, NAN, NAN}, .angle = 0.1};
    plan_settings result = {.environment = ENVIRONMENT_DEFAULT,
                            .radius = NAN,
                            .clearance = 0,
                            .slide = {NAN, NAN},
                            .turn = {NAN, NAN},
                            .goal = goal,
                            .roadmap_nodes = 2000,
                            .states = 200000,
                            .seed = 1};
    for (int k = 0; k < PLAN_GOALS_MAX; k++) {
        result.goals[k] = goal;
    }
    return result;
}
