// Non-blocking reader of command lines on standard input. Returns no lines without standard input, after its
// end, and while the program is a background job.
#pragma once

#include <optional>
#include <string>

namespace fire3dv::mujoco {

class CommandLines {
 public:
  CommandLines();
  // Returns the next complete line, if one has arrived.
  std::optional<std::string> next();

 private:
  std::string text_;
  bool is_over_ = false;
};

}  // namespace fire3dv::mujoco
