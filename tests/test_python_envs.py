"""Robots in steps and environments of gymnasium. test_python_envs.py CONFIGS CPINN_TRAIN, in an empty
folder. Exit status 77 without numpy or gymnasium."""
import subprocess
import sys
import warnings

from python_testing import configs, raises

import numpy

try:
    import gymnasium
except ImportError:
    sys.exit(77)
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import cpinn
import cpinn.envs

scene = configs + "/robots/soft_arm_control.yaml"
subprocess.run([sys.argv[2], scene, "--out", "arm", "--threads", "1", "--quiet",
                "--set", "surrogate.solved=500", "--set", "surrogate.modes=[1, 1, 1, 1]",
                "--set", "network.hidden=[16]",
                "--set", "training.stages=[{optimizer: ssbroyden, steps: 10}]"],
               stdout=subprocess.DEVNULL, check=False)  # a warning: hardly trained

# States a step later: many as one by one, on any number of threads, to the same bits.
generator = numpy.random.default_rng(3)
low, high = numpy.array([[0, 0, 0, 0.6], [8, 8, 8, 1.4]])
inputs = generator.uniform(low, high, (150, 4))
changed = inputs.copy()
changed[:, :3] = generator.uniform(low, high, (150, 4))[:, :3]
for robot, again in ((cpinn.one_step("arm"), cpinn.one_step("arm", threads=2)),
                     (cpinn.reduced_rod(scene), cpinn.reduced_rod(scene, threads=2))):
    assert list(robot.ranges) == ["force1", "force2", "force3", "stiffness"]
    assert robot.slow == ["stiffness"] and robot.step == 0.02 and robot.length == 0.13
    rest = robot.rest(inputs)
    assert rest.shape == (150, robot.states) and numpy.isfinite(rest).all()
    after = robot.advance(rest, changed)
    assert numpy.array_equal(after, again.advance(rest, changed))
    assert numpy.array_equal(after, numpy.vstack([robot.advance(x, u)
                                                  for x, u in zip(rest, changed)]))
    # Derivatives against central differences, h^2 and Newton's tolerance or rounding over h.
    found = robot.derivatives(rest[:3], changed[:3])
    assert numpy.array_equal(found.states, after[:3]) or numpy.allclose(found.states, after[:3],
                                                                        rtol=1e-12, atol=1e-13)
    for k in range(3):
        h = 0.01
        move = h * numpy.eye(4)[k]
        difference = (robot.advance(rest[:3], changed[:3] + move) -
                      robot.advance(rest[:3], changed[:3] - move)) / (2 * h)
        size = numpy.abs(found.by_inputs[:, :, k]).max()
        assert numpy.abs(difference - found.by_inputs[:, :, k]).max() < 2e-3 * size, k
    # Where the tip is, of a state at rest: what the solver of the whole rod says, to the modes.
    tip = robot.tip(rest)
    assert abs(numpy.linalg.norm(tip["rotation"], axis=1) - 1).max() < 1e-12
    assert numpy.abs(tip["velocity"]).max() == 0
    lost = rest.copy()
    lost[1, 0] = numpy.nan
    after = robot.advance(lost, changed)
    assert numpy.isnan(after[1]).all() and numpy.isfinite(numpy.delete(after, 1, axis=0)).all()
    raises(ValueError, "states have the shape (3,)", robot.advance, [1, 2, 3], inputs[:1])
    raises(ValueError, "150 states and 2 rows of inputs", robot.advance, rest, inputs[:2])
    raises(ValueError, "finite", robot.advance, rest[:1], [[numpy.nan, 0, 0, 1]])
raises(ValueError, "force1 is 8.5; allowed: 0 to 8", robot.advance, rest[:1], [[8.5, 0, 0, 1]])
held = cpinn.one_step("arm")
raises(ValueError, "stay while a step lasts", held.advance, held.rest(inputs[:1]), inputs[:1],
       inputs[:1])
