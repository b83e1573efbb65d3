// H.264 encoder of a live stream (libav, x264): one frame in, one access unit out, without delay. Tags and
// colours are those of VideoFile.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace fire3dv::sinks {

class StreamEncoder {
 public:
  enum class Codec : uint8_t { h264, vp8 };
  // width and height: even. crf: constant rate factor of x264, smaller is better; VP8 has about its quality.
  // Null if this system has no encoder for the codec (x264, libvpx), or no memory.
  static std::unique_ptr<StreamEncoder> open(Codec codec, uint32_t width, uint32_t height, int crf);
  ~StreamEncoder();
  StreamEncoder(const StreamEncoder&) = delete;
  StreamEncoder& operator=(const StreamEncoder&) = delete;

  uint32_t width() const;
  uint32_t height() const;
  int crf() const;
  Codec codec() const;

  // Appends the encoded frame (H.264: Annex B; parameter sets precede a key frame). The first frame is a key
  // frame. rgba8: width * height * 4 bytes, top row first. False: the encoder is of no more use.
  bool append(std::span<const uint8_t> rgba8, std::vector<uint8_t>& stream, bool& is_key);

 private:
  struct Impl;
  explicit StreamEncoder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace fire3dv::sinks
