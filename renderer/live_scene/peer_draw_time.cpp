#include "renderer/live_scene/peer_draw_time.h"

#include <algorithm>
#include <set>

#include "base/clock.h"
#include "base/log.h"
#include "base/text.h"

namespace fire3dv::app {
namespace {

constexpr int64_t kMsNs = 1'000'000, kSecondNs = 1'000'000'000;
constexpr int64_t kCacheNs = 50 * kMsNs;  // views and poses change slowly
constexpr int64_t kStoreNs = 100 * kMsNs;
constexpr int64_t kStreamedNs = kSecondNs;  // after their last change, vertices are not rebuilt any more
constexpr size_t kMaxLarge = 32, kMaxSampled = 32;  // items of a peer that one estimate looks at
constexpr size_t kMaxCached = 64, kMaxSubmissions = 64;

// Sums the work of the largest items, and of some of the others as samples of them all.
template <typename Item, typename Size, typename Work>
state::DrawWork sum_of_samples(std::vector<Item>& items, const Size& size, const Work& work) {
  state::DrawWork sum;
  const size_t large = std::min(items.size(), kMaxLarge);
  if (items.size() > large)
    std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(large), items.end(),
                     [&](const Item& a, const Item& b) { return size(a) > size(b); });
  for (size_t i = 0; i < large; ++i) sum += work(items[i]);
  const size_t others = items.size() - large, samples = std::min(others, kMaxSampled);
  state::DrawWork sampled;
  for (size_t i = 0; i < samples; ++i) sampled += work(items[large + i * others / samples]);
  if (samples > 0) sum += sampled * (static_cast<double>(others) / static_cast<double>(samples));
  return sum;
}

}  // namespace

PeerDrawTime::PeerDrawTime(LiveScene& scene, const state::PoseState& poses,
                           const state::DrawTimeSettings& settings, std::function<int64_t()> now_ns)
    : scene_(scene), poses_(poses), now_ns_(now_ns ? std::move(now_ns) : monotonic_ns), policy_(settings) {
  scene_.set_admission([this](const scene::LoadedScene& next, const std::vector<LiveScene::PeerRoot>& roots) {
    return admit(next, roots);
  });
}

void PeerDrawTime::poll() {
  std::vector<Policy::Peer> peers;
  for (state::StreamId id = 0; id < poses_.streams().size(); ++id) {
    const PeerBudget* const peer = poses_.streams()[id].active ? poses_.budget(id).get() : nullptr;
    if (peer && std::ranges::find(peers, peer) == peers.end()) peers.push_back(peer);
  }
  // Content of a peer that has left stays for a grace time; it does not return for that.
  for (const Policy::Report& report : policy_.report()) {
    const bool is_gone = report.is_hidden && std::ranges::find(peers, report.peer) == peers.end();
    if (is_gone && has_content(report.peer)) peers.push_back(report.peer);
  }
  (void)policy_.set_peers(peers);
  for (const PeerBudget* const peer : scene_.take_changed_peers()) {
    refused_.erase(peer);
    cached_.clear();
    meshes_of_.reset();
  }
  if (!policy_.is_active()) {
    image_.reset();
    submissions_.clear();
    cached_.clear();
    refused_.clear();
    replaced_.clear();
    meshes_.clear();
    meshes_of_.reset();
  }
  (void)apply();
  if (policy_.is_active() || has_costs_) store_costs();
}

bool PeerDrawTime::has_content(Policy::Peer peer) const {
  const auto has = [&](const auto& list, auto member) {
    return std::ranges::find(list, peer, member) != list.end();
  };
  return has(scene_.markers().shown(), &state::ShownMarker::peer) ||
         has(scene_.markers().held_back(), &state::ShownMarker::peer) ||
         has(scene_.peer_roots(), &LiveScene::PeerRoot::peer);
}

void PeerDrawTime::store_costs() {
  const int64_t now_ns = now_ns_();
  if (now_ns - stored_ns_ < kStoreNs) return;
  stored_ns_ = now_ns;
  has_costs_ = policy_.is_active();
  const std::vector<Policy::Report> reports = policy_.report();
  for (state::StreamId id = 0; id < poses_.streams().size(); ++id) {
    if (!poses_.streams()[id].active || !poses_.budget(id)) continue;
    const auto report = std::ranges::find(reports, poses_.budget(id).get(), &Policy::Report::peer);
    if (report != reports.end())
      poses_.budget(id)->set_draw_cost({report->seconds, report->share, report->is_hidden});
  }
}

bool PeerDrawTime::begin_image(const View& view) {
  if (!policy_.is_active()) return false;
  const int64_t now_ns = now_ns_();
  Policy::Image image{.kind = view.kind, .pixels = view.pixels};
  if (view.requester_epoch) image.requester = peer_of_epoch(*view.requester_epoch);
  image.content = content_of(view, now_ns);
  (void)policy_.plan(image, now_ns);
  image_ = std::move(image);
  return apply();
}

