/* Loads: large ones, turns, followers, buckling, snap-through, quaternions. Shapes without a closed
 * form by collocation (scipy.integrate.solve_bvp, tolerance 1e-9, continuation in the load). */
#include "tools/judge/stress_rows.h"

#define TURNS(moment)   ROD "loads: {tip: {moment: [0, \"" moment "\", 0]}}\n" ROLLUP
#define FORCE(force)    ROD "loads: {tip: {force: [" force ", 0, 0]}}\n" ELASTICA
#define WEIGHT(g)       ROD "loads: {gravity: [" g ", 0, 0]}\n" BESIDE
#define FOLLOWER(force) ROD "loads: {tip: {force: [" force ", 0, 0], frame: follower}}\n" BESIDE
/* In units of Euler's load, and a small force across it. */
#define COLUMN(load, across) ROD "loads: {tip: {force: [" across ", 0, -" load "*pi^2/4]}}\n" BESIDE

static const char weight_100[] = "s,x,y,z\n"
                                 "0,0,0,0\n"
                                 "0.2,0.13967370383,0,0.12388955892\n"
                                 "0.4,0.33764173257,0,0.14975850847\n"
                                 "0.6,0.53754023667,0,0.15574175307\n"
                                 "0.8,0.73752872432,0,0.15784031461\n"
                                 "1,0.9375239354,0,0.15922338263\n";
static const char weight_1000[] = "s,x,y,z\n"
                                  "0,0,0,0\n"
                                  "0.2,0.18114144171,0,0.045826316912\n"
                                  "0.4,0.38114126927,0,0.045985421677\n"
                                  "0.6,0.58114126927,0,0.045986437\n"
                                  "0.8,0.78114126927,0,0.045986453514\n"
                                  "1,0.98114126927,0,0.045986454757\n";
/* Followers integrated from the tip, where all is known (scipy.integrate.solve_ivp, 1e-13). */
static const char follower_5[] = "s,x,y,z\n"
                                 "0,0,0,0\n"
                                 "0.2,0.059304430495,0,0.18764756837\n"
                                 "0.4,0.21685026282,0,0.30587725685\n"
                                 "0.6,0.41401550934,0,0.32493745932\n"
                                 "0.8,0.60468302727,0,0.26707223275\n"
                                 "1,0.78069014278,0,0.1722778754\n";
static const char follower_20[] = "s,x,y,z\n"
                                  "0,0,0,0\n"
                                  "0.2,-0.041086351506,0,0.19496396912\n"
                                  "0.4,-0.059234095057,0,0.39185707019\n"
                                  "0.6,0.072091022901,0,0.52782121818\n"
                                  "0.8,0.24847943551,0,0.45672801315\n"
                                  "1,0.33015765978,0,0.27571012309\n";
static const char straight[] = "s,x,y,z\n0,0,0,0\n0.5,0,0,0.5\n1,0,0,1\n";
/* The stable branch, which leans the way the small force points. */
static const char leaning_099[] = "s,x,y,z\n"
                                  "0,0,0,0\n"
                                  "0.2,0.0015611505183,0,0.1999919039\n"
                                  "0.4,0.006087694436,0,0.39993904799\n"
                                  "0.6,0.013132331338,0,0.5998139194\n"
                                  "0.8,0.022004028583,0,0.79961663188\n"
                                  "1,0.031835447034,0,0.99937479059\n";
static const char leaning_101[] = "s,x,y,z\n"
                                  "0,0,0,0\n"
                                  "0.2,0.0094919402633,0,0.19970036882\n"
                                  "0.4,0.036950706181,0,0.39774563373\n"
                                  "0.6,0.079502868866,0,0.59312776833\n"
                                  "0.8,0.13285323219,0,0.785864616\n"
                                  "1,0.19180997256,0,0.97697536681\n";
static const char leaning_2[] = "s,x,y,z\n"
                                "0,0,0,0\n"
                                "0.2,0.073680441006,0,0.18072702625\n"
                                "0.4,0.24828228882,0,0.27124573807\n"
                                "0.6,0.44627333459,0,0.25910650534\n"
                                "0.8,0.62932336726,0,0.17987969375\n"
                                "1,0.79709620152,0,0.071120966311\n";

/* A shallow arch of 1 rad on two pins, pressed down. Under 20 EI/L^3 it stands; from 45 on it falls
 * over sideways, so that only the inverted shape is stable. */
#define ARCH(load)                                                                                 \
    "rod:\n"                                                                                       \
    "  model: kirchhoff\n"                                                                         \
    "  length: 1\n"                                                                                \
    "  stiffness: {bending: [1, 1], torsion: 1}\n"                                                 \
    "  rest: {curvature: [0, -1, 0]}\n"                                                            \
    "boundary:\n"                                                                                  \
    "  start: {type: pinned}\n"                                                                    \
    "  end: {type: pinned, position: [0, 0, 0.958851077208406]}\n"                                 \
    "loads: {force: [-" load ", 0, 0]}\n" BESIDE
static const char arch_inverted[] = "s,x,y,z\n"
                                    "0,0,0,0\n"
                                    "0.2,-0.07333585825,0,0.1860500756\n"
                                    "0.4,-0.1217287757,0,0.3797114666\n"
                                    "0.6,-0.1217287757,0,0.5791396106\n"
                                    "0.8,-0.07333585825,0,0.7728010016\n"
                                    "1,0,0,0.9588510772\n";

