"""The Python package: training, solving, families, errors. test_python.py CONFIGS, in an empty folder.
Exit status 77 without numpy."""
import copy
import ctypes
import gc
import os
import pickle
import signal
import threading

from python_testing import FAMILY, configs, raises

import numpy

import cpinn

elastica, moving = configs + "/elastica.yaml", configs + "/cantilever_dynamic.yaml"


seen = []
model = cpinn.train(elastica, threads=1, folder="run", progress=lambda now: seen.append(now.step))
assert model.verdict.outcome == "solved" and model.verdict.reason == "none", model.verdict
assert seen == list(range(1, len(seen) + 1)) and len(seen) > 2
assert list(model.history["step"]) == seen
assert model.history["error"][-1] < 1e-9  # against elliptic integrals

# One point, many, and any shape that numpy broadcasts; a derivative against a difference.
assert model.evaluate("x z", s=0.3)["x"].shape == ()
grid = model.evaluate("x x_s", s=numpy.linspace(0, 0.3, 12).reshape(3, 4))
assert grid["x"].shape == (3, 4)
h = 1e-5
x = model.evaluate("x", s=[0.1 - h, 0.1 + h])["x"]
slope = model.evaluate("x_s", s=0.1)["x_s"]
assert abs((x[1] - x[0]) / (2 * h) - slope) < 1e-8  # h^2 and 1e-16 / h

# Beyond the rod a network means nothing; its length in mm is not its length.
raises(ValueError, "s is 120 m; allowed: 0 to 0.3 m", model.evaluate, "x", s=[0.1, 120])
raises(ValueError, "s is -0.1 m; allowed: 0 to 0.3 m", model.evaluate, "x", s=-0.1)
raises(ValueError, "s is 300 m; allowed: 0 to 0.3 m", cpinn.solve, elastica, [0, 300])

# Kept, opened again, saved; the same numbers to the last bit.
again = cpinn.open("run")
assert again.verdict.outcome == "solved"
assert 0 < again.estimate == model.estimate < 1e-3
assert numpy.array_equal(again.evaluate("r q", s=0.2)["z"], model.evaluate("r q", s=0.2)["z"])
assert numpy.array_equal(again.history["loss"], model.history["loss"])
model.save("saved.h5")
assert numpy.array_equal(cpinn.open("saved.h5").evaluate("z", s=0.1)["z"],
                         model.evaluate("z", s=0.1)["z"])
raises(ValueError, "opened from a checkpoint", again.save, "other.h5")

# The classical solution of the same rod.
s = numpy.linspace(0, 0.3, 5)
solved = cpinn.solve(elastica, s)
assert solved.verdict.outcome == "solved" and solved.estimate < 1e-9
assert abs(solved.values["z"] - model.evaluate("z", s)["z"]).max() < 1e-8

# The same rod, said by a dict; keys that are changed by a dict, with numbers of numpy.
scene = {"rod": {"model": "kirchhoff", "length": 0.3,
                 "stiffness": {"bending": [0.01, 0.01], "torsion": 0.01}},
         "boundary": {"end": {"type": "loaded"}},
         "loads": {"tip": {"force": [0.1, 0, 0]}}}
for length in numpy.linspace(0.2, 0.3, 2):
    by_dict = cpinn.solve(scene, length, overrides={"rod.length": length}).values
    by_text = cpinn.solve(scene, length, overrides=[f"rod.length={length}"]).values
    assert by_dict["x"] == by_text["x"] and by_dict["z"] == by_text["z"]
turned = cpinn.solve(scene, 0.3, overrides={"loads.tip.force": numpy.array([0, 0.1, 0])}).values
assert abs(turned["y"] - by_dict["x"]) < 1e-9
raises(ValueError, "rod.lenght: unknown key; did you mean rod.length?", cpinn.solve,
       {"rod": {**scene["rod"], "lenght": 1}}, 0.1)
raises(TypeError, "is a str; allowed: a dict", cpinn.solve, scene, 0.1, overrides="rod.length=1")

