#!/usr/bin/env python3
"""usage: cpinn-picture PAGE.html --out FILE [options]

Draw the shapes of a page that cpinn-show wrote, as a picture or as a movie. cpinn-show SOURCE --out
NAME.png does both at once. A picture shows several instants from pale to dark, or several members of
a family, above a floor with shadows; with the path of the tip, tendons, chambers, loads and the
surface around them. It needs numpy, and a movie needs ffmpeg.

options:
  --out FILE            NAME.svg, .png: a picture; NAME.gif, .mp4, .webm: a movie, by ffmpeg
  --slow X              a movie takes this many times as long as the motion (default 1)
  --quiet               print only errors
  --help                this text
  --version             the version

  cpinn-picture runs/soft_arm/report.html --out arm.png
  cpinn-picture motion.html --out motion.mp4 --slow 5

Pages of which the browser computes the shapes have none; cpinn-show FAMILY --out NAME.png has some
members. A dash instead of PAGE.html takes the data of a page from standard input.

Exit status: 0; 1 the file cannot be written; 2 with one line that says what is wrong with the input;
130 or 143 stopped by a signal.
"""
import base64
import tempfile

PROGRAM, VERSION = "cpinn-picture", "@PROJECT_VERSION@"

@RUNS@
@SOLIDS@

SIZES = {".svg": (960, 640), ".png": (960, 640), ".gif": (720, 480), ".mp4": (1280, 720), ".webm": (1280, 720)}
RATES = {".gif": 20, ".mp4": 30, ".webm": 30}  # images a second
# The colours of a .gif are those of each image, so that the encoder need not keep all of them.
ENCODERS = {
    ".mp4": ["-pix_fmt", "yuv420p", "-c:v", "libx264", "-crf", "20", "-f", "mp4"],
    ".webm": ["-pix_fmt", "yuv420p", "-c:v", "libvpx-vp9", "-crf", "30", "-f", "webm"],
    ".gif": ["-filter_complex", "split[a][b];[a]palettegen=stats_mode=single[c];"
             "[b][c]paletteuse=new=1:dither=none", "-loop", "0", "-f", "gif"]}
MEMBERS_SECONDS, GIF_SECONDS, MOVIE_SECONDS = 8, 50, 30_000

TIMES = ["c3d7ee", "7fb0dd", "2f7fc1", "0b4f8a"]
KINDS = ["3b4cc0", "2c8fbd", "27a684", "7fb93c", "e3b022", "e2711d", "b8232f"]
SHADES = ["440154", "3b528b", "21918c", "5ec962", "fde725"]
NEARNESS = ["b8232f", "e2711d", "e3b022", "7fb93c", "27a684", "2c8fbd"]
METALS = ["d8a23a", "c96f4a", "7aa870"]
STRENGTHS = {"tendon": ["d9c7a8", "e8590c"], "chamber": ["9fc4d8", "e8590c"]}
INK, SOFT, TRAIL, WANTED, GLASS, STEEL, BODY = ("343a46", "79838f", "d6336c", "37b24d", "8a97a8", "565e69",
                                                "4a505a")
ARROW = 0.15  # of loads, by the size of all shapes
DISCS = 10


def column(data, rows):
    """Numbers of a page, see tools/programs/show.h."""
    if "value" in data:
        return numpy.full(rows, math.nan if data["value"] is None else data["value"], float)
    packed = base64.b64decode(data["data"])
    if data["kind"] == "f4":
        return numpy.frombuffer(packed, "<f4").astype(float)
    numbers = numpy.frombuffer(packed, "<i2").astype(float)
    values = data["low"] + (data["high"] - data["low"]) * (numbers + 32767) / 65534
    return numpy.where(numbers == -32768, math.nan, values)


def round125(size):
    power = 10**math.floor(math.log10(size))
    digit = size / power
    return power * (1 if digit < 1.5 else 2 if digit < 3.5 else 5 if digit < 7.5 else 10)


