#include "programs/drake/request/gltf_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <span>
#include <utility>

#include "base/glb.h"
#include "base/numbers.h"
#include "base/text.h"
#include "programs/drake/request/sha256.h"

namespace fire3dv::drake {
namespace {

using Json = nlohmann::json;

constexpr int kMaxDepth = 64;
constexpr size_t kMaxValues = 4'000'000;  // of the JSON document; transforms of 250,000 nodes

// Columns: the renderer's world axes of Drake's X, Y and Z.
const glm::dmat4 kWorldFromDrake{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}};

std::string at(const char* array, size_t index) {
  return std::string(array) + "[" + std::to_string(index) + "]";
}

// Text without the contents of data: URIs, which are most of it. A JSON parser is ten times slower than a
// search for their ends. Each URI's string becomes "@" and its index. A string that starts here starts in the
// whole text, too, since neither has escapes.
struct ShortText {
  std::string text;
  std::vector<std::string_view> data_uris;
};
ShortText shorten(std::string_view text) {
  constexpr std::string_view kStart = "\"data:";
  ShortText result;
  size_t done = 0;
  for (size_t found = text.find(kStart); found != std::string_view::npos; found = text.find(kStart, found)) {
    const size_t end = text.find('"', found + 1);
    if (end == std::string_view::npos) break;
    const std::string_view uri = text.substr(found + 1, end - found - 1);
    const bool is_escaped = found > 0 && text[found - 1] == '\\';
    if (!is_escaped && uri.find('\\') == std::string_view::npos) {
      result.text.append(text.substr(done, found - done));
      result.text.append("\"@" + std::to_string(result.data_uris.size()) + "\"");
      result.data_uris.push_back(uri);
      found = done = end + 1;
    } else {
      found = end;  // may begin the next string
    }
  }
  result.text.append(text.substr(done));
  return result;
}

// The data: URI that a string of the short text stands for; nullopt: it is another URI.
std::optional<std::string_view> data_uri_of(std::string_view uri,
                                            const std::vector<std::string_view>& data_uris) {
  if (uri.starts_with("data:")) return uri;
  const auto index = uri.starts_with('@') ? parse_number<size_t>(uri.substr(1)) : std::nullopt;
  if (!index || *index >= data_uris.size()) return std::nullopt;
  return data_uris[*index];
}

// Counts the values of a document and their nesting, before memory is spent on them. A callback of the parser
// would take quadratic time: for each element that ends it searches all of its array.
class ValueCounter final : public nlohmann::json_sax<Json> {
 public:
  const std::string& error() const { return error_; }

  bool null() override { return add(); }
  bool boolean(bool) override { return add(); }
  bool number_integer(number_integer_t) override { return add(); }
  bool number_unsigned(number_unsigned_t) override { return add(); }
  bool number_float(number_float_t, const string_t&) override { return add(); }
  bool string(string_t&) override { return add(); }
  bool binary(binary_t&) override { return add(); }
  bool key(string_t&) override { return add(); }
  bool start_object(std::size_t) override { return open(); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& fault) override {
    error_ = fault.what();
    return false;
  }

 private:
  bool add() {
    if (++values_ <= kMaxValues) return true;
    error_ = "it has more than " + std::to_string(kMaxValues) + " values";
    return false;
  }
  bool open() {
    if (++depth_ <= kMaxDepth) return add();
    error_ = "it nests deeper than " + std::to_string(kMaxDepth);
    return false;
  }
  bool close() {
    --depth_;
    return add();
  }

