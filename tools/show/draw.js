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

    /* How far to be for all places to be seen, `room`: in which part of the picture. */
    fit(places, room) {
        const [right, up, back] = this.axes(), wide = this.width / this.height;
        let distance = 0;
        for (const p of places) {
            const from = minus(p, this.target);
            const depth = dot(from, back);
            distance = Math.max(distance, depth + Math.abs(dot(from, up)) / (LENS * room),
                depth + Math.abs(dot(from, right)) / (LENS * room * wide));
        }
        return distance;
    }

    /* [x, y, depth] in pixels of the page from the upper left; depth in m. */
    project(p) {
        const [right, up, back] = this.axes(), from = minus(p, this.target);
        const depth = this.distance - dot(from, back);
        const scale = this.height / (2 * LENS * depth);
        return [this.width / 2 + dot(from, right) * scale, this.height / 2 - dot(from, up) * scale,
            depth];
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

/* ---- WebGL --------------------------------------------------------------------------------- */

const VERTEX = `#version 300 es
in vec3 place; in vec3 normal; in vec4 colour;
uniform mat4 matrix;
out vec3 turned; out vec4 shade; out vec3 at;
void main() {
    gl_Position = matrix * vec4(place, 1.0);
    turned = normal; shade = colour; at = place;
}`;

/* A key light over the shoulder of the eye, one from behind, and a highlight. */
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 turned; in vec4 shade; in vec3 at;
uniform vec3 eye, key, up;
out vec4 result;
void main() {
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
        const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
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
        this.uniform = name => gl.getUniformLocation(program, name);
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

    draw(mesh, camera) {
        const gl = this.gl, [right, up, back] = camera.axes();
        const eye = add(camera.target, times(back, camera.distance));
        const key = unitVector(add(add(times(back, 0.75), times(up, 0.85)), times(right, -0.45)));
        gl.viewport(0, 0, this.canvas.width, this.canvas.height);
        gl.clearColor(0, 0, 0, 0);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        gl.uniformMatrix4fv(this.uniform("matrix"), false, camera.matrix());
        gl.uniform3fv(this.uniform("eye"), eye);
        gl.uniform3fv(this.uniform("key"), key);
        gl.uniform3fv(this.uniform("up"), camera.up);
        gl.bufferData(gl.ARRAY_BUFFER, mesh.vertices.subarray(0, 10 * mesh.count), gl.DYNAMIC_DRAW);
        const parts = [[mesh.lines, gl.LINES, false], [mesh.solid, gl.TRIANGLES, true],
            [mesh.halo, gl.TRIANGLES, false], [mesh.clear, gl.TRIANGLES, false]];
        gl.cullFace(gl.FRONT);
        for (const [indices, kind, depth] of parts) {
            gl.depthMask(depth);
            (indices === mesh.halo ? gl.enable : gl.disable).call(gl, gl.CULL_FACE);
            gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.DYNAMIC_DRAW);
            gl.drawElements(kind, indices.length, gl.UNSIGNED_INT, 0);
        }
        gl.depthMask(true);
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

    draw(mesh, camera) {
        const c = this.context, v = mesh.vertices, [right, up, back] = camera.axes();
        const key = unitVector(add(add(times(back, 0.75), times(up, 0.85)), times(right, -0.45)));
        const scale = this.canvas.width / camera.width;
        const seen = [];
        for (let i = 0; i < mesh.count; i++) {
            seen.push(camera.project([v[10 * i], v[10 * i + 1], v[10 * i + 2]]));
        }
        const shade = i => {
            const n = [v[10 * i + 3], v[10 * i + 4], v[10 * i + 5]];
            const towards = dot(n, back) < 0 ? -1 : 1;
            const light = norm(n) < 0.5 ? 1
                : 0.5 + 0.1 * towards * dot(n, camera.up) + 0.5 * Math.max(0, towards * dot(n, key));
            const part = k => Math.round(255 * Math.min(1, v[10 * i + k] * light));
            return `rgba(${part(6)},${part(7)},${part(8)},${v[10 * i + 9]})`;
        };
        c.setTransform(scale, 0, 0, scale, 0, 0);
        c.clearRect(0, 0, camera.width, camera.height);
        for (let k = 0; k < mesh.lines.length; k += 2) {
            const a = seen[mesh.lines[k]], b = seen[mesh.lines[k + 1]];
            c.strokeStyle = shade(mesh.lines[k]);
            c.beginPath();
            c.moveTo(a[0], a[1]);
            c.lineTo(b[0], b[1]);
            c.stroke();
        }
        const all = mesh.halo.concat(mesh.solid, mesh.clear), order = [];
        for (let k = 0; k < all.length; k += 3) {
            const depth = seen[all[k]][2] + seen[all[k + 1]][2] + seen[all[k + 2]][2];
            order.push([k, k < mesh.halo.length ? depth + 1e9 : depth]);
        }
        order.sort((a, b) => b[1] - a[1]);
        for (const [k] of order) {
            const [p, q, r] = [seen[all[k]], seen[all[k + 1]], seen[all[k + 2]]];
            c.fillStyle = c.strokeStyle = shade(all[k]);
            c.beginPath();
            c.moveTo(p[0], p[1]);
            c.lineTo(q[0], q[1]);
            c.lineTo(r[0], r[1]);
            c.closePath();
            c.fill();
            if (v[10 * all[k] + 9] === 1) {
                c.stroke(); /* or the seams would show */
            }
        }
    }
}
