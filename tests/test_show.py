"""Reports of cpinn-show, read as a browser reads them.

    test_show.py structure REPORT.html TABLE.csv   HTML, JSON, numbers: those of the table
    test_show.py wall REPORT.html WALL.obj         a wall of quads and triangles, in mm
    test_show.py residuals REPORT.html ROWS.csv    rows of test_show.sh: those of the file, and in closed form
    test_show.py looks REPORT.html                 in Chromium; 77: there is none
    test_show.py browser REPORT.html TABLE.csv [OTHER.html...]
                                                   the picture in Chromium; 77: there is none
"""

import base64
import csv
import fcntl
import html.parser
import json
import math
import os
import select
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import urllib.parse
import zlib

VOID = {"meta", "input", "br", "img", "link", "hr"}


class Page(html.parser.HTMLParser):
    """Elements have to be closed in turn; scripts are kept."""

    def __init__(self):
        super().__init__()
        self.open, self.texts, self.links, self.identifiers = [], {}, [], set()

    def handle_starttag(self, tag, attributes):
        about = dict(attributes)
        self.links += [about[key] for key in ("src", "href") if key in about]
        assert about.get("id") not in self.identifiers or "id" not in about, about
        self.identifiers.add(about.get("id"))
        if tag not in VOID:
            self.open.append((tag, about.get("type", "")))

    def handle_endtag(self, tag):
        assert self.open and self.open[-1][0] == tag, (tag, self.open)
        self.open.pop()

    def handle_data(self, data):
        if self.open:
            self.texts[self.open[-1]] = self.texts.get(self.open[-1], "") + data


