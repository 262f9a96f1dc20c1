# Solids in space above a floor, with light, shadow, lines and words: as areas of one colour, for .svg,
# and as pixels. The build puts this into cpinn-picture. Lengths in space are in m, places on the picture
# in pixels from its upper left corner. A corner of a face is a row of three numbers, faces [n][4][3] are
# counterclockwise as seen from outside; those of a triangle have its last corner twice.
import struct
import zlib

LENS = 0.266  # tangent of half the opening of the view upwards
LETTERS = dict((line[0], line[2:].split()) for line in r"""
@LETTERS@
""".splitlines() if line)
NO_LETTER = ["0c4c4j0j0c"]


def rgb(text):
    return numpy.array([int(text[k:k + 2], 16) for k in (0, 2, 4)]) / 255


def between(colours, at):
    """Between the colours of a list, at 0 to 1."""
    place = min(1, max(0, at)) * (len(colours) - 1)
    k = min(int(place), len(colours) - 2)
    return rgb(colours[k]) + (place - k) * (rgb(colours[k + 1]) - rgb(colours[k]))


def unit(v):
    size = numpy.linalg.norm(v, axis=-1, keepdims=True)
    return v / numpy.where(size > 0, size, 1)


def level(up):
    """Two unit vectors across a third."""
    up = numpy.asarray(up, float)
    side = -up[least := int(numpy.argmin(abs(up)))] * up
    side[least] += 1
    side = unit(side)
    return side, numpy.cross(up, side)


def frames_along(places):
    """Directors [n][3][3] of places [n][3]: the third is along them, the others do not twist."""
    n = len(places)
    along = places[numpy.minimum(numpy.arange(n) + 1, n - 1)] - places[numpy.maximum(numpy.arange(n) - 1, 0)]
    along[~(numpy.linalg.norm(along, axis=1) > 0)] = (0, 0, 1)
    frames = numpy.empty((n, 3, 3))
    frames[:, 2] = unit(along)
    for i in range(n):
        d3 = frames[i, 2]
        d1 = frames[i - 1, 0] - (frames[i - 1, 0] @ d3) * d3 if i else numpy.zeros(3)
        frames[i, 0] = unit(d1) if numpy.linalg.norm(d1) > 1e-9 else level(d3)[0]
    frames[:, 1] = numpy.cross(frames[:, 2], frames[:, 0])
    return frames


def pairs(sizes):
    """(which, number in it) of all cells, where `sizes` says how many each has."""
    which = numpy.repeat(numpy.arange(len(sizes)), sizes)
    return which, numpy.arange(len(which)) - numpy.repeat(numpy.cumsum(sizes) - sizes, sizes)


def chunks(sizes, most=100_000):
    """Slices of a list whose sizes sum to about `most`."""
    ends, first = numpy.cumsum(sizes), 0
    while first < len(sizes):
        end = max(first + 1, int(numpy.searchsorted(ends, (ends[first - 1] if first else 0) + most)))
        yield slice(first, end)
        first = end


