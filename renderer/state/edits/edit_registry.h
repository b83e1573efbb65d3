// Registry of scene edits in force: the newest value of each key while its stream lasts. It binds edits to
// nodes and resolves conflicts: the oldest stream that edits or drives a node owns it, and the visibility of
// its ancestors. A changed key costs the edits of its node; while a younger stream hides or removes nodes, a
// change of owners costs one pass over all nodes; a replaced scene is resolved whole. Not thread-safe.
// More than 60 members: a key's value, owner, memory and effect change together, or a limit could be evaded.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "protocol/wire/scene_edit.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/edits/addition.h"
#include "renderer/state/edits/vertex_uses.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::state {

// Edits without effect, by cause; each version of a key is counted once.
struct EditFaults {
  uint64_t conflicting = 0;  // an older stream drives or edits the node
  uint64_t unmatched = 0;    // no node has the name
  uint64_t unfit = 0;        // the node cannot take the value
  uint64_t refused = 0;      // nodes that could not be added
  uint64_t skipped = 0;      // vertices that newer ones replaced before their turn
};

// Addition of a node that a stream or the user has requested.
struct RequestedNode {
  uint64_t age = 0;      // of the stream
  uint64_t version = 0;  // of the edit; age and version identify the request, and are never reused
  std::string name;
  std::shared_ptr<const wire::NodeAdded> added;
  std::shared_ptr<PeerBudget> budget = nullptr;        // of the requesting peer; null: no limits
  std::shared_ptr<const Addition> addition = nullptr;  // by the user; null: by a stream
};

class EditRegistry {
 public:
  // Stores the changes of PoseState::take_scene_changes(). file_names: names of the scene file; an added node
  // with such a name is refused. Null: not checked.
  void apply(std::vector<SceneChanges> changes, const NodeNames* file_names = nullptr);

  // Resolves the edits for this scene, which `poses` refers to. complete: all requested nodes have been added
  // or refused, so that unmatched names are faults.
  const scene::NodeEdits& resolve(const scene::Scene& scene, const PoseState& poses, bool complete = true);
  // Nodes resolved since the last call, in ascending order. all: the scene was replaced.
  struct Resolved {
    bool all = false;
    std::vector<uint32_t> nodes;
  };
  Resolved take_resolved();
  // Number of nodes resolved so far, for tests and measurements.
  uint64_t nodes_resolved() const { return nodes_resolved_; }

  // Requested nodes of all streams, the oldest stream first, by version. Two streams may request one name.
  std::vector<RequestedNode> requested_nodes() const;
  // Incremented by every change of requested_nodes().
  uint64_t requested_revision() const { return requested_revision_; }
  // True if the request is in force and not refused.
  bool is_requested(const RequestedNode& node) const;
  // Budgets of the streams whose requested nodes changed since the last call; null: the stream ended or has
  // no budget.
  std::set<std::shared_ptr<PeerBudget>> take_changed_budgets();
  // Added nodes, by age and version, whose requests ended since the last call.
  std::vector<std::pair<uint64_t, uint64_t>> take_withdrawn_nodes() {
    return std::exchange(withdrawn_nodes_, {});
  }
  // As of the last resolve().
  const VertexUses& vertex_uses() const { return vertex_uses_; }
  // Reports that a scene with own vertices for these nodes is shown. A node that still shares its vertices is
  // refused them. reasons: messages for such nodes, by name.
  void set_built_vertex_nodes(const std::vector<std::string>& vertex_nodes,
                              std::map<std::string, std::string> reasons = {});
  // Reports that the node is in the scene. Returns true if it is still requested.
  bool confirm_node(const RequestedNode& node);
  // True if the node is in the scene, and one that replaces it is not yet.
  bool is_being_replaced(const RequestedNode& node) const;
  // Reports that the node cannot be added.
  void refuse_node(const RequestedNode& node, const std::string& reason);

  // Asynchronous edits that are in effect now or have failed: pose frames need not wait for them any more.
  struct Finished {
    StreamId stream = kNone;
    uint64_t epoch = 0;
    uint64_t version = 0;
  };
  std::vector<Finished> take_finished() { return std::exchange(finished_, {}); }

  // Edits without effect since the last call, each with its reason, for the streams that have sent them: the
  // first ones of each stream.
  struct Ineffective {
    StreamId stream = kNone;
    std::string reason;
  };
  std::vector<Ineffective> take_ineffective() { return std::exchange(ineffective_, {}); }

  bool empty() const { return streams_.empty(); }
  const EditFaults& faults() const { return faults_; }
  // Log messages since the last call.
  std::vector<std::string> take_log_messages() { return std::exchange(log_messages_, {}); }

