#include "examples/bullet_arm/run_loop.h"

#include <cinttypes>
#include <cstdio>
#include <thread>

#include "examples/common/frames.h"
#include "examples/common/publisher.h"
#include "examples/common/report.h"

namespace bullet_arm {
namespace {

using examples::Clock;

int fail(const std::string& sentence) {
  std::fprintf(stderr, "bullet_arm: %s\n", sentence.c_str());
  return 1;
}

}  // namespace

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

}  // namespace bullet_arm
