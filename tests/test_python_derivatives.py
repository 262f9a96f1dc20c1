"""Derivatives in Python: of models, of families by their parameters, in PyTorch and in JAX.
test_python_derivatives.py CONFIGS, in an empty folder. Exit status 77 without numpy."""
from python_testing import FAMILY, configs, raises

import shutil

import numpy

import cpinn

model = cpinn.train(configs + "/elastica.yaml", threads=1)
moving = cpinn.train(configs + "/cantilever_dynamic.yaml", threads=1, overrides={
    "training.stages": [{"optimizer": "adam", "steps": 20}]})  # any network will do

# Of a model: the same bits as by name; time only where there is one.
s = numpy.linspace(0.05, 0.25, 6)
assert numpy.array_equal(model.derivative("x z", "s", s)["z"], model.evaluate("z_s", s)["z_s"])
assert numpy.array_equal(model.derivative("x_s", "s", s)["x_s"], model.evaluate("x_ss", s)["x_ss"])
t = 0.5
assert list(moving.derivative("r", "st", s, t)) == ["x", "y", "z"]
assert numpy.array_equal(moving.derivative("x_t", "s", s, t)["x_t"],
                         moving.evaluate("x_st", s, t)["x_st"])
assert moving.in_motion and not model.in_motion
assert model.units("x_s m2") == {"x_s": "m m^-1", "m2": "N m"}, model.units("x_s m2")
raises(ValueError, "by: is 'u'; allowed: s and t", model.derivative, "x", "u")
raises(ValueError, "by: is ''", model.derivative, "x", "")

# Of members: against central differences of solved ones. Two parameters in the loads, one in the
# material; where shapes are smooth, the error of differences is h^2 times third derivatives.
three = FAMILY.replace("parameters: {", "parameters: {young: {range: [0.8e6, 1.2e6]}, "
                       "pull: {range: [0, 0.5]}, ").replace("1.0e6", "young") + \
    "tendons: [{offset: [0.004, 0], end: 0.2, tension: pull}]\n"
with open("three.yaml", "w") as file:
    file.write(three)
members = cpinn.Members("three.yaml", s, tolerance=1e-7)
at = numpy.array([[1e6, 0.1, -0.02], [0.9e6, 0.4, 0.01], [1.1e6, 0.2, 0.0]])
names = list(members.names)
assert names == ["young", "pull", "force"]
shapes, slopes, results = members.jacobian(at)
assert results["trusted"].all() and slopes.shape == (3, 6, 13, 3)
assert numpy.array_equal(shapes, members.solve(at).values)
largest = numpy.abs(slopes).max(axis=(0, 1))
for k, step in enumerate((1e3, 1e-3, 1e-4)):
    move = step * numpy.eye(3)[k]
    differences = (members.solve(at + move).values - members.solve(at - move).values) / (2 * step)
    off = numpy.abs(differences - slopes[..., k]).max(axis=(0, 1))
    # Positions and rotations to what meshes for 1e-7 leave of derivatives; strains, which jump where
    # the tendon ends and are known to a tenth of a percent there, to that.
    assert (off[:7] <= 1e-4 * largest[:3, k].max() + 1e-4 * largest[:7, k]).all(), (k, off, largest)
    assert (off[7:] <= 1e-2 * largest[7:, k] + 1e-9).all(), (k, off, largest)
assert numpy.array_equal(members.jacobian(dict(zip(names, at.T))).jacobian, slopes)
many = numpy.repeat(at, 40, axis=0)  # more than one piece of work
assert numpy.array_equal(members.jacobian(many).jacobian, numpy.repeat(slopes, 40, axis=0))

