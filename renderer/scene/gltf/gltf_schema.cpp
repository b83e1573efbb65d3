#include "renderer/scene/gltf/gltf_document.h"

#include <algorithm>
#include <array>
#include <climits>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>
#include <unordered_map>

#include "renderer/scene/files.h"
#include "renderer/scene/gltf/gltf_extensions.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

// Bit mask of allowed JSON types of a member name; several bits if glTF reuses the name.
enum Shape : unsigned {
  kIndex = 1,  // 0 .. INT_MAX, tinygltf's int
  kSize = 2,   // 0 .. 2^53
  kNumber = 4,
  kBoolean = 8,
  kText = 16,
  kIndices = 32,  // array of kIndex
  kNumbers = 64,  // array of numbers
  kObject = 128,
  kObjects = 256,         // array of objects
  kIndexMap = 512,        // object of kIndex: attributes
  kExtensionList = 1024,  // object, reduced to supported extensions
  kIndexMaps = 2048,      // array of kIndexMap: morph targets
};

const std::unordered_map<std::string_view, unsigned>& shapes() {
  static const std::unordered_map<std::string_view, unsigned> table{
      {"buffer", kIndex},
      {"bufferView", kIndex},
      {"componentType", kIndex},
      {"indices", kIndex | kObject},
      {"material", kIndex},
      {"mode", kIndex},
      {"mesh", kIndex},
      {"camera", kIndex},
      {"skin", kIndex},
      {"sampler", kIndex},
      {"source", kIndex},
      {"index", kIndex},
      {"texCoord", kIndex},
      {"light", kIndex},
      {"byteStride", kIndex},
      {"magFilter", kIndex},
      {"minFilter", kIndex},
      {"wrapS", kIndex},
      {"wrapT", kIndex},
      {"byteOffset", kSize},
      {"byteLength", kSize},
      {"count", kSize},
      {"metallicFactor", kNumber},
      {"roughnessFactor", kNumber},
      {"strength", kNumber},
      {"alphaCutoff", kNumber},
      {"intensity", kNumber},
      {"range", kNumber},
      {"emissiveStrength", kNumber},
      {"ior", kNumber},
      {"specularFactor", kNumber | kNumbers},  // a colour in specular-glossiness
      {"diffuseFactor", kNumbers},
      {"glossinessFactor", kNumber},
      {"diffuseTexture", kObject},
      {"specularGlossinessTexture", kObject},
      {"specularColorFactor", kNumbers},
      {"clearcoatFactor", kNumber},
      {"clearcoatRoughnessFactor", kNumber},
      {"sheenColorFactor", kNumbers},
      {"sheenRoughnessFactor", kNumber},
      {"anisotropyStrength", kNumber},
      {"anisotropyRotation", kNumber},
      {"iridescenceFactor", kNumber},
      {"iridescenceIor", kNumber},
      {"iridescenceThicknessMinimum", kNumber},
      {"iridescenceThicknessMaximum", kNumber},
      {"transmissionFactor", kNumber},
      {"thicknessFactor", kNumber},
      {"thicknessTexture", kObject},
      {"attenuationDistance", kNumber},
      {"attenuationColor", kNumbers},
      {"dispersion", kNumber},
      {"diffuseTransmissionFactor", kNumber},
      {"diffuseTransmissionColorFactor", kNumbers},
      {"diffuseTransmissionTexture", kObject},
      {"diffuseTransmissionColorTexture", kObject},
      {"specularTexture", kObject},
      {"specularColorTexture", kObject},
      {"clearcoatTexture", kObject},
      {"clearcoatRoughnessTexture", kObject},
      {"clearcoatNormalTexture", kObject},
      {"sheenColorTexture", kObject},
      {"sheenRoughnessTexture", kObject},
      {"anisotropyTexture", kObject},
      {"iridescenceTexture", kObject},
      {"iridescenceThicknessTexture", kObject},
      {"transmissionTexture", kObject},
      {"innerConeAngle", kNumber},
      {"outerConeAngle", kNumber},
      {"yfov", kNumber},
      {"znear", kNumber},
      {"zfar", kNumber},
      {"xmag", kNumber},
      {"ymag", kNumber},
      {"aspectRatio", kNumber},
      {"scale", kNumber | kNumbers},
      {"rotation", kNumber | kNumbers},
      {"matrix", kNumbers},
      {"translation", kNumbers},
      {"baseColorFactor", kNumbers},
      {"emissiveFactor", kNumbers},
      {"color", kNumbers},
      {"offset", kNumbers},
      {"doubleSided", kBoolean},
      {"visible", kBoolean},
      {"normalized", kBoolean},
      {"type", kText},
      {"alphaMode", kText},
      {"name", kText},
      {"mimeType", kText},
      {"uri", kText},
      {"children", kIndices},
      {"nodes", kIndices},
      {"pbrMetallicRoughness", kObject},
      {"baseColorTexture", kObject},
      {"metallicRoughnessTexture", kObject},
      {"normalTexture", kObject},
      {"occlusionTexture", kObject},
      {"emissiveTexture", kObject},
      {"sparse", kObject},
      {"values", kObject},
      {"perspective", kObject},
      {"orthographic", kObject},
      {"spot", kObject},
      {"primitives", kObjects},
      {"mappings", kObjects},
      {"variants", kObjects | kIndices},  // names of the file, numbers in a mapping
      {"lights", kObjects},
      {"attributes", kIndexMap},
      {"filter", kText},
      {"fallback", kBoolean},
      {"targets", kIndexMaps},
      {"weights", kNumbers},
      {"joints", kIndices},
      {"inverseBindMatrices", kIndex},
      {"channels", kObjects},
      {"samplers", kObjects},
      {"target", kObject | kIndex},  // object in a channel, index in a buffer view
      {"node", kIndex},
      {"path", kText},
      {"input", kIndex},
      {"output", kIndex},
      {"interpolation", kText},
      {"extensions", kExtensionList},
  };
  return table;
}

