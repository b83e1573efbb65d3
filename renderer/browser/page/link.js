// State of the page in the URL's fragment, which browsers do not send: the token, then the camera and the selected node.
const SAVE_MS = 500;  // browsers limit how often an address changes
const MAX_PATH = 500;

function numbers(text, count) {
  const values = (text ?? "").split(",").map(Number);
  return values.length === count && values.every(Number.isFinite) ? values : null;
}

export class Link {
  constructor() {
    const [token, ...state] = location.hash.slice(1).split("&");
    const query = new URLSearchParams(state.join("&"));
    this.token = token;
    this.view = numbers(query.get("view"), 9);  // position, quaternion x y z w, distance, field of view
    const camera = query.get("camera");
    this.camera = camera !== null && /^\d{1,4}$/.test(camera) ? Number(camera) : null;
    this.node = query.get("node");
    this.timer = 0;
    window.addEventListener("hashchange", () => location.reload());  // another link was pasted
  }

  // The message that restores the camera; null: there is none to restore.
  restore() {
    if (this.camera !== null) return {type: "camera", index: this.camera};
    if (!this.view) return null;
    const [x, y, z, qx, qy, qz, qw, distance, fov] = this.view;
    return {type: "view", position: [x, y, z], rotation: [qx, qy, qz, qw], distance, fov};
  }

  setView(message) {
    const rounded = (values) => values.map((value) => Number(value.toPrecision(7)));
    this.view = message.position && rounded([...message.position, ...message.rotation, message.distance, message.fov]);
    this.save();
  }

  setCamera(index) {
    this.camera = index;
    this.save();
  }

  setNode(path) {
    this.node = path && path.length <= MAX_PATH ? path : null;
    this.save();
  }

  save() {
    this.timer ||= setTimeout(() => {
      this.timer = 0;
      history.replaceState(null, "", this.address(this.token));
    }, SAVE_MS);
  }

  // This page's address with this token.
  address(token) {
    const parts = [token];
    if (this.camera !== null) parts.push(`camera=${this.camera}`);
    else if (this.view) parts.push(`view=${this.view.join(",")}`);
    if (this.node) parts.push(`node=${encodeURIComponent(this.node)}`);
    return `${location.origin}${location.pathname}${location.search}#${parts.join("&")}`;
  }
}
