/* The coordinates of a scene, and a scene at work at a place of a tape. */
#include "physics/rod_internal.h"

domain rod_domain_of(const scene *rod_scene)
{
    rod_scales scales = rod_scales_of(rod_scene);
    domain d = {.count = 1, .time = -1, .windows = 1};
    d.coordinates[0] = (domain_coordinate){"s", "m", 0, 1, scales.length};
    if (scene_is_dynamic(rod_scene)) {
        double duration = scene_duration(rod_scene) / scales.time;
        d.coordinates[1] = (domain_coordinate){"t", "s", 0, duration, scales.time};
        d.count = 2;
        d.time = 1;
        d.windows = rod_scene->windows;
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

rod_context rod_context_of(const scene *rod_scene, const domain_place *at)
{
    bool dynamic = scene_is_dynamic(rod_scene);
    return (rod_context){.scene = rod_scene,
                         .tape = at->tape,
                         .dynamic = dynamic,
                         .scales = rod_scales_of(rod_scene),
                         .properties = scene_properties_of(rod_scene),
                         .plane = rod_plane_of(rod_scene),
                         .domain = rod_domain_of(rod_scene),
                         .at = *at,
                         .s = at->x[0],
                         .t = dynamic ? at->x[1] : ad_scalar(at->tape, 0)};
}
