#include "tools/programs/solve_family.h"

#include "tools/files/shapes_vtk.h"
#include "tools/prepare/prepare.h"
#include "tools/programs/conclude.h"
#include "tools/programs/eval_family.h"

typedef struct solving {
    config *read;
    samples shapes;
    eval_family family;
} solving;

static ad_status solve(const solve_family_options *asked, solving *x, ad_error *error)
{
    /* To the solver a member beyond its range is as good as any; it is said to be so. */
    const eval_family_options members = {.members = asked->members,
                                         .out = asked->out,
                                         .polish = -1,
                                         .seed = -1,
                                         .threads = asked->threads,
                                         .extrapolate = true,
                                         .derivatives = asked->derivatives};
    const char *conflict = eval_family_conflict(&members);
    if (conflict) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%s", conflict);
    }
    ad_status status = prepare_read(asked->config, NULL, asked->overrides->count,
                                    asked->overrides->texts, &x->read, error);
    if (status == AD_OK && !scene_is_family(&x->read->scene)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "--members: the scene is no family: no parameter of it has a range");
    }
    if (status == AD_OK) {
        const char *usual = scene_is_dynamic(&x->read->scene) ? "21x21" : "21";
        status = samples_choose(&x->shapes, &asked->where, usual, &x->read->scene,
                                scene_duration(&x->read->scene), error);
    }
    return status == AD_OK ? eval_family_solve(&members, &x->read->scene, asked->tolerance,
                                               &x->shapes, &x->family, error)
                           : status;
}

static void tell(const void *of, json *to)
{
    const solving *x = of;
    if (x->family.family) {
        eval_family_json(to, &x->family);
    }
}

static void judge(const solving *x, verdict *to)
{
    if (eval_family_status(&x->family) != 0) {
        verdict_add(to, VERDICT_ESTIMATE_ABOVE_TOLERANCE, "of some members, or there is none");
    }
}

int solve_family_run(const char *program, const solve_family_options *asked)
{
    solving x = {.read = NULL};
    verdict verdict = {.count = 0};
    ad_error error = {.message = ""};
    ad_status status = asked->out ? shapes_check_path(asked->out, &error) : AD_OK;
    status = status == AD_OK ? json_check_path(asked->json, &error) : status;
    status = status == AD_OK ? solve(asked, &x, &error) : status;
    if (status == AD_OK) {
        judge(&x, &verdict);
        eval_family_warn(program, &x.family);
        if (!asked->quiet) {
            eval_family_print(&x.family);
            verdict_print(stdout, "", &verdict);
        }
    }
    const conclusion end = {.program = program,
                            .quiet = asked->quiet,
                            .json = asked->json,
                            .name = x.read ? x.read->settings.name : NULL,
                            .tell = tell,
                            .of = &x,
                            .verdict = &verdict};
    const int exit_status = conclude(&end, status, &error);
    eval_family_free(&x.family);
    samples_free(&x.shapes);
    config_free(x.read);
    return exit_status;
}
