#include "renderer/app/loading/live_scene.h"

#include <algorithm>
#include <iterator>
#include <map>

#include "protocol/base/clock.h"
#include "renderer/passes/resources/gpu_bytes.h"

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
  poses.load_assets_asynchronously();
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
  const int64_t begin_ns = monotonic_ns();
  const bool built = !build_.idle() && show_built();
  std::vector<state::SceneChanges> changes = poses_.take_scene_changes();
  // Who moves a node decides whose edits of it count.
  const bool rebound = bindings_seen_ != poses_.binding_revision();
  if (!built && !user_changed_ && changes.empty() && !can_build() && (book_.empty() || !rebound))
    return false;
  bindings_seen_ = poses_.binding_revision();
  // What follows from a replaced scene, or from who moves which node, is no stream's edit.
  if (built || rebound) (void)book_.resolve(scene(), poses_, false);
  if (built) charge_replacement(monotonic_ns() - begin_ns);
  take_edits(std::move(changes));
  pending_.merge(book_.take_wanted_changes());
  const int64_t list_begin_ns = monotonic_ns();
  if (can_build()) list_wanted();
  resolve();
  if (built) list_ns_ += monotonic_ns() - list_begin_ns;
  build_if_other();
  bool shown = false;
  for (const state::EditRegistry::Finished& edit : book_.take_finished())
    shown |= poses_.finish_edit(edit.stream, edit.epoch, edit.version);
  return shown;
}

// One stream after the other, so that each one's time is known.
void LiveScene::take_edits(std::vector<state::SceneChanges> changes) {
  for (state::SceneChanges& change : changes) {
    const int64_t begin_ns = monotonic_ns();
    const state::StreamId stream = change.stream;
    const bool is_charged = edit_time_ && !change.ended;
    std::vector<state::SceneChanges> one;
    one.push_back(std::move(change));
    book_.take(std::move(one), &poses_.names());
    (void)book_.resolve(scene(), poses_, false);
    if (is_charged) edit_time_(stream, monotonic_ns() - begin_ns);
  }
}

bool LiveScene::may_build(const ReplacementShares::Peer& peer) const {
  return shares_.earliest_ns(peer) <= monotonic_ns();
}

bool LiveScene::can_build() const {
  return build_.idle() &&
         std::any_of(pending_.begin(), pending_.end(), [this](const auto& peer) { return may_build(peer); });
}

// The list is long where streams add many nodes: it is made when a build may begin, not at each edit.
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
  const scene::NodeEdits& of_streams = book_.resolve(scene(), poses_, complete);
  state::EditRegistry::Resolved resolved = book_.take_resolved();
  std::set<uint32_t> nodes(resolved.nodes.begin(), resolved.nodes.end());
  for (const auto& key : book_.take_unwanted()) {
    const auto root = root_of_added_.find(key);
    if (root == root_of_added_.end()) continue;
    gone_.insert(root->second);
    nodes.insert(root->second);
  }
  const bool all = std::exchange(user_changed_, false) || resolved.all || user_.isolated != scene::kNone;
  if (all) {
    for (const auto& [node, edit] : of_streams) nodes.insert(node);
    nodes.insert(gone_.begin(), gone_.end());
    nodes.insert(user_.hidden.begin(), user_.hidden.end());
    for (const auto& [node, light] : user_.lights) nodes.insert(node);
    scene::NodeEdits edits;
    for (const uint32_t node : nodes) {
      if (auto edit = edit_of(of_streams, node)) edits.emplace_hint(edits.end(), node, std::move(*edit));
    }
    edits_.set(scene(), std::move(edits), user_.isolated);
  } else if (!nodes.empty()) {
    scene::SceneEdits::NodeChanges changes;
    for (const uint32_t node : nodes) changes.emplace_back(node, edit_of(of_streams, node));
    edits_.change(scene(), std::move(changes));
  }
  edits_.set_materials(user_.materials);
}

// What streams, and the user over them, change of the node.
std::optional<scene::NodeEdit> LiveScene::edit_of(const scene::NodeEdits& of_streams, uint32_t node) const {
  const auto known = of_streams.find(node);
  const auto light = user_.lights.find(node);
  // A light that a stream has taken away, or made another kind of, is not what the user has changed.
  const bool has_light =
      light != user_.lights.end() && kind_of_light(scene(), of_streams, node) == light->second.type;
  const bool is_gone = gone_.contains(node), is_hidden = user_.hidden.contains(node);
  if (known == of_streams.end() && !is_gone && !is_hidden && !has_light) return std::nullopt;
  scene::NodeEdit edit;
  if (known != of_streams.end()) edit = known->second;
  edit.removed |= is_gone;
  edit.hidden |= is_hidden;
  if (has_light) edit.light = light->second;
  return edit;
}

void LiveScene::note_vertex_changes() {
  const std::set<std::string>& names = book_.vertex_nodes();
  std::vector<std::string> changed;
  std::set_symmetric_difference(names.begin(), names.end(), contents_.vertex_nodes.begin(),
                                contents_.vertex_nodes.end(), std::back_inserter(changed));
  for (const std::string& name : changed) pending_.insert(book_.vertex_budget(name));
}

