/* Sections against the literature, properties that follow from them, and scenes built in C. The
 * many ways a scene file can contradict itself are in test_config.c. */
#include "physics/scene/scene.h"
#include "physics/scene/section.h"
#include "quantity_testing.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* cmocka's own comparison rounds to float. */
#define assert_close(a, b, tolerance) assert_true(fabs((a) - (b)) <= (tolerance))

static scene steel_rod(void)
{
    scene rod_scene;
    scene_defaults(&rod_scene);
    rod_scene.rod.length = Q(1);
    rod_scene.rod.section = SCENE_CIRCLE;
    rod_scene.rod.radius = Q(0.01);
    rod_scene.rod.youngs_modulus = Q(2e11);
    rod_scene.rod.poissons_ratio = Q(0.3);
    rod_scene.rod.density = Q(7800);
    return rod_scene;
}

static void assert_refused(const scene *rod_scene, const char *expected_key)
{
    const char *key = "";
    ad_error error = {AD_OK, ""};
    assert_int_equal(scene_check(rod_scene, &key, &error), AD_BAD_INPUT);
    assert_string_equal(key, expected_key);
    assert_true(strlen(error.message) > 10);
    assert_int_equal(scene_check(rod_scene, NULL, NULL), AD_BAD_INPUT);
}

/* Cowper 1966, table 1: nu = 0.3 gives 0.886 (circle), 0.531 (thin tube), 0.850 (rectangle). */
static void test_shear_correction(void **state)
{
    (void)state;
    scene_rod rod = steel_rod().rod;
    assert_close(scene_shear_correction(&rod).number, 0.886, 5e-4); /* printed digits */
    assert_close(scene_shear_correction(&rod).number, 7.8 / 8.8, 1e-15);
    rod.section = SCENE_TUBE;
    rod.inner_radius = Q(rod.radius.number * 0.9999);
    assert_close(scene_shear_correction(&rod).number, 0.531, 5e-4);
    rod.inner_radius = Q(0); /* a tube without a hole is a circle */
    assert_close(scene_shear_correction(&rod).number, 7.8 / 8.8, 1e-15);
    rod.section = SCENE_RECTANGLE;
    assert_close(scene_shear_correction(&rod).number, 0.850, 5e-4);
    rod.section = SCENE_SECTION_NONE;
    assert_false(scene_shear_correction(&rod).is_given);
}

/* Timoshenko and Goodier, table of k1 = J/(d c^3) with c <= d the sides. */
static void test_rectangle_torsion(void **state)
{
    (void)state;
    static const struct {
        double ratio;
        double k1;
    } rows[] = {{1, 0.1406}, {1.2, 0.166}, {1.5, 0.196}, {2, 0.229},  {2.5, 0.249},
                {3, 0.263},  {4, 0.281},   {5, 0.291},   {10, 0.312}, {1e6, 0.333}};
    scene_rod rod = {.section = SCENE_RECTANGLE};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        rod.width = Q(0.02);
        rod.height = Q(0.02 * rows[i].ratio);
        double unit = rod.height.number * pow(rod.width.number, 3);
        double upright = scene_section_geometry_of(&rod).torsion_constant.number;
        assert_close(upright / unit, rows[i].k1, 6e-4); /* three digits in print */
        rod.width = rod.height;
        rod.height = Q(0.02);
        assert_close(scene_section_geometry_of(&rod).torsion_constant.number / upright, 1, 1e-14);
    }
    /* The square to more digits, from the double sine series of Prandtl's stress function. */
    rod.width = rod.height = Q(1);
    assert_close(scene_section_geometry_of(&rod).torsion_constant.number, 0.1405770150, 1e-9);
}

