"""References of the scenes in this folder, by closed forms and by spectral solvers, from their own YAML.

    python3 configs/equations/reference.py                   writes reference/*.csv; some minutes
    python3 configs/equations/reference.py NAME...           of these scenes only
    python3 configs/equations/reference.py --check [--quick] solvers against closed forms, and every
                                                             reference in the equations of its file
    python3 configs/equations/reference.py --variations DIR [--check]  50 variations as YAML and CSV,
                                                             and how accurate they are

Needs numpy and scipy. A file of a scene is read for its numbers, its start and its ranges, so that a
reference and its scene cannot differ."""
import pathlib
import re
import sys

try:
    import numpy as np
    import scipy.fft
    import scipy.integrate
    import scipy.sparse
    import scipy.special
except ImportError:
    print("reference.py needs numpy and scipy")
    sys.exit(77)  # a test that is left out

FOLDER = pathlib.Path(__file__).resolve().parent
LATTICE = 1000  # references know multiples of a thousandth of the time
ALPHA = 0.4     # of the data for heat.yaml
FUNCTIONS = {name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "cosh", "tanh")}


# ---- scenes ------------------------------------------------------------------------------------------

def formula(text, **names):
    return eval(text.replace("^", "**"), {"__builtins__": {}, "pi": np.pi, **FUNCTIONS}, names)


class Scene:
    """What a file says; only the form in which the files of this folder are written is read."""

    def __init__(self, text):
        def found(pattern):
            return re.findall(pattern, text, flags=re.M)

        self.ranges = {name: (formula(low), formula(high)) for name, low, high in
                       found(r"^    (\w+): \{range: \[([^,]+), ([^\]]+)\]")}
        self.numbers = {name: ALPHA if value.startswith("{") else float(formula(value))
                        for line in found(r"^  parameters: \{(.*)\}$")
                        for name, value in re.findall(r"(\w+): (\{[^}]*\}|[^,]+)", line)}
        self.field, = found(r"^  fields: \[(\w+)\]")
        self.inside, = found(r"^  inside: \[(.*)\]$")
        self.conditions = [(face, float(formula(at)), of, value) for face, at, of, value in
                           found(r"^    - \{at: \{(\w+): ([^}]+)\}, (\w+): (.*)\}$")]
        self.__dict__.update(self.numbers)

    def start(self, x):
        text, = [value for face, _, of, value in self.conditions if face == "t" and of == self.field]
        return formula(text, x=x, **self.numbers) + 0 * x


# ---- Fourier series in x, ETDRK4 in time -------------------------------------------------------------