# With forces: further columns, and the others stay as they are, to the bit.
carrying = cpinn.Members("three.yaml", s, tolerance=1e-7, forces=True)
assert carrying.columns == members.columns + ["n1", "n2", "n3", "m1", "m2", "m3"]
carried = carrying.jacobian(many)
assert carried.jacobian.shape == (120, 6, 19, 3)
assert numpy.array_equal(carried.values[..., :13], members.solve(many).values)
assert numpy.array_equal(carried.jacobian[:, :, :13], members.jacobian(many).jacobian)
assert numpy.array_equal(carried.values, carrying.solve(many).values)
assert numpy.array_equal(carried.jacobian, numpy.repeat(carried.jacobian[::40], 40, axis=0))
largest = [numpy.abs(carried.jacobian[:, :, c:c + 3]).max(axis=(0, 1, 2)) for c in (13, 16)]
for k, step in enumerate((1e3, 1e-3, 1e-4)):
    move = step * numpy.eye(3)[k]
    differences = (carrying.solve(at + move).values - carrying.solve(at - move).values) / (2 * step)
    off = numpy.abs(differences - carried.jacobian[::40, ..., k]).max(axis=(0, 1))
    assert off[13:16].max() <= 1e-4 * largest[0][k] and off[16:].max() <= 1e-4 * largest[1][k], off
lost = carrying.jacobian([[0.8e6, 30, 0.0]])
assert numpy.isnan(lost.values).all() and numpy.isnan(lost.jacobian).all()
found = [of.reach(shapes[:, -1, :3], seed=1) for of in (carrying, members)]  # shapes alone
assert numpy.array_equal(found[0].parameters, found[1].parameters)

shapes, slopes, results = members.jacobian([[0.8e6, 30, 0.0]])  # beyond all equilibria
assert not results["trusted"][0] and numpy.isnan(slopes).all()
with open("supported.yaml", "w") as file:  # forces that depend on the place are sought, too
    file.write(three.replace("loads: {", "loads: {foundation: [3, 2, 0], ") +
               "springs: [{at: 0.3, stiffness: [1, 2, 1], turning: [0.01, 0, 0.01]}]\n")
supported = cpinn.Members("supported.yaml", s, tolerance=1e-7)
slopes = supported.jacobian(at).jacobian
assert numpy.abs(slopes - members.jacobian(at).jacobian).max() > 0.1 * numpy.abs(slopes).max()
for k, step in enumerate((1e3, 1e-3, 1e-4)):
    move = step * numpy.eye(3)[k]
    differences = (supported.solve(at + move).values - supported.solve(at - move).values) / (2 * step)
    off = numpy.abs(differences - slopes[..., k]).max(axis=(0, 1))
    largest = numpy.abs(slopes).max(axis=(0, 1))
    assert (off[:7] <= 1e-4 * largest[:3, k].max() + 1e-4 * largest[:7, k]).all(), (k, off, largest)

# Of a network for all members: that of the equilibrium its answer has arrived at.
cpinn.train("three.yaml", folder="family", threads=1, overrides=[
    "formulation=strain", "network.hidden=[16]", "members.solved=300",
    "training.stages=[{optimizer: adam, steps: 300}]"])
family = cpinn.Family("family")
answered = family.jacobian(at, s)
solved = members.jacobian(at)
assert (answered.answers["error"] < 1e-5).all()
for c, unit in ((slice(0, 3), 0.3), (slice(3, 7), 1)):
    off = numpy.abs(answered.jacobian - solved.jacobian)[:, :, c].max(axis=(0, 1, 2))
    assert (off <= 1e-4 * numpy.abs(solved.jacobian[:, :, c]).max(axis=(0, 1, 2))).all(), off
assert numpy.array_equal(answered.values, family.evaluate(at, s).values)
with_forces = cpinn.Family("family", forces=True)
carried_by_network = with_forces.jacobian(at, s)
assert numpy.array_equal(carried_by_network.values[..., :13], answered.values)
assert numpy.array_equal(carried_by_network.jacobian[:, :, :13], answered.jacobian)
for polish in (0, 2):  # forces are of the equilibrium
    off = numpy.abs(with_forces.evaluate(at, s, polish=polish).values - carried.values[::40])
    for c in (13, 16):
        size = numpy.abs(carried.values[..., c:c + 3]).max()
        assert off[..., c:c + 3].max() <= 1e-4 * size, (polish, c, off, size)