def with_unit(value, unit_):
    """"12.5 mm" of 0.0125 and "m"."""
    rows = [("G", 1e9), ("M", 1e6), ("k", 1e3), ("", 1), ("m", 1e-3), ("\u00b5", 1e-6), ("n", 1e-9),
            ("p", 1e-12), ("f", 1e-15)]
    if abs(value) < rows[-1][1]:
        return f"0 {unit_}"  # what rounding leaves
    prefix, factor = next((row for row in rows[3 if unit_ in ("m", "s") else 0:]  # no kilometres
                           if abs(value) >= 0.9999 * row[1]), rows[-1])
    return f"{value / factor:.3g} {prefix}{unit_}"


class Shapes:
    """Of a motion of a page: at most so many points along each shape."""

    def __init__(self, data, most):
        rows, points = data["frames"] * data["points"], data["points"]
        self.frames = data["frames"]
        keep = [round(k) for k in numpy.linspace(0, points - 1, most)] if points > most else list(range(points))
        columns = {c["name"]: column(c, rows).reshape(-1, points)[:, keep] for c in data["columns"]}
        self.kept, self.s = keep, column(data["s"][0], points)[keep]
        self.t = column(data["t"][0], self.frames) if "t" in data else None
        self.labels, self.enlarged, self.quaternions = data.get("labels"), 1, None
        self.left, self.radius = columns.get("left"), columns.get("radius")
        if all(name in columns for name in "xyz"):
            self.places = numpy.stack([columns[name] for name in "xyz"], 2)
            if all("q" + name in columns for name in "wxyz"):
                self.quaternions = numpy.stack([columns["q" + name] for name in "wxyz"], 2)
        elif "w" in columns:  # a beam along x
            w, length = columns["w"], numpy.ptp(self.s)
            most = numpy.nanmax(abs(w), initial=0)
            self.enlarged = round125(0.2 * length / most) if 0 < most < 0.1 * length else 1
            self.places = numpy.stack([numpy.broadcast_to(self.s, w.shape), 0 * w, self.enlarged * w], 2)
        else:
            fail(f"{source}: there are no columns x, y, z to be drawn")
        known = self.places[numpy.isfinite(self.places).all(2)]
        if not (len(known) and numpy.ptp(known, axis=0).max() > 0):
            fail(f"{source}: there is no shape of any size to be drawn")
        self.low, self.high = known.min(0), known.max(0)
        self.size = numpy.linalg.norm(self.high - self.low)

    def at(self, values, frame):
        """Of a motion also between two frames."""
        first = min(int(frame), self.frames - 1)
        following = min(first + 1, self.frames - 1)
        part = frame - first if self.t is not None else 0
        return values[first] + part * (values[following] - values[first]) if part else values[first]

    def directors(self, frame):
        if self.quaternions is None:
            return frames_along(self.at(self.places, frame))
        first = min(int(frame), self.frames - 1)
        a, b = self.quaternions[first], self.quaternions[min(first + 1, self.frames - 1)]
        part = frame - first if self.t is not None else 0
        q = (1 - part) * a + part * numpy.where((a * b).sum(1, keepdims=True) < 0, -b, b)
        w, x, y, z = unit(q).T
        return 2 * numpy.stack([
            numpy.stack([0.5 - y * y - z * z, x * y + w * z, x * z - w * y], 1),
            numpy.stack([x * y - w * z, 0.5 - x * x - z * z, y * z + w * x], 1),
            numpy.stack([x * z + w * y, y * z - w * x, 0.5 - x * x - y * y], 1)], 1)