class Fourier:
    """u_t = symbol(i q) u + factor d^order(u^power)/dx^order over one period. Products are free of
    aliasing. The start may have kinks: its coefficients are those of a grid of 2^21 points."""

    def __init__(self, ranges, start, symbol, factor=0, power=2, order=0, modes=512, steps=1):
        low, high = ranges["x"]
        end = ranges["t"][1]
        self.low, self.end, self.start = low, end, start
        fine, count = 2 ** 21, modes // 2
        # Many steps sum the rounding of their factors: where it is cheap, with more digits.
        real = np.longdouble if modes <= 2048 else float
        x = low + (high - low) * np.arange(fine, dtype=real) / fine
        a = (scipy.fft.rfft(start(x)) / fine)[:count]
        self.q = 2j * np.pi / (high - low) * np.arange(count, dtype=real)
        rate = symbol(self.q) + 0j
        if not factor:  # exact
            t = end * np.arange(LATTICE + 1) / LATTICE
            self.table = a * np.exp(rate * t[:, None])
            return
        grid = scipy.fft.next_fast_len((power + 1) * modes // 2 + 1, real=True)

        def product(a):
            u = scipy.fft.irfft(a, grid) * grid
            return outer * scipy.fft.rfft(u ** power)[:count]

        outer = factor * self.q ** order / grid
        h = real(end) / LATTICE / steps
        # Functions phi of h * rate by means over a circle (Kassam, Trefethen 2005).
        z = h * rate[:, None] + np.exp(2j * np.pi * (np.arange(64, dtype=real) + 0.5) / 64)
        e = np.exp(z)
        half = h * np.mean((np.exp(z / 2) - 1) / z, axis=1)
        one = h * np.mean((-4 - z + e * (4 - 3 * z + z * z)) / z ** 3, axis=1)
        two = h * np.mean((2 + z + e * (z - 2)) / z ** 3, axis=1) * 2
        three = h * np.mean((-4 - 3 * z - z * z + e * (4 - z)) / z ** 3, axis=1)
        whole, middle = np.exp(h * rate), np.exp(h * rate / 2)
        self.table = np.empty((LATTICE + 1, count), dtype=complex)  # as double numbers
        self.table[0] = a
        for i in range(1, LATTICE + 1):
            for _ in range(steps):
                n = product(a)
                b = middle * a + half * n
                nb = product(b)
                c = middle * a + half * nb
                nc = product(c)
                d = middle * b + half * (2 * nc - n)
                a = whole * a + one * n + two * (nb + nc) + three * product(d)
            self.table[i] = a

    def __call__(self, x, t, order=0):
        at = np.rint(t / self.end * LATTICE).astype(int)
        u = np.empty(len(x))
        for part in range(0, len(x), 200):
            here = slice(part, part + 200)
            a = self.table[at[here]] * self.q ** order
            wave = np.exp(self.q * (x[here] - self.low)[:, None])
            u[here] = 2 * np.sum(a * wave, axis=1).real - a[:, 0].real
        return u if order else np.where(at == 0, self.start(x), u)


# ---- closed forms ------------------------------------------------------------------------------------

def cole_hopf(start, nu, points=2000):
    """The mean of the start over exp(-(x - y)^2 / (4 nu t) - P(y) / (2 nu)), where P' is the start."""
    size = 4096
    y = -1 + 2 * np.arange(size) / size
    a = scipy.fft.rfft(start(y)) / size
    a[np.abs(a) < 1e-15 * np.abs(a).max()] = 0
    count = np.flatnonzero(a)[-1] + 1
    q = np.pi * np.arange(count)
    primitive = np.zeros(count, dtype=complex)
    primitive[1:] = a[1:count] / (1j * q[1:])
    z, weight = scipy.special.roots_hermite(points)
    z, weight = z[weight > 0], weight[weight > 0]

    def u(x, t):
        value = np.empty(len(x))
        for i, (at, time) in enumerate(zip(x, t)):
            if time == 0:
                value[i] = start(at)
                continue
            y = at - 2 * np.sqrt(nu * time) * z
            p = np.zeros(len(y))
            for k in np.flatnonzero(primitive):
                p += 2 * (primitive[k] * np.exp(1j * q[k] * (y + 1))).real
            p = np.log(weight) - p / (2 * nu)
            p = np.exp(p - p.max())
            value[i] = np.sum(start(y) * p) / np.sum(p)
        return value
    return u


def beam(EI, k, c, q, slopes, modes=64):
    """EI w'''' + k w + c w^3 = q(x) on 0..1 with w = 0 and the derivative of order slopes 0 at both
    ends. The unknown is w'''' as a Chebyshev series: integration is well conditioned."""
    C = np.polynomial.chebyshev
    four = np.zeros((modes + 4, modes))
    for j in range(modes):
        series = C.chebint(np.eye(modes)[j], 4)
        four[:len(series), j] = series
    ends = np.zeros((4, modes + 4))
    for j in range(modes + 4):
        unit = np.eye(modes + 4)[j]
        ends[:2, j] = C.chebval([-1, 1], unit)
        ends[2:, j] = C.chebval([-1, 1], C.chebder(unit, slopes))
    four[:4] -= np.linalg.solve(ends[:, :4], ends @ four)  # a cubic makes the ends right
    z = np.cos(np.pi * (np.arange(modes) + 0.5) / modes)
    values, shape = C.chebvander(z, modes - 1), C.chebvander(z, modes + 3) @ four / 16  # x = (z + 1) / 2
    g, load = np.zeros(modes), q((z + 1) / 2) + 0 * z
    for _ in range(30):
        w = shape @ g
        step = np.linalg.solve(EI * values + (k + 3 * c * w * w)[:, None] * shape,
                               EI * (values @ g) + k * w + c * w ** 3 - load)
        g = g - step
        if np.abs(step).max() < 1e-13 * np.abs(g).max():
            break
    series = four @ g / 16
    return lambda x, order=0: C.chebval(2 * x - 1, C.chebder(series, order) if order else series) * 2 ** order


# ---- the reference of a scene ------------------------------------------------------------------------

def fourier_of(scene, kind, finer=0):
    """With a finer grid: bit 0 halves the steps, bit 1 doubles the modes."""
    n = scene.numbers
    # Allen-Cahn: what is left of a kink after a thousandth of the time sets the modes.
    kink = 2 * round(max(1250, 4096 * (1e-4 / n.get("D", 1) / scene.ranges["t"][1]) ** 0.5))
    symbol, factor, power, order, modes, steps = {
        "burgers": lambda: (lambda q: n["nu"] * q ** 2, -0.5, 2, 1, 4096, 40),
        "allen_cahn": lambda: (lambda q: n["D"] * q ** 2 + n["r"], -n["r"], 3, 0, kink, 10),
        "kdv": lambda: (lambda q: -n["d"] ** 2 * q ** 3, -0.5, 2, 1, 1024, 40),
        "kuramoto_sivashinsky": lambda: (
            lambda q: -n["b"] * q ** 2 - n["g"] * q ** 4, -n["a"] / 2, 2, 1, 512, 40),
    }[kind]()
    return Fourier(scene.ranges, scene.start, symbol, factor, power, order,
                   modes * (2 if finer & 2 else 1), steps * (2 if finer & 1 else 1))


def reference(scene, kind, finer=0):
    """A function of the coordinates. With finer another one of the same solution, for comparison."""
    s = scene
    if kind == "burgers":
        if finer == 2:
            return fourier_of(s, kind)
        return cole_hopf(s.start, s.nu, 2000 if finer == 0 else 2800)
    if kind in SOLVED:
        return fourier_of(s, kind, finer)
    if kind == "wave":
        return lambda x, t: (s.start(x - s.c * t) + s.start(x + s.c * t)) / 2
    if kind == "convection":
        return lambda x, t: s.start(x - s.beta * t)
    if kind == "klein_gordon":
        return lambda x, t: x * np.cos(s.w * t) + (x * t) ** 3
    if kind == "helmholtz":
        return lambda x, y: np.sin(s.a * np.pi * x) * np.sin(s.b * np.pi * y)
    if kind == "poisson":
        p = np.pi
        return lambda x, y: (np.sin(p * x) * np.sin(p * y) + np.sin(4 * p * x) * np.sin(3 * p * y) / 2
                             + np.sin(s.a * p * x) * np.sin(s.b * p * y) / 10)
    if kind == "heat":
        return lambda x, t: (np.sin(np.pi * x) * np.exp(-s.alpha * np.pi ** 2 * t)
                             + np.sin(3 * np.pi * x) / 2 * np.exp(-9 * s.alpha * np.pi ** 2 * t))
    if kind == "beam":
        return beam(s.EI, s.k, s.c, lambda x: s.q, 1 if f"{s.field}_x:" in
                    " ".join(of + ":" for _, _, of, _ in s.conditions) else 2, 96 if finer else 64)
    raise ValueError(kind)


def kind_of(name):
    """burgers of burgers_07, beam of beam_clamped."""
    return next(kind for kind in KINDS if name.startswith(kind))


KINDS = ("burgers", "allen_cahn", "kdv", "kuramoto_sivashinsky", "wave", "convection", "klein_gordon",
         "helmholtz", "poisson", "heat", "beam")
SOLVED = KINDS[:4]
CLOSED = ("wave", "convection", "klein_gordon", "helmholtz", "poisson", "heat")


# ---- places and files --------------------------------------------------------------------------------

def places(scene, u, count, draw):
    """Two thirds drawn evenly, a third where u is steep, all with few digits."""
    def even(n):
        at = []
        for name, (low, high) in scene.ranges.items():
            if name == "t":
                at.append((high - low) * draw.integers(0, LATTICE + 1, n) / LATTICE)
            else:
                at.append(np.clip(np.round(draw.uniform(low, high, n), 6), low, high))
        return at
    chosen = even(count - count // 3)
    tried = even(4 * count)
    low, high = next(iter(scene.ranges.values()))
    h = 1e-3 * (high - low)
    inner = [np.clip(tried[0], low + h, high - h)] + tried[1:]
    slope = np.abs(u(inner[0] + h, *inner[1:]) - u(inner[0] - h, *inner[1:]))
    steep = draw.choice(4 * count, count // 3, replace=False, p=slope / slope.sum())
    at = [np.concatenate([a, b[steep]]) for a, b in zip(chosen, tried)]
    order = np.lexsort(at[::-1]) if "t" not in scene.ranges else np.lexsort([at[0], at[1]])
    return [a[order] for a in at]


def write(file, scene, head, columns):
    names = list(scene.ranges) + [scene.field]
    with open(file, "w", encoding="ascii") as out:
        for line in head:
            out.write(f"# {line}\n")
        out.write(",".join(names) + "\n")
        for row in zip(*columns):
            out.write(",".join(f"{value:.12g}" for value in row[:-1]) + f",{row[-1]:.16g}\n")


def relative(a, b):
    return np.linalg.norm(a - b) / np.linalg.norm(b)


def write_reference(name, text, folder, count=1500, check=True):
    scene, kind = Scene(text), kind_of(name)
    u = reference(scene, kind)
    draw = np.random.default_rng(34)
    at = places(scene, u, count if len(scene.ranges) > 1 else count // 3, draw)
    value = u(*at)
    head = [f"Reference of {name}.yaml, made by configs/equations/reference.py: places drawn evenly, and",
            "a third of them where the field is steep."]
    if kind in CLOSED:
        head.append("Closed form; its error is that of rounding.")
    elif check:
        words = {"burgers": ("with more points of quadrature", "to the Fourier solver"),
                 "beam": ("to 96 modes from 64",)}.get(kind, ("by halved steps", "by doubled modes"))
        for bit, what in enumerate(words):
            other = reference(scene, kind, 1 << bit)(*at)
            head.append(f"Relative L2 difference {what}: {relative(value, other):.1e}; "
                        f"largest {np.abs(value - other).max():.1e}.")
    write(pathlib.Path(folder) / f"{name}.csv", scene, head, at + [value])
    print(name, *head[2:], flush=True)


def write_data():
    """Measurements for heat.yaml and heat_exact.yaml."""
    scene = Scene((FOLDER / "heat.yaml").read_text())
    u = reference(scene, "heat")
    draw = np.random.default_rng(34)
    x, t = (np.round(draw.uniform(0, 1, 60), 3) for _ in range(2))
    t = np.round(0.5 * t, 4)  # later there is nothing left to measure
    for name, noise in (("heat_exact", 0), ("heat", 0.01)):
        start = np.abs(scene.start(np.linspace(0, 1, 1001))).max()
        write(FOLDER / "reference" / f"{name}_data.csv", scene,
              [f"Measurements of {name}.yaml, with alpha = {ALPHA}, made by configs/equations/reference.py;",
               f"normal noise of {noise * start:.3g}."], [x, t, u(x, t) + noise * start * draw.normal(size=60)])


# ---- checks ------------------------------------------------------------------------------------------

STENCIL = {1: [0, 4 / 5, -1 / 5, 4 / 105, -1 / 280],
           2: [-205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560],
           4: [91 / 8, -122 / 15, 169 / 60, -2 / 5, 7 / 240]}


def derivative(scene, u, name, at):
    """By differences of eighth order (fourth derivatives: sixth), in x of Fourier and Chebyshev series
    exactly."""
    letters = name.partition("_")[2]
    if not letters:
        return u(*at)
    axis, order = list(scene.ranges).index(letters[0]), len(letters)
    if letters[0] == "x" and (isinstance(u, Fourier) or len(scene.ranges) == 1):
        return u(*at, order=order)
    low, high = scene.ranges[letters[0]]
    h = (high - low) / (LATTICE if letters[0] == "t" and isinstance(u, Fourier) else 200)
    total = 0
    for i, weight in enumerate(STENCIL[order]):
        for sign in ((1, -1) if i else (1,)):
            moved = [a + sign * i * h if k == axis else a for k, a in enumerate(at)]
            total = total + weight * (sign if order % 2 else 1) * u(*moved)
    return total / h ** order


def check_scene(name, text):
    """The largest residual of the file's own equations and conditions on its reference, each over the
    largest of the terms."""
    scene, kind = Scene(text), kind_of(name)
    u = fourier_of(scene, kind) if kind in SOLVED else reference(scene, kind)
    draw = np.random.default_rng(1)
    at = []
    for letter, (low, high) in scene.ranges.items():
        inner = draw.uniform(low + 0.05 * (high - low), high - 0.05 * (high - low), 300)
        at.append(np.rint(inner / high * LATTICE) * high / LATTICE if letter == "t" else inner)
    names = dict(zip(scene.ranges, at), **scene.numbers)
    words = set(re.findall(rf"\b{scene.field}(?:_\w+)?\b", scene.inside))
    values = {word: derivative(scene, u, word, at) for word in words}
    residual = formula(scene.inside, **names, **values)
    scale = max(np.abs(value).max() for value in values.values())
    worst = np.abs(residual).max() / scale
    for face, where, of, text in scene.conditions:
        low, high = scene.ranges[face]
        on = [np.full(300, where) if letter == face else a for letter, a in zip(scene.ranges, at)]
        size = 1
        if "_" in of and len(scene.ranges) > 1:  # a rate at the start: the closed forms hold before it
            got, size = derivative(scene, u, of, on), np.abs(derivative(scene, u, of, at)).max()
        else:
            got = derivative(scene, u, of, on)
        want = formula(text, **{**names, **dict(zip(scene.ranges, on))})
        worst = max(worst, np.abs(got - want).max() / size)
    return worst


def check(quick):
    """Prints a line each; exit status 1 when one is off. Quick leaves out the scenes whose reference takes
    a Fourier solver."""
    bad = 0

    def say(what, error, limit):
        nonlocal bad
        bad += not error <= limit
        print(f"{what:<62} {error:.1e}  {'' if error <= limit else 'is above '}{limit:.0e}", flush=True)

    ranges = {"x": (-1, 1), "t": (0, 1)}
    x, t = np.linspace(-1, 1, 400), np.repeat([0.25, 1], 200)

    # A soliton passes the border; what is left of it there is 1e-14. The limits of these three are the
    # solver's steps: halving them shows 1e-11.
    d = 0.03

    def soliton(x, t):
        z = (x - t + 1) % 2 - 1
        return 3 / np.cosh(z / (2 * d)) ** 2
    u = Fourier(ranges, lambda x: soliton(x, 0), lambda q: -d ** 2 * q ** 3, -0.5, 2, 1, 256, 20)
    say("KdV: Fourier solver and soliton", relative(u(x, t), soliton(x, t)), 1e-10)

    # Two fronts apart from each other; where they meet they differ from 1 and from 0 by 1e-15.
    D, r = 5e-4, 5

    def front(x, t):
        return 1 / (1 + np.exp(np.sqrt(r / 2 / D) * (np.abs(x) - 0.5 - 3 * np.sqrt(r * D / 2) * t)))
    u = Fourier(ranges, lambda x: front(x, 0), lambda q: D * q ** 2 + r, -r, 3, 0, 1024, 5)
    say("Allen-Cahn: Fourier solver and travelling front", relative(u(x, t), front(x, t)), 1e-10)

    # The kink of allen_cahn.yaml: finite differences on 500 and 1,000 intervals from the middle to the
    # border, extrapolated; 2,000 change the value there by 7e-7.
    D, ends = 1e-4, []
    for n in (500, 1000):
        s = np.linspace(0, 1, n + 1)
        beside = np.ones(n)
        up, down = beside.copy(), beside.copy()
        up[0] = down[-1] = 2
        second = scipy.sparse.diags([down, -2 * np.ones(n + 1), up], [-1, 0, 1], format="csc") * (D * n * n)
        found = scipy.integrate.solve_ivp(
            lambda _, v: second @ v + r * v - r * v ** 3, (0, 0.1), s ** 2 * np.cos(np.pi * s), method="Radau",
            jac=lambda _, v: second + scipy.sparse.diags(r - 3 * r * v ** 2), rtol=1e-8, atol=1e-10)
        ends.append(found.y[-1, -1])
    u = Fourier({"x": (-1, 1), "t": (0, 0.1)}, lambda x: x ** 2 * np.cos(np.pi * x),
                lambda q: D * q ** 2 + r, -r, 3, 0, 2000)
    say("Allen-Cahn: Fourier solver and finite differences at a kink",
        abs(u(np.ones(1), np.full(1, 0.1))[0] - (4 * ends[1] - ends[0]) / 3), 2e-6)

    # Burgers' equation with two waves in its start, whose fronts move.
    def two(x):
        return -np.sin(np.pi * x) + np.sin(2 * np.pi * x) / 2
    u = Fourier(ranges, two, lambda q: 0.03 * q ** 2, -0.5, 2, 1, 256, 10)
    say("Burgers: Fourier solver and Cole-Hopf", relative(u(x, t), cole_hopf(two, 0.03)(x, t)), 1e-10)

    x = np.linspace(0, 1, 200)
    for slopes, n in ((1, 2), (2, 1)):  # clamped sin^2, hinged sin
        w = (lambda x: np.sin(np.pi * x) ** 2 / 5) if n == 2 else (lambda x: np.sin(np.pi * x) / 5)
        fourth = ((lambda x: -8 * np.pi ** 4 * np.cos(2 * np.pi * x) / 5) if n == 2 else
                  (lambda x: np.pi ** 4 * np.sin(np.pi * x) / 5))
        got = beam(1, 50, 5000, lambda x: fourth(x) + 50 * w(x) + 5000 * w(x) ** 3, slopes)
        say(f"beam: Chebyshev solver and sin(pi x)^{n} / 5", relative(got(x), w(x)), 1e-13)

    # Differences in time limit these; a wrong sign or number would give 1.
    for file in sorted(FOLDER.glob("*.yaml")):
        if quick and kind_of(file.stem) in SOLVED:
            continue
        say(f"{file.name}: its equations on its reference", check_scene(file.stem, file.read_text()), 1e-6)
    return bad > 0


# ---- variations --------------------------------------------------------------------------------------

def variations():
    """(name, text of the file): other coefficients, starts and lengths, from a fixed seed."""
    draw = np.random.default_rng(50)

    def number(low, high):
        return f"{np.exp(draw.uniform(np.log(low), np.log(high))):.3g}"

    def changed(kind, base, i, start=None, end=None, **numbers):
        text = (FOLDER / f"{base}.yaml").read_text()
        for name, value in numbers.items():
            text, count = re.subn(rf"\b{name}: [^,}}\s]+(?=[,}}])", f"{name}: {value}", text)
            assert count == 1, (base, name)
        for pattern, value in ((r"(at: \{t: 0\}, u: ).*\}$", start and start + "}"),
                               (r"(    t: \{range: \[0, )[^\]]+", end)):
            if value:
                text, count = re.subn(pattern, lambda found: found[1] + value, text, flags=re.M)
                assert count == 1, (base, pattern)
        head = f"# A variation of configs/equations/{base}.yaml.\n"
        return f"{kind}_{i:02d}", head + re.sub(r"^#.*\n", "", text, flags=re.M)

    def waves(of, count):
        """A sum of waves with falling amplitudes, the first of them not small."""
        sizes = {k: round(draw.uniform(0.3, 1.5) if k == 1 else draw.uniform(-1, 1) / k, 2)
                 for k in range(1, 1 + count)}
        text = " ".join(f"{'-' if size < 0 else '+'} {abs(size)}*{of.format(k)}" for k, size in sizes.items())
        return text[2:].replace("(1*", "(")

    for i in range(10):
        yield changed("burgers", "burgers", i, nu=number(0.002, 0.1), end=number(0.5, 2),
                      start=waves("sin({}*pi*x)", 1 + i % 3))
    for i in range(6):
        yield changed("allen_cahn", "allen_cahn", i, D=number(1e-4, 1e-2), r=number(2, 6), end=number(0.5, 1.5),
                      start=None if i % 2 else waves("cos({}*pi*x)", 2))
    for i in range(6):
        yield changed("kdv", "kdv", i, d=number(0.02, 0.1), end=number(0.3, 1), start=waves("cos({}*pi*x)", 1 + i % 2))
    for i in range(6):
        yield changed("wave", "wave", i, c=number(0.5, 3), end=number(0.5, 2), start=waves("sin({}*pi*x)", 2 + i % 3))
    for i in range(6):
        yield changed("convection", "convection_30", i, beta=number(1, 60), start=waves("sin({}*x)", 1 + i % 3))
    for i in range(4):
        yield changed("kuramoto_sivashinsky", "kuramoto_sivashinsky", i, a=number(2, 6), b=number(0.2, 0.5),
                      g=number(0.005, 0.01), end=number(0.3, 1))
    for i in range(4):
        yield changed("klein_gordon", "klein_gordon", i, w=number(2, 20), end=number(0.5, 1.5))
    for i in range(4):
        yield changed("helmholtz", "helmholtz", i, k=number(0.5, 4), a=draw.integers(1, 4), b=draw.integers(1, 6))
    for i in range(4):
        base = ("beam_clamped", "beam_hinged")[i % 2]
        yield changed("beam", base, i, k=number(10, 1000), c=number(100, 1e5), q=number(10, 1000))


def main(words):
    if words[:1] == ["--check"]:
        return check("--quick" in words)
    if words[:1] == ["--variations"]:
        folder = pathlib.Path(words[1])
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in variations():
            (folder / f"{name}.yaml").write_text(text)
            write_reference(name, text, folder, check="--check" in words)
        return 0
    if not words:
        write_data()
    for file in sorted(FOLDER.glob("*.yaml")):
        if not words or file.stem in words:
            write_reference(file.stem, file.read_text(), FOLDER / "reference")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
