/* A scene at work on a tape: its windows of time, and what the network sees of it. */
#include "physics/rod_internal.h"

#include <math.h>

double rod_window_time(const scene *rod_scene, int index)
{
    double duration =
        scene_is_dynamic(rod_scene) ? rod_scene->duration / rod_scales_of(rod_scene).time : 0;
    int windows = rod_scene->windows;
    return index == windows ? duration : duration * index / windows;
}

int rod_window_at(const scene *rod_scene, double t)
{
    int last = rod_scene->windows - 1;
    double passed = ceil(t / rod_window_time(rod_scene, last + 1) * rod_scene->windows) - 1;
    int index = passed >= last ? last : passed > 0 ? (int)passed : 0;
    while (index > 0 && t <= rod_window_time(rod_scene, index)) {
        index--;
    }
    while (index < last && t > rod_window_time(rod_scene, index + 1)) {
        index++;
    }
    return index;
}

int rod_network_inputs(const scene *rod_scene)
{
    return scene_is_dynamic(rod_scene) ? 2 : 1;
}

ad_value rod_network_input(const scene *rod_scene, const rod_window *window, ad_value s, ad_value t)
{
    int index = window ? window->index : 0;
    double start = rod_window_time(rod_scene, index);
    double span = rod_window_time(rod_scene, index + 1) - start;
    ad_value one = ad_scalar(s.tape, 1), space = ad_sub(ad_scale(s, 2), one);
    if (!scene_is_dynamic(rod_scene)) {
        return space;
    }
    ad_value elapsed = ad_sub(t, ad_scalar(s.tape, start));
    return ad_stack(2, (ad_value[]){space, ad_sub(ad_scale(elapsed, 2 / span), one)});
}

rod_context rod_context_of(const scene *rod_scene, ad_value s, ad_value t)
{
    rod_context rod = {.scene = rod_scene,
                       .tape = s.tape,
                       .dynamic = scene_is_dynamic(rod_scene),
                       .scales = rod_scales_of(rod_scene),
                       .properties = scene_properties_of(rod_scene),
                       .plane = rod_plane_of(rod_scene),
                       .s = s,
                       .t = t};
    rod.span = rod_window_time(rod_scene, 1) - rod.start;
    return rod;
}

rod_context rod_in_window(const scene *rod_scene, const rod_window *window, ad_value s, ad_value t)
{
    int index = window ? window->index : 0;
    rod_context rod = rod_context_of(rod_scene, s, t);
    rod.origin = index > 0 ? window->start : NULL;
    rod.start = rod_window_time(rod_scene, index);
    rod.span = rod_window_time(rod_scene, index + 1) - rod.start;
    return rod;
}

ad_value rod_elapsed(const rod_context *rod)
{
    return ad_sub(rod->t, ad_scalar(rod->tape, rod->start));
}
