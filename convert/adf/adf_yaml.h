// Tolerant access to ADF files (YAML). Missing or malformed values yield the given default, with a warning
// that names file and line.
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

#include "base/error.h"
#include "convert/model.h"

namespace fire3dv::convert {

// Collector of warnings about a scene, each reported once.
class AdfReport {
 public:
  explicit AdfReport(Model& model) : model_(model) {}

  void warn(std::string sentence);
  void unknown_field(const std::string& name, const std::string& location) {
    unknown_.emplace(name, location);
  }
  // Adds the warnings that need the whole scene.
  void finish();

 private:
  Model& model_;
  size_t left_out_ = 0;
  std::map<std::string, bool> said_;
  std::map<std::string, std::string> unknown_;  // unknown field to its first location
};

class AdfValue {
 public:
  AdfValue() = default;
  AdfValue(YAML::Node node, std::string file, AdfReport& report);

  bool is_defined() const { return node_.IsDefined() && !node_.IsNull(); }
  bool is_map() const { return node_.IsDefined() && node_.IsMap(); }
  // Returns the value of a map's key; undefined for other types. Of duplicate keys the first counts, as in
  // AMBF. Only the beginning of overlong maps is searched, since a file may list the same map thousands of
  // times.
  AdfValue operator[](std::string_view key) const;
  // Returns at most `most` items of a list; none for other types.
  std::vector<AdfValue> items(size_t most = 200'000) const;
  // "FILE:LINE"
  std::string location() const;

  double number(double otherwise) const;
  bool flag(bool otherwise) const;
  std::string text(const std::string& otherwise = {}) const;
  glm::dvec3 vector(const glm::dvec3& otherwise, std::string_view keys = "xyz") const;
  void warn(const std::string& what) const;

 private:
  friend class AdfFile;
  YAML::Node node_{YAML::NodeType::Undefined};
  std::string file_;
  std::string name_;  // name of the field
  AdfReport* report_ = nullptr;
};

class AdfFile {
 public:
  // Parses with limits on size and depth. The error names file and line.
  static Result<AdfFile> read(const std::filesystem::path& file, AdfReport& report);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path folder() const { return path_.parent_path(); }
  bool has(std::string_view key) const { return index_.contains(std::string(key)); }
  AdfValue operator[](std::string_view key) const;

  struct Block {
    std::string id;
    AdfValue value;
  };
  // Returns the blocks that a list of the file names, in its order; missing ones cause warnings.
  std::vector<Block> blocks(std::string_view list) const;
  // Warns of fields of the file, or of a block, that AMBF does not have either.
  void note_unknown_fields() const;
  void note_unknown_fields(const AdfValue& block) const;

 private:
  std::filesystem::path path_;
  AdfReport* report_ = nullptr;
  YAML::Node root_;
  std::map<std::string, YAML::Node> index_;  // index of the root: yaml-cpp's look-up is linear
};

// True for field names of ADF, for rendering and for simulation. Other names are likely typos.
bool is_adf_field(std::string_view name);

}  // namespace fire3dv::convert
