"""Models that are trained or opened: their verdict, history, values and derivatives."""
from __future__ import annotations

import contextlib
import ctypes
import dataclasses
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Optional

import numpy

from . import _library as library
from ._given import (Numbers, Overrides, PathLike, Scene, array_of, overrides_of, points,
                     scene_file, text_of, threads_of)
from ._library import Array, InputError, Made

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclasses.dataclass(frozen=True)
class Verdict:
    """How a computation has ended.

    Attributes
    ----------
    outcome : str
        "solved", "warning" or "stopped".
    reason : str
        One word for the worst finding; "none" without one.
    text : str
        What was found and what to do; "" without a finding.
    """

    outcome: str
    reason: str
    text: str

    def __str__(self) -> str:
        return f"{self.outcome} ({self.reason}): {self.text}" if self.text else self.outcome


def verdict_of(handle: Any) -> Verdict:
    return Verdict(library.outcome_name(library.outcome_of(handle)).decode(),
                   library.reason_name(library.worst_reason(handle)).decode(),
                   library.verdict_text(handle).decode(errors="replace"))


@dataclasses.dataclass(frozen=True)
class Progress:
    """Where training stands after a step; numbers that are not known are NaN.

    Attributes
    ----------
    step : int
        Over all windows and stages, from 1.
    window, windows, stage, stages : int
        Windows of time and stages of the optimiser, counted from 1.
    load_factor : float
        The part of the loads at work; 1: all of them.
    loss, held_out : float
        The weighted loss; the same at points that are never trained on.
    error : float
        Relative, against the reference of the scene.
    seconds : float
        Of training so far.
    """

    step: int
    window: int
    windows: int
    stage: int
    stages: int
    load_factor: float
    loss: float
    held_out: float
    error: float
    seconds: float

    def __str__(self) -> str:
        where = f"window {self.window} of {self.windows}, " if self.windows > 1 else ""
        return (f"{where}step {self.step}: loss {self.loss:.3e}, held out {self.held_out:.3e}, "
                f"error {self.error:.3e}, {self.seconds:.1f} s")


def fill(function: Any, handle: Any, names: list[str], shape: tuple[int, ...], s: Array,
         t: Array) -> dict[str, Array]:
    """Columns by name, each of the shape of s and t together."""
    values = numpy.empty((len(names), s.size))
    library.call(function, handle, s.size, s.ctypes.data, t.ctypes.data, values.ctypes.data)
    return {name: values[i].reshape(shape) for i, name in enumerate(names)}


def pyplot() -> Any:
    """matplotlib.pyplot, or why it is not there."""
    try:
        import matplotlib.pyplot
    except ImportError as error:
        raise ImportError("plot() needs matplotlib, which is not installed; install it with "
                          "'pip install matplotlib', or draw what evaluate() returns with another "
                          "library") from error
    return matplotlib.pyplot


def plot_shapes(axes: Optional["Axes"], position: Array, labels: Sequence[str],
                style: dict[str, Any]) -> "Axes":
    """Shapes [shapes, points, 3] in m, in the plane of the coordinates that spread most."""
    axes = pyplot().figure().add_subplot() if axes is None else axes
    spread = numpy.ptp(position.reshape(-1, 3), axis=0)
    across, up = sorted(int(i) for i in numpy.argsort(-spread, kind="stable")[:2])
    for shape, label in zip(position, labels):
        axes.plot(shape[:, across], shape[:, up], **{"label": label, **style})
    axes.set_xlabel(f"{'xyz'[across]} (m)")
    axes.set_ylabel(f"{'xyz'[up]} (m)")
    axes.set_aspect("equal", adjustable="datalim")
    if 1 < len(position) <= 10:
        axes.legend()
    return axes


