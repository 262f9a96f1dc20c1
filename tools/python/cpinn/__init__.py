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
    shapes, answers = family.evaluate([[0.5, 2.0]], s=[0.1, 0.2])  # answers["error"] in m

Names are those of the C library, physics/evaluator.h: columns of the scene's model ("x", "qw", "m2",
of beams "w"), r and q for all of a rod's position and rotation, and behind an underscore s and t as
often as differentiated. All numbers are in SI units; arrays are numpy's, and s and t are broadcast
against each other. Errors are raised as cpinn.Error, with the line that cpinn-train would print.

A scene is the path of a file, or what such a file says as a dict: {"rod": {"length": 0.3, ...}, ...}.
Files that a dict names need whole paths. `overrides` change keys, as --set does: {"rod.length": 0.3}
or a list of "rod.length=0.3". threads: how many, None: one per processor; results do not depend on
it. What the library has made, as in a Model, is shared by copies (copy.copy) and lives as long as
one of them; it cannot be copied itself (copy.deepcopy) nor go to another process (pickle).
"""
import contextlib
import ctypes
import io
import json
import operator
import os
import signal
import tempfile
import threading

import numpy

from ._place import example, load

__all__ = ["Error", "Family", "Members", "Model", "Progress", "Solution", "Unknowns", "Verdict",
           "example", "identify", "open", "solve", "train", "version"]


class Error(Exception):
    """What is wrong, and what is allowed, as one line."""


class _Error(ctypes.Structure):
    _fields_ = [("status", ctypes.c_int), ("message", ctypes.c_char * 512)]


class Progress(ctypes.Structure):
    """Where training stands after a step; numbers that are not known are NaN."""

    _fields_ = [("step", ctypes.c_int64), ("window", ctypes.c_int), ("windows", ctypes.c_int),
                ("stage", ctypes.c_int), ("stages", ctypes.c_int),
                ("load_factor", ctypes.c_double), ("loss", ctypes.c_double),
                ("held_out", ctypes.c_double), ("error", ctypes.c_double),
                ("seconds", ctypes.c_double)]

    def __repr__(self):
        where = f"window {self.window} of {self.windows}, " if self.windows > 1 else ""
        return (f"{where}step {self.step}: loss {self.loss:.3e}, held out {self.held_out:.3e}, "
                f"error {self.error:.3e}, {self.seconds:.1f} s")


_PROGRESS = ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.c_void_p, ctypes.POINTER(Progress))


class _Options(ctypes.Structure):
    _fields_ = [("threads", ctypes.c_int), ("folder", ctypes.c_char_p), ("resume", ctypes.c_bool),
                ("progress", _PROGRESS), ("context", ctypes.c_void_p)]


class _MembersSettings(ctypes.Structure):
    _fields_ = [("tolerance", ctypes.c_double),
                ("threads", ctypes.c_int), ("points", ctypes.c_size_t), ("s", ctypes.c_void_p),
                ("ranks", ctypes.c_void_p)]


class _FamilySettings(ctypes.Structure):
    _fields_ = [("extrapolate", ctypes.c_bool), ("threads", ctypes.c_int),
                ("points", ctypes.c_size_t), ("s", ctypes.c_void_p), ("t", ctypes.c_void_p),
                ("ranks", ctypes.c_void_p)]


class _Polish(ctypes.Structure):
    _fields_ = [("steps", ctypes.c_int), ("alone", ctypes.c_bool)]


class _Parameter(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("low", ctypes.c_double), ("high", ctypes.c_double),
                ("scale", ctypes.c_int)]


_library = load()


def _declare(name, result, *arguments):
    function = getattr(_library, name)
    function.restype, function.argtypes = result, arguments
    return function


def _call(function, *arguments):
    error = _Error()
    if function(*arguments, ctypes.byref(error)) != 0:
        raise Error(error.message.decode(errors="replace"))


class _Made:
    """What the library has made, freed with its last owner."""

    def __init__(self, free, function, *arguments):
        self._as_parameter_, self._free = ctypes.c_void_p(), free
        _call(function, *arguments, ctypes.byref(self._as_parameter_))

    @classmethod
    def from_param(cls, made):
        """As an argument: ctypes would take a text or a number for a pointer."""
        if not isinstance(made, cls):
            raise TypeError(f"{made!r}: nothing that the library has made; models and solutions "
                            "are made by cpinn.open, cpinn.train, cpinn.solve, cpinn.identify")
        return made._as_parameter_

    def __reduce_ex__(self, protocol):
        raise Error("what the library has made cannot be copied or pickled; make it anew there, "
                    "from its file")

    def __del__(self):
        self._free(self._as_parameter_)


_P, _I, _D, _S, _Z = (ctypes.c_void_p, ctypes.c_int, ctypes.c_double, ctypes.c_char_p,
                      ctypes.c_size_t)
_TEXTS, _OUT, _FAIL = ctypes.POINTER(_S), ctypes.POINTER(_P), ctypes.POINTER(_Error)
_version = _declare("cpinn_version", _S)
_train_file = _declare("cpinn_train_file", _I, _S, _I, _TEXTS, ctypes.POINTER(_Options), _OUT, _FAIL)
_open = _declare("cpinn_open", _I, _S, _OUT, _FAIL)
_save = _declare("cpinn_save", _I, _Made, _S, _FAIL)
_free = _declare("cpinn_free", None, _P)
_verdict = _declare("cpinn_verdict", _P, _Made)
_estimate = _declare("cpinn_estimate", _D, _Made)
_rows = _declare("cpinn_history_rows", _Z, _Made)
_columns = _declare("cpinn_history_columns", _I, _Made)
_name = _declare("cpinn_history_name", _S, _Made, _I)
_value = _declare("cpinn_history_value", _D, _Made, _Z, _S)
_evaluator = _declare("cpinn_evaluator", _I, _Made, _S, _OUT, _FAIL)
_evaluator_free = _declare("evaluator_free", None, _P)
_evaluator_columns = _declare("evaluator_columns", _I, _Made)
_evaluator_name = _declare("evaluator_column_name", _S, _Made, _I)
_evaluate = _declare("evaluator_evaluate", _I, _Made, _Z, _P, _P, _P, _FAIL)
_solve_file = _declare("cpinn_solve_file", _I, _S, _I, _TEXTS, _D, _Z, _P, _OUT, _FAIL)
_solution_free = _declare("cpinn_solution_free", None, _P)
_solution_verdict = _declare("cpinn_solution_verdict", _P, _Made)
_solution_estimate = _declare("cpinn_solution_estimate", _D, _Made)
_solution_columns = _declare("cpinn_solution_columns", _I, _Made)
_solution_name = _declare("cpinn_solution_column_name", _S, _Made, _I)
_solution_evaluate = _declare("cpinn_solution_evaluate", _I, _Made, _Z, _P, _P, _P, _FAIL)
_members_file = _declare("cpinn_members_file", _I, _S, _I, _TEXTS, _P, _OUT, _FAIL)
_members_name = _declare("cpinn_members_name", _S, _Made, _I)
_members_free = _declare("cpinn_members_free", None, _P)
_members_solve = _declare("cpinn_members_solve", _I, _Made, _Z, _P, _P, _P, _FAIL)
_family_open = _declare("cpinn_family_open", _I, _S, _P, _OUT, _FAIL)
_family_free = _declare("cpinn_family_free", None, _P)
_family_parameters = _declare("cpinn_family_parameters", _I, _Made)
_family_parameter = _declare("cpinn_family_parameter", ctypes.POINTER(_Parameter), _Made, _I)
_family_columns = _declare("cpinn_family_columns", _I, _Made)
_family_name = _declare("cpinn_family_column_name", _S, _Made, _I)
_family_evaluate = _declare("cpinn_family_evaluate", _I, _Made, _P, _Z, _P, _P, _P, _FAIL)
_identify_file = _declare("cpinn_identify_file", _I, _S, _I, _TEXTS, _I, _OUT, _FAIL)
_unknowns_free = _declare("cpinn_unknowns_free", None, _P)
_unknowns_count = _declare("cpinn_unknowns_count", _I, _Made)
_unknowns_name = _declare("cpinn_unknowns_name", _S, _Made, _I)
_unknowns_value = _declare("cpinn_unknowns_value", _D, _Made, _I)
_unknowns_deviation = _declare("cpinn_unknowns_deviation", _D, _Made, _I)
_unknowns_correlation = _declare("cpinn_unknowns_correlation", _D, _Made, _I, _I)
_unknowns_chi_squared = _declare("cpinn_unknowns_chi_squared", _D, _Made)
_unknowns_freedom = _declare("cpinn_unknowns_freedom", _D, _Made)
_unknowns_verdict = _declare("cpinn_unknowns_verdict", _P, _Made)
_reason_word = _declare("cpinn_reason_word", _S, _I)
_source_word = _declare("cpinn_source_word", _S, _I)
_outcome_of = _declare("verdict_outcome_of", _I, _P)
_outcome_name = _declare("verdict_outcome_name", _S, _I)
_worst = _declare("verdict_worst", _I, _P)
_reason_name = _declare("verdict_reason_name", _S, _I)
_verdict_text = _declare("verdict_text", _S, _P)


def _text(text):
    """A text or path for C, which would take a zero byte for its end."""
    encoded = os.fsencode(text)
    if b"\0" in encoded:
        raise Error(f"{text!r}: has a zero byte; allowed: texts without one")
    return encoded


def _whole(name, value, low, high, none=""):
    """A whole number, where ctypes would take its last 32 bits."""
    try:
        number = low - 1 if isinstance(value, bool) else operator.index(value)
    except TypeError:
        number = low - 1
    if not low <= number <= high:
        raise Error(f"{name}: is {value!r}; allowed: a whole number from {low} to {high}{none}")
    return number


_THREADS_MOST = 1024  # AD_THREADS_MAX of autodiff/ad.h


def _threads(threads):
    return 0 if threads is None else _whole("threads", threads, 1, _THREADS_MOST,
                                            ", None: one per processor")


def _plain(value):
    """What json does not know: numbers and arrays of numpy."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


