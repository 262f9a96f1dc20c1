#include "tools/train/reference_solve.h"

#include "physics/numerics/clock.h"
#include "physics/solve/solve.h"
#include "tools/files/checkpoint.h"
#include "tools/files/file_bytes.h"
#include "tools/train/report.h"
#include "tools/train/run.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double worthless = 1e-3; /* estimate above which there is no reference */

/* What is wanted, and where it is kept. */
typedef struct request {
    const experiment *e;
    const scene *scene;   /* the experiment's, or a member of it, */
    const double *member; /* the one with these values */
    size_t points;
    const double *s, *t; /* [points] */
    int columns;
    double *poses;     /* [columns][points] */
    char *text;        /* all that it depends on */
    char folder[3800]; /* "": there is no cache */
    char path[4096];
} request;

/* ---- names --------------------------------------------------------------------------------- */

static char *text_of(const request *r)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return NULL;
    }
    fprintf(file, "# cpinn %s, solution %d, %d columns at %zu points\n", CPINN_VERSION,
            SOLUTION_VERSION, r->columns, r->points);
    for (int i = 0; i < r->e->scene->parameter_count; i++) {
        fprintf(file, "# %s = %.17g\n", r->e->scene->parameters[i].name, r->member[i]);
    }
    ad_status status = r->e->origin.write_physics(r->e->origin.context, file);
    if (fclose(file) != 0 || status != AD_OK) {
        free(text);
        return NULL;
    }
    return text;
}

static void name_files(request *r)
{
    uint64_t hash = checkpoint_hash(CHECKPOINT_HASH_START, r->text, strlen(r->text));
    if (run_cache_folder(r->folder, sizeof r->folder, false)) {
        snprintf(r->path, sizeof r->path, "%s/%016" PRIx64 ".h5", r->folder, hash);
    } else {
        r->folder[0] = '\0';
    }
}

/* ---- the cache ----------------------------------------------------------------------------- */

static void say_solved(const request *r, const char *source, reference_solution *about)
{
    double asked = r->e->settings->reference_tolerance;
    char missed[64] = "";
    bool unstable = verdict_has(&about->verdict, VERDICT_UNSTABLE);
    bool several = unstable || verdict_has(&about->verdict, VERDICT_SEVERAL_EQUILIBRIA);
    bool lost = verdict_has(&about->verdict, VERDICT_ENERGY_OUT_OF_BALANCE);
    if (verdict_has(&about->verdict, VERDICT_ESTIMATE_ABOVE_TOLERANCE)) {
        snprintf(missed, sizeof missed, ", not the %.1g asked for", asked);
    }
    snprintf(about->account, sizeof about->account,
             "solved classically, estimated error %.1e of the %s%s%s%s%s, %s", about->estimate,
             scene_is_beam(r->scene) ? "deflection" : "length", missed,
             several ? ", of several equilibria the one that continues the unstressed rod" : "",
             unstable ? ", which is unstable" : "", lost ? ", its energy out of balance" : "",
             source);
}

static ad_status read_kept(const request *r, const checkpoint *file, reference_solution *about,
                           ad_error *error)
{
    const char *text = NULL;
    size_t count = (size_t)r->columns * r->points;
    ad_status status = checkpoint_get_text(file, "scene", &text, error);
    if (status == AD_OK && strcmp(text, r->text) != 0) {
        status = ad_fail(error, AD_BAD_INPUT, "the text of another scene");
    }
    if (status == AD_OK) {
        status = checkpoint_get_doubles(file, "estimate", &about->estimate, 1, error);
    }
    if (status == AD_OK) {
        status = checkpoint_get_doubles(file, "size", &about->size, 1, error);
    }
    if (status == AD_OK) {
        status = report_get_verdict(file, &about->verdict, error);
    }
    return status == AD_OK ? checkpoint_get_doubles(file, "poses", r->poses, count, error) : status;
}

/* Whether it is there; if it is and cannot be used, the remark says why. */
static bool take_kept(const request *r, reference_solution *about)
{
    checkpoint *file = NULL;
    ad_error why;
    char source[256];
    if (!*r->folder || access(r->path, F_OK) != 0) {
        return false;
    }
    ad_status status = checkpoint_open(r->path, &file, &why);
    if (status == AD_OK) {
        status = read_kept(r, file, about, &why);
    }
    checkpoint_free(file);
    if (status == AD_OK) {
        snprintf(source, sizeof source, "from %s", file_bytes_shown(r->path));
        say_solved(r, source, about);
        return true;
    }
    snprintf(about->remark, sizeof about->remark,
             status == AD_BAD_INPUT ? "%s: is damaged or of another scene; solved anew"
                                    : "%s; solved anew",
             status == AD_BAD_INPUT ? file_bytes_shown(r->path) : why.message);
    return false;
}

