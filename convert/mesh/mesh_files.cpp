#include "convert/mesh/mesh_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <span>
#include <system_error>
#include <tuple>
#include <utility>

#include "convert/glb/write_glb.h"
#include "convert/mesh/geometry/mesh_normals.h"
#include "convert/mesh/smooth_surface.h"
#include "convert/surfaces.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr uint64_t kMaxImageBytes = uint64_t{1} << 28;

// Candidates for an image name: the name as it is, its last components next to the mesh, and the last where
// Gazebo's models have it. Many files contain paths of the machine that wrote them.
std::vector<std::filesystem::path> candidate_paths(const std::filesystem::path& folder, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  const std::filesystem::path path(name);
  std::vector<std::filesystem::path> candidates{folder / path};
  constexpr size_t kMaxComponents = 6;
  std::vector<std::filesystem::path> ends;  // of the path, shortest first
  for (auto part = path.end(); part != path.begin() && ends.size() < kMaxComponents;) {
    --part;
    if (part->native() == ".." || part->native() == "/" || part->native().ends_with(':')) break;
    ends.push_back(ends.empty() ? *part : *part / ends.back());
  }
  for (auto end = ends.rbegin(); end != ends.rend(); ++end) candidates.push_back(folder / *end);
  candidates.push_back(folder.parent_path() / "materials/textures" / path.filename());
  return candidates;
}

constexpr float kInvisible = 0.01f;

// Nobody draws an invisible mesh: exporters disagree whether 0 or 1 is opaque, as in MTL's Tr, and write
// colours with an opacity that means nothing. glTF is exact.
void make_visible(ImportedMesh& mesh, std::vector<std::string>& warnings) {
  std::set<size_t> used;
  size_t clear_surfaces = 0;
  for (Surface& surface : mesh.surfaces) {
    if (surface.material >= mesh.materials.size() || mesh.materials[surface.material].is_exact) continue;
    used.insert(surface.material);
    const bool is_clear =
        !surface.colors.empty() && std::all_of(surface.colors.begin(), surface.colors.end(),
                                               [](const glm::vec4& color) { return color.a < kInvisible; });
    if (!is_clear) continue;
    for (glm::vec4& color : surface.colors) color.a = 1;
    ++clear_surfaces;
  }
  size_t clear_materials = 0;
  std::string first;
  for (const size_t index : used) {
    ImportedMaterial& material = mesh.materials[index];
    if (material.opacity >= kInvisible) continue;
    material.opacity = 1;
    if (clear_materials++ == 0) first = material.name;
  }
  if (clear_materials > 0) {
    warnings.push_back("material " + quote(first) +
                       (clear_materials > 1 ? " and " + std::to_string(clear_materials - 1) + " more" : "") +
                       " would be invisible (opacity 0): drawn opaque");
  }
  if (clear_surfaces > 0)
    warnings.emplace_back("its colours would be invisible (all of opacity 0): drawn opaque");
}

glm::vec3 scaled_normal(const glm::vec3& normal, const glm::dvec3& scale) {
  // Cofactors replace the inverse, which a flat scale does not have.
  const glm::dvec3 wide =
      glm::dvec3(normal) * glm::dvec3(scale.y * scale.z, scale.z * scale.x, scale.x * scale.y);
  const double length = glm::length(wide);
  const double sign = scale.x * scale.y * scale.z < 0 ? -1 : 1;
  return length > 0 ? glm::vec3(wide * (sign / length)) : normal;
}

void apply_scale(Surface& surface, const glm::dvec3& scale) {
  for (glm::vec3& position : surface.positions) position = glm::vec3(glm::dvec3(position) * scale);
  for (glm::vec3& normal : surface.normals) normal = scaled_normal(normal, scale);
  if (scale.x * scale.y * scale.z < 0) {  // mirrored: reverse the winding
    for (size_t i = 0; i + 2 < surface.indices.size(); i += 3)
      std::swap(surface.indices[i + 1], surface.indices[i + 2]);
  }
}

}  // namespace

struct MeshFiles::State {
  explicit State(Model& to) : model(to) {}

