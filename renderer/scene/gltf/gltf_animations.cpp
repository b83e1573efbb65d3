#include "renderer/scene/gltf/gltf_parts.h"

#include <cmath>
#include <map>
#include <optional>
#include <tuple>

namespace fire3dv::scene {
namespace {

// Limit per file: channels may share accessors, so that a small file could claim any amount of memory.
constexpr size_t kMaxKeyFloats = size_t{1} << 28;

std::optional<AnimationPath> path_named(const std::string& name) {
  if (name == "translation") return AnimationPath::translation;
  if (name == "rotation") return AnimationPath::rotation;
  if (name == "scale") return AnimationPath::scale;
  if (name == "weights") return AnimationPath::weights;
  return std::nullopt;
}

std::optional<Interpolation> interpolation_named(const std::string& name) {
  if (name == "STEP") return Interpolation::step;
  if (name == "LINEAR") return Interpolation::linear;
  if (name == "CUBICSPLINE") return Interpolation::cubic_spline;
  return std::nullopt;
}

class AnimationLoader {
 public:
  AnimationLoader(const GltfDocument& document, const LoadLimits& limits,
                  std::span<const uint32_t> node_of_source, Scene& scene)
      : reader_(document, limits), node_of_source_(node_of_source), scene_(scene) {}

  Result<void> add(const AnimationSource& source, const std::string& where) {
    Animation animation;
    animation.name = source.name;
    animation.first_channel = static_cast<uint32_t>(scene_.channels.size());
    for (size_t i = 0; i < source.channels.size(); ++i) {
      auto done = add_channel(source, source.channels[i], where, where + "." + element("channels", i));
      if (!done) return done;
    }
    animation.channel_count = static_cast<uint32_t>(scene_.channels.size()) - animation.first_channel;
    for (uint32_t c = animation.first_channel; c < scene_.channels.size(); ++c) {
      const AnimationChannel& channel = scene_.channels[c];
      animation.duration_s =
          std::max(animation.duration_s, scene_.key_times_s[channel.first_time + channel.key_count - 1]);
    }
    scene_.animations.push_back(std::move(animation));
    return {};
  }

 private:
  struct Range {
    uint32_t first = 0, count = 0;
  };
  // Channels with equal keys share their sampler data.
  using ValuesKey = std::tuple<int, AnimationPath, Interpolation, uint32_t, uint32_t>;

  Result<void> add_channel(const AnimationSource& animation, const AnimationSource::Channel& source,
                           const std::string& of_animation, const std::string& where) {
    if (!in_range(source.sampler, animation.samplers.size()))
      return out_of_range(where, "samplers", source.sampler, animation.samplers.size());
    const auto left_out = [&](const std::string& why) {
      scene_.warnings.push_back(where + " " + why + " and is left out");
      return Result<void>();
    };
    if (source.path == "pointer") return {};  // KHR_animation_pointer, reported once for the file
    if (source.node < 0) return left_out("moves no node");
    if (!in_range(source.node, node_of_source_.size()))
      return out_of_range(where, "nodes", source.node, node_of_source_.size());
    const auto path = path_named(source.path);
    if (!path) return left_out("has a path other than translation, rotation, scale and weights");
    const uint32_t index = node_of_source_[static_cast<size_t>(source.node)];
    if (index == kNone) return {};  // in another scene of the file
    const Node& node = scene_.nodes[index];
    const std::string name = element("nodes", static_cast<size_t>(source.node));
    if (*path == AnimationPath::weights && node.morph_weight_count == 0)
      return left_out("moves the weights of " + name + ", which has no morph targets,");
    if (*path != AnimationPath::weights && node.given_by_matrix)
      return left_out("moves a part of " + name + ", which is given by a matrix,");

    const AnimationSource::Sampler& sampler = animation.samplers[static_cast<size_t>(source.sampler)];
    const std::string of_sampler =
        of_animation + "." + element("samplers", static_cast<size_t>(source.sampler));
    const auto interpolation = interpolation_named(sampler.interpolation);
    if (!interpolation) return Error{of_sampler + ".interpolation is none of STEP, LINEAR and CUBICSPLINE"};
    if (!reader_.has_data(sampler.input)) return left_out("has a sampler without key times");
    if (*path == AnimationPath::rotation && !reader_.has_data(sampler.output))
      return left_out("has a sampler without rotations");
    auto times = times_of(sampler.input, of_sampler + ".input");
    if (!times) return times.error();
    AnimationChannel channel;
    channel.node = index;
    channel.path = *path;
    channel.interpolation = *interpolation;
    channel.width = *path == AnimationPath::rotation  ? 4
                    : *path == AnimationPath::weights ? node.morph_weight_count
                                                      : 3;
    channel.first_time = times->first;
    channel.key_count = times->count;
    auto first_value = values_of(sampler.output, channel, of_sampler + ".output");
    if (!first_value) return first_value.error();
    channel.first_value = *first_value;
    scene_.channels.push_back(channel);
    return {};
  }

