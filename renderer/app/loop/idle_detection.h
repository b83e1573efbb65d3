// Detection of idle runs: an image that would equal the last one is not drawn, and waits become longer.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

namespace fire3dv::app {

class IdleDetection {
 public:
  using Clock = std::chrono::steady_clock;

  // Notes the revisions of everything that images show. is_active: an image must follow in any case.
  void update(const std::array<uint64_t, 3>& revisions, bool is_active);
  // Notes activity without a changed image, such as requested images.
  void note_activity() { changed_ = Clock::now(); }
  // True while images of the last change are due; counts them. Call once a turn.
  bool take_due_image();
  // Tooltips of a window appear late: it is drawn for a while after a change.
  bool is_lingering() const { return Clock::now() < lingers_until_; }
  // True for a while after the last activity: poses may change again at any time.
  bool is_busy() const { return Clock::now() - changed_ < kBusyTime; }

 private:
  static constexpr auto kBusyTime = std::chrono::seconds(1);

  std::optional<std::array<uint64_t, 3>> revisions_;
  int due_images_ = 0;
  Clock::time_point changed_ = Clock::now(), lingers_until_ = changed_;
};

}  // namespace fire3dv::app
