/* Motions: steps and blows, many periods, damping, windows. */
#include "tools/judge/stress_rows.h"

#define TIP(force) ROD IN_ONE "loads: {tip: {force: [\"" force "\", 0, 0]}}\n" BESIDE
/* The rod of configs/cantilever_periods.yaml; a period is 1.787 */
#define SWINGING(duration, windows)                                                                \
    ROD "loads: {tip: {force: [\"-where(0.9-t, sin(pi*t/1.8)^2, 1)\", 0, 0]}}\n"                   \
        "time: {duration: " duration ", windows: " windows "}\n"
#define DEFLECTION "a hundredth of the deflection; Euler and Bernoulli's modes"

#define OF_THE_KINETIC "of the kinetic energy; nothing damps"

/* The solver takes no rod without rotary inertia. This is that of a round one, length over radius
 * 50, which slows the first mode by 2e-4. */
#define SOLVED_STEPPING(limit)                                                                     \
    .tolerance = (limit), .solver_override = "rod.inertia.rotary=[1e-4, 1e-4, 2e-4]"

static const stress_row rows[] = {
    {"step/at-once", TIP("1e-3"), .write = stress_write_step_at_once, .seconds = 30,
     SOLVED_STEPPING(1e-5), BOTH(SOLVED(1e-5, DEFLECTION))},
    {"step/between-windows", TIP("1e-3*step(t-0.1)"), .overrides = {"time.windows=10"},
     .write = stress_write_step, .seconds = 30, SOLVED_STEPPING(1e-5),
     BOTH(SOLVED(1e-5, DEFLECTION))},
    {"step/within-window", TIP("1e-3*step(t-0.1)"), .write = stress_write_step, .seconds = 30,
     SOLVED_STEPPING(1e-5), BOTH(SOLVED(1e-5, DEFLECTION))},
    {"step/push", TIP("1e-2*(step(t-0.1)-step(t-0.2))"), .overrides = {"time.windows=10"},
     .write = stress_write_push, .seconds = 30, SOLVED_STEPPING(1e-5),
     BOTH(SOLVED(1e-5, DEFLECTION))},
    {"step/blow", TIP("0.1*(step(t-0.1)-step(t-0.11))"), .write = stress_write_blow, .seconds = 30,
     SOLVED_STEPPING(1e-4), BOTH(SOLVED(1e-4, DEFLECTION))},
    {"damping/heavy", TIP("1e-2*t/10"),
     .overrides = {"rod.damping.curvature=[10, 10, 10]", "time.duration=10"},
     .write = stress_write_creep, .seconds = 60, SOLVED_STEPPING(1e-6),
     BOTH(SOLVED(1e-5, DEFLECTION))},
    {"energy/2-periods", SWINGING("3.6", "24"), .measure = stress_energy_drift, .seconds = 30,
     SOLVED_STEPPING(1e-5), PINN = SOLVED(1e-4, OF_THE_KINETIC),
     SOLVER = SOLVED(1e-4, OF_THE_KINETIC)},
    {"energy/10-periods", SWINGING("18", "120"), .measure = stress_energy_drift, .seconds = 300,
     SOLVED_STEPPING(1e-5), .is_long = true, PINN = SOLVED(1e-4, OF_THE_KINETIC),
     SOLVER = SOLVED(1e-4, OF_THE_KINETIC)},
    {"energy/50-periods", SWINGING("90", "600"), .measure = stress_energy_drift, .seconds = 1800,
     SOLVED_STEPPING(1e-5), .is_long = true, PINN = SOLVED(1e-4, OF_THE_KINETIC),
     SOLVER = SOLVED(1e-4, OF_THE_KINETIC)},
    {"windows/of-a-static-scene", PULL, .overrides = {"time.windows=4"}, .quick = true,
     PINN = REFUSED("time.windows: windows divide the duration", "there is no time to divide")},
    {"windows/of-no-length", PULL_MOVED, .overrides = {"time.duration=1e-320", "time.windows=256"},
     .quick = true, PINN = REFUSED("time.duration", "windows of length 0")},
    {"windows/too-long", ROD "loads: {tip: {force: [1e-3, 0, 0]}}\ntime: {duration: 1e5}\n",
     .quick = true, PINN = REFUSED("time.windows", "200 periods in each window, beyond its waves")},
    {"windows/too-few", ROD "loads: {tip: {force: [1, 0, 0]}}\ntime: {duration: 20, windows: 1}\n",
     .overrides = {"network.fourier.features=64"}, .seconds = 30,
     PINN = WARNED(VERDICT_NONE, "11 periods in one window")},
};
const stress_group stress_motions = GROUP("Motions: steps, damping, energy, windows", rows);
