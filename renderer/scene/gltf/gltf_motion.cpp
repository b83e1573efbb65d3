#include "renderer/scene/gltf/gltf_motion.h"

#include <nlohmann/json.hpp>

#include "renderer/scene/gltf/gltf_document.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

const json& array_of(const json& object, const char* member) {
  static const json kEmpty = json::array();
  const auto found = object.find(member);
  return found == object.end() ? kEmpty : *found;
}

Result<int> needed_index(const json& object, const char* member, const std::string& where) {
  const auto found = object.find(member);
  if (found == object.end() || !found->is_number()) return Error{where + ": " + member + " is missing"};
  return found->get<int>();
}

Result<AnimationSource::Sampler> sampler_of(const json& source, const std::string& where) {
  AnimationSource::Sampler sampler;
  auto input = needed_index(source, "input", where);
  if (!input) return input.error();
  auto output = needed_index(source, "output", where);
  if (!output) return output.error();
  sampler.input = *input;
  sampler.output = *output;
  sampler.interpolation = source.value("interpolation", std::string("LINEAR"));
  return sampler;
}

Result<AnimationSource::Channel> channel_of(const json& source, const std::string& where) {
  AnimationSource::Channel channel;
  auto sampler = needed_index(source, "sampler", where);
  if (!sampler) return sampler.error();
  channel.sampler = *sampler;
  const auto target = source.find("target");
  if (target == source.end() || !target->is_object()) return Error{where + ": target is missing"};
  channel.node = target->value("node", -1);
  channel.path = target->value("path", std::string());
  if (channel.path.empty()) return Error{where + ".target: path is missing"};
  return channel;
}

Result<AnimationSource> animation_of(const json& source, const std::string& where) {
  AnimationSource animation;
  animation.name = source.value("name", std::string());
  const json& samplers = array_of(source, "samplers");
  for (size_t i = 0; i < samplers.size(); ++i) {
    auto sampler = sampler_of(samplers[i], where + "." + element("samplers", i));
    if (!sampler) return sampler.error();
    animation.samplers.push_back(std::move(*sampler));
  }
  const json& channels = array_of(source, "channels");
  for (size_t i = 0; i < channels.size(); ++i) {
    auto channel = channel_of(channels[i], where + "." + element("channels", i));
    if (!channel) return channel.error();
    animation.channels.push_back(std::move(*channel));
  }
  return animation;
}

}  // namespace

Result<void> take_motion(json& root, std::vector<SkinSource>& skins,
                         std::vector<AnimationSource>& animations) {
  for (const json& source : array_of(root, "skins")) {
    SkinSource skin;
    skin.name = source.value("name", std::string());
    for (const json& joint : array_of(source, "joints")) skin.joints.push_back(joint.get<int>());
    skin.inverse_bind_matrices = source.value("inverseBindMatrices", -1);
    skins.push_back(std::move(skin));
  }
  const json& sources = array_of(root, "animations");
  for (size_t i = 0; i < sources.size(); ++i) {
    auto animation = animation_of(sources[i], element("animations", i));
    if (!animation) return animation.error();
    animations.push_back(std::move(*animation));
  }
  root.erase("skins");
  root.erase("animations");
  return {};
}

}  // namespace fire3dv::scene
