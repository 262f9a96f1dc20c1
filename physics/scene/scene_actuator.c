/* What pulls or pushes along the rod: tendons, then chambers. */
#include "physics/scene/scene.h"

int scene_actuator_count(const scene *rod_scene)
{
    return rod_scene->tendon_count + rod_scene->chamber_count;
}

static scene_actuator tendon_of(const scene_tendon *given)
{
    const bool pulled = given->displacement.is_given;
    return (scene_actuator){.name = "tendon",
                            .unit = pulled ? "m" : "N",
                            .offset = given->offset,
                            .start = &given->start,
                            .end = &given->end,
                            .given = pulled ? given->displacement : given->tension,
                            .tendon = given};
}

static scene_actuator chamber_of(const scene_chamber *given)
{
    return (scene_actuator){.name = "chamber",
                            .unit = "Pa",
                            .offset = given->offset,
                            .start = &given->start,
                            .end = &given->end,
                            .given = given->pressure,
                            .chamber = given};
}

scene_actuator scene_actuator_of(const scene *rod_scene, int index)
{
    const int tendons = rod_scene->tendon_count;
    scene_actuator one = index < tendons ? tendon_of(&rod_scene->tendons[index])
                                         : chamber_of(&rod_scene->chambers[index - tendons]);
    one.from = quantity_number_or(*one.start, 0);
    one.to = quantity_number_or(*one.end, scene_length(rod_scene));
    return one;
}

quantity scene_actuator_pull(const scene_actuator *of)
{
    return of->tendon
               ? of->tendon->tension
               : quantity_scale(quantity_multiply(of->chamber->pressure, of->chamber->area), -1);
}

const char *scene_actuator_lists(const scene *rod_scene)
{
    return rod_scene->chamber_count == 0  ? "tendons"
           : rod_scene->tendon_count == 0 ? "chambers"
                                          : "tendons, chambers";
}
