/* Families as C: what is written compiles without a warning, and says what the solver of members
 * makes of the same curvature.
 *   test_export_family [TEST]      writes, compiles and compares in a folder of its own */
#include "config_testing.h"
#include "fewer.h"
#include "good.h"
#include "random_numbers.h"
#include "temporary_folder.h"

#include "nn/nn.h"
#include "physics/chain/solve_members.h"
#include "tools/emit/export_family.h"

#include <math.h>
#include <string.h>

enum { PARAMETERS = 3, MEMBERS = 6, PLACES = 21, NODES_MAX = 48, WIDTH_MAX = 3 + SCENE_TUBES_MAX };

/* Loads of half a turn; of the first all are dead, of the second not. */
#define PULLED                                                                                     \
    "parameters: {pull: {range: [0, 1]}, push: {range: [-0.05, 0.05]},\n"                          \
    "             stiff: {range: [0.5, 2], scale: log}}\n"
static const char plain[] = PULLED
    "rod: {model: cosserat, length: 0.2, section: {shape: circle, radius: 0.0005},\n"
    "      material: {youngs_modulus: 60e9*stiff, poissons_ratio: 0.3, density: 6450}}\n"
    "boundary: {end: {type: loaded}}\n"
    "loads: {gravity: [0, 9.81, 0], tip: {force: [push, 0.02, 0]}}\n"
    "tendons: [{offset: [0.008, 0], tension: pull}, {offset: [-0.004, 0.0069], tension: 0.2}]\n";
static const char robot[] =
    PULLED "rod: {model: cosserat, section: {shape: circle, radius: 0.002},\n"
           "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000}}\n"
           "segments: [{length: 0.1+push/2}, {length: 0.15, turn: [0, 0.3, 0]}]\n"
           "boundary: {start: {position: [push, 0, 0.1*pull], rotation: [1, 0, pull/5, push]},\n"
           "           end: {type: loaded}}\n"
           "loads:\n"
           "  gravity: [0, 4, -8]\n"
           "  tip: {force: [0.02, push, 0], moment: [0.003, 0, 0.001*pull], frame: follower}\n"
           "  magnetic: {moment: [0, 0.2, 1], field: [0.02*push, 0.01, 0]}\n"
           "tendons: [{offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], tension: pull}]\n";

static const char many[] =
    PULLED "rod: {model: cosserat, length: 0.2, section: {shape: circle, radius: 0.0008},\n"
           "      material: {youngs_modulus: 60e9*stiff, poissons_ratio: 0.3, density: 6450}}\n"
           "boundary: {end: {type: loaded}}\n"
           "loads: {gravity: [0, 0, -9.81], tip: {force: [0, 0, push]}}\n"
           "tendons:\n"
           "  - {offset: [0.008, 0], tension: pull}\n"
           "  - {offset: [-0.004, 0.0069], tension: 2*pull}\n"
           "  - {offset: [-0.004, -0.0069], tension: 3*pull}\n"
           "  - {offset: [0.004, 0.0069], tension: pull, end: 0.1}\n"
           "  - {offset: [-0.008, 0], tension: 2*pull, end: 0.1}\n"
           "  - {offset: [0.004, -0.0069], tension: 3*pull, end: 0.1}\n";

/* A rod that does not shear, with a chamber alone. */
static const char chamber[] =
    PULLED "rod: {model: kirchhoff, length: 0.2, section: {shape: circle, radius: 0.002},\n"
           "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000}}\n"
           "boundary: {end: {type: loaded}}\n"
           "loads: {gravity: [0, 0, -9.81], tip: {force: [push, 0, 0]}}\n"
           "chambers: [{offset: [0, 0.005], pressure: 5e4*pull, area: 1e-5}]\n";

/* On a foundation along a part, with springs that pull to a place, and one that turns; magnetised,
 * with a magnet at the tip, in a field with a gradient. */