# One member at a time by compiled C, where there is a compiler.
if shutil.which("cc"):
    alone = cpinn.Members("three.yaml", s, tolerance=1e-7, compile=True)
    quick, usual = alone.jacobian(at[:1]), members.jacobian(at[:1])
    unit = numpy.abs(usual.jacobian).max(axis=(0, 1)) + 1e-6
    assert not numpy.array_equal(quick.values, usual.values)
    assert numpy.abs(quick.values - usual.values)[..., :3].max() < 2e-7 * max(s)
    assert (numpy.abs(quick.jacobian - usual.jacobian) <= 1e-3 * unit).all()
    quick = cpinn.Family("family", compile=True).jacobian(at[:1], s)
    unit = numpy.abs(answered.jacobian).max(axis=(0, 1)) + 1e-6
    assert numpy.abs(quick.values - answered.values[:1])[..., :3].max() < 1e-5
    assert (numpy.abs(quick.jacobian - answered.jacobian[:1]) <= 1e-3 * unit).all()

# Of a family in motion: the network's own.
cpinn.train(configs + "/families/ramp.yaml", folder="ramp", threads=1, overrides=[
    "training.stages=[{optimizer: adam, steps: 10}]"])
ramp = cpinn.Family("ramp")
middle = numpy.array([[(low + high) / 2 for low, high in ramp.ranges.values()]])
where = [0.3 * max(s), max(s)]
found = ramp.jacobian(middle, where, 0.3)
for k, (low, high) in enumerate(ramp.ranges.values()):
    move = 1e-4 * (high - low) * numpy.eye(len(ramp.ranges))[k]
    differences = (ramp.evaluate(middle + move, where, 0.3).values -
                   ramp.evaluate(middle - move, where, 0.3).values) / (2e-4 * (high - low))
    size = numpy.abs(found.jacobian[..., k]).max(axis=(0, 1))
    assert (numpy.abs(differences - found.jacobian[..., k]).max(axis=(0, 1)) <=
            1e-5 * size + 1e-8).all()  # h^2, and rounding over h

# Of members in motion without a network: they go forward with the steps of time. Modes and their
# steps are chosen for each solution, to a tolerance of 1e-6 over a step of 1e-3.
swing = """
parameters: {soft: {range: [0.5, 2]}, push: {range: [0, 1]}}
rod:
  model: kirchhoff
  length: 0.3
  material: {youngs_modulus: "2e5*soft", poissons_ratio: 0.4, density: 1000, relaxation_time: 0.02}
  section: {shape: circle, radius: 0.01}
boundary: {start: {type: clamped}}
initial: {state: equilibrium}
loads: {gravity: [0, -0.5, -2], tip: {force: [0, "0.02*push*sin(20*t)", 0]}}
time: {duration: 0.4}
"""
with open("swing.yaml", "w") as file:
    file.write(swing)
swings = cpinn.Members("swing.yaml", [0.15, 0.3, 0.15, 0.3], t=[0.1, 0.1, 0.4, 0.4], tolerance=1e-6,
                       threads=2)
member = numpy.array([[1, 0.5], [2.1, 0.2]])  # one beyond the ranges
swung = swings.jacobian(member)
assert swings.columns[-1] == "w3" and swung.jacobian.shape == (2, 4, 25, 2)
assert swung.answers["trusted"].all() and swings.words(swung.answers) == [("solver", "none")] * 2
assert numpy.array_equal(swung.values, swings.solve(member).values)
for k in range(2):
    move = 1e-3 * numpy.eye(2)[k]
    differences = (swings.solve(member + move).values - swings.solve(member - move).values) / 2e-3
    off = numpy.abs(differences - swung.jacobian[..., k]).max(axis=(0, 1))
    assert (off <= 1e-3 * numpy.abs(swung.jacobian[..., k]).max(axis=(0, 1)) + 1e-9).all(), (k, off)
raises(ValueError, "tips of a robot in motion", swings.reach, [[0, 0, 0.2]])
with open("sudden.yaml", "w") as file:
    file.write(swing.replace("push*sin(20*t)", "where(t-0.1*push, 1, 0)"))
sudden = cpinn.Members("sudden.yaml", 0.3, t=0.4)
assert sudden.solve(member).answers["trusted"].all()
raises(ValueError, "the parameter push moves an instant", sudden.jacobian, member)

with open("played.yaml", "w") as file:
    file.write(swing.replace("0.02*push*sin(20*t)", "0.02*play(push, 0.1)*sin(20*t)"))
