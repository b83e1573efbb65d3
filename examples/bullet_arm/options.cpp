#include "examples/bullet_arm/options.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>

namespace bullet_arm {

uint64_t Options::frame_count() const {
  if (frames) return *frames;
  return static_cast<uint64_t>(std::llround(seconds * rate_hz)) + 1;
}

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
  app.add_option("--write-scene", options.write_scene, "write the glTF scene; without --to, then exit")
      ->type_name("FILE.glb")
      ->group(kOutput);
  app.add_flag("--hash", options.hash, "print a hash of all poses at the end; no --to needed")
      ->group(kOutput);

  try {
    app.parse(argc, argv);
    if (lockstep && options.to.empty())
      throw CLI::ValidationError("--lockstep", "needs --to: there is no one to wait for");
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

}  // namespace bullet_arm