static const char supported[] = PULLED
    "rod: {model: cosserat, section: {shape: circle, radius: 0.002},\n"
    "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000}}\n"
    "segments: [{length: 0.1}, {length: 0.15, turn: [0, 0.3, 0]}]\n"
    "boundary: {end: {type: loaded}}\n"
    "loads:\n"
    "  gravity: [0, 4, -8]\n"
    "  foundation: [\"where(0.1-s, 3*stiff, 0)\", 2, 0]\n"
    "  tip: {force: [0.02, push, 0]}\n"
    "  magnetic: {moment: [0, 0.02, 0.1], gradient: [0.1, -0.2, 0.1*push, 0.05, 0.1]}\n"
    "bodies: [{at: 0.25, mass: 0, magnetic_moment: [0, 0.002, 0.01]}]\n"
    "springs: [{at: 0.1, stiffness: [1+pull/5, 2, 0.5]}, {at: 0.1, turning: [0.01, "
    "0.02+0.002*pull, "
    "0.01]},\n"
    "  {at: 0.25, stiffness: [2, 2, 1], turning: [0.005, 0, 0.01], anchor: [0.02, push/5, 0.2]}]\n"
    "tendons: [{offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], tension: pull}]\n";

/* A rod whose law is learned: it bends, stretches and shears beyond what is linear. */
static const char lawful[] =
    PULLED "rod: {model: cosserat, length: 0.2, section: {shape: circle, radius: 0.01},\n"
           "      material: {density: 1000*stiff}, law: {file: configs/law/neo_hooke.csv}}\n"
           "boundary: {end: {type: loaded}}\n"
           "loads: {gravity: [0, 0.5, 0], tip: {force: [push, 0.03, 0]}}\n"
           "tendons: [{offset: [0.008, 0], tension: pull}]\n";

/* A hoop, between a clamp and an end that is held, near where it is without loads. */
#define BETWEEN(end)                                                                               \
    PULLED                                                                                         \
    "rod: {model: cosserat, length: 0.25, section: {shape: circle, radius: 0.002},\n"              \
    "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000},\n"           \
    "      rest: {curvature: [6, 0, 0]}}\n"                                                        \
    "boundary: {end: {" end "}}\n"                                                                 \
    "loads: {gravity: [0, 4, -8], force: [0, \"2*push\", 0]}\n"                                    \
    "tendons: [{offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], tension: pull}]\n"
static const char held[] =
    BETWEEN("type: clamped, position: [0.005, -0.15, 0.168], rotation: [0.73, 0.68, 0.02, 0.01]");
static const char sliding[] = BETWEEN("type: roller, position: [0.005, -0.15, 0.168], along: [0, "
                                      "1, 1]") "springs: [{at: 0.1, stiffness: [1, 2, 0.5]}]\n";
static const char pinned[] = BETWEEN("type: pinned, position: [0.01, -0.148, 0.17]");

/* By the length of tendons, of which the second is elastic and slack where `push` is negative. */
static const char displaced[] =
    PULLED "rod: {model: cosserat, section: {shape: circle, radius: 0.002},\n"
           "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000}}\n"
           "segments: [{length: 0.1}, {length: 0.15, turn: [0, 0.3, 0]}]\n"
           "boundary: {end: {type: loaded}}\n"
           "loads: {gravity: [0, 4, -8], tip: {force: [0.02, push, 0]}}\n"
           "tendons:\n"
           "  - {offset: [0.006, 0], end: 0.2, displacement: 0.004*pull}\n"
           "  - {offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], displacement: 0.06*push,\n"
           "     stiffness: 3000*stiff}\n";

/* Of a rod that does not stretch a tendon is let go by just what it becomes longer by. */
static const char opposed[] =
    PULLED "rod: {model: kirchhoff, length: 0.2, section: {shape: circle, radius: 0.002},\n"
           "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000}}\n"
           "boundary: {end: {type: loaded}}\n"
           "loads: {tip: {force: [push, 0, 0]}}\n"
           "tendons: [{offset: [0.006, 0], displacement: 0.004*pull},\n"
           "          {offset: [-0.006, 0], displacement: -0.004*pull}]\n";

/* With friction of tendons, of which the second begins to wind within the rod. */
#define RUBBED(first)                                                                              \
    PULLED "rod: {model: cosserat, length: 0.25, section: {shape: circle, radius: 0.002},\n"       \
           "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000},\n"    \
           "      rest: {curvature: [0, 3, 1]}}\n"                                                 \
           "boundary: {end: {type: loaded}}\n"                                                     \
           "loads: {gravity: [0, 4, -8], tip: {force: [0.02, push, 0]}}\n"                         \
           "tendons:\n"                                                                            \
           "  - {offset: [0.006, 0], end: 0.15, " first "}\n"                                      \
           "  - {offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], start: 0.15, tension: 0.7,\n" \
           "     friction: 0.3}\n"
