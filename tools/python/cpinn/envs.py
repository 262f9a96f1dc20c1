"""Environments of gymnasium: the tip of a robot reaches a place or follows a path.

    import gymnasium
    import cpinn.envs
    envs = cpinn.envs.RodVectorEnv("runs/arm", num_envs=1024, task="reach")
    envs = gymnasium.make_vec("cpinn/Reach-v0", num_envs=1024, robot="runs/arm",
                              vectorization_mode="vector_entry_point")     # the same

All environments are stepped at once, the robots in them by the C library on all processors. A robot is
a trained one-step model or a reduced rod (`cpinn.one_step`, `cpinn.reduced_rod`). Tasks are drawn from
motions of the robot when the environments are made, so that each can be done; an input that is slow,
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

import os
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy
import numpy.typing

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode
except ImportError as error:
    raise ImportError("cpinn.envs needs gymnasium 1.1 or later; install it with "
                      "'pip install gymnasium'") from error

from ._given import Scene, whole
from ._library import ArgumentTypeError, Array, InputError
from ._steps import OneStep, one_step, reduced_rod

__all__ = ["RodEnv", "RodVectorEnv"]

Robot = Union[OneStep, Scene]
Flags = numpy.typing.NDArray[numpy.bool_]

_TASKS = ("reach", "track")
_INT_MAX = 2**31 - 1


def _robot(robot: Robot, threads: Optional[int]) -> OneStep:
    """The robot of a run, or of a scene."""
    if isinstance(robot, OneStep):
        return robot
    is_scene = isinstance(robot, Mapping) or os.fspath(robot).endswith((".yaml", ".yml"))
    if is_scene:
        return reduced_rod(robot, threads=threads)
    return one_step(robot, threads=threads)  # type: ignore[arg-type]


class _Tasks(NamedTuple):
    """Starts, and where the tip is to be: at each step, or once for all."""

    states: Array  # [tasks, states]
    inputs: Array  # [tasks, inputs]
    goals: Array  # [tasks, 1 or steps, 3] m


def _ramps(random: numpy.random.Generator, low: float, high: float, steps: int) -> Array:
    """An input over the steps: it goes from level to level in 10 to 40 of them."""
    at, levels = [0], [random.uniform(low, high)]
    while at[-1] < steps:
        at.append(at[-1] + int(random.integers(10, 41)))
        levels.append(random.uniform(low, high))
    return numpy.interp(numpy.arange(steps + 1), at, levels)


def _draw(robot: OneStep, task: str, steps: int, count: int, seed: int) -> _Tasks:
    """Tasks that the robot itself has done."""
    random = numpy.random.default_rng(seed)
    ranges = numpy.array(list(robot.ranges.values()))
    slow = numpy.array([name in robot.slow for name in robot.ranges])
    first, other = random.uniform(ranges[:, 0], ranges[:, 1], (2, count, len(ranges)))
    other[:, slow] = first[:, slow]
    if task == "reach":
        goals = robot._seen(robot.rest(other))[:, None, :3]
    else:
        paths = numpy.repeat(first[:, None], steps + 1, axis=1)
        for i in range(count):
            for k in numpy.flatnonzero(~slow):
                paths[i, :, k] = _ramps(random, ranges[k, 0], ranges[k, 1], steps)
        first = paths[:, 0].copy()
        goals = numpy.empty((count, steps, 3))
        state = robot.rest(first)
        for k in range(steps):
            state = (robot.advance(state, paths[:, k], paths[:, k + 1]) if robot.ramps
                     else robot.advance(state, paths[:, k + 1]))
            goals[:, k] = robot._seen(state)[:, :3]
    states = robot.rest(first)
    good = numpy.isfinite(states).all(axis=1) & numpy.isfinite(goals).all(axis=(1, 2))
    if not good.any():
        raise InputError(f"none of {count} tasks has a motion that the robot can do")
    return _Tasks(states[good], first[good], goals[good])


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
        num_envs = whole("num_envs", num_envs, 1, _INT_MAX)
        self._steps = whole("max_episode_steps", max_episode_steps, 1, _INT_MAX)
        tasks = whole("tasks", tasks, 1, _INT_MAX)
        tasks_seed = whole("tasks_seed", tasks_seed, 0, 2**64 - 1)
        self.robot = _robot(robot, threads)
        self._tasks: Optional[_Tasks] = _draw(self.robot, task, self._steps, tasks, tasks_seed)
        self.metadata = {"autoreset_mode": mode, "render_modes": []}
        self.num_envs = num_envs
        self.task = task
        self.action_names = [name for name in self.robot.ranges if name not in self.robot.slow]
        self._acts = numpy.array([name not in self.robot.slow for name in self.robot.ranges])
        self._low, self._high = numpy.array([self.robot.ranges[name]
                                             for name in self.action_names]).reshape(-1, 2).T
        actions = len(self.action_names)
        width = self.robot.states + 16 + actions
        box = gymnasium.spaces.Box
        self.single_observation_space = box(-numpy.inf, numpy.inf, (width,), numpy.float64)
        self.single_action_space = box(-1.0, 1.0, (actions,), numpy.float64)
        self.observation_space = gymnasium.vector.utils.batch_space(
            self.single_observation_space, num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)
        self._observations: Optional[Array] = None
        self._random = [numpy.random.default_rng(i) for i in range(num_envs)]
        self._task, self._at = numpy.zeros((2, num_envs), dtype=int)
        self._over = numpy.zeros(num_envs, dtype=bool)
        self._states = numpy.empty((num_envs, self.robot.states))
        self._inputs = numpy.empty((num_envs, len(self.robot.ranges)))

    def __repr__(self) -> str:
        return (f"<cpinn.envs.RodVectorEnv: {self.num_envs} to {self.task}, actions "
                f"{', '.join(self.action_names)}>")

    def _open(self) -> _Tasks:
        if self._tasks is None:
            raise gymnasium.error.ClosedEnvironmentError("the environments are closed")
        return self._tasks

    def _begin(self, which: Flags) -> None:
        """Episodes."""
        tasks = self._open()
        for i in numpy.flatnonzero(which):
            self._task[i] = self._random[i].integers(len(tasks.states))
        self._at[which] = 0
        self._over[which] = False
        self._states[which] = tasks.states[self._task[which]]
        self._inputs[which] = tasks.inputs[self._task[which]]

    def _observe(self, which: Any, to: Array, seen: Optional[Array] = None) -> None:
        """Of these environments (slice(None): all), whose tips may be known already."""
        goals, n = self._open().goals, self.robot.states
        task, at, last = self._task[which], self._at[which], goals.shape[1] - 1
        goal = goals[task, numpy.minimum(at, last)]
        states, inputs = self._states[which], self._inputs[which][:, self._acts]
        if seen is None:
            seen = self.robot._seen(states)
        to[which, :n] = states
        to[which, n:n + 10] = seen
        to[which, n + 10:n + 13] = goal - seen[:, :3]
        to[which, n + 13:n + 16] = 0.0 if last == 0 else (
            goals[task, numpy.minimum(at + 1, last)] - goal) / self.robot.step
        to[which, n + 16:] = (2 * inputs - self._low - self._high) / (self._high - self._low)

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
        self._open()
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
        for i in numpy.flatnonzero(which & seeded):
            assert seeds is not None
            self._random[i] = numpy.random.default_rng(int(seeds[i]))
        self._begin(which)
        self._observe(which, observations)
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
        tasks = self._open()
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
        mode = self.metadata["autoreset_mode"]
        again = self._over & (mode == AutoresetMode.NEXT_STEP)  # no action is taken in these
        after = self._inputs.copy()
        after[:, self._acts] = (self._low + 0.5 * (1 + numpy.clip(given, -1, 1)) *
                                (self._high - self._low))
        goal = tasks.goals[self._task, numpy.minimum(self._at, tasks.goals.shape[1] - 1)]
        states = (self.robot.advance(self._states, self._inputs, after) if self.robot.ramps
                  else self.robot.advance(self._states, after))
        seen = self.robot._seen(states)
        off = seen[:, :3] - goal
        distances = numpy.sqrt(off[:, 0]**2 + off[:, 1]**2 + off[:, 2]**2)
        good = numpy.isfinite(distances) & ~again
        terminated = ~good & ~again
        rewards = distances / -self.robot.length
        self._at += 1
        truncated = good & (self._at >= self._steps)
        self._over = terminated | truncated
        self._states, self._inputs = states, after
        observations = numpy.empty((self.num_envs, *self._width))
        self._observe(slice(None), observations, seen)
        if not good.all():
            distances[~good] = numpy.nan
            rewards[~good] = numpy.where(again, 0.0, -1.0)[~good]
            # Where there is no state any more the episode ends, at its start.
            self._states[terminated] = tasks.states[self._task[terminated]]
            self._inputs[terminated] = tasks.inputs[self._task[terminated]]
            self._begin(again)
            self._observe(~good, observations)
        over, same = self._over.copy(), mode == AutoresetMode.SAME_STEP
        if same and over.any():
            last = numpy.where(over[:, None], observations, 0)
            self._begin(over)
            self._observe(over, observations)
        self._observations = observations
        known = ~numpy.isnan(distances)
        infos: dict[str, Any] = {"distance": distances, "_distance": known}
        if same and over.any():
            infos |= {"final_obs": last, "_final_obs": over, "_final_info": over,
                      "final_info": {"distance": distances, "_distance": over & known}}
        return observations.copy(), rewards, terminated, truncated, infos

    def close_extras(self, **kwargs: Any) -> None:
        self._tasks = None


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