void PeerDrawTime::submitted(uint64_t submission, double images) {
  scene_.note_drawn();
  if (!image_) return;
  if (images != 1) {
    image_->kind ^= std::hash<double>()(images);
    image_->pixels = static_cast<uint64_t>(images * static_cast<double>(image_->pixels));
    for (Policy::Content& content : image_->content) {
      content.markers = content.markers * images;
      content.meshes = content.meshes * images;
    }
  }
  std::erase_if(image_->content,
                [&](const Policy::Content& content) { return policy_.is_hidden(content.peer); });
  submissions_.emplace_back(submission, *std::exchange(image_, std::nullopt));
  if (submissions_.size() > kMaxSubmissions) submissions_.pop_front();
}

void PeerDrawTime::finished(uint64_t submission, const Policy::Measured& measured) {
  const auto known = std::ranges::find(submissions_, submission, &std::pair<uint64_t, Policy::Image>::first);
  if (known == submissions_.end()) return;
  const Policy::Image image = std::move(known->second);
  submissions_.erase(submissions_.begin(), known + 1);  // earlier ones have no times
  (void)policy_.add(image, measured, now_ns_());
  (void)apply();
}

void PeerDrawTime::abandoned(int64_t elapsed_ns) {
  Policy::Image image;
  if (!submissions_.empty()) image = submissions_.back().second;
  if (image.content.empty())
    for (const auto& [kind, cached] : cached_) image.content = cached.content;
  submissions_.clear();
  (void)policy_.add_abandoned(image, elapsed_ns, now_ns_());
  (void)apply();
}

std::optional<int64_t> PeerDrawTime::abandon_after_ns() const {
  return image_ ? policy_.abandon_after_ns(*image_) : std::nullopt;
}

const PeerBudget* PeerDrawTime::peer_of_epoch(uint64_t epoch) const {
  for (state::StreamId id = 0; id < poses_.streams().size(); ++id) {
    if (poses_.streams()[id].active && poses_.streams()[id].epoch == epoch) return poses_.budget(id).get();
  }
  return nullptr;
}

const std::vector<PeerDrawTime::Policy::Content>& PeerDrawTime::content_of(const View& view, int64_t now_ns) {
  if (cached_.size() > kMaxCached) cached_.clear();
  Cached& cached = cached_[view.kind];
  const bool is_current = cached.updates == scene_.updates() && cached.revision == policy_.revision() &&
                          now_ns - cached.at_ns < kCacheNs;
  if (is_current) return cached.content;
  std::map<Policy::Peer, Policy::Content> content;
  if (view.markers) add_markers(view, content);
  add_meshes(view, now_ns, content);
  cached = {scene_.updates(), policy_.revision(), now_ns, view, {}};
  for (const auto& [peer, of_peer] : content) cached.content.push_back(of_peer);
  return cached.content;
}

void PeerDrawTime::add_markers(const View& view, std::map<Policy::Peer, Policy::Content>& content) const {
  std::map<Policy::Peer, std::vector<const state::ShownMarker*>> markers;
  for (const std::vector<state::ShownMarker>* list :
       {&scene_.markers().shown(), &scene_.markers().held_back()}) {
    for (const state::ShownMarker& shown : *list)
      if (shown.peer) markers[shown.peer].push_back(&shown);
  }
  for (auto& [peer, of_peer] : markers) {
    content[peer].peer = peer;
    content[peer].markers += sum_of_samples(
        of_peer, [](const state::ShownMarker* shown) { return state::max_marker_vertices(*shown->marker); },
        [&](const state::ShownMarker* shown) {
          return state::marker_work(*shown->marker, shown->world_from_marker, view.view);
        });
  }
}

// Nodes with meshes at and below the roots: parents precede their children.
PeerDrawTime::Meshes PeerDrawTime::meshes_below(const scene::Scene& scene,
                                                const std::vector<LiveScene::PeerRoot>& roots) {
  Meshes meshes;
  std::map<uint32_t, Policy::Peer> peer_of;
  for (const LiveScene::PeerRoot& root : roots) peer_of[root.node] = root.peer;
  if (peer_of.empty()) return meshes;
  for (uint32_t node = peer_of.begin()->first; node < scene.nodes.size(); ++node) {
    const auto parent = peer_of.find(scene.nodes[node].parent);
    auto own = peer_of.find(node);
    if (own == peer_of.end() && parent != peer_of.end()) own = peer_of.emplace(node, parent->second).first;
    const uint32_t mesh = scene.nodes[node].mesh;
    if (own == peer_of.end() || mesh == scene::kNone) continue;
    meshes[own->second].push_back({node, mesh, state::triangle_count(scene, scene.meshes[mesh])});
  }
  return meshes;
}

