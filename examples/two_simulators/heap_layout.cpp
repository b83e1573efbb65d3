#include <array>
#include <cmath>
#include <cstdio>

#include "examples/common/object.h"
#include "examples/two_simulators/heap.h"

namespace two_simulators {
namespace {

using examples::Object, examples::Shape, examples::Size;

constexpr float kPi = 3.14159265f;
constexpr float kTrayFloor_m = 0.012f, kTrayRadius_m = 0.285f;
constexpr std::array<const char*, 6> kColors = {"plastic_red",   "plastic_yellow", "plastic_blue",
                                                "plastic_green", "plastic_violet", "plastic_teal"};

class Layout {
 public:
  // Octagonal tray of planks on a disc.
  void tray() {
    add("heap_tray", Shape::cylinder, {kTrayRadius_m, 0, kTrayFloor_m / 2}, 0, "wood",
        {{0, 0, kTrayFloor_m / 2}, 0});
    const float half_length = kTrayRadius_m * std::tan(kPi / 8) + 0.006f;
    for (int side = 0; side < 8; ++side) {
      const float azimuth = kPi / 4 * static_cast<float>(side);
      add(numbered("heap_wall", side), Shape::box, {half_length, 0.007f, 0.028f}, 0, "wood_dark",
          {{kTrayRadius_m * std::cos(azimuth), kTrayRadius_m * std::sin(azimuth), 0.028f},
           azimuth + kPi / 2});
    }
  }

  // Pyramid of 16 + 9 + 4 + 1 boxes.
  void pyramid(float x, float y) {
    constexpr float kHalf = 0.019f, kPitch = 0.0395f;
    for (int layer = 0; layer < 4; ++layer) {
      const int side = 4 - layer;
      const float middle = static_cast<float>(side - 1) / 2;
      for (int i = 0; i < side * side; ++i) {
        add(numbered("heap_box", boxes_), Shape::box, {kHalf, kHalf, kHalf}, 0.05f,
            kColors[static_cast<size_t>(boxes_ + layer) % kColors.size()],
            {{x + (static_cast<float>(i % side) - middle) * kPitch + jitter(),
              y + (static_cast<float>(i / side) - middle) * kPitch + jitter(),
              kTrayFloor_m + kHalf * static_cast<float>(2 * layer + 1)},
             20 * jitter()});
        ++boxes_;
      }
    }
  }

  // Three cans and one on top.
  void cans(float x, float y) {
    constexpr float kRadius = 0.020f, kHalf = 0.029f;
    for (int i = 0; i < 4; ++i) {
      const float azimuth = 2 * kPi / 3 * static_cast<float>(i) + 0.4f, out = i < 3 ? 0.0245f : 0.0f;
      add(numbered("heap_can", cans_++), Shape::cylinder, {kRadius, 0, kHalf}, 0.06f,
          i % 2 == 0 ? "painted_teal" : "plastic_red",
          {{x + out * std::cos(azimuth), y + out * std::sin(azimuth),
            kTrayFloor_m + kHalf * (i < 3 ? 1.0f : 3.0f)},
           40 * jitter()});
    }
  }

  // Three touching balls, and one in the hollow between them.
  void balls(float x, float y) {
    constexpr float kRadius = 0.021f;
    constexpr std::array<const char*, 4> kMetals = {"gold", "copper", "chrome", "gold"};
    for (int i = 0; i < 4; ++i) {
      const float azimuth = 2 * kPi / 3 * static_cast<float>(i) + 1, out = i < 3 ? kRadius * 1.16f : 0.0f;
      add(numbered("heap_ball", balls_++), Shape::sphere, {kRadius, 0, 0}, 0.08f,
          kMetals[static_cast<size_t>(i)],
          {{x + out * std::cos(azimuth), y + out * std::sin(azimuth),
            kTrayFloor_m + kRadius * (i < 3 ? 1.0f : 2.64f)},
           0});
    }
  }

  std::vector<Object> take() { return std::move(objects_); }

 private:
  struct Place {
    examples::Vec3 at;
    float azimuth;
  };
  // Position noise against perfect symmetry.
  float jitter() { return random_.uniform(-0.0004f, 0.0004f); }

  static std::string numbered(const char* what, int number) {
    char name[32];
    std::snprintf(name, sizeof name, "%s_%02d", what, number);
    return name;
  }
  void add(std::string name, Shape shape, Size size, float mass_kg, const char* material, Place place) {
    objects_.push_back({std::move(name), shape, size, mass_kg, material,
                        btTransform(btQuaternion(btVector3(0, 0, 1), place.azimuth),
                                    btVector3(place.at.x, place.at.y, place.at.z))});
  }

  examples::Random random_{11};
  std::vector<Object> objects_;
  int boxes_ = 0, cans_ = 0, balls_ = 0;
};

}  // namespace

std::vector<Object> heap_layout() {
  Layout layout;
  layout.tray();
  layout.pyramid(0, -0.152f);
  layout.pyramid(0, 0.152f);
  for (const float side : {-1.0f, 1.0f}) {
    layout.cans(side * 0.135f, side * 0.105f);
    layout.balls(side * 0.135f, side * -0.105f);
  }
  return layout.take();
}

}  // namespace two_simulators