def _overrides(overrides):
    if isinstance(overrides, str):
        raise Error(f"overrides: '{overrides}' is a str; allowed: a dict, a list of 'key=value'")
    if hasattr(overrides, "items"):
        overrides = [key + "=" + (value if isinstance(value, str) else
                                  json.dumps(value, default=_plain))
                     for key, value in overrides.items()]
    texts = [_text(text.encode()) for text in overrides]
    return len(texts), (_S * (len(texts) + 1))(*texts)


@contextlib.contextmanager
def _file(scene):
    """The path of a scene; one that is given as a dict is a file of YAML, of which JSON is a part,
    for so long. What is wrong with it has a key and no place."""
    if not hasattr(scene, "items"):
        yield _text(scene)
        return
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.yaml")
        with io.open(path, "w") as file:
            json.dump(scene, file, default=_plain)
        try:
            yield os.fsencode(path)
        except Error as error:
            place, _, rest = str(error).partition(": ")
            raise Error(rest if place.startswith(path) else str(error)) from None


def _members(parameters, names):
    """Rows of parameters [members, names]; from a dict {name: numbers} that are broadcast."""
    if hasattr(parameters, "items"):
        if set(parameters) != set(names):
            raise Error(f"parameters are {', '.join(parameters)}; wanted: {', '.join(names)}")
        columns = numpy.broadcast_arrays(*[parameters[name] for name in names])
        parameters = numpy.stack([column.ravel() for column in columns], axis=1)
    parameters = numpy.ascontiguousarray(parameters, dtype=float)
    if len(names) > 1 and parameters.shape[-1:] != (len(names),):
        raise Error(f"parameters have the shape {parameters.shape}; wanted: a column each for "
                    f"{', '.join(names)}")
    return parameters.reshape(-1, len(names))


