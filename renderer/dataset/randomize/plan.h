// Randomisation file of a data set (YAML): which parameters are drawn, from which distributions. The format
// is docs/randomization.md's. Files are untrusted: unknown fields are refused by name, numbers have limits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "renderer/dataset/randomize/distribution.h"
#include "renderer/dataset/randomize/given_draws.h"
#include "renderer/dataset/randomize/trajectory.h"

namespace fire3dv::dataset {

enum class Section : uint8_t {
  cameras,
  nodes,
  materials,
  lights,
  environment,
  background,
  scene,
  distractors
};
constexpr size_t kSections = 8;

// files: words that are names of files. flag: true or false, not drawn.
enum class FieldType : uint8_t { number, vector, chance, place, rotation, word, file, files, flag };
struct Field {
  FieldType type = FieldType::number;
  double least = 0, most = 0;  // limits of its numbers
  Distribution number;
  VectorDistribution vector;
  std::string node;                // of look_at: name or path; empty: the vector
  std::vector<std::string> words;  // texts to choose from; of files: their paths
  std::string folder;              // of files: all of it, read by read_plan(); empty: the words
  int line = 0;
};

// Fields of the objects whose name matches the pattern.
struct Entry {
  std::string pattern;  // * stands for any characters; empty: of a section without objects
  int line = 0;
  std::map<std::string, Field, std::less<>> fields;

  const Field* find(std::string_view name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? nullptr : &found->second;
  }
  bool has_flag(std::string_view name) const {
    const Field* const field = find(name);
    return field && field->number.low != 0;
  }
};

struct Plan {
  std::string file;  // for messages
  std::string text;
  uint64_t seed = 0;
  std::map<std::string, Trajectory, std::less<>> paths;  // of cameras, by the text of the file
  struct Input {
    std::filesystem::path path;
    std::string digest;
  };
  std::map<std::string, Input, std::less<>> maps;         // of the environment, by the text of the file
  std::map<std::string, Input, std::less<>> textures;     // of materials
  std::map<std::string, Input, std::less<>> distractors;  // glTF files
  GivenDraws given;
  std::array<std::vector<Entry>, kSections> entries;

  // Null: there are none.
  const Entry* distractor_entry() const {
    const std::vector<Entry>& found = of(Section::distractors);
    return found.empty() ? nullptr : &found.front();
  }
  const std::vector<Entry>& of(Section section) const { return entries[static_cast<size_t>(section)]; }
};

constexpr size_t kMaxPlanBytes = 64 << 10;
constexpr size_t kMaxPlanFiles = 1000;    // textures, and glTF files of distractors
constexpr size_t kMaxDistractors = 1000;  // files times copies
// Fields of materials that choose a texture.
constexpr const char* kTextureFields[] = {"base_color_texture", "normal_texture", "roughness_texture"};

// Errors name file, line and field.
Result<Plan> parse_plan(const std::string& text, const std::string& file);
// With the files that it names, relative to its folder.
Result<Plan> read_plan(const std::filesystem::path& file);

const char* name_of(Section section);
// True if the text matches the pattern.
bool matches(std::string_view pattern, std::string_view text);

}  // namespace fire3dv::dataset
