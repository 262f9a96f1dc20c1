"use strict";
/* Numbers: columns of the data, vectors of three as arrays, and how numbers are written. */

/* A column as { name, unit, at(i), low, high }; its numbers are Float32, rounded ones to 1/65534 of
 * their range, or `values` that the page has computed. */
function column(from) {
    const result = { name: from.name, unit: from.unit || "", low: Infinity, high: -Infinity };
    if (from.values) {
        return withRange(result, from.values);
    }
    if (!("kind" in from)) {
        const value = from.value === null ? NaN : from.value;
        result.at = () => value;
        result.low = result.high = value;
        return result;
    }
    const bytes = bytesOf(from.data);
    let values;
    if (from.kind === "f4") {
        values = new Float32Array(bytes.buffer);
    } else {
        const few = new Int16Array(bytes.buffer);
        const step = (from.high - from.low) / 65534;
        values = new Float32Array(few.length);
        for (let i = 0; i < few.length; i++) {
            values[i] = few[i] === -32768 ? NaN : from.low + (few[i] + 32767) * step;
        }
    }
    return withRange(result, values);
}

const bytesOf = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));

function withRange(result, values) {
    for (const value of values) {
        if (value < result.low) {
            result.low = value;
        }
        if (value > result.high) {
            result.high = value;
        }
    }
    result.at = i => values[i];
    return result;
}

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (a, k) => [a[0] * k, a[1] * k, a[2] * k];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
    a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = a => Math.hypot(a[0], a[1], a[2]);

function unitVector(a, otherwise) {
    const size = norm(a);
    return size > 0 ? times(a, 1 / size) : otherwise;
}

/* Some vector across a unit vector. */
function across(a) {
    return unitVector(cross(a, Math.abs(a[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
}

/* Directors d1, d2, d3 of a quaternion (w, x, y, z). */
function directors(w, x, y, z) {
    const n = 2 / (w * w + x * x + y * y + z * z || 1);
    return [
        [1 - n * (y * y + z * z), n * (x * y + w * z), n * (x * z - w * y)],
        [n * (x * y - w * z), 1 - n * (x * x + z * z), n * (y * z + w * x)],
        [n * (x * z + w * y), n * (y * z - w * x), 1 - n * (x * x + y * y)]];
}

/* 1, 2 or 5 times a power of ten, about `size`. */
function round125(size) {
    const power = Math.pow(10, Math.floor(Math.log10(size)));
    const digit = size / power;
    return power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}

/* What has a prefix of the SI, and less than this of it is what rounding leaves of 0. */
const hasPrefix = unit => /^(m|s|N|N m|Pa|m\/s|N\/m|J)$/.test(unit);
const NOTHING = 1e-15;

/* What to multiply numbers of about `size` with, and the unit they are then in. */
function prefix(size, unit) {
    const rows = [["G", 1e9], ["M", 1e6], ["k", 1e3], ["", 1], ["m", 1e-3], ["\u00b5", 1e-6],
        ["n", 1e-9], ["p", 1e-12], ["f", NOTHING]];
    const most = /^(m|s|m\/s)$/.test(unit) ? 3 : 0; /* no kilometres */
    const row = hasPrefix(unit) && rows.slice(most).find(r => size >= 0.9999 * r[1]);
    return row ? { factor: 1 / row[1], unit: row[0] + unit } : { factor: 1, unit: unit };
}

function digits(value, count = 4) {
    if (!Number.isFinite(value)) {
        return "\u2013";
    }
    const text = value === 0 || (Math.abs(value) >= 1e-3 && Math.abs(value) < 1e6)
        ? String(Number(value.toPrecision(count)))
        : value.toExponential(count - 2);
    return text.replace("-", "\u2212");
}

/* One of the numbers on an axis that are `step` apart: all have as many digits. */
function tickText(value, step) {
    const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const most = Math.max(Math.abs(value), step);
    return places > 6 || most >= 1e6 ? digits(Math.abs(value) < step / 2 ? 0 : value, 3)
        : (value.toFixed(places) * 1 === 0 ? "0" : value.toFixed(places)).replace("-", "\u2212");
}

function withUnit(given, unit, count = 4) {
    const value = hasPrefix(unit) && Math.abs(given) < NOTHING ? 0 : given;
    const as = prefix(Math.abs(value), unit);
    return digits(value * as.factor, count) + (as.unit ? " " + as.unit : "");
}