/* width lies along d1, so bending about d1 is bending over the height. */
static void test_rectangle_axes(void **state)
{
    (void)state;
    scene_rod rod = {.section = SCENE_RECTANGLE, .width = Q(3), .height = Q(2)};
    scene_section_geometry section = scene_section_geometry_of(&rod);
    assert_close(section.area.number, 6, 1e-15);
    assert_close(section.second_moment[0].number, 2, 1e-15);   /* 3 * 2^3 / 12 */
    assert_close(section.second_moment[1].number, 4.5, 1e-15); /* 2 * 3^3 / 12 */
}

static void test_properties(void **state)
{
    (void)state;
    const double pi = 3.14159265358979323846;
    scene rod_scene = steel_rod();
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    scene_properties got = scene_properties_of(&rod_scene);
    double area = pi * 1e-4;
    double second_moment = pi * 1e-8 / 4;
    double shear = 2e11 / 2.6;
    /* relative rounding of a handful of products */
    assert_close(got.strain_stiffness[2].number / (2e11 * area), 1, 1e-14);
    assert_close(got.strain_stiffness[0].number / (7.8 / 8.8 * shear * area), 1, 1e-14);
    assert_close(got.curvature_stiffness[1].number / (2e11 * second_moment), 1, 1e-14);
    assert_close(got.curvature_stiffness[2].number / (shear * 2 * second_moment), 1, 1e-14);
    assert_close(got.mass_per_length.number / (7800 * area), 1, 1e-14);
    assert_close(got.rotary_inertia[0].number / (7800 * second_moment), 1, 1e-14);
    assert_close(got.rotary_inertia[2].number / (7800 * 2 * second_moment), 1, 1e-14);
    rod_scene.rod.bending_stiffness[0] = rod_scene.rod.bending_stiffness[1] = Q(7);
    rod_scene.rod.model = SCENE_INEXTENSIBLE;
    got = scene_properties_of(&rod_scene);
    assert_close(got.curvature_stiffness[0].number, 7, 0);
    assert_true(isinf(got.strain_stiffness[2].number) && isfinite(got.strain_stiffness[0].number));
    rod_scene.rod.model = SCENE_KIRCHHOFF;
    got = scene_properties_of(&rod_scene);
    assert_true(isinf(got.strain_stiffness[0].number) && isinf(got.strain_stiffness[2].number));
}

static void test_refusals(void **state)
{
    (void)state;
    scene rod_scene = steel_rod();
    rod_scene.rod.length = Q(-1);
    assert_refused(&rod_scene, "rod.length");
    rod_scene = steel_rod();
    rod_scene.rod.radius = Q(INFINITY);
    assert_refused(&rod_scene, "rod.section.radius");
    rod_scene = steel_rod();
    rod_scene.rod.shear_stiffness[0] = Q(5);
    assert_refused(&rod_scene, "rod.stiffness.shear");
    rod_scene = steel_rod();
    set_numbers(rod_scene.rod.curvature_damping, 3, (const double[]){0, -1, 0});
    assert_refused(&rod_scene, "rod.damping.curvature");
    rod_scene = steel_rod();
    rod_scene.rod.model = SCENE_INEXTENSIBLE;
    set_numbers(rod_scene.rod.strain_damping, 3, (const double[]){0.1, 0, 0});
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    rod_scene.rod.strain_damping[2] = Q(0.1); /* of the stretch, which is locked */
    assert_refused(&rod_scene, "rod.damping.strain");
    rod_scene = steel_rod();
    rod_scene.loads.gravity[0] = Q(NAN);
    assert_refused(&rod_scene, "loads.gravity");
    rod_scene = steel_rod();
    rod_scene.loads.tip.force[0] = Q("1");
    rod_scene.end.type = SCENE_LOADED;
    assert_refused(&rod_scene, "loads.tip.force"); /* two entries are missing */
    rod_scene.loads.tip.force[1] = rod_scene.loads.tip.force[2] = Q("0");
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    rod_scene.loads.tip.force[2] = Q("sin(");
    assert_refused(&rod_scene, "loads.tip.force");
    rod_scene = steel_rod();
    rod_scene.duration = Q(INFINITY);
    assert_refused(&rod_scene, "time.duration");
}

