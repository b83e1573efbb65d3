// Portable random numbers: distributions of the standard library differ between implementations.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace fire3dv::bench {

// SplitMix64. Each generated object has its own seed, so that the order of generation does not matter.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t bits() {
    uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  float uniform(float low, float high) {
    return low + (high - low) * static_cast<float>(static_cast<double>(bits() >> 11) * 0x1p-53);
  }
  glm::vec3 direction() {
    const float y = uniform(-1, 1), phi = uniform(0, 6.28318531f);
    const float r = std::sqrt(std::max(0.0f, 1 - y * y));
    return {r * std::cos(phi), y, r * std::sin(phi)};
  }

 private:
  uint64_t state_;
};

}  // namespace fire3dv::bench
