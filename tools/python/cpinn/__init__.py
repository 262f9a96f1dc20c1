"""Physics-informed neural networks for beams and Cosserat rods.

    import cpinn
    model = cpinn.train("cantilever.yaml", threads=2)     # or cpinn.open("runs/cantilever")
    print(model.verdict)                                  # solved, or a warning with its reason
    values = model.evaluate("z r_tt", s=1, t=[0.5, 1])    # {"z": array, "x_tt": array, ...}
    exact = cpinn.solve("cantilever.yaml", s=[0.5, 1], t=1).values["z"]
    softer = cpinn.solve("cantilever.yaml", s=1, t=1, overrides={"rod.length": 0.8})
    found = cpinn.identify("measured.yaml")               # found.values, found.deviations
    robot = cpinn.Members("robot.yaml", s=[0.1, 0.2])     # its parameters with ranges: robot.names
    shapes, results = robot.solve(numpy.random.rand(1000, len(robot.names)))
    family = cpinn.Family("runs/robot")                   # a network trained for all members
    shapes, answers = family.evaluate(at={"tension": [0.5, 1.2]}, s=[0.1, 0.2])
    slopes = family.jacobian(at={"tension": 1.2}, s=0.2).jacobian    # m/N and so on
    arm = cpinn.one_step("runs/arm")                      # states a step later, thousands at once
    cpinn.envs.RodVectorEnv("runs/arm", num_envs=1024)    # for gymnasium; import cpinn.envs
    found = cpinn.fit(equations, tolerance=1e-6)          # of your own: cpinn.Equations

Names of columns are those of the C library, physics/learn/evaluator.h: columns of the scene's model ("x",
"qw", "m2", of beams "w"), r and q for all of a rod's position and rotation, and behind an underscore
s and t as often as differentiated. All numbers are in SI units; arrays are numpy's, and batches take
no loop in Python.

A scene is the path of a file, or what such a file says as a dict: {"rod": {"length": 0.3, ...}, ...}.
Files that a dict names need whole paths. `overrides` change keys: {"rod.length": 0.3}, or a list of
"rod.length=0.3". Errors are `cpinn.Error`: also a ValueError, TypeError, OSError, ArithmeticError or
MemoryError, as Python has it. What the library has made, as in a Model, is shared by copies
(copy.copy) and lives as long as one of them; it cannot be copied itself (copy.deepcopy) nor pickled.
An object is used by one thread at a time; different ones may be by different threads at once.
"""
from ._equations import Coordinate, Equations, Face, Field, Fit, FitProgress, fit, open_fit
from ._family import Family, Jacobian, Members, Reached, Shapes
from ._formulas import (Formula, acos, asin, atan, cos, cosh, exp, log, maximum, minimum, pi, sin, sinh, sqrt,
                        tan, tanh, where)
from ._library import (ArgumentTypeError, Error, FileError, InputError, NotFiniteError,
                       OutOfMemoryError, library_version)
from ._model import Model, Progress, Verdict, train
from ._model import open_run as open
from ._place import example
from ._solution import Solution, Unknowns, identify, solve
from ._steps import OneStep, Step, one_step, reduced_rod

__all__ = ["ArgumentTypeError", "Coordinate", "Equations", "Error", "Face", "Family", "Field", "FileError",
           "Fit", "FitProgress", "Formula", "InputError", "Jacobian", "Members", "Model", "NotFiniteError",
           "OneStep", "OutOfMemoryError", "Progress", "Reached", "Shapes", "Solution", "Step", "Unknowns",
           "Verdict", "acos", "asin", "atan", "cos", "cosh", "example", "exp", "fit", "identify", "log",
           "maximum", "minimum", "one_step", "open", "open_fit", "pi", "reduced_rod", "sin", "sinh", "solve",
           "sqrt", "tan", "tanh", "train", "version", "where"]


def version() -> str:
    """The version of the C library, as in "0.1.0"."""
    text: bytes = library_version()
    return text.decode()
