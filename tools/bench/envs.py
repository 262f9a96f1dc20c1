#!/usr/bin/env python3
"""Steps a second of many soft arms at once: environments of this package, and batches of SoRoMoX.

    CPINN_LIBRARY=build/tools/library/libcpinn.so PYTHONPATH=tools/python \\
        tools/bench/envs.py --model runs/soft_arm_control [--soromox PYTHON]

The arm is that of configs/robots/soft_arm_control.yaml: 130 mm of silicone that hangs down, three
chambers, steps of 20 ms. A step of an environment is the robot's, the place of its tip, the reward, the
observation, and now and then a new episode; a step of SoRoMoX is the robot's alone. PYTHON has the
package soromox and its JAX. Everybody takes as many threads as it wants; medians of rounds that take
turns. Processor time is that of all threads.

What each of them computes in a step of 20 ms:
  one-step model   a trained network, 18 states (modes of bending, twist, stretch and shear)
  reduced rod      one step of Radau's method of order 5 of the equations of the same 18 states
  SoRoMoX          piecewise constant strain, 2 segments, 24 states, in steps of Tsitouras's method of
                   order 5 that are as long as stays finite (it is explicit); its default is 0.1 ms
"""
import argparse
import json
import resource
import statistics
import subprocess
import sys
import time

LENGTH, RADIUS, MODULUS, POISSON, DENSITY = 0.13, 0.021, 8e4, 0.45, 1070.0  # m, Pa, kg/m^3
RELAXATION, OFFSET, FORCE, STEP = 0.03, 0.013, 8.0, 0.02  # s, m, N, s


def timed(step, seconds):
    """Wall and processor seconds of a call, over so long."""
    def processor():
        used = resource.getrusage(resource.RUSAGE_SELF)
        return used.ru_utime + used.ru_stime

    calls, wall, cpu = 0, time.perf_counter(), processor()
    while time.perf_counter() - wall < seconds or calls == 0:
        step()
        calls += 1
    return (time.perf_counter() - wall) / calls, (processor() - cpu) / calls


class Environments:
    """Of this package, under actions that are drawn beforehand."""

    def __init__(self, robot, count):
        import numpy
        import cpinn.envs
        self.envs = cpinn.envs.RodVectorEnv(robot, count)
        self.envs.reset(seed=1)
        self.actions = numpy.random.default_rng(1).uniform(-1, 1, (16, *self.envs.action_space.shape))
        self.at = 0

    def step(self):
        self.at = (self.at + 1) % 16
        self.envs.step(self.actions[self.at])


def soromox(count, step, seconds):
    """Prints a line of JSON: seconds of a call, of the processor, and whether numbers are finite."""
    import jax
    jax.config.update("jax_enable_x64", True)
    jnp = jax.numpy
    from soromox.actuation import ThreadlikeActuator, ThreadlikeRouting
    from soromox.systems import PCS, PCSStructure, SystemState
    from soromox.systems.components import CrossSectionGeometry, LinkSpec
    link = LinkSpec(
        cross_section_geometry=CrossSectionGeometry.CIRCULAR, length=LENGTH / 2, density=DENSITY,
        reference_strain=[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], cross_section_coefficients=(RADIUS,),
        cross_section_profile_types=("constant",), cross_section_profile_parameter_counts=(1,),
        cross_section_coefficient_names=("radius",), young_modulus=MODULUS, poisson_ratio=POISSON,
        material_damping_coefficient=RELAXATION * MODULUS)
    around = 3**0.5 / 2 * OFFSET
    chambers = ThreadlikeActuator.tendons(ThreadlikeRouting.linear(
        intercept=jnp.array([[0, OFFSET, 0], [0, -OFFSET / 2, around], [0, -OFFSET / 2, -around]]),
        start_segment_index=0, end_segment_index=(1, 1, 1)))
    robot = PCS(PCS.params_from_links([link, link], gravity=jnp.array([0.0, 0.0, 9.81])),
                PCSStructure(), base_pose=jnp.array([0.5, 0.5, -0.5, 0.5, 0.0, 0.0, 0.0]),
                actuators=chambers)
    pull = jax.random.uniform(jax.random.PRNGKey(1), (16, count, 3), maxval=FORCE)
    advance = jax.jit(jax.vmap(lambda y, u: robot.rollout_to(
        initial_state=SystemState(t=0.0, y=y), u=u, t1=STEP, solver_dt=step, save_dt=STEP).y[-1]))
    state = [jnp.zeros((count, robot.state_size)), 0]

    def call():
        state[:] = [advance(state[0], pull[state[1] % 16]).block_until_ready(), state[1] + 1]

    call()  # compiles
    for _ in range(3):
        call()
    wall, cpu = timed(call, seconds)
    print(json.dumps([wall, cpu, bool(jnp.isfinite(state[0]).all())]))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", help="run of the one-step model")
    parser.add_argument("--scene", default="configs/robots/soft_arm_control.yaml")
    parser.add_argument("--envs", type=int, default=1024)
    parser.add_argument("--seconds", type=float, default=1.0, help="of each round")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--soromox", help="a Python with soromox")
    parser.add_argument("--soromox-envs", type=int, default=1024)
    parser.add_argument("--peer", type=float, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.peer:
        soromox(asked.envs, asked.peer, asked.seconds)
        return
    sides = {}
    if asked.model:
        sides["one-step model"] = Environments(asked.model, asked.envs)
    sides["reduced rod"] = Environments(asked.scene, asked.envs)
    rounds = {name: [] for name in sides}
    for _ in range(asked.rounds):
        for name, side in sides.items():
            rounds[name].append(timed(side.step, asked.seconds))
    for step in (1e-3, 5e-4, 2e-4, 1e-4) if asked.soromox else ():
        name = f"SoRoMoX, {1000 * step:g} ms"
        wall, cpu, finite = json.loads(subprocess.run(
            [asked.soromox, __file__, "--peer", str(step), "--envs", str(asked.soromox_envs),
             "--seconds", str(asked.seconds)], check=True, stdout=subprocess.PIPE).stdout)
        rounds[name + ("" if finite else ", diverges")] = [(wall, cpu)]
    print(f"{'':26}{'arms':>6}{'steps a second':>18}{'processor us a step':>22}"
          f"{'arm seconds a second':>24}")
    for name, found in rounds.items():
        count = asked.envs if name in sides else asked.soromox_envs
        wall, cpu = (statistics.median(x[k] for x in found) for k in range(2))
        print(f"{name:26}{count:6}{count / wall:18.3g}{1e6 * cpu / count:22.3g}"
              f"{STEP * count / wall:24.3g}")


if __name__ == "__main__":
    sys.exit(main())
