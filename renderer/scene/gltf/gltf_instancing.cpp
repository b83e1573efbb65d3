#include "renderer/scene/gltf/gltf_instancing.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "renderer/scene/gltf/gltf_values.h"
#include "renderer/scene/gltf/meshes/gltf_accessors.h"

namespace fire3dv::scene {
namespace {

// Limit per file: each instance becomes a node, and nodes may share accessors.
constexpr size_t kMaxInstances = size_t{1} << 20;

struct Parts {
  glm::vec3 translation{0};
  glm::vec4 rotation{0, 0, 0, 1};  // x, y, z, w as in the file
  glm::vec3 scale{1};
};
constexpr size_t kPartFloats = sizeof(Parts) / sizeof(float);
static_assert(sizeof(Parts) == kPartFloats * sizeof(float));

// Rotations are floats or normalised integers; translations and scales are floats.
Result<void> check_type(const tinygltf::Accessor& accessor, bool is_rotation, const std::string& where) {
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) return {};
  const bool is_short = accessor.componentType == TINYGLTF_COMPONENT_TYPE_BYTE ||
                        accessor.componentType == TINYGLTF_COMPONENT_TYPE_SHORT;
  if (is_rotation && is_short && accessor.normalized) return {};
  return Error{where + " has the componentType " + std::to_string(accessor.componentType) +
               (accessor.normalized ? ", normalized" : ", not normalized") +
               ", which EXT_mesh_gpu_instancing does not allow"};
}

glm::mat4 matrix_of(const Parts& parts) {
  const glm::mat4 turned =
      glm::translate(glm::mat4(1), parts.translation) *
      glm::mat4_cast(glm::quat(parts.rotation.w, parts.rotation.x, parts.rotation.y, parts.rotation.z));
  return glm::scale(turned, parts.scale);
}

}  // namespace

Result<std::optional<std::vector<glm::mat4>>> Instancing::node_from_instances(const tinygltf::Node& source,
                                                                              const std::string& where) {
  const auto extension = source.extensions.find("EXT_mesh_gpu_instancing");
  if (extension == source.extensions.end()) return std::optional<std::vector<glm::mat4>>();
  const std::string name = where + ".extensions.EXT_mesh_gpu_instancing";
  if (!extension->second.Has("attributes")) return Error{name + ": attributes is missing"};
  const tinygltf::Value& attributes = extension->second.Get("attributes");

  std::vector<Parts> parts;
  const AccessorReader reader(document_, limits_);
  struct Attribute {
    const char* name;
    size_t first_float;
    int components;
  };
  for (const Attribute& attribute :
       {Attribute{"TRANSLATION", 0, 3}, Attribute{"ROTATION", 3, 4}, Attribute{"SCALE", 7, 3}}) {
    const int accessor = index_or(attributes, attribute.name, -1);
    if (accessor < 0) continue;
    const std::string at = name + ".attributes." + attribute.name;
    auto count = reader.count(accessor, at);
    if (!count) return count.error();
    const bool is_rotation = attribute.components == 4;
    if (auto ok = check_type(document_.model.accessors[static_cast<size_t>(accessor)], is_rotation, at); !ok)
      return ok.error();
    if (parts.empty()) {
      if (*count > kMaxInstances - instances_)
        return Error{at + ": the file holds more than " + std::to_string(kMaxInstances) +
                     " instances; split it"};
      if (*count > limits_.max_nodes)
        return Error{at + ": the file has more than " + std::to_string(limits_.max_nodes) + " nodes"};
      instances_ += *count;
      parts.resize(*count);
    } else if (*count != parts.size()) {
      return Error{at + " has " + std::to_string(*count) + " elements, but another attribute has " +
                   std::to_string(parts.size())};
    }
    auto done = reader.read_floats(accessor, at, &parts[0].translation.x + attribute.first_float, kPartFloats,
                                   attribute.components, attribute.components);
    if (!done) return done.error();
  }
  if (parts.empty())
    return Error{name +
                 " has neither TRANSLATION nor ROTATION nor SCALE: the number of instances is unknown"};

  std::vector<glm::mat4> node_from_instance;
  node_from_instance.reserve(parts.size());
  for (Parts& part : parts) {
    const float length = glm::length(part.rotation);
    if (!(length > 1e-6f) || !std::isfinite(length)) {
      return Error{name + ".attributes.ROTATION holds, at " + std::to_string(node_from_instance.size()) +
                   ", no rotation: its length is not 1"};
    }
    part.rotation /= length;
    node_from_instance.push_back(matrix_of(part));
  }
  return std::optional(std::move(node_from_instance));
}

}  // namespace fire3dv::scene
