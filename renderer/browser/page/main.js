// Live view of a FIRE-3DV renderer: joins connection, display, input and panel.
import {Connection} from "./connection.js";
import {Controls} from "./controls.js";
import {Display} from "./display.js";
import {Recorder} from "./download.js";
import {Input} from "./input.js";
import {Joints} from "./joints.js";
import {Link} from "./link.js";
import {Nodes} from "./nodes.js";
import {degrees} from "./rotation.js";
import {Plots} from "./plots.js";
import {Settings} from "./settings.js";
import {Statistics, Timeline, drawStreams, drawViewers} from "./status.js";

const at = (id) => document.getElementById(id);
const query = new URLSearchParams(location.search);
document.body.classList.toggle("embed", query.get("embed") === "1");

let mayControl = false, camera = "", cameraCount = 0, scene = 0, selected = null, framesPicked = false, noticeTimer = 0, viewToken = "", streams = [];
const link = new Link();
const send = (message) => connection.send(message);
const control = (message) => { if (mayControl) send(message); };

const display = new Display(at("canvas"), () => connection);
const nodes = new Nodes({tree: at("tree"), search: at("search"), omitted: at("omitted")}, {
  select: (node) => select(node, nodes.names[node]),
  hide: (node, hidden) => control({type: "hide", node, scene, hidden}),
});
const timeline = new Timeline(control);
const fileName = () => at("title").textContent || "fire3dv";
const plots = new Plots({section: at("plots"), canvas: at("plot"), pause: at("plot-pause"), all: at("plot-all"), csv: at("plot-csv"), cursor: at("plot-cursor"),
                         search: at("plot-search"), list: at("scalars"), omitted: at("scalars-omitted")},
                        {send, shownNs: () => display.simTimeNs, name: fileName});
const joints = new Joints({section: at("joints"), posture: at("posture"), list: at("joint-list")}, control);
const controls = new Controls({section: at("controls"), list: at("control-list"), omitted: at("controls-omitted")}, control);
const settings = new Settings(at("settings"), control);
const recorder = new Recorder(at("canvas"), fileName, () => {
  at("record").setAttribute("aria-pressed", String(recorder.isRecording));
  at("record").title = recorder.isRecording ? "Stop and save the video (R)" : "Record a video (R)";
});
const statistics = new Statistics(at("statistics"), display);

function notice(text) {
  at("notice").textContent = text;
  at("notice").hidden = false;
  clearTimeout(noticeTimer);
  noticeTimer = setTimeout(() => { at("notice").hidden = true; }, 6000);
}

function select(node, name, details) {
  selected = node;
  link.setNode(node === null ? null : nodes.path(node));
  at("selection").hidden = node === null;
  at("picked-name").textContent = name ?? "";
  describe(details);
  nodes.select(node);
  drawVisibility();
  if (node !== null && !details) inspect();
}

const inspect = () => { if (selected !== null) send({type: "inspect", node: selected, scene}); };
setInterval(inspect, 500);  // its pose may change

function describe(details) {
  const rounded = (values, digits = 3) => values.map((value) => value.toFixed(digits).replace(/^-(0\.0*)$/, "$1")).join(", ");
  at("picked-path").textContent = details?.path ?? "";
  at("picked-position").textContent = details ? `${rounded(details.position_m)} m` : "";
  at("picked-rotation").textContent = details ? `${rounded(degrees(details.world_from_node), 1)} °` : "";
  at("picked-stream").textContent = details?.stream ?? (details ? "none" : "");
}


function drawVisibility() {
  at("hide").textContent = nodes.isHidden(selected) ? "Show" : "Hide";
  at("isolate").textContent = nodes.isolated !== null && nodes.isolated === selected ? "Show others" : "Isolate";
  at("show-all").hidden = nodes.hidden.size === 0 && nodes.isolated === null;
}

const frame = () => send(selected === null ? {type: "frame"} : {type: "frame", node: selected, scene});
const hide = () => { if (selected !== null) control({type: "hide", node: selected, scene, hidden: !nodes.isHidden(selected)}); };
const isolate = () => { if (selected !== null) control(nodes.isolated === selected ? {type: "isolate"} : {type: "isolate", node: selected, scene}); };
const screenshot = () => display.save(`${fileName()} ${display.last?.number ?? ""}`.trim());
const record = () => { if (Recorder.type()) recorder.toggle(); };

// The control link is not handed on by accident: it is in the address bar.
async function share() {
  try {
    await navigator.clipboard.writeText(link.address(viewToken));
    notice("A view-only link to this view is on the clipboard.");
  } catch {
    notice("The browser does not allow copying; copy this page's address instead. It has the rights of this page.");
  }
}

const sendQuality = () => send({type: "quality", sharp: at("quality").value === "sharp"});
const togglePanel = () => document.body.classList.toggle("no-panel");

function useCamera(index) {
  if (index !== null && index >= cameraCount) return;
  send(index === null ? {type: "camera"} : {type: "camera", index});
}

