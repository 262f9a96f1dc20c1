/* cpinn-plan: a way of a robot among surfaces, with its certificate; see --help. */
#include "physics/numerics/sampling.h"
#include "tools/config/config.h"
#include "tools/files/checkpoint.h"
#include "tools/files/json.h"
#include "tools/files/shapes_vtk.h"
#include "tools/library/cpinn.h"
#include "tools/plan/ompl_shim.h"
#include "tools/programs/cli.h"
#include "tools/programs/conclude.h"
#include "tools/programs/help.h"
#include "tools/programs/plan_files.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char program[] = "cpinn-plan";

/* Points of shapes: of the search, few enough for compiled members; of the certificate;
 * members that say how far the network is off. */
enum { SEARCH_POINTS = 51, EXACT_POINTS = 121, VERIFIED = 500 };

/* Of the solver in the search, over the length: what it is off is a margin there. */
static const double SEARCH_TOLERANCE = 1e-4;

typedef struct options {
    const char *config, *out, *shapes, *run, *json;
    cli_list overrides;
    int seed, threads;
    bool compile, quiet;
} options;

typedef struct planning {
    options asked;
    config *read;
    environment *environment;
    distance_grid *grid;
    plan_robot robot;
    plan_exact *exact;
    double s[SEARCH_POINTS + 1];
    cpinn_family *family;  /* one of the two is there: of a network or of compiled C, */
    solve_members *solver; /* or of the points of the search */
    solve_member solved;
    way_shapes shapes;
    char by[300];
    way way;
    verdict verdict;
} planning;

/* ---- who says what shapes are in the search ---------------------------------------------------
 */

static ad_status by_family(void *context, const double *parameters, double *values, ad_error *error)
{
    planning *const p = context;
    return cpinn_family_evaluate(p->family, NULL, 1, parameters, values, NULL, error);
}

static ad_status by_solver(void *context, const double *parameters, double *values, ad_error *error)
{
    planning *const p = context;
    return solve_members_solve(p->solver, 1, parameters, values, &p->solved, error);
}

static ad_status refuse(const planning *p, const char *key, const char *why, ad_error *error)
{
    return config_refuse(p->read, key, why, error);
}

/* Whether a network is of these parameters, in their order. */
static bool is_of_scene(const planning *p)
{
    const scene *const of = &p->read->scene;
    bool same = cpinn_family_parameters(p->family) == of->parameter_count;
    for (int i = 0; i < of->parameter_count && same; i++) {
        const scene_parameter *const its = cpinn_family_parameter(p->family, i);
        same = strcmp(its->name, of->parameters[i].name) == 0 &&
               its->low <= of->parameters[i].low && its->high >= of->parameters[i].high;
    }
    return same;
}

static cpinn_family_settings of_search(const planning *p)
{
    return (cpinn_family_settings){
        .points = p->shapes.points, .s = p->s, .compile = p->asked.compile, .threads = 1};
}

/* With the error that is known of its answers. */
static ad_status search_by_family(planning *p, double off, ad_error *error)
{
    if (*cpinn_family_not_compiled(p->family)) {
        return ad_fail(error, AD_BAD_ARGUMENT, "--compile: %.300s",
                       cpinn_family_not_compiled(p->family));
    }
    p->shapes = (way_shapes){
        by_family, p, p->shapes.points, (size_t)cpinn_family_columns(p->family), p->s, off};
    return AD_OK;
}

static ad_status open_family(planning *p, const char *folder, ad_error *error)
{
    cpinn_family_check check;
    const cpinn_family_settings settings = of_search(p);
    ad_status status = cpinn_family_open(folder, &settings, &p->family, error);
    if (status == AD_OK && !is_of_scene(p)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%.200s: the network in %.200s was trained for other parameters; train it "
                       "again, or name another by --run",
                       p->asked.config, folder);
    }
    status = status == AD_OK ? cpinn_family_verify(p->family, VERIFIED, 1, &check, error) : status;
    if (status == AD_OK) {
        const double worst = check.rows[CPINN_WAY_NETWORK].worst;
        status = search_by_family(p, isfinite(worst) ? worst : 0, error);
        snprintf(p->by, sizeof p->by,
                 "the network in %.150s, off by %.2g m at worst of %zu members", folder, worst,
                 check.members - check.unsolved);
    }
    return status;
}

