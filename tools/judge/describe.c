/* What a scene is made of, in a few words and numbers. */
#include "tools/judge/judge.h"

#include <string.h>

/* A word for the terms whose names begin so; told when all of these that there are, are absent. */
static const struct {
    const char *word, *terms[3];
} parts[] = {{"shear", {"shear"}},
             {"stretch", {"stretch"}},
             {"twist", {"twist"}},
             {"rotary inertia", {"rotary inertia"}},
             {"damping", {"strain damping", "curvature damping", "drag"}}};

/* What a solver takes that nobody chose a method for. */
static const char *solver_form(const scene *rod_scene)
{
    return scene_is_dynamic(rod_scene) && !scene_is_beam(rod_scene) ? "spectral elements"
                                                                    : "collocation";
}

static const char *network_functions(const nn_mlp_settings *network)
{
    return network->hidden_count > 0 ? "a network"
           : network->degree > 0     ? "polynomials"
                                     : "random waves";
}

void judge_form(const experiment *e, judge_method method, char text[JUDGE_FORM])
{
    static const char *const of_rods[] = {[SCENE_MIXED] = "mixed form",
                                          [SCENE_DISPLACEMENT] = "displacement form",
                                          [SCENE_POSE_STRAIN] = "poses and strains",
                                          [SCENE_STRAIN_FORM] = "strain form"};
    const char *form = e->modes ? "strain modes"
                       : scene_is_beam(e->scene) && e->scene->formulation == SCENE_DISPLACEMENT
                           ? "strong form"
                           : of_rods[e->scene->formulation];
    if (method == JUDGE_SOLVER) {
        snprintf(text, JUDGE_FORM, "%s", solver_form(e->scene));
    } else {
        snprintf(text, JUDGE_FORM, "%s by %s", form, network_functions(&e->settings->network));
    }
}

const char *judge_form_of(const judge_row *row, judge_method method)
{
    return *row->form ? row->form : judge_method_name(method);
}

static void add_word(char text[64], const char *word)
{
    size_t length = strlen(text);
    snprintf(text + length, 64 - length, "%s%s", length ? "; " : "", word);
}

/* Reasons that have been told otherwise: with the third dimension, with time. */
static bool is_told(const char *reason)
{
    return strcmp(reason, "planar motion") == 0 || strcmp(reason, "static scene") == 0;
}

/* Whether terms of a part are there, but none of them is present. */
static bool is_absent(const rod_term *terms, int count, int part)
{
    bool absent = false;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3 && parts[part].terms[k]; k++) {
            if (strncmp(terms[i].name, parts[part].terms[k], strlen(parts[part].terms[k])) != 0) {
                continue;
            }
            if (terms[i].present) {
                return false;
            }
            absent = absent || !is_told(terms[i].reason);
        }
    }
    return absent;
}

void judge_left_out(const scene *rod_scene, judge_method method, char text[64])
{
    rod_term terms[ROD_TERM_MAX];
    int count = scene_physics_of(rod_scene)->terms(rod_scene, terms);
    if (!scene_is_dynamic(rod_scene)) {
        add_word(text, "time");
    }
    if (method == JUDGE_SOLVER) {
        return; /* takes all rods alike */
    }
    if (!scene_is_beam(rod_scene) && rod_plane_of(rod_scene).is_planar) {
        add_word(text, "out of plane");
    }
    for (int i = 0; i < (int)(sizeof parts / sizeof *parts); i++) {
        if (is_absent(terms, count, i)) {
            add_word(text, parts[i].word);
        }
    }
}

void judge_describe(const session *s, judge_row *row)
{
    const scene *scene = s->e->scene;
    static const rod_residual_kind inside[] = {ROD_STRAIN, ROD_CURVATURE, ROD_FORCE,  ROD_MOMENT,
                                               ROD_TENDON, ROD_TWIST,     ROD_TORSION};
    judge_form(s->e, JUDGE_NETWORK, row->form);
    row->unknowns = scene_physics_of(scene)->network_outputs(scene);
    row->equations = row->instructions = 0;
    for (size_t i = 0; i < sizeof inside / sizeof *inside; i++) {
        row->equations += scene_physics_of(scene)->residual_rows(scene, inside[i]);
    }
    if (s->e->modes) {
        row->unknowns = row->equations = s->e->model->outputs;
    }
    for (int i = 0; i < problem_sets(s->problem); i++) {
        row->instructions += (double)problem_set_inspect(s->problem, i).program.instructions;
    }
    row->points = (double)problem_set_inspect(s->problem, 0).points;
    judge_left_out(scene, JUDGE_NETWORK, row->left_out);
}
