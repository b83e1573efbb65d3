// Builds of the merged scene: whose changes they contain, what they add and refuse, and whom they are charged
// to.
#include <algorithm>
#include <iterator>

#include "renderer/live_scene/live_scene.h"

namespace fire3dv::app {
namespace {

std::vector<std::pair<uint64_t, uint64_t>> keys_of(const std::vector<state::RequestedNode>& nodes) {
  std::vector<std::pair<uint64_t, uint64_t>> keys;
  for (const state::RequestedNode& node : nodes) keys.emplace_back(node.age, node.version);
  std::sort(keys.begin(), keys.end());
  return keys;
}

}  // namespace

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
  const std::set<std::string>& names = registry_.vertex_uses().names();
  std::vector<std::string> changed;
  std::set_symmetric_difference(names.begin(), names.end(), contents_.vertex_nodes.begin(),
                                contents_.vertex_nodes.end(), std::back_inserter(changed));
  for (const std::string& name : changed) pending_.insert(registry_.vertex_uses().budget(name));
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
  for (const std::string& name : registry_.vertex_uses().names()) {
    std::shared_ptr<PeerBudget> budget = registry_.vertex_uses().budget(name);
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
    if (!confirm(node) && !registry_.is_being_replaced(node)) withdrawn.insert(built->roots[i]);
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

}  // namespace fire3dv::app
