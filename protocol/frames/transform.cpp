#include "protocol/frames/transform.h"

namespace fire3dv::frames {

// The largest component of the quaternion comes from the diagonal, so that the division is stable.
Transform transform_of(const std::array<double, 12>& matrix) {
  const auto m = [&](size_t row, size_t column) { return matrix[4 * row + column]; };
  Transform t;
  t.translation = {m(0, 3), m(1, 3), m(2, 3)};
  const double trace = m(0, 0) + m(1, 1) + m(2, 2);
  if (trace > 0) {
    t.rotation = {m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1), 1 + trace};
  } else {
    const size_t i = m(0, 0) >= m(1, 1) && m(0, 0) >= m(2, 2) ? 0 : m(1, 1) >= m(2, 2) ? 1 : 2;
    const size_t j = (i + 1) % 3, k = (i + 2) % 3;
    t.rotation[i] = 1 + m(i, i) - m(j, j) - m(k, k);
    t.rotation[j] = m(i, j) + m(j, i);
    t.rotation[k] = m(i, k) + m(k, i);
    t.rotation[3] = m(k, j) - m(j, k);
  }
  t.rotation = normalized(t.rotation);
  return t;
}

}  // namespace fire3dv::frames
