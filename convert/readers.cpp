#include "convert/readers.h"

#include <system_error>

#include "base/text.h"
#include "convert/description_files.h"

namespace fire3dv::convert {

namespace {

Error not_a_launch_file(const std::filesystem::path& file) {
  return Error{quote(file.string()) + " is no AMBF launch file: remove --models and --all"};
}

Result<Model> read_kind(DescriptionKind kind, const std::filesystem::path& file, const ReadOptions& options) {
  switch (kind) {
    case DescriptionKind::adf:
      return read_adf(file, options);
    case DescriptionKind::urdf:
      return read_urdf(file, options);
    case DescriptionKind::sdf:
      return read_sdf(file, options);
    case DescriptionKind::mjcf:
      break;
  }
  return read_mjcf(file, options);
}

}  // namespace

Result<Model> read_description(const std::filesystem::path& file, const ReadOptions& options) {
  if (is_mesh_scene_name(file)) {
    if (!options.launch_indices.empty() || options.launch_all) return not_a_launch_file(file);
    return read_mesh_scene(file, options);
  }
  if (options.mesh_up || options.mesh_unit_m)
    return Error{quote(file.string()) + " is not a mesh file (OBJ, STL, PLY): remove --up and --unit"};
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {  // a model of Gazebo
    if (!options.launch_indices.empty() || options.launch_all) return not_a_launch_file(file);
    Result<Model> model = read_sdf(file, options);
    if (model) add_light_if_none(*model);
    return model;
  }
  const Result<std::string> text = read_text(file);
  if (!text) return text.error();
  const Result<DescriptionKind> kind = kind_of(file, *text);
  if (!kind) return kind.error();
  if (*kind != DescriptionKind::adf && (!options.launch_indices.empty() || options.launch_all))
    return not_a_launch_file(file);
  if (*kind == DescriptionKind::adf && options.is_confined)
    return Error{quote(file.string()) +
                 " is an AMBF description, whose files cannot be confined: leave --confined out"};
  Result<Model> model = read_kind(*kind, file, options);
  if (model) add_light_if_none(*model);
  return model;
}

}  // namespace fire3dv::convert
