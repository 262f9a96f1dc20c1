/* The table of support, every cell of it (physics/scene/support.h): a scene of each feature is run
 * in each form. What is taken is solved, and its shape is that of the solver by collocation, or of
 * nodes in motion. What is without effect leaves the shape as it is. What is refused says the
 * sentence of the table, with exit status 2.
 *
 *   test_library support [FEATURE]     of this feature alone */
#include "config_testing.h"
#include "fewer.h"
#include "temporary_folder.h"

#include "physics/chain/reduced.h"
#include "physics/chain/solve_members.h"
#include "physics/rod/strain.h"
#include "physics/scene/support.h"
#include "physics/solve/solve.h"
#include "tools/library/cpinn.h"

#include <string.h>
#include <time.h>

enum { CHANGES = 6, PLACES = 3, LIST = 24, SETTINGS = 3 * CHANGES + LIST };

/* A rod of 0.3 m that a force along it bends by a third of its length; in motion for a quarter of
 * L^2 (rhoA/EI)^(1/2). */
static const char base[] =
    "rod: {model: cosserat, length: 0.3, section: {shape: circle, radius: 0.02},\n"
    "      material: {youngs_modulus: 1e6, poissons_ratio: 0.45, density: 1070}}\n"
    "loads: {force: [0, 4, 0]}\n";
/* In motion it begins in equilibrium, and the force changes smoothly. */
static const char *const in_motion[] = {"time.duration=0.04", "initial.state=equilibrium",
                                        "loads.force=[0, '4 - 32*(25*t)^2', 0]", NULL};
static const double length = 0.3, seen[PLACES] = {0.11, 0.21, 0.3}, duration = 0.04;

/* Over the length. Forms of one scene differ by their own errors, and what a feature does has to be
 * three times as much: a form that leaves it out does not pass. */
static const double BY_SOLVERS = 3e-4, BY_STEPS = 1e-3, BY_NETWORKS = 5e-3, MOVED = 1.5e-2;

typedef struct feature_scene {
    const char *feature;
    const char *changes[CHANGES];
    const char *moving[3]; /* of a scene in motion, more changes */
    const char *on_tape;   /* for networks whose residual is on the tape, or NULL */
    const char *beside;    /* another feature that this one needs, or NULL */
    const char *without;   /* the change that takes the feature out again; NULL: the base */
    bool is_silent;        /* its effect is not measured here */
} feature_scene;

#define HELD   "position: [0, 0, 0.3], rotation: [1, 0, 0, 0]"
#define FASTER "loads.force=[0, '4 - 100*(25*t)^2', 0]"
#define WAVES  "network.fourier.features=24"
#define TENDON "tendons=[{offset: [0, 0.015], "
#define EXACT                                                                                      \
    "manufactured={position: ['0.1*s^2', '0.2*s^2*cos(8*t)', 's - 0.3*s^3'], angles: "             \
    "['-0.4*s*cos(8*t)', '0.2*s', '0.3*s']}"
#define EXACT_AT_REST                                                                              \
    "manufactured={position: ['0.1*s^2', '0.2*s^2', 's - 0.3*s^3'], angles: ['-0.4*s', '0.2*s', "  \
    "'0.3*s']}"

