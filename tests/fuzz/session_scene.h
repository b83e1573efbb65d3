// Edited scene of a fuzzed session: app::LiveScene without renderer and camera. The caller ends the builds,
// so equal inputs give equal sessions.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "renderer/app/loading/scene_build.h"
#include "renderer/scene/edits/scene_edits.h"
#include "renderer/state/edit_registry.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::fuzz {

// Returns a valid binary glTF file of a few nodes, for assets and the base scene.
std::vector<std::byte> small_glb();
const scene::LoadedScene& base_scene();

class SessionScene {
 public:
  explicit SessionScene(state::PoseState& poses);

  // Applies the pending edits of streams, as app::LiveScene::follow() does between two frames.
  bool follow(bool finish_build);

  bool is_settled() const { return build_.idle() && registry_.empty(); }
  const scene::Scene& scene() const { return merged_ ? merged_->scene : base_scene().scene; }
  // Returns the nodes hidden or removed by an edit, except for those that their own stream has withdrawn.
  const std::set<uint32_t>& hidden() const { return hidden_; }
  // Returns the smallest age of a stream with an edit that hides or removes this node; nothing if there is
  // none.
  std::optional<uint64_t> oldest_hider(uint32_t node) const;

 private:
  using Keys = std::vector<std::pair<uint64_t, uint64_t>>;
  void note_hiding(const std::vector<state::SceneChanges>& changes);
  bool show_built(app::SceneBuild::Built&& built);
  void begin_build(std::vector<state::RequestedNode> wanted, const std::vector<std::string>& vertex_nodes);
  void resolve(const std::vector<state::RequestedNode>& wanted);

  state::PoseState& poses_;
  state::EditRegistry registry_;
  scene::SceneEdits edits_;
  std::unique_ptr<const scene::LoadedScene> merged_;
  std::vector<state::RequestedNode> added_;
  Keys nodes_;
  std::vector<std::string> vertex_nodes_;
  std::map<uint64_t, std::map<std::pair<std::string, wire::Property>, bool>> hiding_;  // by age
  std::set<uint32_t> hidden_;
  app::SceneBuild build_;
};

}  // namespace fire3dv::fuzz
