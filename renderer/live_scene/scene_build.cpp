#include "renderer/live_scene/scene_build.h"

#include <algorithm>
#include <exception>
#include <new>
#include <set>

#include "base/clock.h"
#include "base/text.h"
#include "renderer/live_scene/gpu_bytes.h"
#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/scene/model/math.h"
#include "renderer/scene/model/scene_edits.h"

namespace fire3dv::app {

namespace {

constexpr size_t kMaxCopiedNodes = 1'000'000;          // by the user, of all copies together
constexpr uint64_t kMaxPathBytes = uint64_t{1} << 30;  // of all nodes, as the file loader has it

// Path of the node that the user has copied; empty: the node is no copy.
const std::string& copied_path(const state::RequestedNode& node) {
  static const std::string kNone;
  const auto* const copied =
      node.addition ? std::get_if<state::CopiedNode>(&node.addition->content) : nullptr;
  return copied ? copied->path : kNone;
}

void add_warnings(const state::RequestedNode& node, const std::vector<std::string>& from,
                  std::vector<std::string>& to) {
  constexpr size_t kMaxWarnings = 20;  // a file may have any number
  for (const std::string& warning : from) {
    if (to.size() < kMaxWarnings)
      to.push_back("node " + quote(node.name) + ": " + asset_name(node) + ": " + warning);
  }
}

}  // namespace

// State of one build.
struct SceneBuild::Merge {
  explicit Merge(const state::NodeNames& base) : names(base) {}
  std::unique_ptr<scene::LoadedScene> to;
  PendingNames names;
  std::map<std::string, std::string> failures;  // of assets that cannot be loaded: why
  std::set<std::string> missing;                // assets that are not loaded yet
  uint64_t added_bytes = 0, path_bytes = 0;
  uint64_t deformed_corners = 0;  // of the scene
  scene::Descendants descendants;
  std::set<uint32_t> roots_of_user;  // of additions, which copies leave out
  size_t copied_nodes = 0;
  std::map<uint32_t, std::vector<uint32_t>> sources;  // of copies, by root
  std::map<uint32_t, MergedAsset> files;              // of assets, by root
  std::vector<size_t> ready;                          // nodes whose parent has been added
  std::vector<state::RequestedNode> charged;          // nodes that are added, or will be in a later turn
};

SceneBuild::SceneBuild(const scene::LoadedScene& base, AssetSettings settings)
    : base_(&base),
      settings_([&] {
        if (!settings.now_ns) settings.now_ns = monotonic_ns;
        return std::move(settings);
      }()),
      asset_files_(settings_.folder, settings_.overlay) {}

void SceneBuild::set_base(const scene::LoadedScene& base) {
  FIRE3DV_ASSERT(idle());
  base_ = &base;
  base_names_.reset();  // they refer to the scene
  base_path_bytes_ = 0;
  asset_files_.clear();
}

void SceneBuild::begin(Request request) {
  finished_ = false;
  thread_ = std::jthread([this, request = std::move(request)](const std::stop_token& stop) {
    std::string fault;
    try {
      built_ = build(request, stop);
    } catch (const std::bad_alloc&) {
      fault = "the scene with it does not fit into memory";
    } catch (const std::exception& error) {
      fault = std::string("the scene with it cannot be made: ") + error.what();
    }
    if (!fault.empty()) {
      built_ = {};
      built_.fault = fault;
      built_.added = request.nodes;
      for (const VertexNode& node : request.vertex_nodes) built_.vertex_nodes.push_back(node.name);
    }
    finished_ = true;
  });
}

std::optional<SceneBuild::Built> SceneBuild::take() {
  if (!is_finished()) return std::nullopt;
  thread_.join();
  thread_ = {};
  return std::exchange(built_, {});
}

void SceneBuild::retain_only(std::span<const state::RequestedNode> nodes) {
  std::set<NodeKey> keys;
  std::set<std::string> assets;
  std::set<UseKey> uses;
  for (const state::RequestedNode& node : nodes) {
    keys.emplace(node.age, node.version);
    if (!has_asset(node)) continue;
    const std::string key = asset_files_.key(node);
    assets.insert(key);
    uses.emplace(key, node.budget.get());
  }
  std::erase_if(node_charges_, [&](const auto& entry) { return !keys.contains(entry.first); });
  std::erase_if(assets_, [&](const auto& entry) { return !assets.contains(entry.first); });
  std::erase_if(uses_, [&](const auto& entry) { return !uses.contains(entry.first); });
}

void SceneBuild::retain_vertices_only(std::span<const std::string> nodes) {
  std::erase_if(vertex_charges_,
                [&](const auto& entry) { return !std::ranges::binary_search(nodes, entry.first.first); });
}

SceneBuild::Built SceneBuild::build(Request request, const std::stop_token& stop) {
  const int64_t begun = settings_.now_ns();
  Built built;
  for (const VertexNode& node : request.vertex_nodes) built.vertex_nodes.push_back(node.name);
  asset_files_.forget_missing();
  retain_only(request.nodes);
  if (!base_names_) {
    base_names_.emplace(base_->scene);
    for (const scene::Node& node : base_->scene.nodes) base_path_bytes_ += node.path.size();
  }
  if (request.nodes.empty() && request.vertex_nodes.empty()) {
    vertex_charges_.clear();
    return built;
  }
  Merge merge(*base_names_);
  load_assets(request, stop, merge, built);
  if (stop.stop_requested()) return built;
  merge.to = std::make_unique<scene::LoadedScene>(*base_);
  merge.path_bytes = base_path_bytes_;
  merge.deformed_corners = scene::deformed_corners(base_->scene);
  merge_nodes(request, stop, merge, built);
  if (stop.stop_requested()) return built;
  give_own_vertices(request, merge, built);
  scene::find_world_bounds(merge.to->scene);
  built.scene = std::move(merge.to);
  built.assets_wait = !merge.missing.empty();
  built.parent_lookups = merge.names.lookups();
  // Refused nodes are not charged.
  retain_only(merge.charged);
  built.merge_ns = settings_.now_ns() - begun;
  for (const auto& [peer, load_ns] : built.load_ns) built.merge_ns -= load_ns;
  return built;
}

// One turn loads assets of one peer, until its time is over or another peer is due. A peer therefore waits
// for one turn of another peer, or for one asset if that takes longer.
void SceneBuild::load_assets(const Request& request, const std::stop_token& stop, Merge& merge,
                             Built& built) {
  std::vector<const state::RequestedNode*> open;  // one for each missing asset
  for (const state::RequestedNode& node : request.nodes) {
    if (!has_asset(node)) continue;
    const std::string key = asset_files_.key(node);
    if (assets_.contains(key)) continue;
    if (const auto failure = failures_.find(key); failure != failures_.end()) {
      if (failure->second.files.are_unchanged()) {
        merge.failures[key] = failure->second.reason;
        continue;
      }
      failures_.erase(failure);
    }
    if (merge.missing.insert(key).second) open.push_back(&node);
  }
  uint64_t loaded_bytes = 0;
  for (const auto& [key, asset] : assets_) loaded_bytes += asset->size.host_bytes;
  if (loaded_bytes >= settings_.max_added_bytes) {  // by nodes that are displayed
    for (const state::RequestedNode* node : std::exchange(open, {})) {
      const std::string key = asset_files_.key(*node);
      merge.missing.erase(key);
      merge.failures[key] = too_many_bytes();
    }
  }
  std::optional<BuildTurns::Peer> served;
  for (int64_t spent_ns = 0; !open.empty() && spent_ns < request.turn_ns &&
                             loaded_bytes < settings_.max_added_bytes && !stop.stop_requested();) {
    std::vector<BuildTurns::Peer> waiting;
    for (const state::RequestedNode* node : open) {
      if (std::find(waiting.begin(), waiting.end(), node->budget.get()) == waiting.end())
        waiting.push_back(node->budget.get());
    }
    const BuildTurns::Peer peer = turns_.next(waiting);
    if (served && peer != *served) return;
    served = peer;
    const auto next =
        std::find_if(open.begin(), open.end(), [&](const auto* node) { return node->budget.get() == peer; });
    const state::RequestedNode& node = **next;
    open.erase(next);
    const std::string key = asset_files_.key(node);
    const int64_t begun = settings_.now_ns();
    Result<BudgetCharge> charge = BudgetCharge::take(node.budget, Resource::asset_bytes, 0);
    FIRE3DV_ASSERT(charge.ok());
    ReadFiles files;
    auto asset = load(node, stop, *charge, files);
    merge.missing.erase(key);
    if (asset) {
      add_warnings(node, (*asset)->loaded.scene.warnings, built.asset_warnings);
      assets_[key] = *asset;
      loaded_bytes += (*asset)->size.host_bytes;
      uses_[{key, peer}] = std::move(*charge);
    } else {
      merge.failures[key] = asset.error().message;
      if (node.addition && !files.empty() && files.are_unchanged() && !stop.stop_requested())
        failures_[key] = {std::move(files), asset.error().message};
    }
    const int64_t load_ns = settings_.now_ns() - begun;
    spent_ns += load_ns;
    turns_.add_ns(peer, load_ns);
    built.load_ns[peer] += load_ns;
    if (node.budget) node.budget->add_build_ns(load_ns);
  }
}

// Parents may be added nodes, too. Nodes are added in rounds: those whose parents exist, then those that
// waited for these. Each node is visited once, and once more when its parent has been added.
void SceneBuild::merge_nodes(Request& request, const std::stop_token& stop, Merge& merge, Built& built) {
  std::vector<state::RequestedNode>& nodes = request.nodes;
  std::vector<size_t> round(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    round[i] = i;
    if (!nodes[i].added->parent.empty()) merge.names.declare_parent(nodes[i].added->parent);
    if (!copied_path(nodes[i]).empty()) merge.names.declare_parent(copied_path(nodes[i]));
  }
  std::vector<bool> settled(nodes.size(), false), refused(nodes.size(), false), is_added(nodes.size(), false);
  std::vector<std::pair<size_t, uint32_t>> added;  // and their roots
  // Edits of the user name nodes by their paths alone.
  const auto find = [&](size_t i, const std::string& name) {
    if (name.empty()) return scene::kNone;
    return nodes[i].addition ? merge.names.find_path(name, merge.to->scene) : merge.names.find_parent(name);
  };
  const auto refuse = [&](size_t i, std::string reason) {
    settled[i] = refused[i] = true;
    built.refused.push_back({nodes[i], std::move(reason)});
  };
  while (!round.empty()) {
    struct Placed {
      size_t i;
      uint32_t parent, source;
    };
    std::vector<Placed> with_parents;  // found before this round adds any
    for (const size_t i : round) {
      const std::string& parent_name = nodes[i].added->parent;
      const uint32_t parent = find(i, parent_name);
      const std::string& source_name = copied_path(nodes[i]);
      const uint32_t source = find(i, source_name);
      if (parent == scene::kNone && !parent_name.empty())
        merge.names.wait(parent_name, i);
      else if (source == scene::kNone && !source_name.empty())
        merge.names.wait(source_name, i);
      else
        with_parents.push_back({i, parent, source});
    }
    for (const auto& [i, parent, source] : with_parents) {
      if (stop.stop_requested()) return;
      if (has_asset(nodes[i])) {
        const std::string key = asset_files_.key(nodes[i]);
        if (merge.missing.contains(key)) {  // in a later turn
          settled[i] = true;
          continue;
        }
        if (const auto failure = merge.failures.find(key); failure != merge.failures.end()) {
          refuse(i, failure->second);
          continue;
        }
      }
      const auto root = static_cast<uint32_t>(merge.to->scene.nodes.size());
      if (Result<void> done = add(nodes[i], parent, source, merge); done) {
        settled[i] = true;
        is_added[i] = true;
        added.emplace_back(i, root);
      } else {
        refuse(i, done.error().message);
      }
    }
    round = std::exchange(merge.ready, {});
    std::sort(round.begin(), round.end());
  }
  for (size_t i = 0; i < nodes.size(); ++i) {
    // A node may wait for a parent in an asset that is not loaded yet.
    if (settled[i] || !merge.missing.empty() || request.is_partial) continue;
    const std::string& parent = nodes[i].added->parent;
    const bool lacks_parent = !parent.empty() && find(i, parent) == scene::kNone;
    const std::string& missing = lacks_parent ? parent : copied_path(nodes[i]);
    const uint32_t named = nodes[i].addition ? merge.names.find_parent(missing) : scene::kNone;
    refuse(i, (nodes[i].addition ? "no node has the path " : "no node is called ") + quote(missing) +
                  (lacks_parent ? ", its parent" : ", which it copies") +
                  (named == scene::kNone ? "" : "; write " + quote(merge.to->scene.nodes[named].path)));
  }
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (!refused[i]) merge.charged.push_back(nodes[i]);
    if (!refused[i] && !is_added[i]) built.waiting.push_back(nodes[i]);
  }
  for (const auto& [i, root] : added) {
    built.added.push_back(std::move(nodes[i]));
    built.roots.push_back(root);
  }
  built.sources = std::move(merge.sources);
  built.assets = std::move(merge.files);
}

