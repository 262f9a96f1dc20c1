"use strict";
/* Charts as SVG: curves over one axis, with a cursor at the present and values under the mouse. */

const SVG = "http://www.w3.org/2000/svg";

function element(name, attributes = {}, parent = null) {
    const is_svg = ["svg", "g", "path", "line", "text", "circle", "rect"].includes(name);
    const made = is_svg ? document.createElementNS(SVG, name) : document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
        if (key === "text") {
            made.textContent = value;
        } else {
            made.setAttribute(key, value);
        }
    }
    if (parent) {
        parent.append(made);
    }
    return made;
}

/* About `count` round numbers within a range, and their distance. */
function ticks(low, high, count) {
    const step = round125((high - low) / count);
    const result = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
        result.push(k * step);
    }
    result.step = step;
    return result;
}

function decades(low, high) {
    const from = Math.ceil(low - 1e-9), to = Math.floor(high + 1e-9);
    const step = Math.max(1, Math.ceil((to - from) / 5)), result = [];
    for (let k = from; k <= to; k += step) {
        result.push(k);
    }
    return result.length > 1 ? result : ticks(low, high, 3);
}

const superscript = k => String(k).replace(/[-0-9]/g,
    c => (c === "-" ? "\u207b" : "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"[c]));

/* about: { title, x, xUnit, yUnit, log, series: [{ name, count, x(i), y(i), dashed, dots, half(i) }],
 * colours, seek }; half: of a band around y; so many colours are taken in turn (6).
 * seek(x, event): where the user has clicked. */