/* Material and mass are finite and positive where they are given, also beside a section. */
static void test_material_is_finite(void **state)
{
    (void)state;
    scene rod_scene = steel_rod();
    const struct {
        const char *key;
        quantity *value;
    } rows[] = {
        {"rod.material.youngs_modulus", &rod_scene.rod.youngs_modulus},
        {"rod.material.shear_correction", &rod_scene.rod.shear_correction},
        {"rod.material.density", &rod_scene.rod.density},
        {"rod.inertia.mass_per_length", &rod_scene.rod.mass_per_length},
    };
    static const double wrong[] = {0, -1, INFINITY};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
            rod_scene = steel_rod();
            *rows[i].value = Q(wrong[k]);
            assert_refused(&rod_scene, rows[i].key);
        }
        *rows[i].value = Q(1);
        assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    }
}

/* Damping by viscosity is that of the section's integrals, by a relaxation time that of the
 * stiffness: of an isotropic material the same. */
static void test_material_damping(void **state)
{
    (void)state;
    const double pi = 3.14159265358979323846, eta = 3e7, area = pi * 1e-4;
    const double second_moment = pi * 1e-8 / 4, in_shear = eta / 2.6;
    scene given = steel_rod(), relaxing = steel_rod();
    given.rod.viscosity = Q(eta);
    relaxing.rod.relaxation_time = Q(eta / 2e11);
    assert_int_equal(scene_check(&given, NULL, NULL), AD_OK);
    assert_int_equal(scene_check(&relaxing, NULL, NULL), AD_OK);
    scene_properties got = scene_properties_of(&given), same = scene_properties_of(&relaxing);
    /* relative rounding of a handful of products */
    assert_close(got.strain_damping[0].number / (7.8 / 8.8 * in_shear * area), 1, 1e-14);
    assert_close(got.strain_damping[2].number / (eta * area), 1, 1e-14);
    assert_close(got.curvature_damping[1].number / (eta * second_moment), 1, 1e-14);
    assert_close(got.curvature_damping[2].number / (in_shear * 2 * second_moment), 1, 1e-14);
    for (int i = 0; i < 3; i++) {
        assert_close(same.strain_damping[i].number / got.strain_damping[i].number, 1, 1e-14);
        assert_close(same.curvature_damping[i].number / got.curvature_damping[i].number, 1, 1e-14);
    }
    given.rod.model = SCENE_KIRCHHOFF; /* what is locked is not damped */
    assert_int_equal(scene_check(&given, NULL, NULL), AD_OK);
    got = scene_properties_of(&given);
    assert_true(quantity_is(got.strain_damping[0], 0) && quantity_is(got.strain_damping[2], 0));
    assert_true(quantity_is_something(got.curvature_damping[2]));
    given.rod.relaxation_time = Q(1e-3);
    assert_refused(&given, "rod.material.relaxation_time");
    given = steel_rod();
    given.rod.viscosity = Q(-1);
    assert_refused(&given, "rod.material.viscosity");
    given.rod.viscosity = Q(1);
    set_numbers(given.rod.strain_damping, 3, (const double[]){0, 0, 0});
    assert_refused(&given, "rod.material.viscosity");
    given = steel_rod();
    given.rod.section = SCENE_SECTION_NONE;
    given.rod.radius = Q(NULL);
    set_numbers(given.rod.shear_stiffness, 2, (const double[]){5, 5});
    set_numbers(given.rod.bending_stiffness, 2, (const double[]){1, 1});
    given.rod.axial_stiffness = given.rod.torsional_stiffness = Q(1);
    given.rod.relaxation_time = Q(0.01);
    assert_int_equal(scene_check(&given, NULL, NULL), AD_OK);
    assert_true(scene_properties_of(&given).strain_damping[1].number == 0.01 * 5);
    given.rod.relaxation_time = Q(NULL);
    given.rod.viscosity = Q(1);
    assert_refused(&given, "rod.material.viscosity");
}

