// Registry of scene edits in force: of each key the newest value, for as long as its stream lasts. Binds
// edits to nodes and decides between streams: an older stream's nodes, the visibility of their ancestors and
// their names belong to it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
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
  uint64_t refused = 0;      // nodes that could not be added
};

// A node that a stream wants to be there.
struct WantedNode {
  uint64_t age = 0;      // of the stream
  uint64_t version = 0;  // of the edit; with the age this names it for good
  std::string name;
  std::shared_ptr<const wire::NodeAdded> what;
  std::shared_ptr<PeerBudget> budget = nullptr;  // of the peer that wants it; null: without limits
};

class EditBook {
 public:
  // What PoseState::take_scene_changes() hands on. file_names: of the scene that nodes are added to; an added
  // node whose name the file has already is refused. Null: not checked.
  void take(std::vector<SceneChanges> changes, const NodeNames* file_names = nullptr);

  // What all of it makes of the scene that `poses` is of. complete: no node is still on its way.
  scene::NodeEdits resolve(const scene::Scene& scene, const PoseState& poses, bool complete = true);

  // Nodes that are to be there, those of the oldest stream first, in the order in which they were asked for.
  // Two streams may ask for the same name.
  std::vector<WantedNode> wanted_nodes() const;
  // Rises with every change of wanted_nodes().
  uint64_t wanted_revision() const { return wanted_revision_; }
  // The stream still wants this node, and it has not been refused.
  bool is_wanted(const WantedNode& node) const;
  // As of the last resolve(): the nodes whose vertices are replaced, by the names that streams use.
  const std::set<std::string>& vertex_nodes() const { return vertex_nodes_; }
  // Of the peer that replaces the vertices of such a node; null: without limits.
  std::shared_ptr<PeerBudget> vertex_budget(const std::string& node) const;
  // For which of those the scene has been made; where it has no room for them they never will be.
  // reasons: sentences for nodes that could not get vertices of their own, by name.
  void scene_made_for(const std::vector<std::string>& vertex_nodes,
                      std::map<std::string, std::string> reasons = {}) {
    made_for_ = {vertex_nodes.begin(), vertex_nodes.end()};
    vertex_refusals_ = std::move(reasons);
  }
  // What has become of a wanted node.
  void node_is_there(const WantedNode& node);
  void refuse_node(const WantedNode& node, const std::string& reason);

  // Edits that take longer than a frame, which frames wait for: those that are in effect now, or never will
  // be.
  struct Finished {
    StreamId stream = kNone;
    uint64_t epoch = 0;
    uint64_t version = 0;
  };
  std::vector<Finished> take_finished() { return std::exchange(finished_, {}); }

  bool empty() const { return streams_.empty(); }
  const EditFaults& faults() const { return faults_; }
  // Sentences for the user since the last call.
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

 private:
  using Key = std::pair<std::string, wire::Property>;
  struct Kept {
    wire::SceneEdit edit;
    uint64_t fault_version = 0;                   // the newest that was counted as a fault
    std::shared_ptr<const wire::NodeAdded> node;  // what the edit held
    std::shared_ptr<const scene::ReplacedVertices> vertices;
    BudgetCharge charge;  // of the value
    BudgetCharge light, shadow_light;
    bool is_light_charged = false;  // as far as it costs more than the scene's own
    uint32_t bound_node = kNone;    // kNone: no node has the name
    bool is_searched = false;       // for that, in the scene of scene_revision_
    bool finished = true;           // no frame waits for it
    bool refused = false;
  };
  struct StreamBook {
    StreamId id = kNone;
    std::string name;
    std::shared_ptr<PeerBudget> budget;
    std::map<Key, Kept> edits;
    std::vector<uint32_t> reserved_nodes;      // of a stream that may return: it edited them
    std::vector<uint64_t EditFaults::*> told;  // causes that the user has heard of
    uint32_t refusals_told = 0;
    bool reported_shadows = false;  // that some of its lights cast none
  };
  void keep(StreamBook& stream, wire::SceneEdit&& edit, BudgetCharge charge);
  void settle_name(const std::string& name, const NodeNames* file_names);
  void refuse(StreamBook& stream, Kept& kept, const std::string& reason);
  static void reserve(StreamBook& stream);
  void bind(const PoseState& poses);
  using Owners = std::vector<uint64_t>;  // ages of streams, by node; UINT64_MAX: none
  Owners find_editors(size_t node_count) const;
  std::vector<uint64_t> find_owners_below(const scene::Scene& scene, const PoseState& poses,
                                          const Owners& editors) const;
  void finish(StreamBook& stream, Kept& kept);
  Kept* find(const WantedNode& node);
  void replace_vertices(const scene::Scene& scene, uint32_t node, StreamBook& stream, Kept& kept,
                        scene::NodeEdit& result);
  bool charge_light(const scene::Scene& scene, uint32_t node, StreamBook& stream, Kept& kept,
                    scene::Light& light);
  void fault(StreamBook& stream, Kept& kept, uint64_t EditFaults::*cause, const std::string& reason);
  void apply(const scene::Scene& scene, uint32_t node, StreamBook& stream, Kept& kept,
             scene::NodeEdit& result);

  std::map<uint64_t, StreamBook> streams_;  // by age, the oldest first
  uint64_t scene_revision_ = 0;             // of PoseState, as of the last resolve()
  EditFaults faults_;
  std::set<std::string> vertex_nodes_, made_for_;
  std::map<std::string, std::shared_ptr<PeerBudget>> vertex_budgets_;
  std::map<std::string, std::string> vertex_refusals_;
  uint64_t wanted_revision_ = 0;
  std::vector<Finished> finished_;
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::state
