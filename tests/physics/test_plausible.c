/* Sizes that are hardly meant are told, and those of the shipped scenes are not. */
#include <dirent.h>
#include <stdio.h>
#include <string.h>

#include "config_testing.h"
#include "fewer.h"
#include "physics/check/plausible.h"

#define ARM                                                                                        \
    "rod:\n"                                                                                       \
    "  length: 0.3\n"                                                                              \
    "  section: {shape: circle, radius: 0.005}\n"                                                  \
    "  material: {youngs_modulus: 1e7, poissons_ratio: 0.45, density: 1070}\n"                     \
    "loads: {gravity: [0, 0, -9.81], tip: {force: [0, 0, 0.02]}}\n"

static scene_warnings warnings_of(const char *path, const char *text, const char *override)
{
    config *experiment = read_config(path, text, override != NULL, &override);
    scene_warnings all = scene_implausible(&experiment->scene);
    config_free(experiment);
    return all;
}

static void every_warning(void **state)
{
    (void)state;
    static const char *const rows[][2] = {
        {"rod.material.youngs_modulus=10", "rod.material.youngs_modulus: 10 Pa is softer than"},
        {"rod.material.youngs_modulus=2.1e14",
         "rod.material.youngs_modulus: 2.1e+14 Pa is stiffer"},
        {"rod.material.density=1.07", "rod.material.density: 1.07 kg/m^3 is lighter than foam"},
        {"rod.material.density=1e6", "rod.material.density: 1e+06 kg/m^3 is heavier"},
        {"rod.length=130", "rod.length: 130 m is very long for a material as soft as this"},
        {"rod={length: 200, section: {radius: 1}, material: {youngs_modulus: 60e9}}",
         "rod.length: 200 m is longer than robots, wires and beams are"},
        {"rod.material={youngs_modulus: 60e3, density: 6450}",
         "rod.material.youngs_modulus: 6e+04 Pa is softer than any metal"},
        {"rod.length=1e-7", "rod.length: 1e-07 m is shorter than a cell"},
        {"loads.gravity=[0, 0, -9810]", "loads.gravity: 9810 m/s^2 is more than on any planet"},
        {"rod.section.radius=5", "rod.section: the rod is only 0.06 times as long as its radius"},
        {"rod.section.radius=5e-6", "rod.section: the rod is 6e+04 times as long as its radius"},
        {"rod.length=30", "loads.gravity: the weight, rhoA g L^3/EI, is 4.53e+06 times what bends"},
        {"loads.tip.force=[0, 0, 200]", "loads.tip, loads.base: the force, F L^2/EI, is 3.67e+03"},
        {"loads.tip.moment=[0, 2, 0]", "loads.tip, loads.base: the moment, T L/EI, is 122 times"},
        {"loads.force=[0, 0, 200]", "loads.force: the line load, f L^3/EI, is 1.1e+03 times"},
        {"loads.moment=[0, 20, 0]", "loads.moment: the line moment, l L^2/EI, is 367 times"},
    };
    assert_int_equal(warnings_of("arm.yaml", ARM, NULL).count, 0);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        scene_warnings all = warnings_of("arm.yaml", ARM, rows[i][0]);
        bool found = false;
        for (int k = 0; k < all.count; k++) {
            found = found || strncmp(all.texts[k], rows[i][1], strlen(rows[i][1])) == 0;
        }
        if (!found) {
            fail_msg("%s: %d warnings, first '%s', none begins '%s'", rows[i][0], all.count,
                     all.count ? all.texts[0] : "", rows[i][1]);
        }
    }
}

/* Without a material nothing says that lengths are metres: only ratios are judged. */
static void numbers_without_dimension(void **state)
{
    (void)state;
    static const char scene[] = "rod:\n"
                                "  length: 1000\n"
                                "  model: kirchhoff\n"
                                "  stiffness: {bending: [1, 1], torsion: 0.8}\n"
                                "  inertia: {mass_per_length: 1}\n"
                                "loads: {gravity: [0, 0, -1e-6]}\n";
    assert_int_equal(warnings_of("scene.yaml", scene, "rod.length=1").count, 0);
    assert_int_equal(warnings_of("scene.yaml", scene, NULL).count, 0); /* exactly 1000 */
    scene_warnings all = warnings_of("scene.yaml", scene, "loads.gravity=[0, 0, -1]");
    assert_int_equal(all.count, 1);
    static const char unit[] = "rod: {length: 130, model: kirchhoff, material: {youngs_modulus: 1, "
                               "poissons_ratio: 0}, section: {shape: circle, radius: 1}}\n";
    assert_int_equal(warnings_of("unit.yaml", unit, NULL).count, 0);
}

static int check_folder(const char *folder)
{
    DIR *entries = opendir(folder);
    int count = 0;
    assert_non_null(entries);
    for (struct dirent *entry = readdir(entries); entry; entry = readdir(entries)) {
        char path[512];
        size_t length = strlen(entry->d_name);
        if (length < 6 || strcmp(entry->d_name + length - 5, ".yaml") != 0) {
            continue;
        }
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        scene_warnings all = warnings_of(path, NULL, NULL);
        if (all.count > 0) {
            fail_msg("%s: %s", path, all.texts[0]);
        }
        count++;
    }
    closedir(entries);
    return count;
}

static void shipped_scenes(void **state)
{
    (void)state;
    assert_true(check_folder("configs") > 10);
    assert_true(check_folder("configs/cases") > 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_warning),
        cmocka_unit_test(numbers_without_dimension),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(shipped_scenes)};
    return run_with_alike(tests, alike, NULL, NULL);
}
