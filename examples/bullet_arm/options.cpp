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
  CLI::App app{"A robot arm simulated by Bullet, published to FIRE-3DV renderers", "bullet_arm"};
  examples::add_link_options(app, options);
  auto* seconds = app.add_option("--seconds", options.seconds, "Simulated time of a run")
                      ->check(CLI::Range(0.01, 86400.0))
                      ->capture_default_str();
  app.add_option("--frames", options.frames, "Publish this many frames instead of --seconds")
      ->check(CLI::Range(uint64_t{1}, uint64_t{100'000'000}))
      ->excludes(seconds);
  app.add_option("--rate", options.rate_hz, "Steps in a simulated second; below 120 stacks get soft")
      ->check(CLI::Range(60.0, 2000.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "How the objects stand: another seed, another fall")
      ->capture_default_str();
  auto* real_flag = app.add_flag("--realtime", realtime, "Step by the clock on the wall (default)");
  auto* fast_flag = app.add_flag("--fast", fast, "Step as fast as possible")->excludes(real_flag);
  app.add_flag("--lockstep", lockstep, "Wait until a renderer has shown every n-th frame")
      ->excludes(real_flag)
      ->excludes(fast_flag);
  app.add_option("--lockstep-every", options.lockstep_every,
                 "That n; 4 makes 60 images of a simulated second")
      ->check(CLI::Range(1u, 1'000'000u))
      ->capture_default_str();
  app.add_option("--publish-every", options.publish_every, "Publish every n-th step only")
      ->check(CLI::Range(1u, 1'000'000u))
      ->capture_default_str();
  app.add_option("--write-scene", options.write_scene,
                 "Write the glTF scene to this .glb file; alone: then stop")
      ->type_name("FILE");
  app.add_flag("--hash", options.hash,
               "Print a hash of all poses at the end; alone: simulate without publishing");
  app.add_flag("--loop", options.loop, "Start over after each run until interrupted");

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
