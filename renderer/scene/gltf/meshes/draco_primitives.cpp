#include "renderer/scene/gltf/meshes/draco_primitives.h"

#include <climits>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "renderer/scene/gltf/gltf_accessors.h"
#include "renderer/scene/gltf/gltf_document.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

const json* extension_of(const json& primitive) {
  const auto extensions = primitive.find("extensions");
  if (extensions == primitive.end()) return nullptr;
  const auto extension = extensions->find(kDracoExtension);
  return extension == extensions->end() ? nullptr : &*extension;
}

int components_of(const std::string& type) {
  static const std::map<std::string, int> kComponents{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
  const auto found = kComponents.find(type);
  return found == kComponents.end() ? 0 : found->second;
}

Result<const json*> accessor_of(const json& root, const json& index, const std::string& where) {
  const json* accessor = element_at(root, "accessors", index.get<size_t>());
  if (accessor != nullptr) return accessor;
  return out_of_range(where, "accessors", index.get<int>(),
                      root.contains("accessors") ? root["accessors"].size() : 0);
}

Result<uint64_t> count_of(const json& root, const json& index, const LoadLimits& limits,
                          const std::string& where) {
  auto accessor = accessor_of(root, index, where);
  if (!accessor) return accessor.error();
  const uint64_t count = (*accessor)->value("count", uint64_t{0});
  if (count > 0 && count <= limits.max_elements) return count;
  return Error{where + ": " + element("accessors", index.get<size_t>()) + " has " + std::to_string(count) +
               " elements; 1 to " + std::to_string(limits.max_elements) + " are read"};
}

Result<DracoAttribute> attribute_of(const json& root, const json& primitive, const std::string& name,
                                    const json& id) {
  const auto index = primitive["attributes"].find(name);
  if (index == primitive["attributes"].end())
    return Error{"attributes." + name + " is not an attribute of the primitive"};
  auto accessor = accessor_of(root, *index, "attributes." + name);
  if (!accessor) return accessor.error();
  DracoAttribute attribute{name, id.get<uint32_t>(), index->get<size_t>()};
  attribute.component_type = (*accessor)->value("componentType", 0);
  attribute.components = components_of((*accessor)->value("type", std::string()));
  attribute.packed_bytes =
      component_bytes(attribute.component_type) * static_cast<size_t>(attribute.components);
  if (attribute.packed_bytes == 0)
    return Error{"attributes." + name + ": " + element("accessors", attribute.accessor) +
                 " has a type or componentType that attributes do not have"};
  return attribute;
}

// Fills the attributes and the bounds that follow from the primitive's accessors.
Result<void> plan(const json& root, const json& extension, const LoadLimits& limits, DracoPrimitive& use) {
  const json& primitive = *use.primitive;
  const int mode = primitive.value("mode", TINYGLTF_MODE_TRIANGLES);
  if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP)
    return Error{"the primitive has the mode " + std::to_string(mode) +
                 ", but only triangles (4) and triangle strips (5) can be compressed"};
  const auto attributes = extension.find("attributes");
  if (attributes == extension.end() || !attributes->contains("POSITION"))
    return Error{"attributes.POSITION is missing"};
  for (const auto& [name, id] : attributes->items()) {
    auto attribute = attribute_of(root, primitive, name, id);
    if (!attribute) return attribute.error();
    use.attributes.push_back(std::move(*attribute));
  }
  auto points = count_of(root, primitive["attributes"]["POSITION"], limits, "attributes.POSITION");
  if (!points) return points.error();
  use.max_points = *points;
  use.max_faces = limits.max_elements / 3;
  if (primitive.contains("indices")) {
    auto indices = count_of(root, primitive["indices"], limits, "indices");
    if (!indices) return indices.error();
    use.max_faces = mode == TINYGLTF_MODE_TRIANGLES ? *indices / 3 : *indices;
  }
  return {};
}

}  // namespace

const json* element_at(const json& root, const char* array, size_t index) {
  const auto found = root.find(array);
  return found == root.end() || index >= found->size() ? nullptr : &(*found)[index];
}

std::vector<DracoStream> draco_streams(json& root, const LoadLimits& limits) {
  using Key = std::tuple<size_t, std::vector<DracoAttribute>, uint64_t, uint64_t>;
  std::vector<DracoStream> streams;
  std::map<size_t, size_t> stream_of_view;
  std::map<Key, size_t> known_uses;
  const auto meshes = root.find("meshes");
  for (size_t m = 0; meshes != root.end() && m < meshes->size(); ++m) {
    const auto primitives = (*meshes)[m].find("primitives");
    for (size_t p = 0; primitives != (*meshes)[m].end() && p < primitives->size(); ++p) {
      DracoPrimitive use{.primitive = &(*primitives)[p]};
      const json* extension = extension_of(*use.primitive);
      if (extension == nullptr) continue;
      use.where = element("meshes", m) + "." + element("primitives", p) + ".extensions." + kDracoExtension;
      // Without a view the stream is refused when its bytes are looked up.
      const size_t view = extension->value("bufferView", size_t{INT_MAX});
      const auto [known, is_new] = stream_of_view.try_emplace(view, streams.size());
      if (is_new) streams.push_back({view, {}});
      std::vector<DracoPrimitive>& uses = streams[known->second].uses;
      if (auto done = plan(root, *extension, limits, use); !done) {
        use.fault = done.error();
      } else {
        const Key key(view, use.attributes, use.max_faces, use.max_points);
        const auto [same, is_first] = known_uses.try_emplace(key, uses.size());
        if (!is_first) use.same_as = same->second;
      }
      uses.push_back(std::move(use));
    }
  }
  return streams;
}

}  // namespace fire3dv::scene