  std::optional<size_t> image(const std::filesystem::path& mesh_file, const std::string& name,
                              ImportedMesh& mesh);
  std::optional<size_t> embedded_image(const std::filesystem::path& mesh_file, const std::string& name,
                                       ImportedMesh& mesh);
  void add_surface_images(const std::filesystem::path& mesh_file, const ImportedMaterial& from,
                          ImportedMesh& mesh, Material& to);
  void add_opacity_image(const std::filesystem::path& mesh_file, const ImportedMaterial& from,
                         ImportedMesh& mesh, Material& to);
  size_t material(const std::filesystem::path& mesh_file, const ImportedMaterial& from, ImportedMesh& mesh);
  Result<ImportedMesh> import(const std::filesystem::path& resolved, const std::filesystem::path& shown,
                              ImportRequest request);
  Result<std::vector<Surface>> read(const std::filesystem::path& resolved,
                                    const std::filesystem::path& shown);

  Model& model;
  MeshImportProcess child;
  AllowedFolders allowed;
  DaeUp dae_up = DaeUp::ignore;
  GltfUp gltf_up = GltfUp::ignore;
  std::optional<double> smooth_cosine = kSmoothCosine;  // empty: flat
  std::set<size_t> defaults;                            // materials that stand for none
  // Surfaces read, or the error.
  std::map<std::filesystem::path, Result<std::vector<Surface>>> surfaces;
  std::map<std::filesystem::path, Result<ImportedMesh>> nodes;  // with their nodes
  std::map<std::filesystem::path, size_t> images;
  // Images packed of a roughness and a metalness image.
  std::map<std::pair<std::optional<size_t>, std::optional<size_t>>, std::optional<size_t>> metallic_roughness;
  // Images with an opacity of their own or of another image: index, and whether it is a cutout.
  std::map<std::tuple<std::optional<size_t>, size_t, OpacityChannel>, std::pair<size_t, bool>> opacity;
};

// name: *N
std::optional<size_t> MeshFiles::State::embedded_image(const std::filesystem::path& mesh_file,
                                                       const std::string& name, ImportedMesh& mesh) {
  size_t index = 0;
  const auto [end, error] = std::from_chars(name.data() + 1, name.data() + name.size(), index);
  if (error != std::errc() || end != name.data() + name.size() || index >= mesh.images.size() ||
      mesh.images[index].bytes.empty()) {
    model.warnings.push_back(quote(mesh_file.string()) + ": an embedded image is left out: it is missing");
    return std::nullopt;
  }
  const std::filesystem::path key = mesh_file / name;  // no path of a file
  if (const auto known = images.find(key); known != images.end()) return known->second;
  EmbeddedImage& image = mesh.images[index];
  model.images.push_back(
      {image.name.empty() ? mesh_file.filename().string() + name : image.name, image.bytes});
  return images[key] = model.images.size() - 1;
}

std::optional<size_t> MeshFiles::State::image(const std::filesystem::path& mesh_file, const std::string& name,
                                              ImportedMesh& mesh) {
  if (name.starts_with('*')) return embedded_image(mesh_file, name, mesh);
  const std::string where = quote(mesh_file.string()) + ": image " + quote(name);
  AllowedFolders may_be_read = allowed;
  may_be_read.add(mesh_file.parent_path());
  may_be_read.add(mesh_file.parent_path().parent_path() / "materials/textures");  // of a model of Gazebo
  bool outside = false;
  for (const std::filesystem::path& candidate : candidate_paths(mesh_file.parent_path(), name)) {
    model.sources.add(candidate);
    const Result<std::filesystem::path> found = regular_file(candidate);
    if (!found) continue;
    if (!may_be_read.hold(*found)) {
      outside = true;
      continue;
    }
    if (const auto known = images.find(*found); known != images.end()) return known->second;
    Result<FileBytes> bytes = read_asset(*found, kMaxImageBytes);
    if (!bytes) {
      model.warnings.push_back(where + " is left out: " + bytes.error().message);
      return std::nullopt;
    }
    const std::span<const std::byte> view = bytes->view();
    model.images.push_back({sanitize_text(found->filename().string()), {view.begin(), view.end()}});
    return images[*found] = model.images.size() - 1;
  }
  model.warnings.push_back(where +
                           (outside ? " is left out: it lies outside the folders of the meshes and of the "
                                      "description; copy it next to the mesh"
                                    : " is left out: there is no such file, nor one next to the mesh"));
  return std::nullopt;
}