static const feature_scene scenes[] = {
    {.feature = "a beam of small deflection",
     .changes = {"rod.model=timoshenko", "loads=null", "beam={force: 0.1}"},
     .moving = {"initial=null"},
     .is_silent = true},
    {.feature = "a manufactured solution with locked strains",
     .changes = {"rod.model=kirchhoff", "loads=null", EXACT_AT_REST},
     .moving = {"initial=null"}},
    {.feature = "a manufactured solution with a tendon whose tension is sought",
     .changes = {"loads=null", EXACT_AT_REST, TENDON "displacement: 0.004, stiffness: 5000}]"},
     .moving = {"initial=null"}},
    {.feature = "a manufactured solution with an imperfection",
     .changes = {"loads=null", EXACT_AT_REST, "rod.rest.imperfection=[1, 0, 0]"},
     .moving = {"initial=null"}},
    {.feature = "a manufactured solution",
     .changes = {"loads=null", EXACT_AT_REST},
     .moving = {"initial=null", EXACT},
     .is_silent = true},
    {.feature = "locked shear or stretch",
     .changes = {"rod.model=inextensible", "loads.tip.force=[0, 0, 100]"},
     .without = "rod.model=cosserat"},
    {.feature = "a rod with tubes that is inserted",
     .changes =
         {"rod.model=kirchhoff", "rod.inserted=0.2",
          "tubes=[{section: {radius: 0.03, inner_radius: 0.025}, end: 0.2, "
          "material: {youngs_modulus: 1e6, poissons_ratio: 0.45, density: 1070}, rest: {curvature: "
          "[3, 0, 0]}}]"},
     .is_silent = true},
    {.feature = "a learned law of a rod whose lengths or places have ranges",
     .changes = {"rod.section.radius=0.01", "rod.material={density: 1070}", "rod.law.file=law.csv",
                 "loads.force=[0, 0.04, 0]", "parameters.more={range: [0.9, 1.1]}",
                 "rod.length=0.3*more"},
     .moving = {"loads.force=[0, '0.04 + 0.3*(25*t)^2', 0]", "initial.state=given"},
     .beside = "a length or place with a range",
     .is_silent = true},
    {.feature = "concentric tubes",
     .changes =
         {"rod.model=kirchhoff",
          "tubes=[{section: {radius: 0.03, inner_radius: 0.025}, end: 0.2, "
          "material: {youngs_modulus: 1e6, poissons_ratio: 0.45, density: 1070}, rest: {curvature: "
          "[3, 0, 0]}}]"}},
    {.feature = "a learned law",
     .changes = {"rod.section.radius=0.01", "rod.material={density: 1070}", "rod.law.file=law.csv",
                 "loads.force=[0, 0.04, 0]"},
     .moving = {"loads.force=[0, '0.04 + 0.3*(25*t)^2', 0]"},
     .is_silent = true},
    {.feature = "friction of a tendon",
     .changes = {TENDON "tension: 10, friction: 0.9}]", "rod.rest.curvature=[4, 0, 0]"},
     .moving = {"tendons[0].tension=10 + 30*(25*t)^2"},
     .without = "tendons[0].friction=0"},
    {.feature = "friction of a tendon where strains jump",
     .beside = "friction of a tendon",
     .changes = {TENDON "tension: 30, friction: 0.9}]", "rod.rest.curvature=[4, 0, 0]",
                 "loads.points=[{at: 0.15, force: [0, 0.5, 0]}]"},
     .moving = {"tendons[0].tension=30 + 60*(25*t)^2"},
     .without = "tendons[0].friction=0"},
    {.feature = "a tendon that keeps its length", .changes = {TENDON "displacement: 0.004}]"}},
    {.feature = "a tendon of given displacement",
     .changes = {TENDON "displacement: 0.004, stiffness: 5000}]"}},
    {.feature = "a tendon of given tension", .changes = {TENDON "tension: 14}]"}},
    {.feature = "a chamber",
     .changes = {"chambers=[{offset: [0, 0.015], area: 3e-4, pressure: 5e4}]"}},
    {.feature = "a free or loaded start",
     .changes = {"boundary={start: {type: loaded}, end: {type: clamped, " HELD "}}",
                 "loads.base.force=[0.5, 0, 0]"}},
    {.feature = "a sliding start",
     .changes = {"boundary={start: {type: guided, across: [0, 0, 1]}, end: {type: clamped, " HELD
                 "}}"}},
    {.feature = "a spring or body at a pinned start",
     .changes = {"boundary={start: {type: pinned}, end: {type: roller, position: [0, 0, 0.3], "
                 "along: [0, 0, 1]}}",
                 "springs=[{at: 0, turning: [5, 5, 5]}]", "loads.force=[0, 30, 0]"},
     .moving = {"loads.force=[0, '30 - 32*(25*t)^2', 0]"},
     .without = "springs=[{at: 0, turning: [1e-6, 1e-6, 1e-6]}]"},
    {.feature = "a pinned start",
     .changes = {"boundary={start: {type: pinned}, end: {type: clamped, " HELD "}}"},
     .moving = {"boundary=null", "boundary={start: {type: pinned}, end: {type: free}}",
                "initial={state: given, position: [0, 0, s], rotation: [1, 0, 0, 0]}"}},
    {.feature = "a driven start",
     .on_tape = "losses.interior.points=250",
     .changes = {"boundary.start={type: driven, rotation: [1, 0.05, 0, 0]}"},
     .moving =
         {"boundary.start={type: driven, position: ['280*t^3', 0, 0], rotation: [1, 0, 0, 0]}"}},
    {.feature = "an end turned by an angle",
     .changes =
         {"boundary.end={type: clamped, position: [0, 0, 0.301], rotation_vector: [0.1, 0.2, 0]}"}},
    {.feature = "a held end", .changes = {"boundary.end={type: clamped, " HELD "}"}},
    {.feature = "a sliding end",
     .changes = {"boundary.end={type: roller, position: [0, 0, 0.3], along: [0, 0, 1]}"}},
    {.feature = "a driven end",
     .changes = {"boundary.end={type: driven, " HELD "}"},
     .moving =
         {"boundary.end={type: driven, position: [0, '150*t^3', 0.301], rotation: [1, 0, 0, 0]}"}},
    {.feature = "segments",
     .on_tape = WAVES,
     .changes = {"rod.length=null",
                 "segments=[{length: 0.1}, {length: 0.2, section: {radius: 0.016}}]"}},
    {.feature = "a point load", .changes = {"loads.points=[{at: 0.1, force: [0, 2, 0]}]"}},
    {.feature = "a body",
     .on_tape = WAVES,
     .changes = {"loads.gravity=[1, -5, 0]",
                 "bodies=[{at: 0.2, mass: 0.3, offset: [0, 0.01, 0.01]}]"},
     .moving = {"losses.interior.points=200"}}, /* of a network; 100 leave 5e-3 */
    {.feature = "a spring",
     .on_tape = WAVES,
     .changes = {"springs=[{at: 0.2, stiffness: [100, 100, 0]}]"}},
    {.feature = "a foundation", .changes = {"loads.foundation=[800, 800, 0]"}},
    {.feature = "gravity", .changes = {"loads.gravity=[1, -5, 0]"}},
    {.feature = "buoyancy",
     .changes = {"loads.gravity=[1, -5, 0]", "loads.buoyancy=0.6"},
     .without = "loads.buoyancy=0"},
    {.feature = "a distributed force", .changes = {"loads.force=[-2, 3, 0]"}},
    {.feature = "a distributed moment",
     .changes = {"loads.moment=[0.4, 0, 0]"},
     .moving = {"initial.state=given"}},
    {.feature = "a distributed load that follows",
     .changes = {"loads.force=[0, 12, 0]", "loads.frame=follower"},
     .without = "loads.frame=dead",
     .is_silent = true},
    {.feature = "a load at the tip", .changes = {"loads.tip.force=[0.5, 0, 0.5]"}},
    {.feature = "a load at the tip that follows",
     .changes = {"loads.tip={force: [1, 0, 1], frame: follower}"},
     .without = "loads.tip.frame=dead",
     .is_silent = true},
    {.feature = "a tapered rod", .changes = {"rod.section.radius='0.02 - 0.02*s'"}},
    {.feature = "a rest shape", .changes = {"rod.rest={curvature: ['2*s', 1, 0.5]}"}},
    {.feature = "an imperfection",
     .changes = {"rod.rest.imperfection=[1, 0, 0]"},
     .is_silent = true},
    {.feature = "drag",
     .changes = {"loads.drag=400"},
     .moving = {FASTER},
     .without = "loads.drag=0"},
    {.feature = "quadratic drag",
     .changes = {"loads.quadratic_drag=2000"},
     .moving = {FASTER},
     .without = "loads.quadratic_drag=0"},
    {.feature = "a magnetised rod in a field",
     .changes = {"loads.magnetic={moment: [0, 1, 8], field: [0.04, 0.02, 0.02], gradient: [0.1, "
                 "-0.05, 0.1, 0.05, 0.1]}"},
     .moving = {"loads.magnetic.field=['0.04 + 0.04*(25*t)^2', 0.02, 0.02]"}},
    {.feature = "drag in a fluid",
     .changes = {"loads.fluid={along: [100, 10, 1000], across: [200, 100, 1000]}"},
     .moving = {FASTER},
     .without = "loads.fluid={along: [0, 0, 0], across: [0, 0, 0]}"},
    {.feature = "added mass of a fluid",
     .changes = {"loads.fluid.added_mass=1.2"},
     .moving = {FASTER},
     .without = "loads.fluid.added_mass=0"},
    {.feature = "damping of the material",
     .changes = {"rod.material.relaxation_time=0.2"},
     .moving = {FASTER},
     .without = "rod.material.relaxation_time=0"},
    {.feature = "a material with a Maxwell branch",
     .changes = {"rod.material.maxwell={ratio: 20, time: 0.05}"},
     .moving = {FASTER},
     .without = "rod.material.maxwell={ratio: 0, time: 1}"},
    {.feature = "a rod that shears without rotary inertia",
     .changes = {"rod.inertia.rotary=[0, 0, 0]"},
     .is_silent = true},
    {.feature = "a rod without shear and rotary inertia",
     .beside = "locked shear or stretch",
     .changes = {"rod.model=kirchhoff", "rod.inertia.rotary=[0, 0, 0]"},
     .without = "rod.inertia.rotary=null",
     .is_silent = true},
    {.feature = "a given state at t = 0",
     .changes =
         {"initial={state: given, velocity: ['3*s^2', 0, 0], angular_velocity: [0, '6*s', 0]}"}},
    {.feature = "equilibrium at t = 0",
     .changes = {"initial.state=equilibrium"},
     .without = "initial.state=given"},
    {.feature = "a formula of time", .changes = {"loads.force=[0, '4 - 90*(25*t)^2', 0]"}},
    {.feature = "soft conditions", .changes = {"enforcement.boundary=soft"}, .is_silent = true},
    {.feature = "a parameter with a range",
     .changes = {"parameters.more={range: [0.9, 1.1]}", "rod.material.youngs_modulus=1e6*more",
                 "network.fourier.features=40"},
     .moving = {"initial.state=given"},
     .is_silent = true},
    {.feature = "a length or place with a range",
     .changes = {"parameters.more={range: [0.9, 1.1]}", "rod.length=0.3*more",
                 "network.fourier.features=40"},
     .moving = {"initial.state=given"},
     .beside = "a parameter with a range",
     .is_silent = true},
    {.feature = "a rod that moves through its port by a formula",
     .changes = {"rod.inserted=0.26+0.04*cos(50*t)"},
     .moving = {"initial.state=given"},
     .beside = "a formula of time"},
    {.feature = "a rod that moves through its port by an input",
     .changes = {"rod.length=0.32", "parameters.out={range: [0.28, 0.32]}", "rod.inserted=out",
                 "rod.feed_time=0.01"},
     .moving = {"initial.state=given"},
     .beside = "a length or place with a range",
     .without = "rod.feed_time=0.02",
     .is_silent = true},
    {.feature = "a base that an input turns",
     .changes = {"parameters.turn={range: [-0.02, 0.02]}", "network.fourier.features=40",
                 "boundary.start.rotation=[cos(turn/2), 0, 0, sin(turn/2)]",
                 "boundary.start.turn_time=0.01"},
     .moving = {"initial.state=given"},
     .beside = "a parameter with a range",
     .without = "boundary.start.turn_time=0.02",
     .is_silent = true},
    {.feature = "a play or lag of an input",
     .beside = "a parameter with a range",
     .changes = {"parameters.push={range: [6, 8]}", "loads.force=[0, 'play(push, 1)', 0]"},
     .moving = {"loads.force=[0, 'lag(play(push, 1), 0.1)', 0]", "initial.state=given"}},
    {.feature = "a parameter to be identified",
     .beside = "a formula of time",
     .changes = {"parameters.more={identify: 0.8, range: [0.5, 1.5]}",
                 "rod.material.youngs_modulus=1e6*more",
                 "data=[{quantity: position, file: MEASURED, noise: 1e-6}]"},
     .is_silent = true},
    {.feature = "measured data",
     .beside = "a formula of time",
     .changes = {"data=[{quantity: position, file: MEASURED, noise: 1e-6}]"},
     .is_silent = true},
};
enum { SCENES = sizeof scenes / sizeof scenes[0] };

