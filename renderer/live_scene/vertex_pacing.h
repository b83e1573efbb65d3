// Pace of streamed vertices while several streams are shown. Each update of vertices rebuilds normals and
// acceleration structures; a peer has a share of the time for it. The newest update waits, older ones are
// skipped. It has no clock: callers pass the time. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

class VertexPacing {
 public:
  // Takes updates that have to wait out of the changes of one stream, and adds none. others_active: other
  // peers have streams; otherwise nothing waits. Returns the versions of the updates that wait: frames need
  // not.
  std::vector<uint64_t> hold(state::SceneChanges& change, bool others_active, int64_t now_ns);
  // Updates that have waited long enough, as changes of their streams.
  std::vector<state::SceneChanges> take_due(bool others_active, int64_t now_ns);
  // The vertices of these changes are shown by the next frame.
  void applied(const state::SceneChanges& change, int64_t now_ns);

  // The frame shows everything that was applied so far.
  void frame_recorded(uint64_t frame_index);
  // Device time of a finished frame for deformed vertices and their acceleration structures.
  void frame_finished(uint64_t frame_index, double ms);

  uint64_t skipped() const { return skipped_; }  // updates, of all streams
  // True once for each stream whose update was skipped.
  bool take_notice(uint64_t age);

  // Time without updates of a peer for each nanosecond of its updates; it has a quarter of the time.
  static constexpr double kRest = 3;
  static constexpr double kMaxPerSecond = 60;  // updates of one peer

 private:
  struct Held {
    wire::SceneEdit edit;
    BudgetCharge charge;
  };
  struct Stream {
    state::SceneChanges head;          // without edits
    std::map<std::string, Held> held;  // by node
    std::set<std::string> shown;       // nodes whose first update was applied
    int64_t next_ns = 0;
    bool has_skipped = false, is_reported = false;
  };
  struct Update {
    uint64_t frame_index = 0, vertices = 0;
  };

  std::map<uint64_t, Stream> streams_;  // by age
  std::deque<Update> updates_;          // frames in flight
  uint64_t unseen_vertices_ = 0;        // applied, in no frame yet
  double ns_per_vertex_ = 0;            // 0: not measured
  uint64_t skipped_ = 0;
};

}  // namespace fire3dv::app
