// Fixture of tests of markers: a grey block before a black background, seen by a pinhole camera in which a
// point (x, y, -z) lies at the pixel (32 + 100 x / z, 24 - 100 y / z), whose centre is a whole number.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {

using wire::Marker;
using wire::MarkerKind;

constexpr VkExtent2D kExtent{65, 49};
constexpr uint32_t kCx = 32, kCy = 24;

// A grey block whose front is at z = -2, at the right half of the image.
inline scene::Scene block() {
  SceneBuilder builder;
  builder.mesh_node("block", builder.box(builder.material(matte({0.5f, 0.5f, 0.5f})), {0.5f, 2, 0.5f}),
                    at({0.6f, 0, -2.5f}));
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({0, 0, -1}));
  return builder.build();
}

// Largest difference of a channel from the column first_x on. Samples of pixels around forward-only draws are
// rounded to halves before they are tone-mapped: 1 is possible there.
inline int largest_difference(const sinks::FrameImage& a, const sinks::FrameImage& b, uint32_t first_x = 0) {
  int largest = 0;
  for (size_t i = 0; i < a.rgba8.size(); ++i)
    if (i / 4 % kExtent.width >= first_x) largest = std::max(largest, std::abs(a.rgba8[i] - b.rgba8[i]));
  return largest;
}

class MarkerTest : public ValidationIsSilent, public testing::WithParamInterface<settings::RasterPath> {
 protected:
  static settings::DrawSettings settings() {
    settings::DrawSettings settings;
    settings.raster = GetParam();
    settings.post.fxaa = false;
    settings.background.color = glm::vec3(0);
    return settings;
  }
  static passes::View view() {
    passes::Intrinsics camera;
    camera.fx_px = camera.fy_px = 100;
    camera.cx_px = kCx;
    camera.cy_px = kCy;
    camera.image_px = {kExtent.width, kExtent.height};
    return passes::make_view(camera, glm::mat4(1));
  }
  void show(Marker marker, const glm::mat4& world_from_marker = glm::mat4(1)) {
    shown_.push_back({++id_, std::make_shared<const Marker>(std::move(marker)), world_from_marker});
  }
  sinks::FrameImage draw() {
    bench_.set_markers(&shown_);
    return bench_.draw(poses_, view());
  }
  // Draws one marker.
  sinks::FrameImage draw(Marker marker, const glm::mat4& world_from_marker = glm::mat4(1)) {
    shown_.clear();
    show(std::move(marker), world_from_marker);
    return draw();
  }

  const scene::Scene scene_ = block();
  state::PoseState poses_{scene_};
  RenderBench bench_{scene_, kExtent, settings()};
  std::vector<state::ShownMarker> shown_;
  uint64_t id_ = 0;
};

}  // namespace fire3dv::test
