#include "tools/programs/form.h"

const char *form_of_solver(const scene *rod_scene, solve_method method)
{
    return method == SOLVE_MODES                                      ? "strain modes"
           : scene_is_dynamic(rod_scene) && !scene_is_beam(rod_scene) ? "spectral elements"
                                                                      : "collocation";
}

static const char *network_functions(const nn_mlp_settings *network)
{
    return network->hidden_count > 0 ? "a network"
           : network->degree > 0     ? "polynomials"
                                     : "random waves";
}

void form_of_network(const experiment *e, char text[FORM_TEXT])
{
    static const char *const of_rods[] = {[SCENE_MIXED] = "mixed form",
                                          [SCENE_DISPLACEMENT] = "displacement form",
                                          [SCENE_POSE_STRAIN] = "poses and strains",
                                          [SCENE_STRAIN_FORM] = "strain form"};
    const char *form = e->modes ? "strain modes"
                       : scene_is_beam(e->scene) && e->scene->formulation == SCENE_DISPLACEMENT
                           ? "strong form"
                           : of_rods[e->scene->formulation];
    snprintf(text, FORM_TEXT, "%s by %s", form, network_functions(&e->settings->network));
}

int form_unknowns(const experiment *e)
{
    return e->modes ? e->model->outputs : scene_physics_of(e->scene)->network_outputs(e->scene);
}

int form_equations(const experiment *e)
{
    static const rod_residual_kind inside[] = {ROD_STRAIN, ROD_CURVATURE, ROD_FORCE,  ROD_MOMENT,
                                               ROD_TENDON, ROD_TWIST,     ROD_TORSION};
    int equations = 0;
    for (size_t i = 0; i < sizeof inside / sizeof *inside; i++) {
        equations += scene_physics_of(e->scene)->residual_rows(e->scene, inside[i]);
    }
    return e->modes ? e->model->outputs : equations;
}
