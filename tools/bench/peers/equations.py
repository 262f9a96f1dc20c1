"""DeepXDE on the scenes of configs/equations, by the recipes of its own examples, in single precision as
they are. Appends rows to a CSV file: case, method with its threads, wall seconds, CPU seconds, relative L2 error at the
places of the reference. The residual and the conditions come from the scene.

    pip install deepxde torch numpy scipy
    python3 tools/bench/peers/equations.py burgers --out configs/equations/peers.csv [--threads 2] [--seed 1] [--double]

CPU seconds are those of all threads; on a machine that does other work wall seconds say little."""
import argparse
import os
import pathlib
import re
import sys
import time

# case: hidden layers, activation, initializer, points inside, on faces, at the start, Adam's steps.
# Burgers.py, Allen_Cahn.py, Helmholtz_Dirichlet_2d.py (ten points a wave) and wave_1d.py of DeepXDE's
# examples/pinn_forward; the last two have Adam alone, L-BFGS is added here. Adam's rate is 1e-3.
RECIPES = {
    "burgers": ([20] * 3, "tanh", "Glorot normal", 2540, 80, 160, 15000),
    "allen_cahn": ([20] * 3, "tanh", "Glorot normal", 8000, 400, 800, 40000),
    "helmholtz": ([150] * 3, "sin", "Glorot uniform", 1600, 160, 0, 5000),
    "wave": ([100] * 3, "tanh", "Glorot uniform", 360, 360, 360, 10000),
    "convection_30": ([20] * 3, "tanh", "Glorot normal", 2540, 80, 160, 15000),
    "klein_gordon": ([40] * 2, "tanh", "Glorot normal", 2540, 80, 160, 15000),
}
# Helmholtz: zero on its faces by a factor. Allen-Cahn: the start is exact, as in the example, whose
# ends are held; here they are periodic, by conditions of value and slope.
HARD = {"helmholtz": lambda x, y, start: (1 - x[:, :1] ** 2) * (1 - x[:, 1:] ** 2) * y,
        "allen_cahn": lambda x, y, start: start(x[:, :1]) + x[:, 1:] * y}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("case", choices=RECIPES)
    parser.add_argument("--out", required=True)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--double", action="store_true")
    parser.add_argument("--adam", type=int, help="steps of Adam, for a short try")
    given = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = str(given.threads)
    os.environ["OMP_WAIT_POLICY"] = "passive"  # threads that wait take no CPU time
    os.environ["GOMP_SPINCOUNT"] = "0"
    os.environ["DDE_BACKEND"] = "pytorch"
    folder = pathlib.Path(__file__).resolve().parents[3] / "configs" / "equations"
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(folder))
    import deepxde as dde
    import numpy as np
    import reference
    import torch

    torch.set_num_threads(given.threads)
    dde.config.set_random_seed(given.seed)
    if given.double:
        dde.config.set_default_float("float64")
    scene = reference.Scene((folder / f"{given.case}.yaml").read_text())
    truth = np.loadtxt(folder / "reference" / f"{given.case}.csv", delimiter=",", skiprows=0,
                       comments=["#", next(iter(scene.ranges))])
    coordinates = list(scene.ranges)
    moving = "t" in coordinates
    hidden, activation, initializer, inside, faces, start, adam = RECIPES[given.case]

    def evaluate(text, names, library):
        functions = {name: getattr(library, name) for name in ("sin", "cos", "exp")}
        return eval(text.replace("^", "**"), {"__builtins__": {}, "pi": np.pi, **functions},
                    {**scene.numbers, **names})

    def columns(x):
        return {name: x[:, i:i + 1] for i, name in enumerate(coordinates)}

    def derivative(word, x, u):
        for letter in word.partition("_")[2]:
            u = dde.grad.jacobian(u, x, i=0, j=coordinates.index(letter))
        return u

    words = set(re.findall(rf"\b{scene.field}(?:_\w+)?\b", scene.inside))

    def pde(x, u):
        dde.grad.clear()
        return evaluate(scene.inside, {**columns(x), **{word: derivative(word, x, u) for word in words}}, torch)

    if moving:
        low, high = scene.ranges["x"]
        line = dde.geometry.Interval(low, high)
        domain = dde.geometry.GeometryXTime(line, dde.geometry.TimeDomain(*scene.ranges["t"]))
    else:
        domain = dde.geometry.Rectangle(*zip(*scene.ranges.values()))
    conditions = []

    def condition(face, at, of, text):
        axis = coordinates.index(face)

        def values(x):
            return evaluate(text, columns(x), np) + 0 * x[:, :1]

        def on(x, _):
            return np.isclose(x[axis], at)

        if "_" in of:
            return dde.icbc.OperatorBC(
                domain, lambda x, u, X: derivative(of, x, u) - torch.as_tensor(values(X)).to(u), on)
        return (dde.icbc.IC if face == "t" else dde.icbc.DirichletBC)(domain, values, on)

    if given.case != "helmholtz":
        conditions = [condition(*row) for row in scene.conditions if not (given.case in HARD and row[0] == "t")]
    if moving and not any(face == "x" for face, *_ in scene.conditions):
        for order in (0, 1):
            conditions.append(dde.icbc.PeriodicBC(domain, 0, lambda _, on: on, derivative_order=order))
    count = {"num_domain": inside, "num_boundary": faces, **({"num_initial": start} if moving else {})}
    data = (dde.data.TimePDE if moving else dde.data.PDE)(domain, pde, conditions, **count)
    net = dde.nn.FNN([len(coordinates)] + hidden + [1], activation, initializer)
    if given.case in HARD:
        first = next((text for face, _, of, text in scene.conditions if face == "t"), "0")
        net.apply_output_transform(
            lambda x, y: HARD[given.case](x, y, lambda at: evaluate(first, {"x": at}, torch)))
    model = dde.Model(data, net)
    clock = {"wall": time.perf_counter(), "cpu": time.process_time()}
    place = np.ascontiguousarray(truth[:, :-1])

    class Watch(dde.callbacks.Callback):
        """A row every thousand steps; what looking takes is taken off the clocks."""

        def __init__(self, method):
            super().__init__()
            self.method, self.seen = method, 0

        def look(self):
            wall, cpu = time.perf_counter(), time.process_time()
            u = model.predict(place)[:, 0]
            error = np.linalg.norm(u - truth[:, -1]) / np.linalg.norm(truth[:, -1])
            with open(given.out, "a", encoding="ascii") as out:
                out.write(f"{given.case},{self.method},{wall - clock['wall']:.1f},"
                          f"{cpu - clock['cpu']:.1f},{error:.3e}\n")
            clock["wall"] += time.perf_counter() - wall
            clock["cpu"] += time.process_time() - cpu

        def on_epoch_end(self):
            self.seen += 1
            if "L-BFGS" in self.method or self.seen % 1000 == 0:
                self.look()

    if not os.path.exists(given.out):
        pathlib.Path(given.out).write_text("case,method,wall,cpu,error\n")
    kind = ("; double" if given.double else "") + f"; {given.threads} thread" + "s" * (given.threads > 1)
    model.compile("adam", lr=1e-3)
    model.train(iterations=given.adam or adam, display_every=5000, callbacks=[Watch("DeepXDE; Adam" + kind)])
    model.compile("L-BFGS")
    model.train(display_every=5000, callbacks=[Watch("DeepXDE; L-BFGS" + kind)])


main()
