// Pixels of an image, shared by copies: a copy costs nothing, and its identity tells whoever keeps something
// made of the pixels that they are the same. Safe to read and copy on several threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace fire3dv::scene {

class Pixels {
 public:
  Pixels() = default;
  Pixels(std::vector<uint8_t> bytes) : bytes_(std::make_shared<std::vector<uint8_t>>(std::move(bytes))) {}

  size_t size() const { return bytes_ ? bytes_->size() : 0; }
  bool empty() const { return size() == 0; }
  const uint8_t* data() const { return bytes_ ? bytes_->data() : nullptr; }
  const uint8_t* begin() const { return data(); }
  const uint8_t* end() const { return data() + size(); }
  uint8_t operator[](size_t i) const { return data()[i]; }
  bool operator==(const Pixels& other) const {
    return bytes_ == other.bytes_ || (size() == other.size() && std::equal(begin(), end(), other.begin()));
  }

  // To be changed: copies keep what they have.
  std::vector<uint8_t>& edit() {
    if (!bytes_ || bytes_.use_count() > 1) bytes_ = std::make_shared<std::vector<uint8_t>>(begin(), end());
    return *bytes_;
  }
  // As they are stored, whoever shares them: for lists of members, of which writers of files change nothing
  // and readers fill new ones.
  std::vector<uint8_t>& stored() {
    if (!bytes_) bytes_ = std::make_shared<std::vector<uint8_t>>();
    return *bytes_;
  }
  // The same for copies alone. Null: there are no pixels.
  std::shared_ptr<const void> identity() const { return bytes_; }

 private:
  std::shared_ptr<std::vector<uint8_t>> bytes_;
};

}  // namespace fire3dv::scene
