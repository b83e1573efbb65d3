// Displayed scene with the edits of streams and of the user, in effect with the next frame. Added nodes need
// a merged scene, built on another thread, which replaces the displayed one between frames. Single-threaded.
// More than 60 members: base, merged scene, edits and charges must change in one step, between two frames.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/live_scene/peer_charges.h"
#include "renderer/live_scene/scene_build.h"
#include "renderer/live_scene/scene_uploader.h"
#include "renderer/live_scene/user_additions.h"
#include "renderer/live_scene/vertex_pacing.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/edits/addition.h"
#include "renderer/state/edits/edit_registry.h"
#include "renderer/state/edits/user_edits.h"
#include "renderer/state/marker_registry.h"
#include "renderer/state/motion/animation.h"

namespace fire3dv::app {

using UserEdits = state::UserEdits;

// Type of a node's light by these edits, else by the file; nullopt: it has none.
std::optional<scene::LightType> light_type(const scene::Scene& scene, const scene::NodeEdits& edits,
                                           uint32_t node);

class LiveScene {
 public:
  // Borrows all arguments except `assets`. poses and uploader refer to the base scene.
  LiveScene(const scene::LoadedScene& base, state::PoseState& poses, SceneUploader& uploader,
            AssetSettings assets);

  // Animations of the file, whose player is replaced with the scene. Borrowed.
  void set_animations(std::optional<state::AnimationPlayer>& player, std::vector<uint32_t> animations);

  // Called before the old scene is destroyed, so that observers can map node indices. Several observers are
  // called in the order in which they were added.
  using Replaced = std::function<void(const scene::Scene& before, const scene::Scene& after)>;
  void on_scene_replaced(Replaced replaced) { on_replaced_.push_back(std::move(replaced)); }
  // Called with the time that the edits of a stream took in follow().
  using EditTime = std::function<void(state::StreamId stream, int64_t ns)>;
  void charge_edit_time(EditTime edit_time) { edit_time_ = std::move(edit_time); }
  // Called with each change of a stream before follow() applies it.
  using EditObserver = std::function<void(const state::SceneChanges& change)>;
  void observe_edits(EditObserver observer) { edit_observer_ = std::move(observer); }
  // Paces streamed vertices of several peers. Off by default, as for data sets and lockstep.
  void pace_vertices(bool paces) { paces_vertices_ = paces; }
  VertexPacing& vertex_pacing() { return vertex_pacing_; }
  // In effect after the next follow(); additions when their build is shown.
  void set_user_edits(const UserEdits& edits);
  const UserEdits& user_edits() const { return user_; }
  // The user's additions that are displayed, by root.
  const std::vector<ShownAddition>& shown_additions() const { return shown_additions_; }
  // Materials of all files that the user and streams have added to the displayed scene.
  const std::vector<state::AddedMaterials>& added_materials() const { return added_materials_; }
  // Names and reasons of the first ones that are not displayed.
  auto refused_additions(size_t most) const { return additions_.refused(most); }
  uint64_t user_revision() const { return user_revision_; }  // rises with each change of user_edits()

  // Material variant of the file; kNone: its default materials. The base scene has the first one.
  void set_loaded_variant(uint32_t variant) {
    loaded_variant_ = variant_ = requested_variant_ = user_.variant = variant;
  }
  // In effect after a follow() without a build in progress: the scene is replaced by one with the same nodes.
  // A change of user_edits().variant requests it.
  void request_variant(uint32_t variant) { requested_variant_ = variant; }
  uint32_t variant() const { return variant_; }
  // True once after a requested variant could not be shown: variant() stays, also in user_edits().
  bool take_variant_refusal() { return std::exchange(is_variant_refused_, false); }
  // True if replace_base() may be called now: no build is running.
  bool can_replace_base() const { return build_.idle(); }
  // Shows another version of the file. Streams keep their nodes by path, else by name; nodes that they add
  // come back with the next build. animations: those of the next version that play. Call between two frames,
  // before follow(); both versions must be alive, and the next one as long as this. After an error the
  // displayed scene stays.
  Result<void> replace_base(const scene::LoadedScene& next, std::vector<uint32_t> animations);

