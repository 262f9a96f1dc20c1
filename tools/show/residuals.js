"use strict";
/* Measured rows beside the model: tables of files and markers, charts by pose, time, input and
 * place, and the markers in the picture. Residuals are measured less computed. */

const MEASURED = "--curve1", MODEL = "--curve0";

const rms = values => Math.sqrt(values.reduce((sum, x) => sum + x * x, 0) / values.length);
const mean = values => values.reduce((sum, x) => sum + x, 0) / values.length;

class Residuals {
    constructor(data) {
        const number = value => (value === null ? NaN : value);
        this.entries = data.entries.map(e => ({ ...e, rms: number(e.rms), mean: number(e.mean),
            median: number(e.median), worst: number(e.worst) }));
        for (const from of data.columns) {
            this[from.name] = column(from); /* pose, marker, s, t, distance */
        }
        this.components = data.components.map(column).filter(c => c.low <= c.high);
        this.inputs = data.known.map(column).filter(c => c.low < c.high);
        this.places = data.places ? data.places.map(column) : null;
        this.poses = data.poses || [];
        this.thinned = data.rows < data.rows_of ? `${data.rows} of ${data.rows_of} rows. ` : "";
        this.all = Array.from({ length: data.rows }, (_, row) => row);
        this.entryOf = new Int32Array(data.rows);
        this.entries.forEach((one, k) => this.entryOf.fill(k, one.first, one.end));
        this.rowsOf = new Map(); /* of a pose */
        for (const row of this.all) {
            const pose = this.pose.at(row);
            this.rowsOf.set(pose, (this.rowsOf.get(pose) || []).concat([row]));
        }
        this.unit = this.entries[0].unit;
        const largest = this.entries.filter(e => e.unit === this.unit)
            .reduce((a, b) => (this.far(b.worst_row) > this.far(a.worst_row) ? b : a));
        this.as = new Map(); /* the same prefix for all that has a unit */
        for (const { unit } of this.entries) {
            this.as.set(unit, prefix(Math.max(...this.entries.filter(e => e.unit === unit)
                .map(e => e.worst || 0)), unit));
        }
        this.row = largest.worst_row; /* that is looked at */
        this.files = null; /* null: all of the unit; else an entry */
        this.which = 0;    /* 0: all markers */
        this.player = null;
    }

    /* Of a row; where there is no solution, nothing is further. */
    far(row) {
        return Number.isFinite(this.distance.at(row)) ? this.distance.at(row) : Infinity;
    }

    /* Its part of the page; player (null: there are no shapes) shows the poses. */
    open(player) {
        this.player = player;
        this.#fillTables();
        this.#addChoices();
        this.#addCharts();
        if (player) {
            player.charts.push({ follow: (time, frame) => this.show(frame) });
            this.#fillLegend();
        }
        this.choose(asked.has("file") ? { files: Number(asked.get("file")) } : {});
        this.#addWorst();
    }

    /* Of a distance or a component, as all of that unit are written. */
    size(value, unit, count = 3) {
        const as = this.as.get(unit);
        return digits(value * as.factor, count)
            + (as.unit && Number.isFinite(value) ? " " + as.unit : "");
    }

    /* ---- names ----------------------------------------------------------------------------- */

    fileName(k) {
        const { file, judged } = this.entries[k];
        const same = this.entries.filter(e => e.file === file).length > 1;
        return file + (same ? ` (data[${this.entries[k].data}])` : "")
            + (judged === "held_out" ? ", held out" : "");
    }

    markerName(row) {
        return (this.marker.high > 1 ? `marker ${this.marker.at(row)}, ` : "")
            + `s = ${withUnit(this.s.at(row), "m", 3)}`;
    }

    poseName(row) {
        return `pose ${this.pose.at(row)}`
            + (this.t ? `, t = ${withUnit(this.t.at(row), "s")}` : "");
    }

    inputsAt(row) {
        return this.inputs.map(c => `${c.name} = ${digits(c.at(row), 3)}`).join(", ");
    }

    /* What a frame of the motion is called. */
    labels() {
        return this.poses.map(pose => {
            const rows = this.rowsOf.get(pose) || [];
            const most = Math.max(...rows.map(row => this.distance.at(row)));
            return rows.length ? `${this.poseName(rows[0])}: ${this.size(most,
                this.entries[this.entryOf[rows[0]]].unit)}` : `pose ${pose}`;
        });
    }

