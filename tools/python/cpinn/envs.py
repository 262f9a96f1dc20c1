"""Environments of gymnasium: the tip of a robot reaches a place or follows a path.

    import gymnasium
    import cpinn.envs
    envs = cpinn.envs.RodVectorEnv("runs/arm", num_envs=1024, task="reach")
    envs = gymnasium.make_vec("cpinn/Reach-v0", num_envs=1024, robot="runs/arm",
                              vectorization_mode="vector_entry_point")     # the same

All environments are stepped at once by the C library, on all processors. A robot is a trained
one-step model or a reduced rod (`cpinn.one_step`, `cpinn.reduced_rod`). Tasks are drawn from motions
of the reduced rod when the environments are made, so that each can be done; an input that is slow,
such as a stiffness, belongs to the task and is neither an action nor observed.

    action       shape (actions,): [-1, 1] over the range of each input that is not slow
    observation  shape (states + 16 + actions,): the state of the rod; position (m), rotation
                 (w, x, y, z) and velocity (m/s) of the tip; from the tip to the goal (m); velocity
                 of the goal (m/s); the inputs, as actions have them
    reward       -distance of the tip from the goal, over the length of the robot
    truncated    after max_episode_steps; terminated: the model has no answer (reward -1)
    info         "distance" in m

An environment draws from a stream of its own, so that it does the same among any number of others
and on any number of threads.
"""
from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union

import numpy
import numpy.typing

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode
except ImportError as error:
    raise ImportError("cpinn.envs needs gymnasium 1.1 or later; install it with "
                      "'pip install gymnasium'") from error

from . import _library as library
from ._given import Scene, pointer, whole
from ._library import ArgumentTypeError, Array, InputError, Made
from ._steps import OneStep, one_step, reduced_rod

__all__ = ["RodEnv", "RodVectorEnv"]

Robot = Union[OneStep, Scene]
Flags = numpy.typing.NDArray[numpy.bool_]

_TASKS = {"reach": 0, "track": 1}
_RESETS = {AutoresetMode.DISABLED: 0, AutoresetMode.NEXT_STEP: 1, AutoresetMode.SAME_STEP: 2}
_INT_MAX = 2**31 - 1


def _robot(robot: Robot, threads: Optional[int]) -> OneStep:
    """The robot of a run, or of a scene."""
    if isinstance(robot, OneStep):
        return robot
    is_scene = isinstance(robot, Mapping) or os.fspath(robot).endswith((".yaml", ".yml"))
    if is_scene:
        return reduced_rod(robot, threads=threads)
    return one_step(robot, threads=threads)  # type: ignore[arg-type]


