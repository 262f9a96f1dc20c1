#include "physics/chain/solve_members.h"

#include "autodiff/memory.h"
#include "physics/chain/strain_group.h"
#include "physics/chain/strain_jacobian.h"
#include "physics/chain/strain_margin.h"
#include "physics/learn/model.h"
#include "physics/rod/strain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Derivatives of a group, and how the last went. */
typedef struct slope {
    strain_jacobian *jacobian;
    ad_status status;
    ad_error error;
} slope;

struct solve_members {
    scene open;
    int threads, count;
    size_t points;
    solve_parameters parameters;
    const char **names;
    double *values;
    double *s; /* [points], over the length */
    ad_pool *pool;
    strain_group **groups; /* [threads] */
    slope *slopes;         /* [threads]; NULL: not asked for yet */
    ad_memory memory;
};

/* ---- what is known of a scene -------------------------------------------------------------- */

/* Writes the middle member to `one`. */
static ad_status check(const scene *open, scene *one, ad_error *error)
{
    const char *key = "";
    ad_error reason;
    scene family = *open; /* one rod for all values, also of what is to be found */
    family.unknown_count = 0;
    ad_status status = scene_check(&family, &key, &reason);
    if (status == AD_OK) {
        scene_middle(open, one);
        status = scene_physics_of(one)->check(one, &key, &reason);
    }
    if (status != AD_OK) {
        return ad_fail(error, status, "%s: %s", key, reason.message);
    }
    return strain_check(one, false, error);
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_status keep(solve_members *members, int threads, ad_error *error)
{
    ad_status status = ad_pool_open(threads, &members->pool, error);
    if (status != AD_OK) {
        return status;
    }
    members->threads = ad_pool_threads(members->pool);
    const size_t count = (size_t)members->count;
    const scene_parameter *parameters = members->open.parameters;
    size_t bytes = 1;
    for (size_t i = 0; i < count; i++) {
        bytes += strlen(parameters[i].name) + 1;
    }
    members->names = malloc((count + 1) * sizeof *members->names + bytes);
    AD_TAKE(members, values, count + 1);
    AD_TAKE(members, groups, (size_t)members->threads);
    if (!members->names || members->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    }
    char *text = (char *)(members->names + count + 1);
    for (size_t i = 0; i < count; i++) {
        members->names[i] = strcpy(text, parameters[i].name);
        text += strlen(text) + 1;
        members->values[i] = scene_parameter_at(&parameters[i], 0.5);
    }
    members->parameters = (solve_parameters){members->count, members->names, members->values};
    return AD_OK;
}

static ad_status create_groups(solve_members *members, const scene *one,
                               const solve_members_settings *settings, ad_error *error)
{
    strain_mesh pieces;
    ad_status status = strain_mesh_of(&members->open, STRAIN_STAGES_MIN, &pieces, error);
    double *s = members->s = malloc((settings->points + 1) * sizeof *s);
    if (status == AD_OK && !s) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", settings->points);
    }
    for (size_t i = 0; status == AD_OK && i < settings->points; i++) {
        s[i] = settings->s[i] / scene_length(one);
        if (!(s[i] >= (i > 0 ? s[i - 1] : 0) && s[i] <= 1 + 1e-12)) {
            status = ad_fail(error, AD_BAD_ARGUMENT,
                             "members: s[%zu] = %g; allowed: ascending "
                             "within the rod",
                             i, settings->s[i]);
        }
    }
    for (int i = 0; i < members->threads && status == AD_OK; i++) {
        solve_rod *rod;
        status = solve_rod_create_open(&members->open, &members->parameters, &rod, error);
        status = status == AD_OK
                     ? strain_group_create(rod, members->count, settings->tolerance,
                                           settings->own_curvature, pieces.elements, pieces.edges,
                                           (int)members->points, s, &members->groups[i], error)
                     : status;
    }
    return status;
}

/* ---- solving ------------------------------------------------------------------------------- */

bool solve_members_is_unloaded(const solve_members *members)
{
    const strain_form *form = members->groups[0]->level[0].form;
    return form->is_unloaded && form->tension_count == 0;
}

size_t solve_members_nodes(const solve_members *members)
{
    const strain_group *one = members->groups[0];
    return (size_t)one->level[one->modes].form->nodes;
}

