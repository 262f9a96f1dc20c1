"use strict";
/* Of a closed loop: distances, inputs, estimates with two deviations, constraints with what they
 * allow, and times. */
function loopCurves({ rows, columns, limits }) {
    const all = columns.map(column), of = name => all.find(one => one.name === name);
    const begun = kind => all.filter(one => one.name.startsWith(kind));
    const line = (name, from, more) => from && { name, count: rows, x: all[0].at, y: from.at, ...more };
    const level = (name, value) => typeof value === "number"
        && line(name, { at: () => value }, { dashed: true });
    const curve = (title, series, yUnit = "", log = false) =>
        ({ title, x: "t", xUnit: "s", yUnit, log, series: series.filter(one => one) });
    const estimates = begun("estimate_").map(one => {
        const name = one.name.slice(9), band = of("deviation_" + name), truth = of("truth_" + name);
        return curve("Estimate of " + name, [
            line(band ? "estimate with two deviations" : "estimate", one,
                band && { half: i => 2 * band.at(i) }),
            truth && Number.isFinite(truth.at(0)) && line("truth", truth, { dashed: true })]);
    });
    return [
        curve("Distance", [line("place off the path", all[1]),
            line("estimate off the place", of("estimate off the place"))], "m", true),
        curve("Inputs", begun("input_").map(one => line(one.name.slice(6), one))),
        ...estimates,
        ...begun("constraint").map((one, k) => curve(one.name, [line("value", one),
            ...(limits[k] || []).map((at, side) => level(side ? "at most" : "at least", at))])),
        curve("Time that a period takes", [line("filter", of("filter_seconds")),
            line("controller", of("control_seconds"))], "s", true)];
}
