// The user's additions as requests of a scene build, beside those of streams. They are merged first, so that
// a node of a stream with the same name is refused, and have no budget: the user may fill the machine.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "renderer/live_scene/asset_files.h"
#include "renderer/state/edits/addition.h"
#include "renderer/state/edits/edit_registry.h"

namespace fire3dv::app {

// Nodes of an addition in the displayed scene.
struct ShownAddition {
  std::string name;
  uint32_t root = 0;
  std::vector<uint32_t> sources;  // of a copy: the nodes of which root and those that follow it are copies
  MergedAsset asset = {};         // of an added file
};

class UserAdditions {
 public:
  static constexpr uint64_t kAge = UINT64_MAX;  // of the requests; no stream has it
  static bool are_of_user(const state::RequestedNode& node) { return node.age == kAge; }

  // Assets and copies.
  static bool may_be_large(const state::RequestedNode& node);

  // Replaces all additions. Returns the age and version of requests that have ended; a changed addition is a
  // new request. After a change refused additions are tried again; those that lacked memory only if others
  // have ended.
  std::vector<std::pair<uint64_t, uint64_t>> set(const state::Additions& additions);
  uint64_t revision() const { return revision_; }  // rises when requests() changes
  // Without those that were refused.
  std::vector<state::RequestedNode> requests() const;
  bool is_requested(const state::RequestedNode& node) const;
  // Returns true if this reason is new, so that it is to be reported.
  bool refuse(const state::RequestedNode& node, const std::string& reason, bool is_for_memory = false);
  // Names and reasons of the first ones that were refused.
  std::vector<std::pair<std::string, std::string>> refused(size_t most) const;
  // The nodes of the scene have changed: refused additions are tried again. Returns true if there are any.
  bool try_again();

 private:
  struct Entry {
    uint64_t version = 0;
    std::shared_ptr<const state::Addition> addition;
    std::shared_ptr<const wire::NodeAdded> added;
    bool is_refused = false;
    bool is_for_memory = false;  // the refusal
    std::string reason;          // reported last
  };
  std::map<std::string, Entry> entries_;  // by name
  uint64_t last_version_ = 0, revision_ = 0;
};

}  // namespace fire3dv::app
