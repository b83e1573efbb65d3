#include "convert/xacro/expression/math_functions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "convert/xacro/expression/budget.h"

namespace fire3dv::convert::xacro {
namespace {

const std::map<std::string, double (*)(double)> kUnaryMath = {
    {"sin", std::sin},
    {"cos", std::cos},
    {"tan", std::tan},
    {"asin", std::asin},
    {"acos", std::acos},
    {"atan", std::atan},
    {"sinh", std::sinh},
    {"cosh", std::cosh},
    {"tanh", std::tanh},
    {"sqrt", std::sqrt},
    {"exp", std::exp},
    {"log10", std::log10},
    {"log2", std::log2},
    {"fabs", std::fabs},
    {"cbrt", std::cbrt},
    {"asinh", std::asinh},
    {"acosh", std::acosh},
    {"atanh", std::atanh},
    {"degrees", [](double x) { return x * (180 / std::numbers::pi); }},
    {"radians", [](double x) { return x * (std::numbers::pi / 180); }}};
const std::map<std::string, double (*)(double, double)> kBinaryMath = {
    {"atan2", std::atan2}, {"pow", std::pow}, {"fmod", std::fmod}, {"copysign", std::copysign}};
const std::set<std::string> kOtherMath = {"floor", "ceil",  "trunc", "log",
                                          "hypot", "isnan", "isinf", "isfinite"};
const std::map<std::string, double> kConstants = {{"pi", std::numbers::pi},
                                                  {"tau", 2 * std::numbers::pi},
                                                  {"e", std::numbers::e},
                                                  {"inf", std::numeric_limits<double>::infinity()},
                                                  {"nan", std::numeric_limits<double>::quiet_NaN()}};

}  // namespace

bool is_math_function(const std::string& name) {
  return kUnaryMath.contains(name) || kBinaryMath.contains(name) || kOtherMath.contains(name);
}

std::optional<double> math_constant(const std::string& name) {
  const auto known = kConstants.find(name);
  return known == kConstants.end() ? std::nullopt : std::optional(known->second);
}

void expect_count(const std::vector<Value>& arguments, size_t fewest, size_t most, const std::string& name) {
  if (arguments.size() < fewest || arguments.size() > most)
    throw Failure(name + "() takes " + std::to_string(fewest) +
                  (most == fewest ? "" : " to " + std::to_string(most)) + " arguments, not " +
                  std::to_string(arguments.size()));
}

Value whole_number(double value, const std::string& name) {
  constexpr double kLimit = 9.2e18;
  if (!(std::abs(value) < kLimit)) throw Failure(name + "() gives no integer of 64 bits");
  return static_cast<int64_t>(value);
}

Value call_math(const std::string& name, const std::vector<Value>& arguments) {
  std::vector<double> x;
  for (const Value& argument : arguments) x.push_back(number(argument, name + "()"));
  double result = 0;
  if (const auto one = kUnaryMath.find(name); one != kUnaryMath.end()) {
    expect_count(arguments, 1, 1, name);
    result = one->second(x[0]);
  } else if (const auto two = kBinaryMath.find(name); two != kBinaryMath.end()) {
    expect_count(arguments, 2, 2, name);
    result = two->second(x[0], x[1]);
  } else if (name == "hypot") {
    for (const double side : x) result = std::hypot(result, side);
  } else if (name == "log") {
    expect_count(arguments, 1, 2, name);
    result = x.size() == 2 ? std::log(x[0]) / std::log(x[1]) : std::log(x[0]);
  } else {
    expect_count(arguments, 1, 1, name);
    if (name == "isnan") return std::isnan(x[0]);
    if (name == "isinf") return std::isinf(x[0]);
    if (name == "isfinite") return std::isfinite(x[0]);
    if (arguments[0].is_integer()) return integer(arguments[0], name);
    return whole_number(name == "floor"  ? std::floor(x[0])
                        : name == "ceil" ? std::ceil(x[0])
                                         : std::trunc(x[0]),
                        name);
  }
  const bool finite = std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
  if (finite && !std::isfinite(result)) throw Failure(name + "() is not defined for this number");
  return result;
}

}  // namespace fire3dv::convert::xacro