// A copy, without the user's additions below its node.
Result<scene::CopyPlan> SceneBuild::plan_copy(uint32_t source, Merge& merge) const {
  const scene::Scene& scene = merge.to->scene;
  std::vector<uint32_t> sources = merge.descendants.of(
      scene, source, [&](uint32_t below) { return merge.roots_of_user.contains(below); });
  if (merge.copied_nodes + sources.size() > kMaxCopiedNodes)
    return Error{"all copies together have more than " + std::to_string(kMaxCopiedNodes) + " nodes"};
  scene::CopyPlan plan = scene::plan_copy(scene, std::move(sources));
  if (merge.added_bytes + plan.host_bytes > settings_.max_added_bytes) return Error{too_many_bytes()};
  return plan;
}

std::string SceneBuild::too_many_bytes() const {
  return "all assets and copies together take more than " + std::to_string(settings_.max_added_bytes >> 20) +
         " MiB";
}

Result<void> SceneBuild::add(const state::RequestedNode& node, uint32_t parent, uint32_t source,
                             Merge& merge) {
  scene::Scene& scene = merge.to->scene;
  const std::string path =
      (parent == scene::kNone ? "" : scene.nodes[parent].path + "/") + path_part(node.name);
  if (merge.names.is_taken(node.name) || merge.names.is_taken(path))
    return Error{"there is a node of that name already"};
  std::shared_ptr<const Asset> asset;
  if (has_asset(node)) {
    const std::string key = asset_files_.key(node);
    asset = assets_.at(key);
    // An asset is charged to each peer that uses it, once.
    const UseKey use(key, node.budget.get());
    if (!uses_.contains(use)) {
      Result<BudgetCharge> charge =
          BudgetCharge::take(node.budget, Resource::asset_bytes, asset->size.host_bytes);
      if (!charge) return charge.error();
      uses_[use] = std::move(*charge);
    }
    if (merge.added_bytes + asset->size.host_bytes > settings_.max_added_bytes)
      return Error{too_many_bytes()};
    if (scene.textures.size() + asset->loaded.scene.textures.size() > settings_.max_textures)
      return Error{"the scene would have more than " + std::to_string(settings_.max_textures) + " textures"};
  }
  uint64_t path_bytes =
      path.size() + (asset ? asset->size.path_bytes + asset->size.nodes * (path.size() + 1) : 0);
  scene::CopyPlan copy;
  if (source != scene::kNone) {
    Result<scene::CopyPlan> planned = plan_copy(source, merge);
    if (!planned) return planned.error();
    copy = std::move(*planned);
    path_bytes = scene::path_bytes_of_copy(scene, copy.sources, path);
  }
  if (merge.path_bytes + path_bytes > kMaxPathBytes)
    return Error{"it lies so deep that the paths of all nodes exceed " + std::to_string(kMaxPathBytes >> 20) +
                 " MiB"};
  const NodeKey key(node.age, node.version);
  auto charges = node_charges_.find(key);
  if (charges == node_charges_.end()) {
    Result<NodeCharges> taken = charge_node(node.budget, asset ? &asset->size : nullptr);
    if (!taken) return taken.error();
    charges = node_charges_.emplace(key, std::move(*taken)).first;
  }
  if (Result<void> charged = charge_paths(charges->second, node.budget, path_bytes); !charged) return charged;

  const uint32_t root =
      scene::add_node(scene, node.name, parent, scene::to_mat4(node.added->parent_from_node));
  const size_t first_light = scene.lights.size();
  const auto first_material = static_cast<uint32_t>(scene.materials.size());
  if (asset) {
    if (Result<void> done = scene::add_below(*merge.to, asset->loaded, root); !done) {
      scene.nodes.pop_back();
      return done;
    }
    merge.added_bytes += asset->size.host_bytes;
    merge.deformed_corners += asset->size.deformed_corners;
    const scene::Scene& added = asset->loaded.scene;
    merge.files[root] = {added.source, static_cast<uint32_t>(added.nodes.size()), first_material,
                         static_cast<uint32_t>(added.materials.size()), asset->files.digest()};
    if (!charges->second.casts_shadows) {
      for (size_t light = first_light; light < scene.lights.size(); ++light)
        scene.lights[light].casts_shadow = false;
    }
  }
  if (!copy.sources.empty()) {
    if (Result<void> done = scene::copy_below(scene, copy, root, merge.deformed_corners); !done) {
      scene.nodes.pop_back();
      return done;
    }
    merge.added_bytes += copy.host_bytes;
    merge.copied_nodes += copy.sources.size();
    merge.sources[root] = std::move(copy.sources);
  }
  if (node.addition) {
    merge.roots_of_user.insert(root);
    if (const auto* light = std::get_if<scene::Light>(&node.addition->content)) {
      scene.nodes[root].light = static_cast<uint32_t>(scene.lights.size());
      scene.lights.push_back(*light);
    } else if (const auto* camera = std::get_if<scene::Camera>(&node.addition->content)) {
      scene.nodes[root].camera = static_cast<uint32_t>(scene.cameras.size());
      scene.cameras.push_back(*camera);
    }
  }
  merge.path_bytes += path_bytes;
  merge.names.add(&node.name, scene.nodes[root].path, root, merge.ready);
  for (uint32_t n = root + 1; n < scene.nodes.size(); ++n)
    merge.names.add(nullptr, scene.nodes[n].path, n, merge.ready);
  return {};
}