def read_page(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    page = Page()
    page.feed(text)
    page.close()
    assert text.startswith("<!DOCTYPE html>") and not page.open, page.open
    assert not page.links, page.links  # self-contained
    assert "<!--" not in text.replace("<!DOCTYPE", ""), "a place was not filled"
    refuse = lambda word: sys.exit(f"{word} in JSON")
    return json.loads(page.texts["script", "application/json"], parse_constant=refuse), page


def read_table(path):
    with open(path) as file:
        rows = list(csv.DictReader(file))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def numbers(column, count):
    """The numbers of a column, and how far they may be rounded."""
    if "kind" not in column:
        return [column["value"]] * count, 0
    data = base64.b64decode(column["data"], validate=True)
    if column["kind"] == "f4":
        values = struct.unpack(f"<{count}f", data)
        return values, max(map(abs, values)) * 2.0**-24
    step = (column["high"] - column["low"]) / 65534
    return [column["low"] + (k + 32767) * step for k in struct.unpack(f"<{count}h", data)], step / 2


def structure(path, table):
    report, page = read_page(path)
    motion = report["motion"]
    count = motion["frames"] * motion["points"]
    assert count == len(table["s"]), "a table this small is kept as it is"
    assert {"title", "verdict", "picture", "legend", "charts"} <= page.identifiers
    for name, unit in (("x", "m"), ("n1", "N"), ("m2", "N m"), ("u2", "1/m"), ("qw", "")):
        column = next(c for c in motion["columns"] if c["name"] == name)
        found, rounding = numbers(column, count)
        assert column["unit"] == unit, column
        worst = max(abs(a - b) for a, b in zip(found, table[name]))
        assert worst <= 1.01 * rounding + 1e-300, (name, worst, rounding)
    for name in "xyz":  # the tip, to the last digit of a float
        column = next(c for c in motion["columns"] if c["name"] == name)
        tip = numbers(column, count)[0][motion["points"] - 1 :: motion["points"]]
        exact = table[name][motion["points"] - 1 :: motion["points"]]
        assert list(tip) == [struct.unpack("f", struct.pack("f", x))[0] for x in exact], name
    times = numbers(motion["t"][0], motion["frames"])[0] if "t" in motion else [0]
    assert all(abs(a - b) < 1e-6 for a, b in zip(times, table["t"][:: motion["points"]]))
    data = len(page.texts["script", "application/json"])
    room = 20_000 + 3 * 4 * 4 / 3 * count + 26 * 2 * 4 / 3 * count
    assert data < room, (data, room)
    assert os.path.getsize(path) < data + 100_000  # what shows it


def residuals(path, file):
    """Statistics, rows and poses as the file has them; places in the axes of the scene in closed form, to
    the last digit of a float; and shapes, to how places of pictures are rounded."""
    report, page = read_page(path)
    with open(file) as opened:
        rows = list(csv.DictReader(opened))
    of, single = report["residuals"], lambda x: struct.unpack("f", struct.pack("f", x))[0]
    known = lambda name: [float(row[name]) for row in rows]
    shown = {c["name"]: numbers(c, len(rows))[0] for c in of["columns"] + of["known"]}
    for name in ("pose", "marker", "s", "distance", "pull"):
        assert list(shown[name]) == [single(x) for x in known(name)], (name, shown[name])
    assert list(shown["pose"]) == [1, 1, 2, 2, 3, 3] and list(shown["marker"]) == 3 * [1, 2]
    for c in of["components"]:
        for found, x, y in zip(numbers(c, len(rows))[0], known(c["name"]), known(c["name"] + "_computed")):
            assert found == single(x - y) or math.isnan(found) and math.isnan(x), (c["name"], found, x - y)
    assert [e["judged"] for e in of["entries"]] == ["compared", "held_out"]
    for entry, first, end, whole in zip(of["entries"], (0, 4), (4, 6), (3, 2)):
        distance = sorted(known("distance")[i] for i in range(first, end) if rows[i]["y"] not in ("", "nan"))
        assert entry["rows"] == len(distance) == whole and entry["first"] == first and entry["end"] == end
        for name, value in (("mean", sum(distance) / whole), ("worst", distance[-1]),
                            ("median", (distance[(whole - 1) // 2] + distance[whole // 2]) / 2),
                            ("rms", math.sqrt(sum(d * d for d in distance) / whole))):
            assert abs(entry[name] - value) <= 1e-14 * value, (name, entry[name], value)
        assert known("distance")[entry["worst_row"]] == distance[-1]
    # a marker 10 mm beside an arc; its own solver is asked for 1e-8 of the length, 2e-9 m
    for i, row in enumerate(rows):
        s, k = float(row["s"]), float(row["pull"]) * 8 / 3
        model = ((1 - math.cos(k * s)) / k + 0.01 * math.cos(k * s), 0,
                 math.sin(k * s) / k - 0.01 * math.sin(k * s))
        measured = (model[0], 0, model[2] + (2e-3 if i == 5 else 0))
        for axis in range(3):
            found = [numbers(of["places"][axis + 3 * side], len(rows))[0][i] for side in (0, 1)]
            assert math.isnan(found[0]) or abs(found[0] - measured[axis]) < 2e-8, (i, axis, found, measured)
            assert math.isnan(found[1]) or abs(found[1] - model[axis]) < 3e-8, (i, axis, found, model)
    motion, frames = report["motion"], of["poses"]
    assert frames == [1, 2, 3] and motion["frames"] == 3
    places = {c["name"]: numbers(c, 3 * motion["points"]) for c in motion["columns"]}
    along = numbers(motion["s"][0], motion["points"])[0]
    for pose in range(3):
        for p, s in enumerate(along):
            k = 0.5 * (pose + 1) * 8 / 3
            for name, exact in (("x", (1 - math.cos(k * s)) / k), ("y", 0), ("z", math.sin(k * s) / k)):
                values, rounding = places[name]
                assert abs(values[pose * motion["points"] + p] - exact) < rounding + 2e-8, (pose, s, name)


def wall(path, file):
    """Its triangles, with corners to the last digit of a float, as those of the file."""
    report, _ = read_page(path)
    of = report["wall"]
    places = list(zip(*(numbers(c, of["corners"])[0] for c in of["places"])))
    corners = zip(*(numbers(c, of["triangles"])[0] for c in of["of"]))
    found = sorted(sorted(places[int(k)] for k in triangle) for triangle in corners)
    single = lambda x: struct.unpack("f", struct.pack("f", 1e-3 * float(x)))[0]
    lines = [line.split() for line in open(file)]
    known = [tuple(single(x) for x in words[1:]) for words in lines if words[0] == "v"]
    faces = [[int(k) - 1 for k in words[1:]] for words in lines if words[0] == "f"]
    assert found == sorted(sorted(known[k] for k in (face[0], face[i], face[i + 1]))
                           for face in faces for i in range(1, len(face) - 1))


# ---- the picture -------------------------------------------------------------------------------


class Browser:
    """Chromium, told what to do through a pipe (its DevTools protocol)."""

    def __init__(self):
        found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser",
                                                     "google-chrome"))), None)
        if not found:
            print("skipped: no Chromium")
            sys.exit(77)
        self.home = tempfile.mkdtemp()
        theirs, self.to = os.pipe()
        self.answers, ours = os.pipe()
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 20) for end in (theirs, ours)]
        command = [found, "--headless=new", "--no-sandbox", "--enable-unsafe-swiftshader",
                   "--hide-scrollbars", "--no-first-run", "--disable-dev-shm-usage",
                   "--remote-debugging-pipe",
                   f"--user-data-dir={self.home}"]
        self.process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, close_fds=False,
            preexec_fn=lambda: (os.dup2(ends[0], 3), os.dup2(ends[1], 4)))
        for end in (theirs, ours, *ends):
            os.close(end)
        self.calls, self.rest, self.said, self.session = 0, b"", [], None
        targets = self.call("Target.getTargets")["targetInfos"]
        page = next(target for target in targets if target["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=page["targetId"],
                                 flatten=True)["sessionId"]
        for part in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{part}.enable")

    def close(self):
        self.session = None
        self.call("Browser.close")
        self.process.wait(30)
        shutil.rmtree(self.home, ignore_errors=True)

    def call(self, method, **parameters):
        self.calls += 1
        message = {"id": self.calls, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.read()
            if answer.get("id") == self.calls:
                assert "error" not in answer, answer
                return answer["result"]
            self.said.append(answer)

    def read(self):
        while b"\0" not in self.rest:
            ready, _, _ = select.select([self.answers], [], [], 60)
            part = os.read(self.answers, 1 << 20) if ready else b""
            if not part:
                print("skipped: Chromium does not start" if not self.session else "no answer")
                sys.exit(77 if not self.session else 1)
            self.rest += part
        answer, self.rest = self.rest.split(b"\0", 1)
        return json.loads(answer)

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def wait(self, expression):
        for _ in range(600):
            if self.evaluate(expression):
                return
            time.sleep(0.05)
        sys.exit(f"never: {expression}")

    def open(self, path, asked="", width=1000, height=800):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=False)
        self.call("Page.navigate", url="about:blank")
        self.said = []
        self.call("Page.navigate", url=f"file://{urllib.parse.quote(os.path.abspath(path))}#{asked}")
        self.wait("document.body && document.body.dataset.ready === 'yes'")

    def press(self, key):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key)

    def screenshot(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.call("Page.captureScreenshot")["data"]))

    def wrong(self):
        """What the page threw or said of errors; software that draws is remarked on."""
        return [m["params"] for m in self.said if m.get("method") == "Runtime.exceptionThrown"
                or m.get("method") == "Log.entryAdded" and m["params"]["entry"]["level"] == "error"]


