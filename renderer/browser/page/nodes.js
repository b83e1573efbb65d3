// Node tree with search. Rows are made when they are opened, so that large scenes stay quick. The tree is one tab stop: arrow keys move
// within it and open and close rows, Enter selects.
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
    this.active = null;  // node of the row that has the tab stop
    elements.search.addEventListener("input", () => this.draw());
    elements.search.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && this.found?.length > 0) this.handlers.select(this.found[0]);
      if (event.key !== "ArrowDown") return;
      event.preventDefault();
      elements.tree.querySelector("li")?.focus();
    });
    elements.tree.addEventListener("keydown", (event) => this.key(event));
    elements.tree.addEventListener("focusin", (event) => {
      this.active = Number(event.target.closest("li").dataset.node);
      this.setTabStop();
    });
  }

  // Keys of the row that has the focus; the others are those of the page.
  key(event) {
    const row = event.target;
    if (!row.matches("li") || event.ctrlKey || event.altKey || event.metaKey) return;
    const rows = [...this.elements.tree.querySelectorAll("li")], at = rows.indexOf(row), node = Number(row.dataset.node);
    const isOpen = row.getAttribute("aria-expanded") === "true";
    if (event.key === "ArrowDown") rows[at + 1]?.focus();
    else if (event.key === "ArrowUp") rows[at - 1]?.focus();
    else if (event.key === "Home") rows[0].focus();
    else if (event.key === "End") rows[rows.length - 1].focus();
    else if (event.key === "ArrowRight" && isOpen) rows[at + 1].focus();
    else if (event.key === "ArrowRight" && row.hasAttribute("aria-expanded")) this.toggle(node);
    else if (event.key === "ArrowLeft" && isOpen) this.toggle(node);
    else if (event.key === "ArrowLeft") row.parentElement.closest("li")?.focus();
    else if (event.key === "Enter" || event.key === " ") this.handlers.select(node);
    else if (event.key !== "ArrowRight") return;
    event.preventDefault();
    event.stopPropagation();
  }

  toggle(node) {
    if (!this.open.delete(node)) this.open.add(node);
    this.draw();
  }

  rowOf(node) {
    return node === null ? null : this.elements.tree.querySelector(`li[data-node="${node}"]`);
  }

  setTabStop() {
    const stop = this.rowOf(this.active) ?? this.rowOf(this.selected) ?? this.elements.tree.querySelector("li");
    for (const row of this.elements.tree.querySelectorAll('li[tabindex="0"]')) row.tabIndex = -1;
    if (stop) stop.tabIndex = 0;
  }

  setScene(message) {
    this.names = message.nodes.map((node) => node[0]);
    this.parents = message.nodes.map((node) => node[1]);
    this.meshes = message.nodes.map((node) => node[2] === 1);
    this.children = this.names.map(() => []);
    this.roots = [];
    this.parents.forEach((parent, node) => (parent < 0 ? this.roots : this.children[parent]).push(node));
    this.open = new Set(this.roots.length === 1 ? this.roots : []);
    this.active = null;
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
    const hasFocus = document.activeElement?.matches("#tree li");
    if (wanted) {
      const found = [];
      for (let node = 0; node < this.names.length && found.length < MAX_FOUND; ++node)
        if (this.names[node].toLowerCase().includes(wanted)) found.push(node);
      this.found = found;
      this.elements.tree.replaceChildren(...found.map((node) => this.row(node, 0)));
    } else {
      this.found = [];
      this.elements.tree.replaceChildren(...(this.roots ?? []).map((node) => this.branch(node, 1)));
    }
    this.elements.tree.scrollTop = scrolled;
    this.setTabStop();
    if (hasFocus) this.elements.tree.querySelector('li[tabindex="0"]')?.focus({preventScroll: true});
  }

  branch(node, level) {
    const item = this.row(node, level);
    if (this.open.has(node) && this.children[node].length > 0) {
      const list = document.createElement("ul");
      list.setAttribute("role", "group");
      list.append(...this.children[node].map((child) => this.branch(child, level + 1)));
      item.append(list);
    }
    return item;
  }

  // level: in the tree, from 1; 0: a row of the search.
  row(node, level) {
    const item = document.createElement("li");
    item.dataset.node = node;
    item.tabIndex = -1;
    item.setAttribute("role", "treeitem");
    item.setAttribute("aria-selected", String(node === this.selected));
    item.setAttribute("aria-label", this.names[node] + (this.hidden.has(node) ? ", hidden" : ""));
    if (level > 0) item.setAttribute("aria-level", String(level));
    if (level > 0 && this.children[node].length > 0) item.setAttribute("aria-expanded", String(this.open.has(node)));
    const row = document.createElement("div");
    row.className = "node";
    row.classList.toggle("selected", node === this.selected);
    row.classList.toggle("gone", this.hidden.has(node));
    row.classList.toggle("empty", !this.meshes[node] && this.children[node].length === 0);
    const isOpen = this.open.has(node);
    if (level > 0) {
      const twist = button("twist", this.children[node].length === 0 ? "" : isOpen ? "▾" : "▸", `Open or close ${this.names[node]}`);
      twist.onclick = () => this.toggle(node);
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
  element.tabIndex = -1;  // the row has the tab stop
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