const messages = {
  welcome(message) {
    mayControl = message.control;
    document.body.classList.toggle("may-control", mayControl);
    document.title = `${message.title} · FIRE-3DV`;
    at("title").textContent = message.title;
    at("rights").textContent = mayControl ? "" : "view only";
    viewToken = message.view_token;
    joints.clear();  // a renderer without joints sends none
    controls.clear();
    const view = link.restore();
    if (view) send(view);
    display.report();
    plots.reconnect();
    display.offerVideo();
    sendQuality();
  },
  scene(message) {
    const path = link.node;
    scene = message.scene;
    nodes.setScene(message);
    const node = path === null ? null : nodes.find(path);
    select(node, nodes.names[node]);
    const options = [new Option("Free camera", ""), ...message.cameras.map((name, index) => new Option(name, String(index)))];
    cameraCount = message.cameras.length;
    if (message.cameras_omitted > 0) {
      const note = new Option(`${message.cameras_omitted} further cameras are not listed`);
      note.disabled = true;
      options.push(note);
    }
    at("cameras").replaceChildren(...options);
    at("cameras").value = camera;
  },
  viewers(message) {
    drawViewers(at("viewers"), message.viewers);
    statistics.viewers = message.viewers.length;
  },
  camera(message) {
    camera = message.index === null ? "" : String(message.index);
    at("cameras").value = camera;
    link.setCamera(message.index);
  },
  view: (message) => link.setView(message),
  joints: (message) => joints.setJoints(message, mayControl),
  joint_positions: (message) => joints.setPositions(message),
  inputs: (message) => controls.setList(message),
  scalars: (message) => plots.setList(message),
  samples: (message) => plots.addSamples(message),
  settings: (message) => settings.show(message.controls),
  paths: (message) => statistics.setPaths(message),
  visibility(message) {
    nodes.setVisibility(message);
    drawVisibility();
  },
  status(message) {
    const names = message.streams.map((stream) => stream.name);
    for (const name of streams) if (!names.includes(name)) notice(`The stream ${name} has ended.`);
    streams = names;
    drawStreams(at("streams"), message.streams, message.timeline && !message.timeline.playing);
    plots.setCount(message.scalars);
    timeline.draw(message.timeline, mayControl);
  },
  picked(message) {
    if (message.scene !== scene) return;
    select(message.node, message.name, message.node === null ? undefined : message);
    if (framesPicked) frame();
    framesPicked = false;
  },
  inspected(message) {
    if (message.scene === scene && message.node === selected) describe(message);
  },
  notice: (message) => notice(message.text),
};

const connection = new Connection(link.token, {
  open() { at("badge").hidden = true; },
  message: (message) => messages[message.type]?.(message),
  image(image) {
    display.show(image);
    plots.dirty();
  },
  lost(text, isFinal) {
    if (isFinal) for (const element of document.querySelectorAll("button, select, input")) element.disabled = true;
    at("badge").textContent = text;
    at("badge").hidden = false;
  },
});

const keys = {
  f: frame, h: hide, i: isolate, p: screenshot, r: record, l: share, n: togglePanel,
  "shift+h": () => control({type: "show_all"}),
  home: () => send({type: "frame"}),
  0: () => useCamera(null),
  escape: () => select(null),
  "/": () => at("search").focus(),
  " ": () => { if (timeline.shown) timeline.toggle(); },
  ",": () => { if (timeline.shown) timeline.step(false); },
  ".": () => { if (timeline.shown) timeline.step(true); },
};

new Input(at("canvas"), {
  send,
  pick(x, y, frames) {
    framesPicked = frames;
    send({type: "pick", x, y});
  },
  key(event) {
    if (event.target.matches("button, summary") && (event.key === " " || event.key === "Enter")) return;
    const key = (event.shiftKey && event.key.length === 1 && event.key !== "/" ? "shift+" : "") + event.key.toLowerCase();
    if (key >= "1" && key <= "9" && key.length === 1) useCamera(Number(key) - 1);
    else if (keys[key]) keys[key]();
    else return;
    event.preventDefault();
  },
});

at("search").addEventListener("keydown", (event) => { if (event.key === "Escape") { at("search").value = ""; nodes.draw(); at("canvas").focus(); } });
at("cameras").onchange = () => { useCamera(at("cameras").value === "" ? null : Number(at("cameras").value)); at("canvas").focus(); };
for (const [id, action] of [["frame-all", () => send({type: "frame"})], ["screenshot", screenshot], ["record", record], ["share", share], ["toggle-panel", togglePanel], ["frame-node", frame],
                            ["hide", hide], ["isolate", isolate], ["show-all", () => control({type: "show_all"})], ["deselect", () => select(null)]])
  at(id).onclick = action;
at("quality").onchange = sendQuality;
at("record").hidden = Recorder.type() === undefined;
if (matchMedia("(max-width: 700px)").matches) document.body.classList.add("no-panel");
