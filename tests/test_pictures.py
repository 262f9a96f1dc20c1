"""Pictures of cpinn-show, decoded.

    test_pictures.py file FILE WIDTH HEIGHT    a whole PNG
    test_pictures.py png FILE WIDTH HEIGHT     and something is drawn in it
    test_pictures.py gif FILE WIDTH HEIGHT IMAGES HUNDREDTHS
    test_pictures.py svg FILE [TABLE.csv [WORDS...]]   the tip is that of the table, the words are written
"""

import csv
import re
import struct
import sys
import xml.etree.ElementTree
import zlib


def looks_drawn(rows):
    """Rows of (r, g, b): white above all, and something in its middle; shades, not a few colours."""
    pixels = [p for row in rows for p in row]
    white = sum(p == (255, 255, 255) for p in pixels) / len(pixels)
    assert 0.3 < white < 0.99, white
    height, width = len(rows), len(rows[0])
    middle = [p for row in rows[height // 5:height * 4 // 5] for p in row[width // 5:width * 4 // 5]]
    dark = sum(sum(p) < 500 for p in middle) / len(middle)
    assert dark > 0.002, dark
    assert len(set(pixels)) > 60, len(set(pixels))


def whole(path, width, height):
    """The filtered rows of a PNG."""
    data = open(path, "rb").read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and len(data) < 200_000, len(data)
    at, packed, kinds = 8, b"", []
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        assert struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0] == zlib.crc32(kind + body)
        kinds.append(kind)
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
        if kind == b"IHDR":
            assert struct.unpack(">IIBBBBB", body) == (int(width), int(height), 8, 2, 0, 0, 0)
    assert kinds == [b"IHDR", b"IDAT", b"IEND"], kinds
    raw = zlib.decompress(packed)
    assert len(raw) == (3 * int(width) + 1) * int(height), len(raw)
    return raw


def png(path, width, height):
    raw, row_bytes = whole(path, width, height), 3 * int(width)
    above, rows = bytes(row_bytes), []
    for y in range(int(height)):
        start = y * (row_bytes + 1)
        filter_kind, row = raw[start], bytearray(raw[start + 1:start + 1 + row_bytes])
        for i in range(row_bytes):
            a, c = (row[i - 3], above[i - 3]) if i >= 3 else (0, 0)
            b = above[i]
            if filter_kind == 4:
                p = a + b - c
                guess = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            else:
                guess = (0, a, b, (a + b) // 2)[filter_kind]
            row[i] = (row[i] + guess) & 255
        above = bytes(row)
        rows.append(list(zip(above[::3], above[1::3], above[2::3])))
    looks_drawn(rows)


def gif(path, width, height, images, hundredths):
    """Its size, how many images it has, and how long each stays."""
    data, count = open(path, "rb").read(), 0
    assert data[:6] == b"GIF89a" and struct.unpack("<HH", data[6:10]) == (int(width), int(height))

    def after_colours(at, flags):
        return at + (3 << (flags & 7) + 1 if flags & 0x80 else 0)

    at = after_colours(13, data[10])
    while data[at] != 0x3B:
        if data[at] == 0x21:
            if data[at + 1] == 0xF9:
                assert struct.unpack("<H", data[at + 4:at + 6])[0] == int(hundredths)
            at += 2
        else:
            assert data[at] == 0x2C
            at, count = after_colours(at + 10, data[at + 9]) + 1, count + 1
        while data[at]:
            at += 1 + data[at]
        at += 1
    assert count == int(images), count


def svg(path, table=None, *words):
    root = xml.etree.ElementTree.parse(path).getroot()
    space = "{http://www.w3.org/2000/svg}"
    assert root.tag == space + "svg" and root.get("viewBox") == "0 0 960 640", root.attrib
    texts = ["".join(t.itertext()) for t in root.iter(space + "text")]
    faces = [p for p in root.iter(space + "path") if re.match("#[0-9a-f]{6}$", p.get("fill") or "")]
    assert len(faces) > 50, len(faces)
    inside = 0
    for face in faces[1:]:  # the first is the shadow
        x, y = map(int, re.match(r"M(-?\d+) ?(-?\d+)l", face.get("d")).groups())
        inside += 0 <= x <= 9600 and 0 <= y <= 6400
    assert inside > 0.98 * len(faces[1:]), (inside, len(faces))
    for word in words:
        assert word in texts, (word, texts)
    if table:
        tip = list(csv.DictReader(open(table)))[-1]
        wanted = "tip (" + ", ".join("%.1f" % (1e3 * float(tip[k])) for k in "xyz") + ") mm"
        assert wanted in texts, (wanted, texts)


{"file": whole, "png": png, "gif": gif, "svg": svg}[sys.argv[1]](*sys.argv[2:])
