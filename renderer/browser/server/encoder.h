// Encoder thread of the live view: turns images into messages, the newest one of each viewer.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/image/jpeg_encoder.h"
#include "renderer/browser/server/server.h"
#include "renderer/sinks/video/stream_encoder.h"

namespace fire3dv::serve {

class Encoder {
 public:
  // take: called on the encoder's thread with each message; an empty one: the image is lost for lack of
  // memory.
  using Take = std::function<void(ViewerId viewer, std::vector<uint8_t>&& message)>;
  explicit Encoder(Take take) : take_(std::move(take)), thread_([this] { run(); }) {}
  ~Encoder();
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  // From any thread. An image that waits is replaced by a newer one of its viewer.
  void add(ViewerId viewer, Image&& image);
  // From any thread.
  EncodeTotals totals(Codec codec) const;
  // Drops what is kept for a viewer that has left.
  void forget(ViewerId viewer);

 private:
  struct Job {
    ViewerId viewer = 0;
    Image image;
  };
  void run();
  void encode(ViewerId viewer, const Image& image);
  Codec append_video(ViewerId viewer, const Image& image, std::vector<uint8_t>& bytes, bool& is_key);

  const Take take_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;  // one of each viewer at most
  std::vector<ViewerId> forgotten_;
  bool is_ending_ = false;
  std::map<Codec, EncodeTotals> totals_;
  std::map<ViewerId, std::unique_ptr<sinks::StreamEncoder>> streams_;  // owned by the thread
  JpegEncoder jpeg_;                                                   // likewise
  std::thread thread_;                                                 // last: it uses the others
};

}  // namespace fire3dv::serve
