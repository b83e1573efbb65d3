#include "tools/convert/mesh/repair.h"

#include <cmath>
#include <cstdint>

namespace fire3dv::convert {
namespace {

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

size_t leave_out_broken_triangles(Surface& surface) {
  const size_t vertices = surface.positions.size();
  const size_t before = surface.indices.size();
  size_t count = 0;
  for (size_t i = 0; i + 3 <= before; i += 3) {
    bool whole = true;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t v = surface.indices[i + k];
      whole = whole && v < vertices && finite(surface.positions[v]);
    }
    if (!whole) continue;
    for (size_t k = 0; k < 3; ++k) surface.indices[count++] = surface.indices[i + k];
  }
  surface.indices.resize(count);
  return (before + 2) / 3 - count / 3;
}

bool move_lost_vertices(Surface& surface) {
  const glm::vec3* somewhere = nullptr;
  for (const glm::vec3& position : surface.positions) {
    if (finite(position)) somewhere = &position;
    if (somewhere) break;
  }
  bool any = false;
  for (glm::vec3& position : surface.positions) {
    if (finite(position)) continue;
    position = somewhere ? *somewhere : glm::vec3(0);  // unreferenced vertex; it only must not extend the
                                                       // bounds
    any = true;
  }
  return any;
}

size_t mend_normals(Surface& surface) {
  std::vector<size_t> broken;
  for (size_t v = 0; v < surface.normals.size(); ++v) {
    glm::vec3& normal = surface.normals[v];
    const float length = finite(normal) ? glm::length(normal) : 0;
    if (std::abs(length - 1) <= 1e-5f) continue;
    if (length > 1e-6f && std::isfinite(length)) {
      normal /= length;
    } else {
      normal = glm::vec3(0);
      broken.push_back(v);
    }
  }
  if (broken.empty()) return 0;
  std::vector<bool> is_broken(surface.normals.size());
  for (const size_t v : broken) is_broken[v] = true;
  for (size_t i = 0; i + 3 <= surface.indices.size(); i += 3) {
    const uint32_t* corner = &surface.indices[i];
    if (!is_broken[corner[0]] && !is_broken[corner[1]] && !is_broken[corner[2]]) continue;
    const glm::vec3& a = surface.positions[corner[0]];
    const glm::vec3 twice_area =
        glm::cross(surface.positions[corner[1]] - a, surface.positions[corner[2]] - a);
    for (size_t k = 0; k < 3; ++k)
      if (is_broken[corner[k]]) surface.normals[corner[k]] += twice_area;
  }
  for (const size_t v : broken) {
    const float length = glm::length(surface.normals[v]);
    surface.normals[v] =
        length > 0 && std::isfinite(length) ? surface.normals[v] / length : glm::vec3(0, 0, 1);
  }
  return broken.size();
}

}  // namespace

std::string repair(Surface& surface) {
  std::string said;
  const auto say = [&](const std::string& what) { said += (said.empty() ? "" : ", ") + what; };
  if (const size_t lost = leave_out_broken_triangles(surface))
    say(std::to_string(lost) + " triangles without a place are left out");
  move_lost_vertices(surface);
  if (surface.normals.size() != surface.positions.size()) surface.normals.clear();
  if (surface.uvs.size() != surface.positions.size()) surface.uvs.clear();
  if (const size_t mended = mend_normals(surface))
    say(std::to_string(mended) + " normals without a direction are made from triangles");
  for (glm::vec2& uv : surface.uvs)
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = glm::vec2(0);
  return said;
}

}  // namespace fire3dv::convert
