#include "examples/soft_tissue/scene_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <span>
#include <utility>

#include "examples/common/gltf_writer.h"
#include "examples/common/materials.h"
#include "examples/common/scene_builder.h"

namespace soft_tissue {

using namespace examples;

namespace {

constexpr const char* kNames[kInstruments] = {"grasper", "upper jaw", "lower jaw", "blade"};

// Value noise in layers, of period 1 in both directions. 0 to 1.
float noise(float u, float v, int cells, int layers) {
  const auto hash = [](int x, int y, int salt) {
    uint32_t h = static_cast<uint32_t>(x) * 0x9e3779b1u ^ static_cast<uint32_t>(y) * 0x85ebca77u ^
                 static_cast<uint32_t>(salt) * 0xc2b2ae3du;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 13)) * 0x297a2d39u;
    return static_cast<float>((h ^ (h >> 16)) >> 8) / 16777216.0f;
  };
  float sum = 0, weight = 0.5f, total = 0;
  for (int layer = 0; layer < layers; ++layer, cells *= 2, weight *= 0.55f) {
    const float x = u * static_cast<float>(cells), y = v * static_cast<float>(cells);
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    const auto fade = [](float t) { return t * t * (3 - 2 * t); };
    const float tx = fade(x - static_cast<float>(x0)), ty = fade(y - static_cast<float>(y0));
    const auto at = [&](int i, int j) { return hash((x0 + i) % cells, (y0 + j) % cells, layer); };
    const float low = at(0, 0) + (at(1, 0) - at(0, 0)) * tx, high = at(0, 1) + (at(1, 1) - at(0, 1)) * tx;
    sum += weight * (low + (high - low) * ty);
    total += weight;
  }
  return sum / total;
}

struct Textures {
  std::vector<uint8_t> capsule, parenchyma, bumps;
};

// Colours of the capsule and of fresh tissue, and a normal map of fine bumps. Made once.
const std::optional<Textures>& textures() {
  static const std::optional<Textures> made = []() -> std::optional<Textures> {
    constexpr int kSide = 256;
    constexpr auto kTexels = static_cast<size_t>(kSide);
    Image capsule{kSide, kSide, {}}, parenchyma{kSide, kSide, {}}, bumps{kSide, kSide, {}};
    std::vector<float> heights(kTexels * kTexels);
    const auto byte = [](float x) {
      return static_cast<uint8_t>(std::lround(255 * std::clamp(x, 0.0f, 1.0f)));
    };
    for (size_t i = 0; i < heights.size(); ++i) {
      const float u = static_cast<float>(i % kTexels) / kSide, v = static_cast<float>(i / kTexels) / kSide;
      const float patches = noise(u, v, 4, 4), grain = noise(u, v, 32, 3);
      const float vein = std::clamp(1 - 14 * std::abs(noise(v, u, 5, 3) - 0.5f), 0.0f, 1.0f);
      heights[i] = 0.55f * noise(u, v, 14, 4) + 0.18f * grain;
      const float bright = 0.72f + 0.45f * patches + 0.12f * grain - 0.10f * vein;
      for (const float c :
           {0.43f * bright, 0.135f * bright + 0.02f * patches, 0.115f * bright + 0.015f * vein})
        capsule.rgb.push_back(byte(c));
      const float wet = 0.7f + 0.6f * noise(u, v, 9, 4);
      for (const float c : {0.56f * wet, 0.10f * wet, 0.085f * wet}) parenchyma.rgb.push_back(byte(c));
    }
    for (size_t i = 0; i < heights.size(); ++i) {
      const size_t column = i % kTexels, row = i / kTexels;
      const auto at = [&](size_t x, size_t y) { return heights[(y % kTexels) * kTexels + x % kTexels]; };
      const float x = 2.6f * (at(column + kTexels - 1, row) - at(column + 1, row));
      const float y = 2.6f * (at(column, row + 1) - at(column, row + kTexels - 1));
      const float length = std::sqrt(x * x + y * y + 1);
      for (const float c : {x / length, y / length, 1 / length}) bumps.rgb.push_back(byte(0.5f + 0.5f * c));
    }
    auto a = encode_png(capsule), b = encode_png(parenchyma), c = encode_png(bumps);
    if (!a || !b || !c) return std::nullopt;
    return Textures{std::move(*a), std::move(*b), std::move(*c)};
  }();
  return made;
}

