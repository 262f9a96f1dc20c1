/* Rods that vary along their length and gravity that varies in time, trained and solved
 * classically, against closed forms. */
#include "trainer_testing.h"

#include "config_testing.h"
#include "physics/solve/solve.h"

enum { POINTS = 41, POSE = 7 };

typedef struct pose {
    double s, t, r[3], q[4];
} pose;

/* Columns as reference files have them. */
static void write_poses(const char *path, const pose *poses, int count)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("s,t,x,y,z,qw,qx,qy,qz\n", file);
    for (int i = 0; i < count; i++) {
        const pose *p = &poses[i];
        fprintf(file, "%.17g,%.17g", p->s, p->t);
        for (int k = 0; k < POSE; k++) {
            fprintf(file, ",%.17g", k < 3 ? p->r[k] : p->q[k - 3]);
        }
        fputc('\n', file);
    }
    fclose(file);
}

/* By the default recipe, against the poses, or (NULL) against the classical solver. */
static double trained_error(const char *text, int count, const char *const *changes,
                            const char *file)
{
    char reference[200];
    const char *all[8];
    ad_error error = {AD_OK, ""};
    reference_errors errors;
    run r = {.made = {NULL, NULL}};
    snprintf(reference, sizeof reference, "reference=%s%s%s", file ? "{file: " : "",
             file ? file : "solve", file ? "}" : "");
    for (int i = 0; i < count; i++) {
        all[i] = changes[i];
    }
    all[count] = reference;
    config *settings = read_text(text, count + 1, all);
    if (config_experiment_create(settings, 1, &r.made.e, &error) != AD_OK ||
        experiment_problem(r.made.e, &r.made.p, &error) != AD_OK ||
        reference_create(r.made.e, &r.known, &error) != AD_OK ||
        trainer_create(r.made.e, r.made.p, r.known, 0, &r.trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    finish(&r);
    if (reference_compare(r.known, r.made.e->parameters, &errors, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    stop(&r);
    return errors.position;
}

/* Largest distance over the length. */
static double solved_error(const char *text, double tolerance, const pose *poses, int count)
{
    ad_error error = {AD_OK, ""};
    solve_settings settings = {.tolerance = tolerance};
    solve_report report;
    solution *solved = NULL;
    config *read = read_text(text, 0, NULL);
    bool moves = scene_is_dynamic(&read->scene);
    double s[POINTS], t[POINTS], values[3 * POINTS], worst = 0;
    for (int i = 0; i < count; i++) {
        s[i] = poses[i].s;
        t[i] = poses[i].t;
    }
    if (solution_create(&read->scene, &settings, moves ? (size_t)count : 0, moves ? t : NULL,
                        &solved, &report, &error) != AD_OK ||
        solution_evaluate(solved, 3, (size_t)count, s, t, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (int i = 0; i < count; i++) {
        double square = 0;
        for (int k = 0; k < 3; k++) {
            square += pow(values[k * count + i] - poses[i].r[k], 2);
        }
        worst = fmax(worst, sqrt(square) / scene_length(&read->scene));
    }
    solution_free(solved);
    config_free(read);
    return worst;
}

/* ---- at rest --------------------------------------------------------------------------------- */

/* A moment M at the tip bends a clamped rod to the curvature M/EI(s) exactly. EI = 2 - s, about
 * both axes: the tangent turns by theta = -M ln(1 - s/2), and the position is its integral, here by
 * Simpson's rule, whose error at this step is below 1e-14. */
static void bent_poses(double moment, pose *poses)
{
    enum { PIECES = 200 };
    double x = 0, z = 0;
    for (int i = 0; i < POINTS; i++) {
        double s = (double)i / (POINTS - 1), angle = -moment * log(1 - s / 2);
        for (int k = 0; k < PIECES && i > 0; k++) {
            double h = 1.0 / (POINTS - 1) / PIECES, from = s - 1.0 / (POINTS - 1) + k * h;
            for (int j = 0; j < 3; j++) {
                double theta = -moment * log(1 - (from + j * h / 2) / 2);
                x += (j == 1 ? 4 : 1) * h / 6 * sin(theta);
                z += (j == 1 ? 4 : 1) * h / 6 * cos(theta);
            }
        }
        poses[i] = (pose){s, 0, {x, 0, z}, {cos(angle / 2), 0, sin(angle / 2), 0}};
    }
}

static void test_tip_moment(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {bending: 2 - s, couple: 1.5}\n"
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [500, 500], axial: 1000*(2 - s), bending: [bending, bending],\n"
        "              torsion: 0.7*bending}\n"
        "loads: {tip: {moment: [0, couple, 0]}}\n";
    pose poses[POINTS];
    bent_poses(1.5, poses);
    write_poses(in_folder("bent.csv"), poses, POINTS);
    double solved = solved_error(text, 1e-12, poses, POINTS);
    print_message("solved: %.1e\n", solved);
    assert_true(solved < 1e-12);
    static const char *const changes[] = {"motion=planar", "motion=spatial"};
    for (int i = 0; i < 2; i++) {
        double error = trained_error(text, 1, &changes[i], in_folder("bent.csv"));
        print_message("%s: %.1e\n", changes[i], error);
        assert_true(error < 1e-10); /* measured: 1e-13 to 1e-12 */
    }
    assert_int_equal(remove(in_folder("bent.csv")), 0);
}

/* ---- in motion ------------------------------------------------------------------------------- */

/* A free rod under gravity g(t) = -9 cos(3 t) falls as it is, tapered or not: z = s + cos(3t) - 1,
 * with a rest shape that stays. */
static void test_fall(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  section: {shape: circle, radius: 0.06 - 0.03*s}\n"
        "  material: {youngs_modulus: 1e5, poissons_ratio: 0.3, density: 30*(1 + s),\n"
        "             relaxation_time: 0.01}\n"
        "boundary: {start: {type: free}, end: {type: free}}\n"
        "loads: {gravity: [0, 0, -9*cos(3*t)]}\n"
        "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0]}\n"
        "time: {duration: 0.15, windows: 1}\n";
    pose poses[POINTS];
    for (int i = 0; i < POINTS; i++) {
        double s = (i * 7 % POINTS) / (POINTS - 1.0), t = 0.15 * i / (POINTS - 1);
        poses[i] = (pose){s, t, {0, 0, s + cos(3 * t) - 1}, {1, 0, 0, 0}};
    }
    write_poses(in_folder("fall.csv"), poses, POINTS);
    double solved = solved_error(text, 1e-8, poses, POINTS);
    double trained = trained_error(text, 0, NULL, in_folder("fall.csv"));
    print_message("solved: %.1e, trained: %.1e\n", solved, trained);
    assert_true(solved < 1e-8);
    assert_true(trained < 1e-9); /* measured: 1e-12 */
    assert_int_equal(remove(in_folder("fall.csv")), 0);
}

/* A tapered rod that curls by itself and is pulled by gravity that grows, damped by its material:
 * network and classical solver, which share the coefficients of the equations and nothing else of
 * them, find the same motion. The solver's estimate is 1e-8 of the length. */
static void test_curling(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {thick: 0.02, thin: 0.012, eta: 300}\n"
        "rod:\n"
        "  length: 0.3\n"
        "  section: {shape: circle, radius: thick + (thin - thick)*s/0.3}\n"
        "  material: {youngs_modulus: 1e5*(2 - s), poissons_ratio: 0.45, density: 1070,\n"
        "             viscosity: eta}\n"
        "  rest: {curvature: [0, 100*s*t^2, 0]}\n"
        "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}\n"
        "loads: {gravity: [0, 0, -300*t^2]}\n"
        "time: {duration: 0.15, windows: 1}\n";
    double error = trained_error(text, 0, NULL, NULL);
    print_message("trained against solved: %.1e\n", error);
    assert_true(error < 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_tip_moment),
                                       cmocka_unit_test(test_fall), cmocka_unit_test(test_curling)};
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
