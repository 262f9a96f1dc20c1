"""Numeric arrays of a file of MATLAB (level 5), one row for each of the longest dimension, as CSV.

    mat_to_csv.py FILE.mat NAME... > FILE.csv        columns NAME1, NAME2, ..."""
import struct
import sys
import zlib

TYPES = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 9: "d"}


def elements(data):
    """(type, bytes) of each element; small ones have both in one word."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from("<II", data, at)
        if kind >> 16:
            kind, size, start, step = kind & 0xFFFF, kind >> 16, at + 4, 8
        else:
            start, step = at + 8, 8 + size if kind == 15 else 8 + (size + 7) // 8 * 8
        yield kind, data[start:start + size]
        at += step


def arrays(data):
    """{name: (dimensions, numbers in the order of columns)}"""
    found = {}
    for kind, body in elements(data):
        if kind == 15:
            found.update(arrays(zlib.decompress(body)))
        elif kind == 14:
            _, shape, name, *numbers = elements(body)
            if numbers and numbers[0][0] in TYPES:
                of, raw = numbers[0]
                values = struct.unpack(f"<{len(raw) // struct.calcsize(TYPES[of])}{TYPES[of]}", raw)
                found[name[1].decode()] = (struct.unpack("<ii", shape[1][:8]), values)
    return found


def main(path, *names):
    with open(path, "rb") as file:
        all_of = arrays(file.read()[128:])
    columns = {}
    for name in names:
        (high, wide), values = all_of[name]
        for k in range(min(high, wide)):
            column = values[k * high:(k + 1) * high] if high > wide else values[k::high]
            columns[f"{name}{k + 1}"] = column
    print(",".join(columns))
    for row in zip(*columns.values()):
        print(",".join(f"{x:.12g}" for x in row))


main(*sys.argv[1:])
