#include "renderer/dataset/randomize/settle.h"

namespace fire3dv::dataset {

Result<std::vector<RestingBody>> settle(const FixedTriangles&, std::span<const FallingBody>) {
  return Error{
      "settle needs Bullet, which this build lacks: install it (Debian: libbullet-dev) and build again"};
}

}  // namespace fire3dv::dataset