class Robot:
    """Shapes in their scene, where the page has one."""

    def __init__(self, data, most):
        self.x = shapes = Shapes(data["motion"], most)
        points = data["motion"]["points"]
        scene = self.scene = data.get("scene")
        rows = (lambda of: column(of, shapes.frames)) if scene else None
        half = scene and numpy.stack([column(h, points)[shapes.kept] for h in scene["half"]], 1)
        thickest = half.max() if scene else 0 if shapes.radius is None else shapes.radius[0, 0]
        self.thicker = max(1, 0.0065 * shapes.size / thickest) if thickest > 0 else 1
        self.radius = thickest * self.thicker if thickest > 0 else 0.012 * shapes.size
        self.half = numpy.full((len(shapes.s), 2), self.radius)
        if scene:
            self.half = numpy.where(half > 0, self.thicker * half, self.radius)
        drawn = scene if scene and shapes.enlarged == 1 and "w" not in [
            c["name"] for c in data["motion"]["columns"]] else {}
        self.ends = [drawn.get("start"), drawn.get("end")]
        self.bodies = drawn.get("bodies", [])
        self.tubes = [(one["end"], self.thicker * column(one["radius"][0], points)[shapes.kept])
                      for one in (scene or {}).get("tubes", [])]
        self.loads = [(one["s"], one["frame"], one["unit"], numpy.stack([rows(v) for v in one["vector"]], 1))
                      for one in drawn.get("arrows", []) if one["name"] in ("tip", "point")]
        self.guided = [(one["kind"], one["start"], one["end"], one["acts"][0]["unit"], rows(one["acts"][0]),
                        numpy.stack([column(o, points)[shapes.kept] for o in one["offset"]], 1))
                       for one in drawn.get("guided", [])]
        guides = max([math.hypot(*g[5][0]) for g in self.guided if g[0] == "tendon"], default=0)
        self.guides = guides if guides > self.radius else 0  # from the axis to the furthest tendon
        loaded = self.loads and shapes.t is None and shapes.frames > 1
        self.room = max(0.8 * ARROW * shapes.size if loaded else self.radius, 1.3 * self.guides)
        gravity = numpy.array([g or 0 for g in scene["gravity"]]) if scene else numpy.zeros(3)
        flat = numpy.ptp([shapes.low[2], shapes.high[2]]) < 1e-6 * shapes.size
        self.up = -unit(gravity) if gravity.any() else numpy.eye(3)[1 if flat else 2]

    def at(self, places, directors, s):
        """Place and directors at an arc length."""
        arc = self.x.s
        k = max(0, min(int(numpy.searchsorted(arc[1:], s)), len(arc) - 2))
        if len(arc) < 2:
            return places[0], directors[0]
        part = min(1, max(0, (s - arc[k]) / (arc[k + 1] - arc[k])))
        return places[k] + part * (places[k + 1] - places[k]), directors[k + (part > 0.5)]

    def draw(self, p, frame, colour, opacity, ends, sides):
        shapes = self.x
        places = shapes.at(shapes.places, frame)
        if len(places) == 1:
            p.ball(places[0], 0.02 * shapes.size, colour)
            return
        directors = shapes.directors(frame)
        self.draw_rod(p, frame, places, directors, colour, opacity, ends, sides)
        if not ends:
            return

        def plate(at, sign, radius, thick, paint):
            place, frame_ = at
            first, last = (-1, 0) if sign < 0 else (0, 1) if sign > 0 else (-0.5, 0.5)
            p.tube(place + numpy.outer((first * thick, last * thick), frame_[2]), numpy.array([frame_] * 2),
                   numpy.full((2, 2), radius), 2 * sides, paint)

        for type_, k, sign in (self.ends[0], 0, -1), (self.ends[1], -1, 1):
            half = self.half[k].max()
            if type_ in ("pinned", "roller"):
                p.ball(places[k], 1.6 * half, rgb(STEEL))
            elif type_ in ("clamped", "driven", "guided"):
                wide = max(1.35 * self.guides, min(1.7 * half, half + 0.05 * shapes.size))
                plate((places[k], directors[k]), sign, wide, 0.028 * shapes.size, rgb(STEEL))
        for body in self.bodies:
            p.ball(self.at(places, directors, body["s"])[0], body["radius"], rgb(BODY))
        for i in range(1, DISCS + 1 if self.guides else 0):  # which guide tendons that run outside of the rod
            plate(self.at(places, directors, self.scene["length"] * i / DISCS), -(i == DISCS), 1.22 * self.guides,
                  0.011 * shapes.size, 0.7 * rgb("cdd3db") + 0.3 * colour)
        strongest = {kind: max([shapes.at(g[4], frame) for g in self.guided if g[0] == kind], default=0)
                     for kind in STRENGTHS}
        for kind, start, end, _, acts, offset in self.guided:
            line = []
            for s in (start, *shapes.s[(shapes.s > start) & (shapes.s < end)], end):
                place, frame_ = self.at(places, directors, s)
                line.append(place + sum(numpy.interp(s, shapes.s, offset[:, k]) * frame_[k] for k in (0, 1)))
            part = 0.15 + 0.85 * max(shapes.at(acts, frame), 0) / strongest[kind] if strongest[kind] > 0 else 0.6
            p.thread(line, 0.24 * self.radius if kind == "chamber" else 0.0034 * shapes.size,
                     between(STRENGTHS[kind], part))
        for s, follows, unit_, vectors in self.loads:
            vector = shapes.at(vectors, frame)
            size = numpy.linalg.norm(vector)
            if not size > 0:
                continue
            place, frame_ = self.at(places, directors, s)
            vector = ARROW * shapes.size / size * (vector @ frame_ if follows == "follower" else vector)
            paint = rgb("7a4fb0" if unit_ == "N m" else "c92a2a")
            p.arrow(place, vector, 0.005 * shapes.size, 2 if unit_ == "N m" else 1, paint)
            if shapes.t is not None or shapes.frames == 1:  # many would be in each other's way
                x, y, _ = p.project(place + vector)
                p.text(x + 8, y - 6, 15, "start", paint, with_unit(size, unit_))

    def draw_rod(self, p, frame, places, directors, colour, opacity, ends, sides):
        shapes = self.x
        rectangle = bool(self.scene) and self.scene["section"] == "rectangle"
        inside = ends and any(g[0] == "chamber" or not self.guides for g in self.guided)
        if inside:
            colour, opacity = 0.55 * colour + 0.45, 0.34
        if shapes.left is not None:  # each piece by how far it is from a wall
            left = shapes.at(shapes.left, frame)
            wide = numpy.nanmax(shapes.left) - numpy.nanmin(shapes.left)
            for k in range(len(places) - 1):
                part = (min(left[k:k + 2]) - numpy.nanmin(shapes.left)) / wide if wide > 0 else 1
                p.tube(places[k:k + 2], directors[k:k + 2], self.half[k:k + 2], sides,
                       between(NEARNESS, part if math.isfinite(part) else 1), rectangle, opacity=opacity)
        elif not self.tubes:
            p.tube(places, directors, self.half, sides, colour, rectangle, opacity=opacity)
        for i, (end, radius) in enumerate(self.tubes if shapes.left is None else []):
            last, frame_ = self.at(places, directors, end)
            within = shapes.s < end
            radii = numpy.append(radius[within], numpy.interp(end, shapes.s, radius))
            p.tube(numpy.vstack([places[within], last]), numpy.concatenate([directors[within], frame_[None]]),
                   numpy.repeat(radii[:, None], 2, 1), sides, colour if i == 0 else rgb(METALS[(i - 1) % 3]))