/* What varies along the rod is what the numbers are at every place; ranges hold all along. */
static void test_tapered(void **state)
{
    (void)state;
    static const double places[] = {0, 0.3, 0.77, 1};
    scene tapered = steel_rod();
    tapered.rod.radius = Q("0.01 - 0.004*s");
    tapered.rod.youngs_modulus = Q("2e11*(1 + s^2)");
    tapered.rod.density = Q("7800 + 100*sin(s)");
    tapered.rod.viscosity = Q("1e7*exp(-s)");
    tapered.rod.maxwell_ratio = Q("0.2 + s");
    tapered.rod.maxwell_time = Q("0.1 + s");
    assert_int_equal(scene_check(&tapered, NULL, NULL), AD_OK);
    scene_properties along = scene_properties_of(&tapered);
    for (int k = 0; k < 4; k++) {
        double s = places[k];
        scene there = steel_rod();
        there.rod.radius = Q(0.01 - 0.004 * s);
        there.rod.youngs_modulus = Q(2e11 * (1 + s * s));
        there.rod.density = Q(7800 + 100 * sin(s));
        there.rod.viscosity = Q(1e7 * exp(-s));
        there.rod.maxwell_ratio = Q(0.2 + s);
        there.rod.maxwell_time = Q(0.1 + s);
        scene_properties at = scene_properties_of(&there);
        const quantity *varying = (const quantity *)(const void *)&along;
        const quantity *number = (const quantity *)(const void *)&at;
        for (size_t i = 0; i < sizeof at / sizeof *number; i++) { /* rounding of a few products */
            assert_close(quantity_value(varying[i], s, 0) / number[i].number, 1, 1e-14);
        }
    }
    scene_properties again = scene_properties_of(&tapered); /* the same nodes, not more of them */
    assert_ptr_equal(again.curvature_stiffness[0].node, along.curvature_stiffness[0].node);
    tapered.rod.section = SCENE_RECTANGLE;
    tapered.rod.width = Q("0.02 + 0.01*s");
    tapered.rod.height = Q("0.025");
    tapered.rod.radius = Q(NULL);
    scene_rod wide = {.section = SCENE_RECTANGLE, .width = Q(0.026), .height = Q(0.025)};
    double torsion =
        quantity_value(scene_section_geometry_of(&tapered.rod).torsion_constant, 0.6, 0);
    assert_close(torsion / scene_section_geometry_of(&wide).torsion_constant.number, 1, 1e-13);
    const struct {
        const char *key;
        quantity *field;
        const char *wrong;
    } rows[] = {{"rod.section.width", &tapered.rod.width, "0.5 - s"},
                {"rod.section.width", &tapered.rod.width, "1/(s - 0.5)"},
                {"rod.section.width", &tapered.rod.width, "0.1 - exp(-((s-0.3)/1e-6)^2)"},
                {"rod.section.width", &tapered.rod.width, "where((s-0.3)*(0.3001-s), -1, 1)"},
                {"rod.section.width", &tapered.rod.width, "0.1 + 0*t"},
                {"rod.length", &tapered.rod.length, "1 + s"},
                {"time.duration", &tapered.duration, "s"},
                {"rod.material.poissons_ratio", &tapered.rod.poissons_ratio, "0.3 + s"},
                {"rod.material.density", &tapered.rod.density, "s - 0.1"},
                {"rod.material.viscosity", &tapered.rod.viscosity, "-s"},
                {"loads.gravity", &tapered.loads.gravity[2], "s"},
                {"loads.gravity", &tapered.loads.gravity[2], "sin(t)"}, /* the scene is static */
                {"loads.drag", &tapered.loads.drag, "-1 + s"},
                {"rod.rest.curvature", &tapered.rod.rest_curvature[0], "t"}};
    assert_int_equal(scene_check(&tapered, NULL, NULL), AD_OK);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        quantity right = *rows[i].field;
        *rows[i].field = Q(rows[i].wrong);
        assert_refused(&tapered, rows[i].key);
        *rows[i].field = right;
    }
    tapered.duration = Q(1);
    tapered.loads.gravity[2] = Q("sin(t)");
    tapered.rod.rest_curvature[0] = Q("s*t");
    assert_int_equal(scene_check(&tapered, NULL, NULL), AD_OK);
}

