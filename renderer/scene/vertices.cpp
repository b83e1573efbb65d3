#include "renderer/scene/vertices.h"

namespace fire3dv::scene {
namespace {

template <typename T>
void copy_each(std::vector<T>& values, std::span<const uint32_t> copied) {
  std::vector<T> copies;
  copies.reserve(copied.size());
  for (const uint32_t from : copied) copies.push_back(values[from]);
  values = std::move(copies);
}

}  // namespace

void copy_vertices(Vertices& vertices, std::span<const uint32_t> copied) {
  copy_each(vertices.positions, copied);
  copy_each(vertices.attributes, copied);
  if (vertices.source.empty()) {
    vertices.source.assign(copied.begin(), copied.end());
  } else {
    copy_each(vertices.source, copied);
  }
}

}  // namespace fire3dv::scene
