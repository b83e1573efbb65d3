#include "renderer/live_scene/live_scene.h"

#include <algorithm>
#include <new>

#include "base/clock.h"
#include "renderer/scene/derived/variants.h"

namespace fire3dv::app {
std::optional<scene::LightType> light_type(const scene::Scene& scene, const scene::NodeEdits& edits,
                                           uint32_t node) {
  if (const auto edit = edits.find(node); edit != edits.end() && edit->second.light)
    return edit->second.light->type;
  const uint32_t light = node < scene.nodes.size() ? scene.nodes[node].light : scene::kNone;
  if (light >= scene.lights.size()) return std::nullopt;
  return scene.lights[light].type;
}

LiveScene::LiveScene(const scene::LoadedScene& base, state::PoseState& poses, SceneUploader& uploader,
                     AssetSettings assets)
    : base_(&base),
      poses_(poses),
      uploader_(uploader),
      now_ns_(assets.now_ns ? assets.now_ns : monotonic_ns),
      file_of_additions_(assets.overlay.empty() ? std::string() : assets.overlay.string() + ": "),
      build_(base, std::move(assets)) {
  uploader.set_edits(edits_);
  poses.load_assets_asynchronously();
}

void LiveScene::set_animations(std::optional<state::AnimationPlayer>& player,
                               std::vector<uint32_t> animations) {
  player_ = &player;
  animations_ = std::move(animations);
}

void LiveScene::set_user_edits(const UserEdits& edits) {
  if (edits == user_) return;
  // Transforms and joints are part of the rest pose, not of the edits of nodes.
  UserEdits moved_only = user_;
  moved_only.transforms = edits.transforms;
  moved_only.joints = edits.joints;
  moved_only.variant = edits.variant;  // a scene of its own
  moved_only.additions = edits.additions;
  user_changed_ |= moved_only != edits;
  if (edits.variant != user_.variant) requested_variant_ = edits.variant;
  if (edits.additions != user_.additions) set_additions(edits.additions);
  user_ = edits;
  ++user_revision_;
  ++updates_;
}

bool LiveScene::follow() {
  const int64_t begin_ns = now_ns_();
  const bool built = !build_.idle() && show_built();
  const bool varied = show_variant();
  std::vector<state::SceneChanges> changes = poses_.take_scene_changes();
  bool shown = pace_edits(changes);
  const bool has_new_markers = markers_.take_from(changes);
  // The driver of a node may own it, so that its edits win.
  const bool rebound = bindings_seen_ != poses_.binding_revision();
  if (!built && !varied && !user_changed_ && changes.empty() && !can_build() &&
      (registry_.empty() || !rebound)) {
    updates_ += has_new_markers ? 1 : 0;
    return shown;
  }
  ++updates_;
  bindings_seen_ = poses_.binding_revision();
  // The cost of a replaced scene or of new drivers is not charged to streams.
  if (built || varied || rebound) (void)registry_.resolve(scene(), poses_, false);
  if (built) charge_replacement(now_ns_() - begin_ns);
  apply_edits(std::move(changes));
  for (const std::shared_ptr<PeerBudget>& peer : registry_.take_changed_budgets()) {
    if (peer) changed_peers_.insert(peer.get());
    pending_.insert(peer);
  }
  const int64_t list_begin_ns = now_ns_();
  if (can_build()) update_request_list();
  resolve();
  if (built) list_ns_ += now_ns_() - list_begin_ns;
  begin_build_if_changed();
  for (const state::EditRegistry::Finished& edit : registry_.take_finished())
    shown |= poses_.finish_edit(edit.stream, edit.epoch, edit.version);
  return shown;
}

// Returns true if a pose frame that waited for its edits is shown now.
bool LiveScene::pace_edits(std::vector<state::SceneChanges>& changes) {
  if (!paces_vertices_) return false;
  const bool others_active = has_other_peers();
  const int64_t now_ns = now_ns_();
  bool shown = false;
  for (state::SceneChanges& change : changes) {
    for (const uint64_t version : vertex_pacing_.hold(change, others_active, now_ns))
      shown |= poses_.finish_edit(change.stream, change.epoch, version);
    if (!vertex_pacing_.take_notice(change.age)) continue;
    log_messages_.push_back("warning: vertices of stream \"" + poses_.streams()[change.stream].name +
                            "\" come faster than its share of the time allows beside other streams: the "
                            "newest are shown, others are skipped; send fewer vertices, or less often");
  }
  for (state::SceneChanges& due : vertex_pacing_.take_due(others_active, now_ns))
    changes.push_back(std::move(due));
  std::erase_if(changes,
                [](const state::SceneChanges& change) { return !change.ended && change.edits.empty(); });
  return shown;
}

// Streams are applied one by one to measure the time of each.
void LiveScene::apply_edits(std::vector<state::SceneChanges> changes) {
  for (state::SceneChanges& change : changes) {
    const int64_t begin_ns = now_ns_();
    const state::StreamId stream = change.stream;
    const bool is_charged = edit_time_ && !change.ended;
    if (edit_observer_) edit_observer_(change);
    if (paces_vertices_) vertex_pacing_.applied(change, begin_ns);
    std::vector<state::SceneChanges> one;
    one.push_back(std::move(change));
    registry_.apply(std::move(one), &poses_.names());
    (void)registry_.resolve(scene(), poses_, false);
    if (is_charged) edit_time_(stream, now_ns_() - begin_ns);
  }
}

// Withdrawn nodes are hidden immediately; the next scene lacks them.
void LiveScene::resolve() {
  const bool complete = requested_revision_ == registry_.requested_revision() &&
                        requested_additions_ == additions_.revision() && requested_keys_ == contents_.nodes;
  const scene::NodeEdits& of_streams = registry_.resolve(scene(), poses_, complete);
  state::EditRegistry::Resolved resolved = registry_.take_resolved();
  std::set<uint32_t> nodes(resolved.nodes.begin(), resolved.nodes.end());
  for (const auto& key : registry_.take_withdrawn_nodes()) {
    const auto root = root_of_added_.find(key);
    if (root == root_of_added_.end()) continue;
    withdrawn_.insert(root->second);
    nodes.insert(root->second);
  }
  const bool all = std::exchange(user_changed_, false) || resolved.all || user_.isolated != scene::kNone;
  if (all) {
    for (const auto& [node, edit] : of_streams) nodes.insert(node);
    nodes.insert(withdrawn_.begin(), withdrawn_.end());
    nodes.insert(hidden_roots_.begin(), hidden_roots_.end());
    nodes.insert(user_.hidden.begin(), user_.hidden.end());
    nodes.insert(user_.removed.begin(), user_.removed.end());
    for (const auto& [node, light] : user_.lights) nodes.insert(node);
    scene::NodeEdits edits;
    for (const uint32_t node : nodes) {
      if (auto edit = combined_edit(of_streams, node))
        edits.emplace_hint(edits.end(), node, std::move(*edit));
    }
    edits_.set(scene(), std::move(edits), user_.isolated);
  } else if (!nodes.empty()) {
    scene::SceneEdits::NodeChanges changes;
    for (const uint32_t node : nodes) changes.emplace_back(node, combined_edit(of_streams, node));
    edits_.change(scene(), std::move(changes));
  }
  edits_.set_materials(user_.materials, user_.textures);
}

// Combines the edits of streams and of the user; nullopt: the node is unchanged.
std::optional<scene::NodeEdit> LiveScene::combined_edit(const scene::NodeEdits& of_streams,
                                                        uint32_t node) const {
  const auto known = of_streams.find(node);
  const auto light = user_.lights.find(node);
  // The user's light is void if a stream removed the light or changed its type.
  const bool has_light =
      light != user_.lights.end() && light_type(scene(), of_streams, node) == light->second.type;
  const bool is_withdrawn = withdrawn_.contains(node) || user_.removed.contains(node);
  const bool is_hidden = user_.hidden.contains(node) || hidden_roots_.contains(node);
  if (known == of_streams.end() && !is_withdrawn && !is_hidden && !has_light) return std::nullopt;
  scene::NodeEdit edit;
  if (known != of_streams.end()) edit = known->second;
  if (edit.vertices && hidden_peers_.contains(registry_.vertex_uses().peer(node))) {
    const auto drawn = drawn_vertices_.find(node);
    edit.vertices = drawn == drawn_vertices_.end() ? nullptr : drawn->second;
  }
  edit.removed |= is_withdrawn;
  edit.hidden |= is_hidden;
  if (has_light) edit.light = light->second;
  return edit;
}

std::vector<LiveScene::PeerRoot> LiveScene::peer_roots() const {
  std::vector<PeerRoot> roots;
  for (const state::RequestedNode& node : added_) {
    const auto root = root_of_added_.find({node.age, node.version});
    if (node.budget && root != root_of_added_.end() && !withdrawn_.contains(root->second))
      roots.push_back({node.budget.get(), root->second});
  }
  return roots;
}

void LiveScene::set_hidden_peers(std::set<const PeerBudget*> peers) {
  if (peers == hidden_peers_) return;
  hidden_peers_ = std::move(peers);
  markers_.set_hidden_peers(hidden_peers_);
  ++updates_;
  find_hidden_roots();
  if (user_changed_) resolve();
}

void LiveScene::find_hidden_roots() {
  std::set<uint32_t> roots;
  for (const PeerRoot& root : peer_roots())
    if (hidden_peers_.contains(root.peer)) roots.insert(root.node);
  const bool has_vertices = !registry_.vertex_uses().names().empty();
  if (roots == hidden_roots_ && !has_vertices) return;
  hidden_roots_ = std::move(roots);
  user_changed_ = true;
}

void LiveScene::note_drawn() {
  const uint64_t revision = edits_.revisions().vertices;
  if (std::exchange(drawn_vertices_revision_, revision) == revision) return;
  drawn_vertices_.clear();
  for (const auto& [node, edit] : edits_.nodes())
    if (edit.vertices) drawn_vertices_.emplace(node, edit.vertices);
}

void LiveScene::notify_replaced(const scene::Scene& before) {
  for (const Replaced& replaced : on_replaced_) replaced(before, scene());
  poses_.set_scene(scene());
  if (player_) player_->emplace(scene(), animations_);
  ++replaced_;
}

// Copies the scene: a build thread and the cache may still read the loaded one.
bool LiveScene::show_variant() {
  if (requested_variant_ == variant_ || !build_.idle()) return false;
  const uint32_t variant = requested_variant_;
  const auto with_variant = [&](const scene::LoadedScene& loaded) {
    auto copy = std::make_unique<scene::LoadedScene>(loaded);
    scene::select_variant(*copy, variant);
    return copy;
  };
  std::unique_ptr<const scene::LoadedScene> next_base, next_merged;
  Result<void> placed;
  if (variant != scene::kNone && variant >= base_->scene.variants.size()) {
    placed = Error{"the scene has no such variant"};
  } else {
    try {
      next_base = with_variant(base());
      if (merged_) next_merged = with_variant(*merged_);
      placed = uploader_.check_memory(next_merged ? *next_merged : *next_base);
    } catch (const std::bad_alloc&) {
      placed = Error{"the scene with it does not fit into memory"};
    }
  }
  if (placed) placed = uploader_.upload(next_merged ? *next_merged : *next_base);
  if (!placed) {
    requested_variant_ = user_.variant = variant_;
    is_variant_refused_ = true;
    log_messages_.push_back("warning: the material variant is not shown: " + placed.error().message);
    return false;
  }
  // The old scenes outlive their users in this function.
  const std::unique_ptr<const scene::LoadedScene> old_merged = std::exchange(merged_, std::move(next_merged));
  const scene::LoadedScene& before = old_merged ? *old_merged : base();
  const std::unique_ptr<const scene::LoadedScene> old_base =
      std::exchange(variant_base_, std::move(next_base));
  build_.set_base(*variant_base_);
  variant_ = variant;
  notify_replaced(before.scene);
  user_changed_ = true;  // all edits are applied to the new scene
  return true;
}

Result<void> LiveScene::replace_base(const scene::LoadedScene& next, std::vector<uint32_t> animations) {
  FIRE3DV_ASSERT(can_replace_base());
  if (next.scene.textures.size() > uploader_.max_textures())
    return Error{"it has more textures than this run has room for: start fire3dv again"};
  if (Result<void> fits = uploader_.check_memory(next); !fits) return fits;
  if (Result<void> uploaded = uploader_.upload(next); !uploaded) return uploaded;
  // The old scenes outlive their users in this function.
  const std::unique_ptr<const scene::LoadedScene> merged = std::exchange(merged_, nullptr);
  const scene::LoadedScene& before_base = base();
  const std::unique_ptr<const scene::LoadedScene> variant_base = std::exchange(variant_base_, nullptr);
  const scene::Scene& before = merged ? merged->scene : before_base.scene;
  const auto in_next = [&](uint32_t variant) {
    return scene::variant_of_same_name(variant, before_base.scene, next.scene);
  };
  requested_variant_ = in_next(requested_variant_);
  user_.variant = in_next(user_.variant);
  variant_ = loaded_variant_ = in_next(loaded_variant_);
  base_ = &next;
  build_.reload(next);
  for (const state::RequestedNode& node : added_) pending_.insert(node.budget);
  if (additions_.try_again()) pending_.insert(nullptr);
  shown_additions_.clear();
  added_materials_.clear();
  added_.clear();
  contents_ = {};
  failed_contents_.reset();
  withdrawn_.clear();
  hidden_roots_.clear();
  drawn_vertices_.clear();
  root_of_added_.clear();
  registry_.set_built_vertex_nodes({}, {});
  animations_ = std::move(animations);
  for (const Replaced& replaced : on_replaced_) replaced(before, scene());
  poses_.set_scene(scene(), static_cast<uint32_t>(scene().nodes.size()));
  if (player_) player_->emplace(scene(), animations_);
  ++replaced_;
  ++updates_;
  (void)registry_.resolve(scene(), poses_, false);
  user_changed_ = true;
  resolve();
  return {};
}

void LiveScene::show_markers(std::span<const state::ShownMarker> overlay) {
  shown_markers_.assign(overlay.begin(), overlay.end());
  if (!shows_markers_) return uploader_.set_markers(shown_markers_);
  const std::vector<state::ShownMarker>& of_streams =
      markers_.resolve(poses_, edits_, settled(), user_.hidden_markers);
  if (overlay.empty()) return uploader_.set_markers(of_streams);
  shown_markers_.insert(shown_markers_.begin(), of_streams.begin(), of_streams.end());
  uploader_.set_markers(shown_markers_);
}

std::vector<std::string> LiveScene::take_log_messages() {
  std::vector<std::string> messages = registry_.take_log_messages();
  for (std::string& message : markers_.take_log_messages()) messages.push_back(std::move(message));
  for (std::string& message : std::exchange(log_messages_, {})) messages.push_back(std::move(message));
  const bool lack = uploader_.lacks_markers();
  if (std::exchange(reported_marker_memory_, lack) != lack && lack)
    messages.push_back("warning: markers are not shown: the device has no memory for them");
  const uint32_t without = uploader_.lights_without_shadow();
  if (std::exchange(reported_without_shadow_, without) != without && without > 0)
    messages.push_back("warning: " + std::to_string(without) +
                       " lights cast no shadow: the device has no memory for shadows of more lights");
  return messages;
}

}  // namespace fire3dv::app
