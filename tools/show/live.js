"use strict";
/* Shapes that the page computes: the C of the family, compiled to WebAssembly, and sliders for its
 * parameters. */

/* The module of report.live; members are as the C has them. */
class Live {
    static async open(data) {
        const packed = new Blob([bytesOf(data.module)]).stream();
        const bytes = packed.pipeThrough(new DecompressionStream("deflate"));
        const { instance } = await WebAssembly.instantiate(
            await new Response(bytes).arrayBuffer(), { env: Math });
        return new Live(data, instance.exports);
    }

    constructor(data, module) {
        const numbers = (at, count) => new Float64Array(module.memory.buffer, at(), count);
        this.module = module;
        this.data = data;
        this.steps = data.steps;
        this.width = data.columns.length;
        this.parameters = numbers(module.parameters, data.parameters.length);
        this.shape = numbers(module.shape, data.points * this.width);
        this.said = numbers(module.said, 3);
        this.drawn = numbers(module.drawn, data.drawn);
        this.place = numbers(module.place, 3);
        this.axes = numbers(module.axes, 9);
        this.box = numbers(module.box, 2 * data.parameters.length);
        this.values = data.parameters.map(p => this.valueAt(p, 0.5));
        this.#spread();
        this.show();
    }

    /* Of a parameter, from its coordinate, 0 to 1 over its range; and back. */
    valueAt(p, x) {
        return p.log ? p.low * Math.pow(p.high / p.low, x) : p.low + x * (p.high - p.low);
    }

    partOf(p, value) {
        return p.log ? Math.log(value / p.low) / Math.log(p.high / p.low)
            : (value - p.low) / (p.high - p.low);
    }

    /* { error, network, reason, tip }, in m; the reason is "" where the answer is trusted. */
    compute(values) {
        this.parameters.set(values);
        this.module.answer(this.steps);
        const [network, error, why] = this.said;
        return { error, network, reason: why ? this.data.reasons[why] : "",
            tip: Array.from(this.shape.slice(-this.width, 3 - this.width || undefined)) };
    }

    /* The motion: the member that is shown, at first one of these, and behind it members all over
     * the ranges, which say how far the picture and its colours reach, and how near the page is to
     * what cpinn has found. */
    #spread() {
        const { data } = this, count = data.parameters.length, row = count + 3;
        const tips = new Float64Array(bytesOf(data.tips).buffer);
        const frames = 1 + data.members, rows = frames * data.points;
        this.columns = data.columns.map(c => ({ ...c, values: new Float64Array(rows) }));
        this.beside = Array.from({ length: data.drawn }, () => new Float64Array(frames));
        this.off = this.compared = 0;
        for (let i = 0; i < data.members; i++) {
            const { reason, tip } = this.compute(tips.subarray(i * row, i * row + count));
            const known = tips.subarray(i * row + count, (i + 1) * row);
            this.#keep(i + 1, reason !== "");
            if (reason === "" && Number.isFinite(known[0])) {
                this.off = Math.max(this.off, norm(minus(tip, known)));
                this.compared++;
                this.values = i <= data.members / 3 ? Array.from(this.parameters) : this.values;
            }
        }
        report.motion = { frames, points: data.points, frames_of: frames, points_of: data.points,
            s: data.s, columns: this.columns, isLive: true };
        const fill = c => Object.assign(c, "live" in c ? { values: this.beside[c.live] } : {});
        for (const load of report.scene.arrows) {
            load.vector.forEach(fill);
        }
        report.scene.guided.forEach(g => g.acts.forEach(fill));
    }

    #keep(frame, hides) {
        const { points } = this.data, { width, shape } = this;
        for (let c = 0; c < width; c++) {
            const to = this.columns[c].values;
            for (let k = 0; k < points; k++) {
                to[frame * points + k] = hides ? NaN : shape[k * width + c];
            }
        }
        this.beside.forEach((to, k) => { to[frame] = this.drawn[k]; });
    }

    /* The member of the sliders becomes the first frame. */
    show() {
        this.answer = this.compute(this.values);
        this.#keep(0, false);
    }

    /* Brings the tip nearer to a place along two or three axes across each other, by the parameters
     * that move, exact derivatives and as many steps as cpinn_reach takes from a start; how far it is
     * from there, m, infinite from an answer without trust. */
    reach(place, axes, moves) {
        const ends = name => this.data.parameters.map((p, k) => (moves[k] ? p[name] : this.values[k]));
        this.place.set(place);
        this.axes.set(axes.flat());
        this.box.set([...ends("low"), ...ends("high")]);
        this.parameters.set(this.values);
        const distance = this.module.reach(axes.length, this.steps, 30);
        this.values = Array.from(this.parameters);
        return distance;
    }

    /* Answers along one parameter, the others as they are; among them that of its value. */
    along(which, count) {
        const p = this.data.parameters[which];
        const places = Array.from({ length: count }, (_, i) => this.valueAt(p, i / (count - 1)));
        return [...places, this.values[which]].sort((a, b) => a - b).map(at => {
            const values = this.values.slice();
            values[which] = at;
            return { at, ...this.compute(values) };
        });
    }

    /* Microseconds of a shape, the median of a hundred. */
    pace() {
        const spent = Array.from({ length: 100 }, () => {
            const start = performance.now();
            for (let k = 0; k < 10; k++) {
                this.compute(this.values);
            }
            return 100 * (performance.now() - start);
        });
        return spent.sort((a, b) => a - b)[50];
    }
}

/* Sliders under the picture, what is known of the answer, and charts along the last parameter that
 * was moved. The tip is dragged by the parameters that are ticked: first those that actuate the rod,
 * or all where none does. */
