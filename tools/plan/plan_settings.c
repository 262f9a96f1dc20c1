#include "tools/plan/plan_settings.h"

#include <math.h>

plan_settings plan_settings_default(void)
{
    return (plan_settings){.environment = ENVIRONMENT_DEFAULT,
                           .radius = NAN,
                           .clearance = 0,
                           .slide = {NAN, NAN},
                           .turn = {NAN, NAN},
                           .goal_position = {NAN, NAN, NAN},
                           .goal_tolerance = NAN,
                           .states = 200000,
                           .seed = 1};
}
