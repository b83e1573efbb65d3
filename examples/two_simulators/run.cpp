#include "examples/two_simulators/run.h"

#include <CLI/CLI.hpp>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <thread>

#include "examples/common/publisher.h"

namespace two_simulators {

std::optional<Options> parse_options(int argc, char** argv, const char* program, const char* about,
                                     int* exit_code) {
  Options options;
  CLI::App app{about, program};
  examples::set_help(app, "--to URI [OPTIONS]");
  examples::add_link_options(app, options)->required();
  constexpr const char* kSimulation = "Simulation";
  app.add_option("--seconds", options.seconds, "simulated duration; 0: until interrupted")
      ->type_name("S")
      ->group(kSimulation)
      ->check(examples::in_range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--publish-every", options.publish_every, "publish every N-th of 240 steps per second")
      ->type_name("N")
      ->group(kSimulation)
      ->check(examples::in_range(1u, 1'000'000u))
      ->capture_default_str();
  app.add_flag("--lockstep", options.lockstep, "wait until a renderer has drawn each frame")
      ->group(kSimulation);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

namespace {

using examples::Clock;

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free,
              "the signal handler below may only use what takes no lock");

void install_stop_signals() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second Ctrl-C ends the program immediately
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

fire3dv::Description describe(const Simulator& simulator, double rate_hz) {
  fire3dv::Description description;
  description.node_names = simulator.names();
  const auto world_from_stream = simulator.frame().world_from_stream();
  description.world_from_stream.assign(world_from_stream.begin(), world_from_stream.end());
  description.body_from_node = {simulator.frame().body_from_node()};
  description.nominal_rate_hz = rate_hz;
  return description;
}

}  // namespace

int run(Simulator& simulator, const char* program, const Options& options) {
  install_stop_signals();
  const auto fail = [&](const std::string& sentence) {
    std::fprintf(stderr, "%s: %s\n", program, sentence.c_str());
    return 1;
  };
  examples::Publisher publisher;
  if (const auto error = publisher.open(program, options.to, options.security)) return fail(*error);
  if (const auto error = publisher.describe(describe(simulator, kStepsPerSecond / options.publish_every)))
    return fail(*error);

  examples::Report report;
  const auto steps = static_cast<uint64_t>(std::llround(options.seconds * kStepsPerSecond));
  const std::chrono::duration<double> period(1 / kStepsPerSecond);
  const Clock::time_point start = Clock::now();
  bool jumped = true;  // the first frame is a discontinuity
  uint64_t step = 0;
  for (; !stop && (steps == 0 || step <= steps); ++step) {
    if (step > 0) {
      const Clock::time_point before = Clock::now();
      jumped |= !simulator.step();
      report.add_step(Clock::now() - before);
    }
    if (step % options.publish_every != 0) continue;
    if (!options.lockstep) {
      std::this_thread::sleep_until(
          start + std::chrono::duration_cast<Clock::duration>(period * static_cast<double>(step)));
    }
    const Clock::time_point before = Clock::now();
    const auto sim_time_ns =
        static_cast<int64_t>(std::llround(static_cast<double>(step) * 1e9 / kStepsPerSecond));
    if (const auto error = publisher.publish(sim_time_ns, simulator.poses(), jumped)) return fail(*error);
    report.add_publish(Clock::now() - before);
    jumped = false;
    if (options.lockstep) {
      if (const auto error = publisher.wait_shown(options.ack_timeout_s, stop)) return fail(*error);
    }
    if (report.due()) report.print(static_cast<double>(sim_time_ns) * 1e-9, publisher.poll());
  }
  report.print(static_cast<double>(step) / kStepsPerSecond, publisher.poll());
  return 0;
}

}  // namespace two_simulators
