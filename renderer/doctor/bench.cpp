#include "renderer/doctor/bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <glm/glm.hpp>
#include <memory>
#include <numbers>
#include <span>
#include <stdexcept>

#include "base/build_info.h"
#include "base/glb.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/readback_ring.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/settings/setting_table.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::doctor {
namespace {

constexpr uint32_t kSide = 10;   // spheres of a side of the grid
constexpr uint32_t kRings = 32;  // of a sphere
constexpr uint32_t kSegments = 64;
constexpr uint64_t kTriangles = uint64_t{kSide} * kSide * kRings * kSegments * 2;
constexpr uint32_t kWarmUp = 3, kMinFrames = 5, kMaxFrames = 51;
constexpr double kEnough_ms = 2000;  // of measured frames of a size
constexpr float kFovRad = 0.8f;

// 100 nodes of one sphere, a directional light with shadows.
scene::Scene make_scene() {
  std::vector<float> positions, normals;
  std::vector<uint32_t> indices;
  for (uint32_t ring = 0; ring <= kRings; ++ring) {
    for (uint32_t segment = 0; segment <= kSegments; ++segment) {
      const float polar = std::numbers::pi_v<float> * static_cast<float>(ring) / kRings;
      const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(segment) / kSegments;
      for (const float v :
           {std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn)}) {
        normals.push_back(v);
        positions.push_back(0.45f * v);
      }
    }
  }
  for (uint32_t ring = 0; ring < kRings; ++ring) {
    for (uint32_t segment = 0; segment < kSegments; ++segment) {
      const uint32_t a = ring * (kSegments + 1) + segment, b = a + kSegments + 1;
      for (const uint32_t index : {a, a + 1, b, b, a + 1, b + 1}) indices.push_back(index);
    }
  }
  base::GlbBuffer buffer;
  buffer.add_view(std::as_bytes(std::span(positions)), base::GlbBuffer::Target::array_buffer);
  buffer.add_view(std::as_bytes(std::span(normals)), base::GlbBuffer::Target::array_buffer);
  buffer.add_view(std::as_bytes(std::span(indices)), base::GlbBuffer::Target::element_array_buffer);
  nlohmann::json json;
  json["asset"]["version"] = "2.0";
  json["extensionsUsed"] = {"KHR_lights_punctual"};
  json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}, {"intensity", 3}}};
  json["buffers"] = {{{"byteLength", buffer.bytes().size()}}};
  for (const base::GlbBuffer::View& view : buffer.views())
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", view.offset}, {"byteLength", view.bytes}});
  json["accessors"] = {
      {{"bufferView", 0},
       {"componentType", 5126},
       {"count", positions.size() / 3},
       {"type", "VEC3"},
       {"min", {-0.45, -0.45, -0.45}},
       {"max", {0.45, 0.45, 0.45}}},
      {{"bufferView", 1}, {"componentType", 5126}, {"count", normals.size() / 3}, {"type", "VEC3"}},
      {{"bufferView", 2}, {"componentType", 5125}, {"count", indices.size()}, {"type", "SCALAR"}}};
  json["materials"] = {{{"pbrMetallicRoughness", {{"metallicFactor", 0.2}, {"roughnessFactor", 0.5}}}}};
  json["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"indices", 2}, {"material", 0}}}}}};
  nlohmann::json& nodes = json["nodes"] = nlohmann::json::array();
  for (uint32_t i = 0; i < kSide * kSide; ++i) {
    const float half = 0.5f * (kSide - 1);
    nodes.push_back({{"mesh", 0},
                     {"translation",
                      {static_cast<float>(i % kSide) - half, 0.3f * static_cast<float>(i % 3),
                       static_cast<float>(i / kSide) - half}}});
  }
  nodes.push_back(
      {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"rotation", {-0.5, 0.2, 0.1, 0.836}}});
  nlohmann::json children = nlohmann::json::array();
  for (size_t i = 0; i < nodes.size(); ++i) children.push_back(i);
  json["scenes"] = {{{"nodes", children}}};
  json["scene"] = 0;
  Result<scene::Scene> scene = scene::load_glb(base::make_glb(json.dump(), buffer.bytes()), "bench scene");
  if (!scene) throw std::runtime_error(scene.error().message);
  return std::move(*scene);
}

passes::View make_view(const BenchSize& size) {
  scene::Camera camera;
  camera.vertical_fov_rad = kFovRad;
  camera.near_m = 0.1f;
  return passes::make_view(camera, passes::look_at_pose(glm::vec3(7, 7, 10), glm::vec3(0)),
                           static_cast<float>(size.width) / static_cast<float>(size.height));
}

double median_ms(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

}  // namespace

std::vector<BenchSize> bench_sizes() {
  return {{640, 480}, {1920, 1080}};
}

nlohmann::json run_bench(uint32_t index) {
  Result<std::unique_ptr<gpu::Instance>> instance = gpu::Instance::create({});
  if (!instance) throw std::runtime_error(instance.error().message);
  Result<std::unique_ptr<gpu::Device>> device = gpu::Device::create(**instance, index, false);
  if (!device) throw std::runtime_error(device.error().message);
  const scene::Scene scene = make_scene();
  const state::PoseState poses(scene);
  gpu::FrameRing frames(**device);
  passes::SceneRenderer renderer(**device, settings::default_settings());
  renderer.set_scene(scene);
  gpu::ReadbackRing<int> readback(**device);
  nlohmann::json ms = nlohmann::json::array();
  for (const BenchSize& size : bench_sizes()) {
    const passes::View view = make_view(size);
    std::vector<double> times;
    double measured_ms = 0;
    for (uint32_t frame = 0; frame < kWarmUp + kMaxFrames; ++frame) {
      if (frame >= kWarmUp + kMinFrames && measured_ms > kEnough_ms) break;
      const auto begin = std::chrono::steady_clock::now();
      const Result<passes::PreparedFrame> prepared = renderer.prepare({.extent = {size.width, size.height}});
      if (!prepared) throw std::runtime_error(prepared.error().message);
      gpu::Recorder& recorder = frames.begin();
      renderer.record(*prepared, recorder, frames.staging(), poses, view);
      readback.record(recorder, renderer.image(), 0);
      const uint64_t done_at = frames.submit();
      readback.submitted(done_at);
      renderer.submitted(done_at);
      readback.drain([](int, VkExtent2D, std::span<const uint8_t>) {});
      const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begin;
      if (frame < kWarmUp) continue;
      times.push_back(taken.count());
      measured_ms += taken.count();
    }
    ms.push_back(median_ms(times));
  }
  return {{"triangles", kTriangles}, {"ms", ms}};
}

std::string bench_table(const std::vector<BenchRow>& rows) {
  std::string text = "| device | driver | fire3dv | triangles |", line = "|---|---|---|---|";
  for (const BenchSize& size : bench_sizes()) {
    text += " " + std::to_string(size.width) + "x" + std::to_string(size.height) + ", ms |";
    line += "---|";
  }
  text += "\n" + line + "\n";
  for (const BenchRow& row : rows) {
    text += "| " + row.device + " | " + row.driver + " | " + kVersion + " " + kCommit + " | " +
            (row.triangles ? std::to_string(row.triangles) : "-") + " |";
    for (size_t i = 0; i < bench_sizes().size(); ++i) {
      char value[32] = "-";
      if (i < row.ms.size()) std::snprintf(value, sizeof(value), "%.2f", row.ms[i]);
      text += std::string(" ") + value + " |";
    }
    text += "\n";
  }
  return text;
}

}  // namespace fire3dv::doctor