# A column that is pushed from both ends: straight, and buckled where its warning's advice is taken.
column = {"rod": {"model": "kirchhoff", "length": 1, "stiffness": {"bending": [1, 1], "torsion": 1}},
          "boundary": {"end": {"type": "loaded"}}, "loads": {"tip": {"force": [0, 0, -4]}}}
straight = cpinn.solve(column, 1)
assert "perturb 10" in straight.verdict.text and "--" not in straight.verdict.text, straight
assert abs(straight.values["z"] - 1) < 1e-9 and straight.verdict.outcome == "warning"
for buckled in (cpinn.solve(column, 1, perturb=10), cpinn.solve(column, 1, branch=1)):
    assert buckled.verdict.outcome == "solved" and buckled.values["z"] < 0.9, buckled
raises(ValueError, "perturb: is -1", cpinn.solve, column, 1, perturb=-1)
raises(ValueError, "branch: is -1", cpinn.solve, column, 1, branch=-1)

# Unknowns from data: within four deviations of what the data were made with, measure.py.
found = cpinn.identify(configs + "/identify/stiffness.yaml", threads=1)
for name, value in {"bending": 3.1e-3, "torsion": 1.9e-3, "weight": 0.03}.items():
    assert abs(found.values[name] - value) < 4 * found.deviations[name], found
assert found.correlations.shape == (3, 3) and found.correlations[0, 0] == 1
assert found.freedom == 57 and 0.5 < found.chi_squared / found.freedom < 1.5
assert found.verdict.outcome == "solved" and "bending = " in repr(found)
raises(ValueError, "have no unknown", cpinn.identify, elastica)

# Many members of a family.
with open("family.yaml", "w") as file:
    file.write(FAMILY)
family = cpinn.Members("family.yaml", s, tolerance=1e-9)
assert family.names == ["force"]
shapes, results = family.solve([[-0.02], [0.03]])
assert shapes.shape == (2, 5, 13) and results["trusted"].all()
assert family.words(results) == [("members", "none")] * 2
known = cpinn.solve("family.yaml", s, overrides=["parameters.force=-0.02"])
assert abs(shapes[0, :, 2] - known.values["z"]).max() < 1e-9
aim = family.reach(shapes[:, -1, :3], seed=4)
assert aim.results["reached"].all() and abs(aim.parameters[:, 0] - [-0.02, 0.03]).max() < 1e-4
beyond = family.reach([0, 0, 9], fixed={"force": 0.01})
assert not beyond.results["reached"][0] and beyond.parameters[0, 0] == 0.01
raises(ValueError, "'pull' is no parameter", family.reach, [0, 0, 1], fixed={"pull": 1.0})
raises(ValueError, "allowed: (tips, 3)", family.reach, [0, 0])
raises(ValueError, "which one member is wanted", cpinn.solve, "family.yaml", s)
raises(ValueError, "allowed: ascending", cpinn.Members, "family.yaml", s[::-1])

# A network trained for all members: each shape with its error, which is that to a solved one.
cpinn.train("family.yaml", folder="family", threads=1, overrides=[
    "formulation=strain", "network.hidden=[16]", "members.solved=200",
    "training.stages=[{optimizer: adam, steps: 500}]"])
trained = cpinn.Family("family")
raises(ValueError, "in Python cpinn.Family", cpinn.open("family").evaluate, "x", s=0.1)
assert trained.ranges == family.ranges == {"force": (-0.03, 0.03)} and trained.columns == family.columns
assert numpy.array_equal(family.evaluate([[0.01]], s[1:]).values, family.evaluate([[0.01]]).values[:, 1:])
exact = family.solve([[-0.02], [0.03]])[0]
for polish in range(3):
    shapes, answers = trained.evaluate([[-0.02], [0.03]], s, polish=polish, alone=True)
    assert answers["trusted"].all() and not answers["outside"].any()
    off = numpy.linalg.norm((shapes - exact)[:, :, :3], axis=2).max(axis=1)
    assert (off <= 2 * answers["error"] + 1e-6 * 0.3).all(), (off, answers)
