"use strict";
/* What is seen at an instant: colours, the rod and all that is drawn beside it. */

const report = JSON.parse(document.getElementById("data").textContent);
const byId = id => document.getElementById(id);

/* "#time=0.2&colour=moment&hide=path,floor&size=900x600&theme=dark&play=1&file=2", to link to a
 * picture; file: of measured rows, from 0 on. */
const asked = new URLSearchParams(location.hash.slice(1));

/* Of a page of measured rows, residuals.js. */
const residuals = report.residuals ? new Residuals(report.residuals) : null;

/* ---- what can be shown as colour ----------------------------------------------------------- */

/* { name, unit, at(i), signed, parts: columns } with its range over the whole motion; first what
 * varies, and nothing that is 0. */
function quantitiesOf(motion) {
    const rows = [], constant = [];
    const offer = (name, unit, columns, value, signed) => {
        const from = columns.map(c => motion.find(c));
        if (!from.every(c => c)) {
            return;
        }
        const at = i => value(from.map(c => c.at(i)));
        let low = Infinity, high = -Infinity;
        for (let i = 0; i < motion.frames * motion.points; i++) {
            const x = at(i);
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        const most = Math.max(Math.abs(low), Math.abs(high));
        if (most > (unit ? 1e-12 : 1e-9)) {
            const varies = high - low > 1e-3 * most; /* columns are rounded */
            (varies ? rows : constant).push({ name, unit, at, signed, parts: from,
                low: varies ? low : Math.min(0, low), high: varies ? high : Math.max(0, high) });
        }
    };
    const size = v => Math.hypot(...v), first = v => v[0];
    offer("moment", "N m", ["m1", "m2", "m3"], size, false);
    offer("force", "N", ["n1", "n2", "n3"], size, false);
    offer("moment", "N m", ["M"], first, true);
    offer("shear force", "N", ["V"], first, true);
    offer("bending", "1/m", ["u1", "u2"], size, false);
    offer("twist", "1/m", ["u3"], first, true);
    offer("stretch", "", ["v3"], v => v[0] - 1, true);
    offer("shear", "", ["v1", "v2"], size, false);
    offer("speed", "m/s", ["vx", "vy", "vz"], size, false);
    const used = /^([xyzwMV]|q[wxyz]|v[xyz123]|u[123]|n[123]|m[123]|w[123]|radius)$/;
    for (const c of motion.columns) {
        if (!used.test(c.name)) {
            offer(c.name, c.unit, [c.name], first, true);
        }
    }
    return rows.concat(constant);
}

/* Which map of colours, and from where to where. */
function scaleOf(quantity) {
    if (quantity.signed && quantity.low < 0 && quantity.high > 0) {
        const most = Math.max(-quantity.low, quantity.high);
        return { map: DIVERGING, shades: DIVERGING_SHADES, low: -most, high: most };
    }
    return { map: SEQUENTIAL, shades: SEQUENTIAL_SHADES, low: quantity.signed ? quantity.low : Math.min(0, quantity.low),
        high: quantity.high };
}

const SEQUENTIAL_SHADES = shadesOf(SEQUENTIAL), DIVERGING_SHADES = shadesOf(DIVERGING);

/* ---- time ---------------------------------------------------------------------------------- */

const timeAt = (motion, at) => {
    const k = Math.min(Math.floor(at), motion.frames - 1), next = Math.min(k + 1, motion.frames - 1);
    return motion.t ? motion.t.at(k) + (at - k) * (motion.t.at(next) - motion.t.at(k)) : at;
};

function frameAt(motion, time) {
    if (!motion.t) {
        return Math.min(motion.frames - 1, Math.max(0, time));
    }
    let low = 0, high = motion.frames - 1;
    while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (motion.t.at(middle) <= time) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const wide = motion.t.at(high) - motion.t.at(low);
    return low + (wide > 0 ? Math.min(1, Math.max(0, (time - motion.t.at(low)) / wide)) : 0);
}

/* ---- colours of the theme ------------------------------------------------------------------ */

const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const themeColour = name => rgb(style(name));

function setTheme(name) {
    document.documentElement.dataset.theme = name;
}

/* ---- the picture --------------------------------------------------------------------------- */

class Picture {
    constructor(motion, reference, paths) {
        this.motion = motion;
        this.reference = reference;
        this.paths = paths; /* of a closed loop: wanted, then what was gone */
        this.scene = report.scene || null;
        this.workspace = null;
        this.residuals = residuals; /* null: nothing was measured */
        this.wanted = null; /* where a tip was dragged to */
        this.shown = { directors: false, loads: true, actuators: true, reference: true, path: true,
            floor: true, through: false, wall: true, markers: true };
        this.mesh = new Mesh();
        this.canvas = byId("picture");
        this.labels = byId("labels").getContext("2d");
        this.#read();
        this.#look();
        try {
            this.renderer = asked.has("canvas") ? new Painter(this.canvas) : new Gpu(this.canvas);
        } catch (why) {
            this.renderer = new Painter(this.canvas.cloneNode());
            this.canvas.replaceWith(this.renderer.canvas);
            this.canvas = this.renderer.canvas;
        }
        document.body.dataset.renderer = this.renderer.name;
        this.outline = null;
        this.detail = 1; /* pixels that are drawn over those that are there */
        this.pace = 0;
    }

    /* Sizes and loads of the scene. */
    #read() {
        const scene = this.scene;
        const load = from => ({ ...from, vector: from.vector.map(column) });
        this.arrows = scene ? scene.arrows.map(load) : [];
        this.guided = scene ? scene.guided.map(g => ({ ...g, offset: g.offset.map(column),
            acts: column(g.acts[0]) })) : [];
        const radius = this.motion.find("radius");
        this.half = scene ? scene.half.map(column) : radius ? [radius, radius] : null;
        this.wall = report.wall && { places: report.wall.places.map(column),
            of: report.wall.of.map(column) };
        this.most = {}; /* of the vectors, by unit */
        for (const a of this.arrows) {
            for (let f = 0; f < this.motion.frames; f++) {
                const size = norm(a.vector.map(c => c.at(f)));
                this.most[a.unit] = Math.max(this.most[a.unit] || 0, size);
            }
        }
    }

    /* Where a load acts, and its vector in the world. */
    #loadAt(load, pose, frame) {
        const { place, frame: axes } = poseAt(pose, this.motion.s, load.s);
        let vector = load.vector.map(c => c.at(frame));
        if (load.frame === "follower") {
            vector = [0, 1, 2].map(k => axes.reduce((sum, d, i) => sum + d[k] * vector[i], 0));
        }
        return { place, vector };
    }

    /* How long one unit of it is drawn, over the size of the picture. */
    #reach(load) {
        return (/\/m$/.test(load.unit) ? 0.12 : 0.2) / (this.most[load.unit] || 1);
    }

    /* The camera: all of the motion in view, across the plane in which it mostly is. */
    #look() {
        const seen = [];
        for (const motion of [this.motion, this.reference, ...this.paths]) {
            const steps = motion ? Math.ceil(motion.frames / 60) : 0;
            for (let f = 0; motion && f < motion.frames; f += steps) {
                for (let k = 0; k < motion.points; k += Math.ceil(motion.points / 40)) {
                    seen.push(motion.placeAt(f, k));
                }
                seen.push(motion.placeAt(f, motion.points - 1));
            }
        }
        for (const load of this.arrows) {
            const steps = Math.ceil(this.motion.frames / 20);
            for (let f = 0; f < this.motion.frames; f += steps) {
                const { place, vector } = this.#loadAt(load, this.motion.pose(f), f);
                seen.push(add(place, times(vector, this.#reach(load) * this.motion.span)));
            }
        }
        const tips = report.workspace ? report.workspace.columns.slice(0, 3).map(column) : null;
        for (let i = 0; tips && i < report.workspace.rows; i += 10) {
            seen.push(tips.map(c => c.at(i)));
        }
        seen.push(...(this.residuals ? this.residuals.placesSeen() : []));
        const wall = report.wall;
        for (let i = 0; wall && i < wall.corners; i += Math.ceil(wall.corners / 500)) {
            seen.push(this.wall.places.map(c => c.at(i)));
        }
        const places = seen.filter(p => p.every(Number.isFinite));
        const low = [0, 1, 2].map(k => Math.min(...places.map(p => p[k])));
        const high = [0, 1, 2].map(k => Math.max(...places.map(p => p[k])));
        this.extent = [Math.min(...low), Math.max(...high)];
        const size = norm(minus(high, low)) || 1, centre = times(add(low, high), 0.5);
        const gravity = this.scene ? this.scene.gravity : [0, 0, 0];
        const flat = high[2] - low[2] < 1e-6 * size;
        const up = norm(gravity) > 0 ? unitVector(times(gravity, -1)) : flat ? [0, 1, 0] : [0, 0, 1];
        const camera = new Camera(centre, up, 0, 0.26, size);
        let a = 0, b = 0, c = 0;
        for (const p of places) {
            const x = dot(minus(p, centre), camera.side), y = dot(minus(p, centre), camera.front);
            a += x * x;
            b += x * y;
            c += y * y;
        }
        let azimuth = 0.5 * Math.atan2(2 * b, a - c) + Math.PI / 2;
        camera.azimuth = azimuth;
        const along = minus(this.motion.placeAt(0, this.motion.points - 1), this.motion.placeAt(0, 0));
        if (dot(camera.axes()[0], along) < -1e-9 * size) {
            azimuth += Math.PI;
        }
        camera.home.azimuth = camera.azimuth = azimuth - 0.42;
        this.camera = camera;
        this.places = places;
        this.size = size;
        const thickest = this.half ? Math.max(...this.half.map(h => h.high)) : 0;
        this.thicker = thickest > 0 ? Math.max(1, 0.006 * size / thickest) : 1;
        this.radius = thickest > 0 ? thickest * this.thicker : 0.01 * size;
        this.floor = Math.min(...places.map(p => dot(p, up))) - 0.05 * size - this.radius;
        const inside = this.guided.some(g => Math.max(...g.offset.map(o => Math.max(-o.low, o.high)))
            < thickest * this.thicker);
        this.shown.through = inside || this.residuals !== null;
        for (const name of (asked.get("hide") || "").split(",")) {
            this.shown[name] = false;
        }
    }

    /* Where pictures come too slowly, as without a graphics processor, those that move are coarser;
     * `passed` ms since the last one. */
    keepUp(passed) {
        const slow = 35, least = 0.4;
        this.pace += (passed - this.pace) / 8;
        if (this.pace > slow && this.detail > least) {
            this.detail = Math.max(least, 0.8 * this.detail);
            this.pace = 0;
            this.#sizeCanvas();
        }
        document.body.dataset.detail = this.detail.toFixed(2);
    }

    rest() {
        this.pace = 0;
        this.detail = 1;
        this.#sizeCanvas();
    }

    #sizeCanvas() {
        const box = byId("stage").getBoundingClientRect();
        this.canvas.width = Math.round(box.width * this.pixels * this.detail);
        this.canvas.height = Math.round(box.height * this.pixels * this.detail);
    }

    resize() {
        const box = byId("stage").getBoundingClientRect(), pixels = window.devicePixelRatio || 1;
        this.labels.canvas.width = Math.round(box.width * pixels);
        this.labels.canvas.height = Math.round(box.height * pixels);
        const camera = this.camera, isHome = camera.distance === camera.home.distance;
        this.pixels = pixels;
        this.#sizeCanvas();
        camera.width = box.width;
        camera.height = box.height;
        camera.home.distance = camera.fit(this.places, this.radius, 0.76);
        if (isHome || !this.wasFitted) {
            camera.distance = camera.home.distance;
            this.wasFitted = true;
        }
    }

    halfAt(k) {
        if (!this.half) {
            return [this.radius, this.radius];
        }
        const sizes = this.half.map(h => h.at(k) * this.thicker);
        return sizes.map(x => (x > 0 ? x : this.radius));
    }

    draw(at, quantity) {
        const mesh = this.mesh, motion = this.motion, pose = motion.pose(at);
        const frame = Math.min(Math.round(at), motion.frames - 1);
        const plain = themeColour("--curve0");
        const scale = quantity && scaleOf(quantity);
        this.pose = pose;
        this.frame = frame;
        this.tags = [];
        mesh.begin();
        if (this.shown.floor) {
            this.#drawFloor();
        }
        this.outline = outlineOf(this.scene ? this.scene.section : "circle",
            this.renderer.name === "canvas" ? 10 : 24);
        if (motion.points > 1) {
            const into = this.shown.through ? mesh.clear : mesh.solid, from = into.count;
            tube(mesh, pose, this.outline, k => this.halfAt(k), k => (quantity
                ? colourOf(scale.shades, (quantity.at(frame * motion.points + k) - scale.low)
                    / (scale.high - scale.low)) : plain), this.shown.through ? 0.45 : 1);
            if (this.shown.floor) {
                mesh.shadow = { of: into, from, to: into.count };
            }
            this.#drawEnds(pose);
        } else {
            ball(mesh, pose.places[0], 0.014 * this.size, plain);
        }
        if (this.shown.reference && this.reference) {
            this.#drawReference(at);
        }
        if (this.shown.path && motion.t && motion.frames > 1) {
            this.#drawPaths(at);
        }
        if (this.shown.directors && motion.points > 1) {
            this.#drawDirectors(pose);
        }
        if (this.shown.loads) {
            this.#drawLoads(pose, frame);
        }
        if (this.shown.actuators) {
            this.#drawActuators(pose);
        }
        if (this.residuals && this.shown.markers) {
            this.residuals.drawMarkers(this, frame);
        }
        if (this.wall && this.shown.wall) {
            this.#drawWall();
        }
        this.renderer.draw(mesh, this.camera, this.floor);
        this.#drawLabels();
    }

    /* Each triangle by itself: walls have edges. */
    #drawWall() {
        const mesh = this.mesh, { places, of } = this.wall, colour = themeColour("--soft");
        for (let i = 0; i < report.wall.triangles; i++) {
            const [a, b, c] = of.map(corner => places.map(p => p.at(corner.at(i))));
            const n = unitVector(cross(minus(b, a), minus(c, a)), [0, 0, 1]);
            mesh.clear.add(...[a, b, c].map(p => mesh.vertex(p, n, colour, 0.14)));
        }
    }

    #drawFloor() {
        const { up, side, front } = this.camera, mesh = this.mesh;
        const home = this.camera.home.target;
        const step = round125(this.size / 8), reach = 1.1 * this.size, colour = themeColour("--soft");
        const centre = add(home, times(up, this.floor - dot(home, up)));
        const snap = d => Math.round(dot(centre, d) / step) * step - dot(centre, d);
        const lines = Math.ceil(reach / step);
        this.step = step;
        for (const [along, over] of [[side, front], [front, side]]) {
            for (let k = -lines; k <= lines; k++) {
                const offset = k * step + snap(along);
                const far = 1 - Math.abs(offset) / reach;
                if (far <= 0) {
                    continue;
                }
                const half = Math.sqrt(Math.max(0, reach * reach - offset * offset));
                const from = add(centre, times(along, offset));
                const pieces = 8; /* fading outwards */
                for (let j = -pieces; j < pieces; j++) {
                    const a = add(from, times(over, half * j / pieces));
                    const b = add(from, times(over, half * (j + 1) / pieces));
                    const fade = far * (1 - Math.abs(j + 0.5) / pieces);
                    mesh.line(a, b, colour, 0.55 * fade);
                }
            }
        }
    }

    /* A plate where an end is clamped, a ball where it is pinned. */
    #drawEnds(pose) {
        const scene = this.scene, last = pose.places.length - 1, colour = [0.45, 0.48, 0.53];
        for (const [type, k, sign] of scene ? [[scene.start, 0, -1], [scene.end, last, 1]] : []) {
            const wide = Math.min(2.6 * Math.max(...this.halfAt(k)),
                Math.max(...this.halfAt(k)) + 0.05 * this.size);
            const thick = 0.35 * wide, d3 = times(pose.frames[k][2], sign);
            if (/clamped|driven|guided/.test(type)) {
                const from = pose.places[k];
                tube(this.mesh, { places: [from, add(from, times(d3, thick))],
                    frames: [pose.frames[k], pose.frames[k]] }, outlineOf("circle", 28),
                () => [wide, wide], () => colour);
            } else if (/pinned|roller/.test(type)) {
                ball(this.mesh, pose.places[k], 1.5 * Math.max(...this.halfAt(k)), colour);
            }
        }
        for (const body of scene ? scene.bodies : []) {
            ball(this.mesh, poseAt(pose, this.motion.s, body.s).place, body.radius,
                [0.35, 0.37, 0.42]);
        }
    }

    #drawReference(at) {
        const other = this.reference, colour = themeColour("--curve1");
        let frame = 0;
        if (other.t && other.frames > 1 && this.motion.t) {
            frame = frameAt(other, timeAt(this.motion, at));
        }
        if (other.points === 1) {
            this.#drawPath(other, other.frames - 1, colour);
            ball(this.mesh, other.pose(frame).places[0], 0.012 * this.size, colour);
            return;
        }
        const wide = this.radius + Math.min(0.012 * this.size,
            Math.max(0.5 * this.radius, 0.004 * this.size));
        tube(this.mesh, other.pose(frame), outlineOf("circle", 20), () => [wide, wide],
            () => colour, 0.45, this.mesh.halo);
    }

    /* Of the tip; of a closed loop where its place was to be, and where it was. */
    #drawPaths(at) {
        if (this.paths.length === 0) {
            this.#drawPath(this.motion, at, themeColour("--ink"));
            return;
        }
        const time = timeAt(this.motion, at), [wanted, gone] = this.paths;
        const colour = themeColour("--curve2");
        thread(this.mesh, wanted.way(0, wanted.frames - 1), 0.0028 * this.size, colour, 0.55);
        ball(this.mesh, wanted.placeBetween(frameAt(wanted, time), 0), 0.009 * this.size, colour);
        this.#drawPath(gone, frameAt(gone, time), themeColour("--ink"));
    }

    /* The way of the last point, until now in full. */
    #drawPath(motion, at, colour) {
        const now = Math.floor(at), last = motion.frames - 1, radius = 0.0016 * this.size;
        const place = motion.placeBetween(at, motion.points - 1);
        thread(this.mesh, motion.way(0, now).concat([place]), radius, colour);
        thread(this.mesh, [place].concat(motion.way(now + 1, last)), 0.6 * radius, colour, 0.35);
    }

    #drawDirectors(pose) {
        const colours = [[0.84, 0.24, 0.22], [0.20, 0.62, 0.30], [0.16, 0.42, 0.80]];
        const count = Math.min(9, pose.places.length);
        for (let j = 0; j < count; j++) {
            const k = Math.round(j * (pose.places.length - 1) / (count - 1 || 1));
            pose.frames[k].forEach((d, i) => arrow(this.mesh, pose.places[k],
                times(d, 0.065 * this.size + this.radius), 0.0022 * this.size, colours[i]));
        }
    }

    #drawLoads(pose, frame) {
        for (const load of this.arrows) {
            const { place, vector } = this.#loadAt(load, pose, frame);
            const most = this.most[load.unit], size = norm(vector);
            const isLine = /\/m$/.test(load.unit), isMoment = /^N m/.test(load.unit);
            if (!(most > 0) || !(size > 1e-9 * most)) {
                continue;
            }
            const seen = times(vector, this.#reach(load) * this.size);
            const colour = isMoment ? [0.55, 0.30, 0.68] : [0.80, 0.22, 0.18];
            arrow(this.mesh, place, seen, (isLine ? 0.0022 : 0.0042) * this.size, colour,
                isMoment ? 2 : 1);
            if (!isLine || load.s === 0) {
                this.tags.push([add(place, seen), withUnit(size, load.unit, 3)]);
            }
        }
    }

    #drawActuators(pose) {
        const arc = this.motion.s;
        for (const g of this.guided) {
            const places = [];
            for (let k = 0; k < this.motion.points; k++) {
                if (arc.at(k) >= g.start - 1e-9 && arc.at(k) <= g.end + 1e-9) {
                    const [d1, d2] = pose.frames[k];
                    places.push(add(pose.places[k], add(times(d1, g.offset[0].at(k)),
                        times(d2, g.offset[1].at(k)))));
                }
            }
            const acts = g.acts.at(this.frame), part = Math.abs(acts) / (Math.max(
                Math.abs(g.acts.low), Math.abs(g.acts.high)) || 1);
            const base = g.kind === "tendon" ? [0.93, 0.55, 0.10] : [0.10, 0.62, 0.78];
            const colour = base.map(x => x * (0.45 + 0.55 * part));
            thread(this.mesh, places, (g.kind === "tendon" ? 0.0028 : 0.006) * this.size, colour);
            if (acts !== 0 && places.length) {
                this.tags.push([places[places.length - 1], withUnit(acts, g.acts.unit, 3)]);
            }
        }
    }

    /* Axes, the scale, and what the arrows are. */
    #drawLabels() {
        const c = this.labels, camera = this.camera, ink = style("--ink"), soft = style("--soft");
        c.setTransform(this.pixels, 0, 0, this.pixels, 0, 0);
        c.clearRect(0, 0, camera.width, camera.height);
        c.font = "12px system-ui, sans-serif";
        c.textBaseline = "middle";
        c.lineJoin = "round";
        const write = (text, x, y, colour, align = "left") => {
            c.textAlign = align;
            c.lineWidth = 4;
            c.strokeStyle = style("--sky");
            c.strokeText(text, x, y);
            c.fillStyle = colour;
            c.fillText(text, x, y);
        };
        if (this.workspace) {
            this.workspace.draw(c, camera);
        }
        if (this.wanted) {
            const [x, y] = camera.project(this.wanted);
            const [tipX, tipY] = camera.project(this.pose.places[this.pose.places.length - 1]);
            c.strokeStyle = ink;
            c.lineWidth = 1.5;
            c.beginPath();
            c.moveTo(tipX, tipY);
            c.lineTo(x, y);
            c.moveTo(x + 5, y);
            c.arc(x, y, 5, 0, 2 * Math.PI);
            c.stroke();
        }
        const axes = camera.axes();
        const gizmo = ["x", "y", "z"].map((name, k) => ({ name, x: axes[0][k], y: axes[1][k],
            z: axes[2][k], colour: ["#d33d38", "#2f9e4c", "#2b6bd0"][k] }));
        for (const a of gizmo.sort((p, q) => p.z - q.z)) {
            c.strokeStyle = a.colour;
            c.lineWidth = 2.2;
            c.beginPath();
            c.moveTo(48, camera.height - 48);
            c.lineTo(48 + 28 * a.x, camera.height - 48 - 28 * a.y);
            c.stroke();
            write(a.name, 48 + 37 * a.x, camera.height - 48 - 37 * a.y, a.colour, "center");
        }
        const perMetre = camera.height / (2 * LENS * camera.distance);
        const bar = round125(110 / perMetre), right = camera.width - 18, low = camera.height - 22;
        c.strokeStyle = ink;
        c.lineWidth = 2;
        c.beginPath();
        c.moveTo(right - bar * perMetre, low - 4);
        c.lineTo(right - bar * perMetre, low);
        c.lineTo(right, low);
        c.lineTo(right, low - 4);
        c.stroke();
        write(withUnit(bar, "m"), right - bar * perMetre / 2, low - 12, ink, "center");
        if (this.shown.floor) {
            write("grid " + withUnit(this.step, "m"), right, low + 12, soft, "right");
        }
        const written = []; /* one below the other, where they would meet */
        for (const [place, text] of this.tags) {
            let [x, y] = camera.project(place);
            x = Math.min(x, camera.width - c.measureText(text).width - 14);
            while (written.some(w => Math.abs(w[0] - x) < 70 && Math.abs(w[1] - y) < 15)) {
                y += 4;
            }
            written.push([x, y]);
            write(text, x + 10, y - 8, ink);
        }
    }

    /* What tests compare the picture with: where it is on the page, and from where it is seen. */
    describe() {
        const { target, distance, width, height } = this.camera;
        const box = this.labels.canvas.getBoundingClientRect();
        document.body.dataset.camera = JSON.stringify({ target, distance, width, height, lens: LENS,
            axes: this.camera.axes(), left: box.left + scrollX, top: box.top + scrollY });
    }

    /* The point under the mouse; -1: none is near. */
    pointAt(x, y) {
        let found = -1, least = 26;
        this.pose.places.forEach((p, k) => {
            const [px, py] = this.camera.project(p), off = Math.hypot(px - x, py - y);
            if (off < least) {
                least = off;
                found = k;
            }
        });
        return found;
    }
}