class RodVectorEnv(gymnasium.vector.VectorEnv[Array, Array, Any]):
    """Many environments of one robot, which are stepped at once.

    Parameters
    ----------
    robot : path, dict or OneStep
        The folder of a trained one-step model; or a scene in motion (a YAML file or a dict), whose
        reduced rod is stepped.
    num_envs : int
    task : {"reach", "track"}
        A place at which the tip can be at rest; or the path of the tip under inputs that move.
    max_episode_steps : int
    tasks : int
        How many starts and goals are drawn, for all environments to choose from.
    tasks_seed : int
        Of these; they do not depend on the seed of `reset`.
    threads : int, optional
        None: one per processor. Of a robot that is given as a OneStep its own.
    autoreset_mode : gymnasium.vector.AutoresetMode
        What happens to an episode that is over: by default the next step begins another, and its
        action is not taken.
    """

    def __init__(self, robot: Robot, num_envs: int = 1, task: str = "reach",
                 max_episode_steps: int = 100, tasks: int = 256, tasks_seed: int = 0,
                 threads: Optional[int] = None,
                 autoreset_mode: Union[str, AutoresetMode] = AutoresetMode.NEXT_STEP) -> None:
        if task not in _TASKS:
            raise InputError(f"task: is {task!r}; allowed: {', '.join(map(repr, _TASKS))}")
        try:
            mode = AutoresetMode(autoreset_mode)
        except ValueError:
            raise InputError(f"autoreset_mode: is {autoreset_mode!r}; allowed: "
                             f"{', '.join(repr(m.value) for m in AutoresetMode)}") from None
        settings = library.EnvsSettings(
            _TASKS[task], _RESETS[mode], whole("num_envs", num_envs, 1, _INT_MAX),
            whole("max_episode_steps", max_episode_steps, 1, _INT_MAX),
            whole("tasks", tasks, 1, _INT_MAX), whole("tasks_seed", tasks_seed, 0, 2**64 - 1))
        self.robot = _robot(robot, threads)
        self._made: Optional[Made] = Made(library.envs_free, library.envs_create,
                                          self.robot._handle, ctypes.byref(settings))
        self.metadata = {"autoreset_mode": mode, "render_modes": []}
        self.num_envs = num_envs
        self.task = task
        width = library.envs_observed(self._made)
        actions = library.envs_actions(self._made)
        names = list(self.robot.ranges)
        self.action_names = [names[library.envs_action(self._made, i)] for i in range(actions)]
        box = gymnasium.spaces.Box
        self.single_observation_space = box(-numpy.inf, numpy.inf, (width,), numpy.float64)
        self.single_action_space = box(-1.0, 1.0, (actions,), numpy.float64)
        self.observation_space = gymnasium.vector.utils.batch_space(
            self.single_observation_space, num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)
        self._observations: Optional[Array] = None

    def __repr__(self) -> str:
        return (f"<cpinn.envs.RodVectorEnv: {self.num_envs} to {self.task}, actions "
                f"{', '.join(self.action_names)}>")

    def _open(self) -> Made:
        if self._made is None:
            raise gymnasium.error.ClosedEnvironmentError("the environments are closed")
        return self._made

    def _seeds(self, seed: Union[int, Sequence[Optional[int]], None]) \
            -> tuple[Optional[numpy.typing.NDArray[numpy.uint64]], Flags]:
        """Seeds, and which environments have one; of an integer seed, seed + 1, ..."""
        if seed is None and self._observations is None:
            drawn = numpy.random.SeedSequence().generate_state(self.num_envs, numpy.uint64)
            return drawn.astype(numpy.uint64), numpy.ones(self.num_envs, dtype=bool)
        if seed is None:
            return None, numpy.zeros(self.num_envs, dtype=bool)
        if isinstance(seed, (int, numpy.integer)):
            first = whole("seed", seed, 0, 2**63 - 1)
            return (numpy.arange(self.num_envs, dtype=numpy.uint64) + numpy.uint64(first),
                    numpy.ones(self.num_envs, dtype=bool))
        if len(seed) != self.num_envs:
            raise InputError(f"seed has {len(seed)} numbers; allowed: one number, or "
                             f"{self.num_envs}, one for each environment")
        given = [0 if one is None else whole("seed", one, 0, 2**64 - 1) for one in seed]
        return (numpy.array(given, dtype=numpy.uint64),
                numpy.array([one is not None for one in seed]))

    def reset(self, *, seed: Union[int, Sequence[Optional[int]], None] = None,
              options: Optional[dict[str, Any]] = None) -> tuple[Array, dict[str, Any]]:
        """Begin episodes.

        Parameters
        ----------
        seed : int or sequence of int, optional
            Of the first environment, whose followers have seed + 1, ...; or of each. None: streams
            go on; at the first reset they begin anywhere.
        options : dict, optional
            "reset_mask": which environments, an array of num_envs bool.

        Returns
        -------
        observations : ndarray, shape (num_envs, observed)
        infos : dict
        """
        made = self._open()
        which = numpy.ones(self.num_envs, dtype=bool)
        if options and "reset_mask" in options:
            which = numpy.ascontiguousarray(options["reset_mask"])
            if which.dtype != bool or which.shape != (self.num_envs,):
                raise InputError(f"reset_mask: is of type {which.dtype} and shape {which.shape}; "
                                 f"allowed: {self.num_envs} bool")
            if self._observations is None:
                raise InputError("reset_mask: the first reset is of all environments")
        seeds, seeded = self._seeds(seed)
        observations = numpy.empty((self.num_envs, *self._width)) \
            if self._observations is None else self._observations.copy()
        for of, given in ((which & seeded, seeds), (which & ~seeded, None)):
            if of.any():
                library.envs_reset(made, pointer(of), pointer(given), pointer(observations))
        self._observations = observations
        return observations.copy(), {}

    @property
    def _width(self) -> tuple[int, ...]:
        shape = self.single_observation_space.shape
        assert shape is not None
        return shape

    def step(self, actions: Array) -> tuple[Array, Array, Flags, Flags, dict[str, Any]]:
        """Take a step in all environments.

        Parameters
        ----------
        actions : array_like, shape (num_envs, actions)
            Within [-1, 1]; what is beyond is taken as the end.

        Returns
        -------
        observations : ndarray, shape (num_envs, observed)
        rewards : ndarray, shape (num_envs,)
        terminated, truncated : ndarray of bool, shape (num_envs,)
        infos : dict
            "distance" in m; of AutoresetMode.SAME_STEP also "final_obs" and "final_info" of
            episodes that are over.
        """
        made = self._open()
        if self._observations is None:
            raise gymnasium.error.ResetNeeded("step() before the first reset()")
        try:
            given = numpy.ascontiguousarray(actions, dtype=float)
        except (TypeError, ValueError):
            raise ArgumentTypeError("actions: are no array of numbers") from None
        if given.shape != self.action_space.shape:
            raise InputError(f"actions have the shape {given.shape}; allowed: "
                             f"{self.action_space.shape}")
        if not numpy.isfinite(given).all():
            raise InputError("actions: have a number that is not finite; allowed: -1 to 1")
        n = self.num_envs
        observations = numpy.empty((n, *self._width))
        same = self.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
        last = numpy.zeros((n, *self._width)) if same else None
        rewards, distances = numpy.empty(n), numpy.empty(n)
        terminated, truncated = numpy.empty(n, dtype=bool), numpy.empty(n, dtype=bool)
        library.envs_step(made, pointer(given), ctypes.byref(library.EnvsStepResult(
            pointer(observations), pointer(last), pointer(rewards), pointer(distances),
            pointer(terminated), pointer(truncated))))
        self._observations = observations
        known = ~numpy.isnan(distances)
        infos: dict[str, Any] = {"distance": distances, "_distance": known}
        over = terminated | truncated
        if same and over.any():
            infos |= {"final_obs": last, "_final_obs": over, "_final_info": over,
                      "final_info": {"distance": distances, "_distance": over & known}}
        return observations.copy(), rewards, terminated, truncated, infos

    def close_extras(self, **kwargs: Any) -> None:
        self._made = None


