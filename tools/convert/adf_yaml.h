// ADF files as values that can be asked for anything: what is missing or odd gives the answer that was
// proposed, and a warning that names file and line.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/error.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

// Collects what is to be said about a scene, each thing once.
class AdfReport {
 public:
  explicit AdfReport(Model& model) : model_(model) {}

  void warn(std::string sentence);
  void unknown_field(const std::string& name, const std::string& place) { unknown_.emplace(name, place); }
  // Adds the sentences that can only be said at the end.
  void finish();

 private:
  Model& model_;
  size_t left_out_ = 0;
  std::map<std::string, bool> said_;
  std::map<std::string, std::string> unknown_;  // to the first place
};

class AdfValue {
 public:
  AdfValue() = default;
  AdfValue(YAML::Node node, std::string file, AdfReport& report);

  bool is_defined() const { return node_.IsDefined() && !node_.IsNull(); }
  bool is_map() const { return node_.IsDefined() && node_.IsMap(); }
  // Of a map; of anything else, undefined. Of keys that are there twice the first, as AMBF takes it. Of a map
  // that is longer than any of AMBF's, only the beginning is looked at: it may be listed thousands of times.
  AdfValue operator[](std::string_view key) const;
  // A list's items, up to so many; none if it is no list.
  std::vector<AdfValue> items(size_t most = 200'000) const;
  // FILE:LINE
  std::string place() const;

  double number(double otherwise) const;
  bool flag(bool otherwise) const;
  std::string text(const std::string& otherwise = {}) const;
  glm::dvec3 vector(const glm::dvec3& otherwise, std::string_view keys = "xyz") const;
  void warn(const std::string& what) const;

 private:
  friend class AdfFile;
  YAML::Node node_{YAML::NodeType::Undefined};
  std::string file_;
  std::string name_;  // of the field
  AdfReport* report_ = nullptr;
};

class AdfFile {
 public:
  // Bounds size and depth; the error names file and line.
  static Result<AdfFile> read(const std::filesystem::path& file, AdfReport& report);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path folder() const { return path_.parent_path(); }
  bool has(std::string_view key) const { return index_.contains(std::string(key)); }
  AdfValue operator[](std::string_view key) const;

  struct Block {
    std::string id;
    AdfValue value;
  };
  // The blocks that a list of the file names, in its order; missing ones are warned of.
  std::vector<Block> blocks(std::string_view list) const;
  // Fields of the file itself, and of a block, that AMBF does not know either.
  void note_unknown_fields() const;
  void note_unknown_fields(const AdfValue& block) const;

 private:
  std::filesystem::path path_;
  AdfReport* report_ = nullptr;
  YAML::Node root_;
  std::map<std::string, YAML::Node> index_;  // of the root: yaml-cpp would look through all keys each time
};

}  // namespace fire3dv::convert
