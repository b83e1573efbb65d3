#include "adapters/mujoco/compare/speed.h"

#include <algorithm>
#include <chrono>
#include <vector>

namespace fire3dv::mujoco {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Returns the median time of `frames` calls of `frame`, in milliseconds. `frame` steps the simulation and
// draws once.
template <typename Frame>
Result<double> block_ms(int frames, std::vector<double>& all, Frame&& frame) {
  std::vector<double> times;
  for (int i = 0; i < frames; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    if (Result<void> done = frame(); !done) return done.error();
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  }
  all.insert(all.end(), times.begin(), times.end());
  return median(times);
}

}  // namespace

Result<Speed> measure_speed(Simulation& simulation, RequestedImages& ours, MujocoRenderer& theirs, int blocks,
                            int frames) {
  std::vector<double> our_times, their_times, ratios;
  const auto our_frame = [&]() -> Result<void> {
    if (Result<void> done = simulation.step(); !done) return done;
    const Result<Image> image = ours.draw(simulation);
    return image ? Result<void>{} : Result<void>(image.error());
  };
  const auto their_frame = [&]() -> Result<void> {
    if (Result<void> done = simulation.step(); !done) return done;
    if (Result<void> done = theirs.draw_color_and_depth(simulation.data()); !done) return done;
    return theirs.draw_labels(simulation.data());
  };
  constexpr int kWarmUp = 3;  // frames for shader compilation and memory allocation
  std::vector<double> unused;
  if (auto warm = block_ms(kWarmUp, unused, our_frame); !warm) return warm.error();
  if (auto warm = block_ms(kWarmUp, unused, their_frame); !warm) return warm.error();
  for (int block = 0; block < blocks; ++block) {
    const Result<double> mine = block_ms(frames, our_times, our_frame);
    if (!mine) return mine.error();
    const Result<double> other = block_ms(frames, their_times, their_frame);
    if (!other) return other.error();
    ratios.push_back(*other / *mine);
  }
  const auto [lowest, highest] = std::minmax_element(ratios.begin(), ratios.end());
  return Speed{median(our_times), median(their_times), median(ratios), *lowest, *highest};
}

}  // namespace fire3dv::mujoco
