"use strict";
/* The picture in time, and everything that can be done with it. */

const FOLLOW = 60; /* ms from one picture of the charts to the next while it plays */

/* What colours are; null: nothing. */
function fillLegend(box, of) {
    box.replaceChildren();
    if (of) {
        const { name, unit, map, low, high } = of;
        const as = prefix(Math.max(Math.abs(low), Math.abs(high)), unit);
        element("div", { text: name + (as.unit ? ` (${as.unit})` : "") }, box);
        element("i", { style: "background: linear-gradient(90deg, "
            + map.map(c => "#" + c).join(", ") + ")" }, box);
        const row = element("div", {}, box);
        for (const part of [0, 0.5, 1]) {
            element("span", { text: digits((low + part * (high - low)) * as.factor, 3) }, row);
        }
    }
}

class Player {
    constructor(motion, reference, paths) {
        this.motion = motion;
        this.picture = new Picture(motion, reference, paths);
        this.quantities = quantitiesOf(motion);
        const wanted = asked.get("colour");
        this.quantity = this.quantities.find(q => q.name === wanted)
            || (wanted === "plain" ? null : this.quantities[0]) || null;
        this.charts = [];
        this.at = this.drawn = this.followed = this.first = 0;
        this.playing = false;
        this.handle = null; /* { place(), drag(eye, place) } of a tip that is dragged */
        this.last = report.live ? 0 : motion.frames - 1; /* behind it are others of the range */
        this.#controls();
        this.#mouse();
        this.#keys();
        new ResizeObserver(() => { this.picture.resize(); this.draw(); }).observe(byId("stage"));
        this.picture.resize();
        this.setQuantity(this.quantity);
        if (asked.has("time")) {
            this.seek(Number(asked.get("time")));
        } else {
            this.go(motion.t ? 0.35 * this.last : Math.round(0.35 * this.last));
        }
        if (asked.has("play") && this.last > 0) {
            this.play(true);
        }
    }