static const char rubbed[] = RUBBED("tension: pull, friction: 0.5*stiff");

/* The first by its length. */
static const char rubbed_by_length[] =
    RUBBED("displacement: 0.0005*pull, stiffness: 3000, friction: 0.5*stiff");

/* With concentric tubes that bend and twist one another: the first also before s = 0, the second on
 * a part; on a tendon. */
static const char tubular[] =
    PULLED "rod: {model: kirchhoff, length: 0.25, section: {shape: circle, radius: 0.002},\n"
           "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000},\n"
           "      rest: {curvature: [\"1+3*s\", 0.5, 0.5]}}\n"
           "boundary: {end: {type: loaded}}\n"
           "loads: {gravity: [0, 1, -2], tip: {force: [0.005, push/4, 0]}}\n"
           "tendons: [{offset: [0.006, 0], tension: pull/2}]\n"
           "tubes:\n"
           "  - {section: {radius: 0.003, inner_radius: 0.0025}, end: 0.2, turned: 0.5+pull/2,\n"
           "     material: {youngs_modulus: 8e8, poissons_ratio: 0.3, density: 2000},\n"
           "     rest: {curvature: [\"2-2*s\", 0.5, 0]}, transmission: 0.1*stiff}\n"
           "  - {section: {radius: 0.004, inner_radius: 0.0035}, end: 0.1, turned: 10*push,\n"
           "     material: {youngs_modulus: 8e8, poissons_ratio: 0.3, density: 2000},\n"
           "     rest: {curvature: [\"stiff\", 0.5, 0]}}\n";

/* A network with random weights, which says little: Newton's method starts near the unloaded rod.
 */
typedef struct network {
    nn_mlp *mlp;
    double weights[2000];
    int outputs, width;
    double bend; /* u1 times the length, of the rod without loads */
} network;

static ad_value record(const void *context, ad_tape *tape, const ad_value *x)
{
    const network *n = context;
    ad_value input = ad_sub(ad_scale(ad_stack(PARAMETERS, x), 2), ad_scalar(tape, 1));
    double rest[WIDTH_MAX * NODES_MAX] = {0};
    for (int i = 0; i < n->outputs / n->width; i++) {
        rest[i] = n->bend;
    }
    return ad_add(nn_mlp_record(n->mlp, input, 0), ad_constant(tape, n->outputs, rest));
}

static network make_network(int nodes, int width, double bend)
{
    const int outputs = width * nodes;
    network n = {.outputs = outputs, .width = width, .bend = bend};
    nn_mlp_settings settings = nn_mlp_settings_default();
    nn_rng random = nn_rng_seed(5);
    ad_error error = {.message = ""};
    settings.inputs = PARAMETERS;
    settings.outputs = outputs;
    settings.hidden_count = 2;
    settings.hidden[0] = settings.hidden[1] = 8;
    assert_good(nn_mlp_create(&settings, &random, &n.mlp, &error), &error);
    assert_true(nn_mlp_parameters(n.mlp) <= sizeof n.weights / sizeof *n.weights);
    nn_mlp_initialize(n.mlp, &random, n.weights);
    for (size_t i = 0; i < nn_mlp_parameters(n.mlp); i++) {
        n.weights[i] *= 0.7;
    }
    return n;
}

/* ---- what the solver says ------------------------------------------------------------------ */

static void put(FILE *file, size_t count, const double *list, double unit)
{
    for (size_t i = 0; i < count; i++) {
        fprintf(file, "%.17g\n", list[i] * unit);
    }
}

