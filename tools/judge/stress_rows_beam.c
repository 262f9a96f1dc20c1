/* Beams of small deflection: foundations, frequencies, shear, units. Closed forms (Hetenyi 1946;
 * Timoshenko, Young, Weaver 1974, ch. 5). */
#include "tools/judge/stress_rows.h"

#define BEAM(model, length, stiffness)                                                             \
    "rod: {model: " model ", length: " length ", stiffness: " stiffness                            \
    ", inertia: {mass_per_length: 1}}\n"
#define UNIT              BEAM("euler_bernoulli", "1", "{bending: [1, 1]}")
#define PINNED            "boundary: {start: {type: pinned}, end: {type: pinned}}\n"
#define SHOWN(deflection) "reference: {deflection: \"" deflection "\"}\n"

/* Under sin(pi s), between pins. */
#define FOUNDED(k)                                                                                 \
    UNIT PINNED "beam: {force: \"sin(pi*s)\", foundation: " k "}\n" SHOWN("sin(pi*s)/(pi^4+" k ")")
/* Under 1, clamped at s = 0: but for a layer there it sinks by 1/k everywhere. */
#define LAYER(k, beta)                                                                             \
    UNIT "beam: {force: 1, foundation: " k                                                         \
         "}\n" SHOWN("(1-exp(-" beta "*s)*(cos(" beta "*s)+sin(" beta "*s)))/" k)
#define SHEARING(stiffness)                                                                        \
    BEAM("timoshenko", "1", "{bending: [1, 1], shear: [" stiffness ", " stiffness "]}")            \
    PINNED "beam: {force: \"sin(pi*s)\"}\n" SHOWN("sin(pi*s)*(pi^-4+pi^-2/" stiffness ")")
#define MODE(n, period)                                                                            \
    UNIT PINNED "time: {duration: " period "}\n"                                                   \
                "beam: {initial: {deflection: \"1e-3*sin(" n                                       \
                "*pi*s)\"}}\n" SHOWN("1e-3*sin(" n "*pi*s)*cos((" n "*pi)^2*t)")
#define SMALL(what) SOLVED(1e-6, what)

static const stress_row rows[] = {
    {"beam/foundation-1e8", FOUNDED("1e8"), .quick = true, PINN = SMALL("bending is a millionth"),
     SOLVER = EXACT},
    {"beam/layer-1e6", LAYER("6.4e5", "20"), .quick = true,
     PINN = DIGITS("a layer of 1/20 of the length, as short as the usual waves"),
     SOLVER = SOLVED(1e-8, "the closed form forgets the free end, by exp(-20)")},
    {"beam/layer-1e8", LAYER("4e8", "100"), .quick = true,
     PINN = WARNED(VERDICT_NOT_CONVERGED, "a layer of 1/100 of the length, shorter than the waves"),
     SOLVER = EXACT},
    {"beam/layer-1e8-waves", LAYER("4e8", "100"),
     .overrides = {"network.fourier.wavenumber=200", "network.fourier.features=128"},
     PINN = DIGITS("waves as short as the layer")},
    {"beam/shear-1e6", SHEARING("1e6"), .quick = true, PINN = SMALL("it hardly shears"),
     SOLVER = EXACT},
    {"beam/shear-1e-3", SHEARING("1e-3"), .quick = true, PINN = SMALL("it hardly bends"),
     SOLVER = EXACT},
    {"beam/micrometres",
     BEAM("euler_bernoulli", "1e-5", "{bending: [1e-20, 1e-20]}") PINNED
     "beam: {force: \"1e-6*sin(pi*s/1e-5)\"}\n" SHOWN("1e-6*sin(pi*s/1e-5)/pi^4"),
     .quick = true, PINN = SMALL("only ratios count"), SOLVER = EXACT},
    {"beam/mode-1", MODE("1", "0.6366197723675814"), PINN = SOLVED(1e-5, "one period"),
     SOLVER = EXACT},
    {"beam/mode-10", MODE("10", "0.006366197723675814"), .tolerance = 1e-6,
     PINN = WARNED(VERDICT_NOT_CONVERGED,
                   "five waves along the beam, shorter than those of the network"),
     SOLVER = SOLVED(1e-6, "as asked for")},
    {"beam/mode-10-waves", MODE("10", "0.006366197723675814"),
     .overrides = {"network.fourier.wavenumber=50", "losses.interior.points=6000"}, .seconds = 120,
     .is_long = true, PINN = SOLVED(1e-5, "one period")},
};
const stress_group stress_beams = GROUP("Beams: foundations, shear, units, modes", rows);