/* ---- a scene in a form ---------------------------------------------------------------------- */

/* What a form has made of a scene: positions at places `seen`, of a motion at its end, or why not.
 */
typedef struct outcome {
    bool solved;
    double x[PLACES][3]; /* m */
    char sentence[sizeof((ad_error *)NULL)->message];
    verdict verdict;
    double seconds;
} outcome;

static char file[4096], measured[4096]; /* paths of the scene, and of a file of data */

typedef struct settings {
    int count;
    const char *texts[SETTINGS];
    char data[5000];
} settings;

static void add(settings *x, const char *change)
{
    if (change) {
        assert_true(x->count < SETTINGS);
        const char *at = strstr(change, "MEASURED");
        if (at) {
            snprintf(x->data, sizeof x->data, "%.*s%s%s", (int)(at - change), change, measured,
                     at + strlen("MEASURED"));
        }
        x->texts[x->count++] = at ? x->data : change;
    }
}

/* What the scene of a form needs beside the feature. */
static void add_form(settings *x, support_form form, bool taken)
{
    static const char *const of_forms[SUPPORT_FORMS] = {
        [SUPPORT_MIXED] = "formulation=mixed",
        [SUPPORT_DISPLACEMENT] = "formulation=displacement",
        [SUPPORT_POSE_STRAIN] = "formulation=pose_strain",
        [SUPPORT_FAMILY] = "formulation=strain",
        [SUPPORT_MIXED_MOTION] = "formulation=mixed",
        [SUPPORT_DISPLACEMENT_MOTION] = "formulation=displacement",
        [SUPPORT_POSE_STRAIN_MOTION] = "formulation=pose_strain",
        [SUPPORT_STRAIN_MOTION] = "formulation=strain",
    };
    const bool is_family =
        form == SUPPORT_FAMILY || form == SUPPORT_EXPORT || form == SUPPORT_ONE_STEP;
    add(x, form == SUPPORT_ONE_STEP && !taken ? "surrogate={step: 0.01}" : of_forms[form]);
    if (is_family && taken &&
        form != SUPPORT_ONE_STEP) { /* of a family, whose member is the scene */
        add(x, "parameters.usual={range: [0.5, 1.5]}");
        add(x, "rod.material.density=1070*usual");
    }
}