/* [width][nodes] times the length as [nodes][width] in 1/m. */
static void said(const network *n, const scene *family, int nodes, const double *parameters,
                 double *curvature)
{
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(1);
    ad_value p[PARAMETERS];
    double x[PARAMETERS], out[WIDTH_MAX * NODES_MAX];
    ad_program *program;
    ad_error error = {.message = ""};
    const double *inputs[PARAMETERS];
    for (int i = 0; i < PARAMETERS; i++) {
        p[i] = ad_input(tape, "p", 1);
        x[i] = scene_parameter_fraction(&family->parameters[i], parameters[i]);
        inputs[i] = &x[i];
    }
    ad_value y = record(n, tape, p);
    const ad_settings settings = ad_settings_default();
    assert_good(ad_compile(1, &y, &settings, pool, &program, &error), &error);
    const ad_run run = {
        .points = 1, .inputs = inputs, .parameters = n->weights, .outputs = (double *[]){out}};
    assert_good(ad_execute(program, &run, &error), &error);
    for (int i = 0; i < n->outputs; i++) {
        curvature[i] = out[i % n->width * nodes + i / n->width] / scene_length(family);
    }
    ad_program_free(program);
    ad_pool_free(pool);
    ad_tape_free(tape);
}

/* Of each member its parameters, float numbers where `single`, and for 0, 1, 2, 5 steps curvature,
 * shape and distances. */
static void write_members(solve_members *x, const scene *family, const network *n, bool single,
                          FILE *file)
{
    const size_t nodes = solve_members_nodes(x);
    uint64_t random = 2;
    for (int m = 0; m < MEMBERS; m++) {
        double p[PARAMETERS], given[WIDTH_MAX * NODES_MAX], refined[WIDTH_MAX * NODES_MAX];
        double values[PLACES * SOLVE_MEMBERS_COLUMNS];
        for (int i = 0; i < PARAMETERS; i++) {
            p[i] = scene_parameter_at(&family->parameters[i], random_in(&random, 0, 1));
            p[i] = single ? (double)(float)p[i] : p[i];
        }
        said(n, family, (int)nodes, p, given);
        put(file, PARAMETERS, p, 1);
        for (int steps = 0; steps <= 5; steps += steps < 2 ? 1 : 3) {
            solve_answer answer;
            ad_error error = {.message = ""};
            assert_good(
                solve_members_refine(x, 1, p, given, steps, values, refined, &answer, &error),
                &error);
            put(file, solve_members_numbers(x), refined, scene_length(family));
            put(file, PLACES * SOLVE_MEMBERS_COLUMNS, values, 1);
            fprintf(file, "%.17g\n%.17g\n", answer.predicted, answer.left);
        }
    }
}

/* ---- the C --------------------------------------------------------------------------------- */

/* Where the tests are under sanitizers, what writes the C is watched. The C itself is the same as
 * elsewhere, and has sanitizers of its own there. */
static void run_command(const char *command)
{
#ifdef CPINN_SANITIZED
    (void)command;
#else
    if (system(command) != 0) {
        fail_msg("%s", command);
    }
#endif
}

static bool has_compiler(const char *name)
{
    char command[100];
    snprintf(command, sizeof command, "%s --version >/dev/null 2>&1", name);
    return system(command) == 0;
}

static void write_c(export_family *x)
{
    ad_error error = {.message = ""};
    FILE *file = fopen(at("arm.c"), "w");
    assert_non_null(file);
    assert_good(export_family_write(x, EXPORT_SOURCE, file, &error), &error);
    fclose(file);
    file = fopen(at("arm.h"), "w");
    assert_non_null(file);
    assert_good(export_family_write(x, EXPORT_HEADER, file, &error), &error);
    fclose(file);
}

/* By all compilers that are there, without a warning; what is to be float is nowhere double. */
static void compile_all(bool single)
{
    static const char *const compilers[] = {"gcc -std=c99", "clang -std=c99", "g++ -x c++",
                                            "clang++ -x c++"};
    for (size_t i = 0; i < (single ? 2 : 4); i++) {
        char command[500], name[10];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(compilers[i], " "), compilers[i]);
        if (has_compiler(name)) {
            snprintf(command, sizeof command,
                     "cd %s && %s -Wall -Wextra -Wpedantic %s -Werror -c arm.c -o arm.o", directory,
                     compilers[i], single ? "-Wdouble-promotion -Wfloat-conversion" : "");
            run_command(command);
        }
    }
}

/* The compiler with the sanitizers, and with indices that nobody has set as wild ones: clang takes
 * a third of the time of gcc, and a half without what is watched twice (CMakeLists.txt). */
