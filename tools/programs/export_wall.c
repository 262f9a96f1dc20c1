#include "tools/programs/export_wall.h"

#include "tools/config/config.h"

#include <math.h>
#include <string.h>

/* Whether the shape says where the rod is, and how long. */
static ad_status check_shape(const export_family *f, double from, ad_error *error)
{
    enum { V = 7 };
    const bool stretches = f->open->rod.model != SCENE_KIRCHHOFF;
    int places = 0, strains = 0;
    for (int i = 0; i < f->columns; i++) {
        places += f->which[i] < 3;
        strains += f->which[i] >= V && f->which[i] < V + 3;
    }
    if (f->open->rod.inserted.is_given || f->open->rod.growth.is_given) {
        return ad_fail(error, AD_BAD_ARGUMENT, "--wall is for rods of which no part comes out");
    }
    if (places < 3 || (stretches && strains < 3)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "--wall needs --columns '%s' among others",
                       stretches ? "r v1 v2 v3" : "r");
    }
    if (f->s[0] * scene_length(f->open) > from) {
        return ad_fail(
            error, AD_BAD_ARGUMENT,
            "--places: begin at %g, after the place from which on --wall looks; allowed: "
            "up to %g",
            f->s[0] * scene_length(f->open), from);
    }
    return AD_OK;
}

static ad_status open_wall(const config *scene, export_model *model, export_walled *to,
                           ad_error *error)
{
    const plan_settings *const plan = &scene->plan;
    if (!plan->environment.file) {
        return config_refuse(scene, "plan.environment.file",
                             "is not given, and --wall exports it; allowed: .stl, .obj", error);
    }
    if (isnan(plan->radius)) {
        return config_refuse(scene, "plan.radius", "is not given; allowed: a number >= 0 (m)",
                             error);
    }
    ad_status status = check_shape(&model->family, plan->from, error);
    if (status == AD_OK) {
        status = surface_tree_open(&plan->environment, scene_length(model->family.open), &to->tree,
                                   error);
    }
    if (status == AD_OK) {
        to->wall = (export_wall){to->tree, plan->radius, plan->from};
        model->family.wall = &to->wall;
    }
    return status;
}

ad_status export_wall_open(const char *scene_path, export_model *model, export_walled *result,
                           ad_error *error)
{
    config *scene = NULL;
    *result = (export_walled){.tree = NULL};
    if (!export_is_family(model)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "--wall is for families in the strain form alone");
    }
    ad_status status = config_read(scene_path, NULL, 0, NULL, &scene, error);
    status = status == AD_OK ? open_wall(scene, model, result, error) : status;
    config_free(scene);
    return status;
}

void export_wall_close(export_walled *of)
{
    surface_tree_free(of->tree);
}
