/* Robots with tendons, chambers and tubes by networks, against references of another kind. */
#include "fewer.h"
#include "trainer_testing.h"

/* Relative error of positions against the reference that the scene names; text: NULL for that of
 * the file. */
static double trained_error_of(const char *path, const char *text, const char *change)
{
    ad_error error = {AD_OK, ""};
    run r = {.made = {experiment_of(path, text, change), NULL}};
    if (experiment_problem(r.made.e, &r.made.p, &error) != AD_OK ||
        reference_create(r.made.e, &r.known, &error) != AD_OK ||
        trainer_create(r.made.e, r.made.p, r.known, 0, &r.trainer, &error) != AD_OK) {
        fail_msg("%s: %s", path, error.message);
    }
    finish(&r);
    double result = trainer_inspect(r.trainer)->errors.position;
    print_message("%s: %.1e\n", path, result);
    stop(&r);
    return result;
}

static double trained_error(const char *path, const char *change)
{
    return trained_error_of(path, NULL, change);
}

static void test_robots(void **state)
{
    (void)state;
    static const struct {
        const char *path, *change;
        double tolerance; /* some times what is measured */
    } rows[] = {{"configs/robots/tendon_one_segment.yaml", NULL, 1e-11},      /* 2e-13 */
                {"configs/robots/tendon_two_segments.yaml", NULL, 1e-10},     /* 4e-12 */
                {"configs/robots/soft_arm_three_chambers.yaml", NULL, 1e-11}, /* 1e-13 */
                {"configs/robots/soft_arm_three_chambers.yaml", "enforcement.boundary=soft",
                 1e-11},                                                    /* 2e-13 */
                {"configs/robots/catheter_routed_tendon.yaml", NULL, 1e-8}, /* 4e-10 */
                {"configs/robots/tendon_pulled.yaml", NULL, 1e-10},         /* 2e-12 */
                {"configs/robots/concentric.yaml", NULL, 1e-10},       /* 2e-12, of the reference */
                {"configs/robots/tendon_in_motion.yaml", NULL, 1e-6}}; /* 4e-7 */
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i += FARTHER(1)) {
        assert_true(trained_error(rows[i].path, rows[i].change) < rows[i].tolerance);
    }
}

/* In displacement form, which takes the load in parts: the actuation grows with the load factor. */
static void test_displacement_form(void **state)
{
    (void)state;
    double error =
        trained_error("configs/robots/soft_arm_three_chambers.yaml", "formulation=displacement");
    assert_true(error < 1e-2); /* measured: 2e-3, as rods that stretch have in this form */
}

/* Friction of a tendon that ends within the rod, and a motor that winds a tendon up, against the
 * classical solver, which has angles and lengths from integrals along the rod. */
static void test_sought(void **state)
{
    (void)state;
    static const char ends[] = "rod:\n"
                               "  length: 0.3\n"
                               "  stiffness: {shear: [80, 80], axial: 100, bending: [0.03, 0.04], "
                               "torsion: 0.02}\n"
                               "tendons: [{offset: [\"0.01*cos(9*s)\", \"0.01*sin(9*s)\"], "
                               "start: 0.05, end: 0.2, tension: 3, friction: 0.4}]\n"
                               "loads: {tip: {force: [0.1, -0.05, 0.08]}}\n"
                               "reference: solve\n";
    /* the same with a coefficient that is a parameter: 0.4 in the middle of it */
    static const char family[] =
        "parameters: {mu: {range: [0.3, 0.5]}}\n"
        "formulation: mixed\n"
        "rod:\n"
        "  length: 0.3\n"
        "  stiffness: {shear: [80, 80], axial: 100, bending: [0.03, 0.04], torsion: 0.02}\n"
        "tendons: [{offset: [\"0.01*cos(9*s)\", \"0.01*sin(9*s)\"], start: 0.05, end: 0.2, "
        "tension: 3, friction: mu}]\n"
        "loads: {tip: {force: [0.1, -0.05, 0.08]}}\n"
        "network: {fourier: {features: 24}}\n"
        "losses: {interior: {points: 250}}\n"
        "training: {stages: [{optimizer: gauss_newton, steps: 6}]}\n"
        "reference: solve\n";
    static const char wound[] =
        "rod:\n"
        "  length: 0.2\n"
        "  section: {shape: circle, radius: 0.005}\n"
        "  material: {youngs_modulus: 1.0e6, poissons_ratio: 0.45, density: 1100}\n"
        "time: {duration: 0.1, windows: 4}\n"
        "tendons: [{offset: [0.008, 0], displacement: \"0.006*sin(5*pi*t)^2\", stiffness: 200}]\n"
        "reference: solve\n";
    assert_true(trained_error_of("ends.yaml", ends, NULL) < 1e-9);
    /* few features: 1e-6 */
    assert_true(WATCHED || trained_error_of("family.yaml", family, NULL) < 1e-4);
    assert_true(trained_error_of("wound.yaml", wound, NULL) < 1e-5); /* measured: 2e-6 */
}

/* A path that has a kink. */
static void test_refused(void **state)
{
    (void)state;
    ad_error error = {AD_OK, ""};
    problem *made = NULL;
    experiment *e =
        experiment_of("configs/robots/tendon_two_segments.yaml", NULL, "tendons[3].friction=0.1");
    assert_int_not_equal(experiment_problem(e, &made, &error), AD_OK);
    assert_non_null(strstr(error.message, "tendons[3].friction: formulation mixed does not take "
                                          "friction of a tendon where strains jump"));
    experiment_free(e);
}

/* Strains as outputs of their own, with those of the pose as residuals: the same shape. Measured:
 * 5e-13 of the length. */
static void test_pose_strain(void **state)
{
    (void)state;
    const char *const changes[] = {
        "formulation=pose_strain",       "reference=solve", "network.hidden=null",
        "network.fourier.features=null", "losses=null",     NULL};
    run r = start("configs/robots/tendon_one_segment.yaml", changes, 1);
    finish(&r);
    assert_true(trainer_inspect(r.trainer)->errors.position < 1e-9);
    stop(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sought),
                                       cmocka_unit_test(test_refused),
                                       cmocka_unit_test(test_pose_strain)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_robots),
                                       cmocka_unit_test(test_displacement_form)};
    return run_with_alike(tests, alike, make_folder, remove_folder);
}
