// Evaluation of ${...} and $(...) in the text of xacro files, with the files and arguments that they name.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "convert/model.h"
#include "convert/urdf_files.h"
#include "convert/xacro/expression/expression.h"
#include "convert/xacro/scope.h"

namespace fire3dv::convert::xacro {

class Substitution : public Environment {
 public:
  Substitution(const std::filesystem::path& file, std::map<std::string, std::string> arguments,
               UrdfFiles& files, Sources& sources, Budget& budget);

  // Returns the value of a text. A text that is one expression keeps its type.
  Value evaluate_text(const std::string& text, Scope& scope);
  std::string evaluate_to_text(const std::string& text, Scope& scope);
  // Value of a condition. `condition` is for the message.
  static bool boolean(const Value& value, const std::string& condition);

  // Sets the default of xacro:arg. The first value counts.
  void set_default_argument(const std::string& name, const std::string& value);

  // Folder of the file that is being expanded comes first for relative paths.
  void push_file(const std::filesystem::path& file);
  void pop_file() { open_files_.pop_back(); }
  const std::filesystem::path& current_file() const { return open_files_.back(); }

  // Resolves the name of an included file to a regular file that may be read.
  std::filesystem::path readable_file(const std::string& name);
  // Resolves a pattern with * and ? in its last part; a name without them is the only result.
  std::vector<std::string> expand_pattern(const std::string& pattern);

  // A file that is not named as xacro may have left-over elements of xacro, which readers of URDF ignore.
  bool ignores_unknown_macros() const { return open_files_.front().extension() != ".xacro"; }

  void warn(const std::string& text);
  std::vector<std::string> take_warnings();

  std::optional<Value> property(Scope* scope, const std::string& name) override;
  std::string argument(const std::string& name) override;
  Value load_yaml(const std::string& path) override;
  std::string absolute_path(const std::string& path) override;
  void message(const std::string& level, const std::string& text) override;

 private:
  Value evaluate_expression(const std::string& text, Scope& scope);
  std::string evaluate_command(const std::string& text, Scope& scope);
  std::string evaluate_arguments(const std::string& text);
  bool has_argument(const std::string& name) const;
  std::string package_folder(const std::string& name);

  std::vector<std::filesystem::path> open_files_;
  std::map<std::string, std::string> given_arguments_, default_arguments_;
  std::set<std::string> used_arguments_;
  UrdfFiles& files_;
  Sources& sources_;
  Budget& budget_;
  Scope* scope_ = nullptr;  // of the expression that is being evaluated
  std::map<std::string, std::unique_ptr<Expression>> parsed_;
  std::map<std::string, std::string> missing_packages_;  // error by name
  std::vector<std::string> warnings_;
  size_t files_read_ = 0;
};

// Converts a YAML file as PyYAML's safe_load does, with xacro's units (!degrees, !millimeters, ...).
Value value_of_yaml(const std::string& text, const std::string& file, Environment& environment,
                    Budget& budget);

}  // namespace fire3dv::convert::xacro