    /* The frame of a pose, or the nearest one that has a shape. */
    frameOf(pose) {
        let low = 0, high = this.poses.length - 1;
        while (low < high) {
            const middle = (low + high) >> 1;
            if (this.poses[middle] < pose) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        return low > 0 && pose - this.poses[low - 1] < this.poses[low] - pose ? low - 1 : low;
    }

    /* ---- tables ---------------------------------------------------------------------------- */

    #fillTables() {
        const box = byId("files"), say = element("p", {}, box), one = this.entries[this.entryOf[this.row]];
        element("b", { text: this.far(this.row) === Infinity ? "No solution"
            : `Largest: ${this.size(this.distance.at(this.row), one.unit)}` }, say);
        say.append(` at ${this.poseName(this.row)} of ${one.file}, ${this.markerName(this.row)}`
            + `. ${this.#compare()}`);
        const row = element("div", { class: "beside" }, box);
        this.#filesTable(element("div", { class: "card" }, row));
        this.markersCard = element("div", { class: "card" }, row);
    }

    /* Held out and fitted rows of the first unit. */
    #compare() {
        const total = judged => {
            const of = this.entries.filter(e => e.unit === this.unit && e.judged === judged);
            return Math.sqrt(of.reduce((sum, e) => sum + e.rows * e.rms * e.rms, 0)
                / of.reduce((sum, e) => sum + e.rows, 0));
        };
        const parts = [["fitted", "fitted rows"], ["held_out", "rows that are held out"],
            ["compared", "rows"]].map(([judged, text]) => [total(judged), text])
            .filter(([value]) => Number.isFinite(value))
            .map(([value, text]) => `${this.size(value, this.unit)} over ${text}`);
        return parts.length ? `Root of the mean square: ${parts.join(", ")}.` : "";
    }

    #filesTable(box) {
        element("h2", { text: "Files" }, box);
        const table = addTable(box, [["file", "judged", "rows", "rms", "mean", "median", "worst", "at",
            "deviation"], ...this.entries.map((e, k) => [this.fileName(k).replace(", held out", ""),
            e.judged.replace("_", " "), e.rows, ...[e.rms, e.mean, e.median, e.worst]
                .map(value => this.size(value, e.unit, 4)), "", e.deviation === null ? "\u2013"
                : this.size(e.deviation, e.unit)])]);
        [...table.tBodies[0].rows].forEach((line, k) => {
            line.classList.add("choice");
            line.onclick = () => this.choose({ files: k });
            const go = element("button", { type: "button", text: this.poseName(
                this.entries[k].worst_row) }, line.cells[7]);
            go.onclick = event => {
                event.stopPropagation();
                this.choose({ files: k });
                this.look(this.entries[k].worst_row);
            };
        });
        this.fileRows = [...table.tBodies[0].rows];
    }

    /* Of the files that are chosen: each marker, and by how much it is off in the mean. */
    #markersTable() {
        const box = this.markersCard, markers = this.#groups(this.#ofFiles(), this.marker);
        box.hidden = markers.length < 2;
        box.replaceChildren(element("h2", { text: "Markers" }));
        const names = this.#parts().map(c => c.name), unit = this.unit;
        addTable(box, [["marker", "s", "rows", "rms", "worst", ...names.map(n => `mean ${n}`)],
            ...markers.map(rows => [this.marker.at(rows[0]), withUnit(this.s.at(rows[0]), "m", 3),
                rows.length, this.size(rms(rows.map(r => this.distance.at(r))), unit),
                this.size(Math.max(...rows.map(r => this.distance.at(r))), unit),
                ...this.#parts().map(c => this.size(mean(rows.map(r => c.at(r))
                    .filter(Number.isFinite)), unit))])]);
    }

    #addWorst() {
        addDetails("The largest residuals", true, box => {
            const rows = this.all.filter(row => this.far(row) < Infinity)
                .sort((a, b) => this.far(b) - this.far(a)).slice(0, 20);
            const table = addTable(box, [["distance", "file", "pose", "place", ...this.components.map(
                c => c.name), "inputs"], ...rows.map(row => {
                const { unit } = this.entries[this.entryOf[row]];
                return [this.size(this.distance.at(row), unit, 4), this.fileName(this.entryOf[row]), this.poseName(row),
                    this.markerName(row), ...this.components.map(c => this.size(c.at(row), unit)),
                    this.inputsAt(row)];
            })]);
            [...table.tBodies[0].rows].forEach((line, k) => {
                line.classList.add("choice");
                line.onclick = () => this.look(rows[k]);
            });
        });
    }

    /* ---- what is chosen -------------------------------------------------------------------- */

    #addChoices() {
        const box = element("div", { class: "card choices" }, byId("charts"));
        const select = (name, options, act) => {
            const label = element("label", { text: name + " " }, box);
            const to = element("select", {}, label);
            options.forEach(([value, text]) => element("option", { value, text }, to));
            to.onchange = () => act(to.value);
            return to;
        };
        const units = [...new Set(this.entries.map(e => e.unit))];
        this.fileSelect = select("Files", [...units.map(unit => ["all " + unit,
            units.length > 1 ? `all in ${unit}` : "all"]),
        ...this.entries.map((_, k) => [k, this.fileName(k)])], value => this.choose(
            value.startsWith("all") ? { files: null, unit: value.slice(4) } : { files: Number(value) }));
        if (this.marker.high > 1) {
            const first = this.#groups(this.all, this.marker).map(rows => rows[0]);
            this.markerSelect = select("Marker", [[0, "all"], ...first.map(
                row => [this.marker.at(row), this.markerName(row)])],
            value => this.choose({ which: Number(value) }));
        }
        this.partSelect = select("Residual", [["", "length"], ...this.components.map(
            c => [c.name, c.name])], () => this.choose({}));
        if (this.inputs.length) {
            this.inputSelect = select("Input", this.inputs.map((c, k) => [k, c.name]),
                () => this.choose({}));
        }
    }

    choose(what) {
        Object.assign(this, what);
        if (this.files !== null) {
            this.unit = this.entries[this.files].unit;
        }
        this.fileSelect.value = this.files === null ? "all " + this.unit : this.files;
        this.fileRows.forEach((line, k) => line.classList.toggle("chosen", k === this.files));
        const rows = this.#selected();
        if (rows.length && !rows.includes(this.row)) {
            this.row = rows.reduce((a, b) => (this.far(b) > this.far(a) ? b : a));
        }
        this.#markersTable();
        this.#fillCharts(rows);
        this.#frames(rows);
        this.look(this.row);
    }

    /* Columns that any row of the files has. */
    #parts() {
        const rows = this.#ofFiles();
        return this.components.filter(c => rows.some(row => Number.isFinite(c.at(row))));
    }

    #ofFiles() {
        return this.all.filter(row => (this.files === null
            ? this.entries[this.entryOf[row]].unit === this.unit : this.entryOf[row] === this.files));
    }

    #selected() {
        return this.#ofFiles().filter(row => this.which === 0 || this.marker.at(row) === this.which);
    }

    #groups(rows, by) {
        const groups = new Map();
        for (const row of rows) {
            const key = by.at(row);
            if (!groups.has(key)) {
                groups.set(key, []);
            }
            groups.get(key).push(row);
        }
        return [...groups.entries()].sort((a, b) => a[0] - b[0]).map(([, of]) => of);
    }

    /* The picture goes through the poses of what is chosen. */
    #frames(rows) {
        const player = this.player;
        if (player && rows.length) {
            const poses = rows.map(row => this.pose.at(row));
            player.first = this.frameOf(poses.reduce((a, b) => Math.min(a, b)));
            player.last = this.frameOf(poses.reduce((a, b) => Math.max(a, b)));
            byId("time").min = player.first;
            byId("time").max = player.last;
        }
    }

    /* ---- charts ---------------------------------------------------------------------------- */

    #addCharts() {
        this.charts = ["Residual", "Components", "Distribution", "Residual by input", "Input",
            "Along the rod"].map(title => {
            const about = { series: [], x: "", xUnit: "", yUnit: "", title };
            const chart = new Chart(byId("charts"), about);
            about.seek = (x, event) => this.#pick(chart, event);
            return chart;
        });
    }

    /* The dot that is the nearest to where the user has clicked. */
    #pick(chart, event) {
        const box = chart.svg.getBoundingClientRect(), scale = chart.width / box.width;
        const x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
        let least = Infinity, row = null;
        for (const one of chart.about.series) {
            for (let i = 0; one.rows && i < one.count; i++) {
                const off = Math.hypot(chart.toX(one.x(i)) - x, chart.toY(one.y(i)) - y);
                if (off < least) {
                    least = off;
                    row = one.rows[i];
                }
            }
        }
        if (row !== null) {
            this.look(row);
        }
    }

    #series(name, rows, x, y, more = {}) {
        const sorted = rows.filter(row => Number.isFinite(y(row))).sort((a, b) => x(a) - x(b));
        return { name, count: sorted.length, x: i => x(sorted[i]), y: i => y(sorted[i]),
            rows: sorted, dots: true, ...more };
    }

    #fillCharts(rows) {
        const [residual, parts, spread, byInput, input, along] = this.charts, unit = this.unit;
        const isTimed = this.files !== null && this.t;
        const x = isTimed ? row => this.t.at(row) : row => this.pose.at(row);
        const axis = { x: isTimed ? "t" : "pose", xUnit: isTimed ? "s" : "" };
        const part = this.#parts().find(c => c.name === this.partSelect.value);
        const y = part ? row => part.at(row) : row => this.distance.at(row);
        const what = part ? `Residual, ${part.name}` : "Residual, length";
        this.xAt = x;
        this.#set(residual, { title: what, ...axis, yUnit: unit, series: this.#kinds(rows)
            .map(([name, of]) => this.#series(name, of, x, y)) });
        this.#set(parts, { title: "Residual, components", ...axis, yUnit: unit,
            series: this.#parts().map(c => this.#series(c.name, rows, x, row => c.at(row))) });
        this.#distribution(spread, rows, unit);
        const from = this.inputs[this.inputSelect ? Number(this.inputSelect.value) : -1];
        byInput.card.hidden = input.card.hidden = !from;
        if (from) {
            this.inputAt = row => from.at(row);
            this.#set(byInput, { title: `${what}, by ${from.name}`, x: from.name, xUnit: "", yUnit: unit,
                series: this.#ways(rows, from).map(([name, of]) => this.#series(name, of,
                    this.inputAt, y)) });
            this.#set(input, { title: from.name, ...axis, yUnit: "", series: [this.#series(from.name,
                rows, x, this.inputAt, { dots: !isTimed })] });
        }
        this.#along(along, unit);
    }

    #set(chart, about) {
        Object.assign(chart.about, about);
        chart.draw();
    }

    /* By marker, else by what was fitted, or by file. */
    #kinds(rows) {
        const markers = this.#groups(rows, this.marker);
        if (markers.length > 1 && markers.length <= 6) {
            return markers.map(of => [this.markerName(of[0]), of]);
        }
        const files = this.#groups(rows, { at: row => this.entryOf[row] });
        if (files.length > 1 && files.length <= 4) {
            return files.map(of => [this.fileName(this.entryOf[of[0]]), of]);
        }
        return ["fitted", "held_out", "compared"].map(judged => [judged.replace("_", " "),
            rows.filter(row => this.entries[this.entryOf[row]].judged === judged)])
            .filter(([, of]) => of.length);
    }

    /* Where an input has gone up, down, or stayed since the row before of the same marker. */
    #ways(rows, input) {
        const ways = { "input up": [], "input down": [], "input the same": [] }, before = new Map();
        for (const row of rows) {
            const key = `${this.entryOf[row]} ${this.marker.at(row)}`, now = input.at(row);
            const change = before.has(key) ? now - before.get(key) : 0;
            ways[change > 0 ? "input up" : change < 0 ? "input down" : "input the same"].push(row);
            before.set(key, now);
        }
        return Object.entries(ways).filter(([, of]) => of.length);
    }

    /* All numbers, over the deviation that is assumed if it is not the same for all. */
    #distribution(chart, rows, unit) {
        const parts = this.#parts(), deviations = new Set(rows.map(
            row => this.entries[this.entryOf[row]].deviation));
        const isKnown = !deviations.has(null), isOne = deviations.size === 1;
        const scaled = isKnown && !isOne;
        const values = [];
        for (const row of rows) {
            const by = scaled ? this.entries[this.entryOf[row]].deviation : 1;
            for (const c of parts) {
                if (Number.isFinite(c.at(row))) {
                    values.push(c.at(row) / by);
                }
            }
        }
        chart.card.hidden = values.length < 8;
        if (chart.card.hidden) {
            return;
        }
        const deviation = scaled ? 1 : isKnown ? [...deviations][0] : rms(values);
        const most = Math.max(4 * deviation, values.reduce((a, b) => Math.max(a, Math.abs(b)), 0));
        const bins = 2 * Math.min(30, Math.ceil(Math.sqrt(values.length) / 2)) + 1;
        const wide = 2 * most / bins, counts = new Array(bins).fill(0);
        values.forEach(v => counts[Math.min(bins - 1, Math.floor((v + most) / wide))]++);
        const steps = [[-most, 0], ...counts.flatMap((count, k) => [[-most + k * wide, count],
            [-most + (k + 1) * wide, count]]), [most, 0]];
        const law = Array.from({ length: 121 }, (_, k) => {
            const at = most * (k / 60 - 1);
            return [at, values.length * wide / deviation / Math.sqrt(2 * Math.PI)
                * Math.exp(-0.5 * (at / deviation) ** 2)];
        });
        const curve = (name, places, more) => ({ name, count: places.length, x: i => places[i][0],
            y: i => places[i][1], ...more });
        this.#set(chart, { title: "Numbers by the size of their residual", x: scaled
            ? "residual over its deviation" : "residual", xUnit: scaled ? "" : unit, yUnit: "",
        series: [curve("components", steps, {}), curve(`normal law${scaled ? ""
            : ` of ${this.size(deviation, unit)}`}${isKnown ? ", as assumed" : ", of their own rms"}`,
        law, { dashed: true })] });
    }

    /* By the place along the rod, where there are several. */
    #along(chart, unit) {
        const parts = this.#parts(), places = this.#groups(this.#ofFiles(), this.s);
        chart.card.hidden = places.length < 2;
        const at = of => this.s.at(of[0]);
        const size = of => rms(of.map(row => this.distance.at(row)));
        const constant = of => Math.hypot(...parts.map(c => mean(of.map(row => c.at(row))
            .filter(Number.isFinite))));
        const curve = (name, value) => ({ name, count: places.length, x: i => at(places[i]),
            y: i => value(places[i]), rows: places.map(of => of[0]) });
        this.#set(chart, { title: "Along the rod", x: "s", xUnit: "m", yUnit: unit,
            series: [curve("root of the mean square", size), curve("length of the mean", constant)] });
    }

    /* ---- a pose ---------------------------------------------------------------------------- */

    look(row) {
        this.row = row;
        if (this.player) {
            this.player.play(false);
            this.player.go(this.frameOf(this.pose.at(row)));
        } else {
            this.#follow();
        }
    }

    /* The picture shows a frame: the row that is looked at is of that pose. */
    show(frame) {
        const rows = this.rowsOf.get(this.poses[frame]) || [];
        if (rows.length && this.frameOf(this.pose.at(this.row)) !== frame) {
            const marker = this.marker.at(this.row);
            this.row = rows.find(row => this.marker.at(row) === marker) ?? rows[0];
        }
        this.#follow();
    }

    #follow() {
        if (!this.xAt) {
            return;
        }
        const [residual, parts, , byInput, input, along] = this.charts, x = this.xAt(this.row);
        [residual, parts, input].forEach(chart => chart.show(x));
        byInput.show(this.inputAt ? this.inputAt(this.row) : null);
        along.show(this.s.at(this.row));
        this.#say();
    }

    /* The pose in words. */
    #say() {
        const box = byId("answer");
        if (!box) {
            return;
        }
        const pose = this.pose.at(this.row), rows = this.rowsOf.get(pose);
        const { unit } = this.entries[this.entryOf[this.row]];
        box.replaceChildren();
        element("b", { text: this.fileName(this.entryOf[this.row]) }, box);
        box.append(`${this.poseName(this.row)}${this.inputs.length ? ": " : ""}${this.inputsAt(this.row)}`);
        for (const row of rows.slice(0, 8)) {
            element("span", { text: `${this.markerName(row)}: off by ${this.size(this.distance.at(row),
                unit)} (${this.components.filter(c => Number.isFinite(c.at(row))).map(
                c => `${c.name} ${this.size(c.at(row), unit)}`).join(", ")})` }, box);
        }
        byId("picture").setAttribute("aria-label", box.textContent);
    }

    /* Where something was measured at a frame, and the model is; [] of other quantities. */
    markersAt(frame) {
        return (this.rowsOf.get(this.poses[frame]) || []).map(row => ({ row,
            measured: [0, 1, 2].map(k => this.places[k].at(row)),
            model: [3, 4, 5].map(k => this.places[k].at(row)) }))
            .filter(m => [...m.measured, ...m.model].every(Number.isFinite));
    }

    /* Some of all places, for the camera. */
    placesSeen() {
        const step = Math.ceil(this.all.length / 1000);
        return !this.places ? [] : this.all.filter(row => row % step === 0)
            .map(row => [0, 1, 2].map(k => this.places[k].at(row)));
    }

    drawMarkers(picture, frame) {
        if (!this.places) {
            return;
        }
        const { mesh, size } = picture, measured = themeColour(MEASURED), model = themeColour(MODEL);
        for (const one of this.markersAt(frame)) {
            ball(mesh, one.measured, 0.009 * size, measured);
            ball(mesh, one.model, 0.009 * size, model);
            thread(mesh, [one.model, one.measured], 0.003 * size, measured);
            picture.tags.push([one.measured, this.size(this.distance.at(one.row), "m")]);
        }
    }

    /* What is drawn in which colour. */
    #fillLegend() {
        const box = byId("reached");
        box.style.top = "10px";
        for (const [name, text] of [[MEASURED, "measured"], [MODEL, "model"]]) {
            const line = element("div", { class: "dot" }, box);
            element("i", { style: `background: var(${name})` }, line);
            element("span", { text }, line);
        }
    }
}