  Result<Range> times_of(int accessor, const std::string& where) {
    if (const auto known = times_.find(accessor); known != times_.end()) return known->second;
    auto count = reader_.count(accessor, where);
    if (!count) return count.error();
    std::vector<float>& times = scene_.key_times_s;
    if (*count > kMaxKeyFloats - times.size()) return too_many(where);
    const Range range{static_cast<uint32_t>(times.size()), static_cast<uint32_t>(*count)};
    if (auto room = reader_.reserve(sizeof(float) * uint64_t{*count}, where); !room) return room.error();
    times.resize(times.size() + *count);
    if (auto done = reader_.read_floats(accessor, where, &times[range.first], 1, 1, 1); !done)
      return done.error();
    for (size_t i = 0; i < *count; ++i) {
      const float time = times[range.first + i];
      if (time < 0) return Error{where + ": key " + std::to_string(i) + " lies before time 0"};
      if (i > 0 && time <= times[range.first + i - 1])
        return Error{where + ": key " + std::to_string(i) + " is not later than the one before it"};
    }
    times_.emplace(accessor, range);
    return range;
  }

  Result<uint32_t> values_of(int accessor, const AnimationChannel& channel, const std::string& where) {
    const ValuesKey key(accessor, channel.path, channel.interpolation, channel.width, channel.key_count);
    if (const auto known = values_.find(key); known != values_.end()) return known->second;
    auto count = reader_.count(accessor, where);
    if (!count) return count.error();
    const bool scalars = channel.path == AnimationPath::weights;
    const size_t values =
        size_t{channel.key_count} * (channel.interpolation == Interpolation::cubic_spline ? 3 : 1);
    const size_t needed = values * (scalars ? channel.width : 1);
    if (*count != needed) {
      return Error{where + " holds " + std::to_string(*count) + " elements, but its " +
                   std::to_string(channel.key_count) + " keys need " + std::to_string(needed)};
    }
    const size_t floats = values * channel.width;
    const size_t first = scene_.key_values.size();
    if (floats > kMaxKeyFloats - first) return too_many(where);
    if (auto room = reader_.reserve(sizeof(float) * uint64_t{floats}, where); !room) return room.error();
    scene_.key_values.resize(first + floats);
    const int components = scalars ? 1 : static_cast<int>(channel.width);
    auto done = reader_.read_floats(accessor, where, &scene_.key_values[first],
                                    static_cast<size_t>(components), components, components);
    if (!done) return done.error();
    if (channel.path == AnimationPath::rotation) {
      if (auto checked = normalize_rotations(channel, first, values, where); !checked) return checked.error();
    }
    values_.emplace(key, static_cast<uint32_t>(first));
    return static_cast<uint32_t>(first);
  }

  // Quantised rotations are renormalised. Spline values are not, since their tangents belong to them.
  Result<void> normalize_rotations(const AnimationChannel& channel, size_t first, size_t values,
                                   const std::string& where) {
    const bool spline = channel.interpolation == Interpolation::cubic_spline;
    for (size_t i = spline ? 1 : 0; i < values; i += spline ? 3 : 1) {
      float* value = &scene_.key_values[first + i * 4];
      double square = 0;
      for (int c = 0; c < 4; ++c) square += double{value[c]} * double{value[c]};
      const double length = std::sqrt(square);
      if (!(length > 1e-6))
        return Error{where + " holds no rotation at element " + std::to_string(i) + ": its length is not 1"};
      if (spline) continue;
      for (int c = 0; c < 4; ++c) value[c] = static_cast<float>(value[c] / length);
    }
    return {};
  }

  static Error too_many(const std::string& where) {
    return Error{where + ": the animations of the file hold more than " + std::to_string(kMaxKeyFloats) +
                 " numbers; split it"};
  }

  AccessorReader reader_;
  std::span<const uint32_t> node_of_source_;
  Scene& scene_;
  std::map<int, Range> times_;
  std::map<ValuesKey, uint32_t> values_;
};

}  // namespace

Result<void> add_animations(const GltfDocument& document, const LoadLimits& limits,
                            std::span<const uint32_t> node_of_source, Scene& scene) {
  AnimationLoader loader(document, limits, node_of_source, scene);
  for (size_t i = 0; i < document.animations.size(); ++i) {
    if (auto done = loader.add(document.animations[i], element("animations", i)); !done) return done;
  }
  return {};
}

}  // namespace fire3dv::scene