  size_t values_ = 0;
  int depth_ = 0;
  std::string error_;
};

Result<Json> parse(std::string_view text) {
  const auto refuse = [](const std::string& why) {
    return Error{"the scene is not glTF in JSON: " + printable_text(why, 300)};
  };
  try {
    ValueCounter counter;
    if (!Json::sax_parse(text, &counter)) return refuse(counter.error());
    return Json::parse(text);
  } catch (const std::exception& error) {
    return refuse(error.what());
  }
}

// Array of objects under a name; null if it is missing or of another type.
Json* objects(Json& in, const char* name) {
  const auto found = in.find(name);
  if (found == in.end() || !found->is_array()) return nullptr;
  return std::ranges::all_of(*found, &Json::is_object) ? &*found : nullptr;
}

std::optional<size_t> index_in(const Json& object, const char* name, size_t size) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number_unsigned()) return std::nullopt;
  const auto index = found->get<uint64_t>();
  return index < size ? std::optional<size_t>(index) : std::nullopt;
}

// Reads exactly `to.size()` finite numbers; leaves `to` if the member is missing.
bool read_numbers(const Json& object, const char* name, std::span<double> to) {
  const auto found = object.find(name);
  if (found == object.end()) return true;
  if (!found->is_array() || found->size() != to.size()) return false;
  for (size_t i = 0; i < to.size(); ++i) {
    const Json& number = (*found)[i];
    if (!number.is_number()) return false;
    to[i] = number.get<double>();
    if (!std::isfinite(to[i]) || std::abs(to[i]) > 1e30) return false;
  }
  return true;
}

// Drake sets `matrix` of merged files' root nodes and may leave parts beside it: the matrix counts.
Result<glm::dmat4> local_transform(const Json& node, const std::string& name) {
  std::array<double, 16> matrix{};
  std::array<double, 3> translation{0, 0, 0}, scale{1, 1, 1};
  std::array<double, 4> rotation{0, 0, 0, 1};
  if (!read_numbers(node, "matrix", matrix) || !read_numbers(node, "translation", translation) ||
      !read_numbers(node, "scale", scale) || !read_numbers(node, "rotation", rotation))
    return Error{"the scene's " + name + " has a transform that is not made of finite numbers"};
  if (node.contains("matrix")) {
    glm::dmat4 result;
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) result[c][r] = matrix[static_cast<size_t>(c * 4 + r)];
    return result;
  }
  const glm::dquat turn(rotation[3], rotation[0], rotation[1], rotation[2]);
  const double length = glm::length(turn);
  if (!(length > 0)) return Error{"the scene's " + name + " has a rotation of length 0"};
  return glm::scale(glm::translate(glm::dmat4(1), {translation[0], translation[1], translation[2]}) *
                        glm::mat4_cast(turn / length),
                    {scale[0], scale[1], scale[2]});
}

// Parent of each node; its own index where it has none.
Result<std::vector<size_t>> parents_of(const Json& nodes) {
  std::vector<size_t> parents(nodes.size());
  for (size_t n = 0; n < parents.size(); ++n) parents[n] = n;
  for (size_t n = 0; n < nodes.size(); ++n) {
    const auto children = nodes[n].find("children");
    if (children == nodes[n].end()) continue;
    for (const Json& child : *children) {
      if (!child.is_number_unsigned() || child.get<uint64_t>() >= nodes.size())
        return Error{"the scene's " + at("nodes", n) + ".children refer to a node that does not exist"};
      parents[child.get<size_t>()] = n;
    }
  }
  return parents;
}

uint8_t label_byte(double factor) {
  return static_cast<uint8_t>(std::lround(std::clamp(factor, 0.0, 1.0) * 255));
}

}  // namespace

Result<GltfScene> GltfScene::read(std::string_view gltf, ImageType type) {
  const ShortText short_text = shorten(gltf);
  Result<Json> document = parse(short_text.text);
  if (!document) return document.error();
  if (!document->is_object()) return Error{"the scene is not a glTF object"};
  GltfScene scene;
  scene.bytes_ = gltf.size();
  scene.document_ = std::move(*document);
  if (!objects(scene.document_, "nodes")) return Error{"the scene has no array \"nodes\" of objects"};
  if (auto read = scene.read_transforms(); !read) return read.error();
  if (auto found = scene.find_camera(); !found) return found.error();
  if (type == ImageType::label) {
    if (auto read = scene.read_labels(); !read) return read.error();
  }
  scene.simplify_materials(type);
  if (auto read = scene.read_uris(short_text.data_uris); !read) return read.error();
  for (const char* unused : {"cameras", "animations", "asset", "extras"}) scene.document_.erase(unused);
  const std::string text = scene.document_.dump();
  scene.content_ = sha256_of(text);
  return scene;
}

