// Scalars and markers of the streams of a recording, for its report. Memory is bounded, whatever the file
// holds.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/peer_budget.h"
#include "protocol/stream/scalar_history.h"
#include "protocol/wire/limits.h"
#include "protocol/wire/scene_edit.h"

namespace fire3dv::inspect {

// One line per scalar: group and name, unit, and statistics.
std::string scalar_text(const stream::ScalarHistory& scalars, const char* indent);
nlohmann::json scalar_json(const stream::ScalarHistory& scalars);

struct MarkerSeen {
  uint8_t kind = 0;       // of the newest value; may be of a later version
  uint64_t elements = 0;  // of the newest value
  uint64_t values = 0;    // how often it was set
  bool is_cleared = false;
};

class RecordedEdits {
 public:
  static constexpr size_t kMaxMarkers = wire::kMaxSceneEdits;  // of all streams
  static constexpr size_t kMaxListed = 64;                     // of each stream, in the text

  // Takes an edit of a stream, in the order of the file. Repeated ones, as in snapshots, count once. A new
  // epoch restarts the statistics of scalars; markers keep their counts.
  void take(const std::string& stream, const wire::SceneEdit& edit);

  // Lines for the stream; empty if it has neither.
  std::string text(const std::string& stream) const;
  // Adds members "scalars" and "markers".
  void add_json(const std::string& stream, nlohmann::json& to) const;

 private:
  struct StreamEdits {
    uint64_t epoch = 0, version = 0;  // of the newest edit
    stream::ScalarHistory scalars;
    std::map<std::string, MarkerSeen> markers;
    uint64_t further_markers = 0;  // edits of names beyond kMaxMarkers
  };
  // Of the scalars of all streams.
  std::shared_ptr<PeerBudget> budget_ = BudgetPool::create()->add_peer("scalars");
  std::map<std::string, StreamEdits> streams_;
  size_t marker_count_ = 0;
};

}  // namespace fire3dv::inspect
