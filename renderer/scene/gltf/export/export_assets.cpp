// Nodes of an exported file that are of other glTF files. Data (buffers, accessors, images, textures) of such
// a file are written once; materials, meshes, skins, lights, cameras and nodes once for each addition, since
// they have edits of their own.

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iterator>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/json/json_fault.h"
#include "renderer/scene/gltf/export/export_parts.h"
#include "renderer/scene/gltf/gltf_document.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

constexpr uint64_t kMaxAssetBytes = uint64_t{1} << 30;  // as for the displayed scene
constexpr const char* kLights = "KHR_lights_punctual";
constexpr const char* kVariants = "KHR_materials_variants";
constexpr const char* kSharedArrays[]{"bufferViews", "accessors", "images", "samplers", "textures"};
constexpr const char* kOwnArrays[]{"materials", "meshes", "skins", "cameras", "lights", "nodes"};

json& array_of(json& root, const char* name) {
  json& array = std::string_view(name) == "lights" ? root["extensions"][kLights]["lights"] : root[name];
  if (!array.is_array()) array = json::array();
  return array;
}

size_t size_of(const json& root, const char* name) {
  const json::json_pointer pointer(std::string_view(name) == "lights"
                                       ? std::string("/extensions/") + kLights + "/lights"
                                       : "/" + std::string(name));
  return root.contains(pointer) ? root.at(pointer).size() : 0;
}

void append_array(json& root, const char* name, const json& values) {
  if (values.empty()) return;
  json& array = array_of(root, name);
  array.insert(array.end(), values.begin(), values.end());
}

