#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>

#include "convert/xacro/expression/expression.h"
#include "convert/xacro/expression/functions.h"

namespace fire3dv::convert::xacro {
namespace {

constexpr const char* kOverflow = "an integer exceeds 64 bits";

int64_t floor_divide(int64_t a, int64_t b) {
  if (b == 0) throw Failure("division by zero");
  if (a == std::numeric_limits<int64_t>::min() && b == -1) throw Failure(kOverflow);
  return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0);
}

double float_modulo(double a, double b) {
  if (b == 0) throw Failure("modulo by zero");
  const double rest = std::fmod(a, b);
  return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}

Value integer_power(int64_t base, int64_t exponent) {
  if (exponent < 0) {
    if (base == 0) throw Failure("0 to a negative power");
    return std::pow(static_cast<double>(base), static_cast<double>(exponent));
  }
  int64_t result = 1;
  if (base == 0 || base == 1) return exponent == 0 ? int64_t{1} : base;
  if (base == -1) return exponent % 2 == 0 ? int64_t{1} : int64_t{-1};
  for (; exponent > 0; --exponent)  // at most 63 rounds
    if (__builtin_mul_overflow(result, base, &result)) throw Failure(kOverflow);
  return result;
}

Value integer_operator(const std::string& name, int64_t a, int64_t b) {
  int64_t result = 0;
  bool overflow = false;
  if (name == "+")
    overflow = __builtin_add_overflow(a, b, &result);
  else if (name == "-")
    overflow = __builtin_sub_overflow(a, b, &result);
  else if (name == "*")
    overflow = __builtin_mul_overflow(a, b, &result);
  else if (name == "//")
    return floor_divide(a, b);
  else if (name == "%") {
    if (b == -1) return int64_t{0};
    return a - floor_divide(a, b) * b;
  } else if (name == "**")
    return integer_power(a, b);
  else if (name == "|")
    return a | b;
  else if (name == "&")
    return a & b;
  else if (name == "^")
    return a ^ b;
  else if (name == "<<" || name == ">>") {
    if (b < 0) throw Failure("a shift by a negative count");
    if (name == ">>") return a >> std::min<int64_t>(b, 63);
    overflow = b > 62 || __builtin_mul_overflow(a, int64_t{1} << b, &result);
  }
  if (overflow) throw Failure(kOverflow);
  return result;
}

Value float_operator(const std::string& name, double a, double b) {
  if (name == "+") return a + b;
  if (name == "-") return a - b;
  if (name == "*") return a * b;
  if (name == "/") {
    if (b == 0) throw Failure("division by zero");
    return a / b;
  }
  if (name == "//") {
    if (b == 0) throw Failure("division by zero");
    return std::floor((a - float_modulo(a, b)) / b + 0.5);
  }
  if (name == "%") return float_modulo(a, b);
  if (name == "**") {
    if (a == 0 && b < 0) throw Failure("0 to a negative power");
    if (a < 0 && std::floor(b) != b && std::isfinite(b))
      throw Failure("a negative number to a broken power is complex");
    return std::pow(a, b);
  }
  throw Failure("the operator " + name + " needs integers");
}

Value repeated(const Value& what, int64_t count, Budget& budget) {
  const auto times = static_cast<size_t>(std::clamp<int64_t>(count, 0, int64_t{1} << 40));
  if (const std::string* text = what.as<std::string>()) {
    if (times > 0 && text->size() > Budget::kMaxBytes / times) budget.bytes(Budget::kMaxBytes + 1);
    budget.bytes(text->size() * times);
    budget.step(text->empty() ? 0 : times);
    std::string result;
    if (!text->empty())
      for (size_t i = 0; i < times; ++i) result += *text;
    return result;
  }
  const Sequence* sequence = what.sequence();
  if (times > 0 && sequence->items.size() > Budget::kMaxSteps / times) budget.step(Budget::kMaxSteps + 1);
  std::vector<Value> items;
  if (!sequence->items.empty()) {
    budget.bytes(sequence->items.size() * times * sizeof(Value));
    for (size_t i = 0; i < times; ++i)
      items.insert(items.end(), sequence->items.begin(), sequence->items.end());
  }
  return make_sequence(std::move(items), sequence->is_tuple, budget);
}

// Union, intersection, difference and symmetric difference.
Value set_operator(const std::string& name, const Sequence& a, const Sequence& b, Budget& budget) {
  std::set<std::string> in_a, in_b;
  for (const Value& item : a.items) in_a.insert(repr_of(item, budget));
  for (const Value& item : b.items) in_b.insert(repr_of(item, budget));
  std::vector<Value> items;
  for (const Value& item : a.items)
    if (name == "|" || in_b.contains(repr_of(item, budget)) == (name == "&")) items.push_back(item);
  for (const Value& item : b.items)
    if (name == "|" || (name == "^" && !in_a.contains(repr_of(item, budget)))) items.push_back(item);
  return make_set(items, budget);
}

class Evaluator {
 public:
  Evaluator(Environment& environment, Budget& budget) : environment_(environment), budget_(budget) {}