static void refuse(outcome *to, const ad_error *error)
{
    to->solved = false;
    snprintf(to->sentence, sizeof to->sentence, "%s", error->message);
    verdict_add_error(&to->verdict, error);
}

static void keep(outcome *to, const double *columns)
{
    to->solved = true;
    for (int i = 0; i < PLACES; i++) {
        for (int k = 0; k < 3; k++) {
            to->x[i][k] = columns[k * PLACES + i];
        }
    }
}

/* Of a beam the deflection is in the place of x. */
static void keep_solution(outcome *to, const solution *made, const scene *of)
{
    double values[3 * PLACES] = {0}, t[PLACES];
    ad_error error = {.message = ""};
    for (int i = 0; i < PLACES; i++) {
        t[i] = scene_duration(of);
    }
    if (solution_evaluate(made, scene_is_beam(of) ? 1 : 3, PLACES, seen, t, values, &error) !=
        AD_OK) {
        fail_msg("%s", error.message);
    }
    keep(to, values);
}

/* What is to be identified, as cpinn-solve finds it: 1. */
static ad_status identify(const settings *list, config **one, ad_error *error)
{
    char at[64];
    cpinn_unknowns *found = NULL;
    ad_status status = cpinn_identify_file(file, list->count, list->texts, 1, &found, error);
    if (status == AD_OK) {
        const double value = cpinn_unknowns_value(found, 0);
        assert_near(value, 1, 1e-3); /* positions are of three places, to 1e-6 m */
        snprintf(at, sizeof at, "more=%.17g", value);
        status = prepare_read_member(file, NULL, list->count, list->texts, at, one, error);
    }
    cpinn_unknowns_free(found);
    return status;
}

