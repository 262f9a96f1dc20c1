"use strict";
/* From the data to what is drawn at an instant: places and directors along the rod, and meshes of
 * triangles. Lengths in m, in the world's frame. */

/* ---- the motion ---------------------------------------------------------------------------- */

/* Of "motion" or its reference: frames of points with places, directors, times and columns. */
class Motion {
    constructor(data) {
        this.frames = data.frames;
        this.points = data.points;
        this.s = column(data.s[0]);
        this.t = data.t ? column(data.t[0]) : null;
        this.labels = data.labels || null;
        this.columns = data.columns.map(column);
        this.name = data.name || "";
        this.enlarged = 1;
        this.place = ["x", "y", "z"].map(name => this.find(name));
        if (!this.place[0] && this.find("w")) {
            this.#beam();
        }
        this.quaternion = ["qw", "qx", "qy", "qz"].map(name => this.find(name));
        this.isPlaced = this.place.every(c => c && c.low <= c.high);
        this.span = this.s.high - this.s.low;
    }

    find(name) {
        return this.columns.find(c => c.name === name) || null;
    }

    /* Of a beam: along x, with its deflection along z, enlarged to a quarter of the length. */
    #beam() {
        const w = this.find("w"), s = this.s, points = this.points;
        const length = s.at(points - 1) - s.at(0);
        const most = Math.max(Math.abs(w.low), Math.abs(w.high));
        this.enlarged = most > 0 && most < 0.1 * length ? round125(0.2 * length / most) : 1;
        this.place = [
            { name: "x", unit: "m", at: i => s.at(i % points), low: s.low, high: s.high },
            { name: "y", unit: "m", at: () => 0, low: 0, high: 0 },
            { name: "z", unit: "m", at: i => this.enlarged * w.at(i), low: this.enlarged * w.low,
                high: this.enlarged * w.high }];
    }

    placeAt(frame, point) {
        const i = frame * this.points + point;
        return [this.place[0].at(i), this.place[1].at(i), this.place[2].at(i)];
    }

    /* A point at frame `at`, between frames of a motion. */
    placeBetween(at, point) {
        const first = Math.min(Math.floor(at), this.frames - 1), part = this.t ? at - first : 0;
        const a = this.placeAt(first, point);
        return part > 0 && first + 1 < this.frames
            ? add(times(a, 1 - part), times(this.placeAt(first + 1, point), part)) : a;
    }

    /* Where the last point was from one frame to another. */
    way(from, to) {
        const places = [];
        for (let f = from; f <= to; f++) {
            places.push(this.placeAt(f, this.points - 1));
        }
        return places;
    }

    /* Places and directors at frame `at`, of a motion also between two frames. */
    pose(at) {
        const first = Math.min(Math.floor(at), this.frames - 1);
        const next = Math.min(first + 1, this.frames - 1), part = this.t ? at - first : 0;
        const places = [], frames = [];
        for (let k = 0; k < this.points; k++) {
            const a = this.placeAt(first, k);
            places.push(part > 0 ? add(times(a, 1 - part), times(this.placeAt(next, k), part)) : a);
        }
        if (this.quaternion.every(c => c)) {
            for (let k = 0; k < this.points; k++) {
                frames.push(this.#turned(first * this.points + k, next * this.points + k, part));
            }
            return { places, frames };
        }
        return { places, frames: this.#transported(places) };
    }

    #turned(i, j, part) {
        const a = this.quaternion.map(c => c.at(i)), b = this.quaternion.map(c => c.at(j));
        const same = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
        return directors(...a.map((x, k) => (1 - part) * x + part * same * b[k]));
    }

    /* Without quaternions: frames along the tangent that do not twist. */
    #transported(places) {
        const frames = [];
        let d1 = null;
        for (let k = 0; k < places.length; k++) {
            const from = places[Math.max(k - 1, 0)];
            const to = places[Math.min(k + 1, places.length - 1)];
            const d3 = unitVector(minus(to, from), [0, 0, 1]);
            d1 = d1 ? unitVector(minus(d1, times(d3, dot(d1, d3))), across(d3)) : across(d3);
            frames.push([d1, cross(d3, d1), d3]);
        }
        return frames;
    }
}

/* Point of a pose at arc length s, between its points. */
function poseAt(pose, arc, s) {
    let k = 0;
    while (k + 2 < pose.places.length && arc.at(k + 1) < s) {
        k++;
    }
    if (pose.places.length < 2) {
        return { place: pose.places[0], frame: pose.frames[0] };
    }
    const part = Math.min(1, Math.max(0, (s - arc.at(k)) / (arc.at(k + 1) - arc.at(k) || 1)));
    return {
        place: add(times(pose.places[k], 1 - part), times(pose.places[k + 1], part)),
        frame: pose.frames[part < 0.5 ? k : k + 1]
    };
}

