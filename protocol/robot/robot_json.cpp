#include "protocol/robot/robot_json.h"

#include <cmath>
#include <utility>
#include <vector>

#include "base/json/json_fault.h"
#include "protocol/wire/check.h"

namespace fire3dv::robot {
namespace {

constexpr size_t kMaxValues = 8'000'000, kMaxDepth = 64, kMaxNameBytes = 1024;
constexpr double kMaxNumber = 1e12;

// Builds the wanted part of a document. nlohmann's own filter takes quadratic time.
class Builder : public nlohmann::json_sax<Json> {
 public:
  explicit Builder(const char* wanted) : wanted_(wanted) {}

  Json take() { return std::move(document_); }

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t&) override { return false; }  // not in JSON
  bool start_object(size_t) override { return open(Json::object()); }
  bool start_array(size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    key_ = std::move(name);
    return true;
  }
  bool parse_error(size_t, const std::string&, const nlohmann::detail::exception& fault) override {
    throw Fault("its JSON is invalid: " + wire::printable(json_fault(fault.what()), 200));
  }

 private:
  // Containers that are not stored are null.
  Json* put(Json&& value) {
    if (++values_ > kMaxValues)
      throw Fault("its JSON has more than " + std::to_string(kMaxValues) + " values");
    if (open_.empty()) return &(document_ = std::move(value));
    Json* const parent = open_.back();
    if (!parent) return nullptr;
    if (parent->is_array()) {
      if (open_.size() == 1) return nullptr;
      parent->push_back(std::move(value));
      return &parent->back();
    }
    if (open_.size() == 1 && key_ != wanted_) return nullptr;
    return &((*parent)[key_] = std::move(value));
  }
  bool add(Json&& value) {
    put(std::move(value));
    return true;
  }
  bool open(Json&& container) {
    if (open_.size() == kMaxDepth)
      throw Fault("its JSON is nested more than " + std::to_string(kMaxDepth) + " deep");
    open_.push_back(put(std::move(container)));
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  const std::string wanted_;
  Json document_;
  std::vector<Json*> open_;
  std::string key_;
  size_t values_ = 0;
};

}  // namespace

std::string in_quotes(const std::string& name) {
  return "\"" + wire::printable(name) + "\"";
}

Json parse_json(std::span<const std::byte> text, const char* wanted) {
  Builder builder(wanted);
  const char* const begin = reinterpret_cast<const char*>(text.data());
  Json::sax_parse(begin, begin + text.size(), &builder);
  return builder.take();
}

const Json* member(const Json& object, const char* name) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

double number_of(const Json& value, const std::string& json_path) {
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!std::isfinite(number) || std::abs(number) > kMaxNumber)
    throw Fault(json_path + " is not a number of at most 1e12");
  return number;
}

double number_of(const Json& object, const char* name, double otherwise, const std::string& json_path) {
  const Json* const value = member(object, name);
  return value ? number_of(*value, json_path + "." + name) : otherwise;
}

const std::string& text_of(const Json& object, const char* name, const std::string& json_path) {
  const Json* const value = member(object, name);
  if (!value || !value->is_string()) throw Fault(json_path + "." + name + " is not text");
  const std::string& text = value->get_ref<const std::string&>();
  if (const Result<void> good = wire::check_text(json_path + "." + name, text, kMaxNameBytes); !good)
    throw Fault(good.error().message);
  return text;
}

Transform rigid_of(const Json& object, const std::string& json_path) {
  Quaternion q = numbers_of<4>(object, "rotation", json_path).value_or(Quaternion{0, 0, 0, 1});
  const double size = length(q);
  if (!(size > 1e-9)) throw Fault(json_path + ".rotation has no length");
  for (double& number : q) number /= size;
  return translation(numbers_of<3>(object, "translation", json_path).value_or(Vector{0, 0, 0})) * rotation(q);
}

}  // namespace fire3dv::robot
