// Publisher's store of scene edits: the newest value of each key, within a byte limit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/wire/encode.h"

namespace fire3dv::wire {

class EditStore {
 public:
  static constexpr size_t kDefaultBudgetBytes = size_t{64} << 20;

  explicit EditStore(size_t budget_bytes = kDefaultBudgetBytes) : budget_bytes_(budget_bytes) {}

  struct Stored {
    uint64_t key = 0;  // one number per (node, property), never reused
    uint64_t version = 0;
    Property property{};
    std::shared_ptr<const Bytes> message;
  };

  // Encodes an edit with the next version; ignores `edit`'s own epoch and version. The error names the
  // invalid field or the exceeded limit. Nothing changes until commit(), so that edits refused by a link are
  // not stored.
  struct Prepared {
    Stored stored;
    std::pair<std::string, Property> name;
  };
  Result<Prepared> prepare(SceneEdit edit) const;
  void commit(Prepared&& prepared);

  // Sets the epoch of all stored edits.
  void set_epoch(uint64_t epoch);

  // Sorted by version.
  std::vector<Stored> in_order() const;
  uint64_t version() const { return version_; }
  size_t used_bytes() const { return used_bytes_; }

 private:
  static size_t cost_of(size_t message_bytes) { return message_bytes + 256; }  // plus the store's own memory

  size_t budget_bytes_;
  size_t used_bytes_ = 0;
  uint64_t epoch_ = 1;  // any value but 0, until set_epoch()
  uint64_t version_ = 0;
  uint64_t last_key_ = 0;
  std::map<std::pair<std::string, Property>, Stored> stored_;
};

}  // namespace fire3dv::wire