// Emission, roughness and metalness. MTL has a grey image for each of the last two, glTF one image for both.
void MeshFiles::State::add_surface_images(const std::filesystem::path& mesh_file,
                                          const ImportedMaterial& from, ImportedMesh& mesh, Material& to) {
  const auto find = [&](const std::string& name) {
    return name.empty() ? std::nullopt : image(mesh_file, name, mesh);
  };
  to.emission_image = find(from.emission_image);
  // Exporters write black, or 0, beside a map that is meant to replace it.
  if (to.emission_image && to.emission == glm::vec3(0) && !from.is_exact) to.emission = glm::vec3(1);
  const std::optional<size_t> roughness = find(from.roughness_image), metallic = find(from.metallic_image);
  if (!roughness && !metallic) return;
  const std::pair<std::optional<size_t>, std::optional<size_t>> both(roughness, metallic);
  const auto known = metallic_roughness.find(both);
  if (known != metallic_roughness.end()) {
    to.metallic_roughness_image = known->second;
  } else if (roughness == metallic) {
    to.metallic_roughness_image = roughness;  // packed as in glTF
  } else {
    const auto bytes = [&](const std::optional<size_t>& index) {
      return index ? std::span<const std::byte>(model.images[*index].bytes) : std::span<const std::byte>();
    };
    Result<std::vector<std::byte>> packed = metallic_roughness_png(bytes(roughness), bytes(metallic));
    if (packed) {
      model.images.push_back({from.name + " (roughness, metalness)", std::move(*packed)});
      to.metallic_roughness_image = model.images.size() - 1;
    } else {
      model.warnings.push_back(quote(mesh_file.string()) + ": roughness and metalness images of " +
                               quote(from.name) + " are left out: " + packed.error().message);
    }
  }
  metallic_roughness[both] = to.metallic_roughness_image;
  if (metallic && to.metallic_roughness_image && to.metallic == 0 && !from.is_exact) to.metallic = 1;
}

// MTL has an image for the opacity, glTF the opacity of the base colour's image.
void MeshFiles::State::add_opacity_image(const std::filesystem::path& mesh_file, const ImportedMaterial& from,
                                         ImportedMesh& mesh, Material& to) {
  const std::optional<size_t> mask = image(mesh_file, from.opacity_image, mesh);
  if (!mask) return;
  const auto left_out = [&](const std::string& why) {
    model.warnings.push_back(quote(mesh_file.string()) + ": the map_d of material " + quote(from.name) +
                             " is not drawn: " + why);
  };
  if (to.base_color_image && from.opacity_placement != from.diffuse_placement)
    return left_out("its options (-s, -o, -clamp) are not those of map_Kd");
  const auto key = std::make_tuple(to.base_color_image, *mask, from.opacity_channel);
  auto known = opacity.find(key);
  if (known == opacity.end()) {
    const auto color = to.base_color_image
                           ? std::span<const std::byte>(model.images[*to.base_color_image].bytes)
                           : std::span<const std::byte>();
    const bool is_own = to.base_color_image == mask;
    Result<OpacityPng> made = opacity_png(color, model.images[*mask].bytes, from.opacity_channel, is_own);
    if (!made) return left_out("of its image and that of map_Kd " + made.error().message);
    if (made->is_opaque)
      return is_own ? left_out("it is the image of map_Kd, which has no opacity of its own") : void();
    const std::string name = model.images[*mask].name;
    model.images.push_back({is_own || !to.base_color_image
                                ? name
                                : model.images[*to.base_color_image].name + ", opacity of " + name,
                            std::move(made->png)});
    known = opacity.emplace(key, std::pair(model.images.size() - 1, made->is_cutout)).first;
  }
  to.base_color_image = known->second.first;
  to.base_color_placement = from.opacity_placement;
  to.blended = to.base_color.a < 1 || !known->second.second;
  if (!to.blended) to.alpha_cutoff = 0.5f;
}