size_t solve_members_width(const solve_members *members)
{
    return (size_t)strain_group_width(members->groups[0]);
}

size_t solve_members_carried(const solve_members *members)
{
    return SOLVE_MEMBERS_FORCES + 2 * (solve_members_width(members) - 3);
}

double solve_members_torsion(const solve_members *members)
{
    const rod_scales *scales = &members->groups[0]->rod->scales;
    return scales->moment * scales->length;
}

size_t solve_members_numbers(const solve_members *members)
{
    return solve_members_width(members) * solve_members_nodes(members);
}

void solve_members_places(const solve_members *members, double *s)
{
    const strain_group *one = members->groups[0];
    for (size_t i = 0; i < solve_members_nodes(members); i++) {
        s[i] = one->level[one->modes].s[i] * one->rod->scales.length;
    }
}

const char *solve_member_text(solve_member_end end)
{
    static const char *const texts[SOLVE_MEMBER_ENDS] = {
        NULL, "its stable equilibria end on the way to the whole load",
        "Newton's method does not settle on the way to the whole load",
        "its estimated error is above the tolerance on the finest mesh"};
    return texts[end];
}

/* Members in groups of LANES; what is NULL is not asked for. */
typedef struct batch {
    solve_members *x;
    size_t members;
    const double *parameters, *given; /* curvature, to be refined; NULL: members are solved */
    int steps;
    double *values, *curvature;
    solve_member *results;
    solve_answer *answers;
    double *margin, *by; /* of the curvature, in place of all that */
    const double *beside;
    int axis;
} batch;

static double *after(double *of, size_t count)
{
    return of ? of + count : NULL;
}

static ad_status run_group(void *context, int item, int thread, ad_error *error)
{
    const batch *of = context;
    solve_members *solver = of->x;
    strain_group *group = solver->groups[thread];
    const size_t first = LANES * (size_t)item, left = of->members - first;
    const size_t members = left < LANES ? left : LANES, unknowns = solve_members_numbers(solver);
    const double *parameters = of->parameters + first * (size_t)solver->count;
    double *values = after(of->values, first * solver->points * SOLVE_MEMBERS_COLUMNS);
    double *curvature = after(of->curvature, first * unknowns);
    if (of->margin) {
        const size_t by = first * (size_t)solver->count;
        return strain_group_margin(group, members, parameters, of->given + first * unknowns,
                                   of->axis, of->beside + by, of->margin + SOLVE_MARGINS * first,
                                   after(of->by, SOLVE_MARGINS * by), error);
    }
    return of->given ? strain_group_refine(group, members, parameters, of->given + first * unknowns,
                                           of->steps, values, curvature,
                                           of->answers ? of->answers + first : NULL, error)
                     : strain_group_solve(group, members, parameters, values, curvature,
                                          of->results + first, error);
}

static ad_status run(batch *of, ad_error *error)
{
    const solve_members *members = of->x;
    struct {
        void *data;
        size_t bytes; /* of a member */
    } wanted[] = {{of->values, members->points * SOLVE_MEMBERS_COLUMNS * sizeof(double)},
                  {of->curvature, solve_members_numbers(members) * sizeof(double)},
                  {of->results, sizeof *of->results},
                  {of->answers, sizeof *of->answers},
                  {of->margin, SOLVE_MARGINS * sizeof *of->margin},
                  {of->by, SOLVE_MARGINS * (size_t)members->count * sizeof *of->by}};
    ad_dealt made[sizeof wanted / sizeof *wanted];
    int count = 0;
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        if (wanted[i].data) {
            made[count++] =
                (ad_dealt){wanted[i].data, LANES * wanted[i].bytes, of->members * wanted[i].bytes};
        }
    }
    return ad_pool_deal(members->pool, (int)((of->members + LANES - 1) / LANES), run_group, of,
                        count, made, error);
}

ad_status solve_members_curvature(solve_members *solver, size_t members, const double *parameters,
                                  double *values, double *curvature, solve_member *results,
                                  ad_error *error)
{
    batch of = {.x = solver,
                .members = members,
                .parameters = parameters,
                .values = values,
                .curvature = curvature,
                .results = results};
    return run(&of, error);
}