raises(ValueError, "do not have plays and lags", cpinn.Members, "played.yaml", 0.3, t=0.4)

# PyTorch.
try:
    import torch
    import cpinn.torch
except ImportError:
    print("no PyTorch")
else:
    value = cpinn.torch.function(moving, "x qw")
    at_s = torch.tensor(s, requires_grad=True)
    at_t = torch.full((6,), t, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(value, (at_s, at_t))
    assert torch.autograd.gradgradcheck(value, (at_s, at_t))
    value(at_s, at_t)[..., 0].sum().backward()
    assert numpy.array_equal(at_s.grad.numpy(), moving.evaluate("x_s", s, t)["x_s"])
    still = cpinn.torch.function(model, "z")
    assert torch.autograd.gradcheck(still, (at_s,))
    assert still(at_s.float()).dtype == torch.float32
    given = torch.tensor(at / [1e6, 1, 0.1], requires_grad=True)  # of like sizes, for differences
    shapes = cpinn.torch.family_function(family, s)
    sizes = torch.tensor([1e6, 1, 0.1], dtype=torch.float64)
    assert torch.autograd.gradcheck(lambda x: shapes(x * sizes)[..., :3], (given,), eps=1e-4,
                                    atol=1e-5, rtol=1e-3)
    solved = torch.tensor(at, requires_grad=True)  # where members were made for
    cpinn.torch.family_function(members)(solved)[:, -1, 2].sum().backward()
    assert numpy.array_equal(solved.grad.numpy(), members.jacobian(at).jacobian[:, -1, 2])
    solved.grad = None
    moved = torch.tensor(member, requires_grad=True)
    cpinn.torch.family_function(swings)(moved)[:, -1, 20].sum().backward()  # a velocity
    assert numpy.array_equal(moved.grad.numpy(), swung.jacobian[:, -1, 20])
    cpinn.torch.family_function(carrying)(solved)[:, 2, 17].sum().backward()  # a moment
    assert numpy.array_equal(solved.grad.numpy(), carried.jacobian[::40, 2, 17])

# JAX.
try:
    import jax
    import cpinn.jax
except ImportError:
    print("no JAX")
else:
    jax.config.update("jax_enable_x64", True)
    value = cpinn.jax.function(moving, "x qw")
    slope = jax.jit(jax.vmap(jax.jacfwd(value, argnums=(0, 1)), in_axes=(0, None)))(s, t)
    assert numpy.array_equal(slope[0][:, 0], moving.evaluate("x_s", s, t)["x_s"])
    assert numpy.array_equal(slope[1][:, 1], moving.evaluate("qw_t", s, t)["qw_t"])
    twice = jax.jacfwd(jax.jacfwd(value, argnums=1))(s[0], t)
    assert numpy.array_equal(twice[0], moving.evaluate("x_st", s[0], t)["x_st"])
    assert jax.grad(lambda s: value(s, t)[0])(s[0]) == moving.evaluate("x_s", s[0], t)["x_s"]
    h = 1e-5
    difference = (value(s[0] + h, t) - value(s[0] - h, t)) / (2 * h)
    assert numpy.abs(difference - jax.jacfwd(value)(s[0], t)).max() < 1e-7  # h^2; 1e-16/h
    assert jax.grad(lambda s: cpinn.jax.function(model, "z")(s)[0])(0.1) == \
        model.evaluate("z_s", 0.1)["z_s"]
    shapes = cpinn.jax.family_function(family, s)
    back = jax.grad(lambda at: shapes(at)[:, -1, 2].sum())(at)
    assert numpy.allclose(back, family.jacobian(at, s).jacobian[:, -1, 2], rtol=1e-12, atol=0)
    alone = cpinn.jax.family_function(members)
    back = jax.grad(lambda at: alone(at)[:, -1, 2].sum())(at)
    assert numpy.allclose(back, members.jacobian(at).jacobian[:, -1, 2], rtol=1e-12, atol=0)
    back = jax.grad(lambda at: cpinn.jax.family_function(swings)(at)[:, -1, 1].sum())(member)
    assert numpy.allclose(back, swung.jacobian[:, -1, 1], rtol=1e-12, atol=0)