static ad_status open_solver(planning *p, ad_error *error)
{
    const double off = SEARCH_TOLERANCE * scene_length(&p->read->scene);
    const solve_members_settings settings = {
        .tolerance = SEARCH_TOLERANCE, .threads = 1, .points = p->shapes.points, .s = p->s};
    snprintf(p->by, sizeof p->by, "the solver%s, off by %.2g m",
             p->asked.compile ? ", compiled" : "", off);
    if (p->asked.compile) {
        const cpinn_family_settings same = of_search(p);
        const ad_status status =
            cpinn_family_file(p->asked.config, p->asked.overrides.count, p->asked.overrides.texts,
                              SEARCH_TOLERANCE, &same, &p->family, error);
        return status == AD_OK ? search_by_family(p, off, error) : status;
    }
    p->shapes.of_member = by_solver;
    p->shapes.context = p;
    p->shapes.columns = SOLVE_MEMBERS_COLUMNS;
    p->shapes.s = p->s;
    p->shapes.error = off;
    return solve_members_create(&p->read->scene, &settings, &p->solver, error);
}

static ad_status open_shapes(planning *p, ad_error *error)
{
    char folder[200], checkpoint[220];
    p->shapes.points =
        sampling_along(scene_length(&p->read->scene), SEARCH_POINTS, 1, &p->read->plan.from, p->s);
    snprintf(folder, sizeof folder, "runs/%.150s", p->read->settings.name);
    snprintf(checkpoint, sizeof checkpoint, "%s/checkpoint.h5", folder);
    if (p->asked.run || access(checkpoint, R_OK) == 0) {
        return open_family(p, p->asked.run ? p->asked.run : folder, error);
    }
    return open_solver(p, error);
}

/* ---- what is asked --------------------------------------------------------------------------- */

static ad_status read_scene(planning *p, ad_error *error)
{
    const options *const o = &p->asked;
    char key[PLAN_KEY] = "plan";
    ad_status status =
        config_read(o->config, NULL, o->overrides.count, o->overrides.texts, &p->read, error);
    if (status != AD_OK) {
        return status;
    }
    plan_settings *const s = &p->read->plan;
    s->seed = o->seed >= 0 ? o->seed : s->seed;
    if (!config_plans(p->read)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%.300s: has no section plan; cpinn-plan --help shows one", o->config);
    }
    if (!s->environment.file) {
        return refuse(p, "plan.environment.file", "is not given; allowed: .stl, .obj", error);
    }
    if (isnan(s->radius)) {
        return refuse(p, "plan.radius", "is not given; allowed: a number >= 0 (m)", error);
    }
    if (s->from >= scene_length(&p->read->scene)) {
        return refuse(p, "plan.from", "is not within the rod", error);
    }
    if (s->goal_count > 0 && (s->goal.count > 0 || !isnan(s->goal.position[0]))) {
        return refuse(p, "plan.goals", "are given beside plan.goal; allowed: one of the two",
                      error);
    }
    status = plan_robot_create(s, &p->read->scene, &p->robot, key, error);
    if (status == AD_BAD_INPUT) {
        return refuse(p, key, error->message, error);
    }
    return status;
}

