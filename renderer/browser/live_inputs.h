// Declared inputs of streams for pages of the live view that have control. Frame loop's thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/browser/server/server.h"
#include "renderer/state/pose_state.h"
#include "renderer/streams/input_router.h"

namespace fire3dv::app {

// Viewers of the live view count from 1; 0 is the window.
inline InputViewer input_viewer(serve::ViewerId viewer) {
  return static_cast<InputViewer>(viewer);
}

// The inputs of all streams that can be reached, by stream and name.
class InputList {
 public:
  static constexpr size_t kMaxListed = 512;
  static constexpr size_t kMaxTextBytes = 256 << 10;  // of all names, choices and texts

  struct Entry {
    uint64_t epoch = 0;  // of the stream
    std::string name;
    bool operator==(const Entry&) const = default;
  };
  // Returns true if message() has changed. The list has another number if its entries have.
  bool update(const InputRouter& router, const state::PoseState& poses);
  uint32_t number() const { return number_; }              // 0: there were no inputs yet
  const std::string& message() const { return message_; }  // "inputs"
  // Null: another list, or no such index.
  const Entry* find(uint32_t list, uint32_t index) const {
    return list == number_ && index < entries_.size() ? &entries_[index] : nullptr;
  }

 private:
  uint32_t number_ = 0;
  uint64_t revision_ = 0, structure_ = 0;
  std::vector<Entry> entries_;
  std::string message_;
};

}  // namespace fire3dv::app
