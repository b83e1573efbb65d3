#include "renderer/dataset/randomize/scene_additions.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "base/files.h"
#include "base/text.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/textures/images.h"

namespace fire3dv::dataset {
namespace {

constexpr uint64_t kMaxImageBytes = uint64_t{1} << 30;    // of a file
constexpr uint64_t kMaxTextureBytes = uint64_t{4} << 30;  // of all, decoded

constexpr const char* kTextureName = "texture of a randomisation: ";
constexpr const char* kDistractorName = "distractor ";

std::string distractor_name(const std::string& file, uint32_t copy) {
  return kDistractorName + file + " " + std::to_string(copy);
}

// The field that counts for a material: the last pattern that matches it.
const Field* find_field(const Plan& plan, const std::string& material, const char* name) {
  const Field* found = nullptr;
  for (const Entry& entry : plan.of(Section::materials)) {
    if (!matches(entry.pattern, material)) continue;
    if (const Field* const field = entry.find(name)) found = field;
  }
  return found;
}

// True if a vertex of the material's meshes has texture coordinates other than the first one's.
bool has_coordinates(const scene::Scene& scene, uint32_t material) {
  for (const scene::Primitive& primitive : scene.primitives) {
    if (primitive.material != material || scene.uvs.empty() || primitive.vertex_count == 0) continue;
    const auto first = scene.uvs.begin() + primitive.first_vertex;
    if (std::any_of(first, first + primitive.vertex_count, [&](const auto& uv) { return uv != *first; }))
      return true;
  }
  return false;
}

class Textures {
 public:
  Textures(const Plan& plan, scene::Scene& scene) : plan_(plan), scene_(scene) {}

  // Lets the material choose from the field's files. Its first one makes it a material with such a texture.
  Result<void> add(uint32_t material, const char* name, const Field& field) {
    const std::string at = plan_.file + ":" + std::to_string(field.line) + ": materials." +
                           printable_text(material_name(scene_, material), 300) + "." + name + ": ";
    scene::Material& of = scene_.materials[material];
    const bool is_color = std::string_view(name) == "base_color_texture";
    const bool is_normal = std::string_view(name) == "normal_texture";
    scene::TextureRef& texture = is_color    ? of.base_color_texture
                                 : is_normal ? of.normal_texture
                                             : of.metallic_roughness_texture;
    if (is_normal && texture.texture == scene::kNone)
      return Error{at +
                   "the material has no normal map, so that its meshes have no tangents: give it one in "
                   "the file of the scene"};
    if (!has_coordinates(scene_, material))
      return Error{at + "its meshes have no texture coordinates: add them to the file of the scene"};
    for (const std::string& file : field.words) {
      if (auto good = add_file(file, is_color); !good) return Error{at + good.error().message};
    }
    if (texture.texture == scene::kNone)
      texture.texture = find_texture(scene_, field.words.front(), is_color);
    return {};
  }

 private:
  Result<void> add_file(const std::string& file, bool is_color) {
    if (!added_.emplace(file, is_color).second) return {};
    auto image = images_.find(file);
    if (image == images_.end()) {
      const std::filesystem::path path = plan_.textures.at(file).path;
      auto bytes = read_whole_file(path, kMaxImageBytes);
      if (!bytes) return bytes.error();
      scene::EncodedImage encoded;
      encoded.name = kTextureName + file;
      encoded.where = quote(file);
      encoded.bytes = std::as_bytes(std::span(*bytes));
      encoded.is_color = is_color;
      encoded.is_data = !is_color;
      scene::ImageLimits limits;
      limits.max_pixels = uint64_t{16384} * 16384;
      limits.reserve = [this](uint64_t wanted) -> Result<void> {
        decoded_bytes_ += wanted;
        if (decoded_bytes_ > kMaxTextureBytes)
          return Error{"the textures take more than " + std::to_string(kMaxTextureBytes >> 30) +
                       " GiB: choose fewer or smaller ones"};
        return {};
      };
      auto decoded = scene::decode_images(std::span(&encoded, 1), limits, [](size_t) {});
      if (!decoded) return decoded.error();
      if (decoded->is_placeholder.at(0))
        return Error{decoded->warnings.empty() ? quote(file) + " cannot be decoded"
                                               : decoded->warnings.front()};
      image = images_.emplace(file, static_cast<uint32_t>(scene_.images.size())).first;
      scene_.images.push_back(std::move(decoded->images.at(0)));
    }
    scene::Texture texture;
    texture.image = image->second;
    texture.srgb = is_color;
    scene_.textures.push_back(texture);
    return {};
  }

