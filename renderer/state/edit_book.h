// Registry of scene edits in force: of each key the newest value, for as long as its stream lasts. Binds
// edits to nodes and decides between streams: an older stream's nodes, the visibility of their ancestors and
// their names belong to it. Incremental: a changed key costs the edits of its node, whatever else is in
// force. While a younger stream hides or removes nodes, a change of a node's owner costs one pass over an
// array of all nodes. A replaced scene is resolved as a whole.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "protocol/wire/scene_edit.h"
#include "renderer/scene/edits/scene_edits.h"
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

class EditRegistry {
 public:
  // What PoseState::take_scene_changes() hands on. file_names: of the scene that nodes are added to; an added
  // node whose name the file has already is refused. Null: not checked.
  void take(std::vector<SceneChanges> changes, const NodeNames* file_names = nullptr);

  // What all of it makes of the scene that `poses` is of, brought up to date. complete: no node is still on
  // its way.
  const scene::NodeEdits& resolve(const scene::Scene& scene, const PoseState& poses, bool complete = true);
  // Nodes that resolve() has looked at since the last call, in ascending order. all: the scene was replaced.
  struct Resolved {
    bool all = false;
    std::vector<uint32_t> nodes;
  };
  Resolved take_resolved();
  // Nodes resolved so far, for tests and measurements.
  uint64_t nodes_resolved() const { return nodes_resolved_; }

  // Nodes that are to be there, those of the oldest stream first, in the order in which they were asked for.
  // Two streams may ask for the same name.
  std::vector<WantedNode> wanted_nodes() const;
  // Rises with every change of wanted_nodes().
  uint64_t wanted_revision() const { return wanted_revision_; }
  // The stream still wants this node, and it has not been refused.
  bool is_wanted(const WantedNode& node) const;
  // Peers of the streams whose wanted nodes have changed since the last call; null: of those that have ended,
  // or that have no budget.
  std::set<std::shared_ptr<PeerBudget>> take_wanted_changes();
  // Nodes, as age and version, that nobody wants any more since the last call, of those that were there.
  std::vector<std::pair<uint64_t, uint64_t>> take_unwanted() { return std::exchange(unwanted_, {}); }
  // As of the last resolve(): the nodes whose vertices are replaced, by the names that streams use.
  const std::set<std::string>& vertex_nodes() const { return vertex_nodes_; }
  // Of the peer that replaces the vertices of such a node; null: without limits.
  std::shared_ptr<PeerBudget> vertex_budget(const std::string& node) const;
  // For which of those the scene has been made; where it has no room for them they never will be.
  // reasons: sentences for nodes that could not get vertices of their own, by name.
  void scene_made_for(const std::vector<std::string>& vertex_nodes,
                      std::map<std::string, std::string> reasons = {});
  // What has become of a wanted node.
  // Returns true while it is wanted.
  bool node_is_there(const WantedNode& node);
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
  struct StreamRegistry;
  struct Kept {
    wire::SceneEdit edit;
    StreamRegistry* stream = nullptr;
    uint64_t fault_version = 0;                   // the newest that was counted as a fault
    std::shared_ptr<const wire::NodeAdded> node;  // what the edit held
    std::shared_ptr<const scene::ReplacedVertices> vertices;
    BudgetCharge charge;  // of the value
    BudgetCharge light, shadow_light;
    bool is_light_charged = false;  // as far as it costs more than the scene's own
    uint32_t bound_node = kNone;    // kNone: no node has the name
    bool is_searched = false;       // for that, in the scene of scene_revision_
    bool finished = true;           // no frame waits for it
    bool is_there = false;          // the added node is in the scene
    bool refused = false;
  };
  struct StreamRegistry {
    uint64_t age = 0;
    StreamId id = kNone;
    std::string name;
    std::shared_ptr<PeerBudget> budget;
    std::map<Key, Kept> edits;
    std::vector<uint32_t> reserved_nodes;      // of a stream that may return: it edited them
    std::vector<uint64_t EditFaults::*> told;  // causes that the user has heard of
    uint32_t refusals_told = 0;
    bool reported_shadows = false;  // that some of its lights cast none
  };
  // Edits of one node, the oldest stream's first, and the streams that may return to it.
  struct Editors {
    std::vector<Kept*> edits;
    std::vector<uint64_t> reserved;  // ages
    uint64_t oldest() const;         // UINT64_MAX: none
  };
  using Versions = std::map<std::pair<uint64_t, uint64_t>, Kept*>;  // by age and version
  struct VertexUse {
    std::string name;
    uint64_t age = 0;
  };