 private:
  using Key = std::pair<std::string, wire::Property>;
  struct StreamEntry;
  struct EditInForce {
    wire::SceneEdit edit;  // without the data of `node` and `vertices`
    StreamEntry* stream = nullptr;
    uint64_t fault_version = 0;  // the newest version that was counted as a fault
    std::shared_ptr<const wire::NodeAdded> node;
    std::shared_ptr<const scene::ReplacedVertices> vertices;
    BudgetCharge charge;    // of the value
    bool is_shown = false;  // the vertices are in effect
    // Vertices that were in effect before: they stay while the newer ones wait for another mesh.
    std::shared_ptr<const scene::ReplacedVertices> before;
    BudgetCharge before_charge;
    // Version of the added node that this one replaces: it stays in the scene until this one is there. 0:
    // none.
    uint64_t replaced_version = 0;
    BudgetCharge light, shadow_light;
    bool is_light_charged = false;  // for its cost beyond the file's light
    uint32_t bound_node = kNone;    // kNone: no node has the name
    bool is_looked_up = false;      // bound_node is valid for the scene of scene_revision_
    bool finished = true;           // no frame waits for it
    bool awaits_build = false;      // counted in builds_awaited
    bool is_added = false;          // the added node is in the scene
    bool refused = false;
  };
  struct StreamEntry {
    uint64_t age = 0;
    StreamId id = kNone;
    std::string name;
    std::shared_ptr<PeerBudget> budget;
    std::map<Key, EditInForce> edits;
    std::vector<uint32_t> reserved_nodes;  // edited nodes of a suspended stream
    std::vector<uint64_t EditFaults::*> reported_causes;
    uint32_t builds_awaited = 0;  // added nodes that are not in the scene yet
    std::set<uint32_t>
        waiting_vertices;  // nodes whose newest vertices may be of a mesh that is not there yet
    uint32_t refusals_reported = 0;
    uint32_t ineffective_reported = 0;
    bool reported_shadows = false;          // lights without a shadow
    std::set<std::string> reported_opaque;  // nodes whose alpha has no effect
  };
  // Edits of one node, the oldest stream's first, and the suspended streams that reserve it.
  struct Editors {
    std::vector<EditInForce*> edits;
    std::vector<uint64_t> reserved;  // ages
    uint64_t oldest() const;         // UINT64_MAX: none
  };
  using Versions = std::map<std::pair<uint64_t, uint64_t>, EditInForce*>;  // by age and version

  void store(StreamEntry& stream, wire::SceneEdit&& edit, BudgetCharge charge);
  void resolve_name_conflict(const std::string& name, const NodeNames* file_names);
  void refuse(StreamEntry& stream, EditInForce& entry, const std::string& reason);
  void requests_changed(uint64_t age);
  void reserve(StreamEntry& stream);
  void end(StreamEntry& stream);
  void retire(EditInForce& entry);
  void link(EditInForce& entry, uint32_t node);
  void unlink(EditInForce& entry);
  void reserve_node(uint64_t age, uint32_t node);
  void release_node(uint64_t age, uint32_t node);
  void count_hiding(const EditInForce& entry, int more);
  template <typename Change>
  void change_editors(uint32_t node, const Change& change);
  void erase_refused();
  void look_up(EditInForce& entry, const PoseState& poses);
  void rebind_all(const PoseState& poses);
  void mark_driver_changes(const PoseState& poses);
  void update_owners_below(const scene::Scene& scene, const PoseState& poses);
  bool has_older_below(uint32_t node) const;
  void resolve_node(const scene::Scene& scene, const PoseState& poses, uint32_t node);
  void report_unmatched();
  void finish(StreamEntry& stream, EditInForce& entry);
  void end_wait_for_build(EditInForce& entry);
  EditInForce* find(const RequestedNode& node);
  void replace_vertices(const scene::Scene& scene, uint32_t node, StreamEntry& stream, EditInForce& entry,
                        scene::NodeEdit& result);
  bool charge_light(const scene::Scene& scene, uint32_t node, StreamEntry& stream, EditInForce& entry,
                    scene::Light& light);
  void report_opaque(const scene::Scene& scene, uint32_t node, StreamEntry& stream, const std::string& name);
  void report_to_stream(StreamEntry& stream, const std::string& reason);
  void fault(StreamEntry& stream, EditInForce& entry, uint64_t EditFaults::*cause, const std::string& reason);
  void apply_to_node(const scene::Scene& scene, uint32_t node, StreamEntry& stream, EditInForce& entry,
                     scene::NodeEdit& result);

  std::map<uint64_t, StreamEntry> streams_;  // by age, the oldest first
  // PoseState's revisions at the last resolve().
  uint64_t scene_revision_ = 0, driver_revision_ = 0;
  std::map<uint32_t, Editors> editors_;  // by node
  std::vector<uint32_t> dirty_;          // nodes to resolve again
  Versions unbound_, unmatched_, refused_;
  // Number of edits that hide or remove nodes, by node and by rank of their stream.
  std::map<uint32_t, uint32_t> hiding_edits_;
  std::map<uint64_t, uint32_t> hiding_ranks_;
  bool owners_changed_ = false;
  // Age of the oldest stream that edits or drives each node or a node below it. Empty: not needed, since no
  // stream hides nodes of an older one.
  std::vector<uint64_t> owners_below_;
  std::vector<uint32_t> parents_;  // of the scene's nodes; empty: not read yet
  scene::NodeEdits node_edits_;
  Resolved resolved_;
  uint64_t nodes_resolved_ = 0;
  EditFaults faults_;
  VertexUses vertex_uses_;
  uint64_t requested_revision_ = 0;
  std::set<uint64_t> changed_ages_;  // of streams whose requested nodes changed
  std::vector<std::pair<uint64_t, uint64_t>> withdrawn_nodes_;
  std::vector<Finished> finished_;
  std::vector<Ineffective> ineffective_;
  std::vector<std::string> log_messages_;
};

}  // namespace fire3dv::state
