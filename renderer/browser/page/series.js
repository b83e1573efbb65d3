// Samples of the plotted scalars, as the renderer sends them, and their table as CSV.
const MAX_SAMPLES = 10000;  // of a curve, as the renderer keeps

export class Series {
  constructor() {
    this.curves = new Map();  // by the scalar's key: {times, values}; times in ns since the origin, values null: none
    this.origin = null;       // BigInt, ns
  }

  get originS() { return this.origin === null ? 0 : Number(this.origin) * 1e-9; }

  // keys: of the listed scalars.
  add(message, keys) {
    const base = BigInt(message.base_ns);
    this.origin ??= base;
    const shift = Number(base - this.origin);
    for (const part of message.curves) {
      const key = keys[part.scalar];
      if (key === undefined) continue;
      if (part.restarts || !this.curves.has(key)) this.curves.set(key, {times: [], values: []});
      const {times, values} = this.curves.get(key);
      part.t_ns.forEach((offset, i) => {
        const time = offset + shift;
        if (times.length > 0 && time <= times.at(-1)) {
          if (time === times.at(-1)) values[values.length - 1] = part.values[i];
          return;
        }
        times.push(time);
        values.push(part.values[i]);
      });
      const excess = times.length - MAX_SAMPLES;
      if (excess > MAX_SAMPLES / 10) {
        times.splice(0, excess);
        values.splice(0, excess);
      }
    }
  }

  keepOnly(keys) {
    for (const key of this.curves.keys()) if (!keys.includes(key)) this.curves.delete(key);
    if (this.curves.size === 0) this.origin = null;
  }

  // Times of all curves; null: there are no samples.
  wholeRange() {
    let low = Infinity, high = -Infinity;
    for (const {times} of this.curves.values()) {
      if (times.length === 0) continue;
      low = Math.min(low, times[0]);
      high = Math.max(high, times.at(-1));
    }
    return low <= high ? [low, high] : null;
  }

  seconds(time) {
    const ns = this.origin + BigInt(Math.round(time));
    const digits = String(ns < 0n ? -ns : ns).padStart(10, "0");
    return `${ns < 0n ? "-" : ""}${digits.slice(0, -9)}.${digits.slice(-9)}`;
  }

  // A row for each time from low to high, a column for each scalar. columns: [{key, title}]
  csv(columns, [low, high]) {
    // An apostrophe before what spreadsheets take for a formula: titles come from simulators.
    const quoted = (text) => `"${(/^[=+\-@\t\r]/.test(text) ? "'" : "") + text.replaceAll('"', '""')}"`;
    const rows = new Map();  // time -> cells
    columns.forEach(({key}, column) => {
      const curve = this.curves.get(key);
      curve?.times.forEach((time, i) => {
        if (time < low || time > high) return;
        if (!rows.has(time)) rows.set(time, new Array(columns.length).fill(""));
        if (curve.values[i] !== null) rows.get(time)[column] = String(curve.values[i]);
      });
    });
    const lines = [["sim_time_s", ...columns.map((column) => quoted(column.title))].join(",")];
    for (const time of [...rows.keys()].sort((a, b) => a - b)) lines.push([this.seconds(time), ...rows.get(time)].join(","));
    return lines.join("\r\n") + "\r\n";
  }
}