  // Applies the edits since the last call; called between two frames. Returns true if a pose frame that
  // waited for its edits is shown now.
  bool follow();
  // Waits until the user's additions are displayed or refused. should_stop: ends the wait; called many times
  // a second. Returns false if it ended the wait.
  bool await_additions(const std::function<bool()>& should_stop = {});
  // A finished build is shown by the next follow().
  bool is_building() const { return !build_.idle(); }
  bool has_finished_build() const { return build_.is_finished(); }
  // True if no build is running or due. Valid after follow().
  bool settled() const { return build_.idle() && pending_.empty(); }

  const scene::Scene& scene() const { return shown().scene; }
  const scene::LoadedScene& loaded() const { return shown(); }
  // Leading nodes of scene() that are of the file; the others were added.
  uint32_t file_nodes() const { return static_cast<uint32_t>(base().scene.nodes.size()); }
  const scene::SceneEdits& edits() const { return edits_; }
  // Makes the markers of streams, for the poses shown now, and those of the viewer's overlay those of the
  // next images.
  void show_markers(std::span<const state::ShownMarker> overlay = {});
  const state::MarkerRegistry& markers() const { return markers_; }

  // Root of an asset or node that a peer has added.
  struct PeerRoot {
    const PeerBudget* peer = nullptr;  // identity only
    uint32_t node = 0;
  };
  // Of the displayed scene, without withdrawn ones; additions of the user have no peer.
  std::vector<PeerRoot> peer_roots() const;
  // Hides the markers and added nodes of these peers, keeps the vertices that they replace as they were drawn
  // last, and adds no further nodes of theirs. In effect with the next image.
  void set_hidden_peers(std::set<const PeerBudget*> peers);
  bool hides_peers() const { return !hidden_peers_.empty(); }
  const PeerBudget* vertex_peer(uint32_t node) const { return registry_.vertex_uses().peer(node); }
  // Called with a scene before its upload, and the roots of the peers that it adds nodes of. Returns the
  // peers whose nodes would take too long to prepare: then the scene is dropped, and these peers must be
  // hidden.
  using Admission = std::function<std::set<const PeerBudget*>(const scene::LoadedScene& next,
                                                              const std::vector<PeerRoot>& roots)>;
  void set_admission(Admission admission) { admission_ = std::move(admission); }
  // Peers that have added or removed nodes since the last call.
  std::set<const PeerBudget*> take_changed_peers() { return std::exchange(changed_peers_, {}); }
  // Called after an image was recorded.
  void note_drawn();

  void set_shows_markers(bool shows) { shows_markers_ = shows; }
  state::EditFaults faults() const {
    state::EditFaults faults = registry_.faults();
    faults.skipped = vertex_pacing_.skipped();
    return faults;
  }
  // Added nodes of the displayed scene that nobody requests any more: they are hidden.
  const std::set<uint32_t>& withdrawn_nodes() const { return withdrawn_; }
  uint64_t replaced() const { return replaced_; }  // number of replacements of the scene
  uint64_t updates() const { return updates_; }    // rises whenever follow() may have changed the scene
  uint64_t builds_begun() const { return builds_begun_; }
  uint64_t request_lists_made() const { return request_lists_made_; }
  // Log messages since the last call.
  std::vector<std::string> take_log_messages();
  // For the streams that have sent them.
  std::vector<state::EditRegistry::Ineffective> take_ineffective_edits() {
    return registry_.take_ineffective();
  }