class Drawing:
    def __init__(self, data, ending):
        self.flat = ending == ".svg"  # areas: as few of them as will do
        self.robot = Robot(data, 33 if self.flat else 121)
        self.x = self.robot.x
        self.p = Picture(*SIZES[ending])
        paths = data.get("paths", [])
        self.wanted = Shapes(paths[0], 2) if paths else None
        reference = data["motion"].get("reference")
        if not paths and reference and reference["frames"] > 1:
            self.wanted = Shapes(reference, 2)
        self.follows = bool(paths)
        self.wall = None
        if "wall" in data:
            wall = data["wall"]
            self.wall = (numpy.stack([column(c, wall["corners"]) for c in wall["places"]], 1),
                         numpy.stack([column(c, wall["triangles"]) for c in wall["of"]], 1).astype(int))
        self.tips = data.get("workspace")
        if self.tips:
            columns = self.tips["columns"]
            values = [column(c, self.tips["rows"]) for c in columns]
            which = next(k for k, c in enumerate(columns) if c["name"] == self.tips["by"])
            shown = numpy.isfinite(values[which])
            self.tip_places, self.tip_values = numpy.stack(values[:3], 1)[shown], values[which][shown]
            self.tip_column, self.tip_ends = columns[which], self.tips["ends"][which - 3]
        self.place_camera()

    def place_camera(self):
        shapes, up, p = self.x, self.robot.up, self.p
        shown = [shapes.at(shapes.places, f)[::3 if len(shapes.s) > 40 else 1]
                 for f in numpy.linspace(0, shapes.frames - 1, 40)]
        known = numpy.concatenate(shown)
        known = known[numpy.isfinite(known).all(1)]
        room = self.robot.room * numpy.vstack([numpy.eye(3), -numpy.eye(3)])
        places = [(known[:, None] + room).reshape(-1, 3)]
        places += [self.wanted.places[:, -1]] if self.wanted else []
        places += [self.wall[0]] if self.wall else []
        places += [self.tip_places] if self.tips else []
        places = numpy.concatenate(places)
        places = places[numpy.isfinite(places).all(1)]
        centre = (shapes.low + shapes.high) / 2
        # from the side along which shapes are widest, turned a little; the last one goes to the right
        side, front = level(up)
        x, y = (places - centre) @ side, (places - centre) @ front
        ahead = shapes.places[-1, -1] - shapes.places[-1, 0]
        azimuth = 0.5 * math.atan2(2 * (x @ y), x @ x - y @ y) + math.pi / 2
        if -math.sin(azimuth) * (ahead @ side) + math.cos(azimuth) * (ahead @ front) < 0:
            azimuth += math.pi
        p.look(centre, up, azimuth - 0.42, 0.36)
        height = (places @ up).min() - 0.035 * shapes.size
        few = places[::31]
        p.fit(numpy.vstack([places, few - numpy.outer(few @ up - height, up)]), 0.80)  # and shadows
        self.floor = (height, round125(shapes.size / 8), 0.95 * shapes.size)

    # ---- around the robot -------------------------------------------------------------------------

    def bar(self, left, name, ends, unit_, colours):
        """What colours mean: from ends[0] to ends[1]."""
        pieces, wide, y = 24, 150, 34
        for i in range(pieces):
            self.p.line([(left + wide * i / pieces, y), (left + wide * (i + 1) / pieces, y)], 8,
                        between(colours, i / (pieces - 1)))
        self.p.text(left - 14, y + 5, 15, "end", rgb(INK), name)
        for k in (0, 1):
            text = with_unit(ends[k], unit_) if unit_ in ("m", "s") else f"{ends[k]:.3g} {unit_}".rstrip()
            self.p.text(left + k * wide, y + 24, 15, "end" if k else "start", rgb(INK), text)

    def axes_and_scale(self):
        p, x, y = self.p, 50, self.p.height - 50
        for k, (name, colour) in enumerate((("x", "d33d38"), ("y", "2f9e4c"), ("z", "2b6bd0"))):
            right, up = p.axes[0][k], p.axes[1][k]
            p.line([(x, y), (x + 30 * right, y - 30 * up)], 2.4, rgb(colour))
            p.text(x + 40 * right, y - 40 * up + 5, 15, "middle", rgb(colour), name)
        bar = round125(120 / p.scale())
        wide, right, low = bar * p.scale(), p.width - 26, p.height - 30
        p.line([(right - wide, low - 5), (right - wide, low), (right, low), (right, low - 5)], 2, rgb(INK))
        p.text(right - wide / 2, low - 9, 15, "middle", rgb(INK), with_unit(bar, "m"))
        if self.x.enlarged > 1:
            p.text(right, low + 20, 13, "end", rgb(SOFT), f"deflections {self.x.enlarged:g} times enlarged")

    def draw_tips(self):
        p, (low, high) = self.p, self.tip_ends
        seen = p.project(self.tip_places)
        for i in numpy.argsort(-seen[:, 2], kind="stable"):
            part = (self.tip_values[i] - low) / (high - low) if high > low else 0
            p.line([seen[i, :2] - (0.1, 0), seen[i, :2] + (0.1, 0)], 4, between(SHADES, part))
        name = f"tips: {self.tip_column['name']}"
        self.bar(38 + strokes_of(name, 15)[1], name, self.tip_ends, self.tip_column["unit"], SHADES)

    def draw_paths(self, until):
        """The way of the tip up to a frame, and that of the wanted place, dashed."""
        shapes = self.x
        if shapes.t is not None and shapes.frames > 1:
            frames = [*range(0, int(until) + 1, int(until) // 598 + 1), until]
            self.p.thread([shapes.at(shapes.places, f)[-1] for f in frames], 0.0028 * shapes.size, rgb(TRAIL))
        if self.wanted:
            places = self.wanted.places[:, -1]
            way = numpy.cumsum(numpy.linalg.norm(numpy.diff(places, axis=0, prepend=places[:1]), axis=1))
            dash = (way // (0.03 * shapes.size)).astype(int)
            for k in range(0, dash[-1] + 1, 2):
                self.p.thread(places[dash == k], 0.0042 * shapes.size, rgb(WANTED))

    def words(self, frame):
        """Where the tip is, and what acts."""
        tip = 1e3 * self.x.at(self.x.places, frame)[-1]
        self.p.text(24, 34, 15, "start", rgb(INK), "tip (%s) mm" % ", ".join(f"{round(v, 1) + 0.0:.1f}" for v in tip))
        y = 60
        for kind, colours in STRENGTHS.items():
            texts = [with_unit(self.x.at(g[4], frame), g[3]) for g in self.robot.guided if g[0] == kind]
            if texts:
                self.p.line([(24, y - 5), (48, y - 5)], 5, rgb(colours[1]))
                self.p.text(58, y, 15, "start", rgb(INK), f"{kind}{'s' * (len(texts) > 1)} {', '.join(texts)}")
                y += 24

    def draw_around(self, frame, is_still):
        shapes, p = self.x, self.p
        moves = shapes.t is not None and shapes.frames > 1
        if self.tips:
            self.draw_tips()
        if self.wall:
            p.mesh(*self.wall, rgb(GLASS), 0.12)
        self.draw_paths(frame)
        self.axes_and_scale()
        if not self.tips and (moves or shapes.frames == 1):
            self.words(frame)
        if shapes.left is not None:
            self.bar(p.width - 176, "left", (numpy.nanmin(shapes.left), numpy.nanmax(shapes.left)), "m", NEARNESS)
        elif moves and is_still:
            self.bar(p.width - 176, "", (shapes.t[0], shapes.t[-1]), "s", TIMES)
        elif not is_still:
            text = shapes.labels[int(frame)] if shapes.labels else with_unit(shapes.at(shapes.t, frame), "s")
            p.text(p.width - 26, 34, 15, "end", rgb(INK), text)

    # ---- stills and movies ------------------------------------------------------------------------

    def draw_robot(self, frame, colour, is_main):
        ghost = self.follows and not is_main
        self.robot.draw(self.p, frame, colour, 0.2 if ghost else 1, is_main, 12 if self.flat else 24)

    def still(self):
        """The last instant, and those before whose tips are not where others are."""
        shapes, self.p.floor = self.x, self.floor
        moves = shapes.t is not None
        count = min(shapes.frames, 6 if self.follows else 8 if moves else 9)
        last, drawn = shapes.frames - 1, []
        for i in range(count):
            part = i / (count - 1) if count > 1 else 1
            frame = int(part * last)
            tip = shapes.places[frame, -1]
            hidden = [numpy.linalg.norm(tip - shapes.places[f, -1]) < 2.2 * self.robot.radius
                      for f in [*drawn, last]]
            if i + 1 == count or not any(hidden):
                colour = between(TIMES, part if count > 1 else 0.75) if moves or count == 1 else \
                    between(KINDS, part)
                self.draw_robot(frame, colour, i + 1 == count or (not moves and not self.flat))
                drawn.append(frame)
        self.draw_around(last, True)

    def image(self, part):
        shapes, p = self.x, self.p
        frame = round(part * (shapes.frames - 1))
        if shapes.t is not None:  # frames need not be evenly spaced in time
            frame = numpy.interp(shapes.t[0] + part * (shapes.t[-1] - shapes.t[0]), shapes.t,
                                 numpy.arange(shapes.frames))
        p.clear()
        p.floor = self.floor
        self.draw_robot(frame, between(TIMES, 0.75), True)
        self.draw_around(frame, False)
        return p.pixels(2)


def film(drawing, path, ending, slow):
    """As long as the motion, `slow` times; members of a family eight seconds."""
    shapes, rate = drawing.x, RATES[ending]
    seconds = slow * (shapes.t[-1] - shapes.t[0] if shapes.t is not None else MEMBERS_SECONDS)
    most = GIF_SECONDS if ending == ".gif" else MOVIE_SECONDS
    if shapes.frames < 2 or not seconds > 0:
        fail(f"{source}: nothing moves; allowed: .svg, .png")
    if seconds > most:
        fail(f"{source}: {seconds:g} s are too long for {'a .gif' if ending == '.gif' else 'a movie'}; "
             f"allowed: up to {most}, by --slow")
    images = round(seconds * rate) + 1
    partial = path + ".partial"
    with tempfile.TemporaryFile() as told:
        try:
            encoder = subprocess.Popen(
                ["ffmpeg", "-nostdin", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgb24",
                 "-video_size", "%dx%d" % SIZES[ending], "-framerate", str(rate), "-i", "pipe:0",
                 *ENCODERS[ending], "file:" + partial],
                stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=told, start_new_session=True)
        except FileNotFoundError:
            fail(f"{source}: {path}: movies need the encoder ffmpeg, which is not installed "
                 "(apt-get install ffmpeg)")
        running.add(encoder)
        try:
            for k in range(images):
                if stopped:
                    return 128 + stopped[0]
                try:
                    encoder.stdin.write(drawing.image(k / (images - 1)).tobytes())
                except BrokenPipeError:
                    break
            try:
                encoder.stdin.close()
            except BrokenPipeError:
                pass
            if encoder.wait() or not os.path.exists(partial):
                told.seek(0)
                line = next((text.strip() for text in told.read().decode(errors="replace").splitlines()
                             if text.strip()), "it says nothing")
                fail(f"{source}: {path}: not written, ffmpeg failed: {line}", 1)
            os.replace(partial, path)
        finally:
            encoder.kill()
            encoder.wait()
            if os.path.exists(partial):
                os.unlink(partial)
    return 0


def read(path):
    """The data of a page."""
    try:
        text = sys.stdin.read() if path == "-" else open(path, encoding="utf-8").read()
    except (OSError, UnicodeDecodeError) as error:
        fail(f"{path}: {getattr(error, 'strerror', 'is no text')}; allowed: a page of cpinn-show")
    if path != "-":
        found = re.search(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.S)
        text = found[1] if found else ""
    try:
        return json.loads(text)
    except ValueError:
        fail(f"{path}: is no page of cpinn-show")


def write(path, content):
    try:
        with open(path + ".partial", "wb") as file:
            file.write(content)
        os.replace(path + ".partial", path)
    except OSError as error:
        fail(f"{path}: not written: {error.strerror}", 1)


def main():
    global numpy, source
    parser = Parser()
    parser.add_argument("page", metavar="PAGE.html")
    parser.add_argument("--out", metavar="FILE", required=True)
    parser.add_argument("--quiet", action="store_true")
    parser.add_argument("--slow", metavar="X", type=number(float, 1e-3, "a number, 0.001 to 1000000", 1e6), default=1)
    asked = parser.parse_args()
    ending = os.path.splitext(asked.out)[1]
    if ending not in SIZES:
        fail(f"--out {asked.out}: allowed: {', '.join(SIZES)}")
    try:
        import numpy
    except ImportError:
        fail("pictures need numpy, which is not installed (apt-get install python3-numpy)")
    data = read(asked.page)
    source = data.get("source", asked.page)
    if "motion" not in data or "residuals" in data:
        fail(f"{source}: has no shapes for a picture; allowed: .html")
    drawing = Drawing(data, ending)
    status = 0
    if ending in RATES:
        status = film(drawing, asked.out, ending, asked.slow)
    else:
        drawing.still()
        write(asked.out, drawing.p.svg().encode() if ending == ".svg" else png(drawing.p.pixels(3)))
    if not status and not asked.quiet:
        print(f"wrote {asked.out}")
    return status


if __name__ == "__main__":
    sys.exit(start(main, lambda: __doc__))