/* ---- meshes -------------------------------------------------------------------------------- */

/* Numbers that are filled in anew for each picture, without new memory. */
class Numbers {
    constructor(Kind) {
        this.data = new Kind(1 << 14);
        this.count = 0;
    }

    room(more) {
        if (this.count + more > this.data.length) {
            const larger = new this.data.constructor(2 * (this.count + more));
            larger.set(this.data);
            this.data = larger;
        }
    }

    add(...values) {
        this.room(values.length);
        for (const value of values) {
            this.data[this.count++] = value;
        }
    }

    used() {
        return this.data.subarray(0, this.count);
    }
}

const VERTEX_NUMBERS = 10;

/* Triangles, anticlockwise from outside, and lines; a vertex is place, normal (0: not shaded) and
 * colour with opacity. */
class Mesh {
    constructor() {
        this.vertices = new Numbers(Float32Array);
        this.solid = new Numbers(Uint32Array);
        this.clear = new Numbers(Uint32Array); /* drawn after the solid ones */
        this.halo = new Numbers(Uint32Array); /* the far sides alone, around something */
        this.lines = new Numbers(Uint32Array);
        this.shadow = null; /* { of: triangles, from, to }: what throws one on the floor */
    }

    begin() {
        for (const part of [this.vertices, this.solid, this.clear, this.halo, this.lines]) {
            part.count = 0;
        }
        this.shadow = null;
    }

    get count() {
        return this.vertices.count / VERTEX_NUMBERS;
    }

    point(x, y, z, nx, ny, nz, c, opacity) {
        const v = this.vertices, i = v.count;
        v.room(VERTEX_NUMBERS);
        const to = v.data;
        to[i] = x;
        to[i + 1] = y;
        to[i + 2] = z;
        to[i + 3] = nx;
        to[i + 4] = ny;
        to[i + 5] = nz;
        to[i + 6] = c[0];
        to[i + 7] = c[1];
        to[i + 8] = c[2];
        to[i + 9] = opacity;
        v.count = i + VERTEX_NUMBERS;
        return i / VERTEX_NUMBERS;
    }

    vertex(p, n, c, opacity = 1) {
        return this.point(p[0], p[1], p[2], n[0], n[1], n[2], c, opacity);
    }

    line(a, b, colour, opacity) {
        this.lines.add(this.vertex(a, [0, 0, 0], colour, opacity),
            this.vertex(b, [0, 0, 0], colour, opacity));
    }
}

/* Outline of a section as rows [along d1, along d2, normal, normal], in halves of its sizes. */
function outlineOf(section, sides) {
    if (section === "rectangle") {
        return [[1, -1, 1, 0], [1, 1, 1, 0], [1, 1, 0, 1], [-1, 1, 0, 1], [-1, 1, -1, 0],
            [-1, -1, -1, 0], [-1, -1, 0, -1], [1, -1, 0, -1]];
    }
    const rows = [];
    for (let k = 0; k < sides; k++) {
        const c = Math.cos(2 * Math.PI * k / sides), s = Math.sin(2 * Math.PI * k / sides);
        rows.push([c, s, c, s]);
    }
    return rows;
}

/* A tube along a pose; half(k): [along d1, along d2]; colour(k): of point k. */
function tube(mesh, pose, outline, half, colour, opacity = 1,
    into = opacity < 1 ? mesh.clear : mesh.solid) {
    const sides = outline.length, points = pose.places.length, first = mesh.count;
    for (let k = 0; k < points; k++) {
        const [d1, d2] = pose.frames[k], p = pose.places[k], [a, b] = half(k), c = colour(k);
        for (let j = 0; j < sides; j++) {
            const [x, y, nx, ny] = outline[j], ax = a * x, by = b * y;
            mesh.point(p[0] + ax * d1[0] + by * d2[0], p[1] + ax * d1[1] + by * d2[1],
                p[2] + ax * d1[2] + by * d2[2], nx * d1[0] + ny * d2[0], nx * d1[1] + ny * d2[1],
                nx * d1[2] + ny * d2[2], c, opacity);
        }
    }
    for (let k = 0; k + 1 < points; k++) {
        for (let j = 0; j < sides; j++) {
            const a = first + k * sides + j, b = first + k * sides + (j + 1) % sides;
            into.add(a, b, b + sides, a, b + sides, a + sides);
        }
    }
    for (const [k, sign] of [[0, -1], [points - 1, 1]]) {
        const d3 = times(pose.frames[k][2], sign), c = colour(k);
        const centre = mesh.vertex(pose.places[k], d3, c, opacity);
        const rim = mesh.count;
        for (let j = 0; j < sides; j++) {
            const at = VERTEX_NUMBERS * (first + k * sides + j), v = mesh.vertices.data;
            mesh.point(v[at], v[at + 1], v[at + 2], d3[0], d3[1], d3[2], c, opacity);
        }
        for (let j = 0; j < sides; j++) {
            const a = rim + j, b = rim + (j + 1) % sides;
            into.add(centre, sign > 0 ? a : b, sign > 0 ? b : a);
        }
    }
}

