#include "tools/judge/judge.h"

#include <string.h>

static const struct {
    const char *name, *text;
} measures[JUDGE_MEASURES] = {{"position", "relative L2 error of position"},
                              {"tip", "tip error / length"},
                              {"rotation", "rotation error, rad"}};

const char *judge_measure_name(judge_measure measure)
{
    return measures[measure].name;
}

const char *judge_measure_text(judge_measure measure)
{
    return measures[measure].text;
}

void judge_measures(const reference_errors *from, double errors[JUDGE_MEASURES])
{
    errors[JUDGE_POSITION] = from->position;
    errors[JUDGE_TIP] = from->tip;
    errors[JUDGE_ROTATION] = from->rotation;
}

void judge_name(char name[JUDGE_NAME], const char *text)
{
    snprintf(name, JUDGE_NAME, "%s", text);
    for (char *byte = name; *byte; byte++) {
        if ((unsigned char)*byte < ' ' || strchr(",\"'/#\x7f", *byte)) {
            *byte = '_';
        }
    }
    for (size_t last = strlen(name); last > 0 && name[last - 1] == ' '; last--) {
        name[last - 1] = '_';
    }
    if (name[0] == '\0') {
        strcpy(name, "_");
    } else if (name[0] == ' ' || name[0] == '.') {
        name[0] = '_';
    }
}

void judge_name_of_file(char name[JUDGE_NAME], const char *path)
{
    const char *slash = strrchr(path, '/');
    judge_name(name, slash ? slash + 1 : path);
    char *dot = strrchr(name, '.');
    if (dot && dot != name) {
        *dot = '\0';
    }
}

/* ---- what a scene is made of ----------------------------------------------------------------- */

const char *judge_solver_form(const scene *rod_scene, solve_method method)
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

void judge_form(const experiment *e, char text[JUDGE_FORM])
{
    static const char *const of_rods[] = {[SCENE_MIXED] = "mixed form",
                                          [SCENE_DISPLACEMENT] = "displacement form",
                                          [SCENE_POSE_STRAIN] = "poses and strains",
                                          [SCENE_STRAIN_FORM] = "strain form"};
    const char *form = e->modes ? "strain modes"
                       : scene_is_beam(e->scene) && e->scene->formulation == SCENE_DISPLACEMENT
                           ? "strong form"
                           : of_rods[e->scene->formulation];
    snprintf(text, JUDGE_FORM, "%s by %s", form, network_functions(&e->settings->network));
}

int judge_unknowns(const experiment *e)
{
    return e->modes ? e->model->outputs : scene_physics_of(e->scene)->network_outputs(e->scene);
}

int judge_equations(const experiment *e)
{
    static const rod_residual_kind inside[] = {ROD_STRAIN, ROD_CURVATURE, ROD_FORCE,  ROD_MOMENT,
                                               ROD_TENDON, ROD_TWIST,     ROD_TORSION};
    int equations = 0;
    for (size_t i = 0; i < sizeof inside / sizeof *inside; i++) {
        equations += scene_physics_of(e->scene)->residual_rows(e->scene, inside[i]);
    }
    return e->modes ? e->model->outputs : equations;
}
