#include "renderer/scene/files.h"
#include "tools/convert/readers.h"

namespace fire3dv::convert {

Result<Model> read_adf(const std::filesystem::path& file, const ReadOptions&) {
  return Error{scene::quote(file.string()) +
               " is an AMBF description, which this fire3dv-convert cannot read"};
}

}  // namespace fire3dv::convert
