"""Classical solutions, and unknown numbers found from data."""
from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Optional

import numpy

from . import _library as library
from ._given import (Numbers, Overrides, Scene, number_of, overrides_of, points, scene_file,
                     threads_of, whole)
from ._library import Array, InputError, Made
from ._model import fill, plot_shapes, verdict_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Solution:
    """A classical solution at the points that were asked for. Made by `solve`; plain data, which
    can be copied and pickled.

    Attributes
    ----------
    values : dict of str to ndarray
        Columns of the scene's model in SI units, each of the shape of s and t together.
    verdict : Verdict
    estimate : float
        Of the largest error of the position, over the length; NaN: not known.
    """

    def __init__(self, handle: Made, shape: tuple[int, ...], s: Array, t: Array) -> None:
        columns = [library.solution_name(handle, i).decode()
                   for i in range(library.solution_columns(handle))]
        self.verdict = verdict_of(library.solution_verdict(handle))
        self.estimate: float = library.solution_estimate(handle)
        self.values = fill(library.solution_evaluate, handle, columns, shape, s, t)

    def __repr__(self) -> str:
        shape = next(iter(self.values.values())).shape
        return (f"<cpinn.Solution: {self.verdict}, error about {self.estimate:.1e}, "
                f"{len(self.values)} columns of shape {shape}>")

    def plot(self, axes: Optional["Axes"] = None, **style: Any) -> "Axes":
        """Draw the rod in the plane in which it spreads most; s goes along the last axis of the
        points.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; None: a new figure.
        **style
            Passed to `Axes.plot`.
        """
        if "x" not in self.values:
            raise InputError("a beam has no position in space; draw values['w'] over s")
        position = numpy.stack([numpy.atleast_1d(self.values[c]) for c in "xyz"], axis=-1)
        position = position.reshape(-1, *position.shape[-2:])
        return plot_shapes(axes, position, [str(i) for i in range(len(position))], style)


class Unknowns:
    """Unknown numbers of a scene, found from its data. Made by `identify`.

    Attributes
    ----------
    values, deviations : dict of str to float
        Numbers and their standard deviations; NaN where the number is held at an end of its range.
    correlations : ndarray, shape (unknowns, unknowns)
    chi_squared, freedom : float
        Squared residuals over their noise, and their degrees of freedom.
    verdict : Verdict
    """

    def __init__(self, handle: Made) -> None:
        indices = range(library.unknowns_count(handle))
        names = [library.unknowns_name(handle, i).decode() for i in indices]
        self.values: dict[str, float] = {name: library.unknowns_value(handle, i)
                                         for i, name in enumerate(names)}
        self.deviations: dict[str, float] = {name: library.unknowns_deviation(handle, i)
                                             for i, name in enumerate(names)}
        self.correlations = numpy.array([[library.unknowns_correlation(handle, i, k)
                                          for k in indices] for i in indices])
        self.chi_squared: float = library.unknowns_chi_squared(handle)
        self.freedom: float = library.unknowns_freedom(handle)
        self.verdict = verdict_of(library.unknowns_verdict(handle))

    def __repr__(self) -> str:
        found = [f"{name} = {value:.6g} +- {self.deviations[name]:.2g}"
                 for name, value in self.values.items()]
        return f"{', '.join(found)}; {self.verdict}"


def solve(scene: Scene, s: Numbers, t: Numbers = 0.0, overrides: Overrides = (),
          tolerance: Optional[float] = None, perturb: float = 0.0, branch: int = 0) -> Solution:
    """Solve a scene by a classical method.

    Parameters
    ----------
    scene : path or dict
        A YAML file, or what would be in one.
    s, t : array_like
        Arc length (m) and time (s), broadcast against each other.
    overrides : dict or list of str
        Keys to change: ``{"rod.length": 0.3}`` or ``["rod.length=0.3"]``.
    tolerance : float, optional
        Of the estimated error of the position, over the length; None: the solver's default.
    perturb : float
        Of rods at rest: a force per length of so many EI/L^3 pushes across the rod while the loads
        grow. A straight column so finds its buckled shape.
    branch : int
        Of rods at rest: leave the path of the unstressed rod at the so many-th bifurcation.

    Returns
    -------
    Solution
    """
    shape, s, t = points(s, t)
    times = numpy.unique(t)
    asked = 0.0 if tolerance is None else number_of("tolerance", tolerance, 0,
                                                    "a number above 0, None: the default")
    push = number_of("perturb", perturb, 0, "0 and more") if perturb != 0 else 0.0
    options = library.SolveOptions(asked, push, whole("branch", branch, 0, 2**31 - 1))
    with scene_file(scene) as path:
        handle = Made(library.solution_free, library.solve_file, path, *overrides_of(overrides),
                      ctypes.byref(options), times.size, times.ctypes.data)
    return Solution(handle, shape, s, t)


def identify(scene: Scene, overrides: Overrides = (), threads: Optional[int] = None) -> Unknowns:
    """Find the unknowns of a scene (parameters with `identify`) from its data.

    Parameters
    ----------
    scene : path or dict
        A YAML file, or what would be in one.
    overrides : dict or list of str
        Keys to change.
    threads : int, optional
        None: one per processor. Results do not depend on it.
    """
    count = threads_of(threads)
    with scene_file(scene) as path:
        return Unknowns(Made(library.unknowns_free, library.identify_file, path,
                             *overrides_of(overrides), count))