constexpr std::array<std::string_view, 13> kRootArrays{
    "accessors", "animations", "bufferViews", "buffers", "cameras", "images",  "materials",
    "meshes",    "nodes",      "samplers",    "scenes",  "skins",   "textures"};

// Normalises integers written as 3.0, which tinygltf does not accept.
bool is_integer(json& value, double max) {
  if (!value.is_number()) return false;
  const double number = value.get<double>();
  if (!(number >= 0 && number <= max) || number != static_cast<double>(static_cast<uint64_t>(number)))
    return false;
  if (!value.is_number_unsigned()) value = static_cast<uint64_t>(number);
  return true;
}
bool is_index(json& value) {
  return is_integer(value, INT_MAX);
}

template <typename Check>
bool all_of(json& container, Check check) {
  return std::all_of(container.begin(), container.end(), check);
}

constexpr double kLargestSize = 9007199254740992.0;

bool fits(json& value, unsigned shape, double largest_size = kLargestSize) {
  if ((shape & kIndex) && is_index(value)) return true;
  if ((shape & kSize) && is_integer(value, largest_size)) return true;
  if ((shape & kNumber) && value.is_number()) return true;
  if ((shape & kBoolean) && value.is_boolean()) return true;
  if ((shape & kText) && value.is_string()) return true;
  if (value.is_array()) {
    if ((shape & kIndices) && all_of(value, is_index)) return true;
    if ((shape & kNumbers) && all_of(value, [](json& v) { return v.is_number(); })) return true;
    if ((shape & kIndexMaps) && all_of(value, [](json& v) { return v.is_object() && all_of(v, is_index); }))
      return true;
    return (shape & kObjects) && all_of(value, [](json& v) { return v.is_object(); });
  }
  if (value.is_object()) {
    if ((shape & kIndexMap)) return all_of(value, is_index);
    return shape & (kObject | kExtensionList);
  }
  return false;
}

Result<void> reduce(json& object, const std::string& where);

// Names of material variants. tinygltf drops empty objects of an extension, which would renumber the others.
Result<void> reduce_variants(json& variants, const std::string& where) {
  for (size_t i = 0; i < variants.size(); ++i) {
    json& variant = variants[i];
    if (!variant.is_object()) continue;  // a number in a mapping
    if (!variant.contains("name") || !variant["name"].is_string())
      return Error{where + ".variants[" + std::to_string(i) + "]: name is missing"};
    variant = json{{"name", variant["name"]}};
  }
  return {};
}

Result<void> reduce_extensions(json& extensions, const std::string& where) {
  for (auto member = extensions.begin(); member != extensions.end();) {
    if (!extension_supported(member.key()) || !member->is_object()) {
      member = extensions.erase(member);
      continue;
    }
    if (auto done = reduce(*member, where + "." + member.key()); !done) return done;
    ++member;
  }
  return {};
}

// Extras are application data: members that the loader does not read are dropped without an error.
constexpr const char* kPunctualLight = ".KHR_lights_punctual.lights[";