/* Replaces what could not be used. */
static void keep(const request *r, reference_solution *about)
{
    const size_t shape[2] = {(size_t)r->columns, r->points};
    checkpoint *file = *r->folder ? checkpoint_create(CPINN_VERSION) : NULL;
    ad_error why;
    if (!file) {
        return;
    }
    report_put_verdict(file, &about->verdict);
    checkpoint_put_text(file, "scene", r->text);
    checkpoint_put_doubles(file, "poses", r->poses, 2, shape);
    checkpoint_put_double(file, "estimate", about->estimate);
    checkpoint_put_double(file, "size", about->size);
    run_make_folder(r->folder, NULL); /* or writing says so */
    if (checkpoint_write(file, &(file_place){.path = r->path}, &why) != AD_OK) {
        snprintf(about->remark, sizeof about->remark, "%s; not kept for the next run", why.message);
    }
    checkpoint_free(file);
}

/* ---- solving ------------------------------------------------------------------------------- */

/* What the solver has to say against the result; AD_OK when it can be used. */
static ad_status judge(const request *r, const solve_report *report, ad_error *error)
{
    char problem[300];
    if (!scene_is_dynamic(r->scene) && report->load_fraction != 1) {
        snprintf(problem, sizeof problem,
                 "solving stops at %.6g of the load, beyond which the equilibria that continue the "
                 "unstressed rod end or turn back; give reference.file, or leave it out",
                 report->load_fraction);
    } else if (!(report->estimate <= worthless)) {
        snprintf(problem, sizeof problem,
                 "the solution is estimated to be off by %.2g of the %s; give reference.file, "
                 "or leave it out",
                 report->estimate, scene_is_beam(r->scene) ? "deflection" : "length");
    } else {
        return AD_OK;
    }
    return experiment_refuse(r->e, "reference.solve", problem, error);
}

static ad_status solve(const request *r, reference_solution *about, ad_error *error)
{
    solve_report report;
    const scene *rod_scene = r->scene;
    bool dynamic = scene_is_dynamic(rod_scene);
    solve_settings asked = solve_settings_default(rod_scene);
    asked.tolerance = r->e->settings->reference_tolerance;
    if (!scene_has_rubbing_tendons(rod_scene)) {
        asked.method = SOLVE_COLLOCATION; /* networks of strain modes are judged by another form */
    }
    solution *solved = NULL;
    ad_error why;
    ad_status status = solution_create(rod_scene, &asked, dynamic ? r->points : 0,
                                       dynamic ? r->t : NULL, &solved, &report, &why);
    if (status == AD_OK) {
        status = judge(r, &report, &why);
    } else if (status != AD_NO_MEMORY) {
        char problem[sizeof why.message];
        snprintf(problem, sizeof problem, "%s", why.message);
        status = experiment_refuse(r->e, "reference.solve", problem, &why);
    }
    if (status == AD_OK) {
        status = solution_evaluate(solved, r->columns, r->points, r->s, dynamic ? r->t : NULL,
                                   r->poses, &why);
    }
    if (status == AD_OK) {
        about->estimate = report.estimate;
        about->size = report.size;
        about->verdict = (verdict){.count = 0};
        solution_verdict(solved, rod_scene, &asked, &report, &about->verdict);
    }
    solution_free(solved);
    return status == AD_OK ? AD_OK : ad_fail(error, status, "%s", why.message);
}

ad_status reference_solve(const experiment *e, const double *member, size_t points, const double *s,
                          const double *t, int columns, double *poses, reference_solution *about,
                          ad_error *error)
{
    scene one;
    scene_member(e->scene, member, &one);
    request r = {e, &one, member, points, s, t, columns, poses, .folder = ""};
    ad_status status = AD_OK;
    about->remark[0] = about->path[0] = '\0';
    if (e->origin.write_physics) {
        r.text = text_of(&r);
        if (!r.text) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for a reference");
        }
        name_files(&r);
    }
    if (!take_kept(&r, about)) {
        char source[32];
        double start = clock_seconds(CLOCK_MONOTONIC);
        status = solve(&r, about, error);
        if (status == AD_OK) {
            snprintf(source, sizeof source, "%.3g s", clock_seconds(CLOCK_MONOTONIC) - start);
            say_solved(&r, source, about);
            keep(&r, about);
        }
    }
    if (*r.folder) {
        snprintf(about->path, sizeof about->path, "%s", r.path);
    }
    free(r.text);
    return status;
}
