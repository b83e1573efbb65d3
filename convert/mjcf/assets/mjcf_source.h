// One MJCF model file with its includes: settings, default classes and assets. A model has further sources
// for the models that it attaches.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "convert/mjcf/assets/mjcf_mesh.h"
#include "convert/mjcf/scene/mjcf_scene.h"
#include "convert/mjcf/xml/mjcf_attributes.h"
#include "convert/mjcf/xml/mjcf_element.h"
#include "convert/mjcf/xml/mjcf_files.h"

namespace fire3dv::convert {

// Mesh asset, read when a geom first shows it.
struct MjcfMeshAsset {
  const MjcfElement* element = nullptr;
  size_t class_index = 0;
  bool is_read = false;
  std::shared_ptr<const MjcfMesh> mesh;  // null: left out
  std::optional<size_t> index;           // into MjcfScene::meshes
};

struct MjcfAsset {
  const MjcfElement* element = nullptr;
  size_t class_index = 0;
  bool is_read = false;
  std::optional<size_t> index;  // into the scene's list; empty: left out
};

class MjcfSource {
 public:
  // Reads settings, classes and the list of assets. root must outlive the source.
  static Result<std::unique_ptr<MjcfSource>> open(const std::filesystem::path& file, MjcfFiles& files,
                                                  MjcfMessages& messages);

  const std::filesystem::path& file() const { return file_; }
  const MjcfElement& root() const { return root_; }
  const MjcfCompiler& compiler() const { return compiler_; }
  const MjcfDefaults& defaults() const { return defaults_; }

  // Assets are read on first use; the scene receives them. Empty: unknown or left out, with a warning.
  const MjcfMeshAsset* mesh(const std::string& name, const MjcfElement& user, MjcfScene& scene);
  std::optional<size_t> height_field(const std::string& name, const MjcfElement& user, MjcfScene& scene);
  std::optional<size_t> material(const std::string& name, const MjcfElement& user, MjcfScene& scene);
  // Its first skybox as an equirectangular image in the frame of glTF. Empty: none, or left out with a
  // warning.
  std::optional<Image> sky() const;
  // Element of an attachable model; null: unknown.
  const MjcfElement* model(const std::string& name) const;
  const std::vector<const MjcfElement*>& unnamed_models() const { return unnamed_models_; }

  MjcfAttributes attributes(const MjcfElement& element, size_t class_index,
                            std::string_view default_kind = {}) const {
    return {element, defaults_, class_index, messages_, default_kind};
  }
  MjcfFiles& files() const { return files_; }
  MjcfMessages& messages() const { return messages_; }
  // Class of an element: its own, or that of its surroundings.
  size_t class_of(const MjcfElement& element, size_t around, std::string_view attribute = "class") const;
  // Folders where the file of an asset is looked for.
  std::vector<std::filesystem::path> folders(const MjcfElement& element,
                                             const std::filesystem::path& below) const;
  // Name of a file as it is looked for: without its folders where the compiler strips them.
  std::string file_name(std::string name) const;

 private:
  MjcfSource(std::filesystem::path file, MjcfElement root, MjcfFiles& files, MjcfMessages& messages)
      : file_(std::move(file)), root_(std::move(root)), files_(files), messages_(messages) {}
  Result<void> read_compiler(const MjcfElement& section);
  void read_assets(const MjcfElement& section);
  std::optional<size_t> texture(const std::string& name, const MjcfElement& user, MjcfScene& scene);
  void read_layers(const MjcfElement& element, MjcfMaterial& material, MjcfScene& scene);

  std::filesystem::path file_;
  MjcfElement root_;
  MjcfFiles& files_;
  MjcfMessages& messages_;
  MjcfCompiler compiler_;
  MjcfDefaults defaults_;
  std::map<std::string, MjcfMeshAsset> meshes_;
  std::map<std::string, MjcfAsset> height_fields_, materials_, textures_;
  std::map<std::string, const MjcfElement*> models_;
  std::vector<const MjcfElement*> unnamed_models_;
  const MjcfElement* skybox_ = nullptr;
};

}  // namespace fire3dv::convert
