#include "protocol/import/messages/cdr.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace fire3dv::imported {
namespace {

constexpr size_t kEncapsulationBytes =
    4;  // representation identifier and options; alignment counts from here

// Reader of primitives, each aligned to its size. After a failure all reads fail.
class CdrReader {
 public:
  static Result<CdrReader> open(std::span<const std::byte> message) {
    if (message.size() < kEncapsulationBytes) return Error{"it is shorter than the header of CDR"};
    const auto kind = static_cast<uint8_t>(message[1]);
    if (message[0] != std::byte{0} || kind > 1)
      return Error{"its representation is no plain CDR, which ROS 2 writes"};
    return CdrReader(message.subspan(kEncapsulationBytes), kind == 1);
  }

  template <typename T>
  T number() {
    std::array<std::byte, sizeof(T)> bytes{};
    at_ += (sizeof(T) - at_ % sizeof(T)) % sizeof(T);
    if (!take(sizeof(T), bytes.data())) return T{};
    if (is_little_ != (std::endian::native == std::endian::little))
      for (size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
    return std::bit_cast<T>(bytes);
  }
  // With a terminating zero, which counts.
  std::string text() {
    const auto length = number<uint32_t>();
    if (has_failed_ || length > data_.size() - at_) {
      has_failed_ = true;
      return {};
    }
    std::string value(reinterpret_cast<const char*>(data_.data() + at_), length);
    at_ += length;
    if (!value.empty() && value.back() == '\0') value.pop_back();
    return value;
  }
  // Number of elements of a sequence, each of which takes at least so many bytes.
  uint32_t count(size_t least_bytes) {
    const auto value = number<uint32_t>();
    if (!has_failed_ && value > (data_.size() - at_) / least_bytes) has_failed_ = true;
    if (!has_failed_ && value > kMaxElements) has_failed_ = has_too_many_ = true;
    return has_failed_ ? 0 : value;
  }
  bool has_failed() const { return has_failed_; }
  bool has_too_many() const { return has_too_many_; }

 private:
  CdrReader(std::span<const std::byte> data, bool is_little) : data_(data), is_little_(is_little) {}

  bool take(size_t size, void* to) {
    if (has_failed_ || at_ > data_.size() || data_.size() - at_ < size) {
      has_failed_ = true;
      at_ = data_.size();
      return false;
    }
    std::memcpy(to, data_.data() + at_, size);
    at_ += size;
    return true;
  }

  std::span<const std::byte> data_;
  bool is_little_;
  size_t at_ = 0;
  bool has_failed_ = false, has_too_many_ = false;
};

Result<void> check_end(const CdrReader& reader) {
  if (reader.has_too_many()) return Error{"it has more than 65536 elements"};
  if (reader.has_failed()) return Error{"it ends before its last field"};
  return {};
}

int64_t read_stamp(CdrReader& reader) {
  const auto seconds = reader.number<int32_t>();
  return int64_t{seconds} * 1'000'000'000 + reader.number<uint32_t>();
}

TransformSample read_transform(CdrReader& reader) {
  TransformSample sample;
  sample.stamp_ns = read_stamp(reader);
  sample.parent = reader.text();
  sample.child = reader.text();
  for (double& number : sample.parent_from_child.translation) number = reader.number<double>();
  for (double& number : sample.parent_from_child.rotation) number = reader.number<double>();
  return sample;
}

}  // namespace

Result<void> decode_cdr_transforms(std::span<const std::byte> message, bool many,
                                   std::vector<TransformSample>& samples) {
  constexpr size_t kLeastTransformBytes = 8 + 4 + 4 + 7 * 8;
  Result<CdrReader> reader = CdrReader::open(message);
  if (!reader) return reader.error();
  const uint32_t count = many ? reader->count(kLeastTransformBytes) : 1;
  for (uint32_t i = 0; i < count && !reader->has_failed(); ++i) samples.push_back(read_transform(*reader));
  return check_end(*reader);
}

Result<void> decode_cdr_joint_state(std::span<const std::byte> message, JointState& state) {
  state = {};
  Result<CdrReader> reader = CdrReader::open(message);
  if (!reader) return reader.error();
  state.stamp_ns = read_stamp(*reader);
  (void)reader->text();  // frame of the header: has no meaning for joints
  state.names.resize(reader->count(4));
  for (std::string& name : state.names) name = reader->text();
  state.positions.resize(reader->count(8));
  for (double& position : state.positions) position = reader->number<double>();
  if (Result<void> whole = check_end(*reader); !whole) return whole;
  if (state.positions.empty() || state.positions.size() == state.names.size()) return {};
  return Error{"it has " + std::to_string(state.positions.size()) + " positions of " +
               std::to_string(state.names.size()) + " joints"};
}

}  // namespace fire3dv::imported
