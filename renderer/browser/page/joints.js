// Sliders of the robot's joints, and the poses that its description names.
const DEGREES = 180 / Math.PI;
const FREE_TURN_DEG = 180, FREE_WAY_M = 1;  // ranges of joints without limits
const MAX_POSITION = 1e6;  // of the renderer's messages

export class Joints {
  // elements: section, posture, list. send(message)
  constructor(elements, send) {
    this.elements = elements;
    this.send = send;
    this.rows = [];
    this.scene = null;
    elements.posture.onchange = () => this.choose();
  }

  clear() {
    this.scene = null;
    this.elements.section.hidden = true;
  }

  setJoints(message, mayControl) {
    this.scene = message.scene;
    this.mayControl = mayControl;
    this.elements.section.hidden = message.joints.length === 0;
    this.elements.posture.replaceChildren(new Option("As in the file", "file"), ...message.postures.map((name, index) => new Option(name, String(index))),
                                          new Option("By hand", "hand"));
    this.elements.posture.options[message.postures.length + 1].disabled = true;
    this.elements.posture.disabled = !mayControl;
    this.rows = message.joints.map((joint, index) => this.row(joint, index));
    this.elements.list.replaceChildren(...this.rows.map((row) => row.item));
  }

  row(joint, index) {
    const unit = joint.turns ? DEGREES : 1;
    const item = document.createElement("li"), label = document.createElement("label"), slider = document.createElement("input");
    const name = document.createElement("span"), value = document.createElement("output");
    name.textContent = name.title = joint.name;
    const free = joint.turns ? FREE_TURN_DEG : FREE_WAY_M;
    const [low, high] = joint.limits ? joint.limits.map((limit) => limit * unit) : [-free, free];
    Object.assign(slider, {type: "range", min: low, max: high, step: "any"});
    slider.setAttribute("aria-label", joint.name);  // without the value, which the slider has itself
    slider.disabled = !this.mayControl;
    const row = {item, slider, value, unit, turns: joint.turns};
    slider.oninput = () => {
      this.show(row, Number(slider.value));
      const position = Math.min(MAX_POSITION, Math.max(-MAX_POSITION, Number(slider.value) / unit));
      this.send({type: "joint", scene: this.scene, index, position});
    };
    // "any" leaves the arrow keys a step of 1.
    slider.onkeydown = (event) => {
      const turn = {ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1}[event.key];
      if (!turn) return;
      event.preventDefault();
      slider.value = Number(slider.value) + turn * (high - low) / 100;
      slider.oninput();
    };
    label.append(name, value, slider);
    item.append(label);
    return row;
  }

  show(row, shown) {
    row.value.textContent = (row.turns ? `${shown.toFixed(1)}°` : `${shown.toFixed(3)} m`).replace(/^-(0\.0*[ °])/, "$1");
    row.slider.setAttribute("aria-valuetext", row.value.textContent);
  }

  setPositions(message) {
    if (message.scene !== this.scene) return;
    this.rows.forEach((row, index) => {
      const driver = message.drivers[index];
      row.slider.disabled = !this.mayControl || driver !== null;
      row.item.classList.toggle("driven", driver !== null);
      if (driver !== null) {
        row.value.textContent = `by ${driver}`;
      } else if (!row.slider.matches(":active")) {
        row.slider.value = message.positions[index] * row.unit;
        this.show(row, message.positions[index] * row.unit);
      }
    });
    this.elements.posture.value = !message.moved ? "file" : message.posture === null ? "hand" : String(message.posture);
  }

  choose() {
    const chosen = this.elements.posture.value;
    this.send(chosen === "file" ? {type: "posture", scene: this.scene} : {type: "posture", scene: this.scene, index: Number(chosen)});
  }
}