class Model:
    """A trained model. Made by `train` and `open`; used by one thread at a time.

    Attributes
    ----------
    verdict : Verdict
        How training has ended.
    estimate : float
        Of the error of the position, over the length; NaN: not known.
    history : dict of str to ndarray
        The columns of history.csv, one number for each row.
    columns : list of str
        Names that `evaluate` knows, without derivatives.
    """

    def __init__(self, handle: Made) -> None:
        self._handle = handle
        self._evaluators: dict[Optional[str], Made] = {}
        self.verdict = verdict_of(library.model_verdict(handle))
        self.estimate: float = library.model_estimate(handle)
        names = [library.history_name(handle, i) for i in range(library.history_columns(handle))]
        self.history: dict[str, Array] = {
            name.decode(): numpy.array([library.history_value(handle, row, name)
                                        for row in range(library.history_rows(handle))])
            for name in names}

    def __repr__(self) -> str:
        steps = len(self.history.get("step", ()))
        return (f"<cpinn.Model: {self.verdict.outcome}"
                f"{f' ({self.verdict.reason})' if self.verdict.text else ''}, error about "
                f"{self.estimate:.1e} of the length, {steps} rows of history>")

    def _evaluator(self, names: Optional[str]) -> Made:
        if names not in self._evaluators:
            wanted = text_of(names) if names is not None else None
            self._evaluators[names] = Made(library.evaluator_free, library.create_evaluator,
                                           self._handle, wanted)
        return self._evaluators[names]

    @staticmethod
    def _columns(made: Made) -> list[str]:
        return [library.evaluator_name(made, i).decode()
                for i in range(library.evaluator_columns(made))]

    @property
    def columns(self) -> list[str]:
        return self._columns(self._evaluator(None))

    @property
    def in_motion(self) -> bool:
        """Whether the model depends on time."""
        try:
            self._evaluator(self.columns[0] + "_t")
        except InputError:
            return False
        return True

    @staticmethod
    def differentiated(columns: Iterable[str], by: str) -> tuple[str, ...]:
        """Names of the derivatives of columns by s and t as often as `by` says."""
        return tuple(name + ("" if "_" in name else "_") + by for name in columns)

    def units(self, names: Optional[str] = None) -> dict[str, str]:
        """SI units of columns and derivatives by name; "" for numbers without one."""
        made = self._evaluator(names)
        return {name: library.evaluator_unit(made, i).decode()
                for i, name in enumerate(self._columns(made))}

    def evaluate(self, names: Optional[str] = None, s: Numbers = 0.0,
                 t: Numbers = 0.0) -> dict[str, Array]:
        """Values and derivatives, exact ones of the network.

        Parameters
        ----------
        names : str, optional
            Columns, separated by spaces: "x", "qw", "m2", of beams "w"; r and q for all of a
            position and a rotation; behind an underscore s and t as often as differentiated, up
            to four times: "z_tt", "x_s". None: every column.
        s, t : array_like
            Arc length (m) and time (s), broadcast against each other.

        Returns
        -------
        dict of str to ndarray
            In SI units (`units`), each of the shape of s and t together.
        """
        made = self._evaluator(names)
        return fill(library.evaluator_evaluate, made, self._columns(made), *points(s, t))

    def derivative(self, names: str, by: str, s: Numbers = 0.0,
                   t: Numbers = 0.0) -> dict[str, Array]:
        """Derivatives of columns, under the names of the columns themselves.

        Parameters
        ----------
        names : str
            Columns as in `evaluate`, which may be derivatives already.
        by : str
            s and t as often as differentiated: "s", "tt", "st".
        s, t : array_like
            Arc length (m) and time (s), broadcast against each other.

        Returns
        -------
        dict of str to ndarray
            In SI units of the column by m for each s and by s for each t.
        """
        if not by or set(by) - set("st"):
            raise InputError(f"by: is {by!r}; allowed: s and t as often as differentiated, as in "
                             "'s', 'tt', 'st'")
        wanted = self._columns(self._evaluator(names))
        made = self._evaluator(" ".join(self.differentiated(wanted, by)))
        return fill(library.evaluator_evaluate, made, wanted, *points(s, t))

    def plot(self, s: Numbers, t: Numbers = 0.0, axes: Optional["Axes"] = None,
             **style: Any) -> "Axes":
        """Draw the rod at instants, in the plane in which it spreads most.

        Parameters
        ----------
        s : array_like, shape (points,)
            Places along the rod, m.
        t : array_like, shape () or (instants,)
            Instants, s.
        axes : matplotlib.axes.Axes, optional
            Where to draw; None: a new figure.
        **style
            Passed to `Axes.plot`.

        Returns
        -------
        matplotlib.axes.Axes
        """
        instants = array_of("t", t).ravel()
        found = self.evaluate("r", s, instants[:, None])
        return plot_shapes(axes, numpy.stack([found[c] for c in "xyz"], axis=-1),
                           [f"{instant:g} s" for instant in instants], style)

    def save(self, path: PathLike) -> None:
        """Write a checkpoint, of a model that was trained here."""
        library.call(library.save, self._handle, text_of(path))


@contextlib.contextmanager
def interrupts(raised: list[BaseException]) -> Iterator[None]:
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


def handed_on(raised: list[BaseException], progress: Optional[Callable[[Any], Any]], kind: Any,
              now: Any) -> bool:
    """Hands on where C stands, a structure, as `kind`, and what is raised into a list; whether to
    go on."""
    try:
        at = now.contents
        answer = progress(kind(*(getattr(at, name) for name, _ in at._fields_))) \
            if progress else None
        return not raised and (answer is None or bool(answer))
    except BaseException as error:
        raised.append(error)
        return False


def train(scene: Scene, overrides: Overrides = (), threads: Optional[int] = None,
          folder: Optional[PathLike] = None, resume: bool = False,
          progress: Optional[Callable[[Progress], Any]] = None) -> Model:
    """Train a scene.

    Parameters
    ----------
    scene : path or dict
        A YAML file, or what would be in one. Files that a dict names need whole paths.
    overrides : dict or list of str
        Keys to change: ``{"rod.length": 0.3}`` or ``["rod.length=0.3"]``.
    threads : int, optional
        None: one per processor. Results do not depend on it.
    folder : path, optional
        Where the run is kept; None: in memory alone.
    resume : bool
        Go on with the run that is in the folder.
    progress : callable, optional
        Called with a `Progress` after each step (``print`` will do); False stops training. What it
        raises ends training, as Ctrl-C does, and is raised again.

    Returns
    -------
    Model
    """
    raised: list[BaseException] = []

    def stepped(_: Any, now: Any) -> bool:
        return handed_on(raised, progress, Progress, now)

    options = library.TrainOptions(threads_of(threads),
                                   text_of(folder) if folder is not None else None,
                                   bool(resume), library.PROGRESS(stepped))
    with scene_file(scene) as path, interrupts(raised):
        model = Model(Made(library.free_model, library.train_file, path, *overrides_of(overrides),
                           ctypes.byref(options)))
    if raised:
        raise raised[0]
    return model


def open_run(path: PathLike) -> Model:
    """Open a model that was trained before.

    Parameters
    ----------
    path : path
        The folder of a run, or a checkpoint.
    """
    return Model(Made(library.free_model, library.open_model, text_of(path)))