class Picture:
    def __init__(self, width, height):
        self.width, self.height = width, height
        self.clear()

    def clear(self):
        self.faces, self.lines, self.words, self.floor = [], [], [], None

    # ---- camera -----------------------------------------------------------------------------------

    def look(self, target, up, azimuth, elevation):
        """Angles in rad, the azimuth from `side`, the elevation above the floor."""
        side, front = level(up)
        back = math.cos(elevation) * (math.cos(azimuth) * side + math.sin(azimuth) * front) \
            + math.sin(elevation) * up
        right = math.cos(azimuth) * front - math.sin(azimuth) * side
        self.target, self.up = target, up
        self.axes = numpy.array([right, numpy.cross(back, right), back])
        self.distance, self.shift = 1, numpy.zeros(2)

    def project(self, places):
        """x, y and how far away, m."""
        seen = (places - self.target) @ self.axes.T
        seen[..., 2] = numpy.maximum(self.distance - seen[..., 2], 0.05 * self.distance)
        scale = self.height / (2 * LENS * seen[..., 2])
        seen[..., 0] = self.width / 2 + self.shift[0] + scale * seen[..., 0]
        seen[..., 1] = self.height / 2 + self.shift[1] - scale * seen[..., 1]
        return seen

    def fit(self, places, part):
        """As near as lets all places be within this part of the picture, and its middle."""
        size = abs(places - self.target).max()
        self.distance = 10 * size
        middle = numpy.array([self.width, self.height]) / 2
        for _ in range(8):
            seen = self.project(places)[:, :2]
            wide = (seen.max(0) - seen.min(0)) / (part * 2 * middle)
            self.distance = max(self.distance * wide.max(), 1.5 * size)
            seen = self.project(places)[:, :2]
            self.shift = self.shift + middle - (seen.min(0) + seen.max(0)) / 2

    def scale(self):
        """Pixels of a metre at the target."""
        return self.height / (2 * LENS * self.distance)

    # ---- solids -----------------------------------------------------------------------------------

    def add(self, corners, normals, colour, opacity=1, shadow=True):
        n = len(corners)
        self.faces.append((corners, numpy.broadcast_to(normals, corners.shape),
                           numpy.broadcast_to(colour, (n, 3)), numpy.full(n, opacity), numpy.full(n, shadow)))

    def tube(self, places, frames, half, sides, colour, rectangle=False, caps=True, opacity=1, shadow=True):
        """Through places [n][3] with directors [n][3][3] and half sizes [n][2] along the first two."""
        if len(places) < 2:
            return
        half = half[:, None, :, None]
        if rectangle:
            outline = numpy.array([(1, -1), (1, 1), (-1, 1), (-1, -1)], float)
            flat = (outline + numpy.roll(outline, -1, 0)) / 2
        else:
            angle = 2 * math.pi * numpy.arange(sides) / sides
            outline = flat = numpy.stack([numpy.cos(angle), numpy.sin(angle)], 1)
        rings = places[:, None] + (outline[None, :, :, None] * half * frames[:, None, :2]).sum(2)
        normals = (flat[None, :, :, None] * frames[:, None, :2]).sum(2)
        following = normals if rectangle else numpy.roll(normals, -1, 1)
        corners = numpy.stack([rings[:-1], numpy.roll(rings, -1, 1)[:-1], numpy.roll(rings, -1, 1)[1:],
                               rings[1:]], 2)
        turned = numpy.stack([normals[:-1], following[:-1], following[1:], normals[1:]], 2)
        look = (colour, opacity, shadow)
        self.add(corners.reshape(-1, 4, 3), turned.reshape(-1, 4, 3), *look)
        for end, sign in ((0, -1), (-1, 1)) if caps else ():
            ring = rings[end][::sign]
            fan = numpy.array([(0, k, k + 1, min(k + 2, len(ring) - 1)) for k in range(1, len(ring) - 1, 2)])
            self.add(ring[fan], sign * frames[end, 2], *look)

    def mesh(self, corners, triangles, colour, opacity):
        faces = corners[triangles]
        normals = numpy.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
        self.add(faces[:, [0, 1, 2, 2]], normals[:, None], colour, opacity, False)

    def thread(self, places, radius, colour):
        places = numpy.asarray(places)
        self.tube(places, frames_along(places), numpy.full((len(places), 2), radius), 6, colour, caps=False,
                  shadow=False)

    def arrow(self, start, vector, radius, heads, colour):
        """Moments have two heads."""
        length = numpy.linalg.norm(vector)
        if length < 2 * radius:
            return
        along, head = vector / length, min(5.5 * radius, 0.6 * length / heads)
        pieces = [(0, length - heads * head, radius, radius)]
        pieces += [(length - k * head, length - (k - 1) * head, 2.4 * radius, 1e-3 * radius)
                   for k in range(heads, 0, -1)]
        for first, last, wide, narrow in pieces:
            places = start + numpy.outer((first, last), along)
            self.tube(places, frames_along(places), numpy.array([[wide] * 2, [narrow] * 2]), 12, colour)

    def ball(self, centre, radius, colour):
        a, b = numpy.meshgrid(numpy.linspace(0, math.pi, 9), numpy.linspace(0, 2 * math.pi, 15), indexing="ij")
        n = numpy.stack([numpy.sin(a) * numpy.cos(b), numpy.sin(a) * numpy.sin(b), numpy.cos(a)], 2)
        normals = numpy.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], 2).reshape(-1, 4, 3)
        self.add(centre + radius * normals, normals, colour)

    # ---- floor, lines, words ----------------------------------------------------------------------

    def grid(self):
        """Lines [n][4] of the floor, the middle where it is darkest and the radii where it has faded."""
        height, step, reach = self.floor
        side, front = level(self.up)
        foot = self.target - (self.target @ self.up - height) * self.up
        lines = []
        for k in range(-int(reach / step), int(reach / step) + 1):
            for across, along in ((side, front), (front, side)):
                centre = across @ self.target  # lines are at multiples of the step in space
                off = step * (round(centre / step) + k) - centre
                half = math.sqrt(max(0, reach**2 - off**2))
                ends = self.project(foot + off * across + numpy.outer((-half, half), along))
                lines.append(ends[:, :2].ravel())
        middle = self.project(foot)
        radius = reach * self.height / (2 * LENS * middle[2])
        return numpy.array(lines), middle[:2], radius * numpy.array([1, max(abs(self.axes[2] @ self.up), 0.05)])

    def line(self, points, width, colour):
        """Over all solids."""
        self.lines.append((numpy.asarray(points, float), width, colour))

    def text(self, x, y, size, align, colour, text):
        """With a white rim; align: start, middle or end."""
        self.words.append((x, y, size, align, colour, text))

    # ---- light ------------------------------------------------------------------------------------

    def light(self, places, normals, colours):
        """A key light over the left shoulder, the sky, a darker edge and a highlight."""
        n, view = unit(normals), unit(self.target + self.distance * self.axes[2] - places)
        key = unit(numpy.array([-0.45, 0.75, 0.55]) @ self.axes)
        facing = (n * view).sum(-1, keepdims=True)
        n, facing = numpy.where(facing < 0, -n, n), abs(facing)
        light = 0.46 + 0.22 * (0.5 + 0.5 * (n @ self.up)) + 0.50 * numpy.maximum(n @ key, 0)
        shine = 0.30 * numpy.maximum((n * unit(key + view)).sum(-1), 0)**48
        return numpy.minimum(1, colours * light[..., None] * (1 - 0.4 * (1 - facing)**3) + shine[..., None])

    def hides(self, places, normals, opacity):
        """How much hides what is behind: what is seen through hides more at its edges."""
        view = unit(self.target + self.distance * self.axes[2] - places)
        edge = 1 - abs((unit(normals) * view).sum(-1))
        return numpy.where(opacity < 1, numpy.minimum(1, opacity * (0.55 + 2.6 * edge**2)), 1)

    def all_faces(self):
        """Corners, normals, colours, opacity and shadow of all; which of them the eye sees from outside."""
        if not self.faces:
            self.add(numpy.zeros((0, 4, 3)), numpy.zeros(3), numpy.zeros(3))
        parts = [numpy.concatenate(part) for part in zip(*self.faces)]
        known = numpy.isfinite(parts[0]).all((1, 2)) & numpy.isfinite(parts[1]).all((1, 2))
        corners, normals, colours, opacity, shadow = (part[known] for part in parts)
        eye = self.target + self.distance * self.axes[2]
        return corners, normals, colours, opacity, shadow, ((eye - corners) * normals).sum((1, 2)) > 0

    def shadows(self, corners):
        flat = corners - (corners @ self.up - self.floor[0])[..., None] * self.up
        return self.project(flat)[..., :2]

    # ---- areas of one colour ----------------------------------------------------------------------

    def svg(self):
        """The text of a file."""
        w, h = self.width, self.height
        to = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {w} {h}" width="{w}" height="{h}">',
              '<rect width="100%" height="100%" fill="#fff"/>']
        corners, normals, colours, opacity, shadow, seen = self.all_faces()
        if self.floor:
            lines, (x, y), (wide, high) = self.grid()
            to.append('<radialGradient id="fade" gradientUnits="userSpaceOnUse" cx="0" cy="0" r="1" '
                      f'gradientTransform="translate({x:.1f} {y:.1f}) scale({wide:.1f} {high:.1f})">'
                      '<stop stop-color="#8f9bab"/><stop offset="1" stop-color="#8f9bab" stop-opacity="0"/>'
                      '</radialGradient>\n<path fill="none" stroke="url(#fade)" d="' +
                      "".join("M%.1f %.1fL%.1f %.1f" % tuple(line) for line in lines) + '"/>')
            areas = self.shadows(corners[shadow])
            a, b = areas, numpy.roll(areas, -1, 1)
            turn = (a[..., 0] * b[..., 1] - b[..., 0] * a[..., 1]).sum(1)
            to.append(f'<filter id="soft"><feGaussianBlur stdDeviation="{w // 240 + 1}"/></filter>\n'
                      '<g opacity=".3" filter="url(#soft)"><path fill="#26303d" transform="scale(.5)" d="' +
                      # one path of all, so that none is darker where they meet: one side of each solid
                      "".join(path_of(numpy.rint(2 * areas[turn > 0.2]))) + '"/></g>')
        shown = numpy.flatnonzero(seen)
        corners, normals = corners[shown], normals[shown]
        place, normal = corners.mean(1), normals.sum(1)
        inks = numpy.rint(255 * self.light(place, normal, colours[shown])).astype(int)
        hides = self.hides(place, normal, opacity[shown])
        areas = self.project(corners)[..., :2]
        out = areas - areas.mean(1, keepdims=True)
        # solid ones are grown by a third of a pixel, so that nothing shines through between neighbours
        areas += numpy.where(opacity[shown] < 1, 0, 0.35)[:, None, None] * unit(out)
        paths = path_of(numpy.rint(10 * areas))
        to.append('<g transform="scale(.1)">')
        for i in numpy.argsort(-(self.distance - place @ self.axes[2]), kind="stable"):
            through = f'" fill-opacity="{hides[i]:.2g}' if opacity[shown[i]] < 1 else ""
            to.append('<path fill="#%02x%02x%02x%s" d="%s"/>' % (*inks[i], through, paths[i]))
        to.append('</g>\n<g fill="none" stroke-linecap="round" stroke-linejoin="round">')
        for points, width, colour in self.lines:
            to.append(f'<path stroke-width="{width:.3g}" stroke="{hex_of(colour)}" d="M' +
                      "L".join("%.1f %.1f" % tuple(point) for point in points) + '"/>')
        to.append('</g>\n<g font-family="Helvetica,Arial,sans-serif" stroke="#fff" stroke-width="3" '
                  'stroke-linejoin="round" paint-order="stroke">')
        for x, y, size, align, colour, text in self.words:
            for mark, code in ("&", "&#38;"), ("<", "&#60;"), (">", "&#62;"):
                text = text.replace(mark, code)
            to.append(f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size:g}" text-anchor="{align}" '
                      f'fill="{hex_of(colour)}">{text}</text>')
        return "\n".join(to) + "\n</g>\n</svg>\n"

    # ---- pixels -----------------------------------------------------------------------------------

    def pixels(self, samples):
        """[height][width][3], by samples x samples for each pixel."""
        corners, normals, colours, opacity, shadow, seen = self.all_faces()
        canvas = Canvas(self.width, self.height, samples)
        if self.floor:
            lines, middle, radii = self.grid()

            def fade(places):
                return numpy.maximum(0, 1 - numpy.hypot(*((places - middle) / radii).T))
            canvas.draw_lines(lines, 1, rgb("8f9bab"), fade)
            cast = Canvas(self.width, self.height, 1)
            cast.solid(*cast.triangles(self.shadows(corners[shadow])))
            canvas.darken(soften(cast.near.reshape(self.height, self.width) > 0, self.width // 240 + 1))
        places = self.project(corners)
        shades = numpy.concatenate([self.light(corners, normals, colours[:, None]),
                                    self.hides(corners, normals, opacity[:, None])[..., None]], 2)
        solid = opacity >= 1
        canvas.solid(*canvas.triangles(places[solid & seen], shades[solid & seen]))
        clear = numpy.flatnonzero(~solid & seen)
        clear = clear[numpy.argsort(-places[clear, :, 2].mean(1), kind="stable")]
        canvas.clear(*canvas.triangles(places[clear], shades[clear]))
        for points, width, colour in self.lines:
            canvas.draw_lines(numpy.concatenate([points[:-1], points[1:]], 1), width, colour)
        for x, y, size, align, colour, text in self.words:
            strokes, wide = strokes_of(text, size)
            if len(strokes):
                strokes += numpy.tile([x - wide * {"start": 0, "middle": 0.5, "end": 1}[align], y], 2)
                canvas.draw_lines(strokes, 0.13 * size + 4, numpy.ones(3))
                canvas.draw_lines(strokes, 0.115 * size, colour)
        return canvas.means()


def hex_of(colour):
    return "#%02x%02x%02x" % tuple(numpy.rint(255 * numpy.asarray(colour)).astype(int))


def path_of(areas):
    """The path of each of areas [n][4][2] of whole numbers, relative from corner to corner."""
    steps = numpy.diff(areas, axis=1, prepend=0).astype(int)
    steps[:, 0] = areas[:, 0]
    texts = []
    for (x, y), *others in steps.tolist():
        if others[-1] == [0, 0]:
            del others[-1]
        texts.append(f"M{x} {y}l" + " ".join(f"{x} {y}" for x, y in others).replace(" -", "-") + "z")
    return texts


def soften(mask, reach):
    """Means over 2 reach + 1 pixels both ways, three times; elsewhere there is nothing."""
    result, room = numpy.zeros(mask.shape), 3 * reach + 1
    if not mask.any():
        return result
    part = tuple(slice(max(0, at.min() - room), at.max() + room + 1) for at in numpy.nonzero(mask))
    values = mask[part].astype(float)
    for axis in (0, 1) * 3:
        padded = numpy.pad(values, [(reach + 1, reach) if k == axis else (0, 0) for k in (0, 1)])
        sums, wide = numpy.cumsum(padded, axis), 2 * reach + 1
        count = values.shape[axis]
        values = (numpy.take(sums, range(wide, wide + count), axis) - numpy.take(sums, range(count), axis)) / wide
    result[part] = values
    return result


def strokes_of(text, size):
    """Lines [n][4] of letters from (0, 0) on, and how wide they are."""
    scale, x, lines = size / 9.6, 0, []
    for letter in text:
        strokes = [] if letter == " " else LETTERS.get(letter, NO_LETTER)
        for stroke in strokes:
            kind = stroke[0] if stroke[0] in "~@" else ""
            stroke = stroke[len(kind):]
            points = numpy.array([(int(a) * scale + x, (ord("c") - ord(b)) * scale)
                                  for a, b in zip(stroke[::2], stroke[1::2])])
            points = curve_of(points, kind) if kind and len(points) > 2 else points
            lines.append(numpy.concatenate([points[:-1], points[1:]], 1))
        x += scale * (max([int(c) for c in "".join(strokes) if c.isdigit()], default=1 - bool(strokes)) + 1.9)
    return numpy.concatenate(lines) if lines else numpy.zeros((0, 4)), max(0, x - 1.9 * scale)


def curve_of(corners, kind):
    """A quadratic B-spline, "@" a closed one."""
    if kind == "@":
        corners = numpy.concatenate([corners, corners[:2]])
    a, b, c = (corners[:-2] + corners[1:-1]) / 2, corners[1:-1], (corners[1:-1] + corners[2:]) / 2
    if kind == "~":
        a[0], c[-1] = corners[0], corners[-1]
    u = numpy.linspace(0, 1, 6)[None, :, None]
    return ((1 - u)**2 * a[:, None] + 2 * u * (1 - u) * b[:, None] + u**2 * c[:, None]).reshape(-1, 2)


class Canvas:
    """Samples with a colour and the inverse of a depth."""

    def __init__(self, width, height, samples):
        self.samples, self.width, self.height = samples, width * samples, height * samples
        self.colours = numpy.ones((self.width * self.height, 3), numpy.float32)
        self.near = numpy.zeros(self.width * self.height, numpy.float32)

    def boxes(self, low, high):
        """Of low and high [n][2]: first samples and sizes [n][2], within the canvas."""
        first = numpy.maximum(numpy.ceil(low - 0.5), 0).astype(int)
        end = numpy.minimum(numpy.ceil(high - 0.5), (self.width, self.height)).astype(int)
        return first, numpy.maximum(end - first, 0)

    def triangles(self, places, shades=None):
        """Of faces [n][4] their triangles, samples and inverse depths [m][3][3], and shades [m][3][4]."""
        places = numpy.array(places)
        places[..., :2] *= self.samples
        if places.shape[-1] == 2:
            places = numpy.concatenate([places, numpy.ones(places.shape[:2] + (1,))], 2)
        places[..., 2] = 1 / places[..., 2]
        shades = numpy.zeros(places.shape[:2] + (4,)) if shades is None else shades
        order = [0, 1, 2, 0, 2, 3]
        return places[:, order].reshape(-1, 3, 3), shades[:, order].reshape(-1, 3, 4)

    def fragments(self, places, shades):
        """In turn (samples, inverse depths, shades) of many triangles at once."""
        low, size = self.boxes(places[..., :2].min(1), places[..., :2].max(1))
        (x0, y0), (x1, y1), (x2, y2) = (places[:, k, :2].T for k in range(3))
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        kept = numpy.flatnonzero((area != 0) & (size.prod(1) > 0))
        for part in chunks(size[kept].prod(1)):
            few = kept[part]
            which, at = pairs(size[few].prod(1))
            which = few[which]
            column, row = low[which, 0] + at % size[which, 0], low[which, 1] + at // size[which, 0]
            x, y = column + 0.5, row + 0.5
            a = ((x1[which] - x) * (y2[which] - y) - (x2[which] - x) * (y1[which] - y)) / area[which]
            b = ((x2[which] - x) * (y0[which] - y) - (x0[which] - x) * (y2[which] - y)) / area[which]
            inside = (a >= 0) & (b >= 0) & (a + b <= 1)
            which, parts = which[inside], (a[inside, None], b[inside, None], (1 - a - b)[inside, None])
            yield (row * self.width + column)[inside], *(sum(part * of[which, k] for k, part in enumerate(parts))
                                                         for of in (places[:, :, 2:], shades))

    def solid(self, places, shades):
        for at, near, shade in self.fragments(places, shades):
            near = near[:, 0]
            order = numpy.argsort(near)
            order = order[near[order] > self.near[at[order]]]
            at = at[order]  # the last of those that are the same stays
            self.near[at] = near[order]
            self.colours[at] = shade[order, :3]

    def clear(self, places, shades):
        """What is seen through, the farthest first."""
        for at, near, shade in self.fragments(places, shades):
            shown = numpy.flatnonzero(near[:, 0] > self.near[at])
            order = shown[numpy.argsort(at[shown], kind="stable")]
            ends = at[order]
            first = numpy.flatnonzero(numpy.diff(ends, prepend=-1))
            turn = pairs(numpy.diff(numpy.append(first, len(ends))))[1]
            for k in range(turn.max() + 1 if len(turn) else 0):
                now = order[turn == k]
                self.mix(at[now], shade[now, :3], shade[now, 3])

    def mix(self, at, colour, part):
        self.colours[at] += numpy.asarray(part)[..., None] * (colour - self.colours[at])

    def draw_lines(self, lines, width, colour, fade=None):
        """Lines [n][4] with round ends, pixels; no sample takes more than one of them."""
        lines = self.samples * numpy.asarray(lines, float)
        half = width * self.samples / 2
        pieces = numpy.maximum(1, numpy.hypot(*(lines[:, 2:] - lines[:, :2]).T) // (6 * half + 20)).astype(int)
        which, k = pairs(pieces)  # short ones, whose boxes are small
        step = (lines[which, 2:] - lines[which, :2]) / pieces[which, None]
        start = lines[which, :2] + k[:, None] * step
        low, size = self.boxes(numpy.minimum(start, start + step) - half, numpy.maximum(start, start + step) + half)
        drawn = []
        for part in chunks(size.prod(1)):
            which, at = pairs(size[part].prod(1))
            which = which + part.start
            cell = low[which] + numpy.stack([at % numpy.maximum(size[which, 0], 1),
                                             at // numpy.maximum(size[which, 0], 1)], 1)
            off = cell + 0.5 - start[which]
            (x, y), (dx, dy) = off.T, step[which].T
            along = numpy.clip((x * dx + y * dy) / numpy.maximum(dx * dx + dy * dy, 1e-30), 0, 1)
            near = (x - along * dx)**2 + (y - along * dy)**2 <= half**2
            drawn.append(cell[near, 0] + self.width * cell[near, 1])
        at = numpy.unique(numpy.concatenate([numpy.zeros(0, int), *drawn]))
        places = (numpy.stack([at % self.width, at // self.width], 1) + 0.5) / self.samples
        self.mix(at, colour, fade(places) if fade else numpy.ones(len(at)))

    def darken(self, shadow):
        part = numpy.repeat(numpy.repeat(shadow, self.samples, 0), self.samples, 1).ravel()
        at = numpy.flatnonzero(part > 1e-6)
        self.mix(at, rgb("26303d"), 0.30 * part[at])

    def means(self):
        n, colours = self.samples, self.colours.reshape(self.height, self.width, 3)
        total = sum(colours[k // n::n, k % n::n] for k in range(n * n))
        return numpy.rint(255 / n**2 * total).astype(numpy.uint8)


def png(image):
    """The bytes of a file: each row by the filter in which it differs least."""
    height, width, _ = image.shape
    padded = numpy.pad(image, ((1, 0), (1, 0), (0, 0))).astype(numpy.int16)
    left, above, corner = padded[1:, :-1], padded[:-1, 1:], padded[:-1, :-1]
    off = abs(above - corner), abs(left - corner), abs(left + above - 2 * corner)
    paeth = numpy.where((off[0] <= off[1]) & (off[0] <= off[2]), left,
                        numpy.where(off[1] <= off[2], above, corner))
    guesses = 0 * left, left, above, (left + above) // 2, paeth
    trials = numpy.stack([(image - guess).astype(numpy.uint8).reshape(height, -1) for guess in guesses])
    kind = abs(trials.astype(numpy.int8).astype(int)).sum(2).argmin(0)
    rows = numpy.hstack([kind[:, None].astype(numpy.uint8), trials[kind, numpy.arange(height)]])
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = (b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in parts)
