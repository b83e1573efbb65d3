// Streams, viewers, the timeline of a replay, and the statistics of this viewer.
const NAMES = {jpeg: "JPEG", h264: "H.264", vp8: "VP8"};
const PLAY = "M4 2.5 13 8l-9 5.5z";
const PAUSE = "M4 3h3v10H4zM9 3h3v10H9z";

const counted = (count, what) => `${count} ${what}${count === 1 ? "" : "s"}`;
const seconds = (value) => `${Math.floor(value / 60)}:${(value % 60).toFixed(1).padStart(4, "0")}`;

function element(tag, className, text) {
  const made = document.createElement(tag);
  made.className = className;
  made.textContent = text;
  return made;
}

// isPaused: of the timeline, on which no frame is late.
export function drawStreams(parent, streams, isPaused) {
  parent.replaceChildren(...streams.map((stream) => {
    const row = element("div", "stream", "");
    const condition = isPaused ? "paused" : stream.condition;
    row.append(element("span", `dot ${condition}`, ""), element("span", "name", stream.name),
               element("span", "number", `${stream.rate_hz.toFixed(1)} Hz`));
    const share = Math.round(100 * (stream.drawing_share || 0));
    const drawing = stream.content_hidden ? ", content hidden: it takes too much drawing time" : share > 0 ? `, ${share} % of drawing time` : "";
    const unmatched = stream.unmatched > 0 ? `, ${stream.unmatched} without a node` : "";
    row.append(element("span", "facts dim", `${condition}, ${counted(stream.frames, "frame")}, ${counted(stream.nodes, "pose")}${unmatched}${drawing}, t = ${stream.sim_time_s.toFixed(2)} s`));
    return row;
  }));
}

export function drawViewers(parent, viewers) {
  parent.hidden = false;
  parent.querySelector("summary").textContent = viewers.length === 1 ? "1 viewer" : `${viewers.length} viewers`;
  parent.querySelector("ul").replaceChildren(...viewers.map((viewer) => {
    const row = element("li", viewer.own ? "viewer own" : "viewer", "");
    row.append(element("span", "", `Viewer ${viewer.number}${viewer.own ? " (this page)" : ""}`), element("span", "dim", viewer.control ? "control" : "view only"));
    return row;
  }));
}

export class Timeline {
  // send(message)
  constructor(send) {
    this.bar = document.getElementById("timeline");
    this.seek = document.getElementById("seek");
    this.position = document.getElementById("position");
    this.icon = document.getElementById("play-icon");
    this.send = send;
    this.playing = false;
    document.getElementById("play").onclick = () => this.toggle();
    document.getElementById("step").onclick = () => this.step(true);
    document.getElementById("step-back").onclick = () => this.step(false);
    this.seek.addEventListener("input", () => this.send({type: "seek", fraction: Number(this.seek.value)}));
  }

  get shown() { return !this.bar.hidden; }
  toggle() { this.send({type: "play", playing: !this.playing}); }
  step(forwards) { this.send({type: "step", forwards}); }

  draw(timeline, mayControl) {
    this.bar.hidden = !timeline;
    if (!timeline) return;
    this.playing = timeline.playing;
    this.icon.setAttribute("d", timeline.playing ? PAUSE : PLAY);
    for (const control of this.bar.querySelectorAll("button, input")) control.disabled = !mayControl;
    if (!this.seek.matches(":active")) this.seek.value = timeline.duration_s > 0 ? timeline.position_s / timeline.duration_s : 0;
    this.position.textContent = `${seconds(timeline.position_s)} / ${seconds(timeline.duration_s)}`;
  }
}

const samplesText = (message, viewers) => `${message.samples} / ${message.samples_per_pixel} samples${message.waits && viewers > 1 ? ", other views refine first" : ""}`;

// Samples of the image, and images and bytes a second of the display.
export class Statistics {
  constructor(parent, display) {
    this.viewers = 1;
    this.samples = parent.appendChild(element("div", "", ""));
    this.samples.id = "samples";
    const rates = parent.appendChild(element("div", "", ""));
    let images = 0, bytes = 0, before = performance.now();
    setInterval(() => {
      const now = performance.now(), span = (now - before) / 1000;
      const rate = (display.images - images) / span, volume = (display.bytes - bytes) / span / 1024;
      [images, bytes, before] = [display.images, display.bytes, now];
      const size = display.last ? `${display.last.width} × ${display.last.height}, ${NAMES[display.last.codec]}` : "no image";
      rates.textContent = `${size}, ${rate.toFixed(0)} images/s, ${volume.toFixed(0)} KiB/s`;
    }, 1000);
  }

  // Of a path-traced image; the raster has none.
  setPaths(message) { this.samples.textContent = message.samples_per_pixel > 0 ? samplesText(message, this.viewers) : ""; }
}
