#include "renderer/live_scene/live_scene.h"

#include <algorithm>
#include <iterator>
#include <new>

#include "base/clock.h"
#include "renderer/scene/derived/variants.h"

namespace fire3dv::app {
namespace {

std::vector<std::pair<uint64_t, uint64_t>> keys_of(const std::vector<state::RequestedNode>& nodes) {
  std::vector<std::pair<uint64_t, uint64_t>> keys;
  for (const state::RequestedNode& node : nodes) keys.emplace_back(node.age, node.version);
  std::sort(keys.begin(), keys.end());
  return keys;
}

}  // namespace

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

bool LiveScene::is_build_due(const ReplacementShares::Peer& peer) const {
  if (hidden_peers_.contains(peer.get())) return false;
  return shares_.earliest_ns(peer) <= now_ns_();
}

bool LiveScene::can_build() const {
  return build_.idle() && std::any_of(pending_.begin(), pending_.end(),
                                      [this](const auto& peer) { return is_build_due(peer); });
}

// The list may be long, so it is made when a build may begin, not for each edit.
void LiveScene::update_request_list() {
  if (requested_revision_ == registry_.requested_revision() && requested_additions_ == additions_.revision())
    return;
  if (requested_revision_ != registry_.requested_revision()) (void)additions_.try_again();
  requested_revision_ = registry_.requested_revision();
  requested_additions_ = additions_.revision();
  requested_ = additions_.requests();
  for (state::RequestedNode& node : registry_.requested_nodes()) requested_.push_back(std::move(node));
  requested_keys_ = keys_of(requested_);
  ++request_lists_made_;
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
  edits_.set_materials(user_.materials);
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
  if (edit.vertices && hidden_peers_.contains(registry_.vertex_peer(node))) {
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
  const bool has_vertices = !registry_.vertex_nodes().empty();
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

// A scene whose preparation would take too long is dropped. Its peers are hidden, and build later.
bool LiveScene::is_admitted(SceneBuild::Built& built) {
  if (!admission_ || !built.scene) return true;
  const auto is_new = [this](const state::RequestedNode& node) {
    return !std::binary_search(contents_.nodes.begin(), contents_.nodes.end(),
                               std::pair(node.age, node.version));
  };
  std::set<const PeerBudget*> adding;
  for (const state::RequestedNode& node : built.added)
    if (node.budget && is_new(node)) adding.insert(node.budget.get());
  std::vector<PeerRoot> roots;
  for (size_t i = 0; i < built.added.size(); ++i) {
    const PeerBudget* const peer = built.added[i].budget.get();
    if (adding.contains(peer)) roots.push_back({peer, built.roots[i]});
  }
  const std::set<const PeerBudget*> refused = admission_(*built.scene, roots);
  if (refused.empty()) return true;
  hidden_peers_.insert(refused.begin(), refused.end());
  markers_.set_hidden_peers(hidden_peers_);
  find_hidden_roots();
  for (const state::RequestedNode& node : built.added)
    if (is_new(node)) pending_.insert(node.budget);
  registry_.set_built_vertex_nodes(contents_.vertex_nodes, {});
  build_.retain_only(added_);
  build_.retain_vertices_only(contents_.vertex_nodes);
  return false;
}

void LiveScene::find_vertex_changes() {
  const std::set<std::string>& names = registry_.vertex_nodes();
  std::vector<std::string> changed;
  std::set_symmetric_difference(names.begin(), names.end(), contents_.vertex_nodes.begin(),
                                contents_.vertex_nodes.end(), std::back_inserter(changed));
  for (const std::string& name : changed) pending_.insert(registry_.vertex_budget(name));
}

// The build contains the changes of peers whose share of the replacement time allows it. Of other peers it
// contains those nodes that are shown and still requested.
void LiveScene::begin_build_if_changed() {
  if (!build_.idle()) return;
  find_vertex_changes();
  if (!can_build()) return;
  const int64_t begin_ns = now_ns_();
  update_request_list();
  std::vector<ReplacementShares::Cause> causes;
  std::erase_if(pending_, [&](const auto& peer) {
    if (!is_build_due(peer)) return false;
    causes.push_back({peer});
    return true;
  });
  SceneBuild::Request request;
  for (const state::RequestedNode& node : requested_) {
    const bool is_shown =
        std::binary_search(contents_.nodes.begin(), contents_.nodes.end(), std::pair(node.age, node.version));
    if (is_shown || !pending_.contains(node.budget))
      request.nodes.push_back(node);
    else
      request.is_partial = true;
  }
  Contents contents{keys_of(request.nodes), {}};
  for (const std::string& name : registry_.vertex_nodes()) {
    std::shared_ptr<PeerBudget> budget = registry_.vertex_budget(name);
    const bool is_shown =
        std::binary_search(contents_.vertex_nodes.begin(), contents_.vertex_nodes.end(), name);
    if (!is_shown && pending_.contains(budget)) continue;
    contents.vertex_nodes.push_back(name);
    request.vertex_nodes.push_back({name, std::move(budget)});
  }
  // The base scene was displayed before, so it is tried again.
  const bool has_failed = contents == failed_contents_ && contents != Contents{};
  if (contents == contents_ || has_failed) {
    // A stream may have left whose assets waited for a further turn: no build comes that would release them.
    build_.retain_only(requested_);
    return;
  }
  // A load turn is at least as long as the pause after a replacement, so that many assets do not cause as
  // many replacements.
  request.turn_ns = std::max(request.turn_ns, replacement_ns_);
  causes_ = std::move(causes);
  ++builds_begun_;
  build_.begin(std::move(request));
  list_ns_ += now_ns_() - begin_ns;
}

// More than one peer has streams.
bool LiveScene::has_other_peers() const {
  const PeerBudget* first = nullptr;
  bool any = false;
  for (state::StreamId id = 0; id < poses_.streams().size(); ++id) {
    if (!poses_.streams()[id].active) continue;
    const PeerBudget* const budget = poses_.budget(id).get();
    if (std::exchange(any, true) && budget != first) return true;
    first = budget;
  }
  return false;
}

// Charges the last replacement to the peers that caused it.
void LiveScene::charge_replacement(int64_t shown_ns) {
  const bool is_alone = !has_other_peers();
  shown_ns += std::exchange(list_ns_, 0);
  shares_.add({std::exchange(causes_, {}), merge_ns_, shown_ns, now_ns_(), is_alone});
  replacement_ns_ = merge_ns_ + (is_alone ? 1 : ReplacementShares::kRestOfShown) * shown_ns;
}

void LiveScene::record_causes(const SceneBuild::Built& built) {
  merge_ns_ = built.merge_ns;
  std::map<const PeerBudget*, size_t> nodes;
  for (const state::RequestedNode& node : built.added) ++nodes[node.budget.get()];
  for (ReplacementShares::Cause& cause : causes_) {
    const auto load = built.load_ns.find(cause.peer.get());
    if (load != built.load_ns.end()) cause.load_ns = load->second;
    cause.nodes = nodes[cause.peer.get()];
  }
}

void LiveScene::report_asset_warnings(const std::vector<std::string>& warnings) {
  constexpr uint32_t kMaxReported = 20;  // streams may add assets without end
  for (const std::string& warning : warnings) {
    if (reported_asset_warnings_ >= kMaxReported) return;
    const bool is_last = ++reported_asset_warnings_ == kMaxReported;
    log_messages_.push_back("warning: " + warning +
                            (is_last ? "; further warnings of added assets are not logged" : ""));
  }
}

bool LiveScene::show_built() {
  std::optional<SceneBuild::Built> built = build_.take();
  if (!built) return false;
  record_causes(*built);
  report_asset_warnings(built->asset_warnings);
  for (const SceneBuild::Refused& refused : built->refused) refuse(refused.node, refused.reason);
  for (const state::RequestedNode& node : built->waiting) pending_.insert(node.budget);
  Contents contents{keys_of(built->added), built->vertex_nodes};
  if (built->fault.empty() && contents == contents_) {  // nothing new: all nodes were refused or wait
    registry_.set_built_vertex_nodes(contents_.vertex_nodes, std::move(built->vertex_refusals));
    return true;
  }
  if (built->fault.empty() && !is_admitted(*built)) return true;
  const Result<void> placed = built->fault.empty() ? upload_built(*built) : Error{built->fault};
  if (!placed) {
    refuse_new(std::move(*built), placed.error().message);
    return true;
  }
  std::set<uint32_t> withdrawn;
  std::map<std::pair<uint64_t, uint64_t>, uint32_t> roots;
  for (size_t i = 0; i < built->added.size(); ++i) {
    const state::RequestedNode& node = built->added[i];
    if (!confirm(node)) withdrawn.insert(built->roots[i]);
    roots.emplace(std::pair(node.age, node.version), built->roots[i]);
  }
  contents_ = std::move(contents);
  failed_contents_.reset();
  registry_.set_built_vertex_nodes(contents_.vertex_nodes, std::move(built->vertex_refusals));
  if (!built->scene && !merged_) {  // all nodes were refused
    added_ = std::move(built->added);
    return true;
  }
  withdrawn_ = std::move(withdrawn);
  root_of_added_ = std::move(roots);
  shown_additions_.clear();
  added_materials_.clear();
  for (size_t i = 0; i < built->added.size(); ++i) {
    const uint32_t root = built->roots[i];
    if (const auto asset = built->assets.find(root); asset != built->assets.end())
      added_materials_.push_back(
          {built->added[i].name, asset->second.first_material, asset->second.material_count});
    if (UserAdditions::are_of_user(built->added[i]))
      shown_additions_.push_back(
          {built->added[i].name, root, std::move(built->sources[root]), std::move(built->assets[root])});
  }
  std::ranges::sort(added_materials_, {}, &state::AddedMaterials::first);
  // The old scene outlives its users in this function; its GPU copy retires with the frames in flight.
  const std::unique_ptr<const scene::LoadedScene> before = std::exchange(merged_, std::move(built->scene));
  notify_replaced(before ? before->scene : base().scene);
  added_ = std::move(built->added);
  hidden_roots_.clear();
  drawn_vertices_.clear();
  find_hidden_roots();
  return true;
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

// After an error the previous scene stays.
Result<void> LiveScene::upload_built(const SceneBuild::Built& built) {
  if (!built.scene && !merged_) return {};
  if (!built.scene) return uploader_.upload(base());
  if (Result<void> fits = uploader_.check_memory(*built.scene); !fits) return fits;
  return uploader_.upload(*built.scene);
}

void LiveScene::refuse_new(SceneBuild::Built&& built, const std::string& reason) {
  failed_contents_ = Contents{keys_of(built.added), built.vertex_nodes};
  std::erase_if(built.added, [&](const state::RequestedNode& node) {
    return std::binary_search(contents_.nodes.begin(), contents_.nodes.end(),
                              std::pair(node.age, node.version));
  });
  // The next build lacks the user's assets and copies only, if that leaves anything.
  const auto large = std::ranges::stable_partition(built.added, std::not_fn(UserAdditions::may_be_large));
  const bool is_tried_again =
      !large.empty() && (large.size() != built.added.size() || built.vertex_nodes != contents_.vertex_nodes);
  for (auto node = is_tried_again ? large.begin() : built.added.begin(); node != built.added.end(); ++node)
    refuse(*node, reason, true);
  build_.retain_only(added_);
  build_.retain_vertices_only(contents_.vertex_nodes);
  if (is_tried_again) return;
  std::map<std::string, std::string> vertex_refusals;
  for (const std::string& name : built.vertex_nodes) vertex_refusals[name] = reason;
  registry_.set_built_vertex_nodes(built.vertex_nodes, std::move(vertex_refusals));
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