  Value value_of(const Expression& e) {
    budget_.step();
    switch (e.kind) {
      case Expression::Kind::constant:
        return e.constant;
      case Expression::Kind::name:
        return named(e.text);
      case Expression::Kind::attribute:
        return attribute(value_of(*e.children[0]), e.text);
      case Expression::Kind::call:
        return call(e);
      case Expression::Kind::index:
        return index(value_of(*e.children[0]), value_of(*e.children[1]));
      case Expression::Kind::slice:
        return slice(e);
      case Expression::Kind::unary:
        return unary(e.text, value_of(*e.children[0]));
      case Expression::Kind::binary: {
        const Value a = value_of(*e.children[0]);
        return apply_operator(e.text, a, value_of(*e.children[1]), budget_);
      }
      case Expression::Kind::comparison:
        return comparison(e);
      case Expression::Kind::logical_and:
      case Expression::Kind::logical_or: {
        Value value;
        for (const auto& child : e.children) {
          value = value_of(*child);
          if (is_true(value) == (e.kind == Expression::Kind::logical_or)) break;
        }
        return value;
      }
      case Expression::Kind::conditional:
        return value_of(*e.children[is_true(value_of(*e.children[1])) ? 0 : 2]);
      case Expression::Kind::sequence:
        break;
    }
    std::vector<Value> items;
    for (const auto& child : e.children) items.push_back(value_of(*child));
    return make_sequence(std::move(items), is_true(e.constant), budget_);
  }

 private:
  Value named(const std::string& name) {
    if (std::optional<Value> value = environment_.property(nullptr, name)) return std::move(*value);
    if (std::optional<Value> value = global_value(name)) return std::move(*value);
    throw Failure("the name " + name + " is not defined");
  }

  Value attribute(Value object, const std::string& name) {
    if (Scope* const* scope = object.as<Scope*>()) {
      if (std::optional<Value> value = environment_.property(*scope, name)) return std::move(*value);
      throw Failure("the namespace has no property " + name);
    }
    if (const Module* module = object.as<Module>()) {
      if (std::optional<Value> value = module_value(module->name, name)) return std::move(*value);
      refuse_python(module->name + "." + name);
    }
    if (is_method(object, name)) return Function{name, std::make_shared<const Value>(std::move(object))};
    if (const Dict* dict = object.dict()) {
      if (const Value* value = find(*dict, name, budget_)) return *value;
      throw Failure("the dict has no key " + name);
    }
    refuse_python("." + name + " of a " + type_name(object));
  }

  Value call(const Expression& e) {
    const Value function = value_of(*e.children[0]);
    if (!function.as<Function>())
      throw Failure(std::string("a ") + type_name(function) + " cannot be called");
    std::vector<Value> arguments;
    for (size_t i = 1; i < e.children.size(); ++i) arguments.push_back(value_of(*e.children[i]));
    return call_function(*function.as<Function>(), std::move(arguments), e.keywords, environment_, budget_);
  }

  size_t position(const Value& at, size_t size) {
    int64_t i = integer(at, "an index");
    const auto count = static_cast<int64_t>(size);
    if (i < 0) i += count;
    if (i < 0 || i >= count)
      throw Failure("the index " + std::to_string(integer(at, "an index")) + " is beyond the " +
                    std::to_string(size) + " items");
    return static_cast<size_t>(i);
  }

  Value index(const Value& object, const Value& at) {
    if (const Dict* dict = object.dict()) {
      if (const Value* value = find(*dict, at, budget_)) return *value;
      throw Failure("the dict has no key " + repr_of(at, budget_));
    }
    if (const Sequence* sequence = object.sequence(); sequence && !sequence->is_set)
      return sequence->items[position(at, sequence->items.size())];
    if (const std::string* text = object.as<std::string>())
      return std::string(1, (*text)[position(at, text->size())]);
    throw Failure(std::string("a ") + type_name(object) + " has no items");
  }

  Value slice(const Expression& e) {
    const Value object = value_of(*e.children[0]);
    const std::string* text = object.as<std::string>();
    const Sequence* sequence = object.sequence();
    if (sequence && sequence->is_set) sequence = nullptr;
    if (!text && !sequence) throw Failure(std::string("a ") + type_name(object) + " has no items");
    const auto size = static_cast<int64_t>(text ? text->size() : sequence->items.size());
    const auto bound = [&](size_t child, int64_t otherwise) {
      if (!e.children[child]) return otherwise;
      const Value value = value_of(*e.children[child]);
      return value.is_none() ? otherwise : integer(value, "a slice");
    };
    const int64_t step = bound(3, 1);
    if (step == 0) throw Failure("a slice with the step 0");
    const int64_t lowest = step > 0 ? 0 : -1, highest = step > 0 ? size : size - 1;
    const auto clamped = [&](int64_t i) { return std::clamp(i < 0 ? i + size : i, lowest, highest); };
    const int64_t first = e.children[1] ? clamped(bound(1, 0)) : (step > 0 ? 0 : size - 1);
    const int64_t last = e.children[2] ? clamped(bound(2, size)) : (step > 0 ? size : -1);
    std::string part;
    std::vector<Value> items;
    for (int64_t i = first; step > 0 ? i < last : i > last;) {
      budget_.step();
      if (text)
        part += (*text)[static_cast<size_t>(i)];
      else
        items.push_back(sequence->items[static_cast<size_t>(i)]);
      if (__builtin_add_overflow(i, step, &i)) break;
    }
    return text ? Value(std::move(part)) : make_sequence(std::move(items), sequence->is_tuple, budget_);
  }

