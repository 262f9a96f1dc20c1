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

/* Where the rod comes out of its port changes with the parameter. */
static bool inserts(const scene *family, int index)
{
    double values[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < family->parameter_count; i++) {
        values[i] = scene_parameter_at(&family->parameters[i], 0.5);
    }
    values[index] = family->parameters[index].low;
    const double port = scene_place_at(family, values, 0, 0);
    values[index] = family->parameters[index].high;
    return scene_place_at(family, values, 0, 0) != port ||
           quantity_depends_on(family->rod.inserted, family->parameters[index].name);
}

static bool moves_end(const scene_end *end, const char *name)
{
    return quantity_any_depends_on(3, end->position, name) ||
           quantity_any_depends_on(4, end->rotation, name) ||
           quantity_any_depends_on(3, end->rotation_vector, name) ||
           quantity_depends_on(end->twist, name);
}

bool scene_parameter_actuates(const scene *family, int index)
{
    const char *name = family->parameters[index].name;
    bool any = inserts(family, index) || moves_end(&family->start, name) ||
               moves_end(&family->end, name) ||
               quantity_any_depends_on(3, family->loads.magnetic_field, name) ||
               quantity_any_depends_on(5, family->loads.magnetic_gradient, name);
    for (int i = 0; i < scene_actuator_count(family) && !any; i++) {
        any = quantity_depends_on(scene_actuator_of(family, i).given, name);
    }
    for (int i = 0; i < family->tube_count && !any; i++) {
        any = quantity_depends_on(family->tubes[i].turned, name);
    }
    return any;
}

const char *scene_actuator_lists(const scene *rod_scene)
{
    return rod_scene->chamber_count == 0  ? "tendons"
           : rod_scene->tendon_count == 0 ? "chambers"
                                          : "tendons, chambers";
}
