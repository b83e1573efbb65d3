#include "renderer/state/motion/animation.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/numbers.h"
#include "renderer/scene/files.h"

namespace fire3dv::state {
namespace {

using scene::AnimationPath;
using scene::Interpolation;

void normalize(std::span<float> rotation) {
  double square = 0;
  for (const float part : rotation) square += double{part} * double{part};
  const double length = std::sqrt(square);
  // A cubic spline may pass through the zero quaternion, which has no direction.
  if (!(length > 1e-12)) {
    std::fill(rotation.begin(), rotation.end(), 0.0f);
    rotation[3] = 1;
    return;
  }
  for (float& part : rotation) part = static_cast<float>(part / length);
}

// Spherical linear interpolation along the shorter arc.
void slerp(const float* from, const float* to, double fraction, std::span<float> value) {
  double cosine = 0;
  for (size_t i = 0; i < 4; ++i) cosine += double{from[i]} * double{to[i]};
  const double sign = cosine < 0 ? -1 : 1;
  const double angle = std::acos(std::min(std::abs(cosine), 1.0));
  // For small angles sin(angle) loses precision; linear interpolation is exact enough.
  double a = 1 - fraction, b = fraction;
  if (angle > 1e-4) {
    a = std::sin(angle * (1 - fraction)) / std::sin(angle);
    b = std::sin(angle * fraction) / std::sin(angle);
  }
  for (size_t i = 0; i < 4; ++i) value[i] = static_cast<float>(a * from[i] + sign * b * to[i]);
}

double looped(double time_s, double duration_s) {
  return duration_s > 0 ? time_s - std::floor(time_s / duration_s) * duration_s : 0.0;
}

// Example: "0 \"Walk\", 1 \"Run\"".
std::string list_animations(const scene::Scene& scene) {
  constexpr size_t kShown = 10;
  std::string text;
  for (size_t i = 0; i < std::min(scene.animations.size(), kShown); ++i)
    text += (i ? ", " : "") + std::to_string(i) + " " + quote(scene.animations[i].name);
  if (scene.animations.size() > kShown)
    text += " and " + std::to_string(scene.animations.size() - kShown) + " more";
  return text;
}

std::vector<uint32_t> all_that_agree(const scene::Scene& scene) {
  std::vector<uint32_t> chosen;
  std::set<std::pair<uint32_t, AnimationPath>> taken;
  for (uint32_t index = 0; index < scene.animations.size(); ++index) {
    const scene::Animation& animation = scene.animations[index];
    std::set<std::pair<uint32_t, AnimationPath>> moves;
    for (uint32_t c = animation.first_channel; c < animation.first_channel + animation.channel_count; ++c)
      moves.emplace(scene.channels[c].node, scene.channels[c].path);
    const bool clashes =
        std::any_of(moves.begin(), moves.end(), [&](const auto& m) { return taken.contains(m); });
    if (moves.empty() || clashes) continue;
    taken.merge(moves);
    chosen.push_back(index);
  }
  return chosen;
}

}  // namespace

RestPose rest_pose(const scene::Scene& scene) {
  RestPose pose;
  pose.parent_from_node.reserve(scene.nodes.size());
  pose.world_from_node.reserve(scene.nodes.size());
  for (const scene::Node& node : scene.nodes) {
    pose.parent_from_node.push_back(node.parent_from_node);
    pose.world_from_node.push_back(node.world_from_node);
  }
  pose.morph_weights = scene.morph_weights;
  return pose;
}

void sample(const scene::Scene& scene, const scene::AnimationChannel& channel, double time_s,
            std::span<float> value) {
  const std::span times = std::span(scene.key_times_s).subspan(channel.first_time, channel.key_count);
  const bool spline = channel.interpolation == Interpolation::cubic_spline;
  const size_t width = channel.width;
  // The part of a cubic spline's key: 0 in-tangent, 1 value, 2 out-tangent.
  const auto key_value = [&](size_t key, size_t part) {
    return &scene.key_values[channel.first_value + (spline ? key * 3 + part : key) * width];
  };
  const auto later = std::upper_bound(times.begin(), times.end(), time_s,
                                      [](double t, float key) { return t < double{key}; });
  const auto next = static_cast<size_t>(later - times.begin());
  const bool rotation = channel.path == AnimationPath::rotation;
  if (next == 0 || next == times.size() || channel.interpolation == Interpolation::step) {
    std::copy_n(key_value(next == 0 ? 0 : next - 1, 1), width, value.begin());
    if (rotation) normalize(value.first(4));
    return;
  }
  const float *from = key_value(next - 1, 1), *to = key_value(next, 1);
  const double span_s = double{times[next]} - double{times[next - 1]};
  const double t = (time_s - double{times[next - 1]}) / span_s;
  if (spline) {
    const float *out = key_value(next - 1, 2), *in = key_value(next, 0);
    const double t2 = t * t, t3 = t2 * t;
    for (size_t i = 0; i < width; ++i) {
      value[i] = static_cast<float>((2 * t3 - 3 * t2 + 1) * from[i] + span_s * (t3 - 2 * t2 + t) * out[i] +
                                    (-2 * t3 + 3 * t2) * to[i] + span_s * (t3 - t2) * in[i]);
    }
  } else if (rotation) {
    slerp(from, to, t, value);
  } else {
    for (size_t i = 0; i < width; ++i) value[i] = static_cast<float>((1 - t) * from[i] + t * to[i]);
  }
  if (rotation) normalize(value.first(4));
}

Result<std::vector<uint32_t>> choose_animations(const scene::Scene& scene, const std::string& argument) {
  if (scene.animations.empty()) return Error{"--animate: the scene has no animations: leave it out"};
  std::vector<uint32_t> named;
  for (uint32_t i = 0; i < scene.animations.size(); ++i) {
    if (!argument.empty() && scene.animations[i].name == argument) named.push_back(i);
  }
  if (named.size() == 1) return named;
  const std::string there_are = "; there are " + list_animations(scene);
  if (named.size() > 1) {
    return Error{"--animate " + quote(argument) + ": " + std::to_string(named.size()) +
                 " animations have that name, so give an index" + there_are};
  }
  if (argument == "all") {
    std::vector<uint32_t> all = all_that_agree(scene);
    if (all.empty()) return Error{"--animate: the scene's animations move nothing that is shown"};
    return all;
  }
  const std::optional<uint32_t> index = parse_number<uint32_t>(argument);
  if (index && *index < scene.animations.size()) return std::vector<uint32_t>{*index};
  return Error{"--animate " + quote(argument) + ": no animation has that name or index" + there_are};
}

std::string animation_title(const scene::Scene& scene, uint32_t animation) {
  const std::string& name = scene.animations[animation].name;
  return name.empty() ? std::to_string(animation) : quote(name);
}

AnimationPlayer::AnimationPlayer(const scene::Scene& scene, const std::vector<uint32_t>& animations)
    : scene_(scene), pose_(rest_pose(scene)) {
  std::vector<uint32_t> parts_of_node(scene.nodes.size(), scene::kNone);
  size_t widest = 0;
  for (const uint32_t index : animations) {
    const scene::Animation& animation = scene.animations[index];
    for (uint32_t c = animation.first_channel; c < animation.first_channel + animation.channel_count; ++c) {
      const scene::AnimationChannel& channel = scene.channels[c];
      widest = std::max<size_t>(widest, channel.width);
      Playing playing{c, animation.duration_s};
      if (channel.path != AnimationPath::weights) {
        uint32_t& parts = parts_of_node[channel.node];
        if (parts == scene::kNone) {
          parts = static_cast<uint32_t>(parts_.size());
          const scene::Node& node = scene.nodes[channel.node];
          parts_.push_back({channel.node, node.translation, node.scale, node.rotation});
        }
        playing.parts = parts;
      }
      playing_.push_back(playing);
    }
  }
  value_.resize(widest);
  std::vector<bool> moved(scene.nodes.size());
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    moved[node] = parts_of_node[node] != scene::kNone || (parent != scene::kNone && moved[parent]);
    if (moved[node]) moved_.push_back(node);
  }
}