def _points(s, t):
    """The shape of s and t together, and both as flat arrays of doubles."""
    s, t = numpy.broadcast_arrays(numpy.asarray(s, dtype=float), numpy.asarray(t, dtype=float))
    return s.shape, numpy.ascontiguousarray(s.ravel()), numpy.ascontiguousarray(t.ravel())


def _fill(function, handle, names, shape, s, t):
    values = numpy.empty((len(names), s.size))
    _call(function, handle, s.size, s.ctypes.data, t.ctypes.data, values.ctypes.data)
    return {name: values[i].reshape(shape) for i, name in enumerate(names)}


class Verdict:
    """How a computation ended: outcome ("solved", "warning", "stopped"), reason and text."""

    def __init__(self, outcome, reason, text=""):
        self.outcome, self.reason, self.text = outcome, reason, text

    def __repr__(self):
        return f"{self.outcome} ({self.reason}): {self.text}" if self.text else self.outcome


def _ended(verdict):
    return Verdict(_outcome_name(_outcome_of(verdict)).decode(),
                   _reason_name(_worst(verdict)).decode(),
                   _verdict_text(verdict).decode(errors="replace"))


class Model:
    """A trained model; `estimate`: of its error, over the length. Used by one thread at a time."""

    def __init__(self, handle):
        self._handle, self._evaluators = handle, {}
        self.verdict, self.estimate = _ended(_verdict(handle)), _estimate(handle)
        names = [_name(handle, i) for i in range(_columns(handle))]
        self.history = {name.decode(): numpy.array([_value(handle, row, name)
                                                    for row in range(_rows(handle))])
                        for name in names}

    def evaluate(self, names=None, s=0.0, t=0.0):
        """Columns and derivatives by name at points s (m), t (s); None: every column."""
        if names not in self._evaluators:
            wanted = _text(names.encode()) if names is not None else None
            self._evaluators[names] = _Made(_evaluator_free, _evaluator, self._handle, wanted)
        made = self._evaluators[names]
        columns = [_evaluator_name(made, i).decode() for i in range(_evaluator_columns(made))]
        return _fill(_evaluate, made, columns, *_points(s, t))

    def save(self, path):
        """Write a checkpoint, of a model that was trained here."""
        _call(_save, self._handle, _text(path))


