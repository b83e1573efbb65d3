// Partial frames. The stream caches all poses, so that a link can send the whole frame to readers that lack
// its base.
#include <algorithm>

#include "stream.h"

namespace wire = fire3dv::wire;

namespace {
constexpr uint64_t kWholeEveryNs = 250'000'000;
}

void fire3dv_stream::cache_poses(std::span<const wire::Affine3x4> stream_from_body) {
  cached_poses.assign(stream_from_body.begin(), stream_from_body.end());
  has_cached_poses = true;
}

void fire3dv_stream::publish_some(int64_t sim_time_ns, uint32_t flags, std::span<const uint32_t> node_indices,
                                  std::span<const wire::Affine3x4> stream_from_body) {
  const uint64_t now_ns = fire3dv::client::monotonic_now_ns();
  const bool is_whole = node_indices.size() == node_count;
  if (is_whole)
    cache_poses(stream_from_body);
  else
    for (size_t i = 0; i < node_indices.size(); ++i) cached_poses[node_indices[i]] = stream_from_body[i];
  if (is_whole || !link->takes_partial_frames() || now_ns - whole_at_ns >= kWholeEveryNs)
    return publish(sim_time_ns, flags, cached_poses);

  wire::PoseFrameView frame;
  frame.header = {epoch, ++sequence, sim_time_ns, now_ns, scene_version, flags};
  frame.node_count = node_count;
  frame.node_indices = node_indices;
  frame.poses = stream_from_body;
  ++frames_published;
  const wire::Bytes partial = wire::encode(frame);
  frame.node_indices = {};
  whole.clear();
  const size_t parts = std::max<size_t>(1, (cached_poses.size() + poses_per_part - 1) / poses_per_part);
  part_encoders.resize(std::max(parts, part_encoders.size()));
  for (size_t part = 0; part < parts; ++part) {
    const size_t first = part * poses_per_part;
    frame.first_node = static_cast<uint32_t>(first);
    frame.poses = std::span<const wire::Affine3x4>(cached_poses)
                      .subspan(first, std::min<size_t>(poses_per_part, cached_poses.size() - first));
    whole.push_back(part_encoders[part].encode(frame));
  }
  link->publish_partial({partial, {}}, whole);
}
