#include "protocol/import/messages/foxglove.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/json/json_fault.h"

namespace fire3dv::imported {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;
constexpr const char* kTooMany = "it has more than 65536 elements";

// Fields of one message of Protocol Buffers: number, and value or bytes.
class ProtobufFields {
 public:
  explicit ProtobufFields(std::span<const std::byte> bytes) : rest_(bytes) {}

  struct Field {
    uint64_t number = 0;
    uint64_t value = 0;                     // varint, fixed64, fixed32
    std::span<const std::byte> bytes = {};  // length-delimited
    bool is_bytes = false;
    double as_double() const { return std::bit_cast<double>(value); }
    std::string text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
  };
  // Nothing at the end, and after a damaged field.
  std::optional<Field> next() {
    uint64_t key = 0;
    if (rest_.empty() || !varint(key)) return std::nullopt;
    Field field{.number = key >> 3};
    bool is_good = true;
    switch (key & 7) {
      case 0:
        is_good = varint(field.value);
        break;
      case 1:
        is_good = fixed(8, field.value);
        break;
      case 2: {
        uint64_t length = 0;
        is_good = varint(length) && length <= rest_.size();
        if (!is_good) break;
        field.is_bytes = true;
        field.bytes = rest_.first(static_cast<size_t>(length));
        rest_ = rest_.subspan(static_cast<size_t>(length));
        break;
      }
      case 5:
        is_good = fixed(4, field.value);
        break;
      default:
        is_good = false;
    }
    if (is_good) return field;
    is_damaged_ = true;
    return std::nullopt;
  }
  bool is_damaged() const { return is_damaged_; }

 private:
  bool varint(uint64_t& value) {
    value = 0;
    for (size_t i = 0; i < rest_.size() && i < 10; ++i) {
      const auto byte = static_cast<uint64_t>(rest_[i]);
      value |= (byte & 0x7F) << (7 * i);
      if (byte >= 0x80) continue;
      rest_ = rest_.subspan(i + 1);
      return true;
    }
    is_damaged_ = true;
    return false;
  }
  bool fixed(size_t size, uint64_t& value) {
    if (rest_.size() < size) return false;
    value = 0;
    for (size_t i = 0; i < size; ++i) value |= static_cast<uint64_t>(rest_[i]) << (8 * i);
    rest_ = rest_.subspan(size);
    return true;
  }

