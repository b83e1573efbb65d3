#include "tools/lab/bench/links/pose_feed.h"

#include <fstream>
#include <random>

#include "protocol/base/clock.h"
#include "protocol/transport/open.h"
#include "protocol/wire/encode.h"

namespace fire3dv::bench {
namespace {

constexpr uint64_t kStop = UINT64_MAX;
constexpr int64_t kStepNs = 1'000'000;

}  // namespace

Result<std::unique_ptr<PoseFeed>> PoseFeed::open(const std::string& uri, std::vector<std::string> names,
                                                 PoseAt pose_at) {
  Result<std::unique_ptr<transport::PublisherLink>> link = transport::open_publisher(uri);
  if (!link) return link.error();
  std::unique_ptr<PoseFeed> feed(new PoseFeed);
  feed->link_ = std::move(*link);
  feed->pose_at_ = std::move(pose_at);
  std::random_device random;
  feed->epoch_ = (uint64_t{random()} << 32 | random()) | 1;
  feed->count_ = static_cast<uint32_t>(names.size());

  wire::StreamDescription description;
  description.adapter_name = "fire3dv-bench";
  description.epoch = feed->epoch_;
  description.node_names = std::move(names);
  description.nominal_rate_hz = 1e9 / kStepNs;
  // A common boot_id disables interpolation: the renderer shows frames on arrival.
  std::ifstream("/proc/sys/kernel/random/boot_id") >> description.clock.boot_id;
  if (Result<void> described = feed->link_->set_description(wire::encode(description)); !described)
    return described.error();
  feed->thread_ = std::thread([raw = feed.get()] { raw->work(); });
  return feed;
}

PoseFeed::~PoseFeed() {
  wanted_ = kStop;
  wanted_.notify_one();
  if (thread_.joinable()) thread_.join();
}

uint64_t PoseFeed::ask_for_next() {
  const uint64_t sequence = ++wanted_;
  wanted_.notify_one();
  return sequence;
}

void PoseFeed::work() {
  wire::PoseFrameEncoder encoder;
  std::vector<wire::Affine3x4> poses;
  for (uint64_t sequence = 1;; ++sequence) {
    // The step is computed before the request, as by a simulator that is ahead.
    pose_at_(sequence, poses);
    uint64_t wanted = wanted_;
    while (wanted < sequence) {
      wanted_.wait(wanted);
      wanted = wanted_;
    }
    if (wanted == kStop) return;
    wire::PoseFrameView frame;
    frame.header.epoch = epoch_;
    frame.header.sequence = sequence;
    frame.header.sim_time_ns = static_cast<int64_t>(sequence) * kStepNs;
    frame.header.publish_time_ns = static_cast<uint64_t>(fire3dv::monotonic_ns());
    frame.node_count = count_;
    frame.poses = poses;
    link_->publish(encoder.encode(frame));
  }
}

}  // namespace fire3dv::bench
