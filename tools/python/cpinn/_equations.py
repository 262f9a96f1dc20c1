"""Equations of one's own: what they are, and their solutions."""
from __future__ import annotations

import ctypes
import dataclasses
import os
from collections.abc import Callable, Mapping
from typing import Any, Optional, Union

import numpy

from . import _library as library
from ._formulas import Formula, formula_of
from ._given import (Numbers, Overrides, PathLike, array_of, number_of, overrides_of, scene_file,
                     text_of, threads_of)
from ._library import ArgumentTypeError, Array, InputError, Made, P
from ._model import handed_on, interrupts, verdict_of


@dataclasses.dataclass(frozen=True)
class Face:
    """Where a coordinate has one value. Made by ``x == 1``."""

    coordinate: "Coordinate"
    value: float

    def __bool__(self) -> bool:
        raise ArgumentTypeError(f"{self.coordinate} == {self.value}: is true or false nowhere; it is a "
                                "place for conditions, m.at(x == 1, ...)")


class Coordinate(Formula):
    """A coordinate. Made by `Equations.coordinate`; ``x == 1`` is the face where it is 1."""

    def __eq__(self, value: Any) -> Any:
        return Face(self, number_of(self.text, value, -numpy.inf, "a number"))

    def __ne__(self, value: Any) -> Any:
        raise ArgumentTypeError(f"{self} != {value!r}: allowed: {self} == {value!r}, of a face")

    __hash__ = object.__hash__


class Field(Formula):
    """A field, a named formula, or a derivative of one: ``u.d(x)``, ``u.d(x, 2)``, ``u.d(x).d(t)``.
    Made by `Equations.field` and `Equations.formula`."""

    def __init__(self, name: str, of: "Equations", by: tuple[str, ...] = ()) -> None:
        together = all(len(name) == 1 for name in by)
        super().__init__(f"{name}_{('' if together else '_').join(by)}" if by else name, of=of)
        self.name, self.by = name, by

    def d(self, coordinate: Formula, order: int = 1) -> "Field":
        """The derivative by a coordinate, `order` times."""
        if not isinstance(coordinate, Coordinate) or coordinate.of is not self.of:
            raise ArgumentTypeError(f"{self}.d({coordinate!r}): allowed: a coordinate of the same "
                                    "equations")
        assert self.of is not None
        return Field(self.name, self.of, self.by + (coordinate.text,) * int(order))


