#!/usr/bin/env python3
"""One training step of a rod in motion, value and gradient, and one Gauss-Newton step of a smaller
network: the tape, against the rate of its products, and on demand the same step in PyTorch and JAX.
Everybody takes turns with the tape, so that a busy moment slows both of a pair.

The peers need Python with numpy, torch and jax:
    python3 -m venv peers && peers/bin/pip install numpy torch jax
    step.py --peers --python peers/bin/python3
Ratios are to the tape with all threads (interpreted: to the tape with as many), each round by itself:
median, least and most.

What every side computes: loss and parameter gradient of one Cosserat rod in motion, displacement form,
clamped at both ends, under its weight, a network of tanh with linear output, double precision.
Everything is dimensionless (length, bending stiffness and mass per length are 1), so that
physics/rod/rod.h reads

    x = (0, 0, s) + f y_1..3,   p = (1, 0, 0, 0) + f y_4..7,   f = s (1 - s) (t / duration)^2
    q = p/|p|,  v = R(q)^T x_s,  u = 2 vec(q* q_s),  w = 2 vec(q* q_t),
    n = K (v - e3),  m = C u,  N = R(q) n
    force = N_s + weight - x_tt,   moment = m_s + u x m + v x n - J w_t - w x (J w)
    loss = mean over the points of force_weight |force|^2 + moment_weight |moment|^2

where y is the network of (2 s - 1, 2 t / duration - 1). Parameters are layer after layer weights
[out][in], bias [out]."""
import argparse
import array
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.realpath(__file__))
PEERS = os.path.join(HERE, "peers")
os.environ["PATH"] += os.pathsep + os.path.join(HERE, "../../build/tools/bench")
# A round rod of length / radius = 20 with nu = 0.3, as in configs/cantilever_dynamic.yaml.
ROD = {"strain_stiffness": [545.4545454545455, 545.4545454545455, 1600],
       "curvature_stiffness": [1, 1, 0.7692307692307692],
       "rotary_inertia": [0.000625, 0.000625, 0.00125], "weight": [0.5, -1, 0.25], "duration": 1,
       "force_weight": 1, "moment_weight": 2}
# After the slash: points in a chunk. Which size is best depends on what a library keeps.
GRADIENTS = [("PyTorch, nested reverse mode", "peer_torch.py", "nested/2048"),
             ("PyTorch, coefficients by hand", "peer_torch.py", "coefficients"),
             ("  the same in chunks of 1024", "peer_torch.py", "coefficients/1024"),
             ("JAX, coefficients by hand", "peer_jax.py", "coefficients"),
             ("  the same in chunks of 256", "peer_jax.py", "coefficients/256"),
             ("JAX, nested forward, chunks", "peer_jax.py", "jvp/256"),
             ("JAX, jet, chunks of 256", "peer_jax.py", "jet/256")]
NORMALS = [("PyTorch, vmap of jacrev", "peer_torch.py", "gn-jacrev"),
           ("PyTorch, batched rows", "peer_torch.py", "gn-rows"),
           ("JAX, vmap of jacrev", "peer_jax.py", "gn-jacrev"),
           ("JAX, vmap of jacfwd", "peer_jax.py", "gn-jacfwd")]


def fail(text):
    sys.exit(f"step: {text}")


def parameters(count):
    """Uniform within 0.2 of 0, from Knuth's MMIX generator: the same for every side and machine."""
    numbers, seed = array.array("d"), 1
    for _ in range(count):
        seed = (seed * 6364136223846793005 + 1442695040888963407) % 2 ** 64
        numbers.append(0.4 * ((seed >> 11) * 2.0 ** -53 - 0.5))
    return numbers


