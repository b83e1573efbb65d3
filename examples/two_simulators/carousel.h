// Geometry of the MuJoCo carousel, whose gondolas hang on chains: dimensions, rest poses and meshes.
// Independent of MuJoCo, so that the scene can be written without it. Metres, Z up.
#pragma once

#include <string>
#include <vector>

#include "examples/common/mesh.h"

namespace two_simulators {

constexpr int kChains = 6;
constexpr int kLinks = 5;  // links per chain, above its gondola
constexpr float kRotorZ_m = 0.52f;
constexpr float kArm_m = 0.21f;  // distance from the axis to the chains
constexpr float kArmDrop_m = 0.010f;
constexpr float kLink_m = 0.036f, kLinkRadius_m = 0.0042f;
constexpr float kGondolaRadius_m = 0.027f;

struct CarouselBody {
  std::string name;
  examples::Vec3 at_m;                // rest position in the carousel frame, without rotation
  std::vector<examples::Part> parts;  // in the body frame, Z up, metres
};

// Returns the rotor, then each chain from the top. A link's origin is its upper end, a gondola's its eyelet.
std::vector<CarouselBody> carousel_bodies();

// Static parts: foot, motor and pole, in the carousel frame.
std::vector<examples::Part> carousel_stand();

std::string link_name(int chain, int link);
std::string gondola_name(int chain);
constexpr const char* kRotorName = "carousel_rotor";

}  // namespace two_simulators
