// The incremental EditRegistry and SceneEdits against a full recomputation after each of thousands of random
// operations of several streams. No GPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/edits/edit_registry.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::state {
namespace {

using wire::Property;

// Reference model: resolves all edits in force anew each time.
class Reference {
 public:
  void apply(const std::vector<SceneChanges>& changes, const NodeNames& file_names) {
    std::vector<std::string> added;
    for (const SceneChanges& change : changes) {
      if (change.ended) {
        apply_end(change);
        continue;
      }
      for (const wire::SceneEdit& edit : change.edits) {
        if (std::holds_alternative<wire::NodeAdded>(edit.value)) added.push_back(edit.node);
        store(streams_[change.age], edit);
      }
      streams_.try_emplace(change.age);
    }
    for (const std::string& name : added) resolve_name_conflict(name, file_names);
  }

  scene::NodeEdits resolve(const scene::Scene& scene, const PoseState& poses, bool complete) {
    for (auto& [age, stream] : streams_)
      std::erase_if(stream.edits, [](const auto& edit) { return edit.second.is_refused; });
    bind(poses);
    std::vector<uint64_t> owners(scene.nodes.size(), UINT64_MAX);
    for (const auto& [age, stream] : streams_) {
      for (const uint32_t node : stream.reserved) owners[node] = std::min(owners[node], age);
      for (const auto& [key, edit] : stream.edits) {
        if (edit.node != kNone) owners[edit.node] = std::min(owners[edit.node], age);
      }
    }
    for (uint32_t node = 0; node < owners.size(); ++node)
      owners[node] = std::min(owners[node], poses.age_of_driver(node).value_or(UINT64_MAX));
    std::vector<uint64_t> below = owners;
    for (size_t node = below.size(); node-- > 0;) {
      const uint32_t parent = scene.nodes[node].parent;
      if (parent != scene::kNone) below[parent] = std::min(below[parent], below[node]);
    }
    scene::NodeEdits result;
    for (auto& [age, stream] : streams_) {
      for (auto& [key, edit] : stream.edits) {
        const auto is_older = [rank = age_rank(age)](uint64_t other) { return age_rank(other) < rank; };
        const bool adds = std::holds_alternative<wire::NodeAdded>(edit.value);
        if (edit.node == kNone) {
          if (complete && !adds && !std::holds_alternative<wire::NodeRemoved>(edit.value))
            fault(edit, faults.unmatched);
          continue;
        }
        const auto* visible = std::get_if<wire::Visible>(&edit.value);
        const bool hides =
            std::holds_alternative<wire::NodeRemoved>(edit.value) || (visible && !visible->visible);
        if (is_older(owners[edit.node]) || (hides && is_older(below[edit.node]))) {
          fault(edit, faults.conflicting);
          continue;
        }
        if (adds) continue;
        scene::NodeEdit& edited = result[edit.node];
        if (visible) edited.hidden = !visible->visible;
        if (std::holds_alternative<wire::NodeRemoved>(edit.value)) edited.removed = true;
        if (const auto* light = std::get_if<wire::Light>(&edit.value)) {
          edited.light.emplace();
          edited.light->intensity = light->intensity;
        }
        if (const auto* color = std::get_if<wire::BaseColor>(&edit.value)) {
          if (scene.nodes[edit.node].mesh == scene::kNone)
            fault(edit, faults.unfit);
          else
            edited.base_color = glm::vec4(color->rgba[0], 0, 0, 1);
        }
      }
    }
    return result;
  }

  void refuse(const RequestedNode& node) {
    const auto stream = streams_.find(node.age);
    if (stream == streams_.end()) return;
    const auto edit = stream->second.edits.find({node.name, Property::node});
    if (edit == stream->second.edits.end() || edit->second.version != node.version) return;
    refuse(edit->second);
  }

  EditFaults faults;

 private:
  struct Edit {
    uint64_t version = 0, fault_version = 0;
    wire::EditValue value;
    uint32_t node = kNone;
    bool is_looked_up = false, is_refused = false;
  };
  struct StreamModel {
    std::map<std::pair<std::string, Property>, Edit> edits;
    std::set<uint32_t> reserved;
  };

