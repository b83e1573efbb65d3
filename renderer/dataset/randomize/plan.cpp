#include "renderer/dataset/randomize/plan.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "base/digest.h"
#include "base/files.h"
#include "base/nearest_names.h"
#include "base/numbers.h"
#include "base/text.h"
#include "base/words.h"

namespace fire3dv::dataset {
namespace {

constexpr uint64_t kMaxMapBytes = uint64_t{4} << 30;
constexpr std::string_view kImages[] = {".png", ".jpg", ".jpeg", ".webp", ".ktx2"};
constexpr std::string_view kAssets[] = {".glb", ".gltf"};
constexpr size_t kMaxNumbers = 100'000;  // aliases repeat parts of a file
constexpr const char* kNames[kSections] = {"cameras",     "nodes",      "materials", "lights",
                                           "environment", "background", "scene",     "distractors"};

// Field of a section with the limits of its numbers.
struct Rule {
  Section section;
  const char* name;
  FieldType type;
  double least = 0, most = 0;
};
constexpr double kFar = 1e6;
constexpr Rule kRules[] = {
    {Section::cameras, "look_at", FieldType::place, -kFar, kFar},
    {Section::cameras, "look_at_offset_m", FieldType::vector, -kFar, kFar},
    {Section::cameras, "position_m", FieldType::vector, -kFar, kFar},
    {Section::cameras, "distance_m", FieldType::number, 1e-6, kFar},
    {Section::cameras, "azimuth_deg", FieldType::number, -360, 360},
    {Section::cameras, "elevation_deg", FieldType::number, -90, 90},
    {Section::cameras, "roll_deg", FieldType::number, -360, 360},
    {Section::cameras, "move_m", FieldType::vector, -kFar, kFar},
    {Section::cameras, "turn_deg", FieldType::vector, -360, 360},
    {Section::cameras, "fov_deg", FieldType::number, 0.1, 170},
    {Section::cameras, "path", FieldType::file},
    {Section::cameras, "path_at", FieldType::number, 0, 1},
    {Section::cameras, "f_number", FieldType::number, 0.1, 1000},
    {Section::cameras, "focus_distance_m", FieldType::number, 1e-3, 1e6},
    {Section::cameras, "exposure_ev", FieldType::number, -20, 20},
    {Section::cameras, "noise", FieldType::number, 0, 255},
    {Section::nodes, "position_m", FieldType::vector, -kFar, kFar},
    {Section::nodes, "move_m", FieldType::vector, -kFar, kFar},
    {Section::nodes, "turn_deg", FieldType::vector, -360, 360},
    {Section::nodes, "rotation", FieldType::rotation},
    {Section::nodes, "scale", FieldType::number, 1e-3, 1e3},
    {Section::nodes, "visible", FieldType::chance, 0, 1},
    {Section::nodes, "settle", FieldType::flag},
    {Section::materials, "base_color", FieldType::vector, 0, 1},
    {Section::materials, "alpha", FieldType::number, 0, 1},
    {Section::materials, "metallic", FieldType::number, 0, 1},
    {Section::materials, "roughness", FieldType::number, 0, 1},
    {Section::materials, "emissive", FieldType::vector, 0, 1e4},
    {Section::materials, "normal_scale", FieldType::number, 0, 10},
    {Section::materials, "base_color_texture", FieldType::files},
    {Section::materials, "normal_texture", FieldType::files},
    {Section::materials, "roughness_texture", FieldType::files},
    {Section::lights, "intensity", FieldType::number, 0, 1e9},
    {Section::lights, "color", FieldType::vector, 0, 1},
    {Section::lights, "radius_m", FieldType::number, 0, 1e3},
    {Section::lights, "on", FieldType::chance, 0, 1},
    {Section::lights, "look_at", FieldType::place, -kFar, kFar},
    {Section::lights, "look_at_offset_m", FieldType::vector, -kFar, kFar},
    {Section::lights, "position_m", FieldType::vector, -kFar, kFar},
    {Section::lights, "distance_m", FieldType::number, 1e-6, kFar},
    {Section::lights, "azimuth_deg", FieldType::number, -360, 360},
    {Section::lights, "elevation_deg", FieldType::number, -90, 90},
    {Section::environment, "intensity", FieldType::number, 0, 1e4},
    {Section::environment, "rotation_deg", FieldType::number, -360, 360},
    {Section::environment, "map", FieldType::word},
    {Section::background, "color", FieldType::vector, 0, 1},
    {Section::scene, "variant", FieldType::word},
    {Section::distractors, "files", FieldType::files},
    {Section::distractors, "copies", FieldType::number, 1, 100},
    {Section::distractors, "count", FieldType::number, 0, kMaxDistractors},
    {Section::distractors, "position_m", FieldType::vector, -kFar, kFar},
    {Section::distractors, "turn_deg", FieldType::vector, -360, 360},
    {Section::distractors, "rotation", FieldType::rotation},
    {Section::distractors, "scale", FieldType::number, 1e-3, 1e3},
    {Section::distractors, "settle", FieldType::flag},
    {Section::distractors, "labels", FieldType::flag},
};

bool has_objects(Section section) {
  return section < Section::environment;
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

struct Fault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Parser {
 public:
  Parser(const std::string& file, Plan& plan) : file_(file), plan_(plan) {}

  void read(const YAML::Node& root) {
    field_.clear();
    for_each(root, "a randomisation file", [&](const std::string& name, const YAML::Node& value) {
      for (size_t i = 0; i < kSections; ++i) {
        if (name == kNames[i]) return read_section(static_cast<Section>(i), value);
      }
      std::string known;
      for (const char* each : kNames) known += (known.empty() ? "" : ", ") + std::string(each);
      fail(value, "no such section: there are " + known);
    });
  }

 private:
  [[noreturn]] void fail(const YAML::Node& at, const std::string& text) const {
    const int line = at.Mark().line;
    throw Fault(file_ + (line < 0 ? "" : ":" + std::to_string(line + 1)) + ": " +
                (field_.empty() ? "" : printable_text(field_, 300) + ": ") + text);
  }

  // Calls take(name, value) for each entry of a map; names are unique.
  template <typename Take>
  void for_each(const YAML::Node& map, const char* what, const Take& take) {
    if (!map.IsMap()) fail(map, std::string(what) + " is a map, \"NAME: VALUE\" a line");
    const std::string outer = field_;
    std::map<std::string, bool> seen;
    for (const auto& entry : map) {
      if (!entry.first.IsScalar()) fail(entry.first, "a name is text");
      const std::string name = entry.first.Scalar();
      field_ = outer.empty() ? name : outer + "." + name;
      if (!seen.emplace(name, true).second) fail(entry.first, "is there twice: remove one");
      take(name, entry.second);
      field_ = outer;
    }
  }

  void read_section(Section section, const YAML::Node& value) {
    std::vector<Entry>& entries = plan_.entries[static_cast<size_t>(section)];
    if (!has_objects(section)) {
      entries.push_back(read_entry(section, value));
      return;
    }
    for_each(value, "a section", [&](const std::string& name, const YAML::Node& fields) {
      entries.push_back(read_entry(section, fields));
      entries.back().pattern = name;
    });
  }

  Entry read_entry(Section section, const YAML::Node& value) {
    Entry entry;
    entry.line = value.Mark().line + 1;
    for_each(value, "an object", [&](const std::string& name, const YAML::Node& field) {
      std::string known;
      for (const Rule& rule : kRules) {
        if (rule.section != section) continue;
        if (name == rule.name) {
          entry.fields[name] = read_field(rule, field);
          return;
        }
        known += (known.empty() ? "" : ", ") + std::string(rule.name);
      }
      std::vector<std::string> names;
      for (const Rule& rule : kRules) {
        if (rule.section == section) names.emplace_back(rule.name);
      }
      const std::vector<std::string> near = nearest_names(name, names, 1);
      fail(field, "no such field of " + std::string(name_of(section)) + ": there are " + known +
                      (near.empty() ? "" : "; did you mean " + near.front() + "?"));
    });
    check(section, entry, value);
    if (entry.find("path") && !entry.find("path_at")) {
      Field& at = entry.fields["path_at"];
      at.most = 1;
      at.number = {Distribution::Kind::uniform, 0, 1, {}, 0, 1};
    }
    return entry;
  }

  void check(Section section, const Entry& entry, const YAML::Node& at) const {
    std::vector<std::string> faults;  // all are reported
    const auto has = [&](const char* name) { return entry.find(name) != nullptr; };
    const auto needs = [&](const char* name, const char* other) {
      if (has(name) && !has(other)) faults.push_back(std::string(name) + " needs " + other);
    };
    const auto excludes = [&](const char* name, const char* other) {
      if (has(name) && has(other))
        faults.push_back(std::string(name) + " and " + other + ": choose one of them");
    };
    // A place on a shell has all four.
    std::vector<std::string> given, missing;
    for (const char* name : {"distance_m", "azimuth_deg", "elevation_deg"})
      (has(name) ? given : missing).push_back(name);
    if (!given.empty() && !has("look_at")) missing.insert(missing.begin(), "look_at");
    if (!given.empty() && !missing.empty()) {
      std::string list = missing.back();
      missing.pop_back();
      if (!missing.empty()) list = joined(missing) + " and " + list;
      faults.push_back(joined(given, " and ") + (given.size() == 1 ? " needs " : " need ") + list);
    }
    needs("look_at_offset_m", "look_at");
    excludes("position_m", "distance_m");
    needs("path_at", "path");
    excludes("path", "position_m");
    excludes("path", "distance_m");
    needs("focus_distance_m", "f_number");
    if (has("f_number") && !has("focus_distance_m") && !has("look_at"))
      faults.emplace_back("f_number needs focus_distance_m, or look_at to focus on");
    if (section == Section::distractors) {
      for (const char* needed : {"files", "count"}) {
        if (!has(needed)) faults.push_back(std::string("needs ") + needed);
      }
      if (const Field* const copies = entry.find("copies");
          copies && (copies->number.kind != Distribution::Kind::constant ||
                     copies->number.low != std::floor(copies->number.low)))
        faults.emplace_back("copies must be a whole number, and is not drawn");
    }
    if (section == Section::nodes || section == Section::distractors) {
      excludes("position_m", "move_m");
      excludes("rotation", "turn_deg");
    }
    if (!faults.empty()) fail(at, joined(faults, "; "));
  }

  Field read_field(const Rule& rule, const YAML::Node& value) {
    Field field;
    field.type = rule.type;
    field.least = rule.type == FieldType::rotation ? -1 : rule.least;
    field.most = rule.type == FieldType::rotation ? 1 : rule.most;
    field.line = value.Mark().line + 1;
    switch (rule.type) {
      case FieldType::number:
        field.number = read_number(rule, value);
        break;
      case FieldType::chance:
        field.number.low = read_constant(rule, value);
        break;
      case FieldType::vector:
        field.vector = read_vector(rule, value);
        break;
      case FieldType::place:
        if (value.IsScalar())
          field.node = value.Scalar();
        else
          field.vector = read_vector(rule, value);
        if (value.IsScalar() && field.node.empty()) fail(value, "name a node, or write [x, y, z]");
        break;
      case FieldType::word:
        field.words = read_words(value);
        break;
      case FieldType::files:
        read_files(value, field);
        break;
      case FieldType::flag:
        if (!value.IsScalar() || (value.Scalar() != "true" && value.Scalar() != "false"))
          fail(value, "must be true or false");
        field.number.low = value.Scalar() == "true" ? 1 : 0;
        break;
      case FieldType::file:
        if (!value.IsScalar() || value.Scalar().empty()) fail(value, "name a file");
        field.words = {value.Scalar()};
        break;
      case FieldType::rotation:
        if (!value.IsScalar() || value.Scalar() != "uniform")
          fail(value, "must be uniform; for ranges of angles use turn_deg");
        break;
    }
    return field;
  }

  double read_constant(const Rule& rule, const YAML::Node& value) {
    if (++numbers_ > kMaxNumbers)
      fail(value, "the file has more than " + std::to_string(kMaxNumbers) + " numbers");
    const std::optional<double> number =
        value.IsScalar() ? parse_number<double>(value.Scalar()) : std::nullopt;
    if (!number || !std::isfinite(*number))
      fail(value,
           "needs a number" + (value.IsScalar() ? ", and not " + quote(value.Scalar()) : std::string()));
    if (*number < rule.least || *number > rule.most)
      fail(value, number_text(*number) + " is outside of " + number_text(rule.least) + " to " +
                      number_text(rule.most));
    return *number;
  }

  std::pair<double, double> read_range(const Rule& rule, const YAML::Node& value) {
    if (!value.IsSequence() || value.size() != 2) fail(value, "a range is [LEAST, MOST]");
    const double low = read_constant(rule, value[0]), high = read_constant(rule, value[1]);
    if (low > high)
      fail(value, "[" + number_text(low) + ", " + number_text(high) +
                      "] is no range: the smaller number comes first");
    return {low, high};
  }

  Distribution read_number(const Rule& rule, const YAML::Node& value) {
    Distribution result;
    result.least = rule.least;
    result.most = rule.most;
    if (value.IsScalar()) {
      result.low = read_constant(rule, value);
      return result;
    }
    if (value.IsSequence()) {
      std::tie(result.low, result.high) = read_range(rule, value);
      result.kind = std::string_view(rule.name) == "elevation_deg" ? Distribution::Kind::elevation
                                                                   : Distribution::Kind::uniform;
      return result;
    }
    if (!value.IsMap() || value.size() != 1) fail(value, kForms);
    const std::string kind = value.begin()->first.IsScalar() ? value.begin()->first.Scalar() : std::string();
    const YAML::Node of = value.begin()->second;
    if (kind == "uniform" || kind == "log") {
      std::tie(result.low, result.high) = read_range(rule, of);
      result.kind = kind == "log" ? Distribution::Kind::log_uniform : Distribution::Kind::uniform;
      if (kind == "log" && !(result.low > 0)) fail(of, "log needs numbers above 0");
    } else if (kind == "normal") {
      if (!of.IsSequence() || of.size() != 2) fail(of, "normal is [MEAN, DEVIATION]");
      result.low = read_constant(rule, of[0]);
      Rule deviation = rule;
      deviation.least = 0;
      deviation.most = kFar;
      result.high = read_constant(deviation, of[1]);
      result.kind = Distribution::Kind::normal;
    } else if (kind == "choice") {
      if (!of.IsSequence() || of.size() == 0) fail(of, "choice is a list of numbers");
      for (const auto& each : of) result.choices.push_back(read_constant(rule, each));
      result.kind = Distribution::Kind::choice;
    } else {
      fail(value, kForms);
    }
    return result;
  }

  VectorDistribution read_vector(const Rule& rule, const YAML::Node& value) {
    VectorDistribution result;
    if (value.IsSequence() && value.size() == 3) {
      for (size_t i = 0; i < 3; ++i) result.parts[i] = read_number(rule, value[i]);
      return result;
    }
    const YAML::Node of = value.IsMap() && value.size() == 1 ? value["choice"] : YAML::Node();
    if (!of.IsDefined() || !of.IsSequence() || of.size() == 0)
      fail(value, "needs three values, as in [0, [1, 2], 0], or {choice: [[0, 0, 0], ...]}");
    for (const auto& each : of) {
      if (!each.IsSequence() || each.size() != 3) fail(each, "a choice here is [A, B, C]");
      glm::dvec3 choice(0);
      for (int i = 0; i < 3; ++i) choice[i] = read_constant(rule, each[static_cast<size_t>(i)]);
      result.choices.push_back(choice);
    }
    return result;
  }

  std::vector<std::string> read_words(const YAML::Node& value) const {
    if (value.IsScalar()) return {value.Scalar()};
    const YAML::Node of = value.IsMap() && value.size() == 1 ? value["choice"] : YAML::Node();
    if (!of.IsDefined() || !of.IsSequence() || of.size() == 0)
      fail(value, "needs a text, or {choice: [A, B]}");
    std::vector<std::string> words;
    for (const auto& each : of) {
      if (!each.IsScalar()) fail(each, "a choice here is a text");
      words.push_back(each.Scalar());
    }
    return words;
  }

  void read_files(const YAML::Node& value, Field& field) const {
    if (value.IsMap() && value.size() == 1 && value["folder"].IsDefined()) {
      if (!value["folder"].IsScalar() || value["folder"].Scalar().empty()) fail(value, "name a folder");
      field.folder = value["folder"].Scalar();
      return;
    }
    if (value.IsMap() && value.size() == 1 && !value["choice"].IsDefined())
      fail(value, "needs a file, {choice: [A, B]}, or {folder: DIR}");
    field.words = read_words(value);
    if (field.words.size() > kMaxPlanFiles)
      fail(value, "names more than " + std::to_string(kMaxPlanFiles) + " files");
    for (const std::string& word : field.words) {
      if (word.empty()) fail(value, "name a file");
    }
  }

  static constexpr const char* kForms =
      "needs a number, a range [LEAST, MOST], or one of {uniform: [LEAST, MOST]}, {log: [LEAST, MOST]}, "
      "{normal: [MEAN, DEVIATION]}, {choice: [A, B, ...]}";

  std::string file_;
  Plan& plan_;
  std::string field_;
  size_t numbers_ = 0;
};

}  // namespace

const char* name_of(Section section) {
  return kNames[static_cast<size_t>(section)];
}

bool matches(std::string_view pattern, std::string_view text) {
  size_t at = 0, star = std::string_view::npos, resume = 0, p = 0;
  while (at < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = at;
    } else if (p < pattern.size() && pattern[p] == text[at]) {
      ++p;
      ++at;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      at = ++resume;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

namespace {

// True if a word of the line begins with * outside of quotes.
bool has_bare_star(const std::string& text, int line) {
  size_t begin = 0;
  for (; line > 0 && begin != std::string::npos; --line) {
    begin = text.find('\n', begin);
    if (begin != std::string::npos) ++begin;
  }
  if (begin == std::string::npos) return false;
  char quote = 0, before = ' ';
  for (size_t at = begin; at < text.size() && text[at] != '\n'; ++at) {
    const char c = text[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '#' && before == ' ') {
      return false;
    } else if (c == '*' && std::string_view(" {[,:").find(before) != std::string_view::npos) {
      return true;
    }
    before = c;
  }
  return false;
}

}  // namespace

Result<Plan> parse_plan(const std::string& text, const std::string& file) {
  const std::string name = printable_text(file, 1000);
  Plan plan;
  plan.file = name;
  plan.text = text;
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsDefined() || root.IsNull())
      return Error{name + ": the file is empty: see docs/randomization.md"};
    Parser(name, plan).read(root);
  } catch (const Fault& fault) {
    return Error{fault.what()};
  } catch (const YAML::Exception& fault) {
    const std::string line = fault.mark.is_null() ? "" : ":" + std::to_string(fault.mark.line + 1);
    if (!fault.mark.is_null() && has_bare_star(text, fault.mark.line))
      return Error{
          name + line +
          ": a name with * stands in quotes, as in \"*\": or \"*_screw\": (YAML has another use of *)"};
    return Error{name + line + ": cannot be read as YAML: " + printable_text(fault.msg, 200)};
  }
  return plan;
}

namespace {

// Names of the folder's files with one of these endings, sorted, so that all machines draw from one list.
Result<std::vector<std::string>> list_folder(const std::filesystem::path& root, const std::string& folder,
                                             std::span<const std::string_view> endings) {
  std::vector<std::string> names;
  std::error_code fault;
  for (std::filesystem::directory_iterator at(root / folder, fault), end; !fault && at != end;
       at.increment(fault)) {
    const std::string ending = lower_extension(at->path());
    if (std::find(endings.begin(), endings.end(), ending) == endings.end()) continue;
    names.push_back((std::filesystem::path(folder) / at->path().filename()).string());
    if (names.size() > kMaxPlanFiles)
      return Error{quote(folder) + " has more than " + std::to_string(kMaxPlanFiles) + " files"};
  }
  if (fault) return Error{"the folder " + quote(folder) + " cannot be read: " + fault.message()};
  if (names.empty()) {
    std::string known;
    for (const std::string_view each : endings) known += (known.empty() ? "" : ", ") + std::string(each);
    return Error{"the folder " + quote(folder) + " has no file that ends with " + known};
  }
  std::sort(names.begin(), names.end());
  return names;
}

// Resolves a folder, and adds the digests of the files.
Result<void> find_files(const Plan& plan, const std::filesystem::path& root, const std::string& title,
                        std::span<const std::string_view> endings, Field& field,
                        std::map<std::string, Plan::Input, std::less<>>& inputs) {
  const std::string at = plan.file + ":" + std::to_string(field.line) + ": " + title + ": ";
  if (!field.folder.empty()) {
    auto names = list_folder(root, field.folder, endings);
    if (!names) return Error{at + names.error().message};
    field.words = std::move(*names);
  }
  for (const std::string& word : field.words) {
    if (inputs.contains(word)) continue;
    const std::filesystem::path path = root / word;
    if (std::find(endings.begin(), endings.end(), lower_extension(path)) == endings.end())
      return Error{at + quote(word) + " is of no kind that can be read here: see docs/randomization.md"};
    auto digest = digest_of_file(path, kMaxMapBytes);
    if (!digest) return Error{at + digest.error().message};
    inputs[word] = {path, hex(*digest).substr(0, 32)};
    if (inputs.size() > kMaxPlanFiles)
      return Error{at + "the file names more than " + std::to_string(kMaxPlanFiles) + " others"};
  }
  return {};
}

}  // namespace

Result<Plan> read_plan(const std::filesystem::path& file) {
  auto bytes = read_whole_file(file, kMaxPlanBytes);
  if (!bytes) return bytes.error();
  auto plan = parse_plan(std::string(bytes->begin(), bytes->end()), file.string());
  if (!plan) return plan;
  for (const Entry& entry : plan->of(Section::cameras)) {
    const Field* const path = entry.find("path");
    if (!path || plan->paths.contains(path->words[0])) continue;
    auto trajectory = read_trajectory(file.parent_path() / path->words[0]);
    if (!trajectory)
      return Error{plan->file + ":" + std::to_string(path->line) + ": path: " + trajectory.error().message};
    plan->paths.emplace(path->words[0], std::move(*trajectory));
  }
  for (const Entry& entry : plan->of(Section::environment)) {
    const Field* const maps = entry.find("map");
    for (size_t i = 0; maps && i < maps->words.size(); ++i) {
      const std::filesystem::path map = file.parent_path() / maps->words[i];
      auto digest = digest_of_file(map, kMaxMapBytes);
      if (!digest)
        return Error{plan->file + ":" + std::to_string(maps->line) +
                     ": environment.map: " + digest.error().message};
      plan->maps[maps->words[i]] = {map, hex(*digest).substr(0, 32)};
    }
  }
  for (Entry& entry : plan->entries[static_cast<size_t>(Section::materials)]) {
    for (const char* name : kTextureFields) {
      const auto field = entry.fields.find(name);
      if (field == entry.fields.end()) continue;
      auto found = find_files(*plan, file.parent_path(), "materials." + entry.pattern + "." + name, kImages,
                              field->second, plan->textures);
      if (!found) return found.error();
    }
  }
  for (Entry& entry : plan->entries[static_cast<size_t>(Section::distractors)]) {
    auto found = find_files(*plan, file.parent_path(), "distractors.files", kAssets, entry.fields.at("files"),
                            plan->distractors);
    if (!found) return found.error();
  }
  return plan;
}

}  // namespace fire3dv::dataset