assert trained.words(answers) == [("network", "none")] * 2
raises(ValueError, "outside its range", trained.evaluate, [[1.0]], s)
far = cpinn.Family("family", extrapolate=True).evaluate([[0.05]], s)[1]
assert far["outside"].all() and far["trusted"].all()

# Stopped by the caller, and by what the caller raises.
stopped = cpinn.train(moving, progress=lambda now: now.step < 2)
assert stopped.verdict.outcome == "stopped" and stopped.verdict.reason == "unfinished"


def fail(now):
    raise KeyError(now.step)


try:
    cpinn.train(moving, progress=fail)
    raise AssertionError("nothing was raised")
except KeyError:
    pass

# Ctrl-C ends training after the step at work.
threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    cpinn.train(elastica, overrides={"training.stages": [{"optimizer": "adam", "steps": 10**9}]})
    raise AssertionError("nothing was raised")
except KeyboardInterrupt:
    pass

# Copies share what the library has made, which lives as long as one of them; it is not copied itself.
copied = [copy.copy(made) for made in (model, family, trained)]
before = model.evaluate("x", s=0.1)["x"], family.solve([[0.01]])[0], trained.evaluate([[0.01]], s)[0]
del model, family, trained
gc.collect()
model, family, trained = copied
assert model.evaluate("x", s=0.1)["x"] == before[0]
assert numpy.array_equal(family.solve([[0.01]])[0], before[1])
assert numpy.array_equal(trained.evaluate([[0.01]], s)[0], before[2])
for made in copied:
    raises(TypeError, "cannot be copied or pickled", copy.deepcopy, made)
    raises(TypeError, "cannot be copied or pickled", pickle.dumps, made)
assert copy.deepcopy(solved).values["z"][0] == solved.values["z"][0]

# No text or number is taken for the address of what the library has made.
for wrong in ("run", b"run", 5, 2**40, None, model):
    for kind in (cpinn.Model, cpinn.Unknowns, lambda made: cpinn.Solution(made, (), s, s)):
        try:
            kind(wrong)
            raise AssertionError(f"{wrong!r} was taken")
        except ctypes.ArgumentError as error:
            assert "are made by cpinn.open" in str(error), error

# Numbers and texts of which C would see a part.
for threads, kind in ((2**40, ValueError), (2**32 + 1, ValueError), (-1, ValueError), (0, ValueError),
                      (True, TypeError), (1.0, TypeError), ("1", TypeError), (1025, ValueError)):
    for function in (cpinn.train, cpinn.identify, cpinn.Family, cpinn.one_step, cpinn.reduced_rod,
                     lambda path, **named: cpinn.Members(path, s, **named)):
        raises(kind, f"threads: is {threads!r}; allowed: a whole number from 1 to 1024",
               function, "family", threads=threads)
for polish, kind in ((3, ValueError), (-1, ValueError), (2**32, ValueError), (0.5, TypeError),
                     (True, TypeError)):
    raises(kind, "polish: is", trained.evaluate, [[0.01]], s, polish=polish)
for function in (cpinn.open, cpinn.train, cpinn.identify, cpinn.Family, cpinn.one_step,
                 cpinn.reduced_rod, model.evaluate, model.save,
                 lambda path: cpinn.train(elastica, folder=path), lambda path: cpinn.solve(path, s),
                 lambda text: cpinn.train(elastica, [text])):
    raises(ValueError, "has a zero byte", function, "run\0.h5")
assert not os.path.exists("run.h5")

raises(OSError, "cannot be read", cpinn.train, "missing.yaml")
raises(ValueError, "override rod.length=-1: rod.length: is -1", cpinn.train, elastica,
       ["rod.length=-1"])
