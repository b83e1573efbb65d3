#include "protocol/wire/edit_store.h"

#include <algorithm>

#include "protocol/wire/check.h"
#include "protocol/wire/limits.h"

namespace fire3dv::wire {

Result<EditStore::Prepared> EditStore::prepare(SceneEdit edit) const {
  edit.epoch = epoch_;
  edit.version = version_ + 1;
  if (auto good = check(edit, {}); !good) return good.error();
  Prepared prepared;
  prepared.name = {edit.node, edit.property};
  const auto known = stored_.find(prepared.name);
  if (known == stored_.end() && stored_.size() >= kMaxSceneEdits)
    return Error{"SceneEdit.node \"" + printable(edit.node) + "\": " + std::to_string(kMaxSceneEdits) +
                 " edits exist already; call describe again to clear them, or edit fewer nodes"};
  auto message = std::make_shared<const Bytes>(encode(edit));
  const size_t freed = known == stored_.end() ? 0 : cost_of(known->second.message->size());
  const size_t needed = used_bytes_ - freed + cost_of(message->size());
  // A smaller value always fits: otherwise a full store could not shrink.
  if (needed > budget_bytes_ && cost_of(message->size()) > freed)
    return Error{"SceneEdit of \"" + printable(edit.node) + "\": all edits together would take " +
                 std::to_string(needed) + " bytes; the budget is " + std::to_string(budget_bytes_) +
                 ": raise scene_budget_bytes, or clear edits that are no longer needed"};
  prepared.stored = {known == stored_.end() ? last_key_ + 1 : known->second.key, edit.version, edit.property,
                     std::move(message)};
  return prepared;
}

void EditStore::commit(Prepared&& prepared) {
  version_ = prepared.stored.version;
  last_key_ = std::max(last_key_, prepared.stored.key);
  Stored& stored = stored_[std::move(prepared.name)];
  if (stored.message) used_bytes_ -= cost_of(stored.message->size());
  used_bytes_ += cost_of(prepared.stored.message->size());
  stored = std::move(prepared.stored);
}

void EditStore::set_epoch(uint64_t epoch) {
  epoch_ = epoch;
  for (auto& [name, stored] : stored_) {
    // Copies the message: links may still be sending the old one.
    Bytes message = *stored.message;
    wire::set_epoch(message, epoch);
    stored.message = std::make_shared<const Bytes>(std::move(message));
  }
}

std::vector<EditStore::Stored> EditStore::in_order() const {
  std::vector<Stored> result;
  result.reserve(stored_.size());
  for (const auto& [name, stored] : stored_) result.push_back(stored);
  std::sort(result.begin(), result.end(),
            [](const Stored& a, const Stored& b) { return a.version < b.version; });
  return result;
}

}  // namespace fire3dv::wire
