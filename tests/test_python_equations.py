"""Equations of one's own in Python: formulas as text, solutions, and what is refused.

    test_python_equations.py CONFIGS CPINN_TRAIN"""
import math
import os

from python_testing import raises

import numpy

import cpinn
from cpinn import cos, exp, pi, sin, where

# ---- formulas ------------------------------------------------------------------------------------

m = cpinn.Equations()
x = m.coordinate("x", 0, 1, unit="m")
t = m.coordinate("t", 0, 0.5, time=True)
k = m.parameter("k", 0.3, 0.4)
u = m.field("u")
for formula, text in (
        (u.d(t) - k*u.d(x, 2), "u_t - k*u_xx"),
        (u.d(x).d(t), "u_xt"),
        (u - (x - t) - 2*(u + 1)**2/(-x)/3, "u - (x - t) - 2*(u + 1)^2/(-x)/3"),
        (x/(t*k), "x/(t*k)"), (x*t/k, "x*t/k"), (-(x + t)*u, "(-(x + t))*u"),
        ((x**2)**3, "(x^2)^3"), (x**-0.5, "x^(-0.5)"), (1 - x, "1 - x"), (2/x, "2/x"),
        (abs(u) + where(x, -u, 1e-7), "abs(u) + where(x, -u, 1e-07)"),
        (sin(pi*x) + numpy.float64(0.5)*cos(t), "sin(3.141592653589793*x) + 0.5*cos(t)"),
        (cpinn.minimum(x, t) - cpinn.maximum(x, 2), "min(x, t) - max(x, 2)"), (+u, "u")):
    assert str(formula) == text, (str(formula), text)
assert sin(0.5) == math.sin(0.5) and (exp([0, 1]) == numpy.exp([0, 1])).all()

flux = m.formula("F", u**2/2 - k*u.d(x))
assert str(flux.d(x) + (x*u).d(t, 2)) == "F_x + _1_tt"
raises(ValueError, "is a number", cpinn.Formula("1").d, x)

raises(ValueError, "the exponent is no number", lambda: x**t)
raises(ValueError, "allowed: finite numbers", lambda: x*math.inf)
raises(TypeError, "allowed: numbers and formulas", lambda: x + "t")
raises(TypeError, "true or false nowhere", bool, u)
raises(TypeError, "true or false nowhere", bool, x == 1)
raises(TypeError, "allowed: x == 1", lambda: x != 1)
raises(TypeError, "allowed: a coordinate of the same equations", u.d, k)
other = cpinn.Equations()
raises(ValueError, "is of other equations", lambda: u + other.coordinate("x", 0, 1))
raises(ValueError, "is of other equations", other.inside, u)
raises(TypeError, "is no face", m.at, True, u, 0)
raises(TypeError, "is no field", m.at, x == 0, u + 1, 0)
raises(ValueError, "x = 0.5 is no face; allowed: 0 or 1", m.at, x == 0.5, u, 0)
raises(ValueError, "u_t is a derivative along a face", m.at, x == 0, u.d(t), 0)
raises(ValueError, "has no field", m.inside, x*t)
raises(ValueError, "unknown name 'w'", m.inside, "u_t - w")
raises(ValueError, "formulas know 'x' already", m.field, "x")
raises(ValueError, "there is no column", m.data, x=[1.0], u=[1.0])
raises(ValueError, "does not broadcast", m.data, x=[1.0, 2], t=[1.0, 2, 3], u=1)
raises(ValueError, "no equation inside", cpinn.fit, m)
raises(TypeError, "allowed: cpinn.Equations, a path, a dict", cpinn.fit, 5)
raises(ValueError, "tolerance: is 0", cpinn.fit, m, tolerance=0)

# ---- solutions: heat in a bar with cold ends, u = exp(-pi^2 k t) sin(pi x) --------------------------


