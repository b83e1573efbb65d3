#include "convert/sdf/sdf_materials.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <sstream>

#include "convert/description_files.h"
#include "convert/glb/write_glb.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

float unit(double value) {
  return std::isfinite(value) ? static_cast<float>(std::clamp(value, 0.0, 1.0)) : 0;
}

glm::vec3 color_of(const glm::vec3& given) {
  return {unit(given.r), unit(given.g), unit(given.b)};
}

bool is_plane(const SdfItem& visual) {
  return visual.shape && visual.shape->type == SdfShape::Type::plane;
}

// Materials of diffuse and specular are dielectrics, whose highlights have no colour, unless a black diffuse
// and a bright specular mean a metal of the latter's colour. Returns its share.
float metal_share(const SdfMaterial& from) {
  if (from.is_pbr || !from.script.empty()) return 0;
  const auto peak = [](const glm::vec3& color) { return std::max({color.r, color.g, color.b}); };
  const float diffuse = peak(color_of(glm::vec3(from.diffuse))), specular = peak(color_of(from.specular));
  constexpr float kDark = 0.25f, kBright = 0.75f;  // of the specular
  constexpr float kBlack = 0.05f;                  // of the diffuse, as a share of the specular
  if (specular <= kDark) return 0;
  const float bright = std::min((specular - kDark) / (kBright - kDark), 1.0f);
  return bright * std::max(1 - diffuse / (kBlack * specular), 0.0f);
}

// Text that is equal for equal materials.
std::string key_of(const SdfItem& visual) {
  std::ostringstream key;
  key.precision(9);
  key << visual.transparency << ' ' << is_plane(visual);
  if (!visual.material) return key.str();
  const SdfMaterial& m = *visual.material;
  key << ' ' << m.diffuse.r << ' ' << m.diffuse.g << ' ' << m.diffuse.b << ' ' << m.diffuse.a << ' '
      << m.specular.r << ' ' << m.specular.g << ' ' << m.specular.b << ' ' << m.emissive.r << ' '
      << m.emissive.g << ' ' << m.emissive.b << ' ' << m.is_pbr << m.is_double_sided << ' ' << m.metalness
      << ' ' << m.roughness << '\n'
      << m.script;
  for (const SdfUri* map :
       {&m.albedo_map, &m.normal_map, &m.metalness_map, &m.roughness_map, &m.occlusion_map, &m.emissive_map})
    key << '\n' << map->uri << '\n' << (map->uri.empty() ? "" : map->from.string());
  return key.str();
}

}  // namespace

size_t SdfMaterials::material(const SdfItem& visual) {
  const std::string key = key_of(visual);
  if (const auto known = materials_.find(key); known != materials_.end()) return known->second;
  Material to = made(visual);
  model_.materials.push_back(std::move(to));
  return materials_[key] = model_.materials.size() - 1;
}

Material SdfMaterials::made(const SdfItem& visual) {
  Material to;
  const float opacity = 1 - unit(visual.transparency);
  to.double_sided = !is_plane(visual) || (visual.material && visual.material->is_double_sided);
  if (!visual.material) {  // Gazebo's default
    to.name = "grey";
    to.base_color = {0.7f, 0.7f, 0.7f, opacity};
    to.roughness = 0.2f;
    to.metallic = 1;
    to.blended = opacity < 1;
    return to;
  }
  const SdfMaterial& from = *visual.material;
  glm::vec4 diffuse = from.diffuse;
  glm::vec3 emissive = from.emissive;
  if (!from.script.empty()) {
    to.name = printable_text(from.script, 200);
    if (const std::optional<SdfScriptColors> colors = sdf_script_colors(from.script)) {
      if (glm::vec3(diffuse) != glm::vec3(0) && glm::vec3(diffuse) != glm::vec3(colors->diffuse))
        warn("the material script " + quote(from.script) +
             " replaces the <diffuse> beside it, as in gz-sim; Gazebo Classic shows the <diffuse>: remove "
             "one of them");
      diffuse = colors->diffuse;
      emissive = colors->emissive;
    } else if (!from.is_pbr) {
      warn("the material script " + quote(from.script) +
           " is not read; its visuals are grey if they have no <diffuse>: write <pbr> or <diffuse>");
      if (glm::vec3(diffuse) == glm::vec3(0)) diffuse = glm::vec4(0.7f, 0.7f, 0.7f, diffuse.a);
    }
  }
  const float metal = metal_share(from);
  to.base_color = glm::vec4(glm::mix(color_of(glm::vec3(diffuse)), color_of(from.specular), metal),
                            unit(diffuse.a) * opacity);
  to.emission = color_of(emissive);
  to.roughness = from.is_pbr ? unit(from.roughness) : 0.5f;
  to.metallic = from.is_pbr ? unit(from.metalness) : metal;
  to.blended = to.base_color.a < 1;
  add_maps(from, to);
  return to;
}