class Equations:
    """Equations of one's own, for `fit`.

        m = cpinn.Equations()
        x = m.coordinate("x", -1, 1)
        t = m.coordinate("t", 0, 1, time=True)
        u = m.field("u")
        m.inside(u.d(t) + u*u.d(x) - 0.01/pi*u.d(x, 2))
        m.at(t == 0, u, -sin(pi*x))
        m.at(x == -1, u, 0)
        m.at(x == 1, u, 0)

    All numbers are in SI units. What is wrong is said where it is added.
    """

    def __init__(self) -> None:
        def create(out: Any, error: Any) -> int:
            out._obj.value = library.equations_create()
            return 0 if out._obj.value else 1
        self._handle = Made(library.equations_free, create)
        self._unnamed = 0

    def _add(self, function: Any, *arguments: Any) -> None:
        library.call(function, self._handle, *arguments)

    def coordinate(self, name: str, low: float, high: float, time: bool = False,
                   periodic: bool = False, unit: str = "") -> Coordinate:
        """Add a coordinate.

        Parameters
        ----------
        name : str
        low, high : float
            Its range.
        time : bool
            One coordinate may be time, which is followed from its start.
        periodic : bool
            Without ends: what is at `low` is at `high`.
        unit : str
            Of the SI.
        """
        given = library.EquationsCoordinate(text_of(name), text_of(unit), float(low), float(high),
                                            bool(periodic), bool(time))
        self._add(library.equations_add_coordinate, ctypes.byref(given))
        return Coordinate(str(name), of=self)

    def parameter(self, name: str, low: float, high: float) -> Formula:
        """Add a parameter with a range: it is solved for all values between, as one more coordinate
        of the solution."""
        self._add(library.equations_add_range, text_of(name), float(low), float(high))
        return Formula(str(name), of=self)

    def unknown(self, name: str, guess: float) -> Formula:
        """Add an unknown number, which data determine from a guess on."""
        self._add(library.equations_add_unknown, text_of(name), float(guess))
        return Formula(str(name), of=self)

    def field(self, name: str) -> Field:
        """Add a field, which is sought."""
        self._add(library.equations_add_field, text_of(name))
        return Field(str(name), self)

    def formula(self, name: Optional[str], formula: Any) -> Field:
        """Give a formula a name, None: one of its own; it can then be differentiated, as a flux in
        ``m.inside(u.d(t) + (k*u.d(x)).d(x))`` is unasked."""
        if name is None:
            self._unnamed += 1
            name = f"_{self._unnamed}"
        self._add(library.equations_add_parameter, text_of(name), self._text(formula))
        return Field(str(name), self)

    def _text(self, formula: Any) -> bytes:
        made = formula if isinstance(formula, str) else formula_of(formula)
        if isinstance(made, Formula) and made.of not in (None, self):
            raise InputError(f"{made}: is of other equations; allowed: names of these")
        return text_of(str(made))

    def inside(self, *formulas: Union[Formula, str]) -> None:
        """Add equations: each formula is zero everywhere inside."""
        for formula in formulas:
            self._add(library.equations_add_inside, self._text(formula))

    def at(self, face: Face, what: Union[Field, Formula, str], value: Any = None) -> None:
        """Add a condition.

        Parameters
        ----------
        face : Face
            An end of a coordinate, or the start of time: ``x == 1``.
        what : Field or Formula
            A field or its derivative by this coordinate.
        value : number or Formula, optional
            What it is there. None: `what` is any formula, which is zero there.
        """
        if not isinstance(face, Face):
            raise ArgumentTypeError(f"{face!r}: is no face; allowed: a coordinate and a value, x == 1")
        if value is None:
            name, formula = b"zero", self._text(what)
        elif isinstance(what, Formula) and not isinstance(what, Field):
            raise ArgumentTypeError(f"({what}): is no field; allowed: a field or a derivative of one "
                                    "with a value, or a formula without, which is zero")
        else:
            name, formula = self._text(what), self._text(value)
        self._add(library.equations_add_condition, text_of(face.coordinate.text), face.value, name,
                  formula)

    def data(self, noise: Optional[float] = None, **columns: Numbers) -> None:
        """Add measured numbers.

        Parameters
        ----------
        noise : float, optional
            Standard deviation of the fields; None: not known.
        **columns : array_like
            All coordinates and one field at least, or derivatives such as ``u_x``, broadcast against
            each other; NaN of a field: not measured there.
        """
        names = [text_of(name) for name in columns]
        try:
            arrays = numpy.broadcast_arrays(*(array_of(name, columns[name]) for name in columns))
        except ValueError as error:
            if isinstance(error, library.Error):
                raise
            raise InputError("data: has columns of shapes that numpy does not broadcast against each "
                             "other; allowed: one number for each measured place") from None
        flat = [numpy.ascontiguousarray(array.ravel()) for array in arrays]
        known = 0.0 if noise is None else number_of("noise", noise, 0, "a number above 0, None")
        self._add(library.equations_add_data, flat[0].size if flat else 0, len(flat),
                  (ctypes.c_char_p * (len(flat) + 1))(*names),
                  (P * (len(flat) + 1))(*(array.ctypes.data for array in flat)), known)


@dataclasses.dataclass(frozen=True)
class FitProgress:
    """Where a fit stands.

    Attributes
    ----------
    attempt, window, patches : int
        Attempts and windows of time counted from 1; patches of this window.
    done : float
        The part of the time that is done.
    estimate : float
        Of the error so far.
    seconds : float
    """

    attempt: int
    window: int
    done: float
    estimate: float
    seconds: float
    patches: int

    def __str__(self) -> str:
        return (f"attempt {self.attempt}, window {self.window}: {100 * self.done:.0f} % of time, "
                f"{self.patches} patches, error {self.estimate:.1e}, {self.seconds:.1f} s")


