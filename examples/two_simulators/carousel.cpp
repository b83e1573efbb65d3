#include "examples/two_simulators/carousel.h"

#include <array>
#include <cmath>

namespace two_simulators {
namespace {

using examples::Mesh, examples::Part, examples::Vec3;

Part cylinder(const char* material, float radius, float half_height, float z, float bevel) {
  return {examples::moved(examples::cylinder_mesh(radius, half_height, bevel), {0, 0, z}), material};
}

Mesh turned(Mesh mesh, float azimuth_rad) {
  const float c = std::cos(azimuth_rad), s = std::sin(azimuth_rad);
  const auto turn = [&](Vec3 a) { return Vec3{c * a.x - s * a.y, s * a.x + c * a.y, a.z}; };
  for (examples::Vertex& v : mesh.vertices)
    v.position = turn(v.position), v.normal = turn(v.normal), v.tangent = turn(v.tangent);
  return mesh;
}

float azimuth_of(int chain) {
  return 6.2831853f * static_cast<float>(chain) / kChains;
}

std::vector<Part> rotor_parts() {
  std::vector<Part> parts = {cylinder("brushed_metal", 0.034f, 0.026f, -0.004f, 0.004f),
                             cylinder("painted_orange", 0.150f, 0.005f, 0.016f, 0.003f),
                             cylinder("painted_white", 0.118f, 0.006f, 0.025f, 0.004f),
                             cylinder("painted_orange", 0.084f, 0.007f, 0.036f, 0.005f),
                             cylinder("painted_white", 0.050f, 0.008f, 0.049f, 0.006f),
                             {examples::moved(examples::capsule_mesh(0.020f, 0), {0, 0, 0.072f}), "gold"}};
  for (int chain = 0; chain < kChains; ++chain) {
    const Mesh arm = examples::moved(examples::box_mesh({(kArm_m - 0.02f) / 2, 0.006f, 0.006f}, 0.002f),
                                     {0.02f + (kArm_m - 0.02f) / 2, 0, 0.002f});
    const Mesh eye = examples::moved(examples::capsule_mesh(0.009f, 0.004f), {kArm_m, 0, -0.002f});
    parts.push_back({turned(arm, azimuth_of(chain)), "painted_graphite"});
    parts.push_back({turned(eye, azimuth_of(chain)), "gold"});
  }
  return parts;
}

std::vector<Part> link_parts() {
  return {
      {examples::moved(examples::capsule_mesh(kLinkRadius_m, kLink_m / 2 - 0.003f, 20), {0, 0, -kLink_m / 2}),
       "chrome"}};
}

std::vector<Part> gondola_parts(int chain) {
  constexpr std::array<const char*, kChains> kColors = {"plastic_red",   "plastic_yellow", "plastic_blue",
                                                        "plastic_green", "plastic_violet", "plastic_teal"};
  const float middle = -kGondolaRadius_m - 0.006f;
  return {{examples::moved(examples::capsule_mesh(kGondolaRadius_m, 0, 48), {0, 0, middle}),
           kColors[static_cast<size_t>(chain)]},
          cylinder("gold", kGondolaRadius_m + 0.003f, 0.003f, middle, 0.0015f),
          cylinder("gold", 0.008f, 0.006f, -0.006f, 0.002f)};
}

}  // namespace

std::string link_name(int chain, int link) {
  return "carousel_chain_" + std::to_string(chain) + "_link_" + std::to_string(link);
}

std::string gondola_name(int chain) {
  return "carousel_gondola_" + std::to_string(chain);
}

std::vector<CarouselBody> carousel_bodies() {
  std::vector<CarouselBody> bodies = {{kRotorName, {0, 0, kRotorZ_m}, rotor_parts()}};
  for (int chain = 0; chain < kChains; ++chain) {
    const float azimuth = azimuth_of(chain);
    Vec3 at{kArm_m * std::cos(azimuth), kArm_m * std::sin(azimuth), kRotorZ_m - kArmDrop_m};
    for (int link = 0; link < kLinks; ++link) {
      bodies.push_back({link_name(chain, link), at, link_parts()});
      at.z -= kLink_m;
    }
    bodies.push_back({gondola_name(chain), at, gondola_parts(chain)});
  }
  return bodies;
}

std::vector<Part> carousel_stand() {
  const float pole_half = (kRotorZ_m - 0.12f) / 2;
  return {cylinder("wood_dark", 0.150f, 0.012f, 0.012f, 0.005f),
          cylinder("painted_graphite", 0.062f, 0.040f, 0.064f, 0.008f),
          cylinder("brushed_metal", 0.050f, 0.008f, 0.110f, 0.003f),
          cylinder("brushed_metal", 0.013f, pole_half, 0.115f + pole_half, 0.002f)};
}

}  // namespace two_simulators
