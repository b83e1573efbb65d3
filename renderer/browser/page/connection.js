// WebSocket to the renderer, which connects again when it is lost.
const HEADER_BYTES = 24;
const CODECS = ["", "jpeg", "h264", "vp8"];
const WRONG_TOKEN = 4401;
const ASK_MS = 3000, MAX_REASON = 300;

// Why the WebSocket was refused: browsers tell a script nothing about it, so the page asks by HTTP. Empty: nobody answers.
async function refusal() {
  try {
    const answer = await fetch(`socket?origin=${location.origin}`, {cache: "no-store", signal: AbortSignal.timeout(ASK_MS)});
    if (![403, 421, 426].includes(answer.status) || !answer.headers.get("content-type")?.startsWith("text/plain"))
      return `the server answers ${answer.status} ${answer.statusText}`.trim();
    return `refused by the server: ${(await answer.text()).trim().slice(0, MAX_REASON)}`;
  } catch {
    return "";
  }
}

export class Connection {
  // handlers: open(), message(object), image({number, width, height, codec, isKey, refined, encodeMs, simTimeNs, bytes}), lost(text, final)
  constructor(token, handlers) {
    this.token = token;
    this.handlers = handlers;
    this.attempts = 0;
    this.connect();
  }

  connect() {
    // Beside the page, which may be below a path of a proxy.
    const address = new URL("socket", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    this.isWelcome = false;
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.send({type: "hello", token: this.token});
    this.socket.onmessage = (event) => this.receive(event.data);
    this.socket.onclose = (event) => this.close(event);
  }

  receive(data) {
    if (typeof data === "string") {
      const message = JSON.parse(data);
      if (message.type === "welcome") {
        this.attempts = 0;
        this.isWelcome = true;
        this.handlers.open();
      }
      this.handlers.message(message);
      return;
    }
    const view = new DataView(data);
    this.handlers.image({
      number: view.getUint32(0, true),
      width: view.getUint16(4, true),
      height: view.getUint16(6, true),
      codec: CODECS[view.getUint8(8)],
      isKey: (view.getUint8(9) & 2) !== 0,
      refined: (view.getUint8(9) & 1) !== 0,
      encodeMs: view.getUint32(12, true) / 1000,
      simTimeNs: view.getBigInt64(16, true),
      bytes: new Uint8Array(data, HEADER_BYTES),
    });
  }

  async close(event) {
    if (event.code === WRONG_TOKEN) {
      this.handlers.lost("This link is not valid. Use the link that fire3dv printed when it started.", true);
      return;
    }
    const reason = event.reason || (this.isWelcome ? "" : await refusal());  // some proxies open and close for a server that refuses
    this.handlers.lost(`Not connected${reason ? ` (${reason})` : ""}. Trying again…`, false);
    const waitMs = Math.min(5000, 300 * 2 ** this.attempts++);
    setTimeout(() => this.connect(), waitMs);
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}