class RodEnv(gymnasium.Env[Array, Array]):
    """One environment; parameters, and the numbers of each step, are those of `RodVectorEnv`."""

    metadata = {"render_modes": []}

    def __init__(self, robot: Robot, task: str = "reach", max_episode_steps: int = 100,
                 tasks: int = 256, tasks_seed: int = 0) -> None:
        self._all = RodVectorEnv(robot, 1, task, max_episode_steps, tasks, tasks_seed, threads=1,
                                 autoreset_mode=AutoresetMode.DISABLED)
        self.observation_space = self._all.single_observation_space
        self.action_space = self._all.single_action_space

    def __repr__(self) -> str:
        return f"<cpinn.envs.RodEnv to {self._all.task}>"

    def reset(self, *, seed: Optional[int] = None,
              options: Optional[dict[str, Any]] = None) -> tuple[Array, dict[str, Any]]:
        """Begin an episode; seed: as of the first environment of a `RodVectorEnv`."""
        super().reset(seed=seed)
        observations, _ = self._all.reset(seed=seed)
        return observations[0], {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Take a step."""
        observations, rewards, terminated, truncated, infos = self._all.step(
            numpy.asarray(action)[None])
        return (observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]),
                {"distance": float(infos["distance"][0])})

    def close(self) -> None:
        self._all.close()


for _name in _TASKS:
    gymnasium.register(id=f"cpinn/{_name.capitalize()}-v0", entry_point="cpinn.envs:RodEnv",
                       vector_entry_point="cpinn.envs:RodVectorEnv", kwargs={"task": _name})
