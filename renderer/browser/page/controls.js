// Controls that streams declare: sliders, buttons, toggles, choices, texts and run bars. The renderer sends only what is declared.
const MAX_TEXT_BYTES = 1023;
const STEPS = 200;  // of a slider by keys, where it takes any value

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

const rounded = (value) => String(Number(value.toPrecision(6)));

export class Controls {
  // elements: section, list, omitted. send(message)
  constructor(elements, send) {
    this.elements = elements;
    this.send = send;
    this.list = null;
    this.rows = [];
  }

  clear() {
    this.list = null;
    this.elements.section.hidden = true;
  }

  setList(message) {
    if (message.list !== this.list) this.build(message);
    message.inputs.forEach((input, index) => this.rows[index]?.update(input));
  }

  build(message) {
    this.list = message.list;
    const shown = message.inputs.some((input) => input.kind !== "drag");
    this.elements.section.hidden = !shown;
    this.elements.omitted.hidden = message.omitted === 0;
    this.elements.omitted.textContent = `${message.omitted} further controls are not listed`;
    let heading = "";
    const items = [];
    this.rows = message.inputs.map((input, index) => {
      const row = this.row(input, index);
      if (!row) return null;
      const slash = input.name.lastIndexOf("/");
      const folder = [message.streams.length > 1 ? message.streams[input.stream] : "", slash > 0 ? input.name.slice(0, slash) : ""].filter(Boolean).join(" · ");
      if (folder !== heading) items.push(element("li", {className: "folder dim", textContent: folder || "Other"}));
      heading = folder;
      items.push(element("li", {}, row.shown));
      return row;
    });
    this.elements.list.replaceChildren(...items);
  }

  act(index, action, value = 0, text = "") {
    this.send({type: "input", list: this.list, index, action, value, text});
  }

  // {shown: element, update(input)}; null: not shown in the list.
  row(input, index) {
    const name = input.name.slice(input.name.lastIndexOf("/") + 1);
    const make = {slider: "slider", button: "button", toggle: "toggle", choice: "choice", text: "text", run: "run"}[input.kind];
    return make ? this[make](input, index, name) : null;
  }

  // action: what a change of it is.
  slider(input, index, name, action = "set") {
    const [min, max] = input.range, step = input.step || "any";
    const track = element("input", {type: "range", min, max, step});
    const number = element("input", {type: "number", min, max, step});
    track.setAttribute("aria-label", name);
    number.setAttribute("aria-label", `${name}, number`);
    const set = (value) => {
      if (Number.isFinite(value)) this.act(index, action, Math.min(max, Math.max(min, value)));
    };
    track.oninput = () => {
      number.value = rounded(Number(track.value));
      set(Number(track.value));
    };
    // "any" leaves the arrow keys a step of 1.
    track.onkeydown = (event) => {
      const turn = {ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1}[event.key];
      if (!turn || input.step) return;
      event.preventDefault();
      track.value = Number(track.value) + turn * (max - min) / STEPS;
      track.oninput();
    };
    number.onchange = () => set(number.valueAsNumber);
    const shown = element("div", {className: "slider"}, element("span", {textContent: name, title: name}), element("span", {className: "number"}, number, input.unit ? ` ${input.unit}` : ""), track);
    return {
      shown,
      update: ({value}) => {
        if (!track.matches(":active")) track.value = value;
        if (document.activeElement !== number && !track.matches(":active")) number.value = rounded(value);
      },
    };
  }

  button(input, index, name) {
    return {shown: element("button", {textContent: name, onclick: () => this.act(index, "press")}), update() {}};
  }

  toggle(input, index, name) {
    const box = element("input", {type: "checkbox"});
    box.onchange = () => this.act(index, "set", box.checked ? 1 : 0);
    return {shown: element("label", {className: "row"}, element("span", {textContent: name}), box), update: ({value}) => { box.checked = value === 1; }};
  }

  choice(input, index, name) {
    const select = element("select", {}, ...input.choices.map((text, value) => new Option(text, String(value))));
    select.onchange = () => this.act(index, "set", Number(select.value));
    return {shown: element("label", {className: "row"}, element("span", {textContent: name}), select), update: ({value}) => { select.value = String(value); }};
  }

  text(input, index, name) {
    const field = element("input", {type: "text", maxLength: MAX_TEXT_BYTES});
    field.onchange = () => {
      if (new TextEncoder().encode(field.value).length <= MAX_TEXT_BYTES) this.act(index, "set", 0, field.value);
    };
    return {shown: element("label", {className: "row"}, element("span", {textContent: name}), field), update: ({text}) => { if (document.activeElement !== field) field.value = text; }};
  }

  run(input, index, name) {
    const takes = input.takes, shown = element("div", {className: "run"}), row = element("div", {className: "row actions"});
    let running = false;
    const toggle = element("button", {onclick: () => this.act(index, running ? "pause" : "run")});
    if (takes.run) row.append(toggle);
    if (takes.step) row.append(element("button", {textContent: "Step", onclick: () => this.act(index, "step", 1)}));
    if (takes.reset) row.append(element("button", {textContent: "Reset", onclick: () => this.act(index, "reset")}));
    shown.append(row);
    shown.setAttribute("role", "group");
    shown.setAttribute("aria-label", name);
    const speed = takes.speed ? this.slider({range: input.range, step: 0, unit: "×"}, index, "Speed", "speed") : null;
    if (speed) shown.append(speed.shown);
    return {
      shown,
      update: (now) => {
        running = now.value === 1;
        toggle.textContent = running ? "Pause" : "Run";
        speed?.update({value: now.speed});
      },
    };
  }
}