  void apply_end(const SceneChanges& change) {
    const auto stream = streams_.find(change.age);
    if (stream == streams_.end()) return;
    if (!change.may_return) {
      streams_.erase(stream);
      return;
    }
    for (const auto& [key, edit] : stream->second.edits) {
      if (edit.node != kNone) stream->second.reserved.insert(edit.node);
    }
    stream->second.edits.clear();
  }
  static void store(StreamModel& stream, const wire::SceneEdit& edit) {
    const std::pair key(edit.node, edit.property);
    if (std::holds_alternative<wire::Cleared>(edit.value)) {
      stream.edits.erase(key);
      return;
    }
    Edit& stored = stream.edits[key];
    stored = {edit.version, 0, edit.value, stored.node, stored.is_looked_up, false};
  }
  void resolve_name_conflict(const std::string& name, const NodeNames& file_names) {
    bool is_taken = file_names.file_has(name);
    for (auto& [age, stream] : streams_) {
      const auto edit = stream.edits.find({name, Property::node});
      if (edit == stream.edits.end() || edit->second.is_refused ||
          !std::holds_alternative<wire::NodeAdded>(edit->second.value))
        continue;
      if (is_taken) refuse(edit->second);
      is_taken = true;
    }
  }
  void refuse(Edit& edit) {
    if (!std::exchange(edit.is_refused, true)) ++faults.refused;
  }
  static void fault(Edit& edit, uint64_t& count) {
    if (std::exchange(edit.fault_version, edit.version) != edit.version) ++count;
  }
  void bind(const PoseState& poses) {
    const uint64_t before = std::exchange(scene_revision_, poses.scene_revision());
    const auto new_node_of = [&](uint32_t node) {
      if (scene_revision_ == before) return node;
      const bool is_next = scene_revision_ == before + 1 && node < poses.new_node_of_old().size();
      return is_next ? poses.new_node_of_old()[node] : kNone;
    };
    for (auto& [age, stream] : streams_) {
      std::set<uint32_t> reserved;
      for (const uint32_t node : stream.reserved) {
        if (new_node_of(node) != kNone) reserved.insert(new_node_of(node));
      }
      stream.reserved = std::move(reserved);
      for (auto& [key, edit] : stream.edits) {
        edit.node = new_node_of(edit.node);
        if (edit.node != kNone || (scene_revision_ == before && edit.is_looked_up)) continue;
        edit.node = poses.names().find(key.first);
        edit.is_looked_up = true;
      }
    }
  }

  std::map<uint64_t, StreamModel> streams_;
  uint64_t scene_revision_ = 0;
};

constexpr uint32_t kFileNodes = 24;
constexpr size_t kSlots = 6, kScenes = 4;

// A tree whose shape the seed makes; the file's nodes are the same in all scenes, and some more stand behind.
scene::Scene tree(uint32_t seed, uint32_t more) {
  std::mt19937 shape(seed);
  scene::Scene scene;
  scene.meshes.emplace_back();
  for (uint32_t i = 0; i < kFileNodes + more; ++i) {
    scene::Node node;
    // Some names are shared, so that nobody finds these nodes by name.
    node.name = i % 7 == 6 ? "twin" : "node " + std::to_string(i);
    if (i >= kFileNodes) node.name = "added " + std::to_string((i + more) % 8);
    if (i > 0 && shape() % 4 != 0) node.parent = shape() % i;
    if (i >= kFileNodes) node.parent = (i * 5) % kFileNodes;
    node.path = (node.parent == scene::kNone ? "" : scene.nodes[node.parent].path + "/") + node.name;
    if (i % 3 == 0) node.mesh = 0;
    scene.nodes.push_back(node);
  }
  return scene;
}

class RandomEdits : public testing::TestWithParam<uint32_t> {
 protected:
  uint32_t below(uint32_t limit) { return static_cast<uint32_t>(random_() % limit); }