static const char *watching(void)
{
    static const char *const ways[] = {"clang -fsanitize=address,undefined "
                                       "-ftrivial-auto-var-init=pattern",
                                       "cc -fsanitize=address,undefined "
                                       "-ftrivial-auto-var-init=pattern",
                                       "cc -fsanitize=address,undefined"};
    static size_t which = 3;
    for (size_t i = 0; i < 3 && which == 3; i++) {
        char command[300];
        snprintf(command, sizeof command,
                 "echo 'int main(void) { return 0; }' | %s -x c - -o %s/tried >/dev/null 2>&1",
                 ways[i], directory);
        which = system(command) == 0 ? i : which;
    }
    assert_true(which < 3);
    return ways[which];
}

/* Every function with what is not expected. */
static void fuzz(const char *type, int rounds)
{
    char command[700];
    snprintf(command, sizeof command,
             "%s -std=c11 -fno-sanitize=pointer-overflow,null,object-size "
             "-fno-sanitize-recover=undefined "
             "-DHEADER='\"arm.h\"' -DNAME=arm -DNUMBER=%s -DROUNDS=%d -I%s -o %s/fuzz "
             "tests/export_family_fuzz.c %s/arm.c -lm && %s/fuzz",
             watching(), type, rounds, directory, directory, directory, directory);
    run_command(command);
}

/* By all compilers that are there, or by the quickest of them. */
static void compare(const char *type, bool shape_by, bool by_all, int sought, bool lawful)
{
    static const char *const compilers[] = {"clang", "gcc"};
    bool done = false;
    for (size_t i = 0; i < 2 && (by_all || !done); i++) {
        char command[600];
        snprintf(
            command, sizeof command,
            "%s -std=c99 -DHEADER='\"arm.h\"' -DNAME=arm -DNUMBER=%s -DSOUGHT=%d -DBETWEEN=%g %s "
            "-I%s -o "
            "%s/compare "
            "tests/export_family_compare.c %s/arm.c -lm && %s/compare %s/members.txt",
            compilers[i], type, sought, lawful ? 2e-4 : 0, shape_by ? "-DSHAPE_BY" : "", directory,
            directory, directory, directory, directory);
        if (has_compiler(compilers[i])) {
            run_command(command);
            done = true;
        }
    }
}

static void set_columns(export_family *x, int first)
{
    for (int i = 0; i < x->columns; i++) {
        x->which[i] = i + (first < 0 ? 0 : first);
    }
}

/* `column`: of the shape alone; -1: all. */
static void check_family(const char *text, bool single, int column)
{
    const char *type = single ? "float" : "double";
    const double unmeasured = NAN;
    config *given = read_text(text, 0, NULL);
    scene one;
    double s[PLACES], places[PLACES], points[NODES_MAX];
    solve_members *members = NULL;
    ad_error error = {.message = ""};
    scene_middle(&given->scene, &one);
    for (int i = 0; i < PLACES; i++) {
        places[i] = (double)i / (PLACES - 1);
        s[i] = places[i] * scene_length(&one);
    }
    const solve_members_settings settings = {
        .tolerance = 1e-6, .threads = 1, .points = PLACES, .s = s};
    assert_good(solve_members_create(&given->scene, &settings, &members, &error), &error);
    const int nodes = (int)solve_members_nodes(members);
    assert_true(nodes <= NODES_MAX);
    solve_members_places(members, points);
    for (int i = 0; i < nodes; i++) {
        points[i] /= scene_length(&one);
    }
    network n = make_network(nodes, (int)solve_members_width(members),
                             text == held || text == sliding || text == pinned ? 1.5 : 0);
    export_family x = {
        .name = "arm",
        .about = "a test",
        .tip = true,
        .shape_by = column < 0 &&
                    (single ? text == plain : text == robot || text == held || text == tubular),
        .open = &given->scene,
        .single = single,
        .columns = column < 0 ? strain_columns(&given->scene) : 1,
        .values = &unmeasured,
        .places = PLACES,
        .s = places,
        .network = record,
        .context = &n,
        .weights = n.weights};
    set_columns(&x, column);
    assert_good(strain_mesh_at(&one, nodes, points, &x.mesh, &error), &error);
    write_c(&x);
    if (text == plain && column < 0) {
        compile_all(single);
    }
    FILE *file = fopen(at("members.txt"), "w");
    assert_non_null(file);
    write_members(members, &given->scene, &n, single, file);
    fclose(file);
    compare(type, x.shape_by, single && (text == plain || column >= 0),
            x.held + strain_angles(x.open) + x.tubes > 0 ? 2 : x.forces > 0, text == lawful);
    if (column < 0 && (single ? text == chamber : text != lawful && text != sliding)) {
        fuzz(type, x.forces + x.held + x.tubes > 0 ? 10 : 300); /* matrices column by column */
    }
    nn_mlp_free(n.mlp);
    solve_members_free(members);
    config_free(given);
}

