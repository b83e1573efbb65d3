#include "convert/xacro/expression/methods.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <set>
#include <string_view>
#include <utility>

#include "convert/xacro/expression/expression.h"
#include "convert/xacro/expression/functions.h"

namespace fire3dv::convert::xacro {
namespace {

constexpr std::string_view kSpace = " \t\r\n\f\v";
const std::set<std::string> kTextMethods = {"lower",   "upper", "strip", "lstrip",     "rstrip",
                                            "split",   "join",  "find",  "startswith", "endswith",
                                            "replace", "count", "title", "isdigit",    "capitalize"};
const std::set<std::string> kDictMethods = {"keys", "values", "items", "get"};
const std::set<std::string> kListMethods = {"index", "count"};

const std::string& text_at(const std::vector<Value>& arguments, size_t at, const std::string& name) {
  const std::string* text = at < arguments.size() ? arguments[at].as<std::string>() : nullptr;
  if (!text) throw Failure(name + "() needs a str as its argument " + std::to_string(at + 1));
  return *text;
}

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
}
char upper(char c) {
  return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
}

std::string stripped(std::string text, std::string_view characters, const std::string& name) {
  if (name != "rstrip") text.erase(0, std::min(text.find_first_not_of(characters), text.size()));
  if (name != "lstrip") text.erase(text.find_last_not_of(characters) + 1);
  return text;
}

Value split(const std::string& text, const std::vector<Value>& arguments, Budget& budget) {
  std::vector<Value> parts;
  size_t most = SIZE_MAX;
  if (arguments.size() > 1 && integer(arguments[1], "split()") >= 0)
    most = static_cast<size_t>(integer(arguments[1], "split()"));
  budget.bytes(text.size() * sizeof(Value));
  if (arguments.empty() || arguments[0].is_none()) {
    for (size_t at = text.find_first_not_of(kSpace); at != std::string::npos;) {
      size_t end = parts.size() < most ? text.find_first_of(kSpace, at) : std::string::npos;
      parts.emplace_back(text.substr(at, end - at));
      at = text.find_first_not_of(kSpace, end);
    }
    return make_sequence(std::move(parts), false, budget);
  }
  const std::string separator = text_at(arguments, 0, "split");
  if (separator.empty()) throw Failure("split() by an empty text");
  size_t at = 0;
  for (size_t end = text.find(separator); end != std::string::npos && parts.size() < most;
       end = text.find(separator, at)) {
    parts.emplace_back(text.substr(at, end - at));
    at = end + separator.size();
  }
  parts.emplace_back(text.substr(at));
  return make_sequence(std::move(parts), false, budget);
}

std::string replaced(const std::string& text, const std::string& from, const std::string& to,
                     Budget& budget) {
  if (from.empty()) throw Failure("replace() of an empty text");
  std::string result;
  size_t at = 0;
  for (size_t end = text.find(from); end != std::string::npos; end = text.find(from, at)) {
    budget.bytes(end - at + to.size());
    result += text.substr(at, end - at) + to;
    at = end + from.size();
  }
  return result + text.substr(at);
}

Value text_method(const std::string& text, const std::string& name, const std::vector<Value>& arguments,
                  Budget& budget) {
  budget.bytes(text.size());
  std::string result = text;
  if (name == "lower" || name == "upper") {
    std::transform(text.begin(), text.end(), result.begin(), name == "lower" ? lower : upper);
    return result;
  }
  if (name == "title" || name == "capitalize") {
    bool first = true;
    for (char& c : result) {
      c = first ? upper(c) : lower(c);
      first = name == "title" && lower(c) == upper(c);
    }
    return result;
  }
  if (name == "isdigit")
    return !text.empty() &&
           std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (name.ends_with("strip"))
    return stripped(std::move(result),
                    arguments.empty() ? kSpace : std::string_view(text_at(arguments, 0, name)), name);
  if (name == "split") return split(text, arguments, budget);
  if (name == "startswith") return text.starts_with(text_at(arguments, 0, name));
  if (name == "endswith") return text.ends_with(text_at(arguments, 0, name));
  if (name == "replace")
    return replaced(text, text_at(arguments, 0, name), text_at(arguments, 1, name), budget);
  if (name == "find") {
    const size_t at = text.find(text_at(arguments, 0, name));
    return at == std::string::npos ? int64_t{-1} : static_cast<int64_t>(at);
  }
  if (name == "count") {
    const std::string part = text_at(arguments, 0, name);
    if (part.empty()) return static_cast<int64_t>(text.size() + 1);
    int64_t count = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size()))
      ++count;
    return count;
  }
  // join
  const Sequence* parts = arguments.size() == 1 ? arguments[0].sequence() : nullptr;
  if (!parts) throw Failure("join() needs a list");
  result.clear();
  for (size_t i = 0; i < parts->items.size(); ++i) {
    const std::string part = text_at(parts->items, i, name);
    budget.bytes(part.size() + text.size());
    result += (i > 0 ? text : "") + part;
  }
  return result;
}

