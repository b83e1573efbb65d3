#include "protocol/stream/input_registry.h"

namespace fire3dv::stream {
namespace {

constexpr uint64_t kBytesPerInput = 512;  // overhead of containers

uint64_t bytes_of(const std::string& name, const wire::Input& input) {
  uint64_t bytes = kBytesPerInput + name.size() + input.unit.size() + input.text.size();
  for (const std::string& choice : input.choices) bytes += sizeof choice + choice.size();
  return bytes;
}

bool differ_in_values_only(wire::Input a, const wire::Input& b) {
  a.value = b.value;
  a.speed = b.speed;
  a.text = b.text;
  return a == b;
}

}  // namespace

Result<void> InputRegistry::apply(const wire::SceneEdit& edit) {
  const auto known = inputs_.find(edit.node);
  const auto* const input = std::get_if<wire::Input>(&edit.value);
  if (known != inputs_.end() && input && known->second.input == *input) return {};
  if (known == inputs_.end() && !input) return {};
  ++revision_;
  if (known != inputs_.end() && input && differ_in_values_only(known->second.input, *input) &&
      known->second.charge.resize(bytes_of(edit.node, *input)).ok()) {
    known->second.input = *input;
    return {};
  }
  ++structure_;
  if (known != inputs_.end()) inputs_.erase(known);
  if (!input) return {};
  if (inputs_.size() == wire::kMaxInputs)
    return Error{"a stream has at most " + std::to_string(wire::kMaxInputs) +
                 " inputs; this declaration is refused: clear others first"};
  Result<BudgetCharge> charge =
      BudgetCharge::take(budget_, Resource::edit_bytes, bytes_of(edit.node, *input));
  if (!charge) return charge.error();
  inputs_.emplace(edit.node, Entry{*input, std::move(*charge)});
  return {};
}

}  // namespace fire3dv::stream
