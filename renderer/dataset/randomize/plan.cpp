#include "renderer/dataset/randomize/plan.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "base/files.h"
#include "base/numbers.h"
#include "base/text.h"

namespace fire3dv::dataset {
namespace {

constexpr size_t kMaxNumbers = 100'000;  // aliases repeat parts of a file
constexpr const char* kNames[kSections] = {"cameras", "nodes",       "materials",
                                           "lights",  "environment", "background"};

enum class Type : uint8_t { number, vector, chance, place, rotation };

// Field of a section with the limits of its numbers.
struct Rule {
  Section section;
  const char* name;
  Type type;
  double least = 0, most = 0;
};
constexpr double kFar = 1e6;
constexpr Rule kRules[] = {
    {Section::cameras, "look_at", Type::place, -kFar, kFar},
    {Section::cameras, "look_at_offset_m", Type::vector, -kFar, kFar},
    {Section::cameras, "position_m", Type::vector, -kFar, kFar},
    {Section::cameras, "distance_m", Type::number, 1e-6, kFar},
    {Section::cameras, "azimuth_deg", Type::number, -360, 360},
    {Section::cameras, "elevation_deg", Type::number, -90, 90},
    {Section::cameras, "roll_deg", Type::number, -360, 360},
    {Section::cameras, "move_m", Type::vector, -kFar, kFar},
    {Section::cameras, "turn_deg", Type::vector, -360, 360},
    {Section::cameras, "fov_deg", Type::number, 0.1, 170},
    {Section::cameras, "exposure_ev", Type::number, -20, 20},
    {Section::cameras, "noise", Type::number, 0, 255},
    {Section::nodes, "position_m", Type::vector, -kFar, kFar},
    {Section::nodes, "move_m", Type::vector, -kFar, kFar},
    {Section::nodes, "turn_deg", Type::vector, -360, 360},
    {Section::nodes, "rotation", Type::rotation},
    {Section::nodes, "scale", Type::number, 1e-3, 1e3},
    {Section::nodes, "visible", Type::chance, 0, 1},
    {Section::materials, "base_color", Type::vector, 0, 1},
    {Section::materials, "alpha", Type::number, 0, 1},
    {Section::materials, "metallic", Type::number, 0, 1},
    {Section::materials, "roughness", Type::number, 0, 1},
    {Section::materials, "emissive", Type::vector, 0, 1e4},
    {Section::materials, "normal_scale", Type::number, 0, 10},
    {Section::lights, "intensity", Type::number, 0, 1e9},
    {Section::lights, "color", Type::vector, 0, 1},
    {Section::lights, "radius_m", Type::number, 0, 1e3},
    {Section::lights, "on", Type::chance, 0, 1},
    {Section::lights, "look_at", Type::place, -kFar, kFar},
    {Section::lights, "look_at_offset_m", Type::vector, -kFar, kFar},
    {Section::lights, "position_m", Type::vector, -kFar, kFar},
    {Section::lights, "distance_m", Type::number, 1e-6, kFar},
    {Section::lights, "azimuth_deg", Type::number, -360, 360},
    {Section::lights, "elevation_deg", Type::number, -90, 90},
    {Section::environment, "intensity", Type::number, 0, 1e4},
    {Section::environment, "rotation_deg", Type::number, -360, 360},
    {Section::background, "color", Type::vector, 0, 1},
};

bool has_objects(Section section) {
  return section != Section::environment && section != Section::background;
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
      fail(field, "no such field of " + std::string(name_of(section)) + ": there are " + known);
    });
    check(section, entry, value);
    return entry;
  }

  void check(Section section, const Entry& entry, const YAML::Node& at) const {
    const auto has = [&](const char* name) { return entry.find(name) != nullptr; };
    const auto needs = [&](const char* name, const char* other) {
      if (has(name) && !has(other)) fail(at, std::string(name) + " needs " + other);
    };
    const auto excludes = [&](const char* name, const char* other) {
      if (has(name) && has(other)) fail(at, std::string(name) + " and " + other + ": choose one of them");
    };
    for (const char* other : {"look_at", "azimuth_deg", "elevation_deg"}) needs("distance_m", other);
    needs("azimuth_deg", "distance_m");
    needs("elevation_deg", "distance_m");
    needs("look_at_offset_m", "look_at");
    excludes("position_m", "distance_m");
    if (section != Section::nodes) return;
    excludes("position_m", "move_m");
    excludes("rotation", "turn_deg");
  }

  Field read_field(const Rule& rule, const YAML::Node& value) {
    Field field;
    switch (rule.type) {
      case Type::number:
        field.number = read_number(rule, value);
        break;
      case Type::chance:
        field.number.low = read_constant(rule, value);
        break;
      case Type::vector:
        field.vector = read_vector(rule, value);
        break;
      case Type::place:
        if (value.IsScalar())
          field.node = value.Scalar();
        else
          field.vector = read_vector(rule, value);
        if (value.IsScalar() && field.node.empty()) fail(value, "name a node, or write [x, y, z]");
        break;
      case Type::rotation:
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
    return Error{name + line + ": cannot be read as YAML: " + printable_text(fault.msg, 200)};
  }
  return plan;
}

Result<Plan> read_plan(const std::filesystem::path& file) {
  auto bytes = read_whole_file(file, kMaxPlanBytes);
  if (!bytes) return bytes.error();
  return parse_plan(std::string(bytes->begin(), bytes->end()), file.string());
}

}  // namespace fire3dv::dataset