class Sliders {
    constructor(live, player) {
        this.live = live;
        this.player = player;
        this.which = 0;
        this.any = live.data.parameters.some(p => p.actuates);
        this.rows = live.data.parameters.map((p, k) => this.#row(p, k));
        this.checked = element("span", {}, byId("notes"));
        this.#ways();
        this.#charts();
        this.change();
        player.handle = { place: () => live.answer.tip, 
            drag: (eye, place) => this.drag(eye, place) };
    }

    #row(p, k) {
        const box = element("label", { class: "slider" }, byId("sliders"));
        element("span", { text: p.name }, box);
        const input = element("input", { type: "range", min: 0, max: 1, step: 0.001,
            title: `${digits(p.low)} to ${digits(p.high)}`, "aria-label": p.name }, box);
        const output = element("output", {}, box);
        input.value = this.live.partOf(p, this.live.values[k]);
        input.oninput = () => {
            this.which = k;
            this.live.values[k] = this.live.valueAt(p, Number(input.value));
            this.player.picture.wanted = null;
            this.change();
        };
        input.ondblclick = () => { input.value = 0.5; input.oninput(); };
        const ticked = element("input", { type: "checkbox",
            title: "moves when the tip is dragged" }, box);
        ticked.checked = p.actuates || !this.any;
        return { input, output, ticked };
    }

    /* To the line of sight from the eye through a place. */
    drag(eye, place) {
        const { live } = this, along = unitVector(minus(place, eye), [0, 0, 1]), side = across(along);
        this.left = live.reach(eye, [side, cross(along, side)],
            this.rows.map(row => row.ticked.checked));
        const { tip } = live.compute(live.values);
        this.player.picture.wanted = add(eye, times(along, dot(minus(tip, eye), along)));
        this.rows.forEach((row, k) => {
            row.input.value = live.partOf(live.data.parameters[k], live.values[k]);
        });
        this.change();
    }

    /* How the answer is found. */
    #ways() {
        const select = element("select", { title: "how the shape is found" },
            element("label", { text: "Shape by " }, byId("tools")));
        ["the network alone", "one step of Newton", "two steps of Newton"].forEach((text, steps) =>
            element("option", { value: steps, text }, select));
        select.value = this.live.steps;
        select.onchange = () => {
            this.live.steps = Number(select.value);
            this.pace = this.live.pace();
            this.change();
        };
        this.pace = this.live.pace();
    }

    #charts() {
        const series = (names, at) => names.map((name, k) => ({ name, count: 0,
            x: i => this.curve[i].at, y: i => at(this.curve[i], k) }));
        const known = (one, value) => (one.reason === "" ? value : NaN);
        this.charts = [
            { title: "Tip", yUnit: "m", series: series(["x", "y", "z"],
                (one, k) => known(one, one.tip[k])) },
            { title: "Predicted error", yUnit: "m", log: true,
                series: series(["of the network", "of the shape"],
                    (one, k) => known(one, k ? one.error : one.network)) }
        ].map(about => new Chart(byId("charts"), { ...about, x: "", xUnit: "", seek: x => {
            const row = this.rows[this.which], p = this.live.data.parameters[this.which];
            row.input.value = this.live.partOf(p, x);
            row.input.oninput();
        } }));
    }

    change() {
        const { live, which } = this, { data } = live, p = data.parameters[which];
        this.curve = live.along(which, 41);
        live.show();
        data.parameters.forEach((q, k) => {
            this.rows[k].output.textContent = digits(live.values[k]);
        });
        for (const chart of this.charts) {
            chart.about.x = p.name;
            chart.about.series.forEach(one => { one.count = this.curve.length; });
            chart.at = live.values[which];
            chart.draw();
            chart.show(live.values[which]);
        }
        this.#say();
        this.player.draw();
    }

    /* Less than what cpinn's own shapes are off is not told apart. */
    #distance(error) {
        const { length, tolerance } = this.live.data;
        return error <= tolerance ? `below ${withUnit(tolerance, "m", 2)}`
            : `${withUnit(error, "m", 2)} (${digits(100 * error / length, 2)} % of the length)`;
    }

    #say() {
        const { answer } = this.live, box = byId("answer");
        const trusted = answer.reason === "";
        box.className = trusted ? "good" : "bad";
        box.replaceChildren();
        element("b", { text: trusted ? "Trusted" : "Not trusted" }, box);
        box.append(trusted ? `the predicted error of the shape is ${this.#distance(answer.error)}`
            : answer.reason);
        const facts = [["tip", answer.tip.map(x => withUnit(x, "m")).join(", ")],
            ["predicted error of the network alone", this.#distance(answer.network)],
            ["computed in this page in", `${digits(this.pace, 2)} \u00b5s`]];
        const row = element("span", {}, box);
        facts.forEach(([name, value], k) => {
            row.append(`${k ? " \u00b7 " : ""}${name} `);
            element("em", { text: value }, row);
        });
        if (this.player.picture.wanted) {
            element("span", { text: !Number.isFinite(this.left)
                ? "Not reached: from an answer that is not trusted the tip is not moved."
                : this.left <= this.live.data.tolerance ? "The tip is where it was dragged to."
                    : `Not reached: the tip stays ${withUnit(this.left, "m", 3)} from where it was `
                        + "dragged to. Nothing nearer was found from here within the ranges." }, box);
        }
        this.checked.textContent = `Tips of ${this.live.compared} members are within `
            + `${withUnit(Math.max(this.live.off, NOTHING), "m", 2)} of those that cpinn has found.`;
    }
}
