"""A network of tanh as C by CasADi, in every form that it has for it.

peer_casadi.py FOLDER METHOD THREADS, METHOD: the widths, as in 2-64-64-7. Reads FOLDER/network.bin
(layer after layer weights [out][in], bias [out]) and writes FOLDER/FORM_value.c and
FOLDER/FORM_jacobian.c, each with a function of the file's name: one argument, the inputs; results
the outputs and, in the second, their Jacobian (dense, column after column)."""
import os
import sys
import time


def layers(numbers, widths):
    result, at = [], 0
    for k, m in zip(widths[:-1], widths[1:]):
        result.append((numbers[at:at + m * k].reshape(m, k), numbers[at + m * k:at + m * k + m]))
        at += m * k + m
    return result


def network(ca, x, weights):
    for w, b in weights[:-1]:
        x = ca.tanh(ca.mtimes(w, x) + b)
    return ca.mtimes(weights[-1][0], x) + weights[-1][1]


def tangents(ca, x, weights):
    """Outputs and Jacobian, the derivatives by all inputs carried along by hand."""
    count = x.shape[0]
    derivatives = ca.DM.eye(count)
    for w, b in weights[:-1]:
        x = ca.tanh(ca.mtimes(w, x) + b)
        derivatives = ca.repmat(1 - x * x, 1, count) * ca.mtimes(w, derivatives)
    w, b = weights[-1]
    return ca.mtimes(w, x) + b, ca.mtimes(w, derivatives)


def write(ca, weights, form):
    kind, by_hand, cse = {"sx": (ca.SX, False, False), "sx_hand": (ca.SX, True, True),
                          "mx": (ca.MX, False, False), "mx_cse": (ca.MX, False, True),
                          "mx_hand": (ca.MX, True, True)}[form]
    x = kind.sym("x", weights[0][0].shape[1])
    y = network(ca, x, weights)
    jacobian = tangents(ca, x, weights) if by_hand else (y, ca.jacobian(y, x))
    for name, results in (("value", (y,)), ("jacobian", jacobian)):
        function = ca.Function(f"{form}_{name}", [x], [ca.densify(r) for r in results],
                               {"cse": cse})
        function.generate(f"{form}_{name}.c")


def main():
    folder, method = sys.argv[1], sys.argv[2]
    try:
        import casadi
        import numpy
    except ImportError as error:
        print(f"missing {error}", flush=True)
        return
    start = time.perf_counter()
    os.chdir(folder)  # generate() takes no folder
    weights = layers(numpy.fromfile("network.bin"), [int(n) for n in method.split("-")])
    for form in ("sx", "sx_hand", "mx", "mx_cse", "mx_hand"):
        write(casadi, weights, form)
    print(f"ready 0 {time.perf_counter() - start:.6f}", flush=True)


main()
