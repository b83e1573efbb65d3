#include "renderer/scene/files.h"
#include "tools/convert/readers.h"

namespace fire3dv::convert {

Result<Model> read_mjcf(const std::filesystem::path& file, const ReadOptions&) {
  return Error{
      quote(file.string()) +
      " is MJCF, and this fire3dv-convert was built without MuJoCo: install libmujoco-dev and build again"};
}

}  // namespace fire3dv::convert
