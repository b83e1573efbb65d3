// Warnings about an SDF scene: each once, and a limited number.
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "convert/model.h"

namespace fire3dv::convert {

class SdfWarnings {
 public:
  static constexpr size_t kMaxWarnings = 1000;  // hostile scenes have more than fit into memory

  // file: precedes each warning; empty for a scene that is in no file. model: borrowed; receives them.
  SdfWarnings(const std::filesystem::path& file, Model& model)
      : prefix_(file.empty() ? "" : file.string() + ": "), model_(model) {}

  void add(const std::string& text);

 private:
  const std::string prefix_;
  Model& model_;
  std::set<std::string> known_;
};

}  // namespace fire3dv::convert
