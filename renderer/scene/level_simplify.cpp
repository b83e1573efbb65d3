#include "renderer/scene/level_simplify.h"

#include <meshoptimizer.h>

#include <algorithm>

namespace fire3dv::scene {
namespace {

// A level that has more triangles than this share of the finer one costs more than it saves.
constexpr double kWorthwhile = 0.85, kGood = 0.7;

std::vector<uint32_t> simplify(std::span<const uint32_t> indices, std::span<const glm::vec3> positions) {
  std::vector<uint32_t> out(indices.size());
  const size_t target = indices.size() / 6 * 3;
  // No limit on the error: it is measured afterwards, and a level with a large one is for the far distance.
  const size_t count =
      meshopt_simplify(out.data(), indices.data(), indices.size(), &positions.data()->x, positions.size(),
                       sizeof(glm::vec3), target, 1e6f, meshopt_SimplifyLockBorder, nullptr);
  out.resize(count);
  return out;
}

bool is_at_most(const std::vector<uint32_t>& simplified, const SurfacePiece& piece, double share) {
  return !simplified.empty() &&
         static_cast<double>(simplified.size()) <= share * static_cast<double>(piece.indices.size());
}

// Where many attributes meet at a place, as on flat-shaded meshes, nothing can be taken away without mixing them. So
// places alone are simplified, and each corner then takes the vertex there whose normal suits its triangle.
std::vector<uint32_t> simplify_places(const SurfacePiece& piece, std::span<const uint32_t> place) {
  const auto count = static_cast<uint32_t>(place.size());
  std::vector<uint32_t> by_place(count), first_of(count);
  for (uint32_t v = 0; v < count; ++v) by_place[v] = v;
  std::stable_sort(by_place.begin(), by_place.end(), [&](uint32_t a, uint32_t b) { return place[a] < place[b]; });
  for (uint32_t i = 0; i < count; ++i) {
    const bool same = i > 0 && place[by_place[i]] == place[by_place[i - 1]];
    first_of[by_place[i]] = same ? first_of[by_place[i - 1]] : i;
  }
  std::vector<uint32_t> welded;
  welded.reserve(piece.indices.size());
  for (uint32_t index : piece.indices) welded.push_back(by_place[first_of[index]]);
  std::vector<uint32_t> out = simplify(welded, piece.positions);
  for (size_t t = 0; t + 2 < out.size(); t += 3) {
    const glm::vec3 a = piece.positions[out[t]], b = piece.positions[out[t + 1]], c = piece.positions[out[t + 2]];
    const glm::vec3 normal = glm::cross(b - a, c - a);
    for (size_t corner = t; corner < t + 3; ++corner) {
      uint32_t best = out[corner];
      for (uint32_t i = first_of[best]; i < count && place[by_place[i]] == place[best]; ++i) {
        const uint32_t other = by_place[i];
        if (glm::dot(piece.attributes[other]->normal, normal) > glm::dot(piece.attributes[best]->normal, normal))
          best = other;
      }
      out[corner] = best;
    }
  }
  return out;
}

}  // namespace

std::vector<uint32_t> simplify_to_half(const SurfacePiece& piece, std::span<const uint32_t> place) {
  std::vector<uint32_t> out = simplify(piece.indices, piece.positions);
  if (is_at_most(out, piece, kGood)) return out;
  std::vector<uint32_t> by_places = simplify_places(piece, place);
  if (!by_places.empty() && (out.empty() || by_places.size() < out.size())) out = std::move(by_places);
  if (!is_at_most(out, piece, kWorthwhile)) out.clear();
  return out;
}

}  // namespace fire3dv::scene