def read_png(path):
    """Rows of bytes, and how many of them a pixel has."""
    with open(path, "rb") as file:
        data = file.read()
    width, height, depth, kind = struct.unpack(">IIBB", data[16:26])
    size = {2: 3, 6: 4}[kind]
    assert depth == 8
    packed, at = b"", 8
    while at < len(data):
        length, name = struct.unpack(">I4s", data[at : at + 8])
        packed += data[at + 8 : at + 8 + length] if name == b"IDAT" else b""
        at += 12 + length
    raw, rows, above = zlib.decompress(packed), [], bytes(width * size)
    for y in range(height):
        first = y * (width * size + 1)
        way, row = raw[first], bytearray(raw[first + 1 : first + 1 + width * size])
        for i in range(len(row)):
            left = row[i - size] if i >= size else 0
            corner = above[i - size] if i >= size else 0
            if way == 1:
                row[i] = (row[i] + left) & 255
            elif way == 2:
                row[i] = (row[i] + above[i]) & 255
            elif way == 3:
                row[i] = (row[i] + (left + above[i]) // 2) & 255
            elif way == 4:
                guess = left + above[i] - corner
                order = [(abs(guess - v), k) for k, v in enumerate((left, above[i], corner))]
                row[i] = (row[i] + (left, above[i], corner)[min(order)[1]]) & 255
        rows.append(row)
        above = row
    return rows, size


def project(camera, place):
    """A pinhole camera, written apart from that of the page: pixels of the page."""
    right, up, back = camera["axes"]
    part = [sum((p - t) * a for p, t, a in zip(place, camera["target"], axis))
            for axis in (right, up, back)]
    scale = camera["height"] / 2 / camera["lens"] / (camera["distance"] - part[2])
    return (camera["left"] + camera["width"] / 2 + part[0] * scale,
            camera["top"] + camera["height"] / 2 - part[1] * scale)


def picture(browser, path, table, way):
    """The rod alone, in one colour at the last instant: where its pixels are."""
    asked = "colour=plain&hide=path,floor,reference,loads&theme=light&size=600x400"
    asked += f"&time={table['t'][-1]}" + ("&canvas=1" if way == "canvas" else "")
    browser.open(path, asked, 700, 620)
    said = browser.evaluate("({...document.body.dataset})")
    camera = json.loads(said["camera"])
    assert (camera["width"], camera["height"]) == (600, 400), camera
    assert said["renderer"] in (way, "canvas"), said
    with tempfile.TemporaryDirectory() as folder:
        image = os.path.join(folder, "picture.png")
        browser.screenshot(image)
        rows, size = read_png(image)
    assert (len(rows[0]) // size, len(rows)) == (700, 620)
    left, top = camera["left"], camera["top"]
    blue = [(x, y) for y in range(math.ceil(top), min(620, math.floor(top + camera["height"])))
            for x in range(math.ceil(left), math.floor(left + camera["width"]))
            if rows[y][size * x + 2] - rows[y][size * x] > 60
            and not (x < left + 100 and y > top + camera["height"] - 100)]  # the axes
    last = [i for i, t in enumerate(table["t"]) if t == table["t"][-1]]
    seen = [project(camera, [table[name][i] for name in "xyz"]) for i in last]
    radius = 0.006 * camera["height"] / camera["lens"]  # a generous one, of the drawn rod
    low = [min(p[k] for p in seen) for k in (0, 1)]
    high = [max(p[k] for p in seen) for k in (0, 1)]
    for k in (0, 1):
        drawn = min(p[k] for p in blue), max(p[k] for p in blue)
        # the plate that holds the rod hides its beginning
        assert abs(drawn[0] - low[k]) < radius + 8 and abs(drawn[1] - high[k]) < radius + 8, (
            way, k, drawn, low, high)
    assert max(high[0] - low[0], high[1] - low[1]) > 0.25 * camera["height"], (low, high)
    tip = seen[-1]
    assert any(math.hypot(x - tip[0], y - tip[1]) < 6 for x, y in blue), tip
    print(f"{said['renderer']}: {len(blue)} pixels of the rod, its tip at {tip[0]:.0f}, {tip[1]:.0f}")


def colours(browser, left, top, width, height):
    """How many different ones a part of the page has."""
    with tempfile.TemporaryDirectory() as folder:
        image = os.path.join(folder, "picture.png")
        browser.screenshot(image)
        rows, size = read_png(image)
    return len({bytes(rows[y][size * x : size * x + size]) for y in range(top, top + height, 2)
                for x in range(left, left + width, 2)})


def words_of_numbers(browser):
    """Numbers with the prefix of the largest on their axis, however small; what rounding leaves is 0."""
    minus = "\u2212"
    for call, wanted in [("withUnit(4.4e-16, 'N')", "0 N"), ("withUnit(4.4e-12, 'N')", "4.4 pN"),
                         ("withUnit(-0.0125, 'm')", minus + "12.5 mm"), ("withUnit(0, 'm')", "0 m"),
                         ("withUnit(2.5e-13, 'rad')", "2.50e" + minus + "13"),
                         ("tickText(0.30000000000000004, 0.1)", "0.3"), ("tickText(-0, 0.1)", "0"),
                         ("tickText(-2, 0.5)", minus + "2.0"), ("tickText(400, 200)", "400"),
                         ("tickText(3e-17, 1e-17)", "3.0e" + minus + "17")]:
        found = browser.evaluate(call)
        assert found.replace(" rad", "") == wanted, (call, found, wanted)
    drawn = """(() => { const box = element("div", {}, document.body);
        new Chart(box, { title: "", x: "s", xUnit: "m", yUnit: "N", series: [{ name: "", count: 2,
            x: i => 2e-11 * i, y: i => SIZE * i }] });
        const all = [...box.querySelectorAll("text")].map(x => x.textContent).join(" ");
        box.remove(); return all; })()"""
    for size in "1e-3", "3e-10", "2e-12", "1e-17", "0":
        found = browser.evaluate(drawn.replace("SIZE", size))
        assert "e" not in found and "pm" in found, (size, found)


def moves(browser, path):
    """Shapes that the page computes: a slider moves the rod, nobody is asked through the network, and
    members all over the ranges are where cpinn has found them."""
    tip = "[...document.querySelectorAll('#answer em')][0].textContent"
    before = browser.evaluate(tip)
    browser.evaluate("""(() => { const one = document.querySelector('.slider input');
        one.value = one.value > 0.5 ? 0.2 : 0.8; one.oninput(); })()""")
    assert browser.evaluate(tip) != before, (path, before)
    place = browser.evaluate("sliders.live.answer.tip.map(x => digits(x * sliders.charts[0].yScale.factor))")
    shown = browser.evaluate("[...sliders.charts[0].keys.querySelectorAll('b')].map(x => x.textContent)")
    assert shown == place, (path, shown, place)  # the chart says what the answer does
    near = browser.evaluate("[sliders.live.compared, sliders.live.off / report.live.length]")
    assert near[0] > 100 and near[1] < 1e-6, (path, near)
    asked = [m["params"]["request"]["url"] for m in browser.said
             if m.get("method") == "Network.requestWillBeSent"]
    assert all(url.startswith(("file:", "about:")) for url in asked) and asked, (path, asked)
    pace = browser.evaluate("sliders.pace")
    print(f"{path}: {os.path.getsize(path) / 1e3:.0f} kB, {pace:.0f} us a shape, tips of "
          f"{near[0]} members off by {near[1]:.1e} of the length")


def drags(browser, path):
    """The tip to the tips of members that cpinn has found, from the middle of all sliders: 1e-6 of the
    length is how near the page is to cpinn. Then to lines of sight through them, from nearby, since a line
    may meet all that is reachable twice, or pass it; by the mouse, which is
    on a pixel; and to where no tip is."""
    found = browser.evaluate("""(() => { const live = sliders.live, all = live.data.parameters;
        const tips = new Float64Array(bytesOf(live.data.tips).buffer), row = all.length + 3;
        const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], moves = all.map(() => true);
        const middle = () => { live.values = all.map(p => live.valueAt(p, 0.5)); };
        const slow = [], eye = sliders.player.picture.camera.placeOf([0, 0, 0]);
        let far = 0, besides = 0, count = 0, other = 0;
        for (let i = 0; i < live.data.members; i++) {
            const tip = tips.subarray(i * row + all.length, (i + 1) * row);
            if (!Number.isFinite(tip[0])) continue;
            middle();
            const start = performance.now();
            live.reach(tip, axes, moves);
            slow.push(performance.now() - start);
            far = Math.max(far, live.reach(tip, axes, moves) / live.data.length);
            all.forEach((p, k) => { other = Math.max(other,
                Math.abs(live.partOf(p, live.values[k]) - live.partOf(p, tips[i * row + k]))); });
            live.values = all.map((p, k) => live.valueAt(p, 0.05 + 0.9 * live.partOf(p, tips[i * row + k])));
            sliders.drag(eye, tip);
            besides = Math.max(besides, sliders.left / live.data.length);
            count++;
        }
        middle();
        sliders.change();
        return [count, far, besides, other, slow.sort((a, b) => a - b)[slow.length >> 1]]; })()""")
    assert found[0] > 100 and max(found[1:3]) <= 1e-6, (path, found)
    at, to, box, size = browser.evaluate("""(() => { const live = sliders.live, row = live.data.parameters.length + 3;
        const tips = new Float64Array(bytesOf(live.data.tips).buffer), camera = sliders.player.picture.camera;
        const box = byId('labels').getBoundingClientRect();
        return [camera.project(live.answer.tip), camera.project(tips.subarray(2 * row - 3, 2 * row)),
            [box.left, box.top], camera.distance / camera.height]; })()""")
    for kind, place in (("mousePressed", at), ("mouseMoved", to), ("mouseReleased", to)):
        browser.call("Input.dispatchMouseEvent", type=kind, x=box[0] + place[0], y=box[1] + place[1],
                     button="left", buttons=int(kind != "mouseReleased"), clickCount=1)
    left, now, said = browser.evaluate("""[sliders.left,
        sliders.player.picture.camera.project(sliders.live.answer.tip), byId('answer').textContent]""")
    assert math.hypot(now[0] - to[0], now[1] - to[1]) < 2, (path, at, to, now, left)
    assert left < size, (path, left, size)  # about a pixel
    browser.evaluate("sliders.drag([10, 0, 10], [10, 0, 0])")  # down a line
    far, said = browser.evaluate("""[[sliders.left, Math.hypot(sliders.live.answer.tip[0] - 10,
        sliders.live.answer.tip[1])], byId('answer').textContent]""")
    assert abs(far[0] - far[1]) < 1e-9 and far[0] > 9 and "Not reached" in said, (path, far, said)
    held = browser.evaluate("""(() => { sliders.rows.forEach(row => { row.ticked.checked = false; });
        const before = sliders.live.values.slice(); sliders.drag([0, 0, 10], [0, 0, 0]);
        return sliders.live.values.every((x, k) => x === before[k]); })()""")
    assert held, path
    print(f"{path}: dragged to {found[0]} tips, off by {found[1]:.1e} and {found[2]:.1e} of the length, "
          f"parameters by {found[3]:.1e} of their ranges, {found[4]:.2f} ms each")


def chooses(browser, path):
    """Rows of test_show.sh: the page begins with the largest, a file and a row are chosen by a click."""
    words = lambda id: browser.evaluate(f"byId('{id}').textContent")
    assert "Largest: 2 mm at pose 3" in words("files"), words("files")
    assert "marker 2, s = 200 mm: off by 2 mm (" in words("answer") and "pose 3" in words("now")
    assert browser.evaluate("byId('answer').textContent === byId('picture').getAttribute('aria-label')")
    cells = browser.evaluate("[...document.querySelectorAll('#files tbody tr')[1].cells].map(x => x.textContent)")
    assert cells[2:6] == ["2", "1.414 mm", "1 mm", "1 mm"], cells
    assert browser.evaluate("residuals.size(NaN, 'm')") == "\u2013"  # where there is no solution
    browser.evaluate("document.querySelectorAll('#files tbody tr')[0].click()")
    assert browser.evaluate("[byId('time').min, byId('time').max]") == ["0", "1"], "poses of that file"
    dots = browser.evaluate("residuals.charts[0].about.series.map(one => one.count)")
    assert dots == [2, 2] or dots == [1, 2], dots  # of each marker; one has a coordinate less
    browser.evaluate("""(() => { const chart = residuals.charts[0], one = chart.about.series[0];
        const box = chart.svg.getBoundingClientRect(), scale = box.width / chart.width;
        chart.svg.dispatchEvent(new MouseEvent("click", {
            clientX: box.left + scale * chart.toX(one.x(0)) + 2,
            clientY: box.top + scale * chart.toY(one.y(0)) - 2 })); })()""")
    assert "pose 1:" in words("now") and "pull = 0.5" in words("answer"), words("now")


def looks(browser, path, kind):
    """A page of any kind: it is drawn, plays at the space key, fits a telephone, without errors."""
    browser.open(path)
    frames = browser.evaluate("report.live ? 1 : report.motion ? report.motion.frames : 0")
    if browser.evaluate("!!report.live"):
        moves(browser, path)
        drags(browser, path)
    if frames:
        box = browser.evaluate("(() => { const b = byId('stage').getBoundingClientRect();"
                               "return [b.left, b.top, b.width, b.height].map(Math.floor) })()")
        found = colours(browser, box[0] + 8, box[1] + 8, box[2] - 16, min(box[3], 780 - box[1]) - 16)
        assert found > 200, (path, found, "a sky alone has fewer")  # shaded, and with a map of colours
    if browser.evaluate("!!report.residuals"):
        chooses(browser, path)
    if browser.evaluate("!!report.loop"):
        titles = browser.evaluate("[...document.querySelectorAll('.chart h2')].map(x => x.textContent)")
        for title in ["Distance", "Inputs", "Estimate of stiffness", "Time that a period takes"]:
            assert title in titles, (path, titles)
    if frames > 1:
        before = browser.evaluate("byId('now').textContent")
        browser.press(" ")
        browser.wait(f"byId('now').textContent != {json.dumps(before)}")
        browser.press(" ")
        time.sleep(0.3)  # for what is under way
        drawn = browser.evaluate("document.body.dataset.drawn")
        time.sleep(0.3)
        assert browser.evaluate("document.body.dataset.drawn") == drawn, "it stops"
    charts = browser.evaluate("document.querySelectorAll('.chart path.curve').length")
    tables = browser.evaluate("document.querySelectorAll('td').length")
    assert charts + tables > 0, path
    names = "[...document.querySelectorAll('summary')].map(x => x.textContent).join()"
    if frames > 1:
        of = browser.evaluate("report.residuals ? 'The largest residuals' : report.motion.t ? "
                              "'The tip over time' : 'The tips of all members'")
        assert of in browser.evaluate(names), (path, of)
    numbers = "[...document.querySelectorAll('.chart text')]"
    cut = f"{numbers}.filter(x => x.getBBox().x < 0).map(x => x.textContent).join()"
    assert browser.evaluate(cut) == "", (path, browser.evaluate(cut))
    browser.open(path, "theme=dark", 400, 800)
    assert browser.evaluate("document.documentElement.scrollWidth") <= 400, path
    assert not browser.wrong(), (path, browser.wrong())
    print(f"{kind}: {frames} instants or members, {charts} curves, {tables} cells")


if __name__ == "__main__":
    if sys.argv[1] == "browser":
        chromium = Browser()
        rows = read_table(sys.argv[3])
        for renderer in ("webgl2", "canvas"):
            picture(chromium, sys.argv[2], rows, renderer)
        words_of_numbers(chromium)
        for page in sys.argv[4:]:
            looks(chromium, page, os.path.basename(page))
        chromium.close()
    elif sys.argv[1] == "looks":
        chromium = Browser()
        looks(chromium, sys.argv[2], os.path.basename(sys.argv[2]))
        chromium.close()
    elif sys.argv[1] == "residuals":
        residuals(sys.argv[2], sys.argv[3])
    elif sys.argv[1] == "wall":
        wall(sys.argv[2], sys.argv[3])
    else:
        structure(sys.argv[2], read_table(sys.argv[3]))