json numbers_of(const json& extras) {
  json numbers = json::object();
  for (const auto& [name, value] : extras.items()) {
    if (value.is_number()) numbers[name] = value.get<double>();
  }
  return numbers;
}

// A number, flag or short list of numbers as it is; all else as a text, which its reader reports.
json read_value(const json& value) {
  constexpr size_t kMaxNumbers = 4;
  if (value.is_number()) return value.get<double>();
  if (value.is_boolean()) return value;
  json list = json::array();
  for (size_t i = 0; value.is_array() && value.size() <= kMaxNumbers && i < value.size(); ++i) {
    if (!value[i].is_number()) return "no number";
    list.push_back(value[i].get<double>());
  }
  return list.empty() ? json("no value") : list;
}

// True for an element of a list of the file itself.
bool is_element_of(const char* list, const std::string& where) {
  return where.starts_with(std::string(list) + "[") && where.find('.') == std::string::npos;
}

// Returns false for extras of which the loader reads nothing.
bool reduce_extras(json& extras, const std::string& where) {
  json reduced = json::object();
  const auto add = [&](const char* name) {
    if (extras.is_object() && extras.contains(name)) reduced[name] = read_value(extras[name]);
  };
  if (where.find(kPunctualLight) != std::string::npos) {
    reduced = numbers_of(extras);
  } else if (is_element_of("cameras", where)) {
    reduced = numbers_of(extras);
    add("principalPoint");
  } else if (is_element_of("nodes", where)) {
    add("semantic");
  } else if (is_element_of("meshes", where)) {
    add("unbounded");
  } else if (is_element_of("scenes", where)) {
    add("skyTexture");
    add("viewFrom");
  } else {
    return false;
  }
  extras = std::move(reduced);
  return true;
}

Result<void> reduce(json& object, const std::string& where) {
  // tinygltf stores sizes of sparse accessors as int.
  const double largest_size = where.find(".sparse") != std::string::npos ? INT_MAX : kLargestSize;
  for (auto member = object.begin(); member != object.end();) {
    if (member.key() == "extras" && reduce_extras(*member, where)) {
      ++member;
      continue;
    }
    const auto known = shapes().find(member.key());
    if (known == shapes().end()) {
      member = object.erase(member);
      continue;
    }
    json& value = *member;
    // "mode" is a number in primitives, and a string in compressed buffer views.
    const bool mode_of_view = member.key() == "mode" && where.ends_with("_meshopt_compression");
    const unsigned shape = mode_of_view ? kText : known->second;
    if (!fits(value, shape, largest_size))
      return Error{where + ": " + member.key() + " is not of the type that glTF requires"};
    if (member.key() == "variants") {
      if (auto done = reduce_variants(value, where); !done) return done;
    } else if (known->second == kExtensionList) {
      if (auto done = reduce_extensions(value, where + ".extensions"); !done) return done;
    } else if (known->second == kObjects) {
      for (size_t i = 0; i < value.size(); ++i) {
        const std::string element = where + "." + member.key() + "[" + std::to_string(i) + "]";
        if (auto done = reduce(value[i], element); !done) return done;
        // tinygltf drops such primitives, which would renumber the others.
        if (member.key() == "primitives" && !value[i].contains("attributes")) {
          return Error{element + ": attributes is missing"};
        }
      }
    } else if ((known->second & kObject) && value.is_object()) {
      if (auto done = reduce(value, where + "." + member.key()); !done) return done;
    }
    ++member;
  }
  return {};
}

Result<void> check_version(const json& document) {
  const auto asset = document.find("asset");
  if (asset == document.end() || !asset->is_object())
    return Error{"asset is missing: this is not a glTF 2.0 file"};
  for (const char* member : {"version", "minVersion"}) {
    const auto version = asset->find(member);
    if (version == asset->end()) {
      if (member == std::string_view("version"))
        return Error{"asset.version is missing: this is not a glTF 2.0 file"};
      continue;
    }
    if (!version->is_string()) return Error{std::string("asset.") + member + " is not a string"};
    const auto& text = version->get_ref<const std::string&>();
    const bool readable = member == std::string_view("version") ? text.starts_with("2.") : text <= "2.0";
    if (!readable)
      return Error{std::string("asset.") + member + " is " + quote(text) + ": only glTF 2.0 is supported"};
  }
  return {};
}

// Such a primitive refers to other accessors before tinygltf sees it.
bool is_draco_compressed(const json& primitive) {
  const auto extensions = primitive.find("extensions");
  return extensions != primitive.end() && extensions->contains("KHR_draco_mesh_compression");
}