  std::string name() {
    const uint32_t kind = below(10);
    if (kind == 0) return "nobody " + std::to_string(below(3));
    if (kind == 1) return "added " + std::to_string(below(8));
    if (kind == 2) return scenes_[current_].nodes[below(kFileNodes)].path;
    return "node " + std::to_string(below(kFileNodes));
  }

  wire::EditValue value(Property property) {
    if (below(4) == 0) return wire::Cleared{};
    switch (property) {
      case Property::visible:
        return wire::Visible{below(3) == 0};
      case Property::base_color:
        return wire::BaseColor{{static_cast<float>(below(5)), 0, 0, 1}};
      case Property::light:
        return wire::Light{.intensity = static_cast<float>(below(5))};
      default:
        if (below(2) == 0) return wire::NodeRemoved{};
        return wire::NodeAdded{};
    }
  }

  void join(size_t slot, uint64_t place) {
    wire::StreamDescription description;
    description.epoch = ++epoch_;
    description.adapter_name = "stream " + std::to_string(slot);
    for (uint32_t i = below(4); i-- > 0;) description.node_names.push_back(name());
    slots_[slot].id = poses_.add_stream(description, nullptr, place);
    slots_[slot].is_there = true;
    slots_[slot].version = 0;
  }

  void operate() {
    now_ns_ += 1;
    const size_t slot = below(kSlots);
    Slot& stream = slots_[slot];
    const uint32_t what = below(100);
    if (!stream.is_there) return join(slot, below(2) == 0 ? stream.place : 0);
    if (what < 3) {
      poses_.remove_stream(stream.id);
      stream.is_there = false;
    } else if (what < 7) {
      stream.place = poses_.suspend_stream(stream.id, now_ns_ + below(60));
      stream.is_there = false;
    } else if (what < 9) {
      const size_t other = below(kSlots);
      if (!slots_[other].is_there && slots_[other].place != 0)
        poses_.pass_reserved_nodes(slots_[other].place, stream.id);
    } else if (what < 11) {
      current_ = below(kScenes);
      poses_.set_scene(scenes_[current_]);
    } else if (what < 13) {
      const std::vector<RequestedNode> wanted = registry_.requested_nodes();
      if (wanted.empty()) return;
      const RequestedNode& node = wanted[below(static_cast<uint32_t>(wanted.size()))];
      registry_.refuse_node(node, "a test");
      reference_.refuse(node);
    } else {
      const auto property = static_cast<Property>(std::array{0, 0, 1, 2, 4}[below(5)]);
      poses_.apply(stream.id,
                   {poses_.streams()[stream.id].epoch, ++stream.version, name(), property, value(property)});
    }
  }

  void compare() {
    poses_.advance(now_ns_);
    // Copies: edits are handed on once.
    std::vector<SceneChanges> changes = poses_.take_scene_changes(), copies;
    for (const SceneChanges& change : changes) {
      SceneChanges& copy = copies.emplace_back();
      copy.stream = change.stream;
      copy.age = change.age;
      copy.ended = change.ended;
      copy.may_return = change.may_return;
      copy.edits = change.edits;
    }
    reference_.apply(copies, poses_.names());
    registry_.apply(std::move(changes), &poses_.names());
    const bool complete = below(3) != 0;
    const scene::Scene& scene = scenes_[current_];
    const scene::NodeEdits& edits = registry_.resolve(scene, poses_, complete);
    ASSERT_EQ(edits, reference_.resolve(scene, poses_, complete));
    ASSERT_EQ(registry_.faults().conflicting, reference_.faults.conflicting);
    ASSERT_EQ(registry_.faults().unmatched, reference_.faults.unmatched);
    ASSERT_EQ(registry_.faults().unfit, reference_.faults.unfit);
    ASSERT_EQ(registry_.faults().refused, reference_.faults.refused);
    compare_changes(scene, edits);
  }

