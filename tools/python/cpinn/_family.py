"""Members of a family of rods: solved, or answered by a network that was trained for all."""
from __future__ import annotations

import ctypes
import warnings
from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy
import numpy.typing

from . import _library as library
from ._given import (Numbers, Overrides, PathLike, Scene, Values, array_of, finite, number_of,
                     overrides_of, points, rows, scene_file, text_of, threads_of, whole)
from ._library import Array, InputError, Made
from ._model import plot_shapes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Records = numpy.typing.NDArray[numpy.void]


class Shapes(NamedTuple):
    """Shapes of members, and what is known of each."""

    values: Array  #: [members, points, columns]
    answers: Records  #: [members]


class Jacobian(NamedTuple):
    """Shapes of members with their derivatives by the parameters."""

    values: Array  #: [members, points, columns]
    jacobian: Array  #: [members, points, columns, parameters]
    answers: Records  #: [members]


class Reached(NamedTuple):
    """Parameters that bring the tip to places, and how near each comes."""

    parameters: Array  #: [tips, parameters]
    results: Records  #: [tips], of distance and bound (m), reached


def _plot(shapes: Shapes, axes: Optional["Axes"], style: dict[str, Any]) -> "Axes":
    position = shapes.values[:, :, :3]
    return plot_shapes(axes, position, [str(i) for i in range(len(position))], style)