void PeerDrawTime::find_meshes() {
  if (meshes_of_ == scene_.replaced()) return;
  meshes_of_ = scene_.replaced();
  replaced_.clear();
  meshes_ = meshes_below(scene_.scene(), scene_.peer_roots());
}

void PeerDrawTime::add_meshes(const View& view, int64_t now_ns,
                              std::map<Policy::Peer, Policy::Content>& content) {
  find_meshes();
  const scene::Scene& scene = scene_.scene();
  for (auto& [peer, nodes] : meshes_) {
    content[peer].peer = peer;
    content[peer].meshes += sum_of_samples(
        nodes, [](const MeshNode& node) { return node.triangles; },
        [&](const MeshNode& node) {
          return state::mesh_work(scene, scene.meshes[node.mesh], poses_.world_from_node(node.node),
                                  view.view);
        });
  }
  for (const auto& [peer, work] : refused_) {
    content[peer].peer = peer;
    content[peer].meshes += work;
  }
  // Vertices that are replaced now: their acceleration structures are built again with each change.
  for (const auto& [node, edit] : scene_.edits().nodes()) {
    const PeerBudget* const peer = edit.vertices ? scene_.vertex_peer(node) : nullptr;
    if (!peer) continue;
    Replaced& replaced = replaced_[node];
    if (replaced.vertices != edit.vertices) replaced = {edit.vertices, now_ns};
    if (now_ns - replaced.changed_ns > kStreamedNs && !policy_.is_hidden(peer)) continue;
    content[peer].peer = peer;
    content[peer].meshes.rebuilt +=
        static_cast<double>(state::triangle_count(scene, scene.meshes[scene.nodes[node].mesh]));
  }
}

std::set<const PeerBudget*> PeerDrawTime::admit(const scene::LoadedScene& next,
                                                const std::vector<LiveScene::PeerRoot>& roots) {
  std::set<const PeerBudget*> refused;
  if (!policy_.is_active()) return refused;
  const scene::Scene& scene = next.scene;
  for (auto& [peer, nodes] : meshes_below(scene, roots)) {
    state::DrawWork largest;
    std::set<uint32_t> counted;  // nodes share the acceleration structures of their mesh
    for (const MeshNode& node : nodes)
      if (counted.insert(node.mesh).second) largest.rebuilt += static_cast<double>(node.triangles);
    std::vector<Policy::Image> images;
    for (const auto& [kind, cached] : cached_) {
      const state::DrawWork work = sum_of_samples(
          nodes, [](const MeshNode& node) { return node.triangles; },
          [&](const MeshNode& node) {
            return state::mesh_work(scene, scene.meshes[node.mesh], scene.nodes[node.node].world_from_node,
                                    cached.view.view);
          });
      if (work.fragments > largest.fragments) {
        largest.vertices = work.vertices;
        largest.fragments = work.fragments;
      }
      Policy::Image& image = images.emplace_back(Policy::Image{.kind = kind, .pixels = cached.view.pixels});
      if (cached.view.requester_epoch) image.requester = peer_of_epoch(*cached.view.requester_epoch);
      image.content.push_back({peer, {}, work});
    }
    refused_.erase(peer);
    if (!policy_.refuse_meshes(peer, largest, images, now_ns_())) continue;
    refused.insert(peer);
    refused_[peer] = largest;
  }
  return refused;
}

// Hides in the scene what the policy hides. Returns true if it changed.
bool PeerDrawTime::apply() {
  if (std::exchange(applied_revision_, policy_.revision()) == policy_.revision()) {
    report_notices();
    return false;
  }
  std::set<const PeerBudget*> hidden;
  for (const Policy::Report& report : policy_.report())
    if (report.is_hidden) hidden.insert(report.peer);
  scene_.set_hidden_peers(std::move(hidden));
  stored_ns_ = 0;
  store_costs();
  report_notices();
  return true;
}

void PeerDrawTime::report_notices() {
  for (Policy::Notice& notice : policy_.take_notices()) {
    std::string name;
    std::optional<state::StreamId> stream;
    for (state::StreamId id = 0; id < poses_.streams().size(); ++id) {
      if (!poses_.streams()[id].active || poses_.budget(id).get() != notice.peer) continue;
      stream = id;
      name = poses_.streams()[id].name;
    }
    if (!stream) continue;
    using Kind = Policy::Notice::Kind;
    const std::string subject = "stream " + quote(name);
    if (notice.kind == Kind::expensive) {
      log_messages_.push_back("info: " + subject + " " + notice.text);
      continue;
    }
    const bool is_hidden = notice.kind == Kind::hidden;
    log_messages_.push_back(is_hidden ? warning(subject + ": " + notice.text)
                                      : "info: " + subject + ": its content is shown again: " + notice.text);
    messages_to_streams_.emplace_back(*stream,
                                      is_hidden ? notice.text : "the content is shown again: " + notice.text);
  }
}

}  // namespace fire3dv::app