def write_case(folder, hidden, width, points):
    widths = [2] + [width] * hidden + [7]
    count = sum(m * k + m for k, m in zip(widths, widths[1:]))
    shear, _, axial = ROD["strain_stiffness"]
    bending, _, torsion = ROD["curvature_stiffness"]
    with open(os.path.join(folder, "scene.yaml"), "w") as file:
        file.write(f"""\
rod:
  model: cosserat
  length: 1
  stiffness: {{shear: [{shear!r}, {shear!r}], axial: {axial}, bending: [{bending}, {bending}], torsion: {torsion!r}}}
  inertia: {{mass_per_length: 1, rotary: {ROD['rotary_inertia']}}}
boundary: {{end: {{type: clamped, position: [0, 0, 1], rotation: [1, 0, 0, 0]}}}}
loads: {{gravity: {ROD['weight']}}}
time: {{duration: {ROD['duration']}, windows: 1}}
formulation: displacement
losses:
  held_out_points: 1
  interior: {{points: {points}, weights: {{force: {ROD['force_weight']}, moment: {ROD['moment_weight']}}}}}
network: {{activation: tanh, hidden: {[width] * hidden}}}
""")
    with open(os.path.join(folder, "case.json"), "w") as file:
        json.dump({"points": points, "parameters": count, "width": width, "hidden": hidden, **ROD}, file)
    with open(os.path.join(folder, "x.bin"), "wb") as file:
        parameters(count).tofile(file)


class Side:
    """A process that makes one step, and says its seconds, whenever it is asked."""

    def __init__(self, name, threads, *command):
        self.name, self.threads, self.remark, self.process = name, threads, "", None
        try:
            self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                            text=True)
        except OSError as error:
            self.remark = f"not installed: {command[0]}: {error.strerror}"
            return
        self.greeting = self.process.stdout.readline().strip()

    def step(self):
        try:
            self.process.stdin.write("step\n")
            self.process.stdin.flush()
            return float(self.process.stdout.readline())
        except (OSError, ValueError):
            return None

    def stop(self):
        """Also says how much memory it had, bytes."""
        if not self.process:
            return 0
        try:
            self.process.stdin.close()
        except OSError:
            pass
        self.process.stdout.close()
        _, status, usage = os.wait4(self.process.pid, 0)
        self.process.returncode = os.waitstatus_to_exitcode(status)
        return 1024.0 * usage.ru_maxrss  # kilobytes on Linux


def tape(name, folder, kind, threads):
    side = Side(name, threads, shutil.which("step_tape") or fail("step_tape is not on the path"), folder,
                kind, str(threads))
    if not side.greeting:
        side.stop()
        sys.exit(1)
    side.about = json.loads(side.greeting)
    if kind != "interpreted":
        print(f"groups of {side.about['fused']} of {side.about['programs']} programs compiled and loaded")
    with open(os.path.join(folder, "case.bin"), "rb") as file:
        side.answer = file.read()
    return side


def peer(kind, asked, folder):
    name, script, method = kind
    side = Side(name, asked.threads, asked.python, "-B", os.path.join(PEERS, script), folder, method,
                str(asked.threads))
    if side.process:
        word, _, rest = side.greeting.partition(" ")
        side.differs, side.first = map(float, rest.split()) if word == "ready" else (None, None)
        side.remark = ("" if word == "ready" else f"not installed: {rest}" if word == "missing" else
                       f"failed: {rest or 'ended early'}")
    return side


def turns(reference, side, rounds):
    """[(seconds, ratio)] of steps in turn, after one of each that warms up; None: one has ended."""
    rows = []
    for _ in range(rounds + 1):
        ours, theirs = reference.step(), side.step()
        if ours is None or theirs is None:
            return None
        rows.append((theirs, theirs / ours))
    return rows[1:]


def print_row(side, reference, asked, points, flops=None, rate=None):
    rows = None if side.remark else turns(reference, side, asked.rounds)
    if not rows:
        print(f"{side.name:30} {side.threads:7} {side.remark or 'failed: it ended during a step'}",
              flush=True)
        return
    seconds, ratios = (sorted(column) for column in zip(*rows))
    seconds = statistics.median(seconds)
    done = flops and flops * points / seconds
    cells = [f"{1e6 * seconds / points:10.3f}", f"{1e-9 * done:8.1f}" if flops else f"{'-':>8}",
             f"{done / (rate * side.threads):9.3f}" if flops else f"{'-':>9}",
             f"{statistics.median(ratios):8.3f}", f"{ratios[0]:8.3f}..{ratios[-1]:<7.3f}",
             f"{side.differs:8.0e}" if hasattr(side, "differs") else f"{'-':>8}",
             f"{side.first:9.2f}" if hasattr(side, "first") else f"{'-':>9}"]
    print(f"{side.name:30} {side.threads:7} " + " ".join(cells), flush=True)