    #controls() {
        const motion = this.motion, picture = this.picture;
        byId("player").hidden = this.last === 0;
        byId("player").style.display = this.last === 0 ? "none" : "";
        byId("time").max = this.last;
        byId("time").step = motion.t ? "any" : 1;
        byId("time").oninput = event => { this.play(false); this.go(Number(event.target.value)); };
        byId("play").onclick = () => this.play(!this.playing);
        const usual = this.#usualSpeed();
        const speeds = motion.t ? [...new Set([0.1, 0.25, 0.5, 1, 2, 4, usual])].sort((a, b) => a - b)
            : [5, 10, 20, ...(this.last > 200 ? [100] : [])];
        for (const speed of speeds) {
            const option = element("option", { value: speed, text: motion.t
                ? digits(speed, 3) + " \u00d7 real time" : speed + " a second" }, byId("speed"));
            option.selected = speed === (motion.t ? usual : 10);
        }
        const select = element("select", { id: "colour", title: "colour (C)" },
            element("label", { text: "Colour " }, byId("tools")));
        for (const q of this.quantities) {
            element("option", { value: q.name, text: q.name }, select);
        }
        element("option", { value: "", text: "plain" }, select);
        select.onchange = () => this.setQuantity(
            this.quantities.find(q => q.name === select.value) || null);
        this.select = select;
        const offers = [["directors", "Directors", motion.points > 1],
            ["loads", "Loads", picture.arrows.length > 0],
            ["actuators", "Tendons, chambers", picture.guided.length > 0],
            ["through", "See through", motion.points > 1],
            ["reference", picture.reference ? "Reference: " + picture.reference.name : "",
                Boolean(picture.reference)],
            ["path", picture.paths.length ? "Wanted path, path" : "Path of the tip", motion.t && this.last > 0], ["wall", "Wall", !!report.wall], ["markers", "Markers", residuals !== null], ["floor", "Grid", true]];
        this.boxes = {};
        for (const [key, text, there] of offers) {
            if (there) {
                const label = element("label", {}, byId("tools"));
                const box = element("input", { type: "checkbox" }, label);
                label.append(text);
                box.checked = picture.shown[key];
                box.onchange = () => { picture.shown[key] = box.checked; this.draw(); };
                this.boxes[key] = box;
            }
        }
        this.#notes();
    }

    /* So that all of it takes some seconds. */
    #usualSpeed() {
        if (!this.motion.t || this.last === 0) {
            return 1;
        }
        const duration = this.motion.t.at(this.last) - this.motion.t.at(0);
        return duration > 1.5 && duration < 20 ? 1 : round125(duration / 6);
    }

    #notes() {
        const notes = byId("notes"), data = report.motion, says = [];
        if (this.motion.enlarged !== 1) {
            says.push(`Deflections are drawn ${digits(this.motion.enlarged)} times as large.`);
        }
        if (this.picture.thicker > 1.01) {
            says.push(`The rod is drawn ${digits(this.picture.thicker, 2)} times as thick.`);
        }
        if (!this.picture.half && this.motion.points > 1) {
            says.push("Its thickness is not known.");
        }
        if (data.frames < data.frames_of || data.points < data.points_of) {
            says.push(`${data.frames} of ${data.frames_of} instants, ${data.points} of `
                + `${data.points_of} points.`);
        }
        if (report.advice) {
            says.push(report.advice);
        }
        notes.append(says.join(" ") + (says.length ? " " : ""));
        const keys = [...(report.live ? [["drag the tip", "move it"]] : []), ["drag", "turn"], ["shift drag", "move"], ["wheel", "zoom"],
            ["space", "play"], ["\u2190 \u2192", "step"], ["C", "colour"], ["D", "directors"],
            ["R", "reset"], ["T", "theme"]];
        for (const [key, what] of keys) {
            element("kbd", { text: key }, notes);
            notes.append(" " + what + "  ");
        }
    }

    #mouse() {
        const canvas = byId("labels"), camera = this.picture.camera, held = new Map();
        let pinch = 0, dragged = null; /* { pointer, x, y }: of the tip from the mouse */
        const tipAt = event => {
            if (!this.handle || event.shiftKey) {
                return null;
            }
            const [x, y] = camera.project(this.handle.place());
            const off = { pointer: event.pointerId, x: x - event.offsetX, y: y - event.offsetY };
            return Math.hypot(off.x, off.y) < 14 ? off : null;
        };
        const spread = () => {
            const [a, b] = [...held.values()];
            return Math.hypot(a.x - b.x, a.y - b.y);
        };
        canvas.onpointerdown = event => {
            canvas.setPointerCapture(event.pointerId);
            held.set(event.pointerId, { x: event.clientX, y: event.clientY });
            pinch = held.size === 2 ? spread() : 0;
            dragged = held.size === 1 ? tipAt(event) : null;
            byId("tip").hidden = true;
        };
        canvas.onpointerup = canvas.onpointercancel = event => {
            held.delete(event.pointerId);
            dragged = null;
        };
        canvas.onpointermove = event => {
            const before = held.get(event.pointerId);
            if (!before) {
                canvas.style.cursor = tipAt(event) ? "move" : "";
                this.#hover(event);
                return;
            }
            if (dragged && dragged.pointer === event.pointerId) {
                const x = event.offsetX + dragged.x, y = event.offsetY + dragged.y;
                this.handle.drag(camera.placeOf([x, y, 0]), camera.placeOf([x, y, camera.distance]));
                return;
            }
            const dx = event.clientX - before.x, dy = event.clientY - before.y;
            held.set(event.pointerId, { x: event.clientX, y: event.clientY });
            if (held.size === 2) {
                camera.zoom(pinch / spread());
                pinch = spread();
            } else if (event.shiftKey || event.buttons & 6) {
                camera.move(dx, dy);
            } else {
                camera.turn(0.008 * dx, 0.008 * dy);
            }
            this.draw();
        };
        canvas.onpointerleave = () => { byId("tip").hidden = true; };
        canvas.oncontextmenu = event => event.preventDefault();
        canvas.ondblclick = () => { camera.reset(); this.draw(); };
        canvas.addEventListener("wheel", event => {
            event.preventDefault();
            camera.zoom(Math.exp(0.0012 * event.deltaY));
            this.draw();
        }, { passive: false });
    }

    #hover(event) {
        const k = this.picture.pointAt(event.offsetX, event.offsetY), box = byId("tip");
        box.hidden = k < 0;
        if (k < 0) {
            return;
        }
        const i = this.picture.frame * this.motion.points + k, place = this.picture.pose.places[k];
        const rows = ["s = " + withUnit(this.motion.s.at(k), "m"),
            ...place.map((x, d) => "xyz"[d] + " = " + withUnit(x, "m"))];
        if (this.quantity) {
            rows.push(this.quantity.name + " = " + withUnit(this.quantity.at(i), this.quantity.unit));
        }
        box.textContent = rows.join("\n");
        box.style.left = Math.min(event.offsetX + 16, this.picture.camera.width - 150) + "px";
        box.style.top = event.offsetY + 14 + "px";
    }

    #keys() {
        const camera = this.picture.camera;
        const toggle = key => this.boxes[key] && this.boxes[key].click();
        const keys = {
            " ": () => this.play(!this.playing),
            ArrowLeft: () => { this.play(false); this.go(Math.ceil(this.at) - 1); },
            ArrowRight: () => { this.play(false); this.go(Math.floor(this.at) + 1); },
            Home: () => this.go(this.first),
            End: () => this.go(this.last),
            r: () => { camera.reset(); this.draw(); },
            d: () => toggle("directors"),
            t: () => byId("theme").click(),
            c: () => {
                const all = [...this.quantities, null];
                this.setQuantity(all[(all.indexOf(this.quantity) + 1) % all.length]);
            }
        };
        document.addEventListener("keydown", event => {
            const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
            if (act && !/SELECT|INPUT|BUTTON/.test(event.target.tagName) && !event.ctrlKey) {
                event.preventDefault();
                act();
            }
        });
    }

    setQuantity(quantity) {
        this.quantity = quantity;
        this.select.value = quantity ? quantity.name : "";
        fillLegend(byId("legend"), quantity && { name: quantity.name, unit: quantity.unit,
            ...scaleOf(quantity) });
        if (this.onQuantity) {
            this.onQuantity();
        }
        this.draw();
    }

    /* To the time of a motion, the number of a member. */
    seek(time) {
        this.play(false);
        this.go(frameAt(this.motion, time));
    }

    go(at) {
        this.at = Math.min(this.last, Math.max(this.first, at));
        this.draw();
    }

    play(on) {
        const run = now => {
            if (!this.playing) {
                return;
            }
            const passed = Math.min(0.25, (now - this.before) / 1000) * Number(byId("speed").value);
            this.picture.keepUp(now - this.before);
            this.before = now;
            if (this.motion.t) {
                const t = timeAt(this.motion, this.at) + passed;
                this.at = t >= this.motion.t.at(this.last) ? 0 : frameAt(this.motion, t);
            } else {
                const next = this.at + passed;
                this.at = next < this.last + 1 ? next : this.first;
            }
            this.draw();
            document.body.dataset.drawn = ++this.drawn;
            requestAnimationFrame(run);
        };
        on = on && this.last > 0;
        if (on && !this.playing) {
            this.playing = true;
            this.before = performance.now();
            requestAnimationFrame(run);
        }
        if (!on && this.playing) {
            this.picture.rest();
            this.playing = false;
            this.draw();
        }
        this.playing = on;
        byId("play").textContent = on ? "\u275a\u275a" : "\u25b6";
    }

    draw() {
        const at = this.motion.t ? this.at : Math.floor(this.at);
        const frame = Math.min(this.last, Math.round(at)), time = timeAt(this.motion, at);
        this.picture.draw(at, this.quantity);
        byId("time").value = at;
        byId("now").textContent = this.motion.labels ? this.motion.labels[frame]
            : this.motion.t ? "t = " + withUnit(time, "s") : `member ${frame + 1}`;
        const now = performance.now();
        if (this.playing && now - this.followed < FOLLOW) {
            return;
        }
        this.followed = now;
        for (const chart of this.charts) {
            chart.follow(time, frame);
        }
    }
}
