// The scene that is shown, as streams edit it: what is changed of its nodes is drawn with the next frame;
// what is added to it is made aside, and replaces the scene between two frames.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "renderer/app/loading/replacement_shares.h"
#include "renderer/app/loading/scene_build.h"
#include "renderer/app/window/camera_rig.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/edits/scene_edits.h"
#include "renderer/state/animation.h"
#include "renderer/state/edit_book.h"

namespace fire3dv::app {

// What the user changes of it, beside what streams do. By nodes of the scene that is shown.
struct UserEdits {
  std::set<uint32_t> hidden;                // with what is below them
  uint32_t isolated = scene::kNone;         // only this one and what is below it is drawn
  std::map<uint32_t, scene::Light> lights;  // instead of the file's and of streams'
  scene::MaterialEdits materials;
  bool operator==(const UserEdits&) const = default;
};

// Of a node's light as these edits and the file have it; nothing: it has none.
std::optional<scene::LightType> kind_of_light(const scene::Scene& scene, const scene::NodeEdits& edits,
                                              uint32_t node);

class LiveScene {
 public:
  // All is borrowed, and of this scene.
  LiveScene(const scene::LoadedScene& base, state::PoseState& poses, passes::SceneRenderer& renderer,
            CameraRig& camera, AssetSettings assets);

  // Plays on when the scene is replaced. These are of the file, and outlive this.
  void keep_playing(std::optional<state::AnimationPlayer>& player, std::vector<uint32_t> animations);

  // For whoever keeps numbers of nodes: called before the old scene goes.
  using Replaced = std::function<void(const scene::Scene& before, const scene::Scene& after)>;
  void tell_replaced(Replaced replaced) { on_replaced_ = std::move(replaced); }
  // Of a stream's edits: called with the time that they took in follow().
  using EditTime = std::function<void(state::StreamId stream, int64_t ns)>;
  void charge_edit_time(EditTime edit_time) { edit_time_ = std::move(edit_time); }
  // Is in effect after the next follow().
  void set_user_edits(const UserEdits& edits);

  // Another renderer has taken the place of the one that was given, at the same address.
  void renderer_is_new();

  // Between two frames: does what streams have asked for since the last call. Returns true when there is a
  // new pose frame to show, which had waited for that.
  bool follow();
  // After follow(): nothing of what was asked for is still being made.
  bool settled() const { return build_.idle() && pending_.empty(); }

  const scene::Scene& scene() const { return shown().scene; }
  const scene::LoadedScene& loaded() const { return shown(); }
  const scene::SceneEdits& edits() const { return edits_; }
  const state::EditFaults& faults() const { return book_.faults(); }
  uint64_t replaced() const { return replaced_; }  // how often the scene was
  uint64_t builds_begun() const { return builds_begun_; }
  uint64_t wanted_lists_made() const { return wanted_lists_made_; }
  // Sentences for the user since the last call.
  std::vector<std::string> take_notes();
  // Other devices that draw this scene: nodes that one of them has no memory for are refused.
  void draw_on_too(std::vector<const gpu::Device*> devices) { further_devices_ = std::move(devices); }

 private:
  // What a scene is made of besides the file: streams' ages and versions, and names.
  using NodeKeys = std::vector<std::pair<uint64_t, uint64_t>>;  // in order
  struct Contents {
    NodeKeys nodes;
    std::vector<std::string> vertex_nodes;
    bool operator==(const Contents&) const = default;
  };
  const scene::LoadedScene& shown() const { return merged_ ? *merged_ : base_; }
  bool show_built();
  Result<void> upload_scene(const SceneBuild::Built& built);
  Result<void> check_memory(const scene::LoadedScene& next) const;
  void refuse_new(SceneBuild::Built&& built, const std::string& reason);
  void take_edits(std::vector<state::SceneChanges> changes);
  bool may_build(const ReplacementShares::Peer& peer) const;
  bool can_build() const;
  void list_wanted();
  void resolve();
  std::optional<scene::NodeEdit> edit_of(const scene::NodeEdits& of_streams, uint32_t node) const;
  void note_vertex_changes();
  void build_if_other();
  void note_causes(const SceneBuild::Built& built);
  void charge_replacement(int64_t shown_ns);

  const scene::LoadedScene& base_;
  std::unique_ptr<const scene::LoadedScene> merged_;  // null: the file's own
  state::PoseState& poses_;
  passes::SceneRenderer& renderer_;
  CameraRig& camera_;
  std::optional<state::AnimationPlayer>* player_ = nullptr;
  std::vector<uint32_t> animations_;
  state::EditRegistry book_;
  scene::SceneEdits edits_;
  UserEdits user_;
  bool user_changed_ = false;
  Replaced on_replaced_;
  uint64_t bindings_seen_ = 0, replaced_ = 0, builds_begun_ = 0, wanted_lists_made_ = 0;
  std::vector<state::WantedNode> wanted_;  // as of wanted_revision_
  NodeKeys wanted_keys_;
  uint64_t wanted_revision_ = 0;
  Contents contents_;                                                // of what is shown
  std::optional<Contents> impossible_;                               // what could not be shown
  std::vector<state::WantedNode> added_;                             // to it
  std::map<std::pair<uint64_t, uint64_t>, uint32_t> root_of_added_;  // by age and version
  std::set<uint32_t> gone_;                       // of the added nodes: those that nobody wants any more
  std::set<ReplacementShares::Peer> pending_;     // peers with changes that are not in the scene yet
  std::vector<ReplacementShares::Cause> causes_;  // whose changes are being built, or were shown last
  ReplacementShares shares_;
  int64_t merge_ns_ = 0, list_ns_ = 0;  // of that build, and what listing its nodes took
  int64_t replacement_ns_ = 0;
  EditTime edit_time_;
  std::vector<const gpu::Device*> further_devices_;
  uint32_t reported_without_shadow_ = 0;
  SceneBuild build_;
};

}  // namespace fire3dv::app
