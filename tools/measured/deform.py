"""Columns of recordings of a cable of DEFORM (roahmlab/DEFORM), for configs/measured/deform.yaml.

    python3 deform.py FOLDER OUT.csv PART/NUMBER...      # such as data_set/DLO1 fit.csv train/101 train/105

One row for each vertex that is free, at each time; recordings follow one another, t falls where the next one begins.
Recordings are cut from longer ones: where the one before ends where this one begins, the ends move as in its last 2 s,
without measured vertices, before it begins. Places of vertices along the cable are mean distances in all of FOLDER/train;
the length goes to OUT.length.

The rotations of the ends are not measured: d3 goes through the two vertices that are held, and turns in time from the
first row on without twist about itself. There it goes from the start to the end along the vertices, without twist, too.
"""
import csv
import glob
import pickle
import sys

import numpy

BEFORE = 200  # samples
RATE = 100.0  # Hz
GAP = 0.05  # m, between samples of one recording


class Arrays(pickle.Unpickler):
    """Pickles may run what they name: here they name numpy's arrays and nothing else."""

    def find_class(self, module, name):
        if module.split(".")[0] != "numpy" or name not in ("_reconstruct", "ndarray", "dtype"):
            raise pickle.UnpicklingError(f"{module}.{name} is no array")
        return super().find_class(module, name)


def read(name):
    """[times][vertices][coordinates], m."""
    with open(name, "rb") as file:
        return numpy.array(Arrays(file).load()).transpose(0, 2, 1)


def product(p, q):
    return numpy.concatenate(([p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + numpy.cross(p[1:], q[1:])))


def least_turn(a, b):
    """The quaternion of the least turn from direction a to b."""
    q = numpy.concatenate(([1 + a @ b], numpy.cross(a, b)))
    return q / numpy.linalg.norm(q)


def follow(directions, q):
    """Rotations whose d3 go along directions, from q on, without twist."""
    rotations = [q]
    for a, b in zip(directions, directions[1:]):
        rotations.append(product(least_turn(a, b), rotations[-1]))
    return numpy.array(rotations)


def with_before(folder, name):
    """A recording with what is before it, and how many rows that is."""
    now, number = read(f"{folder}/{name}.pkl"), int(name.split("/")[-1])
    for part in ("train", "eval"):
        for file in glob.glob(f"{folder}/{part}/{number - 1}.pkl"):
            before = read(file)[-BEFORE:]
            if abs(before[-1] - now[0]).max() < GAP:
                return numpy.concatenate((before, now)), BEFORE
    return now, 0


def main(folder, out, names):
    lengths = [numpy.linalg.norm(numpy.diff(read(name), axis=1), axis=2).mean(axis=0) for name in glob.glob(f"{folder}/train/*.pkl")]
    place = numpy.concatenate(([0], numpy.cumsum(numpy.mean(lengths, axis=0))))
    with open(out.replace(".csv", ".length"), "w") as file:
        print(f"{place[-1]:.5f}", file=file)
    down = numpy.array([-1.0, 0.0, -1.0]) / 2**0.5
    upright = least_turn(numpy.array([0.0, 0.0, 1.0]), down)
    with open(out, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow("t s x y z x0 y0 z0 a0 b0 c0 d0 x1 y1 z1 a1 b1 c1 d1".split())
        for name in names:
            vertices, first = with_before(folder, name)
            along = numpy.diff(vertices, axis=1)
            along /= numpy.linalg.norm(along, axis=2, keepdims=True)
            start = product(least_turn(down, along[0, 0]), upright)
            q = [follow(along[:, 0], start), follow(along[:, -1], follow(along[0], start)[-1])]
            for i, now in enumerate(vertices):
                held = [f"{x:.6f}" for x in (*now[0], *q[0][i], *now[-1], *q[1][i])]
                for k in range(2, len(place) - 2) if i >= first + 2 else [2]:
                    seen = [f"{x:.6f}" for x in now[k]] if i >= first + 2 else ["", "", ""]
                    writer.writerow([f"{i / RATE:.2f}", f"{place[k]:.5f}", *seen, *held])


main(sys.argv[1], sys.argv[2], sys.argv[3:])