def print_header():
    print(f"\n{'':30} {'threads':>7} {'us/point':>10} {'Gflop/s':>8} {'of rate':>9} {'/ tape':>8} "
          f"{'least..most':>17} {'differs':>8} {'first, s':>9}")


def print_peers(kinds, reference, asked, folder, points, flops=None, rate=None):
    for kind in kinds if asked.peers else []:
        side = peer(kind, asked, folder)
        print_row(side, reference, asked, points, flops, rate)
        side.stop()


def compare_gradients(asked, folder):
    rates = json.loads(subprocess.run(["step_tape", "-", "rates", "1"], stdout=subprocess.PIPE,
                                      check=True).stdout)
    rate = max(rates["own"][1], rates["openblas"][1])
    write_case(folder, 4, 64, asked.points)
    ours = tape("tape", folder, "gradient", asked.threads)
    flops = ours.about["flops"]
    print(f"loss and gradient: network 2-64-64-64-64-7, {asked.points} points; products of a step: "
          f"{flops:.0f} flops/point; {ours.about['instructions']} instructions, tiles of "
          f"{ours.about['tile']} points\nproducts of 64 x 64 weights, one thread: "
          f"{1e-9 * rates['own'][1]:.1f} Gflop/s by the tape's own ({rates['own'][0]}), "
          f"{1e-9 * rates['openblas'][1]:.1f} by OpenBLAS ({rates['openblas'][0]})")
    print_header()
    for threads in sorted({asked.threads, 1}, reverse=True):
        side = ours if threads == asked.threads else tape("tape", folder, "gradient", threads)
        plain = tape("tape, interpreted", folder, "interpreted", threads)
        if not ours.answer == side.answer == plain.answer:
            fail("the same step gives different bits, interpreted or with another number of threads")
        print_row(side, ours, asked, asked.points, flops, rate)
        print_row(plain, side, asked, asked.points, flops, rate)
        plain.stop()
        if side is not ours:
            side.stop()
    print_peers(GRADIENTS, ours, asked, folder, asked.points, flops, rate)
    ours.stop()


def compare_normals(asked, folder):
    write_case(folder, 3, 32, asked.normal_points)
    ours = tape("tape, J^T J and Cholesky", folder, "normal", asked.threads)
    print(f"\nGauss-Newton: network 2-32-32-32-7 ({ours.about['parameters']} parameters), "
          f"{asked.normal_points} points")
    print_header()
    print_row(ours, ours, asked, asked.normal_points)
    print_peers(NORMALS, ours, asked, folder, asked.normal_points)
    ours.stop()


def measure_memory(asked, folder):
    """What a run needs beside its points, and the numbers that depend on points alone, is tiles and
    sums, whose number is bounded: the process may grow by the points, and by half as much for the
    bounded rest and the page tables."""
    few, many, peaks = 10_000, 1_000_000, []
    for points in few, many:
        write_case(folder, 4, 64, points)
        side = tape("tape", folder, "interpreted", asked.threads)
        peaks.append(side.stop())
    grown, numbers = peaks[1] - peaks[0], side.about["numbers"]
    needed = 8.0 * (many - few) * numbers
    print(f"peak memory: {1e-6 * peaks[0]:.1f} MB at {few} points, {1e-6 * peaks[1]:.1f} MB at {many}: "
          f"growth {1e-6 * grown:.1f} MB, of which points, {numbers} numbers each, {1e-6 * needed:.1f} MB")
    if grown > 1.5 * needed:
        fail("memory grows with the points by more than the points")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default, text in [("points", 16384, "of the gradient's step"),
                                ("normal-points", 1024, "of the Gauss-Newton step"),
                                ("threads", 2, "of everybody"), ("rounds", 15, "steps of each pair")]:
        parser.add_argument(f"--{name}", type=int, default=default, help=f"{text} ({default})")
    parser.add_argument("--peers", action="store_true", help="PyTorch and JAX as well, Gauss-Newton too")
    parser.add_argument("--python", default="python3", help="that runs the peers (python3)")
    parser.add_argument("--memory", action="store_true",
                        help="instead: growth of the process from 10,000 to 1,000,000 points")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if asked.memory:
            measure_memory(asked, folder)
            return
        compare_gradients(asked, folder)
        if asked.peers:
            compare_normals(asked, folder)


main()
