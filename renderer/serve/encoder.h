// Encoder thread of the live view: turns images into messages, the newest one of each viewer.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "renderer/serve/server.h"

namespace fire3dv::serve {

class Encoder {
 public:
  // take: called on the encoder's thread with each message.
  using Take = std::function<void(ViewerId viewer, std::vector<uint8_t>&& message)>;
  explicit Encoder(Take take) : take_(std::move(take)), thread_([this] { run(); }) {}
  ~Encoder();
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  // From any thread. An image that waits is replaced by a newer one of its viewer.
  void add(ViewerId viewer, Image&& image);

 private:
  struct Job {
    ViewerId viewer = 0;
    Image image;
  };
  void run();

  const Take take_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;  // one of each viewer at most
  bool is_ending_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace fire3dv::serve
