"""The places of the shared library and of the scenes. An installed package has a file _installed.py
with both, relative to this folder; without it this is the source tree."""
from __future__ import annotations

import ctypes
import os
from typing import Optional

library: Optional[str]
scenes: str
try:
    from ._installed import library, scenes  # type: ignore[import-not-found, no-redef, unused-ignore]
except ImportError:
    library, scenes = None, "../../../configs"


def _path(relative: str) -> str:
    return os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), relative))


def load() -> ctypes.CDLL:
    """The shared library: CPINN_LIBRARY, the installed one, or where the system looks."""
    path = os.environ.get("CPINN_LIBRARY") or (_path(library) if library else "libcpinn.so")
    try:
        return ctypes.CDLL(path)
    except OSError as error:
        raise ImportError(f"cpinn: {error}; install cpinn (pip install cpinn), or set CPINN_LIBRARY "
                          "to the path of libcpinn.so") from None


def example(name: str) -> str:
    """The path of a scene that comes with cpinn, by its name: example("soft_arm").

    An unknown name raises cpinn.Error with the names of all scenes.
    """
    paths = {file[:-len(".yaml")]: os.path.join(folder, file)
             for folder, _, files in os.walk(_path(scenes)) for file in files
             if file.endswith(".yaml")}
    if name not in paths:
        from ._library import InputError
        raise InputError(f"example: {name!r} is no scene; allowed: {', '.join(sorted(paths))}")
    return paths[name]