 private:
  // Contents of a merged scene beyond the file.
  using NodeKeys = std::vector<std::pair<uint64_t, uint64_t>>;  // age and version, sorted
  struct Contents {
    NodeKeys nodes;
    std::vector<std::string> vertex_nodes;
    bool operator==(const Contents&) const = default;
  };
  // The file's scene, with another variant if one was requested.
  const scene::LoadedScene& base() const { return variant_base_ ? *variant_base_ : *base_; }
  const scene::LoadedScene& shown() const { return merged_ ? *merged_ : base(); }
  bool show_variant();
  void set_additions(const state::Additions& additions);
  void notify_replaced(const scene::Scene& before);
  bool show_built();
  Result<void> upload_built(const SceneBuild::Built& built);
  void refuse_new(SceneBuild::Built&& built, const std::string& reason);
  bool pace_edits(std::vector<state::SceneChanges>& changes);
  void apply_edits(std::vector<state::SceneChanges> changes);
  bool has_other_peers() const;
  bool is_build_due(const ReplacementShares::Peer& peer) const;
  bool can_build() const;
  void update_request_list();
  void refuse(const state::RequestedNode& node, const std::string& reason, bool is_for_memory = false);
  bool confirm(const state::RequestedNode& node);
  void resolve();
  std::optional<scene::NodeEdit> combined_edit(const scene::NodeEdits& of_streams, uint32_t node) const;
  void find_vertex_changes();
  bool is_admitted(SceneBuild::Built& built);
  void find_hidden_roots();
  void begin_build_if_changed();
  void record_causes(const SceneBuild::Built& built);
  void report_asset_warnings(const std::vector<std::string>& warnings);
  void charge_replacement(int64_t shown_ns);

  const scene::LoadedScene* base_;
  std::unique_ptr<const scene::LoadedScene> variant_base_;  // null: the loaded variant
  uint32_t loaded_variant_ = scene::kNone, variant_ = scene::kNone, requested_variant_ = scene::kNone;
  bool is_variant_refused_ = false;
  std::unique_ptr<const scene::LoadedScene> merged_;  // null: the base scene is shown
  state::PoseState& poses_;
  SceneUploader& uploader_;
  std::optional<state::AnimationPlayer>* player_ = nullptr;
  std::vector<uint32_t> animations_;
  state::EditRegistry registry_;
  state::MarkerRegistry markers_;
  bool shows_markers_ = true;                      // of streams
  std::vector<state::ShownMarker> shown_markers_;  // while there are others than those of streams
  bool reported_marker_memory_ = false;
  scene::SceneEdits edits_;
  UserEdits user_;
  bool user_changed_ = false;
  uint64_t user_revision_ = 0;
  const std::function<int64_t()> now_ns_;
  UserAdditions additions_;
  const std::string file_of_additions_;  // beginning of messages about them
  std::vector<ShownAddition> shown_additions_;
  std::vector<state::AddedMaterials> added_materials_;
  std::vector<Replaced> on_replaced_;
  uint64_t bindings_seen_ = 0, replaced_ = 0, updates_ = 0, builds_begun_ = 0, request_lists_made_ = 0;
  std::vector<state::RequestedNode> requested_;  // as of requested_revision_
  NodeKeys requested_keys_;
  uint64_t requested_revision_ = 0, requested_additions_ = 0;
  Contents contents_;                        // of the displayed scene
  std::optional<Contents> failed_contents_;  // of the last scene that could not be displayed
  std::vector<state::RequestedNode> added_;  // nodes of the displayed scene
  std::set<const PeerBudget*> hidden_peers_, changed_peers_;
  std::set<uint32_t> hidden_roots_;  // of hidden peers
  // As drawn last; empty while no peer replaces vertices.
  std::map<uint32_t, std::shared_ptr<const scene::ReplacedVertices>> drawn_vertices_;
  uint64_t drawn_vertices_revision_ = 0;
  Admission admission_;
  std::map<std::pair<uint64_t, uint64_t>, uint32_t> root_of_added_;  // by age and version
  std::set<uint32_t> withdrawn_;                  // added nodes that are not requested any more
  std::set<ReplacementShares::Peer> pending_;     // peers with changes that are not in the scene yet
  std::vector<ReplacementShares::Cause> causes_;  // peers whose changes are being built, or were shown last
  ReplacementShares shares_;
  VertexPacing vertex_pacing_;
  bool paces_vertices_ = false;
  int64_t merge_ns_ = 0, list_ns_ = 0;  // of the last build: merging, and listing its nodes
  int64_t replacement_ns_ = 0;          // least pause between two replacements
  EditTime edit_time_;
  EditObserver edit_observer_;
  uint32_t reported_without_shadow_ = 0;
  uint32_t reported_asset_warnings_ = 0;
  std::vector<std::string> log_messages_;
  SceneBuild build_;
};

}  // namespace fire3dv::app