/* What a roadmap depends on, beside its variables and how near it goes to the surface. */
static ad_status seal(const planning *p, roadmap_settings *of, ad_error *error)
{
    const plan_settings *const s = &p->read->plan;
    const int side = (int)s->environment.side;
    char *text = NULL;
    size_t size = 0;
    FILE *const file = open_memstream(&text, &size);
    ad_status status = file ? config_write_physics(p->read, file)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for a roadmap");
    if (file && fclose(file) != 0 && status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a roadmap");
    }
    if (status == AD_OK) {
        const uint64_t first = checkpoint_hash(CHECKPOINT_HASH_START, text, size);
        uint64_t shapes = checkpoint_hash(first, p->robot.fixed,
                                          (size_t)p->robot.parameters * sizeof *p->robot.fixed);
        shapes = checkpoint_hash(shapes, &s->from, sizeof s->from);
        *of = (roadmap_settings){
            .file = s->roadmap,
            .nodes = (size_t)s->roadmap_nodes,
            .surface =
                checkpoint_hash(environment_surface(p->environment)->hash, &side, sizeof side),
            .shapes = checkpoint_hash(shapes, &p->shapes.error, sizeof p->shapes.error)};
    }
    free(text);
    return status;
}

static ad_status find(planning *p, ad_error *error)
{
    char key[PLAN_KEY] = "plan";
    roadmap_settings kept = {.file = NULL};
    if (p->read->plan.roadmap && seal(p, &kept, error) != AD_OK) {
        return error->status;
    }
    const way_problem problem = {.settings = &p->read->plan,
                                 .environment = p->environment,
                                 .grid = p->grid,
                                 .exact = p->exact,
                                 .shapes = &p->shapes,
                                 .roadmap = kept.file ? &kept : NULL};
    const ad_status status = way_find(&problem, &p->way, key, error);
    if (status == AD_BAD_INPUT) {
        return refuse(p, key, error->message, error);
    }
    return status;
}

/* What is said of a goal: "the goal ...", "goal 2 of 3 ...". */
static verdict_reason say_goal(const planning *p, int k, char text[VERDICT_TEXT])
{
    const way *const w = &p->way;
    const way_goal *const g = &w->goal[k];
    char name[40], turned[60] = "";
    snprintf(name, sizeof name, w->goals > 1 ? "goal %d of %d" : "the goal", k + 1, w->goals);
    switch (g->end) {
    case WAY_CERTIFIED:
        snprintf(text, VERDICT_TEXT, "%s is reached at row %zu", name, g->row + 1);
        return VERDICT_NONE;
    case WAY_NOT_TRIED:
        snprintf(text, VERDICT_TEXT, "%s is not tried", name);
        return VERDICT_NONE;
    case WAY_NOT_CERTIFIED:
        snprintf(text, VERDICT_TEXT,
                 "a way to %s was found, but at row %zu of %zu %s; another seed or a smaller "
                 "clearance may help",
                 name, w->certificate->which + 1, w->certificate->count,
                 certificate_text(w->certificate->end));
        return VERDICT_NOT_CERTIFIED;
    case WAY_NOT_FOUND:
        snprintf(text, VERDICT_TEXT,
                 "%zu configurations were tried, and no way leads to %s; more states, another seed "
                 "or a smaller clearance may help",
                 w->looked, name);
        return VERDICT_NONE_FOUND;
    case WAY_GOAL_BEYOND:
        if (g->angle > 0) {
            snprintf(turned, sizeof turned, " and %.3g rad of its direction", g->angle);
        }
        snprintf(text, VERDICT_TEXT,
                 "%s is out of reach: the tip comes to %.4g mm of it%s at nearest", name,
                 1e3 * g->nearest, turned);
        return VERDICT_NONE_FOUND;
    case WAY_GOAL_TOUCHES:
        snprintf(text, VERDICT_TEXT,
                 "the tip reaches %s, but no such shape that was found keeps %.4g mm from the "
                 "surface",
                 name, 1e3 * p->read->plan.clearance);
        return VERDICT_NONE_FOUND;
    }
    return VERDICT_NONE;
}

/* ---- report ---------------------------------------------------------------------------------- */