// tinygltf refuses a file with an unknown type. A size of matrices that has no use stands for it, so that
// only what uses the accessor is refused.
void replace_unknown_types(json& document, std::vector<std::string>& warnings) {
  constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
  const auto accessors = document.find("accessors");
  if (accessors == document.end()) return;
  for (size_t i = 0; i < accessors->size(); ++i) {
    json& accessor = (*accessors)[i];
    const auto type = accessor.find("type");
    if (type == accessor.end() || !type->is_string()) continue;
    const auto& name = type->get_ref<const std::string&>();
    if (std::find(std::begin(kTypes), std::end(kTypes), name) != std::end(kTypes)) continue;
    warnings.push_back("accessors[" + std::to_string(i) + "] has the unknown type " + quote(name) +
                       " and is not read");
    accessor["name"] = "unknown type " + quote(name);  // for errors of what uses it
    *type = "MAT2";
  }
}

// tinygltf follows these indices itself, without a usable error message.
Result<void> check_index_accessors(const json& document) {
  static const json kNone = json::array();
  const auto array = [&](const char* name) -> const json& {
    return document.contains(name) ? document[name] : kNone;
  };
  const json& accessors = array("accessors");
  const json& meshes = array("meshes");
  for (size_t m = 0; m < meshes.size(); ++m) {
    if (!meshes[m].contains("primitives")) continue;
    const json& primitives = meshes[m]["primitives"];
    for (size_t p = 0; p < primitives.size(); ++p) {
      if (!primitives[p].contains("indices") || is_draco_compressed(primitives[p])) continue;
      const std::string where =
          "meshes[" + std::to_string(m) + "].primitives[" + std::to_string(p) + "].indices";
      const json& index = primitives[p]["indices"];
      if (!index.is_number()) return Error{where + " is not an index"};
      const auto accessor = index.get<size_t>();
      if (accessor >= accessors.size()) {
        return Error{where + " refers to accessors[" + std::to_string(accessor) + "], but there are " +
                     std::to_string(accessors.size())};
      }
    }
  }
  return {};
}

}  // namespace

bool extension_supported(const std::string& name) {
  static constexpr std::array<std::string_view, 24> supported{
      "KHR_lights_punctual",     "KHR_materials_unlit",        "KHR_materials_emissive_strength",
      "KHR_materials_ior",       "KHR_materials_specular",     "KHR_materials_clearcoat",
      "KHR_materials_sheen",     "KHR_materials_transmission", "KHR_texture_transform",
      "KHR_mesh_quantization",   "EXT_mesh_gpu_instancing",    "EXT_meshopt_compression",
      "EXT_texture_webp",        "KHR_texture_basisu",         "KHR_draco_mesh_compression",
      "KHR_meshopt_compression", "KHR_node_visibility",        "KHR_materials_pbrSpecularGlossiness",
      "KHR_materials_variants",  "KHR_materials_anisotropy",   "KHR_materials_iridescence",
      "KHR_materials_volume",    "KHR_materials_dispersion",   "KHR_materials_diffuse_transmission"};
  return std::find(supported.begin(), supported.end(), name) != supported.end();
}

Result<void> check_and_reduce(json& document, std::vector<std::string>& warnings) {
  if (!document.is_object()) return Error{"the JSON is not an object"};
  if (auto done = check_version(document); !done) return done;
  if (auto done = check_extensions(document, warnings); !done) return done;

  json reduced = json::object();
  reduced["asset"]["version"] = "2.0";
  if (const auto scene = document.find("scene"); scene != document.end()) {
    if (!is_index(*scene)) return Error{"scene is not an index"};
    reduced["scene"] = *scene;
  }
  for (const std::string_view name : kRootArrays) {
    const auto array = document.find(name);
    if (array == document.end()) continue;
    if (!fits(*array, kObjects)) return Error{std::string(name) + " is not an array of objects"};
    for (size_t i = 0; i < array->size(); ++i) {
      auto done = reduce((*array)[i], std::string(name) + "[" + std::to_string(i) + "]");
      if (!done) return done;
    }
    reduced[std::string(name)] = std::move(*array);
  }
  if (const auto extensions = document.find("extensions"); extensions != document.end()) {
    if (!extensions->is_object()) return Error{"extensions is not an object"};
    if (auto done = reduce_extensions(*extensions, "extensions"); !done) return done;
    reduced["extensions"] = std::move(*extensions);
  }
  document = std::move(reduced);
  replace_unknown_types(document, warnings);
  return check_index_accessors(document);
}

}  // namespace fire3dv::scene
