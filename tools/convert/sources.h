// Source files of a model with their time stamps. A stamp is taken before the file is read, so that a change
// during the read is detected at the next start.
#pragma once

#include <filesystem>
#include <set>
#include <vector>

#include "renderer/scene/cache/conversion_record.h"

namespace fire3dv::convert {

class Sources {
 public:
  using Source = scene::ConversionRecord::Source;

  // Adds a file before it is read or looked for, with its current stamp. The first stamp counts.
  void add(const std::filesystem::path& file) {
    if (known_.insert(file).second) all_.push_back({file, scene::stamp_of(file)});
  }
  // Adds a file that another process has stamped.
  void add(const Source& seen) {
    if (known_.insert(seen.file).second) all_.push_back(seen);
  }

  // In order of addition.
  const std::vector<Source>& all() const { return all_; }
  bool contains(const std::filesystem::path& file) const { return known_.contains(file); }

 private:
  std::vector<Source> all_;
  std::set<std::filesystem::path> known_;
};

}  // namespace fire3dv::convert
