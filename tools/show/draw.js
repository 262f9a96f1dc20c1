"use strict";
/* The camera, and two ways to draw a mesh: WebGL 2, and where that is missing a plain canvas. */

const LENS = Math.tan(0.26); /* half the opening of the view */

/* Looks at `target` from a distance; `up` is a unit vector. */
class Camera {
    constructor(target, up, azimuth, elevation, distance) {
        this.home = { target, azimuth, elevation, distance };
        this.up = up;
        this.side = across(up);
        this.front = cross(up, this.side);
        this.width = this.height = 1;
        this.reset();
    }

    reset() {
        Object.assign(this, this.home);
    }

    /* Axes of the picture: to the right, upwards, towards the eye. */
    axes() {
        const c = Math.cos(this.elevation), s = Math.sin(this.elevation);
        const level = add(times(this.side, Math.cos(this.azimuth)),
            times(this.front, Math.sin(this.azimuth)));
        const back = add(times(level, c), times(this.up, s));
        const right = cross(this.up, level);
        return [right, cross(back, right), back];
    }

    turn(dx, dy) {
        this.azimuth -= dx;
        this.elevation = Math.min(1.55, Math.max(-1.55, this.elevation + dy));
    }

    move(dx, dy) {
        const [right, up] = this.axes(), scale = 2 * LENS * this.distance / this.height;
        this.target = add(this.target, add(times(right, -dx * scale), times(up, dy * scale)));
    }

    zoom(factor) {
        this.distance = Math.min(20, Math.max(0.05, this.distance * factor / this.home.distance))
            * this.home.distance;
    }

    /* How far to be for all places and what is `radius` around them to be seen, `room`: in which
     * part of the picture. */
    fit(places, radius, room) {
        const [right, up, back] = this.axes(), wide = this.width / this.height;
        let distance = 0;
        for (const p of places) {
            const from = minus(p, this.target);
            const depth = dot(from, back);
            distance = Math.max(distance, depth + (Math.abs(dot(from, up)) + radius) / (LENS * room),
                depth + (Math.abs(dot(from, right)) + radius) / (LENS * room * wide));
        }
        return distance || 3 * (this.home.distance || 1); /* of a single place */
    }

    /* [x, y, depth] in pixels of the page from the upper left; depth in m. */
    project(p) {
        const [right, up, back] = this.axes(), from = minus(p, this.target);
        const depth = this.distance - dot(from, back);
        const scale = this.height / (2 * LENS * depth);
        return [this.width / 2 + dot(from, right) * scale, this.height / 2 - dot(from, up) * scale,
            depth];
    }

    /* And back. */
    placeOf([x, y, depth]) {
        const [right, up, back] = this.axes(), scale = 2 * LENS * depth / this.height;
        const across = add(times(right, (x - this.width / 2) * scale),
            times(up, (this.height / 2 - y) * scale));
        return add(add(this.target, across), times(back, this.distance - depth));
    }

    /* What takes the world to clip space, by columns. */
    matrix() {
        const [r, u, b] = this.axes(), t = this.target;
        const near = 0.02 * this.distance, far = 30 * this.distance;
        const sx = this.height / (LENS * this.width), sy = 1 / LENS;
        const depth = (far + near) / (far - near), shift = 2 * far * near / (far - near);
        const view = [-dot(r, t), -dot(u, t), -dot(b, t) - this.distance];
        const m = [];
        for (let k = 0; k < 3; k++) {
            m.push(sx * r[k], sy * u[k], -depth * b[k], -b[k]);
        }
        m.push(sx * view[0], sy * view[1], -depth * view[2] - shift, -view[2]);
        return new Float32Array(m);
    }
}

/* Over the shoulder of the eye. */
const keyLight = (right, up, back) => unitVector(
    add(add(times(back, 0.75), times(up, 0.85)), times(right, -0.45)));

/* Twice that of a triangle of the picture; below 0: it is seen from outside. */
const area = (px, py, qx, qy, rx, ry) => (qx - px) * (ry - py) - (qy - py) * (rx - px);

/* ---- WebGL --------------------------------------------------------------------------------- */

const VERTEX = `#version 300 es
in vec3 place; in vec3 normal; in vec4 colour;
uniform mat4 matrix;
uniform vec3 up;
uniform float floorAt, shadow;
out vec3 turned; out vec4 shade; out vec3 at;
void main() {
    gl_Position = matrix * vec4(place + shadow * (floorAt - dot(place, up)) * up, 1.0);
    turned = normal; shade = colour; at = place;
}`;

