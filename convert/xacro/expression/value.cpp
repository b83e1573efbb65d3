#include "convert/xacro/expression/value.h"

#include "base/words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>

namespace fire3dv::convert::xacro {
namespace {

constexpr size_t kMaxValueDepth = 50;

size_t depth_of(const Value& value) {
  if (const Sequence* sequence = value.sequence()) return sequence->depth;
  if (const Dict* dict = value.dict()) return dict->depth;
  return 0;
}

size_t deeper(size_t depth, const Value& value) {
  depth = std::max(depth, 1 + depth_of(value));
  if (depth > kMaxValueDepth)
    throw Failure("lists are nested more than " + std::to_string(kMaxValueDepth) + " deep");
  return depth;
}

std::string quoted(const std::string& text) {
  const char mark = text.find('\'') != std::string::npos && text.find('"') == std::string::npos ? '"' : '\'';
  std::string out(1, mark);
  for (const char c : text) {
    if (c == mark || c == '\\') out += '\\';
    if (c == '\n')
      out += "\\n";
    else if (c == '\t')
      out += "\\t";
    else
      out += c;
  }
  return out + mark;
}

}  // namespace

Value make_sequence(std::vector<Value> items, bool is_tuple, Budget& budget) {
  budget.step(items.size());
  budget.bytes(items.size() * sizeof(Value));
  size_t depth = 1;
  for (const Value& item : items) depth = deeper(depth, item);
  return std::make_shared<const Sequence>(Sequence{is_tuple, std::move(items), depth});
}

Value make_set(const std::vector<Value>& items, Budget& budget) {
  Sequence set;
  set.is_set = true;
  std::set<std::string> known;
  for (const Value& item : items) {
    if (item.dict() || (item.sequence() && !item.sequence()->is_tuple))
      throw Failure(std::string("a ") + type_name(item) + " is not an item of a set");
    budget.step();
    if (!known.insert(repr_of(item, budget)).second) continue;
    set.depth = deeper(set.depth, item);
    budget.bytes(sizeof(Value));
    set.items.push_back(item);
  }
  return std::make_shared<const Sequence>(std::move(set));
}

Value make_dict(std::vector<std::pair<Value, Value>> items, Budget& budget) {
  Dict dict;
  for (auto& [key, value] : items) {
    if (key.sequence() || key.dict())
      throw Failure(std::string("a ") + type_name(key) + " is not a key of a dict");
    dict.depth = deeper(dict.depth, value);
    const auto [known, is_new] = dict.index.try_emplace(repr_of(key, budget), dict.items.size());
    budget.bytes(2 * sizeof(Value));
    if (is_new)
      dict.items.emplace_back(std::move(key), std::move(value));
    else
      dict.items[known->second].second = std::move(value);
  }
  return std::make_shared<const Dict>(std::move(dict));
}

const Value* find(const Dict& dict, const Value& key, Budget& budget) {
  const auto known = dict.index.find(repr_of(key, budget));
  return known == dict.index.end() ? nullptr : &dict.items[known->second].second;
}

const char* type_name(const Value& value) {
  if (const Sequence* sequence = value.sequence())
    return sequence->is_tuple ? "tuple" : sequence->is_set ? "set" : "list";
  constexpr const char* kNames[] = {"None", "bool", "int",      "float",  "str",
                                    "list", "dict", "function", "module", "namespace"};
  return kNames[value.data.index()];
}

bool is_true(const Value& value) {
  if (value.is_none()) return false;
  if (const bool* flag = value.as<bool>()) return *flag;
  if (const int64_t* whole = value.as<int64_t>()) return *whole != 0;
  if (const double* real = value.as<double>()) return *real != 0;
  if (const std::string* text = value.as<std::string>()) return !text->empty();
  if (const Sequence* sequence = value.sequence()) return !sequence->items.empty();
  if (const Dict* dict = value.dict()) return !dict->items.empty();
  return true;
}

int64_t integer(const Value& value, std::string_view operation) {
  if (const bool* flag = value.as<bool>()) return *flag ? 1 : 0;
  if (const int64_t* whole = value.as<int64_t>()) return *whole;
  throw Failure(std::string(operation) + " needs an integer, not a " + type_name(value));
}

double number(const Value& value, std::string_view operation) {
  if (const double* real = value.as<double>()) return *real;
  if (value.is_integer()) return static_cast<double>(integer(value, operation));
  throw Failure(std::string(operation) + " needs a number, not a " + type_name(value));
}

// The shortest decimal number that reads as the same value, laid out as Python does.
std::string text_of(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value < 0 ? "-inf" : "inf";
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::scientific).ptr;
  std::string_view shortest(buffer, static_cast<size_t>(end - buffer));
  const bool negative = shortest.starts_with('-');
  if (negative) shortest.remove_prefix(1);
  const size_t e = shortest.find('e');
  const int exponent = std::atoi(std::string(shortest.substr(e + 1)).c_str());
  std::string digits(shortest.substr(0, e));
  std::erase(digits, '.');
  std::string text;
  const auto count = static_cast<int>(digits.size());
  if (exponent < -4 || exponent >= 16) {
    text = digits.substr(0, 1) + (count > 1 ? "." + digits.substr(1) : "") + (exponent < 0 ? "e-" : "e+");
    const std::string magnitude = std::to_string(std::abs(exponent));
    text += magnitude.size() < 2 ? "0" + magnitude : magnitude;
  } else if (exponent < 0) {
    text = "0." + std::string(static_cast<size_t>(-exponent - 1), '0') + digits;
  } else if (count <= exponent + 1) {
    text = digits + std::string(static_cast<size_t>(exponent + 1 - count), '0') + ".0";
  } else {
    text = digits.substr(0, static_cast<size_t>(exponent) + 1) + "." +
           digits.substr(static_cast<size_t>(exponent) + 1);
  }
  return negative ? "-" + text : text;
}

