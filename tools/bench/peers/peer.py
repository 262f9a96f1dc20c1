"""What the peers share: the case, the talk with tools/bench/step.py, the check of the answer."""
import ctypes
import json
import os
import sys
import time

AGREEMENT = 1e-10


def set_threads(count):
    """Before the first import of a library that starts threads."""
    for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[name] = str(count)
    os.environ["JAX_PLATFORMS"] = "cpu"
    os.environ["JAX_ENABLE_X64"] = "1"
    flags = f"--xla_cpu_multi_thread_eigen={'true' if count > 1 else 'false'}"
    flags += f" --xla_force_host_platform_device_count={count}"
    os.environ["XLA_FLAGS"] = os.environ.get("XLA_FLAGS", "") + " " + flags
    cores = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, cores[:count])


def keep_memory():
    """glibc gives large blocks back to the system at once and gets them zeroed again, which costs
    eager libraries more than their arithmetic: keep them (M_MMAP_MAX, M_TRIM_THRESHOLD)."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt:
        mallopt(-4, 0)
        mallopt(-1, 2 ** 31 - 1)


class Case:
    """Points s, t [points], flat parameters x, numbers of the rod, and the answer to meet."""

    def __init__(self, folder):
        import numpy

        with open(os.path.join(folder, "case.json"), encoding="ascii") as file:
            self.numbers = json.load(file)
        n, parameters = self.numbers["points"], self.numbers["parameters"]
        data = numpy.fromfile(os.path.join(folder, "case.bin"))
        self.s, self.t, self.x, loss, self.gradient = numpy.split(
            data, numpy.cumsum([n, n, parameters, 1]))
        self.loss = float(loss[0])
        self.jtj_file = os.path.join(folder, "jtj.bin")
        widths = [2] + [self.numbers["width"]] * self.numbers["hidden"] + [7]
        self.shapes = list(zip(widths[1:], widths[:-1]))

    def layers(self, x):
        """Views of the flat vector: [(weights [out, in], bias [out])]."""
        layers, at = [], 0
        for m, k in self.shapes:
            layers.append((x[at:at + m * k].reshape(m, k), x[at + m * k:at + m * k + m]))
            at += m * k + m
        return layers

    def blend(self):
        """f = s (1 - s) (t / duration)^2 and f_s, f_ss, f_t, f_tt."""
        s, t, unit = self.s, self.t, 1 / self.numbers["duration"] ** 2
        along, since = s * (1 - s), t * t * unit
        return (along * since, (1 - 2 * s) * since, -2 * since,
                along * 2 * t * unit, along * 2 * unit)

    def difference(self, loss, gradient):
        import numpy

        gradient = numpy.asarray(gradient)
        return max(abs(float(loss) - self.loss) / abs(self.loss), _relative(gradient, self.gradient))

    def difference_normal(self, loss, jtj, jtr):
        import numpy

        n = len(self.x)
        expected = numpy.fromfile(self.jtj_file).reshape(n, n)
        upper = numpy.triu(numpy.asarray(jtj))
        return max(self.difference(loss, 2 * numpy.asarray(jtr)),
                   _relative(upper, numpy.triu(expected)))


def _relative(a, b):
    worst = abs(a - b).max() / abs(b).max()
    return float(worst) if worst == worst else float("inf")


def _say(text):
    print(text, flush=True)


def serve(prepare):
    """prepare(case, method, threads) returns (step, difference): step() does all of one step and
    returns when it is done, difference(what step returned) is relative."""
    folder, method, threads = sys.argv[1], sys.argv[2], int(sys.argv[3])
    set_threads(threads)
    keep_memory()
    try:
        step, difference = prepare(Case(folder), method, threads)
        start = time.perf_counter()
        result = step()
        preparation = time.perf_counter() - start
        worst = difference(result)
    except ImportError as error:
        _say(f"missing {error}")
        return
    except Exception as error:  # the table has a row for it
        _say(f"failed {type(error).__name__}: {error}".replace("\n", " "))
        return
    if not worst <= AGREEMENT:
        _say(f"failed it differs by {worst:.1e}; at most {AGREEMENT:.0e} is allowed")
        return
    step()
    _say(f"ready {worst:.3e} {preparation:.6f}")
    for _ in sys.stdin:
        start = time.perf_counter()
        step()
        _say(f"{time.perf_counter() - start:.9f}")
