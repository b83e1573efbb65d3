// Controls of the draw settings that the renderer's table of settings has for browsers.
const capital = (text) => text[0].toUpperCase() + text.slice(1);

export class Settings {
  // list: element of the rows. send(message)
  constructor(list, send) {
    this.list = list;
    this.send = send;
    this.rows = new Map();
  }

  show(controls) {
    const labels = controls.map((control) => {
      const id = `setting-${control.setting}-${control.control}`;
      if (!this.rows.has(id)) this.rows.set(id, this.row(id, control));
      const row = this.rows.get(id);
      this.update(row, control);
      return row.label;
    });
    if (labels.length !== this.list.children.length || labels.some((label, index) => label !== this.list.children[index])) this.list.replaceChildren(...labels);
  }

  row(id, control) {
    const label = document.createElement("label"), input = document.createElement(control.kind === "choice" ? "select" : "input");
    label.className = "row";
    input.id = id;
    label.append(`${control.label.trim()} `, input);
    const send = (value) => this.send({type: "setting", setting: control.setting, control: control.control, value});
    const row = {label, input};
    if (control.kind === "check") {
      input.type = "checkbox";
      input.onchange = () => send(control.values[input.checked ? 0 : 1]);
    } else if (control.kind === "choice") {
      input.append(...control.values.map((value, index) => new Option(capital(control.names[index]), value)));
      input.onchange = () => send(input.value);
    } else if (control.kind === "color") {
      input.type = "color";
      input.oninput = () => send(input.value.slice(1));
    } else {
      const [toTrack, fromTrack] = control.logarithmic ? [Math.log, Math.exp] : [Number, Number];
      const [min, max] = control.range.map(toTrack);
      Object.assign(input, {type: "range", min, max, step: (max - min) / 1000});
      row.toTrack = toTrack;
      input.oninput = () => send(String(control.whole ? Math.round(fromTrack(input.value)) : Number(fromTrack(input.value).toPrecision(6))));
    }
    return row;
  }

  update({input, toTrack}, control) {
    const lacks = (value) => control.missing.includes(value);
    input.disabled = !control.enabled || (control.values.length > 0 && control.values.every((value) => value === control.value || lacks(value)));
    input.title = !control.enabled ? "Of the raster alone" : control.missing.length > 0 ? "Other values: at the start of fire3dv" : control.hint;
    if (control.kind === "check") input.checked = control.value === control.values[0];
    else if (control.kind === "color") input.value = `#${control.value}`;
    else if (!toTrack) input.value = control.value;
    else if (!input.matches(":active")) input.value = toTrack(control.value);
    if (control.kind === "choice") for (const option of input.options) option.disabled = lacks(option.value) && option.value !== control.value;
  }
}
