// Video images through WebCodecs, one at a time: each is shown before the next one comes.
const CONFIGS = {
  h264: {codec: "avc1.42E033", optimizeForLatency: true},  // baseline profile; the level is an upper bound
  // VP8 itself does not say which colours it has.
  vp8: {codec: "vp8", optimizeForLatency: true, colorSpace: {primaries: "bt709", transfer: "iec61966-2-1", matrix: "bt709", fullRange: false}},
};
export const CODECS = Object.keys(CONFIGS);
const PATIENCE_MS = 3000;

export class Video {
  // WebCodecs are there in secure contexts only: https, and addresses of this machine.
  static async isSupported(codec) {
    if (typeof VideoDecoder === "undefined") return false;
    try {
      return (await VideoDecoder.isConfigSupported(CONFIGS[codec])).supported === true;
    } catch {
      return false;
    }
  }

  constructor(codec) {
    this.codec = codec;
    this.number = 0;
    this.waiting = null;
    this.decoder = new VideoDecoder({
      output: (frame) => {
        if (this.waiting) this.waiting.resolve(frame);
        else frame.close();
        this.waiting = null;
      },
      error: (error) => this.fail(error),
    });
    this.decoder.configure(CONFIGS[codec]);
  }

  // The decoded frame; fails if the decoder does.
  decode(bytes, isKey) {
    return new Promise((resolve, reject) => {
      const waiting = this.waiting = {resolve, reject};
      setTimeout(() => { if (this.waiting === waiting) this.fail(new Error("no frame")); }, PATIENCE_MS);
      this.decoder.decode(new EncodedVideoChunk({type: isKey ? "key" : "delta", timestamp: 1000 * this.number++, data: bytes}));
    });
  }

  fail(error) {
    this.waiting?.reject(error);
    this.waiting = null;
  }

  close() {
    if (this.decoder.state !== "closed") this.decoder.close();
  }
}
