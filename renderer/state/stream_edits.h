// The scene edits of one stream on their way to the scene: of each key the newest, until somebody takes them.
// Says which pose frames may be shown: those whose scene version is applied.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "protocol/wire/scene_edit.h"

namespace fire3dv::state {

class StreamEdits {
 public:
  // What a stream may make its reader keep.
  struct Limits {
    size_t keys = 65'536;
    size_t waiting_bytes = size_t{256} << 20;  // of values that were not taken yet
  };
  enum class Outcome {
    taken,
    stale,    // not newer than what has come
    refused,  // over a limit; its version counts, or frames would wait for ever for what cannot be had
  };

  StreamEdits() = default;
  explicit StreamEdits(Limits limits) : limits_(limits) {}

  Outcome add(wire::SceneEdit&& edit);
  // An edit of a later minor version: without effect, but applied.
  Outcome skip(uint64_t version);

  // All edits up to here are in effect, or will be before the next picture.
  uint64_t applied() const {
    return loading_.empty() ? received_ : std::min(received_, *loading_.begin() - 1);
  }

  // By version. What came since the last call; an edit that a newer one of its key replaced is not among
  // them.
  std::vector<wire::SceneEdit> take();
  bool has_news() const { return !waiting_.empty(); }
  // Something of this stream has been taken.
  bool was_taken() const { return was_taken_; }

  // Added nodes and vertices are not in effect when they come, but when finish() is told so: reading a file
  // takes longer than a frame. From now on.
  void load_aside() { load_aside_ = true; }
  void finish(uint64_t version) { loading_.erase(version); }

 private:
  using Key = std::pair<std::string, wire::Property>;

  Limits limits_;
  std::set<Key> keys_;  // all that ever came
  std::map<Key, wire::SceneEdit> waiting_;
  size_t waiting_bytes_ = 0;
  uint64_t received_ = 0;
  bool load_aside_ = false;
  std::set<uint64_t> loading_;
  bool was_taken_ = false;
};

}  // namespace fire3dv::state