const THIN = outlineOf("circle", 7);

/* A thin tube through places. */
function thread(mesh, places, radius, colour, opacity = 1) {
    if (places.length < 2) {
        return;
    }
    const frames = [];
    let d1 = null;
    for (let k = 0; k < places.length; k++) {
        const d3 = unitVector(minus(places[Math.min(k + 1, places.length - 1)],
            places[Math.max(k - 1, 0)]), [0, 0, 1]);
        d1 = d1 ? unitVector(minus(d1, times(d3, dot(d1, d3))), across(d3)) : across(d3);
        frames.push([d1, cross(d3, d1), d3]);
    }
    tube(mesh, { places, frames }, THIN, () => [radius, radius], () => colour, opacity);
}

/* From a place along a vector; of a moment with two heads. */
function arrow(mesh, from, vector, radius, colour, heads = 1) {
    const length = norm(vector);
    if (length < 2 * radius) {
        return;
    }
    const d3 = times(vector, 1 / length), d1 = across(d3), frame = [d1, cross(d3, d1), d3];
    const head = Math.min(6 * radius, 0.6 * length / heads);
    const outline = outlineOf("circle", 12);
    const along = h => add(from, times(d3, h));
    const piece = (a, b, wide, narrow) => tube(mesh,
        { places: [along(a), along(b)], frames: [frame, frame] }, outline,
        k => (k ? [narrow, narrow] : [wide, wide]), () => colour);
    piece(0, length - heads * head, radius, radius);
    for (let k = 0; k < heads; k++) {
        piece(length - (k + 1) * head, length - k * head, 2.6 * radius, 0);
    }
}

function ball(mesh, centre, radius, colour) {
    const rings = 10, sides = 18, first = mesh.count;
    for (let i = 0; i <= rings; i++) {
        for (let j = 0; j < sides; j++) {
            const a = Math.PI * i / rings, b = 2 * Math.PI * j / sides;
            const n = [Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a)];
            mesh.vertex(add(centre, times(n, radius)), n, colour);
        }
    }
    for (let i = 0; i < rings; i++) {
        for (let j = 0; j < sides; j++) {
            const a = first + i * sides + j, b = first + i * sides + (j + 1) % sides;
            mesh.solid.add(a, a + sides, b + sides, a, b + sides, b);
        }
    }
}

/* ---- colours ------------------------------------------------------------------------------- */

/* From dark to bright, of equal steps for the eye (viridis); and from one side over 0 to the other. */
const SEQUENTIAL = ["440154", "472d7b", "3b528b", "2c728e", "21918c", "28ae80", "5ec962", "addc30",
    "fde725"];
const DIVERGING = ["2166ac", "4393c3", "92c5de", "d1e5f0", "f2f2f2", "fddbc7", "f4a582", "d6604d",
    "b2182b"];

const rgb = hex => [0, 2, 4].map(k => parseInt(hex.replace("#", "").slice(k, k + 2), 16) / 255);

/* A map as colours to be looked up, so fine that no step is seen. */
const SHADES = 512;
function shadesOf(map) {
    return Array.from({ length: SHADES }, (_, i) => {
        const at = i / (SHADES - 1) * (map.length - 1), k = Math.min(Math.floor(at), map.length - 2);
        const a = rgb(map[k]), b = rgb(map[k + 1]);
        return a.map((x, d) => x + (b[d] - x) * (at - k));
    });
}
const UNKNOWN = [0.6, 0.6, 0.6];

function colourOf(shades, part) {
    return Number.isFinite(part)
        ? shades[Math.round(Math.min(1, Math.max(0, part)) * (SHADES - 1))] : UNKNOWN;
}