/* A full circle about +y; q of every second point is -q. */
static const char circle[] = "s,x,y,z,qw,qx,qy,qz\n"
                             "0,0,0,0,-1,0,0,0\n"
                             "0.25,0.15915494309189535,0,0.15915494309189535,"
                             "0.70710678118654752,0,0.70710678118654752,0\n"
                             "0.5,0.3183098861837907,0,0,0,0,-1,0\n"
                             "0.75,0.15915494309189535,0,-0.15915494309189535,"
                             "-0.70710678118654752,0,0.70710678118654752,0\n"
                             "1,0,0,0,1,0,0,0\n";

static const stress_row rows[] = {
    {"turns/1", TURNS("2*pi"), .quick = true, PINN = AT_REST, SOLVER = EXACT},
    {"turns/2", TURNS("4*pi"), PINN = AT_REST, SOLVER = EXACT},
    {"turns/5", TURNS("10*pi"), PINN = AT_REST, SOLVER = EXACT},
    {"turns/5-waves", TURNS("10*pi"), .overrides = {"network.fourier.wavenumber=64"},
     PINN = AT_REST, SOLVER = EXACT},

    {"force/10", FORCE("10"), .quick = true, PINN = AT_REST, SOLVER = EXACT},
    {"force/100", FORCE("100"), .quick = true,
     PINN = SOLVED(1e-4, "a layer of a tenth of the length at the clamp"), SOLVER = EXACT},
    {"force/1000", FORCE("1000"), PINN = DIGITS("a layer of 1/30 of the length at the clamp"),
     SOLVER = EXACT},
    {"weight/100", WEIGHT("100"), .file = weight_100,
     PINN = SOLVED(1e-4, "a layer of a tenth of the length at the clamp"), SOLVER = EXACT},
    {"weight/1000", WEIGHT("1000"), .file = weight_1000,
     PINN = DIGITS("a layer of 1/30 of the length at the clamp"), SOLVER = EXACT},
    {"weight/1000-waves", WEIGHT("1000"), .overrides = {"network.fourier.wavenumber=64"},
     .file = weight_1000, PINN = DIGITS("waves as short as the layer"), SOLVER = EXACT},
    {"follower/5", FOLLOWER("5"), .file = follower_5, .quick = true, PINN = AT_REST,
     SOLVER = EXACT},
    {"follower/20", FOLLOWER("20"), .file = follower_20,
     PINN = DIGITS("three quarters of a turn, and curvature comes and goes"), SOLVER = EXACT},

    {"column/0.99", COLUMN("0.99", "0"), .file = straight, .quick = true, PINN = AT_REST,
     SOLVER = EXACT},
    {"column/0.99-leaning", COLUMN("0.99", "1e-3"), .file = leaning_099,
     PINN = SOLVED(1e-5, "1% below Euler's load errors grow a hundredfold"), SOLVER = EXACT},
    {"column/1.01", COLUMN("1.01", "0"), .file = straight, .quick = true,
     BOTH(WARNED(VERDICT_UNSTABLE, "straight, but not stable: the other branch has to be named"))},
    {"column/1.01-leaning", COLUMN("1.01", "1e-3"), .file = leaning_101,
     PINN = SOLVED(1e-5, "the stable branch"), SOLVER = EXACT},
    {"column/1.01-named", COLUMN("1.01", "1e-3"), .overrides = {"rod.rest.imperfection=[0, 1, 0]"},
     .file = leaning_101, PINN = SOLVED(1e-5, "the stable branch, which an imperfection names"),
     SOLVER = EXACT},
    {"column/2", COLUMN("2", "0"), .file = straight, .quick = true,
     BOTH(WARNED(VERDICT_UNSTABLE, "straight, but not stable: the other branch has to be named"))},
    {"column/2-leaning", COLUMN("2", "1e-2"), .file = leaning_2,
     PINN = SOLVED(1e-6, "the stable branch"), SOLVER = EXACT},
    {"column/2-named", COLUMN("2", "1e-2"), .overrides = {"rod.rest.imperfection=[0, 1, 0]"},
     .file = leaning_2, .quick = true,
     PINN = SOLVED(1e-6, "the stable branch, which an imperfection names"), SOLVER = EXACT},
    {"arch/60-named", ARCH("60"), .overrides = {"rod.rest.imperfection=[0, 3, 0]"},
     .file = arch_inverted, PINN = SOLVED(1e-5, "the inverted shape, which an imperfection names"),
     SOLVER = EXACT},
    {"arch/60", ARCH("60"), .file = arch_inverted,
     PINN = WARNED(VERDICT_UNSTABLE,
                   "straight down it gives way from 39 on: a direction has to be named"),
     SOLVER = WARNED(VERDICT_SNAPPED, "the inverted shape, to which it snaps from 39 on")},

    {"quaternion/file", TURNS("2*pi"),
     .overrides = {"reference.analytic=none", "reference.file=reference.csv"}, .file = circle,
     .measure = stress_rotation, .quick = true,
     PINN = SOLVED(1e-6, "rad; -q is the rotation q, in the file and along the rod"),
     SOLVER = EXACT},
    {"quaternion/opposite",
     ROD "boundary: {end: {type: clamped, position: [0, 0, 1], rotation: [-1, 0, 0, 0]}}\n" BESIDE,
     .file = straight, .quick = true,
     PINN = SOLVED(1e-6, "the ends have one rotation, q and -q, and between them q passes no 0"),
     SOLVER = STOPPED("of the load", "held straight, it has any tension, unless it can stretch")},
    {"quaternion/soft", TURNS("2*pi"), .overrides = {"enforcement.boundary=soft"},
     PINN = SOLVED(1e-5, "q = identity + network has to pass near 0 before it is normalised"),
     SOLVER = EXACT},
};
const stress_group stress_loads =
    GROUP("Loads: turns, large loads, followers, buckling, quaternions", rows);