static ad_status by_solver(const scene *given, support_form form, const settings *list, outcome *to,
                           ad_error *error)
{
    scene of;
    scene_middle(given, &of);
    const bool moves = scene_is_dynamic(&of), path = form == SUPPORT_PATH;
    const solve_settings asked = {.tolerance = moves ? 1e-5 : 1e-9,
                                  .method =
                                      form == SUPPORT_MODES ? SOLVE_MODES : SOLVE_COLLOCATION};
    const double times[1] = {duration};
    const char *key = "";
    ad_error reason;
    if (given->unknown_count > 0) {
        config *one = NULL;
        ad_status status = identify(list, &one, error);
        if (status == AD_OK) {
            status = by_solver(&one->scene, form, list, to, error);
        }
        config_free(one);
        return status;
    }
    ad_status status = solve_check(&of, &asked, path, &key, &reason);
    if (status != AD_OK) {
        return ad_fail(error, AD_BAD_INPUT, "%s: %s", key, reason.message);
    }
    solve_report report = solve_report_blank();
    solution *made = NULL;
    solution_path *way = NULL;
    status = solution_create(&of, &asked, moves, moves ? times : NULL, &made, &report, error);
    if (status == AD_OK && !moves) {
        assert_true(report.load_fraction == 1);
    }
    if (status == AD_OK) {
        keep_solution(to, made, &of);
    }
    if (status == AD_OK && path) {
        status = solution_path_create(&of, &asked, &way, error);
        double x[3];
        assert_true(status != AD_OK || way->arrived);
        const double at = status == AD_OK ? way->place : 0;
        assert_int_equal(solution_evaluate(made, 3, 1, &at, NULL, x, error), AD_OK);
        for (int k = 0; k < 3 && status == AD_OK; k++) { /* the path ends in the solution */
            assert_near(way->points[way->count - 1].position[k], x[k], BY_SOLVERS * length);
        }
    }
    solution_path_free(way);
    solution_free(made);
    return status;
}

