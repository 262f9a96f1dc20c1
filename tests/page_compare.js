"use strict";
/* node page_compare.js PAGE.html SHAPES.json: shapes by the module in a page of cpinn-show, and what
 * is known of them, against those that compiled C has written (export_shapes.c). Both come from one
 * text; what differs is rounding of sin and the like, and its order: 1e-12 of the largest of each
 * column, of distances that of the length. Steps from what is not trusted make more of rounding. */
const fs = require("fs"), zlib = require("zlib");
const page = fs.readFileSync(process.argv[2], "utf8");
const data = /<script type="application\/json" id="data">([^]*?)<\/script>/.exec(page)[1];
const { live } = JSON.parse(data), members = JSON.parse(fs.readFileSync(process.argv[3], "utf8"));
const module_ = new WebAssembly.Instance(new WebAssembly.Module(
    zlib.inflateSync(Buffer.from(live.module, "base64"))), { env: Math }).exports;
const numbers = (at, count) => new Float64Array(module_.memory.buffer, at(), count);
const width = live.columns.length, parameters = numbers(module_.parameters, live.parameters.length);
const shape = numbers(module_.shape, live.points * width), said = numbers(module_.said, 3);

const largest = Array.from({ length: width }, (_, c) => Math.max(1e-300, ...members.map(m =>
    Math.max(...m[5].map((x, i) => (i % width === c ? Math.abs(x) : 0))))));
const scale = largest.map((x, c) => Math.max(...largest.filter(
    (_, d) => live.columns[d].unit === live.columns[c].unit)));
let shapes = 0, distances = 0, trusted = 0;
for (const [steps, p, predicted, left, why, wanted] of members) {
    parameters.set(p);
    module_.answer(steps);
    if (why !== said[2]) {
        throw new Error(`why: ${said[2]}, not ${why}, at ${p}`);
    }
    if (why !== 0) {
        continue;
    }
    trusted++;
    if (wanted.length !== shape.length) {
        throw new Error(`${shape.length} numbers, not ${wanted.length}`);
    }
    wanted.forEach((x, i) => {
        shapes = Math.max(shapes, Math.abs(x - shape[i]) / scale[i % width]);
    });
    distances = Math.max(distances, Math.abs(predicted - said[0]) / live.length,
        Math.abs(left - said[1]) / live.length);
}
const start = process.hrtime.bigint();
for (let k = 0; k < 2000; k++) {
    module_.answer(2);
}
const spent = Number(process.hrtime.bigint() - start) / 2e6;
console.log(`${trusted} of ${members.length} trusted; shapes to ${shapes.toExponential(1)}, errors to `
    + `${distances.toExponential(1)}; ${spent.toFixed(0)} us a shape of two steps`);
process.exit(trusted > members.length / 2 && shapes <= 1e-12 && distances <= 1e-12 ? 0 : 1);