class Solution:
    """A classical solution: values {column: array}, verdict, and the estimate of its error."""

    def __init__(self, handle, shape, s, t):
        columns = [_solution_name(handle, i).decode() for i in range(_solution_columns(handle))]
        self.verdict = _ended(_solution_verdict(handle))
        self.estimate = _solution_estimate(handle)
        self.values = _fill(_solution_evaluate, handle, columns, shape, s, t)


class Members:
    """Many equilibria of one rod at rest, for values of the parameters that have ranges in its
    file, `names`: `columns` x y z qw qx qy qz v1 v2 v3 u1 u2 u3 at s (m, ascending), all to a
    tolerance in lengths."""

    columns = "x y z qw qx qy qz v1 v2 v3 u1 u2 u3".split()

    def __init__(self, scene, s, overrides=(), tolerance=1e-6, threads=1):
        self._s = numpy.ascontiguousarray(s, dtype=float).ravel()
        settings = _MembersSettings(tolerance, _threads(threads), self._s.size,
                                    self._s.ctypes.data)
        with _file(scene) as path:
            self._handle = _Made(_members_free, _members_file, path, *_overrides(overrides),
                                 ctypes.byref(settings))
        self.names = []
        while _members_name(self._handle, len(self.names)):
            self.names.append(_members_name(self._handle, len(self.names)).decode())

    def solve(self, parameters):
        """values [members, points, columns] and results with fields estimate, load, nodes, steps
        and solved, for parameters [members, names], or {name: numbers} that are broadcast; values
        are nan where there is no solution."""
        parameters = _members(parameters, self.names)
        values = numpy.empty((len(parameters), self._s.size, len(self.columns)))
        results = numpy.zeros(len(parameters), dtype=numpy.dtype(
            [("estimate", "f8"), ("load", "f8"), ("nodes", "i4"), ("steps", "i4"),
             ("solved", "?")], align=True))
        _call(_members_solve, self._handle, len(parameters), parameters.ctypes.data,
              values.ctypes.data, results.ctypes.data)
        return values, results


class Family:
    """A network trained for all members of a family, from the folder of a run: each shape with its
    predicted error; what is not trusted is solved instead. `ranges`: {parameter: (low, high)} in
    the order of columns of parameters, `columns`: names of a shape's. Used by one thread at a time.
    """

    answer = numpy.dtype([("error", "f8"), ("network_error", "f8"), ("source", "i4"),
                          ("reason", "i4"), ("trusted", "?"), ("outside", "?")], align=True)

    def __init__(self, path, threads=1, extrapolate=False):
        self._made = {}
        self._open = (_text(path), _threads(threads), bool(extrapolate))
        made = self._at(numpy.zeros(0), numpy.zeros(0))
        found = [_family_parameter(made, i).contents for i in range(_family_parameters(made))]
        self.ranges = {p.name.decode(): (p.low, p.high) for p in found}
        self.columns = [_family_name(made, i).decode() for i in range(_family_columns(made))]

    def _at(self, s, t):
        """The family at these points, as which it was opened before or is now."""
        key = s.tobytes() + t.tobytes()
        if key not in self._made:
            path, threads, extrapolate = self._open
            settings = _FamilySettings(extrapolate, threads, s.size, s.ctypes.data,
                                       t.ctypes.data)
            self._made[key] = _Made(_family_free, _family_open, path, ctypes.byref(settings))
        return self._made[key]

    def evaluate(self, parameters, s, t=0.0, polish=2, alone=False):
        """values [members, points, columns] at s (m, ascending; of a family in motion also t, s),
        and answers [members] with fields error and network_error (m), source, reason, trusted and
        outside, for parameters [members, ranges] in SI units, or {name: numbers} that are
        broadcast. polish: steps of Newton's method; alone: what is not trusted is not solved."""
        _, s, t = _points(s, t)
        made = self._at(s, t)
        parameters = _members(parameters, self.ranges)
        values = numpy.empty((len(parameters), s.size, len(self.columns)))
        answers = numpy.zeros(len(parameters), dtype=self.answer)
        steps = _whole("polish", polish, 0, 2)
        _call(_family_evaluate, made, ctypes.byref(_Polish(steps, bool(alone))), len(parameters),
              parameters.ctypes.data, values.ctypes.data, answers.ctypes.data)
        return values, answers

    @staticmethod
    def words(answers):
        """(source, reason) of each answer."""
        return [(_source_word(a["source"]).decode(), _reason_word(a["reason"]).decode())
                for a in answers]


