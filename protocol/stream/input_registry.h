// Declared inputs of one stream, by name, within the limits of a stream and the peer's budget for edits. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/peer_budget.h"
#include "protocol/wire/scene_edit.h"

namespace fire3dv::stream {

class InputRegistry {
 public:
  InputRegistry() = default;
  // budget null: no limits but the number of inputs.
  explicit InputRegistry(std::shared_ptr<PeerBudget> budget) : budget_(std::move(budget)) {}

  struct Entry {
    wire::Input input;
    BudgetCharge charge;
  };

  // Applies an edit of the property `input`. On error the declaration is refused, and an earlier one of the
  // name ends: its stream does not mean it any more.
  Result<void> apply(const wire::SceneEdit& edit);

  const std::map<std::string, Entry>& inputs() const { return inputs_; }
  // Null: not declared.
  const wire::Input* find(const std::string& name) const {
    const auto known = inputs_.find(name);
    return known == inputs_.end() ? nullptr : &known->second.input;
  }
  // The first declared input of a kind; null: there is none.
  const std::pair<const std::string, Entry>* find(wire::InputKind kind) const {
    for (const auto& entry : inputs_)
      if (entry.second.input.kind == kind) return &entry;
    return nullptr;
  }
  uint64_t revision() const { return revision_; }    // incremented by each change
  uint64_t structure() const { return structure_; }  // incremented by changes other than of current values

 private:
  std::shared_ptr<PeerBudget> budget_;
  std::map<std::string, Entry> inputs_;
  uint64_t revision_ = 0, structure_ = 0;
};

}  // namespace fire3dv::stream