void SdfMaterials::add_maps(const SdfMaterial& from, Material& to) {
  to.base_color_image = image(from.albedo_map, "albedo_map");
  to.normal_image = image(from.normal_map, "normal_map");
  to.occlusion_image = image(from.occlusion_map, "ambient_occlusion_map");
  to.emission_image = image(from.emissive_map, "emissive_map");
  if (to.emission_image && to.emission == glm::vec3(0)) to.emission = glm::vec3(1);
  to.metallic_roughness_image = metallic_roughness(image(from.metalness_map, "metalness_map"),
                                                   image(from.roughness_map, "roughness_map"));
  if (!to.base_color_image) return;
  if (glm::vec3(to.base_color) == glm::vec3(0))
    warn(
        "an <albedo_map> is black, as in Gazebo: its <material> has no <diffuse>, which is multiplied with "
        "it");
  if (!to.blended && has_alpha(*to.base_color_image)) to.alpha_cutoff = 0.5f;
}

std::optional<size_t> SdfMaterials::image(const SdfUri& uri, const char* map) {
  if (uri.uri.empty()) return std::nullopt;
  const auto left_out = [&](const std::string& why) {
    warn("<" + std::string(map) + "> " + quote(uri.uri) + " is left out: " + why);
    return std::nullopt;
  };
  const Result<std::filesystem::path> path = files_.resolve(uri.uri, uri.from);
  if (!path) return left_out(path.error().message);
  const Result<std::filesystem::path> file = regular_file(*path);
  if (!file) return left_out(file.error().message);
  if (const auto known = images_.find(*file); known != images_.end()) return known->second;
  if (!files_.image_folders().hold(*file)) return left_out(files_.outside_image_folders());
  constexpr uint64_t kMaxBytes = uint64_t{1} << 28;
  const Result<FileBytes> bytes = read_asset(*file, kMaxBytes);
  if (!bytes) return left_out(bytes.error().message);
  model_.images.push_back(
      {sanitize_text(file->filename().string()), {bytes->view().begin(), bytes->view().end()}});
  return images_[*file] = model_.images.size() - 1;
}

std::optional<size_t> SdfMaterials::metallic_roughness(std::optional<size_t> metalness,
                                                       std::optional<size_t> roughness) {
  if (!metalness && !roughness) return std::nullopt;
  const auto [known, is_new] = packed_.try_emplace({metalness, roughness});
  if (!is_new) return known->second;
  const auto bytes = [&](const std::optional<size_t>& index) {
    return index ? std::span<const std::byte>(model_.images[*index].bytes) : std::span<const std::byte>();
  };
  Result<std::vector<std::byte>> png = metallic_roughness_png(bytes(roughness), bytes(metalness));
  if (!png) {
    const std::string name = model_.images[metalness ? *metalness : *roughness].name;
    warn("<metalness_map> and <roughness_map> with " + quote(name) + " are left out: " + png.error().message);
    return std::nullopt;
  }
  model_.images.push_back({"roughness, metalness", std::move(*png)});
  return known->second = model_.images.size() - 1;
}

// Of PNG files, by their colour type.
bool SdfMaterials::has_alpha(size_t image) const {
  constexpr size_t kColorType = 25, kPalette = 3, kGreyAlpha = 4, kColorAlpha = 6;
  const std::vector<std::byte>& bytes = model_.images[image].bytes;
  if (bytes.size() <= kColorType || bytes[0] != std::byte{0x89} || bytes[1] != std::byte{'P'}) return false;
  const auto type = std::to_integer<size_t>(bytes[kColorType]);
  return type == kPalette || type == kGreyAlpha || type == kColorAlpha;
}

size_t SdfMaterials::of_mesh(size_t material, double transparency) {
  const float opacity = 1 - unit(transparency);
  if (opacity >= 1) return material;
  const auto [known, is_new] = transparent_.try_emplace({material, transparency}, model_.materials.size());
  if (!is_new) return known->second;
  Material copy = model_.materials[material];
  copy.base_color.a *= opacity;
  copy.blended = true;
  model_.materials.push_back(std::move(copy));
  return known->second;
}

}  // namespace fire3dv::convert
