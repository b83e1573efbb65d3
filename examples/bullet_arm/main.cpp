// Bullet Physics example: a robot arm grips a box, topples dominoes and sweeps through a wall, a tower and a
// stack of cans. It publishes poses to renderers in other processes.
#include <atomic>
#include <csignal>
#include <cstdio>
#include <memory>

#include "examples/bullet_arm/options.h"
#include "examples/bullet_arm/run_loop.h"
#include "examples/bullet_arm/scene_file.h"
#include "examples/bullet_arm/simulation.h"

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
