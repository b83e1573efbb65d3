// Drawing of curves over time on a canvas: grid, curves, and vertical lines. Times are ns since an origin.
const MARGIN = 0.1;  // of the range of values, above and below
const TICK_PX = {x: 80, y: 34};
export const COLORS = 8;

// First index whose time is not before this one.
export function firstAt(times, time) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < time) low = middle + 1;
    else high = middle;
  }
  return low;
}

// Samples in a range of time, with one beyond each end: lines continue to the edge.
function within(curve, [low, high]) {
  return [Math.max(0, firstAt(curve.times, low) - 1), Math.min(curve.times.length, firstAt(curve.times, high) + 2)];
}

export function valueRange(curves, range) {
  let low = Infinity, high = -Infinity;
  for (const curve of curves) {
    const [begin, end] = within(curve, range);
    for (let i = begin; i < end; ++i) {
      const value = curve.values[i];
      if (value === null) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!(low <= high)) return [-1, 1];
  const half = high / 2 - low / 2;
  const margin = half > 0 ? 2 * half * MARGIN : Math.max(Math.abs(high) * MARGIN, 1e-9);
  return [Math.max(low - margin, -Number.MAX_VALUE), Math.min(high + margin, Number.MAX_VALUE)];
}

// Step of 1, 2 or 5 times a power of ten, at least this wide.
function tickStep(least) {
  const decade = 10 ** Math.floor(Math.log10(least));
  return decade * ([1, 2, 5].find((factor) => factor * decade >= least) ?? 10);
}

export const numberText = (value) => String(Number(value.toPrecision(6)));

function ticks(low, high, pixels, perTick) {
  const span = high - low;
  if (!(span > 0) || !Number.isFinite(span)) return [];
  const step = tickStep(span * perTick / Math.max(pixels, 1));
  const made = [];
  for (let at = Math.ceil(low / step) * step; at <= high && made.length < 64; at += step) made.push(Math.abs(at) < step / 1e6 ? 0 : at);
  return made;
}

// curves: [{times, values, color}] with null for no value. range: of time. lines: [{at, color}]. originS: time of the origin in seconds.
export function drawCurves(canvas, {curves, range, lines, originS, empty}) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (width === 0 || height === 0) return;
  const pixels = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== pixels[0] || canvas.height !== pixels[1]) [canvas.width, canvas.height] = pixels;
  const context = canvas.getContext("2d");
  const style = getComputedStyle(canvas);
  const color = (name) => style.getPropertyValue(name).trim();
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = color("--well");
  context.fillRect(0, 0, width, height);
  context.font = "11px system-ui, sans-serif";
  if (empty) {
    context.fillStyle = color("--dim");
    context.fillText(empty, 8, 18);
    return;
  }
  const values = valueRange(curves, range);
  const x = (time) => (time - range[0]) / (range[1] - range[0]) * width;
  // Halves do not overflow.
  const y = (value) => height - (value / 2 - values[0] / 2) / (values[1] / 2 - values[0] / 2) * height;
  context.lineWidth = 1;
  context.strokeStyle = color("--line");
  const labels = [];
  const line = (x0, y0, x1, y1) => {
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
    context.stroke();
  };
  for (const second of ticks(originS + range[0] * 1e-9, originS + range[1] * 1e-9, width, TICK_PX.x)) {
    const at = x((second - originS) * 1e9);
    line(at, 0, at, height);
    labels.push([`${numberText(second)} s`, at + 3, height - 4]);
  }
  for (const value of ticks(values[0], values[1], height, TICK_PX.y)) {
    line(0, y(value), width, y(value));
    if (y(value) > 14 && y(value) < height - 16) labels.push([numberText(value), 3, y(value) - 3]);
  }
  for (const {at, name} of lines) {
    if (!(at >= range[0] && at <= range[1])) continue;
    context.strokeStyle = color(name);
    line(x(at), 0, x(at), height);
  }
  context.lineWidth = 1.4;
  context.lineJoin = "round";
  for (const curve of curves) {
    context.strokeStyle = context.fillStyle = color(`--curve-${curve.color}`);
    drawCurve(context, curve, within(curve, range), x, y);
  }
  // Labels stay legible above the curves.
  context.strokeStyle = color("--well");
  context.fillStyle = color("--dim");
  context.lineWidth = 3;
  for (const label of labels) {
    context.strokeText(...label);
    context.fillText(...label);
  }
}

// A column of many samples shows their first, least, largest and last value.
function drawCurve(context, curve, [begin, end], x, y) {
  let column = null, points = 0;
  const add = (at, value) => {
    if (points++ === 0) context.moveTo(at, value);
    else context.lineTo(at, value);
  };
  const flush = () => {
    if (!column) return;
    if (column.high - column.low > 0.5) {
      add(column.x, column.low);
      add(column.x, column.high);
    }
    add(column.x, column.last);
  };
  const stroke = () => {
    flush();
    context.stroke();
    if (points === 2 && column) context.fillRect(column.x - 1.5, column.last - 1.5, 3, 3);  // a sample without neighbours
    context.beginPath();
    column = null;
    points = 0;
  };
  context.beginPath();
  for (let i = begin; i < end; ++i) {
    if (curve.values[i] === null) {
      stroke();
      continue;
    }
    const at = x(curve.times[i]), value = y(curve.values[i]);
    if (column && Math.abs(at - column.x) < 0.5) {
      column.low = Math.min(column.low, value);
      column.high = Math.max(column.high, value);
      column.last = value;
      continue;
    }
    flush();
    add(at, value);
    column = {x: at, low: value, high: value, last: value};
  }
  stroke();
}