size_t MeshFiles::State::material(const std::filesystem::path& mesh_file, const ImportedMaterial& from,
                                  ImportedMesh& mesh) {
  Material to;
  to.name = from.name;
  to.base_color = glm::vec4(linear_from_srgb(from.diffuse), from.opacity);
  to.emission = linear_from_srgb(from.emission);
  to.roughness = from.roughness;
  to.metallic = from.metallic;
  to.base_color_placement = from.diffuse_placement;
  to.normal_placement = from.normal_placement;
  to.emission_placement = from.emission_placement;
  to.metallic_roughness_placement = from.roughness_placement;
  if (from.alpha_cutoff >= 0)
    to.alpha_cutoff = from.alpha_cutoff;
  else
    to.blended = from.opacity < 1 || from.is_blended;
  if (!from.diffuse_image.empty()) to.base_color_image = image(mesh_file, from.diffuse_image, mesh);
  if (!from.opacity_image.empty()) add_opacity_image(mesh_file, from, mesh, to);
  if (!from.normal_image.empty()) to.normal_image = image(mesh_file, from.normal_image, mesh);
  add_surface_images(mesh_file, from, mesh, to);
  if (from.is_default) defaults.insert(model.materials.size());
  model.materials.push_back(std::move(to));
  return model.materials.size() - 1;
}

Result<std::vector<Surface>> MeshFiles::State::read(const std::filesystem::path& resolved,
                                                    const std::filesystem::path& shown) {
  Result<ImportedMesh> mesh = import(resolved, shown, {.dae_up = dae_up, .gltf_up = gltf_up});
  if (!mesh) return mesh.error();
  return std::move(mesh->surfaces);
}

// The surfaces of the result name materials of the model.
Result<ImportedMesh> MeshFiles::State::import(const std::filesystem::path& resolved,
                                              const std::filesystem::path& shown, ImportRequest request) {
  Result<ImportedMesh> mesh = child.import(resolved, request);
  if (!mesh) return mesh;
  make_visible(*mesh, mesh->warnings);
  for (const std::string& warning : mesh->warnings)
    model.warnings.push_back(quote(shown.string()) + ": " + warning);
  const std::vector<Sources::Source>& besides = mesh->besides.all();
  for (const Sources::Source& source : besides) model.sources.add(source);
  // The first entry is the name in the file; importers then try other names.
  if (!besides.empty() && std::none_of(besides.begin(), besides.end(), [](const Sources::Source& source) {
        return regular_file(source.file).ok();
      })) {
    model.warnings.push_back(quote(shown.string()) +
                             " has no materials: " + quote(besides.front().file.filename().string()) +
                             ", which it names, is not next to it");
  }
  // File material, and whether vertices have colours, to model material, for visible surfaces.
  std::map<std::pair<size_t, bool>, size_t> materials;
  for (Surface& surface : mesh->surfaces) {
    ImportedMaterial& of_file = mesh->materials[surface.material];
    const bool has_colors = !surface.colors.empty();
    const auto [known, is_new] = materials.try_emplace({surface.material, has_colors}, 0);
    if (is_new) {
      known->second = material(shown, of_file, *mesh);
      // glTF multiplies both.
      if (has_colors && of_file.is_default) model.materials.back().base_color = glm::vec4(1);
    }
    surface.material = known->second;
    const bool is_clear = std::any_of(surface.colors.begin(), surface.colors.end(),
                                      [](const glm::vec4& color) { return color.a < 1; });
    if (is_clear) model.materials[surface.material].blended = true;
    if (surface.normals.empty() && smooth_cosine) surface = with_normals(surface, *smooth_cosine);
  }
  return mesh;
}