class Chart {
    constructor(parent, about) {
        this.about = about;
        this.width = Math.min(480, Math.max(300, parent.clientWidth - 30)); /* readable on phones */
        this.height = 190;
        this.room = { left: 58, right: 12, top: 8, bottom: 34 };
        const card = element("div", { class: "card chart" }, parent);
        this.card = card;
        this.title = element("h2", { text: about.title }, card);
        this.svg = element("svg", { viewBox: `0 0 ${this.width} ${this.height}`,
            role: "img", "aria-label": about.title }, card);
        this.keys = element("div", { class: "keys" }, card);
        this.cursor = null;
        this.draw();
        this.svg.addEventListener("pointermove", event => this.#hover(event));
        this.svg.addEventListener("pointerleave", () => this.#say(this.at));
        this.svg.addEventListener("click", event => about.seek && about.seek(this.#xOf(event), event));
    }

    #range() {
        const r = { x: [Infinity, -Infinity], y: [Infinity, -Infinity] };
        const take = (range, value) => {
            if (Number.isFinite(value)) {
                range[0] = Math.min(range[0], value);
                range[1] = Math.max(range[1], value);
            }
        };
        for (const one of this.about.series) {
            for (let i = 0; i < one.count; i++) {
                take(r.x, one.x(i));
                take(r.y, this.about.log ? Math.log10(one.y(i)) : one.y(i));
                if (one.half) {
                    take(r.y, one.y(i) - one.half(i));
                    take(r.y, one.y(i) + one.half(i));
                }
            }
        }
        if (this.about.yRange) {
            r.y = this.about.yRange.slice();
        }
        if (!this.about.log && hasPrefix(this.about.yUnit)
            && Math.max(...r.y.map(Math.abs)) < NOTHING) {
            r.y = [-NOTHING, NOTHING];
        }
        for (const range of [r.x, r.y]) {
            if (!(range[0] <= range[1])) {
                range[0] = 0;
                range[1] = 1;
            }
            if (range[1] - range[0] < 1e-12 * Math.max(Math.abs(range[0]), 1e-30)) {
                const more = Math.abs(range[0]) || 1;
                range[0] -= more / 2;
                range[1] += more / 2;
            }
        }
        const room = 0.05 * (r.y[1] - r.y[0]);
        r.y = [r.y[0] - room, r.y[1] + room];
        return r;
    }

    toX(x) {
        const { left, right } = this.room, [low, high] = this.range.x;
        return left + (x - low) / (high - low) * (this.width - left - right);
    }

    toY(y) {
        const { top, bottom } = this.room, [low, high] = this.range.y;
        const value = this.about.log ? Math.log10(y) : y;
        return this.height - bottom - (value - low) / (high - low) * (this.height - top - bottom);
    }

    #xOf(event) {
        const box = this.svg.getBoundingClientRect(), { left, right } = this.room;
        const at = (event.clientX - box.left) / box.width * this.width;
        const [low, high] = this.range.x;
        const part = (at - left) / (this.width - left - right);
        return low + Math.min(1, Math.max(0, part)) * (high - low);
    }

    draw() {
        const { left, right, top, bottom } = this.room, about = this.about;
        const end = this.width - right, floor = this.height - bottom;
        this.range = this.#range();
        this.svg.replaceChildren();
        const [low, high] = this.range.y;
        const most = Math.max(Math.abs(low), Math.abs(high));
        const y = about.log ? { factor: 1, unit: about.yUnit } : prefix(most, about.yUnit);
        this.yScale = y;
        const x = prefix(Math.max(...this.range.x.map(Math.abs)), about.xUnit);
        this.xScale = x;
        const marks = about.log ? decades(low, high) : ticks(low * y.factor, high * y.factor, 4);
        for (const at of marks) {
            const value = about.log ? Math.pow(10, at) : at / y.factor;
            const h = this.toY(value);
            element("line", { class: "grid", x1: left, x2: end, y1: h, y2: h }, this.svg);
            element("text", { x: left - 6, y: h + 4, "text-anchor": "end",
                text: about.log ? this.#decade(at, value) : tickText(at, marks.step) }, this.svg);
        }
        const places = ticks(this.range.x[0] * x.factor, this.range.x[1] * x.factor,
            Math.round(this.width / 80));
        for (const at of places) {
            const w = this.toX(at / x.factor);
            element("line", { class: "grid", x1: w, x2: w, y1: floor, y2: floor + 4 }, this.svg);
            element("text", { x: w, y: floor + 16, "text-anchor": "middle",
                text: tickText(at, places.step) }, this.svg);
        }
        element("line", { class: "grid", x1: left, x2: end, y1: floor, y2: floor }, this.svg);
        element("text", { x: end, y: this.height - 3, "text-anchor": "end",
            text: about.x + (x.unit ? ` (${x.unit})` : "") }, this.svg);
        this.title.textContent = about.title + (y.unit && !about.log ? ` (${y.unit})` : "");
        about.series.forEach((one, k) => one.half && element("path", { class: "band",
            style: `fill: ${this.#colour(k)}`, d: this.#band(one) }, this.svg));
        this.paths = about.series.map((one, k) => element("path", { class: one.dots ? "dots" : "curve",
            style: `stroke: ${this.#colour(k)}` + (one.dashed ? "; stroke-dasharray: 5 4" : "")
                + (one.dots && one.count < 200 ? "; stroke-width: 5" : ""),
            d: this.#path(one) }, this.svg));
        this.cursor = element("line", { class: "cursor", x1: 0, x2: 0, y1: top, y2: floor,
            visibility: "hidden" }, this.svg);
        this.keys.replaceChildren();
        this.values = about.series.map((one, k) => {
            const row = element("span", {}, this.keys);
            element("i", { style: `background: ${this.#colour(k)}`,
                class: one.dashed ? "dashed" : "" }, row);
            row.append(one.name + " ");
            element("b", { text: " " }, row);
            return row.lastChild.firstChild;
        });
        this.#say(this.at);
    }

    /* A power of ten, with a unit as what it is. */
    #decade(at, value) {
        const unit = this.about.yUnit;
        return prefix(value, unit).unit !== unit || (unit && Math.abs(at) < 1) ? withUnit(value, unit)
            : Number.isInteger(at) ? "10" + superscript(at) : digits(value, 3);
    }

    #colour(k) {
        return `var(--curve${k % (this.about.colours || 6)})`;
    }

    /* From y - half to y + half. */
    #band(one) {
        const at = (i, sign) => this.toX(one.x(i)).toFixed(1) + " "
            + this.toY(one.y(i) + sign * one.half(i)).toFixed(1);
        const known = Array.from({ length: one.count }, (_, i) => i)
            .filter(i => Number.isFinite(one.y(i) + one.half(i)));
        return known.length ? "M" + known.map(i => at(i, 1)).concat(
            known.reverse().map(i => at(i, -1))).join("L") + "Z" : "";
    }

    #path(one) {
        let text = "", up = true;
        for (let i = 0; i < one.count; i++) {
            const y = this.toY(one.y(i));
            if (!Number.isFinite(y)) {
                up = true;
                continue;
            }
            text += (up ? "M" : "L") + this.toX(one.x(i)).toFixed(1) + " " + y.toFixed(1);
            text += one.dots ? "h0" : "";
            up = Boolean(one.dots);
        }
        return text;
    }

    /* Curves of the same axes with new numbers. */
    change() {
        this.about.series.forEach((one, k) => this.paths[k].setAttribute("d", this.#path(one)));
    }

    /* The present; null: none. */
    show(at) {
        this.at = at;
        this.cursor.setAttribute("visibility", at === null ? "hidden" : "visible");
        if (at !== null) {
            this.cursor.setAttribute("x1", this.toX(at));
            this.cursor.setAttribute("x2", this.toX(at));
        }
        this.#say(at);
    }

    #hover(event) {
        this.#say(this.#xOf(event));
    }

    /* Names, with the values at a place. */
    #say(at) {
        this.about.series.forEach((one, k) => {
            const i = at === null || at === undefined ? -1 : nearest(one, at);
            const value = i < 0 ? "" : this.about.log ? withUnit(one.y(i), this.about.yUnit)
                : digits(one.y(i) * this.yScale.factor);
            if (this.values[k].data !== value) {
                this.values[k].data = value;
            }
        });
    }
}

/* The index of a series, ascending in x, that is the nearest; -1: there is none. */
function nearest(one, x) {
    let low = 0, high = one.count - 1;
    while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (one.x(middle) <= x) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return one.count === 0 ? -1 : Math.abs(one.x(high) - x) < Math.abs(one.x(low) - x) ? high : low;
}
