// What all streams have changed of the scene besides poses: of each key the newest value, for as long as its
// stream lasts. Finds the nodes they speak of and settles who may edit which.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "protocol/wire/scene_edit.h"
#include "renderer/scene/scene_edits.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::state {

// Edits without effect, by cause; each version of a key is counted once.
struct EditFaults {
  uint64_t conflicting = 0;  // an older stream moves or edits the node
  uint64_t unmatched = 0;    // no node has the name
  uint64_t unfit = 0;        // the node cannot take the value
};

class EditBook {
 public:
  // What PoseState::take_scene_changes() hands on.
  void take(std::vector<SceneChanges> changes);

  // What all of it makes of the scene that `poses` is of.
  scene::NodeEdits resolve(const scene::Scene& scene, const PoseState& poses);

  bool empty() const { return streams_.empty(); }
  const EditFaults& faults() const { return faults_; }
  // Sentences for the user since the last call.
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

 private:
  using Key = std::pair<std::string, wire::Property>;
  struct Kept {
    wire::SceneEdit edit;
    uint64_t fault_version = 0;  // the newest that was counted as a fault
  };
  struct StreamBook {
    StreamId id = kNone;
    std::string name;
    std::map<Key, Kept> edits;
    std::vector<uint64_t EditFaults::*> told;  // causes that the user has heard of
  };
  void fault(StreamBook& stream, Kept& kept, uint64_t EditFaults::*cause, const std::string& reason);
  void apply(const scene::Scene& scene, uint32_t node, StreamBook& stream, Kept& kept,
             scene::NodeEdit& result);

  std::map<uint64_t, StreamBook> streams_;  // by age, the oldest first
  EditFaults faults_;
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::state
