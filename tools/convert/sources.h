// What a model was made of. Each file is looked at before it is read, never after: who writes or replaces it
// while it is read has changed it since then, and the next start sees that.
#pragma once

#include <filesystem>
#include <set>
#include <vector>

#include "renderer/scene/conversion_record.h"

namespace fire3dv::convert {

class Sources {
 public:
  using Source = scene::ConversionRecord::Source;

  // A file that is about to be read, or looked for: found or not, as it is now. The first look counts.
  void add(const std::filesystem::path& file) {
    if (known_.insert(file).second) all_.push_back({file, scene::stamp_of(file)});
  }
  // One that another process has looked at.
  void add(const Source& seen) {
    if (known_.insert(seen.file).second) all_.push_back(seen);
  }

  // In the order in which they were added.
  const std::vector<Source>& all() const { return all_; }
  bool contains(const std::filesystem::path& file) const { return known_.contains(file); }

 private:
  std::vector<Source> all_;
  std::set<std::filesystem::path> known_;
};

}  // namespace fire3dv::convert