class Fit:
    """A solution of equations. Made by `fit` and `open_fit`. Its fields are functions of the
    coordinates: ``s.u(x, t)``.

    Attributes
    ----------
    verdict : Verdict
    error : float
        Estimated: root mean square over that of the fields, of the field that is worst.
    by_unknowns : float
        The part of it that comes from the deviations of the unknowns; the tolerance is of the rest.
    coordinates, fields : list of str
        Names; parameters with a range are coordinates.
    unknowns, deviations : dict of str to float
        Unknown numbers and their standard deviations.
    seconds : float
    """

    def __init__(self, handle: Made, equations: Optional[Equations] = None) -> None:
        self._handle, self._equations = handle, equations  # which outlive it
        summary = library.fit_summary(handle)
        self.verdict = verdict_of(library.fit_verdict(handle))
        self.error: float = summary.estimate
        self.by_unknowns: float = summary.by_unknowns
        self.seconds: float = summary.seconds
        self.coordinates = _names(library.fit_coordinate, handle)
        self.fields = _names(library.fit_field, handle)
        unknowns = _names(library.fit_unknown, handle)
        self.unknowns: dict[str, float] = dict(zip(unknowns, summary.unknown))
        self.deviations: dict[str, float] = dict(zip(unknowns, summary.deviation))

    def __repr__(self) -> str:
        found = "".join(f", {name} = {value:.6g} +- {self.deviations[name]:.1g}"
                        for name, value in self.unknowns.items())
        return (f"<cpinn.Fit: {', '.join(self.fields)} of {', '.join(self.coordinates)}{found}; error "
                f"about {self.error:.1e}; {self.verdict}>")

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self.fields:
            raise AttributeError(f"a fit has no {name}; it has the fields {', '.join(self.fields)}"
                                 if not name.startswith("_") else name)
        return lambda *at, **named: self.evaluate(name, *at, **named)

    def _places(self, at: tuple[Any, ...], named: Mapping[str, Any]) -> tuple[Any, list[Array]]:
        names = self.coordinates
        given = dict(zip(names, at))
        twice = len(at) > len(names) or set(given) & set(named)
        given.update(named)
        if twice or set(given) != set(names):
            raise InputError(f"places: allowed: each of {', '.join(names)} once, in this order or by "
                             "name")
        try:
            arrays = numpy.broadcast_arrays(*(array_of(name, given[name]) for name in names))
        except ValueError as error:
            if isinstance(error, library.Error):
                raise
            raise InputError("places: are of shapes that numpy does not broadcast against each "
                             "other") from None
        return arrays[0].shape, [numpy.ascontiguousarray(array.ravel()) for array in arrays]

    def _ask(self, name: str, at: tuple[Any, ...], named: Mapping[str, Any]) -> tuple[Array, Array]:
        shape, places = self._places(at, named)
        values, errors = numpy.empty(places[0].size), numpy.empty(places[0].size)
        library.call(library.fit_evaluate, self._handle, text_of(name), values.size,
                     (P * len(places))(*(place.ctypes.data for place in places)),
                     values.ctypes.data, errors.ctypes.data)
        return values.reshape(shape), errors.reshape(shape)

    def evaluate(self, name: str, *at: Numbers, **named: Numbers) -> Array:
        """A field or a derivative of one.

        Parameters
        ----------
        name : str
            "u", "u_x", "u_xxt".
        *at, **named : array_like
            All coordinates, in the order of `coordinates` or by name, broadcast against each other.

        Returns
        -------
        ndarray
            NaN beyond the time that was reached.
        """
        return self._ask(name, at, named)[0]

    def errors(self, name: str, *at: Numbers, **named: Numbers) -> Array:
        """Estimated errors of a field or a derivative at places."""
        return self._ask(name, at, named)[1]

    def save(self, path: PathLike) -> None:
        """Keep the solution in a file of HDF5, for `open_fit`."""
        library.call(library.fit_save, self._handle, text_of(path))


def _names(function: Any, handle: Made) -> list[str]:
    names: list[str] = []
    while True:
        name = function(handle, len(names))
        if name is None:
            return names
        names.append(name.decode())


def fit(model: Union[Equations, PathLike, Mapping[str, Any]], tolerance: Optional[float] = None,
        seconds: Optional[float] = None, threads: Optional[int] = None, overrides: Overrides = (),
        progress: Optional[Callable[[FitProgress], Any]] = None) -> Fit:
    """Solve equations of one's own.

    Parameters
    ----------
    model : Equations, path or dict
        Equations; or a YAML file with a section `equations`, or what would be in one.
    tolerance : float, optional
        Of the estimated error, relative to the fields; None: of the file, or 1e-6.
    seconds : float, optional
        What it may take; None: of the file, or 60.
    threads : int, optional
        None: one per processor.
    overrides : dict or list of str
        Of a file, keys to change: ``{"equations.parameters.nu": 0.02}``.
    progress : callable, optional
        Called with a `FitProgress` on the way (``print`` will do); False stops. What it raises ends
        the fit, as Ctrl-C does, and is raised again.

    Returns
    -------
    Fit
        Also where the tolerance is not met: its verdict says so.
    """
    raised: list[BaseException] = []

    def stepped(_: Any, now: Any) -> bool:
        return handed_on(raised, progress, FitProgress, now)

    allowed = "a number above 0, None: the default"
    options = library.FitOptions(
        0.0 if tolerance is None else number_of("tolerance", tolerance, 0, allowed),
        0.0 if seconds is None else number_of("seconds", seconds, 0, allowed),
        threads_of(threads), library.FIT_PROGRESS(stepped))
    if isinstance(model, Equations):
        with interrupts(raised):
            found = Fit(Made(library.fit_free, library.fit_equations, model._handle,
                             ctypes.byref(options)), model)
    elif isinstance(model, (str, bytes, os.PathLike, Mapping)):
        with scene_file(model) as path, interrupts(raised):
            found = Fit(Made(library.fit_free, library.fit_file, path, *overrides_of(overrides),
                             ctypes.byref(options)))
    else:
        raise ArgumentTypeError(f"{model!r}: is a {type(model).__name__}; allowed: cpinn.Equations, a "
                                "path, a dict")
    if raised:
        raise raised[0]
    return found


def open_fit(path: PathLike) -> Fit:
    """Open a solution that `Fit.save` or cpinn-fit has kept."""
    return Fit(Made(library.fit_free, library.fit_open, text_of(path)))