// With the changes of all peers that do not rest. Of the others it has what is shown, as far as it is wanted.
void LiveScene::build_if_other() {
  if (!build_.idle()) return;  // when that is done
  note_vertex_changes();
  if (!can_build()) return;
  const int64_t begin_ns = monotonic_ns();
  list_wanted();
  std::vector<ReplacementShares::Cause> causes;
  std::erase_if(pending_, [&](const auto& peer) {
    if (!may_build(peer)) return false;
    causes.push_back({peer});
    return true;
  });
  SceneBuild::Request request;
  for (const state::WantedNode& node : wanted_) {
    const bool is_shown =
        std::binary_search(contents_.nodes.begin(), contents_.nodes.end(), std::pair(node.age, node.version));
    if (is_shown || !pending_.contains(node.budget))
      request.nodes.push_back(node);
    else
      request.is_partial = true;
  }
  Contents contents{keys_of(request.nodes), {}};
  for (const std::string& name : book_.vertex_nodes()) {
    std::shared_ptr<PeerBudget> budget = book_.vertex_budget(name);
    const bool is_shown =
        std::binary_search(contents_.vertex_nodes.begin(), contents_.vertex_nodes.end(), name);
    if (!is_shown && pending_.contains(budget)) continue;
    contents.vertex_nodes.push_back(name);
    request.vertex_nodes.push_back({name, std::move(budget)});
  }
  if (contents == contents_ || contents == impossible_) return;
  // Loads take no less time than the rest after showing them, so that many assets do not mean as many
  // replacements.
  request.turn_ns = std::max(request.turn_ns, replacement_ns_);
  causes_ = std::move(causes);
  ++builds_begun_;
  build_.begin(std::move(request));
  list_ns_ += monotonic_ns() - begin_ns;
}

// The scene that was built last, and its part of the render thread's time.
void LiveScene::charge_replacement(int64_t shown_ns) {
  std::set<const PeerBudget*> active;
  for (state::StreamId id = 0; id < poses_.streams().size(); ++id) {
    if (poses_.streams()[id].active) active.insert(poses_.budget(id).get());
  }
  const bool is_alone = active.size() <= 1;
  shown_ns += std::exchange(list_ns_, 0);
  shares_.add({std::exchange(causes_, {}), merge_ns_, shown_ns, monotonic_ns(), is_alone});
  replacement_ns_ = merge_ns_ + (is_alone ? 1 : ReplacementShares::kRestOfShown) * shown_ns;
}

void LiveScene::note_causes(const SceneBuild::Built& built) {
  merge_ns_ = built.merge_ns;
  std::map<const PeerBudget*, size_t> nodes;
  for (const state::WantedNode& node : built.added) ++nodes[node.budget.get()];
  for (ReplacementShares::Cause& cause : causes_) {
    const auto load = built.load_ns.find(cause.peer.get());
    if (load != built.load_ns.end()) cause.load_ns = load->second;
    cause.nodes = nodes[cause.peer.get()];
  }
}

bool LiveScene::show_built() {
  std::optional<SceneBuild::Built> built = build_.take();
  if (!built) return false;
  note_causes(*built);
  for (const SceneBuild::Refused& refused : built->refused) book_.refuse_node(refused.node, refused.reason);
  for (const state::WantedNode& node : built->waiting) pending_.insert(node.budget);
  Contents contents{keys_of(built->added), built->vertex_nodes};
  if (built->fault.empty() && contents == contents_) {  // nothing new: all was refused, or waits
    book_.scene_made_for(contents_.vertex_nodes, std::move(built->vertex_refusals));
    return true;
  }
  const Result<void> placed = built->fault.empty() ? upload_scene(*built) : Error{built->fault};
  if (!placed) {
    refuse_new(std::move(*built), placed.error().message);
    return true;
  }
  std::set<uint32_t> gone;
  std::map<std::pair<uint64_t, uint64_t>, uint32_t> roots;
  for (size_t i = 0; i < built->added.size(); ++i) {
    const state::WantedNode& node = built->added[i];
    if (!book_.node_is_there(node)) gone.insert(built->roots[i]);
    roots.emplace(std::pair(node.age, node.version), built->roots[i]);
  }
  contents_ = std::move(contents);
  impossible_.reset();
  book_.scene_made_for(contents_.vertex_nodes, std::move(built->vertex_refusals));
  if (!built->scene && !merged_) {  // all was refused
    added_ = std::move(built->added);
    return true;
  }
  gone_ = std::move(gone);
  root_of_added_ = std::move(roots);
  // The old one goes when nobody looks at it any more; its copy on the GPU retires with the frames in flight.
  const std::unique_ptr<const scene::LoadedScene> before = std::exchange(merged_, std::move(built->scene));
  if (on_replaced_) on_replaced_(before ? before->scene : base_.scene, scene());
  poses_.set_scene(scene());
  camera_.set_scene(scene());
  if (player_) player_->emplace(scene(), animations_);
  ++replaced_;
  added_ = std::move(built->added);
  return true;
}

// On an error what was shown stays.
Result<void> LiveScene::upload_scene(const SceneBuild::Built& built) {
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
  build_.retain_only(added_);
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