static void print_head(const planning *p)
{
    const surface *const of = environment_surface(p->environment);
    printf("%s: %d variables:", p->read->settings.name, p->robot.count);
    for (int k = 0; k < p->robot.count; k++) {
        printf("%s %s %g to %g", k ? "," : "", p->robot.names[k], p->robot.low[k],
               p->robot.high[k]);
    }
    printf("\nsurface of %zu triangles; grid of %.3g mm, %s\nsearch by %s\n", of->triangles,
           1e3 * p->grid->field.cell, p->grid->was_kept ? "from its file" : "made", p->by);
}

static const char *const sources[] = {
    [ROADMAP_MADE] = "made",
    [ROADMAP_KEPT] = "from its file",
    [ROADMAP_OTHER_SURFACE] = "of another surface: its ways are looked at again",
    [ROADMAP_OTHER_SHAPES] = "of another robot or network: its ways are looked at again",
    [ROADMAP_NEARER] = "of less clearance: its ways are looked at again"};

static void print_way(const planning *p)
{
    const way *const w = &p->way;
    for (int k = 0; k < w->goals && w->goals > 1; k++) {
        char text[VERDICT_TEXT];
        say_goal(p, k, text);
        printf("%s\n", text);
    }
    if (w->searches == 0) {
        return;
    }
    if (p->read->plan.roadmap) {
        printf("roadmap of %zu nodes and %zu edges, %s, %.3g s\n", w->nodes, w->edges,
               sources[w->source], w->seconds_roadmap);
    }
    size_t ends = 0;
    for (int k = 0; k < w->goals; k++) {
        ends += w->goal[k].count;
    }
    printf("%d goal%s, %zu configuration%s; %d search%s, %zu looked at, %.3g s\n", w->goals,
           w->goals == 1 ? "" : "s", ends, ends == 1 ? "" : "s", w->searches,
           w->searches == 1 ? "" : "es", w->looked, w->seconds_search);
    if (w->end != WAY_CERTIFIED) {
        return;
    }
    printf("way of %zu corners, certified by %zu shapes in %.3g s; least at s = %.4g m, in mm:\n",
           w->corners, w->certificate->count, w->seconds_certificate, w->certificate->all.at);
    for (int k = 0; k < PLAN_PARTS; k++) {
        printf("  %-24s %12.6g\n", plan_part_word(k), 1e3 * plan_part(&w->certificate->all, k));
    }
}

static void tell(const void *of, json *to)
{
    const planning *p = of;
    const way *const w = &p->way;
    if (p->grid) {
        json_open(to, "environment", '{');
        json_text(to, "file", p->read->plan.environment.file);
        json_integer(to, "triangles", (int64_t)environment_surface(p->environment)->triangles);
        json_number(to, "grid", p->grid->field.cell);
        json_close(to, '}');
    }
    json_open(to, "goals", '[');
    for (int k = 0; k < w->goals; k++) {
        char text[VERDICT_TEXT];
        say_goal(p, k, text);
        json_text(to, NULL, text);
    }
    json_close(to, ']');
    if (w->searches) {
        if (p->read->plan.roadmap) {
            json_open(to, "roadmap", '{');
            json_text(to, "file", p->read->plan.roadmap);
            json_integer(to, "nodes", (int64_t)w->nodes);
            json_integer(to, "edges", (int64_t)w->edges);
            json_text(to, "is", sources[w->source]);
            json_number(to, "seconds", w->seconds_roadmap);
            json_close(to, '}');
        }
        json_open(to, "search", '{');
        json_text(to, "by", strncmp(p->by, "the solver", 10) == 0 ? "solver" : "network");
        json_number(to, "error", p->shapes.error);
        json_integer(to, "searches", w->searches);
        json_integer(to, "configurations", (int64_t)w->looked);
        json_number(to, "seconds", w->seconds_search);
        json_number(to, "processor_seconds", w->processor_search);
        json_close(to, '}');
    }
    if (w->certificate) {
        json_open(to, "certificate", '{');
        json_text(to, "holds", w->end == WAY_CERTIFIED ? "yes" : "no");
        json_integer(to, "shapes", (int64_t)w->certificate->count);
        json_number(to, "seconds", w->seconds_certificate);
        json_number(to, "processor_seconds", w->processor_certificate);
        for (int k = 0; k < PLAN_PARTS; k++) {
            json_number(to, plan_part_column(k), plan_part(&w->certificate->all, k));
        }
        json_close(to, '}');
    }
}

