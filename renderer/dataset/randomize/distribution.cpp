#include "renderer/dataset/randomize/distribution.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fire3dv::dataset {
namespace {

// SplitMix64: each step is a bijection whose output passes the usual tests of randomness.
constexpr uint64_t kStep = 0x9E3779B97F4A7C15;
uint64_t mix(uint64_t value) {
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EB;
  return value ^ (value >> 31);
}

// FNV-1a.
uint64_t hash_of(std::string_view text) {
  uint64_t hash = 0xCBF29CE484222325;
  for (const char c : text) hash = (hash ^ static_cast<uint8_t>(c)) * 0x100000001B3;
  return hash;
}

constexpr double kDegree = std::numbers::pi / 180;

}  // namespace

ParameterDraw::ParameterDraw(uint64_t seed, uint64_t frame, std::string_view parameter)
    : state_(mix(mix(mix(seed + kStep) ^ (frame + kStep)) ^ hash_of(parameter))) {}

uint64_t ParameterDraw::next() {
  state_ += kStep;
  return mix(state_);
}

double ParameterDraw::unit() {
  return static_cast<double>(next() >> 11) * 0x1p-53;
}

double ParameterDraw::number(const Distribution& of) {
  const auto between = [&](double low, double high) { return low + (high - low) * unit(); };
  switch (of.kind) {
    case Distribution::Kind::constant:
      return of.low;
    case Distribution::Kind::uniform:
      return between(of.low, of.high);
    case Distribution::Kind::log_uniform:
      return std::clamp(std::exp(between(std::log(of.low), std::log(of.high))), of.low, of.high);
    case Distribution::Kind::normal: {
      const double radius = std::sqrt(-2 * std::log(1 - unit()));
      const double value = of.low + of.high * radius * std::cos(2 * std::numbers::pi * unit());
      return std::clamp(value, of.least, of.most);
    }
    case Distribution::Kind::elevation: {
      const double height = between(std::sin(of.low * kDegree), std::sin(of.high * kDegree));
      return std::clamp(std::asin(std::clamp(height, -1.0, 1.0)) / kDegree, of.low, of.high);
    }
    case Distribution::Kind::choice:
      return of.choices[index(of.choices.size())];
  }
  return of.low;
}

glm::dvec3 ParameterDraw::vector(const VectorDistribution& of) {
  if (!of.choices.empty()) return of.choices[index(of.choices.size())];
  glm::dvec3 value(0);
  for (int i = 0; i < 3; ++i) value[i] = number(of.parts[static_cast<size_t>(i)]);
  return value;
}

// Shoemake, Graphics Gems III.
glm::dquat ParameterDraw::rotation() {
  const double share = unit(), first = 2 * std::numbers::pi * unit(), second = 2 * std::numbers::pi * unit();
  const double a = std::sqrt(1 - share), b = std::sqrt(share);
  return glm::dquat(b * std::cos(second), a * std::sin(first), a * std::cos(first), b * std::sin(second));
}

void add_noise(std::vector<uint8_t>& rgba8, double deviation, uint64_t seed, uint64_t image) {
  ParameterDraw draw(seed, image, "pixels");
  // A uniform number of 0 to 65535 has a variance of 65536^2 / 12, and four have twice the deviation of one.
  const double scale = deviation * std::sqrt(3.0) / 65536;
  constexpr double kMeanOfFour = 2 * 65535.0;
  for (size_t i = 0; i < rgba8.size(); ++i) {
    if (i % 4 == 3) continue;
    const uint64_t bits = draw.next();
    const double four =
        static_cast<double>((bits & 0xFFFF) + (bits >> 16 & 0xFFFF) + (bits >> 32 & 0xFFFF) + (bits >> 48));
    const double value = rgba8[i] + std::round((four - kMeanOfFour) * scale);
    rgba8[i] = static_cast<uint8_t>(std::clamp(value, 0.0, 255.0));
  }
}

}  // namespace fire3dv::dataset
