// Scenes that several tests of light share.
#pragma once

#include <cstdint>

#include "renderer/scene/model/scene.h"

namespace fire3dv::test {

// Camera inside of a sphere of radius 1, albedo 0.5, with a lamp of 10 cd in its middle. segments: about the
// axis of the sphere.
scene::Scene integrating_sphere(uint32_t segments);

// A matte ball on a floor, under a sun.
scene::Scene lit_ball();

}  // namespace fire3dv::test