/* Members of the family, and for the exported C its functions at the curvature of the member. */
static ad_status by_members(const scene *family, bool has_data, support_form form, outcome *to,
                            ad_error *error)
{
    const solve_members_settings asked = {1e-7, 1, PLACES, seen, NULL, false};
    solve_members *members = NULL;
    double values[PLACES * SOLVE_MEMBERS_COLUMNS], usual[SCENE_PARAMETERS_MAX];
    solve_member result;
    scene one;
    scene_middle(family, &one);
    ad_status status = support_check(family, form, NULL, error);
    status = status == AD_OK && has_data ? support_check_data(form, NULL, error) : status;
    status = status != AD_OK ? status : strain_check(&one, form == SUPPORT_EXPORT, error);
    status = status == AD_OK ? solve_members_create(family, &asked, &members, error) : status;
    if (status != AD_OK) {
        return status;
    }
    const size_t nodes = solve_members_nodes(members);
    double *curvature = malloc(5 * nodes * sizeof *curvature), *s = curvature + 3 * nodes,
           *jacobian =
               malloc(PLACES * SOLVE_MEMBERS_COLUMNS * SCENE_PARAMETERS_MAX * sizeof *jacobian);
    scene_middle_values(family, usual);
    solve_members_places(members, s);
    assert_int_equal(solve_members_curvature(members, 1, usual, values, curvature, &result, error),
                     AD_OK);
    assert_true(result.solved);
    to->solved = true;
    for (int i = 0; i < PLACES; i++) {
        memcpy(to->x[i], values + i * SOLVE_MEMBERS_COLUMNS, sizeof to->x[i]);
    }
    if (form == SUPPORT_EXPORT) {
        status = solve_members_jacobian(members, 1, usual, curvature, 0, jacobian, error);
    }
    free(jacobian);
    free(curvature);
    solve_members_free(members);
    return status;
}

static ad_status by_network(const config *made, const settings *list, outcome *to, ad_error *error)
{
    const cpinn_options options = {.threads = 1};
    const scene *of = &made->scene;
    cpinn_model *model = NULL;
    evaluator *look = NULL;
    ad_status status = cpinn_train_file(file, list->count, list->texts, &options, &model, error);
    status = status == AD_OK
                 ? cpinn_evaluator(model, scene_is_beam(of) ? "w" : "x y z", &look, error)
                 : status;
    if (status == AD_OK) {
        double values[3 * PLACES] = {0}, t[PLACES], usual[SCENE_PARAMETERS_MAX][PLACES];
        const double *at[2 + SCENE_PARAMETERS_MAX] = {seen};
        int count = 1;
        for (int i = 0; i < PLACES; i++) {
            t[i] = scene_duration(of);
            for (int k = 0; k < of->parameter_count; k++) {
                usual[k][i] = scene_parameter_at(&of->parameters[k], 0.5);
            }
        }
        if (scene_is_dynamic(of)) {
            at[count++] = t;
        }
        for (int k = 0; k < scene_known_count(of); k++) {
            at[count++] = usual[k];
        }
        assert_int_equal(evaluator_evaluate_at(look, PLACES, at, values, error), AD_OK);
        keep(to, values);
    }
    evaluator_free(look);
    cpinn_free(model);
    return status;
}

static ad_status by_steps(const scene *open, outcome *to, ad_error *error)
{
    enum { STEPS = 30, STATES = 400 };
    const reduced_settings asked = {.modes = {6, 3, 3, 3}, .count = PLACES, .s = seen};
    reduced_rod *rod = NULL;
    double state[STATES], usual[SCENE_PARAMETERS_MAX];
    reduced_place places[PLACES];
    scene_middle_values(open, usual);
    ad_status status = reduced_create(open, &asked, &rod, error);
    if (status != AD_OK) {
        return status;
    }
    assert_true(reduced_states(rod) <= STATES);
    status = reduced_initial(rod, usual, state, error);
    for (int i = 0; i < STEPS && status == AD_OK; i++) {
        status = reduced_step(rod, i * duration / STEPS, duration / STEPS, state, usual, state,
                              NULL, NULL, error);
    }
    status =
        status == AD_OK ? reduced_output(rod, duration, state, usual, places, NULL, error) : status;
    for (int i = 0; i < PLACES && status == AD_OK; i++) {
        to->solved = true;
        memcpy(to->x[i], places[i].position, sizeof to->x[i]);
    }
    reduced_free(rod);
    return status;
}

static const char *const of_networks[] = {"training.stages=[{optimizer: gauss_newton, steps: 100}]",
                                          NULL};
static const char *const of_rest[] = {"network.fourier.features=10", NULL};
static const char *const of_motion[] = {
    "network.fourier={features: 14, wavenumber: 12, frequency: 40}", "losses.interior.points=100",
    "time.windows=1", NULL};

/* A network whose residual is on the tape. */
static bool is_tape(support_form form)
{
    return form == SUPPORT_MIXED || form == SUPPORT_DISPLACEMENT || form == SUPPORT_POSE_STRAIN ||
           form == SUPPORT_MIXED_MOTION || form == SUPPORT_DISPLACEMENT_MOTION ||
           form == SUPPORT_POSE_STRAIN_MOTION;
}

