#include "renderer/app/live_scene.h"

#include <algorithm>

namespace fire3dv::app {
namespace {

std::vector<std::pair<uint64_t, uint64_t>> keys_of(const std::vector<state::WantedNode>& nodes) {
  std::vector<std::pair<uint64_t, uint64_t>> keys;
  for (const state::WantedNode& node : nodes) keys.emplace_back(node.age, node.version);
  std::sort(keys.begin(), keys.end());
  return keys;
}

}  // namespace

std::optional<scene::LightType> kind_of_light(const scene::Scene& scene, const scene::NodeEdits& edits,
                                              uint32_t node) {
  if (const auto edit = edits.find(node); edit != edits.end() && edit->second.light)
    return edit->second.light->type;
  const uint32_t light = node < scene.nodes.size() ? scene.nodes[node].light : scene::kNone;
  if (light >= scene.lights.size()) return std::nullopt;
  return scene.lights[light].type;
}

LiveScene::LiveScene(const scene::LoadedScene& base, state::PoseState& poses, passes::SceneRenderer& renderer,
                     CameraRig& camera, AssetSettings assets)
    : base_(base), poses_(poses), renderer_(renderer), camera_(camera), build_(base, std::move(assets)) {
  renderer.set_edits(edits_);
  camera.set_edits(edits_);
  poses.load_assets_aside();
}

void LiveScene::keep_playing(std::optional<state::AnimationPlayer>& player,
                             std::vector<uint32_t> animations) {
  player_ = &player;
  animations_ = std::move(animations);
}

void LiveScene::set_user_edits(const UserEdits& edits) {
  if (edits == user_) return;
  user_ = edits;
  user_changed_ = true;
}

void LiveScene::renderer_is_new() {
  renderer_.set_edits(edits_);
  renderer_.set_scene(scene(), shown().derived);
}

bool LiveScene::follow() {
  const bool built = !build_.idle() && show_built();
  std::vector<state::SceneChanges> changes = poses_.take_scene_changes();
  // Who moves a node decides whose edits of it count.
  const bool rebound = bindings_seen_ != poses_.binding_revision();
  if (!built && !user_changed_ && changes.empty() && (book_.empty() || !rebound)) return false;
  user_changed_ = false;
  bindings_seen_ = poses_.binding_revision();
  book_.take(std::move(changes), &poses_.names());
  std::vector<state::WantedNode> wanted = book_.wanted_nodes();
  resolve(wanted);
  build_if_other(std::move(wanted));
  bool shown = false;
  for (const state::EditBook::Finished& edit : book_.take_finished())
    shown |= poses_.finish_edit(edit.stream, edit.epoch, edit.version);
  return shown;
}

// What nobody wants any more is hidden at once, and gone when the next scene is made.
void LiveScene::resolve(const std::vector<state::WantedNode>& wanted) {
  scene::NodeEdits edits = book_.resolve(scene(), poses_, keys_of(wanted) == contents_.nodes);
  for (const state::WantedNode& node : added_) {
    const bool stays = std::any_of(wanted.begin(), wanted.end(), [&](const state::WantedNode& other) {
      return other.age == node.age && other.version == node.version;
    });
    const uint32_t index = stays ? scene::kNone : poses_.names().find(node.name);
    if (index != scene::kNone) edits[index].removed = true;
  }
  for (const uint32_t node : user_.hidden) edits[node].hidden = true;
  // A light that a stream has taken away, or made another kind of, is not what the user has changed.
  for (const auto& [node, light] : user_.lights) {
    const std::optional<scene::LightType> there = kind_of_light(scene(), edits, node);
    if (there == light.type) edits[node].light = light;
  }
  edits_.set(scene(), std::move(edits), user_.isolated);
  edits_.set_materials(user_.materials);
}

void LiveScene::build_if_other(std::vector<state::WantedNode> wanted) {
  if (!build_.idle()) return;  // when that is done
  const Contents contents{keys_of(wanted), {book_.vertex_nodes().begin(), book_.vertex_nodes().end()}};
  if (contents != contents_) build_.begin({std::move(wanted), contents.vertex_nodes});
}

bool LiveScene::show_built() {
  std::optional<SceneBuild::Built> built = build_.take();
  if (!built) return false;
  for (const SceneBuild::Refused& refused : built->refused) book_.refuse_node(refused.node, refused.reason);
  for (const state::WantedNode& node : built->added) book_.node_is_there(node);
  contents_ = {keys_of(built->added), std::move(built->vertex_nodes)};
  added_ = std::move(built->added);
  book_.scene_made_for(contents_.vertex_nodes);
  if (!built->scene && !merged_) return true;  // all was refused
  // The old one goes when nobody looks at it any more; its copy on the GPU retires with the frames in flight.
  const std::unique_ptr<const scene::LoadedScene> before = std::exchange(merged_, std::move(built->scene));
  if (on_replaced_) on_replaced_(before ? before->scene : base_.scene, scene());
  renderer_.set_scene(scene(), shown().derived);
  poses_.set_scene(scene());
  camera_.set_scene(scene());
  if (player_) player_->emplace(scene(), animations_);
  ++replaced_;
  return true;
}

}  // namespace fire3dv::app