def heat(k_of):
    equations = cpinn.Equations()
    along = equations.coordinate("x", 0, 1)
    time = equations.coordinate("t", 0, 0.5, time=True)
    factor = k_of(equations)
    temperature = equations.field("u")
    equations.inside(temperature.d(time) - factor*temperature.d(along, 2))
    equations.at(time == 0, temperature, sin(pi*along))
    equations.at(along == 0, temperature, 0)
    equations.at(along == 1, temperature)
    return equations


def exact(at_x, at_t, factor=0.4):
    return numpy.exp(-pi**2 * factor * at_t) * numpy.sin(pi * at_x)


places, times = numpy.linspace(0, 1, 11)[:, None], numpy.linspace(0, 0.5, 6)
s = cpinn.fit(heat(lambda e: 0.4), tolerance=1e-8, threads=1)
assert s.verdict.outcome == "solved" and 0 < s.error <= 1e-8, s
assert s.coordinates == ["x", "t"] and s.fields == ["u"] and s.unknowns == {}
assert s.u(places, times).shape == (11, 6)
assert abs(s.u(places, times) - exact(places, times)).max() <= 30 * s.error
assert s.u(0.5, t=0.1) == s.evaluate("u", x=0.5, t=0.1)
# a derivative of what is off by 1e-8: some ten times that
assert abs(s.evaluate("u_x", 0.2, 0.1) - pi * exact(0.7, 0.1)) <= 1e-5
assert (s.errors("u", places, times) >= 0).all()
raises(ValueError, "each of x, t once", s.u, 0.5)
raises(ValueError, "x is 2; allowed: 0 to 1", s.u, 2, 0)
raises(ValueError, "'w' is no field", s.evaluate, "w", 0, 0)
try:
    s.w
    raise AssertionError("a field that is none")
except AttributeError:
    pass

s.save("heat.h5")
read = cpinn.open_fit("heat.h5")
assert numpy.array_equal(read.u(places, times), s.u(places, times))
assert repr(read) == repr(s), (read, s)
os.remove("heat.h5")

found = cpinn.fit(heat(lambda e: e.parameter("k", 0.3, 0.4)), tolerance=1e-3, threads=1)
assert found.coordinates == ["x", "t", "k"]
for factor in (0.3, 0.33, 0.4):
    assert abs(found.u(places, times, factor) - exact(places, times, factor)).max() <= 1e-4

with_unknown = heat(lambda e: e.unknown("k", 0.2))
with_unknown.data(x=places, t=times, u=exact(places, times))
found = cpinn.fit(with_unknown, tolerance=1e-7, threads=1)
assert abs(found.unknowns["k"] - 0.4) <= 1e-6 and found.deviations["k"] < 1e-5, found

# A file, or what is in one, gives the same numbers to the last bit: one recorder reads both.
written = {"equations": {
    "coordinates": {"x": {"range": [0, 1]}, "t": {"range": [0, 0.5], "time": True}},
    "fields": ["u"], "inside": ["u_t - 0.4*u_xx"],
    "conditions": [{"at": {"t": 0}, "u": "sin(pi*x)"}, {"at": {"x": 0}, "u": 0}, {"at": {"x": 1}, "zero": "u"}]}}
named = {"equations": {**written["equations"], "parameters": {"F": "-0.4*u_x"}, "inside": ["u_t + F_x"]}}
by_flux = cpinn.fit(named, tolerance=1e-8, threads=1)
assert abs(by_flux.u(places, times) - exact(places, times)).max() <= 30 * by_flux.error
same = cpinn.fit(written, tolerance=1e-8, threads=1)
assert numpy.array_equal(same.u(places, times), s.u(places, times))
raises(ValueError, "equations.inside: column 1 of 'w'", cpinn.fit, written,
       overrides={"equations.inside": "w"})

# Stopped by the caller, and by what the caller raises.
stopped = cpinn.fit(heat(lambda e: 0.4), progress=lambda now: False)
assert stopped.verdict.reason == "unfinished", stopped


def fail(now):
    raise KeyError(now.window)


try:
    cpinn.fit(heat(lambda e: 0.4), progress=fail)
    raise AssertionError("nothing was raised")
except KeyError:
    pass
print("all passed")
