// Reader for SDF in builds without libsdformat.
#include "convert/model.h"
#include "convert/readers.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {

Result<Model> read_sdf(const std::filesystem::path& file, const ReadOptions&) {
  return Error{
      quote(file.string()) +
      " is SDF, which this build does not read: it was built without libsdformat 12 (libsdformat-dev of "
      "Debian 12). Export the model as URDF or glTF, or build with libsdformat"};
}

}  // namespace fire3dv::convert