MeshFiles::MeshFiles(Model& model) : state_(std::make_unique<State>(model)) {}
MeshFiles::~MeshFiles() = default;

void MeshFiles::allow_images_below(const std::filesystem::path& folder) {
  state_->allowed.add(folder);
}

void MeshFiles::allow_images_below(const AllowedFolders& folders) {
  state_->allowed.add(folders);
}

void MeshFiles::apply_dae_up() {
  state_->dae_up = DaeUp::apply;
}

void MeshFiles::apply_gltf_up() {
  state_->gltf_up = GltfUp::apply;
}

void MeshFiles::set_smooth_angle(std::optional<double> angle_deg) {
  state_->smooth_cosine = kSmoothCosine;
  if (angle_deg) state_->smooth_cosine = std::cos(glm::radians(*angle_deg));
  if (angle_deg == 0) state_->smooth_cosine.reset();
}

bool MeshFiles::is_default(size_t material) const {
  return state_->defaults.contains(material);
}

Result<ImportedMesh> MeshFiles::scene(const std::filesystem::path& file) {
  state_->model.sources.add(file);
  const Result<std::filesystem::path> resolved = regular_file(file);
  if (!resolved) return resolved.error();
  return state_->import(*resolved, file, {.dae_up = DaeUp::apply, .nodes = Nodes::keep});
}

Result<std::vector<Surface>> MeshFiles::surfaces(const std::filesystem::path& file, const glm::dvec3& scale) {
  if (!std::isfinite(scale.x) || !std::isfinite(scale.y) || !std::isfinite(scale.z))
    return Error{"the scale of " + quote(file.string()) + " is not finite"};
  state_->model.sources.add(file);
  Result<std::filesystem::path> resolved = regular_file(file);
  if (!resolved) return resolved.error();
  auto known = state_->surfaces.find(*resolved);
  if (known == state_->surfaces.end())
    known = state_->surfaces.emplace(*resolved, state_->read(*resolved, file)).first;
  if (!known->second) return known->second.error();
  std::vector<Surface> copy = *known->second;
  if (scale != glm::dvec3(1)) {
    for (Surface& surface : copy) {
      apply_scale(surface, scale);
      for (const glm::vec3& p : surface.positions)
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
          return Error{"the scale of " + quote(file.string()) + " is too large for its vertices"};
    }
  }
  return copy;
}

Result<std::vector<Surface>> MeshFiles::surfaces_of_node(const std::filesystem::path& file,
                                                         const std::string& name) {
  state_->model.sources.add(file);
  const Result<std::filesystem::path> resolved = regular_file(file);
  if (!resolved) return resolved.error();
  auto known = state_->nodes.find(*resolved);
  if (known == state_->nodes.end()) {
    const ImportRequest request{.dae_up = state_->dae_up, .nodes = Nodes::keep, .gltf_up = state_->gltf_up};
    known = state_->nodes.emplace(*resolved, state_->import(*resolved, file, request)).first;
  }
  if (!known->second) return known->second.error();
  const ImportedMesh& mesh = *known->second;
  std::vector<Surface> found;
  std::set<std::string> names;
  for (const auto own_name : {&ImportedNode::name, &ImportedNode::mesh_name}) {
    for (size_t i = 0; i < mesh.surfaces.size(); ++i) {
      const ImportedNode& node = mesh.nodes[mesh.surface_nodes[i]];
      if (!(node.*own_name).empty() && !(node.*own_name).starts_with('$')) names.insert(node.*own_name);
      if (node.*own_name != name) continue;
      Mesh in_file;
      add_surface(in_file, mesh.surfaces[i], node.file_from_node, mesh.surfaces[i].material);
      found.push_back(std::move(in_file.surfaces.front()));
    }
    if (!found.empty()) return found;
  }
  std::string all;
  constexpr size_t kMaxBytes = 300;
  for (const std::string& each : names)
    if (all.size() < kMaxBytes) all += (all.empty() ? "" : ", ") + quote(each);
  return Error{quote(file.string()) + " has no node " + quote(name) + " with a mesh, only " + all};
}

}  // namespace fire3dv::convert
