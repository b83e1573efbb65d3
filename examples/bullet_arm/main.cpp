// Bullet Physics example: a robot arm grips a box, topples dominoes and sweeps through a wall, a tower and a
// stack of cans. It publishes poses to renderers in other processes.

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <cinttypes>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "examples/bullet_arm/scene_file.h"
#include "examples/bullet_arm/simulation.h"
#include "examples/common/mesh.h"
#include "examples/common/publisher.h"

namespace bullet_arm {
namespace {

enum class Pace {
  realtime,  // steps follow the wall clock
  fast,      // no delay between steps
  lockstep,  // no delay, but every n-th frame waits until a renderer has shown it
};

struct Options : examples::LinkOptions {
  double seconds = 8;
  double rate_hz = 240;
  std::optional<uint64_t> frames;  // replaces seconds
  uint64_t seed = 7;
  Pace pace = Pace::realtime;
  uint32_t lockstep_every = 4;
  uint32_t publish_every = 1;
  std::string write_scene;
  bool hash = false;
  bool show_contacts = false;
  bool joint_scalars = false;
  bool loop = false;

  // Number of published poses per run: the initial one and one per step.
  uint64_t frame_count() const;
};

uint64_t Options::frame_count() const {
  if (frames) return *frames;
  return static_cast<uint64_t>(std::llround(seconds * rate_hz)) + 1;
}

// Returns nothing when the program must exit with *exit_code: 0 after --help, 2 after a usage error. The text
// has been printed.
std::optional<Options> parse_options(int argc, char** argv, int* exit_code) {
  Options options;
  bool realtime = false, fast = false, lockstep = false;
  CLI::App app{"Simulates a robot arm with Bullet and publishes it to FIRE-3DV renderers.", "bullet_arm"};
  examples::set_help(app, "[--to URI] [--write-scene FILE.glb] [OPTIONS]");
  app.footer("Details: man bullet_arm.");
  using examples::in_range;
  constexpr const char *kSimulation = "Simulation", *kStreams = "Streams", *kOutput = "Output";
  auto* seconds = app.add_option("--seconds", options.seconds, "simulated duration of a run")
                      ->type_name("S")
                      ->group(kSimulation)
                      ->check(in_range(0.01, 86400.0))
                      ->capture_default_str();
  app.add_option("--frames", options.frames, "publish N frames, instead of --seconds")
      ->type_name("N")
      ->group(kSimulation)
      ->check(in_range(uint64_t{1}, uint64_t{100'000'000}))
      ->excludes(seconds);
  app.add_option("--rate", options.rate_hz, "steps per simulated second; below 120 stacks are soft")
      ->type_name("HZ")
      ->group(kSimulation)
      ->check(in_range(60.0, 2000.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "placement of the objects")
      ->type_name("N")
      ->group(kSimulation)
      ->capture_default_str();
  auto* real_flag =
      app.add_flag("--realtime", realtime, "step by the wall clock (the default)")->group(kSimulation);
  auto* fast_flag = app.add_flag("--fast", fast, "step as fast as possible")->group(kSimulation);
  fast_flag->excludes(real_flag);
  app.add_flag("--loop", options.loop, "start again after each run, until interrupted")->group(kSimulation);
  examples::add_link_options(app, options);
  app.add_flag("--lockstep", lockstep, "wait until a renderer has drawn every n-th frame")
      ->group(kStreams)
      ->excludes(real_flag)
      ->excludes(fast_flag);
  app.add_option("--lockstep-every", options.lockstep_every, "that n; 4: 60 images per simulated second")
      ->type_name("N")
      ->group(kStreams)
      ->check(in_range(1u, 1'000'000u))
      ->capture_default_str();
  app.add_option("--publish-every", options.publish_every, "publish every N-th step only")
      ->type_name("N")
      ->group(kStreams)
      ->check(in_range(1u, 1'000'000u))
      ->capture_default_str();
  app.add_flag("--show-contacts", options.show_contacts,
               "publish contact points as the marker contacts/points")
      ->group(kStreams);
  app.add_flag("--joint-scalars", options.joint_scalars,
               "publish joint positions and velocities as scalars for plots")
      ->group(kStreams);
  app.add_option("--write-scene", options.write_scene, "write the glTF scene; without --to, then exit")
      ->type_name("FILE.glb")
      ->group(kOutput);
  app.add_flag("--hash", options.hash, "print a hash of all poses at the end; no --to needed")
      ->group(kOutput);

  try {
    app.parse(argc, argv);
    if (lockstep && options.to.empty())
      throw CLI::ValidationError("--lockstep", "needs --to: there is no one to wait for");
    if (options.show_contacts && options.to.empty())
      throw CLI::ValidationError("--show-contacts", "needs --to");
    if (options.joint_scalars && options.to.empty())
      throw CLI::ValidationError("--joint-scalars", "needs --to");
    if (options.loop && options.to.empty()) throw CLI::ValidationError("--loop", "needs --to");
    if (options.to.empty() && options.write_scene.empty() && !options.hash) {
      throw CLI::ValidationError("--to", "nothing to do: give --to URI, --write-scene FILE or --hash");
    }
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  options.pace = lockstep ? Pace::lockstep : fast || options.to.empty() ? Pace::fast : Pace::realtime;
  return options;
}

using examples::Clock;

// Orange discs, drawn over the bodies that hide the points.
std::optional<std::string> show_contacts(examples::Publisher& publisher, const Simulation& simulation) {
  const std::vector<std::array<float, 3>> points = simulation.contact_points();
  constexpr uint8_t kOrange[] = {255, 140, 0, 255};
  fire3dv_marker marker{};
  marker.struct_size = sizeof marker;
  marker.kind = FIRE3DV_MARKER_POINTS;
  marker.width_unit = FIRE3DV_MARKER_PIXELS;
  marker.width = 5;
  marker.flags = FIRE3DV_MARKER_OVERLAID;
  if (!points.empty()) {
    marker.positions = points.front().data();
    marker.position_count = points.size();
    marker.colors = kOrange;
    marker.color_count = 1;
  }
  return publisher.set_marker("contacts/points", marker);
}

constexpr const char *kPositions = "joint_positions", *kVelocities = "joint_velocities";

std::optional<std::string> declare_joints(examples::Publisher& publisher, const Simulation& simulation) {
  std::vector<const char*> names, of_positions, of_velocities;
  for (const JointState& joint : simulation.joints()) {
    names.push_back(joint.name);
    of_positions.push_back(joint.slides ? "m" : "rad");
    of_velocities.push_back(joint.slides ? "m/s" : "rad/s");
  }
  const auto group = [&](const std::vector<const char*>& units) {
    return fire3dv_scalars{sizeof(fire3dv_scalars), names.data(), units.data(), names.size()};
  };
  if (auto error = publisher.declare_scalars(kPositions, group(of_positions))) return error;
  return publisher.declare_scalars(kVelocities, group(of_velocities));
}

std::optional<std::string> send_joints(examples::Publisher& publisher, const Simulation& simulation,
                                       int64_t sim_time_ns) {
  std::vector<double> positions, velocities;
  for (const JointState& joint : simulation.joints()) {
    positions.push_back(joint.position);
    velocities.push_back(joint.velocity);
  }
  if (auto error = publisher.set_scalars(kPositions, sim_time_ns, positions)) return error;
  return publisher.set_scalars(kVelocities, sim_time_ns, velocities);
}

int fail(const std::string& sentence) {
  std::fprintf(stderr, "bullet_arm: %s\n", sentence.c_str());
  return 1;
}

// Steps the simulation at the selected pace and publishes each step. Returns the exit code. Closes streams in
// order once stop is set.
int run_loop(const Options& options, std::unique_ptr<Simulation> simulation, const std::atomic<bool>& stop) {
  examples::Publisher publisher;
  if (const auto error = publisher.open("bullet_arm", options.to, options.security)) return fail(*error);
  fire3dv::Description description;
  description.node_names = simulation->names();
  description.world_from_stream.assign(examples::kWorldFromStream.begin(), examples::kWorldFromStream.end());
  description.body_from_node = {examples::kBodyFromNode};
  description.nominal_rate_hz = options.rate_hz / options.publish_every;
  description.scene_uri = options.write_scene;
  if (const auto error = publisher.describe(description)) return fail(*error);
  if (options.joint_scalars) {
    if (const auto error = declare_joints(publisher, *simulation)) return fail(*error);
  }

  examples::Report report;
  PoseHash hash;
  const uint64_t frames_a_run = options.frame_count();
  const std::chrono::duration<double> period(1 / options.rate_hz);
  const Clock::time_point start = Clock::now();
  int64_t run_start_ns = 0;
  uint64_t frames = 0;

  while (!stop) {
    // Step. The first frame of a run shows the scene at rest.
    const uint64_t frame_of_run = frames % frames_a_run;
    if (frame_of_run == 0 && frames > 0) {
      if (!options.loop) break;
      run_start_ns += simulation->sim_time_ns() + static_cast<int64_t>(1e9 / options.rate_hz);
      simulation = std::make_unique<Simulation>(options.seed, options.rate_hz);
    }
    if (frame_of_run > 0) {
      const Clock::time_point before = Clock::now();
      simulation->step();
      report.add_step(Clock::now() - before);
    }
    if (options.hash) hash.add(simulation->poses());

    if (frame_of_run % options.publish_every != 0) {
      ++frames;
      continue;
    }

    // Wait until the frame is due.
    if (options.pace == Pace::realtime) {
      std::this_thread::sleep_until(
          start + std::chrono::duration_cast<Clock::duration>(period * static_cast<double>(frames)));
    }

    // Publish. Simulated time continues across a restart, but the bodies jump.
    const int64_t sim_time_ns = run_start_ns + simulation->sim_time_ns();
    const Clock::time_point before = Clock::now();
    if (options.show_contacts) {
      if (const auto error = show_contacts(publisher, *simulation)) return fail(*error);
    }
    if (options.joint_scalars) {
      if (const auto error = send_joints(publisher, *simulation, sim_time_ns)) return fail(*error);
    }
    if (const auto error = publisher.publish(sim_time_ns, simulation->poses(), frame_of_run == 0))
      return fail(*error);
    report.add_publish(Clock::now() - before);
    ++frames;

    // Lockstep: wait until the frame is shown.
    if (options.pace == Pace::lockstep && frame_of_run % options.lockstep_every == 0) {
      if (const auto error = publisher.wait_shown(options.ack_timeout_s, stop)) return fail(*error);
    }
    if (!options.to.empty() && report.due())
      report.print(static_cast<double>(sim_time_ns) * 1e-9, publisher.poll());
  }

  if (!options.to.empty()) {
    report.print(static_cast<double>(run_start_ns + simulation->sim_time_ns()) * 1e-9, publisher.poll());
  }
  if (options.hash) std::printf("frames %" PRIu64 " hash %016" PRIx64 "\n", frames, hash.value());
  return 0;
}

}  // namespace
}  // namespace bullet_arm

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
  const auto options = bullet_arm::parse_options(argc, argv, &exit_code);
  if (!options) return exit_code;

  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESETHAND;  // a second Ctrl-C ends the program immediately
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);

  auto simulation = std::make_unique<bullet_arm::Simulation>(options->seed, options->rate_hz);
  if (!options->write_scene.empty()) {
    if (const auto error = bullet_arm::write_scene(*simulation, options->write_scene)) {
      std::fprintf(stderr, "bullet_arm: %s\n", error->c_str());
      return 1;
    }
  }
  if (options->to.empty() && !options->hash) return 0;
  return bullet_arm::run_loop(*options, std::move(simulation), stop);
}
