// Files that the page makes, and videos of the canvas.
const MAX_VIDEO_S = 60, MAX_VIDEO_BYTES = 100e6;
const VIDEO_BITS_PER_S = 8e6, CHUNK_MS = 500;
const VIDEO_TYPES = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];

export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export class Recorder {
  // name(): of the file, without its ending. changed(): recording has begun or ended.
  constructor(canvas, name, changed) {
    this.canvas = canvas;
    this.name = name;
    this.changed = changed;
    this.recorder = null;
  }

  static type() {
    if (typeof MediaRecorder === "undefined" || !HTMLCanvasElement.prototype.captureStream) return undefined;
    return VIDEO_TYPES.find((type) => MediaRecorder.isTypeSupported(type));
  }

  get isRecording() { return this.recorder !== null; }

  toggle() {
    if (this.recorder) this.stop();
    else this.start();
  }

  start() {
    const stream = this.canvas.captureStream(30);
    const recorder = this.recorder = new MediaRecorder(stream, {mimeType: Recorder.type(), videoBitsPerSecond: VIDEO_BITS_PER_S});
    const chunks = [];
    let bytes = 0;
    const size = [this.canvas.width, this.canvas.height];
    recorder.ondataavailable = (event) => {
      chunks.push(event.data);
      bytes += event.data.size;
      if (bytes > MAX_VIDEO_BYTES || this.canvas.width !== size[0] || this.canvas.height !== size[1]) this.stop();
    };
    const timer = setTimeout(() => this.stop(), 1000 * MAX_VIDEO_S);
    // A view that stands gives no frames of its own: it is drawn again.
    const context = this.canvas.getContext("2d");
    const repaint = setInterval(() => context.drawImage(this.canvas, 0, 0, 1, 1, 0, 0, 1, 1), 100);
    recorder.onstop = () => {
      clearTimeout(timer);
      clearInterval(repaint);
      for (const track of stream.getTracks()) track.stop();
      const type = recorder.mimeType.split(";")[0];
      if (bytes > 0) download(new Blob(chunks, {type}), `${this.name()}.${type === "video/mp4" ? "mp4" : "webm"}`);
    };
    recorder.start(CHUNK_MS);
    this.changed();
  }

  stop() {
    const recorder = this.recorder;
    this.recorder = null;
    if (recorder && recorder.state !== "inactive") recorder.stop();
    this.changed();
  }
}
