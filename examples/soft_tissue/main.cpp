// Soft tissue example: a liver-like phantom of Bullet's soft bodies is grasped and cut. Its vertices are
// streamed at 60 Hz, each with the frame of poses that it belongs to.

#include <fire3dv/image.h>

#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cinttypes>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "examples/common/materials.h"
#include "examples/common/publisher.h"
#include "examples/soft_tissue/scene_file.h"
#include "examples/soft_tissue/simulation.h"

namespace soft_tissue {
namespace {

struct Options : examples::LinkOptions {
  double seconds = kRun_s;
  int detail = 96;
  bool fast = false, lockstep = false, loop = false, frame_code = false;
  std::string write_scene, picture, camera = "camera";
  std::array<uint32_t, 2> size{1280, 720};
};

// Returns nothing when the program must exit with *exit_code: 0 after --help, 2 after a usage error. The text
// has been printed.
std::optional<Options> parse_options(int argc, char** argv, int* exit_code) {
  Options options;
  CLI::App app{
      "Simulates soft tissue that is grasped and cut with Bullet, and publishes it to FIRE-3DV renderers.",
      "soft_tissue"};
  examples::set_help(app, "[--to URI] [--write-scene FILE.glb] [OPTIONS]");
  app.footer("Without --to it simulates and prints the time of a step.");
  using examples::in_range;
  constexpr const char *kSimulation = "Simulation", *kStreams = "Streams", *kOutput = "Output";
  app.add_option("--seconds", options.seconds, "simulated duration; a run takes 8 s")
      ->type_name("S")
      ->group(kSimulation)
      ->check(in_range(0.02, 86400.0))
      ->capture_default_str();
  app.add_option("--detail", options.detail, "cells along the phantom; 96: about 10,000 vertices")
      ->type_name("N")
      ->group(kSimulation)
      ->check(in_range(16, 400))
      ->capture_default_str();
  app.add_flag("--fast", options.fast, "step as fast as possible, not by the wall clock")->group(kSimulation);
  app.add_flag("--loop", options.loop, "go on until interrupted")->group(kSimulation);
  examples::add_link_options(app, options);
  app.add_flag("--lockstep", options.lockstep, "wait until a renderer has shown each frame")->group(kStreams);
  app.add_flag(
         "--frame-code", options.frame_code,
         "add a green square whose vertices cancel its pose: it stands still where both are of one frame")
      ->group(kSimulation);
  app.add_option("--write-scene", options.write_scene, "write the glTF scene; without --to, then exit")
      ->type_name("FILE.glb")
      ->group(kOutput);
  app.add_option("--picture", options.picture, "request the image of the last frame and write it; needs --to")
      ->type_name("FILE.png")
      ->group(kOutput);
  app.add_option("--camera", options.camera, "camera of --picture: a node's name")
      ->type_name("NAME")
      ->group(kOutput)
      ->capture_default_str();
  app.add_option("--size", options.size, "pixels of --picture")
      ->type_name("W H")
      ->group(kOutput)
      ->check(in_range(16u, 8192u))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
    using Given = std::pair<bool, const char*>;
    for (const auto& [given, name] : {Given(!options.picture.empty(), "--picture"),
                                      Given(options.lockstep, "--lockstep"), Given(options.loop, "--loop")})
      if (given && options.to.empty()) throw CLI::ValidationError(name, "needs --to");
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

using examples::Clock;

// Where --frame-code moves its square in a frame; its vertices are moved the other way.
std::array<float, 3> code_offset(uint64_t frame) {
  return {0.01f * static_cast<float>(frame % 7), 0, 0.013f * static_cast<float>(frame % 5)};
}

// The copy that a frame shows. In lockstep nobody draws while vertices change, so one copy is enough.
size_t shown_copy(const Options& options, uint64_t frame) {
  return options.lockstep ? 0 : frame % 2;
}

// Sends the vertices of a frame to that copy of the phantom which the frame before does not show. Its poses
// then show this copy and hide the other one, all at once: a renderer that already has the next vertices does
// not see them.
std::optional<std::string> send_vertices(examples::Publisher& publisher, const Simulation& simulation,
                                         const Options& options, uint64_t frame) {
  const size_t copy = shown_copy(options, frame);
  if (auto error = publisher.set_vertices(kTissue[copy], simulation.positions(), simulation.normals()))
    return error;
  if (!options.frame_code) return std::nullopt;
  const std::vector<float> up = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
  return publisher.set_vertices(kCode[copy], code_corners(code_offset(frame)), up);
}

std::vector<float> poses_of(const Instruments& instruments, const Options& options, uint64_t frame) {
  std::vector<float> poses;
  const auto add = [&](const std::array<float, 12>& pose) {
    poses.insert(poses.end(), pose.begin(), pose.end());
  };
  for (const auto* pose :
       {&instruments.grasper, &instruments.upper_jaw, &instruments.lower_jaw, &instruments.blade})
    add(*pose);
  for (const size_t copy : {0, 1}) add(copy_pose(shown_copy(options, frame) == copy, {0, 0, 0}));
  if (options.frame_code)
    for (const size_t copy : {0, 1}) add(copy_pose(shown_copy(options, frame) == copy, code_offset(frame)));
  return poses;
}

int fail(const std::string& sentence) {
  std::fprintf(stderr, "soft_tissue: %s\n", sentence.c_str());
  return 1;
}

std::optional<std::string> write_picture(examples::Publisher& publisher, const Options& options,
                                         const std::atomic<bool>& stop) {
  examples::Image image{static_cast<int>(options.size[0]), static_cast<int>(options.size[1]), {}};
  if (auto error = publisher.request_picture(options.camera, options.ack_timeout_s, stop, image))
    return error;
  const auto png = examples::encode_png(image);
  std::FILE* const file = png ? std::fopen(options.picture.c_str(), "wb") : nullptr;
  if (!file) return "cannot write " + options.picture;
  const bool written = std::fwrite(png->data(), 1, png->size(), file) == png->size();
  if (std::fclose(file) != 0 || !written) return "cannot write all of " + options.picture;
  return std::nullopt;
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())))];
}