raises(OSError, "cannot be opened", cpinn.one_step, "missing")
raises(ValueError, "is of scenes in motion", cpinn.reduced_rod, configs + "/elastica.yaml")
raises(ValueError, "has no inputs", cpinn.reduced_rod, configs + "/soft_arm.yaml")
raises(ValueError, "a formula of time", cpinn.reduced_rod, scene, overrides={
    "control": None, "loads.force": ["0.1*sin(t)", 0, 0]})
raises(ValueError, "step: is -1", cpinn.reduced_rod, scene, step=-1)
raises(ValueError, "one-step model, which is opened as such", cpinn.open, "arm")

# Environments: those of one robot among many do what they do alone, to the bit, through episodes
# that end; goals are at rest or move; a seed says all.
for robot, count in (("arm", 70), (scene, 9)):
    for task in ("reach", "track"):
        make = dict(task=task, max_episode_steps=5, tasks=12)
        many = cpinn.envs.RodVectorEnv(robot, count, threads=2, **make)
        ones = [cpinn.envs.RodVectorEnv(robot, 1, threads=1, **make) for _ in range(3)]
        actions = generator.uniform(-1.2, 1.2, (13, count, 3))
        runs = []
        for seed in (7, 7, 8):
            seen, infos = many.reset(seed=seed)
            runs.append([seen])
            for k, action in enumerate(actions):
                seen, rewards, terminated, truncated, infos = many.step(action)
                runs[-1].append(seen)
                assert seen in many.observation_space and not terminated.any()
                assert (truncated == (k % 6 == 4)).all()  # of 6 steps one begins an episode
                known = infos["_distance"]
                assert known.all() == (k % 6 != 5)
                assert numpy.allclose(-0.13 * rewards[known], infos["distance"][known], rtol=1e-14)
        assert numpy.array_equal(runs[0], runs[1]) and not numpy.array_equal(runs[0], runs[2])
        for place, one in enumerate(ones):
            alone = [one.reset(seed=8 + place)[0]]
            alone += [one.step(action[place:place + 1])[0] for action in actions]
            assert numpy.array_equal(numpy.array(alone)[:, 0], numpy.array(runs[2])[:, place])
        # What is observed: the tip, the way to the goal, the actions.
        states = many.robot.states
        tip = many.robot.tip(seen[:, :states])
        assert numpy.array_equal(seen[:, states:states + 3], tip["position"])
        assert numpy.array_equal(seen[:, states + 7:states + 10], tip["velocity"])
        assert numpy.allclose(seen[:, -3:], numpy.clip(actions[-1], -1, 1), rtol=0, atol=1e-14)
        moves = numpy.abs(seen[:, -6:-3]).max() > 0
        assert moves == (task == "track")

# A step of an environment is a step of its robot, under the stiffness of the task, which is not seen:
# the goal of that task is where the tip rests under other inputs.
envs = cpinn.envs.RodVectorEnv(cpinn.reduced_rod(scene, overrides={
    "parameters.stiffness": {"range": [0.999999, 1.000001]}}), 40, tasks=12)
seen, _ = envs.reset(seed=1)
n = envs.robot.states
actions = generator.uniform(-1, 1, (40, 3))
pulls = numpy.column_stack([4 * (1 + actions), numpy.ones(40)])
step = envs.step(actions)[0]
known = envs.robot.advance(seen[:, :n], pulls)
assert numpy.abs(known - step[:, :n]).max() < 1e-4 * numpy.abs(known).max()  # a millionth, and Newton's
goals = seen[:, n + 10:n + 13] + seen[:, n:n + 3]
grid = numpy.stack(numpy.meshgrid(*[[0, 2, 4, 6, 8]] * 3), axis=-1).reshape(-1, 3)
ends = envs.robot.tip(envs.robot.rest(numpy.column_stack([grid, numpy.ones(125)])))["position"]
nearest = numpy.linalg.norm(goals[:, None] - ends, axis=2).min(axis=1)
assert nearest.max() < 0.02  # between the places of that grid, which are 10 to 20 mm apart

