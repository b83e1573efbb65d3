#include "convert/xacro/expression/functions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <utility>

#include "convert/xacro/expression/math_functions.h"
#include "convert/xacro/expression/methods.h"

namespace fire3dv::convert::xacro {
namespace {

using Arguments = std::vector<Value>;

const std::set<std::string> kPython = {"list", "dict",      "map",        "len",   "str",     "float",
                                       "int",  "min",       "max",        "round", "range",   "abs",
                                       "all",  "any",       "sum",        "bool",  "sorted",  "tuple",
                                       "zip",  "enumerate", "isinstance", "repr",  "reversed"};
const std::set<std::string> kXacro = {"load_yaml", "abs_filename", "dotify", "arg",   "tokenize",
                                      "message",   "warning",      "error",  "fatal", "print_location"};

// Items of a list, tuple, dict (its keys) or str (its characters).
std::vector<Value> items_of(const Value& value, Budget& budget) {
  std::vector<Value> items;
  if (const Sequence* sequence = value.sequence()) {
    items = sequence->items;
  } else if (const Dict* dict = value.dict()) {
    for (const auto& [key, item] : dict->items) items.push_back(key);
  } else if (const std::string* text = value.as<std::string>()) {
    for (const char c : *text) items.emplace_back(std::string(1, c));
  } else {
    throw Failure(std::string("a ") + type_name(value) + " has no items");
  }
  budget.step(items.size());
  budget.bytes(items.size() * sizeof(Value));
  return items;
}

Value to_integer(const Arguments& arguments) {
  expect_count(arguments, 0, 2, "int");
  if (arguments.empty()) return int64_t{0};
  if (const double* real = arguments[0].as<double>()) return whole_number(std::trunc(*real), "int");
  if (const std::string* text = arguments[0].as<std::string>()) {
    int64_t value = 0;
    const int64_t base = arguments.size() == 2 ? integer(arguments[1], "int()") : 10;
    if (base < 2 || base > 36 || !parse_integer(*text, value, static_cast<int>(base)))
      throw Failure("int() finds no integer in '" + text->substr(0, 60) + "'");
    return value;
  }
  return integer(arguments[0], "int()");
}

Value to_float(const Arguments& arguments) {
  expect_count(arguments, 0, 1, "float");
  if (arguments.empty()) return 0.0;
  if (const std::string* text = arguments[0].as<std::string>()) {
    double value = 0;
    if (!parse_float(*text, value)) throw Failure("float() finds no number in '" + text->substr(0, 60) + "'");
    return value;
  }
  return number(arguments[0], "float()");
}

Value rounded(const Arguments& arguments) {
  expect_count(arguments, 1, 2, "round");
  const bool to_whole = arguments.size() == 1 || arguments[1].is_none();
  if (arguments[0].is_integer() && to_whole) return integer(arguments[0], "round()");
  const double value = number(arguments[0], "round()");
  if (to_whole) return whole_number(std::nearbyint(value), "round");  // to even, as Python
  const int64_t digits = integer(arguments[1], "round()");
  if (arguments[0].is_integer() && digits >= 0) return integer(arguments[0], "round()");
  if (digits > 30 || digits < -30 || !std::isfinite(value)) return value;
  if (digits < 0) {
    const double unit = std::pow(10, -static_cast<double>(digits));
    const double result = std::nearbyint(value / unit) * unit;
    return arguments[0].is_integer() ? whole_number(result, "round") : Value(result);
  }
  char text[400];
  std::snprintf(text, sizeof text, "%.*f", static_cast<int>(digits),
                value);  // rounds the exact decimal value
  return std::strtod(text, nullptr);
}

Value extreme(const std::string& name, const Arguments& arguments, Budget& budget) {
  const std::vector<Value> items = arguments.size() == 1 ? items_of(arguments[0], budget) : arguments;
  if (items.empty()) throw Failure(name + "() of nothing");
  const Value* best = &items[0];
  for (const Value& item : items) {
    const std::partial_ordering order = compare(item, *best, budget);
    if (name == "min" ? order < 0 : order > 0) best = &item;
  }
  return *best;
}

Value range(const Arguments& arguments, Budget& budget) {
  expect_count(arguments, 1, 3, "range");
  int64_t first = 0, last = integer(arguments[0], "range()"), step = 1;
  if (arguments.size() > 1) {
    first = last;
    last = integer(arguments[1], "range()");
  }
  if (arguments.size() > 2) step = integer(arguments[2], "range()");
  if (step == 0) throw Failure("range() with the step 0");
  std::vector<Value> items;
  for (int64_t i = first; step > 0 ? i < last : i > last;) {
    budget.step();
    budget.bytes(sizeof(Value));
    items.emplace_back(i);
    if (__builtin_add_overflow(i, step, &i)) break;
  }
  return make_sequence(std::move(items), false, budget);
}

Value to_dict(const Arguments& arguments, const std::vector<std::string>& keywords, Budget& budget) {
  std::vector<std::pair<Value, Value>> items;
  const size_t positional = arguments.size() - keywords.size();
  if (positional > 1) throw Failure("dict() takes at most one argument without a name");
  if (positional == 1) {
    if (const Dict* dict = arguments[0].dict()) {
      items = dict->items;
    } else {
      for (const Value& item : items_of(arguments[0], budget)) {
        const Sequence* pair = item.sequence();
        if (!pair || pair->items.size() != 2) throw Failure("dict() needs pairs of key and value");
        items.emplace_back(pair->items[0], pair->items[1]);
      }
    }
  }
  for (size_t i = 0; i < keywords.size(); ++i) items.emplace_back(keywords[i], arguments[positional + i]);
  budget.step(items.size());
  return make_dict(std::move(items), budget);
}

bool is_instance(const Value& value, const Value& type, Budget& budget) {
  if (const Sequence* types = type.sequence())
    return std::any_of(types->items.begin(), types->items.end(),
                       [&](const Value& one) { return is_instance(value, one, budget); });
  budget.step();
  const Function* named = type.as<Function>();
  if (!named) throw Failure("isinstance() needs a type");
  return type_name(value) == named->name || (named->name == "int" && value.as<bool>());
}

Value python(const std::string& name, Arguments arguments, const std::vector<std::string>& keywords,
             Environment& environment, Budget& budget) {
  if (name == "dict") return to_dict(arguments, keywords, budget);
  if (!keywords.empty()) refuse_python("an argument with a name in " + name + "()");
  if (name == "int") return to_integer(arguments);
  if (name == "float") return to_float(arguments);
  if (name == "round") return rounded(arguments);
  if (name == "range") return range(arguments, budget);
  if (name == "list" || name == "tuple") {
    expect_count(arguments, 0, 1, name);
    return make_sequence(arguments.empty() ? std::vector<Value>() : items_of(arguments[0], budget),
                         name == "tuple", budget);
  }
  if (name == "set" || name == "frozenset") {
    expect_count(arguments, 0, 1, name);
    return make_set(arguments.empty() ? std::vector<Value>() : items_of(arguments[0], budget), budget);
  }
  if (name == "min" || name == "max") return extreme(name, arguments, budget);
  if (name == "map" || name == "isinstance") expect_count(arguments, 2, 2, name);
  if (name == "map") {
    if (!arguments[0].as<Function>()) throw Failure("map() needs a function");
    std::vector<Value> items = items_of(arguments[1], budget);
    for (Value& item : items)
      item = call_function(*arguments[0].as<Function>(), {item}, {}, environment, budget);
    return make_sequence(std::move(items), false, budget);
  }
  if (name == "isinstance") return is_instance(arguments[0], arguments[1], budget);
  if (name == "zip") {
    std::vector<std::vector<Value>> columns;
    size_t rows = arguments.empty() ? 0 : SIZE_MAX;
    for (const Value& argument : arguments) {
      columns.push_back(items_of(argument, budget));
      rows = std::min(rows, columns.back().size());
    }
    std::vector<Value> items;
    for (size_t row = 0; row < rows; ++row) {
      std::vector<Value> one;
      for (const std::vector<Value>& column : columns) one.push_back(column[row]);
      items.push_back(make_sequence(std::move(one), true, budget));
    }
    return make_sequence(std::move(items), false, budget);
  }
  expect_count(arguments, name == "str" || name == "bool" ? 0 : 1, 1, name);
  if (arguments.empty()) return name == "str" ? Value("") : Value(false);
  const Value& value = arguments[0];
  if (name == "str") return text_of(value, budget);
  if (name == "repr") return repr_of(value, budget);
  if (name == "bool") return is_true(value);
  if (name == "abs") {
    if (const double* real = value.as<double>()) return std::abs(*real);
    return integer(value, "abs()") < 0 ? apply_operator("-", int64_t{0}, value, budget) : value;
  }
  if (name == "len" && value.as<std::string>()) return static_cast<int64_t>(value.as<std::string>()->size());
  std::vector<Value> items = items_of(value, budget);
  if (name == "len") return static_cast<int64_t>(items.size());
  if (name == "all") return std::all_of(items.begin(), items.end(), is_true);
  if (name == "any") return std::any_of(items.begin(), items.end(), is_true);
  if (name == "sum") {
    Value sum = int64_t{0};
    for (const Value& item : items) sum = apply_operator("+", sum, item, budget);
    return sum;
  }
  if (name == "enumerate") {
    for (size_t i = 0; i < items.size(); ++i)
      items[i] = make_sequence({static_cast<int64_t>(i), items[i]}, true, budget);
  } else if (name == "reversed") {
    std::reverse(items.begin(), items.end());
  } else {  // sorted
    std::stable_sort(items.begin(), items.end(),
                     [&](const Value& a, const Value& b) { return compare(a, b, budget) < 0; });
  }
  return make_sequence(std::move(items), false, budget);
}

std::string text_argument(const Arguments& arguments, const std::string& name) {
  expect_count(arguments, 1, 1, name);
  const std::string* text = arguments[0].as<std::string>();
  if (!text) throw Failure(name + "() needs a str, not a " + type_name(arguments[0]));
  return *text;
}

Value xacro_function(const std::string& name, const Arguments& arguments, Environment& environment,
                     Budget& budget) {
  if (name == "load_yaml") return environment.load_yaml(text_argument(arguments, name));
  if (name == "abs_filename") return environment.absolute_path(text_argument(arguments, name));
  if (name == "arg") return environment.argument(text_argument(arguments, name));
  if (name == "print_location") return "";
  if (name == "dotify") {
    expect_count(arguments, 1, 1, name);
    return arguments[0];
  }
  if (name == "tokenize") {
    expect_count(arguments, 1, 3, name);
    return tokenized(arguments, budget);
  }
  std::string text;
  for (const Value& argument : arguments) text += (text.empty() ? "" : " ") + text_of(argument, budget);
  if (name == "fatal") throw Failure(text.empty() ? "xacro.fatal()" : text);
  environment.message(name, text);
  return "";
}

}  // namespace

std::optional<Value> global_value(const std::string& name) {
  if (name == "math" || name == "python" || name == "xacro") return Module{name};
  if (kPython.contains(name)) return Function{name, nullptr};
  if (name == "load_yaml" || name == "abs_filename" || name == "dotify")
    return Function{"xacro." + name, nullptr};
  return module_value("math", name);
}

std::optional<Value> module_value(const std::string& module, const std::string& name) {
  if (module == "math") {
    if (const std::optional<double> constant = math_constant(name)) return *constant;
    if (is_math_function(name)) return Function{"math." + name, nullptr};
  }
  if (module == "python" && (kPython.contains(name) || name == "set" || name == "frozenset"))
    return Function{name, nullptr};
  if (module == "xacro" && kXacro.contains(name)) return Function{"xacro." + name, nullptr};
  return std::nullopt;
}

Value call_function(const Function& function, std::vector<Value> arguments,
                    const std::vector<std::string>& keywords, Environment& environment, Budget& budget) {
  budget.step();
  const std::string& name = function.name;
  if (function.self) {
    if (!keywords.empty()) refuse_python("an argument with a name in " + name + "()");
    return call_method(*function.self, name, arguments, budget);
  }
  if (name.starts_with("math.") || name.starts_with("xacro.")) {
    // xacro's messages take keyword arguments that only concern their output.
    if (!keywords.empty() && name.starts_with("xacro."))
      arguments.resize(arguments.size() - keywords.size());
    else if (!keywords.empty())
      refuse_python("an argument with a name in " + name + "()");
    return name.starts_with("math.") ? call_math(name.substr(5), arguments)
                                     : xacro_function(name.substr(6), arguments, environment, budget);
  }
  return python(name, std::move(arguments), keywords, environment, budget);
}

}  // namespace fire3dv::convert::xacro
