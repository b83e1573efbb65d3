// Scalars of streams for the plots of live view pages: a list of their names, and their samples in messages
// that grow only while the page keeps up. Frame loop's thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/state/pose_state.h"

namespace fire3dv::app {

constexpr size_t kMaxListedScalars = 1000;

// The first kMaxListedScalars scalars of all active streams, by stream and name.
class ScalarList {
 public:
  struct Entry {
    uint64_t epoch = 0;  // of the stream
    std::string stream, group, name, unit;
    size_t scalar = 0;  // index in the group
    bool operator==(const Entry&) const = default;
  };
  // Number of scalars of all active streams.
  static size_t count(const state::PoseState& poses);

  // Returns true if the list has changed; it has another number then.
  bool update(const state::PoseState& poses);
  uint32_t number() const { return number_; }  // 0: never updated
  const std::vector<Entry>& entries() const { return entries_; }
  const std::string& message() const { return message_; }  // "scalars"

 private:
  uint32_t number_ = 0;
  std::vector<Entry> entries_;
  size_t omitted_ = 0;
  std::string message_;
};

// Samples for one page. It has one message in flight, which the page acknowledges when it has drawn it.
class PlotFeed {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr size_t kMinSamples = 256, kMaxSamples = 4096;  // of a message

  bool is_open() const { return is_open_; }  // the page shows its plot
  void close();
  // list: number of the one that the page has; another than the current one: it gets that, and no samples.
  // plotted: indices of it; those out of range are ignored.
  void open(const ScalarList& now, uint32_t list, std::span<const uint32_t> plotted);
  // The page has drawn a message.
  void on_plotted(uint32_t number, Clock::time_point now);
  // Returns true if the page needs the list now.
  bool take_list(const ScalarList& now, Clock::time_point at);
  // Message "samples" that is due now.
  std::optional<std::string> take_samples(const state::PoseState& poses, Clock::time_point now);

 private:
  struct Curve {
    uint32_t index = 0;  // of the list
    ScalarList::Entry of;
    std::optional<int64_t> sent_ns;  // newest sample on the page
    double sent_value = 0;
    uint64_t finite_values = 0;  // of the group's history at that time
  };

  bool is_open_ = false, is_full_ = false;
  uint32_t list_ = 0, number_ = 0;
  bool in_flight_ = false;
  Clock::time_point sent_{}, listed_{};
  size_t samples_ = 2 * kMinSamples;
  std::optional<int64_t> base_ns_;  // times are sent as differences, so that JavaScript has all their digits
  std::vector<Curve> curves_;
};

}  // namespace fire3dv::app