std::string text_of(const Value& value, Budget& budget) {
  if (const std::string* text = value.as<std::string>()) {
    budget.bytes(text->size());
    return *text;
  }
  return repr_of(value, budget);
}

std::string repr_of(const Value& value, Budget& budget) {
  budget.step();
  if (value.is_none()) return "None";
  if (const bool* flag = value.as<bool>()) return *flag ? "True" : "False";
  if (const int64_t* whole = value.as<int64_t>()) return std::to_string(*whole);
  if (const double* real = value.as<double>()) return text_of(*real);
  if (const std::string* text = value.as<std::string>()) {
    budget.bytes(text->size());
    return quoted(*text);
  }
  std::string out;
  if (const Sequence* sequence = value.sequence()) {
    for (const Value& item : sequence->items) out += (out.empty() ? "" : ", ") + repr_of(item, budget);
    if (sequence->is_tuple) return "(" + out + (sequence->items.size() == 1 ? ",)" : ")");
    budget.bytes(out.size());
    if (sequence->is_set) return out.empty() ? "set()" : "{" + out + "}";
    return "[" + out + "]";
  }
  if (const Dict* dict = value.dict()) {
    for (const auto& [key, item] : dict->items)
      out += (out.empty() ? "" : ", ") + repr_of(key, budget) + ": " + repr_of(item, budget);
    budget.bytes(out.size());
    return "{" + out + "}";
  }
  throw Failure(std::string("a ") + type_name(value) + " has no text");
}

bool equal(const Value& a, const Value& b, Budget& budget) {
  budget.step();
  if (a.is_number() && b.is_number()) {
    if (a.is_integer() && b.is_integer()) return integer(a, "==") == integer(b, "==");
    return number(a, "==") == number(b, "==");
  }
  if (a.data.index() != b.data.index()) return false;
  if (const std::string* text = a.as<std::string>()) return *text == *b.as<std::string>();
  if (const Sequence* x = a.sequence()) {
    const Sequence* y = b.sequence();
    if (x->is_tuple != y->is_tuple || x->is_set != y->is_set || x->items.size() != y->items.size())
      return false;
    if (x->is_set)
      return std::all_of(x->items.begin(), x->items.end(), [&](const Value& item) {
        return std::any_of(y->items.begin(), y->items.end(),
                           [&](const Value& other) { return equal(item, other, budget); });
      });
    for (size_t i = 0; i < x->items.size(); ++i)
      if (!equal(x->items[i], y->items[i], budget)) return false;
    return true;
  }
  if (const Dict* x = a.dict()) {
    const Dict* y = b.dict();
    if (x->items.size() != y->items.size()) return false;
    for (const auto& [key, item] : x->items) {
      const Value* other = find(*y, key, budget);
      if (!other || !equal(item, *other, budget)) return false;
    }
    return true;
  }
  return a.is_none();
}

std::partial_ordering compare(const Value& a, const Value& b, Budget& budget) {
  budget.step();
  if (a.is_integer() && b.is_integer()) return integer(a, "<") <=> integer(b, "<");
  if (a.is_number() && b.is_number()) return number(a, "<") <=> number(b, "<");
  if (a.as<std::string>() && b.as<std::string>()) return *a.as<std::string>() <=> *b.as<std::string>();
  const Sequence *x = a.sequence(), *y = b.sequence();
  if (!x || !y || x->is_tuple != y->is_tuple || x->is_set || y->is_set)
    throw Failure(std::string("a ") + type_name(a) + " and a " + type_name(b) + " have no order");
  for (size_t i = 0; i < std::min(x->items.size(), y->items.size()); ++i)
    if (!equal(x->items[i], y->items[i], budget)) return compare(x->items[i], y->items[i], budget);
  return x->items.size() <=> y->items.size();
}

bool parse_integer(std::string_view text, int64_t& value, int base) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || text.starts_with('+')) return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return error == std::errc() && end == text.data() + text.size();
}

bool parse_float(std::string_view text, double& value) {
  text = trimmed(text);
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  if (text.empty()) return false;
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  const double sign = negative ? -1 : 1;
  if (lower == "inf" || lower == "infinity" || lower == "nan") {
    value = lower == "nan" ? std::numeric_limits<double>::quiet_NaN()
                           : sign * std::numeric_limits<double>::infinity();
    return true;
  }
  if (!(text[0] == '.' || (text[0] >= '0' && text[0] <= '9'))) return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return false;
  if (error == std::errc::result_out_of_range) value = std::strtod(lower.c_str(), nullptr);  // 0 or infinity
  value *= sign;
  return error == std::errc() || error == std::errc::result_out_of_range;
}

Value literal(std::string text) {
  if (text.size() >= 2 && text.front() == '\'' && text.back() == '\'') return text.substr(1, text.size() - 2);
  if (text.find('_') != std::string::npos) return text;
  int64_t whole = 0;
  if (parse_integer(text, whole)) return whole;
  double real = 0;
  if (parse_float(text, real)) return real;
  if (text == "true" || text == "True") return true;
  if (text == "false" || text == "False") return false;
  return text;
}

}  // namespace fire3dv::convert::xacro
