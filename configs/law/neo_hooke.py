"""Makes the data of this folder, and the reference: a rod of rubber in closed form.

    python3 configs/law/neo_hooke.py        (numpy, scipy)

An incompressible Neo-Hookean solid, energy mu/2 (|F|^2 - 3) per volume, whose sections stay plane
and swell or shrink in their plane: F = (a d1, a d2, p), p = v + u x r, a^2 p_3 = 1. Of a disc of
radius R, area A and second moment I the integral is, with k^2 = u_1^2 + u_2^2,

    W = mu/2 (A |v|^2 + I k^2 + 2 I u_3^2 + 4 pi R^2/(v_3 + sqrt(v_3^2 - k^2 R^2)) - 3 A).

The references are the rods of stretched.yaml and rolled.yaml with this law. Of the first strains follow
from force and moment by Newton's method in each section, and the moment at the clamp by shooting; the
second is an arc, whose moment and stretch follow from its curvature.
"""

import os

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

folder = os.path.dirname(os.path.abspath(__file__))
R, mu, length = 0.01, 1e5, 0.08
A, I = np.pi * R**2, np.pi * R**4 / 4
tip_force, tip_moment = np.array([1.5, 0.5, 20]), np.array([0.04, 0, 0.02])


def stress(x):
    """n, m of v, u."""
    v, u = x[:3], x[3:]
    root = np.sqrt(v[2]**2 - (u[0]**2 + u[1]**2) * R**2)
    by_sum = -2 * np.pi * mu * R**2 / (v[2] + root)**2
    bend = mu * I - by_sum * R**2 / root
    return np.array([mu * A * v[0], mu * A * v[1], mu * A * v[2] + by_sum * (1 + v[2] / root),
                     bend * u[0], bend * u[1], 2 * mu * I * u[2]])


def strains(wrench, x):
    """v, u of n, m, from x on; derivatives by complex steps."""
    for _ in range(50):
        jacobian = np.array([stress(x + 1e-30j * e).imag / 1e-30 for e in np.eye(6)]).T
        step = np.linalg.solve(jacobian, wrench - stress(x))
        while not (x + step)[2] > R * np.hypot(*(x + step)[3:5]):
            step /= 2
        x = x + step
        if np.abs(step).max() < 1e-13:
            break
    return x


def turned(q):
    w, x = q[0], q[1:]
    cross = np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])
    return (w * w - x @ x) * np.eye(3) + 2 * np.outer(x, x) + 2 * w * cross


def shoot(moment, share, s):
    found = np.array([0, 0, 1.0, 0, 0, 0])

    def rate(_, y):
        nonlocal found
        rotation, q = turned(y[3:7] / np.linalg.norm(y[3:7])), y[3:7]
        wrench = np.concatenate([rotation.T @ tip_force * share, rotation.T @ y[7:]])
        found = strains(wrench, found)
        v, u = found[:3], found[3:]
        tangent = rotation @ v
        turn = np.concatenate([[-q[1:] @ u], q[0] * u + np.cross(q[1:], u)]) / 2
        return np.concatenate([tangent, turn, -np.cross(tangent, tip_force * share)])

    start = np.concatenate([np.zeros(3), [1, 0, 0, 0], moment])
    return solve_ivp(rate, [0, length], start, t_eval=s, method="DOP853", rtol=1e-11, atol=1e-13).y


def write(name, header, columns, rows, digits):
    with open(os.path.join(folder, name), "w", newline="") as file:
        file.write(header + ",".join(columns) + "\n")
        for row in rows:
            file.write(",".join(f"{x:.{digits}g}" for x in row) + "\n")


draw = np.random.default_rng(1)
rows = []
while len(rows) < 300:
    x = draw.uniform([-0.3, -0.3, 0.75, -50, -50, -50], [0.3, 0.3, 1.4, 50, 50, 50])
    if x[2] > R * np.hypot(x[3], x[4]) + 0.3:
        rows.append([*x, *stress(x)])
write("neo_hooke_data.csv", "", "v1 v2 v3 u1 u2 u3 n1 n2 n3 m1 m2 m3".split(), rows, 6)

moment = np.zeros(3)
for share in (0.25, 0.5, 0.75, 1):
    moment = fsolve(lambda m: 100 * (shoot(m, share, [length])[7:, -1] - share * tip_moment), moment,
                    xtol=1e-12)
s = np.linspace(0, length, 41)
write("reference/stretched.csv", "# The rod of stretched.yaml with the law of neo_hooke.py itself.\n",
      "s x y z qw qx qy qz".split(), np.vstack([s, shoot(moment, 1, s)[:7]]).T, 12)

# An arc about x: the stretch without a force, and the moment, which rolled.yaml has.
k = 3 / length
v3 = fsolve(lambda v: stress(np.array([0, 0, v[0], k, 0, 0]))[2], [1.0], xtol=1e-12)[0]
print("moment of rolled.yaml", repr(stress(np.array([0, 0, v3, k, 0, 0]))[3]))
zero, angle = 0 * s, k * s
write("reference/rolled.csv", "# The rod of rolled.yaml with the law of neo_hooke.py itself.\n",
      "s x y z qw qx qy qz".split(),
      np.vstack([s, zero, v3 * (np.cos(angle) - 1) / k, v3 * np.sin(angle) / k, np.cos(angle / 2),
                 np.sin(angle / 2), zero, zero]).T, 12)
