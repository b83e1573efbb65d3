#include "adapters/gazebo/scene/materials.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "protocol/base/files.h"
#include "protocol/base/text.h"
#include "tools/convert/description_files.h"
#include "tools/convert/glb/write_glb.h"

namespace fire3dv::gazebo {
namespace {

constexpr uint64_t kMaxImageBytes = uint64_t{1} << 28;

float unit(double value) {
  return std::isfinite(value) ? static_cast<float>(std::clamp(value, 0.0, 1.0)) : 0.0f;
}

glm::vec3 rgb(const pb::Color& color) {
  return {unit(color.r()), unit(color.g()), unit(color.b())};
}

}  // namespace

std::optional<size_t> Materials::image(const std::string& uri, const std::string& where) {
  if (uri.empty()) return std::nullopt;
  const auto warn = [&](const std::string& reason) {
    model_.warnings.push_back(where + ": texture " + quote(uri) + " is left out: " + reason);
    return std::nullopt;
  };
  const Result<std::filesystem::path> found = resources_.find(uri);
  if (!found) return warn(found.error().message);
  if (const auto known = images_.find(*found); known != images_.end()) return known->second;
  images_[*found] = std::nullopt;
  const Result<std::filesystem::path> file = convert::regular_file(*found);
  if (!file) return warn(file.error().message);
  if (!resources_.image_folders(*file).hold(*file))
    return warn(
        "it lies in no model and in no folder of --resource-path or GZ_SIM_RESOURCE_PATH; name its folder "
        "there");
  std::error_code error;
  const std::filesystem::path canonical = std::filesystem::canonical(*file, error);
  if (!error && canonical != *found) {  // another spelling of its path
    if (const auto known = images_.find(canonical); known != images_.end())
      return images_[*found] = known->second;
  }
  Result<FileBytes> bytes = read_file(*file, kMaxImageBytes);
  if (!bytes) return warn(bytes.error().message);
  const std::span<const std::byte> view = bytes->view();
  model_.images.push_back({convert::sanitize_text(file->filename().string()), {view.begin(), view.end()}});
  if (!error) images_[canonical] = model_.images.size() - 1;
  return images_[*found] = model_.images.size() - 1;
}

// Gazebo has a grey image for each of roughness and metalness, glTF one image for both.
std::optional<size_t> Materials::packed_image(const pb::Material::Pbr& pbr, const std::string& where) {
  if (pbr.roughness_map().empty() && pbr.metalness_map().empty()) return std::nullopt;
  const std::pair<std::string, std::string> key(pbr.roughness_map(), pbr.metalness_map());
  if (const auto known = packed_.find(key); known != packed_.end()) return known->second;
  const std::optional<size_t> roughness = image(key.first, where), metalness = image(key.second, where);
  std::optional<size_t>& packed = packed_[key];
  if (!roughness && !metalness) return packed;
  const auto bytes = [&](const std::optional<size_t>& index) {
    return index ? std::span<const std::byte>(model_.images[*index].bytes) : std::span<const std::byte>();
  };
  Result<std::vector<std::byte>> made = convert::metallic_roughness_png(bytes(roughness), bytes(metalness));
  if (!made) {
    model_.warnings.push_back(where + ": roughness and metalness maps are left out: " + made.error().message);
    return packed;
  }
  model_.images.push_back({"roughness, metalness", std::move(*made)});
  return packed = model_.images.size() - 1;
}

size_t Materials::of_visual(const pb::Visual& visual, const std::string& node) {
  const std::string key = (visual.has_material() ? "m" + visual.material().SerializeAsString() : "-") + "\n" +
                          std::to_string(visual.transparency());
  if (const auto known = by_message_.find(key); known != by_message_.end()) return known->second;
  convert::Material to;
  float alpha = 1 - unit(visual.transparency());
  if (!visual.has_material()) {  // Gazebo's grey
    to.name = "gz-grey";
    to.base_color = glm::vec4(glm::vec3(0.7f), 1);
    to.roughness = 0.2f;
    to.metallic = 1;
  } else {
    const pb::Material& from = visual.material();
    const std::string where = quote(node);
    to.name = convert::sanitize_text(node, 64);
    // Gazebo's numbers are linear.
    to.base_color = glm::vec4(rgb(from.diffuse()), 1);
    if (from.has_diffuse()) alpha *= unit(from.diffuse().a());
    to.emission = rgb(from.emissive());
    if (from.has_pbr() && from.pbr().type() != 0) {
      const pb::Material::Pbr& pbr = from.pbr();
      const bool is_specular = pbr.type() == 2;
      to.metallic = is_specular ? 0 : unit(pbr.metalness());
      to.roughness = is_specular ? 1 - unit(pbr.glossiness()) : unit(pbr.roughness());
      to.base_color_image = image(pbr.albedo_map(), where);
      to.normal_image = image(pbr.normal_map(), where);
      to.emission_image = image(pbr.emissive_map(), where);
      if (to.emission_image && to.emission == glm::vec3(0)) to.emission = glm::vec3(1);
      if (!is_specular) to.metallic_roughness_image = packed_image(pbr, where);
    }
  }
  to.base_color.a = alpha;
  to.blended = alpha < 1;
  model_.materials.push_back(std::move(to));
  return by_message_[key] = model_.materials.size() - 1;
}

size_t Materials::with_transparency(size_t material, double transparency) {
  const float opacity = 1 - unit(transparency);
  if (opacity == 1) return material;
  const auto [known, is_new] = transparent_.try_emplace({material, transparency}, 0);
  if (is_new) {
    convert::Material copy = model_.materials[material];
    copy.base_color.a *= opacity;
    copy.blended = true;
    model_.materials.push_back(std::move(copy));
    known->second = model_.materials.size() - 1;
  }
  return known->second;
}

}  // namespace fire3dv::gazebo