json* member_of(json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

json* extension_of(json& object, const char* name) {
  json* const extensions = member_of(object, "extensions");
  return extensions ? member_of(*extensions, name) : nullptr;
}

// Numbers of one file's objects in another file. Throws at a number that the file lacks.
class IndexShift {
 public:
  // Objects of `from` that follow those of `to`.
  template <size_t count>
  IndexShift(const char* const (&arrays)[count], const json& from, const json& to) {
    for (const char* const array : arrays) ranges_[array] = {size_of(from, array), size_of(to, array)};
  }
  size_t first(const char* array) const { return ranges_.at(array).first; }

  void index(json& number, const char* array) const {
    const Range& range = ranges_.at(array);
    const auto given = number.get<size_t>();
    if (given >= range.count) throw std::runtime_error(element(array, given) + " is not in the file");
    number = given + range.first;
  }
  void member(json& object, const char* name, const char* array) const {
    if (json* const number = member_of(object, name)) index(*number, array);
  }
  void all(json& object, const char* name, const char* array) const {
    json* const numbers = member_of(object, name);
    if (!numbers) return;
    for (json& number : *numbers) index(number, array);
  }

 private:
  struct Range {
    size_t count = 0, first = 0;
  };
  std::map<std::string, Range> ranges_;
};

// Extensions that the loader ignores may refer to objects by numbers. Added files have no variants.
void remove_extensions(json& value) {
  if (value.is_object()) {
    if (json* const extensions = member_of(value, "extensions"); extensions && extensions->is_object()) {
      for (auto each = extensions->begin(); each != extensions->end();)
        each = extension_supported(each.key()) && each.key() != kVariants ? std::next(each)
                                                                          : extensions->erase(each);
      if (extensions->empty()) value.erase("extensions");
    }
    for (auto each = value.begin(); each != value.end(); ++each)
      if (each.key() != "extras") remove_extensions(*each);
  } else if (value.is_array()) {
    for (json& each : value) remove_extensions(each);
  }
}

std::vector<std::string> supported(const json& root, const char* list) {
  std::vector<std::string> names;
  for (const json& name : root.value(list, json::array())) {
    std::string text = name.get<std::string>();
    if (extension_supported(text) && text != kVariants) names.push_back(std::move(text));
  }
  return names;
}

// Below a material, in its extensions, too.
void shift_textures(json& object, const IndexShift& shift) {
  if (!object.is_object()) return;
  for (auto each = object.begin(); each != object.end(); ++each) {
    if (each.key() == "extras" || !each->is_object()) continue;
    if (each.key().ends_with("Texture")) shift.member(*each, "index", "textures");
    shift_textures(*each, shift);
  }
}

// Buffer 0 has the bytes of the file, from this offset on; the others are placeholders.
void shift_buffer(json& view, size_t first_buffer, uint64_t offset) {
  json& buffer = view.at("buffer");
  if (const auto number = buffer.get<size_t>(); number != 0) {
    buffer = number - 1 + first_buffer;
  } else if (const uint64_t moved = view.value("byteOffset", uint64_t{0}) + offset; moved != 0) {
    view["byteOffset"] = moved;
  }
}

void shift_views(json& root, size_t first_buffer, uint64_t offset) {
  for (json& view : array_of(root, "bufferViews")) {
    shift_buffer(view, first_buffer, offset);
    for (const char* const name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
      if (json* const compressed = extension_of(view, name)) shift_buffer(*compressed, first_buffer, offset);
    }
  }
}

void shift_primitive(json& primitive, const IndexShift& shift) {
  shift.all(primitive, "attributes", "accessors");
  shift.member(primitive, "indices", "accessors");
  if (json* const targets = member_of(primitive, "targets")) {
    for (json& target : *targets) {
      for (json& accessor : target) shift.index(accessor, "accessors");
    }
  }
  if (json* const draco = extension_of(primitive, "KHR_draco_mesh_compression"))
    shift.member(*draco, "bufferView", "bufferViews");  // its attributes are ids of the compressed data
}

// References to the arrays that all additions of the file share.
void shift_shared(json& root, const IndexShift& shift) {
  for (json& accessor : array_of(root, "accessors")) {
    shift.member(accessor, "bufferView", "bufferViews");
    json* const sparse = member_of(accessor, "sparse");
    if (!sparse) continue;
    for (const char* const part : {"indices", "values"})
      if (json* const view = member_of(*sparse, part)) shift.member(*view, "bufferView", "bufferViews");
  }
  for (json& image : array_of(root, "images")) {
    shift.member(image, "bufferView", "bufferViews");
    image.erase("uri");  // could name another file in the folder of the exported one
  }
  for (json& texture : array_of(root, "textures")) {
    shift.member(texture, "source", "images");
    shift.member(texture, "sampler", "samplers");
    for (const char* const name : {"KHR_texture_basisu", "EXT_texture_webp"})
      if (json* const extension = extension_of(texture, name)) shift.member(*extension, "source", "images");
  }
  for (json& material : array_of(root, "materials")) shift_textures(material, shift);
  for (json& mesh : array_of(root, "meshes")) {
    for (json& primitive : array_of(mesh, "primitives")) shift_primitive(primitive, shift);
  }
  for (json& skin : array_of(root, "skins")) shift.member(skin, "inverseBindMatrices", "accessors");
  for (json& node : array_of(root, "nodes")) {
    if (json* const instancing = extension_of(node, "EXT_mesh_gpu_instancing"))
      shift.all(*instancing, "attributes", "accessors");
  }
}

// References to the arrays that each addition has of its own.
void shift_own(json& root, const IndexShift& shift) {
  for (json& mesh : array_of(root, "meshes")) {
    for (json& primitive : array_of(mesh, "primitives")) shift.member(primitive, "material", "materials");
  }
  for (json& skin : array_of(root, "skins")) {
    shift.all(skin, "joints", "nodes");
    shift.member(skin, "skeleton", "nodes");
  }
  for (json& node : array_of(root, "nodes")) {
    shift.all(node, "children", "nodes");
    shift.member(node, "mesh", "meshes");
    shift.member(node, "skin", "skins");
    shift.member(node, "camera", "cameras");
    if (json* const light = extension_of(node, kLights)) shift.member(*light, "light", "lights");
  }
}

// Nodes that are not displayed stay for the skins that name them, but are no parents of displayed ones.
// Joints of a robot are those of the scene's file.
void prepare_nodes(json& nodes, const std::vector<uint32_t>& displayed) {
  std::vector<bool> is_displayed(nodes.size(), false);
  for (const uint32_t node : displayed)
    if (node != kNone) is_displayed.at(node) = true;
  for (size_t i = 0; i < nodes.size(); ++i) {
    json& node = nodes[i];
    if (!is_displayed[i]) node.erase("children");
    if (json* const extras = member_of(node, "extras"); extras && extras->is_object())
      extras->erase("fire3dv");
  }
}

}  // namespace

