// Canvas with the newest image. Each image is acknowledged when it is drawn, so that the next one may come.
import {download} from "./download.js";
import {CODECS, Video} from "./video.js";

const MAX_SIDE = 4096;

export class Display {
  constructor(canvas, connection) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d", {alpha: false});
    this.send = (message) => connection().send(message);
    this.images = this.bytes = 0;
    this.size = [0, 0];
    this.failed = new Set();  // codecs
    this.last = null;
    this.simTimeNs = null;  // BigInt: of the shown image
    new ResizeObserver(() => this.measure()).observe(canvas);
  }

  // The canvas has the pixels of the display.
  measure() {
    const ratio = window.devicePixelRatio || 1;
    const side = (css) => Math.min(MAX_SIDE, Math.max(1, Math.round(css * ratio)));
    const size = [side(this.canvas.clientWidth), side(this.canvas.clientHeight)];
    if (size[0] === this.size[0] && size[1] === this.size[1]) return;
    this.size = size;
    this.report();
  }

  report() {
    if (this.size[0] > 0) this.send({type: "size", width: this.size[0], height: this.size[1]});
  }

  // The renderer sends JPEG until it hears which video can be decoded.
  async offerVideo() {
    this.video?.close();
    this.video = null;
    const offer = {type: "codec"};
    for (const codec of CODECS) offer[codec] = !this.failed.has(codec) && await Video.isSupported(codec);
    if (this.failed.size > 0 || CODECS.some((codec) => offer[codec])) this.send(offer);
  }

  decode(image) {
    if (image.codec === "jpeg") return createImageBitmap(new Blob([image.bytes], {type: "image/jpeg"}), {colorSpaceConversion: "none"});
    if (this.video?.codec !== image.codec) {
      this.video?.close();
      this.video = new Video(image.codec);
    }
    return this.video.decode(image.bytes, image.isKey);
  }

  async show(image) {
    let bitmap = null;
    try {
      bitmap = await this.decode(image);
    } catch {
      // A damaged image is acknowledged as well: otherwise no other one comes.
      if (image.codec !== "jpeg") {
        this.failed.add(image.codec);
        await this.offerVideo();
      }
    }
    if (bitmap) {
      // Resizing clears a canvas, so it waits for the first image of the new size.
      if (this.canvas.width !== this.size[0] || this.canvas.height !== this.size[1]) [this.canvas.width, this.canvas.height] = this.size;
      this.context.imageSmoothingQuality = "high";
      this.context.drawImage(bitmap, 0, 0, this.canvas.width, this.canvas.height);
      bitmap.close();
    }
    this.images += 1;
    this.bytes += image.bytes.length;
    this.last = {number: image.number, width: image.width, height: image.height, refined: image.refined, codec: image.codec, encodeMs: image.encodeMs, simTimeS: Number(image.simTimeNs) * 1e-9};
    this.simTimeNs = image.simTimeNs;
    this.canvas.dataset.image = JSON.stringify(this.last);
    this.send({type: "shown", image: image.number});
  }

  save(name) {
    this.canvas.toBlob((blob) => download(blob, `${name}.png`), "image/png");
  }
}
