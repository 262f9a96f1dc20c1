/* The coordinates of a scene, and a scene at work at a place of a tape. */
#include "physics/rod/rod_internal.h"

#include <math.h>
#include <stdio.h>

domain rod_domain_of(const scene *rod_scene)
{
    rod_scales scales = rod_scales_of(rod_scene);
    domain d = {.count = 1, .time = -1, .windows = 1};
    d.coordinates[0] =
        (domain_coordinate){.name = "s", .unit = "m", .low = 0, .high = 1, .scale = scales.length};
    if (scene_is_dynamic(rod_scene)) {
        double duration = scene_duration(rod_scene) / scales.time;
        d.coordinates[1] = (domain_coordinate){
            .name = "t", .unit = "s", .low = 0, .high = duration, .scale = scales.time};
        d.count = 2;
        d.time = 1;
        d.windows = rod_scene->windows;
    }
    for (int i = 0; i < scene_known_count(rod_scene); i++) {
        const scene_parameter *parameter = &rod_scene->parameters[i];
        const double unit = fmax(fabs(parameter->low), fabs(parameter->high));
        domain_coordinate *c = &d.coordinates[d.count++];
        *c = (domain_coordinate){.unit = "",
                                 .low = parameter->low / unit,
                                 .high = parameter->high / unit,
                                 .scale = unit,
                                 .logarithmic = parameter->scale == SCENE_LOG};
        snprintf(c->name, sizeof c->name, "%s", parameter->name);
    }
    return d;
}

domain_place rod_place(const scene *rod_scene, ad_value s, ad_value t)
{
    domain d = rod_domain_of(rod_scene);
    return (domain_place){.tape = s.tape,
                          .x = {s, t},
                          .start = ad_scalar(s.tape, 0),
                          .span = ad_scalar(s.tape, domain_window_time(&d, 1)),
                          .load_factor = ad_scalar(s.tape, 1)};
}

int rod_bind(const scene *rod_scene, const domain *d, const domain_place *at,
             quantity_binding *bindings)
{
    const int count = rod_scene->parameter_count, known = scene_known_count(rod_scene);
    const int first = d->count - known;
    for (int i = 0; i < count; i++) {
        ad_value value = i < known ? ad_scale(at->x[first + i], d->coordinates[first + i].scale)
                         : ad_is_valid(at->unknowns) ? ad_row(at->unknowns, i - known)
                                                     : ad_scalar(at->tape, rod_scene->guess[i]);
        bindings[i] = (quantity_binding){rod_scene->parameters[i].name, value};
    }
    return count;
}

rod_context rod_context_of(const scene *rod_scene, const domain_place *at)
{
    bool dynamic = scene_is_dynamic(rod_scene);
    rod_context rod = {.scene = rod_scene,
                       .tape = at->tape,
                       .dynamic = dynamic,
                       .scales = rod_scales_of(rod_scene),
                       .properties = scene_properties_of(rod_scene),
                       .plane = rod_plane_of(rod_scene),
                       .domain = rod_domain_of(rod_scene),
                       .at = *at,
                       .s = at->x[0],
                       .t = dynamic ? at->x[1] : ad_scalar(at->tape, 0)};
    rod.parameter_count = rod_bind(rod_scene, &rod.domain, at, rod.parameters);
    return rod;
}

rod_context rod_context_open(const scene *open, const scene *one, const domain_place *at, int count,
                             const char *const *names, const ad_value *parameters)
{
    rod_context rod = rod_context_of(one, at);
    rod.scene = open;
    rod.properties = scene_properties_of(open);
    rod.parameter_count = count;
    for (int i = 0; i < count; i++) {
        rod.parameters[i] = (quantity_binding){names[i], parameters[i]};
    }
    return rod;
}
