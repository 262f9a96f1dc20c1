"""Residual of the rod (step.py) from its pose and its derivatives. `np` is torch or jax.numpy;
vectors are tuples of arrays over the points, so that nothing but elementwise products is left."""


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def plus(a, b):
    return tuple(x + y for x, y in zip(a, b))


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def times(a, b):
    return tuple(a * y for y in b)


def each(a, b):
    return tuple(x * y for x, y in zip(a, b))


def relative(p, a):
    """vec(p* a)"""
    v = p[1:]
    return minus(minus(times(p[0], a[1:]), times(a[0], v)), cross(v, a[1:]))


def turned(p, x):
    """|p|^2 R(p)^T x"""
    v = p[1:]
    scale = p[0] * p[0] - dot(v, v)
    return minus(plus(times(scale, x), times(2 * dot(v, x), v)), times(2 * p[0], cross(v, x)))


def turned_back(p, x):
    """|p|^2 R(p) x"""
    return turned((-p[0],) + p[1:], x)


def residual(numbers, world, x_s, x_ss, x_tt, p, p_s, p_ss, p_t, p_tt):
    """Six arrays, force and moment, each times the root of its weight. The loss does not depend on
    the frame of force, J^T J does: `world`, or that of the body. p need not be of unit length: the
    rates of p/|p| are 2 vec(p* p_s)/|p|^2."""
    stiff, bend = numbers["strain_stiffness"], numbers["curvature_stiffness"]
    inertia = numbers["rotary_inertia"]
    over = 1 / dot(p, p)
    twice = 2 * over
    u, w = times(twice, relative(p, p_s)), times(twice, relative(p, p_t))
    u_s = minus(times(twice, relative(p, p_ss)), times(twice * dot(p, p_s), u))
    w_t = minus(times(twice, relative(p, p_tt)), times(twice * dot(p, p_t), w))
    v = times(over, turned(p, x_s))
    v_s = minus(times(over, turned(p, x_ss)), cross(u, v))
    load = times(over, turned(p, minus(numbers["weight"], x_tt)))
    n = each(stiff, (v[0], v[1], v[2] - 1))
    force = plus(plus(each(stiff, v_s), cross(u, n)), load)
    moment = plus(plus(each(bend, u_s), cross(u, each(bend, u))), cross(v, n))
    moment = minus(moment, plus(each(inertia, w_t), cross(w, each(inertia, w))))
    if world:
        force = times(over, turned_back(p, force))
    roots = numbers["force_weight"] ** 0.5, numbers["moment_weight"] ** 0.5
    return times(roots[0], force) + times(roots[1], moment)


def blended(f, y):
    """f y by the product rule: both (value, s, ss, t, tt)."""
    return (f[0] * y[0], f[1] * y[0] + f[0] * y[1],
            f[2] * y[0] + 2 * f[1] * y[1] + f[0] * y[2],
            f[3] * y[0] + f[0] * y[3],
            f[4] * y[0] + 2 * f[3] * y[3] + f[0] * y[4])


def residual_of_outputs(numbers, f, y, world=False):
    """From outputs and derivatives: f and y[o] are (value, s, ss, t, tt), o = 0 .. 6."""
    z = [blended(f, y[o]) for o in range(7)]
    x_s = (z[0][1], z[1][1], z[2][1] + 1)
    x_ss, x_tt = (tuple(z[o][k] for o in range(3)) for k in (2, 4))
    p, p_s, p_ss, p_t, p_tt = (tuple(z[o][k] for o in range(3, 7)) for k in range(5))
    p = (p[0] + 1,) + p[1:]
    return residual(numbers, world, x_s, x_ss, x_tt, p, p_s, p_ss, p_t, p_tt)