double AnimationPlayer::duration_s() const {
  float longest = 0;
  for (const Playing& playing : playing_) longest = std::max(longest, playing.duration_s);
  return static_cast<double>(longest);
}

const RestPose& AnimationPlayer::at(double time_s) {
  for (const Playing& playing : playing_) apply(playing, time_s);
  for (const Parts& parts : parts_) {
    pose_.parent_from_node[parts.node] =
        scene::parent_from_parts(parts.translation, parts.rotation, parts.scale);
  }
  for (const uint32_t node : moved_) {
    const uint32_t parent = scene_.nodes[node].parent;
    const glm::mat4& parent_from_node = pose_.parent_from_node[node];
    pose_.world_from_node[node] =
        parent == scene::kNone ? parent_from_node : pose_.world_from_node[parent] * parent_from_node;
  }
  return pose_;
}

void AnimationPlayer::apply(const Playing& playing, double time_s) {
  const scene::AnimationChannel& channel = scene_.channels[playing.channel];
  sample(scene_, channel, looped(time_s, playing.duration_s), value_);
  if (channel.path == AnimationPath::weights) {
    std::copy_n(value_.begin(), channel.width,
                pose_.morph_weights.begin() + scene_.nodes[channel.node].first_morph_weight);
    return;
  }
  Parts& parts = parts_[playing.parts];
  if (channel.path == AnimationPath::translation) parts.translation = {value_[0], value_[1], value_[2]};
  if (channel.path == AnimationPath::scale) parts.scale = {value_[0], value_[1], value_[2]};
  if (channel.path == AnimationPath::rotation)
    parts.rotation = glm::quat(value_[3], value_[0], value_[1], value_[2]);
}

}  // namespace fire3dv::state
