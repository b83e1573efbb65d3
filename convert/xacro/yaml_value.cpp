#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <numbers>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "convert/model.h"
#include "convert/xacro/substitution.h"

namespace fire3dv::convert::xacro {
namespace {

const std::map<std::string, double> kUnits = {{"!radians", 1.0}, {"!degrees", std::numbers::pi / 180},
                                              {"!meters", 1.0},  {"!millimeters", 0.001},
                                              {"!foot", 0.3048}, {"!inches", 0.0254}};

// Plain scalars by the rules of YAML 1.1, as PyYAML has them: a float needs a point, yes and on are true.
Value plain_scalar(const std::string& text) {
  if (text.empty() || text == "~" || text == "null" || text == "Null" || text == "NULL") return {};
  std::string lower = text;
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  const bool is_uniform = text == lower || std::none_of(text.begin() + 1, text.end(), [&](char c) {
                            return (c >= 'A' && c <= 'Z') != (text[1] >= 'A' && text[1] <= 'Z');
                          });
  if (is_uniform && (lower == "true" || lower == "yes" || lower == "on")) return true;
  if (is_uniform && (lower == "false" || lower == "no" || lower == "off")) return false;
  std::string digits = text;
  std::erase(digits, '_');
  int64_t whole = 0;
  const bool negative = digits.starts_with('-');
  const std::string_view magnitude =
      std::string_view(digits).substr(negative || digits.starts_with('+') ? 1 : 0);
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (magnitude.empty()) return text;
  if (magnitude.starts_with("0x") && parse_integer(magnitude.substr(2), whole, 16))
    return negative ? -whole : whole;
  if (magnitude.size() > 1 && magnitude[0] == '0' &&
      std::all_of(magnitude.begin(), magnitude.end(), is_digit)) {
    if (parse_integer(magnitude, whole, 8)) return negative ? -whole : whole;
    return text;
  }
  if (std::all_of(magnitude.begin(), magnitude.end(), is_digit) && parse_integer(digits, whole)) return whole;
  if (lower == ".inf" || lower == "+.inf" || lower == "-.inf" || lower == ".nan") {
    double value = 0;
    std::erase(lower, '.');
    parse_float(lower, value);
    return value;
  }
  const size_t e = magnitude.find_first_of("eE");
  const bool has_point = magnitude.find('.') < e;
  const bool has_sign = e != std::string_view::npos && e + 1 < magnitude.size() &&
                        (magnitude[e + 1] == '+' || magnitude[e + 1] == '-');
  double value = 0;
  if (has_point && (e == std::string_view::npos || has_sign) && parse_float(digits, value)) return value;
  return text;
}

class YamlReader {
 public:
  YamlReader(Environment& environment, Budget& budget) : environment_(environment), budget_(budget) {}

  Value value_of(const YAML::Node& node) {
    const Budget::Level level(budget_);
    budget_.step();
    if (!node.IsDefined() || node.IsNull()) return {};
    if (node.IsScalar()) return scalar(node);
    if (node.IsSequence()) {
      std::vector<Value> items;
      for (const YAML::Node& item : node) items.push_back(value_of(item));
      return make_sequence(std::move(items), false, budget_);
    }
    std::vector<std::pair<Value, Value>> items, merged;
    for (const auto& entry : node) {
      if (entry.first.IsScalar() && entry.first.Scalar() == "<<" && entry.first.Tag() != "!")
        merge(value_of(entry.second), merged);
      else
        items.emplace_back(value_of(entry.first), value_of(entry.second));
    }
    merged.insert(merged.end(), items.begin(), items.end());
    return make_dict(std::move(merged), budget_);
  }

 private:
  static void merge(const Value& value, std::vector<std::pair<Value, Value>>& items) {
    if (const Dict* dict = value.dict()) items.insert(items.end(), dict->items.begin(), dict->items.end());
    if (const Sequence* sequence = value.sequence())  // earlier ones count
      for (auto item = sequence->items.rbegin(); item != sequence->items.rend(); ++item)
        if (const Dict* dict = item->dict())
          items.insert(items.end(), dict->items.begin(), dict->items.end());
  }

  Value scalar(const YAML::Node& node) {
    const std::string& text = node.Scalar();
    budget_.bytes(text.size());
    if (const auto unit = kUnits.find(node.Tag()); unit != kUnits.end()) {
      const Value value = evaluate(*parse_expression(text), environment_, budget_);
      const std::string* quoted = value.as<std::string>();
      double parsed = 0;
      if (quoted && !parse_float(*quoted, parsed)) throw Failure(node.Tag() + " needs a number");
      return (quoted ? parsed : number(value, node.Tag())) * unit->second;
    }
    // Quoted scalars have the tag "!" and stay text.
    if (node.Tag() == "!" || node.Tag() == "tag:yaml.org,2002:str") return text;
    return plain_scalar(text);
  }

  Environment& environment_;
  Budget& budget_;
};

}  // namespace

Value value_of_yaml(const std::string& text, const std::string& file, Environment& environment,
                    Budget& budget) {
  const std::string name = quote(file);
  try {
    return YamlReader(environment, budget).value_of(YAML::Load(text));
  } catch (const YAML::Exception& fault) {
    const std::string line = fault.mark.is_null() ? "" : ", line " + std::to_string(fault.mark.line + 1);
    throw Failure(name + line + " cannot be read as YAML: " + sanitize_text(fault.msg, 200));
  }
}

}  // namespace fire3dv::convert::xacro
