#include "tools/convert/mesh/surface_builder.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

namespace fire3dv::convert {
namespace {

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

uint64_t mixed(uint64_t hash, float value) {
  return (hash ^ std::bit_cast<uint32_t>(value)) * 0x9e3779b97f4a7c15ull;
}

uint64_t hash_of(const SurfaceBuilder::Corner& c) {
  uint64_t hash = 0;
  for (const float f :
       {c.position.x, c.position.y, c.position.z, c.normal.x, c.normal.y, c.normal.z, c.uv.x, c.uv.y}) {
    hash = mixed(hash, f);
    hash ^= hash >> 29;
  }
  return hash;
}

bool unit_length(glm::vec3& normal) {
  const glm::dvec3 wide(normal);
  const double length = glm::length(wide);
  if (!(length > 1e-20) || !std::isfinite(length)) return false;
  normal = glm::vec3(wide / length);
  return true;
}

}  // namespace

bool SurfaceBuilder::add(const Corner& a, const Corner& b, const Corner& c) {
  if (!finite(a.position) || !finite(b.position) || !finite(c.position)) return false;
  Corner corners[] = {a, b, c};
  if (normals_) {
    glm::vec3 flat(glm::cross(glm::dvec3(b.position) - glm::dvec3(a.position),
                              glm::dvec3(c.position) - glm::dvec3(a.position)));
    if (!unit_length(flat)) flat = {0, 0, 1};  // degenerate triangle, never visible
    for (Corner& corner : corners)
      if (!unit_length(corner.normal)) corner.normal = flat;
  }
  for (const Corner& corner : corners) surface_.indices.push_back(vertex(corner));
  return true;
}

uint32_t SurfaceBuilder::vertex(const Corner& corner) {
  if (surface_.positions.size() * 2 >= table_.size()) grow();
  const size_t mask = table_.size() - 1;
  for (size_t place = hash_of(corner) & mask;; place = (place + 1) & mask) {
    const uint32_t known = table_[place];
    if (known == 0) {
      surface_.positions.push_back(corner.position);
      if (normals_) surface_.normals.push_back(corner.normal);
      if (uvs_) surface_.uvs.push_back(corner.uv);
      return (table_[place] = static_cast<uint32_t>(surface_.positions.size())) - 1;
    }
    const uint32_t v = known - 1;
    if (surface_.positions[v] == corner.position && (!normals_ || surface_.normals[v] == corner.normal) &&
        (!uvs_ || surface_.uvs[v] == corner.uv)) {
      return v;
    }
  }
}

void SurfaceBuilder::grow() {
  table_.assign(std::max<size_t>(64, table_.size() * 2), 0);
  const size_t mask = table_.size() - 1;
  for (uint32_t v = 0; v < surface_.positions.size(); ++v) {
    const Corner corner{surface_.positions[v], normals_ ? surface_.normals[v] : glm::vec3(0),
                        uvs_ ? surface_.uvs[v] : glm::vec2(0)};
    size_t place = hash_of(corner) & mask;
    while (table_[place] != 0) place = (place + 1) & mask;
    table_[place] = v + 1;
  }
}

Surface SurfaceBuilder::take() {
  table_.clear();
  return std::exchange(surface_, {});
}

}  // namespace fire3dv::convert