Mesh joined(std::vector<Mesh> parts) {
  Mesh all;
  for (Mesh& part : parts) {
    const auto first = static_cast<uint32_t>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), part.vertices.begin(), part.vertices.end());
    for (const uint32_t i : part.indices) all.indices.push_back(first + i);
  }
  return all;
}

// A jaw or blade along Z from the tip: a bevelled bar.
Mesh bar(Vec3 half, Vec3 at) {
  return moved(box_mesh(half, 0.4f * std::min({half.x, half.y, half.z})), at);
}

GltfMatrix matrix(const std::array<float, 12>& pose) {
  return pose;
}

GltfMatrix looking_at(Vec3 eye, Vec3 target) {
  const Vec3 z = normalized(eye - target), x = normalized(cross({0, 1, 0}, z)), y = cross(z, x);
  return {x.x, y.x, z.x, eye.x, x.y, y.y, z.y, eye.y, x.z, y.z, z.z, eye.z};
}

void add_tissue(GltfWriter& writer, const Surface& surface) {
  const Textures& images = *textures();
  const size_t bumps = writer.add_texture("bumps", images.bumps);
  const auto material = [&](const char* name, const std::vector<uint8_t>& color, float roughness) {
    GltfMaterial made;
    made.name = name;
    made.roughness = roughness;
    made.base_color_texture = writer.add_texture(name, color);
    made.normal_texture = bumps;
    made.ior = 1.4f;
    return writer.add_material(made);
  };
  const std::array parts = {
      GltfWriter::Primitive{&surface.outside, material("capsule", images.capsule, 0.3f), 1},
      GltfWriter::Primitive{&surface.inside, material("parenchyma", images.parenchyma, 0.24f), 1}};
  const size_t mesh = writer.add_mesh("tissue", parts);
  for (const bool second : {false, true})
    writer.add_node({kTissue[second ? 1 : 0], copy_pose(!second, {0, 0, 0}), mesh, {}, {}});
}

void add_code(GltfWriter& writer) {
  Mesh square;
  const std::vector<float> corners = code_corners({0, 0, 0});
  for (size_t i = 0; i + 2 < corners.size(); i += 3) {
    Vertex vertex;
    vertex.position = {corners[i], corners[i + 1], corners[i + 2]};
    vertex.normal = {0, 1, 0};
    vertex.tangent = {1, 0, 0};
    square.vertices.push_back(vertex);
  }
  square.indices = {0, 2, 1, 0, 3, 2};
  GltfMaterial green;
  green.name = "code";
  green.base_color = {0, 0, 0};
  green.emissive = {0, 1, 0};
  const GltfWriter::Primitive part{&square, writer.add_material(green), 1};
  const size_t mesh = writer.add_mesh("code", std::span(&part, 1));
  for (const bool second : {false, true})
    writer.add_node({kCode[second ? 1 : 0], copy_pose(!second, {0, 0, 0}), mesh, {}, {}});
}

std::optional<std::string> save(const std::vector<std::byte>& bytes, const std::string& path) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (!file) return "cannot write " + path + ": name a file in a folder you own";
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  if (std::fclose(file) != 0 || !written) return "cannot write all of " + path;
  return std::nullopt;
}

}  // namespace

std::vector<std::string> body_names(bool frame_code) {
  std::vector<std::string> names(std::begin(kNames), std::end(kNames));
  names.insert(names.end(), std::begin(kTissue), std::end(kTissue));
  if (frame_code) names.insert(names.end(), std::begin(kCode), std::end(kCode));
  return names;
}

std::array<float, 12> copy_pose(bool shown, const std::array<float, 3>& offset) {
  if (!shown) return {1, 0, 0, 0, 0, 1, 0, -0.3f, 0, 0, 1, 0};
  return {1, 0, 0, offset[0], 0, 1, 0, offset[1], 0, 0, 1, offset[2]};
}