  // SceneEdits with what changed against SceneEdits with all of it.
  void compare_changes(const scene::Scene& scene, const scene::NodeEdits& edits) {
    whole_.set(scene, edits);
    const EditRegistry::Resolved resolved = registry_.take_resolved();
    if (resolved.all) {
      changed_.set(scene, edits);
    } else {
      scene::SceneEdits::NodeChanges changes;
      for (const uint32_t node : resolved.nodes) {
        const auto edit = edits.find(node);
        changes.emplace_back(node, edit == edits.end() ? std::nullopt : std::optional(edit->second));
      }
      changed_.change(scene, std::move(changes));
    }
    ASSERT_EQ(changed_.nodes(), whole_.nodes());
    ASSERT_EQ(changed_.hidden(), whole_.hidden());
    for (uint32_t node = 0; node < scene.nodes.size(); ++node)
      ASSERT_EQ(changed_.is_removed(node), whole_.is_removed(node)) << node;
    ASSERT_EQ(changed_.revisions(), whole_.revisions());
  }

  struct Slot {
    StreamId id = 0;
    bool is_there = false;
    uint64_t version = 0, place = 0;
  };
  std::mt19937 random_{GetParam()};
  const std::vector<scene::Scene> scenes_ = [] {
    std::vector<scene::Scene> scenes;
    for (uint32_t more = 0; more < kScenes; ++more) scenes.push_back(tree(GetParam(), 2 * more));
    return scenes;
  }();
  size_t current_ = 0;
  PoseState poses_{scenes_[0]};
  EditRegistry registry_;
  Reference reference_;
  scene::SceneEdits whole_, changed_;
  std::vector<Slot> slots_{kSlots};
  uint64_t epoch_ = 0;
  int64_t now_ns_ = 0;
};

TEST_P(RandomEdits, IncrementalMatchesRecomputation) {
  constexpr int kOperations = 4000;
  for (int i = 0; i < kOperations; ++i) {
    for (uint32_t batch = 1 + below(3); batch-- > 0;) operate();
    compare();
    ASSERT_FALSE(HasFatalFailure()) << "after operation " << i;
  }
  EXPECT_GT(reference_.faults.conflicting, 100u) << "the streams do not meet";
  EXPECT_GT(reference_.faults.unmatched, 100u);
  EXPECT_GT(reference_.faults.refused, 10u);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomEdits, testing::Range(1u, 9u));

// Thousands of edits in force do not make a further one longer.
TEST(EditBookCost, ChangedKeyResolvesItself) {
  constexpr uint32_t kNodes = 5000;
  scene::Scene scene;
  for (uint32_t i = 0; i < kNodes; ++i) {
    scene::Node& node = scene.nodes.emplace_back();
    node.name = node.path = std::to_string(i);
  }
  PoseState poses(scene);
  wire::StreamDescription description;
  description.epoch = 1;
  const StreamId id = poses.add_stream(description);
  description.epoch = 2;
  const StreamId younger = poses.add_stream(description);
  EditRegistry registry;
  uint64_t version = 0;
  const auto hide = [&](StreamId stream, uint32_t node) {
    poses.apply(stream, {poses.streams()[stream].epoch, ++version, std::to_string(node), Property::visible,
                         wire::Visible{false}});
  };
  const auto resolve = [&] {
    registry.apply(poses.take_scene_changes());
    const uint64_t before = registry.nodes_resolved();
    (void)registry.resolve(scene, poses);
    return registry.nodes_resolved() - before;
  };
  for (uint32_t i = 0; i < kNodes; ++i) hide(id, i);
  EXPECT_EQ(resolve(), kNodes);
  hide(id, 17);
  EXPECT_EQ(resolve(), 1u);
  hide(younger, 18);
  EXPECT_EQ(resolve(), 1u);
  description.epoch = 3;
  description.node_names = {"19"};
  poses.add_stream(description);
  EXPECT_EQ(resolve(), 1u) << "another stream drives one of the nodes";
  EXPECT_EQ(resolve(), 0u);
}

}  // namespace
}  // namespace fire3dv::state
