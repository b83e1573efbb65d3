#include "convert/mjcf/assets/mjcf_source.h"

#include <algorithm>
#include <utility>

#include "convert/mjcf/assets/mjcf_height_field.h"
#include "convert/mjcf/assets/mjcf_texture.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

std::string with_slashes(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

// Name of an asset: its own, or that of its file without folder and extension.
std::string asset_name(const MjcfElement& element) {
  if (const std::string* name = element.find("name"); name && !name->empty()) return *name;
  return fs::path(with_slashes(element.text("file"))).stem().string();
}

}  // namespace

Result<std::unique_ptr<MjcfSource>> MjcfSource::open(const fs::path& file, MjcfFiles& files,
                                                     MjcfMessages& messages) {
  Result<MjcfElement> root = load_mjcf(file, files);
  if (!root) return root.error();
  if (root->kind != "mujoco")
    return Error{quote(file.string()) + ": its root element is " + quote(root->kind) + " instead of mujoco"};
  std::unique_ptr<MjcfSource> source(new MjcfSource(file, std::move(*root), files, messages));
  for (const MjcfElement& section : source->root_.children)
    if (section.kind == "compiler")
      if (Result<void> done = source->read_compiler(section); !done) return done.error();
  for (const MjcfElement& section : source->root_.children)
    if (section.kind == "default") source->defaults_.read(section, messages);
  for (const MjcfElement& section : source->root_.children)
    if (section.kind == "asset") source->read_assets(section);
  return source;
}

Result<void> MjcfSource::read_compiler(const MjcfElement& section) {
  const MjcfAttributes from = attributes(section, MjcfDefaults::kMain);
  if (from.text("coordinate") == "global")
    return Error{section.where() +
                 ": coordinate=\"global\" is not supported, nor by MuJoCo since 2.3.4: load and "
                 "save the model with MuJoCo 2.3.3"};
  if (const std::string* angle = from.find("angle")) compiler_.degrees = *angle != "radian";
  if (const std::string* sequence = from.find("eulerseq")) {
    const bool is_valid = sequence->size() == 3 && sequence->find_first_not_of("xyzXYZ") == std::string::npos;
    if (is_valid)
      compiler_.euler_sequence = *sequence;
    else
      from.warn("eulerseq=" + quote(*sequence) + " is not three of the letters xyzXYZ; xyz is used");
  }
  if (const std::string* folder = from.find("assetdir"))
    compiler_.mesh_folder = compiler_.texture_folder = with_slashes(*folder);
  if (const std::string* folder = from.find("meshdir")) compiler_.mesh_folder = with_slashes(*folder);
  if (const std::string* folder = from.find("texturedir")) compiler_.texture_folder = with_slashes(*folder);
  compiler_.strips_paths = from.flag("strippath", compiler_.strips_paths);
  compiler_.fits_bounds = from.flag("fitaabb", compiler_.fits_bounds);
  compiler_.discards_visual = from.flag("discardvisual", compiler_.discards_visual);
  compiler_.limits_automatically = from.flag("autolimits", compiler_.limits_automatically);
  const std::string inertia = from.text("inertiafromgeom");
  if (!inertia.empty())
    compiler_.inertia_from_geom = inertia == "true"    ? MjcfCompiler::InertiaFromGeom::yes
                                  : inertia == "false" ? MjcfCompiler::InertiaFromGeom::no
                                                       : MjcfCompiler::InertiaFromGeom::unless_given;
  if (const auto range = from.vec2("inertiagrouprange")) {
    compiler_.first_inertia_group = static_cast<int>(std::clamp(range->x, -1e9, 1e9));
    compiler_.last_inertia_group = static_cast<int>(std::clamp(range->y, -1e9, 1e9));
  }
  return {};
}

size_t MjcfSource::class_of(const MjcfElement& element, size_t around, std::string_view attribute) const {
  const std::string* const name = element.find(attribute);
  if (!name || name->empty()) return around;
  if (const auto found = defaults_.find(*name)) return *found;
  messages_.warn(element.where() + ": there is no default class " + quote(*name));
  return around;
}

void MjcfSource::read_assets(const MjcfElement& section) {
  for (const MjcfElement& child : section.children) {
    const size_t class_index = class_of(child, MjcfDefaults::kMain);
    const std::string name = asset_name(child);
    if (child.kind == "mesh") {
      MjcfMeshAsset asset;
      asset.element = &child;
      asset.class_index = class_index;
      meshes_.emplace(name, asset);
    } else if (child.kind == "texture") {
      if (!skybox_ && child.text("type") == "skybox") skybox_ = &child;
      textures_.emplace(name, MjcfAsset{&child, class_index, false, {}});
    } else if (child.kind == "material") {
      materials_.emplace(name, MjcfAsset{&child, class_index, false, {}});
    } else if (child.kind == "hfield") {
      height_fields_.emplace(name, MjcfAsset{&child, class_index, false, {}});
    } else if (child.kind == "model") {
      if (child.text("name").empty())
        unnamed_models_.push_back(&child);
      else
        models_.emplace(name, &child);
    } else if (child.kind != "skin") {  // read with the bodies that it follows
      messages_.warn(child.where() + ": the asset is unknown and ignored");
    }
  }
}

std::string MjcfSource::file_name(std::string name) const {
  name = with_slashes(std::move(name));
  return compiler_.strips_paths ? fs::path(name).filename().string() : name;
}