raises(ValueError, "there is a run already", cpinn.train, elastica, folder="run")
raises(ValueError, "bend is no column", model.evaluate, "bend", 0.1)
raises(OSError, "missing.h5", cpinn.open, "missing.h5")
raises(ValueError, "surrogate: is of a one-step model",
       cpinn.train, configs + "/robots/soft_arm_control.yaml")
raises(TypeError, "is of type int; allowed: str or a path", cpinn.open, 3)

# Numbers that are none, of another type, or of other shapes.
for bad in (numpy.nan, numpy.inf, [0.1, numpy.nan]):
    raises(ValueError, "finite", model.evaluate, "x", bad)
    raises(ValueError, "finite", cpinn.solve, elastica, bad)
    raises(ValueError, "finite", trained.evaluate, [[0.01]], bad)
    raises(ValueError, "finite", trained.evaluate, numpy.reshape(bad, (-1, 1)), s)
    raises(ValueError, "finite", family.solve, {"force": bad})
for bad in ("0.1", 1j, [None], object()):
    raises(TypeError, "real numbers", model.evaluate, "x", bad)
    raises(TypeError, "real numbers", family.solve, {"force": bad})
raises(ValueError, "broadcast", model.evaluate, "x", [0.1, 0.2], [0.1, 0.2, 0.3])
raises(ValueError, "at names push; allowed: each of force", trained.evaluate, {"push": 0.1}, s)
raises(ValueError, "not finite", cpinn.solve, {"rod": {"length": numpy.nan}}, 0.1)
raises(TypeError, "of type object", cpinn.solve, {"rod": {"length": object()}}, 0.1)
for bad, kind in ((0, ValueError), (-1, ValueError), (numpy.nan, ValueError), ("x", TypeError)):
    raises(kind, "tolerance: is", cpinn.solve, elastica, 0.1, tolerance=bad)
    raises(kind, "tolerance: is", cpinn.Members, "family.yaml", s, tolerance=bad)
assert issubclass(cpinn.InputError, ValueError) and issubclass(cpinn.FileError, OSError)

# Members by name are those of an array; everything prints itself.
by_name = trained.evaluate(at={"force": [-0.02, 0.03]}, s=s)
assert numpy.array_equal(by_name.values, trained.evaluate(numpy.array([[-0.02], [0.03]]), s).values)
for made, said in ((model, "solved, error about"), (family, "Members of force from -0.03 to 0.03"),
                   (trained, "Family of force from -0.03 to 0.03"), (solved, "solved, error")):
    assert said in repr(made), repr(made)
assert "Progress(step=1" in repr(cpinn.Progress(1, *[1] * 9))

# Different objects in different threads at once, to the same bits.
results = [None] * 4


def evaluate(place):
    results[place] = cpinn.open("run").evaluate("z", s)["z"]


threads = [threading.Thread(target=evaluate, args=(place,)) for place in range(4)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert all(numpy.array_equal(found, model.evaluate("z", s)["z"]) for found in results)

# Pictures, or why there are none.
try:
    import matplotlib
    matplotlib.use("Agg")
    for axes in (model.plot(s), solved.plot(), family.plot([[0.01], [0.02]]),
                 trained.plot({"force": [0.01, 0.02]}, s, color="k")):
        assert axes.get_xlabel() in ("x (m)", "z (m)") and len(axes.lines) in (1, 2)
    assert numpy.array_equal(solved.plot().lines[0].get_ydata(), solved.values["z"])
except ImportError:
    try:
        model.plot(s)
        raise AssertionError("nothing was raised")
    except ImportError as error:
        assert "pip install matplotlib" in str(error)

# Types, where what checks them is installed.
try:
    import gymnasium  # noqa: F401
    import mypy.api
except ImportError:
    print("types are not checked: no mypy or gymnasium")
else:
    os.environ["MYPYPATH"] = os.path.dirname(os.path.dirname(cpinn.__file__))
    said, complaints, status = mypy.api.run(["--strict", "--ignore-missing-imports", "-p", "cpinn"])
    assert status == 0, said + complaints
assert cpinn.version()
