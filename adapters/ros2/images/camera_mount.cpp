#include "adapters/ros2/images/camera_mount.h"

#include <array>
#include <cstddef>

namespace fire3dv::ros2 {
namespace {

Matrix34 matrix_in_doubles(const Transform& t) {
  const auto [x, y, z, w] = normalized(t.rotation);
  return {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),     t.translation[0],
          2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),     t.translation[1],
          2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y), t.translation[2]};
}

// Inverse of any affine matrix; empty: it has none.
std::optional<Matrix34> inverse_of(const Pose& pose) {
  std::array<double, 12> m{};
  for (size_t i = 0; i < m.size(); ++i) m[i] = static_cast<double>(pose[i]);
  const auto minor = [&](size_t a, size_t b, size_t c, size_t d) { return m[a] * m[d] - m[b] * m[c]; };
  const double c0 = minor(5, 6, 9, 10), c1 = minor(4, 6, 8, 10), c2 = minor(4, 5, 8, 9);
  const double determinant = m[0] * c0 - m[1] * c1 + m[2] * c2;
  if (determinant == 0) return std::nullopt;
  Matrix34 inverse{c0,  -minor(1, 2, 9, 10), minor(1, 2, 5, 6),  0,
                   -c1, minor(0, 2, 8, 10),  -minor(0, 2, 4, 6), 0,
                   c2,  -minor(0, 1, 8, 9),  minor(0, 1, 4, 5),  0};
  for (double& value : inverse) value /= determinant;
  for (size_t row = 0; row < 3; ++row)
    inverse[4 * row + 3] =
        -(inverse[4 * row] * m[3] + inverse[4 * row + 1] * m[7] + inverse[4 * row + 2] * m[11]);
  return inverse;
}

}  // namespace

std::optional<CameraMount> find_camera_mount(const FrameBuffer& buffer, const StreamedFrames& streamed,
                                             const std::string& frame) {
  CameraMount mount;
  FrameId at = buffer.find(frame);
  // A loop of frames has no end.
  for (size_t steps = 0; at != kNoFrame && steps <= buffer.frames().size(); ++steps) {
    const Frame& current = buffer.frames()[at];
    const std::string node = current.name.starts_with(streamed.frame_prefix)
                                 ? current.name.substr(streamed.frame_prefix.size())
                                 : std::string();
    if (!node.empty() && streamed.has_node(node)) {
      mount.node = streamed.name_of(node);
      mount.node_may_be_missing = streamed.nodes_are_all_frames;
      if (const Pose* const offset = streamed.offset_of(node)) {
        const auto node_from_body = inverse_of(*offset);
        if (!node_from_body) return std::nullopt;
        mount.node_from_frame = multiply(*node_from_body, mount.node_from_frame);
      }
      return mount;
    }
    if (at == streamed.fixed) return mount;
    if (!current.is_static || current.samples.empty()) return std::nullopt;
    const FrameSample& sample = current.samples.back();
    mount.node_from_frame = multiply(matrix_in_doubles(sample.parent_from_frame), mount.node_from_frame);
    at = sample.parent;
  }
  return std::nullopt;
}

}  // namespace fire3dv::ros2