std::optional<std::string> write_scene(const Simulation& simulation, bool frame_code,
                                       const std::string& path) {
  if (!textures()) return "the scene's textures could not be encoded: libpng refused";
  GltfWriter writer;
  const size_t steel = writer.add_material({"steel", {0.62f, 0.63f, 0.65f}, 1, 0.28f, {0, 0, 0}, {}, {}, {}});
  const size_t dark =
      writer.add_material({"dark metal", {0.10f, 0.10f, 0.11f}, 1, 0.42f, {0, 0, 0}, {}, {}, {}});
  const size_t drape =
      writer.add_material({"drape", {0.035f, 0.13f, 0.135f}, 0, 0.85f, {0, 0, 0}, {}, {}, {}});
  const size_t pad = writer.add_material({"pad", {0.62f, 0.60f, 0.55f}, 0, 0.7f, {0, 0, 0}, {}, {}, {}});

  Mesh ground = y_up(floor_mesh(0.9f));
  const size_t ground_mesh = writer.add_mesh("drape", std::array{GltfWriter::Primitive{&ground, drape, 1}});
  writer.add_node({"drape", {1, 0, 0, 0, 0, 1, 0, -0.016f, 0, 0, 1, 0}, ground_mesh, {}, {}});
  Mesh cushion = box_mesh({0.13f, 0.008f, 0.10f}, 0.006f);
  const size_t cushion_mesh = writer.add_mesh("pad", std::array{GltfWriter::Primitive{&cushion, pad, 1}});
  writer.add_node({"pad", {1, 0, 0, 0, 0, 1, 0, -0.0095f, 0, 0, 1, 0}, cushion_mesh, {}, {}});

  const Instruments& poses = simulation.instruments();
  Mesh shaft = joined({moved(cylinder_mesh(0.0042f, 0.16f, 0.001f), {0, 0, 0.19f}),
                       moved(cylinder_mesh(0.0052f, 0.006f, 0.001f), {0, 0, 0.028f})});
  const size_t grasper = writer.add_mesh("grasper", std::array{GltfWriter::Primitive{&shaft, dark, 1}});
  writer.add_node({kNames[0], matrix(poses.grasper), grasper, {}, {}});
  for (const bool upper : {true, false}) {
    // From the hinge, which is the origin, to the tip.
    Mesh jaw = bar({0.0026f, 0.0011f, 0.0115f}, {0, upper ? 0.0014f : -0.0014f, -0.0105f});
    const size_t mesh = writer.add_mesh("jaw", std::array{GltfWriter::Primitive{&jaw, steel, 1}});
    writer.add_node({kNames[upper ? 1 : 2], matrix(upper ? poses.upper_jaw : poses.lower_jaw), mesh, {}, {}});
  }
  Mesh edge = bar({0.0006f, 0.0036f, 0.014f}, {0, 0, 0.0135f});
  Mesh handle = joined({moved(cylinder_mesh(0.0036f, 0.15f, 0.001f), {0, 0, 0.175f}),
                        moved(cylinder_mesh(0.0044f, 0.004f, 0.001f), {0, 0, 0.03f})});
  const size_t blade = writer.add_mesh(
      "blade", std::array{GltfWriter::Primitive{&edge, steel, 1}, GltfWriter::Primitive{&handle, dark, 1}});
  writer.add_node({kNames[3], matrix(poses.blade), blade, {}, {}});

  add_tissue(writer, simulation.surface());
  if (frame_code) add_code(writer);
  const auto lamp = [&](const GltfLight& light, Vec3 at, Vec3 target) {
    writer.add_node({light.name, looking_at(at, target), {}, {}, writer.add_light(light)});
  };
  lamp({"lamp", "spot", {1, 0.95f, 0.88f}, 5.0f, 0.25f, 0.5f}, {-0.16f, 0.52f, 0.30f}, {0, 0.02f, 0});
  lamp({"second lamp", "spot", {0.86f, 0.92f, 1}, 2.4f, 0.3f, 0.6f}, {0.42f, 0.44f, 0.16f},
       {0.02f, 0.02f, 0});
  const auto camera = [&](const char* name, float fov_rad, Vec3 at, Vec3 target) {
    writer.add_node({name, looking_at(at, target), {}, writer.add_camera(name, fov_rad, 0.01f), {}});
  };
  camera("camera", 0.62f, {0.03f, 0.21f, 0.29f}, {0.012f, 0.02f, 0.014f});
  camera("close camera", 0.6f, {0.02f, 0.13f, 0.17f}, {0.014f, 0.03f, 0.03f});
  return save(writer.finish("soft_tissue", "FIRE-3DV soft_tissue example"), path);
}

std::vector<float> code_corners(const std::array<float, 3>& offset) {
  std::vector<float> corners;
  for (const auto& [x, z] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)})
    corners.insert(corners.end(), {-0.11f + 0.02f * static_cast<float>(x) - offset[0], 0.07f - offset[1],
                                   -0.07f + 0.02f * static_cast<float>(z) - offset[2]});
  return corners;
}

}  // namespace soft_tissue
