#include "renderer/gpu/submission_limits.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "base/clock.h"
#include "renderer/gpu/device/pipeline_count.h"

namespace fire3dv::gpu {
namespace {

constexpr int64_t kStepNs = 20'000'000;  // between looks at the end of this object
constexpr size_t kMaxEarlyEnds = 256;    // far more submissions than are in flight
// More time for a submission that uses pipelines for the first time: compilation is no content.
constexpr int64_t kCompilationNs = 5'000'000'000;

}  // namespace

SubmissionLimits::~SubmissionLimits() {
  thread_.request_stop();
}

void SubmissionLimits::submitted(uint64_t value, std::span<uint64_t* const> words) {
  const uint64_t pipelines = pipelines_begun();
  const bool compiles = std::exchange(pipelines_, pipelines) != pipelines;
  if (!limit_ns_) return;
  const std::lock_guard lock(mutex_);
  running_.push_back(
      {value, *limit_ns_ + (compiles ? kCompilationNs : 0), cause_, {words.begin(), words.end()}});
  if (!thread_.joinable()) thread_ = std::jthread([this](const std::stop_token& stop) { watch(stop); });
  changed_.notify_one();
}

void SubmissionLimits::end(uint64_t value, std::span<uint64_t* const> words) {
  const std::lock_guard lock(mutex_);
  for (uint64_t* const word : words) std::atomic_ref(*word).store(1, std::memory_order_relaxed);
  note_early_end(value);
}

void SubmissionLimits::release(uint64_t value) {
  const std::lock_guard lock(mutex_);
  for (Running& running : running_) {
    if (running.value <= value) running.words.clear();
  }
}

bool SubmissionLimits::has_ended_early(uint64_t value) const {
  const std::lock_guard lock(mutex_);
  return std::ranges::find(early_ends_, value) != early_ends_.end();
}

std::optional<int64_t> SubmissionLimits::take_ended_early() {
  const std::lock_guard lock(mutex_);
  return std::exchange(ended_ns_, {});
}

// Waits for one submission after the other. A submission's time begins when the one before has ended.
void SubmissionLimits::watch(const std::stop_token& stop) {
  int64_t idle_since_ns = monotonic_ns();
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return !running_.empty(); })) {
    const uint64_t value = running_.front().value;
    const int64_t limit_ns = running_.front().limit_ns;
    lock.unlock();
    bool is_done = false;
    // Earlier submissions without a limit, such as of a scene, are no part of it.
    while (!stop.stop_requested() && !device_.wait_for(value - 1, kStepNs)) {
    }
    const int64_t begun_ns = idle_since_ns = monotonic_ns();
    while (!stop.stop_requested() && !is_done && monotonic_ns() < begun_ns + limit_ns)
      is_done = device_.wait_for(value, std::min(kStepNs, begun_ns + limit_ns - monotonic_ns()));
    lock.lock();
    if (!is_done && !stop.stop_requested()) end_now(monotonic_ns() - begun_ns);
    lock.unlock();
    while (!stop.stop_requested() && !device_.wait_for(value, kStepNs)) {
    }
    lock.lock();
    running_.pop_front();
  }
}

// A submission that is done keeps its words until release(), which waits for the mutex.
void SubmissionLimits::end_now(int64_t ran_ns) {
  const uint64_t done = device_.completed();
  const Cause cause = running_.front().cause;
  for (const Running& running : running_) {
    if (running.value <= done || running.words.empty()) continue;
    for (uint64_t* const word : running.words) std::atomic_ref(*word).store(1, std::memory_order_relaxed);
    note_early_end(running.value);
    if (cause == Cause::image) return;  // those in flight behind it are other images
    ended_ns_ = ran_ns;
  }
}

void SubmissionLimits::note_early_end(uint64_t value) {
  early_ends_.push_back(value);
  while (early_ends_.size() > kMaxEarlyEnds) early_ends_.pop_front();
}

}  // namespace fire3dv::gpu