static outcome run(const feature_scene *x, support_form form, bool taken, const char *last)
{
    settings list = {.count = 0};
    outcome to = {.solved = false};
    config *made = NULL;
    ad_error error = {.message = ""};
    const clock_t begun = clock();
    const bool moves = support_form_moves(form);
    if (is_tape(form) && taken) {
        for (int i = 0; of_networks[i]; i++) {
            add(&list, of_networks[i]);
        }
        for (int i = 0; (moves ? of_motion : of_rest)[i]; i++) {
            add(&list, (moves ? of_motion : of_rest)[i]);
        }
    }
    for (int i = 0; moves && in_motion[i]; i++) {
        add(&list, in_motion[i]);
    }
    for (int i = 0; x && i < CHANGES; i++) {
        add(&list, x->changes[i]);
    }
    for (int i = 0; x && moves && i < 3; i++) {
        add(&list, x->moving[i]);
    }
    if (x && is_tape(form) && taken) {
        add(&list, x->on_tape);
    }
    add(&list, last);
    add_form(&list, form, taken);
    ad_status status = prepare_read(file, NULL, list.count, list.texts, &made, &error);
    if (status == AD_OK) {
        status = is_tape(form) || form == SUPPORT_STRAIN_MOTION
                     ? by_network(made, &list, &to, &error)
                 : form == SUPPORT_FAMILY || form == SUPPORT_EXPORT
                     ? by_members(&made->scene, made->settings.data_count > 0, form, &to, &error)
                 : form == SUPPORT_ONE_STEP ? by_steps(&made->scene, &to, &error)
                                            : by_solver(&made->scene, form, &list, &to, &error);
    }
    if (status != AD_OK) {
        refuse(&to, &error);
    }
    config_free(made);
    to.seconds = (double)(clock() - begun) / CLOCKS_PER_SEC;
    return to;
}

static double distance(const outcome *a, const outcome *b)
{
    double most = 0;
    for (int i = 0; i < PLACES; i++) {
        for (int k = 0; k < 3; k++) {
            most = fmax(most, fabs(a->x[i][k] - b->x[i][k]) / length);
        }
    }
    return most;
}

/* The form that others are compared with. */
static support_form trusted_of(int feature, bool moves)
{
    static const support_form of[2][3] = {{SUPPORT_COLLOCATION, SUPPORT_MIXED, SUPPORT_MIXED},
                                          {SUPPORT_NODES, SUPPORT_MODES, SUPPORT_MIXED_MOTION}};
    for (int i = 0; i < 3; i++) {
        if (support_of(feature, of[moves][i]) == SUPPORT_TAKEN ||
            support_of(feature, of[moves][i]) == SUPPORT_WITHOUT_EFFECT) {
            return of[moves][i];
        }
    }
    return SUPPORT_FORMS;
}

/* ---- cells ------------------------------------------------------------------------------------
 */

static void write_text(const char *path, const char *text)
{
    FILE *to = fopen(path, "w");
    assert_non_null(to);
    fputs(text, to);
    fclose(to);
}

/* Positions of the base, as measured. */
static void write_measured(const outcome *of, bool moves)
{
    FILE *to = fopen(measured, "w");
    assert_non_null(to);
    fprintf(to, moves ? "s,t,x,y,z\n" : "s,x,y,z\n");
    for (int i = 0; i < PLACES; i++) {
        fprintf(to, "%.17g,", seen[i]);
        if (moves) {
            fprintf(to, "%.17g,", duration);
        }
        fprintf(to, "%.17g,%.17g,%.17g\n", of->x[i][0], of->x[i][1], of->x[i][2]);
    }
    fclose(to);
}

static bool is_taken(int feature, support_form form)
{
    return support_of(feature, form) == SUPPORT_TAKEN ||
           support_of(feature, form) == SUPPORT_WITHOUT_EFFECT;
}

/* What is wrong with a form that takes the feature, at most so far from the shape that is known. */
static void judge_taken(const feature_scene *x, support_form form, const outcome *known,
                        const char *place)
{
    const outcome got = run(x, form, true, NULL);
    const double off = distance(&got, known);
    const double allowed = is_tape(form)              ? BY_NETWORKS
                           : form == SUPPORT_ONE_STEP ? BY_STEPS
                                                      : BY_SOLVERS;
    print_message("%s %s: off by %.1e, %.2f s\n", place, x->feature, off, got.seconds);
    if (!got.solved || !(off < allowed)) {
        fail_msg("%s takes %s, and is off by %.1e: %s", place, x->feature, off, got.sentence);
    }
}

static bool says(const outcome *got, const char *feature, support_form form)
{
    char sentence[sizeof got->sentence];
    if (!feature || is_taken(support_feature_find(feature), form)) {
        return false;
    }
    support_sentence(support_feature_find(feature), form, sentence, sizeof sentence);
    return strstr(got->sentence, sentence) != NULL;
}

