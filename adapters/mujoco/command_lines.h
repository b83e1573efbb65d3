// What is typed while a simulation runs, a word a line. Never waits for it, and does without: where there is
// no standard input, where it ends, and where the terminal belongs to another program.
#pragma once

#include <optional>
#include <string>

namespace fire3dv::mujoco {

class CommandLines {
 public:
  CommandLines();
  // The next whole line that has come.
  std::optional<std::string> next();

 private:
  std::string text_;
  bool is_over_ = false;
};

}  // namespace fire3dv::mujoco