class Family:
    """A network that was trained for all members of a family. Each answer has a predicted error,
    and what is not trusted is solved instead. Used by one thread at a time.

    Parameters
    ----------
    path : path
        The folder of a run, or its checkpoint.
    threads : int, optional
        None: one per processor. Results do not depend on it.
    extrapolate : bool
        Answer members outside the ranges, too.
    compile : bool
        Answer up to four members at a time by C that the command ``cc`` compiles for each set of
        places: 5 s once, and 40 for 101 places, as it is kept, then three to five times as quick, and
        derivatives ten times. Warns where that is not possible.
    forces : bool
        Columns n1 n2 n3 (N), m1 m2 m3 (N m) follow: force and moment in the rod, of rod and
        actuators together, with their derivatives. Of families at rest, by the balance at the
        equilibrium of the answer.

    Attributes
    ----------
    ranges : dict of str to (float, float)
        Parameters in the order of columns of an array of them, with their ranges in SI units.
    names : list of str
        The parameters alone.
    columns : list of str
        Of a shape: at rest x y z (m), qw qx qy qz, v1 v2 v3, u1 u2 u3 (1/m), then forces.
    """

    answer = numpy.dtype([("error", "f8"), ("network_error", "f8"), ("source", "i4"),
                          ("reason", "i4"), ("trusted", "?"), ("outside", "?")], align=True)

    reached = numpy.dtype([("distance", "f8"), ("bound", "f8"), ("reached", "?")], align=True)

    def __init__(self, path: PathLike, threads: Optional[int] = 1,
                 extrapolate: bool = False, compile: bool = False, forces: bool = False) -> None:
        self._path = text_of(path)
        self._begin(threads, extrapolate, compile, forces, numpy.zeros(0), numpy.zeros(0))

    def _begin(self, threads: Optional[int], extrapolate: bool, compile: bool, forces: bool,
               s: Array, t: Array) -> None:
        self._made: dict[bytes, Made] = {}
        self._settings = (threads_of(threads), bool(extrapolate), bool(compile), bool(forces))
        made = self._at(s, t)
        found = [library.family_parameter(made, i).contents
                 for i in range(library.family_parameters(made))]
        self.ranges: dict[str, tuple[float, float]] = {p.name.decode(): (p.low, p.high)
                                                       for p in found}
        self.names = list(self.ranges)
        self.columns: list[str] = [library.family_name(made, i).decode()
                                   for i in range(library.family_columns(made))]

    def __repr__(self) -> str:
        of = ", ".join(f"{name} from {low:g} to {high:g}"
                       for name, (low, high) in self.ranges.items())
        return f"<cpinn.{type(self).__name__} of {of}>"

    def _create(self, settings: Any) -> Made:
        return Made(library.family_free, library.family_open, self._path, settings)

    def _at(self, s: Array, t: Array) -> Made:
        """The family at these points, as which it was opened before or is now."""
        key = s.tobytes() + t.tobytes()
        if key not in self._made:
            threads, extrapolate, compiled, forces = self._settings
            compiled = compiled and s.size > 0
            settings = library.FamilySettings(extrapolate, threads, s.size, s.ctypes.data,
                                              t.ctypes.data, compiled, None, forces)
            made = self._made[key] = self._create(ctypes.byref(settings))
            reason = library.family_not_compiled(made).decode() if compiled else ""
            if reason:
                warnings.warn(f"nothing is compiled: {reason}", stacklevel=4)
        return self._made[key]

    def evaluate(self, at: Values, s: Optional[Numbers] = None, t: Numbers = 0.0, polish: int = 2,
                 alone: bool = False) -> Shapes:
        """Shapes of members.

        Parameters
        ----------
        at : array_like, shape (members, parameters), or dict of str to array_like
            Parameters in SI units; by name they are broadcast against each other:
            ``family.evaluate(at={"tension": [0.5, 1.2]}, s=0.2)``.
        s, t : array_like, shape (points,)
            Places (m, ascending) and, of a family in motion, instants (s), in any order then; of
            `Members` those of its making.
        polish : int
            Steps of Newton's method, 0 to 2.
        alone : bool
            Leave what is not trusted as it is, and do not solve it.

        Returns
        -------
        values : ndarray, shape (members, points, columns)
            In SI units.
        answers : structured ndarray, shape (members,)
            error and network_error (m, predicted), source, reason (`words`), trusted, outside.
            Values are NaN where nobody has an answer.
        """
        made, given, values, answers = self._room(at, s, t)
        steps = whole("polish", polish, 0, 2)
        library.call(library.family_evaluate, made,
                     ctypes.byref(library.Polish(steps, bool(alone))), len(given),
                     given.ctypes.data, values.ctypes.data, answers.ctypes.data)
        return Shapes(values, answers)

    def jacobian(self, at: Values, s: Optional[Numbers] = None, t: Numbers = 0.0) -> Jacobian:
        """Shapes of members with exact derivatives by the parameters.

        At rest these are derivatives of the equilibrium at which the answer has arrived, by the
        implicit function theorem. Those of `Members` in motion go forward with the steps of time,
        and an answer is not trusted where they are not exact. Of networks that the solver of
        members does not take, such as motions, they are derivatives of the network.

        Parameters
        ----------
        at, s, t
            As in `evaluate`.

        Returns
        -------
        values, answers
            As of `evaluate`.
        jacobian : ndarray, shape (members, points, columns, parameters)
            In SI units.
        """
        made, given, values, answers = self._room(at, s, t)
        slopes = numpy.empty((*values.shape, len(self.names)))
        library.call(library.family_jacobian, made, len(given), given.ctypes.data,
                     values.ctypes.data, slopes.ctypes.data, answers.ctypes.data)
        return Jacobian(values, slopes, answers)

    def reach(self, tips: Numbers, s: Optional[float] = None, tolerance: float = 1e-5,
              fixed: Optional[dict[str, float]] = None, seed: int = 0) -> Reached:
        """Parameters that bring a place of the rod to given places.

        Parameters
        ----------
        tips : array_like, shape (tips, 3)
            Places in m.
        s : float
            The place on the rod (m); of `Members` the last of its making.
        tolerance : float
            Distance (m) within which a place is reached, what answers may be off by included.
        fixed : dict of str to float
            Parameters that are given; the others are chosen within their ranges.
        seed : int
            Of the random starts.

        Returns
        -------
        parameters : ndarray, shape (tips, parameters)
            NaN where nobody has an answer.
        results : structured ndarray, shape (tips,)
            distance and bound (m), reached. What is not reached may be beyond the robot, or beyond
            what the starts have found.
        """
        places = numpy.ascontiguousarray(numpy.atleast_2d(tips), dtype=float)
        if places.shape[1:] != (3,):
            raise InputError(f"tips have the shape {places.shape}; allowed: (tips, 3)")
        unknown = set(fixed or {}) - set(self.names)
        if unknown:
            raise InputError(f"fixed: '{min(unknown)}' is no parameter; allowed: "
                             f"{', '.join(self.names)}")
        given = numpy.array([(fixed or {}).get(name, numpy.nan) for name in self.names])
        made = self._room(numpy.zeros((0, len(self.names))), s, 0.0)[0]
        parameters = numpy.empty((len(places), len(self.names)))
        results = numpy.zeros(len(places), dtype=self.reached)
        settings = library.ReachSettings(given.ctypes.data, tolerance, seed)
        library.call(library.reach, made, ctypes.byref(settings), len(places), places.ctypes.data,
                     parameters.ctypes.data, results.ctypes.data)
        return Reached(parameters, results)

    def _room(self, at: Values, s: Optional[Numbers],
              t: Numbers) -> tuple[Made, Array, Array, Records]:
        if s is None:
            raise InputError("s is not given; allowed: places, m")
        _, s, t = points(s, t)
        given = rows(at, self.names)
        return (self._at(s, t), given, numpy.empty((len(given), s.size, len(self.columns))),
                numpy.zeros(len(given), dtype=self.answer))

    @staticmethod
    def words(answers: Records) -> list[tuple[str, str]]:
        """(source, reason) of each answer."""
        return [(library.source_word(a["source"]).decode(),
                 library.reason_word(a["reason"]).decode()) for a in answers]

    def plot(self, at: Values, s: Optional[Numbers] = None, t: Numbers = 0.0, axes: Optional["Axes"] = None,
             **style: Any) -> "Axes":
        """Draw members, in the plane in which they spread most; style: of `Axes.plot`."""
        if "x" not in self.columns:
            raise InputError("a beam has no position in space; draw what evaluate() returns")
        return _plot(self.evaluate(at, s, t), axes, style)