// Reads the file and appends its data; later additions of the file share them.
Result<const GlbExport::AddedFile*> GlbExport::add_file(const ExportedAsset& asset) {
  const std::filesystem::path& path = asset.file;
  if (const auto known = added_files_.find(path); known != added_files_.end()) return &known->second;
  LoadLimits limits = limits_;
  limits.max_file_bytes = std::min(limits.max_file_bytes, kMaxAssetBytes);
  // Checks types, references and sizes, which the steps below rely on.
  if (const Result<GltfDocument> checked = open_gltf(path, limits, nullptr); !checked) return checked.error();
  const Result<GltfContainer> container = open_container(path, limits);
  if (!container) return container.error();
  constexpr const char* kChanged = "it has changed since it was loaded";
  if (asset.digest != Digest{} && digest_of(container->file.view()) != asset.digest) return Error{kChanged};
  GlbExport read(Json::parse(container->json), *container, AssetFolder(path), limits);
  if (Result<void> done = read.embed_buffers(); !done) return done.error();
  if (Result<void> done = read.embed_images(); !done) return done.error();
  if (size_of(read.root_, "animations") != 0)
    read.warnings_.push_back("its animations are left out: an added file does not play them");
  if (read.root_.contains(Json::json_pointer(std::string("/extensions/") + kVariants)))
    read.warnings_.push_back("its material variants are left out: an added file shows its default materials");
  remove_extensions(read.root_);
  read.map_nodes();

  AddedFile file;
  file.nodes = std::move(read.source_of_node_);
  file.roots = std::move(read.roots_);
  if (file.nodes.size() != asset.node_count || size_of(read.root_, "materials") + 1 != asset.material_count)
    return Error{kChanged};
  const std::vector<std::string> used = supported(read.root_, "extensionsUsed");
  const std::vector<std::string> required = supported(read.root_, "extensionsRequired");

  // Everything that may throw because of the file comes before the first change of root_.
  const size_t first_buffer = std::max<size_t>(size_of(root_, "buffers"), 1);
  const Json buffers = read.root_.value("buffers", Json::array());
  const IndexShift shift(kSharedArrays, read.root_, root_);
  shift_shared(read.root_, shift);
  prepare_nodes(array_of(read.root_, "nodes"), file.nodes);
  for (const char* const array : kOwnArrays) array_of(file.own, array) = array_of(read.root_, array);
  Json trial = file.own;
  shift_own(trial, IndexShift(kOwnArrays, trial, root_));
  const Result<uint64_t> offset = append(read.binary_);
  if (!offset) return offset.error();
  shift_views(read.root_, first_buffer, *offset);

  if (!buffers.empty() && size_of(root_, "buffers") == 0) root_["buffers"] = Json::array({Json::object()});
  for (size_t i = 1; i < buffers.size(); ++i) root_["buffers"].push_back(buffers[i]);
  for (const char* const array : kSharedArrays) append_array(root_, array, array_of(read.root_, array));
  for (const std::string& name : used) use_extension(name.c_str());
  for (const std::string& name : required) use_extension(name.c_str(), "extensionsRequired");
  for (const std::string& note : read.warnings_) warnings_.push_back(path.string() + ": " + note);
  return &added_files_.emplace(path, std::move(file)).first->second;
}

// Without scenes all nodes without parents are displayed, also those that an added file does not display.
void GlbExport::name_roots() {
  if (const auto scenes = root_.find("scenes"); scenes != root_.end() && !scenes->empty()) return;
  Json scene = Json::object();
  if (!roots_.empty()) scene["nodes"] = roots_;
  for (const uint32_t root : added_roots_) scene["nodes"].push_back(root);
  root_["scenes"] = Json::array({std::move(scene)});
  root_["scene"] = 0;
}

Result<void> GlbExport::add_displayed_asset(const ExportedNode& node, const NodeNumbers& names) {
  const ExportedAsset& asset = *node.asset;
  if (asset.file.empty()) return Error{"its file is not known"};
  const Result<const AddedFile*> added = add_file(asset);
  if (!added) return Error{asset.file.string() + ": " + added.error().message};
  const AddedFile& file = **added;
  Json own = file.own;
  for (Json& below : array_of(own, "nodes")) {
    std::string name = below.value("name", std::string());
    // Streams find the scene's own nodes by name, and nodes of added files by path.
    if (!name.empty() && names.contains(name)) below["name"] = name + " (" + node.name + ")";
  }
  name_roots();
  const std::optional<uint32_t> root = add_node(node);
  if (!root) return Error{"its parent is not of the scene's file"};
  const IndexShift shift(kOwnArrays, own, root_);
  shift_own(own, shift);
  MaterialRange range;
  range.first = asset.first_material;
  range.count = asset.material_count;
  range.first_in_file = shift.first("materials");
  range.first_mesh = shift.first("meshes");
  range.mesh_count = size_of(own, "meshes");
  material_ranges_.push_back(range);
  const auto first_node = static_cast<uint32_t>(shift.first("nodes"));
  for (const char* const array : kOwnArrays) append_array(root_, array, array_of(own, array));
  for (const uint32_t below : file.roots) root_["nodes"][*root]["children"].push_back(below + first_node);
  const size_t first = node.node + size_t{1};
  source_of_node_.resize(std::max(source_of_node_.size(), first + file.nodes.size()), kNone);
  for (size_t i = 0; i < file.nodes.size(); ++i) {
    source_of_node_[first + i] = file.nodes[i] == kNone ? kNone : file.nodes[i] + first_node;
    if (file.nodes[i] == kNone) mark_instance(first + i);
  }
  return {};
}

Result<void> GlbExport::add_asset(const ExportedNode& node, const NodeNumbers& names) {
  try {
    return add_displayed_asset(node, names);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {  // of the JSON, when the file has changed since it was loaded
    return Error{node.asset->file.string() + ": its JSON cannot be read: " + json_fault(error.what())};
  }
}

}  // namespace fire3dv::scene