// One % directive: flags, width and precision from `form`, which begins with %.
std::string formatted_one(std::string form, char kind, const Value& value, Budget& budget) {
  char buffer[512];
  if (kind == 's' || kind == 'r') {
    const std::string text = kind == 's' ? text_of(value, budget) : repr_of(value, budget);
    if (form == "%") return text;
    const size_t size =
        static_cast<size_t>(std::snprintf(buffer, sizeof buffer, (form + "s").c_str(), text.c_str()));
    return {buffer, std::min(size, sizeof buffer - 1)};
  }
  int size = 0;
  if (kind == 'd' || kind == 'i' || kind == 'u' || kind == 'x' || kind == 'X' || kind == 'o') {
    const int64_t whole = value.as<double>()
                              ? static_cast<int64_t>(std::clamp(*value.as<double>(), -9.2e18, 9.2e18))
                              : integer(value, "%d");
    const char conversion = kind == 'u' || kind == 'i' ? 'd' : kind;
    size = std::snprintf(buffer, sizeof buffer, (form + "ll" + conversion).c_str(),
                         static_cast<long long>(whole));
  } else {
    size = std::snprintf(buffer, sizeof buffer, (form + kind).c_str(), number(value, "%f"));
  }
  return {buffer, std::min(static_cast<size_t>(size), sizeof buffer - 1)};
}

}  // namespace

bool is_method(const Value& object, const std::string& name) {
  return (object.as<std::string>() && kTextMethods.contains(name)) ||
         (object.dict() && kDictMethods.contains(name)) ||
         (object.sequence() && !object.sequence()->is_set && kListMethods.contains(name));
}

Value call_method(const Value& object, const std::string& name, const std::vector<Value>& arguments,
                  Budget& budget) {
  if (const std::string* text = object.as<std::string>()) return text_method(*text, name, arguments, budget);
  if (const Dict* dict = object.dict()) {
    if (name == "get") {
      if (arguments.empty() || arguments.size() > 2) throw Failure("get() takes 1 to 2 arguments");
      if (const Value* value = find(*dict, arguments[0], budget)) return *value;
      return arguments.size() == 2 ? arguments[1] : Value();
    }
    std::vector<Value> items;
    for (const auto& [key, value] : dict->items)
      items.push_back(name == "keys"     ? key
                      : name == "values" ? value
                                         : make_sequence({key, value}, true, budget));
    return make_sequence(std::move(items), false, budget);
  }
  if (arguments.size() != 1) throw Failure(name + "() takes 1 argument");
  int64_t count = 0;
  const std::vector<Value>& items = object.sequence()->items;
  for (size_t i = 0; i < items.size(); ++i) {
    if (!equal(items[i], arguments[0], budget)) continue;
    if (name == "index") return static_cast<int64_t>(i);
    ++count;
  }
  if (name == "index") throw Failure("index() finds no such item");
  return count;
}

Value tokenized(const std::vector<Value>& arguments, Budget& budget) {
  const std::string text = text_at(arguments, 0, "tokenize");
  const std::string separators = arguments.size() > 1 ? text_at(arguments, 1, "tokenize") : ",; ";
  const bool skip_empty = arguments.size() < 3 || is_true(arguments[2]);
  budget.bytes(text.size() * sizeof(Value));
  std::vector<Value> items;
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find_first_of(separators, at), text.size());
    if (end > at || !skip_empty) items.emplace_back(text.substr(at, end - at));
    at = end + 1;
  }
  return make_sequence(std::move(items), false, budget);
}

std::string formatted(const std::string& text, const Value& values, Budget& budget) {
  constexpr size_t kMaxWidth = 100;
  const Sequence* tuple = values.sequence() && values.sequence()->is_tuple ? values.sequence() : nullptr;
  const size_t count = tuple ? tuple->items.size() : 1;
  size_t next = 0;
  std::string result;
  for (size_t at = 0; at < text.size(); ++at) {
    if (text[at] != '%') {
      result += text[at];
      continue;
    }
    size_t end = text.find_first_not_of("+- #0123456789.", at + 1);
    if (end == std::string::npos) throw Failure("a % of the text has no kind, such as %s");
    const std::string form = text.substr(at, end - at);
    const char kind = text[end];
    at = end;
    if (kind == '%') {
      result += '%';
      continue;
    }
    if (std::string_view("srdiuxXofFeEgG").find(kind) == std::string_view::npos)
      refuse_python(std::string("the format %") + kind);
    for (size_t digit = form.find_first_of("0123456789"); digit != std::string::npos;) {
      const size_t after = std::min(form.find_first_not_of("0123456789", digit), form.size());
      int64_t width = 0;
      if (!parse_integer(std::string_view(form).substr(digit, after - digit), width) ||
          width > static_cast<int64_t>(kMaxWidth))
        throw Failure("a width of the format exceeds " + std::to_string(kMaxWidth));
      digit = form.find_first_of("0123456789", after);
    }
    if (std::count(form.begin(), form.end(), '.') > 1) throw Failure("a format has two points");
    if (next >= count) throw Failure("the text formats more values than there are");
    const std::string one = formatted_one(form, kind, tuple ? tuple->items[next] : values, budget);
    ++next;
    budget.bytes(one.size());
    result += one;
  }
  if (next < count) throw Failure("there are more values than the text formats");
  return result;
}

}  // namespace fire3dv::convert::xacro
