// tf2::BufferCore of ROS 1 behind an interface without its types: its headers need C++17 or older.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace fire3dv::ros2 {

class Tf2Oracle {
 public:
  struct Result {
    int64_t stamp_ns;
    std::array<double, 3> translation;
    std::array<double, 4> rotation;  // x y z w
  };

  Tf2Oracle();
  ~Tf2Oracle();
  Tf2Oracle(const Tf2Oracle&) = delete;
  Tf2Oracle& operator=(const Tf2Oracle&) = delete;

  // True: taken.
  bool set(const std::string& parent, const std::string& child, int64_t stamp_ns,
           const std::array<double, 3>& translation, const std::array<double, 4>& rotation, bool is_static);
  // stamp_ns 0: newest common time. Nothing: tf2 throws.
  std::optional<Result> look_up(const std::string& target, const std::string& source, int64_t stamp_ns) const;

 private:
  struct Buffer;
  std::unique_ptr<Buffer> buffer_;
};

}  // namespace fire3dv::ros2
