#include "tools/lab/bench/panel_facts.h"

#include <cmath>
#include <utility>

namespace fire3dv::bench {
namespace {

// Deterministic noise between -1 and 1.
double uneven(uint64_t image, double phase) {
  const double t = static_cast<double>(image) + phase * 17;
  return 0.6 * std::sin(t * 0.37 + phase) + 0.3 * std::sin(t * 1.71 + 2 * phase) + 0.1 * std::sin(t * 5.3);
}

gui::StreamFact arm(uint64_t image) {
  gui::StreamFact stream;
  stream.epoch = 0x51;
  stream.name = "bullet_arm";
  stream.listener = "shm://bullet_arm";
  stream.clock = "the same as ours";
  stream.rate_hz = 1000;
  stream.age_ms = 0.9 + 0.3 * uneven(image, 3);
  stream.sequence = 48'210 + image * 16;
  stream.sim_time_ns = static_cast<int64_t>(stream.sequence) * 1'000'000;
  stream.poses = 12;
  stream.shown = stream.sequence - 3;
  for (uint64_t i = 0; i < 96; ++i)
    stream.gaps_ms.push_back(static_cast<float>(1 + 0.15 * uneven(image + i, 5)));
  return stream;
}

gui::StreamFact rover(uint64_t image) {
  gui::StreamFact stream;
  stream.epoch = 0x52;
  stream.name = "rover";
  stream.listener = "udp://127.0.0.1:45001";
  stream.clock = "measured by pings";
  stream.condition = state::Condition::late;
  stream.interpolated = true;
  stream.delay_ns = 42'000'000;
  stream.rate_hz = 48.6;
  stream.age_ms = 61 + 9 * uneven(image, 7);
  stream.sequence = 9'112 + image;
  stream.sim_time_ns = static_cast<int64_t>(stream.sequence) * 20'000'000;
  stream.poses = 40;
  stream.unmatched = 2;
  stream.shown = 9'020 + image;
  stream.uses = {{Resource::pose_bytes, 12 << 20, 512 << 20, 0}, {Resource::requests, 1'024, 1'024, 3}};
  stream.incomplete = 31;
  stream.stale = 7;
  for (uint64_t i = 0; i < 96; ++i)
    stream.gaps_ms.push_back(static_cast<float>(20 + 14 * uneven(image + i, 9)));
  return stream;
}

}  // namespace

gui::Facts panel_facts(uint64_t image, glm::uvec2 extent_px) {
  gui::Facts facts;
  gui::FrameFacts& frame = facts.frame;
  frame.images = image + 1;
  frame.interval_ms = 16.67 + 0.2 * uneven(image, 1);
  frame.cpu_ms = 0.41 + 0.1 * uneven(image, 2);
  frame.pose_age_ms = 1.3;
  frame.extent_px = extent_px;
  frame.triangles = 7'002'114;
  frame.clusters = 58'412;
  frame.clusters_drawn = 21'330;
  frame.shadow_rays = 184'022;
  frame.gpu_bytes = 812ull << 20;
  frame.resident_bytes = 344ull << 20;
  frame.device = "a GPU";
  frame.raster = "from a visibility buffer";
  frame.shadows = "maps, and rays where they cannot tell";
  frame.samples = 4;
  const std::pair<const char*, double> passes[] = {
      {"poses", 0.004}, {"transforms", 0.006}, {"light views", 0.011}, {"clear", 0.030},
      {"cull", 0.022},  {"raster", 0.297},     {"expand", 0.013},      {"tiles", 0.048},
      {"shade", 0.231}, {"tlas wait", 0.009},  {"trace", 0.204},       {"shade again", 0.061},
      {"fxaa", 0.031},  {"gui", 0.028},        {"window", 0.019}};
  double phase = 0;
  for (const auto& [name, ms] : passes) {
    const double here_ms = ms * (1 + 0.08 * uneven(image, phase++));
    frame.passes.push_back({name, here_ms, false});
    frame.gpu_ms += here_ms;
  }
  frame.passes.push_back({"tlas", 0.142, true});
  facts.streams = {arm(image), rover(image)};
  facts.links = {{"shm://bullet_arm", 1, 38'400'000, 0, 0, 0},
                 {"udp://127.0.0.1:45001", 1, 17'600'000, 4, 31, 0}};
  facts.log = {{0.1, "listening on shm://bullet_arm"},
               {0.1, "listening on udp://127.0.0.1:45001"},
               {1.4, "stream \"bullet_arm\" with 12 nodes accepted"},
               {6.2, "stream \"rover\" with 40 nodes accepted; no scene node is called wheel_5, wheel_6"},
               {71.9, "stream \"rover\" sends no frames; the last one is held"},
               {73.0, "stream \"rover\" sends frames again"}};
  facts.log_lines = facts.log.size();
  facts.camera = 0;
  return facts;
}

}  // namespace fire3dv::bench