/* Or of what the scene needs beside the feature. */
static void judge_refused(const feature_scene *x, support_form form, const char *place)
{
    const outcome got = run(x, form, false, NULL);
    if (got.solved || verdict_exit_status(&got.verdict) != 2 ||
        !(says(&got, x->feature, form) || says(&got, x->beside, form))) {
        fail_msg("%s has not refused %s, but: %s", place, x->feature, got.sentence);
    }
}

static void judge_feature(const feature_scene *x, bool moves, const outcome *alone)
{
    const int feature = support_feature_find(x->feature);
    const support_form trusted = trusted_of(feature, moves);
    outcome known = {.solved = false};
    assert_true(feature >= 0);
    if (trusted < SUPPORT_FORMS) {
        known = run(x, trusted, true, NULL);
        if (!known.solved) {
            fail_msg("%s: %s", x->feature, known.sentence);
        }
        const bool knows = !WATCHED || !x->without; /* what is without the feature */
        const outcome without = !knows       ? known
                                : x->without ? run(x, trusted, true, x->without)
                                             : *alone;
        const double moved = distance(&known, &without);
        print_message("%s moves the rod by %.1e\n", x->feature, moved);
        if (support_of(feature, trusted) == SUPPORT_WITHOUT_EFFECT) {
            assert_true(moved == 0);
        } else if (knows && !x->is_silent && !(moved > MOVED)) {
            fail_msg("%s moves the rod by %.1e only", x->feature, moved);
        }
    }
    for (int k = 0; k < SUPPORT_FORMS; k++) {
        const support_form form = (support_form)k;
        char place[100];
        snprintf(place, sizeof place, "%s, %s:", support_form_name(form),
                 moves ? "in motion" : "at rest");
        if (support_form_moves(form) == moves && form != trusted) {
            if (!is_taken(feature, form)) {
                judge_refused(x, form, place);
            } else if (!WATCHED || (feature + k) % 4 == 0) { /* each form with some features */
                judge_taken(x, form, &known, place);
            }
        }
    }
}

static void judge_all(bool moves, const char *feature)
{
    const outcome alone = run(NULL, moves ? SUPPORT_NODES : SUPPORT_COLLOCATION, true, NULL);
    assert_true(alone.solved);
    write_measured(&alone, moves);
    for (int i = 0; i < SCENES; i++) {
        if (!feature || strcmp(feature, scenes[i].feature) == 0) {
            judge_feature(&scenes[i], moves, &alone);
        }
    }
}

/* ---- tests ------------------------------------------------------------------------------------
 */

static const char *chosen; /* feature */

static int begin(void **state)
{
    char law[20000];
    FILE *from = fopen("configs/law/neo_hooke.csv", "r");
    if (make_directory(state) != 0 || !from) {
        return -1;
    }
    law[fread(law, 1, sizeof law - 1, from)] = '\0';
    fclose(from);
    snprintf(file, sizeof file, "%s", at("scene.yaml"));
    snprintf(measured, sizeof measured, "%s", at("measured.csv"));
    write_text(file, base);
    write_text(at("law.csv"), law);
    return 0;
}

static void test_rest(void **state)
{
    (void)state;
    judge_all(false, chosen);
}

static void test_motion(void **state)
{
    (void)state;
    judge_all(true, chosen);
}

/* Each feature has a scene, and is found in it; a row that no form takes has one reason. */
static void test_features(void **state)
{
    (void)state;
    assert_int_equal(SCENES, support_feature_count());
    for (int i = 0; i < SCENES; i++) {
        const int feature = support_feature_find(scenes[i].feature);
        assert_true(feature >= 0);
        for (int moves = 0; moves < 2; moves++) {
            int taken = 0, never = 0, count = 0;
            for (int k = 0; k < SUPPORT_FORMS; k++) {
                const support_answer answer = support_of(feature, (support_form)k);
                if (support_form_moves((support_form)k) == moves) {
                    count++;
                    taken += is_taken(feature, (support_form)k);
                    never += answer == SUPPORT_IMPOSSIBLE;
                    assert_true(answer != SUPPORT_IMPOSSIBLE ||
                                support_feature_reason(feature, moves));
                }
            }
            assert_true(taken > 0 || never == 0 || never == count);
        }
    }
    assert_int_equal(support_feature_find("a feature that is not there"), -1);
}

int main(int count, char **arguments)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_features), cmocka_unit_test(test_rest),
                                       cmocka_unit_test(test_motion)};
    chosen = count > 1 ? arguments[1] : NULL;
    return cmocka_run_group_tests(tests, begin, remove_directory);
}
