"""What an installed wheel does: wheel.py VERSION, by the Python of its environment, in an empty folder."""
import importlib.metadata
import os
import shutil
import subprocess
import sys
import threading

import numpy

import cpinn

version = sys.argv[1]
package = os.path.dirname(cpinn.__file__)
assert package.startswith(sys.prefix), package
assert cpinn.version() == importlib.metadata.version("cpinn") == version
assert shutil.which("cc") is None and shutil.which("sh") is None


def mapped(*words):
    """The files in memory whose names have one of the words."""
    with open("/proc/self/maps") as maps:
        files = {line.split(None, 5)[5].strip() for line in maps if line.count("/")}
    return sorted(file for file in files if any(word in os.path.basename(file) for word in words))


def run(status, *command):
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == status, (command, done.returncode, done.stdout, done.stderr)
    return done.stdout


# ---- what is in it --------------------------------------------------------------------------------

assert os.path.exists(os.path.join(package, "py.typed"))
licences = os.listdir(os.path.join(package, "licenses"))
for carried in ("hdf5", "sundials", "yaml", "zlib", "aec", "openblas", "gfortran", "quadmath"):
    assert any(carried in name for name in licences), (carried, licences)
# Nothing of the system but its C library, and OpenBLAS only when it is first needed.
assert not mapped("hdf5", "sundials", "yaml", "cpinn_openblas"), mapped("")
assert os.path.isfile(cpinn.example("soft_arm"))
try:
    cpinn.example("hard_arm")
    raise AssertionError("nothing was raised")
except cpinn.Error as error:
    assert "soft_arm" in str(error)
scripts = [entry.name for entry in importlib.metadata.distribution("cpinn").entry_points]
assert len(scripts) >= 12
for name in scripts:
    assert run(0, name, "--version") == f"{name} {version}\n"

# ---- solve, train, evaluate -----------------------------------------------------------------------

elastica, moving = cpinn.example("elastica"), cpinn.example("cantilever_dynamic")
s = numpy.linspace(0, 1, 11)
solved = cpinn.solve(moving, s=1, t=[0.5, 1])
model = cpinn.train(moving, threads=2, folder="moving")
values = model.evaluate("x z", s=1, t=[0.5, 1])
assert model.verdict.outcome == "solved" and solved.verdict.outcome == "solved"
# Both are within 1e-5 of the length by their own estimates.
assert abs(values["z"] - solved.values["z"]).max() < 1e-5
exact = cpinn.train(elastica)
assert exact.history["error"][-1] < 1e-9  # against elliptic integrals
assert cpinn.open("moving").evaluate("z", s=1, t=1)["z"] == values["z"][1]

# ---- one thread pool beside numpy's ---------------------------------------------------------------

# The OpenBLAS of cpinn is another library than that of numpy, and neither changes the other's results,
# while both work at once.
assert len(mapped("cpinn_openblas")) == 1
assert len(mapped("openblas", "mkl")) == 2, mapped("blas")
matrix = numpy.random.default_rng(0).standard_normal((400, 400))
product, busy = matrix @ matrix, True
products = []


def multiply():
    while busy:
        products.append(numpy.array_equal(matrix @ matrix, product))


thread = threading.Thread(target=multiply)
thread.start()
again = cpinn.train(moving, threads=1)
busy = False
thread.join()
assert all(products) and len(products) > 2
assert numpy.array_equal(again.evaluate("x z", s=1, t=[0.5, 1])["z"], values["z"])

# ---- a family -------------------------------------------------------------------------------------

scene = {"parameters": {"force": {"range": [-0.03, 0.03]}},
         "rod": {"model": "kirchhoff", "length": 0.3, "section": {"shape": "circle", "radius": 0.005},
                 "material": {"youngs_modulus": 1.0e6, "poissons_ratio": 0.45}},
         "boundary": {"start": {"type": "clamped", "rotation": [0, 1, 0, 1]}, "end": {"type": "loaded"}},
         "loads": {"tip": {"force": [0, 0, "force"]}}, "formulation": "strain",
         "network": {"hidden": [16]}, "members": {"solved": 200},
         "training": {"stages": [{"optimizer": "adam", "steps": 500}]}}
s = numpy.linspace(0, 0.3, 5)
cpinn.train(scene, folder="family")
shapes, answers = cpinn.Family("family").evaluate([[-0.02], [0.03]], s, alone=True)
exact, _ = cpinn.Members(scene, s, tolerance=1e-9).solve([[-0.02], [0.03]])
assert answers["trusted"].all()
off = numpy.linalg.norm((shapes - exact)[:, :, :3], axis=2).max(axis=1)
assert (off <= 2 * answers["error"] + 1e-6 * 0.3).all()  # what an answer that is trusted may be off by

# ---- the programs ---------------------------------------------------------------------------------

assert "error" in run(0, "cpinn-eval", "moving", "--grid", "3x3", "--out", "moving.csv")
run(0, "cpinn-solve", moving, "--grid", "3x3", "--out", "solved.csv")
tables = [numpy.genfromtxt(name, delimiter=",", names=True) for name in ("moving.csv", "solved.csv")]
assert abs(tables[0]["z"] - tables[1]["z"]).max() < 1e-5 and len(tables[0]) == 9
run(0, "cpinn-export", "moving", "--c", "tip")
assert all(os.path.getsize(name) for name in ("tip.c", "tip.h", "tip_selftest.c"))
said = run(0, "cpinn-control", cpinn.example("soft_arm_control"), "--set", "control.model=reduced",
           "--set", "control.duration=1.4")
assert "71 periods of 20 ms" in said
assert os.path.getsize("moving/checkpoint.h5")
run(0, "cpinn-show", "moving", "--out", "moving.svg")
assert "<svg" in open("moving.svg").read()
