// The edited scene of a fuzzed session: app::LiveScene without renderer and camera. Builds end when the
// caller says so, so that the same input gives the same session.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "renderer/app/scene_build.h"
#include "renderer/scene/scene_edits.h"
#include "renderer/state/edit_book.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::fuzz {

// A valid binary glTF file of a few nodes; assets and the base scene are made of it.
std::vector<std::byte> small_glb();
const scene::LoadedScene& base_scene();

class SessionScene {
 public:
  explicit SessionScene(state::PoseState& poses);

  // Applies what streams have changed, as app::LiveScene::follow() does between two frames.
  bool follow(bool finish_build);

  bool is_settled() const { return build_.idle() && book_.empty(); }
  const scene::Scene& scene() const { return merged_ ? merged_->scene : base_scene().scene; }
  // Nodes that an edit hides or removes, without those whose own stream has withdrawn them.
  const std::set<uint32_t>& hidden() const { return hidden_; }
  // Smallest age of a stream that has asked to hide or remove this node; nothing: none has.
  std::optional<uint64_t> oldest_hider(uint32_t node) const;

 private:
  using Keys = std::vector<std::pair<uint64_t, uint64_t>>;
  void note_hiding(const std::vector<state::SceneChanges>& changes);
  bool show_built(app::SceneBuild::Built&& built);
  void begin_build(std::vector<state::WantedNode> wanted, const std::vector<std::string>& vertex_nodes);
  void resolve(const std::vector<state::WantedNode>& wanted);

  state::PoseState& poses_;
  state::EditBook book_;
  scene::SceneEdits edits_;
  std::unique_ptr<const scene::LoadedScene> merged_;
  std::vector<state::WantedNode> added_;
  Keys nodes_;
  std::vector<std::string> vertex_nodes_;
  std::map<uint64_t, std::map<std::pair<std::string, wire::Property>, bool>> hiding_;  // by age
  std::set<uint32_t> hidden_;
  app::SceneBuild build_;
};

}  // namespace fire3dv::fuzz