class Unknowns:
    """Unknown numbers of a scene, found from its data: values and (standard) deviations {name:
    number}, correlations [unknowns, unknowns], chi_squared of so many degrees of freedom, verdict.
    A deviation is nan where the value is an end of its range."""

    def __init__(self, handle):
        indices = range(_unknowns_count(handle))
        names = [_unknowns_name(handle, i).decode() for i in indices]
        self.values = {name: _unknowns_value(handle, i) for i, name in enumerate(names)}
        self.deviations = {name: _unknowns_deviation(handle, i) for i, name in enumerate(names)}
        self.correlations = numpy.array([[_unknowns_correlation(handle, i, k) for k in indices]
                                         for i in indices])
        self.chi_squared = _unknowns_chi_squared(handle)
        self.freedom = _unknowns_freedom(handle)
        self.verdict = _ended(_unknowns_verdict(handle))

    def __repr__(self):
        found = [f"{name} = {value:.6g} +- {self.deviations[name]:.2g}"
                 for name, value in self.values.items()]
        return f"{', '.join(found)}; {self.verdict}"


def version():
    return _version().decode()


@contextlib.contextmanager
def _interrupts(raised):
    """Ctrl-C is put into a list: between two steps Python only runs callbacks, out of which ctypes
    lets no exception go."""
    ours = (threading.current_thread() is threading.main_thread() and
            signal.getsignal(signal.SIGINT) is signal.default_int_handler)
    if ours:
        signal.signal(signal.SIGINT, lambda *_: raised.append(KeyboardInterrupt()))
    try:
        yield
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def train(scene, overrides=(), threads=None, folder=None, resume=False, progress=None):
    """Train a scene. folder: where the run is kept, None: in memory alone; resume: go on with the
    run that is there; progress: called with a Progress after each step (print will do), False stops
    training. What it raises ends training, as Ctrl-C does, and is raised again."""
    raised = []

    def stepped(_, now):
        try:
            answer = progress(now.contents) if progress else None
            return not raised and (answer is None or bool(answer))
        except BaseException as error:  # handed on below
            raised.append(error)
            return False

    options = _Options(_threads(threads), _text(folder) if folder is not None else None,
                       bool(resume), _PROGRESS(stepped))
    with _file(scene) as path, _interrupts(raised):
        model = Model(_Made(_free, _train_file, path, *_overrides(overrides),
                            ctypes.byref(options)))
    if raised:
        raise raised[0]
    return model


def open(path):
    """A model from the folder of a run or a checkpoint."""
    return Model(_Made(_free, _open, _text(path)))


def solve(scene, s, t=0.0, overrides=(), tolerance=0.0):
    """Solve a scene by a classical method, at points s (m), t (s)."""
    shape, s, t = _points(s, t)
    times = numpy.unique(t)
    with _file(scene) as path:
        handle = _Made(_solution_free, _solve_file, path, *_overrides(overrides), tolerance,
                       times.size, times.ctypes.data)
    return Solution(handle, shape, s, t)


def identify(scene, overrides=(), threads=None):
    """Find the unknowns of a scene (parameters with `identify`) from its data."""
    with _file(scene) as path:
        return Unknowns(_Made(_unknowns_free, _identify_file, path, *_overrides(overrides),
                              _threads(threads)))
