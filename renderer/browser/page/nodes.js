// Node tree with search. Rows are made when they are opened, so that large scenes stay quick.
const MAX_FOUND = 200;
const EYE = "M1.5 8S4 3.5 8 3.5 14.5 8 14.5 8 12 12.5 8 12.5 1.5 8 1.5 8z";

export class Nodes {
  // handlers: select(node), hide(node, hidden)
  constructor(elements, handlers) {
    this.elements = elements;
    this.handlers = handlers;
    this.open = new Set();
    this.hidden = new Set();
    this.isolated = null;
    this.selected = null;
    this.names = [];
    elements.search.addEventListener("input", () => this.draw());
    elements.search.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && this.found?.length > 0) this.handlers.select(this.found[0]);
    });
  }

  setScene(message) {
    this.names = message.nodes.map((node) => node[0]);
    this.parents = message.nodes.map((node) => node[1]);
    this.meshes = message.nodes.map((node) => node[2] === 1);
    this.children = this.names.map(() => []);
    this.roots = [];
    this.parents.forEach((parent, node) => (parent < 0 ? this.roots : this.children[parent]).push(node));
    this.open = new Set(this.roots.length === 1 ? this.roots : []);
    this.elements.omitted.hidden = message.omitted === 0;
    this.elements.omitted.textContent = `${message.omitted} further nodes are not listed`;
    this.draw();
  }

  setVisibility(message) {
    this.hidden = new Set(message.hidden);
    this.isolated = message.isolated;
    this.draw();
  }

  isHidden(node) {
    return this.hidden.has(node);
  }

  select(node) {
    this.selected = node;
    for (let at = node === null ? -1 : this.parents?.[node] ?? -1; at >= 0; at = this.parents[at]) this.open.add(at);
    this.draw();
    this.reveal();
  }

  // Names from the root to the node.
  path(node) {
    const names = [];
    for (let at = node; at >= 0; at = this.parents[at]) names.unshift(this.names[at]);
    return names.join("/");
  }

  // The first node with this path; null: there is none.
  find(path) {
    const node = this.names.findIndex((name, index) => path.endsWith(name) && this.path(index) === path);
    return node < 0 ? null : node;
  }

  // Scrolls the list alone, not the panel.
  reveal() {
    const tree = this.elements.tree, row = tree.querySelector(".selected");
    if (!row) return;
    const list = tree.getBoundingClientRect(), box = row.getBoundingClientRect();
    if (box.top < list.top) tree.scrollTop -= list.top - box.top;
    if (box.bottom > list.bottom) tree.scrollTop += box.bottom - list.bottom;
  }

  draw() {
    const wanted = this.elements.search.value.trim().toLowerCase();
    const scrolled = this.elements.tree.scrollTop;
    if (wanted) {
      const found = [];
      for (let node = 0; node < this.names.length && found.length < MAX_FOUND; ++node)
        if (this.names[node].toLowerCase().includes(wanted)) found.push(node);
      this.found = found;
      this.elements.tree.replaceChildren(...found.map((node) => this.row(node, false)));
    } else {
      this.found = [];
      this.elements.tree.replaceChildren(...(this.roots ?? []).map((node) => this.branch(node)));
    }
    this.elements.tree.scrollTop = scrolled;
  }

  branch(node) {
    const item = this.row(node, true);
    if (this.open.has(node) && this.children[node].length > 0) {
      const list = document.createElement("ul");
      list.append(...this.children[node].map((child) => this.branch(child)));
      item.append(list);
    }
    return item;
  }

  row(node, isTree) {
    const item = document.createElement("li");
    const row = document.createElement("div");
    row.className = "node";
    row.classList.toggle("selected", node === this.selected);
    row.classList.toggle("gone", this.hidden.has(node));
    row.classList.toggle("empty", !this.meshes[node] && this.children[node].length === 0);
    const isOpen = this.open.has(node);
    if (isTree) {
      const twist = button("twist", this.children[node].length === 0 ? "" : isOpen ? "▾" : "▸", "Open or close");
      twist.tabIndex = -1;
      twist.onclick = () => {
        if (!this.open.delete(node)) this.open.add(node);
        this.draw();
      };
      row.append(twist);
    }
    const label = button("label", this.names[node], this.names[node]);
    label.onclick = () => this.handlers.select(node);
    const eye = button("eye control", "", `${this.hidden.has(node) ? "Show" : "Hide"} ${this.names[node]}`);
    eye.append(icon(EYE));
    eye.onclick = () => this.handlers.hide(node, !this.hidden.has(node));
    row.append(label, eye);
    item.append(row);
    return item;
  }
}

function button(className, text, title) {
  const element = document.createElement("button");
  element.className = className;
  element.textContent = text;
  element.title = title;
  return element;
}

function icon(path) {
  const namespace = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(namespace, "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  const shape = document.createElementNS(namespace, "path");
  shape.setAttribute("d", path);
  const pupil = document.createElementNS(namespace, "circle");
  for (const [name, value] of [["cx", 8], ["cy", 8], ["r", 2]]) pupil.setAttribute(name, value);
  svg.append(shape, pupil);
  return svg;
}