int run(const Options& options, Simulation& simulation, const std::atomic<bool>& stop) {
  examples::Publisher publisher;
  if (const auto error = publisher.open("soft_tissue", options.to, options.security)) return fail(*error);
  fire3dv::Description description;
  description.node_names = body_names(options.frame_code);
  description.nominal_rate_hz = kRate_hz;
  description.scene_uri = options.write_scene;
  if (const auto error = publisher.describe(description)) return fail(*error);

  const auto frame_count = static_cast<uint64_t>(std::llround(options.seconds * kRate_hz)) + 1;
  const std::chrono::duration<double> period(1 / kRate_hz);
  const Clock::time_point start = Clock::now();
  std::vector<double> step_ms, publish_ms;
  const auto cpu_ms = [] {  // of this thread: on a machine that does other things, too
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
  };
  uint64_t frame = 0;
  for (; !stop && (options.loop || frame < frame_count); ++frame) {
    const double before_ms = cpu_ms();
    if (frame > 0) simulation.step();
    step_ms.push_back(cpu_ms() - before_ms);
    if (!options.fast && !options.lockstep && !options.to.empty())
      std::this_thread::sleep_until(
          start + std::chrono::duration_cast<Clock::duration>(period * static_cast<double>(frame)));
    const double stepped_ms = cpu_ms();
    if (const auto error = send_vertices(publisher, simulation, options, frame)) return fail(*error);
    const auto sim_time_ns = static_cast<int64_t>(std::llround(1e9 * simulation.time_s()));
    if (const auto error =
            publisher.publish(sim_time_ns, poses_of(simulation.instruments(), options, frame), frame == 0))
      return fail(*error);
    publish_ms.push_back(cpu_ms() - stepped_ms);
    if (options.lockstep) {
      if (const auto error = publisher.wait_shown(options.ack_timeout_s, stop)) return fail(*error);
    }
    if (step_ms.size() > 100'000) step_ms.clear(), publish_ms.clear();
  }
  if (!options.picture.empty()) {
    if (const auto error = write_picture(publisher, options, stop)) return fail(*error);
  }
  std::printf(
      "frames %" PRIu64
      " vertices %zu nodes %zu; a step %.2f ms of CPU time (95 %%: %.2f), publishing %.2f ms (95 %%: %.2f)\n",
      frame, simulation.positions().size() / 3, simulation.node_count(), percentile(step_ms, 0.5),
      percentile(step_ms, 0.95), percentile(publish_ms, 0.5), percentile(publish_ms, 0.95));
  return 0;
}

}  // namespace
}  // namespace soft_tissue

namespace {

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free,
              "the signal handler below may only use what takes no lock");

void on_signal(int) {
  stop = true;
}

}  // namespace

int main(int argc, char** argv) {
  int exit_code = 0;
  const auto options = soft_tissue::parse_options(argc, argv, &exit_code);
  if (!options) return exit_code;

  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESETHAND;  // a second Ctrl-C ends the program immediately
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);

  soft_tissue::Simulation simulation({options->detail / 8 * 8, options->detail / 2});
  if (!options->write_scene.empty()) {
    if (const auto error = soft_tissue::write_scene(simulation, options->frame_code, options->write_scene)) {
      std::fprintf(stderr, "soft_tissue: %s\n", error->c_str());
      return 1;
    }
    if (options->to.empty()) return 0;
  }
  return soft_tissue::run(*options, simulation, stop);
}