ad_status solve_members_solve(solve_members *solver, size_t members, const double *parameters,
                              double *values, solve_member *results, ad_error *error)
{
    return solve_members_curvature(solver, members, parameters, values, NULL, results, error);
}

ad_status solve_members_refine(solve_members *solver, size_t members, const double *parameters,
                               const double *curvature, int steps, double *values, double *refined,
                               solve_answer *answers, ad_error *error)
{
    batch of = {.x = solver,
                .members = members,
                .parameters = parameters,
                .given = curvature,
                .steps = steps,
                .values = values,
                .curvature = refined,
                .answers = answers};
    return run(&of, error);
}

/* Of a range, or of a parameter that has none. */
static double step_of(const scene_parameter *parameter, double value)
{
    static const double STEP = 1e-4;
    const double range = scene_parameter_slope(parameter, value);
    return STEP * (isfinite(range) && range > 0 ? range : fmax(1, fabs(value)));
}

ad_status solve_members_margin(solve_members *solver, size_t members, const double *parameters,
                               const double *curvature, double *margin, double *by, ad_error *error)
{
    const size_t count = (size_t)solver->count;
    double *beside = malloc((members * count + 1) * sizeof *beside);
    const rod_plane plane = rod_plane_of(&solver->open);
    const bool is_plane = plane.is_planar && (solver->open.motion == SCENE_PLANAR ||
                                              !rod_has_energy(&solver->open, false));
    batch of = {.x = solver,
                .members = members,
                .parameters = parameters,
                .given = curvature,
                .margin = margin,
                .by = by,
                .beside = beside,
                .axis = is_plane ? plane.director : -1};
    if (!beside) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", members);
    }
    for (size_t i = 0; i < members * count; i++) {
        beside[i] = step_of(&solver->open.parameters[i % count], parameters[i]);
    }
    const ad_status status = run(&of, error);
    free(beside);
    return status;
}

/* ---- derivatives --------------------------------------------------------------------------- */

static void free_slopes(solve_members *x)
{
    for (int i = 0; i < x->threads && x->slopes; i++) {
        strain_jacobian_free(x->slopes[i].jacobian);
    }
    free(x->slopes);
    x->slopes = NULL;
}

static ad_status create_slopes(solve_members *x, ad_error *error)
{
    ad_status status = AD_OK;
    x->slopes = calloc((size_t)x->threads, sizeof *x->slopes);
    if (!x->slopes) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    }
    for (int i = 0; i < x->threads && status == AD_OK; i++) {
        solve_rod *changes;
        status = x->count > 0 /* else it is not asked what changes */
                     ? solve_rod_create_changes(&x->open, &x->parameters, &changes, error)
                     : solve_rod_create_open(&x->open, &x->parameters, &changes, error);
        if (status == AD_OK) {
            status = strain_jacobian_create(x->groups[i], changes, &x->slopes[i].jacobian, error);
        }
    }
    if (status != AD_OK) {
        free_slopes(x);
    }
    return status;
}

/* Derivatives of groups of LANES, of this process alone. */
typedef struct derived {
    solve_members *x;
    size_t members;
    const double *parameters, *curvature;
    int from;
    strain_derived to;
} derived;

static void derive_group(void *context, int item, int thread)
{
    const derived *of = context;
    const solve_members *x = of->x;
    slope *by = &x->slopes[thread];
    const size_t first = LANES * (size_t)item, left = of->members - first, count = (size_t)x->count;
    const size_t carried = solve_members_carried(x);
    const size_t points = first * x->points, slopes = points * (count - (size_t)of->from);
    const strain_derived to = {after(of->to.jacobian, slopes * SOLVE_MEMBERS_COLUMNS),
                               after(of->to.forces, points * carried),
                               after(of->to.by, slopes * carried)};
    if (by->status == AD_OK) {
        by->status = strain_jacobian_run(
            by->jacobian, left < LANES ? left : LANES, of->parameters + first * count,
            of->curvature + first * solve_members_numbers(x), of->from, &to, &by->error);
    }
}

