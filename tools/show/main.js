"use strict";
/* The page: its head, the picture, charts, tables and texts. */

/* ---- the head ------------------------------------------------------------------------------ */

function fillHead() {
    byId("title").textContent = report.title;
    for (const [name, value] of report.facts || []) {
        const row = element("span", {}, byId("facts"));
        row.append(name + " ");
        element("b", { text: value }, row);
    }
    const box = byId("verdict"), verdict = report.verdict;
    if (!verdict) {
        box.hidden = true;
        return;
    }
    box.className = verdict.outcome === "solved" ? "good"
        : verdict.outcome === "warning" ? "warn" : "bad";
    element("b", { text: verdict.outcome }, box);
    box.append(verdict.text || "There is an answer, and nothing speaks against it.");
    for (const finding of (verdict.findings || []).slice(1)) {
        element("span", { text: finding.text }, box);
    }
}

/* ---- charts -------------------------------------------------------------------------------- */

function addChart(player, about, follow) {
    const chart = new Chart(byId("charts"), about);
    chart.follow = follow || (() => {});
    if (player) {
        player.charts.push(chart);
    }
    return chart;
}

/* Of a closed loop: where its place is, and where it was to be. */
function addPlaceChart(player) {
    const [wanted, gone] = player.picture.paths;
    const curves = (of, kind, dashed) => of.place.map(c => ({ name: kind + c.name, dashed,
        count: of.frames, x: f => of.t.at(f), y: f => c.at(f) }));
    addChart(player, { title: "Position of the place; dashed: wanted", x: "t", xUnit: "s",
        yUnit: "m", series: [...curves(gone, "", false), ...curves(wanted, "wanted ", true)],
        colours: 3, seek: t => player.seek(t) }, function (time) { this.show(time); });
}

/* Where the tip is over time, and what colours the rod over its length now. */
function addMotionCharts(player) {
    const motion = player.motion, tip = motion.points - 1;
    const moving = motion.place.filter(c => {
        const values = Array.from({ length: motion.frames }, (_, f) => c.at(f * motion.points + tip));
        return Math.max(...values) - Math.min(...values) > 1e-9 * player.picture.size;
    });
    const isTimed = motion.t !== null;
    if (report.paths) {
        addPlaceChart(player);
    } else if (player.last > 0 && moving.length) {
        addChart(player, {
            title: motion.enlarged !== 1 ? "Tip, enlarged" : "Position of the tip",
            x: isTimed ? "t" : "member", xUnit: isTimed ? "s" : "", yUnit: "m",
            series: moving.map(c => ({ name: c.name, count: motion.frames,
                x: f => timeAt(motion, f), y: f => c.at(f * motion.points + tip) })),
            seek: t => player.seek(t)
        }, function (time) { this.show(time); });
    }
    if (motion.points > 1 && player.quantities.length) {
        const about = { x: "s", xUnit: "m" };
        const along = (name, at) => ({ name, count: motion.points, x: k => motion.s.at(k),
            y: k => at(player.picture.frame * motion.points + k) });
        const choose = () => {
            const q = player.quantity || player.quantities[0];
            const parts = q.parts.length > 1 ? q.parts : [];
            about.series = [along(q.name, q.at), ...parts.map(c => along(c.name, c.at))];
            about.title = q.name[0].toUpperCase() + q.name.slice(1) + " along the rod";
            about.yUnit = q.unit;
            about.yRange = [Math.min(q.low, ...parts.map(c => c.low)),
                Math.max(q.high, ...parts.map(c => c.high))];
        };
        choose();
        const chart = addChart(player, about, function () { this.change(); });
        chart.at = null;
        player.onQuantity = () => { choose(); chart.draw(); };
    }
    if (motion.points > 1 && (player.last === 0 || !isTimed)) {
        const bent = motion.place.map((c, k) => ({ name: "xyz"[k], count: motion.points,
            x: i => motion.s.at(i), y: i => c.at(player.picture.frame * motion.points + i) }));
        addChart(player, { title: "Position along the rod", x: "s", xUnit: "m", yUnit: "m",
            series: bent, yRange: player.picture.extent }, function () { this.change(); });
    }
}

function addReportCharts(player) {
    const written = (report.curves || []).map(curve => ({ title: curve.title, x: curve.x,
        xUnit: curve.x_unit, yUnit: curve.y_unit, log: curve.log === "yes",
        series: curve.series.map(one => {
            const [x, y] = one.columns.map(column);
            return { name: one.name, count: one.rows, x: x.at, y: y.at };
        }) }));
    for (const about of [...written, ...(report.loop ? loopCurves(report.loop) : [])]) {
        const follows = about.x === "t" || about.x === "member";
        if (about.series.length > 0) {
            addChart(player, { ...about, seek: follows && player ? t => player.seek(t) : null },
                follows ? function (time) { this.show(time); } : null);
        }
    }
}

