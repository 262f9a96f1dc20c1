"""Robots in steps of time: trained one-step models and reduced rods, many states at once."""
from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy

from . import _library as library
from ._given import (Numbers, Overrides, PathLike, Scene, Values, array_of, number_of,
                     overrides_of, pointer, rows, scene_file, text_of, threads_of)
from ._library import Array, InputError, Made


class Step(NamedTuple):
    """States a step later, with their derivatives."""

    states: Array  #: [members, states]
    by_state: Array  #: [members, states, states]
    by_inputs: Array  #: [members, states, inputs]


class OneStep:
    """A robot whose state is stepped, many states at once and on several threads. Made by
    `one_step` and `reduced_rod`. One call at a time.

    Attributes
    ----------
    step : float
        Of time, s.
    length : float
        Of the robot, m.
    states : int
        Numbers of a state: modes of the strains, then their rates.
    ranges : dict of str to (float, float)
        Inputs in their order, with their ranges in SI units.
    slow : list of str
        Inputs that stay while the robot moves, such as a stiffness.
    ramps : bool
        Inputs go linearly within a step, to those at its end (`surrogate.hold: linear`).
    """

    def __init__(self, handle: Made) -> None:
        self._handle = handle
        self.step: float = library.stepper_step(handle)
        self.length: float = library.stepper_length(handle)
        self.states: int = library.stepper_states(handle)
        self.ramps: bool = library.stepper_ramps(handle)
        found = [library.stepper_input(handle, i).contents
                 for i in range(library.stepper_inputs(handle))]
        self.ranges: dict[str, tuple[float, float]] = {p.name.decode(): (p.low, p.high)
                                                       for p in found}
        self.slow = [name for i, name in enumerate(self.ranges)
                     if library.stepper_is_slow(handle, i)]

    def __repr__(self) -> str:
        return (f"<cpinn.OneStep: {self.states} states, inputs {', '.join(self.ranges)}, "
                f"{1000 * self.step:g} ms>")

    def _given(self, states: Numbers, inputs: Values) -> tuple[Array, Array]:
        x, u = self._states(states), rows(inputs, list(self.ranges), "inputs")
        if len(u) == 1 and len(x) > 1:
            u = numpy.repeat(u, len(x), axis=0)
        if len(x) == 1 and len(u) > 1:
            x = numpy.repeat(x, len(u), axis=0)
        if len(x) != len(u):
            raise InputError(f"{len(x)} states and {len(u)} rows of inputs; allowed: as many, or "
                             "one of either")
        return x, u

    def _states(self, states: Numbers) -> Array:
        x = array_of("states", states)
        if x.shape[-1:] != (self.states,):
            raise InputError(f"states have the shape {x.shape}; allowed: (members, {self.states})")
        return x.reshape(-1, self.states)

    def rest(self, inputs: Values) -> Array:
        """Equilibria of the reduced rod under inputs.

        Parameters
        ----------
        inputs : array_like, shape (members, inputs), or dict of str to array_like

        Returns
        -------
        ndarray, shape (members, states)
            NaN where none is found, or an input is outside its range.
        """
        u = rows(inputs, list(self.ranges), "inputs")
        states = numpy.empty((len(u), self.states))
        library.stepper_rest(self._handle, len(u), u.ctypes.data, states.ctypes.data)
        return states

    def advance(self, states: Numbers, inputs: Values, after: Optional[Values] = None) -> Array:
        """States a step later.

        Parameters
        ----------
        states : array_like, shape (members, states)
        inputs : array_like, shape (members, inputs), or dict of str to array_like
            In SI units, within their ranges, at the begin of the step.
        after : optional
            Inputs at the end of the step, to which they go linearly; None: they stay. A trained
            model takes what it was trained for (`ramps`).

        Returns
        -------
        ndarray, shape (members, states)
            NaN where there is no answer.
        """
        return self._advance(states, inputs, after, False).states

    def derivatives(self, states: Numbers, inputs: Values,
                    after: Optional[Values] = None) -> Step:
        """The same with exact derivatives by states and inputs (with `after`: of both ends moved
        together)."""
        return self._advance(states, inputs, after, True)

    def _advance(self, states: Numbers, inputs: Values, after: Optional[Values],
                 derive: bool) -> Step:
        x, u = self._given(states, inputs)
        end = None if after is None else self._given(x, after)[1]
        n, m = self.states, len(self.ranges)
        found = Step(numpy.empty_like(x), numpy.empty((len(x), n, n) if derive else 0),
                     numpy.empty((len(x), n, m) if derive else 0))
        library.call(library.stepper_advance, self._handle, len(x), pointer(x), pointer(u),
                     pointer(end), pointer(found.states),
                     *([pointer(found.by_state), pointer(found.by_inputs)] if derive
                       else [None, None]))
        return found

    def _seen(self, states: Numbers) -> Array:
        x = self._states(states)
        seen = numpy.empty((len(x), 10))
        library.stepper_tip(self._handle, len(x), x.ctypes.data, seen.ctypes.data)
        return seen

    def tip(self, states: Numbers) -> dict[str, Array]:
        """The end of the robot.

        Parameters
        ----------
        states : array_like, shape (members, states)

        Returns
        -------
        dict of str to ndarray
            position (members, 3) in m, rotation (members, 4), unit, body to world, and velocity
            (members, 3) in m/s.
        """
        seen = self._seen(states)
        return {"position": seen[:, :3], "rotation": seen[:, 3:7], "velocity": seen[:, 7:]}


def one_step(path: PathLike, threads: Optional[int] = 1) -> OneStep:
    """Open a trained one-step model: the folder of a run of a scene with the section `surrogate`,
    or its checkpoint. threads: None, one per processor; results do not depend on it."""
    return OneStep(Made(library.stepper_free, library.stepper_open, text_of(path),
                        threads_of(threads)))


def reduced_rod(scene: Scene, step: Optional[float] = None, overrides: Overrides = (),
                threads: Optional[int] = 1) -> OneStep:
    """The reduced rod of a scene in motion: modes of its strains, by Radau's method.

    Parameters
    ----------
    scene : path or dict
        Its parameters with ranges are the inputs.
    step : float, optional
        s; None: that of the scene's section `surrogate`, whose modes are taken as well.
    overrides : dict or list of str
        Keys to change.
    threads : int, optional
        None: one per processor. Results do not depend on it.
    """
    asked = 0.0 if step is None else number_of("step", step, 0, "a number of s above 0, None: "
                                               "that of the scene")
    with scene_file(scene) as path:
        return OneStep(Made(library.stepper_free, library.stepper_file, path,
                            *overrides_of(overrides), asked, threads_of(threads)))