  std::span<const std::byte> rest_;
  bool is_damaged_ = false;
};

// Numbers of fields 1 to N; those that are absent are 0, as Protocol Buffers have it.
template <size_t N>
bool read_doubles(std::span<const std::byte> bytes, std::array<double, N>& numbers) {
  ProtobufFields fields(bytes);
  numbers.fill(0);
  while (const auto field = fields.next())
    if (field->number >= 1 && field->number <= N && !field->is_bytes)
      numbers[field->number - 1] = field->as_double();
  return !fields.is_damaged();
}

bool read_timestamp(std::span<const std::byte> bytes, int64_t& stamp_ns) {
  ProtobufFields fields(bytes);
  int64_t seconds = 0, nanoseconds = 0;
  while (const auto field = fields.next()) {
    if (field->number == 1) seconds = static_cast<int64_t>(field->value);
    if (field->number == 2) nanoseconds = static_cast<int64_t>(field->value);
  }
  constexpr int64_t kMaxSeconds = std::numeric_limits<int64_t>::max() / kSecondNs - 1;
  if (seconds < -kMaxSeconds || seconds > kMaxSeconds || nanoseconds < 0 || nanoseconds >= kSecondNs)
    return false;
  stamp_ns = seconds * kSecondNs + nanoseconds;
  return !fields.is_damaged();
}

Result<TransformSample> read_transform(std::span<const std::byte> bytes) {
  TransformSample sample;
  sample.parent_from_child.rotation = {};  // absent: of length 0, which is refused
  ProtobufFields fields(bytes);
  bool is_good = true;
  while (const auto field = fields.next()) {
    if (!field->is_bytes) continue;
    if (field->number == 1) is_good = is_good && read_timestamp(field->bytes, sample.stamp_ns);
    if (field->number == 2) sample.parent = field->text();
    if (field->number == 3) sample.child = field->text();
    if (field->number == 4)
      is_good = is_good && read_doubles(field->bytes, sample.parent_from_child.translation);
    if (field->number == 5)
      is_good = is_good && read_doubles(field->bytes, sample.parent_from_child.rotation);
  }
  if (!is_good || fields.is_damaged()) return Error{"it is no foxglove.FrameTransform in protobuf"};
  return sample;
}

using Json = nlohmann::json;

template <size_t N>
std::array<double, N> numbers_of(const Json& object, const std::array<const char*, N>& names) {
  std::array<double, N> numbers{};
  for (size_t i = 0; i < N; ++i) numbers[i] = object.at(names[i]).template get<double>();
  return numbers;
}

TransformSample json_transform(const Json& value) {
  TransformSample sample;
  const Json& time = value.at("timestamp");
  const double seconds = time.at("sec").get<double>(), nanoseconds = time.at("nsec").get<double>();
  if (!(std::abs(seconds) < 9e9 && nanoseconds >= 0 && nanoseconds < 1e9))
    throw std::runtime_error("its timestamp is no time");
  sample.stamp_ns = static_cast<int64_t>(seconds) * kSecondNs + static_cast<int64_t>(nanoseconds);
  sample.parent = value.at("parent_frame_id").get<std::string>();
  sample.child = value.at("child_frame_id").get<std::string>();
  sample.parent_from_child.translation = numbers_of<3>(value.at("translation"), {"x", "y", "z"});
  sample.parent_from_child.rotation = numbers_of<4>(value.at("rotation"), {"x", "y", "z", "w"});
  return sample;
}

}  // namespace

Result<void> decode_protobuf_transforms(std::span<const std::byte> message, bool many,
                                        std::vector<TransformSample>& samples) {
  const auto add = [&](std::span<const std::byte> bytes) -> Result<void> {
    Result<TransformSample> sample = read_transform(bytes);
    if (!sample) return sample.error();
    samples.push_back(std::move(*sample));
    return {};
  };
  if (!many) return add(message);
  ProtobufFields fields(message);
  while (const auto field = fields.next()) {
    if (field->number != 1 || !field->is_bytes) continue;
    if (samples.size() == kMaxElements) return Error{kTooMany};
    if (Result<void> added = add(field->bytes); !added) return added;
  }
  if (fields.is_damaged()) return Error{"it is no foxglove.FrameTransforms in protobuf"};
  return {};
}

Result<void> decode_json_transforms(std::span<const std::byte> message, bool many,
                                    std::vector<TransformSample>& samples) {
  // Deeper values than those of the schema are damage: the parser would recurse.
  constexpr int kMaxDepth = 16;
  constexpr size_t kMaxEvents = 48 * kMaxElements;  // a transform has 33: its names, values and braces
  size_t events = 0;
  try {
    const auto* const text = reinterpret_cast<const char*>(message.data());
    const Json value =
        Json::parse(text, text + message.size(), [&events](int depth, Json::parse_event_t, const Json&) {
          if (depth > kMaxDepth) throw std::runtime_error("it is nested too deeply");
          if (++events > kMaxEvents) throw std::runtime_error(kTooMany);
          return true;
        });
    if (!many) {
      samples.push_back(json_transform(value));
      return {};
    }
    const Json& transforms = value.at("transforms");
    if (transforms.size() > kMaxElements) return Error{kTooMany};
    for (const Json& each : transforms) samples.push_back(json_transform(each));
    return {};
  } catch (const std::exception& fault) {
    return Error{json_fault(fault.what())};
  }
}

}  // namespace fire3dv::imported
