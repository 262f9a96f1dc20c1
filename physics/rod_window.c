/* Windows of time: when they begin, and the state in which the one before leaves the rod. */
#include "nn/nn.h"
#include "physics/chebyshev.h"
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
    while (index > 0 && t <= rod_window_time(rod_scene, index))
        index--;
    while (index < last && t > rod_window_time(rod_scene, index + 1))
        index++;
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
    if (!scene_is_dynamic(rod_scene))
        return space;
    ad_value elapsed = ad_sub(t, ad_scalar(s.tape, start));
    return ad_stack(2, (ad_value[]){space, ad_sub(ad_scale(elapsed, 2 / span), one)});
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

/* The fields of one moment as functions of s: t is replaced by a number after the derivatives by it
 * have been taken. */
static rod_initial_data rod_at_time(const rod_context *rod, rod_pose pose, double time)
{
    ad_value turning = rod_time_derivative(rod, pose.rotation, 1);
    ad_value parts[4] = {pose.position, pose.rotation, rod_time_derivative(rod, pose.position, 1),
                         rod_rate(pose.rotation, turning)};
    ad_value state = ad_substitute(ad_stack(4, parts), rod->t, ad_scalar(rod->tape, time));
    return (rod_initial_data){.position = ad_slice(state, 0, 3),
                              .rotation = ad_slice(state, 3, 4),
                              .velocity = ad_slice(state, 7, 3),
                              .spin = ad_slice(state, 10, 3)};
}

/* Rows that are 0 at every point are the constant 0, as across the plane of a planar motion. */
rod_initial_data rod_window_start(const rod_context *rod, int degree)
{
    ad_value rows[ROD_WINDOW_ROWS];
    chebyshev_fields(rod->s, rod->origin, ROD_WINDOW_ROWS, degree, rows);
    return (rod_initial_data){.position = ad_stack(3, rows),
                              .rotation = ad_stack(4, rows + 3),
                              .velocity = ad_stack(3, rows + 7),
                              .spin = ad_stack(3, rows + 10)};
}

/* A held end is where it is said to be, also when the window begins. */
rod_initial_data rod_held_at_start(const rod_context *rod, rod_pose held)
{
    return rod_at_time(rod, held, rod->start);
}

ad_status rod_window_end(const scene *rod_scene, const rod_window *window, const nn_mlp *mlp,
                         const double *x, ad_pool *pool, double *end, ad_error *error)
{
    ad_tape *tape = ad_tape_create();
    if (!tape)
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1), rows[ROD_WINDOW_ROWS];
    rod_context rod = rod_in_window(rod_scene, window, s, t);
    ad_value outputs = nn_mlp_record(mlp, rod_network_input(rod_scene, window, s, t), 0);
    rod_pose pose = rod_ansatz_pose(&rod, rod_plane_outputs(&rod, outputs));
    rod_initial_data state = rod_at_time(&rod, pose, rod.start + rod.span);
    const ad_value fields[4] = {state.position, state.rotation, state.velocity, state.spin};
    ad_value stacked = ad_stack(4, fields);
    for (int i = 0; i < ROD_WINDOW_ROWS; i++)
        rows[i] = ad_row(stacked, i);
    ad_status status = chebyshev_sample(ROD_WINDOW_ROWS, rows, x, pool, end, error);
    ad_tape_free(tape);
    return status;
}
