// The scene edits of a stream as its publisher keeps them: the newest value of each key, within a budget.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "protocol/error.h"
#include "protocol/wire/encode.h"

namespace fire3dv::wire {

class EditStore {
 public:
  static constexpr size_t kDefaultBudgetBytes = size_t{64} << 20;
  static constexpr size_t kMostBudgetBytes = size_t{256} << 20;
  static constexpr size_t kMostKeys = 65'536;  // more than that readers refuse

  explicit EditStore(size_t budget_bytes = kDefaultBudgetBytes) : budget_bytes_(budget_bytes) {}

  struct Stored {
    uint64_t key = 0;  // a number for each (node, property), never given out twice
    uint64_t version = 0;
    std::shared_ptr<const Bytes> message;
  };

  // What an edit would be: encoded, with the next version. `edit`'s own epoch and version are ignored. An
  // error names the field that no reader would take, or says that the budget is used up. Nothing changes
  // until commit(), so that what a link refuses is not kept.
  struct Prepared {
    Stored stored;
    std::pair<std::string, Property> name;
  };
  Result<Prepared> prepare(SceneEdit edit) const;
  void commit(Prepared&& prepared);

  // All of them carry this epoch from now on.
  void set_epoch(uint64_t epoch);

  // By version.
  std::vector<Stored> in_order() const;
  uint64_t version() const { return version_; }
  size_t used_bytes() const { return used_bytes_; }

 private:
  static size_t cost_of(size_t message_bytes) { return message_bytes + 256; }  // and the store's own memory

  size_t budget_bytes_;
  size_t used_bytes_ = 0;
  uint64_t epoch_ = 1;  // any but 0, until there is one
  uint64_t version_ = 0;
  uint64_t last_key_ = 0;
  std::map<std::pair<std::string, Property>, Stored> stored_;
};

}  // namespace fire3dv::wire