static void test_dead(void **state)
{
    (void)state;
    check_family(plain, false, -1);
}

static void test_chamber(void **state)
{
    (void)state;
    check_family(chamber, false, -1);
}

static void test_followers(void **state)
{
    (void)state;
    check_family(robot, false, -1);
}

static void test_supported(void **state)
{
    (void)state;
    check_family(supported, false, -1);
}

static void test_law(void **state)
{
    (void)state;
    check_family(lawful, false, -1);
}

static void test_held(void **state)
{
    (void)state;
    check_family(held, false, -1);
}

static void test_sliding(void **state)
{
    (void)state;
    check_family(sliding, false, -1);
}

static void test_pinned(void **state)
{
    (void)state;
    check_family(pinned, false, -1);
    check_family(pinned, true, -1);
}

static void test_tubes(void **state)
{
    (void)state;
    check_family(tubular, false, -1);
    check_family(tubular, true, -1);
}

static void test_displaced(void **state)
{
    (void)state;
    check_family(displaced, false, -1);
    check_family(opposed, false, -1);
}

static void test_rubbed(void **state)
{
    (void)state;
    check_family(rubbed, false, -1);
    check_family(rubbed, true, -1);
    check_family(rubbed_by_length, false, -1);
}

static void test_single(void **state)
{
    (void)state;
    check_family(plain, true, -1);
    check_family(chamber, true, -1);
}

static void test_columns(void **state)
{
    (void)state;
    check_family(plain, false, 2);
    check_family(robot, true, 12);
}

static size_t size_of(export_family *x)
{
    char *text = NULL;
    size_t size = 0;
    ad_error error = {.message = ""};
    FILE *file = open_memstream(&text, &size);
    assert_non_null(file);
    assert_good(export_family_write(x, EXPORT_SOURCE, file, &error), &error);
    fclose(file);
    free(text);
    return size;
}

/* Tendons that end on the way keep the points of the mesh together, in loops, and the state of the
 * rod stands there once: 0.72 MB here. Point by point it was 3.05 MB, which compilers take minutes
 * for; with a state in every function 1.37 MB. */
static void test_size(void **state)
{
    (void)state;
    const double end = 1;
    config *given = read_text(many, 0, NULL);
    scene one;
    ad_error error = {.message = ""};
    network n = make_network(12, 3, 0);
    export_family x = {.name = "arm",
                       .about = "a test",
                       .tip = true,
                       .open = &given->scene,
                       .columns = STRAIN_COLUMNS,
                       .places = 1,
                       .s = &end,
                       .network = record,
                       .context = &n,
                       .weights = n.weights};
    scene_middle(&given->scene, &one);
    assert_good(strain_mesh_of(&one, 6, &x.mesh, &error), &error);
    assert_int_equal(strain_mesh_nodes(&x.mesh), 12);
    set_columns(&x, -1);
    const size_t all = size_of(&x);
    printf("%zu bytes of C\n", all);
    assert_true(all < 750000);
    x.columns = 3; /* positions: forces are not brought to places, nor moments, strains */
    const size_t less = size_of(&x);
    x.single = true;
    assert_true(less < all);
    assert_true(size_of(&x) < less);
    nn_mlp_free(n.mlp);
    config_free(given);
}

int main(int count, char **arguments)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_chamber, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_followers, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_supported, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_law, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_held, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_sliding, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_tubes, make_directory, remove_directory),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_size),
        cmocka_unit_test_setup_teardown(test_rubbed, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_dead, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_single, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_columns, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_displaced, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_pinned, make_directory, remove_directory)};
    cmocka_set_test_filter(count > 1 ? arguments[1] : NULL);
    return has_compiler("cc") ? run_with_alike(tests, alike, NULL, NULL) : 77;
}