/* A key light over the shoulder of the eye, one from behind, and a highlight. */
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 turned; in vec4 shade; in vec3 at;
uniform vec3 eye, key, up;
uniform float shadow;
out vec4 result;
void main() {
    if (shadow > 0.0) {
        result = vec4(0.0, 0.0, 0.0, 0.16);
        return;
    }
    vec3 colour = shade.rgb;
    if (dot(turned, turned) > 0.25) {
        vec3 n = normalize(turned), view = normalize(eye - at);
        if (dot(n, view) < 0.0) n = -n;
        float sky = 0.5 + 0.5 * dot(n, up);
        float light = 0.52 + 0.20 * sky + 0.46 * max(dot(n, key), 0.0);
        float edge = pow(1.0 - max(dot(n, view), 0.0), 3.0);
        float shine = pow(max(dot(n, normalize(key + view)), 0.0), 48.0);
        colour = colour * light * (1.0 - 0.35 * edge) + vec3(0.28 * shine);
    }
    result = vec4(colour * shade.a, shade.a);
}`;

class Gpu {
    constructor(canvas) {
        const gl = canvas.getContext("webgl2", { antialias: true, stencil: true });
        if (!gl) {
            throw new Error("no WebGL 2");
        }
        this.name = "webgl2";
        this.gl = gl;
        this.canvas = canvas;
        const program = gl.createProgram();
        for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
            const shader = gl.createShader(kind);
            gl.shaderSource(shader, text);
            gl.compileShader(shader);
            if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
                throw new Error(gl.getShaderInfoLog(shader));
            }
            gl.attachShader(program, shader);
        }
        gl.linkProgram(program);
        gl.useProgram(program);
        this.uniform = {};
        for (const name of ["matrix", "eye", "key", "up", "floorAt", "shadow"]) {
            this.uniform[name] = gl.getUniformLocation(program, name);
        }
        gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
        for (const [name, size, from] of [["place", 3, 0], ["normal", 3, 12], ["colour", 4, 24]]) {
            const at = gl.getAttribLocation(program, name);
            gl.enableVertexAttribArray(at);
            gl.vertexAttribPointer(at, size, gl.FLOAT, false, 40, from);
        }
        gl.enable(gl.DEPTH_TEST);
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    }

    draw(mesh, camera, floor) {
        const gl = this.gl, uniform = this.uniform, [right, up, back] = camera.axes();
        const eye = add(camera.target, times(back, camera.distance));
        gl.viewport(0, 0, this.canvas.width, this.canvas.height);
        gl.clearColor(0, 0, 0, 0);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
        gl.uniformMatrix4fv(uniform.matrix, false, camera.matrix());
        gl.uniform3fv(uniform.eye, eye);
        gl.uniform3fv(uniform.key, keyLight(right, up, back));
        gl.uniform3fv(uniform.up, camera.up);
        gl.uniform1f(uniform.floorAt, floor);
        gl.bufferData(gl.ARRAY_BUFFER, mesh.vertices.used(), gl.DYNAMIC_DRAW);
        this.#part(mesh.lines.used(), gl.LINES, false);
        this.#shadow(mesh.shadow);
        gl.enable(gl.CULL_FACE);
        gl.cullFace(gl.BACK);
        this.#part(mesh.solid.used(), gl.TRIANGLES, true);
        gl.cullFace(gl.FRONT);
        this.#part(mesh.halo.used(), gl.TRIANGLES, false);
        gl.disable(gl.CULL_FACE);
        this.#part(mesh.clear.used(), gl.TRIANGLES, false);
    }

    #part(indices, kind, depth) {
        const gl = this.gl;
        gl.depthMask(depth);
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.DYNAMIC_DRAW);
        gl.drawElements(kind, indices.length, gl.UNSIGNED_INT, 0);
        gl.depthMask(true);
    }

    /* On the floor, each pixel once. */
    #shadow(thrown) {
        const gl = this.gl;
        if (thrown) {
            gl.uniform1f(this.uniform.shadow, 1);
            gl.enable(gl.STENCIL_TEST);
            gl.stencilFunc(gl.EQUAL, 0, 255);
            gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
            this.#part(thrown.of.data.subarray(thrown.from, thrown.to), gl.TRIANGLES, false);
            gl.disable(gl.STENCIL_TEST);
            gl.uniform1f(this.uniform.shadow, 0);
        }
    }
}

/* ---- a plain canvas ------------------------------------------------------------------------ */

/* Triangles from the far to the near ones, each of one colour. */
class Painter {
    constructor(canvas) {
        this.name = "canvas";
        this.canvas = canvas;
        this.context = canvas.getContext("2d");
    }

    draw(mesh, camera, floor) {
        const c = this.context, axes = camera.axes(), key = keyLight(...axes);
        const scale = this.canvas.width / camera.width;
        this.#see(mesh, camera, axes);
        c.setTransform(scale, 0, 0, scale, 0, 0);
        c.clearRect(0, 0, camera.width, camera.height);
        this.#lines(mesh);
        this.#shadow(mesh, camera, floor);
        this.#triangles(mesh, camera, axes[2], key);
    }

    /* x, y, depth of all vertices. */
    #see(mesh, camera, [right, up, back]) {
        const v = mesh.vertices.data, t = camera.target, wide = camera.width / 2;
        const high = camera.height / 2, lens = camera.height / (2 * LENS);
        if (!this.seen || this.seen.length < 3 * mesh.count) {
            this.seen = new Float32Array(4 * mesh.count);
        }
        for (let i = 0; i < mesh.count; i++) {
            const at = VERTEX_NUMBERS * i;
            const x = v[at] - t[0], y = v[at + 1] - t[1], z = v[at + 2] - t[2];
            const depth = camera.distance - (x * back[0] + y * back[1] + z * back[2]);
            this.seen[3 * i] = wide + (x * right[0] + y * right[1] + z * right[2]) * lens / depth;
            this.seen[3 * i + 1] = high - (x * up[0] + y * up[1] + z * up[2]) * lens / depth;
            this.seen[3 * i + 2] = depth;
        }
    }

    /* Of the same opacity in one path: there are many. */
    #lines(mesh) {
        const c = this.context, seen = this.seen, v = mesh.vertices.data, lines = mesh.lines.used();
        const paths = new Map();
        for (let k = 0; k < lines.length; k += 2) {
            const a = lines[k], b = lines[k + 1], at = VERTEX_NUMBERS * a;
            const colour = this.#rgba(v, at, 1, Math.round(v[at + 9] * 10) / 10);
            const path = paths.get(colour) || new Path2D();
            paths.set(colour, path);
            path.moveTo(seen[3 * a], seen[3 * a + 1]);
            path.lineTo(seen[3 * b], seen[3 * b + 1]);
        }
        for (const [colour, path] of paths) {
            c.strokeStyle = colour;
            c.stroke(path);
        }
    }

    #shadow(mesh, camera, floor) {
        const c = this.context, v = mesh.vertices.data, thrown = mesh.shadow;
        if (!thrown) {
            return;
        }
        c.fillStyle = "rgba(0,0,0,0.16)";
        c.beginPath();
        for (let k = thrown.from; k < thrown.to; k += 3) {
            const [p, q, r] = [0, 1, 2].map(j => {
                const at = VERTEX_NUMBERS * thrown.of.data[k + j];
                const place = [v[at], v[at + 1], v[at + 2]];
                return camera.project(add(place, times(camera.up, floor - dot(place, camera.up))));
            });
            if (area(p[0], p[1], q[0], q[1], r[0], r[1]) < 0) { /* the others are above these */
                c.moveTo(p[0], p[1]);
                c.lineTo(q[0], q[1]);
                c.lineTo(r[0], r[1]);
            }
        }
        c.fill();
    }

    #rgba(v, at, light, opacity) {
        const part = k => Math.round(255 * Math.min(1, v[at + k] * light));
        return `rgba(${part(6)},${part(7)},${part(8)},${opacity})`;
    }

    #shade(v, i, camera, back, key) {
        const at = VERTEX_NUMBERS * i, x = v[at + 3], y = v[at + 4], z = v[at + 5];
        const towards = x * back[0] + y * back[1] + z * back[2] < 0 ? -1 : 1;
        const light = x * x + y * y + z * z < 0.25 ? 1
            : 0.5 + 0.1 * towards * (x * camera.up[0] + y * camera.up[1] + z * camera.up[2])
                + 0.5 * Math.max(0, towards * (x * key[0] + y * key[1] + z * key[2]));
        return this.#rgba(v, at, light, v[at + 9]);
    }

    /* Those of the halo first, then the others from the far to the near ones. */
    #triangles(mesh, camera, back, key) {
        const c = this.context, seen = this.seen, v = mesh.vertices.data, order = [];
        for (const part of [mesh.halo, mesh.solid, mesh.clear]) {
            const all = part.used();
            for (let k = 0; k < all.length; k += 3) {
                const p = 3 * all[k], q = 3 * all[k + 1], r = 3 * all[k + 2];
                const turns = area(seen[p], seen[p + 1], seen[q], seen[q + 1], seen[r], seen[r + 1]);
                if (part === mesh.clear || (part === mesh.solid) === (turns < 0)) {
                    order.push({ p, q, r, depth: seen[p + 2] + seen[q + 2] + seen[r + 2]
                        + (part === mesh.halo ? 1e9 : 0) });
                }
            }
        }
        order.sort((a, b) => b.depth - a.depth);
        for (const { p, q, r } of order) {
            c.fillStyle = c.strokeStyle = this.#shade(v, p / 3, camera, back, key);
            c.beginPath();
            c.moveTo(seen[p], seen[p + 1]);
            c.lineTo(seen[q], seen[q + 1]);
            c.lineTo(seen[r], seen[r + 1]);
            c.closePath();
            c.fill();
            if (v[VERTEX_NUMBERS * p / 3 + 9] === 1) {
                c.stroke(); /* or the seams would show */
            }
        }
    }
}
