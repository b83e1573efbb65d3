// A simulator that does nothing but publish: what fire3dv_publish() does with a frame, in this process, on
// any link. Each pose's first number tells which frame it is.
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

  // Whole numbers below 2^24, which floats hold.
  void set_index(uint32_t index);
  // Checks, encodes and hands on one frame. Never waits.
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

// "body 17"
std::vector<std::string> body_names(size_t count);

}  // namespace fire3dv::bench