  void keep(StreamRegistry& stream, wire::SceneEdit&& edit, BudgetCharge charge);
  void settle_name(const std::string& name, const NodeNames* file_names);
  void refuse(StreamRegistry& stream, Kept& kept, const std::string& reason);
  void change_wanted(uint64_t age);
  void reserve(StreamRegistry& stream);
  void end(StreamRegistry& stream);
  void retire(Kept& kept);
  void link(Kept& kept, uint32_t node);
  void unlink(Kept& kept);
  void reserve_node(uint64_t age, uint32_t node);
  void release_node(uint64_t age, uint32_t node);
  void count_taker(const Kept& kept, int more);
  template <typename Change>
  void change_editors(uint32_t node, const Change& change);
  void erase_refused();
  void search(Kept& kept, const PoseState& poses);
  void bind_all(const PoseState& poses);
  void follow_drivers(const PoseState& poses);
  void find_owners_below(const scene::Scene& scene, const PoseState& poses);
  bool has_older_below(uint32_t node) const;
  void resolve_node(const scene::Scene& scene, const PoseState& poses, uint32_t node);
  void drop_vertex_uses(uint32_t node);
  void report_unmatched();
  void finish(StreamRegistry& stream, Kept& kept);
  Kept* find(const WantedNode& node);
  void replace_vertices(const scene::Scene& scene, uint32_t node, StreamRegistry& stream, Kept& kept,
                        scene::NodeEdit& result);
  bool charge_light(const scene::Scene& scene, uint32_t node, StreamRegistry& stream, Kept& kept,
                    scene::Light& light);
  void fault(StreamRegistry& stream, Kept& kept, uint64_t EditFaults::*cause, const std::string& reason);
  void apply(const scene::Scene& scene, uint32_t node, StreamRegistry& stream, Kept& kept,
             scene::NodeEdit& result);

  std::map<uint64_t, StreamRegistry> streams_;  // by age, the oldest first
  // As of the last resolve(), of PoseState.
  uint64_t scene_revision_ = 0, driver_revision_ = 0;
  std::map<uint32_t, Editors> editors_;  // of nodes with any
  std::vector<uint32_t> dirty_;          // nodes to be resolved again
  Versions unsearched_, unmatched_, refused_;
  // Nodes and ranks of streams with edits that hide or remove, and how many of these there are.
  std::map<uint32_t, uint32_t> takers_;
  std::map<uint64_t, uint32_t> taker_ranks_;
  bool owners_changed_ = false;
  // Of each node: ages of the oldest streams that edit or drive it or one below it. Empty: nobody takes nodes
  // away from an older stream, and there is no need to know.
  std::vector<uint64_t> owners_below_;
  std::vector<uint32_t> parents_;  // of the scene's nodes; empty: not known yet
  scene::NodeEdits node_edits_;
  Resolved resolved_;
  uint64_t nodes_resolved_ = 0;
  EditFaults faults_;
  std::set<std::string> vertex_nodes_, made_for_;
  std::map<uint32_t, std::vector<VertexUse>> vertex_uses_of_node_;
  std::map<std::string, std::map<std::pair<uint64_t, uint32_t>, std::shared_ptr<PeerBudget>>>
      vertex_budgets_;  // by name, age and node
  std::map<std::string, std::string> vertex_refusals_;
  uint64_t wanted_revision_ = 0;
  std::set<uint64_t> wanted_ages_;  // of streams whose wanted nodes have changed
  std::vector<std::pair<uint64_t, uint64_t>> unwanted_;
  std::vector<Finished> finished_;
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::state