Result<void> GltfScene::read_transforms() {
  Json& nodes = *objects(document_, "nodes");
  const Result<std::vector<size_t>> parents = parents_of(nodes);
  if (!parents) return parents.error();
  for (size_t n = 0; n < nodes.size(); ++n) {
    Result<glm::dmat4> local = local_transform(nodes[n], at("nodes", n));
    if (!local) return local.error();
    const bool is_root = (*parents)[n] == n;
    parent_from_node_.push_back(is_root ? kWorldFromDrake * *local : *local);
    for (const char* part : {"matrix", "translation", "rotation", "scale", "extras"}) nodes[n].erase(part);
  }
  return {};
}

// The camera is VTK's "Camera Node"; in other files, the only node with a camera.
Result<void> GltfScene::find_camera() {
  Json& nodes = *objects(document_, "nodes");
  const Result<std::vector<size_t>> parents = parents_of(nodes);
  if (!parents) return parents.error();
  std::vector<size_t> cameras;
  std::optional<size_t> vtk_camera;
  for (size_t n = 0; n < nodes.size(); ++n) {
    if (!nodes[n].contains("camera")) continue;
    cameras.push_back(n);
    const auto name = nodes[n].find("name");
    if (name != nodes[n].end() && *name == "Camera Node") vtk_camera = n;
    nodes[n].erase("camera");
  }
  if (!vtk_camera && cameras.size() != 1)
    return Error{"the scene has " + std::to_string(cameras.size()) +
                 " nodes with a camera: it must have one, or one named \"Camera Node\""};
  size_t node = vtk_camera.value_or(cameras.empty() ? 0 : cameras.front());
  glm::dmat4 world_from_camera = parent_from_node_[node];
  for (size_t steps = 0; (*parents)[node] != node; ++steps) {
    if (steps > nodes.size()) return Error{"the scene's " + at("nodes", node) + " is its own ancestor"};
    node = (*parents)[node];
    world_from_camera = parent_from_node_[node] * world_from_camera;
  }
  // A camera has a rotation and a translation, no scale.
  for (int axis = 0; axis < 3; ++axis) {
    const double length = glm::length(world_from_camera[axis]);
    if (!(length > 1e-12) || !std::isfinite(length))
      return Error{"the scene's camera node has a transform that flattens its axes"};
    world_from_camera[axis] /= length;
  }
  world_from_camera_ = world_from_camera;
  for (size_t n = 0; n < nodes.size(); ++n) nodes[n]["name"] = std::to_string(n);
  return {};
}

// Drake gives all surfaces of a geometry one colour, so that a node has one label.
Result<void> GltfScene::read_labels() {
  Json& nodes = *objects(document_, "nodes");
  Json* const meshes = objects(document_, "meshes");
  Json* const materials = objects(document_, "materials");
  label_of_node_.assign(nodes.size(), Rgb8{255, 255, 255});
  // Many nodes may have one mesh of many surfaces.
  std::vector<std::optional<Rgb8>> label_of_mesh(meshes ? meshes->size() : 0);
  for (size_t n = 0; n < nodes.size(); ++n) {
    const auto mesh = meshes ? index_in(nodes[n], "mesh", meshes->size()) : std::nullopt;
    if (!mesh) continue;
    if (label_of_mesh[*mesh]) {
      label_of_node_[n] = *label_of_mesh[*mesh];
      continue;
    }
    Json* const primitives = objects((*meshes)[*mesh], "primitives");
    std::optional<Rgb8> label;
    for (size_t p = 0; primitives && p < primitives->size(); ++p) {
      std::array<double, 4> color{1, 1, 1, 1};
      const auto material =
          materials ? index_in((*primitives)[p], "material", materials->size()) : std::nullopt;
      if (material) {
        const auto pbr = (*materials)[*material].find("pbrMetallicRoughness");
        if (pbr != (*materials)[*material].end() && pbr->is_object() &&
            !read_numbers(*pbr, "baseColorFactor", color))
          return Error{"the scene's " + at("materials", *material) + " has no baseColorFactor of 4 numbers"};
      }
      const Rgb8 found{label_byte(color[0]), label_byte(color[1]), label_byte(color[2])};
      if (label && *label != found)
        return Error{"the scene's " + at("meshes", *mesh) +
                     " has surfaces of several labels: give each label a node of its own"};
      label = found;
    }
    if (label) label_of_node_[n] = *label;
    label_of_mesh[*mesh] = label_of_node_[n];
  }
  return {};
}

