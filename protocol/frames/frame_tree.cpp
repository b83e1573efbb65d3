#include "protocol/frames/frame_tree.h"

#include <algorithm>

namespace fire3dv::frames {

FrameTree::Node& FrameTree::node(FrameId frame) {
  Node& node = nodes_[frame];
  if (node.round != round_) {
    node.round = round_;
    node.state = State::open;
    node.is_on_path = node.is_collected = false;
  }
  return node;
}

// A frame of another clock has no transform near the time: its newest counts.
FrameSample FrameTree::sample(const Frame& frame) const {
  if (!time_ns_ || frame.samples.front().stamp_ns > *time_ns_ + FrameBuffer::kCacheNs)
    return frame.samples.back();
  return FrameBuffer::clamped(frame, *time_ns_);
}

void FrameTree::begin(const FrameBuffer& buffer, FrameId fixed, std::optional<int64_t> time_ns) {
  buffer_ = &buffer;
  fixed_ = fixed;
  time_ns_ = time_ns;
  ++round_;
  nodes_.resize(buffer.frames().size());
  ancestors_.clear();
  Transform fixed_from_ancestor;
  for (FrameId id = fixed; id != kNoFrame;) {
    Node& known = node(id);
    if (known.state == State::known) break;  // a loop
    known.state = State::known;
    known.fixed_from_frame = fixed_from_ancestor;
    if (id != fixed) ancestors_.push_back(id);
    if (frame(id).is_root()) break;
    const FrameSample up = sample(frame(id));
    fixed_from_ancestor = fixed_from_ancestor * inverse(up.parent_from_frame);
    id = up.parent;
  }
}

const Transform* FrameTree::find(FrameId id) {
  path_.clear();
  FrameId at = id;
  State end = State::none;
  while (true) {
    Node& here = node(at);
    if (here.state != State::open) {
      end = here.state;
      break;
    }
    if (here.is_on_path) {
      end = State::loop;
      break;
    }
    if (frame(at).is_root()) {
      here.state = State::none;
      break;
    }
    here.is_on_path = true;
    const FrameSample up = sample(frame(at));
    path_.emplace_back(at, up.parent_from_frame);
    at = up.parent;
  }
  for (auto step = path_.rbegin(); step != path_.rend(); ++step) {
    Node& below = node(step->first);
    below.is_on_path = false;
    below.state = end;
    if (end == State::known) below.fixed_from_frame = node(at).fixed_from_frame * step->second;
    at = step->first;
  }
  const Node& found = node(id);
  return found.state == State::known ? &found.fixed_from_frame : nullptr;
}

bool FrameTree::is_in_loop(FrameId id) const {
  return nodes_[id].round == round_ && nodes_[id].state == State::loop;
}

FrameId FrameTree::root_of(FrameId id, std::unordered_map<FrameId, FrameId>& roots) const {
  std::vector<FrameId> below;
  while (below.size() < buffer_->frames().size() && !frame(id).is_root()) {
    if (const auto known = roots.find(id); known != roots.end()) {
      id = known->second;
      break;
    }
    below.push_back(id);
    id = frame(id).samples.back().parent;
  }
  for (const FrameId each : below) roots[each] = id;
  return id;
}

std::vector<FrameId> FrameTree::moving_frames(const std::vector<FrameId>& frames) {
  std::vector<FrameId> moving;
  const auto collect = [&](FrameId id) {
    node(id).is_collected = true;
    if (frame(id).is_stamped()) moving.push_back(id);
  };
  size_t ancestors = 0;  // ancestors of the fixed frame that some path leads over
  for (FrameId id : frames) {
    if (!find(id)) continue;
    while (id != fixed_ && !node(id).is_collected) {
      if (const auto above = std::find(ancestors_.begin(), ancestors_.end(), id); above != ancestors_.end()) {
        ancestors = std::max(ancestors, static_cast<size_t>(above - ancestors_.begin()) + 1);
        break;
      }
      collect(id);
      id = frame(id).samples.back().parent;
    }
  }
  FrameId below = fixed_;
  for (size_t i = 0; i < ancestors; ++i) {
    collect(below);
    below = ancestors_[i];
  }
  return moving;
}

}  // namespace fire3dv::frames
