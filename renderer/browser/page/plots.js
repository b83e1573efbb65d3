// Plots of scalars: choice of the curves, zoom, pause, a cursor, and the table as a file.
import {COLORS, drawCurves, firstAt, numberText} from "./curves.js";
import {download} from "./download.js";
import {Series} from "./series.js";

const MAX_ROWS = 200;
const MIN_SPAN_NS = 1e3, MAX_SPAN_NS = 1e19;
const ZOOM_PER_NOTCH = 0.8, CLICK_PX = 4;

export class Plots {
  // elements: section, canvas, pause, all, csv, cursor, search, list, omitted. handlers: send(message), shownNs(): BigInt or null, name()
  constructor(elements, handlers) {
    this.elements = elements;
    this.handlers = handlers;
    this.chosen = new Array(COLORS).fill(null);  // a free place keeps the colours of the others
    this.list = 0;
    this.scalars = [];  // {key, name, unit}
    this.series = new Series();
    this.fixed = null;  // range of time; null: the whole history
    this.hovered = this.pinned = null;  // times
    this.pointers = new Map();
    this.isDirty = false;
    elements.section.addEventListener("toggle", () => this.subscribe());
    elements.pause.onclick = () => this.pause();
    elements.all.onclick = () => this.showAll();
    elements.csv.onclick = () => this.save();
    elements.search.addEventListener("input", () => this.drawList());
    const canvas = elements.canvas;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, (event) => this.up(event));
    canvas.addEventListener("pointerleave", () => { this.hovered = null; this.dirty(); });
    canvas.addEventListener("wheel", (event) => this.wheel(event), {passive: false});
    canvas.addEventListener("dblclick", () => this.showAll());
    canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.dirty()).observe(canvas);
    matchMedia("(prefers-color-scheme: light)").addEventListener("change", () => this.dirty());
  }

  // --- messages ---

  reconnect() {
    this.list = 0;
    this.subscribe();
  }

  setCount(count) { this.elements.section.hidden = count === 0 && !this.elements.section.open; }

  setList(message) {
    this.list = message.list;
    const streams = new Set(message.scalars.map(([stream]) => stream));
    this.scalars = message.scalars.map(([stream, group, name, unit]) =>
      ({key: JSON.stringify([stream, group, name]), name: `${streams.size > 1 ? `${stream}: ` : ""}${group}/${name}`, unit}));
    this.elements.omitted.hidden = message.omitted === 0;
    this.elements.omitted.textContent = `${message.omitted} further scalars are not listed`;
    this.elements.search.hidden = this.scalars.length <= 12;
    this.drawList();
    this.subscribe();
  }

  subscribe() {
    if (!this.elements.section.open) return this.handlers.send({type: "plot", on: false, list: 0, scalars: []});
    const indices = this.chosen.map((key) => this.scalars.findIndex((scalar) => scalar.key === key)).filter((index) => index >= 0);
    this.handlers.send({type: "plot", on: true, list: this.list, scalars: this.list === 0 ? [] : indices});
    this.dirty();
  }

  addSamples(message) {
    if (message.list === this.list) this.series.add(message, this.scalars.map((scalar) => scalar.key));
    this.dirty();
    requestAnimationFrame(() => this.handlers.send({type: "plotted", number: message.number}));
  }

  // --- choice ---

  toggle(key) {
    const place = this.chosen.indexOf(key), free = this.chosen.indexOf(null);
    if (place >= 0) this.chosen[place] = null;
    else if (free >= 0) this.chosen[free] = key;
    this.series.keepOnly(this.chosen);
    if (this.series.origin === null) this.fixed = this.pinned = null;
    this.drawList();
    this.subscribe();
  }

  drawList() {
    const wanted = this.elements.search.value.trim().toLowerCase();
    const found = this.scalars.filter((scalar) => scalar.name.toLowerCase().includes(wanted)).slice(0, MAX_ROWS);
    const isFull = !this.chosen.includes(null);
    this.elements.list.replaceChildren(...found.map((scalar) => {
      const item = document.createElement("li"), label = document.createElement("label"), check = document.createElement("input");
      const name = document.createElement("span"), value = document.createElement("output");
      const place = this.chosen.indexOf(scalar.key);
      check.type = "checkbox";
      check.checked = place >= 0;
      check.disabled = isFull && place < 0;
      check.onchange = () => this.toggle(scalar.key);
      label.className = place >= 0 ? `curve-${place}` : "";
      name.textContent = name.title = scalar.name;
      value.dataset.key = scalar.key;
      label.append(check, name, value);
      item.append(label);
      return item;
    }));
    this.dirty();
  }

  // --- range and cursor ---

  get range() {
    if (this.fixed) return this.fixed;
    const [low, high] = this.series.wholeRange() ?? [0, 1e9];
    return [low, Math.max(high, low + MIN_SPAN_NS)];
  }

  pause() {
    this.fixed = this.fixed ? null : this.range;
    this.dirty();
  }

  showAll() {
    this.fixed = this.pinned = null;
    this.dirty();
  }

  timeAt(clientX) {
    const box = this.elements.canvas.getBoundingClientRect(), [low, high] = this.range;
    return low + (high - low) * (clientX - box.left) / box.width;
  }

  zoom(factor, time) {
    const [low, high] = this.range, span = high - low;
    const scale = Math.min(MAX_SPAN_NS, Math.max(MIN_SPAN_NS, span * factor)) / span;
    this.fixed = [time - (time - low) * scale, time + (high - time) * scale];
    this.dirty();
  }

  pan(pixels) {
    const [low, high] = this.range, moved = (high - low) * pixels / this.elements.canvas.clientWidth;
    this.fixed = [low - moved, high - moved];
    this.dirty();
  }

  down(event) {
    this.elements.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, event.clientX);
    this.moved = this.pointers.size > 1 ? CLICK_PX : 0;
  }

  move(event) {
    this.hovered = this.timeAt(event.clientX);
    const before = this.pointers.get(event.pointerId);
    if (before !== undefined) {
      this.moved += Math.abs(event.clientX - before);
      const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, x]) => x);
      this.pointers.set(event.pointerId, event.clientX);
      if (other !== undefined) {
        const spread = Math.abs(event.clientX - other), old = Math.abs(before - other);
        if (spread > 8 && old > 8) this.zoom(old / spread, this.timeAt((event.clientX + other) / 2));
      } else if (this.moved >= CLICK_PX) {
        this.pan(event.clientX - before);
      }
    }
    this.dirty();
  }

  up(event) {
    if (!this.pointers.delete(event.pointerId) || event.type !== "pointerup" || this.moved >= CLICK_PX) return;
    this.pinned = this.pinned === null ? this.timeAt(event.clientX) : null;
    this.dirty();
  }

  wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 100 : event.deltaY / 3;
    this.zoom(ZOOM_PER_NOTCH ** -lines, this.timeAt(event.clientX));
  }

  key(event) {
    const [low, high] = this.range, middle = this.pinned ?? (low + high) / 2, step = (high - low) / 50;
    const move = (by) => { this.pinned = Math.min(high, Math.max(low, middle + by)); };
    const keys = {
      ArrowLeft: () => move(-step), ArrowRight: () => move(step), "+": () => this.zoom(ZOOM_PER_NOTCH, middle), "-": () => this.zoom(1 / ZOOM_PER_NOTCH, middle),
      " ": () => this.pause(), Home: () => this.showAll(), Escape: () => { this.pinned = null; },
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    event.stopPropagation();  // the view has these keys, too
    keys[event.key]();
    this.dirty();
  }

  // --- drawing ---

  dirty() {
    if (this.isDirty) return;
    this.isDirty = true;
    requestAnimationFrame(() => { this.isDirty = false; this.draw(); });
  }

  draw() {
    if (!this.elements.section.open) return;
    const curves = this.chosen.map((key, color) => ({...this.series.curves.get(key), key, color})).filter((curve) => curve.times);
    const cursor = this.hovered ?? this.pinned, shown = this.handlers.shownNs();
    const lines = [];
    if (shown !== null && this.series.origin !== null) lines.push({at: Number(shown - this.series.origin), name: "--accent"});
    if (cursor !== null) lines.push({at: cursor, name: "--text"});
    const isChosen = this.chosen.some((key) => key !== null);
    drawCurves(this.elements.canvas, {curves, range: this.range, lines, originS: this.series.originS,
                                      empty: curves.length > 0 ? "" : isChosen ? "No samples yet." : "Choose scalars below."});
    this.elements.pause.setAttribute("aria-pressed", String(this.fixed !== null));
    this.elements.all.disabled = this.fixed === null;
    this.elements.csv.disabled = curves.length === 0;
    this.elements.cursor.textContent = cursor === null || this.series.origin === null ? "newest values" : `at ${numberText(this.series.originS + cursor * 1e-9)} s`;
    for (const output of this.elements.list.querySelectorAll("output")) output.textContent = this.valueText(output.dataset.key, cursor);
  }

  // The newest value that is not after the cursor, with its unit.
  valueText(key, cursor) {
    const unit = this.scalars.find((scalar) => scalar.key === key)?.unit ?? "";
    const curve = this.series.curves.get(key);
    if (!curve) return unit;
    const index = cursor === null ? curve.times.length - 1 : firstAt(curve.times, cursor + 0.5) - 1;
    const value = index >= 0 ? curve.values[index] : null;
    return `${value === null ? "–" : numberText(value)} ${unit}`.trim();
  }

  save() {
    const columns = this.chosen.filter((key) => this.series.curves.has(key)).map((key) => {
      const scalar = this.scalars.find((each) => each.key === key), [, group, name] = JSON.parse(key);
      return {key, title: scalar?.unit ? `${scalar.name} [${scalar.unit}]` : scalar?.name ?? `${group}/${name}`};
    });
    download(new Blob([this.series.csv(columns, this.range)], {type: "text/csv"}), `${this.handlers.name()} scalars.csv`);
  }
}