  Value unary(const std::string& name, const Value& value) {
    if (name == "not") return !is_true(value);
    if (const double* real = value.as<double>()) {
      if (name != "~") return name == "-" ? -*real : *real;
    } else if (value.is_integer()) {
      const int64_t whole = integer(value, name);
      if (name == "~") return ~whole;
      return name == "-" ? integer_operator("-", 0, whole) : Value(whole);
    }
    throw Failure(std::string("a ") + type_name(value) + " has no operator " + name);
  }

  bool contains(const Value& container, const Value& item) {
    if (const std::string* text = container.as<std::string>()) {
      if (const std::string* part = item.as<std::string>()) {
        budget_.step(1 + text->size() / 64);
        return text->find(*part) != std::string::npos;
      }
      throw Failure("'in' of a str needs a str before it");
    }
    if (const Dict* dict = container.dict()) return find(*dict, item, budget_) != nullptr;
    if (const Sequence* sequence = container.sequence())
      return std::any_of(sequence->items.begin(), sequence->items.end(),
                         [&](const Value& other) { return equal(item, other, budget_); });
    throw Failure(std::string("a ") + type_name(container) + " contains nothing");
  }

  bool holds(const std::string& name, const Value& a, const Value& b) {
    if (name == "==") return equal(a, b, budget_);
    if (name == "!=") return !equal(a, b, budget_);
    if (name == "in") return contains(b, a);
    if (name == "not in") return !contains(b, a);
    if (name == "is" || name == "is not")
      return (a.data.index() == b.data.index() && equal(a, b, budget_)) == (name == "is");
    const std::partial_ordering order = compare(a, b, budget_);
    if (name == "<") return order < 0;
    if (name == ">") return order > 0;
    if (name == "<=") return order <= 0;
    return order >= 0;
  }

  Value comparison(const Expression& e) {
    Value left = value_of(*e.children[0]);
    for (size_t i = 0; i < e.keywords.size(); ++i) {
      Value right = value_of(*e.children[i + 1]);
      if (!holds(e.keywords[i], left, right)) return false;
      left = std::move(right);
    }
    return true;
  }

  Environment& environment_;
  Budget& budget_;
};

}  // namespace

Value apply_operator(const std::string& name, const Value& a, const Value& b, Budget& budget) {
  if (a.is_number() && b.is_number()) {
    if (name != "/" && a.is_integer() && b.is_integer()) {
      const bool flags = a.as<bool>() && b.as<bool>();
      const Value result = integer_operator(name, integer(a, name), integer(b, name));
      return flags && (name == "&" || name == "|" || name == "^") ? Value(is_true(result)) : result;
    }
    return float_operator(name, number(a, name), number(b, name));
  }
  if (name == "%" && a.as<std::string>()) return formatted(*a.as<std::string>(), b, budget);
  if (name == "+" && a.as<std::string>() && b.as<std::string>()) {
    budget.bytes(a.as<std::string>()->size() + b.as<std::string>()->size());
    return *a.as<std::string>() + *b.as<std::string>();
  }
  const Sequence *x = a.sequence(), *y = b.sequence();
  const bool has_set = (x && x->is_set) || (y && y->is_set);
  if (x && y && x->is_set && y->is_set && (name == "|" || name == "&" || name == "-" || name == "^"))
    return set_operator(name, *x, *y, budget);
  if (name == "+" && x && y && !has_set && x->is_tuple == y->is_tuple) {
    std::vector<Value> items = x->items;
    items.insert(items.end(), y->items.begin(), y->items.end());
    return make_sequence(std::move(items), x->is_tuple, budget);
  }
  if (name == "*" && b.is_integer() && !has_set && (x || a.as<std::string>()))
    return repeated(a, integer(b, name), budget);
  if (name == "*" && a.is_integer() && !has_set && (y || b.as<std::string>()))
    return repeated(b, integer(a, name), budget);
  throw Failure("a " + std::string(type_name(a)) + " and a " + type_name(b) + " have no operator " + name +
                (name == "+" ? ": convert with str() or float()" : ""));
}

Value evaluate(const Expression& expression, Environment& environment, Budget& budget) {
  return Evaluator(environment, budget).value_of(expression);
}

}  // namespace fire3dv::convert::xacro
