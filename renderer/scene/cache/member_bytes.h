// Binary serialisation of structure members. The reader validates untrusted input: lengths against the
// remaining bytes, flags as 0 or 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "base/digest.h"
#include "renderer/scene/model/scene_fields.h"

namespace fire3dv::scene {

template <typename T>
concept PlainMember = std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, glm::vec2> ||
    std::is_same_v<T, glm::vec3> || std::is_same_v<T, glm::vec4> || std::is_same_v<T, glm::mat4> ||
    std::is_same_v<T, glm::quat> || std::is_same_v<T, Digest>;

class MemberWriter {
 public:
  template <typename... T>
  void operator()(T&... members) {
    (write(members), ...);
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  template <PlainMember T>
  void write(const T& value) {
    const auto* first = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof(T));
  }
  void write(std::string& text) {
    write(uint64_t{text.size()});
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    bytes_.insert(bytes_.end(), first, first + text.size());
  }
  template <typename T>
  void write(std::vector<T>& elements) {
    write(uint64_t{elements.size()});
    for (T& element : elements) write(element);
  }
  template <typename T>
  requires(!PlainMember<T>) void write(T& structure) { visit_members(structure, *this); }

  std::vector<std::byte> bytes_;
};

class MemberReader {
 public:
  explicit MemberReader(std::span<const std::byte> bytes) : rest_(bytes) {}
  template <typename... T>
  void operator()(T&... members) {
    (read(members), ...);
  }
  // True after reading if the input was valid and is consumed.
  bool was_right() const { return right_ && rest_.empty(); }

 private:
  template <PlainMember T>
  void read(T& value) {
    if (!has(sizeof(T))) return;
    if constexpr (std::is_same_v<T, bool>) {
      const auto flag = static_cast<uint8_t>(rest_[0]);
      right_ = right_ && flag <= 1;
      value = flag == 1;
    } else {
      std::memcpy(static_cast<void*>(&value), rest_.data(), sizeof(T));
    }
    rest_ = rest_.subspan(sizeof(T));
  }
  void read(std::string& text) {
    uint64_t size = 0;
    read(size);
    if (!has(size)) return;
    text.assign(reinterpret_cast<const char*>(rest_.data()), size);
    rest_ = rest_.subspan(size);
  }
  template <typename T>
  void read(std::vector<T>& elements) {
    uint64_t count = 0;
    read(count);
    if (!has(count)) return;  // an element has at least one byte
    for (uint64_t i = 0; i < count && right_; ++i) read(elements.emplace_back());
  }
  template <typename T>
  requires(!PlainMember<T>) void read(T& structure) { visit_members(structure, *this); }
  bool has(uint64_t size) {
    right_ = right_ && size <= rest_.size();
    return right_;
  }

  std::span<const std::byte> rest_;
  bool right_ = true;
};

}  // namespace fire3dv::scene
