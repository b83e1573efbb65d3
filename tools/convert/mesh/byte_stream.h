// Binary serialisation between processes of one program, in native byte order. Reads are bounds-checked: each
// get returns whether the data was complete.
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace fire3dv::convert {

class ByteWriter {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(&value, sizeof value);
  }
  template <typename T>
  void put_array(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(values.size());
    append(values.data(), values.size() * sizeof(T));
  }
  void put_string(const std::string& text) {
    put(text.size());
    append(text.data(), text.size());
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void append(const void* data, size_t size) {
    const auto* from = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), from, from + size);
  }
  std::vector<std::byte> bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <typename T>
  [[nodiscard]] bool get(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return copy(&value, sizeof value);
  }
  template <typename T>
  [[nodiscard]] bool get_array(std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    size_t count = 0;
    if (!get(count) || count > rest_.size() / sizeof(T)) return false;
    values.resize(count);
    return copy(values.data(), count * sizeof(T));
  }
  [[nodiscard]] bool get_string(std::string& text) {
    size_t size = 0;
    if (!get(size) || size > rest_.size()) return false;
    text.resize(size);
    return copy(text.data(), size);
  }
  bool at_end() const { return rest_.empty(); }

 private:
  bool copy(void* to, size_t size) {
    if (rest_.size() < size) return false;
    if (size > 0) std::memcpy(to, rest_.data(), size);
    rest_ = rest_.subspan(size);
    return true;
  }
  std::span<const std::byte> rest_;
};

}  // namespace fire3dv::convert
