// MuJoCo's half as a thing: a carousel whose gondolas hang on chains. How it is built, where its bodies are
// at rest, and how they look. Knows nothing of MuJoCo, so that the scene can be written without it.
#pragma once

#include <string>
#include <vector>

#include "examples/common/mesh.h"

namespace two_simulators {

constexpr int kChains = 6;
constexpr int kLinks = 5;  // of a chain, above its gondola
constexpr float kRotorZ_m = 0.52f;
constexpr float kArm_m = 0.21f;  // from the axis to where a chain hangs
constexpr float kArmDrop_m = 0.010f;
constexpr float kLink_m = 0.036f, kLinkRadius_m = 0.0042f;
constexpr float kGondolaRadius_m = 0.027f;

struct CarouselBody {
  std::string name;
  examples::Vec3 at_m;                // at rest, in the carousel's frame; no body is turned there
  std::vector<examples::Part> parts;  // in the body's frame, Z up, metres
};

// The rotor first, then chain by chain from the top; a link's origin is its upper end, a gondola's its eye.
std::vector<CarouselBody> carousel_bodies();

// What stands still: foot, motor and pole, in the carousel's frame.
std::vector<examples::Part> carousel_stand();

std::string link_name(int chain, int link);
std::string gondola_name(int chain);
constexpr const char* kRotorName = "carousel_rotor";

}  // namespace two_simulators