class Members(Family):
    """The same without any network. At rest a solver finds the members, some ten microseconds each;
    what is not within the tolerance is left to another one. Each motion is solved by itself. Each
    answer has its error. Members outside the ranges are answered, too.

    Parameters
    ----------
    scene : path or dict
        A scene of a rod whose `parameters` have ranges.
    s, t : array_like, shape (points,)
        Where shapes are wanted unless something else is said: m, ascending at rest; of a scene in
        motion s, broadcast against each other.
    overrides : dict or list of str
        Keys to change.
    tolerance : float, optional
        Of the position, over the length. None: 1e-6 at rest, the solver's default in motion.
    threads : int, optional
        None: one per processor. Results do not depend on it.
    compile : bool
        As of `Family`; then more than twice as quick, and derivatives four times.
    forces : bool
        As of `Family`.

    Attributes
    ----------
    ranges, names, columns
        As of `Family`.
    """

    def __init__(self, scene: Scene, s: Numbers, overrides: Overrides = (),
                 tolerance: Optional[float] = None, threads: Optional[int] = 1,
                 compile: bool = False, forces: bool = False, t: Numbers = 0.0) -> None:
        self._scene, self._overrides = scene, overrides
        self._tolerance = 0.0 if tolerance is None else number_of("tolerance", tolerance, 0,
                                                                  "a number above 0")
        _, self._s, self._t = points(s, t)
        self._begin(threads, True, compile, forces, self._s, self._t)

    def _create(self, settings: Any) -> Made:
        with scene_file(self._scene) as path:
            return Made(library.family_free, library.family_file, path,
                        *overrides_of(self._overrides), self._tolerance, settings)

    def _room(self, at: Values, s: Optional[Numbers], t: Numbers) -> tuple[Made, Array, Array, Records]:
        return super()._room(at, *(self._s, self._t) if s is None else (s, t))

    def solve(self, at: Values) -> Shapes:
        """`evaluate` where shapes are wanted."""
        return self.evaluate(at)
