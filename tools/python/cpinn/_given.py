"""What a caller gives: texts, numbers, arrays, scenes; checked before C sees it."""
from __future__ import annotations

import contextlib
import ctypes
import io
import json
import math
import operator
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Union

import numpy
import numpy.typing

from ._library import ArgumentTypeError, Array, Error, InputError, S

# Of autodiff/ad.h.
_THREADS_MAX = 1024

PathLike = Union[str, "os.PathLike[str]"]
Scene = Union[PathLike, Mapping[str, Any]]
Overrides = Union[Mapping[str, Any], Iterable[str]]
Numbers = numpy.typing.ArrayLike
Values = Union[Numbers, Mapping[str, Numbers]]


def text_of(text: Any) -> bytes:
    """A text or path for C, which would take a zero byte for its end."""
    try:
        encoded = os.fsencode(text)
    except TypeError:
        raise ArgumentTypeError(f"{text!r}: is of type {type(text).__name__}; allowed: str or a "
                                "path") from None
    if b"\0" in encoded:
        raise InputError(f"{text!r}: has a zero byte; allowed: texts without one")
    return encoded


def whole(name: str, value: Any, low: int, high: int, none: str = "") -> int:
    """A whole number, where ctypes would take its last 32 bits."""
    wanted = f"{name}: is {value!r}; allowed: a whole number from {low} to {high}{none}"
    if isinstance(value, (bool, numpy.bool_)):
        raise ArgumentTypeError(wanted)
    try:
        number = operator.index(value)
    except TypeError:
        raise ArgumentTypeError(wanted) from None
    if not low <= number <= high:
        raise InputError(wanted)
    return number


def threads_of(threads: Any) -> int:
    return 0 if threads is None else whole("threads", threads, 1, _THREADS_MAX,
                                           ", None: one per processor")


def number_of(name: str, value: Any, low: float, allowed: str) -> float:
    """A finite number above `low`."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ArgumentTypeError(f"{name}: is {value!r}; allowed: {allowed}") from None
    if not (math.isfinite(number) and number > low):
        raise InputError(f"{name}: is {value!r}; allowed: {allowed}")
    return number


def array_of(name: str, values: Any) -> Array:
    """An array of doubles, of real numbers only."""
    try:
        given = numpy.asarray(values)
        if given.dtype.kind not in "biuf" and given.size:
            raise TypeError
        return numpy.asarray(given, dtype=float, order="C")
    except (TypeError, ValueError):
        raise ArgumentTypeError(f"{name}: is {repr(values):.80}; allowed: real numbers, or an array of "
                                "them") from None


def finite(name: str, values: Array) -> Array:
    if not numpy.isfinite(values).all():
        place = tuple(int(i) for i in numpy.argwhere(~numpy.isfinite(values))[0])
        at = f"[{', '.join(map(str, place))}]" if place else ""
        raise InputError(f"{name}{at} is {values[place]}; allowed: finite numbers")
    return values


def points(s: Any, t: Any) -> tuple[tuple[int, ...], Array, Array]:
    """The shape of s and t together, and both as flat arrays of finite doubles."""
    try:
        s, t = numpy.broadcast_arrays(finite("s", array_of("s", s)), finite("t", array_of("t", t)))
    except ValueError as error:
        if isinstance(error, Error):
            raise
        raise InputError(f"s has the shape {numpy.shape(s)} and t {numpy.shape(t)}; allowed: "
                         "shapes that numpy broadcasts against each other") from None
    return s.shape, numpy.ascontiguousarray(s.ravel()), numpy.ascontiguousarray(t.ravel())


def rows(values: Values, names: Sequence[str], what: str = "at") -> Array:
    """Rows [members, names] from an array of such, or from numbers by name, broadcast."""
    if isinstance(values, Mapping):
        if set(values) != set(names):
            raise InputError(f"{what} names {', '.join(map(str, values)) or 'nothing'}; allowed: "
                             f"each of {', '.join(names)}")
        columns = [array_of(name, values[name]) for name in names]
        try:
            columns = list(numpy.broadcast_arrays(*columns))
        except ValueError:
            shapes = ", ".join(f"{name} {c.shape}" for name, c in zip(names, columns))
            raise InputError(f"{what} has arrays of the shapes {shapes}; allowed: shapes that "
                             "numpy broadcasts against each other") from None
        given = numpy.stack([column.ravel() for column in columns], axis=1)
    else:
        given = array_of(what, values)
        if len(names) > 1 and given.shape[-1:] != (len(names),):
            raise InputError(f"{what} has the shape {given.shape}; allowed: a column each for "
                             f"{', '.join(names)}")
    return finite(what, numpy.ascontiguousarray(given.reshape(-1, len(names)), dtype=float))


def _plain(value: Any) -> Any:
    """What json does not know: numbers and arrays of numpy, and paths."""
    if isinstance(value, (numpy.ndarray, numpy.generic)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise ArgumentTypeError(f"{repr(value):.80}: is of type {type(value).__name__}; allowed: "
                            "numbers, texts, lists, dicts, arrays of numpy")


def _json(value: Any) -> str:
    try:
        return json.dumps(value, default=_plain, allow_nan=False)
    except Error:
        raise
    except ValueError:
        raise InputError(f"{repr(value):.80}: has a number that is not finite; allowed: finite "
                         "numbers") from None
    except TypeError:
        raise ArgumentTypeError(f"{repr(value):.80}: has a key that is no text; allowed: texts") \
            from None


def overrides_of(overrides: Overrides) -> tuple[int, Any]:
    if isinstance(overrides, (str, bytes)) or not isinstance(overrides, (Mapping, Iterable)):
        raise ArgumentTypeError(f"overrides: {repr(overrides):.80} is a {type(overrides).__name__}; "
                                "allowed: a dict, a list of 'key=value'")
    if isinstance(overrides, Mapping):
        overrides = [f"{key}={value if isinstance(value, str) else _json(value)}"
                     for key, value in overrides.items()]
    texts = [text_of(text) for text in overrides]
    return len(texts), (S * (len(texts) + 1))(*texts)


@contextlib.contextmanager
def scene_file(scene: Scene) -> Iterator[bytes]:
    """The path of a scene; one that is given as a dict is a file of YAML, of which JSON is a part,
    for so long. What is wrong with it has a key and no place."""
    if not isinstance(scene, Mapping):
        yield text_of(scene)
        return
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.yaml")
        with io.open(path, "w", encoding="utf-8") as file:
            file.write(_json(dict(scene)))
        try:
            yield os.fsencode(path)
        except Error as error:
            place, _, rest = str(error).partition(": ")
            raise type(error)(rest if place.startswith(path) else str(error)) from None


def pointer(array: Any) -> Any:
    """Where the numbers of an array are, for C; None: NULL."""
    return None if array is None else ctypes.c_void_p(array.ctypes.data)