# Gymnasium's own checks, and its three ways of autoreset.
for name in ("Reach", "Track"):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of bounds of observations that are infinite
        check_env(gymnasium.make(f"cpinn/{name}-v0", robot="arm", tasks=4).unwrapped,
                  skip_render_check=True)
made = gymnasium.make_vec("cpinn/Track-v0", num_envs=3, robot="arm", tasks=4,
                          vectorization_mode="vector_entry_point")
assert made.unwrapped.task == "track" and made.unwrapped.num_envs == 3
assert made.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
wrapped = gymnasium.wrappers.vector.RecordEpisodeStatistics(made)
wrapped.reset(seed=0)
for _ in range(101):
    infos = wrapped.step(wrapped.action_space.sample())[4]
    if "episode" in infos:
        assert (infos["episode"]["l"] == 100).all() and (infos["episode"]["r"] < 0).all()
action = numpy.zeros((4, 3))
same = cpinn.envs.RodVectorEnv("arm", 4, max_episode_steps=3, tasks=4,
                               autoreset_mode=AutoresetMode.SAME_STEP)
never = cpinn.envs.RodVectorEnv("arm", 4, max_episode_steps=3, tasks=4, autoreset_mode="Disabled")
following = cpinn.envs.RodVectorEnv("arm", 4, max_episode_steps=3, tasks=4)
first = [envs.reset(seed=2)[0] for envs in (same, never, following)]
assert numpy.array_equal(first[0], first[1]) and numpy.array_equal(first[0], first[2])
for k in range(3):
    of_same, of_never = same.step(action), never.step(action)
    of_following = following.step(action)
    assert ("final_obs" in of_same[4]) == (k == 2)
assert of_same[3].all() and of_never[3].all() and of_following[3].all()
assert numpy.array_equal(of_same[4]["final_obs"], of_never[0])
assert numpy.array_equal(of_same[4]["final_info"]["distance"], of_never[4]["distance"])
assert numpy.array_equal(of_never[0], of_following[0])
begun = following.step(action)
assert (begun[1] == 0).all() and not begun[3].any() and not begun[4]["_distance"].any()
assert numpy.array_equal(of_same[0], begun[0])  # the same next episode
mask = numpy.array([True, False, False, True])
partly = never.reset(options={"reset_mask": mask})[0]
assert numpy.array_equal(partly[mask], begun[0][mask])
assert numpy.array_equal(partly[~mask], of_never[0][~mask])

# One environment alone is the first of many.
one = cpinn.envs.RodEnv("arm", max_episode_steps=3, tasks=4)
assert numpy.array_equal(one.reset(seed=2)[0], first[0][0])
seen, reward, terminated, truncated, info = one.step(numpy.zeros(3))
assert isinstance(reward, float) and reward < 0 and info["distance"] > 0 and not truncated

# What is refused.
raises(ValueError, "task: is 'fly'; allowed: 'reach', 'track'", cpinn.envs.RodVectorEnv, "arm", 2, "fly")
raises(ValueError, "autoreset_mode: is 'x'", cpinn.envs.RodVectorEnv, "arm", autoreset_mode="x")
raises(ValueError, "num_envs: is 0", cpinn.envs.RodVectorEnv, "arm", 0)
raises(TypeError, "num_envs: is 1.5", cpinn.envs.RodVectorEnv, "arm", 1.5)
raises(ValueError, "actions have the shape (3,)", same.step, numpy.zeros(3))
raises(ValueError, "not finite", same.step, numpy.full((4, 3), numpy.nan))
raises(TypeError, "no array of numbers", same.step, "left")
raises(ValueError, "seed has 2 numbers", same.reset, seed=[1, 2])
raises(ValueError, "4 bool", same.reset, options={"reset_mask": [1, 2]})
same.close()
try:
    same.step(action)
    raise AssertionError("nothing was raised")
except gymnasium.error.ClosedEnvironmentError:
    pass
try:
    cpinn.envs.RodVectorEnv("arm", 2, tasks=4).step(numpy.zeros((2, 3)))
    raise AssertionError("nothing was raised")
except gymnasium.error.ResetNeeded:
    pass
