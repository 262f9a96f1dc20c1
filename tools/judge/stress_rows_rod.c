/* Rods: slender and stout, soft and stiff, small and large. */
#include "tools/judge/stress_rows.h"

#define ROUND(radius)                                                                              \
    "rod:\n"                                                                                       \
    "  model: cosserat\n"                                                                          \
    "  length: 1\n"                                                                                \
    "  section: {shape: circle, radius: " radius "}\n"                                             \
    "  material: {youngs_modulus: 1, poissons_ratio: 0.3}\n"                                       \
    "loads: {units: EI, tip: {force: [0, 0, -4]}}\n" ALONG_X BESIDE

/* configs/reference/slender_10_static.csv and slender_100_static.csv, which say how they were
 * computed. */
static const char slender_10[] = "s,x,y,z\n"
                                 "0,0,0,0\n"
                                 "0.2,0.191700189788,0,-0.0528301165243\n"
                                 "0.4,0.351653947184,0,-0.173593072925\n"
                                 "0.6,0.477345097981,0,-0.3307657624\n"
                                 "0.8,0.578375640725,0,-0.505269512577\n"
                                 "1,0.66703437641,0,-0.686541558053\n";
static const char slender_100[] = "s,x,y,z\n"
                                  "0,0,0,0\n"
                                  "0.2,0.192461314586,0,-0.0475881003413\n"
                                  "0.4,0.353715003251,0,-0.164509354739\n"
                                  "0.6,0.480404160788,0,-0.318851261632\n"
                                  "0.8,0.582017068252,0,-0.491016281131\n"
                                  "1,0.671018598229,0,-0.670129395421\n";

#define MATERIAL(length, radius, youngs_modulus, force)                                            \
    "rod:\n"                                                                                       \
    "  model: kirchhoff\n"                                                                         \
    "  length: " length "\n"                                                                       \
    "  section: {shape: circle, radius: " radius "}\n"                                             \
    "  material: {youngs_modulus: " youngs_modulus ", poissons_ratio: 0.3}\n"                      \
    "loads: {tip: {force: [" force ", 0, 0]}}\n" ELASTICA

#define SCALED(length, radius, youngs_modulus, unit)                                               \
    "rod:\n"                                                                                       \
    "  model: cosserat\n"                                                                          \
    "  length: " length "\n"                                                                       \
    "  section: {shape: circle, radius: " radius "}\n"                                             \
    "  material: {youngs_modulus: " youngs_modulus ", poissons_ratio: 0.3, density: 1000}\n"       \
    "time: {duration: " unit "}\n"                                                                 \
    "loads:\n"                                                                                     \
    "  units: EI\n"                                                                                \
    "  tip: {force: [0, 0, \"-where(0.5-t/" unit ", 4*sin(pi*t/" unit                              \
    ")^2, 4)\"]}\n" ALONG_X BESIDE

#define TWISTED(torsion, moment)                                                                   \
    ROD "loads: {tip: {moment: " moment "}}\n" HELIX,                                              \
        .overrides = {"rod.stiffness.torsion=" torsion}

/* What a user does who wants more of it: steps that gain little count, and there are more. */
#define FAR_PATIENTLY                                                                              \
    ROD "loads: {tip: {moment: [0, 3, 4e-3]}}\n" HELIX,                                            \
        .overrides = {"rod.stiffness.torsion=1e-3",                                                \
                      "training.stages=[{optimizer: gauss_newton, steps: 800, "                    \
                      "function_tolerance: 0.002}]"}

#define UNSTRETCHED(limit)                                                                         \
    SOLVED(limit, "the closed form neither stretches nor shears, by (radius/length)^2")

static const stress_row rows[] = {
    {"slender/10", ROUND("0.1"), .file = slender_10, .quick = true, PINN = AT_REST, SOLVER = EXACT},
    {"slender/100", ROUND("0.01"), .file = slender_100, PINN = AT_REST, SOLVER = EXACT},
    {"slender/1000", ROUND("1e-3"), .write = stress_write_elastica, BOTH(UNSTRETCHED(1e-5))},
    {"slender/10000", ROUND("1e-4"), .write = stress_write_elastica, .quick = true,
     BOTH(UNSTRETCHED(1e-7))},

    {"material/10kPa", MATERIAL("0.1", "0.005", "1e4", "1.5e-3"), .quick = true, PINN = AT_REST,
     SOLVER = EXACT},
    {"material/200GPa", MATERIAL("1", "1e-3", "2e11", "0.5"), PINN = AT_REST, SOLVER = EXACT},
    {"size/1mm", MATERIAL("1e-3", "1e-5", "2e11", "5e-3"), PINN = AT_REST, SOLVER = EXACT},
    {"size/1km", MATERIAL("1e3", "1", "2e11", "3e5"), PINN = AT_REST, SOLVER = EXACT},
    {"size/0.3ug-1ms", SCALED("1e-3", "1e-5", "4e7", "1e-3"), .write = stress_write_small,
     PINN = IN_MOTION, SOLVER = SOLVED(1e-6, "as asked for")},
    {"size/300kt-1h", SCALED("1e3", "10", "3.0864197530864197e6", "3600"),
     .write = stress_write_large, PINN = IN_MOTION, SOLVER = SOLVED(1e-6, "as asked for")},

    {"twist/0.01", TWISTED("0.01", "[0, 3, 0.04]"), .measure = stress_rotation,
     PINN = FLUTTERS(1e-5, "rad; the section turns by 4 rad, and errors grow a hundredfold"),
     SOLVER = FLUTTERS_EXACT},
    {"twist/1e-3", TWISTED("1e-3", "[0, 1, 1e-3]"), .measure = stress_rotation,
     PINN = FLUTTERS(1e-4, "rad; the section turns by 1 rad, and errors grow a thousandfold"),
     SOLVER = FLUTTERS_EXACT},
    {"twist/1e-3-far", TWISTED("1e-3", "[0, 3, 4e-3]"), .measure = stress_rotation,
     PINN = WARNED(VERDICT_NOT_CONVERGED, "200 steps end half way along so narrow a valley"),
     SOLVER = FLUTTERS_EXACT},
    {"twist/1e-3-patient", FAR_PATIENTLY, .measure = stress_rotation,
     PINN = FLUTTERS(1e-4, "rad; the same valley, walked to its end"), SOLVER = FLUTTERS_EXACT},
    {"twist/1000", TWISTED("1e3", "[0, 3, 4]"),
     PINN = FLUTTERS(1e-6, "smooth at rest: 1e-9 is usual"), SOLVER = FLUTTERS_EXACT},
    {"twist/1000-angle", TWISTED("1e3", "[0, 3, 4]"), .measure = stress_rotation, .quick = true,
     PINN = FLUTTERS(1e-6, "rad; the twist is almost locked"), SOLVER = FLUTTERS_EXACT},
    {"twist/640-turns", TWISTED("1e-3", "[0, 3, 4]"),
     PINN = WARNED(VERDICT_NOT_CONVERGED, "no network of a few waves winds 640 times"),
     SOLVER = STOPPED("of the load", "640 turns need more nodes than it takes")},
};
const stress_group stress_rods = GROUP("Rods: slenderness, material, size, twist", rows);
