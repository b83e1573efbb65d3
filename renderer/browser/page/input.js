// Mouse, touch and keyboard on the canvas, as camera moves: at most one message of each kind for each frame.
const ORBIT_RAD_PER_HEIGHT = 3;
const ZOOM_PER_NOTCH = 0.85;
const FLY_RADII_PER_S = 0.5;
const CLICK_PX = 4;
const KEY_ORBIT_RAD_PER_S = 1.2;
const TAP_S = 0.05;

export class Input {
  // handlers: send(message), pick(x, y, frames), key(event)
  constructor(canvas, handlers) {
    this.canvas = canvas;
    this.handlers = handlers;
    this.pointers = new Map();
    this.held = new Set();
    this.clear();
    this.frame = 0;
    this.before = 0;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, (event) => this.up(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => this.wheel(event), {passive: false});
    canvas.addEventListener("dblclick", (event) => this.pick(event, true));
    window.addEventListener("keydown", (event) => this.keyDown(event));
    window.addEventListener("keyup", (event) => this.release(event.key.toLowerCase()));
    window.addEventListener("blur", () => this.held.clear());
  }

  clear() {
    this.orbit = [0, 0];
    this.pan = [0, 0];
    this.zoom = {factor: 1, x: 0, y: 0};
  }

  // Position in normalised device coordinates: -1 to 1, y down.
  ndc(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const limit = (value) => Math.min(1, Math.max(-1, value));
    return [limit(2 * (x - box.left) / box.width - 1), limit(2 * (y - box.top) / box.height - 1)];
  }

  down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.focus({preventScroll: true});
    this.canvas.classList.add("pointed");  // no focus ring before a key is pressed
    this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
    this.moved = this.pointers.size > 1 ? CLICK_PX : 0;
    this.pans = event.button !== 0 || event.shiftKey || event.ctrlKey;
  }

  move(event) {
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) return;
    const before = this.gesture();
    const dx = event.clientX - pointer.x, dy = event.clientY - pointer.y;
    this.moved += Math.hypot(dx, dy);
    if (this.moved < CLICK_PX && this.pointers.size === 1) {
      return;  // trembling; the first real move includes it
    }
    pointer.x = event.clientX;
    pointer.y = event.clientY;
    const height = this.canvas.clientHeight;
    if (this.pointers.size === 1) {
      const target = this.pans ? this.pan : this.orbit;
      target[0] += dx / height;
      target[1] += dy / height;
    } else if (this.pointers.size === 2) {
      const now = this.gesture();
      this.pan[0] += (now.x - before.x) / height;
      this.pan[1] += (now.y - before.y) / height;
      if (now.spread > 1 && before.spread > 1) this.zoomBy(before.spread / now.spread, now.x, now.y);
    }
    this.wake();
  }

  // Centre and spread of two fingers.
  gesture() {
    const [a, b] = [...this.pointers.values()];
    if (!b) return {x: a.x, y: a.y, spread: 0};
    return {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, spread: Math.hypot(a.x - b.x, a.y - b.y)};
  }

  up(event) {
    const isClick = this.pointers.size === 1 && this.moved < CLICK_PX && !this.pans && event.type === "pointerup";
    if (this.pointers.delete(event.pointerId) && isClick) this.pick(event, false);
  }

  pick(event, frames) {
    const [x, y] = this.ndc(event.clientX, event.clientY);
    this.handlers.pick((x + 1) / 2, (y + 1) / 2, frames);
  }

  wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 100 : event.deltaY / 3;
    this.zoomBy(ZOOM_PER_NOTCH ** -lines, event.clientX, event.clientY);
    this.wake();
  }

  zoomBy(factor, x, y) {
    [this.zoom.x, this.zoom.y] = this.ndc(x, y);
    this.zoom.factor = Math.min(100, Math.max(0.01, this.zoom.factor * factor));
  }

  keyDown(event) {
    this.canvas.classList.remove("pointed");
    if (event.target.matches("input, select") || event.ctrlKey || event.altKey || event.metaKey) return;
    const key = event.key.toLowerCase();
    if ("wasdqe+-=".includes(key) || key.startsWith("arrow")) {
      if (event.target.matches("button, summary") && key.startsWith("arrow")) return;
      this.shift = event.shiftKey;
      event.preventDefault();
      if (!this.held.has(key)) {
        this.held.add(key);
        this.moveByKeys(TAP_S);  // the key may be released before the next frame
      }
      this.wake();
    } else {
      this.handlers.key(event);
    }
  }

  // + is released as = by whoever releases Shift first.
  release(key) {
    for (const held of key === "=" || key === "+" ? "=+" : [key]) this.held.delete(held);
  }

  wake() {
    if (!this.frame) {
      this.before = performance.now();
      this.frame = requestAnimationFrame((now) => this.flush(now));
    }
  }

  // Moves of held keys since the last frame.
  moveByKeys(seconds) {
    const axis = (plus, minus) => (this.held.has(plus) ? 1 : 0) - (this.held.has(minus) ? 1 : 0);
    const turn = [axis("arrowright", "arrowleft"), axis("arrowdown", "arrowup")];
    const target = this.shift ? this.pan : this.orbit;
    for (const i of [0, 1]) target[i] += turn[i] * seconds * KEY_ORBIT_RAD_PER_S / ORBIT_RAD_PER_HEIGHT;
    const zoom = axis("-", "+") - axis("=", "");
    if (zoom) this.zoom = {factor: this.zoom.factor * 2 ** (zoom * seconds), x: 0, y: 0};
    const step = seconds * FLY_RADII_PER_S;
    const fly = {right: axis("d", "a") * step, up: axis("e", "q") * step, back: axis("s", "w") * step};
    if (fly.right || fly.up || fly.back) this.handlers.send({type: "fly", ...fly});
  }

  flush(now) {
    this.frame = 0;
    this.moveByKeys(Math.min(0.1, Math.max(0.016, (now - this.before) / 1000)));
    if (this.orbit[0] || this.orbit[1])
      this.handlers.send({type: "orbit", yaw: -this.orbit[0] * ORBIT_RAD_PER_HEIGHT, pitch: this.orbit[1] * ORBIT_RAD_PER_HEIGHT});
    if (this.pan[0] || this.pan[1]) this.handlers.send({type: "pan", right: -this.pan[0], up: this.pan[1]});
    if (this.zoom.factor !== 1) this.handlers.send({type: "zoom", ...this.zoom});
    this.clear();
    if (this.held.size > 0) this.wake();
  }
}
