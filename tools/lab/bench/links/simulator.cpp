#include "tools/lab/bench/links/simulator.h"

#include <algorithm>
#include <fstream>

#include "base/clock.h"
#include "base/random.h"
#include "protocol/wire/check.h"

namespace fire3dv::bench {

std::vector<std::string> body_names(size_t count) {
  std::vector<std::string> names(count);
  for (size_t i = 0; i < count; ++i) names[i] = "body " + std::to_string(i);
  return names;
}

Result<std::unique_ptr<Simulator>> Simulator::open(const std::string& uri, size_t poses,
                                                   const transport::PublisherOptions& options) {
  auto link = transport::open_publisher(uri, options);
  if (!link) return link.error();
  std::unique_ptr<Simulator> simulator(new Simulator);
  simulator->link_ = std::move(*link);
  simulator->poses_.resize(poses);
  simulator->poses_per_part_ = wire::poses_per_part(simulator->link_->max_pose_message_bytes());
  wire::StreamDescription description;
  description.adapter_name = "fire3dv-bench";
  description.epoch = fire3dv::random_id();
  description.node_names = body_names(poses);
  // Equal boot ids allow the receiver to compare its clock with publish times.
  std::ifstream("/proc/sys/kernel/random/boot_id") >> description.clock.boot_id;
  simulator->frame_.header.epoch = description.epoch;
  simulator->frame_.node_count = static_cast<uint32_t>(poses);
  if (auto described = simulator->link_->set_description(wire::encode(description)); !described)
    return described.error();
  return simulator;
}

void Simulator::set_index(uint32_t index) {
  for (wire::Affine3x4& pose : poses_) pose.m[0] = static_cast<float>(index);
}

void Simulator::publish() noexcept {
  ++frame_.header.sequence;
  frame_.header.publish_time_ns = static_cast<uint64_t>(fire3dv::monotonic_ns());
  frame_.header.sim_time_ns = static_cast<int64_t>(frame_.header.publish_time_ns);
  if (!wire::check_poses("poses", poses_, 1e12f)) return;
  const std::span<const wire::Affine3x4> poses = poses_;
  for (size_t first = 0; first < poses.size(); first += poses_per_part_) {
    frame_.first_node = static_cast<uint32_t>(first);
    frame_.poses = poses.subspan(first, std::min(poses_per_part_, poses.size() - first));
    link_->publish(encoder_.encode(frame_), first + frame_.poses.size() == poses.size());
  }
}

}  // namespace fire3dv::bench
