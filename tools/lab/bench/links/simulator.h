// Minimal publisher: performs the steps of fire3dv_publish() in this process, on any link. The first number
// of each pose encodes the frame index.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/transport/open.h"
#include "protocol/wire/encode.h"

namespace fire3dv::bench {

class Simulator {
 public:
  static Result<std::unique_ptr<Simulator>> open(const std::string& uri, size_t poses,
                                                 const transport::PublisherOptions& options = {});

  // index: below 2^24, the exact range of floats.
  void set_index(uint32_t index);
  // Checks, encodes and sends one frame. Never waits.
  void publish() noexcept;

  transport::PublisherLink& link() { return *link_; }

 private:
  Simulator() = default;

  std::unique_ptr<transport::PublisherLink> link_;
  wire::PoseFrameEncoder encoder_;
  wire::PoseFrameView frame_;
  std::vector<wire::Affine3x4> poses_;
  size_t poses_per_part_ = 0;
};

// Returns "body 0", "body 1", ...
std::vector<std::string> body_names(size_t count);

}  // namespace fire3dv::bench