std::vector<fs::path> MjcfSource::folders(const MjcfElement& element, const fs::path& below) const {
  // MuJoCo 3 also looks next to the file that includes the asset.
  std::vector<fs::path> found{file_.parent_path() / below};
  if (element.file && element.file->parent_path() != file_.parent_path())
    found.push_back(element.file->parent_path() / below);
  return found;
}

const MjcfMeshAsset* MjcfSource::mesh(const std::string& name, const MjcfElement& user, MjcfScene& scene) {
  const auto known = meshes_.find(name);
  if (known == meshes_.end()) {
    messages_.warn(user.where() + ": there is no mesh " + quote(name));
    return nullptr;
  }
  MjcfMeshAsset& asset = known->second;
  if (!asset.is_read) {
    asset.is_read = true;
    Result<std::shared_ptr<const MjcfMesh>> read = read_mjcf_mesh(*this, asset);
    if (read) {
      asset.mesh = std::move(*read);
      asset.index = scene.meshes.size();
      scene.meshes.push_back(asset.mesh->surface);
    } else {
      messages_.warn(asset.element->where() + " is left out: " + read.error().message);
    }
  }
  return asset.mesh ? &asset : nullptr;
}

std::optional<size_t> MjcfSource::height_field(const std::string& name, const MjcfElement& user,
                                               MjcfScene& scene) {
  const auto known = height_fields_.find(name);
  if (known == height_fields_.end()) {
    messages_.warn(user.where() + ": there is no hfield " + quote(name));
    return std::nullopt;
  }
  MjcfAsset& asset = known->second;
  if (!std::exchange(asset.is_read, true)) {
    Result<MjcfHeightField> read = read_mjcf_height_field(*this, *asset.element);
    if (read) {
      asset.index = scene.height_fields.size();
      scene.height_fields.push_back(std::make_shared<const MjcfHeightField>(std::move(*read)));
    } else {
      messages_.warn(asset.element->where() + " is left out: " + read.error().message);
    }
  }
  return asset.index;
}

std::optional<Image> MjcfSource::sky() const {
  if (!skybox_) return std::nullopt;
  Result<Image> sky = read_mjcf_sky(*this, *skybox_);
  if (sky) return std::move(*sky);
  messages_.warn(skybox_->where() + ": " + sky.error().message + "; the sky is left out");
  return std::nullopt;
}

std::optional<size_t> MjcfSource::texture(const std::string& name, const MjcfElement& user,
                                          MjcfScene& scene) {
  const auto known = textures_.find(name);
  if (known == textures_.end()) {
    messages_.warn(user.where() + ": there is no texture " + quote(name));
    return std::nullopt;
  }
  MjcfAsset& asset = known->second;
  if (!std::exchange(asset.is_read, true)) {
    Result<MjcfTexture> read = read_mjcf_texture(*this, *asset.element);
    if (read) {
      read->name = name;
      asset.index = scene.textures.size();
      scene.textures.push_back(std::move(*read));
    } else {
      messages_.warn(asset.element->where() + " is left out: " + read.error().message);
    }
  }
  return asset.index;
}

std::optional<size_t> MjcfSource::material(const std::string& name, const MjcfElement& user,
                                           MjcfScene& scene) {
  const auto known = materials_.find(name);
  if (known == materials_.end()) {
    messages_.warn(user.where() + ": there is no material " + quote(name));
    return std::nullopt;
  }
  MjcfAsset& asset = known->second;
  if (std::exchange(asset.is_read, true)) return asset.index;
  const MjcfAttributes from = attributes(*asset.element, asset.class_index);
  MjcfMaterial made;
  made.name = name;
  if (const auto rgba = from.vec4("rgba"))
    for (int i = 0; i < 4; ++i) made.rgba[static_cast<size_t>(i)] = static_cast<float>((*rgba)[i]);
  const auto number = [&](const char* attribute, float& to) {
    if (const auto value = from.number(attribute)) to = static_cast<float>(*value);
  };
  number("emission", made.emission);
  number("specular", made.specular);
  number("shininess", made.shininess);
  number("reflectance", made.reflectance);
  // Negative: not set.
  const auto physical = [&](const char* attribute, std::optional<float>& to) {
    if (const auto value = from.number(attribute); value && *value >= 0) to = static_cast<float>(*value);
  };
  physical("metallic", made.metallic);
  physical("roughness", made.roughness);
  if (const auto repeats = from.vec2("texrepeat")) made.texture_repeats = *repeats;
  made.texture_is_uniform = from.flag("texuniform", false);
  if (const std::string used = from.text("texture"); !used.empty())
    made.texture = texture(used, *asset.element, scene);
  read_layers(*asset.element, made, scene);
  asset.index = scene.materials.size();
  scene.materials.push_back(std::move(made));
  return asset.index;
}

void MjcfSource::read_layers(const MjcfElement& element, MjcfMaterial& material, MjcfScene& scene) {
  for (const MjcfElement& layer : element.children) {
    const std::string role = layer.text("role"), used = layer.text("texture");
    if (layer.kind != "layer") {
      messages_.warn(layer.where() + " is unknown in a material and ignored");
    } else if (role == "rgb" || role == "rgba") {
      material.texture = texture(used, layer, scene);
    } else if (role == "normal") {
      material.normal_texture = texture(used, layer, scene);
    } else {
      messages_.warn(layer.where() + ": textures of the role " + quote(role) + " are not shown");
    }
  }
}

const MjcfElement* MjcfSource::model(const std::string& name) const {
  const auto known = models_.find(name);
  return known == models_.end() ? nullptr : known->second;
}

}  // namespace fire3dv::convert
