#include "renderer/app/live_scene.h"

#include <algorithm>
#include <map>

#include "renderer/passes/gpu_bytes.h"

namespace fire3dv::app {
namespace {

// Replacements of the scene take half of the render thread's time at most. More would make streams wait
// longer whose frames belong to nodes that they add.
constexpr int kReplacementRest = 1;

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
  const bool may_build = must_build_ && can_build();
  if (!built && !user_changed_ && changes.empty() && !may_build && (book_.empty() || !rebound)) return false;
  user_changed_ = false;
  bindings_seen_ = poses_.binding_revision();
  book_.take(std::move(changes), &poses_.names());
  if (can_build()) list_wanted();
  resolve();
  build_if_other();
  bool shown = false;
  for (const state::EditBook::Finished& edit : book_.take_finished())
    shown |= poses_.finish_edit(edit.stream, edit.epoch, edit.version);
  return shown;
}

// The list is long where streams add many nodes: it is made when a build may begin, not at each edit.
bool LiveScene::can_build() const {
  return build_.idle() && std::chrono::steady_clock::now() >= next_build_;
}

void LiveScene::list_wanted() {
  if (wanted_revision_ == book_.wanted_revision()) return;
  wanted_revision_ = book_.wanted_revision();
  wanted_ = book_.wanted_nodes();
  wanted_keys_ = keys_of(wanted_);
  ++wanted_lists_made_;
}

// What nobody wants any more is hidden at once, and gone when the next scene is made.
void LiveScene::resolve() {
  const bool complete = wanted_revision_ == book_.wanted_revision() && wanted_keys_ == contents_.nodes;
  scene::NodeEdits edits = book_.resolve(scene(), poses_, complete);
  if (!complete) {
    for (const state::WantedNode& node : added_) {
      const uint32_t index = book_.is_wanted(node) ? scene::kNone : poses_.names().find(node.name);
      if (index != scene::kNone) edits[index].removed = true;
    }
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

void LiveScene::build_if_other() {
  must_build_ = false;
  if (!build_.idle()) return;  // when that is done
  if (!can_build()) {
    must_build_ = true;
    return;
  }
  const std::set<std::string>& vertex_nodes = book_.vertex_nodes();
  const bool other = wanted_keys_ != contents_.nodes ||
                     !std::equal(vertex_nodes.begin(), vertex_nodes.end(), contents_.vertex_nodes.begin(),
                                 contents_.vertex_nodes.end());
  if (!other) return;
  SceneBuild::Request request;
  Contents contents{wanted_keys_, {vertex_nodes.begin(), vertex_nodes.end()}};
  if (contents == impossible_) return;
  request.nodes = wanted_;
  for (const std::string& name : vertex_nodes)
    request.vertex_nodes.push_back({name, book_.vertex_budget(name)});
  // Loads take no less time than showing them, so that many assets do not mean as many replacements.
  request.turn_ns = std::max(request.turn_ns, replacement_ns_);
  ++builds_begun_;
  build_.begin(std::move(request));
}

bool LiveScene::show_built() {
  std::optional<SceneBuild::Built> built = build_.take();
  if (!built) return false;
  const auto begun = std::chrono::steady_clock::now();
  for (const SceneBuild::Refused& refused : built->refused) book_.refuse_node(refused.node, refused.reason);
  Contents contents{keys_of(built->added), built->vertex_nodes};
  if (built->fault.empty() && contents == contents_) {  // nothing new: all was refused, or waits
    book_.scene_made_for(contents_.vertex_nodes, std::move(built->vertex_refusals));
    return true;
  }
  const Result<void> placed = built->fault.empty() ? put_on_device(*built) : Error{built->fault};
  if (!placed) {
    refuse_new(std::move(*built), placed.error().message);
    return true;
  }
  for (const state::WantedNode& node : built->added) book_.node_is_there(node);
  contents_ = std::move(contents);
  impossible_.reset();
  added_ = std::move(built->added);
  book_.scene_made_for(contents_.vertex_nodes, std::move(built->vertex_refusals));
  if (!built->scene && !merged_) return true;  // all was refused
  // The old one goes when nobody looks at it any more; its copy on the GPU retires with the frames in flight.
  const std::unique_ptr<const scene::LoadedScene> before = std::exchange(merged_, std::move(built->scene));
  if (on_replaced_) on_replaced_(before ? before->scene : base_.scene, scene());
  poses_.set_scene(scene());
  camera_.set_scene(scene());
  if (player_) player_->emplace(scene(), animations_);
  ++replaced_;
  const auto ended = std::chrono::steady_clock::now();
  next_build_ = ended + kReplacementRest * (ended - begun);
  replacement_ns_ = built->merge_ns + (ended - begun) / std::chrono::nanoseconds(1);
  return true;
}

// On an error what was shown stays.
Result<void> LiveScene::put_on_device(const SceneBuild::Built& built) {
  if (!built.scene && !merged_) return {};
  const scene::LoadedScene& next = built.scene ? *built.scene : base_;
  if (built.scene) {
    if (Result<void> fits = check_memory(next); !fits) return fits;
  }
  try {
    renderer_.set_scene(next.scene, next.derived);
    return {};
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    return Error{"the device has no memory for the scene with it"};
  }
}

// The scene that is shown keeps its memory until the next one is whole.
Result<void> LiveScene::check_memory(const scene::LoadedScene& next) const {
  const uint64_t bytes = passes::estimate_gpu_bytes(next.scene, next.derived);
  const auto check = [&](const gpu::Device& device) -> Result<void> {
    const uint64_t available = device.available_bytes();
    if (bytes <= available) return {};
    return Error{"the scene with it takes about " + std::to_string(bytes >> 20) + " MiB, but " +
                 device.report().name + " has " + std::to_string(available >> 20) +
                 " MiB of memory left beside what is shown"};
  };
  Result<void> fits = check(renderer_.device());
  for (const gpu::Device* device : further_devices_) {
    if (fits) fits = check(*device);
  }
  return fits;
}

void LiveScene::refuse_new(SceneBuild::Built&& built, const std::string& reason) {
  for (const state::WantedNode& node : built.added) {
    if (!std::binary_search(contents_.nodes.begin(), contents_.nodes.end(),
                            std::pair(node.age, node.version)))
      book_.refuse_node(node, reason);
  }
  build_.keep_only(added_);
  impossible_ = Contents{keys_of(built.added), built.vertex_nodes};
  std::map<std::string, std::string> vertex_refusals;
  for (const std::string& name : built.vertex_nodes) vertex_refusals[name] = reason;
  book_.scene_made_for(built.vertex_nodes, std::move(vertex_refusals));
}

std::vector<std::string> LiveScene::take_notes() {
  std::vector<std::string> notes = book_.take_notes();
  const uint32_t without = renderer_.lights_without_shadow();
  if (std::exchange(reported_without_shadow_, without) != without && without > 0)
    notes.push_back("warning: " + std::to_string(without) +
                    " lights cast no shadow: the device has no memory for shadows of more lights");
  return notes;
}

}  // namespace fire3dv::app