void GltfScene::simplify_materials(ImageType type) {
  Json* materials = objects(document_, "materials");
  const bool needs_colors = type == ImageType::color;
  if (!needs_colors) {
    for (const char* unused : {"materials", "textures", "images", "samplers"}) document_.erase(unused);
    if (const auto extensions = document_.find("extensions");
        extensions != document_.end() && extensions->is_object())
      extensions->erase("KHR_materials_variants");
    materials = nullptr;
  }
  if (!materials) materials = &(document_["materials"] = Json::array());
  for (Json& material : *materials) material["doubleSided"] = true;
  const size_t plain = materials->size();
  bool is_plain_used = false;
  if (Json* const meshes = objects(document_, "meshes")) {
    for (Json& mesh : *meshes) {
      Json* const primitives = objects(mesh, "primitives");
      if (!primitives) continue;
      for (Json& primitive : *primitives) {
        if (needs_colors && primitive.contains("material")) continue;
        primitive["material"] = plain;
        is_plain_used = true;
        const auto extensions = primitive.find("extensions");
        if (extensions != primitive.end() && extensions->is_object())
          extensions->erase("KHR_materials_variants");
      }
    }
  }
  if (is_plain_used) materials->push_back({{"doubleSided", true}});
  if (materials->empty()) document_.erase("materials");
}

// Replaces each URI by its digest, so that the rest of the document is small.
Result<void> GltfScene::read_uris(const std::vector<std::string_view>& data_uris) {
  for (const char* const array : {"buffers", "images"}) {
    Json* const entries = objects(document_, array);
    for (size_t i = 0; entries && i < entries->size(); ++i) {
      const auto uri = (*entries)[i].find("uri");
      if (uri == (*entries)[i].end()) continue;
      std::optional<std::string_view> data;
      if (uri->is_string()) data = data_uri_of(uri->get_ref<const std::string&>(), data_uris);
      if (!data)
        return Error{"the scene's " + at(array, i) +
                     " names a file: a render request must hold all data, as data: URIs"};
      uris_.emplace_back(*data);
      *uri = hex(sha256_of(*data));
    }
  }
  return {};
}

std::vector<std::byte> GltfScene::take_glb() {
  size_t next = 0;
  for (const char* const array : {"buffers", "images"}) {
    Json* const entries = objects(document_, array);
    for (size_t i = 0; entries && i < entries->size(); ++i) {
      if ((*entries)[i].contains("uri")) (*entries)[i]["uri"] = std::move(uris_[next++]);
    }
  }
  document_["asset"] = {{"version", "2.0"}};
  Json& nodes = *objects(document_, "nodes");
  for (size_t n = 0; n < nodes.size(); ++n) {
    Json& matrix = nodes[n]["matrix"] = Json::array();
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) matrix.push_back(parent_from_node_[n][c][r]);
  }
  // The contents of URIs were not parsed, and may be no UTF-8.
  const std::string text = document_.dump(-1, ' ', false, Json::error_handler_t::replace);
  document_.clear();
  return base::make_glb(text, {});
}

}  // namespace fire3dv::drake