static ad_status run(planning *p, ad_error *error)
{
    const options *const o = &p->asked;
    if (!ompl_is_built() || !environment_is_built()) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "this build has no %s; install libembree-dev, libompl-dev and g++, and "
                       "build cpinn again",
                       ompl_is_built() ? "Embree" : "OMPL");
    }
    ad_status status = o->out ? table_check_path(o->out, error) : AD_OK;
    status = status == AD_OK && o->shapes ? shapes_check_path(o->shapes, error) : status;
    status = status == AD_OK ? json_check_path(o->json, error) : status;
    status = status == AD_OK ? read_scene(p, error) : status;
    status = status == AD_OK
                 ? distance_grid_open(&p->read->plan.environment, scene_length(&p->read->scene),
                                      &p->environment, &p->grid, error)
                 : status;
    if (status == AD_OK) {
        status = plan_exact_create(&p->robot, &p->read->scene, EXACT_POINTS, p->read->plan.from,
                                   p->asked.threads, &p->exact, error);
    }
    status = status == AD_OK ? open_shapes(p, error) : status;
    status = status == AD_OK ? find(p, error) : status;
    if (status != AD_OK) {
        return status;
    }
    for (int k = 0; k < p->way.goals; k++) {
        char text[VERDICT_TEXT];
        const verdict_reason reason = say_goal(p, k, text);
        verdict_add(&p->verdict, reason, "%s", text);
    }
    if (o->out && p->way.certificate) {
        status = plan_write(&p->robot, p->way.certificate, o->out, error);
    }
    if (status == AD_OK && o->shapes && p->way.certificate) {
        status = plan_write_shapes(p->exact, p->environment, &p->read->plan, p->way.certificate,
                                   o->shapes, error);
    }
    if (status == AD_OK && !o->quiet) {
        print_head(p);
        print_way(p);
        verdict_print(stdout, "", &p->verdict);
    }
    return status;
}

int main(int argc, char **argv)
{
    planning p = {.asked = {.seed = -1}};
    options *const o = &p.asked;
    const cli_option list[] = {{"--out", "FILE", CLI_TEXT, &o->out, 0, 0},
                               {"--shapes", "FILE", CLI_TEXT, &o->shapes, 0, 0},
                               {"--run", "DIR", CLI_TEXT, &o->run, 0, 0},
                               {"--compile", NULL, CLI_FLAG, &o->compile, 0, 0},
                               CLI_SEED(&o->seed),
                               CLI_THREADS(&o->threads),
                               CLI_SET(&o->overrides),
                               CLI_JSON(&o->json),
                               CLI_QUIET(&o->quiet)};
    const cli_program about = {program, "CONFIG.yaml", help_plan, verdict_help, NULL};
    int status = cli_parse(&about, list, sizeof list / sizeof *list, argc, argv, &o->config);
    if (status != CLI_RUN) {
        return status;
    }
    o->quiet = o->quiet || json_is_printed(o->json);
    ad_error error = {.message = ""};
    const ad_status ran = run(&p, &error);
    const conclusion end = {.program = program,
                            .quiet = o->quiet,
                            .json = o->json,
                            .name = p.read ? p.read->settings.name : NULL,
                            .tell = tell,
                            .of = &p,
                            .verdict = &p.verdict};
    status = conclude(&end, ran, &error);
    way_free(&p.way);
    cpinn_family_free(p.family);
    solve_members_free(p.solver);
    plan_exact_free(p.exact);
    distance_grid_free(p.grid);
    environment_free(p.environment);
    config_free(p.read);
    return status;
}
