// Reader for SDF: worlds, models and model folders of Gazebo.
#include <filesystem>
#include <system_error>
#include <utility>

#include "convert/model.h"
#include "convert/readers.h"
#include "convert/sdf/add_sdf.h"
#include "convert/sdf/files/sdf_documents.h"
#include "convert/sdf/files/sdf_files.h"
#include "convert/sdf/files/sdf_version.h"
#include "convert/sdf/library/sdf_reader.h"

namespace fire3dv::convert {

Result<Model> read_sdf(const std::filesystem::path& file, const ReadOptions& options) {
  Model model;
  std::filesystem::path sdf = file;
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    Result<std::filesystem::path> found = sdf_of_model_folder(file, kNewestSdfMinorVersion, model.sources);
    if (!found) return found.error();
    sdf = std::move(*found);
  }
  SdfFiles files = options.is_confined ? SdfFiles(options.package_folders, "--package-path", sdf)
                                       : SdfFiles(sdf, options.package_folders, model.sources);
  SdfDocuments documents(files, model.sources, model.warnings);
  const Result<std::string> copy = documents.open(sdf);
  if (!copy) return copy.error();
  const Result<SdfScene> scene = read_sdf_scene(*copy, documents, model.warnings);
  if (!scene) return scene.error();
  model.name = sanitize_text(scene->name.empty() ? sdf.stem().string() : scene->name);
  add_sdf(*scene, sdf, options, files, model);
  if (model.cameras.empty()) model.view_from = kThreeQuarterFront;
  if (model.meshes.empty())
    model.warnings.push_back(sdf.string() + ": nothing to draw: no <visual> can be drawn");
  return model;
}

}  // namespace fire3dv::convert
