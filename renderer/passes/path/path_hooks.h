// Callbacks of path tracing: start from stored samples, checkpoints, progress, stop and time budget.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

namespace fire3dv::passes {

// Sums after some samples of each pixel, gpu_types::PathSum[pixel] as bytes of this machine. An image that
// starts with them ends with the same bytes.
struct PathSamples {
  uint32_t samples = 0;
  std::span<const std::byte> sums;
};

struct PathHooks {
  // Start of a new image, at most as many samples as wanted and of this size. nullopt: without samples.
  std::optional<PathSamples> resume = std::nullopt;
  // Called at each interval, and before should_stop ends the call. null: never.
  std::function<void(const PathSamples&)> save = nullptr;
  std::chrono::steady_clock::duration save_interval{};
  std::function<void(uint64_t done, uint64_t total)> progress = nullptr;  // null: none
  std::function<bool()> should_stop = nullptr;                            // null: never
  // Ends a call of trace() at the first submission after this time. nullopt: with the last sample.
  std::optional<std::chrono::steady_clock::duration> budget = std::nullopt;
};

}  // namespace fire3dv::passes