ad_status solve_members_forces(solve_members *solver, size_t members, const double *parameters,
                               const double *curvature, int from, double *jacobian, double *forces,
                               double *by, ad_error *error)
{
    derived of = {solver, members, parameters, curvature, from, {jacobian, forces, by}};
    const bool nothing = solver->count == from && !forces;
    ad_status status = nothing || solver->slopes ? AD_OK : create_slopes(solver, error);
    if (status != AD_OK || nothing) {
        return status;
    }
    for (int i = 0; i < solver->threads; i++) {
        solver->slopes[i].status = AD_OK;
    }
    ad_pool_run(solver->pool, (int)((members + LANES - 1) / LANES), derive_group, &of);
    for (int i = 0; i < solver->threads && status == AD_OK; i++) {
        status = solver->slopes[i].status;
        if (status != AD_OK) {
            status = ad_fail(error, status, "%s", solver->slopes[i].error.message);
        }
    }
    return status;
}

ad_status solve_members_jacobian(solve_members *solver, size_t members, const double *parameters,
                                 const double *curvature, int from, double *jacobian,
                                 ad_error *error)
{
    return solve_members_forces(solver, members, parameters, curvature, from, jacobian, NULL, NULL,
                                error);
}

/* ---- where curvature is given -------------------------------------------------------------- */

/* Members of Kronecker's sequence by the root of x^(count + 1) = x + 1. */
static void draw(const solve_members *solver, size_t members, double *parameters)
{
    const size_t count = (size_t)solver->count;
    double root = 2;
    for (int i = 0; i < 60; i++) {
        root = pow(1 + root, 1 / (double)(count + 1));
    }
    for (size_t i = 0; i < members * count; i++) {
        const double at = 0.5 + (double)(i / count + 1) * pow(root, -(double)(i % count + 1));
        parameters[i] = scene_parameter_at(&solver->open.parameters[i % count], at - floor(at));
    }
}

/* On the mesh on which nearly all of some members are within the tolerance; their last step is on
 * the next one. */
static ad_status choose_modes(solve_members *members, ad_error *error)
{
    enum { DRAWN = 64 };
    const strain_group *one = members->groups[0];
    solve_member results[DRAWN] = {{0}};
    double *parameters = malloc(DRAWN * ((size_t)members->count + 1) * sizeof *parameters);
    if (!parameters) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    }
    draw(members, DRAWN, parameters);
    ad_status status =
        solve_members_curvature(members, DRAWN, parameters, NULL, NULL, results, error);
    int solved = 0, enough = 0, modes = 0;
    for (int i = 0; i < DRAWN; i++) {
        solved += results[i].solved;
    }
    while (20 * enough < 19 * solved && modes + 2 < one->solved) {
        modes++;
        enough = 0;
        for (int i = 0; i < DRAWN; i++) {
            enough += results[i].solved && results[i].nodes <= one->level[modes + 1].form->nodes;
        }
    }
    for (int i = 0; i < members->threads && status == AD_OK && modes > 1; i++) {
        status = strain_group_choose(members->groups[i], modes, error);
    }
    free(parameters);
    return status;
}

/* ---- making, all together ------------------------------------------------------------------ */

ad_status solve_members_create(const scene *open, const solve_members_settings *settings,
                               solve_members **result, ad_error *error)
{
    scene one;
    *result = NULL;
    if (!(settings->tolerance > 0)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "members: tolerance %g; allowed: > 0",
                       settings->tolerance);
    }
    ad_status status = check(open, &one, error);
    if (status != AD_OK) {
        return status;
    }
    solve_members *members = calloc(1, sizeof *members);
    if (!members) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    }
    *members =
        (solve_members){.open = *open, .count = open->parameter_count, .points = settings->points};
    status = keep(members, settings->threads, error);
    status = status == AD_OK ? ad_pool_share(members->pool, settings->ranks, error) : status;
    status = status == AD_OK ? create_groups(members, &one, settings, error) : status;
    status = status == AD_OK && members->count > 0 ? choose_modes(members, error) : status;
    if (status != AD_OK) {
        solve_members_free(members);
        return status;
    }
    *result = members;
    return AD_OK;
}

void solve_members_free(solve_members *members)
{
    if (members) {
        free_slopes(members);
        for (int i = 0; members->groups && i < members->threads; i++) {
            strain_group_free(members->groups[i]);
        }
        ad_pool_free(members->pool);
        free(members->s);
        ad_memory_free(&members->memory);
        free(members->names);
        free(members);
    }
}
