"use strict";
/* The tips of members all over the ranges, as dots over the picture. */

class Workspace {
    constructor(data, redraw) {
        const columns = data.columns.map(column), quantities = columns.slice(3);
        this.places = Array.from({ length: data.rows }, (_, i) => [0, 1, 2].map(k => columns[k].at(i)));
        this.quantities = quantities.filter(c => c.low <= c.high);
        this.ends = new Map(quantities.map((c, k) => [c, data.ends[k]]));
        this.redraw = redraw;
        const select = element("select", { title: "colour of the tips" },
            element("label", { text: "Tips by " }, byId("tools")));
        for (const q of this.quantities) {
            element("option", { value: q.name, text: q.name }, select);
        }
        element("option", { value: "", text: "hidden" }, select);
        select.value = data.by;
        select.onchange = () => this.choose(select.value);
        const moves = data.moves.filter(name => name);
        byId("notes").append(`Workspace: ${data.says}. Dexterity is the least singular value of the `
            + `tip's Jacobian by ${moves.join(", ")} as parts of their ranges, in ${data.directions} `
            + "directions, conditioning the least over the largest. ");
        this.choose(select.value);
    }

    choose(name) {
        const q = this.quantity = this.quantities.find(one => one.name === name) || null;
        fillLegend(byId("reached"), q && { name: "tips: " + q.name, unit: q.unit, map: SEQUENTIAL,
            low: this.ends.get(q)[0], high: this.ends.get(q)[1] });
        this.redraw();
    }

    /* On a canvas in pixels of the page, the farthest first. */
    draw(canvas, camera) {
        const q = this.quantity;
        if (!q) {
            return;
        }
        const axis = camera.axes()[2], [low, high] = this.ends.get(q), wide = high - low || 1;
        const order = this.places.map((p, i) => [dot(p, axis), i]).sort((a, b) => a[0] - b[0]);
        canvas.globalAlpha = 0.6;
        for (const [, i] of order) {
            const [x, y] = camera.project(this.places[i]);
            canvas.fillStyle = `rgb(${colourOf(SEQUENTIAL_SHADES, (q.at(i) - low) / wide)
                .map(part => Math.round(255 * part)).join()})`;
            canvas.fillRect(x - 1.5, y - 1.5, 3, 3);
        }
        canvas.globalAlpha = 1;
    }
}
