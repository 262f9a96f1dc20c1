"""The Python package: test_python.py CONFIGS, in an empty folder. Exit status 77 without numpy."""
import copy
import ctypes
import gc
import os
import pickle
import signal
import sys
import threading

try:
    import numpy
except ImportError:
    sys.exit(77)
import cpinn

configs = sys.argv[1]
elastica, moving = configs + "/elastica.yaml", configs + "/cantilever_dynamic.yaml"


def raises(text, function, *arguments, **named):
    try:
        function(*arguments, **named)
    except cpinn.Error as error:
        assert text in str(error), str(error)
    else:
        raise AssertionError(f"{text}: nothing was raised")


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
raises("s is 120 m; allowed: 0 to 0.3 m", model.evaluate, "x", s=[0.1, 120])
raises("s is -0.1 m; allowed: 0 to 0.3 m", model.evaluate, "x", s=-0.1)
raises("s is 300 m; allowed: 0 to 0.3 m", cpinn.solve, elastica, [0, 300])

# Kept, opened again, saved; the same numbers to the last bit.
again = cpinn.open("run")
assert again.verdict.outcome == "solved"
assert 0 < again.estimate == model.estimate < 1e-3
assert numpy.array_equal(again.evaluate("r q", s=0.2)["z"], model.evaluate("r q", s=0.2)["z"])
assert numpy.array_equal(again.history["loss"], model.history["loss"])
model.save("saved.h5")
assert numpy.array_equal(cpinn.open("saved.h5").evaluate("z", s=0.1)["z"],
                         model.evaluate("z", s=0.1)["z"])
raises("opened from a checkpoint", again.save, "other.h5")

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
raises("rod.lenght: unknown key; did you mean rod.length?", cpinn.solve,
       {"rod": {**scene["rod"], "lenght": 1}}, 0.1)
raises("is a str; allowed: a dict", cpinn.solve, scene, 0.1, overrides="rod.length=1")

# Unknowns from data: within four deviations of what the data were made with, measure.py.
found = cpinn.identify(configs + "/identify/stiffness.yaml", threads=1)
for name, value in {"bending": 3.1e-3, "torsion": 1.9e-3, "weight": 0.03}.items():
    assert abs(found.values[name] - value) < 4 * found.deviations[name], found
assert found.correlations.shape == (3, 3) and found.correlations[0, 0] == 1
assert found.freedom == 57 and 0.5 < found.chi_squared / found.freedom < 1.5
assert found.verdict.outcome == "solved" and "bending = " in repr(found)
raises("have no unknown", cpinn.identify, elastica)

# Many members of a family.
with open("family.yaml", "w") as file:
    file.write("""parameters: {force: {range: [-0.03, 0.03]}}
rod: {model: kirchhoff, length: 0.3, section: {shape: circle, radius: 0.005},
      material: {youngs_modulus: 1.0e6, poissons_ratio: 0.45}}
boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}, end: {type: loaded}}
loads: {tip: {force: [0, 0, force]}}
""")
family = cpinn.Members("family.yaml", s, tolerance=1e-9)
assert family.names == ["force"]
shapes, results = family.solve([[-0.02], [0.03]])
assert shapes.shape == (2, 5, 13) and results["solved"].all() and (results["load"] == 1).all()
known = cpinn.solve("family.yaml", s, overrides=["parameters.force=-0.02"])
assert abs(shapes[0, :, 2] - known.values["z"]).max() < 1e-9
raises("which one member is wanted", cpinn.solve, "family.yaml", s)
raises("allowed: ascending", cpinn.Members, "family.yaml", s[::-1])

# A network trained for all members: each shape with its error, which is that to a solved one.
cpinn.train("family.yaml", folder="family", threads=1, overrides=[
    "formulation=strain", "network.hidden=[16]", "members.solved=200",
    "training.stages=[{optimizer: adam, steps: 500}]"])
trained = cpinn.Family("family")
raises("in Python cpinn.Family", cpinn.open("family").evaluate, "x", s=0.1)
assert list(trained.ranges) == ["force"] and trained.columns == cpinn.Members.columns
exact = family.solve([[-0.02], [0.03]])[0]
for polish in range(3):
    shapes, answers = trained.evaluate([[-0.02], [0.03]], s, polish=polish, alone=True)
    assert answers["trusted"].all() and not answers["outside"].any()
    off = numpy.linalg.norm((shapes - exact)[:, :, :3], axis=2).max(axis=1)
    assert (off <= 2 * answers["error"] + 1e-6 * 0.3).all(), (off, answers)
assert trained.words(answers) == [("network", "none")] * 2
raises("outside its range", trained.evaluate, [[1.0]], s)
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
    raises("cannot be copied or pickled", copy.deepcopy, made)
    raises("cannot be copied or pickled", pickle.dumps, made)
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
for threads in (2**40, 2**32 + 1, -1, 0, True, 1.0, "1", 1025):
    for function in (cpinn.train, cpinn.identify, cpinn.Family, lambda path, **named:
                     cpinn.Members(path, s, **named)):
        raises(f"threads: is {threads!r}; allowed: a whole number from 1 to 1024",
               function, "family", threads=threads)
for polish in (3, -1, 2**32, 0.5, True):
    raises("polish: is", trained.evaluate, [[0.01]], s, polish=polish)
for function in (cpinn.open, cpinn.train, cpinn.identify, cpinn.Family, model.evaluate, model.save,
                 lambda path: cpinn.train(elastica, folder=path), lambda path: cpinn.solve(path, s),
                 lambda text: cpinn.train(elastica, [text])):
    raises("has a zero byte", function, "run\0.h5")
assert not os.path.exists("run.h5")

raises("cannot be read", cpinn.train, "missing.yaml")
raises("rod.length: is -1", cpinn.train, elastica, ["rod.length=-1"])
raises("there is a run already", cpinn.train, elastica, folder="run")
raises("bend is no column", model.evaluate, "bend", 0.1)
raises("missing.h5", cpinn.open, "missing.h5")
assert cpinn.version()