/* Two pinned ends are enough under a load across the line between them, or in motion with a known
 * start: the spin of a round rod about its own axis moves nothing. */
static void test_pinned(void **state)
{
    (void)state;
    scene rod_scene = steel_rod();
    rod_scene.start.type = rod_scene.end.type = SCENE_PINNED;
    rod_scene.end.position[0] = rod_scene.end.position[1] = Q("0");
    rod_scene.end.position[2] = Q("0.9");
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK); /* straight, round, in a plane */
    rod_scene.motion = SCENE_SPATIAL;
    assert_refused(&rod_scene, "boundary");
    rod_scene.motion = SCENE_AUTOMATIC;
    rod_scene.rod.rest_curvature[0] = Q("0.1");
    assert_refused(&rod_scene, "boundary");
    rod_scene.loads.gravity[2] = Q(-9.81); /* along the line */
    assert_refused(&rod_scene, "boundary");
    rod_scene.loads.gravity[1] = Q(-9.81);
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    rod_scene.rod.rest_curvature[0] = Q("0");
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    rod_scene.loads.gravity[1] = rod_scene.loads.gravity[2] = Q(0);
    rod_scene.loads.force[0] = Q("1");
    rod_scene.loads.force[1] = rod_scene.loads.force[2] = Q("0");
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    rod_scene.loads.frame = SCENE_FOLLOWER; /* spins with the rod */
    assert_refused(&rod_scene, "boundary");
    rod_scene.loads.frame = SCENE_DEAD;
    rod_scene.rod.model = SCENE_KIRCHHOFF;
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    rod_scene.end.position[2] = Q("1.01");
    assert_refused(&rod_scene, "boundary.end.position");
    rod_scene.rod.rest_strain[2] = Q("1.02");
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    rod_scene.rod.rest_strain[2] = Q("1");
    rod_scene.rod.model = SCENE_INEXTENSIBLE; /* reaches farther by shear */
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
    rod_scene.duration = Q(1);
    assert_refused(&rod_scene, "initial.position");
    static const char *const position[3] = {"0", "0", "s*0.9"};
    static const char *const rotation[4] = {"1", "0", "0", "0"};
    set_quantities(rod_scene.initial.position, 3, position);
    set_quantities(rod_scene.initial.rotation, 4, rotation);
    assert_int_equal(scene_check(&rod_scene, NULL, NULL), AD_OK);
}

static void test_names(void **state)
{
    (void)state;
    assert_string_equal(scene_model_names()[SCENE_KIRCHHOFF], "kirchhoff");
    assert_string_equal(scene_section_names()[SCENE_RECTANGLE], "rectangle");
    assert_string_equal(scene_end_names()[SCENE_DRIVEN], "driven");
    assert_null(scene_end_names()[SCENE_ROLLER + 1]);
    assert_string_equal(scene_frame_names()[SCENE_FOLLOWER], "follower");
    assert_string_equal(scene_formulation_names()[SCENE_DISPLACEMENT], "displacement");
    assert_string_equal(scene_enforcement_names()[SCENE_SOFT], "soft");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shear_correction), cmocka_unit_test(test_rectangle_torsion),
        cmocka_unit_test(test_rectangle_axes),   cmocka_unit_test(test_properties),
        cmocka_unit_test(test_refusals),         cmocka_unit_test(test_material_damping),
        cmocka_unit_test(test_tapered),          cmocka_unit_test(test_material_is_finite),
        cmocka_unit_test(test_pinned),           cmocka_unit_test(test_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
