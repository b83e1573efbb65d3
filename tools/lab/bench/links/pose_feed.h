// Publisher thread that sends poses of one step per request over shared memory.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "protocol/transport/link.h"
#include "protocol/wire/messages.h"

namespace fire3dv::bench {

class PoseFeed {
 public:
  // pose_at: fills the poses of a step, one per name. Called on the feed's thread.
  using PoseAt = std::function<void(uint64_t step, std::vector<wire::Affine3x4>& poses)>;
  static Result<std::unique_ptr<PoseFeed>> open(const std::string& uri, std::vector<std::string> names,
                                                PoseAt pose_at);
  ~PoseFeed();
  PoseFeed(const PoseFeed&) = delete;
  PoseFeed& operator=(const PoseFeed&) = delete;

  // Requests the next step without blocking. Returns its sequence, from 1.
  uint64_t ask_for_next();

 private:
  PoseFeed() = default;
  void work();

  std::unique_ptr<transport::PublisherLink> link_;
  PoseAt pose_at_;
  uint64_t epoch_ = 0;
  uint32_t count_ = 0;
  std::atomic<uint64_t> wanted_ = 0;
  std::thread thread_;  // last, since it uses all members above
};

}  // namespace fire3dv::bench