void SceneBuild::give_own_vertices(const Request& request, Merge& merge, Built& built) {
  if (request.vertex_nodes.empty()) return vertex_charges_.clear();
  scene::Scene& scene = merge.to->scene;
  const state::NodeNames names(scene, static_cast<uint32_t>(base_->scene.nodes.size()));
  std::map<UseKey, BudgetCharge> before = std::exchange(vertex_charges_, {});
  uint64_t corners = scene::deformed_corners(scene);
  for (const VertexNode& vertex_node : request.vertex_nodes) {
    const uint32_t node = names.find(vertex_node.name);
    if (node == scene::kNone || !scene::can_replace_vertices(scene.nodes[node])) continue;
    const uint64_t more = scene::corners_of_mesh(scene, scene.meshes[scene.nodes[node].mesh]);
    if (corners + more > scene::kMaxDeformedCorners) {
      built.vertex_refusals[vertex_node.name] = "its vertices are too many to be replaced";
      continue;
    }
    const UseKey key(vertex_node.name, vertex_node.budget.get());
    const uint64_t bytes = estimate_deformed_bytes(scene, merge.to->derived, node);
    const auto known = before.find(key);
    Result<BudgetCharge> charge = known != before.end() && known->second.amount() == bytes
                                      ? Result<BudgetCharge>(std::move(known->second))
                                      : BudgetCharge::take(vertex_node.budget, Resource::gpu_bytes, bytes);
    if (!charge) {
      built.vertex_refusals[vertex_node.name] = charge.error().message;
      continue;
    }
    vertex_charges_[key] = std::move(*charge);
    corners += more;
    scene.nodes[node].has_instance_vertices = true;
  }
}

}  // namespace fire3dv::app