  const Plan& plan_;
  scene::Scene& scene_;
  std::set<std::pair<std::string, bool>> added_;
  std::map<std::string, uint32_t> images_;  // by file
  uint64_t decoded_bytes_ = 0;
};

Result<void> add_textures(const Plan& plan, scene::Scene& scene) {
  Textures textures(plan, scene);
  for (uint32_t material = 0; material < scene.materials.size(); ++material) {
    for (const char* name : kTextureFields) {
      const Field* const field = find_field(plan, material_name(scene, material), name);
      if (!field) continue;
      if (auto good = textures.add(material, name, *field); !good) return good;
    }
  }
  return {};
}

Result<void> add_distractors(const Plan& plan, const Entry& entry, scene::LoadedScene& to) {
  const Field& files = *entry.find("files");
  const std::string at = plan.file + ":" + std::to_string(files.line) + ": distractors.files: ";
  const uint32_t copies = copies_of(entry);
  if (files.words.size() * copies > kMaxDistractors)
    return Error{at + "more than " + std::to_string(kMaxDistractors) +
                 " distractors: choose fewer files or copies"};
  for (const std::string& file : files.words) {
    auto loaded = scene::load_gltf(plan.distractors.at(file).path);
    if (!loaded) return Error{at + loaded.error().message};
    scene::LoadedScene asset{std::move(*loaded), {}};
    for (scene::Node& node : asset.scene.nodes) node.light = node.camera = scene::kNone;
    asset.derived = scene::derive(asset.scene);
    for (uint32_t copy = 1; copy <= copies; ++copy) {
      const uint32_t root =
          scene::add_node(to.scene, distractor_name(file, copy), scene::kNone, glm::mat4(1));
      if (auto good = scene::add_below(to, asset, root); !good)
        return Error{at + quote(file) + ": " + good.error().message};
    }
  }
  return {};
}

}  // namespace

std::string material_name(const scene::Scene& scene, size_t material) {
  const std::string& name = scene.materials[material].name;
  return name.empty() ? "#" + std::to_string(material) : name;
}

Result<std::unique_ptr<const scene::LoadedScene>> add_to_scene(const Plan& plan,
                                                               const scene::LoadedScene& loaded) {
  const Entry* const distractors = plan.distractor_entry();
  std::unique_ptr<scene::LoadedScene> result;
  if (plan.textures.empty() && !distractors) return std::unique_ptr<const scene::LoadedScene>();
  result = std::make_unique<scene::LoadedScene>(loaded);
  if (auto good = add_textures(plan, result->scene); !good) return good.error();
  if (distractors) {
    if (auto good = add_distractors(plan, *distractors, *result); !good) return good.error();
  }
  return std::unique_ptr<const scene::LoadedScene>(std::move(result));
}

uint32_t find_texture(const scene::Scene& scene, const std::string& file, bool is_color) {
  const std::string name = kTextureName + file;
  for (size_t i = 0; i < scene.textures.size(); ++i) {
    const scene::Texture& texture = scene.textures[i];
    if (texture.srgb == is_color && scene.images[texture.image].name == name) return static_cast<uint32_t>(i);
  }
  return scene::kNone;
}

uint32_t find_distractor(const scene::Scene& scene, const std::string& file, uint32_t copy) {
  const std::string name = distractor_name(file, copy);
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].parent == scene::kNone && scene.nodes[i].name == name) return static_cast<uint32_t>(i);
  }
  return scene::kNone;
}

uint32_t copies_of(const Entry& distractors) {
  const Field* const copies = distractors.find("copies");
  return copies ? static_cast<uint32_t>(copies->number.low) : 1;
}

std::set<uint32_t> distractor_nodes(const Plan& plan, const scene::Scene& scene) {
  std::set<uint32_t> nodes;
  const Entry* const entry = plan.distractor_entry();
  if (!entry) return nodes;
  for (const std::string& file : entry->find("files")->words) {
    for (uint32_t copy = 1; copy <= copies_of(*entry); ++copy)
      nodes.insert(find_distractor(scene, file, copy));
  }
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].parent != scene::kNone && nodes.contains(scene.nodes[n].parent)) nodes.insert(n);
  }
  return nodes;
}

}  // namespace fire3dv::dataset