/* ---- tables and texts ---------------------------------------------------------------------- */

function addTable(parent, rows) {
    const table = element("table", {}, element("div", { class: "scroll" }, parent));
    const head = element("tr", {}, element("thead", {}, table)), body = element("tbody", {}, table);
    rows[0].forEach(text => element("th", { text }, head));
    for (const row of rows.slice(1)) {
        const line = element("tr", {}, body);
        row.forEach(value => element("td", { text: value }, line));
    }
    return table;
}

function addDetails(title, open, fill) {
    const box = element("details", { class: "card" }, byId("more"));
    element("summary", { text: title }, box);
    let filled = false;
    box.ontoggle = () => {
        if (box.open && !filled) {
            filled = true;
            fill(box);
        }
    };
    box.open = open;
    return box;
}

/* All numbers at the instant that is shown when the table is opened, and those of the tip. */
function addNumbers(player) {
    const motion = player.motion;
    const names = motion.columns.map(c => c.name + (c.unit ? ` (${c.unit})` : ""));
    const row = (first, i) => [digits(first, 6), ...motion.columns.map(c => digits(c.at(i), 6))];
    if (player.last > 0) {
        addDetails(motion.t ? "The tip over time: numbers" : "The tips of all members: numbers", false, box => addTable(box,
            [[motion.t ? "t (s)" : "member", ...names],
                ...Array.from({ length: motion.frames }, (_, f) => row(
                    motion.t ? motion.t.at(f) : f + 1, (f + 1) * motion.points - 1))]));
    }
    if (motion.points > 1) {
        const box = addDetails("Along the rod: numbers at the instant above", false, () => {});
        box.addEventListener("toggle", () => {
            box.querySelectorAll(".scroll").forEach(old => old.remove());
            if (box.open) {
                const first = player.picture.frame * motion.points;
                addTable(box, [["s (m)", ...names], ...Array.from({ length: motion.points },
                    (_, k) => row(motion.s.at(k), first + k))]);
            }
        });
    }
}

function addRest() {
    for (const image of report.images || []) {
        addDetails(image.title, true, box => element("img",
            { src: "data:image/svg+xml;base64," + image.data, alt: image.title }, box));
    }
    for (const table of report.tables || []) {
        const title = table.title + (table.cut ? " (its first rows)" : "");
        addDetails(title, (report.images || []).length === 0 || table.rows.length < 30,
            box => addTable(box, table.rows));
    }
    for (const text of report.texts || []) {
        addDetails(text.title, false, box => element("pre", { text: text.text }, box));
    }
    byId("footer").textContent = `${report.program} ${report.version}, from ${report.source}. `
        + "SI units; body components along the directors d1, d2, d3.";
}

/* ---- the page ------------------------------------------------------------------------------ */

/* For "#measure": how many pictures a second are drawn, by the median time of a hundred. */
function measure(player) {
    const spent = [];
    for (let k = 0; k < 100; k++) {
        const start = performance.now();
        player.at = k % (player.last + 1);
        player.draw();
        spent.push(performance.now() - start);
    }
    document.body.dataset.rate = (1000 / spent.sort((a, b) => a - b)[50]).toFixed(1);
}

let sliders = null;

async function begin() {
    setTheme(asked.get("theme")
        || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"));
    fillHead();
    if (asked.has("size")) {
        const [width, height] = asked.get("size").split("x");
        Object.assign(byId("stage").style, { width: width + "px", height: height + "px" });
    }
    const live = report.live ? await Live.open(report.live).catch(why => {
        element("p", { text: `This browser does not compute shapes: ${why.message}` },
            byId("charts"));
    }) : null;
    if (residuals && report.motion) {
        report.motion.labels = residuals.labels();
    }
    const motion = report.motion ? new Motion(report.motion) : null;
    let player = null;
    if (motion && motion.isPlaced) {
        const other = report.motion.reference ? new Motion(report.motion.reference) : null;
        player = new Player(motion, other && other.isPlaced ? other : null,
            (report.paths || []).map(data => new Motion(data)));
        if (report.workspace) {
            player.picture.workspace = new Workspace(report.workspace, () => player.draw());
        }
        if (live) {
            sliders = new Sliders(live, player);
        }
        if (!residuals) {
            addMotionCharts(player);
            addNumbers(player);
        }
    } else {
        byId("figure").remove();
        document.querySelector("main").classList.add("single");
    }
    if (residuals) {
        residuals.open(player);
    }
    addReportCharts(player);
    addRest();
    byId("theme").onclick = () => {
        setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
        if (player) {
            player.draw();
        }
    };
    if (player) {
        player.draw();
        player.picture.describe();
        if (asked.has("measure")) {
            measure(player);
        }
    }
    document.body.dataset.ready = "yes";
}

begin();
